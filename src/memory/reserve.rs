//! Memory that is put aside for when the system has none left.
//!
//! Rust's containers, rayon, codecs and the standard library end the process when an allocation fails. [`Allocator`], which the C libraries install, is
//! the system's; a *small* block that the system refuses comes out of the reserve. So what cannot ask for memory goes on, and what asks learns of it:
//! while the system is short, [`check`] is an error, and [`Room`](super::Room) and its siblings begin with it. A large block that is refused is refused:
//! who wants one asks. Foreign code that does not is run by [`behind`], with a reserve of its own.
//!
//! The reserve is a part of the program's image, so it is there from the start. When it has been used and the system has memory again, it is
//! made larger instead of waiting for blocks that may live long.
//!
//! Cost where memory is not short: one comparison for each block that is given back.

use super::OutOfMemory;
use super::segment::{GRANULE, Segment};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::{Cell, UnsafeCell};
use std::ptr::null_mut;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicUsize, Ordering};

/// Larger blocks come out of the reserve only for who runs [`behind`] one.
pub const SMALL: usize = 16 << 10;
/// The reserve of the program's image, and by how much it grows.
const PIECE: usize = 512 << 10;
/// What the system must have again for [`check`] to be content.
const PROBE: usize = 64 << 10;
/// Pieces, and reserves of [`behind`] at a time.
const MOST: usize = 16;
/// How many of them may be pieces.
const MOST_PIECES: usize = 4;

/// The system's allocator, with the reserve behind it. The C libraries install it; a Rust program may as well:
///
/// ```
/// #[global_allocator]
/// static ALLOCATOR: openrt::memory::Allocator = openrt::memory::Allocator;
/// # fn main() {}
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Allocator;

/// A block came out of the reserve, and nobody has seen the system have memory since.
static SHORT: AtomicBool = AtomicBool::new(false);
/// Less than half of the reserve is left.
static LOW: AtomicBool = AtomicBool::new(false);
/// Blocks out of the reserve that are in use.
static BLOCKS: AtomicUsize = AtomicUsize::new(0);
/// Where the segments are, for who does not hold the lock. A segment stays while a block of it is in use.
static RANGES: [(AtomicUsize, AtomicUsize); MOST] = [const { (AtomicUsize::new(0), AtomicUsize::new(0)) }; MOST];
/// The process that holds the lock; a forked child takes it from its parent.
static HOLDER: AtomicU32 = AtomicU32::new(0);
static SHELF: Shelf = Shelf(UnsafeCell::new([const { None }; MOST]));
static IMAGE: Image = Image(UnsafeCell::new([0; PIECE]));

thread_local! {
    /// The slot of the reserve that this thread runs behind.
    static BEHIND: Cell<Option<usize>> = const { Cell::new(None) };
}

struct Shelf(UnsafeCell<[Option<Reserve>; MOST]>);

// SAFETY: only who holds the lock looks at it.
unsafe impl Sync for Shelf {}

#[repr(align(4096))]
struct Image(UnsafeCell<[u8; PIECE]>);

// SAFETY: it is the memory of a segment, and never looked at as what it is.
unsafe impl Sync for Image {}

struct Reserve {
    segment: Segment,
    kind: Kind,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// For small blocks of all threads; stays.
    Piece,
    /// Of a thread that runs behind it.
    Lent,
    /// That thread has finished. What it has left in it is still in use.
    Left,
}

type Slots = [Option<Reserve>; MOST];

/// Does something with the segments. Does not allocate, nor panic.
fn locked<R>(work: impl FnOnce(&mut Slots) -> R) -> R {
    let own = std::process::id();
    loop {
        let holder = HOLDER.load(Ordering::Relaxed);
        // A holder in another process is this one's parent, whose threads are not here.
        if holder != own && HOLDER.compare_exchange(holder, own, Ordering::Acquire, Ordering::Relaxed).is_ok() {
            break;
        }
        std::thread::yield_now();
    }
    // SAFETY: the lock is held, and `work` does not come here again.
    let slots = unsafe { &mut *SHELF.0.get() };
    if slots[0].is_none() {
        // SAFETY: the image is nobody else's, and aligned.
        let segment = unsafe { Segment::new(IMAGE.0.get().cast(), PIECE) };
        put(slots, 0, Reserve { segment, kind: Kind::Piece });
    }
    let result = work(slots);
    HOLDER.store(0, Ordering::Release);
    result
}

fn put(slots: &mut Slots, at: usize, reserve: Reserve) {
    let range = reserve.segment.range();
    slots[at] = Some(reserve);
    RANGES[at].0.store(range.start, Ordering::Relaxed);
    RANGES[at].1.store(range.end, Ordering::Release);
}

/// Takes a segment of the system's memory out of its slot, to be freed.
fn remove(slots: &mut Slots, at: usize) -> *mut u8 {
    RANGES[at].1.store(0, Ordering::Relaxed);
    slots[at].take().map_or(null_mut(), |reserve| reserve.segment.begin())
}

/// Whether a block may be of the reserve; if it is, the answer is yes.
#[inline]
fn may_hold(block: *mut u8) -> bool {
    BLOCKS.load(Ordering::Relaxed) != 0 && is_in_range(block.addr())
}

#[cold]
fn is_in_range(address: usize) -> bool {
    let holds = |(begin, end): &(AtomicUsize, AtomicUsize)| {
        let end = end.load(Ordering::Acquire);
        (begin.load(Ordering::Relaxed)..end).contains(&address)
    };
    RANGES.iter().any(holds)
}

/// Bytes that the pieces have, and how many of them are taken.
fn fill(slots: &Slots) -> (usize, usize) {
    let pieces = slots.iter().flatten().filter(|reserve| reserve.kind == Kind::Piece);
    pieces.map(|piece| piece.segment.fill()).fold((0, 0), |sum, fill| (sum.0 + fill.0, sum.1 + fill.1))
}

/// A block out of the reserve, or null.
#[cold]
fn take(layout: Layout) -> *mut u8 {
    let own = BEHIND.try_with(Cell::get).ok().flatten();
    if own.is_none() && layout.size() > SMALL {
        return null_mut();
    }
    let block = locked(|slots| {
        let of = |slot: &mut Option<Reserve>| slot.as_mut().map_or(null_mut(), |one| one.segment.take(layout));
        let mut block = own.map_or(null_mut(), |own| of(&mut slots[own]));
        for slot in slots.iter_mut().filter(|slot| slot.as_ref().is_some_and(|one| one.kind == Kind::Piece)) {
            if block.is_null() {
                block = of(slot);
            }
        }
        let (all, taken) = fill(slots);
        LOW.store(taken > all / 2, Ordering::Relaxed);
        block
    });
    if !block.is_null() {
        BLOCKS.fetch_add(1, Ordering::Relaxed);
        SHORT.store(true, Ordering::Relaxed);
    }
    block
}

/// Takes a block back if it is of the reserve; whether it is.
#[cold]
fn give(block: *mut u8, layout: Layout) -> bool {
    let (held, empty) = locked(|slots| {
        let holds = |slot: &Option<Reserve>| slot.as_ref().is_some_and(|r| r.segment.range().contains(&block.addr()));
        let Some(at) = slots.iter().position(holds) else { return (false, null_mut()) };
        let Some(reserve) = &mut slots[at] else { return (false, null_mut()) };
        reserve.segment.give(block, layout);
        let is_done = reserve.kind == Kind::Left && reserve.segment.fill().1 == 0;
        let empty = if is_done { remove(slots, at) } else { null_mut() };
        let (all, taken) = fill(slots);
        LOW.store(taken > all / 2, Ordering::Relaxed);
        (true, empty)
    });
    if held {
        BLOCKS.fetch_sub(1, Ordering::Relaxed);
    }
    release(empty);
    held
}

/// Of a segment the size does not matter to the system's allocator, but it has to be told one.
const ANY: Layout = match Layout::from_size_align(GRANULE, GRANULE) {
    Ok(layout) => layout,
    Err(_) => panic!("a power of two"),
};

fn release(begin: *mut u8) {
    if !begin.is_null() {
        // SAFETY: it came from the system with this alignment, and its segment is gone.
        unsafe { System.dealloc(begin, ANY) };
    }
}

/// Gets memory of the system for a segment.
fn obtain(bytes: usize) -> *mut u8 {
    match Layout::from_size_align(bytes, GRANULE) {
        // SAFETY: the size is not 0.
        Ok(layout) if bytes > 0 => unsafe { System.alloc(layout) },
        _ => null_mut(),
    }
}

/// An error while the system is short of memory.
///
/// # Errors
/// Something came out of the reserve, and there is still no memory.
#[inline]
pub fn check() -> Result<(), OutOfMemory> {
    if SHORT.load(Ordering::Relaxed) { recover() } else { Ok(()) }
}

/// Whether so much of the reserve is in use that nothing more should begin, as [`check`] says.
///
/// # Errors
/// As [`check`], and most of the reserve is used up.
#[inline]
pub fn check_enough() -> Result<(), OutOfMemory> {
    if LOW.load(Ordering::Relaxed) { recover() } else { Ok(()) }
}

/// Looks whether the system has memory again, and makes up for what is missing.
#[cold]
fn recover() -> Result<(), OutOfMemory> {
    let wanted = if LOW.load(Ordering::Relaxed) { PIECE } else { PROBE };
    let more = obtain(wanted);
    if more.is_null() {
        return Err(OutOfMemory { bytes: wanted });
    }
    let unused = locked(|slots| {
        let free = slots.iter().position(Option::is_none);
        let pieces = slots.iter().flatten().filter(|reserve| reserve.kind == Kind::Piece).count();
        match free {
            Some(at) if wanted == PIECE && pieces < MOST_PIECES => {
                // SAFETY: so much has been obtained, and it is nobody else's.
                let segment = unsafe { Segment::new(more, PIECE) };
                put(slots, at, Reserve { segment, kind: Kind::Piece });
                LOW.store(false, Ordering::Relaxed);
                null_mut()
            }
            _ => more,
        }
    });
    release(unused);
    SHORT.store(false, Ordering::Relaxed);
    Ok(())
}

/// Whether the system has so much memory. It may be gone the next moment.
pub fn is_there(bytes: usize) -> bool {
    let memory = obtain(bytes);
    release(memory);
    !memory.is_null()
}

/// Runs foreign code that does not ask for memory behind a reserve of `bytes`, on this thread. What the system refuses comes out of that, also large
/// blocks. The reserve is got before; so this is where memory can be wanting.
///
/// # Errors
/// No memory for the reserve; `work` was not run.
pub fn behind<R>(bytes: usize, work: impl FnOnce() -> R) -> Result<R, OutOfMemory> {
    let memory = obtain(bytes);
    if memory.is_null() {
        return Err(OutOfMemory { bytes });
    }
    let at = locked(|slots| {
        let at = slots.iter().position(Option::is_none)?;
        // SAFETY: so much has been obtained, and it is nobody else's.
        put(slots, at, Reserve { segment: unsafe { Segment::new(memory, bytes) }, kind: Kind::Lent });
        Some(at)
    });
    let Some(at) = at else {
        release(memory);
        return Err(OutOfMemory { bytes });
    };
    let before = BEHIND.replace(Some(at));
    let _end = End { at, before };
    Ok(work())
}

/// A thread runs behind a reserve.
struct End {
    at: usize,
    before: Option<usize>,
}

impl Drop for End {
    fn drop(&mut self) {
        BEHIND.set(self.before);
        release(locked(|slots| match &mut slots[self.at] {
            Some(reserve) if reserve.segment.fill().1 > 0 => {
                reserve.kind = Kind::Left;
                null_mut()
            }
            _ => remove(slots, self.at),
        }));
    }
}

// SAFETY: blocks are the system's or of a segment, which hands out each once and aligned; nothing here panics or allocates.
unsafe impl GlobalAlloc for Allocator {
    #[inline]
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's promise.
        let block = unsafe { System.alloc(layout) };
        if block.is_null() { take(layout) } else { block }
    }

    #[inline]
    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's promise.
        let block = unsafe { System.alloc_zeroed(layout) };
        if !block.is_null() {
            return block;
        }
        let block = take(layout);
        if !block.is_null() {
            // SAFETY: a block has the size of its layout.
            unsafe { block.write_bytes(0, layout.size()) };
        }
        block
    }

    #[inline]
    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        if !(may_hold(block) && give(block, layout)) {
            // SAFETY: the caller's promise, and it is the system's.
            unsafe { System.dealloc(block, layout) };
        }
    }

    #[inline]
    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        if !may_hold(block) {
            // SAFETY: the caller's promise.
            let moved = unsafe { System.realloc(block, layout, size) };
            if !moved.is_null() {
                return moved;
            }
        }
        // SAFETY: the caller's promise; where the system has refused, the block is still there.
        unsafe { self.move_block(block, layout, size) }
    }
}

impl Allocator {
    /// # Safety
    /// - As [`GlobalAlloc::realloc`].
    #[cold]
    unsafe fn move_block(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: the caller's promise.
        let moved = unsafe { self.alloc(Layout::from_size_align_unchecked(size, layout.align())) };
        if !moved.is_null() {
            // SAFETY: both are so large, and apart.
            unsafe { moved.copy_from_nonoverlapping(block, layout.size().min(size)) };
            // SAFETY: the caller's promise; it is not used any more.
            unsafe { self.dealloc(block, layout) };
        }
        moved
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layout(size: usize) -> Layout {
        Layout::from_size_align(size, 8).expect("a layout")
    }

    fn slot_of(block: *mut u8) -> Option<usize> {
        RANGES.iter().position(|(begin, end)| {
            (begin.load(Ordering::Relaxed)..end.load(Ordering::Relaxed)).contains(&block.addr())
        })
    }

    // One test, as all of it is about what there is one of.
    #[test]
    fn what_the_system_refuses_comes_out_of_the_reserve() {
        let block = take(layout(100));
        assert!(!block.is_null() && may_hold(block));
        // SAFETY: the block is so large.
        unsafe { block.write_bytes(7, 100) };
        assert_eq!(check(), Ok(()), "the system has memory");
        // SAFETY: it was allocated with this layout.
        let moved = unsafe { Allocator.realloc(block, layout(100), 5000) };
        assert!(!may_hold(moved) || slot_of(moved).is_none(), "the system's now");
        // SAFETY: so much has been written.
        assert_eq!(unsafe { std::slice::from_raw_parts(moved, 100) }, [7; 100]);
        // SAFETY: as above.
        unsafe { Allocator.dealloc(moved, layout(5000)) };

        assert!(take(layout(SMALL + 1)).is_null(), "large blocks are asked for");
        let mut blocks = Vec::with_capacity(PIECE / SMALL);
        while blocks.len() < PIECE / SMALL / 2 + 1 {
            blocks.push(take(layout(SMALL)));
        }
        assert!(blocks.iter().all(|block| !block.is_null()));
        assert_eq!(check_enough(), Ok(()));
        assert!(locked(|slots| fill(slots)).0 > PIECE, "more than half was taken, so it has become larger");
        blocks.iter().for_each(|&block| assert!(give(block, layout(SMALL))));
        assert!(!give(blocks.as_mut_ptr().cast(), layout(8)), "not of the reserve");

        let large = behind(1 << 20, || {
            let large = take(layout(SMALL + 1));
            let other = take(layout(1 << 19));
            assert!(give(other, layout(1 << 19)));
            large
        });
        let large = large.expect("memory");
        let slot = slot_of(large).expect("of a reserve that has outlived its user");
        assert!(take(layout(SMALL + 1)).is_null());
        assert!(give(large, layout(SMALL + 1)));
        let is_left = locked(|slots| slots[slot].as_ref().is_some_and(|reserve| reserve.kind == Kind::Left));
        assert!(!is_left, "nobody needs it any more");
        assert_eq!(behind(1 << 62, || unreachable!("there is no such reserve")), Err(OutOfMemory { bytes: 1 << 62 }));
        assert!(is_there(1000) && !is_there(1 << 62));
    }
}
