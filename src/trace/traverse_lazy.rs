//! Rays through the tree of [`LazyBvh`], whose segments are brought up to date when a ray reaches them: one ray, or a packet.
//!
//! The loops are those of [`super::traverse_bvh`] and [`super::traverse_packet`]. What is new is at the leaves: one beyond a segment's own blocks is another segment, which is
//! entered by a call of the same kernel ([`Shells`]). So the stamp of a segment is looked at once per visit, and never in the loop over nodes.

use super::kernels::Shells;
use super::packet::{Found, GROUPS, LANES, Packet};
use super::packet_boxes::Slabs;
use super::packet_triangles::intersect_leaf;
use super::traverse_bvh::{Below, SlabLanes, descend};
use super::traverse_packet::{Leaves, traverse_packet};
use super::triangle4::RayLanes;
use super::{Hit, PreparedRay};
use crate::accel::{ChildRef, LazyBvh, LazyPart, Touch};
use crate::simd::prefetch;

/// Where in a tree: a segment, and a child in it.
pub(super) type At = (usize, ChildRef);

/// What the loop needs of a ray.
pub(super) type Lanes<I> = (SlabLanes<I>, RayLanes<I>);

/// Looks for hits of `ray` in `lazy`, by the contract of [`super::Kernels::intersect`] or with `ANY` of [`super::Kernels::occluded`].
///
/// # Safety
/// - The processor has the instruction set `I`.
#[inline(always)]
pub(super) unsafe fn traverse<I: Shells, const ANY: bool>(
    lazy: &LazyBvh,
    ray: &PreparedRay,
    numbers: (u32, u32),
    best: &mut Hit,
) -> bool {
    // SAFETY: the caller's promise; a tree that is not empty has a root.
    unsafe {
        !lazy.is_empty() && {
            let lanes = (SlabLanes::<I>::new(ray), RayLanes::<I>::new(ray));
            let mut any = Hit::none(ray.tmax);
            let best = if ANY { &mut any } else { best };
            I::lazy::<ANY>(lazy, (0, ChildRef::ROOT), &lanes, ray, numbers, best)
        }
    }
}

/// Likewise the rays of `mask`, by the contract of `packet_object::traverse_object`.
///
/// # Safety
/// - The processor has the instruction set `I`.
#[inline(always)]
pub(super) unsafe fn traverse_many<I: Shells, const ANY: bool>(
    lazy: &LazyBvh,
    packet: &Packet,
    mask: u64,
    numbers: (u32, u32),
    found: &mut Found,
) {
    if !lazy.is_empty() {
        // SAFETY: the caller's promise.
        unsafe { I::lazy_packet::<ANY>(lazy, 0, packet, mask, numbers, found) }
    }
}

/// A segment, up to date; `touch` is a place for it if it has to be brought there.
#[inline(always)]
fn segment_of<'a>(lazy: &'a LazyBvh, segment: usize, touch: &'a mut Option<Touch<'a>>) -> LazyPart<'a> {
    match lazy.current(segment) {
        Some(part) => part,
        None => touch.insert(lazy.touch(segment)).part(),
    }
}

/// [`traverse`], from a child of a segment down.
///
/// # Safety
/// - The processor has the instruction set `I`; the child is of the segment, and `lanes` are those of `ray`.
#[inline(always)]
pub(super) unsafe fn below<I: Shells, const ANY: bool>(
    lazy: &LazyBvh,
    (segment, child): At,
    lanes: &Lanes<I>,
    ray: &PreparedRay,
    numbers: (u32, u32),
    best: &mut Hit,
) -> bool {
    let mut touch = None;
    let part = segment_of(lazy, segment, &mut touch);
    let segments = SegmentsBelow::<I, ANY> { lazy, first: part.below, lanes, ray, numbers };
    // SAFETY: the caller's promise. The references in a segment are to its own nodes and blocks or to
    // segments below, and paths have at most MAX_DEPTH nodes (by its construction from a `Bvh`).
    unsafe { descend::<I, ANY, _, _>((part.nodes, part.blocks), child, lanes, ray, numbers, best, &segments) }
}

/// The segments below one, as seen by a ray.
struct SegmentsBelow<'a, I: Shells, const ANY: bool> {
    lazy: &'a LazyBvh,
    first: usize,
    lanes: &'a Lanes<I>,
    ray: &'a PreparedRay,
    numbers: (u32, u32),
}

impl<I: Shells, const ANY: bool> Below for SegmentsBelow<'_, I, ANY> {
    const IS_THERE: bool = true;

    #[inline(always)]
    unsafe fn enter(&self, i: usize, best: &mut Hit) -> bool {
        let root = (self.first + i, ChildRef::ROOT);
        // SAFETY: the caller's promise.
        unsafe { I::lazy::<ANY>(self.lazy, root, self.lanes, self.ray, self.numbers, best) }
    }
}

/// [`traverse_many`], from the root of a segment down.
///
/// # Safety
/// - The processor has the instruction set `I`; the tree is not empty.
#[inline(always)]
pub(super) unsafe fn packet_below<I: Shells, const ANY: bool>(
    lazy: &LazyBvh,
    segment: usize,
    packet: &Packet,
    mask: u64,
    numbers: (u32, u32),
    found: &mut Found,
) {
    let mut touch = None;
    let part = segment_of(lazy, segment, &mut touch);
    let slabs = Slabs { near_org: &packet.org, far_org: &packet.org, inv_dir: &packet.inv_dir, tmin: &packet.tmin };
    let mut leaves = LazyLeaves::<ANY> { lazy, segment, part, packet, numbers };
    // SAFETY: the caller's promise; a segment is a tree (by its construction from a `Bvh`).
    unsafe { traverse_packet::<I, _>(part.nodes, &slabs, &packet.negative, mask, &mut leaves, found) }
}

/// The triangles of a segment and the segments below it, as seen by a packet.
struct LazyLeaves<'a, const ANY: bool> {
    lazy: &'a LazyBvh,
    segment: usize,
    part: LazyPart<'a>,
    packet: &'a Packet,
    numbers: (u32, u32),
}

impl<I: Shells, const ANY: bool> Leaves<I> for LazyLeaves<'_, ANY> {
    const FEW: u32 = 4;

    #[inline(always)]
    unsafe fn test(&mut self, leaf: ChildRef, mask: u64, down: [bool; 3], found: &mut Found) -> bool {
        let Self { lazy, part, packet, numbers, .. } = *self;
        let run = leaf.blocks();
        // SAFETY: the caller's promise; the leaf is a run of the segment's own blocks, or a segment.
        unsafe {
            if run.start < part.blocks.len() {
                let run = part.blocks.get_unchecked(run);
                return intersect_leaf::<I, ANY>(packet, mask, down, run, numbers.0, numbers.1, found) && !ANY;
            }
            I::lazy_packet::<ANY>(lazy, part.below + run.start - part.blocks.len(), packet, mask, numbers, found);
            !ANY
        }
    }

    #[inline(always)]
    fn prefetch(&self, child: ChildRef) {
        if child.is_leaf() {
            prefetch(self.part.blocks, child.blocks().start);
        } else {
            prefetch(self.part.nodes, child.index());
        }
    }

    #[inline(always)]
    unsafe fn alone(&mut self, child: ChildRef, r: usize, found: &mut Found) {
        let Self { lazy, segment, packet, numbers, .. } = *self;
        let t = &mut found.t[r / LANES % GROUPS][r % LANES];
        let tmax = *t;
        // SAFETY: the caller's promise.
        unsafe {
            let ray = packet.ray(r, tmax);
            let lanes = (SlabLanes::<I>::new(&ray), RayLanes::<I>::new(&ray));
            let mut none = Hit::none(tmax);
            let best = if ANY { &mut none } else { &mut found.hits[r] };
            if I::lazy::<ANY>(lazy, (segment, child), &lanes, &ray, numbers, best) {
                if ANY {
                    found.open &= !(1 << r);
                } else {
                    *t = best.t;
                }
            }
        }
    }
}
