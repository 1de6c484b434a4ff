//! `-- splits`: what spatial splits give and cost, on one thread, against our own binned SAH.
//!
//! Meshes that have nothing to gain (S1, S4), a tree of S3, and two made for the purpose: a *frame* of beams in all directions with small things between
//! them, as buildings are, and *needles*. Rays start anywhere in the scene's box in any direction, as bounces do; and from a camera.

use crate::measure::{Column, Cost, Lane, race};
use crate::options::Options;
use crate::ours::{ClosestWorker, MODES};
use crate::places::add;
use crate::random::Random;
use crate::rays::{self, View};
use crate::{meshes, scenes};
use glam::{Affine3A, Vec3};
use openrt::accel::{Structure, TwoLevel, build_sah, build_spatial};
use openrt::scene::{Command, Instance, Mesh, Motion, Scene};
use openrt::simd::Level;
use openrt::threads::Pool;
use openrt::trace::{Ray, Tracer};

const ROUNDS: usize = 5;
const QUICK_ROUNDS: usize = 3;
const RAYS: usize = 200_000;

pub fn run(options: &Options) -> String {
    let pool = Pool::new(Some(1)).expect("a worker thread starts");
    let rounds = if options.quick { QUICK_ROUNDS } else { ROUNDS };
    println!(
        "{:8} {:>9} {:>6} {:>6} {:>6} | {:>9} {:>9} {:>6} | {:>6} | {:>7} {:>7} {:>7} {:>7}",
        "",
        "triangles",
        "cost",
        "split",
        "ratio",
        "ns/tri",
        "split",
        "ratio",
        "blocks",
        "camera",
        "many",
        "inside",
        "many"
    );
    let mut json = Vec::new();
    for (name, make) in ALL {
        if options.wants_scene(&name.to_uppercase()) {
            json.push(one(name, make(), &pool, rounds));
        }
    }
    format!("[\n{}\n]\n", json.join(",\n"))
}

type Make = fn() -> Mesh;

const ALL: [(&str, Make); 5] = [
    ("S1", || part("S1", 0)),
    ("S4", || part("S4", 0)),
    ("tree", || part("S3", 1)),
    ("frame", || frame(&mut Random::new(31))),
    ("needles", || needles(&mut Random::new(32))),
];

/// One part of a scene of the bench.
pub fn part(scene: &str, number: usize) -> Mesh {
    let (_, make) = scenes::ALL.into_iter().find(|(name, _)| *name == scene).expect("there is such a scene");
    let bench = make();
    let part = &bench.parts[number.min(bench.parts.len() - 1)];
    Mesh { positions: (part.positions)(0), triangles: part.triangles.clone(), ..Mesh::default() }
}

/// 3,000 beams of two triangles per side, and 600 spheres.
pub fn frame(random: &mut Random) -> Mesh {
    let mut all = Mesh::default();
    for _ in 0..3000 {
        let along = random.vec().normalize_or(Vec3::X);
        let turn = glam::Quat::from_rotation_arc(Vec3::X, along);
        let size = Vec3::new(0.1 + random.unit(), 0.005, 0.01);
        let place = Affine3A::from_scale_rotation_translation(size, turn, random.vec() * 3.0);
        add(&mut all, &meshes::cube(), place);
    }
    for _ in 0..600 {
        let place = Affine3A::from_translation(random.vec() * 3.0) * Affine3A::from_scale(Vec3::splat(0.05));
        add(&mut all, &meshes::icosphere(2), place);
    }
    all
}

/// 50,000 long thin triangles.
pub fn needles(random: &mut Random) -> Mesh {
    meshes::mesh((0..50_000).map(|_| {
        let at = random.vec();
        [at, at + random.vec() * 0.3, at + random.vec() * 0.004]
    }))
}

fn one(name: &str, mesh: Mesh, pool: &Pool, rounds: usize) -> String {
    let count = mesh.triangles.len();
    let mut seconds = [f64::INFINITY; 2];
    let mut cost = [0.0; 2];
    let mut blocks = [0; 2];
    for _ in 0..rounds {
        for (which, build) in [build_sah, build_spatial].into_iter().enumerate() {
            let (took, bvh) = Cost::of(|| pool.install(|| build(&mesh)).expect("memory for a tree"));
            seconds[which] = seconds[which].min(took.all);
            (cost[which], blocks[which]) = (bvh.sah_cost(), bvh.blocks().len());
        }
    }
    let worlds = [false, true].map(|splits| world(&mesh, pool, splits));
    let Structure::Bvh(bvh) = worlds[0].objects()[0].structure() else { panic!("there is a tree") };
    let bounds = bvh.bounds();
    let (center, size) = (bounds.center(), bounds.extent());
    let view = View { eye: center + size * Vec3::new(0.7, 0.4, 1.1), at: center, degrees: 40.0 };
    let mut random = Random::new(5);
    let inside: Vec<Ray> =
        (0..RAYS).map(|_| Ray::new(center + random.vec() * size * 0.5, random.vec().normalize_or(Vec3::X))).collect();
    let mut gains = Vec::new();
    for rays in [rays::primary(&view, [512, 384]), inside] {
        for mode in MODES {
            let lane = |world| {
                Lane::new(mode.name, Column::OursSingle, move || {
                    Box::new(ClosestWorker {
                        tracer: Tracer::new(world),
                        call: mode.closest,
                        rays: Vec::new(),
                        found: Vec::new(),
                    })
                })
            };
            let mut lanes = [lane(&worlds[0]), lane(&worlds[1])];
            race(&mut lanes, &rays, 1, rounds);
            assert_eq!(lanes[0].hits, lanes[1].hits, "the same rays hit");
            gains.push(lanes[0].seconds / lanes[1].seconds);
        }
    }
    let per = seconds.map(|s| s * 1e9 / count as f64);
    println!(
        "{name:8} {count:>9} {:>6.1} {:>6.1} {:>6.2} | {:>9.1} {:>9.1} {:>6.1} | {:>6.2} | {:>7.2} {:>7.2} {:>7.2} {:>7.2}  rays/s with over without",
        cost[0],
        cost[1],
        cost[1] / cost[0],
        per[0],
        per[1],
        per[1] / per[0],
        blocks[1] as f64 / blocks[0] as f64,
        gains[0],
        gains[1],
        gains[2],
        gains[3]
    );
    format!(
        r#"  {{"scene": "{name}", "triangles": {count}, "cost": {:.3}, "cost_split": {:.3}, "ns": {:.1}, "ns_split": {:.1}, "gains": {gains:?}}}"#,
        cost[0], cost[1], per[0], per[1]
    )
}

/// The mesh as a static object.
fn world(mesh: &Mesh, pool: &Pool, splits: bool) -> TwoLevel {
    let mut scene = Scene::default();
    scene.apply(Command::DefineObject { name: 1, mesh: mesh.clone(), motion: Motion::Static });
    scene.apply(Command::SetSpatialSplits { name: 1, wanted: splits });
    let mut world = TwoLevel::new(Level::detect());
    pool.install(|| world.update(&scene, &[Instance::new(1, Affine3A::IDENTITY)]));
    world
}
