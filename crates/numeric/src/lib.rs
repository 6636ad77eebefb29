//! Sparse solves, linear constraints and mixed-integer rounding, free of any mesh.
//!
//! Minimises ½xᵀAx − xᵀb subject to Cx = d and x_i ∈ ℤ for i in I ([Bommes2012] ch. 5).
//!
//! In: a [`Quadratic`] energy, [`Constraints`], indices of integer variables. Out: a [`Solution`].
//! Holds: constraints and integers are met; optimality only where [`Rounding::Exact`] proves it. All is
//! sequential, so equal input gives equal bytes for any number of threads.
//!
//! | paper | here | meaning |
//! |---|---|---|
//! | A, b | [`Quadratic`] | energy |
//! | C, d | [`Constraints`] | linear equality constraints |
//! | x = By + c | [`Elimination`] | solution set of Cx = d |
//! | I | `integers` | indices of integer variables |
//! | ε, maxiters_GS, maxiters_CG | [`LadderOptions`] | limits of the adaptive three-level solver |
//! | lb, d_r | [`ExactReport`] | lower bound and relative gap |

#[doc = include_str!("../README.md")]
#[cfg(doctest)]
pub struct ReadmeDoctests;

mod bounded;
pub mod cholesky;
mod conditional;
pub mod constraints;
mod descent;
pub mod elimination;
pub mod error;
pub mod exact;
pub mod integer_problem;
mod ladder;
mod mending;
pub mod quadratic;
mod reduce;
mod rounding;
pub mod solver;
pub mod sparse;

pub use bounded::LowerBound;
pub use cholesky::{CholeskyError, SINGULAR_PIVOT, SparseCholesky};
pub use constraints::{Constraints, Row};
pub use elimination::{Elimination, Expression};
pub use error::SolveError;
pub use exact::{Branching, ExactOptions, ExactReport, Selection};
pub use integer_problem::{IntegerProblem, IntegerSum};
pub use ladder::LadderOptions;
pub use quadratic::{Quadratic, Square};
pub use solver::{
    DENSE_LIMIT, MixedIntegerProblem, Rounding, SCHUR_LIMIT, Solution, SolveOptions, SolveReport, Solver, StageSeconds,
    Updates, solve,
};
pub use sparse::{SparseSymmetric, Triplet};
