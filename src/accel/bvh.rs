//! The 8-wide bounding volume hierarchy that every object structure but the BSP ends up in.
//!
//! A node holds the boxes of up to eight children as structure of arrays, so that one SIMD slab test takes them all
//! (Wald, Benthin, Boulos, *Getting Rid of Packets*, 2008; the layout of Embree's BVH8). A leaf is a run of
//! [`Tri4`] blocks, four triangles each, corners copied in: one indirection less per test than an index buffer, for 40
//! bytes per triangle.
//!
//! Strategies differ in how they build and update; they all leave a [`Bvh`] for which [`super::validate`] holds, so
//! traversal does not know them. Bounds and corners come from one place only, the sweep of [`Bvh::refit`]:
//! builders decide the topology, the sweep fills it.
//!
//! Invariants, checked once by [`Bvh::from_parts`] and relied upon by the unchecked loads of traversal:
//! * the children of node `i` that are nodes have numbers above `i` (so there are no cycles, and a backward sweep is bottom-up);
//! * every child is a node of the tree, a run of blocks of the tree, or empty, and the empty ones come last;
//! * no path has more than [`MAX_DEPTH`] nodes, which bounds the traversal stack.

use super::Aabb;
use super::memory::{cloned, copied};
pub use crate::memory::OutOfMemory;
use glam::Vec3;
use std::ops::Range;

/// Children per node.
pub const WIDTH: usize = 8;
/// Triangles per block.
pub const BLOCK: usize = 4;
/// Blocks per leaf at most: what fits in a [`ChildRef`].
pub const MAX_LEAF_BLOCKS: usize = 8;
/// Nodes on a path from the root at most. Builders switch to halving by count long before.
pub const MAX_DEPTH: usize = 64;

/// What a node's lane points to, in 32 bits: a node, a leaf (first block and number of blocks), or nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub struct ChildRef(u32);

impl ChildRef {
    const LEAF: u32 = 1 << 31;
    const COUNT_SHIFT: u32 = 28;
    /// Blocks and nodes are numbered below this.
    pub const MAX_INDEX: usize = (1 << Self::COUNT_SHIFT) - 1;

    /// An unused lane. Its box is empty, so that no ray follows it.
    pub const EMPTY: ChildRef = ChildRef(u32::MAX);

    /// The first node.
    pub const ROOT: ChildRef = ChildRef(0);

    #[inline]
    pub fn node(index: usize) -> Self {
        debug_assert!(index < Self::MAX_INDEX);
        ChildRef(index as u32)
    }

    #[inline]
    pub fn leaf(first: usize, count: usize) -> Self {
        debug_assert!(first < Self::MAX_INDEX && (1..=MAX_LEAF_BLOCKS).contains(&count));
        ChildRef(Self::LEAF | ((count as u32 - 1) << Self::COUNT_SHIFT) | first as u32)
    }

    #[inline(always)]
    pub fn is_leaf(self) -> bool {
        self.0 & Self::LEAF != 0
    }

    #[inline]
    pub fn is_empty(self) -> bool {
        self == Self::EMPTY
    }

    /// Of a node.
    #[inline(always)]
    pub fn index(self) -> usize {
        self.0 as usize
    }

    /// First block and one past the last, of a leaf.
    #[inline(always)]
    pub fn blocks(self) -> Range<usize> {
        let first = (self.0 & Self::MAX_INDEX as u32) as usize;
        first..first + (self.0 >> Self::COUNT_SHIFT & 7) as usize + 1
    }

    /// The bits, for a traversal stack.
    #[inline(always)]
    pub fn to_bits(self) -> u32 {
        self.0
    }

    #[inline(always)]
    pub fn from_bits(bits: u32) -> Self {
        ChildRef(bits)
    }
}

/// Eight children: boxes and references.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Node8 {
    /// `lo.x, hi.x, lo.y, hi.y, lo.z, hi.z`, a lane per child. Unused lanes have `lo = +inf`, `hi = -inf`.
    pub bounds: [[f32; WIDTH]; 6],
    pub children: [ChildRef; WIDTH],
}

impl Node8 {
    pub const EMPTY: Node8 = {
        let lo = [f32::INFINITY; WIDTH];
        let hi = [f32::NEG_INFINITY; WIDTH];
        Node8 { bounds: [lo, hi, lo, hi, lo, hi], children: [ChildRef::EMPTY; WIDTH] }
    };

    /// The box of one child.
    #[inline]
    pub fn child_bounds(&self, lane: usize) -> Aabb {
        let b = &self.bounds;
        Aabb { lo: Vec3::new(b[0][lane], b[2][lane], b[4][lane]), hi: Vec3::new(b[1][lane], b[3][lane], b[5][lane]) }
    }

    #[inline]
    pub fn set_child_bounds(&mut self, lane: usize, aabb: &Aabb) {
        for axis in 0..3 {
            self.bounds[2 * axis][lane] = aabb.lo[axis];
            self.bounds[2 * axis + 1][lane] = aabb.hi[axis];
        }
    }

    /// The box around all children.
    #[inline]
    pub fn union(&self) -> Aabb {
        let least = |row: &[f32; WIDTH]| row.iter().fold(f32::INFINITY, |a, &b| if b < a { b } else { a });
        let most = |row: &[f32; WIDTH]| row.iter().fold(f32::NEG_INFINITY, |a, &b| if b > a { b } else { a });
        let b = &self.bounds;
        Aabb {
            lo: Vec3::new(least(&b[0]), least(&b[2]), least(&b[4])),
            hi: Vec3::new(most(&b[1]), most(&b[3]), most(&b[5])),
        }
    }

    /// Used lanes; they come first.
    #[inline]
    pub fn child_count(&self) -> usize {
        self.children.iter().position(|c| c.is_empty()).unwrap_or(WIDTH)
    }
}

/// Four triangles: corners as structure of arrays, and their numbers.
///
/// A block with fewer than four repeats its last one, so that no lane needs masking: the copy finds the same hit. A
/// triangle that became unusable after the build keeps its lane with NaN corners, which no ray hits.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct Tri4 {
    /// `[corner][axis][lane]`.
    pub corners: [[[f32; BLOCK]; 3]; 3],
    pub prims: [u32; BLOCK],
}

impl Tri4 {
    pub(super) const EMPTY: Tri4 = Tri4 { corners: [[[0.0; BLOCK]; 3]; 3], prims: [0; BLOCK] };

    #[inline]
    pub fn corners(&self, lane: usize) -> [Vec3; 3] {
        self.corners.map(|c| Vec3::new(c[0][lane], c[1][lane], c[2][lane]))
    }

    #[inline]
    pub fn set_corners(&mut self, lane: usize, corners: [Vec3; 3]) {
        for (to, from) in self.corners.iter_mut().zip(corners) {
            to[0][lane] = from.x;
            to[1][lane] = from.y;
            to[2][lane] = from.z;
        }
    }
}

/// The part of a tree below some top nodes: its nodes and blocks lie together, so that parts can be refit in parallel.
/// The first node is the part's root.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Subtree {
    pub nodes: Range<usize>,
    pub blocks: Range<usize>,
}

/// An 8-wide tree over the triangles of one mesh. The default is the tree of nothing.
#[derive(Clone, Debug, Default)]
pub struct Bvh {
    /// Node 0 is the root. Empty when there is nothing to hit.
    pub(super) nodes: Vec<Node8>,
    pub(super) blocks: Vec<Tri4>,
    /// Disjoint, in order; the nodes before the first are the top, refit after all of them.
    pub(super) subtrees: Vec<Subtree>,
    /// Triangles that were unusable when the tree was built: they have no lane.
    pub(super) dropped: Vec<u32>,
    /// Triangles of the mesh it was built for.
    pub(super) prim_count: usize,
    bounds: Option<Aabb>,
    depth: usize,
    holds_parts: bool,
}

impl Bvh {
    /// An empty tree, in the place of which a builder puts one with room to grow by an eighth: nobody has touched that, so it costs addresses only.
    pub(super) fn with_room_to_grow() -> Self {
        // See `memory::recycled`: too small, so it will be asked for more again.
        Self { nodes: Vec::with_capacity(1), blocks: Vec::with_capacity(1), ..Self::default() }
    }

    /// A copy.
    pub(super) fn try_clone(&self) -> Result<Self, OutOfMemory> {
        Ok(Self {
            nodes: copied(&self.nodes)?,
            blocks: copied(&self.blocks)?,
            subtrees: cloned(&self.subtrees)?,
            dropped: copied(&self.dropped)?,
            ..*self
        })
    }

    /// Puts a tree together.
    ///
    /// # Panics
    /// When an invariant of the module head is violated: traversal would read outside the arrays.
    pub(super) fn from_parts(
        nodes: Vec<Node8>,
        blocks: Vec<Tri4>,
        subtrees: Vec<Subtree>,
        dropped: Vec<u32>,
        prim_count: usize,
        bounds: Aabb,
    ) -> Self {
        let mut depth = vec![0u8; nodes.len()];
        if let Some(root) = depth.first_mut() {
            *root = 1;
        }
        let mut deepest = depth.first().copied().unwrap_or(0);
        for (i, node) in nodes.iter().enumerate() {
            let used = node.child_count();
            assert!(node.children[used..].iter().all(|c| c.is_empty()), "empty lanes come last");
            for child in &node.children[..used] {
                if child.is_leaf() {
                    assert!(child.blocks().end <= blocks.len(), "a leaf lies inside the blocks");
                } else {
                    assert!(child.index() > i && child.index() < nodes.len(), "a child has a higher number");
                    depth[child.index()] = depth[i] + 1;
                    deepest = deepest.max(depth[i] + 1);
                    assert!(usize::from(deepest) <= MAX_DEPTH, "builders bound the depth");
                }
            }
        }
        Self {
            nodes,
            blocks,
            subtrees,
            dropped,
            prim_count,
            bounds: Some(bounds),
            depth: usize::from(deepest),
            holds_parts: false,
        }
    }

    /// The nodes, root first.
    #[inline(always)]
    pub fn nodes(&self) -> &[Node8] {
        &self.nodes
    }

    /// The triangle blocks.
    #[inline(always)]
    pub fn blocks(&self) -> &[Tri4] {
        &self.blocks
    }

    /// Whether no ray can hit it.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// The box around everything; [`Aabb::EMPTY`] for an empty tree.
    #[inline]
    pub fn bounds(&self) -> Aabb {
        self.bounds.unwrap_or(Aabb::EMPTY)
    }

    pub(super) fn set_bounds(&mut self, bounds: Aabb) {
        self.bounds = Some(bounds);
    }

    pub(super) fn set_depth(&mut self, depth: usize) {
        self.depth = depth;
    }

    /// Whether a triangle may be in several leaves, with boxes around parts of it ([`super::build_spatial`]).
    #[inline]
    pub fn holds_parts(&self) -> bool {
        self.holds_parts
    }

    pub(super) fn set_holds_parts(&mut self) {
        self.holds_parts = true;
    }

    /// The tree of a mesh without usable triangles.
    pub(super) fn of_nothing(dropped: Vec<u32>, prim_count: usize) -> Self {
        Self { dropped, prim_count, ..Self::default() }
    }

    /// Nodes on the longest path from the root to a leaf.
    #[inline]
    pub fn depth(&self) -> usize {
        self.depth
    }

    /// Bytes held, capacity included.
    pub fn memory_bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<Node8>()
            + self.blocks.capacity() * size_of::<Tri4>()
            + self.subtrees.capacity() * size_of::<Subtree>()
            + self.dropped.capacity() * size_of::<u32>()
    }

    /// The expected cost of a random ray that meets the root's box, with a node and a block costing 1 each
    /// (the surface area heuristic of Goldsmith and Salmon 1987 on the wide tree). 0 for an empty tree.
    pub fn sah_cost(&self) -> f64 {
        let area = |aabb: &Aabb| f64::from(aabb.half_area());
        let root = area(&self.bounds());
        if self.is_empty() || root <= 0.0 {
            return 0.0;
        }
        let mut sum = root;
        for node in &self.nodes {
            for lane in 0..node.child_count() {
                let child = node.children[lane];
                let visits = if child.is_leaf() { child.blocks().len() } else { 1 };
                sum += area(&node.child_bounds(lane)) * visits as f64;
            }
        }
        sum / root
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reference_gives_back_what_was_put_in() {
        assert_eq!(size_of::<Node8>(), 256);
        assert_eq!(size_of::<Tri4>(), 160);
        let leaf = ChildRef::leaf(123_456_789, 8);
        assert!(leaf.is_leaf() && !leaf.is_empty());
        assert_eq!(leaf.blocks(), 123_456_789..123_456_797);
        let node = ChildRef::node(7);
        assert!(!node.is_leaf() && node.index() == 7);
        assert!(ChildRef::EMPTY.is_empty() && ChildRef::leaf(ChildRef::MAX_INDEX - 1, 8) != ChildRef::EMPTY);
    }

    #[test]
    #[should_panic(expected = "a child has a higher number")]
    fn a_cycle_is_refused() {
        let mut node = Node8::EMPTY;
        node.children[0] = ChildRef::node(0);
        Bvh::from_parts(vec![node], Vec::new(), Vec::new(), Vec::new(), 0, Aabb::EMPTY);
    }
}
