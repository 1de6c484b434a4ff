//! Linear colours to the bytes of the application's image.

use super::{PixelFormat, Target, TileRect, srgb};

/// Widest run of pixels that [`Target::write_rect`] encodes at once.
const RUN: usize = 64;

impl Target {
    /// Encodes the pixels of `rect` (rows from the bottom) and hands them to the sink, one row segment at a time.
    /// Parts of `rect` outside the layout are left out. `color` is asked for every pixel by its column and row.
    pub fn write_rect(&self, rect: TileRect, srgb: bool, color: impl Fn(u32, u32) -> [f32; 4]) {
        let layout = &self.layout;
        let rect = rect.intersection(TileRect { x0: 0, y0: 0, x1: layout.width, y1: layout.height });
        let size = layout.format.bytes_per_pixel();
        let mut bytes = [0u8; RUN * 16];
        for y in rect.y0..rect.y1 {
            let row = if layout.origin_top_left { layout.height - 1 - y } else { y };
            for x0 in (rect.x0..rect.x1).step_by(RUN) {
                let x1 = rect.x1.min(x0 + RUN as u32);
                let run = &mut bytes[..(x1 - x0) as usize * size];
                encode_pixels(layout.format, srgb, (x0..x1).map(|x| color(x, y)), run);
                self.sink.write(row as usize * layout.stride + x0 as usize * size, run);
            }
        }
    }
}

/// Encodes `colors` (linear RGBA) one after the other into `out`, as many as fit.
///
/// 8-bit channels are clamped to [0, 1] and rounded; colour goes through the sRGB curve when `srgb` is set, alpha
/// never does. Float channels are stored as they are, linear.
pub fn encode_pixels(format: PixelFormat, srgb: bool, colors: impl Iterator<Item = [f32; 4]>, out: &mut [u8]) {
    let curve = if srgb { srgb::encode_srgb8 } else { srgb::encode_linear8 };
    for (color, pixel) in colors.zip(out.chunks_exact_mut(format.bytes_per_pixel())) {
        let [r, g, b, a] = color;
        match format {
            PixelFormat::Rgba8 => pixel.copy_from_slice(&[curve(r), curve(g), curve(b), srgb::encode_linear8(a)]),
            PixelFormat::Bgra8 => pixel.copy_from_slice(&[curve(b), curve(g), curve(r), srgb::encode_linear8(a)]),
            PixelFormat::Rgb8 => pixel.copy_from_slice(&[curve(r), curve(g), curve(b)]),
            PixelFormat::Bgr8 => pixel.copy_from_slice(&[curve(b), curve(g), curve(r)]),
            PixelFormat::Rgb32F | PixelFormat::Rgba32F => store_floats(pixel, color),
            PixelFormat::Bgr32F | PixelFormat::Bgra32F => store_floats(pixel, [b, g, r, a]),
        }
    }
}

/// Stores as many of the channels as the pixel has.
#[inline]
fn store_floats(pixel: &mut [u8], channels: [f32; 4]) {
    for (bytes, channel) in pixel.chunks_exact_mut(4).zip(channels) {
        bytes.copy_from_slice(&channel.to_ne_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{PixelSink, TargetLayout};
    use std::sync::{Arc, Mutex};

    struct Image(Mutex<Vec<u8>>);

    impl PixelSink for Image {
        fn write(&self, offset: usize, bytes: &[u8]) {
            self.0.lock().unwrap()[offset..offset + bytes.len()].copy_from_slice(bytes);
        }
    }

    fn encode(format: PixelFormat, srgb: bool, color: [f32; 4]) -> Vec<u8> {
        let mut out = vec![0; format.bytes_per_pixel()];
        encode_pixels(format, srgb, std::iter::once(color), &mut out);
        out
    }

    #[test]
    fn channels_land_in_their_places() {
        let color = [1.0, 0.5, 0.0, 0.5];
        assert_eq!(encode(PixelFormat::Rgba8, false, color), [255, 128, 0, 128]);
        assert_eq!(encode(PixelFormat::Bgra8, false, color), [0, 128, 255, 128]);
        assert_eq!(encode(PixelFormat::Rgb8, false, color), [255, 128, 0]);
        assert_eq!(encode(PixelFormat::Bgr8, false, color), [0, 128, 255]);
        assert_eq!(encode(PixelFormat::Rgba8, true, color), [255, 188, 0, 128]);
        let floats = |bytes: Vec<u8>| -> Vec<f32> {
            bytes.chunks(4).map(|b| f32::from_ne_bytes(b.try_into().unwrap())).collect()
        };
        assert_eq!(floats(encode(PixelFormat::Rgb32F, true, [2.0, -1.0, 0.25, 0.5])), [2.0, -1.0, 0.25]);
        assert_eq!(floats(encode(PixelFormat::Rgba32F, true, [2.0, -1.0, 0.25, 0.5])), [2.0, -1.0, 0.25, 0.5]);
        assert_eq!(floats(encode(PixelFormat::Bgr32F, true, [2.0, -1.0, 0.25, 0.5])), [0.25, -1.0, 2.0]);
        assert_eq!(floats(encode(PixelFormat::Bgra32F, true, [2.0, -1.0, 0.25, 0.5])), [0.25, -1.0, 2.0, 0.5]);
    }

    #[test]
    fn stride_and_origin_are_respected() {
        for origin_top_left in [false, true] {
            let (width, height, stride) = (150u32, 5u32, 150 * 3 + 7);
            let image = Arc::new(Image(Mutex::new(vec![9; stride * height as usize])));
            let layout = TargetLayout { width, height, format: PixelFormat::Rgb8, stride, origin_top_left };
            let target = Target { layout, sink: image.clone() };
            let rect = TileRect { x0: 1, y0: 1, x1: 400, y1: 4 };
            target.write_rect(rect, false, |x, y| [x as f32 / 255.0, y as f32 / 255.0, 1.0, 1.0]);
            let bytes = image.0.lock().unwrap();
            for row in 0..height {
                let y = if origin_top_left { height - 1 - row } else { row };
                let line = &bytes[row as usize * stride..][..stride];
                for x in 0..width {
                    let pixel = &line[x as usize * 3..][..3];
                    if x >= 1 && (1..4).contains(&y) {
                        assert_eq!(pixel, [x as u8, y as u8, 255]);
                    } else {
                        assert_eq!(pixel, [9; 3]);
                    }
                }
                assert!(line[450..].iter().all(|&b| b == 9), "the gap between rows belongs to the application");
            }
        }
    }
}
