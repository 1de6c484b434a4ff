//! Instances: how a ray gets into object space, and where in the world that can lead to a hit.
//!
//! Rays are transformed, not triangles, and never re-normalised (Wald03 §4.4). The transform is rounded to f32, so a transformed ray
//! passes the object a little beside where the world's ray does. The instance's world box must contain every hit
//! *as computed*, or the top level would cull an instance that a traversal of all instances would hit.
//!
//! Let `N` be `object_from_world` as stored, `M` its exact inverse, `u = 2⁻²⁴`. A ray `(o, d)` becomes `(N o + n + e, N d + f)` with
//! `|e| <= 4u (|N||o| + |n|)`, `|f| <= 3u |N||d|`, and a hit at `t` is clamped to a slab interval of the object's box, so its point is in
//! the box up to `20u t |N||d|`. Mapped back by `M`, the world's point `q = o + t d` lies in the box's image up to
//!
//! ```text
//! |M||N| (23u t|d| + 4u |o|) + 4u |M||n|  <=  |M||N| (23u |q| + 27u |o|) + 4u |M||n|      as t d = q - o
//! ```
//!
//! The part of `|q|`, which lies in the box itself, and the constant part are added to the world box here. The part of `|o|` depends on
//! the ray and is added by `trace/traverse_scene`, with the largest `|M||N|` of all instances. An instance whose
//! rounding errors are large (flattened by 10⁵ after a rotation, say) is an *outlier*: it gets no box and is offered to every
//! ray, rather than making all others' errors large.
//!
//! An instance in world space ([`Space::World`]) needs none of this: its structure's box is its world box.
//!
//! Taking `M` as the inverse of the *rounded* `N` makes the exactness of the inversion irrelevant here; the two differ by a
//! rounding of the application's matrix.

use super::{Aabb, OutOfMemory};
use crate::scene::{Mask, Mesh, Name};
use glam::{Affine3A, DAffine3, DMat3, DVec3, Vec3};

const U: f64 = 1.0 / (1 << 24) as f64;
/// Bounds of the module head, with slack for the errors of the world's own slab test and of this file.
const POINT_ERROR: f64 = 40.0 * U;
const ORIGIN_ERROR: f64 = 40.0 * U;
const TRANSLATION_ERROR: f64 = 8.0 * U;
/// Roundings to denormals, at most one per operation.
const UNDERFLOW: f64 = 2.0e-44;
/// Largest `|M||N|` of an instance that is no outlier: coordinates are then wrong by up to 1 %. It is 3 for rotations after any
/// scaling; only scaling after a rotation makes it large.
const OUTLIER: f64 = 4096.0;

/// One instance that can be hit.
#[derive(Clone, Copy, Debug)]
pub struct InstanceRecord {
    /// Number within the frame.
    pub instance: u32,
    /// Index into [`super::WorldView::objects`].
    pub slot: u32,
    pub object: Name,
    pub world_from_object: Affine3A,
    pub space: Space,
    /// Of the object and of the instance.
    pub mask: Mask,
}

/// Where the triangles of an instance are, as its structure has them.
#[derive(Clone, Copy, Debug)]
pub enum Space {
    /// In object space: the ray is transformed.
    Object { object_from_world: Affine3A },
    /// In world space: the vertices have been transformed, by [`to_world`].
    World,
    /// In the merged tree ([`super::WorldView::merged`]). The record that stands for that tree itself comes last; its number is
    /// `u32::MAX`, and it has no object.
    Merged,
}

/// A vertex of an object in the world: always these operations in this order, so that all ways give the same bits.
#[inline]
pub fn to_world(world_from_object: &Affine3A, p: Vec3) -> Vec3 {
    if *world_from_object == Affine3A::IDENTITY {
        // Not by arithmetic: it would change the sign of -0.
        return p;
    }
    let m = &world_from_object.matrix3;
    ((m.x_axis * p.x + m.y_axis * p.y) + m.z_axis * p.z + world_from_object.translation).into()
}

/// An empty mesh with room for so many vertices and triangles.
pub(super) fn mesh_with_room(vertices: usize, triangles: usize) -> Result<Mesh, OutOfMemory> {
    let bytes =
        vertices.saturating_mul(size_of::<Vec3>()).saturating_add(triangles.saturating_mul(size_of::<[u32; 3]>()));
    let mut mesh = Mesh::default();
    let reserved = mesh.positions.try_reserve_exact(vertices).and(mesh.triangles.try_reserve_exact(triangles));
    if reserved.is_err() || vertices >= u32::MAX as usize || triangles >= u32::MAX as usize {
        return Err(OutOfMemory { bytes });
    }
    Ok(mesh)
}

/// Adds the triangles of `mesh`, placed in the world, to `all`, which has room for them.
pub(super) fn append_to_world(all: &mut Mesh, mesh: &Mesh, world_from_object: &Affine3A) {
    let before = all.positions.len() as u32;
    all.positions.extend(mesh.positions.iter().map(|&p| to_world(world_from_object, p)));
    all.triangles.extend(mesh.triangles.iter().map(|triangle| triangle.map(|index| index + before)));
}

/// Where an instance can be hit.
#[derive(Clone, Copy, Debug)]
pub(super) enum Reach {
    /// In this box, if the ray's origin is allowed for by `error` times its coordinates' magnitudes.
    Box { bounds: Aabb, error: DMat3 },
    /// Anywhere.
    Outlier,
}

/// `object_from_world` in f32, by way of f64. `None` for a matrix that is not finite or cannot be inverted.
pub(super) fn invert(world_from_object: &Affine3A) -> Option<Affine3A> {
    let forward = to_f64(world_from_object);
    let columns = forward.matrix3.to_cols_array_2d().map(DVec3::from_array);
    let rows = [forward.matrix3.row(0), forward.matrix3.row(1), forward.matrix3.row(2)];
    let volume = |v: [DVec3; 3]| v[0].length() * v[1].length() * v[2].length();
    // Singular up to the rounding of this very determinant, whichever way the axes are scaled.
    let det = forward.matrix3.determinant().abs();
    if !(det > 1e-15 * volume(columns).min(volume(rows))) {
        return None;
    }
    let inverse = to_f32(&forward.inverse());
    inverse.is_finite().then_some(inverse)
}

/// Where the box of an object, in object space, can be hit in the world. `None` if the rounded matrix is singular.
pub(super) fn reach(object_bounds: &Aabb, object_from_world: &Affine3A) -> Option<Reach> {
    let backward = to_f64(object_from_world);
    let forward = backward.inverse();
    if !forward.is_finite() {
        return None;
    }
    let magnitudes = |m: &DMat3| DMat3::from_cols(m.x_axis.abs(), m.y_axis.abs(), m.z_axis.abs());
    let scale = magnitudes(&forward.matrix3);
    let error = scale * magnitudes(&backward.matrix3);
    let (lo, hi) = (object_bounds.lo.as_dvec3(), object_bounds.hi.as_dvec3());
    let center = forward.transform_point3((lo + hi) * 0.5);
    let half = scale * ((hi - lo) * 0.5);
    let farthest = center.abs() + half;
    let constant = scale * (backward.translation.abs() * TRANSLATION_ERROR + DVec3::splat(UNDERFLOW));
    // Written so that NaN makes an outlier.
    if !error.to_cols_array().iter().all(|&e| e <= OUTLIER) {
        return Some(Reach::Outlier);
    }
    // The padded box is a little farther out than the box that the padding is computed from.
    let once = error * (farthest * POINT_ERROR) + constant;
    let pad = error * ((farthest + once) * POINT_ERROR) + constant;
    let half = half + pad;
    let bounds = Aabb { lo: round_down(center - half), hi: round_up(center + half) };
    Some(if bounds.lo.is_finite() && bounds.hi.is_finite() {
        Reach::Box { bounds, error: error * ORIGIN_ERROR }
    } else {
        Reach::Outlier
    })
}

fn to_f64(m: &Affine3A) -> DAffine3 {
    let column = |v: glam::Vec3A| Vec3::from(v).as_dvec3();
    DAffine3 {
        matrix3: DMat3::from_cols(column(m.matrix3.x_axis), column(m.matrix3.y_axis), column(m.matrix3.z_axis)),
        translation: column(m.translation),
    }
}

fn to_f32(m: &DAffine3) -> Affine3A {
    let column = |v: DVec3| v.as_vec3().into();
    let DMat3 { x_axis, y_axis, z_axis } = m.matrix3;
    Affine3A {
        matrix3: glam::Mat3A::from_cols(column(x_axis), column(y_axis), column(z_axis)),
        translation: column(m.translation),
    }
}

/// Conversion to f32 rounds to nearest; one step further is on the safe side of it.
fn round_down(v: DVec3) -> Vec3 {
    Vec3::from_array(v.as_vec3().to_array().map(f32::next_down))
}

fn round_up(v: DVec3) -> Vec3 {
    Vec3::from_array(v.as_vec3().to_array().map(f32::next_up))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    #[test]
    fn singular_and_broken_matrices_are_refused() {
        let scale = |x, y, z| Affine3A::from_scale(Vec3::new(x, y, z));
        for m in [
            scale(1.0, 1.0, 0.0),
            scale(f32::NAN, 1.0, 1.0),
            scale(f32::INFINITY, 1.0, 1.0),
            Affine3A::from_translation(Vec3::new(0.0, f32::NAN, 0.0)),
            Affine3A::from_mat3(glam::Mat3::from_cols(Vec3::ONE, Vec3::ONE * 3.0, Vec3::X)),
            scale(1e-39, 1.0, 1.0),
        ] {
            assert!(invert(&m).is_none(), "{m:?}");
        }
        for m in [scale(1e-20, 1e-20, 1e-20), scale(1e20, 1e20, 1e20), scale(1000.0, -1.0, 0.001)] {
            let inverse = invert(&m).expect("regular");
            assert!((m * inverse).abs_diff_eq(Affine3A::IDENTITY, 1e-6), "{m:?}");
        }
    }

    #[test]
    fn the_box_contains_the_corners_and_is_not_much_larger() {
        let unit = Aabb { lo: Vec3::splat(-1.0), hi: Vec3::splat(1.0) };
        let m = Affine3A::from_scale_rotation_translation(
            Vec3::new(1000.0, 1.0, -0.001),
            Quat::from_rotation_z(0.3) * Quat::from_rotation_x(1.0),
            Vec3::new(5.0, -7.0, 1e4),
        );
        let inverse = invert(&m).expect("regular");
        let Some(Reach::Box { bounds, .. }) = reach(&unit, &inverse) else { panic!("no outlier") };
        for i in 0..8 {
            let corner = Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 2.0 - 1.0;
            let p = m.transform_point3(corner);
            assert!(bounds.contains(&Aabb { lo: p, hi: p }), "{p} outside of {bounds:?}");
        }
        assert!(bounds.extent().length() < 2010.0, "{bounds:?}");
    }

    #[test]
    fn a_strong_shear_is_an_outlier() {
        let unit = Aabb { lo: Vec3::splat(-1.0), hi: Vec3::splat(1.0) };
        let flatten = Affine3A::from_scale(Vec3::new(1.0, 1.0, 1e-7)) * Affine3A::from_rotation_y(0.7);
        let inverse = invert(&flatten).expect("regular");
        assert!(matches!(reach(&unit, &inverse), Some(Reach::Outlier)));
    }
}
