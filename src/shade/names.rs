//! From names to dense indices, once per frame, so that a hit costs an array access and never a hash.

use crate::memory::{OutOfMemory, Room};
use crate::scene::Name;

/// Maps names to indices. Names come from counters and are dense as a rule: then this is a plain array. An
/// application may also choose wild names; those are found by binary search.
#[derive(Default)]
pub struct NameTable {
    /// Index of each small name, [`NONE`] where there is none.
    direct: Vec<u32>,
    /// All (name, index) pairs beyond the array, by name.
    sorted: Vec<(Name, u32)>,
}

const NONE: u32 = u32::MAX;

impl NameTable {
    /// Gives the `i`-th name index `i`, in the memory of what was known before.
    ///
    /// # Errors
    /// No memory; the table is empty then.
    pub fn rebuild(&mut self, names: impl Iterator<Item = Name> + Clone) -> Result<(), OutOfMemory> {
        self.direct.clear();
        self.sorted.clear();
        let limit = 4 * names.clone().count() + 1024;
        let is_direct = |name: &Name| (*name as usize) < limit;
        let end = names.clone().filter(is_direct).max().map_or(0, |name| name as usize + 1);
        self.direct.room(end)?;
        self.sorted.room(names.clone().filter(|name| !is_direct(name)).count())?;
        self.direct.resize(end, NONE);
        for (index, name) in (0..).zip(names) {
            match self.direct.get_mut(name as usize) {
                Some(slot) => *slot = index,
                None => self.sorted.push((name, index)),
            }
        }
        self.sorted.sort_unstable();
        Ok(())
    }

    #[inline]
    pub fn get(&self, name: Name) -> Option<u32> {
        match self.direct.get(name as usize) {
            Some(&NONE) => None,
            Some(&index) => Some(index),
            None => {
                let at = self.sorted.binary_search_by_key(&name, |entry| entry.0).ok()?;
                Some(self.sorted[at].1)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_and_wild_names_are_found() {
        let names = [7, 1, u32::MAX, 1_000_000, 0];
        let mut table = NameTable::default();
        table.rebuild([3, 2, 9_000_000].into_iter()).expect("memory");
        table.rebuild(names.iter().copied()).expect("memory");
        for (index, &name) in names.iter().enumerate() {
            assert_eq!(table.get(name), Some(index as u32));
        }
        for name in [2, 3, 8, 999_999, 9_000_000, u32::MAX - 1] {
            assert_eq!(table.get(name), None);
        }
    }
}
