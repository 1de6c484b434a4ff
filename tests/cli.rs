//! The `openrt` program from end to end: pictures in every format, statistics, exit codes.

use image::{AnimationDecoder, GenericImageView};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};

struct Folder(PathBuf);

impl Folder {
    fn new() -> Self {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let name = format!("openrt-cli-{}-{}", std::process::id(), NEXT.fetch_add(1, Ordering::Relaxed));
        let path = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&path).expect("the temporary folder is writable");
        Self(path)
    }

    fn path(&self, name: &str) -> String {
        self.0.join(name).to_str().expect("a plain path").to_string()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn data(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name).to_str().expect("a plain path").to_string()
}

fn openrt(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_openrt"))
        .args(args)
        .env("OPENRT_NUM_THREADS", "2")
        .output()
        .expect("the program starts")
}

/// Standard output of a run that must succeed without a word on standard error.
fn ok(args: &[&str]) -> String {
    let output = openrt(args);
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{args:?}: {errors}");
    assert_eq!(errors, "", "{args:?}");
    String::from_utf8(output.stdout).expect("output is UTF-8")
}

/// Standard error of a run that must end with `code`.
fn fails(args: &[&str], code: i32) -> String {
    let output = openrt(args);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{args:?}: {text}");
    assert!(!text.contains("panicked"), "{text}");
    text
}

fn open(path: &str) -> image::RgbaImage {
    image::open(path).unwrap_or_else(|e| panic!("{path}: {e}")).to_rgba8()
}

fn differing(a: &image::RgbaImage, b: &image::RgbaImage) -> usize {
    assert_eq!(a.dimensions(), b.dimensions());
    a.pixels().zip(b.pixels()).filter(|(a, b)| a != b).count()
}

#[test]
fn renders_every_format_of_scene_and_picture() {
    let folder = Folder::new();
    for scene in ["every.aff", "box.obj", "quad.ply", "moving.gltf"] {
        for kind in ["png", "jpg", "exr", "hdr", "ppm"] {
            let out = folder.path(&format!("{scene}.{kind}"));
            let text = ok(&["render", &data(scene), "--size", "48x36", "--out", &out]);
            assert!(text.contains("Mrays/s") && text.contains("update") && text.contains("render"), "{text}");
            let picture = image::open(&out).unwrap_or_else(|e| panic!("{out}: {e}"));
            assert_eq!(picture.dimensions(), (48, 36));
            let rgba = picture.to_rgba8();
            let first = rgba.get_pixel(0, 0);
            assert!(rgba.pixels().any(|p| p != first), "{out} shows nothing");
        }
    }
}

#[test]
fn the_scene_gives_the_size_and_the_name() {
    let folder = Folder::new();
    let output = Command::new(env!("CARGO_BIN_EXE_openrt"))
        .args(["render", &data("every.aff"), "--quiet"])
        .current_dir(&folder.0)
        .output()
        .expect("the program starts");
    assert!(output.status.success() && output.stdout.is_empty());
    assert_eq!(open(&folder.path("every.png")).dimensions(), (64, 48));
}

#[test]
fn pictures_are_the_right_way_up() {
    let folder = Folder::new();
    let scene = folder.path("up.aff");
    // Something glowing red (ambient) in the upper half, green on the right.
    let text = "v from 0 0 5 at 0 0 0 up 0 1 0 angle 40 hither 1 resolution 32 32\n l 0 0 9\n\
        fm 1 0 0 0 0 0 0 0 0 1 0 0\n p 4 -0.2 0.8 0  0.2 0.8 0  0.2 1.2 0  -0.2 1.2 0\n\
        fm 0 1 0 0 0 0 0 0 0 1 0 0\n p 4 0.8 -0.2 0  1.2 -0.2 0  1.2 0.2 0  0.8 0.2 0\n";
    std::fs::write(&scene, text).unwrap();
    let out = folder.path("up.png");
    ok(&["render", &scene, "--out", &out, "--quiet"]);
    let picture = open(&out);
    assert_eq!(picture.get_pixel(16, 7).0, [255, 0, 0, 255], "top");
    assert_eq!(picture.get_pixel(24, 16).0, [0, 255, 0, 255], "right");
    assert_eq!(picture.get_pixel(16, 24).0[..3], [0, 0, 0], "bottom");
}

/// The first texel of an AFF texture is at (0, 0): red below left, as the file of four texels says.
#[test]
fn textures_are_the_right_way_up() {
    let folder = Folder::new();
    std::fs::copy(data("checks.ppm"), folder.path("checks.ppm")).unwrap();
    let scene = folder.path("t.aff");
    let text = "v from 0.5 0.5 3 at 0.5 0.5 0 up 0 1 0 angle 20 hither 1 resolution 32 32\n l 0 0 9\n\
        fm 1 1 1 0 0 0 0 0 0 1 0 0\n tt checks.ppm 0 0 0 0 0  1 0 0 1 0  1 1 0 1 1\n tt checks.ppm 0 0 0 0 0  1 1 0 1 1  0 1 0 0 1\n";
    std::fs::write(&scene, text).unwrap();
    let out = folder.path("t.png");
    ok(&["render", &scene, "--out", &out, "--quiet"]);
    let picture = open(&out);
    let strongest = |x: u32, y: u32| {
        let p = picture.get_pixel(x, y).0;
        (p[0] > 128, p[1] > 128, p[2] > 128)
    };
    assert_eq!(strongest(8, 24), (true, false, false), "red below left");
    assert_eq!(strongest(24, 24), (false, true, false), "green below right");
    assert_eq!(strongest(8, 8), (false, false, true), "blue above left");
    assert_eq!(strongest(24, 8), (true, true, true), "white above right");
}

#[test]
fn things_move_between_frames() {
    let folder = Folder::new();
    let pattern = folder.path("run/f%03d.png");
    let text = ok(&["play", &data("every.aff"), "--frames", "0..21:10", "--size", "64x48", "--out", &pattern]);
    assert_eq!(text.lines().filter(|l| l.starts_with("frame ")).count(), 3, "{text}");
    assert!(text.contains("3 frames in") && text.contains("frames per second") && text.contains("median"), "{text}");
    assert!(text.contains(&format!("written to {pattern}\n")), "can be typed again: {text}");
    let frames: Vec<_> = ["000", "010", "020"].map(|n| open(&folder.path(&format!("run/f{n}.png")))).into();
    assert!(differing(&frames[0], &frames[1]) > 50 && differing(&frames[1], &frames[2]) > 50);
    // A frame of `play` is the picture of `render` at that frame, and at its time.
    let single = folder.path("single.png");
    ok(&["render", &data("every.aff"), "--frame", "10", "--size", "64x48", "--out", &single, "--quiet"]);
    assert_eq!(differing(&frames[1], &open(&single)), 0);
    ok(&["render", &data("every.aff"), "--time", "1", "--size", "64x48", "--out", &single, "--quiet"]);
    assert_eq!(differing(&frames[1], &open(&single)), 0);
}

#[test]
fn animations_hold_all_frames() {
    let folder = Folder::new();
    let (gif, apng) = (folder.path("a.gif"), folder.path("a.apng"));
    for out in [&gif, &apng] {
        ok(&["play", &data("moving.gltf"), "--frames", "0..25:6", "--size", "32x24", "--out", out, "--quiet"]);
    }
    let file = std::io::BufReader::new(std::fs::File::open(&gif).unwrap());
    let frames = image::codecs::gif::GifDecoder::new(file).unwrap().into_frames().collect_frames().unwrap();
    assert_eq!(frames.len(), 5);
    assert!(differing(frames[0].buffer(), frames[4].buffer()) > 20);
    let file = std::io::BufReader::new(std::fs::File::open(&apng).unwrap());
    let decoder = image::codecs::png::PngDecoder::new(file).unwrap().apng().unwrap();
    let frames = decoder.into_frames().collect_frames().unwrap();
    assert_eq!(frames.len(), 5);
    assert_eq!(frames[0].delay().numer_denom_ms(), (250, 1), "six frames of 1/24 s");
}

#[test]
fn a_folder_is_numbered() {
    let folder = Folder::new();
    ok(&[
        "play",
        &data("every.aff"),
        "--frames",
        "3..5",
        "--size",
        "8x6",
        "--out",
        &folder.path("new/frames"),
        "--quiet",
    ]);
    assert!(Path::new(&folder.path("new/frames/frame_0003.png")).is_file());
    assert!(Path::new(&folder.path("new/frames/frame_0004.png")).is_file());
}

#[test]
fn a_range_beyond_the_end_is_cut() {
    let folder = Folder::new();
    let text =
        ok(&["play", &data("every.aff"), "--frames", "0..800:15", "--size", "8x6", "--out", &folder.path("f%d.png")]);
    assert!(text.contains("the animation ends with frame 20") && text.contains("2 frames in"), "{text}");
}

/// Output of a run that must succeed, with `input` on its standard input.
fn piped(args: &[&str], input: &[u8]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_openrt"));
    command.args(args).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("the program starts");
    // One that does not read its input ends by itself.
    let _ = child.stdin.take().expect("piped").write_all(input);
    let output = child.wait_with_output().expect("the program ends");
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    output
}

#[test]
fn minus_is_the_standard_input_and_output() {
    let folder = Folder::new();
    for scene in ["moving.gltf", "box.obj", "quad.ply"] {
        let out = folder.path("file.png");
        ok(&["render", &data(scene), "--size", "24x18", "--out", &out, "--quiet"]);
        let bytes = std::fs::read(data(scene)).unwrap();
        let output = piped(&["render", "-", "--size", "24x18", "--out", "-"], &bytes);
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(text.contains("-: ") && text.contains("written to -"), "{text}");
        let picture = image::load_from_memory(&output.stdout).expect("nothing but the picture").to_rgba8();
        // What the scene names beside itself is not found from there.
        if !text.contains("warning") {
            assert_eq!(differing(&picture, &open(&out)), 0, "{scene}");
        }
    }
    // One picture after the other, as programs that make films take them.
    let output = piped(
        &["play", &data("every.aff"), "--frames", "0..3", "--size", "8x6", "--out", "-", "--kind", "ppm", "--quiet"],
        b"",
    );
    let frame = b"P6\n8 6 255\n".len() + 8 * 6 * 3;
    assert_eq!(output.stdout.len(), 3 * frame);
    assert!(output.stdout.chunks(frame).all(|f| f.starts_with(b"P6\n8 6 255\n")) && output.stderr.is_empty());
    assert!(
        fails(&["render", &data("every.aff"), "--out", "-", "--json"], 1).contains("both want the standard output")
    );
}

#[test]
fn json_is_one_object() {
    let folder = Folder::new();
    let parsed = |args: &[&str]| -> serde_json::Value { serde_json::from_str(&ok(args)).expect("one object") };
    let out = folder.path("f%02d.png");
    let play = parsed(&["play", &data("every.aff"), "--frames", "0..3", "--size", "8x6", "--out", &out, "--json"]);
    assert_eq!(play["frames"].as_array().map(Vec::len), Some(3));
    assert_eq!((&play["summary"]["frames"], &play["width"], &play["written"]), (&3.into(), &8.into(), &out.into()));
    for number in ["seconds", "frames_per_second", "median_ms", "slowest_ms", "rays", "rays_per_second"] {
        assert!(play["summary"][number].as_f64().is_some_and(|n| n > 0.0), "{number}: {play}");
    }
    assert_eq!(play["frames"][2]["primary_rays"], 48);
    let info = parsed(&["info", &data("every.aff"), "--json", "--long"]);
    assert_eq!(info["animation"]["frames"], 21);
    assert!(info["triangles"].as_u64().is_some_and(|n| n > 0) && info["object_names"].is_array(), "{info}");
}

#[test]
fn shells_complete_the_command_line() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = ok(&["completions", shell]);
        assert!(script.contains("openrt") && script.contains("strategy") && script.contains("play"), "{shell}");
    }
}

#[test]
fn what_lies_beyond_the_animation_is_told() {
    let folder = Folder::new();
    let render = |scene: &str, more: &[&str]| {
        let (scene, out) = (data(scene), folder.path("b.png"));
        let mut args = vec!["render", &scene, "--size", "8x6", "--out", &out];
        args.extend(more);
        ok(&args)
    };
    assert!(render("every.aff", &["--time", "99"]).contains("the animation goes from 0 s to 2 s"));
    assert!(!render("every.aff", &["--time", "2"]).contains("the animation goes"));
    assert!(render("box.obj", &["--time", "1"]).contains("no animation"));
    assert!(render("box.obj", &["--frame", "7"]).contains("no animation"));
    assert!(!render("box.obj", &["--frame", "0"]).contains("no animation"));
}

#[test]
fn an_animation_is_chosen_by_name_or_number() {
    let folder = Folder::new();
    let file = std::fs::read_to_string(data("moving.gltf")).unwrap();
    let mut file: serde_json::Value = serde_json::from_str(&file).unwrap();
    // A second one, which moves the same node to elsewhere.
    let mut second = file["animations"][0].clone();
    file["animations"][0]["name"] = "walk".into();
    second["name"] = "stand".into();
    second["channels"].as_array_mut().unwrap().truncate(1);
    second["channels"][0]["target"]["node"] = 0.into();
    let mut third = second.clone();
    third["name"] = "both".into();
    file["animations"].as_array_mut().unwrap().extend([second, third]);
    let scene = folder.path("three.gltf");
    std::fs::write(&scene, file.to_string()).unwrap();
    let picture = |more: &[&str]| {
        let out = folder.path("c.png");
        let mut args = vec!["render", &scene, "--frame", "1", "--size", "32x24", "--out", &out, "--quiet"];
        args.extend(more);
        ok(&args);
        open(&out)
    };
    let first = picture(&[]);
    assert_eq!(first, picture(&["--animation", "0"]));
    let other = picture(&["--animation", "1"]);
    assert_ne!(first, other);
    assert_eq!(other, picture(&["--animation", "both"]));
    let text = fails(&["info", &scene, "--animation", "run"], 1);
    assert!(text.contains("there is no animation run") && text.contains("both"), "{text}");
    let text = fails(&["info", &data("box.obj"), "--animation", "0"], 1);
    assert!(text.contains("no animations"), "{text}");
}

/// What an overview shows is whole, however narrow the picture.
#[test]
fn overviews_fit_narrow_pictures() {
    let folder = Folder::new();
    let lit = |size: &str| {
        let out = folder.path("n.png");
        ok(&["render", &data("quad.ply"), "--size", size, "--out", &out, "--quiet"]);
        let picture = open(&out);
        let (width, height) = picture.dimensions();
        // The sky is pale, and the mesh is not. The border shows the sky: nothing is cut off.
        let border = (0..width).flat_map(|x| [(x, 0), (x, height - 1)]);
        let border = border.chain((0..height).flat_map(|y| [(0, y), (width - 1, y)]));
        let is_mesh = |&image::Rgba([r, g, b, _]): &image::Rgba<u8>| r.max(g).max(b) > 100 && r.min(g).min(b) < 60;
        assert_eq!(border.filter(|&(x, y)| is_mesh(picture.get_pixel(x, y))).count(), 0, "{size}");
        picture.pixels().filter(|p| is_mesh(p)).count()
    };
    assert!(lit("40x40") > 40);
    assert!(lit("40x160") > 40);
    assert!(lit("160x40") > 40);
}

/// Killed or refused in the middle of writing, a run leaves the file that was there.
#[cfg(unix)]
#[test]
fn old_files_stay_until_new_ones_are_whole() {
    let folder = Folder::new();
    for (name, refused) in [("a.png", true), ("a.ppm", false), ("a.exr", true), ("a.gif", true), ("a.apng", false)] {
        let out = folder.path(name);
        std::fs::write(&out, "old").unwrap();
        let verb = if name.ends_with("gif") || name.ends_with("apng") { "play" } else { "render" };
        // A block is 512 or 1024 bytes; the picture takes more. Unless it is ignored, the signal kills.
        let trap = if refused { "trap '' XFSZ; " } else { "" };
        let line = format!(
            "{trap}ulimit -c 0; ulimit -f 8; exec {} {verb} {} --size 320x240 --out {out} --quiet",
            env!("CARGO_BIN_EXE_openrt"),
            data("moving.gltf"),
        );
        let output = Command::new("sh").args(["-c", &line]).output().expect("sh");
        assert_eq!(output.status.code(), refused.then_some(1), "{name}: {output:?}");
        assert_eq!(std::fs::read(&out).unwrap(), b"old", "{name}");
        if refused {
            let text = String::from_utf8_lossy(&output.stderr);
            assert!(text.contains(name) && text.contains("large"), "{text}");
        }
    }
    let left = std::fs::read_dir(&folder.0)
        .unwrap()
        .filter(|e| e.as_ref().unwrap().file_name().to_str().unwrap().starts_with(".openrt-"));
    assert_eq!(left.count(), 2, "only those that were killed left something");
}

#[test]
fn options_reach_the_picture() {
    let folder = Folder::new();
    let render = |name: &str, options: &[&str]| {
        let out = folder.path(&format!("{name}.png"));
        let scene = data("every.aff");
        let mut args = vec!["render", &scene, "--out", &out, "--quiet"];
        args.extend(options);
        ok(&args);
        open(&out)
    };
    let plain = render("plain", &[]);
    for options in [
        &["--depth", "0"][..],
        &["--shadows", "off"],
        &["--samples", "4"],
        &["--srgb", "on"],
        &["--fov", "20"],
        &["--eye", "-3,2,8"],
        &["--at=-1,1,0"],
        &["--up", "1,1,0"],
        &["--renderer", "raycast"],
        &["--renderer", "ambient_occlusion"],
        &["--renderer", "path"],
    ] {
        assert!(differing(&plain, &render("changed", options)) > 10, "{options:?} changes nothing");
    }
    // What must not change a bit.
    for options in [&["--threads", "3"][..], &["--strategy", "sah"], &["--strategy", "bsp"], &["--strategy", "refit"]] {
        assert_eq!(differing(&plain, &render("same", options)), 0, "{options:?}");
    }
}

#[test]
fn wrong_command_lines_end_with_2() {
    let scene = data("every.aff");
    for args in [
        &[][..],
        &["fly", &scene],
        &["render"],
        &["render", &scene, "--size", "0x9"],
        &["render", &scene, "--frame", "1", "--time", "1"],
        &["render", &scene, "--renderer", "magic"],
        &["render", &scene, "--strategy", "magic"],
        &["render", &scene, "--fov", "180"],
        &["render", &scene, "--eye", "1,2"],
        &["render", &scene, "--samples", "0"],
        &["play", &scene, "--frames", "5..1"],
        &["play", &scene, "--fps", "0"],
    ] {
        fails(args, 2);
    }
    assert!(ok(&["--help"]).contains("Renders the frames of an animation"));
    assert!(ok(&["--version"]).starts_with("openrt "));
}

#[test]
fn what_cannot_be_done_ends_with_1() {
    let folder = Folder::new();
    let scene = data("every.aff");
    let out = folder.path("x.png");
    assert!(fails(&["render", &folder.path("none.aff"), "--out", &out], 1).contains("none.aff"));
    assert!(fails(&["render", &scene, "--out", &folder.path("x.bmp")], 1).contains("unknown kind of picture"));
    assert!(fails(&["render", &scene, "--frame", "21", "--out", &out], 1).contains("frames 0 to 20"));
    assert!(fails(&["play", &scene, "--frames", "30..50", "--out", &out], 1).contains("frames 0 to 20"));
    assert!(fails(&["render", &scene, "--out", "/proc/none/x.png"], 1).contains("/proc/none"));
    assert!(
        fails(&["render", &scene, "--eye", "0,1,0", "--at", "0,1,0", "--out", &out], 1)
            .contains("eye and center must be apart")
    );
}
