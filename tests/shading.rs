//! Shading seen from outside: small scenes through `Renderer`, compared with what can be computed by hand.

use glam::{Affine3A, Vec2, Vec3, Vec4};
use openrt::render::Renderer;
use openrt::scene::*;
use openrt::shade::builtin_classes;
use openrt::simd::Level;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A scene and the frame that shows it, put together with a few words.
struct World {
    scene: Scene,
    frame: FrameDesc,
    next: Name,
}

impl World {
    fn new(size: u32) -> Self {
        let mut scene = Scene::default();
        for (name, class) in (1..).zip(builtin_classes()) {
            scene.apply(Command::DefineClass { name, class });
        }
        let viewport = Viewport { x: 0, y: 0, width: size, height: size };
        Self { scene, frame: FrameDesc { size: [size, size], viewport, ..FrameDesc::default() }, next: 100 }
    }

    fn name(&mut self) -> Name {
        self.next += 1;
        self.next
    }

    /// A shader of a built-in class.
    fn shader(&mut self, class: &str, values: &[(&str, ParamValue)]) -> Name {
        let name = self.name();
        let (&class_name, class) = self.scene.classes.iter().find(|(_, c)| &*c.name == class).expect("built-in class");
        let class = class.clone();
        self.scene.apply(Command::DefineShader { name, class: class_name });
        for (param, value) in values {
            let param = class.param_index(param).unwrap_or_else(|| panic!("{}.{param}", class.name));
            self.scene.apply(Command::SetParameter { shader: name, param, value: value.clone() });
        }
        name
    }

    fn light(&mut self, class: &str, values: &[(&str, ParamValue)]) -> Name {
        let name = self.shader(class, values);
        self.frame.lights.push(name);
        name
    }

    fn object(&mut self, mesh: Mesh) -> Name {
        let name = self.name();
        self.scene.apply(Command::DefineObject { name, mesh, motion: Motion::Affine });
        name
    }

    fn place(&mut self, object: Name, world_from_object: Affine3A) {
        self.frame.instances.push(Instance { object, world_from_object });
    }

    fn add(&mut self, mesh: Mesh) {
        let object = self.object(mesh);
        self.place(object, Affine3A::IDENTITY);
    }

    /// Renders with a fresh renderer and returns the colours, rows from the bottom.
    fn render(&self) -> Vec<Vec4> {
        colors(&self.renderer())
    }

    fn renderer(&self) -> Renderer {
        let mut renderer = Renderer::new(Level::detect());
        renderer.render(&self.scene, &self.frame, None, &AtomicBool::new(false)).expect("small frames render");
        renderer
    }

    /// Renders and returns the colour in the middle.
    fn middle(&self) -> Vec4 {
        let size = self.frame.size[0] as usize;
        self.render()[size / 2 * size + size / 2]
    }
}

fn colors(renderer: &Renderer) -> Vec<Vec4> {
    let fb = renderer.framebuffer();
    (0..fb.height()).flat_map(|y| fb.row(y)).map(|p| Vec4::from_array(p.color)).collect()
}

fn rgb(r: f32, g: f32, b: f32) -> ParamValue {
    ParamValue::Float([r, g, b, 0.0])
}

fn grey(x: f32) -> ParamValue {
    rgb(x, x, x)
}

fn float(x: f32) -> ParamValue {
    ParamValue::Float([x, 0.0, 0.0, 0.0])
}

fn int(i: i32) -> ParamValue {
    ParamValue::Int([i, 0, 0, 0])
}

/// A parallelogram of two triangles with texture coordinates 0 to 1; it faces `u × v`.
fn quad(center: Vec3, u: Vec3, v: Vec3, shader: Name) -> Mesh {
    let c = center - 0.5 * (u + v);
    Mesh {
        positions: vec![c, c + u, c + u + v, c + v],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        tex_coords: vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y],
        shader_of_triangle: vec![shader; 2],
        ..Mesh::default()
    }
}

/// A quad in front of the default camera that fills the picture.
fn wall(z: f32, shader: Name) -> Mesh {
    quad(Vec3::new(0.0, 0.0, z), Vec3::X * 10.0 * -z, Vec3::Y * 10.0 * -z, shader)
}

/// A sphere of 2·n² triangles, closed, with smooth normals.
fn sphere(center: Vec3, radius: f32, n: u32, shader: Name) -> Mesh {
    let mut mesh = Mesh::default();
    for i in 0..=n {
        for j in 0..2 * n {
            let theta = std::f32::consts::PI * i as f32 / n as f32;
            let phi = std::f32::consts::PI * j as f32 / n as f32;
            let normal = Vec3::new(theta.sin() * phi.cos(), theta.cos(), -theta.sin() * phi.sin());
            mesh.positions.push(center + normal * radius);
            mesh.normals.push(normal);
        }
    }
    for i in 0..n {
        for j in 0..2 * n {
            let [a, b] = [i * 2 * n + j, i * 2 * n + (j + 1) % (2 * n)];
            let [c, d] = [a + 2 * n, b + 2 * n];
            mesh.triangles.extend([[a, c, d], [a, d, b]]);
        }
    }
    mesh.shader_of_triangle = vec![shader; mesh.triangles.len()];
    mesh
}

#[track_caller]
fn assert_near(a: Vec4, b: [f32; 4], tolerance: f32) {
    assert!((a - Vec4::from_array(b)).abs().max_element() <= tolerance, "{a} is not {b:?}");
}

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
