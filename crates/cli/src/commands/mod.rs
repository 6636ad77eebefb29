//! The verbs, one file each. Each returns an exit code, or the error that `main` prints.

pub mod check;
pub mod convert;
pub mod field;
pub mod remesh;
pub mod samples;
pub mod stats;
pub mod view;

use crate::exit;
use quadloom::io::{IoError, SurfaceOut, WriteOptions, write_surface};
use quadloom::{FaceSoup, RemeshError, Source, load};
use std::path::Path;
use std::process::ExitCode;

/// The soup of what was typed as an input.
fn read(input: &str) -> Result<FaceSoup, RemeshError> {
    let Ok(source) = input.parse::<Source>();
    load(&source)
}

/// Threads of the whole process; asked for once, before anything is computed.
fn use_threads(threads: Option<usize>) {
    if let Some(n) = threads {
        // A pool that exists already has been asked for by nobody but this function.
        let _ = rayon::ThreadPoolBuilder::new().num_threads(n).build_global();
    }
}

/// What can go to a file, by the extension of its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum OutputKind {
    /// A surface.
    Surface,
    /// A cross field.
    Field,
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
            Self::Field => matches!(path.extension().and_then(|e| e.to_str()), Some("rosy" | "rawfield")),
            Self::Page => matches!(extension.as_deref(), Some("html" | "htm")),
            Self::Text => true,
        }
    }

    fn expected(self) -> &'static str {
        match self {
            Self::Surface => quadloom::io::Format::WRITTEN,
            Self::Field => quadloom::output::FIELDS_WRITTEN,
            Self::Page => ".html",
            Self::Text => "any name",
        }
    }
}

/// Fails now rather than after minutes: the format must be one that is written, the folder must exist.
fn check_output(path: &Path, kind: OutputKind) -> Result<(), RemeshError> {
    if !kind.has(path) {
        return Err(IoError::UnknownOutput { path: path.to_path_buf(), expected: kind.expected() }.into());
    }
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.is_dir() {
        return Err(IoError::NoFolder { path: path.to_path_buf() }.into());
    }
    if path.is_dir() {
        return Err(IoError::IsDirectory { path: path.to_path_buf() }.into());
    }
    Ok(())
}

/// Writes a surface; what the format could not hold is returned as text.
fn write(path: &Path, surface: &SurfaceOut) -> Result<Vec<String>, RemeshError> {
    let warnings = write_surface(path, surface, &WriteOptions::default())?;
    Ok(warnings.iter().map(|w| format!("warning: {}: {w}", path.display())).collect())
}

/// Writes a text file whole or not at all.
fn write_text(path: &Path, text: &str) -> Result<(), RemeshError> {
    Ok(quadloom::io::write_atomically(path, |out| out.write_all(text.as_bytes()))?)
}

fn done() -> Result<ExitCode, RemeshError> {
    Ok(ExitCode::from(exit::DONE))
}
