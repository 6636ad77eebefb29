//! From a cross field to an integer-grid map: solve, stiffen, untangle, separate.
//!
//! In: a triangle mesh, its features, a cross field, sizes. Out: [`Parametrization`] with the exact map and a report
//! of every rung that was needed. Holds: transitions, singular vertices and features are exact; `inverted` lists the
//! faces that stayed inverted, and is empty for a valid map.
//! Source: [Bommes2012] ch. 6 and §8.4; the rungs after stiffening are documented in [`Parametrizer::map`].

use crate::charts::Charts;
use crate::curves::curves;
use crate::fans::saddles;
use crate::follow::{Follower, on_the_way};
use crate::integer_grid_map::{GRID_UNIT, IntegerGridMap};
use crate::placed::{PlacedMap, PlacementError};
use crate::problem::{
    EnergyOptions, FaceGradient, face_gradients, map_constraints, orientation_energy, variable_count,
};
use crate::quantise::{SeparationOptions, SeparationReport, separate};
use crate::sight::sights;
use crate::stiffen::{self, StiffenOptions, StiffenReport, stiffen};
use crate::ties::{Tie, TieError, TiePath, must_differ};
use crate::tmesh::trace;
use crate::untangle::{UntangleOptions, UntangleReport, untangle};
use quadloom_field::{CrossField, SizeField, Transport};
use quadloom_mesh::{Cancelled, EdgeMap, FaceId, FaceMap, FeatureGraph, Progress, TriConnectivity, TriMesh, metric};
use quadloom_numeric::{Rounding, SolveError, SolveOptions, Solver, Updates};
use std::time::Instant;

/// How the map is made.
#[derive(Clone, Debug)]
pub struct ParamOptions {
    /// Choice of the integers. Default: greedy; direct is faster and worse ([Bommes2012] §5.3).
    pub method: Method,
    /// The energy's norm.
    pub energy: EnergyOptions,
    /// Local stiffening.
    pub stiffen: StiffenOptions,
    /// Untangling at fixed integers.
    pub untangle: UntangleOptions,
    /// Re-rounding under separation conditions.
    pub separation: SeparationOptions,
    /// Most attempts at points for separated integers. Default 40: most maps need one, and few more than ten.
    pub followings: u32,
    /// Stiffened re-solves of the seamless map that separation starts from. Default 8: most need one or two.
    pub seamless_rounds: u32,
}

impl Default for ParamOptions {
    fn default() -> Self {
        Self {
            method: Method::Greedy,
            energy: EnergyOptions::default(),
            stiffen: StiffenOptions::default(),
            untangle: UntangleOptions::default(),
            separation: SeparationOptions::default(),
            followings: 40,
            seamless_rounds: 8,
        }
    }
}

/// Choice of the integers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub enum Method {
    /// Nearest first, the others updated in between ([Bommes2012] §5.2.2).
    #[default]
    Greedy,
    /// All at once from the relaxation ([Bommes2012] §5.2.1).
    Direct,
}

/// Why there is no map.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ParamError {
    /// The linear problem has no solution.
    #[error("the map's constraints cannot be met: {0}")]
    Solve(SolveError),
    /// The solution does not close up.
    #[error("the map does not close: {0}")]
    Placement(PlacementError),
    /// Two singular vertices cannot be tied.
    #[error(transparent)]
    Tie(#[from] TieError),
    /// Seams on which every face would depend: the reduced system would take too long.
    #[error(
        "the map's reduced system would take about {entries} products: the surface has too many handles for its seams"
    )]
    TooDense {
        /// Products of coefficients that make up the reduced matrix.
        entries: usize,
    },
    /// The run was asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// A rung of the ladder that produced the map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub enum Rung {
    /// The solver's solution was fold-free.
    #[default]
    Solved,
    /// Stiffening removed the folds.
    Stiffened,
    /// Untangling at fixed integers removed the folds.
    Untangled,
    /// Other integers were chosen under separation conditions.
    Separated,
}

/// What was done to get the map.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct ParamReport {
    /// Variables before elimination.
    pub variables: usize,
    /// Free integers after elimination.
    pub integers: usize,
    /// Energy of the rounded solution (without its constant).
    pub energy: f64,
    /// Inverted faces right after the solve.
    pub inverted_after_solve: usize,
    /// Stiffening of the last attempt.
    pub stiffen: StiffenReport,
    /// Untangling of the last attempt.
    pub untangle: UntangleReport,
    /// Separation, if it was needed.
    pub separation: Option<SeparationReport>,
    /// Last rung used.
    pub rung: Rung,
    /// Seconds of set-up, solving, repairing.
    pub seconds: [f64; 3],
}

/// A map right after its integers were rounded; triangles may be inverted.
#[derive(Clone, Debug)]
pub struct Rounded {
    placed: PlacedMap,
    gradient: FaceMap<FaceGradient>,
    report: ParamReport,
    /// Area of its image, grid units squared: the number of quads that the repaired map will have, but for a few
    /// percent.
    pub area: f64,
}

/// Area of a map's image, grid units squared: its number of quads.
pub fn area_of(mesh: &TriConnectivity, map: &IntegerGridMap) -> f64 {
    let twice: i128 = mesh.faces().map(|f| map.face_area(mesh, f)).sum();
    let unit = GRID_UNIT as f64;
    0.5 * (twice as f64) / (unit * unit)
}

/// An integer-grid map and how it came about.
#[derive(Clone, Debug)]
pub struct Parametrization {
    /// The map; valid where `inverted` is empty.
    pub map: IntegerGridMap,
    /// Faces that are inverted, degenerate or around a wrongly wound singular vertex in the map, ascending.
    pub inverted: Vec<FaceId>,
    /// What was done.
    pub report: ParamReport,
}

/// Charts and eliminated constraints of one field, ready for several sizes.
pub struct Parametrizer<'a> {
    mesh: &'a TriMesh,
    features: &'a FeatureGraph,
    field: &'a CrossField,
    length: EdgeMap<f64>,
    charts: Charts,
    solver: Solver,
    updates: Updates,
    setup_seconds: f64,
}

impl<'a> Parametrizer<'a> {
    /// Cuts the mesh along seams and eliminates the constraints.
    ///
    /// # Errors     rows that exclude each other, named by what they say
    /// # Cost       near linear
    pub fn new(mesh: &'a TriMesh, features: &'a FeatureGraph, field: &'a CrossField) -> Result<Self, ParamError> {
        Self::with_ties(mesh, features, field, &[])
    }

    /// As [`Parametrizer::new`], for maps in which an iso-line runs from one end of each tie to the other.
    ///
    /// # Errors     besides, ties that cannot be met
    /// # Source     [Bommes2012] §8.6, base complex
    pub fn with_ties(
        mesh: &'a TriMesh,
        features: &'a FeatureGraph,
        field: &'a CrossField,
        ties: &[Tie],
    ) -> Result<Self, ParamError> {
        let start = Instant::now();
        let length = metric::edge_lengths(mesh);
        let transport = Transport::new(mesh, &length);
        let charts = Charts::new(mesh, &length, &transport, features, field);
        let paths: Vec<TiePath> =
            ties.iter().map(|&tie| TiePath::new(mesh, &charts, &transport, field, tie)).collect::<Result<_, _>>()?;
        let constraints = map_constraints(mesh, features, &charts, &paths);
        let solver = Solver::new(variable_count(&charts), &constraints.rows, &constraints.integers)
            .map_err(ParamError::Solve)?;
        must_differ(&paths, solver.elimination())?;
        let entries = reduced_entries(mesh, &charts, &solver);
        if entries > MOST_ENTRIES {
            return Err(ParamError::TooDense { entries });
        }
        // Where every variable depends on hundreds of integers, nothing is local and the ladder's sweeps never end.
        let updates = if entries > DENSE_ENTRIES_PER_FACE * mesh.face_count() { Updates::Schur } else { Updates::Auto };
        let setup_seconds = start.elapsed().as_secs_f64();
        Ok(Self { mesh, features, field, length, charts, solver, updates, setup_seconds })
    }

    /// The seams and the combed field.
    pub fn charts(&self) -> &Charts {
        &self.charts
    }

    /// Makes the map at the given sizes.
    ///
    /// The ladder, each rung only where the one before left inverted triangles:
    ///
    /// 1. mixed-integer solve ([Bommes2012] §8.4);
    /// 2. local stiffening at its integers;
    /// 3. untangling at its integers ([Garanzha2021]);
    /// 4. the seamless map without integers is traced ([`crate::tmesh`]), the integers are chosen again so that none of
    ///    its arcs is reversed or collapses ([`crate::quantise`]), and the map at these integers is untangled.
    ///
    /// # Output     the map of the rung with the fewest inverted triangles
    /// # Errors     [`ParamError::Solve`] where the energy does not determine the map
    pub fn map(
        &mut self,
        size: &SizeField,
        options: &ParamOptions,
        progress: &Progress,
    ) -> Result<Parametrization, ParamError> {
        let rounded = self.rounded(size, options, progress)?;
        self.repaired(rounded, options, progress)
    }

    /// Rung 1 of [`Parametrizer::map`]: what the later ones start from, at a fraction of their cost.
    ///
    /// # Errors     [`ParamError::Solve`] where the energy does not determine the map
    pub fn rounded(
        &mut self,
        size: &SizeField,
        options: &ParamOptions,
        progress: &Progress,
    ) -> Result<Rounded, ParamError> {
        let start = Instant::now();
        let mut report = ParamReport { variables: variable_count(&self.charts), ..Default::default() };
        report.seconds[0] = self.setup_seconds;
        let gradient = face_gradients(self.mesh, &self.length, self.field, size, &self.charts);
        let placed = self.solve(&gradient, options, &mut report, progress)?;
        report.seconds[1] = start.elapsed().as_secs_f64();
        let area = area_of(self.mesh, &placed.to_lattice(self.mesh));
        Ok(Rounded { placed, gradient, report, area })
    }

    /// Rungs 2 to 4 of [`Parametrizer::map`].
    ///
    /// # Output     the map of the rung with the fewest inverted triangles
    pub fn repaired(
        &mut self,
        rounded: Rounded,
        options: &ParamOptions,
        progress: &Progress,
    ) -> Result<Parametrization, ParamError> {
        let start = Instant::now();
        let Rounded { mut placed, gradient, mut report, .. } = rounded;
        report.inverted_after_solve = placed.folded_faces(self.mesh).len();
        // 2., 3. Other points at the same integers.
        let quick = options.untangle.quick();
        report.rung = self.repair(&mut placed, &gradient, options, &quick, &mut report, progress)?;
        let mut inverted = placed.folded_faces(self.mesh);
        // 4. Other integers.
        if !inverted.is_empty() {
            progress.check()?;
            let mut second = report.clone();
            if let Some(other) = self.separated(&gradient, options, &mut second, progress)? {
                let still = other.folded_faces(self.mesh);
                report.separation = second.separation.clone();
                if still.len() < inverted.len() {
                    second.rung = Rung::Separated;
                    (placed, inverted, report) = (other, still, second);
                }
            } else {
                report.separation = second.separation;
                if inverted.len() <= HOPELESS_FOLDS {
                    report.untangle = untangle(self.mesh, &mut placed, &gradient, &options.untangle, progress);
                    inverted = placed.folded_faces(self.mesh);
                }
            }
        }
        report.seconds[2] = start.elapsed().as_secs_f64();
        progress.check()?;
        Ok(Parametrization { map: placed.to_lattice(self.mesh), inverted, report })
    }

    /// Rung 1 alone.
    pub(crate) fn solve(
        &mut self,
        gradient: &FaceMap<FaceGradient>,
        options: &ParamOptions,
        report: &mut ParamReport,
        progress: &Progress,
    ) -> Result<PlacedMap, ParamError> {
        let weight = self.first_weights(&options.stiffen);
        let energy = orientation_energy(self.mesh, &self.charts, gradient, &weight, &options.energy, 1.0);
        let cancelled = || progress.cancelled();
        let rounding = match options.method {
            Method::Greedy => Rounding::Greedy,
            Method::Direct => Rounding::Direct,
        };
        let solve_options =
            SolveOptions { rounding, updates: self.updates, cancelled: Some(&cancelled), ..SolveOptions::default() };
        let solution = self.solver.solve(&energy, &solve_options).map_err(|e| solve_error(e, progress))?;
        progress.spend(SOLVE_EFFORT * self.mesh.face_count());
        report.integers = solution.report.free_integers;
        report.energy = solution.energy;
        PlacedMap::new(self.mesh, &self.charts, &solution.x, GRID_UNIT).map_err(ParamError::Placement)
    }

    fn first_weights(&self, options: &StiffenOptions) -> FaceMap<f64> {
        stiffen::first_weights(self.mesh, &saddles(self.mesh, &self.charts), options)
    }

    /// Rungs 2 and 3 at the map's integers.
    fn repair(
        &self,
        placed: &mut PlacedMap,
        gradient: &FaceMap<FaceGradient>,
        options: &ParamOptions,
        untangling: &UntangleOptions,
        report: &mut ParamReport,
        progress: &Progress,
    ) -> Result<Rung, ParamError> {
        report.stiffen = stiffen(self.mesh, placed, gradient, &options.energy, &options.stiffen, progress);
        progress.check()?;
        if report.stiffen.inverted_after == 0 {
            return Ok(if report.stiffen.iterations == 0 { Rung::Solved } else { Rung::Stiffened });
        }
        if report.stiffen.inverted_after <= MOST_UNTANGLED {
            report.untangle = untangle(self.mesh, placed, gradient, untangling, progress);
            progress.check()?;
        }
        Ok(Rung::Untangled)
    }

    /// A seamless map: integers on a grid so fine that rounding to it does not matter; or the faces left inverted.
    ///
    /// Singular vertices and features can start on the wrong side of each other, where untangling cannot help; hence
    /// whole re-solves with stiffened weights ([Bommes2012] §8.4), each followed by untangling.
    fn seamless(
        &mut self,
        gradient: &FaceMap<FaceGradient>,
        options: &ParamOptions,
        progress: &Progress,
    ) -> Result<Result<Seamless, Vec<FaceId>>, ParamError> {
        let scale = (GRID_UNIT / SEAMLESS_UNIT) as f64;
        let direct = SolveOptions { rounding: Rounding::Direct, ..SolveOptions::default() };
        let mut weight = self.first_weights(&options.stiffen);
        let mut folds = Vec::new();
        let (mut fewest, mut in_vain, mut steps) = (usize::MAX, 0, 0);
        for round in 0..=options.seamless_rounds {
            progress.check()?;
            let energy = orientation_energy(self.mesh, &self.charts, gradient, &weight, &options.energy, scale);
            let solution = self.solver.solve(&energy, &direct).map_err(|e| solve_error(e, progress))?;
            progress.spend(SOLVE_EFFORT * self.mesh.face_count());
            let mut map =
                PlacedMap::new(self.mesh, &self.charts, &solution.x, SEAMLESS_UNIT).map_err(ParamError::Placement)?;
            if round < options.seamless_rounds {
                stiffen::reweight(self.mesh, &map, gradient, &mut weight, &options.stiffen);
            }
            steps += untangle(self.mesh, &mut map, gradient, &options.untangle.quick(), progress).steps;
            folds = map.folded_faces(self.mesh);
            if !folds.is_empty() && folds.len() <= HOPELESS_FOLDS {
                steps += untangle(self.mesh, &mut map, gradient, &options.untangle, progress).steps;
                folds = map.folded_faces(self.mesh);
            }
            if folds.is_empty() {
                let x = solution.x.iter().map(|x| x / scale).collect();
                return Ok(Ok(Seamless { map, x }));
            }
            in_vain = if folds.len() < fewest { 0 } else { in_vain + 1 };
            fewest = fewest.min(folds.len());
            if in_vain >= ROUNDS_IN_VAIN || steps > self.most_steps() {
                break;
            }
        }
        Ok(Err(folds))
    }

    /// Integers that keep every arc of the seamless map's motorcycle graph; `None` where there is no fold-free
    /// seamless map or no such integers were found.
    fn separated(
        &mut self,
        gradient: &FaceMap<FaceGradient>,
        options: &ParamOptions,
        report: &mut ParamReport,
        progress: &Progress,
    ) -> Result<Option<PlacedMap>, ParamError> {
        // 1. A seamless map without folds.
        let seamless = match self.seamless(gradient, options, progress)? {
            Ok(map) => map,
            Err(folds) => {
                report.separation = Some(SeparationReport {
                    seamless_inverted: folds.len(),
                    seamless_inverted_faces: folds.into_iter().take(MAX_NAMED_FACES).collect(),
                    ..Default::default()
                });
                return Ok(None);
            }
        };
        let weight = self.first_weights(&options.stiffen);
        // 2. Its motorcycle graph.
        let lattice = seamless.map.to_lattice(self.mesh);
        let Ok(tmesh) = trace(self.mesh, self.features, &self.charts, &lattice, progress) else {
            return Ok(None);
        };
        let seen = sights(self.mesh, &self.charts, &lattice, SIGHT);
        let most_steps = self.most_steps();
        // 3. Integers.
        let energy = orientation_energy(self.mesh, &self.charts, gradient, &weight, &options.energy, 1.0);
        let cancelled = || progress.cancelled();
        let solve_options = SolveOptions { cancelled: Some(&cancelled), ..SolveOptions::default() };
        let failed = |e| solve_error(e, progress);
        let problem = self.solver.integer_problem(&energy, &solve_options).map_err(failed)?;
        progress.spend(SOLVE_EFFORT * self.mesh.face_count() + problem.len().pow(3) / MULTIPLICATIONS);
        let features = curves(self.mesh, gradient, &tmesh, &problem);
        let (z, separation) =
            separate(&tmesh, &seen, &features, &options.separation, &problem, &solve_options).map_err(failed)?;
        progress.spend(problem.effort() / MULTIPLICATIONS);
        progress.check()?;
        let x = problem.complete(&z).map_err(failed)?;
        let target = PlacedMap::new(self.mesh, &self.charts, &x, GRID_UNIT).map_err(ParamError::Placement)?;
        // 4. Points at these integers.
        let most_attempts = if separation.violated == 0 { options.followings } else { 1 };
        let untangle = &options.untangle;
        let follower = Follower { mesh: self.mesh, gradient, untangle, most_steps, most_attempts, progress };
        let first = problem.values_in(&seamless.x);
        let scale = (GRID_UNIT / SEAMLESS_UNIT) as f64;
        let between = |part: f64| {
            let x: Vec<f64> =
                problem.complete_relaxed(&on_the_way(&first, &z, part)).iter().map(|x| x * scale).collect();
            PlacedMap::new(self.mesh, &self.charts, &x, SEAMLESS_UNIT)
        };
        let followed = follower.follow(&seamless.map, target, between);
        report.untangle = followed.untangled;
        let inverted = [followed.folded, followed.left];
        report.separation = Some(SeparationReport { inverted, followings: followed.attempts, ..separation });
        Ok(Some(followed.map))
    }

    /// Newton steps of untangling after which no further round is begun.
    fn most_steps(&self) -> u32 {
        LEAST_STEPS.max(u32::try_from(self.mesh.face_count()).unwrap_or(u32::MAX))
    }
}

/// Grid units within which integer vertices are kept off each other and off features: rounding seldom moves two of them
/// towards each other by more.
const SIGHT: f64 = 2.5;

/// Effort of a solve for a map, per face.
const SOLVE_EFFORT: usize = 20;

/// Multiplications of dense matrices in a unit of effort.
const MULTIPLICATIONS: usize = 500;

/// Newton steps that any map may take: a few regions with all their rings. Larger meshes may take one per face: a
/// crumb of a hundred faces would else take as long as a whole model, and many models have a hundred crumbs.
const LEAST_STEPS: u32 = 300;

/// Products that one reduction of the energy may take: about ten seconds.
///
/// Ordinary maps need 36 a face and little more; surfaces of very high genus have seams that tie every variable to
/// hundreds of integers.
const MOST_ENTRIES: usize = 10_000_000_000;

/// Products per face beyond which roundings are felt everywhere; sparse maps have 36 to 100.
const DENSE_ENTRIES_PER_FACE: usize = 1000;

/// Entries that the orientation energy has after elimination: per face, the product of its corners' expressions.
fn reduced_entries(mesh: &TriMesh, charts: &Charts, solver: &Solver) -> usize {
    let terms = |variable: usize| solver.elimination().expression(variable).terms.len();
    mesh.faces()
        .map(|f| {
            let node = mesh.face_half_edges(f).map(|h| charts.node[h] as usize);
            (0..2).map(|c| node.iter().map(|n| terms(2 * n + c)).sum::<usize>().pow(2)).sum::<usize>()
        })
        .sum()
}

/// Inverted faces beyond which untangling at the first integers is not worth its time once separation has failed.
const HOPELESS_FOLDS: usize = 12;

/// Re-solves of the seamless map without fewer folds after which it is given up.
///
/// Folds go down in nearly every round where they go away at all.
const ROUNDS_IN_VAIN: u32 = 3;

/// Inverted faces beyond which the first integers are taken to be wrong and only others can help.
const MOST_UNTANGLED: usize = 120;

/// Faces that a report names.
const MAX_NAMED_FACES: usize = 20;

/// Lattice units of the grid on which the seamless map lives: 2^-16 of a quad edge.
///
/// Finer: rounding moves singular vertices less (this is far below any triangle's height already); coarser would leave
/// more lattice digits below it, which it does not need.
const SEAMLESS_UNIT: i64 = GRID_UNIT >> 16;

/// A fold-free map on a grid so fine that rounding to it does not matter.
struct Seamless {
    map: PlacedMap,
    /// The solution that has its integers, grid units.
    x: Vec<f64>,
}

fn solve_error(error: SolveError, progress: &Progress) -> ParamError {
    match progress.check() {
        Err(cancelled) => ParamError::Cancelled(cancelled),
        Ok(()) => ParamError::Solve(error),
    }
}
