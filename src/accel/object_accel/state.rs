//! What updates remember of an object from frame to frame, beside the structure that rays traverse.

use super::worth::Worth;
use super::{ObjectAccel, Structure};
use crate::accel::OutOfMemory;
use crate::accel::build_fast::FastScratch;
use crate::accel::build_sah::SahScratch;
use crate::accel::by_rays::{ByRays, LARGE};
use crate::accel::key_trees::KeyTrees;
use crate::accel::links::Links;
use crate::accel::refit::SweepScratch;
use crate::accel::rotate::Wear;
use crate::accel::strategy::{Method, Moved};
use crate::accel::waiting::Attention;
use crate::scene::{Mask, Name, Object};
use glam::Affine3A;
use std::sync::Arc;

/// One object as updates know it.
#[derive(Debug, Default)]
pub struct ObjectState {
    pub(super) name: Name,
    mask: Mask,
    pub(super) made_with: Option<Method>,
    pub(super) topology_version: u64,
    pub(super) vertex_version: u64,
    /// SAH cost after the last build, where wear is watched.
    pub(super) cost_when_built: f64,
    pub(super) definitions: u64,
    /// Where the structure is, if it is in world space.
    pub(super) placed: Option<Affine3A>,
    /// The triangles are in the merged tree; there is no structure here.
    pub(super) merged: bool,
    /// Updates without a change, and how often the object left the merged tree.
    pub(super) calm: u32,
    pub(super) exits: u32,
    pub(super) attention: Attention,
    pub(super) worth: Worth,
    pub(super) by_rays: ByRays,
    pub(super) spent: Spent,
    /// What rotations remember of the tree.
    pub(super) wear: Wear,
    /// For partial refits, once there has been one, and how many nodes these have looked at since wear was.
    pub(super) links: Option<Links>,
    pub(super) patched: usize,
    pub(super) keys: KeyTrees,
    pub(super) scratch: Scratch,
}

/// What an update did about a change, and how long it took: all threads that worked for it, and it for others.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::accel) struct Spent {
    pub work: Work,
    pub seconds: f64,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::accel) enum Work {
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
pub(super) struct Scratch {
    pub(super) sah: SahScratch,
    pub(super) fast: FastScratch,
    pub(super) sweeps: SweepScratch,
}

impl Scratch {
    fn memory_bytes(&self) -> usize {
        self.sah.memory_bytes() + self.fast.memory_bytes() + self.sweeps.memory_bytes()
    }
}

/// Which triangles in world space a structure stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::accel) struct Identity {
    pub(super) name: Name,
    pub(super) topology_version: u64,
    pub(super) vertex_version: u64,
    pub world_from_object: Affine3A,
}

/// What an update did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::accel) enum Outcome {
    Unchanged,
    /// Built anew, with so many nodes (0 for a BSP, whose tree comes with the first ray).
    Built(usize),
    Refitted(usize),
    /// Put off until a ray comes.
    Waits,
    /// The object has no structure and cannot be hit.
    Failed(OutOfMemory),
}

impl ObjectState {
    pub(in crate::accel) fn new(name: Name) -> Self {
        Self { name, ..Self::default() }
    }

    #[inline]
    pub(in crate::accel) fn name(&self) -> Name {
        self.name
    }

    /// Which rays see the object's instances.
    #[inline]
    pub(in crate::accel) fn mask(&self) -> Mask {
        self.mask
    }

    pub(in crate::accel) fn set_mask(&mut self, mask: Mask) {
        self.mask = mask;
    }

    /// Bytes held beside those of `accel`, which is the object's.
    pub(in crate::accel) fn memory_bytes(&self) -> usize {
        let links = self.links.as_ref().map_or(0, Links::memory_bytes);
        let rotations = self.wear.memory_bytes() + self.by_rays.memory_bytes();
        links + self.keys.memory_bytes() + rotations + self.scratch.memory_bytes()
    }

    /// What the last update took.
    pub(in crate::accel) fn spent(&self) -> Spent {
        self.spent
    }

    /// Whether the strategy `Auto` leaves updates of `accel`, which is the object's, to the rays.
    pub(in crate::accel) fn is_left_to_rays(&self, accel: &ObjectAccel) -> bool {
        self.made_with.is_some_and(Method::may_wait) && matches!(accel.structure, Structure::Lazy(_))
    }

    /// Whether the coming update could be left to the rays: all of a large object has moved, and a ray has met it. Gives the part of it that rays had
    /// brought up to date, if that is known.
    pub(in crate::accel) fn could_be_left_to_rays(&self, accel: &ObjectAccel, object: &Object) -> Option<Option<f64>> {
        let follows = self.made_with.is_some_and(Method::may_wait)
            && self.topology_version == object.topology_version
            && object.moves.any_since(self.vertex_version)
            && accel.triangles >= LARGE
            && accel.visits.is_reached();
        follows.then(|| match &accel.structure {
            Structure::Lazy(lazy) => Some(lazy.touched().1 as f64 / lazy.nodes().max(1) as f64),
            _ => None,
        })
    }

    /// Rays took `traced` seconds since the last update, came to this object `mine` times and to all objects `met` times.
    pub(in crate::accel) fn tell_traced(&mut self, traced: f64, mine: u64, met: u64) {
        self.worth.tell(traced, mine as f64 / met.max(1) as f64);
    }

    /// Where the structure is, if it is in world space: then rays are not transformed.
    #[inline]
    pub(in crate::accel) fn placed(&self) -> Option<&Affine3A> {
        self.placed.as_ref()
    }

    /// Whether the triangles are in the merged tree, and there is no structure of the object's own.
    #[inline]
    pub(in crate::accel) fn is_merged(&self) -> bool {
        self.merged
    }

    /// What a structure in world space stands for. None for other structures, and if memory ran out.
    pub(in crate::accel) fn identity(&self) -> Option<Identity> {
        let Self { name, topology_version, vertex_version, .. } = *self;
        self.made_with?;
        self.placed.map(|world_from_object| Identity { name, topology_version, vertex_version, world_from_object })
    }

    /// Whether the triangles may go to the merged tree, after at least `wait` updates without a change: those of a
    /// tree like the merged one. Who left that before has to wait longer.
    pub(in crate::accel) fn may_merge(&self, accel: &ObjectAccel, wait: u32) -> bool {
        let like_merged = Method::Bvh { fast: false, moved: Moved::Rebuild };
        self.made_with == Some(like_merged) && accel.triangles > 0 && self.calm >= wait << self.exits.min(10)
    }

    /// The triangles are in the merged tree from now on: `accel`, which is the object's, gives its structure up.
    pub(in crate::accel) fn enter_merged(&mut self, accel: &mut Arc<ObjectAccel>) {
        let accel = super::exclusive(accel);
        accel.structure = Structure::None;
        accel.waiting = None;
        self.links = None;
        self.merged = true;
    }

    /// The triangles are not in the merged tree any more; the next update builds a structure.
    pub(in crate::accel) fn leave_merged(&mut self) {
        self.merged = false;
        self.made_with = None;
        self.exits += 1;
    }
}
