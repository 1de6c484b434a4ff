//! Meshes of the kinds that structures over planes find hard: large triangles beside small ones, long thin ones, all detail in one place.

use super::meshes::{icosphere, mesh, moved, uv_sphere};
use super::random::Random;
use glam::{Affine3A, Quat, Vec3};
use openrt::scene::Mesh;
use std::f32::consts::{PI, TAU};

/// Adds a mesh somewhere else.
pub fn add(all: &mut Mesh, mesh: &Mesh, place: Affine3A) {
    let first = all.positions.len() as u32;
    all.positions.extend(mesh.positions.iter().map(|p| place.transform_point3(*p)));
    all.triangles.extend(mesh.triangles.iter().map(|t| t.map(|v| v + first)));
}

/// Two triangles from `at` along `u` and `v`.
pub fn quad(at: Vec3, u: Vec3, v: Vec3) -> Mesh {
    Mesh { positions: vec![at, at + u, at + v, at + u + v], triangles: vec![[0, 1, 2], [2, 1, 3]], ..Mesh::default() }
}

/// `wide * long` quads between points.
pub fn sheet(wide: u32, long: u32, at: impl Fn(f32, f32) -> Vec3) -> Mesh {
    let row = wide + 1;
    let positions = (0..row * (long + 1)).map(|i| at((i % row) as f32 / wide as f32, (i / row) as f32 / long as f32));
    let triangles = (0..wide * long).flat_map(|i| {
        let a = i / wide * row + i % wide;
        [[a, a + row, a + 1], [a + 1, a + row, a + row + 1]]
    });
    Mesh { positions: positions.collect(), triangles: triangles.collect(), ..Mesh::default() }
}

/// A cylinder along y from 0 to 1, of radius 1, as drawing programs make them: sides as high as it is, ends as fans around a corner.
pub fn cylinder(sides: u32) -> Mesh {
    let corner = |i: u32, y: f32| {
        let (sin, cos) = (TAU * (i % sides) as f32 / sides as f32).sin_cos();
        Vec3::new(cos, y, sin)
    };
    let mut triangles: Vec<[Vec3; 3]> = Vec::new();
    for i in 0..sides {
        let (a, b, c, d) = (corner(i, 0.0), corner(i + 1, 0.0), corner(i, 1.0), corner(i + 1, 1.0));
        triangles.extend([[a, c, b], [b, c, d]]);
        triangles.extend([[corner(0, 0.0), a, b], [corner(0, 1.0), d, c]]);
    }
    mesh(triangles)
}

/// A hall of columns with carved heads and curtains: walls and planks of two triangles each, 100,000 in all.
pub fn hall() -> Mesh {
    let mut all = Mesh::default();
    let still = Affine3A::IDENTITY;
    let (x, y, z) = (Vec3::X * 40.0, Vec3::Y * 12.0, Vec3::Z * 20.0);
    for (at, u, v) in [(Vec3::ZERO, x, z), (y, x, z), (Vec3::ZERO, x, y), (z, x, y), (Vec3::ZERO, z, y), (x, z, y)] {
        add(&mut all, &quad(at, u, v), still);
    }
    for plank in 0..400 {
        add(&mut all, &quad(Vec3::new(0.0, 0.02, plank as f32 * 0.05), x, Vec3::Z * 0.045), still);
    }
    let head = moved(icosphere(3), |p| p * (1.0 + 0.2 * (9.0 * p.x).sin() * (7.0 * p.z).sin() * (5.0 * p.y).cos()));
    for column in 0..28 {
        let at = Vec3::new(2.0 + (column / 2) as f32 * 2.7, 0.0, if column % 2 == 0 { 5.0 } else { 15.0 });
        add(
            &mut all,
            &cylinder(40),
            Affine3A::from_scale_rotation_translation(Vec3::new(0.5, 8.0, 0.5), Quat::IDENTITY, at),
        );
        for height in [0.3, 8.0] {
            let at = at + Vec3::Y * height;
            add(&mut all, &head, Affine3A::from_scale_rotation_translation(Vec3::splat(0.7), Quat::IDENTITY, at));
        }
    }
    for curtain in 0..5 {
        let from = Vec3::new(3.0 + 8.0 * curtain as f32, 3.0, 5.0);
        let fold = |u: f32, v: f32| from + Vec3::new(2.0 * u, 5.0 * v, 0.2 * (40.0 * u + 3.0 * v).sin());
        add(&mut all, &sheet(60, 40, fold), still);
    }
    all
}

/// A small model of 20,000 triangles in the middle of a field of four, with stands around it.
pub fn stadium() -> Mesh {
    let mut all = quad(Vec3::new(-500.0, 0.0, -500.0), Vec3::X * 1000.0, Vec3::Z * 1000.0);
    add(&mut all, &quad(Vec3::new(-500.0, -1.0, -500.0), Vec3::X * 1000.0, Vec3::Z * 1000.0), Affine3A::IDENTITY);
    let stands = sheet(96, 24, |u, v| {
        let (sin, cos) = (TAU * u).sin_cos();
        Vec3::new(cos, 0.0, sin) * (200.0 + 100.0 * v) + Vec3::Y * 60.0 * (24.0 * v).floor() / 24.0
    });
    add(&mut all, &stands, Affine3A::IDENTITY);
    let model = moved(uv_sphere(100, 100), |p| p * (1.0 + 0.1 * (6.0 * p.y).sin() * (5.0 * p.x).cos()) + Vec3::Y);
    add(&mut all, &model, Affine3A::IDENTITY);
    all
}

/// Shafts, bolts and plates: 60,000 triangles, most of them long or in fans.
pub fn machine(random: &mut Random) -> Mesh {
    let mut all = Mesh::default();
    for part in 0..260 {
        let along = [Vec3::X, Vec3::Y, Vec3::Z, random.vec().normalize_or(Vec3::X)][part % 4];
        let thick = 0.02 + 0.2 * random.unit() * random.unit();
        let size = Vec3::new(thick, 0.1 + 1.5 * random.unit() * random.unit(), thick);
        let turn = Quat::from_rotation_arc(Vec3::Y, along);
        let place = Affine3A::from_scale_rotation_translation(size, turn, random.vec());
        add(&mut all, &cylinder(if part % 3 == 0 { 96 } else { 36 }), place);
    }
    for plate in 0..40 {
        let at = Vec3::new(-1.2, -1.2, -1.2 + 0.06 * plate as f32);
        add(&mut all, &quad(at, Vec3::X * 2.4, Vec3::Y * 2.4), Affine3A::IDENTITY);
    }
    all
}

/// A head of hair: 3,000 strands of 20 thin triangles around a ball.
pub fn hair(random: &mut Random) -> Mesh {
    let mut all = icosphere(4);
    for _ in 0..3000 {
        let root = random.vec().normalize_or(Vec3::Y);
        let (side, fall) = (root.cross(Vec3::Y).normalize_or(Vec3::X), 0.5 + random.unit());
        let at = move |u: f32, v: f32| {
            root * (1.0 + 0.5 * v) - Vec3::Y * fall * v * v + side * (0.003 * (u - 0.5) + 0.1 * (5.0 * v).sin())
        };
        add(&mut all, &sheet(1, 10, at), Affine3A::IDENTITY);
    }
    all
}

/// Hills: 130,000 triangles.
pub fn terrain() -> Mesh {
    sheet(256, 256, |u, v| {
        let hill = |k: f32, a: f32| a * (k * u * PI + a).sin() * (k * v * PI).cos();
        Vec3::new(u * 10.0, hill(3.0, 0.8) + hill(11.0, 0.2) + hill(47.0, 0.03), v * 10.0)
    })
}

/// A statue as scanners give them: 82,000 triangles of one size.
pub fn statue() -> Mesh {
    moved(icosphere(6), |p| {
        let wave = |k: f32, a: f32| a * (k * p.x + a).sin() * (k * p.y).sin() * (k * p.z + 1.0).sin();
        let body = p * (1.0 + wave(4.0, 0.4) + wave(13.0, 0.08) + wave(60.0, 0.006));
        body * Vec3::new(0.5, 1.5, 0.4) + Vec3::X * (0.3 * (3.0 * p.y).sin())
    })
}
