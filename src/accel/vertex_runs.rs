//! Sets of vertices as runs of consecutive ones.
//!
//! The vertices of a part of a mesh are found by number, one by one, though most of them are neighbours in the mesh as well: modellers and subdivision
//! write them in the order in which they make them. So of a set's numbers, those that follow each other are kept as the number of the first of
//! [`RUN`]. Who wants the box around them loads a run as three vectors of four coordinates. A longer sequence is several runs, the last of which
//! may overlap the one before, as that changes no box. What is in no such sequence stays alone.
//!
//! On bodies made by subdivision, in parts of 1024 triangles, three quarters of the vertices are in runs.

use super::OutOfMemory;
use super::memory::{ask, copied, reserve};
use std::ops::Range;

/// Vertices in a run.
pub(super) const RUN: usize = 4;

/// A set: where the first vertices of its runs, and its single ones, are in a list of many sets.
#[derive(Clone, Debug, Default)]
pub(super) struct VertexSet {
    pub runs: Range<usize>,
    pub rest: Range<usize>,
}

impl VertexSet {
    /// The vertices, some of them more than once.
    pub fn vertices(&self, lists: &[u32]) -> impl Iterator<Item = u32> {
        let runs = lists[self.runs.clone()].iter().flat_map(|&first| first..first + RUN as u32);
        runs.chain(lists[self.rest.clone()].iter().copied())
    }
}

/// A set of numbers in the making: a bit each.
#[derive(Debug, Default)]
pub(super) struct Marks {
    words: Vec<u64>,
    /// Words with bits.
    used: Vec<u32>,
    count: usize,
    runs: Vec<u32>,
    rest: Vec<u32>,
}

impl Marks {
    /// Gets ready for numbers below `count`.
    pub fn prepare(&mut self, count: usize) -> Result<(), OutOfMemory> {
        let words = count.div_ceil(u64::BITS as usize);
        if self.words.len() < words {
            *self = Self { words: reserve(words)?, used: reserve(words)?, ..Self::default() };
            self.words.resize(words, 0);
        }
        Ok(())
    }

    /// Adds numbers.
    pub fn mark(&mut self, numbers: &[u32]) {
        self.count += numbers.len();
        for &number in numbers {
            let word = &mut self.words[(number / u64::BITS) as usize];
            if *word == 0 {
                self.used.push(number / u64::BITS);
            }
            *word |= 1 << (number % u64::BITS);
        }
    }

    /// The firsts of its runs, and its single numbers. It is empty after that.
    pub fn take(&mut self) -> Result<[Vec<u32>; 2], OutOfMemory> {
        self.runs.clear();
        self.rest.clear();
        ask(&mut self.runs, self.count)?;
        ask(&mut self.rest, self.count)?;
        self.count = 0;
        self.used.sort_unstable();
        let mut sequence = 0..0;
        for word in self.used.drain(..) {
            let base = word * u64::BITS;
            let mut bits = std::mem::take(&mut self.words[word as usize]);
            while bits != 0 {
                let zeros = bits.trailing_zeros();
                let ones = (bits >> zeros).trailing_ones();
                let start = base + zeros;
                if start != sequence.end {
                    split(&sequence, &mut self.runs, &mut self.rest);
                    sequence.start = start;
                }
                sequence.end = start + ones;
                bits &= (!0u64).checked_shl(zeros + ones).unwrap_or(0);
            }
        }
        split(&sequence, &mut self.runs, &mut self.rest);
        Ok([copied(&self.runs)?, copied(&self.rest)?])
    }
}

/// Appends the runs of a sequence, or its numbers if it is shorter than one.
fn split(sequence: &Range<u32>, runs: &mut Vec<u32>, rest: &mut Vec<u32>) {
    const RUN: u32 = self::RUN as u32;
    if sequence.len() < RUN as usize {
        rest.extend(sequence.clone());
        return;
    }
    let last = sequence.end - RUN;
    runs.extend((sequence.start..last).step_by(RUN as usize));
    runs.push(last);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::test_meshes::Random;
    use std::collections::BTreeSet;

    #[test]
    fn runs_and_single_numbers_are_the_set_and_nothing_else() {
        let seed = Random::seed(51);
        let mut random = Random::new(seed);
        let mut marks = Marks::default();
        for round in 0..200 {
            let count = 1 + random.below(500);
            marks.prepare(count).expect("memory");
            let mut expected = BTreeSet::new();
            for _ in 0..random.below(20) {
                let first = random.below(count);
                let some: Vec<u32> = (first..(first + random.below(90)).min(count)).map(|v| v as u32).collect();
                marks.mark(&some);
                expected.extend(some);
            }
            let [runs, rest] = marks.take().expect("memory");
            let set = VertexSet { runs: 2..2 + runs.len(), rest: 2 + runs.len()..2 + runs.len() + rest.len() };
            let lists = [&[7, 7], &runs[..], &rest].concat();
            let found: BTreeSet<u32> = set.vertices(&lists).collect();
            assert_eq!(found, expected, "seed {seed}, {round}");
            let singles = &lists[set.rest.clone()];
            let in_sequence = |&&v: &&u32| (v.saturating_sub(3)..=v).any(|f| (f..f + 4).all(|v| expected.contains(&v)));
            assert_eq!(singles.iter().find(in_sequence), None, "seed {seed}, {round}: single, but in a sequence");
            assert!(
                set.runs.len() * RUN + set.rest.len() < 2 * expected.len().max(1),
                "seed {seed}, {round}: too many"
            );
        }
    }
}
