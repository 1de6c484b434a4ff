//! The command line: what can be said, and what the words mean.

use crate::output::Kind;
use clap::{Args, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;
use glam::DVec3;
use openrt::api::{MAX_FRAMELESS, Strategy};
use std::path::PathBuf;
use std::time::Duration;

/// Looks at, renders and plays scenes: BART/AFF, NFF, OBJ, PLY and glTF.
#[derive(Debug, Parser)]
#[command(name = "openrt", version, max_term_width = 100)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Says what is in a scene.
    Info(InfoArgs),
    /// Renders one picture.
    Render(RenderArgs),
    /// Renders the frames of an animation.
    Play(PlayArgs),
    /// Prints a script that completes command lines: `openrt completions bash > …/bash-completion/completions/openrt`.
    Completions { shell: Shell },
}

#[derive(Debug, Args)]
pub struct SceneArgs {
    /// Scene file: .aff, .nff, .obj, .ply, .gltf or .glb; - reads it from the standard input.
    pub scene: PathBuf,
    /// Format of a scene on the standard input, where it does not tell by its first lines.
    #[arg(long, value_enum)]
    pub format: Option<Format>,
    /// Level of detail of AFF scenes: included files of a higher level are left out.
    #[arg(long, default_value_t = 0.0, value_name = "LEVEL")]
    pub detail: f64,
    /// Which of the animations of a glTF file is played: its name, or its number counted from 0.
    #[arg(long, value_name = "NAME|NUMBER")]
    pub animation: Option<String>,
}

#[derive(Debug, Args)]
pub struct InfoArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Also lists the moving transforms, objects, materials and textures.
    #[arg(long, short)]
    pub long: bool,
    /// Prints one JSON object.
    #[arg(long)]
    pub json: bool,
}

/// Formats of scenes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    #[value(alias = "aff")]
    Nff,
    Obj,
    Ply,
    Gltf,
    Glb,
}

impl Format {
    pub fn extension(self) -> &'static str {
        match self {
            Format::Nff => "nff",
            Format::Obj => "obj",
            Format::Ply => "ply",
            Format::Gltf => "gltf",
            Format::Glb => "glb",
        }
    }
}

#[derive(Debug, Args)]
pub struct RenderArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Frame of the animation, counted from 0.
    #[arg(long, conflicts_with = "time")]
    pub frame: Option<u32>,
    /// Time on the scene's clock, in seconds.
    #[arg(long, value_parser = finite, allow_negative_numbers = true)]
    pub time: Option<f64>,
    /// Picture file: .png, .jpg, .exr, .hdr or .ppm; - writes to the standard output. By default the scene's name with .png, in
    /// the current folder.
    #[arg(long, short)]
    pub out: Option<PathBuf>,
    /// What the picture is, whatever its file is called.
    #[arg(long, value_enum)]
    pub kind: Option<Kind>,
    #[command(flatten)]
    pub options: Options,
}

#[derive(Debug, Args)]
pub struct PlayArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Frames A to B − 1, every STEP-th; by default all that the scene has.
    #[arg(long, value_name = "A..B[:STEP]")]
    pub frames: Option<FrameRange>,
    /// A folder (frame_0000.png …), a pattern such as out/f%04d.jpg (.png, .jpg, .exr, .hdr, .ppm), an animation (.gif or .apng), or
    /// - for one picture after the other on the standard output.
    #[arg(long, short, default_value = "frames")]
    pub out: PathBuf,
    /// What the pictures are, whatever their files are called.
    #[arg(long, value_enum)]
    pub kind: Option<Kind>,
    /// Speed of a GIF or APNG; by default the animation's own, within 4 to 50 frames per second.
    #[arg(long, value_name = "FRAMES_PER_SECOND", value_parser = positive)]
    pub fps: Option<f64>,
    #[command(flatten)]
    pub options: Options,
}

#[derive(Debug, Args)]
pub struct Options {
    /// Size of the picture; by default what the scene says, else 640x480.
    #[arg(long, value_name = "WxH")]
    pub size: Option<Size>,
    /// Samples per pixel.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=4096))]
    pub samples: u16,
    /// Reflections and refractions that are followed.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u16).range(0..=64))]
    pub depth: u16,
    /// How pixels become rays.
    #[arg(long, value_enum, default_value_t = Renderer::Whitted)]
    pub renderer: Renderer,
    /// Eye point, instead of the scene's camera.
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    pub eye: Option<DVec3>,
    /// Point to look at.
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    pub at: Option<DVec3>,
    /// Direction that is up in the picture.
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    pub up: Option<DVec3>,
    /// Vertical field of view in degrees.
    #[arg(long, value_parser = field_of_view)]
    pub fov: Option<f64>,
    /// Threads; by default all processors, or OPENRT_NUM_THREADS.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Acceleration structure of all objects: auto, bsp, sah, fast_build, refit, …
    #[arg(long, value_parser = strategy)]
    pub strategy: Option<Strategy>,
    /// Encode 8-bit pictures with the sRGB curve; by default only for glTF, whose colours are meant that way.
    #[arg(long, value_enum)]
    pub srgb: Option<Switch>,
    /// Shadows (renderer whitted).
    #[arg(long, value_enum, default_value_t = Switch::On)]
    pub shadows: Switch,
    /// Sample only one pixel in each block of N x N, and interpolate the others.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..))]
    pub subsampling: u16,
    /// How they are interpolated.
    #[arg(long, value_enum, default_value_t = Interpolation::Bilinear)]
    pub upsampling: Interpolation,
    /// Milliseconds per frame: after the primary rays of the whole picture, others are followed as long as there is time.
    #[arg(long, value_name = "MILLISECONDS", value_parser = budget)]
    pub time_budget: Option<Duration>,
    /// Render one in N pixels per frame, and keep the others from frames before.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=MAX_FRAMELESS as i64))]
    pub frameless: u16,
    /// Print nothing but errors.
    #[arg(long, short)]
    pub quiet: bool,
    /// Print one JSON object when all is done, instead of text.
    #[arg(long)]
    pub json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Switch {
    On,
    Off,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
#[value(rename_all = "snake_case")]
pub enum Renderer {
    /// Lights, shadows, reflections and refractions.
    Whitted,
    /// Primary rays and lights only.
    Raycast,
    AmbientOcclusion,
    /// Global illumination.
    Path,
}

impl Renderer {
    /// Name of the rendering object's class.
    pub fn class(self) -> &'static str {
        match self {
            Renderer::Whitted => "whitted",
            Renderer::Raycast => "raycast",
            Renderer::AmbientOcclusion => "ambient_occlusion",
            Renderer::Path => "path",
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Interpolation {
    Bilinear,
    /// Linear in four triangles around the middle of each block.
    Midpoint,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    pub width: u32,
    pub height: u32,
}

/// Most pixels of a picture: 16,384 × 16,384.
const MAX_PIXELS: u64 = 1 << 28;

impl std::str::FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (width, height) = text.split_once(['x', 'X', '×']).ok_or("expected WIDTHxHEIGHT, such as 640x480")?;
        let side = |s: &str| s.parse().ok().filter(|&n: &u32| (1..=65_535).contains(&n));
        let (Some(width), Some(height)) = (side(width), side(height)) else {
            return Err("width and height must lie between 1 and 65535".into());
        };
        if u64::from(width) * u64::from(height) > MAX_PIXELS {
            return Err(format!("more than {MAX_PIXELS} pixels"));
        }
        Ok(Self { width, height })
    }
}

/// Frames `start`, `start + step`, … below `end`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameRange {
    pub start: u32,
    pub end: u32,
    pub step: u32,
}

impl FrameRange {
    pub fn frames(self) -> impl ExactSizeIterator<Item = u32> {
        (self.start..self.end).step_by(self.step as usize)
    }
}

impl std::str::FromStr for FrameRange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        const FORM: &str = "expected A..B or A..B:STEP, such as 0..800:40";
        let (range, step) = text.split_once(':').unwrap_or((text, "1"));
        let (start, end) = range.split_once("..").ok_or(FORM)?;
        let number = |s: &str| s.trim().parse::<u32>().map_err(|_| FORM.to_string());
        let range = Self { start: number(start)?, end: number(end)?, step: number(step)? };
        if range.step == 0 || range.start >= range.end {
            return Err("the range is empty".into());
        }
        Ok(range)
    }
}

fn finite(text: &str) -> Result<f64, String> {
    text.trim().parse().ok().filter(|v: &f64| v.is_finite()).ok_or_else(|| "expected a number".into())
}

fn positive(text: &str) -> Result<f64, String> {
    finite(text).ok().filter(|&v| v > 0.0).ok_or_else(|| "expected a positive number".into())
}

fn budget(text: &str) -> Result<Duration, String> {
    let seconds = finite(text)? / 1e3;
    Duration::try_from_secs_f64(seconds).map_err(|_| "expected milliseconds, from 0 on".into())
}

fn field_of_view(text: &str) -> Result<f64, String> {
    let inside = |v: &f64| *v > 0.0 && *v < 180.0;
    finite(text).ok().filter(inside).ok_or_else(|| "expected degrees between 0 and 180".into())
}

fn point(text: &str) -> Result<DVec3, String> {
    let numbers: Result<Vec<f64>, String> = text.split(',').map(finite).collect();
    match numbers?[..] {
        [x, y, z] => Ok(DVec3::new(x, y, z)),
        _ => Err("expected three numbers: X,Y,Z".into()),
    }
}

fn strategy(text: &str) -> Result<Strategy, String> {
    Strategy::from_name(text).ok_or_else(|| {
        let names: Vec<_> = Strategy::ALL.iter().map(|s| s.name()).collect();
        format!("expected auto, {}", names.join(", "))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn ranges() {
        let range: FrameRange = "0..800:40".parse().unwrap();
        assert_eq!((range.frames().len(), range.frames().last()), (20, Some(760)));
        assert_eq!("3..5".parse::<FrameRange>().unwrap().frames().collect::<Vec<_>>(), [3, 4]);
        for bad in ["", "5", "5..5", "7..5", "0..9:0", "-1..3", "a..b", "0..99999999999"] {
            assert!(bad.parse::<FrameRange>().is_err(), "{bad}");
        }
    }

    #[test]
    fn budgets() {
        assert_eq!(budget("16.5").unwrap(), Duration::from_micros(16_500));
        assert_eq!(budget("0").unwrap(), Duration::ZERO);
        assert!(budget("-1").is_err() && budget("nan").is_err() && budget("1e300").is_err());
    }

    #[test]
    fn sizes_and_points() {
        assert_eq!("640x480".parse::<Size>().unwrap(), Size { width: 640, height: 480 });
        for bad in ["640", "0x5", "x", "65535x65535", "1x70000", "-1x4"] {
            assert!(bad.parse::<Size>().is_err(), "{bad}");
        }
        assert_eq!(point("1,-2.5, 3").unwrap(), DVec3::new(1.0, -2.5, 3.0));
        assert!(point("1,2").is_err() && point("1,2,nan").is_err());
    }
}
