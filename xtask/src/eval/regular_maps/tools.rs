//! Running `quadloom regular-map` and the scripts that judge what it wrote.

use super::super::Settings;
use super::super::runner::{python, read_json};
use super::super::table::Sheet;
use crate::shell::root;
use serde_json::{Value, json};
use std::ffi::{OsStr, OsString};
use std::path::PathBuf;
use std::process::Command;

/// The evaluation in the making.
pub struct Bench<'a> {
    pub settings: &'a Settings,
    pub sheet: Sheet,
}

/// A map as the command line names it.
#[derive(Clone)]
pub struct Named {
    /// What the tables call it.
    pub name: String,
    /// The words that name it: a name, or `--presentation` and relators.
    pub words: Vec<String>,
}

impl Named {
    /// A map of the catalogue.
    pub fn of(name: &str) -> Self {
        Self { name: name.into(), words: vec![name.into()] }
    }

    /// A map by its group.
    pub fn by_group(name: &str, relators: String) -> Self {
        Self { name: name.into(), words: vec!["--presentation".into(), relators] }
    }
}

/// A surface that the command wrote, or did not.
pub struct Made {
    pub exit: Option<i64>,
    pub seconds: f64,
    /// Largest resident memory, bytes.
    pub peak: Option<f64>,
    pub report: Value,
    pub file: PathBuf,
    /// What the command says where it fails.
    pub message: String,
}

impl Made {
    /// Whether there is a surface, with or without self-intersections.
    pub fn is_written(&self) -> bool {
        matches!(self.exit, Some(0 | 6))
    }

    /// Seconds for a table.
    pub fn seconds_text(&self) -> String {
        format!("{:.2}", self.seconds)
    }
}

/// Triangles above which `open3d`, which looks at all pairs, takes more than half a minute.
pub const MOST_TRIANGLES: u64 = 120_000;

/// When `open3d` is asked.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Open3d {
    /// However long it takes.
    Always,
    /// Up to [`MOST_TRIANGLES`].
    WhereQuick,
}

/// How many times longer than others a run may take whose seconds are stated and not limited.
const PATIENCE: u32 = 6;

impl Bench<'_> {
    /// Whether a part of the evaluation was asked for.
    pub fn wants(&self, part: &str) -> bool {
        self.settings.wants(part)
    }

    /// A file of the tables to compare with; where it is not there the document says so.
    pub fn oracle(&mut self, name: &str) -> Option<Vec<Vec<String>>> {
        let path = self.settings.shared.join("research/regular-maps").join(name);
        match std::fs::read_to_string(&path) {
            Ok(text) => Some(text.lines().skip(1).map(|l| l.split('\t').map(String::from).collect()).collect()),
            Err(_) => {
                eprintln!("skipped: there is no {}", path.display());
                self.sheet.text.push_str(&format!("\nSkipped: there is no table `{name}` to compare with.\n"));
                None
            }
        }
    }

    /// What the command prints as JSON; null where it fails.
    pub fn ask(&mut self, words: &[&str]) -> Value {
        let output = Command::new(&self.settings.binary).arg("regular-map").args(words).output();
        let output = match output {
            Ok(output) if output.status.success() => output,
            Ok(output) => {
                let said = String::from_utf8_lossy(&output.stderr).trim().replace('\n', " / ");
                self.sheet.broken.push(format!("{}: {said}", words.join(" ")));
                return Value::Null;
            }
            Err(e) => {
                self.sheet.broken.push(e.to_string());
                return Value::Null;
            }
        };
        serde_json::from_slice(&output.stdout).unwrap_or_else(|e| {
            self.sheet.broken.push(format!("{}: {e}", words.join(" ")));
            Value::Null
        })
    }

    /// The targets of a map.
    pub fn matches(&mut self, map: &Named) -> Vec<Value> {
        let words: Vec<&str> = ["match"].into_iter().chain(map.words.iter().map(String::as_str)).collect();
        self.ask(&[&words[..], &["--json"]].concat()).as_array().cloned().unwrap_or_default()
    }

    /// Makes a surface: `verb` is `realize` or `tubify`, `ending` the file's.
    pub fn make(&mut self, verb: &str, map: &Named, ending: &str, options: &str) -> Made {
        let plain: String = map.name.chars().filter(char::is_ascii_alphanumeric).collect();
        let prime = if map.name.ends_with(['′', '\'']) { "-dual" } else { "" };
        let file = |ending: &str| self.settings.work.join(format!("{verb}-{plain}{prime}.{ending}"));
        let (surface, report, log) = (file(ending), file("json"), file("err"));
        let (_, _) = (std::fs::remove_file(&surface), std::fs::remove_file(&report));
        let script = root().join("xtask/scripts/timed_run.py");
        let patience = if options.contains("--allow-intersections") { PATIENCE } else { 1 };
        let limit = (self.settings.timeout * patience).as_secs().to_string();
        let mut words: Vec<OsString> = vec![script.into(), limit.into(), log.clone().into()];
        words.extend([self.settings.binary.clone().into(), "regular-map".into(), verb.into()]);
        words.extend(map.words.iter().map(OsString::from));
        words.extend(["-o".into(), surface.clone().into(), "--report".into(), report.clone().into(), "--quiet".into()]);
        words.extend(
            options.split_whitespace().chain(self.settings.extra.iter().map(String::as_str)).map(OsString::from),
        );
        let ended = python(&words.iter().map(OsString::as_os_str).collect::<Vec<_>>());
        let said = std::fs::read_to_string(&log).unwrap_or_default();
        let made = Made {
            exit: ended["exit"].as_i64(),
            seconds: ended["seconds"].as_f64().unwrap_or(f64::INFINITY),
            peak: ended["peak_bytes"].as_f64(),
            report: read_json(&report),
            file: surface,
            message: ended["error"].as_str().unwrap_or(said.trim()).replace(['\n', '|'], " / "),
        };
        eprintln!("{verb} {} {options}: exit {:?}, {:.2} s {}", map.name, made.exit, made.seconds, made.message);
        made
    }

    /// What `drawn_map.py` says about a surface that was written with `--edges none`.
    pub fn judge_map(&self, made: &Made) -> Value {
        let source = &made.report["source"];
        let script = root().join("xtask/scripts/drawn_map.py");
        let mut words: Vec<OsString> = vec![script.into(), made.file.clone().into()];
        for key in ["faces", "edges", "vertices", "genus", "petrie"] {
            words.extend([format!("--{key}").into(), source[key].to_string().into()]);
        }
        words.extend(["--type".into(), format!("{},{}", source["p"], source["q"]).into()]);
        python(&words.iter().map(OsString::as_os_str).collect::<Vec<_>>())
    }

    /// What `solid.py` says.
    pub fn judge_solid(&self, made: &Made, genus: &Value, open3d: Open3d) -> Value {
        let script = root().join("xtask/scripts/solid.py");
        let genus = genus.to_string();
        let mut words: Vec<&OsStr> = vec![script.as_ref(), made.file.as_ref(), "--genus".as_ref(), genus.as_ref()];
        let is_large = made.report["surface"]["faces"].as_u64().is_some_and(|n| n > MOST_TRIANGLES);
        if is_large && open3d == Open3d::WhereQuick {
            words.push("--without-intersections".as_ref());
        }
        match python(&words) {
            Value::Array(mut list) if list.len() == 1 => list.remove(0),
            other => other,
        }
    }

    /// Notes everything about a surface for the machine-readable table.
    pub fn record(&mut self, part: &str, map: &Named, made: &Made, judged: Value) {
        let mut report = made.report.clone();
        if let Some(fields) = report.as_object_mut() {
            // The orbits fill pages; their number says enough.
            let orbits = fields.get("face_orbits").and_then(Value::as_array).map(Vec::len);
            fields.insert("face_orbits".into(), json!(orbits));
        }
        self.sheet.runs.push(json!({
            "part": part, "map": map.name, "exit": made.exit, "seconds": made.seconds, "peak_bytes": made.peak,
            "message": made.message, "report": report, "judged": judged,
        }));
    }
}

/// Whether a script found no defect; where it failed it did not.
pub fn is_clean(judged: &Value) -> bool {
    judged["defects"].as_array().is_some_and(Vec::is_empty)
}

/// What a script says, for a table.
pub fn said(judged: &Value) -> String {
    match (&judged["error"], judged["defects"].as_array()) {
        (Value::String(error), _) => error.lines().last().unwrap_or("no answer").replace('|', "/"),
        (_, Some(defects)) if defects.is_empty() => "holds".into(),
        (_, Some(defects)) => defects.iter().filter_map(Value::as_str).collect::<Vec<_>>().join("; ").replace('|', "/"),
        _ => "no answer".into(),
    }
}

/// What `open3d` says about self-intersection.
pub fn by_open3d(judged: &Value) -> String {
    match judged["self_intersecting"].as_bool() {
        Some(false) => "none".into(),
        Some(true) => "some".into(),
        None => "–".into(),
    }
}
