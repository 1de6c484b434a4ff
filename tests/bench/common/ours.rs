//! Our side: a scene's frame in the structures of the library.

use crate::measure::Worker;
use crate::scenes::BenchScene;
use glam::Vec3;
use openrt::accel::TwoLevel;
use openrt::scene::{Command, Instance, Mesh, Scene};
use openrt::simd::Level;
use openrt::threads::Pool;
use openrt::trace::{Hit, Ray, Tracer};

/// A scene of the bench, built.
pub struct Ours {
    pub scene: Scene,
    pub instances: Vec<Instance>,
    pub world: TwoLevel,
}

impl Ours {
    /// Object `i + 1` is part `i`.
    pub fn new(bench: &BenchScene, frame: u32, pool: &Pool) -> Ours {
        let mut scene = Scene::default();
        for (name, part) in (1..).zip(&bench.parts) {
            let mesh =
                Mesh { positions: (part.positions)(frame), triangles: part.triangles.clone(), ..Mesh::default() };
            scene.apply(Command::DefineObject { name, mesh, motion: part.motion });
        }
        let place = |p: crate::scenes::Placement| Instance::new(p.part as u32 + 1, p.transform);
        let instances: Vec<Instance> = (bench.place)(frame).into_iter().map(place).collect();
        let mut world = TwoLevel::new(Level::detect());
        pool.install(|| world.update(&scene, &instances));
        Ours { scene, instances, world }
    }

    pub fn tracer(&self) -> Tracer<'_> {
        Tracer::new(&self.world)
    }

    /// The geometric normal of a hit in world space; of no particular side. NaN for a triangle without area.
    pub fn normal(&self, hit: &Hit) -> Vec3 {
        let corners = self.scene.objects[&hit.object].mesh.corners(hit.primitive);
        let to_world = &self.instances[hit.instance as usize].world_from_object;
        let [a, b, c] = corners.map(|p| to_world.transform_point3(p));
        (b - a).cross(c - a).normalize()
    }
}

type Closest = fn(&Tracer, &[Ray], &mut [Hit]);
type Any = fn(&Tracer, &[Ray], &mut [bool]);

/// One way to trace a chunk: its name, whether ray by ray, and the calls. Every mode competes for "ours best".
pub struct Mode {
    pub name: &'static str,
    pub single: bool,
    pub closest: Closest,
    pub any: Any,
}

/// All our modes.
pub const MODES: &[Mode] = &[
    Mode {
        name: "single",
        single: true,
        closest: |tracer, rays, hits| {
            for (ray, hit) in rays.iter().zip(hits) {
                *hit = tracer.intersect(ray).unwrap_or(Hit::MISS);
            }
        },
        any: |tracer, rays, answers| {
            for (ray, answer) in rays.iter().zip(answers) {
                *answer = tracer.occluded(ray);
            }
        },
    },
    Mode {
        name: "many",
        single: false,
        closest: |tracer, rays, hits| tracer.intersect_into(rays, hits),
        any: |tracer, rays, answers| tracer.occluded_many(rays, answers),
    },
];

/// Traces closest hits by a mode.
pub struct ClosestWorker<'a> {
    pub tracer: Tracer<'a>,
    pub call: Closest,
    pub rays: Vec<Ray>,
    pub found: Vec<Hit>,
}

impl Worker for ClosestWorker<'_> {
    fn load(&mut self, rays: &[Ray]) {
        self.rays.clear();
        self.rays.extend_from_slice(rays);
        self.found.clear();
        self.found.resize(rays.len(), Hit::MISS);
    }

    fn trace(&mut self) {
        (self.call)(&self.tracer, &self.rays, &mut self.found);
    }

    fn hits(&self) -> usize {
        self.found.iter().filter(|hit| !hit.is_miss()).count()
    }
}

/// Traces shadow rays by a mode.
pub struct AnyWorker<'a> {
    pub tracer: Tracer<'a>,
    pub call: Any,
    pub rays: Vec<Ray>,
    pub found: Vec<bool>,
}

impl Worker for AnyWorker<'_> {
    fn load(&mut self, rays: &[Ray]) {
        self.rays.clear();
        self.rays.extend_from_slice(rays);
        self.found.clear();
        self.found.resize(rays.len(), false);
    }

    fn trace(&mut self) {
        (self.call)(&self.tracer, &self.rays, &mut self.found);
    }

    fn hits(&self) -> usize {
        self.found.iter().filter(|&&hit| hit).count()
    }
}
