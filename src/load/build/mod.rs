//! What the readers of several formats make scenes with: shared corners, materials without repeats, curved surfaces and
//! polygons as triangles.

mod builder;
pub mod shapes;

pub use builder::{Baked, Builder, Corner, MaterialTable};
