//! `ambient_occlusion`: how much of the sky each point sees (Zhukov, Iones, Kronin, *An Ambient Light Illumination
//! Model*, 1998), weighted by the cosine.
//!
//! The estimator is the share of cosine-distributed rays that escape: unbiased, and exactly 1 where nothing is near.

use crate::shade::sampler::{cosine_hemisphere, hammersley};
use crate::shade::worker::{Bounce, MAX_LAYERS, Worker};
use crate::trace::{Hit, Ray};
use glam::{Vec3, Vec4};

impl<'a> Worker<'a> {
    pub(crate) fn occlusion(
        &mut self,
        mut ray: Ray,
        first: Option<Hit>,
        bounce: Bounce,
        samples: u32,
        distance: f32,
    ) -> Vec4 {
        let scene = self.scene;
        let mut next = first;
        for _ in 0..MAX_LAYERS {
            let Some(hit) = next else { return scene.environment.radiance(ray.direction, bounce.cone) };
            let it = scene.interaction(&ray, &hit, bounce.cone, bounce.depth);
            if scene.surface(&hit).is_hole(&it, &scene.textures) {
                ray.tmin = hit.t.next_up();
                next = self.closest(&ray, bounce.depth);
                continue;
            }
            self.see(&it);
            let shift = self.rng.next_vec2();
            let mut open = Vec3::ZERO;
            for i in 0..samples {
                if self.is_cancelled() {
                    break;
                }
                let direction = cosine_hemisphere(it.point.normal, hammersley(i, samples, shift));
                // Directions below the true surface, which interpolated normals allow, are mirrored above it.
                let height = direction.dot(it.point.geometric_normal);
                let direction =
                    if height < 0.0 { direction - it.point.geometric_normal * (2.0 * height) } else { direction };
                open += self.transmittance(&it, direction, distance);
            }
            return (open / samples as f32).extend(1.0);
        }
        Vec4::ZERO
    }
}
