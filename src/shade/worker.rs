//! A worker carries the camera samples of tiles, one tile after the other. It owns all that changes while rays fly, so that
//! tiles share nothing but read-only data.

use crate::memory::{OutOfMemory, Room, boxed};
use crate::scene::Mask;
use crate::shade::footprint::Cone;
use crate::shade::integrator::Integrator;
use crate::shade::interaction::Interaction;
use crate::shade::sampler::Rng;
use crate::shade::samples::{Batch, Together};
use crate::shade::shade_scene::ShadeScene;
use crate::trace::{Hit, PacketMemory, Ray, Tracer};
use glam::{Vec3, Vec4};
use std::sync::atomic::{AtomicBool, Ordering};

/// Rays by purpose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayCounts {
    pub primary: u64,
    pub shadow: u64,
    pub secondary: u64,
}

/// What one camera sample saw.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Linear RGB multiplied by coverage, and coverage; always finite.
    pub color: Vec4,
    /// The first visible point; None where the ray left the scene.
    pub seen: Option<Seen>,
}

/// The first point of a camera ray that is not transparent.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    pub distance: f32,
    pub normal: Vec3,
    pub object: u32,
    pub instance: u32,
}

/// State of a ray that continues a path from the camera.
#[derive(Clone, Copy)]
pub(crate) struct Bounce {
    /// Bounces so far.
    pub depth: u32,
    /// Upper bound of the ray's share in the pixel.
    pub weight: f32,
    pub cone: Cone,
}

pub struct Worker<'a> {
    pub(crate) scene: &'a ShadeScene<'a>,
    pub(crate) tracer: Tracer<'a>,
    pub(crate) integrator: Integrator,
    pub counts: RayCounts,
    pub(crate) rng: Rng,
    pub(crate) seen: Option<Seen>,
    /// Bounces that the current sample may still send.
    pub(super) budget: u32,
    pub(super) memory: WorkerMemory,
    pub(super) together: Option<Together>,
    /// When it is raised, samples end soon and mean nothing.
    cancel: &'a AtomicBool,
}

/// For workers that nobody cancels.
static NEVER: AtomicBool = AtomicBool::new(false);

/// What [`Worker::samples`] works in: kept from packet to packet, tile to tile and frame to frame. What is not there is made when it is needed.
#[derive(Default)]
pub struct WorkerMemory {
    pub(super) packet: Option<PacketMemory>,
    pub(super) batch: Option<Box<Batch>>,
    /// For parameter blocks of the user's shaders; one is taken per level of recursion and given back.
    pub(super) patches: Vec<Vec<u8>>,
}

impl WorkerMemory {
    /// Makes everything that a frame can need (see [`ShadeScene::patches`]), and forgets the frame before.
    ///
    /// # Errors
    /// No memory.
    pub fn prepare(&mut self, (levels, bytes): (usize, usize)) -> Result<(), OutOfMemory> {
        if self.packet.is_none() {
            self.packet = Some(PacketMemory::try_new()?);
        }
        match &mut self.batch {
            Some(batch) => batch.forget(),
            none => *none = Some(boxed(Batch::default())?),
        }
        if bytes > 0 {
            self.patches.room(levels.saturating_sub(self.patches.len()))?;
            self.patches.resize_with(levels.max(self.patches.len()), Vec::new);
            for patch in &mut self.patches {
                patch.clear();
                patch.room(bytes)?;
            }
        }
        Ok(())
    }
}

/// Bounces of one camera sample. A tree of mirrors and glass doubles at every level; this keeps one pixel from taking
/// for ever.
pub(super) const BUDGET: u32 = 1 << 14;
/// Rays with a smaller share in the pixel are not sent (Hall and Greenberg 1983): half a step of an 8-bit channel.
const MIN_WEIGHT: f32 = 1.0 / 512.0;
/// Transparent layers that one ray passes before it gives up.
pub const MAX_LAYERS: u32 = 256;
/// Shadow rays end this much before the light, relative to its distance: lights often lie on a surface.
pub(super) const SHADOW_END: f32 = 1.0 - 1e-4;

impl<'a> Worker<'a> {
    pub fn new(scene: &'a ShadeScene<'a>, tracer: Tracer<'a>, memory: WorkerMemory) -> Self {
        Self::with_integrator(scene, tracer, memory, scene.integrator)
    }

    /// Whatever the rendering object of the scene is, a worker that sends no rays but those of the camera.
    pub fn primary_only(scene: &'a ShadeScene<'a>, tracer: Tracer<'a>, memory: WorkerMemory) -> Self {
        Self::with_integrator(scene, tracer, memory, Integrator::RAYCAST)
    }

    fn with_integrator(
        scene: &'a ShadeScene<'a>,
        tracer: Tracer<'a>,
        memory: WorkerMemory,
        integrator: Integrator,
    ) -> Self {
        let (counts, rng) = (RayCounts::default(), Rng::new(0, 0, 0));
        let (seen, budget, together, cancel) = (None, 0, None, &NEVER);
        let mut worker = Self { scene, tracer, integrator, counts, rng, seen, budget, memory, together, cancel };
        worker.together = worker.find_together();
        worker
    }

    /// A worker that ends its samples when `cancel` is raised. It looks before each ray after the camera's, as one sample may send billions.
    pub fn until(self, cancel: &'a AtomicBool) -> Self {
        Self { cancel, ..self }
    }

    /// Whether samples are given up.
    #[inline]
    pub fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }

    /// What the next worker works in.
    pub fn into_memory(self) -> WorkerMemory {
        self.memory
    }

    /// Radiance along `ray`, whose closest hit is known: RGB multiplied by coverage, and coverage.
    pub(crate) fn radiance(&mut self, ray: Ray, hit: Option<Hit>, bounce: Bounce) -> Vec4 {
        match self.integrator {
            Integrator::Whitted { .. } => self.whitted(ray, hit, bounce),
            Integrator::Path { max_depth, roulette_depth } => self.path(ray, hit, bounce, max_depth, roulette_depth),
            Integrator::AmbientOcclusion { samples, distance } => self.occlusion(ray, hit, bounce, samples, distance),
        }
    }

    /// Radiance along a new ray from a point; black beyond the recursion limit and for shares too small to see.
    /// `weight` is the ray's share in what the point sends, `spread` the angle by which the bounce scatters.
    pub(crate) fn bounce(&mut self, it: &Interaction, direction: Vec3, weight: f32, spread: f32, from: Bounce) -> Vec3 {
        let weight = from.weight * weight;
        // Written so that NaN ends here too.
        if !(weight >= MIN_WEIGHT) || from.depth >= self.integrator.max_depth() || self.budget == 0 {
            return Vec3::ZERO;
        }
        if self.is_cancelled() {
            return Vec3::ZERO;
        }
        self.budget -= 1;
        self.counts.secondary += 1;
        let ray = it.spawn(direction);
        let hit = self.closest(&ray, from.depth + 1);
        let cone = it.cone.widened(spread);
        self.radiance(ray, hit, Bounce { depth: from.depth + 1, weight, cone }).truncate()
    }

    /// The closest hit of a ray after `depth` bounces, among what such rays see.
    pub(crate) fn closest(&self, ray: &Ray, depth: u32) -> Option<Hit> {
        let mask = if depth == 0 { Mask::CAMERA } else { Mask::REFLECTION };
        self.tracer.masked(mask).intersect(ray)
    }

    /// Share of light that reaches the point from `distance` along `direction` (unit length).
    pub(crate) fn transmittance(&mut self, it: &Interaction, direction: Vec3, distance: f32) -> Vec3 {
        self.counts.shadow += 1;
        let tracer = self.tracer.masked(Mask::SHADOW);
        let mut ray = Ray { tmax: distance * SHADOW_END, ..it.spawn(direction) };
        if !self.scene.see_through {
            return if tracer.occluded(&ray) { Vec3::ZERO } else { Vec3::ONE };
        }
        // Some surfaces let light through: ask them one by one. `occluded` first would pay for rays that meet nothing
        // only; those that it stops would have to be traced again.
        let mut share = Vec3::ONE;
        for _ in 0..MAX_LAYERS {
            let Some(hit) = tracer.intersect(&ray) else { return share };
            let surface = self.scene.surface(&hit);
            if !surface.is_see_through() || self.is_cancelled() {
                return Vec3::ZERO;
            }
            let layer = self.scene.interaction(&ray, &hit, it.cone, it.point.depth + 1);
            share *= surface.transmittance(&layer, &self.scene.textures);
            if share == Vec3::ZERO {
                return share;
            }
            ray.tmin = hit.t.next_up();
        }
        Vec3::ZERO
    }

    /// Remembers the first visible point of a camera ray.
    pub(crate) fn see(&mut self, it: &Interaction) {
        if it.point.depth == 0 && self.seen.is_none() {
            self.seen = Some(Seen {
                distance: it.point.distance,
                normal: it.point.normal,
                object: it.point.object,
                instance: it.point.instance,
            });
        }
    }
}
