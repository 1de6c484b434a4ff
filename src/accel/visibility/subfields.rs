//! The subfields of a set of triangles: made when rays ask for them, within a budget of memory, the least recently used given up.
//!
//! *Two sets of directions.* A few coarse ones are made when the first ray asks. Those of a finer subdivision, which rays cross in fewer tiles, are made once enough rays
//! have asked for one of them that it is likely to pay: about as many as it takes to lose the time of making it. Until then, and for good when the budget
//! is spent, a coarse one answers: any subfield is right for any ray.
//!
//! *V and GV* (Khanna04 §3). Each subfield has a stamp, V; all are outdated by adding one to a number, GV ([`OnTouch`]). The paper draws its moving triangles into
//! tiles at once, so that a tile may be of this frame or of an earlier one. Ours waits for a ray and then draws a subfield as a whole, so its
//! tiles are of one age, and one stamp per subfield says it.
//!
//! *Without locks.* The first ray that asks for a subfield makes it, alone. Others that come meanwhile take another one, or make another one, or at worst look at all
//! triangles; nobody waits.

use super::directions::{Directions, MOST_LEVELS};
use super::subfield::{Chosen, Subfield};
use crate::accel::OutOfMemory;
use crate::accel::memory::reserve;
use crate::memory::collected;
use crate::threads::OnTouch;
use glam::Vec3;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, AtomicUsize, Ordering::Relaxed};

/// Bytes that the subfields of a set may hold: this,
const LEAST_BUDGET: usize = 32 << 20;
/// or so much per triangle,
const BUDGET_PER_TRIANGLE: usize = 4096;
/// but not more: a large mesh makes do with coarser directions, or with fewer at a time.
const MOST_BUDGET: usize = 1 << 30;
/// What a subfield is taken to hold per triangle before there is one.
const USUAL_BYTES: usize = 64;
/// Subdivisions of the coarse directions.
const COARSE: usize = 1;
/// A fine subfield is made once this many rays have asked, or one per so many triangles.
const LEAST_WANTED: u32 = 256;
const TRIANGLES_PER_WANT: usize = 256;

/// See the module head.
#[derive(Debug)]
pub(super) struct Subfields {
    coarse: &'static Directions,
    fine: Option<&'static Directions>,
    /// Of the coarse directions, then of the fine ones.
    parts: OnTouch<Subfield, ()>,
    asked: Vec<Asked>,
    ordered: bool,
    budget: usize,
    threshold: u32,
    /// Counts updates.
    now: u32,
    bytes: AtomicUsize,
    /// A ray was refused a subfield for want of memory.
    refused: AtomicBool,
    made: AtomicU32,
    drawn: AtomicU64,
}

/// What rays have asked of a subfield.
#[derive(Debug, Default)]
struct Asked {
    /// At which update last.
    last: AtomicU32,
    /// How often it was not there; for fine ones.
    wanted: AtomicU32,
    /// Bytes and references that it holds.
    bytes: AtomicUsize,
    refs: AtomicUsize,
}

impl Subfields {
    /// No subfields yet, of a set of so many triangles.
    pub fn new(triangles: usize, ordered: bool) -> Result<Self, OutOfMemory> {
        let budget = triangles.saturating_mul(BUDGET_PER_TRIANGLE).clamp(LEAST_BUDGET, MOST_BUDGET);
        let each = triangles.saturating_mul(USUAL_BYTES).max(1);
        let coarse = Directions::of_level(COARSE)?;
        let fits = |level: &usize| Directions::count_on(*level).saturating_mul(each) <= budget / 4 * 3;
        let fine = (COARSE + 1..=MOST_LEVELS).rev().find(|level| ordered && fits(level));
        let fine = fine.map(Directions::of_level).transpose()?;
        let count = coarse.count() + fine.map_or(0, Directions::count);
        let (mut parts, mut asked) = (reserve(count)?, reserve(count)?);
        parts.resize_with(count, Subfield::default);
        asked.resize_with(count, Asked::default);
        let threshold = LEAST_WANTED.max((triangles / TRIANGLES_PER_WANT).min(u32::MAX as usize) as u32);
        Ok(Self {
            coarse,
            fine,
            parts: OnTouch::new(parts, Vec::new(), (0..count).map(|i| (i..i + 1, 0..0)))?,
            asked,
            ordered,
            budget,
            threshold,
            now: 1,
            bytes: AtomicUsize::new(0),
            refused: AtomicBool::new(false),
            made: AtomicU32::new(0),
            drawn: AtomicU64::new(0),
        })
    }

    /// The subfield for a ray in direction `dir`; None if it has to look at all triangles.
    #[inline]
    pub fn find(&self, dir: Vec3, chosen: &Chosen<'_>) -> Option<&Subfield> {
        if let Some(fine) = self.fine {
            let part = self.coarse.count() + fine.nearest(dir);
            if let Some(found) = self.current(part).or_else(|| self.want(part, chosen)) {
                return found.frame().map(|_| found);
            }
        }
        let part = self.coarse.nearest(dir);
        let found = self.current(part).or_else(|| self.another(part, chosen));
        found.filter(|found| found.frame().is_some())
    }

    #[inline(always)]
    fn current(&self, part: usize) -> Option<&Subfield> {
        let (subfield, _) = self.parts.current(part)?;
        let last = &self.asked[part].last;
        // Read first: a store by every ray would send the line from thread to thread.
        if last.load(Relaxed) != self.now {
            last.store(self.now, Relaxed);
        }
        Some(&subfield[0])
    }

    /// Counts a wish for a fine subfield, and fulfils the one that makes it worth while.
    #[cold]
    fn want(&self, part: usize, chosen: &Chosen<'_>) -> Option<&Subfield> {
        let wanted = self.asked[part].wanted.fetch_add(1, Relaxed);
        if wanted < self.threshold {
            return None;
        }
        // What is held already is drawn again in the same memory.
        if self.bytes.load(Relaxed) > self.budget && self.asked[part].bytes.load(Relaxed) == 0 {
            self.refused.store(true, Relaxed);
            return None;
        }
        self.make(part, chosen)
    }

    /// A coarse subfield: this one, or if another thread is making it, any that is there, or else the next that nobody is making.
    #[cold]
    fn another(&self, part: usize, chosen: &Chosen<'_>) -> Option<&Subfield> {
        let count = self.coarse.count();
        let others = || (part..count).chain(0..part);
        let is_there = |part: usize| self.current(part).filter(|found| found.frame().is_some());
        self.make(part, chosen)
            .or_else(|| others().find_map(is_there))
            .or_else(|| others().find_map(|part| self.make(part, chosen)))
    }

    /// Makes a subfield unless another thread is at it. One for which there is no memory has no frame.
    fn make(&self, part: usize, chosen: &Chosen<'_>) -> Option<&Subfield> {
        let count = self.coarse.count();
        let dir = match self.fine {
            Some(fine) if part >= count => fine.lines()[part - count],
            _ => self.coarse.lines()[part],
        };
        self.parts.touch(part, |subfield, _| {
            let subfield = &mut subfield[0];
            if subfield.fill(dir, chosen, self.ordered).is_err() {
                subfield.clear();
            }
            let bytes = subfield.memory_bytes();
            self.bytes.fetch_add(bytes, Relaxed);
            self.bytes.fetch_sub(self.asked[part].bytes.swap(bytes, Relaxed), Relaxed);
            self.asked[part].refs.store(subfield.refs(), Relaxed);
            self.made.fetch_add(1, Relaxed);
            self.drawn.fetch_add(subfield.refs() as u64, Relaxed);
        });
        self.current(part)
    }

    /// The triangles have moved: all subfields are outdated.
    pub fn advance(&mut self) {
        self.parts.advance();
        self.rest();
        for asked in &mut self.asked {
            *asked.wanted.get_mut() = 0;
        }
    }

    /// Makes the subfields again that rays asked for before the last [`Subfields::advance`], by all threads.
    pub fn remake(&self, chosen: &Chosen<'_>) {
        let before = self.now - 1;
        (0..self.asked.len()).into_par_iter().with_max_len(1).for_each(|part| {
            if self.asked[part].last.load(Relaxed) == before {
                self.make(part, chosen);
                self.asked[part].last.store(before, Relaxed);
            }
        });
    }

    /// An update has gone by. Gives up subfields, those first that rays asked for longest ago, if memory ran short.
    pub fn rest(&mut self) {
        let short = std::mem::take(self.refused.get_mut()) || *self.bytes.get_mut() > self.budget;
        if short {
            let mut by_age = collected(0..self.asked.len()).unwrap_or_default();
            by_age.sort_unstable_by_key(|&part| (self.asked[part].last.load(Relaxed), part));
            for part in by_age {
                let old = *self.asked[part].last.get_mut() != self.now;
                if *self.bytes.get_mut() <= self.budget / 2 || !old && *self.bytes.get_mut() <= self.budget {
                    break;
                }
                self.parts.part_mut(part).0[0].clear();
                *self.bytes.get_mut() -= std::mem::take(self.asked[part].bytes.get_mut());
                (*self.asked[part].wanted.get_mut(), *self.asked[part].refs.get_mut()) = (0, 0);
                self.parts.outdate(part);
            }
        }
        self.now += 1;
    }

    /// How many subfields are held, and how many references are in them.
    pub fn held(&self) -> (usize, usize) {
        let refs = self.asked.iter().map(|asked| asked.refs.load(Relaxed)).filter(|&refs| refs > 0);
        refs.fold((0, 0), |held, refs| (held.0 + 1, held.1 + refs))
    }

    /// Subfields drawn since [`Subfields::forget_made`], and references written.
    pub fn made(&self) -> (u32, u64) {
        (self.made.load(Relaxed), self.drawn.load(Relaxed))
    }

    pub fn forget_made(&mut self) {
        (*self.made.get_mut(), *self.drawn.get_mut()) = (0, 0);
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> usize {
        self.bytes.load(Relaxed) + self.parts.memory_bytes() + self.asked.capacity() * size_of::<Asked>()
    }

    /// Checks every subfield that is up to date. Describes the first fault.
    pub fn validate(&self, chosen: &Chosen<'_>) -> Result<(), String> {
        for part in 0..self.parts.len() {
            if let Some((subfield, _)) = self.parts.current(part) {
                subfield[0].validate(chosen).map_err(|fault| format!("subfield {part}: {fault}"))?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::test_meshes::{Random, soup};

    #[test]
    fn memory_stays_in_its_budget_and_goes_to_those_that_rays_ask_for() {
        let mesh = soup(&mut Random::new(Random::seed(73)), 2000, 0.1);
        let corners: Vec<[Vec3; 3]> = (0..2000).map(|prim| mesh.corners(prim)).collect();
        let chosen = Chosen { corners: &corners, listed: None, without: None };
        let mut subfields = Subfields::new(2000, true).expect("memory");
        (subfields.threshold, subfields.budget) = (0, 2 << 20);
        let fine = subfields.fine.expect("so few triangles have room for fine directions");
        let mut largest = 0;
        for update in 0..12 {
            // Forty directions, half of them others after each three updates.
            let dirs: Vec<Vec3> = (0..40).map(|i| fine.lines()[update / 3 * 20 + i]).collect();
            for &dir in &dirs {
                let found = subfields.find(dir, &chosen).expect("a coarse one at least");
                largest = largest.max(found.memory_bytes());
                let held = subfields.bytes.load(Relaxed);
                assert!(held <= subfields.budget + 8 * largest, "{held} bytes");
                let sum: usize = subfields.asked.iter().map(|asked| asked.bytes.load(Relaxed)).sum();
                assert_eq!(held, sum);
            }
            let is_fine = |dir: &&Vec3| subfields.parts.is_current(subfields.coarse.count() + fine.nearest(**dir));
            let served = dirs.iter().filter(is_fine).count();
            // Others had the memory, until the update after the first refusal.
            assert!(served > 5 || update % 3 == 0, "update {update}: {served} of {}", dirs.len());
            subfields.rest();
            assert!(*subfields.bytes.get_mut() <= subfields.budget, "update {update}");
        }
        assert!(largest > 10_000 && subfields.held().0 > 10);
    }

    #[test]
    fn who_comes_while_a_subfield_is_made_gets_another() {
        let mesh = soup(&mut Random::new(Random::seed(74)), 500, 0.1);
        let corners: Vec<[Vec3; 3]> = (0..500).map(|prim| mesh.corners(prim)).collect();
        let chosen = Chosen { corners: &corners, listed: None, without: None };
        let mut subfields = Subfields::new(500, false).expect("memory");
        let dir = subfields.coarse.lines()[2];
        let there = subfields.parts.touch(2, |_, _| {
            let other = subfields.find(dir, &chosen).expect("one that nobody makes");
            assert!(other.refs() >= 500 && subfields.held().0 == 1);
            // The one that is there, not a third.
            assert!(std::ptr::eq(other, subfields.find(dir, &chosen).expect("there")));
        });
        assert!(there.is_some_and(|(subfield, _)| subfield[0].frame().is_none()));
        assert!(subfields.find(dir, &chosen).is_none(), "without memory, all triangles are looked at");
        subfields.advance();
        assert!(subfields.find(dir, &chosen).is_some_and(|subfield| subfield.refs() >= 500));
    }
}
