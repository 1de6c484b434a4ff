//! Objects built with spatial splits are hit as without: not a bit differs, for millions of rays of the kinds that could tell.
//!
//! `accel/spatial.rs` says why. Here rays graze the planes of triangles at every angle down to rounding, run along axes and in sides of boxes, through corners
//! and edges, and where a triangle was cut, from near and from far, in meshes of needles, of large triangles among small ones, and of many in one plane.

#[path = "common/meshes.rs"]
#[allow(dead_code, reason = "shared with other tests")]
mod meshes;
#[path = "common/random.rs"]
mod random;
#[path = "common/world.rs"]
#[allow(dead_code, reason = "shared with other tests")]
mod world;

use glam::{Affine3A, Vec3};
use openrt::accel::{Structure, TwoLevel, triangle_bounds};
use openrt::scene::{Command, Mesh, Motion, Strategy, TopLevelKind};
use openrt::simd::Level;
use openrt::threads::Pool;
use openrt::trace::{Hit, Ray, Tracer};
use random::Random;
use world::World;

/// One static object.
fn still(mesh: Mesh, place: Affine3A) -> World {
    let mut world = World::new(vec![mesh], vec![(1, place)]);
    world.scene.apply(Command::SetMotion { name: 1, motion: Motion::Static });
    world
}

fn built(world: &mut World, pool: &Pool, level: Level, splits: bool) -> TwoLevel {
    world.scene.apply(Command::SetSpatialSplits { name: 1, wanted: splits });
    let built = world.build(pool, Strategy::Sah, level, TopLevelKind::Bvh);
    let Structure::Bvh(bvh) = built.objects()[0].structure() else { panic!("no tree") };
    assert_eq!(bvh.holds_parts(), splits);
    built
}

/// Long thin triangles, half of them along the same few directions.
fn needles(random: &mut Random, count: usize) -> Mesh {
    meshes::mesh((0..count).map(|i| {
        let at = random.vec();
        let along = if i % 2 == 0 { random.vec() } else { Vec3::new(0.6, 0.5, [-0.4, 0.3][i / 2 % 2]) };
        [at, at + along, at + random.vec() * 10f32.powf(-2.0 - 4.0 * random.unit())]
    }))
}

/// Walls that reach through everything, and clutter.
fn rooms(random: &mut Random, count: usize) -> Mesh {
    meshes::mesh((0..count).map(|i| {
        let at = random.vec();
        let size = if i % 10 == 0 { 3.0 } else { 0.05 };
        let (mut b, mut c) = (at + random.vec() * size, at + random.vec() * size);
        if i % 20 == 0 {
            let axis = random.below(3);
            (b[axis], c[axis]) = (at[axis], at[axis]);
        }
        [at, b, c]
    }))
}

/// Overlapping triangles in a few planes: equal distances everywhere.
fn sheets(random: &mut Random, count: usize) -> Mesh {
    let planes: Vec<[Vec3; 3]> = (0..4).map(|_| [random.vec() * 0.3, random.vec(), random.vec()]).collect();
    meshes::mesh((0..count).map(|i| {
        let [at, x, y] = planes[i % 4];
        let mut point = || at + x * (random.unit() * 2.0 - 1.0) + y * (random.unit() * 2.0 - 1.0);
        if i < 8 { planes[i % 4].map(|p| at + p) } else { [point(), point(), point()] }
    }))
}

/// Aimed at a point of some triangle, from a direction that grazes its plane.
fn ray(random: &mut Random, mesh: &Mesh) -> Ray {
    let [a, b, c] = mesh.corners(random.below(mesh.triangles.len()) as u32);
    let (mut u, mut v) = (random.unit(), random.unit());
    if u + v > 1.0 {
        (u, v) = (1.0 - u, 1.0 - v);
    }
    match random.below(8) {
        0 => (u, v) = (0.0, 0.0),
        1 => u = 0.0,
        2 => v = 1.0 - u,
        _ => {}
    }
    let target = a + (b - a) * u + (c - a) * v;
    let normal = (b - a).cross(c - a).normalize_or(Vec3::X);
    let within = ((b - a) * (random.unit() * 2.0 - 1.0) + (c - a) * (random.unit() * 2.0 - 1.0)).normalize_or(Vec3::Y);
    let graze = 10f32.powf(-8.0 * random.unit());
    let mut dir = (within + normal * graze) * 10f32.powf(2.0 * random.unit() - 1.0);
    match random.below(10) {
        0 => {
            let axis = random.below(3);
            dir = Vec3::ZERO;
            dir[axis] = if random.below(2) == 0 { 1.0 } else { -1.0 };
        }
        1 => dir[random.below(3)] = 0.0,
        2 => dir = random.vec(),
        _ => {}
    }
    let far = 10f32.powf(6.0 * random.unit() - 3.0);
    let mut ray = Ray::new(target - dir * far, dir);
    match random.below(12) {
        0 => ray.tmax = far * (0.5 + random.unit()),
        1 => ray.tmin = far * (0.5 + random.unit()),
        _ => {}
    }
    ray
}

/// Where edges of cut triangles pass from one leaf to another: the point, the triangle, and the axis of the plane.
fn cuts(built: &TwoLevel, mesh: &Mesh) -> Vec<(Vec3, u32, usize)> {
    let Structure::Bvh(bvh) = built.objects()[0].structure() else { panic!("no tree") };
    let mut all = Vec::new();
    for node in bvh.nodes() {
        for lane in (0..node.child_count()).filter(|&lane| node.children[lane].is_leaf()) {
            let part = node.child_bounds(lane);
            for prim in bvh.blocks()[node.children[lane].blocks()].iter().flat_map(|block| block.prims) {
                let [a, b, c] = mesh.corners(prim);
                let whole = triangle_bounds([a, b, c]);
                let pad = whole.extent().max_element() / 8192.0;
                for axis in 0..3 {
                    for plane in [part.lo[axis] + pad, part.hi[axis] - pad] {
                        for (p, q) in [(a, b), (b, c), (c, a)] {
                            if (p[axis] < plane) != (q[axis] < plane) {
                                let at = p + (q - p) * ((plane - p[axis]) / (q[axis] - p[axis]));
                                all.push((at, prim, axis));
                            }
                        }
                    }
                }
            }
        }
    }
    all
}

/// Aimed at such a place, along the triangle or across the corner between two boxes, or nearly.
fn ray_at_cut(random: &mut Random, mesh: &Mesh, (at, prim, axis): (Vec3, u32, usize)) -> Ray {
    let [a, b, c] = mesh.corners(prim);
    let normal = (b - a).cross(c - a).normalize_or(Vec3::X);
    let mut dir = match random.below(4) {
        0 => random.vec(),
        1 => normal + random.vec() * 1e-3,
        2 => (b - a).cross(random.vec()),
        _ => {
            let mut across = b - a;
            across[axis] = -across[axis];
            across + random.vec() * 0.05
        }
    };
    if random.below(3) == 0 {
        dir -= normal * dir.dot(normal) * (1.0 - 10f32.powf(-6.0 * random.unit()));
    }
    let inward = (a + b + c - at * 3.0) * if random.below(2) == 0 { 0.0 } else { 10f32.powf(-7.0 * random.unit()) };
    let target = at + inward;
    Ray::new(target - dir * 10f32.powf(7.0 * random.unit() - 5.0), dir)
}

fn bits(hit: &Option<Hit>) -> Option<[u32; 6]> {
    hit.map(|h| [h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.primitive, h.object, h.instance])
}

#[test]
fn no_bit_of_any_hit_differs() {
    let seed = Random::seed(41);
    let mut random = Random::new(seed);
    let pool = Pool::new(Some(2)).expect("two threads");
    let scenes: [(&str, Mesh); 6] = [
        ("needles", needles(&mut random, 3000)),
        ("rooms", rooms(&mut random, 3000)),
        ("sheets", sheets(&mut random, 400)),
        ("far away", meshes::moved(rooms(&mut random, 1000), |p| p + Vec3::new(300.0, -2000.0, 50.0))),
        ("tiny", meshes::moved(needles(&mut random, 1000), |p| p * 1e-12)),
        ("fans", meshes::uv_sphere(5, 600)),
    ];
    let mut hits = 0;
    for (name, mesh) in scenes {
        let mut world = still(mesh.clone(), Affine3A::IDENTITY);
        let cuts = cuts(&built(&mut world, &pool, Level::detect(), true), &mesh);
        let rays: Vec<Ray> = (0..60_000)
            .map(|i| match i % 2 {
                0 if !cuts.is_empty() => ray_at_cut(&mut random, &mesh, cuts[i % cuts.len()]),
                _ => ray(&mut random, &mesh),
            })
            .collect();
        let mut expected: Option<Vec<Option<Hit>>> = None;
        for level in Level::available() {
            // The slow ones look at fewer rays.
            let rays = if level == Level::detect() { &rays[..] } else { &rays[..rays.len() / 6] };
            let plain = built(&mut world, &pool, level, false);
            let split = built(&mut world, &pool, level, true);
            let one = Tracer::new(&plain).intersect_many(rays);
            let other = Tracer::new(&split).intersect_many(rays);
            let mut occluded = vec![false; rays.len()];
            Tracer::new(&split).occluded_many(rays, &mut occluded);
            for (i, ray) in rays.iter().enumerate() {
                let what = || format!("seed {seed}, {name}, level {}, ray {i}: {ray:?}", level.name());
                assert_eq!(
                    bits(&one[i]),
                    bits(&other[i]),
                    "{:?} without, {:?} with splits: {}",
                    one[i],
                    other[i],
                    what()
                );
                assert_eq!(occluded[i], one[i].is_some(), "occluded: {}", what());
                let alone = Tracer::new(&split).intersect(ray);
                assert_eq!(bits(&one[i]), bits(&alone), "{:?}, alone {alone:?}: {}", one[i], what());
            }
            for (ray, hit) in rays.iter().zip(&one).take(if level == Level::Scalar { 400 } else { 0 }) {
                assert_eq!(bits(hit), bits(&world.brute_force(&plain, ray)), "seed {seed}, {name}: {ray:?}");
            }
            hits += one.iter().flatten().count();
            match &expected {
                Some(expected) => assert!(one.iter().zip(expected).all(|(a, b)| bits(a) == bits(b)), "{name}"),
                None => expected = Some(one),
            }
        }
    }
    println!("{hits} hits");
    assert!(hits > 150_000, "{hits} hits: the rays are aimed");
}

#[test]
fn split_objects_are_rebuilt_when_they_change_after_all() {
    let mut random = Random::new(Random::seed(42));
    let pool = Pool::new(Some(2)).expect("two threads");
    let mut world = still(needles(&mut random, 300), Affine3A::from_rotation_y(0.3));
    world.scene.apply(Command::SetSpatialSplits { name: 1, wanted: true });
    let mut structures = TwoLevel::new(Level::detect());
    for frame in 0..6 {
        match frame {
            // Vertices move.
            1 => {
                let positions =
                    world.scene.objects[&1].mesh.positions.iter().map(|p| *p + random.vec() * 0.1).collect();
                world.scene.apply(Command::UpdatePositions { name: 1, first: 0, positions });
            }
            // The instance moves.
            2 => world.instances[0].world_from_object = Affine3A::from_rotation_x(1.0),
            // It moves freely now, and is not cut any more.
            3 => world.scene.apply(Command::SetMotion { name: 1, motion: Motion::Unstructured }),
            4 => world.scene.apply(Command::SetMotion { name: 1, motion: Motion::Static }),
            5 => world.scene.apply(Command::SetSpatialSplits { name: 1, wanted: false }),
            _ => {}
        }
        pool.install(|| structures.update(&world.scene, &world.instances));
        let Structure::Bvh(bvh) = structures.objects()[0].structure() else { panic!("no tree") };
        // A static object that moves is built in haste.
        assert_eq!(bvh.holds_parts(), [true, true, false, false, true, false][frame], "frame {frame}");
        let mesh = meshes::moved(Mesh::clone(&world.scene.objects[&1].mesh), |p| {
            world.instances[0].world_from_object.transform_point3(p)
        });
        for _ in 0..300 {
            let ray = ray(&mut random, &mesh);
            let hit = Tracer::new(&structures).intersect(&ray);
            assert_eq!(bits(&hit), bits(&world.brute_force(&structures, &ray)), "frame {frame}: {ray:?}");
        }
    }
}
