//! Memory that is asked for: a refusal is an error, and nothing has changed by then.
//!
//! Rust's containers end the process when they cannot grow. Whatever a caller controls the size of therefore goes through these functions first:
//! room is asked for *before* anything changes, and what follows cannot fail. What lives from frame to frame is kept, so that a frame like the one
//! before asks for nothing.
//!
//! For code that does not ask there is a reserve ([`Allocator`]); while that is in use, asking is an error, so little comes out of it.

mod reserve;
mod segment;

pub use reserve::{Allocator, behind, check, check_enough, is_there};

use std::collections::{HashMap, VecDeque};
use std::hash::{BuildHasher, Hash};

/// The memory for something could not be had.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OutOfMemory {
    /// What was asked for, in bytes.
    pub bytes: usize,
}

impl OutOfMemory {
    /// For `count` elements of a type.
    pub fn of<T>(count: usize) -> Self {
        Self { bytes: count.saturating_mul(size_of::<T>()) }
    }
}

impl std::fmt::Display for OutOfMemory {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "no memory for {} bytes", self.bytes)
    }
}

impl std::error::Error for OutOfMemory {}

/// What can be made larger.
pub trait Room {
    /// Makes room for `count` more elements, and perhaps for others after them.
    ///
    /// # Errors
    /// No memory; nothing has changed.
    fn room(&mut self, count: usize) -> Result<(), OutOfMemory>;
}

impl<T> Room for Vec<T> {
    #[inline]
    fn room(&mut self, count: usize) -> Result<(), OutOfMemory> {
        if self.capacity() - self.len() >= count {
            return Ok(());
        }
        check()?;
        self.try_reserve(count).map_err(|_| OutOfMemory::of::<T>(self.len().saturating_add(count)))
    }
}

impl<T> Room for VecDeque<T> {
    fn room(&mut self, count: usize) -> Result<(), OutOfMemory> {
        if self.capacity() - self.len() >= count {
            return Ok(());
        }
        check()?;
        self.try_reserve(count).map_err(|_| OutOfMemory::of::<T>(self.len().saturating_add(count)))
    }
}

impl<K: Eq + Hash, V, S: BuildHasher> Room for HashMap<K, V, S> {
    fn room(&mut self, count: usize) -> Result<(), OutOfMemory> {
        if self.capacity() - self.len() >= count {
            return Ok(());
        }
        check()?;
        self.try_reserve(count).map_err(|_| OutOfMemory::of::<(K, V)>(self.len().saturating_add(count)))
    }
}

/// An empty vector with room for `len` elements and no more.
///
/// # Errors
/// No memory.
pub fn vec_of<T>(len: usize) -> Result<Vec<T>, OutOfMemory> {
    let mut vec = Vec::new();
    if len == 0 {
        return Ok(vec);
    }
    check()?;
    vec.try_reserve_exact(len).map_err(|_| OutOfMemory::of::<T>(len))?;
    Ok(vec)
}

/// Appends an element.
///
/// # Errors
/// No memory; nothing has changed.
#[inline]
pub fn push<T>(vec: &mut Vec<T>, value: T) -> Result<(), OutOfMemory> {
    vec.room(1)?;
    vec.push(value);
    Ok(())
}

/// `len` times `value`.
///
/// # Errors
/// No memory.
pub fn repeated<T: Clone>(value: T, len: usize) -> Result<Vec<T>, OutOfMemory> {
    let mut vec = vec_of(len)?;
    vec.resize(len, value);
    Ok(vec)
}

/// A copy, no larger than it must be.
///
/// # Errors
/// No memory.
pub fn copied<T: Copy>(elements: &[T]) -> Result<Vec<T>, OutOfMemory> {
    let mut vec = vec_of(elements.len())?;
    vec.extend_from_slice(elements);
    Ok(vec)
}

/// [`copied`], of elements that need [`Clone`]. What their own copies hold is not asked for.
///
/// # Errors
/// No memory.
pub fn cloned<T: Clone>(elements: &[T]) -> Result<Vec<T>, OutOfMemory> {
    let mut vec = vec_of(elements.len())?;
    vec.extend_from_slice(elements);
    Ok(vec)
}

/// Makes a vector a copy of `elements`, in the memory that it has if that is enough.
///
/// # Errors
/// No memory; the vector is empty then.
pub fn copy_into<T: Copy>(vec: &mut Vec<T>, elements: &[T]) -> Result<(), OutOfMemory> {
    vec.clear();
    vec.room(elements.len())?;
    vec.extend_from_slice(elements);
    Ok(())
}

/// What an iterator gives, of which it knows how much at most.
///
/// # Errors
/// No memory.
pub fn collected<T>(elements: impl IntoIterator<Item = T>) -> Result<Vec<T>, OutOfMemory> {
    let elements = elements.into_iter();
    let mut vec = vec_of(elements.size_hint().0)?;
    for element in elements {
        push(&mut vec, element)?;
    }
    Ok(vec)
}

/// What the standard library makes without asking, like an [`Arc`](std::sync::Arc) of a text of `bytes`.
///
/// # Errors
/// No memory.
pub fn made<T>(bytes: usize, make: impl FnOnce() -> T) -> Result<T, OutOfMemory> {
    if bytes < reserve::SMALL / 2 { Ok(make()) } else { behind(bytes.saturating_add(reserve::SMALL), make) }
}

/// A value in a box.
///
/// # Errors
/// No memory; the value is dropped.
pub fn boxed<T>(value: T) -> Result<Box<T>, OutOfMemory> {
    let mut one = vec_of(1)?;
    one.push(value);
    let one = Box::into_raw(one.into_boxed_slice()).cast::<T>();
    // SAFETY: it came from a box, of an array of one, which has the layout of its element.
    Ok(unsafe { Box::from_raw(one) })
}

/// The memory of a vector for another one of elements of the same layout: a list of references into one frame's scene becomes that of the next.
pub fn emptied<A, B>(mut old: Vec<A>) -> Vec<B> {
    const { assert!(size_of::<A>() == size_of::<B>() && align_of::<A>() == align_of::<B>()) };
    old.clear();
    // Collecting what a vector's iterator gives is done in its memory.
    old.into_iter().map(|_| -> B { unreachable!("the vector is empty") }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_had_is_an_error_that_tells_how_much() {
        let most = isize::MAX as usize / 8;
        assert_eq!(vec_of::<u64>(most + 1), Err(OutOfMemory { bytes: 8 * (most + 1) }));
        let mut vec = vec![1u64];
        assert_eq!(vec.room(usize::MAX), Err(OutOfMemory { bytes: usize::MAX }));
        assert_eq!(vec, [1]);
        assert!(HashMap::<u32, u32>::new().room(usize::MAX).is_err());
        assert!(VecDeque::<u32>::new().room(usize::MAX).is_err());
        assert!(repeated(0u8, usize::MAX).is_err());
    }

    #[test]
    fn memory_is_used_again() {
        let mut vec: Vec<u32> = Vec::new();
        copy_into(&mut vec, &[1; 100]).expect("memory");
        let place = vec.as_ptr();
        copy_into(&mut vec, &[2; 50]).expect("memory");
        assert_eq!((vec.len(), vec[0], vec.as_ptr()), (50, 2, place));
        let (text, capacity) = (String::from("short lived"), vec.capacity());
        let mut lent: Vec<Option<&str>> = vec_of(capacity).expect("memory");
        lent.push(Some(&text));
        let place = lent.as_ptr().addr();
        let other: Vec<Option<&'static str>> = emptied(lent);
        assert_eq!((other.len(), other.capacity(), other.as_ptr().addr()), (0, capacity, place));
        assert_eq!(*boxed([7u64; 9]).expect("memory"), [7; 9]);
        assert_eq!(collected((0..10).filter(|i| i % 3 == 0)), Ok(vec![0, 3, 6, 9]));
    }
}
