//! Acceleration structures, and how they are brought up to date every frame.
#![forbid(unsafe_code)]

mod aabb;
mod assemble;
mod binning;
mod block_loader;
mod bsp;
mod build_fast;
mod build_sah;
mod build_spatial;
mod bvh;
mod by_rays;
mod corners;
mod degenerate;
mod grid;
mod instance;
mod key_trees;
mod lazy;
mod lazy_cut;
mod lazy_number;
mod lazy_patch;
mod lazy_validate;
mod lazy_write;
mod links;
mod memory;
mod object_accel;
mod partition;
mod place;
mod prim_ref;
mod proximity;
mod refit;
mod restructure;
mod rotate;
mod spatial;
mod statics;
mod strategy;
mod top_level_bsp;
mod top_level_bvh;
mod top_level_split;
mod treelet;
mod two_level;
mod validate;
mod vertex_box;
mod vertex_runs;
mod visibility;
mod waiting;
mod world_view;

pub use aabb::{Aabb, MAX_COORDINATE, least_area, triangle_bounds};
pub(crate) use aabb::{LEAST_SEEN, PAD_ABSOLUTE, PAD_EXTENT, PAD_ULP};
pub use bsp::{BSP_MAX_NODES, Bsp, BspNode, BspPart, BspTree, LEVELS, Quality};
pub use build_fast::build_fast;
pub use build_sah::build_sah;
pub use build_spatial::build_spatial;
pub use bvh::{BLOCK, Bvh, ChildRef, MAX_DEPTH, MAX_LEAF_BLOCKS, Node8, OutOfMemory, Subtree, Tri4, WIDTH};
pub use corners::{Corners, block_of};
pub use grid::{Grid, Lattice, TopCell, plane};
pub use instance::{InstanceRecord, Space, to_world};
pub use lazy::{LazyBvh, LazyPart, OwnPart};
pub use lazy_cut::LazyBlock;
pub use lazy_validate::validate_lazy;
pub use object_accel::{ObjectAccel, Structure};
pub use proximity::{ProximityNode, ProximityTree};
pub use refit::{Refit, SweepScratch};
pub use statics::{Merged, Merging};
pub use top_level_bsp::{TOP_MAX_DEPTH, TopLevelBsp, TopNode};
pub use top_level_bvh::TopLevelBvh;
pub use two_level::{TwoLevel, UpdateStats};
pub use validate::validate;
pub(crate) use visibility::tile_of;
pub use visibility::{
    Candidates, Directions, FieldSize, Frame, MOST_LEVELS, Subfield, TileList, TileRef, VisibilityField,
};
pub use world_view::{TopLevel, WorldView};

#[cfg(test)]
mod lazy_tests;
#[cfg(test)]
pub(crate) mod test_meshes;
#[cfg(test)]
mod tests;
