//! The rays of a picture with mirrors, as batches: primary rays, shadow rays to every light, first reflections, and their shadow rays.
//!
//! What Larsson03 §4 traces. Nothing is shaded, so what is timed is the structure; the same rays are made whatever structure finds the hits.

use glam::Vec3;
use openrt::accel::TwoLevel;
use openrt::scene::{Name, Scene};
use openrt::trace::{Hit, Ray, Tracer};
use rayon::prelude::*;

/// Rays per call, as a job of the renderer has.
const JOB: usize = 4096;

pub struct Scenery<'a> {
    /// Whose objects all stand where they are, untransformed.
    pub scene: &'a Scene,
    pub lights: &'a [Vec3],
    /// Whether an object mirrors.
    pub mirrors: fn(Name) -> bool,
}

impl Scenery<'_> {
    /// Traces everything that begins with these primary rays; gives how many rays hit.
    pub fn trace(&self, world: &TwoLevel, primary: &[Ray]) -> usize {
        let tracer = Tracer::new(world);
        let job = |rays: &[Ray]| {
            let (seen, mirrored) = self.level(&tracer, rays, true);
            seen + self.level(&tracer, &mirrored, false).0
        };
        primary.par_chunks(JOB).map(job).sum()
    }

    /// Closest hits, their shadow rays, and the rays that are mirrored.
    fn level(&self, tracer: &Tracer, rays: &[Ray], mirror: bool) -> (usize, Vec<Ray>) {
        let hits = tracer.intersect_many(rays);
        let at = |ray: &Ray, hit: &Hit| ray.origin + ray.direction * (hit.t * 0.9999);
        let found = || rays.iter().zip(&hits).filter_map(|(ray, hit)| Some((ray, hit.as_ref()?)));
        let mut count = 0;
        for light in self.lights {
            let shadow = |(ray, hit)| {
                let at = at(ray, hit);
                Ray { tmax: 1.0, ..Ray::new(at, *light - at) }
            };
            let shadows: Vec<Ray> = found().map(shadow).collect();
            let mut dark = vec![false; shadows.len()];
            tracer.occluded_many(&shadows, &mut dark);
            count += shadows.len() + dark.iter().filter(|&&dark| dark).count();
        }
        let mirrored = |(ray, hit): (&Ray, &Hit)| {
            let [a, b, c] = self.scene.objects[&hit.object].mesh.corners(hit.primitive);
            let normal = (b - a).cross(c - a).normalize_or_zero();
            Ray::new(at(ray, hit), ray.direction - normal * (2.0 * ray.direction.dot(normal)))
        };
        let mirrors = found().filter(|(_, hit)| mirror && (self.mirrors)(hit.object));
        let mirrored = mirrors.map(mirrored).collect();
        (count, mirrored)
    }
}
