//! One frame in flight: the world travels with it to a worker and comes back when the frame has ended.
//!
//! While a frame renders nobody else needs the world, so it is *moved* into the job instead of being locked; the mutex here
//! protects only the hand-over. User callbacks run before the hand-over and outside the lock, so whoever sees the frame landed
//! also knows that its callback has returned.

use crate::frame::{FrameStats, Target};
use crate::render::{RenderError, Renderer};
use crate::scene::{FrameDesc, Scene};
use crate::simd::Level;
use crate::threads::{Job, Pool};
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Called on a worker when a frame has ended, whatever its outcome.
pub type OnDone = Arc<dyn Fn(&Result<FrameStats, FrameFailure>) + Send + Sync>;

/// Why a frame did not come out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FrameFailure {
    OutOfMemory(String),
    /// A defect: the text of a panic, of the engine or of a user's callback.
    Panicked(String),
    /// A forked child could not start threads of its own.
    Threads(String),
    /// The process has forked since the frame started; its workers exist only in the parent.
    Forked,
}

/// What frames are rendered from, and with.
pub struct World {
    pub scene: Arc<Scene>,
    pub renderer: Renderer,
    /// The frame whose structures and pixels `renderer` holds.
    pub last_frame: Option<FrameDesc>,
    /// The one before: its lists are the next frame's memory.
    pub spare: FrameDesc,
}

impl World {
    pub fn new(scene: Scene, level: Level) -> Self {
        let (scene, renderer) = (Arc::new(scene), Renderer::new(level));
        Self { scene, renderer, last_frame: None, spare: FrameDesc::default() }
    }

    /// The scene, to change it. No frame is in flight.
    pub fn scene_mut(&mut self) -> &mut Scene {
        Arc::get_mut(&mut self.scene).expect("only a frame in flight shares the scene")
    }

    /// Keeps the frame that has been rendered or committed.
    pub fn show(&mut self, frame: FrameDesc) {
        if let Some(before) = self.last_frame.replace(frame) {
            self.spare = before;
        }
    }
}

/// A frame that is to be rendered, and all that it is rendered with.
pub struct Order {
    pub world: Box<World>,
    pub frame: FrameDesc,
    pub target: Option<Target>,
    pub on_done: Option<OnDone>,
}

struct Landed {
    world: Box<World>,
    outcome: Result<FrameStats, FrameFailure>,
}

/// Where the world is.
enum Stage {
    /// With the back-end.
    Ground,
    /// On its way to a worker.
    Ordered(Order),
    /// With a worker.
    Air,
    /// On its way back.
    Landed(Landed),
}

/// Shared by the job and the one who waits for it; used again from frame to frame.
pub struct Flight {
    stage: Mutex<Stage>,
    changed: Condvar,
    done: AtomicBool,
    cancel: Arc<AtomicBool>,
    /// Which has ordered the frame.
    process: AtomicU32,
}

impl Flight {
    pub fn new(cancel: Arc<AtomicBool>) -> Arc<Self> {
        Arc::new(Self {
            stage: Mutex::new(Stage::Ground),
            changed: Condvar::new(),
            done: AtomicBool::new(true),
            cancel,
            process: AtomicU32::new(0),
        })
    }

    fn stage(&self) -> MutexGuard<'_, Stage> {
        self.stage.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Has a worker of `pool` render a frame. The frame before has been waited for.
    pub fn start(self: &Arc<Self>, pool: &Pool, order: Order) {
        self.process.store(std::process::id(), Ordering::Relaxed);
        self.done.store(false, Ordering::Relaxed);
        *self.stage() = Stage::Ordered(order);
        pool.start(self.clone());
    }

    /// Whether the pixels are there, or never will be as the process has forked.
    pub fn is_done(&self) -> bool {
        self.done.load(Ordering::Acquire) || self.is_the_parents()
    }

    /// Whether the process is a child of the one that started the frame; the worker is not in it.
    fn is_the_parents(&self) -> bool {
        self.process.load(Ordering::Relaxed) != std::process::id()
    }

    /// Waits for the job and takes the world back; None in a child of the process that started the frame.
    pub fn wait(&self) -> Option<(Box<World>, Result<FrameStats, FrameFailure>)> {
        if self.is_the_parents() {
            return None;
        }
        let flying = |stage: &mut Stage| !matches!(stage, Stage::Landed(_));
        let mut stage = self.changed.wait_while(self.stage(), flying).unwrap_or_else(PoisonError::into_inner);
        match std::mem::replace(&mut *stage, Stage::Ground) {
            Stage::Landed(Landed { world, outcome }) => Some((world, outcome)),
            _ => unreachable!("what has landed stays until it is taken"),
        }
    }

    /// Waits until the frame has ended or `timeout` has passed; whether it has ended.
    pub fn wait_timeout(&self, timeout: Duration) -> bool {
        if self.is_the_parents() {
            return true;
        }
        let deadline = Instant::now().checked_add(timeout);
        let mut stage = self.stage();
        while !matches!(*stage, Stage::Landed(_)) {
            let left = deadline.map_or(Duration::from_secs(3600), |d| d.saturating_duration_since(Instant::now()));
            if left.is_zero() {
                return false;
            }
            stage = self.changed.wait_timeout(stage, left).unwrap_or_else(PoisonError::into_inner).0;
        }
        true
    }
}

impl Job for Flight {
    /// Renders, tells the user, hands the world back.
    fn run(&self) {
        let Stage::Ordered(order) = std::mem::replace(&mut *self.stage(), Stage::Air) else { return };
        let Order { mut world, frame, target, on_done } = order;
        let mut outcome = guarded(|| {
            let result = world.renderer.render(&world.scene, &frame, target.as_ref(), &self.cancel);
            result.map_err(FrameFailure::from)
        });
        world.show(frame);
        // The application's memory must not be touched after the callback.
        drop(target);
        self.done.store(true, Ordering::Release);
        if let Some(on_done) = on_done {
            let told = guarded(|| {
                on_done(&outcome);
                Ok(())
            });
            if let Err(failure) = told {
                outcome = Err(failure);
            }
        }
        *self.stage() = Stage::Landed(Landed { world, outcome });
        self.changed.notify_all();
    }
}

/// Runs `f`; a panic becomes [`FrameFailure::Panicked`].
pub fn guarded<T>(f: impl FnOnce() -> Result<T, FrameFailure>) -> Result<T, FrameFailure> {
    // What a panic leaves behind is never used again: the context is poisoned by this failure.
    catch_unwind(AssertUnwindSafe(f)).unwrap_or_else(|payload| Err(FrameFailure::Panicked(panic_text(&*payload))))
}

fn panic_text(payload: &(dyn Any + Send)) -> String {
    if let Some(text) = payload.downcast_ref::<&str>() {
        (*text).to_owned()
    } else if let Some(text) = payload.downcast_ref::<String>() {
        text.clone()
    } else {
        "a panic without text".to_owned()
    }
}

impl From<RenderError> for FrameFailure {
    fn from(error: RenderError) -> Self {
        FrameFailure::OutOfMemory(error.to_string())
    }
}

impl std::fmt::Display for FrameFailure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::OutOfMemory(text) | Self::Threads(text) => f.write_str(text),
            Self::Panicked(text) => write!(f, "internal error: {text}"),
            Self::Forked => f.write_str(
                "the process has forked while the frame was rendered, which is the parent's: start it again",
            ),
        }
    }
}

impl std::error::Error for FrameFailure {}
