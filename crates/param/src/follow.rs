//! Following: a fold-free seamless map is carried to other integers.
//!
//! In: a fold-free map, and integers under which a fold-free map exists. Out: a map at these integers, with few
//! inverted triangles or none. Holds: integers, transitions and features are those asked for. Not: success.
//! Source: the Jacobians of the seamless map as targets of the orientation energy of [Bommes2012] §6; where the way is
//! too far for one step, the integers move there through fractions, and every fold-free map on the way is the next
//! one's target.

use crate::placed::{PlacedMap, PlacementError};
use crate::problem::{EnergyOptions, FaceGradient, jacobian};
use crate::stiffen::{APPROACH_EFFORT, PlacedSolver};
use crate::untangle::{UntangleOptions, UntangleReport, untangle};
use quadloom_mesh::{FaceMap, Progress, TriConnectivity};

/// What following works on.
pub(crate) struct Follower<'a> {
    pub mesh: &'a TriConnectivity,
    pub gradient: &'a FaceMap<FaceGradient>,
    pub untangle: &'a UntangleOptions,
    /// Newton steps after which no further attempt is begun.
    pub most_steps: u32,
    /// Attempts in all; with one only, it goes straight to the integers.
    pub most_attempts: u32,
    pub progress: &'a Progress,
}

/// A map at the integers asked for.
pub(crate) struct Followed {
    pub map: PlacedMap,
    /// Inverted faces before untangling.
    pub folded: usize,
    /// Inverted faces that are left.
    pub left: usize,
    pub untangled: UntangleReport,
    /// Attempts in all.
    pub attempts: u32,
}

/// Shortest step towards the integers.
const SHORTEST_STEP: f64 = 1.0 / 64.0;

/// In longer steps than this, folds that need more than a few rings are not untangled: shorter ones have fewer of them.
const LARGEST_CAREFUL_STEP: f64 = 0.2;

/// Steps that succeed one after the other before the next one is longer.
const STREAK: u32 = 2;

impl Follower<'_> {
    /// Goes straight to the integers, then, if folds are left, in steps.
    ///
    /// # Input      model: fold-free; target: a map at the integers asked for, whose points do not matter; between: maps
    /// at fractions of the way from the model's integers to these
    /// # Output     the map with the fewest folds that was seen
    /// # Cost       one factorisation of the whole map per attempt, and untangling
    pub fn follow(
        &self,
        model: &PlacedMap,
        target: PlacedMap,
        between: impl Fn(f64) -> Result<PlacedMap, PlacementError>,
    ) -> Followed {
        let mut solver = PlacedSolver::new(self.mesh, &target);
        let quick = self.untangle.quick();
        // 1. Straight.
        let first = if self.most_attempts > 1 { &quick } else { self.untangle };
        let mut best = self.attempt(&mut solver, &target, model, first);
        // 2. In steps, half as long where one fails.
        let (mut at, mut step, mut streak, mut spent) = (0.0, 0.5, 0, best.untangled.steps);
        let mut last = model.clone();
        while best.left > 0 && step >= SHORTEST_STEP && self.goes_on(best.attempts, spent) {
            let next = f64::min(at + step, 1.0);
            let Ok(there) = (if next < 1.0 { between(next) } else { Ok(target.clone()) }) else { break };
            let options = if step > LARGEST_CAREFUL_STEP { &quick } else { self.untangle };
            let followed = self.attempt(&mut solver, &there, &last, options);
            spent += followed.untangled.steps;
            let attempts = best.attempts + 1;
            if next < 1.0 && followed.left == 0 {
                (at, last) = (next, followed.map);
                streak += 1;
            } else {
                (step, streak) = (0.5 * step, 0);
                if next >= 1.0 && followed.left < best.left {
                    best = followed;
                }
            }
            if streak == STREAK {
                (step, streak) = (2.0 * step, 0);
            }
            best.attempts = attempts;
        }
        best
    }

    fn goes_on(&self, attempts: u32, steps: u32) -> bool {
        attempts < self.most_attempts && steps <= self.most_steps && !self.progress.cancelled()
    }

    /// Gives the target Jacobians near those of the model, which keeps it nearly fold-free at its own integers, and
    /// untangles it.
    fn attempt(
        &self,
        solver: &mut PlacedSolver,
        target: &PlacedMap,
        model: &PlacedMap,
        options: &UntangleOptions,
    ) -> Followed {
        let wanted =
            FaceMap::from_fn(self.mesh.face_count(), |f| jacobian(&self.gradient[f], model.face(self.mesh, f)));
        let weight = wanted.map(|j| thinness(*j));
        let isotropic = EnergyOptions { anisotropy: 1.0 };
        let mut map = target.clone();
        solver.approach(self.mesh, &mut map, self.gradient, &weight, &isotropic, |f| wanted[f]);
        self.progress.spend(APPROACH_EFFORT * self.mesh.face_count());
        let folded = map.folded_faces(self.mesh).len();
        let untangled = untangle(self.mesh, &mut map, self.gradient, options, self.progress);
        let left = map.folded_faces(self.mesh).len();
        Followed { map, folded, left, untangled, attempts: 1 }
    }
}

/// A face of Jacobian J gets weight 1/σ_min(J)², at least 1 and at most 1e4: thin triangles fold first.
fn thinness(j: [[f64; 2]; 2]) -> f64 {
    let norm: f64 = j.as_flattened().iter().map(|x| x * x).sum();
    let determinant = (j[0][0] * j[1][1] - j[0][1] * j[1][0]).abs();
    // σ_min = det/σ_max and σ_max² ≤ |J|².
    (norm / (determinant * determinant).max(f64::MIN_POSITIVE)).clamp(1.0, 1e4)
}

/// Digits of a quad edge in which fractions of the way are given: sums of them are exact on the finer grid.
const FRACTION: f64 = 4096.0;

/// Integers on the way from some to others, as multiples of a fixed fraction.
pub(crate) fn on_the_way(from: &[f64], to: &[f64], part: f64) -> Vec<f64> {
    let between = |(a, b): (&f64, &f64)| (((1.0 - part) * a + part * b) * FRACTION).round() / FRACTION;
    from.iter().zip(to).map(between).collect()
}
