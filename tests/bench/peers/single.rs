//! `-- single`: rays one by one and in small batches, through the interfaces that programs call.
//!
//! Both engines get one ray per call, in the order of the picture: `rtIntersectRays(1, …)` and, in a snapshot, `rtSceneIntersect(scene, 1, …)` beside
//! `rtcIntersect1`. A ray and its hit are written before each call on both sides, as a program does that comes from elsewhere. Then two threads at a time ask one snapshot, by
//! wall clock; and batches of 4,096 go through the C interface and straight into the engine, both on one thread. Best of the rounds, which alternate; processor time of
//! the thread but for the two threads.

use crate::embree::{Context as PeerContext, Embree, Handle, NO_GEOMETRY, Quality};
use crate::measure::{thread_seconds, wall_seconds};
use crate::options::Options;
use crate::ours::Ours;
use crate::rays;
use crate::scenes::{self, BenchScene, Part, Placement};
use glam::{Affine3A, Quat, Vec3};
use openrt::capi::*;
use openrt::scene::{Mesh, Motion};
use openrt::threads::Pool;
use openrt::trace::{Hit, Ray, Tracer};
use std::ffi::c_void;

const ROUNDS: usize = 9;
const QUICK_ROUNDS: usize = 5;
const BATCH: usize = 4096;
const SCENES: [&str; 3] = ["S1", "S2", "S6"];

pub fn run(options: &Options, embree: Option<&Embree>) -> String {
    println!(
        "one ray per call: time of ours over the peer's; two threads over one; batches of {BATCH} over the engine's own"
    );
    println!(
        "{:5} {:8}| {:>8} {:>8} {:>8} {:>8} {:>8} | {:>9} {:>9}",
        "", "rays", "context", "snapshot", "ns", "peer ns", "occluded", "2 threads", "batches"
    );
    let mut bench =
        Bench { rounds: if options.quick { QUICK_ROUNDS } else { ROUNDS }, embree, json: Vec::new(), worst: 0.0 };
    for (name, make) in scenes::ALL {
        if SCENES.contains(&name) && options.wants_scene(name) {
            bench.one_scene(&make());
        }
    }
    if options.wants_scene("CUBES") {
        bench.one_scene(&cubes());
    }
    if bench.worst > 0.0 {
        println!("worst ratio {:.2} (one ray per call, ours over the peer's)", bench.worst);
    }
    format!("[\n{}\n]\n", bench.json.join(",\n"))
}

struct Bench<'a> {
    rounds: usize,
    embree: Option<&'a Embree>,
    json: Vec<String>,
    worst: f64,
}

/// A thousand instances of a cube, turned.
fn cubes() -> BenchScene {
    let corner = |i: usize| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) - 0.5;
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let mesh = Mesh { positions: (0..8).map(corner).collect(), triangles, ..Mesh::default() };
    let place = |i: u32| {
        let at = Vec3::new((i % 10) as f32, (i / 10 % 10) as f32, (i / 100) as f32) * 2.0 - 9.0;
        let turn = Quat::from_axis_angle(Vec3::new(1.0, 2.0, 3.0).normalize(), i as f32 * 0.37);
        Placement { part: 0, transform: Affine3A::from_rotation_translation(turn, at) }
    };
    BenchScene {
        name: "CUBES",
        title: "1,000 instances of a cube",
        parts: vec![Part::rigid(mesh, Motion::Affine)],
        place: Box::new(move |_| (0..1000).map(place).collect()),
        instanced: true,
        view: rays::View { eye: Vec3::new(18.0, 14.0, 26.0), at: Vec3::ZERO, degrees: 45.0 },
        light: Vec3::new(0.0, 40.0, 10.0),
        sizes: vec![[320, 240]],
    }
}

impl Bench<'_> {
    fn one_scene(&mut self, bench: &BenchScene) {
        let pool = Pool::new(Some(1)).expect("a worker thread starts");
        let ours = Ours::new(bench, 0, &pool);
        let primary = rays::primary(&bench.view, bench.sizes[0]);
        let offset = 1e-4 * bench.view.eye.distance(bench.view.at);
        let (_, bounce) = rays::secondary(&ours, &primary, bench.light, offset);
        let device = self.embree.map(|embree| (embree, embree.device(1)));
        let built = device.as_ref().map(|(embree, device)| (*embree, device.build(bench, 0, Quality::Medium, 0)));
        let peer = built.as_ref().map(|(embree, built)| (*embree, built.top.handle));
        define(bench);
        let scene = rtAcquireScene();
        assert!(!scene.is_null(), "a snapshot");
        for (kind, rays) in [("primary", &primary), ("bounce", &bounce)] {
            self.one_kind(bench.name, kind, rays, scene, peer, &ours);
        }
        // SAFETY: nobody asks it any more.
        unsafe { rtReleaseScene(scene) };
        rtExit();
    }

    fn one_kind(
        &mut self,
        name: &str,
        kind: &str,
        rays: &[Ray],
        scene: RTscene,
        peer: Option<(&Embree, Handle)>,
        ours: &Ours,
    ) {
        let asked: Vec<RTray> = rays.iter().map(ray_of).collect();
        let shared = Shared(scene);
        let mut best = Times::default();
        let (mut batch_hits, mut engine_hits) = (vec![RThit::default(); BATCH], vec![Hit::MISS; BATCH]);
        for _ in 0..self.rounds {
            best.context.take(thread_seconds, || context_one_by_one(&asked));
            best.snapshot.take(thread_seconds, || one_by_one(&shared, &asked));
            best.occluded.take(thread_seconds, || occluded_one_by_one(&shared, &asked));
            if let Some((embree, handle)) = peer {
                best.peer.take(thread_seconds, || peer_one_by_one(embree, handle, &asked));
                best.peer_occluded.take(thread_seconds, || peer_occluded_one_by_one(embree, handle, &asked));
            }
            best.one.take(wall_seconds, || one_by_one(&shared, &asked));
            best.two.take(wall_seconds, || {
                std::thread::scope(|threads| {
                    let other = threads.spawn(|| one_by_one(&shared, &asked));
                    one_by_one(&shared, &asked) + other.join().expect("no panic")
                })
            });
            best.batches.take(wall_seconds, || {
                for rays in asked.chunks(BATCH) {
                    // SAFETY: as many rays as the slice has, and room for as many hits.
                    unsafe { rtIntersectRays(rays.len() as RTsizei, rays.as_ptr(), batch_hits.as_mut_ptr(), 0) };
                }
                count(&batch_hits)
            });
            let tracer: Tracer = ours.tracer();
            best.engine.take(wall_seconds, || {
                rays.chunks(BATCH).for_each(|rays| tracer.intersect_into(rays, &mut engine_hits[..rays.len()]));
                engine_hits.iter().filter(|hit| !hit.is_miss()).count()
            });
        }
        assert_eq!((best.context.hits, best.batches.hits), (best.snapshot.hits, best.engine.hits), "{name}, {kind}");
        assert_eq!(rtGetError(), RT_NO_ERROR, "{name}, {kind}");
        let ratio = |ours: &Best, other: &Best| ours.seconds / other.seconds;
        let nanoseconds = |best: &Best| best.seconds / rays.len() as f64 * 1e9;
        let [context, snapshot] = [&best.context, &best.snapshot].map(|ours| ratio(ours, &best.peer));
        let occluded = ratio(&best.occluded, &best.peer_occluded);
        let (two, batches) = (2.0 * ratio(&best.one, &best.two), ratio(&best.engine, &best.batches));
        println!(
            "{name:5} {kind:8}| {context:>8.2} {snapshot:>8.2} {:>8.0} {:>8.0} {occluded:>8.2} | {two:>9.2} {batches:>9.2}",
            nanoseconds(&best.context),
            nanoseconds(&best.peer)
        );
        if peer.is_some() {
            self.worst = self.worst.max(context).max(snapshot);
        }
        self.json.push(format!(
            r#"  {{"scene": "{name}", "kind": "{kind}", "context": {context:.4}, "snapshot": {snapshot:.4}, "occluded": {occluded:.4}, "threads": {two:.4}, "batches": {batches:.4}}}"#
        ));
    }
}

/// The best time of a way, and what it found.
struct Best {
    seconds: f64,
    hits: usize,
}

impl Default for Best {
    fn default() -> Self {
        Self { seconds: f64::INFINITY, hits: 0 }
    }
}

impl Best {
    fn take(&mut self, clock: fn() -> f64, work: impl FnOnce() -> usize) {
        let begin = clock();
        self.hits = work();
        self.seconds = self.seconds.min(clock() - begin);
    }
}

#[derive(Default)]
struct Times {
    context: Best,
    snapshot: Best,
    occluded: Best,
    peer: Best,
    peer_occluded: Best,
    one: Best,
    two: Best,
    batches: Best,
    engine: Best,
}

/// A snapshot for two threads.
struct Shared(RTscene);

// SAFETY: any thread may ask a snapshot, says the manual.
unsafe impl Sync for Shared {}

fn ray_of(ray: &Ray) -> RTray {
    RTray { origin: ray.origin.into(), tmin: ray.tmin, direction: ray.direction.into(), tmax: ray.tmax }
}

fn count(hits: &[RThit]) -> usize {
    hits.iter().filter(|hit| hit.t >= 0.0).count()
}

fn context_one_by_one(rays: &[RTray]) -> usize {
    let mut found = 0;
    for ray in rays {
        let (ray, mut hit) = (*ray, RThit::default());
        // SAFETY: one ray, and room for one hit.
        unsafe { rtIntersectRays(1, &raw const ray, &raw mut hit, 0) };
        found += usize::from(hit.t >= 0.0);
    }
    found
}

fn one_by_one(scene: &Shared, rays: &[RTray]) -> usize {
    let mut found = 0;
    for ray in rays {
        let (ray, mut hit) = (*ray, RThit::default());
        // SAFETY: a snapshot that lives; one ray, and room for one hit.
        unsafe { rtSceneIntersect(scene.0, 1, &raw const ray, &raw mut hit, 0) };
        found += usize::from(hit.t >= 0.0);
    }
    found
}

fn occluded_one_by_one(scene: &Shared, rays: &[RTray]) -> usize {
    let mut found = 0;
    for ray in rays {
        let (ray, mut dark) = (*ray, RT_FALSE);
        // SAFETY: a snapshot that lives; one ray, and room for one answer.
        unsafe { rtSceneOccluded(scene.0, 1, &raw const ray, &raw mut dark, 0) };
        found += usize::from(dark);
    }
    found
}

/// `RTCRayHit`.
#[repr(C, align(16))]
struct PeerRay([u32; 20]);

impl PeerRay {
    fn new(ray: &RTray) -> Self {
        let [x, y, z] = ray.origin.map(f32::to_bits);
        let [dx, dy, dz] = ray.direction.map(f32::to_bits);
        let (near, far) = (ray.tmin.to_bits(), ray.tmax.to_bits());
        let none = NO_GEOMETRY;
        Self([x, y, z, near, dx, dy, dz, 0, far, u32::MAX, 0, 0, 0, 0, 0, 0, 0, none, none, none])
    }
}

fn peer_one_by_one(embree: &Embree, scene: Handle, rays: &[RTray]) -> usize {
    let mut context = PeerContext::new(false);
    let mut found = 0;
    for ray in rays {
        let mut ray = PeerRay::new(ray);
        // SAFETY: a committed scene, and a ray with its hit.
        unsafe { (embree.intersect1)(scene, &raw mut context, ray.0.as_mut_ptr()) };
        found += usize::from(ray.0[18] != NO_GEOMETRY);
    }
    found
}

fn peer_occluded_one_by_one(embree: &Embree, scene: Handle, rays: &[RTray]) -> usize {
    let mut context = PeerContext::new(false);
    let mut found = 0;
    for ray in rays {
        let mut ray = PeerRay::new(ray);
        // SAFETY: a committed scene, and a ray.
        unsafe { (embree.occluded1)(scene, &raw mut context, ray.0.as_mut_ptr()) };
        found += usize::from(f32::from_bits(ray.0[8]) < 0.0);
    }
    found
}

/// Defines the scene in a context of one thread, which becomes current, by the C interface.
fn define(bench: &BenchScene) {
    // SAFETY: no other thread reads the environment now.
    unsafe { std::env::set_var("OPENRT_NUM_THREADS", "1") };
    // SAFETY: no arguments.
    unsafe { rtInit(std::ptr::null_mut(), std::ptr::null_mut()) };
    let first = rtGenObjects(bench.parts.len() as RTsizei);
    for (name, part) in (first..).zip(&bench.parts) {
        let positions = (part.positions)(0);
        let motion = match part.motion {
            Motion::Static => RT_STATIC,
            Motion::Affine => RT_AFFINE,
            Motion::Unstructured => RT_UNSTRUCTURED,
        };
        rtNewObject(name, RT_COMPILE | motion);
        rtEnableClientState(RT_VERTEX_ARRAY);
        let indices = part.triangles.as_flattened();
        // SAFETY: three floats per vertex, and indices below their number.
        unsafe {
            rtVertexPointer(3, RT_FLOAT, 0, positions.as_ptr().cast::<c_void>());
            rtDrawElements(RT_TRIANGLES, indices.len() as RTsizei, RT_UNSIGNED_INT, indices.as_ptr().cast::<c_void>());
        }
        rtEndObject();
    }
    for placement in (bench.place)(0) {
        let m = glam::Mat4::from(placement.transform).to_cols_array();
        // SAFETY: sixteen floats.
        unsafe { rtLoadMatrixf(m.as_ptr()) };
        rtInstantiateObject(first + placement.part as u32);
    }
    rtCommitScene();
    assert_eq!(rtGetError(), RT_NO_ERROR, "{} is defined", bench.name);
}
