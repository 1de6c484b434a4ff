//! One ray through one object BSP (Wald03 §4.2).
//!
//! ```text
//! loop: inner → distance of the plane; before it: near child, beyond it: far child, between: near now, far to the stack
//!       leaf  → its triangles, one after the other
//!       next  → pop; stop when a cell begins beyond the best hit
//! ```
//!
//! A ray's interval `[enter, exit]` in a cell keeps `enter <= t <= exit * SLAB_PAD` for the hit `t` that wins, in at least
//! one cell that references its triangle. With `s` the distance of a plane and the triangle's box wholly before it, the clamped
//! `t` is at most `s * SLAB_PAD`; wholly beyond it, at least `s`; on both sides, one of the two. So the near child is
//! entered if `enter <= s * SLAB_PAD` and the far one if `s <= exit * SLAB_PAD`, with the padding on the same side as in
//! the slab test, and a cell is left out only if `enter > best t`: equal distances are still compared by number.
//!
//! Which child is near is told by the sign of the direction and not by the origin's side, for a ray in the plane.
//! A triangle in several cells is tested in each: a mailbox costs more than the few repeated tests.

use super::{Hit, PreparedRay, SLAB_PAD, triangle};
use crate::accel::{BSP_MAX_DEPTH, Bsp};

/// A cell to come back to.
#[derive(Clone, Copy)]
struct Pending {
    node: u32,
    enter: f32,
    exit: f32,
}

/// The closest hit, by the contract of [`super::Kernels::intersect`].
pub(super) fn intersect(bsp: &Bsp, ray: &PreparedRay, object: u32, instance: u32, best: &mut Hit) -> bool {
    traverse::<false>(bsp, ray, object, instance, best)
}

/// Whether there is any hit, by the contract of [`super::Kernels::occluded`].
pub(super) fn occluded(bsp: &Bsp, ray: &PreparedRay) -> bool {
    traverse::<true>(bsp, ray, 0, 0, &mut Hit::none(ray.tmax))
}

fn traverse<const ANY: bool>(bsp: &Bsp, ray: &PreparedRay, object: u32, instance: u32, best: &mut Hit) -> bool {
    let (enter, exit) = ray.slab(&bsp.bounds());
    let mut enter = if ray.tmin > enter { ray.tmin } else { enter };
    let mut exit = if best.t < exit { best.t } else { exit };
    // Written so that an empty object's NaN or infinities fail.
    if bsp.bounds().is_empty() || !(enter <= exit * SLAB_PAD) {
        return false;
    }
    let corners = bsp.corners();
    let mut found = false;
    let mut test = |prim: u32, best: &mut Hit| {
        let Some(h) = triangle::intersect(ray, corners[prim as usize]) else { return false };
        if ANY {
            return true;
        }
        if ray.excludes(h.t, instance, prim) {
            return false;
        }
        let hit = Hit { t: h.t, u: h.u, v: h.v, prim, object, instance };
        found |= hit.replaces(best);
        false
    };

    let Some(tree) = bsp.tree() else {
        // No memory for a tree.
        return (0..corners.len() as u32).any(|prim| test(prim, best)) || found;
    };
    let (nodes, refs) = (tree.nodes(), tree.refs());
    let mut stack = [Pending { node: 0, enter: 0.0, exit: 0.0 }; BSP_MAX_DEPTH];
    let mut depth = 0;
    let mut current = 0u32;
    loop {
        let node = nodes[current as usize];
        if !node.is_leaf() {
            let axis = node.axis();
            let s = (node.plane() - ray.org[axis]) * ray.inv_dir[axis];
            let flip = u32::from(ray.inv_dir[axis] < 0.0);
            let (near, far) = (node.lower() + flip, node.lower() + 1 - flip);
            if enter > s * SLAB_PAD {
                current = far;
                enter = if s > enter { s } else { enter };
            } else if s > exit * SLAB_PAD {
                current = near;
            } else {
                stack[depth] = Pending { node: far, enter: if s > enter { s } else { enter }, exit };
                depth += 1;
                current = near;
                exit = if s < exit { s } else { exit };
            }
            continue;
        }
        for &prim in &refs[node.refs()] {
            if test(prim, best) {
                return true;
            }
        }
        loop {
            if depth == 0 {
                return found;
            }
            depth -= 1;
            let next = stack[depth];
            if next.enter <= best.t {
                (current, enter, exit) = (next.node, next.enter, next.exit);
                break;
            }
        }
    }
}
