//! The textures of a frame, by dense index, and the cache of their mip-map chains between frames.

use crate::scene::{Name, Scene};
use crate::shade::names::NameTable;
use crate::shade::surface::TextureId;
use crate::shade::texture::CompiledTexture;
use glam::{Vec2, Vec4};
use std::collections::HashMap;
use std::collections::hash_map::Entry;

/// Compiled textures of the frames before, so that a mip-map chain is built once per image.
#[derive(Default)]
pub struct TextureCache {
    compiled: HashMap<Name, CompiledTexture>,
}

impl TextureCache {
    /// Compiles what is new in the scene and forgets what is gone.
    pub fn update(&mut self, scene: &Scene) {
        self.compiled.retain(|name, compiled| scene.textures.get(name).is_some_and(|t| compiled.is_from(t)));
        for (&name, source) in &scene.textures {
            if let Entry::Vacant(place) = self.compiled.entry(name)
                && let Some(compiled) = CompiledTexture::new(source)
            {
                place.insert(compiled);
            }
        }
    }
}

/// All textures of the scene.
#[derive(Default)]
pub struct Textures {
    compiled: Vec<CompiledTexture>,
    index: NameTable,
}

impl Textures {
    /// What [`TextureCache::update`] has compiled.
    pub fn new(cache: &TextureCache) -> Self {
        let compiled = cache.compiled.values().cloned().collect();
        Self { compiled, index: NameTable::new(cache.compiled.keys().copied()) }
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
