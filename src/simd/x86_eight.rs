//! What only vectors of eight lanes are asked, on x86-64.

use super::Eight;
use super::x86::{Avx8, Mask8, Sse8};
use core::arch::x86_64::*;
use std::mem::MaybeUninit;

/// The lane of the least of eight numbers without sign; the first of equal ones.
///
/// # Safety
/// - The processor has SSE4.1.
#[inline(always)]
unsafe fn lane_of_least(keys: __m128i) -> usize {
    // SAFETY: the caller's promise.
    unsafe { (_mm_cvtsi128_si32(_mm_minpos_epu16(keys)) as u32 >> 16) as usize & 7 }
}

/// The lanes of a mask in order, then lane 0: as number 0, 1, 4, 5, 2, 3, 6, 7, so that unpacking two vectors in this order (which goes by
/// halves of 128 bits) makes words 0 to 3 and 4 to 7.
static PACKED: [[u8; 8]; 256] = {
    let place = [0, 1, 4, 5, 2, 3, 6, 7];
    let mut table = [[0u8; 8]; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut lane, mut next) = (0, 0);
        while lane < 8 {
            if mask >> lane & 1 == 1 {
                table[mask][place[next]] = lane as u8;
                next += 1;
            }
            lane += 1;
        }
        mask += 1;
    }
    table
};

impl Eight for Sse8 {
    #[inline(always)]
    unsafe fn nearest_le(self, limit: Self) -> (u32, usize) {
        // SAFETY: the caller has SSE4.1 (rule of the trait).
        unsafe {
            // As below.
            let (out0, out1) = (_mm_cmpnle_ps(self.0, limit.0), _mm_cmpnle_ps(self.1, limit.1));
            let low = _mm_srli_epi32::<16>(_mm_castps_si128(_mm_or_ps(out0, self.0)));
            let high = _mm_srli_epi32::<16>(_mm_castps_si128(_mm_or_ps(out1, self.1)));
            let out = _mm_movemask_ps(out0) | _mm_movemask_ps(out1) << 4;
            (!out as u32 & 0xff, lane_of_least(_mm_packus_epi32(low, high)))
        }
    }
}

/// The vectors of eight lanes that are one register.
macro_rules! eight {
    ($vector:ident) => {
        impl Eight for $vector {
            #[inline(always)]
            unsafe fn least(self) -> f32 {
                // SAFETY: the caller has the instruction set (rule of the trait).
                unsafe {
                    let four = _mm_min_ps(_mm256_castps256_ps128(self.0), _mm256_extractf128_ps::<1>(self.0));
                    let two = _mm_min_ps(four, _mm_movehl_ps(four, four));
                    _mm_cvtss_f32(_mm_min_ss(two, _mm_movehdup_ps(two)))
                }
            }

            #[inline(always)]
            unsafe fn greatest(self) -> f32 {
                // SAFETY: as above.
                unsafe {
                    let four = _mm_max_ps(_mm256_castps256_ps128(self.0), _mm256_extractf128_ps::<1>(self.0));
                    let two = _mm_max_ps(four, _mm_movehl_ps(four, four));
                    _mm_cvtss_f32(_mm_max_ss(two, _mm_movehdup_ps(two)))
                }
            }

            #[inline(always)]
            unsafe fn nearest_le(self, limit: Self) -> (u32, usize) {
                // SAFETY: as above.
                unsafe {
                    // Of numbers that are not negative, the higher halves sort like the numbers; lanes that are out are above all others.
                    let out = _mm256_cmp_ps::<_CMP_NLE_UQ>(self.0, limit.0);
                    let keys = _mm256_srli_epi32::<16>(_mm256_castps_si256(_mm256_or_ps(out, self.0)));
                    let keys = _mm_packus_epi32(_mm256_castsi256_si128(keys), _mm256_extracti128_si256::<1>(keys));
                    (!_mm256_movemask_ps(out) as u32 & 0xff, lane_of_least(keys))
                }
            }

            #[inline(always)]
            unsafe fn pick(self, which: Self) -> Self {
                // SAFETY: as above.
                unsafe { $vector(_mm256_permutevar8x32_ps(self.0, _mm256_castps_si256(which.0))) }
            }

            #[inline(always)]
            unsafe fn pack_words(self, low: &[u32; 8], mask: u32, to: &mut [MaybeUninit<u64>; 8]) {
                // SAFETY: as above; what is loaded and stored is as long as the tables and arrays.
                unsafe {
                    let order = _mm256_cvtepu8_epi32(_mm_loadl_epi64(PACKED[(mask & 0xff) as usize].as_ptr().cast()));
                    let high = _mm256_permutevar8x32_epi32(_mm256_castps_si256(self.0), order);
                    let low = _mm256_permutevar8x32_epi32(_mm256_loadu_si256(low.as_ptr().cast()), order);
                    let to: *mut __m256i = to.as_mut_ptr().cast();
                    _mm256_storeu_si256(to, _mm256_unpacklo_epi32(low, high));
                    _mm256_storeu_si256(to.add(1), _mm256_unpackhi_epi32(low, high));
                }
            }

            #[inline(always)]
            unsafe fn transpose([a, b, c, d, e, f, g, h]: [Self; 8]) -> [Self; 8] {
                // SAFETY: as above.
                unsafe {
                    // Pairs of rows, then fours, in each half of 128 bits; then the halves.
                    let (ab, ab_high) = (_mm256_unpacklo_ps(a.0, b.0), _mm256_unpackhi_ps(a.0, b.0));
                    let (cd, cd_high) = (_mm256_unpacklo_ps(c.0, d.0), _mm256_unpackhi_ps(c.0, d.0));
                    let (ef, ef_high) = (_mm256_unpacklo_ps(e.0, f.0), _mm256_unpackhi_ps(e.0, f.0));
                    let (gh, gh_high) = (_mm256_unpacklo_ps(g.0, h.0), _mm256_unpackhi_ps(g.0, h.0));
                    const LOW: i32 = 0b01_00_01_00;
                    const HIGH: i32 = 0b11_10_11_10;
                    let front = [
                        _mm256_shuffle_ps::<LOW>(ab, cd),
                        _mm256_shuffle_ps::<HIGH>(ab, cd),
                        _mm256_shuffle_ps::<LOW>(ab_high, cd_high),
                        _mm256_shuffle_ps::<HIGH>(ab_high, cd_high),
                    ];
                    let back = [
                        _mm256_shuffle_ps::<LOW>(ef, gh),
                        _mm256_shuffle_ps::<HIGH>(ef, gh),
                        _mm256_shuffle_ps::<LOW>(ef_high, gh_high),
                        _mm256_shuffle_ps::<HIGH>(ef_high, gh_high),
                    ];
                    [
                        $vector(_mm256_permute2f128_ps::<0x20>(front[0], back[0])),
                        $vector(_mm256_permute2f128_ps::<0x20>(front[1], back[1])),
                        $vector(_mm256_permute2f128_ps::<0x20>(front[2], back[2])),
                        $vector(_mm256_permute2f128_ps::<0x20>(front[3], back[3])),
                        $vector(_mm256_permute2f128_ps::<0x31>(front[0], back[0])),
                        $vector(_mm256_permute2f128_ps::<0x31>(front[1], back[1])),
                        $vector(_mm256_permute2f128_ps::<0x31>(front[2], back[2])),
                        $vector(_mm256_permute2f128_ps::<0x31>(front[3], back[3])),
                    ]
                }
            }
        }
    };
}

eight!(Avx8);
eight!(Mask8);
