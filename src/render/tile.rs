//! One tile: camera samples to pixels.

use crate::frame::{NO_INSTANCE, Pixel, TILE_SIZE, TileRect};
use crate::scene::{FrameDesc, Viewport};
use crate::shade::{Cone, RayCounts, Rng, Seen, ShadeScene, Worker, pixel_pattern};
use crate::trace::Tracer;
use glam::{Vec2, Vec4};

/// What all tiles of a frame share.
pub struct TileJob<'a> {
    pub scene: &'a ShadeScene<'a>,
    pub tracer: Tracer<'a>,
    pub frame: &'a FrameDesc,
    pub aspect: f32,
    pub cone: Cone,
}

impl<'a> TileJob<'a> {
    pub fn new(scene: &'a ShadeScene<'a>, tracer: Tracer<'a>, frame: &'a FrameDesc) -> Self {
        let aspect = aspect(frame.viewport);
        // Samples share a pixel's footprint.
        let rows = frame.viewport.height.max(1) as f32 * (frame.samples.max(1) as f32).sqrt();
        let cone = scene.camera.cone(rows, aspect);
        Self { scene, tracer, frame, aspect, cone }
    }

    /// Renders the pixels of `visible`, a part of the tile at `origin`. `rounds` frames are already averaged in the
    /// tile; 0 overwrites it.
    pub fn render(&self, origin: [u32; 2], visible: TileRect, rounds: u32, pixels: &mut [Pixel]) -> RayCounts {
        let mut worker = Worker::new(self.scene, self.tracer);
        let samples = self.frame.samples.max(1);
        let pattern = pixel_pattern(samples, rounds);
        for y in visible.y0..visible.y1 {
            for x in visible.x0..visible.x1 {
                let pixel = &mut pixels[((y - origin[1]) * TILE_SIZE + x - origin[0]) as usize];
                let (color, seen) = self.pixel(&mut worker, x, y, rounds, &pattern);
                let color = if rounds == 0 {
                    color
                } else {
                    let before = Vec4::from_array(pixel.color);
                    before + (color - before) / (rounds as f32 + 1.0)
                };
                *pixel = finish(color, seen);
            }
        }
        worker.counts
    }

    /// The mean of a pixel's samples, and what its first sample saw.
    fn pixel(&self, worker: &mut Worker, x: u32, y: u32, rounds: u32, pattern: &[Vec2]) -> (Vec4, Option<Seen>) {
        let viewport = self.frame.viewport;
        let size = Vec2::new(viewport.width as f32, viewport.height as f32);
        let corner = Vec2::new((x - viewport.x) as f32, (y - viewport.y) as f32);
        let count = pattern.len() as u32;
        let mut sum = Vec4::ZERO;
        let mut seen = None;
        for (i, offset) in (0..).zip(pattern) {
            // The lens takes its points before the sample's own choices.
            let mut rng = Rng::new(x, y, rounds.wrapping_mul(count).wrapping_add(i));
            let lens = rng.next_vec2();
            match self.scene.camera.primary_ray((corner + *offset) / size, self.aspect, lens) {
                Some(ray) => {
                    let sample = worker.sample(ray, self.cone, rng);
                    sum += sample.color;
                    if i == 0 {
                        seen = sample.seen;
                    }
                }
                None => sum += Vec4::from_array(self.frame.clear_color),
            }
        }
        (sum / count as f32, seen)
    }
}

/// Width over height of a viewport.
pub fn aspect(viewport: Viewport) -> f32 {
    viewport.width.max(1) as f32 / viewport.height.max(1) as f32
}

fn finish(color: Vec4, seen: Option<Seen>) -> Pixel {
    match seen {
        Some(seen) => Pixel {
            color: color.to_array(),
            depth: seen.distance,
            normal: seen.normal.to_array(),
            object: seen.object,
            instance: seen.instance,
        },
        None => Pixel { color: color.to_array(), instance: NO_INSTANCE, ..Pixel::EMPTY },
    }
}
