//! Reading what the caller points to. NULL is an error here, not in the functions that use the value.

use crate::api::{Error, Result};
use std::ffi::{CStr, c_char};

fn null() -> Error {
    Error::invalid_value("a pointer is NULL")
}

/// The `N` values at `p`, wherever they lie: C programs do read vertices out of packed structures.
///
/// # Safety
/// `p` is NULL or points to `N` readable values.
#[inline]
pub(super) unsafe fn array<T: Copy, const N: usize>(p: *const T) -> Result<[T; N]> {
    if p.is_null() {
        return Err(null());
    }
    // SAFETY: not NULL, so N readable values of T by contract; an array has their layout, and alignment is not asked for.
    Ok(unsafe { p.cast::<[T; N]>().read_unaligned() })
}

/// The value at `p`.
///
/// # Safety
/// `p` is NULL or points to a readable value.
pub(super) unsafe fn value<T: Copy>(p: *const T) -> Result<T> {
    // SAFETY: one value is an array of one.
    unsafe { array::<T, 1>(p) }.map(|[v]| v)
}

/// The `n` values at `p`. NULL is accepted when `n` is 0.
///
/// # Safety
/// `p` is NULL or points to `n` readable values (when `n` is positive), which stay unchanged for `'a`.
pub(super) unsafe fn slice<'a, T>(p: *const T, n: i32) -> Result<&'a [T]> {
    let n = count::<T>(p, n)?;
    if n == 0 {
        return Ok(&[]);
    }
    // SAFETY: `count` refused NULL and misaligned pointers and sizes above isize::MAX; readable and unchanged by contract.
    Ok(unsafe { std::slice::from_raw_parts(p, n) })
}

/// As [`slice`], to be written.
///
/// # Safety
/// As [`slice`], and writable, with no other reference for `'a`. The values are initialised.
pub(super) unsafe fn slice_mut<'a, T>(p: *mut T, n: i32) -> Result<&'a mut [T]> {
    let n = count::<T>(p, n)?;
    if n == 0 {
        return Ok(&mut []);
    }
    // SAFETY: as in `slice`; writable and unaliased by contract.
    Ok(unsafe { std::slice::from_raw_parts_mut(p, n) })
}

fn count<T>(p: *const T, n: i32) -> Result<usize> {
    let n = usize::try_from(n).map_err(|_| Error::invalid_value("a count is negative"))?;
    if n == 0 {
        return Ok(0);
    }
    if p.is_null() {
        return Err(null());
    }
    if !p.is_aligned() {
        return Err(Error::invalid_value("a pointer is not aligned for its type"));
    }
    if n.checked_mul(size_of::<T>()).is_none_or(|bytes| bytes > isize::MAX as usize) {
        return Err(Error::invalid_value("a count is larger than memory"));
    }
    Ok(n)
}

/// The text at `p`, which must be UTF-8 (ASCII is).
///
/// # Safety
/// `p` is NULL or points to a string that ends in a zero byte and stays unchanged for `'a`.
pub(super) unsafe fn text<'a>(p: *const c_char) -> Result<&'a str> {
    if p.is_null() {
        return Err(null());
    }
    // SAFETY: not NULL, so a terminated string that stays unchanged, by contract.
    let text = unsafe { CStr::from_ptr(p) };
    text.to_str().map_err(|_| Error::invalid_value("a string is not UTF-8"))
}

/// Where one answer goes.
pub(super) struct Out<T>(*mut T);

impl<T> Out<T> {
    /// # Safety
    /// `p` is NULL or points to a writable `T` until the last use of the value returned.
    pub unsafe fn new(p: *mut T) -> Self {
        Self(p)
    }

    /// Fails for NULL: to be asked before the work is done.
    pub fn check(self) -> Result<Self> {
        if self.0.is_null() { Err(null()) } else { Ok(self) }
    }

    /// Stores the answer, unless the place is NULL.
    pub fn set(&self, value: T) {
        if !self.0.is_null() {
            // SAFETY: not NULL, so writable by the contract of `new`; alignment is not asked for.
            unsafe { self.0.write_unaligned(value) }
        }
    }
}

/// Where several answers go, as many as the question has.
pub(super) struct OutArray<T>(*mut T);

impl<T: Copy> OutArray<T> {
    /// # Safety
    /// `p` is NULL or points to as many writable `T` as the longest slice that [`OutArray::set`] is given.
    pub unsafe fn new(p: *mut T) -> Self {
        Self(p)
    }

    pub fn set(&self, values: &[T]) -> Result<()> {
        if self.0.is_null() {
            return Err(null());
        }
        for (i, &v) in values.iter().enumerate() {
            // SAFETY: not NULL, so `values.len()` places are writable by the contract of `new`.
            unsafe { self.0.add(i).write_unaligned(v) }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn null_negative_and_misaligned_are_refused() {
        let words = [1u32, 2, 3, 4];
        // SAFETY: NULL, or pointers into `words` with counts inside it.
        unsafe {
            assert!(array::<f32, 3>(std::ptr::null()).is_err());
            assert!(slice::<f32>(std::ptr::null(), 1).is_err());
            assert_eq!(slice::<f32>(std::ptr::null(), 0).unwrap(), &[] as &[f32]);
            assert!(slice(words.as_ptr(), -1).is_err());
            assert_eq!(slice(words.as_ptr(), 4).unwrap(), &words);
            let odd = words.as_ptr().cast::<u8>().add(1).cast::<u32>();
            assert!(slice(odd, 1).is_err());
            assert_eq!(
                array::<u32, 1>(odd).unwrap(),
                [u32::from_ne_bytes({
                    let b: [u8; 16] = std::mem::transmute(words);
                    [b[1], b[2], b[3], b[4]]
                })]
            );
            assert!(text(std::ptr::null()).is_err());
            assert!(text(c"\xff".as_ptr()).is_err());
            assert_eq!(text(c"abc".as_ptr()).unwrap(), "abc");
        }
    }
}
