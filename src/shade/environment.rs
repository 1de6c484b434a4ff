//! What rays see that leave the scene.

use crate::scene::EnvironmentShader;
use crate::shade::block::Block;
use crate::shade::footprint::Cone;
use crate::shade::texture::CompiledTexture;
use crate::shade::values::Values;
use glam::{Vec2, Vec3, Vec4};
use std::f32::consts::{PI, TAU};
use std::sync::Arc;

pub enum Environment {
    /// The frame's clear colour, with its alpha.
    Clear(Vec4),
    Constant(Vec3),
    Gradient {
        bottom: Vec3,
        horizon: Vec3,
        top: Vec3,
        up: Vec3,
    },
    LatLong {
        texture: Option<CompiledTexture>,
        intensity: f32,
        rotation: f32,
    },
    User {
        program: Arc<dyn EnvironmentShader>,
        block: Block,
    },
}

impl Environment {
    /// The built-in environment `class`; None if there is none of that name.
    pub fn built_in(class: &str, values: Values, texture: impl Fn(u32) -> Option<CompiledTexture>) -> Option<Self> {
        Some(match class {
            "background" => Environment::Constant(values.vec3("color")),
            "gradient" => Environment::Gradient {
                bottom: values.vec3("bottom"),
                horizon: values.vec3("horizon"),
                top: values.vec3("top"),
                up: values.vec3("up").normalize_or(Vec3::Y),
            },
            "latlong" => Environment::LatLong {
                texture: texture(values.texture("texture")),
                intensity: values.float("intensity"),
                rotation: values.float("rotation") / 360.0,
            },
            _ => return None,
        })
    }

    /// Whether it is the same in all directions.
    pub fn is_uniform(&self) -> bool {
        matches!(self, Environment::Clear(_) | Environment::Constant(_))
    }

    /// Radiance against `direction` (unit length), and alpha.
    pub fn radiance(&self, direction: Vec3, cone: Cone) -> Vec4 {
        let color = match self {
            Environment::Clear(color) => return *color,
            Environment::Constant(color) => *color,
            Environment::Gradient { bottom, horizon, top, up } => {
                let height = direction.dot(*up);
                let end = if height < 0.0 { *bottom } else { *top };
                horizon.lerp(end, height.abs().min(1.0).sqrt())
            }
            Environment::LatLong { texture, intensity, rotation } => {
                let u = 0.5 + direction.x.atan2(-direction.z) / TAU + rotation;
                let v = 0.5 + direction.y.clamp(-1.0, 1.0).asin() / PI;
                // Beyond the last row of texels lies not the first one but the pole.
                let half_texel = texture.as_ref().map_or(0.0, |t| 0.5 / t.height() as f32);
                let v = v.clamp(half_texel, 1.0 - half_texel);
                // The cone's solid angle as a share of the picture's 2π × π.
                let footprint = cone.spread * cone.spread / (TAU * PI);
                let white = Vec4::ONE;
                texture.as_ref().map_or(white, |t| t.lookup(Vec2::new(u, v), footprint)).truncate() * *intensity
            }
            Environment::User { program, block } => program.radiance(block.bytes(), direction),
        };
        color.extend(1.0)
    }
}
