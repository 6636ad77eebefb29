//! The whole solver: levels and methods against each other, warm solves, given values, determinism.

mod common {
    pub mod models;
}

use common::models::{field_problem, map_problem, noise};
use quadloom_numeric::{
    Constraints, ExactOptions, LadderOptions, MixedIntegerProblem, Quadratic, Rounding, Solution, SolveError,
    SolveOptions, Solver, Updates, solve,
};

fn run(problem: &MixedIntegerProblem, rounding: Rounding, updates: Updates) -> Solution {
    solve(problem, &SolveOptions { rounding, updates, ..Default::default() }).unwrap()
}

fn run_ladder(problem: &MixedIntegerProblem, ladder: LadderOptions) -> Solution {
    let rounding = Rounding::GreedyOneByOne;
    solve(problem, &SolveOptions { rounding, updates: Updates::Ladder, ladder, ..Default::default() }).unwrap()
}

fn samples() -> Vec<MixedIntegerProblem> {
    vec![field_problem(6, 0.6), field_problem(9, 1.0), map_problem(15, 3, 8, 1.3), map_problem(20, 4, 15, 2.0)]
}

fn assert_admissible(problem: &MixedIntegerProblem, solution: &Solution) {
    let (violation, label) = problem.constraints.worst_violation(&solution.x).unwrap();
    assert!(violation < 1e-9, "row {label} misses by {violation}");
    assert!(problem.integers.iter().all(|&i| solution.x[i].fract() == 0.0));
    assert!((problem.quadratic.energy(&solution.x) - solution.energy).abs() < 1e-9);
}

#[test]
fn every_level_of_the_ladder_and_the_schur_complement_agree() {
    let tight = LadderOptions { tolerance: 1e-10, gauss_seidel_limit: usize::MAX, ..Default::default() };
    for problem in samples() {
        let naive = run(&problem, Rounding::Naive, Updates::Ladder);
        let gauss_seidel = run_ladder(&problem, tight);
        assert!(gauss_seidel.report.gauss_seidel_updates > 0 && gauss_seidel.report.conjugate_gradient_iterations == 0);
        let gradients =
            run_ladder(&problem, LadderOptions { gauss_seidel_limit: 0, conjugate_gradient_limit: 100_000, ..tight });
        assert!(gradients.report.gauss_seidel_updates == 0 && gradients.report.conjugate_gradient_iterations > 0);
        let cholesky =
            run_ladder(&problem, LadderOptions { gauss_seidel_limit: 0, conjugate_gradient_limit: 0, ..tight });
        assert!(cholesky.report.factorizations > 2);
        let schur = run(&problem, Rounding::Greedy, Updates::Schur);
        assert!(schur.report.schur && schur.report.factorizations == 1);
        for solution in [&gauss_seidel, &gradients, &cholesky, &schur, &naive] {
            assert_admissible(&problem, solution);
            assert!((solution.energy - naive.energy).abs() < 1e-6 * naive.energy, "{:?}", solution.report);
        }
    }
}

/// The optimum for the integers chosen: every free direction is stationary.
#[test]
fn the_continuous_variables_end_at_their_optimum() {
    for problem in samples() {
        for (rounding, updates) in [(Rounding::Direct, Updates::Schur), (Rounding::Greedy, Updates::Ladder)] {
            let solution = run(&problem, rounding, updates);
            let fixed: Vec<(usize, f64)> = problem.integers.iter().map(|&i| (i, solution.x[i])).collect();
            let options = SolveOptions { rounding: Rounding::Relaxed, fixed: &fixed, ..Default::default() };
            let best = solve(&problem, &options).unwrap();
            assert!((solution.energy - best.energy).abs() < 1e-8 * (1.0 + best.energy));
        }
    }
}

#[test]
fn greedy_beats_direct_and_blocks_cost_little() {
    let (mut wins, mut total_block, mut total_single, cases) = (0, 0.0, 0.0, 30);
    for k in 0..cases {
        let problem = field_problem(8 + k % 5, 0.4 + 0.03 * k as f64);
        let direct = run(&problem, Rounding::Direct, Updates::Ladder).energy;
        let greedy = run(&problem, Rounding::Greedy, Updates::Ladder);
        assert!(greedy.report.rounds < greedy.report.roundings, "no blocks were formed");
        wins += usize::from(greedy.energy <= direct);
        total_block += greedy.energy;
        total_single += run(&problem, Rounding::GreedyOneByOne, Updates::Schur).energy;
    }
    assert!(wins * 10 >= cases * 9, "greedy no worse than direct on {wins} of {cases} only");
    assert!((total_block / total_single - 1.0).abs() < 0.02, "{total_block} for {total_single}");
}

#[test]
fn steps_after_rounding_lower_the_energy_and_leave_few_that_would() {
    let (mut kept, mut better, mut tried) = (0, 0, 0);
    for k in 0..6 {
        let problem = field_problem(9, 0.5 + 0.1 * k as f64);
        // A coarse tolerance rounds badly, so that there is something to mend; one by one is not followed by steps.
        let ladder = LadderOptions { tolerance: 0.05, exact_after_rel: f64::INFINITY, ..Default::default() };
        let options = SolveOptions { updates: Updates::Ladder, ladder, block_limit: 0.0, ..Default::default() };
        let rounded = solve(&problem, &SolveOptions { rounding: Rounding::GreedyOneByOne, ..options }).unwrap();
        let stepped = solve(&problem, &SolveOptions { rounding: Rounding::Greedy, ..options }).unwrap();
        assert_admissible(&problem, &stepped);
        assert!(stepped.energy <= rounded.energy + 1e-9, "{} after {}", stepped.energy, rounded.energy);
        kept += stepped.report.steps;
        // Every single step, by an exact solve.
        for &i in &problem.integers {
            for by in [-1.0, 1.0] {
                let value = |&j: &usize| (j, stepped.x[j] + if i == j { by } else { 0.0 });
                let fixed: Vec<(usize, f64)> = problem.integers.iter().map(value).collect();
                let options = SolveOptions { rounding: Rounding::Relaxed, fixed: &fixed, ..Default::default() };
                // A row may tie the integer to others.
                let Ok(there) = solve(&problem, &options) else { continue };
                better += usize::from(there.energy < stepped.energy - 1e-3);
                tried += 1;
            }
        }
    }
    assert!(
        kept > 0 && tried > 1000 && better * 100 < tried,
        "{kept} steps; {better} of {tried} further ones would pay"
    );
}

#[test]
fn exact_mode_proves_the_gap_of_greedy() {
    let problem = map_problem(12, 3, 6, 0.9);
    let greedy = run(&problem, Rounding::Greedy, Updates::Schur);
    let exact = run(&problem, Rounding::Exact(ExactOptions::default()), Updates::Auto);
    let report = exact.report.exact.unwrap();
    assert_admissible(&problem, &exact);
    assert!(report.proven && exact.energy <= greedy.energy + 1e-9);
    assert!((report.greedy_energy - greedy.energy).abs() < 1e-8);
    assert!((report.lower_bound - exact.energy).abs() < 1e-8);
}

#[test]
fn equal_input_gives_equal_bytes_on_any_thread() {
    for problem in samples() {
        for updates in [Updates::Schur, Updates::Ladder] {
            let here = run(&problem, Rounding::Greedy, updates);
            let there =
                std::thread::scope(|scope| scope.spawn(|| run(&problem, Rounding::Greedy, updates)).join().unwrap());
            assert!(here.x.iter().zip(&there.x).all(|(a, b)| a.to_bits() == b.to_bits()));
        }
    }
}

#[test]
fn a_warm_solve_equals_a_cold_one() {
    let problem = map_problem(24, 3, 12, 1.3);
    let mut stiffened = Quadratic::new(problem.quadratic.n());
    for (k, square) in problem.quadratic.squares().enumerate() {
        stiffened.add_square(square.terms, square.target, square.weight * (1.5 + noise(k, 1)));
    }
    for updates in [Updates::Schur, Updates::Ladder] {
        let options = SolveOptions { updates, ..Default::default() };
        let mut solver = Solver::new(problem.quadratic.n(), &problem.constraints, &problem.integers).unwrap();
        assert!(!solver.solve(&problem.quadratic, &options).unwrap().report.warm);
        let warm = solver.solve(&stiffened, &options).unwrap();
        assert!(warm.report.warm);
        let cold = MixedIntegerProblem { quadratic: stiffened.clone(), ..problem.clone() };
        assert_eq!(warm.x, solve(&cold, &options).unwrap().x);
    }
}

#[test]
fn given_values_are_kept_and_checked() {
    let problem = map_problem(24, 3, 12, 1.3);
    let greedy = run(&problem, Rounding::Greedy, Updates::Auto);
    let mut solver = Solver::new(problem.quadratic.n(), &problem.constraints, &problem.integers).unwrap();
    let is_integer = solver.elimination().free_is_integer().to_vec();
    let integers = solver.elimination().free().iter().zip(is_integer).filter(|(_, integer)| *integer).step_by(2);
    let free: Vec<(usize, f64)> = integers.map(|(&i, _)| (i as usize, greedy.x[i as usize] + 1.0)).collect();
    assert!(free.len() > 3);
    let mut with =
        |fixed: &[(usize, f64)]| solver.solve(&problem.quadratic, &SolveOptions { fixed, ..Default::default() });
    let moved = with(&free).unwrap();
    assert_admissible(&problem, &moved);
    assert!(free.iter().all(|&(i, value)| moved.x[i] == value));
    // A continuous vertex that a seam ties to others is no free variable: it becomes a row.
    let vertex = with(&[(200, 0.25), (201, 0.5)]).unwrap();
    assert!((vertex.x[200] - 0.25).abs() < 1e-9 && (vertex.x[201] - 0.5).abs() < 1e-9);
    assert!(matches!(with(&[(free[0].0, 0.5)]), Err(SolveError::NoIntegerSolution { .. })));
    assert!(matches!(with(&[(0, 3.0)]), Err(SolveError::Contradiction { .. })));
    assert!(matches!(with(&[(usize::MAX, 3.0)]), Err(SolveError::VariableOutOfRange { .. })));
}

#[test]
fn undetermined_variables_and_cancellation_are_errors() {
    let mut problem = MixedIntegerProblem { quadratic: Quadratic::new(3), ..Default::default() };
    problem.quadratic.add_square(&[(0, 1.0), (2, -1.0)], 1.0, 1.0);
    problem.quadratic.add_square(&[(1, 1.0)], 1.0, 1.0);
    let error = solve(&problem, &SolveOptions::default()).unwrap_err();
    assert!(matches!(error, SolveError::NotPositiveDefinite { variable: 0 | 2 }), "{error}");
    let stop = || true;
    let options = SolveOptions { cancelled: Some(&stop), ..Default::default() };
    assert_eq!(solve(&field_problem(5, 0.5), &options).unwrap_err(), SolveError::Cancelled);
    let mut bad = Quadratic::new(1);
    bad.add(0, 1, 1.0);
    let problem = MixedIntegerProblem { quadratic: bad, constraints: Constraints::new(), integers: vec![] };
    assert!(matches!(solve(&problem, &SolveOptions::default()), Err(SolveError::VariableOutOfRange { .. })));
}

#[test]
fn a_problem_without_unknowns_is_solved() {
    let mut problem = MixedIntegerProblem { quadratic: Quadratic::new(1), integers: vec![0], ..Default::default() };
    problem.quadratic.add_square(&[(0, 1.0)], 0.0, 1.0);
    problem.constraints.fix(0, 3.0, 0);
    assert_eq!(solve(&problem, &SolveOptions::default()).unwrap().energy, 9.0);
    let nothing = MixedIntegerProblem { quadratic: Quadratic::new(0), ..Default::default() };
    assert_eq!(solve(&nothing, &SolveOptions::default()).unwrap().energy, 0.0);
}
