//! From a builder's decisions to a [`Bvh`].
//!
//! Builders recurse in parallel, and each of their tasks leaves a [`Piece`]: nodes and leaves numbered from 0. What lies above
//! the pieces are [`Branch`]es of one node each. Here all are numbered through (branches first, breadth first, then the pieces in order)
//! and the blocks get their triangle numbers; the refit pass then fills in corners and bounds. So builders copy no
//! triangle, and the order of nodes and blocks does not depend on the threads.

use super::bvh::{BLOCK, Bvh, ChildRef, MAX_LEAF_BLOCKS, Node8, OutOfMemory, Subtree, Tri4, WIDTH, reserve};
use crate::scene::Mesh;
use rayon::prelude::*;

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
    nodes: Vec<Node8>,
    blocks: Vec<BlockRange>,
}

impl Piece {
    /// Appends a node without children and returns its number.
    pub(super) fn push_node(&mut self) -> usize {
        self.nodes.push(Node8::EMPTY);
        self.nodes.len() - 1
    }

    /// Makes a lane of a node point to another node of the piece.
    pub(super) fn set_node(&mut self, node: usize, lane: usize, child: usize) {
        self.nodes[node].children[lane] = ChildRef::node(child);
    }

    /// Makes a lane of a node a leaf of the triangles `start..start + count`, 1 to [`MAX_LEAF`] of them.
    pub(super) fn set_leaf(&mut self, node: usize, lane: usize, start: usize, count: usize) {
        self.nodes[node].children[lane] = push_leaf(&mut self.blocks, start, count);
    }
}

/// Appends the blocks of a leaf.
fn push_leaf(blocks: &mut Vec<BlockRange>, start: usize, count: usize) -> ChildRef {
    assert!((1..=MAX_LEAF).contains(&count), "a leaf has 1 to {MAX_LEAF} triangles, not {count}");
    let first = blocks.len();
    for begin in (start..start + count).step_by(BLOCK) {
        blocks.push(BlockRange { start: begin as u32, count: BLOCK.min(start + count - begin) as u32 });
    }
    ChildRef::leaf(first, blocks.len() - first)
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

/// Builds the tree. `prim_at` gives the triangle at a position of the builder's order; `dropped` are those without a position.
pub(super) fn assemble(
    root: Part,
    prim_at: impl Fn(usize) -> u32 + Sync,
    dropped: Vec<u32>,
    mesh: &Mesh,
) -> Result<Bvh, OutOfMemory> {
    // The top, breadth first. A queue instead of recursion numbers children above their parents by itself.
    let mut top: Vec<Node8> = Vec::new();
    let mut top_blocks: Vec<BlockRange> = Vec::new();
    let mut pieces: Vec<Piece> = Vec::new();
    let mut links: Vec<(usize, usize, usize)> = Vec::new();
    let mut queue = std::collections::VecDeque::new();
    match root {
        Part::Branch(branch) => {
            top.push(Node8::EMPTY);
            queue.push_back((0, branch));
        }
        Part::Piece(piece) => pieces.push(piece),
        Part::Leaf { start, count } => {
            let mut piece = Piece::default();
            let node = piece.push_node();
            piece.set_leaf(node, 0, start, count);
            pieces.push(piece);
        }
    }
    while let Some((node, branch)) = queue.pop_front() {
        assert!(branch.children.len() <= WIDTH, "a node has at most {WIDTH} children");
        for (lane, part) in branch.children.into_iter().enumerate() {
            match part {
                Part::Branch(child) => {
                    top[node].children[lane] = ChildRef::node(top.len());
                    queue.push_back((top.len(), child));
                    top.push(Node8::EMPTY);
                }
                Part::Piece(piece) => {
                    links.push((node, lane, pieces.len()));
                    pieces.push(piece);
                }
                Part::Leaf { start, count } => {
                    top[node].children[lane] = push_leaf(&mut top_blocks, start, count);
                }
            }
        }
    }

    // Where everything goes.
    let mut subtrees = Vec::with_capacity(pieces.len());
    let (mut node_count, mut block_count) = (top.len(), top_blocks.len());
    for piece in &pieces {
        let subtree = Subtree {
            nodes: node_count..node_count + piece.nodes.len(),
            blocks: block_count..block_count + piece.blocks.len(),
        };
        (node_count, block_count) = (subtree.nodes.end, subtree.blocks.end);
        subtrees.push(subtree);
    }
    if node_count >= ChildRef::MAX_INDEX || block_count >= ChildRef::MAX_INDEX {
        return Err(OutOfMemory { bytes: block_count * size_of::<Tri4>() });
    }
    for (node, lane, piece) in links {
        top[node].children[lane] = ChildRef::node(subtrees[piece].nodes.start);
    }

    let mut nodes: Vec<Node8> = reserve(node_count)?;
    nodes.append(&mut top);
    for (piece, subtree) in pieces.iter().zip(&subtrees) {
        nodes.extend(piece.nodes.iter().map(|node| {
            let mut node = *node;
            for child in node.children.iter_mut().filter(|c| !c.is_empty()) {
                *child = if child.is_leaf() {
                    let run = child.blocks();
                    ChildRef::leaf(run.start + subtree.blocks.start, run.len())
                } else {
                    ChildRef::node(child.index() + subtree.nodes.start)
                };
            }
            node
        }));
    }

    let mut ranges: Vec<BlockRange> = reserve(block_count)?;
    ranges.append(&mut top_blocks);
    for piece in &mut pieces {
        ranges.append(&mut piece.blocks);
    }
    drop(pieces);
    let mut blocks: Vec<Tri4> = reserve(block_count)?;
    ranges
        .par_iter()
        .map(|range| {
            let prim = |lane: usize| prim_at(range.start as usize + lane.min(range.count as usize - 1));
            Tri4 { corners: [[[0.0; BLOCK]; 3]; 3], prims: std::array::from_fn(prim) }
        })
        .collect_into_vec(&mut blocks);
    drop(ranges);

    let mut bvh = Bvh::from_topology(nodes, blocks, subtrees, dropped, mesh.triangles.len());
    bvh.fill(mesh);
    Ok(bvh)
}
