//! A surface mesh: checked connectivity with a position per vertex.
//!
//! In: positions and faces. Out: [`TriMesh`], [`QuadMesh`], [`PolygonMesh`].
//! Holds: what [`Connectivity`] holds, and every coordinate is finite. Not: positive areas, no self-intersection.

use crate::connectivity::{Connectivity, Defect, FaceShape, Fixed, Mixed};
use crate::ids::{FaceId, VertexId, VertexMap};
use glam::DVec3;
use std::ops::Deref;

/// Connectivity with a position per vertex, in file units.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh<S> {
    connectivity: Connectivity<S>,
    positions: VertexMap<DVec3>,
}

/// A triangle mesh.
pub type TriMesh = Mesh<Fixed<3>>;
/// A pure-quad mesh.
pub type QuadMesh = Mesh<Fixed<4>>;
/// A mesh of polygons of any degree.
pub type PolygonMesh = Mesh<Mixed>;

/// Why positions and faces are not a mesh.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// The face list is not an oriented 2-manifold.
    #[error("{}", list_defects(.0))]
    Connectivity(Vec<Defect>),
    /// A coordinate is NaN or infinite.
    #[error("vertex {0} has a coordinate that is not finite")]
    NotFinite(VertexId),
}

fn list_defects(defects: &[Defect]) -> String {
    match defects {
        [] => "no defect".into(),
        [one] => one.to_string(),
        [first, rest @ ..] => format!("{first} (and {} more defects)", rest.len()),
    }
}

impl<const N: usize> Mesh<Fixed<N>> {
    /// Builds a mesh from positions and faces.
    ///
    /// # Errors     every defect of the connectivity; the first coordinate that is not finite
    /// # Cost       linear
    pub fn new(positions: Vec<DVec3>, faces: &[[u32; N]]) -> Result<Self, MeshError> {
        let connectivity = Connectivity::from_faces(positions.len(), faces).map_err(MeshError::Connectivity)?;
        Self::from_parts(connectivity, VertexMap::from_vec(positions))
    }
}

impl Mesh<Mixed> {
    /// Builds a mesh from positions and polygons.
    ///
    /// # Errors     every defect of the connectivity; the first coordinate that is not finite
    /// # Cost       linear
    pub fn new<F: AsRef<[u32]>>(positions: Vec<DVec3>, faces: &[F]) -> Result<Self, MeshError> {
        let connectivity = Connectivity::from_polygons(positions.len(), faces).map_err(MeshError::Connectivity)?;
        Self::from_parts(connectivity, VertexMap::from_vec(positions))
    }
}

impl<S: FaceShape> Mesh<S> {
    /// Joins checked connectivity with positions, one per vertex.
    ///
    /// # Errors     the first coordinate that is not finite
    pub fn from_parts(connectivity: Connectivity<S>, positions: VertexMap<DVec3>) -> Result<Self, MeshError> {
        assert_eq!(connectivity.vertex_count(), positions.len(), "one position per vertex");
        let not_finite = positions.iter().find(|(_, p)| !p.is_finite()).map(|(v, _)| v);
        match not_finite {
            Some(v) => Err(MeshError::NotFinite(v)),
            None => Ok(Self { connectivity, positions }),
        }
    }

    /// The connectivity alone.
    pub fn connectivity(&self) -> &Connectivity<S> {
        &self.connectivity
    }
    /// All positions, file units.
    pub fn positions(&self) -> &VertexMap<DVec3> {
        &self.positions
    }
    /// Position of a vertex, file units.
    #[inline]
    pub fn position(&self, v: VertexId) -> DVec3 {
        self.positions[v]
    }
    /// The same connectivity with other positions.
    ///
    /// # Errors     the first coordinate that is not finite
    pub fn with_positions(&self, positions: VertexMap<DVec3>) -> Result<Self, MeshError> {
        Self::from_parts(self.connectivity.clone(), positions)
    }
    /// Smallest and largest coordinates.
    pub fn bounding_box(&self) -> (DVec3, DVec3) {
        self.positions
            .values()
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), &p| (lo.min(p), hi.max(p)))
    }
    /// Length of the bounding box's diagonal, file units.
    pub fn diagonal(&self) -> f64 {
        let (lo, hi) = self.bounding_box();
        if lo.x <= hi.x { (hi - lo).length() } else { 0.0 }
    }
    /// Vector area of a face (normal direction, length = area), by the shoelace formula in space.
    pub fn vector_area(&self, f: FaceId) -> DVec3 {
        let first = self.position(self.origin(self.first_half_edge(f)));
        let twice: DVec3 = self
            .sides(f)
            .map(|h| (self.position(self.origin(h)) - first).cross(self.position(self.target(h)) - first))
            .sum();
        0.5 * twice
    }
    /// Unit normal of a face; zero where its area is zero.
    pub fn face_normal(&self, f: FaceId) -> DVec3 {
        self.vector_area(f).normalize_or_zero()
    }
    /// Total area, file units squared.
    pub fn area(&self) -> f64 {
        self.faces().map(|f| self.vector_area(f).length()).sum()
    }
}

impl<S> Deref for Mesh<S> {
    type Target = Connectivity<S>;
    fn deref(&self) -> &Connectivity<S> {
        &self.connectivity
    }
}
