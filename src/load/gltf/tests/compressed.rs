//! Quantised and compressed meshes. The compressed ones were made by the official encoders of Draco and meshoptimizer: a grid of
//! 3 × 3 vertices from (0, 0, 0) to (1, 1, 0), the texture coordinates equal to x and y, in 8 triangles.

use super::kit::*;
use crate::load::{Deform, SceneFile};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use glam::{DVec3, Vec3};
use serde_json::json;

const DRACO: &str = "RFJBQ08CAgEBAAAACQgBCAIAA3/aB/8BEf8CiEAC/wAAAAAAAQAJAwAAAgEDCQIAAQIBAQEADAOtKiNVFQMqYkz//z8A/g8AAADg/wAA\
    AAAAAAAA/wcAAAAAAAAAAAAAAAAAAAAAgD8LAQEBAAsDrSofVRUDKmJM////PwAA/A8AAAAAAP8DAAAAAAAAAAAAAAAAgD8K";
const ATTRIBUTES: &str =
    "oAAAAQ88wAD//////wEzzwAAfn1+fX4AAAEADAAA/wEDAAAAfgAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA==";
const TRIANGLES: &str = "4f4N/hNvDV8CDwjzBAQEAHaHVmd4qYZliWiYAWkAAA==";
const INDICES: &str = "0QAEDA4QAgYEDA4QAgIEDA4QAgYEDA4QAgAAAAA=";

fn decoded(text: &str) -> Vec<u8> {
    BASE64_STANDARD.decode(text).expect("a constant")
}

/// The sorted triangles of a scene with one object, each from its lowest corner.
fn triangles(scene: &SceneFile) -> Vec<[[i32; 2]; 3]> {
    let mesh = &scene.objects[0].mesh;
    let corner = |p: Vec3| [(p.x * 100.0).round() as i32, (p.y * 100.0).round() as i32];
    let mut triangles: Vec<[[i32; 2]; 3]> =
        mesh.triangles.iter().map(|t| t.map(|v| corner(mesh.positions[v as usize]))).collect();
    for t in &mut triangles {
        let least = (0..3).min_by_key(|&k| t[k]).expect("three corners");
        t.rotate_left(least);
    }
    triangles.sort();
    triangles
}

fn grid() -> Vec<[[i32; 2]; 3]> {
    let mut triangles = Vec::new();
    for (x, y) in [(0, 0), (0, 50), (50, 0), (50, 50)] {
        triangles.push([[x, y], [x + 50, y], [x + 50, y + 50]]);
        triangles.push([[x, y], [x + 50, y + 50], [x, y + 50]]);
    }
    triangles.sort();
    triangles
}

#[test]
fn draco() {
    let mut file = File::quad(1.0);
    let view = file.view(&decoded(DRACO));
    // The accessors only say how much there is.
    file.set(
        "/accessors",
        json!([
            {"componentType": 5126, "count": 9, "type": "VEC3"},
            {"componentType": 5123, "count": 24, "type": "SCALAR"},
            {"componentType": 5126, "count": 9, "type": "VEC2"}
        ]),
    );
    let draco = json!({"bufferView": view, "attributes": {"POSITION": 0, "TEXCOORD_0": 1}});
    file.set("/meshes/0/primitives/0/extensions", json!({"KHR_draco_mesh_compression": draco}));
    file.set("/extensionsRequired", json!(["KHR_draco_mesh_compression"]));
    let scene = file.whole();
    assert_eq!(triangles(&scene), grid());
    let mesh = &scene.objects[0].mesh;
    for (p, t) in mesh.positions.iter().zip(&mesh.tex_coords) {
        assert!((p.truncate() - *t).length() < 0.002, "{p} {t}");
    }
    // More than the accessors say, and damage.
    file.set("/accessors/1/count", json!(21));
    assert!(
        file.error().starts_with("meshes[0].primitives[0]: the Draco mesh cannot be decoded: "),
        "{}",
        file.error()
    );
    file.set("/accessors/1/count", json!(24)).set(&format!("/bufferViews/{view}/byteLength"), json!(60));
    assert!(
        file.error().starts_with("meshes[0].primitives[0]: the Draco mesh cannot be decoded: "),
        "{}",
        file.error()
    );
}

#[test]
fn meshoptimizer() {
    for (mode, indices) in [("TRIANGLES", TRIANGLES), ("INDICES", INDICES)] {
        let mut file = File::quad(1.0);
        let mut packed = |text: &str, mode: &str, stride: u32, count: u32| {
            let bytes = decoded(text);
            let inner = file.view(&bytes);
            let offset = file.json["bufferViews"][inner]["byteOffset"].clone();
            let length = stride * count;
            let meshopt = json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len(), "byteStride": stride,
                "count": count, "mode": mode});
            // The buffer that the view would be in is not there: a fallback without bytes.
            let extension = json!({"EXT_meshopt_compression": meshopt});
            let view = json!({"buffer": 1, "byteLength": length, "extensions": extension});
            push(&mut file.json["bufferViews"], view)
        };
        let (positions, indices) = (packed(ATTRIBUTES, "ATTRIBUTES", 12, 9), packed(indices, mode, 2, 24));
        file.set(
            "/accessors",
            json!([
                {"bufferView": positions, "componentType": 5126, "count": 9, "type": "VEC3"},
                {"bufferView": indices, "componentType": 5123, "count": 24, "type": "SCALAR"}
            ]),
        );
        file.set("/meshes/0/primitives/0/attributes", json!({"POSITION": 0}));
        file.set("/extensionsRequired", json!(["EXT_meshopt_compression"]));
        assert_eq!(triangles(&file.whole()), grid(), "{mode}");
        let extension = format!("/bufferViews/{positions}/extensions/EXT_meshopt_compression");
        file.set(&format!("{extension}/count"), json!(u64::MAX / 2));
        assert!(file.error().contains("more corners"), "{}", file.error());
        file.set(&format!("{extension}/count"), json!(800));
        let damaged = format!("bufferViews[{positions}]: the data of EXT_meshopt_compression is damaged");
        assert_eq!(file.error(), damaged);
        file.set(&format!("{extension}/mode"), json!("COLOURS"));
        assert!(file.error().contains("mode `COLOURS`"), "{}", file.error());
    }
}

/// Integers for positions, normals and texture coordinates; normalised or not.
#[test]
fn quantised_meshes() {
    let mut file = File::quad(1.0);
    let shorts = |values: &[i16]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<_>>();
    let corners = [0, 0, 0, 0, 100, 0, 0, 0, 100, 100, 0, 0, 0, 100, 0, 0];
    let positions = file.add(5122, "VEC3", 4, &shorts(&corners));
    let view = file.json["accessors"][positions]["bufferView"].clone();
    file.set(&format!("/bufferViews/{view}/byteStride"), json!(8));
    let normals = file.add(5120, "VEC3", 4, &[0, 0, 127, 0].repeat(4));
    let view = file.json["accessors"][normals]["bufferView"].clone();
    file.set(&format!("/bufferViews/{view}/byteStride"), json!(4));
    file.set(&format!("/accessors/{normals}/normalized"), json!(true));
    let tex_coords = file.add(5121, "VEC2", 4, &[0, 0, 255, 0, 255, 255, 0, 255]);
    file.set(&format!("/accessors/{tex_coords}/normalized"), json!(true));
    file.set(
        "/meshes/0/primitives/0/attributes",
        json!({"POSITION": positions, "NORMAL": normals, "TEXCOORD_0": tex_coords}),
    );
    file.set("/nodes/0/scale", json!([0.01, 0.01, 0.01]));
    file.set("/extensionsRequired", json!(["KHR_mesh_quantization"]));
    let scene = file.whole();
    let mesh = &scene.objects[0].mesh;
    assert_eq!(scene.bounds(0.0), Some((Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0))));
    assert!(mesh.normals.iter().all(|&n| n == Vec3::Z));
    assert!(mesh.positions.iter().zip(&mesh.tex_coords).all(|(p, t)| p.truncate() == *t));
    // Normalised positions.
    file.set(&format!("/accessors/{positions}/normalized"), json!(true))
        .set("/nodes/0/scale", json!([327.67, 327.67, 327.67]));
    let (_, high) = file.whole().bounds(0.0).unwrap();
    assert!((high - Vec3::new(1.0, 1.0, 0.0)).length() < 1e-5, "{high}");
}

#[test]
fn instances_by_extension() {
    let mut file = File::quad(1.0);
    let translations = file.floats("VEC3", &[10., 0., 0., 20., 0., 0., 30., 0., 0.]);
    let half = 0.5_f32.sqrt();
    let rotations = file.floats("VEC4", &[0., 0., 0., 1., 0., 0., half, half, 0., 0., 0., 1.]);
    let scales = file.floats("VEC3", &[1., 1., 1., 1., 1., 1., 2., 2., 2.]);
    let attributes = json!({"TRANSLATION": translations, "ROTATION": rotations, "SCALE": scales, "_ID": 99});
    file.set("/nodes/0/extensions", json!({"EXT_mesh_gpu_instancing": {"attributes": attributes}}));
    file.set("/nodes/0/translation", json!([0.0, 0.0, 5.0]));
    file.set("/extensionsRequired", json!(["EXT_mesh_gpu_instancing"]));
    let scene = file.whole();
    let object = &scene.objects[0];
    assert_eq!((scene.objects.len(), object.count(), scene.counts.mesh_triangles), (1, 3, 6));
    assert!(matches!(object.deform, Deform::Rigid));
    let corners: Vec<DVec3> = object.placements(&scene.pose(0.0)).map(|at| at.transform_point3(DVec3::X)).collect();
    for (corner, expected) in corners.iter().zip([[11.0, 0.0, 5.0], [20.0, 1.0, 5.0], [32.0, 0.0, 5.0]]) {
        assert!((*corner - DVec3::from_array(expected)).length() < 1e-6, "{corner} {expected:?}");
    }
    let (low, high) = scene.bounds(0.0).unwrap();
    assert!((low - Vec3::new(10.0, 0.0, 5.0)).length() < 1e-5 && (high - Vec3::new(32.0, 2.0, 5.0)).length() < 1e-5);
    // They are seen.
    let color = picture(scene).pixels.iter().filter(|p| p[0] > 0.0).count();
    assert!(color > 0);
    file.set(&format!("/accessors/{scales}/count"), json!(2));
    assert_eq!(file.error(), "nodes[0]: EXT_mesh_gpu_instancing: the attributes differ in length");
}
