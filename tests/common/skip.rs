//! What a test cannot do on this machine is said aloud.

use std::fmt::Display;
use std::io::Write;

/// Says that `what` is not tested here. Written past the test harness, which would hide what a passing test prints.
pub fn skipped(what: impl Display) {
    // A closed stderr is no reason to fail.
    let _ = writeln!(std::io::stderr(), "SKIPPED: {what}");
}
