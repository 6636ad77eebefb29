//! Circle packings: radii whose triangles are flat about every interior vertex.
//!
//! In: a disk and its metric. Out: an angle per corner, which packing it was, the number of rounds. Holds: angles sum
//! to 2π about interior vertices to [`ACCEPTED`] at worst; circles of the border keep their radii; the border is free.
//! Source: [CollinsStephenson2003] (radii of the border given); inversive distances of the mesh's own lengths
//! [BowersStephenson2004], so that a flat tile keeps its lengths; Newton's method on the convex energy, extended by
//! constant angles to radii of which no triangle can be made [Luo2011].
//!
//! | paper | here | meaning |
//! |---|---|---|
//! | r_i, u_i = ln r_i | `Packing::log_radius` | radius of the circle about vertex i |
//! | I_ij | `Packing::inversive` | inversive distance, 1 for circles that touch: l² = r_i² + r_j² + 2 I r_i r_j |
//! | θ | `angle` | angle of a corner |

use super::conformal::fault;
use super::disk::{Disk, NONE};
use super::error::MapError;
use super::metric::{Metric, half_tangent, slack};
use super::{MapMethod, PackingKind};
use quadloom_mesh::{CornerMap, EdgeMap, HalfEdgeId, Progress, TriMesh, VertexMap};
use quadloom_numeric::{SparseCholesky, SparseSymmetric, Triplet};
use std::f64::consts::{PI, TAU};

/// Largest error of an angle sum, radians.
const TOLERANCE: f64 = 1e-12;

/// Largest error that is accepted where rounding allows no less.
const ACCEPTED: f64 = 1e-8;

/// Most rounds of Newton's method, and most halvings of a step.
const LIMITS: (usize, usize) = (60, 30);

/// Largest change of a logarithm of a radius in one round.
const LARGEST_STEP: f64 = 4.0;

/// Share of the largest entry that is added to the diagonal: triangles that are none have no curvature.
const DAMPING: f64 = 1e-13;

/// What packing gave.
pub(super) struct Packed {
    pub angle: CornerMap<f64>,
    pub kind: PackingKind,
    pub rounds: usize,
    pub residual: f64,
}

/// Flat angles of a packing of the wanted kind; of touching circles, if inversive distances end in no triangles.
pub(super) fn pack(
    mesh: &TriMesh,
    disk: &Disk,
    metric: &Metric,
    kind: PackingKind,
    progress: &Progress,
) -> Result<Packed, MapError> {
    let mut before = 0;
    if kind == PackingKind::InversiveDistance {
        let mut packing = Packing::inversive_distances(mesh, disk, metric);
        match packing.flatten(progress) {
            Ok((rounds, residual)) if packing.is_valid() => {
                return Ok(Packed { angle: packing.angles(), kind, rounds, residual });
            }
            Ok((rounds, _)) | Err(MapError::NotConverged { rounds, .. }) => before = rounds,
            // Far from any packing its matrix may be singular; touching circles are always solvable.
            Err(MapError::Solve { .. }) => {}
            Err(other) => return Err(other),
        }
    }
    let mut packing = Packing::tangent(mesh, disk, metric);
    let (rounds, residual) = packing.flatten(progress)?;
    Ok(Packed { angle: packing.angles(), kind: PackingKind::Tangent, rounds: before + rounds, residual })
}

/// Circles about the vertices.
struct Packing<'a> {
    mesh: &'a TriMesh,
    disk: &'a Disk,
    log_radius: VertexMap<f64>,
    inversive: EdgeMap<f64>,
}

impl<'a> Packing<'a> {
    /// Circles of half the shortest edge at each vertex: none meet, so that every inversive distance is at least 1.
    fn inversive_distances(mesh: &'a TriMesh, disk: &'a Disk, metric: &Metric) -> Self {
        let radius = VertexMap::from_fn(mesh.vertex_count(), |v| {
            0.5 * mesh.vertex_edges(v).map(|e| metric.length[e]).fold(f64::INFINITY, f64::min)
        });
        let inversive = EdgeMap::from_fn(mesh.edge_count(), |e| {
            let ([r, s], l) = (mesh.ends(e).map(|v| radius[v]), metric.length[e]);
            // (l² − r² − s²) / 2rs.
            (1.0 + (l - r - s) * (l + r + s) / (2.0 * r * s)).max(1.0)
        });
        Self { mesh, disk, log_radius: radius.map(|r| r.ln()), inversive }
    }

    /// Touching circles, at first those that touch in the triangles of the surface, on average.
    fn tangent(mesh: &'a TriMesh, disk: &'a Disk, metric: &Metric) -> Self {
        let log_radius = VertexMap::from_fn(mesh.vertex_count(), |v| {
            let side = |h: HalfEdgeId| metric.length[mesh.edge(h)];
            let radius = |h: HalfEdgeId| 0.5 * slack(side(mesh.next(h)), side(h), side(mesh.prev(h)));
            let (sum, count) = mesh.outgoing(v).fold((0.0, 0.0), |(sum, count), h| (sum + radius(h), count + 1.0));
            f64::ln(sum / count)
        });
        Self { mesh, disk, log_radius, inversive: EdgeMap::filled(mesh.edge_count(), 1.0) }
    }

    /// Newton's method; the number of rounds and the largest error left.
    fn flatten(&mut self, progress: &Progress) -> Result<(usize, f64), MapError> {
        let mut error = self.errors(&self.angles());
        let mut solver = None;
        let mut best = f64::INFINITY;
        for round in 0..=LIMITS.0 {
            progress.check()?;
            progress.report("circle packing", round as f64 / LIMITS.0 as f64);
            let residual = largest(&error);
            if residual <= TOLERANCE || (residual <= ACCEPTED && residual > 0.25 * best) {
                return Ok((round, residual));
            }
            best = residual;
            let step = self.newton_step(&error, &mut solver)?;
            error = self.advance(&step, &error);
        }
        let (method, rounds) = (MapMethod::Circles, LIMITS.0);
        Err(MapError::NotConverged { method, rounds, residual: largest(&error) })
    }

    /// Takes the largest half, quarter, … of a step after which the energy no longer rises much along it.
    ///
    /// The energy is convex and its gradient known, so that the slope at the end decides.
    fn advance(&mut self, step: &[f64], error: &[f64]) -> Vec<f64> {
        let slope = |error: &[f64]| -> f64 { error.iter().zip(step).map(|(e, s)| e * s).sum() };
        let first = slope(error).abs();
        let largest_step = step.iter().fold(0.0f64, |m, s| m.max(s.abs()));
        let mut length = (LARGEST_STEP / largest_step).min(1.0);
        let start = self.log_radius.clone();
        let mut halvings = 0;
        loop {
            for (i, &v) in self.disk.interior.iter().enumerate() {
                self.log_radius[v] = start[v] + length * step[i];
            }
            let error = self.errors(&self.angles());
            if slope(&error) <= 0.1 * first || halvings == LIMITS.1 {
                return error;
            }
            length *= 0.5;
            halvings += 1;
        }
    }

    fn lengths(&self) -> EdgeMap<f64> {
        EdgeMap::from_fn(self.mesh.edge_count(), |e| {
            let [r, s] = self.mesh.ends(e).map(|v| self.log_radius[v].exp());
            (r * r + s * s + 2.0 * self.inversive[e] * r * s).sqrt()
        })
    }

    /// Angles; 0, 0 and π where sides make no triangle.
    fn angles(&self) -> CornerMap<f64> {
        let length = self.lengths();
        let side = |h: HalfEdgeId| length[self.mesh.edge(h)];
        CornerMap::from_fn(self.mesh.half_edge_count(), |h| {
            let (a, b, c) = (side(self.mesh.next(h)), side(self.mesh.prev(h)), side(h));
            if slack(a, b, c) <= 0.0 {
                PI
            } else if slack(b, c, a) <= 0.0 || slack(c, a, b) <= 0.0 {
                0.0
            } else {
                2.0 * half_tangent(a, b, c).atan()
            }
        })
    }

    fn is_valid(&self) -> bool {
        self.angles().values().iter().all(|&a| a > 0.0 && a < PI)
    }

    /// The gradient of the energy: 2π minus the angle sum of every interior vertex.
    fn errors(&self, angle: &CornerMap<f64>) -> Vec<f64> {
        let sum = |v| self.mesh.outgoing(v).map(|h| angle[h]).sum::<f64>();
        self.disk.interior.iter().map(|&v| TAU - sum(v)).collect()
    }

    fn newton_step(&self, error: &[f64], solver: &mut Option<SparseCholesky>) -> Result<Vec<f64>, MapError> {
        let hessian = self.hessian();
        let method = MapMethod::Circles;
        let factor = match solver {
            Some(factor) => factor,
            None => solver.insert(SparseCholesky::analyse(&hessian, &[]).map_err(|e| fault(method, &e))?),
        };
        factor.factorize(&hessian).map_err(|e| fault(method, &e))?;
        let mut step: Vec<f64> = error.iter().map(|e| -e).collect();
        factor.solve(&mut step);
        Ok(step)
    }

    /// Second derivatives: −∂θ_i/∂u_j; scaling a triangle keeps its angles, so that rows sum to 0 in each.
    fn hessian(&self) -> SparseSymmetric {
        let (length, angle) = (self.lengths(), self.angles());
        let mut triplets: Vec<Triplet> = Vec::with_capacity(9 * self.mesh.face_count());
        for h in self.mesh.half_edges() {
            let (i, j) = (self.mesh.origin(h), self.mesh.target(h));
            let w = self.coupling(h, &length, &angle);
            let (a, b) = (self.disk.inner[i], self.disk.inner[j]);
            triplets.extend([a, b].into_iter().filter(|&a| a != NONE).map(|a| (a, a, w)));
            if a != NONE && b != NONE {
                triplets.push((a, b, -w));
            }
        }
        let n = self.disk.interior.len();
        let damping = DAMPING * triplets.iter().fold(1.0f64, |most, t| most.max(t.2));
        triplets.extend((0..n as u32).map(|a| (a, a, damping)));
        SparseSymmetric::from_triplets(n, &triplets)
    }

    /// ∂θ_i/∂u_j = ∂θ_j/∂u_i in the face of the half-edge from i to j; 0 where there is no triangle.
    fn coupling(&self, h: HalfEdgeId, length: &EdgeMap<f64>, angle: &CornerMap<f64>) -> f64 {
        let (next, prev) = (self.mesh.next(h), self.mesh.prev(h));
        let [ij, jk, ki] = [h, next, prev].map(|h| length[self.mesh.edge(h)]);
        let doubled_area = ij * ki * angle[h].sin();
        if angle[h] <= 0.0 || angle[next] <= 0.0 || angle[prev] <= 0.0 {
            return 0.0;
        }
        // ∂l_ab/∂u_a = (l_ab² + r_a² − r_b²) / 2 l_ab, for a = j.
        let [ri, rj, rk] = [h, next, prev].map(|h| self.log_radius[self.mesh.origin(h)].exp().powi(2));
        let (of_ij, of_jk) = ((ij * ij + rj - ri) / (2.0 * ij), (jk * jk + rj - rk) / (2.0 * jk));
        jk * (of_jk - angle[next].cos() * of_ij) / doubled_area
    }
}

fn largest(errors: &[f64]) -> f64 {
    errors.iter().fold(0.0, |m, e| m.max(e.abs()))
}
