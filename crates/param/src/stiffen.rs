//! Local stiffening at fixed integers: re-solves the map with larger weights where it is distorted.
//!
//! In: a [`PlacedMap`] and its energy. Out: the same map with other points, fewer inverted triangles.
//! Holds: integers, transitions and feature lines are untouched; the best map seen is kept.
//! Source: [Bommes2012] §8.4, "Local Stiffening", c = 1 and d = 5.

use crate::fans::{Saddle, is_wrong};
use crate::placed::{PlacedMap, turn};
use crate::problem::{EnergyOptions, FaceGradient, jacobian};
use quadloom_mesh::{DVec2, FaceId, FaceMap, Progress, TriConnectivity, VertexMap};
use quadloom_numeric::{SparseCholesky, SparseSymmetric};

/// How long stiffening goes on.
#[derive(Clone, Debug)]
pub struct StiffenOptions {
    /// Most re-solves. Default 5, the number that the thesis shows in Figure 8.15; beyond it gains are rare.
    pub iterations: u32,
    /// c, update per unit of the distortion's Laplacian. Default 1.
    pub rate: f64,
    /// d, largest update of a weight. Default 5.
    pub most: f64,
    /// Smoothing steps of the weights after each update. Default 3.
    pub smoothing: u32,
    /// Factor on the weights around a saddle that is folded or wrongly wound. Default 5: after two re-solves its
    /// triangles are nearly rigid; more at once only moves the distortion to the next ring.
    pub fan_factor: f64,
}

impl Default for StiffenOptions {
    fn default() -> Self {
        Self { iterations: 5, rate: 1.0, most: 5.0, smoothing: 3, fan_factor: 5.0 }
    }
}

/// What stiffening did.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct StiffenReport {
    /// Inverted faces before.
    pub inverted_before: usize,
    /// Inverted faces that are left.
    pub inverted_after: usize,
    /// Re-solves.
    pub iterations: u32,
}

/// Re-solves with growing weights until no triangle is inverted or the limit is reached.
///
/// # Cost       one numeric factorisation per iteration, one symbolic one
pub fn stiffen(
    mesh: &TriConnectivity,
    map: &mut PlacedMap,
    gradient: &FaceMap<FaceGradient>,
    energy: &EnergyOptions,
    options: &StiffenOptions,
    progress: &Progress,
) -> StiffenReport {
    let mut weight = first_weights(mesh, &map.saddles, options);
    let mut best = map.folded_faces(mesh).len();
    let mut report = StiffenReport { inverted_before: best, inverted_after: best, iterations: 0 };
    if best == 0 {
        return report;
    }
    let mut solver = PlacedSolver::new(mesh, map);
    let mut points = map.point.clone();
    let mut trial = map.clone();
    for _ in 0..options.iterations {
        if best == 0 || progress.cancelled() {
            break;
        }
        // 1. Weights from the distortion of the last solution.
        reweight(mesh, &trial, gradient, &mut weight, options);
        // 2. New solution.
        if !solver.solve(mesh, &mut trial, gradient, &weight, energy) {
            break;
        }
        report.iterations += 1;
        progress.spend(APPROACH_EFFORT * mesh.face_count());
        // 3. Keep the best.
        let inverted = trial.folded_faces(mesh).len();
        let improved = 4 * inverted <= 3 * best;
        if inverted < best {
            best = inverted;
            points = trial.point.clone();
        }
        // Folds that a re-solve hardly touches are left to the untangler.
        if !improved {
            break;
        }
    }
    map.point = points;
    report.inverted_after = best;
    report
}

/// Effort of a solve for the points of a map, per face.
pub(crate) const APPROACH_EFFORT: usize = 10;

/// 1, and more around saddles, where the linear energy is the first to fold.
pub(crate) fn first_weights(mesh: &TriConnectivity, saddles: &[Saddle], options: &StiffenOptions) -> FaceMap<f64> {
    let mut weight = FaceMap::filled(mesh.face_count(), 1.0);
    for saddle in saddles {
        mesh.outgoing(saddle.vertex).for_each(|h| weight[mesh.face(h)] = options.fan_factor);
    }
    weight
}

/// Raises the weights of faces whose distortion differs from their neighbours'.
pub(crate) fn reweight(
    mesh: &TriConnectivity,
    map: &PlacedMap,
    gradient: &FaceMap<FaceGradient>,
    weight: &mut FaceMap<f64>,
    options: &StiffenOptions,
) {
    let distortion = FaceMap::from_fn(mesh.face_count(), |f| distortion(jacobian(&gradient[f], map.face(mesh, f))));
    update_weights(mesh, &distortion, weight, options);
    // Saddles with folded or wrongly wound fans: what the solve wants of their triangles is right, so let it have it.
    for &saddle in &map.saddles {
        let fan = || mesh.outgoing(saddle.vertex).map(|h| mesh.face(h));
        let is_folded = |f: FaceId| determinant(jacobian(&gradient[f], map.face(mesh, f))) <= 0.0;
        if fan().any(is_folded) || is_wrong(mesh, map, saddle) {
            fan().for_each(|f| weight[f] *= options.fan_factor);
        }
    }
}

fn determinant(j: [[f64; 2]; 2]) -> f64 {
    j[0][0] * j[1][1] - j[0][1] * j[1][0]
}

/// λ = |τσ₁ − 1| + |τσ₂ − 1| with τ the orientation ([Bommes2012] §8.4; the sizes are already divided out).
fn distortion(j: [[f64; 2]; 2]) -> f64 {
    let (a, b) = (DVec2::new(j[0][0] + j[1][1], j[1][0] - j[0][1]), DVec2::new(j[0][0] - j[1][1], j[1][0] + j[0][1]));
    let (large, small) = (0.5 * (a.length() + b.length()), 0.5 * (a.length() - b.length()).abs());
    let sign = if j[0][0] * j[1][1] - j[0][1] * j[1][0] < 0.0 { -1.0 } else { 1.0 };
    (sign * large - 1.0).abs() + (sign * small - 1.0).abs()
}

/// w ← w + min(c·|Δλ|, d), then a few uniform smoothing steps.
fn update_weights(
    mesh: &TriConnectivity,
    distortion: &FaceMap<f64>,
    weight: &mut FaceMap<f64>,
    options: &StiffenOptions,
) {
    let mean_around = |value: &FaceMap<f64>, f| {
        let (mut sum, mut count) = (0.0, 0.0f64);
        for h in mesh.face_half_edges(f) {
            if let Some(t) = mesh.twin(h) {
                sum += value[mesh.face(t)];
                count += 1.0;
            }
        }
        if count > 0.0 { sum / count } else { value[f] }
    };
    for f in mesh.faces() {
        let laplacian = mean_around(distortion, f) - distortion[f];
        weight[f] += (options.rate * laplacian.abs()).min(options.most);
    }
    for _ in 0..options.smoothing {
        let next = FaceMap::from_fn(mesh.face_count(), |f| 0.5 * (weight[f] + mean_around(weight, f)));
        *weight = next;
    }
}

/// Minimises the orientation energy over the free coordinates of a placed map; keeps the symbolic factorisation.
pub struct PlacedSolver {
    unknown: VertexMap<[Option<u32>; 2]>,
    count: usize,
    solver: Option<SparseCholesky>,
}

impl PlacedSolver {
    /// Numbers the free coordinates.
    pub fn new(mesh: &TriConnectivity, map: &PlacedMap) -> Self {
        let mut count = 0;
        let unknown = VertexMap::from_fn(mesh.vertex_count(), |v| {
            map.fixed[v].map(|fixed| {
                (!fixed).then(|| {
                    count += 1;
                    count as u32 - 1
                })
            })
        });
        Self { unknown, count, solver: None }
    }

    /// Moves the free coordinates to the minimum of Σ w·area·E_T; false where the system is singular.
    pub fn solve(
        &mut self,
        mesh: &TriConnectivity,
        map: &mut PlacedMap,
        gradient: &FaceMap<FaceGradient>,
        weight: &FaceMap<f64>,
        options: &EnergyOptions,
    ) -> bool {
        self.approach(mesh, map, gradient, weight, options, |_| [[1.0, 0.0], [0.0, 1.0]])
    }

    /// Moves the free coordinates so that the Jacobians come near the given ones, in the sense of [`Self::solve`].
    pub fn approach(
        &mut self,
        mesh: &TriConnectivity,
        map: &mut PlacedMap,
        gradient: &FaceMap<FaceGradient>,
        weight: &FaceMap<f64>,
        options: &EnergyOptions,
        target: impl Fn(FaceId) -> [[f64; 2]; 2],
    ) -> bool {
        if self.count == 0 {
            return true;
        }
        let along = options.anisotropy.clamp(1e-3, 1.0);
        let mut triplets = Vec::with_capacity(mesh.face_count() * 21);
        let mut rhs = vec![0.0; self.count];
        for f in mesh.faces() {
            let corner = mesh.face_half_edges(f);
            let now = jacobian(&gradient[f], map.face(mesh, f));
            let wanted = target(f);
            let w = weight[f] * gradient[f].area;
            for (row, norm) in [(0, DVec2::new(along, 1.0)), (1, DVec2::new(1.0, along))] {
                // Coefficient of each free coordinate in this row of the Jacobian, and what is still missing.
                let missing = [wanted[row][0] - now[row][0], wanted[row][1] - now[row][1]];
                let mut terms: Vec<(u32, DVec2)> = Vec::with_capacity(6);
                for (k, &h) in corner.iter().enumerate() {
                    for component in 0..2 {
                        let Some(i) = self.unknown[mesh.origin(h)][component] else { continue };
                        let e = turn(
                            [f64::from(component == 0), f64::from(component == 1)],
                            map.to_corner[h].quarter_turns,
                        );
                        if e[row] != 0.0 {
                            terms.push((i, gradient[f].hat[k] * e[row]));
                        }
                    }
                }
                for (n, &(i, a)) in terms.iter().enumerate() {
                    rhs[i as usize] += w * (a.x * norm.x * missing[0] + a.y * norm.y * missing[1]);
                    for &(j, b) in &terms[n..] {
                        triplets.push((i, j, w * (a * norm).dot(b)));
                    }
                }
            }
        }
        let matrix = SparseSymmetric::from_triplets(self.count, &triplets);
        let mut solver = match self.solver.take() {
            Some(kept) => kept,
            None => match SparseCholesky::analyse(&matrix, &[]) {
                Ok(fresh) => fresh,
                Err(_) => return false,
            },
        };
        let solved = solver.factorize(&matrix).is_ok();
        if solved {
            solver.solve(&mut rhs);
        }
        self.solver = Some(solver);
        if !solved || rhs.iter().any(|x| !x.is_finite()) {
            return false;
        }
        for v in mesh.vertices() {
            for k in 0..2 {
                if let Some(i) = self.unknown[v][k] {
                    map.point[v][k] += rhs[i as usize];
                }
            }
        }
        true
    }
}
