//! Reflection at rough surfaces by microfacets: the distribution of Trowbridge and Reitz (GGX) with Smith's height-correlated
//! shadowing and Schlick's Fresnel term (Walter and others, *Microfacet Models for Refraction through Rough Surfaces*, 2007;
//! Heitz, *Understanding the Masking-Shadowing Function*, 2014).
//!
//! `alpha` is roughness². Light between microfacets is lost, as in most renderers: a white surface of roughness 1 reflects
//! about half of what arrives.

use crate::shade::optics::reflect;
use crate::shade::sampler::hammersley;
use glam::{Vec2, Vec3};
use std::f32::consts::{PI, TAU};
use std::sync::LazyLock;

/// Smallest alpha of highlights: a point light in a perfect mirror would be infinitely small and bright.
const SHARPEST: f32 = 0.01;

/// Schlick's approximation; `f0` is the reflectance at normal incidence.
#[inline]
pub fn fresnel(f0: Vec3, cosine: f32) -> Vec3 {
    f0 + (Vec3::ONE - f0) * (1.0 - cosine.clamp(0.0, 1.0)).powi(5)
}

/// BRDF × cosine × π, for light from `light` seen from `view` (unit vectors away from the point).
#[inline]
pub fn reflected(normal: Vec3, view: Vec3, light: Vec3, alpha: f32, f0: Vec3) -> Vec3 {
    let cos_light = light.dot(normal);
    if cos_light <= 0.0 {
        return Vec3::ZERO;
    }
    let cos_view = view.dot(normal).max(1e-4);
    let half = (view + light).normalize_or(normal);
    let cos_half = half.dot(normal).max(0.0);
    let a2 = alpha.max(SHARPEST).powi(2);
    let slope = cos_half * cos_half * (a2 - 1.0) + 1.0;
    let density = a2 / (PI * slope * slope);
    let shadowing = |cosine: f32| (cosine * cosine * (1.0 - a2) + a2).sqrt();
    let visible = 0.5 / (cos_light * shadowing(cos_view) + cos_view * shadowing(cos_light));
    fresnel(f0, view.dot(half)) * (PI * density * visible * cos_light)
}

/// Share of light from all sides that is reflected to the viewer, with the lobe and Fresnel's term each averaged for itself
/// (Karis, *Real Shading in Unreal Engine 4*, 2013).
#[inline]
pub fn reflectance(f0: Vec3, roughness: f32, cos_view: f32) -> Vec3 {
    let scale = (TABLE_SIDE - 1) as f32;
    let at = |x: f32| {
        let x = x.clamp(0.0, 1.0) * scale;
        let low = (x as usize).min(TABLE_SIDE - 2);
        (low, x - low as f32)
    };
    let ((i, u), (j, v)) = (at(roughness), at(cos_view));
    let row = |i: usize| TABLE[i][j].lerp(TABLE[i][j + 1], v);
    let share = row(i).lerp(row(i + 1), u);
    f0 * share.x + Vec3::splat(share.y)
}

const TABLE_SIDE: usize = 16;

/// By roughness and by cosine, in equal steps: the shares that F₀ and 1 have in the reflectance.
static TABLE: LazyLock<[[Vec2; TABLE_SIDE]; TABLE_SIDE]> = LazyLock::new(|| {
    const SAMPLES: u32 = 256;
    let step = |i: usize| i as f32 / (TABLE_SIDE - 1) as f32;
    std::array::from_fn(|i| {
        let alpha = step(i) * step(i);
        let a2 = alpha * alpha;
        std::array::from_fn(|j| {
            let cos_view = step(j).max(0.01);
            let view = Vec3::new((1.0 - cos_view * cos_view).sqrt(), 0.0, cos_view);
            let shadowing = |cosine: f32| (cosine * cosine * (1.0 - a2) + a2).sqrt();
            let mut sum = Vec2::ZERO;
            for k in 0..SAMPLES {
                let light = sample(-view, Vec3::Z, alpha, hammersley(k, SAMPLES, Vec2::ZERO));
                if light.z <= 0.0 {
                    continue;
                }
                // Smith's term of both directions over that of the viewer, which the density has.
                let both = light.z * shadowing(cos_view) + cos_view * shadowing(light.z);
                let share = light.z * (cos_view + shadowing(cos_view)) / both;
                let edge = (1.0 - view.dot((view + light).normalize_or(Vec3::Z)).clamp(0.0, 1.0)).powi(5);
                sum += Vec2::new(1.0 - edge, edge) * share;
            }
            sum / SAMPLES as f32
        })
    })
});

/// A direction in which `incoming` is reflected, by the density of visible microfacets (Dupuy and Benyoub, *Sampling
/// Visible GGX Normals with Spherical Caps*, 2023). It may lead below the surface.
#[inline]
pub fn sample(incoming: Vec3, normal: Vec3, alpha: f32, u: Vec2) -> Vec3 {
    let view = -incoming;
    let cos_view = view.dot(normal);
    // The frame turns with the viewer, so that a fixed set of samples has no seams.
    let fallback = || normal.any_orthonormal_vector();
    let tangent = (view - normal * cos_view).try_normalize().unwrap_or_else(fallback);
    let bitangent = normal.cross(tangent);
    let local = Vec3::new(view.dot(tangent) * alpha, 0.0, cos_view).normalize_or(Vec3::Z);
    let phi = TAU * u.x;
    let z = (1.0 - u.y) * (1.0 + local.z) - local.z;
    let sine = (1.0 - z * z).max(0.0).sqrt();
    let cap = Vec3::new(sine * phi.cos(), sine * phi.sin(), z) + local;
    let facet = Vec3::new(cap.x * alpha, cap.y * alpha, cap.z.max(0.0)).normalize_or(Vec3::Z);
    reflect(incoming, tangent * facet.x + bitangent * facet.y + normal * facet.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shade::sampler::cosine_hemisphere;

    /// A white surface reflects no more than arrives, and nearly all of it where it is smooth.
    #[test]
    fn energy_is_kept_or_lost_between_facets() {
        const N: u32 = 1 << 16;
        for roughness in [0.3f32, 0.5, 0.7, 1.0] {
            for cos_view in [0.2f32, 0.6, 1.0] {
                let view = Vec3::new((1.0 - cos_view * cos_view).sqrt(), 0.0, cos_view);
                let alpha = roughness * roughness;
                let at = |i| hammersley(i, N, Vec2::ZERO);
                let mean = (0..N)
                    .map(|i| {
                        let light = cosine_hemisphere(Vec3::Z, at(i));
                        f64::from(reflected(Vec3::Z, view, light, alpha, Vec3::ONE).x / light.z.max(1e-6))
                    })
                    .sum::<f64>()
                    / f64::from(N);
                assert!(mean < 1.02 && mean > 0.3, "roughness {roughness}, cosine {cos_view}: {mean}");
                let fit = reflectance(Vec3::ONE, roughness, cos_view).x;
                assert!(
                    (mean - f64::from(fit)).abs() < 0.03,
                    "roughness {roughness}, cosine {cos_view}: {mean}, {fit}"
                );
            }
        }
    }

    /// The mean direction of samples is that of the lobe.
    #[test]
    fn samples_follow_the_lobe() {
        const N: u32 = 1 << 14;
        let incoming = Vec3::new(0.6, 0.0, -0.8);
        for alpha in [0.0f32, 0.05, 0.3] {
            let mean = (0..N).map(|i| sample(incoming, Vec3::Z, alpha, hammersley(i, N, Vec2::ZERO))).sum::<Vec3>();
            let mean = mean / N as f32;
            assert!(mean.y.abs() < 1e-3 && mean.x > 0.39 && mean.z > 0.59, "{alpha}: {mean}");
            if alpha == 0.0 {
                assert!((mean - Vec3::new(0.6, 0.0, 0.8)).length() < 1e-3, "{mean}");
            }
        }
    }
}
