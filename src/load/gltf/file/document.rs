//! A glTF file with the bytes of its buffers, and what is said about it while it is read.

use super::container::{self, Parsed};
use super::meshopt;
use crate::load::LoadError;
use crate::load::gltf::json::{BufferView, Root};
use crate::load::input::files::{self, Tree};
use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Corners and moved vertices that every file may have, and how many more for each byte. A mesh uses its numbers more than once
/// when others share them, or has none at all (accessors without data); without a bound a kilobyte could ask for all memory.
const FREE_CORNERS: u64 = 1 << 21;
const CORNERS_PER_BYTE: u64 = 4;

/// Bytes of a buffer, or why there are none.
type Bytes = Result<Arc<[u8]>, String>;

pub struct Document<'a> {
    pub path: &'a Path,
    pub tree: &'a Tree,
    pub root: Root,
    buffers: Vec<Bytes>,
    /// Of the views that are compressed, by view.
    unpacked: HashMap<u32, Vec<u8>>,
    corners_left: Cell<u64>,
    /// What is left out, with the first place and the number of further ones.
    left_out: RefCell<BTreeMap<String, (String, u32)>>,
}

impl<'a> Document<'a> {
    pub fn load(path: &'a Path, tree: &'a Tree) -> Result<Self, LoadError> {
        let file: Arc<[u8]> = files::read(path, files::MAX_FILE_BYTES)?.into();
        let Parsed { root, binary } = container::parse(path, &file)?;
        let mut document = Self {
            path,
            tree,
            root,
            buffers: Vec::new(),
            unpacked: HashMap::new(),
            corners_left: Cell::new(0),
            left_out: RefCell::default(),
        };
        let binary = binary.map(|range| &file[range]);
        let size = document.load_buffers(binary)? + file.len() as u64;
        document.corners_left.set(FREE_CORNERS + CORNERS_PER_BYTE * size);
        document.unpack()?;
        Ok(document)
    }

    /// Reads all buffers, and returns the number of their bytes.
    fn load_buffers(&mut self, mut binary: Option<&[u8]>) -> Result<u64, LoadError> {
        let mut read: HashMap<PathBuf, Arc<[u8]>> = HashMap::new();
        let mut total = 0;
        for (i, buffer) in self.root.buffers.iter().enumerate() {
            let bytes: Bytes = match &buffer.uri {
                Some(uri) => match self.locate(uri).map_err(|why| self.error(format!("buffers[{i}]: {why}")))? {
                    Located::Bytes(bytes) => Ok(bytes.into()),
                    Located::File(file) => match read.get(&file) {
                        Some(known) => Ok(known.clone()),
                        None => {
                            let bytes: Arc<[u8]> = files::read(&file, files::MAX_FILE_BYTES)?.into();
                            read.insert(file, bytes.clone());
                            Ok(bytes)
                        }
                    },
                },
                // What the views of a buffer without bytes hold may be compressed in another one.
                None => match binary.take().filter(|_| i == 0) {
                    Some(bytes) => Ok(bytes.into()),
                    None => Err("it has neither a URI nor a binary chunk".into()),
                },
            };
            let length = bytes.as_ref().map_or(0, |b| b.len() as u64);
            if bytes.is_ok() && length < buffer.byte_length {
                return Err(self.error(format!("buffers[{i}]: {length} bytes instead of {}", buffer.byte_length)));
            }
            total += length;
            self.buffers.push(bytes);
        }
        Ok(total)
    }

    /// Decodes the views that are compressed. What they become is bounded by what their file could hold uncompressed.
    fn unpack(&mut self) -> Result<(), LoadError> {
        let mut unpacked = HashMap::new();
        for (i, view) in self.root.buffer_views.iter().enumerate() {
            let Some(packed) = view.extensions.as_ref().and_then(|e| e.meshopt.as_ref()) else { continue };
            let place = || format!("bufferViews[{i}]");
            let bytes = self.part(packed.buffer, packed.byte_offset, packed.byte_length, place)?;
            // The bound comes before the memory.
            self.spend(packed.count.saturating_mul(packed.byte_stride) / 4, place)?;
            let words = meshopt::decode(packed, bytes).map_err(|why| self.error(format!("{}: {why}", place())))?;
            unpacked.insert(i as u32, words);
        }
        self.unpacked = unpacked;
        Ok(())
    }

    pub fn error(&self, message: String) -> LoadError {
        LoadError::new(self.path, None, message)
    }

    /// Remembers that something of the file is left out; it is said once, with its first place.
    pub fn left_out(&self, place: impl Into<String>, what: impl Into<String>) {
        let mut said = self.left_out.borrow_mut();
        said.entry(what.into()).and_modify(|(_, more)| *more += 1).or_insert_with(|| (place.into(), 0));
    }

    /// What was left out, a line for each kind.
    pub fn warnings(&self) -> Vec<String> {
        let line = |(what, (place, more)): (&String, &(String, u32))| {
            let more = if *more > 0 { format!(" (and {more} more)") } else { String::new() };
            let place = if place.is_empty() { String::new() } else { format!("{place}: ") };
            self.error(format!("{place}{what}{more}")).to_string()
        };
        self.left_out.borrow().iter().map(line).collect()
    }

    /// Takes corners or moved vertices from what the file may have.
    pub fn spend(&self, corners: u64, place: impl Fn() -> String) -> Result<(), LoadError> {
        let left = self.corners_left.get().checked_sub(corners).ok_or_else(|| {
            self.error(format!("{}: the meshes of the file have more corners than a file of its size can", place()))
        })?;
        self.corners_left.set(left);
        Ok(())
    }

    /// An element of one of the arrays of the file.
    pub fn get<'t, T>(
        &self,
        list: &'t [T],
        name: &str,
        index: u32,
        place: impl Fn() -> String,
    ) -> Result<&'t T, LoadError> {
        list.get(index as usize).ok_or_else(|| self.error(format!("{}: there is no {name}[{index}]", place())))
    }

    pub fn view(&self, index: u32, place: impl Fn() -> String) -> Result<(&BufferView, &[u8]), LoadError> {
        let view = self.get(&self.root.buffer_views, "bufferViews", index, place)?;
        if let Some(bytes) = self.unpacked.get(&index) {
            return Ok((view, bytes));
        }
        let place = || format!("bufferViews[{index}]");
        Ok((view, self.part(view.buffer, view.byte_offset, view.byte_length, place)?))
    }

    /// A part of a buffer.
    fn part(&self, buffer: u32, offset: u64, length: u64, place: impl Fn() -> String) -> Result<&[u8], LoadError> {
        let bytes = self.get(&self.buffers, "buffers", buffer, &place)?;
        let bytes = bytes.as_ref().map_err(|why| self.error(format!("buffers[{buffer}]: {why}")))?;
        let end = offset.checked_add(length).and_then(|end| usize::try_from(end).ok());
        end.and_then(|end| bytes.get(offset as usize..end))
            .ok_or_else(|| self.error(format!("{} reaches beyond buffers[{buffer}]", place())))
    }

    /// What a URI stands for: bytes of a `data:` URI, or a file next to the scene. The error says why there is neither.
    pub fn locate(&self, uri: &str) -> Result<Located, String> {
        if let Some(data) = uri.strip_prefix("data:") {
            let (_, encoded) = data.split_once(";base64,").ok_or("a data URI is not base64")?;
            let config = GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent);
            let bytes = GeneralPurpose::new(&STANDARD, config).decode(encoded);
            return bytes.map(Located::Bytes).map_err(|e| format!("a data URI is damaged: {e}"));
        }
        let name = percent_decoded(uri).ok_or_else(|| format!("the URI `{uri}` is damaged"))?;
        let folder = self.path.parent().unwrap_or(Path::new(""));
        self.tree.find_texture(&name, folder).map(Located::File).map_err(|why| format!("file `{name}` {why}"))
    }
}

pub enum Located {
    Bytes(Vec<u8>),
    File(PathBuf),
}

fn percent_decoded(text: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let Some((&first, tail)) = rest.split_first() {
        if first == b'%' {
            let digits = std::str::from_utf8(tail.get(..2)?).ok()?;
            bytes.push(u8::from_str_radix(digits, 16).ok()?);
            rest = &tail[2..];
        } else {
            bytes.push(first);
            rest = tail;
        }
    }
    String::from_utf8(bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percent_signs() {
        assert_eq!(percent_decoded("a%20b.bin").unwrap(), "a b.bin");
        assert!(
            percent_decoded("a%2").is_none() && percent_decoded("%zz").is_none() && percent_decoded("%ff").is_none()
        );
    }
}
