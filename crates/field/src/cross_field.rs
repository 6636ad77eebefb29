//! Cross fields: one angle per face and one period jump per edge.
//!
//! In: a triangle mesh. Out: [`CrossField`], singular vertices, transport between faces.
//! Holds: indices are multiples of 1/4 and sum to chi on closed meshes (Poincaré-Hopf).
//! Source: [Bommes2012] §8.2, Eq. (8.1); [Ray2008].

use quadloom_mesh::{EdgeMap, FaceMap};
use serde::{Deserialize, Serialize};

/// A cross per face and how neighbouring crosses are matched.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CrossField {
    /// Angle of one of the four directions in the face's frame (x along side 0), radians.
    pub angle: FaceMap<f64>,
    /// Period jump p_ij from the face i of the edge's canonical half-edge to the face j across; 0 on the boundary.
    ///
    /// The direction θ_i of face i matches θ_j = θ_i + κ_ij + π/2·p_ij of face j.
    pub period_jump: EdgeMap<i32>,
}
