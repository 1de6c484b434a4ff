//! Objects that rays bring up to date (`RT_LAZY`): the same hits as a fresh build, whoever comes first, and no work for what nobody sees.

#[path = "common/meshes.rs"]
#[allow(dead_code, reason = "shared with other tests")]
mod meshes;
#[path = "common/random.rs"]
mod random;

use glam::{Affine3A, Vec3};
use openrt::accel::{Structure, TwoLevel};
use openrt::scene::{Command, Instance, Mesh, Motion, Scene, Strategy};
use openrt::simd::Level;
use openrt::threads::Pool;
use openrt::trace::{Hit, Ray, Tracer};
use random::Random;
use rayon::prelude::*;

const RAYS: usize = 900;

fn bits(hit: &Option<Hit>) -> Option<[u32; 6]> {
    hit.map(|h| [h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.primitive, h.object, h.instance])
}

fn rays(random: &mut Random, mesh: &Mesh) -> Vec<Ray> {
    let usable: Vec<Vec3> = mesh.positions.iter().copied().filter(|p| p.abs().max_element() < 1e18).collect();
    let size = usable.iter().fold(1e-3f32, |m, p| m.max(p.abs().max_element()));
    (0..RAYS)
        .map(|i| {
            let at = |random: &mut Random| {
                if usable.is_empty() { random.vec() } else { usable[random.below(usable.len())] }
            };
            let org = if i % 4 == 0 { at(random) } else { random.vec() * 3.0 * size };
            let target = (at(random) + at(random) * 0.1) * (0.9 + 0.2 * random.unit());
            Ray { tmax: if i % 7 == 0 { 1.0 } else { f32::INFINITY }, ..Ray::new(org, target - org) }
        })
        .collect()
}

/// Single rays and packets from several threads at once, so that they meet in parts that are being written.
fn trace(pool: &Pool, world: &TwoLevel, rays: &[Ray]) -> (Vec<Option<Hit>>, Vec<bool>) {
    let tracer = Tracer::new(world);
    let mut hits = vec![None; rays.len()];
    let mut occluded = vec![false; rays.len()];
    pool.install(|| {
        hits.par_chunks_mut(50).zip(occluded.par_chunks_mut(50)).zip(rays.par_chunks(50)).enumerate().for_each(
            |(i, ((hits, occluded), rays))| match i % 3 {
                0 => {
                    tracer.occluded_many(rays, occluded);
                    hits.copy_from_slice(&tracer.intersect_many(rays));
                }
                1 => {
                    hits.copy_from_slice(&tracer.intersect_many(rays));
                    tracer.occluded_many(rays, occluded);
                }
                _ => rays.iter().zip(hits).zip(occluded).for_each(|((ray, hit), occluded)| {
                    *hit = tracer.intersect(ray);
                    *occluded = tracer.occluded(ray);
                }),
            },
        );
    });
    (hits, occluded)
}

fn world(strategy: Strategy, level: Level) -> TwoLevel {
    let mut world = TwoLevel::new(level);
    world.force_strategy(Some(strategy));
    world
}

/// What a sequence does to a vertex at frame `k`.
type Move = fn(&mut Random, usize, Vec3) -> Vec3;

const SEQUENCES: [(&str, Move); 6] = [
    ("waves", |_, k, p| p * (1.0 + 0.2 * (p.x * 5.0 + k as f32).sin())),
    ("shaken ever more", |r, k, p| p + r.vec() * (0.02 * k as f32)),
    ("torn", |r, k, p| if k % 3 == 1 { r.vec() * 2.0 } else { p }),
    ("collapsing to a point", |_, k, p| p * (1.0 - k as f32 / 6.0).max(0.0) + Vec3::splat(0.1)),
    ("exploding", |_, k, p| p * 10f32.powi(3 * k as i32)),
    ("NaN that come and go", |r, k, p| match (k % 4, r.below(20)) {
        (1, 0..6) => p.with_z(f32::NAN),
        (2, _) => Vec3::NAN,
        (3, 0) => Vec3::INFINITY,
        _ => p,
    }),
];

#[test]
fn hits_are_those_of_a_fresh_build_in_every_frame() {
    let seed = Random::seed(61);
    let mut random = Random::new(seed);
    let pool = Pool::new(Some(4)).expect("threads");
    let mut broken = meshes::soup(&mut random, 4000, 0.1);
    broken.positions.iter_mut().step_by(5).for_each(|p| *p = Vec3::NAN);
    for (name, mesh) in
        [("icosphere", meshes::icosphere(5)), ("soup", meshes::soup(&mut random, 5000, 0.1)), ("broken", broken)]
    {
        for (sequence, step) in SEQUENCES {
            let mut scene = Scene::default();
            scene.apply(Command::DefineObject { name: 1, mesh: mesh.clone(), motion: Motion::Unstructured });
            let turned = Affine3A::from_rotation_y(0.5);
            let instances = [Affine3A::IDENTITY, turned].map(|world_from_object| Instance::new(1, world_from_object));
            let mut worlds: Vec<TwoLevel> = Level::available().map(|level| world(Strategy::Lazy, level)).collect();
            for frame in 0..8 {
                if frame > 0 {
                    let positions = mesh.positions.iter().map(|&p| step(&mut random, frame, p)).collect();
                    scene.apply(Command::UpdatePositions { name: 1, first: 0, positions });
                }
                let mut fresh = world(Strategy::Sah, Level::detect());
                pool.install(|| fresh.update(&scene, &instances));
                let rays = rays(&mut random, &scene.objects[&1].mesh);
                let (expected, _) = trace(&pool, &fresh, &rays);
                for lazy in &mut worlds {
                    pool.install(|| lazy.update(&scene, &instances));
                    // In one frame nobody looks: the next one finds parts two frames old.
                    if frame % 5 == 3 {
                        continue;
                    }
                    let (hits, occluded) = trace(&pool, lazy, &rays);
                    for (i, (hit, expected)) in hits.iter().zip(&expected).enumerate() {
                        let what = || format!("seed {seed}, {name}, {sequence}, frame {frame}, ray {i}: {:?}", rays[i]);
                        assert_eq!(bits(hit), bits(expected), "{}", what());
                        assert_eq!(occluded[i], hit.is_some(), "occluded: {}", what());
                    }
                }
            }
        }
    }
}

#[test]
fn what_no_ray_meets_is_not_touched() {
    let mut scene = Scene::default();
    let pool = Pool::new(Some(2)).expect("threads");
    for name in 1..=9 {
        scene.apply(Command::DefineObject { name, mesh: meshes::icosphere(5), motion: Motion::Unstructured });
        scene.apply(Command::SetStrategy { name, strategy: Strategy::Lazy });
    }
    let at = |i: u32| Affine3A::from_translation(Vec3::X * (4 * i) as f32);
    let instances: Vec<Instance> = (1..=9).map(|i| Instance::new(i, at(i))).collect();
    let mut world = TwoLevel::new(Level::detect());
    pool.install(|| world.update(&scene, &instances));
    for frame in 0..6 {
        for name in 1..=9 {
            let positions = scene.objects[&name].mesh.positions.iter().map(|p| *p * 1.001).collect();
            scene.apply(Command::UpdatePositions { name, first: 0, positions });
        }
        let stats = pool.install(|| world.update(&scene, &instances));
        assert_eq!((stats.objects_built, stats.objects_refitted), (0, 9));
        if frame == 3 {
            // Nobody looks, so that in the next frame nobody is expected.
            continue;
        }
        let ray = Ray::new(Vec3::new(8.1, 0.05, 10.0), Vec3::NEG_Z);
        let hit = Tracer::new(&world).intersect(&ray).expect("the second sphere");
        assert_eq!(hit.object, 2);
        let (segments, nodes) = world.touched();
        // The top of the second sphere, by the update if a ray was there in the frame before, and what is below the ray.
        assert!((1..=4).contains(&segments), "frame {frame}: {segments} segments");
        assert_eq!(stats.nodes_updated > 0, ![0, 4].contains(&frame), "frame {frame}: {}", stats.nodes_updated);
        assert!(nodes < 600, "frame {frame}: {nodes} nodes");
    }
}

/// Few vertices at a time, by ranges and by lists, between moves of all of them.
#[test]
fn partial_moves_give_the_hits_of_a_fresh_build() {
    let seed = Random::seed(62);
    let mut random = Random::new(seed);
    let pool = Pool::new(Some(3)).expect("threads");
    let mesh = meshes::icosphere(5);
    let count = mesh.positions.len();
    let mut scene = Scene::default();
    scene.apply(Command::DefineObject { name: 1, mesh, motion: Motion::Unstructured });
    let instances = [Instance::new(1, Affine3A::IDENTITY)];
    let strategies = [Strategy::Lazy, Strategy::Refit, Strategy::Auto];
    let mut worlds = strategies.map(|strategy| (strategy, world(strategy, Level::detect())));
    let mut partial = [0; 3];
    for frame in 0..40 {
        if frame % 10 == 9 {
            let positions = scene.objects[&1].mesh.positions.iter().map(|&p| p + random.vec() * 0.003).collect();
            scene.apply(Command::UpdatePositions { name: 1, first: 0, positions });
        } else if frame > 0 {
            let mut moved = |p: Vec3| {
                if random.below(30) == 0 { Vec3::NAN } else { p.normalize_or(Vec3::X) * (0.8 + 0.4 * random.unit()) }
            };
            let before = &scene.objects[&1].mesh.positions;
            let first = (frame * 577) % (count - 30);
            if frame % 2 == 0 {
                let positions = before[first..first + 30].iter().map(|&p| moved(p)).collect();
                scene.apply(Command::UpdatePositions { name: 1, first: first as u32, positions });
            } else {
                let vertices: Vec<u32> = (0..25).map(|i| ((first + 97 * i) % count) as u32).collect();
                let positions = vertices.iter().map(|&v| moved(before[v as usize])).collect();
                scene.apply(Command::MovePositions { name: 1, vertices, positions });
            }
            if frame % 7 == 6 {
                // Two changes until the next update.
                continue;
            }
        }
        let mut fresh = world(Strategy::Sah, Level::detect());
        pool.install(|| fresh.update(&scene, &instances));
        let rays = rays(&mut random, &scene.objects[&1].mesh);
        let (expected, _) = trace(&pool, &fresh, &rays);
        for (i, (strategy, built)) in worlds.iter_mut().enumerate() {
            let stats = pool.install(|| built.update(&scene, &instances));
            partial[i] += usize::from(stats.objects_refitted == 1 && stats.nodes_updated < 400);
            let what = format!("seed {seed}, {}, frame {frame}", strategy.name());
            let few = if frame % 3 == 0 { 20 } else { rays.len() };
            let (hits, _) = trace(&pool, built, &rays[..few]);
            hits.iter().zip(&expected).for_each(|(hit, expected)| assert_eq!(bits(hit), bits(expected), "{what}"));
        }
    }
    assert!(partial.iter().all(|&frames| frames > 20), "{partial:?} frames were updated in part");
}

/// A soup that is another one at each key frame, and on the way between.
#[test]
fn trees_of_key_frames_take_turns_and_hit_the_same() {
    let seed = Random::seed(63);
    let mut random = Random::new(seed);
    let pool = Pool::new(Some(3)).expect("threads");
    let keys: Vec<Mesh> = (0..4).map(|_| meshes::soup(&mut random, 2000, 0.05)).collect();
    let mut scene = Scene::default();
    scene.apply(Command::DefineObject { name: 1, mesh: keys[0].clone(), motion: Motion::Unstructured });
    let instances = [Instance::new(1, Affine3A::from_rotation_x(0.3))];
    let mut worlds = [Strategy::Lazy, Strategy::Refit, Strategy::Sah].map(|s| (s, world(s, Level::detect())));
    let mut costs = Vec::new();
    for frame in 0..26 {
        let time = frame as f32 / 6.0;
        if frame == 3 {
            for (i, key) in keys.iter().enumerate() {
                scene.apply(Command::SetKeyFrame { name: 1, time: i as f32, positions: key.positions.clone() });
            }
        }
        if frame == 23 {
            scene.apply(Command::DeleteKeyFrames { name: 1 });
        }
        let (a, b) = (&keys[(time as usize).min(3)].positions, &keys[(time as usize + 1).min(3)].positions);
        let positions = a.iter().zip(b).map(|(a, b)| a.lerp(*b, time.fract())).collect();
        scene.apply(Command::UpdatePositions { name: 1, first: 0, positions });
        scene.apply(Command::SetTime { name: 1, time });
        let mut fresh = world(Strategy::Sah, Level::detect());
        pool.install(|| fresh.update(&scene, &instances));
        let rays = rays(&mut random, &scene.objects[&1].mesh);
        let (expected, _) = trace(&pool, &fresh, &rays);
        for (strategy, built) in &mut worlds {
            let stats = pool.install(|| built.update(&scene, &instances));
            let what = format!("seed {seed}, {}, frame {frame}", strategy.name());
            let (hits, _) = trace(&pool, built, &rays);
            hits.iter().zip(&expected).for_each(|(hit, expected)| assert_eq!(bits(hit), bits(expected), "{what}"));
            if *strategy != Strategy::Sah {
                // The first time, when the key frames come, and when they go.
                assert_eq!(stats.objects_built == 1, matches!(frame, 0 | 3 | 23), "{what}");
            }
            if let (Strategy::Refit, Structure::Bvh(bvh)) = (*strategy, built.objects()[0].structure()) {
                costs.push(bvh.sah_cost());
            }
        }
    }
    // At a key frame the tree is as good as new; a tree of another one is not.
    assert!(costs[12] < 0.5 * costs[15] && costs[18] < 0.5 * costs[15], "{costs:?}");
}
