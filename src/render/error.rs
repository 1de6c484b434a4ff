//! Why a frame could not be rendered.

use crate::frame::FramebufferError;
use crate::memory::OutOfMemory;
use std::fmt;

#[derive(Debug)]
pub enum RenderError {
    /// The framebuffer could not be made; the frame before is still there.
    Framebuffer(FramebufferError),
    /// What frames work in could not be made.
    Memory(OutOfMemory),
    /// Acceleration structures of the frame's objects could not be made.
    Structures { bytes: u64 },
    /// The composites of the frame have more parts than there is memory or numbers for.
    Instances,
}

impl fmt::Display for RenderError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Framebuffer(cause) => write!(f, "{cause}"),
            Self::Memory(cause) => write!(f, "{cause} to render in"),
            Self::Structures { bytes } => write!(f, "no memory for {bytes} bytes of acceleration structures"),
            Self::Instances => write!(f, "no memory for the parts of the frame's composites"),
        }
    }
}

impl std::error::Error for RenderError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Framebuffer(cause) => Some(cause),
            Self::Memory(cause) => Some(cause),
            Self::Structures { .. } | Self::Instances => None,
        }
    }
}

impl From<OutOfMemory> for RenderError {
    fn from(cause: OutOfMemory) -> Self {
        Self::Memory(cause)
    }
}

impl From<FramebufferError> for RenderError {
    fn from(cause: FramebufferError) -> Self {
        Self::Framebuffer(cause)
    }
}
