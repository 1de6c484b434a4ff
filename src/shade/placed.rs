//! What shading needs of an instance's matrix, computed when the first ray of a frame hits the instance.
//!
//! Hits of one instance follow one another, and their matrix work (cofactors, determinant, error bounds) is the same; it was
//! a third of the time of a plain hit. Instances that nothing hits cost nothing.

use glam::{Affine3A, Mat3A, Vec3, Vec3A};

/// An instance as its hits see it.
#[derive(Clone, Debug)]
pub struct Placed {
    pub world_from_object: Affine3A,
    /// Of the linear part, scaled so that neither tiny nor huge matrices leave the range of f32.
    cofactor: Mat3A,
    /// −1 for a mirroring matrix, else 1.
    orientation: f32,
    /// Absolute values of the linear part, of the transposed cofactors and of the translation.
    linear_abs: Mat3A,
    cofactor_abs: Mat3A,
    translation_abs: Vec3A,
    /// |M⁻¹| is `cofactor_abs` times this.
    inverse_scale: f32,
    /// The largest factor by which the linear part can stretch a component.
    stretch: f32,
    /// Everything in numbers, for [`super::points`]: the matrix (four columns), the cofactors (three), then orientation, inverse scale and stretch.
    pub(super) numbers: [f32; 24],
}

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
        numbers[..12].copy_from_slice(&world_from_object.to_cols_array());
        numbers[12..21].copy_from_slice(&cofactor.to_cols_array());
        numbers[21..].copy_from_slice(&[orientation, inverse_scale, stretch]);
        Self {
            world_from_object,
            cofactor,
            orientation,
            linear_abs: abs(linear),
            cofactor_abs: abs(cofactor).transpose(),
            translation_abs: world_from_object.translation.abs(),
            inverse_scale,
            stretch,
            numbers,
        }
    }

    /// An object-space normal in world space, of no particular length.
    ///
    /// Through the cofactor matrix: it is the inverse transpose up to a factor, exists for singular matrices too, and
    /// its sign under mirrors is that of the determinant.
    #[inline]
    pub fn normal(&self, n: Vec3) -> Vec3 {
        Vec3::from(self.cofactor * Vec3A::from(n) * self.orientation)
    }

    /// A vector of object space in world space.
    #[inline]
    pub fn vector(&self, v: Vec3) -> Vec3 {
        Vec3::from(self.world_from_object.matrix3 * Vec3A::from(v))
    }

    /// In units of ε, how far a point computed on a triangle can lie from it, along each axis, by the time a ray from
    /// there has been transformed into the object's space. `magnitude` bounds the corners' coordinates.
    ///
    /// In the world the point is off by ε(|M||p| + |t|) =: εW. The way back multiplies by |M⁻¹|, and the errors made there
    /// come out again through |M|, so that ε·|M||M⁻¹|W bounds all of them; where M is orthogonal that is at most 3W.
    #[inline]
    pub fn round_trip(&self, magnitude: Vec3) -> Vec3 {
        let reach = self.linear_abs * Vec3A::from(magnitude) + self.translation_abs;
        let back = self.linear_abs * (self.cofactor_abs * reach) * self.inverse_scale;
        Vec3::from(if back.is_finite() { back.max(reach) } else { reach })
    }

    /// The largest factor by which a component of an object-space vector can grow.
    #[inline]
    pub fn stretch(&self) -> f32 {
        self.stretch
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
