//! Rounding under conditions: the free integers of one energy, with all other variables at their optimum.
//!
//! In: a [`Solver`] and an energy. Out: [`IntegerProblem`], which answers for any lower bounds and any kept integers.
//! Holds: values are integers, continuous variables follow exactly. Not: that all bounds are met.
//! Source: ours; the Schur complement in place of the ladder is described in the crate's README.

use crate::bounded::{LowerBound, round_bounded};
use crate::cholesky::SparseCholesky;
use crate::conditional::inverse_from_factor;
use crate::error::SolveError;
use crate::mending::mend;
use crate::quadratic::Quadratic;
use crate::reduce::{Substitution, reduce};
use crate::solver::{DENSE_LIMIT, Rounding, SolveOptions, SolveReport, Solver, Stage, follow_integers};
use std::cell::Cell;

/// Σ coefficient·(free integer) + constant.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct IntegerSum {
    /// Numbers of free integers with their coefficients, ascending.
    pub terms: Vec<(u32, f64)>,
    /// The constant.
    pub constant: f64,
}

impl IntegerSum {
    /// Its value at the free integers.
    pub fn value(&self, z: &[f64]) -> f64 {
        self.terms.iter().map(|&(i, c)| c * z[i as usize]).sum::<f64>() + self.constant
    }
}

/// The free integers of one energy, with everything else at its optimum: for roundings under changing bounds.
#[derive(Debug)]
pub struct IntegerProblem<'a> {
    solver: &'a Solver,
    substitution: Substitution,
    cholesky: SparseCholesky,
    /// Place of each free integer among the active variables, ascending.
    integers: Vec<u32>,
    /// Number of each active variable among the integers.
    number: Vec<Option<u32>>,
    /// Lower factor of the Schur complement.
    factor: faer::Mat<f64>,
    precision: Precision,
    /// Its inverse.
    covariance: Vec<f64>,
    relaxed: Vec<f64>,
    y: Vec<f64>,
    effort: Cell<usize>,
}

impl Solver {
    /// The relaxed problem, reduced to its free integers.
    ///
    /// # Errors  as [`Solver::solve`]; more integers than [`DENSE_LIMIT`]
    /// # Cost    one factorisation and k³ for k integers
    pub fn integer_problem(
        &mut self,
        quadratic: &Quadratic,
        options: &SolveOptions,
    ) -> Result<IntegerProblem<'_>, SolveError> {
        quadratic.check()?;
        let given = vec![None; self.elimination().free().len()];
        let substitution = Substitution::new(self.elimination(), &given);
        let system = reduce(quadratic, &substitution);
        let integers = self.active_integers(&substitution, Rounding::Greedy);
        if integers.len() > DENSE_LIMIT {
            return Err(SolveError::TooManyIntegers { integers: integers.len(), limit: DENSE_LIMIT });
        }
        let mut report = SolveReport::default();
        let mut stage = Stage { system: &system, integers: &integers, options, report: &mut report };
        let (mut analysis, _) = self.take_analysis(&system.matrix, &integers, &mut stage)?;
        let y = stage.relax(&mut analysis.cholesky).map_err(|failure| self.name_variable(failure, &substitution))?;
        let factor = analysis.cholesky.trailing_block();
        let relaxed: Vec<f64> = integers.iter().map(|&i| y[i as usize]).collect();
        let covariance = inverse_from_factor(&factor);
        let precision = Precision::of_factor(&factor);
        let mut number = vec![None; y.len()];
        integers.iter().zip(0..).for_each(|(&at, k)| number[at as usize] = Some(k));
        let cholesky = analysis.cholesky;
        Ok(IntegerProblem {
            solver: self,
            substitution,
            cholesky,
            integers,
            number,
            factor,
            precision,
            covariance,
            relaxed,
            y,
            effort: Cell::default(),
        })
    }
}

/// The Schur complement of the free integers.
#[derive(Debug)]
pub(crate) struct Precision {
    /// Row by row.
    entries: Vec<f64>,
    order: usize,
}

impl Precision {
    /// L·Lᵀ.
    fn of_factor(factor: &faer::Mat<f64>) -> Self {
        let k = factor.nrows();
        let rows: Vec<Vec<f64>> = (0..k).map(|i| (0..=i).map(|j| factor[(i, j)]).collect()).collect();
        let mut entries = vec![0.0; k * k];
        for i in 0..k {
            for j in 0..=i {
                let product: f64 = rows[i].iter().zip(&rows[j]).map(|(a, b)| a * b).sum();
                (entries[i * k + j], entries[j * k + i]) = (product, product);
            }
        }
        Self { entries, order: k }
    }

    /// From all its entries, row by row.
    #[cfg(test)]
    pub fn of_entries(entries: Vec<f64>, order: usize) -> Self {
        Self { entries, order }
    }

    pub fn row(&self, i: usize) -> &[f64] {
        &self.entries[i * self.order..(i + 1) * self.order]
    }

    pub fn times(&self, x: &[f64]) -> Vec<f64> {
        (0..self.order).map(|i| self.row(i).iter().zip(x).map(|(s, x)| s * x).sum()).collect()
    }
}

impl IntegerProblem<'_> {
    /// Number of free integers.
    pub fn len(&self) -> usize {
        self.integers.len()
    }

    /// Whether there is nothing to round.
    pub fn is_empty(&self) -> bool {
        self.integers.is_empty()
    }

    /// Multiplications of all roundings and mendings so far, but for a factor of about two.
    pub fn effort(&self) -> usize {
        self.effort.get()
    }

    fn spend(&self, effort: usize) {
        self.effort.set(self.effort.get() + effort);
    }

    /// A sum of variables as a sum over the free integers and a constant; `None` where continuous variables remain.
    pub fn over_integers(&self, terms: impl Iterator<Item = (usize, f64)>) -> Option<IntegerSum> {
        let (mut sum, mut constant) = (std::collections::BTreeMap::<u32, f64>::new(), 0.0);
        for (variable, c) in terms {
            let (expression, offset) = self.substitution.expression(variable);
            constant += c * offset;
            for &(at, factor) in expression {
                // Continuous ones may cancel, so they are only looked for at the end.
                *sum.entry(at).or_insert(0.0) += c * factor;
            }
        }
        let left = sum.into_iter().filter(|t| t.1.abs() > 1e-12);
        let over: Option<Vec<(u32, f64)>> = left.map(|(at, c)| Some((self.number[at as usize]?, c))).collect();
        Some(IntegerSum { terms: over?, constant })
    }

    /// Greedy rounding under lower bounds.
    ///
    /// # Input      bounds: over the free integers, as from [`IntegerProblem::over_integers`]; kept: free integers whose
    /// values are given
    /// # Output     the free integers
    /// # Errors     cancellation
    /// # Cost       k³ for k integers
    /// # Guarantees integers; not that all bounds are met, see [`LowerBound::is_missed`]
    pub fn round(
        &self,
        bounds: &[LowerBound],
        kept: &[(usize, f64)],
        options: &SolveOptions,
    ) -> Result<Vec<f64>, SolveError> {
        let cancelled = || options.cancelled.is_some_and(|cancelled| cancelled());
        if kept.is_empty() {
            let covariance = self.covariance.clone();
            let rounded = round_bounded(covariance, &self.relaxed, bounds, &cancelled).ok_or(SolveError::Cancelled)?;
            self.spend(rounded.effort);
            return Ok(rounded.integers);
        }
        let others = Restricted::new(self, kept);
        if others.free.is_empty() {
            return Ok(others.completed(&[]));
        }
        let (covariance, relaxed) = others.optimum()?;
        let bounds = others.bounds(bounds);
        let rounded = round_bounded(covariance, &relaxed, &bounds, &cancelled).ok_or(SolveError::Cancelled)?;
        self.spend(rounded.effort + others.free.len().pow(3) + self.len().pow(2));
        Ok(others.completed(&rounded.integers))
    }

    /// What the energy is above the relaxation's, at the optimum for given values of the free integers.
    pub fn excess(&self, values: &[f64]) -> f64 {
        let away: Vec<f64> = values.iter().zip(&self.relaxed).map(|(value, z)| value - z).collect();
        self.spend(self.len().pow(2));
        0.5 * self.precision.times(&away).iter().zip(&away).map(|(s, x)| s * x).sum::<f64>()
    }

    /// Integers near the given ones that miss less of the bounds in sum, or none; else the given ones.
    ///
    /// # Input      bounds: as for [`IntegerProblem::round`]; values: one integer per free integer
    /// # Cost       k² for k integers, and k per jump
    pub fn mend(&self, bounds: &[LowerBound], values: &[f64]) -> Vec<f64> {
        let (mended, effort) = mend(&self.precision, &self.relaxed, bounds, values);
        self.spend(effort + self.len().pow(2));
        mended
    }

    /// All variables at the optimum for given values of the free integers.
    ///
    /// # Errors  integer variables that do not come out as integers
    pub fn complete(&self, values: &[f64]) -> Result<Vec<f64>, SolveError> {
        let mut x = self.complete_relaxed(values);
        self.solver.snap_integers(&mut x)?;
        Ok(x)
    }

    /// All variables at the optimum for values of the free integers that need not be integers.
    pub fn complete_relaxed(&self, values: &[f64]) -> Vec<f64> {
        let mut y = self.y.clone();
        let shift: Vec<f64> = values.iter().zip(&self.relaxed).map(|(value, z)| value - z).collect();
        follow_integers(&self.cholesky, &self.integers, &self.factor, &shift, &mut y);
        self.integers.iter().zip(values).for_each(|(&i, &value)| y[i as usize] = value);
        let given = vec![None; self.substitution.active.len()];
        self.solver.expand(&self.substitution, &given, &y)
    }

    /// The free integers' values in a solution.
    pub fn values_in(&self, x: &[f64]) -> Vec<f64> {
        let free = self.solver.elimination().restrict(x);
        self.integers.iter().map(|&i| free[self.substitution.active[i as usize] as usize]).collect()
    }
}

/// The problem over the free integers that are left once some have given values.
struct Restricted<'a> {
    problem: &'a IntegerProblem<'a>,
    kept: &'a [(usize, f64)],
    /// The given value of each integer.
    value: Vec<Option<f64>>,
    /// The integers without one, ascending.
    free: Vec<usize>,
}

impl<'a> Restricted<'a> {
    fn new(problem: &'a IntegerProblem<'a>, kept: &'a [(usize, f64)]) -> Self {
        let mut value = vec![None; problem.len()];
        kept.iter().for_each(|&(i, given)| value[i] = Some(given));
        let free = (0..problem.len()).filter(|&i| value[i].is_none()).collect();
        Self { problem, kept, value, free }
    }

    /// Covariance of the others, row by row, and their optimum: P_ff·(z - z*)_f = -P_fk·(z - z*)_k.
    fn optimum(&self) -> Result<(Vec<f64>, Vec<f64>), SolveError> {
        let Self { problem, kept, free, .. } = self;
        let n = free.len();
        let precision = |i: usize, j: usize| problem.precision.row(i)[j];
        // 1. Their own covariance.
        let own = faer::Mat::from_fn(n, n, |i, j| precision(free[i], free[j]));
        let factor = own.llt(faer::Side::Lower).map_err(|_| SolveError::TooLarge)?.L().to_owned();
        let covariance = inverse_from_factor(&factor);
        // 2. The kept ones move their optimum.
        let pull_on = |&i: &usize| kept.iter().map(|&(j, z)| precision(i, j) * (z - problem.relaxed[j])).sum();
        let pull: Vec<f64> = free.iter().map(pull_on).collect();
        let step = |i: usize| (0..n).map(|j| covariance[i * n + j] * pull[j]).sum::<f64>();
        let relaxed = (0..n).map(|i| problem.relaxed[free[i]] - step(i)).collect();
        Ok((covariance, relaxed))
    }

    /// The bounds over the others; those over kept integers only are left out.
    fn bounds(&self, bounds: &[LowerBound]) -> Vec<LowerBound> {
        let mut number = vec![None; self.problem.len()];
        self.free.iter().zip(0u32..).for_each(|(&i, n)| number[i] = Some(n));
        let rest = |bound: &LowerBound| {
            let terms = bound.terms.iter().filter_map(|&(i, c)| Some((number[i as usize]?, c)));
            let terms: Vec<(u32, f64)> = terms.collect();
            let known: f64 = bound.terms.iter().filter_map(|&(i, c)| Some(c * self.value[i as usize]?)).sum();
            (!terms.is_empty()).then_some(LowerBound { terms, least: bound.least - known })
        };
        bounds.iter().filter_map(rest).collect()
    }

    /// All integers, with values for the others.
    fn completed(mut self, others: &[f64]) -> Vec<f64> {
        self.free.iter().zip(others).for_each(|(&i, &z)| self.value[i] = Some(z));
        self.value.into_iter().flatten().collect()
    }
}
