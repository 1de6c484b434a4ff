//! The acceleration structure of one object, and its way from frame to frame.
//!
//! A closed enum instead of trait objects: few kinds of structure exist, and traversal matches once per object and ray. Which one, and how it
//! follows changes, is decided in [`super::strategy`] and done in [`update`]. Instances share the structure (Wald03 §4.1).
//!
//! The structure of a static object that is placed once is built in world space (see [`super::statics`]); where it is placed then counts
//! as its vertices do. It has none of its own while its triangles are in the merged tree.

mod update;
mod worth;

use self::worth::Worth;
use super::Aabb;
use super::bsp::Bsp;
use super::build_fast::FastScratch;
use super::build_sah::SahScratch;
use super::bvh::{Bvh, OutOfMemory};
use super::by_rays::{ByRays, LARGE};
use super::grid::Grid;
use super::key_trees::KeyTrees;
use super::lazy::LazyBvh;
use super::links::Links;
use super::rotate::Wear;
use super::strategy::{Method, Moved};
use super::visibility::VisibilityField;
use super::waiting::{Attention, Waiting};
use crate::scene::{Name, Object};
use glam::Affine3A;

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

/// One object's structure and what it was made from.
#[derive(Debug, Default)]
pub struct ObjectAccel {
    name: Name,
    structure: Structure,
    made_with: Option<Method>,
    topology_version: u64,
    vertex_version: u64,
    /// SAH cost after the last build, where wear is watched.
    cost_when_built: f64,
    definitions: u64,
    triangles: u64,
    /// Where the structure is, if it is in world space.
    placed: Option<Affine3A>,
    /// The triangles are in the merged tree; there is no structure here.
    merged: bool,
    /// Updates without a change, and how often the object left the merged tree.
    calm: u32,
    exits: u32,
    /// The structure, while it waits for a ray; there is no other then.
    waiting: Option<Box<Waiting>>,
    attention: Attention,
    worth: Worth,
    by_rays: ByRays,
    spent: Spent,
    /// What rotations remember of the tree.
    wear: Wear,
    /// For partial refits, once there has been one, and how many nodes these have looked at since wear was.
    links: Option<Links>,
    patched: usize,
    keys: KeyTrees,
    scratch: Scratch,
}

/// What an update did about a change, and how long it took: all threads that worked for it, and it for others.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Spent {
    pub work: Work,
    pub seconds: f64,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Work {
    /// All else.
    #[default]
    Other,
    /// A complete refit in which nothing had to be sorted.
    Refit,
    /// A build with care.
    Sah,
}

/// What builders worked with, kept for an object that is built again and again.
#[derive(Debug, Default)]
struct Scratch {
    sah: SahScratch,
    fast: FastScratch,
}

/// Which triangles in world space a structure stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Identity {
    name: Name,
    topology_version: u64,
    vertex_version: u64,
    pub world_from_object: Affine3A,
}

/// What an update did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    Unchanged,
    /// Built anew, with so many nodes (0 for a BSP, whose tree comes with the first ray).
    Built(usize),
    Refitted(usize),
    /// Put off until a ray comes.
    Waits,
    /// The object has no structure and cannot be hit.
    Failed(OutOfMemory),
}

impl ObjectAccel {
    pub(super) fn new(name: Name) -> Self {
        Self { name, ..Self::default() }
    }

    #[inline]
    pub fn name(&self) -> Name {
        self.name
    }

    /// What a ray traverses that has come to the object. One that waited for it is brought up to date.
    #[inline(always)]
    pub fn structure(&self) -> &Structure {
        self.attention.reach();
        match &self.waiting {
            None => &self.structure,
            Some(waiting) => waiting.structure(),
        }
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

    /// Bytes held; 0 while nothing is built.
    pub fn memory_bytes(&self) -> usize {
        let links = self.links.as_ref().map_or(0, Links::memory_bytes);
        let waiting = self.waiting.as_ref().map_or(0, |w| w.memory_bytes());
        let structure = self.structure.memory_bytes() + waiting + self.keys.memory_bytes();
        let rotations = self.wear.memory_bytes() + self.by_rays.memory_bytes();
        structure + links + rotations + self.scratch.sah.memory_bytes() + self.scratch.fast.memory_bytes()
    }

    /// What the last update took.
    pub(super) fn spent(&self) -> Spent {
        self.spent
    }

    /// Whether the strategy `Auto` leaves updates to the rays.
    pub(super) fn is_left_to_rays(&self) -> bool {
        self.made_with.is_some_and(Method::may_wait) && matches!(self.structure, Structure::Lazy(_))
    }

    /// Whether the coming update could be left to the rays: all of a large object has moved, and a ray has met it. Gives the part of it that rays had
    /// brought up to date, if that is known.
    pub(super) fn could_be_left_to_rays(&self, object: &Object) -> Option<Option<f64>> {
        let follows = self.made_with.is_some_and(Method::may_wait)
            && self.topology_version == object.topology_version
            && object.moves.any_since(self.vertex_version)
            && self.triangles >= LARGE
            && self.attention.is_reached();
        follows.then(|| match &self.structure {
            Structure::Lazy(lazy) => Some(lazy.touched().1 as f64 / lazy.nodes().max(1) as f64),
            _ => None,
        })
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

    /// How often rays or packets of them came since the last update, up to a bound.
    pub(super) fn met(&self) -> u64 {
        self.attention.met()
    }

    /// Rays took `traced` seconds since the last update, and came to objects `met` times. Counts anew from now on.
    pub(super) fn tell_traced(&mut self, traced: f64, met: u64) {
        let mine = self.attention.take_met();
        self.worth.tell(traced, mine as f64 / met.max(1) as f64);
    }

    pub(super) fn forget_touched(&mut self) {
        match &mut self.structure {
            Structure::Lazy(lazy) => lazy.forget_touched(),
            Structure::Field(field) => field.forget_touched(),
            _ => {}
        }
    }

    /// Where the structure is, if it is in world space: then rays are not transformed.
    #[inline]
    pub fn placed(&self) -> Option<&Affine3A> {
        self.placed.as_ref()
    }

    /// Whether the triangles are in the merged tree, and there is no structure here.
    #[inline]
    pub fn is_merged(&self) -> bool {
        self.merged
    }

    /// What a structure in world space stands for. None for other structures, and if memory ran out.
    pub(super) fn identity(&self) -> Option<Identity> {
        let Self { name, topology_version, vertex_version, .. } = *self;
        self.made_with?;
        self.placed.map(|world_from_object| Identity { name, topology_version, vertex_version, world_from_object })
    }

    /// Whether the triangles may go to the merged tree, after at least `wait` updates without a change: those of a
    /// tree like the merged one. Who left that before has to wait longer.
    pub(super) fn may_merge(&self, wait: u32) -> bool {
        let like_merged = Method::Bvh { fast: false, moved: Moved::Rebuild };
        self.made_with == Some(like_merged) && self.triangles > 0 && self.calm >= wait << self.exits.min(10)
    }

    /// The triangles are in the merged tree from now on.
    pub(super) fn enter_merged(&mut self) {
        self.structure = Structure::None;
        self.waiting = None;
        self.links = None;
        self.merged = true;
    }

    /// The triangles are not in the merged tree any more; the next update builds a structure.
    pub(super) fn leave_merged(&mut self) {
        self.merged = false;
        self.made_with = None;
        self.exits += 1;
    }
}
