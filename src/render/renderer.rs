//! The renderer of one context.

use super::error::RenderError;
use super::tile::{TileJob, TileWorker, aspect};
use super::upsample::upsample;
use crate::accel::TwoLevel;
use crate::frame::{FrameStats, Framebuffer, Lattice, TILE_PIXELS, Target, TileRect};
use crate::scene::{FrameDesc, Scene, Viewport};
use crate::shade::{Camera, Holes, MAX_LAYERS, RayCounts, ShadeScene, SurfaceUse, TextureCache, compile_camera};
use crate::simd::Level;
use crate::trace::{Hit, Ray, Tracer};
use glam::Vec2;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Renders frames of one scene, one after the other, and keeps what the next frame can use again: acceleration
/// structures, mip-map chains, and the picture.
///
/// The picture depends on nothing but the scene and the frame's description; not on threads, nor on the instruction
/// set.
pub struct Renderer {
    world: TwoLevel,
    framebuffer: Framebuffer,
    /// Of the last sub-sampled frame, the pixels that were sampled.
    nodes: Framebuffer,
    textures: TextureCache,
    surfaces: SurfaceUse,
    /// Camera and viewport of the last frame, for picking.
    view: (Camera, Viewport),
    /// What the tiles' averages belong to.
    history: Option<(u64, FrameDesc)>,
}

impl Renderer {
    /// `level` is the highest instruction set that the kernels may use.
    pub fn new(level: Level) -> Self {
        Self {
            world: TwoLevel::new(level),
            framebuffer: Framebuffer::default(),
            nodes: Framebuffer::default(),
            textures: TextureCache::default(),
            surfaces: SurfaceUse::default(),
            view: (Camera::default(), Viewport::default()),
            history: None,
        }
    }

    /// Brings all structures up to date without rendering.
    ///
    /// # Errors
    /// No memory for a structure. Its object is not there for rays; the next commit tries again.
    pub fn commit(&mut self, scene: &Scene, frame: &FrameDesc) -> Result<FrameStats, RenderError> {
        let begin = Instant::now();
        self.view = (compile_camera(scene, frame), frame.viewport);
        self.textures.update(scene);
        self.world.choose_top_level(frame.top_level);
        let update = self.world.update(scene, &frame.instances);
        if update.out_of_memory > 0 {
            return Err(RenderError::Structures { bytes: update.out_of_memory });
        }
        let seconds = begin.elapsed().as_secs_f64();
        Ok(FrameStats {
            update_seconds: seconds,
            top_level_seconds: update.top_level_seconds,
            total_seconds: seconds,
            instances: frame.instances.len() as u64,
            triangles: update.triangles,
            objects_built: update.objects_built,
            objects_refitted: update.objects_refitted,
            nodes_updated: update.nodes_updated,
            structure_bytes: update.bytes,
            merged_instances: update.merged_instances,
            ..FrameStats::default()
        })
    }

    /// Renders a frame into the framebuffer, and tile by tile into `target`. Call it inside the pool that shall do
    /// the work.
    ///
    /// When `cancel` becomes true, tiles not yet begun keep what they showed before, and the statistics say so; a sub-sampled
    /// frame then leaves the whole picture as it was. On an error nothing was rendered.
    pub fn render(
        &mut self,
        scene: &Scene,
        frame: &FrameDesc,
        target: Option<&Target>,
        cancel: &AtomicBool,
    ) -> Result<FrameStats, RenderError> {
        let begin = Instant::now();
        // First, whatever else fails: structures must not stay behind the scene that rays are traced in.
        let mut stats = self.commit(scene, frame)?;
        self.framebuffer.resize(frame.size[0], frame.size[1])?;
        let Viewport { x, y, width, height } = frame.viewport;
        let viewport = TileRect { x0: x, y0: y, x1: x.saturating_add(width), y1: y.saturating_add(height) };
        let lattice = Some(Lattice::new(viewport, frame.subsampling)).filter(|lattice| lattice.step() > 1);
        if let Some(lattice) = lattice {
            let [columns, rows] = lattice.nodes();
            self.nodes.resize(columns, rows)?;
        }

        let render_begin = Instant::now();
        let continues = frame.accumulate
            && self.history.as_ref().is_some_and(|(epoch, last)| *epoch == scene.epoch && same_picture(last, frame));
        if !continues {
            // Also of tiles that a cancelled frame will not reach: what they hold belongs to another picture.
            self.framebuffer.tiles_mut().1.fill(0);
            self.nodes.tiles_mut().1.fill(0);
            self.history = frame.accumulate.then(|| (scene.epoch, frame.clone()));
        }
        let shade_scene = ShadeScene::new(scene, frame, &self.textures, &mut self.surfaces);
        let job = TileJob::new(&shade_scene, Tracer::new(&self.world), frame, frame.subsampling);
        let counts = match lattice {
            None => render_tiles(&mut self.framebuffer, &job, viewport, target, cancel),
            Some(lattice) => {
                let whole = TileRect { x0: 0, y0: 0, x1: self.nodes.width(), y1: self.nodes.height() };
                let counts = render_tiles(&mut self.nodes, &job, whole, None, cancel);
                if counts.skipped == 0 {
                    upsample(&self.nodes, &lattice, frame, &mut self.framebuffer, viewport, target);
                }
                counts
            }
        };
        stats.render_seconds = render_begin.elapsed().as_secs_f64();
        stats.total_seconds = begin.elapsed().as_secs_f64();
        stats.primary_rays = counts.rays.primary;
        stats.shadow_rays = counts.rays.shadow;
        stats.secondary_rays = counts.rays.secondary;
        stats.cancelled = counts.skipped > 0;
        (stats.subtrees_touched, stats.nodes_touched) = self.world.touched();
        Ok(stats)
    }

    /// Queries against the structures of the last [`Renderer::commit`] or [`Renderer::render`].
    pub fn tracer(&self) -> Tracer<'_> {
        Tracer::new(&self.world)
    }

    /// The picture of the last frame.
    pub fn framebuffer(&self) -> &Framebuffer {
        &self.framebuffer
    }

    /// What the last frame's camera sees at (`x`, `y`), in pixels of the framebuffer from its lower left corner; the
    /// centre of the first pixel is (0.5, 0.5). Holes of cut-out surfaces are looked through. None outside the
    /// viewport and where nothing is hit.
    pub fn pick(&self, scene: &Scene, x: f32, y: f32) -> Option<Hit> {
        let (camera, viewport) = &self.view;
        let size = Vec2::new(viewport.width as f32, viewport.height as f32);
        let screen = (Vec2::new(x, y) - Vec2::new(viewport.x as f32, viewport.y as f32)) / size;
        // Written so that NaN fails.
        if !(screen.cmpge(Vec2::ZERO).all() && screen.cmplt(Vec2::ONE).all()) {
            return None;
        }
        let ray = camera.primary_ray(screen, aspect(*viewport), Vec2::splat(0.5))?;
        let mut ray = Ray::new(ray.origin, ray.direction);
        let holes = Holes::new(scene, &self.textures);
        for _ in 0..MAX_LAYERS {
            let hit = self.tracer().intersect(&ray)?;
            if !holes.is_hole(&ray, &hit) {
                return Some(hit);
            }
            ray.tmin = hit.t.next_up();
        }
        None
    }
}

#[derive(Clone, Copy, Default)]
struct Counts {
    rays: RayCounts,
    /// Tiles left out because the frame was cancelled.
    skipped: u64,
}

impl Counts {
    fn plus(self, other: Self) -> Self {
        Self {
            rays: RayCounts {
                primary: self.rays.primary + other.rays.primary,
                shadow: self.rays.shadow + other.rays.shadow,
                secondary: self.rays.secondary + other.rays.secondary,
            },
            skipped: self.skipped + other.skipped,
        }
    }
}

/// Renders the part of `fb` that is in `wanted`.
fn render_tiles<'a>(
    fb: &mut Framebuffer,
    job: &TileJob<'a>,
    wanted: TileRect,
    target: Option<&Target>,
    cancel: &AtomicBool,
) -> Counts {
    let grid = fb.grid();
    let (pixels, rounds) = fb.tiles_mut();
    let one = |worker: &mut TileWorker<'a>, (index, (pixels, rounds)): (usize, (&mut [_], &mut u32))| {
        let rect = grid.rect(index);
        let visible = rect.intersection(wanted);
        if visible.is_empty() {
            return Counts::default();
        }
        if cancel.load(Ordering::Relaxed) {
            return Counts { skipped: 1, ..Counts::default() };
        }
        let rays = job.render(worker, [rect.x0, rect.y0], visible, *rounds, pixels);
        *rounds = rounds.saturating_add(1);
        if let Some(target) = target {
            let color = |x, y| pixels[((y - rect.y0) * crate::frame::TILE_SIZE + x - rect.x0) as usize].color;
            target.write_rect(visible, job.frame.srgb, color);
        }
        Counts { rays, skipped: 0 }
    };
    pixels
        .par_chunks_mut(TILE_PIXELS)
        .zip(rounds.par_iter_mut())
        .enumerate()
        .map_init(|| job.worker(), one)
        .reduce(Counts::default, Counts::plus)
}

/// Whether two frames of an unchanged scene show the same, so that their samples may be averaged.
fn same_picture(a: &FrameDesc, b: &FrameDesc) -> bool {
    let settings = |f: &FrameDesc| {
        (f.camera, f.environment, f.renderer, f.clear_color, f.size, f.viewport, f.samples, f.max_depth, f.subsampling)
    };
    let same = |(a, b): (&crate::scene::Instance, &crate::scene::Instance)| {
        a.object == b.object && a.world_from_object == b.world_from_object
    };
    settings(a) == settings(b)
        && a.lights == b.lights
        && a.instances.len() == b.instances.len()
        && a.instances.iter().zip(&b.instances).all(same)
}
