//! The door of a pool: how work comes in from other threads.
//!
//! Rayon takes work from outside by a queue that allocates: a box for a job, a block for every few dozen. A steady frame shall allocate nothing, so
//! one worker, the *conductor*, spends its life in [`Door::conduct`]: it sleeps until an order comes, runs it, and what the order shares out
//! reaches the other workers as from any rayon job. The queue has its room from the start; who finds it full waits.
//!
//! While an order runs, who asks for another goes in by rayon's own door: the workers take it as soon as they have nothing else to do.
//! The conductor helps them before it sleeps, as the pool may have no other worker.

use super::Job;
use std::any::Any;
use std::cell::UnsafeCell;
use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

/// Orders that can wait; more threads than this that want something wait themselves.
const ROOM: usize = 64;

pub(super) enum Order {
    Job(Arc<dyn Job>),
    Once(Box<dyn FnOnce() + Send>),
    Lent(Lent),
}

/// Work on the stack of a thread that waits for it.
pub(super) struct Lent {
    task: *const (),
    /// # Safety
    /// - It gets `task`, which is alive, once.
    run: unsafe fn(*const ()),
    /// What its owner waits for.
    done: *const UnsafeCell<bool>,
}

// SAFETY: `Door::lend` makes it of a task that may be sent, and keeps that alive until `done`.
unsafe impl Send for Lent {}

/// See the module head.
pub(super) struct Door {
    state: Mutex<State>,
    /// An order came, or the end.
    came: Condvar,
    /// An order was taken, or is done.
    went: Condvar,
}

struct State {
    orders: VecDeque<Order>,
    busy: bool,
    /// How many came in by rayon's door and are still inside.
    outside: usize,
    ends: bool,
}

struct Task<F, R> {
    work: UnsafeCell<Option<F>>,
    outcome: UnsafeCell<Option<Result<R, Box<dyn Any + Send>>>>,
}

impl Door {
    pub fn new() -> Self {
        let orders = VecDeque::with_capacity(ROOM);
        let state = State { orders, busy: false, outside: 0, ends: false };
        Self { state: Mutex::new(state), came: Condvar::new(), went: Condvar::new() }
    }

    /// No panic passes while it is locked.
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Hands over an order, which is run some time soon.
    pub fn put(&self, order: Order) {
        drop(self.put_locked(self.lock(), order));
    }

    fn put_locked<'a>(&'a self, state: MutexGuard<'a, State>, order: Order) -> MutexGuard<'a, State> {
        let full = |state: &mut State| state.orders.len() >= ROOM;
        let mut state = self.went.wait_while(state, full).unwrap_or_else(PoisonError::into_inner);
        state.orders.push_back(order);
        self.came.notify_one();
        state
    }

    /// Has the conductor run `f`, and waits for it. While the conductor is busy `f` goes in by the other door, which `otherwise` is.
    pub fn lend<F: FnOnce() -> R + Send, R: Send>(&self, f: F, otherwise: impl FnOnce(F) -> R) -> R {
        let mut state = self.lock();
        if state.busy {
            state.outside += 1;
            drop(state);
            let _inside = Inside(self);
            return otherwise(f);
        }
        let task = Task { work: UnsafeCell::new(Some(f)), outcome: UnsafeCell::new(None) };
        let done = UnsafeCell::new(false);
        let lent = Lent { task: (&raw const task).cast(), run: Task::<F, R>::run, done: &raw const done };
        state = self.put_locked(state, Order::Lent(lent));
        // SAFETY: the conductor writes it under the same lock.
        let running = |_: &mut State| unsafe { !*done.get() };
        drop(self.went.wait_while(state, running).unwrap_or_else(PoisonError::into_inner));
        match task.outcome.into_inner() {
            Some(Ok(value)) => value,
            Some(Err(panic)) => resume_unwind(panic),
            None => unreachable!("what is done has an outcome"),
        }
    }

    /// The conductor's life: ends after [`Door::close`], when no order is left.
    pub fn conduct(&self) {
        let mut state = self.lock();
        loop {
            if let Some(order) = state.orders.pop_front() {
                state.busy = true;
                drop(state);
                self.went.notify_all();
                let done = order.run();
                state = self.lock();
                state.busy = false;
                if let Some(done) = done {
                    // SAFETY: its owner waits for this, and reads it under the lock.
                    unsafe { *(*done.0).get() = true };
                    self.went.notify_all();
                }
            } else if state.outside > 0 {
                drop(state);
                if rayon::yield_now() != Some(rayon::Yield::Executed) {
                    std::thread::yield_now();
                }
                state = self.lock();
            } else if state.ends {
                return;
            } else {
                state = self.came.wait(state).unwrap_or_else(PoisonError::into_inner);
            }
        }
    }

    /// Nothing more comes.
    pub fn close(&self) {
        self.lock().ends = true;
        self.came.notify_all();
    }
}

/// Where the owner of a [`Lent`] looks.
struct Done(*const UnsafeCell<bool>);

impl Order {
    fn run(self) -> Option<Done> {
        // A panic of what nobody waits for ends here; the panic hook has reported it.
        match self {
            Order::Job(job) => _ = catch_unwind(AssertUnwindSafe(|| job.run())),
            Order::Once(f) => _ = catch_unwind(AssertUnwindSafe(f)),
            Order::Lent(Lent { task, run, done }) => {
                // SAFETY: its owner waits until `done`, and nobody else runs it, as it was taken out of the queue.
                unsafe { run(task) };
                return Some(Done(done));
            }
        }
        None
    }
}

impl<F: FnOnce() -> R + Send, R: Send> Task<F, R> {
    /// # Safety
    /// - `task` is a `Task<F, R>` that lives and that nobody else looks at.
    unsafe fn run(task: *const ()) {
        // SAFETY: the caller's promise.
        let task = unsafe { &*task.cast::<Self>() };
        // SAFETY: the caller's promise.
        let work = unsafe { (*task.work.get()).take() };
        let outcome = work.map(|f| catch_unwind(AssertUnwindSafe(f)));
        // SAFETY: the caller's promise.
        unsafe { *task.outcome.get() = outcome };
    }
}

/// Somebody is inside who came in by the other door.
struct Inside<'a>(&'a Door);

impl Drop for Inside<'_> {
    fn drop(&mut self) {
        self.0.lock().outside -= 1;
    }
}
