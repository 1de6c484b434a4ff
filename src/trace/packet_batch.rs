//! Many rays as packets.
//!
//! Rays are taken in runs of [`RUN`], sorted by the signs of their directions, in their own order within each octant, and cut into packets of up to
//! 64. Rays of a tile of camera rays all have the same signs but for a few tiles, and stay together; of diffuse bounces an eighth
//! of the run has, so that a packet holds neighbours that at least begin alike.
//!
//! Measured on the bumpy sphere (1.3 million triangles) and a cloth, AVX2: packets of 16, 32 and 64 camera rays 9.8, 11.2 and 11.6
//! Mrays/s. Runs of 1024 to 4096 are alike. Sorting by the longest axis as well, within runs of 4096, made bounces 5 to 15 % slower: it tears
//! neighbours apart. Rays come in by transposing eight at a time: a tenth of a camera ray's instructions less than number by number.

use super::packet::RAYS;
use super::packet_scene::{Scratch, traverse};
use super::shells::Shells;
use super::tracer::is_usual;
use super::{Hit, Kernels, Ray};
use crate::accel::TwoLevel;

/// Rays that are sorted together.
const RUN: usize = 2048;
/// The octant of a ray that is left out.
const UNUSUAL: u8 = 8;

/// Calls `answer(i, hit)` for every ray of usual length (see `Tracer`); with `ANY`, `hit` only tells whether something was hit. Returns whether all are.
///
/// # Safety
/// - The processor has the instruction set `I`, and `kernels` are its own.
#[inline(always)]
pub(super) unsafe fn trace_many<I: Shells, const ANY: bool>(
    world: &TwoLevel,
    kernels: &Kernels,
    rays: &[Ray],
    mut answer: impl FnMut(usize, Option<Hit>),
) -> bool {
    let mut all_usual = true;
    let mut scratch = Scratch::new();
    let mut octants = [0u8; RUN];
    let (mut order, mut mixed) = ([0u16; RUN], [0u16; RUN]);
    for (run, rays) in rays.chunks(RUN).enumerate() {
        let mut left = 0;
        for (c, neighbours) in (0..).zip(rays.chunks(RAYS)) {
            let first = RAYS * c;
            // SAFETY: the caller's promise.
            if seem_alike(neighbours) && unsafe { scratch.world.gather_alike::<I>(&mut scratch.found, neighbours) } {
                // SAFETY: the caller's promise.
                unsafe { traverse::<I, ANY>(world, kernels, &mut scratch) };
                for slot in 0..neighbours.len() {
                    answer(RUN * run + first + slot, scratch.answer::<ANY>(slot));
                }
            } else {
                for i in first..first + neighbours.len() {
                    mixed[left] = i as u16;
                    left += 1;
                }
            }
        }
        // A counting sort.
        let mut counts = [0usize; 9];
        for (to, &i) in octants.iter_mut().zip(&mixed[..left]) {
            *to = octant(&rays[usize::from(i)]);
            counts[usize::from(*to)] += 1;
        }
        let mut next = [0usize; 9];
        for octant in 1..9 {
            next[octant] = next[octant - 1] + counts[octant - 1];
        }
        for (&i, &octant) in mixed[..left].iter().zip(&octants) {
            let at = &mut next[usize::from(octant)];
            order[*at] = i;
            *at += 1;
        }
        all_usual &= counts[usize::from(UNUSUAL)] == 0;
        let mut start = 0;
        for &end in &next[..usize::from(UNUSUAL)] {
            for which in order[start..end].chunks(RAYS) {
                // SAFETY: the caller's promise.
                unsafe {
                    scratch.world.gather::<I>(&mut scratch.found, rays, which);
                    traverse::<I, ANY>(world, kernels, &mut scratch);
                }
                for (slot, &i) in which.iter().enumerate() {
                    answer(RUN * run + usize::from(i), scratch.answer::<ANY>(slot));
                }
            }
            start = end;
        }
    }
    all_usual
}

/// Whether the directions of the first, the last and the ray between them have the same signs: then those of all may.
#[inline(always)]
fn seem_alike(rays: &[Ray]) -> bool {
    let [first, .., last] = rays else { return false };
    let signs = |ray: &Ray| [ray.dir.x, ray.dir.y, ray.dir.z].map(f32::is_sign_negative);
    let of_first = signs(first);
    of_first == signs(last) && of_first == signs(&rays[rays.len() / 2])
}

/// 0 to 7 by the signs of the direction.
#[inline(always)]
fn octant(ray: &Ray) -> u8 {
    if !is_usual(ray) {
        return UNUSUAL;
    }
    let bit = |d: f32| (d.to_bits() >> 31) as u8;
    bit(ray.dir.x) | bit(ray.dir.y) << 1 | bit(ray.dir.z) << 2
}
