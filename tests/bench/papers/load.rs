//! The library's reader of AFF files, without those of other formats, whose crates a bench does not ask for.

#[path = "../../../src/load/build/mod.rs"]
mod build;
#[path = "../../../src/load/define/mod.rs"]
mod define;
#[path = "../../../src/load/error.rs"]
mod error;
#[path = "../../../src/load/input/mod.rs"]
mod input;
#[path = "../../../src/load/model/mod.rs"]
mod model;
#[path = "../../../src/load/nff/mod.rs"]
pub mod nff;
#[path = "../../../src/load/report.rs"]
mod report;

pub use define::*;
pub use error::LoadError;
pub use model::*;
