//! Golden pictures: each example and one frame of each BART scene look as they did when somebody last looked at them.
//!
//! The pictures lie in `tests/golden/`. A difference writes `expected | difference | actual` side by side into
//! `tests/diffs/`. `OPENRT_BLESS=1 cargo test --features cli --test golden` rewrites them: look at what changed before
//! you commit. The examples take sines from the system's C library, so a few pixels may differ between machines.

#[path = "common/skip.rs"]
mod skip;

#[path = "common/examples.rs"]
mod examples;

use image::{Rgb, RgbImage};
use skip::skipped;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A channel that differs by at most this much is equal: the last bit of a sine, rounded to 8 bits.
const CHANNEL_TOLERANCE: u8 = 2;
/// Share of pixels that may differ by more: silhouettes that the last bit of a sine moves over a pixel centre.
const DIFFERENT_PIXELS: f64 = 0.001;

/// Each example with the frame that is looked at.
const EXAMPLES: &[(&str, Option<u32>)] = &[
    ("triangle", None),
    ("instances", Some(1)),
    ("wave", Some(1)),
    ("lights", None),
    ("forest", None),
    ("robot", Some(1)),
    ("plugin", None),
    ("picking", Some(1)),
    ("bodies", Some(1)),
    ("museum", Some(1)),
    ("nbody", Some(1)),
    ("hello", None),
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn load(path: &Path) -> RgbImage {
    image::open(path).unwrap_or_else(|e| panic!("{}: {e}", path.display())).to_rgb8()
}

fn pixel_differs(a: &Rgb<u8>, b: &Rgb<u8>) -> bool {
    a.0.iter().zip(b.0).any(|(&a, b)| a.abs_diff(b) > CHANNEL_TOLERANCE)
}

/// Share of pixels that differ visibly; 1 if the sizes do.
fn difference(expected: &RgbImage, actual: &RgbImage) -> f64 {
    if expected.dimensions() != actual.dimensions() {
        return 1.0;
    }
    let different = expected.pixels().zip(actual.pixels()).filter(|(a, b)| pixel_differs(a, b)).count();
    different as f64 / f64::from(expected.width() * expected.height())
}

/// `expected | difference | actual`, the difference white where it counts and amplified elsewhere.
fn side_by_side(expected: &RgbImage, actual: &RgbImage) -> RgbImage {
    let (w, h) = (expected.width().max(actual.width()), expected.height().max(actual.height()));
    RgbImage::from_fn(3 * w, h, |x, y| {
        let (x, part) = (x % w, x / w);
        let of = |picture: &RgbImage| picture.get_pixel_checked(x, y).copied().unwrap_or(Rgb([255, 0, 255]));
        let (e, a) = (of(expected), of(actual));
        match part {
            0 => e,
            1 if pixel_differs(&e, &a) => Rgb([255; 3]),
            1 => Rgb([0, 1, 2].map(|i| e.0[i].abs_diff(a.0[i]).saturating_mul(60))),
            _ => a,
        }
    })
}

/// Compares `actual` with the golden picture `name`, or rewrites that when blessing.
fn check(name: &str, actual: &Path) -> Result<(), String> {
    let golden = root().join("tests/golden").join(format!("{name}.png"));
    let actual = load(actual);
    if std::env::var_os("OPENRT_BLESS").is_some_and(|v| v == "1") {
        actual.save(&golden).map_err(|e| format!("{}: {e}", golden.display()))?;
        eprintln!("blessed {}", golden.display());
        return Ok(());
    }
    let expected = load(&golden);
    let share = difference(&expected, &actual);
    if share <= DIFFERENT_PIXELS {
        return Ok(());
    }
    let diffs = root().join("tests/diffs");
    std::fs::create_dir_all(&diffs).map_err(|e| format!("{}: {e}", diffs.display()))?;
    let path = diffs.join(format!("{name}.png"));
    side_by_side(&expected, &actual).save(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    Err(format!("{name}: {:.2} % of the pixels differ, see {}", 100.0 * share, path.display()))
}

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).expect("cargo's folder for tests is writable");
    folder
}

#[test]
fn the_comparison_sees_what_matters() {
    let grey = RgbImage::from_pixel(100, 100, Rgb([100; 3]));
    let mut other = grey.clone();
    other.pixels_mut().for_each(|p| p.0[1] += CHANNEL_TOLERANCE);
    assert_eq!(difference(&grey, &other), 0.0, "the last bits are no difference");
    for x in 0..11 {
        other.put_pixel(x, 50, Rgb([100, 100, 110]));
    }
    assert!(difference(&grey, &other) > DIFFERENT_PIXELS, "eleven pixels of ten thousand are one");
    assert_eq!(difference(&grey, &RgbImage::new(100, 99)), 1.0);
    let strip = side_by_side(&grey, &other);
    assert_eq!(strip.dimensions(), (300, 100));
    assert_eq!((strip.get_pixel(0, 50).0, strip.get_pixel(100, 50).0), ([100; 3], [255; 3]));
}

#[test]
fn examples_look_as_they_did() {
    let builder = match examples::Builder::new(folder("golden_build")) {
        Ok(builder) => builder,
        Err(why) => return skipped(format_args!("golden pictures of the examples, {why}")),
    };
    let out = folder("golden_examples");
    let mut faults = Vec::new();
    for &(name, frame) in EXAMPLES {
        if name == "hello" && !builder.has_cxx() {
            skipped("golden picture of hello.cpp, no C++ compiler (c++)");
            continue;
        }
        let picture = out.join(match frame {
            Some(n) => format!("{name}_{n:03}.png"),
            None => format!("{name}.png"),
        });
        let frames = if frame.is_some() { "4" } else { "1" };
        let options = ["--size", "128x96", "--frames", frames, "--out"].map(OsStr::new);
        let shown = builder
            .build(name)
            .and_then(|program| examples::run(Command::new(program).args(options).arg(&out)))
            .and_then(|()| check(name, &picture));
        faults.extend(shown.err());
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// One frame of each BART scene, loaded and rendered by the command-line program.
#[test]
fn bart_scenes_look_as_they_did() {
    let bart = root().join("../shared/bart");
    // Cargo names the program's place also when its required feature is off and it is not built.
    let Some(program) = option_env!("CARGO_BIN_EXE_openrt").filter(|_| cfg!(feature = "cli")) else {
        return skipped("golden pictures of the BART scenes, built without the feature cli");
    };
    if !bart.is_dir() {
        return skipped(format_args!("golden pictures of the BART scenes, no folder {}", bart.display()));
    }
    let out = folder("golden_bart");
    let mut faults = Vec::new();
    for (name, scene, frame) in [
        ("kitchen", "kitchen/aff/kitchen.aff", "300"),
        ("robots", "robot/aff/Robot.aff", "300"),
        ("bart_museum", "museum/aff/museum5.aff", "150"),
    ] {
        let picture = out.join(format!("{name}.png"));
        let mut command = Command::new(program);
        command.arg("render").arg(bart.join(scene)).args(["--frame", frame, "--size", "128x96", "--out"]);
        let shown = examples::run(command.arg(&picture)).and_then(|()| check(name, &picture));
        faults.extend(shown.err());
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
