//! Unit tests of [`super::lazy`].

use super::lazy::{LazyBvh, Source};
use super::test_meshes::{Random, bumpy_sphere, degenerate};
use super::validate_lazy;
use crate::scene::{LazyShape, Mesh};
use crate::threads::Pool;
use glam::Vec3;
use std::sync::Arc;

pub(super) const SHAPES: [LazyShape; 6] = [
    LazyShape { cut: 0, levels: 0 },
    LazyShape { cut: 0, levels: 1 },
    LazyShape { cut: 64, levels: 0 },
    LazyShape { cut: 200, levels: 1 },
    LazyShape { cut: 400, levels: 2 },
    LazyShape { cut: 1 << 20, levels: 0 },
];

fn pool() -> Pool {
    Pool::new(Some(2)).expect("two threads")
}

fn source(mesh: &Mesh) -> Source {
    Source::Own(Arc::new(mesh.clone()))
}

pub(super) fn built(mesh: &Mesh, shape: LazyShape) -> LazyBvh {
    pool().install(|| LazyBvh::new(mesh, source(mesh), shape)).expect("memory")
}

/// Sequences of positions that a tree must follow, each with a name.
pub(super) fn moves(mesh: &Mesh, random: &mut Random) -> Vec<(&'static str, Mesh)> {
    let mut change = |f: &mut dyn FnMut(&mut Random, Vec3) -> Vec3| Mesh {
        positions: mesh.positions.iter().map(|&p| f(random, p)).collect(),
        ..mesh.clone()
    };
    vec![
        ("shaken", change(&mut |r, p| p + r.vec() * 0.1)),
        ("torn", change(&mut |r, _| r.vec())),
        ("with NaN", change(&mut |r, p| if r.below(9) == 0 { p.with_y(f32::NAN) } else { p })),
        ("all NaN", change(&mut |_, _| Vec3::NAN)),
        ("to a point", change(&mut |_, _| Vec3::splat(0.3))),
        ("exploded", change(&mut |_, p| p * 1e15)),
        ("with infinities", change(&mut |r, p| if r.below(9) == 0 { p * f32::INFINITY } else { p })),
        ("usable again", change(&mut |r, _| r.vec() * 3.0)),
        ("as it was", change(&mut |_, p| p)),
    ]
}

#[test]
fn everything_is_within_reach_after_every_move() {
    let mut random = Random::new(Random::seed(41));
    let pool = pool();
    let mut meshes = degenerate();
    meshes.retain(|(_, mesh)| mesh.triangles.len() < 5000);
    meshes.push(("bumpy sphere".into(), bumpy_sphere(24, 40)));
    for (name, mesh) in meshes {
        for shape in SHAPES {
            let what = |step: &str, e: String| -> String { format!("{name}, {shape:?}, {step}: {e}") };
            let mut lazy = built(&mesh, shape);
            validate_lazy(&lazy, &mesh).map_err(|e| what("built", e)).unwrap();
            for (i, (step, moved)) in moves(&mesh, &mut random).into_iter().enumerate() {
                if pool.install(|| lazy.moved(&moved, source(&moved), i % 2 == 0)).is_none() {
                    lazy = built(&moved, shape);
                }
                // Now and then nobody looks.
                if i % 3 != 1 {
                    validate_lazy(&lazy, &moved).map_err(|e| what(step, e)).unwrap();
                }
            }
        }
    }
}

#[test]
fn a_cut_tree_has_many_segments_and_only_those_reached_are_written() {
    let mesh = bumpy_sphere(60, 100);
    let lazy = built(&mesh, LazyShape { cut: 256, levels: 0 });
    assert!(lazy.segments() > 40, "{} segments", lazy.segments());
    assert_eq!(lazy.touched(), (0, 0));
    lazy.touch(0);
    lazy.touch(7);
    lazy.touch(7);
    assert_eq!(lazy.touched().0, 2);
    assert!(lazy.touched().1 < lazy.nodes() as u64 / 4);
    let by_height = built(&mesh, LazyShape { cut: 0, levels: 0 });
    let by_node = built(&mesh, LazyShape { cut: 0, levels: 1 });
    let counts = (by_height.segments(), by_node.segments());
    assert!(counts.0 > 8 && counts.1 > counts.0 * 5 / 4, "{counts:?}");
}

#[test]
fn what_many_threads_see_is_up_to_date_whoever_wrote_it() {
    let mut random = Random::new(Random::seed(42));
    let mesh = bumpy_sphere(40, 60);
    let pool = pool();
    for shape in SHAPES {
        let mut lazy = built(&mesh, shape);
        for (step, moved) in moves(&mesh, &mut random) {
            pool.install(|| lazy.moved(&moved, source(&moved), step.len() % 2 == 0)).expect("few were dropped");
            std::thread::scope(|scope| {
                for _ in 0..6 {
                    scope
                        .spawn(|| validate_lazy(&lazy, &moved).map_err(|e| format!("{shape:?}, {step}: {e}")).unwrap());
                }
            });
        }
    }
}

#[test]
fn a_private_copy_equals_what_the_writer_writes() {
    let mesh = bumpy_sphere(20, 30);
    let lazy = built(&mesh, LazyShape { cut: 100, levels: 0 });
    for number in 0..lazy.segments() {
        let own = lazy.copy(number).expect("memory");
        lazy.touch(number);
        let (own, shared) = (own.part(), lazy.current(number).expect("written"));
        assert_eq!(format!("{own:?}"), format!("{shared:?}"));
    }
}

#[test]
fn a_change_of_the_scene_costs_no_copy_and_cuts_the_tree_off() {
    let mesh = Arc::new(bumpy_sphere(20, 30));
    let lazy = pool().install(|| LazyBvh::new(&mesh, Source::Scene(Arc::downgrade(&mesh)), SHAPES[2])).expect("memory");
    lazy.touch(0);
    let mut changed = mesh;
    let place = changed.positions.as_ptr();
    Arc::make_mut(&mut changed).positions[0] = Vec3::ZERO;
    assert_eq!(changed.positions.as_ptr(), place);
    let caught = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
        lazy.touch(1);
    }));
    assert!(caught.is_err(), "it must not look up positions that are gone");
}

#[test]
fn partial_moves_reach_what_is_up_to_date_and_what_is_not() {
    let seed = Random::seed(43);
    let mut random = Random::new(seed);
    let pool = pool();
    let mut meshes = degenerate();
    meshes.retain(|(_, mesh)| mesh.triangles.len() < 1000 && !mesh.triangles.is_empty());
    meshes.push(("bumpy sphere".into(), bumpy_sphere(30, 50)));
    for (name, first) in meshes {
        for shape in SHAPES {
            let mut mesh = first.clone();
            let mut lazy = built(&mesh, shape);
            for round in 0..10 {
                if round % 4 == 3 {
                    mesh.positions.iter_mut().for_each(|p| *p += random.vec() * 0.01);
                    if pool.install(|| lazy.moved(&mesh, source(&mesh), round % 3 > 0)).is_none() {
                        break;
                    }
                }
                // Some of the tree is up to date, some not.
                if !lazy.is_empty() && round % 3 > 0 {
                    lazy.touch(0);
                    // From above, as rays come.
                    let below = lazy.topology.segments[0].below.clone();
                    below.step_by(2).for_each(|segment| {
                        lazy.touch(segment);
                    });
                }
                let start = random.below(mesh.positions.len()) as u32;
                let vertices: Vec<u32> = (start..(start + 8).min(mesh.positions.len() as u32)).collect();
                for &v in &vertices {
                    let p = &mut mesh.positions[v as usize];
                    *p = if random.below(8) == 0 { Vec3::NAN } else { random.vec() * 3.0 };
                }
                lazy.moved_some(&mesh, source(&mesh), &vertices).expect("memory");
                if round % 2 == 1 {
                    validate_lazy(&lazy, &mesh)
                        .unwrap_or_else(|e| panic!("seed {seed}, {name}, {shape:?}, {round}: {e}"));
                }
            }
        }
    }
}
