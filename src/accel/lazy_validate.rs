//! What must hold of a lazy tree wherever a ray reaches it; for tests and for hunting bugs.

use super::lazy::{LazyBvh, LazyPart};
use super::{Aabb, triangle_bounds};
use crate::scene::Mesh;
use crate::simd::number_at;
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
    let own;
    let part = match lazy.current(number) {
        Some(part) => part,
        None if lazy.touch(number).is_some() => lazy.current(number).ok_or("touched, and not up to date")?,
        None => {
            own = lazy.copy(number).map_err(|error| error.to_string())?;
            own.part()
        }
    };
    let LazyPart { nodes, vertices, first_node, first_vertex } = part;
    let mut boxes = vec![Aabb::EMPTY; nodes.len()];
    for (i, node) in nodes.iter().enumerate().rev() {
        for lane in 0..node.child_count() {
            let child = node.children[lane];
            let inside = if !child.is_leaf() {
                let below = child.index().checked_sub(first_node).filter(|&below| below > i);
                let below = below.and_then(|below| boxes.get(below));
                *below.ok_or_else(|| format!("a child of node {i} of segment {number} is outside of it"))?
            } else if let Some(below) = lazy.segment_of_leaf(child) {
                if below <= number || below >= lazy.segments() {
                    return Err(format!("segment {below} is below segment {number}"));
                }
                segment(lazy, below, mesh, seen)?
            } else {
                let mut all = Aabb::EMPTY;
                for block in &lazy.blocks()[child.blocks()] {
                    for (l, &prim) in block.prims.iter().enumerate() {
                        let corners = mesh.corners(prim);
                        let bits = |c: [Vec3; 3]| c.map(|p| p.to_array().map(f32::to_bits));
                        let held = block.corners.map(|lanes| {
                            let vertex = number_at(lanes[l]).checked_sub(first_vertex);
                            vertex.and_then(|vertex| vertices.get(vertex)).map(|vertex| vertex.truncate())
                        });
                        let [Some(a), Some(b), Some(c)] = held else {
                            return Err(format!("a corner of triangle {prim} is outside of segment {number}"));
                        };
                        if bits([a, b, c]) != bits(corners) {
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
