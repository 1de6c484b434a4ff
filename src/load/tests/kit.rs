//! Folders, files and warnings for the tests.

use crate::load::{LoadError, ReadOptions, SceneFile, read_with};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

/// A folder that goes with its guard.
pub struct Folder(pub PathBuf);

impl Folder {
    pub fn new() -> Self {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let name = format!("openrt-loaders-{}-{}", std::process::id(), NEXT.fetch_add(1, Ordering::Relaxed));
        let path = std::env::temp_dir().join(name);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, bytes).unwrap();
        path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

pub fn load(path: &Path, detail: f64) -> Result<SceneFile, LoadError> {
    read_with(path, &ReadOptions { detail })
}

pub fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

/// Reads `text` as a file called `name`.
pub fn read_text(name: &str, text: impl AsRef<[u8]>) -> Result<SceneFile, LoadError> {
    let folder = Folder::new();
    load(&folder.write(name, text), 0.0)
}

/// Exactly one warning, with these words.
pub fn warned(scene: &SceneFile, words: &str) {
    assert!(scene.warnings.len() == 1 && scene.warnings[0].contains(words), "{words}: {:?}", scene.warnings);
}
