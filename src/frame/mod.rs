//! Colours to pixels.
#![forbid(unsafe_code)]

mod pixel_format;
mod stats;

pub use pixel_format::{PixelFormat, PixelSink, TargetLayout};
pub use stats::FrameStats;
