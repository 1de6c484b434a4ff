//! The command line.

use std::path::PathBuf;

pub const USAGE: &str = "\
usage: cargo bench --bench papers -- TABLE … [options]
  wald1 wald2      frames per second over processors: kitchen, robots
  wald3            key-framed soup of 64 … 65,536 triangles: time to build anew, bytes to send
  wald4            frames per second over clients, six scenes; what two levels cost a scene that rests
  larsson1         nine deforming bodies: complete refit against updates by rays, at 1x1, 5x5 and 10x10
  larsson2         the same for a soup with a tree per key frame
  khanna2          visibility field: time of a frame over the number of triangles that move
  kopta1           refit and rotations on six animations
  kopta4           time of an update: refit, rotations, rebuild
  kopta5           rotations in animations of 20, 100 and 500 frames
  kopta7           time of a frame and cost of the tree over two rounds of each animation
  all              one after the other
options:
  --quick          short animations and small pictures: all of them in a few minutes
  --threads N      of our side; default 1
  --scene A,B      of kopta1, kopta4 and kopta7, only these animations
  --json FILE      every row
  --pictures DIR   curves as PNG files";

pub const TABLES: [&str; 11] =
    ["wald1", "wald2", "wald3", "wald4", "larsson1", "larsson2", "khanna2", "kopta1", "kopta4", "kopta5", "kopta7"];

#[derive(Clone, Debug)]
pub struct Options {
    pub tables: Vec<&'static str>,
    pub quick: bool,
    pub threads: usize,
    pub json: Option<PathBuf>,
    pub pictures: Option<PathBuf>,
    /// Empty: all.
    scenes: Vec<String>,
}

impl Options {
    /// # Errors
    /// The text to show instead of running.
    pub fn parse(mut arguments: impl Iterator<Item = String>) -> Result<Options, String> {
        let mut options =
            Options { tables: Vec::new(), quick: false, threads: 1, json: None, pictures: None, scenes: Vec::new() };
        while let Some(argument) = arguments.next() {
            let mut value = || arguments.next().ok_or_else(|| format!("{argument} needs a value\n{USAGE}"));
            match argument.as_str() {
                // Passed by `cargo bench` itself.
                "--bench" => {}
                "--quick" => options.quick = true,
                "--threads" => {
                    let text = value()?;
                    let number = text.parse().ok().filter(|n| (1..=1024).contains(n));
                    options.threads = number.ok_or_else(|| format!("--threads {text}: 1 to 1024"))?;
                }
                "--scene" => options.scenes = value()?.split(',').map(|s| s.trim().to_lowercase()).collect(),
                "--json" => options.json = Some(value()?.into()),
                "--pictures" => options.pictures = Some(value()?.into()),
                "all" => options.tables = TABLES.to_vec(),
                name => match TABLES.into_iter().find(|table| *table == name) {
                    Some(table) => options.tables.push(table),
                    None => return Err(format!("{name}?\n{USAGE}")),
                },
            }
        }
        if options.tables.is_empty() { Err(USAGE.to_owned()) } else { Ok(options) }
    }

    pub fn wants_scene(&self, name: &str) -> bool {
        self.scenes.is_empty() || self.scenes.contains(&name.to_lowercase())
    }
}
