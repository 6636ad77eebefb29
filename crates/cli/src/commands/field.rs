//! `quadloom field`

use super::{OutputKind, check_output, read, use_threads};
use crate::args::FieldArgs;
use crate::console::Console;
use crate::{exit, watchdog};
use quadloom::RemeshError;
use quadloom::field::{FieldRequest, solve_field};
use quadloom::io::{Singularity, read_features, read_singularities, write_singularities};
use quadloom::output::write_crosses;
use std::process::ExitCode;

/// Computes a cross field on the faces of the input.
pub fn run(args: &FieldArgs) -> Result<ExitCode, RemeshError> {
    use_threads(args.run.threads);
    let progress = watchdog::start(args.run.time_limit);
    let (console, progress) = Console::new(&args.run, progress);
    check_output(&args.output, OutputKind::Field)?;
    args.write_singularities.iter().try_for_each(|path| check_output(path, OutputKind::Text))?;
    let soup = read(&args.input)?;
    let features = args.features.as_ref().map(|path| read_features(path)?.vertex_pairs(&soup)).transpose()?;
    let singularities = args.singularities.as_ref().map(read_singularities).transpose()?;
    let request = FieldRequest {
        sharp_angle: args.sharp_angle.0,
        features: features.unwrap_or_default(),
        singularities: singularities.unwrap_or_default().iter().map(|s| (s.vertex, s.quarters)).collect(),
        other_singularities: args.other_singularities,
    };
    let solved = solve_field(&soup, &request, &progress)?;
    console.warnings(&solved.warnings);
    let _writing = watchdog::while_writing();
    write_crosses(&args.output, &solved.crosses)?;
    if let Some(path) = &args.write_singularities {
        let list: Vec<Singularity> =
            solved.singularities.iter().map(|&(vertex, quarters)| Singularity { vertex, quarters }).collect();
        write_singularities(path, &list)?;
    }
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
