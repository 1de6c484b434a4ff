//! Objects: names, definition, deletion, moving vertices, parameters.

use super::composites::Composites;
use super::context::Context;
use super::error::{Error, ErrorCode, Result};
use super::mesh_builder::{MeshBuilder, try_copy};
use super::names::FIRST_RESERVED;
use super::state::finite;
use crate::scene::{Command, Instance, LazyShape, Mask, Motion, Name, Strategy};
use glam::Vec3;
use std::borrow::Cow;

/// What [`Context::end_object`] does besides storing the object.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Mode {
    #[default]
    Compile,
    /// One instance with the matrix current at `end_object`, in the frame being assembled.
    CompileAndInstantiate,
}

/// A settable property of an object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ObjectParameter {
    Strategy(Strategy),
    Motion(Motion),
    /// How the strategy `Lazy` cuts the tree; changing it builds the tree anew.
    LazyShape(LazyShape),
    /// Which of the key frames is the active one, see [`Context::key_frame`]; finite, 0 at first.
    Time(f32),
    /// Whether triangles may be cut at planes for a tree that is faster to trace, where triangles are long or of very different sizes, at several times the
    /// build time and up to half as much memory again. Has effect while the object is [`Motion::Static`] and its strategy
    /// [`Strategy::Auto`] or [`Strategy::Sah`]; kept, and without effect, otherwise. Does not change the picture.
    SpatialSplits(bool),
    /// Which rays see the object: those whose mask has a bit in common with it. All at first.
    Mask(Mask),
}

/// What an object is, for getters. A name that was generated and not defined has no triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ObjectInfo {
    pub motion: Motion,
    pub strategy: Strategy,
    pub lazy_shape: LazyShape,
    pub time: f32,
    pub spatial_splits: bool,
    pub mask: Mask,
    pub vertex_count: u32,
    pub triangle_count: u32,
    /// Instances of other objects that it holds.
    pub child_count: u32,
    /// Some vertex has a normal of its own.
    pub has_normals: bool,
    /// Times that the object was defined.
    pub definitions: u64,
    /// `Context::frames` + 1 of the frame that it was last instantiated for; 0 when never.
    pub(super) used_in_frame: u64,
}

/// The object between new_object and end_object.
pub(super) struct Definition {
    pub name: Name,
    pub mode: Mode,
    /// None keeps what the object has.
    pub motion: Option<Motion>,
    pub children: Vec<Instance>,
    /// What was drawn outside objects so far, put aside.
    pub outside: MeshBuilder,
}

impl Context {
    /// The first of `n` new consecutive names, each an empty object.
    ///
    /// # Errors
    /// `InvalidValue` for `n` < 1, `OutOfMemory` when there are not `n` consecutive names left.
    pub fn gen_objects(&mut self, n: i32) -> Result<Name> {
        self.outside_begin()?;
        let n = positive(n)?;
        self.object_names.generate(n).ok_or_else(|| no_names(n))
    }

    /// Begins the definition of object `name`, which need not have been generated; what it was before is replaced,
    /// for all its instances from the next frame on, when the definition ends.
    ///
    /// What [`Context::object_parameter`] has set stays, before the first definition and after it; `motion` None keeps the motion, too.
    ///
    /// Vertices get the matrix current at `vertex` baked in. The current normal starts unset, so an object that gives no normals
    /// is shaded flat; current colour, texture coordinate, shader and matrix stay what they are, and
    /// what the definition sets remains set after it. [`Context::instantiate_object`] makes other objects part of this one.
    ///
    /// # Errors
    /// `InvalidValue` for name 0 or one of the topmost 256, `InvalidOperation` inside another definition.
    pub fn new_object(&mut self, name: Name, mode: Mode, motion: impl Into<Option<Motion>>) -> Result<()> {
        self.outside_object()?;
        if name == 0 || name >= FIRST_RESERVED {
            return Err(Error::invalid_value(format_args!(
                "{name} is not a name for an object: these are 1 to {}",
                FIRST_RESERVED - 1
            )));
        }
        let outside = std::mem::take(&mut self.builder);
        let motion = motion.into();
        self.definition = Some(Definition { name, mode, motion, children: Vec::new(), outside });
        self.current.normal = None;
        Ok(())
    }

    /// Ends the definition.
    ///
    /// # Errors
    /// `InvalidOperation` without a definition, between begin and end, and with [`Mode::CompileAndInstantiate`] when the
    /// current matrix is not affine (the definition then stays open).
    pub fn end_object(&mut self) -> Result<()> {
        self.outside_begin()?;
        let Some(definition) = &self.definition else {
            return Err(Error::invalid_operation("no object is being defined"));
        };
        let (name, motion) = (definition.name, definition.motion);
        let placement = match definition.mode {
            Mode::Compile => None,
            Mode::CompileAndInstantiate => {
                self.content.reserve_instances(1)?;
                Some(self.matrices.affine()?)
            }
        };
        self.builder.finish()?;
        self.backend.reserve(2)?;
        self.objects.try_reserve(1)?;
        let held = Composites::held(&definition.children)?;
        self.composites.reserve()?;
        let is_shown = self.objects.get(&name).is_some_and(|info| info.used_in_frame == self.frames + 1);
        if is_shown || placement.is_some() {
            held.iter().try_for_each(|&child| self.mark_used(child))?;
        }
        // Nothing can fail from here on.
        let Some(Definition { children, outside, .. }) = self.definition.take() else { return Ok(()) };
        let mesh = std::mem::replace(&mut self.builder, outside).into_mesh();
        self.composites.set(name, held);
        self.object_names.claim(name);
        self.content.undelete(name);
        let info = self.objects.entry(name).or_default();
        info.motion = motion.unwrap_or(info.motion);
        let motion = info.motion;
        info.vertex_count = mesh.positions.len() as u32;
        info.triangle_count = mesh.triangles.len() as u32;
        info.child_count = children.len() as u32;
        info.has_normals = !mesh.normals.is_empty();
        info.definitions += 1;
        self.backend.send(Command::DefineObject { name, mesh, motion });
        if !children.is_empty() {
            self.backend.send(Command::SetChildren { name, children });
        }
        if let Some(world_from_object) = placement {
            self.place_defined(name, world_from_object);
        }
        Ok(())
    }

    /// Deletes the objects `first..first + n`; names that are not in use are ignored. Instances already placed in the frame
    /// being assembled, and frames in flight, still show them. Composites keep the name of a part that is deleted, and show nothing there until an object
    /// of this name is defined. Inside a definition the object being defined is not touched.
    ///
    /// # Errors
    /// `InvalidValue` for negative `n`.
    pub fn delete_objects(&mut self, first: Name, n: i32) -> Result<()> {
        self.outside_begin()?;
        let n =
            u32::try_from(n).map_err(|_| Error::invalid_value(format_args!("n is {n}; it must not be negative")))?;
        let end = first.saturating_add(n).min(FIRST_RESERVED);
        if first >= end {
            return Ok(());
        }
        // Each defined name is one command, so that those still shown by the frame in the making can wait.
        let this_frame = self.frames + 1;
        let mut doomed = Vec::new();
        if (end - first) as usize <= self.objects.len() {
            doomed.try_reserve((end - first) as usize)?;
            doomed.extend((first..end).filter(|name| self.objects.contains_key(name)));
        } else {
            doomed.try_reserve(self.objects.len())?;
            doomed.extend(self.objects.keys().copied().filter(|name| (first..end).contains(name)));
            doomed.sort_unstable();
        }
        self.backend.reserve(doomed.len())?;
        self.content.reserve_deletions(doomed.len())?;
        self.object_names.release(first, end);
        for name in doomed {
            let shown = self.objects.remove(&name).is_some_and(|info| info.used_in_frame == this_frame);
            if shown {
                self.content.delete_after_start(name);
            } else {
                self.composites.set(name, Vec::new());
                self.backend.send(Command::DeleteObject { name });
            }
        }
        Ok(())
    }

    /// Whether `name` is an object: generated or defined, and not deleted.
    ///
    /// # Errors
    /// `InvalidOperation` between begin and end.
    pub fn is_object(&self, name: Name) -> Result<bool> {
        self.outside_begin()?;
        Ok(self.object_names.contains(name))
    }

    /// Sets a property of an object, from the next frame on.
    ///
    /// # Errors
    /// `InvalidValue` when there is no such object, or the value is a time that is not finite.
    pub fn object_parameter(&mut self, name: Name, parameter: ObjectParameter) -> Result<()> {
        self.outside_begin()?;
        self.known_object(name)?;
        if let ObjectParameter::Time(time) = parameter {
            finite("the time", &[time])?;
        }
        self.backend.reserve(1)?;
        self.objects.try_reserve(1)?;
        let info = self.objects.entry(name).or_default();
        match parameter {
            ObjectParameter::Strategy(strategy) => {
                info.strategy = strategy;
                self.backend.send(Command::SetStrategy { name, strategy });
            }
            ObjectParameter::Motion(motion) => {
                info.motion = motion;
                if let Some(definition) = self.definition.as_mut().filter(|definition| definition.name == name) {
                    definition.motion = None;
                }
                self.backend.send(Command::SetMotion { name, motion });
            }
            ObjectParameter::LazyShape(shape) => {
                info.lazy_shape = shape;
                self.backend.send(Command::SetLazyShape { name, shape });
            }
            ObjectParameter::Time(time) => {
                info.time = time;
                self.backend.send(Command::SetTime { name, time });
            }
            ObjectParameter::SpatialSplits(wanted) => {
                info.spatial_splits = wanted;
                self.backend.send(Command::SetSpatialSplits { name, wanted });
            }
            ObjectParameter::Mask(mask) => {
                info.mask = mask;
                self.backend.send(Command::SetMask { name, mask });
            }
        }
        Ok(())
    }

    /// What an object is.
    ///
    /// # Errors
    /// `InvalidValue` when there is no such object.
    pub fn get_object_parameters(&self, name: Name) -> Result<ObjectInfo> {
        self.outside_begin()?;
        self.known_object(name)?;
        Ok(self.objects.get(&name).copied().unwrap_or_default())
    }

    /// Moves the vertices `first..first + positions.len()` of an object, counted in the order in which its definition gave them;
    /// its triangles stay. Positions are in object space: the current matrix has no part in it. A vector of all positions is moved, not copied.
    ///
    /// # Errors
    /// `InvalidValue` when there is no such object or it has fewer vertices.
    pub fn update_vertices<'a>(&mut self, name: Name, first: u32, positions: impl Into<Cow<'a, [Vec3]>>) -> Result<()> {
        self.outside_begin()?;
        let positions = positions.into();
        self.vertex_range(name, first, positions.len())?;
        if positions.is_empty() {
            return Ok(());
        }
        let positions = owned(positions)?;
        self.backend.reserve(1)?;
        self.backend.send(Command::UpdatePositions { name, first, positions });
        Ok(())
    }

    /// Moves the vertices whose numbers are in `vertices`, each to the position at the same place in `positions`; of one that is named twice the last
    /// counts. What it costs depends on how many are moved, not on how many the object has, if its strategy is `Lazy` or one that refits.
    ///
    /// # Errors
    /// `InvalidValue` when there is no such object, it has fewer vertices, or the slices differ in length.
    pub fn update_vertex_elements<'a>(
        &mut self,
        name: Name,
        vertices: impl Into<Cow<'a, [u32]>>,
        positions: impl Into<Cow<'a, [Vec3]>>,
    ) -> Result<()> {
        self.outside_begin()?;
        let (vertices, positions) = (vertices.into(), positions.into());
        let info = self.vertex_range(name, 0, 0)?;
        if vertices.len() != positions.len() {
            let (vertices, positions) = (vertices.len(), positions.len());
            return Err(Error::invalid_value(format_args!("{vertices} vertices have {positions} positions")));
        }
        if let Some(vertex) = vertices.iter().find(|&&vertex| vertex >= info.vertex_count) {
            let count = info.vertex_count;
            return Err(Error::invalid_value(format_args!("object {name} has no vertex {vertex}, only {count}")));
        }
        if vertices.is_empty() {
            return Ok(());
        }
        let (vertices, positions) = (owned(vertices)?, owned(positions)?);
        self.backend.reserve(1)?;
        self.backend.send(Command::MovePositions { name, vertices, positions });
        Ok(())
    }

    /// Has a structure built for positions that the object's vertices will have at `time`, about. Nothing moves by that. Of all key frames of an object
    /// the one nearest to its [`ObjectParameter::Time`] is active: its structure is what follows the vertices then, under the strategies `Lazy` and
    /// `Refit`. Good for animations that tear a mesh apart. A key frame of the same time is replaced; defining the object anew deletes all.
    ///
    /// # Errors
    /// `InvalidValue` when there is no such object, it has another number of vertices, or the time is not finite.
    pub fn key_frame<'a>(&mut self, name: Name, time: f32, positions: impl Into<Cow<'a, [Vec3]>>) -> Result<()> {
        self.outside_begin()?;
        let positions = positions.into();
        let info = self.vertex_range(name, 0, 0)?;
        finite("the time", &[time])?;
        if positions.len() != info.vertex_count as usize {
            let (given, count) = (positions.len(), info.vertex_count);
            return Err(Error::invalid_value(format_args!(
                "object {name} has {count} vertices, and {given} positions were given"
            )));
        }
        let positions = owned(positions)?;
        self.backend.reserve(1)?;
        self.backend.send(Command::SetKeyFrame { name, time, positions });
        Ok(())
    }

    /// Deletes all key frames of an object.
    ///
    /// # Errors
    /// `InvalidValue` when there is no such object.
    pub fn delete_key_frames(&mut self, name: Name) -> Result<()> {
        self.outside_begin()?;
        self.known_object(name)?;
        self.backend.reserve(1)?;
        self.backend.send(Command::DeleteKeyFrames { name });
        Ok(())
    }

    /// Changes normals as [`Context::update_vertices`] does positions.
    ///
    /// # Errors
    /// Also `InvalidOperation` when the object was defined without normals.
    pub fn update_normals<'a>(&mut self, name: Name, first: u32, normals: impl Into<Cow<'a, [Vec3]>>) -> Result<()> {
        self.outside_begin()?;
        let normals = normals.into();
        let info = self.vertex_range(name, first, normals.len())?;
        if normals.is_empty() {
            return Ok(());
        }
        if !info.has_normals {
            return Err(Error::invalid_operation(format_args!("object {name} was defined without normals")));
        }
        let normals = owned(normals)?;
        self.backend.reserve(1)?;
        self.backend.send(Command::UpdateNormals { name, first, normals });
        Ok(())
    }

    pub(super) fn known_object(&self, name: Name) -> Result<()> {
        // One that is being defined gets its name at the end.
        if self.object_names.contains(name) || self.definition.as_ref().is_some_and(|d| d.name == name) {
            Ok(())
        } else {
            Err(Error::invalid_value(format_args!("there is no object {name}")))
        }
    }

    fn vertex_range(&self, name: Name, first: u32, count: usize) -> Result<ObjectInfo> {
        self.known_object(name)?;
        let info = self.objects.get(&name).copied().unwrap_or_default();
        if count > (info.vertex_count as usize).saturating_sub(first as usize) || first > info.vertex_count {
            let has = info.vertex_count;
            return Err(Error::invalid_value(format_args!(
                "object {name} has {has} vertices, and {count} from number {first} on were given"
            )));
        }
        Ok(info)
    }
}

fn owned<T: Copy>(values: Cow<'_, [T]>) -> Result<Vec<T>> {
    match values {
        Cow::Borrowed(values) => try_copy(values),
        Cow::Owned(values) => Ok(values),
    }
}

pub(super) fn positive(n: i32) -> Result<u32> {
    u32::try_from(n)
        .ok()
        .filter(|&n| n > 0)
        .ok_or_else(|| Error::invalid_value(format_args!("n is {n}; it must be positive")))
}

#[cold]
pub(super) fn no_names(n: u32) -> Error {
    Error::new(ErrorCode::OutOfMemory, format_args!("there are no {n} names in a row left"))
}
