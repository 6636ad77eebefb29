//! Elimination of linear constraints: x = B·y + c.
//!
//! In: [`Constraints`] and which variables are integers. Out: [`Elimination`], every variable as a sparse
//! combination of the free ones, and the rows that were dependent.
//! Holds: if the free integer variables are integers, all integer variables are; where coefficients are ±1
//! and right-hand sides integers, B and c are exact small integers. Contradictions are errors that name
//! the rows which together read 0 = r.
//!
//! Source: [Bommes2012] §5.1.2 (Eq. (5.7), choice of variables, gcd rule, fill-reducing order). Differs:
//! among the coefficients of at least half the largest magnitude the variable met in fewest rows is taken;
//! contradicting rows are an error, not neglected; integer rows whose gcd is not a coefficient are brought
//! to one by Euclid's algorithm with auxiliary integer variables.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::constraints::Constraints;
use crate::error::SolveError;

/// A coefficient is zero if subtraction left less than this fraction of its operands.
///
/// Larger: independent rows of nearly equal coefficients are taken for dependent. Smaller: rounding noise
/// becomes a pivot.
const CANCELLATION_REL: f64 = 1e-11;

/// An empty row contradicts if its right-hand side exceeds this times the row's largest coefficient, the
/// default of [Bommes2012] §5.1.2. Integer data never come near it.
const CONTRADICTION_REL: f64 = 1e-6;

/// A number is taken for an integer within this distance; coefficients are small, so noise is far below.
const INTEGER_TOLERANCE: f64 = 1e-9;

/// Rows of integer variables with fractional coefficients are tried times 1 to this number. Crosses bring
/// halves and quarters; beyond 64 a common unit is more likely noise.
const LARGEST_DENOMINATOR: u32 = 64;

/// A variable as Σ coefficient·(free variable) + constant.
#[derive(Debug, Clone, Copy)]
pub struct Expression<'a> {
    /// Positions in [`Elimination::free`], ascending, with their coefficients.
    pub terms: &'a [(u32, f64)],
    /// The constant part.
    pub constant: f64,
}

/// The solution set of Cx = d as x = B·y + c.
///
/// # Example
/// ```
/// use quadloom_numeric::{Constraints, Elimination};
/// let mut constraints = Constraints::new();
/// constraints.add(&[(0, 1.0), (1, 1.0), (2, -1.0)], 4.0, 0);
/// let elimination = Elimination::eliminate(3, &constraints, &[true, true, false])?;
/// assert_eq!(elimination.free(), &[0, 1]); // the continuous variable is the one eliminated
/// assert_eq!(elimination.expand(&[1.0, 2.0]), vec![1.0, 2.0, -1.0]);
/// # Ok::<(), quadloom_numeric::SolveError>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct Elimination {
    n: usize,
    free: Vec<u32>,
    free_is_integer: Vec<bool>,
    starts: Vec<usize>,
    terms: Vec<(u32, f64)>,
    constants: Vec<f64>,
    dependent: Vec<usize>,
    auxiliaries: Vec<Auxiliary>,
}

/// Definition of an auxiliary integer variable: Σ c_k x_k over earlier variables.
#[derive(Debug, Clone)]
struct Auxiliary {
    terms: Vec<(u32, f64)>,
}

impl Elimination {
    /// Eliminates one variable for each independent row.
    ///
    /// # Input   n variables; `is_integer`: one flag for each
    /// # Errors  [`SolveError::Contradiction`], [`SolveError::NoIntegerSolution`],
    ///   [`SolveError::IncommensurableRow`], [`SolveError::VariableOutOfRange`],
    ///   [`SolveError::NotFinite`]
    /// # Cost    near linear in the terms while fill stays low
    /// # Source  [Bommes2012] §5.1.2
    pub fn eliminate(n: usize, constraints: &Constraints, is_integer: &[bool]) -> Result<Self, SolveError> {
        check(n, constraints)?;
        let mut system = System::new(n, constraints, is_integer);
        while let Some(row) = system.next_row() {
            system.process(row)?;
        }
        Ok(system.back_substitute(n))
    }

    /// Number of variables, auxiliary ones not counted.
    pub fn n(&self) -> usize {
        self.n
    }

    /// The free variables, ascending. Indices from n on are auxiliary integers that Euclid's algorithm
    /// needed; they are no variables of the caller's.
    pub fn free(&self) -> &[u32] {
        &self.free
    }

    /// For each free variable, whether it must be an integer.
    pub fn free_is_integer(&self) -> &[bool] {
        &self.free_is_integer
    }

    /// Variable `i` in terms of the free variables.
    pub fn expression(&self, i: usize) -> Expression<'_> {
        Expression { terms: &self.terms[self.starts[i]..self.starts[i + 1]], constant: self.constants[i] }
    }

    /// Labels of the rows that followed from others and were dropped, in the order met.
    pub fn dependent(&self) -> &[usize] {
        &self.dependent
    }

    /// x = B·y + c.
    ///
    /// # Input  y: one value per free variable
    pub fn expand(&self, y: &[f64]) -> Vec<f64> {
        let value = |i| {
            let e = self.expression(i);
            e.terms.iter().map(|&(k, c)| c * y[k as usize]).sum::<f64>() + e.constant
        };
        (0..self.n).map(value).collect()
    }

    /// The free variables' values at x, so that `expand(restrict(x))` is x wherever Cx = d.
    pub fn restrict(&self, x: &[f64]) -> Vec<f64> {
        let mut extended = x[..self.n].to_vec();
        for auxiliary in &self.auxiliaries {
            let value = auxiliary.terms.iter().map(|&(k, c)| c * extended[k as usize]).sum();
            extended.push(value);
        }
        self.free.iter().map(|&i| extended[i as usize]).collect()
    }

    /// Bᵀ·g: the gradient with respect to y of an energy whose gradient with respect to x is g.
    pub fn pull_back(&self, gradient: &[f64]) -> Vec<f64> {
        let mut reduced = vec![0.0; self.free.len()];
        for (i, g) in gradient.iter().enumerate().take(self.n) {
            self.expression(i).terms.iter().for_each(|&(k, c)| reduced[k as usize] += c * g);
        }
        reduced
    }
}

fn check(n: usize, constraints: &Constraints) -> Result<(), SolveError> {
    for row in constraints.rows() {
        if let Some(&(variable, _)) = row.terms.iter().find(|&&(k, _)| k >= n) {
            return Err(SolveError::VariableOutOfRange { variable, n });
        }
        if !row.rhs.is_finite() || row.terms.iter().any(|(_, c)| !c.is_finite()) {
            return Err(SolveError::NotFinite { place: format!("constraint {}", row.label) });
        }
    }
    Ok(())
}

/// A row under elimination.
#[derive(Debug, Clone, Default)]
struct WorkRow {
    /// Sorted by variable.
    terms: Vec<(u32, f64)>,
    rhs: f64,
    /// Largest coefficient given, against which a leftover right-hand side is measured.
    scale: f64,
    /// Largest right-hand side that went into `rhs`; its rounding noise is proportional.
    rhs_scale: f64,
    /// None for the definition of an auxiliary variable.
    label: Option<usize>,
    /// The row is `own` times the row given plus f times the final form of each row (s, f) here.
    own: f64,
    operations: Vec<(u32, f64)>,
    /// The variable this row was solved for.
    pivot: Option<u32>,
    done: bool,
}

/// The rows, with the rows of each variable and a queue by length.
struct System {
    rows: Vec<WorkRow>,
    is_integer: Vec<bool>,
    /// Rows that hold or once held the variable; checked on use.
    occurrences: Vec<Vec<u32>>,
    /// (length, row), smallest first; entries of outdated length are skipped.
    queue: BinaryHeap<Reverse<(usize, u32)>>,
    /// Rows in the order they were solved.
    solved: Vec<u32>,
    dependent: Vec<usize>,
    auxiliaries: Vec<Auxiliary>,
}

impl System {
    fn new(n: usize, constraints: &Constraints, is_integer: &[bool]) -> Self {
        let mut system = Self {
            rows: Vec::with_capacity(constraints.len()),
            is_integer: (0..n).map(|i| is_integer.get(i).copied().unwrap_or(false)).collect(),
            occurrences: vec![Vec::new(); n],
            queue: BinaryHeap::new(),
            solved: Vec::new(),
            dependent: Vec::new(),
            auxiliaries: Vec::new(),
        };
        for row in constraints.rows() {
            let terms = collect_terms(row.terms);
            let scale = terms.iter().map(|(_, c)| c.abs()).fold(0.0, f64::max);
            system.push_row(WorkRow {
                terms,
                rhs: row.rhs,
                scale,
                rhs_scale: row.rhs.abs(),
                label: Some(row.label),
                own: 1.0,
                ..WorkRow::default()
            });
        }
        system
    }

    fn push_row(&mut self, row: WorkRow) -> u32 {
        let id = self.rows.len() as u32;
        row.terms.iter().for_each(|&(k, _)| self.occurrences[k as usize].push(id));
        self.queue.push(Reverse((row.terms.len(), id)));
        self.rows.push(row);
        id
    }

    /// Step 1: the shortest row left ([Bommes2012] §5.1.2, fill-in reducing constraint reordering).
    fn next_row(&mut self) -> Option<u32> {
        while let Some(Reverse((length, id))) = self.queue.pop() {
            let row = &self.rows[id as usize];
            if !row.done && row.terms.len() == length {
                return Some(id);
            }
        }
        None
    }

    /// Step 2: drops the row, or solves it for a variable and eliminates that from all others.
    fn process(&mut self, id: u32) -> Result<(), SolveError> {
        if self.rows[id as usize].terms.is_empty() {
            return self.drop_empty(id);
        }
        match self.continuous_pivot(id) {
            Some(pivot) => self.solve_for(id, pivot),
            None => self.process_integer_row(id)?,
        }
        Ok(())
    }

    fn drop_empty(&mut self, id: u32) -> Result<(), SolveError> {
        let row = &mut self.rows[id as usize];
        row.done = true;
        if row.rhs.abs() > CONTRADICTION_REL * row.scale.max(f64::MIN_POSITIVE) + CANCELLATION_REL * row.rhs_scale {
            let residual = row.rhs;
            return Err(SolveError::Contradiction { rows: self.combined_rows(id), residual });
        }
        self.dependent.extend(row.label);
        Ok(())
    }

    /// The continuous variable to eliminate, if there is one: of large coefficient, then in few rows.
    fn continuous_pivot(&self, id: u32) -> Option<u32> {
        let continuous = || self.rows[id as usize].terms.iter().filter(|(k, _)| !self.is_integer[*k as usize]);
        let largest = continuous().map(|(_, c)| c.abs()).fold(0.0, f64::max);
        continuous().filter(|(_, c)| c.abs() >= 0.5 * largest).map(|&(k, _)| k).min_by_key(|&k| self.rank(k))
    }

    fn rank(&self, k: u32) -> (usize, u32) {
        (self.occurrences[k as usize].len(), k)
    }

    /// A row of integer variables only ([Bommes2012] §5.1.2, gcd rule).
    fn process_integer_row(&mut self, id: u32) -> Result<(), SolveError> {
        self.make_coefficients_integer(id)?;
        let row = &self.rows[id as usize];
        let divisor = row.terms.iter().map(|(_, c)| c.abs()).fold(0.0, gcd);
        let quotient = row.rhs / divisor;
        if (quotient - quotient.round()).abs() > INTEGER_TOLERANCE.max(CANCELLATION_REL * row.rhs_scale / divisor) {
            let rhs = row.rhs;
            return Err(SolveError::NoIntegerSolution { rows: self.combined_rows(id), divisor, rhs });
        }
        self.scale_row(id, 1.0 / divisor, divisor);
        let row = &mut self.rows[id as usize];
        row.rhs = quotient.round();
        let units = row.terms.iter().filter(|(_, c)| c.abs() == 1.0).map(|&(k, _)| k);
        match units.min_by_key(|&k| (self.occurrences[k as usize].len(), k)) {
            Some(pivot) => self.solve_for(id, pivot),
            None => self.euclid_step(id),
        }
        Ok(())
    }

    /// Multiplies the row by the smallest factor that makes its coefficients integers, and rounds them.
    fn make_coefficients_integer(&mut self, id: u32) -> Result<(), SolveError> {
        let row = &self.rows[id as usize];
        let near = |c: f64| (c - c.round()).abs() <= INTEGER_TOLERANCE * c.abs().max(1.0) && c.round() != 0.0;
        let smallest = row.terms.iter().map(|(_, c)| c.abs()).fold(f64::INFINITY, f64::min);
        let units = [1.0, smallest];
        let mut factors = units.into_iter().flat_map(|u| (1..=LARGEST_DENOMINATOR).map(move |m| f64::from(m) / u));
        let Some(factor) = factors.find(|f| row.terms.iter().all(|(_, c)| near(c * f))) else {
            return Err(SolveError::IncommensurableRow { rows: self.combined_rows(id) });
        };
        self.scale_row(id, factor, 1.0);
        self.rows[id as usize].terms.iter_mut().for_each(|(_, c)| *c = c.round());
        Ok(())
    }

    /// Multiplies a row by factor/divisor; coefficients are divided last, so that integers stay exact.
    fn scale_row(&mut self, id: u32, factor: f64, divisor: f64) {
        let by = if divisor == 1.0 { factor } else { 1.0 / divisor };
        let row = &mut self.rows[id as usize];
        let scaled = |c: f64| if divisor == 1.0 { c * factor } else { c / divisor };
        row.terms.iter_mut().for_each(|(_, c)| *c = scaled(*c));
        row.operations.iter_mut().for_each(|(_, f)| *f *= by);
        row.rhs = scaled(row.rhs);
        row.scale *= by;
        row.rhs_scale *= by;
        row.own *= by;
    }

    /// No coefficient is ±1: with a the smallest and a_k = a·q_k + r_k, the auxiliary integer
    /// t = x_p + Σ q_k x_k turns the row into a·t + Σ r_k x_k = d, of smaller coefficients.
    fn euclid_step(&mut self, id: u32) {
        let terms = self.rows[id as usize].terms.clone();
        let smallest = |a: &&(u32, f64), b: &&(u32, f64)| a.1.abs().total_cmp(&b.1.abs()).then(a.0.cmp(&b.0));
        let Some(&(pivot, a)) = terms.iter().min_by(smallest) else { return };
        let t = self.is_integer.len() as u32;
        self.is_integer.push(true);
        self.occurrences.push(Vec::new());
        let mut definition: Vec<(u32, f64)> = terms.iter().map(|&(k, c)| (k, (c / a).round())).collect();
        definition.retain(|&(_, q)| q != 0.0);
        self.auxiliaries.push(Auxiliary { terms: definition.clone() });
        definition.push((t, -1.0));
        let row = self.push_row(WorkRow { terms: definition, own: 1.0, ..WorkRow::default() });
        self.solve_for(row, pivot);
    }

    /// Step 3: eliminates `pivot` from every other unsolved row by Gauss.
    fn solve_for(&mut self, id: u32, pivot: u32) {
        let mut source = std::mem::take(&mut self.rows[id as usize]);
        source.pivot = Some(pivot);
        source.done = true;
        let leading = coefficient(&source.terms, pivot).unwrap_or(1.0);
        for target in std::mem::take(&mut self.occurrences[pivot as usize]) {
            let row = &self.rows[target as usize];
            if target != id
                && !row.done
                && let Some(c) = coefficient(&row.terms, pivot)
            {
                self.add_multiple(target, &source, id, pivot, -c / leading);
            }
        }
        self.solved.push(id);
        self.rows[id as usize] = source;
    }

    /// target += f·source, where the pivot's coefficient cancels by construction.
    fn add_multiple(&mut self, target: u32, source: &WorkRow, source_id: u32, pivot: u32, f: f64) {
        let row = &mut self.rows[target as usize];
        let old = std::mem::take(&mut row.terms);
        let occurrences = &mut self.occurrences;
        row.terms = merge(&old, &source.terms, f, pivot, |filled| occurrences[filled as usize].push(target));
        row.rhs += f * source.rhs;
        row.rhs_scale = row.rhs_scale.max(f.abs() * source.rhs_scale).max(row.rhs.abs());
        row.operations.push((source_id, f));
        self.queue.push(Reverse((row.terms.len(), target)));
    }

    /// Labels of the given rows whose combination row `id` now is.
    fn combined_rows(&self, id: u32) -> Vec<usize> {
        let mut multiplier = vec![0.0f64; self.rows.len()];
        multiplier[id as usize] = 1.0;
        // A row was only ever combined with rows solved before it, so reverse order settles each in turn.
        for &row in std::iter::once(&id).chain(self.solved.iter().rev()) {
            let by = multiplier[row as usize];
            if by != 0.0 {
                self.rows[row as usize].operations.iter().for_each(|&(s, f)| multiplier[s as usize] += by * f);
            }
        }
        let involved =
            |(row, by): (&WorkRow, &f64)| if (by * row.own).abs() > INTEGER_TOLERANCE { row.label } else { None };
        let mut labels: Vec<usize> = self.rows.iter().zip(&multiplier).filter_map(involved).collect();
        labels.sort_unstable();
        labels.dedup();
        labels
    }

    /// Step 4: expresses every variable by free ones, last solved row first.
    fn back_substitute(self, n: usize) -> Elimination {
        let total = self.is_integer.len();
        let mut row_of = vec![None; total];
        for &id in &self.solved {
            if let Some(pivot) = self.rows[id as usize].pivot {
                row_of[pivot as usize] = Some(id);
            }
        }
        let free: Vec<u32> = (0..total as u32).filter(|&i| row_of[i as usize].is_none()).collect();
        let mut expressions: Vec<(Vec<(u32, f64)>, f64)> = vec![(Vec::new(), 0.0); total];
        free.iter().enumerate().for_each(|(k, &i)| expressions[i as usize].0.push((k as u32, 1.0)));
        let mut sum = SparseSum::new(free.len());
        for &id in self.solved.iter().rev() {
            let row = &self.rows[id as usize];
            let Some(pivot) = row.pivot else { continue };
            expressions[pivot as usize] = solve_row(row, pivot, &expressions, &mut sum);
        }
        let mut elimination = Elimination {
            n,
            free_is_integer: free.iter().map(|&i| self.is_integer[i as usize]).collect(),
            free,
            starts: vec![0],
            dependent: self.dependent,
            auxiliaries: self.auxiliaries,
            ..Elimination::default()
        };
        for (terms, constant) in expressions {
            elimination.terms.extend(terms);
            elimination.starts.push(elimination.terms.len());
            elimination.constants.push(constant);
        }
        elimination
    }
}

/// x_p = (d − Σ c_k x_k) / c_p with the x_k already expressed by free variables ([Bommes2012] Eq. (5.7)).
fn solve_row(
    row: &WorkRow,
    pivot: u32,
    expressions: &[(Vec<(u32, f64)>, f64)],
    sum: &mut SparseSum,
) -> (Vec<(u32, f64)>, f64) {
    let leading = coefficient(&row.terms, pivot).unwrap_or(1.0);
    let mut constant = row.rhs / leading;
    for &(k, c) in row.terms.iter().filter(|(k, _)| *k != pivot) {
        let (terms, offset) = &expressions[k as usize];
        let factor = -c / leading;
        terms.iter().for_each(|&(j, b)| sum.add(j, factor * b));
        constant += factor * offset;
    }
    (sum.take(), constant)
}

/// Accumulates a sparse vector; dense scratch, cost by what was touched.
pub(crate) struct SparseSum {
    value: Vec<f64>,
    magnitude: Vec<f64>,
    touched: Vec<u32>,
}

impl SparseSum {
    pub fn new(n: usize) -> Self {
        Self { value: vec![0.0; n], magnitude: vec![0.0; n], touched: Vec::new() }
    }

    pub fn add(&mut self, k: u32, c: f64) {
        if self.magnitude[k as usize] == 0.0 {
            self.touched.push(k);
        }
        self.value[k as usize] += c;
        self.magnitude[k as usize] += c.abs();
    }

    /// All that was added to, sums that cancelled too, so that what is taken does not depend on values.
    pub fn take_pattern(&mut self) -> Vec<(u32, f64)> {
        self.touched.sort_unstable();
        let mut terms = Vec::with_capacity(self.touched.len());
        for k in self.touched.drain(..) {
            self.magnitude[k as usize] = 0.0;
            terms.push((k, std::mem::take(&mut self.value[k as usize])));
        }
        terms
    }

    pub fn take(&mut self) -> Vec<(u32, f64)> {
        self.touched.sort_unstable();
        let mut terms = Vec::with_capacity(self.touched.len());
        for k in self.touched.drain(..) {
            let value = std::mem::take(&mut self.value[k as usize]);
            let magnitude = std::mem::take(&mut self.magnitude[k as usize]);
            if value.abs() > CANCELLATION_REL * magnitude {
                terms.push((k, value));
            }
        }
        terms
    }
}

/// Sorted terms, repeats summed, zeros dropped.
fn collect_terms(terms: &[(usize, f64)]) -> Vec<(u32, f64)> {
    let mut sorted: Vec<(u32, f64)> = terms.iter().map(|&(k, c)| (k as u32, c)).collect();
    sorted.sort_by_key(|&(k, _)| k);
    sorted.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        if same {
            kept.1 += next.1;
        }
        same
    });
    sorted.retain(|&(_, c)| c != 0.0);
    sorted
}

fn coefficient(terms: &[(u32, f64)], k: u32) -> Option<f64> {
    terms.binary_search_by_key(&k, |&(j, _)| j).ok().map(|at| terms[at].1)
}

/// a + f·b without the pivot; `on_fill` hears of variables that only b holds.
fn merge(a: &[(u32, f64)], b: &[(u32, f64)], f: f64, pivot: u32, mut on_fill: impl FnMut(u32)) -> Vec<(u32, f64)> {
    let mut out = Vec::with_capacity(a.len() + b.len());
    let (mut i, mut j) = (0, 0);
    while i < a.len() || j < b.len() {
        let next_a = a.get(i).map_or(u32::MAX, |t| t.0);
        let next_b = b.get(j).map_or(u32::MAX, |t| t.0);
        let k = next_a.min(next_b);
        let from_a = if next_a == k { a[i].1 } else { 0.0 };
        let from_b = if next_b == k { f * b[j].1 } else { 0.0 };
        i += usize::from(next_a == k);
        j += usize::from(next_b == k);
        let c = from_a + from_b;
        if k == pivot || c.abs() <= CANCELLATION_REL * (from_a.abs() + from_b.abs()) {
            continue;
        }
        if next_a != k {
            on_fill(k);
        }
        out.push((k, c));
    }
    out
}

/// Greatest common divisor of two non-negative integers held as floats.
fn gcd(a: f64, b: f64) -> f64 {
    if b == 0.0 { a } else { gcd(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn eliminate(n: usize, rows: &[(&[(usize, f64)], f64)], integers: &[usize]) -> Result<Elimination, SolveError> {
        let mut constraints = Constraints::new();
        rows.iter().enumerate().for_each(|(label, &(terms, d))| constraints.add(terms, d, 100 + label));
        let is_integer: Vec<bool> = (0..n).map(|i| integers.contains(&i)).collect();
        Elimination::eliminate(n, &constraints, &is_integer)
    }

    #[test]
    fn continuous_variables_are_eliminated_first() {
        let done = eliminate(3, &[(&[(0, 5.0), (1, 1.0), (2, 7.0)], 3.0)], &[0, 2]).unwrap();
        assert_eq!(done.free(), &[0, 2]);
        assert_eq!(done.expand(&[1.0, 2.0]), vec![1.0, -16.0, 2.0]);
    }

    #[test]
    fn contradicting_rows_are_named_and_only_those() {
        let rows: &[(&[(usize, f64)], f64)] = &[
            (&[(0, 1.0), (1, -1.0)], 1.0),
            (&[(3, 1.0), (4, 1.0)], 0.5),
            (&[(1, 1.0), (2, -1.0)], 1.0),
            (&[(0, 2.0), (2, -2.0)], 5.0),
            (&[(3, 1.0)], 0.25),
        ];
        let error = eliminate(5, rows, &[]).unwrap_err();
        let SolveError::Contradiction { rows, residual } = error else { panic!("{error}") };
        assert_eq!(rows, vec![100, 102, 103]);
        assert!(residual.abs() > 0.4);
    }

    #[test]
    fn dependent_rows_are_dropped_and_counted() {
        let rows: &[(&[(usize, f64)], f64)] =
            &[(&[(0, 1.0), (1, 1.0)], 1.0), (&[(1, 1.0), (0, 1.0)], 1.0), (&[(0, 3.0), (1, 3.0)], 3.0), (&[], 0.0)];
        let done = eliminate(2, rows, &[]).unwrap();
        assert_eq!((done.free().len(), done.dependent().len()), (1, 3));
    }

    #[test]
    fn gcd_rule_divides_and_pivots_on_a_unit() {
        let done = eliminate(2, &[(&[(0, 4.0), (1, -2.0)], 6.0)], &[0, 1]).unwrap();
        assert_eq!(done.free(), &[0]);
        assert_eq!(done.expand(&[5.0]), vec![5.0, 7.0]);
        let halves = eliminate(2, &[(&[(0, 0.5), (1, -1.5)], 2.0)], &[0, 1]).unwrap();
        assert_eq!(halves.expand(&[1.0]), vec![7.0, 1.0]);
    }

    #[test]
    fn an_integer_row_without_integer_solution_is_named() {
        let error = eliminate(2, &[(&[(0, 2.0), (1, -4.0)], 3.0)], &[0, 1]).unwrap_err();
        assert_eq!(error, SolveError::NoIntegerSolution { rows: vec![100], divisor: 2.0, rhs: 3.0 });
        let error = eliminate(2, &[(&[(0, 1.0)], 0.5)], &[0]).unwrap_err();
        assert!(matches!(error, SolveError::NoIntegerSolution { .. }));
        // x₀ = 1 + x₁ and x₀ + x₁ = 2 leave 2x₁ = 1.
        let rows: &[(&[(usize, f64)], f64)] = &[(&[(0, 1.0), (1, -1.0)], 1.0), (&[(0, 1.0), (1, 1.0)], 2.0)];
        let SolveError::NoIntegerSolution { rows, .. } = eliminate(2, rows, &[0, 1]).unwrap_err() else { panic!() };
        assert_eq!(rows, vec![100, 101]);
    }

    #[test]
    fn incommensurable_integer_rows_are_refused() {
        let error = eliminate(2, &[(&[(0, 1.0), (1, std::f64::consts::SQRT_2)], 0.0)], &[0, 1]).unwrap_err();
        assert_eq!(error, SolveError::IncommensurableRow { rows: vec![100] });
    }

    #[test]
    fn euclid_reaches_every_integer_solution_of_a_row_without_units() {
        let done = eliminate(3, &[(&[(0, 6.0), (1, 10.0), (2, 15.0)], 1.0)], &[0, 1, 2]).unwrap();
        assert_eq!(done.free().len(), 2);
        assert!(done.free_is_integer().iter().all(|&integer| integer));
        let mut found = std::collections::BTreeSet::new();
        for a in -60..=60 {
            for b in -60..=60 {
                let x = done.expand(&[f64::from(a), f64::from(b)]);
                assert_eq!(6.0 * x[0] + 10.0 * x[1] + 15.0 * x[2], 1.0);
                assert!(x.iter().all(|v| v.fract() == 0.0));
                assert_eq!(done.restrict(&x), vec![f64::from(a), f64::from(b)]);
                found.insert((x[0] as i64, x[1] as i64, x[2] as i64));
            }
        }
        for x0 in -5i64..=5 {
            for x1 in -5i64..=5 {
                let rest = 1 - 6 * x0 - 10 * x1;
                assert!(rest % 15 != 0 || found.contains(&(x0, x1, rest / 15)));
            }
        }
    }

    #[test]
    fn indices_and_numbers_are_checked() {
        assert_eq!(
            eliminate(2, &[(&[(2, 1.0)], 0.0)], &[]).unwrap_err(),
            SolveError::VariableOutOfRange { variable: 2, n: 2 }
        );
        assert!(matches!(eliminate(2, &[(&[(1, 1.0)], f64::NAN)], &[]).unwrap_err(), SolveError::NotFinite { .. }));
    }
}
