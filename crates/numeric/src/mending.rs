//! Mending: single integers jump until no row is missed, and back where that costs nothing.
//!
//! In: the Schur complement S of the integers, their relaxed values z*, rows aᵀz ≥ b and integers that miss some. Out:
//! integers that miss fewer rows. Holds: deterministic, ties by index. Not guaranteed: that all rows are met, even where
//! integers exist that meet them; optimality.
//!
//! Source: [Luteberget2023] for jumps under growing row weights; the energy in the choice of a jump is ours.

use crate::bounded::LowerBound;
use crate::integer_problem::Precision;
use std::collections::BTreeSet;

/// Jumps and weight changes, per integer, after which mending gives up.
const STEPS_PER_INTEGER: usize = 30;

/// Of these there are at least so many.
const LEAST_STEPS: usize = 2000;

/// Coefficients that are looked at before mending gives up: about half a second.
///
/// Most conditions are mended within a hundredth of that.
const MOST_WORK: usize = 200_000_000;

/// What a jump's energy counts against missed rows at first: an integer that moves by one from its optimum, at the
/// median of the integers' stiffness, counts as much as a row that is missed by this.
const ENERGY_WEIGHT: f64 = 1.0;

/// Missed rows among which the best jump is looked for, in turn.
///
/// More: better jumps, each of which costs the more.
const WINDOW: usize = 8;

/// Jumps per integer that only lower the energy, once no row is missed.
const POLISHING_PER_INTEGER: usize = 10;

/// Integers under rows, one of which can jump.
struct Jumps<'a> {
    precision: &'a Precision,
    rows: &'a [LowerBound],
    /// Per integer its rows and coefficients.
    rows_of: Vec<Vec<(u32, f64)>>,
    z: Vec<f64>,
    /// Per row how much is missing; negative where there is some to spare.
    shortfall: Vec<f64>,
    /// Rows that are missed.
    missed: BTreeSet<u32>,
    /// Per row the coefficients that are looked at for the jumps that help it.
    looks: Vec<usize>,
    /// Per row what it counts.
    weight: Vec<f64>,
    /// S·(z − z*).
    slope: Vec<f64>,
    /// What energy counts.
    energy_weight: f64,
}

/// A row counts as met when it is missed by no more.
const SLACK: f64 = 1e-4;

/// Lets integers jump, one at a time, until no row is missed or the limit is reached.
///
/// # Output     the integers with the fewest missed rows that were seen, and the number of coefficients looked at
/// # Cost       a few thousand operations per jump, and k for k integers
pub(crate) fn mend(precision: &Precision, relaxed: &[f64], rows: &[LowerBound], start: &[f64]) -> (Vec<f64>, usize) {
    let mut jumps = Jumps::new(precision, relaxed, rows, start);
    let mut best = (jumps.missing(), start.to_vec());
    // 1. Jumps that lower the weighted sum of what is missing and of the energy; where there are none, missed rows
    //    come to count more.
    let mut after = 0;
    let (mut steps, mut work) = (LEAST_STEPS.max(STEPS_PER_INTEGER * start.len()), 0);
    while steps > 0 && work < MOST_WORK {
        steps -= 1;
        let window = jumps.missed_after(after);
        let Some(&last) = window.last() else { break };
        after = last + 1;
        work += window.iter().map(|&r| jumps.looks[r as usize]).sum::<usize>() + start.len();
        match jumps.best_for(&window) {
            Some((i, by)) => {
                jumps.jump(i, by);
                if jumps.missing() < best.0 - 0.5 {
                    best = (jumps.missing(), jumps.z.clone());
                }
            }
            None => window.iter().for_each(|&r| jumps.weight[r as usize] += 1.0),
        }
    }
    if !jumps.missed.is_empty() {
        return (best.1, work);
    }
    // 2. Jumps that lower the energy and leave all rows met.
    work += jumps.polish();
    (jumps.z, work)
}

impl<'a> Jumps<'a> {
    fn new(precision: &'a Precision, relaxed: &[f64], rows: &'a [LowerBound], start: &[f64]) -> Self {
        let k = start.len();
        let mut rows_of = vec![Vec::new(); k];
        for (row, r) in rows.iter().zip(0u32..) {
            row.terms.iter().for_each(|&(i, c)| rows_of[i as usize].push((r, c)));
        }
        let away: Vec<f64> = start.iter().zip(relaxed).map(|(z, r)| z - r).collect();
        let mut stiffness: Vec<f64> = (0..k).map(|i| precision.row(i)[i]).collect();
        stiffness.sort_by(f64::total_cmp);
        let median = stiffness.get(k / 2).copied().unwrap_or(1.0);
        let shortfall: Vec<f64> = rows.iter().map(|r| r.shortfall(start)).collect();
        let missed = (0u32..).zip(&shortfall).filter(|s| *s.1 > SLACK).map(|s| s.0).collect();
        let looks = |row: &LowerBound| 2 * row.terms.iter().map(|t| rows_of[t.0 as usize].len()).sum::<usize>();
        let looks = rows.iter().map(looks).collect();
        Self {
            precision,
            rows,
            rows_of,
            z: start.to_vec(),
            shortfall,
            missed,
            looks,
            weight: vec![1.0; rows.len()],
            slope: precision.times(&away),
            energy_weight: ENERGY_WEIGHT / median.max(f64::MIN_POSITIVE),
        }
    }

    /// What is missing in all.
    fn missing(&self) -> f64 {
        self.missed.iter().map(|&r| self.shortfall[r as usize]).sum()
    }

    /// The next missed rows in a round of all of them.
    fn missed_after(&self, first: u32) -> Vec<u32> {
        let round = self.missed.range(first..).chain(self.missed.range(..first));
        round.copied().take(WINDOW).collect()
    }

    /// The jump that lowers the weighted sum most, among those that help a missed row.
    fn best_for(&self, missed: &[u32]) -> Option<(usize, f64)> {
        let mut best: Option<(f64, usize, f64)> = None;
        for &r in missed {
            for &(i, c) in &self.rows[r as usize].terms {
                let whole = (self.shortfall[r as usize] / c.abs()).ceil().max(1.0) * c.signum();
                let unit = c.signum();
                for by in
                    if whole == unit { [Some(unit), None] } else { [Some(unit), Some(whole)] }.into_iter().flatten()
                {
                    let change = self.change(i as usize, by);
                    if best.is_none_or(|b| change < b.0) {
                        best = Some((change, i as usize, by));
                    }
                }
            }
        }
        best.filter(|b| b.0 < 0.0).map(|b| (b.1, b.2))
    }

    /// Change of the weighted sum under a jump.
    fn change(&self, i: usize, by: f64) -> f64 {
        let missing = |&(r, c): &(u32, f64)| {
            let before = self.shortfall[r as usize];
            self.weight[r as usize] * ((before - c * by).max(0.0) - before.max(0.0))
        };
        self.rows_of[i].iter().map(missing).sum::<f64>() + self.energy_weight * self.energy_change(i, by)
    }

    fn energy_change(&self, i: usize, by: f64) -> f64 {
        by * (self.slope[i] + 0.5 * by * self.precision.row(i)[i])
    }

    fn jump(&mut self, i: usize, by: f64) {
        self.z[i] += by;
        for &(r, c) in &self.rows_of[i] {
            self.shortfall[r as usize] -= c * by;
            if self.shortfall[r as usize] > SLACK {
                self.missed.insert(r);
            } else {
                self.missed.remove(&r);
            }
        }
        self.slope.iter_mut().zip(self.precision.row(i)).for_each(|(slope, s)| *slope += by * s);
    }

    /// # Output     the number of coefficients looked at
    fn polish(&mut self) -> usize {
        let k = self.z.len();
        for step in 0..POLISHING_PER_INTEGER * k {
            let allowed =
                |i: usize, by: f64| self.rows_of[i].iter().all(|&(r, c)| self.shortfall[r as usize] - c * by <= SLACK);
            let best = (0..k)
                .flat_map(|i| [(i, 1.0), (i, -1.0)])
                .map(|(i, by)| (self.energy_change(i, by), i, by))
                .filter(|&(change, i, by)| change < 0.0 && allowed(i, by))
                .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            let Some((_, i, by)) = best else { return (step + 1) * k };
            self.jump(i, by);
        }
        POLISHING_PER_INTEGER * k * k
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn identity(order: usize) -> Precision {
        Precision::of_entries((0..order * order).map(|k| f64::from(k % (order + 1) == 0)).collect(), order)
    }

    proptest! {
        /// Differences as between coordinates of neighbours, all of which a solution meets.
        #[test]
        fn rows_that_some_integers_meet_are_met(
            solution in prop::collection::vec(-4i32..=4, 6),
            pairs in prop::collection::vec((0usize..6, 0usize..6), 1..12),
            relaxed in prop::collection::vec(-4.0..4.0f64, 6),
        ) {
            let row = |&(i, j): &(usize, usize)| {
                let mut terms = vec![(i as u32, 1.0), (j as u32, -1.0)];
                terms.sort_by_key(|t| t.0);
                LowerBound { terms, least: f64::from(solution[i] - solution[j]) }
            };
            let rows: Vec<LowerBound> = pairs.iter().filter(|(i, j)| i != j).map(row).collect();
            let start: Vec<f64> = relaxed.iter().map(|z| z.round()).collect();
            let (mended, _) = mend(&identity(6), &relaxed, &rows, &start);
            prop_assert!(mended.iter().all(|z| *z == z.round()));
            prop_assert!(!rows.iter().any(|row| row.is_missed(&mended)), "{rows:?} by {mended:?}");
        }

        #[test]
        fn no_single_step_is_better_once_rows_are_met(relaxed in prop::collection::vec(-4.0..4.0f64, 4)) {
            let rows = [LowerBound { terms: vec![(0, 1.0), (2, 1.0)], least: 3.0 }];
            let (mended, _) = mend(&identity(4), &relaxed, &rows, &[0.0; 4]);
            let energy = |z: &[f64]| z.iter().zip(&relaxed).map(|(z, r)| 0.5 * (z - r) * (z - r)).sum::<f64>();
            for i in 0..4 {
                for by in [-1.0, 1.0] {
                    let mut other = mended.clone();
                    other[i] += by;
                    prop_assert!(rows[0].is_missed(&other) || energy(&other) >= energy(&mended) - 1e-9);
                }
            }
        }
    }

    #[test]
    fn rows_that_exclude_each_other_leave_the_fewest_missed() {
        let rows = [
            LowerBound { terms: vec![(0, 1.0)], least: 2.0 },
            LowerBound { terms: vec![(0, -1.0)], least: 0.0 },
            LowerBound { terms: vec![(1, 1.0)], least: 1.0 },
        ];
        let (mended, _) = mend(&identity(2), &[0.0; 2], &rows, &[0.0; 2]);
        assert_eq!(rows.iter().filter(|row| row.is_missed(&mended)).count(), 1);
        assert_eq!(mended[1], 1.0);
    }
}
