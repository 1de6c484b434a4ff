//! The suite that every update strategy runs: sequences of frames that wear, tear and break a structure.
//!
//! After every frame the structure of every strategy must be valid, and rays must find in it what they find in structures that are
//! built for that frame alone, bit for bit, one by one or many at a time, from several threads at once. A strategy that
//! is added to [`Strategy::ALL`] is tested by that alone; what it promises of its quality is written in [`promised`].

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

use glam::{Affine3A, Quat, Vec3};
use openrt::accel::{Bvh, MAX_DEPTH, Structure, TwoLevel, build_sah, validate, validate_lazy};
use openrt::scene::{Command, Mesh, Motion, Strategy, TopLevelKind};
use openrt::simd::Level;
use openrt::threads::Pool;
use openrt::trace::{Hit, Ray, Tracer};
use random::Random;
use rays::{bits, is_rescaled, rays};
use world::World;

const FRAMES: u32 = 50;
const RAYS: usize = 60;

/// All strategies, the choosing one included.
fn strategies() -> impl Iterator<Item = Strategy> + Clone {
    [Strategy::Auto].into_iter().chain(Strategy::ALL)
}

/// How many times as costly as a tree of the SAH builder a strategy's tree may be after any number of frames; `None` where the
/// strategy leaves that to the motion.
fn promised(strategy: Strategy) -> Option<f64> {
    match strategy {
        Strategy::Sah => Some(1.0),
        Strategy::FastBuild => Some(1.35),
        Strategy::Auto | Strategy::Rotate => Some(2.0),
        Strategy::Bsp | Strategy::Refit | Strategy::Grid | Strategy::Lazy | Strategy::VisibilityField => None,
    }
}

/// The vertices of a frame; called for one frame after another.
type Next = Box<dyn FnMut(u32, &mut Random) -> Vec<Vec3>>;

/// An animation: a mesh and its vertices at every frame, in order.
struct Sequence {
    name: &'static str,
    mesh: Mesh,
    next: Next,
}

impl Sequence {
    fn new(name: &'static str, mesh: Mesh, next: impl FnMut(u32, &mut Random) -> Vec<Vec3> + 'static) -> Self {
        Self { name, mesh, next: Box::new(next) }
    }

    /// Every vertex by a function of the frame, its number and where it was at first.
    fn of_points(name: &'static str, mesh: Mesh, at: impl Fn(f32, usize, Vec3) -> Vec3 + 'static) -> Self {
        let first = mesh.positions.clone();
        Self::new(name, mesh, move |frame, _| {
            first.iter().enumerate().map(|(i, p)| at(frame as f32 / FRAMES as f32, i, *p)).collect()
        })
    }
}

fn sequences(random: &mut Random) -> Vec<Sequence> {
    let wandering = meshes::soup(random, 400, 0.2);
    let mut here = wandering.positions.clone();
    let degenerate = meshes::soup(random, 200, 0.4);
    let garbage = meshes::soup(random, 300, 0.3);
    let (flat, gas) = (degenerate.positions.clone(), garbage.positions.clone());
    let swarm = meshes::soup(random, 500, 0.05);
    let swarm_at: Vec<(Vec3, Vec3)> = (0..500).map(|_| (random.vec(), random.vec() * 3.0)).collect();
    let swarm_shape: Vec<Vec3> = (0..1500).map(|i| swarm.positions[i] - swarm.positions[i / 3 * 3]).collect();
    vec![
        Sequence::new("random walk", wandering, move |_, random| {
            here.iter_mut().for_each(|p| *p += random.vec() * 0.15);
            here.clone()
        }),
        // Points, lines, planes, duplicates and slivers come and go.
        Sequence::new("degenerate", degenerate, move |_, random| {
            let mut points = flat.clone();
            for corners in points.chunks_exact_mut(3) {
                match random.below(8) {
                    0 => corners.fill(corners[0]),
                    1 => corners[2] = corners[0] + (corners[1] - corners[0]) * random.unit(),
                    2 => corners.iter_mut().for_each(|p| p.z = 0.25),
                    3 => corners[2] = corners[1] + random.vec() * 1e-7,
                    4 => corners.copy_from_slice(&flat[..3]),
                    5 => corners.iter_mut().for_each(|p| *p *= 1e-20),
                    6 => corners.iter_mut().for_each(|p| *p = p.with_y(0.5) * Vec3::new(1.0, 1.0, 0.0)),
                    _ => {}
                }
            }
            points
        }),
        // A closed surface is torn in two, the triangles between are stretched.
        Sequence::of_points("tearing", meshes::icosphere(3), |time, _, p| {
            p + Vec3::new(0.0, if p.y > 0.1 { 20.0 } else { -3.0 }, p.z.signum() * 5.0) * time * time
        }),
        // Triangles fly apart, by a power of two per frame.
        Sequence::of_points("exploding", meshes::uv_sphere(14, 20), |time, i, p| {
            p * (time * (10.0 + (i % 7) as f32 * 5.0)).exp2()
        }),
        Sequence::of_points("collapsing to a point", meshes::icosphere(3), |time, _, p| {
            let about = Vec3::new(0.3, -0.2, 0.7);
            if (0.6..0.7).contains(&time) { about } else { about + p * (1.0 - time / 0.6).abs().powi(6) }
        }),
        // Vertices that are no numbers appear and vanish, already at the build and at last all at once.
        Sequence::new("not a number", garbage, move |frame, random| {
            let mut points = gas.clone();
            for _ in 0..(frame + 4) % 13 * 5 {
                let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, f32::MAX][random.below(5)];
                let at = random.below(points.len());
                points[at][random.below(3)] = bad;
            }
            if (30..32).contains(&frame) { vec![Vec3::NAN; points.len()] } else { points }
        }),
        // Triangles pass through each other like the birds of a swarm: whoever were neighbours are so no more.
        Sequence::new("swarm", swarm, move |frame, _| {
            let time = frame as f32 * 0.1;
            let fold = |x: f32| 2.0 * ((x * 0.25 + 0.25).rem_euclid(1.0) * 2.0 - 1.0).abs() - 1.0;
            let at = |i: usize| {
                let (from, speed) = swarm_at[i / 3];
                (from + speed * time).map(fold) + swarm_shape[i]
            };
            (0..1500).map(at).collect()
        }),
    ]
}

/// What `openrt` holds for the only object of a world.
fn structure(world: &TwoLevel) -> &Structure {
    world.objects()[0].structure()
}

fn check_structure(world: &TwoLevel, mesh: &Mesh) -> Result<(), String> {
    match structure(world) {
        Structure::None => Err("nothing is built".into()),
        Structure::Bvh(bvh) => validate(bvh, mesh),
        Structure::Grid(grid) => grid.validate(mesh),
        Structure::Lazy(lazy) => validate_lazy(lazy, mesh),
        Structure::Field(field) => field.validate(mesh),
        // Its tree is made by rays, which say whether it is right.
        Structure::Bsp(_) => Ok(()),
    }
}

/// Answers of all rays, one by one and many at a time, from several threads that begin at different places.
fn check_rays(world: &TwoLevel, rays: &[Ray], expected: &[Option<Hit>], what: &str) {
    const THREADS: usize = 3;
    let answer = |thread: usize| {
        let tracer = Tracer::new(world);
        let start = thread * rays.len() / THREADS;
        let order: Vec<usize> = (start..rays.len()).chain(0..start).collect();
        let check = |i: usize, hit: &Option<Hit>, how: &str| {
            assert_eq!(bits(hit), bits(&expected[i]), "{hit:?} is not {:?}: {what}, {how}, {:?}", expected[i], rays[i]);
        };
        if thread == 0 {
            for &i in &order {
                check(i, &tracer.intersect(&rays[i]), "one by one");
                assert_eq!(tracer.occluded(&rays[i]), expected[i].is_some(), "occluded, {what}, {:?}", rays[i]);
            }
        } else {
            let turned: Vec<Ray> = order.iter().map(|&i| rays[i]).collect();
            let hits = tracer.intersect_many(&turned);
            order.iter().zip(&hits).for_each(|(&i, hit)| check(i, hit, "many at a time"));
            let mut occluded = vec![false; rays.len()];
            tracer.occluded_many(&turned, &mut occluded);
            for (&i, found) in order.iter().zip(&occluded) {
                assert_eq!(*found, expected[i].is_some(), "occluded many, {what}, {:?}", rays[i]);
            }
        }
    };
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..THREADS).map(|i| scope.spawn(move || answer(i))).collect();
        for thread in threads {
            if let Err(panic) = thread.join() {
                std::panic::resume_unwind(panic);
            }
        }
    });
}

/// A world for each strategy, and one pool for all.
struct Bench {
    pool: Pool,
    worlds: Vec<(Strategy, TwoLevel)>,
}

impl Bench {
    fn new(threads: usize, strategies: impl Iterator<Item = Strategy>) -> Self {
        let world = |strategy| {
            let mut world = TwoLevel::new(Level::detect());
            world.force_strategy(Some(strategy));
            (strategy, world)
        };
        Self { pool: Pool::new(Some(threads)).expect("worker threads"), worlds: strategies.map(world).collect() }
    }
}

fn unstructured(mesh: Mesh) -> World {
    let turned = Affine3A::from_scale_rotation_translation(
        Vec3::splat(0.5),
        Quat::from_rotation_y(0.7),
        Vec3::new(1.5, 0.2, -0.3),
    );
    let mut world = World::new(vec![mesh], vec![(1, Affine3A::IDENTITY), (1, turned)]);
    world.scene.apply(Command::SetMotion { name: 1, motion: Motion::Unstructured });
    world
}

#[test]
fn every_strategy_follows_every_sequence() {
    let seed = Random::seed(41);
    let mut random = Random::new(seed);
    let mut hits = 0;
    for Sequence { name, mesh, mut next } in sequences(&mut random) {
        let mut world = unstructured(mesh);
        let mut bench = Bench::new(2, strategies());
        for frame in 0..FRAMES {
            let positions = next(frame, &mut random);
            world.scene.apply(Command::UpdatePositions { name: 1, first: 0, positions });
            let mesh = &world.scene.objects[&1].mesh;
            let triangles: Vec<[Vec3; 3]> = (0..mesh.triangles.len() as u32).map(|p| mesh.corners(p)).collect();
            let rays = rays(&mut random, &triangles, RAYS);
            let fresh = world.build(&bench.pool, Strategy::Sah, Level::detect(), TopLevelKind::Bvh);
            let tracer = Tracer::new(&fresh);
            let expected: Vec<Option<Hit>> = rays.iter().map(|ray| tracer.intersect(ray)).collect();
            hits += expected.iter().flatten().count();
            for (ray, hit) in rays.iter().zip(&expected).take(12).filter(|(ray, _)| !is_rescaled(ray)) {
                let brute = world.brute_force(&fresh, ray);
                assert_eq!(bits(hit), bits(&brute), "seed {seed}, {name}, frame {frame}, {ray:?}");
            }
            for (strategy, built) in &mut bench.worlds {
                let what = format!("seed {seed}, {name}, {}, frame {frame}", strategy.name());
                let stats = bench.pool.install(|| built.update(&world.scene, &world.instances));
                assert_eq!(stats.out_of_memory, 0, "{what}");
                check_rays(built, &rays, &expected, &what);
                check_structure(built, mesh).unwrap_or_else(|e| panic!("{what}: {e}"));
            }
        }
    }
    assert!(hits > 5000, "{hits} hits: the test has lost its teeth");
}

/// Everything that traversal sees of a tree.
fn picture(bvh: &Bvh) -> Vec<u32> {
    let nodes = bvh.nodes().iter().flat_map(|n| {
        n.children.iter().map(|c| c.to_bits()).chain(n.bounds.iter().flatten().map(|x| x.to_bits())).collect::<Vec<_>>()
    });
    nodes.chain(bvh.blocks().iter().flat_map(|b| b.prims)).collect()
}

/// Large enough that builders and updates cut it into tasks.
#[test]
fn structures_do_not_depend_on_the_number_of_threads() {
    let seed = Random::seed(42);
    let mut random = Random::new(seed);
    let mut world = unstructured(meshes::soup(&mut random, 30_000, 0.02));
    let trees = strategies().filter(|s| !matches!(s, Strategy::Bsp | Strategy::Lazy | Strategy::VisibilityField));
    let mut benches = [1, 4].map(|threads| Bench::new(threads, trees.clone()));
    let mut positions = world.scene.objects[&1].mesh.positions.clone();
    for frame in 0..8 {
        let speed = |i: usize| Vec3::new(((i / 3 * 7) % 13) as f32, ((i / 3 * 5) % 11) as f32, 3.0) * 0.01 - 0.05;
        positions.iter_mut().enumerate().for_each(|(i, p)| *p += speed(i));
        world.scene.apply(Command::UpdatePositions { name: 1, first: 0, positions: positions.clone() });
        for bench in &mut benches {
            for (_, built) in &mut bench.worlds {
                bench.pool.install(|| built.update(&world.scene, &world.instances));
            }
        }
        let [one, four] = &benches;
        for ((strategy, a), (_, b)) in one.worlds.iter().zip(&four.worlds) {
            let what = format!("{} at frame {frame}", strategy.name());
            match (structure(a), structure(b)) {
                (Structure::Bvh(a), Structure::Bvh(b)) => assert!(picture(a) == picture(b), "{what}"),
                (Structure::Grid(a), Structure::Grid(b)) => assert!(a == b, "{what}"),
                other => panic!("{what}: {other:?}"),
            }
            check_structure(a, &world.scene.objects[&1].mesh).unwrap_or_else(|e| panic!("seed {seed}, {what}: {e}"));
        }
    }
}

/// Triangles that fly straight on and bounce off the walls of a box, for as long as one likes.
#[test]
fn ten_thousand_frames_cost_no_memory_and_no_quality() {
    const FRAMES: u32 = 10_000;
    const COUNT: usize = 300;
    let seed = Random::seed(43);
    let mut random = Random::new(seed);
    let mesh = meshes::soup(&mut random, COUNT, 0.05);
    let shape: Vec<Vec3> = (0..3 * COUNT).map(|i| mesh.positions[i] - mesh.positions[i / 3 * 3]).collect();
    let mut balls: Vec<(Vec3, Vec3)> = (0..COUNT).map(|i| (mesh.positions[3 * i], random.vec() * 0.05)).collect();
    let mut world = unstructured(mesh);
    let mut bench = Bench::new(1, strategies());
    let mut most_bytes = vec![0; bench.worlds.len()];
    let mut worst_cost = vec![0.0f64; bench.worlds.len()];
    for frame in 0..FRAMES {
        for (at, speed) in &mut balls {
            *at += *speed;
            for axis in 0..3 {
                if at[axis].abs() > 1.0 {
                    speed[axis] = -speed[axis].copysign(at[axis]);
                }
            }
        }
        let positions = (0..3 * COUNT).map(|i| balls[i / 3].0 + shape[i]).collect();
        world.scene.apply(Command::UpdatePositions { name: 1, first: 0, positions });
        let mesh = &world.scene.objects[&1].mesh;
        let look = frame % 100 == 99;
        let fresh = if look { build_sah(mesh).expect("memory").sah_cost() } else { 0.0 };
        let some_rays = if look { rays(&mut random, &[mesh.corners(0), mesh.corners(77)], 8) } else { Vec::new() };
        for (i, (strategy, built)) in bench.worlds.iter_mut().enumerate() {
            let what = format!("seed {seed}, {}, frame {frame}", strategy.name());
            // A BSP is built by the first ray; the others work every frame.
            if *strategy == Strategy::Bsp && !look {
                continue;
            }
            let stats = bench.pool.install(|| built.update(&world.scene, &world.instances));
            for ray in some_rays.iter().filter(|ray| !is_rescaled(ray)) {
                let hit = Tracer::new(built).intersect(ray);
                assert_eq!(bits(&hit), bits(&world.brute_force(built, ray)), "{what}, {ray:?}");
            }
            if frame < FRAMES / 10 {
                most_bytes[i] = most_bytes[i].max(stats.bytes);
            } else {
                assert!(
                    stats.bytes <= most_bytes[i] * 5 / 4,
                    "{what}: {} bytes, {} before",
                    stats.bytes,
                    most_bytes[i]
                );
            }
            if let (Structure::Bvh(bvh), true) = (structure(built), look) {
                assert!(bvh.depth() <= MAX_DEPTH, "{what}: depth {}", bvh.depth());
                worst_cost[i] = worst_cost[i].max(bvh.sah_cost() / fresh);
            }
        }
    }
    for ((strategy, _), worst) in bench.worlds.iter().zip(&worst_cost) {
        println!("{:10} {worst:.3} of the cost of a fresh tree at most", strategy.name());
        if let Some(limit) = promised(*strategy) {
            assert!(
                *worst <= limit + 1e-9,
                "{}: {worst} of the cost of a fresh tree, {limit} was promised",
                strategy.name()
            );
        }
    }
}
