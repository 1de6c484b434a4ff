//! `path`: global illumination, one path per camera sample (Kajiya, *The Rendering Equation*, 1986), as a loop.
//!
//! * Lights are sampled at every diffuse point (next event estimation). They are no geometry, so a path never meets
//!   one and nothing is counted twice. The environment and glowing surfaces are only found by paths.
//! * A surface of several parts (diffuse, mirror, refraction) follows one of them, chosen with a probability in
//!   proportion to its colour.
//! * From `roulette_depth` on a path survives with the probability of its weight, which keeps the mean.
//! * Phong's highlights are, as in Whitted's model, images of the lights only. `ambient` lights, which stand in for
//!   what is computed here, are ignored.
//! * Alpha is taken as the probability that a layer is there.

use crate::shade::direct::Effort;
use crate::shade::interaction::Interaction;
use crate::shade::optics::{above, fresnel_dielectric, reflect, refract};
use crate::shade::sampler::cosine_hemisphere;
use crate::shade::surface::{Phong, Surface};
use crate::shade::whitted::refracted;
use crate::shade::worker::{Bounce, MAX_LAYERS, Worker};
use crate::trace::{Hit, Ray};
use glam::{Vec3, Vec4, Vec4Swizzles};
use std::f32::consts::PI;

/// Where a path goes on, and the factor that its weight gets: BSDF × cosine / density.
pub(crate) struct Step {
    pub direction: Vec3,
    pub factor: Vec3,
    /// Angle by which the bounce scatters, for texture filtering.
    pub spread: f32,
}

/// Footprint of a diffuse bounce: wide enough to leave the finest mip levels, narrow enough not to bleed across a room.
pub(crate) const DIFFUSE_SPREAD: f32 = 0.1 * PI;

impl<'a> Worker<'a> {
    pub(crate) fn path(
        &mut self,
        mut ray: Ray,
        first: Option<Hit>,
        start: Bounce,
        max_depth: u32,
        roulette_depth: u32,
    ) -> Vec4 {
        let scene = self.scene;
        let mut sum = Vec3::ZERO;
        let mut weight = Vec3::ONE;
        let mut next = first;
        let mut bounce = start;
        let mut layers = 0;
        let mut solid = false;
        loop {
            if self.is_cancelled() {
                return sum.extend(1.0);
            }
            let Some(hit) = next else {
                let sky = scene.environment.radiance(ray.direction, bounce.cone);
                sum += weight * sky.xyz();
                return sum.extend(if solid { 1.0 } else { sky.w });
            };
            let it = scene.interaction(&ray, &hit, bounce.cone, bounce.depth);
            let surface = scene.surface(&hit);
            let (light, alpha) = match surface {
                Surface::User(user) => {
                    let color = self.user(user, &it, bounce);
                    (color.xyz(), color.w)
                }
                _ => (Vec3::ZERO, surface.coverage(&it, &scene.textures)),
            };
            // `next_f32` is below 1, so an opaque surface is always there.
            if alpha < 1.0 && self.rng.next_f32() >= alpha {
                layers += 1;
                if layers == MAX_LAYERS {
                    return sum.extend(if solid { 1.0 } else { 0.0 });
                }
                ray.tmin = hit.t.next_up();
                next = self.closest(&ray, bounce.depth);
                continue;
            }
            self.see(&it);
            solid = true;
            sum += weight * (light + self.emitted(surface, &it));
            sum += weight * self.next_event(surface, &it);
            if bounce.depth >= max_depth {
                return sum.extend(1.0);
            }
            let Some(step) = self.step(surface, &it) else { return sum.extend(1.0) };
            weight *= step.factor;
            if bounce.depth >= roulette_depth {
                let survival = weight.max_element().min(1.0);
                if !(self.rng.next_f32() < survival) {
                    return sum.extend(1.0);
                }
                weight /= survival;
            }
            if !(weight.max_element() > 0.0) {
                return sum.extend(1.0);
            }
            ray = it.spawn(step.direction);
            self.counts.secondary += 1;
            next = self.closest(&ray, bounce.depth + 1);
            bounce = Bounce { depth: bounce.depth + 1, weight: 1.0, cone: it.cone.widened(step.spread) };
        }
    }

    /// Light that the surface itself sends.
    fn emitted(&self, surface: &Surface, it: &Interaction) -> Vec3 {
        match surface {
            Surface::Phong(phong) => phong.emission,
            Surface::MetallicRoughness(m) => m.emitted(it, &self.scene.textures),
            _ => self.glow(surface, it),
        }
    }

    /// Light of the lights, reflected.
    fn next_event(&mut self, surface: &Surface, it: &Interaction) -> Vec3 {
        match surface {
            Surface::Phong(phong) if phong.diffuse != Vec3::ZERO || phong.specular != Vec3::ZERO => {
                let base = phong.base(it, &self.scene.textures).xyz();
                self.lit(phong, base, it, Effort::Single)
            }
            Surface::Metal { color, exponent: Some(k), texture } => {
                let tint = *color * self.base(*texture, it);
                tint * self.metal_highlight(*k, it, Effort::Single)
            }
            Surface::MetallicRoughness(m) => self.metallic_roughness_lit(m, it),
            _ => Vec3::ZERO,
        }
    }

    /// Chooses how the path goes on; None where it ends.
    fn step(&mut self, surface: &Surface, it: &Interaction) -> Option<Step> {
        let point = &it.point;
        let mirrored = || above(reflect(point.incoming, point.normal), point.geometric_normal);
        match surface {
            Surface::Phong(phong) => self.phong_step(phong, it),
            Surface::MetallicRoughness(m) => self.metallic_roughness_step(m, it),
            Surface::Mirror { color, texture } => {
                let factor = *color * self.base(*texture, it);
                Some(Step { direction: mirrored(), factor, spread: 0.0 })
            }
            Surface::Metal { color, exponent, texture } => {
                let factor = *color * self.base(*texture, it);
                let (direction, spread) = self.metal_direction(*exponent, it);
                Some(Step { direction, factor, spread })
            }
            Surface::Glass { color, ior } => {
                let eta = if point.back_facing { *ior } else { 1.0 / *ior };
                let reflected = fresnel_dielectric(-point.incoming.dot(point.normal), eta);
                let inside = refract(point.incoming, point.normal, eta);
                match inside {
                    Some(direction) if self.rng.next_f32() >= reflected => {
                        let direction = -above(-direction, point.geometric_normal);
                        Some(Step { direction, factor: *color, spread: 0.0 })
                    }
                    _ => Some(Step { direction: mirrored(), factor: Vec3::ONE, spread: 0.0 }),
                }
            }
            _ => None,
        }
    }

    fn phong_step(&mut self, phong: &Phong, it: &Interaction) -> Option<Step> {
        let point = &it.point;
        let diffuse = phong.diffuse * phong.base(it, &self.scene.textures).xyz();
        let refraction = if phong.transmission == Vec3::ZERO { None } else { refracted(point, phong.ior) };
        let (transmission, reflection) = match refraction {
            Some(_) => (phong.transmission, phong.reflection),
            None => (Vec3::ZERO, phong.reflection + phong.transmission),
        };
        let parts = [diffuse, reflection, transmission].map(|color| color.max_element().max(0.0));
        let total = parts[0] + parts[1] + parts[2];
        if !(total > 0.0 && total.is_finite()) {
            return None;
        }
        let choice = self.rng.next_f32() * total;
        if choice < parts[0] {
            let direction = cosine_hemisphere(point.normal, self.rng.next_vec2());
            let height = direction.dot(point.geometric_normal);
            let direction = if height < 0.0 { reflect(direction, point.geometric_normal) } else { direction };
            return Some(Step { direction, factor: diffuse * (total / parts[0]), spread: DIFFUSE_SPREAD });
        }
        match refraction {
            Some(direction) if choice >= parts[0] + parts[1] => {
                Some(Step { direction, factor: transmission * (total / parts[2]), spread: 0.0 })
            }
            _ => {
                let direction = above(reflect(point.incoming, point.normal), point.geometric_normal);
                // Rounding may land here with an empty part: then the path just ends.
                let factor = if parts[1] > 0.0 { reflection * (total / parts[1]) } else { Vec3::ZERO };
                Some(Step { direction, factor, spread: 0.0 })
            }
        }
    }
}
