//! One connected surface becomes quads: the stages in order, attempt after attempt.
//!
//! In: a connected triangle mesh and what is asked of it. Out: [`Part`], verified.
//! Holds: quads that are returned have passed [`verify`]. Not: the count, which integers may miss.

use crate::calm::calm;
use crate::error::{RemeshError, Warning, WarningCode};
use crate::features::{FeatureRequest, Features, find_features};
use crate::ladder::{Climb, Effort, LADDER, Rung};
use crate::options::{Fallback, RemeshOptions};
use crate::report::Seconds;
use crate::singularities::{SingularityRequest, impossible, on_work_mesh, pinned};
use crate::sizes::{SizeRequest, relative_sizes};
use crate::split::split_surface;
use crate::stages::{
    MapRequest, Prescribed, SizedMap, WorkMesh, count_goal, cross_field, extract_quads, integer_grid_map, no_result,
    relocated, with_room, work_edge_length, work_mesh, work_mesh_with_field,
};
use crate::ties::{TieReport, TieRequest, joined_ties, ties_on};
use crate::verify::{Verification, lost_part, verify};
use quadloom_extract::{Distances, Extraction, FinishError, FinishOptions, FinishReport, Finished, Reference, finish};
use quadloom_field::{CrossField, Transport};
use quadloom_mesh::{DVec3, FaceMap, FeatureGraph, Progress, QuadMesh, TriMesh};
use quadloom_param::{RelocationReport, Tie};
use std::time::Instant;

/// What is asked of one connected surface.
#[derive(Clone, Debug)]
pub struct PartRequest<'a> {
    /// The surface.
    pub mesh: &'a TriMesh,
    /// Number of quads.
    pub quads: usize,
    /// Curves to keep.
    pub features: FeatureRequest,
    /// A direction per face to follow.
    pub field: Option<FaceMap<DVec3>>,
    /// Where quads are smaller or stretched.
    pub sizes: SizeRequest,
    /// Singular vertices to use.
    pub singularities: Vec<SingularityRequest>,
    /// Singular vertices that chains of quad edges are to join.
    pub ties: Vec<TieRequest>,
    /// Most attempts before triangles are split.
    pub attempts: usize,
}

/// The quads of one connected surface and how they came about.
#[derive(Clone, Debug)]
pub struct Part {
    /// The quads.
    pub quads: QuadMesh,
    /// Area of the surface, file units squared.
    pub area: f64,
    /// Diagonal of its bounding box, file units.
    pub diagonal: f64,
    /// Curves of the surface.
    pub features: Features,
    /// What the quads were extracted from; `None` where triangles were split.
    pub solution: Option<Solution>,
    /// The attempt that gave the result, from 0.
    pub attempt: usize,
    /// Map solves, over all attempts.
    pub solves: usize,
    /// What the quads were found to be; it passed.
    pub verification: Verification,
    /// Distances to the surface, percent of `diagonal`.
    pub distances: Distances,
    /// What should be known.
    pub warnings: Vec<Warning>,
    /// Time per stage.
    pub seconds: Seconds,
}

/// Work mesh, field, map and extraction of one attempt.
#[derive(Clone, Debug)]
pub struct Solution {
    /// The mesh that the rest lives on.
    pub work: WorkMesh,
    /// The cross field.
    pub field: CrossField,
    /// Its energy, radians squared.
    pub energy: f64,
    /// The map.
    pub map: SizedMap,
    /// The quads before finishing.
    pub extraction: Extraction,
    /// What became of the ties.
    pub ties: Vec<TieReport>,
    /// Relocation of singular vertices, if it was asked for and there was no given field.
    pub relocation: Option<RelocationReport>,
}

/// Work meshes for quads of several sizes are finer by this factor, so that the smallest quads have triangles too.
const ADAPTIVE_WORK_EDGE: f64 = 0.6;

/// Makes quads of one connected surface.
///
/// # Errors     no attempt passed and there is no fallback; given data that do not fit; cancellation
pub fn remesh_part(request: &PartRequest, options: &RemeshOptions, progress: &Progress) -> Result<Part, RemeshError> {
    let progress = progress.counting_anew();
    let mut run = Run::new(request, options, &progress);
    // 1. The ladder, with all features, then with those that were named.
    let [found, named] = run.features();
    run.climb = Climb::new(found.graph.edge_count() > named.graph.edge_count(), run.most_effort());
    let mut failure = no_result("remesh", "no attempt was made");
    let mut spare = None;
    for (attempt, rung) in LADDER.iter().enumerate().take(request.attempts) {
        if !run.climb.begins(rung, run.progress.spent()) {
            continue;
        }
        let features = if rung.sharp { &found } else { &named };
        let attempted = if run.climb.is_late(run.progress.spent()) && options.fallback == Fallback::Split {
            // Nothing else is tried if this fails: what is left then is made beside it.
            let split = run.splitting(&found);
            let (attempted, quads) = rayon::join(|| run.attempt(rung, features), split);
            spare = Some(quads);
            attempted
        } else {
            run.attempt(rung, features)
        };
        match attempted {
            Ok(mut passed) => {
                passed.attempt = attempt;
                let Some(doubt) = passed.doubt() else { return Ok(run.accept(passed, &found)) };
                // Another attempt may be clear.
                run.doubts.push((attempt, doubt.message.clone()));
                run.climb.keep(passed);
            }
            Err(e @ (RemeshError::Cancelled(_) | RemeshError::Mismatch { .. })) => return Err(e),
            Err(e) => {
                run.retried(attempt, &e.to_string());
                failure = e;
            }
        }
    }
    if run.climb.cut_short {
        run.warn(WarningCode::Retried, "further attempts would take too long and were not made".into());
    }
    if let Some(passed) = run.climb.reserve.take() {
        return Ok(run.accept(passed, &found));
    }
    // 2. The last resort.
    match options.fallback {
        Fallback::Off => Err(match failure {
            RemeshError::NoResult { stage, why, .. } => no_result(stage, format!("{why}; {CURE_WITHOUT_FALLBACK}")),
            other => other,
        }),
        Fallback::Split => {
            let made = spare.unwrap_or_else(run.splitting(&found));
            let (quads, checked) = run.split(made, &found, &failure)?;
            Ok(run.part(quads, found, None, LADDER.len(), checked))
        }
    }
}

/// Quads of one attempt that passed verification.
#[derive(Debug)]
pub(crate) struct Passed {
    quads: QuadMesh,
    solution: Solution,
    checked: Checked,
    features: Features,
    attempt: usize,
    /// What should be known if they are the result.
    warnings: Vec<Warning>,
}

/// What was found of quads that passed.
#[derive(Debug)]
struct Checked {
    verification: Verification,
    distances: Distances,
}

/// Warnings of an attempt that may be clear of them at other sizes, the worse one first.
const DOUBTS: [WarningCode; 3] = [WarningCode::FacingUnclear, WarningCode::FoldsSurvived, WarningCode::FeaturesLeft];

impl Passed {
    /// The worst doubt about the quads.
    fn doubt(&self) -> Option<&Warning> {
        DOUBTS.iter().find_map(|&code| self.warnings.iter().find(|w| w.code == code))
    }

    /// Place of the worst doubt in [`DOUBTS`]: of two results, the one with more is better.
    pub fn clarity(&self) -> usize {
        self.doubt().and_then(|w| DOUBTS.iter().position(|&code| code == w.code)).unwrap_or(DOUBTS.len())
    }

    /// Whether all quads face along the surface, whatever became of single vertices.
    pub fn faces_clearly(&self) -> bool {
        self.warnings.iter().all(|w| w.code != WarningCode::FacingUnclear)
    }
}

/// What all attempts on one surface share.
struct Run<'a> {
    request: &'a PartRequest<'a>,
    options: &'a RemeshOptions,
    progress: &'a Progress,
    area: f64,
    solves: usize,
    warnings: Vec<Warning>,
    /// Attempts that passed with a doubt, and the doubt; of one of them it is among the warnings of the result.
    doubts: Vec<(usize, String)>,
    /// Whether the attempt that runs, or ran last, took its directions from a smoothed copy.
    smoothed: bool,
    seconds: Seconds,
    /// What has become of the attempts.
    climb: Climb,
}

/// Interior singular vertices per quad beyond which no map is looked for.
///
/// Coarse boxes with bores have one for five quads, and maps without folds; beyond a quarter, rounding takes minutes and
/// ends in folds.
const MOST_SINGULAR_REL: f64 = 0.25;

/// Corners of features per quad beyond which no map is looked for, unless they are few.
///
/// Surfaces sampled so coarsely that every edge is sharp have one or two; work meshes grow to a hundred triangles a quad
/// between them, and the map folds. Machined parts have up to a fifth.
const MOST_CORNERS_REL: f64 = 0.25;

/// Corners that are worth an attempt for any number of quads: it takes a second or two.
const FEW_CORNERS: usize = 1000;

impl<'a> Run<'a> {
    fn new(request: &'a PartRequest<'a>, options: &'a RemeshOptions, progress: &'a Progress) -> Self {
        let area = request.mesh.area();
        Self {
            request,
            options,
            progress,
            area,
            solves: 0,
            warnings: Vec::new(),
            doubts: Vec::new(),
            smoothed: false,
            seconds: Seconds::default(),
            climb: Climb::new(false, 0),
        }
    }

    /// Effort after which neither another attempt nor another size is begun.
    fn most_effort(&self) -> u64 {
        Effort::OF_ATTEMPTS.most(self.request.quads)
    }

    fn warn(&mut self, code: WarningCode, message: String) {
        self.warnings.push(Warning::new(code, message));
    }

    fn retried(&mut self, attempt: usize, why: &str) {
        let size = if attempt == 0 { "at the first size" } else { "at a slightly other size" };
        self.warn(WarningCode::Retried, format!("an attempt {size} was not used: {why}"));
    }

    /// The result of an attempt becomes that of the run.
    ///
    /// # Input      found: all features, of which the attempt may have given up some
    fn accept(mut self, passed: Passed, found: &Features) -> Part {
        let dropped = found.graph.edge_count() - passed.features.graph.edge_count();
        if dropped > 0 {
            self.warn_of_dropped(dropped);
        }
        for (_, doubt) in std::mem::take(&mut self.doubts).into_iter().filter(|(k, _)| *k != passed.attempt) {
            self.warn(WarningCode::Retried, format!("an attempt at another size was not used: {doubt}"));
        }
        self.warnings.extend(passed.warnings);
        self.part(passed.quads, passed.features, Some(passed.solution), passed.attempt, passed.checked)
    }

    fn warn_of_dropped(&mut self, edges: usize) {
        let message = format!("no map that follows the {edges} sharp edges was found; they were not kept");
        self.warn(WarningCode::SharpEdgesDropped, message);
    }

    /// All features, and those that are there without looking for sharp edges.
    fn features(&mut self) -> [Features; 2] {
        let edge = (self.area / self.request.quads as f64).sqrt();
        let all = &self.request.features;
        let named = FeatureRequest { sharp_angle: None, ..all.clone() };
        self.seconds.time("features", || [all, &named].map(|wanted| find_features(self.request.mesh, wanted, edge)))
    }

    /// One way through the stages, verified.
    fn attempt(&mut self, rung: &Rung, features: &Features) -> Result<Passed, RemeshError> {
        let quads = rung.quads * self.request.quads as f64;
        let edge = (self.area / quads).sqrt();
        self.smoothed = false;
        self.check_corners(rung, features, quads)?;
        let (work, field, energy) = match &self.request.field {
            Some(direction) => self.given_field(&features.graph, direction)?,
            None => self.own_field(&features.graph, edge, rung.work_edge)?,
        };
        self.check_room(rung, &work, &field, quads)?;
        let (field, relocation) = self.relocated(&work, field, edge)?;
        let (work, field, energy) = match relocation {
            Some(_) => {
                let energy = field.energy(&work.mesh, &Transport::of(&work.mesh));
                let (work, field) = with_room(work, field, self.options)?;
                (work, field, energy)
            }
            None => (work, field, energy),
        };
        let ties = ties_on(&work, &field, self.request);
        let map = self.map(&work, &field, quads, edge, &ties)?;
        let inverted = map.parametrization.inverted.len();
        // The quads around the folds may still close up; if they do not, other sizes are not worth their time.
        self.climb.folded(rung, inverted, work.mesh.face_count());
        self.progress.report("extraction", 0.0);
        let integer_grid = &map.parametrization.map;
        let extraction = self.seconds.time("extraction", || extract_quads(&work, integer_grid, self.progress))?;
        let reference = self.seconds.time("reference", || Reference::new(self.request.mesh, &features.graph));
        let pinned = match self.request.singularities[..] {
            [] => None,
            _ => Some(pinned(&extraction, &work, self.request, edge).map_err(|e| no_result("finish", e))?),
        };
        let raw = pinned.as_ref().unwrap_or(&extraction);
        let finished = self.seconds.time("finish", || finish_quads(raw, &reference, self.options, self.progress))?;
        let quads = finished.mesh;
        let ties = joined_ties(&work, &extraction, self.request, &ties);
        let solution = Solution { work, field, energy, map, extraction, ties, relocation };
        self.check_for_lost_parts(&solution, &quads)?;
        let (checked, unclear) = self.checked(&quads, &reference)?;
        let noise = self.smoothed.then(noise_warning);
        let warnings =
            [unclear, left_warning(&finished.report), fold_warning(&solution), noise].into_iter().flatten().collect();
        Ok(Passed { quads, solution, checked, features: features.clone(), attempt: 0, warnings })
    }

    /// The input's own triangles with the field that was given: only the count varies between attempts.
    fn given_field(
        &mut self,
        features: &FeatureGraph,
        direction: &FaceMap<DVec3>,
    ) -> Result<(WorkMesh, CrossField, f64), RemeshError> {
        self.progress.report("work mesh", 0.0);
        let make = || work_mesh_with_field(self.request.mesh, features, direction, self.options);
        let (work, field) = self.seconds.time("work mesh", make)?;
        let energy = field.energy(&work.mesh, &Transport::of(&work.mesh));
        let (work, field) = with_room(work, field, self.options)?;
        Ok((work, field, energy))
    }

    /// A work mesh, and a field solved on it.
    fn own_field(
        &mut self,
        features: &FeatureGraph,
        edge: f64,
        work_edge_rel: f64,
    ) -> Result<(WorkMesh, CrossField, f64), RemeshError> {
        let room = if self.request.sizes.is_uniform() { 1.0 } else { ADAPTIVE_WORK_EDGE };
        let work_edge = work_edge_rel * room * work_edge_length(self.area, edge);
        let make = || work_mesh(self.request.mesh, features, work_edge, self.options, self.progress);
        let mut work = self.seconds.time("work mesh", make)?;
        let quads = self.area / (edge * edge);
        let calm = || calm(&mut work, quads, work_edge, self.options, self.progress);
        self.smoothed = self.seconds.time("work mesh", calm)?;
        let given = on_work_mesh(&work, self.request)?;
        let singularities = Prescribed { at: &given, only: !given.is_empty() && !self.options.other_singularities };
        self.progress.report("cross field", 0.0);
        let solve = || cross_field(&work, edge, singularities, self.progress);
        let (field, report) = self.seconds.time("cross field", solve)?;
        let (work, field) = with_room(work, field, self.options)?;
        Ok((work, field, report.energy))
    }

    /// The field with singular vertices where the map would rather have them, if that was asked for; a field that was
    /// given stays as it is.
    fn relocated(
        &mut self,
        work: &WorkMesh,
        field: CrossField,
        edge: f64,
    ) -> Result<(CrossField, Option<RelocationReport>), RemeshError> {
        let Self { request, options, progress, .. } = *self;
        if !options.relocate || request.field.is_some() {
            return Ok((field, None));
        }
        progress.report("relocation", 0.0);
        let relocate = || {
            let size = relative_sizes(work, &field, request.mesh, edge, &request.sizes, progress)?.scaled(edge);
            relocated(work, &field, &on_work_mesh(work, request)?, &size, progress)
        };
        let (field, report) = self.seconds.time("relocation", relocate)?;
        Ok((field, Some(report)))
    }

    /// Whether features leave room between their corners.
    fn check_corners(&mut self, rung: &Rung, features: &Features, quads: f64) -> Result<(), RemeshError> {
        let corners = features.graph.is_corner.values().iter().filter(|&&is_corner| is_corner).count();
        if corners as f64 <= MOST_CORNERS_REL * quads || corners <= FEW_CORNERS {
            return Ok(());
        }
        self.climb.has_no_room(rung);
        let why = format!(
            "{corners} corners of features leave no room in {quads:.0} quads; ask for more quads, or keep fewer edges \
             (--sharp-angle)"
        );
        Err(no_result("features", why))
    }

    /// Whether there are quads enough for the singular vertices, and any that have just those.
    fn check_room(&mut self, rung: &Rung, work: &WorkMesh, field: &CrossField, quads: f64) -> Result<(), RemeshError> {
        let singular = field.singularities(&work.mesh, &Transport::of(&work.mesh));
        let count = singular.iter().filter(|s| !work.mesh.is_boundary_vertex(s.0)).count();
        let why = if count as f64 > MOST_SINGULAR_REL * quads {
            format!("{count} singular vertices leave no room in {quads:.0} quads; ask for more quads")
        } else if let Some(why) = impossible(&work.mesh, singular.iter().map(|s| s.1)) {
            format!("{why}; give it more of them (--singularities)")
        } else {
            return Ok(());
        };
        self.climb.has_no_room(rung);
        Err(no_result("cross field", why))
    }

    /// A map of about so many quads; without the ties, where it folds with them and does not without.
    fn map(
        &mut self,
        work: &WorkMesh,
        field: &CrossField,
        quads: f64,
        edge: f64,
        ties: &[Option<Tie>],
    ) -> Result<SizedMap, RemeshError> {
        let Self { request, options, progress, .. } = *self;
        let sizes = || relative_sizes(work, field, request.mesh, edge, &request.sizes, progress);
        let size = self.seconds.time("sizing", sizes)?;
        progress.report("integer-grid map", 0.0);
        let (goal, most_effort) = (count_goal(quads, options), self.most_effort());
        let ties: Vec<Tie> = ties.iter().flatten().copied().collect();
        let mut solve = |ties: &[Tie]| {
            let wanted = MapRequest { method: options.method, ties, most_effort };
            let solve = || integer_grid_map(work, field, &size, goal, edge, wanted, progress);
            let map = self.seconds.time("integer-grid map", solve)?;
            self.solves += map.solves;
            Ok(map)
        };
        let map = solve(&ties);
        let folds =
            |map: &Result<SizedMap, RemeshError>| map.as_ref().map_or(usize::MAX, |m| m.parametrization.inverted.len());
        if ties.is_empty() || folds(&map) == 0 || matches!(map, Err(RemeshError::Cancelled(_))) {
            return map;
        }
        let free = solve(&[]);
        if folds(&free) < folds(&map) { free } else { map }
    }

    /// Where a map has folds, quads around them were closed up, perhaps across a sheet or rod that is then left out.
    fn check_for_lost_parts(&mut self, solution: &Solution, quads: &QuadMesh) -> Result<(), RemeshError> {
        if solution.map.parametrization.inverted.is_empty() {
            return Ok(());
        }
        match self.seconds.time("verify", || lost_part(quads, self.request.mesh)) {
            None => Ok(()),
            Some((v, distance, edges)) => {
                let why = format!(
                    "the quads leave out a part of the surface: vertex {v} is {distance:.3e} away, {edges:.1} edges"
                );
                Err(no_result("verification", why))
            }
        }
    }

    /// Distances of quads that pass verification, and a warning where the facing of some is unclear.
    fn checked(&mut self, quads: &QuadMesh, reference: &Reference) -> Result<(Checked, Option<Warning>), RemeshError> {
        self.progress.report("verify", 0.0);
        let verification = self.seconds.time("verify", || verify(quads, reference));
        if !verification.passed() {
            return Err(no_result("verification", verification.complaint()));
        }
        let unclear = verification.unclear.first().map(|first| {
            let count = verification.unclear.len();
            let message = format!("{count} quads may face against the input (first: {first}): their centres do");
            Warning::new(WarningCode::FacingUnclear, message)
        });
        let measure = || Distances::measure(quads, reference);
        let distances = self.seconds.time("distances", measure).map_err(|e| no_result("report", e))?;
        Ok((Checked { verification, distances }, unclear))
    }

    /// What makes quads of split triangles, and says how long it took; its effort is counted by itself.
    fn splitting<'b>(&self, features: &'b Features) -> impl FnOnce() -> Split + Send + use<'a, 'b> {
        let Self { request, options, progress, .. } = *self;
        let goal = count_goal(request.quads as f64, options);
        move || {
            let begun = Instant::now();
            let quads = split_surface(request.mesh, &features.graph, goal, &progress.counting_anew());
            Split { quads, seconds: begun.elapsed().as_secs_f64() }
        }
    }

    /// Split triangles, verified.
    fn split(
        &mut self,
        made: Split,
        features: &Features,
        failure: &RemeshError,
    ) -> Result<(QuadMesh, Checked), RemeshError> {
        let Self { request, .. } = *self;
        let because = |e: RemeshError| match e {
            RemeshError::NoResult { why, .. } => {
                no_result("split", format!("{why}; before that, {failure}; {CURE_OF_NO_RESULT}"))
            }
            other => other,
        };
        self.seconds.add("split", made.seconds);
        let quads = made.quads.map_err(because)?;
        let reference = Reference::new(request.mesh, &features.graph);
        let (checked, unclear) = self.checked(&quads, &reference).map_err(because)?;
        self.warnings.extend(unclear);
        let message = format!("no map without folds was found ({failure}); triangles were split into quads instead");
        self.warn(WarningCode::TrianglesSplit, message);
        Ok((quads, checked))
    }

    fn part(
        self,
        quads: QuadMesh,
        features: Features,
        solution: Option<Solution>,
        attempt: usize,
        checked: Checked,
    ) -> Part {
        let Self { request, area, solves, warnings, seconds, .. } = self;
        let Checked { verification, distances } = checked;
        Part {
            quads,
            area,
            diagonal: request.mesh.diagonal(),
            features,
            solution,
            attempt,
            solves,
            verification,
            distances,
            warnings,
            seconds,
        }
    }
}

/// What helps where not even split triangles pass: nearly always sheets that cannot be told apart.
const CURE_OF_NO_RESULT: &str = "where sheets lie on each other, with no thickness between them, delete one of them or \
                                 move them apart; elsewhere mend the surface at the places named, or ask for more quads \
                                 (--quads)";

/// What helps where no map is found and no triangles are to be split.
const CURE_WITHOUT_FALLBACK: &str = "ask for more quads (--quads), or let triangles be split (--fallback split)";

/// Quads of split triangles.
struct Split {
    quads: Result<QuadMesh, RemeshError>,
    seconds: f64,
}

/// Smoothing on the input.
fn finish_quads(
    extraction: &Extraction,
    reference: &Reference,
    options: &RemeshOptions,
    progress: &Progress,
) -> Result<Finished, RemeshError> {
    progress.report("finish", 0.0);
    let finishing = FinishOptions { crease_angle: options.sharp_angle, ..FinishOptions::default() };
    finish(extraction, reference, &finishing, progress).map_err(|e| match e {
        FinishError::Cancelled(c) => c.into(),
        other => no_result("finish", other),
    })
}

/// Distance from its feature, relative to the mean edge, from which a vertex that left it is worth a word and another
/// attempt: a fifth of a quad is seen in a picture.
const FAR_LEFT_REL: f64 = 0.2;

fn left_warning(report: &FinishReport) -> Option<Warning> {
    let FinishReport { released, released_farthest: far, .. } = *report;
    let message =
        format!("{released} vertices had to leave their feature, by up to {far:.1} edges, to keep quads valid");
    (far > FAR_LEFT_REL).then(|| Warning::new(WarningCode::FeaturesLeft, message))
}

fn noise_warning() -> Warning {
    let message = "the surface is rough at the size of its quads: directions were taken from a smoothed copy";
    Warning::new(WarningCode::NoiseSmoothed, message)
}

fn fold_warning(solution: &Solution) -> Option<Warning> {
    let folds = solution.map.parametrization.inverted.len();
    let message = format!("{folds} triangles of the map are inverted; the quads around them were closed up");
    (folds > 0).then(|| Warning::new(WarningCode::FoldsSurvived, message))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sphere of rings pressed flat: two sheets on each other, of which no vertex of one is one of the other.
    fn pressed_sphere() -> TriMesh {
        const RINGS: u32 = 7;
        const AROUND: u32 = 12;
        let mut positions = vec![DVec3::ZERO];
        for k in 1..RINGS {
            let radius = (f64::from(k) * std::f64::consts::PI / f64::from(RINGS)).sin();
            let angle = |j: u32| std::f64::consts::TAU * (f64::from(j) + 0.3 * f64::from(k)) / f64::from(AROUND);
            positions.extend((0..AROUND).map(|j| DVec3::new(radius * angle(j).cos(), radius * angle(j).sin(), 0.0)));
        }
        positions.push(DVec3::new(0.01, 0.0, 0.0));
        let last = positions.len() as u32 - 1;
        let at = |k: u32, j: u32| 1 + (k - 1) * AROUND + j % AROUND;
        let mut faces = Vec::new();
        for j in 0..AROUND {
            faces.push([0, at(1, j), at(1, j + 1)]);
            faces.push([last, at(RINGS - 1, j + 1), at(RINGS - 1, j)]);
            for k in 1..RINGS - 1 {
                faces.push([at(k, j), at(k + 1, j), at(k + 1, j + 1)]);
                faces.push([at(k, j), at(k + 1, j + 1), at(k, j + 1)]);
            }
        }
        TriMesh::new(positions, &faces).expect("a sphere")
    }

    fn asked_of(mesh: &TriMesh, attempts: usize) -> PartRequest<'_> {
        PartRequest {
            mesh,
            quads: 60,
            features: FeatureRequest::default(),
            field: None,
            sizes: SizeRequest::default(),
            singularities: Vec::new(),
            ties: Vec::new(),
            attempts,
        }
    }

    #[test]
    fn no_result_without_a_fallback_names_it() {
        let mesh = pressed_sphere();
        let options = RemeshOptions { fallback: Fallback::Off, ..RemeshOptions::default() };
        let error = remesh_part(&asked_of(&mesh, 0), &options, &Progress::none()).expect_err("no attempt");
        assert!(error.to_string().contains("--fallback split"), "{error}");
    }

    #[test]
    fn sheets_without_thickness_are_told_their_cure() {
        let mesh = pressed_sphere();
        let error =
            remesh_part(&asked_of(&mesh, 0), &RemeshOptions::default(), &Progress::none()).expect_err("no thickness");
        assert!(error.to_string().contains("move them apart"), "{error}");
    }
}
