//! The sRGB transfer curve (IEC 61966-2-1), both ways, by table.
//!
//! Both tables are exact. Decoding has only 256 inputs. Encoding rounds to the nearest code: code `k` begins at the
//! linear value of `(k − ½)/255`, the threshold. Thresholds are nowhere closer than 1/(255·12.92), so a bucket of
//! width 1/4096 holds at most one: look up the bucket's first code, then compare with one threshold.

use std::sync::LazyLock;

/// The curve itself: display value in [0, 1] to linear.
pub fn linear_from_display(x: f64) -> f64 {
    if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

static DECODE: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|code| linear_from_display(code as f64 / 255.0) as f32));

const BUCKETS: usize = 4096;

struct Encode {
    /// Smallest linear value of each code; `first[0]` is 0, `first[256]` infinite.
    first: [f32; 257],
    /// Code at the lower end of each bucket.
    code: [u8; BUCKETS + 1],
}

static ENCODE: LazyLock<Encode> = LazyLock::new(|| {
    let first = std::array::from_fn(|k| match k {
        0 => 0.0,
        256 => f32::INFINITY,
        _ => linear_from_display((k as f64 - 0.5) / 255.0) as f32,
    });
    let mut code = [0u8; BUCKETS + 1];
    let mut k = 0;
    for (bucket, slot) in code.iter_mut().enumerate() {
        let low = bucket as f32 / BUCKETS as f32;
        while low >= first[k + 1] {
            k += 1;
        }
        *slot = k as u8;
    }
    Encode { first, code }
});

/// The linear value of every 8-bit sRGB code.
pub fn decode_table() -> &'static [f32; 256] {
    &DECODE
}

/// The 8-bit sRGB code nearest to a linear value; values outside [0, 1] are clamped, NaN is 0.
#[inline]
pub fn encode_srgb8(linear: f32) -> u8 {
    let x = clamp(linear);
    let table = &*ENCODE;
    let code = table.code[(x * BUCKETS as f32) as usize];
    code + u8::from(x >= table.first[usize::from(code) + 1])
}

/// The 8-bit code nearest to a linear value without a curve; values outside [0, 1] are clamped, NaN is 0.
#[inline]
pub fn encode_linear8(linear: f32) -> u8 {
    (clamp(linear) * 255.0 + 0.5) as u8
}

/// Into [0, 1]; `f32::clamp` would keep NaN.
#[inline]
fn clamp(x: f32) -> f32 {
    if x > 0.0 { x.min(1.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_values_of_the_curve() {
        // From the standard's piecewise definition, evaluated by hand.
        for (linear, code) in
            [(0.0, 0), (1.0, 255), (0.5, 188), (0.214_041_14, 128), (0.003_130_8, 10), (0.001, 3), (0.18, 118)]
        {
            assert_eq!(encode_srgb8(linear), code, "linear {linear}");
        }
        assert_eq!(encode_srgb8(f32::NAN), 0);
        assert_eq!(encode_srgb8(f32::INFINITY), 255);
        assert_eq!(encode_srgb8(-1.0), 0);
    }

    #[test]
    fn every_code_survives_a_round_trip() {
        for code in 0..=255u8 {
            assert_eq!(encode_srgb8(decode_table()[usize::from(code)]), code);
        }
    }

    #[test]
    fn encoding_rounds_to_the_nearest_code() {
        for i in 0..=100_000u32 {
            let x = i as f32 / 100_000.0;
            let linear = f64::from(x);
            let display = if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
            let exact = display * 255.0;
            let error = (f64::from(encode_srgb8(x)) - exact).abs();
            assert!(error <= 0.5001, "{x}: {} for {exact}", encode_srgb8(x));
        }
    }

    #[test]
    fn linear_codes_round_and_clamp() {
        assert_eq!(encode_linear8(0.5), 128);
        assert_eq!(encode_linear8(0.4999 / 255.0), 0);
        assert_eq!(encode_linear8(0.5001 / 255.0), 1);
        assert_eq!([f32::NAN, -3.0, 7.0].map(encode_linear8), [0, 0, 255]);
    }
}
