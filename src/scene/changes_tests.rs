use super::*;
use crate::scene::{Motion, Object, ParamValue, Program, ShaderClass, ShaderKind, Strategy, Texture};
use std::sync::Arc;

fn numbers(mut seed: u64) -> impl FnMut(u64) -> u64 {
    move |below| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) % below
    }
}

fn mesh(vertices: u64, normals: bool, value: f32) -> Mesh {
    let values = vec![Vec3::splat(value); vertices as usize];
    Mesh { normals: if normals { values.clone() } else { Vec::new() }, positions: values, ..Mesh::default() }
}

/// Made twice from the same numbers, because commands are not to be copied.
fn command(next: &mut impl FnMut(u64) -> u64, sizes: &mut HashMap<Name, u64>) -> Command {
    let name = 1 + next(3) as Name;
    let value = next(1000) as f32;
    let size = sizes.get(&name).copied().unwrap_or(0);
    let values = |n: u64| (0..n).map(|i| Vec3::new(value, i as f32, 0.0)).collect::<Vec<_>>();
    match next(20) {
        0 => {
            let size = next(40);
            sizes.insert(name, size);
            let motion = [Motion::Static, Motion::Affine][next(2) as usize];
            Command::DefineObject { name, mesh: mesh(size, next(2) == 0, value), motion }
        }
        1 => Command::SetStrategy { name, strategy: Strategy::ALL[next(8) as usize] },
        2 => Command::SetMotion { name, motion: Motion::Unstructured },
        3 => Command::SetTime { name, time: value },
        4 if size > 0 => Command::SetKeyFrame { name, time: next(4) as f32, positions: values(size) },
        5 => Command::DeleteKeyFrames { name },
        6 if next(4) == 0 => {
            sizes.remove(&name);
            Command::DeleteObject { name }
        }
        7..=10 if size > 0 => {
            let first = next(size);
            Command::UpdatePositions { name, first: first as u32, positions: values(next(size - first + 1)) }
        }
        11 | 12 if size > 0 => {
            let vertices: Vec<u32> = (0..next(10)).map(|_| next(size) as u32).collect();
            Command::MovePositions { name, positions: values(vertices.len() as u64), vertices }
        }
        13 | 14 if size > 0 => {
            let first = next(size);
            Command::UpdateNormals { name, first: first as u32, normals: values(next(size - first + 1)) }
        }
        15 => Command::DefineShader { name, class: 1 },
        16 | 17 => Command::SetParameter {
            shader: name,
            param: next(2) as u32,
            value: ParamValue::Float([value, 0.0, 0.0, 0.0]),
        },
        18 if next(3) == 0 => Command::DeleteShader { name },
        19 if next(2) == 0 => Command::DeleteTexture { name },
        _ => Command::DefineTexture { name, texture: Arc::new(Texture::default()) },
    }
}

fn class() -> Command {
    let param = |name: &str| crate::scene::ParamDef {
        name: name.into(),
        ty: crate::scene::ParamType::Float(1),
        scope: crate::scene::ParamScope::Shader,
        default: ParamValue::Float([0.0; 4]),
        offset: 0,
        choices: &[],
    };
    let params = vec![param("a"), param("b")];
    let (kind, program) = (ShaderKind::Surface, Program::BuiltIn);
    Command::DefineClass {
        name: 1,
        class: Arc::new(ShaderClass { name: "c".into(), kind, params, block_size: 0, program }),
    }
}

fn same(a: &Scene, b: &Scene) {
    fn sorted<T>(map: &HashMap<Name, T>) -> Vec<Name> {
        let mut names: Vec<Name> = map.keys().copied().collect();
        names.sort_unstable();
        names
    }
    assert_eq!(sorted(&a.objects), sorted(&b.objects));
    assert_eq!(sorted(&a.shaders), sorted(&b.shaders));
    assert_eq!(sorted(&a.textures), sorted(&b.textures));
    for (name, x) in &a.objects {
        let y = &b.objects[name];
        let shown = |o: &Object| (o.motion, o.strategy, o.time, o.keys.iter().map(|k| k.time).collect::<Vec<_>>());
        assert_eq!(shown(x), shown(y), "object {name}");
        assert_eq!((&x.mesh.positions, &x.mesh.normals), (&y.mesh.positions, &y.mesh.normals), "object {name}");
        assert!(x.keys.iter().zip(&y.keys).all(|(x, y)| x.positions == y.positions), "object {name}");
    }
    for (name, x) in &a.shaders {
        assert_eq!(x.values, b.shaders[name].values, "shader {name}");
    }
}

/// What is left does the same as everything that was added, however often it is merged and cleared away.
#[test]
fn what_is_left_has_the_same_effect() {
    for seed in 0..300 {
        let (mut one, mut other) = (Scene::default(), Scene::default());
        let (mut changes, mut sizes, mut sizes_again) = (Changes::default(), HashMap::new(), HashMap::new());
        let (mut next, mut again) = (numbers(seed), numbers(seed));
        one.apply(class());
        other.apply(class());
        for _ in 0..4 {
            for _ in 0..200 {
                one.apply(command(&mut next, &mut sizes));
                changes.reserve(1).expect("memory");
                changes.add(command(&mut again, &mut sizes_again), (seed % 2 == 0).then_some(&other));
                if seed % 3 == 0 {
                    // As if there were a great many.
                    for thing in [Thing::Positions, Thing::Normals] {
                        (1..=3).for_each(|name| changes.merge((thing, name)));
                    }
                }
            }
            changes.apply_to(&mut other);
            assert!(changes.waiting.is_empty() && changes.chains.is_empty());
            same(&one, &other);
        }
    }
}

fn vertices_waiting(changes: &Changes) -> usize {
    changes.waiting.iter().filter_map(|w| w.command.as_ref()).map(Command::update_weight).sum()
}

#[test]
fn what_waits_is_bounded_by_what_is_changed() {
    const SIZE: u32 = 1000;
    let mut scene = Scene::default();
    let mut changes = Changes::default();
    let mut next = numbers(7);
    let define = || Command::DefineObject { name: 1, mesh: mesh(SIZE.into(), true, 0.0), motion: Motion::Affine };
    scene.apply(define());
    for turn in 0..20_000u32 {
        let first = next(SIZE.into()) as u32;
        let n = if turn % 50 == 0 { SIZE - first } else { 1 };
        let values = vec![Vec3::splat(turn as f32); n as usize];
        changes.add(Command::UpdatePositions { name: 1, first, positions: values.clone() }, Some(&scene));
        changes.add(Command::UpdateNormals { name: 1, first, normals: values.clone() }, Some(&scene));
        changes.add(Command::MovePositions { name: 1, vertices: vec![first; 3], positions: vec![values[0]; 3] }, None);
        changes.add(Command::SetTime { name: 1, time: turn as f32 }, None);
        changes.add(Command::DefineShader { name: turn, class: 1 }, Some(&scene));
        changes.add(Command::DeleteShader { name: turn }, Some(&scene));
        let most = 2 * (2 * LEAST_LIMIT + SIZE as usize + UPDATE_WEIGHT);
        assert!(vertices_waiting(&changes) <= most, "{} vertices wait", vertices_waiting(&changes));
        assert!(changes.waiting.len() < 3000, "{} commands wait", changes.waiting.len());
    }
    for _ in 0..100 {
        changes.add(define(), Some(&scene));
    }
    let waiting = changes.waiting.iter().filter(|w| w.command.is_some()).count();
    assert_eq!(waiting, 2, "the definition and the time are left");
    changes.add(Command::DeleteObject { name: 1 }, Some(&scene));
    let left = changes.waiting.iter().filter_map(|w| w.command.as_ref()).collect::<Vec<_>>();
    assert!(matches!(left[..], [Command::DeleteObject { name: 1 }]));
}

#[test]
fn what_was_prepared_for_is_applied_to_a_copy_of_what_a_snapshot_holds() {
    let mut scene = Scene::default();
    let mesh = |x: f32| Mesh { positions: vec![Vec3::splat(x); 3], triangles: vec![[0, 1, 2]], ..Mesh::default() };
    let mut changes = Changes::default();
    changes.add(Command::DefineObject { name: 1, mesh: mesh(0.0), motion: Motion::Affine }, Some(&scene));
    changes.prepare(&mut scene, 2).expect("memory");
    assert!(scene.objects[&1].mesh.triangles.is_empty() && scene.objects.capacity() >= 3);
    changes.apply_to(&mut scene);
    let snapshot = scene.objects[&1].mesh.clone();
    changes.add(Command::UpdatePositions { name: 1, first: 0, positions: vec![Vec3::ONE; 3] }, Some(&scene));
    changes.prepare(&mut scene, 0).expect("memory");
    assert!(!Arc::ptr_eq(&snapshot, &scene.objects[&1].mesh));
    assert_eq!(snapshot.positions, scene.objects[&1].mesh.positions);
    let prepared = Arc::as_ptr(&scene.objects[&1].mesh);
    changes.apply_to(&mut scene);
    assert_eq!((Arc::as_ptr(&scene.objects[&1].mesh), snapshot.positions[0]), (prepared, Vec3::ZERO));
    assert_eq!(scene.objects[&1].mesh.positions[0], Vec3::ONE);
}
