//! What the frame being assembled shows: instances, lights, camera, environment, rendering object.
//!
//! Instances are cleared when a frame starts, as the recording rule of the API says. Lights, camera, environment and rendering object
//! persist; but the first `use_light` after the start of a frame begins a new list of lights. So both habits work: naming
//! everything again in every frame, and naming it once.

use super::context::Context;
use super::error::{Error, Result};
use super::mesh_builder::MeshBuilder;
use super::shaders::no_shader;
use super::state::finite;
use crate::memory::Room;
use crate::scene::{Command, Instance, LightUse, Mask, Mesh, Motion, Name, Program, ShaderKind};
use glam::Affine3A;

/// The object that geometry drawn outside objects belongs to.
pub const IMMEDIATE_OBJECT: Name = 0xFFFF_FFFF;

fn of_immediate() -> Instance {
    Instance::new(IMMEDIATE_OBJECT, Affine3A::IDENTITY)
}

#[derive(Default)]
pub(super) struct FrameContent {
    instances: Vec<Instance>,
    pub lights: Vec<LightUse>,
    /// `lights` were named for a frame that has started.
    pub lights_are_old: bool,
    /// Chosen by use_camera; None is the camera of the helper calls.
    pub camera: Option<Name>,
    pub environment: Name,
    pub renderer: Name,
    pub clear_color: [f32; 4],
    /// Of the instances to come.
    pub instance_mask: Mask,
    /// Set by ambient_light.
    pub ambient: Option<[f32; 3]>,
    /// Objects deleted since they were instantiated; they go when the frame has started.
    deletions: Vec<Name>,
    /// The back-end knows [`IMMEDIATE_OBJECT`].
    immediate_defined: bool,
}

impl FrameContent {
    /// Adds an instance; room was reserved.
    pub fn push(&mut self, instance: Instance) {
        self.instances.push(instance);
    }

    /// Forgets the instances from number `count` on.
    pub fn truncate(&mut self, count: usize) {
        self.instances.truncate(count);
    }

    pub fn instance_count(&self) -> usize {
        self.instances.len()
    }

    pub fn reserve_instances(&mut self, count: usize) -> Result<()> {
        // Room for the immediate-mode object as well, so that starting the frame need not allocate.
        self.instances.try_reserve(count + 1)?;
        if self.instances.len() + count >= u32::MAX as usize - 1 {
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
        self.lights.retain(|light| light.shader != name);
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
    /// Begins a new frame without rendering the one that was being assembled: its instances are dropped, and what was drawn outside objects.
    /// Lights, camera and all that persists from frame to frame stay. For programs that ask rays and render nothing: place, commit, ask, clear.
    ///
    /// # Errors
    /// `InvalidOperation` between begin and end or inside an object definition.
    pub fn clear_instances(&mut self) -> Result<()> {
        self.outside_object()?;
        self.backend.reserve(self.content.deletions.len())?;
        self.content.instances.clear();
        self.content.lights_are_old = true;
        self.builder = MeshBuilder::default();
        self.send_deletions();
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

    /// Lets a light shader shine in the frame being assembled and those after it, until a later frame names lights of its own. Its position, direction,
    /// and the edges of an area are transformed by the current matrix, as OpenGL does with `glLightfv(GL_POSITION)`; a sphere keeps its shape
    /// and its volume changes as the matrix says. A shader may be used several times in a frame, each time with another matrix.
    /// Name 0 takes all lights away.
    ///
    /// # Errors
    /// `InvalidValue` when there is no such shader, or the matrix has an element beyond [`super::MAX_COORDINATE`]; `InvalidOperation` when the shader is
    /// not a light, is used in this frame already with the same matrix, the current matrix is not affine, or, for a light program of the
    /// application's, it has no inverse.
    pub fn use_light(&mut self, shader: Name) -> Result<()> {
        self.outside_begin()?;
        if shader == 0 {
            self.content.lights.clear();
            self.content.lights_are_old = false;
            return Ok(());
        }
        self.expect_kind(shader, ShaderKind::Light, "not a light")?;
        let light = LightUse::new(shader, self.matrices.affine()?);
        let is_program = self.shaders.get(shader).is_some_and(|s| matches!(s.class.program, Program::Light(_)));
        if is_program && !light.world_from_light.inverse().is_finite() {
            return Err(Error::invalid_operation(format_args!(
                "the current matrix has no inverse, which light {shader} needs: it is a function of the application's"
            )));
        }
        if !self.content.lights_are_old && self.content.lights.contains(&light) {
            return Err(Error::invalid_operation(format_args!(
                "light {shader} is used in this frame already, with this matrix"
            )));
        }
        self.content.lights.try_reserve(1)?;
        if std::mem::take(&mut self.content.lights_are_old) {
            self.content.lights.clear();
        }
        self.content.lights.push(light);
        Ok(())
    }

    /// Sets the light that comes from everywhere, as OpenGL's `GL_LIGHT_MODEL_AMBIENT`: a surface reflects its `ambient` share of it, and of the lights
    /// of class `ambient`. Before the first call it is 0.2 in frames without such lights, and only surfaces whose `ambient` was set reflect it.
    /// Linear RGB, not clamped.
    ///
    /// # Errors
    /// `InvalidValue` for NaN or infinity, `InvalidOperation` between begin and end.
    pub fn ambient_light(&mut self, rgb: [f32; 3]) -> Result<()> {
        self.outside_begin()?;
        finite("the colour", &rgb)?;
        self.content.ambient = Some(rgb);
        Ok(())
    }

    /// Selects a camera shader; 0 goes back to the camera of `perspective`, `look_at` and their like.
    ///
    /// # Errors
    /// `InvalidValue` when there is no such shader, `InvalidOperation` when it is not a camera.
    pub fn use_camera(&mut self, shader: Name) -> Result<()> {
        self.outside_begin()?;
        if shader != 0 {
            self.expect_kind(shader, ShaderKind::Camera, "not a camera")?;
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
            self.expect_kind(shader, ShaderKind::Environment, "not an environment")?;
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
        finite("the colour", &rgba)?;
        self.content.clear_color = rgba;
        Ok(())
    }

    fn expect_kind(&self, shader: Name, kind: ShaderKind, otherwise: &'static str) -> Result<()> {
        let Some(state) = self.shaders.get(shader) else {
            return Err(no_shader(shader));
        };
        if state.class.kind == kind {
            return Ok(());
        }
        let class = &state.class.name;
        Err(Error::invalid_operation(format_args!("shader {shader}, of class \"{class}\", is {otherwise}")))
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
            self.backend.send(Command::DeleteObject { name: IMMEDIATE_OBJECT });
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

    /// After a frame has started or was given up: what was deleted while it was assembled may go. Room was reserved.
    pub(super) fn send_deletions(&mut self) {
        for name in self.content.deletions.drain(..) {
            self.composites.set(name, Vec::new());
            self.backend.send(Command::DeleteObject { name });
        }
    }
}
