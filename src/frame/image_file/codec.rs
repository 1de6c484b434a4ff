//! Pictures to bytes and back, by the `image` crate.

use super::{ImageFileError, LoadedImage};
use crate::frame::{Framebuffer, NewFile, PixelFormat, encode_pixels};
use crate::memory::{OutOfMemory, behind, repeated, vec_of};
use image::codecs::pnm::{PnmSubtype, SampleEncoding};
use image::codecs::{hdr::HdrEncoder, jpeg::JpegEncoder, openexr::OpenExrEncoder, png::PngEncoder, pnm::PnmEncoder};
use image::error::LimitErrorKind;
use image::{
    ColorType, DynamicImage, ExtendedColorType, ImageDecoder, ImageEncoder, ImageError, ImageReader, Limits, Rgb,
};
use std::io::Write;
use std::path::Path;

/// What codecs take at most whatever the picture.
const CODEC_BYTES: usize = 4 << 20;
/// What an encoder takes, as a multiple of the pixels' bytes: a copy in another order, and the file, which grows by doubling.
const ENCODER_SHARE: usize = 4;
/// What a decoder takes before it knows the picture, as a multiple of the file's bytes: some read all of it, into what grows by doubling.
const FILE_SHARE: u64 = 4;

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
    let mut bytes = repeated(0, row_bytes * height as usize).map_err(out_of_memory)?;
    // Files start with the top row.
    for (row, y) in bytes.chunks_exact_mut(row_bytes).zip((0..height).rev()) {
        encode_pixels(pixels, srgb, picture.row(y).map(|p| p.color), row);
    }
    let io = |cause| ImageFileError::Io { path: path.into(), cause };
    let mut file = NewFile::create(path).map_err(io)?;
    let encoded = behind(reserve_of(ENCODER_SHARE.saturating_mul(bytes.len()) as u64), || {
        encode(format, &mut file, &bytes, width, height)
    });
    encoded.map_err(out_of_memory)?.map_err(|cause| match cause {
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
    let out_of_memory = |_: OutOfMemory| ImageFileError::OutOfMemory { path: path.into() };
    let codec = |cause: ImageError| match cause {
        ImageError::IoError(cause) => io(cause),
        ImageError::Limits(limit) => match limit.kind() {
            LimitErrorKind::DimensionError => ImageFileError::TooLarge { path: path.into(), max_side },
            _ => ImageFileError::OutOfMemory { path: path.into() },
        },
        cause => ImageFileError::Codec { path: path.into(), cause: cause.into() },
    };
    let size = std::fs::metadata(path).map_err(io)?.len();
    let opened = behind(reserve_of(size.saturating_mul(FILE_SHARE)), || {
        let mut reader = ImageReader::open(path).map_err(io)?.with_guessed_format().map_err(io)?;
        let mut limits = Limits::default();
        (limits.max_image_width, limits.max_image_height) = (Some(max_side), Some(max_side));
        limits.max_alloc = Some(MAX_DECODER_BYTES);
        reader.limits(limits.clone());
        let mut decoder = reader.into_decoder().map_err(codec)?;
        let (width, height) = decoder.dimensions();
        // Not every decoder asks the limits.
        if width > max_side || height > max_side {
            return Err(ImageFileError::TooLarge { path: path.into(), max_side });
        }
        // Pixels are converted as a whole, and some decoders have a copy of their own.
        let bytes = decoder.total_bytes();
        let converted = if is_float(decoder.color_type()) { 16 } else { 4 } * u64::from(width) * u64::from(height);
        let needed = bytes.saturating_mul(2).saturating_add(converted);
        limits.reserve(bytes).map_err(codec)?;
        decoder.set_limits(limits).map_err(codec)?;
        let mut texels = vec_of(width as usize * height as usize).map_err(out_of_memory)?;
        let decoded = behind(reserve_of(needed), || {
            texels_of(DynamicImage::from_decoder(decoder)?, &mut texels);
            Ok(())
        });
        decoded.map_err(out_of_memory)?.map_err(codec)?;
        Ok(LoadedImage { width, height, texels })
    });
    opened.map_err(out_of_memory)?
}

/// A reserve for so many bytes that depend on the picture.
fn reserve_of(bytes: u64) -> usize {
    usize::try_from(bytes).map_or(usize::MAX, |bytes| bytes.saturating_add(CODEC_BYTES))
}

fn is_float(color: ColorType) -> bool {
    matches!(color, ColorType::Rgb32F | ColorType::Rgba32F)
}

/// Appends the pixels, bottom row first. There is room for them.
fn texels_of(decoded: DynamicImage, texels: &mut Vec<[u8; 4]>) {
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
}
