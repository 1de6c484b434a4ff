//! Cuts a tree into segments, the units of [`super::lazy`].
//!
//! A segment is a part of the tree that is updated at once: nodes connected with each other, and the vertices of the triangles in their leaves. Nodes, blocks and
//! vertices are numbered through the whole tree, those of a segment in a row, so rays go from segment to segment without noticing but for one thing: where a
//! child begins another segment, its lane refers to a "leaf" beyond all blocks, `blocks + k` for segment `k`. Segments are numbered breadth
//! first, so those below one are in a row; within a segment nodes are in depth-first order, so that every reference is to a higher number.
//!
//! Where to cut: the top ends where a subtree has no more than so many triangles, or at half the height, the rule of Larsson03 §3.2. Below, a segment
//! has all levels or so many.
//!
//! Triangles that were unusable at the build are not lost as they are for a refit: they hang below the root in a tree of their own,
//! in the order of their numbers, with empty boxes as long as nothing can hit them. So no change of vertices ever asks for a build.

use super::OutOfMemory;
use super::bvh::{BLOCK, Bvh, ChildRef, MAX_DEPTH, MAX_LEAF_BLOCKS, WIDTH};
use super::lazy_number::{Distinct, MANY, Outline};
use super::memory::{ask, cloned, copied, filled, reserve};
use super::vertex_runs::{Marks, VertexSet};
use crate::scene::{LazyShape, Mesh};
use crate::simd::{Places, place_of};
use rayon::prelude::*;
use std::ops::Range;

/// Four triangles: where their corners are among the vertices of the tree, and their numbers.
///
/// A quarter of what a block with corners copied in takes, and never written after the build. A block with fewer than four repeats its last one.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct LazyBlock {
    /// `[corner][lane]`.
    pub corners: Places,
    pub prims: [u32; BLOCK],
}

/// What never changes of a tree: who is whose child, in segments.
///
/// Invariants, relied upon by the unchecked loads of traversal:
/// * the children of node `i` that are nodes are of its segment, with numbers above `i`; those that are segments have numbers above that of their parent;
/// * every child is a node, a run of blocks of the segment, a segment, or empty;
/// * the corners of a segment's blocks are among its own vertices;
/// * no path has more than [`MAX_DEPTH`] nodes.
#[derive(Debug, Default)]
pub(super) struct Topology {
    /// Per node.
    pub children: Vec<[ChildRef; WIDTH]>,
    pub blocks: Vec<LazyBlock>,
    /// Per block.
    pub outlines: Vec<Outline>,
    /// The top first.
    pub segments: Vec<Segment>,
    /// Per vertex that the tree holds, its number in the mesh.
    pub vertices: Vec<u32>,
    /// Lists for [`Segment::around`].
    pub around: Vec<u32>,
    /// Triangles that were unusable when the tree was built.
    pub dropped: usize,
}

#[derive(Clone, Debug, Default)]
pub(super) struct Segment {
    pub nodes: Range<usize>,
    pub blocks: Range<usize>,
    /// The segments below it.
    pub below: Range<usize>,
    /// The vertices of its own triangles, among those that the tree holds.
    pub held: Range<usize>,
    /// Those of its own triangles and of all below, for its box. The top has no use for that.
    pub around: VertexSet,
    /// Its triangles were unusable at the build.
    pub dropped: bool,
}

impl Topology {
    /// A copy.
    pub(super) fn try_clone(&self) -> Result<Self, OutOfMemory> {
        Ok(Self {
            children: copied(&self.children)?,
            blocks: copied(&self.blocks)?,
            outlines: copied(&self.outlines)?,
            segments: cloned(&self.segments)?,
            vertices: copied(&self.vertices)?,
            around: copied(&self.around)?,
            dropped: self.dropped,
        })
    }

    pub fn memory_bytes(&self) -> usize {
        self.children.capacity() * size_of::<[ChildRef; WIDTH]>()
            + self.blocks.capacity() * size_of::<LazyBlock>()
            + self.outlines.capacity() * size_of::<Outline>()
            + self.segments.capacity() * size_of::<Segment>()
            + (self.vertices.capacity() + self.around.capacity()) * size_of::<u32>()
    }

    /// Cuts the tree of `mesh`. To be called inside the pool.
    pub fn new(bvh: &Bvh, mesh: &Mesh, shape: LazyShape) -> Result<Self, OutOfMemory> {
        let plain = Plain::new(bvh)?;
        let mut topology = Topology {
            children: reserve(plain.children.len())?,
            blocks: reserve(plain.prims.len())?,
            dropped: bvh.dropped.len(),
            ..Topology::default()
        };
        if plain.children.is_empty() {
            return Ok(topology);
        }
        // One node may be above the root, and dropped triangles are below few.
        assert!(bvh.depth() < MAX_DEPTH, "builders bound the depth");
        let rule = Rule::new(&plain, bvh.depth(), shape);
        // Roots of segments, of which there are at most as many as nodes.
        let mut roots: Vec<u32> = reserve(plain.children.len())?;
        roots.push(0);
        while let Some(&root) = roots.get(topology.segments.len()) {
            let number = topology.segments.len();
            ask(&mut topology.segments, number + 1)?;
            let mut cutter = Cutter { plain: &plain, rule: &rule, topology: &mut topology, number, roots: &mut roots };
            let segment = cutter.cut(root as usize);
            topology.segments.push(segment);
        }
        topology.list_vertices(mesh)?;
        Ok(topology)
    }

    /// Lists the vertices of all segments, and tells the blocks where their corners are among them.
    fn list_vertices(&mut self, mesh: &Mesh) -> Result<(), OutOfMemory> {
        let mut cut: Vec<(&mut [LazyBlock], &mut [Outline])> = reserve(self.segments.len())?;
        self.outlines = filled(Vec::new(), self.blocks.len(), MANY)?;
        let (mut blocks, mut outlines) = (&mut self.blocks[..], &mut self.outlines[..]);
        for segment in &self.segments {
            let (own, others) = blocks.split_at_mut(segment.blocks.len());
            let (own_outlines, other_outlines) = outlines.split_at_mut(segment.blocks.len());
            cut.push((own, own_outlines));
            (blocks, outlines) = (others, other_outlines);
        }
        // The numbers of corners within the segment at first.
        let mut own: Vec<Result<Vec<u32>, OutOfMemory>> = reserve(cut.len())?;
        cut.into_par_iter()
            .map_init(Distinct::default, |list, (blocks, outlines)| list.number_corners(mesh, blocks, outlines))
            .collect_into_vec(&mut own);
        let mut vertices = reserve(own.iter().flatten().map(Vec::len).sum())?;
        for (segment, own) in self.segments.iter_mut().zip(own) {
            let own = own?;
            segment.held = vertices.len()..vertices.len() + own.len();
            vertices.extend_from_slice(&own);
        }
        self.vertices = vertices;
        let mut rest = &mut self.blocks[..];
        for segment in &self.segments {
            let (own, others) = rest.split_at_mut(segment.blocks.len());
            rest = others;
            for block in own {
                block.corners = block.corners.map(|lanes| lanes.map(|i| place_of(segment.held.start + i as usize)));
            }
        }
        self.list_around(mesh)
    }

    /// Lists the vertices that the boxes of segments are around.
    fn list_around(&mut self, mesh: &Mesh) -> Result<(), OutOfMemory> {
        let this = &*self;
        let sets = (1..self.segments.len()).into_par_iter().map_init(Marks::default, |marks, number| {
            marks.prepare(mesh.positions.len())?;
            this.each_list(number, &mut |list| marks.mark(list));
            marks.take()
        });
        let mut found: Vec<Result<[Vec<u32>; 2], OutOfMemory>> = reserve(self.segments.len() - 1)?;
        sets.collect_into_vec(&mut found);
        let mut around = reserve(found.iter().flatten().flatten().map(Vec::len).sum())?;
        for (segment, set) in self.segments.iter_mut().skip(1).zip(found) {
            let [runs, rest] = set?;
            let middle = around.len() + runs.len();
            segment.around = VertexSet { runs: around.len()..middle, rest: middle..middle + rest.len() };
            around.extend_from_slice(&runs);
            around.extend_from_slice(&rest);
        }
        self.around = around;
        Ok(())
    }

    /// The vertices of a segment and those of all below it.
    fn each_list(&self, number: usize, to: &mut dyn FnMut(&[u32])) {
        let segment = &self.segments[number];
        to(&self.vertices[segment.held.clone()]);
        for below in segment.below.clone() {
            self.each_list(below, to);
        }
    }

    /// The segment that a leaf stands for, if it is not of blocks.
    #[inline(always)]
    pub fn segment_of_leaf(&self, leaf: ChildRef) -> Option<usize> {
        leaf.blocks().start.checked_sub(self.blocks.len())
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
            return Err(OutOfMemory { bytes: plain.prims.len() * size_of::<LazyBlock>() });
        }
        plain.count()?;
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

    fn count(&mut self) -> Result<(), OutOfMemory> {
        self.triangles = filled(Vec::new(), self.children.len(), 0)?;
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
        Ok(())
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
    /// Of all segments so far.
    roots: &'a mut Vec<u32>,
}

impl Cutter<'_> {
    fn cut(&mut self, root: usize) -> Segment {
        let nodes = self.topology.children.len();
        let (blocks, below) = (self.topology.blocks.len(), self.roots.len());
        self.node(root, 0);
        Segment {
            nodes: nodes..self.topology.children.len(),
            blocks: blocks..self.topology.blocks.len(),
            below: below..self.roots.len(),
            dropped: root >= self.plain.dropped_root,
            ..Segment::default()
        }
    }

    /// Appends a node and what is below it in the segment. The recursion is bounded by the depth of the tree.
    fn node(&mut self, from: usize, level: usize) {
        let node = self.topology.children.len();
        self.topology.children.push([ChildRef::EMPTY; WIDTH]);
        for lane in 0..WIDTH {
            let child = self.plain.children[from][lane];
            if child.is_empty() {
                break;
            }
            self.topology.children[node][lane] = if child.is_leaf() {
                let start = self.topology.blocks.len();
                let prims = &self.plain.prims[child.blocks()];
                // Corners are placed when all vertices are known.
                self.topology.blocks.extend(prims.iter().map(|&prims| LazyBlock { corners: [[0; BLOCK]; 3], prims }));
                ChildRef::leaf(start, prims.len())
            } else if self.rule.cuts(self.number == 0, level + 1, self.plain.triangles[child.index()]) {
                self.roots.push(child.index() as u32);
                ChildRef::leaf(self.plain.prims.len() + self.roots.len() - 1, 1)
            } else {
                let below = self.topology.children.len();
                self.node(child.index(), level + 1);
                ChildRef::node(below)
            };
        }
    }
}
