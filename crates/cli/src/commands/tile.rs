//! `quadloom tile`

use super::files::Files;
use super::{OutputKind, read, stage_text, use_threads};
use crate::args::{CuttingArg, DiagonalsArg, IntoArg, ParametrizeArg, SearchArg, TileArgs};
use crate::console::Console;
use crate::{exit, watchdog};
use quadloom::RemeshError;
use quadloom::io::{Batch, ensure_folder};
use quadloom::tile::{Into, TileRequest, scene, stage_layout, stage_steps, stage_tiles, tile_surface};
use quadloom::tiling::maps::MapMethod;
use quadloom::tiling::{DiagonalChoice, Method, SearchMode};
use quadloom::view::render_html;
use std::process::ExitCode;

/// Cuts the input into tiles.
pub fn run(args: &TileArgs) -> Result<ExitCode, RemeshError> {
    let fewer = use_threads(args.run.threads);
    let progress = watchdog::start(args.run.time_limit);
    let (console, progress) = Console::new(&args.run, progress);
    fewer.iter().for_each(|note| console.note(note));
    files(args).check()?;
    let soup = read(&args.input)?;
    let result = tile_surface(&soup, &request(args), &progress).map_err(|e| e.of_input(&args.input))?;
    console.warnings(&result.warnings);
    let _writing = watchdog::while_writing();
    let mut files = Batch::new();
    stage_tiles(&mut files, &args.output, &result)?;
    if let Some(path) = &args.layout {
        stage_layout(&mut files, path, &result)?;
    }
    if let Some(folder) = &args.steps {
        ensure_folder(folder)?;
        stage_steps(&mut files, folder, &result)?;
    }
    if let Some(path) = &args.report {
        let report = serde_json::to_string_pretty(&serde_json::json!(result.report)).unwrap_or_default();
        stage_text(&mut files, path, &format!("{report}\n"))?;
    }
    if let Some(path) = &args.view {
        stage_text(&mut files, path, &render_html(&scene(&result, &args.input)))?;
    }
    files.commit()?;
    let report = &result.report;
    console.note(&format!(
        "{}: {} tiles, {} multipoints, cuts of length {:.6}, {:.3} s",
        args.output.display(),
        report.tiles,
        report.multipoints,
        report.length,
        report.seconds.cutting
    ));
    let missed = result.warnings.iter().any(|w| w.misses_request());
    Ok(ExitCode::from(if missed { exit::MISSED } else { exit::DONE }))
}

fn request(args: &TileArgs) -> TileRequest {
    TileRequest {
        into: match args.into {
            IntoArg::Disk => Into::Disk,
            IntoArg::Schema => Into::Schema,
            IntoArg::Quads => Into::Quads,
            IntoArg::Pants => Into::Pants,
            IntoArg::Cylinders => Into::Cylinders,
        },
        method: args.method.map(|method| match method {
            CuttingArg::Shortest => Method::Shortest,
            CuttingArg::SinglePoint => Method::SinglePoint,
            CuttingArg::Intermediate => Method::Intermediate,
        }),
        search: match args.search {
            SearchArg::Exact => SearchMode::Exact,
            SearchArg::Fast => SearchMode::Fast,
        },
        cost: args.cost.clone(),
        diagonals: match args.diagonals {
            DiagonalsArg::Greedy => DiagonalChoice::Greedy,
            DiagonalsArg::Optimal => DiagonalChoice::Optimal,
        },
        base: args.base,
        forbid: args.forbid.clone(),
        cut: args.cut.clone(),
        parametrize: args.parametrize.map(|method| match method {
            ParametrizeArg::Fixed => MapMethod::MeanValue,
            ParametrizeArg::Conformal => MapMethod::Conformal,
            ParametrizeArg::Abf => MapMethod::AngleBased,
            ParametrizeArg::Circles => MapMethod::Circles,
        }),
        steps: args.steps.is_some(),
    }
}

fn files(args: &TileArgs) -> Files {
    Files::of(&args.input)
        .reads("the edges to cut along (--cut)", args.cut.as_ref())
        .writes("the tiles (-o)", Some(&args.output), OutputKind::Tiles)
        .writes("the layout (--layout)", args.layout.as_ref(), OutputKind::Text)
        .writes("the report (--report)", args.report.as_ref(), OutputKind::Text)
        .writes("the page (--view)", args.view.as_ref(), OutputKind::Page)
}
