//! The six animations of Kopta12 figure 3, generated: as many triangles, moving in the same ways.
//!
//! Cloth over a ball, the key-framed soup and the n-body spheres are scenes of the other bench; a forest in which little moves, a body
//! that bursts when another hits it, and a large walking figure that falls to pieces are made here. Like the paper's, each of them is one mesh
//! under one tree. Triangles of what breaks share no vertices.

use crate::meshes::{moved, uv_sphere};
use crate::random::Random;
use crate::rays::View;
use crate::scenes::{BenchScene, Part, forest, in_place, moving, spheres};
use glam::{Affine3A, Quat, Vec3};
use openrt::scene::{Mesh, Motion};
use std::f32::consts::TAU;

/// A scene of the paper, at the pace that makes it end after so many frames.
pub struct Animation {
    /// As the paper calls it.
    pub name: &'static str,
    pub make: fn(u32) -> BenchScene,
}

pub const ALL: [Animation; 6] = [
    Animation { name: "Clothball", make: moving::cloth_of },
    Animation { name: "BART", make: |frames| moving::soup_of(moving::SOUP, frames) },
    Animation { name: "FairyForest", make: fairy_forest },
    Animation { name: "DragBun", make: bursting },
    Animation { name: "Lion", make: walker },
    Animation { name: "N-body", make: spheres::small_spheres_of },
];

/// The BART museum with so many triangles between its shapes: those, and the hall around them.
pub fn museum(count: usize, frames: u32) -> BenchScene {
    let mut bench = moving::soup_of(count, frames);
    bench.parts.push(Part::rigid(hall(), Motion::Static));
    bench.place = in_place(2);
    bench.light = Vec3::new(3.0, 2.2, 2.0);
    bench
}

/// 10,000 triangles of walls that bulge, seen from inside.
pub fn hall() -> Mesh {
    moved(uv_sphere(72, 72), |p| p.map(|x| x.signum() * x.abs().powf(0.3)) * Vec3::new(6.0, 3.0, 6.0))
}

/// A mesh under construction.
#[derive(Default)]
struct Heap {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
}

impl Heap {
    /// Gives the vertices that were added.
    fn add(&mut self, mesh: &Mesh, place: Affine3A) -> std::ops::Range<usize> {
        let first = self.positions.len();
        self.positions.extend(mesh.positions.iter().map(|p| place.transform_point3(*p)));
        self.triangles.extend(mesh.triangles.iter().map(|t| t.map(|v| v + first as u32)));
        first..self.positions.len()
    }
}

/// An ellipsoid.
fn body(half: Vec3, rings: u32, around: u32) -> Mesh {
    moved(uv_sphere(rings, around), |p| p * half)
}

fn one_part(
    title: &'static str,
    triangles: Vec<[u32; 3]>,
    positions: impl Fn(u32) -> Vec<Vec3> + Send + Sync + 'static,
    view: View,
    light: Vec3,
) -> BenchScene {
    BenchScene {
        name: "",
        title,
        parts: vec![Part { triangles, positions: Box::new(positions), motion: Motion::Unstructured }],
        place: in_place(1),
        instanced: false,
        view,
        light,
        sizes: vec![[640, 480]],
    }
}

/// 174,000 triangles: eight trees and sixteen mushrooms on a ground, between which two small figures fly.
fn fairy_forest(frames: u32) -> BenchScene {
    let mut random = Random::new(174);
    let mut heap = Heap::default();
    heap.add(
        &forest::ground(),
        Affine3A::from_scale_rotation_translation(Vec3::splat(0.1), Quat::IDENTITY, Vec3::ZERO),
    );
    let trees = [forest::tree(31, 1.1), forest::tree(32, 1.5)];
    for i in 0..8u32 {
        let (sin, cos) = (i as f32 / 8.0 * TAU).sin_cos();
        let at = Vec3::new(3.0 * cos, -0.1, 3.0 * sin) + random.vec() * Vec3::new(0.5, 0.0, 0.5);
        let place = Affine3A::from_scale_rotation_translation(
            Vec3::splat(1.0 + 0.4 * random.unit()),
            Quat::from_rotation_y(random.unit() * TAU),
            at,
        );
        heap.add(&trees[i as usize % 2], place);
    }
    let hat = body(Vec3::new(0.18, 0.1, 0.18), 21, 25);
    for _ in 0..16 {
        heap.add(&hat, Affine3A::from_translation(random.vec() * Vec3::new(2.0, 0.0, 2.0) + Vec3::Y * 0.1));
    }
    let figures = [(body(Vec3::new(0.12, 0.3, 0.08), 61, 180), 0.0), (body(Vec3::new(0.3, 0.06, 0.06), 61, 120), 2.1)];
    let flying = figures.map(|(mesh, phase)| (heap.add(&mesh, Affine3A::IDENTITY), phase));
    let Heap { positions: rest, triangles } = heap;
    let positions = move |frame: u32| {
        let mut now = rest.clone();
        for (range, phase) in flying.iter().cloned() {
            let turn = frame as f32 / frames as f32 * TAU + phase;
            let at = Vec3::new(1.2 * turn.cos(), 0.9 + 0.3 * (2.0 * turn).sin(), 1.2 * turn.sin());
            let place = Affine3A::from_rotation_translation(Quat::from_rotation_y(-turn), at);
            for p in &mut now[range] {
                // Beating as wings do.
                let bent = *p + Vec3::Z * (p.y.abs().max(p.x.abs()) * 0.5 * (9.0 * turn).sin());
                *p = place.transform_point3(bent);
            }
        }
        now
    };
    let view = View { eye: Vec3::new(0.5, 1.6, 4.6), at: Vec3::new(0.0, 0.6, 0.0), degrees: 50.0 };
    one_part("forest with two flying figures", triangles, positions, view, Vec3::new(4.0, 9.0, 5.0))
}

/// Triangles that are thrown about from a moment on.
struct Shards {
    corners: Vec<[Vec3; 3]>,
    /// Of each triangle: its way per unit of time, and its spin.
    flights: Vec<(Vec3, Vec3)>,
}

impl Shards {
    /// Flies outwards from `center`, triangles of a cell of the size `cell` together, each a little on its own.
    fn new(mesh: &Mesh, center: Vec3, cell: f32, speed: f32) -> Shards {
        let mut random = Random::new(253);
        let count = mesh.triangles.len() as u32;
        let corners: Vec<[Vec3; 3]> = (0..count).map(|i| mesh.corners(i)).collect();
        let flights = corners.iter().map(|c| {
            let middle = (c[0] + c[1] + c[2]) / 3.0;
            let place = (middle / cell).floor().as_ivec3();
            let key = place.to_array().iter().fold(17u64, |h, &x| h.wrapping_mul(0x9e37_79b9).wrapping_add(x as u64));
            let mut shared = Random::new(key);
            let out = (middle - center).normalize_or(Vec3::Y);
            let way = out * (0.3 + shared.unit()) + shared.vec() * 0.6 + random.vec() * 0.15;
            (way * speed, shared.vec() * 9.0)
        });
        let flights = flights.collect();
        Shards { corners, flights }
    }

    /// Corners after so much time of flight; what has not begun to fly rests.
    fn at(&self, time: f32, to: &mut Vec<Vec3>) {
        for (corners, (way, spin)) in self.corners.iter().zip(&self.flights) {
            if time <= 0.0 {
                to.extend(corners);
                continue;
            }
            let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
            let turn = Quat::from_scaled_axis(*spin * time);
            let to_middle = middle + *way * time - Vec3::Y * (0.8 * time * time);
            to.extend(corners.iter().map(|c| to_middle + turn * (*c - middle)));
        }
    }
}

/// 253,000 triangles: a body of 240,000 bursts when one of 12,960 hits it, after a quarter of the frames.
fn bursting(frames: u32) -> BenchScene {
    let wave = |p: Vec3| 1.0 + 0.15 * (7.0 * p.x).sin() * (5.0 * p.y + 1.0).sin() + 0.03 * (31.0 * p.z).sin();
    let dragon = moved(uv_sphere(301, 400), |p| p * wave(p));
    let bunny = body(Vec3::splat(0.22), 82, 80);
    let shards = Shards::new(&dragon, Vec3::new(-0.8, 0.1, 0.0), 0.12, 2.0);
    let count = 3 * shards.corners.len() as u32;
    let mut triangles: Vec<[u32; 3]> = (0..count / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    triangles.extend(bunny.triangles.iter().map(|t| t.map(|v| v + count)));
    let positions = move |frame: u32| {
        let time = frame as f32 / frames as f32;
        let mut now = Vec::with_capacity(count as usize + bunny.positions.len());
        shards.at(time - 0.25, &mut now);
        let at = Vec3::new(-3.0 + 8.0 * time, 0.1, 0.0);
        now.extend(bunny.positions.iter().map(|p| *p + at));
        now
    };
    let view = View { eye: Vec3::new(0.8, 0.9, 3.6), at: Vec3::ZERO, degrees: 46.0 };
    one_part("a body bursts", triangles, positions, view, Vec3::new(3.0, 6.0, 4.0))
}

/// 1.6 million triangles: a four-legged figure of ellipsoids walks on the spot, and falls to pieces in the last two fifths.
fn walker(frames: u32) -> BenchScene {
    const LIMB: f32 = 0.55;
    // Rings and triangles around; where it is attached; in which phase it swings.
    let trunk = body(Vec3::new(0.9, 0.42, 0.36), 601, 500);
    let head = moved(body(Vec3::splat(0.34), 401, 250), |p| p + Vec3::new(1.1, 0.35, 0.0));
    let limb = |half: f32| moved(body(Vec3::new(0.12, half, 0.12), 401, 250), move |p| p - Vec3::Y * half);
    let legs = [(0.6, 0.22, 0.0), (0.6, -0.22, 0.5), (-0.6, 0.22, 0.5), (-0.6, -0.22, 0.0)];
    let mut pieces = vec![(trunk, None), (head, None)];
    for (x, z, phase) in legs {
        pieces.push((moved(limb(LIMB), move |p| p + Vec3::new(x, -0.2, z)), Some((Vec3::new(x, -0.2, z), phase))));
    }
    let mut all = Mesh::default();
    // Per triangle, in which piece it is.
    let mut piece_of: Vec<u8> = Vec::new();
    let mut hinges = Vec::new();
    for (number, (mesh, hinge)) in pieces.into_iter().enumerate() {
        let first = all.positions.len() as u32;
        all.positions.extend(&mesh.positions);
        all.triangles.extend(mesh.triangles.iter().map(|t| t.map(|v| v + first)));
        piece_of.resize(all.triangles.len(), number as u8);
        hinges.push(hinge);
    }
    let shards = Shards::new(&all, Vec3::ZERO, 0.2, 0.7);
    let count = 3 * shards.corners.len() as u32;
    let triangles = (0..count / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let positions = move |frame: u32| {
        let time = frame as f32 / frames as f32;
        let mut now = Vec::with_capacity(count as usize);
        shards.at(time - 0.6, &mut now);
        let turns = hinges.iter().map(|hinge| match hinge {
            None => Affine3A::from_translation(Vec3::Y * (0.04 * (time * 4.0 * TAU).sin())),
            Some((at, phase)) => {
                let swing = Quat::from_rotation_z(0.5 * ((2.0 * time + phase) * TAU).sin());
                Affine3A::from_translation(*at) * Affine3A::from_quat(swing) * Affine3A::from_translation(-*at)
            }
        });
        let turns: Vec<Affine3A> = turns.collect();
        for (corners, &piece) in now.chunks_exact_mut(3).zip(&piece_of) {
            corners.iter_mut().for_each(|p| *p = turns[piece as usize].transform_point3(*p));
        }
        now
    };
    let view = View { eye: Vec3::new(1.7, 0.9, 3.4), at: Vec3::new(0.1, -0.25, 0.0), degrees: 46.0 };
    one_part("a figure walks and falls to pieces", triangles, positions, view, Vec3::new(3.0, 6.0, 4.0))
}
