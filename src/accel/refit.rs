//! The complete bottom-up refit (Larsson03 §2): new corners and bounds for an unchanged topology.
//!
//! Children have higher numbers than their parents, so a backward sweep meets every node after its children. The sweep reads
//! the mesh in leaf order, writes the blocks, and takes each leaf's box from the block while it is in registers.
//! Subtrees are disjoint ranges of nodes and blocks and are swept in parallel; then the few top nodes. One thread or many,
//! the result is the same, as boxes are only minima and maxima.
//!
//! Builders use the same sweep to write the topology they have decided on ([`super::assemble`]).

use super::block_loader::{BlockBox, Load, Prims, load};
use super::bvh::{BLOCK, Bvh, Node8, Subtree, Tri4, WIDTH};
use super::{Aabb, triangle_bounds};
use crate::scene::Mesh;
use glam::Mat4;
use rayon::prelude::*;
use std::ops::Range;

/// A subtree with its nodes and blocks.
type Part<'a> = (&'a Subtree, &'a mut [Node8], &'a mut [Tri4]);

/// What a refit could do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub enum Refit {
    /// The tree holds the mesh.
    Done,
    /// The tree was left alone: it holds parts of triangles, the number of triangles is another, or one that was unusable at the build
    /// (NaN, infinite) has become usable and has no place in it.
    NeedsRebuild,
}

impl Bvh {
    /// Whether every triangle that can be hit has a place in the tree, and one only.
    pub(super) fn can_hold(&self, mesh: &Mesh) -> bool {
        mesh.triangles.len() == self.prim_count
            && !self.holds_parts()
            && self.dropped.iter().all(|&prim| triangle_bounds(mesh.corners(prim)).is_empty())
    }

    /// Brings bounds and corners in line with the mesh, whose triangles are those of the build with other positions.
    ///
    /// Triangles that have become unusable keep their place and cannot be hit. To be called inside the pool.
    pub fn refit(&mut self, mesh: &Mesh) -> Refit {
        self.refit_by(mesh, |parts, sweep| parts.into_par_iter().map(sweep).collect())
    }

    /// Likewise by one thread, wherever it is called.
    pub(super) fn refit_alone(&mut self, mesh: &Mesh) -> Refit {
        self.refit_by(mesh, |parts, sweep| parts.into_iter().map(sweep).collect())
    }

    /// `each` gives all parts to the sweep and collects what it gives back.
    fn refit_by(
        &mut self,
        mesh: &Mesh,
        each: impl FnOnce(Vec<Part<'_>>, &(dyn Fn(Part<'_>) -> (usize, Aabb) + Sync)) -> Vec<(usize, Aabb)>,
    ) -> Refit {
        if !self.can_hold(mesh) {
            return Refit::NeedsRebuild;
        }
        if self.nodes.is_empty() {
            return Refit::Done;
        }
        let top_nodes = self.subtrees.first().map_or(self.nodes.len(), |s| s.nodes.start);
        let top_blocks = self.subtrees.first().map_or(self.blocks.len(), |s| s.blocks.start);
        let (top_nodes, mut nodes) = self.nodes.split_at_mut(top_nodes);
        let (top_blocks, mut blocks) = self.blocks.split_at_mut(top_blocks);
        let mut parts = Vec::with_capacity(self.subtrees.len());
        for subtree in &self.subtrees {
            let (these_nodes, rest_nodes) = nodes.split_at_mut(subtree.nodes.len());
            let (these_blocks, rest_blocks) = blocks.split_at_mut(subtree.blocks.len());
            parts.push((subtree, these_nodes, these_blocks));
            (nodes, blocks) = (rest_nodes, rest_blocks);
        }
        let lower =
            each(parts, &|(part, nodes, blocks)| (part.nodes.start, sweep(&Keep, part, nodes, blocks, &[], mesh)));
        let whole = Subtree { nodes: 0..top_nodes.len(), blocks: 0..top_blocks.len() };
        let bounds = match &lower[..] {
            [(0, bounds)] => *bounds,
            lower => sweep(&Keep, &whole, top_nodes, top_blocks, lower, mesh),
        };
        self.set_bounds(bounds);
        Refit::Done
    }
}

/// Where a sweep gets a part's topology from. Indices count from the part's first.
pub(super) trait Fill: Prims {
    /// Sets the children of a node.
    fn node(&self, index: usize, node: &mut Node8);

    /// The box of the leaf that consists of a run of blocks, if it is not the box around its triangles.
    #[inline(always)]
    fn leaf(&self, _run: Range<usize>) -> Option<BlockBox> {
        None
    }
}

/// The topology stays.
pub(super) struct Keep;

impl Fill for Keep {
    #[inline(always)]
    fn node(&self, _: usize, _: &mut Node8) {}
}

impl Prims for Keep {
    #[inline(always)]
    fn prims(&self, blocks: &[Tri4], index: usize) -> [u32; BLOCK] {
        blocks[index].prims
    }
}

/// Writes the blocks of one part, then its nodes, last first, and returns the box of its root. Children outside of the part are
/// roots of other parts, with boxes in `lower` (sorted by node number).
pub(super) fn sweep(
    fill: &impl Fill,
    part: &Subtree,
    nodes: &mut [Node8],
    blocks: &mut [Tri4],
    lower: &[(usize, Aabb)],
    mesh: &Mesh,
) -> Aabb {
    let mut leaves = Vec::with_capacity(blocks.len());
    load(Load { mesh, blocks, prims: fill, boxes: &mut leaves });
    let mut boxes = vec![BlockBox::EMPTY; nodes.len()];
    for (i, node) in nodes.iter_mut().enumerate().rev() {
        fill.node(i, node);
        let mut lanes = [BlockBox::EMPTY; WIDTH];
        let mut all = BlockBox::EMPTY;
        for (child, lane) in node.children.iter().zip(&mut lanes) {
            if child.is_empty() {
                break;
            }
            *lane = if child.is_leaf() {
                let run = child.blocks();
                let (first, end) = (run.start - part.blocks.start, run.end - part.blocks.start);
                let whole = || leaves[first + 1..end].iter().fold(leaves[first], |all, b| all.union(b));
                fill.leaf(first..end).unwrap_or_else(whole)
            } else if part.nodes.contains(&child.index()) {
                boxes[child.index() - part.nodes.start]
            } else {
                let at = lower.binary_search_by_key(&child.index(), |(node, _)| *node);
                let bounds = lower[at.expect("the child is the root of a part")].1;
                BlockBox { lo: bounds.lo.extend(0.0), hi: bounds.hi.extend(0.0) }
            };
            all = all.union(lane);
        }
        boxes[i] = all;
        set_bounds(node, &lanes);
    }
    Aabb { lo: boxes[0].lo.truncate(), hi: boxes[0].hi.truncate() }
}

/// Writes the boxes of all lanes; unused ones are empty.
#[inline(always)]
pub(super) fn set_bounds(node: &mut Node8, lanes: &[BlockBox; WIDTH]) {
    for half in 0..2 {
        let [a, b, c, d] = [lanes[4 * half], lanes[4 * half + 1], lanes[4 * half + 2], lanes[4 * half + 3]];
        let lo = Mat4::from_cols(a.lo, b.lo, c.lo, d.lo).transpose();
        let hi = Mat4::from_cols(a.hi, b.hi, c.hi, d.hi).transpose();
        for (row, values) in [lo.x_axis, hi.x_axis, lo.y_axis, hi.y_axis, lo.z_axis, hi.z_axis].iter().enumerate() {
            node.bounds[row][4 * half..][..4].copy_from_slice(&values.to_array());
        }
    }
}
