//! The program's reader of AFF files, without those of other formats, whose crates a bench does not ask for.

#[path = "../../../src/bin/openrt/loaders/aff.rs"]
pub mod aff;
#[path = "../../../src/bin/openrt/loaders/aff_keys.rs"]
mod aff_keys;
#[path = "../../../src/bin/openrt/loaders/aff_shapes.rs"]
mod aff_shapes;
#[path = "../../../src/bin/openrt/loaders/builder.rs"]
mod builder;
#[path = "../../../src/bin/openrt/loaders/error.rs"]
mod error;
#[path = "../../../src/bin/openrt/loaders/files.rs"]
mod files;
#[path = "../../../src/bin/openrt/loaders/lexer.rs"]
mod lexer;
#[path = "../../../src/bin/openrt/loaders/shapes.rs"]
mod shapes;

pub use error::LoadError;
