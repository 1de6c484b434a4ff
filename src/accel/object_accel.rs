//! The acceleration structure of one object, and its way from frame to frame.
//!
//! A closed enum instead of trait objects: few kinds of structure exist, and traversal matches once per object and ray. Which one, and how it
//! follows changes, is decided in [`super::strategy`] and done in [`update`]. Instances share the structure (Wald03 §4.1).
//!
//! What rays traverse ([`ObjectAccel`]) is apart from what updates remember ([`ObjectState`]): the former is shared with snapshots
//! ([`super::WorldView`]) and never changed while one holds it. An update then works on a copy, or builds anew.
//!
//! The structure of a static object that is placed once is built in world space (see [`super::statics`]); where it is placed then counts
//! as its vertices do. It has none of its own while its triangles are in the merged tree.

mod state;
mod update;
mod worth;

pub(super) use self::state::{Identity, ObjectState, Outcome, Spent, Work};

use super::Aabb;
use super::bsp::Bsp;
use super::bvh::Bvh;
use super::grid::Grid;
use super::lazy::{LazyBvh, Source};
use super::proximity::ProximityTree;
use super::visibility::VisibilityField;
use super::waiting::{Visits, Waiting};
use crate::scene::Mesh;
use std::sync::{Arc, OnceLock};

/// What rays of one object traverse.
#[derive(Debug, Default)]
pub enum Structure {
    /// Nothing is built: the object has not been instanced yet, or memory ran out.
    #[default]
    None,
    Bvh(Bvh),
    Bsp(Bsp),
    Grid(Grid),
    Lazy(LazyBvh),
    Field(VisibilityField),
}

impl Structure {
    pub(super) fn memory_bytes(&self) -> usize {
        match self {
            Structure::None => 0,
            Structure::Bvh(bvh) => bvh.memory_bytes(),
            Structure::Bsp(bsp) => bsp.memory_bytes(),
            Structure::Grid(grid) => grid.memory_bytes(),
            Structure::Lazy(lazy) => lazy.memory_bytes(),
            Structure::Field(field) => field.memory_bytes(),
        }
    }
}

/// One object as rays meet it. Shared by snapshots; changed by updates only while nobody else holds it.
#[derive(Debug, Default)]
pub struct ObjectAccel {
    pub(super) structure: Structure,
    /// The structure, while it waits for a ray; there is no other then.
    pub(super) waiting: Option<Box<Waiting>>,
    pub(super) triangles: u64,
    pub(super) visits: Visits,
    /// Of the object in its own space, once somebody has asked what is near.
    proximity: OnceLock<ProximityTree>,
}

impl ObjectAccel {
    /// What a ray traverses that has come to the object. One that waited for it is brought up to date.
    #[inline(always)]
    pub fn structure(&self) -> &Structure {
        self.visits.count();
        match &self.waiting {
            None => &self.structure,
            Some(waiting) => waiting.structure(),
        }
    }

    /// The tree for questions about nearness; `mesh` is the object's. Empty without memory, so nothing is near then.
    pub fn proximity(&self, mesh: &Mesh) -> &ProximityTree {
        self.proximity.get_or_init(|| ProximityTree::new(mesh).unwrap_or_default())
    }

    /// The box around everything that can be hit, in object space.
    #[inline]
    pub fn bounds(&self) -> Aabb {
        if let Some(waiting) = &self.waiting {
            return waiting.bounds();
        }
        match &self.structure {
            Structure::None => Aabb::EMPTY,
            Structure::Bvh(bvh) => bvh.bounds(),
            Structure::Bsp(bsp) => bsp.bounds(),
            Structure::Grid(grid) => grid.bounds(),
            Structure::Lazy(lazy) => lazy.bounds(),
            Structure::Field(field) => field.bounds(),
        }
    }

    /// Triangles of the object, those that no ray can hit included.
    #[inline]
    pub fn triangles(&self) -> u64 {
        self.triangles
    }

    /// Bytes that rays traverse; 0 while nothing is built.
    pub fn memory_bytes(&self) -> usize {
        let proximity = self.proximity.get().map_or(0, ProximityTree::memory_bytes);
        proximity + self.structure.memory_bytes() + self.waiting.as_ref().map_or(0, |w| w.memory_bytes())
    }

    /// What rays have had brought up to date since [`ObjectAccel::forget_touched`]: subtrees and nodes, or subfields and references.
    pub(super) fn touched(&self) -> (u32, u64) {
        match (&self.waiting, &self.structure) {
            (Some(waiting), _) => waiting.touched(),
            (None, Structure::Lazy(lazy)) => lazy.touched(),
            (None, Structure::Field(field)) => field.touched(),
            _ => (0, 0),
        }
    }

    /// Vertices have moved.
    fn forget_proximity(&mut self) {
        self.proximity = OnceLock::new();
    }

    /// Counts anew what [`ObjectAccel::touched`] tells.
    pub(super) fn forget_touched(&mut self) {
        match &mut self.structure {
            Structure::Lazy(lazy) => lazy.forget_touched(),
            Structure::Field(field) => field.forget_touched(),
            _ => {}
        }
    }

    /// A copy that an update of `mesh`, which is what `source` refers to, can go on with: trees, with nothing in a lazy one up to date.
    /// None for structures that are built anew at every move, and without memory.
    fn copied(&self, mesh: &Mesh, source: Source) -> Option<Structure> {
        let bvh = |bvh: &Bvh| bvh.try_clone().ok().map(Structure::Bvh);
        match (&self.waiting, &self.structure) {
            (Some(waiting), _) => waiting.copied_tree().ok().map(Structure::Bvh),
            (None, Structure::Bvh(tree)) => bvh(tree),
            (None, Structure::Lazy(lazy)) => lazy.outdated_copy(mesh, source).ok().map(Structure::Lazy),
            _ => None,
        }
    }
}

/// The object for an update to change: a fresh one in the place of one that a snapshot holds. To be filled by a copy or a build.
fn exclusive(shared: &mut Arc<ObjectAccel>) -> &mut ObjectAccel {
    if Arc::get_mut(shared).is_none() {
        *shared = Arc::new(ObjectAccel {
            triangles: shared.triangles,
            visits: shared.visits.clone(),
            ..ObjectAccel::default()
        });
    }
    Arc::get_mut(shared).expect("nobody else has a fresh one")
}
