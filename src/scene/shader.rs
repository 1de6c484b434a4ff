//! Shader classes, shader instances and their late-bound parameters.
//!
//! A class names its parameters once; a shader holds one value per parameter. What a value means is decided
//! when a frame starts (`openrt_api.md` §3.2: geometry → shader is bound early, shader → values late).

use super::{Name, Program};
use std::sync::Arc;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ShaderKind {
    Surface,
    Light,
    Camera,
    Environment,
    /// Rendering object: the algorithm that turns pixels into rays.
    Renderer,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParamType {
    /// 1 to 4 integers.
    Int(u8),
    /// 1 to 4 floats.
    Float(u8),
    /// Column-major 4×4.
    Matrix,
    String,
    /// Name of a texture object.
    Texture,
    /// A fixed number of bytes.
    Raw(u32),
}

/// Where a parameter's value comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParamScope {
    /// One value per shader, read when the frame starts.
    Shader,
    /// Captured when a triangle is completed.
    Triangle,
    /// Captured at each vertex and interpolated.
    Vertex,
}

#[derive(Clone, Debug, PartialEq)]
pub enum ParamValue {
    /// Unused components are 0.
    Int([i32; 4]),
    /// Unused components are 0.
    Float([f32; 4]),
    Matrix([f32; 16]),
    String(Arc<str>),
    /// 0 is no texture.
    Texture(Name),
    Raw(Arc<[u8]>),
}

#[derive(Clone, Debug)]
pub struct ParamDef {
    pub name: Arc<str>,
    pub ty: ParamType,
    pub scope: ParamScope,
    pub default: ParamValue,
    /// The texts that a string parameter can be; it can be anything if there are none.
    pub choices: &'static [&'static str],
    /// Byte offset in the parameter block that a user's shader function is given; 0 for built-in classes.
    pub offset: u32,
}

/// What `rtGenNewShaderClass` or `rtRegisterShaderClass` names.
pub struct ShaderClass {
    pub name: Arc<str>,
    pub kind: ShaderKind,
    pub params: Vec<ParamDef>,
    /// Bytes of the parameter block of a user's class; 0 for built-in classes.
    pub block_size: u32,
    pub program: Program,
}

impl ShaderClass {
    /// Index of the parameter called `name`.
    pub fn param_index(&self, name: &str) -> Option<u32> {
        self.params.iter().position(|p| &*p.name == name).map(|i| i as u32)
    }
}

/// A shader instance: a class and one value per parameter of the class.
#[derive(Clone)]
pub struct Shader {
    pub class: Arc<ShaderClass>,
    pub values: Vec<ParamValue>,
    /// Whether each of them was set, if only to its default.
    pub given: Vec<bool>,
    /// The epoch of the last change; no two shaders share one.
    pub version: u64,
}

impl Shader {
    /// A shader with the default values of its class.
    pub fn new(class: Arc<ShaderClass>, version: u64) -> Self {
        let values = class.params.iter().map(|p| p.default.clone()).collect();
        let given = vec![false; class.params.len()];
        Self { class, values, given, version }
    }

    /// Sets parameter number `param`, if the class has so many, in epoch `version`.
    pub fn set(&mut self, param: u32, value: ParamValue, version: u64) {
        if let Some(slot) = self.values.get_mut(param as usize) {
            *slot = value;
            self.given[param as usize] = true;
            self.version = version;
        }
    }

    /// Whether the parameter called `name` was set.
    pub fn is_given(&self, name: &str) -> bool {
        self.class.param_index(name).is_some_and(|i| self.given[i as usize])
    }

    /// Value of the parameter called `name`, if the class has it.
    pub fn value(&self, name: &str) -> Option<&ParamValue> {
        self.class.param_index(name).map(|i| &self.values[i as usize])
    }
}
