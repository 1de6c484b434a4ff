//! The watertight triangle test, scalar: the reference that every SIMD kernel must equal bit for bit.
//!
//! After Woop, Benthin, Wald, *Watertight Ray/Triangle Intersection* (JCGT 2013): move the origin to 0, shear the ray
//! onto the z axis, and ask on which side of the three edges 0 lies.
//!
//! * A shared vertex is sheared by the same operations for every triangle that uses it, so the sheared triangles tile the plane as
//!   the mesh does. `fl(a*b) - fl(c*d)` never has the wrong sign (rounding is monotone); it can only be 0. Then, and on overflow,
//!   the edge functions are evaluated again in f64, where products of two f32 are exact. So the side is always exact
//!   and a ray cannot slip through an edge or a vertex. A fused multiply-add here would break it (one product
//!   rounded, the other not): *never contract these*.
//! * `t` is clamped to the interval in which the ray is inside the triangle's box. For triangles seen edge-on `t` is
//!   ill-conditioned, and unclamped it could lie outside every box that holds the triangle, so that the winner would depend on the structure.
//! * For structures that hold parts of triangles (spatial splits) that is not enough: `t` has to be near the point that was hit. So f32 weighs
//!   only triangles that are seen large enough for their own size ([`least_area`]), where rounding moves `t` by a small part of that
//!   size; others, and overflows, are weighed in f64, whose products are exact. Of well-shaped triangles these are one hit in some thousands.

use super::{PreparedRay, SLAB_PAD};
use crate::accel::{Aabb, least_area, triangle_bounds};
use glam::Vec3;

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    pub t: f32,
    /// Weight of the second corner.
    pub u: f32,
    /// Weight of the third corner.
    pub v: f32,
}

/// Tests one triangle against the ray's interval `[tmin, tmax]`.
#[inline]
pub fn intersect(ray: &PreparedRay, corners: [Vec3; 3]) -> Option<TriangleHit> {
    let [kx, ky, kz] = ray.axis;
    let shear = |corner: Vec3| {
        let p = corner - ray.org;
        [p[kx] - ray.shear.x * p[kz], p[ky] - ray.shear.y * p[kz], p[kz]]
    };
    // Not by `map`, which is a function of its own that is not always inlined.
    let sheared = [shear(corners[0]), shear(corners[1]), shear(corners[2])];
    let [a, b, c] = sheared;
    let u = c[0] * b[1] - c[1] * b[0];
    let v = a[0] * c[1] - a[1] * c[0];
    let w = b[0] * a[1] - b[1] * a[0];
    let exact = all_exact([u, v, w]);
    if exact && (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
        return None;
    }
    // Costs more than all before it, and most triangles have been missed by now.
    let bounds = triangle_bounds(corners);
    let in_f32 = if exact { weigh(ray, [u, v, w], sheared.map(|p| p[2]), least_area(&bounds)) } else { None };
    let hit = match in_f32 {
        Some(hit) => hit,
        None => weigh_f64(ray, sheared)?,
    };
    accept(ray, &bounds, hit)
}

/// Whether the edge functions are finite and not 0: then their signs decide.
#[inline(always)]
fn all_exact(edges: [f32; 3]) -> bool {
    // Written so that NaN fails.
    edges.iter().all(|e| e.abs() > 0.0 && e.abs() < f32::INFINITY)
}

/// Numerators of `t` below have lost bits to underflow.
pub(super) const LEAST_NUMERATOR: f32 = 1e-30;

/// Distance and weights from edge functions of one sign, and the corners' depths before the shear. None if f32 does not tell them well:
/// where the triangle is seen smaller than `least_area`, or the sums leave the range.
#[inline(always)]
fn weigh(ray: &PreparedRay, [u, v, w]: [f32; 3], depth: [f32; 3], least_area: f32) -> Option<TriangleHit> {
    let det = (u + v) + w;
    let [az, bz, cz] = depth.map(|z| ray.shear.z * z);
    let numerator = (u * az + v * bz) + w * cz;
    // Written so that NaN fails.
    let is_good = det.abs() >= least_area
        && det.abs() < f32::INFINITY
        && numerator.abs() >= LEAST_NUMERATOR
        && numerator.abs() < f32::INFINITY;
    let inv_det = 1.0 / det;
    is_good.then_some(TriangleHit { t: numerator * inv_det, u: v * inv_det, v: w * inv_det })
}

/// The edge functions in f64, for a ray through an edge or a vertex, nearly in the triangle's plane, or when f32 overflowed.
#[cold]
fn weigh_f64(ray: &PreparedRay, sheared: [[f32; 3]; 3]) -> Option<TriangleHit> {
    let [a, b, c] = sheared.map(|p| p.map(f64::from));
    let u = c[0] * b[1] - c[1] * b[0];
    let v = a[0] * c[1] - a[1] * c[0];
    let w = b[0] * a[1] - b[1] * a[0];
    if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
        return None;
    }
    let det = u + v + w;
    // Seen exactly edge-on the triangle covers nothing; its neighbours do.
    if det == 0.0 || det.is_nan() {
        return None;
    }
    let z = f64::from(ray.shear.z);
    let t = (u * (z * a[2]) + v * (z * b[2]) + w * (z * c[2])) / det;
    Some(TriangleHit { t: t as f32, u: (v / det) as f32, v: (w / det) as f32 })
}

/// Clamps `t` to the triangle's box and tests it against the ray's interval.
#[inline]
fn accept(ray: &PreparedRay, bounds: &Aabb, hit: TriangleHit) -> Option<TriangleHit> {
    if bounds.is_empty() || hit.t.is_nan() {
        return None;
    }
    let (enter, exit) = ray.slab(bounds);
    let exit = exit * SLAB_PAD;
    // No structure would visit a box that the ray misses; nor may brute force.
    if enter > exit {
        return None;
    }
    let t = if hit.t < enter {
        enter
    } else if hit.t > exit {
        exit
    } else {
        hit.t
    };
    (t >= ray.tmin && t <= ray.tmax).then_some(TriangleHit { t, ..hit })
}
