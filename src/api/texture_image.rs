//! From the application's pixels to the texels of one level.

use super::arrays::Component;
use super::error::{Error, Result};
use crate::scene::TextureLevel;

/// Meaning of the channels of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageFormat {
    Rgb,
    Rgba,
    Bgr,
    Bgra,
    Luminance,
    LuminanceAlpha,
    /// White with this opacity.
    Alpha,
    Red,
}

impl ImageFormat {
    pub fn channels(self) -> usize {
        match self {
            ImageFormat::Rgb | ImageFormat::Bgr => 3,
            ImageFormat::Rgba | ImageFormat::Bgra => 4,
            ImageFormat::Luminance | ImageFormat::Alpha | ImageFormat::Red => 1,
            ImageFormat::LuminanceAlpha => 2,
        }
    }
}

/// How an image lies in memory.
#[derive(Clone, Copy, Debug)]
pub struct ImageDesc {
    pub width: u32,
    pub height: u32,
    pub format: ImageFormat,
    /// Of each channel; integers stand for 0…1.
    pub component: Component,
    /// Bytes from one row to the next; 0 when rows follow each other without a gap.
    pub row_stride: usize,
}

impl ImageDesc {
    fn row_bytes(&self) -> Option<usize> {
        (self.width as usize).checked_mul(self.format.channels() * self.component.bytes())
    }

    /// Bytes from the first to the last pixel; None when that is beyond the address space or rows overlap.
    pub fn byte_size(&self) -> Option<usize> {
        let row = self.row_bytes()?;
        if self.height == 0 || row == 0 {
            return Some(0);
        }
        let stride = if self.row_stride == 0 { row } else { self.row_stride };
        if stride < row {
            return None;
        }
        stride.checked_mul(self.height as usize - 1)?.checked_add(row)
    }
}

/// Size of level `level` under `base`; None below the level of one texel.
pub(super) fn level_size(base: &TextureLevel, level: u32) -> Option<(u32, u32)> {
    let side = |n: u32| n.checked_shr(level).unwrap_or(0);
    let (width, height) = (side(base.width), side(base.height));
    (width > 0 || height > 0).then_some((width.max(1), height.max(1)))
}

pub(super) fn decode_level(image: &ImageDesc, data: Option<&[u8]>) -> Result<TextureLevel> {
    let needed = image
        .byte_size()
        .ok_or_else(|| Error::invalid_value("the rows of the image overlap, or are larger than memory"))?;
    if let Some(bytes) = data.map(<[u8]>::len).filter(|&bytes| bytes < needed) {
        return Err(Error::invalid_value(format_args!("the image takes {needed} bytes, and {bytes} were given")));
    }
    let count = image.width as usize * image.height as usize;
    let mut texels = Vec::new();
    texels.try_reserve_exact(count)?;
    let Some(data) = data.filter(|_| count > 0) else {
        texels.resize(count, [0; 4]);
        return Ok(TextureLevel { width: image.width, height: image.height, texels });
    };
    let row_bytes = image.row_bytes().expect("byte_size() has computed it");
    let stride = if image.row_stride == 0 { row_bytes } else { image.row_stride };
    let (channels, size) = (image.format.channels(), image.component.bytes());
    for y in 0..image.height as usize {
        let row = &data[y * stride..][..row_bytes];
        for pixel in row.chunks_exact(channels * size) {
            let channel = |i: usize| image.component.read_unorm8(&pixel[i * size..]);
            texels.push(match image.format {
                ImageFormat::Rgb => [channel(0), channel(1), channel(2), 255],
                ImageFormat::Rgba => [channel(0), channel(1), channel(2), channel(3)],
                ImageFormat::Bgr => [channel(2), channel(1), channel(0), 255],
                ImageFormat::Bgra => [channel(2), channel(1), channel(0), channel(3)],
                ImageFormat::Luminance => [channel(0), channel(0), channel(0), 255],
                ImageFormat::LuminanceAlpha => [channel(0), channel(0), channel(0), channel(1)],
                ImageFormat::Alpha => [255, 255, 255, channel(0)],
                ImageFormat::Red => [channel(0), 0, 0, 255],
            });
        }
    }
    Ok(TextureLevel { width: image.width, height: image.height, texels })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn padded_rows_short_data_and_missing_data() {
        let mut image = ImageDesc {
            width: 1,
            height: 2,
            format: ImageFormat::Rgb,
            component: Component::UnsignedByte,
            row_stride: 4,
        };
        assert_eq!(image.byte_size(), Some(7));
        let level = decode_level(&image, Some(&[1, 2, 3, 99, 4, 5, 6])).unwrap();
        assert_eq!(level.texels, [[1, 2, 3, 255], [4, 5, 6, 255]]);
        assert!(decode_level(&image, Some(&[0; 6])).is_err());
        assert_eq!(decode_level(&image, None).unwrap().texels, [[0; 4]; 2]);
        image.row_stride = 2;
        assert!(decode_level(&image, Some(&[0; 64])).is_err());
        image.row_stride = usize::MAX;
        assert_eq!(image.byte_size(), None);
    }

    #[test]
    fn floats_are_clamped_and_rounded() {
        let image = ImageDesc {
            width: 4,
            height: 1,
            format: ImageFormat::Luminance,
            component: Component::Float,
            row_stride: 0,
        };
        let data: Vec<u8> = [-1.0f32, 0.5, 7.0, f32::NAN].iter().flat_map(|v| v.to_ne_bytes()).collect();
        let level = decode_level(&image, Some(&data)).unwrap();
        assert_eq!(level.texels.iter().map(|t| t[0]).collect::<Vec<_>>(), [0, 128, 255, 0]);
    }
}
