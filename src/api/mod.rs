//! The state machine in safe Rust: what Rust programs call, and what the C face calls for C programs.
//!
//! [`Context`] holds everything that is current, checks every call by OpenGL's rules, and turns what is valid into
//! [`crate::scene::Command`]s and frame descriptions for the back-end. It never looks into the back-end's scene, which may be
//! rendering: what it must know of objects, shaders and textures to check a call, it remembers itself.
#![forbid(unsafe_code)]

mod arrays;
mod assembler;
mod camera;
mod class_check;
mod composites;
mod context;
mod error;
mod frame;
mod frame_content;
mod frame_parameter;
mod immediate;
mod instances;
mod matrices;
mod matrix_stack;
mod mesh_builder;
mod names;
mod near_miss;
mod objects;
mod parameter_value;
mod query;
mod shaders;
mod state;
mod target;
mod texture_image;
mod textures;
mod typed_mesh;

pub use arrays::{Component, Indices, VertexArray, VertexArrays, decode_vectors};
pub use assembler::Primitive;
pub(crate) use class_check::{Layout, check_sizes};
pub use context::{Config, Context, ErrorCallback, MAX_THREADS};
pub use error::{Error, ErrorCode, Message, Result};
pub use frame::{CancelHandle, FrameCallback, PixelKind};
pub use frame_content::IMMEDIATE_OBJECT;
pub use frame_parameter::{FrameParameter, MAX_FRAMELESS};
pub use matrix_stack::MAX_DEPTH as MAX_MATRIX_DEPTH;
pub use objects::{Mode, ObjectInfo, ObjectParameter};
pub use state::{Capability, MAX_RAY_DEPTH, MAX_SAMPLES, State, StateString, StateValue};
pub use target::MAX_FRAME_SIZE;
pub use texture_image::{ImageDesc, ImageFormat};
pub use textures::{MAX_TEXTURE_SIZE, TextureInfo, TextureParameter};
pub use typed_mesh::TriangleMesh;

/// The vectors and matrices of the API are of this version of `glam`.
pub use glam;

// The plain types of the rooms below that appear in the methods of `Context`.
pub(crate) use crate::backend::with_default_floats;
pub use crate::backend::{HitSurface, Level, Queries, SceneView};
pub use crate::frame::{FrameStats, PixelFormat, PixelSink, Target, TargetLayout};
pub use crate::scene::{
    CameraShader, EnvironmentShader, Filter, LazyShape, LightSample, LightShader, LightUse, MAX_COORDINATE, Mask,
    Motion, Name, ParamDef, ParamScope, ParamType, ParamValue, PrimaryRay, Program, ShaderClass, ShaderKind,
    ShadingContext, Strategy, SurfacePoint, SurfaceShader, TextureFormat, TopLevelKind, Upsampling, Wrap,
};
pub use crate::trace::{ClosestPoint, Hit, Ray};

/// The Rust program of the README must compile.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct Readme;
