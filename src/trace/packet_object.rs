//! A packet of rays through the 8-wide tree of one object.

use super::Hit;
use super::ground::Plain;
use super::one_ray::InPacket;
use super::packet::{Found, GROUPS, LANES, Packet};
use super::packet_boxes::Slabs;
use super::packet_triangles::intersect_leaf;
use super::shells::Shells;
use super::traverse_bvh::traverse_below;
use super::traverse_packet::{Alike, Leaves, traverse_packet};
use super::turns::differ_much;
use crate::accel::{Bvh, ChildRef};
use crate::simd::{bits, prefetch};

/// The triangles of one object, as seen by a packet in its space.
struct Triangles<'a, const ANY: bool> {
    bvh: &'a Bvh,
    packet: &'a Packet,
    object: u32,
    instance: u32,
    /// Whether the directions of the rays that are on their way differ much.
    differ: bool,
}

/// Looks for hits of the rays of `packet` that are in `mask`, by the contract of [`super::Kernels::intersect`], or with `ANY` of
/// [`super::Kernels::occluded`]; rays that are hit then leave `found.open`.
///
/// # Safety
/// - The processor has the instruction set `I`.
#[inline(always)]
pub(super) unsafe fn traverse_object<I: Shells, const ANY: bool>(
    bvh: &Bvh,
    packet: &Packet,
    mask: u64,
    object: u32,
    instance: u32,
    found: &mut Found,
) {
    if bvh.is_empty() {
        return;
    }
    let slabs = Slabs { near_org: &packet.org, far_org: &packet.org, inv_dir: &packet.inv_dir, tmin: &packet.tmin };
    let mut triangles = Triangles::<ANY> { bvh, packet, object, instance, differ: false };
    // SAFETY: the caller's promise; a `Bvh` that is not empty is a tree (its invariants, checked on construction).
    unsafe {
        traverse_packet::<I, _>(bvh.nodes(), ChildRef::ROOT, &slabs, &packet.negative, mask, &mut triangles, found)
    }
}

impl<I: Shells, const ANY: bool> Leaves<I> for Triangles<'_, ANY> {
    const FEW: u32 = 4;

    #[inline(always)]
    unsafe fn test(&mut self, leaf: ChildRef, mask: u64, alike: Alike, found: &mut Found) -> bool {
        let Self { bvh, packet, object, instance, .. } = *self;
        // SAFETY: the caller's promise; the leaf is a run of the tree's own blocks.
        unsafe {
            let run = bvh.blocks().get_unchecked(leaf.blocks());
            intersect_leaf::<I, ANY>(packet, mask, alike, run, object, instance, found) && !ANY
        }
    }

    #[inline(always)]
    fn prefetch(&self, child: ChildRef) {
        if child.is_leaf() {
            prefetch(self.bvh.blocks(), child.blocks().start);
        } else {
            prefetch(self.bvh.nodes(), child.index());
        }
    }

    #[inline(always)]
    unsafe fn apart(&mut self, mask: u64, down: [bool; 3], found: &mut Found) -> bool {
        let Self { bvh, packet, object, instance, .. } = *self;
        // SAFETY: the caller's promise; a tree that is walked is not empty.
        unsafe {
            self.differ = differ_much::<I>(packet, mask);
            if !found.habits::<ANY>(self.differ).are_to_part() {
                return false;
            }
            for r in bits(I::turns::<ANY, _>(
                &Plain::new(bvh),
                ChildRef::ROOT,
                packet,
                mask,
                down,
                (object, instance),
                found,
            )) {
                <Self as Leaves<I>>::alone(self, ChildRef::ROOT, r, down, found);
            }
        }
        true
    }

    #[inline(always)]
    fn went_alone(&mut self, rays: u32, alone: u32, found: &mut Found) {
        found.habits::<ANY>(self.differ).saw(rays, alone);
    }

    #[inline(always)]
    unsafe fn alone(&mut self, child: ChildRef, r: usize, down: [bool; 3], found: &mut Found) {
        let Self { bvh, packet, object, instance, .. } = *self;
        let t = &mut found.t[r / LANES % GROUPS][r % LANES];
        let tmax = *t;
        // SAFETY: the caller's promise.
        unsafe {
            let ray = InPacket::new(packet, r, down);
            if ANY {
                let none = &mut Hit::none(tmax);
                if traverse_below::<I, true>(bvh, child, ray, object, instance, none) {
                    found.open &= !(1 << r);
                }
            } else {
                let best = &mut found.hits[r];
                if traverse_below::<I, false>(bvh, child, ray, object, instance, best) {
                    *t = best.t;
                }
            }
        }
    }
}
