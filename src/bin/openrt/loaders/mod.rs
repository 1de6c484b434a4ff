//! Readers of scene files. Each format has its own; all fill a [`SceneFile`].
//!
//! Files are untrusted: sizes are bounded, counts are believed only as far as the file reaches, and every fault is a
//! [`LoadError`] with file and line.

mod aff;
mod aff_keys;
mod aff_shapes;
mod builder;
mod error;
mod files;
mod gltf;
mod gltf_buffers;
mod gltf_motion;
mod lexer;
mod obj;
mod ply;
mod shapes;
#[cfg(test)]
mod tests;

pub use error::LoadError;

use crate::scene::SceneFile;
use std::path::Path;

/// Loads a scene; the format is told by the file name's extension.
pub fn load(path: &Path, detail: f64) -> Result<SceneFile, LoadError> {
    // The last line of defence against a file that a crate cannot take: still a message and an exit code.
    std::panic::catch_unwind(|| read(path, detail))
        .unwrap_or_else(|_| Err(LoadError::new(path, None, "the reader of this format gave up on the file")))
}

fn read(path: &Path, detail: f64) -> Result<SceneFile, LoadError> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    match extension.as_str() {
        "aff" | "nff" => aff::load(path, detail),
        "obj" => obj::load(path),
        "ply" => ply::load(path),
        "gltf" | "glb" => gltf::load(path),
        _ => Err(LoadError::new(path, None, "unknown kind of scene: expected .aff, .nff, .obj, .ply, .gltf or .glb")),
    }
}
