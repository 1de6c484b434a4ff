//! What `RT_AUTO` decides from frame to frame: objects that no ray meets wait for one, large ones are left to the rays where these are few, what parts is sorted, and a motion that wears a tree in every frame is
//! answered by builds. Hits are those of a fresh build, whatever was decided.

#[path = "common/meshes.rs"]
#[allow(dead_code, reason = "shared with other tests")]
mod meshes;
#[path = "common/random.rs"]
mod random;

use glam::{Affine3A, Vec3};
use openrt::accel::{TwoLevel, UpdateStats};
use openrt::scene::{Command, Instance, Mesh, Motion, Scene, Strategy};
use openrt::simd::Level;
use openrt::threads::Pool;
use openrt::trace::{Hit, Ray, Tracer};
use random::Random;
use rayon::prelude::*;

const APART: f32 = 10.0;

struct Stage {
    pool: Pool,
    scene: Scene,
    instances: Vec<Instance>,
    world: TwoLevel,
}

impl Stage {
    /// Soups in a row, [`APART`] from each other.
    fn new(random: &mut Random, soups: &[usize]) -> Stage {
        Stage::of(soups.iter().map(|&count| meshes::soup(random, count, 0.2)))
    }

    /// Objects in a row.
    fn of(objects: impl Iterator<Item = Mesh>) -> Stage {
        let mut scene = Scene::default();
        let mut instances = Vec::new();
        for (name, mesh) in (1..).zip(objects) {
            scene.apply(Command::DefineObject { name, mesh, motion: Motion::Unstructured });
            let world_from_object = Affine3A::from_translation(Vec3::X * APART * (name - 1) as f32);
            instances.push(Instance::new(name, world_from_object));
        }
        let mut world = TwoLevel::new(Level::detect());
        // Not what the environment says.
        world.force_strategy(None);
        let pool = Pool::new(Some(3)).expect("threads");
        Stage { pool, scene, instances, world }
    }

    fn update(&mut self) -> UpdateStats {
        let Stage { pool, scene, instances, world } = self;
        pool.install(|| world.update(scene, instances))
    }

    /// Moves the vertices `part` (of 4) of an object, or all.
    fn shift(&mut self, name: u32, part: Option<usize>, by: Vec3) {
        let positions = &self.scene.objects[&name].mesh.positions;
        let quarter = positions.len() / 4;
        let range = part.map_or(0..positions.len(), |part| part * quarter..(part + 1) * quarter);
        let first = range.start as u32;
        let positions = positions[range].iter().map(|p| *p + by).collect();
        self.scene.apply(Command::UpdatePositions { name, first, positions });
    }

    /// Moves every triangle of a soup on its own.
    fn scatter(&mut self, name: u32, random: &mut Random, size: f32) {
        let mut positions = self.scene.objects[&name].mesh.positions.clone();
        for corners in positions.chunks_mut(3) {
            let by = random.vec() * size;
            corners.iter_mut().for_each(|p| *p += by);
        }
        self.scene.apply(Command::UpdatePositions { name, first: 0, positions });
    }

    fn rays(&self, random: &mut Random, name: u32) -> Vec<Ray> {
        let place = &self.instances[name as usize - 1].world_from_object;
        let positions = &self.scene.objects[&name].mesh.positions;
        let ray = |_| {
            let target = place.transform_point3(positions[random.below(positions.len())]);
            let org = target + Vec3::new(random.unit() - 0.5, 2.0, random.unit() - 0.5) * 2.0;
            Ray::new(org, (target - org) * 0.999)
        };
        (0..600).map(ray).collect()
    }

    /// Looks at an object by many threads at once, and checks what they see.
    fn look(&self, random: &mut Random, name: u32) {
        let rays = self.rays(random, name);
        let mut fresh = TwoLevel::new(Level::detect());
        fresh.force_strategy(Some(Strategy::Sah));
        self.pool.install(|| fresh.update(&self.scene, &self.instances));
        let bits = |h: &Option<Hit>| h.map(|h| [h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.primitive, h.object]);
        let [seen, expected] = [&self.world, &fresh].map(|world| {
            let mut hits = vec![None; rays.len()];
            let tracer = Tracer::new(world);
            self.pool.install(|| {
                let chunks = hits.par_chunks_mut(20).zip(rays.par_chunks(20)).enumerate();
                chunks.for_each(|(i, (hits, rays))| match i % 2 {
                    0 => hits.copy_from_slice(&tracer.intersect_many(rays)),
                    _ => hits.iter_mut().zip(rays).for_each(|(hit, ray)| *hit = tracer.intersect(ray)),
                });
            });
            hits.iter().map(bits).collect::<Vec<_>>()
        });
        assert!(expected.iter().flatten().count() > 100, "the rays are aimed");
        assert_eq!(seen, expected);
    }
}

#[test]
fn who_is_not_looked_at_waits_and_is_right_when_looked_at() {
    let mut random = Random::new(Random::seed(91));
    let mut stage = Stage::new(&mut random, &[2000, 20_000, 1]);
    assert_eq!(stage.update().objects_built, 3);
    stage.look(&mut random, 1);
    stage.look(&mut random, 2);
    let by = |frame: usize| Vec3::new(0.3, -0.2, 0.1) * (1.0 + frame as f32 * 0.1);
    for frame in 0..12 {
        // In parts, so that a tree that was not refit for some frames is behind by different vertices.
        stage.shift(1, Some(frame % 4), by(frame));
        stage.shift(2, if frame == 7 { None } else { Some(frame % 4) }, by(frame));
        stage.shift(3, None, by(frame));
        let stats = stage.update();
        let nobody_at_2 = (1..9).contains(&frame);
        assert_eq!(stats.objects_waiting, u32::from(nobody_at_2) + 1, "frame {frame}");
        assert_eq!(stage.world.touched(), (0, 0), "no ray was there yet");
        stage.look(&mut random, 1);
        if frame == 8 || frame == 9 {
            stage.look(&mut random, 2);
            assert_eq!(stage.world.touched().0, u64::from(frame == 8), "it waited for these rays");
        }
    }
    // Nothing moves: who waits goes on doing so.
    let stats = stage.update();
    assert_eq!((stats.objects_waiting, stats.objects_refitted, stats.objects_built), (0, 0, 0));
    stage.look(&mut random, 2);
    stage.look(&mut random, 1);
}

#[test]
fn who_is_no_longer_what_it_was_when_it_began_to_wait_is_built() {
    let mut random = Random::new(Random::seed(92));
    let mut stage = Stage::new(&mut random, &[500, 500]);
    stage.update();
    stage.shift(2, None, Vec3::Y);
    assert_eq!(stage.update().objects_waiting, 1);
    let mesh = meshes::soup(&mut random, 700, 0.2);
    stage.scene.apply(Command::DefineObject { name: 2, mesh, motion: Motion::Unstructured });
    assert_eq!(stage.update().objects_built, 1);
    stage.look(&mut random, 2);
    stage.shift(1, None, Vec3::Y);
    assert_eq!(stage.update().objects_waiting, 1);
    stage.scene.apply(Command::SetStrategy { name: 1, strategy: Strategy::Sah });
    assert_eq!(stage.update().objects_built, 1);
    stage.look(&mut random, 1);
}

#[test]
fn motion_that_wears_the_tree_in_every_frame_is_answered_by_builds_alone() {
    let mut random = Random::new(Random::seed(93));
    let mut stage = Stage::new(&mut random, &[4000]);
    stage.update();
    stage.look(&mut random, 1);
    for frame in 0..6 {
        stage.scatter(1, &mut random, 2.0);
        let stats = stage.update();
        assert_eq!((stats.objects_built, stats.objects_refitted), (1, 0), "frame {frame}");
        stage.look(&mut random, 1);
    }
    // Calm again, it is refit again, after a pause.
    let refitted: Vec<u32> = (0..10)
        .map(|_| {
            stage.shift(1, None, Vec3::splat(0.01));
            let stats = stage.update();
            stage.look(&mut random, 1);
            stats.objects_refitted
        })
        .collect();
    assert_eq!(refitted[9], 1, "{refitted:?}");
}

/// Small bodies that fly through each other, as one mesh.
struct Swarm {
    body: Mesh,
    ways: Vec<[Vec3; 2]>,
}

impl Swarm {
    fn new(random: &mut Random) -> Swarm {
        let ways = (0..200).map(|_| [random.vec(), random.vec()]).collect();
        Swarm { body: meshes::uv_sphere(6, 8), ways }
    }

    fn mesh(&self, time: f32) -> Mesh {
        let Mesh { positions, triangles, .. } = &self.body;
        let mut all = Mesh { positions: self.positions(time), ..Mesh::default() };
        for first in (0..all.positions.len() as u32).step_by(positions.len()) {
            all.triangles.extend(triangles.iter().map(|corners| corners.map(|v| first + v)));
        }
        all
    }

    fn positions(&self, time: f32) -> Vec<Vec3> {
        let at = |[from, way]: &[Vec3; 2]| (*from * 2.0 + *way * time).map(|x| 2.0 * x.sin());
        self.ways.iter().flat_map(|way| self.body.positions.iter().map(move |p| at(way) + *p * 0.1)).collect()
    }
}

#[test]
fn bodies_that_part_are_sorted_and_not_built() {
    let mut random = Random::new(Random::seed(94));
    let swarm = Swarm::new(&mut random);
    let mut stage = Stage::of([swarm.mesh(0.0)].into_iter());
    stage.update();
    let (mut built, mut by_rays) = (0, 0);
    for frame in 1..=30 {
        stage.look(&mut random, 1);
        // Few rays: all the same it is not left to them, as they do not sort.
        stage.world.add_traced(1e-6);
        let mut positions = swarm.positions(frame as f32 * 0.1);
        let first = if frame % 3 == 2 {
            // A body alone, in a tree whose nodes may have changed places since the last time.
            positions.truncate(swarm.body.positions.len());
            0
        } else {
            positions.remove(0);
            1
        };
        stage.scene.apply(Command::UpdatePositions { name: 1, first, positions });
        let stats = stage.update();
        built += stats.objects_built;
        by_rays += stats.objects_by_rays;
    }
    stage.look(&mut random, 1);
    assert!(by_rays <= 6, "left to rays in {by_rays} frames");
    assert!(built <= 2, "{built} builds, which rotations save");
}

#[test]
fn large_objects_are_left_to_rays_as_long_as_these_are_few() {
    let mut random = Random::new(Random::seed(95));
    let mut stage = Stage::new(&mut random, &[20_000, 2000, 20_000]);
    stage.update();
    let (few, many) = (1e-6, 1e3);
    let by = Vec3::new(0.3, -0.2, 0.1);
    let frame = |stage: &mut Stage, random: &mut Random, seen: &[u32], part: Option<usize>, traced: f64| {
        seen.iter().for_each(|&name| stage.look(random, name));
        stage.world.add_traced(traced);
        for name in 1..=3 {
            stage.shift(name, part, by);
        }
        let stats = stage.update();
        [stats.objects_built, stats.objects_refitted, stats.objects_waiting, stats.objects_by_rays]
    };
    assert_eq!(frame(&mut stage, &mut random, &[1, 2], None, many), [0, 2, 1, 0], "many rays");
    assert_eq!(
        frame(&mut stage, &mut random, &[1, 2], None, few),
        [1, 1, 1, 1],
        "few: the tree is cut, that of the small object is not"
    );
    assert_eq!(frame(&mut stage, &mut random, &[1, 2], None, few), [0, 2, 1, 1]);
    assert!(stage.world.touched().0 == 0);
    stage.look(&mut random, 1);
    assert!(stage.world.touched().0 > 1, "rays update it in parts");
    for part in 0..4 {
        assert_eq!(frame(&mut stage, &mut random, &[1], Some(part), few)[3], 1, "moved in part it stays so");
    }
    assert_eq!(frame(&mut stage, &mut random, &[1], None, few), [0, 1, 2, 1]);
    assert_eq!(
        frame(&mut stage, &mut random, &[1], None, many),
        [1, 0, 2, 0],
        "what rays lost would have bought a build"
    );
    assert_eq!(frame(&mut stage, &mut random, &[1], None, few), [1, 0, 2, 1], "and again");
    // Looked away from, it waits; looked at again, it is up to date.
    stage.shift(1, None, by);
    stage.shift(1, None, by);
    assert_eq!(stage.update().objects_waiting, 1);
    stage.shift(1, None, by);
    assert_eq!(stage.update().objects_waiting, 1);
    stage.look(&mut random, 1);
}

#[test]
fn a_tree_left_to_rays_that_wears_is_built_anew() {
    let mut random = Random::new(Random::seed(96));
    let mut stage = Stage::new(&mut random, &[10_000]);
    stage.update();
    let mut move_by = |stage: &mut Stage, size: f32| {
        stage.look(&mut random, 1);
        stage.world.add_traced(1e-6);
        stage.scatter(1, &mut random, size);
        let stats = stage.update();
        [stats.objects_built, stats.objects_refitted, stats.objects_by_rays]
    };
    assert_eq!(move_by(&mut stage, 0.01), [1, 0, 1]);
    assert_eq!(move_by(&mut stage, 0.01), [0, 1, 1]);
    // Seen at the next move, when rays have had it updated.
    move_by(&mut stage, 2.0);
    assert_eq!(move_by(&mut stage, 0.01), [1, 0, 0], "worn");
    assert_eq!(move_by(&mut stage, 0.01), [0, 1, 0], "and refit for some moves");
    for _ in 0..5 {
        assert_eq!(move_by(&mut stage, 0.01)[2], 0);
    }
    let later: Vec<_> = (0..4).map(|_| move_by(&mut stage, 0.01)[2]).collect();
    assert_eq!(later[3], 1, "then it is left to rays again: {later:?}");
}
