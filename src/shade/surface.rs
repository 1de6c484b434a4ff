//! Surfaces as compiled for one frame: plain data in a closed enum, so that shading a hit costs a `match` and no
//! virtual call.

use crate::scene::{Name, ShaderClass, SurfacePoint, SurfaceShader};
use crate::shade::alpha::Alpha;
use crate::shade::block::Block;
use crate::shade::interaction::Interaction;
use crate::shade::metallic_roughness::MetallicRoughness;
use crate::shade::optics::reflect;
use crate::shade::textures::Textures;
use crate::shade::values::Values;
use glam::{Vec3, Vec4, Vec4Swizzles};
use std::sync::Arc;

/// Index of a texture in the frame's [`Textures`]; None is white.
pub type TextureId = Option<u32>;

pub enum Surface {
    Constant {
        color: Vec3,
        texture: TextureId,
        alpha: Alpha,
    },
    /// `diffuse`, `phong` and `cutout`.
    Phong(Phong),
    Mirror {
        color: Vec3,
        texture: TextureId,
    },
    Glass {
        color: Vec3,
        ior: f32,
    },
    Metal {
        color: Vec3,
        exponent: Option<f32>,
        texture: TextureId,
    },
    EyeLight {
        color: Vec3,
        texture: TextureId,
    },
    MetallicRoughness(MetallicRoughness),
    Normals,
    Wireframe {
        color: Vec3,
        background: Vec3,
        thickness: f32,
    },
    User(UserSurface),
}

/// Phong's model with Whitted's mirror and refracted rays; see [`crate::shade::class`].
pub struct Phong {
    /// Ambient light that is reflected, see [`Surface::reflect_ambient`].
    pub ambient: Vec3,
    pub diffuse: Vec3,
    pub specular: Vec3,
    pub shininess: f32,
    pub reflection: Vec3,
    pub transmission: Vec3,
    pub ior: f32,
    pub emission: Vec3,
    pub texture: TextureId,
    pub alpha: Alpha,
}

pub struct UserSurface {
    pub program: Arc<dyn SurfaceShader>,
    pub block: Block,
    pub shader: Name,
    pub class: Arc<ShaderClass>,
}

impl Default for Surface {
    /// What triangles without a shader look like: grey and dull.
    fn default() -> Self {
        Surface::Phong(Phong { ambient: Vec3::splat(0.16), ..Phong::matte(Vec3::splat(0.8)) })
    }
}

impl Phong {
    fn matte(diffuse: Vec3) -> Self {
        Self {
            ambient: Vec3::ZERO,
            diffuse,
            specular: Vec3::ZERO,
            shininess: 1.0,
            reflection: Vec3::ZERO,
            transmission: Vec3::ZERO,
            ior: 1.0,
            emission: Vec3::ZERO,
            texture: None,
            alpha: Alpha::default(),
        }
    }

    /// Base colour factor in xyz, alpha after threshold and opacity in w.
    #[inline]
    pub fn base(&self, it: &Interaction, textures: &Textures) -> Vec4 {
        let base = it.point.color * textures.lookup(self.texture, it.point.tex_coord, || it.footprint());
        base.xyz().extend(self.alpha.at(base.w, it, textures))
    }

    /// Light of `radiance` from `direction`, reflected to the viewer: diffuse and in the highlight.
    #[inline]
    pub fn reflected(&self, base: Vec3, point: &SurfacePoint, direction: Vec3, radiance: Vec3) -> Vec3 {
        let mut color = self.diffuse * base * direction.dot(point.normal).max(0.0);
        if self.specular != Vec3::ZERO {
            let mirrored = reflect(point.incoming, point.normal);
            color += self.specular * direction.dot(mirrored).max(0.0).powf(self.shininess);
        }
        color * radiance
    }
}

impl Surface {
    /// The built-in surface `class`; None if there is none of that name.
    pub fn built_in(class: &str, values: Values, textures: &Textures) -> Option<Self> {
        let texture = || textures.id(values.texture("texture"));
        let color = || values.vec3("color");
        Some(match class {
            "constant" => Surface::Constant { color: color(), texture: texture(), alpha: Alpha::new(values, textures) },
            "diffuse" => {
                let matte = Phong::matte(color());
                Surface::Phong(Phong { ambient: values.vec3("ambient") * color(), texture: texture(), ..matte })
            }
            "cutout" => Surface::Phong(Phong {
                ambient: values.vec3("ambient") * color(),
                texture: texture(),
                alpha: Alpha { opacity: 1.0, ..Alpha::new(values, textures) },
                ..Phong::matte(color())
            }),
            "phong" => Surface::Phong(Phong {
                ambient: values.vec3("ambient"),
                diffuse: values.vec3("diffuse"),
                specular: values.vec3("specular"),
                shininess: values.float("shininess").max(0.0),
                reflection: values.vec3("reflection"),
                transmission: values.vec3("transmission"),
                ior: positive_or_one(values.float("ior")),
                emission: values.vec3("emission"),
                texture: texture(),
                alpha: Alpha::new(values, textures),
            }),
            "mirror" => Surface::Mirror { color: color(), texture: texture() },
            "glass" => Surface::Glass { color: color(), ior: positive_or_one(values.float("ior")) },
            "metal" => {
                let roughness = values.float("roughness").clamp(0.0, 1.0);
                // 2/r² − 2 maps 1 to a cosine-free lobe and small values to Blinn's highlights of slope r.
                let exponent = (roughness > 1e-3).then(|| 2.0 / (roughness * roughness) - 2.0);
                Surface::Metal { color: color(), exponent, texture: texture() }
            }
            "metallic_roughness" => Surface::MetallicRoughness(MetallicRoughness::new(values, textures)),
            "eyelight" => Surface::EyeLight { color: color(), texture: texture() },
            "normals" => Surface::Normals,
            "wireframe" => Surface::Wireframe {
                color: color(),
                background: values.vec3("background"),
                thickness: values.float("thickness"),
            },
            _ => return None,
        })
    }

    /// Makes the ambient share of a surface the light that it reflects, out of the `light` that comes from everywhere.
    pub fn reflect_ambient(&mut self, light: Vec3) {
        match self {
            Surface::Phong(phong) => phong.ambient *= light,
            Surface::MetallicRoughness(material) => material.ambient *= light,
            _ => {}
        }
    }

    /// Whether shadow rays may pass, somewhere.
    pub fn is_see_through(&self) -> bool {
        match self {
            Surface::Phong(p) => !p.alpha.is_opaque() || p.transmission != Vec3::ZERO,
            Surface::MetallicRoughness(m) => !m.alpha.is_opaque() || m.transmission > 0.0,
            Surface::Constant { alpha, .. } => !alpha.is_opaque(),
            Surface::Glass { .. } => true,
            _ => false,
        }
    }

    /// Whether the surface is not there at the point.
    pub fn is_hole(&self, it: &Interaction, textures: &Textures) -> bool {
        let may = match self {
            Surface::Phong(p) => p.alpha.has_holes(),
            Surface::MetallicRoughness(m) => m.alpha.has_holes(),
            Surface::Constant { alpha, .. } => alpha.has_holes(),
            _ => false,
        };
        may && self.coverage(it, textures) == 0.0
    }

    /// How much of what lies behind the point is hidden, without regard to transmission.
    pub fn coverage(&self, it: &Interaction, textures: &Textures) -> f32 {
        match self {
            Surface::Phong(p) => p.base(it, textures).w,
            Surface::MetallicRoughness(m) => m.coverage(it, textures),
            Surface::Constant { texture, alpha, .. } if !alpha.is_opaque() => {
                let texel = textures.lookup(*texture, it.point.tex_coord, || it.footprint());
                alpha.at(it.point.color.w * texel.w, it, textures)
            }
            _ => 1.0,
        }
    }

    /// Share of light that goes straight through, for shadow rays. Refracting surfaces let it pass undeflected:
    /// a lamp behind a window shines; caustics are left to the eye. A user's surfaces are opaque.
    pub fn transmittance(&self, it: &Interaction, textures: &Textures) -> Vec3 {
        let alpha = self.coverage(it, textures);
        let within = match self {
            Surface::Phong(p) => p.transmission,
            Surface::MetallicRoughness(m) => m.transmitted(it, textures),
            Surface::Glass { color, .. } => *color,
            _ => Vec3::ZERO,
        };
        Vec3::splat(1.0 - alpha) + within * alpha
    }
}

pub(super) fn positive_or_one(ior: f32) -> f32 {
    if ior > 0.0 && ior.is_finite() { ior } else { 1.0 }
}
