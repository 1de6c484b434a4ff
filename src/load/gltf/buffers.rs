//! Bytes of a glTF file: buffers, data URIs, and accessors with every bound checked.
//!
//! The `gltf` crate checks that indices in the JSON exist; whether an accessor lies inside its buffer is checked here, so
//! that no count in the file is believed before the bytes behind it have been seen.

use crate::load::LoadError;
use crate::load::input::files::{self, Tree};
use ::gltf::accessor::{DataType, Dimensions};
use std::path::Path;

/// Largest accessor that has no bytes behind it (all zero but for sparse values).
const MAX_ZERO_COUNT: usize = 1 << 24;

pub struct Buffers<'a> {
    path: &'a Path,
    tree: &'a Tree,
    bytes: Vec<Vec<u8>>,
}

impl<'a> Buffers<'a> {
    pub fn load(path: &'a Path, tree: &'a Tree, gltf: &mut ::gltf::Gltf) -> Result<Self, LoadError> {
        let mut all = Self { path, tree, bytes: Vec::new() };
        let mut blob = gltf.blob.take();
        for buffer in gltf.document.buffers() {
            let bytes = match buffer.source() {
                gltf::buffer::Source::Bin => blob.take().ok_or_else(|| all.error("there is no binary chunk".into()))?,
                gltf::buffer::Source::Uri(uri) => all.uri(uri)?,
            };
            if bytes.len() < buffer.length() {
                let text =
                    format!("buffer {} has {} bytes instead of {}", buffer.index(), bytes.len(), buffer.length());
                return Err(all.error(text));
            }
            all.bytes.push(bytes);
        }
        Ok(all)
    }

    pub fn error(&self, message: String) -> LoadError {
        LoadError::new(self.path, None, message)
    }

    /// Contents of a `data:` URI or of a file next to the scene.
    pub fn uri(&self, uri: &str) -> Result<Vec<u8>, LoadError> {
        if let Some(data) = uri.strip_prefix("data:") {
            let (_, encoded) =
                data.split_once(";base64,").ok_or_else(|| self.error("a data URI is not base64".into()))?;
            return base64(encoded).ok_or_else(|| self.error("a data URI is damaged".into()));
        }
        let name = percent_decoded(uri).ok_or_else(|| self.error(format!("URI `{uri}` is damaged")))?;
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let file = self.tree.find_texture(&name, folder).map_err(|why| self.error(format!("file `{name}` {why}")))?;
        files::read(&file, files::MAX_FILE_BYTES)
    }

    pub fn view(&self, view: &gltf::buffer::View) -> Result<&[u8], LoadError> {
        let end = view.offset().checked_add(view.length());
        end.and_then(|end| self.bytes.get(view.buffer().index())?.get(view.offset()..end))
            .ok_or_else(|| self.error(format!("buffer view {} reaches beyond its buffer", view.index())))
    }

    /// All components as floats; normalised integers become shares as the specification says.
    pub fn floats(&self, accessor: &gltf::Accessor, width: usize) -> Result<Vec<f32>, LoadError> {
        let data_type = accessor.data_type();
        let scale = |max: f32, raw: f32| if accessor.normalized() { (raw / max).max(-1.0) } else { raw };
        self.read(accessor, width, |b| match data_type {
            DataType::I8 => scale(127.0, f32::from(b[0] as i8)),
            DataType::U8 => scale(255.0, f32::from(b[0])),
            DataType::I16 => scale(32767.0, f32::from(i16::from_le_bytes([b[0], b[1]]))),
            DataType::U16 => scale(65535.0, f32::from(u16::from_le_bytes([b[0], b[1]]))),
            DataType::U32 => u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as f32,
            DataType::F32 => f32::from_le_bytes([b[0], b[1], b[2], b[3]]),
        })
    }

    /// All components as unsigned integers.
    pub fn integers(&self, accessor: &gltf::Accessor, width: usize) -> Result<Vec<u32>, LoadError> {
        let data_type = accessor.data_type();
        if matches!(data_type, DataType::F32 | DataType::I8 | DataType::I16) {
            return Err(self.error(format!("accessor {} should hold unsigned integers", accessor.index())));
        }
        self.read(accessor, width, |b| match data_type {
            DataType::U8 => u32::from(b[0]),
            DataType::U16 => u32::from(u16::from_le_bytes([b[0], b[1]])),
            _ => u32::from_le_bytes([b[0], b[1], b[2], b[3]]),
        })
    }

    fn read<T: Copy + Default>(
        &self,
        accessor: &gltf::Accessor,
        width: usize,
        decode: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, LoadError> {
        let components = match accessor.dimensions() {
            Dimensions::Scalar => 1,
            Dimensions::Vec2 => 2,
            Dimensions::Vec3 => 3,
            Dimensions::Vec4 | Dimensions::Mat2 => 4,
            Dimensions::Mat3 => 9,
            Dimensions::Mat4 => 16,
        };
        if components != width {
            let text = format!("accessor {} has {components} components instead of {width}", accessor.index());
            return Err(self.error(text));
        }
        let size = accessor.data_type().size();
        let count = accessor.count();
        let mut values = match accessor.view() {
            Some(view) => {
                let stride = view.stride().unwrap_or(size * width);
                self.strided(self.view(&view)?, accessor.offset(), stride, count, (size, width), &decode)
                    .ok_or_else(|| self.error(format!("accessor {} reaches beyond its view", accessor.index())))?
            }
            None if count <= MAX_ZERO_COUNT => vec![T::default(); count * width],
            None => return Err(self.error(format!("accessor {} has {count} entries without data", accessor.index()))),
        };
        if let Some(sparse) = accessor.sparse() {
            self.apply_sparse(&sparse, &mut values, (size, width), &decode)
                .ok_or_else(|| self.error(format!("the sparse part of accessor {} is damaged", accessor.index())))?;
        }
        Ok(values)
    }

    fn strided<T>(
        &self,
        bytes: &[u8],
        offset: usize,
        stride: usize,
        count: usize,
        (size, width): (usize, usize),
        decode: &impl Fn(&[u8]) -> T,
    ) -> Option<Vec<T>> {
        let entry = size * width;
        if count == 0 {
            return Some(Vec::new());
        }
        let last = stride.checked_mul(count - 1)?.checked_add(offset)?.checked_add(entry)?;
        if stride == 0 || last > bytes.len() {
            return None;
        }
        let mut values = Vec::with_capacity(count * width);
        for i in 0..count {
            let entry = &bytes[offset + i * stride..][..entry];
            values.extend(entry.chunks_exact(size).map(decode));
        }
        Some(values)
    }

    fn apply_sparse<T: Copy>(
        &self,
        sparse: &gltf::accessor::sparse::Sparse,
        values: &mut [T],
        (size, width): (usize, usize),
        decode: &impl Fn(&[u8]) -> T,
    ) -> Option<()> {
        use gltf::accessor::sparse::IndexType;
        let count = sparse.count();
        let indices = sparse.indices();
        let index_size = match indices.index_type() {
            IndexType::U8 => 1,
            IndexType::U16 => 2,
            IndexType::U32 => 4,
        };
        let view = self.view(&indices.view()).ok()?;
        let numbers = self.strided(view, indices.offset(), index_size, count, (index_size, 1), &|b: &[u8]| {
            b.iter().rev().fold(0_usize, |n, &byte| n << 8 | usize::from(byte))
        })?;
        let source = sparse.values();
        let view = self.view(&source.view()).ok()?;
        let replacements = self.strided(view, source.offset(), size * width, count, (size, width), decode)?;
        for (number, replacement) in numbers.into_iter().zip(replacements.chunks_exact(width)) {
            let first = number.checked_mul(width)?;
            values.get_mut(first..first + width)?.copy_from_slice(replacement);
        }
        Some(())
    }
}

/// Standard alphabet, padding optional; white space is not allowed.
fn base64(text: &str) -> Option<Vec<u8>> {
    let text = text.trim_end_matches('=').as_bytes();
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3 + 2);
    for group in text.chunks(4) {
        if group.len() == 1 {
            return None;
        }
        let mut bits = 0_u32;
        for i in 0..4 {
            let sextet = match group.get(i) {
                None => 0,
                Some(c @ b'A'..=b'Z') => c - b'A',
                Some(c @ b'a'..=b'z') => c - b'a' + 26,
                Some(c @ b'0'..=b'9') => c - b'0' + 52,
                Some(b'+' | b'-') => 62,
                Some(b'/' | b'_') => 63,
                Some(_) => return None,
            };
            bits = bits << 6 | u32::from(sextet);
        }
        bytes.extend(&bits.to_be_bytes()[1..group.len()]);
    }
    Some(bytes)
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
    fn base64_of_every_length() {
        let cases = [("", ""), ("Zg==", "f"), ("Zm8=", "fo"), ("Zm9v", "foo"), ("Zm9vYg", "foob"), ("+/+/", "\u{0}")];
        for (text, plain) in &cases[..5] {
            assert_eq!(base64(text).unwrap(), plain.as_bytes());
        }
        assert_eq!(base64(cases[5].0).unwrap(), [0xfb, 0xff, 0xbf]);
        assert!(base64("Z").is_none() && base64("Zm9 ").is_none());
    }

    #[test]
    fn percent_signs() {
        assert_eq!(percent_decoded("a%20b.bin").unwrap(), "a b.bin");
        assert!(
            percent_decoded("a%2").is_none() && percent_decoded("%zz").is_none() && percent_decoded("%ff").is_none()
        );
    }
}
