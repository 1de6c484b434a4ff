//! The state machine through the public Rust API: OpenGL's rules, and that a refused call changes nothing.

use glam::{DVec3, Vec4};
use openrt::Context;
use openrt::api::*;

fn context() -> Context {
    Context::with_config(Config::with_threads(2)).expect("a context")
}

/// One triangle that covers the middle of the default view, at z = −2.
fn triangle(cx: &mut Context, name: Name) {
    cx.new_object(name, Mode::Compile, Motion::Affine).unwrap();
    cx.begin(Primitive::Triangles).unwrap();
    for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (0.0, 1.0)] {
        cx.vertex3(x, y, -2.0).unwrap();
    }
    cx.end().unwrap();
    cx.end_object().unwrap();
}

fn object_ids(cx: &mut Context) -> Vec<u32> {
    let [w, h] = cx.frame_size().unwrap();
    let mut bytes = vec![0u8; (w * h * 4) as usize];
    cx.read_pixels(0, 0, w, h, PixelKind::ObjectId, 0, &mut bytes).unwrap();
    bytes.chunks_exact(4).map(|b| u32::from_ne_bytes(b.try_into().unwrap())).collect()
}

#[test]
fn a_triangle_is_rendered_and_instances_are_cleared() {
    let mut cx = context();
    cx.set_frame_size(33, 33).unwrap();
    let name = cx.gen_objects(1).unwrap();
    triangle(&mut cx, name);
    cx.instantiate_object(name).unwrap();
    let stats = cx.render().unwrap();
    assert_eq!((stats.instances, stats.triangles), (1, 1));
    assert_eq!(object_ids(&mut cx)[16 * 33 + 16], name);
    cx.render().unwrap();
    assert!(object_ids(&mut cx).iter().all(|&id| id == 0));
}

#[test]
fn geometry_outside_objects_lives_for_one_frame() {
    let mut cx = context();
    cx.set_frame_size(9, 9).unwrap();
    cx.begin(Primitive::Quads).unwrap();
    for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
        cx.vertex(Vec4::new(x, y, -1.0, 1.0)).unwrap();
    }
    cx.end().unwrap();
    cx.render().unwrap();
    assert!(object_ids(&mut cx).iter().all(|&id| id == IMMEDIATE_OBJECT));
    cx.render().unwrap();
    assert!(object_ids(&mut cx).iter().all(|&id| id == 0));
}

#[test]
fn errors_stick_until_read() {
    let mut cx = context();
    let error = cx.pop_matrix().unwrap_err();
    cx.latch(error);
    let error = cx.end().unwrap_err();
    cx.latch(error);
    assert_eq!(cx.get_error(), ErrorCode::StackUnderflow);
    assert_eq!(cx.get_error(), ErrorCode::NoError);
    cx.translate(DVec3::X).unwrap();
}
