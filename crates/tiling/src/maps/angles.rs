//! Angle-based flattening: the flat angles nearest to those of the surface.
//!
//! In: a disk and its metric. Out: an angle per corner and the number of rounds. Holds: angles lie inside (0, π), sum
//! to π in every face and to 2π about every interior vertex, and sides around interior vertices close, each to
//! [`TOLERANCE`]; the border is free. Source: the problem of [ShefferDeSturler2001] §2 with the wheel condition
//! in logarithms ([Zayer2007] (5)); differs: steps towards the nearest angles (sequential quadratic programming
//! without the curvature of the constraints) until they are small, then onto the constraints; faces are eliminated
//! as in [Sheffer2005] §3.2.
//!
//! | paper | here | meaning |
//! |---|---|---|
//! | α, β | `alpha`, `beta` | flat angles; angles of the surface, scaled to 2π about interior vertices |
//! | w = β⁻² | inverse of `variance` | weight of an angle's change |
//! | C_tri | face sums | eliminated |
//! | C_plan, C_len | unknowns 2v, 2v + 1 | vertex sums and wheels |

use super::MapMethod;
use super::conformal::fault;
use super::disk::{Disk, NONE};
use super::error::MapError;
use super::metric::Metric;
use quadloom_mesh::{CornerMap, FaceId, HalfEdgeId, Progress, TriMesh};
use quadloom_numeric::{SparseCholesky, SparseSymmetric, Triplet};
use std::f64::consts::{PI, TAU};

/// Largest error of a sum, radians, and of a wheel relative to the sum of its derivatives.
const TOLERANCE: f64 = 1e-12;

/// Largest error with which angles are accepted where rounding allows no less.
const ACCEPTED: f64 = 1e-9;

/// Change of the angles, relative to them, below which they are near enough to the nearest ones.
const NEAR: f64 = 1e-3;

/// Most rounds towards the nearest angles, and most rounds in all.
const ROUNDS: (usize, usize) = (8, 40);

/// Part of the way to 0 or π that an angle may go in one round.
const PART: f64 = 0.8;

/// Flat angles, the number of rounds, and the largest error left.
pub(super) fn flatten(
    mesh: &TriMesh,
    disk: &Disk,
    metric: &Metric,
    progress: &Progress,
) -> Result<(CornerMap<f64>, usize, f64), MapError> {
    let beta = wanted_angles(mesh, metric);
    let variance = beta.map(|b| b * b);
    let mut alpha = beta.clone();
    let mut solver = None;
    let (mut towards, mut best) = (true, f64::INFINITY);
    for round in 0..ROUNDS.1 {
        progress.check()?;
        progress.report("angle based flattening", round as f64 / ROUNDS.1 as f64);
        let residual = largest_error(mesh, disk, &alpha);
        // Once steps are onto the constraints alone, errors fall quadratically until rounding stops them.
        let done = residual <= TOLERANCE || (!towards && residual <= ACCEPTED && residual > 0.25 * best);
        if done && (!towards || round == 0) {
            return Ok((alpha, round, residual));
        }
        best = residual;
        let system = System::new(mesh, disk, &alpha, &variance);
        let wish = CornerMap::from_fn(alpha.len(), |h| if towards { beta[h] - alpha[h] } else { 0.0 });
        let step = system.step(&wish, &mut solver)?;
        let change = advance(&mut alpha, &step);
        towards = towards && change > NEAR && round + 1 < ROUNDS.0;
    }
    let residual = largest_error(mesh, disk, &alpha);
    if residual <= ACCEPTED {
        return Ok((alpha, ROUNDS.1, residual));
    }
    Err(MapError::NotConverged { method: MapMethod::AngleBased, rounds: ROUNDS.1, residual })
}

/// Angles of the surface, scaled about interior vertices ([ShefferDeSturler2001] (2)).
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

/// Adds a step, shortened where an angle would come too near to 0 or π; returns its largest relative change.
fn advance(alpha: &mut CornerMap<f64>, step: &CornerMap<f64>) -> f64 {
    let mut length: f64 = 1.0;
    for (h, &d) in step.iter() {
        let room = PART * if d < 0.0 { alpha[h] } else { PI - alpha[h] };
        if d.abs() > room {
            length = length.min(room / d.abs());
        }
    }
    let mut change: f64 = 0.0;
    for (h, &d) in step.iter() {
        change = change.max((d / alpha[h]).abs());
        alpha[h] += length * d;
    }
    change
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

    /// The step nearest to `wish` that meets the linearised constraints.
    fn step(&self, wish: &CornerMap<f64>, solver: &mut Option<SparseCholesky>) -> Result<CornerMap<f64>, MapError> {
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
        Ok(self.changes(wish, &price))
    }

    /// J P Jᵀ μ = c for the vertices, where P forbids changes of the sums of faces.
    fn normal_equations(&self, wish: &CornerMap<f64>) -> (SparseSymmetric, Vec<f64>) {
        let n = 2 * self.disk.interior.len();
        let mut triplets: Vec<Triplet> = Vec::with_capacity(21 * self.mesh.face_count());
        let mut rhs = vec![0.0; n];
        for (i, &v) in self.disk.interior.iter().enumerate() {
            let h = self.mesh.outgoing_half_edge(v);
            rhs[2 * i] = vertex_error(self.mesh, self.alpha, h);
            rhs[2 * i + 1] = wheel_error(self.mesh, self.alpha, h).0;
        }
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
