//! From a hit to everything a shader wants to know about the point.
//!
//! Positions come from the corners by barycentric weights, which is far more exact than `org + t · dir` (Wächter,
//! *Quasi-Monte Carlo Light Transport Simulation*, 2008). Normals go through the cofactor matrix: it is the inverse
//! transpose up to a factor, exists for singular matrices too, and its sign under mirrors is that of the determinant.

use crate::scene::{Instance, Mesh, SurfacePoint};
use crate::shade::footprint::Cone;
use crate::trace::{Hit, Ray};
use glam::{Affine3A, Mat3A, Vec2, Vec3, Vec3A, Vec4};

/// A hit point, ready for shading.
pub struct Interaction {
    pub point: SurfacePoint,
    /// Distance along the geometric normal that a secondary ray's origin needs; see [`Interaction::spawn`].
    pub clearance: f32,
    /// Area of texture space that the ray's cone covers, for choosing the mip level.
    pub footprint: f32,
    /// Width of the cone at the point.
    pub cone: Cone,
    /// Distances in world units from the point to the edges opposite to the three corners.
    pub edge_distance: Vec3,
}

/// Error bound of a secondary ray's origin in units of its position's magnitude: the roundings of interpolation, of
/// the transformation and of its inverse. Half of it is already enough for the millions of rays of test R15.
const CLEARANCE: f32 = 16.0 * (f32::EPSILON * 0.5);

/// Error bound of the triangle test's distance. The test weighs the corners' distances (up to the triangle's size
/// apart) by areas whose error is ε·size², so the bound is in units of size × slenderness, size²/area. Twice what
/// test R15 needs.
const TEST_CLEARANCE: f32 = 4.0 * (f32::EPSILON * 0.5);

impl Interaction {
    /// `ray` must have a direction of unit length.
    pub fn new(ray: &Ray, hit: &Hit, instance: &Instance, mesh: &Mesh, cone: Cone, depth: u32) -> Self {
        let world_from_object = instance.world_from_object;
        let [i0, i1, i2] = mesh.triangles[hit.prim as usize].map(|i| i as usize);
        let corners = [mesh.positions[i0], mesh.positions[i1], mesh.positions[i2]];
        let weights = [(1.0 - hit.u) - hit.v, hit.u, hit.v];
        let local = corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2];
        let position = world_from_object.transform_point3(local);
        let cone = cone.advanced(hit.t);

        // Scaled to 1, so that neither tiny nor huge matrices leave the range of f32.
        let linear = world_from_object.matrix3;
        let linear_scaled = linear * reciprocal(largest(linear));
        let cofactor = cofactor(linear_scaled);
        let determinant = linear_scaled.x_axis.dot(cofactor.x_axis);
        let orientation = if determinant < 0.0 { -1.0 } else { 1.0 };

        let (edge1, edge2) = (corners[1] - corners[0], corners[2] - corners[0]);
        let size = edge1.abs().max_element().max(edge2.abs().max_element());
        let shrink = reciprocal(size);
        let object_normal = (edge1 * shrink).cross(edge2 * shrink);
        let mut geometric_normal =
            Vec3::from(cofactor * Vec3A::from(object_normal) * orientation).normalize_or(-ray.dir);

        let mut normal = geometric_normal;
        if !mesh.normals.is_empty() {
            let n = [mesh.normals[i0], mesh.normals[i1], mesh.normals[i2]];
            let outward = Vec3::from(cofactor * Vec3A::from(n[0] + n[1] + n[2]) * orientation);
            if outward.dot(geometric_normal) < 0.0 {
                geometric_normal = -geometric_normal;
            }
            let mixed = n[0] * weights[0] + n[1] * weights[1] + n[2] * weights[2];
            normal = Vec3::from(cofactor * Vec3A::from(mixed) * orientation).normalize_or(geometric_normal);
        }
        let back_facing = geometric_normal.dot(ray.dir) > 0.0;
        if back_facing {
            geometric_normal = -geometric_normal;
            normal = -normal;
        }
        normal = towards_viewer(normal, ray.dir);

        let mix2 = |values: &[Vec2]| values[i0] * weights[0] + values[i1] * weights[1] + values[i2] * weights[2];
        let mix4 = |values: &[Vec4]| values[i0] * weights[0] + values[i1] * weights[1] + values[i2] * weights[2];
        let tex_coord = if mesh.tex_coords.is_empty() { Vec2::ZERO } else { mix2(&mesh.tex_coords) };
        let color = if mesh.colors.is_empty() { Vec4::ONE } else { mix4(&mesh.colors) };

        let world_edges = [edge1, edge2].map(|e| Vec3::from(linear * Vec3A::from(e)));
        let world_size = world_edges[0].abs().max(world_edges[1].abs()).max_element();
        let double_area = world_edges[0].cross(world_edges[1]).length();
        let footprint = if mesh.tex_coords.is_empty() {
            0.0
        } else {
            let t = &mesh.tex_coords;
            let double_area_uv = (t[i1] - t[i0]).perp_dot(t[i2] - t[i0]).abs();
            let cosine = geometric_normal.dot(ray.dir).abs().max(1e-3);
            cone.width * cone.width / cosine * (double_area_uv / double_area)
        };
        let edge_distance = Vec3::new(
            weights[0] * double_area / (world_edges[1] - world_edges[0]).length(),
            weights[1] * double_area / world_edges[1].length(),
            weights[2] * double_area / world_edges[0].length(),
        );

        let magnitude = corners[0].abs().max(corners[1].abs()).max(corners[2].abs());
        let clearance = clearance(world_from_object, cofactor, determinant, magnitude, geometric_normal)
            + TEST_CLEARANCE * size * row_sum(linear) * (1.0 + reciprocal(object_normal.length()))
            // A static instance is met in world space, where the triangle may be the thinner needle.
            + TEST_CLEARANCE * world_size * reciprocal(double_area * reciprocal(world_size).powi(2));
        let point = SurfacePoint {
            position,
            geometric_normal,
            normal,
            incoming: ray.dir,
            tex_coord,
            color,
            barycentric: Vec2::new(hit.u, hit.v),
            distance: hit.t,
            object: hit.object,
            instance: hit.instance,
            primitive: hit.prim,
            back_facing,
            depth,
        };
        Self { point, clearance, footprint, cone, edge_distance }
    }

    /// A ray from the point along `direction` (unit length) that cannot meet the triangle it starts on: its origin is
    /// moved along the geometric normal, to the side into which it leaves, by a bound of all rounding errors between
    /// here and the triangle test (after Ize, *Robust BVH Ray Traversal*, 2013, and pbrt-v4 §6.8; the bound itself is
    /// our own).
    pub fn spawn(&self, direction: Vec3) -> Ray {
        let n = self.point.geometric_normal;
        let side = if direction.dot(n) >= 0.0 { self.clearance } else { -self.clearance };
        Ray { org: self.point.position + n * side, tmin: 0.0, dir: direction, tmax: f32::INFINITY }
    }
}

/// How far a point computed on a triangle can lie from it, along its normal `n`, by the time a ray from there has
/// been transformed into the object's space. `magnitude` bounds the corners' coordinates.
///
/// In the world the point is off by ε(|M||p| + |t|) =: εW. The way back multiplies by |M⁻¹|, and the errors made there
/// come out again through |M|, so that ε·|M||M⁻¹|W bounds all of them; where M is orthogonal that is at most 3W.
/// (The caller adds the error of the triangle test itself, which counts along any normal.)
fn clearance(world_from_object: Affine3A, cofactor: Mat3A, determinant: f32, magnitude: Vec3, n: Vec3) -> f32 {
    let linear = abs(world_from_object.matrix3);
    let reach = linear * Vec3A::from(magnitude) + world_from_object.translation.abs();
    // |M⁻¹| = |cofactorᵀ| / |det|; the scale of `cofactor` cancels but for one factor, as M is unscaled.
    let scale = reciprocal(largest(world_from_object.matrix3));
    let round_trip = linear * (abs(cofactor).transpose() * reach) * (scale / determinant.abs());
    let bound = Vec3::from(if round_trip.is_finite() { round_trip.max(reach) } else { reach });
    CLEARANCE * n.abs().dot(bound)
}

/// A shading normal that the viewer cannot see (interpolated normals at a silhouette) is bent until it is just visible.
fn towards_viewer(n: Vec3, incoming: Vec3) -> Vec3 {
    const GRAZING: f32 = 1e-3;
    let cosine = -n.dot(incoming);
    if cosine >= GRAZING { n } else { (n - incoming * (GRAZING - cosine)).normalize_or(-incoming) }
}

fn cofactor(m: Mat3A) -> Mat3A {
    Mat3A::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis))
}

fn abs(m: Mat3A) -> Mat3A {
    Mat3A::from_cols(m.x_axis.abs(), m.y_axis.abs(), m.z_axis.abs())
}

fn largest(m: Mat3A) -> f32 {
    m.x_axis.abs().max(m.y_axis.abs()).max(m.z_axis.abs()).max_element()
}

/// The largest factor by which `m` can stretch a component.
fn row_sum(m: Mat3A) -> f32 {
    (m.x_axis.abs() + m.y_axis.abs() + m.z_axis.abs()).max_element()
}

/// 1/x, or 1 where that is of no use.
fn reciprocal(x: f32) -> f32 {
    let r = 1.0 / x;
    if r.is_finite() && r > 0.0 { r } else { 1.0 }
}
