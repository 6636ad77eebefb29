//! The smoothest angles for given period jumps: one sparse least-squares problem over the free faces.
//!
//! In: mesh, transport, constraints. Out: [`SmoothnessSystem`], factorised once: every change of the period jumps
//! changes the right-hand side only ([Bommes2012] §8.2, local search).
//! Holds: every component has a face that is fixed or softly tied, so that the matrix is positive definite.
//! Source: [Bommes2012] §8.2, Eqs. (8.1), (8.2).

use crate::constraints::{FieldConstraints, SoftDirection};
use crate::error::FieldError;
use crate::transport::Transport;
use quadloom_mesh::{EdgeId, EdgeMap, FaceId, FaceMap, TriConnectivity};
use quadloom_numeric::{CholeskyError, SolveError, SparseCholesky, SparseSymmetric, Triplet};
use std::f64::consts::FRAC_PI_2;

const FIXED: u32 = u32::MAX;

/// Hard and soft directions of a solve; every component has at least one of them.
#[derive(Clone, Debug)]
pub(crate) struct Roots {
    /// Angle of the faces that are not free.
    pub fixed: FaceMap<Option<f64>>,
    /// Soft direction of free faces, in the branch that is nearest to the field.
    pub soft: FaceMap<Option<SoftDirection>>,
    /// Faces fixed only because their component has no constraint, ascending.
    pub anchors: Vec<FaceId>,
}

impl Roots {
    /// The constrained faces, and one face of angle 0 per component without any.
    pub fn new(mesh: &TriConnectivity, constraints: &FieldConstraints) -> Self {
        let mut fixed = constraints.angle.clone();
        let soft = FaceMap::from_fn(mesh.face_count(), |f| match fixed[f] {
            Some(_) => None,
            None => constraints.soft[f].filter(|s| s.weight > 0.0),
        });
        let mut seen = FaceMap::filled(mesh.face_count(), false);
        let mut anchors = Vec::new();
        for start in mesh.faces() {
            if seen[start] {
                continue;
            }
            seen[start] = true;
            let (mut stack, mut tied) = (vec![start], false);
            while let Some(f) = stack.pop() {
                tied |= fixed[f].is_some() || soft[f].is_some();
                for g in neighbours(mesh, f) {
                    if !seen[g] {
                        seen[g] = true;
                        stack.push(g);
                    }
                }
            }
            if !tied {
                fixed[start] = Some(0.0);
                anchors.push(start);
            }
        }
        Self { fixed, soft, anchors }
    }

    /// Whether a face is the root of a tree of fixed period jumps.
    pub fn is_root(&self, f: FaceId) -> bool {
        self.fixed[f].is_some() || self.soft[f].is_some()
    }
}

/// The faces across the sides of a face.
pub(crate) fn neighbours(mesh: &TriConnectivity, f: FaceId) -> impl Iterator<Item = FaceId> + '_ {
    mesh.face_half_edges(f).into_iter().filter_map(|h| mesh.twin(h)).map(|t| mesh.face(t))
}

/// Factorised normal equations of Eq. (8.1) in the angles of the free faces.
pub(crate) struct SmoothnessSystem<'a> {
    mesh: &'a TriConnectivity,
    pub roots: Roots,
    variable: FaceMap<u32>,
    variables: usize,
    terms: Vec<EdgeTerm>,
    factor: SparseCholesky,
}

/// An interior edge with what every solve asks of it.
#[derive(Clone, Copy, Debug)]
struct EdgeTerm {
    edge: EdgeId,
    /// Face of the canonical half-edge, and the face across.
    faces: [FaceId; 2],
    /// Their variables, or [`FIXED`].
    variables: [u32; 2],
    kappa: f64,
}

impl<'a> SmoothnessSystem<'a> {
    /// Assembles and factorises the matrix.
    pub fn new(mesh: &'a TriConnectivity, transport: &'a Transport, roots: Roots) -> Result<Self, FieldError> {
        let (variable, variables) = number_free_faces(&roots.fixed);
        let mut triplets: Vec<Triplet> = Vec::with_capacity(4 * variables);
        for f in mesh.faces().filter(|&f| variable[f] != FIXED) {
            let degree = neighbours(mesh, f).count() as f64;
            triplets.push((variable[f], variable[f], degree + roots.soft[f].map_or(0.0, |s| s.weight)));
        }
        for (i, j, _) in interior_edges(mesh) {
            if variable[i] != FIXED && variable[j] != FIXED {
                triplets.push((variable[i], variable[j], -1.0));
            }
        }
        let matrix = SparseSymmetric::from_triplets(variables, &triplets);
        let mut factor = SparseCholesky::analyse(&matrix, &[]).map_err(solve_error)?;
        factor.factorize(&matrix).map_err(solve_error)?;
        let terms = interior_edges(mesh)
            .map(|(i, j, edge)| EdgeTerm {
                edge,
                faces: [i, j],
                variables: [variable[i], variable[j]],
                kappa: transport.kappa(mesh, mesh.half_edge(edge)),
            })
            .collect();
        Ok(Self { mesh, roots, variable, variables, terms, factor })
    }

    /// Number of free faces.
    pub fn free_faces(&self) -> usize {
        self.variables
    }

    /// Whether the angle of a face is free.
    pub fn is_free(&self, f: FaceId) -> bool {
        self.variable[f] != FIXED
    }

    /// The angles that minimise Eq. (8.1) for the given period jumps; exact at fixed faces.
    pub fn angles(&self, period_jump: &EdgeMap<i32>) -> FaceMap<f64> {
        let mut rhs = vec![0.0; self.variables];
        for term in &self.terms {
            let ([i, j], [a, b]) = (term.faces, term.variables);
            let shift = term.kappa + FRAC_PI_2 * f64::from(period_jump[term.edge]);
            if a != FIXED {
                rhs[a as usize] += self.roots.fixed[j].unwrap_or(0.0) - shift;
            }
            if b != FIXED {
                rhs[b as usize] += self.roots.fixed[i].unwrap_or(0.0) + shift;
            }
        }
        for (f, soft) in self.roots.soft.iter() {
            if let Some(s) = soft {
                rhs[self.variable[f] as usize] += s.weight * s.angle;
            }
        }
        self.factor.solve(&mut rhs);
        FaceMap::from_fn(self.mesh.face_count(), |f| match self.variable[f] {
            FIXED => self.roots.fixed[f].unwrap_or(0.0),
            k => rhs[k as usize],
        })
    }

    /// Change of the angles when period jumps change by the given amounts, one column per set of changes.
    pub fn responses(&self, changes: &[&[(EdgeId, i32)]]) -> Responses {
        let n = self.variables;
        let mut rhs = vec![0.0; n * changes.len()];
        for (column, set) in rhs.chunks_mut(n.max(1)).zip(changes) {
            for &(e, amount) in *set {
                let shift = FRAC_PI_2 * f64::from(amount);
                let h = self.mesh.half_edge(e);
                let Some(t) = self.mesh.twin(h) else { continue };
                let (a, b) = (self.variable[self.mesh.face(h)], self.variable[self.mesh.face(t)]);
                if a != FIXED {
                    column[a as usize] -= shift;
                }
                if b != FIXED {
                    column[b as usize] += shift;
                }
            }
        }
        self.factor.solve_columns(&mut rhs, changes.len());
        Responses { variables: n, columns: rhs }
    }

    /// Change of a face's angle in column `column` of a response.
    pub fn change(&self, responses: &Responses, column: usize, f: FaceId) -> f64 {
        match self.variable[f] {
            FIXED => 0.0,
            k => responses.columns[column * responses.variables + k as usize],
        }
    }

    /// Turns θ_j - θ_i - κ - π/2·p of all edges, seen from their canonical half-edges; 0 on the boundary.
    pub fn turns(&self, angle: &FaceMap<f64>, period_jump: &EdgeMap<i32>) -> EdgeMap<f64> {
        let mut turn = EdgeMap::filled(self.mesh.edge_count(), 0.0);
        for term in &self.terms {
            let [i, j] = term.faces;
            turn[term.edge] = angle[j] - angle[i] - term.kappa - FRAC_PI_2 * f64::from(period_jump[term.edge]);
        }
        turn
    }

    /// Pull of its soft direction on a face of the given angle: weight, and weight times distance.
    pub fn soft_pull(&self, f: FaceId, angle: f64) -> (f64, f64) {
        self.roots.soft[f].map_or((0.0, 0.0), |s| (s.weight, s.weight * (s.angle - angle)))
    }
}

/// Changes of all free angles, one column per set of changed period jumps.
pub(crate) struct Responses {
    variables: usize,
    columns: Vec<f64>,
}

/// Interior edges as (face i of the canonical half-edge, face j across, edge), ascending.
pub(crate) fn interior_edges(mesh: &TriConnectivity) -> impl Iterator<Item = (FaceId, FaceId, EdgeId)> + '_ {
    mesh.edges().filter_map(|e| {
        let (i, j) = mesh.edge_faces(e);
        j.map(|j| (i, j, e))
    })
}

/// Dense numbers of the faces that are not fixed.
pub(crate) fn number_free_faces(fixed: &FaceMap<Option<f64>>) -> (FaceMap<u32>, usize) {
    let mut count = 0u32;
    let variable = fixed.map(|angle| match angle {
        Some(_) => FIXED,
        None => {
            count += 1;
            count - 1
        }
    });
    (variable, count as usize)
}

/// The factorisation's error as the solver's.
pub(crate) fn solve_error(error: CholeskyError) -> FieldError {
    FieldError::Solve(match error {
        CholeskyError::NotPositiveDefinite { row } => SolveError::NotPositiveDefinite { variable: row },
        CholeskyError::TooLarge => SolveError::TooLarge,
    })
}
