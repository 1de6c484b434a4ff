//! One ray through a uniform grid.
//!
//! ```text
//! major = the axis along which the ray meets most planes
//! for every slice of cells between two planes of it, in the ray's order:
//!     the ray's interval in the slice → ranges of cells on both other axes → the triangles of these cells
//!     stop when the slice begins beyond the best hit
//! ```
//!
//! The usual walk from cell to cell (Amanatides and Woo 1987) decides at every step which of three planes comes first. Where two are
//! equally far but for rounding it may go round a cell on the wrong side. Here only intervals are compared, with
//! the padding of [`super::traverse_bsp`], by the same argument: let `t` be the hit that wins, already clamped to the box of its triangle.
//! On each axis this box touches the cells `a..=b` in the ray's order. It lies wholly beyond plane `a` and before plane `b + 1` (unless
//! these are the outermost ones, which are not asked), so `distance(a) <= t <= distance(b + 1) * SLAB_PAD`.
//!
//! * On the major axis there is thus a slice `a <= i <= b` with `distance(i) <= t <= distance(i + 1) * SLAB_PAD`: it is visited with an
//!   interval that contains `t`. A slice is the last one only if the next begins beyond the best hit: equal distances are still compared by number.
//! * On another axis the range goes from the first cell with `distance(j + 1) * SLAB_PAD >= begin` to the last with `distance(j) <= end`. As `begin <= t <=
//!   end`, it reaches from at most `b` to at least `a`.
//!
//! A triangle in several cells is tested in each.

use super::{Hit, PreparedRay, SLAB_PAD, triangle};
use crate::accel::Grid;

/// The planes of one axis in the order in which the ray meets them.
#[derive(Clone, Copy)]
struct Axis<'a> {
    planes: &'a [f32],
    org: f32,
    inv_dir: f32,
    cells: usize,
}

impl<'a> Axis<'a> {
    #[inline(always)]
    fn new(grid: &'a Grid, ray: &PreparedRay, axis: usize) -> Self {
        let planes = grid.planes(axis);
        Self { planes, org: ray.org[axis], inv_dir: ray.inv_dir[axis], cells: planes.len() - 1 }
    }

    /// Where the ray meets the plane before cell `i`. The outermost planes do not limit anything.
    #[inline(always)]
    fn distance(&self, i: usize) -> f32 {
        if i == 0 {
            return f32::NEG_INFINITY;
        }
        if i == self.cells {
            return f32::INFINITY;
        }
        let plane = self.planes[if self.inv_dir < 0.0 { self.cells - i } else { i }];
        (plane - self.org) * self.inv_dir
    }

    /// The number of a cell in the grid.
    #[inline(always)]
    fn cell(&self, i: usize) -> usize {
        if self.inv_dir < 0.0 { self.cells - 1 - i } else { i }
    }
}

/// Cells of another axis that the ray may be in; both ends only grow.
#[derive(Clone, Copy, Default)]
struct Reach {
    first: usize,
    last: usize,
}

impl Reach {
    #[inline(always)]
    fn follow(&mut self, axis: &Axis, begin: f32, end: f32) {
        while self.first + 1 < axis.cells && axis.distance(self.first + 1) * SLAB_PAD < begin {
            self.first += 1;
        }
        while self.last + 1 < axis.cells && axis.distance(self.last + 1) <= end {
            self.last += 1;
        }
    }
}

/// The closest hit, by the contract of [`super::Kernels::intersect`].
pub(super) fn intersect(grid: &Grid, ray: &PreparedRay, object: u32, instance: u32, best: &mut Hit) -> bool {
    traverse::<false>(grid, ray, object, instance, best)
}

/// Whether there is any hit, by the contract of [`super::Kernels::occluded`].
pub(super) fn occluded(grid: &Grid, ray: &PreparedRay) -> bool {
    traverse::<true>(grid, ray, 0, 0, &mut Hit::none(ray.tmax))
}

fn traverse<const ANY: bool>(grid: &Grid, ray: &PreparedRay, object: u32, instance: u32, best: &mut Hit) -> bool {
    let bounds = grid.bounds();
    let (enter, exit) = ray.slab(&bounds);
    let enter = if ray.tmin > enter { ray.tmin } else { enter };
    let limit = if best.t < exit { best.t } else { exit } * SLAB_PAD;
    // Written so that an empty object's NaN or infinities fail.
    if bounds.is_empty() || !(enter <= limit) {
        return false;
    }
    let extent = bounds.extent();
    // Planes met per distance; an axis with one cell has none.
    let rate = |axis: usize| match grid.planes(axis).len() - 2 {
        0 => 0.0,
        inner => inner as f32 * ray.dir[axis].abs() / extent[axis],
    };
    let major = (1..3).fold(0, |major, axis| if rate(axis) > rate(major) { axis } else { major });
    let others = [(major + 1) % 3, (major + 2) % 3];
    let slices = Axis::new(grid, ray, major);
    let axes = others.map(|axis| Axis::new(grid, ray, axis));
    let mut reach = [Reach::default(); 2];
    let corners = grid.corners();
    let mut found = false;
    for slice in 0..slices.cells {
        let begin = slices.distance(slice);
        if begin > best.t || begin > limit {
            break;
        }
        let begin = if enter > begin { enter } else { begin };
        let end = slices.distance(slice + 1) * SLAB_PAD;
        if end < begin {
            continue;
        }
        let end = if limit < end { limit } else { end };
        for (reach, axis) in reach.iter_mut().zip(&axes) {
            reach.follow(axis, begin, end);
        }
        for i in reach[0].first..=reach[0].last {
            for j in reach[1].first..=reach[1].last {
                let mut cell = [0; 3];
                cell[major] = slices.cell(slice);
                cell[others[0]] = axes[0].cell(i);
                cell[others[1]] = axes[1].cell(j);
                for prim in grid.refs(cell) {
                    let Some(h) = triangle::intersect(ray, corners[prim as usize]) else { continue };
                    if ANY {
                        return true;
                    }
                    if ray.excludes(h.t, instance, prim) {
                        continue;
                    }
                    let hit = Hit { t: h.t, u: h.u, v: h.v, prim, object, instance };
                    found |= hit.replaces(best);
                }
            }
        }
    }
    found
}
