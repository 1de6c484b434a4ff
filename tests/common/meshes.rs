//! Meshes for engine tests: closed surfaces, soups, and the geometry list of the reliability notes (R5).

use super::random::Random;
use glam::Vec3;
use openrt::scene::Mesh;
use std::collections::HashMap;

#[path = "soup.rs"]
mod soup;

pub use soup::{mesh, soup};

/// A closed sphere of radius 1: `20 * 4^subdivisions` triangles that share their vertices.
pub fn icosphere(subdivisions: u32) -> Mesh {
    let g = (1.0 + 5.0f32.sqrt()) / 2.0;
    let mut positions: Vec<Vec3> = Vec::new();
    for (a, b) in [(-1.0, g), (1.0, g), (-1.0, -g), (1.0, -g)] {
        positions.push(Vec3::new(a, b, 0.0).normalize());
        positions.push(Vec3::new(0.0, a, b).normalize());
        positions.push(Vec3::new(b, 0.0, a).normalize());
    }
    // The faces are the triples at mutual distance of an edge, oriented outwards.
    let edge = positions.iter().skip(1).map(|p| p.distance(positions[0])).fold(f32::MAX, f32::min) * 1.01;
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for a in 0..12u32 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                let [p, q, r] = [a, b, c].map(|i| positions[i as usize]);
                if p.distance(q) < edge && q.distance(r) < edge && r.distance(p) < edge {
                    let outwards = (q - p).cross(r - p).dot(p) > 0.0;
                    triangles.push(if outwards { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
    assert_eq!(triangles.len(), 20);
    for _ in 0..subdivisions {
        let mut middle: HashMap<(u32, u32), u32> = HashMap::new();
        let mut finer = Vec::with_capacity(4 * triangles.len());
        for [a, b, c] in triangles {
            let mut between = |i: u32, j: u32| {
                *middle.entry((i.min(j), i.max(j))).or_insert_with(|| {
                    positions.push((positions[i as usize] + positions[j as usize]).normalize());
                    positions.len() as u32 - 1
                })
            };
            let (ab, bc, ca) = (between(a, b), between(b, c), between(c, a));
            finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    Mesh { positions, triangles, ..Mesh::default() }
}

/// A closed sphere of radius 1 with fans at the poles: `2 * around * (rings - 1)` triangles.
pub fn uv_sphere(rings: u32, around: u32) -> Mesh {
    let mut positions = vec![Vec3::Y, Vec3::NEG_Y];
    for ring in 1..rings {
        let theta = std::f32::consts::PI * ring as f32 / rings as f32;
        for i in 0..around {
            let phi = std::f32::consts::TAU * i as f32 / around as f32;
            positions.push(Vec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin()));
        }
    }
    let at = |ring: u32, i: u32| 2 + (ring - 1) * around + i % around;
    let mut triangles = Vec::new();
    for i in 0..around {
        triangles.push([0, at(1, i + 1), at(1, i)]);
        triangles.push([1, at(rings - 1, i), at(rings - 1, i + 1)]);
        for ring in 1..rings - 1 {
            triangles.push([at(ring, i), at(ring, i + 1), at(ring + 1, i)]);
            triangles.push([at(ring, i + 1), at(ring + 1, i + 1), at(ring + 1, i)]);
        }
    }
    Mesh { positions, triangles, ..Mesh::default() }
}

/// The cube `[-1, 1]³` of 12 triangles.
pub fn cube() -> Mesh {
    let corner = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 2.0 - 1.0;
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = faces.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    Mesh { positions: (0..8).map(corner).collect(), triangles, ..Mesh::default() }
}

/// The mesh with every position changed.
pub fn moved(mut mesh: Mesh, f: impl Fn(Vec3) -> Vec3) -> Mesh {
    for p in &mut mesh.positions {
        *p = f(*p);
    }
    mesh
}

/// Names and meshes of everything a builder and a kernel must survive.
pub fn degenerate(random: &mut Random) -> Vec<(String, Mesh)> {
    let tri = [Vec3::new(-1.0, -1.0, 0.5), Vec3::new(1.0, -1.0, 0.5), Vec3::new(0.0, 1.0, 0.5)];
    let mut list: Vec<(String, Mesh)> = Vec::new();
    let mut add = |name: &str, m: Mesh| list.push((name.to_owned(), m));
    for count in [0, 1, 2, 3, 4, 5, 7, 8, 9, 15, 16, 17, 31, 32, 33, 63, 64, 65] {
        add(&format!("{count} triangles"), soup(random, count, 0.5));
    }
    for (name, bad) in [("NaN", f32::NAN), ("inf", f32::INFINITY), ("-inf", f32::NEG_INFINITY), ("MAX", f32::MAX)] {
        let mut mixed = soup(random, 60, 0.5);
        for (i, p) in mixed.positions.iter_mut().enumerate() {
            if i % 7 == 0 {
                p[i % 3] = bad;
            }
        }
        add(&format!("some {name}"), mixed);
        add(&format!("only {name}"), mesh(vec![[Vec3::splat(bad); 3]; 10]));
    }
    for scale in [1e-40, 1e-20, 1e-10, 1e10, 1e18] {
        add(&format!("scaled by {scale:e}"), moved(soup(random, 200, 0.4), |p| p * scale));
    }
    add("beyond the limit", moved(soup(random, 20, 0.4), |p| p * 1e30));
    add("huge and tiny", {
        let mut both = soup(random, 40, 0.4);
        for (i, p) in both.positions.iter_mut().enumerate() {
            *p *= if i / 3 % 2 == 0 { 1e18 } else { 1e-3 };
        }
        both
    });
    add("minus zero", mesh([[Vec3::new(-0.0, -1.0, -0.0), Vec3::new(1.0, 1.0, -0.0), Vec3::new(-1.0, 1.0, 0.0)]]));
    let p = Vec3::new(0.3, 0.2, 0.1);
    add("no area", mesh([[p, p, p], [p, p, Vec3::ONE], [p, p * 2.0, p * 3.0], tri]));
    add(
        "slivers",
        mesh((0..50).map(|_| {
            let a = random.vec();
            [a, a + random.vec(), a + random.vec() * 1e-6]
        })),
    );
    add("one point", mesh(vec![[p; 3]; 500]));
    add("one plane", moved(soup(random, 200, 0.3), |p| p.with_z(0.25)));
    add("one axis", moved(soup(random, 50, 0.3), |p| p * Vec3::X));
    add("10,000 duplicates", mesh(vec![tri; 10_000]));
    add("pairs of duplicates", {
        let once = soup(random, 100, 0.4);
        mesh((0..200u32).map(|i| once.corners(i / 2)))
    });
    add("grid of equal boxes", {
        mesh((0..1000).map(|i| {
            let at = Vec3::new((i % 10) as f32, (i / 10 % 10) as f32, (i / 100) as f32) * 0.2 - 1.0;
            tri.map(|c| at + c * 0.1)
        }))
    });
    add("axis-aligned cube", cube());
    list
}
