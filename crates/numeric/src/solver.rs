//! The constrained mixed-integer solver.
//!
//! In: an energy, linear constraints, integer variables. Out: [`Solution`], all constraints and integers
//! kept. Holds: integers and rows of integer data are met exactly, others to rounding; sequential, so equal
//! input gives equal bytes. Not guaranteed: optimality, except where [`Rounding::Exact`] proves it.
//!
//! Source: [Bommes2012] §5; the Schur complement in place of the ladder is ours, see the crate's README.

use std::time::Instant;

use crate::cholesky::{CholeskyError, SparseCholesky};
use crate::conditional::Conditional;
use crate::constraints::Constraints;
use crate::descent::descend;
use crate::elimination::Elimination;
use crate::error::{Failure, SolveError};
use crate::exact::{ExactOptions, ExactReport, branch_and_bound, cost_of};
use crate::ladder::{Ladder, LadderOptions};
use crate::quadratic::Quadratic;
use crate::reduce::{Reduced, Substitution, reduce};
use crate::rounding::{RoundingCounts, nearest_integer, round_conditional, round_ladder};
use crate::sparse::SparseSymmetric;

/// Up to so many free integers a dense Schur complement replaces the ladder under [`Updates::Auto`].
///
/// Cost grows with the cube: measured in the crate's README.
pub const SCHUR_LIMIT: usize = 1000;

/// More integers than this are refused where a dense matrix is needed: 2 × 8 bytes × 6000² are 576 MB.
pub const DENSE_LIMIT: usize = 6000;

/// Analyses of distinct patterns that a [`Solver`] keeps.
const KEPT_ANALYSES: usize = 3;

/// An integer variable that misses its integer by more than this was not one of integer data.
const INTEGER_TOLERANCE: f64 = 1e-6;

/// min ½xᵀAx − xᵀb, Cx = d, x_i integer for i in I ([Bommes2012] Eq. (5.1)-(5.3)).
#[derive(Debug, Clone, Default)]
pub struct MixedIntegerProblem {
    /// A and b.
    pub quadratic: Quadratic,
    /// C and d.
    pub constraints: Constraints,
    /// I, in any order.
    pub integers: Vec<usize>,
}

/// How integers are chosen.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum Rounding {
    /// Not at all: the continuous relaxation.
    Relaxed,
    /// All at once from the relaxation ([Bommes2012] §5.2.1).
    Direct,
    /// Nearest first, in blocks where that saves work ([Bommes2012] §5.2.2); on the ladder then by single steps that lower
    /// the energy.
    #[default]
    Greedy,
    /// Nearest first, the others updated after each.
    GreedyOneByOne,
    /// As `GreedyOneByOne`, each update by a Cholesky factorisation; slow, for comparison.
    Naive,
    /// Branch and bound from the greedy solution ([Bommes2012] §4.1).
    Exact(ExactOptions),
}

/// How the relaxation follows a rounding.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Updates {
    /// The Schur complement up to [`SCHUR_LIMIT`] integers, the ladder beyond.
    #[default]
    Auto,
    /// Dense Schur complement onto the integers: exact, cost k³ for k integers.
    Schur,
    /// Gauss-Seidel, conjugate gradients, Cholesky: cost by how far a rounding is felt.
    Ladder,
}

/// What to do and when to stop.
#[derive(Clone, Copy)]
pub struct SolveOptions<'a> {
    /// Choice of the integers. Default: greedy.
    pub rounding: Rounding,
    /// Update of the relaxation. Default: automatic.
    pub updates: Updates,
    /// Sum of deviations up to which integers are rounded in one block of the ladder. Default ½, beyond
    /// which roundings could influence each other. Larger: faster, worse. 0: one by one.
    pub block_limit: f64,
    /// Limits of the ladder.
    pub ladder: LadderOptions,
    /// Variables whose value is given in advance, for instance integers of an earlier solution.
    pub fixed: &'a [(usize, f64)],
    /// Asked between roundings; true ends the solve with [`SolveError::Cancelled`].
    pub cancelled: Option<&'a (dyn Fn() -> bool + 'a)>,
}

impl Default for SolveOptions<'_> {
    fn default() -> Self {
        Self {
            rounding: Rounding::default(),
            updates: Updates::default(),
            block_limit: 0.5,
            ladder: LadderOptions::default(),
            fixed: &[],
            cancelled: None,
        }
    }
}

impl std::fmt::Debug for SolveOptions<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SolveOptions")
            .field("rounding", &self.rounding)
            .field("updates", &self.updates)
            .field("block_limit", &self.block_limit)
            .field("ladder", &self.ladder)
            .field("fixed", &self.fixed.len())
            .finish_non_exhaustive()
    }
}

/// A point that satisfies the constraints.
#[derive(Debug, Clone)]
pub struct Solution {
    /// One value per variable.
    pub x: Vec<f64>,
    /// E(x) with all constants.
    pub energy: f64,
    /// How it was found.
    pub report: SolveReport,
}

/// Counts and times of one solve.
#[derive(Debug, Clone, Default)]
pub struct SolveReport {
    /// Variables of the problem.
    pub variables: usize,
    /// Rows of C.
    pub rows: usize,
    /// Labels of rows that followed from others.
    pub dependent_rows: Vec<usize>,
    /// Variables left after elimination and fixed values.
    pub free: usize,
    /// Integers among them.
    pub free_integers: usize,
    /// Entries of the reduced matrix, both triangles.
    pub matrix_entries: usize,
    /// Entries of the Cholesky factor.
    pub factor_entries: usize,
    /// Whether the Schur complement was used, and not the ladder.
    pub schur: bool,
    /// Whether a kept analysis was used again.
    pub warm: bool,
    /// Integers rounded.
    pub roundings: usize,
    /// Updates of the relaxation in the course of it.
    pub rounds: usize,
    /// Steps of single integers after rounding that lowered the energy.
    pub steps: usize,
    /// Single-variable updates.
    pub gauss_seidel_updates: usize,
    /// Iterations of conjugate gradients.
    pub conjugate_gradient_iterations: usize,
    /// Numeric factorisations.
    pub factorizations: usize,
    /// Branch and bound, if it ran.
    pub exact: Option<ExactReport>,
    /// Wall-clock seconds.
    pub seconds: StageSeconds,
}

/// Seconds per stage of a solve.
#[derive(Debug, Clone, Copy, Default)]
pub struct StageSeconds {
    /// Elimination of the constraints; 0 for solves after a solver's first.
    pub eliminate: f64,
    /// Assembly of the reduced system.
    pub reduce: f64,
    /// Ordering and symbolic factorisation; near 0 if kept.
    pub analyse: f64,
    /// Relaxed solution.
    pub relax: f64,
    /// Choice of the integers.
    pub round: f64,
    /// Continuous variables for the final integers.
    pub finish: f64,
}

/// Solves one problem.
///
/// # Output     a point that meets every row and integer
/// # Errors     see [`SolveError`]; contradicting rows are named
/// # Cost       one or two factorisations, and the roundings
/// # Guarantees integers exactly; not optimality, unless exact mode proves it
/// # Source     [Bommes2012] §5
/// # Example
/// ```
/// use quadloom_numeric::{MixedIntegerProblem, Quadratic, SolveOptions, solve};
/// let mut problem = MixedIntegerProblem { quadratic: Quadratic::new(2), ..Default::default() };
/// problem.quadratic.add_square(&[(0, 1.0)], 1.4, 1.0);
/// problem.quadratic.add_square(&[(0, 1.0), (1, -1.0)], 0.0, 1.0);
/// problem.integers = vec![0];
/// let solution = solve(&problem, &SolveOptions::default())?;
/// assert_eq!(solution.x[0], 1.0);
/// assert!((solution.x[1] - 1.0).abs() < 1e-12);
/// # Ok::<(), quadloom_numeric::SolveError>(())
/// ```
pub fn solve(problem: &MixedIntegerProblem, options: &SolveOptions) -> Result<Solution, SolveError> {
    Solver::new(problem.quadratic.n(), &problem.constraints, &problem.integers)?.solve(&problem.quadratic, options)
}

/// Constraints eliminated once, for any number of energies over them.
///
/// Solves after the first with the same pattern of energy skip the ordering and the symbolic factorisation.
#[derive(Debug)]
pub struct Solver {
    constraints: Constraints,
    integers: Vec<usize>,
    elimination: Elimination,
    /// Most recently used first.
    analyses: Vec<Analysis>,
    eliminate_seconds: f64,
}

/// A kept analysis and the pattern it belongs to.
#[derive(Debug)]
pub(crate) struct Analysis {
    pattern: SparseSymmetric,
    last: Vec<u32>,
    pub cholesky: SparseCholesky,
}

impl Solver {
    /// Eliminates the constraints.
    ///
    /// # Errors  as [`Elimination::eliminate`]
    pub fn new(n: usize, constraints: &Constraints, integers: &[usize]) -> Result<Self, SolveError> {
        let started = Instant::now();
        let mut is_integer = vec![false; n];
        for &variable in integers {
            *is_integer.get_mut(variable).ok_or(SolveError::VariableOutOfRange { variable, n })? = true;
        }
        let elimination = Elimination::eliminate(n, constraints, &is_integer)?;
        Ok(Self {
            constraints: constraints.clone(),
            integers: integers.to_vec(),
            elimination,
            analyses: Vec::new(),
            eliminate_seconds: started.elapsed().as_secs_f64(),
        })
    }

    /// The elimination, for other energies over the same constraints.
    pub fn elimination(&self) -> &Elimination {
        &self.elimination
    }

    /// Minimises an energy over the constraints.
    ///
    /// # Errors  see [`SolveError`]
    pub fn solve(&mut self, quadratic: &Quadratic, options: &SolveOptions) -> Result<Solution, SolveError> {
        quadratic.check()?;
        if quadratic.n() != self.elimination.n() {
            return Err(SolveError::VariableOutOfRange { variable: quadratic.n(), n: self.elimination.n() });
        }
        match given_values(&self.elimination, options.fixed)? {
            Some(given) => self.solve_given(quadratic, options, given),
            None => self.solve_with_extra_rows(quadratic, options),
        }
    }

    /// Fixed values that do not reduce to values of free variables are rows like any other.
    fn solve_with_extra_rows(&self, quadratic: &Quadratic, options: &SolveOptions) -> Result<Solution, SolveError> {
        let mut constraints = self.constraints.clone();
        let first = constraints.rows().map(|row| row.label + 1).max().unwrap_or(0);
        for (at, &(variable, value)) in options.fixed.iter().enumerate() {
            constraints.fix(variable, value, first + at);
        }
        let mut solver = Self::new(self.elimination.n(), &constraints, &self.integers)?;
        solver.solve(quadratic, &SolveOptions { fixed: &[], ..*options })
    }

    fn solve_given(
        &mut self,
        quadratic: &Quadratic,
        options: &SolveOptions,
        given: Vec<Option<f64>>,
    ) -> Result<Solution, SolveError> {
        let mut report = self.start_report();
        let clock = Instant::now();
        let substitution = Substitution::new(&self.elimination, &given);
        let system = reduce(quadratic, &substitution);
        let integers = self.active_integers(&substitution, options.rounding);
        report.free = system.rhs.len();
        report.free_integers = integers.len();
        report.matrix_entries = system.matrix.stored();
        report.seconds.reduce = clock.elapsed().as_secs_f64();
        let schur = uses_schur(options, integers.len())?;
        let mut stage = Stage { system: &system, integers: &integers, options, report: &mut report };
        let last: &[u32] = if schur { &integers } else { &[] };
        let (mut analysis, warm) = self.take_analysis(&system.matrix, last, &mut stage)?;
        stage.report.warm = warm;
        let expand = |y: &[f64]| self.expand(&substitution, &given, y);
        let outcome = if schur {
            stage.round_by_schur(&mut analysis.cholesky, |y| quadratic.energy(&expand(y)))
        } else {
            stage.round_by_ladder(&mut analysis.cholesky)
        };
        let y = outcome.map_err(|failure| self.name_variable(failure, &substitution))?;
        let mut x = expand(&y);
        self.analyses.insert(0, analysis);
        self.analyses.truncate(KEPT_ANALYSES);
        if options.rounding != Rounding::Relaxed {
            self.snap_integers(&mut x)?;
        }
        let energy = quadratic.energy(&x);
        Ok(Solution { energy, x, report })
    }

    fn start_report(&mut self) -> SolveReport {
        let seconds = StageSeconds { eliminate: std::mem::take(&mut self.eliminate_seconds), ..Default::default() };
        SolveReport {
            variables: self.elimination.n(),
            rows: self.constraints.len(),
            dependent_rows: self.elimination.dependent().to_vec(),
            seconds,
            ..SolveReport::default()
        }
    }

    /// Active variables to be rounded, ascending.
    pub(crate) fn active_integers(&self, substitution: &Substitution, rounding: Rounding) -> Vec<u32> {
        if rounding == Rounding::Relaxed {
            return Vec::new();
        }
        let is_integer = |&at: &u32| self.elimination.free_is_integer()[substitution.active[at as usize] as usize];
        (0..substitution.active.len() as u32).filter(is_integer).collect()
    }

    /// A kept analysis of this pattern, or a new one; with whether it was kept.
    pub(crate) fn take_analysis(
        &mut self,
        matrix: &SparseSymmetric,
        last: &[u32],
        stage: &mut Stage,
    ) -> Result<(Analysis, bool), SolveError> {
        let clock = Instant::now();
        // Where no order is asked for, any will do.
        let serves = |a: &Analysis| last.is_empty() || a.last == last;
        let known = self.analyses.iter().position(|a| serves(a) && a.pattern.same_pattern(matrix));
        let analysis = match known {
            Some(at) => self.analyses.remove(at),
            None => Analysis {
                pattern: matrix.clone(),
                last: last.to_vec(),
                cholesky: SparseCholesky::analyse(matrix, last).map_err(|_| SolveError::TooLarge)?,
            },
        };
        stage.report.factor_entries = analysis.cholesky.factor_entries();
        stage.report.seconds.analyse = clock.elapsed().as_secs_f64();
        Ok((analysis, known.is_some()))
    }

    pub(crate) fn expand(&self, substitution: &Substitution, given: &[Option<f64>], y: &[f64]) -> Vec<f64> {
        let mut free: Vec<f64> = given.iter().map(|value| value.unwrap_or(0.0)).collect();
        substitution.active.iter().zip(y).for_each(|(&k, &value)| free[k as usize] = value);
        self.elimination.expand(&free)
    }

    /// Integers are combinations of integers; rounding takes off the last digit of noise.
    pub(crate) fn snap_integers(&self, x: &mut [f64]) -> Result<(), SolveError> {
        for &i in &self.integers {
            let rounded = x[i].round();
            if (x[i] - rounded).abs() > INTEGER_TOLERANCE {
                return Err(SolveError::NotAnInteger { variable: i, value: x[i] });
            }
            x[i] = rounded;
        }
        Ok(())
    }

    pub(crate) fn name_variable(&self, failure: Failure, substitution: &Substitution) -> SolveError {
        match failure {
            Failure::Cholesky(CholeskyError::NotPositiveDefinite { row }) => {
                let free = substitution.active[row] as usize;
                SolveError::NotPositiveDefinite { variable: self.elimination.free()[free] as usize }
            }
            Failure::Cholesky(CholeskyError::TooLarge) => SolveError::TooLarge,
            Failure::Solve(error) => error,
        }
    }
}

/// The value of each free variable that `fixed` determines; None if it ties free variables to each other.
fn given_values(elimination: &Elimination, fixed: &[(usize, f64)]) -> Result<Option<Vec<Option<f64>>>, SolveError> {
    let mut given = vec![None; elimination.free().len()];
    let mut later = Vec::new();
    for &(variable, value) in fixed {
        if variable >= elimination.n() {
            return Err(SolveError::VariableOutOfRange { variable, n: elimination.n() });
        }
        if !value.is_finite() {
            return Err(SolveError::NotFinite { place: format!("fixed variable {variable}") });
        }
        let expression = elimination.expression(variable);
        match *expression.terms {
            [(k, 1.0)] if given[k as usize].is_none() => {
                let value = value - expression.constant;
                if elimination.free_is_integer()[k as usize] && value.fract() != 0.0 {
                    return Ok(None);
                }
                given[k as usize] = Some(value);
            }
            _ => later.push((variable, value)),
        }
    }
    let agrees = |&(variable, value): &(usize, f64)| {
        let expression = elimination.expression(variable);
        let sum = |total: f64, &(k, c): &(u32, f64)| given[k as usize].map(|v: f64| total + c * v);
        let known = expression.terms.iter().try_fold(expression.constant, sum);
        known.is_some_and(|known| (known - value).abs() <= INTEGER_TOLERANCE * value.abs().max(1.0))
    };
    Ok(later.iter().all(agrees).then_some(given))
}

fn uses_schur(options: &SolveOptions, integers: usize) -> Result<bool, SolveError> {
    let dense = match (options.rounding, options.updates) {
        (Rounding::Exact(_), _) => true,
        (Rounding::Naive, _) => false,
        (_, Updates::Schur) => true,
        (_, Updates::Ladder) => false,
        (_, Updates::Auto) => integers <= SCHUR_LIMIT,
    };
    if dense && integers > DENSE_LIMIT {
        return Err(SolveError::TooManyIntegers { integers, limit: DENSE_LIMIT });
    }
    Ok(dense && integers > 0)
}

/// A reduced system on its way to integers.
pub(crate) struct Stage<'a> {
    pub system: &'a Reduced,
    pub integers: &'a [u32],
    pub options: &'a SolveOptions<'a>,
    pub report: &'a mut SolveReport,
}

impl Stage<'_> {
    fn is_cancelled(&self) -> bool {
        self.options.cancelled.is_some_and(|cancelled| cancelled())
    }

    /// Step 1 ([Bommes2012] Eq. (5.4)): the relaxed solution.
    pub(crate) fn relax(&mut self, cholesky: &mut SparseCholesky) -> Result<Vec<f64>, Failure> {
        if self.is_cancelled() {
            return Err(SolveError::Cancelled.into());
        }
        let clock = Instant::now();
        cholesky.factorize(&self.system.matrix)?;
        self.report.factorizations += 1;
        let mut y = self.system.rhs.clone();
        cholesky.solve(&mut y);
        self.report.seconds.relax = clock.elapsed().as_secs_f64();
        Ok(y)
    }

    /// Steps 2 and 3 on the Schur complement: the factor's trailing block is all that rounding needs.
    fn round_by_schur(
        mut self,
        cholesky: &mut SparseCholesky,
        energy: impl Fn(&[f64]) -> f64,
    ) -> Result<Vec<f64>, Failure> {
        self.report.schur = true;
        let mut y = self.relax(cholesky)?;
        let clock = Instant::now();
        let factor = cholesky.trailing_block();
        let relaxed: Vec<f64> = self.integers.iter().map(|&i| y[i as usize]).collect();
        let values = match self.options.rounding {
            Rounding::Direct => relaxed.iter().map(|&z| nearest_integer(z)).collect(),
            _ => self.choose_integers(Conditional::new(&factor, relaxed.clone()), energy(&y))?,
        };
        self.report.seconds.round = clock.elapsed().as_secs_f64();
        let clock = Instant::now();
        let shift: Vec<f64> = values.iter().zip(&relaxed).map(|(value, z)| value - z).collect();
        follow_integers(cholesky, self.integers, &factor, &shift, &mut y);
        self.integers.iter().zip(&values).for_each(|(&i, &value)| y[i as usize] = value);
        self.report.seconds.finish = clock.elapsed().as_secs_f64();
        Ok(y)
    }

    fn choose_integers(&mut self, relaxation: Conditional, relaxed_energy: f64) -> Result<Vec<f64>, SolveError> {
        let cancelled = || self.options.cancelled.is_some_and(|cancelled| cancelled());
        let Rounding::Exact(exact) = self.options.rounding else {
            let (values, counts) = greedy_values(relaxation, &cancelled)?;
            self.count(counts);
            return Ok(values);
        };
        let (values, counts) = greedy_values(relaxation.clone(), &cancelled)?;
        let greedy_cost = cost_of(relaxation.clone(), &values);
        let proof = branch_and_bound(relaxation, relaxed_energy, values, &exact, &cancelled)?;
        self.count(counts);
        let energy = relaxed_energy + proof.cost;
        let lower_bound = relaxed_energy + proof.lower_bound;
        self.report.exact = Some(ExactReport {
            nodes: proof.nodes,
            lower_bound,
            gap: (proof.cost - proof.lower_bound) / energy.abs().max(f64::MIN_POSITIVE),
            proven: proof.proven,
            greedy_energy: relaxed_energy + greedy_cost,
        });
        Ok(proof.values)
    }

    /// Steps 2 and 3 by the ladder; the last step is always an exact solve.
    fn round_by_ladder(mut self, cholesky: &mut SparseCholesky) -> Result<Vec<f64>, Failure> {
        let y = self.relax(cholesky)?;
        if self.integers.is_empty() {
            return Ok(y);
        }
        let clock = Instant::now();
        let options = self.options;
        let cancelled = || options.cancelled.is_some_and(|cancelled| cancelled());
        let mut ladder = Ladder::new(self.system, self.integers, cholesky, y, options.ladder);
        let counts = match options.rounding {
            Rounding::Direct => {
                let all: Vec<(usize, f64)> =
                    self.integers.iter().map(|&i| (i as usize, nearest_integer(ladder.y()[i as usize]))).collect();
                ladder.fix_without_update(&all);
                RoundingCounts { roundings: all.len(), rounds: 1 }
            }
            Rounding::Naive => round_ladder(&mut ladder, self.integers, 0.0, &cancelled, Ladder::fix_and_factorize)?,
            Rounding::GreedyOneByOne => round_ladder(&mut ladder, self.integers, 0.0, &cancelled, Ladder::fix)?,
            _ => round_ladder(&mut ladder, self.integers, options.block_limit, &cancelled, Ladder::fix)?,
        };
        if options.rounding == Rounding::Greedy {
            self.report.steps = descend(&mut ladder, self.integers, &cancelled)?;
        }
        self.report.seconds.round = clock.elapsed().as_secs_f64();
        let clock = Instant::now();
        ladder.fix_and_factorize(&[])?;
        let y = ladder.y().to_vec();
        let used = ladder.counts;
        self.count(counts);
        self.report.gauss_seidel_updates = used.gauss_seidel_updates;
        self.report.conjugate_gradient_iterations = used.conjugate_gradient_iterations;
        self.report.factorizations += used.factorizations;
        self.report.seconds.finish = clock.elapsed().as_secs_f64();
        Ok(y)
    }

    fn count(&mut self, counts: RoundingCounts) {
        self.report.roundings = counts.roundings;
        self.report.rounds = counts.rounds;
    }
}

/// With S = L·Lᵀ, adding S·shift to the integers' right-hand side moves them by `shift` and all others to their optimum:
/// one back-solve.
pub(crate) fn follow_integers(
    cholesky: &SparseCholesky,
    integers: &[u32],
    factor: &faer::Mat<f64>,
    shift: &[f64],
    y: &mut [f64],
) {
    let k = shift.len();
    let transposed: Vec<f64> = (0..k).map(|j| (j..k).map(|i| factor[(i, j)] * shift[i]).sum()).collect();
    let mut move_all = vec![0.0; y.len()];
    for (i, &at) in integers.iter().enumerate() {
        move_all[at as usize] = (0..=i).map(|j| factor[(i, j)] * transposed[j]).sum();
    }
    cholesky.solve(&mut move_all);
    y.iter_mut().zip(&move_all).for_each(|(value, step)| *value += step);
}

fn greedy_values(
    mut relaxation: Conditional,
    cancelled: &dyn Fn() -> bool,
) -> Result<(Vec<f64>, RoundingCounts), SolveError> {
    let counts = round_conditional(&mut relaxation, cancelled)?;
    Ok(((0..relaxation.len()).map(|i| relaxation.z(i)).collect(), counts))
}
