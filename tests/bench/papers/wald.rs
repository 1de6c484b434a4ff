//! Wald03 tables 1 and 2: frames per second of the BART kitchen and robots over processors.
//!
//! *The paper*: 110,000 triangles in 5 objects with 6 lights, and 161 objects of 100,000 triangles, at 640×480 by "OpenGL-like" shading (primary rays alone) and by full
//! ray tracing (shadows, three levels of reflection), on 2 to 32 processors of a cluster. Both scale almost without loss until the server's network is full
//! of pixels (26 frames).
//!
//! *Here*: the same scenes if `../shared/bart` is there, else generated ones; `raycast` and `whitted` with textures, through [`crate::stage::Stage`], over a few frames of
//! the animation. Frames of one thread and of two (`real`, processor time of the busier) are measured; all other columns are *simulated* from measured times of 1200 tiles
//! ([`crate::cluster`]), until there is a cluster. What tiles take together, over the time of the whole picture on one thread, stands beside it. Quick
//! runs render a quarter of the pixels in 300 tiles, too few for 32 processors.
//!
//! The ratio that counts is 32 processors over 2, or 16 where the paper's network was full.

use crate::bart;
use crate::cluster::{DUAL, Work};
use crate::load::SceneFile;
use crate::options::Options;
use crate::report::{Report, head};
use crate::scenes;
use crate::stage::{Look, PAPER, QUICK, Stage};
use openrt::api::Result;

const PROCESSORS: [usize; 5] = [2, 4, 8, 16, 32];

/// The paper's frames per second; not a number beyond what its network lets through.
const KITCHEN: [[f64; 5]; 2] = [[3.2, 6.4, 12.8, 25.6, f64::NAN], [0.47, 0.94, 1.88, 3.77, 7.55]];
const ROBOTS: [[f64; 5]; 2] = [[2.8, 5.55, 10.8, 21.0, f64::NAN], [0.54, 1.07, 2.15, 4.3, 8.6]];
/// Part of the paper's scaling that is as good as all of it.
const NEARLY: f64 = 0.9;

/// A scene and the frames of it that are rendered.
pub struct Show {
    make: Box<dyn Fn(usize) -> Result<Stage>>,
    frames: Vec<u32>,
    quick: bool,
}

impl Show {
    fn size(quick: bool) -> [u32; 3] {
        if quick { QUICK } else { PAPER }
    }

    pub fn file(file: SceneFile, quick: bool) -> Show {
        let frames = Self::some(file.animation.map_or(1, |a| a.frames), quick);
        let make = move |threads| bart::stage(threads, Self::size(quick), file.clone());
        Show { make: Box::new(make), frames, quick }
    }

    pub fn generated(make: fn() -> scenes::BenchScene, mirror: bool, last: u32, quick: bool) -> Show {
        let make = move |threads| Stage::generated(threads, Self::size(quick), make(), mirror);
        Show { make: Box::new(make), frames: Self::some(last, quick), quick }
    }

    /// Numbers of frames spread over an animation of so many.
    fn some(last: u32, quick: bool) -> Vec<u32> {
        let count = if quick { 1 } else { 4 };
        (0..count).map(|i| last * (2 * i + 1) / (2 * count)).collect()
    }

    /// Measures every frame in both looks: update and tiles, the whole by one thread and by two.
    pub fn measure(&self) -> Result<[Measured; 2]> {
        let [mut one, mut two] = [(self.make)(1)?, (self.make)(DUAL)?];
        let mut measured = <[Measured; 2]>::default();
        for &frame in &self.frames {
            let update = one.update(frame)?;
            for (look, measured) in Look::BOTH.into_iter().zip(&mut measured) {
                // Textures are read, and structures built, by then.
                let (stats, first) = one.frame(frame, look)?;
                measured.rays += (stats.primary_rays + stats.shadow_rays + stats.secondary_rays) as f64;
                two.frame(frame, look)?;
                // A picture that takes a second is not repeated.
                let rounds = if self.quick && first.all > 1.0 { 1 } else { 3 };
                let mut least = [f64::INFINITY; 2];
                for _ in 0..rounds {
                    least[0] = least[0].min(one.frame(frame, look)?.1.all);
                    least[1] = least[1].min(two.frame(frame, look)?.1.busiest);
                }
                measured.whole.iter_mut().zip(least).for_each(|(sum, seconds)| *sum += seconds);
                let tiles = one.tiles(frame, look, rounds.min(2))?;
                measured.works.push(Work { update, tiles, bytes: one.bytes });
            }
        }
        Ok(measured)
    }
}

/// A scene in one look.
#[derive(Clone, Default)]
pub struct Measured {
    /// Per frame.
    pub works: Vec<Work>,
    /// Processor seconds of all frames, rendered whole by one thread, and of the busier of two.
    whole: [f64; 2],
    rays: f64,
}

/// What has been measured, for all tables.
#[derive(Default)]
pub struct Scenes {
    done: Vec<(&'static str, [Measured; 2])>,
}

impl Scenes {
    /// Of the scene called `name`.
    pub fn get(&mut self, name: &'static str, make: impl FnOnce() -> Show) -> Result<[Measured; 2]> {
        if let Some((_, measured)) = self.done.iter().find(|(done, _)| *done == name) {
            return Ok(measured.clone());
        }
        let measured = make().measure()?;
        self.done.push((name, measured.clone()));
        Ok(measured)
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

pub fn table_1(options: &Options, scenes: &mut Scenes, report: &mut Report) {
    head("wald1", "the kitchen over processors");
    let measured = scenes.get("Kitchen", || kitchen(options.quick));
    scaling("wald1", measured, &KITCHEN, report);
}

pub fn table_2(options: &Options, scenes: &mut Scenes, report: &mut Report) {
    head("wald2", "the robots over processors");
    let measured = scenes.get("Robots", || robots(options.quick));
    scaling("wald2", measured, &ROBOTS, report);
}

fn scaling(table: &str, measured: Result<[Measured; 2]>, paper: &[[f64; 5]; 2], report: &mut Report) {
    let measured = match measured {
        Ok(measured) => measured,
        Err(error) => return report.verdict(table, false, &format!("the scene cannot be rendered: {error}")),
    };
    println!(
        "{:12} | {:>7} {:>7} |{:>8}{:>8}{:>8}{:>8}{:>8} | {:>5} {:>9} {:>9} {:>7}",
        "frames/s", "1 real", "2 real", "2", "4", "8", "16", "32", "tiles", "update ms", "Mrays", "Mrays/s"
    );
    for ((look, theirs), Measured { works, whole, rays }) in Look::BOTH.into_iter().zip(paper).zip(measured) {
        let count = works.len() as f64;
        let tiles: f64 = works.iter().map(|w| w.tiles.iter().sum::<f64>() + w.update).sum();
        let rates = PROCESSORS.map(|p| mean_rate(&works, |w| 1.0 / w.seconds(p)));
        let update = works.iter().map(|w| w.update).sum::<f64>() / count;
        print!("{:12} | {:>7.1} {:>7.1} |", look.name(), count / whole[0], count / whole[1]);
        rates.iter().for_each(|rate| print!("{rate:>8.1}"));
        println!(
            " | {:>5.2} {:>9.3} {:>9.2} {:>7.2}",
            tiles / whole[0],
            update * 1e3,
            rays / count * 1e-6,
            rays / whole[0] * 1e-6
        );
        print!("{:12} | {:>15} |", "   the paper", "");
        theirs.iter().for_each(|rate| if rate.is_nan() { print!("{:>8}", "> 26") } else { print!("{rate:>8.2}") });
        println!(" |");
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
        // Not beyond where the paper's network was full.
        let last = if theirs[4].is_nan() { 3 } else { 4 };
        let [ours, paper] = [rates[last] / rates[0], theirs[last] / theirs[0]];
        let text = format!(
            "{}: {} processors {ours:.1}x two (simulated; paper {paper:.1}x; reached from {:.0}% of it on)",
            look.name(),
            PROCESSORS[last],
            NEARLY * 100.0
        );
        report.verdict(table, ours >= NEARLY * paper, &text);
    }
    println!(
        "2 ... 32: simulated, tiles measured on one processor and pulled by so many; `tiles`: all of them over the whole frame"
    );
}
