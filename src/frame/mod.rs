//! Colours to pixels.
//!
//! The renderer fills a [`Framebuffer`] of linear floats, tile by tile; every finished tile is encoded for the
//! application's image ([`Target`]) at once. Rows count from the bottom, as in OpenGL, everywhere but in image files
//! and in targets that ask for it.
#![forbid(unsafe_code)]

pub mod srgb;

mod block;
mod encode;
mod framebuffer;
mod image_file;
mod lattice;
mod new_file;
mod pixel_format;
mod stats;

pub use block::{BLOCK_PIXELS, Block, NO_INSTANCE, Pixel, TILE_SIZE, Tile, block_place};
pub use encode::encode_pixels;
pub use framebuffer::{Framebuffer, FramebufferError, TileGrid, TileRect};
pub use image_file::{ImageFileError, LoadedImage, read_image, write_image};
pub use lattice::Lattice;
pub use new_file::NewFile;
pub use pixel_format::{PixelFormat, PixelSink, Target, TargetLayout};
pub use stats::FrameStats;
