//! Files made to do harm: they give a scene or an error, soon and in little memory.

use super::kit::*;
use serde_json::{Value, json};

#[test]
fn counts_without_data_are_refused() {
    let mut file = File::quad(1.0);
    file.set("/accessors", json!([{"componentType": 5126, "count": u64::MAX, "type": "VEC3"}]));
    file.set("/meshes/0/primitives/0", json!({"attributes": {"POSITION": 0}}));
    assert!(file.error().contains("more corners than a file of its size can"), "{}", file.error());
    file.set("/accessors/0/count", json!(1_000_000));
    let mut more = file.clone();
    let primitive = file.json["meshes"][0]["primitives"][0].clone();
    more.set("/meshes/0/primitives", json!(vec![primitive; 1000]));
    assert!(more.error().contains("more corners than a file of its size can"), "{}", more.error());
    // Many instances of nothing.
    file.set("/accessors/0/count", json!(1_u64 << 50));
    file.set("/nodes/0/extensions", json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0}}}));
    assert!(file.error().contains("nodes[0]: EXT_mesh_gpu_instancing: "), "{}", file.error());
}

#[test]
fn shared_data_does_not_multiply() {
    let mut file = File::quad(1.0);
    let positions = file.floats("VEC3", &vec![0.5; 300_000]);
    let primitive = json!({"attributes": {"POSITION": positions}});
    file.set("/meshes/0/primitives", json!(vec![primitive; 10_000]));
    assert!(file.error().contains("more corners than a file of its size can"), "{}", file.error());
    // A hundred textures of one image hold its bytes once.
    let mut file = File::quad(1.0);
    let image = file.view(&[0; 1_000_000]);
    file.set("/images", json!(vec![json!({"bufferView": image}); 100]));
    file.set("/textures", json!((0..100).map(|i| json!({"source": i})).collect::<Vec<_>>()));
    let materials: Vec<Value> =
        (0..100).map(|i| json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": i}}})).collect();
    let scene = file.set("/materials", json!(materials)).whole();
    let shared = |t: &crate::load::TextureSource| match &t.data {
        crate::load::TextureData::Bytes(bytes) => bytes.as_ptr(),
        crate::load::TextureData::File(_) => panic!("no file"),
    };
    assert!(scene.textures.iter().all(|t| shared(t) == shared(&scene.textures[0])));
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

/// A file with something of everything.
fn rich() -> File {
    let mut file = File::quad(2.0);
    let normals = file.floats("VEC3", &[0.0, 0.0, 1.0].repeat(4));
    let (joints, weights) = (file.add(5121, "VEC4", 4, &[0; 16]), file.floats("VEC4", &[1.0, 0.0, 0.0, 0.0].repeat(4)));
    let (times, moves) = (file.floats("SCALAR", &[0.0, 1.0]), file.floats("VEC3", &[0., 0., 0., 1., 2., 3.]));
    let colors = file.floats("VEC3", &[1.0, 0.5, 0.25].repeat(4));
    let (which, what) = (file.view(&[1]), file.view(&[0; 12]));
    let texture = file.texture(2, &[[255, 0, 0, 255], [0, 255, 0, 128]]);
    let sparse =
        json!({"count": 1, "indices": {"bufferView": which, "componentType": 5121}, "values": {"bufferView": what}});
    file.set("/accessors/0/sparse", sparse);
    file.set(
        "/meshes/0/primitives/0/attributes",
        json!({"POSITION": 0, "NORMAL": normals, "TEXCOORD_0": 2,
        "COLOR_0": colors, "JOINTS_0": joints, "WEIGHTS_0": weights, "_FOO": 0}),
    );
    file.set("/meshes/0/primitives/0/targets", json!([{"POSITION": normals}]));
    let info =
        json!({"index": texture, "extensions": {"KHR_texture_transform": {"offset": [0.1, 0.2], "rotation": 1.0}}});
    file.material(json!({"alphaMode": "MASK", "normalTexture": info, "occlusionTexture": info, "emissiveTexture": info,
        "emissiveFactor": [1, 1, 1], "pbrMetallicRoughness": {"baseColorTexture": info, "metallicRoughnessTexture": info}}));
    push(&mut file.json["meshes"], json!({"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "mode": 5}]}));
    file.set(
        "/nodes",
        json!([
            {"mesh": 0, "skin": 0, "children": [1, 2]},
            {"mesh": 1, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": normals}}}},
            {"camera": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 5, 1],
                "extensions": {"KHR_lights_punctual": {"light": 0}}}
        ]),
    );
    file.set("/skins", json!([{"joints": [1]}]))
        .set("/cameras", json!([{"type": "perspective", "perspective": {"yfov": 1}}]));
    file.set("/extensions", json!({"KHR_lights_punctual": {"lights": [{"type": "spot", "intensity": 3}]}}));
    file.set(
        "/animations",
        json!([{"samplers": [{"input": times, "output": moves}],
        "channels": [{"sampler": 0, "target": {"node": 1, "path": "translation"}}]}]),
    );
    file
}

/// Numbers and words of the JSON are replaced by wild ones, bytes of the file cut, doubled and overwritten.
#[test]
fn mutated_files_do_no_harm() {
    let seed = std::env::var("OPENRT_SEED").ok().and_then(|s| s.parse().ok()).unwrap_or(0x0614_2026);
    println!("OPENRT_SEED={seed}");
    let mut random = Random(seed | 1);
    const WILD: [&str; 16] = [
        "-1",
        "0",
        "1",
        "2",
        "3",
        "5120",
        "5125",
        "4294967295",
        "18446744073709551615",
        "1e38",
        "-1e-45",
        "null",
        "[]",
        "{}",
        "\"\"",
        "\"VEC3\"",
    ];
    let text = rich().text();
    assert_eq!(rich().whole().objects.len(), 2);
    let (mut good, mut bad) = (0, 0);
    for round in 0..1500 {
        let mut bytes = text.clone().into_bytes();
        for _ in 0..=random.below(3) {
            let (a, b) = (random.below(bytes.len() + 1), random.below(bytes.len() + 1));
            let (a, b) = (a.min(b), a.max(b));
            match random.below(8) {
                0 => bytes.truncate(b),
                1 => drop(bytes.drain(a..b.min(a + 40))),
                2 if a < bytes.len() => bytes[a] = random.below(256) as u8,
                3 => {
                    let piece = bytes[a..b.min(a + 200)].to_vec();
                    let at = random.below(bytes.len() + 1);
                    bytes.splice(at..at, piece);
                }
                _ => {
                    // A number or a word between colon, comma and bracket.
                    let start =
                        bytes[a..].iter().position(|&c| c == b':' || c == b'[').map_or(bytes.len(), |i| a + i + 1);
                    let start = start.min(bytes.len());
                    let end =
                        bytes[start..].iter().position(|&c| b",]}".contains(&c)).map_or(bytes.len(), |i| start + i);
                    if end - start < 40 {
                        bytes.splice(start..end, WILD[random.below(WILD.len())].bytes());
                    }
                }
            }
        }
        let begin = std::time::Instant::now();
        let result = std::panic::catch_unwind(|| load("scene.gltf", &bytes));
        match result.unwrap_or_else(|_| panic!("round {round} of seed {seed}")) {
            Ok(scene) => {
                good += 1;
                for time in [-1e9, 0.0, 0.7, 1e9] {
                    let _ = scene.bounds(time);
                }
            }
            Err(error) => {
                bad += 1;
                let error = error.to_string();
                assert!(error.contains("scene.gltf"), "round {round}, seed {seed}: {error}");
            }
        }
        assert!(begin.elapsed().as_secs() < 5, "round {round} of seed {seed} is slow");
    }
    assert!(good > 20 && bad > 100, "the mutations are too tame or too wild ({good} good, {bad} bad)");
}
