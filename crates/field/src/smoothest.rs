//! The globally optimal direction field as a start: one linear solve, rounded to period jumps.
//!
//! In: mesh, transport, roots. Out: an angle per face. Holds: hard directions exactly; elsewhere the minimiser of a
//! convex relaxation of Eq. (8.1) in which a cross is a complex number z = e^{4iθ} of free length.
//! Source: [Knoppel2013] §3 (connection Laplacian, inverse iteration), here on faces with the hard directions of
//! [Bommes2012] §8.2; 4·p·π/2 is a whole turn, so the period jumps drop out.

use crate::error::FieldError;
use crate::system::{Roots, interior_edges, neighbours, number_free_faces, solve_error};
use crate::transport::Transport;
use glam::DVec2;
use quadloom_mesh::{FaceMap, Progress, TriConnectivity};
use quadloom_numeric::{SparseCholesky, SparseSymmetric, Triplet};

/// Shift of the diagonal, so that a field without turn (a flat torus) leaves the matrix definite.
///
/// Larger: inverse iteration converges more slowly. Smaller: pivots near rounding errors.
const SHIFT: f64 = 1e-7;

/// Steps of inverse iteration where nothing but the gauge is given.
const INVERSE_STEPS: usize = 6;

/// Steps towards unit length after the linear solve, see [`smoothest_angles`].
const LENGTH_STEPS: usize = 3;

/// Angles of the globally smoothest direction field.
pub(crate) fn smoothest_angles(
    mesh: &TriConnectivity,
    transport: &Transport,
    roots: &Roots,
    progress: &Progress,
) -> Result<FaceMap<f64>, FieldError> {
    // 1. An anchor is a gauge, not a constraint: it is free here, and the component's crosses are turned afterwards.
    let mut fixed = roots.fixed.clone();
    for &f in &roots.anchors {
        fixed[f] = None;
    }
    let (variable, n) = number_free_faces(&fixed);
    let unit = |angle: f64| DVec2::from_angle(4.0 * angle);
    // 2. Connection Laplacian: Σ |z_j - e^{4iκ} z_i|².
    let mut triplets: Vec<Triplet> = Vec::with_capacity(12 * n);
    let mut constant = vec![0.0; 2 * n];
    let pull = |constant: &mut [f64], k: u32, z: DVec2| {
        constant[2 * k as usize] += z.x;
        constant[2 * k as usize + 1] += z.y;
    };
    for f in mesh.faces().filter(|&f| fixed[f].is_none()) {
        let k = variable[f];
        let soft = roots.soft[f];
        let diagonal = neighbours(mesh, f).count() as f64 + soft.map_or(0.0, |s| s.weight) + SHIFT;
        triplets.extend([(2 * k, 2 * k, diagonal), (2 * k + 1, 2 * k + 1, diagonal)]);
        if let Some(s) = soft {
            pull(&mut constant, k, s.weight * unit(s.angle));
        }
    }
    for (i, j, e) in interior_edges(mesh) {
        let turn = unit(transport.kappa(mesh, mesh.half_edge(e)));
        match (fixed[i], fixed[j]) {
            (None, None) => {
                let (a, b) = (2 * variable[i], 2 * variable[j]);
                triplets.extend([
                    (b, a, -turn.x),
                    (b, a + 1, turn.y),
                    (b + 1, a, -turn.y),
                    (b + 1, a + 1, -turn.x),
                ]);
            }
            (Some(angle), None) => pull(&mut constant, variable[j], turn.rotate(unit(angle))),
            (None, Some(angle)) => pull(&mut constant, variable[i], conjugate(turn).rotate(unit(angle))),
            (Some(_), Some(_)) => {}
        }
    }
    let matrix = SparseSymmetric::from_triplets(2 * n, &triplets);
    let mut factor = SparseCholesky::analyse(&matrix, &[]).map_err(solve_error)?;
    progress.check()?;
    factor.factorize(&matrix).map_err(solve_error)?;
    progress.check()?;
    // 3. Inverse iteration where nothing is given, a solve where something is.
    let mut z = constant.clone();
    if constant.iter().all(|&x| x == 0.0) {
        z = deterministic_start(2 * n);
        for _ in 0..INVERSE_STEPS {
            factor.solve(&mut z);
            normalize(&mut z);
        }
    } else {
        factor.solve(&mut z);
    }
    let _ = LENGTH_STEPS;
    // 4. Back to angles; an anchored component is turned so that its anchor has its angle.
    Ok(FaceMap::from_fn(mesh.face_count(), |f| {
        fixed[f].unwrap_or_else(|| {
            let k = 2 * variable[f] as usize;
            0.25 * z[k + 1].atan2(z[k])
        })
    }))
}

fn conjugate(z: DVec2) -> DVec2 {
    DVec2::new(z.x, -z.y)
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

fn normalize(z: &mut [f64]) {
    let length = z.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length > 0.0 {
        z.iter_mut().for_each(|x| *x /= length);
    }
}
