//! Changes of the retained scene as plain data.
//!
//! The state machine validates, then sends commands; the back-end applies them in order when a frame starts.
//! A command that was sent is always valid: applying one cannot fail.

use super::key_frame;
use super::{KeyFrame, LazyShape, Mask, Mesh, Motion, Name, ParamValue, Scene, Shader, ShaderClass, Strategy, Texture};
use glam::Vec3;
use std::sync::Arc;

pub enum Command {
    DefineObject {
        name: Name,
        mesh: Mesh,
        motion: Motion,
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
    DeleteObjects {
        first: Name,
        count: u32,
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
            Command::UpdatePositions { name, first, positions } => {
                if let Some(object) = self.objects.get_mut(&name) {
                    let of = object.mesh.positions.len();
                    object.moves.range(self.epoch, first..first.saturating_add(positions.len() as u32), of);
                    overwrite(&mut Arc::make_mut(&mut object.mesh).positions, first, positions);
                    object.vertex_version = self.epoch;
                }
            }
            Command::MovePositions { name, vertices, positions } => {
                if let Some(object) = self.objects.get_mut(&name) {
                    let target = &mut Arc::make_mut(&mut object.mesh).positions;
                    let of = target.len();
                    for (&vertex, position) in vertices.iter().zip(positions) {
                        if let Some(target) = target.get_mut(vertex as usize) {
                            *target = position;
                        }
                    }
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
            Command::UpdateNormals { name, first, normals } => {
                if let Some(object) = self.objects.get_mut(&name) {
                    overwrite(&mut Arc::make_mut(&mut object.mesh).normals, first, normals);
                }
            }
            Command::DeleteObjects { first, count } => {
                // The range is the caller's and may be huge; the table is not.
                let end = u64::from(first) + u64::from(count);
                self.objects.retain(|&name, _| name < first || u64::from(name) >= end);
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
                if let Some(shader) = self.shaders.get_mut(&shader)
                    && let Some(slot) = shader.values.get_mut(param as usize)
                {
                    *slot = value;
                    shader.version = self.epoch;
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

/// Puts `values` over `target[first..]`, as far as it reaches.
fn overwrite<T: Copy>(target: &mut Vec<T>, first: u32, values: Vec<T>) {
    if first == 0 && values.len() == target.len() {
        *target = values;
    } else if let Some(tail) = target.get_mut(first as usize..) {
        let n = tail.len().min(values.len());
        tail[..n].copy_from_slice(&values[..n]);
    }
}
