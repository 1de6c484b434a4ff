//! Image files, through the `image` crate.

use super::{Framebuffer, PixelFormat, encode_pixels};
use image::codecs::pnm::{PnmSubtype, SampleEncoding};
use image::codecs::{hdr::HdrEncoder, jpeg::JpegEncoder, openexr::OpenExrEncoder, png::PngEncoder, pnm::PnmEncoder};
use image::{ExtendedColorType, ImageEncoder, ImageReader, Rgb};
use std::fmt;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// An image file could not be read or written.
#[derive(Debug)]
pub enum ImageFileError {
    /// The extension names no format that we write.
    UnknownFormat { path: PathBuf },
    /// The picture has no pixels.
    Empty { path: PathBuf },
    /// The picture does not fit into memory.
    OutOfMemory { path: PathBuf },
    /// The file system refused.
    Io { path: PathBuf, cause: std::io::Error },
    /// The encoder or decoder refused.
    Codec { path: PathBuf, cause: image::ImageError },
}

impl fmt::Display for ImageFileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnknownFormat { path } => {
                write!(f, "{}: unknown image format; use .png, .jpg, .exr, .hdr or .ppm", path.display())
            }
            Self::Empty { path } => write!(f, "{}: the picture has no pixels", path.display()),
            Self::OutOfMemory { path } => write!(f, "{}: the picture does not fit into memory", path.display()),
            Self::Io { path, cause } => write!(f, "{}: {cause}", path.display()),
            Self::Codec { path, cause } => write!(f, "{}: {cause}", path.display()),
        }
    }
}

impl std::error::Error for ImageFileError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Io { cause, .. } => Some(cause),
            Self::Codec { cause, .. } => Some(cause),
            _ => None,
        }
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum FileFormat {
    Png,
    Jpeg,
    Exr,
    Hdr,
    Ppm,
}

fn format_of(path: &Path) -> Option<FileFormat> {
    let extension = path.extension()?.to_str()?.to_ascii_lowercase();
    Some(match extension.as_str() {
        "png" => FileFormat::Png,
        "jpg" | "jpeg" => FileFormat::Jpeg,
        "exr" => FileFormat::Exr,
        "hdr" => FileFormat::Hdr,
        "ppm" => FileFormat::Ppm,
        _ => return None,
    })
}

/// Writes the picture; the extension chooses the format. PNG, JPEG (quality 92) and PPM get 8-bit RGB, through the
/// sRGB curve when `srgb` is set; EXR gets linear RGBA floats and HDR linear RGB.
pub fn write_image(path: &Path, picture: &Framebuffer, srgb: bool) -> Result<(), ImageFileError> {
    let format = format_of(path).ok_or_else(|| ImageFileError::UnknownFormat { path: path.into() })?;
    let (width, height) = (picture.width(), picture.height());
    if width == 0 || height == 0 {
        return Err(ImageFileError::Empty { path: path.into() });
    }
    let pixels = match format {
        FileFormat::Exr => PixelFormat::Rgba32F,
        FileFormat::Hdr => PixelFormat::Rgb32F,
        _ => PixelFormat::Rgb8,
    };
    let row_bytes = width as usize * pixels.bytes_per_pixel();
    let mut bytes = Vec::new();
    if bytes.try_reserve_exact(row_bytes * height as usize).is_err() {
        return Err(ImageFileError::OutOfMemory { path: path.into() });
    }
    bytes.resize(row_bytes * height as usize, 0);
    // Files start with the top row.
    for (row, y) in bytes.chunks_exact_mut(row_bytes).zip((0..height).rev()) {
        encode_pixels(pixels, srgb, picture.row(y).map(|p| p.color), row);
    }
    let io = |cause| ImageFileError::Io { path: path.into(), cause };
    let mut file = BufWriter::new(File::create(path).map_err(io)?);
    encode_file(format, &mut file, &bytes, width, height)
        .map_err(|cause| ImageFileError::Codec { path: path.into(), cause })?;
    file.flush().map_err(io)
}

fn encode_file(
    format: FileFormat,
    file: &mut BufWriter<File>,
    bytes: &[u8],
    width: u32,
    height: u32,
) -> Result<(), image::ImageError> {
    match format {
        FileFormat::Png => PngEncoder::new(file).write_image(bytes, width, height, ExtendedColorType::Rgb8),
        FileFormat::Jpeg => {
            JpegEncoder::new_with_quality(file, 92).write_image(bytes, width, height, ExtendedColorType::Rgb8)
        }
        FileFormat::Ppm => PnmEncoder::new(file).with_subtype(PnmSubtype::Pixmap(SampleEncoding::Binary)).write_image(
            bytes,
            width,
            height,
            ExtendedColorType::Rgb8,
        ),
        FileFormat::Exr => OpenExrEncoder::new(file).write_image(bytes, width, height, ExtendedColorType::Rgba32F),
        FileFormat::Hdr => {
            let float = |b: &[u8]| f32::from_ne_bytes([b[0], b[1], b[2], b[3]]);
            let rgb: Vec<_> = bytes.chunks_exact(12).map(|p| Rgb([float(p), float(&p[4..]), float(&p[8..])])).collect();
            HdrEncoder::new(file).encode(&rgb, width as usize, height as usize)
        }
    }
}

/// An image as textures want it: bottom row first.
pub struct LoadedImage {
    pub width: u32,
    pub height: u32,
    /// RGBA as stored in the file; alpha is 255 where the file has none.
    pub texels: Vec<[u8; 4]>,
}

/// Reads a PNG, JPEG, PPM/PGM, HDR or EXR file; the contents choose the format. Files of floats are clamped to [0, 1]
/// and encoded to 8 bits by the sRGB curve.
pub fn read_image(path: &Path) -> Result<LoadedImage, ImageFileError> {
    let io = |cause| ImageFileError::Io { path: path.into(), cause };
    let decoded = ImageReader::open(path)
        .map_err(io)?
        .with_guessed_format()
        .map_err(io)?
        .decode()
        .map_err(|cause| ImageFileError::Codec { path: path.into(), cause })?;
    let (width, height) = (decoded.width(), decoded.height());
    let floats = matches!(decoded.color(), image::ColorType::Rgb32F | image::ColorType::Rgba32F);
    let mut texels = Vec::with_capacity(width as usize * height as usize);
    if floats {
        for pixel in decoded.flipv().into_rgba32f().pixels() {
            let mut texel = [0; 4];
            encode_pixels(PixelFormat::Rgba8, true, std::iter::once(pixel.0), &mut texel);
            texels.push(texel);
        }
    } else {
        texels.extend(decoded.flipv().into_rgba8().pixels().map(|p| p.0));
    }
    Ok(LoadedImage { width, height, texels })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Pixel;

    fn picture() -> Framebuffer {
        let mut fb = Framebuffer::default();
        fb.resize(20, 3).unwrap();
        let grid = fb.grid();
        for (i, tile) in fb.tiles_mut().0.iter_mut().enumerate() {
            let r = grid.rect(i);
            for y in r.y0..r.y1 {
                for x in r.x0..r.x1 {
                    let color = [x as f32 / 255.0, y as f32 * 60.0 / 255.0, 1.0, 1.0];
                    tile.set(x - r.x0, y - r.y0, Pixel { color, ..Pixel::EMPTY });
                }
            }
        }
        fb
    }

    #[test]
    fn lossless_formats_come_back_unchanged() {
        let dir = std::env::temp_dir().join(format!("openrt_image_{}", std::process::id()));
        std::fs::create_dir_all(&dir).unwrap();
        for name in ["a.png", "a.PPM"] {
            let path = dir.join(name);
            write_image(&path, &picture(), false).unwrap();
            let image = read_image(&path).unwrap();
            assert_eq!((image.width, image.height), (20, 3));
            for (i, texel) in image.texels.iter().enumerate() {
                assert_eq!(*texel, [(i % 20) as u8, (i / 20 * 60) as u8, 255, 255]);
            }
        }
        for name in ["a.exr", "a.hdr", "a.jpeg"] {
            let path = dir.join(name);
            write_image(&path, &picture(), true).unwrap();
            let image = read_image(&path).unwrap();
            assert_eq!((image.width, image.height), (20, 3), "{name}");
            // Row 2 from the bottom has green 120/255 linear = 181 in sRGB. JPEG blurs colour, HDR quantises.
            assert!(image.texels[45][1].abs_diff(181) <= 12, "{name}: {:?}", image.texels[45]);
        }
        std::fs::remove_dir_all(&dir).unwrap();
    }

    #[test]
    fn errors_name_the_file_and_the_cause() {
        let error = |path: &str| write_image(Path::new(path), &picture(), false).unwrap_err().to_string();
        assert!(error("picture.xyz").contains("picture.xyz: unknown image format"));
        assert!(error("/no/such/folder/p.png").starts_with("/no/such/folder/p.png: "));
        let empty = write_image(Path::new("p.png"), &Framebuffer::default(), false).unwrap_err();
        assert!(empty.to_string().contains("no pixels"));
        assert!(read_image(Path::new("/no/such/file.png")).is_err());
    }
}
