//! *crowd* and *sculpt*: more triangles than can be touched in a frame, of which few are seen, or few move.

use super::{BenchScene, Part, in_place};
use crate::meshes::uv_sphere;
use crate::rays::View;
use glam::Vec3;
use openrt::scene::Motion;
use std::f32::consts::PI;
use std::sync::Arc;

/// Bodies side by side in rows of so many.
const BODIES: u32 = 200;
const WIDE: u32 = 20;
/// Distance between their centres.
const APART: f32 = 3.2;

/// 10 million triangles in 200 bodies that all breathe; the camera looks down on about ten of them.
pub fn crowd() -> BenchScene {
    let body = uv_sphere(101, 250);
    let directions = Arc::new(body.positions);
    let part = |i: u32| {
        let directions = directions.clone();
        let centre = Vec3::new((i % WIDE) as f32, 0.0, (i / WIDE) as f32) * APART;
        let phase = i as f32 * 0.7;
        let positions = move |frame: u32| {
            let time = frame as f32 * 0.35 + phase;
            directions.iter().map(|p| centre + *p * (1.0 + 0.2 * (4.0 * p.x + 3.0 * p.y + time).sin())).collect()
        };
        Part { triangles: body.triangles.clone(), positions: Box::new(positions), motion: Motion::Unstructured }
    };
    let at = Vec3::new(4.5, 0.0, 4.5) * APART;
    BenchScene {
        name: "CROWD",
        title: "200 bodies, a few of them seen",
        parts: (0..BODIES).map(part).collect(),
        place: in_place(BODIES as usize),
        instanced: false,
        view: View { eye: at + Vec3::new(0.0, 12.0, 4.0), at, degrees: 38.0 },
        light: at + Vec3::new(3.0, 20.0, -2.0),
        sizes: vec![[640, 480]],
    }
}

/// Vertices around the sphere, and rings of them.
const AROUND: u32 = 1000;
/// Vertices of a stroke: a run in a ring, at four triangles each.
const STROKE: u32 = 125;

/// One mesh of 2 million triangles; every frame pulls at 125 neighbouring vertices of it, which moves 500 triangles.
pub fn sculpt() -> BenchScene {
    let sphere = uv_sphere(AROUND + 1, AROUND);
    let smooth = sphere.positions;
    let positions = move |frame: u32| {
        let mut points = smooth.clone();
        for stroke in 1..=frame {
            let first = 2 + (300 + 9 * stroke) * AROUND + 100 + 3 * stroke;
            for (i, p) in points[first as usize..][..STROKE as usize].iter_mut().enumerate() {
                *p *= 1.0 + 0.03 * (PI * i as f32 / STROKE as f32).sin();
            }
        }
        points
    };
    BenchScene {
        name: "SCULPT",
        title: "strokes on one large mesh",
        parts: vec![Part { triangles: sphere.triangles, positions: Box::new(positions), motion: Motion::Unstructured }],
        place: in_place(1),
        instanced: false,
        view: View { eye: Vec3::new(1.6, 1.3, 1.8), at: Vec3::ZERO, degrees: 42.0 },
        light: Vec3::new(4.0, 5.0, 3.0),
        sizes: vec![[640, 480]],
    }
}
