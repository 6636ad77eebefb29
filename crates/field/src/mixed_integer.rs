//! The mixed-integer formulation: angles and period jumps of Eq. (8.1) in one quadratic problem.
//!
//! In: mesh, transport, roots, constraints. Out: period jumps by rounding or branch and bound.
//! Holds: prescribed indices and index sums exactly. Source: [Bommes2012] §8.2, reducing the search space and
//! mixed-integer formulation; §8.6, irregular vertices.
//!
//! | paper | here |
//! |---|---|
//! | θ_i, i free | variables 0..free faces |
//! | p_ij, not fixed | variables from there on |
//! | Dijkstra forest, p = 0 | [`tree_edges`] |

use crate::constraints::FieldConstraints;
use crate::error::FieldError;
use crate::system::{Roots, interior_edges, number_free_faces};
use crate::transport::Transport;
use quadloom_mesh::topology::dual_forest;
use quadloom_mesh::{EdgeId, EdgeMap, FaceId, Progress, TriConnectivity, VertexId};
use quadloom_numeric::{
    Constraints, MixedIntegerProblem, Quadratic, Rounding, SolveError, SolveOptions, SolveReport, solve,
};
use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};

/// Period jumps found by the mixed-integer solver, with its report.
///
/// # Errors     [`FieldError::Unsatisfiable`] where prescribed indices exclude each other
/// # Cost       see [`Rounding`]
pub(crate) fn mixed_integer_jumps(
    mesh: &TriConnectivity,
    transport: &Transport,
    length: &EdgeMap<f64>,
    roots: &Roots,
    constraints: &FieldConstraints,
    rounding: Rounding,
    progress: &Progress,
) -> Result<(EdgeMap<i32>, SolveReport), FieldError> {
    let (problem, unknowns) = assemble(mesh, transport, length, roots, constraints);
    let cancelled = || progress.cancelled();
    let options = SolveOptions { rounding, cancelled: Some(&cancelled), ..Default::default() };
    let solution = solve(&problem, &options).map_err(|e| explain(e, constraints, progress))?;
    let jumps = EdgeMap::from_fn(mesh.edge_count(), |e| match unknowns.jump[e] {
        Jump::Fixed(p) => p,
        Jump::Unknown(k) => solution.x[k].round() as i32,
    });
    Ok((jumps, solution.report))
}

/// A period jump: known in advance, or a variable.
#[derive(Clone, Copy, Debug)]
enum Jump {
    Fixed(i32),
    Unknown(usize),
}

struct Unknowns {
    jump: EdgeMap<Jump>,
}

/// Energy (8.1) in the free angles and jumps, and the rows of the prescribed index sums.
fn assemble(
    mesh: &TriConnectivity,
    transport: &Transport,
    length: &EdgeMap<f64>,
    roots: &Roots,
    constraints: &FieldConstraints,
) -> (MixedIntegerProblem, Unknowns) {
    let (variable, free) = number_free_faces(&roots.fixed);
    // 1. Jumps that are known: tree edges, and edges between fixed faces.
    let fixed_jumps = known_jumps(mesh, transport, length, roots, constraints);
    let mut count = free;
    let jump = fixed_jumps.map(|known| match known {
        Some(p) => Jump::Fixed(*p),
        None => {
            count += 1;
            Jump::Unknown(count - 1)
        }
    });
    // 2. Energy: (θ_i + κ + π/2·p - θ_j)² per interior edge.
    let mut quadratic = Quadratic::new(count);
    for (i, j, e) in interior_edges(mesh) {
        let mut target = -transport.kappa(mesh, mesh.half_edge(e));
        let mut terms = [(0, 0.0); 3];
        let mut used = 0;
        let mut term = |k: usize, c: f64| {
            terms[used] = (k, c);
            used += 1;
        };
        for (f, sign) in [(i, 1.0), (j, -1.0)] {
            match roots.fixed[f] {
                Some(angle) => target -= sign * angle,
                None => term(variable[f] as usize, sign),
            }
        }
        match jump[e] {
            Jump::Fixed(p) => target -= FRAC_PI_2 * f64::from(p),
            Jump::Unknown(k) => term(k, FRAC_PI_2),
        }
        quadratic.add_square(&terms[..used], target, 1.0);
    }
    for (f, soft) in roots.soft.iter() {
        if let Some(s) = soft {
            quadratic.add_square(&[(variable[f] as usize, 1.0)], s.angle, s.weight);
        }
    }
    // 3. Index sums: Σ_v (4·I_0(v) - Σp) = q.
    let mut rows = Constraints::new();
    for (label, (list, quarters)) in constraints.index_sums().enumerate() {
        let (terms, rhs) = index_row(mesh, transport, &jump, list, quarters);
        rows.add(&terms, rhs, label);
    }
    let problem = MixedIntegerProblem { quadratic, constraints: rows, integers: (free..count).collect() };
    (problem, Unknowns { jump })
}

/// The row Σ_v Σp = Σ_v 4·I_0(v) - q over the unknown jumps, each of them once.
fn index_row(
    mesh: &TriConnectivity,
    transport: &Transport,
    jump: &EdgeMap<Jump>,
    list: &[VertexId],
    quarters: i32,
) -> (Vec<(usize, f64)>, f64) {
    let mut coefficients = std::collections::BTreeMap::new();
    let mut rhs = -quarters;
    for &v in list {
        rhs += transport.base_index(v);
        for h in transport.crossings(mesh, v) {
            let e = mesh.edge(h);
            let sign = if mesh.half_edge(e) == h { 1 } else { -1 };
            match jump[e] {
                Jump::Fixed(p) => rhs -= sign * p,
                Jump::Unknown(k) => *coefficients.entry(k).or_insert(0) += sign,
            }
        }
    }
    let terms = coefficients.into_iter().filter(|&(_, c)| c != 0).map(|(k, c)| (k, f64::from(c))).collect();
    (terms, f64::from(rhs))
}

/// Jumps that may be fixed without changing the minimum: 0 on the Dijkstra forest of the roots, the nearest one
/// between two fixed faces (unless an index prescription needs it), 0 on the boundary.
fn known_jumps(
    mesh: &TriConnectivity,
    transport: &Transport,
    length: &EdgeMap<f64>,
    roots: &Roots,
    constraints: &FieldConstraints,
) -> EdgeMap<Option<i32>> {
    let mut known = EdgeMap::filled(mesh.edge_count(), None);
    for e in mesh.edges().filter(|&e| mesh.is_boundary_edge(e)) {
        known[e] = Some(0);
    }
    for e in tree_edges(mesh, length, roots) {
        known[e] = Some(0);
    }
    let prescribed: std::collections::BTreeSet<VertexId> =
        constraints.index_sums().flat_map(|(list, _)| list.iter().copied()).collect();
    for (i, j, e) in interior_edges(mesh) {
        if let (Some(a), Some(b)) = (roots.fixed[i], roots.fixed[j]) {
            let nearest = ((b - a - transport.kappa(mesh, mesh.half_edge(e))) * FRAC_2_PI).round() as i32;
            let wanted = mesh.ends(e).iter().any(|v| prescribed.contains(v));
            known[e] = if wanted { None } else { Some(nearest) };
        }
    }
    known
}

/// Edges between parent and child in the shortest-path forest that grows from the roots ([Bommes2012] Figure 8.4).
fn tree_edges(mesh: &TriConnectivity, length: &EdgeMap<f64>, roots: &Roots) -> Vec<EdgeId> {
    let sources: Vec<FaceId> = mesh.faces().filter(|&f| roots.is_root(f)).collect();
    let across = EdgeMap::from_fn(mesh.edge_count(), |e| {
        let (i, j) = mesh.edge_faces(e);
        centre_to_side(mesh, length, i, e) + j.map_or(0.0, |j| centre_to_side(mesh, length, j, e))
    });
    let forest = dual_forest(mesh, &across, &sources);
    forest.parent.values().iter().flatten().map(|&h| mesh.edge(h)).collect()
}

/// Distance from a face's centroid to the middle of one of its sides: a third of the median, from lengths alone.
fn centre_to_side(mesh: &TriConnectivity, length: &EdgeMap<f64>, f: FaceId, side: EdgeId) -> f64 {
    let squares = mesh.face_half_edges(f).map(|h| length[mesh.edge(h)].powi(2));
    let sum: f64 = squares.iter().sum();
    let c = length[side].powi(2);
    (2.0 * (sum - c) - c).max(0.0).sqrt() / 6.0
}

/// The solver's error in terms of the prescriptions.
fn explain(error: SolveError, constraints: &FieldConstraints, progress: &Progress) -> FieldError {
    match error {
        SolveError::Contradiction { rows, .. } | SolveError::NoIntegerSolution { rows, .. } => {
            let sums: Vec<(&[VertexId], i32)> = constraints.index_sums().collect();
            let describe = |&row: &usize| match sums.get(row) {
                Some(([v], q)) => format!("index {q}/4 at vertex {v}"),
                Some((list, q)) => format!("index sum {q}/4 over {} vertices", list.len()),
                None => format!("row {row}"),
            };
            let reason = rows.iter().take(4).map(describe).collect::<Vec<_>>().join(", ");
            let more = if rows.len() > 4 { format!(" and {} more", rows.len() - 4) } else { String::new() };
            FieldError::Unsatisfiable { reason: format!("{reason}{more} exclude each other") }
        }
        SolveError::Cancelled => match progress.check() {
            Err(cancelled) => FieldError::Cancelled(cancelled),
            Ok(()) => FieldError::Solve(SolveError::Cancelled),
        },
        other => FieldError::Solve(other),
    }
}
