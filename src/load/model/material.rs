//! Materials and where their textures come from.

use crate::api::{Filter, Wrap};
use glam::{Affine2, Vec2, Vec3};
use std::path::PathBuf;
use std::sync::Arc;

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
    /// Share of what lies behind that is hidden.
    pub opacity: f32,
    /// The alpha of texture and vertex colours multiplies `opacity`.
    pub alpha_blend: bool,
    /// The surface glows with this colour × texture, whatever shines on it. Of the other terms only alpha counts then.
    pub unlit: Option<Vec3>,
    /// The surface in other terms. Of those above only `texture` and alpha count then.
    pub metallic_roughness: Option<Box<MetallicRoughness>>,
}

/// A surface in the terms of glTF: the parameters of the shader class `metallic_roughness`. Textures are indices into
/// `SceneFile::textures`.
#[derive(Clone, Debug, PartialEq)]
pub struct MetallicRoughness {
    pub color: Vec3,
    pub metallic: f32,
    pub roughness: f32,
    /// Reflectance of a dielectric at normal incidence.
    pub specular: Vec3,
    pub emission: Vec3,
    pub transmission: f32,
    /// 1: a thin sheet.
    pub ior: f32,
    pub metallic_roughness_texture: Option<u32>,
    pub normal_texture: Option<u32>,
    pub normal_scale: Vec2,
    pub occlusion_texture: Option<u32>,
    pub occlusion_strength: f32,
    pub emission_texture: Option<u32>,
}

impl Default for MetallicRoughness {
    fn default() -> Self {
        Self {
            color: Vec3::ONE,
            metallic: 1.0,
            roughness: 1.0,
            specular: Vec3::splat(0.04),
            emission: Vec3::ZERO,
            transmission: 0.0,
            ior: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            normal_scale: Vec2::ONE,
            occlusion_texture: None,
            occlusion_strength: 1.0,
            emission_texture: None,
        }
    }
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
            opacity: 1.0,
            alpha_blend: false,
            unlit: None,
            metallic_roughness: None,
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
pub enum TextureData {
    File(PathBuf),
    /// An encoded image (PNG, JPEG, …) that was inside another file.
    Bytes(Arc<[u8]>),
}

/// An image that is read when the scene is given to the library.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureSource {
    pub name: String,
    pub data: TextureData,
    /// The first row of the image lies at t = 0 (AFF, glTF); otherwise the last one does (OBJ).
    pub first_row_at_zero: bool,
    /// Along s and t.
    pub wrap: [Wrap; 2],
    pub filter: Filter,
    /// The texels lie on the sRGB curve; else they are linear.
    pub srgb: bool,
    /// From texture coordinates to those of the image.
    pub transform: Affine2,
}
