//! Safe code compiled once per instruction set.
//!
//! Loops over boxes need no intrinsics: written over arrays of lanes, the compiler makes vectors of them, of the width that it may
//! assume. So such a loop is a [`Kernel`], and [`run`] has a shell per instruction set that it inlines into. Rust never contracts
//! `a * b + c` and never reorders sums, so all shells give the same bits.

use super::Level;

/// Work whose `run` is `#[inline(always)]`, as is everything in it that should use wide vectors.
pub trait Kernel {
    type Output;
    fn run(self) -> Self::Output;
}

/// Runs `kernel`, compiled for `level`, or for what this processor has if that is less.
#[inline]
pub fn run<K: Kernel>(level: Level, kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    if level.min(Level::strongest()) >= Level::Avx2 {
        #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
        fn avx2<K: Kernel>(kernel: K) -> K::Output {
            kernel.run()
        }
        // SAFETY: `Level::strongest` has asked the processor for all of them.
        return unsafe { avx2(kernel) };
    }
    let _ = level;
    kernel.run()
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Sum<'a>(&'a [[f32; 8]]);

    impl Kernel for Sum<'_> {
        type Output = [u32; 8];

        #[inline(always)]
        fn run(self) -> [u32; 8] {
            let mut all = [0.0f32; 8];
            for lanes in self.0 {
                // A fused multiply-add would round once.
                all = std::array::from_fn(|i| all[i] * 0.7 + lanes[i]);
            }
            all.map(f32::to_bits)
        }
    }

    #[test]
    fn every_level_gives_the_same_bits() {
        let lanes: Vec<[f32; 8]> = (0..100).map(|n| std::array::from_fn(|i| ((n * 8 + i) as f32).sin())).collect();
        let plain = run(Level::Scalar, Sum(&lanes));
        for level in Level::ALL {
            // Levels that this processor lacks fall back.
            assert_eq!(run(level, Sum(&lanes)), plain, "{}", level.name());
        }
    }
}
