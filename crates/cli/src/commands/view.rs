//! `quadloom view`

use super::{OutputKind, check_output, done, read, write_text};
use crate::args::ViewArgs;
use quadloom::inspect::as_quads;
use quadloom::mesh::repair::{RepairOptions, repair};
use quadloom::view::render_html;
use quadloom::{RemeshError, TriMesh, scene};
use std::process::ExitCode;

/// Draws a mesh in a page.
pub fn run(args: &ViewArgs) -> Result<ExitCode, RemeshError> {
    check_output(&args.output, OutputKind::Page)?;
    let soup = read(&args.input)?;
    let reference = args.reference.as_deref().map(surface).transpose()?;
    let scene = match as_quads(&soup) {
        Some(Ok(quads)) => scene::of_quads(&quads, reference.as_ref(), None, &args.input),
        _ => scene::of_triangles(&repair(&soup, &RepairOptions::default())?.mesh, &args.input),
    };
    write_text(&args.output, &render_html(&scene))?;
    done()
}

fn surface(input: &str) -> Result<TriMesh, RemeshError> {
    Ok(repair(&read(input)?, &RepairOptions::default())?.mesh)
}
