//! Pictures to bytes and back, by the `image` crate.

use super::{ImageFileError, LoadedImage};
use crate::frame::{Framebuffer, NewFile, PixelFormat, encode_pixels};
use image::codecs::pnm::{PnmSubtype, SampleEncoding};
use image::codecs::{hdr::HdrEncoder, jpeg::JpegEncoder, openexr::OpenExrEncoder, png::PngEncoder, pnm::PnmEncoder};
use image::{DynamicImage, ExtendedColorType, ImageEncoder, ImageError, ImageReader, Limits, Rgb};
use std::io::Write;
use std::path::Path;

/// What a decoder may take of memory: a picture of the largest size, as floats. Files that claim more are refused before it is taken.
const MAX_DECODER_BYTES: u64 = 1 << 32;

#[derive(Clone, Copy, PartialEq, Eq)]
enum FileFormat {
    Png,
    /// With its quality.
    Jpeg(u8),
    Exr,
    Hdr,
    Ppm,
}

fn format_of(path: &Path, quality: u8) -> Option<FileFormat> {
    let extension = path.extension()?.to_str()?.to_ascii_lowercase();
    Some(match extension.as_str() {
        "png" => FileFormat::Png,
        "jpg" | "jpeg" => FileFormat::Jpeg(quality.clamp(1, 100)),
        "exr" => FileFormat::Exr,
        "hdr" => FileFormat::Hdr,
        "ppm" => FileFormat::Ppm,
        _ => return None,
    })
}

/// See [`super::write_image`].
pub(super) fn write(path: &Path, picture: &Framebuffer, srgb: bool, quality: u8) -> Result<(), ImageFileError> {
    let format = format_of(path, quality).ok_or_else(|| ImageFileError::UnknownFormat { path: path.into() })?;
    let (width, height) = (picture.width(), picture.height());
    if width == 0 || height == 0 {
        return Err(ImageFileError::Empty { path: path.into() });
    }
    let pixels = match format {
        FileFormat::Exr => PixelFormat::Rgba32F,
        FileFormat::Hdr => PixelFormat::Rgb32F,
        _ => PixelFormat::Rgb8,
    };
    let out_of_memory = |_| ImageFileError::OutOfMemory { path: path.into() };
    let row_bytes = width as usize * pixels.bytes_per_pixel();
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(row_bytes * height as usize).map_err(out_of_memory)?;
    bytes.resize(row_bytes * height as usize, 0);
    // Files start with the top row.
    for (row, y) in bytes.chunks_exact_mut(row_bytes).zip((0..height).rev()) {
        encode_pixels(pixels, srgb, picture.row(y).map(|p| p.color), row);
    }
    let io = |cause| ImageFileError::Io { path: path.into(), cause };
    let mut file = NewFile::create(path).map_err(io)?;
    encode(format, &mut file, &bytes, width, height).map_err(|cause| match cause {
        ImageError::IoError(cause) => io(cause),
        cause => ImageFileError::Codec { path: path.into(), cause: cause.into() },
    })?;
    file.complete().map_err(io)
}

fn encode(format: FileFormat, file: &mut NewFile, bytes: &[u8], width: u32, height: u32) -> Result<(), ImageError> {
    let rgb = ExtendedColorType::Rgb8;
    match format {
        FileFormat::Png => PngEncoder::new(file).write_image(bytes, width, height, rgb),
        FileFormat::Jpeg(quality) => {
            JpegEncoder::new_with_quality(file, quality).write_image(bytes, width, height, rgb)
        }
        FileFormat::Ppm => PnmEncoder::new(file)
            .with_subtype(PnmSubtype::Pixmap(SampleEncoding::Binary))
            .write_image(bytes, width, height, rgb),
        FileFormat::Exr => {
            // Its writer goes back and forth in the file.
            let mut whole = std::io::Cursor::new(Vec::new());
            OpenExrEncoder::new(&mut whole).write_image(bytes, width, height, ExtendedColorType::Rgba32F)?;
            file.write_all(whole.get_ref()).map_err(ImageError::IoError)
        }
        FileFormat::Hdr => {
            let float = |b: &[u8]| f32::from_ne_bytes([b[0], b[1], b[2], b[3]]);
            let rgb: Vec<_> = bytes.chunks_exact(12).map(|p| Rgb([float(p), float(&p[4..]), float(&p[8..])])).collect();
            HdrEncoder::new(file).encode(&rgb, width as usize, height as usize)
        }
    }
}

/// See [`super::read_image`].
pub(super) fn read(path: &Path, max_side: u32) -> Result<LoadedImage, ImageFileError> {
    let io = |cause| ImageFileError::Io { path: path.into(), cause };
    let codec = |cause: ImageError| match cause {
        ImageError::IoError(cause) => io(cause),
        ImageError::Limits(limit) if matches!(limit.kind(), image::error::LimitErrorKind::DimensionError) => {
            ImageFileError::TooLarge { path: path.into(), max_side }
        }
        cause => ImageFileError::Codec { path: path.into(), cause: cause.into() },
    };
    let mut reader = ImageReader::open(path).map_err(io)?.with_guessed_format().map_err(io)?;
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(max_side), Some(max_side));
    limits.max_alloc = Some(MAX_DECODER_BYTES);
    reader.limits(limits);
    let decoded = reader.decode().map_err(codec)?;
    let (width, height) = (decoded.width(), decoded.height());
    // Not every decoder asks the limits.
    if width > max_side || height > max_side {
        return Err(ImageFileError::TooLarge { path: path.into(), max_side });
    }
    let mut texels = Vec::new();
    let count = width as usize * height as usize;
    texels.try_reserve_exact(count).map_err(|_| ImageFileError::OutOfMemory { path: path.into() })?;
    match decoded {
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) => {
            for row in decoded.into_rgba32f().rows().rev() {
                for pixel in row {
                    let mut texel = [0; 4];
                    encode_pixels(PixelFormat::Rgba8, true, std::iter::once(pixel.0), &mut texel);
                    texels.push(texel);
                }
            }
        }
        decoded => decoded.into_rgba8().rows().rev().for_each(|row| texels.extend(row.map(|p| p.0))),
    }
    Ok(LoadedImage { width, height, texels })
}
