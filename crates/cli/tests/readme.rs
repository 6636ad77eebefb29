//! Every command in README.md does what it says.

mod common;

use common::Bench;

/// The command lines of README.md, in order.
fn commands() -> Vec<String> {
    let readme = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../README.md")).expect("README.md");
    let blocks = readme.split("```sh\n").skip(1).filter_map(|rest| rest.split("```").next());
    blocks.flat_map(str::lines).map(str::trim).filter(|l| !l.is_empty()).map(String::from).collect()
}

#[test]
fn every_command_in_the_readme_works() {
    let bench = Bench::new();
    let commands = commands();
    assert!(commands.len() > 8, "{commands:?}");
    for line in commands {
        let words = line.strip_prefix("cargo run --release -- ").or(line.strip_prefix("quadloom "));
        let words = words.unwrap_or_else(|| panic!("not a command of this program: {line}"));
        let ran = bench.line(words);
        assert_eq!(ran.code, 0, "{line}\n{}", ran.stderr);
    }
}

#[test]
fn every_verb_has_help_with_an_example() {
    let bench = Bench::new();
    for verb in ["remesh", "field", "check", "stats", "convert", "view", "samples", "distance", "tile", "regular-map"] {
        let help = bench.line(&format!("{verb} --help"));
        help.succeeds();
        assert!(help.stdout.contains(&format!("Example: quadloom {verb}")), "{}", help.stdout);
    }
}
