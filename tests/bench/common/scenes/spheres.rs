//! S1, S5 and S7: spheres, large and bumpy, deforming, and many small ones that fly about.

use super::{BenchScene, FRAMES, Part, in_place};
use crate::meshes::{icosphere, moved};
use crate::random::Random;
use crate::rays::View;
use glam::Vec3;
use openrt::scene::Motion;
use std::sync::Arc;

/// Waves on a unit sphere at several scales.
fn bumps(p: Vec3) -> f32 {
    let wave = |k: f32| (k * p.x + 0.7).sin() * (k * p.y + 1.9).sin() * (k * p.z + 0.3).sin();
    0.10 * wave(6.0) + 0.04 * wave(19.0) + 0.01 * wave(67.0)
}

/// S1: one static mesh of 1,310,720 triangles.
pub fn bumpy_sphere() -> BenchScene {
    let mesh = moved(icosphere(8), |p| p * (1.0 + bumps(p)));
    BenchScene {
        name: "S1",
        title: "bumpy sphere",
        parts: vec![Part::rigid(mesh, Motion::Static)],
        place: in_place(1),
        instanced: false,
        view: View { eye: Vec3::new(0.9, 1.1, 2.0), at: Vec3::ZERO, degrees: 45.0 },
        light: Vec3::new(4.0, 5.0, 3.0),
        sizes: vec![[640, 480], [1024, 1024]],
    }
}

/// S5: nine meshes of 81,920 triangles in rows of three, each deforming its own way; the camera sees about half of them.
pub fn blobs() -> BenchScene {
    let sphere = icosphere(6);
    let directions = Arc::new(sphere.positions);
    let part = |i: u32| {
        let directions = directions.clone();
        let centre = Vec3::new((i % 3) as f32 - 1.0, 0.0, (i / 3) as f32 - 1.0) * 2.6;
        let phase = i as f32 * 1.7;
        let positions = move |frame: u32| {
            let time = frame as f32 / FRAMES as f32 * std::f32::consts::TAU + phase;
            let shape = |p: &Vec3| {
                let slow = (3.0 * p.x + time).sin() * (2.0 * p.y - time).cos() + 0.5 * (5.0 * p.z + 2.0 * time).sin();
                let fine = (23.0 * p.y + phase).sin() * (19.0 * p.x + 17.0 * p.z).sin();
                centre + *p * (1.0 + 0.18 * slow + 0.015 * fine)
            };
            directions.iter().map(shape).collect()
        };
        Part { triangles: sphere.triangles.clone(), positions: Box::new(positions), motion: Motion::Unstructured }
    };
    BenchScene {
        name: "S5",
        title: "nine deforming blobs",
        parts: (0..9).map(part).collect(),
        place: in_place(9),
        instanced: false,
        view: View { eye: Vec3::new(4.6, 1.5, 6.0), at: Vec3::new(2.0, -0.1, 1.6), degrees: 50.0 },
        light: Vec3::new(8.0, 7.0, 6.0),
        sizes: vec![[640, 480]],
    }
}

/// S7: one mesh of 456 spheres of 320 triangles, flying straight on and bouncing off the walls of a box.
pub fn small_spheres() -> BenchScene {
    small_spheres_of(FRAMES)
}

/// The same flight in so many frames.
pub fn small_spheres_of(frames: u32) -> BenchScene {
    let pace = FRAMES as f32 / frames as f32;
    let sphere = icosphere(2);
    let mut random = Random::new(7);
    let balls: Vec<(Vec3, Vec3, f32)> =
        (0..456).map(|_| (random.vec(), random.vec() * 0.12, 0.04 + 0.05 * random.unit())).collect();
    let count = sphere.positions.len() as u32;
    let triangles = (0..456).flat_map(|i| sphere.triangles.iter().map(move |t| t.map(|v| v + i * count))).collect();
    let directions = sphere.positions.clone();
    let positions = move |frame: u32| {
        let ball = |&(start, step, radius): &(Vec3, Vec3, f32)| {
            // Folded into -1..1 as a triangle wave.
            let far = start + step * (frame as f32 * pace);
            let centre = far.map(|x| ((x - 1.0).rem_euclid(4.0) - 2.0).abs() - 1.0);
            directions.iter().map(move |d| centre + *d * radius)
        };
        balls.iter().flat_map(ball).collect()
    };
    BenchScene {
        name: "S7",
        title: "456 small moving spheres",
        parts: vec![Part { triangles, positions: Box::new(positions), motion: Motion::Unstructured }],
        place: in_place(1),
        instanced: false,
        view: View { eye: Vec3::new(0.6, 0.5, 2.9), at: Vec3::ZERO, degrees: 42.0 },
        light: Vec3::new(2.0, 4.0, 3.0),
        sizes: vec![[640, 480]],
    }
}
