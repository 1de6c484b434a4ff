//! One ray as the kernels for one ray read it: alone, or where it is in a packet.

use super::PreparedRay;
use super::packet::{Packet, RAYS, Rows};

/// One ray as the kernels for one ray read it: alone, or out of a packet.
pub(super) trait OneRay: Copy {
    fn org(self, axis: usize) -> f32;
    /// The origin, its numbers in the order of `axes`, each below 3.
    fn permuted_org(self, axes: [usize; 3]) -> [f32; 3];
    fn inv_dir(self, axis: usize) -> f32;
    /// Whether `inv_dir` is below 0.
    fn is_down(self, axis: usize) -> bool;
    fn tmin(self) -> f32;
    /// See [`PreparedRay::excludes`].
    fn excludes(self, t: f32, instance: u32, prim: u32) -> bool;
    /// See [`PreparedRay::shear`].
    fn shear(self, i: usize) -> f32;
    /// The last of [`PreparedRay::axis`].
    fn longest_axis(self) -> usize;
    /// Everything at once, for the scalar test; `tmax` in the place of its own end.
    fn prepared(self, tmax: f32) -> PreparedRay;
}

impl OneRay for &PreparedRay {
    #[inline(always)]
    fn org(self, axis: usize) -> f32 {
        self.org[axis]
    }
    #[inline(always)]
    fn permuted_org(self, axes: [usize; 3]) -> [f32; 3] {
        // Indexing an array of four by two bits needs neither branch nor check.
        let org = [self.org.x, self.org.y, self.org.z, 0.0];
        [org[axes[0] & 3], org[axes[1] & 3], org[axes[2] & 3]]
    }
    #[inline(always)]
    fn inv_dir(self, axis: usize) -> f32 {
        self.inv_dir[axis]
    }
    #[inline(always)]
    fn is_down(self, axis: usize) -> bool {
        self.inv_dir[axis] < 0.0
    }
    #[inline(always)]
    fn tmin(self) -> f32 {
        self.tmin
    }
    #[inline(always)]
    fn excludes(self, t: f32, instance: u32, prim: u32) -> bool {
        PreparedRay::excludes(self, t, instance, prim)
    }
    #[inline(always)]
    fn shear(self, i: usize) -> f32 {
        self.shear[i]
    }
    #[inline(always)]
    fn longest_axis(self) -> usize {
        self.axis[2]
    }
    #[inline(always)]
    fn prepared(self, tmax: f32) -> PreparedRay {
        PreparedRay { tmax, ..*self }
    }
}

/// Ray `r` of a packet, whose directions are below 0 on the axes of `down`: known for many rays at once.
#[derive(Clone, Copy)]
pub(super) struct InPacket<'a> {
    packet: &'a Packet,
    r: usize,
    down: [bool; 3],
}

impl<'a> InPacket<'a> {
    #[inline(always)]
    pub(super) fn new(packet: &'a Packet, r: usize, down: [bool; 3]) -> Self {
        Self { packet, r: r % RAYS, down }
    }

    #[inline(always)]
    fn of(self, rows: &Rows) -> f32 {
        rows.as_flattened()[self.r % RAYS]
    }
}

impl OneRay for InPacket<'_> {
    #[inline(always)]
    fn org(self, axis: usize) -> f32 {
        self.of(&self.packet.org[axis])
    }
    #[inline(always)]
    fn permuted_org(self, axes: [usize; 3]) -> [f32; 3] {
        [self.org(axes[0]), self.org(axes[1]), self.org(axes[2])]
    }
    #[inline(always)]
    fn inv_dir(self, axis: usize) -> f32 {
        self.of(&self.packet.inv_dir[axis])
    }
    #[inline(always)]
    fn is_down(self, axis: usize) -> bool {
        self.down[axis]
    }
    #[inline(always)]
    fn tmin(self) -> f32 {
        self.of(&self.packet.tmin)
    }
    /// All hits of packets count.
    #[inline(always)]
    fn excludes(self, _t: f32, _instance: u32, _prim: u32) -> bool {
        false
    }
    #[inline(always)]
    fn shear(self, i: usize) -> f32 {
        self.of(&self.packet.shear[i])
    }
    #[inline(always)]
    fn longest_axis(self) -> usize {
        self.packet.axis(self.r)
    }
    #[inline(always)]
    fn prepared(self, tmax: f32) -> PreparedRay {
        self.packet.ray(self.r, tmax)
    }
}
