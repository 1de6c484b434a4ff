//! A tree for questions about nearness, over the triangles of one object in its own space.
//!
//! Structures for rays differ by strategy, and some know nothing of boxes; questions about the nearest point are rare. So they have a plain binary tree of
//! boxes of their own, split at the middle of the centroids along their longest axis, or by halves where that leaves one side empty. It is built by the
//! thread that asks first after a change, in O(n log n), and takes about 20 bytes per triangle. The library's pool has no part in it: a question may come from any
//! thread.

use super::{Aabb, OutOfMemory};
use crate::accel::memory::reserve;
use crate::scene::Mesh;
use glam::Vec3;

/// Triangles of a leaf at most.
const LEAF: usize = 4;
/// Below this depth a node is halved by count, so that no arrangement makes a tree deeper than [`DEPTH`].
const BY_COUNT: usize = 40;
/// More levels than any tree has: 2³² triangles are halved 32 times.
const DEPTH: usize = BY_COUNT + 32;

/// A node and its box. The children of an inner node follow each other.
#[derive(Clone, Copy, Debug)]
pub struct ProximityNode {
    pub bounds: Aabb,
    /// Of a leaf, its first place in the list of triangles; else the first child.
    pub first: u32,
    /// Triangles of a leaf; 0 for an inner node.
    pub count: u32,
}

/// See the module head.
#[derive(Debug, Default)]
pub struct ProximityTree {
    /// The root first; none without a triangle.
    nodes: Vec<ProximityNode>,
    prims: Vec<u32>,
}

impl ProximityTree {
    /// Levels that a tree has at most.
    pub const MAX_DEPTH: usize = DEPTH;

    /// The tree of the triangles with finite corners.
    pub(super) fn new(mesh: &Mesh) -> Result<Self, OutOfMemory> {
        let usable = |prim: &u32| mesh.corners(*prim).iter().all(|corner| corner.is_finite());
        let mut prims = reserve(mesh.triangles.len())?;
        prims.extend((0..mesh.triangles.len() as u32).filter(usable));
        if prims.is_empty() {
            return Ok(Self::default());
        }
        let mut nodes = reserve(prims.len())?;
        nodes.push(ProximityNode { bounds: Aabb::EMPTY, first: 0, count: prims.len() as u32 });
        let mut todo = reserve(DEPTH + 1)?;
        todo.push((0, 0));
        while let Some((node, depth)) = todo.pop() {
            let ProximityNode { first, count, .. } = nodes[node];
            let range = first as usize..(first + count) as usize;
            let (bounds, middles) = boxes(mesh, &prims[range.clone()]);
            nodes[node].bounds = bounds;
            if range.len() <= LEAF {
                continue;
            }
            let left = split(mesh, &mut prims[range], &middles, depth >= BY_COUNT) as u32;
            let child = nodes.len();
            nodes.push(ProximityNode { bounds, first, count: left });
            nodes.push(ProximityNode { bounds, first: first + left, count: count - left });
            (nodes[node].first, nodes[node].count) = (child as u32, 0);
            todo.push((child, depth + 1));
            todo.push((child + 1, depth + 1));
        }
        Ok(Self { nodes, prims })
    }

    /// The root first.
    pub fn nodes(&self) -> &[ProximityNode] {
        &self.nodes
    }

    /// Triangles, as leaves refer to them.
    pub fn prims(&self) -> &[u32] {
        &self.prims
    }

    pub(super) fn memory_bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<ProximityNode>() + self.prims.capacity() * size_of::<u32>()
    }
}

fn middle(mesh: &Mesh, prim: u32) -> Vec3 {
    // Divided first: a sum could leave the range.
    mesh.corners(prim).iter().map(|corner| *corner / 3.0).sum()
}

/// The box around some triangles, and that around their middles.
fn boxes(mesh: &Mesh, prims: &[u32]) -> (Aabb, Aabb) {
    let (mut bounds, mut middles) = (Aabb::EMPTY, Aabb::EMPTY);
    for &prim in prims {
        mesh.corners(prim).iter().for_each(|corner| bounds.grow(*corner));
        middles.grow(middle(mesh, prim));
    }
    (bounds, middles)
}

/// Sorts triangles into two groups, neither of which is empty; returns the size of the first.
fn split(mesh: &Mesh, prims: &mut [u32], middles: &Aabb, by_count: bool) -> usize {
    let extent = middles.hi * 0.5 - middles.lo * 0.5;
    let axis = if extent.x >= extent.y && extent.x >= extent.z {
        0
    } else if extent.y >= extent.z {
        1
    } else {
        2
    };
    let plane = middles.lo[axis] * 0.5 + middles.hi[axis] * 0.5;
    let mut left = 0;
    if !by_count {
        for i in 0..prims.len() {
            if middle(mesh, prims[i])[axis] < plane {
                prims.swap(i, left);
                left += 1;
            }
        }
    }
    if left == 0 || left == prims.len() {
        left = prims.len() / 2;
        prims.select_nth_unstable_by(left, |a, b| {
            middle(mesh, *a)[axis].total_cmp(&middle(mesh, *b)[axis]).then(a.cmp(b))
        });
    }
    left
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::test_meshes::{Random, soup};

    #[test]
    fn every_triangle_is_in_one_leaf_and_in_all_boxes_above() {
        let mut random = Random::new(Random::seed(5));
        let mut same = soup(&mut random, 1, 1.0);
        same.triangles = vec![same.triangles[0]; 1000];
        for mesh in [soup(&mut random, 3000, 0.1), soup(&mut random, 3, 0.1), same] {
            let tree = ProximityTree::new(&mesh).expect("memory");
            let mut seen = vec![0; mesh.triangles.len()];
            let mut todo = vec![(0, 1)];
            while let Some((node, depth)) = todo.pop() {
                assert!(depth <= DEPTH);
                let ProximityNode { bounds, first, count } = tree.nodes()[node];
                if count == 0 {
                    for child in [first as usize, first as usize + 1] {
                        assert!(bounds.contains(&tree.nodes()[child].bounds));
                        todo.push((child, depth + 1));
                    }
                    continue;
                }
                for &prim in &tree.prims()[first as usize..][..count as usize] {
                    seen[prim as usize] += 1;
                    assert!(mesh.corners(prim).iter().all(|p| bounds.contains(&Aabb { lo: *p, hi: *p })));
                }
            }
            assert!(seen.iter().all(|n| *n == 1));
        }
    }
}
