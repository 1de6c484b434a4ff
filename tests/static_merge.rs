//! Merging static instances does not change a bit of what rays hit: before, while and after it, under every kind of change,
//! on every instruction set, with any number of threads, below either top level.

#[path = "common/meshes.rs"]
#[allow(dead_code, reason = "shared with other tests")]
mod meshes;
#[path = "common/random.rs"]
mod random;
#[path = "common/world.rs"]
#[allow(dead_code, reason = "shared with other tests")]
mod world;

use glam::{Affine3A, Vec3};
use openrt::accel::{Merging, TwoLevel};
use openrt::scene::{Command, Instance, Motion, Strategy, TopLevelKind};
use openrt::simd::Level;
use openrt::threads::Pool;
use openrt::trace::{Hit, Ray, Tracer};
use random::Random;
use world::World;

/// Objects `1..=PARTS` are static; the last one is affine, and the same as the first.
const PARTS: u32 = 30;
const FRAMES: u32 = 24;

/// A static scene in parts, of which some coincide, with an affine instance in the same place as the first.
fn split_scene(random: &mut Random) -> World {
    let mut parts = Vec::new();
    let mut instances = Vec::new();
    for name in 1..=PARTS {
        parts.push(match name % 4 {
            0 => meshes::icosphere(2),
            1 => meshes::soup(random, 60, 0.4),
            2 => meshes::moved(meshes::uv_sphere(8, 12), |p| p * 0.7),
            _ => meshes::soup(random, 1, 1.0),
        });
        instances.push((
            name,
            Affine3A::from_rotation_translation(glam::Quat::from_rotation_y(random.unit() * 6.0), random.vec() * 1.5),
        ));
    }
    // The same triangles five times, in static objects and in an affine one.
    let twin = meshes::moved(meshes::icosphere(3), |p| p * 1.8);
    for name in [1, 5, 9, 17] {
        parts[name - 1] = twin.clone();
        instances[name - 1].1 = Affine3A::IDENTITY;
    }
    parts.push(twin);
    instances.insert(3, (PARTS + 1, Affine3A::IDENTITY));
    let mut world = World::new(parts, instances);
    for name in 1..=PARTS {
        world.scene.apply(Command::SetMotion { name, motion: Motion::Static });
    }
    world
}

/// What the application does before a frame.
fn change(world: &mut World, random: &mut Random, frame: u32) {
    let at = |world: &World, name: u32| world.instances.iter().position(|i| i.object == name);
    match frame {
        // Long enough to be merged before the first change.
        0..=7 => {}
        8 => world.scene.apply(Command::DeleteObject { name: 1 }),
        9 => world.scene.apply(Command::DefineObject { name: 7, mesh: meshes::icosphere(1), motion: Motion::Static }),
        10 => {
            let i = at(world, 12).expect("it is there");
            world.instances[i].world_from_object *= Affine3A::from_translation(Vec3::splat(0.3));
        }
        // Another order: equal triangles have other winners now.
        11 => world.instances.reverse(),
        // Twice: affine from now on.
        12 => world.instances.push(Instance::new(14, Affine3A::from_rotation_x(0.4))),
        13 => {
            let positions = world.scene.objects[&9].mesh.positions.iter().map(|p| *p + random.vec() * 0.02).collect();
            world.scene.apply(Command::UpdatePositions { name: 9, first: 0, positions });
        }
        // Hidden, and shown again at the end.
        14 => world.instances.retain(|i| i.object != 20),
        16 => world.instances.push(Instance::new(20, Affine3A::IDENTITY)),
        17 => world.scene.apply(Command::SetMotion { name: 22, motion: Motion::Affine }),
        // It draws nothing, merged or not.
        18 => {
            let i = at(world, 24).expect("it is there");
            world.instances[i].world_from_object = Affine3A::from_scale(Vec3::new(1.0, 0.0, 1.0));
        }
        // The name of a deleted object for a new one.
        19 => {
            world.scene.apply(Command::DefineObject { name: 1, mesh: meshes::icosphere(3), motion: Motion::Static });
            world.instances.insert(0, Instance::new(1, Affine3A::from_scale(Vec3::splat(1.8))));
        }
        _ => {}
    }
}

fn rays(random: &mut Random, world: &World) -> Vec<Ray> {
    let corners: Vec<Vec3> = world
        .instances
        .iter()
        .filter_map(|i| Some((world.scene.objects.get(&i.object)?, i.world_from_object)))
        .flat_map(|(object, m)| object.mesh.positions.iter().map(move |p| m.transform_point3(*p)))
        .collect();
    (0..150)
        .map(|i| {
            let org = random.vec() * 5.0;
            let target = if i % 3 == 0 { random.vec() } else { corners[random.below(corners.len())] };
            let ray = Ray::new(org, target - org);
            if i % 10 == 7 { Ray { tmax: random.unit() * 1.2, ..ray } } else { ray }
        })
        .collect()
}

fn bits(hit: &Option<Hit>) -> Option<[u32; 6]> {
    hit.map(|h| [h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.primitive, h.object, h.instance])
}

type Answers = Vec<(Option<[u32; 6]>, bool)>;

fn answers(built: &TwoLevel, rays: &[Ray]) -> Answers {
    let tracer = Tracer::new(built);
    let hits = tracer.intersect_many(rays);
    let mut occluded = vec![false; rays.len()];
    tracer.occluded_many(rays, &mut occluded);
    for (ray, hit) in rays.iter().zip(&hits) {
        assert_eq!(bits(&tracer.intersect(ray)), bits(hit), "one ray and many: {ray:?}");
    }
    hits.iter().map(bits).zip(occluded).collect()
}

/// How a world is brought from frame to frame.
struct Way {
    merging: Merging,
    level: Level,
    threads: usize,
    top: TopLevelKind,
    /// Wait for the tree in the background before every update.
    wait: bool,
}

/// Answers of all frames, and how many instances were merged in each.
fn play(seed: u64, way: &Way) -> (Vec<Answers>, Vec<u32>) {
    let mut random = Random::new(seed);
    let mut world = split_scene(&mut random);
    let pool = Pool::new(Some(way.threads)).expect("threads");
    let mut built = TwoLevel::new(way.level);
    built.set_merging(way.merging);
    built.force_top_level(Some(way.top));
    // Merging is for the automatic strategy, whatever the environment asks for.
    built.force_strategy(None);
    let (mut all, mut merged) = (Vec::new(), Vec::new());
    for frame in 0..FRAMES {
        change(&mut world, &mut random, frame);
        if way.wait {
            built.wait_for_merge();
        }
        let stats = pool.install(|| built.update(&world.scene, &world.instances));
        assert_eq!(stats.out_of_memory, 0);
        merged.push(stats.merged_instances);
        let rays = rays(&mut random, &world);
        let answers = pool.install(|| answers(&built, &rays));
        if way.merging == Merging::Never && way.level == Level::detect() {
            for (i, (ray, (hit, occluded))) in rays.iter().zip(&answers).enumerate() {
                let expected = bits(&world.brute_force(&built, ray));
                assert_eq!((hit, occluded), (&expected, &expected.is_some()), "seed {seed}, frame {frame}, ray {i}");
            }
        }
        all.push(answers);
    }
    (all, merged)
}

#[test]
fn merging_changes_no_bit() {
    let seed = Random::seed(33);
    let never =
        Way { merging: Merging::Never, level: Level::detect(), threads: 2, top: TopLevelKind::Bvh, wait: false };
    let (expected, merged) = play(seed, &never);
    assert!(merged.iter().all(|&count| count == 0));
    let hits = expected.iter().flatten().filter(|(hit, _)| hit.is_some()).count();
    assert!(hits > 1000, "{hits} hits");
    let winners = |frame: usize| expected[frame].iter().filter_map(|(hit, _)| hit.map(|h| h[4])).collect::<Vec<_>>();
    // The tie rule is at work: the first twin wins until it is deleted; the affine one, then the first in the other order.
    assert!(winners(7).contains(&1) && !winners(7).contains(&5) && !winners(7).contains(&(PARTS + 1)));
    assert!(winners(10).contains(&(PARTS + 1)) && !winners(10).contains(&17));
    assert!(winners(11).contains(&17) && !winners(11).contains(&5));

    for level in Level::available() {
        for top in TopLevelKind::ALL {
            for (merging, wait, threads) in [
                (Merging::Never, false, 1),
                (Merging::AtOnce, false, 1),
                (Merging::AtOnce, false, 3),
                (Merging::Background, true, 2),
                (Merging::Background, false, 2),
            ] {
                let way = Way { merging, level, threads, top, wait };
                let (all, merged) = play(seed, &way);
                for (frame, (answers, expected)) in all.iter().zip(&expected).enumerate() {
                    for (i, (answer, expected)) in answers.iter().zip(expected).enumerate() {
                        assert_eq!(
                            answer,
                            expected,
                            "seed {seed}, {merging:?} at {} with {threads} threads below {top:?}, frame {frame}, \
                             {} merged, ray {i}",
                            level.name(),
                            merged[frame]
                        );
                    }
                }
                match (merging, wait) {
                    // In frame 12 one is placed twice; it is affine.
                    (Merging::AtOnce, _) => {
                        assert_eq!((merged[0], merged[8], merged[12]), (PARTS, PARTS - 1, PARTS - 2))
                    }
                    (Merging::Background, true) => {
                        // Begun in the fifth frame, taken in in the sixth; those that change leave one by one.
                        assert_eq!((merged[3], merged[7], merged[8], merged[9]), (0, PARTS, PARTS - 1, PARTS - 2));
                        assert!(merged[FRAMES as usize - 1] >= PARTS - 8, "{merged:?}");
                    }
                    _ => {}
                }
            }
        }
    }
}

/// What is merged has no structure of its own, and what is gone leaves nothing behind.
#[test]
fn memory_is_that_of_one_tree() {
    let mut random = Random::new(Random::seed(34));
    let mut world = split_scene(&mut random);
    let pool = Pool::new(Some(2)).expect("threads");
    let bytes = |merging, world: &World| {
        let mut built = TwoLevel::new(Level::detect());
        built.force_strategy(Some(Strategy::Sah));
        built.set_merging(merging);
        pool.install(|| built.update(&world.scene, &world.instances)).bytes
    };
    let (apart, together) = (bytes(Merging::Never, &world), bytes(Merging::AtOnce, &world));
    assert!(together < apart + apart / 10, "{together} bytes merged, {apart} before");

    let mut built = TwoLevel::new(Level::detect());
    built.force_strategy(Some(Strategy::Sah));
    built.set_merging(Merging::AtOnce);
    pool.install(|| built.update(&world.scene, &world.instances));
    (1..=PARTS).for_each(|name| world.scene.apply(Command::DeleteObject { name }));
    let stats = pool.install(|| built.update(&world.scene, &world.instances));
    assert_eq!((stats.merged_instances, built.merged().is_none()), (0, true));
    assert!(stats.bytes < apart / 2, "{} bytes after the end, {apart} at the beginning", stats.bytes);
}

/// Objects of other strategies keep the structure that was asked for.
#[test]
fn only_what_the_merged_tree_is_like_is_merged() {
    let mut random = Random::new(Random::seed(35));
    let mut world = split_scene(&mut random);
    for (name, strategy) in [(2, Strategy::Bsp), (3, Strategy::FastBuild), (4, Strategy::Refit), (6, Strategy::Sah)] {
        world.scene.apply(Command::SetStrategy { name, strategy });
    }
    let pool = Pool::new(Some(2)).expect("threads");
    let mut built = TwoLevel::new(Level::detect());
    built.force_strategy(None);
    built.set_merging(Merging::AtOnce);
    let stats = pool.install(|| built.update(&world.scene, &world.instances));
    assert_eq!(stats.merged_instances, PARTS - 3);
}
