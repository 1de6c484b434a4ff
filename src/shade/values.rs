//! Typed reading of a shader's parameters by name, at frame start.

use crate::scene::{Name, ParamValue, Shader};
use glam::{Vec3, Vec4};

/// The values of one shader. A parameter of another type is converted where that makes sense; one that is
/// missing (a class of the same name that is not ours) reads as 0.
#[derive(Clone, Copy)]
pub struct Values<'a>(pub &'a Shader);

impl Values<'_> {
    pub fn vec4(&self, name: &str) -> Vec4 {
        match self.0.value(name) {
            Some(ParamValue::Float(v)) => Vec4::from_array(*v),
            Some(ParamValue::Int(v)) => Vec4::from_array(v.map(|i| i as f32)),
            _ => Vec4::ZERO,
        }
    }

    pub fn vec3(&self, name: &str) -> Vec3 {
        self.vec4(name).truncate()
    }

    pub fn float(&self, name: &str) -> f32 {
        self.vec4(name).x
    }

    pub fn int(&self, name: &str) -> i32 {
        match self.0.value(name) {
            Some(ParamValue::Int(v)) => v[0],
            // `as` saturates, and turns NaN into 0.
            Some(ParamValue::Float(v)) => v[0] as i32,
            _ => 0,
        }
    }

    /// A count that is at least 1 and at most `limit`.
    pub fn count(&self, name: &str, limit: u32) -> u32 {
        (self.int(name).max(1) as u32).min(limit)
    }

    pub fn texture(&self, name: &str) -> Name {
        match self.0.value(name) {
            Some(ParamValue::Texture(texture)) => *texture,
            Some(ParamValue::Int(v)) => v[0].max(0) as Name,
            _ => 0,
        }
    }

    pub fn string(&self, name: &str) -> &str {
        match self.0.value(name) {
            Some(ParamValue::String(text)) => text,
            _ => "",
        }
    }
}
