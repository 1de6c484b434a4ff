//! Settings, capabilities, and getters for everything that is current.

use super::assembler::Primitive;
use super::context::Context;
use super::error::{Error, Result};
use super::matrix_stack::MAX_DEPTH;
use super::objects::Mode;
use super::target::MAX_FRAME_SIZE;
use super::textures::MAX_TEXTURE_SIZE;
use crate::backend::OnDone;
use crate::scene::{DEFAULT_AMBIENT, LightUse, TopLevelKind, Upsampling};
use std::time::Duration;

/// Most samples per pixel.
pub const MAX_SAMPLES: u32 = 1 << 16;

/// Most bounces after the primary ray.
pub const MAX_RAY_DEPTH: u32 = 64;

/// What can be switched on and off; all are off at first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Capability {
    /// 8-bit pixels are encoded with the sRGB curve instead of holding linear values.
    FramebufferSrgb,
    /// Row 0 of pictures is the topmost, and `pick` counts from the top.
    OriginTopLeft,
    /// Frames are averaged as long as neither scene nor camera changes.
    Accumulate,
    /// As `Accumulate`; and if the frames are sub-sampled, each next one samples blocks of half the size, until all pixels are sampled. Any change
    /// begins anew.
    Progressive,
}

impl Capability {
    pub const ALL: [Capability; 4] = [Self::FramebufferSrgb, Self::OriginTopLeft, Self::Accumulate, Self::Progressive];
}

/// Settings that persist and belong to no object.
pub(super) struct Settings {
    pub srgb: bool,
    pub origin_top_left: bool,
    pub accumulate: bool,
    pub samples: u32,
    pub max_depth: u32,
    pub top_level: TopLevelKind,
    pub subsampling: u32,
    pub upsampling: Upsampling,
    pub frameless: u32,
    pub time_budget: Option<Duration>,
    pub progressive: bool,
    pub on_frame_done: Option<OnDone>,
    pub jpeg_quality: u8,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            srgb: false,
            origin_top_left: false,
            accumulate: false,
            samples: 1,
            max_depth: 3,
            top_level: TopLevelKind::Auto,
            subsampling: 1,
            upsampling: Upsampling::Bilinear,
            frameless: 1,
            time_budget: None,
            progressive: false,
            on_frame_done: None,
            jpeg_quality: 92,
        }
    }
}

/// What [`Context::get`] can be asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum State {
    /// 16 numbers, column-major.
    CurrentMatrix,
    MatrixDepth,
    MaxMatrixDepth,
    /// 4 numbers.
    CurrentColor,
    /// 3 numbers; 0 0 0 when unset.
    CurrentNormal,
    /// 4 numbers.
    CurrentTexCoord,
    /// Object being defined, or 0.
    CurrentObject,
    /// 0, or 1 for compile and instantiate; of the object being defined.
    CurrentObjectMode,
    BoundShaderClass,
    BoundShader,
    BoundTexture,
    /// Shader chosen by `use_camera`, or 0.
    Camera,
    Environment,
    RenderingObject,
    /// Lights of the frame being assembled.
    LightCount,
    /// Instances of the frame being assembled.
    InstanceCount,
    /// 4 numbers.
    ClearColor,
    /// 3 numbers.
    AmbientLight,
    /// x, y, width, height; all 0 before there is a framebuffer.
    Viewport,
    /// Width, height of the framebuffer; 0 before there is one.
    FrameSize,
    MaxFrameSize,
    MaxTextureSize,
    SamplesPerPixel,
    MaxSamples,
    MaxDepth,
    MaxMaxDepth,
    Threads,
    /// A frame was started and not ended.
    Rendering,
    /// Frames started so far.
    FrameNumber,
    /// See [`super::FrameParameter::Subsampling`].
    Subsampling,
    /// See [`super::FrameParameter::Frameless`].
    Frameless,
    /// In milliseconds; -1 without one. See [`super::FrameParameter::TimeBudget`].
    TimeBudget,
    /// See [`Context::jpeg_quality`].
    JpegQuality,
    Capability(Capability),
}

impl State {
    /// Everything that can be asked for.
    pub const ALL: [State; 37] = [
        State::CurrentMatrix,
        State::MatrixDepth,
        State::MaxMatrixDepth,
        State::CurrentColor,
        State::CurrentNormal,
        State::CurrentTexCoord,
        State::CurrentObject,
        State::CurrentObjectMode,
        State::BoundShaderClass,
        State::BoundShader,
        State::BoundTexture,
        State::Camera,
        State::Environment,
        State::RenderingObject,
        State::LightCount,
        State::InstanceCount,
        State::ClearColor,
        State::AmbientLight,
        State::Viewport,
        State::FrameSize,
        State::MaxFrameSize,
        State::MaxTextureSize,
        State::SamplesPerPixel,
        State::MaxSamples,
        State::MaxDepth,
        State::MaxMaxDepth,
        State::Threads,
        State::Rendering,
        State::FrameNumber,
        State::Subsampling,
        State::Frameless,
        State::TimeBudget,
        State::JpegQuality,
        State::Capability(Capability::FramebufferSrgb),
        State::Capability(Capability::OriginTopLeft),
        State::Capability(Capability::Accumulate),
        State::Capability(Capability::Progressive),
    ];
}

/// 1 to 16 numbers. All integers of the API are exact in f64.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StateValue {
    values: [f64; 16],
    len: usize,
}

impl StateValue {
    fn new<T: Into<f64> + Copy>(from: &[T]) -> Self {
        let mut values = [0.0; 16];
        values.iter_mut().zip(from).for_each(|(to, &from)| *to = from.into());
        Self { values, len: from.len() }
    }

    pub fn as_slice(&self) -> &[f64] {
        &self.values[..self.len]
    }

    /// The numbers rounded to the nearest integer, as OpenGL's integer getters do. Names above `i32::MAX` wrap, so that they
    /// come out right as unsigned.
    pub fn integers(&self) -> impl Iterator<Item = i32> + '_ {
        self.as_slice().iter().map(|&v| v.round().clamp(f64::from(i32::MIN), f64::from(u32::MAX)) as i64 as i32)
    }

    pub fn floats(&self) -> impl Iterator<Item = f32> + '_ {
        self.as_slice().iter().map(|&v| v as f32)
    }

    /// False for 0, true for everything else.
    pub fn booleans(&self) -> impl Iterator<Item = bool> + '_ {
        self.as_slice().iter().map(|&v| v != 0.0)
    }
}

/// What [`Context::get_string`] can be asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StateString {
    Vendor,
    /// major.minor.patch
    Version,
    /// The rendering object in use.
    Renderer,
    /// Instruction set of the kernels.
    SimdLevel,
    /// Who executes frames.
    Backend,
}

impl Context {
    /// # Errors
    /// `InvalidOperation` between begin and end.
    pub fn enable(&mut self, capability: Capability) -> Result<()> {
        self.set_capability(capability, true)
    }

    /// # Errors
    /// `InvalidOperation` between begin and end.
    pub fn disable(&mut self, capability: Capability) -> Result<()> {
        self.set_capability(capability, false)
    }

    fn set_capability(&mut self, capability: Capability, on: bool) -> Result<()> {
        self.outside_begin()?;
        match capability {
            Capability::FramebufferSrgb => self.settings.srgb = on,
            Capability::OriginTopLeft => self.settings.origin_top_left = on,
            Capability::Accumulate => self.settings.accumulate = on,
            Capability::Progressive => self.settings.progressive = on,
        }
        Ok(())
    }

    /// # Errors
    /// `InvalidOperation` between begin and end.
    pub fn is_enabled(&self, capability: Capability) -> Result<bool> {
        self.outside_begin()?;
        Ok(match capability {
            Capability::FramebufferSrgb => self.settings.srgb,
            Capability::OriginTopLeft => self.settings.origin_top_left,
            Capability::Accumulate => self.settings.accumulate,
            Capability::Progressive => self.settings.progressive,
        })
    }

    /// Samples per pixel of the frames that start from now on; 1 samples the centre.
    ///
    /// # Errors
    /// `InvalidValue` unless 1 to [`MAX_SAMPLES`].
    pub fn samples_per_pixel(&mut self, samples: i32) -> Result<()> {
        self.outside_begin()?;
        self.settings.samples = in_range(samples, 1, MAX_SAMPLES)?;
        Ok(())
    }

    /// Bounces after the primary ray: 0 for none. The default is 3.
    ///
    /// # Errors
    /// `InvalidValue` unless 0 to [`MAX_RAY_DEPTH`].
    pub fn max_depth(&mut self, depth: i32) -> Result<()> {
        self.outside_begin()?;
        self.settings.max_depth = in_range(depth, 0, MAX_RAY_DEPTH)?;
        Ok(())
    }

    /// How well JPEG files show the picture, from 1 (small files) to 100; 92 at first. See [`Context::write_image`].
    ///
    /// # Errors
    /// `InvalidValue` unless 1 to 100.
    pub fn jpeg_quality(&mut self, quality: i32) -> Result<()> {
        self.outside_begin()?;
        self.settings.jpeg_quality = in_range(quality, 1, 100)? as u8;
        Ok(())
    }

    /// The structure over the instances, in frames and commits that start from now on. None changes the picture.
    ///
    /// # Errors
    /// `InvalidOperation` between begin and end.
    pub fn top_level(&mut self, kind: TopLevelKind) -> Result<()> {
        self.outside_begin()?;
        self.settings.top_level = kind;
        Ok(())
    }

    /// The value of a piece of state.
    ///
    /// # Errors
    /// `InvalidOperation` between begin and end.
    pub fn get(&self, state: State) -> Result<StateValue> {
        self.outside_begin()?;
        let one = |value: u32| StateValue::new(&[value]);
        let size = self.target.size().unwrap_or_default();
        Ok(match state {
            State::CurrentMatrix => StateValue::new(&self.matrices.current().to_cols_array()),
            State::MatrixDepth => one(self.matrices.depth() as u32),
            State::MaxMatrixDepth => one(MAX_DEPTH as u32),
            State::CurrentColor => StateValue::new(&self.current.color.to_array()),
            State::CurrentNormal => StateValue::new(&self.current.normal.unwrap_or_default().to_array()),
            State::CurrentTexCoord => StateValue::new(&self.current.tex_coord.to_array()),
            State::CurrentObject => one(self.definition.as_ref().map_or(0, |d| d.name)),
            State::CurrentObjectMode => {
                one(self.definition.as_ref().map_or(0, |d| u32::from(d.mode == Mode::CompileAndInstantiate)))
            }
            State::BoundShaderClass => one(self.shaders.bound_class()),
            State::BoundShader => one(self.shaders.bound()),
            State::BoundTexture => one(self.textures.bound()),
            State::Camera => one(self.content.camera.unwrap_or(0)),
            State::Environment => one(self.content.environment),
            State::RenderingObject => one(self.content.renderer),
            State::LightCount => one(self.content.lights.len() as u32),
            State::InstanceCount => one(self.content.instance_count() as u32),
            State::ClearColor => StateValue::new(&self.content.clear_color),
            State::AmbientLight => StateValue::new(&self.content.ambient.unwrap_or(DEFAULT_AMBIENT)),
            State::Viewport => {
                let v = self.target.shown_viewport();
                StateValue::new(&[v.x, v.y, v.width, v.height])
            }
            State::FrameSize => StateValue::new(&size),
            State::MaxFrameSize => one(MAX_FRAME_SIZE),
            State::MaxTextureSize => one(MAX_TEXTURE_SIZE),
            State::SamplesPerPixel => one(self.settings.samples),
            State::MaxSamples => one(MAX_SAMPLES),
            State::MaxDepth => one(self.settings.max_depth),
            State::MaxMaxDepth => one(MAX_RAY_DEPTH),
            State::Threads => one(self.backend.threads() as u32),
            State::Rendering => one(u32::from(self.rendering)),
            State::FrameNumber => StateValue::new(&[self.frames as f64]),
            State::Subsampling => one(self.settings.subsampling),
            State::Frameless => one(self.settings.frameless),
            State::TimeBudget => {
                StateValue::new(&[self.settings.time_budget.map_or(-1.0, |budget| budget.as_secs_f64() * 1e3)])
            }
            State::JpegQuality => one(self.settings.jpeg_quality.into()),
            State::Capability(capability) => one(u32::from(self.is_enabled(capability)?)),
        })
    }

    /// The primitive between begin and end, if any. The only getter that works there.
    pub fn open_primitive(&self) -> Option<Primitive> {
        self.assembler.as_ref().map(|a| a.primitive())
    }

    /// Lights of the frame being assembled, each with the matrix that it was used with.
    ///
    /// # Errors
    /// `InvalidOperation` between begin and end.
    pub fn get_lights(&self) -> Result<&[LightUse]> {
        self.outside_begin()?;
        Ok(&self.content.lights)
    }

    /// The structure over the instances that was asked for.
    ///
    /// # Errors
    /// `InvalidOperation` between begin and end.
    pub fn get_top_level(&self) -> Result<TopLevelKind> {
        self.outside_begin()?;
        Ok(self.settings.top_level)
    }

    /// A text about the library.
    ///
    /// # Errors
    /// `InvalidOperation` between begin and end.
    pub fn get_string(&self, string: StateString) -> Result<&str> {
        self.outside_begin()?;
        Ok(match string {
            StateString::Vendor => "The openrt project",
            StateString::Version => env!("CARGO_PKG_VERSION"),
            StateString::Renderer => match self.shaders.get(self.content.renderer) {
                Some(state) => &state.class.name,
                None => "whitted",
            },
            StateString::SimdLevel => self.backend.simd_level(),
            StateString::Backend => "local",
        })
    }
}

pub(super) fn in_range(value: i32, least: u32, most: u32) -> Result<u32> {
    u32::try_from(value)
        .ok()
        .filter(|v| (least..=most).contains(v))
        .ok_or_else(|| Error::invalid_value(format_args!("the value is {value}; it must be {least} to {most}")))
}

/// Checks that all numbers of an argument are finite.
pub(super) fn finite(argument: &str, values: &[f32]) -> Result<()> {
    if values.iter().all(|v| v.is_finite()) {
        Ok(())
    } else {
        Err(Error::invalid_value(format_args!("{argument} is {values:?}; it must be finite")))
    }
}
