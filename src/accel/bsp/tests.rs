//! Trees of both builders: every triangle where it must be, in bounded memory.

use super::build::{REFS_PER_TRIANGLE, build};
use super::plane::fast_leaf;
use super::{BLOCK, Bsp, BspTree, Quality};
use crate::accel::corners::Corners;
use crate::accel::test_meshes::{Random, bumpy_sphere, degenerate, needles, soup};
use crate::accel::{Aabb, ChildRef, triangle_bounds};
use crate::scene::Mesh;
use glam::Vec3;

const BOTH: [Quality; 2] = [Quality::Sah, Quality::Fast];

fn tree_of(mesh: &Mesh, quality: Quality) -> BspTree {
    let triangles: Vec<Corners> =
        (0..mesh.triangles.len() as u32).map(|prim| Corners::new(prim, mesh.corners(prim))).collect();
    build(triangles, bounds_of(mesh), quality).expect("memory")
}

fn bounds_of(mesh: &Mesh) -> Aabb {
    (0..mesh.triangles.len() as u32).fold(Aabb::EMPTY, |b, prim| b.union(triangle_bounds(mesh.corners(prim))))
}

/// The triangles of a leaf, or of a node without planes, which is a large one. Returns how many nodes that was.
fn collect(tree: &BspTree, child: ChildRef, held: &mut Vec<u32>) -> usize {
    if child.is_leaf() {
        let refs = tree.blocks[child.blocks()].as_flattened();
        held.extend(refs.iter().map(|r| tree.triangles[*r as usize].prim()));
        return 0;
    }
    let children = tree.nodes[child.index()].children().iter().filter(|c| !c.is_empty());
    1 + children.map(|c| collect(tree, *c, held)).sum::<usize>()
}

/// Leaves with their cells, depths in planes and triangles. Checks that lanes without triangles are empty and that planes are inside of their cells.
fn leaves(mesh: &Mesh, tree: &BspTree) -> Vec<(Aabb, usize, Vec<u32>)> {
    let mut all = Vec::new();
    let mut stack = vec![(0usize, bounds_of(mesh), 0usize)];
    let mut visited = 0;
    while let Some((index, cell, depth)) = stack.pop() {
        visited += 1;
        let node = &tree.nodes[index];
        // (plane, lane, cell, depth)
        let mut cells = vec![(0usize, 0usize, cell, depth)];
        while let Some((number, lane, cell, depth)) = cells.pop() {
            if number < 7
                && let Some((axis, plane)) = node.plane(number)
            {
                assert!(cell.lo[axis] < plane && plane < cell.hi[axis], "{plane} in {cell:?}");
                let (mut below, mut above) = (cell, cell);
                (below.hi[axis], above.lo[axis]) = (plane, plane);
                let half = [4, 2, 2, 1, 1, 1, 1][number];
                cells.push((2 * number + 1, lane, below, depth + 1));
                cells.push((2 * number + 2, lane + half, above, depth + 1));
                continue;
            }
            // Without a plane all lanes below are this cell.
            let lanes = [8, 4, 4, 2, 2, 2, 2].get(number).map_or(1, |lanes| *lanes);
            let mut held = Vec::new();
            for lane in lane..lane + lanes {
                let child = node.children()[lane];
                assert_eq!(child.is_empty(), node.used() >> lane & 1 == 0);
                if child.is_empty() {
                    continue;
                }
                match tree.nodes.get(child.index()) {
                    Some(node) if node.plane(0).is_some() => stack.push((child.index(), cell, depth)),
                    _ => visited += collect(tree, child, &mut held),
                }
            }
            held.sort_unstable();
            held.dedup();
            if !held.is_empty() || node.children()[lane].is_empty() {
                all.push((cell, depth, held));
            }
        }
    }
    assert_eq!(visited, tree.nodes.len(), "every node is in the tree once");
    all
}

/// Whether a part of a triangle is inside a box, by clipping in f64.
fn reaches_into(corners: [Vec3; 3], cell: &Aabb) -> bool {
    let mut polygon: Vec<glam::DVec3> = corners.iter().map(|c| c.as_dvec3()).collect();
    for axis in 0..3 {
        for (limit, sign) in [(f64::from(cell.lo[axis]), 1.0), (f64::from(cell.hi[axis]), -1.0)] {
            let inside = |p: &glam::DVec3| (p[axis] - limit) * sign;
            let mut next = Vec::new();
            for (i, p) in polygon.iter().enumerate() {
                let q = &polygon[(i + 1) % polygon.len()];
                if inside(p) >= 0.0 {
                    next.push(*p);
                }
                if (inside(p) > 0.0 && inside(q) < 0.0) || (inside(p) < 0.0 && inside(q) > 0.0) {
                    next.push(*p + (*q - *p) * (inside(p) / (inside(p) - inside(q))));
                }
            }
            polygon = next;
        }
    }
    !polygon.is_empty()
}

#[test]
fn cells_refer_to_what_reaches_into_them() {
    let mut random = Random::new(Random::seed(21));
    let mut meshes = vec![
        ("soup".to_owned(), soup(&mut random, 500, 0.2)),
        ("needles".to_owned(), needles(&mut random, 300)),
        ("sphere".to_owned(), bumpy_sphere(12, 20)),
    ];
    meshes.extend(degenerate().into_iter().filter(|(_, mesh)| mesh.triangles.len() <= 500));
    for (name, mesh) in meshes {
        for quality in BOTH {
            let tree = tree_of(&mesh, quality);
            for (cell, _, held) in leaves(&mesh, &tree) {
                for prim in 0..mesh.triangles.len() as u32 {
                    let corners = mesh.corners(prim);
                    let b = triangle_bounds(corners);
                    if b.is_empty() {
                        assert!(!held.contains(&prim), "{name}: {prim} cannot be hit");
                        continue;
                    }
                    let by_box = (0..3).all(|k| b.lo[k] < cell.hi[k] && b.hi[k] > cell.lo[k]);
                    let is_held = held.binary_search(&prim).is_ok();
                    let least = match quality {
                        Quality::Fast => by_box,
                        Quality::Sah => reaches_into(corners, &cell),
                    };
                    assert!(is_held || !least, "{name}, {quality:?}: triangle {prim} is not in {cell:?}");
                    assert!(by_box || !is_held, "{name}, {quality:?}: triangle {prim} is in {cell:?}");
                }
            }
        }
    }
}

#[test]
fn leaves_of_a_fast_tree_keep_to_a_threshold_that_grows_with_depth() {
    assert!((0..60).all(|depth| fast_leaf(depth) <= fast_leaf(depth + 1)) && fast_leaf(20) >= 2 * fast_leaf(0));
    let mesh = soup(&mut Random::new(Random::seed(22)), 20_000, 0.01);
    let (sah, fast) = (tree_of(&mesh, Quality::Sah), tree_of(&mesh, Quality::Fast));
    // Small triangles apart from each other: nothing but the threshold ends a division.
    let all = leaves(&mesh, &fast);
    for (_, depth, held) in &all {
        assert!(held.len() <= fast_leaf(*depth), "{} at depth {depth}", held.len());
    }
    assert!(all.iter().any(|(_, _, held)| held.len() > fast_leaf(0)), "deep leaves hold more than the root may");
    assert!(fast.nodes.len() < sah.nodes.len() && fast.blocks.len() < sah.blocks.len());
}

#[test]
fn degenerate_input_stays_linear() {
    let same =
        Mesh { positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y], triangles: vec![[0, 1, 2]; 100_000], ..Mesh::default() };
    let mut fan = soup(&mut Random::new(1), 50_000, 0.5);
    for corners in fan.triangles.iter() {
        fan.positions[corners[0] as usize] = Vec3::splat(0.5);
    }
    let mut all = degenerate();
    all.extend([("same".to_owned(), same), ("fan".to_owned(), fan)]);
    for (name, mesh) in all {
        for quality in BOTH {
            let tree = tree_of(&mesh, quality);
            let n = mesh.triangles.len();
            let refs: usize = leaves(&mesh, &tree).iter().map(|(_, _, held)| held.len()).sum();
            assert!(refs <= REFS_PER_TRIANGLE * n, "{name}, {quality:?}: {refs} references of {n}");
            assert!(tree.nodes.len() <= 2 * n + 2, "{name}, {quality:?}: {} nodes", tree.nodes.len());
            assert!(tree.blocks.len() * BLOCK <= 2 * REFS_PER_TRIANGLE * n);
        }
    }
}

#[test]
fn nothing_is_built_before_a_ray_asks() {
    let mesh = soup(&mut Random::new(1), 100, 0.1);
    let bsp = Bsp::new(&mesh, Quality::Sah, None).expect("memory");
    let before = bsp.memory_bytes();
    assert!(!bsp.is_built());
    assert!(bsp.tree().is_some() && bsp.is_built());
    assert!(bsp.memory_bytes() > before);
    // The next one has the memory of the triangles.
    let place = bsp.tree().expect("memory").triangles.as_ptr();
    let mut next = Bsp::new(&mesh, Quality::Fast, Some(bsp)).expect("memory");
    assert!(!next.is_built());
    assert_eq!(next.waiting.get_mut().expect("no panic").as_ptr(), place);
}
