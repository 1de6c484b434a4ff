//! Words and numbers of an NFF or AFF file, with the line that each stands on.

use crate::load::LoadError;
use std::path::Path;

/// Reads words separated by white space. `#` and `%` start a comment to the end of the line; braces are words of
/// their own. Bytes that are not UTF-8 may stand in comments (BART has some) and in unknown statements.
#[derive(Clone)]
pub struct Lexer<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    position: usize,
    /// Line of the next byte.
    next_line: u32,
    /// Line of the word read last.
    line: u32,
}

impl<'a> Lexer<'a> {
    pub fn new(path: &'a Path, bytes: &'a [u8]) -> Self {
        Self { path, bytes, position: 0, next_line: 1, line: 1 }
    }

    /// The file.
    pub fn path(&self) -> &'a Path {
        self.path
    }

    /// Line of the word read last.
    pub fn line(&self) -> u32 {
        self.line
    }

    pub fn error(&self, message: impl Into<String>) -> LoadError {
        LoadError::new(self.path, Some(self.line), message)
    }

    fn skip_blank(&mut self) {
        while let Some(&b) = self.bytes.get(self.position) {
            match b {
                b'\n' => self.next_line += 1,
                // CR alone ends lines of old Macintosh files.
                b'\r' if self.bytes.get(self.position + 1) != Some(&b'\n') => self.next_line += 1,
                b'#' | b'%' => {
                    self.skip_line();
                    continue;
                }
                _ if b.is_ascii_whitespace() || b == 0x0b || b == 0x1a => {}
                _ => return,
            }
            self.position += 1;
        }
    }

    /// Goes to the end of the current line, not past it.
    pub fn skip_line(&mut self) {
        let rest = &self.bytes[self.position..];
        self.position += rest.iter().position(|&b| b == b'\n' || b == b'\r').unwrap_or(rest.len());
    }

    /// The next word; `None` at the end of the file.
    pub fn word(&mut self) -> Option<&'a [u8]> {
        self.skip_blank();
        self.line = self.next_line;
        let start = self.position;
        let rest = &self.bytes[start..];
        let length = match rest.first()? {
            b'{' | b'}' => 1,
            _ => rest
                .iter()
                .position(|b| b.is_ascii_whitespace() || matches!(b, b'{' | b'}' | b'#' | b'%'))
                .unwrap_or(rest.len()),
        };
        self.position += length;
        Some(&rest[..length])
    }

    /// The next word without taking it.
    pub fn peek(&self) -> Option<&'a [u8]> {
        self.clone().word()
    }

    /// A name or a path: any characters but white space and braces.
    pub fn name(&mut self, what: &str) -> Result<&'a str, LoadError> {
        match self.word() {
            None => Err(self.error(format!("the file ends where {what} is expected"))),
            Some(b"{" | b"}") => Err(self.error(format!("a brace where {what} is expected"))),
            Some(word) => std::str::from_utf8(word).map_err(|_| self.error(format!("{what} is not UTF-8 text"))),
        }
    }

    /// Takes the word `expected` or fails.
    pub fn expect(&mut self, expected: &str) -> Result<(), LoadError> {
        match self.word() {
            Some(word) if word == expected.as_bytes() => Ok(()),
            Some(word) => Err(self.error(format!("`{expected}` expected, found `{}`", show(word)))),
            None => Err(self.error(format!("the file ends where `{expected}` is expected"))),
        }
    }

    /// A finite number.
    pub fn number(&mut self, what: &str) -> Result<f64, LoadError> {
        let word = match self.word() {
            Some(word) => word,
            None => return Err(self.error(format!("the file ends where {what} is expected"))),
        };
        match parse_number(word) {
            Some(value) => Ok(value),
            None => Err(self.error(format!("{what} is expected, found `{}`", show(word)))),
        }
    }

    /// A finite number that also fits single precision.
    pub fn float(&mut self, what: &str) -> Result<f32, LoadError> {
        let value = self.number(what)? as f32;
        if value.is_finite() { Ok(value) } else { Err(self.error(format!("{what} is too large"))) }
    }

    pub fn floats<const N: usize>(&mut self, what: &str) -> Result<[f32; N], LoadError> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = self.float(what)?;
        }
        Ok(values)
    }

    pub fn numbers<const N: usize>(&mut self, what: &str) -> Result<[f64; N], LoadError> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = self.number(what)?;
        }
        Ok(values)
    }

    /// A whole number from 0 to `max`.
    pub fn count(&mut self, what: &str, max: u32) -> Result<u32, LoadError> {
        let value = self.number(what)?;
        if value < 0.0 || value > f64::from(max) || value.fract() != 0.0 {
            return Err(self.error(format!("{what} must be a whole number from 0 to {max}, found {value}")));
        }
        Ok(value as u32)
    }

    /// Whether the next word is a number.
    pub fn number_follows(&self) -> bool {
        self.peek().is_some_and(|word| parse_number(word).is_some())
    }

    /// The next word, when it stands on the line of the one read last.
    pub fn peek_in_line(&self) -> Option<&'a [u8]> {
        let mut next = self.clone();
        let word = next.word();
        word.filter(|_| next.line == self.line)
    }

    /// Upper bound of the words that are left; keeps reservations within what the file can hold.
    pub fn words_left(&self) -> usize {
        (self.bytes.len() - self.position).div_ceil(2)
    }
}

fn parse_number(word: &[u8]) -> Option<f64> {
    // `inf`, `nan` and their kin are words that Rust's parser knows; a scene cannot mean them.
    if !word.iter().any(u8::is_ascii_digit) {
        return None;
    }
    std::str::from_utf8(word).ok()?.parse().ok().filter(|v: &f64| v.is_finite())
}

/// A word as it can be shown in a message.
pub fn show(word: &[u8]) -> String {
    let text: String = String::from_utf8_lossy(word).chars().filter(|c| !c.is_control()).take(40).collect();
    if word.len() > 40 { format!("{text}…") } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lexer(text: &[u8]) -> Lexer<'_> {
        Lexer::new(Path::new("t.aff"), text)
    }

    #[test]
    fn words_comments_and_lines() {
        let mut l = lexer(b"x name{ # c } {\n% f\xf6rslag\n 1.5e-1%c\n\r\n}");
        let words: Vec<_> = std::iter::from_fn(|| l.word().map(|w| (show(w), l.line()))).collect();
        let expected = [("x", 1), ("name", 1), ("{", 1), ("1.5e-1", 3), ("}", 5)];
        assert_eq!(words, expected.map(|(w, n)| (w.to_string(), n)));
    }

    #[test]
    fn carriage_returns_end_lines() {
        let mut l = lexer(b"# a\rb\r\nc\r\rd");
        let words: Vec<_> = std::iter::from_fn(|| l.word().map(|w| (show(w), l.line()))).collect();
        assert_eq!(words, [("b", 2), ("c", 3), ("d", 5)].map(|(w, n)| (w.to_string(), n)));
    }

    #[test]
    fn numbers_are_checked() {
        assert_eq!(lexer(b" -1.5e3").number("x").unwrap(), -1500.0);
        assert_eq!(lexer(b".5").number("x").unwrap(), 0.5);
        for bad in [&b"nan"[..], b"inf", b"1e999", b"1,5", b"", b"}", b"\xff\xfe", b"0x10"] {
            assert!(lexer(bad).number("x").is_err(), "{bad:?}");
        }
        assert!(lexer(b"1e39").float("x").is_err());
        assert!(lexer(b"-1").count("x", 5).is_err() && lexer(b"1.5").count("x", 5).is_err());
        assert!(lexer(b"6").count("x", 5).is_err() && lexer(b"5").count("x", 5).is_ok());
    }

    #[test]
    fn errors_name_the_line_of_the_word() {
        let mut l = lexer(b"\n\n 3\n\n oops");
        l.number("x").unwrap();
        assert_eq!(l.number("a radius").unwrap_err().to_string(), "t.aff:5: a radius is expected, found `oops`");
    }
}
