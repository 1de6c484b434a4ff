//! Every strategy on every instruction set answers every ray alike, and rightly.
//!
//! Two references: an oracle in f64 that knows nothing of the engine ([`world::oracle`]) for what is right, and brute
//! force with the engine's own triangle test for the bits.

#[path = "common/meshes.rs"]
mod meshes;
#[path = "common/random.rs"]
mod random;
#[path = "common/rays.rs"]
mod rays;
#[path = "common/world.rs"]
mod world;

use glam::{Affine3A, Vec3};
use openrt::scene::{Command, Instance, Mesh, Motion, Strategy, TopLevelKind};
use openrt::simd::Level;
use openrt::threads::Pool;
use openrt::trace::{Hit, PacketMemory, Ray, RayPacket, Tracer};
use random::Random;
use rays::{bits, is_rescaled, rays};
use world::{Verdict, World, combinations, oracle};

fn pool() -> Pool {
    Pool::new(Some(2)).expect("two threads")
}

fn world_triangles(world: &World) -> Vec<[Vec3; 3]> {
    let mut all = Vec::new();
    for Instance { object, world_from_object, .. } in &world.instances {
        if let Some(object) = world.scene.objects.get(object) {
            let m = &object.mesh;
            all.extend(
                (0..m.triangles.len() as u32).map(|p| m.corners(p).map(|c| world_from_object.transform_point3(c))),
            );
        }
    }
    all
}

/// All structures and levels: bit-equal to each other, to brute force, and occluded where there is a hit.
fn check_bits(name: &str, world: &World, rays: &[Ray]) -> usize {
    let pool = pool();
    let mut expected: Option<Vec<Option<Hit>>> = None;
    for (strategy, level, top) in combinations() {
        let built = world.build(&pool, strategy, level, top);
        let tracer = Tracer::new(&built);
        let hits = tracer.intersect_many(rays);
        let mut occluded = vec![false; rays.len()];
        tracer.occluded_many(rays, &mut occluded);
        let what = |i: usize| {
            format!("{name}, {} at level {} below {top:?}, ray {i}: {:?}", strategy.name(), level.name(), rays[i])
        };
        for (i, (hit, occluded)) in hits.iter().zip(&occluded).enumerate() {
            assert_eq!(hit.is_some(), *occluded, "occluded differs: {}", what(i));
        }
        check_packets(&tracer, rays, &hits, what);
        let expected = expected.get_or_insert_with(|| {
            let brute =
                |(ray, hit): (&Ray, &Option<Hit>)| if is_rescaled(ray) { *hit } else { world.brute_force(&built, ray) };
            rays.iter().zip(&hits).map(brute).collect()
        });
        for (i, (hit, expected)) in hits.iter().zip(expected.iter()).enumerate() {
            assert_eq!(bits(hit), bits(expected), "{hit:?} is not {expected:?}: {}", what(i));
        }
    }
    expected.map_or(0, |e| e.iter().flatten().count())
}

/// Packets answer what batches do. Every seventh ray, and those that do not begin at their origin, are left out.
fn check_packets(tracer: &Tracer, rays: &[Ray], hits: &[Option<Hit>], what: impl Fn(usize) -> String) {
    let (mut packet, mut memory) = (RayPacket::new(), PacketMemory::new());
    for (number, (rays, hits)) in rays.chunks(RayPacket::RAYS).zip(hits.chunks(RayPacket::RAYS)).enumerate() {
        let first = RayPacket::RAYS * number;
        rays.iter().enumerate().for_each(|(r, ray)| packet.set(r, ray));
        let goes = |r: usize| (first + r) % 7 != 3 && !(rays[r].tmin > 0.0);
        let mask = (0..rays.len()).fold(0u64, |mask, r| mask | u64::from(goes(r)) << r);
        let occluded = tracer.occluded_packet(&packet, mask, &mut memory);
        let found = tracer.intersect_packet(&packet, mask, &mut memory);
        for r in (0..rays.len()).filter(|r| mask >> r & 1 == 1) {
            let hit = Some(found[r]).filter(|hit| !hit.is_none());
            assert_eq!(bits(&hit), bits(&hits[r]), "{hit:?} by the packet: {}", what(first + r));
            assert_eq!(occluded >> r & 1 == 1, hit.is_some(), "occluded by the packet: {}", what(first + r));
        }
        assert_eq!(occluded & !mask, 0, "rays that nobody asked for");
    }
}
#[test]
fn closest_hits_agree_with_exact_geometry() {
    let seed = Random::seed(1);
    let mut random = Random::new(seed);
    let (mut sure, mut unsure, mut hit_count) = (0, 0, 0);
    for (round, size) in [0.05, 0.2, 0.8, 0.02].into_iter().enumerate() {
        let mesh = meshes::soup(&mut random, 600, size);
        let triangles: Vec<_> = (0..600).map(|p| mesh.corners(p)).collect();
        let rays = rays(&mut random, &triangles, 1500);
        let world = World::plain(mesh);
        let built = world.build(
            &pool(),
            Strategy::ALL[round % Strategy::ALL.len()],
            Level::detect(),
            TopLevelKind::ALL[round / 2 % 2],
        );
        let tracer = Tracer::new(&built);
        for (i, ray) in rays.iter().enumerate() {
            let verdicts: Vec<Verdict> = triangles.iter().map(|t| oracle(ray, *t)).collect();
            let latest = verdicts.iter().fold(f64::INFINITY, |best, v| match v {
                Verdict::Hit { t, tolerance } => best.min(t + tolerance),
                _ => best,
            });
            let hit = tracer.intersect(ray);
            let what = || format!("seed {seed}, scene {round}, ray {i}: {ray:?} gives {hit:?}");
            assert_eq!(tracer.occluded(ray), hit.is_some(), "{}", what());
            let Some(hit) = hit else {
                assert!(latest == f64::INFINITY, "a triangle is surely hit before {latest}: {}", what());
                continue;
            };
            hit_count += 1;
            let t_hit = f64::from(hit.t);
            match verdicts[hit.primitive as usize] {
                Verdict::Miss => panic!("the triangle is surely missed: {}", what()),
                Verdict::Hit { t, tolerance } => {
                    sure += 1;
                    assert!((t_hit - t).abs() <= tolerance, "t should be {t} ± {tolerance}: {}", what());
                }
                Verdict::Unsure { t, tolerance } => {
                    unsure += 1;
                    assert!((t_hit - t).abs() <= tolerance, "t should be {t} ± {tolerance}: {}", what());
                }
            }
            assert!(t_hit <= latest, "another triangle is surely hit before {latest}: {}", what());
        }
    }
    println!("{hit_count} hits: {sure} sure, {unsure} within rounding of an edge or edge-on");
    assert!(sure > 1000 && hit_count > 2500, "{hit_count} hits, {sure} sure: the test has lost its teeth");
}

#[test]
fn all_structures_and_levels_agree_on_random_scenes() {
    let seed = Random::seed(2);
    let mut random = Random::new(seed);
    for (count, size) in [(300, 0.3), (3000, 0.05), (1000, 1.0)] {
        let world = World::plain(meshes::soup(&mut random, count, size));
        let rays = rays(&mut random, &world_triangles(&world), 1500);
        let hits = check_bits(&format!("seed {seed}, soup of {count}"), &world, &rays);
        assert!(hits > rays.len() / 3, "{hits} hits of {}", rays.len());
    }
    for (name, mesh) in [("icosphere", meshes::icosphere(3)), ("sphere with poles", meshes::uv_sphere(16, 40))] {
        let world = World::plain(mesh);
        let rays = rays(&mut random, &world_triangles(&world), 1500);
        check_bits(&format!("seed {seed}, {name}"), &world, &rays);
    }
}

#[test]
fn all_structures_and_levels_agree_on_degenerate_meshes() {
    let seed = Random::seed(3);
    let mut random = Random::new(seed);
    for (name, mesh) in meshes::degenerate(&mut random) {
        let count = if mesh.triangles.len() > 5000 { 40 } else { 200 };
        let world = World::plain(mesh);
        let rays = rays(&mut random, &world_triangles(&world), count);
        check_bits(&format!("seed {seed}, {name}"), &world, &rays);
    }
}

#[test]
fn instances_agree_with_testing_every_instance() {
    let seed = Random::seed(4);
    let mut random = Random::new(seed);
    for count in [1, 2, 3, 10, 60, 400] {
        let shapes = vec![meshes::soup(&mut random, 40, 0.5), meshes::icosphere(1), meshes::soup(&mut random, 1, 1.0)];
        let placed = world::placements(&mut random, count);
        let instances = placed.into_iter().enumerate().map(|(i, m)| (i as u32 % 3 + 1, m)).collect();
        let world = World::new(shapes, instances);
        let rays = rays(&mut random, &world_triangles(&world), 600);
        let hits = check_bits(&format!("seed {seed}, {count} instances"), &world, &rays);
        assert!(hits > 100, "{hits} hits");
    }
}

/// A cube's corners are corners of its box. Far from the origin, the rounded ray of object space passes them on another side than the
/// ray of the world passes the box, if the box is not padded for it.
#[test]
fn corners_of_instances_far_away_are_not_culled() {
    let seed = Random::seed(7);
    let mut random = Random::new(seed);
    let turned = Affine3A::from_rotation_y(0.5) * Affine3A::from_rotation_x(1.0);
    for (name, spread, at, turn) in [
        ("far place", 3.0f32, Vec3::new(1e4, -3e4, 2e4), Affine3A::IDENTITY),
        ("far place, turned", 3.0, Vec3::new(1e5, 4e4, -1e5), turned),
        ("far along an axis", 3.0, Vec3::new(3e4, 0.5, -0.5), Affine3A::IDENTITY),
        ("far along an axis, turned", 3.0, Vec3::new(0.5, 3e4, -0.5), turned),
        ("far origin", 1e5, Vec3::ZERO, Affine3A::IDENTITY),
        ("far origin, turned", 1e5, Vec3::ZERO, turned),
        ("flattened after a turn", 3.0, Vec3::splat(50.0), Affine3A::from_scale(Vec3::new(1.0, 1.0, 0.01)) * turned),
    ] {
        let placed = (0..9).map(|i| {
            let step = Vec3::new((i % 3) as f32, (i / 3) as f32, 0.0) * 2.5;
            (1, Affine3A::from_translation(at + step) * turn)
        });
        let world = World::new(vec![meshes::cube()], placed.collect());
        let triangles = world_triangles(&world);
        let rays: Vec<Ray> = (0..6000)
            .map(|i| {
                let [a, b, _] = triangles[random.below(triangles.len())];
                let target = if i % 2 == 0 { a } else { a + (b - a) * random.unit() };
                // Nearly in a side of the box: for other rays the padding of slab distances would do.
                let mut out = random.vec() * 10f32.powf(-6.0 * random.unit());
                out[random.below(3)] = random.unit() * 2.0 - 1.0;
                let org = if i % 5 == 0 { random.vec() * spread.min(10.0) } else { target + out * spread };
                Ray::new(org, target - org)
            })
            .collect();
        check_bits(&format!("seed {seed}, {name}"), &world, &rays);
    }
}

#[test]
fn equal_instances_and_equal_triangles_give_the_lowest_numbers() {
    let tri = [Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, -1.0, 0.0), Vec3::new(0.0, 1.0, 0.0)];
    let twice = meshes::mesh([tri.map(|c| c + Vec3::Z), tri, tri]);
    let turn = Affine3A::from_rotation_z(0.5);
    let instances = [Affine3A::from_translation(Vec3::Z * 5.0), turn, turn, turn].map(|m| (1, m)).to_vec();
    let world = World::new(vec![twice], instances);
    let pool = pool();
    for (strategy, level, top) in combinations() {
        let built = world.build(&pool, strategy, level, top);
        let hit = Tracer::new(&built).intersect(&Ray::new(Vec3::new(0.1, 0.0, -3.0), Vec3::Z)).expect("in the way");
        assert_eq!((hit.instance, hit.primitive), (1, 1), "{} at {}, {top:?}", strategy.name(), level.name());
    }
}

#[test]
fn broken_instances_draw_nothing_and_leave_the_others_alone() {
    let seed = Random::seed(5);
    let mut random = Random::new(seed);
    let pool = pool();
    let good = || vec![(1, Affine3A::IDENTITY), (2, Affine3A::from_translation(Vec3::splat(1.5)))];
    let shapes = || vec![meshes::icosphere(2), meshes::uv_sphere(6, 9), Mesh::default()];
    let scale = |x, y, z| Affine3A::from_scale(Vec3::new(x, y, z));
    let broken = vec![
        // A line; what is flattened in one direction only is there, see tests/instances.rs.
        (1, scale(0.0, 0.0, 1.0)),
        (1, scale(f32::NAN, 1.0, 1.0)),
        (2, scale(1.0, f32::INFINITY, 1.0)),
        (1, Affine3A::from_translation(Vec3::new(f32::NAN, 0.0, 0.0))),
        (1, scale(1e-42, 1e-42, 1e-42)),
        (3, Affine3A::IDENTITY),
        (77, Affine3A::IDENTITY),
        (0, Affine3A::IDENTITY),
    ];
    let plain = World::new(shapes(), good());
    let mixed = World::new(shapes(), [good(), broken].concat());
    let rays = rays(&mut random, &world_triangles(&plain), 500);
    for (strategy, level, top) in combinations() {
        let (a, b) = (plain.build(&pool, strategy, level, top), mixed.build(&pool, strategy, level, top));
        for ray in &rays {
            assert_eq!(
                bits(&Tracer::new(&a).intersect(ray)),
                bits(&Tracer::new(&b).intersect(ray)),
                "seed {seed}, {top:?}, {ray:?}"
            );
        }
    }
}

#[test]
fn extreme_scales_are_hit_where_they_are() {
    // A sphere of radius 1 in the world, whatever the units of its object.
    let pool = pool();
    for scale in [1e-15f32, 1e-10, 1.0, 1e10, 1e15] {
        let mesh = meshes::moved(meshes::icosphere(2), |p| p / scale);
        let world = World::new(vec![mesh], vec![(1, Affine3A::from_scale(Vec3::splat(scale)))]);
        for (strategy, level, top) in combinations() {
            let built = world.build(&pool, strategy, level, top);
            let tracer = Tracer::new(&built);
            for length in [1e-37f32, 1e-30, 1e-10, 1.0, 1e10, 1e30] {
                let dir = Vec3::new(0.1, 0.2, -1.0) * length;
                let ray = Ray::new(Vec3::new(0.2, 0.1, 0.05), dir);
                let hit =
                    tracer.intersect(&ray).unwrap_or_else(|| panic!("scale {scale:e}, length {length:e}: no hit"));
                let distance = f64::from(hit.t) * dir.as_dvec3().length();
                assert!((0.85..1.15).contains(&distance), "scale {scale:e}, length {length:e}: {hit:?}");
                // Its distance is beyond f32.
                let denormal = tracer.intersect(&Ray { direction: dir / length * 1e-42, ..ray });
                assert_eq!(denormal.map(|h| h.t), Some(f32::MAX));
                assert!((-1e-3..=1.001).contains(&hit.u) && (-1e-3..=1.001).contains(&hit.v), "{hit:?}");
            }
        }
    }
}

#[test]
fn broken_rays_hit_nothing() {
    let world = World::plain(meshes::icosphere(1));
    let pool = pool();
    let (nan, inf) = (f32::NAN, f32::INFINITY);
    let plain = Ray::new(Vec3::ZERO, Vec3::X);
    let broken = [
        Ray { origin: Vec3::new(nan, 0.0, 0.0), ..plain },
        Ray { origin: Vec3::new(0.0, inf, 0.0), ..plain },
        Ray { origin: Vec3::splat(1e30), ..plain },
        Ray { direction: Vec3::ZERO, ..plain },
        Ray { direction: Vec3::new(nan, 1.0, 0.0), ..plain },
        Ray { direction: Vec3::new(1.0, nan, 0.0), ..plain },
        Ray { direction: Vec3::new(1.0, -inf, 0.0), ..plain },
        Ray { direction: Vec3::NAN, ..plain },
        Ray { tmax: nan, ..plain },
        Ray { tmax: -1.0, ..plain },
        Ray { tmin: 2.0, tmax: 1.0, ..plain },
        Ray { tmin: inf, ..plain },
    ];
    for (strategy, level, top) in combinations() {
        let built = world.build(&pool, strategy, level, top);
        let tracer = Tracer::new(&built);
        for ray in &broken {
            assert_eq!((tracer.intersect(ray), tracer.occluded(ray)), (None, false), "{ray:?}");
        }
        assert!(tracer.intersect(&Ray { tmin: nan, ..plain }).is_some());
        assert!(tracer.intersect(&Ray { tmin: -5.0, ..plain }).is_some());
    }
}

#[test]
fn updates_follow_the_scene() {
    let seed = Random::seed(6);
    let mut random = Random::new(seed);
    let pool = pool();
    let strategies = [None].into_iter().chain(Strategy::ALL.map(Some));
    for (strategy, top) in strategies.flat_map(|s| TopLevelKind::ALL.map(|t| (s, t))) {
        let mut world = World::new(
            vec![meshes::icosphere(3), meshes::soup(&mut random, 200, 0.2)],
            vec![
                (1, Affine3A::IDENTITY),
                (2, Affine3A::from_translation(Vec3::X * 2.0)),
                (1, Affine3A::from_scale(Vec3::splat(0.3))),
            ],
        );
        world.scene.apply(Command::SetMotion { name: 1, motion: Motion::Unstructured });
        let mut built = openrt::accel::TwoLevel::new(Level::detect());
        built.force_strategy(strategy);
        built.force_top_level(Some(top));
        for frame in 0..14 {
            match frame {
                4 => world.scene.apply(Command::DeleteObject { name: 2 }),
                // The same name, another object, between two frames.
                6 => {
                    world.scene.apply(Command::DefineObject {
                        name: 2,
                        mesh: meshes::uv_sphere(5, 7),
                        motion: Motion::Static,
                    });
                }
                8 => {
                    world.scene.apply(Command::DeleteObject { name: 2 });
                    world.scene.apply(Command::DefineObject {
                        name: 2,
                        mesh: meshes::icosphere(2),
                        motion: Motion::Static,
                    });
                }
                10 => world.instances.truncate(2),
                11 => world.scene.apply(Command::DefineObject {
                    name: 1,
                    mesh: meshes::icosphere(1),
                    motion: Motion::Unstructured,
                }),
                _ => {
                    let positions =
                        world.scene.objects[&1].mesh.positions.iter().map(|p| *p + random.vec() * 0.1).collect();
                    world.scene.apply(Command::UpdatePositions { name: 1, first: 0, positions });
                }
            }
            let stats = pool.install(|| built.update(&world.scene, &world.instances));
            assert_eq!(stats.out_of_memory, 0);
            let tracer = Tracer::new(&built);
            for ray in rays(&mut random, &world_triangles(&world), 150).iter().filter(|r| !is_rescaled(r)) {
                let what = format!("seed {seed}, {strategy:?}, {top:?}, frame {frame}, {ray:?}");
                assert_eq!(bits(&tracer.intersect(ray)), bits(&world.brute_force(&built, ray)), "{what}");
            }
            // A second update has nothing to do.
            let again = pool.install(|| built.update(&world.scene, &world.instances));
            assert_eq!((again.objects_built, again.objects_refitted), (0, 0), "{strategy:?}, frame {frame}");
        }
    }
}
