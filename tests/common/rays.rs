//! Rays that find the weak points of a structure, and hits compared by their bits.

use super::random::Random;
use glam::Vec3;
use openrt::trace::{Hit, Ray};

/// Rays at a set of points: towards corners, edges and inner points, along axes, starting on surfaces, short, long, scaled.
pub fn rays(random: &mut Random, triangles: &[[Vec3; 3]], count: usize) -> Vec<Ray> {
    let usable: Vec<[Vec3; 3]> =
        triangles.iter().copied().filter(|t| t.iter().all(|c| c.abs().max_element() <= 1.8e18)).collect();
    let scale = usable.iter().flatten().fold(0.0f32, |m, p| m.max(p.abs().max_element()));
    let scale = if scale > 0.0 { scale } else { 1.0 };
    (0..count)
        .map(|i| {
            let target = if usable.is_empty() {
                random.vec() * scale
            } else {
                let [a, b, c] = usable[random.below(usable.len())];
                let (u, v) = (random.unit() * 0.5, random.unit() * 0.5);
                match random.below(5) {
                    0 => a,
                    1 => b + (c - b) * u,
                    2 => (a + c) * 0.5,
                    3 => a + (b - a) * u + (c - a) * v,
                    _ => random.vec() * scale,
                }
            };
            let org = random.vec() * (2.0 * scale);
            let mut ray = Ray::new(org, target - org);
            let axis = random.below(3);
            match i % 10 {
                0 => {
                    ray.direction = Vec3::ZERO;
                    ray.direction[axis] = if random.below(2) == 0 { 1.0 } else { -1.0 };
                    ray.origin = target;
                    ray.origin[axis] = org[axis];
                }
                1 => ray.direction[axis] = -0.0,
                2 => ray.origin = target,
                3 => ray.tmax = random.unit() * 2.0,
                4 => ray.tmin = random.unit(),
                5 => ray.direction *= 1e25 / scale.max(1e-10),
                6 => ray.direction *= 1e-25,
                7 => ray.origin = target - (target - org) * 50.0,
                _ => {}
            }
            ray
        })
        .collect()
}

/// Whether the engine would scale this ray before tracing it; brute force cannot say its bits then.
pub fn is_rescaled(ray: &Ray) -> bool {
    let largest = ray.direction.abs().max_element();
    !(1e-6..=1e6).contains(&largest)
}

/// A hit, so that equal means equal in every bit.
pub fn bits(hit: &Option<Hit>) -> Option<(u32, u32, u32, u32, u32, u32)> {
    hit.map(|h| (h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.primitive, h.object, h.instance))
}
