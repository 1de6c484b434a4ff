//! The C face: every function of `<openrt/rt.h>`, one file per group, each a few lines long.
//!
//! An export reads its pointers in its first lines (`pointer`), then runs inside `guard`, which finds the
//! context that is current on the calling thread, catches panics, and records errors. What travels further is
//! safe: numbers, slices, `TryFrom`-checked enums. No pointer to anything of ours leaves, except strings that
//! the manual gives a lifetime.
//!
//! The doc comments of this room are the C manual: cbindgen copies them into the header, which
//! `tests/header.rs` keeps up to date. They are written for a reader of C, so the conditions of each pointer
//! stand in its text rather than under "Safety".

#![allow(non_snake_case)]
#![allow(clippy::missing_safety_doc, reason = "the C manual states for each pointer what it must point to")]

#[cfg(panic = "abort")]
compile_error!("openrt must be built with panic = \"unwind\": a defect must not end the application");

mod constants;
mod types;

mod contexts;
mod current;
mod guard;
mod plugin;
mod pointer;
mod refusal;
mod texts;

mod arrays;
mod attributes;
mod colors;
mod context;
mod frame;
mod frame_parameters;
mod immediate;
mod load;
#[cfg_attr(not(feature = "load"), path = "no_scenes.rs")]
mod loaded_scenes;
mod matrices;
mod objects;
mod parameters;
mod queries;
mod scenes;
mod shader_class;
mod shaders;
mod shading;
mod state;
mod textures;
mod view;

pub use constants::*;
pub use types::*;

pub use arrays::*;
pub use attributes::*;
pub use colors::*;
pub use context::*;
pub use frame::*;
pub use immediate::*;
pub use load::*;
pub use matrices::*;
pub use objects::*;
pub use parameters::*;
pub use queries::*;
pub use scenes::*;
pub use shader_class::*;
pub use shaders::*;
pub use shading::*;
pub use state::*;
pub use textures::*;
pub use view::*;
