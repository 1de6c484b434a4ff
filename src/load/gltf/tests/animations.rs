//! What moves, by which interpolation, and what is played.

use super::kit::*;
use crate::load::SceneFile;
use glam::{DVec3, Vec3};
use serde_json::{Value, json};

/// Two keys at 1 and 3 seconds; `values` of one or, for cubic splines, three rows a key.
fn channel(file: &mut File, node: u32, path: &str, interpolation: &str, kind: &str, values: &[f32]) -> Value {
    let (input, output) = (file.floats("SCALAR", &[1.0, 3.0]), file.floats(kind, values));
    json!({"channels": [{"sampler": 0, "target": {"node": node, "path": path}}],
        "samplers": [{"input": input, "output": output, "interpolation": interpolation}]})
}

fn corner(scene: &SceneFile, time: f64) -> DVec3 {
    scene.objects[0].world_from_object(&scene.pose(time)).transform_point3(DVec3::new(1.0, 0.0, 0.0))
}

#[test]
fn every_path_by_every_interpolation() {
    let half = 0.5_f32.sqrt();
    let turn = [0., 0., 0., 1., 0., 0., half, half];
    let at = |path: &str, interpolation: &str, kind: &str, values: &[f32], time: f64| {
        let mut file = File::quad(1.0);
        let animation = channel(&mut file, 0, path, interpolation, kind, values);
        corner(&file.set("/animations", json!([animation])).whole(), time)
    };
    let moved = [0., 0., 0., 0., 4., 0.];
    for (interpolation, y) in [("LINEAR", 1.0), ("STEP", 0.0)] {
        assert_eq!(at("translation", interpolation, "VEC3", &moved, 1.5), DVec3::new(1.0, y, 0.0));
        assert_eq!(at("translation", interpolation, "VEC3", &moved, 9.0), DVec3::new(1.0, 4.0, 0.0));
    }
    // In-tangent, value, out-tangent; flat at both ends: 3u² − 2u³ of the way, u = ¼.
    let cubic = [[0.; 3], [0.; 3], [0.; 3], [0.; 3], [0., 4., 0.], [0.; 3]].concat();
    let eased = at("translation", "CUBICSPLINE", "VEC3", &cubic, 1.5).y;
    assert!((eased - 4.0 * (3.0 / 16.0 - 2.0 / 64.0)).abs() < 1e-6, "{eased}");
    let turned = at("rotation", "LINEAR", "VEC4", &turn, 2.0);
    let expected = std::f64::consts::FRAC_PI_4;
    assert!((turned - DVec3::new(expected.cos(), expected.sin(), 0.0)).length() < 1e-6, "{turned}");
    assert_eq!(at("scale", "LINEAR", "VEC3", &[1., 1., 1., 3., 1., 1.], 2.0), DVec3::new(2.0, 0.0, 0.0));
}

#[test]
fn weights_move_vertices() {
    let mut file = File::quad(1.0);
    let target = file.floats("VEC3", &[0.0, 0.0, 1.0].repeat(4));
    file.set("/meshes/0/primitives/0/targets", json!([{"POSITION": target}, {}]));
    let animation = channel(&mut file, 0, "weights", "LINEAR", "SCALAR", &[0.0, 0.0, 2.0, 0.0]);
    let scene = file.set("/animations", json!([animation])).whole();
    let z = |time: f64| scene.bounds(time).unwrap().0.z;
    assert_eq!([z(0.0), z(2.0), z(3.0)], [0.0, 1.0, 2.0]);
    assert_eq!(scene.named_transforms, [""; 0], "the node itself rests");
}

/// Animations that move different things play together; others are clips to choose from.
#[test]
fn animations_that_do_not_meet_play_together() {
    let mut file = File::quad(1.0);
    file.set("/nodes", json!([{"mesh": 0}, {"children": [0]}])).set("/scenes/0/nodes", json!([1]));
    let mut animations = Vec::new();
    for (node, path, to) in [(0, "translation", 4.0), (1, "translation", 2.0), (0, "translation", 10.0)] {
        animations.push(channel(&mut file, node, path, "LINEAR", "VEC3", &[0., 0., 0., 0., to, 0.]));
    }
    animations[2]["name"] = json!("jump");
    file.set("/animations", json!(animations));
    let mut scene = file.whole();
    assert_eq!(corner(&scene, 3.0).y, 6.0, "the first two");
    assert_eq!(scene.clips.iter().map(|c| c.name.as_str()).collect::<Vec<_>>(), ["animation 0", "jump"]);
    assert!(scene.notes[0].contains("animation 0, jump"), "{:?}", scene.notes);
    scene.play_clip(1);
    assert_eq!(corner(&scene, 3.0).y, 10.0);
    scene.play_clip(7);
    scene.play_clip(0);
    assert_eq!(corner(&scene, 3.0).y, 6.0);
    assert_eq!(scene.animation.map(|a| (a.end, a.frames)), Some((3.0, 73)));
}

#[test]
fn what_cannot_be_played_is_left_out_by_name() {
    let mut file = File::quad(1.0);
    let mut bad = Vec::new();
    for (path, interpolation, values) in [
        ("translation", "LINEAR", vec![0.0; 9]),
        ("translation", "CUBICSPLINE", vec![0.0; 6]),
        ("translation", "SMOOTH", vec![0.0; 6]),
        ("pointer", "LINEAR", vec![0.0; 6]),
        ("translation", "LINEAR", vec![f32::NAN; 6]),
    ] {
        bad.push(channel(&mut file, 0, path, interpolation, "VEC3", &values));
    }
    file.set("/animations", json!(bad));
    assert_eq!(
        file.warnings(),
        [
            "animations[4].channels[0]: an animation whose times go back, or whose values are not finite, is left out",
            "animations[0].channels[0]: an animation whose values do not fit its keys is left out (and 1 more)",
            "animations[3].channels[0]: animations of `pointer` are left out",
            "animations[2].channels[0]: animations with interpolation `SMOOTH` are left out",
        ]
    );
    assert_eq!(file.load().unwrap().bounds(9.0).unwrap().1, Vec3::new(1.0, 1.0, 0.0));
}
