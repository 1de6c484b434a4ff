//! Whether a worn tree is built anew: what rays lose in it, against the price of a build.
//!
//! The cost of a tree (SAH) tells by how much longer one ray takes, and not how many rays there are. So whoever traces says how long rays took
//! ([`crate::accel::TwoLevel::add_traced`]), and objects count how often they were met, up to a bound ([`crate::accel::waiting`]); the time is shared out by that.
//! Of its share an object's rays have lost the part by which its tree costs more than after its build:
//!
//! ```text
//! lost   = time · (1 - 1 / wear)                         summed up since the build
//! coming = time · wear now / wear then · (1 - 1 / wear now)
//! build if wear > WORN and lost + coming >= price
//! ```
//!
//! The rule of those who rent skis: what is lost before a build is never more than the build would have cost, or one frame's loss. Where rays are many it builds in the frame
//! that wears the tree, as it would without any of this; where nobody says how long rays took, likewise. The price is a multiple of measured refits.
//!
//! An object that no ray met gets the share [`UNSEEN`]: a tree that wears without end would make the first frame that sees it endless.

/// Of the time of all rays, what those of an object are taken to need at least.
const UNSEEN: f64 = 1.0 / 64.0;
/// After so many defeats in a row a refit is tried in every eighth frame.
const MOST_DEFEATS: u32 = 4;

/// See the module head.
#[derive(Debug, Default)]
pub(super) struct Worth {
    /// Seconds that rays took in the last frame; 0 if nobody says.
    traced: f64,
    /// The tree's cost in that frame over that after its build, if it was more.
    wear: f64,
    /// Seconds since the build.
    lost: f64,
    defeats: Defeats,
}

impl Worth {
    /// Rays took `traced` seconds since the last update, of which the object's are the part `share`.
    pub fn tell(&mut self, traced: f64, share: f64) {
        self.traced = traced * share.max(UNSEEN);
        if self.wear > 1.0 {
            self.lost += self.traced * (1.0 - 1.0 / self.wear);
        }
    }

    /// Whether a build for `price` seconds, if that is known, is worth it for a tree of such wear.
    fn pays(&self, wear: f64, price: Option<f64>) -> bool {
        match price {
            Some(price) if self.traced > 0.0 && wear.is_finite() => {
                self.lost + self.traced / self.wear.max(1.0) * (wear - 1.0) >= price
            }
            _ => true,
        }
    }

    /// Whether to build without trying a refit.
    pub fn needs_no_trial(&mut self, price: Option<f64>) -> bool {
        self.defeats.pauses() && self.pays(self.defeats.wear, price)
    }

    /// A refit has left a tree of such wear, too much for it or not. Says whether to build anew.
    pub fn try_refit(&mut self, wear: f64, worn: bool, price: Option<f64>) -> bool {
        let builds = worn && self.pays(wear, price);
        self.defeats.tell(builds, wear);
        self.wear = wear;
        builds
    }

    /// The tree is a new one, by which a worn one was replaced.
    pub fn renewed(&mut self) {
        (self.wear, self.lost) = (1.0, 0.0);
    }
}

/// Refits, with rotations or without, that left the tree so worn that it was built. A motion that defeats them in two frames most likely does so in the third, and to try costs as much
/// as a quarter of the build that follows: so they are not tried in the next frame, then in the next three, then seven. (After a single defeat they are: an
/// animation that begins again jumps once, and a build in vain costs four trials.)
#[derive(Debug, Default)]
struct Defeats {
    in_a_row: u32,
    /// Updates that are builds without trying.
    pause: u32,
    /// Of the tree after the last one.
    wear: f64,
}

impl Defeats {
    fn pauses(&mut self) -> bool {
        let pauses = self.pause > 0;
        self.pause -= u32::from(pauses);
        pauses
    }

    /// The tree was tried and will be built, or not.
    fn tell(&mut self, builds: bool, wear: f64) {
        self.in_a_row = if builds { (self.in_a_row + 1).min(MOST_DEFEATS) } else { 0 };
        self.pause = (1 << self.in_a_row.saturating_sub(1)) - 1;
        self.wear = wear;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PRICE: Option<f64> = Some(0.080);

    /// Frames until a tree that wears by `wear` once is built, if rays take so long while it is not worn.
    fn frames(fresh: f64, wear: f64, price: Option<f64>) -> Option<usize> {
        let mut worth = Worth::default();
        worth.tell(fresh, 1.0);
        (1..=1000).find(|_| {
            let builds = worth.try_refit(wear, wear > 1.5, price);
            worth.tell(fresh * wear, 1.0);
            builds
        })
    }

    #[test]
    fn it_builds_when_rays_have_lost_what_a_build_costs() {
        assert_eq!(frames(0.050, 3.0, PRICE), Some(1), "100 ms are lost in the coming frame");
        // 10 ms in each frame, and in the coming one.
        assert_eq!(frames(0.005, 3.0, PRICE), Some(8));
        assert_eq!(frames(1e-6, 3.0, PRICE), None);
        assert_eq!(frames(1.0, 1.4, PRICE), None, "it is not worn");
        assert_eq!(frames(0.0, 3.0, PRICE), Some(1), "nobody says how long rays took");
        assert_eq!(frames(1e-6, 3.0, None), Some(1), "nor what a build costs");
        assert_eq!(frames(1e-6, f64::INFINITY, PRICE), Some(1), "it has to be");
    }

    #[test]
    fn few_rays_are_no_reason_and_an_endless_tree_is() {
        let mut worth = Worth::default();
        worth.tell(0.100, 0.0);
        assert!(!worth.try_refit(3.0, true, PRICE));
        assert!(worth.try_refit(300.0, true, PRICE), "whoever looks at it will have to wait");
        worth.renewed();
        assert!(!worth.needs_no_trial(PRICE), "once is nothing");
        assert!(worth.try_refit(300.0, true, PRICE));
        worth.renewed();
        assert!(worth.needs_no_trial(PRICE), "it will be as bad again");
        assert!(!worth.needs_no_trial(PRICE), "or not");
        assert!(worth.try_refit(300.0, true, PRICE));
        worth.tell(1e-6, 0.0);
        assert!(!worth.needs_no_trial(PRICE), "but nobody looks");
    }
}
