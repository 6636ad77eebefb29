//! Conditions on integers, and integers that meet them.
//!
//! In: lengths of arcs over the free integers, what integer vertices see. Out: rows of lower bounds, and integers chosen
//! under them: rounded, mended, improved. Holds: what [`Conditions::missed`] does not name is met exactly.
//! Source: the validity conditions of [Campen2015] §4 as rows; roundings of [Bommes2012] §5.2.2 under them.

use crate::sight::Sight;
use crate::tmesh::{Form, TMesh};
use quadloom_numeric::{IntegerProblem, IntegerSum, LowerBound, SolveError, SolveOptions};
use std::collections::BTreeMap;

/// Quads by which a missed row is to be longer in the next round.
///
/// Smaller: more rounds. Larger: quads are stretched where half a quad would have been enough.
const MARGIN_STEP: f64 = 0.5;

/// A row that is missed with this margin, in quads, is not a matter of rounding.
const LARGEST_MARGIN: f64 = 3.0;

/// Lengths of arcs over the free integers.
pub(crate) struct Lengths {
    /// Per arc its sum and constant; `None` where its length is not a matter of integers alone.
    of_arc: Vec<Option<IntegerSum>>,
}

impl Lengths {
    /// Forms of the arcs over the free integers.
    pub fn new(tmesh: &TMesh, problem: &IntegerProblem) -> Self {
        let over = |form: &Form| problem.over_integers(form.iter().map(|&(i, c)| (i as usize, f64::from(c))));
        Self { of_arc: tmesh.arcs.iter().map(|arc| over(&arc.form)).collect() }
    }

    /// The lengths, in quads; infinite where they are not a matter of integers alone.
    pub fn values(&self, z: &[f64]) -> Vec<f64> {
        let value = |sum: &IntegerSum| sum.value(z).round();
        self.of_arc.iter().map(|arc| arc.as_ref().map_or(f64::INFINITY, value)).collect()
    }

    /// The sum of some arcs is to be at least `least`; `None` where no choice of integers changes it.
    pub fn bound(&self, arcs: &[usize], least: f64) -> Option<LowerBound> {
        let (mut sum, mut constant) = (BTreeMap::<u32, f64>::new(), 0.0);
        for &i in arcs {
            let length = self.of_arc[i].as_ref()?;
            constant += length.constant;
            length.terms.iter().for_each(|&(k, c)| *sum.entry(k).or_insert(0.0) += c);
        }
        let terms: Vec<(u32, f64)> = sum.into_iter().filter(|t| t.1.abs() > 1e-9).collect();
        (!terms.is_empty()).then_some(LowerBound { terms, least: least - constant })
    }
}

/// What one integer vertex sees, over the free integers.
pub(crate) struct Difference {
    /// Must not all be zero.
    sums: Vec<IntegerSum>,
    /// The largest of them in the seamless map, and its sign there.
    largest: usize,
    sign: f64,
}

impl Difference {
    /// `None` where it is not a matter of integers alone, or of none.
    pub fn new(sight: &Sight, problem: &IntegerProblem) -> Option<Self> {
        let over = |form: &Form| problem.over_integers(form.iter().map(|&(i, c)| (i as usize, f64::from(c))));
        let sums: Vec<IntegerSum> = sight.ways.iter().map(|w| over(&w.1)).collect::<Option<_>>()?;
        let ways = || sight.ways.iter().map(|w| w.0).enumerate();
        let (largest, way) = ways().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()).then(b.0.cmp(&a.0)))?;
        (!sums[largest].terms.is_empty()).then_some(Self { sums, largest, sign: way.signum() })
    }

    /// Whether the two coincide.
    pub fn is_zero(&self, z: &[f64]) -> bool {
        self.sums.iter().all(|sum| sum.value(z).abs() < 0.5)
    }

    /// The row that keeps the two apart, in the direction in which they are.
    pub fn apart(&self) -> LowerBound {
        let sum = &self.sums[self.largest];
        let terms = sum.terms.iter().map(|&(i, c)| (i, self.sign * c)).collect();
        LowerBound { terms, least: 1.0 - self.sign * sum.constant }
    }
}

/// Rows that the integers are to meet.
#[derive(Clone)]
pub(crate) struct Conditions {
    rows: Vec<LowerBound>,
    /// Per row how much longer it is asked to be, because rounding missed it.
    margin: Vec<f64>,
    /// The first rows are those of single arcs.
    arcs: usize,
}

impl Conditions {
    /// Equal lengths are one row.
    pub fn of_arcs(tmesh: &TMesh, lengths: &Lengths) -> Self {
        let mut rows: Vec<LowerBound> = (0..tmesh.arcs.len()).filter_map(|i| lengths.bound(&[i], 0.0)).collect();
        rows.sort_by_cached_key(|row| row.terms.iter().map(|t| (t.0, t.1.to_bits())).collect::<Vec<_>>());
        rows.dedup_by(|b, a| {
            a.terms == b.terms && {
                a.least = a.least.max(b.least);
                true
            }
        });
        Self { margin: vec![0.0; rows.len()], arcs: rows.len(), rows }
    }

    /// Rows beyond those of single arcs.
    pub fn prescribed(&self) -> usize {
        self.rows.len() - self.arcs
    }

    /// Rows that are missed.
    pub fn missed(&self, z: &[f64]) -> Vec<usize> {
        (0..self.rows.len()).filter(|&r| self.rows[r].is_missed(z)).collect()
    }

    /// What is missing in all.
    fn shortfall(&self, z: &[f64]) -> f64 {
        self.rows.iter().map(|r| r.shortfall(z).max(0.0)).sum()
    }

    /// Adds rows; whether there was a new one.
    pub fn add(&mut self, rows: impl Iterator<Item = LowerBound>) -> bool {
        let before = self.rows.len();
        for row in rows {
            if !self.rows[self.arcs..].contains(&row) {
                self.rows.push(row);
                self.margin.push(0.0);
            }
        }
        self.rows.len() > before
    }

    /// All integers, under the rows where that does not take too long.
    pub fn round(&self, problem: &IntegerProblem, solve: &SolveOptions) -> Result<Vec<f64>, SolveError> {
        let rows = if problem.len() <= MOST_UNDER_ROWS { &self.rows[..] } else { &[] };
        problem.round(rows, &[], solve)
    }

    /// Lets integers jump from where they are and from a new rounding; the better one is taken, if it misses less.
    pub fn mend(&self, z: &mut Vec<f64>, problem: &IntegerProblem, solve: &SolveOptions) -> Result<bool, SolveError> {
        let mut better = problem.mend(&self.rows, z);
        if problem.len() <= MOST_UNDER_ROWS && self.shortfall(&better) > 0.5 {
            let anew = problem.mend(&self.rows, &problem.round(&self.rows, &[], solve)?);
            let cost = |z: &[f64]| (self.shortfall(z).round(), problem.excess(z));
            if cost(&anew) < cost(&better) {
                better = anew;
            }
        }
        let helps = self.shortfall(&better) < self.shortfall(z) - 0.5;
        if helps {
            *z = better;
        }
        Ok(helps)
    }

    /// Rounds again with more room for the rows that are missed; `false` where there has been enough of that.
    pub fn widen(
        &mut self,
        z: &mut Vec<f64>,
        problem: &IntegerProblem,
        solve: &SolveOptions,
    ) -> Result<bool, SolveError> {
        let missed = self.missed(z);
        if problem.len() > MOST_UNDER_ROWS || missed.iter().all(|&r| self.margin[r] >= LARGEST_MARGIN) {
            return Ok(false);
        }
        missed.into_iter().for_each(|r| self.margin[r] += MARGIN_STEP);
        let wider = |(r, m): (&LowerBound, &f64)| LowerBound { least: r.least + m, ..r.clone() };
        let wanted: Vec<LowerBound> = self.rows.iter().zip(&self.margin).map(wider).collect();
        *z = problem.mend(&self.rows, &problem.round(&wanted, &[], solve)?);
        Ok(true)
    }

    /// Chooses integers again, one neighbourhood after the other, where all rows stay met.
    pub fn improve(&self, z: &mut Vec<f64>, problem: &IntegerProblem, solve: &SolveOptions) -> Result<(), SolveError> {
        let mut rows_of = vec![Vec::new(); z.len()];
        for (row, r) in self.rows.iter().zip(0u32..) {
            row.terms.iter().for_each(|t| rows_of[t.0 as usize].push(r));
        }
        let before = problem.excess(z);
        let mut least = before;
        let mut settled = vec![false; z.len()];
        for root in 0..z.len() {
            if settled[root] {
                continue;
            }
            let near = self.neighbourhood(root, &rows_of, z);
            near.iter().take(NEIGHBOURHOOD / 2).for_each(|&i| settled[i] = true);
            let mut free = vec![false; z.len()];
            near.iter().for_each(|&i| free[i] = true);
            let kept: Vec<(usize, f64)> = (0..z.len()).filter(|&i| !free[i]).map(|i| (i, z[i])).collect();
            let mut other = problem.round(&self.rows, &kept, solve)?;
            if !self.missed(&other).is_empty() {
                other = problem.mend(&self.rows, &other);
            }
            let excess = problem.excess(&other);
            if excess < least - 1e-9 * before && self.missed(&other).is_empty() {
                (least, *z) = (excess, other);
            }
        }
        Ok(())
    }

    /// Integers around one, nearest first, that rows without room to spare tie to each other.
    fn neighbourhood(&self, root: usize, rows_of: &[Vec<u32>], z: &[f64]) -> Vec<usize> {
        let mut near = vec![root];
        let mut known = vec![false; z.len()];
        known[root] = true;
        let mut next = 0;
        while next < near.len() && near.len() < NEIGHBOURHOOD {
            let tight = rows_of[near[next]].iter().map(|&r| &self.rows[r as usize]).filter(|r| r.shortfall(z) > -TIGHT);
            for &(i, _) in tight.flat_map(|row| &row.terms) {
                if !std::mem::replace(&mut known[i as usize], true) && near.len() < NEIGHBOURHOOD {
                    near.push(i as usize);
                }
            }
            next += 1;
        }
        near
    }
}

/// More integers than this are rounded without rows, and what they miss is left to jumps: multipliers of a thousand
/// rows take longer than all else.
const MOST_UNDER_ROWS: usize = 400;

/// A row with no more than this to spare, in quads, ties its integers to each other.
const TIGHT: f64 = 1.5;

/// Integers that are chosen again together.
///
/// Fewer: less is gained; more: a rounding costs their third power.
const NEIGHBOURHOOD: usize = 40;
