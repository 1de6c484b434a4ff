//! Colours to pixels.
#![forbid(unsafe_code)]

mod pixel_format;
mod stats;

pub use pixel_format::{PixelFormat, PixelSink, Target, TargetLayout};
pub use stats::FrameStats;
