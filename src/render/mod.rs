//! The conductor of one frame: bring the structures up to date, bind the shaders, trace and shade the tiles, deliver
//! their pixels.
//!
//! All parallel work runs on the calling thread's rayon pool; enter it with [`crate::threads::Pool::install`].
#![forbid(unsafe_code)]

mod desk;
mod error;
mod frameless;
mod history;
mod passes;
mod queries;
mod renderer;
mod scene_view;
mod tile;
mod upsample;

pub use error::RenderError;
pub use queries::{HitSurface, Queries};
pub use renderer::Renderer;
pub use scene_view::SceneView;

/// What the rooms above may know of the shaders.
pub use crate::shade::builtin_classes;

#[cfg(test)]
mod budget_tests;
#[cfg(test)]
mod tests;
