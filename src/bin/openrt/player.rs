//! Plays a scene file through the library: objects and shaders once, placements and moving vertices per frame.
//!
//! What the file holds is defined and placed by [`LoadedScene`]; this adds what the command line says.

use crate::args::{Interpolation, Options, Renderer, Switch};
use glam::DVec3;
use openrt::Context;
use openrt::api::{
    Capability, Config, Error, FrameParameter, FrameStats, ObjectParameter, PixelFormat, PixelKind, Target, Upsampling,
};
use openrt::load::{Camera, LoadedScene, Parts, Pose, Projection, SceneFile, View};
use std::time::Duration;

pub struct Player {
    context: Context,
    scene: LoadedScene,
    camera: CameraChoice,
    aspect: f64,
}

/// The scene's camera with what the command line replaces.
struct CameraChoice {
    camera: Camera,
    eye: Option<DVec3>,
    at: Option<DVec3>,
    up: Option<DVec3>,
}

impl Player {
    /// Gives everything that persists to the library.
    pub fn new(file: SceneFile, options: &Options, size: (u32, u32)) -> Result<Self, String> {
        let config = options.threads.map_or_else(Config::default, |n| Config::with_threads(usize::from(n)));
        let mut context = Context::with_config(config).map_err(|e| e.to_string())?;
        let srgb = options.srgb.map_or(file.srgb, |s| s == Switch::On);
        set_up(&mut context, options, size, srgb).map_err(|e| e.to_string())?;
        let scene = LoadedScene::define(&mut context, file).map_err(|e| e.to_string())?;
        if let Some(strategy) = options.strategy {
            for object in scene.objects() {
                context.object_parameter(object, ObjectParameter::Strategy(strategy)).map_err(|e| e.to_string())?;
            }
        }
        let camera = CameraChoice::new(&scene, options);
        Ok(Self { context, scene, camera, aspect: f64::from(size.0) / f64::from(size.1) })
    }

    /// What reading and defining the scene left out.
    pub fn warnings(&self) -> &[String] {
        &self.scene.file().warnings
    }

    /// Puts the frame of `time` together; may run while the frame before is rendering.
    pub fn assemble(&mut self, time: f64) -> Result<(), String> {
        self.try_assemble(time).map_err(|e| e.to_string())
    }

    fn try_assemble(&mut self, time: f64) -> Result<(), Error> {
        self.scene.instantiate(&mut self.context, time, Parts { camera: false, ..Parts::ALL })?;
        let poses = self.scene.file().pose(time);
        self.camera.apply(&mut self.context, time, &poses, self.aspect)
    }

    /// Also delivers frames to `target`, for who watches them come.
    pub fn deliver(&mut self, target: Option<Target>) -> Result<(), String> {
        match target {
            Some(target) => self.context.set_frame_buffer(Some(target)).map_err(|e| e.to_string()),
            None => Ok(()),
        }
    }

    /// Waits up to `timeout` for the frame that was started; whether it is done.
    pub fn wait(&mut self, timeout: Duration) -> Result<bool, String> {
        self.context.wait_frame(timeout).map_err(|e| e.to_string())
    }

    /// Starts rendering the frame that was assembled.
    pub fn start(&mut self) -> Result<(), String> {
        self.context.start_rendering().map_err(|e| e.to_string())
    }

    /// Waits for the frame that was started.
    pub fn finish(&mut self) -> Result<FrameStats, String> {
        self.context.end_rendering().map_err(|e| e.to_string())
    }

    /// The last finished frame as RGBA bytes, row 0 at the top.
    pub fn read_bytes(&mut self) -> Result<Vec<u8>, String> {
        self.read(PixelFormat::Rgba8)
    }

    /// The last finished frame as linear RGBA.
    pub fn read_floats(&mut self) -> Result<Vec<f32>, String> {
        let bytes = self.read(PixelFormat::Rgba32F)?;
        Ok(bytes.as_chunks::<4>().0.iter().map(|&b| f32::from_ne_bytes(b)).collect())
    }

    fn read(&mut self, format: PixelFormat) -> Result<Vec<u8>, String> {
        let [width, height] = self.context.frame_size().map_err(|e| e.to_string())?;
        let length = width as usize * height as usize * format.bytes_per_pixel();
        let mut bytes = Vec::new();
        bytes.try_reserve_exact(length).map_err(|_| "no memory for the picture".to_string())?;
        bytes.resize(length, 0);
        self.context
            .read_pixels(0, 0, width, height, PixelKind::Color(format), 0, &mut bytes)
            .map_err(|e| e.to_string())?;
        Ok(bytes)
    }
}

/// Applies what the command line says about pictures.
fn set_up(context: &mut Context, options: &Options, (width, height): (u32, u32), srgb: bool) -> Result<(), Error> {
    context.set_frame_size(width, height)?;
    context.enable(Capability::OriginTopLeft)?;
    if srgb {
        context.enable(Capability::FramebufferSrgb)?;
    }
    context.samples_per_pixel(i32::from(options.samples))?;
    context.max_depth(i32::from(options.depth))?;
    context.frame_parameter(FrameParameter::Subsampling(i32::from(options.subsampling)))?;
    context.frame_parameter(FrameParameter::Upsampling(match options.upsampling {
        Interpolation::Bilinear => Upsampling::Bilinear,
        Interpolation::Midpoint => Upsampling::Midpoint,
    }))?;
    context.frame_parameter(FrameParameter::Frameless(i32::from(options.frameless)))?;
    context.frame_parameter(FrameParameter::TimeBudget(options.time_budget))?;
    context.gen_new_shader_class(options.renderer.class())?;
    let renderer = context.gen_new_shader()?;
    if options.renderer == Renderer::Whitted && options.shadows == Switch::Off {
        let handle = context.parameter_handle("shadows")?;
        context.parameter_i(handle, &[0])?;
    }
    context.use_rendering_object(renderer)
}

impl CameraChoice {
    fn new(scene: &LoadedScene, options: &Options) -> Self {
        let mut camera = scene.camera().clone();
        if let Some(fov_y) = options.fov {
            camera.projection = Projection::Perspective { fov_y };
        }
        Self { camera, eye: options.eye, at: options.at, up: options.up }
    }

    fn view(&self, time: f64, poses: &[Pose]) -> View {
        let mut view = self.camera.view(time, poses);
        view.from = self.eye.unwrap_or(view.from);
        view.up = self.up.unwrap_or(view.up);
        if let Some(at) = self.at {
            view.forward = at - view.from;
        }
        view
    }

    fn apply(&self, context: &mut Context, time: f64, poses: &[Pose], aspect: f64) -> Result<(), Error> {
        let view = self.view(time, poses);
        self.camera.projection.apply(context, aspect)?;
        context.look_at(view.from, view.from + view.forward.normalize_or_zero(), view.up)
    }
}
