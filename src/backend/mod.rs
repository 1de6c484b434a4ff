//! Who executes: this process.
//!
//! The state machine sends [`crate::scene::Command`]s and frame descriptions; what happens to them is decided here, and the
//! application cannot tell. [`Local`] is the only back-end; a cluster is another one with the same methods.
#![forbid(unsafe_code)]

mod flight;
mod image_files;
mod local;
mod queries;

pub use flight::{FrameFailure, OnDone};
pub use image_files::read_image;
pub use local::{BackendError, Local};

pub use crate::render::{HitSurface, Queries, SceneView, builtin_classes};
pub use crate::simd::Level;
pub use crate::threads::{MAX_THREADS, with_default_floats};
