//! Acceleration structures, and how they are brought up to date every frame.
#![forbid(unsafe_code)]

mod aabb;
mod assemble;
mod build_fast;
mod build_sah;
mod bvh;
mod refit;
mod two_level;
mod validate;

pub use aabb::{Aabb, MAX_COORDINATE, triangle_bounds};
pub use build_fast::build_fast;
pub use build_sah::build_sah;
pub use bvh::{BLOCK, Bvh, ChildRef, MAX_DEPTH, MAX_LEAF_BLOCKS, Node8, OutOfMemory, Subtree, Tri4, WIDTH};
pub use refit::Refit;
pub use two_level::{InstanceRecord, ObjectAccel, TwoLevel, UpdateStats};
pub use validate::validate;

#[cfg(test)]
pub(crate) mod test_meshes;
#[cfg(test)]
mod tests;
