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
use crate::memory::{OutOfMemory, Room, push, repeated, vec_of};
use crate::simd::{self, Kernel, Level};
use crate::threads::Desks;
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
#[derive(Debug, Default)]
pub(super) struct Scratch(Vec<PrimRef>);

/// That of every thread.
pub(super) type Scratches = Desks<Scratch>;

/// Makes them ready for [`partition`].
pub(super) fn prepare(scratches: &mut Scratches) -> Result<(), OutOfMemory> {
    scratches.prepare(usize::MAX, Scratch::prepare)
}

impl Scratch {
    pub fn prepare(&mut self) -> Result<(), OutOfMemory> {
        self.0.room(RUN.saturating_sub(self.0.len()))
    }

    pub fn memory_bytes(&self) -> usize {
        self.0.capacity() * size_of::<PrimRef>()
    }

    fn get(&mut self) -> &mut [PrimRef] {
        self.0.resize(RUN, PrimRef::EMPTY);
        &mut self.0
    }
}

/// Where [`partition`] gets it from.
pub(super) enum From<'a> {
    One(&'a mut Scratch),
    Any(&'a Scratches),
}

impl From<'_> {
    fn with<R>(&mut self, work: impl FnOnce(&mut [PrimRef]) -> R) -> R {
        match self {
            From::One(scratch) => work(scratch.get()),
            From::Any(all) => all.at_one(|scratch| work(scratch.get())),
        }
    }
}

/// Puts the triangles of the left side first and returns how many they are. Where scratch comes from one place only, there are so few that
/// one thread divides them.
pub(super) fn partition(
    level: Level,
    refs: &mut [PrimRef],
    scratch: &mut From<'_>,
    split: &Split,
) -> Result<usize, OutOfMemory> {
    let divide = |refs: &mut [PrimRef], scratch: &mut [PrimRef]| simd::run(level, Divide { refs, scratch, split });
    if refs.len() <= RUN {
        return Ok(scratch.with(|scratch| divide(refs, scratch)));
    }
    let mut lefts = repeated(0usize, refs.len().div_ceil(RUN))?;
    let parallel = match scratch {
        From::Any(all) if refs.len() > PARALLEL => {
            let runs = refs.par_chunks_mut(RUN).zip(&mut lefts).with_min_len(8);
            runs.for_each(|(refs, left)| *left = all.at_one(|scratch| divide(refs, scratch.get())));
            true
        }
        _ => {
            for (refs, left) in refs.chunks_mut(RUN).zip(&mut lefts) {
                *left = scratch.with(|scratch| divide(refs, scratch));
            }
            false
        }
    };

    let border = lefts.iter().sum::<usize>();
    let count = refs.len();
    let run_start = |run: usize| (run * RUN).min(count);
    let belong_right =
        lefts.iter().enumerate().map(|(run, left)| run_start(run) + left..run_start(run + 1).min(border));
    let belong_left = lefts.iter().enumerate().map(|(run, left)| run_start(run).max(border)..run_start(run) + left);
    let (left, right) = refs.split_at_mut(border);
    let from_left = stretches(left, 0, belong_right)?;
    let from_right = stretches(right, border, belong_left)?;
    let pairs = pair(from_left, from_right)?;
    if parallel {
        pairs.into_par_iter().for_each(|(a, b)| a.swap_with_slice(b));
    } else {
        pairs.into_iter().for_each(|(a, b)| a.swap_with_slice(b));
    }
    Ok(border)
}

/// The parts of `refs` (whose first has the position `at`) at ascending positions, without empty ones.
fn stretches(
    mut refs: &mut [PrimRef],
    mut at: usize,
    positions: impl Iterator<Item = Range<usize>>,
) -> Result<Vec<&mut [PrimRef]>, OutOfMemory> {
    let mut found = Vec::new();
    for range in positions.filter(|r| r.start < r.end) {
        let (these, rest) = std::mem::take(&mut refs)[range.start - at..].split_at_mut(range.len());
        push(&mut found, these)?;
        (refs, at) = (rest, range.end);
    }
    Ok(found)
}

type Pair<'a> = (&'a mut [PrimRef], &'a mut [PrimRef]);

/// Cuts two lists of the same total length into pairs of equal lengths.
fn pair<'a>(a: Vec<&'a mut [PrimRef]>, b: Vec<&'a mut [PrimRef]>) -> Result<Vec<Pair<'a>>, OutOfMemory> {
    let mut pairs = vec_of(a.len() + b.len())?;
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
    Ok(pairs)
}
