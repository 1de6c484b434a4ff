//! Wald03 tables 1 and 2: frames per second of the BART kitchen and robots over processors.
//!
//! *The paper*: 110,000 triangles in 5 objects with 6 lights, and 161 objects of 100,000 triangles, at 640×480 by "OpenGL-like" shading (primary rays alone) and by full
//! ray tracing (shadows, three levels of reflection), on 2 to 32 processors of a cluster. Both scale almost without loss until the server's network is full
//! of pixels (26 frames).
//!
//! *Here*: the same scenes if `../shared/bart` is there, else generated ones; `raycast` and `whitted` with textures, through [`crate::stage::Stage`], over a few frames of
//! the animation. Frames of one processor and of two (`real`) are measured; all other columns are *simulated* from measured times of tiles of 32×32 pixels
//! ([`crate::cluster`]), until there is a cluster. What tiles take together, over the time of the whole picture on one processor, stands beside it.
//!
//! The ratio that counts is 32 processors over 2; the pixels' network is left out of the verdict on both sides (theirs is stated for ray tracing alone).

use crate::bart;
use crate::cluster::{DUAL, Work};
use crate::options::Options;
use crate::report::{Report, head};
use crate::scene::SceneFile;
use crate::scenes;
use crate::stage::{HEIGHT, Look, Stage, WIDTH};
use openrt::api::Result;

const PROCESSORS: [usize; 5] = [2, 4, 8, 16, 32];

/// The paper's frames per second; not a number beyond what its network lets through.
const KITCHEN: [[f64; 5]; 2] = [[3.2, 6.4, 12.8, 25.6, f64::NAN], [0.47, 0.94, 1.88, 3.77, 7.55]];
const ROBOTS: [[f64; 5]; 2] = [[2.8, 5.55, 10.8, 21.0, f64::NAN], [0.54, 1.07, 2.15, 4.3, 8.6]];
/// Part of the paper's scaling that is as good as all of it.
const NEARLY: f64 = 0.9;

/// Makes a stage for so many threads.
pub type Make = Box<dyn Fn(usize) -> Result<Stage>>;

/// A scene and the frames of it that are rendered.
pub struct Show {
    pub make: Make,
    pub frames: Vec<u32>,
}

impl Show {
    pub fn file(file: SceneFile, quick: bool) -> Show {
        let last = file.animation.map_or(1, |a| a.frames);
        let frames = Self::some(last, quick);
        Show { make: Box::new(move |threads| bart::stage(threads, file.clone())), frames }
    }

    pub fn generated(make: fn() -> scenes::BenchScene, mirror: bool, last: u32, quick: bool) -> Show {
        let make = move |threads| Stage::generated(threads, make(), mirror);
        Show { make: Box::new(make), frames: Self::some(last, quick) }
    }

    /// Numbers of frames spread over an animation of so many.
    fn some(last: u32, quick: bool) -> Vec<u32> {
        let count = if quick { 2 } else { 6 };
        (0..count).map(|i| last * (2 * i + 1) / (2 * count)).collect()
    }

    /// Measures every frame: update and tiles.
    pub fn works(&self, stage: &mut Stage, look: Look) -> Result<Vec<Work>> {
        let mut works = Vec::new();
        for &frame in &self.frames {
            // From the frame before to this one, as the animation goes.
            let mut update = f64::INFINITY;
            for _ in 0..2 {
                stage.frame(frame.saturating_sub(1), look)?;
                update = update.min(stage.frame(frame, look)?.update_seconds);
            }
            let tiles = stage.tiles(frame, look, 2)?;
            works.push(Work { update, tiles, pixels: f64::from(WIDTH * HEIGHT), bytes: stage.bytes });
        }
        Ok(works)
    }
}

/// Frames per second over all frames.
pub fn mean_rate(works: &[Work], rate: impl Fn(&Work) -> f64) -> f64 {
    works.len() as f64 / works.iter().map(|work| 1.0 / rate(work)).sum::<f64>()
}

/// The kitchen of BART, or the mirroring bodies.
pub fn kitchen(quick: bool) -> Show {
    match bart::load("kitchen/aff/kitchen.aff") {
        Some(file) => Show::file(file, quick),
        None => Show::generated(|| scenes::moving::cloth_of(100), true, 100, quick),
    }
}

/// The robots of BART, or the figures.
pub fn robots(quick: bool) -> Show {
    match bart::load("robot/aff/Robot.aff") {
        Some(file) => Show::file(file, quick),
        None => Show::generated(scenes::ALL[1].1, false, 20, quick),
    }
}

pub fn table_1(options: &Options, report: &mut Report) {
    head("wald1", "the kitchen over processors");
    scaling("wald1", &kitchen(options.quick), &KITCHEN, options, report);
}

pub fn table_2(options: &Options, report: &mut Report) {
    head("wald2", "the robots over processors");
    scaling("wald2", &robots(options.quick), &ROBOTS, options, report);
}

fn scaling(table: &str, show: &Show, paper: &[[f64; 5]; 2], options: &Options, report: &mut Report) {
    if let Err(error) = try_scaling(table, show, paper, options, report) {
        report.verdict(table, false, &format!("the scene cannot be rendered: {error}"));
    }
}

fn try_scaling(table: &str, show: &Show, paper: &[[f64; 5]; 2], options: &Options, report: &mut Report) -> Result<()> {
    let rounds = if options.quick { 2 } else { 4 };
    println!(
        "{:12} | {:>7} {:>7} |{:>8}{:>8}{:>8}{:>8}{:>8} | {:>5} {:>8} {:>8}",
        "frames/s", "1 real", "2 real", "2", "4", "8", "16", "32", "tiles", "32 / 2", "update"
    );
    for (look, theirs) in Look::BOTH.into_iter().zip(paper) {
        let mut stage = (show.make)(1)?;
        let mut two = (show.make)(DUAL)?;
        let works = show.works(&mut stage, look)?;
        let mut real = [0.0; 2];
        for &frame in &show.frames {
            for (real, stage) in real.iter_mut().zip([&mut stage, &mut two]) {
                let mut least = f64::INFINITY;
                for _ in 0..=rounds {
                    least = least.min(stage.frame(frame, look)?.total_seconds);
                }
                *real += least;
            }
        }
        let count = show.frames.len() as f64;
        let tiles: f64 = works.iter().map(|w| w.tiles.iter().sum::<f64>() + w.update).sum();
        let rates = PROCESSORS.map(|p| mean_rate(&works, |w| 1.0 / w.seconds(p)));
        let update = works.iter().map(|w| w.update).sum::<f64>() / count;
        let (ours, paper) = (rates[4] / rates[0], theirs[4] / theirs[0]);
        print!("{:12} | {:>7.1} {:>7.1} |", look.name(), count / real[0], count / real[1]);
        rates.iter().for_each(|rate| print!("{rate:>8.1}"));
        println!(" | {:>5.2} {ours:>7.1}x {:>6.3}ms", tiles / real[0], update * 1e3);
        print!("{:12} | {:>15} |", "   the paper", "");
        theirs.iter().for_each(|rate| if rate.is_nan() { print!("{:>8}", "> 26") } else { print!("{rate:>8.2}") });
        println!(" | {:>5} {paper:>7.1}x", "");
        for ((p, rate), theirs) in PROCESSORS.into_iter().zip(rates).zip(theirs) {
            report.row(
                table,
                &[
                    ("look", look.name().into()),
                    ("processors", (p as u32).into()),
                    ("simulated_fps", rate.into()),
                    ("paper_fps", (*theirs).into()),
                ],
            );
        }
        // Where the paper's network was full, only its ray tracing tells.
        let paper = if paper.is_nan() { theirs[3] / theirs[0] } else { paper };
        let (to, ours) = if theirs[4].is_nan() { (16, rates[3] / rates[0]) } else { (32, ours) };
        let text = format!(
            "{}: {to} processors {ours:.1}x two (simulated; paper {paper:.1}x, reached from {:.0}% of it on)",
            look.name(),
            NEARLY * 100.0
        );
        report.verdict(table, ours >= NEARLY * paper, &text);
    }
    println!(
        "simulated: tiles of 32x32 pixels, measured on one processor, pulled by so many; `tiles`: all of them over the whole frame"
    );
    Ok(())
}
