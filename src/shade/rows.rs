//! Numbers of up to 64 samples in rows of eight lanes, and records that lanes look up by a key.

use crate::simd::LANES;
use crate::trace::RayPacket;
use glam::Vec3;

/// Samples of a packet.
pub(super) const SLOTS: usize = RayPacket::RAYS;
/// Rows of a packet.
pub(super) const GROUPS: usize = SLOTS / LANES;

/// A number per sample; sample `s` is lane `s % 8` of row `s / 8`.
pub(super) type Rows = [[f32; LANES]; GROUPS];
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
