//! Texture statements of MTL: options before a file name.

use crate::load::input::lines::{decoded, float, without_comment};
use crate::load::report::Report;
use glam::Vec2;

/// Texture coordinates as the options `-s` and `-o` place the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    pub scale: Vec2,
    pub offset: Vec2,
}

impl Default for Transform {
    fn default() -> Self {
        Self { scale: Vec2::ONE, offset: Vec2::ZERO }
    }
}

impl Transform {
    pub fn apply(&self, t: Vec2) -> Vec2 {
        t * self.scale + self.offset
    }
}

/// An image file and how it lies on a surface.
#[derive(Clone, Debug)]
pub struct Map {
    pub file: String,
    pub transform: Transform,
    pub clamp: bool,
    pub line: u32,
}

/// Options with the number of words that may follow them, at least and at most.
const OPTIONS: [(&[u8], usize, usize); 12] = [
    (b"-blendu", 1, 1),
    (b"-blendv", 1, 1),
    (b"-cc", 1, 1),
    (b"-clamp", 1, 1),
    (b"-imfchan", 1, 1),
    (b"-texres", 1, 1),
    (b"-type", 1, 1),
    (b"-bm", 1, 1),
    (b"-boost", 1, 1),
    (b"-mm", 2, 2),
    (b"-o", 1, 3),
    (b"-s", 1, 3),
];

/// The words behind `map_Kd` or another statement of its kind. `None`, with a warning, when there is no file name.
/// With `silent`, options that change nothing here are not told: the whole map is left out anyway.
pub fn read(statement: &str, rest: &[u8], line: u32, report: &mut Report, silent: bool) -> Option<Map> {
    let mut map = Map { file: String::new(), transform: Transform::default(), clamp: false, line };
    let mut rest = rest.trim_ascii();
    while rest.first() == Some(&b'-') {
        let (option, after) = split_word(rest);
        let option = option.to_ascii_lowercase();
        // -t moves the texture by turbulence; it has as many numbers as -o.
        let known = OPTIONS.iter().find(|o| o.0 == option).copied();
        let Some((_, least, most)) = known.or((option == b"-t").then_some((b"-t", 1, 3))) else {
            // A file name may begin with a dash.
            break;
        };
        let mut values = Vec::new();
        let mut behind = after;
        while values.len() < most {
            let (word, next) = split_word(behind);
            let fits = values.len() < least || (float(word).is_some() && !next.is_empty());
            if word.is_empty() || !fits {
                break;
            }
            values.push(word);
            behind = next;
        }
        rest = behind;
        let number = |i: usize, otherwise: f32| values.get(i).and_then(|w| float(w)).unwrap_or(otherwise);
        match &option[..] {
            b"-s" => map.transform.scale = Vec2::new(number(0, 1.0), number(1, 1.0)),
            b"-o" => map.transform.offset = Vec2::new(number(0, 0.0), number(1, 0.0)),
            b"-clamp" => map.clamp = values.first().is_some_and(|w| w.eq_ignore_ascii_case(b"on")),
            // How an image is filtered is not the file's business, and what follows is the default.
            b"-blendu" | b"-blendv" | b"-texres" | b"-boost" => {}
            b"-mm" if number(0, 0.0) == 0.0 && number(1, 1.0) == 1.0 => {}
            b"-cc" if values.first().is_some_and(|w| w.eq_ignore_ascii_case(b"off")) => {}
            b"-t" if (0..3).all(|i| number(i, 0.0) == 0.0) => {}
            _ if silent => {}
            _ => report.once(Some(line), &format!("option `{}` of `{statement}` is left out", decoded(&option))),
        }
    }
    let name = without_comment(rest);
    let name = name.strip_prefix(b"\"").and_then(|n| n.strip_suffix(b"\"")).unwrap_or(name);
    map.file = decoded(name).replace("\\ ", " ");
    if map.file.is_empty() {
        report.broken(line, format!("`{statement}` names no file"));
        return None;
    }
    Some(map)
}

/// The first word, and what follows it.
fn split_word(text: &[u8]) -> (&[u8], &[u8]) {
    let text = text.trim_ascii_start();
    let end = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
    (&text[..end], text[end..].trim_ascii_start())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn map(text: &str) -> (Map, Vec<String>) {
        let mut report = Report::new(Path::new("t.mtl"));
        let map = read("map_Kd", text.as_bytes(), 7, &mut report, false).expect(text);
        (map, report.into_warnings())
    }

    #[test]
    fn options_end_where_the_name_begins() {
        for (text, scale, offset, file) in [
            ("tex.png", (1.0, 1.0), (0.0, 0.0), "tex.png"),
            ("-s 2 2 1 tex.png", (2.0, 2.0), (0.0, 0.0), "tex.png"),
            ("-s 2 tex.png", (2.0, 1.0), (0.0, 0.0), "tex.png"),
            ("-o .5 -.25 -s 3 4 my tex.png # it", (3.0, 4.0), (0.5, -0.25), "my tex.png"),
            ("-s 1 1 1 42", (1.0, 1.0), (0.0, 0.0), "42"),
            ("-blendu off -cc off -mm 0 1 -clamp on \"a b.png\"", (1.0, 1.0), (0.0, 0.0), "a b.png"),
            ("..\\maps\\a.png", (1.0, 1.0), (0.0, 0.0), "..\\maps\\a.png"),
            ("-odd.png", (1.0, 1.0), (0.0, 0.0), "-odd.png"),
        ] {
            let (map, warnings) = map(text);
            assert_eq!(map.transform, Transform { scale: scale.into(), offset: offset.into() }, "{text}");
            assert_eq!((map.file.as_str(), map.clamp), (file, text.contains("clamp")), "{text}");
            assert!(warnings.is_empty(), "{text}: {warnings:?}");
        }
    }

    #[test]
    fn what_is_left_out_is_told() {
        let (found, warnings) = map("-bm 0.5 -imfchan l -type cube_top a.png");
        assert_eq!(found.file, "a.png");
        assert_eq!(warnings.len(), 3, "{warnings:?}");
        assert!(warnings[0].contains("t.mtl:7: option `-bm` of `map_Kd`"), "{warnings:?}");
    }
}
