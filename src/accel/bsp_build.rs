//! Building the object BSP: slowly for good trees, or fast for objects that are rebuilt every frame.
//!
//! *SAH* (static and affine objects; the "sophisticated and slow algorithms" that Wald03 §4.2 takes from Havran's thesis, 2001). The
//! plane with the least expected cost among the borders of [`BINS`] bins per axis, counting boxes exactly at each border;
//! planes that cut off empty space get a bonus. Splitting ends when no plane pays.
//!
//! *Fast* (unstructured motion, Wald03 §4.3). The plane in the middle of the longest side of what the cell holds, no cost function. The deeper the
//! cell, the more triangles it may keep: the threshold grows by [`FAST_GROWTH`] per level.
//!
//! Both are iterative, depth-first, with the references of the open cells on one stack, and both are bounded: in depth by
//! `8 + 1.3 log2 n` (Havran's rule), and in references by [`REFS_PER_TRIANGLE`] per triangle, so that 100,000
//! equal triangles cost linear time.
//!
//! *Cost.* n log n in practice: SAH 1 µs (beams), 1.6 (soup), 3.3 (a closed surface, of which it makes ten nodes per triangle); fast 0.2. Boxes travel with
//! their references, all axes of a border are evaluated as one vector, and references are divided without branches; a loop per axis over boxes
//! fetched by number took 2 to 3 times as long for the same trees. Most of what is left are the borders of nodes with few triangles.

use super::bsp::{BSP_MAX_DEPTH, BspNode, BspTree};
use super::build_sah::around;
use super::prim_ref::PrimRef;
use super::{Aabb, triangle_bounds};
use crate::simd::{self, Kernel, Level};
use glam::{Vec3, Vec4};

/// Which of the two builders.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quality {
    /// For objects that are built once.
    Sah,
    /// For objects that are built every frame.
    Fast,
}

/// Bins per axis; doubling them changes traversal by less than the noise and build time by a third.
const BINS: usize = 32;
/// Cost of passing a plane, when testing a triangle costs 1. A scalar triangle test is worth several planes.
const PLANE_COST: f32 = 0.3;
/// Share of the cost that a plane keeps which cuts off empty space (Havran 2001).
const EMPTY_BONUS: f32 = 0.8;
/// Cells with at most this many triangles are left whole.
const SAH_LEAF: usize = 2;
const FAST_LEAF: f32 = 3.0;
/// The constant factor of Wald03 §4.3; at depth 20 a leaf may hold 27.
const FAST_GROWTH: f32 = 1.12;
/// References of open cells and leaves together, per triangle.
const REFS_PER_TRIANGLE: usize = 12;
/// Splits in a row that leave a child with everything, before the fast build gives the cell up.
const FUTILE_SPLITS: u8 = 3;

/// A cell still to be split; its references are the topmost of the stack.
struct Open {
    node: usize,
    first_ref: usize,
    cell: Aabb,
    depth: usize,
    futile: u8,
}

/// The tree, or `None` when there is no memory for it.
pub(super) fn build(corners: &[[Vec3; 3]], bounds: Aabb, quality: Quality) -> Option<BspTree> {
    let n = corners.len();
    let level = Level::detect();
    let budget = n.checked_mul(REFS_PER_TRIANGLE)?.min(u32::MAX as usize);
    // Boxes travel with their numbers: read in a row, where boxes elsewhere would be fetched one by one.
    let mut open_refs: Vec<PrimRef> = Vec::new();
    open_refs.try_reserve(n).ok()?;
    open_refs.extend((0..n as u32).zip(corners).filter_map(|(prim, corners)| {
        let b = triangle_bounds(*corners);
        (!b.is_empty()).then(|| PrimRef::new(prim, b.lo.extend(0.0), b.hi.extend(0.0)))
    }));

    let max_depth = (8 + 13 * (n.max(1).ilog2() as usize + 1) / 10).min(BSP_MAX_DEPTH);
    let mut tree = BspTree::default();
    tree.nodes.push(BspNode::leaf(0, 0));
    let mut open = vec![Open { node: 0, first_ref: 0, cell: bounds, depth: 0, futile: 0 }];
    let mut lower: Vec<PrimRef> = Vec::new();

    while let Some(Open { node, first_ref, cell, depth, futile }) = open.pop() {
        let here = &mut open_refs[first_ref..];
        let count = here.len();
        let plane = if depth >= max_depth || tree.nodes.len() + 2 > BspNode::MAX_LINK {
            None
        } else {
            match quality {
                Quality::Sah => sah_plane(level, here, &cell),
                Quality::Fast => fast_plane(here, &cell, depth),
            }
        };
        let room = budget.saturating_sub(first_ref + count + tree.refs.len());
        let (mut futile_here, mut below_count) = (0, 0);
        let split = plane.filter(|&(axis, plane)| {
            let (below, above) = simd::run(level, Count { refs: here, axis, plane });
            let is_futile = below.max(above) == count && below.min(above) > 0;
            (futile_here, below_count) = (if is_futile { futile + 1 } else { 0 }, below);
            below + above - count <= room && futile_here < FUTILE_SPLITS
        });
        let Some((axis, plane)) = split else {
            tree.refs.try_reserve(count).ok()?;
            tree.nodes[node] = BspNode::leaf(tree.refs.len(), count);
            tree.refs.extend(here.iter().map(PrimRef::prim));
            open_refs.truncate(first_ref);
            continue;
        };

        let children = tree.nodes.len();
        tree.nodes.try_reserve(2).ok()?;
        tree.nodes[node] = BspNode::inner(axis, plane, children);
        tree.nodes.extend([BspNode::leaf(0, 0); 2]);
        if lower.len() < count {
            lower.try_reserve(count - lower.len()).ok()?;
            lower.resize(count, PrimRef::EMPTY);
        }
        let above = simd::run(level, Divide { refs: here, lower: &mut lower, axis, plane });
        open_refs.truncate(first_ref + above);
        open_refs.try_reserve(below_count).ok()?;
        // The lower child is handled next, so it comes to lie on top.
        open_refs.extend_from_slice(&lower[..below_count]);
        let (mut below, mut above_cell) = (cell, cell);
        below.hi[axis] = plane;
        above_cell.lo[axis] = plane;
        let (depth, futile) = (depth + 1, futile_here);
        open.push(Open { node: children + 1, first_ref, cell: above_cell, depth, futile });
        open.push(Open { node: children, first_ref: first_ref + above, cell: below, depth, futile });
    }
    tree.nodes.shrink_to_fit();
    tree.refs.shrink_to_fit();
    Some(tree)
}

// Boxes are never flat, so each goes at least one way. Touching the plane is not reaching beyond it: such a box has its interval on its own side
// of the plane's distance.

/// How many boxes reach below the plane, and how many above it.
struct Count<'a> {
    refs: &'a [PrimRef],
    axis: usize,
    plane: f32,
}

impl Kernel for Count<'_> {
    type Output = (usize, usize);

    #[inline(always)]
    fn run(self) -> (usize, usize) {
        let plane = Vec4::splat(self.plane);
        let (mut below, mut above) = (0, 0);
        for r in self.refs {
            below += (r.bounds().lo().cmplt(plane).bitmask() >> self.axis & 1) as usize;
            above += (r.bounds().hi().cmpgt(plane).bitmask() >> self.axis & 1) as usize;
        }
        (below, above)
    }
}

/// Leaves the boxes that reach above the plane, in their order, and copies those that reach below it. Without branches: which way a box
/// goes is hard to predict. Returns how many are left.
struct Divide<'a> {
    refs: &'a mut [PrimRef],
    lower: &'a mut [PrimRef],
    axis: usize,
    plane: f32,
}

impl Kernel for Divide<'_> {
    type Output = usize;

    #[inline(always)]
    fn run(self) -> usize {
        let Self { refs, lower, axis, plane } = self;
        let plane = Vec4::splat(plane);
        let (mut below, mut above) = (0, 0);
        for i in 0..refs.len() {
            let r = refs[i];
            refs[above] = r;
            lower[below] = r;
            below += (r.bounds().lo().cmplt(plane).bitmask() >> axis & 1) as usize;
            above += (r.bounds().hi().cmpgt(plane).bitmask() >> axis & 1) as usize;
        }
        above
    }
}

/// The plane of least cost, if splitting pays at all.
fn sah_plane(level: Level, refs: &[PrimRef], cell: &Aabb) -> Option<(usize, f32)> {
    let area = cell.half_area();
    if refs.len() <= SAH_LEAF || !(area > 0.0 && area.is_finite()) {
        return None;
    }
    simd::run(level, Cheapest { refs, cell, area })
}

/// Counts all boxes into the bins of all axes at once, then looks at the borders of all axes at once.
struct Cheapest<'a> {
    refs: &'a [PrimRef],
    cell: &'a Aabb,
    area: f32,
}

/// Rounds to an integer by way of the mantissa: vectorises, where a saturating cast does not.
const MAGIC: f32 = (1 << 23) as f32;

impl Kernel for Cheapest<'_> {
    type Output = Option<(usize, f32)>;

    #[inline(always)]
    fn run(self) -> Option<(usize, f32)> {
        let Self { refs, cell, area } = self;
        let (lo, hi) = (cell.lo.extend(0.0), cell.hi.extend(0.0));
        let extent = hi - lo;
        let width = extent / BINS as f32;
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
        for r in refs {
            let (first, last) = (bins(r.bounds().lo()), bins(r.bounds().hi()));
            for k in 0..3 {
                begins[first[k]][k] += 1;
                ends[last[k]][k] += 1;
            }
        }
        let count = refs.len() as u32;
        let [x, y, z, _] = extent.to_array();
        let cap = Vec4::new(y * z, z * x, x * y, 0.0);
        let ring = Vec4::new(y + z, z + x, x + y, 0.0);
        let inv_area = Vec4::splat(1.0 / area);
        let (mut below, mut above) = ([0u32; 4], [count; 4]);
        let (mut least, mut at) = (Vec4::INFINITY, Vec4::ZERO);
        for bin in 1..BINS {
            for k in 0..4 {
                below[k] += begins[bin - 1][k];
                above[k] -= ends[bin - 1][k];
            }
            let number = |counts: [u32; 4]| Vec4::from_array(counts.map(|x| x as i32 as f32));
            let (n_below, n_above) = (number(below), number(above));
            let plane = lo + width * bin as f32;
            let tests = ((cap + ring * (plane - lo)) * n_below + (cap + ring * (hi - plane)) * n_above) * inv_area;
            let is_empty = n_below.cmpeq(Vec4::ZERO) | n_above.cmpeq(Vec4::ZERO);
            let bonus = Vec4::select(is_empty, Vec4::splat(EMPTY_BONUS), Vec4::ONE);
            let cost = bonus * tests + Vec4::splat(PLANE_COST);
            // The fourth lane is flat.
            let better = cost.cmplt(least) & plane.cmpgt(lo) & plane.cmplt(hi);
            least = Vec4::select(better, cost, least);
            at = Vec4::select(better, plane, at);
        }
        // Without a split every triangle is tested.
        let mut best = (count as f32, None);
        for axis in 0..3 {
            if least[axis] < best.0 {
                best = (least[axis], Some((axis, at[axis])));
            }
        }
        best.1
    }
}

/// The middle of the longest side of what the cell holds, unless it holds little for its depth.
fn fast_plane(refs: &[PrimRef], cell: &Aabb, depth: usize) -> Option<(usize, f32)> {
    if refs.len() as f32 <= FAST_LEAF * FAST_GROWTH.powi(depth as i32) {
        return None;
    }
    let all = around(refs);
    let held = Aabb { lo: all.lo().truncate(), hi: all.hi().truncate() }.intersection(*cell);
    let extent = held.extent();
    let axis = (0..3).fold(0, |best, axis| if extent[axis] > extent[best] { axis } else { best });
    let plane = held.center()[axis];
    (plane > held.lo[axis] && plane < held.hi[axis]).then_some((axis, plane))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn soup(n: usize) -> Vec<[Vec3; 3]> {
        let mut state = 1u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        (0..n)
            .map(|_| {
                let p = Vec3::new(next(), next(), next());
                [p, p + 0.05 * Vec3::new(next(), next(), next()), p + 0.05 * Vec3::new(next(), next(), next())]
            })
            .collect()
    }

    fn bounds_of(corners: &[[Vec3; 3]]) -> Aabb {
        corners.iter().fold(Aabb::EMPTY, |b, c| b.union(triangle_bounds(*c)))
    }

    /// Every triangle lies in every leaf that its box reaches into, walking all cells; returns the largest leaf and the depth.
    fn check(corners: &[[Vec3; 3]], tree: &BspTree) -> (usize, usize) {
        let mut stack = vec![(0usize, bounds_of(corners), 0usize)];
        let (mut largest, mut deepest, mut leaves) = (0, 0, 0);
        while let Some((node, cell, depth)) = stack.pop() {
            let node = tree.nodes[node];
            deepest = deepest.max(depth);
            if node.is_leaf() {
                leaves += 1;
                let refs = &tree.refs[node.refs()];
                largest = largest.max(refs.len());
                for (prim, c) in corners.iter().enumerate() {
                    let b = triangle_bounds(*c);
                    let inside = (0..3).all(|k| b.lo[k] < cell.hi[k] && b.hi[k] > cell.lo[k]);
                    assert_eq!(inside, refs.contains(&(prim as u32)), "triangle {prim}, cell {cell:?}");
                }
            } else {
                let (mut below, mut above) = (cell, cell);
                below.hi[node.axis()] = node.plane();
                above.lo[node.axis()] = node.plane();
                stack.push((node.lower() as usize, below, depth + 1));
                stack.push((node.lower() as usize + 1, above, depth + 1));
            }
        }
        assert_eq!(tree.nodes.len(), 2 * leaves - 1);
        (largest, deepest)
    }

    #[test]
    fn cells_reference_what_reaches_into_them() {
        let corners = soup(500);
        for quality in [Quality::Sah, Quality::Fast] {
            let tree = build(&corners, bounds_of(&corners), quality).expect("memory");
            let (largest, depth) = check(&corners, &tree);
            assert!(largest <= 60 && depth > 4, "{quality:?}: leaf of {largest}, depth {depth}");
        }
    }

    #[test]
    fn fast_leaves_may_be_larger() {
        let corners = soup(4000);
        let leaves = |quality| {
            let tree = build(&corners, bounds_of(&corners), quality).expect("memory");
            (tree.nodes.len(), tree.refs.len())
        };
        let (sah, fast) = (leaves(Quality::Sah), leaves(Quality::Fast));
        assert!(fast.0 < sah.0, "fast {fast:?}, SAH {sah:?}");
    }

    #[test]
    fn degenerate_input_stays_linear() {
        let same = vec![[Vec3::ZERO, Vec3::X, Vec3::Y]; 100_000];
        let mut fan = soup(50_000);
        for c in &mut fan {
            c[0] = Vec3::splat(0.5);
        }
        let nothing = vec![[Vec3::NAN; 3]; 1000];
        for quality in [Quality::Sah, Quality::Fast] {
            for corners in [&same, &fan, &nothing, &Vec::new()] {
                let tree = build(corners, bounds_of(corners), quality).expect("memory");
                assert!(tree.refs.len() <= REFS_PER_TRIANGLE * corners.len());
                assert!(tree.nodes.len() <= 8 * corners.len() + 1, "{} nodes", tree.nodes.len());
            }
        }
    }
}
