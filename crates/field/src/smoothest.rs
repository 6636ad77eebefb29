//! The globally optimal direction field as a start: one sparse solve, rounded to period jumps.
//!
//! In: mesh, transport, roots. Out: an angle per face. Holds: hard directions exactly; elsewhere the minimiser of a
//! convex relaxation of Eq. (8.1) in which a cross is a complex number z = e^{4iθ} of free length.
//! Source: [Knoppel2013] §3 (connection Laplacian, inverse iteration), here on faces with the hard directions of
//! [Bommes2012] §8.2; 4·p·π/2 is a whole turn, so the period jumps drop out.

use crate::error::FieldError;
use crate::system::{Roots, interior_edges, neighbours, number_free_faces, solve_error};
use crate::transport::Transport;
use glam::DVec2;
use quadloom_mesh::topology::{Components, components};
use quadloom_mesh::{FaceMap, Progress, TriConnectivity};
use quadloom_numeric::{SparseCholesky, SparseSymmetric, Triplet};

/// Shift of the diagonal, so that a field without turn (a flat torus) leaves the matrix definite.
///
/// Larger: inverse iteration converges more slowly. Smaller: pivots near rounding errors.
const SHIFT: f64 = 1e-7;

/// Steps of inverse iteration where no direction is given. From a start without pattern six leave the lowest
/// eigenvalue's field on every test shape; more only cost time, since the period jumps are re-optimised anyway.
const INVERSE_STEPS: usize = 6;

/// Angles of the globally smoothest direction field, radians.
///
/// # Cost       one factorisation of a matrix of two rows per free face
pub(crate) fn smoothest_angles(
    mesh: &TriConnectivity,
    transport: &Transport,
    roots: &Roots,
    progress: &Progress,
) -> Result<FaceMap<f64>, FieldError> {
    // 1. An anchor is a gauge, not a constraint: it is free here.
    let mut fixed = roots.fixed.clone();
    for &f in &roots.anchors {
        fixed[f] = None;
    }
    let (variable, n) = number_free_faces(&fixed);
    let (matrix, constant) = connection_laplacian(mesh, transport, roots, &fixed, &variable, n);
    let mut factor = SparseCholesky::analyse(&matrix, &[]).map_err(solve_error)?;
    progress.check()?;
    factor.factorize(&matrix).map_err(solve_error)?;
    progress.check()?;
    // 2. A solve where directions are given, inverse iteration where none is.
    let mut z = constant;
    factor.solve(&mut z);
    if !roots.anchors.is_empty() {
        let parts = components(mesh);
        let part_of = FaceMap::from_fn(mesh.face_count(), |f| parts.of_face[f]);
        let mut loose = vec![false; parts.count];
        roots.anchors.iter().for_each(|&f| loose[part_of[f] as usize] = true);
        let eigenvector = inverse_iteration(mesh, &factor, &parts, &variable, &fixed, n);
        for f in mesh.faces().filter(|&f| fixed[f].is_none() && loose[part_of[f] as usize]) {
            let k = 2 * variable[f] as usize;
            z[k..k + 2].copy_from_slice(&eigenvector[k..k + 2]);
        }
    }
    // 3. Back to angles.
    Ok(FaceMap::from_fn(mesh.face_count(), |f| {
        fixed[f].unwrap_or_else(|| {
            let k = 2 * variable[f] as usize;
            0.25 * z[k + 1].atan2(z[k])
        })
    }))
}

/// Matrix and right-hand side of Σ |z_j - e^{4iκ} z_i|² + Σ w·|z_f - e^{4iα}|² over the free faces.
fn connection_laplacian(
    mesh: &TriConnectivity,
    transport: &Transport,
    roots: &Roots,
    fixed: &FaceMap<Option<f64>>,
    variable: &FaceMap<u32>,
    n: usize,
) -> (SparseSymmetric, Vec<f64>) {
    let unit = |angle: f64| DVec2::from_angle(4.0 * angle);
    let mut triplets: Vec<Triplet> = Vec::with_capacity(8 * n);
    let mut constant = vec![0.0; 2 * n];
    let mut pull = |k: u32, z: DVec2| {
        constant[2 * k as usize] += z.x;
        constant[2 * k as usize + 1] += z.y;
    };
    for f in mesh.faces().filter(|&f| fixed[f].is_none()) {
        let (k, soft) = (variable[f], roots.soft[f]);
        let diagonal = neighbours(mesh, f).count() as f64 + soft.map_or(0.0, |s| s.weight) + SHIFT;
        triplets.extend([(2 * k, 2 * k, diagonal), (2 * k + 1, 2 * k + 1, diagonal)]);
        if let Some(s) = soft {
            pull(k, s.weight * unit(s.angle));
        }
    }
    for (i, j, e) in interior_edges(mesh) {
        let turn = unit(transport.kappa(mesh, mesh.half_edge(e)));
        match (fixed[i], fixed[j]) {
            (None, None) => {
                let (a, b) = (2 * variable[i], 2 * variable[j]);
                let (re, im) = (turn.x, turn.y);
                triplets.extend([(b, a, -re), (b, a + 1, im), (b + 1, a, -im), (b + 1, a + 1, -re)]);
            }
            (Some(angle), None) => pull(variable[j], turn.rotate(unit(angle))),
            (None, Some(angle)) => pull(variable[i], DVec2::new(turn.x, -turn.y).rotate(unit(angle))),
            (Some(_), Some(_)) => {}
        }
    }
    (SparseSymmetric::from_triplets(2 * n, &triplets), constant)
}

/// The lowest eigenvector of every component, each of unit length.
fn inverse_iteration(
    mesh: &TriConnectivity,
    factor: &SparseCholesky,
    parts: &Components,
    variable: &FaceMap<u32>,
    fixed: &FaceMap<Option<f64>>,
    n: usize,
) -> Vec<f64> {
    let mut part_of_variable = vec![0usize; n];
    for f in mesh.faces().filter(|&f| fixed[f].is_none()) {
        part_of_variable[variable[f] as usize] = parts.of_face[f] as usize;
    }
    let mut z = deterministic_start(2 * n);
    for _ in 0..INVERSE_STEPS {
        factor.solve(&mut z);
        let mut square = vec![0.0; parts.count];
        z.iter().enumerate().for_each(|(k, x)| square[part_of_variable[k / 2]] += x * x);
        let scale: Vec<f64> = square.iter().map(|&s| if s > 0.0 { 1.0 / s.sqrt() } else { 0.0 }).collect();
        z.iter_mut().enumerate().for_each(|(k, x)| *x *= scale[part_of_variable[k / 2]]);
    }
    z
}

/// Numbers in -1..1 without pattern, the same in every run (a linear congruential sequence).
fn deterministic_start(n: usize) -> Vec<f64> {
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    (0..n)
        .map(|_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        })
        .collect()
}
