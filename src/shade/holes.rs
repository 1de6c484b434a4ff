//! Holes of cut-out surfaces, for picking: the eye looks through them.

use crate::scene::Scene;
use crate::shade::footprint::Cone;
use crate::shade::interaction::Interaction;
use crate::shade::placed::Placed;
use crate::shade::shade_scene::compile_surface;
use crate::shade::surface::Surface;
use crate::shade::textures::{TextureCache, Textures};
use crate::trace::{Hit, Ray};
use glam::Affine3A;
use std::cell::OnceCell;

/// Answers whether surfaces are there, for one pick. The table of textures is made for the first surface that has holes.
pub struct Holes<'a> {
    scene: &'a Scene,
    cache: &'a TextureCache,
    textures: OnceCell<Textures>,
}

impl<'a> Holes<'a> {
    /// `cache` must be up to date with the scene.
    pub fn new(scene: &'a Scene, cache: &'a TextureCache) -> Self {
        Self { scene, cache, textures: OnceCell::new() }
    }

    /// Whether the surface is not there at a hit.
    pub fn is_hole(&self, ray: &Ray, hit: &Hit) -> bool {
        let Some(mesh) = self.scene.objects.get(&hit.object).map(|object| &object.mesh) else { return false };
        let name = mesh.shader_of_triangle.get(hit.prim as usize);
        let Some(shader) = name.and_then(|name| self.scene.shaders.get(name)) else { return false };
        let compile = |textures: &Textures| compile_surface(0, shader, textures);
        // Whether it can have holes does not depend on its textures.
        if !compile(&Textures::default()).is_some_and(|surface| surface.is_see_through()) {
            return false;
        }
        let textures = self.textures.get_or_init(|| Textures::new(self.cache));
        // Alpha depends neither on where the instance is nor on the shader's name.
        let placed = Placed::new(Affine3A::IDENTITY);
        let it = Interaction::new(ray, hit, &placed, mesh, Cone { width: 0.0, spread: 0.0 }, 0);
        compile(textures).as_ref().is_some_and(|surface: &Surface| surface.is_hole(&it, textures))
    }
}
