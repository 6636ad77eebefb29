//! One connected surface becomes quads: the stages in order, and the ladder of attempts.
//!
//! In: a connected triangle mesh and what is asked of it. Out: [`Part`], verified.
//! Holds: quads that are returned have passed [`verify`]. Not: the count, which integers may miss.

use crate::count::{Tried, fit_count};
use crate::error::{RemeshError, Warning, WarningCode};
use crate::features::{FeatureRequest, Features, find_features};
use crate::options::{Fallback, RemeshOptions};
use crate::report::Seconds;
use crate::sizes::{SizeRequest, relative_sizes};
use crate::split::{QUADS_PER_TRIANGLE, split_triangles};
use crate::stages::{
    SizedMap, WorkMesh, count_goal, cross_field, extract_quads, integer_grid_map, no_result, work_edge_length,
    work_mesh, work_mesh_with_field,
};
use crate::verify::verify;
use quadloom_extract::{Distances, Extraction, FinishError, FinishOptions, Reference, finish};
use quadloom_field::CrossField;
use quadloom_mesh::{DVec3, FaceMap, FeatureGraph, Progress, QuadMesh, TriMesh, VertexId};

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
    /// Singular vertices to use, with their index in quarters.
    pub singularities: Vec<(VertexId, i32)>,
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
    /// Distances to the surface, if they were asked for.
    pub distances: Option<Distances>,
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
}

/// Sizes of one attempt, relative to the first one.
struct Attempt {
    work_edge: f64,
    quads: f64,
    /// Whether sharp edges that nobody named are kept.
    sharp: bool,
}

/// The ladder: other work meshes move the singularities and the integers, slightly other counts stay within the
/// usual tolerance; then sharp edges that were only found, not named, are given up; only the last rung leaves the
/// tolerance.
const LADDER: [Attempt; 5] = [
    Attempt { work_edge: 1.0, quads: 1.0, sharp: true },
    Attempt { work_edge: 0.85, quads: 1.03, sharp: true },
    Attempt { work_edge: 1.0, quads: 1.0, sharp: false },
    Attempt { work_edge: 0.85, quads: 0.97, sharp: false },
    Attempt { work_edge: 0.7, quads: 1.15, sharp: false },
];

/// Work meshes for quads of several sizes are finer by this factor, so that the smallest quads have triangles too.
const ADAPTIVE_WORK_EDGE: f64 = 0.6;

/// Makes quads of one connected surface.
///
/// # Errors     no attempt passed and there is no fallback; given data that do not fit; cancellation
pub fn remesh_part(request: &PartRequest, options: &RemeshOptions, progress: &Progress) -> Result<Part, RemeshError> {
    let mut seconds = Seconds::default();
    let mut warnings = Vec::new();
    let (area, diagonal) = (request.mesh.area(), request.mesh.diagonal());
    let edge = (area / request.quads as f64).sqrt();
    let found = seconds.time("features", || find_features(request.mesh, &request.features, edge));
    let named = FeatureRequest { sharp_angle: None, ..request.features.clone() };
    let named = seconds.time("features", || find_features(request.mesh, &named, edge));
    let any_sharp = found.graph.edge_count() > named.graph.edge_count();
    let mut solves = 0;
    let mut last = None;
    for (attempt, rung) in LADDER.iter().enumerate() {
        // With a given field the work mesh is always the input: only the count can be varied.
        if !rung.sharp && !any_sharp && (rung.work_edge, rung.quads) == (LADDER[0].work_edge, LADDER[0].quads) {
            continue;
        }
        let features = if rung.sharp { &found } else { &named };
        let reference = seconds.time("reference", || Reference::new(request.mesh, &features.graph));
        let quads = rung.quads * request.quads as f64;
        let made = solve(request, &features.graph, rung, quads, options, progress, &mut seconds);
        let checked = made.and_then(|solution| {
            solves += solution.map.solves;
            let quads = seconds.time("finish", || finish_quads(&solution, &reference, progress))?;
            progress.report("verify", 0.0);
            let verification = seconds.time("verify", || verify(&quads, &reference));
            match verification.passed() {
                true => Ok((quads, solution)),
                false => Err(no_result("verification", verification.complaint())),
            }
        });
        match checked {
            Ok((quads, solution)) => {
                warnings.extend(fold_warning(&solution));
                if any_sharp && !rung.sharp {
                    let count = found.graph.edge_count() - named.graph.edge_count();
                    let message = format!("no map that follows the {count} sharp edges was found; they were not kept");
                    warnings.push(Warning::new(WarningCode::SharpEdgesDropped, message));
                }
                let features = features.clone();
                let solution = Some(solution);
                let distances = seconds.time("distances", || distances(&quads, &reference, options))?;
                return Ok(Part {
                    quads,
                    area,
                    diagonal,
                    features,
                    solution,
                    attempt,
                    solves,
                    distances,
                    warnings,
                    seconds,
                });
            }
            Err(e @ (RemeshError::Cancelled(_) | RemeshError::Mismatch { .. })) => return Err(e),
            Err(e) => {
                warnings.push(Warning::new(WarningCode::Retried, format!("attempt {} failed: {e}", attempt + 1)));
                last = Some(e);
            }
        }
    }
    let features = found;
    let reference = Reference::new(request.mesh, &features.graph);
    let failure = last.unwrap_or_else(|| no_result("remesh", "no attempt was made"));
    match options.fallback {
        Fallback::Off => Err(failure),
        Fallback::Split => {
            let quads = seconds.time("split", || split(request, &features.graph, options, progress))?;
            let verification = seconds.time("verify", || verify(&quads, &reference));
            if !verification.passed() {
                return Err(no_result("split", format!("{}; before that, {failure}", verification.complaint())));
            }
            let message =
                format!("no map without folds was found ({failure}); triangles were split into quads instead");
            warnings.push(Warning::new(WarningCode::TrianglesSplit, message));
            let distances = seconds.time("distances", || distances(&quads, &reference, options))?;
            let attempt = LADDER.len();
            Ok(Part { quads, area, diagonal, features, solution: None, attempt, solves, distances, warnings, seconds })
        }
    }
}

/// Work mesh, field, map, extraction.
fn solve(
    request: &PartRequest,
    features: &FeatureGraph,
    rung: &Attempt,
    quads: f64,
    options: &RemeshOptions,
    progress: &Progress,
    seconds: &mut Seconds,
) -> Result<Solution, RemeshError> {
    let area = request.mesh.area();
    let edge = (area / quads).sqrt();
    let (work, field, energy) = match &request.field {
        Some(direction) => {
            progress.report("work mesh", 0.0);
            let (work, field) =
                seconds.time("work mesh", || work_mesh_with_field(request.mesh, features, direction, options))?;
            let energy = field.energy(&work.mesh, &quadloom_field::Transport::of(&work.mesh));
            (work, field, energy)
        }
        None => {
            let room = if request.sizes.is_uniform() { 1.0 } else { ADAPTIVE_WORK_EDGE };
            let work_edge = rung.work_edge * room * work_edge_length(area, edge);
            let work = seconds.time("work mesh", || work_mesh(request.mesh, features, work_edge, options, progress))?;
            let singularities = on_work_mesh(request, &work);
            progress.report("cross field", 0.0);
            let (field, report) = seconds.time("cross field", || cross_field(&work, edge, &singularities, progress))?;
            (work, field, report.energy)
        }
    };
    let size =
        seconds.time("sizing", || relative_sizes(&work, &field, request.mesh, edge, &request.sizes, progress))?;
    progress.report("integer-grid map", 0.0);
    let goal = count_goal(quads, options);
    let map = seconds
        .time("integer-grid map", || integer_grid_map(&work, &field, &size, goal, edge, options.method, progress))?;
    progress.report("extraction", 0.0);
    let extraction = seconds.time("extraction", || extract_quads(&work, &map.parametrization.map, progress))?;
    Ok(Solution { work, field, energy, map, extraction })
}

/// The prescribed vertices' nearest vertices on the work mesh.
fn on_work_mesh(request: &PartRequest, work: &WorkMesh) -> Vec<(VertexId, i32)> {
    let nearest = |p: DVec3| {
        let distance = |v: &VertexId| work.mesh.position(*v).distance_squared(p);
        work.mesh.vertices().min_by(|a, b| distance(a).total_cmp(&distance(b)))
    };
    request.singularities.iter().filter_map(|&(v, index)| Some((nearest(request.mesh.position(v))?, index))).collect()
}

/// Smoothing on the input.
fn finish_quads(solution: &Solution, reference: &Reference, progress: &Progress) -> Result<QuadMesh, RemeshError> {
    progress.report("finish", 0.0);
    match finish(&solution.extraction, reference, &FinishOptions::default(), progress) {
        Ok(finished) => Ok(finished.mesh),
        Err(FinishError::Cancelled(c)) => Err(c.into()),
        Err(other) => Err(no_result("finish", other)),
    }
}

fn distances(
    quads: &QuadMesh,
    reference: &Reference,
    options: &RemeshOptions,
) -> Result<Option<Distances>, RemeshError> {
    let measured = options.measure_distance.then(|| Distances::measure(quads, reference));
    measured.transpose().map_err(|e| no_result("report", e))
}

fn fold_warning(solution: &Solution) -> Option<Warning> {
    let folds = solution.map.parametrization.inverted.len();
    let message = format!("{folds} triangles of the map are inverted; the quads around them were closed up");
    (folds > 0).then(|| Warning::new(WarningCode::FoldsSurvived, message))
}

/// Triangles of an isotropic mesh, split into quads.
fn split(
    request: &PartRequest,
    features: &FeatureGraph,
    options: &RemeshOptions,
    progress: &Progress,
) -> Result<QuadMesh, RemeshError> {
    let triangles = (request.quads as f64 / QUADS_PER_TRIANGLE as f64).max(1.0);
    let equilateral = (request.mesh.area() / triangles * 4.0 / 3.0_f64.sqrt()).sqrt();
    let fitted = fit_count(count_goal(request.quads as f64, options), equilateral, |edge| {
        let work = work_mesh(request.mesh, features, edge, options, progress)?;
        let quads = (QUADS_PER_TRIANGLE * work.mesh.face_count()) as f64;
        Ok::<_, RemeshError>(Some(Tried { solution: work, quads, flaws: 0 }))
    })?;
    let work = fitted.ok_or_else(|| no_result("split", "there is no work mesh"))?.solution;
    split_triangles(&work.mesh).map_err(|e| no_result("split", e))
}
