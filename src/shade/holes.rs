//! Holes of cut-out surfaces, for picking: the eye looks through them.

use crate::memory::OutOfMemory;
use crate::scene::Scene;
use crate::shade::footprint::Cone;
use crate::shade::interaction::Interaction;
use crate::shade::placed::Placed;
use crate::shade::shade_scene::{ShadeMemory, compile_surface};
use crate::shade::surface::Surface;
use crate::shade::textures::Textures;
use crate::trace::{Hit, Ray};
use glam::Affine3A;

/// Answers whether surfaces are there, for one pick. The table of textures is made for the first surface that has holes.
pub struct Holes<'a> {
    scene: &'a Scene,
    memory: &'a ShadeMemory,
    textures: Option<Textures>,
}

impl<'a> Holes<'a> {
    /// `memory` must be up to date with the scene.
    pub fn new(scene: &'a Scene, memory: &'a ShadeMemory) -> Self {
        Self { scene, memory, textures: None }
    }

    /// Whether the surface is not there at a hit.
    ///
    /// # Errors
    /// No memory.
    pub fn is_hole(&mut self, ray: &Ray, hit: &Hit) -> Result<bool, OutOfMemory> {
        let Self { scene, memory, .. } = *self;
        let Some(mesh) = scene.objects.get(&hit.object).map(|object| &object.mesh) else { return Ok(false) };
        let Some(&name) = mesh.shader_of_triangle.get(hit.primitive as usize) else { return Ok(false) };
        let Some(shader) = scene.shaders.get(&name) else { return Ok(false) };
        let compile = |textures: &Textures| compile_surface(name, shader, textures, &memory.blocks);
        // Whether it can have holes does not depend on its textures.
        if !compile(&Textures::default()).is_some_and(|surface| surface.is_see_through()) {
            return Ok(false);
        }
        let textures = match &mut self.textures {
            Some(known) => known,
            none => {
                let mut textures = Textures::default();
                textures.take(&memory.textures)?;
                none.insert(textures)
            }
        };
        // Alpha does not depend on where the instance is.
        let placed = Placed::new(Affine3A::IDENTITY);
        let it = Interaction::new(ray, hit, &placed, mesh, Cone { width: 0.0, spread: 0.0 }, 0);
        Ok(compile(textures).as_ref().is_some_and(|surface: &Surface| surface.is_hole(&it, textures)))
    }
}
