//! Acceleration structures, and how they are brought up to date every frame.
#![forbid(unsafe_code)]

mod aabb;
mod two_level;

pub use aabb::{Aabb, MAX_COORDINATE, triangle_bounds};
pub use two_level::{InstanceRecord, ObjectAccel, TwoLevel, UpdateStats};
