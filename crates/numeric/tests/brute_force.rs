//! Exact mode against enumeration with Lagrange multipliers ([Bommes2012] Eq. (5.6)): another algorithm
//! for every step.

mod common;

use common::{Random, gauss};
use quadloom_numeric::{
    Branching, Constraints, ExactOptions, MixedIntegerProblem, Quadratic, Rounding, Selection, SolveError,
    SolveOptions, solve,
};

/// The same problem twice: for the crate, and dense.
struct Case {
    problem: MixedIntegerProblem,
    a: Vec<Vec<f64>>,
    b: Vec<f64>,
    rows: Vec<Vec<f64>>,
}

/// A = ½MᵀM + 2·1, so that its smallest eigenvalue is at least 2.
const SMALLEST_EIGENVALUE: f64 = 2.0;

fn random_case(seed: u64) -> Case {
    let mut random = Random::new(seed);
    let n = random.integer(1, 9) as usize;
    let integers: Vec<usize> = (0..n).filter(|_| random.integer(0, 2) == 0).take(5).collect();
    let m: Vec<Vec<f64>> = (0..n).map(|_| (0..n).map(|_| random.real(-1.0, 1.0)).collect()).collect();
    let mut a: Vec<Vec<f64>> =
        (0..n).map(|i| (0..n).map(|j| (0..n).map(|t| 0.5 * m[t][i] * m[t][j]).sum()).collect()).collect();
    (0..n).for_each(|i| a[i][i] += SMALLEST_EIGENVALUE);
    let b: Vec<f64> = (0..n).map(|_| random.real(-8.0, 8.0)).collect();
    let mut problem = MixedIntegerProblem { quadratic: Quadratic::new(n), integers, ..Default::default() };
    for i in 0..n {
        problem.quadratic.add_rhs(i, b[i]);
        (i..n).for_each(|j| problem.quadratic.add(j, i, a[i][j]));
    }
    let rows =
        (0..random.integer(0, 4)).map(|label| random_row(&mut random, &mut problem, n, label as usize)).collect();
    Case { problem, a, b, rows }
}

fn random_row(random: &mut Random, problem: &mut MixedIntegerProblem, n: usize, label: usize) -> Vec<f64> {
    let mut row = vec![0.0; n + 1];
    for _ in 0..random.integer(1, 5) {
        row[random.integer(0, n as i64) as usize] += random.integer(-3, 4) as f64;
    }
    let continuous = (0..n).any(|i| row[i] != 0.0 && !problem.integers.contains(&i));
    row[n] = if continuous { random.real(-3.0, 3.0) } else { random.integer(-3, 4) as f64 };
    let terms: Vec<(usize, f64)> = (0..n).filter(|&i| row[i] != 0.0).map(|i| (i, row[i])).collect();
    problem.constraints.add(&terms, row[n], label);
    row
}

/// Least energy with some variables given: the stationary point of Eq. (5.5). None: the rows exclude it.
fn minimise(case: &Case, given: &[(usize, f64)]) -> Option<f64> {
    let (n, m) = (case.b.len(), case.rows.len() + given.len());
    let mut constraints = case.rows.clone();
    for &(i, value) in given {
        let mut row = vec![0.0; n + 1];
        row[i] = 1.0;
        row[n] = value;
        constraints.push(row);
    }
    gauss(constraints.clone(), n)?;
    let mut system = vec![vec![0.0; n + m + 1]; n + m];
    for (i, row) in system.iter_mut().enumerate().take(n) {
        row[..n].copy_from_slice(&case.a[i]);
        row[n + m] = case.b[i];
    }
    for (r, row) in constraints.iter().enumerate() {
        for i in 0..n {
            system[i][n + r] = row[i];
            system[n + r][i] = row[i];
        }
        system[n + r][n + m] = row[n];
    }
    let x = gauss(system, n + m)?;
    let ax = |i: usize| (0..n).map(|j| case.a[i][j] * x[j]).sum::<f64>();
    Some((0..n).map(|i| x[i] * (0.5 * ax(i) - case.b[i])).sum())
}

/// The relaxed minimiser's integers, by which the box of the search is centred.
fn relaxed(case: &Case) -> Option<Vec<f64>> {
    let options = SolveOptions { rounding: Rounding::Relaxed, ..Default::default() };
    let solution = solve(&case.problem, &options).ok()?;
    assert!((solution.energy - minimise(case, &[])?).abs() < 1e-7);
    Some(case.problem.integers.iter().map(|&i| solution.x[i]).collect())
}

/// Visits every integer point of the box centre ± radius, unless there are more than `most`.
fn for_each_point(center: &[f64], radius: f64, most: usize, mut visit: impl FnMut(&[f64])) -> bool {
    let low: Vec<i64> = center.iter().map(|c| (c - radius).ceil() as i64).collect();
    let high: Vec<i64> = center.iter().map(|c| (c + radius).floor() as i64).collect();
    if low.iter().zip(&high).any(|(l, h)| l > h) {
        return true;
    }
    let count: f64 = low.iter().zip(&high).map(|(l, h)| (h - l + 1) as f64).product();
    if count > most as f64 {
        return false;
    }
    let mut point = low.clone();
    loop {
        visit(&point.iter().map(|&v| v as f64).collect::<Vec<_>>());
        let Some(at) = (0..point.len()).find(|&i| point[i] < high[i]) else { return true };
        point[at] += 1;
        point[..at].copy_from_slice(&low[..at]);
    }
}

fn enumerate(case: &Case, center: &[f64], radius: f64) -> Option<f64> {
    let mut best = f64::INFINITY;
    let complete = for_each_point(center, radius, 3000, |point| {
        let given: Vec<(usize, f64)> = case.problem.integers.iter().copied().zip(point.iter().copied()).collect();
        if let Some(energy) = minimise(case, &given) {
            best = best.min(energy);
        }
    });
    complete.then_some(best)
}

fn exact(problem: &MixedIntegerProblem, options: ExactOptions) -> Result<quadloom_numeric::Solution, SolveError> {
    solve(problem, &SolveOptions { rounding: Rounding::Exact(options), ..Default::default() })
}

#[test]
fn exact_mode_equals_enumeration_on_1000_random_problems() {
    let (mut compared, mut infeasible, mut seed) = (0, 0, 0);
    while compared < 1000 {
        seed += 1;
        let case = random_case(seed);
        match exact(&case.problem, ExactOptions::default()) {
            Ok(solution) => {
                let Some(center) = relaxed(&case) else { panic!("seed {seed}: relaxation failed") };
                let excess = solution.energy - minimise(&case, &[]).unwrap();
                // No better point is farther away, as energy grows with the smallest eigenvalue.
                let radius = (2.0 * (excess + 1e-9) / SMALLEST_EIGENVALUE).sqrt();
                let Some(best) = enumerate(&case, &center, radius) else { continue };
                assert!((best - solution.energy).abs() < 1e-7, "seed {seed}: {} for {best}", solution.energy);
                assert!(case.problem.constraints.worst_violation(&solution.x).is_none_or(|(v, _)| v < 1e-9));
                assert!(case.problem.integers.iter().all(|&i| solution.x[i].fract() == 0.0));
                compared += 1;
            }
            Err(error) => {
                let nothing = enumerate(&case, &vec![0.0; case.problem.integers.len()], 2.0);
                assert!(nothing.is_none_or(|best| best == f64::INFINITY), "seed {seed}: {error} is wrong");
                infeasible += 1;
            }
        }
    }
    assert!(infeasible > 20, "the generator no longer makes infeasible problems: {infeasible}");
}

#[test]
fn all_strategies_agree_and_bounds_hold() {
    for seed in 5000..5150 {
        let case = random_case(seed);
        let Ok(reference) = exact(&case.problem, ExactOptions::default()) else { continue };
        for selection in [Selection::BestBound, Selection::DepthFirst] {
            for branching in [Branching::MinInfeasibility, Branching::MaxInfeasibility, Branching::PseudoCost] {
                let full = ExactOptions { selection, branching, ..Default::default() };
                assert!((exact(&case.problem, full).unwrap().energy - reference.energy).abs() < 1e-8);
                for limited in [ExactOptions { gap: 0.05, ..full }, ExactOptions { node_limit: Some(2), ..full }] {
                    let solution = exact(&case.problem, limited).unwrap();
                    let Some(report) = solution.report.exact else { continue };
                    assert!(report.lower_bound <= reference.energy + 1e-9);
                    assert!(
                        reference.energy <= solution.energy + 1e-9 && solution.energy <= report.greedy_energy + 1e-9
                    );
                    assert!(!report.proven || report.gap <= limited.gap + 1e-9);
                }
            }
        }
    }
}

#[test]
fn contradictions_are_named_by_label() {
    let mut constraints = Constraints::new();
    constraints.add(&[(0, 1.0), (1, 1.0)], 1.0, 70);
    constraints.add(&[(2, 1.0)], 1.0, 71);
    constraints.add(&[(0, 2.0), (1, 2.0)], 3.0, 72);
    let problem = MixedIntegerProblem { quadratic: Quadratic::new(3), constraints, integers: vec![] };
    let error = solve(&problem, &SolveOptions::default()).unwrap_err();
    assert!(matches!(error, SolveError::Contradiction { ref rows, .. } if *rows == [70, 72]), "{error}");
}
