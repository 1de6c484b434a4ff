//! Seeded random numbers for tests.

use glam::Vec3;

/// SplitMix64: small, seedable, good enough for tests.
pub struct Random(u64);

impl Random {
    /// `OPENRT_SEED` overrides the seed; failing assertions should print the seed they ran with.
    pub fn seed(default: u64) -> u64 {
        std::env::var("OPENRT_SEED").ok().and_then(|s| s.parse().ok()).unwrap_or(default)
    }

    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ (x >> 31)
    }

    /// In `[0, 1)`.
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1u64 << 24) as f32
    }

    /// In `[-1, 1)` on each axis.
    pub fn vec(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }
}
