//! What a cut along an edge costs.
//!
//! In: a mesh, lengths, multipliers, places where no cut may run. Out: [`EdgeCosts`].
//! Holds: costs are finite and not negative, or infinite where no cut may run. Searches add them up as integers
//! ([`EdgeCosts::units`]), so that a sum does not depend on its order and no two paths tie by chance of rounding.
//! Source: [Favreau2009] §5.3.

use crate::error::TilingError;
use quadloom_mesh::{EdgeMap, FaceId, TriMesh, VertexId, VertexMap, metric};
use std::f64::consts::PI;

/// Cost of every edge, ≥ 0; infinite where no cut may run.
#[derive(Clone, Debug, PartialEq)]
pub struct EdgeCosts {
    value: EdgeMap<f64>,
}

/// The sum of all costs in integer units; leaves two bits for sums of two distances.
const UNITS: f64 = (1u64 << 61) as f64;
/// Ties are broken by numbers of this many bits, one per edge. More: costs of large meshes are changed by more than a
/// millionth of an edge. Fewer: equal paths of regular meshes stay equal.
const TIE_BITS: u32 = 16;
/// Cost in units of an edge along which no cut may run.
pub(crate) const FORBIDDEN: u64 = u64::MAX;

impl EdgeCosts {
    /// Any costs, one per edge.
    ///
    /// # Errors     [`TilingError::Cost`] names the first edge whose cost is negative or NaN
    pub fn new(value: EdgeMap<f64>) -> Result<Self, TilingError> {
        let bad = value.iter().find(|(_, c)| c.is_nan() || **c < 0.0).map(|(edge, &cost)| (edge, cost));
        match bad {
            Some((edge, cost)) => Err(TilingError::Cost { edge, cost }),
            None => Ok(Self { value }),
        }
    }

    /// Lengths of edges, file units ([Favreau2009] §5.3, d_E).
    pub fn euclidean(mesh: &TriMesh) -> Self {
        Self { value: metric::edge_lengths(mesh) }
    }

    /// Lengths that are smaller where the surface bends: d·(1 − c·|α|/π), with α the angle between the normals of an
    /// edge's triangles; borders count as bent by π ([Favreau2009] §5.3, d_{m,c}).
    ///
    /// # Input      strength: c in 0..=1; 0 is Euclidean
    /// # Errors     [`TilingError::Option`] for another c
    pub fn curvature(mesh: &TriMesh, strength: f64) -> Result<Self, TilingError> {
        if !(0.0..=1.0).contains(&strength) {
            return Err(TilingError::Option { what: "the weight of curvature", range: "in 0..=1", value: strength });
        }
        let mut costs = Self::euclidean(mesh);
        for e in mesh.edges() {
            let h = mesh.half_edge(e);
            let bend = if mesh.is_boundary_edge(e) { PI } else { metric::dihedral_angle(mesh, h).abs() };
            costs.value[e] *= (1.0 - strength * bend / PI).max(0.0);
        }
        Ok(costs)
    }

    /// Costs times a multiplier per edge ([Favreau2009] §5.3, d·m); infinity forbids an edge.
    ///
    /// # Errors     [`TilingError::Cost`] names the first edge whose cost becomes negative or NaN
    pub fn times(&self, multiplier: &EdgeMap<f64>) -> Result<Self, TilingError> {
        Self::new(EdgeMap::from_fn(self.value.len(), |e| self.value[e] * multiplier[e]))
    }

    /// Costs times the mean of a multiplier at each edge's ends.
    ///
    /// # Errors     [`TilingError::Cost`] names the first edge whose cost becomes negative or NaN
    pub fn times_vertices(&self, mesh: &TriMesh, multiplier: &VertexMap<f64>) -> Result<Self, TilingError> {
        let mean = |e| mesh.ends(e).map(|v| 0.5 * multiplier[v]).iter().sum();
        self.times(&EdgeMap::from_fn(self.value.len(), mean))
    }

    /// Forbids cuts along every edge that has one of these vertices as an end.
    pub fn without_vertices(mut self, mesh: &TriMesh, vertices: impl IntoIterator<Item = VertexId>) -> Self {
        for v in vertices {
            mesh.vertex_edges(v).for_each(|e| self.value[e] = f64::INFINITY);
        }
        self
    }

    /// Forbids cuts through the inside of a region: along edges both of whose faces are in it.
    pub fn without_faces(mut self, mesh: &TriMesh, inside: impl Fn(FaceId) -> bool) -> Self {
        for e in mesh.edges() {
            let (a, b) = mesh.edge_faces(e);
            if inside(a) && b.is_none_or(&inside) {
                self.value[e] = f64::INFINITY;
            }
        }
        self
    }

    /// The costs, by edge.
    pub fn values(&self) -> &EdgeMap<f64> {
        &self.value
    }

    /// The costs as integers.
    ///
    /// # Guarantees positive; their sum is below 2⁶²; each is within 2⁻⁴⁴ of the sum of all costs of the true one, and
    /// the part of that which is not rounding is a number of the edge alone, so that two paths never tie in practice
    pub(crate) fn units(&self) -> Vec<u64> {
        let finite = self.value.values().iter().filter(|c| c.is_finite());
        let largest = finite.clone().fold(0.0, |a: f64, &b| a.max(b));
        // Costs near the largest number would overflow their sum.
        let sum: f64 = finite.map(|c| c / largest.max(f64::MIN_POSITIVE)).sum();
        let scale = if sum > 0.0 { UNITS / sum } else { 0.0 };
        let tie = |e: u32| {
            let mixed = (u64::from(e) + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            let mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            1 + (mixed >> (64 - TIE_BITS))
        };
        let units = |(e, &c): (quadloom_mesh::EdgeId, &f64)| {
            let relative = c / largest.max(f64::MIN_POSITIVE);
            if c.is_finite() { (relative * scale) as u64 + tie(e.0) } else { FORBIDDEN }
        };
        self.value.iter().map(units).collect()
    }
}
