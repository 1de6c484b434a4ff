//! S3: 661 instances of two trees of 15,000 triangles, on a ground.

use super::{BenchScene, Part, Placement};
use crate::random::Random;
use crate::rays::View;
use glam::{Affine3A, Quat, Vec3};
use openrt::scene::{Mesh, Motion};

const TREE: usize = 15_000;
const COUNT: usize = 661;
/// Trees stand in a jittered grid so many wide.
const WIDE: usize = 26;

/// A tree under construction.
struct Tree {
    mesh: Mesh,
    /// Ends of the last branches, and where they point.
    tips: Vec<(Vec3, Vec3)>,
}

impl Tree {
    /// A tapered tube of so many sides.
    fn tube(&mut self, from: Vec3, to: Vec3, wide: f32, narrow: f32, sides: u32) {
        let along = (to - from).normalize();
        let across = along.any_orthonormal_vector();
        let first = self.mesh.positions.len() as u32;
        for (centre, radius) in [(from, wide), (to, narrow)] {
            for i in 0..sides {
                let turn = Quat::from_axis_angle(along, std::f32::consts::TAU * i as f32 / sides as f32);
                self.mesh.positions.push(centre + turn * across * radius);
            }
        }
        for i in 0..sides {
            let (a, b) = (first + i, first + (i + 1) % sides);
            self.mesh.triangles.extend([[a, b, a + sides], [b, b + sides, a + sides]]);
        }
    }

    /// A branch and those that grow from it.
    fn branch(&mut self, random: &mut Random, from: Vec3, along: Vec3, length: f32, thick: f32, levels: u32) {
        let bend = from + along * (length * 0.55);
        let turned = (along + random.vec() * 0.25 + Vec3::Y * 0.1).normalize();
        let to = bend + turned * (length * 0.45);
        let sides = 4 + 2 * levels.min(3);
        self.tube(from, bend, thick, thick * 0.8, sides);
        self.tube(bend, to, thick * 0.8, thick * 0.5, sides);
        if levels == 0 {
            self.tips.push((to, turned));
            return;
        }
        for i in 0..4 {
            let start = if i < 2 { bend } else { to };
            let out = (turned * 0.7 + random.vec() * 0.9 + Vec3::Y * 0.15).normalize();
            self.branch(random, start, out, length * 0.62, thick * 0.5, levels - 1);
        }
    }
}

/// A trunk, branches, and single triangles for leaves up to the number wanted.
pub fn tree(seed: u64, height: f32) -> Mesh {
    let mut random = Random::new(seed);
    let mut tree = Tree { mesh: Mesh::default(), tips: Vec::new() };
    tree.branch(&mut random, Vec3::ZERO, Vec3::Y, height, 0.05 * height, 4);
    let Tree { mut mesh, tips } = tree;
    let mut i = 0;
    while mesh.triangles.len() < TREE {
        let (tip, along) = tips[i % tips.len()];
        i += 1;
        let at = tip - along * (0.12 * random.unit()) + random.vec() * 0.14;
        let first = mesh.positions.len() as u32;
        mesh.positions.extend([at, at + random.vec() * 0.055, at + random.vec() * 0.055]);
        mesh.triangles.push([first, first + 1, first + 2]);
    }
    mesh
}

/// A gentle hilly ground.
pub fn ground() -> Mesh {
    let n = 32u32;
    let height = |x: f32, z: f32| 0.5 * ((0.13 * x).sin() + (0.11 * z + 1.0).cos());
    let at = |i: u32| {
        let side = |k: u32| (k as f32 / n as f32 - 0.5) * 140.0;
        let (x, z) = (side(i % (n + 1)), side(i / (n + 1)));
        Vec3::new(x, height(x, z) - 0.6, z)
    };
    let triangles = (0..n * n)
        .flat_map(|i| {
            let a = i / n * (n + 1) + i % n;
            [[a, a + n + 1, a + 1], [a + 1, a + n + 1, a + n + 2]]
        })
        .collect();
    Mesh { positions: (0..(n + 1) * (n + 1)).map(at).collect(), triangles, ..Mesh::default() }
}

pub fn forest() -> BenchScene {
    let parts = [tree(31, 1.1), tree(32, 1.5), ground()];
    let mut random = Random::new(3);
    let mut placements = vec![Placement { part: 2, transform: Affine3A::IDENTITY }];
    for i in 0..COUNT {
        let cell =
            Vec3::new((i % WIDE) as f32, 0.0, (i / WIDE) as f32) - (WIDE as f32 - 1.0) * 0.5 * Vec3::new(1.0, 0.0, 1.0);
        let at = (cell + random.vec() * Vec3::new(0.4, 0.0, 0.4)) * 2.2;
        let turn = Quat::from_rotation_y(random.unit() * std::f32::consts::TAU);
        let size = Vec3::splat(0.7 + 0.6 * random.unit());
        let transform = Affine3A::from_scale_rotation_translation(size, turn, at);
        placements.push(Placement { part: i % 2, transform });
    }
    BenchScene {
        name: "S3",
        title: "661 trees of two kinds",
        parts: parts.into_iter().map(|mesh| Part::rigid(mesh, Motion::Affine)).collect(),
        place: Box::new(move |_| placements.clone()),
        instanced: true,
        view: View { eye: Vec3::new(2.0, 7.5, 33.0), at: Vec3::new(0.0, 0.5, 0.0), degrees: 45.0 },
        light: Vec3::new(30.0, 50.0, 20.0),
        sizes: vec![[640, 480]],
    }
}
