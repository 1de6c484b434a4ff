//! Wald03 table 3: the time to build a soup's BSP anew, and what has to be sent, for 64 to 65,536 triangles.
//!
//! *The paper*: the museum's triangles fly between five shapes; their object is built anew in every frame with the leaf threshold that grows with depth (§4.3). From under
//! a millisecond for 64 triangles to more than a second for 65,536; 100 bytes per triangle go to every client. Uniformly spread triangles are
//! the worst case; those of a surface are built much faster.
//!
//! *Here*: a generated soup of the same number of triangles and as much area, at times spread over the animation. `RT_BSP` of an unstructured object is
//! built by the first ray; its figure is the update with that ray. Beside it are other strategies. Vertices alone are sent: 36 bytes per triangle.

use crate::measure::Cost;
use crate::options::Options;
use crate::report::{Report, head};
use crate::scenes::moving::Soup;
use glam::{Affine3A, Vec3};
use openrt::accel::TwoLevel;
use openrt::scene::{Command, Instance, Mesh, Motion, Scene, Strategy};
use openrt::simd::Level;
use openrt::threads::Pool;
use openrt::trace::{Ray, Tracer};

const SIZES: [usize; 6] = [64, 256, 1024, 4096, 16_384, 65_536];
/// Milliseconds; the first is stated as less, the last as more.
const PAPER: [f64; 6] = [1.0, 2.0, 8.0, 34.0, 100.0, 1000.0];
const PAPER_BYTES: f64 = 100.0;
const STRATEGIES: [Strategy; 5] =
    [Strategy::Bsp, Strategy::Grid, Strategy::FastBuild, Strategy::Rotate, Strategy::Refit];
/// Of the animation; the first is uniformly spread.
const TIMES: [f32; 6] = [0.0, 0.5, 1.0, 2.0, 3.0, 4.0];

pub fn run(options: &Options, report: &mut Report) {
    head("wald3", "a soup built anew, over its size");
    let pool = Pool::new(Some(options.threads)).expect("worker threads start");
    print!("{:>9} | {:>9}", "triangles", "paper");
    STRATEGIES.iter().for_each(|s| print!(" {:>9}", s.name()));
    println!(" | {:>8} | {:>9} {:>9}", "ns/tri", "bytes", "paper");
    let mut per_triangle = Vec::new();
    for (count, paper) in SIZES.into_iter().zip(PAPER) {
        let soup = Soup::new(count);
        let ms = STRATEGIES.map(|strategy| 1e3 * seconds(&soup, strategy, &pool, if options.quick { 2 } else { 6 }));
        let shown = match count {
            64 => "< 1".to_owned(),
            65_536 => "> 1000".to_owned(),
            _ => format!("{paper:.0}"),
        };
        print!("{count:>9} | {shown:>9}");
        ms.iter().for_each(|ms| print!(" {ms:>9.3}"));
        println!(" | {:>8.0} | {:>9} {:>9.0}", ms[0] * 1e6 / count as f64, 36 * count, PAPER_BYTES * count as f64);
        per_triangle.push(ms[0] / count as f64);
        let mut cells = vec![("triangles", (count as u32).into()), ("paper_ms", paper.into())];
        cells.extend(STRATEGIES.iter().zip(ms).map(|(s, ms)| (s.name(), ms.into())));
        report.row("wald3", &cells);
    }
    let ours = per_triangle[5] / per_triangle[3];
    let paper = PAPER[5] / PAPER[3] / 16.0;
    let text = format!(
        "RT_BSP takes {ours:.2}x as long per triangle for 65,536 as for 4,096 (paper: more than {paper:.1}x); 36 bytes per triangle (paper: 100)"
    );
    report.verdict("wald3", ours <= paper, &text);
}

/// Seconds of an update and a first ray, the mean over [`TIMES`].
fn seconds(soup: &Soup, strategy: Strategy, pool: &Pool, rounds: u32) -> f64 {
    let mut scene = Scene::default();
    let mesh = Mesh { positions: soup.corners(0.2), triangles: soup.triangles(), ..Mesh::default() };
    scene.apply(Command::DefineObject { name: 1, mesh, motion: Motion::Unstructured });
    scene.apply(Command::SetStrategy { name: 1, strategy });
    let mut world = TwoLevel::new(Level::detect());
    let here = [Instance::new(1, Affine3A::IDENTITY)];
    let mut best = [f64::INFINITY; TIMES.len()];
    for round in 0..=rounds {
        for (best, time) in best.iter_mut().zip(TIMES) {
            scene.apply(Command::UpdatePositions { name: 1, first: 0, positions: soup.corners(time) });
            let ray = Ray::new(Vec3::new(0.1, 0.2, 5.0), Vec3::NEG_Z);
            let build = || {
                world.update(&scene, &here);
                Tracer::new(&world).intersect(&ray)
            };
            let (cost, _) = pool.install(|| Cost::of(build));
            if round > 0 {
                *best = best.min(cost.busiest);
            }
        }
    }
    best.iter().sum::<f64>() / TIMES.len() as f64
}
