//! Memory of structures: asked for so that a refusal is an error, and used again from build to build.

use super::OutOfMemory;
use crate::memory::{Room, vec_of};
pub(super) use crate::memory::{cloned, copied};
use rayon::prelude::*;

/// A vector with room for `len` elements, or the error.
pub(super) fn reserve<T>(len: usize) -> Result<Vec<T>, OutOfMemory> {
    let mut vec = vec_of(len)?;
    crate::simd::prefer_huge_pages(vec.spare_capacity_mut());
    Ok(vec)
}

/// Makes a vector have room for `len` elements.
pub(super) fn ask<T>(vec: &mut Vec<T>, len: usize) -> Result<(), OutOfMemory> {
    vec.room(len.saturating_sub(vec.len()))
}

/// The same vector if it has room for `len` elements and not for more than twice as many; else another one. A vector that
/// had become too small grows by an eighth more than asked, as it will be asked for about as much again.
pub(super) fn recycled<T>(old: Vec<T>, len: usize) -> Result<Vec<T>, OutOfMemory> {
    const SMALL: usize = 1024;
    let capacity = old.capacity();
    if (len..=SMALL.max(2 * len)).contains(&capacity) {
        return Ok(old);
    }
    drop(old);
    reserve(if capacity == 0 || capacity > len { len } else { len + len / 8 })
}

/// Makes room for `count` more elements. What has become too small grows by an eighth, as it will be asked for more again.
pub(super) fn more<T: Copy>(vec: &mut Vec<T>, count: usize) -> Result<(), OutOfMemory> {
    if vec.capacity() - vec.len() < count {
        let mut larger = reserve(vec.len() + count.max(vec.len() / 8))?;
        larger.extend_from_slice(vec);
        *vec = larger;
    }
    Ok(())
}

/// A vector of `len` elements that will all be written to: old ones of `old`, or copies of `value`.
pub(super) fn filled<T: Copy + Send + Sync>(old: Vec<T>, len: usize, value: T) -> Result<Vec<T>, OutOfMemory> {
    let mut vec = recycled(old, len)?;
    if vec.len() >= len {
        vec.truncate(len);
    } else {
        // In parallel, since this is the first touch of fresh memory.
        (0..len).into_par_iter().with_min_len(4096).map(|_| value).collect_into_vec(&mut vec);
    }
    Ok(vec)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_is_used_again_unless_it_is_far_too_large() {
        let first = filled(Vec::new(), 5000, 7u64).expect("memory");
        assert_eq!((first.len(), first.capacity()), (5000, 5000));
        let place = first.as_ptr();
        let fewer = filled(first, 4000, 0).expect("memory");
        assert_eq!((fewer.len(), fewer.as_ptr()), (4000, place));
        let again = filled(fewer, 5000, 3).expect("memory");
        assert_eq!((again.len(), again.as_ptr()), (5000, place));
        let larger = filled(again, 8000, 0).expect("memory");
        assert_eq!((larger.len(), larger.capacity()), (8000, 9000));
        assert_eq!(filled(larger, 2000, 1).expect("memory").capacity(), 2000);
        assert!(reserve::<u64>(usize::MAX / 16).is_err());
        let mut vec = filled(Vec::new(), 800, 5u8).expect("memory");
        for (count, capacity) in [(0, 800), (1, 900), (100, 900), (300, 1100)] {
            more(&mut vec, count).expect("memory");
            assert_eq!((vec.len(), vec.capacity(), vec[799]), (800, capacity, 5));
        }
        assert!(more(&mut vec, usize::MAX / 2).is_err());
    }
}
