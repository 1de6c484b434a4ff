//! Mirrors, glass and the end of recursion.

use crate::kit::*;
use glam::Vec3;
use openrt::render::Renderer;
use openrt::scene::*;
use openrt::simd::Level;
use std::sync::atomic::AtomicBool;

/// A large quad through (0, 0, −2) whose normal is tilted by `degrees` from +z towards +x.
fn tilted(degrees: f32, shader: Name) -> Mesh {
    let a = degrees.to_radians();
    quad(Vec3::new(0.0, 0.0, -2.0), Vec3::new(a.cos(), 0.0, -a.sin()) * 8.0, Vec3::Y * 8.0, shader)
}

#[test]
fn a_mirror_reflects_by_the_law() {
    for degrees in [0.0f32, 20.0, 45.0, 70.0] {
        let mut w = World::new(1);
        w.use_compass();
        let mirror = w.shader("mirror", &[("color", rgb(1.0, 0.5, 0.25))]);
        w.add(tilted(degrees, mirror));
        let a = (2.0 * degrees).to_radians();
        let expected = compass(Vec3::new(a.sin(), 0.0, a.cos())) * Vec3::new(1.0, 0.5, 0.25);
        assert_near(w.middle(), [expected.x, expected.y, expected.z, 1.0], 1e-5);
    }
}

#[test]
fn glass_refracts_by_snell_and_reflects_by_fresnel() {
    for (degrees, inside) in [(0.0f32, false), (30.0, false), (60.0, false), (0.0, true), (30.0, true), (60.0, true)] {
        let mut w = World::new(1);
        w.use_compass();
        let glass = w.shader("glass", &[("color", rgb(1.0, 0.5, 1.0)), ("ior", float(1.5))]);
        let mut mesh = tilted(degrees, glass);
        if inside {
            mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        w.add(mesh);
        let a = f64::from(degrees).to_radians();
        let eta: f64 = if inside { 1.5 } else { 1.0 / 1.5 };
        let reflected = Vec3::new((2.0 * a).sin() as f32, 0.0, (2.0 * a).cos() as f32);
        let sin_out = eta * a.sin();
        let expected = if sin_out >= 1.0 {
            compass(reflected)
        } else {
            let (cos_in, cos_out) = (a.cos(), (1.0 - sin_out * sin_out).sqrt());
            let rs = ((eta * cos_in - cos_out) / (eta * cos_in + cos_out)).powi(2);
            let rp = ((cos_in - eta * cos_out) / (cos_in + eta * cos_out)).powi(2);
            let f = (0.5 * (rs + rp)) as f32;
            if degrees == 0.0 {
                assert!((f - 0.04).abs() < 1e-6, "4 % at normal incidence");
            }
            // The refracted ray leans from −n by the angle out, to the side of the incoming one.
            let turn = (a - sin_out.asin()) as f32;
            let refracted = Vec3::new(-turn.sin(), 0.0, -turn.cos());
            f * compass(reflected) + (1.0 - f) * Vec3::new(1.0, 0.5, 1.0) * compass(refracted)
        };
        assert_near(w.middle(), [expected.x, expected.y, expected.z, 1.0], 2e-5);
        // `path` chooses one of the two, with the same mean; total reflection leaves no choice.
        w.frame.renderer = w.shader("path", &[]);
        w.frame.samples = if sin_out >= 1.0 { 1 } else { 4096 };
        let tolerance = if sin_out >= 1.0 { 2e-5 } else { 0.02 };
        w.use_narrow_camera();
        assert_near(w.middle(), [expected.x, expected.y, expected.z, 1.0], tolerance);
    }
}

#[test]
fn phong_expresses_whitted_materials() {
    // NFF's `f 1 0.5 0.25 0.6 0.3 … T 0.2`: mirror and refracted images beside diffuse light.
    let mut w = World::new(1);
    w.use_compass();
    let material = [
        ("diffuse", rgb(0.6, 0.3, 0.15)),
        ("specular", grey(0.0)),
        ("reflection", rgb(0.3, 0.2, 0.1)),
        ("transmission", grey(0.2)),
        ("emission", rgb(0.01, 0.02, 0.03)),
        ("ambient", rgb(0.1, 0.2, 0.3)),
    ];
    let phong = w.shader("phong", &material);
    w.add(wall(-2.0, phong));
    w.light("point", &[]);
    w.light("ambient", &[("color", grey(0.5))]);
    let expected = Vec3::new(0.6, 0.3, 0.15)
        + Vec3::new(0.3, 0.2, 0.1) * compass(Vec3::Z)
        + 0.2 * compass(Vec3::NEG_Z)
        + Vec3::new(0.01, 0.02, 0.03)
        + 0.5 * Vec3::new(0.1, 0.2, 0.3);
    assert_near(w.middle(), [expected.x, expected.y, expected.z, 1.0], 1e-5);
    // The highlight: the light at the eye is met head on.
    let shiny = w.shader("phong", &[("diffuse", grey(0.0)), ("specular", grey(0.7)), ("shininess", float(50.0))]);
    w.frame.instances.clear();
    w.add(wall(-2.0, shiny));
    w.frame.lights.pop();
    assert_near(w.middle(), [0.7, 0.7, 0.7, 1.0], 1e-4);
}

#[test]
fn mirrors_that_face_each_other_end() {
    let mut w = World::new(8);
    let mirror = w.shader("mirror", &[]);
    w.add(wall(-2.0, mirror));
    w.add(quad(Vec3::new(0.0, 0.0, 2.0), Vec3::X * 20.0, Vec3::NEG_Y * 20.0, mirror));
    w.use_narrow_camera();
    for depth in [0, 5, u32::MAX] {
        w.frame.max_depth = depth;
        let mut renderer = Renderer::new(Level::detect());
        let stats = renderer.render(&w.scene, &w.frame, None, &AtomicBool::new(false)).unwrap();
        assert_eq!(stats.secondary_rays, 64 * u64::from(depth.min(64)));
    }
    // Glass on both sides doubles the rays at every level: the budget ends it.
    let both = w.shader("phong", &[("reflection", grey(1.0)), ("transmission", grey(1.0)), ("diffuse", grey(0.0))]);
    w.frame.instances.clear();
    w.add(sphere(Vec3::ZERO, 3.0, 8, both));
    w.add(sphere(Vec3::ZERO, 2.0, 8, both));
    let mut renderer = Renderer::new(Level::detect());
    let stats = renderer.render(&w.scene, &w.frame, None, &AtomicBool::new(false)).unwrap();
    assert!(stats.secondary_rays <= 64 << 14);
}
