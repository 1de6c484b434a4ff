//! Which instruction sets this processor has, and which one is used.

use std::sync::OnceLock;

/// An instruction set for which kernels exist, weakest first. On processors other than x86-64 only `Scalar` exists.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Level {
    /// Plain Rust, the reference.
    Scalar,
    /// 128-bit vectors.
    Sse41,
    /// 256-bit vectors, and the bit instructions BMI1, BMI2, LZCNT and POPCNT.
    Avx2,
    /// 256-bit vectors with mask registers (AVX-512 F and VL). Wider registers lower the clock of some processors and
    /// 8-wide nodes do not fill them.
    Avx512,
}

impl Level {
    /// Every level, weakest first.
    pub const ALL: [Level; 4] = [Level::Scalar, Level::Sse41, Level::Avx2, Level::Avx512];

    /// The strongest level that this processor can run. (A build with `OPENRT_FEW_LEVELS` in the environment has `Scalar` and `Avx2` only.)
    pub fn strongest() -> Level {
        #[cfg(target_arch = "x86_64")]
        {
            // The bit instructions came with the first AVX2 processors.
            let avx2 = is_x86_feature_detected!("avx2")
                && is_x86_feature_detected!("bmi1")
                && is_x86_feature_detected!("bmi2")
                && is_x86_feature_detected!("lzcnt")
                && is_x86_feature_detected!("popcnt");
            if avx2
                && !cfg!(openrt_few_levels)
                && is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512vl")
            {
                return Level::Avx512;
            }
            if avx2 {
                return Level::Avx2;
            }
            if !cfg!(openrt_few_levels) && is_x86_feature_detected!("sse4.1") {
                return Level::Sse41;
            }
        }
        Level::Scalar
    }

    /// The level to use: the strongest one, unless the environment variable `OPENRT_SIMD` (`scalar`, `sse`, `avx2` or
    /// `avx512`) asks for a weaker one. It cannot raise the level; other values are ignored. Read once per process.
    pub fn detect() -> Level {
        static LEVEL: OnceLock<Level> = OnceLock::new();
        *LEVEL.get_or_init(|| {
            let asked = std::env::var("OPENRT_SIMD").ok().and_then(|name| Level::from_name(&name));
            Level::lowered(Level::strongest(), asked)
        })
    }

    fn lowered(strongest: Level, asked: Option<Level>) -> Level {
        asked.map_or(strongest, |level| level.min(strongest))
    }

    /// Whether this processor can run kernels of this level, and they were compiled.
    pub fn is_available(self) -> bool {
        self <= Level::strongest() && !(cfg!(openrt_few_levels) && self == Level::Sse41)
    }

    /// The levels that this processor can run, weakest first; for tests that must hold on each.
    pub fn available() -> impl Iterator<Item = Level> {
        Level::ALL.into_iter().filter(|level| level.is_available())
    }

    /// Lower-case name, as accepted by `OPENRT_SIMD`.
    pub fn name(self) -> &'static str {
        match self {
            Level::Scalar => "scalar",
            Level::Sse41 => "sse",
            Level::Avx2 => "avx2",
            Level::Avx512 => "avx512",
        }
    }

    /// Inverse of [`Level::name`].
    pub fn from_name(name: &str) -> Option<Level> {
        Level::ALL.into_iter().find(|level| level.name() == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_environment_lowers_but_never_raises() {
        assert_eq!(Level::lowered(Level::Avx2, None), Level::Avx2);
        assert_eq!(Level::lowered(Level::Avx2, Some(Level::Scalar)), Level::Scalar);
        assert_eq!(Level::lowered(Level::Avx2, Some(Level::Avx512)), Level::Avx2);
    }

    #[test]
    fn names_go_both_ways_and_scalar_is_everywhere() {
        for level in Level::ALL {
            assert_eq!(Level::from_name(level.name()), Some(level));
        }
        assert_eq!(Level::from_name("neon"), None);
        assert_eq!(Level::available().next(), Some(Level::Scalar));
        assert!(Level::detect() <= Level::strongest());
    }
}
