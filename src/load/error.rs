//! What is wrong with a file, and where.

use std::fmt;
use std::path::{Path, PathBuf};

/// A file that cannot be loaded; shown as `path:line: message`.
#[derive(Debug)]
pub struct LoadError {
    pub path: PathBuf,
    /// 1-based; absent where a line means nothing (binary files, missing files).
    pub line: Option<u32>,
    pub message: String,
}

impl LoadError {
    pub fn new(path: &Path, line: Option<u32>, message: impl Into<String>) -> Self {
        Self { path: path.to_path_buf(), line, message: message.into() }
    }

    pub fn io(path: &Path, error: &std::io::Error) -> Self {
        Self::new(path, None, error.to_string())
    }
}

impl fmt::Display for LoadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "{}:{line}: {}", self.path.display(), self.message),
            None => write!(f, "{}: {}", self.path.display(), self.message),
        }
    }
}

impl std::error::Error for LoadError {}
