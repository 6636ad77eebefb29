//! How far a map is from the surface: angles and areas.
//!
//! In: a mesh, its metric, a place per vertex. Out: [`Distortion`]. Holds: finite for any finite places.

use super::metric::Metric;
use quadloom_mesh::{DVec2, FaceId, HalfEdgeId, TriMesh, VertexMap};
use serde::{Deserialize, Serialize};

/// Distortion of a map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Distortion {
    /// Mean over all corners of |flat angle − angle on the surface|, degrees. A folded face has negative flat angles.
    pub angle_mean: f64,
    /// The largest of them, degrees.
    pub angle_largest: f64,
    /// Mean over all faces, weighted by area on the surface, of the factor between a face's share of the flat area
    /// and its share of the surface, or its inverse, whichever is larger; 1 is none. Faces that are folded or have no
    /// area are left out.
    pub area_mean: f64,
    /// The largest of these factors.
    pub area_largest: f64,
}

/// Measures a map.
pub(super) fn measure(mesh: &TriMesh, metric: &Metric, uv: &VertexMap<DVec2>) -> Distortion {
    let (angle_mean, angle_largest) = angle_errors(mesh, metric, uv);
    let (area_mean, area_largest) = area_factors(mesh, metric, uv);
    Distortion { angle_mean, angle_largest, area_mean, area_largest }
}

fn angle_errors(mesh: &TriMesh, metric: &Metric, uv: &VertexMap<DVec2>) -> (f64, f64) {
    let error = |h: HalfEdgeId| (flat_angle(mesh, uv, h) - metric.angle(h)).abs().to_degrees();
    let (sum, largest) = mesh.half_edges().map(error).fold((0.0, 0.0f64), |(s, m), e| (s + e, m.max(e)));
    (sum / mesh.half_edge_count() as f64, largest)
}

fn flat_angle(mesh: &TriMesh, uv: &VertexMap<DVec2>, h: HalfEdgeId) -> f64 {
    let apex = uv[mesh.origin(h)];
    let (right, left) = (uv[mesh.target(h)] - apex, uv[mesh.origin(mesh.prev(h))] - apex);
    right.perp_dot(left).atan2(right.dot(left))
}

fn area_factors(mesh: &TriMesh, metric: &Metric, uv: &VertexMap<DVec2>) -> (f64, f64) {
    let flat = |f: FaceId| {
        let [a, b, c] = mesh.face_vertices(f).map(|v| uv[v]);
        0.5 * (b - a).perp_dot(c - a)
    };
    let pairs: Vec<[f64; 2]> = mesh.faces().map(|f| [flat(f), metric.area(mesh, f)]).collect();
    let total = pairs.iter().fold([0.0; 2], |t, p| [t[0] + p[0], t[1] + p[1]]);
    let (mut sum, mut weight, mut largest) = (0.0, 0.0, 1.0f64);
    for [flat, curved] in pairs.into_iter().filter(|p| p[0] > 0.0 && p[1] > 0.0) {
        let factor = (flat / total[0]) / (curved / total[1]);
        let factor = factor.max(1.0 / factor);
        sum += curved * factor;
        weight += curved;
        largest = largest.max(factor);
    }
    (if weight > 0.0 { sum / weight } else { 1.0 }, largest)
}
