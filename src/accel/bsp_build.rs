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
//! equal triangles cost linear time. Cost: n log n in practice.

use super::bsp::{BSP_MAX_DEPTH, BspNode, BspTree};
use super::{Aabb, triangle_bounds};
use glam::Vec3;

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
    let budget = n.checked_mul(REFS_PER_TRIANGLE)?.min(u32::MAX as usize);
    let mut boxes = Vec::new();
    boxes.try_reserve_exact(n).ok()?;
    boxes.extend(corners.iter().map(|c| triangle_bounds(*c)));
    let mut open_refs: Vec<u32> = Vec::new();
    open_refs.try_reserve(n).ok()?;
    open_refs.extend((0..n as u32).filter(|&prim| !boxes[prim as usize].is_empty()));

    let max_depth = (8 + 13 * (n.max(1).ilog2() as usize + 1) / 10).min(BSP_MAX_DEPTH);
    let mut tree = BspTree::default();
    tree.nodes.push(BspNode::leaf(0, 0));
    let mut open = vec![Open { node: 0, first_ref: 0, cell: bounds, depth: 0, futile: 0 }];
    let (mut lower, mut upper) = (Vec::new(), Vec::new());

    while let Some(Open { node, first_ref, cell, depth, futile }) = open.pop() {
        let here = &open_refs[first_ref..];
        let count = here.len();
        let room = budget.saturating_sub(open_refs.len() + tree.refs.len());
        let plane = if depth >= max_depth || tree.nodes.len() + 2 > BspNode::MAX_LINK {
            None
        } else {
            match quality {
                Quality::Sah => sah_plane(&boxes, here, &cell),
                Quality::Fast => fast_plane(&boxes, here, &cell, depth),
            }
        };
        let split = plane.filter(|&(axis, plane)| {
            lower.clear();
            upper.clear();
            // Boxes are never flat, so each goes at least one way. Touching the plane is not reaching beyond it:
            // such a box has its interval on its own side of the plane's distance.
            lower.try_reserve(count).is_ok() && upper.try_reserve(count).is_ok() && {
                for &prim in here {
                    let b = &boxes[prim as usize];
                    if b.lo[axis] < plane {
                        lower.push(prim);
                    }
                    if b.hi[axis] > plane {
                        upper.push(prim);
                    }
                }
                lower.len() + upper.len() - count <= room
            }
        });
        let is_futile = lower.len().max(upper.len()) == count && lower.len().min(upper.len()) > 0;
        let futile = if is_futile { futile + 1 } else { 0 };
        let Some((axis, plane)) = split.filter(|_| futile < FUTILE_SPLITS) else {
            tree.refs.try_reserve(count).ok()?;
            tree.nodes[node] = BspNode::leaf(tree.refs.len(), count);
            tree.refs.extend_from_slice(here);
            open_refs.truncate(first_ref);
            continue;
        };

        let children = tree.nodes.len();
        tree.nodes.try_reserve(2).ok()?;
        tree.nodes[node] = BspNode::inner(axis, plane, children);
        tree.nodes.extend([BspNode::leaf(0, 0); 2]);
        open_refs.truncate(first_ref);
        open_refs.try_reserve(lower.len() + upper.len()).ok()?;
        // The lower child is handled next, so it comes to lie on top.
        open_refs.extend_from_slice(&upper);
        let first_lower = open_refs.len();
        open_refs.extend_from_slice(&lower);
        let (mut below, mut above) = (cell, cell);
        below.hi[axis] = plane;
        above.lo[axis] = plane;
        open.push(Open { node: children + 1, first_ref, cell: above, depth: depth + 1, futile });
        open.push(Open { node: children, first_ref: first_lower, cell: below, depth: depth + 1, futile });
    }
    tree.nodes.shrink_to_fit();
    tree.refs.shrink_to_fit();
    Some(tree)
}

/// The plane of least cost, if splitting pays at all.
fn sah_plane(boxes: &[Aabb], refs: &[u32], cell: &Aabb) -> Option<(usize, f32)> {
    let count = refs.len();
    if count <= SAH_LEAF {
        return None;
    }
    let extent = cell.extent();
    let area = cell.half_area();
    if !(area > 0.0 && area.is_finite()) {
        return None;
    }
    // Without a split every triangle is tested.
    let mut best = (count as f32, None);
    for axis in 0..3 {
        let (lo, width) = (cell.lo[axis], extent[axis] / BINS as f32);
        if !(width > 0.0) {
            continue;
        }
        let border = |bin: usize| lo + width * bin as f32;
        // `begins[b]`: boxes whose lower side lies between borders b - 1 and b; `ends[b]`: the same of upper sides. Rounding may
        // count a box one bin off; that only makes the estimate worse, the split itself compares exactly.
        let mut begins = [0u32; BINS + 1];
        let mut ends = [0u32; BINS + 1];
        let scale = 1.0 / width;
        for &prim in refs {
            let b = &boxes[prim as usize];
            let first = (((b.lo[axis] - lo) * scale) as usize).min(BINS - 1) + 1;
            let last = (((b.hi[axis] - lo) * scale) as usize).min(BINS - 1) + 1;
            begins[first] += 1;
            ends[last] += 1;
        }
        let rest = [extent[(axis + 1) % 3], extent[(axis + 2) % 3]];
        let (cap, ring) = (rest[0] * rest[1], rest[0] + rest[1]);
        let (mut below, mut above) = (0, count as u32);
        for bin in 1..BINS {
            below += begins[bin];
            above -= ends[bin];
            let plane = border(bin);
            if !(plane > cell.lo[axis] && plane < cell.hi[axis]) {
                continue;
            }
            let side = |length: f32| cap + ring * length;
            let (area_below, area_above) = (side(plane - cell.lo[axis]), side(cell.hi[axis] - plane));
            let tests = (area_below * below as f32 + area_above * above as f32) / area;
            let bonus = if below == 0 || above == 0 { EMPTY_BONUS } else { 1.0 };
            let cost = PLANE_COST + bonus * tests;
            if cost < best.0 {
                best = (cost, Some((axis, plane)));
            }
        }
    }
    best.1
}

/// The middle of the longest side of what the cell holds, unless it holds little for its depth.
fn fast_plane(boxes: &[Aabb], refs: &[u32], cell: &Aabb, depth: usize) -> Option<(usize, f32)> {
    if refs.len() as f32 <= FAST_LEAF * FAST_GROWTH.powi(depth as i32) {
        return None;
    }
    let held = refs.iter().fold(Aabb::EMPTY, |all, &prim| all.union(boxes[prim as usize])).intersection(*cell);
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
