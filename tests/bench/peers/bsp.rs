//! `-- bsp`: time per ray of the BSP, built carefully and fast, and of the grid, as multiples of the SAH tree's; bytes per triangle and time of the builds.
//!
//! Twelve generated meshes, of kinds that real ones are: scanned, of cloth, drawn, built, grown, and soups. `--models` adds files. Rays go from anywhere in a
//! box of twice the size to anywhere in the mesh's box, as the programs of users do that test visibility, and from anywhere in it in any
//! direction, as bounces do; each ray by a call of its own, and all as one batch. One thread. A figure is the sum over both kinds.

use crate::measure::{Column, Cost, Lane, race};
use crate::options::Options;
use crate::ours::{ClosestWorker, MODES};
use crate::random::Random;
use crate::scenes::{FRAMES, moving};
use crate::splits::{frame, needles, part};
use crate::{model_files, places};
use glam::{Affine3A, Vec3};
use openrt::accel::{Structure, TwoLevel};
use openrt::scene::{Command, Instance, Mesh, Motion, Scene, Strategy};
use openrt::simd::Level;
use openrt::threads::Pool;
use openrt::trace::{Ray, Tracer};

const ROUNDS: usize = 9;
const QUICK_ROUNDS: usize = 3;
/// Of each kind.
const RAYS: usize = 20_000;

type Make = fn() -> Mesh;

const GENERATED: [(&str, Make); 12] = [
    ("statue", places::statue),
    ("blob", || part("S5", 0)),
    ("terrain", places::terrain),
    ("cloth", hanging_cloth),
    ("machine", || places::machine(&mut Random::new(33))),
    ("frame", || frame(&mut Random::new(31))),
    ("hall", places::hall),
    ("stadium", places::stadium),
    ("tree", || part("S3", 1)),
    ("hair", || places::hair(&mut Random::new(34))),
    ("needles", || needles(&mut Random::new(32))),
    ("spheres", || part("S7", 0)),
];

/// The cloth of S6 at the end of its fall.
fn hanging_cloth() -> Mesh {
    let cloth = &moving::cloth().parts[0];
    Mesh { positions: (cloth.positions)(FRAMES - 1), triangles: cloth.triangles.clone(), ..Mesh::default() }
}

/// Who races: the first is what the others are measured by. With the most that they may take.
const STRUCTURES: [(&str, Strategy, Motion, f64); 4] = [
    ("SAH", Strategy::Sah, Motion::Affine, 1.0),
    ("BSP", Strategy::Bsp, Motion::Affine, 3.0),
    ("fast BSP", Strategy::Bsp, Motion::Unstructured, 6.0),
    ("grid", Strategy::Grid, Motion::Unstructured, 6.0),
];

pub fn run(options: &Options) -> String {
    let pool = Pool::new(Some(1)).expect("a worker thread starts");
    let rounds = if options.quick { QUICK_ROUNDS } else { ROUNDS };
    let mut meshes: Vec<(String, Mesh)> = Vec::new();
    for (name, make) in GENERATED {
        if options.wants_scene(&name.to_uppercase()) {
            meshes.push((name.to_owned(), make()));
        }
    }
    if options.models.is_empty() {
        println!("NO MODELS: --models FILE_OR_FOLDER adds OBJ and PLY files. Generated meshes only.");
    }
    for file in options.models.iter().flat_map(|path| model_files::files(path)) {
        let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        match model_files::read(&file) {
            Ok(mesh) => meshes.push((name, mesh)),
            Err(why) => println!("LEFT OUT: {}: {why}", file.display()),
        }
    }
    println!(
        "{:16} {:>9} {:>7} {:>7} |{}",
        "mesh",
        "triangles",
        "ns/ray",
        "batch",
        STRUCTURES[1..].iter().map(|s| format!("{:>9} {:>6}", s.0, "batch")).collect::<String>()
            + " | bytes per triangle  | us per triangle built"
    );
    let mut worst = vec![(0.0f64, String::new()); STRUCTURES.len()];
    let mut json = Vec::new();
    for (name, mesh) in &meshes {
        let row = Row::measure(mesh, &pool, rounds);
        print!("{name:16.16} {:>9} {:>7.0} {:>7.0} |", mesh.triangles.len(), row.ns[0][0], row.ns[0][1]);
        for (ns, worst) in row.ns.iter().zip(&mut worst).skip(1) {
            let ratios = [0, 1].map(|mode| ns[mode] / row.ns[0][mode]);
            print!("{:>9.2} {:>6.2}", ratios[0], ratios[1]);
            for (ratio, mode) in ratios.into_iter().zip(["", " in batches"]) {
                if ratio > worst.0 {
                    *worst = (ratio, format!("{name}{mode}"));
                }
            }
        }
        println!(
            " |{} |{}",
            row.bytes.map(|b| format!("{b:>5.0}")).join(""),
            row.build.map(|b| format!("{b:>6.2}")).join("")
        );
        json.push(format!(
            r#"  {{"mesh": "{name}", "triangles": {}, "ns": {:?}, "bytes": {:?}, "build": {:?}}}"#,
            mesh.triangles.len(),
            row.ns,
            row.bytes,
            row.build
        ));
    }
    let verdict = |((name, _, _, most), (ratio, mesh)): (&(&str, Strategy, Motion, f64), &(f64, String))| {
        let reached = if ratio <= most { "reached" } else { "MISSED" };
        format!("{name} {ratio:.2} ({mesh}; at most {most}: {reached})")
    };
    let verdicts: Vec<String> = STRUCTURES.iter().zip(&worst).skip(1).map(verdict).collect();
    println!("worst ratio {}", verdicts.join(", "));
    format!("[\n{}\n]\n", json.join(",\n"))
}

struct Row {
    /// Per structure, ray by ray and in batches.
    ns: [[f64; 2]; 4],
    bytes: [f64; 4],
    /// Microseconds per triangle.
    build: [f64; 4],
}

impl Row {
    fn measure(mesh: &Mesh, pool: &Pool, rounds: usize) -> Row {
        let count = mesh.triangles.len() as f64;
        let mut row = Row { ns: [[0.0; 2]; 4], bytes: [0.0; 4], build: [f64::INFINITY; 4] };
        let worlds: Vec<TwoLevel> = STRUCTURES
            .iter()
            .zip(&mut row.build)
            .map(|((_, strategy, motion, _), build)| {
                let (cost, world) = Cost::of(|| world(mesh, pool, *strategy, *motion));
                *build = cost.all * 1e6 / count;
                world
            })
            .collect();
        for (bytes, world) in row.bytes.iter_mut().zip(&worlds) {
            *bytes = world.objects()[0].memory_bytes() as f64 / count;
        }
        for rays in rays(&worlds[0]) {
            for (mode, way) in MODES.iter().enumerate() {
                let lane = |view| {
                    Lane::new(way.name, Column::OursSingle, move || {
                        let tracer = Tracer::new(view);
                        Box::new(ClosestWorker { tracer, call: way.closest, rays: Vec::new(), found: Vec::new() })
                    })
                };
                let mut lanes: Vec<Lane> = worlds.iter().map(|world| &**world.view()).map(lane).collect();
                race(&mut lanes, &rays, 1, rounds);
                for (lane, ns) in lanes.iter().zip(&mut row.ns) {
                    assert_eq!(lane.hits, lanes[0].hits, "the same rays hit");
                    ns[mode] += lane.seconds * 1e9 / (2 * rays.len()) as f64;
                }
            }
        }
        row
    }
}

/// Rays towards the mesh, and rays in it.
fn rays(world: &TwoLevel) -> [Vec<Ray>; 2] {
    let bounds = world.objects()[0].bounds();
    let (center, half) = (bounds.center(), bounds.extent() * 0.5);
    let mut random = Random::new(3);
    let outside = (0..RAYS).map(|_| {
        let org = center + random.vec() * half * 2.0;
        Ray::new(org, center + random.vec() * half - org)
    });
    let outside = outside.collect();
    let inside =
        (0..RAYS).map(|_| Ray::new(center + random.vec() * half, random.vec().normalize_or(Vec3::X))).collect();
    [outside, inside]
}

/// The mesh by a strategy, all that rays ask for built.
fn world(mesh: &Mesh, pool: &Pool, strategy: Strategy, motion: Motion) -> TwoLevel {
    let mut scene = Scene::default();
    scene.apply(Command::DefineObject { name: 1, mesh: mesh.clone(), motion });
    let mut world = TwoLevel::new(Level::detect());
    world.force_strategy(Some(strategy));
    pool.install(|| world.update(&scene, &[Instance::new(1, Affine3A::IDENTITY)]));
    if let Structure::Bsp(bsp) = world.objects()[0].structure() {
        assert!(bsp.tree().is_some(), "there is memory for a tree");
    }
    world
}
