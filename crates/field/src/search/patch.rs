//! A few faces around an edge whose angles answer a change of its period jump.
//!
//! In: a [`SmoothnessSystem`] and an edge. Out: [`Patch`], dense and factorised.
//! Holds: energies with only these angles free are upper bounds of the true ones. Source: [Bommes2012] Eq. (8.1).

use crate::system::{SmoothnessSystem, neighbours};
use quadloom_mesh::{EdgeId, FaceId, TriConnectivity};

/// Faces of the patch on which the cost of a single move is computed.
///
/// With free angles only there, Q comes out too large by a few per cent (the dipole's energy outside the patch), so
/// that every accepted move still lowers the true energy. Larger: nearer to the true cost, cubic time.
const PATCH_FACES: usize = 40;

/// Normal equations of Eq. (8.1) on a few free faces around an edge, all other angles fixed.
pub(super) struct Patch {
    /// The faces, nearest first.
    pub faces: Vec<FaceId>,
    /// Lower Cholesky factor, row by row.
    factor: Vec<f64>,
}

impl Patch {
    /// The free faces nearest to an edge, breadth first.
    pub fn around(mesh: &TriConnectivity, system: &SmoothnessSystem, e: EdgeId) -> Self {
        let (i, j) = mesh.edge_faces(e);
        let mut faces: Vec<FaceId> = [Some(i), j].into_iter().flatten().filter(|&f| system.is_free(f)).collect();
        let mut at = 0;
        while at < faces.len() && faces.len() < PATCH_FACES {
            for g in neighbours(mesh, faces[at]) {
                if system.is_free(g) && !faces.contains(&g) {
                    faces.push(g);
                }
            }
            at += 1;
        }
        let n = faces.len();
        let mut factor = vec![0.0; n * n];
        for (row, &f) in faces.iter().enumerate() {
            factor[row * n + row] = system.soft_pull(f, 0.0).0;
            for g in neighbours(mesh, f) {
                factor[row * n + row] += 1.0;
                if let Some(column) = faces.iter().position(|&other| other == g) {
                    factor[row * n + column] -= 1.0;
                }
            }
        }
        cholesky(&mut factor, n);
        Self { faces, factor }
    }

    /// Replaces the right-hand side by the angles' response.
    pub fn solve(&self, x: &mut [f64]) {
        let (n, l) = (x.len(), &self.factor);
        for i in 0..n {
            let dot: f64 = (0..i).map(|k| l[i * n + k] * x[k]).sum();
            x[i] = (x[i] - dot) / l[i * n + i];
        }
        for i in (0..n).rev() {
            let dot: f64 = (i + 1..n).map(|k| l[k * n + i] * x[k]).sum();
            x[i] = (x[i] - dot) / l[i * n + i];
        }
    }
}

/// Lower Cholesky factor of a small positive definite matrix, in place; the upper triangle is not looked at.
fn cholesky(matrix: &mut [f64], n: usize) {
    for j in 0..n {
        for i in j..n {
            let dot: f64 = (0..j).map(|k| matrix[i * n + k] * matrix[j * n + k]).sum();
            let value = matrix[i * n + j] - dot;
            // A closed component that the patch swallows whole leaves a zero pivot: its gauge.
            matrix[i * n + j] = if i == j { value.max(1e-9).sqrt() } else { value / matrix[j * n + j] };
        }
    }
}
