//! Substitution of eliminated and fixed variables into an energy.
//!
//! In: a [`Quadratic`] and a [`Substitution`]. Out: [`Reduced`], the matrix and right-hand side over the
//! variables that remain. Holds: sums run in the order given; equal input gives equal bytes.
//!
//! Source: [Bommes2012] §5.1.2, Eq. (5.8)-(5.10): Ã = BᵀAB, b̃ = Bᵀ(b − Ac).

use crate::elimination::Elimination;
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
}

/// The energy over the active variables.
pub(crate) fn reduce(quadratic: &Quadratic, substitution: &Substitution) -> Reduced {
    let n = substitution.active.len();
    let mut assembly = Assembly { triplets: Vec::new(), rhs: vec![0.0; n], square: Vec::new() };
    for &(i, j, a) in quadratic.entries() {
        assembly.add_entry(substitution.expression(i), substitution.expression(j), i == j, a);
    }
    for &(i, b) in quadratic.rhs() {
        substitution.expression(i).0.iter().for_each(|&(k, c)| assembly.rhs[k as usize] += b * c);
    }
    for square in quadratic.squares() {
        assembly.add_square(square, substitution);
    }
    Reduced { matrix: SparseSymmetric::from_triplets(n, &assembly.triplets), rhs: assembly.rhs }
}

struct Assembly {
    triplets: Vec<Triplet>,
    rhs: Vec<f64>,
    square: Vec<(u32, f64)>,
}

impl Assembly {
    /// a·x_i·x_j, or ½a·x_i² on the diagonal, with x_i = Σ p_k y_k + c and x_j = Σ q_l y_l + e.
    fn add_entry(&mut self, (p, c): (&[(u32, f64)], f64), (q, e): (&[(u32, f64)], f64), diagonal: bool, a: f64) {
        if diagonal {
            return self.add_outer(p, c, a);
        }
        for &(k, pk) in p {
            for &(l, ql) in q {
                let twice = if k == l { 2.0 } else { 1.0 };
                self.triplets.push((k, l, twice * a * pk * ql));
            }
        }
        p.iter().for_each(|&(k, pk)| self.rhs[k as usize] -= a * pk * e);
        q.iter().for_each(|&(l, ql)| self.rhs[l as usize] -= a * ql * c);
    }

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
}
