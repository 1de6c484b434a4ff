//! The surface class `metallic_roughness`: the material of glTF 2.0 (appendix B of its specification), which most modelling
//! programs write.
//!
//! A point is a mixture of a metal, which reflects in its base colour, and of a dielectric, which reflects `specular` and
//! scatters the rest in its base colour; both by one GGX lobe ([`ggx`]). How lights and surroundings are gathered is in
//! [`shading`]. Textures multiply: base colour and alpha, roughness (green) and metal (blue), emission, occlusion (red), and
//! normals in the space of the texture coordinates.

mod ggx;
mod shading;

use crate::shade::alpha::Alpha;
use crate::shade::interaction::Interaction;
use crate::shade::surface::{TextureId, positive_or_one};
use crate::shade::textures::Textures;
use crate::shade::values::Values;
use glam::{Vec2, Vec3, Vec4Swizzles};

pub struct MetallicRoughness {
    color: Vec3,
    /// Ambient light that a white surface reflects, see [`Surface::reflect_ambient`](crate::shade::surface::Surface).
    pub ambient: Vec3,
    metallic: f32,
    roughness: f32,
    /// Reflectance of the dielectric at normal incidence.
    specular: Vec3,
    emission: Vec3,
    pub transmission: f32,
    ior: f32,
    pub alpha: Alpha,
    texture: TextureId,
    metallic_roughness_texture: TextureId,
    normal_texture: TextureId,
    normal_scale: Vec2,
    occlusion_texture: TextureId,
    occlusion_strength: f32,
    emission_texture: TextureId,
}

/// The material at one point.
struct Mixture {
    /// Of the scattered light.
    diffuse: Vec3,
    /// Reflectance at normal incidence.
    f0: Vec3,
    roughness: f32,
    /// Colour of what passes through.
    transmission: Vec3,
    /// Ambient light that is reflected.
    ambient: Vec3,
    /// Share of the surroundings that nothing near hides.
    open: f32,
}

impl MetallicRoughness {
    pub fn new(values: Values, textures: &Textures) -> Self {
        let texture = |name: &str| textures.id(values.texture(name));
        let unit = |name: &str| values.float(name).clamp(0.0, 1.0);
        Self {
            color: values.vec3("color"),
            ambient: values.vec3("ambient"),
            metallic: unit("metallic"),
            roughness: unit("roughness"),
            specular: values.vec3("specular").clamp(Vec3::ZERO, Vec3::ONE),
            emission: values.vec3("emission"),
            transmission: unit("transmission"),
            ior: positive_or_one(values.float("ior")),
            alpha: Alpha::new(values, textures),
            texture: texture("texture"),
            metallic_roughness_texture: texture("metallic_roughness_texture"),
            normal_texture: texture("normal_texture"),
            normal_scale: values.vec3("normal_scale").truncate(),
            occlusion_texture: texture("occlusion_texture"),
            occlusion_strength: unit("occlusion_strength"),
            emission_texture: texture("emission_texture"),
        }
    }

    /// Coverage of the point.
    pub fn coverage(&self, it: &Interaction, textures: &Textures) -> f32 {
        if self.alpha.is_opaque() {
            return 1.0;
        }
        let base = it.point.color.w * look(textures, self.texture, it).w;
        self.alpha.at(base, it, textures)
    }

    /// Share of light that passes a point that is there, for shadow rays.
    pub fn transmitted(&self, it: &Interaction, textures: &Textures) -> Vec3 {
        if self.transmission == 0.0 { Vec3::ZERO } else { self.mixture(it, textures).transmission }
    }

    /// Light that the surface itself sends.
    pub fn emitted(&self, it: &Interaction, textures: &Textures) -> Vec3 {
        if self.emission == Vec3::ZERO {
            return Vec3::ZERO;
        }
        self.emission * look(textures, self.emission_texture, it).xyz()
    }

    fn mixture(&self, it: &Interaction, textures: &Textures) -> Mixture {
        let base = self.color * it.point.color.xyz() * look(textures, self.texture, it).xyz();
        let rough_metal = look(textures, self.metallic_roughness_texture, it);
        let metallic = self.metallic * rough_metal.z;
        let scattered = base * (1.0 - metallic);
        let open = match self.occlusion_texture {
            Some(_) => 1.0 + self.occlusion_strength * (look(textures, self.occlusion_texture, it).x - 1.0),
            None => 1.0,
        };
        Mixture {
            diffuse: scattered * (1.0 - self.transmission),
            f0: self.specular.lerp(base, metallic),
            roughness: self.roughness * rough_metal.y,
            transmission: scattered * self.transmission,
            ambient: self.ambient * base * open,
            open,
        }
    }

    /// The point with the normal that the normal texture gives it.
    fn bumped<'a>(&self, it: &Interaction<'a>, textures: &Textures) -> Interaction<'a> {
        let normal = match (self.normal_texture, it.tangents()) {
            (Some(_), Some([along_s, along_t])) => {
                let texel = look(textures, self.normal_texture, it).xyz() * 2.0 - Vec3::ONE;
                let n = it.point.normal;
                let s = (along_s - n * n.dot(along_s)).normalize_or_zero();
                let t = n.cross(s);
                let t = if t.dot(along_t) < 0.0 { -t } else { t };
                // Seen from behind, all of the surface is turned about.
                let side = if it.point.back_facing { -1.0 } else { 1.0 };
                (s * (side * texel.x * self.normal_scale.x) + t * (side * texel.y * self.normal_scale.y) + n * texel.z)
                    .normalize_or(n)
            }
            _ => it.point.normal,
        };
        it.with_normal(normal)
    }
}

fn look(textures: &Textures, texture: TextureId, it: &Interaction) -> glam::Vec4 {
    textures.lookup(texture, it.point.tex_coord, || it.footprint())
}
