//! `openrt`: looks at, renders and plays scene files, through the public API of the library only.
//!
//! Files become a [`openrt::load::SceneFile`], which `player` gives to the library; `play` and `info` are the
//! commands. Exit codes: 0 done, 1 the scene or the rendering failed, 2 the command line is wrong.
#![forbid(unsafe_code)]

mod args;
mod info;
mod input;
mod output;
mod play;
mod player;
mod progress;
mod report;

use args::{Cli, Command};
use clap::{CommandFactory, Parser};
use std::process::ExitCode;

fn main() -> ExitCode {
    let result = match Cli::parse().command {
        Command::Info(args) => info::run(&args, &mut std::io::stdout().lock()),
        Command::Render(args) => play::render(args),
        Command::Play(args) => play::play(args),
        Command::Completions { shell } => {
            clap_complete::generate(shell, &mut Cli::command(), "openrt", &mut std::io::stdout());
            Ok(())
        }
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(text) => {
            eprintln!("error: {text}");
            ExitCode::FAILURE
        }
    }
}
