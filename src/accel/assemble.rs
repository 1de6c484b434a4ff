//! From a builder's decisions to a [`Bvh`].
//!
//! Builders recurse in parallel, and each of their tasks leaves a [`Piece`]: nodes and leaves numbered from 0. What lies above
//! the pieces are [`Branch`]es of one node each. Here all are numbered through (branches first, breadth first, then the pieces in order).
//! Then every piece is written to its place by the sweep of the refit, which gets children and triangle numbers from the
//! piece instead of the tree: one pass over the memory of the tree, in parallel. So builders copy no triangle, bounds come from one
//! place, and the order of nodes and blocks does not depend on the threads.
//!
//! The arrays of a former tree are used again. Fresh memory has to be cleared by the system page by page, which took a
//! fifth of the time of a build of 1.3 M triangles.

use super::block_loader::{BlockBox, Prims};
use super::bvh::{BLOCK, Bvh, ChildRef, MAX_LEAF_BLOCKS, Node8, OutOfMemory, Subtree, Tri4, WIDTH};
use super::memory::filled;
use super::prim_ref::Box4;
use super::refit::{Fill, SweepScratch};
use crate::memory::{Room, collected, push, vec_of};
use crate::scene::Mesh;
use rayon::prelude::*;
use std::ops::Range;

/// Triangles of a leaf at most.
pub(super) const MAX_LEAF: usize = MAX_LEAF_BLOCKS * BLOCK;

/// A run in the builder's order of triangles, that becomes one block.
#[derive(Clone, Copy, Debug)]
struct BlockRange {
    start: u32,
    count: u32,
}

/// A finished subtree with at least one node, root first.
#[derive(Debug, Default)]
pub(super) struct Piece {
    nodes: Vec<[ChildRef; WIDTH]>,
    blocks: Vec<BlockRange>,
}

impl Piece {
    /// A piece that will hold about so many triangles.
    pub(super) fn with_room_for(count: usize) -> Result<Self, OutOfMemory> {
        Ok(Self { nodes: vec_of(count / 14 + 4)?, blocks: vec_of(count / 3 + 4)? })
    }

    /// Appends a node without children and returns its number.
    pub(super) fn push_node(&mut self) -> Result<usize, OutOfMemory> {
        push(&mut self.nodes, [ChildRef::EMPTY; WIDTH])?;
        Ok(self.nodes.len() - 1)
    }

    /// Makes a lane of a node point to another node of the piece.
    pub(super) fn set_node(&mut self, node: usize, lane: usize, child: usize) {
        self.nodes[node][lane] = ChildRef::node(child);
    }

    /// Makes a lane of a node a leaf of the triangles `start..start + count`, 1 to [`MAX_LEAF`] of them.
    pub(super) fn set_leaf(&mut self, node: usize, lane: usize, start: usize, count: usize) -> Result<(), OutOfMemory> {
        assert!((1..=MAX_LEAF).contains(&count), "a leaf has 1 to {MAX_LEAF} triangles, not {count}");
        let first = self.blocks.len();
        for begin in (start..start + count).step_by(BLOCK) {
            let count = BLOCK.min(start + count - begin) as u32;
            push(&mut self.blocks, BlockRange { start: begin as u32, count })?;
        }
        self.nodes[node][lane] = ChildRef::leaf(first, self.blocks.len() - first);
        Ok(())
    }
}

/// A node above the pieces.
#[derive(Debug)]
pub(super) struct Branch {
    pub(super) children: Vec<Part>,
}

/// What a branch's lane holds.
#[derive(Debug)]
pub(super) enum Part {
    Branch(Branch),
    Piece(Piece),
    Leaf { start: usize, count: usize },
}

impl Part {
    /// A node whose lanes hold what `part` makes of the tasks, in parallel.
    pub(super) fn branch<T: Send>(
        tasks: Vec<T>,
        part: impl Fn(T) -> Result<Part, OutOfMemory> + Sync + Send,
    ) -> Result<Part, OutOfMemory> {
        let count = tasks.len();
        let (mut found, mut children) = (vec_of(count)?, vec_of(count)?);
        tasks.into_par_iter().with_max_len(1).map(part).collect_into_vec(&mut found);
        for part in found {
            children.push(part?);
        }
        Ok(Part::Branch(Branch { children }))
    }
}

/// The nodes above the pieces, which are a piece themselves, and the pieces with the lanes that point to them.
struct Layout {
    top: Piece,
    pieces: Vec<Piece>,
    links: Vec<(usize, usize)>,
}

impl Layout {
    /// Breadth first: a queue instead of recursion numbers children above their parents by itself.
    fn new(root: Part) -> Result<Self, OutOfMemory> {
        let mut layout = Layout { top: Piece::default(), pieces: Vec::new(), links: Vec::new() };
        let mut queue = std::collections::VecDeque::new();
        match root {
            Part::Piece(piece) => push(&mut layout.pieces, piece)?,
            Part::Branch(branch) => {
                queue.room(1)?;
                queue.push_back((layout.top.push_node()?, branch));
            }
            Part::Leaf { start, count } => {
                let mut piece = Piece::default();
                let node = piece.push_node()?;
                piece.set_leaf(node, 0, start, count)?;
                push(&mut layout.pieces, piece)?;
            }
        }
        while let Some((node, branch)) = queue.pop_front() {
            assert!(branch.children.len() <= WIDTH, "a node has at most {WIDTH} children");
            for (lane, part) in branch.children.into_iter().enumerate() {
                match part {
                    Part::Branch(branch) => {
                        let child = layout.top.push_node()?;
                        layout.top.set_node(node, lane, child);
                        queue.room(1)?;
                        queue.push_back((child, branch));
                    }
                    Part::Piece(piece) => {
                        push(&mut layout.links, (node, lane))?;
                        push(&mut layout.pieces, piece)?;
                    }
                    Part::Leaf { start, count } => layout.top.set_leaf(node, lane, start, count)?,
                }
            }
        }
        Ok(layout)
    }

    /// Where the pieces go, and how many nodes and blocks there are.
    fn places(&self) -> Result<(Vec<Subtree>, usize, usize), OutOfMemory> {
        let (mut nodes, mut blocks) = (self.top.nodes.len(), self.top.blocks.len());
        let places = self.pieces.iter().map(|piece| {
            let place =
                Subtree { nodes: nodes..nodes + piece.nodes.len(), blocks: blocks..blocks + piece.blocks.len() };
            (nodes, blocks) = (place.nodes.end, place.blocks.end);
            place
        });
        Ok((collected(places)?, nodes, blocks))
    }
}

/// The builder's order.
pub(super) trait Order: Sync {
    /// The triangle at a position.
    fn prim(&self, position: usize) -> u32;

    /// The box around the part of it that is meant, if it is not all of it.
    #[inline(always)]
    fn part(&self, _position: usize) -> Option<Box4> {
        None
    }
}

impl<F: Fn(usize) -> u32 + Sync> Order for F {
    #[inline(always)]
    fn prim(&self, position: usize) -> u32 {
        self(position)
    }
}

/// Builds the tree of `order`; `dropped` are the triangles without a position. The memory of `old` is used again.
pub(super) fn assemble(
    root: Part,
    order: impl Order,
    dropped: Vec<u32>,
    mesh: &Mesh,
    old: Bvh,
    scratch: &mut SweepScratch,
) -> Result<Bvh, OutOfMemory> {
    let mut layout = Layout::new(root)?;
    let (subtrees, node_count, block_count) = layout.places()?;
    if node_count >= ChildRef::MAX_INDEX || block_count >= ChildRef::MAX_INDEX {
        return Err(OutOfMemory { bytes: block_count * size_of::<Tri4>() });
    }
    let mut nodes = filled(old.nodes, node_count, Node8::EMPTY)?;
    let mut blocks = filled(old.blocks, block_count, Tri4::EMPTY)?;

    // The pieces.
    let top = (layout.top.nodes.len(), layout.top.blocks.len());
    scratch.prepare(&subtrees, top, usize::MAX)?;
    let (top_nodes, below_nodes) = nodes.split_at_mut(top.0);
    let (top_blocks, below_blocks) = blocks.split_at_mut(top.1);
    let fill = |i: usize| FromPiece { piece: &layout.pieces[i], at: &subtrees[i], order: &order };
    scratch.sweep(&subtrees, (below_nodes, below_blocks), &fill, mesh, true);

    // The nodes above them.
    for ((node, lane), subtree) in layout.links.iter().zip(&subtrees) {
        layout.top.nodes[*node][*lane] = ChildRef::node(subtree.nodes.start);
    }
    let whole = Subtree { nodes: 0..top.0, blocks: 0..top.1 };
    let fill = FromPiece { piece: &layout.top, at: &whole, order: &order };
    let bounds = scratch.sweep_top(&fill, &whole, top_nodes, top_blocks, mesh);
    Ok(Bvh::from_parts(nodes, blocks, subtrees, dropped, mesh.triangles.len(), bounds))
}

/// Children and triangle numbers from a piece, moved to its place in the tree.
struct FromPiece<'a, O> {
    piece: &'a Piece,
    at: &'a Subtree,
    order: &'a O,
}

impl<O: Order> Fill for FromPiece<'_, O> {
    #[inline(always)]
    fn leaf(&self, run: Range<usize>) -> Option<BlockBox> {
        let blocks = &self.piece.blocks[run];
        let positions = blocks.iter().flat_map(|b| b.start as usize..b.start as usize + b.count as usize);
        let mut parts = positions.map(|position| self.order.part(position));
        let first = parts.next()??;
        let union = |all: BlockBox, part: Box4| all.union(&BlockBox { lo: part.lo(), hi: part.hi() });
        Some(parts.flatten().fold(BlockBox { lo: first.lo(), hi: first.hi() }, union))
    }

    #[inline(always)]
    fn node(&self, index: usize, node: &mut Node8) {
        node.children = [ChildRef::EMPTY; WIDTH];
        for (to, from) in node.children.iter_mut().zip(&self.piece.nodes[index]) {
            if from.is_empty() {
                break;
            }
            *to = if from.is_leaf() {
                let run = from.blocks();
                ChildRef::leaf(run.start + self.at.blocks.start, run.len())
            } else {
                ChildRef::node(from.index() + self.at.nodes.start)
            };
        }
    }
}

impl<O: Order> Prims for FromPiece<'_, O> {
    #[inline(always)]
    fn prims(&self, _: &[Tri4], index: usize) -> [u32; BLOCK] {
        let range = self.piece.blocks[index];
        let (start, last) = (range.start as usize, range.count as usize - 1);
        let prim = |lane: usize| self.order.prim(start + lane.min(last));
        [prim(0), prim(1), prim(2), prim(3)]
    }
}
