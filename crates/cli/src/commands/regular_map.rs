//! `quadloom regular-map`

use super::files::Files;
use super::{OutputKind, done, stage_text, use_threads};
use crate::args::RunArgs;
use crate::console::Console;
use crate::map_args::{
    CentreArg, EdgesArg, FlatArgs, InfoArgs, ListArgs, MapArgs, MapVerb, MatchArgs, ModelArg, RealizeArgs,
    RegularMapArgs, SearchArgs, SkeletonArg, SurfaceArgs, TubifyArgs,
};
use crate::{exit, watchdog};
use quadloom::io::{Batch, Format};
use quadloom::regular_map as maps;
use quadloom::regular_map::{MapReport, MapSpec, RealizeRequest, SurfaceReport};
use quadloom::regular_maps::catalogue::COMPLETE;
use quadloom::regular_maps::realize::{RealizeOptions, SkeletonKind};
use quadloom::regular_maps::tiling::{Centre, Model};
use quadloom::regular_maps::{DrawOptions, Drawn, EdgeStyle};
use quadloom::view::render_map_html;
use quadloom::{Progress, RemeshError};
use serde_json::json;
use std::ops::RangeInclusive;
use std::process::ExitCode;

/// Lists, finds, draws and builds regular maps.
pub fn run(args: &RegularMapArgs) -> Result<ExitCode, RemeshError> {
    match &args.verb {
        MapVerb::List(args) => list(args),
        MapVerb::Info(args) => info(args),
        MapVerb::Tile(args) => tile(args),
        MapVerb::Match(args) => find(args),
        MapVerb::Realize(args) => realize(args),
        MapVerb::Tubify(args) => tubify(args),
        MapVerb::Search(args) => search(args),
    }
}

fn spec(args: &MapArgs) -> MapSpec {
    match (&args.map, &args.presentation) {
        (_, Some(text)) => MapSpec::Presentation(text.clone()),
        (name, None) => MapSpec::Name(name.clone().unwrap_or_default()),
    }
}

fn list(args: &ListArgs) -> Result<ExitCode, RemeshError> {
    let found = maps::list(args.genus.clone(), args.kind)?;
    note_gaps(args.genus.as_ref());
    if args.json {
        println!("{:#}", json!(found));
        return done();
    }
    print_maps(&found);
    done()
}

fn print_maps(found: &[MapReport]) {
    println!("{:<10} {:<18} {:>6} {:>6} {:>6} {:>6} {:>6}", "name", "identifier", "genus", "order", "V", "E", "F");
    for map in found {
        println!(
            "{:<10} {:<18} {:>6} {:>6} {:>6} {:>6} {:>6}",
            if map.name == map.identifier { "" } else { &map.name },
            map.identifier,
            map.genus,
            map.order,
            map.vertices,
            map.edges,
            map.faces
        );
    }
    println!("{} maps", found.len());
}

/// Says where a list is not all there is.
fn note_gaps(genera: Option<&RangeInclusive<usize>>) {
    let Some(genera) = genera else { return };
    if *genera.start() < 2 {
        eprintln!("note: lists begin at genus 2; maps on the sphere and the torus go by names (cube, {{4,4}}_(3,0))");
    }
    if genera.end() > COMPLETE.end() {
        let (start, end) = (COMPLETE.start(), COMPLETE.end());
        eprintln!("note: the list is complete for genus {start} to {end}; `quadloom regular-map search` goes on");
    }
}

fn info(args: &InfoArgs) -> Result<ExitCode, RemeshError> {
    let source = maps::find_map(&spec(&args.source))?;
    let facts = maps::info(&source);
    if args.json {
        println!("{:#}", json!(facts));
        return done();
    }
    for (name, value) in facts.rows() {
        println!("{name:>24}  {value}");
    }
    done()
}

fn find(args: &MatchArgs) -> Result<ExitCode, RemeshError> {
    let source = maps::find_map(&spec(&args.source))?;
    let found = maps::matches(&source)?;
    if args.json {
        println!("{:#}", json!(found));
        return done();
    }
    println!("{:<22} {:<12} {:>6} {:>9} {:>7} {:>6}  pole", "target", "type", "index", "junctions", "valence", "tubes");
    for m in &found {
        println!(
            "{:<22} {:<12} {:>6} {:>9} {:>7} {:>6}  {}{}",
            m.target.name,
            format!("{{{},{}}}_{}", m.target.p, m.target.q, m.target.petrie),
            m.index,
            m.junctions,
            m.valence,
            m.tubes,
            match m.pole {
                quadloom::regular_maps::Pole::Face => "face",
                quadloom::regular_maps::Pole::Vertex => "vertex",
            },
            if m.twisted { ", half-twisted tubes" } else { "" }
        );
    }
    done()
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
    for warning in maps::stage_realized(&mut files, &args.surface.output, &result)? {
        console.note(&format!("warning: {}: {warning}", args.surface.output.display()));
    }
    if let Some(path) = &args.report {
        let report = serde_json::to_string_pretty(&json!(result.report)).unwrap_or_default();
        stage_text(&mut files, path, &format!("{report}\n"))?;
    }
    if let Some(path) = &args.view {
        stage_text(&mut files, path, &render_map_html(&maps::map_scene(&result)?))?;
    }
    files.commit()?;
    let report = &result.report;
    console.note(&format!(
        "{}: {}, {} junctions, {} tubes, rotations {}, {} triangles, {} self-intersections, {:.2} s",
        args.surface.output.display(),
        report.title(),
        report.surface_of.junctions,
        report.surface_of.tubes,
        report.surface_of.symmetry.group,
        report.surface.faces,
        report.surface.self_intersections,
        report.seconds
    ));
    Ok(code_of(&report.surface))
}

/// A surface that meets itself is written only where that is allowed, and is not what one would like.
fn code_of(surface: &SurfaceReport) -> ExitCode {
    ExitCode::from(if surface.self_intersections > 0 { exit::MISSED } else { exit::DONE })
}

fn realize_request(args: &RealizeArgs) -> RealizeRequest {
    let relief = Format::from_path(&args.surface.output) == Some(Format::Stl);
    let edges = args.edges.unwrap_or(if relief { EdgesArg::Relief } else { EdgesArg::Bands });
    let mut options = options(&args.surface, &args.run);
    options.draw = DrawOptions {
        drawn: if args.dual { Drawn::Dual } else { Drawn::Map },
        edges: match edges {
            EdgesArg::None => EdgeStyle::None,
            EdgesArg::Bands => EdgeStyle::Bands(args.edge_width),
            EdgesArg::Tubes => EdgeStyle::Tubes(args.edge_width),
            EdgesArg::Relief => EdgeStyle::Relief(args.edge_width),
        },
        height: match edges {
            EdgesArg::None | EdgesArg::Bands => 0.0,
            EdgesArg::Tubes | EdgesArg::Relief => RELIEF,
        },
        steps: [usize::from(args.steps); 2],
    };
    RealizeRequest { on: args.on.clone(), options, colors: args.colors.clone(), size: args.surface.size }
}

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
    for warning in maps::stage_tubes(&mut files, &args.surface.output, &result)? {
        console.note(&format!("warning: {}: {warning}", args.surface.output.display()));
    }
    if let Some(path) = &args.report {
        let report = serde_json::to_string_pretty(&json!(result.report)).unwrap_or_default();
        stage_text(&mut files, path, &format!("{report}\n"))?;
    }
    files.commit()?;
    console.note(&format!(
        "{}: tubes of {}, {} junctions, {} tubes, genus {}, rotations {}, {} self-intersections, {:.2} s",
        args.surface.output.display(),
        source.name,
        result.report.tubes.junctions,
        result.report.tubes.tubes,
        result.report.surface.genus,
        result.report.tubes.symmetry.group,
        result.report.surface.self_intersections,
        result.report.seconds
    ));
    Ok(code_of(&result.report.surface))
}

fn search(args: &SearchArgs) -> Result<ExitCode, RemeshError> {
    let fewer = use_threads(args.run.threads);
    let progress = watchdog::start(args.run.time_limit);
    let (console, progress) = Console::new(&args.run, progress);
    fewer.iter().for_each(|note| console.note(note));
    if args.chiral {
        return search_chiral(args, &progress);
    }
    let found = maps::search(args.genus.clone(), args.kind, &progress)?;
    drop(console);
    if args.json {
        println!("{:#}", json!(found));
        return done();
    }
    print_maps(&found);
    done()
}

fn search_chiral(args: &SearchArgs, progress: &Progress) -> Result<ExitCode, RemeshError> {
    let found = maps::search_chiral(args.genus.clone(), args.kind, progress)?;
    if args.json {
        println!("{:#}", json!(found));
        return done();
    }
    println!("{:<10} {:>6} {:>9} {:>6} {:>6} {:>6}  group", "type", "genus", "rotations", "V", "E", "F");
    for map in &found {
        let kind = format!("{{{},{}}}", map.p, map.q);
        println!(
            "{kind:<10} {:>6} {:>9} {:>6} {:>6} {:>6}  {}",
            map.genus, map.rotations, map.vertices, map.edges, map.faces, map.presentation
        );
    }
    println!("{} maps", found.len());
    done()
}
