//! Light that comes straight from the lights.

use crate::shade::interaction::Interaction;
use crate::shade::worker::Worker;
use glam::Vec3;

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
    #[inline]
    pub(crate) fn direct(&mut self, it: &Interaction, shadows: bool, effort: Effort, mut each: impl FnMut(Vec3, Vec3)) {
        let scene = self.scene;
        let point = &it.point;
        for light in &scene.lights {
            let n = match effort {
                Effort::Full => light.points(point.depth),
                Effort::Single => 1,
            };
            let shift = light.shift(&mut self.rng);
            for i in 0..n {
                if self.is_cancelled() {
                    return;
                }
                let Some(sample) = light.facing(point, i, n, shift) else { continue };
                let share = if shadows { self.transmittance(it, sample.direction, sample.distance) } else { Vec3::ONE };
                if share != Vec3::ZERO {
                    each(sample.direction, sample.radiance * share / n as f32);
                }
            }
        }
    }
}
