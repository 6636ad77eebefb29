//! The surface that quads stand for, prepared for closest-point queries.
//!
//! In: the input mesh and its features. Out: [`Reference`]. Holds: queries are exact up to rounding.
//! Source: own.

use quadloom_mesh::closest::{ClosestPoint, PolylineIndex};
use quadloom_mesh::{DVec3, FaceId, FeatureGraph, TriMesh};

/// A triangle mesh with its features, and trees over both.
#[derive(Clone, Debug)]
pub struct Reference<'a> {
    /// The surface.
    pub mesh: &'a TriMesh,
    /// Its features.
    pub features: &'a FeatureGraph,
    /// Answers closest-point queries on the surface.
    pub closest: ClosestPoint,
    /// Answers closest-point queries on the chains, by their numbers.
    pub curves: PolylineIndex,
}

impl<'a> Reference<'a> {
    /// Prepares a surface.
    ///
    /// # Cost       O(n log n)
    pub fn new(mesh: &'a TriMesh, features: &'a FeatureGraph) -> Self {
        let curves = PolylineIndex::from_features(mesh, features);
        Self { mesh, features, closest: ClosestPoint::new(mesh), curves }
    }

    /// Whether a quad faces against the surface: at its centre, and half way from there to at least two corners.
    ///
    /// One point alone may be nearest to the other side of a thin sheet.
    ///
    /// # Input      hint: a face near the quad
    pub fn faces_against(&self, corner: [DVec3; 4], hint: FaceId) -> bool {
        self.points_against(corner, hint) >= 3
    }

    /// At how many of five points a quad faces against the surface: its centre, and half way from there to the corners;
    /// 0 if it does not at its centre. A quad that is turned over has all five.
    ///
    /// # Input      hint: a face near the quad
    pub fn points_against(&self, corner: [DVec3; 4], hint: FaceId) -> usize {
        let normal = (corner[2] - corner[0]).cross(corner[3] - corner[1]);
        let centre = (corner[0] + corner[1] + corner[2] + corner[3]) / 4.0;
        let against = |p: DVec3| self.mesh.vector_area(self.closest.query_near(p, hint).point.face).dot(normal) < 0.0;
        if against(centre) { 1 + corner.iter().filter(|c| against(c.lerp(centre, 0.5))).count() } else { 0 }
    }
}
