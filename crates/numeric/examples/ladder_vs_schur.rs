//! Times the adaptive ladder against the dense Schur complement on synthetic problems of both kinds.
//!
//! Run: `cargo run --release -p quadloom-numeric --example ladder_vs_schur [-- field|map]`
//!
//! Seconds are processor time of the one thread that works (wall-clock where the system does not tell).
#![allow(clippy::print_stdout)] // A program, not the library.

#[path = "../tests/common/models.rs"]
mod models;

use std::time::Instant;

use quadloom_numeric::{MixedIntegerProblem, Rounding, SolveOptions, Solver, Updates};

fn main() {
    let started = Instant::now();
    let wanted = std::env::args().nth(1).unwrap_or_default();
    println!("| problem | free | integers | method | seconds | warm | energy | rounds | GS | CG | Cholesky |");
    println!("|---|--:|--:|---|--:|--:|--:|--:|--:|--:|--:|");
    if wanted != "map" {
        for m in [10, 22, 32, 100] {
            compare(started, &format!("field {}", 2 * m * m), &models::field_problem(m, 0.6), 12_000 / m);
        }
    }
    if wanted != "field" {
        for (m, strips, features) in [(100, 5, 20), (100, 8, 150), (140, 8, 400), (140, 8, 1000), (140, 8, 3000)] {
            let problem = models::map_problem(m, strips, features, m as f64 / 30.0);
            compare(started, &format!("map {} with {features} features", 2 * m * m), &problem, 100);
        }
    }
}

/// Seconds this thread has been on a processor.
fn clock(started: Instant) -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanoseconds = text.split_whitespace().next().and_then(|word| word.parse::<f64>().ok());
    nanoseconds.map_or_else(|| started.elapsed().as_secs_f64(), |ns| ns * 1e-9)
}

/// Naive re-solving is tried only for few integers: it factorises once for each.
fn compare(started: Instant, name: &str, problem: &MixedIntegerProblem, naive_limit: usize) {
    for (method, rounding, updates) in [
        ("direct, two factorisations", Rounding::Direct, Updates::Ladder),
        ("direct, Schur", Rounding::Direct, Updates::Schur),
        ("greedy, ladder", Rounding::Greedy, Updates::Ladder),
        ("one by one, ladder", Rounding::GreedyOneByOne, Updates::Ladder),
        ("greedy, Schur", Rounding::Greedy, Updates::Schur),
        ("naive", Rounding::Naive, Updates::Ladder),
    ] {
        let begun = clock(started);
        let Ok(mut solver) = Solver::new(problem.quadratic.n(), &problem.constraints, &problem.integers) else {
            return;
        };
        let integers = solver.elimination().free_is_integer().iter().filter(|&&integer| integer).count();
        let skipped =
            (rounding == Rounding::Naive && integers > naive_limit) || (updates == Updates::Schur && integers > 3000);
        if skipped {
            continue;
        }
        let options = SolveOptions { rounding, updates, ..Default::default() };
        match solver.solve(&problem.quadratic, &options) {
            Ok(cold) => {
                let seconds = clock(started) - begun;
                let begun = clock(started);
                let warm = solver.solve(&problem.quadratic, &options).map_or(f64::NAN, |_| clock(started) - begun);
                let r = &cold.report;
                println!(
                    "| {name} | {} | {integers} | {method} | {seconds:.3} | {warm:.3} | {:.4} | {} | {} | {} | {} |",
                    r.free,
                    cold.energy,
                    r.rounds,
                    r.gauss_seidel_updates,
                    r.conjugate_gradient_iterations,
                    r.factorizations
                );
            }
            Err(error) => println!("| {name} | | {integers} | {method} | {error} |"),
        }
    }
}
