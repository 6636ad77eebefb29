//! Fold-free maps to a convex border by mean value coordinates.
//!
//! In: a disk whose border is placed. Out: places of all vertices and the number of times weights were changed.
//! Holds: no face is folded, by the exact test, or there is an error. Weights are always positive, so that the map is
//! an embedding in exact arithmetic ([Floater2003b], [Tutte1963]); in doubles a long finger of the surface shrinks by
//! e^(−2π·length/girth) until its places coincide, and then weights are divided by the stretch of the map, which moves
//! vertices towards the tip of the finger apart ([Yoshizawa2004]), until its faces can be told apart.
//!
//! | paper | here | meaning |
//! |---|---|---|
//! | λ_ij | `Rows::weight` | weight of neighbour j of interior vertex i |
//! | Γ, γ | inside [`stretch_sq`] | singular values of the map from the plane to the surface |
//! | σ_j | [`vertex_stretch`] | stretch of the map about vertex j |

use super::checks::folded_faces;
use super::disk::Disk;
use super::error::MapError;
use super::harmonic::{RowSolver, Rows};
use super::metric::Metric;
use super::{MapMethod, MapOptions};
use quadloom_mesh::{DVec2, FaceId, Progress, TriMesh, VertexMap};

/// Least weight in a row as a fraction of the largest.
///
/// Degenerate triangles have weights of any size. Larger: obtuse needles lose linear precision. Smaller: places of
/// neighbours differ by less than doubles can tell, and the faces between them have no area.
const LEAST_WEIGHT: f64 = 1e-9;

/// Lengths in the plane below this are taken for noise of the solver.
///
/// Stretches beyond one over it are not told apart. Larger: a finger takes more rounds. Smaller: weights follow noise.
const NOISE: f64 = 1e-14;

/// Places of all vertices, and the number of rounds of re-weighting.
///
/// # Errors     [`MapError::Folded`] if folds are left after the allowed rounds
pub(super) fn solve(
    mesh: &TriMesh,
    disk: &Disk,
    metric: &Metric,
    border: &[DVec2],
    options: &MapOptions,
    progress: &Progress,
) -> Result<(VertexMap<DVec2>, usize), MapError> {
    let mut rows = mean_value_weights(mesh, disk, metric);
    let solver = RowSolver::analyse(disk, &rows)?;
    let mut round = 0;
    loop {
        progress.check()?;
        progress.report("mean value map", round as f64 / (options.max_rounds + 1) as f64);
        let mut place = start(mesh, disk, border);
        solver.settle(disk, &rows, &mut place)?;
        let folded = folded_faces(mesh, &place);
        let Some(&face) = folded.first() else { return Ok((place, round)) };
        if round == options.max_rounds {
            let advice = "allow more rounds, or cut the tile into smaller ones";
            let (count, method) = (folded.len(), MapMethod::MeanValue);
            return Err(MapError::Folded { face, count, method, rounds: round, advice });
        }
        divide_by_stretch(&mut rows, &vertex_stretch(mesh, metric, &place));
        round += 1;
    }
}

/// Border vertices at their places, all others in the middle.
pub(super) fn start(mesh: &TriMesh, disk: &Disk, border: &[DVec2]) -> VertexMap<DVec2> {
    let middle = border.iter().sum::<DVec2>() / border.len() as f64;
    let mut place = VertexMap::filled(mesh.vertex_count(), middle);
    disk.border.iter().zip(border).for_each(|(&v, &p)| place[v] = p);
    place
}

/// λ_ij = (tan(δ/2) + tan(γ/2)) / |ij| for the angles δ, γ at i beside the edge, then normalised ([Floater2003] (2.1)).
fn mean_value_weights(mesh: &TriMesh, disk: &Disk, metric: &Metric) -> Rows {
    let mut rows = Rows::new(mesh, disk, |h| {
        let right = mesh.rotate_cw(h).map_or(0.0, |r| metric.half_tan[r]);
        (metric.half_tan[h] + right) / metric.length[mesh.edge(h)]
    });
    (0..rows.len()).for_each(|i| normalise(&mut rows, i));
    rows
}

/// Makes the largest weight of a row 1 and none far smaller.
fn normalise(rows: &mut Rows, i: usize) {
    let row = rows.row(i);
    let weight = &mut rows.weight[row];
    let largest = weight.iter().copied().fold(0.0, f64::max);
    weight.iter_mut().for_each(|w| *w = (*w / largest).max(LEAST_WEIGHT));
}

/// Weights for the next round: λ_ij / σ_j ([Yoshizawa2004] §3).
fn divide_by_stretch(rows: &mut Rows, stretch: &VertexMap<f64>) {
    for i in 0..rows.len() {
        for at in rows.row(i) {
            rows.weight[at] /= stretch[rows.neighbour[at]];
        }
        normalise(rows, i);
    }
}

/// Root mean square over a vertex's faces, by area on the surface, of the stretch ([Yoshizawa2004] (4)).
fn vertex_stretch(mesh: &TriMesh, metric: &Metric, place: &VertexMap<DVec2>) -> VertexMap<f64> {
    let mut sums = VertexMap::filled(mesh.vertex_count(), (0.0, 0.0));
    for f in mesh.faces() {
        let area = metric.area(mesh, f);
        let stretched = area * stretch_sq(mesh, metric, place, f);
        for v in mesh.face_vertices(f) {
            sums[v] = (sums[v].0 + area, sums[v].1 + stretched);
        }
    }
    sums.map(|(area, stretched)| (stretched / area).sqrt())
}

/// (Γ² + γ²)/2 of the map of a face from the plane to the surface, kept finite where its place is noise.
fn stretch_sq(mesh: &TriMesh, metric: &Metric, place: &VertexMap<DVec2>, f: FaceId) -> f64 {
    let [a, b, c] = mesh.face_vertices(f).map(|v| place[v]);
    let length_sq = mesh.face_half_edges(f).map(|h| metric.length[mesh.edge(h)].powi(2));
    // Dirichlet energy of the inverse map: Σ cot(flat angle) · |opposite side|² / (4 · flat area).
    let (ab, bc, ca) = (b - a, c - b, a - c);
    let dots = [-(bc.dot(ca)), -(ca.dot(ab)), -(ab.dot(bc))];
    let noise_sq = NOISE * NOISE;
    let energy: f64 = (0..3).map(|k| (dots[k] + noise_sq) * length_sq[k]).sum();
    let doubled = ab.perp_dot(-ca).max(0.0) + noise_sq;
    energy.max(noise_sq * length_sq.iter().sum::<f64>()) / (doubled * doubled)
}
