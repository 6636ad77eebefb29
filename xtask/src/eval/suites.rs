//! The evaluations, one function each.

use super::Settings;
use super::runner::{Job, Measure, Reference, Run, run_all, wait};
use super::table::{BASICS, Column, Evaluation, SHAPE, count, grid, number, table, verdict};
use crate::shell::root;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

/// Makes the evaluation that the settings name.
pub fn run(settings: &Settings) -> Result<Evaluation, String> {
    match settings.suite.as_str() {
        "tri" => tri(settings),
        "irregular" => irregular(settings),
        "features" => features(settings),
        "distance" => distance(settings),
        "geodesic" => super::geodesic::run(settings),
        "tiling" => super::tiling::run(settings),
        "regular-maps" => super::regular_maps::run(settings),
        "speed" => speed(settings),
        "threads" => threads(settings),
        "nasty" => nasty(settings),
        "fields" => fields(settings),
        "limits" => limits(settings),
        "cad" => cad(settings),
        "solver" => solver(settings),
        other => Err(format!("there is no evaluation {other}")),
    }
}

/// All models at the default size and at 4,000 quads.
fn tri(settings: &Settings) -> Result<Evaluation, String> {
    let mut jobs = Vec::new();
    for (model, input) in models(settings, "tri")? {
        for (variant, options) in [("default", vec![]), ("4000", words("--quads 4000"))] {
            jobs.push(job(&model, variant, &input, options, Measure::JudgeAndOrientation));
        }
    }
    let runs = run_all(settings, jobs, 2);
    let mut text = "# Every triangle model, at the default size and at 4,000 quads\n\n".to_string();
    for variant in ["default", "4000"] {
        let these: Vec<&Run> = runs.iter().filter(|r| r.job.variant == variant).collect();
        let good = these.iter().filter(|r| r.is_good()).count();
        let near = these.iter().filter(|r| count_error(r).is_some_and(|e| e.abs() <= 10.0)).count();
        let [lies, doubted] = [0, 6].map(|code| these.iter().filter(|r| r.is_lie() && r.exit == Some(code)).count());
        text.push_str(&format!(
            "- {variant}: {good} of {} valid, nothing inverted, nothing facing against the input; count within 10 %: \
             {near}; rejected with exit code 0: {lies}, with 6: {doubted}\n",
            these.len()
        ));
    }
    let columns: Vec<Column> = [&BASICS[..], &[("count error %", |r| number(count_error(r), 1))], &SHAPE[..]].concat();
    text.push_str(&format!("\n{}", table(&runs, &columns)));
    Ok(evaluation(text, &runs))
}

/// Irregular vertices and shape, against the limits that are aimed at.
fn irregular(settings: &Settings) -> Result<Evaluation, String> {
    const AIMS: [(&str, u64, u64); 6] = [
        ("fandisk", 3000, 30),
        ("rockerarm", 3000, 36),
        ("fertility", 3000, 48),
        ("botijo", 3000, 74),
        ("3holes", 3000, 26),
        ("armadillo", 10_000, 132),
    ];
    let jobs = AIMS.iter().filter(|(model, ..)| settings.wants(model)).map(|(model, quads, _)| {
        let options = words(&format!("--quads {quads}"));
        job(model, &quads.to_string(), &model_file(settings, model), options, Measure::JudgeAndOrientation)
    });
    let runs = run_all(settings, jobs.collect(), 2);
    let aim = |run: &Run| AIMS.iter().find(|a| a.0 == run.job.model).map_or(0, |a| a.2);
    let met = runs.iter().filter(|r| {
        let irregular = r.judge["irregular"].as_u64().unwrap_or(u64::MAX);
        irregular <= aim(r) && r.judged("sj_mean") >= Some(0.96) && r.judged("angle_mean").is_some_and(|a| a <= 8.5)
    });
    let mut text = format!(
        "# Irregular vertices and shape\n\nAll aims met (irregular interior vertices, mean scaled Jacobian at least \
         0.96, mean angle deviation at most 8.5°): {} of {}\n\n",
        met.count(),
        runs.len()
    );
    let rows: Vec<Vec<String>> = runs
        .iter()
        .map(|r| {
            let mut row: Vec<String> = BASICS.iter().map(|c| (c.1)(r)).collect();
            row.extend([count(&r.judge["irregular"]), aim(r).to_string()]);
            row.extend(SHAPE[1..].iter().map(|c| (c.1)(r)));
            row
        })
        .collect();
    let head: Vec<&str> =
        BASICS.iter().map(|c| c.0).chain(["irregular", "aim"]).chain(SHAPE[1..].iter().map(|c| c.0)).collect();
    text.push_str(&grid(&head, &rows));
    Ok(evaluation(text, &runs))
}

/// Distance of features and boundaries to those of the input.
fn features(settings: &Settings) -> Result<Evaluation, String> {
    const SHARP: [&str; 5] = ["fandisk", "joint", "lever", "pinion", "casting"];
    const OPEN: [&str; 6] = ["beetle", "bunny", "camelhead", "roof", "disk_planar", "punctured_torus"];
    let jobs = SHARP.iter().chain(&OPEN).filter(|m| settings.wants(m)).map(|model| {
        job(model, "10000", &model_file(settings, model), words("--quads 10000"), Measure::JudgeAndOrientation)
    });
    let runs = run_all(settings, jobs.collect(), 2);
    let columns: Vec<Column> = [
        &BASICS[..],
        &[
            ("feature mean %", |r| number(r.judged("feature_mean"), 4)),
            ("feature max %", |r| number(r.judged("feature_max"), 4)),
            ("loops", |r| count(&r.judge["boundary_loops"])),
            ("boundary mean %", |r| number(r.orientation["boundary_mean"].as_f64(), 4)),
            ("boundary max %", |r| number(r.orientation["boundary_max"].as_f64(), 4)),
        ],
        &SHAPE[..],
    ]
    .concat();
    let met = runs.iter().filter(|r| feature_aim_met(r)).count();
    let text = format!(
        "# Features and boundaries at 10,000 quads\n\nDistances in % of the diagonal. Aims: feature mean 0.02 \
         (casting 0.04) and max 0.2; boundary mean 0.04 and max 0.2. Met: {met} of {}\n\n{}",
        runs.len(),
        table(&runs, &columns)
    );
    Ok(evaluation(text, &runs))
}

fn feature_aim_met(run: &Run) -> bool {
    let below = |value: Option<f64>, limit: f64| value.is_none_or(|v| v <= limit);
    let open = !run.orientation["boundary_mean"].is_null();
    let mean = if run.job.model == "casting" { 0.04 } else { 0.02 };
    run.is_good()
        && if open {
            below(run.orientation["boundary_mean"].as_f64(), 0.04)
                && below(run.orientation["boundary_max"].as_f64(), 0.2)
        } else {
            below(run.judged("feature_mean"), mean) && below(run.judged("feature_max"), 0.2)
        }
}

/// Two-sided distance at 10,000 quads.
fn distance(settings: &Settings) -> Result<Evaluation, String> {
    let jobs = models(settings, "tri")?
        .into_iter()
        .map(|(model, input)| job(&model, "10000", &input, words("--quads 10000"), Measure::JudgeAndOrientation));
    let runs = run_all(settings, jobs.collect(), 2);
    let near = runs.iter().filter(|r| r.judged("distance_max").is_some_and(|d| d <= 1.0)).count();
    let counted = runs.iter().filter(|r| count_error(r).is_some_and(|e| e.abs() <= 10.0)).count();
    let columns: Vec<Column> = [&BASICS[..], &[("count error %", |r| number(count_error(r), 1))], &SHAPE[..]].concat();
    let text = format!(
        "# Distance to the input at 10,000 quads\n\nMax two-sided distance at most 1 % of the diagonal: {near} of {}; \
         count within 10 %: {counted}\n\n{}",
        runs.len(),
        table(&runs, &columns)
    );
    Ok(evaluation(text, &runs))
}

/// Seconds and memory of the whole command, one run at a time.
fn speed(settings: &Settings) -> Result<Evaluation, String> {
    const AIMS: [(&str, f64); 5] =
        [("fandisk", 1.5), ("fertility", 2.5), ("armadillo", 3.0), ("botijo", 5.0), ("turbineblade_200k", 10.0)];
    // Once as a user would run it, for the time; once with the report and its extra measurements.
    let mut jobs = Vec::new();
    for (model, _) in AIMS.iter().filter(|a| settings.wants(a.0)) {
        let file = model_file(settings, model);
        jobs.push(Job { report: false, ..job(model, "3000", &file, words("--quads 3000"), Measure::Nothing) });
        jobs.push(job(model, "report", &file, words("--quads 3000"), Measure::JudgeAndOrientation));
    }
    let (timed, runs): (Vec<Run>, Vec<Run>) = run_all(settings, jobs, 1).into_iter().partition(|r| !r.job.report);
    let mut stages: Vec<String> = Vec::new();
    for run in &runs {
        for name in run.report["seconds"].as_object().into_iter().flat_map(|o| o.keys()) {
            if !stages.contains(name) {
                stages.push(name.clone());
            }
        }
    }
    let rows: Vec<Vec<String>> = runs
        .iter()
        .zip(&timed)
        .map(|(r, timed)| {
            let aim = AIMS.iter().find(|a| a.0 == r.job.model).map(|a| a.1);
            let triangles = r.report["input"]["faces"].as_f64();
            let mut row = vec![
                r.job.model.clone(),
                count(&r.report["input"]["faces"]),
                format!("{:.2}", timed.seconds),
                number(aim, 1),
                number(triangles.map(|n| timed.seconds / n * 1e6), 1),
                number(r.report["peak_memory_bytes"].as_f64().map(|b| b / 1e6), 0),
                verdict(r),
            ];
            row.extend(stages.iter().map(|s| number(r.report["seconds"][s].as_f64(), 2)));
            row
        })
        .collect();
    let mut head = vec!["model", "triangles", "seconds", "aim", "µs per triangle", "peak MB", "verdict"];
    head.extend(stages.iter().map(String::as_str));
    let text = format!(
        "# Time and memory of the whole command at 3,000 quads\n\nTwo threads, one run at a time, without a report; columns after \
         the verdict are seconds per stage of a second run.\n\n{}",
        grid(&head, &rows)
    );
    Ok(evaluation(text, &runs))
}

/// The same bytes with one and two threads, and twice in a row.
fn threads(settings: &Settings) -> Result<Evaluation, String> {
    let models = models(settings, "tri")?;
    let mut jobs = Vec::new();
    for (model, input) in &models {
        for (variant, threads) in [("one", 1), ("two", 2), ("again", 2)] {
            let options = words(&format!("--quads 2000 --threads {threads}"));
            jobs.push(job(model, variant, input, options, Measure::Nothing));
        }
    }
    let runs = run_all(settings, jobs, 1);
    let bytes = |model: &str, variant: &str| std::fs::read(settings.work.join(format!("{model}-{variant}.obj"))).ok();
    let rows: Vec<Vec<String>> = models
        .iter()
        .map(|(model, _)| {
            let [one, two, again] = ["one", "two", "again"].map(|v| bytes(model, v));
            let size = one.as_ref().map_or("–".into(), |b| b.len().to_string());
            let word = |same: bool| if same { "same" } else { "**different**" }.to_string();
            vec![model.clone(), size, word(one == two), word(two == again)]
        })
        .collect();
    let same = rows.iter().filter(|r| r[1] != "–" && r[2] == "same" && r[3] == "same").count();
    let failed = rows.iter().filter(|r| r[1] == "–").count();
    let text = format!(
        "# Same bytes for any number of threads\n\nAt 2,000 quads. Identical: {same} of {} models; no output at all: \
         {failed}\n\n{}",
        rows.len(),
        grid(&["model", "bytes", "1 and 2 threads", "twice in a row"], &rows)
    );
    Ok(evaluation(text, &runs))
}

/// Broken input: how each file ends.
fn nasty(settings: &Settings) -> Result<Evaluation, String> {
    let jobs = models(settings, "nasty")?.into_iter().map(|(model, input)| Job {
        reference: Reference::None,
        ..job(&model, "nasty", &input, vec![], Measure::Judge)
    });
    let runs = run_all(settings, jobs.collect(), 2);
    let meshed = runs.iter().filter(|r| matches!(r.exit, Some(0 | 6)) && r.is_good()).count();
    let wrong = runs.iter().filter(|r| r.is_lie() || r.exit.is_none() || r.exit == Some(101)).count();
    let slowest = runs.iter().map(|r| r.seconds).fold(0.0, f64::max);
    let columns: Vec<Column> = [
        &BASICS[..],
        &[
            ("chi", |r| count(&r.judge["chi"])),
            ("of the repaired input", |r| count(&r.report["input"]["chi"])),
            ("inverted", |r| count(&r.judge["inverted"])),
            ("message", |r| r.message.replace('|', "/")),
        ],
    ]
    .concat();
    let text = format!(
        "# Broken input\n\n{meshed} of {} meshed; accepted and rejected by the judge, hung or panicked: {wrong}; the \
         slowest took {slowest:.1} s\n\n{}",
        runs.len(),
        table(&runs, &columns)
    );
    Ok(evaluation(text, &runs))
}

/// Given cross fields are followed.
fn fields(settings: &Settings) -> Result<Evaluation, String> {
    let mut jobs = Vec::new();
    for (model, input) in models(settings, "field/loopycuts")? {
        let field = input.with_extension("rosy").display().to_string();
        let sharp = input.with_extension("sharp").display().to_string();
        let options = ["--quads", "4000", "--field", &field, "--features", &sharp].map(String::from).to_vec();
        jobs.push(job(&model, "given", &input, options, Measure::JudgeAndOrientation));
    }
    let runs = run_all(settings, jobs, 2);
    let good = runs.iter().filter(|r| r.is_good()).count();
    let followed =
        runs.iter().filter(|r| r.is_good() && r.report["field"]["singularities_kept"] == json!(true)).count();
    let columns: Vec<Column> = [
        &BASICS[..],
        &[
            ("singularities given", |r| count(&r.report["field"]["given_singularities"])),
            ("kept", |r| r.report["field"]["singularities_kept"].as_bool().map_or("–".into(), |b| b.to_string())),
        ],
        &SHAPE[..],
    ]
    .concat();
    let text = format!(
        "# Given cross fields and features\n\nValid: {good} of {}; with the singularities of the given field: \
         {followed}\n\n{}",
        runs.len(),
        table(&runs, &columns)
    );
    Ok(evaluation(text, &runs))
}

/// An interrupt and a time limit end a long run within a second and leave nothing behind.
fn limits(settings: &Settings) -> Result<Evaluation, String> {
    let input = model_file(settings, "turbineblade_200k");
    let mut rows = Vec::new();
    for delay in [0.3, 1.0, 2.0] {
        rows.push(interrupted(settings, &input, delay)?);
    }
    let folder = fresh_folder(settings, "time-limit")?;
    let mut command = remesh_command(settings, &input, &folder.join("out.obj"));
    command.args(["--time-limit", "1"]);
    let begin = Instant::now();
    let (exit, message) = wait(&mut command, &settings.work.join("time-limit.err"), settings.timeout);
    rows.push(limit_row("--time-limit 1", exit, begin.elapsed().as_secs_f64() - 1.0, &folder, &message));
    let head = ["stop", "exit", "seconds until it ended", "files left", "message"];
    let text = format!("# Interrupts and time limits on turbineblade_200k\n\n{}", grid(&head, &rows));
    Ok(Evaluation { markdown: text, runs: rows.into_iter().map(|r| json!(r)).collect(), broken: Vec::new() })
}

fn interrupted(settings: &Settings, input: &Path, delay: f64) -> Result<Vec<String>, String> {
    let folder = fresh_folder(settings, "interrupt")?;
    let log = settings.work.join("interrupt.err");
    let stderr = std::fs::File::create(&log).map_err(|e| e.to_string())?;
    let mut child =
        remesh_command(settings, input, &folder.join("out.obj")).stderr(stderr).spawn().map_err(|e| e.to_string())?;
    std::thread::sleep(Duration::from_secs_f64(delay));
    let begin = Instant::now();
    let _ = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    let exit = child.wait().map_err(|e| e.to_string())?.code();
    let message = std::fs::read_to_string(&log).unwrap_or_default();
    Ok(limit_row(&format!("interrupt after {delay} s"), exit, begin.elapsed().as_secs_f64(), &folder, &message))
}

fn limit_row(name: &str, exit: Option<i32>, seconds: f64, folder: &Path, message: &str) -> Vec<String> {
    let files = std::fs::read_dir(folder).map_or(0, |d| d.count());
    let line = message.lines().rev().find(|l| l.starts_with("error")).unwrap_or_default();
    vec![
        name.into(),
        exit.map_or("–".into(), |c| c.to_string()),
        format!("{seconds:.2}"),
        files.to_string(),
        line.into(),
    ]
}

fn remesh_command(settings: &Settings, input: &Path, output: &Path) -> Command {
    let mut command = Command::new(&settings.binary);
    command.arg("remesh").arg(input).arg("-o").arg(output).args(["--quads", "20000", "--progress", "none"]);
    command
}

fn fresh_folder(settings: &Settings, name: &str) -> Result<PathBuf, String> {
    let folder = settings.work.join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    Ok(folder)
}

/// Ways to round: on one model at several resolutions, and the two quick ones on all models.
fn solver(settings: &Settings) -> Result<Evaluation, String> {
    let list = solver_rows(&model_file(settings, "rockerarm"), &[])?;
    // Energy relative to the naive re-solve of the same problem and resolution.
    let naive = |row: &Value| {
        let same =
            |r: &&Value| r["problem"] == row["problem"] && r["triangles"] == row["triangles"] && r["method"] == "naive";
        list.iter().find(same).and_then(|r| r["energy"].as_f64())
    };
    let rows: Vec<Vec<String>> = list
        .iter()
        .map(|row| {
            let text = |key: &str| row[key].as_str().unwrap_or("–").to_string();
            let energy = row["energy"].as_f64();
            let ratio = energy.zip(naive(row)).map(|(e, n)| 100.0 * (e - n) / n);
            let proven = row["exact"]["proven"]
                .as_bool()
                .map_or("–".into(), |p| if p { "proven".into() } else { number(row["exact"]["gap"].as_f64(), 4) });
            vec![
                text("problem"),
                count(&row["triangles"]),
                count(&row["integers"]),
                text("method"),
                number(row["seconds"].as_f64(), 3),
                number(energy, 4),
                number(ratio, 2),
                proven,
            ]
        })
        .collect();
    let head = ["problem", "triangles", "integers", "method", "seconds", "energy", "against naive %", "optimum"];
    let (quick, quick_rows) = greedy_and_direct(settings)?;
    let text = format!(
        "# Ways to round\n\n## Rockerarm\n\nCross field and integer-grid map on isotropic meshes of the model; one \
         thread. A dash for the energy: given up after fifteen minutes; the exact search after one, or refused where its \
         dense matrix would be too large.\n\n{}\n{quick}",
        grid(&head, &rows)
    );
    Ok(Evaluation { markdown: text, runs: list.into_iter().chain(quick_rows).collect(), broken: Vec::new() })
}

/// What the example of the solver prints for a model.
fn solver_rows(model: &Path, further: &[&str]) -> Result<Vec<Value>, String> {
    let model = model.display().to_string();
    let words = ["run", "--release", "--quiet", "--package", "quadloom", "--example", "solver_table", "--", &model];
    let printed = crate::shell::output("cargo", &[&words[..], further].concat())?;
    serde_json::from_str(&printed).map_err(|e| format!("solver_table: {e}"))
}

/// Energies of greedy and of direct rounding, on isotropic meshes of all models.
fn greedy_and_direct(settings: &Settings) -> Result<(String, Vec<Value>), String> {
    const PROBLEMS: [&str; 2] = ["field", "map"];
    const METHODS: [&str; 2] = ["direct", "greedy"];
    let (mut rows, mut all, mut no_worse) = (Vec::new(), Vec::new(), 0);
    for (model, file) in models(settings, "tri")? {
        let found = solver_rows(&file, &["5000", "direct,greedy"])?;
        let energy = |problem: &str, method: &str| {
            let row = found.iter().find(|r| r["problem"] == problem && r["method"] == method);
            row.and_then(|r| r["energy"].as_f64())
        };
        let energies = PROBLEMS.map(|p| METHODS.map(|m| energy(p, m)));
        let holds = |[direct, greedy]: &[Option<f64>; 2]| greedy.is_some_and(|g| direct.is_none_or(|d| g <= d));
        no_worse += usize::from(energies.iter().all(holds));
        let numbers = energies.as_flattened().iter().map(|&e| number(e, 4));
        rows.push([model.clone()].into_iter().chain(numbers).collect());
        all.extend(found.into_iter().map(|mut row| {
            row["model"] = model.clone().into();
            row
        }));
    }
    let head = ["model", "field, direct", "field, greedy", "map, direct", "map, greedy"];
    let text = format!(
        "## Greedy and direct\n\nEnergies on isotropic meshes of 5,000 triangles. Greedy is no worse than direct in both \
         problems on {no_worse} of {} models.\n\n{}",
        rows.len(),
        grid(&head, &rows)
    );
    Ok((text, all))
}

/// Random solids with creases, smooth blends, and damaged variants of fandisk; a script makes them.
fn cad(settings: &Settings) -> Result<Evaluation, String> {
    let folder = settings.work.join("solids");
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let script = root().join("xtask/scripts/cad_solids.py");
    let fandisk = model_file(settings, "fandisk");
    let made = super::runner::python(&[script.as_os_str(), folder.as_os_str(), fandisk.as_os_str()]);
    let names = made["solids"].as_array().ok_or_else(|| format!("cad_solids.py: {made}"))?;
    let jobs = names.iter().filter_map(Value::as_str).filter(|n| settings.wants(n)).map(|name| {
        // Damaged variants have no clean topology to be compared with; the command's own report has the repaired one.
        let reference =
            if name.starts_with("fandisk_degenerate") { Reference::File(fandisk.clone()) } else { Reference::Input };
        Job {
            reference,
            ..job(name, "default", &folder.join(format!("{name}.obj")), vec![], Measure::JudgeAndOrientation)
        }
    });
    let runs = run_all(settings, jobs.collect(), 2);
    let good = runs.iter().filter(|r| r.is_good()).count();
    let columns: Vec<Column> = [&BASICS[..], &SHAPE[..]].concat();
    let text = format!(
        "# Random solids, smooth blends, damaged fandisk\n\nValid, nothing inverted, nothing facing against the input: \
         {good} of {}\n\n{}",
        runs.len(),
        table(&runs, &columns)
    );
    Ok(evaluation(text, &runs))
}

fn evaluation(markdown: String, runs: &[Run]) -> Evaluation {
    Evaluation { markdown, runs: runs.iter().map(Run::to_json).collect(), broken: Vec::new() }
}

fn job(model: &str, variant: &str, input: &Path, options: Vec<String>, measure: Measure) -> Job {
    Job {
        model: model.into(),
        variant: variant.into(),
        input: input.into(),
        options,
        reference: Reference::Input,
        measure,
        report: true,
    }
}

/// Percent by which the count misses what the command was asked for, or chose itself.
fn count_error(run: &Run) -> Option<f64> {
    let (asked, reached) = (run.report["count"]["asked"].as_f64()?, run.judged("faces")?);
    Some(100.0 * (reached - asked) / asked)
}

fn words(line: &str) -> Vec<String> {
    line.split_whitespace().map(String::from).collect()
}

fn model_file(settings: &Settings, model: &str) -> PathBuf {
    settings.shared.join("models/tri").join(format!("{model}.obj"))
}

/// The OBJ files of a folder of models that were asked for, by name.
fn models(settings: &Settings, folder: &str) -> Result<Vec<(String, PathBuf)>, String> {
    let folder = settings.shared.join("models").join(folder);
    let entries = std::fs::read_dir(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut files: Vec<PathBuf> = entries.filter_map(|e| Some(e.ok()?.path())).collect();
    files.retain(|p| p.extension().is_some_and(|e| e == "obj"));
    files.sort();
    let named = files.into_iter().filter_map(|p| Some((p.file_stem()?.to_str()?.to_string(), p)));
    Ok(named.filter(|(name, _)| settings.wants(name)).collect())
}
