//! `openrt render` and `openrt play`: frames from a scene to files, with what each cost.
//!
//! While a frame renders, the placements of the next one are put together; its picture is written while that one renders.

use crate::args::{FrameRange, Options, PlayArgs, RenderArgs, SceneArgs, Size};
use crate::input;
use crate::output::{Output, Picture, STANDARD};
use crate::player::Player;
use crate::progress::Progress;
use crate::report::{Report, Voice, line};
use openrt::load::{Animation, SceneFile};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Size of pictures when neither the command line nor the scene says one.
const DEFAULT_SIZE: Size = Size { width: 640, height: 480 };

pub fn render(args: RenderArgs) -> Result<(), String> {
    let out = args.out.unwrap_or_else(|| {
        let stem = args.scene.scene.file_stem().filter(|s| *s != STANDARD);
        PathBuf::from(stem.unwrap_or("picture".as_ref())).with_extension("png")
    });
    let voice = voice(&args.options, &out)?;
    let (scene, about) = load(&args.scene, voice)?;
    let size = size_of(&scene, &args.options);
    let (frame, time) = match (args.frame, args.time) {
        (None, None) => (0, frame_time(&scene, 0)?),
        (Some(frame), _) => (frame, frame_time(&scene, frame)?),
        (None, Some(time)) => (0, time),
    };
    if let Some(text) = beyond(scene.animation, args.frame, args.time) {
        voice.say(&text);
    }
    let output = Output::single(out, args.kind, size)?;
    let job = Job { frames: vec![(frame, time)], size, voice, about };
    job.run(scene, output, &args.options)
}

pub fn play(args: PlayArgs) -> Result<(), String> {
    let voice = voice(&args.options, &args.out)?;
    let (scene, about) = load(&args.scene, voice)?;
    let size = size_of(&scene, &args.options);
    let range = frame_range(args.frames, scene.animation, voice)?;
    let frames: Result<Vec<_>, String> = range.frames().map(|f| Ok((f, frame_time(&scene, f)?))).collect();
    let frames = frames?;
    let delay = match args.fps {
        Some(fps) => Duration::from_secs_f64(1.0 / fps.max(1e-3)),
        None => natural_delay(scene.animation, range.step),
    };
    let output = Output::animation(args.out, args.kind, size, frames.len() as u32, delay)?;
    Job { frames, size, voice, about }.run(scene, output, &args.options)
}

/// How a run speaks whose pictures go to `out`.
fn voice(options: &Options, out: &Path) -> Result<Voice, String> {
    let aside = out == Path::new(STANDARD);
    if aside && options.json {
        return Err("--json and --out - both want the standard output".into());
    }
    Ok(Voice { quiet: options.quiet, json: options.json, aside })
}

/// What is to be said of a frame or a time that the animation does not have.
fn beyond(animation: Option<Animation>, frame: Option<u32>, time: Option<f64>) -> Option<String> {
    match (animation, frame, time) {
        (None, Some(1..), _) | (None, _, Some(_)) => {
            Some("the scene has no animation: it looks the same at any time".into())
        }
        (Some(Animation { start, end, .. }), _, Some(time)) if !(start..=end).contains(&time) => {
            let which = if time < start { "first" } else { "last" };
            Some(format!("the animation goes from {start} s to {end} s: shown is how its {which} keys go on"))
        }
        _ => None,
    }
}

/// The frames wanted, as far as the animation has them.
fn frame_range(wanted: Option<FrameRange>, animation: Option<Animation>, voice: Voice) -> Result<FrameRange, String> {
    let count = animation.map_or(1, |a| a.frames);
    let Some(mut range) = wanted else { return Ok(FrameRange { start: 0, end: count, step: 1 }) };
    // A file without animation shows the same picture as often as it is asked for.
    if animation.is_some() && range.end > count {
        if range.start >= count {
            return Err(format!("frame {} does not exist: the animation has frames 0 to {}", range.start, count - 1));
        }
        voice.say(&format!("the animation ends with frame {}", count - 1));
        range.end = count;
    }
    Ok(range)
}

/// Time between two pictures on the scene's own clock, within what can be watched.
fn natural_delay(animation: Option<Animation>, step: u32) -> Duration {
    let seconds = animation.map_or(0.1, |a| a.time(step) - a.time(0));
    Duration::from_secs_f64(seconds.clamp(0.02, 0.25))
}

/// The scene, and an object that tells of it.
fn load(args: &SceneArgs, voice: Voice) -> Result<(SceneFile, Value), String> {
    let begin = Instant::now();
    let scene = input::load(args)?;
    let seconds = begin.elapsed().as_secs_f64();
    let triangles: usize = scene.objects.iter().map(|o| o.mesh.triangles.len()).sum();
    voice.say(&format!("{}: {triangles} triangles, read in {seconds:.2} s", args.scene.display()));
    let about = json!({ "scene": args.scene.display().to_string(), "triangles": triangles, "read_seconds": seconds });
    Ok((scene, about))
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

/// What is to be rendered.
struct Job {
    /// Numbers and times.
    frames: Vec<(u32, f64)>,
    size: Size,
    voice: Voice,
    /// Tells of the scene, for the object that is printed.
    about: Value,
}

impl Job {
    fn run(mut self, scene: SceneFile, mut output: Output, options: &Options) -> Result<(), String> {
        let Some(&(_, first)) = self.frames.first() else { return Ok(()) };
        let size = (self.size.width, self.size.height);
        let progress = Progress::new(self.frames.len() as u64, size, options.quiet);
        let mut player = self.player(scene, options)?;
        player.deliver(progress.target(size))?;
        let begin = Instant::now();
        let mut report = Report::default();
        player.assemble(first)?;
        progress.begin_frame();
        player.start()?;
        for (i, &(frame, time)) in self.frames.iter().enumerate() {
            let next = self.frames.get(i + 1);
            if let Some(&(_, time)) = next {
                player.assemble(time)?;
            }
            if let Some(interval) = progress.interval() {
                while !player.wait(interval)? {
                    progress.show(i as u64);
                }
            }
            let stats = player.finish()?;
            let picture = if output.wants_floats() {
                Picture::Floats(player.read_floats()?)
            } else {
                Picture::Bytes(player.read_bytes()?)
            };
            if next.is_some() {
                progress.begin_frame();
                player.start()?;
            }
            output.write(frame, picture)?;
            if self.voice.speaks() {
                progress.aside(|| self.voice.say(&line(frame, time, &stats)));
            }
            report.add(frame, time, stats);
        }
        let written = output.describe();
        output.finish()?;
        progress.end();
        let elapsed = begin.elapsed();
        self.voice.say(&report.text(elapsed, &written));
        if self.voice.json {
            let warnings = player.warnings();
            self.about["warnings"] = json!(warnings);
            println!("{}", report.json(self.about, elapsed, &written));
        }
        Ok(())
    }

    fn player(&mut self, scene: SceneFile, options: &Options) -> Result<Player, String> {
        let shown = scene.warnings.len();
        let player = Player::new(scene, options, (self.size.width, self.size.height))?;
        // Those of reading were shown before.
        for warning in player.warnings().iter().skip(shown) {
            eprintln!("warning: {warning}");
        }
        self.about["width"] = json!(self.size.width);
        self.about["height"] = json!(self.size.height);
        Ok(player)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_lies_beyond_the_animation_is_told() {
        let animation = Some(Animation { start: 1.0, end: 3.0, frames: 5 });
        for time in [1.0, 2.0, 3.0] {
            assert_eq!(beyond(animation, None, Some(time)), None);
        }
        assert!(beyond(animation, None, Some(0.5)).unwrap().contains("first"));
        assert!(beyond(animation, None, Some(3.5)).unwrap().contains("last"));
        assert_eq!(beyond(None, Some(0), None), None);
        assert!(beyond(None, Some(1), None).is_some() && beyond(None, None, Some(0.0)).is_some());
    }
}
