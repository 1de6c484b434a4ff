//! What converges, converges to the right answer.

use crate::kit::*;
use glam::{Vec3, Vec4};
use openrt::render::Renderer;
use openrt::scene::*;
use openrt::simd::Level;
use std::sync::atomic::AtomicBool;

/// Mean and standard error of a set of values.
fn statistics(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

#[track_caller]
fn assert_mean(values: &[f64], expected: f64) {
    let (mean, error) = statistics(values);
    assert!((mean - expected).abs() <= 3.0 * error + 1e-5, "{mean} ± {error} is not {expected}");
}

fn reds(picture: &[Vec4]) -> Vec<f64> {
    picture.iter().map(|c| f64::from(c.x)).collect()
}

#[test]
fn white_furnace_everything_that_keeps_energy_vanishes() {
    let materials: &[(&str, &[(&str, ParamValue)])] = &[
        ("diffuse", &[("color", grey(1.0))]),
        ("mirror", &[]),
        ("glass", &[]),
        ("metal", &[("color", grey(1.0))]),
        ("metal", &[("color", grey(1.0)), ("roughness", float(0.5))]),
        (
            "phong",
            &[("diffuse", grey(0.5)), ("reflection", grey(0.25)), ("transmission", grey(0.25)), ("ior", float(1.3))],
        ),
    ];
    for (class, values) in materials {
        let mut w = World::new(16);
        w.frame.clear_color = [1.0; 4];
        w.frame.samples = 4;
        w.frame.renderer = w.shader("path", &[("max_depth", int(1000)), ("roulette_depth", int(1000))]);
        let material = w.shader(class, values);
        w.add(sphere(Vec3::new(0.0, 0.0, -2.5), 1.0, 24, material));
        for color in w.render() {
            assert_near(color, [1.0; 4], 1e-4);
        }
    }
}

#[test]
fn closed_furnace_has_the_sum_of_all_bounces() {
    // Inside a closed grey lamp: L = e + a·L, so L = e / (1 − a), whatever the shape.
    for roulette in [0, 4] {
        let mut w = World::new(16);
        w.frame.samples = 16;
        w.frame.renderer = w.shader("path", &[("max_depth", int(1000)), ("roulette_depth", int(roulette))]);
        let wall = w.shader("phong", &[("diffuse", grey(0.5)), ("emission", grey(0.25)), ("reflection", grey(0.25))]);
        w.add(sphere(Vec3::ZERO, 3.0, 16, wall));
        assert_mean(&reds(&w.render()), 0.25 / (1.0 - 0.75));
    }
}

#[test]
fn path_agrees_with_whitted_where_nothing_bounces() {
    let mut w = World::new(8);
    let white = w.shader("diffuse", &[("color", grey(0.7))]);
    w.add(wall(-2.0, white));
    w.light("point", &[("position", rgb(0.5, 0.7, -0.5)), ("attenuation", rgb(0.0, 0.0, 1.0))]);
    let whitted = w.render();
    w.frame.renderer = w.shader("path", &[]);
    for (a, b) in whitted.iter().zip(w.render()) {
        assert!((*a - b).abs().max_element() < 1e-6);
    }
}

#[test]
fn frames_accumulate_until_something_changes() {
    let mut w = World::new(8);
    w.frame.clear_color = [1.0; 4];
    w.frame.accumulate = true;
    w.frame.renderer = w.shader("path", &[]);
    let grey_wall = w.shader("diffuse", &[("color", grey(0.5))]);
    // A corner: bounces make noise.
    w.add(quad(Vec3::new(0.0, -0.5, -2.0), Vec3::X * 4.0, Vec3::NEG_Z * 4.0, grey_wall));
    w.add(quad(Vec3::new(0.0, 0.0, -3.0), Vec3::X * 4.0, Vec3::Y * 4.0, grey_wall));
    let mut renderer = Renderer::new(Level::detect());
    let never = AtomicBool::new(false);
    let mut noise = Vec::new();
    let mut reference = World { scene: Scene::default(), frame: w.frame.clone(), next: 0 };
    std::mem::swap(&mut reference.scene, &mut w.scene);
    reference.frame.accumulate = false;
    reference.frame.samples = 4096;
    let truth = reference.render();
    w.scene = reference.scene;
    for round in 1..=64 {
        renderer.render(&w.scene, &w.frame, None, &never).unwrap();
        if [1, 16, 64].contains(&round) {
            let picture = colors(&renderer);
            let square: f32 = picture.iter().zip(&truth).map(|(a, b)| (a.x - b.x).powi(2)).sum();
            noise.push((square / 64.0).sqrt());
        }
    }
    assert!(noise[1] < 0.4 * noise[0] && noise[2] < 0.7 * noise[1], "{noise:?}");
    // Any change starts anew: the same picture as a fresh renderer's first.
    w.frame.clear_color = [0.5; 4];
    renderer.render(&w.scene, &w.frame, None, &never).unwrap();
    assert_eq!(colors(&renderer), w.render());
    w.scene.epoch += 1;
    renderer.render(&w.scene, &w.frame, None, &never).unwrap();
    assert_eq!(colors(&renderer), w.render());
}

#[test]
fn ambient_occlusion_of_a_plane_and_of_a_corner() {
    let mut w = World::new(16);
    w.frame.renderer = w.shader("ambient_occlusion", &[("samples", int(64))]);
    w.add(wall(-2.0, 0));
    for color in w.render() {
        assert_near(color, [1.0; 4], 0.0);
    }
    // Beside a perpendicular half space, half of the cosine-weighted hemisphere is hidden, at any distance from it.
    w.frame.instances.clear();
    w.add(quad(Vec3::new(0.0, 0.0, -2.0), Vec3::X * 1000.0, Vec3::Y * 1000.0, 0));
    for color in w.render() {
        assert_near(color, [1.0; 4], 0.0);
    }
    w.add(quad(Vec3::new(2.0, 0.0, 500.0 - 2.0), Vec3::Z * 1000.0, Vec3::Y * 1000.0, 0));
    let (mean, error) = statistics(&reds(&w.render()));
    // The wall ends after 500 to 1000 units, seen from at most 3.2 units away: up to 0.3 % escape.
    assert!(mean > 0.5 - 3.0 * error && mean < 0.503 + 3.0 * error, "{mean} ± {error}");
    w.frame.renderer = w.shader("ambient_occlusion", &[("distance", float(0.1))]);
    assert_near(w.middle(), [1.0; 4], 0.0);
}

#[test]
fn half_of_an_area_light_gives_half_of_its_light() {
    for shape in ["rectangle", "disc", "sphere"] {
        let mut w = World::new(1);
        let white = w.shader("diffuse", &[("color", grey(1.0))]);
        w.add(wall(-2.0, white));
        // Far away beside the eye, shining along −z.
        w.light(
            "area",
            &[
                ("shape", ParamValue::String(shape.into())),
                ("position", rgb(0.0, 0.0, 98.0)),
                ("edge_u", rgb(0.0, 1.0, 0.0)),
                ("edge_v", rgb(1.0, 0.0, 0.0)),
                ("samples", int(1024)),
            ],
        );
        assert_near(w.middle(), [1.0; 4], 1e-3);
        // A half plane whose edge is the line from the point to the light's centre.
        w.add(quad(Vec3::new(500.0, 0.0, 10.0), Vec3::X * 1000.0, Vec3::Y * 1000.0, 0));
        let full = w.middle().x;
        assert!((full - 0.5).abs() < 0.01, "{shape}: {full}");
        // With few samples and random ones the mean is the same.
        w.frame.renderer = w.shader("path", &[("max_depth", int(0))]);
        w.frame.samples = 4096;
        assert!((w.middle().x - 0.5).abs() < 0.03);
    }
}
