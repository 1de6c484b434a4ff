//! Eight numbers as one, for code that may not be `unsafe`.
//!
//! [`run_wide`] gives a kernel a [`Proof`] that the processor has an instruction set; numbers ([`Wide`], [`Wide3`]) come only from a
//! proof or from other numbers, so whoever holds one may compute with it. Operators are those of [`Vector`], lane by lane, and
//! [`Wide3`] sums in the order of `glam::Vec3`: eight points in lanes get the bits that each would get alone.
//!
//! Against loops over arrays ([`super::run`]): those are the shorter where the compiler makes vectors of them, which it does not
//! where a choice or a square root stands in a long body. Here nothing depends on its mood.

use super::{Eight, Isa, Level, Scalar, Vector};
use glam::Vec3;
use std::marker::PhantomData;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Lanes of a [`Wide`].
pub const LANES: usize = 8;

/// The processor has the instruction set `I`.
#[derive(Clone, Copy, Debug)]
pub struct Proof<I>(PhantomData<I>);

/// Work over [`Wide`] numbers. `run` and everything that it calls with them is `#[inline(always)]`.
pub trait WideKernel {
    type Output;
    fn run<I: Isa>(self, isa: Proof<I>) -> Self::Output;
}

/// Runs `kernel` by the instructions of `level`, or of what this processor has if that is less.
#[inline]
pub fn run_wide<K: WideKernel>(level: Level, kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    {
        use super::Avx2;
        #[cfg(not(openrt_few_levels))]
        use super::{Avx512, Sse41};

        #[cfg(not(openrt_few_levels))]
        #[target_feature(enable = "sse4.1")]
        fn sse41<K: WideKernel>(kernel: K) -> K::Output {
            kernel.run(Proof::<Sse41>(PhantomData))
        }
        #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
        fn avx2<K: WideKernel>(kernel: K) -> K::Output {
            kernel.run(Proof::<Avx2>(PhantomData))
        }
        #[cfg(not(openrt_few_levels))]
        #[target_feature(enable = "avx512f,avx512vl,avx2,bmi1,bmi2,lzcnt,popcnt")]
        fn avx512<K: WideKernel>(kernel: K) -> K::Output {
            kernel.run(Proof::<Avx512>(PhantomData))
        }
        match level.min(Level::strongest()) {
            // SAFETY: `Level::strongest` has asked the processor for all features of the level.
            Level::Avx2 => return unsafe { avx2(kernel) },
            // SAFETY: as above.
            #[cfg(not(openrt_few_levels))]
            Level::Sse41 => return unsafe { sse41(kernel) },
            // SAFETY: as above.
            #[cfg(not(openrt_few_levels))]
            Level::Avx512 => return unsafe { avx512(kernel) },
            _ => {}
        }
    }
    let _ = level;
    kernel.run(Proof::<Scalar>(PhantomData))
}

/// Eight numbers.
#[derive(Clone, Copy)]
pub struct Wide<I: Isa>(I::F8);

impl<I: Isa> Proof<I> {
    /// The same number in all lanes.
    #[inline(always)]
    pub fn splat(self, value: f32) -> Wide<I> {
        // SAFETY: the proof.
        Wide(unsafe { I::F8::splat(value) })
    }

    #[inline(always)]
    pub fn load(self, from: &[f32; LANES]) -> Wide<I> {
        // SAFETY: the proof.
        Wide(unsafe { I::F8::load(from) })
    }

    /// Lane `i` of row `k` becomes lane `k` of row `i`.
    #[inline(always)]
    pub fn transposed(self, rows: [Wide<I>; LANES]) -> [Wide<I>; LANES] {
        let [a, b, c, d, e, f, g, h] = rows;
        // SAFETY: the proof.
        let [a, b, c, d, e, f, g, h] = unsafe { I::F8::transpose([a.0, b.0, c.0, d.0, e.0, f.0, g.0, h.0]) };
        [Wide(a), Wide(b), Wide(c), Wide(d), Wide(e), Wide(f), Wide(g), Wide(h)]
    }

    /// The same vector in all lanes.
    #[inline(always)]
    pub fn splat3(self, v: Vec3) -> Wide3<I> {
        Wide3 { x: self.splat(v.x), y: self.splat(v.y), z: self.splat(v.z) }
    }

    /// Row by row.
    #[inline(always)]
    pub fn load3(self, from: [&[f32; LANES]; 3]) -> Wide3<I> {
        Wide3 { x: self.load(from[0]), y: self.load(from[1]), z: self.load(from[2]) }
    }
}

impl<I: Isa> Wide<I> {
    #[inline(always)]
    pub fn store(self, to: &mut [f32; LANES]) {
        // SAFETY: a number exists only where there was a proof (here and below).
        unsafe { self.0.store(to) }
    }

    /// The bits of lanes that hold integers: loaded as numbers, and moved about only.
    #[inline(always)]
    pub fn store_bits(self, to: &mut [u32; LANES]) {
        // SAFETY: as in `store`; any four bytes are a u32.
        unsafe { self.0.store(&mut *to.as_mut_ptr().cast::<[f32; LANES]>()) }
    }

    #[inline(always)]
    pub fn abs(self) -> Self {
        // SAFETY: as in `store`.
        Wide(unsafe { self.0.abs() })
    }

    #[inline(always)]
    pub fn sqrt(self) -> Self {
        // SAFETY: as in `store`.
        Wide(unsafe { self.0.sqrt() })
    }

    /// `if self < other { self } else { other }`.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        // SAFETY: as in `store`.
        Wide(unsafe { self.0.min(other.0) })
    }

    /// `if self > other { self } else { other }`.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        // SAFETY: as in `store`.
        Wide(unsafe { self.0.max(other.0) })
    }

    /// `if self <= other { yes } else { no }`.
    #[inline(always)]
    pub fn select_le(self, other: Self, yes: Self, no: Self) -> Self {
        // SAFETY: as in `store`.
        Wide(unsafe { self.0.select_le(other.0, yes.0, no.0) })
    }

    /// This where the bit of the lane is set, else `other`.
    #[inline(always)]
    pub fn select(self, other: Self, mask: u32) -> Self {
        // SAFETY: as in `store`.
        Wide(unsafe { self.0.select_bits(other.0, mask) })
    }

    /// A bit per lane; false for NaN.
    #[inline(always)]
    pub fn le(self, other: Self) -> u32 {
        // SAFETY: as in `store`.
        unsafe { self.0.le(other.0) }
    }

    /// A bit per lane; false for NaN.
    #[inline(always)]
    pub fn lt(self, other: Self) -> u32 {
        // SAFETY: as in `store`.
        unsafe { self.0.lt(other.0) }
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident) => {
        impl<I: Isa> $trait for Wide<I> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: as in `store`.
                Wide(unsafe { Vector::$method(self.0, other.0) })
            }
        }

        impl<I: Isa> $trait for Wide3<I> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Wide3 { x: self.x.$method(other.x), y: self.y.$method(other.y), z: self.z.$method(other.z) }
            }
        }

        impl<I: Isa> $trait<Wide<I>> for Wide3<I> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Wide<I>) -> Self {
                Wide3 { x: self.x.$method(other), y: self.y.$method(other), z: self.z.$method(other) }
            }
        }
    };
}

operator!(Add, add);
operator!(Sub, sub);
operator!(Mul, mul);
operator!(Div, div);

impl<I: Isa> Neg for Wide<I> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // Times -1 rather than 0 - x: it turns the sign of 0 as well.
        // SAFETY: as in `store`.
        Wide(unsafe { self.0.mul(I::F8::splat(-1.0)) })
    }
}

/// Eight vectors.
#[derive(Clone, Copy)]
pub struct Wide3<I: Isa> {
    pub x: Wide<I>,
    pub y: Wide<I>,
    pub z: Wide<I>,
}

impl<I: Isa> Neg for Wide3<I> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Wide3 { x: -self.x, y: -self.y, z: -self.z }
    }
}

impl<I: Isa> Wide3<I> {
    #[inline(always)]
    pub fn store(self, to: [&mut [f32; LANES]; 3]) {
        let [x, y, z] = to;
        self.x.store(x);
        self.y.store(y);
        self.z.store(z);
    }

    #[inline(always)]
    pub fn dot(self, other: Self) -> Wide<I> {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Wide3 {
            x: self.y * other.z - other.y * self.z,
            y: self.z * other.x - other.z * self.x,
            z: self.x * other.y - other.x * self.y,
        }
    }

    #[inline(always)]
    pub fn length(self) -> Wide<I> {
        self.dot(self).sqrt()
    }

    #[inline(always)]
    pub fn abs(self) -> Self {
        Wide3 { x: self.x.abs(), y: self.y.abs(), z: self.z.abs() }
    }

    /// Component by component.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        Wide3 { x: self.x.max(other.x), y: self.y.max(other.y), z: self.z.max(other.z) }
    }

    #[inline(always)]
    pub fn max_element(self) -> Wide<I> {
        self.x.max(self.y.max(self.z))
    }

    /// This where the bit of the lane is set, else `other`.
    #[inline(always)]
    pub fn select(self, other: Self, mask: u32) -> Self {
        Wide3 { x: self.x.select(other.x, mask), y: self.y.select(other.y, mask), z: self.z.select(other.z, mask) }
    }

    /// The vectors at length 1, and a bit for each that can be brought there; of the others the result means nothing.
    #[inline(always)]
    pub fn try_normalize(self, isa: Proof<I>) -> (Self, u32) {
        let reciprocal = isa.splat(1.0) / self.length();
        // Written so that NaN fails.
        let good = isa.splat(0.0).lt(reciprocal) & reciprocal.le(isa.splat(f32::MAX));
        (self * reciprocal, good)
    }

    /// The vectors at length 1, or `fallback` where that cannot be.
    #[inline(always)]
    pub fn normalize_or(self, fallback: Self, isa: Proof<I>) -> Self {
        let (normalized, good) = self.try_normalize(isa);
        if good == 0xff { normalized } else { normalized.select(fallback, good) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const VECTORS: [Vec3; LANES] = [
        Vec3::new(1.0, 2.0, 3.0),
        Vec3::ZERO,
        Vec3::new(1e-30, -1e-30, 1e-30),
        Vec3::new(f32::NAN, 1.0, 0.0),
        Vec3::new(f32::INFINITY, 0.0, 0.0),
        Vec3::new(1e30, 1e30, -1e30),
        Vec3::new(-0.0, 0.1, 0.7),
        Vec3::new(1e-39, 0.0, 0.0),
    ];

    /// Vectors through everything that sums or chooses.
    struct All(usize);

    impl WideKernel for All {
        type Output = [[f32; LANES]; 13];

        #[inline(always)]
        fn run<I: Isa>(self, isa: Proof<I>) -> Self::Output {
            let rows = |turn: usize| {
                let row = |k: usize| std::array::from_fn(|l| VECTORS[(l + turn) % LANES][k]);
                isa.load3([&row(0), &row(1), &row(2)])
            };
            let (a, b) = (rows(0), rows(self.0));
            let mut to = [[0.0; LANES]; 13];
            a.dot(b).store(&mut to[0]);
            let (cross, others) = to[1..].split_at_mut(3);
            let [x, y, z] = cross else { unreachable!() };
            a.cross(b).store([x, y, z]);
            let (unit, others) = others.split_at_mut(3);
            let [x, y, z] = unit else { unreachable!() };
            a.normalize_or(b, isa).store([x, y, z]);
            let (negative, others) = others.split_at_mut(3);
            let [x, y, z] = negative else { unreachable!() };
            (-a).store([x, y, z]);
            a.x.select_le(b.x, a.y, b.y).store(&mut others[0]);
            a.abs().max_element().store(&mut others[1]);
            (a * b.x / b.y).length().store(&mut others[2]);
            to
        }
    }

    /// Eight rows of integers, each moved to where the others have their lane.
    struct Turn<'a>(&'a [[f32; LANES]; LANES]);

    impl WideKernel for Turn<'_> {
        type Output = [[u32; LANES]; LANES];

        #[inline(always)]
        fn run<I: Isa>(self, isa: Proof<I>) -> Self::Output {
            let mut rows = [isa.splat(0.0); LANES];
            for (row, from) in rows.iter_mut().zip(self.0) {
                *row = isa.load(from);
            }
            let mut to = [[0; LANES]; LANES];
            for (row, to) in isa.transposed(rows).into_iter().zip(&mut to) {
                row.store_bits(to);
            }
            to
        }
    }

    #[test]
    fn integers_are_moved_bit_by_bit() {
        // Among them NaNs of both kinds, denormals and all ones.
        let integers: [[u32; LANES]; LANES] = std::array::from_fn(|k| {
            std::array::from_fn(|i| [0x7f80_0001, 0xffff_ffff, 0xff80_0000, 1, 0x8000_0000][(8 * k + i) % 5] ^ k as u32)
        });
        let turned: [[u32; LANES]; LANES] = std::array::from_fn(|i| std::array::from_fn(|k| integers[k][i]));
        for level in Level::available() {
            let rows = integers.map(|row| row.map(f32::from_bits));
            assert_eq!(run_wide(level, Turn(&rows)), turned, "{}", level.name());
        }
    }

    #[test]
    fn lanes_get_what_vectors_get_alone_on_every_level() {
        let bits = |x: f32| if x.is_nan() { u32::MAX } else { x.to_bits() };
        for level in Level::available() {
            for turn in 0..LANES {
                let wide = run_wide(level, All(turn));
                for l in 0..LANES {
                    let (a, b) = (VECTORS[l], VECTORS[(l + turn) % LANES]);
                    let unit = a.normalize_or(b);
                    let cross = a.cross(b);
                    let alone = [
                        a.dot(b),
                        cross.x,
                        cross.y,
                        cross.z,
                        unit.x,
                        unit.y,
                        unit.z,
                        -a.x,
                        -a.y,
                        -a.z,
                        if a.x <= b.x { a.y } else { b.y },
                        a.abs().max_element(),
                        (a * b.x / b.y).length(),
                    ];
                    let lane = wide.map(|row| bits(row[l]));
                    assert_eq!(lane, alone.map(bits), "{}: {a} and {b}", level.name());
                }
            }
        }
    }
}
