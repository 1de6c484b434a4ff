//! The file: its JSON and its bytes, and the numbers in them, which may be compressed.

pub mod accessor;
mod container;
pub mod document;
pub mod draco;
mod meshopt;
