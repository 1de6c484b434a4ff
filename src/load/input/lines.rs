//! Text files as logical lines of bytes: any line ends, continuation lines, comments after data, byte order marks.
//!
//! Files are bytes, not UTF-8: comments and names of old programs are Latin-1, and what is asked of a word is only whether it is a
//! number or a keyword.

use crate::load::LoadError;
use std::borrow::Cow;
use std::path::Path;

/// The bytes behind a byte order mark, of a file that can be text. UTF-16 and binary files are refused by name.
pub fn text<'a>(path: &Path, bytes: &'a [u8]) -> Result<&'a [u8], LoadError> {
    let refused = |what: &str| Err(LoadError::new(path, None, what));
    match bytes {
        [0xEF, 0xBB, 0xBF, rest @ ..] => text(path, rest),
        [0xFF, 0xFE, 0, 0, ..] | [0, 0, 0xFE, 0xFF, ..] => {
            refused("the file is UTF-32 text; save it as UTF-8 or ASCII")
        }
        [0xFF, 0xFE, ..] | [0xFE, 0xFF, ..] => refused("the file is UTF-16 text; save it as UTF-8 or ASCII"),
        _ => {
            // Zero bytes and Ctrl-Z at the end are padding; others are in no encoding that ASCII words can be found in.
            let padding = |b: &u8| matches!(b, 0 | 0x1a) || b.is_ascii_whitespace();
            let end = bytes.len() - bytes.iter().rev().take_while(|b| padding(b)).count();
            let blanks = bytes[end..].iter().take_while(|b| b.is_ascii_whitespace()).count();
            let text = &bytes[..end + blanks];
            if text.iter().take(1 << 16).any(|&b| b == 0) { refused("the file is binary, not text") } else { Ok(text) }
        }
    }
}

/// Logical lines with the number of the first physical one, without comments and empty lines. A `\` at the end of a line
/// continues it on the next.
pub struct Lines<'a> {
    bytes: &'a [u8],
    position: usize,
    number: u32,
}

impl<'a> Lines<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, position: 0, number: 0 }
    }

    /// The next physical line without its end: LF, CR LF or CR.
    fn physical(&mut self) -> Option<&'a [u8]> {
        let rest = &self.bytes[self.position..];
        if rest.is_empty() {
            return None;
        }
        self.number += 1;
        let length = rest.iter().position(|&b| b == b'\n' || b == b'\r').unwrap_or(rest.len());
        let end = match &rest[length..] {
            [b'\r', b'\n', ..] => 2,
            [] => 0,
            _ => 1,
        };
        self.position += length + end;
        Some(&rest[..length])
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = (u32, Cow<'a, [u8]>);

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let mut line = self.physical()?;
            let number = self.number;
            // What the lines before the last one say; the marks are looked for in single lines, so that a file of nothing but
            // continuations takes linear time.
            let mut before = Vec::new();
            let comment = line.trim_ascii_start().starts_with(b"#");
            while let Some(kept) = continued(line).filter(|_| !comment) {
                before.extend_from_slice(&line[..kept]);
                before.push(b' ');
                line = self.physical().unwrap_or_default();
            }
            let line = if before.is_empty() {
                Cow::Borrowed(line)
            } else {
                before.extend_from_slice(line);
                Cow::Owned(before)
            };
            let rest = line.trim_ascii_start();
            if !rest.is_empty() && rest[0] != b'#' {
                return Some((number, line));
            }
        }
    }
}

/// Length of what comes before the `\` that continues a line.
fn continued(line: &[u8]) -> Option<usize> {
    let line = line.trim_ascii_end();
    line.ends_with(b"\\").then(|| line.len() - 1)
}

/// The line without a comment after data: a `#` at the beginning of a word. (Inside one it is part of a name.)
pub fn without_comment(line: &[u8]) -> &[u8] {
    let comment = |i: usize| line[i] == b'#' && (i == 0 || line[i - 1].is_ascii_whitespace());
    let end = (0..line.len()).find(|&i| comment(i)).unwrap_or(line.len());
    line[..end].trim_ascii()
}

/// Words between blanks.
pub fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> + Clone {
    line.split(|b| b.is_ascii_whitespace() || *b == 0x0b).filter(|w| !w.is_empty())
}

/// The first word and what follows it, both without blanks around them.
pub fn keyword(line: &[u8]) -> (&[u8], &[u8]) {
    let line = line.trim_ascii();
    let end = line.iter().position(|b| b.is_ascii_whitespace()).unwrap_or(line.len());
    (&line[..end], line[end..].trim_ascii())
}

/// A finite number that fits single precision.
pub fn float(word: &[u8]) -> Option<f32> {
    std::str::from_utf8(word).ok()?.parse().ok().filter(|v: &f32| v.is_finite())
}

/// Text as UTF-8, or else as Latin-1, in which every byte is a character.
pub fn decoded(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|&b| char::from(b)).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &[u8]) -> Vec<(u32, String)> {
        Lines::new(text).map(|(n, line)| (n, String::from_utf8_lossy(&line).into_owned())).collect()
    }

    #[test]
    fn every_line_end_and_continuation() {
        let expected = [(1, "a 1"), (2, "b  c"), (5, "d")].map(|(n, t)| (n, t.to_string()));
        assert_eq!(lines(b"a 1\r\nb \\\r\nc\r\n# x \\\r\nd"), expected);
        assert_eq!(lines(b"a 1\rb \\\rc\r#\rd\r"), expected);
        assert_eq!(lines(b"a 1\nb \\\nc\n\t#x\nd\n"), expected);
        assert_eq!(lines(b"a\\"), [(1, "a ".to_string())]);
    }

    #[test]
    fn comments_begin_at_words() {
        assert_eq!(without_comment(b"f 1 2 3 # four"), b"f 1 2 3");
        assert_eq!(without_comment(b"usemtl a#b"), b"usemtl a#b");
        assert_eq!(without_comment(b"#"), b"");
    }

    #[test]
    fn marks_and_binaries_are_named() {
        let path = Path::new("t.obj");
        assert_eq!(text(path, b"\xEF\xBB\xBFv").unwrap(), b"v");
        assert!(text(path, b"\xFF\xFEv\0").unwrap_err().message.contains("UTF-16"));
        assert!(text(path, b"\xFE\xFF\0v").unwrap_err().message.contains("UTF-16"));
        assert!(text(path, b"v 1\0\x7f2").unwrap_err().message.contains("binary"));
        assert_eq!(text(path, b"v 1\n\0\x1a").unwrap(), b"v 1\n");
        assert_eq!(decoded(b"caf\xe9"), "café");
        assert_eq!((float(b"1e39"), float(b"nan"), float(b"-.5")), (None, None, Some(-0.5)));
    }
}
