//! Linear equality constraints Cx = d, rows named by the caller.
//!
//! In: rows in any order, of any length. Out: [`Constraints`]. Holds: nothing is checked while building.
//!
//! Source: [Bommes2012] §5, Eq. (5.3).

/// Rows Σ c_k x_k = d, each with a label of the caller's by which errors name it.
///
/// # Example
/// ```
/// let mut constraints = quadloom_numeric::Constraints::new();
/// constraints.add(&[(0, 1.0), (1, -1.0)], 2.0, 17); // x₀ − x₁ = 2, called row 17
/// constraints.fix(1, 4.0, 18);
/// assert_eq!(constraints.len(), 2);
/// ```
#[derive(Debug, Clone, Default)]
pub struct Constraints {
    ends: Vec<usize>,
    terms: Vec<(usize, f64)>,
    rhs: Vec<f64>,
    labels: Vec<usize>,
}

/// One constraint.
#[derive(Debug, Clone, Copy)]
pub struct Row<'a> {
    /// (k, c_k); a variable may occur more than once.
    pub terms: &'a [(usize, f64)],
    /// d.
    pub rhs: f64,
    /// The caller's name for the row; need not be unique.
    pub label: usize,
}

impl Constraints {
    /// No rows.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds the row Σ c_k x_k = d.
    pub fn add(&mut self, terms: &[(usize, f64)], d: f64, label: usize) {
        self.terms.extend_from_slice(terms);
        self.ends.push(self.terms.len());
        self.rhs.push(d);
        self.labels.push(label);
    }

    /// Adds the row x_i = value.
    pub fn fix(&mut self, i: usize, value: f64, label: usize) {
        self.add(&[(i, 1.0)], value, label);
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.rhs.len()
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.rhs.is_empty()
    }

    /// The rows, in the order given.
    pub fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        (0..self.len()).map(|r| {
            let start = if r == 0 { 0 } else { self.ends[r - 1] };
            Row { terms: &self.terms[start..self.ends[r]], rhs: self.rhs[r], label: self.labels[r] }
        })
    }

    /// The largest |Σ c_k x_k − d| over all rows, and the label of its row.
    pub fn worst_violation(&self, x: &[f64]) -> Option<(f64, usize)> {
        let violation = |row: Row| (row.terms.iter().map(|&(k, c)| c * x[k]).sum::<f64>() - row.rhs).abs();
        self.rows().map(|row| (violation(row), row.label)).max_by(|a, b| a.0.total_cmp(&b.0))
    }
}
