//! What can go wrong when a field is read or solved, with the elements concerned.

use quadloom_mesh::{Cancelled, FaceId, VertexId};
use quadloom_numeric::SolveError;

/// Why there is no field.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FieldError {
    /// A list has not one entry per face.
    #[error("the field has {found} entries, but the mesh has {expected} faces")]
    WrongLength {
        /// Faces of the mesh.
        expected: usize,
        /// Entries given.
        found: usize,
    },
    /// A vector is zero, not finite or perpendicular to its face.
    #[error("the vector of face {face} has no direction in the face's plane")]
    NoDirection {
        /// The face.
        face: FaceId,
    },
    /// A constrained angle, weight or option is not finite.
    #[error("the constraint of face {face} is not a finite number")]
    NotFinite {
        /// The face.
        face: FaceId,
    },
    /// A prescribed vertex does not exist or lies on the boundary, where indices are not defined.
    #[error("vertex {vertex} cannot have a prescribed index: it is no interior vertex")]
    NoInteriorVertex {
        /// The vertex.
        vertex: VertexId,
    },
    /// No field has the prescribed indices.
    #[error("no cross field has the prescribed indices: {reason}")]
    Unsatisfiable {
        /// Which vertices exclude each other.
        reason: String,
    },
    /// The mixed-integer solver failed.
    #[error("cross field solve: {0}")]
    Solve(#[from] SolveError),
    /// The run was asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
