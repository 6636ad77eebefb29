//! `quadloom view`

use super::files::Files;
use super::{OutputKind, done, read, repaired, stage_text};
use crate::args::ViewArgs;
use quadloom::inspect::as_quads;
use quadloom::io::Batch;
use quadloom::view::render_html;
use quadloom::{RemeshError, Source, TriMesh, scene};
use std::process::ExitCode;

/// Draws a mesh in a page.
pub fn run(args: &ViewArgs) -> Result<ExitCode, RemeshError> {
    let reference = args.reference.as_deref().and_then(file);
    let files = Files::of(&args.input).reads("the reference (--reference)", reference.as_ref());
    files.writes("the page (-o)", Some(&args.output), OutputKind::Page).check()?;
    let soup = read(&args.input)?;
    let reference = args.reference.as_deref().map(surface).transpose()?;
    let scene = match as_quads(&soup) {
        Some(Ok(quads)) => scene::of_quads(&quads, reference.as_ref(), None, &args.input),
        _ => scene::of_triangles(&repaired(&soup, &args.input)?.mesh, &args.input),
    };
    let mut files = Batch::new();
    stage_text(&mut files, &args.output, &render_html(&scene))?;
    files.commit()?;
    done()
}

fn surface(input: &str) -> Result<TriMesh, RemeshError> {
    Ok(repaired(&read(input)?, input)?.mesh)
}

fn file(input: &str) -> Option<std::path::PathBuf> {
    match input.parse() {
        Ok(Source::File(path)) => Some(path),
        Ok(Source::Sample(_)) => None,
    }
}
