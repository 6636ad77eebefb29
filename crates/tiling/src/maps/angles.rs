//! Angle-based flattening: the flat angles nearest to those of the surface.
//!
//! In: a disk and its metric. Out: [`Flattened`]: an angle per corner, and how it was found. Holds: angles lie inside
//! (0, π), sum to π in every face and to 2π about every interior vertex, and sides around interior vertices close,
//! each to [`ACCEPTED`] at worst; the border is free. Source: the problem of [ShefferDeSturler2001] with the wheel
//! condition in logarithms [Zayer2007]; differs: sequential quadratic programming without the curvature of the
//! constraints, with a line search, then Newton's method onto the constraints; faces are eliminated as in
//! [Sheffer2005].
//!
//! | paper | here | meaning |
//! |---|---|---|
//! | α, β | `alpha`, `beta` | flat angles; angles of the surface, scaled to 2π about interior vertices |
//! | w = β⁻² | inverse of `variance`, where angles do not shrink far | weight of an angle's change |
//! | C_tri | face sums | eliminated |
//! | C_plan, C_len | unknowns 2v, 2v + 1 | vertex sums and wheels |

use super::circles;
use super::conformal::fault;
use super::disk::{Disk, NONE};
use super::error::MapError;
use super::metric::Metric;
use super::{MapMethod, PackingKind};
use quadloom_mesh::{CornerMap, FaceId, HalfEdgeId, Progress, TriMesh};
use quadloom_numeric::{SparseCholesky, SparseSymmetric, Triplet};
use std::f64::consts::{PI, TAU};

/// Largest error of a sum, radians, and of a wheel relative to the sum of its derivatives.
const TOLERANCE: f64 = 1e-12;

/// Largest error with which angles are accepted where rounding allows no less.
const ACCEPTED: f64 = 1e-8;

/// Largest change of an angle, relative to it, and fall of the cost, relative to it, of the last step towards the
/// nearest angles.
const NEAR: [f64; 2] = [1e-3, 1e-5];

/// Most rounds towards the nearest angles, and most rounds onto the constraints thereafter.
const ROUNDS: [usize; 2] = [30, 30];

/// Part of the way to 0 or π that an angle may go in one round.
const PART: f64 = 0.8;

/// Most halvings of a step; a step that needs more leads nowhere.
const HALVINGS: usize = 12;

/// How far an angle may fall below that of the surface before it moves more stiffly.
///
/// Larger: cotangents of angles that shrink make systems singular. Smaller: more rounds where distortion is large.
const SHRINKING: f64 = 10.0;

/// Flat angles, and how they were found.
pub(super) struct Flattened {
    pub angle: CornerMap<f64>,
    /// The packing from which the search started, if it did not get there from the surface.
    pub start: Option<PackingKind>,
    pub rounds: usize,
    /// Largest error left.
    pub residual: f64,
}

/// Flat angles, by a search from those of the surface; if it does not end, by one from the angles of a circle packing,
/// which meet all constraints.
pub(super) fn flatten(
    mesh: &TriMesh,
    disk: &Disk,
    metric: &Metric,
    progress: &Progress,
) -> Result<Flattened, MapError> {
    let beta = wanted_angles(mesh, metric);
    let mut search = Search::new(mesh, disk, &beta, beta.clone());
    match search.run(progress) {
        Ok(residual) => {
            return Ok(Flattened { angle: search.alpha, start: None, rounds: search.rounds, residual });
        }
        Err(MapError::NotConverged { .. } | MapError::Solve { .. }) => {}
        Err(other) => return Err(other),
    }
    let packed = circles::pack(mesh, disk, metric, PackingKind::InversiveDistance, progress)?;
    let before = search.rounds + packed.rounds;
    let mut search = Search::new(mesh, disk, &beta, packed.angle.clone());
    let start = Some(packed.kind);
    match search.run(progress) {
        Ok(residual) => Ok(Flattened { angle: search.alpha, start, rounds: before + search.rounds, residual }),
        // The packing itself is flat, though not the nearest to the surface.
        Err(MapError::NotConverged { .. } | MapError::Solve { .. }) => {
            Ok(Flattened { angle: packed.angle, start, rounds: before + search.rounds, residual: packed.residual })
        }
        Err(other) => Err(other),
    }
}

/// Angles on their way.
struct Search<'a> {
    mesh: &'a TriMesh,
    disk: &'a Disk,
    beta: &'a CornerMap<f64>,
    alpha: CornerMap<f64>,
    /// What an error of each vertex condition costs against distance from the wanted angles.
    penalty: Vec<f64>,
    solver: Option<SparseCholesky>,
    rounds: usize,
}

impl<'a> Search<'a> {
    /// From given angles, whose sums in faces are set right.
    fn new(mesh: &'a TriMesh, disk: &'a Disk, beta: &'a CornerMap<f64>, mut alpha: CornerMap<f64>) -> Self {
        for f in mesh.faces() {
            let scale = PI / mesh.sides(f).map(|h| alpha[h]).sum::<f64>();
            mesh.sides(f).for_each(|h| alpha[h] *= scale);
        }
        let penalty = vec![0.0; 2 * disk.interior.len()];
        Self { mesh, disk, beta, alpha, penalty, solver: None, rounds: 0 }
    }

    /// Towards the nearest angles, then onto the constraints; the largest error left.
    fn run(&mut self, progress: &Progress) -> Result<f64, MapError> {
        let mut residual = largest_error(self.mesh, self.disk, &self.alpha);
        // Where the surface is flat already nothing moves.
        let mut towards = residual > TOLERANCE || !self.is_wanted();
        for round in 0..ROUNDS[0] {
            if !towards {
                break;
            }
            self.report(round, progress)?;
            towards = self.approach()?;
        }
        for round in ROUNDS[0]..ROUNDS[0] + ROUNDS[1] {
            let best = residual;
            residual = largest_error(self.mesh, self.disk, &self.alpha);
            // Errors fall quadratically until rounding stops them.
            if residual <= TOLERANCE || (residual <= ACCEPTED && residual > 0.25 * best) {
                return Ok(residual);
            }
            self.report(round, progress)?;
            self.close()?;
        }
        Err(MapError::NotConverged { method: MapMethod::AngleBased, rounds: self.rounds, residual })
    }

    fn report(&mut self, round: usize, progress: &Progress) -> Result<(), MapError> {
        progress.check()?;
        progress.report("angle based flattening", round as f64 / (ROUNDS[0] + ROUNDS[1]) as f64);
        self.rounds += 1;
        Ok(())
    }

    fn is_wanted(&self) -> bool {
        self.alpha.iter().all(|(h, a)| (a - self.beta[h]).abs() <= NEAR[0] * self.beta[h])
    }

    /// One step towards the nearest angles; returns whether another is worth taking.
    fn approach(&mut self) -> Result<bool, MapError> {
        let (alpha, beta) = (&self.alpha, self.beta);
        let variance = CornerMap::from_fn(alpha.len(), |h| beta[h].min(SHRINKING * alpha[h]).powi(2));
        let wish = CornerMap::from_fn(alpha.len(), |h| (beta[h] - alpha[h]) * variance[h] / (beta[h] * beta[h]));
        let system = System::new(self.mesh, self.disk, alpha, &variance);
        let (step, price) = system.step(&wish, &mut self.solver)?;
        self.penalty.iter_mut().zip(&price).for_each(|(p, mu)| *p = p.max(1.5 * mu.abs()));
        let slope: f64 = step.iter().map(|(h, d)| (alpha[h] - beta[h]) * d / (beta[h] * beta[h])).sum();
        let (before, error) = self.cost(&self.alpha);
        let fall = slope - error;
        let mut length = longest(&self.alpha, &step);
        for _ in 0..HALVINGS {
            let next = moved(&self.alpha, &step, length);
            if self.cost(&next).0 <= before + 1e-4 * length * fall + 1e-13 * before {
                let change = step.iter().map(|(h, d)| (d / self.alpha[h]).abs()).fold(0.0, f64::max);
                self.alpha = next;
                return Ok(change > NEAR[0] && -fall > NEAR[1] * before);
            }
            length *= 0.5;
        }
        // Nothing nearer is found in this direction.
        Ok(false)
    }

    /// Half the weighted square of the distance from the wanted angles and the price of errors; and that price.
    fn cost(&self, alpha: &CornerMap<f64>) -> (f64, f64) {
        let distance: f64 = alpha.iter().map(|(h, a)| (a / self.beta[h] - 1.0).powi(2)).sum();
        let errors = vertex_errors(self.mesh, self.disk, alpha);
        let price: f64 = errors.iter().zip(&self.penalty).map(|(e, p)| e.abs() * p).sum();
        (0.5 * distance + price, price)
    }

    /// The least relative change that meets the linearised constraints.
    fn close(&mut self) -> Result<(), MapError> {
        let variance = self.alpha.map(|a| a * a);
        let wish = CornerMap::filled(self.alpha.len(), 0.0);
        let system = System::new(self.mesh, self.disk, &self.alpha, &variance);
        let (step, _) = system.step(&wish, &mut self.solver)?;
        let size =
            |alpha: &CornerMap<f64>| -> f64 { vertex_errors(self.mesh, self.disk, alpha).iter().map(|e| e * e).sum() };
        let before = size(&self.alpha);
        let mut length = longest(&self.alpha, &step);
        let mut next = moved(&self.alpha, &step, length);
        for _ in 0..HALVINGS {
            if size(&next) < before {
                break;
            }
            length *= 0.5;
            next = moved(&self.alpha, &step, length);
        }
        self.alpha = next;
        Ok(())
    }
}

/// Angles of the surface, scaled about interior vertices ([ShefferDeSturler2001]).
fn wanted_angles(mesh: &TriMesh, metric: &Metric) -> CornerMap<f64> {
    let mut beta = CornerMap::from_fn(mesh.half_edge_count(), |h| metric.angle(h));
    for v in mesh.vertices().filter(|&v| !mesh.is_boundary_vertex(v)) {
        let total: f64 = mesh.outgoing(v).map(|h| beta[h]).sum();
        // A spike of a few narrow angles would be scaled beyond π.
        let widest = mesh.outgoing(v).map(|h| beta[h]).fold(0.0, f64::max);
        let scale = (TAU / total).min(0.95 * PI / widest).max(0.0);
        if (total - TAU).abs() > 1e-13 * TAU {
            mesh.outgoing(v).for_each(|h| beta[h] *= scale);
        }
    }
    beta
}

/// Sum of the angles about a vertex, minus 2π.
fn vertex_error(mesh: &TriMesh, alpha: &CornerMap<f64>, h: HalfEdgeId) -> f64 {
    mesh.outgoing(mesh.origin(h)).map(|h| alpha[h]).sum::<f64>() - TAU
}

/// Σ ln sin of the angles after, minus those before, about a vertex; and the sum of its derivatives' magnitudes.
fn wheel_error(mesh: &TriMesh, alpha: &CornerMap<f64>, h: HalfEdgeId) -> (f64, f64) {
    mesh.outgoing(mesh.origin(h)).fold((0.0, 0.0), |(error, slope), h| {
        let (after, before) = (alpha[mesh.next(h)], alpha[mesh.prev(h)]);
        (error + (after.sin() / before.sin()).ln(), slope + (1.0 / after.tan()).abs() + (1.0 / before.tan()).abs())
    })
}

fn face_error(mesh: &TriMesh, alpha: &CornerMap<f64>, f: FaceId) -> f64 {
    mesh.sides(f).map(|h| alpha[h]).sum::<f64>() - PI
}

fn largest_error(mesh: &TriMesh, disk: &Disk, alpha: &CornerMap<f64>) -> f64 {
    let faces = mesh.faces().map(|f| face_error(mesh, alpha, f).abs());
    let about = |h: HalfEdgeId| {
        let (wheel, slope) = wheel_error(mesh, alpha, h);
        vertex_error(mesh, alpha, h).abs().max(wheel.abs() / (1.0 + slope))
    };
    let vertices = disk.interior.iter().map(|&v| about(mesh.outgoing_half_edge(v)));
    faces.chain(vertices).fold(0.0, f64::max)
}

/// Errors of the sum and the wheel of each interior vertex.
fn vertex_errors(mesh: &TriMesh, disk: &Disk, alpha: &CornerMap<f64>) -> Vec<f64> {
    let about = |h: HalfEdgeId| [vertex_error(mesh, alpha, h), wheel_error(mesh, alpha, h).0];
    disk.interior.iter().flat_map(|&v| about(mesh.outgoing_half_edge(v))).collect()
}

/// The longest part of a step, at most all of it, that brings no angle too near to 0 or π.
fn longest(alpha: &CornerMap<f64>, step: &CornerMap<f64>) -> f64 {
    let limit = |(h, d): (HalfEdgeId, &f64)| PART * if *d < 0.0 { alpha[h] } else { PI - alpha[h] } / d.abs();
    step.iter().filter(|(_, d)| **d != 0.0).map(limit).fold(1.0, f64::min)
}

fn moved(alpha: &CornerMap<f64>, step: &CornerMap<f64>, length: f64) -> CornerMap<f64> {
    CornerMap::from_fn(alpha.len(), |h| alpha[h] + length * step[h])
}

/// The constraints, linearised.
struct System<'a> {
    mesh: &'a TriMesh,
    disk: &'a Disk,
    variance: &'a CornerMap<f64>,
    alpha: &'a CornerMap<f64>,
    cotangent: CornerMap<f64>,
}

/// Corner k of a face in the unknowns of the face: sum and wheel of each of its corners.
type Slopes = [[f64; 6]; 3];

impl<'a> System<'a> {
    fn new(mesh: &'a TriMesh, disk: &'a Disk, alpha: &'a CornerMap<f64>, variance: &'a CornerMap<f64>) -> Self {
        Self { mesh, disk, variance, alpha, cotangent: alpha.map(|a| 1.0 / a.tan()) }
    }

    /// The step nearest to `wish` that meets the linearised constraints, and the multipliers of the vertices.
    fn step(
        &self,
        wish: &CornerMap<f64>,
        solver: &mut Option<SparseCholesky>,
    ) -> Result<(CornerMap<f64>, Vec<f64>), MapError> {
        let (matrix, mut price) = self.normal_equations(wish);
        let method = MapMethod::AngleBased;
        if matrix.n() > 0 {
            let factor = match solver {
                Some(factor) => factor,
                None => solver.insert(SparseCholesky::analyse(&matrix, &[]).map_err(|e| fault(method, &e))?),
            };
            factor.factorize(&matrix).map_err(|e| fault(method, &e))?;
            factor.solve(&mut price);
        }
        Ok((self.changes(wish, &price), price))
    }

    /// J P Jᵀ μ = c for the vertices, where P forbids changes of the sums of faces.
    fn normal_equations(&self, wish: &CornerMap<f64>) -> (SparseSymmetric, Vec<f64>) {
        let n = 2 * self.disk.interior.len();
        let mut triplets: Vec<Triplet> = Vec::with_capacity(21 * self.mesh.face_count());
        let mut rhs = vertex_errors(self.mesh, self.disk, self.alpha);
        for f in self.mesh.faces() {
            let (unknown, slopes) = (self.unknowns(f), self.slopes(f));
            let (d, total) = self.variances(f);
            let base = self.forced(f, wish);
            let mean: [f64; 6] = std::array::from_fn(|a| (0..3).map(|k| d[k] * slopes[k][a]).sum());
            for a in (0..6).filter(|&a| unknown[a] != NONE) {
                rhs[unknown[a] as usize] += (0..3).map(|k| slopes[k][a] * base[k]).sum::<f64>();
                for b in (a..6).filter(|&b| unknown[b] != NONE) {
                    let full: f64 = (0..3).map(|k| slopes[k][a] * d[k] * slopes[k][b]).sum();
                    triplets.push((unknown[a], unknown[b], full - mean[a] * mean[b] / total));
                }
            }
        }
        (SparseSymmetric::from_triplets(n, &triplets), rhs)
    }

    /// Changes of all angles: wish − D Jᵀ μ, with each face's sum set right.
    fn changes(&self, wish: &CornerMap<f64>, price: &[f64]) -> CornerMap<f64> {
        let mut change = CornerMap::filled(wish.len(), 0.0);
        for f in self.mesh.faces() {
            let (unknown, slopes) = (self.unknowns(f), self.slopes(f));
            let (d, total) = self.variances(f);
            let base = self.forced(f, wish);
            let paid: [f64; 3] = std::array::from_fn(|k| {
                let terms = (0..6).filter(|&a| unknown[a] != NONE).map(|a| slopes[k][a] * price[unknown[a] as usize]);
                d[k] * terms.sum::<f64>()
            });
            let excess: f64 = paid.iter().sum();
            for (k, h) in self.mesh.sides(f).enumerate() {
                change[h] = base[k] - (paid[k] - d[k] / total * excess);
            }
        }
        change
    }

    /// The wish, changed least so that the face's sum becomes π.
    fn forced(&self, f: FaceId, wish: &CornerMap<f64>) -> [f64; 3] {
        let side = self.mesh.face_half_edges(f);
        let (d, total) = self.variances(f);
        let excess = face_error(self.mesh, self.alpha, f) + side.iter().map(|&h| wish[h]).sum::<f64>();
        std::array::from_fn(|k| wish[side[k]] - d[k] / total * excess)
    }

    fn variances(&self, f: FaceId) -> ([f64; 3], f64) {
        let d = self.mesh.face_half_edges(f).map(|h| self.variance[h]);
        (d, d[0] + d[1] + d[2])
    }

    fn unknowns(&self, f: FaceId) -> [u32; 6] {
        let inner = self.mesh.face_vertices(f).map(|v| self.disk.inner[v]);
        std::array::from_fn(|a| if inner[a / 2] == NONE { NONE } else { 2 * inner[a / 2] + (a % 2) as u32 })
    }

    /// Corner k enters the sum of its own vertex, and the wheels of the vertices before (+) and after (−) it.
    fn slopes(&self, f: FaceId) -> Slopes {
        let side = self.mesh.face_half_edges(f);
        std::array::from_fn(|k| {
            let (cot, mut slope) = (self.cotangent[side[k]], [0.0; 6]);
            slope[2 * k] = 1.0;
            slope[2 * ((k + 2) % 3) + 1] = cot;
            slope[2 * ((k + 1) % 3) + 1] = -cot;
            slope
        })
    }
}
