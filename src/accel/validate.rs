//! What must hold of every tree after every build and update; for tests and for hunting bugs.

use super::bvh::{Bvh, MAX_DEPTH, Node8};
use super::{Aabb, triangle_bounds};
use crate::scene::Mesh;

/// Checks `bvh` against the mesh it should hold: every usable triangle has its place exactly once, with the mesh's corners; each
/// leaf's box is the union of its triangles' boxes (not larger, and several places are allowed, in trees that hold parts of triangles) and each inner box the union of its children's; unused lanes
/// are empty; the depth is bounded. Describes the first violation.
pub fn validate(bvh: &Bvh, mesh: &Mesh) -> Result<(), String> {
    let usable = |prim: u32| !triangle_bounds(mesh.corners(prim)).is_empty();
    let count = mesh.triangles.len();
    let live = (0..count as u32).filter(|&prim| usable(prim)).count();
    if bvh.is_empty() {
        return if live == 0 {
            Ok(())
        } else {
            Err(format!("the tree is empty, the mesh has {live} usable triangles"))
        };
    }

    let mut seen = vec![false; count];
    let mut visited = vec![false; bvh.nodes().len()];
    let mut used_blocks = vec![false; bvh.blocks().len()];
    let mut stack = vec![(0usize, 1usize, bvh.bounds())];
    while let Some((index, depth, expected)) = stack.pop() {
        let node = bvh.nodes().get(index).ok_or(format!("node {index} does not exist"))?;
        if std::mem::replace(&mut visited[index], true) {
            return Err(format!("node {index} has two parents"));
        }
        if depth > bvh.depth() || depth > MAX_DEPTH {
            return Err(format!("node {index} is at depth {depth}, the tree says {}", bvh.depth()));
        }
        if node.union() != expected {
            return Err(format!("the box of node {index} is {expected:?}, its children's union {:?}", node.union()));
        }
        check_unused_lanes(node).map_err(|lane| format!("lane {lane} of node {index} is unused but not empty"))?;
        for lane in 0..node.child_count() {
            let child = node.children[lane];
            if !child.is_leaf() {
                if child.index() <= index {
                    return Err(format!(
                        "node {index} has the child {}, which should have a higher number",
                        child.index()
                    ));
                }
                stack.push((child.index(), depth + 1, node.child_bounds(lane)));
                continue;
            }
            let mut union = Aabb::EMPTY;
            for block_index in child.blocks() {
                let block = bvh.blocks().get(block_index).ok_or(format!("block {block_index} does not exist"))?;
                if std::mem::replace(&mut used_blocks[block_index], true) {
                    return Err(format!("block {block_index} is in two leaves"));
                }
                for (lane, &prim) in block.prims.iter().enumerate() {
                    if prim as usize >= count {
                        return Err(format!("triangle {prim} of block {block_index} does not exist"));
                    }
                    let corners = mesh.corners(prim);
                    union = union.union(triangle_bounds(corners));
                    let same = block
                        .corners(lane)
                        .iter()
                        .zip(&corners)
                        .all(|(a, b)| a.to_array().map(f32::to_bits) == b.to_array().map(f32::to_bits));
                    if !same {
                        return Err(format!("triangle {prim} has other corners in block {block_index}"));
                    }
                    // A lane that repeats the one before is padding.
                    let padding = lane > 0 && block.prims[lane - 1] == prim;
                    if !padding && std::mem::replace(&mut seen[prim as usize], true) && !bvh.holds_parts() {
                        return Err(format!("triangle {prim} has two places"));
                    }
                }
            }
            let bounds = node.child_bounds(lane);
            let fits = if bvh.holds_parts() { !bounds.is_empty() && union.contains(&bounds) } else { union == bounds };
            if !fits {
                return Err(format!(
                    "leaf {lane} of node {index} has the box {:?}, its triangles {union:?}",
                    node.child_bounds(lane)
                ));
            }
        }
    }
    match (0..count as u32).find(|&prim| usable(prim) && !seen[prim as usize]) {
        Some(prim) => Err(format!("triangle {prim} is usable but not in the tree")),
        None => Ok(()),
    }
}

fn check_unused_lanes(node: &Node8) -> Result<(), usize> {
    match (node.child_count()..super::WIDTH).find(|&lane| node.child_bounds(lane) != Aabb::EMPTY) {
        Some(lane) => Err(lane),
        None => Ok(()),
    }
}
