//! Trees for key frames of one object (Larsson03 §4: "we always had an active pre-constructed hierarchy").
//!
//! A soup that is torn from one arrangement to another soon has a useless tree, however well it is refit. Where arrangements are known before, a tree is
//! built for each; the one of the key frame nearest in time follows the vertices, by the object's own strategy, and the others wait. Changing
//! from one to another costs a move of all vertices, which for a lazy tree is next to nothing. All are built when they are first seen.
//!
//! Memory is what it says: a tree per key frame.

use super::bvh::OutOfMemory;
use super::object_accel::Structure;
use crate::memory::push;
use crate::scene::{Mesh, Object};

/// The trees that wait, by the version of their key frame; and whose tree is in use, 0 for the object's own.
#[derive(Debug, Default)]
pub(super) struct KeyTrees {
    waiting: Vec<(u64, Structure)>,
    active: u64,
    /// [`Object::keys_version`] that all this is in line with.
    seen: u64,
}

/// What [`KeyTrees::follow`] did.
pub(super) struct Followed {
    /// Trees built.
    pub built: usize,
    /// Another tree is in use now, and knows nothing of where the vertices are.
    pub switched: bool,
}

impl KeyTrees {
    pub fn memory_bytes(&self) -> usize {
        self.waiting.iter().map(|(_, tree)| tree.memory_bytes()).sum()
    }

    /// Whether there is nothing to do for the key frames of `object`.
    pub fn are_current(&self, object: &Object, follows: bool) -> bool {
        !follows && self.active == 0 && self.waiting.is_empty()
            || self.seen == object.keys_version && self.active == wanted(object, follows)
    }

    /// Forgets all trees, the one in use included.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// Puts the tree of the active key frame into `structure`, and builds those that are missing by `build`. If the object has no key frames, or its
    /// strategy does not follow them (not `follows`), its own tree is the active one; that is built by the caller.
    pub fn follow(
        &mut self,
        object: &Object,
        follows: bool,
        structure: &mut Structure,
        mut build: impl FnMut(&Mesh) -> Result<Structure, OutOfMemory>,
    ) -> Result<Followed, OutOfMemory> {
        let wanted = wanted(object, follows);
        let keys = if follows { &object.keys[..] } else { &[] };
        let exists = |version: u64| keys.iter().any(|key| key.version == version);
        self.waiting.retain(|(version, _)| exists(*version));
        let present = !matches!(structure, Structure::None);
        let switched = self.active != wanted || (wanted != 0 && !present);
        if switched {
            let old = std::mem::take(structure);
            if present && exists(self.active) {
                // Without memory it is built anew when it is wanted.
                let _ = push(&mut self.waiting, (self.active, old));
            }
            self.active = wanted;
        }
        let mut built = 0;
        for key in keys {
            let in_use = key.version == wanted && !switched;
            if in_use || self.waiting.iter().any(|(version, _)| *version == key.version) {
                continue;
            }
            let mut mesh = Mesh::default();
            let bytes = size_of_val(&key.positions[..]) + size_of_val(&object.mesh.triangles[..]);
            let reserved = mesh.positions.try_reserve_exact(key.positions.len());
            let reserved = reserved.and(mesh.triangles.try_reserve_exact(object.mesh.triangles.len()));
            reserved.map_err(|_| OutOfMemory { bytes })?;
            mesh.positions.extend_from_slice(&key.positions);
            mesh.triangles.extend_from_slice(&object.mesh.triangles);
            push(&mut self.waiting, (key.version, build(&mesh)?))?;
            built += 1;
        }
        if switched && let Some(at) = self.waiting.iter().position(|(version, _)| *version == wanted) {
            *structure = self.waiting.swap_remove(at).1;
        }
        self.seen = object.keys_version;
        Ok(Followed { built, switched })
    }
}

fn wanted(object: &Object, follows: bool) -> u64 {
    object.active_key().filter(|_| follows).map_or(0, |key| key.version)
}
