//! One tile: camera samples to pixels.
//!
//! All rays of a tile (one per pixel at a time) are made first and traced as a batch, in an order in which any aligned run of 8, 16 or 64
//! is a compact part of the picture: by 8×8 quads, 4×4 blocks and 4×2 halves.

use crate::frame::{NO_INSTANCE, Pixel, TILE_PIXELS, TILE_SIZE, TileRect};
use crate::scene::{FrameDesc, Viewport};
use crate::shade::{CameraSample, Cone, RayCounts, Seen, ShadeScene, Worker, pixel_pattern};
use crate::trace::{Ray, Tracer};
use glam::{Vec2, Vec4};

/// What all tiles of a frame share.
pub struct TileJob<'a> {
    pub scene: &'a ShadeScene<'a>,
    pub tracer: Tracer<'a>,
    pub frame: &'a FrameDesc,
    pub aspect: f32,
    pub cone: Cone,
}

/// What a thread needs from tile to tile.
pub struct TileWorker<'a> {
    worker: Worker<'a>,
    samples: Vec<CameraSample>,
    /// Places in the tile of the samples.
    places: Vec<u16>,
    sums: Vec<Vec4>,
    seen: Vec<Option<Seen>>,
}

impl<'a> TileJob<'a> {
    pub fn new(scene: &'a ShadeScene<'a>, tracer: Tracer<'a>, frame: &'a FrameDesc) -> Self {
        let aspect = aspect(frame.viewport);
        // Samples share a pixel's footprint.
        let rows = frame.viewport.height.max(1) as f32 * (frame.samples.max(1) as f32).sqrt();
        let cone = scene.camera.cone(rows, aspect);
        Self { scene, tracer, frame, aspect, cone }
    }

    /// What one thread works with.
    pub fn worker(&self) -> TileWorker<'a> {
        TileWorker {
            worker: Worker::new(self.scene, self.tracer),
            samples: Vec::with_capacity(TILE_PIXELS),
            places: Vec::with_capacity(TILE_PIXELS),
            sums: vec![Vec4::ZERO; TILE_PIXELS],
            seen: vec![None; TILE_PIXELS],
        }
    }

    /// Renders the pixels of `visible`, a part of the tile at `origin`. `rounds` frames are already averaged in the
    /// tile; 0 overwrites it.
    pub fn render(
        &self,
        worker: &mut TileWorker<'a>,
        origin: [u32; 2],
        visible: TileRect,
        rounds: u32,
        pixels: &mut [Pixel],
    ) -> RayCounts {
        let TileWorker { worker, samples, places, sums, seen } = worker;
        worker.counts = RayCounts::default();
        sums.fill(Vec4::ZERO);
        seen.fill(None);
        let pattern = pixel_pattern(self.frame.samples.max(1), rounds);
        for (i, &offset) in pattern.iter().enumerate() {
            self.camera_rays(origin, visible, rounds, (i as u32, pattern.len() as u32), offset, samples, places, sums);
            worker.samples(samples, self.cone, |number, sample| {
                let place = usize::from(places[number]);
                sums[place] += sample.color;
                if i == 0 {
                    seen[place] = sample.seen;
                }
            });
        }
        for y in visible.y0..visible.y1 {
            for x in visible.x0..visible.x1 {
                let place = ((y - origin[1]) * TILE_SIZE + x - origin[0]) as usize;
                let pixel = &mut pixels[place];
                let color = sums[place] / pattern.len() as f32;
                let color = if rounds == 0 {
                    color
                } else {
                    let before = Vec4::from_array(pixel.color);
                    before + (color - before) / (rounds as f32 + 1.0)
                };
                *pixel = finish(color, seen[place]);
            }
        }
        worker.counts
    }

    /// Sample `i` of `count` of all visible pixels; those that the camera leaves clear get their colour at once.
    #[allow(clippy::too_many_arguments, reason = "the fields of a worker, borrowed apart")]
    fn camera_rays(
        &self,
        origin: [u32; 2],
        visible: TileRect,
        rounds: u32,
        (i, count): (u32, u32),
        offset: Vec2,
        samples: &mut Vec<CameraSample>,
        places: &mut Vec<u16>,
        sums: &mut [Vec4],
    ) {
        let viewport = self.frame.viewport;
        let size = Vec2::new(viewport.width as f32, viewport.height as f32);
        let number = rounds.wrapping_mul(count).wrapping_add(i);
        let has_lens = self.scene.camera.has_lens();
        samples.clear();
        places.clear();
        for place in PLACES {
            let (x, y) = (origin[0] + u32::from(place) % TILE_SIZE, origin[1] + u32::from(place) / TILE_SIZE);
            if x < visible.x0 || x >= visible.x1 || y < visible.y0 || y >= visible.y1 {
                continue;
            }
            let corner = Vec2::new((x - viewport.x) as f32, (y - viewport.y) as f32);
            let lens = if has_lens { CameraSample::lens([x, y], number) } else { Vec2::ZERO };
            match self.scene.camera.primary_ray((corner + offset) / size, self.aspect, lens) {
                Some(ray) => {
                    samples.push(CameraSample { ray: Ray::new(ray.origin, ray.direction), pixel: [x, y], number });
                    places.push(place);
                }
                None => sums[usize::from(place)] += Vec4::from_array(self.frame.clear_color),
            }
        }
    }
}

/// The pixels of a tile in the order of their rays.
const PLACES: [u16; TILE_PIXELS] = {
    let mut places = [0; TILE_PIXELS];
    let mut i = 0;
    while i < TILE_PIXELS {
        let (quad, block, half, pixel) = (i >> 6, i >> 4 & 3, i >> 3 & 1, i & 7);
        let x = (quad & 1) * 8 + (block & 1) * 4 + (pixel & 3);
        let y = (quad >> 1) * 8 + (block >> 1) * 4 + half * 2 + (pixel >> 2);
        places[i] = (y * TILE_SIZE as usize + x) as u16;
        i += 1;
    }
    places
};

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
