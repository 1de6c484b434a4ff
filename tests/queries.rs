//! Questions about a scene outside of pictures: snapshots, masks, all hits of a ray, what lies at a hit, the nearest point. Against brute force, for every strategy.

#[path = "common/meshes.rs"]
#[allow(dead_code, reason = "shared with other tests")]
mod meshes;
#[path = "common/random.rs"]
#[allow(dead_code, reason = "shared with other tests")]
mod random;

use glam::{Affine3A, DAffine3, DMat4, DVec3, Mat4, Quat, Vec3, Vec4};
use openrt::Context;
use openrt::api::ErrorCode::{InvalidOperation, InvalidValue};
use openrt::api::*;
use openrt::scene::Mesh;
use random::Random;
use std::sync::atomic::{AtomicBool, Ordering};

fn context() -> Context {
    Context::with_config(Config::with_threads(2)).expect("a context")
}

fn define(cx: &mut Context, name: Name, mesh: &Mesh, motion: Motion) {
    cx.new_object(name, Mode::Compile, motion).unwrap();
    let Mesh { positions, triangles, normals, .. } = mesh;
    cx.draw_mesh(&TriangleMesh { positions, triangles, normals, ..TriangleMesh::default() }).unwrap();
    cx.end_object().unwrap();
}

fn place(cx: &mut Context, name: Name, world_from_object: Affine3A) {
    cx.load_matrix(DMat4::from_cols_array(&Mat4::from(world_from_object).to_cols_array().map(f64::from))).unwrap();
    cx.instantiate_object(name).unwrap();
    cx.load_identity().unwrap();
}

/// Begins another frame, without the instances of the one before.
fn next_frame(cx: &mut Context) {
    cx.set_frame_size(1, 1).unwrap();
    cx.render().unwrap();
}

fn bits(hit: Option<Hit>) -> Option<[u32; 6]> {
    hit.map(|h| [h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.primitive, h.object, h.instance])
}

fn rays(random: &mut Random, n: usize) -> Vec<Ray> {
    let ray = |_| {
        let org = random.vec() * 6.0 - 3.0;
        let to = random.vec() * 2.0 - 1.0;
        Ray::new(org, to - org)
    };
    (0..n).map(ray).collect()
}

fn soup(random: &mut Random, n: usize, size: f32) -> Mesh {
    let mut mesh = Mesh::default();
    for i in 0..n as u32 {
        let at = random.vec() * 2.0 - 1.0;
        mesh.positions.extend([0; 3].map(|_| at + (random.vec() - 0.5) * size));
        mesh.triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    mesh
}

#[test]
fn small_and_large_batches_and_single_rays_find_the_same() {
    let mut random = Random::new(Random::seed(301));
    let mut cx = context();
    define(&mut cx, 1, &soup(&mut random, 3000, 0.2), Motion::Affine);
    place(&mut cx, 1, Affine3A::from_rotation_y(0.3));
    place(&mut cx, 1, Affine3A::from_translation(Vec3::X));
    cx.commit_scene().unwrap();
    let rays = rays(&mut random, 5000);
    let expected: Vec<_> = cx.intersect_rays(&rays, false).unwrap().into_iter().map(bits).collect();
    assert!(expected.iter().flatten().count() > 1000, "the rays are aimed");
    for chunk in [1, 3, 4, 65, 512, 513] {
        let (mut hits, mut dark) = (vec![Hit::MISS; rays.len()], vec![false; rays.len()]);
        for ((rays, hits), dark) in rays.chunks(chunk).zip(hits.chunks_mut(chunk)).zip(dark.chunks_mut(chunk)) {
            cx.intersect_into(rays, hits, chunk == 3).unwrap();
            cx.occluded_into(rays, dark, chunk == 3).unwrap();
        }
        for i in 0..rays.len() {
            assert_eq!(bits(hits[i].found()), expected[i], "ray {i} of chunks of {chunk}");
            assert_eq!(dark[i], expected[i].is_some(), "ray {i} of chunks of {chunk}");
        }
    }
    assert_eq!(cx.intersect_into(&rays, &mut [], false).unwrap_err().code, InvalidValue);
    cx.new_object(2, Mode::Compile, Motion::Affine).unwrap();
    assert_eq!(cx.intersect_into(&rays, &mut [Hit::MISS; 5000], false).unwrap_err().code, InvalidOperation);
    assert_eq!(cx.snapshot().unwrap_err().code, InvalidOperation);
}

/// What rays find in a snapshot, while the context deforms, moves, redefines, deletes and commits, by every strategy.
#[test]
fn a_snapshot_never_changes_while_frames_go_on() {
    let strategies = Strategy::ALL.into_iter().chain([Strategy::Auto]);
    for strategy in strategies {
        for motion in [Motion::Static, Motion::Affine, Motion::Unstructured] {
            let mut random = Random::new(Random::seed(302));
            let mut cx = context();
            let meshes = [meshes::icosphere(3), soup(&mut random, 400, 0.3), meshes::cube()];
            for (name, mesh) in (1..).zip(&meshes) {
                define(&mut cx, name, mesh, motion);
                cx.object_parameter(name, ObjectParameter::Strategy(strategy)).unwrap();
            }
            let rays = rays(&mut random, 300);
            let mut held: Vec<(SceneView, Vec<Option<[u32; 6]>>)> = Vec::new();
            for frame in 0..8 {
                for name in 1..=3 {
                    place(&mut cx, name, Affine3A::from_translation(Vec3::splat(0.1 * frame as f32 * name as f32)));
                }
                cx.commit_scene().unwrap();
                // A fresh context is the oracle.
                let found: Vec<_> = cx.intersect_rays(&rays, false).unwrap().into_iter().map(bits).collect();
                let snapshot = cx.snapshot().unwrap();
                // Of some frames nobody has asked before they change.
                if frame % 3 != 1 {
                    check(&snapshot, &rays, &found, "at once");
                }
                held.push((snapshot, found));
                next_frame(&mut cx);
                if frame == 5 {
                    held.drain(..3);
                }
                let grown: Vec<Vec3> = meshes[0].positions.iter().map(|p| *p * (1.0 + 0.1 * frame as f32)).collect();
                match frame {
                    0 | 2 | 3 => cx.update_vertices(1, 0, &grown).unwrap(),
                    1 => cx.update_vertices(2, 30, &meshes[1].positions[..60]).unwrap(),
                    4 => define(&mut cx, 3, &meshes::icosphere(2), motion),
                    5 => cx.delete_objects(2, 1).and_then(|()| cx.gen_objects(1)).map(|_| ()).unwrap(),
                    _ => cx.update_vertices(1, 5, &grown[5..40]).unwrap(),
                }
                if frame == 5 {
                    define(&mut cx, 2, &meshes[1], motion);
                }
                for (i, (snapshot, found)) in held.iter().enumerate() {
                    check(snapshot, &rays, found, &format!("{}, {motion:?}, frame {frame}, {i}", strategy.name()));
                }
            }
            drop(cx);
            for (snapshot, found) in &held {
                check(snapshot, &rays, found, "after the context");
            }
        }
    }
}

fn check(snapshot: &SceneView, rays: &[Ray], expected: &[Option<[u32; 6]>], what: &str) {
    let mut hits = vec![Hit::MISS; rays.len()];
    snapshot.intersect_into(rays, &mut hits);
    for (i, ray) in rays.iter().enumerate() {
        assert_eq!(bits(hits[i].found()), expected[i], "{what}, ray {i}, many");
        if i % 5 == 0 {
            assert_eq!(bits(snapshot.intersect(ray)), expected[i], "{what}, ray {i}, one");
            assert_eq!(snapshot.is_occluded(ray), expected[i].is_some(), "{what}, ray {i}, occluded");
        }
    }
}

#[test]
fn threads_ask_snapshots_while_the_context_renders() {
    let mut random = Random::new(Random::seed(303));
    let mut cx = context();
    cx.set_frame_size(32, 32).unwrap();
    let mesh = meshes::icosphere(4);
    define(&mut cx, 1, &mesh, Motion::Unstructured);
    let rays = rays(&mut random, 200);
    place(&mut cx, 1, Affine3A::IDENTITY);
    cx.commit_scene().unwrap();
    let stop = AtomicBool::new(false);
    let first = cx.snapshot().unwrap();
    let expected: Vec<_> = rays.iter().map(|ray| bits(first.intersect(ray))).collect();
    std::thread::scope(|threads| {
        for _ in 0..2 {
            let (snapshot, stop, rays, expected) = (first.clone(), &stop, &rays, &expected);
            threads.spawn(move || {
                while !stop.load(Ordering::Relaxed) {
                    check(&snapshot, rays, expected, "beside frames");
                }
            });
        }
        for frame in 1..20 {
            let moved: Vec<Vec3> = mesh.positions.iter().map(|p| *p * (1.0 + 0.02 * frame as f32)).collect();
            cx.update_vertices(1, 0, moved).unwrap();
            place(&mut cx, 1, Affine3A::IDENTITY);
            cx.render().unwrap();
            let now = cx.snapshot().unwrap();
            let t = now.intersect(&Ray::new(Vec3::Z * 9.0, Vec3::NEG_Z)).expect("the sphere").t;
            assert!((t - (9.0 - (1.0 + 0.02 * frame as f32))).abs() < 0.02, "frame {frame}: {t}");
        }
        stop.store(true, Ordering::Relaxed);
    });
}

#[test]
fn masks_hide_instances_from_kinds_of_rays() {
    for strategy in [Strategy::Auto, Strategy::Bsp] {
        for motion in [Motion::Static, Motion::Affine] {
            let mut cx = context();
            cx.set_frame_size(9, 9).unwrap();
            for name in [1, 2] {
                define(&mut cx, name, &meshes::cube(), motion);
                cx.object_parameter(name, ObjectParameter::Strategy(strategy)).unwrap();
            }
            let down = Ray::new(Vec3::Z * 20.0, Vec3::NEG_Z);
            let both = |cx: &mut Context, mask| {
                cx.instance_mask(mask).unwrap();
                place(cx, 1, Affine3A::from_translation(Vec3::Z * 5.0));
                cx.instance_mask(Mask::ALL).unwrap();
                place(cx, 2, Affine3A::IDENTITY);
            };
            let seen = |cx: &mut Context, mask| {
                let queries = cx.queries().unwrap().masked(mask);
                let mut many = [Hit::MISS; 64];
                queries.intersect_into(&[down; 64], &mut many);
                let one = queries.intersect(&down).map_or(0, |hit| hit.object);
                assert!(many.iter().all(|hit| hit.object == one));
                assert_eq!(queries.is_occluded(&down), one != 0);
                one
            };
            for _ in 0..8 {
                both(&mut cx, Mask(0x10));
                cx.render().unwrap();
            }
            assert_eq!(seen(&mut cx, Mask(0x10)), 1);
            assert_eq!(seen(&mut cx, Mask::QUERY), 2);
            assert_eq!(seen(&mut cx, Mask::NONE), 0);
            // Static instances are merged meanwhile: the mask takes them out of the merged tree again.
            for _ in 0..8 {
                both(&mut cx, Mask::ALL);
                cx.render().unwrap();
            }
            assert_eq!(seen(&mut cx, Mask::QUERY), 1);
            cx.object_parameter(1, ObjectParameter::Mask(Mask(0x20))).unwrap();
            both(&mut cx, Mask::ALL);
            cx.render().unwrap();
            assert_eq!((seen(&mut cx, Mask::QUERY), seen(&mut cx, Mask(0x20))), (2, 1));
            assert_eq!(cx.get_object_parameters(1).unwrap().mask, Mask(0x20));
        }
    }
}

/// A lamp's mesh around its light makes a scene black, unless it casts no shadow.
#[test]
fn what_casts_no_shadow_lets_light_out() {
    for renderer in ["whitted", "path"] {
        let mut cx = context();
        cx.set_frame_size(9, 9).unwrap();
        let mut wall = meshes::cube();
        wall.positions.iter_mut().for_each(|p| *p = *p * Vec3::new(40.0, 40.0, 1.0) - Vec3::Z * 8.0);
        define(&mut cx, 1, &wall, Motion::Affine);
        define(&mut cx, 2, &meshes::icosphere(2), Motion::Affine);
        let mut shader = |class: &str| {
            cx.gen_new_shader_class(class).unwrap();
            cx.gen_new_shader().unwrap()
        };
        let (light, renderer) = (shader("point"), shader(renderer));
        let mut center = |mask| {
            cx.object_parameter(2, ObjectParameter::Mask(mask)).unwrap();
            cx.use_light(light).unwrap();
            cx.use_rendering_object(renderer).unwrap();
            place(&mut cx, 1, Affine3A::IDENTITY);
            // The light is at the origin, and so is the camera, within the lamp.
            place(&mut cx, 2, Affine3A::from_scale(Vec3::splat(0.5)));
            cx.render().unwrap();
            let mut bytes = [0; 16];
            cx.read_pixels(4, 4, 1, 1, PixelKind::Color(PixelFormat::Rgba32F), 0, &mut bytes).unwrap();
            f32::from_ne_bytes(bytes[..4].try_into().unwrap())
        };
        let seen = Mask::ALL.with(Mask::CAMERA, false);
        assert_eq!(center(seen), 0.0);
        assert!(center(seen.with(Mask::SHADOW, false)) > 1e-3);
    }
}

#[test]
fn all_hits_of_a_ray_come_in_order_and_none_is_left_out() {
    for strategy in Strategy::ALL {
        let mut random = Random::new(Random::seed(305));
        let mut cx = context();
        let mut mesh = soup(&mut random, 200, 1.5);
        // Each triangle twice, and a stack of one plane: many hits at one distance.
        let again = mesh.triangles.clone();
        mesh.triangles.extend(again);
        define(&mut cx, 1, &mesh, Motion::Affine);
        define(&mut cx, 2, &meshes::cube(), Motion::Static);
        define(&mut cx, 3, &meshes::cube(), Motion::Static);
        for name in 1..=3 {
            cx.object_parameter(name, ObjectParameter::Strategy(strategy)).unwrap();
        }
        for _ in 0..8 {
            place(&mut cx, 1, Affine3A::IDENTITY);
            place(&mut cx, 2, Affine3A::from_scale(Vec3::splat(0.5)));
            place(&mut cx, 1, Affine3A::from_rotation_x(0.5));
            place(&mut cx, 3, Affine3A::from_scale(Vec3::splat(0.5)));
            cx.commit_scene().unwrap();
            next_frame(&mut cx);
        }
        let mut rays = rays(&mut random, 40);
        rays.push(Ray::new(Vec3::new(0.1, 0.2, 9.0), Vec3::NEG_Z * 1e-30));
        rays.push(Ray { tmin: 1.0, tmax: 1.2, ..rays[0] });
        let queries = cx.queries().unwrap();
        for (i, ray) in rays.iter().enumerate() {
            let mut found = Vec::new();
            queries.each_hit(ray, |hit| {
                found.push(*hit);
                true
            });
            let what = format!("{}, ray {i}", strategy.name());
            let order = |h: &Hit| (h.t, h.instance, h.primitive);
            assert!(found.windows(2).all(|w| order(&w[0]) < order(&w[1])), "{what}: not in order");
            assert_eq!(bits(found.first().copied()), bits(queries.intersect(ray)), "{what}");
            if i < 40 {
                let count = brute_hits(&queries, &mesh, ray);
                assert_eq!(found.len(), count, "{what}: {found:?}");
            }
            let mut first = Vec::new();
            queries.each_hit(ray, |hit| {
                first.push(*hit);
                first.len() < 3
            });
            assert_eq!(first, found[..first.len()], "{what}: the first three");
            assert_eq!(first.len(), found.len().min(3), "{what}");
        }
    }
}

/// Triangles that a ray hits, each asked for alone.
fn brute_hits(queries: &Queries<'_>, soup: &Mesh, ray: &Ray) -> usize {
    let cube = meshes::cube();
    let mut count = 0;
    for record in queries.view().instances().iter().filter(|record| record.object != 0) {
        let mesh = if record.object == 1 { soup } else { &cube };
        for corners in (0..mesh.triangles.len() as u32).map(|prim| mesh.corners(prim)) {
            let world = DAffine3::from_mat4(DMat4::from_cols_array(
                &Mat4::from(record.world_from_object).to_cols_array().map(f64::from),
            ));
            let [a, b, c] = corners.map(|p| world.transform_point3(p.as_dvec3()));
            let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
            let n = (b - a).cross(c - a);
            let t = (a - o).dot(n) / d.dot(n);
            let p = o + d * t;
            let inside = [(a, b), (b, c), (c, a)].iter().all(|(x, y)| (*y - *x).cross(p - *x).dot(n) >= 0.0);
            count += usize::from(t >= 0.0 && t.is_finite() && inside);
        }
    }
    count
}

#[test]
fn a_hit_tells_what_lies_there() {
    let mut cx = context();
    let shader = {
        cx.gen_new_shader_class("diffuse").unwrap();
        cx.gen_new_shader().unwrap()
    };
    cx.new_object(7, Mode::Compile, Motion::Affine).unwrap();
    cx.bind_shader(shader).unwrap();
    cx.begin(Primitive::Triangles).unwrap();
    for (x, y, s) in [(0.0, 0.0, 0.0), (4.0, 0.0, 1.0), (0.0, 4.0, 0.5)] {
        cx.color(Vec4::new(s, 0.25, 0.0, 1.0)).unwrap();
        cx.tex_coord(Vec4::new(s, 1.0 - s, 0.0, 1.0)).unwrap();
        cx.vertex3(x, y, 0.0).unwrap();
    }
    cx.end().unwrap();
    cx.end_object().unwrap();
    let scale = Vec3::new(1.0, 2.0, 3.0);
    place(&mut cx, 7, Affine3A::from_scale_rotation_translation(scale, Quat::IDENTITY, Vec3::X));
    cx.commit_scene().unwrap();
    let snapshot = cx.snapshot().unwrap();
    for (dir, front) in [(-5.0, true), (5.0, false)] {
        let ray = Ray::new(Vec3::new(2.0, 2.0, -dir), Vec3::Z * dir);
        let hit = snapshot.intersect(&ray).expect("the triangle");
        let surface = snapshot.queries().surface(&ray, &hit).expect("a surface");
        assert!(surface.position.abs_diff_eq(Vec3::new(2.0, 2.0, 0.0), 1e-5), "{surface:?}");
        for normal in [surface.geometric_normal, surface.normal] {
            assert!(normal.abs_diff_eq(Vec3::Z, 1e-6), "{surface:?}");
        }
        assert_eq!((surface.front_facing, surface.shader), (front, shader), "{surface:?}");
        let s = 0.25 * 1.0 + 0.25 * 0.5;
        assert!((surface.tex_coord.x - s).abs() < 1e-6 && (surface.tex_coord.y - (1.0 - s)).abs() < 1e-6);
        assert!((surface.color.x - s).abs() < 1e-6 && surface.color.y == 0.25 && surface.color.w == 1.0);
        for strange in [Hit { object: 8, ..hit }, Hit { primitive: 1, ..hit }, Hit { instance: 1, ..hit }] {
            assert_eq!(snapshot.queries().surface(&ray, &strange), None);
        }
    }
}

#[test]
fn the_nearest_point_is_that_of_brute_force() {
    for (strategy, top) in [(Strategy::Auto, TopLevelKind::Auto), (Strategy::Bsp, TopLevelKind::Bsp)] {
        let mut random = Random::new(Random::seed(307));
        let mut cx = context();
        cx.top_level(top).unwrap();
        let mesh = soup(&mut random, 150, 0.4);
        let cube = meshes::cube();
        define(&mut cx, 1, &mesh, Motion::Unstructured);
        define(&mut cx, 2, &cube, Motion::Static);
        define(&mut cx, 3, &cube, Motion::Static);
        cx.object_parameter(1, ObjectParameter::Strategy(strategy)).unwrap();
        let turn = |i: f32| Quat::from_axis_angle(Vec3::new(1.0, i, 2.0).normalize(), i);
        let placements: Vec<(Name, Affine3A)> = (0..12)
            .map(|i| {
                let scale = Vec3::new(0.5, 1.0 + i as f32 * 0.2, -2.0);
                let at = random.vec() * 8.0 - 4.0;
                (1, Affine3A::from_scale_rotation_translation(scale, turn(i as f32), at))
            })
            .chain([(2, Affine3A::from_translation(Vec3::X * 3.0)), (3, Affine3A::from_scale(Vec3::splat(0.5)))])
            .collect();
        for _ in 0..8 {
            placements.iter().for_each(|(name, matrix)| place(&mut cx, *name, *matrix));
            cx.commit_scene().unwrap();
            next_frame(&mut cx);
        }
        let queries = cx.queries().unwrap();
        for i in 0..60 {
            let p = random.vec() * 12.0 - 6.0;
            let mut best = f64::INFINITY;
            for (name, matrix) in &placements {
                let mesh = if *name == 1 { &mesh } else { &cube };
                for prim in 0..mesh.triangles.len() as u32 {
                    let corners = mesh.corners(prim).map(|c| matrix.transform_point3(c).as_dvec3());
                    best = best.min(distance_to_triangle(corners, p.as_dvec3()));
                }
            }
            let found = queries.closest_point(p, f32::INFINITY).expect("some point");
            assert!((f64::from(found.distance) - best).abs() < 1e-4, "point {i}: {found:?}, {best}");
            let matrix = placements[found.instance as usize].1;
            let of = if found.object == 1 { &mesh } else { &cube };
            let [a, b, c] = of.corners(found.primitive).map(|c| matrix.transform_point3(c));
            let there = a * (1.0 - found.u - found.v) + b * found.u + c * found.v;
            assert!(there.abs_diff_eq(found.position, 1e-4), "{there} {found:?}");
            assert!((found.position.distance(p) - found.distance).abs() < 1e-4);
            assert_eq!(queries.closest_point(p, found.distance * 0.99), None);
            let own = queries.closest_point_on(1, p, f32::INFINITY).expect("some point");
            let local = (0..mesh.triangles.len() as u32)
                .map(|prim| distance_to_triangle(mesh.corners(prim).map(|c| c.as_dvec3()), p.as_dvec3()))
                .fold(f64::INFINITY, f64::min);
            assert!((f64::from(own.distance) - local).abs() < 1e-4, "point {i}: {own:?}, {local}");
        }
        assert_eq!(queries.closest_point_on(9, Vec3::ZERO, 1.0), None);
        assert_eq!(queries.masked(Mask::NONE).closest_point(Vec3::ZERO, 99.0), None);
    }
}

/// By a search over the triangle in ever smaller steps: slow, and of another kind than what it checks.
fn distance_to_triangle([a, b, c]: [DVec3; 3], p: DVec3) -> f64 {
    let at = |u: f64, v: f64| (a + (b - a) * u + (c - a) * v).distance(p);
    let (mut u, mut v, mut step) = (1.0 / 3.0, 1.0 / 3.0, 0.5);
    let mut best = at(u, v);
    while step > 1e-9 {
        let mut better = false;
        for (du, dv) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (1.0, -1.0), (-1.0, 1.0)] {
            let x = (u + du * step).clamp(0.0, 1.0);
            let y = (v + dv * step).clamp(0.0, 1.0 - x);
            if at(x, y) < best {
                (u, v, best, better) = (x, y, at(x, y), true);
            }
        }
        if !better {
            step *= 0.5;
        }
    }
    best
}
