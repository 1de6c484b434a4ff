//! Picking and batches of rays, in the scene last rendered or committed.

use super::context::Context;
use super::error::{Error, ErrorCode, Result};
use crate::backend::{Queries, SceneView};
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
            return Err(Error::invalid_value(format_args!("the window coordinates are ({x}, {y})")));
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
        let mut hits = answers(rays, Hit::MISS)?;
        self.intersect_into(rays, &mut hits, coherent)?;
        let mut found = Vec::new();
        found.try_reserve_exact(hits.len())?;
        found.extend(hits.into_iter().map(Hit::found));
        Ok(found)
    }

    /// As [`Context::intersect_rays`], into memory of the caller: [`Hit::MISS`] for none. Up to some hundred rays are traced on the calling thread,
    /// without allocation, lock or system call; more by all threads of the context.
    ///
    /// # Errors
    /// `InvalidValue` when the slices differ in length; else as [`Context::intersect_rays`].
    #[inline]
    pub fn intersect_into(&mut self, rays: &[Ray], hits: &mut [Hit], coherent: bool) -> Result<()> {
        self.outside_object()?;
        same_length(rays.len(), hits.len())?;
        let traced = self.backend.intersect(rays, hits, coherent);
        self.trust(traced)
    }

    /// Whether anything lies on each ray between its ends; as [`Context::intersect_rays`], and faster.
    ///
    /// # Errors
    /// As [`Context::intersect_rays`].
    pub fn occluded_rays(&mut self, rays: &[Ray], coherent: bool) -> Result<Vec<bool>> {
        let mut occluded = answers(rays, false)?;
        self.occluded_into(rays, &mut occluded, coherent)?;
        Ok(occluded)
    }

    /// As [`Context::occluded_rays`], into memory of the caller, by the rule of [`Context::intersect_into`].
    ///
    /// # Errors
    /// As [`Context::intersect_into`].
    #[inline]
    pub fn occluded_into(&mut self, rays: &[Ray], answers: &mut [bool], coherent: bool) -> Result<()> {
        self.outside_object()?;
        same_length(rays.len(), answers.len())?;
        let traced = self.backend.occluded(rays, answers, coherent);
        self.trust(traced)
    }

    /// All that can be asked about the scene last rendered or committed: hits by masks, all hits of a ray, what lies at a hit, the nearest point. Waits for a
    /// frame in flight.
    ///
    /// # Errors
    /// `InvalidOperation` between begin and end or inside an object.
    pub fn queries(&mut self) -> Result<Queries<'_>> {
        self.outside_object()?;
        if let Err(failure) = self.backend.queries() {
            return Err(self.distrust(failure));
        }
        self.backend.queries().map_err(|failure| Error::new(ErrorCode::InternalError, failure.to_string()))
    }

    /// A snapshot of the scene last rendered or committed, which any number of threads may ask while this context goes on. Waits for a frame in flight.
    ///
    /// ```
    /// use openrt::Context;
    /// use openrt::api::glam::Vec3;
    /// use openrt::api::{Ray, Result};
    ///
    /// fn main() -> Result<()> {
    ///     let mut cx = Context::new()?;
    ///     let scene = cx.snapshot()?;
    ///     let above = std::thread::spawn(move || scene.intersect(&Ray::new(Vec3::Y, Vec3::NEG_Y)));
    ///     assert_eq!(above.join().expect("no panic"), None, "nothing was committed yet");
    ///     Ok(())
    /// }
    /// ```
    ///
    /// # Errors
    /// `InvalidOperation` between begin and end or inside an object; `OutOfMemory`.
    pub fn snapshot(&mut self) -> Result<SceneView> {
        self.outside_object()?;
        let snapshot = self.backend.snapshot();
        self.trust(snapshot)
    }
}

/// Room for the answers to `rays`.
fn answers<T: Clone>(rays: &[Ray], none: T) -> Result<Vec<T>> {
    let mut answers = Vec::new();
    answers.try_reserve_exact(rays.len())?;
    answers.resize(rays.len(), none);
    Ok(answers)
}

fn same_length(rays: usize, answers: usize) -> Result<()> {
    if rays == answers {
        return Ok(());
    }
    Err(Error::invalid_value(format!("there are {rays} rays, and room for {answers} answers")))
}
