//! Image files, by the `image` crate if the feature `images` is on.

#[cfg(feature = "images")]
mod codec;

use super::Framebuffer;
use std::fmt;
use std::path::{Path, PathBuf};

/// An image file could not be read or written.
#[derive(Debug)]
pub enum ImageFileError {
    /// The extension names no format that we write.
    UnknownFormat { path: PathBuf },
    /// The picture has no pixels.
    Empty { path: PathBuf },
    /// The picture has more pixels on a side than are wanted.
    TooLarge { path: PathBuf, max_side: u32 },
    /// The picture does not fit into memory.
    OutOfMemory { path: PathBuf },
    /// The file system refused.
    Io { path: PathBuf, cause: std::io::Error },
    /// The encoder or decoder refused.
    Codec { path: PathBuf, cause: Box<dyn std::error::Error + Send + Sync> },
    /// The library was built without the feature `images`.
    NotBuilt { path: PathBuf },
}

impl fmt::Display for ImageFileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnknownFormat { path } => {
                write!(f, "{}: unknown image format; use .png, .jpg, .exr, .hdr or .ppm", path.display())
            }
            Self::Empty { path } => write!(f, "{}: the picture has no pixels", path.display()),
            Self::TooLarge { path, max_side } => {
                write!(f, "{}: the picture has more than {max_side} pixels on a side", path.display())
            }
            Self::OutOfMemory { path } => write!(f, "{}: the picture does not fit into memory", path.display()),
            Self::Io { path, cause } => write!(f, "{}: {cause}", path.display()),
            Self::Codec { path, cause } => write!(f, "{}: {cause}", path.display()),
            Self::NotBuilt { path } => write!(
                f,
                "{}: this build of openrt neither reads nor writes image files (cargo feature `images`)",
                path.display()
            ),
        }
    }
}

impl std::error::Error for ImageFileError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Io { cause, .. } => Some(cause),
            Self::Codec { cause, .. } => Some(&**cause),
            _ => None,
        }
    }
}

/// Writes the picture; the extension chooses the format. PNG, JPEG (of `quality` 1 to 100) and PPM get 8-bit RGB, through the
/// sRGB curve when `srgb` is set; EXR gets linear RGBA floats and HDR linear RGB. A file that is there is replaced when the new
/// one is complete, see [`super::NewFile`].
///
/// Takes a few hundred kilobytes of stack.
pub fn write_image(path: &Path, picture: &Framebuffer, srgb: bool, quality: u8) -> Result<(), ImageFileError> {
    #[cfg(feature = "images")]
    return codec::write(path, picture, srgb, quality);
    #[cfg(not(feature = "images"))]
    {
        let _ = (picture, srgb, quality);
        Err(ImageFileError::NotBuilt { path: path.into() })
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
/// and encoded to 8 bits by the sRGB curve. A picture with more than `max_side` pixels on a side is refused.
///
/// Takes a few hundred kilobytes of stack.
pub fn read_image(path: &Path, max_side: u32) -> Result<LoadedImage, ImageFileError> {
    #[cfg(feature = "images")]
    return codec::read(path, max_side);
    #[cfg(not(feature = "images"))]
    {
        let _ = max_side;
        Err(ImageFileError::NotBuilt { path: path.into() })
    }
}

#[cfg(all(test, feature = "images"))]
mod tests {
    use super::*;
    use crate::frame::Pixel;

    const MAX: u32 = 64;

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
            write_image(&path, &picture(), false, 92).unwrap();
            let image = read_image(&path, MAX).unwrap();
            assert_eq!((image.width, image.height), (20, 3));
            for (i, texel) in image.texels.iter().enumerate() {
                assert_eq!(*texel, [(i % 20) as u8, (i / 20 * 60) as u8, 255, 255]);
            }
        }
        for name in ["a.exr", "a.hdr", "a.jpeg"] {
            let path = dir.join(name);
            write_image(&path, &picture(), true, 92).unwrap();
            let image = read_image(&path, MAX).unwrap();
            assert_eq!((image.width, image.height), (20, 3), "{name}");
            // Row 2 from the bottom has green 120/255 linear = 181 in sRGB. JPEG blurs colour, HDR quantises.
            assert!(image.texels[45][1].abs_diff(181) <= 12, "{name}: {:?}", image.texels[45]);
        }
        let length = |quality| {
            let path = dir.join("quality.jpg");
            write_image(&path, &picture(), true, quality).unwrap();
            std::fs::metadata(&path).unwrap().len()
        };
        assert!(length(10) < length(92) && length(92) < length(100));
        std::fs::remove_dir_all(&dir).unwrap();
    }

    #[test]
    fn errors_name_the_file_and_the_cause() {
        let error = |path: &str| write_image(Path::new(path), &picture(), false, 92).unwrap_err().to_string();
        assert!(error("picture.xyz").contains("picture.xyz: unknown image format"));
        assert!(error("/no/such/folder/p.png").starts_with("/no/such/folder/p.png: "));
        let empty = write_image(Path::new("p.png"), &Framebuffer::default(), false, 92).unwrap_err();
        assert!(empty.to_string().contains("no pixels"));
        assert!(read_image(Path::new("/no/such/file.png"), MAX).is_err());
        let path = std::env::temp_dir().join(format!("openrt_image_error_{}.png", std::process::id()));
        write_image(&path, &picture(), false, 92).unwrap();
        assert!(read_image(&path, 19).err().unwrap().to_string().contains("more than 19 pixels on a side"));
        std::fs::remove_file(&path).unwrap();
    }
}
