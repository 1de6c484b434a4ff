//! The user's programs.

use crate::kit::*;
use glam::{Affine3A, Vec2, Vec3, Vec4};
use openrt::render::Renderer;
use openrt::scene::*;
use openrt::simd::Level;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

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
    let param = |name: &str, ty, scope, default, offset| ParamDef {
        name: name.into(),
        ty,
        scope,
        default,
        choices: &[],
        offset,
    };
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
    w.frame.lights.push(LightUse::new(lamp, Affine3A::IDENTITY));
    let white = w.shader("diffuse", &[("color", grey(1.0))]);
    w.add(quad(Vec3::X * 3.0, Vec3::Y * 9.0, Vec3::Z * 9.0, white));
    let picture = w.render();
    assert_near(picture[0], [0.1, 0.2, 0.3, 0.4], 1e-6);
    assert_near(picture[1], [0.0, 0.0, 0.0, 1.0], 1e-6);
    assert_near(picture[3], [0.25, 0.5, 1.0, 1.0], 1e-6);
    // Under a matrix it is asked in its own space: upside down, it shines on the lower half. (The wall is seen from its left.)
    w.frame.lights[0].world_from_light = Affine3A::from_rotation_x(std::f32::consts::PI);
    let picture = w.render();
    assert_near(picture[1], [0.25, 0.5, 1.0, 1.0], 1e-6);
    assert_near(picture[3], [0.0, 0.0, 0.0, 1.0], 1e-6);
}
