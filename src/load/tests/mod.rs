//! Grammar, faults and hostile files, for all formats.

#[path = "../../../tests/common/skip.rs"]
mod skip;

use super::{LoadError, ReadOptions, read_format, read_with};
use crate::load::model::{Background, Deform, Local, Projection, SceneFile};
use glam::{DVec3, Vec3};
use skip::skipped;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

/// A folder that goes with its guard.
struct Folder(PathBuf);

impl Folder {
    fn new() -> Self {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let name = format!("openrt-loaders-{}-{}", std::process::id(), NEXT.fetch_add(1, Ordering::Relaxed));
        let path = std::env::temp_dir().join(name);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, bytes).unwrap();
        path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn load(path: &Path, detail: f64) -> Result<SceneFile, LoadError> {
    read_with(path, &ReadOptions { detail })
}

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

fn aff(text: impl AsRef<[u8]>) -> Result<SceneFile, LoadError> {
    load(&Folder::new().write("scene.aff", text), 0.0)
}

/// The message of a scene that must not load, without its folder.
fn fault(text: &str) -> String {
    let error = aff(text).expect_err(text).to_string();
    error[error.find("scene.aff").expect("the message names the file")..].to_string()
}

#[test]
fn every_statement_is_understood() {
    let scene = load(&data("every.aff"), 0.0).unwrap();
    assert_eq!(scene.warnings, [""; 0]);
    assert_eq!(scene.notes, [""; 0]);
    let c = &scene.counts;
    assert_eq!((c.spheres, c.cones, c.polygons, c.polygon_triangles), (1, 1, 2, 3));
    assert_eq!((c.textured_triangles, c.animated_triangles, c.meshes, c.mesh_triangles), (2, 1, 3, 5));
    assert_eq!((c.static_transforms, c.files), (1, 3));
    assert_eq!((c.translation_keys, c.rotation_keys, c.scale_keys, c.visibility_keys), (12, 4, 4, 2));
    assert_eq!(scene.named_transforms, ["flap"]);
    assert_eq!(scene.textures.len(), 1, "one texture, used four times");
    assert_eq!(scene.background, Background::Color(Vec3::new(0.2, 0.3, 0.4)));
    assert_eq!(scene.ambient, Vec3::splat(0.5));
    assert_eq!(scene.animation.map(|a| (a.start, a.end, a.frames)), Some((0.0, 2.0, 21)));
    let camera = &scene.cameras[0];
    assert_eq!(camera.projection, Projection::Perspective { fov_y: 40.0 });
    assert_eq!(camera.resolution, Some((64, 48)));
    // Static, key-framed, and the object of the named transform.
    assert_eq!(scene.objects.len(), 3);
    assert_eq!(scene.objects.iter().filter(|o| matches!(o.deform, Deform::Triangles(_))).count(), 1);
}

#[test]
fn transforms_and_keys_move_things() {
    let scene = load(&data("every.aff"), 0.0).unwrap();
    let flap = scene.objects.iter().find(|o| o.name == "flap").unwrap();
    let corner = |time: f64| flap.world_from_object(&scene.pose(time)).transform_point3(DVec3::X);
    // xs: scale 2, turn by 90° about y, move: +x goes to −z.
    assert!((corner(0.0) - DVec3::new(-2.0, 0.0, 0.0)).length() < 1e-9, "{}", corner(0.0));
    // Moved up by 1 (doubled), turned by −10° about z (the shorter way to 350°).
    let turned = (-10.0_f64).to_radians();
    let expected = DVec3::new(-2.0, 2.0 * (1.0 + turned.sin()), 2.0 - 2.0 * turned.cos());
    assert!((corner(2.0) - expected).length() < 1e-9, "{} {expected}", corner(2.0));
    let visible = |time: f64| scene.pose(time)[flap.node as usize].visible;
    assert!(visible(1.49) && !visible(1.5));
    let lamp = |time: f64| scene.lights[1].placed(time, &scene.pose(time)).unwrap().0;
    assert_eq!((lamp(0.0), lamp(2.0)), (Vec3::new(-4.0, 6.0, 5.0), Vec3::new(-4.0, 7.0, 5.0)));
    // The light without a colour has its share of two.
    assert!((scene.lights[0].color.x - 0.5_f32.sqrt()).abs() < 1e-6);
    let camera = scene.cameras[0].view(2.0, &scene.pose(2.0));
    assert!((camera.from - DVec3::new(1.0, 2.0, 9.0)).length() < 1e-12);
    assert_eq!(camera.forward, DVec3::new(0.0, -1.0, -9.0), "not keyed, so as the view says");
    let keyed = scene.objects.iter().find(|o| matches!(o.deform, Deform::Triangles(_))).unwrap();
    let deformed = keyed.deformed(0.5, &scene.pose(0.5), &scene.nodes).unwrap();
    assert_eq!(deformed.positions[0], Vec3::new(3.0, 2.5, 0.0));
}

#[test]
fn detail_opens_further_includes() {
    let folder = Folder::new();
    folder.write("more.aff", "s 0 0 0 1");
    let path = folder.write("scene.aff", "i 2 more.aff\nd 2\ni 2 more.aff\n");
    assert_eq!(load(&path, 0.0).unwrap().counts.spheres, 1);
    assert_eq!(load(&path, 2.0).unwrap().counts.spheres, 2);
}

#[test]
fn faults_are_told_with_file_and_line() {
    let view = "v\nfrom 0 0 0\nat 0 0 1\nup 0 1 0\nangle 40\n";
    let cases: &[(&str, u32, &str)] = &[
        ("\n\ns 1 2 x 4", 3, "the centre of a sphere is expected, found `x`"),
        ("s 1 2 3", 1, "the file ends where the radius of a sphere is expected"),
        ("s 1 2 nan 4", 1, "found `nan`"),
        ("s 1 2 3 1e99", 1, "too large"),
        ("b 1 2", 1, "a background colour"),
        ("am 1 2 }", 1, "an ambient colour"),
        ("l 1 2", 1, "a light position"),
        ("l 1 2 3 0.5 z", 1, "a light colour"),
        ("la", 1, "the name of an animated light"),
        ("f 1 1 1 0.5", 1, "Kd and Ks"),
        ("fm 1 1 1 0.5", 1, "a diffuse colour"),
        ("c 0 0 0 1  0 0 0 1", 1, "coincide"),
        ("p 2 0 0 0 1 0 0", 1, "at least 3 corners"),
        ("p -3", 1, "a whole number"),
        ("p 4000000000 0 0 0", 1, "the file ends where"),
        ("pp 3 0 0 0", 1, "a normal of a polygon"),
        ("tt", 1, "the name of a texture"),
        ("tpa 0", 1, "at least one key"),
        ("tpa 2\n1 0 0 0 0 0 1 1 0 0 0 0 1 0 1 0 0 0 1\n0 0 0 0 0 0 1 1 0 0 0 0 1 0 1 0 0 0 1", 3, "back in time"),
        ("m normals 3", 1, "`vertices` expected, found `normals`"),
        (
            "m vertices 1 0 0 0\nnormals 1 0 0 1\ntriangles 1\n0 0 0\n0 0 1",
            5,
            "a normal number is 1, but the mesh has only 1",
        ),
        ("m vertices 1 0 0 0 triangles 1 0 0 7", 1, "a vertex number is 7"),
        ("m vertices 1 0 0 0 triangles 1 0 0 -1", 1, "a whole number"),
        ("m vertices 1 0 0 0", 1, "the file ends where `triangles` is expected"),
        ("a 5 1 10", 1, "start ≤ end"),
        ("a 0 1 0", 1, "at least one frame"),
        ("i 0 nothing.aff", 1, "included file `nothing.aff` does not exist"),
        ("\ni 0 scene.aff", 2, "`scene.aff` includes itself"),
        ("i 0 ../outside.aff", 1, "lies outside the scene's folder"),
        ("i 0 /etc/passwd", 1, "is an absolute path"),
        ("xs 1 1 1 0 0 0 30 0 0 0 { }", 1, "the rotation axis has no length"),
        ("xs 1 1 1 0 1 0 30 0 0 0 s", 1, "`{` expected, found `s`"),
        ("\nx arm {\n s 0 0 0 1", 2, "this `{` is not closed"),
        ("s 0 0 0 1\n}", 2, "`}` without a `{`"),
        ("x {", 1, "a brace where the name of a transform is expected"),
        ("k a { transl 3", 1, "`a` has 3 keys, a spline needs at least 4"),
        ("k a {\n turn 4 }", 2, "found `turn`"),
        ("k a {\n", 2, "the file ends inside the key frames of `a`"),
        ("k a { rot 4 0 0 0 0 90 0 0 0", 1, "an axis without length"),
        ("k a { visibility 2 1 1 0 1 }", 1, "must not go back in time"),
        ("v\nfrom 0 0 0\nat 0 0 1\nup 0 1 0\n", 1, "the view has no `angle`"),
        ("v from 0 0 0 at 0 0 1 up 0 1 0 angle 180", 1, "between 0 and 180"),
        ("\nv from 0 0 0 at 0 1 0 up 0 1 0 angle 40", 2, "parallel"),
        ("d x", 1, "a level of detail"),
    ];
    for (text, line, words) in cases {
        let message = fault(text);
        assert!(message.starts_with(&format!("scene.aff:{line}: ")), "{text:?} gave {message}");
        assert!(message.contains(words), "{text:?} gave {message}");
    }
    assert!(aff(view).is_ok());
}

#[test]
fn what_is_not_known_is_skipped_with_a_warning() {
    let scene = aff("\nzz 1 2 3\ns 0 0 0 1\ntt no.ppm 0 0 0 0 0 1 0 0 1 0 0 1 0 0 1").unwrap();
    assert_eq!(scene.counts.spheres, 1);
    assert_eq!(scene.warnings.len(), 2);
    assert!(scene.warnings[0].contains("scene.aff:2: unknown statement `zz`"), "{}", scene.warnings[0]);
    assert!(scene.warnings[1].contains("scene.aff:4: texture `no.ppm` does not exist"), "{}", scene.warnings[1]);
    // A file of another kind does not flood the screen.
    assert!(aff("?\n".repeat(5000)).unwrap().warnings.len() < 200);
}

#[test]
fn includes_are_bounded() {
    let folder = Folder::new();
    // Every file includes the next one twice: 2^40 files if it were not bounded by depth.
    for i in 0..40 {
        folder.write(&format!("f{i}.aff"), format!("i 0 f{}.aff\n", i + 1).repeat(2));
    }
    folder.write("f40.aff", "");
    let error = load(&folder.0.join("f0.aff"), 0.0).unwrap_err().to_string();
    assert!(error.contains("deep") || error.contains("too many"), "{error}");
    for i in 0..30 {
        folder.write(&format!("g{i}.aff"), format!("i 0 g{}.aff\n", i + 1).repeat(2));
    }
    folder.write("g30.aff", "");
    let error = load(&folder.0.join("g0.aff"), 0.0).unwrap_err().to_string();
    assert!(error.contains("too many"), "{error}");
}

#[cfg(unix)]
#[test]
fn links_do_not_lead_out_of_the_tree() {
    let (outside, inside) = (Folder::new(), Folder::new());
    let secret = outside.write("secret.aff", "s 0 0 0 1");
    std::os::unix::fs::symlink(&secret, inside.0.join("link.aff")).unwrap();
    let path = inside.write("scene.aff", "i 0 link.aff");
    assert!(load(&path, 0.0).unwrap_err().to_string().contains("outside"));
}

#[test]
fn textures_lie_in_the_sibling_folder() {
    let folder = Folder::new();
    let ppm = "P3 1 1 255 1 2 3";
    folder.write("TextureFiles/a.ppm", ppm);
    folder.write("aff/b.ppm", ppm);
    let triangle = "0 0 0 0 0 1 0 0 1 0 0 1 0 0 1\n";
    let text = format!("tt a.ppm {triangle} tt b.ppm {triangle} tt ../TextureFiles/a.ppm {triangle}");
    let path = folder.write("aff/scene.aff", text);
    let scene = load(&path, 0.0).unwrap();
    assert_eq!((scene.textures.len(), scene.warnings.len()), (3, 0), "{:?}", scene.warnings);
}

#[test]
fn obj_with_materials() {
    let scene = load(&data("box.obj"), 0.0).unwrap();
    assert_eq!(scene.warnings, [""; 0]);
    assert_eq!((scene.counts.mesh_triangles, scene.objects.len(), scene.textures.len()), (3, 1, 1));
    let painted = scene.materials.iter().find(|m| m.name == "painted").unwrap();
    assert_eq!((painted.shininess, painted.texture, painted.reflection), (40.0, Some(0), Vec3::splat(0.5)));
    let pane = scene.materials.iter().find(|m| m.name == "pane").unwrap();
    assert_eq!((pane.transmission, pane.ior), (0.75, 1.5));
    let mesh = &scene.objects[0].mesh;
    let used: Vec<&str> = mesh.materials.iter().map(|&m| scene.materials[m as usize].name.as_str()).collect();
    assert_eq!(used, ["painted", "painted", "pane"]);
}

#[test]
fn faults_of_obj_files() {
    let folder = Folder::new();
    let check = |text: &str, line: u32, words: &str| {
        let error = load(&folder.write("bad.obj", text), 0.0).unwrap_err().to_string();
        assert!(error.contains(&format!("bad.obj:{line}: ")) && error.contains(words), "{text:?} gave {error}");
    };
    check("v 0 0 0\nv 1 0 zero\n", 2, "position");
    check("v 0 0 0\nv 1 0 0\nv 0 1 0\n\nf 1 2 9\n", 5, "out of bounds");
    check("v 0 0 0\nv 1 0 0\nf 1 2 x\n", 3, "face");
    let path = folder.write("lost.obj", "# \nmtllib lost.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let scene = load(&path, 0.0).unwrap();
    assert!(
        scene.warnings[0].contains("lost.obj:2: material library `lost.mtl` does not exist"),
        "{:?}",
        scene.warnings
    );
    folder.write("odd.mtl", "newmtl a\nKd 1 x 1\n");
    let path = folder.write("odd.obj", "mtllib odd.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    assert!(load(&path, 0.0).unwrap().warnings[0].contains("odd.mtl:2: "));
}

#[test]
fn ply_with_colours() {
    let scene = load(&data("quad.ply"), 0.0).unwrap();
    let mesh = &scene.objects[0].mesh;
    assert_eq!((mesh.triangles.len(), mesh.positions.len(), mesh.colors.len()), (3, 5, 5));
    assert_eq!(mesh.colors[2].truncate(), Vec3::Z);
}

#[test]
fn faults_of_ply_files() {
    let folder = Folder::new();
    let header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                  element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    let check = |text: &str, words: &str| {
        let error = load(&folder.write("bad.ply", text), 0.0).unwrap_err().to_string();
        assert!(error.contains("bad.ply") && error.contains(words), "{text:?} gave {error}");
    };
    check(&format!("{header}0 0 0\n1 0 zero\n0 1 0\n3 0 1 2\n"), "bad.ply:11: ");
    check(&format!("{header}0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"), "face 0 names a vertex that does not exist");
    check(&format!("{header}0 0 0\n1 0 0\n"), "bad.ply:1");
    check(&header.replace("vertex 3", "vertex 4000000000"), "cannot be in a file of");
    check("plx\n", "bad.ply");
}

#[test]
fn gltf_moves_bends_and_morphs() {
    let scene = load(&data("moving.gltf"), 0.0).unwrap();
    assert_eq!(scene.warnings, [""; 0]);
    assert_eq!((scene.cameras.len(), scene.lights.len(), scene.textures.len()), (1, 1, 1));
    assert_eq!(scene.animation.map(|a| (a.end, a.frames)), Some((1.0, 25)));
    assert_eq!(scene.named_transforms, ["mover", "tip"]);
    let object = |name: &str| scene.objects.iter().find(|o| o.name == name).unwrap();
    // The quad under the still node is baked; the one under the mover is an object that moves.
    assert!(scene.objects.iter().any(|o| o.node == 0 && o.mesh.positions[0] == Vec3::new(-4.0, 0.0, 0.0)));
    let at = |name: &str, time: f64, vertex: usize| {
        let object = object(name);
        let poses = scene.pose(time);
        let local =
            object.deformed(time, &poses, &scene.nodes).map_or(object.mesh.positions[vertex], |d| d.positions[vertex]);
        object.world_from_object(&poses).transform_point3(local.as_dvec3()).as_vec3()
    };
    assert_eq!((at("quad", 0.0, 0), at("quad", 1.0, 0)), (Vec3::new(-1.0, 0.0, 0.0), Vec3::new(-1.0, 1.0, 0.0)));
    assert_eq!(at("stretched", 0.5, 2), Vec3::new(1.0, 5.25, 0.0));
    // Vertices of the tip turn by 90° about (3, 1, 0); those of the bone stay; the mesh's own node counts for nothing.
    assert!((at("bent", 0.0, 2) - Vec3::new(4.0, 2.0, 0.0)).length() < 1e-5, "{}", at("bent", 0.0, 2));
    assert!((at("bent", 1.0, 2) - Vec3::new(2.0, 2.0, 0.0)).length() < 1e-5, "{}", at("bent", 1.0, 2));
    assert!((at("bent", 1.0, 0) - Vec3::new(2.0, 0.0, 0.0)).length() < 1e-5);
    assert!(matches!(scene.nodes[2].local, Local::Channels(_)));
}

#[test]
fn faults_of_gltf_files() {
    let folder = Folder::new();
    let text = fs::read_to_string(data("moving.gltf")).unwrap();
    let check = |from: &str, to: &str, words: &str| {
        assert!(text.contains(from), "{from}");
        let error = load(&folder.write("bad.gltf", text.replacen(from, to, 1)), 0.0).expect_err(to).to_string();
        assert!(error.contains("bad.gltf") && error.contains(words), "{to:?} gave {error}");
    };
    check("\"count\": 4", "\"count\": 400000000000", "reaches beyond its view");
    check("\"byteLength\": 48", "\"byteLength\": 480000", "reaches beyond its buffer");
    check("\"asset\"", "asset", "bad.gltf:2: ");
    check("data:application/octet-stream;base64,", "data:application/octet-stream;base64,!", "damaged");
    check("data:application/octet-stream;base64,", "../../etc/", "outside");
    check("\"POSITION\": 0", "\"POSITION\": 999", "a mesh names accessor 999, which does not exist");
}

/// xorshift64*
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 33) as usize % n.max(1)
    }
}

/// Cuts, doubles, overwrites and swaps pieces of a file; numbers become wild ones.
fn mutate(bytes: &[u8], random: &mut Random) -> Vec<u8> {
    const WORDS: [&[u8]; 14] = [
        b"-1",
        b"4294967295",
        b"99999999999999999999",
        b"1e38",
        b"-1e-45",
        b"nan",
        b"{",
        b"}",
        b"k x {",
        b"m",
        b"\n",
        b"\0",
        b"\xff\xfe",
        b"i 0 scene.aff",
    ];
    let mut bytes = bytes.to_vec();
    for _ in 0..=random.below(4) {
        let (a, b) = (random.below(bytes.len() + 1), random.below(bytes.len() + 1));
        let (a, b) = (a.min(b), a.max(b));
        match random.below(6) {
            0 => bytes.truncate(b),
            1 => drop(bytes.drain(a..b.min(a + 40))),
            2 => {
                let piece = bytes[a..b.min(a + 200)].to_vec();
                let at = random.below(bytes.len() + 1);
                bytes.splice(at..at, piece);
            }
            3 => {
                let word = WORDS[random.below(WORDS.len())];
                bytes.splice(a..b.min(a + 3), word.iter().copied());
            }
            4 if a < bytes.len() => bytes[a] = random.below(256) as u8,
            _ => {
                // Another word in place of one that stands between blanks.
                let start =
                    bytes[a..].iter().position(|&c| c == b' ').map_or(bytes.len(), |i| a + i + 1).min(bytes.len());
                let end = bytes[start..].iter().position(u8::is_ascii_whitespace).map_or(bytes.len(), |i| start + i);
                bytes.splice(start..end, WORDS[random.below(WORDS.len())].iter().copied());
            }
        }
    }
    bytes
}

/// Hostile files give a scene or a fault, never a panic, and soon.
#[test]
fn mutated_files_do_no_harm() {
    let seed = std::env::var("OPENRT_SEED").ok().and_then(|s| s.parse().ok()).unwrap_or(0x0517_2026);
    println!("OPENRT_SEED={seed}");
    let mut random = Random(seed | 1);
    let folder = Folder::new();
    for name in ["checks.ppm", "box.mtl"] {
        folder.write(name, fs::read(data(name)).unwrap());
    }
    folder.write("parts/wing.aff", fs::read(data("parts/wing.aff")).unwrap());
    for name in ["every.aff", "parts/wing.aff", "box.obj", "quad.ply", "moving.gltf"] {
        let original = fs::read(data(name)).unwrap();
        let extension = Path::new(name).extension().unwrap().to_str().unwrap();
        let (mut good, mut bad) = (0, 0);
        for _ in 0..400 {
            let bytes = mutate(&original, &mut random);
            let path = folder.write(&format!("scene.{extension}"), &bytes);
            let begin = std::time::Instant::now();
            // Not through `load`, which would hide a panic of a crate.
            match read_format(&path, &ReadOptions { detail: 1.0 }) {
                Ok(scene) => {
                    good += 1;
                    // What loads can be posed, too.
                    for time in [-1e9, 0.0, 0.7, 1e9] {
                        let _ = scene.bounds(time);
                    }
                }
                Err(error) => {
                    bad += 1;
                    assert!(!error.to_string().is_empty());
                }
            }
            assert!(begin.elapsed().as_secs() < 5, "slow file kept in {}", path.display());
        }
        assert!(bad > 20, "{name}: the mutations are too tame ({good} good, {bad} bad)");
    }
}

/// Steps between fine samples shrink with the sampling: nothing jumps, except at cuts that the file itself has.
#[test]
fn bart_moves_smoothly() {
    let bart = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/bart");
    if !bart.is_dir() {
        skipped("no ../shared/bart");
        return;
    }
    for file in ["kitchen/aff/kitchen.aff", "robot/aff/Robot.aff", "museum/aff/museum5.aff"] {
        let scene = load(&bart.join(file), 0.0).unwrap();
        let animation = scene.animation.unwrap();
        let frame = (animation.end - animation.start) / f64::from(animation.frames);
        let camera = &scene.cameras[0];
        let view = |time: f64| {
            let view = camera.view(time, &[]);
            (view.from, view.forward.normalize(), view.up)
        };
        let camera_step = |step: f64| -> f64 {
            let samples = ((animation.end - animation.start) / step) as usize;
            let at = |i: usize| view(animation.start + i as f64 * step);
            (0..samples)
                .map(|i| {
                    let (a, b) = (at(i), at(i + 1));
                    (a.0 - b.0).length().max((a.1 - b.1).length()).max((a.2 - b.2).length())
                })
                .fold(0.0, f64::max)
        };
        shrinks(file, "camera", camera_step(frame), camera_step(frame / 16.0));
        for node in &scene.nodes {
            let Local::Keyed { keys: Some(keys), .. } = &node.local else { continue };
            // The kitchen's wheels have keys rounded to equal times at 25 turns a second: cuts, in the file itself.
            if node.name.starts_with("rotating_wheel") {
                continue;
            }
            let worst = |step: f64| -> f64 {
                let samples = ((animation.end - animation.start) / step) as usize;
                let at = |i: usize| keys.at(animation.start + i as f64 * step);
                (0..samples)
                    .map(|i| {
                        let (a, b) = (at(i), at(i + 1));
                        let turn = [DVec3::X, DVec3::Y, DVec3::Z]
                            .map(|v| (a.transform_vector3(v) - b.transform_vector3(v)).length());
                        (a.translation - b.translation).length().max(turn[0]).max(turn[1]).max(turn[2])
                    })
                    .fold(0.0, f64::max)
            };
            shrinks(file, &node.name, worst(frame), worst(frame / 16.0));
        }
    }
}

/// A sixteenth of the step gives at most a quarter of the greatest change (a jump would give all of it).
fn shrinks(file: &str, name: &str, coarse: f64, fine: f64) {
    assert!(fine <= 0.25 * coarse + 1e-9, "{file}: `{name}` jumps: {coarse} per frame, {fine} per sixteenth");
}
