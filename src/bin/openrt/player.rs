//! Plays a scene file through the library: objects and shaders once, placements and moving vertices per frame.
//!
//! Everything goes through [`openrt::Context`], as any application would do it: materials become shaders of the class
//! `phong`, every object is compiled once, and each frame instantiates the visible ones with their matrices of that time.

use crate::args::{Interpolation, Options, Renderer, Switch};
use crate::scene::{Background, Camera, Deform, Deformed, LightKind, Pose, Projection, SceneFile, View};
use crate::upload::{Placed, ShaderMaker, decode, define, texture};
use glam::{DMat4, DVec3, Vec3};
use openrt::Context;
use openrt::api::{
    Capability, Config, Error, FrameParameter, FrameStats, Motion, Name, ObjectParameter, PixelFormat, PixelKind,
    Upsampling,
};

pub struct Player {
    context: Context,
    scene: SceneFile,
    /// Parallel to `scene.objects`.
    objects: Vec<Placed>,
    /// Shader and class of each of `scene.lights`.
    lights: Vec<Name>,
    ambient: Option<Name>,
    camera: CameraChoice,
    aspect: f64,
    /// Oddities met while objects were made.
    pub warnings: Vec<String>,
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
    pub fn new(scene: SceneFile, options: &Options, size: (u32, u32)) -> Result<Self, String> {
        let config = options.threads.map_or_else(Config::default, |n| Config::with_threads(usize::from(n)));
        let context = Context::with_config(config).map_err(|e| e.to_string())?;
        let camera = CameraChoice::new(&scene, options);
        let aspect = f64::from(size.0) / f64::from(size.1);
        let mut player = Self {
            context,
            scene,
            objects: Vec::new(),
            lights: Vec::new(),
            ambient: None,
            camera,
            aspect,
            warnings: Vec::new(),
        };
        player.set_up(options, size).map_err(|e| e.to_string())?;
        Ok(player)
    }

    fn set_up(&mut self, options: &Options, (width, height): (u32, u32)) -> Result<(), Error> {
        let mut shaders = ShaderMaker::default();
        let srgb = options.srgb.map_or(self.scene.srgb, |s| s == Switch::On);
        let context = &mut self.context;
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
        let renderer = shaders.make(context, options.renderer.class())?;
        if options.renderer == Renderer::Whitted && options.shadows == Switch::Off {
            let handle = context.parameter_handle("shadows")?;
            context.parameter_i(handle, &[0])?;
        }
        context.use_rendering_object(renderer)?;
        match self.scene.background {
            Background::Color(color) => context.clear_color(color.extend(1.0).to_array())?,
            Background::Sky => {
                let sky = shaders.make(context, "gradient")?;
                context.use_environment_shader(sky)?;
            }
        }
        let textures = self.textures()?;
        let context = &mut self.context;
        let mut surfaces = Vec::new();
        for material in &self.scene.materials {
            surfaces.push(shaders.surface(context, material, &textures)?);
        }
        for light in &self.scene.lights {
            self.lights.push(shaders.light(context, light.kind, light.color)?);
        }
        // Without lights the library puts a lamp at the eye, which an ambient light would switch off.
        if !self.lights.is_empty() && self.scene.ambient != Vec3::ZERO {
            let ambient = shaders.make(context, "ambient")?;
            shaders.floats(context, "color", &self.scene.ambient.to_array())?;
            self.ambient = Some(ambient);
        }
        let moving = self.scene.moving_nodes();
        for object in &self.scene.objects {
            let motion = match object.deform {
                Deform::Rigid if moving[object.node as usize] => Motion::Affine,
                Deform::Rigid => Motion::Static,
                _ => Motion::Unstructured,
            };
            let placed = define(context, object, motion, &surfaces)?;
            if let Some(strategy) = options.strategy {
                context.object_parameter(placed.name, ObjectParameter::Strategy(strategy))?;
            }
            self.objects.push(placed);
        }
        Ok(())
    }

    /// Texture names parallel to `scene.textures`; 0, with a warning, for an image that cannot be read.
    fn textures(&mut self) -> Result<Vec<Name>, Error> {
        let mut names = Vec::new();
        for source in &self.scene.textures {
            names.push(match decode(source) {
                Ok(image) => texture(&mut self.context, source, &image, self.scene.srgb)?,
                Err(text) => {
                    self.warnings.push(format!("texture `{}`: {text}", source.name));
                    0
                }
            });
        }
        Ok(names)
    }

    /// Puts the frame of `time` together; may run while the frame before is rendering.
    pub fn assemble(&mut self, time: f64) -> Result<(), String> {
        self.try_assemble(time).map_err(|e| e.to_string())
    }

    fn try_assemble(&mut self, time: f64) -> Result<(), Error> {
        let poses = self.scene.pose(time);
        let context = &mut self.context;
        for (object, placed) in self.scene.objects.iter().zip(&self.objects) {
            if !poses.get(object.node as usize).is_none_or(|p| p.visible) {
                continue;
            }
            if let Some(deformed) = object.deformed(time, &poses, &self.scene.nodes) {
                update(context, placed, &deformed)?;
            }
            context.load_matrix(DMat4::from(object.world_from_object(&poses)))?;
            context.instantiate_object(placed.name)?;
        }
        context.load_identity()?;
        if let Some(ambient) = self.ambient {
            context.use_light(ambient)?;
        }
        for (light, &shader) in self.scene.lights.iter().zip(&self.lights) {
            let Some((position, direction)) = light.placed(time, &poses) else { continue };
            context.bind_shader(shader)?;
            if light.kind != LightKind::Directional {
                let handle = context.parameter_handle("position")?;
                context.parameter_f(handle, &position.to_array())?;
            }
            if !matches!(light.kind, LightKind::Point { .. }) {
                let handle = context.parameter_handle("direction")?;
                context.parameter_f(handle, &direction.to_array())?;
            }
            context.use_light(shader)?;
        }
        self.camera.apply(context, time, &poses, self.aspect)
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

impl CameraChoice {
    fn new(scene: &SceneFile, options: &Options) -> Self {
        let mut camera = scene.cameras.first().cloned().unwrap_or_else(|| scene.overview());
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
        match self.camera.projection {
            // Nothing is clipped: the planes only have to be valid.
            Projection::Perspective { fov_y } => context.perspective(fov_y, aspect, 0.1, 1e3)?,
            Projection::Orthographic { half_height: h } => {
                context.ortho(-h * aspect, h * aspect, -h, h, 0.1, 1e3)?;
            }
        }
        context.look_at(view.from, view.from + view.forward.normalize_or_zero(), view.up)
    }
}

/// Moves the vertices of a deforming object.
fn update(context: &mut Context, placed: &Placed, deformed: &Deformed) -> Result<(), Error> {
    let pick = |values: &[Vec3]| -> Vec<Vec3> { placed.sources.iter().map(|&v| values[v as usize]).collect() };
    context.update_vertices(placed.name, 0, pick(&deformed.positions))?;
    if placed.has_normals && !deformed.normals.is_empty() {
        context.update_normals(placed.name, 0, pick(&deformed.normals))?;
    }
    Ok(())
}
