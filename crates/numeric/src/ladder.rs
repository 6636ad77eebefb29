//! The three-level update of a relaxed solution: local Gauss-Seidel, conjugate gradients, Cholesky.
//!
//! In: a reduced system A·y = b, its factor and its integers. Out: [`Ladder`], the relaxed solution under a
//! growing set of fixed integers. Holds: after each update every residual is at most `tolerance` times its
//! diagonal entry, that is, no single variable would move by more than `tolerance`.
//!
//! Source: [Bommes2012] §5.2.2. Differs: residuals are kept up to date instead of recomputed, and a
//! variable enters the queue only when its residual exceeds the tolerance; steps are over-relaxed; integers
//! that only link few variables are eliminated on the fly.

use std::collections::VecDeque;

use crate::cholesky::{CholeskyError, SparseCholesky};
use crate::reduce::Reduced;

/// Followers of more neighbours would make a step of one variable visit too many others.
const FOLLOWER_NEIGHBOURS: usize = 4;

/// Falls of the energy that are smaller are noise, and would let steps go round in circles.
const LEAST_FALL: f64 = 1e-6;

/// Tolerance of a trial, relative to that of the ladder: what the others would still gain decides whether a step pays.
const TRIAL_TOLERANCE_REL: f64 = 0.3;

/// When each level of the ladder gives up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LadderOptions {
    /// Largest movement a variable may still want, in units of the variables. Default 3e-3. Larger: estimates drift and
    /// roundings go wrong (1e-2: 3 to 7 % more energy on cross fields). Smaller: more sweeps, ever farther from the
    /// rounded integer.
    pub tolerance: f64,
    /// Factor on each Gauss-Seidel step, in 0..2. Default 1.3. Larger: fewer steps over long distances, until
    /// overshooting (beyond 1.5) costs more than it saves. 1: plain Gauss-Seidel.
    pub over_relaxation: f64,
    /// Single-variable updates for each rounding before conjugate gradients take over. Default 100,000
    /// ([Bommes2012] §5.3, orientation field); 0 skips the level.
    pub gauss_seidel_limit: usize,
    /// Iterations of conjugate gradients before the matrix is factorised. Default 50 ([Bommes2012] §5.3);
    /// 0 skips the level.
    pub conjugate_gradient_limit: usize,
    /// Single-variable updates, relative to the number of variables, after which the matrix is factorised in any case.
    /// Default 3, which costs less than the updates. Larger: errors over long distances, which no variable feels, add up
    /// (cross field of Rockerarm without it: 8 to 28 % more energy than exact updates).
    pub exact_after_rel: f64,
}

impl Default for LadderOptions {
    fn default() -> Self {
        Self {
            tolerance: 3e-3,
            over_relaxation: 1.3,
            gauss_seidel_limit: 100_000,
            conjugate_gradient_limit: 50,
            exact_after_rel: 3.0,
        }
    }
}

/// How often each level was used.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct LadderCounts {
    pub gauss_seidel_updates: usize,
    pub conjugate_gradient_iterations: usize,
    pub factorizations: usize,
}

/// Relaxed solution of a reduced system under fixings.
pub(crate) struct Ladder<'a> {
    system: &'a Reduced,
    cholesky: &'a mut SparseCholesky,
    options: LadderOptions,
    diagonal: Vec<f64>,
    /// Unfixed integers that follow every step of their neighbours at once, see [`follower_set`].
    follows: Vec<bool>,
    /// The diagonal once followers are eliminated: by how much a step changes its own residual.
    stiffness: Vec<f64>,
    y: Vec<f64>,
    /// b − A·y; of no meaning in fixed rows.
    residual: Vec<f64>,
    fixed: Vec<bool>,
    queue: VecDeque<u32>,
    queued: Vec<bool>,
    moved: Vec<u32>,
    has_moved: Vec<bool>,
    pub counts: LadderCounts,
    /// Movement beyond which a variable is queued.
    tolerance: f64,
    /// Gauss-Seidel updates up to the last factorisation.
    updates_when_exact: usize,
}

impl<'a> Ladder<'a> {
    /// `y`: the relaxed solution; `cholesky`: analysed for the matrix.
    pub fn new(
        system: &'a Reduced,
        integers: &[u32],
        cholesky: &'a mut SparseCholesky,
        y: Vec<f64>,
        options: LadderOptions,
    ) -> Self {
        let n = y.len();
        let diagonal = system.matrix.diagonal();
        let follows = follower_set(system, integers);
        let mut ladder = Self {
            system,
            cholesky,
            options,
            stiffness: condensed_diagonal(system, &diagonal, &follows),
            diagonal,
            follows,
            y,
            residual: vec![0.0; n],
            fixed: vec![false; n],
            queue: VecDeque::new(),
            queued: vec![false; n],
            moved: Vec::new(),
            has_moved: vec![false; n],
            counts: LadderCounts::default(),
            tolerance: options.tolerance,
            updates_when_exact: 0,
        };
        ladder.refresh_residual();
        ladder
    }

    /// The current solution.
    pub fn y(&self) -> &[f64] {
        &self.y
    }

    /// The variables that moved since the last call, each once.
    pub fn take_moved(&mut self) -> Vec<u32> {
        self.moved.iter().for_each(|&i| self.has_moved[i as usize] = false);
        std::mem::take(&mut self.moved)
    }

    /// Fixes variables and climbs the ladder until the rest has settled.
    pub fn fix(&mut self, block: &[(usize, f64)]) -> Result<(), CholeskyError> {
        for &(j, value) in block {
            self.mark_fixed(j);
            self.shift(j, value - self.y[j]);
            self.y[j] = value;
        }
        let settled = self.local_gauss_seidel() || self.conjugate_gradients();
        if settled && !self.is_exact_solve_due() { Ok(()) } else { self.factorize() }
    }

    fn is_exact_solve_due(&self) -> bool {
        let since = self.counts.gauss_seidel_updates - self.updates_when_exact;
        since as f64 > self.options.exact_after_rel * self.y.len() as f64
    }

    /// How strongly a fixed variable is drawn, in units of it: by so much it would move if no other one did.
    pub fn pull(&self, i: usize) -> f64 {
        self.residual[i] / self.diagonal[i]
    }

    /// The variables that share an entry of the matrix with one.
    pub fn neighbours(&self, i: usize) -> &'a [u32] {
        self.system.matrix.row(i).0
    }

    /// Moves a fixed variable by `step` and lets the others settle around it, if the energy falls by that.
    ///
    /// # Output     whether it did; if not, all is as before
    /// # Cost       local Gauss-Seidel, `limit` updates at most
    pub fn step_down(&mut self, i: usize, step: f64, limit: usize) -> bool {
        let mut log = vec![(i, step)];
        self.tolerance = TRIAL_TOLERANCE_REL * self.options.tolerance;
        let mut change = self.energy_of(i, step);
        self.y[i] += step;
        self.shift(i, step);
        while log.len() <= limit {
            let Some(k) = self.queue.pop_front() else { break };
            let k = k as usize;
            self.queued[k] = false;
            let step = self.residual[k] / self.diagonal[k];
            if self.fixed[k] || step.abs() <= self.tolerance {
                continue;
            }
            let step = self.options.over_relaxation * step;
            change += self.energy_of(k, step);
            self.y[k] += step;
            self.shift(k, step);
            log.push((k, step));
        }
        self.tolerance = self.options.tolerance;
        self.counts.gauss_seidel_updates += log.len();
        self.queue.drain(..).for_each(|k| self.queued[k as usize] = false);
        let falls = change < -LEAST_FALL;
        if !falls {
            for &(k, step) in log.iter().rev() {
                self.y[k] -= step;
                let (columns, values) = self.system.matrix.row(k);
                columns.iter().zip(values).for_each(|(&j, &a)| self.residual[j as usize] += a * step);
            }
            self.take_moved();
        }
        falls
    }

    /// By how much the energy changes if one variable moves, the others staying.
    fn energy_of(&self, k: usize, step: f64) -> f64 {
        step * (0.5 * self.diagonal[k] * step - self.residual[k])
    }

    /// Fixes variables and leaves the rest as it is, to be settled by a later call.
    pub fn fix_without_update(&mut self, block: &[(usize, f64)]) {
        for &(j, value) in block {
            self.mark_fixed(j);
            self.y[j] = value;
        }
    }

    /// A follower that is fixed follows no more: its neighbours become stiffer.
    fn mark_fixed(&mut self, j: usize) {
        self.fixed[j] = true;
        if std::mem::take(&mut self.follows[j]) {
            let (columns, values) = self.system.matrix.row(j);
            for (&k, &a) in columns.iter().zip(values).filter(|(k, _)| **k as usize != j) {
                self.stiffness[k as usize] += a * a / self.diagonal[j];
            }
        }
    }

    /// Fixes variables and re-solves by Cholesky at once.
    pub fn fix_and_factorize(&mut self, block: &[(usize, f64)]) -> Result<(), CholeskyError> {
        self.fix_without_update(block);
        self.factorize()
    }

    /// Level 1 ([Bommes2012] §5.2.2, algorithm Local Gauss-Seidel).
    fn local_gauss_seidel(&mut self) -> bool {
        let mut left = self.options.gauss_seidel_limit;
        while let Some(k) = self.queue.pop_front() {
            let k = k as usize;
            self.queued[k] = false;
            let step = self.residual[k] / self.stiffness[k];
            if self.fixed[k] || step.abs() <= self.options.tolerance {
                continue;
            }
            if left == 0 {
                self.queue.drain(..).for_each(|i| self.queued[i as usize] = false);
                return false;
            }
            left -= 1;
            self.counts.gauss_seidel_updates += 1;
            let step = self.options.over_relaxation * step;
            self.y[k] += step;
            self.shift(k, step);
        }
        true
    }

    /// y_k moves by `step`: followers follow, residuals too, and those above tolerance are queued.
    fn shift(&mut self, k: usize, step: f64) {
        self.mark_moved(k);
        let (columns, values) = self.system.matrix.row(k);
        for (&j, &a) in columns.iter().zip(values) {
            let j = j as usize;
            if self.follows[j] {
                self.follow(j, -a * step / self.diagonal[j]);
            } else {
                self.add_residual(j, -a * step);
            }
        }
    }

    /// A follower moves by `step`, which keeps its own residual at zero.
    fn follow(&mut self, p: usize, step: f64) {
        self.mark_moved(p);
        self.y[p] += step;
        let (columns, values) = self.system.matrix.row(p);
        for (&j, &a) in columns.iter().zip(values).filter(|(j, _)| **j as usize != p) {
            self.add_residual(j as usize, -a * step);
        }
    }

    fn add_residual(&mut self, j: usize, change: f64) {
        self.residual[j] += change;
        let wants = self.residual[j].abs() > self.tolerance * self.stiffness[j];
        if wants && !self.fixed[j] && !self.queued[j] {
            self.queued[j] = true;
            self.queue.push_back(j as u32);
        }
    }

    fn mark_moved(&mut self, k: usize) {
        if !self.has_moved[k] {
            self.has_moved[k] = true;
            self.moved.push(k as u32);
        }
    }

    /// Level 2, preconditioned by the diagonal, on the rows not fixed.
    fn conjugate_gradients(&mut self) -> bool {
        let free: Vec<u32> = (0..self.y.len() as u32).filter(|&i| !self.fixed[i as usize]).collect();
        let mut direction = vec![0.0; self.y.len()];
        let mut rho_before = 1.0;
        for iteration in 0..self.options.conjugate_gradient_limit {
            if self.is_settled() {
                break;
            }
            let precondition = |i: usize| self.residual[i] / self.diagonal[i];
            let rho: f64 = free.iter().map(|&i| self.residual[i as usize] * precondition(i as usize)).sum();
            let keep = if iteration == 0 { 0.0 } else { rho / rho_before };
            free.iter().for_each(|&i| direction[i as usize] = precondition(i as usize) + keep * direction[i as usize]);
            let image: Vec<f64> = free.iter().map(|&i| self.system.matrix.row_dot(i as usize, &direction)).collect();
            let curvature: f64 = free.iter().zip(&image).map(|(&i, a)| direction[i as usize] * a).sum();
            let step = rho / curvature;
            if !step.is_finite() {
                break;
            }
            for (&i, a) in free.iter().zip(&image) {
                self.y[i as usize] += step * direction[i as usize];
                self.residual[i as usize] -= step * a;
            }
            rho_before = rho;
            self.counts.conjugate_gradient_iterations += 1;
        }
        free.iter().for_each(|&i| self.mark_moved(i as usize));
        self.is_settled()
    }

    fn is_settled(&self) -> bool {
        let wants = |i: usize| self.residual[i].abs() > self.options.tolerance * self.stiffness[i];
        !(0..self.y.len()).any(|i| !self.fixed[i] && wants(i))
    }

    /// Level 3: the exact solution. Fixed variables keep identity rows, so the analysis is used again.
    fn factorize(&mut self) -> Result<(), CholeskyError> {
        self.counts.factorizations += 1;
        self.updates_when_exact = self.counts.gauss_seidel_updates;
        let masked = self.system.matrix.with_identity_rows(&self.fixed);
        self.cholesky.factorize(&masked)?;
        let mut solution = self.masked_rhs();
        self.cholesky.solve(&mut solution);
        for (i, &value) in solution.iter().enumerate() {
            if !self.fixed[i] {
                self.y[i] = value;
                self.mark_moved(i);
            }
        }
        self.refresh_residual();
        Ok(())
    }

    fn masked_rhs(&self) -> Vec<f64> {
        let only_fixed: Vec<f64> = self.y.iter().zip(&self.fixed).map(|(&y, &f)| if f { y } else { 0.0 }).collect();
        let row = |i: usize| {
            if self.fixed[i] { self.y[i] } else { self.system.rhs[i] - self.system.matrix.row_dot(i, &only_fixed) }
        };
        (0..self.y.len()).map(row).collect()
    }

    fn refresh_residual(&mut self) {
        for i in 0..self.y.len() {
            self.residual[i] = self.system.rhs[i] - self.system.matrix.row_dot(i, &self.y);
        }
    }
}

/// Integers of at most [`FOLLOWER_NEIGHBOURS`] neighbours, none of which is a follower.
///
/// An unfixed integer that only links two angles, say, takes up whatever difference they have. Swept like
/// any other variable it holds its neighbours back at every step; eliminated on the fly it does not, and
/// a sweep settles in a fraction of the updates.
fn follower_set(system: &Reduced, integers: &[u32]) -> Vec<bool> {
    let mut follows = vec![false; system.rhs.len()];
    for &p in integers {
        let (columns, _) = system.matrix.row(p as usize);
        let alone = columns.iter().all(|&j| !follows[j as usize]);
        follows[p as usize] = alone && columns.len() <= FOLLOWER_NEIGHBOURS + 1;
    }
    follows
}

/// A_kk − Σ A_kp²/A_pp over the followers p.
fn condensed_diagonal(system: &Reduced, diagonal: &[f64], follows: &[bool]) -> Vec<f64> {
    let mut condensed = diagonal.to_vec();
    for p in (0..follows.len()).filter(|&p| follows[p]) {
        let (columns, values) = system.matrix.row(p);
        for (&k, &a) in columns.iter().zip(values).filter(|(k, _)| **k as usize != p) {
            condensed[k as usize] -= a * a / diagonal[p];
        }
    }
    condensed
}
