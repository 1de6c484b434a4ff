//! Pictures to files or to the standard output: one, numbered ones, or frames of an animated GIF or PNG.

mod destination;
mod kind;

pub use destination::STANDARD;
pub use kind::Kind;

use crate::args::Size;
use destination::{Destination, Writer, create_folder};
use image::codecs::gif::{GifEncoder, Repeat};
use image::{Delay, Frame};
use kind::rgba;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// A finished picture, row 0 at the top.
pub enum Picture {
    /// RGBA, 8 bits.
    Bytes(Vec<u8>),
    /// Linear RGBA.
    Floats(Vec<f32>),
}

/// Where the frames of one run go.
pub enum Output {
    /// One picture, or one after the other to the standard output.
    Single {
        path: PathBuf,
        kind: Kind,
        size: Size,
    },
    Numbered {
        pattern: Pattern,
        kind: Kind,
        size: Size,
    },
    Gif {
        path: PathBuf,
        file: Destination,
        encoder: Box<GifEncoder<Writer>>,
        delay: Duration,
        size: Size,
    },
    Apng {
        path: PathBuf,
        file: Destination,
        writer: Box<png::Writer<Writer>>,
    },
}

impl Output {
    /// The file of `openrt render`. `kind` is what the command line says of it.
    pub fn single(path: PathBuf, kind: Option<Kind>, size: Size) -> Result<Self, String> {
        let is_standard = path == Path::new(STANDARD);
        let Some(kind) = kind.or_else(|| Kind::of(&path)).or(is_standard.then_some(Kind::Png)) else {
            return Err(format!("{}: unknown kind of picture; expected {}", path.display(), Kind::NAMES));
        };
        if !is_standard {
            create_folder(&path)?;
        }
        Ok(Output::Single { path, kind, size })
    }

    /// The files of `openrt play`; `frames` of them, `delay` apart.
    pub fn animation(
        path: PathBuf,
        kind: Option<Kind>,
        size: Size,
        frames: u32,
        delay: Duration,
    ) -> Result<Self, String> {
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
        let fault = |e: &dyn std::fmt::Display| format!("{}: {e}", path.display());
        match extension.as_str() {
            "gif" if kind.is_none() => {
                let file = Destination::create(&path)?;
                let mut encoder = GifEncoder::new_with_speed(file.writer(), 10);
                encoder.set_repeat(Repeat::Infinite).map_err(|e| fault(&e))?;
                Ok(Output::Gif { path, file, encoder: Box::new(encoder), delay, size })
            }
            "apng" if kind.is_none() => {
                let file = Destination::create(&path)?;
                let mut encoder = png::Encoder::new(file.writer(), size.width, size.height);
                encoder.set_color(png::ColorType::Rgba);
                encoder.set_depth(png::BitDepth::Eight);
                encoder.set_animated(frames, 0).map_err(|e| fault(&e))?;
                let milliseconds = delay.as_millis().clamp(1, u128::from(u16::MAX)) as u16;
                encoder.set_frame_delay(milliseconds, 1000).map_err(|e| fault(&e))?;
                let writer = Box::new(encoder.write_header().map_err(|e| fault(&e))?);
                Ok(Output::Apng { path, file, writer })
            }
            _ if path == Path::new(STANDARD) => Self::single(path, kind, size),
            _ => numbered(path, kind, size),
        }
    }

    /// Whether pictures are wanted as floats.
    pub fn wants_floats(&self) -> bool {
        match self {
            Output::Single { kind, .. } | Output::Numbered { kind, .. } => kind.holds_floats(),
            _ => false,
        }
    }

    /// Writes the picture of frame number `frame`.
    pub fn write(&mut self, frame: u32, picture: Picture) -> Result<(), String> {
        match self {
            Output::Single { path, kind, size } => save(path, *kind, *size, picture),
            Output::Numbered { pattern, kind, size } => save(&pattern.path(frame), *kind, *size, picture),
            Output::Gif { path, encoder, delay, size, .. } => {
                let Picture::Bytes(bytes) = picture else { return Err("a GIF cannot hold floats".into()) };
                let image = rgba(bytes, *size)?;
                let frame = Frame::from_parts(image, 0, 0, Delay::from_saturating_duration(*delay));
                encoder.encode_frame(frame).map_err(|e| format!("{}: {e}", path.display()))
            }
            Output::Apng { path, writer, .. } => {
                let Picture::Bytes(bytes) = picture else { return Err("an APNG cannot hold floats".into()) };
                writer.write_image_data(&bytes).map_err(|e| format!("{}: {e}", path.display()))
            }
        }
    }

    /// Completes the file of an animation.
    pub fn finish(self) -> Result<(), String> {
        match self {
            Output::Apng { path, file, writer } => {
                writer.finish().map_err(|e| format!("{}: {e}", path.display()))?;
                file.complete(&path)
            }
            Output::Gif { path, file, encoder, .. } => {
                // Writes the trailer.
                drop(encoder);
                file.complete(&path)
            }
            _ => Ok(()),
        }
    }

    /// What the pictures are called, as it can be typed.
    pub fn describe(&self) -> String {
        match self {
            Output::Single { path, .. } | Output::Gif { path, .. } | Output::Apng { path, .. } => {
                path.display().to_string()
            }
            Output::Numbered { pattern, .. } => pattern.to_string(),
        }
    }
}

fn save(path: &Path, kind: Kind, size: Size, picture: Picture) -> Result<(), String> {
    let fault = |e: &dyn std::fmt::Display| format!("{}: {e}", path.display());
    let bytes = kind.encode(picture, size).map_err(|e| fault(&e))?;
    let file = Destination::create(path)?;
    file.writer().write_all(&bytes).map_err(|e| fault(&e))?;
    file.complete(path)
}

/// A pattern (`%d`, `%04d`), a picture name to be numbered, or a folder.
fn numbered(path: PathBuf, kind: Option<Kind>, size: Size) -> Result<Output, String> {
    let text = path.to_str().ok_or_else(|| format!("{}: not a UTF-8 name", path.display()))?;
    let Some(named) = Kind::of(&path) else {
        if path.extension().is_some() && !path.is_dir() {
            let text = format!("unknown kind of picture; expected a folder, or {}, .gif or .apng", Kind::NAMES);
            return Err(format!("{}: {text}", path.display()));
        }
        fs::create_dir_all(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        let kind = kind.unwrap_or(Kind::Png);
        let before = format!("{}/frame_", text.trim_end_matches('/'));
        let pattern = Pattern { before, digits: 4, after: format!(".{}", kind.extension()) };
        return Ok(Output::Numbered { pattern, kind, size });
    };
    let pattern: Pattern = text.parse()?;
    create_folder(&pattern.path(0))?;
    Ok(Output::Numbered { pattern, kind: kind.unwrap_or(named), size })
}

/// `before`, the frame number with at least `digits` digits, `after`.
pub struct Pattern {
    before: String,
    digits: usize,
    after: String,
}

impl Pattern {
    fn path(&self, frame: u32) -> PathBuf {
        let Self { before, digits, after } = self;
        PathBuf::from(format!("{before}{frame:0digits$}{after}"))
    }
}

impl std::str::FromStr for Pattern {
    type Err = String;

    /// `a%04db`; without a `%` the number goes before the extension.
    fn from_str(text: &str) -> Result<Self, String> {
        let Some((before, rest)) = text.split_once('%') else {
            let (stem, extension) = text.rsplit_once('.').unwrap_or((text, ""));
            return Ok(Self { before: format!("{stem}_"), digits: 4, after: format!(".{extension}") });
        };
        let (digits, after) = rest.split_once('d').unwrap_or(("?", ""));
        let width = if digits.is_empty() { Some(1) } else { digits.parse().ok().filter(|&n: &usize| n <= 20) };
        match width {
            Some(digits) if !after.contains('%') => {
                Ok(Self { before: before.to_string(), digits, after: after.to_string() })
            }
            _ => Err(format!("{text}: the pattern needs one %d or %04d for the frame number")),
        }
    }
}

impl std::fmt::Display for Pattern {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { before, digits, after } = self;
        match digits {
            0 | 1 => write!(f, "{before}%d{after}"),
            _ => write!(f, "{before}%0{digits}d{after}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns() {
        let shown = |text: &str| text.parse().map(|p: Pattern| (p.to_string(), p.path(7).display().to_string()));
        let both = |a: &str, b: &str| (a.to_string(), b.to_string());
        assert_eq!(shown("out/f%04d.png").unwrap(), both("out/f%04d.png", "out/f0007.png"));
        assert_eq!(shown("f%d.jpg").unwrap(), both("f%d.jpg", "f7.jpg"));
        assert_eq!(shown("f.png").unwrap(), both("f_%04d.png", "f_0007.png"));
        for bad in ["f%.png", "f%x.png", "f%04d%d.png", "f%999d.png"] {
            assert!(bad.parse::<Pattern>().is_err(), "{bad}");
        }
    }
}
