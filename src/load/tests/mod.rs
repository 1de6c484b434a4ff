//! Grammar, faults and hostile files: glTF, and what is the same for all formats.

#[allow(clippy::duplicate_mod, reason = "shared with the tests outside")]
#[path = "../../../tests/common/skip.rs"]
mod skip;

mod kit;
mod nff;
mod obj;
mod ply;

use super::{ReadOptions, read_format};
use crate::load::model::{Local, SceneFile};
use glam::{DVec3, Vec3};
use kit::{Folder, data, load};
use skip::skipped;
use std::fs;
use std::path::Path;

#[test]
fn gltf_moves_bends_and_morphs() {
    let scene = load(&data("moving.gltf"), 0.0).unwrap();
    assert_eq!(scene.warnings, [""; 0]);
    assert_eq!((scene.cameras.len(), scene.lights.len(), scene.textures.len()), (1, 1, 1));
    assert_eq!(scene.animation.map(|a| (a.end, a.frames)), Some((1.0, 25)));
    assert_eq!(scene.named_transforms, ["mover", "tip"]);
    let object = |name: &str| scene.objects.iter().find(|o| o.name == name).unwrap();
    // The quad under the still node stands under the root; the one under the mover is an object that moves.
    assert!(scene.objects.iter().any(|o| o.node == 0 && o.copies[0].translation.x == -3.0));
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
    check("\"count\": 4", "\"count\": 400000000000", "elements reach beyond the buffer view");
    check("\"byteLength\": 48", "\"byteLength\": 480000", "bufferViews[0] reaches beyond buffers[0]");
    check("\"asset\"", "asset", "bad.gltf:2: ");
    check("data:application/octet-stream;base64,", "data:application/octet-stream;base64,!", "damaged");
    check("data:application/octet-stream;base64,", "../../etc/", "outside");
    check("\"POSITION\": 0", "\"POSITION\": 999", "there is no accessors[999]");
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
    folder.write("all.mtl", obj::EVERY_MATERIAL);
    let user = folder.write("user.obj", obj::EVERYTHING.replace("all.mtl", "scene.mtl"));
    let mut originals: Vec<(&str, Vec<u8>)> = ["every.aff", "parts/wing.aff", "box.obj", "quad.ply", "moving.gltf"]
        .map(|name| (name, fs::read(data(name)).unwrap()))
        .to_vec();
    originals.push(("all.obj", obj::EVERYTHING.into()));
    originals.push(("all.mtl", obj::EVERY_MATERIAL.into()));
    originals.push(("all.ply", ply::everything()));
    for (name, original) in originals {
        let extension = Path::new(name).extension().unwrap().to_str().unwrap();
        let (mut good, mut bad) = (0, 0);
        for _ in 0..400 {
            let bytes = mutate(&original, &mut random);
            let path = folder.write(&format!("scene.{extension}"), &bytes);
            let path = if extension == "mtl" { user.clone() } else { path };
            let begin = std::time::Instant::now();
            // Not through `load`, which would hide a panic of a crate.
            match read_format(&path, &ReadOptions { detail: 1.0 }) {
                Ok(scene) => {
                    if scene.warnings.is_empty() {
                        good += 1
                    } else {
                        bad += 1
                    }
                    sound(&scene);
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

/// Every index of a scene has what it points to, and every vertex all attributes.
fn sound(scene: &SceneFile) {
    for object in &scene.objects {
        let mesh = &object.mesh;
        let count = mesh.positions.len();
        assert!(mesh.triangles.as_flattened().iter().all(|&v| (v as usize) < count));
        for length in [mesh.normals.len(), mesh.tex_coords.len(), mesh.colors.len()] {
            assert!(length == 0 || length == count, "{length} of {count}");
        }
        assert!(object.material.is_some() || mesh.materials.len() == mesh.triangles.len());
        assert!(mesh.materials.iter().chain(&object.material).all(|&m| (m as usize) < scene.materials.len()));
        assert!((object.node as usize) < scene.nodes.len());
    }
    let textures = scene.materials.iter().filter_map(|m| m.texture);
    assert!(textures.into_iter().all(|t| (t as usize) < scene.textures.len()));
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
