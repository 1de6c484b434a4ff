//! Picking and batches of rays, in the scene last rendered or committed.

use super::context::Context;
use super::error::{Error, Result};
use crate::trace::{Hit, Ray};

impl Context {
    /// What the camera of the last frame sees at window coordinates `x`, `y`; pixel centres are at .5, the origin is at the lower left, or
    /// at the upper left with that capability on. Waits for a frame in flight.
    ///
    /// # Errors
    /// `InvalidOperation` between begin and end, inside an object, or before the first frame or commit; `InvalidValue` for NaN or infinity.
    pub fn pick(&mut self, x: f32, y: f32) -> Result<Option<Hit>> {
        self.outside_object()?;
        if !(x.is_finite() && y.is_finite()) {
            return Err(Error::invalid_value("the window coordinates are not finite"));
        }
        let size = self.backend.last_frame_size();
        let Some([_, height]) = self.trust(size)? else {
            return Err(Error::invalid_operation("nothing was rendered or committed yet"));
        };
        let y = if self.settings.origin_top_left { height as f32 - y } else { y };
        let hit = self.backend.pick(x, y);
        self.trust(hit)
    }

    /// The closest hit of each ray. `coherent` says that neighbouring rays are alike. A ray that is not finite, or has no direction,
    /// hits nothing. Waits for a frame in flight.
    ///
    /// # Errors
    /// `InvalidOperation` between begin and end or inside an object; `OutOfMemory`.
    pub fn intersect_rays(&mut self, rays: &[Ray], coherent: bool) -> Result<Vec<Option<Hit>>> {
        self.outside_object()?;
        let hits = self.backend.intersect(rays, coherent);
        self.trust(hits)
    }

    /// Whether anything lies on each ray between its ends; as [`Context::intersect_rays`], and faster.
    ///
    /// # Errors
    /// As [`Context::intersect_rays`].
    pub fn occluded_rays(&mut self, rays: &[Ray], coherent: bool) -> Result<Vec<bool>> {
        self.outside_object()?;
        let occluded = self.backend.occluded(rays, coherent);
        self.trust(occluded)
    }
}
