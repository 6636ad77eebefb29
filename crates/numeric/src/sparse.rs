//! Symmetric sparse matrices in compressed rows.
//!
//! In: triplets of one triangle. Out: [`SparseSymmetric`], both triangles, columns sorted in each row.
//! Holds: repeated triplets are summed in the order given, so equal input gives equal bytes.

/// One entry above or on the diagonal: row ≤ column is not required, the pair is unordered.
pub type Triplet = (u32, u32, f64);

/// Symmetric matrix, n × n, stored with both triangles in compressed rows.
#[derive(Debug, Clone, PartialEq)]
pub struct SparseSymmetric {
    row_start: Vec<u32>,
    columns: Vec<u32>,
    values: Vec<f64>,
}

impl SparseSymmetric {
    /// The matrix with a at (i, j) and at (j, i) for each triplet (i, j, a); repeats are summed.
    ///
    /// # Cost  linear in the triplets, plus sorting each row; a triplet out of range is ignored
    pub fn from_triplets(n: usize, triplets: &[Triplet]) -> Self {
        let buckets = bucket_upper(n, triplets);
        mirror(n, &sum_rows(n, &buckets))
    }

    /// Number of rows.
    pub fn n(&self) -> usize {
        self.row_start.len() - 1
    }

    /// Number of stored entries, both triangles.
    pub fn stored(&self) -> usize {
        self.columns.len()
    }

    /// Columns and values of row `i`, columns ascending.
    pub fn row(&self, i: usize) -> (&[u32], &[f64]) {
        let range = self.row_start[i] as usize..self.row_start[i + 1] as usize;
        (&self.columns[range.clone()], &self.values[range])
    }

    /// The diagonal; 0 where nothing is stored.
    pub fn diagonal(&self) -> Vec<f64> {
        (0..self.n()).map(|i| self.get(i, i)).collect()
    }

    /// Entry (i, j); 0 where nothing is stored.
    pub fn get(&self, i: usize, j: usize) -> f64 {
        let (columns, values) = self.row(i);
        columns.binary_search(&(j as u32)).map_or(0.0, |at| values[at])
    }

    /// A·x.
    pub fn multiply(&self, x: &[f64]) -> Vec<f64> {
        (0..self.n()).map(|i| self.row_dot(i, x)).collect()
    }

    /// Row `i` times x.
    pub fn row_dot(&self, i: usize, x: &[f64]) -> f64 {
        let (columns, values) = self.row(i);
        columns.iter().zip(values).map(|(&j, a)| a * x[j as usize]).sum()
    }

    /// Whether both matrices store entries in the same places.
    pub fn same_pattern(&self, other: &Self) -> bool {
        self.row_start == other.row_start && self.columns == other.columns
    }

    /// The matrix of the same pattern whose rows and columns in `fixed` are those of the identity
    /// ([Bommes2012] §5.2.2, after Eq. (5.10): no re-indexing).
    pub fn with_identity_rows(&self, fixed: &[bool]) -> Self {
        let mut masked = self.clone();
        for i in 0..self.n() {
            for at in self.row_start[i] as usize..self.row_start[i + 1] as usize {
                let j = self.columns[at] as usize;
                if fixed[i] || fixed[j] {
                    masked.values[at] = f64::from(i == j);
                }
            }
        }
        masked
    }

    pub(crate) fn row_starts(&self) -> &[u32] {
        &self.row_start
    }

    pub(crate) fn columns(&self) -> &[u32] {
        &self.columns
    }

    pub(crate) fn values(&self) -> &[f64] {
        &self.values
    }
}

/// Rows of (column, value), flat.
struct Rows {
    start: Vec<u32>,
    entries: Vec<(u32, f64)>,
}

/// Step 1: the triplets, as (column ≥ row, value), gathered by row in the order given.
fn bucket_upper(n: usize, triplets: &[Triplet]) -> Rows {
    let in_range = |&&(i, j, _): &&Triplet| (i as usize) < n && (j as usize) < n;
    let mut start = vec![0u32; n + 1];
    for &(i, j, _) in triplets.iter().filter(in_range) {
        start[i.min(j) as usize + 1] += 1;
    }
    accumulate(&mut start);
    let mut next = start.clone();
    let mut entries = vec![(0, 0.0); start[n] as usize];
    for &(i, j, a) in triplets.iter().filter(in_range) {
        let row = i.min(j) as usize;
        entries[next[row] as usize] = (i.max(j), a);
        next[row] += 1;
    }
    Rows { start, entries }
}

/// Step 2: repeats summed, columns sorted.
fn sum_rows(n: usize, rows: &Rows) -> Rows {
    const ABSENT: u32 = u32::MAX;
    let mut place = vec![ABSENT; n];
    let mut summed = Rows { start: vec![0], entries: Vec::with_capacity(rows.entries.len() / 2) };
    for i in 0..n {
        let first = summed.entries.len();
        for &(j, a) in &rows.entries[rows.start[i] as usize..rows.start[i + 1] as usize] {
            let at = &mut place[j as usize];
            if *at == ABSENT {
                *at = summed.entries.len() as u32;
                summed.entries.push((j, a));
            } else {
                summed.entries[*at as usize].1 += a;
            }
        }
        let row = &mut summed.entries[first..];
        row.iter().for_each(|&(j, _)| place[j as usize] = ABSENT);
        row.sort_unstable_by_key(|&(j, _)| j);
        summed.start.push(summed.entries.len() as u32);
    }
    summed
}

/// Step 3: the lower triangle added. Ascending rows fill each lower part in ascending order.
fn mirror(n: usize, upper: &Rows) -> SparseSymmetric {
    let row = |i: usize| &upper.entries[upper.start[i] as usize..upper.start[i + 1] as usize];
    let mut row_start = vec![0u32; n + 1];
    for i in 0..n {
        for &(j, _) in row(i) {
            row_start[i + 1] += 1;
            row_start[j as usize + 1] += u32::from(j as usize != i);
        }
    }
    accumulate(&mut row_start);
    let stored = row_start[n] as usize;
    let (mut columns, mut values) = (vec![0; stored], vec![0.0; stored]);
    let mut next = row_start.clone();
    let mut put = |i: usize, j: u32, a: f64| {
        columns[next[i] as usize] = j;
        values[next[i] as usize] = a;
        next[i] += 1;
    };
    for i in 0..n {
        for &(j, a) in row(i) {
            put(i, j, a);
            if j as usize != i {
                put(j as usize, i as u32, a);
            }
        }
    }
    SparseSymmetric { row_start, columns, values }
}

/// Counts at 1.. become starts.
pub(crate) fn accumulate(counts: &mut [u32]) {
    for i in 1..counts.len() {
        counts[i] += counts[i - 1];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repeats_are_summed_and_mirrored() {
        let matrix = SparseSymmetric::from_triplets(3, &[(2, 0, 1.0), (1, 1, 4.0), (0, 2, 2.0), (0, 0, 5.0)]);
        assert_eq!(matrix.row(0), (&[0, 2][..], &[5.0, 3.0][..]));
        assert_eq!(matrix.row(1), (&[1][..], &[4.0][..]));
        assert_eq!(matrix.row(2), (&[0][..], &[3.0][..]));
        assert_eq!(matrix.multiply(&[1.0, 2.0, 3.0]), vec![14.0, 8.0, 3.0]);
        assert_eq!(matrix.diagonal(), vec![5.0, 4.0, 0.0]);
    }

    #[test]
    fn rows_are_sorted_whatever_the_order_of_the_triplets() {
        let mut triplets: Vec<Triplet> = (0..40).map(|k| ((k * 7) % 9, (k * 5) % 9, f64::from(k))).collect();
        let first = SparseSymmetric::from_triplets(9, &triplets);
        triplets.reverse();
        assert!(first.same_pattern(&SparseSymmetric::from_triplets(9, &triplets)));
        for i in 0..9 {
            assert!(first.row(i).0.windows(2).all(|pair| pair[0] < pair[1]));
        }
    }
}
