//! What a ray found.

use crate::accel::Merged;

/// The closest hit of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Hit {
    /// Distance in units of the ray's direction.
    pub t: f32,
    /// Barycentric weight of the triangle's second corner.
    pub u: f32,
    /// Barycentric weight of the triangle's third corner.
    pub v: f32,
    /// Triangle number within the object.
    pub primitive: u32,
    /// Object name.
    pub object: u32,
    /// Number of the instance within the frame, in the order of `rtInstantiateObject`.
    pub instance: u32,
}

impl Hit {
    /// The members of hits in their order, the last three as bits: so that many hits can be turned to rows of lanes.
    #[inline(always)]
    pub fn numbers<const N: usize>(hits: &[Hit; N]) -> &[[f32; 6]; N] {
        const { assert!(size_of::<Hit>() == 6 * size_of::<f32>() && align_of::<Hit>() == align_of::<f32>()) };
        // SAFETY: a `Hit` is `repr(C)` of six members of four bytes, without padding; any four bytes are an f32.
        unsafe { &*std::ptr::from_ref(hits).cast::<[[f32; 6]; N]>() }
    }

    /// [`Hit::primitive`] of no hit.
    pub const NOTHING: u32 = u32::MAX;
    /// [`Hit::instance`] of no hit.
    pub const NO_INSTANCE: u32 = u32::MAX;

    /// No hit up to and including `tmax`: every hit with `t <= tmax` comes before it.
    #[inline]
    pub fn none(tmax: f32) -> Self {
        Hit { t: tmax, u: 0.0, v: 0.0, primitive: Self::NOTHING, object: 0, instance: Self::NO_INSTANCE }
    }

    /// No hit, as answers to queries tell it: `t` is -1, and the numbers are 0.
    pub const MISS: Hit = Hit { t: -1.0, u: 0.0, v: 0.0, primitive: 0, object: 0, instance: 0 };

    /// Whether this is an answer of no hit: distances of hits are at least 0.
    #[inline]
    pub fn is_miss(&self) -> bool {
        self.t < 0.0
    }

    /// The hit, if this answer is one.
    #[inline]
    pub fn found(self) -> Option<Hit> {
        if self.is_miss() { None } else { Some(self) }
    }

    /// The order of hits at equal distance.
    #[inline(always)]
    pub(super) fn order(instance: u32, prim: u32) -> u64 {
        u64::from(instance) << 32 | u64::from(prim)
    }

    /// Whether this is still what [`Hit::none`] gave.
    #[inline]
    pub fn is_none(&self) -> bool {
        self.primitive == Self::NOTHING
    }

    /// The rule that makes the closest hit unique: smaller `t`, then lower instance, then lower primitive.
    /// (An instance has one object, so the object needs no comparison of its own.)
    #[inline]
    pub fn is_before(&self, other: &Hit) -> bool {
        self.t < other.t || (self.t == other.t && (self.instance, self.primitive) < (other.instance, other.primitive))
    }

    /// A hit in the tree of merged static instances, with the numbers of the triangle that was hit.
    #[inline]
    pub(super) fn located(self, merged: &Merged) -> Hit {
        let (instance, object, prim) = merged.locate(self.primitive);
        Hit { primitive: prim, object, instance, ..self }
    }

    /// Puts this hit in the place of `best` if it comes before. Returns whether it does.
    #[inline]
    pub(super) fn replaces(self, best: &mut Hit) -> bool {
        let before = self.is_before(best);
        if before {
            *best = self;
        }
        before
    }
}
