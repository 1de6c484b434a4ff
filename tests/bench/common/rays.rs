//! The rays of a picture, in the order in which a tile renderer makes them.
//!
//! Primary rays go through pixel centres, by tiles of 16×16 pixels, in these by 8×8 quads, 4×4 blocks and 4×2 halves: any aligned
//! run of 8, 16 or 64 rays is a compact part of the picture. Our hits of them start one shadow ray each, to a point light,
//! and one bounce ray each, cosine-distributed over the hemisphere by a hash of the pixel's number, both in the order
//! of their primary rays. All engines get the same bits.

use crate::ours::Ours;
use glam::Vec3;
use openrt::trace::{Hit, Ray, Tracer};

/// A count of rays that hit something.
pub type Hits = usize;

const TILE: u32 = 16;

/// A kind of ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Primary,
    Shadow,
    Bounce,
}

impl Kind {
    pub const ALL: [Kind; 3] = [Kind::Primary, Kind::Shadow, Kind::Bounce];

    pub fn name(self) -> &'static str {
        match self {
            Kind::Primary => "primary",
            Kind::Shadow => "shadow",
            Kind::Bounce => "bounce",
        }
    }
}

/// A pinhole, looking with +y up.
#[derive(Clone, Copy, Debug)]
pub struct View {
    pub eye: Vec3,
    pub at: Vec3,
    /// Of the vertical field of view.
    pub degrees: f32,
}

/// Traces rays and, from each hit, a shadow ray to a point light, as two batches; gives how many of both hit.
pub fn with_shadows(tracer: &Tracer, rays: &[Ray], light: Vec3) -> Hits {
    let hits = tracer.intersect_many(rays);
    let shadow = |(ray, hit): (&Ray, &Option<Hit>)| {
        let at = ray.origin + ray.direction * (hit.as_ref()?.t * 0.9999);
        Some(Ray { tmax: 1.0, ..Ray::new(at, light - at) })
    };
    let shadows: Vec<Ray> = rays.iter().zip(&hits).filter_map(shadow).collect();
    let mut dark = vec![false; shadows.len()];
    tracer.occluded_many(&shadows, &mut dark);
    shadows.len() + dark.iter().filter(|&&dark| dark).count()
}

/// Pixel coordinates in the order of the rays.
pub fn pixel_order(width: u32, height: u32) -> impl Iterator<Item = (u32, u32)> {
    let tiles =
        (0..height).step_by(TILE as usize).flat_map(move |y| (0..width).step_by(TILE as usize).map(move |x| (x, y)));
    let inside = |i: u32| {
        let (quad, block, half, pixel) = (i >> 6, i >> 4 & 3, i >> 3 & 1, i & 7);
        let x = (quad & 1) * 8 + (block & 1) * 4 + (pixel & 3);
        let y = (quad >> 1) * 8 + (block >> 1) * 4 + half * 2 + (pixel >> 2);
        (x, y)
    };
    tiles
        .flat_map(move |(x, y)| (0..TILE * TILE).map(inside).map(move |(dx, dy)| (x + dx, y + dy)))
        .filter(move |&(x, y)| x < width && y < height)
}

/// One ray per pixel.
pub fn primary(view: &View, [width, height]: [u32; 2]) -> Vec<Ray> {
    let back = (view.eye - view.at).normalize();
    let right = Vec3::Y.cross(back).normalize();
    let up = back.cross(right);
    let half = (view.degrees.to_radians() * 0.5).tan();
    let step = 2.0 * half / height as f32;
    let ray = |(x, y): (u32, u32)| {
        let at = right * ((x as f32 + 0.5 - width as f32 * 0.5) * step)
            + up * ((height as f32 * 0.5 - y as f32 - 0.5) * step);
        Ray::new(view.eye, (at - back).normalize())
    };
    pixel_order(width, height).map(ray).collect()
}

/// Shadow and bounce rays, one of each per primary ray that hits. `offset` is by how much they start above the surface.
pub fn secondary(ours: &Ours, primary: &[Ray], light: Vec3, offset: f32) -> (Vec<Ray>, Vec<Ray>) {
    let tracer = ours.tracer();
    let (mut shadow, mut bounce) = (Vec::new(), Vec::new());
    for (number, ray) in (0u64..).zip(primary) {
        let Some(hit) = tracer.intersect(ray) else { continue };
        let normal = ours.normal(&hit);
        if !normal.is_finite() {
            continue;
        }
        let normal = if normal.dot(ray.direction) > 0.0 { -normal } else { normal };
        let org = ray.origin + ray.direction * hit.t + normal * offset;
        shadow.push(Ray { tmax: 0.999, ..Ray::new(org, light - org) });
        bounce.push(Ray::new(org, hemisphere(normal, number)));
    }
    (shadow, bounce)
}

/// A direction around `normal`, cosine-distributed.
fn hemisphere(normal: Vec3, number: u64) -> Vec3 {
    let mut random = crate::random::Random::new(number.wrapping_mul(0x9e37_79b9) ^ 0xb0c4);
    // A point on the unit sphere around the tip of the normal (Lambert's law by construction).
    let z = random.unit() * 2.0 - 1.0;
    let (sin, cos) = (random.unit() * std::f32::consts::TAU).sin_cos();
    let r = (1.0 - z * z).max(0.0).sqrt();
    let dir = normal + Vec3::new(r * cos, r * sin, z) * 0.999;
    dir.normalize()
}
