//! How much of a surface is there: opacity, holes and blending.

use crate::shade::interaction::Interaction;
use crate::shade::surface::TextureId;
use crate::shade::textures::Textures;
use crate::shade::values::Values;

/// What decides a surface's coverage; see [`crate::shade::class`].
#[derive(Clone, Copy)]
pub struct Alpha {
    pub opacity: f32,
    /// Its red multiplies alpha.
    pub texture: TextureId,
    /// Points with less alpha do not exist. 0 keeps every point.
    pub threshold: f32,
    /// Alpha multiplies the opacity.
    pub blend: bool,
}

impl Default for Alpha {
    /// Opaque everywhere.
    fn default() -> Self {
        Self { opacity: 1.0, texture: None, threshold: 0.0, blend: false }
    }
}

impl Alpha {
    /// From the parameters `opacity`, `alpha_texture`, `alpha_threshold` and `alpha_blend`.
    pub fn new(values: Values, textures: &Textures) -> Self {
        Self {
            opacity: values.float("opacity").clamp(0.0, 1.0),
            texture: textures.id(values.texture("alpha_texture")),
            threshold: values.float("alpha_threshold"),
            blend: values.int("alpha_blend") != 0,
        }
    }

    /// Whether every point is there, and hides what lies behind it.
    #[inline]
    pub fn is_opaque(&self) -> bool {
        self.threshold <= 0.0 && self.opacity == 1.0 && !self.blend
    }

    /// Whether there may be points that do not exist.
    pub fn has_holes(&self) -> bool {
        self.threshold > 0.0 || self.blend
    }

    /// Coverage of a point whose colour has alpha `base`.
    #[inline]
    pub fn at(&self, base: f32, it: &Interaction, textures: &Textures) -> f32 {
        if self.threshold <= 0.0 && !self.blend {
            return self.opacity;
        }
        let alpha = base * textures.lookup(self.texture, it.point.tex_coord, || it.footprint()).x;
        if self.threshold > 0.0 && alpha < self.threshold {
            return 0.0;
        }
        if self.blend { self.opacity * alpha.clamp(0.0, 1.0) } else { self.opacity }
    }
}
