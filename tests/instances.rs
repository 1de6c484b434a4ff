//! Instances through the public Rust API: frames without rendering, matrices without an inverse, composites.

use glam::{DMat4, DVec3, Mat4, Vec3};
use openrt::Context;
use openrt::api::*;

fn context() -> Context {
    let mut cx = Context::with_config(Config::with_threads(2)).expect("a context");
    cx.set_frame_size(17, 17).unwrap();
    cx
}

/// An object that is one square, 2 × 2 around the z axis at `z`.
fn square(cx: &mut Context, name: Name, z: f32) {
    cx.new_object(name, Mode::Compile, Motion::Affine).unwrap();
    quad(cx, z);
    cx.end_object().unwrap();
}

fn quad(cx: &mut Context, z: f32) {
    cx.begin(Primitive::Quads).unwrap();
    for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
        cx.vertex3(x, y, z).unwrap();
    }
    cx.end().unwrap();
}

/// What the ray from `org` downwards meets in the scene that was committed.
fn below(cx: &mut Context, org: Vec3) -> Option<Hit> {
    cx.intersect_rays(&[Ray::new(org, Vec3::NEG_Z)], false).unwrap()[0]
}

#[test]
fn a_loop_that_renders_nothing_asks_exactly_what_it_has_placed() {
    let mut cx = context();
    square(&mut cx, 1, 0.0);
    square(&mut cx, 2, 0.0);
    let light = {
        cx.gen_new_shader_class("point").unwrap();
        cx.gen_new_shader().unwrap()
    };
    for step in 0..8_u32 {
        cx.clear_instances().unwrap();
        cx.use_light(light).unwrap();
        for i in 0..1000 {
            cx.load_identity().unwrap();
            cx.translate(DVec3::new(f64::from(i) * 3.0, f64::from(step) * 3.0, 0.0)).unwrap();
            cx.instantiate_object(1).unwrap();
        }
        assert_eq!(cx.get(State::InstanceCount).unwrap().as_slice(), [1000.0]);
        assert_eq!(cx.commit_scene().unwrap().instances, 1000);
        let at = |x: usize, y: usize| Vec3::new(x as f32 * 3.0, y as f32 * 3.0, 1.0);
        for y in 0..8 {
            let hit = below(&mut cx, at(700, y));
            assert_eq!(
                hit.map(|h| (h.instance, h.object)),
                (y as u32 == step).then_some((700, 1)),
                "step {step}, row {y}"
            );
        }
    }
    // What was drawn outside objects is of the frame that is given up, and so is an object deleted since it was placed.
    cx.load_identity().unwrap();
    quad(&mut cx, 5.0);
    cx.instantiate_object(2).unwrap();
    cx.delete_objects(2, 1).unwrap();
    cx.clear_instances().unwrap();
    assert_eq!(cx.commit_scene().unwrap().instances, 0);
    assert_eq!(below(&mut cx, Vec3::new(0.0, 0.0, 9.0)), None);
    assert_eq!(cx.get(State::FrameNumber).unwrap().as_slice(), [0.0], "nothing was rendered");
    assert_eq!(cx.get_lights().unwrap().iter().map(|light| light.shader).collect::<Vec<_>>(), [light]);
    cx.new_object(3, Mode::Compile, Motion::Affine).unwrap();
    assert_eq!(cx.clear_instances().unwrap_err().code, ErrorCode::InvalidOperation);
}

/// The current matrix times this one, by which x and y are kept and z becomes a mixture of them: a shadow on a plane.
const FLATTEN: DMat4 =
    DMat4::from_cols_array(&[1.0, 0.0, 0.5, 0.0, 0.0, 1.0, -0.25, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);

/// An object of steep facets over the square −1 … 1; `bake` moves its vertices.
fn facets(cx: &mut Context, name: Name, bake: DMat4) {
    cx.push_matrix().unwrap();
    cx.load_matrix(bake).unwrap();
    cx.new_object(name, Mode::Compile, Motion::Affine).unwrap();
    let height = |x: i32, y: i32| ((x * 7 + y * 11).rem_euclid(5)) as f32 * 0.3;
    cx.begin(Primitive::Quads).unwrap();
    for (x, y) in (0..8).flat_map(|y| (0..8).map(move |x| (x, y))) {
        for (x, y) in [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)] {
            cx.vertex3(x as f32 / 4.0 - 1.0, y as f32 / 4.0 - 1.0, height(x, y)).unwrap();
        }
    }
    cx.end().unwrap();
    cx.end_object().unwrap();
    cx.pop_matrix().unwrap();
}

#[test]
fn flattened_instances_are_where_flattened_vertices_are() {
    let place = |i: usize, step: usize| {
        let to = DMat4::from_translation(DVec3::new(i as f64 * 3.0, 0.0, 0.0));
        let turn = DMat4::from_rotation_y(0.3 * i as f64 + 0.1 * step as f64);
        let own = match i {
            0 => DMat4::from_cols_array_2d(&[[1.0, 0., 0., 0.], [0., 1., 0., 0.], [0.; 4], [0., 0., 0., 1.]]),
            1 => FLATTEN,
            2 => DMat4::from_rotation_x(0.2),
            3 => FLATTEN * DMat4::from_rotation_z(0.5),
            // Not only flat but tiny: seen by a ray that aims at it.
            _ => DMat4::from_scale(DVec3::splat(1e-19)),
        };
        to * turn * own
    };
    let rays: Vec<Ray> = (0..4)
        .flat_map(|i| (0..100).map(move |r| (i, r)))
        .map(|(i, r)| {
            let (x, y) = ((r % 10) as f32 * 0.19 - 0.87, (r / 10) as f32 * 0.19 - 0.83);
            Ray::new(Vec3::new(i as f32 * 3.0 + x, y, 9.0), Vec3::new(0.01, -0.02, -1.0))
        })
        .collect();
    for strategy in Strategy::ALL {
        let mut cx = context();
        facets(&mut cx, 1, DMat4::IDENTITY);
        for name in [1, 10, 11, 12, 13, 14] {
            cx.object_parameter(name, ObjectParameter::Strategy(strategy)).ok();
        }
        let answers = |cx: &mut Context, objects: [(Name, bool); 5], step: usize| {
            cx.clear_instances().unwrap();
            for (i, (object, moved)) in objects.into_iter().enumerate() {
                cx.load_matrix(if moved { place(i, step) } else { DMat4::IDENTITY }).unwrap();
                cx.instantiate_object(object).unwrap();
            }
            cx.commit_scene().unwrap();
            cx.intersect_rays(&rays, false).unwrap()
        };
        for step in [0, 1, 1] {
            for i in 0..5 {
                facets(&mut cx, 10 + i, place(i as usize, step));
            }
            let baked = answers(&mut cx, [10, 11, 12, 13, 14].map(|name| (name, false)), step);
            let placed = answers(&mut cx, [(1, true); 5], step);
            let mut seen = [0; 5];
            for (i, (baked, placed)) in baked.iter().zip(&placed).enumerate() {
                let t = |hit: &Option<Hit>| hit.map_or(-1.0, |h| h.t);
                // Where one of two facets is seen edge-on, or at a rim, rounding decides.
                if (t(baked) - t(placed)).abs() > 1e-3 {
                    seen[4] += 1;
                    continue;
                }
                if let Some(hit) = placed {
                    assert_eq!((hit.object, hit.instance as usize), (1, i / 100), "{strategy:?}");
                    seen[i / 100] += 1;
                }
            }
            let [a, b, c, d, differ] = seen;
            assert!(a > 60 && b > 60 && c > 60 && d > 60 && differ <= 4, "{strategy:?} {seen:?}");
        }
        // A ray that aims at what has nearly no size; it has been moved from its place, which no f32 could tell from it.
        cx.clear_instances().unwrap();
        cx.load_identity().unwrap();
        cx.scale(DVec3::splat(1e-19)).unwrap();
        cx.instantiate_object(1).unwrap();
        cx.commit_scene().unwrap();
        let hit = below(&mut cx, Vec3::new(0.0, 0.0, 5.0)).expect("a hit");
        assert_eq!((hit.t, hit.object), (5.0, 1), "{strategy:?}");
        cx.load_identity().unwrap();
        cx.clear_instances().unwrap();
        cx.scale(DVec3::splat(1e18)).unwrap();
        cx.instantiate_object(1).unwrap();
        cx.commit_scene().unwrap();
        let hit = below(&mut cx, Vec3::new(1e17, 1e17, 1.5e18)).expect("a hit");
        assert!(hit.t > 1e17 && hit.t < 1.5e18, "{strategy:?}");
        // Deleted, and nothing is left of its own structures.
        cx.delete_objects(1, 1).unwrap();
        assert_eq!(cx.commit_scene().unwrap().triangles, 128);
        cx.clear_instances().unwrap();
        assert_eq!(cx.commit_scene().unwrap().triangles, 0);
    }
}

#[test]
fn a_shadow_on_the_floor_has_the_normal_of_the_floor() {
    let mut cx = context();
    facets(&mut cx, 1, DMat4::IDENTITY);
    square(&mut cx, 2, -1.0);
    cx.look_at(DVec3::new(0.0, 0.0, 2.0), DVec3::ZERO, DVec3::Y).unwrap();
    cx.load_matrix(FLATTEN).unwrap();
    cx.instantiate_object(1).unwrap();
    cx.load_identity().unwrap();
    cx.instantiate_object(2).unwrap();
    cx.render().unwrap();
    let mut bytes = [0; 12];
    cx.read_pixels(8, 8, 1, 1, PixelKind::Normal, 0, &mut bytes).unwrap();
    let normal =
        Vec3::from_array(std::array::from_fn(|k| f32::from_ne_bytes(bytes[4 * k..4 * k + 4].try_into().unwrap())));
    let plane = Vec3::new(-0.5, 0.25, 1.0).normalize();
    assert!((normal - plane).length() < 1e-5, "{normal} instead of {plane}");
}

#[test]
fn matrices_out_of_range_are_refused_by_name_and_value() {
    let mut cx = context();
    square(&mut cx, 1, 0.0);
    for factor in [1e19, 3e38] {
        cx.load_identity().unwrap();
        cx.scale(DVec3::splat(factor)).unwrap();
        let error = cx.instantiate_object(1).unwrap_err();
        assert_eq!(error.code, ErrorCode::InvalidValue);
        assert!(error.message.contains(&format!("{:e}", factor as f32)), "{error}");
    }
    assert_eq!(cx.get(State::InstanceCount).unwrap().as_slice(), [0.0]);
}

/// What rays from z = 9 downwards meet, at each of `x`.
fn row(cx: &mut Context, x: impl IntoIterator<Item = f32>) -> Vec<Option<(Name, u32)>> {
    cx.commit_scene().unwrap();
    let rays: Vec<Ray> = x.into_iter().map(|x| Ray::new(Vec3::new(x, 0.0, 9.0), Vec3::NEG_Z)).collect();
    let hits = cx.intersect_rays(&rays, false).unwrap();
    hits.into_iter().map(|hit| hit.map(|h| (h.object, h.instance))).collect()
}

fn at(cx: &mut Context, name: Name, x: f64) -> Result<()> {
    cx.push_matrix()?;
    cx.translate(DVec3::new(x, 0.0, 0.0))?;
    let placed = cx.instantiate_object(name);
    cx.pop_matrix()?;
    placed
}

fn composite(cx: &mut Context, name: Name, parts: &[(Name, f64)]) -> Result<()> {
    cx.new_object(name, Mode::Compile, Motion::Affine)?;
    let placed = parts.iter().try_for_each(|&(part, x)| at(cx, part, x));
    cx.end_object()?;
    placed
}

#[test]
fn an_object_made_of_objects_is_placed_with_all_its_parts() {
    let mut cx = context();
    square(&mut cx, 1, 0.0);
    square(&mut cx, 2, 0.5);
    composite(&mut cx, 3, &[(1, 0.0), (2, 3.0)]).unwrap();
    // Triangles and parts.
    cx.new_object(4, Mode::Compile, Motion::Static).unwrap();
    quad(&mut cx, 0.0);
    at(&mut cx, 3, 3.0).unwrap();
    at(&mut cx, 1, 9.0).unwrap();
    cx.end_object().unwrap();
    assert_eq!(cx.get_object_parameters(4).unwrap().child_count, 2);
    at(&mut cx, 1, -3.0).unwrap();
    at(&mut cx, 4, 0.0).unwrap();
    at(&mut cx, 2, 12.0).unwrap();
    let five = [-3.0, 0.0, 3.0, 6.0, 9.0, 12.0, 15.0];
    let expected = [Some((1, 0)), Some((4, 1)), Some((1, 1)), Some((2, 1)), Some((1, 1)), Some((2, 2)), None];
    assert_eq!(row(&mut cx, five), expected);
    assert_eq!(cx.commit_scene().unwrap().instances, 6);
    // The same numbers in the picture and for shaders, and for the eye.
    cx.ortho(-6.0, 11.0, -8.5, 8.5, 0.0, 9.0).unwrap();
    cx.look_at(DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO, DVec3::Y).unwrap();
    cx.render().unwrap();
    for (x, object, instance) in [(3, 1, 0), (6, 4, 1), (9, 1, 1), (12, 2, 1), (15, 1, 1)] {
        let mut read = |kind| {
            let mut bytes = [0; 4];
            cx.read_pixels(x, 8, 1, 1, kind, 0, &mut bytes).unwrap();
            u32::from_ne_bytes(bytes)
        };
        assert_eq!((read(PixelKind::ObjectId), read(PixelKind::InstanceId)), (object, instance), "pixel {x}");
        let hit = cx.pick(x as f32 + 0.5, 8.5).unwrap().expect("a hit");
        assert_eq!((hit.object, hit.instance), (object, instance), "pixel {x}");
    }
}

#[test]
fn parts_are_bound_late_and_may_be_gone() {
    let mut cx = context();
    square(&mut cx, 1, 0.0);
    square(&mut cx, 2, 0.0);
    composite(&mut cx, 3, &[(1, 0.0), (2, 3.0)]).unwrap();
    composite(&mut cx, 4, &[(3, 0.0), (3, 6.0)]).unwrap();
    let four = [0.0, 3.0, 6.0, 9.0];
    let show = |cx: &mut Context| {
        cx.clear_instances().unwrap();
        cx.instantiate_object(4).unwrap();
        row(cx, four).into_iter().map(|hit| hit.map_or(0, |h| h.0)).collect::<Vec<_>>()
    };
    assert_eq!(show(&mut cx), [1, 2, 1, 2]);
    // A part that moves on, and a composite that becomes another.
    composite(&mut cx, 3, &[(2, 0.0), (2, 3.0)]).unwrap();
    assert_eq!(show(&mut cx), [2, 2, 2, 2]);
    composite(&mut cx, 3, &[(1, 0.0), (2, 3.0)]).unwrap();
    // What the frame being assembled shows stays in it, the parts of parts too.
    cx.clear_instances().unwrap();
    cx.instantiate_object(4).unwrap();
    cx.delete_objects(1, 4).unwrap();
    assert_eq!(row(&mut cx, four).into_iter().flatten().count(), 4);
    cx.render().unwrap();
    square(&mut cx, 1, 0.0);
    cx.new_object(4, Mode::CompileAndInstantiate, Motion::Affine).unwrap();
    let gone = cx.instantiate_object(3).unwrap_err();
    assert_eq!(gone.code, ErrorCode::InvalidValue);
    at(&mut cx, 1, 3.0).unwrap();
    cx.end_object().unwrap();
    assert_eq!(row(&mut cx, four), [None, Some((1, 0)), None, None]);
    // A part that is deleted shows nothing, until there is another of its name.
    cx.clear_instances().unwrap();
    cx.delete_objects(1, 1).unwrap();
    assert_eq!(show(&mut cx), [0, 0, 0, 0]);
    square(&mut cx, 1, 0.0);
    assert_eq!(show(&mut cx), [0, 1, 0, 0]);
}

#[test]
fn no_object_becomes_a_part_of_itself() {
    let mut cx = context();
    let refused = |outcome: Result<()>, text: &str| {
        let error = outcome.unwrap_err();
        assert_eq!(error.code, ErrorCode::InvalidOperation);
        assert!(error.message.contains(text), "{error}");
    };
    for name in 1..=4 {
        square(&mut cx, name, 0.0);
    }
    refused(composite(&mut cx, 1, &[(2, 3.0), (1, 6.0)]), "object 1 cannot be a part of itself");
    // The definition went on without it.
    assert_eq!(cx.get_object_parameters(1).unwrap().child_count, 1);
    composite(&mut cx, 3, &[(1, 0.0)]).unwrap();
    refused(composite(&mut cx, 2, &[(4, 0.0), (3, 0.0)]), "object 3 cannot be a part of object 2");
    // Once the way is cut, it may be gone the other way round.
    square(&mut cx, 1, 0.0);
    composite(&mut cx, 2, &[(3, 0.0)]).unwrap();
    refused(composite(&mut cx, 1, &[(2, 0.0)]), "object 2 cannot be a part of object 1");
    cx.instantiate_object(2).unwrap();
    assert_eq!(row(&mut cx, [0.0]), [None], "1 is empty, 3 holds it, 2 holds 3");
    // A thousand deep.
    square(&mut cx, 1000, 0.0);
    for name in (1001..2000).chain([2000]) {
        composite(&mut cx, name, &[(name - 1, 0.001)]).unwrap();
    }
    cx.clear_instances().unwrap();
    cx.instantiate_object(2000).unwrap();
    assert_eq!(row(&mut cx, [1.0, 2.1]), [Some((1000, 0)), None]);
    refused(composite(&mut cx, 1000, &[(2000, 0.0)]), "object 2000 cannot be a part of object 1000");
}

#[test]
fn many_instances_are_placed_at_once_or_not_at_all() {
    let mut cx = context();
    square(&mut cx, 1, 0.0);
    let matrices = |broken: usize| {
        (0..100).map(move |i| {
            Mat4::from_translation(Vec3::new(3.0 * i as f32, 0.0, if i == broken { f32::NAN } else { 0.0 }))
        })
    };
    cx.translate(DVec3::new(0.5, 0.0, 0.0)).unwrap();
    cx.instantiate_object(1).unwrap();
    let error = cx.instantiate_objects(1, matrices(57)).unwrap_err();
    assert_eq!(error.code, ErrorCode::InvalidValue);
    assert!(error.message.contains("matrix 57"), "{error}");
    assert_eq!(cx.get(State::InstanceCount).unwrap().as_slice(), [1.0]);
    cx.instantiate_objects(1, matrices(usize::MAX)).unwrap();
    assert_eq!(row(&mut cx, [1.4, 1.6, 30.5, 298.4, 298.6]), [Some((1, 0)), None, Some((1, 11)), Some((1, 100)), None]);
    // In an object they are its parts.
    cx.load_identity().unwrap();
    cx.new_object(2, Mode::Compile, Motion::Affine).unwrap();
    assert_eq!(cx.instantiate_objects(1, matrices(3)).unwrap_err().code, ErrorCode::InvalidValue);
    cx.instantiate_objects(1, matrices(usize::MAX)).unwrap();
    cx.end_object().unwrap();
    assert_eq!(cx.get_object_parameters(2).unwrap().child_count, 100);
    cx.clear_instances().unwrap();
    cx.instantiate_object(2).unwrap();
    assert_eq!(row(&mut cx, [0.0, 297.0, 298.5]), [Some((1, 0)), Some((1, 0)), None]);
}

#[test]
fn parameters_set_before_the_definition_count() {
    let mut cx = context();
    let name = cx.gen_objects(1).unwrap();
    cx.object_parameter(name, ObjectParameter::Motion(Motion::Static)).unwrap();
    cx.object_parameter(name, ObjectParameter::Strategy(Strategy::Bsp)).unwrap();
    let is = |cx: &Context, name, motion, strategy| {
        let info = cx.get_object_parameters(name).unwrap();
        assert_eq!((info.motion, info.strategy), (motion, strategy), "object {name}");
    };
    cx.new_object(name, Mode::Compile, None).unwrap();
    quad(&mut cx, 0.0);
    cx.end_object().unwrap();
    is(&cx, name, Motion::Static, Strategy::Bsp);
    // What the definition says counts, and what is set within it, though the name is not in use before its end.
    cx.new_object(name, Mode::Compile, Motion::Unstructured).unwrap();
    cx.end_object().unwrap();
    is(&cx, name, Motion::Unstructured, Strategy::Bsp);
    cx.new_object(77, Mode::Compile, Motion::Affine).unwrap();
    cx.object_parameter(77, ObjectParameter::Motion(Motion::Unstructured)).unwrap();
    cx.object_parameter(77, ObjectParameter::Strategy(Strategy::Grid)).unwrap();
    quad(&mut cx, 0.0);
    cx.end_object().unwrap();
    is(&cx, 77, Motion::Unstructured, Strategy::Grid);
    cx.new_object(78, Mode::Compile, None).unwrap();
    cx.end_object().unwrap();
    is(&cx, 78, Motion::Affine, Strategy::Auto);
}
