//! How far a run has come, for those who watch: pixels are counted as they are delivered.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use openrt::api::{PixelFormat, PixelSink, Target, TargetLayout};
use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Work that ends sooner shows no bar.
const PATIENCE: Duration = Duration::from_millis(400);

pub struct Progress {
    /// None where nobody watches.
    bar: Option<ProgressBar>,
    begin: Instant,
    frames: u64,
    pixels: u64,
    delivered: Arc<Counter>,
}

/// Counts the pixels of a frame.
struct Counter(AtomicU64);

const FORMAT: PixelFormat = PixelFormat::Rgb8;

impl PixelSink for Counter {
    fn write(&self, _offset: usize, bytes: &[u8]) {
        self.0.fetch_add((bytes.len() / FORMAT.bytes_per_pixel()) as u64, Ordering::Relaxed);
    }
}

impl Progress {
    pub fn new(frames: u64, (width, height): (u32, u32), quiet: bool) -> Self {
        let pixels = u64::from(width) * u64::from(height);
        let bar = (!quiet && std::io::stderr().is_terminal()).then(|| {
            let bar = ProgressBar::with_draw_target(Some(frames * pixels), ProgressDrawTarget::hidden());
            let style = ProgressStyle::with_template("{bar:40} {percent:>3} %  {msg}, {elapsed} elapsed, {eta} to go");
            bar.with_style(style.expect("the template is well formed"))
        });
        Self { bar, begin: Instant::now(), frames, pixels, delivered: Arc::new(Counter(AtomicU64::new(0))) }
    }

    /// What frames are to be delivered to, so that their pixels can be counted.
    pub fn target(&self, (width, height): (u32, u32)) -> Option<Target> {
        self.bar.as_ref()?;
        let stride = width as usize * FORMAT.bytes_per_pixel();
        let layout = TargetLayout { width, height, format: FORMAT, stride, origin_top_left: true };
        Some(Target { layout, sink: self.delivered.clone() })
    }

    /// A frame begins.
    pub fn begin_frame(&self) {
        self.delivered.0.store(0, Ordering::Relaxed);
    }

    /// How often [`Progress::show`] is to be called while frame number `done` (from 0) renders.
    pub fn interval(&self) -> Option<Duration> {
        self.bar.as_ref().map(|_| Duration::from_millis(100))
    }

    /// Draws the bar while the frame after `done` others renders.
    pub fn show(&self, done: u64) {
        let Some(bar) = &self.bar else { return };
        if self.begin.elapsed() < PATIENCE {
            return;
        }
        if bar.is_hidden() {
            bar.set_draw_target(ProgressDrawTarget::stderr());
        }
        // A frame with a time budget delivers pixels twice.
        let part = self.delivered.0.load(Ordering::Relaxed).min(self.pixels);
        bar.set_message(format!("frame {} of {}", (done + 1).min(self.frames), self.frames));
        bar.set_position(done * self.pixels + part);
    }

    /// Does something that writes to the terminal.
    pub fn aside(&self, print: impl FnOnce()) {
        match &self.bar {
            Some(bar) => bar.suspend(print),
            None => print(),
        }
    }

    pub fn end(self) {
        if let Some(bar) = self.bar {
            bar.finish_and_clear();
        }
    }
}
