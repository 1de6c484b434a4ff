//! Hits to colours: surfaces, lights, cameras, environments and rendering objects.
//!
//! At frame start [`ShadeScene`] turns names and parameters into dense, typed data (late binding). A [`Worker`], one
//! per thread, then carries the camera samples of a tile through a rendering object. Built-in shaders are variants of closed enums;
//! only the user's own programs are called through traits. No ray allocates memory. [`class`] has the manual of all
//! built-in classes.
#![forbid(unsafe_code)]

pub mod class;

mod alpha;
mod ambient_occlusion;
mod block;
mod camera;
mod camera_packet;
mod context;
mod direct;
mod environment;
mod footprint;
mod holes;
mod integrator;
mod interaction;
mod light;
mod light_packet;
mod lighting;
mod materials;
mod metallic_roughness;
mod names;
mod optics;
mod path;
mod placed;
mod points;
mod rows;
mod sampler;
mod samples;
mod shade_scene;
mod surface;
mod surface_use;
mod texture;
mod textures;
mod values;
mod whitted;
mod worker;

pub use block::Blocks;
pub use camera::Camera;
pub use camera_packet::{CameraPacket, PACKET_SIZE, Wanted, place};
pub use class::builtin_classes;
pub use footprint::Cone;
pub use holes::Holes;
pub use interaction::Interaction;
pub use placed::Placed;
pub use sampler::{PixelPattern, Rng};
pub use samples::{Planes, Samples};
pub use shade_scene::{ShadeMemory, ShadeScene, compile_camera};
pub use worker::{MAX_LAYERS, RayCounts, Sample, Seen, Worker, WorkerMemory};
