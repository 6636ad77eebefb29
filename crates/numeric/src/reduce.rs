//! Substitution of eliminated and fixed variables into an energy.
//!
//! In: a [`Quadratic`] and a [`Substitution`]. Out: [`Reduced`], the matrix and right-hand side over the
//! variables that remain. Holds: sums run in the order given; equal input gives equal bytes.
//!
//! Source: [Bommes2012] §5.1.2, Eq. (5.8)-(5.10): Ã = BᵀAB, b̃ = Bᵀ(b − Ac).

use crate::elimination::{Elimination, SparseSum};
use crate::quadratic::{Quadratic, Square};
use crate::sparse::{SparseSymmetric, Triplet};

/// Minimise ½yᵀAy − yᵀb.
#[derive(Debug)]
pub(crate) struct Reduced {
    pub matrix: SparseSymmetric,
    pub rhs: Vec<f64>,
}

/// Every variable as Σ coefficient·(active variable) + constant, where the active variables are the free
/// ones of an elimination whose value is not given.
#[derive(Debug)]
pub(crate) struct Substitution {
    starts: Vec<usize>,
    terms: Vec<(u32, f64)>,
    constants: Vec<f64>,
    /// Position among the free variables of each active one.
    pub active: Vec<u32>,
}

impl Substitution {
    /// `given`: for each free variable its value, or None if it is active.
    pub fn new(elimination: &Elimination, given: &[Option<f64>]) -> Self {
        let active: Vec<u32> = (0..given.len() as u32).filter(|&k| given[k as usize].is_none()).collect();
        let mut position = vec![0; given.len()];
        active.iter().enumerate().for_each(|(at, &k)| position[k as usize] = at as u32);
        let mut substitution = Self { starts: vec![0], terms: Vec::new(), constants: Vec::new(), active };
        for i in 0..elimination.n() {
            let expression = elimination.expression(i);
            let mut constant = expression.constant;
            for &(k, c) in expression.terms {
                match given[k as usize] {
                    Some(value) => constant += c * value,
                    None => substitution.terms.push((position[k as usize], c)),
                }
            }
            substitution.starts.push(substitution.terms.len());
            substitution.constants.push(constant);
        }
        substitution
    }

    pub fn expression(&self, i: usize) -> (&[(u32, f64)], f64) {
        (&self.terms[self.starts[i]..self.starts[i + 1]], self.constants[i])
    }

    /// Per active variable, the variables that depend on it, ascending.
    fn transposed(&self, n: usize) -> Rows {
        let mut start = vec![0; n + 1];
        self.terms.iter().for_each(|t| start[t.0 as usize + 1] += 1);
        (0..n).for_each(|k| start[k + 1] += start[k]);
        let (mut at, mut entries) = (start.clone(), vec![(0, 0.0); self.terms.len()]);
        for i in 0..self.constants.len() {
            for &(k, c) in self.expression(i).0 {
                entries[at[k as usize]] = (i as u32, c);
                at[k as usize] += 1;
            }
        }
        Rows { start, entries }
    }
}

/// The energy over the active variables.
///
/// # Cost  a product of sparse matrices: per variable, the length of its expression times that of its row of A·B
pub(crate) fn reduce(quadratic: &Quadratic, substitution: &Substitution) -> Reduced {
    let n = substitution.active.len();
    let mut assembly = Assembly { triplets: Vec::new(), rhs: vec![0.0; n], square: Vec::new() };
    // 1. Rows of A·B, and Bᵀ(b − Ac).
    let entries: Vec<Triplet> = quadratic.entries().iter().map(|&(i, j, a)| (i as u32, j as u32, a)).collect();
    let full = SparseSymmetric::from_triplets(quadratic.n(), &entries);
    drop(entries);
    let mut sum = SparseSum::new(n);
    let mut product = Rows { start: vec![0], entries: Vec::new() };
    for i in 0..quadratic.n() {
        let own = substitution.expression(i).0;
        let (columns, values) = full.row(i);
        let mut constant = 0.0;
        if !own.is_empty() {
            for (&j, a) in columns.iter().zip(values) {
                let (terms, offset) = substitution.expression(j as usize);
                constant += a * offset;
                terms.iter().for_each(|&(l, b)| sum.add(l, a * b));
            }
            product.entries.extend(sum.take_pattern());
        }
        product.start.push(product.entries.len());
        own.iter().for_each(|&(k, c)| assembly.rhs[k as usize] -= c * constant);
    }
    for &(i, b) in quadratic.rhs() {
        substitution.expression(i).0.iter().for_each(|&(k, c)| assembly.rhs[k as usize] += b * c);
    }
    // 2. Rows of Bᵀ·(A·B), the upper triangle.
    let transposed = substitution.transposed(n);
    for k in 0..n as u32 {
        for &(i, c) in transposed.row(k as usize) {
            product.row(i as usize).iter().filter(|(l, _)| *l >= k).for_each(|&(l, v)| sum.add(l, c * v));
        }
        assembly.triplets.extend(sum.take_pattern().into_iter().map(|(l, v)| (k, l, v)));
    }
    // 3. Squares.
    for square in quadratic.squares() {
        assembly.add_square(square, substitution);
    }
    Reduced { matrix: SparseSymmetric::from_triplets(n, &assembly.triplets), rhs: assembly.rhs }
}

/// Sparse rows, flat.
struct Rows {
    start: Vec<usize>,
    entries: Vec<(u32, f64)>,
}

impl Rows {
    fn row(&self, i: usize) -> &[(u32, f64)] {
        &self.entries[self.start[i]..self.start[i + 1]]
    }
}

struct Assembly {
    triplets: Vec<Triplet>,
    rhs: Vec<f64>,
    square: Vec<(u32, f64)>,
}

impl Assembly {
    /// ½a·(Σ p_k y_k + c)², the variables of p distinct.
    fn add_outer(&mut self, p: &[(u32, f64)], c: f64, a: f64) {
        for (at, &(k, pk)) in p.iter().enumerate() {
            p[at..].iter().for_each(|&(l, pl)| self.triplets.push((k, l, a * pk * pl)));
            self.rhs[k as usize] -= a * pk * c;
        }
    }

    /// w·(Σ c_k x_k − d)²: substituted first, squared after.
    fn add_square(&mut self, square: Square, substitution: &Substitution) {
        let mut row = std::mem::take(&mut self.square);
        row.clear();
        let mut constant = -square.target;
        for &(i, c) in square.terms {
            let (terms, offset) = substitution.expression(i);
            constant += c * offset;
            terms.iter().for_each(|&(k, b)| add_term(&mut row, k, c * b));
        }
        self.add_outer(&row, constant, 2.0 * square.weight);
        self.square = row;
    }
}

/// Squares are short, a few dozen terms at most after substitution, so a linear search is quickest.
fn add_term(row: &mut Vec<(u32, f64)>, k: u32, c: f64) {
    match row.iter_mut().find(|(j, _)| *j == k) {
        Some((_, sum)) => *sum += c,
        None => row.push((k, c)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constraints::Constraints;

    /// The reduced energy differs from the full one by a constant, whatever y.
    #[test]
    fn reduced_energy_follows_the_full_energy() {
        let mut quadratic = Quadratic::new(5);
        for i in 0..5 {
            quadratic.add(i, i, 3.0 + i as f64);
            quadratic.add_rhs(i, 1.0 - i as f64);
        }
        quadratic.add(0, 3, 0.5);
        quadratic.add(4, 1, -0.75);
        quadratic.add_square(&[(0, 1.0), (1, 2.0), (2, -1.0), (0, 0.5)], 0.3, 2.0);
        let mut constraints = Constraints::new();
        constraints.add(&[(0, 1.0), (1, -1.0), (2, 2.0)], 1.0, 0);
        constraints.add(&[(3, 1.0), (4, 1.0)], 2.0, 1);
        let elimination = Elimination::eliminate(5, &constraints, &[false; 5]).unwrap();
        let mut given = vec![None; elimination.free().len()];
        given[1] = Some(0.7);
        let substitution = Substitution::new(&elimination, &given);
        let reduced = reduce(&quadratic, &substitution);
        let difference = |t: f64| {
            let mut y = vec![0.7; 3];
            substitution.active.iter().enumerate().for_each(|(at, &k)| y[k as usize] = t * (at as f64 + 1.0).sin());
            let active: Vec<f64> = substitution.active.iter().map(|&k| y[k as usize]).collect();
            let ay = reduced.matrix.multiply(&active);
            let small: f64 = (0..active.len()).map(|k| active[k] * (0.5 * ay[k] - reduced.rhs[k])).sum();
            quadratic.energy(&elimination.expand(&y)) - small
        };
        for t in [-3.0, 0.5, 10.0] {
            assert!((difference(t) - difference(0.0)).abs() < 1e-10);
        }
    }

    /// Seams of surfaces with many handles make every variable depend on the same few integers, whose columns of B are
    /// full: the product row by row must still be Bᵀ·A·B, here by dense arithmetic.
    #[test]
    fn columns_that_every_variable_depends_on_are_multiplied_right() {
        let (free, followers) = (3, 40);
        let n = free + followers;
        let mut quadratic = Quadratic::new(n);
        let coefficient = |i: usize, j: usize| ((i * 7 + j * 3) % 11) as f64 - 5.0;
        for i in 0..n {
            quadratic.add(i, i, 50.0 + i as f64);
            for j in i + 1..n {
                quadratic.add(i, j, 0.1 * coefficient(i, j));
            }
            quadratic.add_rhs(i, coefficient(i, i + 1));
        }
        let follows = |i: usize, k: usize| 1.0 + (i % (k + 2)) as f64;
        let mut constraints = Constraints::new();
        for i in free..n {
            let mut row = vec![(i, 1.0)];
            row.extend((0..free).map(|k| (k, -follows(i, k))));
            constraints.add(&row, 0.25 * i as f64, i);
        }
        // The first variables are integers, so that the others are the pivots.
        let is_integer: Vec<bool> = (0..n).map(|i| i < free).collect();
        let elimination = Elimination::eliminate(n, &constraints, &is_integer).unwrap();
        assert_eq!(elimination.free(), [0, 1, 2]);
        let substitution = Substitution::new(&elimination, &[None; 3]);
        assert!((free..n).all(|i| substitution.expression(i).0.len() == free), "every column is full");
        let reduced = reduce(&quadratic, &substitution);
        let b = |i: usize, k: usize| if i < free { f64::from(u8::from(i == k)) } else { follows(i, k) };
        let c = |i: usize| if i < free { 0.0 } else { 0.25 * i as f64 };
        let a = |i: usize, j: usize| match i.cmp(&j) {
            std::cmp::Ordering::Equal => 50.0 + i as f64,
            _ => 0.1 * coefficient(i.min(j), i.max(j)),
        };
        for k in 0..free {
            let unit: Vec<f64> = (0..free).map(|l| f64::from(u8::from(l == k))).collect();
            let column = reduced.matrix.multiply(&unit);
            for (l, &entry) in column.iter().enumerate() {
                let wanted: f64 =
                    (0..n).flat_map(|i| (0..n).map(move |j| (i, j))).map(|(i, j)| b(i, l) * a(i, j) * b(j, k)).sum();
                assert!((entry - wanted).abs() < 1e-9 * wanted.abs().max(1.0), "{k} {l}: {entry} {wanted}");
            }
            let shifted = |i: usize| coefficient(i, i + 1) - (0..n).map(|j| a(i, j) * c(j)).sum::<f64>();
            let wanted: f64 = (0..n).map(|i| b(i, k) * shifted(i)).sum();
            assert!((reduced.rhs[k] - wanted).abs() < 1e-9 * wanted.abs().max(1.0));
        }
    }
}
