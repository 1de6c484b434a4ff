//! The tables and figures of the four papers, made again: ours beside theirs, on scenes of the same structure and size.
//!
//! ```sh
//! cargo bench --bench papers -- kopta1 --quick
//! cargo bench --bench papers -- all --quick --pictures target/papers
//! ```
//!
//! Absolute times of machines twenty years apart say nothing: what is compared is ratios within one run, theirs and ours. Every table ends
//! with a verdict: the goal, and whether it is reached. What the paper measured, on what, and where we differ stands in the head of
//! the table's file: [`kopta`] (table 1, figures 4 and 7),
//! [`kopta_pace`] (figure 5), [`khanna`] (figure 2), [`larsson`],
//! [`wald`] (tables 1 and 2), [`wald_soup`] (table 3), [`wald_clients`] (table 4) and [`wald_levels`] (§6).
//!
//! Build it without `CARGO_INCREMENTAL`, as the other bench.

mod animate;
mod animations;
mod bart;
mod bounce;
mod cluster;
mod khanna;
mod kopta;
mod kopta_pace;
mod larsson;
#[allow(dead_code, unused_imports, reason = "of the library, with its tests")]
mod load;
#[allow(dead_code, reason = "shared with the other bench")]
#[path = "../common/measure.rs"]
mod measure;
#[allow(dead_code, reason = "shared with the tests")]
#[path = "../../common/meshes.rs"]
mod meshes;
mod options;
#[allow(dead_code, reason = "shared with the other bench")]
#[path = "../common/ours.rs"]
mod ours;
mod plot;
#[path = "../../../src/quiet/mod.rs"]
#[allow(unused_imports, reason = "its test runs with the library's")]
mod quiet;
#[allow(dead_code, reason = "shared with the tests")]
#[path = "../../common/random.rs"]
mod random;
#[allow(dead_code, reason = "shared with the other bench")]
#[path = "../common/rays.rs"]
mod rays;
mod report;
#[allow(dead_code, reason = "shared with the other bench")]
#[path = "../common/scenes/mod.rs"]
mod scenes;
mod stage;
#[path = "../common/start.rs"]
mod start;
mod wald;
mod wald_clients;
mod wald_levels;
mod wald_soup;

// The reader of AFF files is a part of the library, and names its API as such.
use openrt::api;
use options::Options;
use std::process::ExitCode;

fn main() -> ExitCode {
    let options = match start::options(options::USAGE, Options::parse) {
        Ok(options) => options,
        Err(code) => return code,
    };
    println!("{} thread(s); milliseconds of processor time unless something else is said", options.threads);
    let mut report = report::Report::default();
    let mut scenes = wald::Scenes::default();
    let mut animations = kopta::Runs::default();
    for table in &options.tables {
        match *table {
            "kopta1" => kopta::table_1(&options, &mut animations, &mut report),
            "kopta4" => kopta::figure_4(&options, &mut animations, &mut report),
            "kopta7" => kopta::figure_7(&options, &mut animations, &mut report),
            "kopta5" => kopta_pace::run(&options, &mut report),
            "larsson1" => larsson::table_1(&options, &mut report),
            "larsson2" => larsson::table_2(&options, &mut report),
            "wald1" => wald::table_1(&options, &mut scenes, &mut report),
            "wald2" => wald::table_2(&options, &mut scenes, &mut report),
            "wald4" => {
                wald_clients::run(&options, &mut scenes, &mut report);
                wald_levels::run(&options, &mut report);
            }
            "wald3" => wald_soup::run(&options, &mut report),
            "khanna2" => khanna::run(&options, &mut report),
            _ => unreachable!("the command line knows the tables"),
        }
    }
    report.end();
    start::end(options.json.as_deref(), || report.json())
}
