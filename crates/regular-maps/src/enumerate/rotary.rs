//! The rotation group of a map, by its darts.
//!
//! In: the other side of each dart. Out: its flags, its mirror image, its dual; whether two maps are equal.
//! Holds: darts of [`RotaryTable`] are numbered as a breadth-first search along R, x from dart 0 meets them, so equal
//! maps have equal tables.

use super::search::Found;

/// Row d holds d·R and d·x.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct RotaryTable(Vec<[u32; 2]>);

impl RotaryTable {
    /// The table of a map with faces of p darts.
    pub(super) fn of(found: &Found, p: usize) -> Self {
        let next = |d: usize| if d % p + 1 == p { d + 1 - p } else { d + 1 };
        let rows: Vec<_> = found.across.iter().enumerate().map(|(d, &x)| [next(d) as u32, x]).collect();
        Self(numbered(&rows))
    }

    pub(super) fn mirror(&self) -> Self {
        let back = self.inverse_of_r();
        Self(numbered(&self.rows_by(|d| [back[d], self.0[d][1]])))
    }

    /// Faces and vertices change places: S⁻¹ = xR for R.
    pub(super) fn dual(&self) -> Self {
        Self(numbered(&self.rows_by(|d| [self.0[self.0[d][1] as usize][0], self.0[d][1]])))
    }

    /// The flags: dart d is flag 2d, and 2d + 1 is its image under r₁.
    pub(super) fn flags(&self) -> Vec<[u32; 3]> {
        let back = self.inverse_of_r();
        let mut rows = Vec::with_capacity(2 * self.0.len());
        for (d, &[next, across]) in self.0.iter().enumerate() {
            let spun = self.0[across as usize][0];
            rows.push([2 * next + 1, 2 * d as u32 + 1, 2 * spun + 1]);
            rows.push([2 * back[d], 2 * d as u32, 2 * self.0[back[d] as usize][1]]);
        }
        rows
    }

    fn rows_by(&self, row: impl Fn(usize) -> [u32; 2]) -> Vec<[u32; 2]> {
        (0..self.0.len()).map(row).collect()
    }

    fn inverse_of_r(&self) -> Vec<u32> {
        let mut back = vec![0; self.0.len()];
        for (d, row) in self.0.iter().enumerate() {
            back[row[0] as usize] = d as u32;
        }
        back
    }
}

fn numbered(rows: &[[u32; 2]]) -> Vec<[u32; 2]> {
    let mut number = vec![u32::MAX; rows.len()];
    let mut order = vec![0u32];
    number[0] = 0;
    let mut at = 0;
    while at < order.len() {
        for to in rows[order[at] as usize] {
            if number[to as usize] == u32::MAX {
                number[to as usize] = order.len() as u32;
                order.push(to);
            }
        }
        at += 1;
    }
    order.iter().map(|&d| rows[d as usize].map(|to| number[to as usize])).collect()
}
