//! The camera samples of a packet, carried to their colours together.
//!
//! Rays of neighbouring pixels visit the same nodes and meet the same surfaces, so they are traced as a packet (Wald, Slusallek, Benthin, Wagner,
//! *Interactive Rendering with Coherent Ray Tracing*, 2001) and, where nothing but Phong's model is asked for, shaded eight at a time: hit points
//! ([`super::points`]), then for each point of each light the reflected light and the shadow rays, which are a packet again
//! ([`super::lighting`]). Textures are looked up one by one, and mirror rays sent. Everything else (other surfaces, a user's shaders, cut-out and
//! see-through ones, other renderers than `whitted` and `raycast`) goes on ray by ray.
//!
//! The picture is the same as if each sample went alone: a sample has random numbers of its own, and what the lights add to it is
//! added in their order. Shadow rays are batched where they can only answer yes or no (no surface of the frame is
//! see-through).
//!
//! What it gave, one thread of an AVX2 machine, 640x480 with one lamp, as rays per second of whole frames over those of the same
//! rays in batches (`cargo bench --bench peers -- frames`): eight at a time instead of one by one, robots by `raycast` 0.29 → 0.57; corners of all rows fetched
//! before the first point is computed 0.70; no stores of single lanes 0.80. Batches became 1.3 times as fast since, and frames, a third of which was not tracing,
//! fell to 0.60 (18.1 ms; `whitted` 0.72; a cloth 0.66 and 0.75). They are at 0.71 and 0.78, the cloth at 0.75 and 0.82, since:
//!
//! * Pixels are kept number by number (`frame::block`), in the order of samples: a packet is copied by rows. 10 % of a frame were 4.
//! * Hits are turned to rows at once, so distances and names are pixels as they are, also those of rays that hit nothing ([`Points::take`]).
//! * Instances of one surface are known before the frame ([`ShadeScene::look`]): sorting hits by surface takes 7 % no more, but 4.
//! * Corners come as vectors of four coordinates, eight are transposed. Points are laid row by row, and then normals made unit vectors row by row: one row
//!   after the other, each waited for its own division, root and division; with surfaces known before, that made a frame 4 to 5 % faster.
//!
//! Tried without gain: to ask for vertices as soon as their numbers are known (prefetches cost what they save).
//! What is left beside tracing of a frame of robots by `raycast`: fetching corners 8 %, points 6, pixels 4, camera rays 3.5, light 3.5, surfaces and sums 4.

use crate::scene::Mask;
use crate::shade::camera_packet::CameraPacket;
use crate::shade::footprint::Cone;
use crate::shade::integrator::Integrator;
use crate::shade::light_packet::LightPoint;
use crate::shade::lighting::{Lighting, Shadows};
use crate::shade::materials::Materials;
use crate::shade::points::Points;
use crate::shade::rows::{GROUPS, Rows, Rows3, SLOTS, ZEROS, set_vec3, vec3};
use crate::shade::sampler::Rng;
use crate::shade::worker::{BUDGET, Bounce, Sample, Seen, Worker};
use crate::simd::{LANES, bits};
use crate::trace::{Hit, PacketMemory, Ray};
use glam::{Vec2, Vec3, Vec4, Vec4Swizzles};

/// What the samples of a packet have become; of those that had no ray it means nothing.
pub struct Samples {
    color: [Rows; 4],
    /// Those that have seen nothing have no instance.
    points: Points,
}

/// Each number of all samples by itself. Those that have seen nothing have distance ∞, normal 0, object 0 and instance [`Hit::NO_INSTANCE`].
pub struct Planes<'a> {
    pub color: [&'a [f32; SLOTS]; 4],
    pub distance: &'a [f32; SLOTS],
    pub normal: [&'a [f32; SLOTS]; 3],
    pub object: &'a [u32; SLOTS],
    pub instance: &'a [u32; SLOTS],
}

impl Samples {
    pub fn new() -> Self {
        Self { color: [ZEROS; 4], points: Points::new() }
    }

    /// See [`Sample::color`].
    #[inline]
    pub fn color(&self, slot: usize) -> Vec4 {
        let (g, l) = (slot / LANES, slot % LANES);
        Vec4::new(self.color[0][g][l], self.color[1][g][l], self.color[2][g][l], self.color[3][g][l])
    }

    /// See [`Sample::seen`].
    #[inline]
    pub fn seen(&self, slot: usize) -> Option<Seen> {
        let points = &self.points;
        let (g, l) = (slot / LANES, slot % LANES);
        (points.instance[g][l] != Hit::NO_INSTANCE).then(|| Seen {
            distance: points.distance[g][l],
            normal: vec3(&points.normal, slot),
            object: points.object[g][l],
            instance: points.instance[g][l],
        })
    }

    /// Everything at once.
    #[inline]
    pub fn planes(&self) -> Planes<'_> {
        let Self { color: [r, g, b, a], points } = self;
        let [x, y, z] = &points.normal;
        Planes {
            color: [plane(r), plane(g), plane(b), plane(a)],
            distance: plane(&points.distance),
            normal: [plane(x), plane(y), plane(z)],
            object: plane(&points.object),
            instance: plane(&points.instance),
        }
    }

    /// A sample that saw nothing but `color`.
    pub fn set_clear(&mut self, slot: usize, color: Vec4) {
        self.set(slot, Sample { color, seen: None });
    }

    /// Forgets what is held of instances: they move from frame to frame.
    pub fn forget(&mut self) {
        self.points.forget();
    }

    fn set_color(&mut self, slot: usize, color: Vec4) {
        for k in 0..4 {
            // Colours are sums of layers: a zero has no sign.
            self.color[k][slot / LANES][slot % LANES] = 0.0 + color[k];
        }
    }

    fn set(&mut self, slot: usize, sample: Sample) {
        self.set_color(slot, sample.color);
        const NOTHING: Seen =
            Seen { distance: f32::INFINITY, normal: Vec3::ZERO, object: 0, instance: Hit::NO_INSTANCE };
        let seen = sample.seen.unwrap_or(NOTHING);
        let (g, l) = (slot / LANES, slot % LANES);
        self.points.distance[g][l] = seen.distance;
        set_vec3(&mut self.points.normal, slot, seen.normal);
        self.points.object[g][l] = seen.object;
        self.points.instance[g][l] = seen.instance;
    }
}

/// Rows as one.
#[inline(always)]
fn plane<T>(rows: &[[T; LANES]; GROUPS]) -> &[T; SLOTS] {
    rows.as_flattened().first_chunk().expect("rows of eight")
}

impl Default for Samples {
    fn default() -> Self {
        Self::new()
    }
}

/// Memory of a packet.
pub(super) struct Batch {
    materials: Materials,
    shadows: Shadows,
    /// In which shadow rays are traced.
    memory: PacketMemory,
    /// What the lights send to each sample.
    sum: Rows3,
    rngs: [Rng; SLOTS],
    shifts: [Vec2; SLOTS],
}

impl Default for Batch {
    fn default() -> Self {
        Self {
            materials: Materials::new(),
            shadows: Shadows::new(),
            memory: PacketMemory::new(),
            sum: [ZEROS; 3],
            rngs: [Rng::new(0, 0, 0); SLOTS],
            shifts: [Vec2::ZERO; SLOTS],
        }
    }
}

impl Batch {
    /// Forgets what it holds of surfaces: they are numbered anew in each frame.
    pub fn forget(&mut self) {
        self.materials.forget();
    }
}

/// How the samples of a packet can be shaded together.
#[derive(Clone, Copy)]
pub(super) struct Together {
    shadows: bool,
    /// What rays see that leave the scene, if it is the same for all.
    sky: Option<Vec4>,
}

impl<'a> Worker<'a> {
    /// Carries camera samples to their colours.
    pub fn samples(&mut self, camera: &CameraPacket, cone: Cone, samples: &mut Samples) {
        let together = self.together;
        self.samples_by(camera, cone, samples, together);
    }

    /// As [`Worker::samples`], one by one.
    #[cfg(test)]
    pub(crate) fn samples_alone(&mut self, camera: &CameraPacket, cone: Cone, samples: &mut Samples) {
        self.samples_by(camera, cone, samples, None);
    }

    /// As [`Worker::samples`], one by one without `together`.
    fn samples_by(&mut self, camera: &CameraPacket, cone: Cone, samples: &mut Samples, together: Option<Together>) {
        if camera.mask == 0 {
            return;
        }
        self.counts.primary += u64::from(camera.mask.count_ones());
        let mut memory = self.memory.packet.take().unwrap_or_default();
        let hits = self.tracer.masked(Mask::CAMERA).intersect_packet(&camera.rays, camera.mask, &mut memory);
        let first = Bounce { depth: 0, weight: 1.0, cone };
        let rest = match together {
            Some(together) => camera.mask & !self.shade_together(together, camera, hits, first, samples),
            None => camera.mask,
        };
        for slot in bits(rest) {
            let hit = Some(hits[slot]).filter(|hit| !hit.is_none());
            // A ray that leaves the scene makes no random choice.
            self.begin(if hit.is_some() { camera.rng(slot) } else { self.rng });
            let color = self.radiance(camera.rays.ray(slot), hit, first);
            samples.set(slot, self.end(color));
        }
        self.memory.packet = Some(memory);
    }

    /// Shades what can be shaded together, and returns which samples that are.
    fn shade_together(
        &mut self,
        together: Together,
        camera: &CameraPacket,
        hits: &[Hit; SLOTS],
        first: Bounce,
        samples: &mut Samples,
    ) -> u64 {
        let (scene, level) = (self.scene, self.tracer.world().level());
        let mut batch = self.memory.batch.take().unwrap_or_default();
        let Batch { materials, sum, .. } = &mut *batch;
        let hit = samples.points.take(level, hits, camera.mask);
        materials.sort(scene, &samples.points, hit);
        let lit = materials.lit;
        if lit != 0 {
            samples.points.find(level, scene, &camera.rays, lit, together.shadows);
            for slot in bits(materials.textured) {
                let it = samples.points.interaction(scene, &camera.rays, hits, slot, first.cone);
                let base = materials.phong(scene, slot).base(&it, &scene.textures);
                materials.set_base(slot, base.xyz());
            }
            *sum = [ZEROS; 3];
            self.light(together, camera, &mut batch, samples);
        }
        let Batch { materials, sum, rngs, .. } = &*batch;
        let lighting = Lighting { scene, level, rays: &camera.rays, points: &samples.points, materials };
        let sky = together.sky.unwrap_or(Vec4::ZERO);
        lighting.finish(sum, sky, camera.mask, &mut samples.color);
        for slot in bits(materials.bouncing) {
            let it = samples.points.interaction(scene, &camera.rays, hits, slot, first.cone);
            self.begin(rngs[slot]);
            let layer =
                self.phong_lit(materials.phong(scene, slot), materials.base(slot), 1.0, vec3(sum, slot), &it, first);
            samples.set_color(slot, self.end((Vec3::ZERO + layer.xyz()).extend(1.0)).color);
        }
        self.memory.batch = Some(batch);
        if together.sky.is_some() { lit | camera.mask & !hit } else { lit }
    }

    /// Adds to the sums of all lit samples what the lights send them, light by light and point by point of the light.
    fn light(&mut self, together: Together, camera: &CameraPacket, batch: &mut Batch, samples: &Samples) {
        let (scene, level) = (self.scene, self.tracer.world().level());
        let Batch { memory, materials, shadows, sum, rngs, shifts, .. } = batch;
        let lighting = Lighting { scene, level, rays: &camera.rays, points: &samples.points, materials };
        let chance =
            if scene.lights.iter().any(|light| light.samples > 1) { materials.lit } else { materials.bouncing };
        bits(chance).for_each(|slot| rngs[slot] = camera.rng(slot));
        if scene.headlight {
            lighting.headlight(sum);
            return;
        }
        for light in &scene.lights {
            if light.samples > 1 {
                bits(materials.lit).for_each(|slot| shifts[slot] = light.shift(&mut rngs[slot]));
            }
            let n = light.points(0);
            for i in 0..n {
                if self.is_cancelled() {
                    return;
                }
                let which = LightPoint { i, n };
                if together.shadows {
                    let asking = lighting.ask(light, which, shifts, shadows);
                    self.counts.shadow += u64::from(asking.count_ones());
                    let occluded = self.tracer.masked(Mask::SHADOW).occluded_packet(&shadows.rays, asking, memory);
                    lighting.add_arriving(shadows, asking & !occluded, sum);
                } else {
                    lighting.add(light, which, shifts, sum);
                }
            }
        }
    }

    /// How many samples of the last packet were lit together.
    #[cfg(test)]
    pub(crate) fn lit_together(&self) -> u32 {
        self.memory.batch.as_ref().map_or(0, |batch| batch.materials.lit.count_ones())
    }

    #[inline]
    fn begin(&mut self, rng: Rng) {
        self.rng = rng;
        self.seen = None;
        self.budget = BUDGET;
    }

    #[inline]
    fn end(&self, color: Vec4) -> Sample {
        // A shader may have divided by zero; one such sample must not spoil an average.
        let color = if color.is_finite() { color } else { Vec4::ZERO };
        Sample { color, seen: self.seen }
    }

    /// Whether samples can be shaded together: not if shadow rays of the frame may meet something that lets them pass in part.
    pub(super) fn find_together(&mut self) -> Option<Together> {
        let scene = self.scene;
        let Integrator::Whitted { shadows, .. } = self.integrator else { return None };
        let shadows = shadows && !scene.headlight;
        if shadows && scene.see_through {
            return None;
        }
        let sky = scene.environment.is_uniform().then(|| {
            let anywhere = Ray::new(Vec3::ZERO, Vec3::Z);
            let color =
                self.radiance(anywhere, None, Bounce { depth: 0, weight: 1.0, cone: Cone { width: 0.0, spread: 0.0 } });
            self.end(color).color
        });
        Some(Together { shadows, sky })
    }
}
