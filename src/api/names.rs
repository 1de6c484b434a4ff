//! Integer names: handed out in growing order, in runs of any length, and not reused until the range is exhausted.
//!
//! The names in use are kept as disjoint intervals, so that a run of two thousand million names costs one map
//! entry. All operations are logarithmic in the number of intervals.

use crate::scene::Name;
use std::collections::BTreeMap;

/// Names from here on belong to the library itself (implicit camera, immediate-mode geometry).
pub const FIRST_RESERVED: Name = 0xFFFF_FF00;

/// The names of one kind of thing.
#[derive(Debug, Default)]
pub struct Names {
    /// First name of each used run → one past its last. Runs neither overlap nor touch.
    runs: BTreeMap<Name, Name>,
    /// Everything below was handed out once; 0 stands for 1.
    next: Name,
}

impl Names {
    pub fn contains(&self, name: Name) -> bool {
        self.runs.range(..=name).next_back().is_some_and(|(_, &end)| name < end)
    }

    /// Takes `count` ≥ 1 consecutive unused names and returns the first; None when no such run is left.
    pub fn generate(&mut self, count: u32) -> Option<Name> {
        let first = self.find_free(self.next.max(1), count).or_else(|| self.find_free(1, count))?;
        self.take(first, first + count);
        self.next = first + count;
        Some(first)
    }

    /// Takes a name of the caller's choice. False when it is 0 or reserved.
    pub fn claim(&mut self, name: Name) -> bool {
        if name == 0 || name >= FIRST_RESERVED {
            return false;
        }
        if !self.contains(name) {
            self.take(name, name + 1);
        }
        true
    }

    /// Gives back the names `first..end`, as far as they are in use.
    pub fn release(&mut self, first: Name, end: Name) {
        if first >= end {
            return;
        }
        // A run that begins before `first` and reaches into the range keeps its head and perhaps its tail.
        if let Some((_, run_end)) = self.runs.range_mut(..first).next_back() {
            let old_end = *run_end;
            *run_end = old_end.min(first);
            if old_end > end {
                self.runs.insert(end, old_end);
            }
        }
        while let Some((&run, &run_end)) = self.runs.range(first..end).next() {
            self.runs.remove(&run);
            if run_end > end {
                self.runs.insert(end, run_end);
            }
        }
    }

    /// The lowest free run of `count` names at or above `from`.
    fn find_free(&self, from: Name, count: u32) -> Option<Name> {
        let mut start = from;
        if let Some((_, &end)) = self.runs.range(..=start).next_back() {
            start = start.max(end);
        }
        for (&run, &run_end) in self.runs.range(start..) {
            if run - start >= count {
                break;
            }
            start = run_end;
        }
        (FIRST_RESERVED.checked_sub(start)? >= count).then_some(start)
    }

    /// Marks the free names `first..end` as used, merging with the runs on either side.
    fn take(&mut self, first: Name, end: Name) {
        let end = self.runs.remove(&end).unwrap_or(end);
        match self.runs.range_mut(..first).next_back() {
            Some((_, run_end)) if *run_end == first => *run_end = end,
            _ => {
                self.runs.insert(first, end);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_grow_and_come_back_only_after_exhaustion() {
        let mut names = Names::default();
        assert_eq!(names.generate(3), Some(1));
        assert_eq!(names.generate(1), Some(4));
        names.release(2, 4);
        assert!(names.contains(1) && !names.contains(2) && !names.contains(3) && names.contains(4));
        assert_eq!(names.generate(1), Some(5));
        assert_eq!(names.generate(i32::MAX as u32), Some(6));
        let left = FIRST_RESERVED - 6 - i32::MAX as u32;
        assert_eq!(names.generate(left), Some(6 + i32::MAX as u32));
        assert_eq!(names.generate(3), None);
        assert_eq!(names.generate(2), Some(2));
        assert_eq!(names.generate(1), None);
        assert_eq!(names.runs.len(), 1);
    }

    #[test]
    fn claimed_names_are_skipped() {
        let mut names = Names::default();
        assert!(names.claim(3) && names.claim(3));
        assert!(!names.claim(0) && !names.claim(FIRST_RESERVED));
        assert_eq!(names.generate(2), Some(1));
        assert_eq!(names.generate(2), Some(4));
        names.release(1, 100);
        assert!(names.runs.is_empty());
    }

    /// Against a plain table of flags, with small ranges so that runs meet, split and merge.
    #[test]
    fn release_matches_a_table_of_flags() {
        let mut names = Names::default();
        let mut used = [false; 64];
        let mut state = 12345u32;
        let mut random = |below: u32| {
            state = state.wrapping_mul(1664525).wrapping_add(1013904223);
            (state >> 16) % below
        };
        for _ in 0..5000 {
            let first = 1 + random(60);
            if random(2) == 0 {
                names.claim(first);
                used[first as usize] = true;
            } else {
                let end = (first + random(6)).min(64);
                names.release(first, end);
                used[first as usize..end as usize].fill(false);
            }
            for name in 0..64 {
                assert_eq!(names.contains(name), used[name as usize], "name {name}");
            }
            let mut last = 0;
            for (&run, &end) in &names.runs {
                assert!(run < end && (run > last || last == 0), "runs must not touch");
                last = end;
            }
        }
    }
}
