//! One ray through a grid that is so far from its origin, or so fine, that rounding takes several planes of an axis for equally far.
//!
//! ```text
//! for every slice of cells of the first axis that the ray is in: for every row: for every cell:
//!     the intervals in which it is in the slice, the row and the cell have something in common → visit
//! ```
//!
//! Only intervals are compared, with the padding of the slab test, by the argument of [`super::traverse_grid`]. In no particular order, so all
//! cells on the way are visited. Rare: the origin is tens of thousands of cells away.

use super::traverse_grid::{Axis, meet};
use super::{Hit, PreparedRay, SLAB_PAD, triangle};
use crate::accel::{Grid, Lattice};

/// [`super::traverse_grid::traverse`], by this walk.
#[cold]
#[inline(never)]
pub(super) fn traverse_far<const ANY: bool>(
    grid: &Grid,
    ray: &PreparedRay,
    (object, instance): (u32, u32),
    best: &mut Hit,
) -> bool {
    let Some(top) = grid.top() else { return false };
    let mut found = false;
    let mut limit = best.t;
    for_each_cell(top, ray, limit, |number| {
        let cell = &grid.cells()[number];
        limit = best.t;
        for_each_cell(&cell.lattice, ray, limit, |below| {
            for &index in grid.refs(cell, below) {
                let triangle = &grid.triangles()[index as usize];
                let Some(h) = triangle::intersect(ray, triangle.corners()) else { continue };
                if ANY {
                    found = true;
                    return true;
                }
                if ray.excludes(h.t, instance, triangle.prim()) {
                    continue;
                }
                found |= Hit { t: h.t, u: h.u, v: h.v, primitive: triangle.prim(), object, instance }.replaces(best);
            }
            false
        })
    });
    found
}

/// Calls `visit` with the cells of a lattice that the ray meets before `limit`, until that says that it is enough. Returns whether it did.
fn for_each_cell(lattice: &Lattice, ray: &PreparedRay, limit: f32, mut visit: impl FnMut(usize) -> bool) -> bool {
    let Some(whole) = meet(lattice, ray, limit) else { return false };
    let step = lattice.step();
    let [x, y, z] = [0, 1, 2].map(|axis| Axis::new(lattice, step, ray, axis));
    for i in x.first(whole.0, 0.0)..x.cells {
        let Some(slice) = cut(&x, i, whole) else { break };
        for j in y.first(slice.0, 0.0)..y.cells {
            let Some(row) = cut(&y, j, slice) else { break };
            for k in z.first(row.0, 0.0)..z.cells {
                if cut(&z, k, row).is_none() {
                    break;
                }
                if visit(lattice.number([x.cell(i), y.cell(j), z.cell(k)])) {
                    return true;
                }
            }
        }
    }
    false
}

/// The part of an interval in which a ray is in cell `i` of an axis, which it has not left before.
fn cut(axis: &Axis, i: usize, (enter, exit): (f32, f32)) -> Option<(f32, f32)> {
    let enter = enter.max(axis.distance(i));
    let exit = exit.min(axis.distance(i + 1) * SLAB_PAD);
    (enter <= exit).then_some((enter, exit))
}
