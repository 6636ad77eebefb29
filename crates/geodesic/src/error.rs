//! What can be wrong with a surface, with sources, or with a question.
//!
//! In: ids and numbers. Out: messages with the element, what is wrong and the cure.

use quadloom_mesh::{Cancelled, EdgeId, FaceId, VertexId};

/// Why there is no distance field.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GeodesicError {
    /// The number of lengths is not that of the edges.
    #[error("{found} lengths for {edges} edges; give one per edge, in the order of their ids")]
    LengthCount {
        /// Number of lengths.
        found: usize,
        /// Number of edges.
        edges: usize,
    },
    /// A length is no length.
    #[error("edge {edge} has length {length}; lengths must be finite and not negative")]
    Length {
        /// The edge.
        edge: EdgeId,
        /// Its length, file units.
        length: f64,
    },
    /// No triangle has these sides.
    #[error("face {face} has sides {lengths:?}: one is longer than the others together; correct its lengths")]
    TriangleInequality {
        /// The face.
        face: FaceId,
        /// Its lengths, file units.
        lengths: [f64; 3],
    },
    /// More vertices and sources than ids.
    #[error("{roots} vertices and sources are more than the {most} that can be told apart; use fewer sources")]
    TooLarge {
        /// Vertices and sources.
        roots: usize,
        /// The most there may be.
        most: usize,
    },
    /// There is nothing to measure from.
    #[error("there is no source; name at least one vertex, point or curve")]
    NoSource,
    /// A source names a vertex that does not exist.
    #[error("source {label}: there is no vertex {vertex}, the last one is {last}")]
    NoVertex {
        /// Label of the source.
        label: u32,
        /// The vertex.
        vertex: VertexId,
        /// The largest id.
        last: usize,
    },
    /// A source names a face that does not exist.
    #[error("source {label}: there is no face {face}, the last one is {last}")]
    NoFace {
        /// Label of the source.
        label: u32,
        /// The face.
        face: FaceId,
        /// The largest id.
        last: usize,
    },
    /// Barycentric weights that are no point of a face.
    #[error("source {label}: {weights:?} is no point of face {face}; weights are in 0..=1 and sum to 1")]
    Weights {
        /// Label of the source.
        label: u32,
        /// The face.
        face: FaceId,
        /// The weights.
        weights: [f64; 3],
    },
    /// A segment whose ends are in different faces.
    #[error("source {label}: the segment's ends are in faces {} and {}; cut it where it crosses edges", faces[0], faces[1])]
    SegmentFaces {
        /// Label of the source.
        label: u32,
        /// Faces of the ends.
        faces: [FaceId; 2],
    },
    /// A start value that is no distance.
    #[error("source {label} starts at {start}; start values must be finite and not negative")]
    Start {
        /// Label of the source.
        label: u32,
        /// Its start value, file units.
        start: f64,
    },
    /// Two points of a curve cannot be joined.
    #[error(
        "source {label}: points {point} and {} of the curve are on different components (faces {from} and {to}); \
         give a curve for each component", .point + 1
    )]
    CurveLeavesComponent {
        /// Label of the source.
        label: u32,
        /// Index of the first of the two points in the curve.
        point: usize,
        /// Its face.
        from: FaceId,
        /// The face of the next one.
        to: FaceId,
    },
    /// Tracing went round in circles: rounding hides which way is down.
    #[error("the path from face {face} could not be traced; its surroundings have no measurable extent")]
    PathLost {
        /// Face of the point.
        face: FaceId,
    },
    /// Windows are needed where only distances of vertices were kept.
    #[error("only distances of vertices were kept; spread with Keep::Windows to ask for more")]
    NoWindows,
    /// A tolerance that is none.
    #[error("{what} must be {range}, not {value}")]
    Option {
        /// What it is.
        what: &'static str,
        /// The values that are allowed.
        range: &'static str,
        /// What was given.
        value: f64,
    },
    /// The run was asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
