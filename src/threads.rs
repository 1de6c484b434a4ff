//! The engine's own thread pool.
//!
//! A library must not take rayon's global pool: it belongs to the host program, it cannot be ended, and after `fork()` the child
//! waits for ever for workers that exist only in the parent. So every parallel call of the engine goes through a [`Pool`]:
//!
//! * It is *keyed by process id*. In a forked child the first use starts fresh workers; the parent's bookkeeping is
//!   leaked there, because ending it would wait for threads that do not exist. No lock is involved: a lock held by
//!   another thread at the moment of `fork()` would stay held in the child.
//! * Workers start with the *default floating-point environment*. Threads inherit MXCSR from their creator, so a host that runs with
//!   flush-to-zero would otherwise get other pictures. The caller's own register is never written.
//! * Dropping the pool ends and joins the workers, so that no thread of ours outlives the library.
//! * Work from outside comes in without allocating (`conductor`). What rayon allocates later than a worker's start, it does before [`Pool::new`] returns.
//!
//! Two other things here are shared by threads: [`Desks`], which they work at, and [`OnTouch`]: arrays that are brought up to date part by part, by whoever needs a part first.
//!
//! Never hold a lock across [`Pool::install`] or a rayon `join`: a waiting worker steals work that may want the same lock.

mod conductor;
mod desks;
mod float_environment;
mod gate;
mod on_touch;
mod spawn;

use self::conductor::{Door, Order};
use self::gate::Gate;
use self::spawn::Thread;
use crate::memory::{OutOfMemory, behind, boxed, vec_of};
pub use desks::Desks;
pub use float_environment::with_default_floats;
pub use on_touch::{OnTouch, Place};

use std::fmt;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr;
use std::sync::atomic::{AtomicPtr, Ordering};
use std::sync::{Arc, Mutex};

/// More workers than this are never started, whatever the environment says.
pub const MAX_THREADS: usize = 1024;

/// Same as the usual main thread's: shaders of plug-ins run on workers.
const STACK_BYTES: usize = 8 << 20;

/// What threads of Rust programs have.
const ASIDE_STACK_BYTES: usize = 2 << 20;

/// What rayon takes for a worker, at most, and for a pool. Only the system's memory is meant, which need not be touched.
const WORKER_BYTES: usize = 4 << 10;
const POOL_BYTES: usize = 64 << 10;

/// Why no pool could be started.
#[derive(Debug)]
pub struct ThreadError {
    threads: usize,
    cause: String,
    no_memory: bool,
}

impl ThreadError {
    fn new(threads: usize, cause: &dyn fmt::Display, no_memory: bool) -> Self {
        Self { threads, cause: cause.to_string(), no_memory }
    }

    /// Whether it was for want of memory.
    pub fn is_out_of_memory(&self) -> bool {
        self.no_memory
    }
}

impl fmt::Display for ThreadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "cannot start {} worker threads: {}", self.threads, self.cause)
    }
}

impl std::error::Error for ThreadError {}

/// A fixed number of worker threads; cheap to ask, safe to use after `fork()`.
pub struct Pool {
    threads: usize,
    /// From `Box::into_raw`, never null; replaced only by a process that finds another process's id in it.
    workers: AtomicPtr<Workers>,
}

/// Work that somebody keeps, and has a pool do again and again: handing it over allocates nothing.
pub trait Job: Send + Sync {
    /// Runs on a worker. A panic ends there.
    fn run(&self);
}

/// The workers of one process.
struct Workers {
    pid: u32,
    pool: rayon::ThreadPool,
    door: Arc<Door>,
    handles: Mutex<Vec<Thread>>,
}

impl Pool {
    /// Starts a pool. `None` takes the size from `OPENRT_NUM_THREADS`, else from the number of processors that this
    /// process may use (affinity and cgroup limits included).
    ///
    /// # Errors
    /// The system refuses a thread; those already started are ended again.
    pub fn new(threads: Option<usize>) -> Result<Pool, ThreadError> {
        let wanted = threads.or_else(threads_from_environment).unwrap_or_else(available_processors);
        let threads = wanted.clamp(1, MAX_THREADS);
        let workers = Workers::start(threads)?;
        Ok(Pool { threads, workers: AtomicPtr::new(Box::into_raw(Box::new(workers))) })
    }

    /// Number of workers.
    pub fn threads(&self) -> usize {
        self.threads
    }

    /// Makes sure that this process has workers; only after a `fork()` is there anything to do.
    ///
    /// # Errors
    /// As [`Pool::new`].
    pub fn ensure(&self) -> Result<(), ThreadError> {
        self.workers().map(|_| ())
    }

    /// Runs `f` on a worker and waits for it; rayon calls inside use this pool. Panics of `f` continue in the caller.
    ///
    /// # Panics
    /// In a forked child that cannot start workers; call [`Pool::ensure`] first to get that as an error.
    pub fn install<R: Send>(&self, f: impl FnOnce() -> R + Send) -> R {
        let Workers { pool, door, .. } = self.present();
        // A worker would wait for itself.
        if pool.current_thread_index().is_some() { f() } else { door.lend(f, |f| pool.install(f)) }
    }

    /// Runs `job` on a worker some time soon.
    ///
    /// # Panics
    /// As [`Pool::install`].
    pub fn start(&self, job: Arc<dyn Job>) {
        self.present().door.put(Order::Job(job));
    }

    /// Runs `f` on a worker some time soon. A panic of `f` ends there.
    ///
    /// # Errors
    /// No memory for a copy of `f`.
    ///
    /// # Panics
    /// As [`Pool::install`].
    pub fn spawn(&self, f: impl FnOnce() + Send + 'static) -> Result<(), OutOfMemory> {
        self.present().door.put(Order::Once(boxed(f)?));
        Ok(())
    }

    fn present(&self) -> &Workers {
        self.workers().unwrap_or_else(|error| panic!("after fork: {error}"))
    }

    /// The workers of this process.
    fn workers(&self) -> Result<&Workers, ThreadError> {
        let found = self.workers.load(Ordering::Acquire);
        // SAFETY: the pointer came from Box::into_raw, and is freed only in `drop`, which has `&mut self`, or below by a
        // thread that never published it.
        let current = unsafe { &*found };
        if current.pid == std::process::id() {
            return Ok(current);
        }
        let fresh = Box::into_raw(Box::new(Workers::start(self.threads)?));
        match self.workers.compare_exchange(found, fresh, Ordering::AcqRel, Ordering::Acquire) {
            // SAFETY: `fresh` is published now and lives until `drop`. The parent's workers stay leaked.
            Ok(_) => Ok(unsafe { &*fresh }),
            Err(winner) => {
                // SAFETY: `fresh` was not published, so this thread owns it.
                drop(unsafe { Box::from_raw(fresh) });
                // SAFETY: as for `found`; another thread of this process published it.
                Ok(unsafe { &*winner })
            }
        }
    }
}

impl Drop for Pool {
    fn drop(&mut self) {
        let workers = *self.workers.get_mut();
        // SAFETY: never null, and `&mut self` proves that nobody else uses it.
        let same_process = unsafe { (*workers).pid } == std::process::id();
        if same_process {
            // SAFETY: it came from Box::into_raw, and this is the only place that frees a published one.
            unsafe { Box::from_raw(workers) }.end();
        }
        self.workers = AtomicPtr::new(ptr::null_mut());
    }
}

impl Workers {
    fn start(threads: usize) -> Result<Workers, ThreadError> {
        let no_memory = |error: OutOfMemory| ThreadError::new(threads, &error, true);
        let mut handles = vec_of(threads).map_err(no_memory)?;
        let gate = Gate::new(threads).map_err(no_memory)?;
        let builder = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            // Without a handler, a panicking job would abort the host. The panic hook has already reported it.
            .panic_handler(|_| {})
            .spawn_handler(|worker| {
                let name = format!("openrt-{}", worker.index());
                let way = gate.way();
                let body = move || {
                    float_environment::set_default();
                    if way.is_free() {
                        worker.run();
                    }
                };
                handles.push(spawn::spawn(&name, STACK_BYTES, body)?);
                io::Result::Ok(())
            });
        match behind(POOL_BYTES + threads * WORKER_BYTES, || builder.build()).map_err(no_memory)? {
            Ok(pool) => {
                if let Err(error) = gate.open() {
                    drop(pool);
                    handles.into_iter().for_each(Thread::join);
                    return Err(no_memory(error));
                }
                // Whoever looks for work the first time allocates; so each does it here.
                pool.broadcast(|_| ());
                let door = Arc::new(Door::new());
                let of_conductor = door.clone();
                pool.spawn(move || of_conductor.conduct());
                Ok(Workers { pid: std::process::id(), pool, door, handles: Mutex::new(handles) })
            }
            Err(error) => {
                gate.close();
                handles.into_iter().for_each(Thread::join);
                Err(ThreadError::new(threads, &error, is_out_of_memory(&error)))
            }
        }
    }

    /// Ends the workers after their jobs and waits for them; from a worker itself it cannot wait.
    fn end(self) {
        let Workers { pool, door, handles, .. } = self;
        let is_worker = pool.current_thread_index().is_some();
        door.close();
        drop(pool);
        if is_worker {
            return;
        }
        let handles = handles.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
        handles.into_iter().for_each(Thread::join);
    }
}

/// Whether an error is one of the system, which has no memory.
fn is_out_of_memory(error: &rayon::ThreadPoolBuildError) -> bool {
    let cause = std::error::Error::source(error).and_then(|cause| cause.downcast_ref::<io::Error>());
    cause.is_some_and(|cause| cause.kind() == io::ErrorKind::OutOfMemory)
}

/// Runs `f` on a thread of its own and waits for it; an inner error is the panic of `f`. For what needs more stack than an
/// application's thread may have, and must not wait for the pool.
///
/// # Errors
/// The system refuses a thread.
pub fn aside<R: Send>(f: impl FnOnce() -> R + Send) -> Result<std::thread::Result<R>, ThreadError> {
    let mut outcome = None;
    let place = &mut outcome;
    let body = move || {
        float_environment::set_default();
        *place = Some(catch_unwind(AssertUnwindSafe(f)));
    };
    // SAFETY: it is waited for before anything that it borrows ends.
    let thread = unsafe { spawn::spawn_unbounded("openrt-aside", ASIDE_STACK_BYTES, body) };
    thread.map_err(|error| ThreadError::new(1, &error, error.kind() == io::ErrorKind::OutOfMemory))?.join();
    Ok(outcome.expect("the thread has run to its end"))
}

fn threads_from_environment() -> Option<usize> {
    std::env::var("OPENRT_NUM_THREADS").ok()?.trim().parse().ok().filter(|&n| n > 0)
}

fn available_processors() -> usize {
    std::thread::available_parallelism().map_or(1, |n| n.get())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc;

    #[test]
    fn size_is_the_argument() {
        for n in [1, 2, 3, 7] {
            let pool = Pool::new(Some(n)).expect("threads");
            assert_eq!(pool.threads(), n);
            assert_eq!(pool.install(rayon::current_num_threads), n);
        }
        assert_eq!(Pool::new(Some(0)).expect("threads").threads(), 1);
    }

    #[test]
    fn panics_of_install_reach_the_caller_and_leave_the_pool_alive() {
        let pool = Pool::new(Some(2)).expect("threads");
        let caught = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| pool.install(|| panic!("on purpose"))));
        assert!(caught.is_err());
        pool.spawn(|| panic!("on purpose, in a spawned job")).expect("memory");
        let (send, receive) = mpsc::channel();
        pool.spawn(move || send.send(7).expect("receiver waits")).expect("memory");
        assert_eq!(receive.recv(), Ok(7));
    }

    #[test]
    fn drop_waits_for_spawned_jobs() {
        let (send, receive) = mpsc::channel();
        let pool = Pool::new(Some(1)).expect("threads");
        let spawned = pool.spawn(move || {
            std::thread::sleep(std::time::Duration::from_millis(20));
            send.send(()).expect("receiver waits");
        });
        spawned.expect("memory");
        drop(pool);
        assert!(receive.try_recv().is_ok());
    }

    #[test]
    fn many_threads_come_in_while_a_job_runs_and_all_have_their_turn() {
        struct Wait(Mutex<mpsc::Receiver<()>>);
        impl Job for Wait {
            fn run(&self) {
                let _ = self.0.lock().map(|receiver| receiver.recv());
            }
        }
        for threads in [1, 2, 3] {
            let pool = Pool::new(Some(threads)).expect("threads");
            let (send, receive) = mpsc::channel();
            pool.start(Arc::new(Wait(Mutex::new(receive))));
            let sum = std::thread::scope(|scope| {
                let ask = |i: u64| {
                    let pool = &pool;
                    move || {
                        (0..50)
                            .map(|k| pool.install(|| pool.install(|| rayon::join(|| i, || k))))
                            .map(|(i, k)| i * k)
                            .sum::<u64>()
                    }
                };
                // More than can wait at a time.
                let askers: Vec<_> = (0..100).map(|i| scope.spawn(ask(i))).collect();
                std::thread::sleep(std::time::Duration::from_millis(10));
                send.send(()).expect("the job waits");
                askers.into_iter().map(|asker| asker.join().expect("no panic")).sum::<u64>()
            });
            assert_eq!(sum, (0..100).sum::<u64>() * (0..50).sum::<u64>(), "{threads} threads");
        }
    }

    #[cfg(target_arch = "x86_64")]
    #[test]
    fn workers_do_not_inherit_flush_to_zero() {
        fn mxcsr() -> u32 {
            let mut value = 0u32;
            // SAFETY: stores MXCSR to a valid u32.
            unsafe { std::arch::asm!("stmxcsr [{0}]", in(reg) &raw mut value, options(nostack)) };
            value
        }
        fn set_mxcsr(value: u32) {
            // SAFETY: a valid control word; no float is computed before it is restored.
            unsafe { std::arch::asm!("ldmxcsr [{0}]", in(reg) &raw const value, options(nostack, readonly)) };
        }
        // A thread of its own: the test harness must keep its register.
        let (worker, caller) = std::thread::spawn(|| {
            set_mxcsr(0xffc0);
            let pool = Pool::new(Some(1)).expect("threads");
            let worker = pool.install(mxcsr);
            (worker, mxcsr())
        })
        .join()
        .expect("no panic");
        assert_eq!(worker & 0xffc0, 0x1f80, "worker: {worker:x}");
        assert_eq!(caller & 0xffc0, 0xffc0, "the caller's register was written: {caller:x}");
    }

    #[cfg(unix)]
    #[test]
    fn forked_child_gets_its_own_workers() {
        let pool = Pool::new(Some(2)).expect("threads");
        assert_eq!(pool.install(|| 1 + 1), 2);
        // SAFETY: the child calls only the pool and `_exit`; an alarm ends it if it hangs.
        let child = unsafe { libc::fork() };
        if child == 0 {
            // SAFETY: no memory involved.
            unsafe { libc::alarm(20) };
            let (a, b) = pool.install(|| rayon::join(|| 20, || 22));
            drop(pool);
            // SAFETY: ends the child without running the test harness's exit handlers.
            unsafe { libc::_exit(a + b) };
        }
        let mut status = 0;
        // SAFETY: `child` is our child and `status` a valid int.
        assert_eq!(unsafe { libc::waitpid(child, &raw mut status, 0) }, child);
        assert!(libc::WIFEXITED(status) && libc::WEXITSTATUS(status) == 42, "child status {status:x}");
    }
}
