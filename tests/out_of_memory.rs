//! What happens when memory runs out: every allocation of the C library fails once, in turn, and with all after it.
//!
//! `c/out_of_memory.c` brings its own `malloc`, and sweeps. What aborts ends it, so it is begun anew behind that place.

#[cfg(all(target_os = "linux", target_env = "gnu"))]
#[path = "common/c.rs"]
mod c;

#[cfg(all(target_os = "linux", target_env = "gnu"))]
mod sweeps {
    use super::c;
    use std::path::{Path, PathBuf};
    use std::process::Command;
    use std::sync::LazyLock;

    const SCENARIOS: [&str; 10] =
        ["init", "shaders", "objects", "first", "steady", "moved", "again", "beside", "queries", "images"];
    const LARGE: usize = 1024;

    /// The program in its folder; None where there is no compiler.
    fn program() -> Option<&'static PathBuf> {
        static PROGRAM: LazyLock<Option<PathBuf>> = LazyLock::new(|| {
            let program = c::scratch("out_of_memory")?.join("program");
            Some(c::build(&[Path::new("tests/c/out_of_memory.c")], &program, c::Link::Shared))
        });
        PROGRAM.as_ref()
    }

    fn command(program: &Path, arguments: &[&str]) -> Command {
        let mut command = Command::new(program);
        command.args(arguments).current_dir(program.parent().expect("it is in a folder"));
        // What does not depend on the machine.
        command.env("OPENRT_NUM_THREADS", "2").env("RUST_BACKTRACE", "0");
        command
    }

    /// One failed allocation.
    struct Failure {
        at: String,
        /// 0 if the program has ended before it could say.
        bytes: usize,
        outcome: Outcome,
    }

    #[derive(Debug, PartialEq)]
    enum Outcome {
        /// Nothing was to be seen of it.
        Good,
        /// `RT_OUT_OF_MEMORY`, and everything went on afterwards.
        Memory,
        Abort(String),
        Wrong(String),
    }

    /// Which share is tried of the allocations that fail for good: where one is tried, those before have shown as much.
    fn step(for_good: bool) -> usize {
        if for_good { 3 } else { 1 }
    }

    /// Has the allocations of a scenario fail one after the other, or, with `for_good`, some of them with all after. `sizes` as the program says.
    fn sweep(program: &Path, scenario: &str, sizes: &str, for_good: bool) -> Vec<Failure> {
        let mut failures = Vec::new();
        let mut first = 1;
        let (step, duration) = (step(for_good), if for_good { "0" } else { "1" });
        loop {
            let arguments = [scenario, &first.to_string(), &step.to_string(), sizes, duration];
            let (status, out, err) = c::outcome(&mut command(program, &arguments));
            let mut last = None;
            for line in out.lines() {
                let mut words = line.splitn(3, ' ');
                let (at, bytes, outcome) = (words.next().unwrap_or(""), words.next(), words.next());
                last = at.parse::<usize>().ok();
                let outcome = match outcome {
                    Some("end") => return failures,
                    Some("good") => Outcome::Good,
                    Some("memory") => Outcome::Memory,
                    Some(wrong) => Outcome::Wrong(wrong.to_owned()),
                    None => Outcome::Abort(err.trim().to_owned()),
                };
                let bytes = bytes.and_then(|bytes| bytes.parse().ok()).unwrap_or(0);
                failures.push(Failure { at: format!("{scenario} {at}"), bytes, outcome });
            }
            let last = last.unwrap_or_else(|| panic!("{scenario} {arguments:?}: {status:?}\n{err}"));
            assert!(status != Some(0) && last >= first, "{scenario} {arguments:?}: {status:?}\n{out}{err}");
            first = last + step;
        }
    }

    fn list(failures: &[&Failure]) -> String {
        let line = |failure: &&Failure| format!("{}: {} bytes: {:?}\n", failure.at, failure.bytes, failure.outcome);
        failures.iter().map(line).collect()
    }

    fn are_aborts<'a>(failures: &[&'a Failure]) -> Vec<&'a Failure> {
        failures.iter().copied().filter(|failure| matches!(failure.outcome, Outcome::Abort(_))).collect()
    }

    fn check(for_good: bool) {
        let Some(program) = program() else { return };
        let both = |sizes| SCENARIOS.iter().flat_map(move |scenario| sweep(program, scenario, sizes, for_good));
        let step = step(for_good);
        let (large, small): (Vec<_>, Vec<_>) = (both("large").collect(), both("small").collect());
        let all: Vec<&Failure> = large.iter().chain(&small).collect();
        let is_wrong = |failure: &&&Failure| matches!(failure.outcome, Outcome::Wrong(_));
        let wrong: Vec<&Failure> = all.iter().filter(is_wrong).copied().collect();
        assert!(wrong.is_empty(), "{}", list(&wrong));
        assert!(
            large.len() > 100 / step && small.len() > 500 / step,
            "{} and {} allocations",
            large.len(),
            small.len()
        );
        assert!(large.iter().all(|failure| failure.bytes >= LARGE || failure.bytes == 0));
        assert!(all.iter().filter(|failure| failure.outcome == Outcome::Memory).count() > 10, "nothing was refused");
        let aborts = are_aborts(&large.iter().collect::<Vec<_>>());
        assert!(aborts.is_empty(), "of large blocks: {}", list(&aborts));
        // A thread of rayon's, one that handles an EXR file and one that calls the library have something that must be done at their end, and the system
        // ends the process where it has no memory to remember that.
        let aborts = are_aborts(&small.iter().collect::<Vec<_>>());
        let is_known = |failure: &&Failure| matches!(&failure.outcome, Outcome::Abort(text) if text.contains("failed to register TLS destructor"));
        assert!(aborts.iter().all(is_known), "{}", list(&aborts));
        if for_good {
            // All that come before the first of these fail at it, so shares mean nothing; but only where threads begin.
            let begins = |failure: &&Failure| failure.at.starts_with("init ") || failure.at.starts_with("images ");
            assert!(aborts.iter().all(begins), "{}", list(&aborts));
            return;
        }
        let few = 100 * aborts.len() <= small.len();
        assert!(few, "{} of {} small blocks: {}", aborts.len(), small.len(), list(&aborts));
    }

    #[test]
    fn an_allocation_that_fails_is_an_error_or_nothing() {
        check(false);
    }

    #[test]
    fn a_call_without_any_memory_is_an_error_or_nothing() {
        check(true);
    }

    #[test]
    fn steady_frames_allocate_nothing() {
        let Some(program) = program() else { return };
        let counted = c::run(&mut command(program, &["count"]));
        assert!(counted.lines().count() >= 9, "{counted}");
        for line in counted.lines() {
            let words: Vec<_> = line.split(' ').collect();
            assert_eq!(words[1], "0", "{line}");
            // Builders take memory, and what reads an old mesh while rays are traced is cut off from it by a new one.
            let builds = ["bsp", "sah", "fast_build", "grid", "lazy"].contains(&words[0]);
            assert!(builds || words[2] == "0", "{line}");
        }
    }
}
