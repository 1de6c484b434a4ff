//! The textures of a frame, by dense index, and the cache of their mip-map chains between frames.

use crate::memory::{OutOfMemory, Room};
use crate::scene::{Name, Scene};
use crate::shade::names::NameTable;
use crate::shade::surface::TextureId;
use crate::shade::texture::CompiledTexture;
use glam::{Vec2, Vec4};
use std::collections::HashMap;

/// Compiled textures of the frames before, so that a mip-map chain is built once per image.
#[derive(Default)]
pub struct TextureCache {
    compiled: HashMap<Name, CompiledTexture>,
}

impl TextureCache {
    /// Compiles what is new in the scene and forgets what is gone.
    ///
    /// # Errors
    /// No memory; the next update tries again.
    pub fn update(&mut self, scene: &Scene) -> Result<(), OutOfMemory> {
        self.compiled.retain(|name, compiled| scene.textures.get(name).is_some_and(|t| compiled.is_from(t)));
        for (&name, source) in &scene.textures {
            if !self.compiled.contains_key(&name)
                && let Some(compiled) = CompiledTexture::new(source)?
            {
                self.compiled.room(1)?;
                self.compiled.insert(name, compiled);
            }
        }
        Ok(())
    }
}

/// All textures of the scene.
#[derive(Default)]
pub struct Textures {
    compiled: Vec<CompiledTexture>,
    index: NameTable,
}

impl Textures {
    /// Makes them what [`TextureCache::update`] has compiled.
    ///
    /// # Errors
    /// No memory.
    pub fn take(&mut self, cache: &TextureCache) -> Result<(), OutOfMemory> {
        self.compiled.clear();
        self.compiled.room(cache.compiled.len())?;
        self.compiled.extend(cache.compiled.values().cloned());
        self.index.rebuild(cache.compiled.keys().copied())
    }

    /// Lets go of the textures, but not of the memory.
    pub fn clear(&mut self) {
        self.compiled.clear();
    }

    /// The index of texture `name`; None if there is no such texture or it has no image.
    pub fn id(&self, name: Name) -> TextureId {
        if name == 0 { None } else { self.index.get(name) }
    }

    pub fn get(&self, name: Name) -> Option<CompiledTexture> {
        self.id(name).map(|id| self.compiled[id as usize].clone())
    }

    /// Filtered linear RGBA; white without a texture, and then nobody asks for the footprint.
    #[inline]
    pub fn lookup(&self, id: TextureId, uv: Vec2, footprint: impl FnOnce() -> f32) -> Vec4 {
        match id {
            Some(id) => self.compiled[id as usize].lookup(uv, footprint()),
            None => Vec4::ONE,
        }
    }
}
