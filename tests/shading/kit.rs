//! Scenes, meshes and parameters in a few words.

use glam::{Affine3A, Vec2, Vec3, Vec4};
use openrt::render::Renderer;
use openrt::scene::*;
use openrt::shade::builtin_classes;
use openrt::simd::Level;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A scene and the frame that shows it, put together with a few words.
pub struct World {
    pub scene: Scene,
    pub frame: FrameDesc,
    pub next: Name,
}

impl World {
    pub fn new(size: u32) -> Self {
        let mut scene = Scene::default();
        for (name, class) in (1..).zip(builtin_classes()) {
            scene.apply(Command::DefineClass { name, class });
        }
        let viewport = Viewport { x: 0, y: 0, width: size, height: size };
        Self { scene, frame: FrameDesc { size: [size, size], viewport, ..FrameDesc::default() }, next: 100 }
    }

    pub fn name(&mut self) -> Name {
        self.next += 1;
        self.next
    }

    /// A shader of a built-in class.
    pub fn shader(&mut self, class: &str, values: &[(&str, ParamValue)]) -> Name {
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

    pub fn light(&mut self, class: &str, values: &[(&str, ParamValue)]) -> Name {
        let name = self.shader(class, values);
        self.frame.lights.push(LightUse::new(name, Affine3A::IDENTITY));
        name
    }

    pub fn object(&mut self, mesh: Mesh) -> Name {
        let name = self.name();
        self.scene.apply(Command::DefineObject { name, mesh, motion: Motion::Affine });
        name
    }

    pub fn place(&mut self, object: Name, world_from_object: Affine3A) {
        self.frame.instances.push(Instance::new(object, world_from_object));
    }

    pub fn add(&mut self, mesh: Mesh) {
        let object = self.object(mesh);
        self.place(object, Affine3A::IDENTITY);
    }

    /// Renders with a fresh renderer and returns the colours, rows from the bottom.
    pub fn render(&self) -> Vec<Vec4> {
        colors(&self.renderer())
    }

    pub fn renderer(&self) -> Renderer {
        let mut renderer = Renderer::new(Level::detect());
        renderer.render(&self.scene, &self.frame, None, &AtomicBool::new(false)).expect("small frames render");
        renderer
    }

    /// Renders and returns the colour in the middle.
    pub fn middle(&self) -> Vec4 {
        let size = self.frame.size[0] as usize;
        self.render()[size / 2 * size + size / 2]
    }
}

pub fn colors(renderer: &Renderer) -> Vec<Vec4> {
    let fb = renderer.framebuffer();
    (0..fb.height()).flat_map(|y| fb.row(y)).map(|p| Vec4::from_array(p.color)).collect()
}

pub fn rgb(r: f32, g: f32, b: f32) -> ParamValue {
    ParamValue::Float([r, g, b, 0.0])
}

pub fn grey(x: f32) -> ParamValue {
    rgb(x, x, x)
}

pub fn float(x: f32) -> ParamValue {
    ParamValue::Float([x, 0.0, 0.0, 0.0])
}

pub fn int(i: i32) -> ParamValue {
    ParamValue::Int([i, 0, 0, 0])
}

/// A parallelogram of two triangles with texture coordinates 0 to 1; it faces `u × v`.
pub fn quad(center: Vec3, u: Vec3, v: Vec3, shader: Name) -> Mesh {
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
pub fn wall(z: f32, shader: Name) -> Mesh {
    quad(Vec3::new(0.0, 0.0, z), Vec3::X * 10.0 * -z, Vec3::Y * 10.0 * -z, shader)
}

/// A sphere of 2·n² triangles, closed, with smooth normals.
pub fn sphere(center: Vec3, radius: f32, n: u32, shader: Name) -> Mesh {
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
pub fn assert_near(a: Vec4, b: [f32; 4], tolerance: f32) {
    assert!((a - Vec4::from_array(b)).abs().max_element() <= tolerance, "{a} is not {b:?}");
}

/// Shows the direction itself: ½(d + 1).
pub struct Compass;

impl EnvironmentShader for Compass {
    fn radiance(&self, _params: &[u8], direction: Vec3) -> Vec3 {
        direction * 0.5 + Vec3::splat(0.5)
    }
}

pub fn compass(d: Vec3) -> Vec3 {
    d * 0.5 + Vec3::splat(0.5)
}

impl World {
    pub fn user_class(&mut self, kind: ShaderKind, program: Program, block_size: u32, params: Vec<ParamDef>) -> Name {
        let class = self.name();
        let definition = ShaderClass { name: format!("user{class}").into(), kind, params, block_size, program };
        self.scene.apply(Command::DefineClass { name: class, class: Arc::new(definition) });
        let shader = self.name();
        self.scene.apply(Command::DefineShader { name: shader, class });
        shader
    }

    /// Looks at one point only, so that all samples of a pixel are the same.
    pub fn use_narrow_camera(&mut self) {
        self.frame.camera = self.shader("pinhole", &[("fov", float(0.001))]);
    }

    pub fn use_compass(&mut self) {
        let program = Program::Environment(Arc::new(Compass));
        self.frame.environment = self.user_class(ShaderKind::Environment, program, 0, vec![]);
    }
}

/// 2 × 2 texels; (u, v) = (0, 0) is the first.
pub fn texture(w: &mut World, texels: [[u8; 4]; 4], filter: Filter) -> Name {
    let name = w.name();
    let level = TextureLevel { width: 2, height: 2, texels: texels.to_vec() };
    let texture = Texture { levels: vec![level], filter, ..Texture::default() };
    w.scene.apply(Command::DefineTexture { name, texture: Arc::new(texture) });
    name
}

/// A scene with something of everything.
pub fn zoo(size: u32) -> World {
    let mut w = World::new(size);
    let [o, x] = [[40, 40, 60, 255], [255; 4]];
    let checker = texture(&mut w, [o, x, x, o], Filter::LinearMipmapLinear);
    let floor = w.shader("diffuse", &[("texture", ParamValue::Texture(checker)), ("color", grey(0.9))]);
    let glass = w.shader("glass", &[]);
    let metal = w.shader("metal", &[("color", rgb(0.9, 0.7, 0.3)), ("roughness", float(0.2))]);
    let shiny = [("diffuse", rgb(0.7, 0.1, 0.1)), ("specular", grey(0.5)), ("reflection", grey(0.2))];
    let plastic = w.shader("phong", &shiny);
    let mut ground = quad(Vec3::new(0.0, -1.0, -4.0), Vec3::X * 12.0, Vec3::NEG_Z * 12.0, floor);
    ground.tex_coords.iter_mut().for_each(|t| *t *= 6.0);
    w.add(ground);
    for (x, shader) in [(-1.3, glass), (0.0, metal), (1.3, plastic)] {
        let ball = w.object(sphere(Vec3::ZERO, 0.6, 32, shader));
        w.place(ball, Affine3A::from_translation(Vec3::new(x, -0.4, -3.0)));
    }
    w.light("area", &[("position", rgb(1.0, 3.0, -2.0)), ("color", grey(0.9)), ("samples", int(9))]);
    w.light("ambient", &[]);
    w.frame.environment = w.shader("gradient", &[]);
    w
}

pub fn pool(threads: usize) -> openrt::threads::Pool {
    openrt::threads::Pool::new(Some(threads)).expect("a few threads can be had")
}
