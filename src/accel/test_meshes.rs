//! Meshes that builders and kernels must survive, for the unit tests of `accel` and `trace`.

use crate::scene::Mesh;
use glam::Vec3;

#[path = "../../tests/common/random.rs"]
mod random;
#[path = "../../tests/common/soup.rs"]
mod soup;

pub use random::Random;
pub use soup::{mesh, soup};

/// A closed, indexed sphere with waves: `2 * around * (rings - 1)` triangles.
pub fn bumpy_sphere(rings: u32, around: u32) -> Mesh {
    let mut positions = vec![Vec3::Y, Vec3::NEG_Y];
    for ring in 1..rings {
        let theta = std::f32::consts::PI * ring as f32 / rings as f32;
        for i in 0..around {
            let phi = std::f32::consts::TAU * i as f32 / around as f32;
            let r =
                1.0 + 0.1 * (7.0 * theta).sin() * (9.0 * phi).cos() + 0.01 * (60.0 * theta).sin() * (71.0 * phi).cos();
            positions.push(Vec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin()) * r);
        }
    }
    let at = |ring: u32, i: u32| 2 + (ring - 1) * around + i % around;
    let mut triangles = Vec::new();
    for i in 0..around {
        triangles.push([0, at(1, i + 1), at(1, i)]);
        for ring in 1..rings - 1 {
            let [a, b, c, d] = [at(ring, i), at(ring, i + 1), at(ring + 1, i), at(ring + 1, i + 1)];
            triangles.extend([[a, b, d], [a, d, c]]);
        }
        triangles.push([1, at(rings - 1, i), at(rings - 1, i + 1)]);
    }
    Mesh { positions, triangles, ..Mesh::default() }
}

/// Long thin triangles in all directions, each along another random chord of the cube `[-1, 1]³`.
pub fn needles(random: &mut Random, count: usize) -> Mesh {
    mesh((0..count).map(|_| {
        let at = random.vec();
        [at, at + random.vec() * 0.5, at + random.vec() * 0.003]
    }))
}

/// Every degenerate mesh, with a name for messages.
pub fn degenerate() -> Vec<(String, Mesh)> {
    let mut random = Random::new(Random::seed(7));
    let mut all = Vec::new();
    for count in [0, 1, 2, 3, 4, 5, 7, 8, 9, 15, 16, 17, 33, 100] {
        all.push((format!("{count} triangles"), soup(&mut random, count, 0.3)));
    }
    let tri = [Vec3::new(-0.5, -0.5, 0.1), Vec3::new(0.6, -0.4, 0.0), Vec3::new(0.0, 0.7, -0.1)];
    all.push(("all points equal".into(), mesh((0..50).map(|_| [Vec3::splat(0.25); 3]))));
    all.push(("100000 identical".into(), mesh((0..100_000).map(|_| tri))));
    let mut with_garbage = soup(&mut random, 300, 0.3);
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, 1e30, -1e19] {
        for _ in 0..10 {
            let at = random.below(with_garbage.positions.len());
            let axis = random.below(3);
            with_garbage.positions[at][axis] = value;
        }
    }
    all.push(("NaN, Inf and huge".into(), with_garbage));
    all.push(("only NaN".into(), mesh((0..20).map(|_| [Vec3::NAN; 3]))));
    for scale in [1e18, 1e-20, 1e-38, 1e-40, 1e-44] {
        let mut scaled = soup(&mut random, 200, 0.3);
        scaled.positions.iter_mut().for_each(|p| *p *= scale);
        all.push((format!("scaled by {scale:e}"), scaled));
    }
    for axis in 0..3 {
        let mut flat = soup(&mut random, 200, 0.3);
        flat.positions.iter_mut().for_each(|p| p[axis] = 0.5);
        all.push((format!("flat on axis {axis}"), flat));
        let mut line = soup(&mut random, 200, 0.3);
        line.positions.iter_mut().for_each(|p| *p = Vec3::splat(0.5).with_y(p.y));
        all.push((format!("collinear {axis}"), line));
    }
    all.push((
        "slivers".into(),
        mesh((0..200).map(|_| {
            let (a, d) = (random.vec(), random.vec());
            [a, a + d, a + d * 0.5 + random.vec() * 1e-6]
        })),
    ));
    let mut uneven = soup(&mut random, 500, 1e-3);
    uneven.positions.iter_mut().for_each(|p| *p *= 1e-3);
    uneven.positions[0] = Vec3::splat(1e18);
    uneven.positions[31] = Vec3::splat(-1e18);
    all.push(("huge beside tiny".into(), uneven));
    // Centres at 1, 1/2, 1/4, …: every split peels off one.
    let halves = (0..120).map(|i| tri.map(|p| p * 0.5f32.powi(i) * 0.1 + Vec3::X * 0.5f32.powi(i)));
    all.push(("geometric sequence".into(), mesh(halves)));
    all.push(("negative zeros".into(), mesh((0..9).map(|_| tri.map(|p| p.with_z(-0.0))))));
    all
}
