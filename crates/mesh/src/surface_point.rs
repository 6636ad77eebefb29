//! A point on a triangle mesh.
//!
//! In: a face and barycentric weights. Out: a position. Holds: weights are those given; they should sum to 1.

use crate::ids::FaceId;
use crate::mesh::TriMesh;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A point of a face by its barycentric weights.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SurfacePoint {
    /// The face.
    pub face: FaceId,
    /// Weights of the face's three corners; they sum to 1.
    pub weights: [f64; 3],
}

impl SurfacePoint {
    /// Position in space, file units.
    pub fn position(&self, mesh: &TriMesh) -> DVec3 {
        let corner = mesh.face_vertices(self.face).map(|v| mesh.position(v));
        corner[0] * self.weights[0] + corner[1] * self.weights[1] + corner[2] * self.weights[2]
    }
}
