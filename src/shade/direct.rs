//! Light that comes straight from the lights.

use crate::shade::interaction::Interaction;
use crate::shade::sampler::hammersley;
use crate::shade::worker::Worker;
use glam::{Vec2, Vec3};

/// How much of an area light one shading point samples.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Effort {
    /// As many points as the light asks for: smooth penumbrae from one camera sample. A quarter of it after each
    /// bounce.
    Full,
    /// One point, for estimators that average many camera samples.
    Single,
}

impl<'a> Worker<'a> {
    /// Calls `each(direction, radiance)` for all light that arrives at the point from the side of the viewer.
    /// Directions have unit length and a positive cosine to the normal, which `each` has to multiply itself.
    pub(crate) fn direct(&mut self, it: &Interaction, shadows: bool, effort: Effort, mut each: impl FnMut(Vec3, Vec3)) {
        let scene = self.scene;
        let point = &it.point;
        for light in &scene.lights {
            let n = match effort {
                Effort::Full => (light.samples >> (2 * point.depth).min(31)).max(1),
                Effort::Single => 1,
            };
            let area = light.samples > 1;
            // The shift differs from pixel to pixel, which turns the bands of a fixed pattern into fine grain.
            let shift = if area { self.rng.next_vec2() } else { Vec2::ZERO };
            for i in 0..n {
                let u = if area { hammersley(i, n, shift) } else { Vec2::splat(0.5) };
                let Some(sample) = light.sample(point.position, u) else { continue };
                let visible =
                    sample.direction.dot(point.normal) > 0.0 && sample.direction.dot(point.geometric_normal) > 0.0;
                if !visible {
                    continue;
                }
                let share = if shadows { self.transmittance(it, sample.direction, sample.distance) } else { Vec3::ONE };
                if share != Vec3::ZERO {
                    each(sample.direction, sample.radiance * share / n as f32);
                }
            }
        }
    }
}
