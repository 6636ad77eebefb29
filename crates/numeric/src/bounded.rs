//! Greedy rounding under lower bounds: integers near their relaxation for which given sums do not fall below limits.
//!
//! In: the covariance S⁻¹ of the integers, their relaxed values z*, rows aᵀz ≥ b. Out: integers and the rows that they
//! miss. Holds: every rounding is followed by the exact minimum of ½(z − z*)ᵀS(z − z*) over the fixed integers, and by
//! its minimum over the rows to a tolerance; sequential, ties by index. Not guaranteed: that all rows are met, even
//! where integers exist that meet them; optimality.
//!
//! Source: [Bommes2012] §5.2.2 for the order of rounding; the multipliers of the rows by [LawsonHanson1974] ch. 23.

use crate::rounding::nearest_integer;

/// aᵀz ≥ b.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LowerBound {
    /// Numbers of integers with their coefficients, ascending.
    pub terms: Vec<(u32, f64)>,
    /// b.
    pub least: f64,
}

impl LowerBound {
    /// Whether integers miss it.
    pub fn is_missed(&self, z: &[f64]) -> bool {
        self.value(z) < self.least - SLACK
    }

    /// How much is missing; negative where there is some to spare.
    pub fn shortfall(&self, z: &[f64]) -> f64 {
        self.least - self.value(z)
    }

    fn value(&self, z: &[f64]) -> f64 {
        self.terms.iter().map(|&(i, c)| c * z[i as usize]).sum()
    }
}

/// By how much a row may be missed before its multiplier is changed, and by how much in the end.
const SLACK: f64 = 1e-4;

/// A row that the fixed integers determine to this variance is constant.
const CONSTANT: f64 = 1e-9;

/// Relative addition to the rows' own coupling: rows that depend on each other stay solvable, and those that exclude
/// each other show as missed.
const REGULARISATION: f64 = 1e-9;

/// Relaxed integers under fixings and rows.
struct State {
    /// S⁻¹ conditioned on what is fixed, row by row.
    covariance: Vec<f64>,
    /// Optimum under the fixings, without the rows.
    unbounded: Vec<f64>,
    /// Optimum under both.
    z: Vec<f64>,
    free: Vec<bool>,
    active: Vec<Active>,
    /// aᵢᵀ·G·aⱼ of the active rows.
    coupling: Vec<Vec<f64>>,
    /// Multiplications, but for a factor of about two.
    effort: usize,
}

/// What rounding under rows gave.
#[derive(Debug)]
pub(crate) struct Bounded {
    /// The integers.
    pub integers: Vec<f64>,
    /// Multiplications, but for a factor of about two.
    pub effort: usize,
}

/// A row that was found violated, with its multiplier.
struct Active {
    row: u32,
    multiplier: f64,
    /// G·a.
    response: Vec<f64>,
}

/// Rounds all integers, nearest first, each to the nearest integer of the optimum under the rows.
///
/// # Input      covariance: S⁻¹, k × k, row by row; relaxed: z*
/// # Output     `None` where cancelled
/// # Cost       k³ multiplications, and per rounding a few factorisations over the rows in force
pub(crate) fn round_bounded(
    covariance: Vec<f64>,
    relaxed: &[f64],
    rows: &[LowerBound],
    cancelled: &dyn Fn() -> bool,
) -> Option<Bounded> {
    let mut state = State {
        covariance,
        unbounded: relaxed.to_vec(),
        z: relaxed.to_vec(),
        free: vec![true; relaxed.len()],
        active: Vec::new(),
        coupling: Vec::new(),
        effort: 0,
    };
    state.settle(rows);
    while let Some(j) = state.nearest() {
        if cancelled() {
            return None;
        }
        state.condition(j, nearest_integer(state.z[j]));
        state.settle(rows);
    }
    Some(Bounded { integers: state.z.iter().map(|z| z.round()).collect(), effort: state.effort })
}

impl State {
    fn len(&self) -> usize {
        self.z.len()
    }

    /// The free integer whose value is nearest to an integer.
    fn nearest(&self) -> Option<usize> {
        let deviation = |i: &usize| (self.z[*i] - nearest_integer(self.z[*i])).abs();
        (0..self.len())
            .filter(|&i| self.free[i])
            .min_by(|a, b| (deviation(a) / SLACK).round().total_cmp(&(deviation(b) / SLACK).round()).then(a.cmp(b)))
    }

    /// Fixes an integer and moves the others to their optimum without the rows.
    fn condition(&mut self, j: usize, value: f64) {
        let k = self.len();
        let column: Vec<f64> = (0..k).map(|i| self.covariance[i * k + j]).collect();
        let pivot = column[j];
        self.free[j] = false;
        if pivot > CONSTANT * CONSTANT {
            self.effort += k * (k + self.active.len());
            // 1. The other integers and their covariance.
            let shift = (value - self.unbounded[j]) / pivot;
            for i in (0..k).filter(|&i| column[i] != 0.0) {
                self.unbounded[i] += column[i] * shift;
                let factor = column[i] / pivot;
                let row = &mut self.covariance[i * k..(i + 1) * k];
                row.iter_mut().zip(&column).for_each(|(g, c)| *g -= factor * c);
            }
            // 2. The responses of the active rows and their coupling.
            let along: Vec<f64> = self.active.iter().map(|a| a.response[j]).collect();
            for (active, along) in self.active.iter_mut().zip(&along) {
                let factor = along / pivot;
                active.response.iter_mut().zip(&column).for_each(|(r, c)| *r -= factor * c);
            }
            for (row, a) in self.coupling.iter_mut().zip(&along) {
                row.iter_mut().zip(&along).for_each(|(h, b)| *h -= a * b / pivot);
            }
        }
        self.unbounded[j] = value;
    }

    /// Multipliers of all rows at the given fixings.
    fn settle(&mut self, rows: &[LowerBound]) {
        loop {
            self.multiply(rows);
            self.place();
            self.effort += (self.len() + rows.len()) * (1 + self.active.len() / 4);
            // Rows that have come to be missed join in.
            let missed = |r: usize| rows[r].least - rows[r].value(&self.z);
            let known: Vec<u32> = self.active.iter().map(|a| a.row).collect();
            let fresh: Vec<u32> = (0..rows.len())
                .filter(|&r| missed(r) > SLACK)
                .map(|r| r as u32)
                .filter(|r| !known.contains(r))
                .collect();
            if fresh.is_empty() {
                return;
            }
            fresh.into_iter().for_each(|r| self.activate(r, rows));
        }
    }

    fn activate(&mut self, row: u32, rows: &[LowerBound]) {
        let k = self.len();
        let terms = &rows[row as usize].terms;
        let mut response = vec![0.0; k];
        for &(i, c) in terms {
            let column = &self.covariance[i as usize * k..(i as usize + 1) * k];
            response.iter_mut().zip(column).for_each(|(r, g)| *r += c * g);
        }
        let coupled: Vec<f64> = self.active.iter().map(|a| dot(&rows[a.row as usize].terms, &response)).collect();
        let own = dot(terms, &response);
        for (line, &h) in self.coupling.iter_mut().zip(&coupled) {
            line.push(h);
        }
        self.coupling.push(coupled.into_iter().chain([own]).collect());
        self.active.push(Active { row, multiplier: 0.0, response });
    }

    /// Multipliers of the active rows, each at least 0: an active-set method on the dual, started from the last one.
    fn multiply(&mut self, rows: &[LowerBound]) {
        let m = self.active.len();
        // How much each row is missed without multipliers.
        let missing: Vec<f64> = self
            .active
            .iter()
            .map(|a| rows[a.row as usize].least - rows[a.row as usize].value(&self.unbounded))
            .collect();
        let mut multiplier: Vec<f64> = self.active.iter().map(|a| a.multiplier).collect();
        let movable = |i: usize| self.coupling[i][i] >= CONSTANT;
        let mut pushing: Vec<usize> = (0..m).filter(|&i| multiplier[i] > 0.0 && movable(i)).collect();
        for _ in 0..3 * m + 10 {
            // 1. The pushing rows at equality; back to the first multiplier that would turn negative.
            let target = self.solve_for(&pushing, &missing);
            self.effort += pushing.len().pow(3) / 6 + pushing.len() * m;
            let step = pushing
                .iter()
                .zip(&target)
                .filter(|(_, t)| **t < 0.0)
                .map(|(&i, t)| multiplier[i] / (multiplier[i] - t))
                .fold(1.0, f64::min);
            for (&i, t) in pushing.iter().zip(&target) {
                multiplier[i] += step * (t - multiplier[i]);
            }
            if step < 1.0 {
                for &i in &pushing {
                    if multiplier[i] <= 1e-12 {
                        multiplier[i] = 0.0;
                    }
                }
                pushing.retain(|&i| multiplier[i] > 0.0);
                continue;
            }
            // 2. The row that is missed most pushes too.
            let mut is_pushing = vec![false; m];
            pushing.iter().for_each(|&i| is_pushing[i] = true);
            let left =
                |i: usize| missing[i] - pushing.iter().map(|&j| self.coupling[i][j] * multiplier[j]).sum::<f64>();
            let next = (0..m)
                .filter(|&i| movable(i) && !is_pushing[i])
                .map(|i| (left(i), i))
                .filter(|(missed, _)| *missed > 0.5 * SLACK)
                .max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
            match next {
                Some((_, i)) => pushing.push(i),
                None => break,
            }
        }
        for (i, active) in self.active.iter_mut().enumerate() {
            active.multiplier = if pushing.contains(&i) { multiplier[i].max(0.0) } else { 0.0 };
        }
    }

    /// Multipliers of some rows that bring all of them to equality, by Cholesky factorisation of their coupling.
    fn solve_for(&self, pushing: &[usize], missing: &[f64]) -> Vec<f64> {
        let n = pushing.len();
        let mut l = vec![0.0; n * n];
        let mut x: Vec<f64> = pushing.iter().map(|&i| missing[i]).collect();
        for i in 0..n {
            let (above, row) = l.split_at_mut(i * n);
            for j in 0..i {
                let other = &above[j * n..=j * n + j];
                row[j] = (self.coupling[pushing[i]][pushing[j]] - product(&row[..j], other)) / other[j];
            }
            let own = self.coupling[pushing[i]][pushing[i]];
            let pivot = own * (1.0 + REGULARISATION) - product(&row[..i], &row[..i]);
            row[i] = pivot.max(REGULARISATION * own).sqrt();
            x[i] = (x[i] - product(&row[..i], &x)) / row[i];
        }
        for i in (0..n).rev() {
            x[i] /= l[i * n + i];
            let (below, at) = x.split_at_mut(i);
            below.iter_mut().zip(&l[i * n..]).for_each(|(x, l)| *x -= l * at[0]);
        }
        x
    }

    fn place(&mut self) {
        self.z.copy_from_slice(&self.unbounded);
        for active in self.active.iter().filter(|a| a.multiplier != 0.0) {
            let by = active.multiplier;
            for (i, r) in active.response.iter().enumerate() {
                if self.free[i] {
                    self.z[i] += by * r;
                }
            }
        }
    }
}

/// Σ aᵢbᵢ over the shorter one, in four sums that a processor can do at once.
fn product(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().min(b.len());
    let (a, b) = (a[..n].chunks_exact(4), b[..n].chunks_exact(4));
    let rest: f64 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| a * b).sum();
    let mut sums = [0.0; 4];
    for (a, b) in a.zip(b) {
        (0..4).for_each(|k| sums[k] += a[k] * b[k]);
    }
    sums.iter().sum::<f64>() + rest
}

fn dot(terms: &[(u32, f64)], response: &[f64]) -> f64 {
    terms.iter().map(|&(i, c)| c * response[i as usize]).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// All integers within two units of the relaxation that meet the rows: the least energy, if there are any.
    fn least_energy(s: &[[f64; 3]; 3], relaxed: &[f64; 3], rows: &[LowerBound]) -> Option<f64> {
        let range = |i: usize| (-2..=3).map(move |d| (relaxed[i].floor()) + f64::from(d));
        let mut best: Option<f64> = None;
        for a in range(0) {
            for b in range(1) {
                for c in range(2) {
                    let z = [a, b, c];
                    if rows.iter().all(|r| r.value(&z) >= r.least) {
                        let e = energy(s, relaxed, &z);
                        best = Some(best.map_or(e, |x: f64| x.min(e)));
                    }
                }
            }
        }
        best
    }

    fn energy(s: &[[f64; 3]; 3], relaxed: &[f64; 3], z: &[f64]) -> f64 {
        let d: Vec<f64> = (0..3).map(|i| z[i] - relaxed[i]).collect();
        (0..3).flat_map(|i| (0..3).map(move |j| (i, j))).map(|(i, j)| 0.5 * s[i][j] * d[i] * d[j]).sum()
    }

    fn inverse(s: &[[f64; 3]; 3]) -> Vec<f64> {
        let cofactor = |i: usize, j: usize| {
            let [a, b] = [(i + 1) % 3, (i + 2) % 3];
            let [c, d] = [(j + 1) % 3, (j + 2) % 3];
            s[a][c] * s[b][d] - s[a][d] * s[b][c]
        };
        let det: f64 = (0..3).map(|j| s[0][j] * cofactor(0, j)).sum();
        (0..9).map(|k| cofactor(k % 3, k / 3) / det).collect()
    }

    proptest! {
        #[test]
        fn rows_are_met_and_the_energy_is_near_the_least(
            factor in prop::array::uniform9(-1.0..1.0f64),
            relaxed in prop::array::uniform3(-3.0..3.0f64),
            coefficients in prop::collection::vec(prop::array::uniform3(-1i32..=1), 0..4),
            slack in -1.0..1.0f64,
        ) {
            let l = |i: usize, j: usize| factor[3 * i + j];
            let s: [[f64; 3]; 3] = std::array::from_fn(|i| std::array::from_fn(|j| {
                (0..3).map(|t| l(i, t) * l(j, t)).sum::<f64>() + if i == j { 0.5 } else { 0.0 }
            }));
            // Bounds that the relaxed values, rounded, would miss by up to a unit.
            let rows: Vec<LowerBound> = coefficients
                .iter()
                .filter(|c| c.iter().any(|&x| x != 0))
                .map(|c| {
                    let terms: Vec<(u32, f64)> = (0..3u32).zip(c).filter(|t| *t.1 != 0).map(|(i, &x)| (i, f64::from(x))).collect();
                    let value: f64 = terms.iter().map(|&(i, x)| x * relaxed[i as usize]).sum();
                    LowerBound { terms, least: (value + slack).round() }
                })
                .collect();
            let z = round_bounded(inverse(&s), &relaxed, &rows, &|| false).expect("not cancelled").integers;
            prop_assert!(z.iter().all(|x| *x == x.round()));
            if !rows.iter().any(|row| row.is_missed(&z)) && let Some(least) = least_energy(&s, &relaxed, &rows) {
                prop_assert!(energy(&s, &relaxed, &z) >= least - 1e-9);
            }
        }
    }
}
