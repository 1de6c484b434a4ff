//! When `RT_AUTO` leaves the update of large objects to the rays.
//!
//! A tree that rays bring up to date ([`super::lazy`]) saves what no ray reaches, and rays pay for it: they gather corners. What that costs
//! depends on how many rays there are, so it takes the clock to tell. Two times are known: what refits of so many triangles took, and what the rays of the last frame took
//! altogether (whoever traces says so, [`super::TwoLevel::add_traced`]). How much of the latter was spent in objects that move is not known, so it is taken to be all of it:
//!
//! ```text
//! saved  = refits of all that moves - updates by rays of what they reach
//! lost   = SLOWER · time of rays
//! ```
//!
//! Where more is saved than lost, it is right whatever the rays did; where not, no more than `lost`, a seventh of a frame, can have been missed. So a wrong guess is
//! cheap, and the rule needs no trial: it begins with the first move. As long as no refit has been timed, it is taken from the time of the build.
//!
//! To begin costs five to six refits once (the tree is cut, not built: 90 ns per triangle beside other work, a third of it for memory touched first and given back, two fifths for numbering corners); to end costs a build. So it begins at once if it surely pays, and ends when
//! what has been lost since it last paid would have bought the build, which at worst doubles the loss (the rule of those who rent skis).
//!
//! *Measured* (`peers -- dynamic --strategy lazy,rotate`, 19 frames, one thread, update and trace): nine bodies 1.04 times what it takes to leave them to rays from
//! the first frame on, 0.92 of rotations; crowd 1.06 of the former. Over 6 and 3 frames the cut is not earned back: 1.23 and 1.42 times the best in one run.
//! Not to begin there would be no better: bodies that are refit with rotations take 1.15 to 1.2 times the best, however many frames follow.
//!
//! The decision is one for all objects that rays met and that have moved as a whole. Each leaves again on its own if it wears ([`ByRays`]): nothing is sorted in such a
//! tree. Of all that can be looked at only what rays had updated is, an eighth of it per frame, and the top.

use super::lazy::LazyBvh;
use super::rotate::half_areas;

/// Fewer triangles are not worth it.
pub(super) const LARGE: u64 = 8192;
/// By how much longer rays need: a twelfth where they are many and stay together, a fifth where they are few (see [`super::lazy`]).
const SLOWER: f64 = 0.15;
/// What is saved has to be so many times what is lost at most, to begin.
const SURE: f64 = 1.25;
/// Of the time of a refit: the boxes before the first ray, an update by rays, building fast.
const BOXES: f64 = 0.06;
const TOUCH: f64 = 0.5;
const FAST_BUILD: f64 = 4.0;
/// A build with care takes so many times as long as a refit.
const SAH_BUILD: f64 = 16.0;
/// By so much the time of refits may grow from update to update.
const LONGER: f64 = 1.25;
/// What rays reach of a tree, while that is not known.
const LIKELY: f64 = 0.5;

/// Triangles of objects that have moved as a whole, that rays met, and that are large.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Stakes {
    pub moved: f64,
    /// Of these, how many rays reached or are likely to reach, by subtrees.
    pub reached: f64,
}

impl Stakes {
    /// `part`: how much of the object was reached, if it is known.
    pub fn add(&mut self, triangles: u64, part: Option<f64>) {
        self.moved += triangles as f64;
        self.reached += triangles as f64 * part.unwrap_or(LIKELY);
    }
}

/// What was done for large objects: how many triangles, and how long all threads were at it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Done {
    pub triangles: f64,
    pub seconds: f64,
}

/// The work of an update, of which `seconds` passed on the wall.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Ledger {
    pub refits: Done,
    pub builds: Done,
    /// Of all threads for anything.
    pub all: f64,
}

/// See the module head.
#[derive(Debug, Default)]
pub(super) struct Balance {
    /// Seconds per triangle.
    refit: Option<f64>,
    by_rays: bool,
    /// Lost since it last paid, in seconds.
    debt: f64,
}

impl Balance {
    /// Learns from an update that took `wall` seconds.
    pub fn learn(&mut self, ledger: &Ledger, wall: f64) {
        // Threads work for each other, so what each object took is known as a share only.
        let per_triangle = |done: &Done| {
            let known = done.triangles >= LARGE as f64 && done.seconds > 0.0;
            known.then(|| wall * done.seconds / ledger.all / done.triangles)
        };
        if let Some(now) = per_triangle(&ledger.refits) {
            // What disturbs a measurement makes it longer, so a shorter one is believed at once.
            self.refit = Some(self.refit.map_or(now, |before| now.min(before * LONGER)));
        } else if let (None, Some(build)) = (self.refit, per_triangle(&ledger.builds)) {
            self.refit = Some(build / SAH_BUILD);
        }
    }

    /// Seconds that building fast takes per triangle.
    pub fn fast_build(&self) -> Option<f64> {
        self.refit.map(|refit| refit * FAST_BUILD)
    }

    /// Whether to leave objects to rays in this frame. In the last one, rays took `traced` seconds.
    pub fn decide(&mut self, traced: f64, stakes: &Stakes) -> bool {
        let Some(refit) = self.refit.filter(|_| traced > 0.0 && stakes.moved > 0.0) else { return self.by_rays };
        let touch = TOUCH * refit * stakes.reached;
        let saved = (1.0 - BOXES) * refit * stakes.moved - touch;
        if self.by_rays {
            let lost = (traced - touch).max(0.0) * (SLOWER / (1.0 + SLOWER));
            self.debt = (self.debt + lost - saved).max(0.0);
            if self.debt > FAST_BUILD * refit * stakes.moved {
                (self.by_rays, self.debt) = (false, 0.0);
            }
        } else {
            self.by_rays = saved > SURE * SLOWER * traced;
        }
        self.by_rays
    }
}

/// So many segments are looked at in turns.
const TURNS: usize = 8;
/// Moves before a tree that wore is left to rays again, twice as many each time.
const SHY: u32 = 8;
const MOST_WORN: u32 = 6;

/// How an object fares whose tree is left to rays.
#[derive(Debug, Default)]
pub(super) struct ByRays {
    /// Per segment: the areas of its lanes when they were first seen, 0 before, as parts of the root's.
    was: Vec<f32>,
    turn: usize,
    worn: u32,
    pause: u32,
}

impl ByRays {
    /// There is a tree now.
    pub fn begin(&mut self) {
        self.was.clear();
    }

    /// Whether the object may be left to rays. Asked once per move.
    pub fn may(&mut self) -> bool {
        self.pause = self.pause.saturating_sub(1);
        self.pause == 0
    }

    /// The tree was worn, or had to be sorted, which rays do not do.
    pub fn wore(&mut self) {
        self.pause = SHY << self.worn;
        self.worn = (self.worn + 1).min(MOST_WORN);
    }

    /// By how much what rays have seen costs more than when they saw it first.
    pub fn wear(&mut self, lazy: &LazyBvh) -> f64 {
        let root = lazy.bounds().half_area();
        if self.was.try_reserve(lazy.segments().saturating_sub(self.was.len())).is_err() {
            // Not looked at, so not worn as far as anyone knows.
            return 1.0;
        }
        self.was.resize(lazy.segments(), 0.0);
        self.turn = (self.turn + 1) % TURNS;
        if root.is_nan() || root <= 0.0 {
            return 1.0;
        }
        let (mut before, mut after) = (0.0, 0.0);
        for (number, was) in self.was.iter_mut().enumerate() {
            if number > 0 && number % TURNS != self.turn && *was > 0.0 {
                continue;
            }
            let Some(part) = lazy.current(number) else { continue };
            let mut sum = 0.0;
            for node in part.nodes {
                sum += half_areas(&node.bounds).iter().sum::<f32>();
            }
            let now = sum / root;
            if *was > 0.0 {
                before += f64::from(*was);
                after += f64::from(now);
            } else {
                // The first time.
                *was = now;
            }
        }
        if before > 0.0 { after / before } else { 1.0 }
    }

    pub fn memory_bytes(&self) -> usize {
        self.was.capacity() * size_of::<f32>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A frame in which refits of a million triangles took 20 ms.
    fn balance() -> Balance {
        let mut balance = Balance::default();
        let refits = Done { triangles: 1e6, seconds: 0.030 };
        balance.learn(&Ledger { refits, all: 0.060, ..Ledger::default() }, 0.040);
        balance
    }

    fn stakes(part: Option<f64>) -> Stakes {
        let mut stakes = Stakes::default();
        stakes.add(1_000_000, part);
        stakes
    }

    #[test]
    fn objects_are_left_to_rays_where_rays_are_few() {
        // 20 ms saved less 1.2 for boxes and 5 for the half that is seen, against a seventh of 40 ms and of 160 ms.
        assert!(balance().decide(0.040, &stakes(None)));
        assert!(!balance().decide(0.160, &stakes(None)));
        assert!(!balance().decide(0.0, &stakes(None)), "without the time of rays nothing is known");
        assert!(!Balance::default().decide(0.040, &stakes(None)), "nor without that of refits");
        assert!(!balance().decide(0.040, &Stakes::default()), "nothing has moved");
    }

    #[test]
    fn before_the_first_refit_the_build_tells() {
        let mut balance = Balance::default();
        let builds = Done { triangles: 1e6, seconds: 0.320 };
        balance.learn(&Ledger { builds, all: 0.320, ..Ledger::default() }, 0.320);
        assert!(balance.decide(0.040, &stakes(None)));
        // What was measured counts more than what was guessed.
        let refits = Done { triangles: 1e6, seconds: 0.004 };
        balance.learn(&Ledger { refits, all: 0.004, ..Ledger::default() }, 0.004);
        balance.by_rays = false;
        assert!(!balance.decide(0.040, &stakes(None)));
    }

    #[test]
    fn it_ends_when_the_loss_would_have_bought_a_build() {
        let mut balance = balance();
        assert!(balance.decide(0.040, &stakes(None)));
        // An eighth of 490 ms is lost in a frame, 9 ms are saved, a build costs 80.
        let frames = (0..10).take_while(|_| balance.decide(0.500, &stakes(Some(1.0)))).count();
        assert_eq!(frames, 1);
        // And as long as it pays now and then, never.
        assert!(balance.decide(0.040, &stakes(None)));
        for _ in 0..20 {
            assert!(balance.decide(0.500, &stakes(Some(1.0))));
            for _ in 0..8 {
                assert!(balance.decide(0.040, &stakes(Some(0.2))));
            }
        }
    }

    #[test]
    fn who_wears_stays_away_longer_and_longer() {
        let mut object = ByRays::default();
        assert!(object.may());
        for pause in [8, 16, 32] {
            object.wore();
            assert_eq!((0..100).take_while(|_| !object.may()).count(), pause - 1);
        }
    }
}
