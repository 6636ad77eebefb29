//! The surface that quads stand for, prepared for closest-point queries.
//!
//! In: the input mesh and its features. Out: [`Reference`]. Holds: queries are exact up to rounding.
//! Source: own.

use quadloom_mesh::closest::{ClosestPoint, PolylineIndex, closest_weights};
use quadloom_mesh::{DVec3, FaceId, FeatureGraph, TriMesh};

/// Faces count as touched that are farther than the nearest one by at most this part of its size, for rounding.
const TOUCHING_REL: f64 = 1e-9;

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

    /// Whether the surface faces like a quad at all of its corners: there at least one of the faces that the corner
    /// touches does, whatever is nearest to the places between.
    pub fn faces_along_at_corners(&self, corner: [DVec3; 4]) -> bool {
        let normal = (corner[2] - corner[0]).cross(corner[3] - corner[1]);
        let along = |&f: &FaceId| self.mesh.vector_area(f).dot(normal) > 0.0;
        corner.iter().all(|&p| self.faces_at(p).iter().any(along))
    }

    /// The face nearest to a point, and those around it that are as near.
    fn faces_at(&self, p: DVec3) -> Vec<FaceId> {
        let nearest = self.closest.query(p);
        let [a, b, c] = self.mesh.face_vertices(nearest.point.face).map(|v| self.mesh.position(v));
        let size = a.distance(b).max(b.distance(c)).max(nearest.distance);
        let reach = nearest.distance + TOUCHING_REL * size;
        let distance = |f: FaceId| {
            let corner = self.mesh.face_vertices(f).map(|v| self.mesh.position(v));
            let [a, b, c] = closest_weights(&corner, p);
            (corner[0] * a + corner[1] * b + corner[2] * c).distance(p)
        };
        let vertices = self.mesh.face_vertices(nearest.point.face);
        let around = vertices.iter().flat_map(|&v| self.mesh.outgoing(v)).map(|h| self.mesh.face(h));
        around.filter(|&f| distance(f) <= reach).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quad on the upper side of a thin bent sheet sags through the lower one.
    #[test]
    fn corners_tell_the_side_of_a_thin_sheet() {
        let sheet = quadloom_mesh::shapes::cube(1.0, 8);
        let bend = |p: &DVec3| DVec3::new(p.x, p.y, 0.001 * p.z - (p.x - 0.5).powi(2));
        let positions = sheet.positions().values().iter().map(bend).collect();
        let sheet = TriMesh::new(positions, &sheet.to_faces()).expect("a bent sheet");
        let features = FeatureGraph::none(&sheet);
        let reference = Reference::new(&sheet, &features);
        let at = |x: f64, y: f64| bend(&DVec3::new(x, y, 1.0));
        let upper = [at(0.25, 0.25), at(0.75, 0.25), at(0.75, 0.75), at(0.25, 0.75)];
        let centre = upper.iter().sum::<DVec3>() / 4.0;
        assert!(reference.points_against(upper, reference.closest.query(centre).point.face) > 0);
        assert!(reference.faces_along_at_corners(upper));
        let [a, b, c, d] = upper;
        assert!(!reference.faces_along_at_corners([d, c, b, a]));
    }
}
