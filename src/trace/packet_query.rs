//! Packets from outside: up to 64 rays that somebody has already in rows of lanes, as a renderer makes them.
//!
//! The packet goes in as it is: nothing is sorted or turned from rays to rows, and the answers are read where the kernels leave them. What a
//! batch of single rays ([`super::packet_batch`]) sorts by octant is here split by octant on the way through the trees, so the
//! directions of a packet should mostly have the same signs.

use super::packet::{LANES, Packet, RAYS, Rows};
use super::packet_scene::{Scratch, traverse};
use super::shells::Shells;
use super::tracer::WORTH_A_PACKET;
use super::{Hit, Kernels, Ray, Scope, Tracer};
use crate::memory::{OutOfMemory, boxed};
use crate::simd::bits;
use glam::Vec3;

/// Up to 64 rays that begin at their origins (`tmin` 0). Ray `r` is lane `r % 8` of row `r / 8`.
#[derive(Clone)]
#[repr(C, align(64))]
pub struct RayPacket {
    /// Of each axis.
    pub org: [Rows; 3],
    /// Of each axis; any length but 0.
    pub dir: [Rows; 3],
    /// Largest accepted distance, may be infinite.
    pub tmax: Rows,
}

impl RayPacket {
    /// Rays per packet.
    pub const RAYS: usize = RAYS;

    /// Rays without direction, which hit nothing.
    pub fn new() -> Self {
        let rows = [[0.0; LANES]; RAYS / LANES];
        Self { org: [rows; 3], dir: [rows; 3], tmax: rows }
    }

    /// Ray `r`.
    #[inline]
    pub fn ray(&self, r: usize) -> Ray {
        let (g, l) = (r / LANES, r % LANES);
        let vec = |rows: &[Rows; 3]| Vec3::new(rows[0][g][l], rows[1][g][l], rows[2][g][l]);
        Ray { origin: vec(&self.org), tmin: 0.0, direction: vec(&self.dir), tmax: self.tmax[g][l] }
    }

    /// Puts a ray, whose `tmin` counts as 0, in the place of ray `r`.
    #[inline]
    pub fn set(&mut self, r: usize, ray: &Ray) {
        let (g, l) = (r / LANES, r % LANES);
        for k in 0..3 {
            self.org[k][g][l] = ray.origin[k];
            self.dir[k][g][l] = ray.direction[k];
        }
        self.tmax[g][l] = ray.tmax;
    }
}

impl Default for RayPacket {
    fn default() -> Self {
        Self::new()
    }
}

/// What packets are traced in. To be kept from packet to packet.
pub struct PacketMemory(Box<Scratch>);

impl PacketMemory {
    /// About 12 KB.
    pub fn new() -> Self {
        Self(Box::new(Scratch::new()))
    }

    /// # Errors
    /// The memory is not there.
    pub fn try_new() -> Result<Self, OutOfMemory> {
        Ok(Self(boxed(Scratch::new())?))
    }
}

impl Default for PacketMemory {
    fn default() -> Self {
        Self::new()
    }
}

impl Tracer<'_> {
    /// [`Tracer::intersect`] for the rays of a packet whose bits are set in `mask`. Hit `r` is that of ray `r`, or
    /// [`Hit::is_none`]; those of rays not in `mask` mean nothing.
    pub fn intersect_packet<'m>(&self, rays: &RayPacket, mask: u64, memory: &'m mut PacketMemory) -> &'m [Hit; RAYS] {
        let scratch = &mut *memory.0;
        let mut alone = mask;
        if mask.count_ones() as usize >= WORTH_A_PACKET {
            // SAFETY: holding kernels proves that the processor can run them.
            alone = unsafe { (self.kernels.intersect_packet)(self.world, rays, mask, scratch) };
        }
        for r in bits(alone) {
            let ray = rays.ray(r);
            scratch.found.hits[r] = self.intersect(&ray).unwrap_or(Hit::none(ray.tmax));
        }
        &scratch.found.hits
    }

    /// [`Tracer::occluded`] for the rays of a packet whose bits are set in `mask`; a bit for each.
    pub fn occluded_packet(&self, rays: &RayPacket, mask: u64, memory: &mut PacketMemory) -> u64 {
        let scratch = &mut *memory.0;
        let (mut alone, mut occluded) = (mask, 0);
        if mask.count_ones() as usize >= WORTH_A_PACKET {
            // SAFETY: holding kernels proves that the processor can run them.
            alone = unsafe { (self.kernels.occluded_packet)(self.world, rays, mask, scratch) };
            occluded = scratch.world.usable & !scratch.found.open;
        }
        for r in bits(alone) {
            occluded |= u64::from(self.occluded(&rays.ray(r))) << r;
        }
        occluded
    }
}

/// Traces the rays of `mask`, of which there is at least one. Returns those that have to go alone, as their directions are of
/// unusual length. The answers are in `scratch`, see [`traverse`].
///
/// # Safety
/// - The processor has the instruction set `I`, and `kernels` are its own.
#[inline(always)]
pub(super) unsafe fn trace_packet<I: Shells, const ANY: bool>(
    world: Scope<'_>,
    kernels: &Kernels,
    rays: &RayPacket,
    mask: u64,
    scratch: &mut Scratch,
) -> u64 {
    // SAFETY: the caller's promise.
    unsafe {
        let alone = Packet::take_in::<I, ANY>(&mut scratch.world, &mut scratch.found, rays, mask);
        if scratch.found.open != 0 {
            traverse::<I, ANY>(world, kernels, scratch);
        }
        alone
    }
}
