//! Two arrays cut into parts, each of which is brought up to date by the first thread that needs it.
//!
//! A part has a stamp: the period in which it was last written. [`OnTouch::advance`] begins a new period and so makes all parts outdated, by
//! adding one to a number. In a period, any number of threads ask for parts; the first to ask for an outdated one may claim it, and
//! writes it; the others see it when it is finished. Nobody waits: while a part is being written, others are told so and help themselves.
//!
//! ```text
//! outdated --claim (compare and swap)--> being written --(release)--> current --advance()--> outdated
//! ```
//!
//! Why this is sound: a period ends by `&mut self`, so no reference into a part outlives it. Within a period a part is claimed at most once, since no
//! transition leads back to "outdated"; the claimer is the only one with a reference to it then, as shared ones are handed out only when it is current,
//! which is after the claimer's own has ended. The release of the stamp and its acquisition order the writes before the reads. Parts do not overlap
//! (checked on construction). A claimer that panics leaves its part "being written" until the next period.

use crate::memory::{OutOfMemory, collected};
use std::cell::UnsafeCell;
use std::mem::ManuallyDrop;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

/// Where a part lies in the two arrays.
pub type Place = (Range<usize>, Range<usize>);

/// See the module head.
pub struct OnTouch<A, B> {
    first: Vec<UnsafeCell<A>>,
    second: Vec<UnsafeCell<B>>,
    stamps: Vec<Stamp>,
    places: Vec<Place>,
    period: u64,
}

/// What is looked at again and again of a part; apart from the rest, so that those of many parts stay in a cache.
struct Stamp {
    /// Twice the period in which the part was finished, or that plus one where it was claimed.
    period: AtomicU64,
    /// Where it begins in the first array.
    start: usize,
}

// SAFETY: by the module head, `&self` gives a `&mut` to a part to one thread at a time (hence `Send`), and `&` to many (hence `Sync`).
unsafe impl<A: Send + Sync, B: Send + Sync> Sync for OnTouch<A, B> {}

impl<A, B> OnTouch<A, B> {
    /// Takes two arrays and the parts they are cut into, all of which are outdated.
    ///
    /// # Errors
    /// No memory to note them.
    ///
    /// # Panics
    /// When the parts are not ascending, overlap, or reach beyond the arrays.
    pub fn new(first: Vec<A>, second: Vec<B>, places: impl IntoIterator<Item = Place>) -> Result<Self, OutOfMemory> {
        let mut end = (0, 0);
        let places = places.into_iter().map(|(a, b)| {
            assert!(end.0 <= a.start && a.start <= a.end && a.end <= first.len(), "parts of the first array overlap");
            assert!(end.1 <= b.start && b.start <= b.end && b.end <= second.len(), "parts of the second array overlap");
            end = (a.end, b.end);
            (a, b)
        });
        let places: Vec<Place> = collected(places)?;
        let stamp = |(a, _): &Place| Stamp { period: AtomicU64::new(0), start: a.start };
        let stamps = collected(places.iter().map(stamp))?;
        Ok(Self { first: cells(first), second: cells(second), stamps, places, period: 1 })
    }

    /// The number of parts.
    pub fn len(&self) -> usize {
        self.stamps.len()
    }

    /// Whether there are no parts.
    pub fn is_empty(&self) -> bool {
        self.stamps.is_empty()
    }

    /// Makes all parts outdated.
    pub fn advance(&mut self) {
        self.period += 1;
    }

    /// Makes one part outdated.
    ///
    /// # Panics
    /// When there is no such part.
    pub fn outdate(&mut self, part: usize) {
        *self.stamps[part].period.get_mut() = 0;
    }

    /// A part, if it is current.
    ///
    /// # Panics
    /// When there is no such part.
    #[inline(always)]
    pub fn current(&self, part: usize) -> Option<(&[A], &[B])> {
        if !self.is_current(part) {
            return None;
        }
        let place = &self.places[part];
        // SAFETY: the part is current, so nobody has or will get a `&mut` to it before the next `&mut self`.
        Some(unsafe { (self.first_of(place), self.second_of(place)) })
    }

    /// A part, brought up to date by `update` if nobody has done so in this period; None while another thread does. `update` gets what the part
    /// held before.
    ///
    /// # Panics
    /// When there is no such part.
    pub fn touch(&self, number: usize, update: impl FnOnce(&mut [A], &mut [B])) -> Option<(&[A], &[B])> {
        let (stamp, place) = (&self.stamps[number].period, &self.places[number]);
        let (finished, claimed) = (2 * self.period, 2 * self.period + 1);
        let mut seen = stamp.load(Ordering::Acquire);
        while seen != finished {
            if seen == claimed {
                return None;
            }
            // Acquire: what the writer of an earlier period wrote is seen.
            match stamp.compare_exchange_weak(seen, claimed, Ordering::Acquire, Ordering::Acquire) {
                Ok(_) => {
                    {
                        // SAFETY: only one thread per period makes this transition, and no shared reference is handed out
                        // before the stamp says "finished"; those of former periods ended with a `&mut self`.
                        let (first, second) = unsafe { (self.first_mut(place), self.second_mut(place)) };
                        update(first, second);
                    }
                    stamp.store(finished, Ordering::Release);
                    break;
                }
                Err(now) => seen = now,
            }
        }
        self.current(number)
    }

    /// Whether a part is current.
    ///
    /// # Panics
    /// When there is no such part.
    #[inline(always)]
    pub fn is_current(&self, part: usize) -> bool {
        self.stamps[part].period.load(Ordering::Acquire) == 2 * self.period
    }

    /// Where a part begins in the first array, if it is current.
    ///
    /// # Panics
    /// When there is no such part.
    #[inline(always)]
    pub fn start_of_current(&self, part: usize) -> Option<usize> {
        let stamp = &self.stamps[part];
        (stamp.period.load(Ordering::Acquire) == 2 * self.period).then_some(stamp.start)
    }

    /// The beginnings of the arrays, for who has several parts at a time. What is in a part that has been seen to be current may be read as long as `self` is
    /// borrowed; nothing else may.
    #[inline(always)]
    pub fn beginnings(&self) -> (*const A, *const B) {
        (UnsafeCell::raw_get(self.first.as_ptr()), UnsafeCell::raw_get(self.second.as_ptr()))
    }

    /// A part to be changed at will, current or not; its stamp stays what it is.
    ///
    /// # Panics
    /// When there is no such part.
    pub fn part_mut(&mut self, part: usize) -> (&mut [A], &mut [B]) {
        let place = &self.places[part];
        // SAFETY: `&mut self` proves that nobody else has a reference into it.
        unsafe { (self.first_mut(place), self.second_mut(place)) }
    }

    /// Where a part lies in the arrays.
    ///
    /// # Panics
    /// When there is no such part.
    pub fn place(&self, part: usize) -> Place {
        self.places[part].clone()
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> usize {
        self.first.capacity() * size_of::<A>()
            + self.second.capacity() * size_of::<B>()
            + self.stamps.capacity() * size_of::<Stamp>()
            + self.places.capacity() * size_of::<Place>()
    }

    /// The arrays.
    pub fn into_arrays(self) -> (Vec<A>, Vec<B>) {
        (values(self.first), values(self.second))
    }

    /// # Safety
    /// - Nobody has a `&mut` to this part while the reference lives.
    #[inline(always)]
    unsafe fn first_of(&self, place: &Place) -> &[A] {
        // SAFETY: the range was checked on construction; the caller's promise. `UnsafeCell` has the layout of what is in it.
        unsafe { &*(self.first.get_unchecked(place.0.clone()) as *const [UnsafeCell<A>] as *const [A]) }
    }

    /// # Safety
    /// - As [`OnTouch::first_of`].
    #[inline(always)]
    unsafe fn second_of(&self, place: &Place) -> &[B] {
        // SAFETY: as in `first_of`.
        unsafe { &*(self.second.get_unchecked(place.1.clone()) as *const [UnsafeCell<B>] as *const [B]) }
    }

    /// # Safety
    /// - Nobody has any reference to this part while this one lives.
    #[allow(clippy::mut_from_ref, reason = "what the cells are for")]
    unsafe fn first_mut(&self, place: &Place) -> &mut [A] {
        let cells = &self.first[place.0.clone()];
        // SAFETY: the caller's promise. A pointer to `UnsafeCell`s may write to what is in them.
        unsafe { std::slice::from_raw_parts_mut(UnsafeCell::raw_get(cells.as_ptr()), cells.len()) }
    }

    /// # Safety
    /// - As [`OnTouch::first_mut`].
    #[allow(clippy::mut_from_ref, reason = "what the cells are for")]
    unsafe fn second_mut(&self, place: &Place) -> &mut [B] {
        let cells = &self.second[place.1.clone()];
        // SAFETY: as in `first_mut`.
        unsafe { std::slice::from_raw_parts_mut(UnsafeCell::raw_get(cells.as_ptr()), cells.len()) }
    }
}

impl<A, B> std::fmt::Debug for OnTouch<A, B> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let current = (0..self.len()).filter(|&part| self.is_current(part)).count();
        write!(f, "{} of {} parts current", current, self.len())
    }
}

/// The same memory.
fn cells<T>(values: Vec<T>) -> Vec<UnsafeCell<T>> {
    let mut values = ManuallyDrop::new(values);
    let (length, capacity) = (values.len(), values.capacity());
    // SAFETY: `UnsafeCell<T>` is `repr(transparent)`, so the allocation has the right layout; it was ours.
    unsafe { Vec::from_raw_parts(values.as_mut_ptr().cast(), length, capacity) }
}

fn values<T>(cells: Vec<UnsafeCell<T>>) -> Vec<T> {
    let mut cells = ManuallyDrop::new(cells);
    let (length, capacity) = (cells.len(), cells.capacity());
    // SAFETY: as in `cells`.
    unsafe { Vec::from_raw_parts(cells.as_mut_ptr().cast(), length, capacity) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicUsize;

    #[test]
    fn a_part_is_updated_once_per_period_and_seen_whole_by_all_threads() {
        const PARTS: usize = 12;
        let (threads, periods) = if cfg!(miri) { (3, 4) } else { (8, 300) };
        let places = (0..PARTS).map(|i| (10 * i..10 * i + 10, 3 * i..3 * i + 2));
        let mut cells = OnTouch::new(vec![0u64; 10 * PARTS], vec![0u32; 3 * PARTS], places).expect("memory");
        for period in 1..=periods {
            let updates = [const { AtomicUsize::new(0) }; PARTS];
            let busy = AtomicUsize::new(0);
            std::thread::scope(|scope| {
                for thread in 0..threads {
                    let (cells, updates, busy) = (&cells, &updates, &busy);
                    scope.spawn(move || {
                        for step in 0..2 * PARTS {
                            let part = (step * (2 * thread + 1) + thread) % PARTS;
                            let seen = cells.current(part).or_else(|| {
                                cells.touch(part, |a, b| {
                                    updates[part].fetch_add(1, Ordering::Relaxed);
                                    assert!(a.iter().all(|&v| v < period), "from a former period");
                                    a.iter_mut().for_each(|v| *v = period);
                                    b.fill(period as u32);
                                })
                            });
                            let Some((a, b)) = seen else {
                                busy.fetch_add(1, Ordering::Relaxed);
                                continue;
                            };
                            assert_eq!((a.len(), b.len()), (10, 2));
                            assert!(a.iter().all(|&v| v == period) && b.iter().all(|&v| v == period as u32));
                        }
                    });
                }
            });
            assert!(updates.iter().all(|u| u.load(Ordering::Relaxed) <= 1), "claimed twice");
            cells.advance();
            assert!((0..PARTS).all(|part| cells.current(part).is_none()));
        }
        let (_, gaps) = cells.into_arrays();
        assert!(gaps.chunks(3).all(|part| part[2] == 0), "outside of all parts");
    }

    #[test]
    fn who_asks_for_a_part_that_is_being_written_is_told_so() {
        let cells = OnTouch::new(vec![1u8; 4], vec![(); 4], [(0..2, 0..2), (2..4, 2..4)]).expect("memory");
        let seen = cells.touch(0, |a, _| {
            assert!(cells.touch(0, |_, _| unreachable!("claimed already")).is_none());
            assert!(cells.current(0).is_none());
            assert_eq!(cells.touch(1, |a, _| a[1] = 5).map(|(a, _)| a[1]), Some(5));
            a[0] = 7;
        });
        assert_eq!(seen.map(|(a, _)| a), Some(&[7, 1][..]));
        assert_eq!(cells.touch(0, |_, _| unreachable!("current")).map(|(a, _)| a[0]), Some(7));
    }

    #[test]
    fn a_panic_while_writing_leaves_the_part_outdated_until_the_next_period() {
        let mut cells = OnTouch::new(vec![0u8; 1], vec![0u8; 1], [(0..1, 0..1)]).expect("memory");
        let caught = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            cells.touch(0, |_, _| panic!("on purpose"));
        }));
        assert!(caught.is_err() && cells.touch(0, |_, _| ()).is_none());
        cells.advance();
        assert!(cells.touch(0, |_, b| b[0] = 1).is_some());
        cells.part_mut(0).1[0] = 2;
        assert_eq!(cells.current(0).map(|(_, b)| b[0]), Some(2));
    }

    #[test]
    fn one_part_alone_can_be_outdated() {
        let mut cells = OnTouch::new(vec![0u8; 2], vec![(); 2], [(0..1, 0..1), (1..2, 1..2)]).expect("memory");
        assert!(cells.touch(0, |a, _| a[0] = 1).is_some() && cells.touch(1, |a, _| a[0] = 2).is_some());
        cells.outdate(0);
        assert!(cells.current(0).is_none());
        assert_eq!(cells.current(1).map(|(a, _)| a[0]), Some(2));
        assert_eq!(cells.touch(0, |a, _| a[0] += 2).map(|(a, _)| a[0]), Some(3));
    }

    #[test]
    #[should_panic(expected = "parts of the second array overlap")]
    fn parts_that_overlap_are_refused() {
        let _ = OnTouch::new(vec![0; 4], vec![0; 4], [(0..2, 0..3), (2..4, 2..4)]);
    }
}
