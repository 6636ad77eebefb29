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
    /// The input is so large or so small that products of its lengths are no normal doubles.
    #[error(
        "the surface {what} {size:.1e}, but only lengths from {least:.0e} to {most:.0e} can be computed with; scale the \
         model (other units)"
    )]
    Extent {
        /// What is out of range.
        what: &'static str,
        /// Its size, file units.
        size: f64,
        /// Least extent, file units.
        least: f64,
        /// Largest coordinate, file units.
        most: f64,
    },
    /// Distances cannot be measured on the surface, or not from these sources.
    #[error(transparent)]
    Geodesic(quadloom_geodesic::GeodesicError),
    /// A surface cannot be cut into the tiles that were asked for.
    #[error("{}{error}", component_name(.component))]
    Tiling {
        /// Number of the component and its first face, where there are several.
        component: Option<(usize, u32)>,
        /// Why.
        error: quadloom_tiling::TilingError,
    },
    /// There is no regular map of this name, or it is that of several.
    #[error(transparent)]
    Catalogue(quadloom_regular_maps::catalogue::CatalogueError),
    /// A word, presentation or group that is no regular map, or not one that can be drawn here.
    #[error(transparent)]
    Map(quadloom_regular_maps::MapError),
    /// A regular map does not match a target that was asked for.
    #[error(
        "{map} cannot be drawn on the tubes of {target:?}; its targets are {known} (`regular-map match` says more about \
         them)"
    )]
    NoTarget {
        /// Name of the map.
        map: String,
        /// The target asked for.
        target: String,
        /// Targets that there are.
        known: String,
    },
    /// A regular map has no surface in space.
    #[error("{0}{cure}", cure = realize_cure(.0))]
    Realize(quadloom_tubification::RealizeError),
    /// A piece of the input has no area.
    #[error(
        "{faces} faces form a piece without area (first: face {first}); delete them, or check the units and the \
         precision of the export"
    )]
    NoArea {
        /// Number of its faces.
        faces: usize,
        /// The first of them, in the counting of the input.
        first: u32,
    },
    /// Another error, and the input that it is about.
    #[error("{input}: {error}")]
    Of {
        /// The input, as the user named it.
        input: String,
        /// What is wrong with it.
        error: Box<RemeshError>,
    },
    /// A file that goes with the input does not fit it.
    #[error("{what} does not fit the input: {why}")]
    Mismatch {
        /// Which file or option.
        what: &'static str,
        /// What does not fit, and where.
        why: String,
    },
    /// An option has a value that cannot be meant.
    #[error("--{option} {value}: {allowed} is needed")]
    Option {
        /// Its name on the command line.
        option: &'static str,
        /// Its value.
        value: f64,
        /// What it may be.
        allowed: &'static str,
    },
    /// An option has a value that cannot be meant, for a reason that takes more words.
    #[error("--{option}: {why}")]
    Argument {
        /// Its name on the command line.
        option: &'static str,
        /// What is wrong, and what is right.
        why: String,
    },
    /// More quads than can be made.
    #[error(
        "this size leads to {asked:.1e} quads, more than the {most} that can be made: ask for fewer (--quads) or for longer \
         edges (--edge-length, --scale)"
    )]
    TooMany {
        /// Number of quads that the size leads to.
        asked: f64,
        /// Largest number.
        most: usize,
    },
    /// A tie has one vertex at both ends.
    #[error("--tie {0},{0}: a vertex cannot be tied to itself; name two different vertices")]
    TiedToItself(u32),
    /// A file would be written over another one of the same run.
    #[error("{}: {written} and {other} are one file; {cure}", path.display())]
    SameFile {
        /// The file.
        path: std::path::PathBuf,
        /// What would be written there.
        written: &'static str,
        /// What is written there, too, or read from there.
        other: &'static str,
        /// What to do.
        cure: &'static str,
    },
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

fn component_name(component: &Option<(usize, u32)>) -> String {
    component.map_or(String::new(), |(number, face)| format!("component {number} (first face: {face}): "))
}

/// What may help besides what the error says.
fn realize_cure(error: &quadloom_tubification::RealizeError) -> &'static str {
    match error {
        quadloom_tubification::RealizeError::Intersections { .. } => {
            " (--allow-intersections, --on, --skeleton, --symmetry)"
        }
        _ => "",
    }
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

impl From<quadloom_geodesic::GeodesicError> for RemeshError {
    fn from(error: quadloom_geodesic::GeodesicError) -> Self {
        match error {
            quadloom_geodesic::GeodesicError::Cancelled(cancelled) => Self::Cancelled(cancelled),
            other => Self::Geodesic(other),
        }
    }
}

impl From<quadloom_tiling::TilingError> for RemeshError {
    fn from(error: quadloom_tiling::TilingError) -> Self {
        match error {
            quadloom_tiling::TilingError::Cancelled(cancelled) => Self::Cancelled(cancelled),
            error => Self::Tiling { component: None, error },
        }
    }
}

impl From<quadloom_regular_maps::MapError> for RemeshError {
    fn from(error: quadloom_regular_maps::MapError) -> Self {
        match error {
            quadloom_regular_maps::MapError::Cancelled(cancelled) => Self::Cancelled(cancelled),
            other => Self::Map(other),
        }
    }
}

impl From<quadloom_regular_maps::catalogue::CatalogueError> for RemeshError {
    fn from(error: quadloom_regular_maps::catalogue::CatalogueError) -> Self {
        match error {
            quadloom_regular_maps::catalogue::CatalogueError::Map(error) => error.into(),
            other => Self::Catalogue(other),
        }
    }
}

impl From<quadloom_tubification::RealizeError> for RemeshError {
    fn from(error: quadloom_tubification::RealizeError) -> Self {
        use quadloom_tubification::RealizeError as E;
        use quadloom_tubification::skeleton::SkeletonError;
        match error {
            E::Cancelled(cancelled) | E::Skeleton(SkeletonError::Cancelled(cancelled)) => Self::Cancelled(cancelled),
            other => Self::Realize(other),
        }
    }
}

/// What kind of failure an error of realising a map is.
fn realize_kind(error: &quadloom_tubification::RealizeError) -> FailureKind {
    use quadloom_tubification::RealizeError as E;
    use quadloom_tubification::TubeError;
    use quadloom_tubification::skeleton::SkeletonError as S;
    match error {
        E::NoMatch(_) | E::Skeleton(S::NoSymmetry { .. } | S::Valence(..)) => FailureKind::Rejected,
        E::Tubes(TubeError::Option(..)) => FailureKind::Usage,
        _ => FailureKind::NoResult,
    }
}

/// What kind of failure an error of tiling is.
fn tiling_kind(error: &quadloom_tiling::TilingError) -> FailureKind {
    use quadloom_tiling::TilingError as E;
    use quadloom_tiling::maps::MapError as M;
    match error {
        E::Option { .. } | E::NoVertex { .. } => FailureKind::Usage,
        E::NoWay { .. } | E::Fault { .. } => FailureKind::NoResult,
        E::Map { error: M::Folded { .. } | M::NotConverged { .. } | M::Solve { .. }, .. } => FailureKind::NoResult,
        E::Cancelled(stop) if stop.time_limit => FailureKind::Limit,
        E::Cancelled(_) => FailureKind::Cancelled,
        _ => FailureKind::Rejected,
    }
}

impl RemeshError {
    /// The kind of failure.
    pub fn kind(&self) -> FailureKind {
        match self {
            Self::Option { .. }
            | Self::TooMany { .. }
            | Self::TiedToItself(_)
            | Self::SameFile { .. }
            | Self::Argument { .. }
            | Self::Catalogue(_)
            | Self::NoSample(_) => FailureKind::Usage,
            Self::Map(quadloom_regular_maps::MapError::NotOrientable(_)) | Self::NoTarget { .. } => {
                FailureKind::Rejected
            }
            Self::Map(_) => FailureKind::Usage,
            Self::Realize(error) => realize_kind(error),
            Self::Of { error, .. } => error.kind(),
            Self::File(quadloom_io::IoError::UnknownOutput { .. }) => FailureKind::Usage,
            // The file was read; it belongs to another input.
            Self::File(quadloom_io::IoError::Mismatch { .. }) => FailureKind::Rejected,
            Self::File(_) | Self::NoFaces => FailureKind::Unreadable,
            Self::Geodesic(quadloom_geodesic::GeodesicError::Option { .. }) => FailureKind::Usage,
            Self::Tiling { error, .. } => tiling_kind(error),
            Self::Input(_) | Self::Mismatch { .. } | Self::Extent { .. } | Self::Geodesic(_) | Self::NoArea { .. } => {
                FailureKind::Rejected
            }
            Self::NoResult { .. } => FailureKind::NoResult,
            Self::Cancelled(c) if c.time_limit => FailureKind::Limit,
            Self::Cancelled(_) => FailureKind::Cancelled,
        }
    }

    /// The same error, with the name of the input where it is about that; errors about files name theirs already.
    pub fn of_input(self, input: &str) -> Self {
        match self {
            Self::NoFaces
            | Self::Input(_)
            | Self::Mismatch { .. }
            | Self::Extent { .. }
            | Self::Geodesic(_)
            | Self::Tiling { .. }
            | Self::NoArea { .. }
            | Self::NoResult { .. } => Self::Of { input: input.to_string(), error: Box::new(self) },
            other => other,
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
    /// Repair changed the components or boundaries that the input seems to have.
    TopologyRepaired,
    /// Sharp edges in loose pieces that are short, or no sharper than their surroundings, were dropped.
    LooseFeaturesDropped,
    /// No map follows the sharp edges that were found; they were not kept.
    SharpEdgesDropped,
    /// A curve that was found has no quad edge along it.
    FeatureLost,
    /// The count asked for was missed by more than the tolerance.
    CountMissed,
    /// No count was asked for, and the one aimed at was missed by more than the tolerance.
    DefaultCountMissed,
    /// Vertices left their feature, because a quad would be inverted otherwise.
    FeaturesLeft,
    /// A drawn curve is far from the surface.
    GuideFar,
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
    /// The quads are so large that they miss parts of the surface's shape.
    DetailLost,
    /// A stage that was asked for does not exist for this input.
    Ignored,
    /// Parts of the surface have no source from which a distance could be measured.
    Unreached,
    /// A path that was asked for begins where no source reaches.
    PathMissed,
    /// A tolerance of refinement was not met.
    RefinementMissed,
    /// A tile has another map than the one asked for.
    TileMapMissed,
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

impl WarningCode {
    /// Whether something that the user asked for was not reached, although the result is valid.
    pub fn misses_request(self) -> bool {
        self.rank() == 0
    }

    /// How much a warning matters: 0 where a request was missed, then the less the larger.
    ///
    /// 1: the result is not what one would expect of it. 2: the input is not what its owner may think. 3: how the
    /// result came about.
    pub fn rank(self) -> u8 {
        match self {
            Self::CountMissed
            | Self::FacingUnclear
            | Self::FeatureMissed
            | Self::GuideFar
            | Self::PathMissed
            | Self::RefinementMissed
            | Self::SingularitiesMissed
            | Self::TieMissed
            | Self::TileMapMissed
            | Self::TrianglesSplit => 0,
            Self::SharpEdgesDropped
            | Self::FeatureLost
            | Self::FeaturesLeft
            | Self::DetailLost
            | Self::DefaultCountMissed
            | Self::TopologyRepaired
            | Self::Unreached
            | Self::Ignored => 1,
            Self::FoldsSurvived | Self::LooseFeaturesDropped | Self::NoiseSmoothed | Self::Repaired => 2,
            Self::Retried => 3,
        }
    }
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
        self.code.misses_request()
    }
}
