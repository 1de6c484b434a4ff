//! Kinds of pictures, and one picture as the bytes of a file.

use super::Picture;
use crate::args::Size;
use clap::ValueEnum;
use image::codecs::jpeg::JpegEncoder;
use image::codecs::pnm::{PnmEncoder, PnmSubtype, SampleEncoding};
use image::{DynamicImage, ExtendedColorType, ImageEncoder, ImageFormat, Rgba32FImage, RgbaImage};
use std::io::Cursor;
use std::path::Path;

/// As in files of `rtWriteImage`.
const JPEG_QUALITY: u8 = 92;

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Kind {
    Png,
    Jpg,
    /// Linear floats.
    Exr,
    /// Linear floats.
    Hdr,
    Ppm,
}

impl Kind {
    pub const NAMES: &str = ".png, .jpg, .exr, .hdr or .ppm";

    /// The kind that the extension of `path` names.
    pub fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "png" => Some(Kind::Png),
            "jpg" | "jpeg" => Some(Kind::Jpg),
            "exr" => Some(Kind::Exr),
            "hdr" => Some(Kind::Hdr),
            "ppm" => Some(Kind::Ppm),
            _ => None,
        }
    }

    pub fn extension(self) -> &'static str {
        match self {
            Kind::Png => "png",
            Kind::Jpg => "jpg",
            Kind::Exr => "exr",
            Kind::Hdr => "hdr",
            Kind::Ppm => "ppm",
        }
    }

    pub fn holds_floats(self) -> bool {
        matches!(self, Kind::Exr | Kind::Hdr)
    }

    /// The bytes of a file with this picture.
    pub fn encode(self, picture: Picture, size: Size) -> Result<Vec<u8>, String> {
        let image = match picture {
            Picture::Bytes(bytes) => DynamicImage::ImageRgba8(rgba(bytes, size)?),
            Picture::Floats(floats) => {
                let buffer = Rgba32FImage::from_raw(size.width, size.height, floats);
                DynamicImage::ImageRgba32F(buffer.ok_or(ANOTHER_SIZE)?)
            }
        };
        let mut file = Cursor::new(Vec::new());
        let Size { width, height } = size;
        let rgb = ExtendedColorType::Rgb8;
        let encoded = match self {
            Kind::Png => image.write_to(&mut file, ImageFormat::Png),
            Kind::Exr => image.write_to(&mut file, ImageFormat::OpenExr),
            Kind::Hdr => DynamicImage::ImageRgb32F(image.to_rgb32f()).write_to(&mut file, ImageFormat::Hdr),
            // Neither has alpha.
            Kind::Jpg => {
                JpegEncoder::new_with_quality(&mut file, JPEG_QUALITY).write_image(&image.to_rgb8(), width, height, rgb)
            }
            Kind::Ppm => PnmEncoder::new(&mut file)
                .with_subtype(PnmSubtype::Pixmap(SampleEncoding::Binary))
                .write_image(&image.to_rgb8(), width, height, rgb),
        };
        encoded.map_err(|e| e.to_string())?;
        Ok(file.into_inner())
    }
}

const ANOTHER_SIZE: &str = "the picture has another size";

pub fn rgba(bytes: Vec<u8>, size: Size) -> Result<RgbaImage, String> {
    RgbaImage::from_raw(size.width, size.height, bytes).ok_or_else(|| ANOTHER_SIZE.to_string())
}
