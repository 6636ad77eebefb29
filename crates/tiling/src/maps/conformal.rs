//! Discrete conformal maps to a given border: harmonic coordinates with cotangent weights.
//!
//! In: a disk whose border is placed. Out: places of all vertices. Holds: the map of least Dirichlet energy
//! among piecewise linear ones with this border. Not: free of folds, where triangles are obtuse and weights negative.
//! Source: [Eck1995], [PinkallPolthier1993].

use super::MapMethod;
use super::disk::{Disk, NONE};
use super::error::MapError;
use super::harmonic::Rows;
use super::mean_value::start;
use super::metric::Metric;
use quadloom_mesh::{DVec2, HalfEdgeId, TriMesh, VertexMap};
use quadloom_numeric::{CholeskyError, SparseCholesky, SparseSymmetric, Triplet};

/// Places of all vertices.
pub(super) fn solve(
    mesh: &TriMesh,
    disk: &Disk,
    metric: &Metric,
    border: &[DVec2],
) -> Result<VertexMap<DVec2>, MapError> {
    let mut place = start(mesh, disk, border);
    if disk.interior.is_empty() {
        return Ok(place);
    }
    let rows = Rows::new(mesh, disk, |h| cotangent_weight(mesh, metric, h));
    let matrix = stiffness(disk, &rows);
    let factor = factorized(&matrix).map_err(|e| fault(MapMethod::Conformal, &e))?;
    rows.settle(disk, &mut place, |b| factor.solve_columns(b, 2));
    Ok(place)
}

pub(super) fn factorized(matrix: &SparseSymmetric) -> Result<SparseCholesky, CholeskyError> {
    let mut factor = SparseCholesky::analyse(matrix, &[])?;
    factor.factorize(matrix)?;
    Ok(factor)
}

pub(super) fn fault(method: MapMethod, what: &CholeskyError) -> MapError {
    MapError::Solve { method, what: what.to_string() }
}

/// Half the sum of the cotangents opposite to an edge inside.
fn cotangent_weight(mesh: &TriMesh, metric: &Metric, h: HalfEdgeId) -> f64 {
    let opposite = |h: HalfEdgeId| metric.cotangent(mesh.prev(h));
    0.5 * (opposite(h) + mesh.twin(h).map_or(0.0, opposite))
}

fn stiffness(disk: &Disk, rows: &Rows) -> SparseSymmetric {
    let mut triplets: Vec<Triplet> = Vec::new();
    for i in 0..rows.len() {
        let total: f64 = rows.row(i).map(|at| rows.weight[at]).sum();
        triplets.push((i as u32, i as u32, total));
        for at in rows.row(i) {
            let j = disk.inner[rows.neighbour[at]];
            if j != NONE && j > i as u32 {
                triplets.push((i as u32, j, -rows.weight[at]));
            }
        }
    }
    SparseSymmetric::from_triplets(rows.len(), &triplets)
}
