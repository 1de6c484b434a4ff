//! Attributes, modes, scenes and shared meshes.

use super::kit::*;
use crate::load::Deform;
use glam::{Vec3, Vec4};
use serde_json::json;

#[test]
fn attributes_of_applications_are_passed_over() {
    let mut file = File::quad(1.0);
    file.set("/meshes/0/primitives/0/attributes/_FOO", json!(0));
    file.set("/meshes/0/primitives/0/attributes/_BAR_9", json!(12345));
    assert_eq!(file.whole().counts.mesh_triangles, 2);
}

#[test]
fn scenes_need_no_nodes() {
    let mut file = File::quad(1.0);
    file.set("/scenes", json!([{}]));
    assert_eq!(file.warnings(), ["the scene has no triangles"]);
    let mut bare = File { json: json!({"asset": {"version": "2.0"}}), bytes: Vec::new() };
    assert_eq!(bare.warnings(), ["the scene has no triangles"]);
    // Without a scene all nodes are shown.
    bare = File::quad(1.0);
    let json = bare.json.as_object_mut().unwrap();
    json.remove("scenes");
    json.remove("scene");
    assert_eq!(bare.whole().counts.mesh_triangles, 2);
    bare.set("/scene", json!(3));
    assert_eq!(bare.warnings(), ["scene: there is no scenes[3]; all nodes are shown"]);
    assert_eq!(file.set("/scenes/0/nodes", json!([7])).error(), "a list of nodes: there is no nodes[7]");
}

#[test]
fn strips_and_fans_become_triangles() {
    let mut file = File::quad(1.0);
    // Corners of the square: 0 1 / 3 2 counter-clockwise.
    let strip = file.add(5121, "SCALAR", 4, &[0, 1, 3, 2]);
    file.set("/meshes/0/primitives/0/indices", json!(strip)).set("/meshes/0/primitives/0/mode", json!(5));
    let scene = file.whole();
    let mesh = &scene.objects[0].mesh;
    assert_eq!(mesh.triangles.len(), 2);
    assert!(mesh.normals.iter().all(|&n| n == Vec3::Z), "all turn the same way: {:?}", mesh.normals);
    let fan = file.add(5121, "SCALAR", 4, &[0, 1, 2, 3]);
    file.set("/meshes/0/primitives/0/indices", json!(fan)).set("/meshes/0/primitives/0/mode", json!(6));
    let scene = file.whole();
    assert_eq!(scene.objects[0].mesh.triangles.len(), 2);
    assert!(scene.objects[0].mesh.normals.iter().all(|&n| n == Vec3::Z));
    file.set("/meshes/0/primitives/0/mode", json!(1));
    assert_eq!(file.warnings(), ["meshes[0].primitives[0]: lines are not drawn", "the scene has no triangles"]);
}

#[test]
fn colours_of_vertices_have_three_or_four_numbers_of_any_type() {
    let mut file = File::quad(1.0);
    let colors = file.add(5121, "VEC4", 4, &[255, 0, 0, 51].repeat(4));
    file.set(&format!("/accessors/{colors}/normalized"), json!(true));
    file.set("/meshes/0/primitives/0/attributes/COLOR_0", json!(colors));
    assert_eq!(file.whole().objects[0].mesh.colors, [Vec4::new(1.0, 0.0, 0.0, 0.2); 4]);
    let colors = file.floats("VEC3", &[0.0, 0.5, 1.0].repeat(4));
    file.set("/meshes/0/primitives/0/attributes/COLOR_0", json!(colors));
    assert_eq!(file.whole().objects[0].mesh.colors, [Vec4::new(0.0, 0.5, 1.0, 1.0); 4]);
}

#[test]
fn sparse_accessors_replace_some_elements() {
    let mut file = File::quad(1.0);
    let (which, what) = (file.view(&[1, 2]), file.view(&[5_f32, 0., 0., 5., 5., 0.].map(f32::to_le_bytes).concat()));
    let sparse =
        json!({"count": 2, "indices": {"bufferView": which, "componentType": 5121}, "values": {"bufferView": what}});
    file.set("/accessors/0/sparse", sparse);
    assert_eq!(file.whole().bounds(0.0).unwrap().1, Vec3::new(5.0, 5.0, 0.0));
    // Without a view all other elements are zero.
    file.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    assert_eq!(file.whole().bounds(0.0).unwrap(), (Vec3::ZERO, Vec3::new(5.0, 5.0, 0.0)));
    file.set("/accessors/0/sparse/count", json!(3));
    assert_eq!(file.error(), "accessors[0]: the sparse elements reach beyond their buffer views");
}

/// One mesh under many nodes is one object, whatever they do.
#[test]
fn shared_meshes_are_placed_not_copied() {
    let mut file = File::quad(1.0);
    let nodes: Vec<_> = (0..50).map(|i| json!({"mesh": 0, "translation": [i, 0, 0]})).collect();
    file.set("/nodes", json!(nodes)).set("/scenes/0/nodes", json!((0..50).collect::<Vec<_>>()));
    let scene = file.whole();
    assert_eq!((scene.objects.len(), scene.objects[0].count(), scene.counts.mesh_triangles), (1, 50, 100));
    assert_eq!(scene.bounds(0.0), Some((Vec3::ZERO, Vec3::new(50.0, 1.0, 0.0))));
}

#[test]
fn vertices_of_other_primitives_are_left_alone() {
    let mut file = File::quad(1.0);
    // One triangle of a large shared list of vertices.
    let mut many = vec![0.0; 30_000];
    many[29_991..].copy_from_slice(&[1.0, 1.0, 1.0, 2.0, 1.0, 1.0, 1.0, 2.0, 1.0]);
    let positions = file.floats("VEC3", &many);
    let indices = file.add(5125, "SCALAR", 3, &[9997_u32, 9998, 9999].map(u32::to_le_bytes).concat());
    file.set("/meshes/0/primitives/0/attributes", json!({"POSITION": positions}));
    file.set("/meshes/0/primitives/0/indices", json!(indices));
    let scene = file.whole();
    assert_eq!(scene.objects[0].mesh.positions.len(), 3);
    assert_eq!(scene.bounds(0.0).unwrap().0, Vec3::ONE);
}

#[test]
fn eight_joints_become_four() {
    let mut file = File::quad(1.0);
    let joints = file.add(5121, "VEC4", 4, &[0, 1, 0, 0].repeat(4));
    let weights = file.floats("VEC4", &[0.5, 0.25, 0.0, 0.0].repeat(4));
    let more = file.floats("VEC4", &[0.25, 0.0, 0.0, 0.0].repeat(4));
    for (name, accessor) in [("JOINTS_0", joints), ("JOINTS_1", joints), ("WEIGHTS_0", weights), ("WEIGHTS_1", more)] {
        file.set(&format!("/meshes/0/primitives/0/attributes/{name}"), json!(accessor));
    }
    file.set("/nodes", json!([{"mesh": 0, "skin": 0}, {}, {"translation": [4, 0, 0]}]));
    file.set("/scenes/0/nodes", json!([0, 1, 2])).set("/skins", json!([{"joints": [1, 2]}]));
    let scene = file.whole();
    assert!(matches!(&scene.objects[0].deform, Deform::Blend { skin: Some(skin), .. } if skin.joints.len() == 2));
    // Three quarters stay, one quarter moves by 4.
    assert_eq!(scene.bounds(0.0), Some((Vec3::X, Vec3::new(2.0, 1.0, 0.0))));
    file.set("/skins/0/joints", json!([1]));
    assert_eq!(file.error(), "meshes[0].primitives[0]: a vertex has a joint beyond the 1 of skins[0]");
}
