//! Cuts a tree into segments, the units of [`super::lazy`].
//!
//! A segment is a part of the tree that is updated at once: nodes connected with each other, and the blocks of their leaves. Where a child begins another segment, its
//! lane refers to a "leaf" beyond the segment's own blocks: `blocks + k` is the `k`-th segment below. Segments are numbered breadth
//! first, so those below one are in a row; within a segment nodes are in depth-first order, so that every reference is to a higher number.
//!
//! Where to cut: the top ends where a subtree has no more than so many triangles, or at half the height, the rule of Larsson03 §3.2. Below, a segment
//! has all levels or so many.
//!
//! Triangles that were unusable at the build are not lost as they are for a refit: they hang below the root in a tree of their own,
//! in the order of their numbers, with empty boxes as long as nothing can hit them. So no change of vertices ever asks for a build.

use super::OutOfMemory;
use super::bvh::{BLOCK, Bvh, ChildRef, MAX_LEAF_BLOCKS, Tri4, WIDTH};
use super::memory::reserve;
use crate::scene::{LazyShape, Mesh};
use rayon::prelude::*;
use std::collections::VecDeque;
use std::ops::Range;

/// What never changes of a tree: who is whose child, in segments.
#[derive(Debug, Default)]
pub(super) struct Topology {
    /// Per node; references count from the first node and block of the segment.
    pub children: Vec<[ChildRef; WIDTH]>,
    /// Per block.
    pub prims: Vec<[u32; BLOCK]>,
    /// The top first.
    pub segments: Vec<Segment>,
    /// Of all segments but the top, one after the other: each vertex of its triangles and of those below once, ascending.
    pub vertices: Vec<u32>,
    /// Triangles that were unusable when the tree was built.
    pub dropped: usize,
}

#[derive(Clone, Debug, Default)]
pub(super) struct Segment {
    pub nodes: Range<usize>,
    pub blocks: Range<usize>,
    /// The segments below it.
    pub below: Range<usize>,
    pub vertices: Range<usize>,
    /// Its triangles were unusable at the build.
    pub dropped: bool,
}

impl Topology {
    pub fn memory_bytes(&self) -> usize {
        self.children.capacity() * size_of::<[ChildRef; WIDTH]>()
            + self.prims.capacity() * size_of::<[u32; BLOCK]>()
            + self.segments.capacity() * size_of::<Segment>()
            + self.vertices.capacity() * size_of::<u32>()
    }

    /// Blocks that have their triangles' numbers, but no corners yet.
    pub fn empty_blocks(&self, blocks: Range<usize>) -> impl Iterator<Item = Tri4> {
        self.prims[blocks].iter().map(|&prims| Tri4 { prims, ..Tri4::EMPTY })
    }

    /// Cuts the tree of `mesh`. To be called inside the pool.
    pub fn new(bvh: &Bvh, mesh: &Mesh, shape: LazyShape) -> Result<Self, OutOfMemory> {
        let plain = Plain::new(bvh)?;
        let mut topology = Topology {
            children: reserve(plain.children.len())?,
            prims: reserve(plain.prims.len())?,
            dropped: bvh.dropped.len(),
            ..Topology::default()
        };
        if plain.children.is_empty() {
            return Ok(topology);
        }
        let rule = Rule::new(&plain, bvh.depth(), shape);
        let mut queue = VecDeque::from([0usize]);
        while let Some(root) = queue.pop_front() {
            let number = topology.segments.len();
            let first = number + 1 + queue.len();
            let mut cutter = Cutter { plain: &plain, rule: &rule, topology: &mut topology, number, below: Vec::new() };
            let segment = cutter.cut(root, first);
            queue.extend(cutter.below.iter().map(|(root, _)| root));
            topology.segments.push(segment);
        }
        topology.list_vertices(mesh)?;
        Ok(topology)
    }

    fn list_vertices(&mut self, mesh: &Mesh) -> Result<(), OutOfMemory> {
        let this = &*self;
        let mut lists: Vec<Vec<u32>> = (1..self.segments.len())
            .into_par_iter()
            .map(|number| {
                let mut vertices = Vec::new();
                this.each_block(number, &mut |prims: &[u32; BLOCK]| {
                    vertices.extend(prims.iter().flat_map(|&prim| mesh.triangles[prim as usize]));
                });
                vertices.sort_unstable();
                vertices.dedup();
                vertices.shrink_to_fit();
                vertices
            })
            .collect();
        let mut vertices = reserve(lists.iter().map(Vec::len).sum())?;
        for (segment, list) in self.segments[1..].iter_mut().zip(&mut lists) {
            segment.vertices = vertices.len()..vertices.len() + list.len();
            vertices.append(list);
        }
        self.vertices = vertices;
        Ok(())
    }

    /// The blocks of a segment and of all below it.
    fn each_block(&self, number: usize, to: &mut impl FnMut(&[u32; BLOCK])) {
        let segment = &self.segments[number];
        self.prims[segment.blocks.clone()].iter().for_each(&mut *to);
        for below in segment.below.clone() {
            self.each_block(below, to);
        }
    }
}

/// The tree to be cut, with the dropped triangles hung up.
struct Plain {
    children: Vec<[ChildRef; WIDTH]>,
    prims: Vec<[u32; BLOCK]>,
    /// Triangles below each node.
    triangles: Vec<u32>,
    /// The nodes from this one on are over dropped triangles.
    dropped_root: usize,
}

impl Plain {
    fn new(bvh: &Bvh) -> Result<Self, OutOfMemory> {
        let dropped = &bvh.dropped;
        // A new root, if there are two trees.
        let shift = usize::from(!dropped.is_empty() && !bvh.is_empty());
        let mut children = reserve(bvh.nodes().len() + dropped.len().div_ceil(BLOCK) + shift)?;
        let mut prims = reserve(bvh.blocks().len() + dropped.len().div_ceil(BLOCK))?;
        children.resize(shift, [ChildRef::EMPTY; WIDTH]);
        let shifted = |c: ChildRef| if c.is_leaf() { c } else { ChildRef::node(c.index() + shift) };
        children.extend(bvh.nodes().iter().map(|node| node.children.map(shifted)));
        prims.extend(bvh.blocks().iter().map(|block| block.prims));
        let dropped_root = children.len();
        let mut plain = Plain { children, prims, triangles: Vec::new(), dropped_root };
        if !dropped.is_empty() {
            let root = plain.hang_up(dropped);
            if shift > 0 {
                plain.children[0][..2].copy_from_slice(&[ChildRef::node(1), root]);
            }
        }
        if plain.children.len().max(plain.prims.len()) >= ChildRef::MAX_INDEX / 2 {
            return Err(OutOfMemory { bytes: plain.prims.len() * size_of::<super::Tri4>() });
        }
        plain.count();
        Ok(plain)
    }

    /// Appends a node over triangles in the order given.
    fn hang_up(&mut self, triangles: &[u32]) -> ChildRef {
        let node = self.children.len();
        self.children.push([ChildRef::EMPTY; WIDTH]);
        let most = MAX_LEAF_BLOCKS * BLOCK;
        let share = triangles.len().div_ceil(WIDTH).max(BLOCK);
        for (lane, triangles) in triangles.chunks(share).enumerate() {
            self.children[node][lane] = if triangles.len() > most {
                self.hang_up(triangles)
            } else {
                let first = self.prims.len();
                for run in triangles.chunks(BLOCK) {
                    self.prims.push(std::array::from_fn(|i| run[i.min(run.len() - 1)]));
                }
                ChildRef::leaf(first, self.prims.len() - first)
            };
        }
        ChildRef::node(node)
    }

    fn count(&mut self) {
        self.triangles = vec![0; self.children.len()];
        for node in (0..self.children.len()).rev() {
            let below = |child: &ChildRef| {
                if child.is_leaf() {
                    // Repeated ones fill a block up.
                    let distinct = |prims: &[u32; BLOCK]| 1 + prims.windows(2).filter(|w| w[0] != w[1]).count() as u32;
                    self.prims[child.blocks()].iter().map(distinct).sum()
                } else {
                    self.triangles[child.index()]
                }
            };
            let sum = self.children[node].iter().take_while(|c| !c.is_empty()).map(below).sum();
            self.triangles[node] = sum;
        }
    }
}

/// Where segments end.
struct Rule {
    /// The top ends above nodes of this many triangles or less,
    triangles: u32,
    /// and where it has this many levels.
    top_levels: usize,
    levels: usize,
}

impl Rule {
    fn new(plain: &Plain, depth: usize, shape: LazyShape) -> Self {
        let all = plain.triangles[0];
        let levels = if shape.levels == 0 { usize::MAX } else { shape.levels as usize };
        match shape.cut {
            // The leaves are at the height `depth`, in the paper's count.
            0 => Rule { triangles: 0, top_levels: (depth / 2).max(1), levels },
            cut if all <= cut => Rule { triangles: 0, top_levels: levels, levels },
            cut => Rule { triangles: cut, top_levels: usize::MAX, levels },
        }
    }

    /// Whether a child on level `level` of a segment (its root is on 0) begins another one.
    fn cuts(&self, is_top: bool, level: usize, triangles: u32) -> bool {
        if is_top { triangles <= self.triangles || level >= self.top_levels } else { level >= self.levels }
    }
}

struct Cutter<'a> {
    plain: &'a Plain,
    rule: &'a Rule,
    topology: &'a mut Topology,
    number: usize,
    /// Roots of the segments below, each with the node and lane that refer to it.
    below: Vec<(usize, (usize, usize))>,
}

impl Cutter<'_> {
    fn cut(&mut self, root: usize, first_below: usize) -> Segment {
        let nodes = self.topology.children.len();
        let blocks = self.topology.prims.len();
        self.node(root, 0, (nodes, blocks));
        let end = self.topology.prims.len();
        // How many blocks there are is known only now.
        for (k, (_, (node, lane))) in self.below.iter().enumerate() {
            self.topology.children[*node][*lane] = ChildRef::leaf(end - blocks + k, 1);
        }
        Segment {
            nodes: nodes..self.topology.children.len(),
            blocks: blocks..end,
            below: first_below..first_below + self.below.len(),
            vertices: 0..0,
            dropped: root >= self.plain.dropped_root,
        }
    }

    /// Appends a node and what is below it in the segment. The recursion is bounded by the depth of the tree.
    fn node(&mut self, from: usize, level: usize, first: (usize, usize)) {
        let node = self.topology.children.len();
        self.topology.children.push([ChildRef::EMPTY; WIDTH]);
        for lane in 0..WIDTH {
            let child = self.plain.children[from][lane];
            if child.is_empty() {
                break;
            }
            self.topology.children[node][lane] = if child.is_leaf() {
                let start = self.topology.prims.len() - first.1;
                self.topology.prims.extend_from_slice(&self.plain.prims[child.blocks()]);
                ChildRef::leaf(start, child.blocks().len())
            } else if self.rule.cuts(self.number == 0, level + 1, self.plain.triangles[child.index()]) {
                self.below.push((child.index(), (node, lane)));
                continue;
            } else {
                let below = self.topology.children.len() - first.0;
                self.node(child.index(), level + 1, first);
                ChildRef::node(below)
            };
        }
    }
}
