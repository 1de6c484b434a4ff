//! What a run says: a line for each frame and a summary, as text or as one JSON object.

use openrt::api::FrameStats;
use serde_json::{Value, json};
use std::time::Duration;

/// Who is told, and how.
#[derive(Clone, Copy)]
pub struct Voice {
    pub quiet: bool,
    /// The only thing on the standard output is an object at the end.
    pub json: bool,
    /// The standard output is taken by pictures.
    pub aside: bool,
}

impl Voice {
    /// Whether lines of text are wanted.
    pub fn speaks(self) -> bool {
        !self.quiet && !self.json
    }

    pub fn say(self, text: &str) {
        match (self.speaks(), self.aside) {
            (false, _) => {}
            (true, false) => println!("{text}"),
            (true, true) => eprintln!("{text}"),
        }
    }
}

/// What each frame cost.
#[derive(Default)]
pub struct Report {
    frames: Vec<(u32, f64, FrameStats)>,
}

fn rays(stats: &FrameStats) -> u64 {
    stats.primary_rays + stats.shadow_rays + stats.secondary_rays
}

/// The line of one frame.
pub fn line(frame: u32, time: f64, stats: &FrameStats) -> String {
    let rate = rays(stats) as f64 / stats.render_seconds.max(1e-9) / 1e6;
    let refined =
        if stats.refined < 1.0 { format!("  {:3.0} % refined", stats.refined * 100.0) } else { String::new() };
    format!(
        "frame {frame:5}  time {time:8.3} s  update {:8.2} ms  render {:9.2} ms  {:10} rays  {rate:7.2} Mrays/s{refined}",
        stats.update_seconds * 1e3,
        stats.render_seconds * 1e3,
        rays(stats),
    )
}

/// Sums over the frames of a run; times in seconds.
struct Summary {
    frames: usize,
    elapsed: f64,
    frames_per_second: f64,
    median: f64,
    slowest: f64,
    update: f64,
    render: f64,
    rays: u64,
    rays_per_second: f64,
}

impl Report {
    pub fn add(&mut self, frame: u32, time: f64, stats: FrameStats) {
        self.frames.push((frame, time, stats));
    }

    fn summary(&self, elapsed: Duration) -> Summary {
        let n = self.frames.len();
        let sum = |of: fn(&FrameStats) -> f64| self.frames.iter().map(|(.., stats)| of(stats)).sum::<f64>();
        let mut totals: Vec<f64> = self.frames.iter().map(|(.., stats)| stats.total_seconds).collect();
        totals.sort_by(f64::total_cmp);
        let render = sum(|s| s.render_seconds);
        let rays = self.frames.iter().map(|(.., stats)| rays(stats)).sum();
        Summary {
            frames: n,
            elapsed: elapsed.as_secs_f64(),
            frames_per_second: n as f64 / elapsed.as_secs_f64().max(1e-9),
            median: median(&totals),
            slowest: totals.last().copied().unwrap_or(0.0),
            update: sum(|s| s.update_seconds) / n.max(1) as f64,
            render: render / n.max(1) as f64,
            rays,
            rays_per_second: rays as f64 / render.max(1e-9),
        }
    }

    /// The summary in two lines. `written` is what the pictures are called.
    pub fn text(&self, elapsed: Duration, written: &str) -> String {
        let s = self.summary(elapsed);
        format!(
            "{} frames in {:.2} s, {:.2} frames per second; a frame took {:.2} ms (median; slowest {:.2} ms): update {:.2} ms, \
             render {:.2} ms (means), {} rays, {:.2} Mrays/s\nwritten to {written}",
            s.frames,
            s.elapsed,
            s.frames_per_second,
            s.median * 1e3,
            s.slowest * 1e3,
            s.update * 1e3,
            s.render * 1e3,
            s.rays,
            s.rays_per_second / 1e6,
        )
    }

    /// Everything, with `about`, an object that tells of the scene. Times of frames are in milliseconds.
    pub fn json(&self, mut about: Value, elapsed: Duration, written: &str) -> Value {
        let s = self.summary(elapsed);
        let frames: Vec<Value> = self
            .frames
            .iter()
            .map(|(frame, time, stats)| {
                json!({
                    "frame": frame,
                    "time": time,
                    "update_ms": stats.update_seconds * 1e3,
                    "render_ms": stats.render_seconds * 1e3,
                    "total_ms": stats.total_seconds * 1e3,
                    "primary_rays": stats.primary_rays,
                    "shadow_rays": stats.shadow_rays,
                    "secondary_rays": stats.secondary_rays,
                    "instances": stats.instances,
                    "triangles": stats.triangles,
                    "structure_bytes": stats.structure_bytes,
                    "refined": stats.refined,
                })
            })
            .collect();
        about["written"] = json!(written);
        about["frames"] = json!(frames);
        about["summary"] = json!({
            "frames": s.frames,
            "seconds": s.elapsed,
            "frames_per_second": s.frames_per_second,
            "median_ms": s.median * 1e3,
            "slowest_ms": s.slowest * 1e3,
            "mean_update_ms": s.update * 1e3,
            "mean_render_ms": s.render * 1e3,
            "rays": s.rays,
            "rays_per_second": s.rays_per_second,
        });
        about
    }
}

/// Of sorted numbers; of an even number of them the mean of the middle two.
fn median(sorted: &[f64]) -> f64 {
    match sorted.len() {
        0 => 0.0,
        n if n % 2 == 1 => sorted[n / 2],
        n => (sorted[n / 2 - 1] + sorted[n / 2]) / 2.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn summaries() {
        let mut report = Report::default();
        for (frame, total) in [(0, 0.4), (1, 0.1), (2, 0.2), (3, 0.1)] {
            let stats = FrameStats { total_seconds: total, render_seconds: total / 2.0, ..FrameStats::default() };
            report.add(frame, 0.0, FrameStats { primary_rays: 1000, shadow_rays: 500, ..stats });
        }
        let s = report.summary(Duration::from_secs(2));
        assert_eq!((s.frames, s.frames_per_second, s.rays), (4, 2.0, 6000));
        assert!((s.median - 0.15).abs() < 1e-12 && s.slowest == 0.4 && (s.render - 0.1).abs() < 1e-12);
        let text = report.text(Duration::from_secs(2), "f%04d.png");
        assert!(text.contains("4 frames in 2.00 s, 2.00 frames per second") && text.contains("150.00 ms (median"));
        assert_eq!(median(&[]), 0.0);
        assert_eq!(median(&[3.0]), 3.0);
    }
}
