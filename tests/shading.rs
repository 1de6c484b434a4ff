//! Shading seen from outside: small scenes through `Renderer`, compared with what can be computed by hand.

use glam::{Affine3A, Vec2, Vec3, Vec4};
use openrt::render::Renderer;
use openrt::scene::*;
use openrt::shade::builtin_classes;
use openrt::simd::Level;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

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

// --- environments and directions ---------------------------------------------------------------------------

/// Shows the direction itself: ½(d + 1).
struct Compass;

impl EnvironmentShader for Compass {
    fn radiance(&self, _params: &[u8], direction: Vec3) -> Vec3 {
        direction * 0.5 + Vec3::splat(0.5)
    }
}

fn compass(d: Vec3) -> Vec3 {
    d * 0.5 + Vec3::splat(0.5)
}

impl World {
    fn user_class(&mut self, kind: ShaderKind, program: Program, block_size: u32, params: Vec<ParamDef>) -> Name {
        let class = self.name();
        let definition = ShaderClass { name: format!("user{class}").into(), kind, params, block_size, program };
        self.scene.apply(Command::DefineClass { name: class, class: Arc::new(definition) });
        let shader = self.name();
        self.scene.apply(Command::DefineShader { name: shader, class });
        shader
    }

    /// Looks at one point only, so that all samples of a pixel are the same.
    fn use_narrow_camera(&mut self) {
        self.frame.camera = self.shader("pinhole", &[("fov", float(0.001))]);
    }

    fn use_compass(&mut self) {
        let program = Program::Environment(Arc::new(Compass));
        self.frame.environment = self.user_class(ShaderKind::Environment, program, 0, vec![]);
    }
}

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

// --- holes, textures, interpolation -------------------------------------------------------------------------

/// 2 × 2 texels; (u, v) = (0, 0) is the first.
fn texture(w: &mut World, texels: [[u8; 4]; 4], filter: Filter) -> Name {
    let name = w.name();
    let level = TextureLevel { width: 2, height: 2, texels: texels.to_vec() };
    let texture = Texture { levels: vec![level], filter, ..Texture::default() };
    w.scene.apply(Command::DefineTexture { name, texture: Arc::new(texture) });
    name
}

#[test]
fn a_texture_lies_the_right_way_up() {
    let mut w = World::new(4);
    let rgbw = [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255; 4]];
    let image = texture(&mut w, rgbw, Filter::Nearest);
    let shader = w.shader("constant", &[("texture", ParamValue::Texture(image))]);
    // Exactly the field of view of the default camera.
    let side = 2.0 * 30f32.to_radians().tan();
    w.add(quad(Vec3::NEG_Z, Vec3::X * side, Vec3::Y * side, shader));
    let picture = w.render();
    assert_near(picture[0], [1.0, 0.0, 0.0, 1.0], 0.0);
    assert_near(picture[3], [0.0, 1.0, 0.0, 1.0], 0.0);
    assert_near(picture[12], [0.0, 0.0, 1.0, 1.0], 0.0);
    assert_near(picture[15], [1.0, 1.0, 1.0, 1.0], 0.0);
    // A texture that does not exist is white.
    let missing = w.shader("constant", &[("texture", ParamValue::Texture(77_777))]);
    w.frame.instances.clear();
    w.add(wall(-1.0, missing));
    assert_near(w.middle(), [1.0; 4], 0.0);
}

#[test]
fn a_fine_texture_far_away_is_its_mean() {
    let mut w = World::new(16);
    let [o, x] = [[0, 0, 0, 255], [255; 4]];
    let checker = texture(&mut w, [o, x, x, o], Filter::LinearMipmapLinear);
    let shader = w.shader("constant", &[("texture", ParamValue::Texture(checker))]);
    let mut mesh = wall(-2.0, shader);
    mesh.tex_coords.iter_mut().for_each(|t| *t *= 1000.0);
    w.add(mesh);
    for color in w.render() {
        // The 1 × 1 level of the checker is 128/255.
        assert_near(color, [128.0 / 255.0, 128.0 / 255.0, 128.0 / 255.0, 1.0], 1e-5);
    }
}

#[test]
fn holes_let_the_eye_and_the_light_through() {
    let mut w = World::new(1);
    let [o, x] = [[255, 255, 255, 0], [255; 4]];
    let mask = texture(&mut w, [o, x, x, o], Filter::Nearest);
    let leaf = w.shader("cutout", &[("texture", ParamValue::Texture(mask)), ("color", rgb(0.0, 1.0, 0.0))]);
    let white = w.shader("diffuse", &[("color", grey(1.0))]);
    w.add(wall(-2.0, white));
    w.light("directional", &[("direction", rgb(-1.0, 0.0, -1.0))]);
    let lit = 0.5f32.sqrt();
    // The ray to the light passes (1, 0, −1); the eye's ray stays at x = 0.
    let shadow_leaf = |dx: f32| quad(Vec3::new(1.0 + dx, 0.2, -1.0), Vec3::X * 1.6, Vec3::Y * 1.6, leaf);
    for (dx, share) in [(0.4, lit), (-0.4, 0.0)] {
        let mut v = World { scene: Scene::default(), frame: w.frame.clone(), next: 900 };
        v.scene.classes = w.scene.classes.clone();
        v.scene.shaders = w.scene.shaders.clone();
        v.scene.textures = w.scene.textures.clone();
        v.scene.objects = w.scene.objects.clone();
        v.add(shadow_leaf(dx));
        assert_near(v.middle(), [share, share, share, 1.0], 1e-5);
        let renderer = v.renderer();
        assert_eq!(renderer.framebuffer().pixel(0, 0).unwrap().instance, 0);
    }
    // In front of the eye: through the hole the wall, elsewhere the leaf, also for depth and names.
    w.add(quad(Vec3::new(0.4, 0.4, -1.0), Vec3::X * 1.6, Vec3::Y * 1.6, leaf));
    let renderer = w.renderer();
    assert!((renderer.framebuffer().pixel(0, 0).unwrap().depth - 2.0).abs() < 1e-5);
    w.frame.instances.pop();
    w.add(quad(Vec3::new(-0.4, 0.4, -1.0), Vec3::X * 1.6, Vec3::Y * 1.6, leaf));
    let renderer = w.renderer();
    let pixel = renderer.framebuffer().pixel(0, 0).unwrap();
    assert!((pixel.depth - 1.0).abs() < 1e-5 && pixel.instance == 1);
    assert_near(Vec4::from_array(pixel.color), [0.0, lit, 0.0, 1.0], 1e-5);
}

#[test]
fn opacity_blends_with_what_lies_behind() {
    let mut w = World::new(1);
    let back = w.shader("constant", &[("color", rgb(0.0, 0.0, 1.0))]);
    let red = [("emission", rgb(1.0, 0.0, 0.0)), ("diffuse", grey(0.0)), ("opacity", float(0.25))];
    let front = w.shader("phong", &red);
    w.add(wall(-1.0, front));
    assert_near(w.middle(), [0.25, 0.0, 0.0, 0.25], 1e-6);
    w.add(wall(-2.0, back));
    assert_near(w.middle(), [0.25, 0.0, 0.75, 1.0], 1e-6);
}

#[test]
fn vertex_colors_and_normals_are_interpolated() {
    let mut w = World::new(9);
    let constant = w.shader("constant", &[]);
    let side = 2.0 * 30f32.to_radians().tan();
    let mut mesh = quad(Vec3::NEG_Z, Vec3::X * side, Vec3::Y * side, constant);
    mesh.colors =
        vec![Vec4::W, Vec4::new(1.0, 0.0, 0.0, 1.0), Vec4::new(1.0, 1.0, 0.0, 1.0), Vec4::new(0.0, 1.0, 0.0, 1.0)];
    w.add(mesh);
    for (i, color) in w.render().into_iter().enumerate() {
        let (x, y) = ((i % 9) as f32 + 0.5, (i / 9) as f32 + 0.5);
        assert_near(color, [x / 9.0, y / 9.0, 0.0, 1.0], 1e-5);
    }

    let normals = w.shader("normals", &[]);
    let [a, b] = [Vec3::new(-1.0, 0.0, 1.0), Vec3::new(1.0, 0.0, 1.0)];
    let mut mesh = quad(Vec3::NEG_Z, Vec3::X * side, Vec3::Y * side, normals);
    mesh.normals = vec![a, b, b, a];
    let smooth = w.object(mesh);
    // Stretched, turned and mirrored instances: normals follow the inverse transpose, and stay on their side.
    let flat_scale = Affine3A::from_scale(Vec3::new(1.0, 1.0, 0.25));
    let mirrored = Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    for (place, factor) in [(Affine3A::IDENTITY, 1.0), (flat_scale, 4.0), (mirrored, 1.0)] {
        let mut v = World { scene: std::mem::take(&mut w.scene), frame: w.frame.clone(), next: 2000 };
        v.frame.instances.clear();
        let lifted = Affine3A::from_translation(Vec3::Z * (place.matrix3.z_axis.z - 1.0)) * place;
        v.place(smooth, lifted);
        for (i, color) in v.render().into_iter().enumerate() {
            let x = ((i % 9) as f32 + 0.5) / 9.0;
            let n = Vec3::new(2.0 * x - 1.0, 0.0, factor).normalize();
            let expected = compass(n);
            assert_near(color, [expected.x, expected.y, expected.z, 1.0], 2e-3);
        }
        w.scene = v.scene;
    }
}

#[test]
fn glass_keeps_its_inside_in_mirrored_instances() {
    let mut w = World::new(16);
    w.use_compass();
    let glass = w.shader("glass", &[]);
    let ball = w.object(sphere(Vec3::new(0.0, 0.0, -3.0), 1.0, 32, glass));
    w.place(ball, Affine3A::IDENTITY);
    let right = w.render();
    w.frame.instances.clear();
    w.place(ball, Affine3A::from_scale(Vec3::new(1.0, -1.0, 1.0)));
    let mirrored = w.render();
    for y in 0..16 {
        for x in 0..16 {
            let (a, b) = (right[y * 16 + x], mirrored[(15 - y) * 16 + x]);
            assert!((a.x - b.x).abs() < 0.05 && (a.z - b.z).abs() < 0.05, "{x} {y}: {a} {b}");
        }
    }
}

// --- estimators ----------------------------------------------------------------------------------------------

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

// --- robustness ----------------------------------------------------------------------------------------------

/// A number from `OPENRT_SEED`, or the one given.
fn seed(default: u64) -> u64 {
    std::env::var("OPENRT_SEED").ok().and_then(|s| s.parse().ok()).unwrap_or(default)
}

struct Random(openrt::shade::Rng);

impl Random {
    fn new(seed: u64) -> Self {
        Self(openrt::shade::Rng::new(seed as u32, (seed >> 32) as u32, 0))
    }

    fn unit(&mut self) -> f32 {
        self.0.next_f32()
    }

    fn vec3(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - Vec3::ONE
    }

    fn direction(&mut self) -> Vec3 {
        loop {
            let v = self.vec3();
            if (0.01..1.0).contains(&v.length_squared()) {
                return v.normalize();
            }
        }
    }
}

/// Spawned rays never meet the flat triangle that they leave, wherever it lies and however it is instanced.
#[test]
fn r15_a_million_spawned_rays_never_hit_their_own_triangle() {
    use openrt::accel::TwoLevel;
    use openrt::shade::{Cone, Interaction};
    use openrt::trace::{Ray, Tracer};
    let seed = seed(15);
    let mut random = Random::new(seed);
    let (mut spawned, mut hits) = (0u32, 0u32);
    for round in 0..2000 {
        let offset = [0.0, 1.0, 1e3, 1e5][round % 4];
        let size = [1.0, 1e-3, 30.0, 1e3][round / 4 % 4];
        let motion = [Motion::Affine, Motion::Static][round / 16 % 2];
        let origin = random.vec3() * offset;
        // Any triangle; one flat in an axis and close to that plane's origin; a needle; one all but flat.
        let (axes, near) = match round / 128 % 4 {
            0 => (Vec3::ONE, Vec3::ONE),
            1 => (Vec3::new(1.0, 1.0, 0.0), Vec3::new(1.0, 1.0, 1e-3)),
            2 => (random.direction(), Vec3::ONE),
            _ => (Vec3::new(1.0, 1e-3, 1.0), Vec3::new(1.0, 1e-3, 1.0)),
        };
        let needle = round / 128 % 4 == 2;
        let corners = [0; 3].map(|_| {
            let p = random.vec3() * size;
            origin * near + if needle { axes * p.x + p * 1e-3 } else { p * axes }
        });
        let mut m = match round / 32 % 4 {
            0 => Affine3A::IDENTITY,
            1 => Affine3A::from_rotation_x(random.unit() * 6.0) * Affine3A::from_rotation_y(random.unit() * 6.0),
            2 => Affine3A::from_scale(Vec3::new(0.01, 3.0, -20.0)) * Affine3A::from_rotation_z(random.unit() * 6.0),
            _ => Affine3A::from_mat3(glam::Mat3::from_cols(random.vec3(), random.vec3(), random.vec3())),
        };
        m.translation = glam::Vec3A::from(random.vec3() * [0.0, 1.0, 1e4][round % 3]);
        let mut w = World::new(1);
        let name = w.object(Mesh { positions: corners.to_vec(), triangles: vec![[0, 1, 2]], ..Mesh::default() });
        w.scene.apply(Command::SetMotion { name, motion });
        w.place(name, m);
        let mut world = TwoLevel::new(Level::detect());
        world.update(&w.scene, &w.frame.instances);
        let tracer = Tracer::new(&world);
        let mesh = &w.scene.objects[&name].mesh;
        let placed = corners.map(|c| m.transform_point3(c));
        let extent = (placed[1] - placed[0]).length().max((placed[2] - placed[0]).length());
        for _ in 0..500 {
            let (u, v) = (random.unit(), random.unit());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let target = placed[0] * (1.0 - u - v) + placed[1] * u + placed[2] * v;
            let towards = random.direction();
            let ray = Ray::new(target - towards * extent, towards);
            let Some(hit) = tracer.intersect(&ray) else { continue };
            let cone = Cone { width: 0.0, spread: 0.0 };
            let it = Interaction::new(&ray, &hit, &w.frame.instances[0], mesh, cone, 0);
            // All directions, and nearly tangential ones.
            let n = it.point.geometric_normal;
            for grazing in [1.0, 0.0, 1e-3, 1e-6] {
                let d = random.direction();
                let d = if grazing == 1.0 { d } else { ((d - n * d.dot(n)) + n * (grazing * d.dot(n))).normalize() };
                spawned += 1;
                if tracer.intersect(&it.spawn(d)).is_some() {
                    hits += 1;
                }
            }
        }
    }
    assert!(spawned > 1_000_000, "{spawned}");
    assert_eq!(hits, 0, "of {spawned} rays; seed {seed}");
}

/// A scene with something of everything.
fn zoo(size: u32) -> World {
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

fn pool(threads: usize) -> openrt::threads::Pool {
    openrt::threads::Pool::new(Some(threads)).expect("a few threads can be had")
}

#[test]
fn the_picture_does_not_depend_on_the_number_of_threads() {
    let mut w = zoo(50);
    w.frame.samples = 2;
    let path = w.shader("path", &[]);
    let occlusion = w.shader("ambient_occlusion", &[]);
    for renderer in [0, path, occlusion] {
        w.frame.renderer = renderer;
        let reference = pool(1).install(|| w.render());
        assert!(reference.iter().any(|c| *c != reference[0]));
        for threads in [2, 3, 7] {
            assert!(pool(threads).install(|| w.render()) == reference, "{threads} threads");
        }
    }
}

#[test]
fn a_cancelled_frame_keeps_the_old_picture_and_says_so() {
    let mut w = zoo(40);
    let mut renderer = Renderer::new(Level::detect());
    let stats = renderer.render(&w.scene, &w.frame, None, &AtomicBool::new(false)).unwrap();
    assert!(!stats.cancelled && stats.primary_rays == 1600);
    assert!(stats.shadow_rays > 0 && stats.secondary_rays > 0 && stats.instances == 4);
    let before = colors(&renderer);
    w.frame.lights.clear();
    let stats = renderer.render(&w.scene, &w.frame, None, &AtomicBool::new(true)).unwrap();
    assert!(stats.cancelled && stats.primary_rays == 0);
    assert_eq!(colors(&renderer), before);
}

#[test]
fn a_viewport_renders_its_pixels_only() {
    let mut w = World::new(40);
    let red = w.shader("constant", &[("color", rgb(1.0, 0.0, 0.0))]);
    w.add(wall(-1.0, red));
    w.frame.viewport = Viewport { x: 3, y: 20, width: 17, height: 9 };
    let picture = w.render();
    for (i, color) in picture.iter().enumerate() {
        let (x, y) = (i % 40, i / 40);
        let inside = (3..20).contains(&x) && (20..29).contains(&y);
        assert_eq!(*color, if inside { Vec4::new(1.0, 0.0, 0.0, 1.0) } else { Vec4::ZERO }, "{x} {y}");
    }
    // A viewport beyond the framebuffer is cut.
    w.frame.viewport = Viewport { x: 30, y: 30, width: 20, height: 20 };
    assert_eq!(w.render().iter().filter(|c| c.x > 0.0).count(), 100);
    w.frame.viewport = Viewport { x: 0, y: 0, width: 0, height: 0 };
    assert!(w.render().iter().all(|c| *c == Vec4::ZERO));
}

#[test]
fn pixels_know_what_they_show_and_picking_agrees() {
    let w = zoo(64);
    let renderer = w.renderer();
    let mut kinds = std::collections::BTreeSet::new();
    for y in 0..64 {
        for x in 0..64 {
            let pixel = renderer.framebuffer().pixel(x, y).unwrap();
            match renderer.pick(&w.scene, x as f32 + 0.5, y as f32 + 0.5) {
                Some(hit) => {
                    assert_eq!((pixel.object, pixel.instance, pixel.depth), (hit.object, hit.instance, hit.t));
                    let n = Vec3::from_array(pixel.normal);
                    assert!((n.length() - 1.0).abs() < 1e-5);
                    kinds.insert(hit.instance);
                }
                None => {
                    assert_eq!((pixel.object, pixel.instance), (0, openrt::frame::NO_INSTANCE));
                    assert!(pixel.depth == f32::INFINITY && pixel.normal == [0.0; 3]);
                }
            }
        }
    }
    assert_eq!(kinds.len(), 4);
    assert!(renderer.pick(&w.scene, -0.1, 3.0).is_none() && renderer.pick(&w.scene, f32::NAN, 3.0).is_none());
    assert!(renderer.pick(&w.scene, 3.0, 64.0).is_none());
}

// --- the user's programs --------------------------------------------------------------------------------------

/// Returns what it finds in its parameter block, and checks the block's alignment.
struct Reader;

impl SurfaceShader for Reader {
    fn shade(&self, params: &[u8], context: &mut dyn ShadingContext) -> Vec4 {
        assert_eq!(params.as_ptr() as usize % 16, 0);
        let float = |at: usize| f32::from_ne_bytes(params[at..at + 4].try_into().unwrap());
        let int = i32::from_ne_bytes(params[12..16].try_into().unwrap());
        assert_eq!(params[16..20], context.point().primitive.to_ne_bytes());
        Vec4::new(float(0), float(4), int as f32, float(8))
    }
}

#[test]
fn parameter_blocks_carry_shader_triangle_and_vertex_values() {
    let mut w = World::new(9);
    let param = |name: &str, ty, scope, default, offset| ParamDef { name: name.into(), ty, scope, default, offset };
    let params = vec![
        param("per_shader", ParamType::Float(1), ParamScope::Shader, float(0.25), 0),
        param("per_vertex", ParamType::Float(1), ParamScope::Vertex, float(9.0), 4),
        param("opacity", ParamType::Float(1), ParamScope::Shader, float(1.0), 8),
        param("per_triangle", ParamType::Int(1), ParamScope::Triangle, int(9), 12),
        param("prim", ParamType::Int(1), ParamScope::Triangle, int(9), 16),
        param("beyond", ParamType::Float(4), ParamScope::Shader, float(1.0), 30),
    ];
    let shader = w.user_class(ShaderKind::Surface, Program::Surface(Arc::new(Reader)), 32, params);
    let side = 2.0 * 30f32.to_radians().tan();
    let mut mesh = quad(Vec3::NEG_Z, Vec3::X * side, Vec3::Y * side, shader);
    let stream = |param, data: &[f32]| ParamStream { shader, param, width: 1, data: data.to_vec() };
    mesh.params = vec![
        stream(1, &[0.0, 1.0, 1.0, 0.0]),
        stream(3, &[3.0, 7.0]),
        stream(4, &[0.0, 1.0]),
        ParamStream { shader: shader + 1, ..stream(1, &[5.0; 4]) },
        stream(99, &[1.0]),
    ];
    w.add(mesh);
    for (i, color) in w.render().into_iter().enumerate() {
        let (x, y) = ((i % 9) as f32 + 0.5, (i / 9) as f32 + 0.5);
        // The first triangle is the lower right one; on the diagonal it wins as the lower primitive.
        let below = x >= y;
        assert_near(color, [0.25, x / 9.0, if below { 3.0 } else { 7.0 }, 1.0], 1e-5);
    }
}

/// Lights, shadows, mirrors and textures through the context, as the built-in classes do them.
struct ByHand(Name);

impl SurfaceShader for ByHand {
    fn shade(&self, _params: &[u8], context: &mut dyn ShadingContext) -> Vec4 {
        let point = *context.point();
        let mut color = context.texture(self.0, point.tex_coord).truncate() * 0.0;
        for i in 0..context.light_count() {
            if let Some(sample) = context.illuminate(i) {
                let cos = point.normal.dot(sample.direction);
                if cos > 0.0 && !context.shadowed(sample.direction, sample.distance) {
                    color += 0.5 * cos * sample.radiance;
                }
            }
        }
        assert!(context.illuminate(99).is_none());
        let mirrored = point.incoming - 2.0 * point.incoming.dot(point.normal) * point.normal;
        (color + 0.5 * context.trace(mirrored * 3.0)).extend(1.0)
    }
}

#[test]
fn a_users_surface_can_do_what_phong_does() {
    let mut w = zoo(32);
    w.frame.lights.clear();
    w.light("point", &[("position", rgb(2.0, 3.0, 0.0))]);
    let phong = w.shader("phong", &[("diffuse", grey(0.5)), ("reflection", grey(0.5))]);
    let user = w.user_class(ShaderKind::Surface, Program::Surface(Arc::new(ByHand(0))), 0, vec![]);
    let mut picture = |shader: Name| {
        let instances = w.frame.instances.clone();
        w.add(sphere(Vec3::new(0.0, 0.6, -3.5), 0.7, 24, shader));
        let picture = w.render();
        w.frame.instances = instances;
        picture
    };
    for (a, b) in picture(phong).iter().zip(picture(user)) {
        assert!((*a - b).abs().max_element() < 1e-5, "{a} {b}");
    }
}

struct Broken(f32);

impl SurfaceShader for Broken {
    fn shade(&self, _params: &[u8], _context: &mut dyn ShadingContext) -> Vec4 {
        Vec4::new(1.0, self.0, 1.0, 1.0)
    }
}

#[test]
fn a_broken_shader_writes_zero_and_does_not_poison_averages() {
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut w = World::new(2);
        w.frame.accumulate = true;
        let broken = w.user_class(ShaderKind::Surface, Program::Surface(Arc::new(Broken(value))), 0, vec![]);
        w.add(wall(-1.0, broken));
        let mut renderer = Renderer::new(Level::detect());
        for _ in 0..3 {
            renderer.render(&w.scene, &w.frame, None, &AtomicBool::new(false)).unwrap();
        }
        assert_eq!(colors(&renderer), [Vec4::ZERO; 4]);
    }
}

struct Corner;

impl CameraShader for Corner {
    fn primary_ray(&self, _params: &[u8], screen: Vec2, aspect: f32) -> Option<PrimaryRay> {
        assert!((aspect - 1.0).abs() < 1e-6);
        // Looks along +x, and leaves the left half clear.
        (screen.x >= 0.5).then(|| PrimaryRay { origin: Vec3::ZERO, direction: Vec3::new(7.0, screen.y - 0.5, 0.0) })
    }
}

struct Lamp;

impl LightShader for Lamp {
    fn illuminate(&self, _params: &[u8], position: Vec3) -> Option<LightSample> {
        (position.y > 0.0).then_some(LightSample {
            direction: Vec3::NEG_X * 2.0,
            distance: 5.0,
            radiance: Vec3::new(0.25, 0.5, 1.0),
        })
    }
}

#[test]
fn a_users_camera_and_light_are_asked() {
    let mut w = World::new(2);
    w.frame.clear_color = [0.1, 0.2, 0.3, 0.4];
    w.frame.camera = w.user_class(ShaderKind::Camera, Program::Camera(Arc::new(Corner)), 0, vec![]);
    let lamp = w.user_class(ShaderKind::Light, Program::Light(Arc::new(Lamp)), 0, vec![]);
    w.frame.lights.push(lamp);
    let white = w.shader("diffuse", &[("color", grey(1.0))]);
    w.add(quad(Vec3::X * 3.0, Vec3::Y * 9.0, Vec3::Z * 9.0, white));
    let picture = w.render();
    assert_near(picture[0], [0.1, 0.2, 0.3, 0.4], 1e-6);
    assert_near(picture[1], [0.0, 0.0, 0.0, 1.0], 1e-6);
    assert_near(picture[3], [0.25, 0.5, 1.0, 1.0], 1e-6);
}

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

/// An image in memory.
struct Image(std::sync::Mutex<Vec<u8>>);

impl openrt::frame::PixelSink for Image {
    fn write(&self, offset: usize, bytes: &[u8]) {
        self.0.lock().unwrap()[offset..offset + bytes.len()].copy_from_slice(bytes);
    }
}

#[test]
fn a_target_gets_the_pixels_of_the_framebuffer() {
    use openrt::frame::{PixelFormat, Target, TargetLayout};
    let mut w = zoo(37);
    w.frame.srgb = true;
    for origin_top_left in [false, true] {
        let stride = 37 * 4 + 12;
        let image = Arc::new(Image(std::sync::Mutex::new(vec![7; stride * 37])));
        let layout = TargetLayout { width: 37, height: 37, format: PixelFormat::Bgra8, stride, origin_top_left };
        let target = Target { layout, sink: image.clone() };
        let mut renderer = Renderer::new(Level::detect());
        pool(3).install(|| renderer.render(&w.scene, &w.frame, Some(&target), &AtomicBool::new(false))).unwrap();
        let bytes = image.0.lock().unwrap();
        for y in 0..37u32 {
            let row = if origin_top_left { 36 - y } else { y } as usize;
            for x in 0..37u32 {
                let [r, g, b, a] = renderer.framebuffer().pixel(x, y).unwrap().color;
                let code = openrt::frame::srgb::encode_srgb8;
                let expected = [code(b), code(g), code(r), (a * 255.0 + 0.5) as u8];
                assert_eq!(bytes[row * stride + x as usize * 4..][..4], expected);
            }
            assert!(bytes[row * stride + 37 * 4..(row + 1) * stride].iter().all(|&b| b == 7));
        }
    }
}

/// Not a test of its own: writes the pictures of this file's scene for people to look at.
#[test]
#[ignore = "writes pictures to the folder in OPENRT_PICTURES"]
fn pictures_to_look_at() {
    let folder = std::env::var("OPENRT_PICTURES").expect("OPENRT_PICTURES names a folder");
    let mut w = zoo(400);
    w.frame.samples = 4;
    w.frame.max_depth = 6;
    for (class, samples) in [("whitted", 4), ("raycast", 1), ("ambient_occlusion", 4), ("path", 64)] {
        w.frame.renderer = w.shader(class, &[]);
        w.frame.samples = samples;
        let mut renderer = Renderer::new(Level::detect());
        let stats = renderer.render(&w.scene, &w.frame, None, &AtomicBool::new(false)).unwrap();
        println!("{class}: {stats:?}");
        let path = std::path::Path::new(&folder).join(format!("{class}.png"));
        openrt::frame::write_image(&path, renderer.framebuffer(), true).unwrap();
    }
}
