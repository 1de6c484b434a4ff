//! The builder for meshes that are built anew every frame: Morton order, then splits where the highest bit changes.
//!
//! After Lauterbach et al., *Fast BVH Construction on GPUs* (2009), and Pantaleoni and Luebke, *HLBVH* (2010): triangles are sorted along
//! a space-filling curve by the bits of their box centre; a range of the sorted order is a cell of an implicit octree, and is
//! split at the first position whose code has the highest differing bit set. Three such splits give eight children,
//! so the wide node is built directly. Boxes are filled by the refit pass.
//!
//! Codes have 10 bits per axis, in a 64-bit word with the triangle's number below, sorted by a radix sort of 3 passes.
//! A mesh has more triangles in a finest cell than a leaf takes only where it is very uneven, such as a teapot in a stadium. Such a
//! cell gets a grid and codes of its own. Where centres coincide, ranges are halved by count.
//!
//! *Quality.* SAH cost 7 to 20 % above that of the SAH builder. *Cost.* 55–85 ns per triangle on a core where Embree's Morton builder takes 80–140. The first
//! build of 1.3 M triangles takes 95–110, as the system has to clear fresh memory: there Embree is faster. 28 bytes of scratch per triangle.

use super::Aabb;
use super::assemble::{Part, Piece, assemble};
use super::block_loader::{EachBox, TakeBox};
use super::bvh::{BLOCK, Bvh, OutOfMemory, WIDTH};
use super::memory::filled;
use super::refit::SweepScratch;
use crate::memory::{Room, collected, copied, emptied, repeated, vec_of};
use crate::scene::Mesh;
use crate::simd::{self, Kernel, Level};
use glam::{Vec3, Vec4};
use rayon::prelude::*;

/// Bits per axis.
const BITS: u32 = 10;
/// Ranges above are split off as tasks of their own.
const TASK: usize = 4096;
/// Triangles per chunk of the parallel passes.
const CHUNK: usize = 1 << 14;
/// Bits per pass of the radix sort: 3 passes, and a table that stays in the first-level cache.
const DIGIT: u32 = 10;

/// Fewer keys are sorted by comparing them.
const RADIX: usize = 4096;

/// Ranges up to this are left as leaves when a node has no lane to spare: a node for two blocks costs as much as a block.
const LEAF: usize = 2 * BLOCK;
/// Ranges up to this are split where it costs no block: a tenth of the memory for +1 % of cost. At 16: +3 %.
const FILL: usize = 2 * BLOCK;

/// Levels of the wide tree that may give a cell a grid of its own. With 30 levels for the bits of the last grid and 14 for halves, this stays
/// below [`super::MAX_DEPTH`].
const REFINE_DEPTH: usize = 18;

/// Code above, triangle number below.
type Key = u64;

/// What a build works with, kept for the next one.
#[derive(Debug, Default)]
pub(super) struct FastScratch {
    centers: Vec<Vec3>,
    keys: Vec<Key>,
    sorted: Vec<Key>,
    digits: Digits,
    sweeps: SweepScratch,
}

/// What the sort works in.
#[derive(Default)]
struct Digits {
    /// Per chunk of keys and bucket: how many there are.
    counts: Vec<u32>,
    /// Likewise: where the next one goes.
    places: Vec<std::slice::IterMut<'static, Key>>,
}

impl std::fmt::Debug for Digits {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "room for {} counts", self.counts.capacity())
    }
}

impl FastScratch {
    pub(super) fn memory_bytes(&self) -> usize {
        let Digits { counts, places } = &self.digits;
        self.centers.capacity() * size_of::<Vec3>()
            + (self.keys.capacity() + self.sorted.capacity()) * size_of::<Key>()
            + counts.capacity() * size_of::<u32>()
            + places.capacity() * size_of::<std::slice::IterMut<'static, Key>>()
            + self.sweeps.memory_bytes()
    }
}

/// Builds the tree of all usable triangles of `mesh`. To be called inside the pool.
pub fn build_fast(mesh: &Mesh) -> Result<Bvh, OutOfMemory> {
    rebuild_fast(mesh, Bvh::default(), &mut FastScratch::default())
}

/// Likewise, in the memory of a former tree.
pub(super) fn rebuild_fast(mesh: &Mesh, old: Bvh, scratch: &mut FastScratch) -> Result<Bvh, OutOfMemory> {
    let count = mesh.triangles.len();
    let level = Level::detect();
    let mut centers = filled(std::mem::take(&mut scratch.centers), count, Vec3::ZERO)?;
    let around = centers
        .par_chunks_mut(CHUNK)
        .enumerate()
        .map(|(chunk, centers)| {
            let begin = chunk * CHUNK;
            let prims = begin..begin + centers.len();
            let mut to = Collect { centers, next: 0, lo: Vec4::INFINITY, hi: Vec4::NEG_INFINITY };
            simd::run(level, EachBox { mesh, prims, to: &mut to });
            Aabb { lo: to.lo.truncate(), hi: to.hi.truncate() }
        })
        .reduce(|| Aabb::EMPTY, Aabb::union);
    if around.is_empty() {
        return Ok(Bvh::of_nothing(collected(0..count as u32)?, count));
    }

    let grid = Grid::around(&around).unwrap_or(Grid { origin: Vec4::ZERO, scale: Vec4::ZERO });
    let mut keys = filled(std::mem::take(&mut scratch.keys), count, 0)?;
    keys.par_chunks_mut(CHUNK).zip(centers.par_chunks(CHUNK)).enumerate().for_each(|(chunk, (keys, centers))| {
        simd::run(level, MakeKeys { grid: &grid, begin: chunk * CHUNK, centers, keys });
    });
    let unusable = |center: &Vec3| center.x.is_nan();
    let mut dropped = vec_of(centers.par_iter().filter(|center| unusable(center)).count())?;
    if dropped.capacity() > 0 {
        dropped.extend((0..).zip(&centers).filter(|(_, center)| unusable(center)).map(|(prim, _)| prim));
        keys.retain(|&key| !centers[key as u32 as usize].x.is_nan());
    }
    let sorted = filled(std::mem::take(&mut scratch.sorted), keys.len(), 0)?;
    let (mut keys, other) = radix_sort(keys, sorted, &mut scratch.digits)?;
    let part = Hierarchy { centers: &centers }.part(&mut keys, 0, 0)?;
    let bvh = assemble(part, |i| keys[i] as u32, dropped, mesh, old, &mut scratch.sweeps);
    (scratch.centers, scratch.keys, scratch.sorted) = (centers, keys, other);
    bvh
}

/// Writes the centres of triangles, NaN for unusable ones, and finds the box around them.
struct Collect<'a> {
    centers: &'a mut [Vec3],
    next: usize,
    lo: Vec4,
    hi: Vec4,
}

impl TakeBox for Collect<'_> {
    #[inline(always)]
    fn take(&mut self, lo: Vec4, hi: Vec4) {
        let center = lo * 0.5 + hi * 0.5;
        self.centers[self.next] = center.truncate();
        self.next += 1;
        // A NaN as the first operand gives the second.
        self.lo = center.min(self.lo);
        self.hi = center.max(self.hi);
    }
}

/// The cells of the finest level.
struct Grid {
    origin: Vec4,
    scale: Vec4,
}

impl Grid {
    /// Over centres in a box; none if they coincide (nearly, in the range of denormals).
    fn around(centers: &Aabb) -> Option<Self> {
        // One scale for all axes keeps the cells cubes; the curve then follows space, not the box.
        let extent = centers.extent().max_element();
        let scale = (1 << BITS) as f32 * 0.9999 / extent;
        (extent > 1e-30).then(|| Self { origin: centers.lo.extend(0.0), scale: Vec4::splat(scale) })
    }

    /// The Morton code of the cell that a centre lies in, in the place where keys have it.
    #[inline(always)]
    fn code(&self, center: Vec3) -> Key {
        // Rounds to an integer by way of the mantissa: vectorises, where a saturating cast does not.
        const MAGIC: f32 = (1 << 23) as f32;
        const LAST: u32 = (1 << BITS) - 1;
        let cell = (center.extend(0.0) - self.origin) * self.scale - Vec4::splat(0.499);
        // A NaN as the first operand gives the second.
        let cell = cell.max(Vec4::ZERO).min(Vec4::splat(LAST as f32)) + Vec4::splat(MAGIC);
        let [x, y, z, _] = cell.to_array().map(|c| spread3(c.to_bits() & LAST));
        u64::from(x << 2 | y << 1 | z) << 32
    }
}

struct MakeKeys<'a> {
    grid: &'a Grid,
    /// The number of the first triangle.
    begin: usize,
    centers: &'a [Vec3],
    keys: &'a mut [Key],
}

impl Kernel for MakeKeys<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (i, (key, center)) in self.keys.iter_mut().zip(self.centers).enumerate() {
            *key = self.grid.code(*center) | (self.begin + i) as u64;
        }
    }
}

/// Puts two zero bits between the ten lowest bits.
#[inline(always)]
fn spread3(x: u32) -> u32 {
    let x = (x | x << 16) & 0x0300_00ff;
    let x = (x | x << 8) & 0x0300_f00f;
    let x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}

/// Sorts keys by their codes; equal codes keep their order. `other` is as long, and is what is not returned first.
fn radix_sort(
    mut keys: Vec<Key>,
    mut other: Vec<Key>,
    digits: &mut Digits,
) -> Result<(Vec<Key>, Vec<Key>), OutOfMemory> {
    if keys.len() < RADIX {
        keys.sort_unstable();
        return Ok((keys, other));
    }
    for pass in 0..(3 * BITS).div_ceil(DIGIT) {
        radix_pass(&keys, &mut other, 32 + pass * DIGIT, digits)?;
        std::mem::swap(&mut keys, &mut other);
    }
    Ok((keys, other))
}

fn radix_pass(from: &[Key], to: &mut [Key], shift: u32, digits: &mut Digits) -> Result<(), OutOfMemory> {
    const BUCKETS: usize = 1 << DIGIT;
    let digit = |key: Key| (key >> shift) as usize & (BUCKETS - 1);
    // Few large chunks: each has a slice per bucket.
    let chunk = from.len().div_ceil(16).max(CHUNK);
    let lists = from.len().div_ceil(chunk) * BUCKETS;
    let Digits { counts, places } = digits;
    counts.clear();
    counts.room(lists)?;
    counts.resize(lists, 0);
    from.par_chunks(chunk).zip(counts.par_chunks_mut(BUCKETS)).for_each(|(keys, counts)| {
        for &key in keys {
            counts[digit(key)] += 1;
        }
    });
    let mut slices: Vec<std::slice::IterMut<'_, Key>> = emptied(std::mem::take(places));
    slices.room(lists)?;
    slices.resize_with(lists, Default::default);
    let mut rest = to;
    for bucket in 0..BUCKETS {
        for list in (bucket..lists).step_by(BUCKETS) {
            let (these, others) = rest.split_at_mut(counts[list] as usize);
            slices[list] = these.iter_mut();
            rest = others;
        }
    }
    from.par_chunks(chunk).zip(slices.par_chunks_mut(BUCKETS)).for_each(|(keys, slices)| {
        for &key in keys {
            *slices[digit(key)].next().expect("the digits were counted") = key;
        }
    });
    *places = emptied(slices);
    Ok(())
}

struct Hierarchy<'a> {
    centers: &'a [Vec3],
}

impl Hierarchy<'_> {
    /// Large ranges become branches with a task per child, others pieces.
    fn part(&self, keys: &mut [Key], start: usize, depth: usize) -> Result<Part, OutOfMemory> {
        if keys.len() <= LEAF {
            return Ok(Part::Leaf { start, count: keys.len() });
        }
        if keys.len() <= TASK {
            let mut piece = Piece::with_room_for(keys.len())?;
            self.node(&mut piece, keys, start, depth)?;
            return Ok(Part::Piece(piece));
        }
        let (borders, count) = self.split_wide(keys, depth)?;
        let mut tasks = vec_of(count)?;
        let mut rest = keys;
        for lane in 0..count {
            let (these, others) = rest.split_at_mut(borders[lane + 1] - borders[lane]);
            tasks.push((these, start + borders[lane]));
            rest = others;
        }
        Part::branch(tasks, |(keys, start)| self.part(keys, start, depth + 1))
    }

    /// Appends the node of a range and all below it. Every level consumes code bits or halves the count, and few levels
    /// make new codes, which bounds the recursion.
    fn node(&self, piece: &mut Piece, keys: &mut [Key], start: usize, depth: usize) -> Result<usize, OutOfMemory> {
        let node = piece.push_node()?;
        let (borders, count) = self.split_wide(keys, depth)?;
        for lane in 0..count {
            let (begin, end) = (borders[lane], borders[lane + 1]);
            if end - begin <= LEAF {
                piece.set_leaf(node, lane, start + begin, end - begin)?;
            } else {
                let below = self.node(piece, &mut keys[begin..end], start + begin, depth + 1)?;
                piece.set_node(node, lane, below);
            }
        }
        Ok(node)
    }

    /// Borders of up to eight children: the fullest part is split, as small ones are leaves soon anyway.
    fn split_wide(&self, keys: &mut [Key], depth: usize) -> Result<([usize; WIDTH + 1], usize), OutOfMemory> {
        let mut borders = [0; WIDTH + 1];
        borders[1] = keys.len();
        let mut count = 1;
        while count < WIDTH {
            // Of equal ones the first. One number to compare, since this is a tenth of the build.
            let order = |i: usize| (borders[i + 1] - borders[i]) * WIDTH + (WIDTH - 1 - i);
            let fullest = WIDTH - 1 - (0..count).map(order).fold(0, usize::max) % WIDTH;
            let (begin, end) = (borders[fullest], borders[fullest + 1]);
            if end - begin <= BLOCK {
                break;
            }
            let middle = begin + self.split(&mut keys[begin..end], depth)?;
            borders.copy_within(fullest + 1..=count, fullest + 2);
            borders[fullest + 1] = middle;
            count += 1;
        }
        Ok((borders, count))
    }

    /// The first key that has the highest differing bit set, or the middle when all codes are equal.
    fn split(&self, keys: &mut [Key], depth: usize) -> Result<usize, OutOfMemory> {
        let ends = |keys: &[Key]| (keys[0] >> 32, keys[keys.len() - 1] >> 32);
        let (mut first, mut last) = ends(keys);
        if first == last && keys.len() > LEAF && depth < REFINE_DEPTH {
            self.refine(keys)?;
            (first, last) = ends(keys);
        }
        if first == last {
            return Ok(keys.len() / 2);
        }
        let bit = 63 - (first ^ last).leading_zeros();
        let at = keys.partition_point(|key| key >> 32 >> bit & 1 == 0);
        Ok(if keys.len() > FILL { at } else { fill_blocks(keys.len(), at) })
    }

    /// Gives triangles of one cell codes in a grid of their own.
    #[cold]
    fn refine(&self, keys: &mut [Key]) -> Result<(), OutOfMemory> {
        let center = |key: Key| self.centers[key as u32 as usize];
        let around = keys.iter().fold(Aabb::EMPTY, |mut all, &key| {
            all.grow(center(key));
            all
        });
        let Some(grid) = Grid::around(&around) else { return Ok(()) };
        for key in keys.iter_mut() {
            *key = grid.code(center(*key)) | *key & u64::from(u32::MAX);
        }
        if keys.len() < RADIX {
            keys.sort_unstable();
            return Ok(());
        }
        let (sorted, _) = radix_sort(copied(keys)?, repeated(0, keys.len())?, &mut Digits::default())?;
        keys.copy_from_slice(&sorted);
        Ok(())
    }
}

/// The split nearest to `at` that costs no block: at a multiple of the block from either end.
fn fill_blocks(count: usize, at: usize) -> usize {
    let down = |x: usize| x / BLOCK * BLOCK;
    let up = |x: usize| x.next_multiple_of(BLOCK);
    let rest = count - at;
    [down(at), up(at), count - down(rest), count.saturating_sub(up(rest))]
        .into_iter()
        .filter(|&k| k > 0 && k < count)
        .min_by_key(|&k| k.abs_diff(at))
        .unwrap_or(at)
}
