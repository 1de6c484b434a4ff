//! What the SAH builder knows of a triangle: its box and its number, in 32 bytes.
//!
//! Tried: the upper corner negated, so that growing a box is one minimum over eight lanes. Written over arrays it became masked stores, which made
//! binning twice as slow.

use glam::{Vec3, Vec4};

/// A box of four lanes, of which the last is meaningless.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct Box4 {
    lo: Vec4,
    hi: Vec4,
}

impl Box4 {
    pub const EMPTY: Box4 = Box4 { lo: Vec4::INFINITY, hi: Vec4::NEG_INFINITY };

    #[inline(always)]
    pub fn new(lo: Vec4, hi: Vec4) -> Self {
        Self { lo, hi }
    }

    #[inline(always)]
    pub fn grow(&mut self, other: &Box4) {
        self.lo = self.lo.min(other.lo);
        self.hi = self.hi.max(other.hi);
    }

    #[inline(always)]
    pub fn lo(&self) -> Vec4 {
        self.lo
    }

    #[inline(always)]
    pub fn hi(&self) -> Vec4 {
        self.hi
    }

    /// The common part; empty when there is none.
    pub fn intersection(&self, other: &Box4) -> Box4 {
        Box4 { lo: self.lo.max(other.lo), hi: self.hi.min(other.hi) }
    }

    /// Sides of the box; 0 for an empty one. The last lane is meaningless.
    #[inline(always)]
    pub fn extent(&self) -> Vec4 {
        (self.hi - self.lo).max(Vec4::ZERO)
    }

    #[inline(always)]
    pub fn half_area(&self) -> f32 {
        let e = self.extent();
        e.x * e.y + (e.y * e.z + e.z * e.x)
    }
}

/// A triangle's box, whose number sits in the first unused lane.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub(super) struct PrimRef(Box4);

impl PrimRef {
    /// A placeholder.
    pub const EMPTY: PrimRef = PrimRef(Box4::EMPTY);

    #[inline(always)]
    pub fn new(prim: u32, lo: Vec4, hi: Vec4) -> Self {
        // The 1 makes the sum in the number's lane a normal float: denormal factors are slow on some processors.
        PrimRef(Box4 { lo: lo.with_w(f32::from_bits(prim)), hi: hi.with_w(1.0) })
    }

    #[inline(always)]
    pub fn prim(&self) -> u32 {
        self.0.lo.w.to_bits()
    }

    #[inline(always)]
    pub fn bounds(&self) -> &Box4 {
        &self.0
    }

    /// Whether the box is not empty.
    #[inline(always)]
    pub fn is_usable(&self) -> bool {
        self.0.lo.x <= self.0.hi.x
    }

    /// What of the box lies between `lo` and `hi`; all sides are turned round if that is nothing.
    #[inline(always)]
    pub fn clipped(&self, lo: Vec4, hi: Vec4) -> Self {
        let (lo, hi) = (self.0.lo.max(lo), self.0.hi.min(hi));
        if (lo.cmple(hi).bitmask() & 7) == 7 {
            Self::new(self.prim(), lo, hi)
        } else {
            Self::new(self.prim(), Vec4::INFINITY, Vec4::NEG_INFINITY)
        }
    }

    /// The same triangle, with the box around this box and another one.
    pub fn union(&self, other: &Self) -> Self {
        Self::new(self.prim(), self.0.lo.min(other.0.lo), self.0.hi.max(other.0.hi))
    }

    /// Twice the centre of the box; the last lane is meaningless.
    #[inline(always)]
    pub fn center2(&self) -> Vec4 {
        self.0.lo + self.0.hi
    }
}

/// The box around the doubled centres of triangles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Centers {
    pub lo: Vec4,
    pub hi: Vec4,
}

impl Centers {
    pub const EMPTY: Centers = Centers { lo: Vec4::INFINITY, hi: Vec4::NEG_INFINITY };

    #[inline(always)]
    pub fn of(refs: &[PrimRef]) -> Self {
        let mut all = Self::EMPTY;
        for r in refs {
            let c = r.center2();
            all.lo = all.lo.min(c);
            all.hi = all.hi.max(c);
        }
        all
    }

    pub fn union(self, other: Self) -> Self {
        Self { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    #[inline(always)]
    pub fn extent(&self) -> Vec3 {
        (self.hi - self.lo).truncate()
    }
}
