//! `metallic_roughness`: what it reflects, scatters and lets through.

use crate::kit::*;
use glam::{Vec2, Vec3};
use openrt::scene::*;

fn metal(w: &mut World, color: ParamValue, roughness: f32) -> Name {
    w.shader("metallic_roughness", &[("color", color), ("metallic", float(1.0)), ("roughness", float(roughness))])
}

/// A light that nothing sees switches the lamp at the eye off.
fn dark(w: &mut World) {
    w.light("directional", &[("direction", rgb(0.0, 0.0, 1.0)), ("color", grey(0.0))]);
}

/// A quad at z = −2 that is tilted towards +x.
fn tilted(degrees: f32, shader: Name) -> Mesh {
    let a = degrees.to_radians();
    quad(Vec3::new(0.0, 0.0, -2.0), Vec3::new(a.cos(), 0.0, -a.sin()) * 8.0, Vec3::Y * 8.0, shader)
}

#[test]
fn a_smooth_metal_is_a_mirror_in_its_colour() {
    for degrees in [0.0f32, 20.0, 45.0] {
        let mut w = World::new(1);
        w.use_compass();
        dark(&mut w);
        let shader = metal(&mut w, rgb(1.0, 0.5, 0.25), 0.0);
        w.add(tilted(degrees, shader));
        let a = (2.0 * degrees).to_radians();
        let seen = compass(Vec3::new(a.sin(), 0.0, a.cos()));
        let color = w.middle();
        // Schlick's rise to white stays small below 45 degrees.
        for (c, (s, tint)) in
            color.truncate().to_array().into_iter().zip(seen.to_array().into_iter().zip([1.0, 0.5, 0.25]))
        {
            assert!((c - s * tint).abs() < 0.05, "{degrees}: {color} {seen}");
        }
    }
}

/// Under a uniform sky a white metal of any roughness reflects a share that does not depend on the renderer, and no lamp is
/// needed for it to be seen.
#[test]
fn rough_metals_reflect_a_uniform_sky() {
    for roughness in [0.0f32, 0.3, 0.5, 0.7, 1.0] {
        let mut colors = Vec::new();
        for renderer in ["whitted", "raycast", "path"] {
            let mut w = World::new(8);
            w.frame.samples = 64;
            w.frame.environment = w.shader("background", &[("color", grey(1.0))]);
            dark(&mut w);
            w.frame.renderer = w.shader(renderer, &[]);
            let shader = metal(&mut w, grey(1.0), roughness);
            w.add(wall(-2.0, shader));
            let picture = w.render();
            colors.push(picture.iter().map(|c| c.x).sum::<f32>() / picture.len() as f32);
        }
        assert!(colors.iter().all(|&c| c > 0.3 && c < 1.01), "roughness {roughness}: {colors:?}");
        let (low, high) = (colors.iter().copied().fold(9.0, f32::min), colors.iter().copied().fold(0.0, f32::max));
        assert!(high - low < 0.02, "roughness {roughness}: {colors:?}");
    }
}

/// A highlight lies around the mirror direction of the light, is tinted, and is the wider the rougher the metal.
#[test]
fn highlights_widen_with_roughness() {
    let at = |roughness: f32, degrees: f32| {
        let mut w = World::new(1);
        w.light("directional", &[("direction", rgb(0.0, 0.0, -1.0)), ("color", grey(0.1))]);
        let shader = metal(&mut w, rgb(1.0, 0.5, 0.0), roughness);
        w.add(tilted(degrees, shader));
        w.middle()
    };
    let straight = [0.3f32, 0.5, 0.8].map(|r| at(r, 0.0).x);
    assert!(straight[0] > straight[1] && straight[1] > straight[2], "{straight:?}");
    let aside = [0.3f32, 0.5, 0.8].map(|r| at(r, 30.0).x);
    assert!(aside[0] < aside[1] && aside[1] < aside[2] && aside[2] > 0.005, "{aside:?}");
    let tint = at(0.8, 10.0);
    assert!((tint.y / tint.x - 0.5).abs() < 0.05 && tint.z < 0.05 * tint.x, "{tint}");
}

/// What the lamp at the eye gives a dielectric: its colour, a little more in the highlight.
#[test]
fn a_dielectric_scatters_its_colour() {
    let mut w = World::new(1);
    let shader = w.shader("metallic_roughness", &[("color", rgb(0.6, 0.3, 0.0)), ("roughness", float(1.0))]);
    w.add(wall(-2.0, shader));
    let color = w.middle();
    assert_near(color, [0.6, 0.3, 0.0, 1.0], 0.05);
    // Less where it is metal, by a texture: red is not asked.
    let image = texture(&mut w, [[0, 255, 255, 255]; 4], Filter::Nearest);
    let parameters = [
        ("color", rgb(0.6, 0.3, 0.0)),
        ("metallic", float(1.0)),
        ("roughness", float(1.0)),
        ("metallic_roughness_texture", ParamValue::Texture(image)),
    ];
    let shader = w.shader("metallic_roughness", &parameters);
    w.frame.instances.clear();
    w.add(wall(-2.0, shader));
    assert!(w.middle().x < 0.4 * color.x, "{} {color}", w.middle());
}

#[test]
fn alpha_blends_where_it_is_asked_for() {
    for class in ["constant", "phong", "metallic_roughness"] {
        let mut w = World::new(1);
        w.frame.environment = w.shader("background", &[("color", rgb(0.0, 0.0, 1.0))]);
        let image = texture(&mut w, [[255, 255, 255, 51]; 4], Filter::Nearest);
        let of = |w: &mut World, blend: i32, opacity: f32| {
            let values =
                [("texture", ParamValue::Texture(image)), ("alpha_blend", int(blend)), ("opacity", float(opacity))];
            let shader = w.shader(class, &values);
            w.frame.instances.clear();
            w.add(wall(-2.0, shader));
            (w.middle(), shader)
        };
        let (opaque, _) = of(&mut w, 0, 1.0);
        for (blend, opacity, alpha) in [(1, 1.0, 0.2f32), (1, 0.5, 0.1), (0, 0.5, 0.5)] {
            let (color, _) = of(&mut w, blend, opacity);
            let expected = opaque.truncate() * alpha + Vec3::Z * (1.0 - alpha);
            assert_near(color, [expected.x, expected.y, expected.z, 1.0], 3e-3);
        }
        // Light passes, too.
        let (_, shader) = of(&mut w, 1, 1.0);
        w.frame.instances.clear();
        let white = w.shader("diffuse", &[("color", grey(1.0)), ("ambient", grey(0.0))]);
        w.add(wall(-2.0, white));
        w.add(quad(Vec3::new(2.0, 0.0, -1.0), Vec3::X * 1.5, Vec3::Y * 1.5, shader));
        w.light("point", &[("position", rgb(4.0, 0.0, 0.0))]);
        let with = w.middle().x;
        w.frame.instances.pop();
        let without = w.middle().x;
        assert!((with / without - 0.8).abs() < 1e-3, "{class}: {with} of {without}");
    }
}

/// A normal that leans to +s mirrors what lies on that side.
#[test]
fn normals_lean_along_the_texture_coordinates() {
    for (texel, side) in [([218, 128, 218, 255], Vec3::X), ([128, 218, 218, 255], Vec3::Y)] {
        for flip in [false, true] {
            let mut w = World::new(1);
            w.use_compass();
            dark(&mut w);
            let image = texture(&mut w, [texel; 4], Filter::Nearest);
            let values = [
                ("color", grey(1.0)),
                ("metallic", float(1.0)),
                ("roughness", float(0.0)),
                ("normal_texture", ParamValue::Texture(image)),
            ];
            let shader = w.shader("metallic_roughness", &values);
            let mut mesh = wall(-2.0, shader);
            if flip {
                mesh.tex_coords.iter_mut().for_each(|t| *t = Vec2::ONE - *t);
            }
            w.add(mesh);
            let side = if flip { -side } else { side };
            let seen = compass(side).extend(1.0);
            assert!((w.middle() - seen).abs().max_element() < 0.05, "{texel:?} {flip}: {} {seen}", w.middle());
        }
    }
}
