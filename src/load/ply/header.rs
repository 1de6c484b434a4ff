//! The header of a PLY file: which elements with which properties follow, and how they are written.

use crate::load::LoadError;
use crate::load::input::lexer::show;
use crate::load::input::lines::{decoded, keyword, words};
use std::path::Path;

/// How the values behind the header are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// Type of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Kind {
    fn named(word: &[u8]) -> Option<Self> {
        Some(match word {
            b"char" | b"int8" => Kind::I8,
            b"uchar" | b"uint8" => Kind::U8,
            b"short" | b"int16" => Kind::I16,
            b"ushort" | b"uint16" => Kind::U16,
            b"int" | b"int32" => Kind::I32,
            b"uint" | b"uint32" => Kind::U32,
            b"float" | b"float32" => Kind::F32,
            b"double" | b"float64" => Kind::F64,
            _ => return None,
        })
    }

    /// Bytes of a binary value.
    pub fn size(self) -> usize {
        match self {
            Kind::I8 | Kind::U8 => 1,
            Kind::I16 | Kind::U16 => 2,
            Kind::I32 | Kind::U32 | Kind::F32 => 4,
            Kind::F64 => 8,
        }
    }
}

#[derive(Clone, Debug)]
pub struct Property {
    pub name: String,
    /// Of the value, or of the values of the list.
    pub kind: Kind,
    /// Of the number in front of a list.
    pub list: Option<Kind>,
}

#[derive(Clone, Debug)]
pub struct Element {
    pub name: String,
    pub count: usize,
    pub properties: Vec<Property>,
}

impl Element {
    pub fn has(&self, name: &str) -> bool {
        self.properties.iter().any(|p| p.name == name)
    }

    /// Fewest bytes that one element takes: its values, with empty lists.
    pub fn least_bytes(&self, encoding: Encoding) -> usize {
        match encoding {
            // A digit and a blank.
            Encoding::Ascii => 2 * self.properties.len(),
            _ => self.properties.iter().map(|p| p.list.unwrap_or(p.kind).size()).sum(),
        }
    }
}

#[derive(Clone, Debug)]
pub struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// Images named in comments `TextureFile`, with their lines.
    pub textures: Vec<(u32, String)>,
    /// Words that no line of a header begins with, with their lines.
    pub unknown: Vec<(u32, String)>,
    /// Where the data begins: its byte and its line.
    pub length: usize,
    pub line: u32,
}

/// Reads the header of `bytes`.
pub fn read(path: &Path, bytes: &[u8]) -> Result<Header, LoadError> {
    let mut header = Header {
        encoding: Encoding::Ascii,
        elements: Vec::new(),
        textures: Vec::new(),
        unknown: Vec::new(),
        length: 0,
        line: 0,
    };
    let mut has_format = false;
    // What ends the first line ends all: in a binary file a byte 10 behind a CR may be data.
    let end = bytes.iter().position(|&b| b == b'\n' || b == b'\r').unwrap_or(bytes.len());
    let separator: &[u8] = if bytes[end..].starts_with(b"\r\n") {
        b"\r\n"
    } else if bytes[end..].starts_with(b"\r") {
        b"\r"
    } else {
        b"\n"
    };
    loop {
        let rest = &bytes[header.length..];
        header.line += 1;
        let fault = |text: String| LoadError::new(path, Some(header.line), text);
        let Some(length) = rest.windows(separator.len()).position(|w| w == separator) else {
            return Err(fault("the header has no `end_header`".into()));
        };
        let line = &rest[..length];
        header.length += length + separator.len();
        let (word, rest) = keyword(line);
        match (header.line, word) {
            (1, b"ply") => {}
            (1, _) => return Err(fault("the file does not begin with `ply`".into())),
            (_, b"format") => {
                header.encoding = match words(rest).next() {
                    Some(b"ascii") => Encoding::Ascii,
                    Some(b"binary_little_endian") => Encoding::LittleEndian,
                    Some(b"binary_big_endian") => Encoding::BigEndian,
                    _ => return Err(fault(format!("unknown format `{}`", show(rest)))),
                };
                has_format = true;
            }
            (line, b"comment" | b"obj_info") => {
                let (word, name) = keyword(rest);
                if word.eq_ignore_ascii_case(b"texturefile") && !name.is_empty() {
                    header.textures.push((line, decoded(name)));
                }
            }
            (_, b"element") => {
                let mut parts = words(rest);
                let name = parts.next().map(decoded);
                let count = parts.next().and_then(|w| std::str::from_utf8(w).ok()?.parse().ok());
                match (name, count) {
                    (Some(name), Some(count)) => {
                        header.elements.push(Element { name, count, properties: Vec::new() });
                    }
                    _ => return Err(fault(format!("a name and a count are expected: `element {}`", show(rest)))),
                }
            }
            (_, b"property") => {
                let property = property(rest).ok_or_else(|| fault(format!("unknown property `{}`", show(rest))))?;
                match header.elements.last_mut() {
                    Some(element) => element.properties.push(property),
                    None => return Err(fault("a property without an element".into())),
                }
            }
            (_, b"end_header") => break,
            (_, b"") => {}
            (line, _) => header.unknown.push((line, show(word))),
        }
    }
    if !has_format {
        return Err(LoadError::new(path, Some(header.line), "the header has no `format`"));
    }
    header.line += 1;
    Ok(header)
}

/// `kind name` or `list count-kind kind name`.
fn property(rest: &[u8]) -> Option<Property> {
    let parts: Vec<&[u8]> = words(rest).collect();
    match parts[..] {
        [b"list", count, kind, name] => {
            Some(Property { name: decoded(name), kind: Kind::named(kind)?, list: Some(Kind::named(count)?) })
        }
        [kind, name] => Some(Property { name: decoded(name), kind: Kind::named(kind)?, list: None }),
        _ => None,
    }
}
