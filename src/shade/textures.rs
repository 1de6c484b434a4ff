//! The textures of a frame, by dense index, and the cache of their mip-map chains between frames.

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

/// All textures of the scene.
#[derive(Default)]
pub struct Textures {
    compiled: Vec<CompiledTexture>,
    index: NameTable,
}

impl Textures {
    pub fn new(scene: &Scene, cache: &mut TextureCache) -> Self {
        cache.compiled.retain(|name, compiled| scene.textures.get(name).is_some_and(|t| compiled.is_from(t)));
        let mut names = Vec::new();
        let mut all = Vec::new();
        for (&name, source) in &scene.textures {
            let compiled = match cache.compiled.get(&name) {
                Some(compiled) => compiled.clone(),
                None => match CompiledTexture::new(source) {
                    Some(compiled) => cache.compiled.entry(name).insert_entry(compiled).get().clone(),
                    None => continue,
                },
            };
            names.push(name);
            all.push(compiled);
        }
        Self { compiled: all, index: NameTable::new(names.iter().copied()) }
    }

    /// The index of texture `name`; None if there is no such texture or it has no image.
    pub fn id(&self, name: Name) -> TextureId {
        if name == 0 { None } else { self.index.get(name) }
    }

    pub fn get(&self, name: Name) -> Option<CompiledTexture> {
        self.id(name).map(|id| self.compiled[id as usize].clone())
    }

    /// Filtered linear RGBA; white without a texture.
    #[inline]
    pub fn lookup(&self, id: TextureId, uv: Vec2, footprint: f32) -> Vec4 {
        match id {
            Some(id) => self.compiled[id as usize].lookup(uv, footprint),
            None => Vec4::ONE,
        }
    }
}
