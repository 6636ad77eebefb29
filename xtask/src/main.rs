//! Recipes of the repository: `cargo xtask NAME`. Each check of `.ci/run` and each table of `docs/results` is one.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a command-line program")]

mod checks;
mod eval;
mod gallery;
mod shell;
mod viewer;

use std::process::ExitCode;

const USAGE: &str = "\
cargo xtask NAME

checks      fmt        formatting is rustfmt's
            clippy     no lint fires
            citations  every [Key] cited in sources and documents is in docs/bibliography.bib
            paths      no absolute path of a machine is in the repository
            docs       documentation builds without a warning
            viewer     a page of the command works in Chromium (skipped without node, chromium or playwright-core)
            test       cargo test --workspace
            ci         all of them, in this order
pictures    gallery [NAME …]  pictures of docs/regular-maps.md (skipped as viewer is)
evaluations eval SUITE [--only A,B] [--jobs N] [--binary FILE] [--models DIR] [--timeout SECONDS]
            suites: tri, irregular, features, distance, geodesic, tiling, regular-maps, speed, threads, nasty, fields,
            limits, cad, solver";

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = args.iter().map(String::as_str).collect();
    let outcome = match words[..] {
        ["fmt"] => shell::cargo(&["fmt", "--all", "--check"]),
        ["clippy"] => shell::cargo(&["clippy", "--workspace", "--all-targets", "--quiet", "--", "-D", "warnings"]),
        ["citations"] => checks::citations(),
        ["paths"] => checks::paths(),
        ["docs"] => checks::docs(),
        ["viewer"] => viewer::test(),
        ["gallery", ..] => gallery::make(&args[1..]),
        ["test"] => shell::cargo(&["test", "--workspace"]),
        ["ci"] => ["fmt", "citations", "paths", "clippy", "docs", "viewer", "test"]
            .iter()
            .try_for_each(|recipe| shell::cargo(&["xtask", recipe])),
        ["eval", suite, ..] => eval::run(suite, &args[2..]),
        _ => Err(USAGE.into()),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::FAILURE
        }
    }
}
