//! Runs an animation by several strategies at once: the same frames, the same rays, row by row in turn.
//!
//! A frame's vertices are made and handed over untimed. Then each row brings its structure up to date (*update*) and traces primary rays and a shadow
//! ray to one point light from each hit, as batches (*trace*). One thread: its processor time; more: that of the busiest. A frame that
//! takes a row longer than [`LONG`] is traced in parts, another part of the tiles in each frame, and the time multiplied.

use crate::measure::Cost;
use crate::random::Random;
use crate::rays;
use crate::scenes::BenchScene;
use glam::Vec3;
use openrt::accel::{Structure, TwoLevel};
use openrt::scene::{Command, Instance, Mesh, Scene, Strategy};
use openrt::simd::Level;
use openrt::threads::Pool;
use openrt::trace::{Ray, Tracer};
use rayon::prelude::*;

/// Rays per call: a tile of 16×16 pixels.
const CHUNK: usize = 256;
/// A frame is traced in parts if it takes longer, in seconds.
const LONG: f64 = 0.08;
const MOST_PARTS: usize = 48;

/// What a frame took, in seconds.
#[derive(Clone, Copy, Debug, Default)]
pub struct Frame {
    pub update: f64,
    pub trace: f64,
    /// Surface-area cost of the largest object's tree; 0 without a tree.
    pub cost: f64,
    /// Whether a structure was built anew.
    pub built: bool,
}

impl Frame {
    pub fn total(&self) -> f64 {
        self.update + self.trace
    }
}

/// All frames of one strategy.
pub struct Run {
    pub strategy: Strategy,
    pub frames: Vec<Frame>,
}

impl Run {
    /// Mean over the frames.
    pub fn mean(&self, pick: impl Fn(&Frame) -> f64) -> f64 {
        self.frames.iter().map(pick).sum::<f64>() / self.frames.len().max(1) as f64
    }

    /// Mean time of the updates that built nothing anew; NaN if every one did.
    pub fn update_in_place(&self) -> f64 {
        let mine: Vec<f64> = self.frames.iter().filter(|f| !f.built).map(|f| f.update).collect();
        mine.iter().sum::<f64>() / mine.len() as f64
    }

    pub fn rebuilds(&self) -> usize {
        self.frames.iter().filter(|f| f.built).count()
    }
}

struct Row {
    world: TwoLevel,
    parts: usize,
    run: Run,
}

/// Runs frames 1 … `shown` of a scene that begins again after `period` frames; frame 0, which builds, is not counted.
pub fn run(
    bench: &BenchScene,
    strategies: &[Strategy],
    [period, shown]: [u32; 2],
    size: [u32; 2],
    threads: usize,
) -> Vec<Run> {
    let pool = Pool::new(Some(threads)).expect("worker threads start");
    let mut scene = Scene::default();
    for (name, part) in (1..).zip(&bench.parts) {
        let mesh = Mesh { positions: (part.positions)(0), triangles: part.triangles.clone(), ..Mesh::default() };
        scene.apply(Command::DefineObject { name, mesh, motion: part.motion });
    }
    let row = |&strategy: &Strategy| {
        let mut world = TwoLevel::new(Level::detect());
        world.force_strategy(Some(strategy));
        Row { world, parts: 1, run: Run { strategy, frames: Vec::new() } }
    };
    let mut rows: Vec<Row> = strategies.iter().map(row).collect();
    let primary = rays::primary(&bench.view, size);
    let tiles = scattered(primary.chunks(CHUNK).collect());
    for frame in 0..=shown {
        let of_clip = frame % period;
        for (name, part) in (1..).zip(&bench.parts) {
            if frame > 0 && part.motion == openrt::scene::Motion::Unstructured {
                scene.apply(Command::UpdatePositions { name, first: 0, positions: (part.positions)(of_clip) });
            }
        }
        let instances: Vec<Instance> =
            (bench.place)(of_clip).into_iter().map(|p| Instance::new(p.part as u32 + 1, p.transform)).collect();
        let mut seen = None;
        for row in &mut rows {
            let (updating, stats) = pool.install(|| Cost::of(|| row.world.update(&scene, &instances)));
            assert_eq!(stats.out_of_memory, 0, "memory for structures");
            if frame == 0 {
                continue;
            }
            let turn = frame as usize % row.parts;
            let some = &tiles[turn * tiles.len() / row.parts..(turn + 1) * tiles.len() / row.parts];
            let (tracing, hits) = pool.install(|| Cost::of(|| trace(&row.world, some, bench.light)));
            if row.parts == 1 {
                assert_eq!(*seen.get_or_insert(hits), hits, "{} sees another picture", row.run.strategy.name());
            }
            let all = tracing.busiest * primary.len() as f64 / some.iter().map(|tile| tile.len()).sum::<usize>() as f64;
            row.world.add_traced(all);
            row.parts = (all / LONG).ceil().clamp(1.0, MOST_PARTS as f64) as usize;
            let built = stats.objects_built > 0;
            row.run.frames.push(Frame { update: updating.busiest, trace: all, cost: cost(&row.world), built });
        }
    }
    rows.into_iter().map(|row| row.run).collect()
}

/// In an order of which every run is spread over all of the picture.
fn scattered<T>(mut items: Vec<T>) -> Vec<T> {
    let mut random = Random::new(1);
    for i in (1..items.len()).rev() {
        items.swap(i, random.below(i + 1));
    }
    items
}

/// Traces primary rays and their shadow rays; gives how many of both hit.
fn trace(world: &TwoLevel, tiles: &[&[Ray]], light: Vec3) -> usize {
    let tracer = Tracer::new(world);
    tiles.par_iter().map(|tile| rays::with_shadows(&tracer, tile, light)).sum()
}

fn cost(world: &TwoLevel) -> f64 {
    let largest = world.objects().iter().max_by_key(|object| object.triangles());
    match largest.map(|object| object.structure()) {
        Some(Structure::Bvh(bvh)) => bvh.sah_cost(),
        _ => 0.0,
    }
}
