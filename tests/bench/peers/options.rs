//! The command line.

use crate::rays::Kind;
use openrt::scene::Strategy;
use std::path::PathBuf;

pub const USAGE: &str = "\
usage: cargo bench --bench peers -- SUITE [options]
  static           rays per second on S1 … S7
  dynamic          milliseconds per frame, update and trace, of S4 … S7, CROWD and SCULPT, by every strategy
  frames           whole frames of the renderer on S2 and S6, beside batches of as many rays
  single           one ray per call, two threads, batches of 4,096, through the C interface, on S1, S2, S6 and CUBES
  build            nanoseconds per triangle of builders and refit, SAH cost, memory
  splits           what spatial splits give and cost: S1, S4, a tree, beams, needles
  toplevel         time to place 161 … 100,000 instances
  field            the visibility field beside the BSP and the BVH, resting and moving
  bsp              BSPs and grid beside the SAH tree: time per ray, memory, builds
  lazy             complete refits against updates by rays, and partial updates
  calls            nanoseconds per call of the C interface
options:
  --quick          fewer rounds, frames and picture sizes: within two or three minutes
  --threads N      trace with N threads, wall time (1: processor time)
  --json FILE      every figure, also those not printed
  --scene S1,S6    only these; `toplevel` has S2, S3, 10K and 100K
  --kind primary,shadow,bounce
  --strategy A,B   of `dynamic`: only these beside auto, and no peers
  --models PATH    of `bsp`: also this OBJ or PLY file, or those of this folder; may be given several times
  --all            every mode of both engines, not only the best";

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Suite {
    Static,
    Dynamic,
    Frames,
    Build,
    Splits,
    TopLevel,
    Lazy,
    Field,
    Single,
    Bsp,
    Calls,
}

#[derive(Clone, Debug)]
pub struct Options {
    pub suite: Suite,
    pub quick: bool,
    pub all: bool,
    pub threads: usize,
    pub json: Option<PathBuf>,
    /// Model files, and folders with some.
    pub models: Vec<PathBuf>,
    /// Empty: all.
    scenes: Vec<String>,
    kinds: Vec<Kind>,
    /// Empty: all.
    strategies: Vec<Strategy>,
}

impl Options {
    /// # Errors
    /// The text to show instead of running.
    pub fn parse(arguments: impl Iterator<Item = String>) -> Result<Options, String> {
        let mut suite = None;
        let mut options = Options {
            suite: Suite::Static,
            quick: false,
            all: false,
            threads: 1,
            json: None,
            models: Vec::new(),
            scenes: Vec::new(),
            kinds: Kind::ALL.to_vec(),
            strategies: Vec::new(),
        };
        let mut arguments = arguments;
        while let Some(argument) = arguments.next() {
            let mut value = || arguments.next().ok_or_else(|| format!("{argument} needs a value\n{USAGE}"));
            match argument.as_str() {
                // Passed by `cargo bench` itself.
                "--bench" => {}
                "static" => suite = Some(Suite::Static),
                "dynamic" => suite = Some(Suite::Dynamic),
                "frames" => suite = Some(Suite::Frames),
                "build" => suite = Some(Suite::Build),
                "splits" => suite = Some(Suite::Splits),
                "toplevel" => suite = Some(Suite::TopLevel),
                "lazy" => suite = Some(Suite::Lazy),
                "field" => suite = Some(Suite::Field),
                "single" => suite = Some(Suite::Single),
                "bsp" => suite = Some(Suite::Bsp),
                "calls" => suite = Some(Suite::Calls),
                "--quick" => options.quick = true,
                "--all" => options.all = true,
                "--threads" => {
                    let text = value()?;
                    let number = text.parse().ok().filter(|n| (1..=1024).contains(n));
                    options.threads = number.ok_or_else(|| format!("--threads {text}: 1 to 1024"))?;
                }
                "--models" => options.models.push(value()?.into()),
                "--json" => options.json = Some(value()?.into()),
                "--scene" => options.scenes = value()?.split(',').map(|s| s.trim().to_uppercase()).collect(),
                "--kind" => {
                    let named = |name: &str| {
                        Kind::ALL
                            .into_iter()
                            .find(|k| k.name() == name.trim())
                            .ok_or(format!("no kind {name}\n{USAGE}"))
                    };
                    options.kinds = value()?.split(',').map(named).collect::<Result<_, _>>()?;
                }
                "--strategy" => {
                    let named =
                        |name: &str| Strategy::from_name(name.trim()).ok_or(format!("no strategy {name}\n{USAGE}"));
                    options.strategies = value()?.split(',').map(named).collect::<Result<_, _>>()?;
                }
                _ => return Err(USAGE.to_owned()),
            }
        }
        options.suite = suite.ok_or_else(|| USAGE.to_owned())?;
        Ok(options)
    }

    pub fn wants_scene(&self, name: &str) -> bool {
        self.scenes.is_empty() || self.scenes.iter().any(|s| s == name)
    }

    /// The strategies asked for, if not all of them are.
    pub fn strategies(&self) -> Option<&[Strategy]> {
        Some(&self.strategies[..]).filter(|some| !some.is_empty())
    }

    pub fn wants_kind(&self, kind: Kind) -> bool {
        self.kinds.contains(&kind)
    }
}
