//! Parameter blocks of the user's shader programs.
//!
//! A block is what the C side sees as a struct: every parameter at the offset its class declares, in native byte
//! order. Ints and floats take 4 bytes per component, a matrix 64 (column-major), a texture its 4-byte name, a raw
//! parameter its size, and a string the address of a NUL-terminated copy that lives as long as the frame. Blocks
//! begin at multiples of 16 bytes. Parameters that do not fit into the block are left out.

use crate::scene::{Mesh, Name, ParamDef, ParamScope, ParamType, ParamValue, Shader, ShaderClass};
use std::ffi::CString;
use std::sync::Arc;

/// Alignment of every block, enough for any C struct without extended alignment.
const ALIGN: usize = 16;

/// The block of one shader, packed at frame start.
#[derive(Clone)]
pub struct Block {
    storage: Arc<[u8]>,
    start: usize,
    len: usize,
    /// What the string parameters point to.
    _strings: Arc<[CString]>,
}

impl Block {
    pub fn pack(shader: &Shader) -> Self {
        let len = shader.class.block_size as usize;
        let mut strings = Vec::new();
        let storage: Arc<[u8]> = vec![0u8; len + ALIGN - 1].into();
        let start = storage.as_ptr().align_offset(ALIGN).min(ALIGN - 1);
        let mut bytes = vec![0u8; len];
        for (def, value) in shader.class.params.iter().zip(&shader.values) {
            pack_value(&mut bytes, def, value, &mut strings);
        }
        let mut block = Self { storage, start, len, _strings: strings.into() };
        let storage = Arc::get_mut(&mut block.storage).expect("nobody else has the new storage");
        storage[start..start + len].copy_from_slice(&bytes);
        block
    }

    pub fn bytes(&self) -> &[u8] {
        &self.storage[self.start..self.start + self.len]
    }

    /// Fills `scratch` with the block as triangle `prim` sees it: with its values of the mesh's parameter streams.
    /// `weights` are those of the corners. Returns where in `scratch` the block lies.
    pub fn patched<'s>(
        &self,
        scratch: &'s mut Vec<u8>,
        shader: Name,
        class: &ShaderClass,
        mesh: &Mesh,
        prim: u32,
        weights: [f32; 3],
    ) -> &'s [u8] {
        scratch.resize(self.len + ALIGN - 1, 0);
        let start = scratch.as_ptr().align_offset(ALIGN).min(ALIGN - 1);
        let bytes = &mut scratch[start..start + self.len];
        bytes.copy_from_slice(self.bytes());
        for stream in mesh.params.iter().filter(|s| s.shader == shader) {
            let Some(def) = class.params.get(stream.param as usize) else { continue };
            let width = (stream.width as usize).min(4);
            let entry = |i: u32| -> [f32; 4] {
                let begin = i as usize * stream.width as usize;
                let values = stream.data.get(begin..begin + width).unwrap_or(&[]);
                std::array::from_fn(|k| values.get(k).copied().unwrap_or(0.0))
            };
            let value = match def.scope {
                ParamScope::Shader => continue,
                ParamScope::Triangle => entry(prim),
                ParamScope::Vertex => {
                    let corners = mesh.triangles[prim as usize].map(entry);
                    std::array::from_fn(|k| {
                        corners[0][k] * weights[0] + corners[1][k] * weights[1] + corners[2][k] * weights[2]
                    })
                }
            };
            pack_numbers(bytes, def, value);
        }
        bytes
    }
}

fn pack_value(bytes: &mut [u8], def: &ParamDef, value: &ParamValue, strings: &mut Vec<CString>) {
    match (def.ty, value) {
        (ParamType::Int(n), ParamValue::Int(v)) => {
            v.iter().take(n.into()).enumerate().for_each(|(k, i)| put(bytes, def, 4 * k, &i.to_ne_bytes()));
        }
        (ParamType::Int(_) | ParamType::Float(_), ParamValue::Float(v)) => pack_numbers(bytes, def, *v),
        (ParamType::Float(_), ParamValue::Int(v)) => pack_numbers(bytes, def, v.map(|i| i as f32)),
        (ParamType::Matrix, ParamValue::Matrix(m)) => {
            m.iter().enumerate().for_each(|(k, x)| put(bytes, def, 4 * k, &x.to_ne_bytes()));
        }
        (ParamType::Texture, ParamValue::Texture(name)) => put(bytes, def, 0, &name.to_ne_bytes()),
        (ParamType::Raw(size), ParamValue::Raw(raw)) => put(bytes, def, 0, &raw[..raw.len().min(size as usize)]),
        (ParamType::String, ParamValue::String(text)) => {
            // A C string ends at its first NUL.
            let text = text.split('\0').next().expect("split yields at least one part");
            let text = CString::new(text).expect("cut before the first NUL");
            put(bytes, def, 0, &(text.as_ptr() as usize).to_ne_bytes());
            strings.push(text);
        }
        _ => {}
    }
}

/// Floats into a float or int parameter.
fn pack_numbers(bytes: &mut [u8], def: &ParamDef, values: [f32; 4]) {
    match def.ty {
        ParamType::Float(n) => {
            values.iter().take(n.into()).enumerate().for_each(|(k, x)| put(bytes, def, 4 * k, &x.to_ne_bytes()));
        }
        ParamType::Int(n) => {
            let ints = values.map(|x| x.round() as i32);
            ints.iter().take(n.into()).enumerate().for_each(|(k, i)| put(bytes, def, 4 * k, &i.to_ne_bytes()));
        }
        _ => {}
    }
}

fn put(bytes: &mut [u8], def: &ParamDef, offset: usize, data: &[u8]) {
    let begin = def.offset as usize + offset;
    if let Some(place) = bytes.get_mut(begin..begin.saturating_add(data.len())) {
        place.copy_from_slice(data);
    }
}
