//! Runs of `quadloom distance`, and the document that its evaluation writes.
//!
//! In: models or generated surfaces, options. Out: seconds, memory, report and distances of a run; tables.
//! Holds: one run at a time, with one thread; what is left out is said in the document; a run that fails, or a promise
//! that is broken, is in [`Bench::broken`] and the other rows are made nevertheless.

use super::inputs::{Triangles, write_plane, write_torus};
use crate::eval::Settings;
use crate::eval::runner::python;
use crate::eval::table::{grid, number};
use crate::shell::root;
use serde_json::{Value, json};
use std::ffi::OsString;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Times of the command are the best of so many runs.
pub const REPEATS: usize = 5;

/// Quads along a side of the generated plane.
const PLANE_SIDE: u32 = 20;

/// Generated tori: name, vertices along a side.
const TORI: [(&str, u32); 2] = [("torus_2M", 1000), ("torus_8M", 2000)];

/// What the document is made of.
pub struct Bench<'a> {
    /// The evaluation's settings.
    pub settings: &'a Settings,
    /// The document so far.
    pub text: String,
    /// Everything measured.
    pub runs: Vec<Value>,
    /// What must not happen and did.
    pub broken: Vec<String>,
    /// Aims that were met, and all that were looked at.
    pub aims: (usize, usize),
    /// Models that a section left out.
    skipped: Vec<String>,
}

/// One run of the command.
pub struct Ran {
    /// Wall-clock seconds of the whole command.
    pub seconds: f64,
    /// Largest resident memory, bytes.
    pub peak: Option<f64>,
    /// The part of its report about distances.
    pub report: Value,
}

impl Ran {
    /// Seconds of a stage.
    pub fn stage(&self, name: &str) -> Option<f64> {
        self.report["seconds"][name].as_f64()
    }

    /// Everything measured.
    pub fn to_json(&self) -> Value {
        json!({ "seconds": self.seconds, "peak_bytes": self.peak, "report": self.report })
    }
}

/// What a row is about: a model and a kind of source.
pub type Case = (&'static str, &'static str);

impl<'a> Bench<'a> {
    /// An empty document.
    pub fn new(settings: &'a Settings) -> Self {
        let (runs, broken, skipped) = (Vec::new(), Vec::new(), Vec::new());
        Self { settings, text: String::new(), runs, broken, aims: (0, 0), skipped }
    }

    /// A file of the evaluation's own folder.
    pub fn work(&self, name: &str) -> PathBuf {
        self.settings.work.join(name)
    }

    /// The file of a model; it is generated where it is none of the given ones. `None` if there is no such file.
    fn input(&self, name: &str) -> Result<Option<PathBuf>, String> {
        let said = |path: &Path, e: std::io::Error| format!("{}: {e}", path.display());
        if name == "plane" {
            let path = self.work("plane.obj");
            write_plane(&path, PLANE_SIDE).map_err(|e| said(&path, e))?;
            return Ok(Some(path));
        }
        if let Some((_, side)) = TORI.iter().find(|torus| torus.0 == name) {
            let path = self.work(&format!("{name}.ply"));
            write_torus(&path, *side).map_err(|e| said(&path, e))?;
            return Ok(Some(path));
        }
        let path = self.settings.shared.join("models/tri").join(format!("{name}.obj"));
        Ok(path.is_file().then_some(path))
    }

    /// The words that name a source: `vertex` is the first one that a face uses, `polygon` a closed curve of eight
    /// points across faces, `polyline` half of it; others are the command's own.
    pub fn source(&self, input: &Path, kind: &str) -> Result<Vec<String>, String> {
        let from = match kind {
            // Generated surfaces use all their vertices.
            "vertex" if input.extension().is_some_and(|e| e == "ply") => "vertices:0".into(),
            "vertex" => format!("vertices:{}", Triangles::read(input)?.first_used()),
            "polygon" | "polyline" => {
                let path = self.work(&format!("{kind}.json"));
                let curve = Triangles::read(input)?.curve_around(8, kind == "polygon");
                std::fs::write(&path, curve.to_string()).map_err(|e| format!("{}: {e}", path.display()))?;
                format!("curve:{}", path.display())
            }
            other => other.into(),
        };
        Ok(vec!["--from".into(), from])
    }

    /// Runs the command once; distances go to the file `out` of the evaluation's folder.
    pub fn run(&self, input: &Path, out: &str, options: &[String]) -> Result<Ran, String> {
        let [out, report, log] = [out, "out.json", "out.err"].map(|name| self.work(name));
        let (_, _) = (std::fs::remove_file(&out), std::fs::remove_file(&report));
        let script = root().join("xtask/scripts/timed_run.py");
        let limit = self.settings.timeout.as_secs().to_string();
        let mut words: Vec<OsString> = vec![script.into(), limit.into(), log.clone().into()];
        words.extend([self.settings.binary.clone().into(), "distance".into(), input.into(), "-o".into(), out.into()]);
        words.extend(["--report".into(), report.clone().into()]);
        words.extend(["--threads", "1", "--quiet"].map(OsString::from));
        words.extend(options.iter().chain(&self.settings.extra).map(OsString::from));
        let words: Vec<&std::ffi::OsStr> = words.iter().map(OsString::as_os_str).collect();
        let ended = python(&words);
        let (Some(seconds), Some(0)) = (ended["seconds"].as_f64(), ended["exit"].as_i64()) else {
            let said = std::fs::read_to_string(&log).unwrap_or_default();
            let why = ended["error"].as_str().unwrap_or_else(|| said.trim());
            let why = why.lines().collect::<Vec<_>>().join(" / ");
            return Err(format!("{}: exit {}: {why}", options.join(" "), ended["exit"]));
        };
        let text = std::fs::read(&report).map_err(|e| format!("no report: {e}"))?;
        let report: Value = serde_json::from_slice(&text).map_err(|e| format!("report: {e}"))?;
        let report = report["distance"].clone();
        // The command's own figure where the system's says nothing.
        let peak = ended["peak_bytes"].as_f64().or_else(|| report["peak_memory_bytes"].as_f64());
        Ok(Ran { seconds, peak, report })
    }

    /// The fastest of several runs.
    pub fn best(&self, input: &Path, options: &[String]) -> Result<Ran, String> {
        let mut best = self.run(input, "out.csv", options)?;
        for _ in 1..REPEATS {
            let next = self.run(input, "out.csv", options)?;
            if next.seconds < best.seconds {
                best = next;
            }
        }
        Ok(best)
    }

    /// Distance per vertex of the file that the last run wrote.
    pub fn distances(&self) -> Result<Vec<f64>, String> {
        let path = self.work("out.csv");
        let text = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        let row = |(k, line): (usize, &str)| {
            let mut cells = line.split(',');
            let vertex: Option<usize> = cells.next().and_then(|v| v.parse().ok());
            let distance: Option<f64> = cells.next().and_then(|d| d.parse().ok());
            distance.filter(|d| vertex == Some(k) && !d.is_nan()).ok_or_else(|| format!("row {k}: {line}"))
        };
        text.lines().skip(1).enumerate().map(row).collect()
    }

    /// Whether the command knows an option.
    pub fn knows(&self, option: &str) -> bool {
        let help = Command::new(&self.settings.binary).args(["distance", "--help"]).output();
        help.is_ok_and(|out| String::from_utf8_lossy(&out.stdout).split_whitespace().any(|word| word == option))
    }

    /// A cell that is bold where an aim is missed; without a value there is nothing to meet.
    pub fn aim(&mut self, value: Option<f64>, text: String, is_met: impl Fn(f64) -> bool) -> String {
        let Some(value) = value else { return "–".into() };
        self.aims.1 += 1;
        if is_met(value) {
            self.aims.0 += 1;
            return text;
        }
        format!("**{text}**")
    }

    /// A cell with a number and the most that it may be.
    pub fn at_most(&mut self, value: Option<f64>, digits: usize, most: f64) -> String {
        self.aim(value, number(value, digits), |v| v <= most)
    }

    /// The rows of all cases that were asked for; those without a model are left out, those that fail say why.
    pub fn rows(
        &mut self,
        title: &str,
        cases: &[Case],
        measure: impl Fn(&mut Self, Case, &Path) -> Result<Vec<Vec<String>>, String>,
    ) -> Result<Vec<Vec<String>>, String> {
        let mut rows = Vec::new();
        for &case in cases.iter().filter(|case| self.settings.wants(case.0)) {
            let Some(input) = self.input(case.0)? else {
                let text = format!("skipped: there is no model {}", case.0);
                eprintln!("{title}: {text}");
                self.skipped.push(text);
                continue;
            };
            match measure(self, case, &input) {
                Ok(made) => {
                    made.iter().for_each(|row| eprintln!("{title}: {}", row.join(" | ")));
                    rows.extend(made);
                }
                Err(why) => {
                    eprintln!("{title}: {} {}: {why}", case.0, case.1);
                    let text = why.replace('|', "/");
                    rows.push(vec![case.0.into(), case.1.into(), format!("**failed**: {text}")]);
                    self.runs.push(json!({ "table": title, "model": case.0, "from": case.1, "failed": why }));
                    self.broken.push(format!("{title}, {} from {}: {why}", case.0, case.1));
                }
            }
            if input.extension().is_some_and(|e| e == "ply") {
                let _ = std::fs::remove_file(&input);
            }
        }
        Ok(rows)
    }

    /// Says below the next table what was left out.
    pub fn skip(&mut self, text: String) {
        eprintln!("{text}");
        self.skipped.push(text);
    }

    /// Keeps what was measured for a row.
    pub fn keep(&mut self, table: &str, case: Case, measured: Value) {
        let mut run = json!({ "table": table, "model": case.0, "from": case.1 });
        if let (Some(run), Value::Object(measured)) = (run.as_object_mut(), measured) {
            run.extend(measured);
        }
        self.runs.push(run);
    }

    /// Adds a table, padded where rows are short, and what it leaves out.
    pub fn section(&mut self, title: &str, text: &str, head: &[&str], mut rows: Vec<Vec<String>>) {
        rows.iter_mut().for_each(|row| row.resize(head.len(), String::new()));
        let table = if rows.is_empty() { String::new() } else { grid(head, &rows) };
        let _ = write!(self.text, "\n## {title}\n\n{text}\n\n{table}");
        self.skipped.dedup();
        for skipped in self.skipped.drain(..) {
            let _ = write!(self.text, "\n{skipped}\n");
        }
    }
}
