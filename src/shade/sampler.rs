//! Sample points and random numbers that depend on nothing but the pixel and the sample's number.
//!
//! Pictures must not depend on threads or on the order of tiles, so there is no shared generator: each camera sample
//! starts its own stream from a hash of (column, row, sample number). The seed never contains the frame, so a picture
//! does not flicker; frames that accumulate continue the sample numbers instead.
//!
//! The stream is PCG-XSH-RR 64/32 (O'Neill, *PCG*, 2014); point sets are Hammersley points shifted modulo 1
//! (Cranley and Patterson 1976), which stay stratified for any count.

use crate::memory::{OutOfMemory, Room};
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;

/// Random numbers of one camera sample.
#[derive(Clone, Copy)]
pub struct Rng {
    state: u64,
}

const MULTIPLIER: u64 = 6_364_136_223_846_793_005;
const INCREMENT: u64 = 1_442_695_040_888_963_407;

impl Rng {
    pub fn new(x: u32, y: u32, sample: u32) -> Self {
        // SplitMix64's finaliser over the packed coordinates: neighbouring pixels must not share low bits.
        let mut z = (u64::from(y) << 32 | u64::from(x)) ^ u64::from(sample).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        let mut rng = Self { state: z ^ (z >> 31) };
        rng.next_u32();
        rng
    }

    #[inline]
    pub fn next_u32(&mut self) -> u32 {
        let old = self.state;
        self.state = old.wrapping_mul(MULTIPLIER).wrapping_add(INCREMENT);
        let xorshifted = (((old >> 18) ^ old) >> 27) as u32;
        xorshifted.rotate_right((old >> 59) as u32)
    }

    /// Uniform in [0, 1).
    #[inline]
    pub fn next_f32(&mut self) -> f32 {
        (self.next_u32() >> 8) as f32 * (1.0 / (1 << 24) as f32)
    }

    #[inline]
    pub fn next_vec2(&mut self) -> Vec2 {
        let x = self.next_f32();
        Vec2::new(x, self.next_f32())
    }
}

/// Point `i` of the `n`-point Hammersley set, shifted by `shift` modulo 1; each coordinate lies in [0, 1).
#[inline]
pub fn hammersley(i: u32, n: u32, shift: Vec2) -> Vec2 {
    let x = (i as f32 + 0.5) / n as f32;
    let y = (i.reverse_bits() >> 8) as f32 * (1.0 / (1 << 24) as f32) + 0.5 / n as f32;
    fract(Vec2::new(x, y) + shift)
}

/// Fraction modulo 1 that never returns 1.
#[inline]
fn fract(p: Vec2) -> Vec2 {
    let q = p - p.floor();
    Vec2::select(q.cmpge(Vec2::ONE), Vec2::ZERO, q)
}

/// Positions of a pixel's samples inside the pixel, in [0, 1)². One sample is the centre; of several, the first is
/// the one nearest to the centre. Kept, as most tiles of a frame have the same.
#[derive(Default)]
pub struct PixelPattern {
    /// Samples, and the number of the frame among those that accumulate.
    of: (u32, u32),
    points: Vec<Vec2>,
}

impl PixelPattern {
    /// Makes room for so many samples.
    ///
    /// # Errors
    /// No memory.
    pub fn prepare(&mut self, samples: u32) -> Result<(), OutOfMemory> {
        self.points.room((samples.max(1) as usize).saturating_sub(self.points.len()))
    }

    /// The pattern of so many samples in a frame that is the `round`-th of those that accumulate.
    pub fn of(&mut self, samples: u32, round: u32) -> &[Vec2] {
        let samples = samples.max(1);
        if self.points.is_empty() || self.of != (samples, round) {
            self.of = (samples, round);
            self.points.clear();
            fill_pattern(samples, round, &mut self.points);
        }
        &self.points
    }
}

fn fill_pattern(samples: u32, round: u32, points: &mut Vec<Vec2>) {
    if samples == 1 && round == 0 {
        points.push(Vec2::splat(0.5));
        return;
    }
    // Each round is the same set, moved along the R2 sequence (Roberts 2018), so that the union stays even.
    let shift = (Vec2::new(0.754_877_7, 0.569_840_3) * round as f32).fract();
    let shift = if samples == 1 { shift } else { fract(shift) };
    points.extend((0..samples).map(|i| hammersley(i, samples, shift)));
    let distance = |p: &Vec2| p.distance_squared(Vec2::splat(0.5));
    let nearest = (0..points.len()).min_by(|&a, &b| distance(&points[a]).total_cmp(&distance(&points[b])));
    points.swap(0, nearest.expect("there is at least one sample"));
}

/// Uniform point of the unit disc (concentric map of Shirley and Chiu 1997).
pub fn disc(u: Vec2) -> Vec2 {
    let p = 2.0 * u - Vec2::ONE;
    if p == Vec2::ZERO {
        return p;
    }
    let (r, phi) = if p.x.abs() > p.y.abs() {
        (p.x, (TAU / 8.0) * (p.y / p.x))
    } else {
        (p.y, TAU / 4.0 - (TAU / 8.0) * (p.x / p.y))
    };
    Vec2::new(r * phi.cos(), r * phi.sin())
}

/// Direction about unit `n` with density cos/π.
pub fn cosine_hemisphere(n: Vec3, u: Vec2) -> Vec3 {
    let d = disc(u);
    let (t, b) = n.any_orthonormal_pair();
    (t * d.x + b * d.y + n * (1.0 - d.length_squared()).max(0.0).sqrt()).normalize_or(n)
}

/// Direction about unit `axis` with density (k+1)/2π · cosᵏ.
pub fn cosine_power(axis: Vec3, k: f32, u: Vec2) -> Vec3 {
    let cos = u.x.powf(1.0 / (k + 1.0));
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let (t, b) = axis.any_orthonormal_pair();
    let phi = TAU * u.y;
    (t * (sin * phi.cos()) + b * (sin * phi.sin()) + axis * cos).normalize_or(axis)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_sample_is_the_centre_and_patterns_are_stratified() {
        let mut pattern = PixelPattern::default();
        assert_eq!(pattern.of(1, 0), [Vec2::splat(0.5)]);
        for n in [4u32, 9, 16, 64] {
            let points = pattern.of(n, 0);
            for axis in 0..2 {
                let mut cells: Vec<u32> = points.iter().map(|p| (p[axis] * n as f32) as u32).collect();
                cells.sort_unstable();
                if axis == 0 || n.is_power_of_two() {
                    assert_eq!(cells, (0..n).collect::<Vec<_>>(), "one sample per {n}th of axis {axis}");
                }
            }
            assert!(points[1..].iter().all(|p| p.distance(Vec2::splat(0.5)) >= points[0].distance(Vec2::splat(0.5))));
        }
    }

    #[test]
    fn random_numbers_are_uniform_across_pixels() {
        // χ² of 256 cells, one number for each of 256 × 256 pixels: 255 degrees of freedom, 99.9 % below 331.
        for draw in 0..3 {
            let mut cells = [0u32; 256];
            for y in 0..256 {
                for x in 0..256 {
                    let mut rng = Rng::new(x, y, 5);
                    for _ in 0..draw {
                        rng.next_f32();
                    }
                    cells[(rng.next_f32() * 256.0) as usize] += 1;
                }
            }
            let chi2: f64 = cells.iter().map(|&n| (f64::from(n) - 256.0).powi(2) / 256.0).sum();
            assert!(chi2 < 331.0, "draw {draw}: chi2 = {chi2}");
        }
    }

    #[test]
    fn hemisphere_densities_have_the_right_mean_cosine() {
        let n = Vec3::new(0.3, -0.5, 0.8).normalize();
        let count = 100_000;
        let mean = |f: &dyn Fn(Vec2) -> Vec3| -> f64 {
            (0..count).map(|i| f64::from(f(hammersley(i, count, Vec2::ZERO)).dot(n))).sum::<f64>() / f64::from(count)
        };
        assert!((mean(&|u| cosine_hemisphere(n, u)) - 2.0 / 3.0).abs() < 1e-3);
        // E[cos] = (k+1)/(k+2).
        assert!((mean(&|u| cosine_power(n, 18.0, u)) - 19.0 / 20.0).abs() < 1e-3);
    }
}
