//! A small deterministic random generator and dense linear algebra, independent of the crate under test.
#![allow(dead_code)] // Each test program uses its own part of it.

/// xorshift64*, seeded.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    pub fn bits(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 16
    }

    /// An integer in from..to.
    pub fn integer(&mut self, from: i64, to: i64) -> i64 {
        from + (self.bits() % (to - from) as u64) as i64
    }

    /// A real number in from..to.
    pub fn real(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * (self.bits() % (1 << 30)) as f64 / (1u64 << 30) as f64
    }
}

/// Solves the augmented rows [M | r] by Gauss with full row pivoting. None: no solution. Free unknowns are 0.
pub fn gauss(mut rows: Vec<Vec<f64>>, unknowns: usize) -> Option<Vec<f64>> {
    let mut pivots = Vec::new();
    let mut next = 0;
    for column in 0..unknowns {
        let best = (next..rows.len()).max_by(|&a, &b| rows[a][column].abs().total_cmp(&rows[b][column].abs()));
        let Some(best) = best.filter(|&r| rows[r][column].abs() > 1e-9) else { continue };
        rows.swap(next, best);
        let pivot = rows[next].clone();
        for (r, row) in rows.iter_mut().enumerate() {
            if r != next && row[column] != 0.0 {
                let f = row[column] / pivot[column];
                row.iter_mut().zip(&pivot).for_each(|(a, b)| *a -= f * b);
            }
        }
        pivots.push(column);
        next += 1;
    }
    if rows[next..].iter().any(|row| row[unknowns].abs() > 1e-7) {
        return None;
    }
    let mut x = vec![0.0; unknowns];
    pivots.iter().enumerate().for_each(|(r, &c)| x[c] = rows[r][unknowns] / rows[r][c]);
    Some(x)
}
