//! A piece of memory that is handed out in runs of granules; a bitmap at its beginning tells which are taken.
//!
//! Whoever gives a block back knows its size, so blocks have no headers. The first run that is long enough is taken: time linear in the size,
//! and no memory beside the bitmap.

use std::alloc::Layout;

/// Every block begins at a multiple of so many bytes.
pub(super) const GRANULE: usize = 64;
const BITS: usize = u64::BITS as usize;

/// See the module head.
pub(super) struct Segment {
    map: *mut u64,
    /// Where the granules begin.
    first: *mut u8,
    granules: usize,
    taken: usize,
}

impl Segment {
    /// # Safety
    /// - `bytes` from `begin` on may be written to and are nobody else's while the segment is used; `begin` is a multiple of [`GRANULE`].
    pub unsafe fn new(begin: *mut u8, bytes: usize) -> Self {
        let words = bytes.div_ceil(GRANULE * BITS);
        let header = (words * size_of::<u64>()).next_multiple_of(GRANULE);
        let granules = bytes.saturating_sub(header) / GRANULE;
        let map = begin.cast::<u64>();
        if granules > 0 {
            // SAFETY: the caller's promise; the map is a part of the memory, and aligned as it is.
            unsafe { map.write_bytes(0, words) };
        }
        Self { map, first: begin.wrapping_add(header), granules, taken: 0 }
    }

    fn map(&mut self) -> &mut [u64] {
        // SAFETY: `new` has written as many words, or more; nobody else refers to them.
        unsafe { std::slice::from_raw_parts_mut(self.map, self.granules.div_ceil(BITS)) }
    }

    /// Addresses of what it hands out.
    pub fn range(&self) -> std::ops::Range<usize> {
        self.first.addr()..self.first.addr() + self.granules * GRANULE
    }

    /// Bytes of it, and how many of them are taken.
    pub fn fill(&self) -> (usize, usize) {
        (self.granules * GRANULE, self.taken * GRANULE)
    }

    /// Where the memory began that it was made of.
    pub fn begin(&self) -> *mut u8 {
        self.map.cast()
    }

    /// A block, or null if none is free.
    pub fn take(&mut self, layout: Layout) -> *mut u8 {
        let count = layout.size().div_ceil(GRANULE).max(1);
        let (first, granules) = (self.first, self.granules);
        let map = self.map();
        let (mut at, mut free) = (0, 0);
        while at < granules {
            if at % BITS == 0 && map[at / BITS] == u64::MAX {
                (at, free) = (at + BITS, 0);
                continue;
            }
            let is_free = map[at / BITS] >> (at % BITS) & 1 == 0;
            let begins_well = free > 0 || first.addr().wrapping_add(at * GRANULE).is_multiple_of(layout.align());
            free = if is_free && begins_well { free + 1 } else { 0 };
            at += 1;
            if free == count {
                let begin = at - count;
                (begin..at).for_each(|granule| map[granule / BITS] |= 1 << (granule % BITS));
                self.taken += count;
                return first.wrapping_add(begin * GRANULE);
            }
        }
        std::ptr::null_mut()
    }

    /// Takes a block back, which [`Segment::take`] gave for the same layout.
    pub fn give(&mut self, block: *mut u8, layout: Layout) {
        let count = layout.size().div_ceil(GRANULE).max(1);
        let begin = (block.addr() - self.first.addr()) / GRANULE;
        let map = self.map();
        (begin..begin + count).for_each(|granule| map[granule / BITS] &= !(1 << (granule % BITS)));
        self.taken -= count;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[repr(align(4096))]
    struct Memory([u8; 8192]);

    #[test]
    fn blocks_are_apart_aligned_and_used_again() {
        let mut memory = Box::new(Memory([0; 8192]));
        // SAFETY: the memory is ours and outlives the segment.
        let mut segment = unsafe { Segment::new(memory.0.as_mut_ptr(), 8192) };
        let (all, none) = segment.fill();
        assert!(all >= 8000 && none == 0, "{all}");
        let layout = |size, align| Layout::from_size_align(size, align).expect("a layout");
        let mut blocks: Vec<(*mut u8, Layout)> = Vec::new();
        for i in 0.. {
            let layout = layout([1, 64, 65, 300][i % 4], [1, 8, 128, 512][i % 4]);
            let block = segment.take(layout);
            if block.is_null() {
                break;
            }
            assert!(block.addr().is_multiple_of(layout.align()) && segment.range().contains(&block.addr()));
            assert!(segment.range().contains(&(block.addr() + layout.size() - 1)));
            let apart = |(other, of): &(*mut u8, Layout)| {
                block.addr() >= other.addr() + of.size() || other.addr() >= block.addr() + layout.size()
            };
            assert!(blocks.iter().all(apart), "two blocks overlap");
            blocks.push((block, layout));
        }
        assert!(blocks.len() > 20 && segment.fill().1 > all / 2);
        let (block, of) = blocks.swap_remove(7);
        segment.give(block, of);
        assert_eq!(segment.take(of), block);
        segment.give(block, of);
        blocks.into_iter().for_each(|(block, layout)| segment.give(block, layout));
        assert_eq!(segment.fill().1, 0);
        assert!(segment.take(layout(all + 1, 1)).is_null());
        assert_eq!(segment.take(layout(all, 1)).addr(), segment.range().start);
    }
}
