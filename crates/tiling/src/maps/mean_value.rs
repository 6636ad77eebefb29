//! Fold-free maps to a convex border by mean value coordinates.
//!
//! In: a disk whose border is placed. Out: places of all vertices and the number of times weights were changed.
//! Holds: no face is folded, by the exact test, or there is an error. Weights are always positive, so that the map is
//! an embedding in exact arithmetic ([Floater2003b], [Tutte1963]). In doubles a long finger of the surface shrinks by
//! e^(−k·length), k = 2π/girth, until its places coincide; see [`pull_outwards`] for what is done then.
//! Source: [Floater2003]; that weights are changed and the system solved again until a map is good, [Yoshizawa2004],
//! whose own rule, weights over stretch, was tried: it takes rounds with the square of a finger's length.
//!
//! | paper | here | meaning |
//! |---|---|---|
//! | λ_ij | `Rows::weight` | weight of neighbour j of interior vertex i |

use super::checks::folded_faces;
use super::disk::{Disk, NONE};
use super::error::MapError;
use super::harmonic::{Factor, RowSolver, Rows};
use super::metric::Metric;
use super::{MapMethod, MapOptions};
use quadloom_mesh::{DVec2, Progress, TriMesh, VertexMap};

/// Least weight in a row as a fraction of the largest.
///
/// Degenerate triangles have weights of any size. Larger: obtuse needles lose linear precision. Smaller: places of
/// neighbours differ by less than doubles can tell, and the faces between them have no area.
const LEAST_WEIGHT: f64 = 1e-9;

/// Pull of the first round, over the longest time; and its growth from round to round.
///
/// A finger k·length = 35 long is the first that cannot be told apart, and needs about 80. Larger: maps of such
/// fingers differ more from mean value maps than they must. Smaller: more rounds for long fingers.
const PULL: [f64; 2] = [128.0, 4.0];

/// Places of all vertices, and the number of rounds after the first.
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
    let first = mean_value_weights(mesh, disk, metric);
    let solver = RowSolver::analyse(disk, &first)?;
    let mut rows = first.clone();
    let mut time = None;
    let mut round = 0;
    loop {
        progress.check()?;
        progress.report("mean value map", round as f64 / (options.max_rounds + 1) as f64);
        let mut place = start(mesh, disk, border);
        if rows.len() > 0 {
            let factor = solver.factorize(&rows)?;
            rows.settle(disk, &mut place, |b| factor.solve(b, 2));
            time.get_or_insert_with(|| times_to_border(mesh, disk, metric, &first, &factor));
        }
        let folded = folded_faces(mesh, &place);
        let (Some(&face), Some(time)) = (folded.first(), &time) else { return Ok((place, round)) };
        if round == options.max_rounds {
            let advice = "allow more rounds, or cut the tile into smaller ones";
            let (count, method) = (folded.len(), MapMethod::MeanValue);
            return Err(MapError::Folded { face, count, method, rounds: round, advice });
        }
        rows = pull_outwards(disk, &first, time, PULL[0] * PULL[1].powi(round as i32));
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

/// λ_ij = (tan(δ/2) + tan(γ/2)) / |ij| for the angles δ, γ at i beside the edge [Floater2003].
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

/// Expected time of a diffusion from each vertex to the border: Σ_j λ_ij (t_i − t_j) = Σ_j λ_ij |ij|².
///
/// It grows towards the tip of every finger, and does not shrink exponentially as places do.
fn times_to_border(mesh: &TriMesh, disk: &Disk, metric: &Metric, rows: &Rows, factor: &Factor<'_>) -> VertexMap<f64> {
    let length = |i: usize| mesh.outgoing(disk.interior[i]).map(|h| metric.length[mesh.edge(h)]);
    let step = |i: usize| rows.row(i).zip(length(i)).map(|(at, l)| rows.weight[at] * l * l).sum();
    let mut times: Vec<f64> = (0..rows.len()).map(step).collect();
    factor.solve(&mut times, 1);
    disk.inner.map(|&i| if i == NONE { 0.0 } else { times[i as usize] })
}

/// Weights λ_ij · (1 + κ (t_i − t_j)) where j is nearer to the border than i, for κ = pull / max t.
///
/// On a tube x from its closed end the time has slope 2x, places are r(x)·e^(ikθ), and r'' + 2κx·r' − k²r = 0: r is
/// x^p with p = k²/2κ far from the end, where without pull it is e^(kx). Where edges are long against 1/κx this is the
/// upwind difference, which does not overshoot.
fn pull_outwards(disk: &Disk, first: &Rows, time: &VertexMap<f64>, pull: f64) -> Rows {
    let longest = time.values().iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let mut rows = first.clone();
    for (i, &v) in disk.interior.iter().enumerate() {
        for at in rows.row(i) {
            let outwards = ((time[v] - time[rows.neighbour[at]]) / longest).max(0.0);
            rows.weight[at] *= 1.0 + pull * outwards;
        }
        normalise(&mut rows, i);
    }
    rows
}
