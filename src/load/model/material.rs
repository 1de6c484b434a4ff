//! Materials and where their textures come from.

use glam::Vec3;
use std::path::PathBuf;

/// A surface in the terms of Whitted's model; linear colours.
///
/// Colour of a point = `emission` + `ambient` × the scene's ambient light × texture
/// + Σ lights (`diffuse` × texture × cos + `specular` × Phong lobe) + `reflection` × what the mirror direction sees
/// + `transmission` × what the refracted direction sees.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    pub name: String,
    pub emission: Vec3,
    pub ambient: Vec3,
    pub diffuse: Vec3,
    pub specular: Vec3,
    /// Exponent of the Phong lobe.
    pub shininess: f32,
    pub reflection: Vec3,
    /// Share of light that passes through, 0 to 1.
    pub transmission: f32,
    /// Index of refraction inside; 1 bends nothing.
    pub ior: f32,
    /// Index into `SceneFile::textures`; modulates `ambient` and `diffuse`.
    pub texture: Option<u32>,
    /// Texels with less alpha than this are holes.
    pub alpha_cutoff: Option<f32>,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: "default".into(),
            emission: Vec3::ZERO,
            ambient: Vec3::splat(0.1),
            diffuse: Vec3::splat(0.7),
            specular: Vec3::ZERO,
            shininess: 1.0,
            reflection: Vec3::ZERO,
            transmission: 0.0,
            ior: 1.0,
            texture: None,
            alpha_cutoff: None,
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
pub enum TextureData {
    File(PathBuf),
    /// An encoded image (PNG, JPEG, …) that was inside another file.
    Bytes(Vec<u8>),
}

/// An image that is read when the scene is given to the library.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureSource {
    pub name: String,
    pub data: TextureData,
    /// The first row of the image lies at t = 0 (AFF, glTF); otherwise the last one does (OBJ).
    pub first_row_at_zero: bool,
    pub clamp_s: bool,
    pub clamp_t: bool,
}
