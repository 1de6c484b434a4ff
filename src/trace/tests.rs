//! Every level against the scalar reference and brute force, bit for bit.

use super::{Hit, Kernels, PreparedRay, Ray, triangle};
use crate::accel::test_meshes::{Random, bumpy_sphere, degenerate, mesh, soup};
use crate::accel::{Bvh, build_fast, build_sah};
use crate::scene::Mesh;
use crate::simd::Level;
use glam::Vec3;

/// Every kernel set that runs here; says which do not.
fn kernels() -> Vec<Kernels> {
    for level in Level::ALL.into_iter().filter(|l| !l.is_available()) {
        eprintln!("SKIPPED: level {} (this processor does not have it)", level.name());
    }
    Level::available().map(Kernels::new).collect()
}

fn brute_force(mesh: &Mesh, ray: &PreparedRay) -> Hit {
    let mut best = Hit::none(ray.tmax);
    for prim in 0..mesh.triangles.len() as u32 {
        if let Some(h) = triangle::intersect(ray, mesh.corners(prim)) {
            let hit = Hit { t: h.t, u: h.u, v: h.v, prim, object: 9, instance: 4 };
            if hit.is_before(&best) {
                best = hit;
            }
        }
    }
    best
}

/// Random, axis-parallel, aimed at corners, edges and planes, starting on the surface, short, unnormalised.
fn rays(random: &mut Random, mesh: &Mesh, count: usize) -> Vec<Ray> {
    let scale =
        mesh.positions.iter().filter(|p| p.is_finite()).fold(0.0f32, |m, p| m.max(p.abs().max_element())).min(1e18);
    let scale = if scale > 0.0 { scale } else { 1.0 };
    (0..count)
        .map(|i| {
            let org = random.vec() * (2.0 * scale);
            let target = if mesh.triangles.is_empty() {
                random.vec() * scale
            } else {
                let [a, b, c] = mesh.corners(random.below(mesh.triangles.len()) as u32);
                match random.below(4) {
                    0 => a,
                    1 => (b + c) * 0.5,
                    2 => a + (b - a) * 0.3 + (c - a) * 0.3,
                    _ => random.vec() * scale,
                }
            };
            let mut ray = Ray::new(org, target - org);
            match i % 8 {
                0 => {
                    // Along an axis, through the target.
                    let axis = random.below(3);
                    ray.dir = Vec3::ZERO;
                    ray.dir[axis] = if random.below(2) == 0 { 1.0 } else { -1.0 };
                    ray.org = target.with_x(target.x);
                    ray.org[axis] = org[axis];
                }
                1 => ray.dir[random.below(3)] = -0.0,
                2 => ray.org = target,
                3 => ray.tmax = 0.9,
                4 => ray.tmin = 1.0,
                5 => ray.dir *= 1e-20,
                _ => {}
            }
            ray
        })
        .collect()
}

fn check(name: &str, mesh: &Mesh, bvh: &Bvh, rays: &[Ray], kernels: &[Kernels]) -> usize {
    let mut hits = 0;
    for (i, ray) in rays.iter().enumerate() {
        let Some(prepared) = PreparedRay::new(ray) else { continue };
        let expected = brute_force(mesh, &prepared);
        hits += usize::from(!expected.is_none());
        for kernels in kernels {
            let mut hit = Hit::none(ray.tmax);
            let found = kernels.intersect(bvh, &prepared, 9, 4, &mut hit);
            let same = hit == expected && hit.t.to_bits() == expected.t.to_bits() && found != hit.is_none();
            assert!(same, "{name}, {:?}, ray {i} {ray:?}: {hit:?}, expected {expected:?}", kernels.level());
            assert_eq!(
                kernels.occluded(bvh, &prepared),
                !expected.is_none(),
                "{name}, {:?}, ray {i} {ray:?}",
                kernels.level()
            );
        }
    }
    hits
}

#[test]
fn every_tree_and_level_finds_the_hit_of_brute_force() {
    let kernels = kernels();
    let mut random = Random::new(11);
    let mut hits = 0;
    for (name, mesh) in degenerate() {
        let count = if mesh.triangles.len() > 10_000 { 40 } else { 800 };
        let rays = rays(&mut random, &mesh, count);
        hits += check(&name, &mesh, &build_sah(&mesh).expect("memory"), &rays, &kernels);
        check(&name, &mesh, &build_fast(&mesh).expect("memory"), &rays, &kernels);
    }
    assert!(hits > 5000, "the rays are aimed: {hits}");
}

#[test]
fn ordinary_meshes_too() {
    let kernels = kernels();
    let mut random = Random::new(12);
    for mesh in [bumpy_sphere(30, 40), soup(&mut random, 3000, 0.2)] {
        let rays = rays(&mut random, &mesh, 2000);
        assert!(check("sah", &mesh, &build_sah(&mesh).expect("memory"), &rays, &kernels) > 500);
        check("fast", &mesh, &build_fast(&mesh).expect("memory"), &rays, &kernels);
    }
}

#[test]
fn no_ray_aimed_at_an_edge_or_corner_leaks_through_a_closed_mesh() {
    let mesh = bumpy_sphere(60, 80);
    let bvh = build_sah(&mesh).expect("memory");
    let kernels = kernels();
    let mut random = Random::new(13);
    for i in 0..40_000 {
        let [a, b, _] = mesh.corners(random.below(mesh.triangles.len()) as u32);
        let target = if i % 3 == 0 { a } else { a + (b - a) * random.unit() };
        let org = random.vec() * 0.3;
        let ray = Ray::new(org, target - org);
        let prepared = PreparedRay::new(&ray).expect("a usable ray");
        for kernels in &kernels {
            let mut hit = Hit::none(ray.tmax);
            assert!(kernels.intersect(&bvh, &prepared, 0, 0, &mut hit), "{:?}: {ray:?} leaks", kernels.level());
        }
    }
}

#[test]
fn equal_distances_go_to_the_lowest_number() {
    let tri = [Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, -1.0, 0.0), Vec3::new(0.0, 1.0, 0.0)];
    let mesh = mesh((0..1000).map(|_| tri));
    let bvh = build_sah(&mesh).expect("memory");
    let ray = PreparedRay::new(&Ray::new(Vec3::Z, Vec3::NEG_Z)).expect("a usable ray");
    for kernels in kernels() {
        let mut best = Hit::none(f32::INFINITY);
        assert!(kernels.intersect(&bvh, &ray, 1, 5, &mut best));
        assert_eq!((best.prim, best.instance), (0, 5));
        // A later instance does not replace it, an earlier one does, and so does neither twice.
        assert!(!kernels.intersect(&bvh, &ray, 1, 6, &mut best));
        assert!(kernels.intersect(&bvh, &ray, 1, 3, &mut best));
        assert!(!kernels.intersect(&bvh, &ray, 1, 3, &mut best));
        assert_eq!((best.prim, best.instance), (0, 3));
    }
}
