//! What shading needs of an instance's matrix, computed when the first ray of a frame hits the instance.
//!
//! Hits of one instance follow one another, and their matrix work (cofactors, determinant, error bounds) is the same; it was
//! a third of the time of a plain hit. Instances that nothing hits cost nothing.

use crate::memory::{OutOfMemory, Room};
use glam::{Affine3A, Mat3A, Vec3, Vec3A, Vec4};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering};

/// An instance as its hits see it.
#[derive(Clone, Debug)]
pub struct Placed {
    /// The matrix (four columns); the cofactors (three), of the linear part scaled so that neither tiny nor huge matrices leave the range of
    /// f32; then orientation (−1 for a mirroring matrix, else 1), inverse scale (|M⁻¹| is the transpose of the cofactors' absolute
    /// values times this) and stretch (the largest factor by which the linear part can stretch a component). In a row for [`super::points`].
    pub(super) numbers: [f32; 24],
}

const COFACTORS: usize = 12;
const ORIENTATION: usize = 21;
const INVERSE_SCALE: usize = 22;
const STRETCH: usize = 23;

impl Placed {
    pub fn new(world_from_object: Affine3A) -> Self {
        let linear = world_from_object.matrix3;
        let unscale = reciprocal(largest(linear));
        let scaled = linear * unscale;
        let cofactor = Mat3A::from_cols(
            scaled.y_axis.cross(scaled.z_axis),
            scaled.z_axis.cross(scaled.x_axis),
            scaled.x_axis.cross(scaled.y_axis),
        );
        let determinant = scaled.x_axis.dot(cofactor.x_axis);
        let orientation = if determinant < 0.0 { -1.0 } else { 1.0 };
        // The scale of `cofactor` cancels but for one factor, as M is unscaled.
        let inverse_scale = unscale / determinant.abs();
        let stretch = (linear.x_axis.abs() + linear.y_axis.abs() + linear.z_axis.abs()).max_element();
        let mut numbers = [0.0; 24];
        numbers[..COFACTORS].copy_from_slice(&world_from_object.to_cols_array());
        numbers[COFACTORS..ORIENTATION].copy_from_slice(&cofactor.to_cols_array());
        numbers[ORIENTATION..].copy_from_slice(&[orientation, inverse_scale, stretch]);
        Self { numbers }
    }

    /// Three numbers, and what comes after them.
    #[inline(always)]
    fn column(&self, at: usize) -> Vec3A {
        Vec3A::from_vec4(Vec4::from_slice(&self.numbers[at..at + 4]))
    }

    #[inline(always)]
    fn linear(&self) -> Mat3A {
        Mat3A::from_cols(self.column(0), self.column(3), self.column(6))
    }

    #[inline(always)]
    fn cofactor(&self) -> Mat3A {
        Mat3A::from_cols(self.column(COFACTORS), self.column(COFACTORS + 3), self.column(COFACTORS + 6))
    }

    /// A point of object space in world space.
    #[inline(always)]
    pub fn point(&self, p: Vec3) -> Vec3 {
        Affine3A { matrix3: self.linear(), translation: self.column(9) }.transform_point3(p)
    }

    /// An object-space normal in world space, of no particular length.
    ///
    /// Through the cofactor matrix: it is the inverse transpose up to a factor, exists for singular matrices too, and
    /// its sign under mirrors is that of the determinant.
    #[inline]
    pub fn normal(&self, n: Vec3) -> Vec3 {
        Vec3::from(self.cofactor() * Vec3A::from(n) * self.numbers[ORIENTATION])
    }

    /// A vector of object space in world space.
    #[inline]
    pub fn vector(&self, v: Vec3) -> Vec3 {
        Vec3::from(self.linear() * Vec3A::from(v))
    }

    /// In units of ε, how far a point computed on a triangle can lie from it, along each axis, by the time a ray from
    /// there has been transformed into the object's space. `magnitude` bounds the corners' coordinates.
    ///
    /// In the world the point is off by ε(|M||p| + |t|) =: εW. The way back multiplies by |M⁻¹|, and the errors made there
    /// come out again through |M|, so that ε·|M||M⁻¹|W bounds all of them; where M is orthogonal that is at most 3W.
    #[inline]
    pub fn round_trip(&self, magnitude: Vec3) -> Vec3 {
        let linear = abs(self.linear());
        let reach = linear * Vec3A::from(magnitude) + self.column(9).abs();
        let back = linear * (abs(self.cofactor()).transpose() * reach) * self.numbers[INVERSE_SCALE];
        Vec3::from(if back.is_finite() { back.max(reach) } else { reach })
    }

    /// The largest factor by which a component of an object-space vector can grow.
    #[inline]
    pub fn stretch(&self) -> f32 {
        self.numbers[STRETCH]
    }
}

/// The instances of a frame that a ray has hit. Its memory is that of all instances, kept from frame to frame; a frame writes
/// to the places of those that it hits.
#[derive(Default)]
pub(super) struct PlacedInstances {
    placed: Vec<OnceLock<Placed>>,
    /// Which have been hit, and how many.
    hit: Vec<AtomicU32>,
    count: AtomicU32,
}

impl PlacedInstances {
    /// Empties it, for a frame of `instances` instances.
    pub fn begin(&mut self, instances: usize) -> Result<(), OutOfMemory> {
        const SMALL: usize = 1024;
        if self.placed.len() > SMALL.max(4 * instances) {
            *self = Self::default();
        }
        let used = std::mem::take(self.count.get_mut()) as usize;
        for hit in &mut self.hit[..used] {
            self.placed[*hit.get_mut() as usize].take();
        }
        let more = instances.saturating_sub(self.placed.len());
        self.placed.room(more)?;
        self.hit.room(more)?;
        self.placed.resize_with(self.placed.len() + more, OnceLock::new);
        self.hit.resize_with(self.placed.len(), Default::default);
        Ok(())
    }

    /// Instance `number`, which is at `world_from_object`.
    #[inline(always)]
    pub fn get(&self, number: u32, world_from_object: impl FnOnce() -> Affine3A) -> &Placed {
        self.placed[number as usize].get_or_init(|| {
            let at = self.count.fetch_add(1, Ordering::Relaxed);
            self.hit[at as usize].store(number, Ordering::Relaxed);
            Placed::new(world_from_object())
        })
    }
}

fn abs(m: Mat3A) -> Mat3A {
    Mat3A::from_cols(m.x_axis.abs(), m.y_axis.abs(), m.z_axis.abs())
}

fn largest(m: Mat3A) -> f32 {
    m.x_axis.abs().max(m.y_axis.abs()).max(m.z_axis.abs()).max_element()
}

/// 1/x, or 1 where that is of no use.
#[inline]
pub(super) fn reciprocal(x: f32) -> f32 {
    let r = 1.0 / x;
    if r.is_finite() && r > 0.0 { r } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_frame_begins_without_the_instances_of_the_one_before() {
        let mut instances = PlacedInstances::default();
        for (frame, count) in [(1, 3), (2, 3), (3, 5000), (4, 2)] {
            instances.begin(count).expect("memory");
            assert!(instances.placed.len() >= count && instances.placed.len() <= 5000);
            let at = |x: usize| Affine3A::from_translation(Vec3::new((frame * x) as f32, 0.0, 0.0));
            for number in [count - 1, 0, count - 1] {
                let point = instances.get(number as u32, || at(number)).point(Vec3::ONE);
                assert_eq!(point, Vec3::new((frame * number + 1) as f32, 1.0, 1.0));
            }
        }
        assert!(instances.placed.len() < 5000, "so much is not kept for two");
    }
}
