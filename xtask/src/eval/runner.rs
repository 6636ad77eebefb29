//! One run of the command and what is measured of it.

use super::Settings;
use crate::shell::root;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// A run of `quadloom remesh` that is to be made.
#[derive(Clone)]
pub struct Job {
    /// Name of the model.
    pub model: String,
    /// Which variant of the run it is, a word for the file name and the table.
    pub variant: String,
    /// The file.
    pub input: PathBuf,
    /// Options after the input.
    pub options: Vec<String>,
    /// What the output is measured against.
    pub reference: Reference,
    /// Which measurements are made of the output.
    pub measure: Measure,
    /// Whether the command writes its report, which takes some tenths of a second.
    pub report: bool,
}

/// What an output is measured against.
#[derive(Clone)]
pub enum Reference {
    /// The input.
    Input,
    /// Another file.
    File(PathBuf),
    /// Nothing: the input's own topology is not that of a surface.
    None,
}

/// Which measurements are made of an output.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Measure {
    /// None: only the command's exit code, message and time.
    Nothing,
    /// The judge, with the reference.
    Judge,
    /// The judge, and the repository's own script: facing against the input, boundary distance.
    JudgeAndOrientation,
}

/// What came out of a job.
pub struct Run {
    /// The job.
    pub job: Job,
    /// Exit code; `None` where a signal or the time limit ended it.
    pub exit: Option<i32>,
    /// Wall-clock seconds of the whole command.
    pub seconds: f64,
    /// The last line on stderr that is an error or warning.
    pub message: String,
    /// The command's own JSON report.
    pub report: Value,
    /// What the judge says.
    pub judge: Value,
    /// What the repository's own script says.
    pub orientation: Value,
}

impl Run {
    /// The judge's word: a valid pure-quad mesh with the reference's topology.
    pub fn is_valid(&self) -> bool {
        self.judge["valid"] == Value::Bool(true)
    }

    /// Valid, no inverted quad, none facing against the input.
    pub fn is_good(&self) -> bool {
        self.is_valid()
            && self.judge["inverted"] == json!(0)
            && self.orientation["facing_against"].as_u64().unwrap_or(0) == 0
    }

    /// The command said that it succeeded and the judge disagrees.
    pub fn is_lie(&self) -> bool {
        matches!(self.exit, Some(0 | 6)) && self.job.measure != Measure::Nothing && !self.is_good()
    }

    /// A number of the judge.
    pub fn judged(&self, key: &str) -> Option<f64> {
        self.judge[key].as_f64()
    }

    /// Everything measured, for the machine-readable table; of the report's warnings their code and message, and nothing
    /// for each component, of which a file may have hundreds.
    pub fn to_json(&self) -> Value {
        let mut report = self.report.clone();
        if let Some(fields) = report.as_object_mut() {
            fields.remove("components");
        }
        for warning in report.get_mut("warnings").and_then(Value::as_array_mut).into_iter().flatten() {
            *warning = json!({ "code": warning["code"], "message": warning["message"] });
        }
        json!({
            "model": self.job.model, "variant": self.job.variant, "options": self.job.options,
            "exit": self.exit, "seconds": (self.seconds * 1000.0).round() / 1000.0, "message": self.message,
            "report": report, "judge": self.judge, "orientation": self.orientation,
        })
    }
}

/// Makes all runs, `jobs` at a time, in the order given.
pub fn run_all(settings: &Settings, jobs: Vec<Job>, at_once: usize) -> Vec<Run> {
    let at_once = settings.jobs.unwrap_or(at_once).max(1);
    let next = AtomicUsize::new(0);
    let done: Vec<Mutex<Option<Run>>> = jobs.iter().map(|_| Mutex::new(None)).collect();
    std::thread::scope(|scope| {
        for _ in 0..at_once {
            scope.spawn(|| {
                loop {
                    let slot = next.fetch_add(1, Ordering::Relaxed);
                    let Some(job) = jobs.get(slot) else { break };
                    let run = run_one(settings, job, at_once);
                    eprintln!("{}", progress_line(&run));
                    *done[slot].lock().unwrap_or_else(|e| e.into_inner()) = Some(run);
                }
            });
        }
    });
    done.into_iter().filter_map(|slot| slot.into_inner().unwrap_or_else(|e| e.into_inner())).collect()
}

fn progress_line(run: &Run) -> String {
    let verdict = match run.exit {
        Some(0 | 6) if run.job.measure == Measure::Nothing => "done",
        Some(0 | 6) if run.is_good() => "good",
        Some(0 | 6) => "REJECTED",
        None => "KILLED",
        _ => "refused",
    };
    let exit = run.exit.map_or("-".into(), |c| c.to_string());
    let quads = run.judge["faces"].as_u64().map_or(String::new(), |n| format!("{n} quads "));
    format!(
        "{verdict:<9} {:<24} {:<9} exit {exit} {:.1} s {quads}{}",
        run.job.model, run.job.variant, run.seconds, run.message
    )
}

fn run_one(settings: &Settings, job: &Job, at_once: usize) -> Run {
    let stem = settings.work.join(format!("{}-{}", job.model, job.variant));
    let (mesh, report) = (stem.with_extension("obj"), stem.with_extension("json"));
    let (_, _) = (std::fs::remove_file(&mesh), std::fs::remove_file(&report));
    let mut command = Command::new(&settings.binary);
    command.arg("remesh").arg(&job.input).arg("-o").arg(&mesh);
    if job.report {
        command.arg("--report").arg(&report);
    }
    command.args(["--progress", "none"]).args(&job.options).args(&settings.extra);
    if at_once > 1 && !job.options.iter().any(|o| o == "--threads") {
        command.args(["--threads", "1"]);
    }
    let begin = Instant::now();
    let (exit, stderr) = wait(&mut command, &stem.with_extension("err"), settings.timeout);
    let seconds = begin.elapsed().as_secs_f64();
    let mut run = Run {
        job: job.clone(),
        exit,
        seconds,
        message: last_message(&stderr),
        report: read_json(&report),
        judge: Value::Null,
        orientation: Value::Null,
    };
    if matches!(exit, Some(0 | 6)) && job.measure != Measure::Nothing {
        measure(settings, &mut run, &mesh);
    }
    run
}

/// Runs a program with a time limit; its exit code and standard error.
///
/// Standard error goes to a file: a pipe that nobody reads would block the program.
pub fn wait(command: &mut Command, stderr: &Path, timeout: Duration) -> (Option<i32>, String) {
    let Ok(file) = std::fs::File::create(stderr) else { return (None, format!("cannot write {}", stderr.display())) };
    let child = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(file).spawn();
    let mut child = match child {
        Ok(child) => child,
        Err(e) => return (None, e.to_string()),
    };
    let begin = Instant::now();
    let exit = loop {
        match child.try_wait() {
            Ok(Some(status)) => break status.code(),
            Ok(None) if begin.elapsed() < timeout => std::thread::sleep(Duration::from_millis(5)),
            _ => {
                let _ = child.kill();
                let _ = child.wait();
                break None;
            }
        }
    };
    (exit, std::fs::read_to_string(stderr).unwrap_or_default())
}

fn measure(settings: &Settings, run: &mut Run, mesh: &Path) {
    let reference = match &run.job.reference {
        Reference::Input => Some(run.job.input.clone()),
        Reference::File(path) => Some(path.clone()),
        Reference::None => None,
    };
    let judge = settings.shared.join("tools/quadcheck.py");
    let mut args = vec![judge.as_os_str(), mesh.as_os_str(), "--json".as_ref()];
    if let Some(reference) = &reference {
        args.extend(["--ref".as_ref(), reference.as_os_str()]);
    }
    run.judge = python(&args);
    if let (Measure::JudgeAndOrientation, Some(reference)) = (run.job.measure, &reference) {
        let script = root().join("xtask/scripts/orientation.py");
        run.orientation = python(&[script.as_os_str(), mesh.as_os_str(), reference.as_os_str()]);
    }
}

/// The JSON that a script prints; its exit code does not matter.
pub fn python(args: &[&std::ffi::OsStr]) -> Value {
    let output = Command::new("python3").args(args).stdin(Stdio::null()).output();
    match output {
        Ok(output) => serde_json::from_slice(&output.stdout)
            .unwrap_or_else(|_| json!({ "error": String::from_utf8_lossy(&output.stderr) })),
        Err(e) => json!({ "error": e.to_string() }),
    }
}

/// What an example of a crate prints.
pub fn example(package: &str, name: &str, args: &[&str]) -> Result<String, String> {
    let cargo = std::env::var_os("CARGO").unwrap_or("cargo".into());
    let output = Command::new(cargo)
        .args(["run", "--release", "--quiet", "--package", package, "--example", name, "--"])
        .args(args)
        .current_dir(root())
        .output()
        .map_err(|e| e.to_string())?;
    if !output.status.success() {
        return Err(format!("example {name}: {}", String::from_utf8_lossy(&output.stderr)));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// The JSON of a file; null where there is none.
pub fn read_json(path: &Path) -> Value {
    std::fs::read(path).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok()).unwrap_or(Value::Null)
}

fn last_message(stderr: &str) -> String {
    let says = |word: &str| stderr.lines().rev().find(|l| l.starts_with(word));
    let line = says("error").or_else(|| stderr.lines().find(|l| l.contains("panicked"))).or_else(|| says("warning"));
    line.unwrap_or_default().to_string()
}
