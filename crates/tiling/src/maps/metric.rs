//! The tile's own metric, kept away from degenerate triangles.
//!
//! In: a mesh. Out: [`Metric`]: lengths in units of their mean, angles. Holds: every triangle inequality is strict by
//! [`LEAST_SLACK`], so that every angle lies inside (0, π), its cotangent is finite, and a planar tile whose triangles
//! are sound keeps its lengths as they are. Source: intrinsic mollification [SharpCrane2020].

use super::error::MapError;
use quadloom_mesh::metric::edge_lengths;
use quadloom_mesh::{CornerMap, EdgeMap, FaceId, HalfEdgeId, TriConnectivity, TriMesh};

/// Least excess of two sides over the third, mean edge lengths.
///
/// A needle of base 1 reaches it at height 7e-5. Larger: sound needles change the lengths of the whole tile. Smaller:
/// cotangents grow beyond the 1e8 whose squares the normal equations of the free borders can hold.
pub(super) const LEAST_SLACK: f64 = 1e-8;

/// Lengths and angles of a tile.
pub(super) struct Metric {
    /// Length of every edge, units: `unit`.
    pub length: EdgeMap<f64>,
    /// Mean length of the edges, file units; 1 where all are 0.
    pub unit: f64,
    /// Length that was added to every edge, mean lengths; 0 for a mesh without degenerate triangles.
    pub added: f64,
    /// Number of triangles that made it necessary.
    pub degenerate: usize,
    /// tan(θ/2) of every corner.
    pub half_tan: CornerMap<f64>,
}

impl Metric {
    /// # Errors     [`MapError::TooLong`]
    pub fn new(mesh: &TriMesh) -> Result<Self, MapError> {
        let mut length = edge_lengths(mesh);
        if let Some((edge, _)) = length.iter().find(|(_, l)| !l.is_finite()) {
            return Err(MapError::TooLong { edge });
        }
        let unit = scale_to_mean(&mut length);
        let (added, degenerate) = mollify(mesh, &mut length);
        let half_tan = half_tangents(mesh, &length);
        Ok(Self { length, unit, added, degenerate, half_tan })
    }

    /// Angle of a corner, radians.
    pub fn angle(&self, h: HalfEdgeId) -> f64 {
        2.0 * self.half_tan[h].atan()
    }

    /// Cotangent of a corner's angle.
    pub fn cotangent(&self, h: HalfEdgeId) -> f64 {
        let t = self.half_tan[h];
        0.5 * (1.0 - t * t) / t
    }

    /// Area of a face, units: `unit`².
    pub fn area(&self, mesh: &TriConnectivity, f: FaceId) -> f64 {
        let [a, b, c] = sides_of(mesh, &self.length, f);
        0.25 * ((a + b + c) * slack(a, b, c) * slack(b, c, a) * slack(c, a, b)).sqrt()
    }
}

/// Divides lengths by their mean, which is returned.
fn scale_to_mean(length: &mut EdgeMap<f64>) -> f64 {
    let count = length.len() as f64;
    let mean: f64 = length.values().iter().map(|l| l / count).sum();
    let unit = if mean > f64::MIN_POSITIVE && mean.is_finite() { mean } else { 1.0 };
    length.values_mut().iter_mut().for_each(|l| *l /= unit);
    unit
}

/// Lengthens all edges so that triangle inequalities are strict; returns by how much, and for how many faces.
fn mollify(mesh: &TriMesh, length: &mut EdgeMap<f64>) -> (f64, usize) {
    let (mut added, mut degenerate) = (0.0f64, 0);
    for f in mesh.faces() {
        let [a, b, c] = sides_of(mesh, length, f);
        let least = slack(a, b, c).min(slack(b, c, a)).min(slack(c, a, b));
        if least < LEAST_SLACK {
            added = added.max(LEAST_SLACK - least);
            degenerate += 1;
        }
    }
    length.values_mut().iter_mut().for_each(|l| *l += added);
    (added, degenerate)
}

fn half_tangents(mesh: &TriMesh, length: &EdgeMap<f64>) -> CornerMap<f64> {
    CornerMap::from_fn(mesh.half_edge_count(), |h| {
        let side = |h: HalfEdgeId| length[mesh.edge(h)];
        half_tangent(side(mesh.next(h)), side(mesh.prev(h)), side(h))
    })
}

fn sides_of(mesh: &TriConnectivity, length: &EdgeMap<f64>, f: FaceId) -> [f64; 3] {
    mesh.face_half_edges(f).map(|h| length[mesh.edge(h)])
}

/// tan(θ/2) of the angle opposite to side a of a triangle a, b, c.
pub(super) fn half_tangent(a: f64, b: f64, c: f64) -> f64 {
    (slack(b, c, a) * slack(c, a, b) / ((a + b + c) * slack(a, b, c))).sqrt()
}

/// b + c − a, with the cancelling terms first.
pub(super) fn slack(a: f64, b: f64, c: f64) -> f64 {
    (b.max(c) - a) + b.min(c)
}
