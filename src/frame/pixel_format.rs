//! Where finished pixels go: the layout of the application's image, and the hole through which bytes reach it.

use std::sync::Arc;

/// How one pixel is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PixelFormat {
    Rgba8,
    Bgra8,
    Rgb8,
    Bgr8,
    Rgb32F,
    Rgba32F,
    Bgr32F,
    Bgra32F,
}

impl PixelFormat {
    pub fn bytes_per_pixel(self) -> usize {
        match self {
            PixelFormat::Rgb8 | PixelFormat::Bgr8 => 3,
            PixelFormat::Rgba8 | PixelFormat::Bgra8 => 4,
            PixelFormat::Rgb32F | PixelFormat::Bgr32F => 12,
            PixelFormat::Rgba32F | PixelFormat::Bgra32F => 16,
        }
    }
}

/// Layout of a target image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TargetLayout {
    pub width: u32,
    pub height: u32,
    pub format: PixelFormat,
    /// Bytes from one row to the next, at least `width * bytes_per_pixel`.
    pub stride: usize,
    /// Row 0 is the top of the picture instead of the bottom.
    pub origin_top_left: bool,
}

/// Receives encoded pixels while a frame renders. Called from several threads at once, for disjoint byte ranges.
pub trait PixelSink: Send + Sync {
    /// Stores `bytes` at `offset` bytes from the start of the image. The renderer keeps within
    /// `height * stride` of the layout that came with the sink.
    fn write(&self, offset: usize, bytes: &[u8]);
}

/// An image of the application's that a frame is delivered to.
#[derive(Clone)]
pub struct Target {
    pub layout: TargetLayout,
    pub sink: Arc<dyn PixelSink>,
}
