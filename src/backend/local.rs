//! The back-end that renders in this process.
//!
//! Commands wait ([`Changes`]) and are applied, in order, when the next frame or commit starts; so a frame sees the scene as it was at
//! its start, and queries between frames see the frame before.

use super::flight::{Flight, FrameFailure, OnDone, Order, World, guarded};
use crate::frame::{FrameStats, Framebuffer, Target};
use crate::render::RenderError;
use crate::scene::{Changes, Command, FrameDesc, Scene};
use crate::simd::Level;
use crate::threads::{Pool, ThreadError, with_default_floats};
use crate::trace::Hit;
use std::collections::TryReserveError;
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Why no back-end could be set up.
#[derive(Debug)]
pub enum BackendError {
    Threads(ThreadError),
}

impl fmt::Display for BackendError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Threads(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for BackendError {}

impl BackendError {
    /// Whether it was for want of memory.
    pub fn is_out_of_memory(&self) -> bool {
        match self {
            Self::Threads(error) => error.is_out_of_memory(),
        }
    }
}

/// Scene, renderer and threads of one context.
pub struct Local {
    pub(super) pool: Pool,
    level: Level,
    /// None while a frame is in flight.
    world: Option<Box<World>>,
    /// The scene of the frame in flight, with which a child of fork() goes on: the world is with a thread that the child does not have.
    flying: Option<Arc<Scene>>,
    flight: Arc<Flight>,
    /// The world is with `flight`, or on its way.
    in_flight: bool,
    /// Outcome of a flight that a query has waited for; the application has yet to ask.
    outcome: Option<Result<FrameStats, FrameFailure>>,
    /// Not yet applied.
    pending: Changes,
    cancel: Arc<AtomicBool>,
    /// Batches traced on the application's threads.
    pub(super) small_batches: u32,
}

impl Local {
    /// A back-end with its own threads, see [`Pool::new`], and kernels up to `level`.
    ///
    /// # Errors
    /// The system refuses a thread.
    pub fn new(threads: Option<usize>, level: Level) -> Result<Self, BackendError> {
        let pool = Pool::new(threads).map_err(BackendError::Threads)?;
        let cancel = Arc::new(AtomicBool::new(false));
        Ok(Self {
            pool,
            level,
            world: Some(Box::new(World::new(Scene::default(), level))),
            flying: None,
            flight: Flight::new(cancel.clone()),
            in_flight: false,
            outcome: None,
            pending: Changes::default(),
            cancel,
            small_batches: 0,
        })
    }

    /// Number of worker threads.
    pub fn threads(&self) -> usize {
        self.pool.threads()
    }

    /// Instruction set of the kernels.
    pub fn simd_level(&self) -> &'static str {
        self.level.name()
    }

    /// Makes room for `n` commands, which [`Local::send`] then takes without fail.
    ///
    /// # Errors
    /// No memory.
    pub fn reserve(&mut self, n: usize) -> Result<(), TryReserveError> {
        self.pending.reserve(n)
    }

    /// Takes a valid command; it counts from the next frame or commit on.
    pub fn send(&mut self, command: Command) {
        self.pending.add(command, self.world.as_deref().map(|world| &*world.scene));
    }

    /// Waits for the frame in flight, and makes sure that another can start.
    ///
    /// # Errors
    /// As [`Local::start_frame`].
    pub fn ready(&mut self) -> Result<(), FrameFailure> {
        self.land()
    }

    /// Gets the memory that the changes sent take in the scene, and that of `more` definitions of objects to come: a frame that starts then has all that it
    /// needs to start. Waits for the frame in flight.
    ///
    /// # Errors
    /// As [`Local::ready`], and `OutOfMemory`; then nothing has changed.
    pub fn prepare(&mut self, more: usize) -> Result<(), FrameFailure> {
        self.land()?;
        let world = self.world.as_mut().expect("land() has put the world back");
        self.pending.prepare(world.scene_mut(), more).map_err(|error| RenderError::from(error).into())
    }

    /// The memory of an older frame's description, for the next one's. Waits for the frame in flight.
    ///
    /// # Errors
    /// As [`Local::ready`].
    pub fn spare_frame(&mut self) -> Result<FrameDesc, FrameFailure> {
        self.land()?;
        let world = self.world.as_mut().expect("land() has put the world back");
        Ok(std::mem::take(&mut world.spare))
    }

    /// Starts rendering `frame`, after the one in flight.
    ///
    /// # Errors
    /// `Threads` when a forked child cannot start its own, `OutOfMemory`.
    pub fn start_frame(
        &mut self,
        frame: FrameDesc,
        target: Option<Target>,
        on_done: Option<OnDone>,
    ) -> Result<(), FrameFailure> {
        self.land()?;
        self.outcome = None;
        self.apply_pending()?;
        let world = self.world.take().expect("land() has put the world back");
        self.cancel.store(false, Ordering::Relaxed);
        self.in_flight = true;
        self.flying = Some(world.scene.clone());
        self.flight.start(&self.pool, Order { world, frame, target, on_done });
        Ok(())
    }

    /// Waits for the frame that was started and says how it went. None was started: statistics of nothing.
    ///
    /// # Errors
    /// The frame did not come out; `Forked` in a child of the process that started it.
    pub fn finish_frame(&mut self) -> Result<FrameStats, FrameFailure> {
        self.land()?;
        self.outcome.take().unwrap_or(Ok(FrameStats::default()))
    }

    /// Whether the pixels of the frame that was started are there.
    pub fn is_frame_done(&self) -> bool {
        !self.in_flight || self.flight.is_done()
    }

    /// Waits up to `timeout` for the frame; whether it has ended.
    pub fn wait_frame(&self, timeout: Duration) -> bool {
        !self.in_flight || self.flight.wait_timeout(timeout)
    }

    /// Raised by whoever wants the frame in flight to stop early; lowered when a frame starts.
    pub fn cancel_flag(&self) -> &Arc<AtomicBool> {
        &self.cancel
    }

    /// Brings all structures up to date with the commands sent and with `frame`, without rendering.
    ///
    /// # Errors
    /// As [`Local::finish_frame`].
    pub fn commit(&mut self, frame: FrameDesc) -> Result<FrameStats, FrameFailure> {
        self.land()?;
        self.apply_pending()?;
        let world = self.world.as_mut().expect("land() has put the world back");
        let pool = &self.pool;
        guarded(|| {
            let stats = pool.install(|| world.renderer.commit(&world.scene, &frame))?;
            world.show(frame);
            Ok(stats)
        })
    }

    /// What the camera of the last frame sees at window coordinates `x`, `y` (pixel centres at .5, origin at the lower left).
    ///
    /// # Errors
    /// As [`Local::finish_frame`].
    pub fn pick(&mut self, x: f32, y: f32) -> Result<Option<Hit>, FrameFailure> {
        let world = self.resting_world()?;
        let hit = || world.renderer.pick(&world.scene, x, y).map_err(|error| RenderError::from(error).into());
        guarded(|| with_default_floats(hit))
    }

    /// Size of the framebuffer of the frame last committed or rendered.
    ///
    /// # Errors
    /// As [`Local::finish_frame`].
    pub fn last_frame_size(&mut self) -> Result<Option<[u32; 2]>, FrameFailure> {
        Ok(self.resting_world()?.last_frame.as_ref().map(|frame| frame.size))
    }

    /// Pixels of the last frame.
    ///
    /// # Errors
    /// As [`Local::finish_frame`].
    pub fn framebuffer(&mut self) -> Result<&Framebuffer, FrameFailure> {
        Ok(self.landed_world()?.1.renderer.framebuffer())
    }

    pub(super) fn landed_world(&mut self) -> Result<(&Pool, &World), FrameFailure> {
        self.land()?;
        Ok((&self.pool, self.world.as_deref().expect("land() has put the world back")))
    }

    /// Waits for the frame in flight, if any, and takes the world back.
    fn land(&mut self) -> Result<(), FrameFailure> {
        self.resting_world()?;
        self.pool.ensure().map_err(|error| FrameFailure::Threads(error.to_string()))
    }

    /// The world, when no frame is in flight any more. Its threads may be missing, after a fork.
    #[inline]
    pub(super) fn resting_world(&mut self) -> Result<&World, FrameFailure> {
        if std::mem::take(&mut self.in_flight) {
            match self.flight.wait() {
                Some((world, outcome)) => (self.world, self.outcome) = (Some(world), Some(outcome)),
                None => self.go_on_after_fork()?,
            }
            self.flying = None;
        }
        Ok(self.world.as_deref().expect("the world is here when no frame is in flight"))
    }

    /// In a child of the process that has started the frame: the same scene, without structures, and no frame.
    #[cold]
    fn go_on_after_fork(&mut self) -> Result<(), FrameFailure> {
        // Once more, if there is no memory.
        self.in_flight = true;
        let scene = self.flying.as_ref().expect("a frame in flight has a scene").copied();
        let scene = scene.map_err(RenderError::from)?;
        self.world = Some(Box::new(World::new(scene, self.level)));
        self.outcome = Some(Err(FrameFailure::Forked));
        // That of the parent may be locked for ever.
        self.flight = Flight::new(self.cancel.clone());
        self.in_flight = false;
        Ok(())
    }

    fn apply_pending(&mut self) -> Result<(), FrameFailure> {
        self.prepare(0)?;
        let world = self.world.as_mut().expect("the world has landed");
        let pending = &mut self.pending;
        guarded(|| {
            pending.apply_to(world.scene_mut());
            Ok(())
        })
    }
}

impl Drop for Local {
    /// Waits for the frame in flight, because it may be writing to the application's memory.
    fn drop(&mut self) {
        self.cancel.store(true, Ordering::Relaxed);
        if self.in_flight {
            // In a forked child there is nothing to wait for.
            let _ = self.flight.wait();
        }
    }
}
