//! openrt beside Embree: the same scenes, the same rays, one process, interleaved rounds.
//!
//! ```sh
//! cargo bench --bench peers -- static     # rays per second
//! cargo bench --bench peers -- --help     # the rest
//! ```
//!
//! Embree (`libembree3`) is loaded at run time. Without it only our own figures are printed, and the bench says so.
//! Build it without `CARGO_INCREMENTAL`: the many units of incremental builds prevent inlining (S2: 2.3 instead of 4.7 Mrays/s).
//!
//! How is measured stands in the head of [`measure`], what in those of [`static_scenes`], [`dynamic`], [`frames`], [`single`], [`builders`], [`splits`], [`bsp`], [`toplevel`] and [`calls`].

mod bsp;
mod builders;
mod calls;
mod dynamic;
mod embree;
mod field;
mod frames;
mod lanes;
mod lazy;
#[path = "../common/measure.rs"]
mod measure;
#[allow(dead_code, reason = "shared with the tests")]
#[path = "../../common/meshes.rs"]
mod meshes;
#[path = "../common/model_files.rs"]
mod model_files;
mod options;
#[path = "../common/ours.rs"]
mod ours;
#[allow(dead_code, reason = "shared with the tests")]
#[path = "../../common/places.rs"]
mod places;
#[allow(dead_code, reason = "shared with the tests")]
#[path = "../../common/random.rs"]
mod random;
#[path = "../common/rays.rs"]
mod rays;
mod report;
#[path = "../common/scenes/mod.rs"]
mod scenes;
mod single;
mod splits;
#[path = "../common/start.rs"]
mod start;
mod static_scenes;
mod toplevel;

use options::{Options, Suite};
use std::process::ExitCode;

fn main() -> ExitCode {
    let options = match start::options(options::USAGE, Options::parse) {
        Ok(options) => options,
        Err(code) => return code,
    };
    let embree = match embree::Embree::load() {
        Ok(embree) => Some(embree),
        Err(why) => {
            println!("NO PEER: {why}. Only our own figures follow.");
            None
        }
    };
    let json = match options.suite {
        Suite::Static => static_scenes::run(&options, embree.as_ref()),
        Suite::Dynamic => dynamic::run(&options, embree.as_ref()),
        Suite::Build => builders::run(&options, embree.as_ref()),
        Suite::Frames => frames::run(&options, embree.as_ref()),
        Suite::Splits => splits::run(&options),
        Suite::TopLevel => toplevel::run(&options, embree.as_ref()),
        Suite::Lazy => lazy::run(&options),
        Suite::Field => field::run(&options),
        Suite::Single => single::run(&options, embree.as_ref()),
        Suite::Bsp => bsp::run(&options),
        Suite::Calls => calls::run(&options),
    };
    start::end(options.json.as_deref(), || json)
}
