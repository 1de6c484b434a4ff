//! Rays of the application, in the scene last committed or rendered.
//!
//! Up to [`ON_CALLER`] rays are traced on the thread that asks: without allocation, lock or system call. More are cut into jobs for the pool. Rays and answers
//! are read and written where the application has them.

use super::flight::{FrameFailure, guarded};
use super::local::Local;
use crate::render::{Queries, SceneView};
use crate::trace::{Hit, Ray};
use rayon::prelude::*;
use std::time::Instant;

/// To wake a pool and wait for it costs as much as some hundred rays.
const ON_CALLER: usize = 512;
/// Rays that one job of a batch traces, at the least and at the most. Coherent ones fill packets as they come; others are sorted into
/// packets within a job, so that it needs many.
const COHERENT_JOB: (usize, usize) = (64, 4096);
const INCOHERENT_JOB: (usize, usize) = (1024, 4096);
/// Jobs per thread, if there are rays enough: some take longer than others.
const JOBS: usize = 4;
/// One small batch in so many is timed, and counts for all: to look at the clock takes as long as a ray.
const TIMED: u32 = 64;

impl Local {
    /// What can be asked about the scene last committed or rendered.
    ///
    /// # Errors
    /// As [`Local::finish_frame`].
    #[inline]
    pub fn queries(&mut self) -> Result<Queries<'_>, FrameFailure> {
        let world = self.resting_world()?;
        Ok(world.renderer.queries(&world.scene))
    }

    /// A snapshot of the same.
    ///
    /// # Errors
    /// As [`Local::finish_frame`]; no memory.
    pub fn snapshot(&mut self) -> Result<SceneView, FrameFailure> {
        let world = self.resting_world()?;
        let snapshot = world.renderer.snapshot(&world.scene);
        snapshot.map_err(|_| FrameFailure::OutOfMemory("no memory for a snapshot".into()))
    }

    /// The closest hit of each ray, [`Hit::MISS`] for none. As many hits as rays.
    ///
    /// # Errors
    /// As [`Local::finish_frame`].
    #[inline]
    pub fn intersect(&mut self, rays: &[Ray], hits: &mut [Hit], coherent: bool) -> Result<(), FrameFailure> {
        self.trace(rays, hits, coherent, |queries, rays, hits| queries.intersect_into(rays, hits))
    }

    /// Whether anything lies on each ray. As many answers as rays.
    ///
    /// # Errors
    /// As [`Local::finish_frame`].
    #[inline]
    pub fn occluded(&mut self, rays: &[Ray], answers: &mut [bool], coherent: bool) -> Result<(), FrameFailure> {
        self.trace(rays, answers, coherent, |queries, rays, answers| queries.occluded_into(rays, answers))
    }

    #[inline]
    fn trace<T: Send>(
        &mut self,
        rays: &[Ray],
        answers: &mut [T],
        coherent: bool,
        trace: impl Fn(&Queries<'_>, &[Ray], &mut [T]) + Sync,
    ) -> Result<(), FrameFailure> {
        if rays.len() > ON_CALLER {
            return self.trace_in_parallel(rays, answers, coherent, trace);
        }
        self.small_batches = self.small_batches.wrapping_add(1);
        let begin = self.small_batches.is_multiple_of(TIMED).then(Instant::now);
        let world = self.resting_world()?;
        guarded(|| {
            trace(&world.renderer.queries(&world.scene), rays, answers);
            Ok(())
        })?;
        if let Some(begin) = begin {
            world.renderer.add_traced(begin.elapsed().as_secs_f64() * f64::from(TIMED));
        }
        Ok(())
    }

    fn trace_in_parallel<T: Send>(
        &mut self,
        rays: &[Ray],
        answers: &mut [T],
        coherent: bool,
        trace: impl Fn(&Queries<'_>, &[Ray], &mut [T]) + Sync,
    ) -> Result<(), FrameFailure> {
        let (pool, world) = self.landed_world()?;
        let (least, most) = if coherent { COHERENT_JOB } else { INCOHERENT_JOB };
        let begin = Instant::now();
        guarded(|| {
            let queries = world.renderer.queries(&world.scene);
            pool.install(|| {
                let share = rays.len() / (JOBS * rayon::current_num_threads());
                let job = share.next_multiple_of(64).clamp(least, most);
                let jobs = answers.par_chunks_mut(job).zip(rays.par_chunks(job));
                jobs.for_each(|(answers, rays)| trace(&queries, rays, answers));
            });
            Ok(())
        })?;
        world.renderer.add_traced(begin.elapsed().as_secs_f64());
        Ok(())
    }
}
