//! The built-in shader classes: their names, parameters and defaults. The C header's manual repeats this table.
//!
//! Colours are linear RGB. A *base colour* is `color` (or `diffuse`) × texture × vertex colour. `texture` and
//! `alpha_texture` are texture names, 0 = none. Lengths are in world units, angles in degrees.
//!
//! | surface | parameters |
//! |---|---|
//! | `constant` | glows with the base colour, unlit: `color` 1 1 1, `texture`, `opacity` 1, `alpha_texture`, `alpha_threshold` 0, `alpha_blend` 0 |
//! | `diffuse` | Lambert: `color` 0.8 0.8 0.8, `ambient` 0.2 0.2 0.2 (share of the ambient light that is reflected), `texture` |
//! | `phong` | `ambient` 0.2, `diffuse` 0.8, `specular` 0, `shininess` 32 (highlights of lights: cosᵏ around the mirror direction), `reflection` 0 (mirror image of the scene), `transmission` 0 and `ior` 1 (refracted image), `emission` 0, `opacity` 1, `texture`, `alpha_texture`, `alpha_threshold` 0, `alpha_blend` 0 |
//! | `cutout` | `diffuse` with holes where alpha < `alpha_threshold` 0.5: `color`, `ambient`, `texture`, `alpha_texture` |
//! | `mirror` | perfect mirror: `color` 1 1 1, `texture` |
//! | `glass` | smooth dielectric with Fresnel reflection: `color` 1 1 1 (per crossing), `ior` 1.5 |
//! | `metal` | `color` 0.9 0.9 0.9, `roughness` 0 (0 mirror … 1 dull), `texture` |
//! | `metallic_roughness` | the material of glTF: `color` 0.8 0.8 0.8 with `texture`; `metallic` 0 and `roughness` 0.5, multiplied by blue and green of `metallic_roughness_texture`; `specular` 0.04 0.04 0.04 (what a dielectric reflects at normal incidence); `ambient` 0.2; `emission` 0 × `emission_texture`; `transmission` 0 with `ior` 1 (1: a thin sheet); `normal_texture` with `normal_scale` 1 1 (of red and green; −1 for the second where the first row of the image lies at t = 0); red of `occlusion_texture` with `occlusion_strength` 1; `opacity` 1, `alpha_texture`, `alpha_threshold` 0, `alpha_blend` 0 |
//! | `eyelight` | base colour × cosine to the viewer, no lights: `color` 0.8 0.8 0.8, `texture` |
//! | `normals` | the shading normal as a colour, ½(n + 1) |
//! | `wireframe` | `color` 0 0 0 on the triangle's edges, `background` 1 1 1, `thickness` 1.5 (pixels) |
//!
//! Opacity: alpha is vertex alpha × texture alpha × alpha-texture's red. With an `alpha_threshold` above 0, points
//! whose alpha lies below it do not exist, for shadows too, and all others are opaque. `opacity` blends with what
//! lies behind, without refraction; with `alpha_blend` 1 it is multiplied by alpha. NFF's `f r g b Kd Ks shine T ior` is `phong` with `diffuse` Kd·rgb, `specular`
//! and `reflection` Ks·rgb, `shininess`, `transmission` T, `ior`.
//!
//! | light | parameters |
//! |---|---|
//! | `ambient` | `color` 0.2 0.2 0.2, from everywhere, never shadowed |
//! | `point` | `position` 0 0 0, `color` 1 1 1, `attenuation` 1 0 0 (constant, linear, quadratic: divides by c + l·d + q·d²) |
//! | `directional` | `direction` 0 0 −1 (in which the light travels), `color` |
//! | `spot` | `position`, `direction`, `color`, `attenuation`, `cutoff` 45 (half angle), `penumbra` 0 (degrees inside the cutoff over which it fades), `exponent` 0 (cosᵏ towards the rim) |
//! | `area` | `shape` "rectangle" (or "disc", "sphere"), `position` 0 0 0 (centre), `edge_u` 1 0 0, `edge_v` 0 0 1 (full sides of the rectangle, axes of the disc; it shines to the side of u × v), `radius` 0.5 (disc, sphere), `color`, `attenuation`, `samples` 16 |
//!
//! Ambient light is the sum of the `ambient` lights and of that of the frame ([`crate::scene::FrameDesc::ambient`]). Positions, directions and edges of lights
//! are transformed by the matrix that they are used with.
//!
//! A light of colour 1 facing a white diffuse surface head on gives it the value 1: no π appears, as in OpenGL. An
//! area light spreads the same power over its surface and falls off with the cosine at the light. Lights themselves
//! are invisible. A frame without any light is lit by a lamp at the eye (`whitted` and `raycast` only), so a first
//! program is not black.
//!
//! | camera | parameters |
//! |---|---|
//! | `pinhole` | `eye` 0 0 0, `center` 0 0 −1, `up` 0 1 0, `fov` 60 (vertical), `aspect` 0 (width/height; 0 takes the viewport's), `window` 0 0 0 0 (left right bottom top at distance 1; replaces `fov` when not empty) |
//! | `orthographic` | `eye`, `center`, `up`, `height` 2, `aspect`, `window` (left right bottom top; replaces `height`) |
//! | `thinlens` | as `pinhole`, and `aperture` 0.05 (radius of the lens), `focus` 0 (distance in focus; 0 takes that of `center`) |
//! | `environment` | latitude-longitude picture of all directions: `eye`, `center` (the middle of the picture), `up` |
//!
//! | environment | parameters |
//! |---|---|
//! | `background` | one colour: `color` 0 0 0 |
//! | `gradient` | `bottom` 0.3 0.25 0.2, `horizon` 0.9 0.95 1, `top` 0.25 0.45 0.9, `up` 0 1 0 |
//! | `latlong` | `texture` (2:1, its middle towards −z, +y up), `intensity` 1, `rotation` 0 (about y) |
//!
//! | rendering object | parameters |
//! |---|---|
//! | `whitted` | the default. Lights, shadows, mirror and refracted rays: `max_depth` −1 (bounces; −1 takes the frame's), `shadows` 1 |
//! | `raycast` | primary rays and lights only, no secondary rays |
//! | `ambient_occlusion` | white × share of the hemisphere that sees `distance` 0 (0 = everything) far: `samples` 16 |
//! | `path` | global illumination, one path per sample: `max_depth` 32, `roulette_depth` 4 (bounces before paths may end at random) |

use crate::scene::{ParamDef, ParamScope, ParamType, ParamValue, Program, ShaderClass, ShaderKind};
use std::sync::Arc;

/// Every built-in class, with [`Program::BuiltIn`]; the names are unique.
pub fn builtin_classes() -> Vec<Arc<ShaderClass>> {
    [surfaces(), lights(), cameras(), environments(), renderers()].concat()
}

fn class(kind: ShaderKind, name: &str, params: Vec<ParamDef>) -> Arc<ShaderClass> {
    Arc::new(ShaderClass { name: name.into(), kind, params, block_size: 0, program: Program::BuiltIn })
}

fn param(name: &str, ty: ParamType, default: ParamValue) -> ParamDef {
    ParamDef { name: name.into(), ty, scope: ParamScope::Shader, default, choices: &[], offset: 0 }
}

fn rgb(name: &str, r: f32, g: f32, b: f32) -> ParamDef {
    param(name, ParamType::Float(3), ParamValue::Float([r, g, b, 0.0]))
}

fn grey(name: &str, value: f32) -> ParamDef {
    rgb(name, value, value, value)
}

fn float(name: &str, value: f32) -> ParamDef {
    param(name, ParamType::Float(1), ParamValue::Float([value, 0.0, 0.0, 0.0]))
}

fn int(name: &str, value: i32) -> ParamDef {
    param(name, ParamType::Int(1), ParamValue::Int([value, 0, 0, 0]))
}

fn texture(name: &str) -> ParamDef {
    param(name, ParamType::Texture, ParamValue::Texture(0))
}

fn surfaces() -> Vec<Arc<ShaderClass>> {
    let surface = |name, params| class(ShaderKind::Surface, name, params);
    vec![
        surface("constant", [vec![grey("color", 1.0), texture("texture")], alpha()].concat()),
        surface("diffuse", vec![grey("color", 0.8), grey("ambient", 0.2), texture("texture")]),
        surface(
            "phong",
            vec![
                grey("ambient", 0.2),
                grey("diffuse", 0.8),
                grey("specular", 0.0),
                float("shininess", 32.0),
                grey("reflection", 0.0),
                grey("transmission", 0.0),
                float("ior", 1.0),
                grey("emission", 0.0),
                float("opacity", 1.0),
                texture("texture"),
                texture("alpha_texture"),
                float("alpha_threshold", 0.0),
                int("alpha_blend", 0),
            ],
        ),
        surface(
            "cutout",
            vec![
                grey("color", 0.8),
                grey("ambient", 0.2),
                texture("texture"),
                texture("alpha_texture"),
                float("alpha_threshold", 0.5),
            ],
        ),
        surface("mirror", vec![grey("color", 1.0), texture("texture")]),
        surface("glass", vec![grey("color", 1.0), float("ior", 1.5)]),
        surface("metal", vec![grey("color", 0.9), float("roughness", 0.0), texture("texture")]),
        surface("metallic_roughness", [metallic_roughness(), alpha()].concat()),
        surface("eyelight", vec![grey("color", 0.8), texture("texture")]),
        surface("normals", vec![]),
        surface("wireframe", vec![grey("color", 0.0), grey("background", 1.0), float("thickness", 1.5)]),
    ]
}

/// Parameters of surfaces that need not hide what lies behind them.
fn alpha() -> Vec<ParamDef> {
    vec![float("opacity", 1.0), texture("alpha_texture"), float("alpha_threshold", 0.0), int("alpha_blend", 0)]
}

fn metallic_roughness() -> Vec<ParamDef> {
    vec![
        grey("color", 0.8),
        grey("ambient", 0.2),
        float("metallic", 0.0),
        float("roughness", 0.5),
        grey("specular", 0.04),
        grey("emission", 0.0),
        float("transmission", 0.0),
        float("ior", 1.0),
        texture("texture"),
        texture("metallic_roughness_texture"),
        texture("normal_texture"),
        param("normal_scale", ParamType::Float(2), ParamValue::Float([1.0, 1.0, 0.0, 0.0])),
        texture("occlusion_texture"),
        float("occlusion_strength", 1.0),
        texture("emission_texture"),
    ]
}

fn lights() -> Vec<Arc<ShaderClass>> {
    let light = |name, params| class(ShaderKind::Light, name, params);
    let position = || grey("position", 0.0);
    let direction = || rgb("direction", 0.0, 0.0, -1.0);
    let color = || grey("color", 1.0);
    let attenuation = || rgb("attenuation", 1.0, 0.0, 0.0);
    let shape = ParamDef {
        choices: &["rectangle", "disc", "sphere"],
        ..param("shape", ParamType::String, ParamValue::String("rectangle".into()))
    };
    vec![
        light("ambient", vec![grey("color", 0.2)]),
        light("point", vec![position(), color(), attenuation()]),
        light("directional", vec![direction(), color()]),
        light(
            "spot",
            vec![
                position(),
                direction(),
                color(),
                attenuation(),
                float("cutoff", 45.0),
                float("penumbra", 0.0),
                float("exponent", 0.0),
            ],
        ),
        light(
            "area",
            vec![
                shape,
                position(),
                rgb("edge_u", 1.0, 0.0, 0.0),
                rgb("edge_v", 0.0, 0.0, 1.0),
                float("radius", 0.5),
                color(),
                attenuation(),
                int("samples", 16),
            ],
        ),
    ]
}

fn cameras() -> Vec<Arc<ShaderClass>> {
    let camera = |name, own: Vec<ParamDef>| {
        let mut params = vec![grey("eye", 0.0), rgb("center", 0.0, 0.0, -1.0), rgb("up", 0.0, 1.0, 0.0)];
        params.extend(own);
        class(ShaderKind::Camera, name, params)
    };
    let aspect = || float("aspect", 0.0);
    let window = || param("window", ParamType::Float(4), ParamValue::Float([0.0; 4]));
    vec![
        camera("pinhole", vec![float("fov", 60.0), aspect(), window()]),
        camera("orthographic", vec![float("height", 2.0), aspect(), window()]),
        camera("thinlens", vec![float("fov", 60.0), aspect(), window(), float("aperture", 0.05), float("focus", 0.0)]),
        camera("environment", vec![]),
    ]
}

fn environments() -> Vec<Arc<ShaderClass>> {
    let environment = |name, params| class(ShaderKind::Environment, name, params);
    vec![
        environment("background", vec![grey("color", 0.0)]),
        environment(
            "gradient",
            vec![
                rgb("bottom", 0.3, 0.25, 0.2),
                rgb("horizon", 0.9, 0.95, 1.0),
                rgb("top", 0.25, 0.45, 0.9),
                rgb("up", 0.0, 1.0, 0.0),
            ],
        ),
        environment("latlong", vec![texture("texture"), float("intensity", 1.0), float("rotation", 0.0)]),
    ]
}

fn renderers() -> Vec<Arc<ShaderClass>> {
    let renderer = |name, params| class(ShaderKind::Renderer, name, params);
    vec![
        renderer("whitted", vec![int("max_depth", -1), int("shadows", 1)]),
        renderer("raycast", vec![]),
        renderer("ambient_occlusion", vec![int("samples", 16), float("distance", 0.0)]),
        renderer("path", vec![int("max_depth", 32), int("roulette_depth", 4)]),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn names_are_unique_and_defaults_match_their_types() {
        let classes = builtin_classes();
        let names: HashSet<_> = classes.iter().map(|c| c.name.clone()).collect();
        assert_eq!(names.len(), classes.len());
        for class in &classes {
            let params: HashSet<_> = class.params.iter().map(|p| p.name.clone()).collect();
            assert_eq!(params.len(), class.params.len(), "{}", class.name);
            for p in &class.params {
                let fits = matches!(
                    (p.ty, &p.default),
                    (ParamType::Int(1..=4), ParamValue::Int(_))
                        | (ParamType::Float(1..=4), ParamValue::Float(_))
                        | (ParamType::String, ParamValue::String(_))
                        | (ParamType::Texture, ParamValue::Texture(0))
                );
                assert!(fits, "{}.{}", class.name, p.name);
            }
        }
    }
}
