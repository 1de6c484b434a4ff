//! Files that are refused, and what is said then; containers and extensions.

use super::kit::*;
use serde_json::json;

#[test]
fn faults_name_their_place() {
    for (pointer, value, error) in [
        (
            "/accessors/0/count",
            json!(400_000_000_000_u64),
            "accessors[0]: 400000000000 elements reach beyond the buffer view",
        ),
        ("/accessors/0/byteOffset", json!(u64::MAX), "accessors[0]: 4 elements reach beyond the buffer view"),
        ("/accessors/0/componentType", json!(5127), "accessors[0]: there is no component type 5127"),
        ("/accessors/0/type", json!("VEC2"), "accessors[0]: 2 components instead of 3"),
        ("/accessors/0/bufferView", json!(77), "accessors[0]: there is no bufferViews[77]"),
        ("/accessors/1/componentType", json!(5122), "accessors[1]: the components are not unsigned integers"),
        ("/accessors/2/count", json!(3), "meshes[0].primitives[0]: 3 texture coordinates for 4 vertices"),
        ("/bufferViews/0/byteLength", json!(480_000), "bufferViews[0] reaches beyond buffers[0]"),
        ("/bufferViews/0/buffer", json!(3), "bufferViews[0]: there is no buffers[3]"),
        ("/bufferViews/0/byteStride", json!(0), "accessors[0]: 4 elements reach beyond the buffer view"),
        ("/meshes/0/primitives/0/attributes/POSITION", json!(99), "meshes[0].primitives[0]: there is no accessors[99]"),
        ("/meshes/0/primitives/0/indices", json!(99), "meshes[0].primitives[0]: there is no accessors[99]"),
        ("/meshes/0/primitives/0/material", json!(0), "meshes[0].primitives[0]: there is no materials[0]"),
        ("/meshes/0/primitives/0/mode", json!(9), "meshes[0].primitives[0]: there is no mode 9"),
        ("/nodes/0/mesh", json!(1), "nodes[0]: there is no meshes[1]"),
        ("/nodes/0/camera", json!(0), "nodes[0]: there is no cameras[0]"),
        ("/nodes/0/skin", json!(0), ""),
        ("/scene", json!(5), "scene: there is no scenes[5]"),
        ("/scenes/0/nodes", json!([0, 0]), ""),
        ("/nodes/0/children", json!([0]), ""),
    ] {
        let mut file = File::quad(1.0);
        file.set(pointer, value);
        match error {
            "" => drop(file.whole()),
            error => assert_eq!(file.error(), error, "{pointer}"),
        }
    }
    let mut file = File::quad(1.0);
    let indices = file.add(5121, "SCALAR", 3, &[0, 1, 4]);
    file.set("/meshes/0/primitives/0/indices", json!(indices));
    assert_eq!(file.error(), "meshes[0].primitives[0]: a triangle uses a vertex beyond the 4 of the primitive");
}

#[test]
fn text_that_is_not_gltf_has_a_line() {
    let error = |text: &str| load("scene.gltf", text.as_bytes()).unwrap_err().to_string();
    assert!(
        error("{\n\"asset\": {\"version\": \"2.0\"},\n\"nodes\": 7}").contains("scene.gltf:3: not glTF: invalid type")
    );
    assert!(error("{\n\"asset\"\n}").contains("scene.gltf:3: not glTF: expected `:`"));
    assert!(error("").contains("scene.gltf:1: not glTF: EOF"));
    assert!(error("{}").ends_with("scene.gltf: not glTF: there is no `asset` with a `version`"));
    assert!(
        error("{\"asset\": {\"version\": \"2.0\"}, \"nodes\": [{\"mesh\": -1}]}")
            .contains("invalid value: integer `-1`")
    );
    // Depth and number of objects are bounded.
    assert!(error(&"[".repeat(100_000)).contains("scene.gltf:1: "));
    let many = format!("{{\"asset\": {{\"version\": \"2.0\"}}, \"nodes\": [{}{{}}]}}", "{},".repeat(5_000_000));
    assert!(error(&many).contains("objects in the JSON"), "{}", error(&many));
    // A byte order mark is passed over.
    let marked = [b"\xef\xbb\xbf".as_slice(), File::quad(1.0).text().as_bytes()].concat();
    assert!(load("scene.gltf", &marked).is_ok());
}

#[test]
fn other_versions_are_named() {
    let error = |text: &str| load("scene.gltf", text.as_bytes()).unwrap_err().to_string();
    for (text, version) in [
        ("{\"asset\": {\"version\": \"1.0\"}, \"meshes\": {\"a\": {\"primitives\": []}}, \"nodes\": {}}", "1.0"),
        ("{\"meshes\": {\"a\": {}}, \"accessors\": {}}", "1.0"),
        ("{\"asset\": {\"version\": 1.1}, \"nodes\": {}}", "1.1"),
        ("{\"asset\": {\"version\": \"2.0\", \"minVersion\": \"3.1\"}}", "3.1"),
    ] {
        assert!(error(text).ends_with(&format!("this is glTF {version}; only glTF 2.0 is read")), "{}", error(text));
    }
    let binary = [b"glTF".as_slice(), &1_u32.to_le_bytes(), &20_u32.to_le_bytes(), &[0; 8]].concat();
    let error = load("scene.glb", &binary).unwrap_err().to_string();
    assert!(error.contains("this is binary glTF 1.0; only glTF 2.0 is read"), "{error}");
    assert!(File::quad(1.0).set("/asset/version", json!("2.1")).load().is_ok());
}

fn glb(file: &File) -> Vec<u8> {
    let mut json = file.json.clone();
    json["buffers"] = json!([{"byteLength": file.bytes.len()}]);
    let mut text = serde_json::to_vec(&json).unwrap();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut binary = file.bytes.clone();
    binary.resize(binary.len().next_multiple_of(4), 0);
    let chunk = |kind: &[u8], bytes: &[u8]| [&(bytes.len() as u32).to_le_bytes(), kind, bytes].concat();
    let body = [chunk(b"JSON", &text), chunk(b"BIN\0", &binary)].concat();
    [b"glTF".as_slice(), &2_u32.to_le_bytes(), &(12 + body.len() as u32).to_le_bytes(), &body].concat()
}

#[test]
fn binary_files() {
    let bytes = glb(&File::quad(1.0));
    assert_eq!(load("scene.glb", &bytes).unwrap().counts.mesh_triangles, 2);
    // By content, not by name.
    assert!(load("scene.gltf", &bytes).is_ok());
    for length in [0, 3, 4, 11, 12, 19, 20, 100, bytes.len() - 1] {
        let error = load("scene.glb", &bytes[..length]).unwrap_err().to_string();
        assert!(error.contains("scene.glb:"), "{length}: {error}");
    }
}

#[test]
fn extensions_are_required_or_optional() {
    let mut file = File::quad(1.0);
    file.set("/extensionsUsed", json!(["KHR_materials_clearcoat", "KHR_materials_unlit", "ACME_thing"]));
    assert_eq!(file.warnings(), ["extension ACME_thing is ignored", "extension KHR_materials_clearcoat is ignored"]);
    file.set("/extensionsRequired", json!(["ACME_thing"]));
    assert_eq!(file.error(), "the file requires extension ACME_thing, which is not read");
    file.set("/extensionsRequired", json!(["ACME_thing", "ACME_other", "KHR_texture_transform"]));
    assert_eq!(file.error(), "the file requires extensions ACME_thing, ACME_other, which are not read");
}

#[test]
fn uris_stay_in_the_folder() {
    let file = File::quad(1.0);
    let text = file.text();
    let with = |uri: &str| {
        let (front, rest) = text.split_once("data:application").unwrap();
        let rest = rest.split_once('"').unwrap().1;
        load("scene.gltf", format!("{front}{uri}\"{rest}").as_bytes()).unwrap_err().to_string()
    };
    for (uri, why) in [
        ("/etc/passwd", "buffers[0]: file `/etc/passwd` is an absolute path"),
        ("../../etc/passwd", "lies outside the scene's folder"),
        ("no%20where.bin", "buffers[0]: file `no where.bin` does not exist"),
        ("%zz", "buffers[0]: the URI `%zz` is damaged"),
        ("data:;base64,AAA!", "buffers[0]: a data URI is damaged"),
        ("data:,plain", "buffers[0]: a data URI is not base64"),
        ("data:;base64,AAAA", "buffers[0]: 3 bytes instead of"),
    ] {
        assert!(with(uri).contains(why), "{}", with(uri));
    }
}
