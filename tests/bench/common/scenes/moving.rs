//! S4 and S6: triangles that fly between key frames, and cloth that falls over a ball.

use super::{BenchScene, FRAMES, Part, in_place};
use crate::meshes::{icosphere, moved};
use crate::random::Random;
use crate::rays::View;
use glam::Vec3;
use openrt::scene::Motion;
use std::f32::consts::{PI, TAU};

/// Triangles of S4, as in the largest of the museum scenes.
pub const SOUP: usize = 65_536;
/// Shapes that the soup takes, one per key frame.
pub const KEYS: usize = 5;

/// Where a triangle is in the shape of key frame `key`: a cube, a shell, a ring, a ball, a spiral.
fn shape(key: usize, random: &mut Random) -> Vec3 {
    let (a, b, c) = (random.unit(), random.unit(), random.unit());
    let on_sphere = || {
        let z = 2.0 * a - 1.0;
        let (sin, cos) = (b * TAU).sin_cos();
        let r = (1.0 - z * z).max(0.0).sqrt();
        Vec3::new(r * cos, r * sin, z)
    };
    match key {
        0 => Vec3::new(a, b, c) * 2.0 - 1.0,
        1 => on_sphere() * (0.95 + 0.1 * c),
        2 => {
            let (sin, cos) = (b * TAU).sin_cos();
            let tube = 0.75 + 0.3 * c.sqrt() * (a * TAU).cos();
            Vec3::new(tube * cos, 0.3 * c.sqrt() * (a * TAU).sin(), tube * sin)
        }
        3 => on_sphere() * c.cbrt() * 1.1,
        _ => {
            let (sin, cos) = (a * 3.0 * TAU).sin_cos();
            Vec3::new(cos * (0.3 + 0.7 * a), 2.0 * a - 1.0, sin * (0.3 + 0.7 * a))
                + (Vec3::new(b, c, b * c) - 0.5) * 0.3
        }
    }
}

/// Triangles without neighbours, that meet in another shape at every key frame, each by a way of its own.
pub struct Soup {
    /// Where each triangle is in every shape, and its edges.
    places: Vec<([Vec3; KEYS], [Vec3; 2])>,
}

impl Soup {
    /// As large together as S4 is, whatever their number.
    pub fn new(count: usize) -> Soup {
        let mut random = Random::new(4);
        let size = 0.03 * (SOUP as f32 / count as f32).sqrt();
        let one = |_| {
            let keys = std::array::from_fn(|key| shape(key, &mut random));
            (keys, [random.vec() * size, random.vec() * size])
        };
        Soup { places: (0..count).map(one).collect() }
    }

    pub fn triangles(&self) -> Vec<[u32; 3]> {
        (0..self.places.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect()
    }

    /// Corners on the straight way from one shape to the next. Times beyond the last stay there.
    pub fn corners(&self, time: f32) -> Vec<Vec3> {
        let key = (time as usize).min(KEYS - 2);
        let part = (time - key as f32).min(1.0);
        let corners = |(keys, [u, v]): &([Vec3; KEYS], [Vec3; 2])| {
            let at = keys[key].lerp(keys[key + 1], part);
            [at, at + *u, at + *v]
        };
        self.places.iter().flat_map(corners).collect()
    }
}

/// S4.
pub fn soup() -> BenchScene {
    soup_of(SOUP, FRAMES)
}

/// So many triangles, in so many frames from the first shape to the last.
pub fn soup_of(count: usize, frames: u32) -> BenchScene {
    let soup = Soup::new(count);
    let triangles = soup.triangles();
    let positions = move |frame: u32| {
        let time = (frame as f32 / (frames - 1) as f32 * (KEYS - 1) as f32).min((KEYS - 1) as f32);
        let key = (time as usize).min(KEYS - 2) as f32;
        let part = time - key;
        // Slow at the key frames.
        soup.corners(key + part * part * (3.0 - 2.0 * part))
    };
    BenchScene {
        name: "S4",
        title: "key-framed soup",
        parts: vec![Part { triangles, positions: Box::new(positions), motion: Motion::Unstructured }],
        place: in_place(1),
        instanced: false,
        view: View { eye: Vec3::new(1.4, 1.2, 3.4), at: Vec3::ZERO, degrees: 40.0 },
        light: Vec3::new(3.0, 5.0, 4.0),
        sizes: vec![[320, 240]],
    }
}

/// Quads along a side of the cloth.
const CLOTH: u32 = 215;
const BALL: f32 = 1.0;

/// S6: 92,450 triangles of cloth, flat at first and hanging at last, over a ball of 20,480. Nearly isometric: from the pole
/// the cloth follows the ball up to an angle that grows with time, and goes on along the tangent, with folds.
pub fn cloth() -> BenchScene {
    cloth_of(FRAMES)
}

/// The same fall in so many frames.
pub fn cloth_of(frames: u32) -> BenchScene {
    let triangles = (0..CLOTH * CLOTH)
        .flat_map(|i| {
            let a = i / CLOTH * (CLOTH + 1) + i % CLOTH;
            let below = a + CLOTH + 1;
            [[a, below, a + 1], [a + 1, below, below + 1]]
        })
        .collect();
    let positions = move |frame: u32| {
        let time = frame as f32 / (frames - 1) as f32;
        let touching = 0.25 + 1.1 * time;
        let point = |i: u32| {
            let side = |k: u32| (k as f32 / CLOTH as f32 - 0.5) * 3.6;
            let (x, z) = (side(i % (CLOTH + 1)), side(i / (CLOTH + 1)));
            let (length, around) = ((x * x + z * z).sqrt(), z.atan2(x));
            let radius = BALL * 1.01;
            let angle = (length / radius).min(touching);
            let free = length - angle * radius;
            let folds = free * free * (0.05 + 0.10 * time) * (7.0 * around + 2.0 * time * PI).sin();
            let ripple = 0.012 * free * (9.0 * x + 11.0 * z + 4.0 * time).sin();
            let (sin, cos) = angle.sin_cos();
            let out = radius * sin + free * cos + folds * sin;
            let up = radius * cos - free * sin + folds * cos + ripple;
            Vec3::new(out * around.cos(), up, out * around.sin())
        };
        (0..(CLOTH + 1) * (CLOTH + 1)).map(point).collect()
    };
    BenchScene {
        name: "S6",
        title: "cloth over a ball",
        parts: vec![
            Part { triangles, positions: Box::new(positions), motion: Motion::Unstructured },
            Part::rigid(moved(icosphere(5), |p| p * BALL), Motion::Static),
        ],
        place: in_place(2),
        instanced: false,
        view: View { eye: Vec3::new(1.9, 1.3, 3.4), at: Vec3::new(0.0, 0.1, 0.0), degrees: 42.0 },
        light: Vec3::new(3.0, 5.0, 1.5),
        sizes: vec![[640, 480]],
    }
}
