//! What can be wrong with a file, said so that its owner can mend it.
//!
//! In: a fault found by a reader or writer. Out: [`IoError`], whose text names the file, the place and the cure.
//! Holds: one variant per kind of trouble; a place is a line where the format is text, a byte where it is not.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// Where in a file something is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// A line of a text file, from 1.
    Line(u64),
    /// A byte of a binary file, from 0.
    Byte(u64),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Byte(byte) => write!(f, "byte {byte}"),
        }
    }
}

/// What is wrong at a [`Place`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ContentDefect {
    /// Control bytes where text is expected.
    #[error("binary data where {0} text is expected; is this another kind of file with a wrong extension?")]
    Binary(&'static str),
    /// A token that should be a number is none.
    #[error("`{0}` is not a number; write numbers like -1.5e-3, with a decimal point")]
    NotANumber(String),
    /// A value is NaN or infinite, or too large for double precision.
    #[error("`{0}` is not a finite number; delete what it belongs to (a vertex with its faces) or give it a value")]
    NotFinite(String),
    /// A vertex number is zero in a format that counts from one.
    #[error("vertex number 0, but OBJ counts from 1 (or backwards from -1)")]
    IndexZero,
    /// A vertex number names no vertex.
    #[error(
        "vertex {index}, but the file has only {count} vertices; delete this {what} or restore the missing vertices"
    )]
    IndexOutOfRange {
        /// What uses the vertex.
        what: &'static str,
        /// The number as it is written, in the counting of the format.
        index: i64,
        /// Number of vertices.
        count: usize,
    },
    /// A line, facet or record has too few or too many values.
    #[error("{what}: {found} values where {wanted} are needed")]
    WrongCount {
        /// What the values belong to.
        what: &'static str,
        /// Number of values there.
        found: usize,
        /// What the format asks for.
        wanted: &'static str,
    },
    /// The file stops before its end.
    #[error("the file ends in the middle of {0}; it seems truncated, copy or export it again")]
    Truncated(String),
    /// The header makes no sense.
    #[error("bad header: {0}")]
    Header(String),
    /// Well-formed, but of a variant that is not read.
    #[error("{0}")]
    Unsupported(String),
    /// Anything else that breaks the format's rules.
    #[error("{0}")]
    Malformed(String),
    /// More elements than 32-bit ids can name.
    #[error("more elements than 32-bit ids can name; split or coarsen the model")]
    TooLarge,
}

/// Why a file could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum IoError {
    /// There is no such file.
    #[error("{}: no such file; check the spelling of the path", path.display())]
    NotFound {
        /// The path asked for.
        path: PathBuf,
    },
    /// The path is a folder.
    #[error("{}: this is a folder; name a file in it", path.display())]
    IsDirectory {
        /// The path asked for.
        path: PathBuf,
    },
    /// The system denies reading.
    #[error("{}: permission to read denied; change the file's permissions", path.display())]
    PermissionDenied {
        /// The path asked for.
        path: PathBuf,
    },
    /// Reading failed for another reason.
    #[error("{}: cannot be read: {source}", path.display())]
    Unreadable {
        /// The path asked for.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// The file has no bytes.
    #[error("{}: the file is empty; export it again", path.display())]
    Empty {
        /// The path asked for.
        path: PathBuf,
    },
    /// Neither the extension nor the content is one that is read.
    #[error("{}: neither extension nor content is that of {expected}; convert the file first", path.display())]
    UnknownFormat {
        /// The path asked for.
        path: PathBuf,
        /// The formats that would do.
        expected: &'static str,
    },
    /// Something in the file is wrong.
    #[error("{}, {place}: {defect}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// Where in it.
        place: Place,
        /// What is wrong there.
        defect: ContentDefect,
    },
    /// The file is well-formed but holds no surface.
    #[error("{}: {vertices} vertices but no face; a surface is needed (a point cloud must be meshed first)", path.display())]
    NoFaces {
        /// The file.
        path: PathBuf,
        /// Number of vertices in it.
        vertices: usize,
    },
    /// A file of curves holds none.
    #[error("{}: no curve; an OBJ with polylines (lines that start with `l`) is needed", path.display())]
    NoPolylines {
        /// The file.
        path: PathBuf,
    },
    /// A file that goes with a mesh does not fit it.
    #[error("{}: {what}; was it made for another mesh?", path.display())]
    Mismatch {
        /// The file.
        path: PathBuf,
        /// What does not fit.
        what: String,
    },
    /// The output is a folder.
    #[error("{}: this is a folder; name a file in it ({expected})", path.display())]
    OutputFolder {
        /// The path asked for.
        path: PathBuf,
        /// The extensions that would do.
        expected: &'static str,
    },
    /// The extension of the output is not one that is written.
    #[error("{}: {}; use {expected}", path.display(), unknown_suffix(path))]
    UnknownOutput {
        /// The path asked for.
        path: PathBuf,
        /// The extensions that would do.
        expected: &'static str,
    },
    /// The values to be written are not a surface.
    #[error("{}: refused to write: {what}", path.display())]
    InvalidSurface {
        /// The path asked for.
        path: PathBuf,
        /// What is wrong with them.
        what: String,
    },
    /// The output's folder does not exist.
    #[error("{}: the folder does not exist; create it first", path.display())]
    NoFolder {
        /// The path asked for.
        path: PathBuf,
    },
    /// The system, or the read-only flag of the file in place, denies writing.
    #[error("{}: permission to write denied; choose another path or change its permissions", path.display())]
    WriteDenied {
        /// The path asked for.
        path: PathBuf,
    },
    /// Writing failed for another reason; all files that were there before are unchanged.
    #[error("{}: cannot be written, nothing was changed: {source}", path.display())]
    Unwritable {
        /// The path asked for.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// One of several files could not be put in place, after others were.
    #[error("{}: cannot be written: {source}; these files were written before: {}", path.display(), listed(written))]
    PartlyWritten {
        /// The path asked for.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
        /// The files that are in place, at least one.
        written: Vec<PathBuf>,
    },
}

impl IoError {
    /// The error of a failed system call that reads `path`.
    pub(crate) fn reading(path: &Path, source: io::Error) -> Self {
        let path = path.to_path_buf();
        match source.kind() {
            io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => Self::NotFound { path },
            io::ErrorKind::IsADirectory => Self::IsDirectory { path },
            io::ErrorKind::PermissionDenied => Self::PermissionDenied { path },
            _ => Self::Unreadable { path, source },
        }
    }

    /// The error of a failed system call that writes `path`.
    pub(crate) fn writing(path: &Path, source: io::Error) -> Self {
        // Some folders, /proc for one, are there and take no file.
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let no_folder = !folder.is_dir();
        let path = path.to_path_buf();
        match source.kind() {
            io::ErrorKind::NotFound | io::ErrorKind::NotADirectory if no_folder => Self::NoFolder { path },
            io::ErrorKind::IsADirectory => Self::IsDirectory { path },
            io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => Self::WriteDenied { path },
            _ => Self::Unwritable { path, source },
        }
    }

    /// The file the error is about.
    pub fn path(&self) -> &Path {
        match self {
            Self::NotFound { path }
            | Self::IsDirectory { path }
            | Self::PermissionDenied { path }
            | Self::Unreadable { path, .. }
            | Self::Empty { path }
            | Self::UnknownFormat { path, .. }
            | Self::Content { path, .. }
            | Self::NoFaces { path, .. }
            | Self::NoPolylines { path }
            | Self::Mismatch { path, .. }
            | Self::OutputFolder { path, .. }
            | Self::UnknownOutput { path, .. }
            | Self::InvalidSurface { path, .. }
            | Self::NoFolder { path }
            | Self::WriteDenied { path }
            | Self::Unwritable { path, .. }
            | Self::PartlyWritten { path, .. } => path,
        }
    }
}

/// What is wrong with the extension of an output.
fn unknown_suffix(path: &Path) -> String {
    match path.extension().map(|e| e.to_string_lossy()) {
        None => "the name has no suffix, which tells the format".into(),
        Some(suffix) => format!(".{suffix} files are not written here"),
    }
}

fn listed(paths: &[PathBuf]) -> String {
    paths.iter().map(|p| p.display().to_string()).collect::<Vec<_>>().join(", ")
}

/// A content error before the path is known.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Fault {
    pub place: Place,
    pub defect: ContentDefect,
}

impl Fault {
    pub fn line(line: u64, defect: ContentDefect) -> Self {
        Self { place: Place::Line(line), defect }
    }
    pub fn byte(byte: usize, defect: ContentDefect) -> Self {
        Self { place: Place::Byte(byte as u64), defect }
    }
    pub fn in_file(self, path: &Path) -> IoError {
        IoError::Content { path: path.to_path_buf(), place: self.place, defect: self.defect }
    }
}
