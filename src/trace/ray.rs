//! Rays, and what is computed once per ray and space.
//!
//! Directions are never normalised: `t` then means the same in world and object space (Wald03 §4.4).
//! The slab distance of a plane is `(plane - org) * inv_dir` everywhere, in this order of operations, so that it is
//! monotone in the plane's position and equal on every instruction set. `inv_dir` is kept finite, which keeps NaN out
//! of the slab test: `0 * inf` cannot occur.

use super::Hit;
use crate::accel::{Aabb, MAX_COORDINATE, Merged};
use glam::{Vec3, Vec3A};

/// Relative widening of a slab exit distance. The three roundings of a slab distance need 3 units in the last place
/// (Ize 2013); the shear of the triangle test adds up to 5 on either side. 16 covers both.
pub const SLAB_PAD: f32 = 1.0 + 16.0 * (f32::EPSILON * 0.5);

/// A query: points `origin + t * direction` with `tmin <= t <= tmax`.
/// In memory: eight numbers in this order, so that eight rays can be transposed into lanes.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Ray {
    pub origin: Vec3,
    /// Smallest accepted `t`; negative values count as 0.
    pub tmin: f32,
    /// Any length but 0.
    pub direction: Vec3,
    /// Largest accepted `t`, may be infinite.
    pub tmax: f32,
}

impl Ray {
    /// Its eight numbers.
    #[inline(always)]
    pub(super) fn numbers(&self) -> [f32; 8] {
        let Self { origin: o, tmin, direction: d, tmax } = *self;
        [o.x, o.y, o.z, tmin, d.x, d.y, d.z, tmax]
    }

    /// The ray from `origin` towards `direction` without end.
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, tmin: 0.0, direction, tmax: f32::INFINITY }
    }
}

/// A ray with everything that the box and triangle tests derive from it, in one space.
#[derive(Clone, Copy, Debug)]
pub struct PreparedRay {
    pub org: Vec3,
    pub dir: Vec3,
    /// `1 / dir`, finite: components of `dir` that are (nearly) 0 give ±`f32::MAX`.
    pub inv_dir: Vec3,
    pub tmin: f32,
    pub tmax: f32,
    /// Permutation of the axes: `axis[2]` has the largest component of `dir`.
    pub axis: [usize; 3],
    /// `dir[axis[0]] / dir[axis[2]]`, `dir[axis[1]] / dir[axis[2]]`, `1 / dir[axis[2]]`.
    pub shear: Vec3,
    /// At the distance `tmin`, hits count from this number on (instance and primitive in one); 0 for all.
    pub from: u64,
}

impl PreparedRay {
    /// None for a ray that cannot hit anything: a component is not finite or out of range, the direction is 0,
    /// or the interval is empty.
    #[inline]
    pub fn new(ray: &Ray) -> Option<Self> {
        Self::with_reciprocal(ray, reciprocal(ray))
    }

    /// As [`PreparedRay::new`], but None also for a ray that does not enter `aabb` before `limit`. What only triangles ask for
    /// is computed last: most rays that reach the world box of an instance miss its object's box.
    #[inline(always)]
    pub(super) fn entering(ray: &Ray, aabb: &Aabb, limit: f32) -> Option<Self> {
        let inv_dir = reciprocal(ray);
        let (org, lo, hi) = (Vec3A::from(ray.origin), Vec3A::from(aabb.lo), Vec3A::from(aabb.hi));
        let down = inv_dir.cmplt(Vec3A::ZERO);
        let enter = ((Vec3A::select(down, hi, lo) - org) * inv_dir).max_element();
        let exit = ((Vec3A::select(down, lo, hi) - org) * inv_dir).min_element();
        let enter = if ray.tmin > enter { ray.tmin } else { enter };
        // Written so that NaN fails.
        if !(enter <= (exit * SLAB_PAD).min(limit)) {
            return None;
        }
        Self::with_reciprocal(ray, inv_dir)
    }

    #[inline(always)]
    fn with_reciprocal(ray: &Ray, inv_dir: Vec3A) -> Option<Self> {
        let tmin = if ray.tmin > 0.0 { ray.tmin } else { 0.0 };
        let biggest = ray.direction.abs();
        let Vec3 { x, y, z } = ray.direction;
        let (axis, [first, second, depth]) = if biggest.x >= biggest.y && biggest.x >= biggest.z {
            ([1, 2, 0], [y, z, x])
        } else if biggest.y >= biggest.z {
            ([2, 0, 1], [z, x, y])
        } else {
            ([0, 1, 2], [x, y, z])
        };
        // Written so that NaN fails.
        let usable = depth.abs() >= MIN_DIRECTION
            && (biggest.x + biggest.y) + biggest.z <= f32::MAX
            && ray.origin.abs().cmple(Vec3::splat(MAX_COORDINATE)).all()
            && tmin <= ray.tmax;
        if !usable {
            return None;
        }
        let shear = Vec3A::new(first, second, 1.0) / Vec3A::splat(depth);
        let (inv_dir, shear) = (inv_dir.into(), shear.into());
        Some(Self { org: ray.origin, dir: ray.direction, inv_dir, tmin, tmax: ray.tmax, axis, shear, from: 0 })
    }

    /// The ray in the merged tree, whose triangles have numbers of their own.
    pub(super) fn in_merged(&self, merged: &Merged) -> Self {
        let (instance, prim) = ((self.from >> 32) as u32, self.from as u32);
        let from = if self.from == 0 { 0 } else { Hit::order(u32::MAX, merged.first_from(instance, prim)) };
        Self { from, ..*self }
    }

    /// Whether a hit lies before those that count: an earlier one of several at the distance `tmin`.
    #[inline(always)]
    pub(super) fn excludes(&self, t: f32, instance: u32, prim: u32) -> bool {
        t == self.tmin && Hit::order(instance, prim) < self.from
    }

    /// Distances at which the ray enters and leaves `aabb`, neither padded nor cut to the ray's own interval.
    /// The ray misses when `enter > exit * SLAB_PAD`. Same operations as the SIMD box tests.
    #[inline]
    pub fn slab(&self, aabb: &Aabb) -> (f32, f32) {
        let mut enter = f32::NEG_INFINITY;
        let mut exit = f32::INFINITY;
        for k in 0..3 {
            let inv = self.inv_dir[k];
            let (near, far) = if inv < 0.0 { (aabb.hi[k], aabb.lo[k]) } else { (aabb.lo[k], aabb.hi[k]) };
            let t_near = (near - self.org[k]) * inv;
            let t_far = (far - self.org[k]) * inv;
            enter = if t_near > enter { t_near } else { enter };
            exit = if t_far < exit { t_far } else { exit };
        }
        (enter, exit)
    }
}

/// `1 / dir`, kept finite.
#[inline(always)]
fn reciprocal(ray: &Ray) -> Vec3A {
    (Vec3A::ONE / Vec3A::from(ray.direction)).clamp(Vec3A::splat(-f32::MAX), Vec3A::splat(f32::MAX))
}

/// Directions whose largest component is smaller count as 0: their reciprocal would overflow.
/// Callers who may get such rays from outside rescale them first.
pub const MIN_DIRECTION: f32 = 1.0e-37;
