//! Parameter blocks of the user's shader programs.
//!
//! A block is what the C side sees as a struct: every parameter at the offset its class declares, in native byte
//! order. Ints and floats take 4 bytes per component, a matrix 64 (column-major), a texture its 4-byte name, a raw
//! parameter its size, and a string the address of a NUL-terminated copy that lives as long as the frame. Blocks
//! begin at multiples of 16 bytes. Parameters that do not fit into the block are left out.

use crate::memory::{OutOfMemory, Room, repeated, vec_of};
use crate::scene::{Mesh, Name, ParamDef, ParamScope, ParamType, ParamValue, Program, Scene, Shader, ShaderClass};
use std::collections::HashMap;
use std::ffi::CString;
use std::sync::Arc;

/// Alignment of every block, enough for any C struct without extended alignment.
const ALIGN: usize = 16;

/// Bytes that a block of `len` takes, wherever they begin.
fn with_slack(len: usize) -> usize {
    len + ALIGN - 1
}

/// The block of one shader.
#[derive(Clone)]
pub struct Block(Arc<Packed>);

struct Packed {
    storage: Vec<u8>,
    start: usize,
    len: usize,
    /// What the string parameters point to.
    _strings: Vec<CString>,
}

impl Block {
    pub fn pack(shader: &Shader) -> Result<Self, OutOfMemory> {
        let len = shader.class.block_size as usize;
        let mut storage = repeated(0u8, with_slack(len))?;
        let start = storage.as_ptr().align_offset(ALIGN).min(ALIGN - 1);
        let is_text = |value: &&ParamValue| matches!(value, ParamValue::String(_));
        let mut strings = vec_of(shader.values.iter().filter(is_text).count())?;
        for (def, value) in shader.class.params.iter().zip(&shader.values) {
            pack_value(&mut storage[start..start + len], def, value, &mut strings)?;
        }
        Ok(Self(Arc::new(Packed { storage, start, len, _strings: strings })))
    }

    /// Bytes of memory that [`Block::patched`] asks for.
    pub fn patch_bytes(&self) -> usize {
        with_slack(self.0.len)
    }

    pub fn bytes(&self) -> &[u8] {
        let Packed { storage, start, len, .. } = &*self.0;
        &storage[*start..start + len]
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
        scratch.resize(self.patch_bytes(), 0);
        let start = scratch.as_ptr().align_offset(ALIGN).min(ALIGN - 1);
        let bytes = &mut scratch[start..start + self.0.len];
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

/// The blocks of the scene's shaders that have a program of the user's, packed anew when a value has changed.
#[derive(Default)]
pub struct Blocks {
    packed: HashMap<Name, (u64, Block)>,
}

impl Blocks {
    /// Packs what is new in the scene and forgets what is gone.
    ///
    /// # Errors
    /// No memory; the next update tries again.
    pub fn update(&mut self, scene: &Scene) -> Result<(), OutOfMemory> {
        let is_current = |name: &Name, version| scene.shaders.get(name).is_some_and(|s| s.version == version);
        self.packed.retain(|name, (version, _)| is_current(name, *version));
        for (&name, shader) in &scene.shaders {
            if !matches!(shader.class.program, Program::BuiltIn) && !self.packed.contains_key(&name) {
                self.packed.room(1)?;
                self.packed.insert(name, (shader.version, Block::pack(shader)?));
            }
        }
        Ok(())
    }

    /// The block of a shader that has one.
    pub fn get(&self, shader: Name) -> Option<Block> {
        self.packed.get(&shader).map(|(_, block)| block.clone())
    }
}

fn pack_value(
    bytes: &mut [u8],
    def: &ParamDef,
    value: &ParamValue,
    strings: &mut Vec<CString>,
) -> Result<(), OutOfMemory> {
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
            let mut bytes_of_text = vec_of(text.len() + 1)?;
            bytes_of_text.extend_from_slice(text.as_bytes());
            bytes_of_text.push(0);
            let text = CString::from_vec_with_nul(bytes_of_text).expect("cut before the first NUL");
            put(bytes, def, 0, &(text.as_ptr() as usize).to_ne_bytes());
            strings.push(text);
        }
        _ => {}
    }
    Ok(())
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
