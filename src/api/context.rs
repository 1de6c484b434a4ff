//! The context: everything that is current, and what may be called when.

use super::assembler::Assembler;
use super::camera::HelperCamera;
use super::composites::Composites;
use super::error::{Error, ErrorCode, Result};
use super::frame_content::FrameContent;
use super::immediate::Current;
use super::matrix_stack::MatrixStack;
use super::mesh_builder::{Capture, MeshBuilder};
use super::names::Names;
use super::objects::{Definition, ObjectInfo};
use super::shaders::Shaders;
use super::state::Settings;
use super::target::FrameTarget;
use super::textures::Textures;
use crate::backend::{Level, Local};
use crate::frame::FrameStats;
use crate::scene::NameMap;
use std::borrow::Cow;

/// How a context is set up.
#[derive(Clone, Debug, Default)]
pub struct Config {
    /// Worker threads; None asks `OPENRT_NUM_THREADS`, then the processors that this process may use.
    pub threads: Option<usize>,
    /// Instruction set of the kernels; None asks `OPENRT_SIMD`, then the processor. A level that the processor lacks is lowered.
    pub simd: Option<Level>,
}

impl Config {
    /// A configuration with `threads` workers.
    pub fn with_threads(threads: usize) -> Self {
        Self { threads: Some(threads), ..Self::default() }
    }
}

/// Most worker threads of a context.
pub const MAX_THREADS: u32 = crate::backend::MAX_THREADS as u32;

/// Told every latched error, the first and those after it.
pub type ErrorCallback = Box<dyn FnMut(ErrorCode, &str) + Send>;

/// A scene in the making and the frames rendered from it: the state machine of the API.
///
/// Methods are the C functions without their `rt`. Each returns an [`Error`] and changes nothing when it is called
/// with a bad value or at the wrong time:
///
/// | call | between begin and end | between new_object and end_object |
/// |---|---|---|
/// | `vertex`, `normal`, `tex_coord`, `color`, `parameter_*` | yes (`vertex` only there) | yes |
/// | `new_object`, frames and queries | no | no |
/// | everything else | no | yes |
///
/// Immediate mode, as in OpenGL:
///
/// ```
/// use openrt::Context;
/// use openrt::api::glam::DVec3;
/// use openrt::api::{Mode, Motion, Primitive, Result};
///
/// fn main() -> Result<()> {
///     let mut cx = Context::new()?;
///     cx.set_frame_size(64, 64)?;
///     let object = cx.gen_objects(1)?;
///     cx.new_object(object, Mode::Compile, Motion::Affine)?;
///     cx.begin(Primitive::Triangles)?;
///     cx.vertex3(-1.0, -1.0, 0.0)?;
///     cx.vertex3(1.0, -1.0, 0.0)?;
///     cx.vertex3(0.0, 1.0, 0.0)?;
///     cx.end()?;
///     cx.end_object()?;
///     for frame in 0..3 {
///         cx.load_identity()?;
///         cx.translate(DVec3::new(0.0, 0.0, -3.0))?;
///         cx.rotate(30.0 * f64::from(frame), DVec3::Y)?;
///         cx.instantiate_object(object)?;
///         let stats = cx.render()?;
///         assert_eq!(stats.triangles, 1);
///     }
///     assert_eq!(cx.pick(32.0, 32.0)?.map(|hit| hit.object), Some(object));
///     Ok(())
/// }
/// ```
///
/// Whole meshes go in by [`Context::draw_mesh`]; deforming ones move by [`Context::update_vertices`].
///
/// A context is used by one thread at a time, and rendering is parallel inside it. Dropping it waits for the frame in flight.
pub struct Context {
    pub(super) backend: Local,
    /// First error latched since the last [`Context::get_error`].
    latched: Option<Error>,
    last_message: Cow<'static, str>,
    error_callback: Option<ErrorCallback>,
    /// Why the context is unusable, after a defect showed itself.
    poisoned: Option<Cow<'static, str>>,

    pub(super) object_names: Names,
    pub(super) objects: NameMap<ObjectInfo>,
    pub(super) definition: Option<Definition>,
    pub(super) composites: Composites,
    /// Receives vertices: those of the object being defined, else those drawn outside objects.
    pub(super) builder: MeshBuilder,
    /// Some between begin and end.
    pub(super) assembler: Option<Assembler>,
    /// Captured parameters of the shader bound at begin.
    pub(super) captures: Vec<Capture>,
    pub(super) current: Current,
    pub(super) matrices: MatrixStack,

    pub(super) shaders: Shaders,
    pub(super) textures: Textures,
    pub(super) content: FrameContent,
    pub(super) camera: HelperCamera,
    pub(super) target: FrameTarget,
    pub(super) settings: Settings,
    /// Between start_rendering and end_rendering.
    pub(super) rendering: bool,
    pub(super) stats: FrameStats,
    /// Frames started so far.
    pub(super) frames: u64,
}

impl Context {
    /// A context with the default configuration.
    ///
    /// # Errors
    /// `Io` when the system refuses worker threads, `OutOfMemory`.
    pub fn new() -> Result<Self> {
        Self::with_config(Config::default())
    }

    /// A context with `config`.
    ///
    /// # Errors
    /// As [`Context::new`].
    pub fn with_config(config: Config) -> Result<Self> {
        let level = config.simd.map_or_else(Level::detect, |level| level.min(Level::strongest()));
        let backend = Local::new(config.threads, level).map_err(|error| {
            Error::new(if error.is_out_of_memory() { ErrorCode::OutOfMemory } else { ErrorCode::Io }, error.to_string())
        })?;
        Ok(Self {
            backend,
            latched: None,
            last_message: Cow::Borrowed("no error"),
            error_callback: None,
            poisoned: None,
            object_names: Names::default(),
            objects: NameMap::default(),
            definition: None,
            composites: Composites::default(),
            builder: MeshBuilder::default(),
            assembler: None,
            captures: Vec::new(),
            current: Current::default(),
            matrices: MatrixStack::default(),
            shaders: Shaders::default(),
            textures: Textures::default(),
            content: FrameContent::default(),
            camera: HelperCamera::default(),
            target: FrameTarget::default(),
            settings: Settings::default(),
            rendering: false,
            stats: FrameStats::default(),
            frames: 0,
        })
    }

    /// Records a refused call, as the C face does for every error: the first one since the last
    /// [`Context::get_error`] is kept, and the error callback is told.
    pub fn latch(&mut self, error: Error) {
        // Taken out, so that a callback that panics is not called again.
        if let Some(mut callback) = self.error_callback.take() {
            callback(error.code, &error.message);
            self.error_callback = Some(callback);
        }
        if self.latched.is_none() {
            self.last_message = error.message.clone();
            self.latched = Some(error);
        }
    }

    /// The first error latched since the last call, which is thereby forgotten. Between begin and end this is itself
    /// an error: it latches `InvalidOperation` and returns `NoError`.
    pub fn get_error(&mut self) -> ErrorCode {
        if self.assembler.is_some() && self.poisoned.is_none() {
            self.latch(Error::invalid_operation("get_error between begin and end"));
            return ErrorCode::NoError;
        }
        match self.latched.take() {
            Some(error) => error.code,
            None if self.poisoned.is_some() => ErrorCode::InternalError,
            None => ErrorCode::NoError,
        }
    }

    /// Whether [`Context::get_error`] would return `NoError` and do nothing.
    #[inline]
    pub(crate) fn has_no_error(&self) -> bool {
        self.latched.is_none() && self.poisoned.is_none() && self.assembler.is_none()
    }

    /// Text of the first error latched since the last but one [`Context::get_error`]; "no error" before any.
    pub fn error_message(&self) -> &str {
        &self.last_message
    }

    /// As [`Context::error_message`], for those who keep it.
    pub(crate) fn error_text(&self) -> &Cow<'static, str> {
        &self.last_message
    }

    /// Calls `callback` with every error from now on; None stops that.
    pub fn error_callback(&mut self, callback: Option<ErrorCallback>) {
        self.error_callback = callback;
    }

    /// Makes every later call fail with `InternalError`: a defect was caught and the state cannot be trusted.
    pub fn poison(&mut self, reason: impl Into<Cow<'static, str>>) {
        self.assembler = None;
        self.poisoned = Some(reason.into());
    }

    pub fn is_poisoned(&self) -> bool {
        self.poisoned.is_some()
    }

    /// Fails once the context is poisoned.
    #[inline]
    pub(super) fn usable(&self) -> Result<()> {
        match &self.poisoned {
            None => Ok(()),
            Some(reason) => Err(unusable(reason.clone())),
        }
    }

    /// Fails between begin and end.
    #[inline]
    pub(super) fn outside_begin(&self) -> Result<()> {
        self.usable()?;
        if self.assembler.is_some() {
            return Err(between_begin_and_end());
        }
        Ok(())
    }

    #[cold]
    fn in_definition(&self) -> Error {
        let object = self.definition.as_ref().map_or(0, |definition| definition.name);
        Error::invalid_operation(format_args!("not allowed while object {object} is being defined"))
    }

    /// Fails between begin and end, and between new_object and end_object.
    #[inline]
    pub(crate) fn outside_object(&self) -> Result<()> {
        self.outside_begin()?;
        if self.definition.is_some() {
            return Err(self.in_definition());
        }
        Ok(())
    }
}

#[cold]
fn unusable(reason: Cow<'static, str>) -> Error {
    Error::new(ErrorCode::InternalError, reason)
}

#[cold]
fn between_begin_and_end() -> Error {
    Error::invalid_operation("not allowed between begin and end of a primitive")
}
