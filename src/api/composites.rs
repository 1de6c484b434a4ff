//! Which objects are parts of which.
//!
//! This mirrors the children that the back-end knows, by name alone, for two questions: whether an object would become a part of itself, and which objects a
//! frame shows. An object deleted while the frame being assembled shows it stays here until that frame has started, as it does in the back-end.

use super::error::Result;
use crate::scene::{Instance, Name, NameMap};
use std::collections::HashSet;

#[derive(Default)]
pub(super) struct Composites {
    /// The parts of each composite, each once.
    parts: NameMap<Vec<Name>>,
    /// Of a walk; empty between two.
    pending: Vec<Name>,
    seen: HashSet<Name>,
}

impl Composites {
    /// The objects among `children`, each once.
    ///
    /// # Errors
    /// No memory.
    pub fn held(children: &[Instance]) -> Result<Vec<Name>> {
        let mut held = Vec::new();
        held.try_reserve_exact(children.len())?;
        held.extend(children.iter().map(|child| child.object));
        held.sort_unstable();
        held.dedup();
        Ok(held)
    }

    /// Room for one more composite.
    ///
    /// # Errors
    /// No memory.
    pub fn reserve(&mut self) -> Result<()> {
        Ok(self.parts.try_reserve(1)?)
    }

    /// Replaces the parts of an object; room was reserved unless there are none.
    pub fn set(&mut self, name: Name, parts: Vec<Name>) {
        if parts.is_empty() {
            self.parts.remove(&name);
        } else {
            self.parts.insert(name, parts);
        }
    }

    /// Whether `part` is `whole`, or a part of it at any depth.
    ///
    /// # Errors
    /// No memory for the search.
    pub fn holds(&mut self, whole: Name, part: Name) -> Result<bool> {
        let mut found = false;
        self.walk(whole, |name| {
            found |= name == part;
            !found
        })?;
        Ok(found)
    }

    /// Calls `enter` with an object and all its parts, each once; with the parts of those only for which it returns true.
    ///
    /// # Errors
    /// No memory for the walk, which then has gone part of the way.
    pub fn walk(&mut self, whole: Name, mut enter: impl FnMut(Name) -> bool) -> Result<()> {
        // Most objects have no parts.
        if !enter(whole) || !self.parts.contains_key(&whole) {
            return Ok(());
        }
        let Self { parts, pending, seen } = self;
        pending.clear();
        seen.clear();
        pending.try_reserve(1)?;
        pending.push(whole);
        while let Some(name) = pending.pop() {
            for &part in parts.get(&name).map_or(&[][..], Vec::as_slice) {
                seen.try_reserve(1)?;
                pending.try_reserve(1)?;
                if seen.insert(part) && enter(part) {
                    pending.push(part);
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_parts_are_parts() {
        let mut composites = Composites::default();
        for (whole, parts) in [(1, vec![2, 3]), (2, vec![4]), (3, vec![4, 5]), (9, vec![1])] {
            composites.set(whole, parts);
        }
        assert!(composites.holds(1, 1).unwrap() && composites.holds(9, 4).unwrap() && composites.holds(7, 7).unwrap());
        assert!(!composites.holds(4, 1).unwrap() && !composites.holds(2, 5).unwrap());
        let mut met = Vec::new();
        composites
            .walk(9, |name| {
                met.push(name);
                name != 2
            })
            .unwrap();
        met.sort_unstable();
        assert_eq!(met, [1, 2, 3, 4, 5, 9]);
        composites.set(3, Vec::new());
        assert!(!composites.holds(9, 5).unwrap());
    }
}
