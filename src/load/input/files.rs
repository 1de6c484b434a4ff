//! Reading files that scene files name: bounded in size, and only from the scene's own folders.
//!
//! A scene may come from a stranger. It can name files below its own folder and below sibling folders that hold
//! textures (`../TextureFiles` in BART), and nothing else: absolute paths, other `..` and symbolic links that lead
//! outside are refused.

use super::lines::decoded;
use crate::load::LoadError;
use std::cell::RefCell;
use std::collections::HashMap;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

/// Largest file that is read. The largest public scenes (Moana, Lucy) split into smaller files or stay below.
pub const MAX_FILE_BYTES: u64 = 1 << 30;

/// Sibling folders of the scene's folder that hold textures by convention.
const TEXTURE_SIBLINGS: [&str; 3] = ["TextureFiles", "textures", "Textures"];

/// Sub-folders in which a texture is looked for when it does not lie where the scene says.
const TEXTURE_FOLDERS: [&str; 6] = ["", "../TextureFiles", "TextureFiles", "textures", "Textures", "../textures"];

/// Folders that a scene may read.
#[derive(Clone, Debug)]
pub struct Tree {
    /// Folder of the main file.
    folder: PathBuf,
    allowed: Vec<PathBuf>,
    /// Names in folders where something was looked for without regard to case.
    listed: RefCell<HashMap<PathBuf, Listing>>,
}

/// Names of a folder by their small letters; of several that differ in capitals, the first in order.
type Listing = HashMap<String, OsString>;

impl Tree {
    pub fn of(main_file: &Path) -> Result<Self, LoadError> {
        let folder = match main_file.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent.to_path_buf(),
            _ => PathBuf::from("."),
        };
        let real = folder.canonicalize().map_err(|e| LoadError::io(main_file, &e))?;
        let siblings = TEXTURE_SIBLINGS.iter().filter_map(|s| real.parent().map(|p| p.join(s)));
        let allowed = std::iter::once(real.clone()).chain(siblings.filter(|s| s.is_dir())).collect();
        Ok(Self { folder, allowed, listed: RefCell::default() })
    }

    /// The file called `name`, looked for in `folder` (of the file that names it) and in the scene's own; one that is spelled
    /// with other capitals is found too. The error says why in words that follow the name.
    pub fn find(&self, name: &str, folder: &Path) -> Result<PathBuf, String> {
        let name = name.replace('\\', "/");
        if Path::new(&name).is_absolute() || name.contains(':') {
            return Err("is an absolute path".into());
        }
        let mut refused = false;
        for base in [folder, self.folder.as_path()] {
            let Some(path) = self.existing(base, &name) else {
                // A missing file outside the tree is refused too: its existence is none of the scene's business.
                refused |= escapes(&name);
                continue;
            };
            match path.canonicalize() {
                Ok(real) if self.allowed.iter().any(|a| real.starts_with(a)) => {
                    if real.is_file() {
                        return Ok(path);
                    }
                }
                Ok(_) => refused = true,
                Err(_) => {}
            }
        }
        Err(if refused { "lies outside the scene's folder".into() } else { "does not exist".into() })
    }

    /// The path below `base` that `name` spells, with other capitals or in Latin-1 if there is nothing of exactly that name.
    fn existing(&self, base: &Path, name: &str) -> Option<PathBuf> {
        let exact = base.join(name);
        if exact.exists() {
            return Some(exact);
        }
        let mut path = base.to_path_buf();
        for part in name.split('/').filter(|p| !p.is_empty() && *p != ".") {
            let exact = path.join(part);
            if exact.exists() {
                path = exact;
                continue;
            }
            let mut listed = self.listed.borrow_mut();
            let listing = listed.entry(path.clone()).or_insert_with(|| listing(&path));
            path.push(listing.get(&part.to_lowercase())?);
        }
        Some(path)
    }

    /// Like [`Tree::find`], also in the usual texture folders; and, since scenes travel without the folders that they were made
    /// in, there also by the last part of its path.
    pub fn find_texture(&self, name: &str, folder: &Path) -> Result<PathBuf, String> {
        let mut first_error = None;
        let last = name.rsplit(['/', '\\']).next().filter(|last| *last != name);
        for name in [Some(name), last].into_iter().flatten() {
            for sub in TEXTURE_FOLDERS {
                let candidate = if sub.is_empty() { name.to_string() } else { format!("{sub}/{name}") };
                match self.find(&candidate, folder) {
                    Ok(path) => return Ok(path),
                    Err(e) => first_error = first_error.or(Some(e)),
                }
            }
        }
        Err(first_error.unwrap_or_default())
    }
}

fn listing(folder: &Path) -> Listing {
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let entries = fs::read_dir(here).into_iter().flatten().filter_map(|entry| Some(entry.ok()?.file_name()));
    let mut names: Vec<OsString> = entries.collect();
    // The same one each time, whatever the order in the folder.
    names.sort();
    let mut listing = Listing::new();
    for name in names {
        listing.entry(decoded(name.as_encoded_bytes()).to_lowercase()).or_insert(name);
    }
    listing
}

/// Whether `name` climbs above the folder it starts in, apart from the texture siblings.
fn escapes(name: &str) -> bool {
    let mut depth = 0_i32;
    for part in name.split('/') {
        match part {
            ".." => depth -= 1,
            "" | "." => {}
            _ => depth += 1,
        }
        if depth < 0 {
            return !TEXTURE_SIBLINGS.iter().any(|s| name.starts_with(&format!("../{s}/")));
        }
    }
    false
}

/// Reads a regular file of at most `limit` bytes.
pub fn read(path: &Path, limit: u64) -> Result<Vec<u8>, LoadError> {
    let metadata = fs::metadata(path).map_err(|e| LoadError::io(path, &e))?;
    if !metadata.is_file() {
        return Err(LoadError::new(path, None, "not a regular file"));
    }
    if metadata.len() > limit {
        let text = format!("{} bytes; files of more than {limit} bytes are refused", metadata.len());
        return Err(LoadError::new(path, None, text));
    }
    fs::read(path).map_err(|e| LoadError::io(path, &e))
}

/// Line of byte `position`, 1-based.
pub fn line_of(bytes: &[u8], position: usize) -> u32 {
    1 + bytes[..position.min(bytes.len())].iter().filter(|&&b| b == b'\n').count() as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn climbing_out_is_noticed() {
        assert!(!escapes("a/b.ppm") && !escapes("a/../b.ppm") && !escapes("../TextureFiles/b.ppm"));
        assert!(escapes("../b.ppm") && escapes("a/../../b") && escapes("../../etc/passwd"));
    }

    #[test]
    fn lines_count_from_one() {
        assert_eq!((line_of(b"a\nb\nc", 0), line_of(b"a\nb\nc", 2), line_of(b"a\nb\nc", 99)), (1, 2, 3));
    }
}
