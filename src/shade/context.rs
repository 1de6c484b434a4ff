//! What a user's surface shader sees of the engine.

use crate::scene::{LightSample, Name, ShadingContext, SurfacePoint};
use crate::shade::interaction::Interaction;
use crate::shade::worker::{Bounce, Worker};
use glam::{Vec2, Vec3, Vec4};

pub(crate) struct Context<'w, 'a> {
    pub worker: &'w mut Worker<'a>,
    pub it: &'w Interaction<'w>,
    pub bounce: Bounce,
}

impl ShadingContext for Context<'_, '_> {
    fn point(&self) -> &SurfacePoint {
        &self.it.point
    }

    fn light_count(&self) -> u32 {
        self.worker.scene.lights.len() as u32
    }

    /// An area light answers with one of its points, another one each time.
    fn illuminate(&mut self, index: u32) -> Option<LightSample> {
        let light = self.worker.scene.lights.get(index as usize)?;
        let u = if light.samples > 1 { self.worker.rng.next_vec2() } else { Vec2::splat(0.5) };
        light.sample(self.it.point.position, u)
    }

    fn shadowed(&mut self, direction: Vec3, distance: f32) -> bool {
        let length = direction.length();
        if !(length > 0.0 && length.is_finite()) {
            return false;
        }
        self.worker.transmittance(self.it, direction / length, distance * length) == Vec3::ZERO
    }

    fn trace(&mut self, direction: Vec3) -> Vec3 {
        match direction.try_normalize() {
            Some(direction) => self.worker.bounce(self.it, direction, 1.0, 0.0, self.bounce),
            None => Vec3::ZERO,
        }
    }

    fn texture(&self, name: Name, uv: Vec2) -> Vec4 {
        let textures = &self.worker.scene.textures;
        textures.lookup(textures.id(name), uv, || self.it.footprint())
    }
}
