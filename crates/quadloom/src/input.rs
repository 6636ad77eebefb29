//! Where a surface comes from.
//!
//! In: what a user typed. Out: [`FaceSoup`]. Holds: what [`quadloom_io::read_soup`] holds.

use crate::error::RemeshError;
use quadloom_io::{IoError, read_rawfield, read_rosy, read_soup};
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

/// Least extent of a surface and largest coordinate, file units.
///
/// Areas and the squares of cross products are fourth powers of lengths, and no stage goes beyond sixth powers. Those of
/// 1e40 are 1e240; those of 1e-48, a detail of a hundred-millionth of 1e-40, are 1e-288: both are normal doubles.
const EXTENT: [f64; 2] = [1e-40, 1e40];

/// Refuses a surface whose lengths cannot be multiplied with each other.
///
/// # Input      positions used by faces count; those that are not finite are the repair's to name
/// # Cost       linear
pub fn check_extent(soup: &FaceSoup) -> Result<(), RemeshError> {
    let used = soup.faces.iter().flatten().filter_map(|&v| soup.positions.get(v as usize)).filter(|p| p.is_finite());
    let bounds = |(lo, hi): (DVec3, DVec3), &p: &DVec3| (lo.min(p), hi.max(p));
    let (lo, hi) = used.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), bounds);
    if lo.x > hi.x {
        return Ok(());
    }
    let [least, most] = EXTENT;
    let (largest, extent) = (lo.abs().max(hi.abs()).max_element(), (hi - lo).max_element());
    let (what, size) = match () {
        () if largest > most => ("has coordinates up to", largest),
        // One point is no surface, which the repair says.
        () if extent < least && extent > 0.0 => ("has an extent of", extent),
        () => return Ok(()),
    };
    Err(RemeshError::Extent { what, size, least, most })
}

/// Reads one direction per face from a `.rosy` or `.rawfield` file.
///
/// # Errors     every error of reading; neither extension nor content of a field; a field without directions
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
        Some("rosy") => Ok(read_rosy(path)?),
        // Any other name will do if the content does.
        _ => read_rosy(path).map_err(|error| match error {
            IoError::Content { path, .. } => IoError::UnknownFormat { path, expected: FIELDS_READ }.into(),
            other => other.into(),
        }),
    }
}

/// Formats of cross fields that are read.
const FIELDS_READ: &str = "a cross field (.rosy or .rawfield, as `quadloom field` writes them)";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_of_which_no_area_can_be_computed_are_named() {
        let triangle = |size: f64| FaceSoup {
            positions: vec![DVec3::ZERO, size * DVec3::X, size * DVec3::Y],
            faces: vec![vec![0, 1, 2]],
            ..FaceSoup::default()
        };
        for size in [1e-39, 1e-12, 1.0, 1e12, 1e39, 0.0, f64::NAN] {
            assert!(check_extent(&triangle(size)).is_ok(), "{size}");
        }
        for (size, text) in [(1e160, "up to 1.0e160"), (1e300, "1.0e300"), (1e-200, "extent of 1.0e-200")] {
            let message = check_extent(&triangle(size)).expect_err("refused").to_string();
            assert!(message.contains(text) && message.contains("from 1e-40 to 1e40"), "{message}");
        }
        // A vertex that no face uses does not matter.
        let mut soup = triangle(1.0);
        soup.positions.push(DVec3::splat(1e200));
        assert!(check_extent(&soup).is_ok());
    }
}
