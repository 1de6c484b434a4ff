//! One parallel subfield: all beams of one direction through a set of triangles, as tiles that list what their beam meets (Khanna04 §2).
//!
//! *Frame.* Tiles lie on the side of the bounding cuboid that the direction meets most steeply; points are moved onto it along the direction. That is a shear
//! instead of the paper's rotation into the canonical direction: two multiplications, walls along the axes stay along rows and columns, and depth is a
//! coordinate of the object. In the frame a tile is one unit wide and the set is one unit deep.
//!
//! *Lists.* A reference is 16 bytes: the triangle, how deep it reaches in this tile, and the part of the tile that it covers, in 256ths. So most triangles are passed
//! over without a look at their corners, and tiles can be coarse. In a subfield of resting triangles each list is in the order of depth, and a ray finds its place by
//! binary search: the list is a binary space partition by planes across the beam. A triangle that reaches
//! through more than a quarter of its tile's depth, as a wall along the beam, would spoil the order; those come first, in a list of their own.
//!
//! *Numbers.* The frame is computed in f64, where rounding is nothing beside that of rays (see `trace/traverse_field`); what is stored is rounded
//! outwards.

use super::raster::{Piece, cover, tile_of};
use crate::accel::memory::recycled;
use crate::accel::{OutOfMemory, triangle_bounds};
use glam::Vec3;

/// Tiles per triangle.
const DENSITY: f64 = 0.5;
/// References per triangle beyond which there are fewer tiles.
const MOST_REFS: usize = 6;
/// Tiles along a side at most.
const MOST_TILES: usize = 2048;
/// By how much tiles become fewer where there are too many references.
const COARSER: f64 = 0.4;
/// Lists up to this length are not ordered.
const SHORT: usize = 8;
/// A triangle is long if it reaches through more than this part of the depth of its tile's list.
const LONG: f32 = 0.25;
/// Depths are grown by this part of the whole: more than they are rounded by.
const DEPTH_MARGIN: f64 = 1.0 / (1 << 21) as f64;
/// Only triangles with at least this size, in tiles, and this part of its square as area get depths of their own in each tile: of others the slope
/// is not known well enough, and little is to be gained.
const LEAST_SIZE: f64 = 0.5;
const LEAST_AREA: f64 = 1e-4;

/// A triangle in a tile.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TileRef {
    /// How deep it reaches, in the frame of the subfield.
    pub near: f32,
    pub far: f32,
    pub prim: u32,
    /// The part of the tile that it covers, in 256ths: from column, row to column, row. 255 stands for the border beyond as well.
    pub covers: [u8; 4],
}

const _: () = assert!(size_of::<TileRef>() == 16);

/// A tile's list ends where the next one begins.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Tile {
    first: u32,
    /// Where the part in the order of `near` begins.
    ordered: u32,
    /// No triangle of that part reaches farther than this.
    reach: f32,
}

/// The references of one tile.
#[derive(Clone, Copy, Debug)]
pub struct TileList<'a> {
    /// In no order.
    pub unordered: &'a [TileRef],
    /// In ascending order of `near`.
    pub ordered: &'a [TileRef],
    /// The greatest `far - near` of `ordered`.
    pub reach: f32,
}

/// From the object's space to a subfield's.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// The object's axes in the order of the frame's: column, row, depth.
    pub axes: [usize; 3],
    /// What a column and a row change by per unit of depth, in the object's units.
    pub shear: [f64; 2],
    pub scale: [f64; 3],
    /// A point of the set, from which differences are taken first: they are exact, or nearly so, however far out the set is.
    base: [f64; 3],
    /// Of the sheared differences.
    origin: [f64; 3],
}

impl Frame {
    /// Along `dir`, in the object's units.
    fn along(dir: Vec3) -> Self {
        let size = dir.abs();
        let depth = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let axes = [(depth + 1) % 3, (depth + 2) % 3, depth];
        let shear = [axes[0], axes[1]].map(|k| f64::from(dir[k]) / f64::from(dir[depth]));
        Self { axes, shear, scale: [1.0; 3], base: [0.0; 3], origin: [0.0; 3] }
    }

    /// A point in the frame.
    #[inline(always)]
    pub fn point(&self, p: Vec3) -> [f64; 3] {
        let [x, y, z] = [0, 1, 2].map(|i| f64::from(p[self.axes[i]]) - self.base[i]);
        let sheared = [x - self.shear[0] * z, y - self.shear[1] * z, z];
        [0, 1, 2].map(|i| (sheared[i] - self.origin[i]) * self.scale[i])
    }

    /// A difference of points in the frame.
    #[inline(always)]
    pub fn vector(&self, p: Vec3) -> [f64; 3] {
        let [x, y, z] = self.axes.map(|k| f64::from(p[k]));
        [(x - self.shear[0] * z) * self.scale[0], (y - self.shear[1] * z) * self.scale[1], z * self.scale[2]]
    }
}

/// See the module head.
#[derive(Debug, Default)]
pub struct Subfield {
    /// None until something is put in.
    frame: Option<Frame>,
    counts: [usize; 2],
    /// One more than there are.
    tiles: Vec<Tile>,
    refs: Vec<TileRef>,
}

/// Some of the triangles of an object.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chosen<'a> {
    pub corners: &'a [[Vec3; 3]],
    /// These, or all if `None`,
    pub listed: Option<&'a [u32]>,
    /// but for those marked here.
    pub without: Option<&'a [bool]>,
}

impl Chosen<'_> {
    /// Calls `f` for every one that rays can hit.
    #[inline(always)]
    pub fn each(&self, mut f: impl FnMut(u32, [Vec3; 3])) {
        let mut usable = |prim: u32| {
            let corners = self.corners[prim as usize];
            let marked = self.without.is_some_and(|marks| marks[prim as usize]);
            if !marked && !triangle_bounds(corners).is_empty() {
                f(prim, corners);
            }
        };
        match self.listed {
            Some(listed) => listed.iter().for_each(|&prim| usable(prim)),
            None => (0..self.corners.len() as u32).for_each(usable),
        }
    }
}

impl Subfield {
    /// Puts triangles into the tiles of a direction, in the memory of what was there; in the order of depth if `ordered`.
    pub(super) fn fill(&mut self, dir: Vec3, chosen: &Chosen<'_>, ordered: bool) -> Result<(), OutOfMemory> {
        let mut frame = Frame::along(dir);
        let (mut lo, mut hi, mut usable) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3], 0usize);
        chosen.each(|_, corners| {
            if usable == 0 {
                frame.base = frame.axes.map(|k| f64::from(corners[0][k]));
            }
            usable += 1;
            for p in corners.map(|p| frame.point(p)) {
                for k in 0..3 {
                    (lo[k], hi[k]) = (lo[k].min(p[k]), hi[k].max(p[k]));
                }
            }
        });
        if usable == 0 {
            *self = Subfield { frame: Some(frame), ..Subfield::default() };
            return Ok(());
        }
        let extent = [0, 1, 2].map(|k| hi[k] - lo[k]);
        frame.origin = lo;
        let mut wanted = DENSITY * usable as f64;
        let mut tiles = std::mem::take(&mut self.tiles);
        let (counts, count) = loop {
            let counts = resolution([extent[0], extent[1]], wanted);
            frame.scale =
                [scale(counts[0] as f64, extent[0]), scale(counts[1] as f64, extent[1]), scale(1.0, extent[2])];
            let number = counts[0] * counts[1];
            tiles = recycled(tiles, number + 1)?;
            tiles.clear();
            tiles.resize(number + 1, Tile::default());
            let mut count = 0usize;
            chosen.each(|_, corners| {
                let points = corners.map(|p| frame.point(p));
                cover(&points.map(|p| [p[0], p[1]]), counts, |piece| {
                    tiles[piece.tile[1] * counts[0] + piece.tile[0] + 1].first += 1;
                    count += 1;
                });
            });
            if (count <= MOST_REFS * usable && count < u32::MAX as usize) || number == 1 {
                break (counts, count);
            }
            wanted *= COARSER;
        };
        // Each entry becomes the beginning of the tile before, and moves on to its end as that is filled.
        let mut sum = 0;
        for tile in &mut tiles[1..] {
            let here = tile.first;
            tile.first = sum;
            sum += here;
        }
        let mut refs = recycled(std::mem::take(&mut self.refs), count)?;
        refs.truncate(count);
        refs.resize(count, TileRef::default());
        chosen.each(|prim, corners| {
            let points = corners.map(|p| frame.point(p));
            let depth = Depth::new(&points);
            cover(&points.map(|p| [p[0], p[1]]), counts, |piece| {
                let end = &mut tiles[piece.tile[1] * counts[0] + piece.tile[0] + 1].first;
                let [near, far] = depth.within(&piece);
                refs[*end as usize] = TileRef { near, far, prim, covers: covers(&piece) };
                *end += 1;
            });
        });
        for i in 0..tiles.len() - 1 {
            let (first, end) = (tiles[i].first, tiles[i + 1].first);
            let list = &mut refs[first as usize..end as usize];
            (tiles[i].ordered, tiles[i].reach) = (end, 0.0);
            if ordered && list.len() > SHORT {
                let (long, reach) = put_in_order(list);
                (tiles[i].ordered, tiles[i].reach) = (first + long as u32, reach);
            }
        }
        *self = Subfield { frame: Some(frame), counts, tiles, refs };
        Ok(())
    }

    /// None if memory ran out when it was filled.
    #[inline(always)]
    pub fn frame(&self) -> Option<&Frame> {
        self.frame.as_ref()
    }

    /// Tiles per row and per column; 0 if there is nothing in it.
    #[inline(always)]
    pub fn counts(&self) -> [usize; 2] {
        self.counts
    }

    /// The list of a tile.
    #[inline(always)]
    pub fn list(&self, column: usize, row: usize) -> TileList<'_> {
        let at = row * self.counts[0] + column;
        let Tile { first, ordered, reach } = self.tiles[at];
        let end = self.tiles[at + 1].first as usize;
        let ordered = ordered as usize;
        TileList { unordered: &self.refs[first as usize..ordered], ordered: &self.refs[ordered..end], reach }
    }

    /// References of all tiles.
    pub fn refs(&self) -> usize {
        self.refs.len()
    }

    /// Gives the memory back.
    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }

    /// Bytes held, capacity included.
    pub fn memory_bytes(&self) -> usize {
        self.tiles.capacity() * size_of::<Tile>() + self.refs.capacity() * size_of::<TileRef>()
    }

    /// Checks that points of the chosen triangles are found where a ray looks for them. Describes the first that is not.
    pub(super) fn validate(&self, chosen: &Chosen<'_>) -> Result<(), String> {
        let Some(frame) = &self.frame else { return Ok(()) };
        let mut fault = None;
        chosen.each(|prim, [a, b, c]| {
            let points = [a, b, c, (a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5].map(|p| frame.point(p));
            for (i, p) in points.into_iter().enumerate() {
                // Middles are rounded, to f32 of the object's units.
                let slack = if i < 3 { 1e-6 } else { return };
                let tile = [tile_of(p[0], self.counts[0]), tile_of(p[1], self.counts[1])];
                let TileList { unordered, ordered, .. } = self.list(tile[0], tile[1]);
                let holds = |r: &TileRef| {
                    let at = |k: usize| (p[k] - tile[k] as f64) * 256.0;
                    let [x0, y0, x1, y1] = r.covers.map(f64::from);
                    let beside = |v: f64, lo: f64, hi: f64| lo <= v + 1e-3 && (v <= hi + 1e-3 || hi == 255.0);
                    r.prim == prim
                        && f64::from(r.near) <= p[2] + slack
                        && p[2] <= f64::from(r.far) + slack
                        && beside(at(0), x0, x1)
                        && beside(at(1), y0, y1)
                };
                if !unordered.iter().chain(ordered).any(holds) {
                    fault = Some(format!("triangle {prim} is not in tile {tile:?}, where {p:?} is"));
                }
            }
        });
        for row in 0..self.counts[1] {
            for column in 0..self.counts[0] {
                let TileList { ordered, reach, .. } = self.list(column, row);
                let in_order = ordered.windows(2).all(|pair| pair[0].near <= pair[1].near);
                if !in_order || ordered.iter().any(|r| r.far > r.near + reach) {
                    fault = Some(format!("tile {column}, {row} is not in order"));
                }
            }
        }
        fault.map_or(Ok(()), Err)
    }
}

/// How many tiles, or units of depth, go into one unit; nothing is stretched to infinity.
fn scale(count: f64, extent: f64) -> f64 {
    let scale = count / extent;
    if scale.is_finite() { scale } else { 0.0 }
}

/// Columns and rows, about `wanted` tiles, as near to squares as it goes.
fn resolution(extent: [f64; 2], wanted: f64) -> [usize; 2] {
    let side = (extent[0] * extent[1] / wanted).sqrt();
    let long = extent[0].max(extent[1]);
    let side = if side > 0.0 { side.max(long / MOST_TILES as f64) } else { long / wanted.min(MOST_TILES as f64) };
    // What is not a number becomes 0.
    extent.map(|extent| ((extent / side).ceil() as usize).clamp(1, MOST_TILES))
}

/// Depths of a triangle.
struct Depth {
    at: [f64; 3],
    slope: [f64; 2],
    lo: f64,
    hi: f64,
}

impl Depth {
    #[inline(always)]
    fn new(points: &[[f64; 3]; 3]) -> Self {
        let [a, b, c] = *points;
        let (p, q) = ([b[0] - a[0], b[1] - a[1], b[2] - a[2]], [c[0] - a[0], c[1] - a[1], c[2] - a[2]]);
        let area = p[0] * q[1] - p[1] * q[0];
        let size = (p[0].abs() + p[1].abs()) + (q[0].abs() + q[1].abs());
        let slope = if size >= LEAST_SIZE && area.abs() > LEAST_AREA * size * size {
            [(p[2] * q[1] - p[1] * q[2]) / area, (p[0] * q[2] - p[2] * q[0]) / area]
        } else {
            // Nothing is known but its corners.
            [f64::INFINITY; 2]
        };
        Self { at: a, slope, lo: a[2].min(b[2]).min(c[2]), hi: a[2].max(b[2]).max(c[2]) }
    }

    /// From and to which depth the triangle reaches within a piece.
    #[inline(always)]
    fn within(&self, piece: &Piece) -> [f32; 2] {
        let (mut middle, mut half) = (self.at[2], 0.0);
        for k in 0..2 {
            middle += self.slope[k] * ((piece.lo[k] + piece.hi[k]) * 0.5 - self.at[k]);
            half += self.slope[k].abs() * ((piece.hi[k] - piece.lo[k]).abs() * 0.5 + 1e-6);
        }
        // Rounding moves the middle by some 1e-8, far less than the margin. Infinite or not a number: the corners decide.
        let lo = if middle - half > self.lo { middle - half } else { self.lo };
        let hi = if middle + half < self.hi { middle + half } else { self.hi };
        [(lo - DEPTH_MARGIN) as f32, (hi + DEPTH_MARGIN) as f32]
    }
}

/// A piece in 256ths of its tile, rounded outwards.
#[inline(always)]
fn covers(piece: &Piece) -> [u8; 4] {
    let at = |x: f64, k: usize| (x - piece.tile[k] as f64) * 256.0;
    // Casts to u8 stay within its range.
    let low = |k: usize| (at(piece.lo[k].min(piece.hi[k]), k) - 1e-3).floor() as u8;
    let high = |k: usize| (at(piece.hi[k].max(piece.lo[k]), k) + 1e-3).ceil() as u8;
    [low(0), low(1), high(0), high(1)]
}

/// Long triangles first, then the others in the order of depth. Returns how many are long, and the reach of the others.
fn put_in_order(list: &mut [TileRef]) -> (usize, f32) {
    let (near, far) = list.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(n, f), r| (n.min(r.near), f.max(r.far)));
    let most = (far - near) * LONG;
    let mut long = 0;
    for i in 0..list.len() {
        if list[i].far - list[i].near > most {
            list.swap(long, i);
            long += 1;
        }
    }
    let rest = &mut list[long..];
    rest.sort_unstable_by(|a, b| a.near.total_cmp(&b.near).then(a.prim.cmp(&b.prim)));
    // Rounded up: a sum of it and `near` must not be below `far`.
    let reach = rest.iter().fold(0.0f32, |reach, r| reach.max(r.far - r.near)) * (1.0 + 1e-6) + 1e-6;
    (long, reach)
}
