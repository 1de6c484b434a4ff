//! From the bytes of a `.gltf` or `.glb` file to its JSON and its binary chunk.

use crate::load::LoadError;
use crate::load::gltf::json::Root;
use crate::load::input::files::line_of;
use serde::Deserialize;
use serde::de::{Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde_json::Value;
use std::fmt;
use std::ops::Range;
use std::path::Path;

/// Most objects (`{`) of the JSON. Each becomes a few hundred bytes of memory.
const MAX_OBJECTS: usize = 1 << 22;

/// A parsed file.
pub struct Parsed {
    pub root: Root,
    /// Where the binary chunk of a `.glb` lies.
    pub binary: Option<Range<usize>>,
}

pub fn parse(path: &Path, bytes: &[u8]) -> Result<Parsed, LoadError> {
    if !bytes.starts_with(b"glTF") {
        return Ok(Parsed { root: parse_json(path, bytes, true)?, binary: None });
    }
    let error = |text: &str| LoadError::new(path, None, text);
    match word(bytes, 4) {
        Some(2) => {}
        Some(1) => return Err(error("this is binary glTF 1.0; only glTF 2.0 is read")),
        _ => return Err(error("this is binary glTF of an unknown version; only glTF 2.0 is read")),
    }
    let (json, binary) = chunks(bytes).ok_or_else(|| error("the chunks of the binary file do not fit the file"))?;
    let root = parse_json(path, &bytes[json], false)?;
    Ok(Parsed { root, binary })
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(bytes.get(at..at.checked_add(4)?)?.try_into().ok()?))
}

/// The JSON chunk, which comes first, and the binary one; chunks of other types are passed over.
fn chunks(bytes: &[u8]) -> Option<(Range<usize>, Option<Range<usize>>)> {
    const JSON: u32 = u32::from_le_bytes(*b"JSON");
    const BIN: u32 = u32::from_le_bytes(*b"BIN\0");
    let end = bytes.len().min(word(bytes, 8)? as usize);
    let (mut json, mut binary) = (None, None);
    let mut at = 12;
    while at + 8 <= end {
        let (length, kind) = (word(bytes, at)? as usize, word(bytes, at + 4)?);
        let chunk = at + 8..(at + 8).checked_add(length)?;
        if chunk.end > bytes.len() {
            return None;
        }
        at = chunk.end;
        match kind {
            JSON if json.is_none() => json = Some(chunk),
            BIN if binary.is_none() => binary = Some(chunk),
            _ => {}
        }
    }
    Some((json?, binary))
}

fn parse_json(path: &Path, text: &[u8], lines: bool) -> Result<Root, LoadError> {
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    if text.iter().filter(|&&b| b == b'{').count() > MAX_OBJECTS {
        return Err(LoadError::new(path, None, format!("more than {MAX_OBJECTS} objects in the JSON of the file")));
    }
    if let Some(version) = other_version(text) {
        return Err(LoadError::new(path, None, format!("this is glTF {version}; only glTF 2.0 is read")));
    }
    let root: Root = serde_json::from_slice(text).map_err(|error| {
        // The message ends in the place, which we have said already.
        let message = error.to_string();
        let message = message.split(" at line ").next().unwrap_or_default();
        // In a `.glb` the lines of the JSON chunk mean nothing to the user.
        let line = lines.then(|| (error.line() as u32).clamp(1, line_of(text, text.len())));
        LoadError::new(path, line, format!("not glTF: {message}"))
    })?;
    if root.asset.version.is_none() {
        return Err(LoadError::new(path, None, "not glTF: there is no `asset` with a `version`"));
    }
    Ok(root)
}

/// The version of a file that is glTF, but not 2. Version 1 had dictionaries where version 2 has arrays, so it is
/// asked before anything else is understood.
fn other_version(text: &[u8]) -> Option<String> {
    #[derive(Deserialize, Default)]
    #[serde(rename_all = "camelCase", default)]
    struct Versions {
        version: Value,
        min_version: Value,
    }
    #[derive(Deserialize, Default)]
    #[serde(default)]
    struct Probe {
        asset: Versions,
        meshes: Dictionary,
    }
    let probe: Probe = serde_json::from_slice(text).ok()?;
    let text = |value: &Value| match value {
        Value::String(text) => Some(text.clone()),
        Value::Number(number) => Some(number.to_string()),
        _ => None,
    };
    let asked = text(&probe.asset.min_version).or_else(|| text(&probe.asset.version));
    match asked {
        Some(version) if version.split('.').next() != Some("2") => Some(version),
        None if probe.meshes.0 => Some("1.0".into()),
        _ => None,
    }
}

/// Whether a value is an object; its content is not kept.
#[derive(Default)]
struct Dictionary(bool);

impl<'de> Deserialize<'de> for Dictionary {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Look;
        impl<'de> Visitor<'de> for Look {
            type Value = Dictionary;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("an array or an object")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Dictionary, A::Error> {
                while map.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {}
                Ok(Dictionary(true))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Dictionary, A::Error> {
                while list.next_element::<IgnoredAny>()?.is_some() {}
                Ok(Dictionary(false))
            }
        }
        deserializer.deserialize_any(Look)
    }
}
