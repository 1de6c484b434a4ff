//! A scene file in a context: what persists is defined once, what belongs to a frame is placed for each time.
//!
//! Everything goes through [`Context`], as any application would do it: materials become shaders (of the class `phong`, or
//! `metallic_roughness` for glTF), images textures, every object is compiled once, and each frame instantiates the visible
//! ones with their matrices of that time. The state of the context (matrix, what is bound, current colour and normal) is as before after each call.

mod kept;
mod objects;
mod surfaces;
mod textures;

use crate::api::{Context, Error, Motion, Name, State};
use crate::load::{Background, Camera, Deform, LightKind, Pose, SceneFile};
use glam::DMat4;
use kept::with_state_kept;
use objects::Placed;
use surfaces::ShaderMaker;

/// What of a scene a frame gets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parts {
    /// Instances of the objects that are visible.
    pub instances: bool,
    /// Lights that are on.
    pub lights: bool,
    /// The first camera of the file, else one that shows everything.
    pub camera: bool,
    /// Clear colour or environment.
    pub background: bool,
}

impl Parts {
    pub const ALL: Self = Self { instances: true, lights: true, camera: true, background: true };
    pub const NONE: Self = Self { instances: false, lights: false, camera: false, background: false };
}

/// A scene file whose objects, shaders and textures a context has.
///
/// ```no_run
/// use openrt::Context;
/// use openrt::load::{LoadedScene, Parts, read};
///
/// fn main() -> Result<(), Box<dyn std::error::Error>> {
///     let mut cx = Context::new()?;
///     cx.set_frame_size(640, 480)?;
///     let file = read("kitchen.aff")?;
///     for warning in &file.warnings {
///         eprintln!("{warning}");
///     }
///     let animation = file.animation;
///     let mut scene = LoadedScene::define(&mut cx, file)?;
///     for frame in 0..100 {
///         let time = animation.map_or(0.0, |a| a.time(frame));
///         scene.instantiate(&mut cx, time, Parts::ALL)?;
///         cx.render()?;
///         cx.write_image(format!("kitchen{frame:03}.png"))?;
///     }
///     Ok(())
/// }
/// ```
pub struct LoadedScene {
    file: SceneFile,
    camera: Camera,
    /// Parallel to `file.objects`.
    objects: Vec<Placed>,
    /// Parallel to `file.materials`.
    surfaces: Vec<Name>,
    /// Parallel to `file.lights`.
    lights: Vec<Name>,
    ambient: Option<Name>,
    sky: Option<Name>,
    /// Parallel to `file.textures`; 0 for those that could not be read.
    textures: Vec<Name>,
    /// Time for which the vertices of deforming objects were moved last.
    deformed_at: Option<f64>,
}

impl LoadedScene {
    /// Defines objects, shaders and textures of `file`. Images that cannot be read are reported in [`SceneFile::warnings`].
    ///
    /// # Errors
    /// Those of the calls of [`Context`] that it makes, such as `OutOfMemory`, and `InvalidOperation` between begin and end
    /// or in the definition of an object. What was defined until then is deleted.
    pub fn define(context: &mut Context, file: SceneFile) -> Result<Self, Error> {
        let mut scene = Self {
            camera: file.cameras.first().cloned().unwrap_or_else(|| file.overview()),
            file,
            objects: Vec::new(),
            surfaces: Vec::new(),
            lights: Vec::new(),
            ambient: None,
            sky: None,
            textures: Vec::new(),
            deformed_at: None,
        };
        let defined = with_state_kept(context, |context| {
            context.load_identity()?;
            scene.define_all(context)
        });
        match defined {
            Ok(()) => Ok(scene),
            Err(error) => {
                // The first error counts.
                let _ = scene.delete(context);
                Err(error)
            }
        }
    }

    fn define_all(&mut self, context: &mut Context) -> Result<(), Error> {
        let mut shaders = ShaderMaker::default();
        let file = &mut self.file;
        for source in &file.textures {
            self.textures.push(match textures::decode(source) {
                Ok(image) => textures::texture(context, source, &image)?,
                Err(text) => {
                    file.warnings.push(format!("texture `{}`: {text}", source.name));
                    0
                }
            });
        }
        for material in &file.materials {
            self.surfaces.push(shaders.surface(context, material, &self.textures)?);
        }
        for light in &file.lights {
            self.lights.push(shaders.light(context, light.kind, light.color)?);
        }
        // Without lights the library puts a lamp at the eye, which an ambient light would switch off. A black one says that there is none.
        if !file.lights.is_empty() {
            let ambient = shaders.make(context, "ambient")?;
            self.ambient = Some(ambient);
            shaders.floats(context, "color", &file.ambient.to_array())?;
        }
        if file.background == Background::Sky {
            self.sky = Some(shaders.make(context, "gradient")?);
        }
        let moving = file.moving_nodes();
        // A range of names, for callers who want to walk over the objects.
        let count = i32::try_from(file.objects.len()).map_err(|_| Error::out_of_memory())?;
        let first = if count > 0 { context.gen_objects(count)? } else { 0 };
        for (name, object) in (first..).zip(&file.objects) {
            let motion = match object.deform {
                Deform::Rigid if moving[object.node as usize] => Motion::Affine,
                Deform::Rigid => Motion::Static,
                _ => Motion::Unstructured,
            };
            self.objects.push(objects::define(context, name, object, motion, &self.surfaces)?);
        }
        Ok(())
    }

    /// What the file said, with the warnings of reading and defining.
    pub fn file(&self) -> &SceneFile {
        &self.file
    }

    /// Names of the objects, one after the other, in the order of [`SceneFile::objects`].
    pub fn objects(&self) -> impl ExactSizeIterator<Item = Name> + '_ {
        self.objects.iter().map(|o| o.name)
    }

    /// The first camera of the file, else one that shows everything.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Puts the scene as it is at `time` (seconds on the file's clock) into the frame being assembled, which may be while the
    /// frame before renders. Instances are placed under the current matrix. The camera's picture has the shape of the
    /// viewport, which must therefore be set before.
    ///
    /// A scene may be placed several times in a frame; but the vertices of deforming objects have one state in it, that
    /// of the last time.
    ///
    /// # Errors
    /// Those of the calls of [`Context`] that it makes; what was placed until then stays in the frame.
    pub fn instantiate(&mut self, context: &mut Context, time: f64, parts: Parts) -> Result<(), Error> {
        let poses = self.file.pose(time);
        with_state_kept(context, |context| {
            if parts.background {
                self.use_background(context)?;
            }
            if parts.instances {
                self.place_objects(context, time, &poses)?;
            }
            if parts.lights {
                self.use_lights(context, time, &poses)?;
            }
            if parts.camera {
                self.use_camera(context, time, &poses)?;
            }
            Ok(())
        })
    }

    fn use_background(&self, context: &mut Context) -> Result<(), Error> {
        if let Background::Color(color) = self.file.background {
            context.clear_color(color.extend(1.0).to_array())?;
        }
        context.use_environment_shader(self.sky.unwrap_or(0))
    }

    fn place_objects(&mut self, context: &mut Context, time: f64, poses: &[Pose]) -> Result<(), Error> {
        for (object, placed) in self.file.objects.iter().zip(&self.objects) {
            if poses.get(object.node as usize).is_some_and(|p| !p.visible) {
                continue;
            }
            if self.deformed_at != Some(time)
                && let Some(deformed) = object.deformed(time, poses, &self.file.nodes)
            {
                objects::update(context, placed, &deformed)?;
            }
            for world in object.placements(poses) {
                context.push_matrix()?;
                context.mult_matrix(DMat4::from(world))?;
                context.instantiate_object(placed.name)?;
                context.pop_matrix()?;
            }
        }
        self.deformed_at = Some(time);
        Ok(())
    }

    fn use_lights(&self, context: &mut Context, time: f64, poses: &[Pose]) -> Result<(), Error> {
        if let Some(ambient) = self.ambient {
            context.use_light(ambient)?;
        }
        for (light, &shader) in self.file.lights.iter().zip(&self.lights) {
            let Some((position, direction)) = light.placed(time, poses) else { continue };
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
        Ok(())
    }

    fn use_camera(&self, context: &mut Context, time: f64, poses: &[Pose]) -> Result<(), Error> {
        let view = self.camera.view(time, poses);
        let aspect = aspect(context)?;
        context.use_camera(0)?;
        self.camera.projection.apply(context, aspect)?;
        context.look_at(view.from, view.from + view.forward.normalize_or_zero(), view.up)
    }

    /// Deletes objects, shaders and textures. Instances in the frame being assembled are still shown.
    ///
    /// # Errors
    /// `InvalidOperation` between begin and end or in the definition of an object, before anything is deleted.
    pub fn delete(&mut self, context: &mut Context) -> Result<(), Error> {
        // Deleting nothing is refused where deleting something is.
        context.delete_objects(0, 0)?;
        // What the application has deleted itself is gone already.
        for placed in self.objects.drain(..) {
            if context.is_object(placed.name)? {
                context.delete_objects(placed.name, 1)?;
            }
        }
        let shaders = self.surfaces.drain(..).chain(self.lights.drain(..)).chain(self.ambient.take());
        for shader in shaders.chain(self.sky.take()) {
            if context.is_shader(shader)? {
                context.delete_shader(shader)?;
            }
        }
        context.delete_textures(&std::mem::take(&mut self.textures))
    }
}

/// Width over height of the pictures: of the viewport, or 4:3 before there is one.
fn aspect(context: &Context) -> Result<f64, Error> {
    let viewport = context.get(State::Viewport)?;
    let [_, _, width, height] = *viewport.as_slice() else { return Ok(4.0 / 3.0) };
    Ok(if width > 0.0 && height > 0.0 { width / height } else { 4.0 / 3.0 })
}
