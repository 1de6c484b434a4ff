//! The renderer of one context.

use super::desk::{self, Desks};
use super::error::RenderError;
use super::history::{History, Plan};
use super::passes::{Counts, Order, Passes};
use super::queries::{Meshes, Queries};
use super::scene_view::SceneView;
use super::tile::{TileJob, aspect};
use super::upsample::upsample;
use crate::accel::TwoLevel;
use crate::frame::{FrameStats, Framebuffer, Lattice, Target, TileGrid, TileRect};
use crate::memory::OutOfMemory;
use crate::scene::{FrameDesc, InstanceList, Mask, Resolved, Scene, Viewport};
use crate::shade::{Camera, Holes, MAX_LAYERS, ShadeMemory, ShadeScene, compile_camera};
use crate::simd::Level;
use crate::trace::{Hit, Ray, Tracer};
use glam::Vec2;
use std::collections::TryReserveError;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Renders frames of one scene, one after the other, and keeps what the next frame can use again: acceleration
/// structures, mip-map chains, and the picture.
///
/// The picture depends on nothing but the scene and the frame's description; not on threads, nor on the instruction
/// set. Only with a time budget does it depend on the time.
pub struct Renderer {
    world: TwoLevel,
    framebuffer: Framebuffer,
    /// Of the last sub-sampled frame, the pixels that were sampled.
    nodes: Framebuffer,
    shade: ShadeMemory,
    desks: Desks,
    order: Order,
    /// The instances of the last frame.
    resolved: Resolved,
    /// Camera and viewport of the last frame, for picking.
    view: (Camera, Viewport),
    history: History,
}

impl Renderer {
    /// `level` is the highest instruction set that the kernels may use.
    pub fn new(level: Level) -> Self {
        Self {
            world: TwoLevel::new(level),
            framebuffer: Framebuffer::default(),
            nodes: Framebuffer::default(),
            shade: ShadeMemory::default(),
            desks: Desks::default(),
            order: Order::default(),
            resolved: Resolved::default(),
            view: (Camera::default(), Viewport::default()),
            history: History::default(),
        }
    }

    /// Brings all structures up to date without rendering.
    ///
    /// # Errors
    /// No memory for a structure. Its object is not there for rays; the next commit tries again.
    pub fn commit(&mut self, scene: &Scene, frame: &FrameDesc) -> Result<FrameStats, RenderError> {
        let begin = Instant::now();
        self.shade.update(scene)?;
        self.view = (compile_camera(scene, frame, &self.shade.blocks), frame.viewport);
        self.world.choose_top_level(frame.top_level);
        self.resolved.resolve(scene, &frame.instances).map_err(|_| RenderError::Instances)?;
        let list = self.resolved.list(&frame.instances);
        let update = self.world.update_list(scene, list);
        if update.out_of_memory > 0 {
            return Err(RenderError::Structures { bytes: update.out_of_memory });
        }
        let seconds = begin.elapsed().as_secs_f64();
        Ok(FrameStats {
            update_seconds: seconds,
            top_level_seconds: update.top_level_seconds,
            total_seconds: seconds,
            instances: list.instances.len() as u64,
            triangles: update.triangles,
            objects_built: update.objects_built,
            objects_refitted: update.objects_refitted,
            objects_waiting: update.objects_waiting,
            objects_by_rays: update.objects_by_rays,
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
        let time_is_up = || frame.time_budget.is_some_and(|budget| begin.elapsed() >= budget);
        self.render_until(scene, frame, target, cancel, &time_is_up)
    }

    /// As [`Renderer::render`] by another clock: a frame with a budget is asked before each tile that it refines whether
    /// `time_is_up`.
    pub fn render_until(
        &mut self,
        scene: &Scene,
        frame: &FrameDesc,
        target: Option<&Target>,
        cancel: &AtomicBool,
        time_is_up: &(dyn Fn() -> bool + Sync),
    ) -> Result<FrameStats, RenderError> {
        let begin = Instant::now();
        // First, whatever else fails: structures must not stay behind the scene that rays are traced in.
        let mut stats = self.commit(scene, frame)?;
        let render_begin = Instant::now();
        let resolved = std::mem::take(&mut self.resolved);
        let (plan, shade_scene) = match self.begin(scene, frame, resolved.list(&frame.instances)) {
            Ok(begun) => begun,
            Err(error) => {
                self.resolved = resolved;
                self.history = History::default();
                return Err(error);
            }
        };
        let counts = self.pixels(&shade_scene, frame, &plan, target, cancel, time_is_up, &mut stats);
        shade_scene.end(&mut self.shade);
        self.resolved = resolved;
        self.history.ended(&plan, counts.skipped > 0);
        stats.render_seconds = render_begin.elapsed().as_secs_f64();
        // Shading included: then updates by rays are chosen too rarely, never too often.
        self.world.add_traced(stats.render_seconds);
        stats.total_seconds = begin.elapsed().as_secs_f64();
        stats.primary_rays = counts.rays.primary;
        stats.shadow_rays = counts.rays.shadow;
        stats.secondary_rays = counts.rays.secondary;
        stats.subsampling = plan.step;
        stats.cancelled = counts.skipped > 0;
        (stats.subtrees_touched, stats.nodes_touched) = self.world.touched();
        Ok(stats)
    }

    /// Plans the frame and gets all the memory that it needs; then its pixels come without fail.
    fn begin<'a>(
        &mut self,
        scene: &'a Scene,
        frame: &FrameDesc,
        list: InstanceList<'a>,
    ) -> Result<(Plan, ShadeScene<'a>), RenderError> {
        let plan = self.history.plan(scene.epoch, frame)?;
        let shade_scene = ShadeScene::new(scene, frame, list, &mut self.shade)?;
        desk::prepare(&mut self.desks, frame.samples, shade_scene.patches())?;
        self.make_room(frame, &plan)?;
        Ok((plan, shade_scene))
    }

    /// Makes the framebuffers as large as the frame needs, and empty if nothing in them can be gone on with. On an error the picture is what it was.
    fn make_room(&mut self, frame: &FrameDesc, plan: &Plan) -> Result<(), RenderError> {
        let [width, height] = frame.size;
        let mut stored = TileGrid { width, height };
        if plan.step > 1 {
            let [columns, rows] = Lattice::new(rect_of(frame.viewport), plan.step).nodes();
            self.nodes.resize(columns, rows)?;
            stored = self.nodes.grid();
        }
        if frame.time_budget.is_some() {
            self.order.prepare(stored.tile_count())?;
        }
        self.framebuffer.resize(width, height)?;
        if !plan.continues {
            // Also of tiles that a cancelled frame will not reach: what they hold belongs to another picture.
            self.framebuffer.tiles_mut().1.fill(0);
            self.nodes.tiles_mut().1.fill(0);
        }
        Ok(())
    }

    /// Traces and shades the tiles.
    #[expect(clippy::too_many_arguments, reason = "what a frame is made of")]
    fn pixels(
        &mut self,
        shade_scene: &ShadeScene<'_>,
        frame: &FrameDesc,
        plan: &Plan,
        target: Option<&Target>,
        cancel: &AtomicBool,
        time_is_up: &(dyn Fn() -> bool + Sync),
        stats: &mut FrameStats,
    ) -> Counts {
        let job = TileJob::new(shade_scene, Tracer::new(&self.world), frame, plan.step, cancel);
        let viewport = rect_of(frame.viewport);
        let sub_sampled = plan.step > 1;
        let (stored, wanted) = if sub_sampled {
            let whole = TileRect { x0: 0, y0: 0, x1: self.nodes.width(), y1: self.nodes.height() };
            (&mut self.nodes, whole)
        } else {
            (&mut self.framebuffer, viewport)
        };
        let target_of_tiles = target.filter(|_| !sub_sampled);
        let passes = Passes { wanted, turn: plan.turn, target: target_of_tiles, desks: &self.desks };
        // Where primary rays are all that is asked for, the first pass has done everything.
        let at_once = frame.time_budget.is_none() || !plan.continues && job.is_primary_only();
        let counts = if at_once {
            passes.all(stored, &job)
        } else {
            let mut counts = Counts::default();
            if plan.wants_primary {
                counts = passes.primary(stored, &job.primary_only());
            }
            counts.plus(passes.refine(stored, &job, &mut self.order, time_is_up))
        };
        stats.refined = passes.refined(stored);
        if sub_sampled && counts.skipped == 0 {
            let lattice = Lattice::new(viewport, plan.step);
            upsample(&self.nodes, &lattice, frame, &mut self.framebuffer, viewport, target);
        }
        counts
    }

    /// What can be asked about `scene`, to which nothing was done since the last [`Renderer::commit`] or [`Renderer::render`].
    pub fn queries<'a>(&'a self, scene: &'a Scene) -> Queries<'a> {
        Queries::new(Tracer::new(&self.world), Meshes::Scene(scene))
    }

    /// A snapshot of the same.
    ///
    /// # Errors
    /// No memory.
    pub fn snapshot(&self, scene: &Scene) -> Result<SceneView, TryReserveError> {
        SceneView::new(self.world.view(), scene)
    }

    /// Says how long rays of [`Renderer::queries`] have taken, see [`TwoLevel::add_traced`].
    pub fn add_traced(&self, seconds: f64) {
        self.world.add_traced(seconds);
    }

    /// The picture of the last frame.
    pub fn framebuffer(&self) -> &Framebuffer {
        &self.framebuffer
    }

    /// What the last frame's camera sees at (`x`, `y`), in pixels of the framebuffer from its lower left corner; the
    /// centre of the first pixel is (0.5, 0.5). Holes of cut-out surfaces are looked through. None outside the
    /// viewport and where nothing is hit.
    ///
    /// # Errors
    /// No memory.
    pub fn pick(&self, scene: &Scene, x: f32, y: f32) -> Result<Option<Hit>, OutOfMemory> {
        let (camera, viewport) = &self.view;
        let size = Vec2::new(viewport.width as f32, viewport.height as f32);
        let screen = (Vec2::new(x, y) - Vec2::new(viewport.x as f32, viewport.y as f32)) / size;
        // Written so that NaN fails.
        if !(screen.cmpge(Vec2::ZERO).all() && screen.cmplt(Vec2::ONE).all()) {
            return Ok(None);
        }
        let Some(ray) = camera.primary_ray(screen, aspect(*viewport), Vec2::splat(0.5)) else { return Ok(None) };
        let mut ray = Ray::new(ray.origin, ray.direction);
        let tracer = Tracer::new(&self.world).masked(Mask::CAMERA);
        let mut holes = Holes::new(scene, &self.shade);
        for _ in 0..MAX_LAYERS {
            let Some(hit) = tracer.intersect(&ray) else { return Ok(None) };
            if !holes.is_hole(&ray, &hit)? {
                return Ok(Some(Hit { instance: self.world.number_of(hit.instance), ..hit }));
            }
            ray.tmin = hit.t.next_up();
        }
        Ok(None)
    }
}

fn rect_of(viewport: Viewport) -> TileRect {
    let Viewport { x, y, width, height } = viewport;
    TileRect { x0: x, y0: y, x1: x.saturating_add(width), y1: y.saturating_add(height) }
}
