//! The `quadloom` command: one verb per task, and no algorithm.
//!
//! In: what is typed. Out: files, data on stdout, messages on stderr, an exit code (see [`exit`]).
//! Holds: files appear whole or not at all; code 0 comes only with a verified result.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a command-line program")]

mod args;
mod commands;
mod console;
mod exit;
mod map_args;
mod watchdog;

use args::{Cli, Verb};
use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    // clap ends with code 2 on wrong usage, and with 0 after help.
    let cli = Cli::parse();
    let done = match cli.verb {
        Verb::Remesh(args) => commands::remesh::run(&args),
        Verb::Field(args) => commands::field::run(&args),
        Verb::Distance(args) => commands::distance::run(&args),
        Verb::Tile(args) => commands::tile::run(&args),
        Verb::RegularMap(args) => commands::regular_map::run(&args),
        Verb::Check(args) => commands::check::run(&args),
        Verb::Stats(args) => commands::stats::run(&args),
        Verb::Convert(args) => commands::convert::run(&args),
        Verb::View(args) => commands::view::run(&args),
        Verb::Samples => commands::samples::run(),
    };
    match done {
        Ok(code) => code,
        Err(error) => {
            eprintln!("error: {error}");
            exit::of_failure(error.kind())
        }
    }
}
