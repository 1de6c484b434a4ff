//! How a bench begins and ends: the command line, a word on how it was built, and its figures as JSON.

use std::path::Path;
use std::process::ExitCode;

/// The options that `parse` reads from the command line, or, after its message or the `usage` that was asked for, how to end.
pub fn options<O>(
    usage: &str,
    parse: impl FnOnce(std::iter::Skip<std::env::Args>) -> Result<O, String>,
) -> Result<O, ExitCode> {
    if std::env::args().skip(1).any(|argument| argument == "--help" || argument == "-h") {
        println!("{usage}");
        return Err(ExitCode::SUCCESS);
    }
    let options = parse(std::env::args().skip(1)).map_err(|text| {
        eprintln!("{text}");
        ExitCode::FAILURE
    })?;
    if option_env!("CARGO_INCREMENTAL") == Some("1") {
        println!(
            "!!! BUILT WITH CARGO_INCREMENTAL=1: kernels are cut into 256 units and hardly inlined; ours is up to 2 times too slow"
        );
    }
    Ok(options)
}

/// Writes the figures if there is a file for them.
pub fn end(path: Option<&Path>, json: impl FnOnce() -> String) -> ExitCode {
    if let Some(path) = path
        && let Err(error) = std::fs::write(path, json())
    {
        eprintln!("{}: {error}", path.display());
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}
