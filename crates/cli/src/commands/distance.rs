//! `quadloom distance`

use super::files::Files;
use super::{OutputKind, read, stage_text, use_threads};
use crate::args::DistanceArgs;
use crate::console::Console;
use crate::{exit, watchdog};
use quadloom::RemeshError;
use quadloom::distance::{
    Curve, DistanceRequest, From, measure_distances, scene, stage_distances, stage_lines, stage_lines_svg,
};
use quadloom::io::Batch;
use quadloom::view::render_html;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Measures distances on the input.
pub fn run(args: &DistanceArgs) -> Result<ExitCode, RemeshError> {
    let fewer = use_threads(args.run.threads);
    let progress = watchdog::start(args.run.time_limit);
    let (console, progress) = Console::new(&args.run, progress);
    fewer.iter().for_each(|note| console.note(note));
    let (isolines_to, paths_to) = (isolines_path(args), paths_path(args));
    files(args, isolines_to.as_ref(), paths_to.as_ref()).check()?;
    let soup = read(&args.input)?;
    let request = DistanceRequest {
        from: args.from.clone(),
        start: args.start.clone(),
        epsilon: args.epsilon,
        snap_rel: args.snap,
        refine: args.refine,
        picture: args.view.is_some(),
        isolines: args.isolines,
        path_from: args.path_from.clone(),
    };
    let result = measure_distances(&soup, &request, &progress).map_err(|e| e.of_input(&args.input))?;
    console.warnings(&result.warnings);
    let _writing = watchdog::while_writing();
    let mut files = Batch::new();
    stage_distances(&mut files, &args.output, soup, &result)?;
    if let Some(path) = &isolines_to {
        stage_curves(&mut files, path, &result.isolines)?;
    }
    if let Some(path) = &paths_to {
        let found: Vec<Curve> = result.paths.iter().filter(|p| !p.points.is_empty()).cloned().collect();
        stage_curves(&mut files, path, &found)?;
    }
    if let Some(path) = &args.report {
        let report = serde_json::json!({ "distance": result.report, "warnings": result.warnings });
        stage_text(&mut files, path, &format!("{report:#}\n"))?;
    }
    if let Some(path) = &args.view {
        stage_text(&mut files, path, &render_html(&scene(&result, &args.input)))?;
    }
    files.commit()?;
    let report = &result.report;
    console.note(&format!(
        "{}: {} vertices, largest distance {:.6e}, wavefront {:.3} s",
        args.output.display(),
        report.vertices - report.unreached,
        report.largest_distance,
        report.seconds.wavefront
    ));
    let missed = result.warnings.iter().any(|w| w.misses_request());
    // The surface and its windows need not be taken apart before the process ends.
    std::mem::forget(result);
    Ok(ExitCode::from(if missed { exit::MISSED } else { exit::DONE }))
}

fn stage_curves(files: &mut Batch, path: &Path, curves: &[Curve]) -> Result<(), RemeshError> {
    match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
        Some("svg") => stage_lines_svg(files, path, curves),
        _ => stage_lines(files, path, curves),
    }
}

/// The output's name with another ending.
fn beside(output: &Path, ending: &str) -> PathBuf {
    output.with_extension(ending)
}

fn isolines_path(args: &DistanceArgs) -> Option<PathBuf> {
    let default = || beside(&args.output, "isolines.obj");
    args.isolines.map(|_| args.isolines_to.clone().unwrap_or_else(default))
}

fn paths_path(args: &DistanceArgs) -> Option<PathBuf> {
    let default = || beside(&args.output, "paths.obj");
    (!args.path_from.is_empty()).then(|| args.paths_to.clone().unwrap_or_else(default))
}

fn files(args: &DistanceArgs, isolines: Option<&PathBuf>, paths: Option<&PathBuf>) -> Files {
    let mut files = Files::of(&args.input);
    for from in &args.from {
        if let From::Curve(path) = from {
            files = files.reads("a curve (--from)", Some(path));
        }
    }
    files
        .writes("the distances (-o)", Some(&args.output), OutputKind::Distances)
        .writes("the isolines (--isolines-to)", isolines, OutputKind::Lines)
        .writes("the paths (--paths-to)", paths, OutputKind::Lines)
        .writes("the report (--report)", args.report.as_ref(), OutputKind::Text)
        .writes("the page (--view)", args.view.as_ref(), OutputKind::Page)
}
