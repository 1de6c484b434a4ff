//! Image files are read and written on a thread of their own: codecs take more stack than an application's thread may have,
//! and what they compute must not depend on its floating-point environment.

use super::flight::FrameFailure;
use super::local::Local;
use crate::frame::{self, ImageFileError, LoadedImage};
use crate::quiet;
use crate::threads::aside;
use std::path::Path;

/// See [`frame::read_image`].
///
/// # Errors
/// The file cannot be read, or no thread be started.
pub fn read_image(path: &Path, max_side: u32) -> Result<LoadedImage, ImageFileError> {
    on_its_thread(path, || frame::read_image(path, max_side))
}

impl Local {
    /// Writes the last frame, see [`frame::write_image`].
    ///
    /// # Errors
    /// The outer one as [`Local::finish_frame`], the inner one for the file.
    pub fn write_image(
        &mut self,
        path: &Path,
        srgb: bool,
        quality: u8,
    ) -> Result<Result<(), ImageFileError>, FrameFailure> {
        let picture = self.framebuffer()?;
        Ok(on_its_thread(path, || frame::write_image(path, picture, srgb, quality)))
    }
}

fn on_its_thread<T: Send>(
    path: &Path,
    work: impl FnOnce() -> Result<T, ImageFileError> + Send,
) -> Result<T, ImageFileError> {
    match aside(|| quiet::caught(work)) {
        Ok(Ok(Ok(outcome))) => outcome,
        // A panic of a codec is an error of the file; the context has no part in it.
        Ok(Ok(Err(panic))) => {
            Err(ImageFileError::Codec { path: path.into(), cause: format!("the codec of this format {panic}").into() })
        }
        Ok(Err(payload)) => std::panic::resume_unwind(payload),
        Err(error) if error.is_out_of_memory() => Err(ImageFileError::OutOfMemory { path: path.into() }),
        Err(cause) => Err(ImageFileError::Io { path: path.into(), cause: std::io::Error::other(cause) }),
    }
}
