//! Which vertices moved lately, so that structures need not look at the others.
//!
//! The log is short: when it has grown to a part of all vertices, or an update moves them all, what is older is forgotten. Who asks for
//! changes since then is told to look at everything.

use crate::memory::{Room, collected, vec_of};
use std::collections::VecDeque;
use std::ops::Range;

/// Updates that are remembered at most: looking through more costs more than it saves.
const MOST_UPDATES: usize = 4096;
/// Vertices that are remembered at most are this part of all.
const PART: usize = 8;

/// The vertices moved by the latest updates, oldest first.
#[derive(Clone, Debug, Default)]
pub struct Moves {
    updates: VecDeque<(u64, Moved)>,
    /// Sum over `updates`.
    vertices: usize,
    /// Nothing is known of this epoch and those before it.
    forgotten: u64,
}

#[derive(Clone, Debug)]
enum Moved {
    Range(Range<u32>),
    Listed(Vec<u32>),
}

impl Moved {
    fn len(&self) -> usize {
        match self {
            Moved::Range(range) => range.len(),
            Moved::Listed(vertices) => vertices.len(),
        }
    }
}

impl Moves {
    /// All vertices moved, or are others.
    pub(super) fn all(&mut self, epoch: u64) {
        *self = Self { forgotten: epoch, ..Self::default() };
    }

    /// Some of `of` vertices moved.
    pub(super) fn range(&mut self, epoch: u64, range: Range<u32>, of: usize) {
        let within = |v: u32| v.min(of as u32);
        self.push(epoch, Moved::Range(within(range.start)..within(range.end)), of);
    }

    /// Likewise.
    pub(super) fn listed(&mut self, epoch: u64, vertices: &[u32], of: usize) {
        if vertices.len() > of / PART {
            self.all(epoch);
        } else {
            match collected(vertices.iter().copied().filter(|&v| (v as usize) < of)) {
                Ok(vertices) => self.push(epoch, Moved::Listed(vertices), of),
                Err(_) => self.all(epoch),
            }
        }
    }

    fn push(&mut self, epoch: u64, moved: Moved, of: usize) {
        if self.updates.room(1).is_err() {
            return self.all(epoch);
        }
        self.vertices += moved.len();
        self.updates.push_back((epoch, moved));
        while self.vertices > of / PART || self.updates.len() > MOST_UPDATES {
            let Some((epoch, oldest)) = self.updates.pop_front() else { break };
            self.vertices -= oldest.len();
            self.forgotten = epoch;
        }
    }

    /// Whether any vertex may have moved after `epoch`, and not some that are known.
    pub fn any_since(&self, epoch: u64) -> bool {
        epoch < self.forgotten
    }

    /// The vertices moved after `epoch`, some of them perhaps more than once; None if that may be any, or without memory for a list.
    pub fn since(&self, epoch: u64) -> Option<Vec<u32>> {
        if self.any_since(epoch) {
            return None;
        }
        let first = self.updates.partition_point(|(at, _)| *at <= epoch);
        let mut vertices = vec_of(self.updates.range(first..).map(|(_, moved)| moved.len()).sum()).ok()?;
        for (_, moved) in self.updates.range(first..) {
            match moved {
                Moved::Range(range) => vertices.extend(range.clone()),
                Moved::Listed(list) => vertices.extend_from_slice(list),
            }
        }
        Some(vertices)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_moved_since_is_known_until_it_is_too_much() {
        let mut moves = Moves::default();
        moves.all(3);
        assert_eq!(moves.since(2), None);
        assert_eq!(moves.since(3), Some(vec![]));
        moves.range(4, 10..13, 1000);
        moves.listed(6, &[500, 7], 1000);
        assert_eq!(moves.since(3), Some(vec![10, 11, 12, 500, 7]));
        assert_eq!(moves.since(4), Some(vec![500, 7]));
        assert_eq!(moves.since(6), Some(vec![]));
        // More than an eighth of all: the oldest go.
        moves.range(7, 0..122, 1000);
        assert_eq!(moves.since(3), None);
        assert_eq!(moves.since(4).map(|v| v.len()), Some(124));
        moves.range(8, 0..126, 1000);
        assert_eq!((moves.since(7), moves.since(8)), (None, Some(vec![])));
        moves.listed(9, &vec![1; 126], 1000);
        assert_eq!(moves.since(8), None);
        for epoch in 10..10 + 2 * MOST_UPDATES as u64 {
            moves.range(epoch, 1..2, 1 << 20);
        }
        assert_eq!(moves.since(9), None);
        assert_eq!(moves.updates.len(), MOST_UPDATES);
    }
}
