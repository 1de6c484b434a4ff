//! The complete bottom-up refit (Larsson03 §2): new corners and bounds for an unchanged topology.
//!
//! Children have higher numbers than their parents, so a backward sweep meets every node after its children. The sweep reads
//! the mesh in leaf order, writes the blocks, and takes each leaf's box from the block while it is in registers.
//! Subtrees are disjoint ranges of nodes and blocks and are swept in parallel; then the few top nodes. One thread or many,
//! the result is the same, as boxes are only minima and maxima.
//!
//! Builders use the same sweep to write the topology they have decided on ([`super::assemble`]).

use super::block_loader::{BlockBox, Load, Prims, load};
use super::bvh::{BLOCK, Bvh, Node8, OutOfMemory, Subtree, Tri4, WIDTH};
use super::{Aabb, triangle_bounds};
use crate::memory::Room;
use crate::scene::Mesh;
use crate::threads::Desks;
use glam::Mat4;
use std::ops::Range;

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
    ///
    /// # Errors
    /// No memory to work in; nothing has changed.
    pub fn refit(&mut self, mesh: &Mesh, scratch: &mut SweepScratch) -> Result<Refit, OutOfMemory> {
        self.prepare(scratch, usize::MAX)?;
        Ok(self.refit_by(mesh, scratch, true))
    }

    /// Makes a scratch ready for [`Bvh::refit_alone`].
    pub(super) fn prepare_alone(&self, scratch: &mut SweepScratch) -> Result<(), OutOfMemory> {
        self.prepare(scratch, 1)
    }

    /// Likewise by one thread, wherever it is called.
    pub(super) fn refit_alone(&mut self, mesh: &Mesh, scratch: &mut SweepScratch) -> Refit {
        self.refit_by(mesh, scratch, false)
    }

    #[cfg(test)]
    pub(super) fn refit_once(&mut self, mesh: &Mesh) -> Refit {
        self.refit(mesh, &mut SweepScratch::default()).expect("memory")
    }

    /// How many nodes and blocks are above the subtrees.
    fn top(&self) -> (usize, usize) {
        let below = self.subtrees.first();
        below.map_or((self.nodes.len(), self.blocks.len()), |s| (s.nodes.start, s.blocks.start))
    }

    fn prepare(&self, scratch: &mut SweepScratch, threads: usize) -> Result<(), OutOfMemory> {
        scratch.prepare(&self.subtrees, self.top(), threads)
    }

    fn refit_by(&mut self, mesh: &Mesh, scratch: &mut SweepScratch, parallel: bool) -> Refit {
        if !self.can_hold(mesh) {
            return Refit::NeedsRebuild;
        }
        if self.nodes.is_empty() {
            return Refit::Done;
        }
        let (top_nodes, top_blocks) = self.top();
        let (top_nodes, nodes) = self.nodes.split_at_mut(top_nodes);
        let (top_blocks, blocks) = self.blocks.split_at_mut(top_blocks);
        scratch.sweep(&self.subtrees, (nodes, blocks), &|_| Keep, mesh, parallel);
        let whole = Subtree { nodes: 0..top_nodes.len(), blocks: 0..top_blocks.len() };
        let bounds = scratch.sweep_top(&Keep, &whole, top_nodes, top_blocks, mesh);
        self.set_bounds(bounds);
        Refit::Done
    }
}

/// What sweeps over a tree work in. Kept by whoever sweeps again.
#[derive(Debug, Default)]
pub struct SweepScratch {
    desks: Desks<SweepDesk>,
    /// The root of each subtree, and its box.
    lower: Vec<(usize, Aabb)>,
}

/// Boxes of the blocks and nodes of one part.
#[derive(Debug, Default)]
struct SweepDesk {
    leaves: Vec<BlockBox>,
    boxes: Vec<BlockBox>,
}

impl SweepDesk {
    fn prepare(&mut self, nodes: usize, blocks: usize) -> Result<(), OutOfMemory> {
        for (boxes, count) in [(&mut self.boxes, nodes), (&mut self.leaves, blocks)] {
            boxes.room(count.saturating_sub(boxes.len()))?;
        }
        Ok(())
    }
}

impl SweepScratch {
    pub(super) fn memory_bytes(&self) -> usize {
        let boxes = self.desks.sum(|desk| desk.leaves.capacity() + desk.boxes.capacity());
        boxes * size_of::<BlockBox>() + self.lower.capacity() * size_of::<(usize, Aabb)>()
    }

    /// Makes room to sweep over `subtrees`, by at most so many threads, and over as many nodes and blocks as `top` says above them.
    pub(super) fn prepare(
        &mut self,
        subtrees: &[Subtree],
        top: (usize, usize),
        threads: usize,
    ) -> Result<(), OutOfMemory> {
        let most = |a: (usize, usize), b: (usize, usize)| (a.0.max(b.0), a.1.max(b.1));
        let sizes = subtrees.iter().map(|s| (s.nodes.len(), s.blocks.len()));
        let (nodes, blocks) = sizes.fold(top, most);
        self.lower.clear();
        self.lower.room(subtrees.len())?;
        self.desks.prepare(subtrees.len().clamp(1, threads), |desk| desk.prepare(nodes, blocks))
    }

    /// Sweeps over the subtrees, whose nodes and blocks follow one another, with the topology that `fill` has of each.
    pub(super) fn sweep<F: Fill>(
        &mut self,
        subtrees: &[Subtree],
        memory: (&mut [Node8], &mut [Tri4]),
        fill: &(impl Fn(usize) -> F + Sync),
        mesh: &Mesh,
        parallel: bool,
    ) {
        self.lower.clear();
        self.lower.resize(subtrees.len(), (0, Aabb::EMPTY));
        let job = Sweeps { fill, mesh, desks: &self.desks, parallel };
        job.run(0, subtrees, memory, &mut self.lower);
    }

    /// Then sweeps over what is above them, if there is anything, and returns the box around all.
    pub(super) fn sweep_top(
        &self,
        fill: &impl Fill,
        top: &Subtree,
        nodes: &mut [Node8],
        blocks: &mut [Tri4],
        mesh: &Mesh,
    ) -> Aabb {
        match &self.lower[..] {
            [(0, bounds)] => *bounds,
            lower => self.desks.at_one(|desk| sweep(fill, top, nodes, blocks, lower, mesh, desk)),
        }
    }
}

struct Sweeps<'a, I> {
    fill: &'a I,
    mesh: &'a Mesh,
    desks: &'a Desks<SweepDesk>,
    parallel: bool,
}

impl<F: Fill, I: Fn(usize) -> F + Sync> Sweeps<'_, I> {
    /// The subtrees from number `first` on.
    fn run(
        &self,
        first: usize,
        subtrees: &[Subtree],
        (nodes, blocks): (&mut [Node8], &mut [Tri4]),
        lower: &mut [(usize, Aabb)],
    ) {
        match subtrees {
            [] => {}
            [part] => {
                let sweep =
                    |desk: &mut SweepDesk| sweep(&(self.fill)(first), part, nodes, blocks, &[], self.mesh, desk);
                lower[0] = (part.nodes.start, self.desks.at_one(sweep));
            }
            _ => {
                let middle = subtrees.len() / 2;
                let (left, right) = subtrees.split_at(middle);
                let (left_lower, right_lower) = lower.split_at_mut(middle);
                let (left_nodes, right_nodes) = nodes.split_at_mut(right[0].nodes.start - left[0].nodes.start);
                let (left_blocks, right_blocks) = blocks.split_at_mut(right[0].blocks.start - left[0].blocks.start);
                let mut run_left = || self.run(first, left, (left_nodes, left_blocks), left_lower);
                let mut run_right = || self.run(first + middle, right, (right_nodes, right_blocks), right_lower);
                if self.parallel {
                    rayon::join(run_left, run_right);
                } else {
                    run_left();
                    run_right();
                }
            }
        }
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
fn sweep(
    fill: &impl Fill,
    part: &Subtree,
    nodes: &mut [Node8],
    blocks: &mut [Tri4],
    lower: &[(usize, Aabb)],
    mesh: &Mesh,
    desk: &mut SweepDesk,
) -> Aabb {
    let SweepDesk { leaves, boxes } = desk;
    // Whatever was there will be written over.
    for (boxes, count) in [(&mut *boxes, nodes.len()), (&mut *leaves, blocks.len())] {
        boxes.resize(count.max(boxes.len()), BlockBox::EMPTY);
    }
    load(Load { mesh, blocks, prims: fill, boxes: leaves });
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
