//! The verbs, one file each. Each returns an exit code, or the error that `main` prints.

pub mod check;
pub mod convert;
pub mod distance;
pub mod field;
pub mod files;
pub mod regular_map;
pub mod remesh;
pub mod samples;
pub mod stats;
pub mod tile;
pub mod view;

use crate::exit;
use quadloom::io::{Batch, FeatureFile, SurfaceOut, WriteOptions, stage_surface};
use quadloom::mesh::repair::{RepairOptions, Repaired, repair};
use quadloom::{Elements, FaceSoup, RemeshError, Source, Warning, WarningCode, load};
use std::path::Path;
use std::process::ExitCode;

/// The soup of what was typed as an input.
fn read(input: &str) -> Result<FaceSoup, RemeshError> {
    let Ok(source) = input.parse::<Source>();
    load(&source)
}

/// The repaired surface of a soup; errors name the input.
fn repaired(soup: &FaceSoup, input: &str) -> Result<Repaired, RemeshError> {
    repair(soup, &RepairOptions::default()).map_err(|e| RemeshError::from(e).of_input(input))
}

/// Says where a file of features names the first edge that the mesh does not have.
fn name_places(warnings: &mut [Warning], features: Option<&FeatureFile>, soup: &FaceSoup) {
    let Some(file) = features else { return };
    for warning in warnings.iter_mut().filter(|w| w.code == WarningCode::FeatureMissed) {
        let Elements::Vertices(ends) = &warning.elements else { continue };
        let &[a, b, ..] = ends.as_slice() else { continue };
        if let Some(place) = file.place_of([a, b], soup) {
            warning.message += &format!(": {}, {place}", file.path().display());
        }
    }
}

/// Threads for each core beyond which more are not started: they only take turns, and thousands take minutes to start.
const MOST_THREADS_PER_CORE: usize = 4;

/// Threads of the whole process; asked for once, before anything is computed. Says so if fewer are used.
fn use_threads(threads: Option<usize>) -> Option<String> {
    let asked = threads?;
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let used = asked.min(MOST_THREADS_PER_CORE * cores);
    // A pool that exists already has been asked for by nobody but this function.
    let _ = rayon::ThreadPoolBuilder::new().num_threads(used).build_global();
    (used < asked).then(|| format!("note: {used} threads are used, {MOST_THREADS_PER_CORE} for each core"))
}

/// What can go to a file, by the extension of its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputKind {
    /// A surface.
    Surface,
    /// A surface with texture coordinates.
    Map,
    /// A cross field.
    Field,
    /// Distances.
    Distances,
    /// Polylines.
    Lines,
    /// Tiles.
    Tiles,
    /// A flat picture.
    Picture,
    /// A page.
    Page,
    /// Text; any name will do.
    Text,
}

impl OutputKind {
    fn has(self, path: &Path) -> bool {
        let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
        match self {
            Self::Surface => quadloom::io::Format::from_path(path).is_some(),
            Self::Map | Self::Tiles => extension.as_deref() == Some("obj"),
            Self::Field => matches!(path.extension().and_then(|e| e.to_str()), Some("rosy" | "rawfield")),
            Self::Distances => matches!(extension.as_deref(), Some("csv" | "ply" | "vtu" | "obj")),
            Self::Lines => matches!(extension.as_deref(), Some("obj" | "svg")),
            Self::Picture => matches!(extension.as_deref(), Some("svg" | "png")),
            Self::Page => matches!(extension.as_deref(), Some("html" | "htm")),
            Self::Text => true,
        }
    }

    fn expected(self) -> &'static str {
        match self {
            Self::Surface => quadloom::io::Format::WRITTEN,
            Self::Map | Self::Tiles => ".obj",
            Self::Field => quadloom::output::FIELDS_WRITTEN,
            Self::Distances => quadloom::distance::EXPECTED,
            Self::Lines => ".obj or .svg",
            Self::Picture => ".svg or .png",
            Self::Page => ".html",
            Self::Text => "any name",
        }
    }
}

/// Adds a surface to the files to be written; what the format cannot hold is returned as text.
fn stage(files: &mut Batch, path: &Path, surface: &SurfaceOut) -> Result<Vec<String>, RemeshError> {
    let warnings = stage_surface(files, path, surface, &WriteOptions::default())?;
    Ok(warnings.iter().map(|w| format!("warning: {}: {w}", path.display())).collect())
}

/// Adds a text to the files to be written.
fn stage_text(files: &mut Batch, path: &Path, text: &str) -> Result<(), RemeshError> {
    Ok(files.stage(path, |out| out.write_all(text.as_bytes()))?)
}

fn done() -> Result<ExitCode, RemeshError> {
    Ok(ExitCode::from(exit::DONE))
}
