//! `quadloom regular-map`

mod tables;

use super::files::Files;
use super::{OutputKind, done, stage_text, use_threads};
use crate::args::RunArgs;
use crate::console::Console;
use crate::map_args::{
    CentreArg, EdgesArg, FlatArgs, MapArgs, MapVerb, ModelArg, RealizeArgs, RegularMapArgs, SkeletonArg, SurfaceArgs,
    TubifyArgs,
};
use crate::{exit, watchdog};
use quadloom::RemeshError;
use quadloom::io::{Batch, Format, WriteWarning};
use quadloom::regular_map::{self as maps, MapSpec, RealizeRequest, SurfaceReport};
use quadloom::regular_maps::tiling::{Centre, Model};
use quadloom::tubification::realize::{RealizeOptions, SkeletonKind};
use quadloom::tubification::{DrawOptions, Drawn, EdgeStyle};
use quadloom::view::render_map_html;
use serde::Serialize;
use std::path::Path;
use std::process::ExitCode;

/// Lists, finds, draws and builds regular maps.
pub fn run(args: &RegularMapArgs) -> Result<ExitCode, RemeshError> {
    match &args.verb {
        MapVerb::List(args) => tables::list(args),
        MapVerb::Info(args) => tables::info(args),
        MapVerb::Tile(args) => tile(args),
        MapVerb::Match(args) => tables::find(args),
        MapVerb::Realize(args) => realize(args),
        MapVerb::Tubify(args) => tubify(args),
        MapVerb::Search(args) => tables::search(args),
    }
}

fn spec(args: &MapArgs) -> MapSpec {
    match (&args.map, &args.presentation) {
        (_, Some(text)) => MapSpec::Presentation(text.clone()),
        (name, None) => MapSpec::Name(name.clone().unwrap_or_default()),
    }
}

fn tile(args: &FlatArgs) -> Result<ExitCode, RemeshError> {
    Files::default().writes("the picture (-o)", Some(&args.output), OutputKind::Picture).check()?;
    let source = maps::find_map(&spec(&args.source))?;
    let request = maps::FlatRequest {
        model: match args.model {
            ModelArg::Poincare => Model::Poincare,
            ModelArg::Klein => Model::Klein,
            ModelArg::Jemisphere => Model::Jemisphere,
        },
        centre: match args.centre {
            CentreArg::Face => Centre::Face,
            CentreArg::Vertex => Centre::Vertex,
            CentreArg::Edge => Centre::Edge,
        },
        colors: args.colors.clone(),
        size: args.size,
        triangles: args.triangles,
        numbers: args.numbers,
    };
    let mut files = Batch::new();
    maps::stage_flat(&mut files, &args.output, &source, &request)?;
    files.commit()?;
    done()
}

fn options(args: &SurfaceArgs, run: &RunArgs) -> RealizeOptions {
    let mut options = RealizeOptions {
        skeleton: match args.skeleton {
            SkeletonArg::Auto => SkeletonKind::Auto,
            SkeletonArg::Drawn => SkeletonKind::Drawn,
            SkeletonArg::Relaxed => SkeletonKind::Relaxed,
        },
        thickness: args.thickness,
        allow_intersections: args.allow_intersections,
        ..RealizeOptions::default()
    };
    options.relax.symmetry = args.symmetry;
    options.relax.seed = options.relax.seed.wrapping_add(run.seed);
    options
}

fn realize(args: &RealizeArgs) -> Result<ExitCode, RemeshError> {
    let fewer = use_threads(args.run.threads);
    let progress = watchdog::start(args.run.time_limit);
    let (console, progress) = Console::new(&args.run, progress);
    fewer.iter().for_each(|note| console.note(note));
    Files::default()
        .writes("the surface (-o)", Some(&args.surface.output), OutputKind::Surface)
        .writes("the report (--report)", args.report.as_ref(), OutputKind::Text)
        .writes("the page (--view)", args.view.as_ref(), OutputKind::Page)
        .check()?;
    let source = maps::find_map(&spec(&args.source))?;
    let request = realize_request(args);
    let result = maps::realize_map(&source, &request, &progress)?;
    let _writing = watchdog::while_writing();
    let mut files = Batch::new();
    warn(&console, &args.surface.output, &maps::stage_realized(&mut files, &args.surface.output, &result)?);
    stage_report(&mut files, args.report.as_deref(), &result.report)?;
    if let Some(path) = &args.view {
        stage_text(&mut files, path, &render_map_html(&maps::map_scene(&result)?))?;
    }
    files.commit()?;
    let report = &result.report;
    console.note(&format!(
        "{}: {}, {}, {}, rotations {}, {} triangles, {} self-intersections, {:.2} s",
        args.surface.output.display(),
        report.title(),
        counted(report.surface_of.junctions, "junction"),
        counted(report.surface_of.tubes, "tube"),
        report.surface_of.symmetry.group,
        report.surface.faces,
        report.surface.self_intersections,
        report.seconds
    ));
    Ok(code_of(&report.surface))
}

fn counted(n: usize, noun: &str) -> String {
    format!("{n} {noun}{}", if n == 1 { "" } else { "s" })
}

fn warn(console: &Console, path: &Path, warnings: &[WriteWarning]) {
    warnings.iter().for_each(|warning| console.note(&format!("warning: {}: {warning}", path.display())));
}

fn stage_report<T: Serialize>(files: &mut Batch, path: Option<&Path>, report: &T) -> Result<(), RemeshError> {
    let Some(path) = path else { return Ok(()) };
    let text = serde_json::to_string_pretty(report).unwrap_or_default();
    stage_text(files, path, &format!("{text}\n"))
}

/// A surface that meets itself is written only where that is allowed, and is not what one would like.
fn code_of(surface: &SurfaceReport) -> ExitCode {
    ExitCode::from(if surface.self_intersections > 0 { exit::MISSED } else { exit::DONE })
}

fn realize_request(args: &RealizeArgs) -> RealizeRequest {
    let relief = Format::from_path(&args.surface.output) == Some(Format::Stl);
    let edges = args.edges.unwrap_or(if relief { EdgesArg::Relief } else { EdgesArg::Bands });
    let width = args.edge_width.unwrap_or(if edges == EdgesArg::Bands { BAND } else { RIDGE });
    let mut options = options(&args.surface, &args.run);
    options.draw = DrawOptions {
        drawn: if args.dual { Drawn::Dual } else { Drawn::Map },
        edges: match edges {
            EdgesArg::None => EdgeStyle::None,
            EdgesArg::Bands => EdgeStyle::Bands(width),
            EdgesArg::Tubes => EdgeStyle::Tubes(width),
            EdgesArg::Relief => EdgeStyle::Relief(width),
        },
        height: match edges {
            EdgesArg::None | EdgesArg::Bands => 0.0,
            EdgesArg::Tubes | EdgesArg::Relief => RELIEF,
        },
        steps: [usize::from(args.steps); 2],
    };
    RealizeRequest { on: args.on.clone(), options, colors: args.colors.clone(), size: args.surface.size }
}

/// Width of bands: lines, even where a face is drawn out along a tube.
const BAND: f64 = 0.05;

/// Width of what stands out: a nozzle can print it.
const RIDGE: f64 = 0.12;

/// Height of ridges and reliefs in tube radii.
const RELIEF: f64 = 0.12;

fn tubify(args: &TubifyArgs) -> Result<ExitCode, RemeshError> {
    let fewer = use_threads(args.run.threads);
    let progress = watchdog::start(args.run.time_limit);
    let (console, progress) = Console::new(&args.run, progress);
    fewer.iter().for_each(|note| console.note(note));
    Files::default()
        .writes("the surface (-o)", Some(&args.surface.output), OutputKind::Surface)
        .writes("the report (--report)", args.report.as_ref(), OutputKind::Text)
        .check()?;
    let source = maps::find_map(&spec(&args.source))?;
    let result = maps::tubify_map(&source, &options(&args.surface, &args.run), args.surface.size, &progress)?;
    let _writing = watchdog::while_writing();
    let mut files = Batch::new();
    warn(&console, &args.surface.output, &maps::stage_tubes(&mut files, &args.surface.output, &result)?);
    stage_report(&mut files, args.report.as_deref(), &result.report)?;
    files.commit()?;
    console.note(&format!(
        "{}: tubes of {}, {}, {}, genus {}, rotations {}, {} self-intersections, {:.2} s",
        args.surface.output.display(),
        source.name,
        counted(result.report.tubes.junctions, "junction"),
        counted(result.report.tubes.tubes, "tube"),
        result.report.surface.genus,
        result.report.tubes.symmetry.group,
        result.report.surface.self_intersections,
        result.report.seconds
    ));
    Ok(code_of(&result.report.surface))
}
