//! The tree that is brought up to date by the rays that reach it (Larsson and Akenine-Möller, *Strategies for Bounding Volume Hierarchy Updates for
//! Ray Tracing of Deformable Models*, 2003, §3).
//!
//! The hierarchy is built once, and cut into segments ([`super::lazy_cut`]): a top, and subtrees below it. When vertices have moved,
//! an update only says so, by counting up one number. The first ray that reaches a segment writes it: blocks from the triangles, the boxes of segments
//! below from their vertices, each shared vertex once ([`super::vertex_box`]), the nodes above by merging. For the top that is the paper's hybrid update of
//! the middle level and all above it; for the segments below it is one of the paper's heuristics, all levels of a subtree at once, or a few, or one
//! ([`LazyShape`]).
//!
//! *Where we differ.* Even the middle level waits for a ray, so an object that no ray meets costs the box around its vertices and nothing else. But the top of
//! an object that was met in the frame before is written at the update, by all threads. A stamp belongs to a segment, not to a node: the loop over nodes
//! is that of any tree, and structures of other strategies pay nothing. Paper and field write boxes in one thread; here any
//! thread may be the first ([`OnTouch`]): it alone writes the segment, and one that comes while it does writes a private copy rather than wait.
//!
//! *Same hits.* Boxes from vertices are a little larger than those from triangles, and contain them; a box that is larger never changes a hit.
//!
//! *Measured* on nine bodies of 81,920 triangles, primary and shadow rays, all bodies in sight (`cargo bench --bench peers -- lazy`; one thread, a busy machine, a build
//! of the development profile, so the ratios count and not the times). A complete refit takes 18.6 ns per triangle in a tree
//! whose leaves hold several triangles; so there is less to save than in the paper, whose hold one. Update before the first ray 8.4 times cheaper with subtrees of 1024
//! triangles, 11.6 times with 4096 (paper: 17); update and rays together 1.35 times with 5×5 sub-sampling (paper: 1.5) and 1.69 times with 10×10 (paper: 2.6).
//! Subtrees of 256 to 4096 triangles and half the height are alike in total. One level at a time is slower than a refit with 5×5 (0.96), as the
//! same vertices are looked at on each level; two levels at a time are up to a tenth slower than all. The paper prefers one level; its nodes hold one box and one triangle.
//!
//! *The mesh* is that of the scene, by a weak reference: a change of the scene then need not copy it, but cuts the tree off until the update that must follow.

use super::block_loader::{BlockBox, Load, load};
use super::bvh::{ChildRef, Node8, OutOfMemory, Tri4, WIDTH};
use super::lazy_cut::{Segment, Topology};
use super::links::Links;
use super::memory::reserve;
use super::refit::{Keep, set_bounds};
use super::vertex_box::{box_of_all, box_of_listed};
use super::{Aabb, build_sah};
use crate::scene::{LazyShape, Mesh};
use crate::threads::OnTouch;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::{Arc, Weak};

/// Triangles that were dropped at the build and can be hit again ask for a build if they are more than this part of all.
const MANY_DROPPED: usize = 8;

/// Where a tree finds its vertices.
#[derive(Debug)]
pub(super) enum Source {
    Scene(Weak<Mesh>),
    /// In world space.
    Own(Arc<Mesh>),
}

impl Source {
    pub(super) fn mesh(&self) -> Arc<Mesh> {
        match self {
            Source::Scene(mesh) => {
                mesh.upgrade().expect("after a change of the scene, no ray is traced before an update")
            }
            Source::Own(mesh) => mesh.clone(),
        }
    }
}

/// A tree in segments; number 0 is the top.
#[derive(Debug)]
pub struct LazyBvh {
    pub(super) topology: Topology,
    pub(super) parts: OnTouch<Node8, Tri4>,
    source: Source,
    pub(super) bounds: Aabb,
    prim_count: usize,
    /// A triangle that was unusable at the build has been seen usable.
    revived: AtomicBool,
    touched: Touched,
    /// For partial updates, once there has been one.
    pub(super) links: Option<Links>,
}

/// What rays have had updated.
#[derive(Debug, Default)]
struct Touched {
    segments: AtomicU32,
    nodes: AtomicU64,
}

/// A segment that is up to date.
#[derive(Clone, Copy, Debug)]
pub struct LazyPart<'a> {
    /// The root first. A leaf whose first block is beyond `blocks` is a segment.
    pub nodes: &'a [Node8],
    pub blocks: &'a [Tri4],
    /// Number of the first segment below.
    pub below: usize,
}

/// What [`LazyBvh::touch`] found.
pub enum Touch<'a> {
    Shared(LazyPart<'a>),
    /// Another thread is writing the segment; this is a copy.
    Own(OwnPart),
}

/// A segment written for one thread.
pub struct OwnPart {
    nodes: Vec<Node8>,
    blocks: Vec<Tri4>,
    below: usize,
}

impl Touch<'_> {
    /// The segment.
    #[inline]
    pub fn part(&self) -> LazyPart<'_> {
        match self {
            Touch::Shared(part) => *part,
            Touch::Own(own) => LazyPart { nodes: &own.nodes, blocks: &own.blocks, below: own.below },
        }
    }
}

impl LazyBvh {
    /// Builds the tree of `mesh`, which is what `source` refers to, with nothing up to date. To be called inside the pool.
    pub(super) fn new(mesh: &Mesh, source: Source, shape: LazyShape) -> Result<Self, OutOfMemory> {
        let bvh = build_sah(mesh)?;
        let topology = Topology::new(&bvh, mesh, shape)?;
        let bounds = bvh.bounds();
        drop(bvh);
        let mut nodes = reserve(topology.children.len())?;
        nodes.extend(topology.children.iter().map(|&children| Node8 { children, ..Node8::EMPTY }));
        let mut blocks = reserve(topology.prims.len())?;
        blocks.extend(topology.empty_blocks(0..topology.prims.len()));
        let places = topology.segments.iter().map(|s| (s.nodes.clone(), s.blocks.clone()));
        let parts = OnTouch::new(nodes, blocks, places);
        let prim_count = mesh.triangles.len();
        let (revived, touched) = (AtomicBool::new(false), Touched::default());
        Ok(Self { topology, parts, source, bounds, prim_count, revived, touched, links: None })
    }

    /// Says that vertices have moved, and where they are now; the triangles are those of the build. Returns how many nodes were written, and None
    /// if it has to be built anew. To be called inside the pool.
    pub(super) fn moved(&mut self, mesh: &Mesh, source: Source) -> Option<usize> {
        let revived = std::mem::take(self.revived.get_mut());
        if mesh.triangles.len() != self.prim_count
            || (revived && self.topology.dropped > self.prim_count / MANY_DROPPED)
        {
            return None;
        }
        self.source = source;
        let was_reached = !self.is_empty() && self.parts.is_current(0);
        self.parts.advance();
        if was_reached {
            let boxes = self.boxes_below(0, mesh, true);
            let (nodes, _) = self.write_now(0, mesh, &boxes);
            let (bounds, count) = (nodes[0].union(), nodes.len());
            self.bounds = bounds;
            Some(count)
        } else {
            self.bounds = box_of_all(&mesh.positions);
            Some(0)
        }
    }

    /// The mesh is elsewhere, and the same.
    pub(super) fn set_source(&mut self, source: Source) {
        self.source = source;
    }

    /// Forgets what rays have had updated.
    pub(super) fn forget_touched(&mut self) {
        self.touched = Touched::default();
    }

    /// What rays have had updated since [`LazyBvh::forget_touched`]: segments and nodes.
    pub(super) fn touched(&self) -> (u32, u64) {
        (self.touched.segments.load(Ordering::Relaxed), self.touched.nodes.load(Ordering::Relaxed))
    }

    /// Whether no ray can hit it, wherever its vertices are.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.topology.segments.is_empty()
    }

    /// A box around everything that can be hit.
    #[inline]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Segments.
    pub fn segments(&self) -> usize {
        self.topology.segments.len()
    }

    /// Nodes of all segments.
    pub fn nodes(&self) -> usize {
        self.topology.children.len()
    }

    /// Bytes held, capacity included.
    pub fn memory_bytes(&self) -> usize {
        let own = match &self.source {
            Source::Scene(_) => 0,
            Source::Own(mesh) => size_of_val(&mesh.positions[..]) + size_of_val(&mesh.triangles[..]),
        };
        let links = self.links.as_ref().map_or(0, Links::memory_bytes);
        self.topology.memory_bytes() + self.parts.memory_bytes() + links + own
    }

    /// A segment, if it is up to date.
    #[inline(always)]
    pub fn current(&self, segment: usize) -> Option<LazyPart<'_>> {
        let (nodes, blocks) = self.parts.current(segment)?;
        Some(LazyPart { nodes, blocks, below: self.topology.segments[segment].below.start })
    }

    /// A segment, brought up to date if it is not.
    ///
    /// # Panics
    /// When the scene was changed after the last update.
    #[cold]
    pub fn touch(&self, segment: usize) -> Touch<'_> {
        let mesh = self.source.mesh();
        let below = self.topology.segments[segment].below.start;
        let written = self.parts.touch(segment, |nodes, blocks| {
            self.touched.segments.fetch_add(1, Ordering::Relaxed);
            self.touched.nodes.fetch_add(nodes.len() as u64, Ordering::Relaxed);
            self.write(segment, &mesh, nodes, blocks, &self.boxes_below(segment, &mesh, false));
        });
        match written {
            Some((nodes, blocks)) => Touch::Shared(LazyPart { nodes, blocks, below }),
            None => Touch::Own(self.copy(segment, &mesh)),
        }
    }

    /// A segment for this thread alone.
    fn copy(&self, segment: usize, mesh: &Mesh) -> OwnPart {
        let Segment { nodes, blocks, below, .. } = &self.topology.segments[segment];
        let mut own = OwnPart {
            nodes: self.topology.children[nodes.clone()]
                .iter()
                .map(|&c| Node8 { children: c, ..Node8::EMPTY })
                .collect(),
            blocks: self.topology.empty_blocks(blocks.clone()).collect(),
            below: below.start,
        };
        self.write(segment, mesh, &mut own.nodes, &mut own.blocks, &self.boxes_below(segment, mesh, false));
        own
    }

    #[cfg(test)]
    pub(super) fn copy_for_tests(&self, segment: usize) -> Touch<'_> {
        Touch::Own(self.copy(segment, &self.source.mesh()))
    }

    /// Writes a segment with the exclusive right to do so.
    fn write_now(&mut self, segment: usize, mesh: &Mesh, boxes: &[BlockBox]) -> (&[Node8], &[Tri4]) {
        let this = &*self;
        // Not counted: no ray has asked for it.
        let written = this.parts.touch(segment, |nodes, blocks| this.write(segment, mesh, nodes, blocks, boxes));
        written.expect("nobody else is writing")
    }

    /// The boxes of the segments below one, from their vertices.
    fn boxes_below(&self, segment: usize, mesh: &Mesh, parallel: bool) -> Vec<BlockBox> {
        let vertex_box = |below: &Segment| {
            let Aabb { lo, hi } = box_of_listed(&mesh.positions, &self.topology.vertices[below.vertices.clone()]);
            BlockBox { lo: lo.extend(0.0), hi: hi.extend(0.0) }
        };
        let below = &self.topology.segments[self.topology.segments[segment].below.clone()];
        if parallel {
            below.par_iter().with_min_len(8).map(vertex_box).collect()
        } else {
            below.iter().map(vertex_box).collect()
        }
    }

    /// Blocks, which have the numbers of their triangles already, then nodes, last first. `below` are the boxes of the segments below.
    fn write(&self, segment: usize, mesh: &Mesh, nodes: &mut [Node8], blocks: &mut [Tri4], below: &[BlockBox]) {
        let part = &self.topology.segments[segment];
        let mut leaves = Vec::with_capacity(blocks.len());
        // To read the numbers out of the blocks, some blocks ahead, also fetches what will be written.
        load(Load { mesh, blocks, prims: &Keep, boxes: &mut leaves });
        if part.dropped && leaves.iter().any(|b| b.lo.cmple(b.hi).bitmask() & 7 == 7) {
            self.revived.store(true, Ordering::Relaxed);
        }
        let mut boxes = vec![BlockBox::EMPTY; nodes.len()];
        for (i, node) in nodes.iter_mut().enumerate().rev() {
            let mut lanes = [BlockBox::EMPTY; WIDTH];
            let mut all = BlockBox::EMPTY;
            for (child, lane) in node.children.iter().zip(&mut lanes) {
                if child.is_empty() {
                    break;
                }
                *lane = lane_box(*child, &leaves, &boxes, below);
                all = all.union(lane);
            }
            boxes[i] = all;
            set_bounds(node, &lanes);
        }
    }
}

/// The box of a child, from those of blocks, nodes and segments below.
#[inline(always)]
fn lane_box(child: ChildRef, leaves: &[BlockBox], nodes: &[BlockBox], below: &[BlockBox]) -> BlockBox {
    if !child.is_leaf() {
        return nodes[child.index()];
    }
    let run = child.blocks();
    if run.start < leaves.len() {
        leaves[run.start + 1..run.end].iter().fold(leaves[run.start], |all, b| all.union(b))
    } else {
        below[run.start - leaves.len()]
    }
}
