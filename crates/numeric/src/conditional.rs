//! The integers' own energy: what is left once all continuous variables are at their optimum.
//!
//! In: the Schur complement S = L·Lᵀ onto the integers and their relaxed values z. Out:
//! [`Conditional`], the relaxed values given any sequence of fixings, each exact.
//! Holds: fixing z_j = v moves the others by G_:j/G_jj·(v − z_j), where G is S⁻¹ conditioned on what is
//! fixed, and costs ½(v − z_j)²/G_jj of energy.
//!
//! Source: [Bommes2012] §5.2.2 asks for the re-solved relaxation after each rounding; here it is read off
//! a Cholesky factorisation of S⁻¹ whose pivots are chosen by the rounding, column by column as needed.

use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::{Accum, Mat, Par};

/// Relaxed integers under fixings that can be undone.
#[derive(Debug, Clone)]
pub(crate) struct Conditional {
    k: usize,
    /// S⁻¹, row by row; symmetric.
    inverse: Vec<f64>,
    /// Rows of the partial factor W with G = S⁻¹ − W·Wᵀ; row i holds k places, `fixings` of them in use.
    partial: Vec<f64>,
    fixings: usize,
    z: Vec<f64>,
    /// Diagonal of G.
    variance: Vec<f64>,
    free: Vec<bool>,
}

impl Conditional {
    /// # Input  `factor`: lower Cholesky factor of S; `z`: the relaxed integers
    /// # Cost   k³ for k integers, 2·k² numbers of memory
    pub fn new(factor: &Mat<f64>, z: Vec<f64>) -> Self {
        let k = z.len();
        let inverse = inverse_from_factor(factor);
        let variance = (0..k).map(|i| inverse[i * k + i]).collect();
        Self { k, inverse, partial: vec![0.0; k * k], fixings: 0, z, variance, free: vec![true; k] }
    }

    /// Number of integers, fixed or not.
    pub fn len(&self) -> usize {
        self.k
    }

    /// Relaxed value of integer `i` given the fixings; the value itself where fixed.
    pub fn z(&self, i: usize) -> f64 {
        self.z[i]
    }

    /// The integers not yet fixed, ascending.
    pub fn free(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.k).filter(|&i| self.free[i])
    }

    /// By how much the energy rises if integer `i` is fixed at `value`.
    pub fn cost(&self, i: usize, value: f64) -> f64 {
        0.5 * (value - self.z[i]).powi(2) / self.variance[i]
    }

    /// Energy per squared unit of deviation of integer `i`.
    pub fn curvature(&self, i: usize) -> f64 {
        0.5 / self.variance[i]
    }

    /// Fixes integer `j` and moves the others to their new optimum.
    ///
    /// # Cost  k·(number of fixings so far)
    pub fn fix(&mut self, j: usize, value: f64) {
        let (k, used) = (self.k, self.fixings);
        let pivot = self.variance[j];
        let (root, shift) = (pivot.sqrt(), (value - self.z[j]) / pivot);
        self.free[j] = false;
        let row_j = self.partial[j * k..j * k + used].to_vec();
        for i in 0..k {
            if !self.free[i] {
                continue;
            }
            let row_i = &mut self.partial[i * k..i * k + used + 1];
            let covariance = self.inverse[j * k + i] - dot(&row_i[..used], &row_j);
            let w = covariance / root;
            row_i[used] = w;
            self.z[i] += covariance * shift;
            self.variance[i] -= w * w;
        }
        self.z[j] = value;
        self.fixings += 1;
    }

    /// What [`Self::undo`] needs to take back the next fixing.
    pub fn save(&self) -> Saved {
        Saved { z: self.z.clone(), variance: self.variance.clone(), fixings: self.fixings }
    }

    /// Takes back the fixing of integer `j` made after `saved`.
    pub fn undo(&mut self, j: usize, saved: Saved) {
        self.z = saved.z;
        self.variance = saved.variance;
        self.fixings = saved.fixings;
        self.free[j] = true;
    }
}

/// State before a fixing.
#[derive(Debug, Clone)]
pub(crate) struct Saved {
    z: Vec<f64>,
    variance: Vec<f64>,
    fixings: usize,
}

/// (L·Lᵀ)⁻¹ = L⁻ᵀ·L⁻¹, only one triangle of which is computed.
pub(crate) fn inverse_from_factor(factor: &Mat<f64>) -> Vec<f64> {
    let k = factor.nrows();
    let mut inverse_factor = Mat::<f64>::zeros(k, k);
    faer::linalg::triangular_inverse::invert_lower_triangular(inverse_factor.as_mut(), factor.as_ref(), Par::Seq);
    let mut product = Mat::<f64>::zeros(k, k);
    matmul(
        product.as_mut(),
        BlockStructure::TriangularLower,
        Accum::Replace,
        inverse_factor.transpose(),
        BlockStructure::TriangularUpper,
        inverse_factor.as_ref(),
        BlockStructure::TriangularLower,
        1.0,
        Par::Seq,
    );
    let mut inverse = vec![0.0; k * k];
    for j in 0..k {
        for i in j..k {
            inverse[i * k + j] = product[(i, j)];
            inverse[j * k + i] = product[(i, j)];
        }
    }
    inverse
}

/// Eight partial sums in fixed order: vectorises, and gives the same bytes everywhere.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (chunks_a, chunks_b) = (a.chunks_exact(8), b.chunks_exact(8));
    let tail: f64 = chunks_a.remainder().iter().zip(chunks_b.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in chunks_a.zip(chunks_b) {
        for lane in 0..8 {
            sums[lane] += x[lane] * y[lane];
        }
    }
    sums.iter().sum::<f64>() + tail
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the definition: minimise ½(z − z⁰)ᵀS(z − z⁰) with some z fixed, by Gauss on the rest.
    fn reference(s: &[Vec<f64>], z0: &[f64], fixed: &[(usize, f64)]) -> Vec<f64> {
        let k = z0.len();
        let given = |i: usize| fixed.iter().find(|f| f.0 == i).map(|f| f.1);
        let free: Vec<usize> = (0..k).filter(|&i| given(i).is_none()).collect();
        let mut rows: Vec<Vec<f64>> = free
            .iter()
            .map(|&i| {
                let rhs: f64 = fixed.iter().map(|&(j, v)| -s[i][j] * (v - z0[j])).sum();
                free.iter().map(|&j| s[i][j]).chain([rhs]).collect()
            })
            .collect();
        let m = free.len();
        for p in 0..m {
            for i in 0..m {
                if i != p {
                    let f = rows[i][p] / rows[p][p];
                    (0..=m).for_each(|c| rows[i][c] -= f * rows[p][c]);
                }
            }
        }
        let mut z: Vec<f64> = (0..k).map(|i| given(i).unwrap_or(0.0)).collect();
        free.iter().enumerate().for_each(|(at, &i)| z[i] = z0[i] + rows[at][m] / rows[at][at]);
        z
    }

    #[test]
    fn fixings_follow_the_definition_and_can_be_undone() {
        let k = 11;
        let factor = Mat::from_fn(k, k, |i, j| {
            if i == j {
                1.0 + 0.1 * i as f64
            } else if i > j {
                ((3 * i + 7 * j) as f64).sin() * 0.4
            } else {
                0.0
            }
        });
        let s: Vec<Vec<f64>> =
            (0..k).map(|i| (0..k).map(|j| (0..k).map(|t| factor[(i, t)] * factor[(j, t)]).sum()).collect()).collect();
        let z0: Vec<f64> = (0..k).map(|i| (i as f64 * 1.7).cos() * 3.0).collect();
        let mut conditional = Conditional::new(&factor, z0.clone());
        let mut fixed = Vec::new();
        for (j, value) in [(4, 1.0), (0, -2.0), (10, 3.0), (5, 0.0)] {
            let saved = conditional.save();
            conditional.fix(if j == 5 { 6 } else { 7 }, 9.0);
            conditional.undo(if j == 5 { 6 } else { 7 }, saved);
            conditional.fix(j, value);
            fixed.push((j, value));
            for (i, expected) in reference(&s, &z0, &fixed).iter().enumerate() {
                assert!((conditional.z(i) - expected).abs() < 1e-9, "integer {i} after {fixed:?}");
            }
        }
    }
}
