//! The object BSP of Wald03 §4.2–4.3: a kd-tree over the triangles of one object, built when the first ray asks.
//!
//! A node is 8 bytes: an axis-aligned plane and the number of the first of two neighbouring children, or a run of
//! triangle references. Cells have no boxes: a ray carries its own interval down and cuts it at the planes.
//!
//! *The same hit as from a BVH.* A triangle is referenced by every cell that its padded box
//! ([`super::triangle_bounds`]) reaches into, and not by what a tighter clip would leave of it. Hits are clamped to
//! the ray's interval in that box. Since the slab distance of a plane is monotone in the plane's position, in floating point
//! too, a box wholly on one side of a plane has its interval wholly on that side of the plane's
//! distance, and a box on both sides is referenced on both; so the traversal (`trace/traverse_bsp`) reaches the
//! triangle in a cell whose entry distance is not above the hit. Ties and edge-on triangles then end as in every other structure.
//!
//! *On demand* (Wald03 §3): an update only copies the corners. The tree is built in a `OnceLock` by the first ray
//! that passes the object's box; other rays wait for it. The build is sequential: a parallel one would let the waiting
//! worker steal a tile that waits for this very lock. What nobody sees is never built.

use super::bsp_build::{self, Quality};
use super::bvh::OutOfMemory;
use super::{Aabb, triangle_bounds};
use crate::scene::Mesh;
use glam::Vec3;
use std::sync::OnceLock;

/// Planes on a path from the root at most; bounds the traversal stack.
pub const BSP_MAX_DEPTH: usize = 60;

/// An inner node or a leaf, in 8 bytes.
#[derive(Clone, Copy, Debug)]
pub struct BspNode {
    /// Inner: the plane's position. Leaf: the bits of the first reference's number.
    payload: u32,
    /// Low 2 bits: the plane's axis, 3 for a leaf. Others: number of the lower child (the upper one
    /// follows), or the count of references.
    link: u32,
}

const _: () = assert!(size_of::<BspNode>() == 8);

impl BspNode {
    const LEAF: u32 = 3;
    /// Children and counts are below this.
    pub(super) const MAX_LINK: usize = (1 << 30) - 1;

    pub(super) fn inner(axis: usize, plane: f32, lower: usize) -> Self {
        debug_assert!(axis < 3 && lower <= Self::MAX_LINK);
        Self { payload: plane.to_bits(), link: ((lower as u32) << 2) | axis as u32 }
    }

    pub(super) fn leaf(first: usize, count: usize) -> Self {
        debug_assert!(count <= Self::MAX_LINK);
        Self { payload: first as u32, link: ((count as u32) << 2) | Self::LEAF }
    }

    #[inline(always)]
    pub fn is_leaf(self) -> bool {
        self.link & 3 == Self::LEAF
    }

    /// Of an inner node.
    #[inline(always)]
    pub fn axis(self) -> usize {
        (self.link & 3) as usize
    }

    /// Of an inner node.
    #[inline(always)]
    pub fn plane(self) -> f32 {
        f32::from_bits(self.payload)
    }

    /// Of an inner node: the child on the lower side of the plane; the upper one is next to it.
    #[inline(always)]
    pub fn lower(self) -> u32 {
        self.link >> 2
    }

    /// Of a leaf: its part of the references.
    #[inline(always)]
    pub fn refs(self) -> std::ops::Range<usize> {
        let first = self.payload as usize;
        first..first + (self.link >> 2) as usize
    }
}

/// The tree itself. Node 0 is the root.
#[derive(Clone, Debug, Default)]
pub struct BspTree {
    pub(super) nodes: Vec<BspNode>,
    pub(super) refs: Vec<u32>,
}

impl BspTree {
    #[inline(always)]
    pub fn nodes(&self) -> &[BspNode] {
        &self.nodes
    }

    /// Triangle numbers, by leaf.
    #[inline(always)]
    pub fn refs(&self) -> &[u32] {
        &self.refs
    }

    fn memory_bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<BspNode>() + self.refs.capacity() * size_of::<u32>()
    }
}

/// The triangles of one object, and their BSP as soon as somebody asked for it.
#[derive(Debug)]
pub struct Bsp {
    corners: Vec<[Vec3; 3]>,
    bounds: Aabb,
    quality: Quality,
    /// `None` inside: there was no memory for a tree, and all triangles are tested in turn.
    tree: OnceLock<Option<BspTree>>,
}

impl Bsp {
    /// Copies the triangles. Linear; the tree comes later. An existing structure gives its memory.
    ///
    /// # Errors
    /// No memory for the copy.
    pub fn new(mesh: &Mesh, quality: Quality, recycled: Option<Bsp>) -> Result<Self, OutOfMemory> {
        let mut corners = recycled.map_or_else(Vec::new, |old| old.corners);
        corners.clear();
        let count = mesh.triangles.len();
        let bytes = count.saturating_mul(size_of::<[Vec3; 3]>());
        corners.try_reserve_exact(count).map_err(|_| OutOfMemory { bytes })?;
        let mut bounds = Aabb::EMPTY;
        for prim in 0..count as u32 {
            let triangle = mesh.corners(prim);
            bounds = bounds.union(triangle_bounds(triangle));
            corners.push(triangle);
        }
        Ok(Self { corners, bounds, quality, tree: OnceLock::new() })
    }

    /// The box around everything that can be hit.
    #[inline]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Corners of all triangles, those that no ray can hit included.
    #[inline(always)]
    pub fn corners(&self) -> &[[Vec3; 3]] {
        &self.corners
    }

    /// The tree, built now if nobody needed it before; `None` when there is no memory for it.
    #[inline]
    pub fn tree(&self) -> Option<&BspTree> {
        self.tree.get_or_init(|| bsp_build::build(&self.corners, self.bounds, self.quality)).as_ref()
    }

    /// Whether a ray has asked for the tree.
    pub fn is_built(&self) -> bool {
        self.tree.get().is_some()
    }

    /// Bytes held, capacity included.
    pub fn memory_bytes(&self) -> usize {
        let tree = self.tree.get().and_then(|t| t.as_ref()).map_or(0, BspTree::memory_bytes);
        self.corners.capacity() * size_of::<[Vec3; 3]>() + tree
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_gives_back_what_was_put_in() {
        let inner = BspNode::inner(2, -1.5e-30, 123_456_789);
        assert!(!inner.is_leaf());
        assert_eq!((inner.axis(), inner.plane(), inner.lower()), (2, -1.5e-30, 123_456_789));
        let leaf = BspNode::leaf(4_000_000_000, 5);
        assert!(leaf.is_leaf());
        assert_eq!(leaf.refs(), 4_000_000_000..4_000_000_005);
    }

    #[test]
    fn nothing_is_built_before_a_ray_asks() {
        let mesh =
            Mesh { positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y], triangles: vec![[0, 1, 2]], ..Mesh::default() };
        let bsp = Bsp::new(&mesh, Quality::Sah, None).expect("memory");
        let before = bsp.memory_bytes();
        assert!(!bsp.is_built());
        assert!(bsp.tree().is_some() && bsp.is_built());
        assert!(bsp.memory_bytes() > before);
    }
}
