//! Many rays as packets.
//!
//! Rays are taken in runs of [`RUN`], sorted by the signs of their directions, in their own order within each octant, and cut into packets of up to
//! 64. Rays of a tile of camera rays all have the same signs but for a few tiles, and stay together; of diffuse bounces an eighth
//! of the run has, so that a packet holds neighbours that at least begin alike.
//!
//! Measured on the bumpy sphere (1.3 million triangles) and a cloth, AVX2: packets of 16, 32 and 64 camera rays 9.8, 11.2 and 11.6
//! Mrays/s. Runs of 1024 to 4096 are alike. Sorting by the longest axis as well, within runs of 4096, made bounces 5 to 15 % slower: it tears
//! neighbours apart. Rays come in by transposing eight at a time: a tenth of a camera ray's instructions less than number by number.

use super::packet::{LANES, RAYS, is_usual, spread, transposed};
use super::packet_scene::{Scratch, traverse};
use super::shells::Shells;
use super::{Hit, Kernels, Ray};
use crate::accel::TwoLevel;
use crate::simd::{Isa, Vector};

/// Rays that are sorted together.
const RUN: usize = 2048;
/// In the place of an octant: a ray that is left out, and one that has been traced.
const UNUSUAL: u8 = 8;
const TRACED: u8 = 9;

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
    let mut order = [0u16; RUN];
    for (run, rays) in rays.chunks(RUN).enumerate() {
        let mut all_traced = true;
        for (c, (neighbours, octants)) in rays.chunks(RAYS).zip(octants.chunks_mut(RAYS)).enumerate() {
            // SAFETY: the caller's promise.
            if seem_alike(neighbours) && unsafe { scratch.world.gather_alike::<I>(&mut scratch.found, neighbours) } {
                // SAFETY: the caller's promise.
                unsafe { traverse::<I, ANY>(world, kernels, &mut scratch) };
                for slot in 0..neighbours.len() {
                    answer(RUN * run + RAYS * c + slot, scratch.answer::<ANY>(slot));
                }
                octants.fill(TRACED);
            } else {
                all_traced = false;
                for (rays, octants) in neighbours.chunks(LANES).zip(octants.chunks_exact_mut(LANES)) {
                    // SAFETY: the caller's promise.
                    octants.copy_from_slice(&unsafe { octants_of::<I>(rays) });
                }
            }
        }
        if all_traced {
            continue;
        }
        // A counting sort.
        let octants = &octants[..rays.len()];
        let mut counts = [0usize; 16];
        for octant in octants {
            counts[usize::from(octant & 15)] += 1;
        }
        let mut next = [0usize; 16];
        for octant in 1..=usize::from(TRACED) {
            next[octant] = next[octant - 1] + counts[octant - 1];
        }
        for (i, octant) in (0..).zip(octants) {
            let at = &mut next[usize::from(octant & 15)];
            order[*at % RUN] = i;
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

/// 0 to 7 by the signs of the direction, or [`UNUSUAL`], of up to eight rays.
///
/// # Safety
/// - The processor has the instruction set `I`.
#[inline(always)]
unsafe fn octants_of<I: Isa>(rays: &[Ray]) -> [u8; LANES] {
    // SAFETY: the caller's promise.
    unsafe {
        let [_, _, _, _, x, y, z, _] = transposed::<I>(rays);
        let zero = I::F8::splat(0.0);
        let octants = spread(x.lt(zero)) | (spread(y.lt(zero)) << 1) | (spread(z.lt(zero)) << 2);
        let unusual = spread(!is_usual::<I>([x, y, z]) & 0xff);
        let usual = octants & !(7 * unusual);
        (usual | (unusual * u64::from(UNUSUAL))).to_le_bytes()
    }
}
