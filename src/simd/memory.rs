//! What large arrays ask of the memory system.

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
