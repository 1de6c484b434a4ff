//! Vectors of x86-64: SSE4.1, AVX2, and AVX-512 F+VL with mask registers.
//!
//! The 4-wide vector is an SSE register everywhere; the 8-wide one is two of them on SSE4.1.

use super::{Isa, Vector};
use core::arch::x86_64::*;

/// 128-bit registers.
#[derive(Clone, Copy, Debug)]
pub struct Sse41;
/// 256-bit registers.
#[derive(Clone, Copy, Debug)]
pub struct Avx2;
/// 256-bit registers, comparisons into mask registers.
#[derive(Clone, Copy, Debug)]
pub struct Avx512;

impl Isa for Sse41 {
    type F4 = Sse4;
    type F8 = Sse8;
}

impl Isa for Avx2 {
    type F4 = Sse4;
    type F8 = Avx8;
}

impl Isa for Avx512 {
    type F4 = Mask4;
    type F8 = Mask8;
}

#[derive(Clone, Copy, Debug)]
pub struct Sse4(__m128);
#[derive(Clone, Copy, Debug)]
pub struct Sse8(pub(super) __m128, pub(super) __m128);
#[derive(Clone, Copy, Debug)]
pub struct Avx8(pub(super) __m256);
#[derive(Clone, Copy, Debug)]
pub struct Mask4(__m128);
#[derive(Clone, Copy, Debug)]
pub struct Mask8(pub(super) __m256);

/// Bits 0 to 3 of `mask` as the signs of four lanes: SSE has no shift by lane, but a multiplication does.
///
/// # Safety
/// - The processor has SSE4.1.
#[inline(always)]
unsafe fn sign_bits4(mask: u32) -> __m128 {
    // SAFETY: the caller's promise.
    unsafe {
        _mm_castsi128_ps(_mm_mullo_epi32(
            _mm_set1_epi32(mask as i32),
            _mm_setr_epi32(1 << 31, 1 << 30, 1 << 29, 1 << 28),
        ))
    }
}

/// Writes one implementation of [`Vector`] over a single register. Arguments: the type, its array, the intrinsics,
/// how two lanes are compared into bits, how such a comparison selects, and how bits do.
macro_rules! one_register {
    ($vector:ident, $array:ty, $splat:ident, $load:ident, $store:ident, $add:ident, $sub:ident, $mul:ident, $div:ident,
     $sqrt:ident, $min:ident, $max:ident, $andnot:ident, |$a:ident, $b:ident, $op:ident| $compare:expr,
     |$x:ident, $y:ident, $yes:ident, $no:ident| $select:expr,
     |$first:ident, $second:ident, $mask:ident| $by_bits:expr) => {
        impl Vector for $vector {
            type Array = $array;

            #[inline(always)]
            unsafe fn splat(value: f32) -> Self {
                // SAFETY: the caller has the instruction set (rule of the trait).
                unsafe { $vector($splat(value)) }
            }
            #[inline(always)]
            unsafe fn load(from: &Self::Array) -> Self {
                // SAFETY: as in `splat`; the array has as many lanes as the register, and the load needs no alignment.
                unsafe { $vector($load(from.as_ptr())) }
            }
            #[inline(always)]
            unsafe fn store(self, to: &mut Self::Array) {
                // SAFETY: as in `load`.
                unsafe { $store(to.as_mut_ptr(), self.0) }
            }
            #[inline(always)]
            unsafe fn add(self, other: Self) -> Self {
                // SAFETY: as in `splat`.
                unsafe { $vector($add(self.0, other.0)) }
            }
            #[inline(always)]
            unsafe fn sub(self, other: Self) -> Self {
                // SAFETY: as in `splat`.
                unsafe { $vector($sub(self.0, other.0)) }
            }
            #[inline(always)]
            unsafe fn mul(self, other: Self) -> Self {
                // SAFETY: as in `splat`.
                unsafe { $vector($mul(self.0, other.0)) }
            }
            #[inline(always)]
            unsafe fn div(self, other: Self) -> Self {
                // SAFETY: as in `splat`.
                unsafe { $vector($div(self.0, other.0)) }
            }
            #[inline(always)]
            unsafe fn sqrt(self) -> Self {
                // SAFETY: as in `splat`.
                unsafe { $vector($sqrt(self.0)) }
            }
            #[inline(always)]
            unsafe fn abs(self) -> Self {
                // SAFETY: as in `splat`.
                unsafe { $vector($andnot($splat(-0.0), self.0)) }
            }
            #[inline(always)]
            unsafe fn select_le(self, other: Self, yes: Self, no: Self) -> Self {
                let ($x, $y, $yes, $no) = (self.0, other.0, yes.0, no.0);
                // SAFETY: as in `splat`.
                unsafe { $vector($select) }
            }
            #[inline(always)]
            unsafe fn select_bits(self, other: Self, $mask: u32) -> Self {
                let ($first, $second) = (self.0, other.0);
                // SAFETY: as in `splat`.
                unsafe { $vector($by_bits) }
            }
            #[inline(always)]
            unsafe fn min(self, other: Self) -> Self {
                // SAFETY: as in `splat`.
                unsafe { $vector($min(self.0, other.0)) }
            }
            #[inline(always)]
            unsafe fn max(self, other: Self) -> Self {
                // SAFETY: as in `splat`.
                unsafe { $vector($max(self.0, other.0)) }
            }
            #[inline(always)]
            unsafe fn le(self, other: Self) -> u32 {
                const $op: i32 = _CMP_LE_OQ;
                let ($a, $b) = (self.0, other.0);
                // SAFETY: as in `splat`.
                unsafe { $compare }
            }
            #[inline(always)]
            unsafe fn lt(self, other: Self) -> u32 {
                const $op: i32 = _CMP_LT_OQ;
                let ($a, $b) = (self.0, other.0);
                // SAFETY: as in `splat`.
                unsafe { $compare }
            }
        }
    };
}

one_register!(
    Sse4,
    [f32; 4],
    _mm_set1_ps,
    _mm_loadu_ps,
    _mm_storeu_ps,
    _mm_add_ps,
    _mm_sub_ps,
    _mm_mul_ps,
    _mm_div_ps,
    _mm_sqrt_ps,
    _mm_min_ps,
    _mm_max_ps,
    _mm_andnot_ps,
    // SSE has an instruction per comparison; the condition is constant, so one branch is left.
    |a, b, OP| _mm_movemask_ps(if OP == _CMP_LE_OQ { _mm_cmple_ps(a, b) } else { _mm_cmplt_ps(a, b) }) as u32,
    |a, b, yes, no| _mm_blendv_ps(no, yes, _mm_cmple_ps(a, b)),
    |yes, no, mask| _mm_blendv_ps(no, yes, sign_bits4(mask))
);

one_register!(
    Avx8,
    [f32; 8],
    _mm256_set1_ps,
    _mm256_loadu_ps,
    _mm256_storeu_ps,
    _mm256_add_ps,
    _mm256_sub_ps,
    _mm256_mul_ps,
    _mm256_div_ps,
    _mm256_sqrt_ps,
    _mm256_min_ps,
    _mm256_max_ps,
    _mm256_andnot_ps,
    |a, b, OP| _mm256_movemask_ps(_mm256_cmp_ps::<OP>(a, b)) as u32,
    |a, b, yes, no| _mm256_blendv_ps(no, yes, _mm256_cmp_ps::<_CMP_LE_OQ>(a, b)),
    |yes, no, mask| {
        let bits = _mm256_sllv_epi32(_mm256_set1_epi32(mask as i32), _mm256_setr_epi32(31, 30, 29, 28, 27, 26, 25, 24));
        _mm256_blendv_ps(no, yes, _mm256_castsi256_ps(bits))
    }
);

one_register!(
    Mask4,
    [f32; 4],
    _mm_set1_ps,
    _mm_loadu_ps,
    _mm_storeu_ps,
    _mm_add_ps,
    _mm_sub_ps,
    _mm_mul_ps,
    _mm_div_ps,
    _mm_sqrt_ps,
    _mm_min_ps,
    _mm_max_ps,
    _mm_andnot_ps,
    |a, b, OP| u32::from(_mm_cmp_ps_mask::<OP>(a, b)),
    |a, b, yes, no| _mm_mask_blend_ps(_mm_cmp_ps_mask::<_CMP_LE_OQ>(a, b), no, yes),
    |yes, no, mask| _mm_mask_blend_ps(mask as u8, no, yes)
);

one_register!(
    Mask8,
    [f32; 8],
    _mm256_set1_ps,
    _mm256_loadu_ps,
    _mm256_storeu_ps,
    _mm256_add_ps,
    _mm256_sub_ps,
    _mm256_mul_ps,
    _mm256_div_ps,
    _mm256_sqrt_ps,
    _mm256_min_ps,
    _mm256_max_ps,
    _mm256_andnot_ps,
    |a, b, OP| u32::from(_mm256_cmp_ps_mask::<OP>(a, b)),
    |a, b, yes, no| _mm256_mask_blend_ps(_mm256_cmp_ps_mask::<_CMP_LE_OQ>(a, b), no, yes),
    |yes, no, mask| _mm256_mask_blend_ps(mask as u8, no, yes)
);

impl Vector for Sse8 {
    type Array = [f32; 8];

    #[inline(always)]
    unsafe fn splat(value: f32) -> Self {
        // SAFETY: the caller has SSE4.1 (rule of the trait).
        unsafe { Sse8(_mm_set1_ps(value), _mm_set1_ps(value)) }
    }
    #[inline(always)]
    unsafe fn load(from: &[f32; 8]) -> Self {
        // SAFETY: as in `splat`; lanes 0..4 and 4..8 lie inside the array.
        unsafe { Sse8(_mm_loadu_ps(from.as_ptr()), _mm_loadu_ps(from.as_ptr().add(4))) }
    }
    #[inline(always)]
    unsafe fn store(self, to: &mut [f32; 8]) {
        // SAFETY: as in `load`.
        unsafe {
            _mm_storeu_ps(to.as_mut_ptr(), self.0);
            _mm_storeu_ps(to.as_mut_ptr().add(4), self.1);
        }
    }
    #[inline(always)]
    unsafe fn add(self, other: Self) -> Self {
        // SAFETY: as in `splat`.
        unsafe { Sse8(_mm_add_ps(self.0, other.0), _mm_add_ps(self.1, other.1)) }
    }
    #[inline(always)]
    unsafe fn sub(self, other: Self) -> Self {
        // SAFETY: as in `splat`.
        unsafe { Sse8(_mm_sub_ps(self.0, other.0), _mm_sub_ps(self.1, other.1)) }
    }
    #[inline(always)]
    unsafe fn mul(self, other: Self) -> Self {
        // SAFETY: as in `splat`.
        unsafe { Sse8(_mm_mul_ps(self.0, other.0), _mm_mul_ps(self.1, other.1)) }
    }
    #[inline(always)]
    unsafe fn div(self, other: Self) -> Self {
        // SAFETY: as in `splat`.
        unsafe { Sse8(_mm_div_ps(self.0, other.0), _mm_div_ps(self.1, other.1)) }
    }
    #[inline(always)]
    unsafe fn sqrt(self) -> Self {
        // SAFETY: as in `splat`.
        unsafe { Sse8(_mm_sqrt_ps(self.0), _mm_sqrt_ps(self.1)) }
    }
    #[inline(always)]
    unsafe fn abs(self) -> Self {
        // SAFETY: as in `splat`.
        unsafe {
            let sign = _mm_set1_ps(-0.0);
            Sse8(_mm_andnot_ps(sign, self.0), _mm_andnot_ps(sign, self.1))
        }
    }
    #[inline(always)]
    unsafe fn select_le(self, other: Self, yes: Self, no: Self) -> Self {
        // SAFETY: as in `splat`.
        unsafe {
            Sse8(
                _mm_blendv_ps(no.0, yes.0, _mm_cmple_ps(self.0, other.0)),
                _mm_blendv_ps(no.1, yes.1, _mm_cmple_ps(self.1, other.1)),
            )
        }
    }
    #[inline(always)]
    unsafe fn select_bits(self, other: Self, mask: u32) -> Self {
        // SAFETY: as in `splat`.
        unsafe {
            Sse8(
                _mm_blendv_ps(other.0, self.0, sign_bits4(mask)),
                _mm_blendv_ps(other.1, self.1, sign_bits4(mask >> 4)),
            )
        }
    }
    #[inline(always)]
    unsafe fn min(self, other: Self) -> Self {
        // SAFETY: as in `splat`.
        unsafe { Sse8(_mm_min_ps(self.0, other.0), _mm_min_ps(self.1, other.1)) }
    }
    #[inline(always)]
    unsafe fn max(self, other: Self) -> Self {
        // SAFETY: as in `splat`.
        unsafe { Sse8(_mm_max_ps(self.0, other.0), _mm_max_ps(self.1, other.1)) }
    }
    #[inline(always)]
    unsafe fn le(self, other: Self) -> u32 {
        // SAFETY: as in `splat`.
        unsafe {
            let low = _mm_movemask_ps(_mm_cmple_ps(self.0, other.0));
            let high = _mm_movemask_ps(_mm_cmple_ps(self.1, other.1));
            (low | high << 4) as u32
        }
    }
    #[inline(always)]
    unsafe fn lt(self, other: Self) -> u32 {
        // SAFETY: as in `splat`.
        unsafe {
            let low = _mm_movemask_ps(_mm_cmplt_ps(self.0, other.0));
            let high = _mm_movemask_ps(_mm_cmplt_ps(self.1, other.1));
            (low | high << 4) as u32
        }
    }
}
