//! The state machine through the public Rust API: OpenGL's rules, limits, and that a refused call changes nothing.

use glam::{DMat4, DVec3, Vec3, Vec4};
use openrt::Context;
use openrt::api::ErrorCode::{InvalidOperation, InvalidValue, NoError, OutOfMemory, StackOverflow, StackUnderflow};
use openrt::api::*;
use std::sync::{Arc, Mutex};

fn context() -> Context {
    Context::with_config(Config::with_threads(2)).expect("a context")
}

/// One triangle around the z axis at z = −2.
fn triangle(cx: &mut Context, name: Name) {
    cx.new_object(name, Mode::Compile, Motion::Affine).unwrap();
    cx.begin(Primitive::Triangles).unwrap();
    for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (0.0, 1.0)] {
        cx.vertex3(x, y, -2.0).unwrap();
    }
    cx.end().unwrap();
    cx.end_object().unwrap();
}

/// Everything that can be asked for, and what is known of object 1.
fn snapshot(cx: &Context) -> String {
    let state: Vec<_> = State::ALL.iter().map(|&s| (s, cx.get(s).unwrap())).collect();
    let object = cx.get_object_parameters(1);
    format!("{state:?} {object:?} {:?} {:?}", cx.get_tex_parameters(), cx.get_lights())
}

/// A context with one of everything, nothing of which has its default value.
fn furnished() -> Context {
    let mut cx = context();
    let object = cx.gen_objects(3).unwrap();
    triangle(&mut cx, object);
    cx.push_matrix().unwrap();
    cx.translate(DVec3::new(1.0, 2.0, 3.0)).unwrap();
    cx.instantiate_object(object).unwrap();
    cx.color(Vec4::new(0.1, 0.2, 0.3, 0.4)).unwrap();
    cx.normal(Vec3::X).unwrap();
    cx.tex_coord(Vec4::new(0.5, 0.25, 0.0, 1.0)).unwrap();
    cx.gen_new_shader_class("point").unwrap();
    let light = cx.gen_new_shader().unwrap();
    cx.use_light(light).unwrap();
    cx.gen_new_shader_class("diffuse").unwrap();
    cx.gen_new_shader().unwrap();
    cx.bind_texture(7).unwrap();
    cx.viewport(1, 2, 30, 20).unwrap();
    cx.clear_color([0.1, 0.2, 0.3, 1.0]).unwrap();
    cx.samples_per_pixel(4).unwrap();
    cx.frame_parameter(FrameParameter::Subsampling(2)).unwrap();
    cx
}

type Call = fn(&mut Context) -> Result<()>;

fn void<T>(result: Result<T>) -> Result<()> {
    result.map(|_| ())
}

/// name, call, code outside, between begin and end, inside an object; `None` is success. The bound shader is 2 (`diffuse`), the
/// light is 1, and the bound texture 7.
#[rustfmt::skip]
fn table() -> Vec<(&'static str, Call, [ErrorCode; 3])> {
    const OP: ErrorCode = InvalidOperation;
    const VAL: ErrorCode = InvalidValue;
    const OK: ErrorCode = NoError;
    vec![
        ("gen_objects(0)", |c| void(c.gen_objects(0)), [VAL, OP, VAL]),
        ("gen_objects(-1)", |c| void(c.gen_objects(-1)), [VAL, OP, VAL]),
        ("new_object(0)", |c| c.new_object(0, Mode::Compile, Motion::Static), [VAL, OP, OP]),
        ("new_object(reserved)", |c| c.new_object(u32::MAX, Mode::Compile, Motion::Static), [VAL, OP, OP]),
        ("end_object", |c| c.end_object(), [OP, OP, OK]),
        ("delete_objects(1, -1)", |c| c.delete_objects(1, -1), [VAL, OP, VAL]),
        ("delete_objects(0, 0)", |c| c.delete_objects(0, 0), [OK, OP, OK]),
        ("is_object", |c| void(c.is_object(1)), [OK, OP, OK]),
        ("object_parameter(unknown)", |c| c.object_parameter(99, ObjectParameter::Motion(Motion::Static)), [VAL, OP, VAL]),
        ("get_object_parameters(unknown)", |c| void(c.get_object_parameters(99)), [VAL, OP, VAL]),
        ("update_vertices(unknown)", |c| c.update_vertices(99, 0, &[Vec3::ZERO]), [VAL, OP, VAL]),
        ("update_vertices(too many)", |c| c.update_vertices(1, 2, &[Vec3::ZERO; 2]), [VAL, OP, VAL]),
        ("update_vertices(beyond)", |c| c.update_vertices(1, u32::MAX, &[]), [VAL, OP, VAL]),
        ("update_normals(without)", |c| c.update_normals(1, 0, &[Vec3::ZERO]), [OP, OP, OP]),
        ("begin", |c| { c.begin(Primitive::Quads)?; c.end() }, [OK, OP, OK]),
        ("end", |c| c.end(), [OP, OK, OP]),
        ("vertex", |c| c.vertex3(0.0, 0.0, 0.0), [OP, OK, OP]),
        ("push_matrix", |c| { c.push_matrix()?; c.pop_matrix() }, [OK, OP, OK]),
        ("pop_matrix twice", |c| { c.pop_matrix()?; c.pop_matrix().inspect_err(|_| { c.push_matrix().unwrap(); c.translate(DVec3::new(1.0, 2.0, 3.0)).unwrap(); }) }, [StackUnderflow, OP, StackUnderflow]),
        ("load_matrix(NaN)", |c| c.load_matrix(DMat4::NAN), [VAL, OP, VAL]),
        ("mult_matrix(NaN)", |c| c.mult_matrix(DMat4::NAN), [VAL, OP, VAL]),
        ("translate(inf)", |c| c.translate(DVec3::INFINITY), [VAL, OP, VAL]),
        ("scale(1e39)", |c| c.scale(DVec3::splat(1e39)), [VAL, OP, VAL]),
        ("scale(1)", |c| c.scale(DVec3::ONE), [OK, OP, OK]),
        ("rotate(0 axis)", |c| c.rotate(1.0, DVec3::ZERO), [VAL, OP, VAL]),
        ("rotate(inf)", |c| c.rotate(f64::INFINITY, DVec3::X), [VAL, OP, VAL]),
        ("instantiate_object(unknown)", |c| c.instantiate_object(99), [VAL, OP, VAL]),
        ("instantiate_object(0)", |c| c.instantiate_object(0), [VAL, OP, VAL]),
        ("use_light(unknown)", |c| c.use_light(99), [VAL, OP, VAL]),
        ("use_light(surface)", |c| c.use_light(2), [OP, OP, OP]),
        ("use_light(twice)", |c| c.use_light(1), [OP, OP, OP]),
        ("use_camera(unknown)", |c| c.use_camera(99), [VAL, OP, VAL]),
        ("use_camera(light)", |c| c.use_camera(1), [OP, OP, OP]),
        ("use_environment_shader(light)", |c| c.use_environment_shader(1), [OP, OP, OP]),
        ("use_rendering_object(light)", |c| c.use_rendering_object(1), [OP, OP, OP]),
        ("use_rendering_object(unknown)", |c| c.use_rendering_object(99), [VAL, OP, VAL]),
        ("clear_color(NaN)", |c| c.clear_color([f32::NAN; 4]), [VAL, OP, VAL]),
        ("perspective(180)", |c| c.perspective(180.0, 1.0, 0.1, 1.0), [VAL, OP, VAL]),
        ("perspective(NaN)", |c| c.perspective(f64::NAN, 1.0, 0.1, 1.0), [VAL, OP, VAL]),
        ("perspective(near > far)", |c| c.perspective(60.0, 1.0, 2.0, 1.0), [VAL, OP, VAL]),
        ("frustum(near 0)", |c| c.frustum(-1.0, 1.0, -1.0, 1.0, 0.0, 1.0), [VAL, OP, VAL]),
        ("ortho(empty)", |c| c.ortho(1.0, 1.0, -1.0, 1.0, 0.0, 1.0), [VAL, OP, VAL]),
        ("look_at(eye = centre)", |c| c.look_at(DVec3::ONE, DVec3::ONE, DVec3::Y), [VAL, OP, VAL]),
        ("look_at(up along the view)", |c| c.look_at(DVec3::ZERO, DVec3::Y, DVec3::Y), [VAL, OP, VAL]),
        ("gen_new_shader_class(unknown)", |c| void(c.gen_new_shader_class("teapot")), [VAL, OP, VAL]),
        ("bind_shader_class(unknown)", |c| c.bind_shader_class(99), [VAL, OP, VAL]),
        ("bind_shader(unknown)", |c| c.bind_shader(99), [VAL, OP, VAL]),
        ("delete_shader(unknown)", |c| c.delete_shader(99), [VAL, OP, VAL]),
        ("delete_shader(0)", |c| c.delete_shader(0), [OK, OP, OK]),
        ("parameter_handle(unknown)", |c| void(c.parameter_handle("teapot")), [VAL, OP, VAL]),
        ("parameter_f(0)", |c| c.parameter_f(0, &[1.0]), [VAL, VAL, VAL]),
        ("parameter_f(unknown)", |c| c.parameter_f(9999, &[1.0]), [VAL, VAL, VAL]),
        ("parameter_f(of the light)", |c| c.parameter_f(1, &[1.0; 3]), [OP, OP, OP]),
        ("parameter_f(too few)", |c| c.parameter_f(4, &[1.0; 2]), [OP, OP, OP]),
        ("parameter_f(none)", |c| c.parameter_f(4, &[]), [OP, OP, OP]),
        ("parameter_f(NaN)", |c| c.parameter_f(4, &[f32::NAN; 3]), [VAL, VAL, VAL]),
        ("parameter_i(a float)", |c| c.parameter_i(4, &[1; 3]), [OP, OP, OP]),
        ("parameter_matrix(a float)", |c| c.parameter_matrix(4, &[0.0; 16]), [OP, OP, OP]),
        ("parameter_string(a float)", |c| c.parameter_string(4, "x"), [OP, OP, OP]),
        ("parameter_raw(wrong size)", |c| c.parameter_raw(4, &[0; 11]), [OP, OP, OP]),
        ("parameter_raw(NaN)", |c| c.parameter_raw(4, &[255; 12]), [VAL, VAL, VAL]),
        ("parameter_texture(a float)", |c| c.parameter_texture(4, 0), [OP, OP, OP]),
        ("parameter_texture(unknown)", |c| c.parameter_texture(6, 99), [VAL, VAL, VAL]),
        ("parameter_i(unknown texture)", |c| c.parameter_i(6, &[-1]), [VAL, VAL, VAL]),
        ("gen_textures(0)", |c| void(c.gen_textures(0)), [VAL, OP, VAL]),
        ("bind_texture(reserved)", |c| c.bind_texture(u32::MAX), [VAL, OP, VAL]),
        ("delete_textures(unknown)", |c| c.delete_textures(&[0, 99, u32::MAX]), [OK, OP, OK]),
        ("tex_parameter(mip-mapped magnification)", |c| c.tex_parameter(TextureParameter::MagFilter(Filter::LinearMipmapLinear)), [VAL, OP, VAL]),
        ("load_texture(missing)", |c| void(c.load_texture("/nonexistent/x.png")), [ErrorCode::Io, OP, ErrorCode::Io]),
        ("set_frame_size(0)", |c| c.set_frame_size(0, 4), [VAL, OP, VAL]),
        ("set_frame_size(huge)", |c| c.set_frame_size(4, u32::MAX), [VAL, OP, VAL]),
        ("viewport(negative)", |c| c.viewport(0, -1, 4, 4), [VAL, OP, VAL]),
        ("viewport(huge)", |c| c.viewport(i32::MAX, 0, i32::MAX, 4), [VAL, OP, VAL]),
        ("end_rendering", |c| void(c.end_rendering()), [OP, OP, OP]),
        ("read_pixels(before a frame)", |c| c.read_pixels(0, 0, 1, 1, PixelKind::Depth, 0, &mut [0; 4]), [OP, OP, OP]),
        ("write_image(before a frame)", |c| c.write_image("/nonexistent/x.png"), [OP, OP, OP]),
        ("pick(before a frame)", |c| void(c.pick(0.0, 0.0)), [OP, OP, OP]),
        ("pick(NaN)", |c| void(c.pick(f32::NAN, 0.0)), [VAL, OP, OP]),
        ("intersect_rays(none)", |c| void(c.intersect_rays(&[], true)), [OK, OP, OP]),
        ("samples_per_pixel(0)", |c| c.samples_per_pixel(0), [VAL, OP, VAL]),
        ("samples_per_pixel(huge)", |c| c.samples_per_pixel(i32::MAX), [VAL, OP, VAL]),
        ("max_depth(-1)", |c| c.max_depth(-1), [VAL, OP, VAL]),
        ("frame_parameter(no pixels)", |c| c.frame_parameter(FrameParameter::Subsampling(0)), [VAL, OP, VAL]),
        ("frame_parameter(too many)", |c| c.frame_parameter(FrameParameter::Subsampling(i32::MAX)), [VAL, OP, VAL]),
        ("frame_parameter(no cycle)", |c| c.frame_parameter(FrameParameter::Frameless(0)), [VAL, OP, VAL]),
        ("frame_parameter(long cycle)", |c| c.frame_parameter(FrameParameter::Frameless(1025)), [VAL, OP, VAL]),
        ("frame_parameter(budget)", |c| c.frame_parameter(FrameParameter::TimeBudget(None)), [OK, OP, OK]),
        ("get_upsampling", |c| void(c.get_upsampling()), [OK, OP, OK]),
        ("get", |c| void(c.get(State::Viewport)), [OK, OP, OK]),
        ("get_top_level", |c| void(c.get_top_level()), [OK, OP, OK]),
        ("object_parameter(splits of unknown)", |c| c.object_parameter(99, ObjectParameter::SpatialSplits(true)), [VAL, OP, VAL]),
        ("get_string", |c| void(c.get_string(StateString::Version)), [OK, OP, OK]),
        ("enable", |c| { c.enable(Capability::Accumulate)?; c.disable(Capability::Accumulate) }, [OK, OP, OK]),
        ("render inside", |c| if c.open_primitive().is_none() && c.get(State::CurrentObject)?.as_slice() == [0.0] { Err(Error::invalid_operation("skip")) } else { void(c.render()) }, [OP, OP, OP]),
        ("start inside", |c| if c.open_primitive().is_none() && c.get(State::CurrentObject)?.as_slice() == [0.0] { Err(Error::invalid_operation("skip")) } else { c.start_rendering() }, [OP, OP, OP]),
        ("commit inside", |c| if c.open_primitive().is_none() && c.get(State::CurrentObject)?.as_slice() == [0.0] { Err(Error::invalid_operation("skip")) } else { void(c.commit_scene()) }, [OP, OP, OP]),
    ]
}

fn code_of(result: Result<()>) -> ErrorCode {
    result.err().map_or(NoError, |e| e.code)
}

#[test]
fn every_refused_call_has_its_code_and_changes_nothing() {
    for (name, call, [outside, in_begin, in_object]) in table() {
        let mut cx = furnished();
        let before = snapshot(&cx);
        assert_eq!(code_of(call(&mut cx)), outside, "{name} outside");
        assert_eq!(snapshot(&cx), before, "{name} outside");

        let mut cx = furnished();
        cx.begin(Primitive::Triangles).unwrap();
        assert_eq!(code_of(call(&mut cx)), in_begin, "{name} between begin and end");
        if name != "end" {
            cx.end().unwrap();
        }
        assert_eq!(snapshot(&cx), before, "{name} between begin and end");

        let mut cx = furnished();
        cx.new_object(2, Mode::Compile, Motion::Static).unwrap();
        let before = snapshot(&cx);
        assert_eq!(code_of(call(&mut cx)), in_object, "{name} inside an object");
        if name != "end_object" {
            assert_eq!(snapshot(&cx), before, "{name} inside an object");
            cx.end_object().unwrap();
        }
    }
}

#[test]
fn the_first_error_sticks_until_it_is_read_and_all_are_told() {
    let told = Arc::new(Mutex::new(Vec::new()));
    let mut cx = context();
    let sink = told.clone();
    cx.error_callback(Some(Box::new(move |code, text| sink.lock().unwrap().push((code, text.to_owned())))));
    let first = cx.pop_matrix().unwrap_err();
    cx.latch(first.clone());
    let second = cx.end().unwrap_err();
    cx.latch(second.clone());
    assert_eq!(*told.lock().unwrap(), [first.clone(), second].map(|e| (e.code, e.message.into_owned())));
    assert_eq!(cx.error_message(), first.message);
    assert_eq!(cx.get_error(), StackUnderflow);
    assert_eq!(cx.get_error(), NoError);
}

#[test]
fn asking_for_the_error_between_begin_and_end_is_an_error() {
    let mut cx = context();
    cx.begin(Primitive::Polygon).unwrap();
    assert_eq!(cx.get_error(), NoError);
    cx.end().unwrap();
    assert_eq!(cx.get_error(), InvalidOperation);
}

#[test]
fn a_context_may_move_to_another_thread() {
    fn is_send<T: Send>(_: &T) {}
    let mut cx = context();
    is_send(&cx);
    std::thread::spawn(move || triangle(&mut cx, 1)).join().unwrap();
}

#[test]
fn names_grow_are_objects_at_once_and_may_be_chosen() {
    let mut cx = context();
    let a = cx.gen_objects(2).unwrap();
    assert!(a > 0 && cx.is_object(a).unwrap() && cx.is_object(a + 1).unwrap() && !cx.is_object(a + 2).unwrap());
    cx.delete_objects(a, 1).unwrap();
    assert!(!cx.is_object(a).unwrap() && !cx.is_object(0).unwrap());
    assert_eq!(cx.gen_objects(1).unwrap(), a + 2);
    triangle(&mut cx, 1000);
    assert!(cx.is_object(1000).unwrap());
    assert_eq!(cx.gen_objects(1000).unwrap(), 1001);
    // A run of two thousand million names costs nothing; two leave no room for a third.
    let big = cx.gen_objects(i32::MAX).unwrap();
    assert!(cx.is_object(big + i32::MAX as u32 - 1).unwrap());
    assert_eq!(code_of(void(cx.gen_objects(i32::MAX))), OutOfMemory);
    cx.delete_objects(1, i32::MAX).unwrap();
    assert!(!cx.is_object(1000).unwrap());
    cx.delete_objects(u32::MAX, i32::MAX).unwrap();
    // An object without a definition is empty, and may be placed.
    cx.instantiate_object(big + i32::MAX as u32 - 1).unwrap();
}

#[test]
fn the_matrix_stack_is_deep_and_bounded() {
    let mut cx = context();
    let depth = cx.get(State::MaxMatrixDepth).unwrap().as_slice()[0] as usize;
    assert!(depth >= 64);
    for _ in 1..depth {
        cx.push_matrix().unwrap();
    }
    assert_eq!(code_of(cx.push_matrix()), StackOverflow);
    for _ in 1..depth {
        cx.pop_matrix().unwrap();
    }
    assert_eq!(code_of(cx.pop_matrix()), StackUnderflow);
}

#[test]
fn projective_matrices_bend_vertices_but_place_no_instances() {
    let mut cx = context();
    let object = cx.gen_objects(1).unwrap();
    cx.load_matrix(DMat4::from_cols_array(&[1., 0., 0., 0., 0., 1., 0., 0., 0., 0., -1., -1., 0., 0., -0.2, 0.]))
        .unwrap();
    triangle(&mut cx, object);
    assert_eq!(code_of(cx.instantiate_object(object)), InvalidOperation);
    cx.new_object(object, Mode::CompileAndInstantiate, Motion::Affine).unwrap();
    assert_eq!(code_of(cx.end_object()), InvalidOperation);
    // The definition is still open, and can be saved.
    cx.load_identity().unwrap();
    cx.end_object().unwrap();
    assert_eq!(cx.get(State::InstanceCount).unwrap().as_slice(), [1.0]);
}

#[test]
fn sizes_beyond_memory_are_refused() {
    let mut cx = context();
    let array = |size, stride, bytes| VertexArray { size, component: Component::Float, stride, bytes };
    let arrays = |positions| VertexArrays { positions, normals: None, colors: None, tex_coords: None };
    let bytes = [0u8; 48];
    let good = arrays(array(3, 0, &bytes));
    for (first, count) in [(0, 5), (4, 1), (0, i32::MAX), (i32::MAX, i32::MAX), (-1, 1), (0, -1)] {
        assert_eq!(code_of(cx.draw_arrays(Primitive::Triangles, &good, first, count)), InvalidValue, "{first} {count}");
    }
    let wide = arrays(array(3, usize::MAX, &bytes));
    assert_eq!(code_of(cx.draw_arrays(Primitive::Triangles, &wide, 0, 3)), InvalidValue);
    for size in [0, 1, 5, u32::MAX] {
        let odd = arrays(array(size, 0, &bytes));
        assert_eq!(code_of(cx.draw_arrays(Primitive::Triangles, &odd, 0, 1)), InvalidValue, "size {size}");
    }
    let index = u32::MAX.to_ne_bytes();
    let indices = Indices::new(Component::UnsignedInt, &index).unwrap();
    assert_eq!(code_of(cx.draw_elements(Primitive::Triangles, &good, indices)), InvalidValue);
    assert_eq!(Indices::new(Component::Short, &index).unwrap_err().code, ErrorCode::InvalidEnum);

    cx.bind_texture(1).unwrap();
    let image = |width, height, row_stride| ImageDesc {
        width,
        height,
        format: ImageFormat::Rgba,
        component: Component::Double,
        row_stride,
    };
    for bad in [image(u32::MAX, u32::MAX, 0), image(1, 2, usize::MAX), image(2, 2, 8), image(2, 2, 0)] {
        assert_eq!(code_of(cx.tex_image_2d(0, &bad, Some(&bytes))), InvalidValue, "{bad:?}");
    }
    assert_eq!(code_of(cx.tex_image_2d(u32::MAX, &image(1, 1, 0), None)), InvalidOperation);

    struct Nowhere;
    impl PixelSink for Nowhere {
        fn write(&self, _: usize, _: &[u8]) {}
    }
    for (width, height, stride) in [(0, 1, 4), (1, 0, 4), (4, 4, 15), (4, 4, usize::MAX), (1 << 17, 1, 1 << 20)] {
        let layout = TargetLayout { width, height, format: PixelFormat::Rgba8, stride, origin_top_left: false };
        let target = Target { layout, sink: Arc::new(Nowhere) };
        assert_eq!(code_of(cx.set_frame_buffer(Some(target))), InvalidValue, "{width}x{height} {stride}");
    }
    assert_eq!(code_of(cx.start_rendering()), InvalidOperation, "no framebuffer");
}

#[test]
fn a_viewport_beyond_the_framebuffer_is_refused_when_the_frame_starts() {
    let mut cx = context();
    cx.set_frame_size(8, 8).unwrap();
    cx.viewport(4, 4, 5, 4).unwrap();
    triangle(&mut cx, 1);
    cx.instantiate_object(1).unwrap();
    assert_eq!(code_of(void(cx.render())), InvalidOperation);
    cx.viewport(4, 4, 4, 4).unwrap();
    assert_eq!(cx.render().unwrap().instances, 1);
}

#[test]
fn texture_levels_come_in_order_and_have_their_size() {
    let mut cx = context();
    let image = |width, height| ImageDesc {
        width,
        height,
        format: ImageFormat::Rgb,
        component: Component::UnsignedByte,
        row_stride: 0,
    };
    assert_eq!(code_of(cx.tex_image_2d(0, &image(1, 1), None)), InvalidOperation, "no texture is bound");
    let name = cx.gen_textures(2).unwrap();
    assert!(!cx.is_texture(name).unwrap(), "as in OpenGL, a name is a texture once it was bound");
    cx.bind_texture(name).unwrap();
    assert!(cx.is_texture(name).unwrap());
    assert_eq!(code_of(cx.tex_image_2d(1, &image(2, 1), None)), InvalidOperation);
    cx.tex_image_2d(0, &image(5, 3), Some(&[9; 45])).unwrap();
    assert_eq!(code_of(cx.tex_image_2d(2, &image(1, 1), None)), InvalidOperation, "level 1 is missing");
    assert_eq!(code_of(cx.tex_image_2d(1, &image(3, 1), None)), InvalidOperation);
    cx.tex_image_2d(1, &image(2, 1), None).unwrap();
    cx.tex_image_2d(2, &image(1, 1), None).unwrap();
    assert_eq!(code_of(cx.tex_image_2d(3, &image(1, 1), None)), InvalidOperation);
    cx.tex_parameter(TextureParameter::WrapT(Wrap::ClampToEdge)).unwrap();
    let info = cx.get_tex_parameters().unwrap();
    assert_eq!((info.width, info.height, info.wrap_s, info.wrap_t), (5, 3, Wrap::Repeat, Wrap::ClampToEdge));
    cx.delete_textures(&[name]).unwrap();
    assert!(!cx.is_texture(name).unwrap());
    assert_eq!(cx.get(State::BoundTexture).unwrap().as_slice(), [0.0]);
}

#[test]
fn deleted_shaders_leave_every_binding() {
    let mut cx = context();
    let make = |cx: &mut Context, class| {
        cx.gen_new_shader_class(class).unwrap();
        cx.gen_new_shader().unwrap()
    };
    let (light, camera, sky) = (make(&mut cx, "point"), make(&mut cx, "pinhole"), make(&mut cx, "gradient"));
    let renderer = make(&mut cx, "raycast");
    cx.use_light(light).unwrap();
    cx.use_camera(camera).unwrap();
    cx.use_environment_shader(sky).unwrap();
    cx.use_rendering_object(renderer).unwrap();
    assert_eq!(cx.get_string(StateString::Renderer).unwrap(), "raycast");
    for shader in [light, camera, sky, renderer] {
        cx.delete_shader(shader).unwrap();
        assert_eq!(code_of(cx.delete_shader(shader)), InvalidValue);
    }
    for state in [State::Camera, State::Environment, State::RenderingObject, State::LightCount, State::BoundShader] {
        assert_eq!(cx.get(state).unwrap().as_slice(), [0.0], "{state:?}");
    }
    assert_eq!(code_of(cx.parameter_f(1, &[0.0; 3])), InvalidOperation, "no shader is bound");
}

#[test]
fn binding_a_class_unbinds_the_shader_and_back() {
    let mut cx = context();
    assert_eq!(code_of(void(cx.gen_new_shader())), InvalidOperation);
    let class = cx.gen_new_shader_class("diffuse").unwrap();
    assert_eq!(cx.get(State::BoundShaderClass).unwrap().as_slice(), [f64::from(class)]);
    let shader = cx.gen_new_shader().unwrap();
    cx.bind_shader_class(class).unwrap();
    assert_eq!(cx.get(State::BoundShader).unwrap().as_slice(), [0.0]);
    cx.bind_shader_class(0).unwrap();
    cx.bind_shader(shader).unwrap();
    assert_eq!(cx.get(State::BoundShaderClass).unwrap().as_slice(), [f64::from(class)]);
    let color = cx.parameter_handle("color").unwrap();
    cx.parameter_f(color, &[0.1, 0.2, 0.3]).unwrap();
    assert_eq!(cx.get_parameter(color).unwrap(), ParamValue::Float([0.1, 0.2, 0.3, 0.0]));
    cx.parameter_raw(color, &[0; 12]).unwrap();
    assert_eq!(cx.get_parameter(color).unwrap(), ParamValue::Float([0.0; 4]));
    // A class has one name, and so its handles are good for all its shaders.
    assert_eq!(cx.gen_new_shader_class("diffuse").unwrap(), class);
    cx.gen_new_shader().unwrap();
    cx.parameter_f(color, &[0.1, 0.2, 0.3]).unwrap();
    cx.gen_new_shader_class("phong").unwrap();
    cx.gen_new_shader().unwrap();
    assert_eq!(code_of(cx.parameter_f(color, &[0.1, 0.2, 0.3])), InvalidOperation);
}
