//! Frame techniques: how a picture is made with fewer rays.

use super::context::Context;
use super::error::Result;
use super::state::in_range;
use super::target::MAX_FRAME_SIZE;
use crate::scene::Upsampling;
use std::time::Duration;

/// What [`Context::frame_parameter`] sets, for all frames that start from then on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FrameParameter {
    /// Only one pixel in each block of so many on a side is sampled, 1 to [`MAX_FRAME_SIZE`]; the others get colours in between, and depth, normal and
    /// names of the nearest. Sampled are columns and rows 0, n, 2n, … of the viewport and its last ones, and these show what they
    /// show without sub-sampling. 1, the default, samples all (Larsson and Akenine-Möller 2003, §4).
    Subsampling(i32),
    /// How the colours in between are found.
    Upsampling(Upsampling),
    /// Frameless rendering (Bishop 1994): each frame renders one in so many pixels, 1 to [`MAX_FRAMELESS`], in an order that looks random
    /// and gives every pixel its turn once in so many frames; the others keep what older frames left. The first frame of a size, viewport or sub-sampling is
    /// complete. 1, the default, renders all. Above 1, frames are not averaged.
    Frameless(i32),
    /// When a frame shall be finished, from its start; None, the default, gives it all the time that it takes. With a budget all primary rays are
    /// sent first, and the picture is as by the rendering object `raycast` with one sample per pixel; then tiles are rendered in full, from the middle on, until
    /// the time is up. A tile that was begun is finished. [`crate::api::FrameStats::refined`] says how far that went.
    TimeBudget(Option<Duration>),
}

/// Most frames of a cycle of frameless rendering.
pub const MAX_FRAMELESS: u32 = 1024;

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
            FrameParameter::Frameless(frames) => self.settings.frameless = in_range(frames, 1, MAX_FRAMELESS)?,
            FrameParameter::TimeBudget(budget) => self.settings.time_budget = budget,
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
