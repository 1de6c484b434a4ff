//! Ray cones: how wide a pixel has become, for texture filtering and line widths.
//!
//! After Akenine-Möller et al., *Texture Level of Detail Strategies for Real-Time Ray Tracing* (Ray Tracing Gems,
//! 2019, ch. 20): a cone of `width` at the ray's origin opens by `spread` per unit of distance. Bounces pass the cone
//! on; curved mirrors are treated as flat ones, rough bounces open it. We filter over the *area* of the footprint
//! (width²/cos), which blurs less at grazing angles than its long axis would, and aliases less than its short one.

/// The cone around a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Width where the ray is now, in world units.
    pub width: f32,
    /// Growth of the width per unit of distance.
    pub spread: f32,
}

impl Cone {
    /// The cone after `distance`.
    #[inline]
    pub fn advanced(self, distance: f32) -> Self {
        Self { width: self.width + self.spread.abs() * distance, spread: self.spread }
    }

    /// The cone after a bounce that scatters by about `angle` (radians).
    #[inline]
    pub fn widened(self, angle: f32) -> Self {
        Self { spread: self.spread.max(angle), ..self }
    }
}
