//! What large arrays ask of the memory system.

use glam::Vec3;
use std::mem::MaybeUninit;

/// Asks for 2 MiB pages behind an array that will be read all over, such as the nodes of a tree: with pages of 4 KiB
/// most node visits of a large tree also miss the translation cache. To be called on fresh memory, before anything is written.
/// Advice only; without effect on small arrays and on systems other than Linux.
pub fn prefer_huge_pages<T>(fresh: &mut [MaybeUninit<T>]) {
    #[cfg(target_os = "linux")]
    {
        const PAGE: usize = 4096;
        const WORTHWHILE: usize = 4 << 20;
        let bytes = size_of_val(fresh);
        if bytes < WORTHWHILE {
            return;
        }
        let start = fresh.as_mut_ptr() as usize;
        let first = start.next_multiple_of(PAGE);
        let length = (start + bytes - first) & !(PAGE - 1);
        // SAFETY: the range lies inside of the slice, hence in mapped memory of this process, and MADV_HUGEPAGE changes neither
        // its contents nor its protection. A refusal leaves everything as it was.
        unsafe { libc::madvise(first as *mut libc::c_void, length, libc::MADV_HUGEPAGE) };
    }
    #[cfg(not(target_os = "linux"))]
    let _ = fresh;
}

/// The points as one run of coordinates, so that a point can be loaded as four of them.
#[inline(always)]
pub fn components(points: &[Vec3]) -> &[f32] {
    const { assert!(size_of::<Vec3>() == 3 * size_of::<f32>() && align_of::<Vec3>() == align_of::<f32>()) };
    // SAFETY: a `Vec3` is `repr(C)` of three f32, without padding (see above).
    unsafe { std::slice::from_raw_parts(points.as_ptr().cast(), 3 * points.len()) }
}

/// Asks for the cache lines of an element that will be read soon. Indices beyond the end ask for nothing.
#[inline(always)]
pub fn prefetch<T>(slice: &[T], index: usize) {
    if let Some(element) = slice.get(index) {
        prefetch_at(element);
    }
}

/// Likewise of what is at an address, which need not be that of anything.
#[inline(always)]
pub fn prefetch_at<T>(start: *const T) {
    #[cfg(target_arch = "x86_64")]
    {
        use core::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        for line in 0..size_of::<T>().div_ceil(64) {
            // SAFETY: part of SSE, which x86-64 always has; it reads nothing, and faults at no address.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(start.cast::<i8>().wrapping_add(64 * line)) };
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = start;
}
