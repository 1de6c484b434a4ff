//! Pictures to files: numbered PNG, JPEG and EXR, animated GIF and APNG.

use crate::args::Size;
use image::codecs::gif::{GifEncoder, Repeat};
use image::{Delay, DynamicImage, Frame, ImageFormat, RgbaImage};
use std::fs::{self, File};
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// A finished picture, row 0 at the top.
pub enum Picture {
    /// RGBA, 8 bits.
    Bytes(Vec<u8>),
    /// Linear RGBA.
    Floats(Vec<f32>),
}

/// Kind of a picture file, told by its extension.
fn format_of(path: &Path) -> Option<ImageFormat> {
    match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
        "png" => Some(ImageFormat::Png),
        "jpg" | "jpeg" => Some(ImageFormat::Jpeg),
        "exr" => Some(ImageFormat::OpenExr),
        _ => None,
    }
}

/// Where the frames of one run go.
pub enum Output {
    /// One picture.
    Single {
        path: PathBuf,
        format: ImageFormat,
        size: Size,
    },
    /// `before`, the frame number with at least `digits` digits, `after`.
    Numbered {
        before: String,
        digits: usize,
        after: String,
        format: ImageFormat,
        size: Size,
    },
    Gif {
        path: PathBuf,
        encoder: Box<GifEncoder<BufWriter<File>>>,
        delay: Duration,
        size: Size,
    },
    Apng {
        path: PathBuf,
        writer: Box<png::Writer<BufWriter<File>>>,
    },
}

impl Output {
    /// The file of `openrt render`.
    pub fn single(path: PathBuf, size: Size) -> Result<Self, String> {
        let Some(format) = format_of(&path) else {
            return Err(format!("{}: unknown kind of picture; expected .png, .jpg or .exr", path.display()));
        };
        create_folder(&path)?;
        Ok(Output::Single { path, format, size })
    }

    /// The files of `openrt play`; `frames` of them, `delay` apart.
    pub fn animation(path: PathBuf, size: Size, frames: u32, delay: Duration) -> Result<Self, String> {
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
        let fault = |e: &dyn std::fmt::Display| format!("{}: {e}", path.display());
        match extension.as_str() {
            "gif" => {
                create_folder(&path)?;
                let file = BufWriter::new(File::create(&path).map_err(|e| fault(&e))?);
                let mut encoder = GifEncoder::new_with_speed(file, 10);
                encoder.set_repeat(Repeat::Infinite).map_err(|e| fault(&e))?;
                Ok(Output::Gif { path, encoder: Box::new(encoder), delay, size })
            }
            "apng" => {
                create_folder(&path)?;
                let file = BufWriter::new(File::create(&path).map_err(|e| fault(&e))?);
                let mut encoder = png::Encoder::new(file, size.width, size.height);
                encoder.set_color(png::ColorType::Rgba);
                encoder.set_depth(png::BitDepth::Eight);
                encoder.set_animated(frames, 0).map_err(|e| fault(&e))?;
                let milliseconds = delay.as_millis().clamp(1, u128::from(u16::MAX)) as u16;
                encoder.set_frame_delay(milliseconds, 1000).map_err(|e| fault(&e))?;
                let writer = Box::new(encoder.write_header().map_err(|e| fault(&e))?);
                Ok(Output::Apng { path, writer })
            }
            _ => numbered(path, size),
        }
    }

    /// Whether pictures are wanted as floats.
    pub fn wants_floats(&self) -> bool {
        let (Output::Single { format, .. } | Output::Numbered { format, .. }) = self else { return false };
        *format == ImageFormat::OpenExr
    }

    /// Writes the picture of frame number `frame`; the path of its file.
    pub fn write(&mut self, frame: u32, picture: Picture) -> Result<PathBuf, String> {
        match self {
            Output::Single { path, format, size } => save(path.clone(), *format, *size, picture),
            Output::Numbered { before, digits, after, format, size } => {
                let path = PathBuf::from(format!("{before}{frame:0digits$}{after}"));
                save(path, *format, *size, picture)
            }
            Output::Gif { path, encoder, delay, size } => {
                let Picture::Bytes(bytes) = picture else { return Err("a GIF cannot hold floats".into()) };
                let image = rgba(bytes, *size)?;
                let frame = Frame::from_parts(image, 0, 0, Delay::from_saturating_duration(*delay));
                encoder.encode_frame(frame).map_err(|e| format!("{}: {e}", path.display()))?;
                Ok(path.clone())
            }
            Output::Apng { path, writer } => {
                let Picture::Bytes(bytes) = picture else { return Err("an APNG cannot hold floats".into()) };
                writer.write_image_data(&bytes).map_err(|e| format!("{}: {e}", path.display()))?;
                Ok(path.clone())
            }
        }
    }

    /// Completes the file of an animation.
    pub fn finish(self) -> Result<(), String> {
        match self {
            Output::Apng { path, writer } => writer.finish().map_err(|e| format!("{}: {e}", path.display())),
            // The GIF's trailer is written when the encoder is dropped.
            _ => Ok(()),
        }
    }

    /// What the pictures are called, for the summary.
    pub fn describe(&self) -> String {
        match self {
            Output::Single { path, .. } | Output::Gif { path, .. } | Output::Apng { path, .. } => {
                path.display().to_string()
            }
            Output::Numbered { before, digits, after, .. } => format!("{before}{}{after}", "#".repeat(*digits)),
        }
    }
}

fn create_folder(path: &Path) -> Result<(), String> {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => {
            fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))
        }
        _ => Ok(()),
    }
}

/// A pattern (`%d`, `%04d`), a picture name to be numbered, or a folder.
fn numbered(path: PathBuf, size: Size) -> Result<Output, String> {
    let format = format_of(&path);
    let text = path.to_str().ok_or_else(|| format!("{}: not a UTF-8 name", path.display()))?;
    let Some(format) = format else {
        if path.extension().is_some() && !path.is_dir() {
            let text = "unknown kind of picture; expected a folder, or .png, .jpg, .exr, .gif or .apng";
            return Err(format!("{}: {text}", path.display()));
        }
        fs::create_dir_all(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        let before = format!("{}/frame_", text.trim_end_matches('/'));
        return Ok(Output::Numbered { before, digits: 4, after: ".png".into(), format: ImageFormat::Png, size });
    };
    let (before, digits, after) = split_pattern(text)?;
    create_folder(Path::new(&format!("{before}0{after}")))?;
    Ok(Output::Numbered { before, digits, after, format, size })
}

/// `a%04db` → (`a`, 4, `b`); without a `%` the number goes before the extension.
fn split_pattern(text: &str) -> Result<(String, usize, String), String> {
    let Some((before, rest)) = text.split_once('%') else {
        let (stem, extension) = text.rsplit_once('.').unwrap_or((text, ""));
        return Ok((format!("{stem}_"), 4, format!(".{extension}")));
    };
    let (digits, after) = rest.split_once('d').unwrap_or(("?", ""));
    let width = if digits.is_empty() { Some(1) } else { digits.parse().ok().filter(|&n: &usize| n <= 20) };
    match width {
        Some(width) if !after.contains('%') => Ok((before.to_string(), width, after.to_string())),
        _ => Err(format!("{text}: the pattern needs one %d or %04d for the frame number")),
    }
}

fn rgba(bytes: Vec<u8>, size: Size) -> Result<RgbaImage, String> {
    RgbaImage::from_raw(size.width, size.height, bytes).ok_or_else(|| "the picture has another size".to_string())
}

fn save(path: PathBuf, format: ImageFormat, size: Size, picture: Picture) -> Result<PathBuf, String> {
    let image = match picture {
        Picture::Bytes(bytes) => DynamicImage::ImageRgba8(rgba(bytes, size)?),
        Picture::Floats(floats) => {
            let buffer = image::Rgba32FImage::from_raw(size.width, size.height, floats);
            DynamicImage::ImageRgba32F(buffer.ok_or("the picture has another size")?)
        }
    };
    // JPEG has no alpha.
    let image = if format == ImageFormat::Jpeg { DynamicImage::ImageRgb8(image.to_rgb8()) } else { image };
    image.save_with_format(&path, format).map_err(|e| format!("{}: {e}", path.display()))?;
    Ok(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns() {
        let parts = |text: &str| split_pattern(text).map(|(b, n, a)| format!("{b}|{n}|{a}"));
        assert_eq!(parts("out/f%04d.png").unwrap(), "out/f|4|.png");
        assert_eq!(parts("f%d.jpg").unwrap(), "f|1|.jpg");
        assert_eq!(parts("f.png").unwrap(), "f_|4|.png");
        for bad in ["f%.png", "f%x.png", "f%04d%d.png", "f%999d.png"] {
            assert!(parts(bad).is_err(), "{bad}");
        }
    }
}
