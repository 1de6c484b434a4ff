//! Clocks, the floating-point mode of the peer, and interleaved rounds.
//!
//! * *One thread*: processor time of the thread, which other processes cannot lengthen (but for caches and clocks shared
//!   with them). *Several threads*: wall time, of the thread that took longest.
//! * A *pass* cuts the rays into chunks of [`CHUNK`]. For each, the lane first lays the rays out as its engine likes them best, then is timed.
//!   So neither engine pays for arranging rays, and both find theirs in the cache, as a renderer that has just made them does.
//! * *Rounds* go through all lanes in turn, so that a disturbance meets all alike; the best pass of each lane counts.
//! * Embree's lanes run with denormals flushed to zero, as its manual advises; ours in the default mode, as the library never touches it.

use crate::rays::Hits;
use openrt::trace::Ray;
use std::collections::HashMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// Rays that are laid out and then traced together, and what a thread takes at a time.
pub const CHUNK: usize = 4096;

/// One way of tracing, on one thread.
pub trait Worker {
    /// Lays the rays out. Not timed.
    fn load(&mut self, rays: &[Ray]);
    /// Traces what was laid out. Timed.
    fn trace(&mut self);
    /// How many of them hit. Not timed.
    fn hits(&self) -> usize;
}

/// Which figure a lane competes for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Column {
    OursSingle,
    OursMany,
    PeerSingle,
    PeerPacket,
    RobustSingle,
    RobustPacket,
}

impl Column {
    pub fn is_ours(self) -> bool {
        matches!(self, Column::OursSingle | Column::OursMany)
    }

    pub fn is_robust(self) -> bool {
        matches!(self, Column::RobustSingle | Column::RobustPacket)
    }

    pub fn is_peer(self) -> bool {
        matches!(self, Column::PeerSingle | Column::PeerPacket)
    }
}

/// A way of tracing, and how it did.
pub struct Lane<'a> {
    pub name: String,
    pub column: Column,
    make: Box<dyn Fn() -> Box<dyn Worker + 'a> + Sync + 'a>,
    /// Of the best pass; infinite before the first.
    pub seconds: f64,
    pub hits: Hits,
}

impl<'a> Lane<'a> {
    pub fn new(
        name: impl Into<String>,
        column: Column,
        make: impl Fn() -> Box<dyn Worker + 'a> + Sync + 'a,
    ) -> Lane<'a> {
        Lane { name: name.into(), column, make: Box::new(make), seconds: f64::INFINITY, hits: 0 }
    }

    /// Traces all rays once.
    fn pass(&mut self, rays: &[Ray], threads: usize) {
        let next = AtomicUsize::new(0);
        let flush = !self.column.is_ours();
        let clock = if threads == 1 { thread_seconds } else { wall_seconds };
        let work = || {
            let mut worker = (self.make)();
            let (mut seconds, mut hits) = (0.0, 0);
            loop {
                let begin = next.fetch_add(CHUNK, Ordering::Relaxed);
                if begin >= rays.len() {
                    return (seconds, hits);
                }
                worker.load(&rays[begin..rays.len().min(begin + CHUNK)]);
                let mode = flush.then(FlushToZero::set);
                let start = clock();
                worker.trace();
                seconds += clock() - start;
                drop(mode);
                hits += worker.hits();
            }
        };
        let results: Vec<(f64, usize)> = if threads == 1 {
            vec![work()]
        } else {
            std::thread::scope(|scope| {
                let handles: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
                handles.into_iter().map(|h| h.join().expect("a lane does not panic")).collect()
            })
        };
        let seconds = results.iter().fold(0.0, |most, r| r.0.max(most));
        self.hits = results.iter().map(|r| r.1).sum();
        self.seconds = self.seconds.min(seconds);
    }
}

/// Interleaved rounds over all lanes; the best of each stays in it.
pub fn race(lanes: &mut [Lane], rays: &[Ray], threads: usize, rounds: usize) {
    for _ in 0..rounds {
        for lane in &mut *lanes {
            lane.pass(rays, threads);
        }
    }
}

fn clock_seconds(clock: libc::clockid_t) -> f64 {
    let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: writes the time to a valid timespec.
    let answer = unsafe { libc::clock_gettime(clock, &raw mut time) };
    assert_eq!(answer, 0, "the clock exists");
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// Processor time of this thread.
pub fn thread_seconds() -> f64 {
    clock_seconds(libc::CLOCK_THREAD_CPUTIME_ID)
}

/// Processor time of all threads of this process.
fn process_seconds() -> f64 {
    clock_seconds(libc::CLOCK_PROCESS_CPUTIME_ID)
}

/// Processor times of the process's threads, by their number.
fn times_of_threads() -> HashMap<libc::pid_t, f64> {
    let tasks = std::fs::read_dir("/proc/self/task").into_iter().flatten().flatten();
    let numbers = tasks.filter_map(|task| task.file_name().to_str()?.parse().ok());
    // The clock of a thread, as pthread_getcpuclockid makes it up.
    numbers.map(|thread: libc::pid_t| (thread, clock_seconds((!thread << 3) | 6))).collect()
}

/// What a piece of work took.
#[derive(Clone, Copy, Debug)]
pub struct Cost {
    pub wall: f64,
    /// Processor time of the thread that worked most: the wall time there would have been had no other process wanted the
    /// processors, if the work begins and ends on one thread.
    pub busiest: f64,
    /// Processor time of all threads.
    pub all: f64,
}

impl Cost {
    /// Runs `f`.
    pub fn of<R>(f: impl FnOnce() -> R) -> (Cost, R) {
        let threads = times_of_threads();
        let (wall, all) = (wall_seconds(), process_seconds());
        let result = f();
        let (wall, all) = (wall_seconds() - wall, process_seconds() - all);
        let spent = |(thread, time): (libc::pid_t, f64)| time - threads.get(&thread).copied().unwrap_or(0.0);
        let busiest = times_of_threads().into_iter().map(spent).fold(0.0, f64::max);
        (Cost { wall, busiest, all }, result)
    }
}

/// Wall time since the first call.
pub fn wall_seconds() -> f64 {
    static START: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
    START.get_or_init(Instant::now).elapsed().as_secs_f64()
}

/// While it lives, this thread flushes denormals to zero, inputs and results. The mode before comes back after.
pub struct FlushToZero {
    before: u32,
}

impl FlushToZero {
    pub fn set() -> Self {
        let before = control();
        set_control(before | 0x8040);
        Self { before }
    }
}

impl Drop for FlushToZero {
    fn drop(&mut self) {
        set_control(self.before);
    }
}

#[cfg(target_arch = "x86_64")]
fn control() -> u32 {
    let mut value = 0u32;
    // SAFETY: stores MXCSR to a valid u32.
    unsafe { std::arch::asm!("stmxcsr [{0}]", in(reg) &raw mut value, options(nostack)) };
    value
}

#[cfg(target_arch = "x86_64")]
fn set_control(value: u32) {
    // SAFETY: a control word with exceptions masked, loaded from a valid u32; only the peer runs under it.
    unsafe { std::arch::asm!("ldmxcsr [{0}]", in(reg) &raw const value, options(nostack, readonly)) };
}

#[cfg(not(target_arch = "x86_64"))]
fn control() -> u32 {
    0
}

#[cfg(not(target_arch = "x86_64"))]
fn set_control(_: u32) {}
