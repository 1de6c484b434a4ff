//! `-- toplevel`: the time to place instances whose matrices have all changed.
//!
//! Ours is the whole of [`TwoLevel::update`] with unchanged objects: inverse matrices, world boxes, top-level structure. Of Embree two figures are
//! given: committing the top scene alone, and with the calls that set and commit the matrices, which do part of the same work.
//! 161 and 661 instances are those of S2 and S3, more are small spheres all over a cube.

use crate::embree::{Embree, PeerScene, Quality, SCENE_DYNAMIC};
use crate::measure::Cost;
use crate::meshes::uv_sphere;
use crate::options::Options;
use crate::ours::Ours;
use crate::random::Random;
use crate::rays::View;
use crate::scenes::{self, BenchScene, Part, Placement};
use glam::{Affine3A, Quat, Vec3};
use openrt::scene::{Instance, Motion};
use openrt::threads::Pool;

const THREADS: [usize; 2] = [1, 2];

pub fn run(options: &Options, embree: Option<&Embree>) -> String {
    let mut scenes = vec![scenes::ALL[1].1(), scenes::ALL[2].1(), many(10_000), many(100_000)];
    scenes.retain(|s| options.wants_scene(s.name));
    println!("milliseconds of the busiest thread to place all instances anew, best of the rounds");
    println!(
        "{:>9} {:>7} | {:>8} | {:>9} {:>9} {:>9} {:>9} | {:>7} {:>13}",
        "instances", "threads", "ours", "med", "med+mat", "low", "low+mat", "ratio", "with matrices"
    );
    let mut json = Vec::new();
    let mut worst: Option<(f64, String)> = None;
    for bench in &scenes {
        let count = (bench.place)(0).len();
        // About a second per cell.
        let rounds = (300_000 / count).clamp(5, 400) / if options.quick { 2 } else { 1 };
        for threads in THREADS {
            let ours = time_ours(bench, threads, rounds);
            let mut line = format!("{count:>9} {threads:>7} | {:>8.3}", ours * 1e3);
            let mut cells = format!(r#""instances": {count}, "threads": {threads}, "ours_ms": {:.4}"#, ours * 1e3);
            if let Some(embree) = embree {
                let medium = time_peer(embree, bench, threads, rounds, Quality::Medium, 0);
                let low = time_peer(embree, bench, threads, rounds, Quality::Low, SCENE_DYNAMIC);
                let ratio = medium.0.min(low.0) / ours;
                let with_matrices = medium.1.min(low.1) / ours;
                for (name, seconds) in [("med", medium.0), ("med_mat", medium.1), ("low", low.0), ("low_mat", low.1)] {
                    line += &format!("{}{:>9.3}", if name == "med" { " | " } else { " " }, seconds * 1e3);
                    cells += &format!(r#", "{name}_ms": {:.4}"#, seconds * 1e3);
                }
                line += &format!(" | {ratio:>7.2} {with_matrices:>13.2}");
                if worst.as_ref().is_none_or(|(w, _)| ratio < *w) {
                    worst = Some((ratio, format!("{count} instances, {threads} thread(s)")));
                }
            }
            println!("{line}");
            json.push(format!("  {{{cells}}}"));
        }
    }
    match worst {
        Some((ratio, what)) => println!("worst ratio {ratio:.2} ({what})"),
        None => println!("worst ratio - (no peer)"),
    }
    format!("[\n{}\n]\n", json.join(",\n"))
}

/// Spheres that overlap a little, each turned and scaled, and elsewhere in every frame.
fn many(count: usize) -> BenchScene {
    let place = move |frame: u32| {
        let mut random = Random::new(u64::from(frame) + 11);
        let size = 0.8 / (count as f32).cbrt();
        let one = |_| {
            let turn = Quat::from_rotation_y(random.unit() * 6.0) * Quat::from_rotation_x(random.unit() * 6.0);
            let scale = Vec3::splat(size * (0.5 + random.unit()));
            let transform = Affine3A::from_scale_rotation_translation(scale, turn, random.vec());
            Placement { part: 0, transform }
        };
        (0..count).map(one).collect()
    };
    BenchScene {
        name: if count > 10_000 { "100K" } else { "10K" },
        title: "spheres all over a cube",
        parts: vec![Part::rigid(uv_sphere(8, 12), Motion::Affine)],
        place: Box::new(place),
        instanced: true,
        view: View { eye: Vec3::Z * 3.0, at: Vec3::ZERO, degrees: 45.0 },
        light: Vec3::splat(5.0),
        sizes: vec![[640, 480]],
    }
}

fn placed(bench: &BenchScene, frame: u32) -> Vec<Instance> {
    let one = |p: Placement| Instance::new(p.part as u32 + 1, p.transform);
    (bench.place)(frame).into_iter().map(one).collect()
}

/// Least processor time of the busiest thread over the rounds.
fn time_ours(bench: &BenchScene, threads: usize, rounds: usize) -> f64 {
    let pool = Pool::new(Some(threads)).expect("worker threads start");
    let mut ours = Ours::new(bench, 0, &pool);
    let frames = [1, 2].map(|frame| placed(bench, frame));
    let mut best = f64::INFINITY;
    for round in 0..rounds {
        let (scene, world, instances) = (&ours.scene, &mut ours.world, &frames[round % 2]);
        // Inside of the pool, where a renderer would be.
        let (cost, stats) = pool.install(|| Cost::of(|| world.update(scene, instances)));
        assert_eq!((stats.objects_built, stats.out_of_memory), (0, 0), "only matrices changed");
        best = best.min(cost.busiest);
    }
    best
}

/// The same for a commit alone, and for a commit with the matrices set.
fn time_peer(
    embree: &Embree,
    bench: &BenchScene,
    threads: usize,
    rounds: usize,
    quality: Quality,
    flags: i32,
) -> (f64, f64) {
    let device = embree.device(threads);
    let parts: Vec<PeerScene> = bench
        .parts
        .iter()
        .map(|part| {
            let mut scene = device.scene(Quality::Medium, 0);
            scene.add_mesh(&(part.positions)(0), &part.triangles, Quality::Medium);
            scene.commit();
            scene
        })
        .collect();
    let mut top = device.scene(quality, flags);
    for placement in (bench.place)(0) {
        top.add_instance(&parts[placement.part], &placement.transform);
    }
    top.commit();
    let frames = [1, 2].map(|frame| (bench.place)(frame));
    let (mut commit, mut whole) = (f64::INFINITY, f64::INFINITY);
    for round in 0..rounds {
        let (matrices, ()) = Cost::of(|| {
            for (i, placement) in frames[round % 2].iter().enumerate() {
                top.move_instance(i, &placement.transform);
            }
        });
        let (cost, ()) = Cost::of(|| top.commit());
        commit = commit.min(cost.busiest);
        whole = whole.min(matrices.busiest + cost.busiest);
    }
    device.check();
    (commit, whole)
}
