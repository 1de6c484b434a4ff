//! Pictures from fewer rays, through the public Rust API: sub-sampling, frameless rendering, time budgets, progressive refinement. The
//! oracle is the picture of all rays. What a clock decides is tested with a clock of its own in `src/render/budget_tests.rs`.

use glam::{DVec3, Vec3};
use openrt::Context;
use openrt::api::*;
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// Of the picture and of the part that is rendered; no multiple of anything.
const SIZE: [u32; 2] = [107, 83];
const VIEWPORT: [u32; 4] = [5, 3, 97, 71];

fn shader(cx: &mut Context, class: &str, values: &[(&str, &[f32])]) -> Name {
    cx.gen_new_shader_class(class).unwrap();
    let name = cx.gen_new_shader().unwrap();
    for (parameter, value) in values {
        let handle = cx.parameter_handle(parameter).unwrap();
        cx.parameter_f(handle, value).unwrap();
    }
    name
}

fn ball(cx: &mut Context, object: Name) {
    let (slices, stacks) = (16, 8);
    cx.new_object(object, Mode::Compile, Motion::Affine).unwrap();
    for stack in 0..stacks {
        cx.begin(Primitive::QuadStrip).unwrap();
        for slice in 0..=slices {
            for edge in [stack + 1, stack] {
                let up = std::f32::consts::PI * (edge as f32 / stacks as f32 - 0.5);
                let turn = std::f32::consts::TAU * (slice % slices) as f32 / slices as f32;
                let p = Vec3::new(up.cos() * turn.cos(), up.sin(), -up.cos() * turn.sin());
                cx.normal(p).unwrap();
                cx.vertex3(p.x, p.y, p.z).unwrap();
            }
        }
        cx.end().unwrap();
    }
    cx.end_object().unwrap();
}

/// What a test looks at.
struct World {
    cx: Context,
    objects: Name,
}

impl World {
    /// Two balls, one of them a mirror, over a floor, under a large lamp; seen by `camera` and rendered by `renderer`.
    fn new(threads: usize, renderer: &str, camera: &str) -> Self {
        let mut cx = Context::with_config(Config::with_threads(threads)).unwrap();
        cx.set_frame_size(SIZE[0], SIZE[1]).unwrap();
        let [x, y, width, height] = VIEWPORT.map(|n| n as i32);
        cx.viewport(x, y, width, height).unwrap();
        cx.clear_color([0.2, 0.3, 0.5, 1.0]).unwrap();
        let light = shader(
            &mut cx,
            "area",
            &[("position", &[-1.0, 5.0, -2.0]), ("edge_u", &[2.0, 0.0, 0.0]), ("edge_v", &[0.0, 0.0, 2.0])],
        );
        cx.use_light(light).unwrap();
        let objects = cx.gen_objects(3).unwrap();
        shader(&mut cx, "phong", &[("diffuse", &[0.8, 0.3, 0.2]), ("specular", &[0.4, 0.4, 0.4])]);
        ball(&mut cx, objects);
        shader(&mut cx, "mirror", &[("color", &[0.9, 0.9, 0.8])]);
        ball(&mut cx, objects + 1);
        shader(&mut cx, "diffuse", &[("color", &[0.5, 0.7, 0.4])]);
        cx.new_object(objects + 2, Mode::Compile, Motion::Affine).unwrap();
        cx.begin(Primitive::Quads).unwrap();
        for (x, z) in [(-9.0, 9.0), (9.0, 9.0), (9.0, -9.0), (-9.0, -9.0)] {
            cx.vertex3(x, -1.0, z).unwrap();
        }
        cx.end().unwrap();
        cx.end_object().unwrap();
        let camera = shader(&mut cx, camera, &[("eye", &[0.3, 1.2, 4.0]), ("center", &[0.0, -0.2, 0.0])]);
        cx.use_camera(camera).unwrap();
        cx.gen_new_shader_class(renderer).unwrap();
        let renderer = cx.gen_new_shader().unwrap();
        cx.use_rendering_object(renderer).unwrap();
        Self { cx, objects }
    }

    /// Renders the scene, with the balls moved aside by `aside`.
    fn frame(&mut self, aside: f64) -> FrameStats {
        for (object, x) in [(0, aside - 1.1), (1, 1.1)] {
            self.cx.push_matrix().unwrap();
            self.cx.translate(DVec3::new(x, 0.0, 0.0)).unwrap();
            self.cx.instantiate_object(self.objects + object).unwrap();
            self.cx.pop_matrix().unwrap();
        }
        self.cx.instantiate_object(self.objects + 2).unwrap();
        self.cx.render().unwrap()
    }

    fn set(&mut self, parameter: FrameParameter) {
        self.cx.frame_parameter(parameter).unwrap();
    }

    fn read(&mut self, kind: PixelKind) -> Vec<u8> {
        let mut bytes = vec![0u8; (SIZE[0] * SIZE[1]) as usize * kind.bytes_per_pixel()];
        self.cx.read_pixels(0, 0, SIZE[0], SIZE[1], kind, 0, &mut bytes).unwrap();
        bytes
    }

    fn colors(&mut self) -> Vec<[f32; 4]> {
        let bytes = self.read(PixelKind::Color(PixelFormat::Rgba32F));
        let float = |b: &[u8]| f32::from_ne_bytes(b.try_into().unwrap());
        bytes.chunks(16).map(|p| std::array::from_fn(|k| float(&p[4 * k..4 * k + 4]))).collect()
    }

    /// All that can be read of the picture.
    fn picture(&mut self) -> Vec<u8> {
        let kinds = [
            PixelKind::Color(PixelFormat::Rgba32F),
            PixelKind::Depth,
            PixelKind::Normal,
            PixelKind::ObjectId,
            PixelKind::InstanceId,
        ];
        kinds.into_iter().flat_map(|kind| self.read(kind)).collect()
    }
}

fn index(x: u32, y: u32) -> usize {
    (y * SIZE[0] + x) as usize
}

/// The nodes below and above `at`, of those at multiples of `step` and at the end.
fn around(at: u32, step: u32, end: u32) -> [u32; 2] {
    let nodes = (0..end).filter(|&x| x % step == 0 || x + 1 == end);
    [nodes.clone().rfind(|&x| x <= at).unwrap(), nodes.clone().find(|&x| x >= at).unwrap()]
}

const RENDERERS: [&str; 4] = ["whitted", "raycast", "ambient_occlusion", "path"];

#[test]
fn sampled_pixels_are_those_of_the_whole_picture_and_the_others_lie_between() {
    for renderer in RENDERERS {
        for camera in ["pinhole", "thinlens", "environment"] {
            let mut world = World::new(2, renderer, camera);
            let [x0, y0, width, height] = VIEWPORT;
            let rays = world.frame(0.0).primary_rays;
            assert_eq!(rays, u64::from(width * height));
            let full = world.colors();
            let whole = world.picture();
            for (step, scheme) in [(5, Upsampling::Bilinear), (10, Upsampling::Midpoint), (500, Upsampling::Bilinear)] {
                let at = format!("{renderer}, {camera}, {step}");
                world.set(FrameParameter::Subsampling(step as i32));
                world.set(FrameParameter::Upsampling(scheme));
                let nodes = |pixels: u32| (0..pixels).filter(|&x| x % step == 0 || x + 1 == pixels).count() as u64;
                assert_eq!(world.frame(0.0).primary_rays, nodes(width) * nodes(height), "{at}");
                let scaled = world.colors();
                let mut changed = 0;
                for y in 0..height {
                    for x in 0..width {
                        let (xs, ys) = (around(x, step, width), around(y, step, height));
                        let place = index(x0 + x, y0 + y);
                        if xs[0] == xs[1] && ys[0] == ys[1] {
                            assert_eq!(scaled[place].map(f32::to_bits), full[place].map(f32::to_bits), "{at}: {x} {y}");
                        }
                        let corners = xs.map(|x| ys.map(|y| full[index(x0 + x, y0 + y)]));
                        for (k, color) in scaled[place].into_iter().enumerate() {
                            let all = corners.as_flattened().iter().map(|c| c[k]);
                            let least = all.clone().fold(f32::INFINITY, f32::min);
                            let most = all.fold(f32::NEG_INFINITY, f32::max);
                            assert!(least - 1e-5 <= color && color <= most + 1e-5, "{at}: {x} {y} {color}");
                        }
                        changed += u32::from(scaled[place] != full[place]);
                    }
                }
                assert!(changed > width * height / 4, "{at}: {changed} pixels were interpolated");
            }
            world.set(FrameParameter::Subsampling(1));
            world.frame(0.0);
            assert!(world.picture() == whole, "{renderer}, {camera}: without sub-sampling again");
        }
    }
}

struct Image(Mutex<Vec<u8>>);

impl PixelSink for Image {
    fn write(&self, offset: usize, bytes: &[u8]) {
        self.0.lock().unwrap()[offset..offset + bytes.len()].copy_from_slice(bytes);
    }
}

#[test]
fn a_sub_sampled_picture_is_the_same_for_any_threads_and_reaches_the_application() {
    let pictures = [1, 2].map(|threads| {
        let mut world = World::new(threads, "whitted", "pinhole");
        world.set(FrameParameter::Subsampling(7));
        world.cx.samples_per_pixel(4).unwrap();
        let image = Arc::new(Image(Mutex::new(vec![9; (SIZE[0] * SIZE[1] * 4) as usize])));
        let [width, height] = SIZE;
        let layout = TargetLayout {
            width,
            height,
            format: PixelFormat::Rgba8,
            stride: 4 * width as usize,
            origin_top_left: false,
        };
        world.cx.set_frame_buffer(Some(Target { layout, sink: image.clone() })).unwrap();
        world.frame(0.0);
        let [x0, y0, w, h] = VIEWPORT;
        let (read, shown) = (world.read(PixelKind::Color(PixelFormat::Rgba8)), image.0.lock().unwrap().clone());
        for y in 0..height {
            for x in 0..width {
                let at = 4 * index(x, y)..4 * index(x, y) + 4;
                if x0 <= x && x < x0 + w && y0 <= y && y < y0 + h {
                    assert_eq!(shown[at.clone()], read[at], "{x} {y}");
                } else {
                    assert_eq!(shown[at], [9; 4], "{x} {y} is outside of the viewport");
                }
            }
        }
        world.picture()
    });
    assert!(pictures[0] == pictures[1]);
}

#[test]
fn frames_that_accumulate_do_so_in_the_nodes() {
    let mut world = World::new(2, "path", "pinhole");
    world.cx.enable(Capability::Accumulate).unwrap();
    (0..3).for_each(|_| _ = world.frame(0.0));
    let full = world.colors();
    world.set(FrameParameter::Subsampling(5));
    (0..3).for_each(|_| _ = world.frame(0.0));
    let scaled = world.colors();
    let [x0, y0, width, height] = VIEWPORT;
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let place = index(x0 + x, y0 + y);
        let node = |at: u32, end: u32| at.is_multiple_of(5) || at + 1 == end;
        assert!(scaled[place] == full[place] || !node(x, width) || !node(y, height), "{x} {y}");
    }
}

#[test]
fn frameless_frames_visit_every_pixel_once_per_cycle() {
    for (cycle, subsampling) in [(10, 1), (7, 1), (64, 1), (3, 2)] {
        let mut world = World::new(2, "whitted", "pinhole");
        world.set(FrameParameter::Subsampling(subsampling));
        // An empty scene whose clear colour tells the number of the frame that rendered a pixel.
        let frame = |world: &mut World, number: u32| {
            world.cx.clear_color([number as f32, 0.0, 0.0, 1.0]).unwrap();
            world.cx.render().unwrap().primary_rays
        };
        world.set(FrameParameter::Frameless(cycle));
        let all = frame(&mut world, 0);
        assert_eq!(subsampling == 1, all == u64::from(VIEWPORT[2] * VIEWPORT[3]), "the first frame is complete");
        let mut ages = Vec::new();
        for number in 1..=2 * cycle as u32 {
            let rays = frame(&mut world, number);
            let share = all as f64 / f64::from(cycle);
            assert!((rays as f64) > 0.5 * share && (rays as f64) < 1.6 * share, "{rays} rays in a frame of {share}");
            if number % cycle as u32 == 0 {
                ages.push(world.colors().iter().map(|c| c[0]).collect::<Vec<_>>());
            }
        }
        if subsampling == 1 {
            for (i, (first, second)) in ages[0].iter().zip(&ages[1]).enumerate() {
                let [x, y] = [i as u32 % SIZE[0], i as u32 / SIZE[0]];
                let visible = x >= VIEWPORT[0]
                    && x < VIEWPORT[0] + VIEWPORT[2]
                    && y >= VIEWPORT[1]
                    && y < VIEWPORT[1] + VIEWPORT[3];
                let expected = if visible { first + cycle as f32 } else { 0.0 };
                assert_eq!(*second, expected, "pixel {x} {y}");
                assert_eq!(visible, (1.0..=cycle as f32).contains(first), "pixel {x} {y}");
            }
        }
    }
}

#[test]
fn a_static_cycle_of_frameless_frames_is_the_whole_picture() {
    for (renderer, subsampling) in [("whitted", 1), ("path", 1), ("ambient_occlusion", 5)] {
        let mut reference = World::new(2, renderer, "thinlens");
        reference.set(FrameParameter::Subsampling(subsampling));
        reference.frame(0.4);
        let whole = reference.picture();
        let cycles = [1, 2].map(|threads| {
            let mut world = World::new(threads, renderer, "thinlens");
            world.set(FrameParameter::Subsampling(subsampling));
            world.frame(0.0);
            world.set(FrameParameter::Frameless(6));
            (0..6)
                .map(|number| {
                    assert!(world.picture() != whole, "{renderer}: before frame {number}");
                    world.frame(0.4);
                    world.picture()
                })
                .collect::<Vec<_>>()
        });
        assert!(cycles[0] == cycles[1], "{renderer}: the same for any threads");
        assert!(cycles[0].last() == Some(&whole), "{renderer}: a cycle is the whole picture");
    }
}

#[test]
fn frameless_frames_fill_each_of_two_buffers_of_the_application() {
    let mut world = World::new(2, "whitted", "pinhole");
    world.set(FrameParameter::Frameless(5));
    let [width, height] = SIZE;
    for number in 0..4 {
        let image = Arc::new(Image(Mutex::new(vec![0; (width * height * 4) as usize])));
        let layout = TargetLayout {
            width,
            height,
            format: PixelFormat::Rgba8,
            stride: 4 * width as usize,
            origin_top_left: false,
        };
        world.cx.set_frame_buffer(Some(Target { layout, sink: image.clone() })).unwrap();
        world.frame(0.1 * f64::from(number));
        let [x0, y0, w, h] = VIEWPORT;
        let (read, shown) = (world.read(PixelKind::Color(PixelFormat::Rgba8)), image.0.lock().unwrap().clone());
        for (x, y) in (y0..y0 + h).flat_map(|y| (x0..x0 + w).map(move |x| (x, y))) {
            let at = 4 * index(x, y)..4 * index(x, y) + 4;
            assert_eq!(shown[at.clone()], read[at], "{x} {y}");
        }
    }
}

#[test]
fn no_time_shows_primary_rays_and_endless_time_the_whole_picture() {
    for renderer in RENDERERS {
        let mut world = World::new(2, renderer, "pinhole");
        world.cx.samples_per_pixel(2).unwrap();
        let stats = world.frame(0.2);
        assert_eq!((stats.refined, stats.subsampling), (1.0, 1));
        let whole = world.picture();
        world.set(FrameParameter::TimeBudget(Some(Duration::MAX)));
        assert_eq!(world.frame(0.2).refined, 1.0);
        assert!(world.picture() == whole, "{renderer}: endless");
        world.set(FrameParameter::TimeBudget(Some(Duration::ZERO)));
        let stats = world.frame(0.2);
        assert_eq!((stats.refined, stats.shadow_rays, stats.secondary_rays), (0.0, 0, 0), "{renderer}");
        let mut primary = World::new(2, "raycast", "pinhole");
        primary.frame(0.2);
        assert!(world.picture() == primary.picture(), "{renderer}: no time");
    }
}

#[test]
fn progressive_frames_sample_smaller_blocks_and_then_average() {
    for renderer in ["whitted", "path"] {
        let mut reference = World::new(1, renderer, "pinhole");
        reference.cx.enable(Capability::Accumulate).unwrap();
        let averaged = [0, 1].map(|_| {
            reference.frame(0.3);
            reference.picture()
        });
        let pictures = [1, 2].map(|threads| {
            let mut world = World::new(threads, renderer, "pinhole");
            world.cx.enable(Capability::Progressive).unwrap();
            world.set(FrameParameter::Subsampling(10));
            let mut frames = |aside, n| -> Vec<(u32, Vec<u8>)> {
                (0..n).map(|_| (world.frame(aside).subsampling, world.picture())).collect()
            };
            assert_eq!(frames(0.0, 3).iter().map(|f| f.0).collect::<Vec<_>>(), [10, 5, 2]);
            frames(0.3, 5)
        });
        assert!(pictures[0] == pictures[1], "{renderer}: the same for any threads");
        let steps: Vec<u32> = pictures[0].iter().map(|f| f.0).collect();
        assert_eq!(steps, [10, 5, 2, 1, 1], "a change begins anew");
        assert!(pictures[0][3].1 == averaged[0] && pictures[0][4].1 == averaged[1], "{renderer}");
        assert!(averaged[0] != averaged[1]);
    }
}
