//! `quadloom convert`

use super::files::Files;
use super::{OutputKind, done, read, stage};
use crate::args::ConvertArgs;
use quadloom::RemeshError;
use quadloom::io::{Batch, SurfaceOut};
use std::process::ExitCode;

/// Writes a mesh in another format: faces, coordinates, texture coordinates and attributes as they are.
pub fn run(args: &ConvertArgs) -> Result<ExitCode, RemeshError> {
    Files::of(&args.input).writes("the output", Some(&args.output), OutputKind::Surface).check()?;
    let surface = SurfaceOut::from(read(&args.input)?);
    let mut files = Batch::new();
    let warnings = stage(&mut files, &args.output, &surface)?;
    files.commit()?;
    for warning in warnings {
        eprintln!("{warning}");
    }
    done()
}
