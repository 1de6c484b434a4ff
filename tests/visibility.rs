//! What is particular to the visibility field: subfields that come and go with the rays, triangles that begin and cease to move.
//!
//! That it answers as all others do is shown with them (`accel_conformance`, `strategies`, `watertight`); here many rays go through few subfields, so that the fine
//! ones are made, at rays that meet the borders of tiles.

#[allow(dead_code, reason = "shared with other tests")]
#[path = "common/meshes.rs"]
mod meshes;
#[path = "common/random.rs"]
mod random;
#[path = "common/rays.rs"]
mod rays;
#[allow(dead_code, reason = "shared with other tests")]
#[path = "common/world.rs"]
mod world;

use glam::{Affine3A, Vec3};
use openrt::accel::{Directions, FieldSize, Structure, TwoLevel, VisibilityField};
use openrt::scene::{Command, Mesh, Motion, Strategy, TopLevelKind};
use openrt::simd::Level;
use openrt::threads::Pool;
use openrt::trace::{Ray, Tracer};
use random::Random;
use rayon::prelude::*;
use rays::{bits, is_rescaled, rays};
use world::World;

fn field(world: &TwoLevel) -> &VisibilityField {
    match world.objects()[0].structure() {
        Structure::Field(field) => field,
        other => panic!("{other:?} is no field"),
    }
}

fn built(world: &World, pool: &Pool, strategy: Strategy) -> TwoLevel {
    world.build(pool, strategy, Level::detect(), TopLevelKind::Bvh)
}

/// A floor and walls of two triangles each, along the axes and not, and a swarm of small triangles between them.
fn room(random: &mut Random, count: usize) -> Mesh {
    let small = |_| {
        let p = random.vec();
        [p, p + random.vec() * 0.04, p + random.vec() * 0.04]
    };
    let mut triangles: Vec<[Vec3; 3]> = (0..count).map(small).collect();
    let [x, y, z] = [Vec3::X, Vec3::Y, Vec3::Z];
    for (at, u, v) in [(-y, x, z), (-x, y, z), (z, x, y), (Vec3::ZERO, x + y, z), (Vec3::splat(0.3), x * 0.01, y + z)] {
        triangles.push([at - u - v, at + u - v, at + u + v]);
        triangles.push([at - u - v, at + u + v, at - u + v]);
    }
    meshes::mesh(triangles)
}

/// All rays by all threads, against the tree.
fn check(pool: &Pool, field: &TwoLevel, tree: &TwoLevel, rays: &[Ray], what: &str) -> usize {
    let (field, tree) = (Tracer::new(field), Tracer::new(tree));
    let check = |ray: &Ray| {
        let (found, expected) = (field.intersect(ray), tree.intersect(ray));
        assert_eq!(bits(&found), bits(&expected), "{found:?} is not {expected:?}: {what}, {ray:?}");
        assert_eq!(field.occluded(ray), expected.is_some(), "occluded, {what}, {ray:?}");
        usize::from(expected.is_some())
    };
    pool.install(|| rays.par_iter().with_max_len(64).map(check).sum())
}

#[test]
fn fine_subfields_are_made_for_many_rays_and_answer_alike() {
    let seed = Random::seed(81);
    let mut random = Random::new(seed);
    let pool = Pool::new(Some(3)).expect("threads");
    for (name, mesh) in [
        ("room", room(&mut random, 4000)),
        ("sphere", meshes::uv_sphere(40, 60)),
        (
            "soup of all sizes",
            meshes::mesh((0..3000).map(|i| {
                let (p, size) = (random.vec(), 0.5f32.powi(i % 9));
                [p, p + random.vec() * size, p + random.vec() * size]
            })),
        ),
        ("flat", meshes::moved(meshes::soup(&mut random, 2000, 0.05), |p| p.with_y(0.25))),
        ("far out", meshes::moved(room(&mut random, 2000), |p| p * 0.1 + Vec3::new(3000.0, -500.0, 70.0))),
    ] {
        let triangles: Vec<[Vec3; 3]> = (0..mesh.triangles.len() as u32).map(|p| mesh.corners(p)).collect();
        let (lo, hi) = triangles
            .iter()
            .flatten()
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(lo, hi), p| (lo.min(*p), hi.max(*p)));
        let world = World::plain(mesh);
        let (fields, trees) = (built(&world, &pool, Strategy::VisibilityField), built(&world, &pool, Strategy::Sah));
        let mut batch = rays(&mut random, &triangles, 3000);
        // A bundle, which the same few directions serve, and rays through the room between two of its points.
        let lines = Directions::of_level(4).expect("memory").lines();
        for i in 0..30_000 {
            let at = |random: &mut Random| lo + (hi - lo) * (random.vec() * 0.6 + 0.5);
            let from = at(&mut random);
            let to = match i % 4 {
                0 => at(&mut random),
                1 => from + lines[random.below(lines.len())] * (hi - lo).length() * [1.0, -1.0][i / 4 % 2],
                2 => {
                    from + (Vec3::new(0.3, 0.5, 1.0) + random.vec() * 0.02)
                        * (hi - lo).length()
                        * [1.0, -1.0][i / 4 % 2]
                }
                _ => triangles[random.below(triangles.len())][i % 3],
            };
            let tmax = if i % 5 == 0 { random.unit() * 2.0 } else { f32::INFINITY };
            batch.push(Ray { tmax, tmin: if i % 7 == 0 { random.unit() } else { 0.0 }, ..Ray::new(from, to - from) });
        }
        let hits = check(&pool, &fields, &trees, &batch, &format!("seed {seed}, {name}"));
        assert!(hits > 2000, "{name}: {hits} hits");
        field(&fields).validate(&world.scene.objects[&1].mesh).unwrap_or_else(|e| panic!("seed {seed}, {name}: {e}"));
        let FieldSize { resting: (subfields, refs), moving, movers } = field(&fields).size();
        assert!(subfields > Directions::count_on(1), "{name}: {subfields} subfields of {refs} references");
        assert_eq!((moving, movers), ((0, 0), 0), "{name}");
    }
}

#[test]
fn an_update_costs_what_moves_and_rest_makes_resting_triangles() {
    let seed = Random::seed(82);
    let mut random = Random::new(seed);
    let pool = Pool::new(Some(2)).expect("threads");
    let count = 3000;
    let mut world = World::plain(room(&mut random, count));
    world.scene.apply(Command::SetMotion { name: 1, motion: Motion::Unstructured });
    let mut fields = built(&world, &pool, Strategy::VisibilityField);
    let (mut most_movers, mut redrawn) = (0, 0);
    for frame in 0..120u32 {
        // Ten triangles of a hundred, elsewhere every twenty frames.
        let vertices: Vec<u32> = (0..10)
            .flat_map(|i| {
                let t = frame / 20 * 100 + (frame + i) % 100;
                [3 * t, 3 * t + 1, 3 * t + 2]
            })
            .collect();
        let by = random.vec() * 0.1;
        let positions = vertices.iter().map(|&v| world.scene.objects[&1].mesh.positions[v as usize] + by).collect();
        world.scene.apply(Command::MovePositions { name: 1, vertices, positions });
        let stats = pool.install(|| fields.update(&world.scene, &world.instances));
        assert_eq!((stats.objects_built, stats.objects_refitted, stats.nodes_updated), (0, 1, 10), "frame {frame}");
        let mesh = &world.scene.objects[&1].mesh;
        let triangles: Vec<[Vec3; 3]> = (0..mesh.triangles.len() as u32).map(|p| mesh.corners(p)).collect();
        let trees = built(&world, &pool, Strategy::FastBuild);
        check(&pool, &fields, &trees, &rays(&mut random, &triangles, 200), &format!("seed {seed}, frame {frame}"));
        field(&fields).validate(mesh).unwrap_or_else(|e| panic!("seed {seed}, frame {frame}: {e}"));
        let movers = field(&fields).size().movers;
        let (_, drawn) = fields.touched();
        // Ordered subfields are drawn at first, and when some have come to rest.
        redrawn += usize::from(drawn > 200 * movers as u64);
        most_movers = most_movers.max(movers);
    }
    assert!(redrawn < 40, "{redrawn} times of 120");
    assert!((100..600).contains(&most_movers), "{most_movers} at a time were moving ones");
    // All at once, and then for long none but ten.
    let positions = world.scene.objects[&1].mesh.positions.iter().map(|p| *p * 1.01).collect();
    world.scene.apply(Command::UpdatePositions { name: 1, first: 0, positions });
    pool.install(|| fields.update(&world.scene, &world.instances));
    assert!(field(&fields).size().movers >= count);
    for frame in 0..8 {
        let positions = vec![random.vec(); 30];
        world.scene.apply(Command::UpdatePositions { name: 1, first: 0, positions });
        pool.install(|| fields.update(&world.scene, &world.instances));
        let triangles = [world.scene.objects[&1].mesh.corners(5), world.scene.objects[&1].mesh.corners(500)];
        for ray in rays(&mut random, &triangles, 60).iter().filter(|ray| !is_rescaled(ray)) {
            let hit = Tracer::new(&fields).intersect(ray);
            assert_eq!(bits(&hit), bits(&world.brute_force(&fields, ray)), "seed {seed}, frame {frame}, {ray:?}");
        }
    }
    assert_eq!(field(&fields).size().movers, 10, "the others rest");
}

/// Rays from so far away that their rounding spans tiles.
#[test]
fn rays_from_far_out_are_right() {
    let seed = Random::seed(83);
    let mut random = Random::new(seed);
    let pool = Pool::new(Some(2)).expect("threads");
    let world = World::new(vec![meshes::icosphere(3)], vec![(1, Affine3A::IDENTITY)]);
    let (fields, trees) = (built(&world, &pool, Strategy::VisibilityField), built(&world, &pool, Strategy::Sah));
    let mesh = &world.scene.objects[&1].mesh;
    let rays: Vec<Ray> = (0..6000)
        .map(|i| {
            let target = mesh.positions[random.below(mesh.positions.len())];
            let mut out = random.vec() * 10f32.powi(i % 9);
            if i % 3 == 0 {
                out = out.with_x(0.0);
            }
            Ray::new(target + out, -out)
        })
        .collect();
    let hits = check(&pool, &fields, &trees, &rays, &format!("seed {seed}"));
    assert!(hits > 2000, "{hits} hits");
}
