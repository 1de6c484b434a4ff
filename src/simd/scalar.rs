//! Vectors in plain Rust: what runs where there is no better, and the reference for all others.

use super::{Eight, Isa, Vector};
use std::array;

/// The instruction set that every processor has.
#[derive(Clone, Copy, Debug)]
pub struct Scalar;

/// An array that acts as a [`Vector`].
#[derive(Clone, Copy, Debug)]
pub struct Lanes<const N: usize>([f32; N]);

impl Isa for Scalar {
    type F4 = Lanes<4>;
    type F8 = Lanes<8>;
}

impl Eight for Lanes<8> {}

impl<const N: usize> Lanes<N> {
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        Lanes(array::from_fn(|i| f(self.0[i], other.0[i])))
    }

    #[inline(always)]
    fn compare(self, other: Self, f: impl Fn(f32, f32) -> bool) -> u32 {
        (0..N).fold(0, |mask, i| mask | (f(self.0[i], other.0[i]) as u32) << i)
    }
}

impl<const N: usize> Vector for Lanes<N> {
    type Array = [f32; N];

    #[inline(always)]
    unsafe fn splat(value: f32) -> Self {
        Lanes([value; N])
    }
    #[inline(always)]
    unsafe fn load(from: &[f32; N]) -> Self {
        Lanes(*from)
    }
    #[inline(always)]
    unsafe fn store(self, to: &mut [f32; N]) {
        *to = self.0;
    }
    #[inline(always)]
    unsafe fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
    #[inline(always)]
    unsafe fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
    #[inline(always)]
    unsafe fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
    #[inline(always)]
    unsafe fn div(self, other: Self) -> Self {
        self.zip(other, |a, b| a / b)
    }
    #[inline(always)]
    unsafe fn sqrt(self) -> Self {
        Lanes(self.0.map(f32::sqrt))
    }
    #[inline(always)]
    unsafe fn abs(self) -> Self {
        Lanes(self.0.map(f32::abs))
    }
    #[inline(always)]
    unsafe fn select_le(self, other: Self, yes: Self, no: Self) -> Self {
        Lanes(array::from_fn(|i| if self.0[i] <= other.0[i] { yes.0[i] } else { no.0[i] }))
    }
    #[inline(always)]
    unsafe fn select_bits(self, other: Self, mask: u32) -> Self {
        Lanes(array::from_fn(|i| if mask >> i & 1 == 1 { self.0[i] } else { other.0[i] }))
    }
    #[inline(always)]
    unsafe fn min(self, other: Self) -> Self {
        self.zip(other, |a, b| if a < b { a } else { b })
    }
    #[inline(always)]
    unsafe fn max(self, other: Self) -> Self {
        self.zip(other, |a, b| if a > b { a } else { b })
    }
    #[inline(always)]
    unsafe fn le(self, other: Self) -> u32 {
        self.compare(other, |a, b| a <= b)
    }
    #[inline(always)]
    unsafe fn lt(self, other: Self) -> u32 {
        self.compare(other, |a, b| a < b)
    }
}
