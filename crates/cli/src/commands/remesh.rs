//! `quadloom remesh`

use super::files::Files;
use super::{OutputKind, name_places, read, stage, stage_text, use_threads};
use crate::args::{AdaptToArg, FallbackArg, MethodArg, RemeshArgs};
use crate::console::Console;
use crate::{exit, watchdog};
use quadloom::io::{Batch, FeatureFile, Format, read_features, read_guides, read_singularities, read_vertex_pairs};
use quadloom::view::render_html;
use quadloom::{
    AdaptTo, FaceSoup, Fallback, GivenField, Method, RemeshError, RemeshOptions, RemeshResult, Report, Target, output,
    remesh, scene,
};
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

/// Makes quads of a surface and writes what was asked for, all at the end.
pub fn run(args: &RemeshArgs) -> Result<ExitCode, RemeshError> {
    let begin = Instant::now();
    let fewer = use_threads(args.run.threads);
    let progress = watchdog::start(args.run.time_limit);
    let (console, progress) = Console::new(&args.run, progress);
    fewer.iter().for_each(|note| console.note(note));
    files(args).check()?;
    progress.report("read", 0.0);
    let soup = read(&args.input)?;
    let features = args.features.as_ref().map(read_features).transpose()?;
    let options = options(args, &soup, features.as_ref())?;
    let mut result = remesh(&soup, &options, &progress).map_err(|e| named(args, e))?;
    name_places(&mut result.report.warnings, features.as_ref(), &soup);
    if options.target == Target::Auto {
        console.note(&default_count(&result));
    }
    console.warnings(&result.report.warnings);
    // From here on the run is not interrupted: every file is written whole.
    let _writing = watchdog::while_writing();
    for warning in write_all(args, &result)? {
        console.note(&warning);
    }
    console.note(&summary(&result, &args.output, begin.elapsed().as_secs_f64()));
    let missed = result.report.warnings.iter().any(|w| w.misses_request());
    Ok(ExitCode::from(if missed { exit::MISSED } else { exit::DONE }))
}

fn files(args: &RemeshArgs) -> Files {
    let field_surface = args.write_field.as_deref().map(output::field_surface_path);
    Files::of(&args.input)
        .reads("the features (--features)", args.features.as_ref())
        .reads("the curves (--guides)", args.guides.as_ref())
        .reads("the field (--field)", args.field.as_ref())
        .reads("the singularities (--singularities)", args.singularities.as_ref())
        .reads("the ties (--ties)", args.ties.as_ref())
        .writes("the quads (-o)", Some(&args.output), OutputKind::Surface)
        .writes("the field (--write-field)", args.write_field.as_ref(), OutputKind::Field)
        .writes("the surface of the field (--write-field)", field_surface.as_ref(), OutputKind::Surface)
        .writes("the map (--write-map)", args.write_map.as_ref(), OutputKind::Map)
        .writes("the report (--report)", args.report.as_ref(), OutputKind::Text)
        .writes("the page (--view)", args.view.as_ref(), OutputKind::Page)
}

/// An error with the name of the file that it is about.
fn named(args: &RemeshArgs, error: RemeshError) -> RemeshError {
    let beside = match &error {
        RemeshError::Mismatch { what: "the list of singularities", .. } => args.singularities.as_ref(),
        RemeshError::Mismatch { what: "the cross field", .. } => args.field.as_ref(),
        _ => None,
    };
    let file = beside.map_or_else(|| args.input.clone(), |path| path.display().to_string());
    error.of_input(&file)
}

fn options(args: &RemeshArgs, soup: &FaceSoup, features: Option<&FeatureFile>) -> Result<RemeshOptions, RemeshError> {
    let features = features.map(|file| file.vertex_pairs(soup)).transpose()?.unwrap_or_default();
    let guides = match &args.guides {
        Some(path) => read_guides(path)?.into_iter().map(|g| g.points).collect(),
        None => Vec::new(),
    };
    let singularities = match &args.singularities {
        Some(path) => Some(read_singularities(path)?.iter().map(|s| (s.vertex, s.quarters)).collect()),
        None => None,
    };
    let mut ties = args.tie.clone();
    if let Some(path) = &args.ties {
        ties.extend(read_vertex_pairs(path)?);
    }
    let field = args.field.as_deref().map(quadloom::input::load_field).transpose()?;
    Ok(RemeshOptions {
        target: target(args),
        tolerance: args.tolerance / 100.0,
        sharp_angle: args.sharp_angle.0,
        features,
        keep_boundary: args.keep_boundary,
        adaptivity: args.adaptivity,
        adapt_to: match args.adapt_to {
            AdaptToArg::Curvature => AdaptTo::Curvature,
            AdaptToArg::FeatureSize => AdaptTo::FeatureSize,
        },
        anisotropy: args.anisotropy,
        curl_correction: args.curl_correction,
        density: args.density.clone(),
        field: field.map(|directions| GivenField { directions }),
        singularities,
        other_singularities: args.other_singularities,
        ties,
        relocate: args.relocate,
        guides,
        method: match args.method {
            MethodArg::Direct => Method::Direct,
            MethodArg::Greedy => Method::Greedy,
        },
        fallback: match args.fallback {
            FallbackArg::Split => Fallback::Split,
            FallbackArg::Off => Fallback::Off,
        },
        seed: args.run.seed,
    })
}

fn target(args: &RemeshArgs) -> Target {
    match (args.quads, args.edge_length, args.scale) {
        (Some(n), ..) => Target::Quads(n),
        (_, Some(length), _) => Target::EdgeLength(length),
        (.., Some(scale)) => Target::Scale(scale),
        _ => Target::Auto,
    }
}

/// Writes all files or none.
fn write_all(args: &RemeshArgs, result: &RemeshResult) -> Result<Vec<String>, RemeshError> {
    let mut files = Batch::new();
    let quads = output::quad_surface(result, Format::from_path(&args.output));
    let mut warnings = stage(&mut files, &args.output, &quads)?;
    if let Some(path) = &args.write_field {
        output::stage_field(&mut files, path, result)?;
    }
    if let Some(path) = &args.write_map {
        warnings.extend(stage(&mut files, path, &output::map_surface(result))?);
    }
    if let Some(path) = &args.view {
        stage_text(&mut files, path, &render_html(&scene::of_result(result, &title(args))))?;
    }
    if let Some(path) = &args.report {
        stage_text(&mut files, path, &report_text(&result.report))?;
    }
    files.commit()?;
    Ok(warnings)
}

/// Pretty JSON with keys in the order of the report.
fn report_text(report: &Report) -> String {
    // A struct of plain data always serialises.
    serde_json::to_string_pretty(report).unwrap_or_default() + "\n"
}

/// What was aimed at where nothing was asked for.
fn default_count(result: &RemeshResult) -> String {
    let (asked, triangles) = (result.report.count.asked, result.input.face_count());
    let why = match triangles / 4 {
        quarter if quarter < asked => "the fewest that are aimed at by default",
        quarter if quarter > asked => "the most that are aimed at by default",
        _ => "a quarter of the triangles",
    };
    format!("note: aimed at {asked} quads, {why}; --quads N asks for another number")
}

fn title(args: &RemeshArgs) -> String {
    let name =
        Path::new(&args.input).file_name().map_or_else(|| args.input.clone(), |n| n.to_string_lossy().into_owned());
    format!("{name} in quads")
}

/// The result in a line; seconds: of the whole command.
fn summary(result: &RemeshResult, path: &Path, seconds: f64) -> String {
    let report = &result.report;
    format!(
        "{}: {} quads, {} irregular vertices, scaled Jacobian {:.3} (worst {:.3}), {seconds:.2} s",
        path.display(),
        report.count.reached,
        report.irregular.interior,
        report.quality.scaled_jacobian_mean,
        report.quality.scaled_jacobian_min,
    )
}
