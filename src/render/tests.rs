//! Samples shaded together against samples shaded one by one: the same bits of all that a pixel gets, and the same rays.

use crate::accel::TwoLevel;
use crate::scene::*;
use crate::shade::*;
use crate::simd::Level;
use crate::trace::{RayPacket, Tracer};
use glam::{Affine3A, Quat, Vec2, Vec3, Vec4};
use std::sync::Arc;

const SIZE: u32 = 40;

pub(super) struct World {
    pub scene: Scene,
    pub frame: FrameDesc,
    next: Name,
}

fn float(x: f32) -> ParamValue {
    ParamValue::Float([x, 0.0, 0.0, 0.0])
}

pub(super) fn vec3(x: f32, y: f32, z: f32) -> ParamValue {
    ParamValue::Float([x, y, z, 0.0])
}

impl World {
    fn new() -> Self {
        let mut scene = Scene::default();
        for (name, class) in (1..).zip(builtin_classes()) {
            scene.apply(Command::DefineClass { name, class });
        }
        let viewport = Viewport { x: 0, y: 0, width: SIZE, height: SIZE };
        let frame =
            FrameDesc { size: [SIZE, SIZE], viewport, clear_color: [0.1, 0.2, 0.3, 0.4], ..FrameDesc::default() };
        Self { scene, frame, next: 100 }
    }

    pub fn shader(&mut self, class: &str, values: &[(&str, ParamValue)]) -> Name {
        self.next += 1;
        let (&class_name, class) = self.scene.classes.iter().find(|(_, c)| &*c.name == class).expect("built in");
        let class = class.clone();
        self.scene.apply(Command::DefineShader { name: self.next, class: class_name });
        for (param, value) in values {
            let param = class.param_index(param).expect("a parameter of the class");
            self.scene.apply(Command::SetParameter { shader: self.next, param, value: value.clone() });
        }
        self.next
    }

    fn texture(&mut self) -> ParamValue {
        self.next += 1;
        let texels = vec![[40, 40, 60, 255], [255; 4], [255, 90, 10, 40], [30, 200, 90, 200]];
        let level = TextureLevel { width: 2, height: 2, texels };
        let texture = Texture { levels: vec![level], filter: Filter::LinearMipmapLinear, ..Texture::default() };
        self.scene.apply(Command::DefineTexture { name: self.next, texture: Arc::new(texture) });
        ParamValue::Texture(self.next)
    }

    fn add(&mut self, mesh: Mesh, world_from_object: Affine3A) {
        self.next += 1;
        self.scene.apply(Command::DefineObject { name: self.next, mesh, motion: Motion::Affine });
        self.frame.instances.push(Instance::new(self.next, world_from_object));
    }
}

/// Attributes that a mesh may have.
#[derive(Clone, Copy, PartialEq)]
enum With {
    Nothing,
    Normals,
    /// Some of them 0, NaN or turned inside.
    BadNormals,
    Everything,
}

/// A ball around the origin; its triangles have the shaders in turn.
fn ball(with: With, shaders: &[Name]) -> Mesh {
    let (n, mut mesh) = (9u32, Mesh::default());
    for i in 0..=n {
        for j in 0..2 * n {
            let (theta, phi) = (std::f32::consts::PI * i as f32 / n as f32, std::f32::consts::PI * j as f32 / n as f32);
            let p = Vec3::new(theta.sin() * phi.cos(), theta.cos(), -theta.sin() * phi.sin());
            mesh.positions.push(p);
            if with != With::Nothing {
                mesh.normals.push(match (with, (i + 3 * j) % 11) {
                    (With::BadNormals, 0) => Vec3::ZERO,
                    (With::BadNormals, 1) => Vec3::NAN,
                    (With::BadNormals, 2) => -p,
                    _ => p * (1.0 + j as f32),
                });
            }
            if with == With::Everything {
                mesh.tex_coords.push(Vec2::new(j as f32, i as f32) * 0.3);
                mesh.colors.push(Vec4::new(0.5 + 0.5 * p.x, 0.9, 0.7 - 0.2 * p.y, 0.8));
            }
        }
    }
    for i in 0..n {
        for j in 0..2 * n {
            let [a, b] = [i * 2 * n + j, i * 2 * n + (j + 1) % (2 * n)];
            mesh.triangles.extend([[a, a + 2 * n, b + 2 * n], [a, b + 2 * n, b]]);
        }
    }
    mesh.shader_of_triangle = shaders.iter().copied().cycle().take(mesh.triangles.len()).collect();
    mesh
}

/// Balls of many kinds in a row of rows, over a floor without any attribute.
pub(super) fn world(see_through: bool) -> World {
    let mut w = World::new();
    let image = w.texture();
    let plain = w.shader("diffuse", &[("color", vec3(0.8, 0.3, 0.2)), ("ambient", vec3(0.1, 0.2, 0.3))]);
    let textured = w.shader("diffuse", &[("texture", image.clone())]);
    let shiny = [("diffuse", vec3(0.2, 0.3, 0.7)), ("specular", vec3(0.5, 0.4, 0.3)), ("shininess", float(17.0))];
    let shiny = w.shader("phong", &shiny);
    let mirroring =
        [("reflection", vec3(0.3, 0.2, 0.2)), ("emission", vec3(0.05, 0.0, 0.1)), ("texture", image.clone())];
    let mirroring = w.shader("phong", &mirroring);
    let broken =
        w.shader("phong", &[("diffuse", vec3(f32::INFINITY, 0.0, 0.5)), ("emission", vec3(f32::NAN, 0.0, 0.0))]);
    let mirror = w.shader("mirror", &[]);
    let lines = w.shader("wireframe", &[("thickness", float(2.0))]);
    let metal = w.shader("metal", &[("roughness", float(0.3))]);
    let mut kinds: Vec<Vec<Name>> = vec![
        vec![],
        vec![plain],
        vec![plain, shiny],
        vec![textured, plain, shiny],
        vec![mirroring],
        vec![mirror, plain, lines, 9999],
        vec![plain, plain, broken],
        vec![metal, textured],
    ];
    if see_through {
        let clear = w.shader("phong", &[("transmission", vec3(0.5, 0.6, 0.7)), ("ior", float(1.3))]);
        let veil = w.shader("phong", &[("opacity", float(0.4)), ("diffuse", vec3(0.9, 0.9, 0.2))]);
        let cut = [("alpha_texture", image), ("alpha_threshold", float(0.5))];
        let cut = w.shader("cutout", &cut);
        let glass = w.shader("glass", &[]);
        kinds.extend([vec![clear, plain], vec![veil], vec![cut], vec![cut, plain, glass]]);
    }
    let withs = [With::Nothing, With::Normals, With::BadNormals, With::Everything];
    for (i, shaders) in kinds.iter().enumerate() {
        for (j, with) in withs.into_iter().enumerate() {
            let at = Vec3::new(i as f32 * 1.3 - 5.0, j as f32 * 1.3 - 2.0, -7.0 - 0.3 * ((i * j) % 4) as f32);
            let scale = Vec3::new(0.6, if i % 3 == 1 { 0.3 } else { 0.7 }, if (i + j) % 3 == 0 { -0.6 } else { 0.5 });
            let turn = Quat::from_rotation_y(i as f32) * Quat::from_rotation_x(j as f32);
            w.add(ball(with, shaders), Affine3A::from_scale_rotation_translation(scale, turn, at));
        }
    }
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let positions = corners.iter().map(|&(x, z)| Vec3::new(x, 0.0, z) * 20.0).collect();
    let floor = Mesh { positions, triangles: vec![[0, 2, 1], [0, 3, 2]], ..Mesh::default() };
    w.add(floor, Affine3A::from_translation(Vec3::new(0.0, -2.5, -5.0)));
    w
}

fn bits(v: impl IntoIterator<Item = f32>) -> Vec<u32> {
    v.into_iter().map(f32::to_bits).collect()
}

/// Both ways through a few packets of the frame, on every level. Returns how many samples were shaded together.
fn check(what: &str, w: &World) -> u32 {
    let mut shaded = 0;
    for level in Level::available() {
        let mut world = TwoLevel::new(level);
        world.update(&w.scene, &w.frame.instances);
        let mut memory = ShadeMemory::default();
        memory.update(&w.scene).expect("memory");
        let list = InstanceList::plain(&w.frame.instances);
        let scene = ShadeScene::new(&w.scene, &w.frame, list, &mut memory).expect("memory");
        let cone = scene.camera.cone(SIZE as f32, 1.0);
        let mut workers = [0, 1].map(|_| Worker::new(&scene, Tracer::new(&world), WorkerMemory::default()));
        let mut answers = [0, 1].map(|_| Samples::new());
        let mut camera = CameraPacket::new();
        for (number, packet) in (0..(SIZE / PACKET_SIZE).pow(2)).enumerate() {
            let pixel = [packet % (SIZE / PACKET_SIZE), packet / (SIZE / PACKET_SIZE)].map(|p| p * PACKET_SIZE);
            let wanted = Wanted {
                pixel,
                corner: Vec2::new(pixel[0] as f32, pixel[1] as f32),
                step: 1,
                last: [SIZE - 1; 2],
                mask: [u64::MAX, 0xffff_0f0f_3333_0001, 0x8000_0000_0000_0000][number % 3],
                number: number as u32 % 2,
                offset: Vec2::new(0.5, 0.25),
            };
            camera.aim(&scene.camera, level, &wanted, Vec2::splat(SIZE as f32), 1.0);
            for (i, (worker, samples)) in workers.iter_mut().zip(&mut answers).enumerate() {
                if i == 0 {
                    worker.samples(&camera, cone, samples);
                } else {
                    worker.samples_alone(&camera, cone, samples);
                }
            }
            let [together, alone] = &answers;
            for slot in (0..RayPacket::RAYS).filter(|slot| camera.mask >> slot & 1 == 1) {
                let place = || format!("{what}, {}, packet {number}, sample {slot}", level.name());
                let [a, b] = [together, alone].map(|samples| bits(samples.color(slot).to_array()));
                assert_eq!(a, b, "colour: {}", place());
                let seen = |samples: &Samples| {
                    samples.seen(slot).map(|s| (bits(s.normal.to_array()), s.distance.to_bits(), s.object, s.instance))
                };
                assert_eq!(seen(together), seen(alone), "seen: {}", place());
                // Also of samples that saw nothing, since pixels are copied as they are.
                let pixel = |samples: &Samples| {
                    let planes = samples.planes();
                    let color = planes.color.map(|plane| plane[slot].to_bits());
                    let (distance, normal) = (planes.distance[slot], planes.normal.map(|plane| plane[slot]));
                    (color, distance.to_bits(), bits(normal), planes.object[slot], planes.instance[slot])
                };
                assert_eq!(pixel(together), pixel(alone), "pixel: {}", place());
            }
            assert_eq!(workers[0].counts, workers[1].counts, "rays: {what}, packet {number}");
            shaded += workers[0].lit_together();
        }
    }
    shaded
}

#[test]
fn samples_shaded_together_get_what_each_gets_alone() {
    for see_through in [false, true] {
        for sky in ["", "gradient", "background"] {
            let mut w = world(see_through);
            let lens = [("aperture", float(0.3)), ("focus", float(7.0))];
            let window = [("window", ParamValue::Float([-0.9, 0.7, -0.4, 0.8]))];
            let wide = [("height", float(7.0)), ("center", vec3(0.1, -0.2, -1.0))];
            let cameras = [
                0,
                w.shader("thinlens", &lens),
                w.shader("pinhole", &window),
                w.shader("orthographic", &wide),
                w.shader("environment", &[]),
            ];
            let lights = [
                w.shader("point", &[("position", vec3(1.0, 4.0, -2.0)), ("attenuation", vec3(0.2, 0.1, 0.02))]),
                w.shader("directional", &[("direction", vec3(-1.0, -2.0, -1.5)), ("color", vec3(0.3, 0.3, 0.2))]),
                w.shader("ambient", &[("color", vec3(0.4, 0.5, 0.6))]),
                w.shader("spot", &[("position", vec3(-3.0, 5.0, 1.0)), ("direction", vec3(0.3, -1.0, -1.4))]),
                w.shader("area", &[("position", vec3(0.0, 6.0, -4.0)), ("samples", ParamValue::Int([3, 0, 0, 0]))]),
            ];
            let raycast = w.shader("raycast", &[]);
            if !sky.is_empty() {
                w.frame.environment = w.shader(sky, &[]);
            }
            for (i, camera) in cameras.into_iter().enumerate() {
                w.frame.camera = camera;
                for used in [&[][..], &lights[..3], &lights] {
                    w.frame.lights = used.iter().map(|&light| LightUse::new(light, Affine3A::IDENTITY)).collect();
                    for renderer in [0, raycast] {
                        w.frame.renderer = renderer;
                        let what = format!("camera {i}, {} lights, renderer {renderer}, sky {sky}", used.len());
                        let shaded = check(&what, &w);
                        let expected = !see_through || used.is_empty() || renderer == raycast;
                        assert_eq!(shaded > 0, expected, "{what}: {shaded} samples together");
                    }
                }
            }
        }
    }
}

#[test]
fn rays_of_a_packet_are_those_of_the_camera() {
    let mut w = World::new();
    let view = [("eye", vec3(1.0, 2.0, 3.0)), ("center", vec3(-0.3, 0.2, 0.1))];
    let with = |more: &[(&'static str, ParamValue)]| [&view[..], more].concat();
    let window = ("window", ParamValue::Float([-0.9, 0.7, -0.4, 0.8]));
    let beyond = ("eye", vec3(f32::INFINITY, 0.0, 0.0));
    let cameras = [
        w.shader("pinhole", &with(&[])),
        w.shader("pinhole", &with(&[window.clone(), ("aspect", float(2.0))])),
        w.shader("orthographic", &with(&[("height", float(3.0))])),
        w.shader("orthographic", &with(&[window])),
        w.shader("pinhole", &[beyond]),
        w.shader("thinlens", &with(&[("aperture", float(0.2))])),
    ];
    for (i, camera) in cameras.into_iter().enumerate() {
        w.frame.camera = camera;
        let camera = compile_camera(&w.scene, &w.frame, &Blocks::default());
        for (level, step) in Level::available().flat_map(|level| [(level, 1), (level, 5)]) {
            let mask = 0xffff_00ff_1234_8001;
            let (pixel, offset) = ([16, 8], Vec2::new(0.3, 0.9));
            let corner = Vec2::new(13.0, -2.0);
            // 13 columns and -2 rows of a viewport of 37 by 23 are before the packet.
            let wanted = Wanted { pixel, corner, step, last: [16 - 13 + 36, 8 + 2 + 22], mask, number: 5, offset };
            let (size, aspect) = (Vec2::new(37.0, 23.0), 1.7);
            let mut packet = CameraPacket::new();
            packet.aim(&camera, level, &wanted, size, aspect);
            for slot in 0..RayPacket::RAYS {
                let [x, y] = place(slot);
                let [x, y] = [(x * step).min(23), (y * step).min(24)];
                let screen = (wanted.corner + Vec2::new(x as f32, y as f32) + offset) / size;
                let lens = Rng::new(pixel[0] + x, pixel[1] + y, 5).next_vec2();
                let ray = camera.primary_ray(screen, aspect, lens).filter(|_| mask >> slot & 1 == 1);
                assert_eq!(packet.mask >> slot & 1 == 1, ray.is_some(), "camera {i}, {}, sample {slot}", level.name());
                if let Some(alone) = ray {
                    let ray = packet.rays.ray(slot);
                    assert_eq!(bits(ray.origin.to_array()), bits(alone.origin.to_array()), "camera {i}, sample {slot}");
                    assert_eq!(
                        bits(ray.direction.to_array()),
                        bits(alone.direction.to_array()),
                        "camera {i}, sample {slot}"
                    );
                    assert!(ray.tmax == f32::INFINITY);
                }
            }
            assert_eq!(packet.mask == 0, i == 4, "camera {i}");
        }
    }
}
