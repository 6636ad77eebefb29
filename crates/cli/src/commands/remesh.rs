//! `quadloom remesh`

use super::{OutputKind, check_output, read, use_threads, write, write_text};
use crate::args::{AdaptToArg, FallbackArg, MethodArg, RemeshArgs};
use crate::console::Console;
use crate::{exit, watchdog};
use quadloom::io::{Format, read_features, read_guides, read_singularities, read_vertex_pairs};
use quadloom::view::render_html;
use quadloom::{
    AdaptTo, FaceSoup, Fallback, GivenField, Method, RemeshError, RemeshOptions, RemeshResult, Report, Target, output,
    remesh, scene,
};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Makes quads of a surface and writes what was asked for, all at the end.
pub fn run(args: &RemeshArgs) -> Result<ExitCode, RemeshError> {
    use_threads(args.run.threads);
    let progress = watchdog::start(args.run.time_limit);
    let (console, progress) = Console::new(&args.run, progress);
    check_outputs(args)?;
    progress.report("read", 0.0);
    let soup = read(&args.input)?;
    let options = options(args, &soup)?;
    let result = remesh(&soup, &options, &progress)?;
    if options.target == Target::Auto {
        console.note(&default_count(&result));
    }
    console.warnings(&result.report.warnings);
    // From here on the run is not interrupted: every file is written whole.
    let _writing = watchdog::while_writing();
    for warning in write_all(args, &result)? {
        console.note(&warning);
    }
    console.note(&summary(&result, &args.output));
    let missed = result.report.warnings.iter().any(|w| w.misses_request());
    Ok(ExitCode::from(if missed { exit::MISSED } else { exit::DONE }))
}

fn check_outputs(args: &RemeshArgs) -> Result<(), RemeshError> {
    check_output(&args.output, OutputKind::Surface)?;
    let others = [
        (&args.write_field, OutputKind::Field),
        (&args.write_map, OutputKind::Surface),
        (&args.report, OutputKind::Text),
        (&args.view, OutputKind::Page),
    ];
    let mut taken = vec![absolute(&args.output)];
    for (path, kind) in others.into_iter().filter_map(|(path, kind)| Some((path.as_ref()?, kind))) {
        check_output(path, kind)?;
        if taken.contains(&absolute(path)) {
            return Err(RemeshError::SameFile(path.clone()));
        }
        taken.push(absolute(path));
    }
    Ok(())
}

/// A path with its folder resolved, so that two names of one file are the same.
fn absolute(path: &Path) -> PathBuf {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let folder = folder.canonicalize().unwrap_or_else(|_| folder.to_path_buf());
    path.file_name().map_or_else(|| folder.clone(), |name| folder.join(name))
}

fn options(args: &RemeshArgs, soup: &FaceSoup) -> Result<RemeshOptions, RemeshError> {
    let features = match &args.features {
        Some(path) => read_features(path)?.vertex_pairs(soup)?,
        None => Vec::new(),
    };
    let guides = match &args.guides {
        Some(path) => read_guides(path)?.into_iter().map(|g| g.points).collect(),
        None => Vec::new(),
    };
    let singularities = match &args.singularities {
        Some(path) => read_singularities(path)?.iter().map(|s| (s.vertex, s.quarters)).collect(),
        None => Vec::new(),
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
        measure_distance: args.report.is_some() || args.view.is_some(),
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

fn write_all(args: &RemeshArgs, result: &RemeshResult) -> Result<Vec<String>, RemeshError> {
    let mut warnings = write(&args.output, &output::quad_surface(result, Format::from_path(&args.output)))?;
    if let Some(path) = &args.write_field {
        output::write_field(path, result)?;
    }
    if let Some(path) = &args.write_map {
        warnings.extend(write(path, &output::map_surface(result))?);
    }
    if let Some(path) = &args.view {
        write_text(path, &render_html(&scene::of_result(result, &title(args))))?;
    }
    if let Some(path) = &args.report {
        write_text(path, &report_text(&result.report))?;
    }
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

fn summary(result: &RemeshResult, path: &Path) -> String {
    let report = &result.report;
    let seconds: f64 = report.seconds.iter().map(|(_, s)| s).sum();
    format!(
        "{}: {} quads, {} irregular vertices, scaled Jacobian {:.3} (worst {:.3}), {seconds:.2} s",
        path.display(),
        report.count.reached,
        report.irregular.interior,
        report.quality.scaled_jacobian_mean,
        report.quality.scaled_jacobian_min,
    )
}
