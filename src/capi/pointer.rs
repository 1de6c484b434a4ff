//! Reading what the caller points to. NULL is an error here, not in the functions that use the value.

use super::refusal::{not_negative, null};
use super::texts;
use crate::api::{Error, Result};
use std::ffi::{CStr, c_char};

/// The `N` values at `p`, an argument called v, wherever they lie: C programs do read vertices out of packed structures.
///
/// # Safety
/// `p` is NULL or points to `N` readable values.
#[inline]
pub(super) unsafe fn array<T: Copy, const N: usize>(p: *const T) -> Result<[T; N]> {
    // SAFETY: the caller's promise.
    unsafe { array_at("v", p) }
}

/// As [`array`], of an argument with another name.
///
/// # Safety
/// As [`array`].
#[inline]
pub(super) unsafe fn array_at<T: Copy, const N: usize>(argument: &str, p: *const T) -> Result<[T; N]> {
    if p.is_null() {
        return Err(null(argument));
    }
    // SAFETY: not NULL, so N readable values of T by contract; an array has their layout, and alignment is not asked for.
    Ok(unsafe { p.cast::<[T; N]>().read_unaligned() })
}

/// The value at `p`.
///
/// # Safety
/// `p` is NULL or points to a readable value.
pub(super) unsafe fn value<T: Copy>(argument: &str, p: *const T) -> Result<T> {
    // SAFETY: one value is an array of one.
    unsafe { array_at::<T, 1>(argument, p) }.map(|[v]| v)
}

/// The `n` values at `p`. NULL is accepted when `n` is 0.
///
/// # Safety
/// `p` is NULL or points to `n` readable values (when `n` is positive), which stay unchanged for `'a`.
pub(super) unsafe fn slice<'a, T>(argument: &str, p: *const T, n: i32) -> Result<&'a [T]> {
    let n = count::<T>(argument, p, n)?;
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
pub(super) unsafe fn slice_mut<'a, T>(argument: &str, p: *mut T, n: i32) -> Result<&'a mut [T]> {
    let n = count::<T>(argument, p, n)?;
    if n == 0 {
        return Ok(&mut []);
    }
    // SAFETY: as in `slice`; writable and unaliased by contract.
    Ok(unsafe { std::slice::from_raw_parts_mut(p, n) })
}

fn count<T>(argument: &str, p: *const T, n: i32) -> Result<usize> {
    let n = usize::try_from(n)
        .map_err(|_| Error::invalid_value(format_args!("{argument} holds {n} values; there must be 0 or more")))?;
    if n == 0 {
        return Ok(0);
    }
    if p.is_null() {
        return Err(null(argument));
    }
    if !p.is_aligned() {
        return Err(Error::invalid_value(format_args!("{argument} is {p:p}, which is not aligned for its type")));
    }
    if n.checked_mul(size_of::<T>()).is_none_or(|bytes| bytes > isize::MAX as usize) {
        return Err(Error::invalid_value(format_args!("{argument} holds {n} values, which is larger than memory")));
    }
    Ok(n)
}

/// The `n` arrays of `N` values at `p`, from one to the next `stride` bytes, or none between them for 0. Wherever they lie.
///
/// # Safety
/// `p` is NULL or points to `n` such arrays, readable and unchanged as long as the iterator lives.
pub(super) unsafe fn strided<T: Copy, const N: usize>(
    argument: &str,
    p: *const T,
    n: i32,
    stride: i32,
) -> Result<impl Iterator<Item = [T; N]>> {
    let n = not_negative("n", n)? as usize;
    let packed = size_of::<[T; N]>();
    let stride = match usize::try_from(stride) {
        Ok(0) => packed,
        Ok(stride) if stride >= packed => stride,
        _ => return Err(Error::invalid_value(format_args!("stride is {stride}; it must be 0, or {packed} or more"))),
    };
    if p.is_null() && n > 0 {
        return Err(null(argument));
    }
    // SAFETY: not NULL as there is an element `i` below `n`, which is readable by contract. Alignment is not asked for.
    Ok((0..n).map(move |i| unsafe { p.byte_add(i * stride).cast::<[T; N]>().read_unaligned() }))
}

/// The text at `p`, which must be UTF-8 (ASCII is).
///
/// # Safety
/// `p` is NULL or points to a string that ends in a zero byte and stays unchanged for `'a`.
pub(super) unsafe fn text<'a>(argument: &str, p: *const c_char) -> Result<&'a str> {
    if p.is_null() {
        return Err(null(argument));
    }
    // SAFETY: not NULL, so a terminated string that stays unchanged, by contract.
    let text = unsafe { CStr::from_ptr(p) };
    text.to_str().map_err(|_| Error::invalid_value(format_args!("{argument} is {text:?}, which is not UTF-8")))
}

/// A text that is handed out, for ever.
pub(super) fn answer(text: &str) -> Result<*const c_char> {
    texts::forever(text).map(CStr::as_ptr).ok_or_else(Error::out_of_memory)
}

/// Where one answer goes, and the name of the argument.
pub(super) struct Out<T>(*mut T, &'static str);

impl<T> Out<T> {
    /// # Safety
    /// `p` is NULL or points to a writable `T` until the last use of the value returned.
    pub unsafe fn new(argument: &'static str, p: *mut T) -> Self {
        Self(p, argument)
    }

    /// Fails for NULL: to be asked before the work is done.
    pub fn check(self) -> Result<Self> {
        if self.0.is_null() { Err(null(self.1)) } else { Ok(self) }
    }

    /// Stores the answer, unless the place is NULL.
    pub fn set(&self, value: T) {
        if !self.0.is_null() {
            // SAFETY: not NULL, so writable by the contract of `new`; alignment is not asked for.
            unsafe { self.0.write_unaligned(value) }
        }
    }
}

/// Where several answers go, as many as the question has: the argument params.
pub(super) struct OutArray<T>(*mut T);

impl<T: Copy> OutArray<T> {
    /// # Safety
    /// `p` is NULL or points to as many writable `T` as the longest slice that [`OutArray::set`] is given.
    pub unsafe fn new(p: *mut T) -> Self {
        Self(p)
    }

    pub fn set(&self, values: &[T]) -> Result<()> {
        if self.0.is_null() {
            return Err(null("params"));
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
            assert!(slice::<f32>("x", std::ptr::null(), 1).is_err());
            assert_eq!(slice::<f32>("x", std::ptr::null(), 0).unwrap(), &[] as &[f32]);
            assert!(slice("x", words.as_ptr(), -1).is_err());
            assert_eq!(slice("x", words.as_ptr(), 4).unwrap(), &words);
            let odd = words.as_ptr().cast::<u8>().add(1).cast::<u32>();
            assert!(slice("x", odd, 1).is_err());
            assert_eq!(
                array::<u32, 1>(odd).unwrap(),
                [u32::from_ne_bytes({
                    let b: [u8; 16] = std::mem::transmute(words);
                    [b[1], b[2], b[3], b[4]]
                })]
            );
            assert!(strided::<u32, 2>("x", std::ptr::null(), 1, 0).is_err());
            for (n, stride) in [(-1, 0), (2, 7), (2, -8)] {
                assert!(strided::<u32, 2>("x", words.as_ptr(), n, stride).is_err());
            }
            let pairs = strided::<u32, 1>("x", words.as_ptr(), 2, 8).expect("two words that are eight bytes apart");
            assert_eq!(pairs.collect::<Vec<_>>(), [[1], [3]]);
            assert_eq!(strided::<u32, 2>("x", words.as_ptr(), 2, 0).expect("packed").last(), Some([3, 4]));
            assert!(text("x", std::ptr::null()).is_err());
            assert!(text("x", c"\xff".as_ptr()).is_err());
            assert_eq!(text("x", c"abc".as_ptr()).unwrap(), "abc");
        }
    }
}
