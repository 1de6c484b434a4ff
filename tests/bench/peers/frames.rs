//! `-- frames`: whether the speed of batches is seen in whole frames.
//!
//! Frames of the renderer at 640×480, from the update of the structures to the last pixel, by `raycast` (primary rays) and by `whitted`
//! with one point light (and a shadow ray for each point that faces it). Beside them stands the time that the same numbers of rays
//! take as batches, in our best mode, measured in the same rounds; the ratio is that time over the frame's. The hash is of all pixels:
//! it must not depend on how rays are traced.

use crate::embree::Embree;
use crate::lanes::our_lanes;
use crate::measure::{Cost, race};
use crate::options::Options;
use crate::ours::Ours;
use crate::rays::{self, Kind};
use crate::scenes::{self, BenchScene};
use glam::{Affine3A, Vec3};
use openrt::frame::Framebuffer;
use openrt::render::{Renderer, builtin_classes};
use openrt::scene::{Command, FrameDesc, LightUse, Name, ParamValue, Scene, Viewport};
use openrt::simd::Level;
use openrt::threads::Pool;
use std::sync::atomic::AtomicBool;

const ROUNDS: usize = 15;
const QUICK_ROUNDS: usize = 5;
const SCENES: [&str; 2] = ["S2", "S6"];

pub fn run(options: &Options, _: Option<&Embree>) -> String {
    println!("whole frames, {} thread(s), best of the rounds", options.threads);
    println!(
        "{:3} {:>9} {:10}| {:>9} {:>9} {:>9} {:>9} {:>8} {:>8} | {:>6}",
        "", "", "renderer", "primary", "shadow", "frame ms", "batch ms", "Mrays/s", "batch", "ratio"
    );
    let mut json = Vec::new();
    let mut worst: Option<(f64, String)> = None;
    for (name, make) in scenes::ALL {
        if SCENES.contains(&name) && options.wants_scene(name) {
            one_scene(&make(), options, &mut json, &mut worst);
        }
    }
    if let Some((ratio, what)) = worst {
        println!("worst ratio {ratio:.2} ({what})");
    }
    format!("[\n{}\n]\n", json.join(",\n"))
}

fn one_scene(bench: &BenchScene, options: &Options, json: &mut Vec<String>, worst: &mut Option<(f64, String)>) {
    let size = bench.sizes[0];
    let pool = Pool::new(Some(options.threads)).expect("worker threads start");
    let mut ours = Ours::new(bench, 0, &pool);
    let frames = ["raycast", "whitted"].map(|class| describe(&mut ours.scene, bench, class, &ours.instances));
    let primary = rays::primary(&bench.view, size);
    let offset = 1e-4 * bench.view.eye.distance(bench.view.at);
    let (shadow, _) = rays::secondary(&ours, &primary, bench.light, offset);
    let mut primary_lanes = our_lanes(ours.tracer(), Kind::Primary);
    let mut shadow_lanes = our_lanes(ours.tracer(), Kind::Shadow);
    let mut renderers = [Renderer::new(Level::detect()), Renderer::new(Level::detect())];
    let mut best = [f64::INFINITY; 2];
    let mut counts = [[0u64; 2]; 2];
    for _ in 0..if options.quick { QUICK_ROUNDS } else { ROUNDS } {
        race(&mut primary_lanes, &primary, options.threads, 1);
        race(&mut shadow_lanes, &shadow, options.threads, 1);
        for (i, (renderer, frame)) in renderers.iter_mut().zip(&frames).enumerate() {
            let render = || Cost::of(|| renderer.render(&ours.scene, frame, None, &AtomicBool::new(false)));
            let (cost, stats) = pool.install(render);
            let stats = stats.expect("memory for a small frame");
            best[i] = best[i].min(if options.threads == 1 { cost.busiest } else { cost.wall });
            counts[i] = [stats.primary_rays, stats.shadow_rays];
        }
    }
    let per_ray = |lanes: &[crate::measure::Lane], rays: usize| {
        lanes.iter().map(|lane| lane.seconds).fold(f64::INFINITY, f64::min) / rays as f64
    };
    let costs = [per_ray(&primary_lanes, primary.len()), per_ray(&shadow_lanes, shadow.len())];
    for (i, class) in ["raycast", "whitted"].into_iter().enumerate() {
        let batch: f64 = counts[i].iter().zip(costs).map(|(&rays, cost)| rays as f64 * cost).sum();
        let rays = counts[i].iter().sum::<u64>() as f64;
        let ratio = batch / best[i];
        println!(
            "{:3} {:>9} {class:10}| {:>9} {:>9} {:>9.2} {:>9.2} {:>8.2} {:>8.2} | {ratio:>6.2}   picture {:016x}",
            bench.name,
            format!("{}x{}", size[0], size[1]),
            counts[i][0],
            counts[i][1],
            best[i] * 1e3,
            batch * 1e3,
            rays / best[i] * 1e-6,
            rays / batch * 1e-6,
            hash(renderers[i].framebuffer())
        );
        json.push(format!(
            r#"  {{"scene": "{}", "renderer": "{class}", "rays": {rays}, "frame_ms": {:.4}, "batch_ms": {:.4}}}"#,
            bench.name,
            best[i] * 1e3,
            batch * 1e3
        ));
        if worst.as_ref().is_none_or(|(w, _)| ratio < *w) {
            *worst = Some((ratio, format!("{}, {class}", bench.name)));
        }
    }
}

/// The frame that shows the scene as the batches do.
fn describe(scene: &mut Scene, bench: &BenchScene, class: &str, instances: &[openrt::scene::Instance]) -> FrameDesc {
    let float = |x: f32| ParamValue::Float([x, 0.0, 0.0, 0.0]);
    let vec3 = |v: Vec3| ParamValue::Float([v.x, v.y, v.z, 0.0]);
    let view = &bench.view;
    let camera = [("eye", vec3(view.eye)), ("center", vec3(view.at)), ("fov", float(view.degrees))];
    let camera = shader(scene, "pinhole", &camera);
    let light = shader(scene, "point", &[("position", vec3(bench.light))]);
    let renderer = shader(scene, class, &[]);
    let [width, height] = bench.sizes[0];
    FrameDesc {
        instances: instances.to_vec(),
        lights: vec![LightUse::new(light, Affine3A::IDENTITY)],
        camera,
        renderer,
        size: [width, height],
        viewport: Viewport { x: 0, y: 0, width, height },
        ..FrameDesc::default()
    }
}

/// A shader of a built-in class.
fn shader(scene: &mut Scene, class: &str, values: &[(&str, ParamValue)]) -> Name {
    let definition = builtin_classes().into_iter().find(|c| &*c.name == class).expect("a built-in class");
    let name = scene.shaders.len() as Name + 1;
    scene.apply(Command::DefineClass { name, class: definition.clone() });
    scene.apply(Command::DefineShader { name, class: name });
    for (parameter, value) in values {
        let param = definition.param_index(parameter).expect("a parameter of the class");
        scene.apply(Command::SetParameter { shader: name, param, value: value.clone() });
    }
    name
}

/// FNV-1a over colours, depths, normals and numbers.
fn hash(picture: &Framebuffer) -> u64 {
    let pixels = (0..picture.height()).flat_map(|y| picture.row(y));
    let words = pixels.flat_map(|p| {
        let [r, g, b, a] = p.color.map(f32::to_bits);
        let [x, y, z] = p.normal.map(f32::to_bits);
        [r, g, b, a, p.depth.to_bits(), x, y, z, p.object, p.instance]
    });
    words.fold(0xcbf2_9ce4_8422_2325, |h, word| (h ^ u64::from(word)).wrapping_mul(0x0000_0100_0000_01b3))
}
