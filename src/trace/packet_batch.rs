//! Many rays as packets.
//!
//! Sixty-four neighbours whose directions have the same signs are a packet as they are: nearly all tiles of camera rays. Others, as those of
//! diffuse bounces, are sorted by these signs in runs of [`RUN`], in their own order within each octant, and cut into packets of up to 64: of a run
//! an octant has an eighth, so that a packet holds neighbours that at least begin alike.
//!
//! Measured on the bumpy sphere (1.3 million triangles) and a cloth, AVX2: packets of 16, 32 and 64 camera rays 9.8, 11.2 and 11.6
//! Mrays/s. Runs of 1024 to 4096 are alike. Sorting by the longest axis as well, within runs of 4096, made bounces 5 to 15 % slower: it tears
//! neighbours apart. Rays come in by transposing eight at a time: of a camera ray's instructions that was a sixth when each was asked for its octant
//! and sorted, and is a fourteenth now. Octants of those that are sorted are the signs of one vector per ray, and whether a direction is of usual length is asked in the packet.
//!
//! *Tried*, for bounces that take turns ([`super::turns`]): all rays of an octant in a run at once, without packets, so that no slot waits for the last rays of
//! a packet. A twentieth slower: to prepare rays one at a time costs as much as packets do.

use super::packet::RAYS;
use super::packet_scene::{Scratch, traverse};
use super::shells::Shells;
use super::turns::Habits;
use super::{Hit, Kernels, Ray, Scope};
use crate::simd::{Isa, Vector};
use std::cell::Cell;

/// Rays that are sorted together.
const RUN: usize = 2048;

thread_local! {
    /// What the packets of a thread were like, from batch to batch. Of another scene it is soon forgotten.
    static HABITS: Cell<[[Habits; 2]; 2]> = const { Cell::new(Habits::NONE) };
}

/// In the place of an octant: a ray that has been traced.
const TRACED: u8 = 8;

/// Calls `answer(i, hit)` for every ray of usual length (see `Tracer`); with `ANY`, `hit` only tells whether something was hit. Returns whether all are.
///
/// # Safety
/// - The processor has the instruction set `I`, and `kernels` are its own.
#[inline(always)]
pub(super) unsafe fn trace_many<I: Shells, const ANY: bool>(
    world: Scope<'_>,
    kernels: &Kernels,
    rays: &[Ray],
    mut answer: impl FnMut(usize, Option<Hit>),
) -> bool {
    let mut all_usual = true;
    let mut scratch = Scratch::new();
    scratch.found.habits = HABITS.get();
    let mut octants = [0u8; RUN];
    let mut order = [0u16; RUN];
    for (run, rays) in rays.chunks(RUN).enumerate() {
        let mut all_traced = true;
        for (c, (neighbours, octants)) in rays.chunks(RAYS).zip(octants.chunks_mut(RAYS)).enumerate() {
            // SAFETY: the caller's promise.
            if seem_alike(neighbours) && unsafe { scratch.world.gather_alike::<I, ANY>(&mut scratch.found, neighbours) }
            {
                // SAFETY: the caller's promise.
                unsafe { traverse::<I, ANY>(world, kernels, &mut scratch) };
                for slot in 0..neighbours.len() {
                    answer(RUN * run + RAYS * c + slot, scratch.answer::<ANY>(slot));
                }
                octants.fill(TRACED);
            } else {
                all_traced = false;
                for (ray, octant) in neighbours.iter().zip(octants) {
                    // SAFETY: the caller's promise.
                    *octant = unsafe { octant_of::<I>(ray) };
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
        let mut start = 0;
        for &end in &next[..usize::from(TRACED)] {
            for which in order[start..end].chunks(RAYS) {
                // SAFETY: the caller's promise.
                let unusual = unsafe {
                    let unusual = scratch.world.gather::<I, ANY>(&mut scratch.found, rays, which);
                    traverse::<I, ANY>(world, kernels, &mut scratch);
                    unusual
                };
                all_usual &= unusual == 0;
                for (slot, &i) in which.iter().enumerate() {
                    if unusual >> slot & 1 == 0 {
                        answer(RUN * run + usize::from(i), scratch.answer::<ANY>(slot));
                    }
                }
            }
            start = end;
        }
    }
    HABITS.set(scratch.found.habits);
    all_usual
}

/// Whether the directions of the first, the last and the ray between them have the same signs: then those of all may.
#[inline(always)]
fn seem_alike(rays: &[Ray]) -> bool {
    let [first, .., last] = rays else { return false };
    let signs = |ray: &Ray| [ray.direction.x, ray.direction.y, ray.direction.z].map(f32::is_sign_negative);
    let of_first = signs(first);
    of_first == signs(last) && of_first == signs(&rays[rays.len() / 2])
}

/// 0 to 7 by the signs of the direction.
///
/// # Safety
/// - The processor has the instruction set `I`.
#[inline(always)]
unsafe fn octant_of<I: Isa>(ray: &Ray) -> u8 {
    let Ray { direction: dir, tmax, .. } = *ray;
    // SAFETY: the caller's promise.
    unsafe { (I::F4::load(&[dir.x, dir.y, dir.z, tmax]).lt(I::F4::splat(0.0)) & 7) as u8 }
}

#[cfg(test)]
mod tests {
    use crate::accel::TwoLevel;
    use crate::accel::test_meshes::{Random, bumpy_sphere, soup};
    use crate::scene::{Command, Instance, Motion, Scene};
    use crate::simd::Level;
    use crate::trace::{Hit, Ray, Tracer};
    use glam::{Affine3A, Vec3};

    /// Rays of a camera, in tiles of 8 by 8 and a part of one, with a few strangers among them.
    fn camera(random: &mut Random, eye: Vec3, strangers: bool) -> Vec<Ray> {
        (0..4821)
            .map(|i| {
                let (tile, pixel) = (i / 64, i % 64);
                let at = [tile % 9 * 8 + pixel % 8, tile / 9 * 8 + pixel / 8].map(|x| x as f32 / 36.0 - 1.0);
                let mut ray = Ray::new(eye, Vec3::new(at[0], at[1], 0.0) - eye);
                match random.below(if strangers { 200 } else { 1 << 20 }) {
                    0 => ray.direction *= 1e-39,
                    1 => ray.direction *= 1e36,
                    2 => ray.direction.x = f32::NAN,
                    3 => ray.direction[random.below(3)] = -0.0,
                    4 => ray.origin += random.vec() * 0.1,
                    5 => ray.tmin = 1.0,
                    6 => ray.tmax = 0.9,
                    7 => ray.tmax = -1.0,
                    8 => ray.direction = -ray.direction,
                    _ => {}
                }
                ray
            })
            .collect()
    }

    #[test]
    fn rays_that_go_alike_find_what_they_find_alone() {
        let seed = Random::seed(53);
        let mut random = Random::new(seed);
        let mut scene = Scene::default();
        for (name, mesh) in [(1, bumpy_sphere(40, 60)), (2, soup(&mut random, 2000, 0.1))] {
            scene.apply(Command::DefineObject { name, mesh, motion: Motion::Affine });
        }
        let placed = |object, x: f32, scale: f32| {
            let to = Affine3A::from_translation(Vec3::new(x, 0.1, 0.0));
            Instance::new(object, to * Affine3A::from_scale(Vec3::splat(scale)))
        };
        let own = Instance::new(1, Affine3A::IDENTITY);
        let scenes = [vec![own], vec![placed(1, 0.2, 0.7)], vec![own, placed(2, -0.4, 0.8), placed(1, 0.6, 0.3)]];
        for level in Level::available() {
            for instances in &scenes {
                let mut world = TwoLevel::new(level);
                world.update(&scene, instances);
                let tracer = Tracer::new(&world);
                for (eye, strangers) in [(Vec3::new(3.0, 2.0, 5.0), false), (Vec3::new(0.3, -0.2, 4.0), true)] {
                    let rays = camera(&mut random, eye, strangers);
                    let mut hits: Vec<Option<Hit>> = vec![None; rays.len()];
                    let mut dark = vec![false; rays.len()];
                    // Of few rays that one stranger is among, as one makes a whole batch look again.
                    let piece = if strangers { 200 } else { rays.len() };
                    for ((rays, hits), dark) in
                        rays.chunks(piece).zip(hits.chunks_mut(piece)).zip(dark.chunks_mut(piece))
                    {
                        hits.copy_from_slice(&tracer.intersect_many(rays));
                        tracer.occluded_many(rays, dark);
                    }
                    for (i, ray) in rays.iter().enumerate() {
                        let hit = tracer.intersect(ray);
                        let what = format!("seed {seed}, {level:?}, {} instances, ray {i} {ray:?}", instances.len());
                        assert_eq!(format!("{:?}", hits[i]), format!("{hit:?}"), "{what}");
                        assert_eq!(dark[i], hit.is_some(), "{what}");
                    }
                    let count = hits.iter().flatten().count();
                    assert!(count > 500 && count < rays.len(), "{count} rays hit something");
                }
            }
        }
    }
}
