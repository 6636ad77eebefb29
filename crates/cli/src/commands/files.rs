//! Which files a run reads and writes: checked before any work.
//!
//! In: paths with what they are for. Out: nothing, or the error. Holds: no file is written over another one of the same
//! run, read or written; formats and folders of what is written are known to do.

use super::OutputKind;
use quadloom::io::{IoError, check_writable};
use quadloom::{RemeshError, Source};
use std::path::{Path, PathBuf};

/// The files of one run.
#[derive(Default)]
pub struct Files {
    read: Vec<(&'static str, PathBuf)>,
    written: Vec<(&'static str, PathBuf, OutputKind)>,
}

impl Files {
    /// A run that reads this input.
    pub fn of(input: &str) -> Self {
        let Ok(source) = input.parse::<Source>();
        match source {
            Source::File(path) => Self::default().reads("the input", Some(&path)),
            Source::Sample(_) => Self::default(),
        }
    }

    /// The same run, which reads another file, if there is one.
    pub fn reads(mut self, what: &'static str, path: Option<&PathBuf>) -> Self {
        self.read.extend(path.map(|p| (what, p.clone())));
        self
    }

    /// The same run, which writes another file, if there is one.
    pub fn writes(mut self, what: &'static str, path: Option<&PathBuf>, kind: OutputKind) -> Self {
        self.written.extend(path.map(|p| (what, p.clone(), kind)));
        self
    }

    /// Fails now rather than after minutes.
    ///
    /// # Errors     two files that are one; a format that is not written; a folder that is not there or takes no file
    pub fn check(&self) -> Result<(), RemeshError> {
        // 1. No file stands for two.
        for (k, (written, path, _)) in self.written.iter().enumerate() {
            let same = |other: &Path| matches!((identity(path), identity(other)), (Some(a), Some(b)) if a == b);
            let clash = |other, cure| Err(RemeshError::SameFile { path: path.clone(), written, other, cure });
            if let Some((other, _)) = self.read.iter().find(|(_, p)| same(p)) {
                return clash(*other, "what is read is not written over: choose another name for the result");
            }
            if let Some((other, ..)) = self.written[..k].iter().find(|(_, p, _)| same(p)) {
                return clash(*other, "give each a file of its own");
            }
        }
        // 2. Each can be written.
        self.written.iter().try_for_each(|(_, path, kind)| check_output(path, *kind))
    }
}

/// A path with links resolved, so that two names of one file are the same; `None` for devices and pipes, which may be
/// used twice.
fn identity(path: &Path) -> Option<PathBuf> {
    if path.metadata().is_ok_and(|m| !m.is_file()) {
        return None;
    }
    if let Ok(whole) = path.canonicalize() {
        return Some(whole);
    }
    // A file that is not there yet: its folder is.
    let folder = folder_of(path);
    let folder = folder.canonicalize().unwrap_or_else(|_| folder.to_path_buf());
    Some(path.file_name().map_or_else(|| folder.clone(), |name| folder.join(name)))
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

fn check_output(path: &Path, kind: OutputKind) -> Result<(), RemeshError> {
    if path.is_dir() {
        return Err(IoError::OutputFolder { path: path.to_path_buf(), expected: kind.expected() }.into());
    }
    if !kind.has(path) {
        return Err(IoError::UnknownOutput { path: path.to_path_buf(), expected: kind.expected() }.into());
    }
    if !folder_of(path).is_dir() {
        return Err(IoError::NoFolder { path: path.to_path_buf() }.into());
    }
    Ok(check_writable(path)?)
}
