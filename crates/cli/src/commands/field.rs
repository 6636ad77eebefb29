//! `quadloom field`

use super::files::Files;
use super::{OutputKind, name_places, read, use_threads};
use crate::args::FieldArgs;
use crate::console::Console;
use crate::{exit, watchdog};
use quadloom::RemeshError;
use quadloom::field::{FieldRequest, solve_field};
use quadloom::io::{Batch, Singularity, read_features, read_singularities, stage_singularities};
use quadloom::output::stage_crosses;
use std::process::ExitCode;

/// Computes a cross field on the faces of the input.
pub fn run(args: &FieldArgs) -> Result<ExitCode, RemeshError> {
    let fewer = use_threads(args.run.threads);
    let progress = watchdog::start(args.run.time_limit);
    let (console, progress) = Console::new(&args.run, progress);
    fewer.iter().for_each(|note| console.note(note));
    files(args).check()?;
    let soup = read(&args.input)?;
    let file = args.features.as_ref().map(read_features).transpose()?;
    let features = file.as_ref().map(|file| file.vertex_pairs(&soup)).transpose()?;
    let singularities = args.singularities.as_ref().map(read_singularities).transpose()?;
    let request = FieldRequest {
        sharp_angle: args.sharp_angle.0,
        features: features.unwrap_or_default(),
        singularities: singularities.map(|list| list.iter().map(|s| (s.vertex, s.quarters)).collect()),
        other_singularities: args.other_singularities,
    };
    let mut solved = solve_field(&soup, &request, &progress).map_err(|e| e.of_input(&args.input))?;
    name_places(&mut solved.warnings, file.as_ref(), &soup);
    console.warnings(&solved.warnings);
    let _writing = watchdog::while_writing();
    let mut files = Batch::new();
    stage_crosses(&mut files, &args.output, &solved.crosses)?;
    if let Some(path) = &args.write_singularities {
        let list: Vec<Singularity> =
            solved.singularities.iter().map(|&(vertex, quarters)| Singularity { vertex, quarters }).collect();
        stage_singularities(&mut files, path, &list)?;
    }
    files.commit()?;
    console.note(&format!(
        "{}: {} faces, {} singular vertices, energy {:.2}",
        args.output.display(),
        solved.crosses.len(),
        solved.singularities.len(),
        solved.energy
    ));
    let missed = solved.warnings.iter().any(|w| w.misses_request());
    Ok(ExitCode::from(if missed { exit::MISSED } else { exit::DONE }))
}

fn files(args: &FieldArgs) -> Files {
    Files::of(&args.input)
        .reads("the features (--features)", args.features.as_ref())
        .reads("the singularities (--singularities)", args.singularities.as_ref())
        .writes("the field (-o)", Some(&args.output), OutputKind::Field)
        .writes("the singularities (--write-singularities)", args.write_singularities.as_ref(), OutputKind::Text)
}
