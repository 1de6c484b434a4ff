//! Frames through the public Rust API: what a frame sees, delivery, late binding, capture, frames in flight, queries.

use glam::{DVec3, Vec3, Vec4};
use openrt::Context;
use openrt::api::ErrorCode::{InternalError, InvalidOperation, InvalidValue};
use openrt::api::*;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Barrier, Mutex};
use std::time::Duration;

const SIZE: u32 = 17;

/// A context with a 17×17 framebuffer.
fn context() -> Context {
    let mut cx = Context::with_config(Config::with_threads(2)).expect("a context");
    cx.set_frame_size(SIZE, SIZE).unwrap();
    cx
}

/// A quadrilateral at `z` that fills the default view, and more.
fn wall(cx: &mut Context, z: f32) {
    cx.begin(Primitive::Quads).unwrap();
    for (x, y) in [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)] {
        cx.vertex3(x, y, z).unwrap();
    }
    cx.end().unwrap();
}

fn wall_object(cx: &mut Context, name: Name, z: f32) {
    cx.new_object(name, Mode::Compile, Motion::Affine).unwrap();
    wall(cx, z);
    cx.end_object().unwrap();
}

fn read(cx: &mut Context, kind: PixelKind) -> Vec<u8> {
    let mut bytes = vec![0u8; SIZE as usize * SIZE as usize * kind.bytes_per_pixel()];
    cx.read_pixels(0, 0, SIZE, SIZE, kind, 0, &mut bytes).unwrap();
    bytes
}

fn object_at(cx: &mut Context, x: u32, y: u32) -> u32 {
    let mut bytes = [0; 4];
    cx.read_pixels(x, y, 1, 1, PixelKind::ObjectId, 0, &mut bytes).unwrap();
    u32::from_ne_bytes(bytes)
}

fn center_object(cx: &mut Context) -> u32 {
    object_at(cx, SIZE / 2, SIZE / 2)
}

fn color_at(cx: &mut Context, x: u32, y: u32) -> [f32; 4] {
    let mut bytes = [0; 16];
    cx.read_pixels(x, y, 1, 1, PixelKind::Color(PixelFormat::Rgba32F), 0, &mut bytes).unwrap();
    std::array::from_fn(|i| f32::from_ne_bytes(bytes[4 * i..4 * i + 4].try_into().unwrap()))
}

fn center_color(cx: &mut Context) -> [f32; 4] {
    color_at(cx, SIZE / 2, SIZE / 2)
}

fn center_depth(cx: &mut Context) -> f32 {
    cx.intersect_rays(&[Ray::new(Vec3::ZERO, Vec3::NEG_Z)], false).unwrap()[0].map_or(f32::INFINITY, |hit| hit.t)
}

fn code_of<T>(result: Result<T>) -> Option<ErrorCode> {
    result.err().map(|e| e.code)
}

#[test]
fn instances_are_cleared_each_frame_and_their_matrix_is_the_current_one() {
    let mut cx = context();
    wall_object(&mut cx, 5, -2.0);
    cx.push_matrix().unwrap();
    cx.translate(DVec3::new(0.0, 0.0, -1.0)).unwrap();
    cx.instantiate_object(5).unwrap();
    cx.pop_matrix().unwrap();
    let stats = cx.render().unwrap();
    assert_eq!((stats.instances, stats.triangles), (1, 2));
    assert_eq!(center_object(&mut cx), 5);
    assert_eq!(center_depth(&mut cx), 3.0);
    cx.render().unwrap();
    assert_eq!(center_object(&mut cx), 0);
    assert_eq!(read(&mut cx, PixelKind::InstanceId), vec![255; 4 * (SIZE * SIZE) as usize]);
}

#[test]
fn the_matrix_at_the_vertex_is_baked_in() {
    let mut cx = context();
    cx.translate(DVec3::new(0.0, 0.0, -4.0)).unwrap();
    wall_object(&mut cx, 5, -2.0);
    cx.load_identity().unwrap();
    cx.instantiate_object(5).unwrap();
    cx.render().unwrap();
    assert_eq!(center_depth(&mut cx), 6.0);
}

#[test]
fn compile_and_instantiate_places_once() {
    let mut cx = context();
    cx.new_object(5, Mode::CompileAndInstantiate, Motion::Affine).unwrap();
    wall(&mut cx, -2.0);
    cx.end_object().unwrap();
    assert_eq!(cx.render().unwrap().instances, 1);
    assert_eq!(cx.render().unwrap().instances, 0);
}

#[test]
fn geometry_outside_objects_lives_for_one_frame_and_survives_a_commit() {
    let mut cx = context();
    wall(&mut cx, -2.0);
    cx.commit_scene().unwrap();
    assert_eq!(center_depth(&mut cx), 2.0);
    wall_object(&mut cx, 5, -3.0);
    cx.instantiate_object(5).unwrap();
    wall(&mut cx, -1.0);
    assert_eq!(cx.render().unwrap().triangles, 6);
    assert_eq!(center_object(&mut cx), IMMEDIATE_OBJECT);
    assert_eq!(center_depth(&mut cx), 1.0);
    assert_eq!(cx.render().unwrap().triangles, 0);
    assert_eq!(center_object(&mut cx), 0);
}

#[test]
fn redefinition_shows_in_all_instances_from_the_next_frame_on() {
    let mut cx = context();
    wall_object(&mut cx, 5, -2.0);
    cx.instantiate_object(5).unwrap();
    cx.start_rendering().unwrap();
    wall_object(&mut cx, 5, -7.0);
    cx.instantiate_object(5).unwrap();
    cx.end_rendering().unwrap();
    assert_eq!(center_depth(&mut cx), 2.0);
    cx.render().unwrap();
    assert_eq!(center_depth(&mut cx), 7.0);
}

#[test]
fn a_name_deleted_and_defined_again_between_frames_shows_the_new_geometry() {
    let mut cx = context();
    for z in [-2.0, -3.0, -4.0] {
        wall_object(&mut cx, 5, z);
        cx.instantiate_object(5).unwrap();
        cx.render().unwrap();
        assert_eq!(center_depth(&mut cx), -z);
        cx.delete_objects(5, 1).unwrap();
    }
}

#[test]
fn deleted_objects_stay_in_the_frame_that_shows_them() {
    let mut cx = context();
    wall_object(&mut cx, 5, -2.0);
    cx.instantiate_object(5).unwrap();
    cx.delete_objects(5, 1).unwrap();
    assert_eq!(code_of(cx.instantiate_object(5)), Some(InvalidValue));
    cx.start_rendering().unwrap();
    cx.delete_objects(1, i32::MAX).unwrap();
    cx.end_rendering().unwrap();
    assert_eq!(center_object(&mut cx), 5);
    cx.render().unwrap();
    assert_eq!(center_object(&mut cx), 0);
    // Deleted and defined again before the frame starts: the instance shows the new definition.
    wall_object(&mut cx, 6, -2.0);
    cx.instantiate_object(6).unwrap();
    cx.delete_objects(6, 1).unwrap();
    wall_object(&mut cx, 6, -3.0);
    cx.render().unwrap();
    assert_eq!(center_depth(&mut cx), 3.0);
    cx.instantiate_object(6).unwrap();
    cx.render().unwrap();
    assert_eq!(center_depth(&mut cx), 3.0);
}

#[test]
fn vertices_move_by_the_number_they_were_given() {
    for strategy in [Strategy::Auto].into_iter().chain(Strategy::ALL) {
        let mut cx = context();
        wall_object(&mut cx, 5, -2.0);
        cx.object_parameter(5, ObjectParameter::Strategy(strategy)).unwrap();
        for z in [-2.0, -5.0, -3.0] {
            // Two calls: the corners below, then those above.
            let corners = [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)].map(|(x, y)| Vec3::new(x, y, z));
            cx.update_vertices(5, 0, &corners[..2]).unwrap();
            cx.update_vertices(5, 2, &corners[2..]).unwrap();
            cx.instantiate_object(5).unwrap();
            cx.render().unwrap();
            assert_eq!(center_depth(&mut cx), -z, "{strategy:?}");
        }
    }
}

#[test]
fn typed_meshes_are_drawn_whole_or_not_at_all() {
    let mut cx = context();
    let positions =
        [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0), (0.0, 0.0)].map(|(x, y)| Vec3::new(x, y, -2.0));
    let mesh = TriangleMesh { positions: &positions, triangles: &[[0, 1, 2], [2, 3, 0]], ..TriangleMesh::default() };
    cx.new_object(5, Mode::CompileAndInstantiate, Motion::Unstructured).unwrap();
    for bad in [TriangleMesh { triangles: &[[0, 1, 5]], ..mesh }, TriangleMesh { normals: &[Vec3::Z; 4], ..mesh }] {
        assert_eq!(code_of(cx.draw_mesh(&bad)), Some(InvalidValue));
    }
    cx.draw_mesh(&mesh).unwrap();
    cx.draw_mesh(&TriangleMesh { normals: &[Vec3::Z; 5], ..mesh }).unwrap();
    cx.end_object().unwrap();
    let info = cx.get_object_parameters(5).unwrap();
    assert_eq!((info.vertex_count, info.triangle_count, info.has_normals), (10, 4, true));
    cx.render().unwrap();
    assert!(read(&mut cx, PixelKind::ObjectId).chunks_exact(4).all(|id| id == 5u32.to_ne_bytes()));
}

#[test]
fn degenerate_geometry_and_matrices_harm_nobody() {
    let mut cx = context();
    cx.new_object(7, Mode::Compile, Motion::Affine).unwrap();
    cx.begin(Primitive::Triangles).unwrap();
    for bad in [f32::NAN, f32::INFINITY, f32::MAX, 1e30, 1e-40, -0.0, 0.0] {
        for corner in [Vec4::new(bad, 0.0, -1.0, 1.0), Vec4::new(0.0, bad, -1.0, 1.0), Vec4::new(bad, bad, bad, bad)] {
            cx.vertex(corner).unwrap();
        }
    }
    cx.end().unwrap();
    cx.end_object().unwrap();
    wall_object(&mut cx, 5, -1.0);
    wall_object(&mut cx, 6, -3.0);
    let empty = cx.gen_objects(1).unwrap();
    let scales = [[0.0; 3], [1.0, 1.0, 0.0], [1e-30; 3], [1.8e18; 3], [1e-30, 1e18, 1.0]];
    for strategy in Strategy::ALL {
        for name in 5..8 {
            cx.object_parameter(name, ObjectParameter::Strategy(strategy)).unwrap();
        }
        for scale in scales {
            cx.push_matrix().unwrap();
            // Behind the camera, should anything be left of it.
            cx.translate(DVec3::new(0.0, 0.0, 20.0)).unwrap();
            cx.scale(DVec3::from_array(scale)).unwrap();
            for name in [5, 7, empty] {
                cx.instantiate_object(name).unwrap();
            }
            cx.pop_matrix().unwrap();
        }
        cx.push_matrix().unwrap();
        cx.scale(DVec3::new(-1.0, 1.0, 1.0)).unwrap();
        cx.instantiate_object(6).unwrap();
        cx.pop_matrix().unwrap();
        cx.render().unwrap();
        assert_eq!(center_object(&mut cx), 6, "{strategy:?}");
    }
}

#[test]
fn an_indexed_draw_stores_each_vertex_once_in_the_order_of_the_array() {
    let mut cx = context();
    let corners = [[-9.0f32, -9.0, -2.0], [9.0, -9.0, -2.0], [9.0, 9.0, -2.0], [-9.0, 9.0, -2.0]];
    let bytes: Vec<u8> = corners.iter().flatten().flat_map(|v| v.to_ne_bytes()).collect();
    let positions = VertexArray { size: 3, component: Component::Float, stride: 0, bytes: &bytes };
    let arrays = VertexArrays { positions, normals: None, colors: None, tex_coords: None };
    let indices = Indices::new(Component::UnsignedByte, &[3, 0, 2, 2, 0, 1]).unwrap();
    cx.new_object(5, Mode::CompileAndInstantiate, Motion::Unstructured).unwrap();
    cx.draw_elements(Primitive::Triangles, &arrays, indices).unwrap();
    cx.end_object().unwrap();
    let info = cx.get_object_parameters(5).unwrap();
    assert_eq!((info.vertex_count, info.triangle_count, info.has_normals), (4, 2, false));
    cx.render().unwrap();
    assert!(read(&mut cx, PixelKind::ObjectId).chunks_exact(4).all(|id| id == 5u32.to_ne_bytes()));
    // The same in one go, without indices.
    cx.new_object(6, Mode::CompileAndInstantiate, Motion::Unstructured).unwrap();
    cx.draw_arrays(Primitive::Polygon, &arrays, 0, 4).unwrap();
    cx.end_object().unwrap();
    cx.render().unwrap();
    assert!(read(&mut cx, PixelKind::ObjectId).chunks_exact(4).all(|id| id == 6u32.to_ne_bytes()));
}

/// Shows its parameter block: four floats.
struct ShowParams;

impl SurfaceShader for ShowParams {
    fn shade(&self, params: &[u8], _: &mut dyn ShadingContext) -> Vec4 {
        let float = |i: usize| f32::from_ne_bytes(params[4 * i..4 * i + 4].try_into().unwrap());
        Vec4::new(float(0), float(1), float(2), 1.0)
    }
}

fn float_param(name: &str, scope: ParamScope, offset: u32) -> ParamDef {
    let default = ParamValue::Float([0.0; 4]);
    ParamDef { name: name.into(), ty: ParamType::Float(1), scope, default, choices: &[], offset }
}

fn surface(program: impl SurfaceShader + 'static, params: Vec<ParamDef>) -> ShaderClass {
    let block_size = 4 * params.len() as u32;
    let program = Program::Surface(Arc::new(program));
    ShaderClass { name: "test".into(), kind: ShaderKind::Surface, params, block_size, program }
}

#[test]
fn parameters_are_late_per_shader_and_captured_per_triangle_and_vertex() {
    let mut cx = context();
    let params = vec![
        float_param("late", ParamScope::Shader, 0),
        float_param("triangle", ParamScope::Triangle, 4),
        float_param("vertex", ParamScope::Vertex, 8),
    ];
    cx.register_shader_class(surface(ShowParams, params)).unwrap();
    let shader = cx.gen_new_shader().unwrap();
    let [late, triangle, vertex] = ["late", "triangle", "vertex"].map(|n| cx.parameter_handle(n).unwrap());
    cx.new_object(5, Mode::CompileAndInstantiate, Motion::Affine).unwrap();
    cx.begin(Primitive::Triangles).unwrap();
    // Left triangle, then right; `vertex` grows from bottom to top.
    for (t, x) in [(1.0, -9.0), (2.0, 9.0)] {
        for (v, px, py) in [(0.0, 0.0, -9.0), (0.0, x, -9.0), (18.0, 0.0, 9.0)] {
            cx.parameter_f(vertex, &[v]).unwrap();
            // Set before the triangle's last vertex is what counts.
            cx.parameter_f(triangle, &[if py > 0.0 { t } else { 77.0 }]).unwrap();
            cx.vertex3(px, py, -9.0).unwrap();
        }
    }
    cx.end().unwrap();
    cx.end_object().unwrap();
    // Too late for what was captured, in time for what is late.
    cx.parameter_f(triangle, &[5.0]).unwrap();
    cx.parameter_f(vertex, &[5.0]).unwrap();
    cx.parameter_f(late, &[1.0]).unwrap();
    cx.parameter_f(late, &[3.0]).unwrap();
    cx.start_rendering().unwrap();
    cx.bind_shader(shader).unwrap();
    cx.parameter_f(late, &[4.0]).unwrap();
    cx.instantiate_object(5).unwrap();
    cx.end_rendering().unwrap();
    let (left, right) = (color_at(&mut cx, 7, 8), color_at(&mut cx, 9, 8));
    assert_eq!((left[0], left[1], right[0], right[1]), (3.0, 1.0, 3.0, 2.0));
    assert!((left[2] - 9.0).abs() < 1e-4 && (right[2] - 9.0).abs() < 1e-4, "{left:?} {right:?}");
    cx.render().unwrap();
    assert_eq!(color_at(&mut cx, 7, 8)[0], 4.0);
    // Deleted: the default surface.
    cx.delete_shader(shader).unwrap();
    cx.instantiate_object(5).unwrap();
    cx.render().unwrap();
    assert_ne!(color_at(&mut cx, 7, 8)[0], 4.0);
}

#[test]
fn attributes_reach_the_shader() {
    struct Show;
    impl SurfaceShader for Show {
        fn shade(&self, _: &[u8], cx: &mut dyn ShadingContext) -> Vec4 {
            let p = cx.point();
            Vec4::new(p.normal.x, p.tex_coord.x, p.color.x, 1.0)
        }
    }
    let mut cx = context();
    cx.register_shader_class(surface(Show, vec![])).unwrap();
    cx.gen_new_shader().unwrap();
    cx.color(Vec4::new(0.25, 0.0, 0.0, 1.0)).unwrap();
    wall(&mut cx, -2.0);
    cx.render().unwrap();
    assert_eq!(center_color(&mut cx)[..3], [0.0, 0.0, 0.25], "no normal: the geometric one");
    // Scaled by 2 in x, a normal leans half as much.
    cx.scale(DVec3::new(2.0, 1.0, 1.0)).unwrap();
    cx.normal(Vec3::new(1.0, 0.0, 1.0)).unwrap();
    cx.tex_coord(Vec4::new(1.0, 0.0, 0.0, 2.0)).unwrap();
    wall(&mut cx, -2.0);
    cx.render().unwrap();
    let color = center_color(&mut cx);
    assert!((color[0] - (0.5f32 / 1.25f32.sqrt())).abs() < 1e-6, "{color:?}");
    assert_eq!(color[1], 0.5);
    // A definition starts without a normal.
    cx.new_object(5, Mode::CompileAndInstantiate, Motion::Affine).unwrap();
    wall(&mut cx, -2.0);
    cx.end_object().unwrap();
    cx.render().unwrap();
    assert_eq!(center_color(&mut cx)[0], 0.0);
}

#[test]
fn lights_persist_until_a_later_frame_names_its_own() {
    let mut cx = context();
    cx.gen_new_shader_class("ambient").unwrap();
    let (a, b) = (cx.gen_new_shader().unwrap(), cx.gen_new_shader().unwrap());
    let lights = |cx: &Context| cx.get_lights().unwrap().iter().map(|light| light.shader).collect::<Vec<_>>();
    cx.use_light(a).unwrap();
    cx.use_light(b).unwrap();
    cx.render().unwrap();
    assert_eq!(lights(&cx), [a, b]);
    cx.use_light(b).unwrap();
    assert_eq!(lights(&cx), [b]);
    assert_eq!(code_of(cx.use_light(b)), Some(InvalidOperation));
    cx.use_light(0).unwrap();
    cx.use_light(b).unwrap();
    assert_eq!(lights(&cx), [b]);
    // Under another matrix it is another light.
    cx.translate(DVec3::X).unwrap();
    cx.use_light(b).unwrap();
    assert_eq!(code_of(cx.use_light(b)), Some(InvalidOperation));
    assert_eq!(lights(&cx), [b, b]);
    cx.load_matrix(2.0 * glam::DMat4::IDENTITY).unwrap();
    assert_eq!(code_of(cx.use_light(a)), Some(InvalidOperation));
}

/// Application memory.
struct Memory(Mutex<Vec<u8>>);

impl PixelSink for Memory {
    fn write(&self, offset: usize, bytes: &[u8]) {
        self.0.lock().unwrap()[offset..offset + bytes.len()].copy_from_slice(bytes);
    }
}

#[test]
fn pixels_are_delivered_within_the_rows_and_either_side_up() {
    for top_left in [false, true] {
        let mut cx = context();
        let stride = SIZE as usize * 3 + 5;
        let memory = Arc::new(Memory(Mutex::new(vec![0xAB; stride * SIZE as usize])));
        let layout =
            TargetLayout { width: SIZE, height: SIZE, format: PixelFormat::Rgb8, stride, origin_top_left: false };
        cx.set_frame_buffer(Some(Target { layout, sink: memory.clone() })).unwrap();
        cx.gen_new_shader_class("constant").unwrap();
        cx.gen_new_shader().unwrap();
        if top_left {
            cx.enable(Capability::OriginTopLeft).unwrap();
        }
        // The upper half of the picture.
        cx.begin(Primitive::Quads).unwrap();
        for (x, y) in [(-9.0, 0.0), (9.0, 0.0), (9.0, 9.0), (-9.0, 9.0)] {
            cx.vertex3(x, y + 0.01, -2.0).unwrap();
        }
        cx.end().unwrap();
        cx.render().unwrap();
        let bytes = memory.0.lock().unwrap().clone();
        let mut read = vec![0xAB; bytes.len()];
        cx.read_pixels(0, 0, SIZE, SIZE, PixelKind::Color(PixelFormat::Rgb8), stride, &mut read).unwrap();
        assert_eq!(bytes, read, "both ways give the same bytes, and neither touches the gap");
        let row = |y: usize| bytes[y * stride];
        assert_eq!((row(0), row(16)), if top_left { (255, 0) } else { (0, 255) });
        assert!(bytes.chunks(stride).all(|row| row[SIZE as usize * 3..] == [0xAB; 5]));
        let y = if top_left { 2.5 } else { 14.5 };
        assert!(cx.pick(8.5, y).unwrap().is_some() && cx.pick(8.5, 17.0 - y).unwrap().is_none());
    }
}

#[test]
fn read_pixels_checks_the_rectangle_and_the_memory() {
    let mut cx = context();
    cx.render().unwrap();
    let mut out = [0; 64];
    let mut read =
        |x, y, w, h, stride, n: usize| code_of(cx.read_pixels(x, y, w, h, PixelKind::Depth, stride, &mut out[..n]));
    assert_eq!(read(1, 1, 4, 4, 0, 64), None);
    assert_eq!(read(1, 1, 4, 4, 0, 63), Some(InvalidValue));
    assert_eq!(read(SIZE - 3, 1, 4, 4, 0, 64), Some(InvalidValue));
    assert_eq!(read(u32::MAX, 1, 4, 4, 0, 64), Some(InvalidValue));
    assert_eq!(read(1, 1, u32::MAX, u32::MAX, 0, 64), Some(InvalidValue));
    assert_eq!(read(1, 1, 4, 4, 15, 64), Some(InvalidValue));
    assert_eq!(read(1, 1, 4, 4, usize::MAX, 64), Some(InvalidValue));
    assert_eq!(read(1, 1, 0, 4, 0, 0), None);
}

/// Blocks a frame until told to go on.
struct Gate {
    entered: Barrier,
    open: Barrier,
    once: AtomicBool,
}

impl Gate {
    fn new() -> Arc<Self> {
        Arc::new(Self { entered: Barrier::new(2), open: Barrier::new(2), once: AtomicBool::new(true) })
    }
}

struct GateShader(Arc<Gate>);

impl SurfaceShader for GateShader {
    fn shade(&self, _: &[u8], _: &mut dyn ShadingContext) -> Vec4 {
        if self.0.once.swap(false, Ordering::SeqCst) {
            self.0.entered.wait();
            self.0.open.wait();
        }
        Vec4::ONE
    }
}

#[test]
fn one_frame_renders_while_the_next_is_assembled() {
    let gate = Gate::new();
    let mut cx = context();
    let calls = Arc::new(AtomicU32::new(0));
    let seen = calls.clone();
    let main = std::thread::current().id();
    cx.frame_callback(Some(Arc::new(move |outcome| {
        assert!(outcome.is_ok());
        assert_ne!(std::thread::current().id(), main);
        seen.fetch_add(1, Ordering::SeqCst);
    })))
    .unwrap();
    cx.register_shader_class(surface(GateShader(gate.clone()), vec![])).unwrap();
    cx.gen_new_shader().unwrap();
    wall(&mut cx, -2.0);
    cx.start_rendering().unwrap();
    gate.entered.wait();
    // The frame stands still in a shader now.
    assert!(!cx.is_frame_done().unwrap());
    assert!(!cx.wait_frame(Duration::from_millis(1)).unwrap());
    assert_eq!(code_of(cx.start_rendering()), Some(InvalidOperation));
    wall_object(&mut cx, 5, -3.0);
    cx.instantiate_object(5).unwrap();
    assert_eq!(cx.get(State::InstanceCount).unwrap().as_slice(), [1.0]);
    assert_eq!(calls.load(Ordering::SeqCst), 0);
    gate.open.wait();
    assert!(cx.wait_frame(Duration::from_secs(600)).unwrap());
    assert!(cx.is_frame_done().unwrap());
    cx.end_rendering().unwrap();
    assert_eq!(calls.load(Ordering::SeqCst), 1);
    assert_eq!(code_of(cx.end_rendering()), Some(InvalidOperation));
    assert_eq!(center_object(&mut cx), IMMEDIATE_OBJECT);
    cx.swap_buffers().unwrap();
    assert_eq!((center_object(&mut cx), calls.load(Ordering::SeqCst)), (5, 2));
}

#[test]
fn queries_wait_for_the_frame_in_flight_and_it_can_still_be_ended() {
    let mut cx = context();
    wall_object(&mut cx, 5, -2.0);
    cx.instantiate_object(5).unwrap();
    cx.start_rendering().unwrap();
    assert_eq!(center_depth(&mut cx), 2.0);
    assert_eq!(cx.end_rendering().unwrap().instances, 1);
}

#[test]
fn a_cancelled_frame_ends_and_says_so() {
    let gate = Gate::new();
    let mut cx = context();
    cx.set_frame_size(512, 512).unwrap();
    cx.register_shader_class(surface(GateShader(gate.clone()), vec![])).unwrap();
    cx.gen_new_shader().unwrap();
    wall(&mut cx, -2.0);
    cx.start_rendering().unwrap();
    gate.entered.wait();
    // A second worker may have taken tiles; it cannot have done them all before this.
    let handle = cx.cancel_handle();
    std::thread::spawn(move || handle.cancel()).join().unwrap();
    gate.open.wait();
    let stats = cx.end_rendering().unwrap();
    assert!(stats.cancelled || stats.primary_rays == 512 * 512, "{stats:?}");
    // The flag is lowered by the next frame.
    wall(&mut cx, -2.0);
    assert!(!cx.render().unwrap().cancelled);
}

#[test]
fn dropping_a_context_waits_for_its_frame() {
    struct Slow(Arc<AtomicBool>);
    impl PixelSink for Slow {
        fn write(&self, _: usize, _: &[u8]) {
            assert!(!self.0.load(Ordering::SeqCst), "written after the context was dropped");
            std::thread::sleep(Duration::from_millis(1));
        }
    }
    let gone = Arc::new(AtomicBool::new(false));
    let mut cx = context();
    let layout =
        TargetLayout { width: 64, height: 64, format: PixelFormat::Rgba8, stride: 256, origin_top_left: false };
    let sink = Arc::new(Slow(gone.clone()));
    cx.set_frame_buffer(Some(Target { layout, sink: sink.clone() })).unwrap();
    cx.start_rendering().unwrap();
    drop(cx);
    gone.store(true, Ordering::SeqCst);
    std::thread::sleep(Duration::from_millis(20));
    assert_eq!(Arc::strong_count(&sink), 1, "the frame has let go of the memory");
}

#[test]
fn a_panicking_shader_poisons_the_context_and_nothing_else() {
    struct Broken;
    impl SurfaceShader for Broken {
        fn shade(&self, _: &[u8], _: &mut dyn ShadingContext) -> Vec4 {
            panic!("a broken shader, on purpose");
        }
    }
    let mut cx = context();
    cx.register_shader_class(surface(Broken, vec![])).unwrap();
    cx.gen_new_shader().unwrap();
    wall(&mut cx, -2.0);
    cx.start_rendering().unwrap();
    let error = cx.end_rendering().unwrap_err();
    assert_eq!(error.code, InternalError);
    assert!(error.message.contains("on purpose"), "{error}");
    assert!(cx.is_poisoned());
    assert_eq!(code_of(cx.push_matrix()), Some(InternalError));
    assert_eq!(code_of(cx.vertex3(0.0, 0.0, 0.0)), Some(InternalError));
    assert_eq!(code_of(cx.render()), Some(InternalError));
    assert_eq!(cx.get_error(), InternalError);
    drop(cx);
    context().render().unwrap();
}

#[test]
fn queries_see_what_was_committed() {
    let mut cx = context();
    let down = Ray::new(Vec3::ZERO, Vec3::NEG_Z);
    assert_eq!(cx.intersect_rays(&[down], false).unwrap(), [None]);
    assert_eq!(code_of(cx.pick(1.0, 1.0)), Some(InvalidOperation));
    wall_object(&mut cx, 5, -2.0);
    cx.instantiate_object(5).unwrap();
    assert_eq!(cx.intersect_rays(&[down], false).unwrap(), [None]);
    assert_eq!(cx.commit_scene().unwrap().instances, 1);
    let hit = cx.intersect_rays(&[down], true).unwrap()[0].expect("a hit");
    assert_eq!((hit.object, hit.instance, hit.t), (5, 0, 2.0));
    assert!(cx.pick(8.5, 8.5).unwrap().is_some());
    assert_eq!(code_of(cx.read_pixels(0, 0, 1, 1, PixelKind::Depth, 0, &mut [0; 4])), Some(InvalidOperation));
    // A batch longer than any chunk, with rays that cannot hit among them.
    let bad = [
        Ray::new(Vec3::NAN, Vec3::NEG_Z),
        Ray::new(Vec3::ZERO, Vec3::ZERO),
        Ray::new(Vec3::ZERO, Vec3::splat(f32::INFINITY)),
        Ray { tmax: 1.0, ..down },
        Ray { tmin: f32::NAN, tmax: f32::NAN, ..down },
    ];
    let rays: Vec<Ray> = (0..5000).map(|i| if i % 7 == 0 { bad[i / 7 % bad.len()] } else { down }).collect();
    for coherent in [false, true] {
        let hits = cx.intersect_rays(&rays, coherent).unwrap();
        let occluded = cx.occluded_rays(&rays, coherent).unwrap();
        for i in 0..rays.len() {
            assert_eq!(hits[i], (i % 7 != 0).then_some(hit), "ray {i}");
            assert_eq!(occluded[i], i % 7 != 0, "ray {i}");
        }
    }
    // The commit has not begun a new frame.
    assert_eq!(cx.render().unwrap().instances, 1);
}

#[test]
fn helper_cameras_show_what_opengl_would() {
    let mut cx = context();
    wall_object(&mut cx, 5, 0.0);
    let eye = DVec3::new(0.0, 0.0, 9.0);
    cx.look_at(eye, DVec3::ZERO, DVec3::Y).unwrap();
    // The window at distance 9 is 9 high: half the wall's height.
    let corners = |cx: &mut Context| {
        cx.instantiate_object(5).unwrap();
        cx.render().unwrap();
        [(0, 0), (SIZE - 1, 0), (0, SIZE - 1), (SIZE - 1, SIZE - 1)].map(|(x, y)| object_at(cx, x, y) == 5)
    };
    cx.perspective(2.0 * 0.5f64.atan().to_degrees(), 1.0, 0.1, 100.0).unwrap();
    assert_eq!(corners(&mut cx), [true; 4]);
    let wide = 2.0 * 1.2f64.atan().to_degrees();
    cx.perspective(wide, 1.0, 0.1, 100.0).unwrap();
    assert_eq!(corners(&mut cx), [false; 4]);
    // Off the axis, given on the near plane: the right half looks past the wall.
    cx.frustum(-0.1, 0.3, -0.1, 0.1, 0.2, 100.0).unwrap();
    assert_eq!(corners(&mut cx), [true, false, true, false]);
    cx.ortho(-8.0, 8.0, -10.0, 8.0, -1.0, 1.0).unwrap();
    assert_eq!(corners(&mut cx), [false, false, true, true]);
    cx.look_at(eye + DVec3::Y * 3.0, DVec3::Y * 3.0, DVec3::Y).unwrap();
    assert_eq!(corners(&mut cx), [true, true, false, false]);
    // An explicit camera wins until a helper is called again.
    cx.gen_new_shader_class("pinhole").unwrap();
    let camera = cx.gen_new_shader().unwrap();
    for (name, z) in [("eye", -1.0), ("center", -2.0)] {
        let handle = cx.parameter_handle(name).unwrap();
        cx.parameter_f(handle, &[0.0, 0.0, z]).unwrap();
    }
    cx.use_camera(camera).unwrap();
    assert_eq!(corners(&mut cx), [false; 4], "the wall is behind it");
    cx.use_camera(0).unwrap();
    assert_eq!(corners(&mut cx), [true, true, false, false]);
}

#[test]
fn textures_are_seen_by_shaders_and_gone_when_deleted() {
    let mut cx = context();
    let texture = cx.gen_textures(1).unwrap();
    cx.bind_texture(texture).unwrap();
    let image =
        ImageDesc { width: 1, height: 1, format: ImageFormat::Rgb, component: Component::UnsignedByte, row_stride: 0 };
    cx.tex_image_2d(0, &image, Some(&[255, 0, 51])).unwrap();
    cx.gen_new_shader_class("constant").unwrap();
    cx.gen_new_shader().unwrap();
    let handle = cx.parameter_handle("texture").unwrap();
    cx.parameter_i(handle, &[texture as i32]).unwrap();
    let shown = |cx: &mut Context| {
        wall(cx, -2.0);
        cx.render().unwrap();
        center_color(cx)
    };
    assert_eq!(shown(&mut cx)[..3], [1.0, 0.0, 0.2]);
    cx.tex_parameter(TextureParameter::Format(TextureFormat::Srgb)).unwrap();
    assert!((shown(&mut cx)[2] - 0.0331).abs() < 1e-4);
    cx.tex_image_2d(0, &image, Some(&[0, 255, 0])).unwrap();
    assert_eq!(shown(&mut cx)[..3], [0.0, 1.0, 0.0]);
    cx.delete_textures(&[texture]).unwrap();
    assert_eq!(shown(&mut cx)[..3], [1.0, 1.0, 1.0]);
}

#[test]
fn winding_of_strips_is_consistent() {
    struct Side;
    impl SurfaceShader for Side {
        fn shade(&self, _: &[u8], cx: &mut dyn ShadingContext) -> Vec4 {
            Vec4::splat(if cx.point().back_facing { 0.5 } else { 1.0 })
        }
    }
    let mut cx = context();
    cx.register_shader_class(surface(Side, vec![])).unwrap();
    cx.gen_new_shader().unwrap();
    for primitive in [Primitive::TriangleStrip, Primitive::QuadStrip] {
        cx.begin(primitive).unwrap();
        for i in 0..20 {
            // Zig-zag from below to above, to the right.
            cx.vertex3((i / 2) as f32 * 2.0 - 9.0, if i % 2 == 0 { 9.0 } else { -9.0 }, -2.0).unwrap();
        }
        cx.end().unwrap();
        cx.render().unwrap();
        let colors = read(&mut cx, PixelKind::Color(PixelFormat::Rgb32F));
        assert!(colors.chunks_exact(4).all(|c| c == 1.0f32.to_ne_bytes()), "{primitive:?}");
    }
}
