//! Origins of secondary rays.

use crate::kit::*;
use glam::{Affine3A, Vec3};
use openrt::scene::*;
use openrt::simd::Level;

/// A number from `OPENRT_SEED`, or the one given.
fn seed(default: u64) -> u64 {
    std::env::var("OPENRT_SEED").ok().and_then(|s| s.parse().ok()).unwrap_or(default)
}

struct Random(openrt::shade::Rng);

impl Random {
    fn new(seed: u64) -> Self {
        Self(openrt::shade::Rng::new(seed as u32, (seed >> 32) as u32, 0))
    }

    fn unit(&mut self) -> f32 {
        self.0.next_f32()
    }

    fn vec3(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - Vec3::ONE
    }

    fn direction(&mut self) -> Vec3 {
        loop {
            let v = self.vec3();
            if (0.01..1.0).contains(&v.length_squared()) {
                return v.normalize();
            }
        }
    }
}

/// Spawned rays never meet the flat triangle that they leave, wherever it lies and however it is instanced.
#[test]
fn r15_a_million_spawned_rays_never_hit_their_own_triangle() {
    use openrt::accel::TwoLevel;
    use openrt::shade::{Cone, Interaction, Placed};
    use openrt::trace::{Ray, Tracer};
    let seed = seed(15);
    let mut random = Random::new(seed);
    let (mut spawned, mut hits) = (0u32, 0u32);
    for round in 0..2000 {
        let offset = [0.0, 1.0, 1e3, 1e5][round % 4];
        let size = [1.0, 1e-3, 30.0, 1e3][round / 4 % 4];
        let motion = [Motion::Affine, Motion::Static][round / 16 % 2];
        let origin = random.vec3() * offset;
        // Any triangle; one flat in an axis and close to that plane's origin; a needle; one all but flat.
        let (axes, near) = match round / 128 % 4 {
            0 => (Vec3::ONE, Vec3::ONE),
            1 => (Vec3::new(1.0, 1.0, 0.0), Vec3::new(1.0, 1.0, 1e-3)),
            2 => (random.direction(), Vec3::ONE),
            _ => (Vec3::new(1.0, 1e-3, 1.0), Vec3::new(1.0, 1e-3, 1.0)),
        };
        let needle = round / 128 % 4 == 2;
        let corners = [0; 3].map(|_| {
            let p = random.vec3() * size;
            origin * near + if needle { axes * p.x + p * 1e-3 } else { p * axes }
        });
        let mut m = match round / 32 % 4 {
            0 => Affine3A::IDENTITY,
            1 => Affine3A::from_rotation_x(random.unit() * 6.0) * Affine3A::from_rotation_y(random.unit() * 6.0),
            2 => Affine3A::from_scale(Vec3::new(0.01, 3.0, -20.0)) * Affine3A::from_rotation_z(random.unit() * 6.0),
            _ => Affine3A::from_mat3(glam::Mat3::from_cols(random.vec3(), random.vec3(), random.vec3())),
        };
        m.translation = glam::Vec3A::from(random.vec3() * [0.0, 1.0, 1e4][round % 3]);
        let mut w = World::new(1);
        let name = w.object(Mesh { positions: corners.to_vec(), triangles: vec![[0, 1, 2]], ..Mesh::default() });
        w.scene.apply(Command::SetMotion { name, motion });
        w.place(name, m);
        let mut world = TwoLevel::new(Level::detect());
        world.update(&w.scene, &w.frame.instances);
        let tracer = Tracer::new(&world);
        let mesh = &w.scene.objects[&name].mesh;
        let matrices = Placed::new(m);
        let placed = corners.map(|c| m.transform_point3(c));
        let extent = (placed[1] - placed[0]).length().max((placed[2] - placed[0]).length());
        for _ in 0..500 {
            let (u, v) = (random.unit(), random.unit());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let target = placed[0] * (1.0 - u - v) + placed[1] * u + placed[2] * v;
            let towards = random.direction();
            let ray = Ray::new(target - towards * extent, towards);
            let Some(hit) = tracer.intersect(&ray) else { continue };
            let cone = Cone { width: 0.0, spread: 0.0 };
            let it = Interaction::new(&ray, &hit, &matrices, mesh, cone, 0);
            // All directions, and nearly tangential ones.
            let n = it.point.geometric_normal;
            for grazing in [1.0, 0.0, 1e-3, 1e-6] {
                let d = random.direction();
                let d = if grazing == 1.0 { d } else { ((d - n * d.dot(n)) + n * (grazing * d.dot(n))).normalize() };
                spawned += 1;
                if tracer.intersect(&it.spawn(d)).is_some() {
                    hits += 1;
                }
            }
        }
    }
    assert!(spawned > 1_000_000, "{spawned}");
    assert_eq!(hits, 0, "of {spawned} rays; seed {seed}");
}
