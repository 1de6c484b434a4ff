//! Axis-aligned boxes, and *the* box of a triangle.
//!
//! Every structure bounds a triangle by [`triangle_bounds`] and by nothing tighter. Two promises rest on that:
//!
//! * *No leaks.* The triangle test (Woop, Benthin, Wald 2013) is exact for the sheared, rounded vertices; those differ
//!   from the true ones by a few ulps of their distance from the ray's origin. The slab test allows for the relative
//!   part ([`crate::trace::SLAB_PAD`], after Ize 2013); the padding here covers the part that is relative
//!   to the triangle's own size, and denormal sizes.
//! * *The same hit from every structure.* A hit's distance is clamped to the interval in which the ray is inside this very box
//!   ([`crate::trace::triangle`]). Slab distances grow monotonically with the box, in floating point too, so no box or cell
//!   that contains the triangle can be culled against a hit that the triangle would win or tie.

pub use crate::scene::MAX_COORDINATE;
use glam::Vec3;

/// A box; empty when any `lo > hi`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    pub lo: Vec3,
    pub hi: Vec3,
}

impl Aabb {
    pub const EMPTY: Aabb = Aabb { lo: Vec3::INFINITY, hi: Vec3::NEG_INFINITY };

    #[inline]
    pub fn is_empty(&self) -> bool {
        !self.lo.cmple(self.hi).all()
    }

    /// Grows to contain `point`.
    #[inline]
    pub fn grow(&mut self, point: Vec3) {
        self.lo = self.lo.min(point);
        self.hi = self.hi.max(point);
    }

    #[inline]
    pub fn union(self, other: Aabb) -> Aabb {
        Aabb { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    /// The common part; empty when there is none.
    #[inline]
    pub fn intersection(self, other: Aabb) -> Aabb {
        Aabb { lo: self.lo.max(other.lo), hi: self.hi.min(other.hi) }
    }

    /// Whether `other` lies inside or on the border. An empty box is inside every box.
    #[inline]
    pub fn contains(&self, other: &Aabb) -> bool {
        other.is_empty() || (self.lo.cmple(other.lo).all() && other.hi.cmple(self.hi).all())
    }

    #[inline]
    pub fn extent(&self) -> Vec3 {
        self.hi - self.lo
    }

    #[inline]
    pub fn center(&self) -> Vec3 {
        self.lo * 0.5 + self.hi * 0.5
    }

    /// Half the surface area, the measure of the surface area heuristic; 0 for an empty box.
    #[inline]
    pub fn half_area(&self) -> f32 {
        if self.is_empty() {
            return 0.0;
        }
        let e = self.extent();
        e.x * e.y + (e.y * e.z + e.z * e.x)
    }
}

/// The padded box of a triangle; empty when a corner is not finite or out of range, so that no ray meets it.
#[inline]
pub fn triangle_bounds(corners: [Vec3; 3]) -> Aabb {
    let [a, b, c] = corners;
    // `max` would swallow a NaN; the sum of magnitudes does not.
    let reach = (a.abs() + b.abs()) + c.abs();
    if !(reach.x <= 3.0 * MAX_COORDINATE && reach.y <= 3.0 * MAX_COORDINATE && reach.z <= 3.0 * MAX_COORDINATE) {
        return Aabb::EMPTY;
    }
    padded(Aabb { lo: a.min(b).min(c), hi: a.max(b).max(c) })
}

/// The box of triangles between vertices around which `tight` lies. Every operation is monotone, in floating point too, so a larger box has a
/// larger one: it contains the box of each of the triangles.
#[inline]
pub(super) fn padded(tight: Aabb) -> Aabb {
    let largest = tight.lo.abs().max(tight.hi.abs());
    let pad = (Vec3::splat(tight.extent().max_element() * PAD_EXTENT) + largest * PAD_ULP) + Vec3::splat(PAD_ABSOLUTE);
    Aabb { lo: tight.lo - pad, hi: tight.hi + pad }
}

/// Twice the least area, seen along the ray's longest axis, from which a triangle's hit may be weighed in f32, given its padded box.
///
/// Rounding of the edge functions moves the weighed distance by up to 24 half ulps of the triangle's largest side, times the square of that side
/// over twice the area seen: with this bound by less than 1/8192 of the side. Below the range of f32's full precision no area is enough.
#[inline(always)]
pub fn least_area(bounds: &Aabb) -> f32 {
    let side = bounds.extent().max_element();
    side * side * LEAST_SEEN + f32::MIN_POSITIVE
}

/// Share of the square of its largest side that a triangle must be seen with.
pub(crate) const LEAST_SEEN: f32 = 1.0 / 64.0;

/// A triangle's box is padded by 4 ulps of its largest side,
pub(crate) const PAD_EXTENT: f32 = 1.0 / (1 << 22) as f32;
/// by at least one ulp of the coordinate, so that no corner lies on a side of the box (a ray in that side's plane has a
/// reciprocal direction of `f32::MAX`, and 0 times that would end the slab at 0, before the hit),
pub(crate) const PAD_ULP: f32 = 1.0 / (1 << 23) as f32;
/// and by a few denormals, for meshes of denormal size.
pub(crate) const PAD_ABSOLUTE: f32 = f32::MIN_POSITIVE / (1 << 16) as f32;
