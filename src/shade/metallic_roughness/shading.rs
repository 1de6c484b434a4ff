//! What a point of a metallic-roughness surface sends to the viewer.
//!
//! Smooth surfaces reflect the scene by one ray of the lobe, as the class `metal` does. The rougher a surface, the more such rays
//! differ from pixel to pixel, so from roughness 0.4 to 0.6 what they see is blended with the environment averaged over the
//! lobe, which has no grain and no shadows; so have the last bounces, which send no ray. `path` follows rays at any roughness.

use super::{MetallicRoughness, Mixture, ggx};
use crate::shade::direct::Effort;
use crate::shade::interaction::Interaction;
use crate::shade::optics::{above, reflect};
use crate::shade::path::{DIFFUSE_SPREAD, Step};
use crate::shade::sampler::{cosine_hemisphere, hammersley};
use crate::shade::whitted::refracted;
use crate::shade::worker::{Bounce, Worker};
use glam::{Vec2, Vec3, Vec4};

/// Directions of the lobe over which the environment is averaged.
const LOOKS: u32 = 8;
/// How much wider highlights of the lamp at the eye are: it stands for no light of the scene, and must not dazzle.
const HEADLIGHT: f32 = 0.7;
/// Smoother surfaces are perfect mirrors.
const MIRROR: f32 = 1e-4;

impl Mixture {
    fn alpha(&self) -> f32 {
        self.roughness * self.roughness
    }

    /// Angle by which the lobe scatters.
    fn spread(&self) -> f32 {
        1.5 * self.alpha()
    }

    /// Light of `radiance` from `direction`, reflected to the viewer; `alpha` is that of the highlight.
    #[inline]
    fn reflected(&self, it: &Interaction, alpha: f32, direction: Vec3, radiance: Vec3) -> Vec3 {
        let (normal, view) = (it.point.normal, -it.point.incoming);
        let half = (view + direction).normalize_or(normal);
        let scattered = self.diffuse * (Vec3::ONE - ggx::fresnel(self.f0, view.dot(half)));
        let highlight = ggx::reflected(normal, view, direction, alpha, self.f0);
        (scattered * direction.dot(normal).max(0.0) + highlight) * radiance
    }

    /// Share of the surroundings that is reflected.
    fn reflectance(&self, it: &Interaction) -> Vec3 {
        ggx::reflectance(self.f0, self.roughness, -it.point.incoming.dot(it.point.normal))
    }
}

impl<'a> Worker<'a> {
    pub(crate) fn metallic_roughness(&mut self, m: &MetallicRoughness, it: &Interaction, bounce: Bounce) -> Vec4 {
        let scene = self.scene;
        let alpha = m.coverage(it, &scene.textures);
        if alpha == 0.0 {
            return Vec4::ZERO;
        }
        let it = &m.bumped(it, &scene.textures);
        let mixture = m.mixture(it, &scene.textures);
        let bounce = Bounce { weight: bounce.weight * alpha, ..bounce };
        let mut color = m.emitted(it, &scene.textures) + mixture.ambient;
        let alpha_lit = if scene.headlight { (mixture.alpha() + HEADLIGHT).min(1.0) } else { mixture.alpha() };
        self.each_light(it, Effort::Full, |direction, radiance| {
            color += mixture.reflected(it, alpha_lit, direction, radiance);
        });
        let mut reflectance = mixture.reflectance(it);
        if mixture.transmission != Vec3::ZERO {
            let tint = mixture.transmission * (Vec3::ONE - reflectance);
            match passing(it, m.ior) {
                Some(direction) => color += tint * self.bounce(it, direction, tint.max_element(), 0.0, bounce),
                None => reflectance += tint,
            }
        }
        let traced = if bounce.depth >= self.integrator.max_depth() {
            0.0
        } else {
            ((0.6 - mixture.roughness) / 0.2).clamp(0.0, 1.0)
        };
        if traced > 0.0 {
            let share = reflectance * traced;
            let direction = self.lobe_direction(&mixture, it);
            color += share * self.bounce(it, direction, share.max_element(), mixture.spread(), bounce);
        }
        if traced < 1.0 {
            color += reflectance * ((1.0 - traced) * mixture.open) * self.surroundings(&mixture, it);
        }
        color.extend(alpha)
    }

    /// A direction of the lobe, above the surface.
    fn lobe_direction(&mut self, mixture: &Mixture, it: &Interaction) -> Vec3 {
        let point = &it.point;
        let direction = if mixture.alpha() < MIRROR {
            reflect(point.incoming, point.normal)
        } else {
            ggx::sample(point.incoming, point.normal, mixture.alpha(), self.rng.next_vec2())
        };
        above(direction, point.geometric_normal)
    }

    /// The environment, averaged over the lobe.
    fn surroundings(&self, mixture: &Mixture, it: &Interaction) -> Vec3 {
        let (point, environment) = (&it.point, &self.scene.environment);
        if mixture.alpha() < MIRROR || environment.is_uniform() {
            let direction = above(reflect(point.incoming, point.normal), point.geometric_normal);
            return environment.radiance(direction, it.cone).truncate();
        }
        let cone = it.cone.widened(mixture.spread() / (LOOKS as f32).sqrt());
        let mut sum = Vec3::ZERO;
        for i in 0..LOOKS {
            let u = hammersley(i, LOOKS, Vec2::ZERO);
            let direction = ggx::sample(point.incoming, point.normal, mixture.alpha(), u);
            sum += environment.radiance(above(direction, point.geometric_normal), cone).truncate();
        }
        sum / LOOKS as f32
    }

    /// Light of the lights, reflected, for paths.
    pub(crate) fn metallic_roughness_lit(&mut self, m: &MetallicRoughness, it: &Interaction) -> Vec3 {
        let it = &m.bumped(it, &self.scene.textures);
        let mixture = m.mixture(it, &self.scene.textures);
        let mut sum = Vec3::ZERO;
        let alpha = mixture.alpha();
        self.each_light(it, Effort::Single, |direction, radiance| {
            sum += mixture.reflected(it, alpha, direction, radiance);
        });
        sum
    }

    /// How a path goes on: by one of reflection, scattering and transmission, chosen in proportion to their colours.
    pub(crate) fn metallic_roughness_step(&mut self, m: &MetallicRoughness, it: &Interaction) -> Option<Step> {
        let it = &m.bumped(it, &self.scene.textures);
        let mixture = m.mixture(it, &self.scene.textures);
        let reflectance = mixture.reflectance(it);
        let rest = Vec3::ONE - reflectance;
        let (mut reflected, diffuse, mut passed) = (reflectance, mixture.diffuse * rest, mixture.transmission * rest);
        let through = if passed == Vec3::ZERO { None } else { passing(it, m.ior) };
        if through.is_none() {
            reflected += std::mem::take(&mut passed);
        }
        let parts = [diffuse, reflected, passed].map(|color| color.max_element().max(0.0));
        let total = parts[0] + parts[1] + parts[2];
        if !(total > 0.0 && total.is_finite()) {
            return None;
        }
        let choice = self.rng.next_f32() * total;
        let geometric_normal = it.point.geometric_normal;
        if choice < parts[0] {
            let direction = above(cosine_hemisphere(it.point.normal, self.rng.next_vec2()), geometric_normal);
            return Some(Step { direction, factor: diffuse * (total / parts[0]), spread: DIFFUSE_SPREAD });
        }
        match through {
            Some(direction) if choice >= parts[0] + parts[1] => {
                Some(Step { direction, factor: passed * (total / parts[2]), spread: 0.0 })
            }
            _ => {
                // Rounding may land here with an empty part: then the path just ends.
                let factor = if parts[1] > 0.0 { reflected * (total / parts[1]) } else { Vec3::ZERO };
                Some(Step { direction: self.lobe_direction(&mixture, it), factor, spread: mixture.spread() })
            }
        }
    }
}

/// Where light goes on behind the surface: an index of 1 stands for a thin sheet. None on total reflection.
fn passing(it: &Interaction, ior: f32) -> Option<Vec3> {
    if ior == 1.0 { Some(it.point.incoming) } else { refracted(&it.point, ior) }
}
