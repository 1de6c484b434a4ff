//! Scenes on the engine's own interface, and the brute force they are compared with.

#[path = "skip.rs"]
mod skip;

use super::random::Random;
use glam::{Affine3A, DVec3, Quat, Vec3, Vec3A};
use openrt::accel::{Space, TopLevel, TwoLevel, to_world};
use openrt::scene::{Command, Instance, Mesh, Motion, Scene, Strategy, TopLevelKind};
use openrt::simd::Level;
use openrt::threads::Pool;
use openrt::trace::{Hit, PreparedRay, Ray, triangle};
use skip::skipped;

/// A scene with its frame's instances. Object names are 1, 2, … in the order of the meshes.
pub struct World {
    pub scene: Scene,
    pub instances: Vec<Instance>,
}

impl World {
    pub fn new(meshes: Vec<Mesh>, instances: Vec<(u32, Affine3A)>) -> Self {
        let mut scene = Scene::default();
        for (i, mesh) in meshes.into_iter().enumerate() {
            scene.apply(Command::DefineObject { name: i as u32 + 1, mesh, motion: Motion::Affine });
        }
        let instances =
            instances.into_iter().map(|(object, world_from_object)| Instance::new(object, world_from_object)).collect();
        Self { scene, instances }
    }

    pub fn plain(mesh: Mesh) -> Self {
        Self::new(vec![mesh], vec![(1, Affine3A::IDENTITY)])
    }

    /// The structures of this scene, by one strategy for everything, with one top level or the other.
    pub fn build(&self, pool: &Pool, strategy: Strategy, level: Level, top: TopLevelKind) -> TwoLevel {
        let mut world = TwoLevel::new(level);
        world.force_strategy(Some(strategy));
        world.force_top_level(Some(top));
        pool.install(|| world.update(&self.scene, &self.instances));
        match (world.top_level(), top) {
            (TopLevel::Bvh(tree), TopLevelKind::Bvh | TopLevelKind::Auto) => {
                tree.validate(world.boxed(), world.boxes()).unwrap_or_else(|e| panic!("top level: {e}"));
            }
            (TopLevel::Bsp(_), TopLevelKind::Bsp) => {}
            (built, asked) => panic!("{asked:?} was asked for, {built:?} is there"),
        }
        world
    }

    /// The answer by testing every triangle of every instance with the reference test, bits included. Takes the inverse
    /// matrices from `built`, and transforms the ray by the documented operations, or the vertices of static instances.
    pub fn brute_force(&self, built: &TwoLevel, ray: &Ray) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        for record in built.instances().iter().filter(|r| r.instance != u32::MAX) {
            let local = match &record.space {
                Space::Object { object_from_world: m } => {
                    let linear = |v: Vec3| {
                        let v = Vec3A::from(v);
                        (m.matrix3.x_axis * v.x + m.matrix3.y_axis * v.y) + m.matrix3.z_axis * v.z
                    };
                    Ray {
                        origin: (linear(ray.origin) + m.translation).into(),
                        direction: linear(ray.direction).into(),
                        ..*ray
                    }
                }
                Space::World | Space::Merged => *ray,
            };
            let Some(local) = PreparedRay::new(&local) else { continue };
            let mesh = &self.scene.objects[&record.object].mesh;
            for prim in 0..mesh.triangles.len() as u32 {
                let corners = match &record.space {
                    Space::Object { .. } => mesh.corners(prim),
                    Space::World | Space::Merged => mesh.corners(prim).map(|p| to_world(&record.world_from_object, p)),
                };
                let Some(h) = triangle::intersect(&local, corners) else { continue };
                let hit =
                    Hit { t: h.t, u: h.u, v: h.v, primitive: prim, object: record.object, instance: record.instance };
                if best.is_none_or(|b| hit.is_before(&b)) {
                    best = Some(hit);
                }
            }
        }
        best
    }
}

/// Every strategy with every instruction set that runs here and every top level. Says which do not run.
pub fn combinations() -> Vec<(Strategy, Level, TopLevelKind)> {
    for level in Level::ALL.into_iter().filter(|l| !l.is_available()) {
        skipped(format_args!("level {} (this processor does not have it)", level.name()));
    }
    let pairs = Strategy::ALL.into_iter().flat_map(|s| Level::available().map(move |l| (s, l)));
    pairs.flat_map(|(s, l)| TopLevelKind::ALL.map(|t| (s, l, t))).collect()
}

/// Placements that a two-level structure must survive: rotated, stretched, mirrored, far away, tiny, huge, sheared, flattened.
pub fn placements(random: &mut Random, count: usize) -> Vec<Affine3A> {
    (0..count)
        .map(|i| {
            let turn = Quat::from_axis_angle((random.vec() + Vec3::splat(1e-3)).normalize(), random.unit() * 6.3);
            let at = random.vec() * 3.0;
            let scale = match i % 8 {
                0 => Vec3::ONE,
                1 => Vec3::splat(0.3),
                2 => Vec3::new(-1.0, 1.0, 1.0),
                3 => Vec3::new(1.0, 0.1, 3.0),
                4 => Vec3::new(-0.01, -2.0, -0.5),
                5 => Vec3::new(1.0, 1.0, 1e-3),
                6 => Vec3::splat(0.05),
                _ => Vec3::splat(1.5),
            };
            let placed = Affine3A::from_scale_rotation_translation(scale, turn, at);
            match i % 11 {
                3 => Affine3A::from_scale(Vec3::new(1.0, 0.2, 1.0)) * placed,
                5 => Affine3A::from_translation(Vec3::new(0.0, 1000.0, 0.0)) * placed,
                7 => Affine3A::from_scale(Vec3::new(1.0, 1.0, 1e-5)) * placed,
                _ => placed,
            }
        })
        .collect()
}

/// What exact geometry says of one ray and one triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    Miss,
    /// Surely hit, at `t` up to `tolerance`.
    Hit {
        t: f64,
        tolerance: f64,
    },
    /// Within the rounding of an f32 test from an edge, or edge-on; hit at `t` up to `tolerance` if at all.
    Unsure {
        t: f64,
        tolerance: f64,
    },
}

/// The oracle: on which side of the three edges the ray passes, by triple products in f64. Knows nothing of the shear or of boxes.
pub fn oracle(ray: &Ray, corners: [Vec3; 3]) -> Verdict {
    const U: f64 = 1.0 / (1 << 24) as f64;
    let d = ray.direction.as_dvec3();
    let o = ray.origin.as_dvec3();
    let p = corners.map(|c| c.as_dvec3() - o);
    if corners.iter().any(|c| !c.is_finite() || c.abs().max_element() > openrt::accel::MAX_COORDINATE) {
        return Verdict::Miss;
    }
    let length = d.length();
    let edge = |a: DVec3, b: DVec3| (d.dot(a.cross(b)), 32.0 * U * length * a.length() * b.length());
    let edges = [edge(p[1], p[2]), edge(p[2], p[0]), edge(p[0], p[1])];
    let sign = |(e, bound): (f64, f64)| if e.abs() <= bound { 0 } else { e.signum() as i32 };
    let signs = edges.map(sign);
    if signs.contains(&1) && signs.contains(&-1) {
        return Verdict::Miss;
    }
    let normal = (corners[1] - corners[0]).as_dvec3().cross((corners[2] - corners[0]).as_dvec3());
    let slope = d.dot(normal);
    let t = p[0].dot(normal) / slope;
    let reach = p.iter().map(|p| p.length()).fold(0.0, f64::max);
    let condition = length * normal.length() / slope.abs();
    let tolerance = 64.0 * U * condition * reach / length;
    let inside = tolerance < 0.1 * reach / length
        && t > f64::from(ray.tmin.max(0.0)) + tolerance
        && t < f64::from(ray.tmax) - tolerance;
    if inside && !signs.contains(&0) {
        return Verdict::Hit { t, tolerance };
    }
    let outside = t < f64::from(ray.tmin.max(0.0)) - tolerance || t > f64::from(ray.tmax) + tolerance;
    if outside && tolerance.is_finite() {
        return Verdict::Miss;
    }
    // Edge-on triangles are hit anywhere in their box.
    let (t, tolerance) = if tolerance < 0.1 * reach / length { (t, tolerance) } else { (0.0, 2.0 * reach / length) };
    Verdict::Unsure { t, tolerance }
}
