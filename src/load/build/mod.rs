//! What the readers of several formats make scenes with: shared corners, materials without repeats, curved surfaces and
//! polygons as triangles.

mod builder;
mod curved;
pub mod polygon;

pub use builder::{Baked, Builder, Corner, MaterialTable};
pub use curved::Curved;
