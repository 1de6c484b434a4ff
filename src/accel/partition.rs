//! Dividing a range of triangles at a split, in place.
//!
//! A short run is divided without branches, as which side a triangle falls on is hard to predict: every triangle is
//! written both to the end of the left side, which never overtakes the reading, and to the end of a scratch list, and one of the two
//! ends moves on. The order within each side stays, so that leaves read the mesh in its own order.
//!
//! A longer range is divided run by run, in parallel if it is long; then the misplaced stretches on either side of the
//! border change places. The outcome depends on the size of the runs, never on threads.

use super::binning::{PARALLEL, Split};
use super::prim_ref::PrimRef;
use crate::simd::{self, Kernel, Level};
use rayon::prelude::*;
use std::ops::Range;

/// Triangles per run: 64 KiB, beside as much of scratch in the second-level cache.
const RUN: usize = 2048;

struct Divide<'a> {
    refs: &'a mut [PrimRef],
    scratch: &'a mut [PrimRef],
    split: &'a Split,
}

impl Kernel for Divide<'_> {
    type Output = usize;

    #[inline(always)]
    fn run(self) -> usize {
        let Self { refs, scratch, split } = self;
        let is_left = split.side();
        let (mut left, mut right) = (0, 0);
        for i in 0..refs.len() {
            let r = refs[i];
            let goes_left = usize::from(is_left(&r));
            refs[left] = r;
            scratch[right] = r;
            left += goes_left;
            right += 1 - goes_left;
        }
        refs[left..].copy_from_slice(&scratch[..right]);
        left
    }
}

/// What [`partition`] needs to work.
pub(super) fn scratch() -> Vec<PrimRef> {
    vec![PrimRef::EMPTY; RUN]
}

/// Puts the triangles of the left side first and returns how many they are. `scratch` comes from [`scratch`].
pub(super) fn partition(level: Level, refs: &mut [PrimRef], scratch: &mut [PrimRef], split: &Split) -> usize {
    if refs.len() <= RUN {
        return simd::run(level, Divide { refs, scratch, split });
    }
    let parallel = refs.len() > PARALLEL;
    let lefts: Vec<usize> = if parallel {
        let runs = refs.par_chunks_mut(RUN).with_min_len(8);
        runs.map_init(self::scratch, |scratch, refs| simd::run(level, Divide { refs, scratch, split })).collect()
    } else {
        refs.chunks_mut(RUN).map(|refs| simd::run(level, Divide { refs, scratch, split })).collect()
    };

    let border = lefts.iter().sum::<usize>();
    let count = refs.len();
    let run_start = |run: usize| (run * RUN).min(count);
    let belong_right =
        lefts.iter().enumerate().map(|(run, left)| run_start(run) + left..run_start(run + 1).min(border));
    let belong_left = lefts.iter().enumerate().map(|(run, left)| run_start(run).max(border)..run_start(run) + left);
    let (left, right) = refs.split_at_mut(border);
    let from_left = stretches(left, 0, belong_right);
    let from_right = stretches(right, border, belong_left);
    let pairs = pair(from_left, from_right);
    if parallel {
        pairs.into_par_iter().for_each(|(a, b)| a.swap_with_slice(b));
    } else {
        pairs.into_iter().for_each(|(a, b)| a.swap_with_slice(b));
    }
    border
}

/// The parts of `refs` (whose first has the position `at`) at ascending positions, without empty ones.
fn stretches(
    mut refs: &mut [PrimRef],
    mut at: usize,
    positions: impl Iterator<Item = Range<usize>>,
) -> Vec<&mut [PrimRef]> {
    let mut found = Vec::new();
    for range in positions.filter(|r| r.start < r.end) {
        let (these, rest) = std::mem::take(&mut refs)[range.start - at..].split_at_mut(range.len());
        found.push(these);
        (refs, at) = (rest, range.end);
    }
    found
}

/// Cuts two lists of the same total length into pairs of equal lengths.
fn pair<'a>(a: Vec<&'a mut [PrimRef]>, b: Vec<&'a mut [PrimRef]>) -> Vec<(&'a mut [PrimRef], &'a mut [PrimRef])> {
    let mut pairs = Vec::with_capacity(a.len() + b.len());
    let (mut a, mut b) = (a.into_iter(), b.into_iter());
    let (mut x, mut y): (&mut [PrimRef], &mut [PrimRef]) = (&mut [], &mut []);
    loop {
        if x.is_empty() {
            let Some(next) = a.next() else { break };
            x = next;
        }
        if y.is_empty() {
            y = b.next().expect("both sides have as many misplaced triangles");
        }
        let length = x.len().min(y.len());
        let (these, rest) = x.split_at_mut(length);
        let (those, remaining) = y.split_at_mut(length);
        pairs.push((these, those));
        (x, y) = (rest, remaining);
    }
    pairs
}
