//! The tree that is brought up to date by the rays that reach it (Larsson and Akenine-Möller, *Strategies for Bounding Volume Hierarchy Updates for
//! Ray Tracing of Deformable Models*, 2003, §3).
//!
//! The hierarchy is built once, and cut into segments ([`super::lazy_cut`]): a top, and subtrees below it. When vertices have moved,
//! an update only says so, by counting up one number. The first ray that reaches a segment writes it ([`super::lazy_write`]): a copy of its vertices, the boxes of segments
//! below from their vertices, each shared vertex once ([`super::vertex_box`]), the nodes above by merging. For the top that is the paper's hybrid update of
//! the middle level and all above it; for the segments below it is one of the paper's heuristics, all levels of a subtree at once, or a few, or one
//! ([`LazyShape`]).
//!
//! *Where we differ.* Even the middle level waits for a ray, so an object that no ray meets costs the box around its vertices and nothing else. But the top of
//! an object that was met in the frame before is written at the update, by all threads. A stamp belongs to a segment, not to a node: the loop over nodes
//! is that of any tree, and structures of other strategies pay nothing. Paper and field write boxes in one thread; here any
//! thread may be the first ([`OnTouch`]): it alone writes the segment, and one that comes while it does writes a private copy rather than wait.
//! Triangles are not laid out in blocks, as in our other trees, but refer to the segment's vertices; who tests four of them gathers their corners.
//!
//! *Same hits.* Boxes from vertices are a little larger than those from triangles, and contain them; a box that is larger never changes a hit.
//!
//! *Measured* on nine bodies of 81,920 triangles, with reflections and two lights, one thread (`cargo bench --bench papers -- larsson1 --quick`, whose head says what
//! limits it). Per triangle that a ray has updated it takes half of what a complete refit does, in one go (whole trees: 1.7 to 1.8 times as fast); with blocks of corners
//! it was 1.3 to 1.6 times as much (see [`super::lazy_write`]). To gather corners makes rays 1.15 times as slow, to go from segment to segment 1.05 to 1.1 times; the order of
//! vertices helps there: those of a leaf are neighbours. One level at a time is
//! slower, as the same vertices are looked at on each level; the paper prefers it, but its nodes hold one box and one triangle.
//!
//! *How large a segment* is: each costs 0.5 µs to begin, so the fewer nodes small ones have, the more each takes: subtrees of 64, 256, 1024, 2048 and 4096 triangles write 14, 30, 37, 55
//! and 57 % of all nodes at 10x10 for 600, 220, 165, 130 and 135 ns each. In total, the update before the first ray included, those of 2048 and 1024 are alike, 4096 and 512 a twentieth worse.
//! *Tried*: both, large ones below the top and small ones below these. Boxes of the small ones are made where a ray reaches the large one; the update before the first ray is that of large ones, but vertices are
//! looked at twice, and rays go through one more: a tenth slower in total.
//!
//! *The mesh* is that of the scene, by a weak reference: a change of the scene then need not copy it, but cuts the tree off until the update that must follow.

use super::block_loader::BlockBox;
use super::bvh::{Bvh, ChildRef, Node8, OutOfMemory};
use super::lazy_cut::{LazyBlock, Segment, Topology};
use super::lazy_write::{Asked, Below, Known, Write};
use super::links::Links;
use super::memory::{filled, reserve};
use super::vertex_box::box_of_all;
use super::{Aabb, build_sah};
use crate::memory::{Room, collected, repeated};
use crate::scene::{LazyShape, Mesh};
use crate::simd::{self, Level, prefetch};
use crate::threads::OnTouch;
use glam::Vec4;
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
    /// Whether this is not `mesh`, and was the scene's once.
    pub(super) fn is_elsewhere(&self, mesh: &Arc<Mesh>) -> bool {
        matches!(self, Source::Scene(known) if !std::ptr::eq(known.as_ptr(), Arc::as_ptr(mesh)))
    }

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
    pub(super) parts: OnTouch<Node8, Vec4>,
    source: Source,
    pub(super) bounds: Aabb,
    prim_count: usize,
    /// A triangle that was unusable at the build has been seen usable.
    revived: AtomicBool,
    touched: Touched,
    /// For partial updates, once there has been one.
    pub(super) links: Option<Links>,
    /// Room for the boxes of the segments below the first.
    below_root: Vec<BlockBox>,
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
    /// The root first.
    pub nodes: &'a [Node8],
    /// The last lanes are meaningless.
    pub vertices: &'a [Vec4],
    /// The numbers of the first of both in the whole tree.
    pub first_node: usize,
    pub first_vertex: usize,
}

/// A segment written for one thread.
pub struct OwnPart {
    nodes: Vec<Node8>,
    vertices: Vec<Vec4>,
    first_node: usize,
    first_vertex: usize,
}

impl OwnPart {
    /// The segment.
    pub fn part(&self) -> LazyPart<'_> {
        let Self { ref nodes, ref vertices, first_node, first_vertex } = *self;
        LazyPart { nodes, vertices, first_node, first_vertex }
    }
}

impl LazyBvh {
    /// Builds the tree of `mesh`, which is what `source` refers to, with nothing up to date. To be called inside the pool.
    pub(super) fn new(mesh: &Mesh, source: Source, shape: LazyShape) -> Result<Self, OutOfMemory> {
        Self::of(&build_sah(mesh)?, mesh, source, shape)
    }

    /// Cuts a tree of `mesh`, or of what it was before vertices moved.
    pub(super) fn of(bvh: &Bvh, mesh: &Mesh, source: Source, shape: LazyShape) -> Result<Self, OutOfMemory> {
        Self::with_topology(Topology::new(bvh, mesh, shape)?, mesh, source)
    }

    /// The tree for `mesh`, which has the same triangles and is what `source` refers to, with nothing up to date.
    pub(super) fn outdated_copy(&self, mesh: &Mesh, source: Source) -> Result<Self, OutOfMemory> {
        let revived = self.revived.load(Ordering::Relaxed);
        Ok(Self { revived: AtomicBool::new(revived), ..Self::with_topology(self.topology.try_clone()?, mesh, source)? })
    }

    fn with_topology(topology: Topology, mesh: &Mesh, source: Source) -> Result<Self, OutOfMemory> {
        let bounds = box_of_all(&mesh.positions);
        let mut nodes = reserve(topology.children.len())?;
        nodes.extend(topology.children.iter().map(|&children| Node8 { children, ..Node8::EMPTY }));
        let vertices = filled(Vec::new(), topology.vertices.len(), Vec4::ZERO)?;
        let places = topology.segments.iter().map(|s| (s.nodes.clone(), s.held.clone()));
        let parts = OnTouch::new(nodes, vertices, places)?;
        let prim_count = mesh.triangles.len();
        let (revived, touched) = (AtomicBool::new(false), Touched::default());
        Ok(Self { topology, parts, source, bounds, prim_count, revived, touched, links: None, below_root: Vec::new() })
    }

    /// Says that vertices have moved, and where they are now; the triangles are those of the build. The top is written `now`, if rays are expected, or waits
    /// for one. Returns how many nodes were written, and None if it has to be built anew. To be called inside the pool.
    pub(super) fn moved(&mut self, mesh: &Mesh, source: Source, now: bool) -> Option<usize> {
        let revived = std::mem::take(self.revived.get_mut());
        if mesh.triangles.len() != self.prim_count
            || (revived && self.topology.dropped > self.prim_count / MANY_DROPPED)
        {
            return None;
        }
        self.source = source;
        self.parts.advance();
        if now && !self.is_empty() {
            let boxes = self.boxes_below_root(mesh);
            let nodes = self.write_root(mesh, &boxes);
            let (bounds, count) = (nodes[0].union(), nodes.len());
            (self.bounds, self.below_root) = (bounds, boxes);
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

    /// Where the mesh is.
    pub(super) fn source(&self) -> &Source {
        &self.source
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

    /// The blocks of all segments.
    #[inline(always)]
    pub fn blocks(&self) -> &[LazyBlock] {
        &self.topology.blocks
    }

    /// Where nodes and vertices of all segments begin, of which those of segments that are up to date may be read as long as `self` is borrowed.
    #[inline(always)]
    pub fn beginnings(&self) -> (*const Node8, *const Vec4) {
        self.parts.beginnings()
    }

    /// The segment that a leaf stands for, if it is not of blocks.
    #[inline(always)]
    pub fn segment_of_leaf(&self, leaf: ChildRef) -> Option<usize> {
        self.topology.segment_of_leaf(leaf)
    }

    /// The root of a segment, if that is up to date.
    #[inline(always)]
    pub fn current_root(&self, segment: usize) -> Option<ChildRef> {
        self.parts.start_of_current(segment).map(ChildRef::node)
    }

    /// A segment, if it is up to date.
    pub fn current(&self, segment: usize) -> Option<LazyPart<'_>> {
        let (nodes, vertices) = self.parts.current(segment)?;
        let Segment { nodes: all_nodes, held, .. } = &self.topology.segments[segment];
        Some(LazyPart { nodes, vertices, first_node: all_nodes.start, first_vertex: held.start })
    }

    /// Brings a segment up to date if it is not, and gives its root; None while another thread is writing it, when all that is left is a [`LazyBvh::copy`].
    ///
    /// # Panics
    /// When the scene was changed after the last update.
    #[cold]
    pub fn touch(&self, segment: usize) -> Option<ChildRef> {
        // Needed first, and while the mesh is looked for it comes.
        prefetch(&self.topology.segments, segment);
        let mesh = self.source.mesh();
        self.parts.touch(segment, |nodes, vertices| {
            self.touched.segments.fetch_add(1, Ordering::Relaxed);
            self.touched.nodes.fetch_add(nodes.len() as u64, Ordering::Relaxed);
            self.write(segment, &mesh, nodes, vertices, self.asked(&mesh));
        })?;
        Some(ChildRef::node(self.topology.segments[segment].nodes.start))
    }

    /// A segment for this thread alone.
    ///
    /// # Panics
    /// When the scene was changed after the last update.
    #[cold]
    pub fn copy(&self, segment: usize) -> Result<OwnPart, OutOfMemory> {
        let mesh = &*self.source.mesh();
        let Segment { nodes, held, .. } = &self.topology.segments[segment];
        let children = &self.topology.children[nodes.clone()];
        let mut own = OwnPart {
            nodes: collected(children.iter().map(|&c| Node8 { children: c, ..Node8::EMPTY }))?,
            vertices: repeated(Vec4::ZERO, held.len())?,
            first_node: nodes.start,
            first_vertex: held.start,
        };
        self.write(segment, mesh, &mut own.nodes, &mut own.vertices, self.asked(mesh));
        Ok(own)
    }

    /// As if another thread were writing the segment, until vertices move.
    #[cfg(test)]
    pub(crate) fn leave_claimed(&self, segment: usize) {
        let panics = || self.parts.touch(segment, |_, _| panic!("on purpose")).is_some();
        assert!(std::panic::catch_unwind(std::panic::AssertUnwindSafe(panics)).is_err());
    }

    /// Writes a segment with the exclusive right to do so.
    fn write_root(&self, mesh: &Mesh, boxes: &[BlockBox]) -> &[Node8] {
        // Not counted: no ray has asked for it.
        let written = self.parts.touch(0, |nodes, vertices| match boxes {
            // Without memory for them.
            [] => self.write(0, mesh, nodes, vertices, self.asked(mesh)),
            known => self.write(
                0,
                mesh,
                nodes,
                vertices,
                Known { boxes: known, first: self.topology.segments[0].below.start },
            ),
        });
        written.expect("nobody else is writing").0
    }

    /// The boxes of segments, each asked for when it is needed.
    fn asked<'a>(&'a self, mesh: &'a Mesh) -> Asked<'a> {
        Asked { topology: &self.topology, mesh }
    }

    /// The boxes of all segments below the first, by all threads, in the memory of the last time; none without memory.
    fn boxes_below_root(&mut self, mesh: &Mesh) -> Vec<BlockBox> {
        let mut boxes = std::mem::take(&mut self.below_root);
        boxes.clear();
        let below = self.topology.segments[0].below.clone();
        if boxes.room(below.len()).is_ok() {
            below
                .into_par_iter()
                .with_min_len(8)
                .map(|number| self.asked(mesh).of(number))
                .collect_into_vec(&mut boxes);
        }
        boxes
    }

    fn write(&self, segment: usize, mesh: &Mesh, nodes: &mut [Node8], vertices: &mut [Vec4], below: impl Below) {
        let segment = &self.topology.segments[segment];
        if simd::run(Level::detect(), Write { topology: &self.topology, segment, mesh, nodes, vertices, below }) {
            self.revived.store(true, Ordering::Relaxed);
        }
    }
}
