//! `-- dynamic`: milliseconds per frame, update and trace, of scenes that move.
//!
//! One row per strategy of ours and per policy of Embree, all in one run: a frame's vertices are made and handed over untimed; then every
//! row in turn brings its structure up to date and traces the same rays, the primary rays of a picture of 640 × 480 and a shadow ray
//! from each hit. Each row traces in the mode that was its fastest on the frame before the first (single rays, packets, streams).
//! Where the shadow rays begin is found in a world of its own, so that nothing has been reached by a ray when a row's time is taken.
//! A frame that a row needs long for is traced in parts only, evenly spread chunks of rays, and the time multiplied.
//!
//! Embree's policies: a dynamic scene whose meshes are refit, or built anew at low (Morton order) or at medium quality; and a scene
//! without the dynamic flag, built anew as a whole at medium quality. Rows that would take minutes are left out, and the table says so.
//!
//! The ratio of a scene is the time of Embree's best policy over that of `auto`; its *regret*, the time of `auto` over that of our best fixed
//! strategy.

use crate::embree::{Built, Device, Embree, Quality, SCENE_DYNAMIC};
use crate::lanes::{Variant, our_lanes, peer_lanes};
use crate::measure::{CHUNK, Cost, Lane, race};
use crate::options::Options;
use crate::ours::Ours;
use crate::rays::{self, Kind};
use crate::scenes::{self, BenchScene, FRAMES};
use glam::Vec3;
use openrt::accel::TwoLevel;
use openrt::scene::{Command, Strategy};
use openrt::simd::Level;
use openrt::threads::Pool;
use openrt::trace::{Ray, Tracer};
use std::fmt::Write;
use std::ops::Range;

const SCENES: [&str; 6] = ["S4", "S5", "S6", "S7", "CROWD", "SCULPT"];
/// Frames of quick runs, of scenes above a million triangles and of others.
const QUICK_FRAMES: [u32; 2] = [3, 6];
const LARGE: usize = 1_000_000;
/// A kind of ray is traced in parts if it takes longer, in seconds.
const LONG: f64 = 0.15;

struct Policy {
    name: &'static str,
    scene: Quality,
    mesh: Quality,
    flags: i32,
    /// Whether every frame builds everything with care.
    slow: bool,
}

const POLICIES: [Policy; 4] = [
    Policy { name: "Embree refit", scene: Quality::Low, mesh: Quality::Refit, flags: SCENE_DYNAMIC, slow: false },
    Policy { name: "Embree dyn. low", scene: Quality::Low, mesh: Quality::Low, flags: SCENE_DYNAMIC, slow: false },
    Policy { name: "Embree dyn. med", scene: Quality::Medium, mesh: Quality::Medium, flags: SCENE_DYNAMIC, slow: true },
    Policy { name: "Embree full med", scene: Quality::Medium, mesh: Quality::Medium, flags: 0, slow: true },
];

/// Seconds spent, summed over frames.
#[derive(Default)]
struct Tally {
    update: f64,
    trace: f64,
    /// Of the last frame alone.
    last: f64,
    /// Per kind of ray: the fastest mode, and of how many chunks one is traced.
    modes: [Option<usize>; 2],
    strides: [usize; 2],
    hits: [usize; 2],
}

impl Tally {
    fn total(&self) -> f64 {
        self.update + self.trace
    }

    fn begin(&mut self, update: f64) {
        self.update += update;
        self.last = update;
    }

    /// Traces rays of a kind by the fastest of some lanes; gives the seconds.
    fn trace(&mut self, kind: usize, mut lanes: Vec<Lane>, rays: &[Ray], threads: usize) -> f64 {
        let stride = self.strides[kind].max(1);
        let some: Vec<Ray> = rays.chunks(CHUNK).step_by(stride).flatten().copied().collect();
        if let Some(mode) = self.modes[kind] {
            lanes = vec![lanes.swap_remove(mode)];
        }
        race(&mut lanes, &some, threads, 1);
        let fastest = (0..lanes.len()).min_by(|&a, &b| lanes[a].seconds.total_cmp(&lanes[b].seconds));
        let fastest = fastest.expect("a row has a mode");
        self.modes[kind].get_or_insert(fastest);
        let seconds = lanes[fastest].seconds * rays.len() as f64 / some.len().max(1) as f64;
        self.hits[kind] = if stride == 1 { lanes[fastest].hits } else { 0 };
        self.strides[kind] = (seconds / LONG).ceil().clamp(1.0, 64.0) as usize;
        self.trace += seconds;
        self.last += seconds;
        seconds
    }

    /// Forgets what the frame before the first took.
    fn start(&mut self) {
        (self.update, self.trace, self.last) = (0.0, 0.0, 0.0);
    }
}

pub fn run(options: &Options, embree: Option<&Embree>) -> String {
    let pool = Pool::new(Some(options.threads)).expect("worker threads start");
    let device = embree.filter(|_| options.strategies().is_none()).map(|e| e.device(options.threads));
    println!("milliseconds per frame on {} thread(s)", options.threads);
    let (mut json, mut worst, mut updates) = (Vec::new(), None::<(f64, &str)>, String::new());
    for (name, make) in scenes::ALL.into_iter().chain(scenes::LARGE) {
        if !SCENES.contains(&name) || !options.wants_scene(name) {
            continue;
        }
        let outcome = one_scene(&make(), options, &pool, device.as_ref(), &mut json);
        let Some((ratio, update)) = outcome else { continue };
        if worst.is_none_or(|(w, _)| ratio < w) {
            worst = Some((ratio, name));
        }
        if scenes::LARGE.iter().any(|(large, _)| *large == name) {
            let _ = write!(updates, " {name} {update:.2}");
        }
    }
    if !updates.is_empty() {
        println!("update ratios{updates}");
    }
    match worst {
        Some((ratio, what)) => println!("worst ratio {ratio:.2} ({what})"),
        None => println!("worst ratio - (no peer)"),
    }
    format!("[\n{}\n]\n", json.join(",\n"))
}

/// The vertices that differ, all those between the first and the last.
fn changed(before: &[Vec3], after: &[Vec3]) -> Range<usize> {
    let differ = |(a, b): (&Vec3, &Vec3)| a.to_array().map(f32::to_bits) != b.to_array().map(f32::to_bits);
    let first = before.iter().zip(after).position(differ).unwrap_or(0);
    let end = before.iter().zip(after).rposition(differ).map_or(first, |last| last + 1);
    first..end
}

struct OurRow {
    strategy: Strategy,
    world: TwoLevel,
    tally: Tally,
}

struct PeerRow<'a> {
    name: &'static str,
    variant: Variant<'a>,
    tally: Tally,
}

/// Runs the frames; gives the ratios of whole frames and of updates.
fn one_scene(
    bench: &BenchScene,
    options: &Options,
    pool: &Pool,
    device: Option<&Device>,
    json: &mut Vec<String>,
) -> Option<(f64, f64)> {
    let triangles = bench.triangles();
    let large = triangles > LARGE;
    let frames = if options.quick { QUICK_FRAMES[usize::from(!large)] } else { FRAMES - 1 };
    // Owns the scene. Its own world only tells where rays of the second kind begin: what they touch first is not to be saved by any row.
    let mut ours = Ours::new(bench, 0, pool);
    ours.world.force_strategy(Some(Strategy::Refit));
    let slow = |s: Strategy| s == Strategy::Bsp || (large && s == Strategy::Sah);
    let fixed =
        Strategy::ALL.into_iter().filter(|s| !slow(*s) && options.strategies().is_none_or(|some| some.contains(s)));
    let mut rows: Vec<OurRow> = [Strategy::Auto]
        .into_iter()
        .chain(fixed)
        .map(|strategy| {
            let mut world = TwoLevel::new(Level::detect());
            world.force_strategy(Some(strategy).filter(|s| *s != Strategy::Auto));
            OurRow { strategy, world, tally: Tally::default() }
        })
        .collect();
    let policies = POLICIES.iter().filter(|p| !(large && p.slow));
    let mut peers: Vec<PeerRow> = device.map_or_else(Vec::new, |device| {
        let row = |policy: &Policy| {
            let mut top = device.scene(policy.scene, policy.flags);
            for part in &bench.parts {
                top.add_mesh(&(part.positions)(0), &part.triangles, policy.mesh);
            }
            top.commit();
            let variant = Variant { name: policy.name, built: Built::plain(top), robust: false };
            PeerRow { name: policy.name, variant, tally: Tally::default() }
        };
        policies.map(row).collect()
    });
    println!("{} {}: {} parts, {triangles} triangles, {frames} frames", bench.name, bench.title, bench.parts.len());
    let size = [640, 480];
    let primary = rays::primary(&bench.view, size);
    let offset = 1e-4 * bench.view.eye.distance(bench.view.at);
    for frame in 0..=frames {
        for (name, part) in (1u32..).zip(&bench.parts) {
            let positions = (part.positions)(frame);
            let range = changed(&ours.scene.objects[&name].mesh.positions, &positions);
            if range.is_empty() {
                continue;
            }
            for peer in &mut peers {
                peer.variant.built.top.move_mesh(name as usize - 1, &positions);
                peer.variant.built.top.mark_mesh(name as usize - 1);
            }
            let first = range.start as u32;
            ours.scene.apply(Command::UpdatePositions { name, first, positions: positions[range].to_vec() });
        }
        let Ours { scene, instances, world } = &mut ours;
        let update = |world: &mut TwoLevel| {
            let (cost, stats) = pool.install(|| Cost::of(|| world.update(scene, instances)));
            assert_eq!(stats.out_of_memory, 0, "memory for structures");
            cost.busiest
        };
        update(world);
        rows.iter_mut().for_each(|row| row.tally.begin(update(&mut row.world)));
        for peer in &mut peers {
            let top = &mut peer.variant.built.top;
            let (cost, ()) = Cost::of(|| top.commit_moved());
            peer.tally.begin(cost.busiest);
        }
        let (shadow, _) = rays::secondary(&ours, &primary, bench.light, offset);
        for (kind, (kind_name, rays)) in [(Kind::Primary, &primary), (Kind::Shadow, &shadow)].into_iter().enumerate() {
            for row in &mut rows {
                let seconds =
                    row.tally.trace(kind, our_lanes(Tracer::new(&row.world), kind_name), rays, options.threads);
                // As the renderer does.
                row.world.add_traced(seconds);
            }
            for peer in &mut peers {
                let device = device.expect("peers come from a device");
                let lanes = peer_lanes(device.embree, &peer.variant, kind_name, false, device.has_16());
                peer.tally.trace(kind, lanes, rays, options.threads);
            }
        }
        if frame == 0 {
            rows.iter_mut().for_each(|row| row.tally.start());
            peers.iter_mut().for_each(|peer| peer.tally.start());
        }
    }
    if let Some(device) = device {
        device.check();
    }
    let named = rows.iter().map(|r| (r.strategy.name(), true, &r.tally));
    let all: Vec<(&str, bool, &Tally)> = named.chain(peers.iter().map(|p| (p.name, false, &p.tally))).collect();
    let auto = &rows[0].tally;
    let per = 1e3 / f64::from(frames);
    println!("    {:16} {:>9} {:>9} {:>9} {:>11}", "", "update", "trace", "total", "last frame");
    for (name, is_ours, tally) in &all {
        let [update, trace, total] = [tally.update, tally.trace, tally.total()].map(|s| s * per);
        println!("    {name:16} {update:>9.3} {trace:>9.2} {total:>9.2} {:>11.2}", tally.last * 1e3);
        for kind in 0..2 {
            let off = tally.hits[kind].abs_diff(auto.hits[kind]);
            if tally.hits[kind] > 0 && auto.hits[kind] > 0 && off > if *is_ours { 0 } else { primary.len() / 500 } {
                println!("!!! DIFFERENT HITS: {name} finds {}, auto {}", tally.hits[kind], auto.hits[kind]);
            }
        }
        json.push(format!(
            r#"  {{"scene": "{}", "row": "{name}", "update_ms": {update:.4}, "trace_ms": {trace:.4}, "last_ms": {:.4}}}"#,
            bench.name,
            tally.last * 1e3
        ));
    }
    for strategy in Strategy::ALL.into_iter().filter(|s| slow(*s)) {
        println!("    {:16} left out: it would take minutes", strategy.name());
    }
    let least = |rows: &[&Tally], f: fn(&Tally) -> f64| rows.iter().map(|t| f(t)).fold(f64::INFINITY, f64::min);
    let fixed: Vec<&Tally> = rows[1..].iter().map(|r| &r.tally).collect();
    let peer: Vec<&Tally> = peers.iter().map(|p| &p.tally).collect();
    let regret = auto.total() / least(&fixed, Tally::total);
    if peer.is_empty() {
        println!("    regret {regret:.2}");
        return None;
    }
    let ratio = least(&peer, Tally::total) / auto.total();
    let update = least(&peer, |t| t.update) / auto.update;
    println!("    ratio {ratio:.2}, of updates {update:.2}; regret {regret:.2}");
    Some((ratio, update))
}
