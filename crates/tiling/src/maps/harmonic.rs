//! Systems that put every interior vertex at a weighted mean of its neighbours.
//!
//! In: weights per interior vertex and neighbour, places of the border. Out: places of all vertices. Holds: residuals
//! are sums of weighted differences of places, so that refinement makes places as exact as doubles are, whatever the
//! condition; sequential, so equal input gives equal bytes.

use super::MapMethod;
use super::disk::{Disk, NONE};
use super::error::MapError;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::lu::{LuRef, NumericLu, SymbolicLu, factorize_symbolic_lu};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par};
use quadloom_mesh::{DVec2, HalfEdgeId, TriMesh, VertexId, VertexMap};

/// Steps of iterative refinement after the first solution.
const REFINEMENTS: usize = 2;

/// Weights of the neighbours of each interior vertex.
#[derive(Clone)]
pub(super) struct Rows {
    /// Where the neighbours of each interior vertex start.
    start: Vec<u32>,
    /// Neighbours, counter-clockwise.
    pub neighbour: Vec<VertexId>,
    /// Their weights.
    pub weight: Vec<f64>,
}

impl Rows {
    /// Weights by outgoing half-edges of interior vertices.
    pub fn new(mesh: &TriMesh, disk: &Disk, weight: impl Fn(HalfEdgeId) -> f64) -> Self {
        let mut rows = Self { start: vec![0], neighbour: Vec::new(), weight: Vec::new() };
        for &v in &disk.interior {
            for h in mesh.outgoing(v) {
                rows.neighbour.push(mesh.target(h));
                rows.weight.push(weight(h));
            }
            rows.start.push(rows.neighbour.len() as u32);
        }
        rows
    }

    /// Entries of an interior vertex.
    pub fn row(&self, i: usize) -> std::ops::Range<usize> {
        self.start[i] as usize..self.start[i + 1] as usize
    }

    /// Number of interior vertices.
    pub fn len(&self) -> usize {
        self.start.len() - 1
    }

    /// Σ_j w_ij (p_j − p_i) of every interior vertex i.
    fn pulls(&self, disk: &Disk, place: &VertexMap<DVec2>) -> Vec<DVec2> {
        let pull = |i: usize| {
            let p = place[disk.interior[i]];
            self.row(i).map(|at| self.weight[at] * (place[self.neighbour[at]] - p)).sum()
        };
        (0..self.len()).map(pull).collect()
    }

    /// Moves interior vertices to where their pulls vanish, by solves of A·x = pulls, two columns at a time.
    pub fn settle(&self, disk: &Disk, place: &mut VertexMap<DVec2>, solve: impl Fn(&mut [f64])) {
        for _ in 0..=REFINEMENTS {
            let pulls = self.pulls(disk, place);
            let mut step: Vec<f64> = pulls.iter().map(|p| p.x).chain(pulls.iter().map(|p| p.y)).collect();
            solve(&mut step);
            for (i, &v) in disk.interior.iter().enumerate() {
                place[v] += DVec2::new(step[i], step[self.len() + i]);
            }
        }
    }
}

/// Non-symmetric systems of one pattern: Σ_j w_ij (x_i − x_j) of interior vertices i, where border vertices have x = 0.
pub(super) struct RowSolver {
    matrix: Compressed,
    symbolic: SymbolicLu<u32>,
}

/// Compressed rows, columns ascending; and which entry of [`Rows`] each comes from ([`NONE`]: the diagonal).
struct Compressed {
    start: Vec<u32>,
    column: Vec<u32>,
    source: Vec<u32>,
}

impl RowSolver {
    /// Orders the unknowns.
    pub fn analyse(disk: &Disk, rows: &Rows) -> Result<Self, MapError> {
        let matrix = Compressed::new(disk, rows);
        let symbolic = factorize_symbolic_lu(matrix.pattern(), Default::default()).map_err(fault)?;
        Ok(Self { matrix, symbolic })
    }

    /// Factorises the system of these weights.
    ///
    /// Rows are the columns of the matrix that is factorised: each is dominated by its diagonal, so that partial
    /// pivoting finds the largest entry there and keeps the order of the unknowns.
    pub fn factorize(&self, rows: &Rows) -> Result<Factor<'_>, MapError> {
        let values = self.matrix.values(rows);
        let mut numeric = NumericLu::new();
        let scratch = self.symbolic.factorize_numeric_lu_scratch::<f64>(Par::Seq, Default::default());
        let mut memory = MemBuffer::try_new(scratch).map_err(|_| fault("out of memory"))?;
        let transposed = SparseColMatRef::new(self.matrix.pattern(), &values);
        self.symbolic
            .factorize_numeric_lu(&mut numeric, transposed, Par::Seq, MemStack::new(&mut memory), Default::default())
            .map_err(|e| fault(format!("{e:?}")))?;
        Ok(Factor { solver: self, numeric })
    }
}

/// A factorised system.
pub(super) struct Factor<'a> {
    solver: &'a RowSolver,
    numeric: NumericLu<u32, f64>,
}

impl Factor<'_> {
    /// Replaces columns of right sides by solutions.
    pub fn solve(&self, b: &mut [f64], columns: usize) {
        let symbolic = &self.solver.symbolic;
        let mut memory = MemBuffer::new(symbolic.solve_transpose_in_place_scratch::<f64>(columns, Par::Seq));
        let b = MatMut::from_column_major_slice_mut(b, self.solver.matrix.start.len() - 1, columns);
        LuRef::new_unchecked(symbolic, &self.numeric).solve_transpose_in_place_with_conj(
            Conj::No,
            b,
            Par::Seq,
            MemStack::new(&mut memory),
        );
    }
}

impl Compressed {
    fn new(disk: &Disk, rows: &Rows) -> Self {
        let mut matrix = Self { start: vec![0], column: Vec::new(), source: Vec::new() };
        let mut row: Vec<(u32, u32)> = Vec::new();
        for i in 0..rows.len() {
            row.clear();
            row.push((i as u32, NONE));
            row.extend(rows.row(i).map(|at| (disk.inner[rows.neighbour[at]], at as u32)).filter(|e| e.0 != NONE));
            row.sort_unstable();
            matrix.column.extend(row.iter().map(|e| e.0));
            matrix.source.extend(row.iter().map(|e| e.1));
            matrix.start.push(matrix.column.len() as u32);
        }
        matrix
    }

    /// The pattern of the transposed matrix by columns.
    fn pattern(&self) -> SymbolicSparseColMatRef<'_, u32> {
        let n = self.start.len() - 1;
        SymbolicSparseColMatRef::new_checked(n, n, &self.start, None, &self.column)
    }

    fn values(&self, rows: &Rows) -> Vec<f64> {
        let mut values = Vec::with_capacity(self.source.len());
        for i in 0..rows.len() {
            let total: f64 = rows.row(i).map(|at| rows.weight[at]).sum();
            for &source in &self.source[self.start[i] as usize..self.start[i + 1] as usize] {
                values.push(if source == NONE { total } else { -rows.weight[source as usize] });
            }
        }
        values
    }
}

fn fault(what: impl std::fmt::Debug) -> MapError {
    MapError::Solve { method: MapMethod::MeanValue, what: format!("{what:?}") }
}
