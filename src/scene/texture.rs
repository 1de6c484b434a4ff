//! Two-dimensional textures with their mip-map chain.

use glam::Affine2;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Wrap {
    #[default]
    Repeat,
    ClampToEdge,
    MirroredRepeat,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Filter {
    Nearest,
    /// Bilinear on the base level.
    Linear,
    /// Bilinear on the two nearest levels, blended.
    #[default]
    LinearMipmapLinear,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TextureFormat {
    /// Values are used as stored.
    #[default]
    Linear,
    /// Colour channels are decoded from the sRGB curve when looked up.
    Srgb,
}

/// An image and how it is looked up. Row 0 is at t = 0 (the bottom), as in OpenGL.
#[derive(Clone, Debug, Default)]
pub struct Texture {
    /// Level 0 first; each level has half the size (at least 1) of the one before. Empty without an image.
    pub levels: Vec<TextureLevel>,
    pub wrap_s: Wrap,
    pub wrap_t: Wrap,
    pub filter: Filter,
    pub format: TextureFormat,
    /// From the coordinates of the surface to those of the image.
    pub transform: Affine2,
}

/// One mip-map level: RGBA8, row by row.
#[derive(Clone, Debug, Default)]
pub struct TextureLevel {
    pub width: u32,
    pub height: u32,
    pub texels: Vec<[u8; 4]>,
}
