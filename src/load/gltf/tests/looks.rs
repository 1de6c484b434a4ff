//! What materials look like.

use super::kit::*;
use serde_json::json;

fn pbr(color: [f32; 4], metallic: f32, roughness: f32) -> serde_json::Value {
    json!({"pbrMetallicRoughness":
        {"baseColorFactor": color, "metallicFactor": metallic, "roughnessFactor": roughness}})
}

/// Neither black nor white in any channel.
#[track_caller]
fn assert_shaded(color: [f32; 3], what: &str) {
    assert!(color.iter().all(|&c| c > 0.02 && c < 0.98), "{what}: {color:?}");
}

#[test]
fn the_default_material_is_a_rough_white_metal() {
    assert_shaded(picture(File::quad(1.0).material(json!({})).whole()).middle(), "an empty material");
    assert_shaded(picture(File::quad(1.0).whole()).middle(), "no material");
}

#[test]
fn metals_of_any_roughness_reflect_the_surroundings() {
    for step in 0..=10 {
        let roughness = step as f32 / 10.0;
        let grey = picture(File::quad(1.0).material(pbr([0.2, 0.2, 0.2, 1.0], 1.0, roughness)).whole()).middle();
        assert_shaded(grey, &format!("grey, roughness {roughness}"));
        let gold = picture(File::quad(1.0).material(pbr([1.0, 0.6, 0.2, 1.0], 1.0, roughness)).whole()).middle();
        assert!(gold[0] > 1.2 * gold[1] && gold[1] > 1.5 * gold[2], "gold, roughness {roughness}: {gold:?}");
    }
}

/// A light makes a rough metal brighter towards it than away from it.
#[test]
fn metals_are_lit_by_lights() {
    let mut file = File::quad(1.0);
    file.material(pbr([0.5, 0.5, 0.5, 1.0], 1.0, 0.6));
    let mut at = |direction: &str, intensity: f32| {
        let rotation = if direction == "front" { [0.0, 0.0, 0.0, 1.0] } else { [0.0, 1.0, 0.0, 0.0] };
        let lights = json!({"KHR_lights_punctual": {"lights": [{"type": "directional", "intensity": intensity}]}});
        file.set("/extensions", lights);
        // The light hangs on a node of its own, the mesh on another.
        let node = json!({"rotation": rotation, "extensions": {"KHR_lights_punctual": {"light": 0}}});
        file.set("/nodes", json!([{"mesh": 0}, node])).set("/scenes/0/nodes", json!([0, 1]));
        facing(file.whole()).middle()[0]
    };
    let (lit, unlit) = (at("front", 3.0), at("back", 3.0));
    assert!(lit > unlit + 0.1, "{lit} {unlit}");
}

#[test]
fn unlit_surfaces_have_their_colour() {
    let mut material = pbr([0.25, 0.5, 0.75, 1.0], 0.0, 1.0);
    material["extensions"] = json!({"KHR_materials_unlit": {}});
    let color =
        picture(File::quad(1.0).material(material).set("/extensionsUsed", json!(["KHR_materials_unlit"])).whole());
    assert_eq!(color.middle(), [0.25, 0.5, 0.75]);
}

#[test]
fn emission_shines_beside_everything() {
    let mut material = pbr([0.0, 0.0, 0.0, 1.0], 0.0, 1.0);
    material["emissiveFactor"] = json!([0.5, 0.25, 0.0]);
    material["extensions"] = json!({"KHR_materials_emissive_strength": {"emissiveStrength": 2.0}});
    let mut file = File::quad(1.0);
    file.material(material);
    let [r, g, b] = facing(file.whole()).middle();
    assert!((r - 1.0 - b).abs() < 0.01 && (g - 0.5 - b).abs() < 0.01 && b < 0.1, "{r} {g} {b}");
    let texture = file.texture(1, &[[0, 255, 255, 255]]);
    file.set("/materials/0/emissiveTexture", json!({"index": texture}));
    let [r, g, b] = facing(file.whole()).middle();
    assert!(r < 0.1 && (g - 0.5 - b).abs() < 0.01, "{r} {g} {b}");
}

#[test]
fn blue_and_green_say_what_is_metal_and_how_rough() {
    let mut file = File::quad(1.0);
    // On the left rough plastic, on the right a mirror.
    let texture = file.texture(2, &[[0, 255, 0, 255], [0, 0, 255, 255]]);
    file.material(json!({"pbrMetallicRoughness":
        {"baseColorFactor": [1.0, 0.0, 0.0, 1.0], "metallicRoughnessTexture": {"index": texture}}}));
    let picture = facing(file.whole());
    let (left, right) = (picture.at(0.25, 0.5), picture.at(0.75, 0.5));
    assert!(left[0] > 0.8 && left[1] > 0.005, "plastic is lit, and reflects white: {left:?}");
    assert!(right[0] > 0.5 && right[1] < 0.02, "metal reflects red alone: {right:?}");
    // The factors multiply.
    file.set("/materials/0/pbrMetallicRoughness/metallicFactor", json!(0.0));
    let color = facing(file.whole()).at(0.75, 0.5);
    assert!(color[1] > 0.005, "{color:?}");
}

#[test]
fn normals_of_textures_turn_the_surface() {
    let mut file = File::quad(1.0);
    // Flat, and leaning to the right.
    let texture = file.texture(2, &[[128, 128, 255, 255], [218, 128, 218, 255]]);
    file.material(pbr([1.0; 4], 1.0, 0.0));
    file.dark().set("/materials/0/normalTexture", json!({"index": texture}));
    let picture = facing(file.whole());
    // Straight back is the horizon of the sky, sideways too; down and up are not.
    assert_eq!(picture.at(0.25, 0.5).map(|c| (c * 20.0).round()), picture.at(0.75, 0.5).map(|c| (c * 20.0).round()));
    let up = file.texture(1, &[[128, 218, 218, 255]]);
    let down = file.texture(1, &[[128, 37, 218, 255]]);
    let blue = |file: &mut File, texture: usize| {
        let [r, _, b] = facing(file.set("/materials/0/normalTexture", json!({"index": texture})).whole()).middle();
        b / r
    };
    let (up, down) = (blue(&mut file, up), blue(&mut file, down));
    // The image stands on its head here: its up is against t, which grows upwards.
    assert!(up < 1.0 && down > 2.0, "green down looks to the blue zenith ({down}), green up to the ground ({up})");
}

#[test]
fn occlusion_darkens_what_comes_from_all_sides() {
    let mut file = File::quad(1.0);
    file.material(pbr([1.0; 4], 1.0, 1.0));
    let open = facing(file.whole()).middle()[0];
    let texture = file.texture(1, &[[0, 255, 255, 255]]);
    file.set("/materials/0/occlusionTexture", json!({"index": texture, "strength": 0.5}));
    let half = facing(file.whole()).middle()[0];
    file.set("/materials/0/occlusionTexture/strength", json!(1.0));
    let hidden = facing(file.whole()).middle()[0];
    assert!(open > half + 0.05 && half > hidden + 0.05, "{open} {half} {hidden}");
}

#[test]
fn older_specular_glossiness_is_read() {
    let mut file = File::quad(1.0);
    file.material(json!({"extensions": {"KHR_materials_pbrSpecularGlossiness":
        {"diffuseFactor": [0.0, 0.5, 0.0, 1.0], "specularFactor": [0.0, 0.0, 0.0], "glossinessFactor": 0.2}}}));
    let [r, g, b] = facing(file.whole()).middle();
    assert!((g - 0.5).abs() < 0.1 && r < 0.05 && b < 0.05, "{r} {g} {b}");
}

#[test]
fn transmission_lets_the_background_through() {
    let mut material = pbr([1.0; 4], 0.0, 0.0);
    material["extensions"] = json!({"KHR_materials_transmission": {"transmissionFactor": 1.0}});
    let mut file = File::quad(1.0);
    let [r, g, b] = facing(file.material(material.clone()).whole()).middle();
    assert!(r > 0.8 && g > 0.8 && b > 0.8, "the sky at the horizon: {r} {g} {b}");
    material["extensions"]["KHR_materials_transmission"]["transmissionTexture"] = json!({"index": 0});
    assert_eq!(file.material(material).warnings(), ["materials[0]: textures of transmission are left out"]);
}
