//! Frames: started, waited for, read back.
//!
//! A frame sees the scene as it is when it starts. While it renders, the application may assemble the next one; nothing
//! that it does then shows before that one starts.

use super::context::Context;
use super::error::{Error, ErrorCode, Result};
use crate::backend::{FrameFailure, OnDone};
use crate::frame::{FrameStats, PixelFormat, encode_pixels};
use crate::memory::copy_into;
use crate::scene::FrameDesc;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Called when a frame has ended, on a worker thread and with no lock held. `end_rendering` returns after the callback has.
pub type FrameCallback = Arc<dyn Fn(&Result<FrameStats>) + Send + Sync>;

/// Stops the frame in flight from any thread.
#[derive(Clone, Debug)]
pub struct CancelHandle(Arc<AtomicBool>);

impl CancelHandle {
    /// Tiles that have not begun keep what they showed before. Without a frame in flight this does nothing.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// What [`Context::read_pixels`] reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PixelKind {
    /// In any format; 8-bit values are encoded with the sRGB curve when that capability is on.
    Color(PixelFormat),
    /// `f32`: distance from the camera in units of the ray's direction; infinite where nothing was hit.
    Depth,
    /// Three `f32`: unit normal in world space; 0 where nothing was hit.
    Normal,
    /// `u32`: name of the object; 0 where nothing was hit.
    ObjectId,
    /// `u32`: number of the instance in the frame; `u32::MAX` where nothing was hit.
    InstanceId,
}

impl PixelKind {
    pub fn bytes_per_pixel(self) -> usize {
        match self {
            PixelKind::Color(format) => format.bytes_per_pixel(),
            PixelKind::Normal => 12,
            _ => 4,
        }
    }
}

impl Context {
    /// Renders the frame that was assembled and waits for it; or, if a frame was started, only waits for that one.
    ///
    /// # Errors
    /// As [`Context::start_rendering`] and [`Context::end_rendering`].
    pub fn render(&mut self) -> Result<FrameStats> {
        self.outside_object()?;
        if !self.rendering {
            self.start_rendering()?;
        }
        self.end_rendering()
    }

    /// The end of a frame in OpenRT's order of calls: same as [`Context::render`]; what follows belongs to the next frame.
    ///
    /// # Errors
    /// As [`Context::render`].
    pub fn swap_buffers(&mut self) -> Result<FrameStats> {
        self.render()
    }

    /// Freezes the scene and all shader parameters, starts rendering, and begins a new frame without instances.
    ///
    /// # Errors
    /// `InvalidOperation` between begin and end, inside an object, while a frame is rendering, without a framebuffer, or when the viewport
    /// reaches beyond it; `OutOfMemory`.
    pub fn start_rendering(&mut self) -> Result<()> {
        self.outside_object()?;
        if self.rendering {
            return Err(Error::invalid_operation("a frame is rendering already; it must be ended first"));
        }
        let viewport = self.target.viewport()?;
        let ready = self.backend.ready();
        self.trust(ready)?;
        self.reserve_content()?;
        let mut frame = self.send_changes()?;
        frame.viewport = viewport;
        // Room for the immediate-mode object, taken by the changes perhaps, and for the deletions.
        self.reserve_content()?;
        // The last thing that can fail.
        let prepared = self.backend.prepare(1);
        self.trust(prepared)?;
        let mesh = std::mem::take(&mut self.builder).into_mesh();
        let with_immediate = self.send_immediate_object(mesh);
        frame.instances = self.take_instances(with_immediate, std::mem::take(&mut frame.instances));
        let mut target = self.target.target().cloned();
        if let Some(target) = &mut target {
            target.layout.origin_top_left |= self.settings.origin_top_left;
        }
        let started = self.backend.start_frame(frame, target, self.settings.on_frame_done.clone());
        self.trust(started)?;
        self.rendering = true;
        self.frames += 1;
        self.content.lights_are_old = true;
        self.send_deletions();
        Ok(())
    }

    /// Waits for the frame that was started; then its pixels are in the framebuffer, and its completion callback has returned.
    ///
    /// # Errors
    /// `InvalidOperation` when none was started; `OutOfMemory`; `InternalError` when it met a defect.
    pub fn end_rendering(&mut self) -> Result<FrameStats> {
        self.outside_object()?;
        if !self.rendering {
            return Err(Error::invalid_operation("no frame was started"));
        }
        self.rendering = false;
        let outcome = self.backend.finish_frame();
        self.stats = self.trust(outcome)?;
        Ok(self.stats)
    }

    /// Whether the frame that was started is finished; true when none was.
    ///
    /// # Errors
    /// `InvalidOperation` between begin and end.
    pub fn is_frame_done(&self) -> Result<bool> {
        self.outside_begin()?;
        Ok(self.backend.is_frame_done())
    }

    /// Waits up to `timeout` for the frame that was started, its callback included; whether it has ended. It still wants [`Context::end_rendering`].
    ///
    /// # Errors
    /// `InvalidOperation` between begin and end.
    pub fn wait_frame(&self, timeout: Duration) -> Result<bool> {
        self.outside_begin()?;
        Ok(self.backend.wait_frame(timeout))
    }

    /// Stops the frame in flight early: tiles that have not begun keep what they showed before. Its statistics say `cancelled`.
    ///
    /// # Errors
    /// `InvalidOperation` between begin and end.
    pub fn cancel(&mut self) -> Result<()> {
        self.outside_begin()?;
        self.cancel_handle().cancel();
        Ok(())
    }

    /// A handle with which other threads can cancel the frames of this context.
    pub fn cancel_handle(&self) -> CancelHandle {
        CancelHandle(self.backend.cancel_flag().clone())
    }

    /// Calls `callback` at the end of every frame started from now on; None stops that.
    ///
    /// # Errors
    /// `InvalidOperation` between begin and end.
    pub fn frame_callback(&mut self, callback: Option<FrameCallback>) -> Result<()> {
        self.outside_begin()?;
        self.settings.on_frame_done = callback
            .map(|callback| -> OnDone { Arc::new(move |outcome| callback(&outcome.clone().map_err(error_of))) });
        Ok(())
    }

    /// What the last finished frame, or commit, cost.
    ///
    /// # Errors
    /// `InvalidOperation` between begin and end.
    pub fn get_frame_stats(&self) -> Result<FrameStats> {
        self.outside_begin()?;
        Ok(self.stats)
    }

    /// Brings all structures up to date with the scene and the instances placed so far, without rendering and without beginning
    /// a new frame; queries then see them. Waits for a frame in flight.
    ///
    /// # Errors
    /// `InvalidOperation` between begin and end or inside an object; `OutOfMemory`.
    pub fn commit_scene(&mut self) -> Result<FrameStats> {
        self.outside_object()?;
        self.reserve_content()?;
        let mesh = self.builder.try_copy()?;
        let with_immediate = !mesh.triangles.is_empty();
        let mut frame = self.send_changes()?;
        self.copy_instances(&mut frame.instances, with_immediate)?;
        frame.viewport = self.target.viewport().unwrap_or(frame.viewport);
        self.reserve_content()?;
        self.send_immediate_object(mesh);
        let outcome = self.backend.commit(frame);
        self.stats = self.trust(outcome)?;
        Ok(self.stats)
    }

    /// Copies the rectangle at `x`, `y` of the last frame to `out`, row by row, `stride` bytes apart (0: without a gap). Row 0 is the
    /// lowest, or the topmost with that capability on. Waits for a frame in flight.
    ///
    /// # Errors
    /// `InvalidOperation` when nothing was rendered yet; `InvalidValue` when the rectangle reaches beyond the picture, the stride is shorter
    /// than a row, or `out` is too short.
    #[expect(clippy::too_many_arguments, reason = "a rectangle, as in OpenGL")]
    pub fn read_pixels(
        &mut self,
        x: u32,
        y: u32,
        width: u32,
        height: u32,
        kind: PixelKind,
        stride: usize,
        out: &mut [u8],
    ) -> Result<()> {
        self.outside_object()?;
        let row_bytes = (width as usize).checked_mul(kind.bytes_per_pixel());
        let row_bytes = row_bytes
            .ok_or_else(|| Error::invalid_value(format_args!("a width of {width} pixels is larger than memory")))?;
        let stride = if stride == 0 { row_bytes } else { stride };
        if stride < row_bytes {
            return Err(Error::invalid_value(format_args!(
                "stride is {stride}, less than the {row_bytes} bytes of a row"
            )));
        }
        let (top_left, srgb) = (self.settings.origin_top_left, self.settings.srgb);
        let picture = self.backend.framebuffer();
        let picture = match picture {
            Ok(picture) => picture,
            Err(failure) => return Err(self.distrust(failure)),
        };
        if picture.width() == 0 {
            return Err(Error::invalid_operation("nothing was rendered yet"));
        }
        let fits = |start: u32, length: u32, size: u32| start.checked_add(length).is_some_and(|end| end <= size);
        if !fits(x, width, picture.width()) || !fits(y, height, picture.height()) {
            let (w, h) = (picture.width(), picture.height());
            return Err(Error::invalid_value(format_args!(
                "the rectangle of {width} x {height} pixels at ({x}, {y}) reaches beyond the picture of {w} x {h}"
            )));
        }
        if width == 0 || height == 0 {
            return Ok(());
        }
        let needed = stride.checked_mul(height as usize - 1).and_then(|n| n.checked_add(row_bytes));
        if needed.is_none_or(|needed| needed > out.len()) {
            let bytes = out.len();
            return Err(Error::invalid_value(format_args!("{bytes} bytes are too few for {width} x {height} pixels")));
        }
        for (row, out) in out.chunks_mut(stride).take(height as usize).enumerate() {
            let from_below = y + row as u32;
            let line = if top_left { picture.height() - 1 - from_below } else { from_below };
            let pixels = picture.row(line).skip(x as usize).take(width as usize);
            let out = &mut out[..row_bytes];
            match kind {
                PixelKind::Color(format) => encode_pixels(format, srgb, pixels.map(|p| p.color), out),
                PixelKind::Depth => words(out, pixels.map(|p| p.depth.to_ne_bytes())),
                PixelKind::Normal => words(out, pixels.flat_map(|p| p.normal).map(f32::to_ne_bytes)),
                PixelKind::ObjectId => words(out, pixels.map(|p| p.object.to_ne_bytes())),
                PixelKind::InstanceId => words(out, pixels.map(|p| p.instance.to_ne_bytes())),
            }
        }
        Ok(())
    }

    /// Size of the last frame, 0 × 0 before the first. Waits for a frame in flight.
    ///
    /// # Errors
    /// `InvalidOperation` between begin and end or inside an object.
    pub fn frame_size(&mut self) -> Result<[u32; 2]> {
        self.outside_object()?;
        let size = self.backend.framebuffer().map(|picture| [picture.width(), picture.height()]);
        self.trust(size)
    }

    /// Writes the last frame to a file whose extension names the format (PNG, JPEG, PPM, HDR, EXR). Waits for a frame in flight. A file that is there
    /// is replaced when the new one is complete, and stays what it was when that cannot be.
    ///
    /// # Errors
    /// `InvalidOperation` when nothing was rendered yet or image files were left out of the build, `Io` with the cause, `OutOfMemory`.
    pub fn write_image(&mut self, path: impl AsRef<Path>) -> Result<()> {
        self.outside_object()?;
        let (srgb, quality) = (self.settings.srgb, self.settings.jpeg_quality);
        if self.frame_size()?[0] == 0 {
            return Err(Error::invalid_operation("nothing was rendered yet"));
        }
        let written = self.backend.write_image(path.as_ref(), srgb, quality);
        Ok(self.trust(written)??)
    }

    /// Sends what the state machine holds back until a frame starts, and describes the frame but for its instances, for which the list is empty.
    fn send_changes(&mut self) -> Result<FrameDesc> {
        self.send_textures()?;
        self.send_parameters()?;
        let camera = self.send_camera()?;
        let spare = self.backend.spare_frame();
        let FrameDesc { mut lights, mut instances, .. } = self.trust(spare)?;
        copy_into(&mut lights, &self.content.lights)?;
        instances.clear();
        Ok(FrameDesc {
            instances,
            lights,
            ambient: self.content.ambient,
            camera,
            environment: self.content.environment,
            renderer: self.content.renderer,
            clear_color: self.content.clear_color,
            size: self.target.size().unwrap_or([1, 1]),
            samples: self.settings.samples,
            max_depth: self.settings.max_depth,
            top_level: self.settings.top_level,
            srgb: self.settings.srgb,
            accumulate: self.settings.accumulate,
            subsampling: self.settings.subsampling,
            upsampling: self.settings.upsampling,
            frameless: self.settings.frameless,
            time_budget: self.settings.time_budget,
            progressive: self.settings.progressive,
            ..FrameDesc::default()
        })
    }

    /// Turns a failure of the back-end into an error; a defect makes the context unusable.
    pub(super) fn trust<T>(&mut self, outcome: Result<T, FrameFailure>) -> Result<T> {
        outcome.map_err(|failure| self.distrust(failure))
    }

    pub(super) fn distrust(&mut self, failure: FrameFailure) -> Error {
        let error = error_of(failure);
        if error.code == ErrorCode::InternalError {
            self.poison(error.message.clone());
        }
        error
    }
}

fn error_of(failure: FrameFailure) -> Error {
    let code = match &failure {
        FrameFailure::OutOfMemory(_) => ErrorCode::OutOfMemory,
        FrameFailure::Threads(_) => ErrorCode::Io,
        FrameFailure::Panicked(_) => ErrorCode::InternalError,
        FrameFailure::Forked => ErrorCode::InvalidOperation,
    };
    Error::new(code, failure.to_string())
}

fn words(out: &mut [u8], words: impl Iterator<Item = [u8; 4]>) {
    for (out, word) in out.chunks_exact_mut(4).zip(words) {
        out.copy_from_slice(&word);
    }
}
