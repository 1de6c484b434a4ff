//! Pixels in memory: tiles of four blocks of 8×8, in a block each number of all pixels by itself.
//!
//! A renderer that shades eight samples at a time has every number of them in a vector. Kept like this a block is written by whole
//! lines of memory, 40 of them; as records of 40 bytes, pixel by pixel, writing was a tenth of the time of a frame of primary rays. The order of pixels in a
//! block is the renderer's: each run of eight is 4×2 pixels, two of them are 4×4.

/// Edge length of a tile in pixels.
pub const TILE_SIZE: u32 = 16;
/// Edge length of a block in pixels.
pub const BLOCK_SIZE: u32 = 8;
/// Pixels of one block.
pub const BLOCK_PIXELS: usize = (BLOCK_SIZE * BLOCK_SIZE) as usize;
/// Blocks along each side of a tile.
const BLOCKS: u32 = TILE_SIZE / BLOCK_SIZE;
/// [`Pixel::instance`] where nothing was hit.
pub const NO_INSTANCE: u32 = u32::MAX;

/// What a frame leaves for one pixel. All but the colour belong to the sample nearest to the pixel's centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixel {
    /// Linear RGB, and coverage (1 where something was hit).
    pub color: [f32; 4],
    /// Distance from the ray's origin along the camera ray, in world units; infinite where nothing was hit.
    pub depth: f32,
    /// Unit shading normal in world space, on the side of the camera; 0 where nothing was hit.
    pub normal: [f32; 3],
    /// Name of the object; 0 where nothing was hit.
    pub object: u32,
    /// Number of the instance in the order of the frame; [`NO_INSTANCE`] where nothing was hit.
    pub instance: u32,
}

impl Pixel {
    /// A pixel that no frame has touched.
    pub const EMPTY: Pixel =
        Pixel { color: [0.0; 4], depth: f32::INFINITY, normal: [0.0; 3], object: 0, instance: NO_INSTANCE };
}

/// 8×8 pixels; see [`Pixel`] for what the numbers are, and [`block_place`] for their order.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct Block {
    pub color: [[f32; BLOCK_PIXELS]; 4],
    pub depth: [f32; BLOCK_PIXELS],
    pub normal: [[f32; BLOCK_PIXELS]; 3],
    pub object: [u32; BLOCK_PIXELS],
    pub instance: [u32; BLOCK_PIXELS],
}

/// Column and row of pixel `i` of a block.
#[inline]
pub const fn block_place(i: usize) -> [u32; 2] {
    let i = i as u32;
    [4 * (i >> 4 & 1) + (i & 3), 4 * (i >> 5 & 1) + 2 * (i >> 3 & 1) + (i >> 2 & 1)]
}

/// The pixel of a block in column `x`, row `y`: the inverse of [`block_place`].
#[inline]
const fn number_at(x: u32, y: u32) -> usize {
    ((y & 4) << 3 | (x & 4) << 2 | (y & 3) << 2 | (x & 3)) as usize
}

impl Block {
    pub const EMPTY: Block = Block {
        color: [[0.0; BLOCK_PIXELS]; 4],
        depth: [f32::INFINITY; BLOCK_PIXELS],
        normal: [[0.0; BLOCK_PIXELS]; 3],
        object: [0; BLOCK_PIXELS],
        instance: [NO_INSTANCE; BLOCK_PIXELS],
    };

    /// Pixel `i`.
    #[inline(always)]
    pub fn pixel(&self, i: usize) -> Pixel {
        let [x, y, z] = &self.normal;
        Pixel {
            color: self.color(i),
            depth: self.depth[i],
            normal: [x[i], y[i], z[i]],
            object: self.object[i],
            instance: self.instance[i],
        }
    }

    #[inline(always)]
    pub fn set(&mut self, i: usize, pixel: Pixel) {
        self.set_color(i, pixel.color);
        self.depth[i] = pixel.depth;
        for (plane, number) in self.normal.iter_mut().zip(pixel.normal) {
            plane[i] = number;
        }
        self.object[i] = pixel.object;
        self.instance[i] = pixel.instance;
    }

    #[inline(always)]
    pub fn color(&self, i: usize) -> [f32; 4] {
        let [r, g, b, a] = &self.color;
        [r[i], g[i], b[i], a[i]]
    }

    #[inline(always)]
    pub fn set_color(&mut self, i: usize, color: [f32; 4]) {
        for (plane, number) in self.color.iter_mut().zip(color) {
            plane[i] = number;
        }
    }
}

/// 16×16 pixels.
#[derive(Clone, Debug)]
pub struct Tile {
    /// From the lower left, row by row.
    pub blocks: [Block; (BLOCKS * BLOCKS) as usize],
}

impl Tile {
    pub const EMPTY: Tile = Tile { blocks: [const { Block::EMPTY }; (BLOCKS * BLOCKS) as usize] };

    /// The pixel in column `x`, row `y` of the tile. (Beyond the tile they begin anew.)
    #[inline(always)]
    pub fn pixel(&self, x: u32, y: u32) -> Pixel {
        self.blocks[block_at(x, y)].pixel(number_at(x, y))
    }

    #[inline(always)]
    pub fn set(&mut self, x: u32, y: u32, pixel: Pixel) {
        self.blocks[block_at(x, y)].set(number_at(x, y), pixel);
    }

    #[inline(always)]
    pub fn color(&self, x: u32, y: u32) -> [f32; 4] {
        self.blocks[block_at(x, y)].color(number_at(x, y))
    }
}

/// The block of a tile that has the pixel in column `x`, row `y`.
#[inline(always)]
const fn block_at(x: u32, y: u32) -> usize {
    (y / BLOCK_SIZE % BLOCKS * BLOCKS + x / BLOCK_SIZE % BLOCKS) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_of_a_tile_has_a_place_of_its_own() {
        let mut tile = Tile::EMPTY;
        let value = |x: u32, y: u32| Pixel {
            color: [0, 1, 2, 3].map(|k| (4 * (16 * y + x) + k) as f32),
            depth: x as f32,
            normal: [y as f32, 1.0, -(x as f32)],
            object: y,
            instance: 16 * x + y,
        };
        let all = || (0..TILE_SIZE).flat_map(|y| (0..TILE_SIZE).map(move |x| (x, y)));
        all().for_each(|(x, y)| tile.set(x, y, value(x, y)));
        for (x, y) in all() {
            assert_eq!(tile.pixel(x, y), value(x, y));
            assert_eq!(tile.color(x, y), value(x, y).color);
        }
        for i in 0..BLOCK_PIXELS {
            let [x, y] = block_place(i);
            assert_eq!(number_at(x, y), i);
            assert_eq!(tile.blocks[1].pixel(i), value(x + 8, y));
            assert_eq!(tile.blocks[2].pixel(i), value(x, y + 8));
        }
    }
}
