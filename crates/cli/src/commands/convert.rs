//! `quadloom convert`

use super::{OutputKind, check_output, done, read, write};
use crate::args::ConvertArgs;
use quadloom::RemeshError;
use quadloom::io::SurfaceOut;
use std::process::ExitCode;

/// Writes a mesh in another format: faces, coordinates, texture coordinates and attributes as they are.
pub fn run(args: &ConvertArgs) -> Result<ExitCode, RemeshError> {
    check_output(&args.output, OutputKind::Surface)?;
    let surface = SurfaceOut::from(read(&args.input)?);
    for warning in write(&args.output, &surface)? {
        eprintln!("{warning}");
    }
    done()
}
