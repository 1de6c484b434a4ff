//! Which rays see what: 32 bits each.

/// Kinds of rays, as bits. An object and an instance have a mask each, and so has a ray: it meets the instances that have, in the object's mask
/// and in their own, a bit in common with its own. The upper bits are the application's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Mask(pub u32);

impl Mask {
    /// Everything: what objects, instances and rays begin with.
    pub const ALL: Mask = Mask(u32::MAX);
    pub const NONE: Mask = Mask(0);
    /// Rays of a camera.
    pub const CAMERA: Mask = Mask(1);
    /// Rays from a surface to a light, and those that look for occluders nearby.
    pub const SHADOW: Mask = Mask(2);
    /// Rays that are reflected, refracted or scattered.
    pub const REFLECTION: Mask = Mask(4);
    /// Rays of the application's queries.
    pub const QUERY: Mask = Mask(8);

    /// Whether the two have a bit in common.
    #[inline(always)]
    pub fn meets(self, other: Mask) -> bool {
        self.0 & other.0 != 0
    }

    /// What is in both.
    #[inline(always)]
    pub fn and(self, other: Mask) -> Mask {
        Mask(self.0 & other.0)
    }

    /// This one, with the bits of `bits` set or not.
    pub fn with(self, bits: Mask, set: bool) -> Mask {
        if set { Mask(self.0 | bits.0) } else { Mask(self.0 & !bits.0) }
    }
}

impl Default for Mask {
    fn default() -> Self {
        Mask::ALL
    }
}
