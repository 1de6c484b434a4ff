//! The values behind the header, one after the other.

use super::header::{Encoding, Header, Kind};
use crate::load::LoadError;
use crate::load::input::lexer::show;
use std::path::Path;

/// Reads values. Those of text are words between blanks: an element may go over several lines, and a line may hold several.
pub struct Values<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    position: usize,
    encoding: Encoding,
    /// Of the next byte of text.
    line: u32,
}

impl<'a> Values<'a> {
    pub fn new(path: &'a Path, bytes: &'a [u8], header: &Header) -> Self {
        Self { path, bytes, position: header.length, encoding: header.encoding, line: header.line }
    }

    /// A fault at the value read last: its line of text, or its byte.
    pub fn error(&self, message: impl Into<String>) -> LoadError {
        let message = message.into();
        match self.encoding {
            Encoding::Ascii => LoadError::new(self.path, Some(self.line), message),
            _ => LoadError::new(self.path, None, format!("at byte {}: {message}", self.position)),
        }
    }

    /// Line of the value read last, where there are lines.
    pub fn line(&self) -> Option<u32> {
        (self.encoding == Encoding::Ascii).then_some(self.line)
    }

    pub fn bytes_left(&self) -> usize {
        self.bytes.len() - self.position
    }

    /// Whether anything but blanks is left.
    pub fn any_left(&self) -> bool {
        match self.encoding {
            Encoding::Ascii => !self.bytes[self.position..].trim_ascii().is_empty(),
            _ => self.bytes_left() > 0,
        }
    }

    /// The next value. Integers of all kinds are exact in `f64`; text may say `nan` and `inf`.
    pub fn next(&mut self, kind: Kind, what: &str) -> Result<f64, LoadError> {
        match self.encoding {
            Encoding::Ascii => {
                let word = self.word();
                if word.is_empty() {
                    return Err(self.error(format!("the file ends where {what} is expected")));
                }
                let number = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok());
                number.ok_or_else(|| self.error(format!("{what} is expected, found `{}`", show(word))))
            }
            encoding => {
                let Some(bytes) = self.bytes[self.position..].get(..kind.size()) else {
                    return Err(self.error(format!("the file ends where {what} is expected")));
                };
                let value = decode(kind, bytes, encoding == Encoding::BigEndian);
                self.position += kind.size();
                Ok(value)
            }
        }
    }

    fn word(&mut self) -> &'a [u8] {
        while let Some(b) = self.bytes.get(self.position).filter(|b| b.is_ascii_whitespace()) {
            let is_end = *b == b'\n' || (*b == b'\r' && self.bytes.get(self.position + 1) != Some(&b'\n'));
            self.line += u32::from(is_end);
            self.position += 1;
        }
        let rest = &self.bytes[self.position..];
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.position += length;
        &rest[..length]
    }

    /// The number in front of a list, which the rest of the file must be able to hold.
    pub fn length(&mut self, count: Kind, kind: Kind, what: &str) -> Result<usize, LoadError> {
        let value = self.next(count, "the length of a list")?;
        let least = if self.encoding == Encoding::Ascii { 2 } else { kind.size() };
        // The last value of text needs no blank behind it.
        let most = (self.bytes_left() + 1) / least;
        if value.fract() != 0.0 || value < 0.0 || value > most as f64 {
            return Err(self.error(format!("{what} cannot have {value} values")));
        }
        Ok(value as usize)
    }

    /// Reads past a value or a list.
    pub fn skip(&mut self, kind: Kind, list: Option<Kind>) -> Result<(), LoadError> {
        let count = match list {
            Some(count) => self.length(count, kind, "a list")?,
            None => 1,
        };
        for _ in 0..count {
            self.next(kind, "a value")?;
        }
        Ok(())
    }
}

fn decode(kind: Kind, bytes: &[u8], big: bool) -> f64 {
    /// The value of `$bytes` as type `$t`.
    macro_rules! of {
        ($t:ty) => {{
            let bytes = bytes.try_into().expect("as many bytes as the kind has");
            if big { <$t>::from_be_bytes(bytes) } else { <$t>::from_le_bytes(bytes) }
        }};
    }
    match kind {
        Kind::I8 => f64::from(of!(i8)),
        Kind::U8 => f64::from(of!(u8)),
        Kind::I16 => f64::from(of!(i16)),
        Kind::U16 => f64::from(of!(u16)),
        Kind::I32 => f64::from(of!(i32)),
        Kind::U32 => f64::from(of!(u32)),
        Kind::F32 => f64::from(of!(f32)),
        Kind::F64 => of!(f64),
    }
}
