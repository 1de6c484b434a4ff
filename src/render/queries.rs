//! Questions about the scene of the last frame or commit, outside of pictures: rays, all hits of a ray, what lies at a hit, the nearest point.
//!
//! Everything runs on the thread that asks, in the default floating-point environment, and allocates nothing (but see [`Queries::closest_point`]).

use crate::accel::WorldView;
use crate::scene::{Mask, Mesh, Name, Scene};
use crate::shade::{Cone, Interaction, Placed};
use crate::threads::with_default_floats;
use crate::trace::{ClosestPoint, Hit, Ray, Tracer, closest_point};
use glam::{Affine3A, Vec2, Vec3, Vec4};
use std::collections::HashMap;
use std::sync::Arc;

/// The meshes that structures were made from.
#[derive(Clone, Copy)]
pub(super) enum Meshes<'a> {
    /// Those of a scene to which nothing was done since.
    Scene(&'a Scene),
    /// Those of a snapshot.
    Held(&'a HashMap<Name, Arc<Mesh>>),
}

impl<'a> Meshes<'a> {
    fn of(self, object: Name) -> Option<&'a Arc<Mesh>> {
        match self {
            Meshes::Scene(scene) => scene.objects.get(&object).map(|object| &object.mesh),
            Meshes::Held(meshes) => meshes.get(&object),
        }
    }
}

/// See the module head. Cheap to copy; any number of threads may ask at a time.
#[derive(Clone, Copy)]
pub struct Queries<'a> {
    tracer: Tracer<'a>,
    meshes: Meshes<'a>,
}

/// What lies at a hit, in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HitSurface {
    pub position: Vec3,
    /// Unit length. To the side from which the corners run counter-clockwise, or to that of the vertices' normals if the mesh has some.
    pub geometric_normal: Vec3,
    /// Unit length: interpolated from the vertices' normals, else the geometric one.
    pub normal: Vec3,
    /// Interpolated; 0 without.
    pub tex_coord: Vec2,
    /// Linear RGBA of the vertices, interpolated; 1 without.
    pub color: Vec4,
    /// The triangle's shader; 0 is the default surface.
    pub shader: Name,
    /// Whether the ray came from the side to which the geometric normal points.
    pub front_facing: bool,
}

impl<'a> Queries<'a> {
    pub(super) fn new(tracer: Tracer<'a>, meshes: Meshes<'a>) -> Self {
        Self { tracer: tracer.masked(Mask::QUERY), meshes }
    }

    /// The same questions by rays that see the instances which have a bit in common with `mask`; at first that is [`Mask::QUERY`].
    pub fn masked(&self, mask: Mask) -> Self {
        Self { tracer: self.tracer.masked(mask), ..*self }
    }

    /// The closest hit of `ray`. A ray that is not finite, or has no direction, hits nothing.
    #[inline]
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        with_default_floats(|| self.tracer.intersect(ray)).map(|hit| self.told(hit))
    }

    /// Whether anything lies on `ray` between its ends; faster than [`Queries::intersect`].
    #[inline]
    pub fn is_occluded(&self, ray: &Ray) -> bool {
        with_default_floats(|| self.tracer.occluded(ray))
    }

    /// The closest hit of each ray, [`Hit::MISS`] for none. Neighbours in `rays` should be neighbours in space.
    ///
    /// # Panics
    /// When the slices differ in length.
    #[inline]
    pub fn intersect_into(&self, rays: &[Ray], hits: &mut [Hit]) {
        with_default_floats(|| self.tracer.intersect_into(rays, hits));
        if self.view().has_numbers() {
            hits.iter_mut().for_each(|hit| *hit = self.told(*hit));
        }
    }

    /// A hit as the application is told of it: the instance is the one that it has placed itself.
    #[inline]
    fn told(&self, hit: Hit) -> Hit {
        Hit { instance: self.view().number_of(hit.instance), ..hit }
    }

    /// Whether anything lies on each ray.
    ///
    /// # Panics
    /// When the slices differ in length.
    #[inline]
    pub fn occluded_into(&self, rays: &[Ray], answers: &mut [bool]) {
        with_default_floats(|| self.tracer.occluded_many(rays, answers));
    }

    /// Calls `visit` with the hits of `ray` in ascending order, by distance and then by numbers, until it returns false. Each costs the
    /// search for a closest hit.
    pub fn each_hit(&self, ray: &Ray, mut visit: impl FnMut(&Hit) -> bool) {
        with_default_floats(|| self.tracer.each_hit(ray, |hit| visit(&self.told(*hit))));
    }

    /// What lies at a hit of `ray` in this scene. None if the scene has no such triangle.
    pub fn surface(&self, ray: &Ray, hit: &Hit) -> Option<HitSurface> {
        let mesh = self.meshes.of(hit.object)?;
        mesh.triangles.get(hit.primitive as usize)?;
        let world_from_object = self.world_from_object(ray, hit, mesh.corners(hit.primitive))?;
        Some(with_default_floats(|| {
            let ray = Ray { direction: unit(ray.direction), ..*ray };
            let placed = Placed::new(world_from_object);
            let point = Interaction::new(&ray, hit, &placed, mesh, Cone { width: 0.0, spread: 0.0 }, 0).point;
            let side = if point.back_facing { -1.0 } else { 1.0 };
            let normal = if mesh.normals.is_empty() { point.geometric_normal } else { point.normal };
            HitSurface {
                position: point.position,
                geometric_normal: point.geometric_normal * side,
                normal: normal * side,
                tex_coord: point.tex_coord,
                color: point.color,
                shader: mesh.shader_of_triangle.get(hit.primitive as usize).copied().unwrap_or(0),
                front_facing: !point.back_facing,
            }
        }))
    }

    /// The point of the scene that is nearest to `point`, no farther away than `max_distance`; on instances that have a bit in common with the mask.
    ///
    /// Objects whose structure is no bounding volume hierarchy get one for such questions, at the first one after a change; without memory for it
    /// all of their triangles are looked at.
    pub fn closest_point(&self, point: Vec3, max_distance: f32) -> Option<ClosestPoint> {
        with_default_floats(|| {
            let nearest =
                closest_point::in_scene(self.tracer.scope(), point, max_distance, |o| self.meshes.of(o).map(|m| &**m));
            nearest.map(|found| ClosestPoint { instance: self.view().number_of(found.instance), ..found })
        })
    }

    /// The point of one object, in its own space, that is nearest to `point`. None also for an object that no instance shows.
    pub fn closest_point_on(&self, object: Name, point: Vec3, max_distance: f32) -> Option<ClosestPoint> {
        let mesh = self.meshes.of(object)?;
        with_default_floats(|| closest_point::on_mesh(self.view(), object, mesh, point, max_distance))
    }

    /// Whether some instance shows an object.
    pub fn shows(&self, object: Name) -> bool {
        object != 0 && self.view().instances().iter().any(|record| record.object == object)
    }

    /// What rays traverse.
    pub fn view(&self) -> &'a WorldView {
        self.tracer.world()
    }

    /// Where the triangle of a hit is. A composite may hold its object several times: then it is there where the ray has met the triangle.
    fn world_from_object(&self, ray: &Ray, hit: &Hit, [a, b, c]: [Vec3; 3]) -> Option<Affine3A> {
        let local = a * ((1.0 - hit.u) - hit.v) + b * hit.u + c * hit.v;
        let met = ray.origin + ray.direction * hit.t;
        let apart = |m: &Affine3A| m.transform_point3(local).distance_squared(met);
        let places = self.view().instances_of(hit.instance).filter(|record| record.object == hit.object);
        places.map(|record| record.world_from_object).min_by(|m, n| apart(m).total_cmp(&apart(n)))
    }
}

/// Of unit length, whatever its own.
fn unit(v: Vec3) -> Vec3 {
    (v / v.abs().max_element()).normalize_or_zero()
}
