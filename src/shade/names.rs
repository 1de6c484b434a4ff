//! From names to dense indices, once per frame, so that a hit costs an array access and never a hash.

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
    /// The `i`-th name gets index `i`.
    pub fn new(names: impl Iterator<Item = Name> + Clone) -> Self {
        let limit = 4 * names.clone().count() + 1024;
        let mut table = Self::default();
        for (index, name) in names.enumerate() {
            let slot = name as usize;
            if slot < limit {
                if table.direct.len() <= slot {
                    table.direct.resize(slot + 1, NONE);
                }
                table.direct[slot] = index as u32;
            } else {
                table.sorted.push((name, index as u32));
            }
        }
        table.sorted.sort_unstable();
        table
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
        let table = NameTable::new(names.iter().copied());
        for (index, &name) in names.iter().enumerate() {
            assert_eq!(table.get(name), Some(index as u32));
        }
        for name in [2, 8, 999_999, u32::MAX - 1] {
            assert_eq!(table.get(name), None);
        }
    }
}
