//! Changes of the retained scene as plain data.
//!
//! The state machine validates, then sends commands; the back-end applies them in order when a frame starts.
//! A command that was sent is always valid: applying one cannot fail.

use super::changes::{overwrite, scatter};
use super::key_frame;
use super::{
    Instance, KeyFrame, LazyShape, Mask, Mesh, Motion, Name, Object, ParamValue, Scene, Shader, ShaderClass, Strategy,
    Texture,
};
use crate::memory::{OutOfMemory, Room};
use glam::Vec3;
use std::sync::Arc;

pub enum Command {
    DefineObject {
        name: Name,
        mesh: Mesh,
        motion: Motion,
    },
    /// Makes an object a composite. One that is defined anew has no children.
    SetChildren {
        name: Name,
        children: Vec<Instance>,
    },
    SetStrategy {
        name: Name,
        strategy: Strategy,
    },
    SetMotion {
        name: Name,
        motion: Motion,
    },
    SetSpatialSplits {
        name: Name,
        wanted: bool,
    },
    SetMask {
        name: Name,
        mask: Mask,
    },
    /// New positions for vertices `first..first + positions.len()`; the topology stays.
    UpdatePositions {
        name: Name,
        first: u32,
        positions: Vec<Vec3>,
    },
    /// New positions for the vertices listed; the topology stays.
    MovePositions {
        name: Name,
        vertices: Vec<u32>,
        positions: Vec<Vec3>,
    },
    SetLazyShape {
        name: Name,
        shape: LazyShape,
    },
    /// A tree is to be built for these positions of all vertices; one for the same time is replaced. An object defined anew has none.
    SetKeyFrame {
        name: Name,
        time: f32,
        positions: Vec<Vec3>,
    },
    DeleteKeyFrames {
        name: Name,
    },
    /// Chooses among the trees for key frames.
    SetTime {
        name: Name,
        time: f32,
    },
    UpdateNormals {
        name: Name,
        first: u32,
        normals: Vec<Vec3>,
    },
    /// New normals for the vertices listed.
    MoveNormals {
        name: Name,
        vertices: Vec<u32>,
        normals: Vec<Vec3>,
    },
    DeleteObject {
        name: Name,
    },
    DefineClass {
        name: Name,
        class: Arc<ShaderClass>,
    },
    DefineShader {
        name: Name,
        class: Name,
    },
    SetParameter {
        shader: Name,
        param: u32,
        value: ParamValue,
    },
    DeleteShader {
        name: Name,
    },
    DefineTexture {
        name: Name,
        texture: Arc<Texture>,
    },
    DeleteTexture {
        name: Name,
    },
}

impl Scene {
    /// Gets the memory that [`Scene::apply`] takes, but for tables of classes, shaders and textures. An object that is not there is there
    /// afterwards, without triangles.
    ///
    /// # Errors
    /// No memory.
    pub(super) fn prepare(&mut self, command: &Command) -> Result<(), OutOfMemory> {
        match command {
            Command::DefineObject { name, .. }
            | Command::SetChildren { name, .. }
            | Command::SetStrategy { name, .. }
            | Command::SetMotion { name, .. }
            | Command::SetSpatialSplits { name, .. }
            | Command::SetMask { name, .. }
            | Command::SetLazyShape { name, .. }
            | Command::SetTime { name, .. }
                if !self.objects.contains_key(name) =>
            {
                self.objects.room(1)?;
                self.objects.insert(*name, Object::default());
            }
            Command::UpdatePositions { name, .. }
            | Command::MovePositions { name, .. }
            | Command::UpdateNormals { name, .. }
            | Command::MoveNormals { name, .. } => {
                // A snapshot has it, too. What is written to is a copy.
                if let Some(object) = self.objects.get_mut(name)
                    && Arc::strong_count(&object.mesh) > 1
                {
                    object.mesh = Arc::new(object.mesh.try_clone()?);
                }
            }
            Command::SetKeyFrame { name, .. } => {
                if let Some(object) = self.objects.get_mut(name) {
                    object.keys.room(1)?;
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// Applies one command. Names that do not exist are ignored: the sender has validated them, and a
    /// deletion may have overtaken a change.
    ///
    /// Versions are epochs: an object that is deleted and defined again under the same name never repeats one.
    pub fn apply(&mut self, command: Command) {
        self.epoch += 1;
        match command {
            Command::DefineObject { name, mesh, motion } => {
                let object = self.objects.entry(name).or_default();
                // Not a count of its own: an object deleted and defined again must not look like the one before.
                object.topology_version = self.epoch;
                object.moves.all(self.epoch);
                object.keys.clear();
                object.keys_version = self.epoch;
                object.mesh = Arc::new(mesh);
                object.motion = motion;
                self.composites -= usize::from(!std::mem::take(&mut object.children).is_empty());
            }
            Command::SetChildren { name, children } => {
                let object = self.objects.entry(name).or_default();
                self.composites += usize::from(!children.is_empty());
                self.composites -= usize::from(!object.children.is_empty());
                object.children = children;
            }
            Command::SetStrategy { name, strategy } => {
                self.objects.entry(name).or_default().strategy = strategy;
            }
            Command::SetMotion { name, motion } => {
                self.objects.entry(name).or_default().motion = motion;
            }
            Command::SetSpatialSplits { name, wanted } => {
                self.objects.entry(name).or_default().spatial_splits = wanted;
            }
            Command::SetMask { name, mask } => {
                self.objects.entry(name).or_default().mask = mask;
            }
            Command::UpdatePositions { name, first, mut positions } => {
                if let Some(object) = self.objects.get_mut(&name) {
                    let of = object.mesh.positions.len();
                    object.moves.range(self.epoch, first..first.saturating_add(positions.len() as u32), of);
                    overwrite(&mut Arc::make_mut(&mut object.mesh).positions, first, &mut positions);
                    object.vertex_version = self.epoch;
                }
            }
            Command::MovePositions { name, vertices, positions } => {
                if let Some(object) = self.objects.get_mut(&name) {
                    let target = &mut Arc::make_mut(&mut object.mesh).positions;
                    let of = target.len();
                    scatter(target, &vertices, &positions);
                    object.moves.listed(self.epoch, &vertices, of);
                    object.vertex_version = self.epoch;
                }
            }
            Command::SetLazyShape { name, shape } => {
                self.objects.entry(name).or_default().lazy = shape;
            }
            Command::SetKeyFrame { name, time, positions } => {
                if let Some(object) = self.objects.get_mut(&name).filter(|o| o.mesh.positions.len() == positions.len())
                {
                    key_frame::insert(&mut object.keys, KeyFrame { time, positions, version: self.epoch });
                    object.keys_version = self.epoch;
                }
            }
            Command::DeleteKeyFrames { name } => {
                if let Some(object) = self.objects.get_mut(&name) {
                    object.keys.clear();
                    object.keys_version = self.epoch;
                }
            }
            Command::SetTime { name, time } => {
                self.objects.entry(name).or_default().time = time;
            }
            Command::UpdateNormals { name, first, mut normals } => {
                if let Some(object) = self.objects.get_mut(&name) {
                    overwrite(&mut Arc::make_mut(&mut object.mesh).normals, first, &mut normals);
                }
            }
            Command::MoveNormals { name, vertices, normals } => {
                if let Some(object) = self.objects.get_mut(&name) {
                    scatter(&mut Arc::make_mut(&mut object.mesh).normals, &vertices, &normals);
                }
            }
            Command::DeleteObject { name } => {
                if let Some(object) = self.objects.remove(&name) {
                    self.composites -= usize::from(!object.children.is_empty());
                }
            }
            Command::DefineClass { name, class } => {
                self.classes.insert(name, class);
            }
            Command::DefineShader { name, class } => {
                if let Some(class) = self.classes.get(&class) {
                    self.shaders.insert(name, Shader::new(class.clone(), self.epoch));
                }
            }
            Command::SetParameter { shader, param, value } => {
                if let Some(shader) = self.shaders.get_mut(&shader) {
                    shader.set(param, value, self.epoch);
                }
            }
            Command::DeleteShader { name } => {
                self.shaders.remove(&name);
            }
            Command::DefineTexture { name, texture } => {
                self.textures.insert(name, texture);
            }
            Command::DeleteTexture { name } => {
                self.textures.remove(&name);
            }
        }
    }
}
