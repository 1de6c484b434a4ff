//! Every operation of every instruction set against plain Rust, on values that tell them apart.

use super::skip::skipped;
use super::{Eight, Isa, Level, Scalar, Vector};
use std::mem::MaybeUninit;

/// Signed zeros, denormals, infinities, NaN and neighbours; products and sums of these round in every way.
const VALUES: [f32; 16] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    1.0 + f32::EPSILON,
    1.0 - f32::EPSILON / 2.0,
    3.0e38,
    -3.0e38,
    1.0e-40,
    -1.0e-45,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
    16_777_217.0,
    0.1,
    -7.3e-12,
];

/// Lanes, and whether each is NaN (whose bits are not specified).
fn bits<const N: usize>(lanes: [f32; N]) -> [u32; N] {
    lanes.map(|x| if x.is_nan() { u32::MAX } else { x.to_bits() })
}

/// All operations on two vectors, as comparable bits.
///
/// # Safety
/// - The processor has the instruction set of `V`.
#[inline(always)]
unsafe fn all<V: Vector<Array = [f32; N]>, const N: usize>(a: [f32; N], b: [f32; N]) -> ([[u32; N]; 11], [u32; 2]) {
    // SAFETY: the caller's promise.
    unsafe {
        let stored = |v: V| {
            let mut to = [0.0; N];
            v.store(&mut to);
            bits(to)
        };
        let (x, y) = (V::load(&a), V::load(&b));
        (
            [
                stored(x.add(y)),
                stored(x.sub(y)),
                stored(x.mul(y)),
                stored(x.div(y)),
                stored(x.abs()),
                stored(x.sqrt()),
                stored(x.select_le(y, y, x)),
                stored(x.select_bits(y, a[1].to_bits() ^ b[2].to_bits().rotate_left(9))),
                stored(x.min(y)),
                stored(x.max(y)),
                // Fused, this would be 2^-46 instead of 0 for some of the values.
                stored(x.mul(y).sub(V::splat(a[0] * b[0]))),
            ],
            [x.le(y), x.lt(y)],
        )
    }
}

type OfFour = ([[u32; 4]; 11], [u32; 2]);
type OfEight = ([[u32; 8]; 11], [u32; 2]);
/// Eight rows transposed, and a row picked from; the least and the greatest of a row; which of a row are not above another's, and the nearest; these packed, and how many.
type Shuffled = ([[u32; 8]; 9], [u32; 2], (u32, usize), (Vec<u64>, usize));

/// # Safety
/// - The processor has the instruction set `I`.
#[inline(always)]
unsafe fn both<I: Isa>(a: [f32; 8], b: [f32; 8]) -> (OfFour, OfEight, Shuffled) {
    let half = |x: [f32; 8]| [x[0], x[1], x[2], x[3]];
    // SAFETY: the caller's promise.
    unsafe { (all::<I::F4, 4>(half(a), half(b)), all::<I::F8, 8>(a, b), shuffled::<I::F8>(a, b)) }
}

/// # Safety
/// - The processor has the instruction set of `V`.
#[inline(always)]
unsafe fn shuffled<V: Eight>(a: [f32; 8], b: [f32; 8]) -> Shuffled {
    // SAFETY: the caller's promise.
    unsafe {
        let mut rows = [V::load(&a); 8];
        for (k, row) in rows.iter_mut().enumerate() {
            let turned = if k % 2 == 0 { a } else { b };
            *row = V::load(&std::array::from_fn(|i| turned[(i + k) % 8]));
        }
        let mut columns = [[0; 8]; 9];
        for (to, column) in columns.iter_mut().zip(V::transpose(rows)) {
            let mut lanes = [0.0; 8];
            column.store(&mut lanes);
            *to = bits(lanes);
        }
        let mut picked = [0.0; 8];
        V::load(&a).pick(V::load(&b)).store(&mut picked);
        columns[8] = bits(picked);
        // Without NaN, and with one zero.
        let row = V::load(&b.map(|x| if x.is_nan() || x == 0.0 { 0.25 } else { x }));
        let distances = V::load(&b.map(|x| if x.is_nan() { 0.25 } else { x.abs() }));
        let (mask, nearest) = distances.nearest_le(V::load(&a));
        // Behind those of the mask there may be anything.
        let mut words = [const { MaybeUninit::uninit() }; 8];
        distances.pack_words(&[10, 11, 12, 13, 14, 15, 16, 17], mask, &mut words);
        let count = mask.count_ones() as usize;
        let packed = words[..count].iter().map(|word| word.assume_init()).collect();
        (columns, [row.least().to_bits(), row.greatest().to_bits()], (mask, nearest), (packed, count))
    }
}

fn at_level(level: Level, a: [f32; 8], b: [f32; 8]) -> (OfFour, OfEight, Shuffled) {
    #[cfg(target_arch = "x86_64")]
    {
        use super::{Avx2, Avx512, Sse41};
        #[target_feature(enable = "sse4.1")]
        fn sse41(a: [f32; 8], b: [f32; 8]) -> (OfFour, OfEight, Shuffled) {
            // SAFETY: this function has the features.
            unsafe { both::<Sse41>(a, b) }
        }
        #[target_feature(enable = "avx2,fma")]
        fn avx2(a: [f32; 8], b: [f32; 8]) -> (OfFour, OfEight, Shuffled) {
            // SAFETY: this function has the features.
            unsafe { both::<Avx2>(a, b) }
        }
        #[target_feature(enable = "avx2,avx512f,avx512vl,fma")]
        fn avx512(a: [f32; 8], b: [f32; 8]) -> (OfFour, OfEight, Shuffled) {
            // SAFETY: this function has the features.
            unsafe { both::<Avx512>(a, b) }
        }
        assert!(level.is_available());
        // FMA came with AVX2; it is on here to show that nothing gets fused.
        match level {
            Level::Scalar => {}
            // SAFETY: the level is available.
            Level::Sse41 => return unsafe { sse41(a, b) },
            // SAFETY: the level is available.
            Level::Avx2 => return unsafe { avx2(a, b) },
            // SAFETY: the level is available.
            Level::Avx512 => return unsafe { avx512(a, b) },
        }
    }
    assert_eq!(level, Level::Scalar);
    // SAFETY: every processor has it.
    unsafe { both::<Scalar>(a, b) }
}

#[test]
fn every_level_computes_what_plain_rust_does() {
    for level in Level::ALL.into_iter().filter(|l| !l.is_available()) {
        skipped(format_args!("level {} (this processor does not have it)", level.name()));
    }
    for first in 0..16 {
        for second in 0..16 {
            let a = std::array::from_fn(|i| VALUES[(first + i) % 16]);
            let b = std::array::from_fn(|i| VALUES[(second + i * 3) % 16]);
            let expected = at_level(Level::Scalar, a, b);
            for level in Level::available() {
                assert_eq!(at_level(level, a, b), expected, "{level:?}: {a:?} {b:?}");
            }
        }
    }
}

#[test]
fn scalar_min_and_max_give_the_second_operand_for_nan() {
    let one = [1.0; 4];
    let nan = [f32::NAN; 4];
    type V = <Scalar as Isa>::F4;
    // SAFETY: every processor has the scalar set.
    unsafe {
        let stored = |v: V| {
            let mut to = [0.0; 4];
            v.store(&mut to);
            to[0]
        };
        assert_eq!(stored(V::load(&nan).min(V::load(&one))), 1.0);
        assert_eq!(stored(V::load(&nan).max(V::load(&one))), 1.0);
        assert!(stored(V::load(&one).min(V::load(&nan))).is_nan());
        assert!(stored(V::load(&one).max(V::load(&nan))).is_nan());
        assert_eq!(V::load(&nan).le(V::load(&one)) | V::load(&nan).lt(V::load(&nan)), 0);
    }
}

#[test]
fn scalar_rows_become_columns() {
    let a = std::array::from_fn(|i| i as f32);
    let b = std::array::from_fn(|i| (10 + i) as f32);
    // SAFETY: every processor has the scalar set.
    let (columns, ends, ..) = unsafe { shuffled::<<Scalar as Isa>::F8>(a, b) };
    for (i, column) in columns.into_iter().take(8).enumerate() {
        let expected = std::array::from_fn(|k| ((i + k) % 8 + 10 * (k % 2)) as f32);
        assert_eq!(column, bits(expected), "column {i}");
    }
    assert_eq!(ends.map(f32::from_bits), [10.0, 17.0]);
}

#[test]
fn the_nearest_is_found_and_words_are_packed_in_order() {
    type V = <Scalar as Isa>::F8;
    let distances = [5.0, 2.0, f32::INFINITY, 1.5, 0.0, 9.0, 1.5, 3.0];
    // SAFETY: every processor has the scalar set.
    unsafe {
        let v = V::load(&distances);
        assert_eq!(v.nearest_le(V::splat(4.0)), (0b1101_1010, 4));
        assert_eq!(v.nearest_le(V::load(&[9.0, 9.0, 9.0, 9.0, -1.0, 9.0, 9.0, 9.0])), (0b1110_1011, 3));
        assert_eq!(v.nearest_le(V::splat(-1.0)).0, 0);
        let mut words = [const { MaybeUninit::uninit() }; 8];
        v.pack_words(&[0, 1, 2, 3, 4, 5, 6, 7], 0b1000_0101, &mut words);
        let word = |lane: usize| u64::from(distances[lane].to_bits()) << 32 | lane as u64;
        assert_eq!([0, 1, 2].map(|i| words[i].assume_init()), [0, 2, 7].map(word));
    }
}
