//! Khanna04 figure 2: the visibility field, over the number of triangles that move.
//!
//! *The paper*: a scene that rests, and more and more dolphins of 564 polygons that move through it; time of a frame on one processor of 2.8 GHz. The figure's numbers are
//! not in the text; what it is said to show is that "the overhead of adding dynamics to the visibility field framework is significant as is the cost of
//! shading".
//!
//! *Here*: a generated room of 51,000 triangles and bodies of 564, one object under `RT_VISIBILITY_FIELD`, whose moving vertices alone are updated; primary and shadow rays, one by
//! one as in the paper, without shading. Subfields of what moves are drawn when a ray asks for them, so their cost is in the rays. Beside it stand the BSP, which the paper
//! sets its method against, and refit. All see the same picture to the bit. There is no goal; how much longer a frame takes with bodies than without is
//! the paper's finding.

use crate::kopta::picture;
use crate::measure::Cost;
use crate::meshes::{icosphere, mesh, moved, uv_sphere};
use crate::options::Options;
use crate::plot::{Panel, Series};
use crate::random::Random;
use crate::rays::{self, View};
use crate::report::{Report, head};
use glam::{Affine3A, Vec3, Vec3Swizzles};
use openrt::accel::TwoLevel;
use openrt::scene::{Command, Instance, Mesh, Motion, Scene, Strategy};
use openrt::simd::Level;
use openrt::threads::Pool;
use openrt::trace::{Ray, Tracer};

const BODIES: [u32; 7] = [0, 1, 2, 4, 8, 16, 32];
const FRAMES: u32 = 12;
const QUICK_FRAMES: u32 = 3;
const STRATEGIES: [(&str, Strategy); 3] =
    [("field", Strategy::VisibilityField), ("bsp", Strategy::Bsp), ("refit", Strategy::Refit)];

/// Forty balls in a box that is open in front.
fn room() -> Mesh {
    let mut random = Random::new(77);
    let mut all = Vec::new();
    for _ in 0..40 {
        let (at, size) = (random.vec() * 0.9, 0.05 + 0.1 * random.unit());
        let ball = moved(icosphere(3), |p| at + p * size);
        all.extend((0..ball.triangles.len() as u32).map(|prim| ball.corners(prim)));
    }
    for n in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::NEG_Z] {
        let u = n.yzx();
        let v = n.cross(u);
        all.extend([[n - u - v, n + u - v, n + u + v], [n - u - v, n + u + v, n - u + v]]);
    }
    mesh(all)
}

/// Where the bodies' vertices are in a frame.
fn swimming(body: &Mesh, bodies: u32, frame: u32) -> Vec<Vec3> {
    let swim = |i: u32, p: Vec3| {
        let phase = i as f32 * 2.4 + frame as f32 * 0.05;
        let wave = Vec3::Y * (0.02 * (p.x * 20.0 + phase * 8.0).sin());
        p + wave + Vec3::new(phase.cos() * 0.7, (i as f32 * 0.61).sin() * 0.8, (phase * 0.7).sin() * 0.7)
    };
    (0..bodies).flat_map(|i| body.positions.iter().map(move |p| swim(i, *p))).collect()
}

pub fn run(options: &Options, report: &mut Report) {
    head("khanna2", "visibility field over the number of triangles that move");
    let pool = Pool::new(Some(1)).expect("a worker thread starts");
    let room = room();
    let body = moved(uv_sphere(7, 47), |p| p * Vec3::new(0.16, 0.05, 0.05));
    let view = View { eye: Vec3::new(0.1, 0.2, 2.4), at: Vec3::ZERO, degrees: 50.0 };
    let primary = rays::primary(&view, if options.quick { [160, 120] } else { [320, 240] });
    println!("{} triangles rest; update + rays in milliseconds per frame", room.triangles.len());
    print!("{:>7} {:>9} |", "bodies", "triangles");
    STRATEGIES.iter().for_each(|(name, _)| print!(" {name:>18}"));
    println!();
    let mut series: Vec<Series> = STRATEGIES.iter().map(|(name, _)| Series::new(*name, [])).collect();
    for bodies in BODIES {
        let moving = bodies * body.triangles.len() as u32;
        print!("{bodies:>7} {moving:>9} |");
        let mut seen = None;
        for ((name, strategy), series) in STRATEGIES.into_iter().zip(&mut series) {
            let (update, trace, hits) = frames(&room, &body, bodies, strategy, &primary, options.quick, &pool);
            assert_eq!(*seen.get_or_insert(hits), hits, "{name} sees another picture");
            print!(" {:>18}", format!("{update:.3} + {trace:.2}"));
            series.points.push((f64::from(moving), update + trace));
            report.row(
                "khanna2",
                &[
                    ("moving", moving.into()),
                    ("strategy", name.into()),
                    ("update_ms", update.into()),
                    ("rays_ms", trace.into()),
                ],
            );
        }
        println!();
    }
    let times = |series: &Series| series.points[BODIES.len() - 1].1 / series.points[0].1;
    let text = format!(
        "a frame with {} bodies takes {:.2}x as long as with none (bsp {:.2}x, refit {:.2}x; paper: significantly longer), same hits",
        BODIES[BODIES.len() - 1],
        times(&series[0]),
        times(&series[1]),
        times(&series[2])
    );
    let title = "Khanna04 figure 2: moving triangles in a room".to_owned();
    let panel = Panel { title, x: "triangles that move", y: "ms per frame", log: true, names: Vec::new(), series };
    picture(options, "khanna2.png", 1, &[panel]);
    report.remark("khanna2", &text);
}

/// Milliseconds per frame of updates and of rays, and how many rays hit in all frames. The first frames, in which structures are made, do not count.
fn frames(
    room: &Mesh,
    body: &Mesh,
    bodies: u32,
    strategy: Strategy,
    primary: &[Ray],
    quick: bool,
    pool: &Pool,
) -> (f64, f64, usize) {
    let first = room.positions.len() as u32;
    let mut all = room.clone();
    all.positions.extend(swimming(body, bodies, 0));
    let count = body.positions.len() as u32;
    all.triangles
        .extend((0..bodies).flat_map(|i| body.triangles.iter().map(move |t| t.map(|v| first + i * count + v))));
    let mut scene = Scene::default();
    scene.apply(Command::DefineObject { name: 1, mesh: all, motion: Motion::Unstructured });
    scene.apply(Command::SetStrategy { name: 1, strategy });
    let mut world = TwoLevel::new(Level::detect());
    let here = [Instance::new(1, Affine3A::IDENTITY)];
    let light = Vec3::new(0.3, 0.85, 0.9);
    let (warm, shown) = (2, if quick { QUICK_FRAMES } else { FRAMES });
    let (mut update, mut trace, mut hits) = (0.0, 0.0, 0);
    for frame in 0..warm + shown {
        if bodies > 0 {
            scene.apply(Command::UpdatePositions { name: 1, first, positions: swimming(body, bodies, frame) });
        }
        let (updating, _) = pool.install(|| Cost::of(|| world.update(&scene, &here)));
        let tracer = Tracer::new(&world);
        let one = |ray: &Ray| {
            let Some(hit) = tracer.intersect(ray) else { return 0 };
            let at = ray.origin + ray.direction * (hit.t * 0.9999);
            1 + usize::from(tracer.occluded(&Ray { tmax: 1.0, ..Ray::new(at, light - at) }))
        };
        let (tracing, found) = pool.install(|| Cost::of(|| primary.iter().map(one).sum::<usize>()));
        hits += found;
        if frame >= warm {
            update += updating.busiest;
            trace += tracing.busiest;
        }
    }
    let ms = 1e3 / f64::from(shown);
    (update * ms, trace * ms, hits)
}
