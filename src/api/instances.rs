//! Instances: objects placed in the frame being assembled, or in the object being defined.

use super::context::Context;
use super::error::{Error, Result};
use crate::scene::{Instance, Name};
use glam::{Affine3A, DMat4, Mat4};

impl Context {
    /// Places an object with the current matrix in the frame being assembled. Several hundred thousand instances are fine.
    ///
    /// Between [`Context::new_object`] and [`Context::end_object`] it makes the object part of the one that is being defined, as `glCallList` does between
    /// `glNewList` and `glEndList`. Parts are named, not copied: a part that is defined anew shows from the next frame on wherever it is a part, and one
    /// that is deleted shows nothing. Composites may be parts of others, as deep as memory allows. A hit names the innermost object, and the instance that was placed in the frame.
    ///
    /// A matrix that flattens the object (a factor of 0) shows it flat, and one without thickness in two directions shows nothing. Such an instance has
    /// a structure of its own, as has one that is smaller than 10⁻¹² of its object.
    ///
    /// # Errors
    /// `InvalidValue` when there is no such object, or the matrix has an element beyond [`super::MAX_COORDINATE`]; `InvalidOperation` between begin and
    /// end, when the current matrix is not affine (bottom row 0 0 0 1), or when the object would become a part of itself; `OutOfMemory`.
    pub fn instantiate_object(&mut self, name: Name) -> Result<()> {
        self.outside_begin()?;
        let seen = self.is_shown(name);
        if !seen {
            self.known_object(name)?;
        }
        let instance = self.masked(name, self.matrices.affine()?);
        if !seen {
            self.may_place(name)?;
        }
        self.reserve_instances(1)?;
        self.place(instance);
        Ok(())
    }

    /// Places an object once for each of `matrices`, which are multiplied on the current matrix: as [`Context::instantiate_object`] many times, but
    /// all of them or none.
    ///
    /// # Errors
    /// As [`Context::instantiate_object`]; the message says which matrix is meant.
    pub fn instantiate_objects(&mut self, name: Name, matrices: impl IntoIterator<Item = Mat4>) -> Result<()> {
        self.outside_begin()?;
        self.known_object(name)?;
        self.may_place(name)?;
        let before = self.placed_count();
        let outcome = matrices.into_iter().enumerate().try_for_each(|(number, matrix)| {
            let matrix = self.matrices.affine_times(&DMat4::from_cols_array(&matrix.to_cols_array().map(f64::from)));
            let matrix = matrix.map_err(|e| Error::new(e.code, format_args!("matrix {number}: {}", e.message)))?;
            self.reserve_instances(1)?;
            self.place(self.masked(name, matrix));
            Ok(())
        });
        if outcome.is_err() {
            match &mut self.definition {
                Some(definition) => definition.children.truncate(before),
                None => self.content.truncate(before),
            }
        }
        outcome
    }

    /// Whether the frame being assembled takes the next instance, and shows the object already: then nothing is left to check.
    fn is_shown(&self, name: Name) -> bool {
        self.definition.is_none() && self.objects.get(&name).is_some_and(|info| info.used_in_frame == self.frames + 1)
    }

    fn masked(&self, object: Name, world_from_object: Affine3A) -> Instance {
        Instance { object, world_from_object, mask: self.content.instance_mask }
    }

    fn placed_count(&self) -> usize {
        self.definition.as_ref().map_or(self.content.instance_count(), |definition| definition.children.len())
    }

    /// Checks that the object may be placed where instances go now; one that is shown by the frame being assembled is marked so, with all its parts.
    fn may_place(&mut self, name: Name) -> Result<()> {
        let Some(definition) = &self.definition else { return self.mark_used(name) };
        if self.composites.holds(name, definition.name)? {
            let whole = definition.name;
            return Err(if name == whole {
                Error::invalid_operation(format_args!("object {whole} cannot be a part of itself"))
            } else {
                Error::invalid_operation(format_args!(
                    "object {name} cannot be a part of object {whole}, which is a part of it"
                ))
            });
        }
        Ok(())
    }

    fn reserve_instances(&mut self, count: usize) -> Result<()> {
        match &mut self.definition {
            Some(definition) => Ok(definition.children.try_reserve(count)?),
            None => self.content.reserve_instances(count),
        }
    }

    /// Adds an instance; room was reserved.
    fn place(&mut self, instance: Instance) {
        match &mut self.definition {
            Some(definition) => definition.children.push(instance),
            None => self.content.push(instance),
        }
    }

    /// Adds the object that has just been defined; room was reserved, and it was marked.
    pub(super) fn place_defined(&mut self, object: Name, world_from_object: Affine3A) {
        self.content.push(self.masked(object, world_from_object));
        let this_frame = self.frames + 1;
        if let Some(info) = self.objects.get_mut(&object) {
            info.used_in_frame = this_frame;
        }
    }

    /// Marks an object and its parts as shown by the frame being assembled: if they are deleted before it starts, it shows them all the same.
    pub(super) fn mark_used(&mut self, name: Name) -> Result<()> {
        let this_frame = self.frames + 1;
        let objects = &mut self.objects;
        self.composites.walk(name, |part| {
            let Some(info) = objects.get_mut(&part) else { return false };
            // Its parts have been marked then, too.
            std::mem::replace(&mut info.used_in_frame, this_frame) != this_frame
        })
    }
}
