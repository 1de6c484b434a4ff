//! The object BSP of Wald03 §4.2–4.3: a kd-tree over the triangles of one object, built when the first ray asks.
//!
//! Planes divide cells, leaves refer to the triangles that reach into them, and a ray carries its own interval down and cuts it at the planes
//! (`trace/traverse_bsp`). Eight cells and the seven planes between them are one [`node`]; [`build`] shares a bounded number of references among cells,
//! at planes that [`plane`] chooses.
//!
//! *On demand* (Wald03 §3): an update only copies the corners. The tree is built in a `OnceLock` by the first ray
//! that passes the object's box; other rays wait for it. The build is sequential: a parallel one would let the waiting
//! worker steal a tile that waits for this very lock. What nobody sees is never built.
//!
//! *Cost*. 78 to 93 bytes per triangle, 69 to 81 built fast. A careful build takes 2 to 3.5 µs per triangle on a busy core, a fast one 0.7 to 1.1.

mod build;
mod node;
mod plane;

pub use node::{BspNode, LEVELS};

use self::build::build;
use super::bvh::{BLOCK, OutOfMemory};
use super::corners::Corners;
use super::{Aabb, triangle_bounds};
use crate::scene::Mesh;
use std::sync::{Mutex, OnceLock, PoisonError};

/// Planes on a path from the root at most.
const BSP_MAX_DEPTH: usize = 60;
/// Nodes on a path from the root at most, those of large leaves included; bounds the traversal stack.
pub const BSP_MAX_NODES: usize = BSP_MAX_DEPTH.div_ceil(LEVELS) + 10;

/// Which of the two builders.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quality {
    /// For objects that are built once.
    Sah,
    /// For objects that are built every frame.
    Fast,
}

/// The tree itself. Node 0 is the root.
///
/// Invariants, relied upon by the unchecked loads of traversal: children are nodes of the tree or runs of its blocks, or empty; blocks refer to its
/// triangles; no path has more than [`BSP_MAX_NODES`] nodes.
#[derive(Clone, Debug, Default)]
pub struct BspTree {
    nodes: Vec<BspNode>,
    /// References of leaves, four together; a block with fewer repeats its last one.
    blocks: Vec<[u32; BLOCK]>,
    /// In the order in which leaves refer to them first. Those that no ray can hit are not here.
    triangles: Vec<Corners>,
}

impl BspTree {
    #[inline(always)]
    pub fn nodes(&self) -> &[BspNode] {
        &self.nodes
    }

    #[inline(always)]
    pub fn blocks(&self) -> &[[u32; BLOCK]] {
        &self.blocks
    }

    #[inline(always)]
    pub fn triangles(&self) -> &[Corners] {
        &self.triangles
    }

    fn memory_bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<BspNode>()
            + self.blocks.capacity() * size_of::<[u32; BLOCK]>()
            + self.triangles.capacity() * size_of::<Corners>()
    }
}

/// What rays find.
#[derive(Debug)]
pub enum BspPart {
    Tree(BspTree),
    /// There was no memory for a tree: all triangles are tested in turn.
    List(Vec<Corners>),
}

/// The triangles of one object, and their BSP as soon as somebody asked for it.
#[derive(Debug)]
pub struct Bsp {
    bounds: Aabb,
    quality: Quality,
    /// The triangles, until the tree is built of them. Locked by who builds only.
    waiting: Mutex<Vec<Corners>>,
    built: OnceLock<BspPart>,
}

impl Bsp {
    /// Copies the triangles. Linear; the tree comes later. An existing structure gives its memory.
    ///
    /// # Errors
    /// No memory for the copy.
    pub fn new(mesh: &Mesh, quality: Quality, recycled: Option<Bsp>) -> Result<Self, OutOfMemory> {
        let mut triangles = recycled.map_or_else(Vec::new, Bsp::into_triangles);
        triangles.clear();
        let count = mesh.triangles.len();
        let bytes = count.saturating_mul(size_of::<Corners>());
        triangles.try_reserve_exact(count).map_err(|_| OutOfMemory { bytes })?;
        let mut bounds = Aabb::EMPTY;
        for prim in 0..count as u32 {
            let corners = mesh.corners(prim);
            bounds = bounds.union(triangle_bounds(corners));
            triangles.push(Corners::new(prim, corners));
        }
        Ok(Self { bounds, quality, waiting: Mutex::new(triangles), built: OnceLock::new() })
    }

    fn into_triangles(self) -> Vec<Corners> {
        match self.built.into_inner() {
            Some(BspPart::Tree(tree)) => tree.triangles,
            Some(BspPart::List(triangles)) => triangles,
            None => self.waiting.into_inner().unwrap_or_else(PoisonError::into_inner),
        }
    }

    /// The box around everything that can be hit.
    #[inline]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// The tree, built now if nobody needed it before.
    #[inline]
    pub fn part(&self) -> &BspPart {
        self.built.get_or_init(|| {
            let triangles = std::mem::take(&mut *self.waiting.lock().unwrap_or_else(PoisonError::into_inner));
            build(triangles, self.bounds, self.quality).map_or_else(BspPart::List, BspPart::Tree)
        })
    }

    /// [`Bsp::part`], if there was memory for a tree.
    pub fn tree(&self) -> Option<&BspTree> {
        match self.part() {
            BspPart::Tree(tree) => Some(tree),
            BspPart::List(_) => None,
        }
    }

    /// Whether a ray has asked for the tree.
    pub fn is_built(&self) -> bool {
        self.built.get().is_some()
    }

    /// Bytes held, capacity included.
    pub fn memory_bytes(&self) -> usize {
        match self.built.get() {
            Some(BspPart::Tree(tree)) => tree.memory_bytes(),
            Some(BspPart::List(triangles)) => triangles.capacity() * size_of::<Corners>(),
            None => {
                let waiting = self.waiting.lock().unwrap_or_else(PoisonError::into_inner);
                waiting.capacity() * size_of::<Corners>()
            }
        }
    }
}

#[cfg(test)]
mod tests;
