//! Lights and shadows.

use crate::kit::*;
use glam::Vec3;
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
