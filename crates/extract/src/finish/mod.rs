//! Finishing: quads are moved onto the input surface and made as rectangular as their connectivity allows.
//!
//! In: an extraction, the input as [`Reference`]. Out: [`Finished`]. Holds: corners stay, vertices on a chain stay on
//! the input's curve and in order, all others on the input surface, except where only a place beside it keeps a quad
//! from being inverted; no step inverts a quad or turns it against the surface; the result is the same for any number
//! of threads. Not: that a quad inverted at the start is cured.
//! Source: [Bommes2012] §8.5 asks for it; the method is projective smoothing [Bouaziz2012] with rollback, own.

mod creases;
mod joints;
mod release;
mod shape;
mod spread;
mod state;
mod sweep;
mod ties;
mod tips;
mod untangle;

use crate::extraction::Extraction;
use crate::reference::Reference;
use creases::{CreaseError, follow_creases};
use joints::settle_on_joints;
use quadloom_mesh::{Cancelled, MeshError, Progress, QuadMesh};
use release::{release_around, release_single};
use serde::{Deserialize, Serialize};
use spread::spread_along_curves;
use state::{State, mean_edge};
use sweep::{Aim, sweep};
use ties::Ties;
use tips::reach_tips;
use untangle::{improve_beside, improve_worst};

/// How quads are finished.
#[derive(Clone, Debug, PartialEq)]
pub struct FinishOptions {
    /// Sweeps at most. Default 25: the mean angle moves by less than 0.1 degrees beyond. More cost time in proportion.
    pub sweeps: usize,
    /// Sweeps end when no vertex moves farther than this, relative to the mean edge. Default 0.01.
    pub settled_rel: f64,
    /// How much of its stretch a quad keeps in a sweep, 0..=1. Default 0.7. Smaller: more even edges; larger: better
    /// angles beside features that do not fit squares.
    pub stretch_kept: f64,
    /// Part of the mean of the neighbours in a proposal, 0..=1. Default 0.1: it keeps sizes even.
    pub laplacian: f64,
    /// Scaled Jacobian below which quads are improved one by one. Default 0.35.
    pub poor: f64,
    /// Rounds of that at most. Default 12.
    pub rounds: usize,
    /// Dihedral angle from which an edge of the surface is sharp, degrees: vertices go to such edges that are no features.
    /// Default 35, as for features. `None`: none do.
    pub crease_angle: Option<f64>,
    /// Whether vertices leave their feature where a quad stays inverted otherwise. Default true: a mesh without
    /// inverted quads is worth more than a few edge lengths of a feature, and the report counts them.
    pub release: bool,
}

/// Steps shorter than this are not made, relative to the length at which sweeps end.
const SHORTEST_STEP_REL: f64 = 0.2;

impl Default for FinishOptions {
    fn default() -> Self {
        Self {
            sweeps: 25,
            settled_rel: 0.01,
            stretch_kept: 0.7,
            laplacian: 0.1,
            poor: 0.35,
            rounds: 12,
            crease_angle: Some(35.0),
            release: true,
        }
    }
}

/// Rings of quads around an inverted one whose features are given up at most, the quad itself being the first.
const RELEASE_RINGS: usize = 4;

/// Quality below which a quad is cured before all else, and at any price in the end.
const LEAST_QUALITY: f64 = 0.05;

/// Sweeps after vertices were pinned to joints: their neighbours move by a fraction of an edge.
const SWEEPS_AFTER_PINNING: usize = 8;

/// Sweeps after each round of pinning vertices to joints: those that were in each other's way go in the second one.
const SWEEPS_AFTER_JOINTS: [usize; 2] = [SWEEPS_AFTER_PINNING, 3];

/// Scaled Jacobian down to which quads may get worse for a joint.
const JOINT_FLOOR: f64 = 0.3;

/// The same for what no vertex has reached at the end: the other vertices of such quads are moved once more after it.
const LAST_JOINT_FLOOR: f64 = 0.12;

/// The same where a chord cuts much off in spite of that: a poor quad is worth less than a feature that is seen to be cut.
const SPREAD_FLOOR: f64 = 0.06;

/// Strides towards tips, and sweeps after each.
const TIP_ROUNDS: usize = 5;

/// See there.
const SWEEPS_AFTER_TIPS: usize = 3;

/// What finishing did.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FinishReport {
    /// Sweeps made.
    pub sweeps: usize,
    /// Moves of single vertices at poor quads.
    pub single_moves: usize,
    /// Vertices whose corner or curve was not found on the input: they lie on the surface only.
    pub mismatched: usize,
    /// Vertices that were pinned to joints of their curves.
    pub pinned: usize,
    /// Moves of vertices towards tips of the surface that the quads cut off.
    pub tips: usize,
    /// Vertices that were pinned to sharp edges which are no features.
    pub creased: usize,
    /// Vertices that were spread along curves again, because a chord cut much off.
    pub spread: usize,
    /// Vertices that left their corner or curve because a quad stayed inverted otherwise.
    pub released: usize,
    /// Largest distance of those from where they belong, relative to the mean edge.
    pub released_farthest: f64,
    /// Moves of vertices to places beside the surface, because a quad stayed inverted otherwise.
    pub lifted: usize,
    /// Quads inverted or facing against the surface, as they came.
    pub bad_before: usize,
    /// The same at the end.
    pub bad_after: usize,
}

/// A finished quad mesh.
#[derive(Clone, Debug)]
pub struct Finished {
    /// The quads, numbered as in the extraction.
    pub mesh: QuadMesh,
    /// What was done.
    pub report: FinishReport,
}

/// Why finishing gave up.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FinishError {
    /// The caller or the time limit stopped the run.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A position is not finite: the input has coordinates near the limits of floating point.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

impl From<CreaseError> for FinishError {
    fn from(error: CreaseError) -> Self {
        match error {
            CreaseError::Cancelled(c) => c.into(),
            CreaseError::Mesh(e) => e.into(),
        }
    }
}

/// Moves the quads onto the input surface and smooths them there.
///
/// # Input      quads: an extraction whose chain numbers are those of `reference`
/// # Output     the same connectivity with other positions
/// # Errors     cancellation; positions that are not finite
/// # Cost       per sweep one closest-point query per vertex, in parallel
/// # Guarantees no quad becomes inverted or turns against the surface once it is neither; deterministic
pub fn finish(
    quads: &Extraction,
    reference: &Reference,
    options: &FinishOptions,
    progress: &Progress,
) -> Result<Finished, FinishError> {
    progress.check()?;
    // 1. Onto the input.
    let mut run = Run::new(quads, reference, options, progress);
    // 2. What is inverted is cured first: sweeps only keep what is good.
    run.cure_inverted()?;
    // 3. Sweeps.
    run.sweep(options.sweeps)?;
    run.state.settle();
    // 4. Joints of coarse curves get a vertex, to which the others adapt.
    run.settle_on_joints()?;
    // 5. The worst ones by themselves.
    run.improve_poor()?;
    // 6. Tips that stick out of the quads.
    run.reach_tips()?;
    // 7. Sharp edges that are no features.
    run.follow_creases()?;
    // 8. Joints that are cut off still.
    run.settle_on_last_joints()?;
    // 9. Curves whose chords cut much off in spite of all that.
    run.spread_along_curves()?;
    // 10. A feature is given up where it alone keeps a quad inverted.
    if options.release {
        run.release()?;
    }
    // 11. So is the surface itself.
    run.leave_surface()?;
    progress.report("finish", 1.0);
    run.finished()
}

/// Finishing on its way.
struct Run<'a> {
    state: State<'a>,
    /// Mean length of the quads' edges as they came, file units.
    edge: f64,
    aim: Aim,
    options: &'a FinishOptions,
    report: FinishReport,
    progress: &'a Progress,
}

impl<'a> Run<'a> {
    fn new(
        quads: &'a Extraction,
        reference: &'a Reference,
        options: &'a FinishOptions,
        progress: &'a Progress,
    ) -> Self {
        let edge = mean_edge(&quads.mesh, quads.mesh.positions());
        let ties = Ties::new(quads, reference, edge);
        let mismatched = ties.mismatched;
        let (state, bad_before) = State::new(&quads.mesh, reference, ties);
        let shortest_step = SHORTEST_STEP_REL * options.settled_rel * edge;
        let aim = Aim { stretch_kept: options.stretch_kept, laplacian: options.laplacian, shortest_step };
        let report = FinishReport { mismatched, bad_before, ..FinishReport::default() };
        Self { state, edge, aim, options, report, progress }
    }

    /// Sweeps until no vertex moves far, at most so many times.
    fn sweep(&mut self, sweeps: usize) -> Result<(), Cancelled> {
        for k in 0..sweeps {
            self.progress.check()?;
            self.progress.report("finish", k as f64 / sweeps as f64);
            self.progress.spend(SWEEP_EFFORT * self.state.quads.vertex_count());
            self.report.sweeps += 1;
            if sweep(&mut self.state, self.aim) < self.options.settled_rel * self.edge {
                break;
            }
        }
        Ok(())
    }

    /// Improves quads below a threshold one by one.
    fn improve(&mut self, threshold: f64) -> Result<(), Cancelled> {
        self.report.single_moves += improve_worst(&mut self.state, threshold, self.options.rounds, self.progress)?;
        Ok(())
    }

    /// Improves poor quads one by one; vertices that were off the surface for their sake come back.
    fn improve_poor(&mut self) -> Result<(), Cancelled> {
        self.improve(self.options.poor)?;
        self.state.project_all();
        Ok(())
    }

    fn cure_inverted(&mut self) -> Result<(), Cancelled> {
        if self.state.bad_quads() > 0 {
            self.improve(LEAST_QUALITY)?;
        }
        Ok(())
    }

    fn settle_on_joints(&mut self) -> Result<(), Cancelled> {
        for sweeps in SWEEPS_AFTER_JOINTS {
            let pinned = settle_on_joints(&mut self.state, self.edge, JOINT_FLOOR, self.aim, self.progress)?;
            self.report.pinned += pinned;
            if pinned == 0 {
                break;
            }
            self.sweep(self.options.sweeps.min(sweeps))?;
        }
        Ok(())
    }

    fn reach_tips(&mut self) -> Result<(), FinishError> {
        for _ in 0..TIP_ROUNDS {
            let moved = reach_tips(&mut self.state, self.edge)?;
            self.report.tips += moved;
            if moved == 0 {
                break;
            }
            self.sweep(self.options.sweeps.min(SWEEPS_AFTER_TIPS))?;
        }
        if self.report.tips > 0 {
            self.improve_poor()?;
        }
        Ok(())
    }

    fn follow_creases(&mut self) -> Result<(), FinishError> {
        if let Some(angle) = self.options.crease_angle {
            self.report.creased = follow_creases(&mut self.state, angle, self.edge, self.aim, self.progress)?;
        }
        if self.report.creased > 0 {
            self.sweep(self.options.sweeps.min(SWEEPS_AFTER_PINNING))?;
            self.improve_poor()?;
        }
        Ok(())
    }

    fn settle_on_last_joints(&mut self) -> Result<(), Cancelled> {
        let pinned = settle_on_joints(&mut self.state, self.edge, LAST_JOINT_FLOOR, self.aim, self.progress)?;
        self.report.pinned += pinned;
        if pinned > 0 { self.improve(self.options.poor) } else { Ok(()) }
    }

    fn spread_along_curves(&mut self) -> Result<(), Cancelled> {
        self.report.spread = spread_along_curves(&mut self.state, self.edge, SPREAD_FLOOR, self.progress)?;
        if self.report.spread > 0 { self.improve_poor() } else { Ok(()) }
    }

    /// Vertices leave their feature: single ones first, then all around an inverted quad.
    fn release(&mut self) -> Result<(), Cancelled> {
        if self.state.bad_quads() > 0 {
            self.report.released += release_single(&mut self.state);
            self.improve(LEAST_QUALITY)?;
        }
        for rings in 0..RELEASE_RINGS {
            if self.state.bad_quads() == 0 {
                break;
            }
            self.report.released += release_around(&mut self.state, rings);
            self.improve(self.options.poor)?;
        }
        Ok(())
    }

    fn leave_surface(&mut self) -> Result<(), Cancelled> {
        self.state.distrust_corners();
        if self.state.bad_quads() > 0 {
            self.report.lifted = improve_beside(&mut self.state, LEAST_QUALITY, self.options.rounds, self.progress)?;
        }
        Ok(())
    }

    fn finished(self) -> Result<Finished, FinishError> {
        let Self { state, edge, mut report, .. } = self;
        report.released_farthest = state.farthest_left() / edge.max(f64::MIN_POSITIVE);
        report.bad_after = state.bad_quads();
        let mesh = state.quads.with_positions(state.position)?;
        Ok(Finished { mesh, report })
    }
}

/// Effort of a sweep, per vertex.
const SWEEP_EFFORT: usize = 4;
