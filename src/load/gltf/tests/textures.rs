//! Textures: alpha, wrapping, filters, transforms and sets of coordinates.

use super::kit::*;
use crate::api::{Filter, Wrap};
use serde_json::{Value, json};

const RED: [u8; 4] = [255, 0, 0, 255];
const GREEN: [u8; 4] = [0, 255, 0, 255];

/// An unlit material with a texture.
fn painted(texture: Value) -> Value {
    json!({"pbrMetallicRoughness": {"baseColorTexture": texture}, "extensions": {"KHR_materials_unlit": {}}})
}

/// The colours from left to right: R, G or ? for others.
fn row(file: &File, count: usize) -> String {
    let picture = facing(file.whole());
    let letter = |i: usize| match picture.at((i as f32 + 0.5) / count as f32, 0.5) {
        [r, g, _] if r > 0.9 && g < 0.1 => 'R',
        [r, g, _] if r < 0.1 && g > 0.9 => 'G',
        _ => '?',
    };
    (0..count).map(letter).collect()
}

#[test]
fn all_ways_to_wrap() {
    for (wrap, colors, kind) in [
        (10497, "RGRGRGRG", Wrap::Repeat),
        (33071, "RGGGGGGG", Wrap::ClampToEdge),
        (33648, "RGGRRGGR", Wrap::MirroredRepeat),
    ] {
        let mut file = File::quad(4.0);
        let texture = file.texture(2, &[RED, GREEN]);
        file.material(painted(json!({"index": texture})));
        file.set("/samplers/0/wrapS", json!(wrap));
        assert_eq!(file.whole().textures[0].wrap, [kind, Wrap::Repeat]);
        assert_eq!(row(&file, 8), colors, "{wrap}");
    }
}

#[test]
fn all_filters() {
    for (mag, min, filter) in [
        (json!(9728), json!(9728), Filter::Nearest),
        (json!(9728), json!(9987), Filter::Nearest),
        (json!(9729), json!(9729), Filter::Linear),
        (json!(9729), json!(9985), Filter::LinearMipmapLinear),
        (Value::Null, Value::Null, Filter::LinearMipmapLinear),
    ] {
        let mut file = File::quad(1.0);
        let texture = file.texture(2, &[RED, GREEN]);
        file.material(painted(json!({"index": texture})));
        file.set("/samplers/0", json!({"magFilter": mag, "minFilter": min}));
        assert_eq!(file.whole().textures[0].filter, filter, "{mag} {min}");
    }
}

#[test]
fn transforms_of_textures() {
    let mut file = File::quad(1.0);
    let texture = file.texture(2, &[RED, GREEN]);
    let mut of = |transform: Value| {
        file.material(painted(json!({"index": texture, "extensions": {"KHR_texture_transform": transform}})));
        row(&file, 4)
    };
    assert_eq!(of(json!({})), "RRGG");
    assert_eq!(of(json!({"offset": [0.5, 0.0]})), "GGRR");
    assert_eq!(of(json!({"scale": [2.0, 1.0]})), "RGRG");
    assert_eq!(of(json!({"offset": [0.5, 0.0], "scale": [0.0, 0.0]})), "GGGG");
    // Turned by a half, about the origin.
    assert_eq!(of(json!({"rotation": std::f32::consts::PI, "offset": [1.0, 1.0]})), "GGRR");
    // Turned by a quarter s is where t was: what lay side by side lies one above the other.
    let quarter = of(json!({"rotation": std::f32::consts::FRAC_PI_2, "offset": [0.0, 1.0]}));
    assert!(quarter == "RRRR" || quarter == "GGGG", "{quarter}");
}

#[test]
fn the_set_of_coordinates_is_chosen_by_the_texture() {
    let mut file = File::quad(1.0);
    let texture = file.texture(2, &[RED, GREEN]);
    let other = file.floats("VEC2", &[0.75, 0.0, 0.75, 0.0, 0.75, 0.0, 0.75, 0.0]);
    file.set("/meshes/0/primitives/0/attributes/TEXCOORD_1", json!(other));
    file.material(painted(json!({"index": texture})));
    assert_eq!(row(&file, 2), "RG");
    file.material(painted(json!({"index": texture, "texCoord": 1})));
    assert_eq!(row(&file, 2), "GG");
    // The transform may choose another.
    let transform = json!({"KHR_texture_transform": {"texCoord": 0}});
    file.material(painted(json!({"index": texture, "texCoord": 1, "extensions": transform})));
    assert_eq!(row(&file, 2), "RG");
    // Two sets in one material are one too many.
    file.material(json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": texture}},
        "occlusionTexture": {"index": texture, "texCoord": 1}}));
    assert_eq!(
        file.warnings(),
        ["materials[0]: occlusion textures on another set of coordinates than the base colour's are left out"]
    );
}

/// Red × the factor's alpha × the texture's alpha over the background.
#[test]
fn alpha_of_texture_and_factor_blend() {
    let mut file = File::quad(1.0);
    let texture = file.texture(1, &[[255, 0, 0, 51]]);
    let mut material = painted(json!({"index": texture}));
    material["alphaMode"] = json!("OPAQUE");
    let opaque = facing(file.material(material.clone()).whole()).middle();
    assert_eq!(opaque, [1.0, 0.0, 0.0]);
    let background = {
        let mut empty = file.clone();
        facing(empty.set("/scenes/0/nodes", json!([])).load().unwrap()).middle()
    };
    material["alphaMode"] = json!("BLEND");
    for factor in [1.0, 0.5] {
        material["pbrMetallicRoughness"]["baseColorFactor"] = json!([1.0, 1.0, 1.0, factor]);
        let blended = facing(file.material(material.clone()).whole()).middle();
        let alpha = 0.2 * factor as f32;
        let expected: [f32; 3] = std::array::from_fn(|i| alpha * opaque[i] + (1.0 - alpha) * background[i]);
        for i in 0..3 {
            assert!((blended[i] - expected[i]).abs() < 2e-3, "factor {factor}: {blended:?} {expected:?}");
        }
    }
    // As much on surfaces that are lit.
    material.as_object_mut().unwrap().remove("extensions");
    let [_, g, b] = facing(file.material(material).whole()).middle();
    assert!(g > 0.85 * background[1] && b > 0.85 * background[2], "{g} {b}");
}

#[test]
fn alpha_of_texture_and_factor_cut_out() {
    let mut file = File::quad(1.0);
    // Alpha 0.4 on the left, 0.8 on the right.
    let texture = file.texture(2, &[[255, 0, 0, 102], [255, 0, 0, 204]]);
    let mut of = |factor: f32, cutoff: f32| {
        let mut material = painted(json!({"index": texture}));
        material["pbrMetallicRoughness"]["baseColorFactor"] = json!([1.0, 1.0, 1.0, factor]);
        material["alphaMode"] = json!("MASK");
        material["alphaCutoff"] = json!(cutoff);
        row(file.material(material), 2)
    };
    assert_eq!(of(1.0, 0.5), "?R");
    assert_eq!(of(1.0, 0.3), "RR");
    assert_eq!(of(0.5, 0.3), "?R", "0.2 and 0.4");
    assert_eq!(of(0.5, 0.5), "??");
    assert_eq!(of(0.0, 0.5), "??");
    assert_eq!(of(1.0, 0.0), "RR");
}

#[test]
fn images_are_shared_and_kept_apart_by_what_they_mean() {
    let mut file = File::quad(1.0);
    let texture = file.texture(1, &[RED]);
    let same = json!({"index": texture});
    file.set(
        "/materials",
        json!([
            {"pbrMetallicRoughness": {"baseColorTexture": same, "metallicRoughnessTexture": same}},
            {"pbrMetallicRoughness": {"baseColorTexture": same}}
        ]),
    );
    let scene = file.whole();
    assert_eq!(scene.textures.iter().map(|t| t.srgb).collect::<Vec<_>>(), [true, false]);
    assert_eq!(scene.materials[1].texture, scene.materials[2].texture);
}

#[test]
fn images_that_cannot_be_had_are_said() {
    let mut file = File::quad(1.0);
    let texture = file.texture(1, &[RED]);
    file.material(painted(json!({"index": texture})));
    file.set("/images/0/uri", json!("no%20where.png"));
    assert_eq!(file.warnings(), ["images[0]: file `no where.png` does not exist"]);
    file.set("/textures/0", json!({"extensions": {"KHR_texture_basisu": {"source": 0}}}));
    file.set("/extensionsUsed", json!(["KHR_texture_basisu"]));
    assert_eq!(
        file.warnings(),
        [
            "extension KHR_texture_basisu is ignored",
            "materials[0]: textures whose images are of no kind that is read are left out"
        ]
    );
}
