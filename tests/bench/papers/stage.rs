//! A scene in a [`Context`], as an application holds it: frames are put together and rendered whole, or tile by tile.
//!
//! A tile is rendered as a frame of its own, whose frustum is that part of the picture's: its time is what a client of a cluster would need for it.

use crate::measure::Cost;
use crate::rays::View;
use crate::scenes::BenchScene;
use glam::{DMat4, DVec3, Vec3};
use openrt::Context;
use openrt::api::{Config, FrameStats, Mode, Motion, Name, Result, TriangleMesh};

/// Width, height and the side of a tile, in pixels: of the paper's picture, and of one for quick runs, which has a quarter of the tiles.
pub const PAPER: [u32; 3] = [640, 480, 16];
pub const QUICK: [u32; 3] = [320, 240, 16];

/// Where the camera is, with +y of the picture along `up`.
#[derive(Clone, Copy, Debug)]
pub struct Eye {
    pub from: DVec3,
    pub at: DVec3,
    pub up: DVec3,
    /// Of the vertical field of view.
    pub degrees: f64,
}

impl From<&View> for Eye {
    fn from(view: &View) -> Eye {
        let [from, at] = [view.eye, view.at].map(Vec3::as_dvec3);
        Eye { from, at, up: DVec3::Y, degrees: f64::from(view.degrees) }
    }
}

/// Puts the instances and lights of a frame into the context, and moves vertices; gives the camera.
type Assemble = Box<dyn FnMut(&mut Context, u32) -> Result<Eye>>;

pub struct Stage {
    pub context: Context,
    assemble: Assemble,
    /// Shaders of the two rendering objects.
    renderers: [Name; 2],
    size: [u32; 3],
    /// Bytes of what changes from frame to frame and has to be sent: matrices and vertices.
    pub bytes: f64,
}

/// "OpenGL-like": primary rays alone; or shadows and three levels of reflection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Look {
    Raycast,
    Whitted,
}

impl Look {
    pub const BOTH: [Look; 2] = [Look::Raycast, Look::Whitted];

    pub fn name(self) -> &'static str {
        match self {
            Look::Raycast => "OpenGL-like",
            Look::Whitted => "ray tracing",
        }
    }
}

/// A shader of a built-in class, and some of its parameters.
pub fn shader(context: &mut Context, class: &str, values: &[(&str, &[f32])]) -> Result<Name> {
    context.gen_new_shader_class(class)?;
    let name = context.gen_new_shader()?;
    for (parameter, value) in values {
        let handle = context.parameter_handle(parameter)?;
        context.parameter_f(handle, value)?;
    }
    Ok(name)
}

impl Stage {
    pub fn new(
        threads: usize,
        size: [u32; 3],
        bytes: f64,
        define: impl FnOnce(&mut Context) -> Result<Assemble>,
    ) -> Result<Stage> {
        let mut context = Context::with_config(Config::with_threads(threads))?;
        context.max_depth(3)?;
        let renderers = [shader(&mut context, "raycast", &[])?, shader(&mut context, "whitted", &[])?];
        let assemble = define(&mut context)?;
        Ok(Stage { context, assemble, renderers, size, bytes })
    }

    /// A generated scene, whose first part mirrors if `mirror`. A frame sends 48 bytes per matrix and 36 per triangle that moves.
    pub fn generated(threads: usize, size: [u32; 3], bench: BenchScene, mirror: bool) -> Result<Stage> {
        let moving = |motion: Motion| motion == Motion::Unstructured;
        let soft: usize = bench.parts.iter().filter(|p| moving(p.motion)).map(|p| p.triangles.len()).sum();
        let matrices = if bench.instanced { (bench.place)(0).len() } else { 0 };
        let bytes = (36 * soft + 48 * matrices) as f64;
        Stage::new(threads, size, bytes, move |context| {
            let grey: [(&str, &[f32]); 1] = [("diffuse", &[0.6, 0.6, 0.55])];
            let shiny: [(&str, &[f32]); 2] = [("diffuse", &[0.2, 0.2, 0.25]), ("reflection", &[0.6, 0.6, 0.6])];
            let surfaces = [shader(context, "phong", &grey)?, shader(context, "phong", &shiny)?];
            let first = context.gen_objects(bench.parts.len() as i32)?;
            for (i, (name, part)) in (first..).zip(&bench.parts).enumerate() {
                context.bind_shader(surfaces[usize::from(mirror && i == 0)])?;
                context.new_object(name, Mode::Compile, part.motion)?;
                let positions = (part.positions)(0);
                let mesh =
                    TriangleMesh { positions: &positions, triangles: &part.triangles, ..TriangleMesh::default() };
                context.draw_mesh(&mesh)?;
                context.end_object()?;
            }
            let light = shader(context, "point", &[("position", &bench.light.to_array())])?;
            let mut shown = 0;
            Ok(Box::new(move |context: &mut Context, frame| {
                for (name, part) in (first..).zip(&bench.parts) {
                    // Only when time has gone on.
                    if moving(part.motion) && frame != shown {
                        context.update_vertices(name, 0, (part.positions)(frame))?;
                    }
                }
                shown = frame;
                for placement in (bench.place)(frame) {
                    context.load_matrix(DMat4::from(placement.transform.as_daffine3()))?;
                    context.instantiate_object(first + placement.part as Name)?;
                }
                context.load_identity()?;
                context.use_light(light)?;
                Ok(Eye::from(&bench.view))
            }))
        })
    }

    /// Renders a part of the picture, `[left, bottom, right, top]` in pixels; gives the processor time of all threads and of the busiest as well.
    fn render(&mut self, frame: u32, look: Look, part: [u32; 4]) -> Result<(FrameStats, Cost)> {
        let eye = (self.assemble)(&mut self.context, frame)?;
        let [width, height, _] = self.size.map(f64::from);
        let context = &mut self.context;
        context.use_rendering_object(self.renderers[usize::from(look == Look::Whitted)])?;
        let [left, bottom, right, top] = part;
        context.set_frame_size(right - left, top - bottom)?;
        let half = (eye.degrees.to_radians() * 0.5).tan();
        let x = |pixel: u32| (f64::from(pixel) / width * 2.0 - 1.0) * half * width / height;
        let y = |pixel: u32| (f64::from(pixel) / height * 2.0 - 1.0) * half;
        context.frustum(x(left), x(right), y(bottom), y(top), 1.0, 1e4)?;
        context.look_at(eye.from, eye.at, eye.up)?;
        let (cost, stats) = Cost::of(|| context.render());
        Ok((stats?, cost))
    }

    /// Renders the whole picture.
    pub fn frame(&mut self, frame: u32, look: Look) -> Result<(FrameStats, Cost)> {
        self.render(frame, look, [0, 0, self.size[0], self.size[1]])
    }

    /// Processor seconds of the update from the frame before: what the smallest of pictures takes.
    pub fn update(&mut self, frame: u32) -> Result<f64> {
        let mut least = f64::INFINITY;
        for _ in 0..3 {
            self.render(frame.saturating_sub(1), Look::Raycast, [0, 0, 1, 1])?;
            least = least.min(self.render(frame, Look::Raycast, [0, 0, 1, 1])?.1.all);
        }
        Ok(least)
    }

    /// Processor seconds that each tile takes, without what a frame costs whose scene is as before. The least of the rounds.
    pub fn tiles(&mut self, frame: u32, look: Look, rounds: u32) -> Result<Vec<f64>> {
        let [width, height, tile] = self.size;
        let corner = |side: u32| (0..side).step_by(tile as usize);
        let corners: Vec<[u32; 2]> = corner(height).flat_map(|y| corner(width).map(move |x| [x, y])).collect();
        let mut empty = f64::INFINITY;
        for _ in 0..10 {
            empty = empty.min(self.render(frame, look, [0, 0, 1, 1])?.1.all);
        }
        let mut seconds = vec![f64::INFINITY; corners.len()];
        for _ in 0..rounds {
            for (least, [x, y]) in seconds.iter_mut().zip(&corners) {
                let (_, cost) = self.render(frame, look, [*x, *y, x + tile, y + tile])?;
                *least = least.min((cost.all - empty).max(0.0));
            }
        }
        Ok(seconds)
    }
}
