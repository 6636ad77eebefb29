//! `quadloom convert`

use super::{check_output, done, is_surface_output, read, write};
use crate::args::ConvertArgs;
use quadloom::RemeshError;
use quadloom::io::SurfaceOut;
use std::process::ExitCode;

/// Writes a mesh in another format: faces, coordinates, texture coordinates and attributes as they are.
pub fn run(args: &ConvertArgs) -> Result<ExitCode, RemeshError> {
    check_output(&args.output, is_surface_output)?;
    let surface = SurfaceOut::from(read(&args.input)?);
    for warning in write(&args.output, &surface)? {
        eprintln!("{warning}");
    }
    done()
}
