//! Why there is no result, and what should be known about one.
//!
//! In: what the stages say. Out: [`RemeshError`] with its [`FailureKind`], and [`Warning`].
//! Holds: every message names what, where and a cure; a warning's code never changes its meaning.

use crate::options::Elements;
use quadloom_mesh::Cancelled;
use serde::Serialize;

/// Why a run ended without a result.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RemeshError {
    /// A file cannot be read or written.
    #[error(transparent)]
    File(#[from] quadloom_io::IoError),
    /// There is no generated shape of this name.
    #[error("there is no sample '{0}'; `quadloom samples` lists them")]
    NoSample(String),
    /// The input has no face.
    #[error("the input has no face; a surface of triangles or polygons is needed")]
    NoFaces,
    /// The input is not a surface that can be repaired.
    #[error(transparent)]
    Input(#[from] quadloom_mesh::repair::RepairError),
    /// A file that goes with the input does not fit it.
    #[error("{what} does not fit the input: {why}")]
    Mismatch {
        /// Which file or option.
        what: &'static str,
        /// What does not fit, and where.
        why: String,
    },
    /// An option has a value that cannot be meant.
    #[error("--{option} {value}: out of range; `quadloom remesh --help` has the ranges")]
    Option {
        /// Its name on the command line.
        option: &'static str,
        /// Its value.
        value: f64,
    },
    /// More quads than can be made.
    #[error("{asked} quads are asked for, more than {most}: ask for larger ones (--quads, --edge-length, --scale)")]
    TooMany {
        /// Number of quads that the size leads to.
        asked: usize,
        /// Largest number.
        most: usize,
    },
    /// A tie has one vertex at both ends.
    #[error("--tie {0},{0}: a vertex cannot be tied to itself; name two different vertices")]
    TiedToItself(u32),
    /// Two results would go to one file.
    #[error("two outputs go to {}: give each a file of its own", .0.display())]
    SameFile(std::path::PathBuf),
    /// Some component has no valid quad mesh.
    #[error("{stage}: {why}")]
    NoResult {
        /// The stage that gave up.
        stage: &'static str,
        /// What happened, where, and what may help.
        why: String,
        /// What the message is about.
        elements: Elements,
    },
    /// The run was asked to stop.
    #[error("{0}; nothing was written")]
    Cancelled(#[from] Cancelled),
}

/// What kind of failure a [`RemeshError`] is; the command line has an exit code for each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FailureKind {
    /// The request itself is wrong.
    Usage,
    /// The input cannot be read, or is empty.
    Unreadable,
    /// The input was read and is not a surface, or what goes with it does not fit it.
    Rejected,
    /// No valid result was found.
    NoResult,
    /// The time limit was reached.
    Limit,
    /// The caller asked to stop.
    Cancelled,
}

impl RemeshError {
    /// The kind of failure.
    pub fn kind(&self) -> FailureKind {
        match self {
            Self::Option { .. }
            | Self::TooMany { .. }
            | Self::TiedToItself(_)
            | Self::SameFile(_)
            | Self::NoSample(_) => FailureKind::Usage,
            // The file was read; it belongs to another input.
            Self::File(quadloom_io::IoError::Mismatch { .. }) => FailureKind::Rejected,
            Self::File(_) | Self::NoFaces => FailureKind::Unreadable,
            Self::Input(_) | Self::Mismatch { .. } => FailureKind::Rejected,
            Self::NoResult { .. } => FailureKind::NoResult,
            Self::Cancelled(c) if c.time_limit => FailureKind::Limit,
            Self::Cancelled(_) => FailureKind::Cancelled,
        }
    }
}

/// What a [`Warning`] is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum WarningCode {
    /// The input had defects that were cured.
    Repaired,
    /// Sharp edges in loose pieces that are short, or no sharper than their surroundings, were dropped.
    LooseFeaturesDropped,
    /// No map follows the sharp edges that were found; they were not kept.
    SharpEdgesDropped,
    /// A curve that was found has no quad edge along it.
    FeatureLost,
    /// The count asked for was missed by more than the tolerance.
    CountMissed,
    /// Feature edges asked for are not kept.
    FeatureMissed,
    /// Given singular vertices are not those of the result.
    SingularitiesMissed,
    /// Irregular vertices that were to be tied have no chain of quad edges between them.
    TieMissed,
    /// The surface is rough at the size of its quads; directions and map were made on a smoothed copy.
    NoiseSmoothed,
    /// A first attempt failed and another one was made.
    Retried,
    /// No integer-grid map was found: triangles were split into quads.
    TrianglesSplit,
    /// Some triangles of the map are inverted; the quads around them were rebuilt.
    FoldsSurvived,
    /// Some quads face against the input at their centre, though not all around it.
    FacingUnclear,
    /// A stage that was asked for does not exist for this input.
    Ignored,
}

/// Something about a result that a user should know.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Warning {
    /// What it is about.
    pub code: WarningCode,
    /// One sentence.
    pub message: String,
    /// Where it is.
    pub elements: Elements,
}

impl Warning {
    /// A warning about nothing in particular on the surface.
    pub fn new(code: WarningCode, message: impl Into<String>) -> Self {
        Self { code, message: message.into(), elements: Elements::None }
    }

    /// The same warning about these elements.
    pub fn at(self, elements: Elements) -> Self {
        Self { elements, ..self }
    }

    /// Whether something that the user asked for was not reached, although the result is valid.
    pub fn misses_request(&self) -> bool {
        use WarningCode::{CountMissed, FacingUnclear, FeatureMissed, SingularitiesMissed, TieMissed, TrianglesSplit};
        matches!(
            self.code,
            CountMissed | FacingUnclear | FeatureMissed | SingularitiesMissed | TieMissed | TrianglesSplit
        )
    }
}
