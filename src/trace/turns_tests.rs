//! Rays in turn against one ray at a time. The stacks of these builds are short (see `STACK`), so that some rays run out of them.

use super::Kernels;
use super::ground::Plain;
use super::packet::{Found, Packet, RAYS};
use super::shells::Shells;
use super::tests::{kernels, rays};
use super::turns::Habits;
use crate::accel::test_meshes::{Random, bumpy_sphere, needles, soup};
use crate::accel::{Bvh, ChildRef, build_fast, build_sah};
use crate::simd::{Level, Scalar, bits};

const NUMBERS: (u32, u32) = (9, 4);

fn turns<const ANY: bool>(
    level: Level,
    bvh: &Bvh,
    packet: &Packet,
    mask: u64,
    down: [bool; 3],
    found: &mut Found,
) -> u64 {
    assert!(level.is_available());
    let tree = Plain::new(bvh);
    // SAFETY: the level is available, and the tree is not empty.
    unsafe {
        match level {
            Level::Scalar => Scalar::turns::<ANY, _>(&tree, ChildRef::ROOT, packet, mask, down, NUMBERS, found),
            #[cfg(all(target_arch = "x86_64", not(openrt_few_levels)))]
            Level::Sse41 => {
                crate::simd::Sse41::turns::<ANY, _>(&tree, ChildRef::ROOT, packet, mask, down, NUMBERS, found)
            }
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => {
                crate::simd::Avx2::turns::<ANY, _>(&tree, ChildRef::ROOT, packet, mask, down, NUMBERS, found)
            }
            #[cfg(all(target_arch = "x86_64", not(openrt_few_levels)))]
            Level::Avx512 => {
                crate::simd::Avx512::turns::<ANY, _>(&tree, ChildRef::ROOT, packet, mask, down, NUMBERS, found)
            }
            #[cfg(any(not(target_arch = "x86_64"), openrt_few_levels))]
            _ => unreachable!("such levels are not available"),
        }
    }
}

/// Traces the packet octant by octant; the rays that ran out of stack.
fn by_octants<const ANY: bool>(level: Level, bvh: &Bvh, packet: &Packet, found: &mut Found) -> u64 {
    (0..8).fold(0, |full, octant| {
        let down = [0, 1, 2].map(|k| octant >> k & 1 == 1);
        let same = |k: usize| if down[k] { packet.negative[k] } else { !packet.negative[k] };
        let mask = packet.usable & same(0) & same(1) & same(2);
        full | turns::<ANY>(level, bvh, packet, mask, down, found)
    })
}

/// How many rays hit something, and how many ran out of stack.
fn check(name: &str, bvh: &Bvh, rays: &[super::Ray], kernels: &Kernels) -> (usize, usize) {
    let (mut packet, mut hits, mut full) = (Packet::new(), 0, 0);
    for rays in rays.chunks(RAYS) {
        let which: Vec<u16> = (0..rays.len() as u16).collect();
        let mut closest = Found::new();
        // SAFETY: every processor has the scalar set.
        unsafe {
            packet.gather::<Scalar, false>(&mut closest, rays, &which);
            packet.prepare_triangles::<Scalar>(packet.usable);
        }
        let mut any = closest.clone();
        let out = [
            by_octants::<false>(kernels.level(), bvh, &packet, &mut closest),
            by_octants::<true>(kernels.level(), bvh, &packet, &mut any),
        ];
        full += out[0].count_ones() as usize;
        for r in bits(packet.usable) {
            let ray = packet.ray(r, rays[r].tmax);
            let mut expected = super::Hit::none(ray.tmax);
            let is_hit = kernels.intersect(bvh, &ray, NUMBERS.0, NUMBERS.1, &mut expected);
            hits += usize::from(is_hit);
            if out[0] >> r & 1 == 0 {
                assert_eq!(closest.hits[r], expected, "{name}, {:?}, ray {r} {ray:?}", kernels.level());
                assert_eq!(closest.t[r / 8][r % 8].to_bits(), closest.hits[r].t.to_bits(), "{name}");
            }
            let open = any.open >> r & 1 == 1;
            assert!(out[1] >> r & 1 == 1 && open || open != is_hit, "{name}, {:?}, any, ray {r}", kernels.level());
        }
    }
    (hits, full)
}

#[test]
fn rays_in_turn_find_what_they_find_alone() {
    let mut random = Random::new(Random::seed(41));
    let meshes = [
        ("soup", soup(&mut random, 3000, 0.5)),
        ("needles", needles(&mut random, 2000)),
        ("sphere", bumpy_sphere(40, 60)),
        ("few", soup(&mut random, 5, 0.5)),
    ];
    for (name, mesh) in &meshes {
        let rays = rays(&mut random, mesh, 600);
        for bvh in [build_sah(mesh), build_fast(mesh)] {
            let bvh = bvh.expect("memory");
            for kernels in kernels() {
                let (hits, full) = check(name, &bvh, &rays, &kernels);
                assert!(hits > 50, "{name}: {hits} hits");
                let deep = *name == "soup";
                assert!(!deep || (full > 0 && full < rays.len() / 2), "{name}: {full} ran out of stack");
            }
        }
    }
}

#[test]
fn packets_that_fall_apart_are_remembered_and_probed_more_and_more_rarely() {
    let mut habits = Habits::NONE[0][0];
    assert!(!habits.are_to_part(), "nothing has been seen");
    habits.saw(64, 200);
    let mut probes = vec![];
    for packet in 0..1200 {
        if !habits.are_to_part() {
            probes.push(packet);
            habits.saw(64, 200);
        }
    }
    assert_eq!(probes, [16, 49, 114, 243, 500, 757, 1014]);
    // A probe that stays together makes the next one come soon.
    while habits.are_to_part() {}
    habits.saw(64, 10);
    assert_eq!((0..17).filter(|_| habits.are_to_part()).count(), 16);
    for _ in 0..40 {
        habits.saw(64, 10);
    }
    assert!((0..1000).all(|_| !habits.are_to_part()), "rays stay together now");
}
