//! `-- static`: rays per second in scenes that stand still (frame 0 of those that move).
//!
//! Per scene: our structures as `Auto` builds them; Embree's at medium and at high quality, and at medium quality with the robust flag,
//! which is what comes closest to our being watertight. Instances are instances in both engines.

use crate::embree::{Device, Embree, Quality, SCENE_ROBUST};
use crate::lanes::{Variant, our_lanes, peer_lanes};
use crate::measure::{CHUNK, race, wall_seconds};
use crate::options::Options;
use crate::ours::Ours;
use crate::rays::{self, Kind};
use crate::report::{self, Row};
use crate::scenes::{self, BenchScene};
use openrt::threads::Pool;

/// Passes per lane.
const ROUNDS: usize = 7;
const QUICK_ROUNDS: usize = 3;

pub fn run(options: &Options, embree: Option<&Embree>) -> String {
    let builders = std::thread::available_parallelism().map_or(1, |n| n.get());
    let pool = Pool::new(Some(builders)).expect("worker threads start");
    let device = embree.map(|e| e.device(builders));
    if let Some(device) = &device {
        let wide = if device.has_16() { "packets of 8 and 16" } else { "packets of 8; no AVX-512 for 16" };
        println!("Embree {} ({wide}, streams)", device.version());
    }
    println!("{CHUNK} rays at a time");
    report::print_heading(options.threads);
    let mut rows = Vec::new();
    for (name, make) in scenes::ALL {
        if options.wants_scene(name) {
            one_scene(&make(), options, &pool, device.as_ref(), &mut rows);
        }
    }
    report::print_worst(&rows);
    report::json(&rows)
}

fn one_scene(bench: &BenchScene, options: &Options, pool: &Pool, device: Option<&Device>, rows: &mut Vec<Row>) {
    let begin = wall_seconds();
    let ours = Ours::new(bench, 0, pool);
    let mut variants = Vec::new();
    if let Some(device) = device {
        let mut add = |name, quality, flags| {
            variants.push(Variant { name, built: device.build(bench, 0, quality, flags), robust: flags != 0 });
        };
        add("med", Quality::Medium, 0);
        add("high", Quality::High, 0);
        add("robust", Quality::Medium, SCENE_ROBUST);
    }
    println!(
        "{} {}: {} instances, {} triangles ({} after instancing), made in {:.1} s",
        bench.name,
        bench.title,
        ours.instances.len(),
        bench.triangles(),
        bench.triangles_shown(0),
        wall_seconds() - begin
    );
    let sizes = if options.quick { &bench.sizes[..1] } else { &bench.sizes[..] };
    for &size in sizes {
        let primary = rays::primary(&bench.view, size);
        let offset = 1e-4 * bench.view.eye.distance(bench.view.at);
        let (shadow, bounce) = rays::secondary(&ours, &primary, bench.light, offset);
        for (kind, rays) in Kind::ALL.into_iter().zip([primary, shadow, bounce]) {
            if !options.wants_kind(kind) {
                continue;
            }
            let mut lanes = our_lanes(ours.tracer(), kind);
            for variant in &variants {
                let device = device.expect("variants come from a device");
                lanes.extend(peer_lanes(device.embree, variant, kind, bench.instanced, device.has_16()));
            }
            let rounds = if options.quick { QUICK_ROUNDS } else { ROUNDS };
            race(&mut lanes, &rays, options.threads, rounds);
            let row = Row::new(bench.name, size, kind.name(), rays.len(), &lanes);
            row.print(options.all);
            rows.push(row);
        }
    }
}
