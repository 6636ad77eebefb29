//! Cross fields: one angle per face and one period jump per edge.
//!
//! In: a triangle mesh. Out: [`CrossField`], singular vertices, transport between faces.
//! Holds: indices are multiples of 1/4 and sum to chi on closed meshes (Poincaré-Hopf).
//! Source: [Bommes2012] §8.2, Eq. (8.1); [Ray2008].
//!
//! ```text
//!   direction 1                directions of a cross: θ, θ + π/2, θ + π, θ + 3π/2, numbered 0..4
//!        │                     index +1 quarter: the vertex of valence 3 of the quad mesh (a cube's corner)
//!   2 ───┼─── direction 0      index -1 quarter: valence 5
//!        │
//!        3
//! ```

use crate::error::FieldError;
use crate::transport::Transport;
use quadloom_mesh::metric::FaceFrame;
use quadloom_mesh::{DVec3, EdgeId, EdgeMap, FaceId, FaceMap, HalfEdgeId, TriConnectivity, TriMesh, VertexId};
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};

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

/// A violated condition of [`CrossField`].
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum FieldDefect {
    /// The field has as many angles or period jumps as some other mesh.
    #[error("the field has {angles} angles and {jumps} period jumps, the mesh {faces} faces and {edges} edges")]
    Size {
        /// Angles of the field.
        angles: usize,
        /// Period jumps of the field.
        jumps: usize,
        /// Faces of the mesh.
        faces: usize,
        /// Edges of the mesh.
        edges: usize,
    },
    /// An angle is NaN or infinite.
    #[error("the angle of face {0} is not finite")]
    NotFinite(FaceId),
    /// A boundary edge has a period jump.
    #[error("boundary edge {0} has a period jump")]
    BoundaryJump(EdgeId),
    /// Indices and boundary turning do not add up to the Euler characteristic.
    #[error("the indices sum to {found} quarters instead of {expected}")]
    IndexSum {
        /// Sum over all vertices, quarters.
        found: f64,
        /// Four times the Euler characteristic.
        expected: f64,
    },
}

impl CrossField {
    /// The field whose direction 0 in every face is the projection of the given vector.
    ///
    /// # Input      one vector per face, any positive length (the layout of `.rosy` files)
    /// # Output     neighbours are matched the nearest way: |θ_j - θ_i - κ_ij - π/2·p_ij| is at most π/4
    /// # Errors     [`FieldError::NoDirection`] names the first face whose vector has no direction in the face
    /// # Cost       linear
    pub fn from_directions(mesh: &TriMesh, direction: &FaceMap<DVec3>) -> Result<Self, FieldError> {
        if direction.len() != mesh.face_count() {
            return Err(FieldError::WrongLength { expected: mesh.face_count(), found: direction.len() });
        }
        let mut angle = FaceMap::filled(mesh.face_count(), 0.0);
        for f in mesh.faces() {
            let (frame, vector) = (FaceFrame::of(mesh, f), direction[f]);
            let in_face = vector - frame.normal * vector.dot(frame.normal);
            let has_direction = vector.is_finite() && in_face.length() > 1e-9 * vector.length();
            if !has_direction {
                return Err(FieldError::NoDirection { face: f });
            }
            angle[f] = frame.angle_of(vector);
        }
        Ok(Self::from_angles(mesh, &Transport::of(mesh), angle))
    }

    /// The field with the given angles whose neighbours are matched the nearest way.
    ///
    /// # Cost       linear
    pub fn from_angles(mesh: &TriConnectivity, transport: &Transport, angle: FaceMap<f64>) -> Self {
        let period_jump = EdgeMap::from_fn(mesh.edge_count(), |e| nearest_jump(mesh, transport, &angle, e));
        Self { angle, period_jump }
    }

    /// Direction `d` (0..4) of a face's cross as a unit vector in space.
    pub fn direction(&self, mesh: &TriMesh, f: FaceId, d: u8) -> DVec3 {
        FaceFrame::of(mesh, f).direction(self.direction_angle(f, d))
    }

    /// Angle of direction `d` (0..4) in the face's frame, radians.
    #[inline]
    pub fn direction_angle(&self, f: FaceId, d: u8) -> f64 {
        self.angle[f] + FRAC_PI_2 * f64::from(d)
    }

    /// The period jump seen from the face of a half-edge: p_ij, with p_ji = -p_ij; 0 on the boundary.
    #[inline]
    pub fn jump(&self, mesh: &TriConnectivity, h: HalfEdgeId) -> i32 {
        let e = mesh.edge(h);
        if mesh.half_edge(e) == h { self.period_jump[e] } else { -self.period_jump[e] }
    }

    /// Quarter turns k across a half-edge: direction d of its face continues as direction d + k (mod 4) of the face
    /// across; 0 on the boundary.
    ///
    /// θ_j = θ_i + κ + π/2·p, so direction d of face i is direction d - p of face j: k = -p mod 4. A chart whose
    /// x axis is direction 0 changes into the neighbour's chart by k counter-clockwise quarter turns.
    #[inline]
    pub fn matching(&self, mesh: &TriConnectivity, h: HalfEdgeId) -> u8 {
        (-self.jump(mesh, h)).rem_euclid(4) as u8
    }

    /// How far the cross turns across a half-edge: θ_j - θ_i - κ_ij - π/2·p_ij, radians; 0 on the boundary.
    #[inline]
    pub fn turn(&self, mesh: &TriConnectivity, transport: &Transport, h: HalfEdgeId) -> f64 {
        let Some(t) = mesh.twin(h) else { return 0.0 };
        let (i, j) = (mesh.face(h), mesh.face(t));
        self.angle[j] - self.angle[i] - transport.kappa(mesh, h) - FRAC_PI_2 * f64::from(self.jump(mesh, h))
    }

    /// Smoothness energy ([Bommes2012] §8.2, Eq. (8.1)): the sum of squared turns over the interior edges, radians².
    pub fn energy(&self, mesh: &TriConnectivity, transport: &Transport) -> f64 {
        mesh.edges().map(|e| self.turn(mesh, transport, mesh.half_edge(e)).powi(2)).sum()
    }

    /// Index of an interior vertex, quarters: +1 at valence 3, -1 at valence 5; 0 on the boundary.
    ///
    /// 4·I(v) = 4·I_0(v) - Σp over a counter-clockwise walk around v, integers throughout ([Bommes2012] §8.2; the
    /// thesis walks clockwise, hence its plus sign).
    pub fn index(&self, mesh: &TriConnectivity, transport: &Transport, v: VertexId) -> i32 {
        if mesh.is_boundary_vertex(v) {
            return 0;
        }
        transport.base_index(v) - transport.crossings(mesh, v).map(|h| self.jump(mesh, h)).sum::<i32>()
    }

    /// The interior vertices of nonzero index with their indices in quarters, ascending by id.
    pub fn singularities(&self, mesh: &TriConnectivity, transport: &Transport) -> Vec<(VertexId, i32)> {
        mesh.vertices().map(|v| (v, self.index(mesh, transport, v))).filter(|&(_, q)| q != 0).collect()
    }

    /// Index of any vertex from its angle defect and the turns around it, quarters.
    ///
    /// At interior vertices it equals [`CrossField::index`] up to rounding errors. At a boundary vertex it is an integer
    /// where the field is aligned with the two boundary edges: 2 minus the number of quads that meet there, so 0 on
    /// a straight boundary, 1 at a convex and -1 at a reflex corner. The sum over all vertices is 4·chi.
    pub fn turning(&self, mesh: &TriConnectivity, transport: &Transport, v: VertexId) -> f64 {
        let turns: f64 = transport.crossings(mesh, v).map(|h| self.turn(mesh, transport, h)).sum();
        (transport.defect(v) + turns) * FRAC_2_PI
    }

    /// Edges whose crosses are not matched the nearest way (turn beyond π/4), ascending.
    ///
    /// Such a matching is legal (prescribed indices can force it), but cannot be recovered from directions alone.
    pub fn far_matchings(&self, mesh: &TriConnectivity, transport: &Transport) -> Vec<EdgeId> {
        let limit = 0.5 * FRAC_PI_2 + 1e-9;
        mesh.edges().filter(|&e| self.turn(mesh, transport, mesh.half_edge(e)).abs() > limit).collect()
    }

    /// Every violated condition of the definition; empty for a cross field of this mesh.
    ///
    /// # Cost       linear
    /// # Source     [Bommes2012] §8.2; Poincaré-Hopf, with the turning of the boundary
    pub fn check(&self, mesh: &TriConnectivity, transport: &Transport) -> Vec<FieldDefect> {
        let (faces, edges) = (mesh.face_count(), mesh.edge_count());
        let (angles, jumps) = (self.angle.len(), self.period_jump.len());
        if (angles, jumps) != (faces, edges) {
            return vec![FieldDefect::Size { angles, jumps, faces, edges }];
        }
        let mut defects: Vec<FieldDefect> =
            mesh.faces().filter(|&f| !self.angle[f].is_finite()).map(FieldDefect::NotFinite).collect();
        defects.extend(
            mesh.edges()
                .filter(|&e| mesh.is_boundary_edge(e) && self.period_jump[e] != 0)
                .map(FieldDefect::BoundaryJump),
        );
        if defects.is_empty() {
            defects.extend(self.index_sum_defect(mesh, transport));
        }
        defects
    }

    fn index_sum_defect(&self, mesh: &TriConnectivity, transport: &Transport) -> Option<FieldDefect> {
        let found: f64 = mesh
            .vertices()
            .map(|v| match mesh.is_boundary_vertex(v) {
                true => self.turning(mesh, transport, v),
                false => f64::from(self.index(mesh, transport, v)),
            })
            .sum();
        let chi = mesh.vertex_count() as f64 - mesh.edge_count() as f64 + mesh.face_count() as f64;
        let expected = 4.0 * chi;
        ((found - expected).abs() > 0.25).then_some(FieldDefect::IndexSum { found, expected })
    }
}

/// The period jump that makes the turn across an edge smallest; 0 on the boundary.
pub(crate) fn nearest_jump(mesh: &TriConnectivity, transport: &Transport, angle: &FaceMap<f64>, e: EdgeId) -> i32 {
    let h = mesh.half_edge(e);
    let Some(t) = mesh.twin(h) else { return 0 };
    ((angle[mesh.face(t)] - angle[mesh.face(h)] - transport.kappa(mesh, h)) * FRAC_2_PI).round() as i32
}
