//! `openrt`: looks at, renders and plays scene files, through the public API of the library only.
//!
//! Files become a [`SceneFile`], which `player` gives to the library; `play` and `info` are the
//! commands. Exit codes: 0 done, 1 the scene or the rendering failed, 2 the command line is wrong.
#![forbid(unsafe_code)]

mod args;
mod info;
mod output;
mod play;
mod player;

use args::{Cli, Command, SceneArgs};
use clap::Parser;
use openrt::load::{ReadOptions, SceneFile, read_with};
use std::process::ExitCode;

fn main() -> ExitCode {
    let result = match Cli::parse().command {
        Command::Info(args) => info::run(&args, &mut std::io::stdout().lock()),
        Command::Render(args) => play::render(args),
        Command::Play(args) => play::play(args),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(text) => {
            eprintln!("error: {text}");
            ExitCode::FAILURE
        }
    }
}

/// Loads a scene and shows what was odd about it.
fn load(args: &SceneArgs) -> Result<SceneFile, String> {
    let scene = read_with(&args.scene, &ReadOptions { detail: args.detail }).map_err(|e| e.to_string())?;
    for warning in &scene.warnings {
        eprintln!("warning: {warning}");
    }
    Ok(scene)
}
