//! Frame techniques: how a picture is made with fewer rays.

use super::context::Context;
use super::error::Result;
use super::state::in_range;
use super::target::MAX_FRAME_SIZE;
use crate::scene::Upsampling;

/// What [`Context::frame_parameter`] sets, for all frames that start from then on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FrameParameter {
    /// Only one pixel in each block of so many on a side is sampled, 1 to [`MAX_FRAME_SIZE`]; the others get colours in between, and depth, normal and
    /// names of the nearest. Sampled are columns and rows 0, n, 2n, … of the viewport and its last ones, and these show what they
    /// show without sub-sampling. 1, the default, samples all (Larsson and Akenine-Möller 2003, §4).
    Subsampling(i32),
    /// How the colours in between are found.
    Upsampling(Upsampling),
}

impl Context {
    /// Sets a parameter of the frames that start from now on.
    ///
    /// # Errors
    /// `InvalidValue` for a number that the parameter does not allow, `InvalidOperation` between begin and end.
    pub fn frame_parameter(&mut self, parameter: FrameParameter) -> Result<()> {
        self.outside_begin()?;
        match parameter {
            FrameParameter::Subsampling(pixels) => self.settings.subsampling = in_range(pixels, 1, MAX_FRAME_SIZE)?,
            FrameParameter::Upsampling(scheme) => self.settings.upsampling = scheme,
        }
        Ok(())
    }

    /// How the pixels between sampled ones get their colours.
    ///
    /// # Errors
    /// `InvalidOperation` between begin and end.
    pub fn get_upsampling(&self) -> Result<Upsampling> {
        self.outside_begin()?;
        Ok(self.settings.upsampling)
    }
}
