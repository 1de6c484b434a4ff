//! Frameless rendering: each frame renders a share of the pixels, in an order that looks random, and keeps the others as older frames
//! left them (Bishop, Fuchs, McMillan, Scher Zagier, *Frameless Rendering: Double Buffering Considered Harmful*, 1994; tried by Larsson and
//! Akenine-Möller 2003, §4).
//!
//! The order is stratified, where Bishop's is not: each packet of 8×8 pixels has a permutation of its own, so that every frame renders as many of its
//! pixels as any other (one more or less), these are still traced as a packet, and all threads have the same work. Each pixel has its turn once in
//! `cycle` frames, and always the same, so that none is ever older than that.

use crate::shade::place;
use crate::trace::RayPacket;

/// Which of the frames of a cycle this is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Turn {
    /// Below `cycle`.
    pub number: u32,
    pub cycle: u32,
}

const BITS: u32 = RayPacket::RAYS.trailing_zeros();

impl Turn {
    /// The samples of the packet at `pixel` whose turn it is.
    pub fn places(self, pixel: [u32; 2]) -> u64 {
        let key = mixed(mixed(pixel[0]) ^ pixel[1]);
        // A number in [0, 1) of 32 bits for each pixel: its place in the permutation, and what all pixels of the packet share,
        // so that packets differ in where one turn ends and the next begins.
        let shared = mixed(key) >> BITS;
        (0..RayPacket::RAYS).fold(0, |mask, slot| {
            let number = permuted(place(slot), key) << (32 - BITS) | shared;
            let turn = (u64::from(number) * u64::from(self.cycle)) >> 32;
            mask | u64::from(turn == u64::from(self.number)) << slot
        })
    }
}

/// A permutation of the pixels of a packet: steps that can be undone, with constants taken from `key`.
fn permuted([x, y]: [u32; 2], key: u32) -> u32 {
    let mask = (1 << BITS) - 1;
    (0..3).fold(y << (BITS / 2) | x, |n, round| {
        let n = (n + (key >> (10 * round))) & mask;
        let n = n.wrapping_mul(key >> (10 * round + 5) | 1) & mask;
        n ^ n >> (BITS / 2)
    })
}

/// The finaliser of MurmurHash3 (Appleby), after an odd step so that 0 does not stay 0.
fn mixed(n: u32) -> u32 {
    let n = n.wrapping_add(0x9E37_79B9);
    let n = (n ^ n >> 16).wrapping_mul(0x85EB_CA6B);
    let n = (n ^ n >> 13).wrapping_mul(0xC2B2_AE35);
    n ^ n >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_has_one_turn_in_a_cycle_and_turns_are_fair() {
        for cycle in [1, 2, 3, 7, 10, 64, 65, 1000] {
            let mut counts = vec![0u32; cycle as usize];
            for pixel in [0, 8, 16, 8000].into_iter().flat_map(|x| [0, 8, 4096].map(|y| [x, y])) {
                let mut seen = 0u64;
                for number in 0..cycle {
                    let mask = Turn { number, cycle }.places(pixel);
                    assert_eq!(mask & seen, 0, "cycle {cycle}, turn {number} of {pixel:?}");
                    seen |= mask;
                    counts[number as usize] += mask.count_ones();
                    let (least, most) = (64 / cycle, 64_u32.div_ceil(cycle) + 1);
                    assert!((least.saturating_sub(1)..=most).contains(&mask.count_ones()), "cycle {cycle}");
                }
                assert_eq!(seen, u64::MAX, "cycle {cycle} of {pixel:?}");
            }
            assert_eq!(counts.iter().sum::<u32>(), 12 * 64);
        }
    }

    #[test]
    fn the_order_looks_random() {
        // Of 64 x 64 packets: how often two pixels that are neighbours have the same turn in four. By chance: one time in four.
        let mut same = [0u32; 2];
        let mut patterns = std::collections::HashSet::new();
        for (x, y) in (0..64).flat_map(|y| (0..64).map(move |x| (x, y))) {
            let mut turns = [[0; 8]; 8];
            let mut pattern = 0;
            for number in 0..4 {
                let mask = Turn { number, cycle: 4 }.places([8 * x, 8 * y]);
                pattern = if number == 0 { mask } else { pattern };
                for slot in (0..RayPacket::RAYS).filter(|slot| mask >> slot & 1 == 1) {
                    let [x, y] = place(slot);
                    turns[y as usize][x as usize] = number;
                }
            }
            patterns.insert(pattern);
            for (i, j) in (0..8).flat_map(|i| (1..8).map(move |j| (i, j))) {
                same[0] += u32::from(turns[i][j] == turns[i][j - 1]);
                same[1] += u32::from(turns[j][i] == turns[j - 1][i]);
            }
        }
        let pairs = 64.0 * 64.0 * 56.0;
        assert!(same.iter().all(|&n| (0.12..0.38).contains(&(f64::from(n) / pairs))), "{same:?} of {pairs}");
        assert!(patterns.len() > 3500, "{} patterns of 4096 packets", patterns.len());
    }
}
