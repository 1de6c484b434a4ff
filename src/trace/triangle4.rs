//! The triangle test of [`super::triangle`], four triangles at a time.
//!
//! The edge functions are the scalar ones, operation by operation. A lane is out when one of its edge functions is
//! below 0 and another above: both signs are exact (see there), so a third one that is 0 or not a number cannot change it.
//! That leaves few lanes, and they take the scalar way: at once when f32 tells them well (there),
//! else by way of f64. So the result is that of the scalar test, bit for bit, without a second copy of its rare branches.

use super::packet::{GROUPS, LANES, Packet};
use super::{Hit, PreparedRay, triangle};
use crate::accel::{BLOCK, Tri4, least_area, triangle_bounds};
use crate::simd::{Isa, Vector};

/// What the four-wide test derives from a ray, in registers.
#[derive(Clone, Copy)]
pub(super) struct RayLanes<I: Isa> {
    /// Origin and shear, in the order of the ray's permuted axes.
    org: [I::F4; 3],
    shear: [I::F4; 2],
    axis: [usize; 3],
}

impl<I: Isa> RayLanes<I> {
    /// # Safety
    /// - The processor has the instruction set `I`.
    #[inline(always)]
    pub(super) unsafe fn new(ray: &PreparedRay) -> Self {
        // Indexing an array of four by two bits needs neither branch nor check.
        let axis = ray.axis.map(|k| k & 3);
        assert!(axis.iter().all(|&k| k < 3), "axes are numbered 0, 1, 2");
        let org = [ray.org.x, ray.org.y, ray.org.z, 0.0];
        // SAFETY: the caller's promise.
        unsafe {
            Self {
                org: axis.map(|k| I::F4::splat(org[k])),
                shear: [I::F4::splat(ray.shear.x), I::F4::splat(ray.shear.y)],
                axis,
            }
        }
    }

    /// The lanes of ray `r` of a packet.
    ///
    /// # Safety
    /// - The processor has the instruction set `I`.
    #[inline(always)]
    pub(super) unsafe fn of_packet(packet: &Packet, r: usize) -> Self {
        const NEXT: [usize; 5] = [0, 1, 2, 0, 1];
        let (g, l) = (r / LANES % GROUPS, r % LANES);
        let z = packet.axis(r);
        let axis = [NEXT[z + 1], NEXT[z + 2], NEXT[z]];
        // SAFETY: the caller's promise.
        unsafe {
            Self {
                org: axis.map(|k| I::F4::splat(packet.org[k][g][l])),
                shear: [I::F4::splat(packet.shear[0][g][l]), I::F4::splat(packet.shear[1][g][l])],
                axis,
            }
        }
    }
}

/// Edge functions and depths of the four triangles: `u, v, w` and the corners' `z`.
pub(super) struct Edges {
    weights: [[f32; BLOCK]; 3],
    depth: [[f32; BLOCK]; 3],
}

/// The lanes that the edge functions leave, if any, and what they have computed.
///
/// # Safety
/// - The processor has the instruction set `I`.
#[inline(always)]
pub(super) unsafe fn edges4<I: Isa>(lanes: &RayLanes<I>, block: &Tri4) -> Option<(u32, Edges)> {
    let [kx, ky, kz] = lanes.axis;
    // SAFETY: the caller's promise; axes are below 3 (checked by the constructors of `RayLanes`).
    unsafe {
        let sheared = |corner: usize| {
            let p = &block.corners[corner];
            let z = I::F4::load(p.get_unchecked(kz)).sub(lanes.org[2]);
            let x = I::F4::load(p.get_unchecked(kx)).sub(lanes.org[0]).sub(lanes.shear[0].mul(z));
            let y = I::F4::load(p.get_unchecked(ky)).sub(lanes.org[1]).sub(lanes.shear[1].mul(z));
            [x, y, z]
        };
        let (a, b, c) = (sheared(0), sheared(1), sheared(2));
        let u = c[0].mul(b[1]).sub(c[1].mul(b[0]));
        let v = a[0].mul(c[1]).sub(a[1].mul(c[0]));
        let w = b[0].mul(a[1]).sub(b[1].mul(a[0]));
        // A minimum below 0 is one of the three, even if another is NaN; the same for the maximum.
        let zero = I::F4::splat(0.0);
        let least = u.min(v).min(w);
        let most = u.max(v).max(w);
        let candidates = !(least.lt(zero) & zero.lt(most)) & 0xf;
        if candidates == 0 {
            return None;
        }
        let mut edges = Edges { weights: [[0.0; BLOCK]; 3], depth: [[0.0; BLOCK]; 3] };
        for (to, from) in edges.weights.iter_mut().zip([u, v, w]) {
            from.store(to);
        }
        for (to, from) in edges.depth.iter_mut().zip([a[2], b[2], c[2]]) {
            from.store(to);
        }
        Some((candidates, edges))
    }
}

/// The scalar rest: tests the candidates of a block against the ray's own interval and `best`, which every hit that comes before it replaces
/// (with the number of the triangle and of `best`'s candidate object and instance). With `ANY` the first hit ends the test.
/// Returns whether there was a hit that counts. Out of line, so that the traversal loop around it keeps its registers.
#[inline(never)]
pub(super) fn resolve<const ANY: bool>(
    ray: &PreparedRay,
    block: &Tri4,
    mut candidates: u32,
    edges: &Edges,
    object: u32,
    instance: u32,
    best: &mut Hit,
) -> bool {
    let mut found = false;
    while candidates != 0 {
        let lane = candidates.trailing_zeros() as usize & (BLOCK - 1);
        candidates &= candidates - 1;
        let weights = edges.weights.map(|e| e[lane]);
        let corners = block.corners(lane);
        let bounds = triangle_bounds(corners);
        let depth = edges.depth.map(|z| z[lane]);
        let in_f32 =
            if triangle::all_exact(weights) { triangle::weigh(ray, weights, depth, least_area(&bounds)) } else { None };
        let hit = match in_f32 {
            Some(hit) => triangle::accept(ray, &bounds, hit),
            None => triangle::intersect(ray, corners),
        };
        let Some(h) = hit else { continue };
        if ANY {
            return true;
        }
        let hit = Hit { t: h.t, u: h.u, v: h.v, prim: block.prims[lane], object, instance };
        found |= hit.replaces(best);
    }
    found
}
