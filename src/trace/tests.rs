//! Every level against the scalar reference and brute force, bit for bit.

use super::{Hit, Kernels, PreparedRay, Ray, triangle};
use crate::accel::test_meshes::{Random, bumpy_sphere, degenerate, mesh, needles, soup};
use crate::accel::{Bvh, build_fast, build_sah, build_spatial};
use crate::scene::Mesh;
use crate::simd::Level;
use crate::simd::skip::skipped;
use glam::Vec3;

/// Every kernel set that runs here; says which do not.
pub(super) fn kernels() -> Vec<Kernels> {
    for level in Level::ALL.into_iter().filter(|l| !l.is_available()) {
        skipped(format_args!("level {} (this processor does not have it)", level.name()));
    }
    Level::available().map(Kernels::new).collect()
}

fn brute_force(mesh: &Mesh, ray: &PreparedRay) -> Hit {
    let mut best = Hit::none(ray.tmax);
    for prim in 0..mesh.triangles.len() as u32 {
        if let Some(h) = triangle::intersect(ray, mesh.corners(prim)) {
            let hit = Hit { t: h.t, u: h.u, v: h.v, primitive: prim, object: 9, instance: 4 };
            if hit.is_before(&best) {
                best = hit;
            }
        }
    }
    best
}

/// Random, axis-parallel, aimed at corners, edges and planes, starting on the surface, short, unnormalised.
pub(super) fn rays(random: &mut Random, mesh: &Mesh, count: usize) -> Vec<Ray> {
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
                    ray.direction = Vec3::ZERO;
                    ray.direction[axis] = if random.below(2) == 0 { 1.0 } else { -1.0 };
                    ray.origin = target.with_x(target.x);
                    ray.origin[axis] = org[axis];
                }
                1 => ray.direction[random.below(3)] = -0.0,
                2 => ray.origin = target,
                3 => ray.tmax = 0.9,
                4 => ray.tmin = 1.0,
                5 => ray.direction *= 1e-20,
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
    let mut random = Random::new(Random::seed(11));
    let mut hits = 0;
    for (name, mesh) in degenerate() {
        let count = if mesh.triangles.len() > 10_000 { 40 } else { 800 };
        let rays = rays(&mut random, &mesh, count);
        hits += check(&name, &mesh, &build_sah(&mesh).expect("memory"), &rays, &kernels);
        check(&name, &mesh, &build_fast(&mesh).expect("memory"), &rays, &kernels);
        check(&name, &mesh, &build_spatial(&mesh).expect("memory"), &rays, &kernels);
    }
    assert!(hits > 5000, "the rays are aimed: {hits}");
}

#[test]
fn ordinary_meshes_too() {
    let kernels = kernels();
    let mut random = Random::new(Random::seed(12));
    for mesh in [bumpy_sphere(30, 40), soup(&mut random, 3000, 0.2), needles(&mut random, 3000)] {
        let rays = rays(&mut random, &mesh, 2000);
        assert!(check("sah", &mesh, &build_sah(&mesh).expect("memory"), &rays, &kernels) > 200);
        check("fast", &mesh, &build_fast(&mesh).expect("memory"), &rays, &kernels);
        check("spatial", &mesh, &build_spatial(&mesh).expect("memory"), &rays, &kernels);
    }
}

#[test]
fn no_ray_aimed_at_an_edge_or_corner_leaks_through_a_closed_mesh() {
    let mesh = bumpy_sphere(60, 80);
    let bvh = build_sah(&mesh).expect("memory");
    let kernels = kernels();
    let mut random = Random::new(Random::seed(13));
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
        assert_eq!((best.primitive, best.instance), (0, 5));
        // A later instance does not replace it, an earlier one does, and so does neither twice.
        assert!(!kernels.intersect(&bvh, &ray, 1, 6, &mut best));
        assert!(kernels.intersect(&bvh, &ray, 1, 3, &mut best));
        assert!(!kernels.intersect(&bvh, &ray, 1, 3, &mut best));
        assert_eq!((best.primitive, best.instance), (0, 3));
    }
}

/// Two products that round to the same f32 but differ: the plain difference is 0 and the exact sign is asked of f64. A fused
/// multiply-subtract (or one fused operand) would give one rounding error instead of 0, with its sign depending on
/// which product was rounded: shared edges would then leak.
#[test]
fn edge_functions_are_not_contracted() {
    let mut random = Random::new(Random::seed(17));
    let (mut edge_cases, mut fused_differs) = (0, 0);
    let kernels = kernels();
    for _ in 0..20_000 {
        // A quad split along its diagonal, and a ray through that diagonal: one of the halves must take it, on every level
        // the same one.
        let (a, c) = (random.vec(), random.vec());
        let (b, d) = (a + random.vec(), c + random.vec());
        let on_edge = a + (c - a) * (0.1 + 0.8 * random.unit());
        let org = random.vec() * 3.0;
        let Some(ray) = PreparedRay::new(&Ray::new(org, on_edge - org)) else { continue };
        let sheared = |p: Vec3| {
            let p = p - ray.org;
            let [kx, ky, kz] = ray.axis;
            [p[kx] - ray.shear.x * p[kz], p[ky] - ray.shear.y * p[kz]]
        };
        let (sa, sc) = (sheared(a), sheared(c));
        let plain = sc[0] * sa[1] - sc[1] * sa[0];
        let fused = sc[0].mul_add(sa[1], -(sc[1] * sa[0]));
        edge_cases += usize::from(plain == 0.0);
        fused_differs += usize::from(plain == 0.0 && fused != 0.0);

        let mesh = mesh([[a, b, c], [a, c, d]]);
        let bvh = build_sah(&mesh).expect("memory");
        let expected = brute_force(&mesh, &ray);
        // The exact sides, from f64 on the sheared corners, where products of two f32 are exact.
        let exact = (0..2).any(|prim| {
            let [p, q, r] = mesh.corners(prim).map(|corner| sheared(corner).map(f64::from));
            let side = |s: [f64; 2], t: [f64; 2]| s[0] * t[1] - s[1] * t[0];
            let (u, v, w) = (side(r, q), side(p, r), side(q, p));
            let in_front = expected.t >= 0.0;
            in_front && u + v + w != 0.0 && ((u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0))
        });
        assert_eq!(!expected.is_none(), exact, "{ray:?} {mesh:?}");
        for kernels in &kernels {
            let mut hit = Hit::none(ray.tmax);
            kernels.intersect(&bvh, &ray, 9, 4, &mut hit);
            assert_eq!(hit, expected, "{:?}: {ray:?} {mesh:?}", kernels.level());
        }
    }
    assert!(edge_cases > 1000 && fused_differs > 500, "the rays are aimed: {edge_cases} {fused_differs}");
}
