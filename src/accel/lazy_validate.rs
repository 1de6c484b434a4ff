//! What must hold of a lazy tree wherever a ray reaches it; for tests and for hunting bugs.

use super::lazy::{LazyBvh, LazyPart};
use super::{Aabb, triangle_bounds};
use crate::scene::Mesh;
use glam::Vec3;

/// Reaches every segment of `lazy`, as rays would, and checks it against the mesh: each usable triangle has its place once, with the mesh's corners, and every
/// box contains what is below it. Describes the first violation.
pub fn validate_lazy(lazy: &LazyBvh, mesh: &Mesh) -> Result<(), String> {
    let mut seen = vec![false; mesh.triangles.len()];
    if !lazy.is_empty() {
        let inside = segment(lazy, 0, mesh, &mut seen)?;
        if !lazy.bounds().contains(&inside) {
            return Err(format!("the box {:?} lacks {inside:?}", lazy.bounds()));
        }
    }
    let missing =
        (0..mesh.triangles.len() as u32).find(|&p| !seen[p as usize] && !triangle_bounds(mesh.corners(p)).is_empty());
    missing.map_or(Ok(()), |prim| Err(format!("triangle {prim} is missing")))
}

/// What is in a segment, with the box around it.
fn segment(lazy: &LazyBvh, number: usize, mesh: &Mesh, seen: &mut [bool]) -> Result<Aabb, String> {
    let touch;
    let part = match lazy.current(number) {
        Some(part) => part,
        None => {
            touch = lazy.touch(number);
            touch.part()
        }
    };
    let LazyPart { nodes, blocks, below } = part;
    let mut boxes = vec![Aabb::EMPTY; nodes.len()];
    for (i, node) in nodes.iter().enumerate().rev() {
        for lane in 0..node.child_count() {
            let child = node.children[lane];
            let inside = if !child.is_leaf() {
                boxes[child.index()]
            } else if child.blocks().start >= blocks.len() {
                segment(lazy, below + child.blocks().start - blocks.len(), mesh, seen)?
            } else {
                let mut all = Aabb::EMPTY;
                for block in &blocks[child.blocks()] {
                    for (l, &prim) in block.prims.iter().enumerate() {
                        let corners = mesh.corners(prim);
                        let bits = |c: [Vec3; 3]| c.map(|p| p.to_array().map(f32::to_bits));
                        if bits(block.corners(l)) != bits(corners) {
                            return Err(format!("triangle {prim} of segment {number} is where it was before"));
                        }
                        all = all.union(triangle_bounds(corners));
                        let padding = l > 0 && block.prims[l - 1] == prim;
                        if !padding && std::mem::replace(&mut seen[prim as usize], true) {
                            return Err(format!("triangle {prim} has two places"));
                        }
                    }
                }
                all
            };
            let bounds = node.child_bounds(lane);
            if !bounds.contains(&inside) || bounds.lo.is_nan() || bounds.hi.is_nan() {
                return Err(format!("lane {lane} of node {i} of segment {number}: {bounds:?} lacks {inside:?}"));
            }
            boxes[i] = boxes[i].union(inside);
        }
    }
    Ok(boxes.first().copied().unwrap_or(Aabb::EMPTY))
}
