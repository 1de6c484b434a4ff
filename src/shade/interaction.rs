//! From a hit to everything a shader wants to know about the point.
//!
//! Positions come from the corners by barycentric weights, which is far more exact than `org + t · dir` (Wächter,
//! *Quasi-Monte Carlo Light Transport Simulation*, 2008). What few shaders ask for (the footprint, distances to edges, the clearance of secondary
//! rays) is computed when they do.

use crate::scene::{Mesh, SurfacePoint};
use crate::shade::footprint::Cone;
use crate::shade::placed::{Placed, reciprocal};
use crate::trace::{Hit, Ray};
use glam::{Vec2, Vec3, Vec4};
use std::cell::OnceCell;

/// A hit point, ready for shading.
#[derive(Clone)]
pub struct Interaction<'a> {
    pub point: SurfacePoint,
    /// Width of the cone at the point.
    pub cone: Cone,
    placed: &'a Placed,
    mesh: &'a Mesh,
    corners: [Vec3; 3],
    clearance: OnceCell<f32>,
}

/// Where a hit point is and how it lies: the part of it that needs arithmetic. [`super::points`] has it for many at a time.
#[derive(Clone, Copy)]
pub(super) struct Placement {
    pub position: Vec3,
    pub geometric_normal: Vec3,
    pub normal: Vec3,
    pub back_facing: bool,
}

/// Error bound of a secondary ray's origin in units of its position's magnitude: the roundings of interpolation, of
/// the transformation and of its inverse. Half of it is already enough for the millions of rays of test R15.
pub(super) const CLEARANCE: f32 = 16.0 * (f32::EPSILON * 0.5);

/// Error bound of the triangle test's distance. The test weighs the corners' distances (up to the triangle's size
/// apart) by areas whose error is ε·size², so the bound is in units of size × slenderness, size²/area. Twice what
/// test R15 needs.
pub(super) const TEST_CLEARANCE: f32 = 4.0 * (f32::EPSILON * 0.5);

impl<'a> Interaction<'a> {
    /// `ray` must have a direction of unit length; `placed` and `mesh` are those of the instance that was hit.
    #[inline(always)]
    pub fn new(ray: &Ray, hit: &Hit, placed: &'a Placed, mesh: &'a Mesh, cone: Cone, depth: u32) -> Self {
        let [i0, i1, i2] = mesh.triangles[hit.primitive as usize].map(|i| i as usize);
        let corners = [mesh.positions[i0], mesh.positions[i1], mesh.positions[i2]];
        let weights = weights(hit.u, hit.v);
        let local = corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2];
        let position = placed.point(local);

        let (object_normal, _) = scaled_normal(&corners);
        let mut geometric_normal = placed.normal(object_normal).normalize_or(-ray.direction);
        let mut normal = geometric_normal;
        if !mesh.normals.is_empty() {
            let n = [mesh.normals[i0], mesh.normals[i1], mesh.normals[i2]];
            let outward = placed.normal(n[0] + n[1] + n[2]);
            if outward.dot(geometric_normal) < 0.0 {
                geometric_normal = -geometric_normal;
            }
            let mixed = n[0] * weights[0] + n[1] * weights[1] + n[2] * weights[2];
            normal = placed.normal(mixed).normalize_or(geometric_normal);
        }
        let back_facing = geometric_normal.dot(ray.direction) > 0.0;
        if back_facing {
            geometric_normal = -geometric_normal;
            normal = -normal;
        }
        normal = towards_viewer(normal, ray.direction);
        let placement = Placement { position, geometric_normal, normal, back_facing };
        Self::placed_at(placement, ray.direction, hit, placed, mesh, cone, depth)
    }

    /// As [`Interaction::new`], where the geometry of the point is known.
    #[inline(always)]
    pub(super) fn placed_at(
        at: Placement,
        incoming: Vec3,
        hit: &Hit,
        placed: &'a Placed,
        mesh: &'a Mesh,
        cone: Cone,
        depth: u32,
    ) -> Self {
        let indices = mesh.triangles[hit.primitive as usize].map(|i| i as usize);
        let corners = indices.map(|i| mesh.positions[i]);
        let (weights, [i0, i1, i2]) = (weights(hit.u, hit.v), indices);
        let mix2 = |values: &[Vec2]| values[i0] * weights[0] + values[i1] * weights[1] + values[i2] * weights[2];
        let mix4 = |values: &[Vec4]| values[i0] * weights[0] + values[i1] * weights[1] + values[i2] * weights[2];
        let tex_coord = if mesh.tex_coords.is_empty() { Vec2::ZERO } else { mix2(&mesh.tex_coords) };
        let color = if mesh.colors.is_empty() { Vec4::ONE } else { mix4(&mesh.colors) };
        let point = SurfacePoint {
            position: at.position,
            geometric_normal: at.geometric_normal,
            normal: at.normal,
            incoming,
            tex_coord,
            color,
            barycentric: Vec2::new(hit.u, hit.v),
            distance: hit.t,
            object: hit.object,
            instance: hit.instance,
            primitive: hit.primitive,
            back_facing: at.back_facing,
            depth,
        };
        Self { point, cone: cone.advanced(hit.t), placed, mesh, corners, clearance: OnceCell::new() }
    }

    /// Area of texture space that the ray's cone covers, for choosing the mip level.
    pub fn footprint(&self) -> f32 {
        if self.mesh.tex_coords.is_empty() {
            return 0.0;
        }
        let [a, b, c] = self.mesh.triangles[self.point.primitive as usize].map(|i| self.mesh.tex_coords[i as usize]);
        let double_area_uv = (b - a).perp_dot(c - a).abs();
        let cosine = self.point.geometric_normal.dot(self.point.incoming).abs().max(1e-3);
        let [edge1, edge2] = self.world_edges();
        self.cone.width * self.cone.width / cosine * (double_area_uv / edge1.cross(edge2).length())
    }

    /// Distances in world units from the point to the edges opposite to the three corners.
    pub fn edge_distance(&self) -> Vec3 {
        let weights = weights(self.point.barycentric.x, self.point.barycentric.y);
        let [edge1, edge2] = self.world_edges();
        let double_area = edge1.cross(edge2).length();
        Vec3::new(
            weights[0] * double_area / (edge2 - edge1).length(),
            weights[1] * double_area / edge2.length(),
            weights[2] * double_area / edge1.length(),
        )
    }

    /// Derivatives of the position with respect to the texture coordinates s and t, in world space; None where the triangle
    /// has no area in texture space.
    pub fn tangents(&self) -> Option<[Vec3; 2]> {
        if self.mesh.tex_coords.is_empty() {
            return None;
        }
        let [a, b, c] = self.mesh.triangles[self.point.primitive as usize].map(|i| self.mesh.tex_coords[i as usize]);
        let (uv1, uv2) = (b - a, c - a);
        let area = uv1.perp_dot(uv2);
        let [edge1, edge2] = self.world_edges();
        let both = [(edge1 * uv2.y - edge2 * uv1.y) / area, (edge2 * uv1.x - edge1 * uv2.x) / area];
        (area != 0.0 && both[0].is_finite() && both[1].is_finite()).then_some(both)
    }

    /// The same point with another shading normal (unit length), which is bent until the viewer sees its side.
    pub fn with_normal(&self, normal: Vec3) -> Self {
        let mut turned = self.clone();
        turned.point.normal = towards_viewer(normal, self.point.incoming);
        turned
    }

    fn world_edges(&self) -> [Vec3; 2] {
        let [a, b, c] = self.corners;
        [b - a, c - a].map(|edge| self.placed.vector(edge))
    }

    /// Distance along the geometric normal that a secondary ray's origin needs.
    fn clearance(&self) -> f32 {
        *self.clearance.get_or_init(|| {
            let [a, b, c] = self.corners;
            let (object_normal, size) = scaled_normal(&self.corners);
            let magnitude = a.abs().max(b.abs()).max(c.abs());
            let bound = self.placed.round_trip(magnitude);
            let [edge1, edge2] = self.world_edges();
            let world_size = edge1.abs().max(edge2.abs()).max_element();
            let double_area = edge1.cross(edge2).length();
            CLEARANCE * self.point.geometric_normal.abs().dot(bound)
                + TEST_CLEARANCE * size * self.placed.stretch() * (1.0 + reciprocal(object_normal.length()))
                // A static instance is met in world space, where the triangle may be the thinner needle.
                + TEST_CLEARANCE * world_size * reciprocal(double_area * reciprocal(world_size).powi(2))
        })
    }

    /// A ray from the point along `direction` (unit length) that cannot meet the triangle it starts on: its origin is
    /// moved along the geometric normal, to the side into which it leaves, by a bound of all rounding errors between
    /// here and the triangle test (after Ize, *Robust BVH Ray Traversal*, 2013, and pbrt-v4 §6.8; the bound itself is
    /// our own).
    pub fn spawn(&self, direction: Vec3) -> Ray {
        let n = self.point.geometric_normal;
        let clearance = self.clearance();
        let side = if direction.dot(n) >= 0.0 { clearance } else { -clearance };
        Ray { origin: self.point.position + n * side, tmin: 0.0, direction, tmax: f32::INFINITY }
    }
}

/// Barycentric weights of the three corners.
#[inline]
fn weights(u: f32, v: f32) -> [f32; 3] {
    [(1.0 - u) - v, u, v]
}

/// The normal of a triangle scaled to a size of about 1, and the size.
#[inline]
fn scaled_normal(corners: &[Vec3; 3]) -> (Vec3, f32) {
    let (edge1, edge2) = (corners[1] - corners[0], corners[2] - corners[0]);
    let size = edge1.abs().max_element().max(edge2.abs().max_element());
    let shrink = reciprocal(size);
    ((edge1 * shrink).cross(edge2 * shrink), size)
}

/// Least cosine of the angle at which a shading normal meets the viewer's eye.
pub(super) const GRAZING: f32 = 1e-3;

/// A shading normal that the viewer cannot see (interpolated normals at a silhouette) is bent until it is just visible.
#[inline]
fn towards_viewer(n: Vec3, incoming: Vec3) -> Vec3 {
    let cosine = -n.dot(incoming);
    if cosine >= GRAZING { n } else { (n - incoming * (GRAZING - cosine)).normalize_or(-incoming) }
}
