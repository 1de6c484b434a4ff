//! First pass: vertices, normals, texture coordinates, and which material libraries there are.

use crate::load::input::lexer::show;
use crate::load::input::lines::{Lines, float, keyword, without_comment, words};
use crate::load::report::Report;
use glam::{Vec2, Vec3};

/// Statements about free-form curves and surfaces.
const FREE_FORM: [&[u8]; 19] = [
    b"vp", b"cstype", b"deg", b"bmat", b"step", b"curv", b"curv2", b"surf", b"parm", b"trim", b"hole", b"scrv", b"sp",
    b"end", b"con", b"bsp", b"bzp", b"cdc", b"cdp",
];

/// Statements that say how other programs show an object.
const DISPLAY: [&[u8]; 15] = [
    b"bevel",
    b"c_interp",
    b"d_interp",
    b"lod",
    b"maplib",
    b"usemap",
    b"shadow_obj",
    b"trace_obj",
    b"ctech",
    b"stech",
    b"mg",
    b"res",
    b"call",
    b"csh",
    b"scmp",
];

/// What the lines of an OBJ file say apart from its faces.
#[derive(Debug, Default)]
pub struct Tables {
    /// NaN where a line was broken, so that the numbers of the others stay right.
    pub positions: Vec<Vec3>,
    /// Empty, or one per position.
    pub colors: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    pub tex_coords: Vec<Vec2>,
    /// Line and words of each `mtllib`.
    pub libraries: Vec<(u32, Vec<u8>)>,
    /// A statement of the format was met.
    pub understood: bool,
}

impl Tables {
    pub fn read(text: &[u8], report: &mut Report) -> Self {
        let mut tables = Self::default();
        for (number, line) in Lines::new(text) {
            let (word, rest) = keyword(&line);
            tables.understood |= tables.statement(word, rest, number, report);
        }
        // Some programs write 0 to 255.
        if tables.colors.iter().any(|c| c.max_element() > 1.0) {
            tables.colors.iter_mut().for_each(|c| *c /= 255.0);
        }
        tables
    }

    /// Reads a statement; false when it is none of the format. Those of faces are left for the second pass.
    fn statement(&mut self, word: &[u8], rest: &[u8], line: u32, report: &mut Report) -> bool {
        match word {
            b"v" => self.vertex(rest, line, report),
            b"vt" => self.tex_coords.push(self::numbers(rest).map_or_else(
                || {
                    report.broken(line, broken("texture coordinate", rest));
                    Vec2::ZERO
                },
                |(n, count)| Vec2::new(n[0], if count > 1 { n[1] } else { 0.0 }),
            )),
            b"vn" => self.normals.push(match self::numbers(rest) {
                Some((n, 3..)) => Vec3::new(n[0], n[1], n[2]),
                // What programs write for triangles without area.
                _ if words(rest).all(|w| w.to_ascii_lowercase().ends_with(b"nan") || w.ends_with(b"#IND")) => {
                    Vec3::ZERO
                }
                _ => {
                    report.broken(line, broken("normal", rest));
                    Vec3::ZERO
                }
            }),
            b"mtllib" if !rest.is_empty() => self.libraries.push((line, rest.to_vec())),
            b"f" | b"fo" | b"usemtl" | b"mtllib" | b"s" | b"o" | b"g" => {}
            b"p" => report.once(Some(line), "points (`p`) are left out"),
            b"l" => report.once(Some(line), "lines (`l`) are left out"),
            _ if FREE_FORM.contains(&word) => {
                let text = format!("free-form curves and surfaces are left out: `{}`", show(word));
                report.once(Some(line), &text);
            }
            _ if DISPLAY.contains(&word) => report.once(Some(line), &format!("`{}` is left out", show(word))),
            _ => {
                report.once(Some(line), &format!("unknown statement `{}` is left out", show(word)));
                return false;
            }
        }
        true
    }

    fn vertex(&mut self, rest: &[u8], line: u32, report: &mut Report) {
        let numbers = numbers(rest);
        let position = match numbers {
            Some((n, 3..)) => Vec3::new(n[0], n[1], n[2]),
            _ => {
                report.broken(line, broken("vertex", rest));
                Vec3::NAN
            }
        };
        // x y z r g b, also with an opacity behind it; with 4 numbers the last one is a weight, which only curves need.
        if let Some((n, 6..)) = numbers {
            self.colors.resize(self.positions.len(), Vec3::ONE);
            self.colors.push(Vec3::new(n[3], n[4], n[5]).max(Vec3::ZERO));
        } else if !self.colors.is_empty() {
            self.colors.push(Vec3::ONE);
        }
        self.positions.push(position);
    }
}

/// Up to 8 numbers and how many there are; `None` when a word is not a number, or there is none.
fn numbers(rest: &[u8]) -> Option<([f32; 8], usize)> {
    let mut numbers = [0.0; 8];
    let mut count = 0;
    for word in words(without_comment(rest)).take(8) {
        numbers[count] = float(word)?;
        count += 1;
    }
    (count > 0).then_some((numbers, count))
}

fn broken(what: &str, rest: &[u8]) -> String {
    format!("this is not a {what}: `{}`", show(rest))
}
