//! Readers of scene files. Each format has its own; all fill a [`SceneFile`].
//!
//! Files are untrusted: sizes are bounded, counts are believed only as far as the file reaches, and every fault is a
//! [`LoadError`] with file and line.
#![forbid(unsafe_code)]

mod build;
mod define;
mod error;
mod gltf;
mod input;
mod model;
mod nff;
mod obj;
mod ply;
mod report;
#[cfg(test)]
mod tests;

pub use define::{LoadedScene, Parts};
pub use error::LoadError;
pub use model::*;

use crate::quiet;
use std::path::Path;

/// How a file is read.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReadOptions {
    /// Level of detail of AFF scenes: included files of a higher level are left out.
    pub detail: f64,
}

/// Reads a scene; the format is told by the file name's extension: `.aff`, `.nff`, `.obj`, `.ply`, `.gltf` or `.glb`.
/// What the file has and the answer lacks is said in [`SceneFile::warnings`].
///
/// # Errors
/// The file, or another one that the scene cannot be without, cannot be read or is damaged.
pub fn read(path: impl AsRef<Path>) -> Result<SceneFile, LoadError> {
    read_with(path, &ReadOptions::default())
}

/// As [`read`], with options.
///
/// # Errors
/// As [`read`].
pub fn read_with(path: impl AsRef<Path>, options: &ReadOptions) -> Result<SceneFile, LoadError> {
    let path = path.as_ref();
    // The last line of defence against a file that a crate cannot take.
    let read = quiet::caught(|| read_format(path, options));
    read.unwrap_or_else(|panic| Err(LoadError::new(path, None, format!("the reader {panic}"))))
}

fn read_format(path: &Path, options: &ReadOptions) -> Result<SceneFile, LoadError> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    match extension.as_str() {
        "aff" | "nff" => nff::load(path, options.detail),
        "obj" => obj::load(path),
        "ply" => ply::load(path),
        "gltf" | "glb" => gltf::load(path),
        _ => Err(LoadError::new(path, None, "unknown kind of scene: expected .aff, .nff, .obj, .ply, .gltf or .glb")),
    }
}
