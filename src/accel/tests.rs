//! Builders and refit on every degenerate mesh, and on ordinary ones.

use super::build_fast::{FastScratch, rebuild_fast};
use super::build_sah::{SahScratch, rebuild_sah};
use super::test_meshes::{Random, bumpy_sphere, degenerate, mesh, needles, soup};
use super::{Aabb, Bvh, OutOfMemory, Refit, build_fast, build_sah, build_spatial, triangle_bounds, validate};
use crate::scene::Mesh;
use glam::{Vec3, Vec3Swizzles};

type Build = fn(&Mesh) -> Result<Bvh, OutOfMemory>;
const BUILDERS: [(&str, Build); 3] = [("sah", build_sah), ("fast", build_fast), ("spatial", build_spatial)];

fn threads(count: usize) -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(count).build().expect("a pool can be made")
}

#[test]
fn every_build_of_degenerate_meshes_is_valid() {
    for (name, mesh) in degenerate() {
        for (builder, build) in BUILDERS {
            let bvh = build(&mesh).expect("memory");
            validate(&bvh, &mesh).unwrap_or_else(|e| panic!("{builder} of {name}: {e}"));
            let all = (0..mesh.triangles.len() as u32)
                .fold(Aabb::EMPTY, |all, prim| all.union(triangle_bounds(mesh.corners(prim))));
            assert_eq!(bvh.bounds(), all, "{builder} of {name}");
        }
    }
}

#[test]
fn large_meshes_are_valid_and_equal_for_any_number_of_threads() {
    let mut random = Random::new(Random::seed(3));
    for mesh in [bumpy_sphere(200, 300), soup(&mut random, 150_000, 0.02), needles(&mut random, 50_000)] {
        for (builder, build) in BUILDERS {
            let one = threads(1).install(|| build(&mesh)).expect("memory");
            validate(&one, &mesh).unwrap_or_else(|e| panic!("{builder}: {e}"));
            for count in [2, 3, 7] {
                let other = threads(count).install(|| build(&mesh)).expect("memory");
                assert_eq!(format!("{:?}", one.nodes()), format!("{:?}", other.nodes()), "{builder}, {count} threads");
                let prims = |bvh: &Bvh| bvh.blocks().iter().map(|b| b.prims).collect::<Vec<_>>();
                assert_eq!(prims(&one), prims(&other), "{builder}, {count} threads");
            }
        }
    }
}

#[test]
fn a_rebuild_makes_the_same_tree_in_the_same_memory() {
    let mut random = Random::new(Random::seed(11));
    let mesh = soup(&mut random, 40_000, 0.05);
    let smaller = soup(&mut random, 30_000, 0.05);
    let fresh = [build_sah(&mesh).expect("memory"), build_fast(&mesh).expect("memory")];
    let (mut sah, mut fast) = (SahScratch::default(), FastScratch::default());
    let mut rebuild = |which: usize, mesh: &Mesh, old: Bvh| {
        let built = if which == 0 { rebuild_sah(mesh, old, &mut sah) } else { rebuild_fast(mesh, old, &mut fast) };
        let bvh = built.expect("memory");
        validate(&bvh, mesh).expect("valid");
        let scratch = sah.memory_bytes() + fast.memory_bytes();
        let memory = (bvh.nodes.as_ptr(), bvh.nodes.capacity(), bvh.blocks.as_ptr(), bvh.blocks.capacity(), scratch);
        (bvh, memory)
    };
    for (which, fresh) in fresh.iter().enumerate() {
        // What is largest in either tree has been met then.
        let (bvh, _) = rebuild(which, &mesh, Bvh::default());
        let (bvh, _) = rebuild(which, &smaller, bvh);
        let (bvh, memory) = rebuild(which, &mesh, bvh);
        assert!(memory.4 > 0, "the scratch was not kept");
        let (bvh, again) = rebuild(which, &smaller, bvh);
        assert_eq!(memory, again);
        let (bvh, again) = rebuild(which, &mesh, bvh);
        assert_eq!(memory, again);
        assert_eq!(format!("{:?}", bvh.nodes()), format!("{:?}", fresh.nodes()));
        let prims = |bvh: &Bvh| bvh.blocks().iter().map(|b| b.prims).collect::<Vec<_>>();
        assert_eq!(prims(&bvh), prims(fresh));
    }
}

#[test]
fn a_teapot_in_a_stadium_gets_a_good_tree_fast() {
    let mut teapot = bumpy_sphere(100, 150);
    let alone = build_fast(&teapot).expect("memory").sah_cost();
    // In one cell of the grid over the stadium.
    teapot.positions.iter_mut().for_each(|p| *p = *p * 1e-4 + 0.3);
    let first = teapot.positions.len() as u32;
    teapot.positions.extend([Vec3::ONE, Vec3::NEG_ONE, Vec3::X]);
    teapot.triangles.push([first, first + 1, first + 2]);
    let bvh = build_fast(&teapot).expect("memory");
    validate(&bvh, &teapot).expect("valid");
    // The cost of the part within the teapot's own box.
    let within: f64 = bvh.nodes()[1..].iter().map(|n| f64::from(n.union().half_area())).sum();
    let sphere = f64::from(Aabb { lo: Vec3::splat(-1.1e-4), hi: Vec3::splat(1.1e-4) }.half_area());
    assert!(within / sphere < alone, "{} nodes per ray through the teapot, alone it costs {alone}", within / sphere);
}

#[test]
fn surface_area_heuristic_makes_the_cheaper_tree() {
    let mesh = bumpy_sphere(100, 150);
    let (sah, fast) = (build_sah(&mesh).expect("memory"), build_fast(&mesh).expect("memory"));
    assert!(sah.sah_cost() < fast.sah_cost(), "{} {}", sah.sah_cost(), fast.sah_cost());
    assert!(sah.depth() <= 12 && fast.depth() <= 16, "{} {}", sah.depth(), fast.depth());
}

#[test]
fn cutting_triangles_makes_a_cheaper_tree_of_long_ones() {
    let mut random = Random::new(Random::seed(6));
    let mut mixed = |large: usize, size: f32| {
        let parts = [soup(&mut random, 20_000, 0.01), soup(&mut random, large, size)];
        mesh(parts.iter().flat_map(|m| (0..m.triangles.len() as u32).map(|prim| m.corners(prim))))
    };
    for (name, mesh, gain) in [("few large among small", mixed(200, 2.0), 1.6), ("walls", mixed(1000, 1.5), 1.6)] {
        let (plain, cut) = (build_sah(&mesh).expect("memory"), build_spatial(&mesh).expect("memory"));
        validate(&cut, &mesh).expect("valid");
        let (before, after) = (plain.sah_cost(), cut.sah_cost());
        assert!(after * gain < before, "{name}: cost {before} without, {after} with cuts");
        assert!(cut.blocks().len() < 2 * plain.blocks().len(), "{name}: {} blocks", cut.blocks().len());
    }
}

#[test]
fn every_point_of_a_cut_triangle_is_in_a_leaf() {
    let mut random = Random::new(Random::seed(8));
    for mesh in [needles(&mut random, 500), soup(&mut random, 500, 1.5), bumpy_sphere(20, 30)] {
        let bvh = build_spatial(&mesh).expect("memory");
        let mut boxes = vec![Vec::new(); mesh.triangles.len()];
        for node in bvh.nodes() {
            for lane in (0..node.child_count()).filter(|&lane| node.children[lane].is_leaf()) {
                for block in &bvh.blocks()[node.children[lane].blocks()] {
                    block.prims.iter().for_each(|&prim| boxes[prim as usize].push(node.child_bounds(lane)));
                }
            }
        }
        for (prim, boxes) in boxes.iter().enumerate() {
            let [a, b, c] = mesh.corners(prim as u32);
            let whole = triangle_bounds([a, b, c]);
            assert!(boxes.iter().fold(Aabb::EMPTY, |all, b| all.union(*b)).contains(&whole));
            for _ in 0..200 {
                let (u, v) = (random.unit(), random.unit());
                let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
                // What a ray may be off by: a ten-thousandth of the triangle.
                let at = a + (b - a) * u + (c - a) * v + random.vec() * (whole.extent().max_element() * 1e-4);
                let at = at.max(whole.lo).min(whole.hi);
                let point = Aabb { lo: at, hi: at };
                assert!(boxes.iter().any(|b| b.contains(&point)), "triangle {prim} at {u}, {v}: {boxes:?}");
            }
        }
        let mut moved = bvh.clone();
        assert_eq!(moved.refit_once(&mesh), Refit::NeedsRebuild);
    }
}

#[test]
fn refit_follows_moving_vertices() {
    let mut mesh = bumpy_sphere(100, 150);
    for (builder, build) in &BUILDERS[..2] {
        let mut bvh = build(&mesh).expect("memory");
        for frame in 0..3 {
            for p in &mut mesh.positions {
                *p = p.yzx() * 1.1 + Vec3::X * (3.0 * p.y + frame as f32).sin();
            }
            assert_eq!(bvh.refit_once(&mesh), Refit::Done);
            validate(&bvh, &mesh).unwrap_or_else(|e| panic!("{builder}, frame {frame}: {e}"));
        }
    }
}

#[test]
fn refit_keeps_the_place_of_triangles_that_vanish_for_a_while() {
    let mut random = Random::new(Random::seed(5));
    let good = soup(&mut random, 100, 0.3);
    let mut bvh = build_sah(&good).expect("memory");
    let mut bad = good.clone();
    for i in (0..300).step_by(7) {
        bad.positions[i] = Vec3::NAN;
    }
    assert_eq!(bvh.refit_once(&bad), Refit::Done);
    validate(&bvh, &bad).expect("valid with triangles missing");
    let none = Mesh { positions: vec![Vec3::NAN; 300], ..good.clone() };
    assert_eq!(bvh.refit_once(&none), Refit::Done);
    assert!(bvh.bounds().is_empty());
    assert_eq!(bvh.refit_once(&good), Refit::Done);
    validate(&bvh, &good).expect("valid again");

    // Built while some were unusable, they have no place.
    let mut bvh = build_sah(&bad).expect("memory");
    assert_eq!(bvh.refit_once(&bad), Refit::Done);
    assert_eq!(bvh.refit_once(&good), Refit::NeedsRebuild);
    validate(&bvh, &bad).expect("left alone");
    assert_eq!(bvh.refit_once(&mesh([])), Refit::NeedsRebuild);
}

#[test]
fn validate_sees_what_is_wrong() {
    let mesh = bumpy_sphere(20, 30);
    let good = build_sah(&mesh).expect("memory");
    validate(&good, &mesh).expect("valid");

    let mut bad = good.clone();
    bad.nodes[1].bounds[1][0] *= 0.5;
    validate(&bad, &mesh).expect_err("a box is too small");

    let mut bad = good.clone();
    bad.blocks[3].prims[0] = bad.blocks[4].prims[0];
    validate(&bad, &mesh).expect_err("a triangle has two places");

    let mut bad = good.clone();
    bad.blocks[3].corners[1][1][0] += 1.0;
    validate(&bad, &mesh).expect_err("a corner is another");

    let mut moved = mesh.clone();
    moved.positions[5].x += 0.5;
    validate(&good, &moved).expect_err("the mesh moved");
}
