//! Every instruction set that this processor has gives the answers of the scalar one, bit for bit, through the whole of a
//! tree; the levels it lacks are named aloud. (The conformance suite compares all structures with an oracle.)

#[path = "common/skip.rs"]
mod skip;

use glam::Vec3;
use openrt::accel::{build_fast, build_sah};
use openrt::scene::Mesh;
use openrt::simd::Level;
use openrt::trace::{Hit, Kernels, PreparedRay, Ray};
use skip::skipped;

/// SplitMix64.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) >> 40) as f32 / (1u64 << 24) as f32
    }

    fn vec(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }
}

fn seed() -> u64 {
    std::env::var("OPENRT_SEED").ok().and_then(|s| s.parse().ok()).unwrap_or(21)
}

/// Small triangles around a sphere; every tenth shares its plane and corners with the one before.
fn mesh(random: &mut Random, count: usize) -> Mesh {
    let mut mesh = Mesh::default();
    for i in 0..count {
        let at = random.vec().normalize_or(Vec3::X);
        let corners = match (i % 10, mesh.positions.len()) {
            (0, n) if n > 0 => [mesh.positions[n - 1], mesh.positions[n - 2], mesh.positions[n - 3]],
            _ => [at, at + random.vec() * 0.1, at + random.vec() * 0.1],
        };
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(corners);
        mesh.triangles.push([first, first + 1, first + 2]);
    }
    mesh
}

#[test]
fn every_level_gives_the_scalar_answer() {
    let seed = seed();
    let mut random = Random(seed);
    // Around the widths of blocks and nodes, and one of several thousand.
    for count in [1, 3, 4, 5, 7, 8, 9, 31, 32, 33, 5000] {
        let mesh = mesh(&mut random, count);
        for bvh in [build_sah(&mesh).expect("memory"), build_fast(&mesh).expect("memory")] {
            let scalar = Kernels::new(Level::Scalar);
            for i in 0..4000 {
                let org = random.vec() * 2.0;
                let target = mesh.positions[(random.unit() * mesh.positions.len() as f32) as usize];
                let aim = if i % 2 == 0 { target } else { random.vec() };
                let Some(ray) = PreparedRay::new(&Ray::new(org, aim - org)) else { continue };
                let mut expected = Hit::none(ray.tmax);
                scalar.intersect(&bvh, &ray, 1, 2, &mut expected);
                for level in Level::available() {
                    let kernels = Kernels::new(level);
                    assert_eq!(kernels.level(), level);
                    let mut hit = Hit::none(ray.tmax);
                    kernels.intersect(&bvh, &ray, 1, 2, &mut hit);
                    let bits = |h: &Hit| (h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.primitive, h.instance);
                    assert_eq!(bits(&hit), bits(&expected), "{level:?}, OPENRT_SEED={seed}, ray {i}");
                    assert_eq!(
                        kernels.occluded(&bvh, &ray),
                        !expected.is_none(),
                        "{level:?}, OPENRT_SEED={seed}, ray {i}"
                    );
                }
            }
        }
    }
}

#[test]
fn levels_that_are_missing_are_named() {
    for level in Level::ALL {
        if level.is_available() {
            eprintln!("level {}: tested", level.name());
        } else {
            skipped(format_args!("level {} (this processor does not have it)", level.name()));
            // Asked for nevertheless, the strongest one that there is takes its place.
            assert_eq!(Kernels::new(level).level(), Level::strongest());
        }
    }
}
