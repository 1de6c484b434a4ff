//! One ray as the kernels for one ray read it: alone, or where it is in a packet.

use super::PreparedRay;
use super::packet::{GROUPS, LANES, Packet};

/// One ray as the kernels for one ray read it: alone, or out of a packet.
pub(super) trait OneRay: Copy {
    fn org(self, axis: usize) -> f32;
    fn inv_dir(self, axis: usize) -> f32;
    fn tmin(self) -> f32;
    /// See [`PreparedRay::shear`].
    fn shear(self, i: usize) -> f32;
    /// See [`PreparedRay::axis`]; every number is below 3.
    fn axes(self) -> [usize; 3];
    /// Everything at once, for the scalar test; `tmax` in the place of its own end.
    fn prepared(self, tmax: f32) -> PreparedRay;
}

impl OneRay for &PreparedRay {
    #[inline(always)]
    fn org(self, axis: usize) -> f32 {
        self.org[axis]
    }
    #[inline(always)]
    fn inv_dir(self, axis: usize) -> f32 {
        self.inv_dir[axis]
    }
    #[inline(always)]
    fn tmin(self) -> f32 {
        self.tmin
    }
    #[inline(always)]
    fn shear(self, i: usize) -> f32 {
        self.shear[i]
    }
    #[inline(always)]
    fn axes(self) -> [usize; 3] {
        self.axis
    }
    #[inline(always)]
    fn prepared(self, tmax: f32) -> PreparedRay {
        PreparedRay { tmax, ..*self }
    }
}

/// Ray `r` of a packet.
#[derive(Clone, Copy)]
pub(super) struct InPacket<'a> {
    packet: &'a Packet,
    r: usize,
}

impl<'a> InPacket<'a> {
    #[inline(always)]
    pub(super) fn new(packet: &'a Packet, r: usize) -> Self {
        Self { packet, r: r % (GROUPS * LANES) }
    }

    #[inline(always)]
    fn of(self, rows: &[[f32; LANES]; GROUPS]) -> f32 {
        rows[self.r / LANES % GROUPS][self.r % LANES]
    }
}

impl OneRay for InPacket<'_> {
    #[inline(always)]
    fn org(self, axis: usize) -> f32 {
        self.of(&self.packet.org[axis])
    }
    #[inline(always)]
    fn inv_dir(self, axis: usize) -> f32 {
        self.of(&self.packet.inv_dir[axis])
    }
    #[inline(always)]
    fn tmin(self) -> f32 {
        self.of(&self.packet.tmin)
    }
    #[inline(always)]
    fn shear(self, i: usize) -> f32 {
        self.of(&self.packet.shear[i])
    }
    #[inline(always)]
    fn axes(self) -> [usize; 3] {
        const NEXT: [usize; 5] = [0, 1, 2, 0, 1];
        let z = self.packet.axis(self.r);
        [NEXT[z + 1], NEXT[z + 2], NEXT[z]]
    }
    #[inline(always)]
    fn prepared(self, tmax: f32) -> PreparedRay {
        self.packet.ray(self.r, tmax)
    }
}
