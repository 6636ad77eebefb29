//! Sparse Cholesky factorisation A = L·Lᵀ whose symbolic part is kept.
//!
//! In: a [`SparseSymmetric`] and, if wanted, variables to be eliminated last. Out: [`SparseCholesky`].
//! Holds: sequential, so equal input gives equal bytes; a pivot below [`SINGULAR_PIVOT`] of its diagonal
//! is an error, not a huge number.
//!
//! Source: approximate minimum degree and supernodal factorisation as in faer. Variables ordered last
//! make the trailing block of L the Cholesky factor of their Schur complement.

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::llt::factor::LltError;
use faer::sparse::linalg::amd;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, Mat, MatMut, Par, Side};

use crate::sparse::{SparseSymmetric, accumulate};

/// A pivot below this fraction of its diagonal entry means a singular matrix.
///
/// Rounding leaves pivots of about 1e-16 to 1e-14 where zero is meant. Larger: well-posed problems with
/// one pinned vertex (last pivot about 1/n) and strong stiffening are refused. Smaller: garbage of
/// magnitude 1e15 passes for a solution.
pub const SINGULAR_PIVOT: f64 = 1e-13;

/// Why a matrix could not be factorised.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum CholeskyError {
    /// The pivot of this row is not positive.
    #[error("not positive definite at row {row}")]
    NotPositiveDefinite {
        /// Row of the matrix as given.
        row: usize,
    },
    /// The factor exceeds memory or 32-bit indices.
    #[error("the factor is too large")]
    TooLarge,
}

/// Kept symbolic factorisation and the numbers of the last one.
///
/// # Example
/// ```
/// use quadloom_numeric::{SparseCholesky, SparseSymmetric};
/// let a = SparseSymmetric::from_triplets(2, &[(0, 0, 4.0), (0, 1, 2.0), (1, 1, 3.0)]);
/// let mut factor = SparseCholesky::analyse(&a, &[])?;
/// factor.factorize(&a)?;
/// let mut x = [8.0, 8.0];
/// factor.solve(&mut x);
/// assert!((x[0] - 1.0).abs() < 1e-12 && (x[1] - 2.0).abs() < 1e-12);
/// # Ok::<(), quadloom_numeric::CholeskyError>(())
/// ```
#[derive(Debug)]
pub struct SparseCholesky {
    symbolic: SymbolicCholesky<u32>,
    values: Vec<f64>,
    /// Entries of the matrix whose factor `values` is; empty where there is none.
    factorized: Vec<f64>,
    last: usize,
}

impl SparseCholesky {
    /// Orders the rows and finds the pattern of L.
    ///
    /// # Input   `matrix`: its pattern only; `last`: distinct rows to be eliminated after all others, in
    ///   this order
    /// # Errors  [`CholeskyError::TooLarge`]
    /// # Cost    about that of one numeric factorisation of a planar mesh matrix
    pub fn analyse(matrix: &SparseSymmetric, last: &[u32]) -> Result<Self, CholeskyError> {
        let order = elimination_order(matrix, last)?;
        let inverse = invert(&order);
        let permutation = faer::perm::PermRef::new_checked(&order, &inverse, matrix.n());
        let symbolic = factorize_symbolic_cholesky(
            pattern(matrix),
            Side::Upper,
            SymmetricOrdering::Custom(permutation),
            CholeskySymbolicParams::default(),
        )
        .map_err(|_| CholeskyError::TooLarge)?;
        Ok(Self { symbolic, values: Vec::new(), factorized: Vec::new(), last: last.len() })
    }

    /// Computes L for a matrix of the analysed pattern, replacing the last one.
    ///
    /// # Errors  [`CholeskyError::NotPositiveDefinite`] names the row of the first bad pivot
    /// # Cost    that of a comparison where the matrix is the one of the last factorisation
    pub fn factorize(&mut self, matrix: &SparseSymmetric) -> Result<(), CholeskyError> {
        if matrix.n() == 0 || self.factorized == matrix.values() {
            return Ok(());
        }
        self.factorized.clear();
        self.values.resize(self.symbolic.len_val(), 0.0);
        let mut memory = buffer(self.symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default()))?;
        let a = SparseColMatRef::new(pattern(matrix), matrix.values());
        let done = self
            .symbolic
            .factorize_numeric_llt(
                &mut self.values,
                a,
                Side::Upper,
                Default::default(),
                Par::Seq,
                MemStack::new(&mut memory),
                Default::default(),
            )
            .map(|_| ());
        done.map_err(|LltError::NonPositivePivot { index }| CholeskyError::NotPositiveDefinite {
            row: self.row_of_pivot(index.saturating_sub(self.first_pivot_index())),
        })?;
        self.refuse_tiny_pivots(matrix)?;
        self.factorized.extend_from_slice(matrix.values());
        Ok(())
    }

    /// Replaces b by the x with A·x = b.
    ///
    /// # Cost  two passes over L
    pub fn solve(&self, b: &mut [f64]) {
        self.solve_columns(b, 1);
    }

    /// Replaces each column of b, n × `columns` stored column by column, by its solution.
    pub fn solve_columns(&self, b: &mut [f64], columns: usize) {
        let n = self.symbolic.nrows();
        if n == 0 || columns == 0 {
            return;
        }
        let scratch = self.symbolic.solve_in_place_scratch::<f64>(columns, Par::Seq);
        let mut memory = MemBuffer::new(scratch);
        let b = MatMut::from_column_major_slice_mut(b, n, columns);
        LltRef::new(&self.symbolic, &self.values).solve_in_place_with_conj(
            Conj::No,
            b,
            Par::Seq,
            MemStack::new(&mut memory),
        );
    }

    /// Number of entries of L.
    pub fn factor_entries(&self) -> usize {
        self.symbolic.len_val()
    }

    /// Lower Cholesky factor of the Schur complement onto the rows ordered last, in their order.
    pub(crate) fn trailing_block(&self) -> Mat<f64> {
        let k = self.last;
        let first = self.symbolic.nrows() - k;
        let mut block = Mat::zeros(k, k);
        self.for_each_entry(first, |i, j, l| block[(i - first, j - first)] = l);
        block
    }

    /// Visits (i, j, L_ij), i ≥ j ≥ `from`, in permuted indices.
    fn for_each_entry(&self, from: usize, mut visit: impl FnMut(usize, usize, f64)) {
        match self.symbolic.raw() {
            SymbolicCholeskyRaw::Simplicial(l) => {
                for j in from..l.nrows() {
                    for at in l.col_ptr()[j] as usize..l.col_ptr()[j + 1] as usize {
                        visit(l.row_idx()[at] as usize, j, self.values[at]);
                    }
                }
            }
            SymbolicCholeskyRaw::Supernodal(l) => {
                for s in 0..l.n_supernodes() {
                    let (begin, end) = (l.supernode_begin()[s] as usize, l.supernode_end()[s] as usize);
                    let below = l.supernode(s).pattern();
                    let rows = end - begin + below.len();
                    let start = l.col_ptr_for_val()[s] as usize;
                    for j in begin.max(from)..end {
                        let column = &self.values[start + (j - begin) * rows..][..rows];
                        (j..end).for_each(|i| visit(i, j, column[i - begin]));
                        below.iter().zip(&column[end - begin..]).for_each(|(&i, &l)| visit(i as usize, j, l));
                    }
                }
            }
        }
    }

    /// faer counts failing pivots from 1 in simplicial factorisations, from 0 in supernodal ones.
    fn first_pivot_index(&self) -> usize {
        usize::from(matches!(self.symbolic.raw(), SymbolicCholeskyRaw::Simplicial(_)))
    }

    fn row_of_pivot(&self, pivot: usize) -> usize {
        self.symbolic.perm().map_or(pivot, |p| p.arrays().0.get(pivot).map_or(pivot, |&row| row as usize))
    }

    fn refuse_tiny_pivots(&self, matrix: &SparseSymmetric) -> Result<(), CholeskyError> {
        let mut bad = None;
        self.for_each_entry(0, |i, j, l| {
            if i == j && bad.is_none() {
                let row = self.row_of_pivot(j);
                let sound = l * l > SINGULAR_PIVOT * matrix.get(row, row);
                bad = (!sound).then_some(row);
            }
        });
        bad.map_or(Ok(()), |row| Err(CholeskyError::NotPositiveDefinite { row }))
    }
}

/// Approximate minimum degree on the rows not in `last`, then `last`.
fn elimination_order(matrix: &SparseSymmetric, last: &[u32]) -> Result<Vec<u32>, CholeskyError> {
    let mut is_last = vec![false; matrix.n()];
    last.iter().for_each(|&i| is_last[i as usize] = true);
    let first: Vec<u32> = (0..matrix.n() as u32).filter(|&i| !is_last[i as usize]).collect();
    let mut order: Vec<u32> = minimum_degree(matrix, &first)?.iter().map(|&at| first[at as usize]).collect();
    order.extend_from_slice(last);
    Ok(order)
}

/// Approximate minimum degree ordering of the sub-matrix on `rows` (ascending), as positions in `rows`.
fn minimum_degree(matrix: &SparseSymmetric, rows: &[u32]) -> Result<Vec<u32>, CholeskyError> {
    const OUTSIDE: u32 = u32::MAX;
    if rows.is_empty() {
        return Ok(Vec::new());
    }
    let mut local = vec![OUTSIDE; matrix.n()];
    rows.iter().enumerate().for_each(|(at, &i)| local[i as usize] = at as u32);
    let mut start = vec![0u32; rows.len() + 1];
    let mut columns = Vec::with_capacity(matrix.stored());
    for (at, &i) in rows.iter().enumerate() {
        let inside = matrix.row(i as usize).0.iter().map(|&j| local[j as usize]).filter(|&j| j != OUTSIDE);
        let before = columns.len();
        columns.extend(inside);
        start[at + 1] = (columns.len() - before) as u32;
    }
    accumulate(&mut start);
    let n = rows.len();
    let sub = SymbolicSparseColMatRef::new_checked(n, n, &start, None, &columns);
    let (mut order, mut inverse) = (vec![0u32; n], vec![0u32; n]);
    let mut memory = buffer(amd::order_maybe_unsorted_scratch::<u32>(n, columns.len()))?;
    amd::order_maybe_unsorted(&mut order, &mut inverse, sub, Default::default(), MemStack::new(&mut memory))
        .map_err(|_| CholeskyError::TooLarge)?;
    Ok(order)
}

fn invert(order: &[u32]) -> Vec<u32> {
    let mut inverse = vec![0; order.len()];
    order.iter().enumerate().for_each(|(at, &i)| inverse[i as usize] = at as u32);
    inverse
}

fn pattern(matrix: &SparseSymmetric) -> SymbolicSparseColMatRef<'_, u32> {
    let n = matrix.n();
    SymbolicSparseColMatRef::new_checked(n, n, matrix.row_starts(), None, matrix.columns())
}

fn buffer(size: StackReq) -> Result<MemBuffer, CholeskyError> {
    MemBuffer::try_new(size).map_err(|_| CholeskyError::TooLarge)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sparse::Triplet;

    /// Five-point Laplacian of an m × m grid plus `shift` on the diagonal.
    fn grid(m: u32, shift: f64) -> SparseSymmetric {
        let mut triplets: Vec<Triplet> = Vec::new();
        for i in 0..m {
            for j in 0..m {
                let me = i * m + j;
                triplets.push((me, me, shift));
                for other in [(i + 1 < m).then_some(me + m), (j + 1 < m).then_some(me + 1)].into_iter().flatten() {
                    triplets.extend([(me, me, 1.0), (other, other, 1.0), (me, other, -1.0)]);
                }
            }
        }
        SparseSymmetric::from_triplets((m * m) as usize, &triplets)
    }

    fn residual(a: &SparseSymmetric, x: &[f64], b: &[f64]) -> f64 {
        a.multiply(x).iter().zip(b).map(|(ax, b)| (ax - b).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn solves_with_any_rows_last_and_again_with_new_values() {
        for m in [1, 2, 7, 60] {
            let n = (m * m) as usize;
            let scattered: Vec<u32> = (0..n as u32).filter(|i| i % 7 == 3).collect();
            for last in [Vec::new(), scattered, (0..n as u32 / 2).rev().collect()] {
                let mut factor = SparseCholesky::analyse(&grid(m, 0.1), &last).unwrap();
                for shift in [0.1, 3.0] {
                    let a = grid(m, shift);
                    factor.factorize(&a).unwrap();
                    let b: Vec<f64> = (0..n).map(|i| (i as f64 * 0.37).sin()).collect();
                    let mut x = [b.clone(), b.iter().map(|v| 2.0 * v).collect()].concat();
                    factor.solve_columns(&mut x, 2);
                    assert!(residual(&a, &x[..n], &b) < 1e-11);
                    assert!((x[n] - 2.0 * x[0]).abs() < 1e-11);
                }
            }
        }
    }

    #[test]
    fn trailing_block_is_the_factor_of_the_schur_complement() {
        let a = grid(12, 0.3);
        let last: Vec<u32> = vec![3, 70, 71, 9, 140];
        let mut factor = SparseCholesky::analyse(&a, &last).unwrap();
        factor.factorize(&a).unwrap();
        let l = factor.trailing_block();
        // (A⁻¹) restricted to `last` is the inverse of L·Lᵀ.
        for (column, &j) in last.iter().enumerate() {
            let mut unit = vec![0.0; a.n()];
            unit[j as usize] = 1.0;
            factor.solve(&mut unit);
            let inverse: Vec<f64> = last.iter().map(|&i| unit[i as usize]).collect();
            for row in 0..last.len() {
                let product: f64 = (0..last.len())
                    .map(|mid| (0..last.len()).map(|t| l[(row, t)] * l[(mid, t)]).sum::<f64>() * inverse[mid])
                    .sum();
                assert!((product - f64::from(row == column)).abs() < 1e-10);
            }
        }
    }

    #[test]
    fn singular_and_indefinite_matrices_are_refused() {
        for m in [3, 40] {
            let a = grid(m, 0.0);
            let mut factor = SparseCholesky::analyse(&a, &[]).unwrap();
            assert!(matches!(factor.factorize(&a), Err(CholeskyError::NotPositiveDefinite { .. })));
        }
        let a = SparseSymmetric::from_triplets(3, &[(0, 0, 1.0), (1, 1, -1.0), (2, 2, 1.0)]);
        let mut factor = SparseCholesky::analyse(&a, &[]).unwrap();
        assert_eq!(factor.factorize(&a), Err(CholeskyError::NotPositiveDefinite { row: 1 }));
    }

    #[test]
    fn a_factor_of_nothing_solves_nothing() {
        let a = SparseSymmetric::from_triplets(0, &[]);
        let mut factor = SparseCholesky::analyse(&a, &[]).unwrap();
        factor.factorize(&a).unwrap();
        factor.solve(&mut []);
    }
}
