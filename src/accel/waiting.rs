//! The tree of an object that nobody looks at: when its vertices move, it waits for a ray.
//!
//! `RT_AUTO` does with whole objects what Larsson and Akenine-Möller (*Strategies for Bounding Volume Hierarchy Updates for Ray Tracing of Deformable
//! Models*, 2003, §3) do with the nodes of one. An object that no ray met in the frame before will most likely not be met in this one, so its tree
//! stays as it is and only the box around its vertices is made anew, which takes a tenth of a refit. The first ray that enters the box
//! refits the tree; then the object is refit at updates again, by all threads.
//!
//! *Where we differ* from [`super::lazy`]: there are no segments, so the tree is that of a refit, rays traverse it as fast, and
//! to begin waiting costs nothing. But rays of other threads that come while the first one refits have to wait for it, and
//! one thread refits. So an object that is looked at now and then is made to wait less and less often ([`Attention`]).

use super::bvh::{Bvh, OutOfMemory};
use super::lazy::Source;
use super::object_accel::Structure;
use super::refit::SweepScratch;
use super::vertex_box::box_of_all;
use super::{Aabb, Refit};
use crate::scene::Mesh;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};

/// A tree behind its mesh.
#[derive(Debug)]
pub(super) struct Waiting {
    /// Until a ray comes.
    stale: Mutex<Option<(Bvh, SweepScratch)>>,
    fresh: OnceLock<Structure>,
    source: Source,
    bounds: Aabb,
    nodes: usize,
    bytes: usize,
}

impl Waiting {
    /// Lets `bvh` wait, whose mesh is `mesh` now; `source` refers to it. The tree must be one that may wait ([`Bvh::may_wait`]). To be called inside the
    /// pool, with a scratch that is ready ([`Bvh::prepare_alone`]).
    pub fn new(bvh: Bvh, scratch: SweepScratch, mesh: &Mesh, source: Source) -> Self {
        let (nodes, bytes) = (bvh.nodes().len(), bvh.memory_bytes());
        let bounds = box_of_all(&mesh.positions);
        Self { stale: Mutex::new(Some((bvh, scratch))), fresh: OnceLock::new(), source, bounds, nodes, bytes }
    }

    /// The mesh is elsewhere, and the same.
    pub fn set_source(&mut self, source: Source) {
        self.source = source;
    }

    /// A box around everything that can be hit.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// The tree, brought up to date.
    #[inline]
    pub fn structure(&self) -> &Structure {
        self.fresh.get_or_init(|| self.refit())
    }

    #[cold]
    fn refit(&self) -> Structure {
        let stale = self.stale.lock().unwrap_or_else(PoisonError::into_inner).take();
        let (mut bvh, mut scratch) = stale.expect("only the first ray refits");
        // Not by the pool: a thread that waits for others' parts would render another tile, come here and wait for itself.
        let done = bvh.refit_alone(&self.source.mesh(), &mut scratch);
        assert_eq!(done, Refit::Done, "a tree that may wait can be refit");
        Structure::Bvh(bvh)
    }

    /// Nodes that a ray has had brought up to date.
    pub fn touched(&self) -> (u32, u64) {
        if self.was_reached() { (1, self.nodes as u64) } else { (0, 0) }
    }

    pub fn was_reached(&self) -> bool {
        self.fresh.get().is_some()
    }

    /// Where the mesh is.
    pub fn source(&self) -> &Source {
        &self.source
    }

    /// A copy of what [`Waiting::into_tree`] gives.
    ///
    /// # Errors
    /// No memory.
    pub fn copied_tree(&self) -> Result<Bvh, OutOfMemory> {
        if let Some((bvh, _)) = &*self.stale.lock().unwrap_or_else(PoisonError::into_inner) {
            return bvh.try_clone();
        }
        // A ray of a snapshot may be at work on it at this moment: then its end is waited for.
        match self.structure() {
            Structure::Bvh(bvh) => bvh.try_clone(),
            _ => Ok(Bvh::default()),
        }
    }

    /// The tree: as it was when it began to wait, or since a ray came.
    pub fn into_tree(self) -> Bvh {
        match self.fresh.into_inner() {
            Some(Structure::Bvh(bvh)) => bvh,
            _ => self.stale.into_inner().unwrap_or_else(PoisonError::into_inner).unwrap_or_default().0,
        }
    }

    pub fn memory_bytes(&self) -> usize {
        self.bytes
    }
}

impl Bvh {
    /// Whether it can be refit to wherever its vertices go.
    pub(super) fn may_wait(&self, mesh: &Mesh) -> bool {
        self.dropped.is_empty() && self.can_hold(mesh)
    }
}

/// Updates without a ray, in a row, before an object waits that has been looked at while it did: at most so many.
const MOST_PATIENCE: u32 = 32;

/// Objects that rays meet more often in a frame are met equally often, as far as anyone knows: to go on counting would have threads wait for each other.
const ENOUGH: u32 = 1024;

/// Rays that have come to an object. Counted by rays of frames and of snapshots alike.
#[derive(Debug, Default)]
pub(super) struct Visits {
    /// A ray has come since the last update that moved vertices.
    reached: AtomicBool,
    /// How often one came since the last update, up to [`ENOUGH`].
    met: AtomicU32,
}

impl Clone for Visits {
    fn clone(&self) -> Self {
        let (reached, met) = (self.reached.load(Ordering::Relaxed), self.met.load(Ordering::Relaxed));
        Self { reached: AtomicBool::new(reached), met: AtomicU32::new(met) }
    }
}

impl Visits {
    /// A ray, or a packet of them, is here. Not written any more where many have come, so threads share the line.
    #[inline(always)]
    pub fn count(&self) {
        if self.met.load(Ordering::Relaxed) < ENOUGH {
            self.count_one();
        }
    }

    #[cold]
    #[inline(never)]
    fn count_one(&self) {
        self.met.fetch_add(1, Ordering::Relaxed);
        self.reached.store(true, Ordering::Relaxed);
    }

    /// How often [`Visits::count`] was called since the last [`Visits::take_met`], up to about [`ENOUGH`].
    pub fn met(&self) -> u64 {
        u64::from(self.met.load(Ordering::Relaxed))
    }

    pub fn take_met(&self) -> u64 {
        u64::from(self.met.swap(0, Ordering::Relaxed))
    }

    /// Whether a ray has come since the last update that moved vertices.
    pub fn is_reached(&self) -> bool {
        self.reached.load(Ordering::Relaxed)
    }

    /// Likewise, and all vertices move now.
    pub fn take_reached(&self) -> bool {
        self.reached.swap(false, Ordering::Relaxed)
    }
}

/// Whether an object is looked at from frame to frame.
#[derive(Debug, Default)]
pub(super) struct Attention {
    unseen: u32,
    patience: u32,
}

impl Attention {
    /// Whether the object was looked at in the frame before the last move.
    pub fn was_reached(&self) -> bool {
        self.unseen == 0
    }

    /// Vertices have moved: whether the object should wait for a ray. `reached`: one came since the move before ([`Visits::take_reached`]);
    /// `had_to_come`: one came while the object waited.
    pub fn should_wait(&mut self, reached: bool, had_to_come: bool) -> bool {
        if had_to_come {
            self.patience = (2 * self.patience + 1).min(MOST_PATIENCE);
        }
        self.unseen = if reached || had_to_come { 0 } else { self.unseen + 1 };
        self.unseen > self.patience
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_is_looked_at_now_and_then_waits_less_often() {
        let (mut attention, visits) = (Attention::default(), Visits::default());
        visits.count();
        assert!(!attention.should_wait(visits.take_reached(), false), "a ray was there");
        assert!(attention.should_wait(visits.take_reached(), false), "and now none");
        // A ray comes in every fourth frame, if the object waits or not.
        let (mut waits, mut came) = (Vec::new(), false);
        for frame in 0..64 {
            let wait = attention.should_wait(visits.take_reached(), std::mem::take(&mut came));
            if frame % 4 == 3 {
                came = wait;
                visits.count();
            }
            waits.push(wait);
        }
        let sum = |part: &[bool]| part.iter().filter(|w| **w).count();
        assert!(sum(&waits[..8]) >= 2, "{waits:?}");
        assert_eq!(sum(&waits[16..]), 0, "three frames are not worth it: {waits:?}");
    }
}
