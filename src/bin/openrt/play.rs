//! `openrt render` and `openrt play`: frames from a scene to files, with what each cost.
//!
//! While a frame renders, the placements of the next one are put together; its picture is written while that one renders.

use crate::args::{FrameRange, Options, PlayArgs, RenderArgs, SceneArgs, Size};
use crate::output::{Output, Picture};
use crate::player::Player;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use openrt::api::FrameStats;
use openrt::load::{Animation, SceneFile};
use std::io::IsTerminal;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Size of pictures when neither the command line nor the scene says one.
const DEFAULT_SIZE: Size = Size { width: 640, height: 480 };

pub fn render(args: RenderArgs) -> Result<(), String> {
    let scene = load(&args.scene, &args.options)?;
    let size = size_of(&scene, &args.options);
    let (frame, time) = match (args.frame, args.time) {
        (None, None) => (0, frame_time(&scene, 0)?),
        (Some(frame), _) => (frame, frame_time(&scene, frame)?),
        (None, Some(time)) => (0, time),
    };
    let out = args.out.unwrap_or_else(|| {
        PathBuf::from(args.scene.scene.file_stem().unwrap_or("picture".as_ref())).with_extension("png")
    });
    let output = Output::single(out, size)?;
    let player = player(scene, &args.options, size)?;
    run(player, output, &[(frame, time)], &args.options)
}

pub fn play(args: PlayArgs) -> Result<(), String> {
    let scene = load(&args.scene, &args.options)?;
    let size = size_of(&scene, &args.options);
    let range = frame_range(args.frames, scene.animation, args.options.quiet)?;
    let frames: Result<Vec<_>, String> = range.frames().map(|f| Ok((f, frame_time(&scene, f)?))).collect();
    let frames = frames?;
    let delay = match args.fps {
        Some(fps) => Duration::from_secs_f64(1.0 / fps.max(1e-3)),
        None => natural_delay(scene.animation, range.step),
    };
    let output = Output::animation(args.out, size, frames.len() as u32, delay)?;
    let player = player(scene, &args.options, size)?;
    run(player, output, &frames, &args.options)
}

/// The frames wanted, as far as the animation has them.
fn frame_range(wanted: Option<FrameRange>, animation: Option<Animation>, quiet: bool) -> Result<FrameRange, String> {
    let count = animation.map_or(1, |a| a.frames);
    let Some(mut range) = wanted else { return Ok(FrameRange { start: 0, end: count, step: 1 }) };
    // A file without animation shows the same picture as often as it is asked for.
    if animation.is_some() && range.end > count {
        if range.start >= count {
            return Err(format!("frame {} does not exist: the animation has frames 0 to {}", range.start, count - 1));
        }
        if !quiet {
            println!("the animation ends with frame {}", count - 1);
        }
        range.end = count;
    }
    Ok(range)
}

/// Time between two pictures on the scene's own clock, within what can be watched.
fn natural_delay(animation: Option<Animation>, step: u32) -> Duration {
    let seconds = animation.map_or(0.1, |a| a.time(step) - a.time(0));
    Duration::from_secs_f64(seconds.clamp(0.02, 0.25))
}

fn load(args: &SceneArgs, options: &Options) -> Result<SceneFile, String> {
    let begin = Instant::now();
    let scene = crate::load(args)?;
    if !options.quiet {
        let triangles: usize = scene.objects.iter().map(|o| o.mesh.triangles.len()).sum();
        println!("{}: {triangles} triangles, read in {:.2} s", args.scene.display(), begin.elapsed().as_secs_f64());
    }
    Ok(scene)
}

fn size_of(scene: &SceneFile, options: &Options) -> Size {
    let own = scene.cameras.first().and_then(|c| c.resolution).map(|(width, height)| Size { width, height });
    // The scene's own size passes the same check as the command line's.
    let own = own.filter(|s| format!("{}x{}", s.width, s.height).parse::<Size>().is_ok());
    options.size.or(own).unwrap_or(DEFAULT_SIZE)
}

fn frame_time(scene: &SceneFile, frame: u32) -> Result<f64, String> {
    match scene.animation {
        Some(animation) if frame >= animation.frames => {
            Err(format!("frame {frame} does not exist: the animation has frames 0 to {}", animation.frames - 1))
        }
        Some(animation) => Ok(animation.time(frame)),
        None => Ok(0.0),
    }
}

fn player(scene: SceneFile, options: &Options, size: Size) -> Result<Player, String> {
    let shown = scene.warnings.len();
    let player = Player::new(scene, options, (size.width, size.height))?;
    // Those of reading were shown before.
    for warning in player.warnings().iter().skip(shown) {
        eprintln!("warning: {warning}");
    }
    Ok(player)
}

/// Sums over the frames of a run.
#[derive(Default)]
struct Totals {
    frames: u32,
    update: f64,
    render: f64,
    slowest: f64,
    rays: u64,
}

fn rays(stats: &FrameStats) -> u64 {
    stats.primary_rays + stats.shadow_rays + stats.secondary_rays
}

fn run(mut player: Player, mut output: Output, frames: &[(u32, f64)], options: &Options) -> Result<(), String> {
    let begin = Instant::now();
    let bar = progress_bar(frames.len() as u64, options);
    let mut totals = Totals::default();
    let Some(&(_, first)) = frames.first() else { return Ok(()) };
    player.assemble(first)?;
    player.start()?;
    for (i, &(frame, time)) in frames.iter().enumerate() {
        let next = frames.get(i + 1);
        if let Some(&(_, time)) = next {
            player.assemble(time)?;
        }
        let stats = player.finish()?;
        let picture = if output.wants_floats() {
            Picture::Floats(player.read_floats()?)
        } else {
            Picture::Bytes(player.read_bytes()?)
        };
        if next.is_some() {
            player.start()?;
        }
        output.write(frame, picture)?;
        totals.add(&stats);
        bar.inc(1);
        if !options.quiet {
            bar.suspend(|| println!("{}", line(frame, time, &stats)));
        }
    }
    let written = output.describe();
    output.finish()?;
    bar.finish_and_clear();
    if !options.quiet {
        totals.print(begin.elapsed(), &written);
    }
    Ok(())
}

/// Only for long work, and only where somebody can see it.
fn progress_bar(frames: u64, options: &Options) -> ProgressBar {
    let bar = ProgressBar::new(frames);
    if options.quiet || frames < 2 || !std::io::stderr().is_terminal() {
        bar.set_draw_target(ProgressDrawTarget::hidden());
    }
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} frames, {elapsed} elapsed, {eta} to go")
        .expect("the template is well formed");
    bar.set_style(style);
    bar.tick();
    bar
}

fn line(frame: u32, time: f64, stats: &FrameStats) -> String {
    let rate = rays(stats) as f64 / stats.render_seconds.max(1e-9) / 1e6;
    let refined =
        if stats.refined < 1.0 { format!("  {:3.0} % refined", stats.refined * 100.0) } else { String::new() };
    format!(
        "frame {frame:5}  time {time:8.3} s  update {:8.2} ms  render {:9.2} ms  {:10} rays  {rate:7.2} Mrays/s{refined}",
        stats.update_seconds * 1e3,
        stats.render_seconds * 1e3,
        rays(stats),
    )
}

impl Totals {
    fn add(&mut self, stats: &FrameStats) {
        self.frames += 1;
        self.update += stats.update_seconds;
        self.render += stats.render_seconds;
        self.slowest = self.slowest.max(stats.total_seconds);
        self.rays += rays(stats);
    }

    fn print(&self, elapsed: Duration, written: &str) {
        let n = f64::from(self.frames.max(1));
        println!(
            "{} frames in {:.2} s: update {:.2} ms, render {:.2} ms per frame (slowest {:.2} ms), {} rays, {:.2} Mrays/s",
            self.frames,
            elapsed.as_secs_f64(),
            self.update / n * 1e3,
            self.render / n * 1e3,
            self.slowest * 1e3,
            self.rays,
            self.rays as f64 / self.render.max(1e-9) / 1e6,
        );
        println!("written to {written}");
    }
}
