//! # openrt
//!
//! An OpenGL-like, immediate-mode API over a CPU ray tracing engine for scenes that move.
//!
//! This file is the map. Data flows through the rooms in this order, and a room uses only those after it:
//!
//! ```text
//! C call → capi → (load) → api → backend → render → (accel, trace, shade) → frame → pixels
//! ```
//!
//! | room | what lives there |
//! |---|---|
//! | [`capi`] | the `extern "C"` functions of `<openrt/rt.h>`, one file per group |
//! | `load` | readers of scene files, which define objects, lights and cameras in a [`Context`]; feature `load` |
//! | [`api`] | the state machine in safe Rust: [`Context`], errors, names, matrix stack, begin/end |
//! | [`backend`] | who executes the commands: this process |
//! | [`render`] | the conductor of one frame: update structures, trace and shade tiles, deliver pixels |
//! | [`shade`] | hits to colours: surfaces, lights, cameras, environments, rendering objects |
//! | [`trace`] | rays through structures; triangle kernels |
//! | [`accel`] | acceleration structures and how they are brought up to date |
//! | [`frame`] | colours to pixels: framebuffer, pixel formats, image files |
//! | [`scene`] | retained definitions: meshes, instances, shaders, textures. Knows nothing of rays |
//! | [`simd`], [`threads`], [`memory`], [`quiet`] | shelves: vectors and instruction sets; the thread pool; memory that is asked for; panics of codecs as errors |

pub mod api;
pub mod capi;
#[cfg(feature = "load")]
pub mod load;

pub mod backend;
pub mod render;

pub mod accel;
pub mod frame;
pub mod scene;
pub mod shade;
pub mod trace;

pub mod memory;
pub mod quiet;
pub mod simd;
pub mod threads;

pub use api::Context;
