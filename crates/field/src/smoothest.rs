//! The globally optimal direction field as a start, rounded to period jumps.
//!
//! In: mesh, transport, roots. Out: an angle per face. Holds: hard directions exactly; elsewhere near the minimiser of
//! a convex relaxation of Eq. (8.1) in which a cross is a complex number z = e^{4iθ} of free length.
//! Not: the minimiser itself. It is solved exactly on a coarsened dual graph, then smoothed level by level; the local
//! search that follows would not notice the difference.
//! Source: [Knoppel2013] §3 (connection Laplacian, inverse iteration), here on faces with the hard directions of
//! [Bommes2012] §8.2; 4·p·π/2 is a whole turn, so the period jumps drop out. Cascade of Galerkin products over
//! aggregates of four: our own.

use crate::error::FieldError;
use crate::system::{Roots, interior_edges, neighbours, number_free_faces, solve_error};
use crate::transport::Transport;
use glam::DVec2;
use quadloom_mesh::topology::components;
use quadloom_mesh::{FaceMap, Progress, TriConnectivity};
use quadloom_numeric::{SparseCholesky, SparseSymmetric, Triplet};

/// Shift of the diagonal, so that a field without turn (a flat torus) leaves the matrix definite.
///
/// Larger: inverse iteration converges more slowly. Smaller: pivots near rounding errors.
const SHIFT: f64 = 1e-7;

/// Steps of inverse iteration at most, where no direction is given.
///
/// On a torus the regular field and those with a quarter turn more around the ring have close eigenvalues: six steps
/// leave a mixture, from which no local search finds back.
const INVERSE_STEPS: usize = 60;

/// Relative change of the eigenvector at which inverse iteration ends.
const EIGENVECTOR_TOLERANCE: f64 = 1e-4;

/// Unknowns at which coarsening stops and the system is solved exactly.
///
/// Larger: a better start for more time (at 20,000 faces the exact solve takes half of the whole field's time).
pub(crate) const COARSEST: usize = 1500;

/// Gauss-Seidel sweeps after each prolongation, forward and backward in turn.
const SWEEPS: usize = 8;

/// Angles of the smoothest direction field, radians; solved exactly once at most `coarsest` unknowns are left.
///
/// # Cost       linear, but for one factorisation at `coarsest` unknowns
pub(crate) fn smoothest_angles(
    mesh: &TriConnectivity,
    transport: &Transport,
    roots: &Roots,
    coarsest: usize,
    progress: &Progress,
) -> Result<FaceMap<f64>, FieldError> {
    // 1. An anchor is a gauge, not a constraint: it is free here.
    let mut fixed = roots.fixed.clone();
    for &f in &roots.anchors {
        fixed[f] = None;
    }
    let (variable, n) = number_free_faces(&fixed);
    // 2. Coarser and coarser.
    let mut levels = vec![finest_level(mesh, transport, roots, &fixed, &variable, n)];
    let mut parents: Vec<Vec<Child>> = Vec::new();
    while levels[levels.len() - 1].len() > coarsest {
        progress.check()?;
        let fine = &levels[levels.len() - 1];
        let children = fine.aggregate();
        let coarse = fine.coarsened(&children);
        if 10 * coarse.len() > 9 * fine.len() {
            break;
        }
        levels.push(coarse);
        parents.push(children);
    }
    // 3. Exactly on the coarsest level; prolongation and smoothing down to the finest.
    let mut z = levels[levels.len() - 1].solve()?;
    for (fine, children) in levels.iter().zip(&parents).rev() {
        progress.check()?;
        z = children.iter().map(|c| c.turn.rotate(z[c.parent as usize])).collect();
        fine.smooth(&mut z);
    }
    // 4. Back to angles.
    let angle_of = |z: DVec2| 0.25 * z.y.atan2(z.x);
    Ok(FaceMap::from_fn(mesh.face_count(), |f| fixed[f].unwrap_or_else(|| angle_of(z[variable[f] as usize]))))
}

/// Hermitian system over complex unknowns: d_i z_i + Σ a_ij z_j = c_i.
struct Level {
    row_start: Vec<u32>,
    columns: Vec<u32>,
    /// Off-diagonal entries a_ij as complex numbers.
    entries: Vec<DVec2>,
    diagonal: Vec<f64>,
    constant: Vec<DVec2>,
    /// Component of each unknown, and whether a component has no constraint.
    part: Vec<u32>,
    loose: Vec<bool>,
}

/// Where a fine unknown went: z = turn · z_parent.
#[derive(Clone, Copy, Debug)]
struct Child {
    parent: u32,
    turn: DVec2,
}

/// Connection Laplacian Σ |z_j - e^{4iκ} z_i|² + Σ w·|z_f - e^{4iα}|² over the free faces.
fn finest_level(
    mesh: &TriConnectivity,
    transport: &Transport,
    roots: &Roots,
    fixed: &FaceMap<Option<f64>>,
    variable: &FaceMap<u32>,
    n: usize,
) -> Level {
    let unit = |angle: f64| DVec2::from_angle(4.0 * angle);
    let (mut diagonal, mut constant) = (vec![SHIFT; n], vec![DVec2::ZERO; n]);
    let mut pairs = Vec::with_capacity(3 * n / 2);
    for f in mesh.faces().filter(|&f| fixed[f].is_none()) {
        let k = variable[f] as usize;
        diagonal[k] += neighbours(mesh, f).count() as f64;
        if let Some(s) = roots.soft[f] {
            diagonal[k] += s.weight;
            constant[k] += s.weight * unit(s.angle);
        }
    }
    for (i, j, e) in interior_edges(mesh) {
        let turn = unit(transport.kappa(mesh, mesh.half_edge(e)));
        match (fixed[i], fixed[j]) {
            (None, None) => pairs.push((variable[j], variable[i], -turn)),
            (Some(angle), None) => constant[variable[j] as usize] += turn.rotate(unit(angle)),
            (None, Some(angle)) => constant[variable[i] as usize] += conjugate(turn).rotate(unit(angle)),
            (Some(_), Some(_)) => {}
        }
    }
    let parts = components(mesh);
    let mut loose = vec![false; parts.count];
    roots.anchors.iter().for_each(|&f| loose[parts.of_face[f] as usize] = true);
    let mut part = vec![0; n];
    mesh.faces().filter(|&f| fixed[f].is_none()).for_each(|f| part[variable[f] as usize] = parts.of_face[f]);
    Level::new(diagonal, constant, part, loose, &pairs)
}

impl Level {
    /// `pairs`: (row, column, entry), each unordered pair any number of times; the mirror entries are conjugates.
    fn new(
        diagonal: Vec<f64>,
        constant: Vec<DVec2>,
        part: Vec<u32>,
        loose: Vec<bool>,
        pairs: &[(u32, u32, DVec2)],
    ) -> Self {
        let n = diagonal.len();
        // 1. Bucket by row.
        let mut start = vec![0u32; n + 1];
        for &(i, j, _) in pairs {
            start[i as usize + 1] += 1;
            start[j as usize + 1] += 1;
        }
        (0..n).for_each(|k| start[k + 1] += start[k]);
        let mut next = start.clone();
        let mut bucket = vec![(0u32, DVec2::ZERO); 2 * pairs.len()];
        for &(i, j, a) in pairs {
            for (row, column, value) in [(i, j, a), (j, i, conjugate(a))] {
                bucket[next[row as usize] as usize] = (column, value);
                next[row as usize] += 1;
            }
        }
        // 2. Sum repeats.
        let mut level =
            Self { row_start: vec![0], columns: Vec::new(), entries: Vec::new(), diagonal, constant, part, loose };
        for k in 0..n {
            let row = &mut bucket[start[k] as usize..start[k + 1] as usize];
            row.sort_by_key(|&(column, _)| column);
            let first = level.columns.len();
            for &(column, value) in row.iter() {
                if level.columns.len() > first && level.columns[level.columns.len() - 1] == column {
                    let last = level.entries.len() - 1;
                    level.entries[last] += value;
                } else {
                    level.columns.push(column);
                    level.entries.push(value);
                }
            }
            level.row_start.push(level.columns.len() as u32);
        }
        level
    }

    fn len(&self) -> usize {
        self.diagonal.len()
    }

    fn row(&self, i: usize) -> impl Iterator<Item = (usize, DVec2)> + '_ {
        let range = self.row_start[i] as usize..self.row_start[i + 1] as usize;
        self.columns[range.clone()].iter().map(|&j| j as usize).zip(self.entries[range].iter().copied())
    }

    /// Aggregates of about four unknowns: each free unknown takes its free neighbours, at most three.
    ///
    /// A member's turn is the phase of -a_ij, which makes its entry with the centre real and negative.
    fn aggregate(&self) -> Vec<Child> {
        const NONE: u32 = u32::MAX;
        let mut children = vec![Child { parent: NONE, turn: DVec2::X }; self.len()];
        let mut count = 0;
        for i in 0..self.len() {
            if children[i].parent != NONE {
                continue;
            }
            let open: Vec<(usize, DVec2)> = self.row(i).filter(|&(j, _)| children[j].parent == NONE).collect();
            if open.is_empty() {
                // A left-over joins its strongest neighbour's aggregate.
                let strongest = self.row(i).max_by(|a, b| a.1.length().total_cmp(&b.1.length()));
                if let Some((j, a)) = strongest.filter(|(_, a)| *a != DVec2::ZERO) {
                    let turn = (-a).normalize().rotate(children[j].turn);
                    children[i] = Child { parent: children[j].parent, turn };
                    continue;
                }
            }
            children[i].parent = count;
            for (j, a) in open.into_iter().take(3) {
                // Row i reads z_i = -a_ij z_j / d: the neighbour that agrees has z_j = phase(-conj a_ij) z_i.
                children[j] = Child { parent: count, turn: (-conjugate(a)).normalize_or(DVec2::X) };
            }
            count += 1;
        }
        children
    }

    /// Galerkin product Pᴴ·A·P for the prolongation z = turn · z_parent.
    fn coarsened(&self, children: &[Child]) -> Self {
        let n = children.iter().map(|c| c.parent as usize + 1).max().unwrap_or(0);
        let (mut diagonal, mut constant, mut part) = (vec![0.0; n], vec![DVec2::ZERO; n], vec![0; n]);
        let mut pairs = Vec::with_capacity(self.columns.len() / 4);
        for i in 0..self.len() {
            let here = children[i];
            let p = here.parent as usize;
            diagonal[p] += self.diagonal[i];
            constant[p] += conjugate(here.turn).rotate(self.constant[i]);
            part[p] = self.part[i];
            for (j, a) in self.row(i).filter(|&(j, _)| j > i) {
                let there = children[j];
                let entry = conjugate(here.turn).rotate(a.rotate(there.turn));
                if there.parent == here.parent {
                    diagonal[p] += 2.0 * entry.x;
                } else {
                    pairs.push((here.parent, there.parent, entry));
                }
            }
        }
        Self::new(diagonal, constant, part, self.loose.clone(), &pairs)
    }

    /// Gauss-Seidel sweeps.
    fn smooth(&self, z: &mut [DVec2]) {
        for sweep in 0..SWEEPS {
            for k in 0..self.len() {
                let i = if sweep % 2 == 0 { k } else { self.len() - 1 - k };
                let pull = self.row(i).fold(self.constant[i], |sum, (j, a)| sum - a.rotate(z[j]));
                z[i] = pull / self.diagonal[i];
            }
        }
    }

    /// The exact solution; the lowest eigenvector in components without constraint.
    fn solve(&self) -> Result<Vec<DVec2>, FieldError> {
        let matrix = self.real_matrix();
        let mut factor = SparseCholesky::analyse(&matrix, &[]).map_err(solve_error)?;
        factor.factorize(&matrix).map_err(solve_error)?;
        let mut z = self.constant.iter().flat_map(|c| c.to_array()).collect::<Vec<_>>();
        factor.solve(&mut z);
        let mut z: Vec<DVec2> = z.chunks_exact(2).map(DVec2::from_slice).collect();
        if self.loose.contains(&true) {
            let eigenvector = self.inverse_iteration(&factor);
            for (k, value) in eigenvector.into_iter().enumerate().filter(|&(k, _)| self.loose[self.part[k] as usize]) {
                z[k] = value;
            }
        }
        Ok(z)
    }

    /// Real and imaginary parts as unknowns 2k and 2k + 1.
    fn real_matrix(&self) -> SparseSymmetric {
        let mut triplets: Vec<Triplet> = Vec::with_capacity(2 * self.len() + 2 * self.columns.len());
        for i in 0..self.len() {
            let row = 2 * i as u32;
            triplets.extend([(row, row, self.diagonal[i]), (row + 1, row + 1, self.diagonal[i])]);
            for (j, a) in self.row(i).filter(|&(j, _)| j > i) {
                let column = 2 * j as u32;
                triplets.extend([
                    (row, column, a.x),
                    (row, column + 1, -a.y),
                    (row + 1, column, a.y),
                    (row + 1, column + 1, a.x),
                ]);
            }
        }
        SparseSymmetric::from_triplets(2 * self.len(), &triplets)
    }

    /// The lowest eigenvector of every component, each of unit length.
    fn inverse_iteration(&self, factor: &SparseCholesky) -> Vec<DVec2> {
        let mut z = deterministic_start(2 * self.len());
        for _ in 0..INVERSE_STEPS {
            let before = z.clone();
            factor.solve(&mut z);
            let mut square = vec![0.0; self.loose.len()];
            z.iter().enumerate().for_each(|(k, x)| square[self.part[k / 2] as usize] += x * x);
            let scale: Vec<f64> = square.iter().map(|&s: &f64| if s > 0.0 { 1.0 / s.sqrt() } else { 0.0 }).collect();
            z.iter_mut().enumerate().for_each(|(k, x)| *x *= scale[self.part[k / 2] as usize]);
            let change: f64 = z.iter().zip(&before).map(|(x, y)| (x - y).powi(2)).sum();
            if change < EIGENVECTOR_TOLERANCE.powi(2) {
                break;
            }
        }
        z.chunks_exact(2).map(DVec2::from_slice).collect()
    }
}

fn conjugate(z: DVec2) -> DVec2 {
    DVec2::new(z.x, -z.y)
}

/// Numbers in -1..1 without pattern, the same in every run (a linear congruential sequence).
fn deterministic_start(n: usize) -> Vec<f64> {
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    (0..n)
        .map(|_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        })
        .collect()
}
