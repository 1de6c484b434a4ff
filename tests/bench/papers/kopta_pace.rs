//! Kopta12 figure 5: rotations in the same animation at three paces.
//!
//! *The paper*: a body bursts in 20, 100 or 500 frames; what happens between two frames is the more the fewer they are. Frame times with rotations over the
//! loop; 100 and 500 frames are alike, 20 are somewhat slower, and after a few rounds their tree is almost as good as that of 500.
//!
//! *Here*: the generated body ([`crate::animations`]), played in 20, 100 and 500 frames (20, 50 and 100 in quick runs), the shortest five times over. Where our strategy
//! finds its tree worn it builds it anew, which the paper's never does; how often is printed.

use crate::animate::{self, Frame};
use crate::animations;
use crate::kopta::picture;
use crate::options::Options;
use crate::plot::{Panel, Series};
use crate::report::{Report, head};
use openrt::scene::Strategy;

const PACES: [u32; 3] = [20, 100, 500];
const QUICK_PACES: [u32; 3] = [20, 50, 100];
/// Rounds of the shortest.
const ROUNDS: u32 = 5;
/// How much slower "similar" may be, and how much costlier a tree "almost as good".
const SIMILAR: f64 = 1.15;
const ALMOST: f64 = 1.25;

pub fn run(options: &Options, report: &mut Report) {
    head("kopta5", "rotations in an animation at three paces");
    let animation = animations::ALL.iter().find(|a| a.name == "DragBun").expect("it is one of them");
    let size = if options.quick { [320, 240] } else { [640, 480] };
    println!(
        "{:>7} {:>6} | {:>9} {:>9} {:>9} {:>9} {:>8}",
        "frames", "round", "update", "trace", "total ms", "SAH cost", "rebuilt"
    );
    let paces = if options.quick { QUICK_PACES } else { PACES };
    let mut series = Vec::new();
    // Mean total and cost of the last round of each.
    let mut last = [[0.0; 2]; 3];
    for (i, period) in paces.into_iter().enumerate() {
        let rounds = if i == 0 { ROUNDS } else { 1 };
        let bench = (animation.make)(period);
        let mut runs = animate::run(&bench, &[Strategy::Rotate], [period, rounds * period], size, options.threads);
        let frames = runs.remove(0).frames;
        for (round, part) in frames.chunks(period as usize).enumerate() {
            let mean = |pick: fn(&Frame) -> f64| part.iter().map(pick).sum::<f64>() / part.len() as f64;
            let [update, trace, cost] = [mean(|f| f.update) * 1e3, mean(|f| f.trace) * 1e3, mean(|f| f.cost)];
            last[i] = [update + trace, cost];
            let rebuilt = part.iter().filter(|f| f.built).count();
            println!(
                "{period:>7} {:>6} | {update:>9.2} {trace:>9.2} {:>9.2} {cost:>9.1} {rebuilt:>8}",
                round + 1,
                update + trace
            );
            report.row(
                "kopta5",
                &[
                    ("frames", period.into()),
                    ("round", (round as u32 + 1).into()),
                    ("update_ms", update.into()),
                    ("trace_ms", trace.into()),
                    ("cost", cost.into()),
                    ("rebuilt", (rebuilt as u32).into()),
                ],
            );
            if round == 0 || round as u32 + 1 == rounds {
                let points = part.iter().zip(1..).map(|(f, x)| (f64::from(x) / f64::from(period), f.total() * 1e3));
                let name = if rounds > 1 {
                    format!("{period} frames, round {}", round + 1)
                } else {
                    format!("{period} frames")
                };
                series.push(Series::new(name, points));
            }
        }
    }
    let title = "Kopta12 figure 5: rotations at three paces".to_owned();
    let panel = Panel { title, x: "part of the animation", y: "ms per frame", log: false, names: Vec::new(), series };
    picture(options, "kopta5.png", 1, &[panel]);
    let (alike, cost) = (last[1][0] / last[2][0], last[0][1] / last[2][1]);
    let text = format!(
        "{} frames {alike:.2}x the time of {} (paper: similar, here up to {SIMILAR}), tree of {} after {ROUNDS} rounds {cost:.2}x the cost (paper: almost as good, here up to {ALMOST})",
        paces[1], paces[2], paces[0]
    );
    report.verdict("kopta5", alike <= SIMILAR && cost <= ALMOST, &text);
}
