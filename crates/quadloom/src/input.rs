//! Where a surface comes from.
//!
//! In: what a user typed. Out: [`FaceSoup`]. Holds: what [`quadloom_io::read_soup`] holds.

use crate::error::RemeshError;
use quadloom_io::{read_rawfield, read_rosy, read_soup};
use quadloom_mesh::shapes::sample;
use quadloom_mesh::{DVec3, FaceSoup};
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// A file or a generated shape.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Source {
    /// A file.
    File(PathBuf),
    /// A generated shape, by its name.
    Sample(String),
}

/// What stands before the name of a generated shape.
const SAMPLE_PREFIX: &str = "sample:";

impl From<&std::ffi::OsStr> for Source {
    fn from(text: &std::ffi::OsStr) -> Self {
        match text.to_str().and_then(|t| t.strip_prefix(SAMPLE_PREFIX)) {
            Some(name) => Self::Sample(name.to_string()),
            None => Self::File(text.into()),
        }
    }
}

impl FromStr for Source {
    type Err = std::convert::Infallible;
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Ok(std::ffi::OsStr::new(text).into())
    }
}

impl std::fmt::Display for Source {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::File(path) => path.display().fmt(f),
            Self::Sample(name) => write!(f, "{SAMPLE_PREFIX}{name}"),
        }
    }
}

/// Reads a surface.
///
/// # Errors     every error of reading; a name that is no generated shape's
pub fn load(source: &Source) -> Result<FaceSoup, RemeshError> {
    match source {
        Source::File(path) => Ok(read_soup(path)?),
        Source::Sample(name) => {
            let mesh = sample(name).ok_or_else(|| RemeshError::NoSample(name.clone()))?;
            Ok(FaceSoup {
                positions: mesh.positions().values().to_vec(),
                faces: mesh.to_faces().iter().map(|f| f.to_vec()).collect(),
                ..FaceSoup::default()
            })
        }
    }
}

/// Reads one direction per face from a `.rosy` or `.rawfield` file.
///
/// # Errors     every error of reading; an extension that is no field's; a field without directions
pub fn load_field(path: &Path) -> Result<Vec<DVec3>, RemeshError> {
    match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
        Some("rawfield") => {
            let field = read_rawfield(path)?;
            let first = field.faces().map(|face| face.first().copied());
            first.collect::<Option<Vec<_>>>().ok_or_else(|| RemeshError::Mismatch {
                what: "the cross field",
                why: format!("{} has no vectors", path.display()),
            })
        }
        _ => Ok(read_rosy(path)?),
    }
}
