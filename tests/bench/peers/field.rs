//! `-- field`: the visibility field (Khanna04) beside the BSP, which the paper compares it with, and the BVH.
//!
//! *Resting*: single rays in the first frames of S1, S4 and S6, after two passes in which subfields are made; what these hold. *Moving*, after the paper's figure 2: a room
//! that rests and more and more bodies of 564 triangles that swim through it, milliseconds per frame for update and for primary and shadow rays. One thread, processor
//! time, all variants in turn.

use crate::measure::thread_seconds;
use crate::options::Options;
use crate::random::Random;
use crate::rays::{self, Kind, View};
use crate::{meshes, ours::Ours, scenes};
use glam::{Affine3A, Vec3};
use openrt::accel::{Structure, TwoLevel};
use openrt::scene::{Command, Instance, Mesh, Motion, Scene, Strategy};
use openrt::simd::Level;
use openrt::threads::Pool;
use openrt::trace::{Ray, Tracer};

const STRATEGIES: [Strategy; 3] = [Strategy::VisibilityField, Strategy::Bsp, Strategy::Sah];
const SIZE: [u32; 2] = [320, 240];
const FRAMES: u32 = 12;

pub fn run(options: &Options) -> String {
    let pool = Pool::new(Some(1)).expect("a worker thread starts");
    let mut json = Vec::new();
    println!("{:14}{:>12}{:>10}{:>10}{:>10}   Mrays/s, one by one", "resting", "", "field", "bsp", "sah");
    for (name, make) in scenes::ALL.into_iter().filter(|(name, _)| ["S1", "S4", "S6"].contains(name)) {
        if options.wants_scene(name) {
            resting(&make(), options, &pool, &mut json);
        }
    }
    if options.wants_scene("FIGURE2") {
        moving(&pool, options, &mut json);
    }
    format!("[\n{}\n]\n", json.join(",\n"))
}

fn resting(bench: &scenes::BenchScene, options: &Options, pool: &Pool, json: &mut Vec<String>) {
    let ours = Ours::new(bench, 0, pool);
    let worlds = STRATEGIES.map(|strategy| {
        let mut world = TwoLevel::new(Level::detect());
        world.force_strategy(Some(strategy));
        pool.install(|| world.update(&ours.scene, &ours.instances));
        world
    });
    let primary = rays::primary(&bench.view, if options.quick { SIZE } else { [640, 480] });
    let (shadow, bounce) = rays::secondary(&ours, &primary, bench.light, 1e-4 * bench.view.eye.distance(bench.view.at));
    for (kind, rays) in [(Kind::Primary, &primary), (Kind::Shadow, &shadow), (Kind::Bounce, &bounce)] {
        if !options.wants_kind(kind) {
            continue;
        }
        let mut best = [f64::INFINITY; 3];
        let mut hits = [0; 3];
        for pass in 0..5 {
            for ((world, best), hits) in worlds.iter().zip(&mut best).zip(&mut hits) {
                let tracer = Tracer::new(world);
                let begin = thread_seconds();
                *hits = rays
                    .iter()
                    .filter(
                        |ray| if kind == Kind::Shadow { tracer.occluded(ray) } else { tracer.intersect(ray).is_some() },
                    )
                    .count();
                if pass > 1 {
                    *best = best.min(thread_seconds() - begin);
                }
            }
        }
        assert!(hits.iter().all(|&h| h == hits[0]), "{hits:?}: other pictures");
        let speed = best.map(|seconds| rays.len() as f64 / seconds * 1e-6);
        println!("{:14}{:>12}{:10.3}{:10.3}{:10.3}", bench.name, kind.name(), speed[0], speed[1], speed[2]);
        let [field, bsp, sah] = speed;
        json.push(format!(
            "{{\"scene\":\"{}\",\"kind\":\"{}\",\"field\":{field},\"bsp\":{bsp},\"sah\":{sah}}}",
            bench.name,
            kind.name()
        ));
    }
    let (mut subfields, mut refs) = (0, 0);
    for object in worlds[0].objects() {
        if let Structure::Field(field) = object.structure() {
            let held = field.size().resting;
            (subfields, refs) = (subfields + held.0, refs + held.1);
        }
    }
    let bytes = |world: &TwoLevel| world.objects().iter().map(|o| o.memory_bytes()).sum::<usize>() as f64 / 1048576.0;
    let bytes = [0, 1, 2].map(|i| bytes(&worlds[i]));
    println!(
        "{:14}{:>12}{:10.1}{:10.1}{:10.1}   {subfields} subfields, {:.1} references per triangle in each",
        "",
        "MiB",
        bytes[0],
        bytes[1],
        bytes[2],
        refs as f64 / subfields.max(1) as f64 / bench.triangles() as f64
    );
}

/// How a variant keeps the room and the bodies.
const VARIANTS: [(&str, bool, Strategy, Strategy); 5] = [
    ("field", true, Strategy::VisibilityField, Strategy::VisibilityField),
    ("two fields", false, Strategy::VisibilityField, Strategy::VisibilityField),
    ("bsp", false, Strategy::Bsp, Strategy::Bsp),
    ("sah, fast", false, Strategy::Sah, Strategy::FastBuild),
    ("sah, refit", false, Strategy::Sah, Strategy::Refit),
];

/// A room of about 50,000 triangles.
fn room() -> Mesh {
    let mut random = Random::new(77);
    let mut all = Vec::new();
    for _ in 0..40 {
        let (at, size) = (random.vec() * 0.9, 0.05 + 0.1 * random.unit());
        let ball = meshes::moved(meshes::icosphere(3), |p| at + p * size);
        all.extend((0..ball.triangles.len() as u32).map(|prim| ball.corners(prim)));
    }
    for k in 0..3 {
        let [n, u, v] = [k, (k + 1) % 3, (k + 2) % 3].map(|k| Vec3::AXES[k]);
        for n in if k == 2 { vec![-n] } else { vec![n, -n] } {
            all.push([n - u - v, n + u - v, n + u + v]);
            all.push([n - u - v, n + u + v, n - u + v]);
        }
    }
    meshes::mesh(all)
}

fn moving(pool: &Pool, options: &Options, json: &mut Vec<String>) {
    let room = room();
    let body = meshes::moved(meshes::uv_sphere(7, 47), |p| p * Vec3::new(0.16, 0.05, 0.05));
    let view = View { eye: Vec3::new(0.1, 0.2, 2.4), at: Vec3::ZERO, degrees: 50.0 };
    let primary = rays::primary(&view, SIZE);
    println!("\n{:10}{:>10}   update + trace, ms per frame (subfields)", "bodies", "triangles");
    println!("{:20}{}", "", VARIANTS.map(|v| format!("{:>21}", v.0)).join(""));
    for bodies in [0usize, 1, 2, 4, 8, 16, 32, 64] {
        if options.quick && bodies > 16 {
            continue;
        }
        let at = |frame: u32| -> Vec<Vec3> {
            let swim = |i: usize, p: Vec3| {
                let phase = i as f32 * 2.4 + frame as f32 * 0.05;
                let wave = Vec3::Y * (0.02 * (p.x * 20.0 + phase * 8.0).sin());
                let place = Vec3::new(phase.cos() * 0.7, (i as f32 * 0.61).sin() * 0.8, (phase * 0.7).sin() * 0.7);
                place + p + wave
            };
            (0..bodies).flat_map(|i| body.positions.iter().map(move |&p| swim(i, p)).collect::<Vec<_>>()).collect()
        };
        let count = body.positions.len() as u32;
        let triangles: Vec<[u32; 3]> =
            (0..bodies as u32).flat_map(|i| body.triangles.iter().map(move |t| t.map(|v| v + i * count))).collect();
        let mut line = String::new();
        let mut seen = None;
        for (name, one, still, swim) in VARIANTS {
            let mut scene = Scene::default();
            let offset = if one { room.positions.len() as u32 } else { 0 };
            let bodies_mesh = Mesh {
                positions: room.positions.iter().copied().take(offset as usize).chain(at(0)).collect(),
                triangles: room
                    .triangles
                    .iter()
                    .copied()
                    .take(if one { room.triangles.len() } else { 0 })
                    .chain(triangles.iter().map(|t| t.map(|v| v + offset)))
                    .collect(),
                ..Mesh::default()
            };
            let mut instances = Vec::new();
            for (name, mesh, strategy, shown) in [(1, room.clone(), still, !one), (2, bodies_mesh, swim, true)] {
                scene.apply(Command::DefineObject {
                    name,
                    mesh,
                    motion: if name == 1 { Motion::Affine } else { Motion::Unstructured },
                });
                scene.apply(Command::SetStrategy { name, strategy });
                if shown {
                    instances.push(Instance::new(name, Affine3A::IDENTITY));
                }
            }
            let mut world = TwoLevel::new(Level::detect());
            let (mut updates, mut traces, mut hits) = (Vec::new(), Vec::new(), 0);
            for frame in 0..FRAMES {
                scene.apply(Command::UpdatePositions { name: 2, first: offset, positions: at(frame) });
                pool.install(|| {
                    let begin = thread_seconds();
                    world.update(&scene, &instances);
                    let middle = thread_seconds();
                    hits += trace(&world, &primary);
                    updates.push(middle - begin);
                    traces.push(thread_seconds() - middle);
                });
            }
            assert_eq!(*seen.get_or_insert(hits), hits, "{name} sees another picture");
            // The first frames build, and make subfields.
            let median = |times: &[f64]| {
                let mut times = times[4..].to_vec();
                times.sort_by(f64::total_cmp);
                times[times.len() / 2] * 1e3
            };
            let (update, trace) = (median(&updates), median(&traces));
            let fields = world.objects().iter().map(|object| match object.structure() {
                Structure::Field(field) => field.size().resting.0 + field.size().moving.0,
                _ => 0,
            });
            let fields: usize = fields.sum();
            line += &format!("{:>21}", format!("{update:.2} + {trace:.1} ({fields})"));
            json.push(format!("{{\"bodies\":{bodies},\"variant\":\"{name}\",\"update_ms\":{update},\"trace_ms\":{trace},\"subfields\":{fields}}}"));
        }
        println!("{bodies:<10}{:>10}{line}", triangles.len());
    }
}

/// Primary rays and their shadow rays, one by one as the paper traces them; how many of both hit.
fn trace(world: &TwoLevel, primary: &[Ray]) -> usize {
    let tracer = Tracer::new(world);
    let light = Vec3::new(0.3, 0.9, 0.8);
    let mut count = 0;
    for ray in primary {
        let Some(hit) = tracer.intersect(ray) else { continue };
        let at = ray.origin + ray.direction * (hit.t * 0.9999);
        count += 1 + usize::from(tracer.occluded(&Ray { tmax: 1.0, ..Ray::new(at, light - at) }));
    }
    count
}
