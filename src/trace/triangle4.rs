//! The triangle test of [`super::triangle`], four triangles at a time.
//!
//! The edge functions are the scalar ones, operation by operation. A lane is out when one of its edge functions is
//! below 0 and another above: both signs are exact (see there), so a third one that is 0 or not a number cannot change it.
//! That leaves few lanes, and they take the scalar way: at once when all edge functions are finite and not 0,
//! else by way of f64. So the result is that of the scalar test, bit for bit, without a second copy of its rare branches.

use super::PreparedRay;
use super::triangle::{self, TriangleHit};
use crate::accel::{BLOCK, Tri4};
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
        let [kx, ky, kz] = ray.axis;
        // SAFETY: the caller's promise.
        unsafe {
            Self {
                org: [I::F4::splat(ray.org[kx]), I::F4::splat(ray.org[ky]), I::F4::splat(ray.org[kz])],
                shear: [I::F4::splat(ray.shear.x), I::F4::splat(ray.shear.y)],
                axis: ray.axis,
            }
        }
    }
}

/// Calls `found(lane, hit)` for every triangle of the block that the ray hits within its own interval, until it returns true;
/// says whether it did.
///
/// # Safety
/// - The processor has the instruction set `I`.
#[inline(always)]
pub(super) unsafe fn intersect4<I: Isa>(
    ray: &PreparedRay,
    lanes: &RayLanes<I>,
    block: &Tri4,
    mut found: impl FnMut(usize, TriangleHit) -> bool,
) -> bool {
    let [kx, ky, kz] = lanes.axis;
    // SAFETY: the caller's promise.
    let (candidates, edges, depth) = unsafe {
        let sheared = |corner: usize| {
            let p = &block.corners[corner];
            let z = I::F4::load(&p[kz]).sub(lanes.org[2]);
            let x = I::F4::load(&p[kx]).sub(lanes.org[0]).sub(lanes.shear[0].mul(z));
            let y = I::F4::load(&p[ky]).sub(lanes.org[1]).sub(lanes.shear[1].mul(z));
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
            return false;
        }
        let mut edges = [[0.0f32; BLOCK]; 3];
        let mut depth = [[0.0f32; BLOCK]; 3];
        for (to, from) in edges.iter_mut().zip([u, v, w]) {
            from.store(to);
        }
        for (to, from) in depth.iter_mut().zip([a[2], b[2], c[2]]) {
            from.store(to);
        }
        (candidates, edges, depth)
    };
    let mut left = candidates;
    while left != 0 {
        let lane = left.trailing_zeros() as usize & (BLOCK - 1);
        left &= left - 1;
        let weights = edges.map(|e| e[lane]);
        let hit = if triangle::all_exact(weights) {
            let hit = triangle::weigh(ray, weights, depth.map(|z| z[lane]));
            triangle::accept(ray, block.corners(lane), hit)
        } else {
            triangle::intersect(ray, block.corners(lane))
        };
        if let Some(hit) = hit
            && found(lane, hit)
        {
            return true;
        }
    }
    false
}
