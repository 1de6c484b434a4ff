//! Lights and shadows.

use crate::kit::*;
use glam::{Affine3A, Vec3, Vec4};
use openrt::scene::*;

#[test]
fn a_first_program_without_lights_and_shaders_is_not_black() {
    let mut w = World::new(3);
    w.add(wall(-2.0, 0));
    assert_near(w.middle(), [0.8, 0.8, 0.8, 1.0], 1e-5);
}

#[test]
fn lights_follow_their_laws() {
    let mut w = World::new(3);
    let white = w.shader("diffuse", &[("color", grey(1.0)), ("ambient", grey(1.0))]);
    w.add(wall(-2.0, white));
    w.frame.ambient = Some([0.0; 3]);
    let with = |class: &str, values: &[(&str, ParamValue)]| {
        let mut v = World { scene: Scene::default(), frame: w.frame.clone(), next: 500 };
        v.scene.classes = w.scene.classes.clone();
        v.scene.objects = w.scene.objects.clone();
        v.scene.shaders = w.scene.shaders.clone();
        v.light(class, values);
        v.middle().x
    };
    let near = |a: f32, b: f32| assert!((a - b).abs() < 1e-4, "{a} is not {b}");
    near(with("ambient", &[("color", grey(0.3))]), 0.3);
    near(with("point", &[("color", grey(0.5))]), 0.5);
    near(with("point", &[("attenuation", rgb(0.0, 0.0, 1.0))]), 0.25);
    near(with("point", &[("attenuation", rgb(1.0, 2.0, 0.0))]), 0.2);
    near(with("point", &[("position", rgb(2.0, 0.0, 0.0))]), 0.5f32.sqrt());
    near(with("point", &[("position", rgb(0.0, 0.0, -3.0))]), 0.0);
    near(with("directional", &[]), 1.0);
    near(with("directional", &[("direction", rgb(3.0, 0.0, -4.0))]), 0.8);
    near(with("spot", &[("position", rgb(0.0, 0.0, 0.0)), ("cutoff", float(10.0))]), 1.0);
    near(with("spot", &[("direction", rgb(0.5, 0.0, -1.0)), ("cutoff", float(10.0))]), 0.0);
    near(with("spot", &[("direction", rgb(1.0, 0.0, -1.0)), ("exponent", float(2.0)), ("cutoff", float(90.0))]), 0.5);
}

#[test]
fn a_shadow_falls_where_it_must() {
    let mut w = World::new(3);
    let white = w.shader("diffuse", &[("color", grey(1.0))]);
    w.add(wall(-2.0, white));
    w.light("point", &[("position", rgb(1.0, 0.0, 0.0))]);
    assert!(w.middle().x > 0.8);
    // Half way between the middle of the wall and the light, out of the camera's sight.
    w.add(quad(Vec3::new(0.5, 0.0, -1.0), Vec3::X * 0.2, Vec3::Y * 0.2, 0));
    assert_near(w.middle(), [0.0, 0.0, 0.0, 1.0], 0.0);
    w.frame.renderer = w.shader("raycast", &[]);
    assert!(w.middle().x > 0.8);
}

#[test]
fn ambient_light_is_what_opengl_has_where_a_surface_asks_for_it() {
    let shown = |share: Option<f32>, lights: &[f32], global: Option<f32>, class: &str| {
        let mut w = World::new(1);
        let params: Vec<_> = share.iter().map(|&share| ("ambient", grey(share))).collect();
        let surface = w.shader(class, &params);
        w.add(wall(-2.0, surface));
        w.light("point", &[("position", rgb(0.0, 0.0, -3.0))]);
        for &light in lights {
            w.light("ambient", &[("color", grey(light))]);
        }
        w.frame.ambient = global.map(|a| [a; 3]);
        w.middle().x
    };
    let near = |a: f32, b: f32| assert!((a - b).abs() < 1e-6, "{a} is not {b}");
    // OpenGL's 0.2, for surfaces that were told to reflect it, if only with the default.
    near(shown(Some(0.5), &[], None, "phong"), 0.1);
    near(shown(Some(0.2), &[], None, "phong"), 0.04);
    near(shown(None, &[], None, "phong"), 0.0);
    near(shown(Some(0.5), &[], None, "diffuse"), 0.08);
    near(shown(Some(0.5), &[], None, "cutout"), 0.08);
    // Lights of the class take its place; what the application sets is added to them, for every surface.
    near(shown(Some(0.5), &[0.3, 0.1], None, "phong"), 0.2);
    near(shown(None, &[0.3], None, "phong"), 0.06);
    near(shown(Some(0.5), &[0.3], Some(0.5), "phong"), 0.4);
    near(shown(None, &[], Some(1.0), "phong"), 0.2);
    near(shown(Some(0.5), &[], Some(0.0), "phong"), 0.0);
}

/// The picture of a small scene lit by one light.
fn lit_by(place: Affine3A, class: &str, values: &[(&str, ParamValue)]) -> Vec<Vec4> {
    let mut w = World::new(16);
    let white = w.shader("phong", &[("diffuse", grey(1.0)), ("specular", grey(0.5))]);
    w.add(wall(-3.0, white));
    w.add(quad(Vec3::new(0.5, 0.2, -2.0), Vec3::X * 0.3, Vec3::Y * 0.3, white));
    w.light(class, values);
    w.frame.lights[0].world_from_light = place;
    w.render()
}

fn same(what: &str, a: &[Vec4], b: &[Vec4], most: usize) {
    assert!(a.iter().any(|c| c.x > 0.1), "{what} is dark");
    let differ = a.iter().zip(b).filter(|(a, b)| (**a - **b).abs().max_element() > 1e-3).count();
    assert!(differ <= most, "{what}: {differ} pixels differ");
}

#[test]
fn lights_move_with_their_matrix() {
    let turned = Affine3A::from_translation(Vec3::new(0.5, 1.0, 0.0)) * Affine3A::from_rotation_z(0.8);
    let place = turned * Affine3A::from_scale(Vec3::new(2.0, 2.0, 2.0));
    let p = |v: Vec3| place.transform_point3(v).to_array();
    let d = |v: Vec3| place.transform_vector3(v).to_array();
    let v = |v: [f32; 3]| rgb(v[0], v[1], v[2]);
    let (position, direction) = (Vec3::new(0.2, -0.3, 0.1), Vec3::new(0.1, -0.2, -1.0));
    let (edge_u, edge_v) = (Vec3::new(0.3, 0.0, 0.0), Vec3::new(0.0, -0.2, 0.0));
    let text = |s: &str| ParamValue::String(s.into());
    let both = |what: &str, class: &str, own: &[(&str, ParamValue)], moved: &[(&str, ParamValue)]| {
        same(what, &lit_by(place, class, own), &lit_by(Affine3A::IDENTITY, class, moved), 2);
        // It does make a difference.
        let (here, there) = (lit_by(Affine3A::IDENTITY, class, own), lit_by(place, class, own));
        assert!(here.iter().zip(&there).any(|(a, b)| (*a - *b).length() > 0.01), "{what}");
    };
    both("point", "point", &[("position", v(position.to_array()))], &[("position", v(p(position)))]);
    both("directional", "directional", &[("direction", v(direction.to_array()))], &[("direction", v(d(direction)))]);
    let cutoff = ("cutoff", float(30.0));
    let own = [("position", v(position.to_array())), ("direction", v(direction.to_array())), cutoff.clone()];
    both("spot", "spot", &own, &[("position", v(p(position))), ("direction", v(d(direction))), cutoff]);
    let samples = ("samples", int(64));
    let edges = |u: [f32; 3], w: [f32; 3]| [("edge_u", v(u)), ("edge_v", v(w)), samples.clone()];
    let (own, moved) = (edges(edge_u.to_array(), edge_v.to_array()), edges(d(edge_u), d(edge_v)));
    let with = |edges: &[(&'static str, ParamValue)], position: [f32; 3], shape: &str, radius: f32| {
        let rest = [("position", v(position)), ("shape", text(shape)), ("radius", float(radius))];
        [edges, &rest].concat()
    };
    for (shape, radius) in [("rectangle", 0.0), ("disc", 0.4), ("sphere", 0.4)] {
        let own = with(&own, position.to_array(), shape, radius);
        both(shape, "area", &own, &with(&moved, p(position), shape, 2.0 * radius));
    }
    // A mirrored area shines to the side that its mirror image shines to.
    let mirror = Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    let own = with(&own, position.to_array(), "rectangle", 0.0);
    let image = Vec3::new(-position.x, position.y, position.z);
    let image = with(&edges(edge_u.to_array(), edge_v.to_array()), image.to_array(), "rectangle", 0.0);
    // Its samples are in other places, which shows in the penumbra; the other side would be dark.
    same("mirrored area", &lit_by(mirror, "area", &own), &lit_by(Affine3A::IDENTITY, "area", &image), 16);
}
