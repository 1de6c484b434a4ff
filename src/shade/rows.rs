//! Numbers of up to 64 samples in rows of eight lanes, and records that lanes look up by a key.

use crate::simd::{Isa, LANES, Proof};
use crate::trace::RayPacket;
use glam::Vec3;

/// Samples of a packet.
pub(super) const SLOTS: usize = RayPacket::RAYS;
/// Rows of a packet.
pub(super) const GROUPS: usize = SLOTS / LANES;

/// A number per sample; sample `s` is lane `s % 8` of row `s / 8`.
pub(super) type Rows = [[f32; LANES]; GROUPS];
/// An integer per sample.
pub(super) type Words = [[u32; LANES]; GROUPS];
/// A vector per sample.
pub(super) type Rows3 = [Rows; 3];

pub(super) const ZEROS: Rows = [[0.0; LANES]; GROUPS];

/// Row `g` of each component.
#[inline(always)]
pub(super) fn row3(rows: &Rows3, g: usize) -> [&[f32; LANES]; 3] {
    [&rows[0][g], &rows[1][g], &rows[2][g]]
}

/// Row `g` of each component.
#[inline(always)]
pub(super) fn row3_mut(rows: &mut Rows3, g: usize) -> [&mut [f32; LANES]; 3] {
    let [x, y, z] = rows;
    [&mut x[g], &mut y[g], &mut z[g]]
}

/// The vector of sample `slot`.
#[inline(always)]
pub(super) fn vec3(rows: &Rows3, slot: usize) -> Vec3 {
    let (g, l) = (slot / LANES, slot % LANES);
    Vec3::new(rows[0][g][l], rows[1][g][l], rows[2][g][l])
}

/// Makes `v` the vector of sample `slot`.
#[inline(always)]
pub(super) fn set_vec3(rows: &mut Rows3, slot: usize, v: Vec3) {
    let (g, l) = (slot / LANES, slot % LANES);
    for k in 0..3 {
        rows[k][g][l] = v[k];
    }
}

/// Bits of row `g`.
#[inline(always)]
pub(super) fn lanes_of(mask: u64, g: usize) -> u32 {
    (mask >> (LANES * g)) as u32 & 0xff
}

/// Of each of eight lanes the record of `N` numbers that belongs to its key. Neighbouring samples mostly have the same keys, so
/// only what changes is looked up.
pub(super) struct Held<const N: usize> {
    keys: [u32; LANES],
    pub rows: [[f32; LANES]; N],
}

impl<const N: usize> Held<N> {
    /// No key is `u32::MAX`.
    pub fn new() -> Self {
        Self { keys: [u32::MAX; LANES], rows: [[0.0; LANES]; N] }
    }

    /// Holds nothing any more.
    pub fn forget(&mut self) {
        self.keys = [u32::MAX; LANES];
    }

    /// [`Held::hold`] of many numbers, that are there already.
    #[inline(always)]
    pub fn hold_wide<'r, I: Isa>(&mut self, isa: Proof<I>, keys: &[u32; LANES], record: impl Fn(u32) -> &'r [f32; N]) {
        const { assert!(N.is_multiple_of(LANES)) };
        if self.keys == *keys {
            return;
        }
        self.keys = *keys;
        if *keys == [keys[0]; LANES] {
            for (row, &number) in self.rows.iter_mut().zip(record(keys[0])) {
                isa.splat(number).store(row);
            }
            return;
        }
        for (k, rows) in self.rows.as_chunks_mut::<LANES>().0.iter_mut().enumerate() {
            let mut records = [isa.splat(0.0); LANES];
            for (of_lane, &key) in records.iter_mut().zip(keys) {
                *of_lane = isa.load(&record(key).as_chunks().0[k]);
            }
            for (row, lanes) in rows.iter_mut().zip(isa.transposed(records)) {
                lanes.store(row);
            }
        }
    }

    #[inline(always)]
    pub fn hold(&mut self, keys: &[u32; LANES], record: impl Fn(u32) -> [f32; N]) {
        if self.keys == *keys {
            return;
        }
        if *keys == [keys[0]; LANES] {
            for (row, number) in self.rows.iter_mut().zip(record(keys[0])) {
                *row = [number; LANES];
            }
        } else {
            for l in 0..LANES {
                if self.keys[l] != keys[l] {
                    for (row, number) in self.rows.iter_mut().zip(record(keys[l])) {
                        row[l] = number;
                    }
                }
            }
        }
        self.keys = *keys;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{Level, WideKernel, run_wide};

    /// Holds records of many numbers, one set of keys after the other.
    struct Hold<'a>(&'a [[u32; LANES]], &'a [[f32; 16]]);

    impl WideKernel for Hold<'_> {
        type Output = ();

        #[inline(always)]
        fn run<I: Isa>(self, isa: Proof<I>) {
            let mut held = Held::<16>::new();
            for keys in self.0 {
                held.hold_wide(isa, keys, |key| &self.1[key as usize]);
                for (l, &key) in keys.iter().enumerate() {
                    for k in 0..16 {
                        assert_eq!(held.rows[k][l], self.1[key as usize][k]);
                    }
                }
            }
        }
    }

    #[test]
    fn every_lane_holds_the_many_numbers_of_its_key() {
        let records: Vec<[f32; 16]> = (0..10).map(|i| std::array::from_fn(|k| (16 * i + k) as f32)).collect();
        let keys = [[3; 8], [3, 3, 4, 3, 3, 5, 3, 3], [3; 8], [9, 3, 4, 4, 4, 5, 5, 9], [4; 8]];
        for level in Level::available() {
            run_wide(level, Hold(&keys, &records));
        }
    }

    #[test]
    fn every_lane_holds_the_record_of_its_key() {
        let mut held = Held::<2>::new();
        let record = |key: u32| [key as f32, -(key as f32)];
        for keys in [[3; 8], [3, 3, 4, 3, 3, 5, 3, 3], [9, 3, 4, 4, 4, 5, 5, 9], [4; 8]] {
            held.hold(&keys, record);
            for (l, &key) in keys.iter().enumerate() {
                assert_eq!([held.rows[0][l], held.rows[1][l]], record(key));
            }
        }
    }
}
