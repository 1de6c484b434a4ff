//! `whitted` and `raycast`: lights, shadows, mirror and refracted rays (Whitted, *An Improved Illumination Model for
//! Shaded Display*, 1980).
//!
//! Layers of partial opacity are a loop along one ray; mirrors and refraction are recursive and bounded by the
//! frame's depth, by the ray's share in the pixel and by a budget per camera sample.

use crate::scene::SurfacePoint;
use crate::shade::context::Context;
use crate::shade::direct::Effort;
use crate::shade::integrator::Integrator;
use crate::shade::interaction::Interaction;
use crate::shade::optics::{above, fresnel_dielectric, reflect, refract};
use crate::shade::sampler::cosine_power;
use crate::shade::surface::{Phong, Surface, UserSurface};
use crate::shade::worker::{Bounce, MAX_LAYERS, Worker};
use crate::trace::{Hit, Ray};
use glam::{Vec3, Vec4, Vec4Swizzles};

/// What is left of a ray behind opaque enough layers is not followed.
const MIN_REST: f32 = 1.0 / 512.0;

impl<'a> Worker<'a> {
    pub(crate) fn whitted(&mut self, mut ray: Ray, first: Option<Hit>, bounce: Bounce) -> Vec4 {
        let scene = self.scene;
        let mut sum = Vec3::ZERO;
        let mut rest = 1.0;
        let mut next = first;
        for _ in 0..MAX_LAYERS {
            let Some(hit) = next else {
                let sky = scene.environment.radiance(ray.direction, bounce.cone);
                return (sum + sky.xyz() * rest).extend(1.0 - rest * (1.0 - sky.w));
            };
            let it = scene.interaction(&ray, &hit, bounce.cone, bounce.depth);
            let share = Bounce { weight: bounce.weight * rest, ..bounce };
            let layer = self.surface(scene.surface(&hit), &it, share);
            let alpha = layer.w.clamp(0.0, 1.0);
            if alpha > 0.0 {
                self.see(&it);
                sum += layer.xyz() * (rest * alpha);
                rest *= 1.0 - alpha;
            }
            if rest < MIN_REST {
                return sum.extend(1.0);
            }
            ray.tmin = hit.t.next_up();
            next = self.closest(&ray, bounce.depth);
        }
        sum.extend(1.0 - rest)
    }

    /// Colour and opacity of a surface at a point.
    pub(crate) fn surface(&mut self, surface: &Surface, it: &Interaction, bounce: Bounce) -> Vec4 {
        let point = &it.point;
        let color = match surface {
            Surface::Phong(phong) => return self.phong(phong, it, bounce),
            Surface::User(user) => return self.user(user, it, bounce),
            Surface::MetallicRoughness(m) => return self.metallic_roughness(m, it, bounce),
            Surface::Constant { .. } => {
                return self.glow(surface, it).extend(surface.coverage(it, &self.scene.textures));
            }
            Surface::Mirror { color, texture } => {
                let tint = *color * self.base(*texture, it);
                let direction = above(reflect(point.incoming, point.normal), point.geometric_normal);
                tint * self.bounce(it, direction, tint.max_element(), 0.0, bounce)
            }
            Surface::Glass { color, ior } => self.glass(*color, *ior, it, bounce),
            Surface::Metal { color, exponent, texture } => {
                let tint = *color * self.base(*texture, it);
                self.metal(tint, *exponent, it, bounce)
            }
            _ => self.glow(surface, it),
        };
        color.extend(1.0)
    }

    /// Texture × vertex colour.
    pub(crate) fn base(&self, texture: Option<u32>, it: &Interaction) -> Vec3 {
        let texel = self.scene.textures.lookup(texture, it.point.tex_coord, || it.footprint());
        (it.point.color * texel).xyz()
    }

    /// Colour of the surfaces that ask for no other ray; black for all others.
    pub(crate) fn glow(&self, surface: &Surface, it: &Interaction) -> Vec3 {
        let point = &it.point;
        match surface {
            Surface::Constant { color, texture, .. } => *color * self.base(*texture, it),
            Surface::EyeLight { color, texture } => {
                *color * self.base(*texture, it) * -point.normal.dot(point.incoming)
            }
            Surface::Normals => point.normal * 0.5 + Vec3::splat(0.5),
            Surface::Wireframe { color, background, thickness } => {
                let near = it.edge_distance().min_element() < 0.5 * thickness * it.cone.width;
                if near { *color } else { *background }
            }
            _ => Vec3::ZERO,
        }
    }

    #[inline]
    fn phong(&mut self, phong: &Phong, it: &Interaction, bounce: Bounce) -> Vec4 {
        let base = phong.base(it, &self.scene.textures);
        let (base, alpha) = (base.xyz(), base.w);
        if alpha == 0.0 {
            return Vec4::ZERO;
        }
        let lit = self.lit(phong, base, it, Effort::Full);
        self.phong_lit(phong, base, alpha, lit, it, bounce)
    }

    /// The colour of [`Surface::Phong`], when what the lights contribute is known.
    pub(super) fn phong_lit(
        &mut self,
        phong: &Phong,
        base: Vec3,
        alpha: f32,
        lit: Vec3,
        it: &Interaction,
        bounce: Bounce,
    ) -> Vec4 {
        let point = &it.point;
        let bounce = Bounce { weight: bounce.weight * alpha, ..bounce };
        let mut color = phong.emission + phong.ambient * base;
        color += lit;
        let mut reflection = phong.reflection;
        if phong.transmission != Vec3::ZERO {
            match refracted(point, phong.ior) {
                Some(direction) => {
                    let share = phong.transmission.max_element();
                    color += phong.transmission * self.bounce(it, direction, share, 0.0, bounce);
                }
                None => reflection += phong.transmission,
            }
        }
        if reflection != Vec3::ZERO {
            let direction = above(reflect(point.incoming, point.normal), point.geometric_normal);
            color += reflection * self.bounce(it, direction, reflection.max_element(), 0.0, bounce);
        }
        color.extend(alpha)
    }

    /// Diffuse light and highlights of the lights, or of the lamp at the eye in a frame without lights.
    #[inline]
    pub(crate) fn lit(&mut self, phong: &Phong, base: Vec3, it: &Interaction, effort: Effort) -> Vec3 {
        let mut sum = Vec3::ZERO;
        self.each_light(it, effort, |direction, radiance| {
            sum += phong.reflected(base, &it.point, direction, radiance);
        });
        sum
    }

    /// Calls `each(direction, radiance)` for all light that arrives from the lights, or from the lamp at the eye in a
    /// frame without lights; see [`Worker::direct`].
    #[inline]
    pub(crate) fn each_light(&mut self, it: &Interaction, effort: Effort, mut each: impl FnMut(Vec3, Vec3)) {
        let shadows = match self.integrator {
            Integrator::Whitted { .. } if self.scene.headlight => return each(-it.point.incoming, Vec3::ONE),
            Integrator::Whitted { shadows, .. } => shadows,
            _ => true,
        };
        self.direct(it, shadows, effort, each);
    }

    fn glass(&mut self, color: Vec3, ior: f32, it: &Interaction, bounce: Bounce) -> Vec3 {
        let point = &it.point;
        let eta = if point.back_facing { ior } else { 1.0 / ior };
        let reflected = fresnel_dielectric(-point.incoming.dot(point.normal), eta);
        let mut sum = Vec3::ZERO;
        if let Some(direction) = refract(point.incoming, point.normal, eta) {
            let direction = -above(-direction, point.geometric_normal);
            let tint = color * (1.0 - reflected);
            sum += tint * self.bounce(it, direction, tint.max_element(), 0.0, bounce);
        }
        let direction = above(reflect(point.incoming, point.normal), point.geometric_normal);
        sum + reflected * self.bounce(it, direction, reflected, 0.0, bounce)
    }

    /// One ray into the lobe around the mirror direction, and the lights' highlights by the same lobe.
    fn metal(&mut self, tint: Vec3, exponent: Option<f32>, it: &Interaction, bounce: Bounce) -> Vec3 {
        let (direction, spread) = self.metal_direction(exponent, it);
        let mut sum = tint * self.bounce(it, direction, tint.max_element(), spread, bounce);
        if let Some(k) = exponent {
            sum += tint * self.metal_highlight(k, it, Effort::Full);
        }
        sum
    }

    /// A direction of the lobe, and the angle by which it scatters.
    pub(crate) fn metal_direction(&mut self, exponent: Option<f32>, it: &Interaction) -> (Vec3, f32) {
        let point = &it.point;
        let mirrored = above(reflect(point.incoming, point.normal), point.geometric_normal);
        match exponent {
            None => (mirrored, 0.0),
            Some(k) => {
                let direction = cosine_power(mirrored, k, self.rng.next_vec2());
                let height = direction.dot(point.geometric_normal);
                // Mirrored back above the surface, so that no energy is lost.
                let direction = if height < 0.0 { reflect(direction, point.geometric_normal) } else { direction };
                (direction, (2.0 / (k + 2.0)).sqrt())
            }
        }
    }

    /// The lights in a lobe of density (k+1)/2π · cosᵏ; lights are in units of irradiance/π, hence no π.
    pub(crate) fn metal_highlight(&mut self, k: f32, it: &Interaction, effort: Effort) -> Vec3 {
        let point = &it.point;
        let mirrored = above(reflect(point.incoming, point.normal), point.geometric_normal);
        let shadows = !matches!(self.integrator, Integrator::Whitted { shadows: false, .. });
        let mut sum = Vec3::ZERO;
        self.direct(it, shadows, effort, |direction, radiance| {
            sum += radiance * (0.5 * (k + 1.0) * direction.dot(mirrored).max(0.0).powf(k));
        });
        sum
    }

    pub(crate) fn user(&mut self, user: &UserSurface, it: &Interaction, bounce: Bounce) -> Vec4 {
        let scene = self.scene;
        let mesh = scene.mesh(it.point.instance);
        let mut renamed: Interaction;
        let mut it = it;
        if !scene.list().numbers.is_empty() {
            renamed = it.clone();
            renamed.point.instance = scene.list().number_of(it.point.instance);
            it = &renamed;
        }
        let point = &it.point;
        if mesh.params.is_empty() {
            return user.program.shade(user.block.bytes(), &mut Context { worker: self, it, bounce });
        }
        let mut memory = self.memory.patches.pop().unwrap_or_default();
        let weights = [1.0 - point.barycentric.x - point.barycentric.y, point.barycentric.x, point.barycentric.y];
        let block = user.block.patched(&mut memory, user.shader, &user.class, mesh, point.primitive, weights);
        let color = user.program.shade(block, &mut Context { worker: self, it, bounce });
        self.memory.patches.push(memory);
        color
    }
}

/// The refracted direction; None on total reflection.
pub(crate) fn refracted(point: &SurfacePoint, ior: f32) -> Option<Vec3> {
    let eta = if point.back_facing { ior } else { 1.0 / ior };
    refract(point.incoming, point.normal, eta).map(|d| -above(-d, point.geometric_normal))
}
