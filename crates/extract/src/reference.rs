//! The surface that quads stand for, prepared for closest-point queries.
//!
//! In: the input mesh and its features. Out: [`Reference`]. Holds: queries are exact up to rounding.
//! Source: own.

use quadloom_mesh::closest::{ClosestPoint, PolylineIndex};
use quadloom_mesh::{DVec3, FaceId, FeatureGraph, TriMesh};
use std::collections::{HashSet, VecDeque};

/// Faces that a quad covers of which the mean normal is made, from the nearest one outwards: the noise of a scan is
/// smaller than this many.
const MOST_COVERED: usize = 200;

/// How a quad lies to the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Facing {
    /// As it should.
    Along,
    /// Its centre is nearest to a face that it faces against, but the mean of what it covers is along it.
    Wrinkled,
    /// Its centre faces against what it covers there, but most of its other points do not: perhaps a thin sheet.
    Unclear,
    /// Against the surface that it covers, whose unit normal this is.
    Against(DVec3),
}

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

    /// Whether a quad faces against the surface that it covers.
    ///
    /// # Input      hint: a face near the quad
    pub fn faces_against(&self, corner: [DVec3; 4], hint: FaceId) -> bool {
        matches!(self.facing(corner, hint), Facing::Against(_))
    }

    /// How a quad faces at five points: its centre, and half way from there to the corners.
    ///
    /// It faces against the surface if it does so at its centre and at two other points at least: against the nearest
    /// faces, or against the mean of what it covers there. One point alone may be nearest to the other side of a thin
    /// sheet, and one face alone may be the side of a wrinkle that is smaller than the quad.
    ///
    /// # Input      hint: a face near the quad
    /// # Cost       five closest-point queries; where one of the nearest faces does face against the quad, also a visit of
    /// the faces that it covers
    pub fn facing(&self, corner: [DVec3; 4], hint: FaceId) -> Facing {
        let normal = (corner[2] - corner[0]).cross(corner[3] - corner[1]);
        let points = five_points(corner);
        // 1. The nearest faces.
        let nearest = |p: DVec3| self.mesh.vector_area(self.closest.query_near(p, hint).point.face).dot(normal) < 0.0;
        let against = points.map(nearest);
        if against.iter().all(|a| !a) {
            return Facing::Along;
        }
        let normal_of = |f: FaceId| self.mesh.vector_area(f).normalize_or_zero();
        if against[0] && against.iter().filter(|a| **a).count() >= 3 {
            return Facing::Against(normal_of(self.closest.query_near(points[0], hint).point.face));
        }
        // 2. What the quad covers.
        let reach = 0.5 * corner[0].distance(corner[2]).max(corner[1].distance(corner[3]));
        let [centre, middles @ ..] = points;
        let around = self.normal_around(centre, hint, reach);
        let is_against = |p: &DVec3| self.normal_around(*p, hint, reach).dot(normal) < 0.0;
        if around.dot(normal) < 0.0 && middles.iter().filter(|p| is_against(p)).take(2).count() == 2 {
            return Facing::Against(around.normalize_or_zero());
        }
        match against[0] {
            true if around.dot(normal) < 0.0 => Facing::Unclear,
            true => Facing::Wrinkled,
            false => Facing::Along,
        }
    }

    /// The mean normal, not normalised, of the face nearest to a point and of those joined to it that have a vertex or
    /// their centroid within reach of the point, up to the features.
    fn normal_around(&self, p: DVec3, hint: FaceId, reach: f64) -> DVec3 {
        let nearest = self.closest.query_near(p, hint);
        let reach = (nearest.distance + reach).powi(2);
        let is_near = |f: FaceId| {
            let corner = self.mesh.face_vertices(f).map(|v| self.mesh.position(v));
            let centroid = corner.iter().sum::<DVec3>() / 3.0;
            centroid.distance_squared(p) <= reach || corner.iter().any(|c| c.distance_squared(p) <= reach)
        };
        let (mut seen, mut next) = (HashSet::from([nearest.point.face]), VecDeque::from([nearest.point.face]));
        let (mut sum, mut visited) = (DVec3::ZERO, 0);
        while let Some(f) = next.pop_front().filter(|_| visited < MOST_COVERED) {
            visited += 1;
            sum += self.mesh.vector_area(f);
            let joined =
                self.mesh.face_half_edges(f).into_iter().filter(|&h| !self.features.is_feature(self.mesh.edge(h)));
            let neighbours = joined.filter_map(|h| self.mesh.twin(h)).map(|t| self.mesh.face(t));
            next.extend(neighbours.filter(|&g| is_near(g) && seen.insert(g)));
        }
        sum
    }
}

/// The centre of a quad, and half way from there to its corners.
fn five_points(corner: [DVec3; 4]) -> [DVec3; 5] {
    let centre = corner.iter().sum::<DVec3>() / 4.0;
    let [a, b, c, d] = corner.map(|c| c.lerp(centre, 0.5));
    [centre, a, b, c, d]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quad on the upper side of a thin bent sheet sags through the lower one: that is not taken for granted.
    #[test]
    fn a_quad_through_a_thin_sheet_is_not_along_it() {
        let sheet = quadloom_mesh::shapes::cube(1.0, 8);
        let bend = |p: &DVec3| DVec3::new(p.x, p.y, 0.001 * p.z - (p.x - 0.5).powi(2));
        let positions = sheet.positions().values().iter().map(bend).collect();
        let sheet = TriMesh::new(positions, &sheet.to_faces()).expect("a bent sheet");
        let features = FeatureGraph::none(&sheet);
        let reference = Reference::new(&sheet, &features);
        let at = |x: f64, y: f64| bend(&DVec3::new(x, y, 1.0));
        let upper = [at(0.25, 0.25), at(0.75, 0.25), at(0.75, 0.75), at(0.25, 0.75)];
        let centre = upper.iter().sum::<DVec3>() / 4.0;
        assert_ne!(reference.facing(upper, reference.closest.query(centre).point.face), Facing::Along);
    }

    /// A plane with a fold that is smaller than the quad above it, and the same quad turned over.
    #[test]
    fn a_wrinkle_does_not_turn_the_surface_around() {
        let line: Vec<(f64, f64)> = [(0.0, 0.0), (1.0, 0.0), (2.1, 0.3), (1.9, -0.3), (3.0, 0.0), (4.0, 0.0)].into();
        let positions = line.iter().flat_map(|&(x, z)| [DVec3::new(x, 0.0, z), DVec3::new(x, 4.0, z)]).collect();
        let faces: Vec<[u32; 3]> =
            (0..5).flat_map(|i| [[2 * i, 2 * i + 2, 2 * i + 3], [2 * i, 2 * i + 3, 2 * i + 1]]).collect();
        let sheet = TriMesh::new(positions, &faces).expect("a sheet");
        let features = FeatureGraph::none(&sheet);
        let reference = Reference::new(&sheet, &features);
        let quad = [(1.9, 1.9), (2.1, 1.9), (2.1, 2.1), (1.9, 2.1)].map(|(x, y)| DVec3::new(x, y, 0.0));
        let wide = [(0.5, 0.5), (3.5, 0.5), (3.5, 3.5), (0.5, 3.5)].map(|(x, y)| DVec3::new(x, y, 0.0));
        let hint = FaceId(4);
        assert_eq!(reference.facing(wide, hint), Facing::Wrinkled);
        let [a, b, c, d] = wide;
        assert!(reference.faces_against([d, c, b, a], hint));
        // One that is smaller than the fold stands for the fold's own side.
        assert!(reference.faces_against(quad, hint));
    }
}
