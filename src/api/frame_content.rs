//! What the frame being assembled shows: instances, lights, camera, environment, rendering object.
//!
//! Instances are cleared when a frame starts, as the recording rule of the API says. Lights, camera, environment and rendering object
//! persist; but the first `use_light` after the start of a frame begins a new list of lights. So both habits work: naming
//! everything again in every frame, and naming it once.

use super::context::Context;
use super::error::{Error, Result};
use crate::memory::Room;
use crate::scene::{Command, Instance, Mask, Mesh, Motion, Name, ShaderKind};
use glam::Affine3A;

/// The object that geometry drawn outside objects belongs to.
pub const IMMEDIATE_OBJECT: Name = 0xFFFF_FFFF;

fn of_immediate() -> Instance {
    Instance::new(IMMEDIATE_OBJECT, Affine3A::IDENTITY)
}

#[derive(Default)]
pub(super) struct FrameContent {
    instances: Vec<Instance>,
    pub lights: Vec<Name>,
    /// `lights` were named for a frame that has started.
    pub lights_are_old: bool,
    /// Chosen by use_camera; None is the camera of the helper calls.
    pub camera: Option<Name>,
    pub environment: Name,
    pub renderer: Name,
    pub clear_color: [f32; 4],
    /// Of the instances to come.
    pub instance_mask: Mask,
    /// Objects deleted since they were instantiated; they go when the frame has started.
    deletions: Vec<Name>,
    /// The back-end knows [`IMMEDIATE_OBJECT`].
    immediate_defined: bool,
}

impl FrameContent {
    pub fn instance_count(&self) -> usize {
        self.instances.len()
    }

    pub fn reserve_instance(&mut self) -> Result<()> {
        // Room for the immediate-mode object as well, so that starting the frame need not allocate.
        self.instances.try_reserve(2)?;
        if self.instances.len() > u32::MAX as usize - 2 {
            return Err(Error::out_of_memory());
        }
        Ok(())
    }

    pub fn reserve_deletions(&mut self, n: usize) -> Result<()> {
        Ok(self.deletions.try_reserve(n)?)
    }

    pub fn delete_after_start(&mut self, name: Name) {
        self.deletions.push(name);
    }

    /// The name lives again before the frame that still shows the deleted object has started.
    pub fn undelete(&mut self, name: Name) {
        self.deletions.retain(|&n| n != name);
    }

    /// Takes a shader that is being deleted out of the frame.
    pub fn forget_shader(&mut self, name: Name) {
        self.lights.retain(|&n| n != name);
        if self.camera == Some(name) {
            self.camera = None;
        }
        for slot in [&mut self.environment, &mut self.renderer] {
            if *slot == name {
                *slot = 0;
            }
        }
    }
}

impl Context {
    /// Places an object with the current matrix in the frame being assembled. Several hundred thousand instances are fine.
    ///
    /// # Errors
    /// `InvalidValue` when there is no such object; `InvalidOperation` between begin and end, inside an object definition, or
    /// when the current matrix is not affine (bottom row 0 0 0 1).
    pub fn instantiate_object(&mut self, name: Name) -> Result<()> {
        self.outside_object()?;
        self.known_object(name)?;
        let world_from_object = self.matrices.affine()?;
        self.content.reserve_instance()?;
        self.place(name, world_from_object);
        Ok(())
    }

    /// Which rays see the instances placed from now on: those whose mask has a bit in common with this one and with the object's
    /// ([`super::ObjectParameter::Mask`]). All at first; it stays from frame to frame.
    ///
    /// # Errors
    /// `InvalidOperation` between begin and end.
    pub fn instance_mask(&mut self, mask: Mask) -> Result<()> {
        self.outside_begin()?;
        self.content.instance_mask = mask;
        Ok(())
    }

    /// Adds an instance; room was reserved.
    pub(super) fn place(&mut self, object: Name, world_from_object: Affine3A) {
        self.content.instances.push(Instance { object, world_from_object, mask: self.content.instance_mask });
        let this_frame = self.frames + 1;
        if let Some(info) = self.objects.get_mut(&object) {
            info.used_in_frame = this_frame;
        }
    }

    /// Lets a light shader shine in the frame being assembled and those after it, until a later frame names lights of its own.
    /// Name 0 takes all lights away.
    ///
    /// # Errors
    /// `InvalidValue` when there is no such shader; `InvalidOperation` when it is not a light, or already used in this frame.
    pub fn use_light(&mut self, shader: Name) -> Result<()> {
        self.outside_begin()?;
        if shader == 0 {
            self.content.lights.clear();
            self.content.lights_are_old = false;
            return Ok(());
        }
        self.expect_kind(shader, ShaderKind::Light, "not a light shader")?;
        if !self.content.lights_are_old && self.content.lights.contains(&shader) {
            return Err(Error::invalid_operation("the light is already used in this frame"));
        }
        self.content.lights.try_reserve(1)?;
        if std::mem::take(&mut self.content.lights_are_old) {
            self.content.lights.clear();
        }
        self.content.lights.push(shader);
        Ok(())
    }

    /// Selects a camera shader; 0 goes back to the camera of `perspective`, `look_at` and their like.
    ///
    /// # Errors
    /// `InvalidValue` when there is no such shader, `InvalidOperation` when it is not a camera.
    pub fn use_camera(&mut self, shader: Name) -> Result<()> {
        self.outside_begin()?;
        if shader != 0 {
            self.expect_kind(shader, ShaderKind::Camera, "not a camera shader")?;
        }
        self.content.camera = (shader != 0).then_some(shader);
        Ok(())
    }

    /// Selects the shader that rays see which leave the scene; 0 is the clear colour.
    ///
    /// # Errors
    /// As [`Context::use_camera`].
    pub fn use_environment_shader(&mut self, shader: Name) -> Result<()> {
        self.outside_begin()?;
        if shader != 0 {
            self.expect_kind(shader, ShaderKind::Environment, "not an environment shader")?;
        }
        self.content.environment = shader;
        Ok(())
    }

    /// Selects the algorithm that drives the rays; 0 is `whitted`.
    ///
    /// # Errors
    /// As [`Context::use_camera`].
    pub fn use_rendering_object(&mut self, shader: Name) -> Result<()> {
        self.outside_begin()?;
        if shader != 0 {
            self.expect_kind(shader, ShaderKind::Renderer, "not a rendering object")?;
        }
        self.content.renderer = shader;
        Ok(())
    }

    /// Sets the linear RGBA of rays that leave the scene when there is no environment shader. It is not clamped.
    ///
    /// # Errors
    /// `InvalidValue` for NaN or infinity.
    pub fn clear_color(&mut self, rgba: [f32; 4]) -> Result<()> {
        self.outside_begin()?;
        if !rgba.iter().all(|c| c.is_finite()) {
            return Err(Error::invalid_value("the clear colour is not finite"));
        }
        self.content.clear_color = rgba;
        Ok(())
    }

    fn expect_kind(&self, shader: Name, kind: ShaderKind, otherwise: &'static str) -> Result<()> {
        let Some(state) = self.shaders.get(shader) else {
            return Err(Error::invalid_value("there is no such shader"));
        };
        if state.class.kind == kind { Ok(()) } else { Err(Error::invalid_operation(otherwise)) }
    }

    /// Room for what [`Context::send_immediate_object`] and the end of the frame's assembly will send and store.
    pub(super) fn reserve_content(&mut self) -> Result<()> {
        self.builder.finish()?;
        self.backend.reserve(2 + self.content.deletions.len())?;
        Ok(self.content.instances.try_reserve(1)?)
    }

    /// Defines what was drawn outside objects as one object, or takes back that of the frame before. Whether there is one.
    pub(super) fn send_immediate_object(&mut self, mesh: Mesh) -> bool {
        let drawn = !mesh.triangles.is_empty();
        if drawn {
            let motion = Motion::Unstructured;
            self.backend.send(Command::DefineObject { name: IMMEDIATE_OBJECT, mesh, motion });
        } else if self.content.immediate_defined {
            self.backend.send(Command::DeleteObjects { first: IMMEDIATE_OBJECT, count: 1 });
        }
        self.content.immediate_defined = drawn;
        drawn
    }

    /// The instances of the frame, that of the immediate-mode object last; room was reserved. Those of the next one get the memory of `spare`.
    pub(super) fn take_instances(&mut self, with_immediate: bool, spare: Vec<Instance>) -> Vec<Instance> {
        let mut instances = std::mem::replace(&mut self.content.instances, spare);
        instances.extend(with_immediate.then(of_immediate));
        instances
    }

    /// The same without clearing, for a commit in mid-frame.
    pub(super) fn copy_instances(&self, to: &mut Vec<Instance>, with_immediate: bool) -> Result<()> {
        to.room(self.content.instances.len() + 1)?;
        to.extend_from_slice(&self.content.instances);
        to.extend(with_immediate.then(of_immediate));
        Ok(())
    }

    /// After a frame has started: what was deleted while it was assembled may go.
    pub(super) fn send_deletions(&mut self) {
        for name in self.content.deletions.drain(..) {
            self.backend.send(Command::DeleteObjects { first: name, count: 1 });
        }
    }
}
