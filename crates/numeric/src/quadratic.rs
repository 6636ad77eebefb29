//! Quadratic energies E(x) = ½xᵀAx − xᵀb + c, given entry by entry or as weighted squares.
//!
//! In: entries and squares in any order. Out: [`Quadratic`]. Holds: nothing is checked while building;
//! indices and finiteness are checked by the solve.
//!
//! Source: [Bommes2012] §5, Eq. (5.1).

use crate::error::SolveError;

/// Energy of n variables.
///
/// # Example
/// ```
/// let mut energy = quadloom_numeric::Quadratic::new(2);
/// energy.add_square(&[(0, 1.0), (1, -1.0)], 3.0, 0.5); // ½(x₀ − x₁ − 3)²
/// assert_eq!(energy.energy(&[1.0, 0.0]), 2.0);
/// ```
#[derive(Debug, Clone, Default)]
pub struct Quadratic {
    n: usize,
    entries: Vec<(usize, usize, f64)>,
    rhs: Vec<(usize, f64)>,
    square_start: Vec<usize>,
    square_terms: Vec<(usize, f64)>,
    /// (d, w) of each square.
    square_data: Vec<(f64, f64)>,
    constant: f64,
}

/// One term w·(Σ c_k x_k − d)².
#[derive(Debug, Clone, Copy)]
pub struct Square<'a> {
    /// (k, c_k).
    pub terms: &'a [(usize, f64)],
    /// d.
    pub target: f64,
    /// w.
    pub weight: f64,
}

impl Quadratic {
    /// The zero energy of n variables.
    pub fn new(n: usize) -> Self {
        Self { n, square_start: vec![0], ..Self::default() }
    }

    /// Number of variables.
    pub fn n(&self) -> usize {
        self.n
    }

    /// Adds a to A_ij and, if i ≠ j, to A_ji: each unordered pair is given once.
    pub fn add(&mut self, i: usize, j: usize, a: f64) {
        self.entries.push((i, j, a));
    }

    /// Adds b to b_i.
    pub fn add_rhs(&mut self, i: usize, b: f64) {
        self.rhs.push((i, b));
    }

    /// Adds w·(Σ c_k x_k − d)², that is A += 2w·ccᵀ, b += 2wd·c, and the constant wd².
    pub fn add_square(&mut self, terms: &[(usize, f64)], d: f64, w: f64) {
        self.square_terms.extend_from_slice(terms);
        self.square_start.push(self.square_terms.len());
        self.square_data.push((d, w));
    }

    /// Adds a constant, which no minimiser depends on.
    pub fn add_constant(&mut self, c: f64) {
        self.constant += c;
    }

    /// E(x) with all constants.
    ///
    /// # Input  x: one value per variable
    pub fn energy(&self, x: &[f64]) -> f64 {
        let entry = |&(i, j, a): &(usize, usize, f64)| if i == j { 0.5 * a * x[i] * x[i] } else { a * x[i] * x[j] };
        let square = |s: Square| s.weight * (s.terms.iter().map(|&(k, c)| c * x[k]).sum::<f64>() - s.target).powi(2);
        self.constant + self.entries.iter().map(entry).sum::<f64>()
            - self.rhs.iter().map(|&(i, b)| b * x[i]).sum::<f64>()
            + self.squares().map(square).sum::<f64>()
    }

    pub(crate) fn entries(&self) -> &[(usize, usize, f64)] {
        &self.entries
    }

    pub(crate) fn rhs(&self) -> &[(usize, f64)] {
        &self.rhs
    }

    /// The squares, in the order given.
    pub fn squares(&self) -> impl Iterator<Item = Square<'_>> {
        self.square_data.iter().enumerate().map(|(k, &(target, weight))| Square {
            terms: &self.square_terms[self.square_start[k]..self.square_start[k + 1]],
            target,
            weight,
        })
    }

    /// Errors where an index is out of range or a number is not finite.
    pub(crate) fn check(&self) -> Result<(), SolveError> {
        let pairs = self.entries.iter().flat_map(|&(i, j, a)| [(i, a), (j, a)]);
        let terms = pairs.chain(self.rhs.iter().copied()).chain(self.square_terms.iter().copied());
        for (variable, value) in terms {
            if variable >= self.n {
                return Err(SolveError::VariableOutOfRange { variable, n: self.n });
            }
            if !value.is_finite() {
                return Err(SolveError::NotFinite { place: format!("variable {variable} in the energy") });
            }
        }
        let finite = self.square_data.iter().all(|(d, w)| d.is_finite() && w.is_finite());
        if !finite {
            return Err(SolveError::NotFinite { place: "a square of the energy".into() });
        }
        Ok(())
    }
}
