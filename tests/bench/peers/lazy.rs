//! `-- lazy`: complete refits against updates by the rays, after Larsson03 table 1, and partial updates.
//!
//! Nine deforming bodies (S5) over all frames: primary rays and a shadow ray from each hit, at 640×480 and at what 5×5 and 10×10 sub-sampling leave of it. One
//! thread, processor time, all variants in turn at each frame. `update` is what happens before the first ray; what rays update is in `trace`.
//! Then the mesh of S1, of which the vertices of some 500 neighbouring triangles move per frame.

use crate::measure::thread_seconds;
use crate::options::Options;
use crate::rays;
use crate::scenes::{self, BenchScene, FRAMES};
use glam::{Affine3A, Vec3};
use openrt::accel::TwoLevel;
use openrt::scene::{Command, Instance, LazyShape, Mesh, Motion, Scene, Strategy};
use openrt::simd::Level;
use openrt::threads::Pool;
use openrt::trace::Tracer;

/// Rays per call, as a job of the renderer has.
const JOB: usize = 4096;

const VARIANTS: [(&str, Strategy, LazyShape); 8] = [
    ("refit", Strategy::Refit, LazyShape { cut: 0, levels: 0 }),
    ("lazy, 256 triangles", Strategy::Lazy, LazyShape { cut: 256, levels: 0 }),
    ("lazy, 2048 triangles", Strategy::Lazy, LazyShape { cut: 2048, levels: 0 }),
    ("lazy, 4096 triangles", Strategy::Lazy, LazyShape { cut: 4096, levels: 0 }),
    ("lazy, 2048, 2 levels", Strategy::Lazy, LazyShape { cut: 2048, levels: 2 }),
    ("lazy, half height", Strategy::Lazy, LazyShape { cut: 0, levels: 0 }),
    ("lazy, half height, 1 level", Strategy::Lazy, LazyShape { cut: 0, levels: 1 }),
    ("lazy, half height, 2 levels", Strategy::Lazy, LazyShape { cut: 0, levels: 2 }),
];

/// Processor seconds of one variant over all frames.
#[derive(Clone, Copy, Default)]
struct Sum {
    update: f64,
    trace: f64,
    subtrees: u64,
    hits: usize,
}

pub fn run(options: &Options) -> String {
    let pool = Pool::new(Some(1)).expect("a worker thread starts");
    let (_, make) = scenes::ALL.into_iter().find(|(name, _)| *name == "S5").expect("S5 is a scene");
    let bodies = make();
    println!("S5 {}: {} triangles, {FRAMES} frames, ms per frame", bodies.title, bodies.triangles());
    let mut json = Vec::new();
    for (name, size) in [("1x1", [640, 480]), ("5x5", [128, 96]), ("10x10", [64, 48])] {
        if options.quick && name == "1x1" {
            continue;
        }
        println!(
            "\n{name:28}{:>9}{:>9}{:>9}{:>10}{:>10}{:>10}",
            "update", "trace", "total", "up x", "total x", "subtrees"
        );
        let sums = animate(&bodies, size, &pool);
        let base = sums[0];
        for ((variant, ..), sum) in VARIANTS.iter().zip(&sums) {
            assert_eq!(sum.hits, base.hits, "{variant} sees another picture");
            let ms = 1e3 / f64::from(FRAMES);
            let total = |s: &Sum| s.update + s.trace;
            println!(
                "{variant:28}{:9.3}{:9.3}{:9.3}{:10.2}{:10.2}{:10}",
                sum.update * ms,
                sum.trace * ms,
                total(sum) * ms,
                base.update / sum.update,
                total(&base) / total(sum),
                sum.subtrees / u64::from(FRAMES)
            );
            json.push(format!(
                "{{\"sampling\":\"{name}\",\"variant\":\"{variant}\",\"update_ms\":{},\"trace_ms\":{}}}",
                sum.update * ms,
                sum.trace * ms
            ));
        }
    }
    sculpt(&pool);
    format!("[{}]", json.join(",\n"))
}

fn animate(bench: &BenchScene, size: [u32; 2], pool: &Pool) -> Vec<Sum> {
    let mut scenes: Vec<Scene> = VARIANTS.iter().map(|_| Scene::default()).collect();
    for (scene, (_, strategy, shape)) in scenes.iter_mut().zip(VARIANTS) {
        for (name, part) in (1..).zip(&bench.parts) {
            let mesh = Mesh { positions: (part.positions)(0), triangles: part.triangles.clone(), ..Mesh::default() };
            scene.apply(Command::DefineObject { name, mesh, motion: part.motion });
            scene.apply(Command::SetStrategy { name, strategy });
            scene.apply(Command::SetLazyShape { name, shape });
        }
    }
    let mut worlds: Vec<TwoLevel> = VARIANTS.iter().map(|_| TwoLevel::new(Level::detect())).collect();
    let mut sums = vec![Sum::default(); VARIANTS.len()];
    let primary = rays::primary(&bench.view, size);
    // Frame 0 builds.
    for frame in 0..=FRAMES {
        let positions: Vec<Vec<Vec3>> = bench.parts.iter().map(|part| (part.positions)(frame % FRAMES)).collect();
        let instances: Vec<Instance> =
            (bench.place)(frame % FRAMES).into_iter().map(|p| Instance::new(p.part as u32 + 1, p.transform)).collect();
        for ((world, scene), sum) in worlds.iter_mut().zip(&mut scenes).zip(&mut sums) {
            for (name, positions) in (1..).zip(&positions) {
                scene.apply(Command::UpdatePositions { name, first: 0, positions: positions.clone() });
            }
            pool.install(|| {
                let begin = thread_seconds();
                world.update(scene, &instances);
                let middle = thread_seconds();
                let tracer = Tracer::new(world);
                let hits =
                    primary.chunks(JOB).map(|rays| rays::with_shadows(&tracer, rays, bench.light)).sum::<usize>();
                let end = thread_seconds();
                if frame > 0 {
                    sum.update += middle - begin;
                    sum.trace += end - middle;
                    sum.subtrees += world.touched().0;
                    sum.hits += hits;
                }
            });
        }
    }
    sums
}

/// A brush that wanders over a large mesh.
fn sculpt(pool: &Pool) {
    let (_, make) = scenes::ALL.into_iter().find(|(name, _)| *name == "S1").expect("S1 is a scene");
    let bench = make();
    let (triangles, start) = (&bench.parts[0].triangles, (bench.parts[0].positions)(0));
    println!("\nS1 with a brush: {} triangles, ms per frame", triangles.len());
    let instances = [Instance::new(1, Affine3A::IDENTITY)];
    for (name, strategy, partial) in [
        ("refit of all", Strategy::Refit, false),
        ("refit of what moved", Strategy::Refit, true),
        ("lazy", Strategy::Lazy, true),
    ] {
        let mut scene = Scene::default();
        let mesh = Mesh { positions: start.clone(), triangles: triangles.clone(), ..Mesh::default() };
        scene.apply(Command::DefineObject { name: 1, mesh, motion: Motion::Unstructured });
        scene.apply(Command::SetStrategy { name: 1, strategy });
        let mut world = TwoLevel::new(Level::detect());
        let mut first = 0.0;
        let mut times = Vec::new();
        for frame in 0..FRAMES {
            let center = start[(frame as usize * 7919) % start.len()];
            // As many as 500 neighbouring triangles have.
            let mut near: Vec<u32> = (0..start.len() as u32).collect();
            near.select_nth_unstable_by(280, |&a, &b| {
                let distance = |v: u32| start[v as usize].distance_squared(center);
                distance(a).total_cmp(&distance(b))
            });
            near.truncate(280);
            let positions: Vec<Vec3> = near.iter().map(|&v| start[v as usize] * 1.01).collect();
            let mut all = start.clone();
            near.iter().zip(&positions).for_each(|(&v, p)| all[v as usize] = *p);
            pool.install(|| {
                let begin = thread_seconds();
                match (frame, partial) {
                    (0, _) => {}
                    (_, true) => scene.apply(Command::MovePositions { name: 1, vertices: near, positions }),
                    (_, false) => scene.apply(Command::UpdatePositions { name: 1, first: 0, positions: all }),
                }
                world.update(&scene, &instances);
                let seconds = thread_seconds() - begin;
                match frame {
                    // Built, and then the ways up the tree made.
                    0 => {}
                    1 => first = seconds,
                    _ => times.push(seconds),
                }
            });
        }
        times.sort_unstable_by(f64::total_cmp);
        println!("{name:28}{:9.4}   the first time {:9.3}", times[times.len() / 2] * 1e3, first * 1e3);
    }
}
