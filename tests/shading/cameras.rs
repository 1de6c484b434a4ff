//! Cameras and environments.

use crate::kit::*;
use glam::Vec3;
use openrt::scene::*;

#[test]
fn cameras_see_where_they_look() {
    let see = |class: &str, values: &[(&str, ParamValue)], size: u32| {
        let mut w = World::new(size);
        w.use_compass();
        w.frame.camera = w.shader(class, values);
        let picture = w.render();
        move |x: usize, y: usize| (picture[y * size as usize + x].truncate() * 2.0 - Vec3::ONE).normalize()
    };
    let near = |a: Vec3, b: Vec3| assert!((a - b).length() < 1e-3, "{a} is not {b}");
    // 3 × 3 pixels, 90° high: the outer pixels' centres are at ±2/3.
    let d = see("pinhole", &[("fov", float(90.0)), ("center", rgb(1.0, 0.0, 0.0))], 3);
    near(d(1, 1), Vec3::X);
    near(d(2, 1), Vec3::new(1.0, 0.0, 2.0 / 3.0).normalize());
    near(d(1, 2), Vec3::new(1.0, 2.0 / 3.0, 0.0).normalize());
    let window = ParamValue::Float([0.0, 3.0, -3.0, 0.0]);
    let d = see("pinhole", &[("window", window)], 3);
    near(d(0, 2), Vec3::new(0.5, -0.5, -1.0).normalize());
    let d = see("orthographic", &[("center", rgb(0.0, -1.0, 0.0)), ("up", rgb(0.0, 0.0, -1.0))], 3);
    near(d(0, 0), Vec3::NEG_Y);
    near(d(2, 1), Vec3::NEG_Y);
    // Looking along the up vector is no reason to fail.
    let d = see("pinhole", &[("center", rgb(0.0, 5.0, 0.0))], 3);
    near(d(1, 1), Vec3::Y);
    let d = see("environment", &[], 4);
    near(d(2, 2), {
        let (phi, theta) = (std::f32::consts::FRAC_PI_4, std::f32::consts::PI / 8.0);
        Vec3::new(theta.cos() * phi.sin(), theta.sin(), -theta.cos() * phi.cos())
    });
}

#[test]
fn a_thin_lens_is_sharp_in_its_focus_only() {
    let mut w = World::new(16);
    w.frame.samples = 64;
    let [o, x] = [[0, 0, 0, 255], [255; 4]];
    let checker = texture(&mut w, [o, x, x, o], Filter::Nearest);
    let shader = w.shader("constant", &[("texture", ParamValue::Texture(checker))]);
    w.add(quad(Vec3::NEG_Z * 2.0, Vec3::X * 4.0, Vec3::Y * 4.0, shader));
    let mut contrast = |focus: f32| {
        let values = [("aperture", float(0.3)), ("focus", float(focus))];
        w.frame.camera = w.shader("thinlens", &values);
        w.render().iter().filter(|c| c.x == 0.0 || c.x == 1.0).count()
    };
    assert_eq!(contrast(2.0), 256);
    assert!(contrast(0.8) < 128);
}

#[test]
fn a_latlong_picture_surrounds_the_scene() {
    let mut w = World::new(4);
    // Two texels wide: left half (west of −z) red, right half green; upper row blue added.
    let image =
        texture(&mut w, [[255, 0, 0, 255], [0, 255, 0, 255], [255, 0, 255, 255], [0, 255, 255, 255]], Filter::Nearest);
    let values = [("texture", ParamValue::Texture(image)), ("intensity", float(2.0))];
    w.frame.environment = w.shader("latlong", &values);
    let picture = w.render();
    assert_near(picture[0], [2.0, 0.0, 0.0, 1.0], 0.0);
    assert_near(picture[3], [0.0, 2.0, 0.0, 1.0], 0.0);
    assert_near(picture[12], [2.0, 0.0, 2.0, 1.0], 0.0);
}
