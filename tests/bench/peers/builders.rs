//! `-- build`: what structures cost to make and to keep.
//!
//! Each scene is taken as one mesh. One thread is measured in processor time, two in wall time; beside the latter stands the
//! processor time of the busier thread, from which the speed-up and the ratio are taken: it is what the wall time would be on a quiet machine. Peers are what
//! each of our builders competes with: Embree's medium quality against SAH, its low quality (Morton order) against the fast
//! build, refit against refit. Neither engine pays for the mesh itself, nor for freeing the structure before.

use crate::embree::{Device, Embree, PeerScene, Quality, SCENE_DYNAMIC};
use crate::measure::Cost;
use crate::options::Options;
use crate::scenes::{self, BenchScene};
use openrt::accel::{self, Bsp, Bvh, Refit, SweepScratch};
use openrt::scene::Mesh;
use openrt::threads::Pool;

/// Builds per row and number of threads.
const ROUNDS: usize = 7;
const QUICK_ROUNDS: usize = 3;
const SCENES: [&str; 3] = ["S1", "S5", "S6"];
const THREADS: [usize; 2] = [1, 2];

/// What one builder did to one mesh.
struct Row {
    name: &'static str,
    /// Of the peer's builder that it is compared with.
    against: Option<&'static str>,
    /// Best seconds on one and two threads.
    seconds: [f64; 2],
    /// Least processor time of the busier of two threads.
    busiest: f64,
    sah: Option<f64>,
    bytes: f64,
}

impl Row {
    fn new(name: &'static str, against: Option<&'static str>) -> Row {
        Row { name, against, seconds: [f64::INFINITY; 2], busiest: f64::INFINITY, sah: None, bytes: 0.0 }
    }

    /// Times `f` on 1 or 2 threads (`at` 0 or 1) and keeps the best.
    fn time<R>(&mut self, at: usize, f: impl FnOnce() -> R) -> R {
        let (cost, result) = Cost::of(f);
        if at == 0 {
            self.seconds[0] = self.seconds[0].min(cost.all);
        } else {
            self.seconds[1] = self.seconds[1].min(cost.wall);
            self.busiest = self.busiest.min(cost.busiest);
        }
        result
    }
}

pub fn run(options: &Options, embree: Option<&Embree>) -> String {
    let mut json = Vec::new();
    let mut worst: Option<(f64, String)> = None;
    for (name, make) in scenes::ALL {
        if !SCENES.contains(&name) || !options.wants_scene(name) {
            continue;
        }
        let bench = make();
        let rounds = if options.quick { QUICK_ROUNDS } else { ROUNDS };
        let (before, after) = (one_mesh(&bench, 0), one_mesh(&bench, 1));
        let mut rows = our_rows(&before, &after, rounds, options.quick);
        if let Some(embree) = embree {
            rows.extend(peer_rows(embree, &before, &after, rounds));
        }
        print(name, before.triangles.len(), &rows, &mut worst, &mut json);
    }
    match worst {
        Some((ratio, what)) => println!("worst ratio {ratio:.2} ({what})"),
        None => println!("worst ratio - (no peer)"),
    }
    format!("[\n{}\n]\n", json.join(",\n"))
}

/// All parts of a scene without instances in one mesh.
fn one_mesh(bench: &BenchScene, frame: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for part in &bench.parts {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend((part.positions)(frame));
        mesh.triangles.extend(part.triangles.iter().map(|t| t.map(|v| v + first)));
    }
    mesh
}

fn our_rows(before: &Mesh, after: &Mesh, rounds: usize, quick: bool) -> Vec<Row> {
    let mut sah = Row::new("SAH", Some("Embree medium"));
    let mut fast = Row::new("fast build", Some("Embree low"));
    let mut refit = Row::new("refit", Some("Embree refit"));
    let mut bsp = Row::new("BSP", None);
    for (at, threads) in THREADS.into_iter().enumerate() {
        let pool = Pool::new(Some(threads)).expect("worker threads start");
        for _ in 0..rounds {
            let build = |row: &mut Row, f: fn(&Mesh) -> Result<Bvh, accel::OutOfMemory>| {
                let bvh = row.time(at, || pool.install(|| f(before))).expect("memory for a structure");
                row.sah = Some(bvh.sah_cost());
                row.bytes = bvh.memory_bytes() as f64;
                bvh
            };
            build(&mut fast, accel::build_fast);
            let mut bvh = build(&mut sah, accel::build_sah);
            // The second is as in every frame but the first: what it works in is there.
            let mut scratch = SweepScratch::default();
            let warm = pool.install(|| bvh.refit(before, &mut scratch));
            assert_eq!(warm, Ok(Refit::Done));
            let done = refit.time(at, || pool.install(|| bvh.refit(after, &mut scratch)));
            assert_eq!(done, Ok(Refit::Done), "only vertices moved");
            refit.sah = Some(bvh.sah_cost());
            refit.bytes = bvh.memory_bytes() as f64;
        }
        // Slow, and the same every time.
        for _ in 0..if quick { 1 } else { 2 } {
            let tree = bsp.time(at, || {
                pool.install(|| {
                    let bsp = Bsp::new(before, accel::Quality::Sah, None).expect("memory for a structure");
                    assert!(bsp.tree().is_some(), "memory for a tree");
                    bsp
                })
            });
            bsp.bytes = tree.memory_bytes() as f64;
        }
    }
    vec![sah, fast, refit, bsp]
}

fn peer_rows(embree: &Embree, before: &Mesh, after: &Mesh, rounds: usize) -> Vec<Row> {
    let mut medium = Row::new("Embree medium", None);
    let mut high = Row::new("Embree high", None);
    let mut low = Row::new("Embree low", None);
    let mut refit = Row::new("Embree refit", None);
    for (at, threads) in THREADS.into_iter().enumerate() {
        let device = embree.device(threads);
        let build = |row: &mut Row, quality, flags| {
            let mut scene = device.scene(quality, flags);
            scene.add_mesh(&before.positions, &before.triangles, quality);
            let held = Device::bytes_held();
            row.time(at, || scene.commit());
            row.bytes = (Device::bytes_held() - held) as f64;
        };
        for _ in 0..rounds {
            build(&mut medium, Quality::Medium, 0);
            build(&mut high, Quality::High, 0);
            build(&mut low, Quality::Low, 0);
        }
        let mut scene: PeerScene = device.scene(Quality::Low, SCENE_DYNAMIC);
        let held = Device::bytes_held();
        scene.add_mesh(&before.positions, &before.triangles, Quality::Refit);
        scene.commit();
        for round in 0..rounds {
            scene.move_mesh(0, if round % 2 == 0 { &after.positions } else { &before.positions });
            refit.time(at, || {
                scene.touch_mesh(0);
                scene.commit();
            });
        }
        let mesh = before.positions.len() * 12 + before.triangles.len() * 12;
        refit.bytes = (Device::bytes_held() - held) as f64 - mesh as f64;
        drop(scene);
        device.check();
    }
    vec![medium, high, low, refit]
}

fn print(scene: &str, triangles: usize, rows: &[Row], worst: &mut Option<(f64, String)>, json: &mut Vec<String>) {
    println!("{scene} as one mesh of {triangles} triangles");
    println!(
        "    {:14} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}  ns/triangle; Embree's time over ours",
        "", "1 thread", "2 threads", "busier", "speed-up", "SAH cost", "bytes/tri"
    );
    let per = 1e9 / triangles as f64;
    for row in rows {
        let [one, two] = row.seconds;
        let peer = row.against.and_then(|name| rows.iter().find(|r| r.name == name));
        let ratios = peer.map(|p| [p.seconds[0] / one, p.busiest / row.busiest]);
        println!(
            "    {:14} {:>9.1} {:>9.1} {:>9.1} {:>9.2} {:>9} {:>9.1}  {}",
            row.name,
            one * per,
            two * per,
            row.busiest * per,
            one / row.busiest,
            row.sah.map_or_else(|| "-".to_owned(), |c| format!("{c:.2}")),
            row.bytes / triangles as f64,
            ratios.map_or_else(String::new, |[a, b]| format!("{a:.2} {b:.2}"))
        );
        if let Some(ratio) = ratios.map(|[a, b]| a.min(b))
            && worst.as_ref().is_none_or(|(w, _)| ratio < *w)
        {
            *worst = Some((ratio, format!("{scene}, {}", row.name)));
        }
        json.push(format!(
            r#"  {{"scene": "{scene}", "triangles": {triangles}, "builder": "{}", "ns_1": {:.2}, "ns_2": {:.2}, "busier_of_2": {:.2}, "sah": {}, "bytes": {:.1}}}"#,
            row.name,
            one * per,
            two * per,
            row.busiest * per,
            row.sah.map_or_else(|| "null".to_owned(), |c| format!("{c:.3}")),
            row.bytes / triangles as f64
        ));
    }
}
