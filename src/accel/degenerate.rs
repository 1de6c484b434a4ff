//! Degenerate instances: those whose matrix has no inverse that a ray could be transformed by.
//!
//! A matrix may flatten an object (planar shadows of OpenGL programs are drawn so), or make it so small that the inverse, or the origins of rays that it
//! transforms, leave the range of f32. Such an instance is evaluated in world space as a static one is: its vertices are transformed, and it has a
//! structure of its own, by the object's strategy. Any number of instances of one object may be degenerate, beside others that are not.
//!
//! The n-th degenerate instance of a frame follows on the n-th of the frame before: where object and matrix are the same, nothing is done.
//!
//! *Cost*: memory and builds per instance, not per object. To find out that an instance is not degenerate takes a determinant.

use super::MAX_COORDINATE;
use super::instance::invert;
use glam::{Affine3A, Vec3A};

/// Larger elements of an inverse matrix carry the origin of a ray out of the range of coordinates, where it is some millions of units away.
const LARGEST_INVERSE: f32 = 1e12;

/// Whether an instance with this matrix must be evaluated in world space. False for a matrix that is not finite, which shows nothing.
#[inline]
pub(super) fn is_degenerate(world_from_object: &Affine3A) -> bool {
    let m = &world_from_object.matrix3;
    let offset = world_from_object.translation.abs().max_element();
    let largest = m.x_axis.abs().max(m.y_axis.abs()).max(m.z_axis.abs()).max_element();
    // Of nearly all matrices this is known by f32: an element of the inverse is at most twice the square of the largest one over the determinant.
    let ordinary = largest > 1e-3 && largest < 1e6 && offset < 1e6;
    if ordinary && m.determinant().abs() > 1e-5 * largest * largest * largest {
        return false;
    }
    is_degenerate_in_f64(world_from_object)
}

#[cold]
fn is_degenerate_in_f64(world_from_object: &Affine3A) -> bool {
    if !world_from_object.is_finite() {
        return false;
    }
    let Some(inverse) = invert(world_from_object) else { return true };
    let within = |v: Vec3A, bound: f32| v.abs().max_element() <= bound;
    let m = &inverse.matrix3;
    let linear = [m.x_axis, m.y_axis, m.z_axis].into_iter().all(|column| within(column, LARGEST_INVERSE));
    !(linear && within(inverse.translation, MAX_COORDINATE / 16.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Mat3, Quat, Vec3};

    #[test]
    fn matrices_are_degenerate_where_rays_cannot_be_transformed() {
        let scale = |x, y, z| Affine3A::from_scale(Vec3::new(x, y, z));
        let turned = Affine3A::from_quat(Quat::from_rotation_y(0.7));
        for m in [
            scale(1.0, 1.0, 0.0),
            scale(0.0, 0.0, 0.0),
            turned * scale(1.0, 0.0, 1.0) * turned,
            Affine3A::from_mat3(Mat3::from_cols(Vec3::ONE, Vec3::ONE * 3.0, Vec3::X)),
            scale(1e-19, 1e-19, 1e-19),
            scale(1.0, 1.0, 1e-39),
            Affine3A::from_translation(Vec3::splat(1e9)) * scale(1e-10, 1e-10, 1e-10),
        ] {
            assert!(is_degenerate(&m), "{m:?}");
        }
        for m in [
            Affine3A::IDENTITY,
            turned * scale(1000.0, -1.0, 0.001),
            scale(1e18, 1e18, 1e18),
            scale(1e-10, 1e-10, 1e-10),
            scale(1.0, 1.0, 1e-7) * turned,
            Affine3A::from_translation(Vec3::splat(1e17)),
            scale(f32::NAN, 1.0, 1.0),
            scale(f32::INFINITY, 0.0, 1.0),
        ] {
            assert!(!is_degenerate(&m), "{m:?}");
        }
    }
}
