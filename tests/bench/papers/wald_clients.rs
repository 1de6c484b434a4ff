//! Wald03 table 4: frames per second over clients, in six scenes.
//!
//! *The paper*: one to sixteen clients of two processors each; robots, kitchen, a terrain of 661 trees and the museum with 1,000, 4,000 and 16,000 moving triangles. All
//! but the museum scale to sixteen clients, or to what the server can take in; the museum's changes are sent to every client, which fills the network: 4,000
//! triangles are fastest with four to eight clients.
//!
//! *Here*: BART if it is there, else generated scenes; trees and museum are generated (a soup that mirrors, in a room). Everything over one client is *simulated*
//! from tile times measured on one processor, over the paper's network in proportion ([`crate::cluster`]): once with unicast, as the paper's server, and once with
//! the broadcast that the paper asks for in §8 and our cluster is to have.

use crate::animations;
use crate::cluster::{Sending, Work, pictures};
use crate::options::Options;
use crate::plot::{Panel, Series};
use crate::report::{Report, head};
use crate::stage::Look;
use crate::wald::{Scenes, Show, kitchen, mean_rate, robots};
use crate::{kopta, scenes};
use openrt::api::Result;

const CLIENTS: [usize; 5] = [1, 2, 4, 8, 16];
const FULL: f64 = f64::NAN;

struct Row {
    name: &'static str,
    make: fn(bool) -> Show,
    /// The paper's frames per second by [`Look`]; not a number where pixels filled its network.
    paper: [[f64; 5]; 2],
}

const ROWS: [Row; 6] = [
    Row { name: "Robots", make: robots, paper: [[2.8, 5.55, 10.8, 21.0, FULL], [0.54, 1.07, 2.15, 4.3, 8.6]] },
    Row { name: "Kitchen", make: kitchen, paper: [[3.2, 6.4, 12.8, 25.6, FULL], [0.47, 0.94, 1.88, 3.77, 7.55]] },
    Row {
        name: "Terrain",
        make: |quick| Show::generated(scenes::ALL[2].1, false, 20, quick),
        paper: [[1.3, 2.5, 4.8, 8.0, 15.0], [0.9, 1.77, 3.39, 6.5, 12.0]],
    },
    Row {
        name: "Museum/1k",
        make: |quick| Show::generated(|| animations::museum(1024, 300), true, 300, quick),
        paper: [[2.7, 5.4, 10.2, 19.5, FULL], [0.6, 1.2, 2.4, 4.8, 9.3]],
    },
    Row {
        name: "Museum/4k",
        make: |quick| Show::generated(|| animations::museum(4096, 300), true, 300, quick),
        paper: [[2.5, 4.5, 7.5, 4.5, 2.5], [0.55, 1.1, 2.2, 4.2, 2.5]],
    },
    Row {
        name: "Museum/16k",
        make: |quick| Show::generated(|| animations::museum(16_384, 300), true, 300, quick),
        paper: [[1.6, 2.4, 1.7, 1.0, 0.5], [0.45, 0.9, 1.65, 0.98, 0.53]],
    },
];
/// Part of the paper's scaling that counts as as good.
const NEARLY: f64 = 0.9;

pub fn run(options: &Options, scenes: &mut Scenes, report: &mut Report) {
    head("wald4", "frames per second over clients (simulated from measured tile times)");
    if let Err(error) = try_run(options, scenes, report) {
        report.verdict("wald4", false, &format!("a scene cannot be rendered: {error}"));
    }
}

fn try_run(options: &Options, scenes: &mut Scenes, report: &mut Report) -> Result<()> {
    // How much faster our processors are, by the robots without secondary rays.
    let mut faster = None;
    let mut panels = Vec::new();
    // Least of ours over the paper's, by unicast, and by broadcast.
    let mut worst = [(f64::INFINITY, String::new()), (f64::INFINITY, String::new())];
    for row in &ROWS {
        let measured = scenes.get(row.name, || (row.make)(options.quick))?;
        for ((look, theirs), measured) in Look::BOTH.into_iter().zip(row.paper).zip(measured) {
            let works = measured.works;
            let one = |work: &Work| 1.0 / work.seconds(2);
            let faster = *faster.get_or_insert(mean_rate(&works, one) / theirs[0]);
            let rates = [Sending::Unicast, Sending::Broadcast]
                .map(|sending| CLIENTS.map(|clients| mean_rate(&works, |work| work.rate(clients, sending, faster))));
            println!(
                "{} {}: update {:.2} ms, {:.0} kB",
                row.name,
                look.name(),
                1e3 * works[0].update,
                works[0].bytes / 1e3
            );
            let print = |name: &str, rates: &[f64; 5]| {
                print!("    {name:24}");
                rates.iter().for_each(|r| if r.is_nan() { print!("{:>9}", "26 (*)") } else { print!("{r:>9.2}") });
                println!(
                    "   times one client{}",
                    rates.iter().map(|r| format!("{:>7.2}", r / rates[0])).collect::<String>()
                );
            };
            print("the paper", &theirs);
            print("ours, unicast", &rates[0]);
            print("ours, broadcast", &rates[1]);
            // Where neither server is full of pixels.
            let free = |i: &usize| !theirs[*i].is_nan() && rates[1][*i] < 0.99 * pictures(faster);
            let compared = (0..CLIENTS.len()).rfind(free).unwrap_or(0);
            for ((rates, worst), sending) in rates.iter().zip(&mut worst).zip(["unicast", "broadcast"]) {
                let ratio = rates[compared] / rates[0] / (theirs[compared] / theirs[0]);
                if ratio < worst.0 {
                    *worst = (ratio, format!("{}, {}", row.name, look.name()));
                }
                let mut cells =
                    vec![("scene", row.name.into()), ("look", look.name().into()), ("sending", sending.into())];
                let names = ["fps_1", "fps_2", "fps_4", "fps_8", "fps_16"];
                cells.extend(names.into_iter().zip(rates).map(|(name, &rate)| (name, rate.into())));
                report.row("wald4", &cells);
            }
            if look == Look::Whitted {
                let times = |rates: &[f64; 5]| CLIENTS.map(|c| c as f64).into_iter().zip(rates.map(|r| r / rates[0]));
                let names = ["paper", "ours, unicast", "ours, broadcast"];
                let curves = [&theirs, &rates[0], &rates[1]];
                let series =
                    names.iter().zip(curves).map(|(name, rates)| Series::new(*name, times(rates).collect::<Vec<_>>()));
                panels.push(Panel {
                    title: format!("{}: ray tracing", row.name),
                    x: "clients",
                    y: "times one client",
                    log: false,
                    names: Vec::new(),
                    series: series.collect(),
                });
            }
        }
    }
    println!(
        "(*) the paper's server could not take in more pixels. Our network: the paper's, {:.0} times as fast",
        faster.unwrap_or(1.0)
    );
    kopta::picture(options, "wald4.png", 3, &panels);
    for ((ratio, what), name) in worst.into_iter().zip(["unicast", "broadcast"]) {
        let text = format!(
            "scaling to 16 clients by {name} {ratio:.2}x the paper's at least ({what}; or to as many as fill neither server with pixels; simulated; reached from {NEARLY} on)"
        );
        report.verdict("wald4", ratio >= NEARLY, &text);
    }
    Ok(())
}
