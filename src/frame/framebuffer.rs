//! The picture in linear floats, stored tile by tile.
//!
//! Tile-major storage lets threads own disjoint slices without locks or `unsafe`, and keeps the memory
//! that a thread writes together ([`super::block`]). Tiles at the right and upper border are stored whole; their outer pixels are never
//! shown.

use super::block::{Pixel, TILE_SIZE, Tile};
use std::fmt;

/// Largest width or height.
const MAX_SIZE: u32 = 1 << 16;

/// A rectangle of pixels: columns `x0..x1`, rows `y0..y1` from the bottom.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileRect {
    pub x0: u32,
    pub y0: u32,
    pub x1: u32,
    pub y1: u32,
}

impl TileRect {
    /// The common part; empty rectangles have `x0 >= x1` or `y0 >= y1`.
    pub fn intersection(self, other: TileRect) -> TileRect {
        TileRect {
            x0: self.x0.max(other.x0),
            y0: self.y0.max(other.y0),
            x1: self.x1.min(other.x1),
            y1: self.y1.min(other.y1),
        }
    }

    pub fn is_empty(&self) -> bool {
        self.x0 >= self.x1 || self.y0 >= self.y1
    }
}

/// How a picture is cut into tiles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TileGrid {
    pub width: u32,
    pub height: u32,
}

impl TileGrid {
    pub fn tiles_x(&self) -> u32 {
        self.width.div_ceil(TILE_SIZE)
    }

    pub fn tile_count(&self) -> usize {
        self.tiles_x() as usize * self.height.div_ceil(TILE_SIZE) as usize
    }

    /// The visible pixels of tile `index`; tiles run row by row from the lower left.
    pub fn rect(&self, index: usize) -> TileRect {
        let x0 = (index % self.tiles_x() as usize) as u32 * TILE_SIZE;
        let y0 = (index / self.tiles_x() as usize) as u32 * TILE_SIZE;
        TileRect { x0, y0, x1: (x0 + TILE_SIZE).min(self.width), y1: (y0 + TILE_SIZE).min(self.height) }
    }
}

/// The framebuffer of the last frames.
#[derive(Default)]
pub struct Framebuffer {
    grid: TileGrid,
    tiles: Vec<Tile>,
    /// Samples per pixel that are averaged in each tile.
    samples: Vec<u32>,
}

/// The framebuffer could not be made.
#[derive(Debug)]
pub enum FramebufferError {
    /// A side is longer than 65,536 pixels.
    TooLarge { width: u32, height: u32 },
    /// The memory is not there.
    OutOfMemory { bytes: u64 },
}

impl fmt::Display for FramebufferError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooLarge { width, height } => {
                write!(f, "a framebuffer of {width} x {height} pixels is larger than {MAX_SIZE} on a side")
            }
            Self::OutOfMemory { bytes } => write!(f, "no memory for a framebuffer of {bytes} bytes"),
        }
    }
}

impl std::error::Error for FramebufferError {}

impl Framebuffer {
    /// Makes the picture `width` × `height`. A picture that already has this size is kept; any other starts
    /// as [`Pixel::EMPTY`]. On an error the old picture stays.
    pub fn resize(&mut self, width: u32, height: u32) -> Result<(), FramebufferError> {
        let grid = TileGrid { width, height };
        if grid == self.grid {
            return Ok(());
        }
        if width > MAX_SIZE || height > MAX_SIZE {
            return Err(FramebufferError::TooLarge { width, height });
        }
        let tiles = grid.tile_count();
        let bytes = tiles as u64 * (size_of::<Tile>() + size_of::<u32>()) as u64;
        let out_of_memory = |_| FramebufferError::OutOfMemory { bytes };
        // A smaller picture re-uses the memory of a larger one.
        if self.tiles.capacity() < tiles {
            let mut fresh = Vec::new();
            fresh.try_reserve_exact(tiles).map_err(out_of_memory)?;
            let mut samples = Vec::new();
            samples.try_reserve_exact(tiles).map_err(out_of_memory)?;
            (self.tiles, self.samples) = (fresh, samples);
        }
        self.tiles.clear();
        self.tiles.resize(tiles, Tile::EMPTY);
        self.samples.clear();
        self.samples.resize(tiles, 0);
        self.grid = grid;
        Ok(())
    }

    pub fn width(&self) -> u32 {
        self.grid.width
    }

    pub fn height(&self) -> u32 {
        self.grid.height
    }

    pub fn grid(&self) -> TileGrid {
        self.grid
    }

    /// The pixel in column `x`, row `y` from the bottom; None outside the picture.
    #[inline]
    pub fn pixel(&self, x: u32, y: u32) -> Option<Pixel> {
        if x >= self.grid.width || y >= self.grid.height {
            return None;
        }
        let tile = (y / TILE_SIZE * self.grid.tiles_x() + x / TILE_SIZE) as usize;
        self.tiles.get(tile).map(|tile| tile.pixel(x % TILE_SIZE, y % TILE_SIZE))
    }

    /// The pixels of row `y` from the bottom, left to right; nothing outside the picture.
    pub fn row(&self, y: u32) -> impl ExactSizeIterator<Item = Pixel> + '_ {
        let width = if y < self.grid.height { self.grid.width } else { 0 };
        (0..width).map(move |x| self.pixel(x, y).expect("x and y are inside the picture"))
    }

    /// All tiles for writing, and a sample count for each, in the order of [`TileGrid::rect`].
    pub fn tiles_mut(&mut self) -> (&mut [Tile], &mut [u32]) {
        (&mut self.tiles, &mut self.samples)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_every_pixel_once() {
        for (width, height) in [(1, 1), (16, 16), (17, 31), (50, 3)] {
            let grid = TileGrid { width, height };
            let mut seen = vec![0; (width * height) as usize];
            for i in 0..grid.tile_count() {
                let r = grid.rect(i);
                for y in r.y0..r.y1 {
                    for x in r.x0..r.x1 {
                        seen[(y * width + x) as usize] += 1;
                    }
                }
            }
            assert!(seen.iter().all(|&n| n == 1));
        }
    }

    #[test]
    fn pixel_finds_what_a_tile_wrote() {
        let mut fb = Framebuffer::default();
        fb.resize(37, 21).unwrap();
        let grid = fb.grid();
        let (tiles, _) = fb.tiles_mut();
        for (i, tile) in tiles.iter_mut().enumerate() {
            let r = grid.rect(i);
            for y in r.y0..r.y1 {
                for x in r.x0..r.x1 {
                    tile.set(x - r.x0, y - r.y0, Pixel { object: y * 37 + x + 1, ..Pixel::EMPTY });
                }
            }
        }
        for y in 0..21 {
            assert!(fb.row(y).enumerate().all(|(x, p)| p.object == y * 37 + x as u32 + 1));
        }
        assert!(fb.pixel(37, 0).is_none() && fb.pixel(0, 21).is_none());
        assert_eq!(fb.row(21).len(), 0);
    }

    #[test]
    fn a_size_beyond_reason_is_refused_and_the_old_picture_stays() {
        let mut fb = Framebuffer::default();
        fb.resize(4, 4).unwrap();
        assert!(matches!(fb.resize(u32::MAX, u32::MAX), Err(FramebufferError::TooLarge { .. })));
        assert_eq!((fb.width(), fb.height()), (4, 4));
        assert!(fb.resize(0, 9).is_ok());
        assert!(fb.pixel(0, 0).is_none());
    }
}
