//! Rays through the tree of [`LazyBvh`], whose segments are brought up to date when a ray reaches them: one ray, or a packet.
//!
//! The loops are those of [`super::traverse_bvh`] and [`super::traverse_packet`]. What is new is at the leaves: one beyond a segment's own blocks is another segment, which is
//! entered by a call of the same kernel. So the stamp of a segment is looked at once per visit, and never in the loop over nodes. `deeper` is
//! that kernel in the shell of the instruction set: a recursive function cannot inline into the shell.

use super::kernels::Shells;
use super::packet::{Found, GROUPS, LANES, Packet};
use super::packet_boxes::Slabs;
use super::packet_triangles::intersect_leaf;
use super::stack::{STACK, Stack, pop, push};
use super::traverse_bvh::SlabLanes;
use super::traverse_packet::{Leaves, traverse_packet};
use super::triangle4::{RayLanes, edges4};
use super::{Hit, PreparedRay, SLAB_PAD};
use crate::accel::{ChildRef, LazyBvh, LazyPart};
use crate::simd::{Isa, Vector, prefetch};
use std::mem::MaybeUninit;

/// Where in a tree: a segment, and a child in it.
pub(super) type At = (usize, ChildRef);

/// [`below`] in its shell.
pub(super) type Deeper<I> =
    unsafe fn(&LazyBvh, At, &(SlabLanes<I>, RayLanes<I>), &PreparedRay, u32, u32, &mut Hit) -> bool;

/// [`packet_below`] in its shell.
pub(super) type PacketDeeper = unsafe fn(&LazyBvh, usize, &Packet, u64, u32, u32, &mut Found);

/// The root.
pub(super) const ROOT: At = (0, ChildRef::ROOT);

/// Looks for hits of `ray` in `lazy`, by the contract of [`super::Kernels::intersect`] or with `ANY` of [`super::Kernels::occluded`].
///
/// # Safety
/// - The processor has the instruction set `I`, and `deeper` needs no other.
#[inline(always)]
pub(super) unsafe fn traverse<I: Shells>(
    lazy: &LazyBvh,
    ray: &PreparedRay,
    object: u32,
    instance: u32,
    best: &mut Hit,
    deeper: Deeper<I>,
) -> bool {
    // SAFETY: the caller's promise; a tree that is not empty has a root.
    unsafe {
        !lazy.is_empty() && {
            let lanes = (SlabLanes::<I>::new(ray), RayLanes::<I>::new(ray));
            deeper(lazy, ROOT, &lanes, ray, object, instance, best)
        }
    }
}

/// [`traverse`], from a child of a segment down. What the loop needs of the ray is in `lanes`.
///
/// # Safety
/// - The processor has the instruction set `I`, and `deeper` needs no other; the child is of the segment.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "a kernel's state, kept in registers")]
pub(super) unsafe fn below<I: Shells, const ANY: bool>(
    lazy: &LazyBvh,
    (segment, child): At,
    lanes: &(SlabLanes<I>, RayLanes<I>),
    ray: &PreparedRay,
    object: u32,
    instance: u32,
    best: &mut Hit,
    deeper: Deeper<I>,
) -> bool {
    let touch;
    let part = match lazy.current(segment) {
        Some(part) => part,
        None => {
            touch = lazy.touch(segment);
            touch.part()
        }
    };
    let LazyPart { nodes, blocks, below } = part;
    let mut stack: Stack = [const { MaybeUninit::uninit() }; STACK];
    let mut depth = 0;
    let mut found = false;
    let mut current = child;
    // SAFETY: the caller's promise, for all vector operations. The references in a segment are to its own nodes and blocks or to
    // segments below, and paths have at most MAX_DEPTH nodes (by its construction from a `Bvh`); all nodes but
    // the first come from the stack.
    unsafe {
        let mut limit = I::F8::splat(best.t * SLAB_PAD);
        loop {
            // Down to a leaf.
            let reached = loop {
                if current.is_leaf() {
                    break true;
                }
                let node = nodes.get_unchecked(current.index());
                let (mask, enter) = lanes.0.test(node, limit);
                if mask == 0 {
                    break false;
                }
                current = push::<I>(&mut stack, &mut depth, node, mask, enter);
            };
            if reached {
                let mut closer = false;
                let run = current.blocks();
                if run.start >= blocks.len() {
                    let root = (below + run.start - blocks.len(), ChildRef::ROOT);
                    closer = deeper(lazy, root, lanes, ray, object, instance, best);
                    if ANY && closer {
                        return true;
                    }
                } else {
                    for block in blocks.get_unchecked(run) {
                        let Some((candidates, edges)) = edges4(&lanes.1, block) else { continue };
                        closer |= I::resolve::<ANY, _>(ray, block, candidates, &edges, (object, instance), best);
                        if ANY && closer {
                            return true;
                        }
                    }
                }
                if closer {
                    found = true;
                    limit = I::F8::splat(best.t * SLAB_PAD);
                }
            }
            // Back to what is left.
            let Some(next) = pop::<ANY>(&stack, &mut depth, best.t * SLAB_PAD) else { return found };
            current = next;
        }
    }
}

/// The rays of `mask` from the root of a segment down, by the contract of `packet_object::traverse_object`.
///
/// # Safety
/// - The processor has the instruction set `I`, and `deeper` and `alone` need no other; the tree is not empty.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "a kernel's state, kept in registers")]
pub(super) unsafe fn packet_below<I: Shells, const ANY: bool>(
    lazy: &LazyBvh,
    segment: usize,
    packet: &Packet,
    mask: u64,
    object: u32,
    instance: u32,
    found: &mut Found,
    deeper: PacketDeeper,
    alone: Deeper<I>,
) {
    let touch;
    let part = match lazy.current(segment) {
        Some(part) => part,
        None => {
            touch = lazy.touch(segment);
            touch.part()
        }
    };
    let slabs = Slabs { near_org: &packet.org, far_org: &packet.org, inv_dir: &packet.inv_dir, tmin: &packet.tmin };
    let mut leaves = LazyLeaves::<I, ANY> { lazy, segment, part, packet, object, instance, deeper, alone };
    // SAFETY: the caller's promise; a segment is a tree (by its construction from a `Bvh`).
    unsafe { traverse_packet::<I, _>(part.nodes, &slabs, &packet.negative, mask, &mut leaves, found) }
}

/// The triangles of a segment and the segments below it, as seen by a packet.
struct LazyLeaves<'a, I: Isa, const ANY: bool> {
    lazy: &'a LazyBvh,
    segment: usize,
    part: LazyPart<'a>,
    packet: &'a Packet,
    object: u32,
    instance: u32,
    deeper: PacketDeeper,
    alone: Deeper<I>,
}

impl<I: Shells, const ANY: bool> Leaves<I> for LazyLeaves<'_, I, ANY> {
    const FEW: u32 = 4;

    #[inline(always)]
    unsafe fn test(&mut self, leaf: ChildRef, mask: u64, down: [bool; 3], found: &mut Found) -> bool {
        let Self { lazy, part, packet, object, instance, deeper, .. } = *self;
        let run = leaf.blocks();
        // SAFETY: the caller's promise; the leaf is a run of the segment's own blocks, or a segment.
        unsafe {
            if run.start < part.blocks.len() {
                let run = part.blocks.get_unchecked(run);
                return intersect_leaf::<I, ANY>(packet, mask, down, run, object, instance, found) && !ANY;
            }
            deeper(lazy, part.below + run.start - part.blocks.len(), packet, mask, object, instance, found);
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
        let Self { lazy, segment, packet, object, instance, alone, .. } = *self;
        let t = &mut found.t[r / LANES % GROUPS][r % LANES];
        let tmax = *t;
        // SAFETY: the caller's promise.
        unsafe {
            let ray = packet.ray(r, tmax);
            let lanes = (SlabLanes::<I>::new(&ray), RayLanes::<I>::new(&ray));
            if ANY {
                if alone(lazy, (segment, child), &lanes, &ray, object, instance, &mut Hit::none(tmax)) {
                    found.open &= !(1 << r);
                }
            } else {
                let best = &mut found.hits[r];
                if alone(lazy, (segment, child), &lanes, &ray, object, instance, best) {
                    *t = best.t;
                }
            }
        }
    }
}
