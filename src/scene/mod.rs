//! Retained definitions: what the application has told us, before any ray is traced.
//!
//! A [`Scene`] is plain data changed only by [`Command`]s. The engine looks at the version counters of an
//! [`Object`] to learn what changed since the frame before; it never gets a callback. Everything here is
//! free of `unsafe`, of threads and of rays, so that a command log can also be sent over a wire or replayed.
#![forbid(unsafe_code)]

mod changes;
mod command;
mod composite;
mod frame_desc;
mod key_frame;
mod mask;
mod mesh;
mod moves;
mod name_map;
mod object;
mod program;
mod shader;
mod texture;
mod top_level;
mod upsampling;

pub use changes::Changes;
pub use command::Command;
pub use composite::{InstanceList, Resolved, TooMany};
pub use frame_desc::{DEFAULT_AMBIENT, FrameDesc, Instance, LightUse, Viewport};
pub use key_frame::KeyFrame;
pub use mask::Mask;
pub use mesh::{MAX_COORDINATE, Mesh, ParamStream};
pub use moves::Moves;
pub use name_map::NameMap;
pub use object::{LazyShape, Motion, Object, Strategy};
pub use program::{
    CameraShader, EnvironmentShader, LightSample, LightShader, PrimaryRay, Program, ShadingContext, SurfacePoint,
    SurfaceShader,
};
pub use shader::{ParamDef, ParamScope, ParamType, ParamValue, Shader, ShaderClass, ShaderKind};
pub use texture::{Filter, Texture, TextureFormat, TextureLevel, Wrap};
pub use top_level::TopLevelKind;
pub use upsampling::Upsampling;

use crate::memory::{OutOfMemory, Room};
use std::collections::HashMap;
use std::sync::Arc;

/// Integer names as in OpenGL; 0 is never an object.
pub type Name = u32;

/// Everything that persists between frames.
#[derive(Default)]
pub struct Scene {
    pub objects: HashMap<Name, Object>,
    pub classes: HashMap<Name, Arc<ShaderClass>>,
    pub shaders: HashMap<Name, Shader>,
    pub textures: HashMap<Name, Arc<Texture>>,
    /// Counts every applied command except a frame; two equal values mean an unchanged scene.
    pub epoch: u64,
    /// Objects that have children.
    composites: usize,
}

impl Scene {
    /// The same scene once more, which shares meshes, classes and textures with this one.
    ///
    /// # Errors
    /// No memory.
    pub fn copied(&self) -> Result<Self, OutOfMemory> {
        fn map<T: Clone>(from: &HashMap<Name, T>) -> Result<HashMap<Name, T>, OutOfMemory> {
            let mut to = HashMap::new();
            to.room(from.len())?;
            to.extend(from.iter().map(|(&name, value)| (name, value.clone())));
            Ok(to)
        }
        Ok(Self {
            objects: map(&self.objects)?,
            classes: map(&self.classes)?,
            shaders: map(&self.shaders)?,
            textures: map(&self.textures)?,
            epoch: self.epoch,
            composites: self.composites,
        })
    }

    fn is_composite(&self, object: Name) -> bool {
        self.objects.get(&object).is_some_and(|object| !object.children.is_empty())
    }
}
