//! Texture look-up: wrap modes, nearest, bilinear and mip-mapped filtering, decoding of sRGB.
//!
//! Filtering works on decoded, linear values. The mip level follows from the *area* that a ray's footprint covers in
//! texture space ([`crate::shade::footprint`]): level = ½ log₂(area in texels of the base level), so a footprint of
//! one texel asks for level 0.

use crate::memory::{OutOfMemory, collected, push, vec_of};
use crate::scene::{Filter, Texture, TextureFormat, TextureLevel, Wrap};
use glam::{Affine2, Vec2, Vec4};
use std::sync::{Arc, LazyLock};

/// A texture ready for look-up: with a whole mip-map chain if its filter wants one.
#[derive(Clone)]
pub struct CompiledTexture {
    source: Arc<Texture>,
    /// The levels that the source does not have.
    rest: Arc<Vec<TextureLevel>>,
}

impl CompiledTexture {
    /// None for a texture without an image (or with a broken one): such look-ups are white.
    ///
    /// # Errors
    /// No memory for the levels.
    pub fn new(source: &Arc<Texture>) -> Result<Option<Self>, OutOfMemory> {
        let whole = |l: &TextureLevel| {
            l.width > 0 && l.height > 0 && l.texels.len() as u64 == u64::from(l.width) * u64::from(l.height)
        };
        if source.levels.is_empty() || !source.levels.iter().all(whole) {
            return Ok(None);
        }
        let mut rest: Vec<TextureLevel> = Vec::new();
        if source.filter == Filter::LinearMipmapLinear {
            loop {
                let last = rest.last().or(source.levels.last()).expect("the source has a level");
                if last.width == 1 && last.height == 1 {
                    break;
                }
                let next = half(last, source.format)?;
                push(&mut rest, next)?;
            }
        }
        Ok(Some(Self { source: source.clone(), rest: Arc::new(rest) }))
    }

    /// Whether this was compiled from that very image.
    pub fn is_from(&self, source: &Arc<Texture>) -> bool {
        Arc::ptr_eq(&self.source, source)
    }

    /// Rows of the base level, at least 1.
    pub fn height(&self) -> u32 {
        self.source.levels[0].height
    }

    fn level_count(&self) -> usize {
        self.source.levels.len() + self.rest.len()
    }

    fn level(&self, i: usize) -> &TextureLevel {
        self.source.levels.get(i).unwrap_or_else(|| &self.rest[i - self.source.levels.len()])
    }

    /// The filtered linear RGBA at `uv`; `footprint` is the area of texture space (1 = the whole image) to filter over.
    pub fn lookup(&self, uv: Vec2, footprint: f32) -> Vec4 {
        let transform = &self.source.transform;
        if *transform == Affine2::IDENTITY {
            return self.filtered(uv, footprint);
        }
        self.filtered(transform.transform_point2(uv), footprint * transform.matrix2.determinant().abs())
    }

    fn filtered(&self, uv: Vec2, footprint: f32) -> Vec4 {
        match self.source.filter {
            Filter::Nearest => self.nearest(uv),
            Filter::Linear => self.bilinear(0, uv),
            Filter::LinearMipmapLinear => {
                let level = self.level_of(footprint);
                let below = level as usize;
                let color = self.bilinear(below, uv);
                let blend = level - below as f32;
                if blend > 0.0 { color.lerp(self.bilinear(below + 1, uv), blend) } else { color }
            }
        }
    }

    /// The mip level, with its fraction, for a footprint; grows monotonically with it. NaN gives 0.
    pub fn level_of(&self, footprint: f32) -> f32 {
        let base = &self.source.levels[0];
        let texels = footprint * base.width as f32 * base.height as f32;
        if texels > 1.0 { (0.5 * texels.log2()).min((self.level_count() - 1) as f32) } else { 0.0 }
    }

    fn nearest(&self, uv: Vec2) -> Vec4 {
        let level = self.level(0);
        let x = (wrap_unit(uv.x, self.source.wrap_s) * level.width as f32) as u32;
        let y = (wrap_unit(uv.y, self.source.wrap_t) * level.height as f32) as u32;
        self.texel(level, x.min(level.width - 1), y.min(level.height - 1))
    }

    fn bilinear(&self, level: usize, uv: Vec2) -> Vec4 {
        let level = self.level(level);
        let (x0, x1, fx) = neighbours(uv.x, level.width, self.source.wrap_s);
        let (y0, y1, fy) = neighbours(uv.y, level.height, self.source.wrap_t);
        let low = self.texel(level, x0, y0).lerp(self.texel(level, x1, y0), fx);
        let high = self.texel(level, x0, y1).lerp(self.texel(level, x1, y1), fx);
        low.lerp(high, fy)
    }

    #[inline]
    fn texel(&self, level: &TextureLevel, x: u32, y: u32) -> Vec4 {
        decode(level.texels[y as usize * level.width as usize + x as usize], self.source.format)
    }
}

fn decode(texel: [u8; 4], format: TextureFormat) -> Vec4 {
    let [r, g, b, a] = texel;
    let alpha = f32::from(a) / 255.0;
    match format {
        TextureFormat::Linear => Vec4::new(f32::from(r) / 255.0, f32::from(g) / 255.0, f32::from(b) / 255.0, alpha),
        TextureFormat::Srgb => {
            let curve = &*SRGB;
            Vec4::new(curve[usize::from(r)], curve[usize::from(g)], curve[usize::from(b)], alpha)
        }
    }
}

/// Linear value of each 8-bit sRGB code.
static SRGB: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|code| {
        let x = code as f64 / 255.0;
        (if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }) as f32
    })
});

/// The texel nearest to a mean of texels.
fn encode(color: Vec4, format: TextureFormat) -> [u8; 4] {
    let linear = |x: f32| (x.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
    let curved = |x: f32| {
        let above = SRGB.partition_point(|&code| code < x).clamp(1, 255);
        let nearer_below = x - SRGB[above - 1] < SRGB[above] - x;
        (above - usize::from(nearer_below)) as u8
    };
    let [r, g, b, a] = color.to_array();
    match format {
        TextureFormat::Linear => [linear(r), linear(g), linear(b), linear(a)],
        TextureFormat::Srgb => [curved(r), curved(g), curved(b), linear(a)],
    }
}

/// A coordinate brought into [0, 1] by its wrap mode; not a number gives 0.
#[inline]
fn wrap_unit(u: f32, wrap: Wrap) -> f32 {
    if !u.is_finite() {
        return 0.0;
    }
    match wrap {
        Wrap::Repeat => u - u.floor(),
        Wrap::ClampToEdge => u.clamp(0.0, 1.0),
        Wrap::MirroredRepeat => {
            let v = u - 2.0 * (u * 0.5).floor();
            if v > 1.0 { 2.0 - v } else { v }
        }
    }
}

/// The two texels beside a coordinate, and the weight of the second. Texel centres lie at (i + ½)/size.
#[inline]
fn neighbours(u: f32, size: u32, wrap: Wrap) -> (u32, u32, f32) {
    let x = wrap_unit(u, wrap) * size as f32 - 0.5;
    let low = x.floor();
    let blend = x - low;
    // `low` is between −1 and size − 1, or size when rounding carried it there.
    let i = low as i64;
    let last = i64::from(size) - 1;
    let bring_in = |i: i64| match wrap {
        Wrap::Repeat => i.rem_euclid(last + 1),
        // A mirrored coordinate meets its own image at the border: the same texel.
        Wrap::ClampToEdge | Wrap::MirroredRepeat => i.clamp(0, last),
    } as u32;
    (bring_in(i), bring_in(i + 1), blend)
}

/// The next mip level: half the size, rounded down but at least 1; each texel the area-weighted mean of what it
/// covers (for odd sizes up to three texels a side), in linear light.
fn half(level: &TextureLevel, format: TextureFormat) -> Result<TextureLevel, OutOfMemory> {
    let width = (level.width / 2).max(1);
    let height = (level.height / 2).max(1);
    let columns = collected((0..width).map(|x| coverage(x, width, level.width)))?;
    let mut texels = vec_of(width as usize * height as usize)?;
    for y in 0..height {
        let rows = coverage(y, height, level.height);
        for column in &columns {
            let mut sum = Vec4::ZERO;
            let mut weight = 0.0;
            for &(sy, wy) in rows.iter().filter(|r| r.1 > 0.0) {
                for &(sx, wx) in column.iter().filter(|c| c.1 > 0.0) {
                    let texel = level.texels[sy as usize * level.width as usize + sx as usize];
                    sum += decode(texel, format) * (wx * wy);
                    weight += wx * wy;
                }
            }
            texels.push(encode(sum / weight, format));
        }
    }
    Ok(TextureLevel { width, height, texels })
}

/// Which source texels destination texel `i` covers, and how much of each.
fn coverage(i: u32, size: u32, source: u32) -> [(u32, f32); 3] {
    let ratio = f64::from(source) / f64::from(size);
    let (begin, end) = (f64::from(i) * ratio, f64::from(i + 1) * ratio);
    std::array::from_fn(|k| {
        let texel = begin as u32 + k as u32;
        let covered = (end.min(f64::from(texel) + 1.0) - begin.max(f64::from(texel))).max(0.0);
        if texel < source { (texel, covered as f32) } else { (source - 1, 0.0) }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texture(width: u32, height: u32, grey: &[u8], filter: Filter, wrap: Wrap) -> CompiledTexture {
        let texels = grey.iter().map(|&g| [g, g, g, 255]).collect();
        let source = Texture {
            levels: vec![TextureLevel { width, height, texels }],
            wrap_s: wrap,
            wrap_t: wrap,
            filter,
            ..Texture::default()
        };
        CompiledTexture::new(&Arc::new(source)).expect("memory").expect("an image")
    }

    fn red(t: &CompiledTexture, u: f32, v: f32) -> f32 {
        t.lookup(Vec2::new(u, v), 0.0).x * 255.0
    }

    #[test]
    fn nearest_takes_the_texel_under_the_point_with_row_0_at_the_bottom() {
        let t = texture(2, 2, &[10, 20, 30, 40], Filter::Nearest, Wrap::Repeat);
        for (u, v, value) in
            [(0.1, 0.1, 10.0), (0.9, 0.1, 20.0), (0.1, 0.9, 30.0), (1.1, -0.9, 10.0), (0.999_999_94, 0.0, 20.0)]
        {
            assert!((red(&t, u, v) - value).abs() < 1e-3, "{u} {v}");
        }
    }

    #[test]
    fn bilinear_weights_by_hand() {
        let t = texture(2, 2, &[0, 100, 40, 80], Filter::Linear, Wrap::ClampToEdge);
        // Texel centres at 1/4 and 3/4.
        for (u, v, value) in [
            (0.25, 0.25, 0.0),
            (0.75, 0.25, 100.0),
            (0.5, 0.25, 50.0),
            (0.5, 0.5, 55.0),
            (0.625, 0.375, 0.75 * (0.75 * 100.0) + 0.25 * (0.25 * 40.0 + 0.75 * 80.0)),
            (0.0, 0.0, 0.0),
            (1.0, 1.0, 80.0),
        ] {
            assert!((red(&t, u, v) - value).abs() < 1e-3, "{u} {v}: {} for {value}", red(&t, u, v));
        }
    }

    #[test]
    fn wrap_modes_at_the_border() {
        let at = |wrap, u| red(&texture(2, 1, &[0, 100], Filter::Linear, wrap), u, 0.5);
        // Half way between the last texel and what follows it.
        for (wrap, u, value) in [
            (Wrap::Repeat, 1.0, 50.0),
            (Wrap::Repeat, 1.25, 0.0),
            (Wrap::Repeat, -0.25, 100.0),
            (Wrap::ClampToEdge, 1.0, 100.0),
            (Wrap::ClampToEdge, 7.0, 100.0),
            (Wrap::ClampToEdge, -7.0, 0.0),
            (Wrap::MirroredRepeat, 1.0, 100.0),
            (Wrap::MirroredRepeat, 1.25, 100.0),
            (Wrap::MirroredRepeat, 1.75, 0.0),
            (Wrap::MirroredRepeat, -0.25, 0.0),
            (Wrap::MirroredRepeat, 2.5, 50.0),
        ] {
            assert!((at(wrap, u) - value).abs() < 1e-3, "{wrap:?} {u}: {}", at(wrap, u));
        }
        for wrap in [Wrap::Repeat, Wrap::ClampToEdge, Wrap::MirroredRepeat] {
            for u in [f32::NAN, f32::INFINITY, -1e30, 1e30, -1e-30] {
                assert!(at(wrap, u).is_finite());
            }
        }
    }

    #[test]
    fn a_transform_comes_before_everything_else() {
        let texels = vec![[0, 0, 0, 255], [100, 100, 100, 255]];
        let source = Texture {
            levels: vec![TextureLevel { width: 2, height: 1, texels }],
            filter: Filter::LinearMipmapLinear,
            transform: Affine2::from_scale_angle_translation(Vec2::splat(2.0), 0.0, Vec2::new(0.25, 0.0)),
            ..Texture::default()
        };
        let t = CompiledTexture::new(&Arc::new(source)).expect("memory").expect("an image");
        assert_eq!((red(&t, 0.0, 0.0), red(&t, 0.25, 0.0), red(&t, 0.5, 0.0)), (0.0, 100.0, 0.0));
        // A footprint of half the surface's square is twice the image.
        assert!((t.lookup(Vec2::ZERO, 0.5).x * 255.0 - 50.0).abs() < 1e-3);
    }

    #[test]
    fn srgb_texels_are_decoded_before_filtering() {
        let texels = vec![[0, 0, 0, 255], [255, 255, 255, 0]];
        let source = Texture {
            levels: vec![TextureLevel { width: 2, height: 1, texels }],
            filter: Filter::Linear,
            format: TextureFormat::Srgb,
            ..Texture::default()
        };
        let t = CompiledTexture::new(&Arc::new(source)).expect("memory").expect("an image");
        assert_eq!(t.lookup(Vec2::new(0.5, 0.5), 0.0), Vec4::splat(0.5));
    }

    #[test]
    fn mip_levels_hold_means_and_odd_sizes_lose_nothing() {
        for (width, height) in [(4, 4), (5, 3), (7, 1), (3, 3)] {
            let grey: Vec<u8> = (0..width * height).map(|i| (i * 37 % 251) as u8).collect();
            let mean = grey.iter().map(|&g| f32::from(g)).sum::<f32>() / grey.len() as f32;
            let t = texture(width, height, &grey, Filter::LinearMipmapLinear, Wrap::Repeat);
            let top = t.level(t.level_count() - 1);
            assert_eq!((top.width, top.height), (1, 1));
            // Each level rounds to 8 bits.
            assert!((f32::from(top.texels[0][0]) - mean).abs() <= 0.5 * t.level_count() as f32, "{width}x{height}");
        }
        let t = texture(2, 2, &[0, 100, 40, 80], Filter::LinearMipmapLinear, Wrap::Repeat);
        assert_eq!(t.level(1).texels, [[55, 55, 55, 255]]);
        // Footprint of two texels: half way between the levels; of four or more: the top.
        let blended = t.lookup(Vec2::new(0.25, 0.25), 0.5).x * 255.0;
        assert!((blended - 27.5).abs() < 1e-3);
        assert!((t.lookup(Vec2::new(0.25, 0.25), 9.0).x * 255.0 - 55.0).abs() < 1e-3);
    }

    #[test]
    fn the_level_grows_with_the_footprint() {
        let t = texture(64, 32, &[128; 2048], Filter::LinearMipmapLinear, Wrap::Repeat);
        let mut last = 0.0;
        for i in 0..200 {
            let level = t.level_of(1e-6 * 1.1f32.powi(i));
            assert!(level >= last && level <= 6.0);
            last = level;
        }
        assert_eq!(last, 6.0);
        assert_eq!(t.level_of(1.0 / 2048.0), 0.0);
        assert_eq!(t.level_of(16.0 / 2048.0), 2.0);
        assert_eq!(t.level_of(f32::NAN), 0.0);
        assert_eq!(t.level_of(f32::INFINITY), 6.0);
    }

    #[test]
    fn a_broken_image_is_refused() {
        let level = TextureLevel { width: 2, height: 2, texels: vec![[0; 4]; 3] };
        assert!(
            CompiledTexture::new(&Arc::new(Texture { levels: vec![level], ..Texture::default() }))
                .expect("memory")
                .is_none()
        );
        assert!(CompiledTexture::new(&Arc::new(Texture::default())).expect("memory").is_none());
    }
}
