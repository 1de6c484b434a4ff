//! Parameter values and their bytes.

use crate::scene::{ParamType, ParamValue};
use std::fmt;

/// Bytes of a parameter of type `ty` in a parameter block; a string is a pointer there.
pub(super) fn byte_size(ty: ParamType) -> usize {
    match ty {
        ParamType::Int(n) | ParamType::Float(n) => 4 * usize::from(n),
        ParamType::Matrix => 64,
        ParamType::String => size_of::<usize>(),
        ParamType::Texture => 4,
        ParamType::Raw(n) => n as usize,
    }
}

/// `values`, at most four of them, followed by zeros.
pub(super) fn zero_padded<T: Copy + Default>(values: &[T]) -> [T; 4] {
    std::array::from_fn(|i| values.get(i).copied().unwrap_or_default())
}

/// A value of type `ty` from its native-endian bytes; None for strings and for another number of bytes.
pub(super) fn from_bytes(ty: ParamType, bytes: &[u8]) -> Option<ParamValue> {
    if bytes.len() != byte_size(ty) {
        return None;
    }
    let word = |i: usize| bytes.get(4 * i..4 * i + 4).and_then(|b| b.try_into().ok()).unwrap_or([0; 4]);
    Some(match ty {
        ParamType::Int(_) => ParamValue::Int(std::array::from_fn(|i| i32::from_ne_bytes(word(i)))),
        ParamType::Float(_) => ParamValue::Float(std::array::from_fn(|i| f32::from_ne_bytes(word(i)))),
        ParamType::Matrix => ParamValue::Matrix(std::array::from_fn(|i| f32::from_ne_bytes(word(i)))),
        ParamType::Texture => ParamValue::Texture(u32::from_ne_bytes(word(0))),
        ParamType::Raw(_) => ParamValue::Raw(bytes.into()),
        ParamType::String => return None,
    })
}

/// A type in words, with its article.
pub(super) struct Described(pub ParamType);

impl fmt::Display for Described {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            ParamType::Int(1) => f.write_str("an integer"),
            ParamType::Int(n) => write!(f, "{n} integers"),
            ParamType::Float(1) => f.write_str("a float"),
            ParamType::Float(n) => write!(f, "{n} floats"),
            ParamType::Matrix => f.write_str("a matrix of 16 floats"),
            ParamType::String => f.write_str("a string"),
            ParamType::Texture => f.write_str("a texture"),
            ParamType::Raw(n) => write!(f, "{n} bytes"),
        }
    }
}
