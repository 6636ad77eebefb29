//! What can go wrong in a solve, with the rows and variables concerned.
//!
//! In: nothing. Out: [`SolveError`]. Holds: rows are named by the caller's labels, variables by the
//! caller's indices.

use crate::cholesky::CholeskyError;

/// Why a problem could not be solved.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SolveError {
    /// A combination of these rows reads 0 = residual.
    #[error("constraints {rows:?} contradict each other: together they read 0 = {residual:e}")]
    Contradiction {
        /// Labels of the rows in the combination, sorted, without repeats.
        rows: Vec<usize>,
        /// What zero would have to equal.
        residual: f64,
    },
    /// A combination of these rows holds integer variables only, and no integers satisfy it.
    #[error("constraints {rows:?} have no integer solution: the divisor {divisor} does not divide {rhs}")]
    NoIntegerSolution {
        /// Labels of the rows in the combination, sorted, without repeats.
        rows: Vec<usize>,
        /// Greatest common divisor of the coefficients.
        divisor: f64,
        /// Right-hand side of the combined row.
        rhs: f64,
    },
    /// A combination of these rows holds integer variables only, with coefficients of irrational ratio.
    #[error("constraints {rows:?} tie integer variables by coefficients that are no multiples of a common unit")]
    IncommensurableRow {
        /// Labels of the rows in the combination, sorted, without repeats.
        rows: Vec<usize>,
    },
    /// The energy does not determine this variable: the reduced matrix is singular or indefinite.
    #[error("the energy is not positive definite: variable {variable} is not determined")]
    NotPositiveDefinite {
        /// A variable of the offending pivot; an auxiliary one, see [`crate::Elimination`], counts from `n` on.
        variable: usize,
    },
    /// A variable index is not below the number of variables.
    #[error("variable {variable} is out of range: there are {n}")]
    VariableOutOfRange {
        /// The index given.
        variable: usize,
        /// Number of variables.
        n: usize,
    },
    /// A coefficient or right-hand side is not finite.
    #[error("a coefficient of {place} is not finite")]
    NotFinite {
        /// Where: "the energy", "constraint 12" or "the fixed values".
        place: String,
    },
    /// An integer variable came out between integers: its rows hold coefficients too fine to be told
    /// from integers.
    #[error("integer variable {variable} came out as {value}")]
    NotAnInteger {
        /// The variable.
        variable: usize,
        /// Its value.
        value: f64,
    },
    /// Exact mode needs a dense matrix over the free integers, and there are too many.
    #[error("{integers} free integers are too many for a dense matrix (at most {limit})")]
    TooManyIntegers {
        /// Free integer variables after elimination.
        integers: usize,
        /// The most that are allowed.
        limit: usize,
    },
    /// The matrix or its factor exceeds the memory or the index range.
    #[error("the sparse factor is too large for memory or for 32-bit indices")]
    TooLarge,
    /// The caller asked to stop.
    #[error("cancelled")]
    Cancelled,
}

/// A failure in terms of the reduced system.
pub(crate) enum Failure {
    Cholesky(CholeskyError),
    Solve(SolveError),
}

impl From<CholeskyError> for Failure {
    fn from(error: CholeskyError) -> Self {
        Self::Cholesky(error)
    }
}

impl From<SolveError> for Failure {
    fn from(error: SolveError) -> Self {
        Self::Solve(error)
    }
}
