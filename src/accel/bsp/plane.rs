//! Where to split a cell.
//!
//! *Careful* (static and affine objects; the "sophisticated and slow algorithms" that Wald03 §4.2 takes from Havran's thesis, 2001). The
//! plane with the least expected cost among the borders of bins over what the cell holds, the outermost included: those cut off empty space, for which
//! there is a bonus. A leaf costs by its blocks of four triangles.
//!
//! *Fast* (unstructured motion, Wald03 §4.3: "less expensive, simple heuristics"). The same with fewer bins and a sample of the triangles, for cells
//! with more triangles than the threshold, which grows by [`FAST_GROWTH`] per level. A sample costs the same in every cell, so that the time goes
//! to dividing. The middle of the longest side, which costs nothing, makes trees that take 3 to 20 times as long to trace, and 446 nodes per ray for 40 where a mesh is
//! dense in one place.

use super::node::tagged;
use crate::accel::Aabb;
use crate::accel::bvh::BLOCK;
use crate::accel::prim_ref::{Box4, PrimRef};
use crate::simd::{self, Kernel, Level};
use glam::Vec4;

/// Bins per axis; twice as many change traversal by less than the noise.
const BINS: usize = 32;
const FAST_BINS: usize = 16;
/// Cost of passing a plane, and of testing a block of [`BLOCK`] triangles. A lower one for planes makes trees of twice the size for the same time per ray.
const PLANE_COST: f32 = 2.0;
const BLOCK_COST: f32 = 3.0;
/// Share of the cost that a plane keeps which cuts off empty space (Havran 2001).
const EMPTY_BONUS: f32 = 0.8;
/// Triangles that a fast build looks at for a plane.
const SAMPLE: usize = 64;
/// Triangles that a fast build leaves in the root, and the constant factor of Wald03 §4.3 by which it is more at each level: 21 at depth 20.
const FAST_LEAF: f32 = 8.0;
const FAST_GROWTH: f32 = 1.05;

/// The plane of least cost, if splitting pays at all.
pub(super) fn careful(level: Level, refs: &[PrimRef], cell: &Aabb) -> Option<(usize, f32)> {
    cheapest::<BINS>(level, refs, 1, cell)
}

/// A good plane, unless the cell holds little for its depth. Whether it was chosen from a sample comes with it: what all triangles say is
/// asked for by `thorough`.
pub(super) fn fast(
    level: Level,
    refs: &[PrimRef],
    cell: &Aabb,
    depth: usize,
    thorough: bool,
) -> Option<((usize, f32), bool)> {
    if refs.len() <= fast_leaf(depth) {
        return None;
    }
    let stride = if thorough { 1 } else { refs.len().div_ceil(SAMPLE) };
    Some((cheapest::<FAST_BINS>(level, refs, stride, cell)?, stride > 1))
}

/// Triangles that a fast build leaves together at a depth.
pub(super) fn fast_leaf(depth: usize) -> usize {
    (FAST_LEAF * FAST_GROWTH.powi(depth as i32)) as usize
}

fn cheapest<const BINS: usize>(level: Level, refs: &[PrimRef], stride: usize, cell: &Aabb) -> Option<(usize, f32)> {
    if refs.is_empty() {
        return None;
    }
    let border = simd::run(level, Cheapest::<BINS> { refs, stride, cell })?;
    let Border { axis, plane, up } = border;
    // Triangles beside empty space must not reach into it for the digits of the axis.
    [up, !up]
        .map(|up| tagged(plane, axis, up))
        .into_iter()
        .find(|plane| cell.lo[axis] < *plane && *plane < cell.hi[axis])
        .map(|plane| (axis, plane))
}

/// A plane, and where it may be moved to.
struct Border {
    axis: usize,
    plane: f32,
    up: bool,
}

/// Counts boxes into the bins of all axes at once, then looks at the borders of all axes at once.
struct Cheapest<'a, const BINS: usize> {
    refs: &'a [PrimRef],
    /// Every so many of them are looked at.
    stride: usize,
    cell: &'a Aabb,
}

/// Rounds to an integer by way of the mantissa: vectorises, where a saturating cast does not.
const MAGIC: f32 = (1 << 23) as f32;

impl<const BINS: usize> Kernel for Cheapest<'_, BINS> {
    type Output = Option<Border>;

    #[inline(always)]
    fn run(self) -> Option<Border> {
        let Self { refs, stride, cell } = self;
        let sample = || refs.iter().step_by(stride);
        let count = refs.len().div_ceil(stride) as u32;
        let mut held = Box4::EMPTY;
        sample().for_each(|r| held.grow(r.bounds()));
        let cell = Box4::new(cell.lo.extend(0.0), cell.hi.extend(0.0));
        let held = held.intersection(&cell);
        let (lo, width) = (held.lo(), held.extent() / BINS as f32);
        // An infinite scale would make bins of NaN.
        let scale = Vec4::select(width.cmpgt(Vec4::ZERO), width.recip(), Vec4::ZERO).min(Vec4::splat(f32::MAX));
        let last = Vec4::splat((BINS - 1) as f32);
        let bins = |corner: Vec4| {
            let position = ((corner - lo) * scale - Vec4::splat(0.499)).max(Vec4::ZERO).min(last);
            (position + Vec4::splat(MAGIC)).to_array().map(|x| x.to_bits() as usize & (BINS - 1))
        };
        // `begins[b][k]`: boxes whose lower side lies in bin b of axis k; `ends`: the same of upper sides. Rounding may count a box one bin
        // off; that only makes the estimate worse, the split itself compares exactly.
        let mut begins = [[0u32; 4]; BINS];
        let mut ends = [[0u32; 4]; BINS];
        for r in sample() {
            let (first, last) = (bins(r.bounds().lo()), bins(r.bounds().hi()));
            for k in 0..3 {
                begins[first[k]][k] += 1;
                ends[last[k]][k] += 1;
            }
        }
        // Sides relative to the longest one, so that areas of tiny and of huge cells are numbers as good as any.
        let extent = cell.extent();
        let longest = Vec4::splat(extent.truncate().max_element());
        let sides = extent / longest;
        let [x, y, z, _] = sides.to_array();
        let cap = Vec4::new(y * z, z * x, x * y, 0.0);
        let ring = Vec4::new(y + z, z + x, x + y, 0.0);
        let area = x * y + (y * z + z * x);
        // Written so that NaN fails.
        if !(area > 0.0) {
            return None;
        }
        let inv_area = Vec4::splat(1.0 / area);
        let weight = Vec4::splat(stride as f32 * (BLOCK_COST / BLOCK as f32));
        let (mut below, mut above) = ([0u32; 4], [count; 4]);
        let (mut least, mut at, mut border) = (Vec4::INFINITY, Vec4::ZERO, Vec4::ZERO);
        for bin in 0..=BINS {
            if bin > 0 {
                for k in 0..4 {
                    below[k] += begins[bin - 1][k];
                    above[k] -= ends[bin - 1][k];
                }
            }
            let number = |counts: [u32; 4]| Vec4::from_array(counts.map(|x| x as i32 as f32));
            let (n_below, n_above) = (number(below), number(above));
            let plane = if bin == BINS { held.hi() } else { lo + width * bin as f32 };
            let (no_below, no_above) = (n_below.cmpeq(Vec4::ZERO), n_above.cmpeq(Vec4::ZERO));
            // Half a block is empty, on average.
            let half = |none| Vec4::select(none, Vec4::ZERO, Vec4::splat(BLOCK_COST * 0.5));
            let (from_lo, from_hi) = ((plane - cell.lo()) / longest, (cell.hi() - plane) / longest);
            let tests = ((cap + ring * from_lo) * (n_below * weight + half(no_below))
                + (cap + ring * from_hi) * (n_above * weight + half(no_above)))
                * inv_area;
            let bonus = Vec4::select(no_below | no_above, Vec4::splat(EMPTY_BONUS), Vec4::ONE);
            let cost = bonus * tests + Vec4::splat(PLANE_COST);
            let inside = plane.cmpgt(cell.lo()) & plane.cmplt(cell.hi());
            let better = cost.cmplt(least) & inside;
            least = Vec4::select(better, cost, least);
            at = Vec4::select(better, plane, at);
            border = Vec4::select(better, Vec4::splat(bin as f32), border);
        }
        // Without a split every block is tested.
        let mut best = (refs.len().div_ceil(BLOCK) as f32 * BLOCK_COST, None);
        for axis in 0..3 {
            if least[axis] < best.0 {
                let up = border[axis] == BINS as f32;
                best = (least[axis], Some(Border { axis, plane: at[axis], up }));
            }
        }
        best.1
    }
}
