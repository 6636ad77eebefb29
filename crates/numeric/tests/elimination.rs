//! Elimination against dense Gauss on random rows.

mod common;

use common::gauss;
use proptest::prelude::*;
use quadloom_numeric::{Constraints, Elimination, SolveError};

const N: usize = 7;

fn rows() -> impl Strategy<Value = Vec<(Vec<f64>, f64)>> {
    let coefficient = prop_oneof![4 => Just(0i32), 2 => Just(1), 2 => Just(-1), 1 => -4i32..5];
    let row = (prop::collection::vec(coefficient.prop_map(f64::from), N), (-3i32..4).prop_map(f64::from));
    prop::collection::vec(row, 0..8)
}

fn constraints(rows: &[(Vec<f64>, f64)]) -> Constraints {
    let mut constraints = Constraints::new();
    for (label, (row, rhs)) in rows.iter().enumerate() {
        let terms: Vec<(usize, f64)> = row.iter().copied().enumerate().filter(|(_, c)| *c != 0.0).collect();
        constraints.add(&terms, *rhs, label);
    }
    constraints
}

fn augmented<'a>(rows: impl IntoIterator<Item = &'a (Vec<f64>, f64)>) -> Vec<Vec<f64>> {
    rows.into_iter().map(|(row, rhs)| row.iter().copied().chain([*rhs]).collect()).collect()
}

/// Rank by floating-point Gauss, independent of the crate.
fn rank(rows: &[(Vec<f64>, f64)]) -> usize {
    let mut m: Vec<Vec<f64>> = rows.iter().map(|(row, _)| row.clone()).collect();
    let mut rank = 0;
    for column in 0..N {
        let Some(pivot) = (rank..m.len()).find(|&r| m[r][column].abs() > 1e-9) else { continue };
        m.swap(rank, pivot);
        let top = m[rank].clone();
        for row in &mut m[rank + 1..] {
            let f = row[column] / top[column];
            row.iter_mut().zip(&top).for_each(|(a, b)| *a -= f * b);
        }
        rank += 1;
    }
    rank
}

/// All rows, to 1e-8, or to three digits above the rounding of the largest value.
fn holds(rows: &[(Vec<f64>, f64)], x: &[f64]) -> bool {
    let largest = x.iter().fold(0.0f64, |a, b| a.max(b.abs()));
    constraints(rows).worst_violation(x).is_none_or(|(v, _)| v < 1e-8f64.max(1e-13 * largest))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn continuous_rows_have_the_solution_set_of_dense_gauss(rows in rows(), y in prop::collection::vec(-5.0..5.0, N)) {
        let solvable = gauss(augmented(&rows), N).is_some();
        match Elimination::eliminate(N, &constraints(&rows), &[false; N]) {
            Ok(done) => {
                prop_assert!(solvable);
                prop_assert_eq!(done.free().len(), N - rank(&rows));
                prop_assert_eq!(done.dependent().len(), rows.len() - rank(&rows));
                let x = done.expand(&y[..done.free().len()]);
                prop_assert!(holds(&rows, &x), "{x:?}");
                prop_assert!(done.restrict(&x).iter().zip(&y).all(|(a, b)| (a - b).abs() < 1e-9));
            }
            Err(SolveError::Contradiction { rows: named, .. }) => {
                prop_assert!(!solvable);
                let named: Vec<_> = named.iter().map(|&label| rows[label].clone()).collect();
                prop_assert!(gauss(augmented(&named), N).is_none(), "the named rows do not contradict");
            }
            Err(error) => prop_assert!(false, "{error}"),
        }
    }

    #[test]
    fn integer_rows_give_exact_integers(rows in rows(), flags in prop::collection::vec(any::<bool>(), N), y in prop::collection::vec(-9i32..10, N + 8)) {
        let Ok(done) = Elimination::eliminate(N, &constraints(&rows), &flags) else { return Ok(()) };
        let value = |(k, integer): (usize, &bool)| f64::from(y[k]) + if *integer { 0.0 } else { 0.37 };
        let y: Vec<f64> = done.free_is_integer().iter().enumerate().map(value).collect();
        let x = done.expand(&y);
        prop_assert!(holds(&rows, &x), "{x:?}");
        prop_assert!((0..N).filter(|&i| flags[i]).all(|i| x[i].fract() == 0.0), "{x:?}");
    }
}

/// A chain of seams as on a cut mesh: the cost must stay near linear.
#[test]
fn long_chains_of_seam_rows_are_eliminated_quickly() {
    let count = 60_000;
    let mut constraints = Constraints::new();
    for k in 0..count {
        constraints.add(&[(k, 1.0), (k + 1, -1.0), (count + 1 + k % 50, 1.0)], 0.0, k);
    }
    let n = count + 51;
    let is_integer: Vec<bool> = (0..n).map(|i| i > count).collect();
    let started = std::time::Instant::now();
    let done = Elimination::eliminate(n, &constraints, &is_integer).unwrap();
    assert_eq!(done.free().len(), 51);
    assert!(done.free_is_integer().iter().filter(|&&integer| integer).count() == 50);
    assert!(started.elapsed().as_secs_f64() < 5.0, "{:?}", started.elapsed());
}

/// Integers that come out above ten million: the rows hold to the digits that such numbers have.
#[test]
fn rows_of_large_integers_hold_to_their_digits() {
    let rows: Vec<(Vec<f64>, f64)> = vec![
        (vec![-1.0, 0.0, 1.0, -1.0, 0.0, -2.0, 0.0], 2.0),
        (vec![0.0, 1.0, 0.0, 3.0, 0.0, 0.0, -1.0], 1.0),
        (vec![1.0, -1.0, -1.0, 0.0, -3.0, 1.0, 0.0], 0.0),
        (vec![0.0, 1.0, -1.0, 1.0, 1.0, -4.0, -1.0], 0.0),
        (vec![-1.0, 1.0, -1.0, 0.0, -4.0, 1.0, -1.0], -2.0),
        (vec![3.0, 0.0, 0.0, -1.0, -1.0, -1.0, -1.0], 0.0),
    ];
    let flags = [false, true, true, false, true, false, true];
    if let Ok(done) = Elimination::eliminate(N, &constraints(&rows), &flags) {
        let x = done.expand(&vec![0.0; done.free().len()]);
        assert!(x.iter().any(|x| x.abs() > 1e6), "not the case it was: {x:?}");
        assert!(holds(&rows, &x), "{x:?}");
    }
}
