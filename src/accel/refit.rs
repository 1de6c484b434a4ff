//! The complete bottom-up refit (Larsson03 §2): new corners and bounds for an unchanged topology.
//!
//! Children have higher numbers than their parents, so a backward sweep meets every node after its children. The sweep reads
//! the mesh in leaf order, writes the blocks, and takes each leaf's box from the block while it is in the cache.
//! Subtrees are disjoint ranges of nodes and blocks and are swept in parallel; then the few top nodes. One thread or many,
//! the result is the same, as boxes are only minima and maxima.
//!
//! Builders use the same pass to fill the topology they have decided on.

use super::bvh::{BLOCK, Bvh, Node8, Subtree, Tri4, WIDTH};
use super::{Aabb, triangle_bounds};
use crate::scene::Mesh;
use rayon::prelude::*;

/// What a refit could do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub enum Refit {
    /// The tree holds the mesh.
    Done,
    /// The tree was left alone: the number of triangles is another, or one that was unusable at the build
    /// (NaN, infinite) has become usable and has no place in it.
    NeedsRebuild,
}

impl Bvh {
    /// Brings bounds and corners in line with the mesh, whose triangles are those of the build with other positions.
    ///
    /// Triangles that have become unusable keep their place and cannot be hit. To be called inside the pool.
    pub fn refit(&mut self, mesh: &Mesh) -> Refit {
        if mesh.triangles.len() != self.prim_count
            || self.dropped.iter().any(|&prim| !triangle_bounds(mesh.corners(prim)).is_empty())
        {
            return Refit::NeedsRebuild;
        }
        self.fill(mesh);
        Refit::Done
    }

    /// The pass itself.
    pub(super) fn fill(&mut self, mesh: &Mesh) {
        let Some(first) = self.nodes.first() else {
            self.set_bounds(Aabb::EMPTY);
            return;
        };
        debug_assert!(!first.children[0].is_empty(), "a root has a child");
        let top_nodes = self.subtrees.first().map_or(self.nodes.len(), |s| s.nodes.start);
        let top_blocks = self.subtrees.first().map_or(self.blocks.len(), |s| s.blocks.start);

        let mut parts = Vec::with_capacity(self.subtrees.len());
        let (mut nodes, mut blocks) = (&mut self.nodes[top_nodes..], &mut self.blocks[top_blocks..]);
        for subtree in &self.subtrees {
            let (these_nodes, rest) = nodes.split_at_mut(subtree.nodes.len());
            let (these_blocks, rest_blocks) = blocks.split_at_mut(subtree.blocks.len());
            parts.push((subtree, these_nodes, these_blocks));
            (nodes, blocks) = (rest, rest_blocks);
        }
        parts.into_par_iter().for_each(|(subtree, nodes, blocks)| sweep(subtree, nodes, blocks, None, mesh));

        let whole = Subtree { nodes: 0..top_nodes, blocks: 0..top_blocks };
        let lower: Vec<(usize, Aabb)> =
            self.subtrees.iter().map(|s| (s.nodes.start, self.nodes[s.nodes.start].union())).collect();
        sweep(&whole, &mut self.nodes[..top_nodes], &mut self.blocks[..top_blocks], Some(&lower), mesh);
        let bounds = self.nodes[0].union();
        self.set_bounds(bounds);
    }
}

/// Refits the nodes of one part, last first. Children outside of the part are roots of subtrees, with boxes in `lower`
/// (sorted by node number).
fn sweep(part: &Subtree, nodes: &mut [Node8], blocks: &mut [Tri4], lower: Option<&[(usize, Aabb)]>, mesh: &Mesh) {
    for i in (0..nodes.len()).rev() {
        let (upper, below) = nodes.split_at_mut(i + 1);
        let node = &mut upper[i];
        for lane in 0..WIDTH {
            let child = node.children[lane];
            if child.is_empty() {
                break;
            }
            let bounds = if child.is_leaf() {
                let run = child.blocks();
                blocks[run.start - part.blocks.start..run.end - part.blocks.start]
                    .iter_mut()
                    .fold(Aabb::EMPTY, |all, block| all.union(fill_block(block, mesh)))
            } else if part.nodes.contains(&child.index()) {
                below[child.index() - part.nodes.start - i - 1].union()
            } else {
                let lower = lower.expect("only top nodes have children in another part");
                let at = lower.binary_search_by_key(&child.index(), |(node, _)| *node);
                lower[at.expect("the child is the root of a subtree")].1
            };
            node.set_child_bounds(lane, &bounds);
        }
    }
}

/// Copies the corners in and returns their box.
#[inline]
fn fill_block(block: &mut Tri4, mesh: &Mesh) -> Aabb {
    for lane in 0..BLOCK {
        let corners = mesh.corners(block.prims[lane]);
        block.set_corners(lane, corners);
    }
    block.bounds()
}
