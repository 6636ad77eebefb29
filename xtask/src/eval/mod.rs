//! Evaluations: the release command is run over models, an independent judge measures what it wrote.
//!
//! In: the folder `../shared` with models and the judge (`--models DIR`), a built command. Out: a table in
//! `docs/results/SUITE.md` and everything measured in `docs/results/SUITE.json`, both naming the command that made
//! them; the meshes themselves stay in the target folder. With `--only` nothing is written to `docs`.

mod geodesic;
mod regular_maps;
mod runner;
mod suites;
mod table;
mod tiling;

use crate::shell::{Outcome, cargo, root};
use serde_json::json;
use std::path::PathBuf;
use std::time::Duration;

/// What the command line of `cargo xtask eval` says.
pub struct Settings {
    /// Name of the evaluation.
    pub suite: String,
    /// Models to look at; empty: all.
    pub only: Vec<String>,
    /// Runs at the same time.
    pub jobs: Option<usize>,
    /// The command under evaluation.
    pub binary: PathBuf,
    /// Folder with `models` and `tools`.
    pub shared: PathBuf,
    /// A run that takes longer is stopped and counts as hung.
    pub timeout: Duration,
    /// Where meshes and reports go.
    pub work: PathBuf,
    /// Options added to every run of the command, after `--`.
    pub extra: Vec<String>,
}

impl Settings {
    fn parse(suite: &str, args: &[String]) -> Result<Self, String> {
        let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from);
        let mut settings = Self {
            suite: suite.into(),
            only: Vec::new(),
            jobs: None,
            binary: target.join("release/quadloom"),
            shared: root().join("../shared"),
            timeout: Duration::from_secs(300),
            work: target.join("eval").join(suite),
            extra: Vec::new(),
        };
        let mut words = args.iter();
        while let Some(word) = words.next() {
            if word == "--" {
                settings.extra.extend(words.by_ref().cloned());
                break;
            }
            let value = words.next().ok_or_else(|| format!("{word} needs a value"))?;
            match word.as_str() {
                "--only" => settings.only = value.split(',').map(String::from).collect(),
                "--jobs" => settings.jobs = Some(value.parse().map_err(|_| format!("--jobs {value}: not a number"))?),
                "--binary" => settings.binary = value.into(),
                "--models" => settings.shared = value.into(),
                "--timeout" => {
                    let seconds = value.parse().map_err(|_| format!("--timeout {value}: not a number of seconds"))?;
                    settings.timeout = Duration::from_secs(seconds);
                }
                _ => return Err(format!("unknown option {word}")),
            }
        }
        Ok(settings)
    }

    /// Whether a model was asked for.
    pub fn wants(&self, model: &str) -> bool {
        self.only.is_empty() || self.only.iter().any(|name| name == model)
    }

    /// Whether this run covers its whole suite with the command's own settings.
    fn is_complete(&self) -> bool {
        self.only.is_empty() && self.extra.is_empty()
    }

    /// A text without the folders of this machine.
    fn without_places(&self, text: &str) -> String {
        let places = [(&self.work, "work"), (&self.shared, "../shared"), (&self.binary, "quadloom")];
        places.iter().fold(text.to_string(), |text, (path, name)| text.replace(&path.display().to_string(), name))
    }

    fn command_line(&self) -> String {
        format!("cargo xtask eval {}", self.suite)
    }
}

/// Runs an evaluation and writes its table.
pub fn run(suite: &str, args: &[String]) -> Outcome {
    let settings = Settings::parse(suite, args)?;
    if !settings.shared.join("models").is_dir() {
        println!("skipped: there is no folder {} with models", settings.shared.join("models").display());
        return Ok(());
    }
    if settings.binary.starts_with(settings.work.parent().and_then(|p| p.parent()).unwrap_or(&settings.work)) {
        cargo(&["build", "--release", "--package", "quadloom-cli"])?;
    }
    std::fs::create_dir_all(&settings.work).map_err(|e| format!("{}: {e}", settings.work.display()))?;
    let result = suites::run(&settings)?;
    println!("{}", result.markdown);
    let folder = if settings.is_complete() { root().join("docs/results") } else { settings.work.clone() };
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let document = json!({ "command": settings.command_line(), "runs": result.runs });
    let markdown = format!("{}\nMade by `{}`.\n", result.markdown, settings.command_line());
    let text = settings.without_places(&format!("{document:#}\n"));
    write(&folder.join(format!("{suite}.json")), &text)?;
    write(&folder.join(format!("{suite}.md")), &settings.without_places(&markdown))?;
    if result.broken.is_empty() { Ok(()) } else { Err(format!("broken: {}", result.broken.join("; "))) }
}

fn write(path: &std::path::Path, text: &str) -> Outcome {
    std::fs::write(path, text).map_err(|e| format!("{}: {e}", path.display()))?;
    println!("wrote {}", path.display());
    Ok(())
}
