//! The arrows of the pipeline on one connected surface, one function each.
//!
//! In: a triangle mesh and its features. Out: [`WorkMesh`], then a cross field, an integer-grid map with a number of
//! quads, an extraction. Holds: chains keep their numbers from the input to the quads.
//! Source: [Bommes2012] §8.1 to §8.4.

use crate::count::{CountGoal, Fitted, Tried, fit_count};
use crate::error::RemeshError;
use crate::features::without_boundary;
use crate::options::{Elements, Method, RemeshOptions};
use quadloom_extract::Extraction;
use quadloom_field::{CrossField, FieldConstraints, FieldOptions, FieldReport, SizeField, Transport};
use quadloom_mesh::refine::separate_features;
use quadloom_mesh::remesh::{self, TargetLength, isotropic};
use quadloom_mesh::{DVec3, FaceMap, FeatureGraph, Progress, TriMesh, VertexId, metric};
use quadloom_param::{
    IntegerGridMap, ParamOptions, Parametrization, Parametrizer, RelocationError, RelocationOptions, RelocationReport,
    Tie, area_of, make_room, relocate, solve_open_field,
};

/// Edge length of the work mesh, relative to that of the quads.
///
/// Larger: fewer triangles, and singularities that have no room. Smaller: slower; the cost grows with the square.
pub const WORK_EDGE_REL: f64 = 0.55;

/// Most triangles that a work mesh is meant to have: beyond, its edges grow relative to the quads.
const WORK_TRIANGLES_MAX: f64 = 250_000.0;

/// Effort of a cross field with its local search, per face.
const FIELD_EFFORT: usize = 80;

/// Opposite singularities closer than this many quad edges are joined: nearer pairs collapse in the map.
const CANCEL_DISTANCE_REL: f64 = 2.0;

/// Rise of the field's energy at which they still are, radians squared: before the others have moved, after which most
/// of it is gone.
const NEAR_PAIR_COST: f64 = 3.0;

/// Solves of the map that reaching a count may cost.
const COUNT_SOLVES: usize = 4;

/// Solves for rounded maps that finding the size may cost, each a fraction of a map's.
const PREVIEWS: usize = 3;

/// The mesh on which field and map are solved.
#[derive(Clone, Debug)]
pub struct WorkMesh {
    /// Its triangles.
    pub mesh: TriMesh,
    /// All chains, those of the input with their numbers.
    pub features: FeatureGraph,
    /// The chains that field and map follow.
    pub binding: FeatureGraph,
}

/// A map with the number of quads in it.
#[derive(Clone, Debug)]
pub struct SizedMap {
    /// The map and how it came about.
    pub parametrization: Parametrization,
    /// Number of quads: the area of the map's image.
    pub quads: f64,
    /// Edge length that led to it, file units.
    pub edge_length: f64,
    /// Solves made.
    pub solves: usize,
}

/// Edge length of a work mesh for quads of the given length, file units.
pub fn work_edge_length(area: f64, quad_edge: f64) -> f64 {
    let equilateral = |triangles: f64| (area / triangles * 4.0 / 3.0_f64.sqrt()).sqrt();
    (WORK_EDGE_REL * quad_edge).max(equilateral(WORK_TRIANGLES_MAX))
}

/// Makes the work mesh: isotropic, with the input's topology and chains.
///
/// # Input      edge: its edge length, file units
/// # Errors     cancellation
pub fn work_mesh(
    mesh: &TriMesh,
    features: &FeatureGraph,
    edge: f64,
    options: &RemeshOptions,
    progress: &Progress,
) -> Result<WorkMesh, RemeshError> {
    let remeshed = isotropic(mesh, features, TargetLength::Uniform(edge), &remesh::RemeshOptions::default(), progress)?;
    // Between two curves that meet there is an edge that the field can turn over.
    let refined = separate_features(&remeshed.mesh, &remeshed.features).map_err(|e| no_result("work mesh", e))?;
    Ok(WorkMesh::new(refined.mesh, refined.features, options))
}

/// Makes a work mesh of the input's own triangles, with a given direction per face, and its field.
///
/// Triangles are only split where features are too close to each other, so that the field's singularities stay.
///
/// # Errors     a vector without a direction in its face
pub fn work_mesh_with_field(
    mesh: &TriMesh,
    features: &FeatureGraph,
    direction: &FaceMap<DVec3>,
    options: &RemeshOptions,
) -> Result<(WorkMesh, CrossField), RemeshError> {
    let refined = separate_features(mesh, features).map_err(|e| no_result("work mesh", e))?;
    let direction = FaceMap::from_fn(refined.mesh.face_count(), |f| direction[refined.parent_face[f]]);
    let field = CrossField::from_directions(&refined.mesh, &direction)
        .map_err(|e| RemeshError::Mismatch { what: "the cross field", why: e.to_string() })?;
    Ok((WorkMesh::new(refined.mesh, refined.features, options), field))
}

impl WorkMesh {
    fn new(mesh: TriMesh, features: FeatureGraph, options: &RemeshOptions) -> Self {
        let binding = if options.keep_boundary { features.clone() } else { without_boundary(&mesh, &features) };
        Self { mesh, features, binding }
    }
}

/// Singular vertices that are given.
#[derive(Clone, Copy, Debug, Default)]
pub struct Prescribed<'a> {
    /// Interior vertices of the work mesh with their index in quarters.
    pub at: &'a [(VertexId, i32)],
    /// Whether the field is to have no others where it can do without.
    pub only: bool,
}

/// Rise of the energy at which unwanted singular vertices still leave, radians squared: more than any field has.
const UNWANTED_COST: f64 = 1e6;

/// Solves for the cross field.
///
/// # Input      quad_edge: edge length of the quads, file units
/// # Errors     prescriptions that exclude each other, cancellation
pub fn cross_field(
    work: &WorkMesh,
    quad_edge: f64,
    singularities: Prescribed,
    progress: &Progress,
) -> Result<(CrossField, FieldReport), RemeshError> {
    let mesh = &work.mesh;
    let length = metric::edge_lengths(mesh);
    let transport = Transport::new(mesh, &length);
    let (mut constraints, _) = FieldConstraints::from_features(mesh, &transport, &length, &work.binding);
    constraints.indices = singularities.at.to_vec();
    let options = FieldOptions {
        cancel_distance: CANCEL_DISTANCE_REL * quad_edge,
        singularity_cost: if singularities.only { UNWANTED_COST } else { 0.0 },
        near_pair_cost: NEAR_PAIR_COST,
        ..FieldOptions::default()
    };
    progress.spend(FIELD_EFFORT * mesh.face_count());
    solve_open_field(mesh, &transport, &length, &work.binding, &constraints, &options, progress).map_err(|e| match e {
        quadloom_field::FieldError::Cancelled(c) => c.into(),
        quadloom_field::FieldError::NoInteriorVertex { .. } | quadloom_field::FieldError::Unsatisfiable { .. } => {
            RemeshError::Mismatch { what: "the list of singularities", why: e.to_string() }
        }
        other => no_result("cross field", other),
    })
}

/// The same field with room around its singular vertices and features.
///
/// # Errors     more elements than ids
pub fn with_room(
    work: WorkMesh,
    field: CrossField,
    options: &RemeshOptions,
) -> Result<(WorkMesh, CrossField), RemeshError> {
    let room = make_room(&work.mesh, &work.features, &work.binding, &field).map_err(|e| no_result("work mesh", e))?;
    Ok(match room {
        Some((refined, carried)) => (WorkMesh::new(refined.mesh, refined.features, options), carried),
        None => (work, field),
    })
}

/// Moves singular vertices of a field that was solved on the work mesh, where that lowers the map's energy.
///
/// # Input      singularities: as in [`Prescribed`]; size: in file units
/// # Errors     a field without a map, cancellation
pub fn relocated(
    work: &WorkMesh,
    field: &CrossField,
    singularities: &[(VertexId, i32)],
    size: &SizeField,
    progress: &Progress,
) -> Result<(CrossField, RelocationReport), RemeshError> {
    let mesh = &work.mesh;
    let length = metric::edge_lengths(mesh);
    let transport = Transport::new(mesh, &length);
    let (mut constraints, _) = FieldConstraints::from_features(mesh, &transport, &length, &work.binding);
    constraints.indices = singularities.to_vec();
    let options = RelocationOptions::default();
    relocate(mesh, &work.binding, &constraints, field, size, &options, progress).map_err(|e| match e {
        RelocationError::Map(e) => param_error(e),
        RelocationError::Field(e) => no_result("relocation", e),
    })
}

/// What maps are asked for besides sizes.
#[derive(Clone, Copy, Debug)]
pub struct MapRequest<'a> {
    /// How integers are found.
    pub method: Method,
    /// Singular vertices of the field that chains of quad edges are to join.
    pub ties: &'a [Tie],
    /// Effort of the run after which no further solve is begun.
    pub most_effort: u64,
}

impl Default for MapRequest<'_> {
    fn default() -> Self {
        Self { method: Method::default(), ties: &[], most_effort: u64::MAX }
    }
}

/// Solves for integer-grid maps until one has the wanted number of quads.
///
/// # Input      size: relative to the mean edge length; edge_length: the first mean edge length, file units
/// # Output     the best map: fold-free and near the count, else fold-free, else near the count
/// # Errors     the first solve failed, cancellation
pub fn integer_grid_map(
    work: &WorkMesh,
    field: &CrossField,
    size: &SizeField,
    goal: CountGoal,
    edge_length: f64,
    request: MapRequest,
    progress: &Progress,
) -> Result<SizedMap, RemeshError> {
    let mut solves = 0;
    let mut parametrizer =
        Parametrizer::with_ties(&work.mesh, &work.binding, field, request.ties).map_err(param_error)?;
    let method = match request.method {
        Method::Direct => quadloom_param::Method::Direct,
        Method::Greedy => quadloom_param::Method::Greedy,
    };
    let options = ParamOptions { method, ..ParamOptions::default() };
    let mut first_error = None;
    let mut begun = 0;
    let mut begin = || {
        progress.report("integer-grid map", begun as f64 / (PREVIEWS + COUNT_SOLVES) as f64);
        begun += 1;
    };
    // 1. A size whose rounded map has about the count: repairs cost more and change it little.
    let preview = CountGoal { tolerance: 0.5 * goal.tolerance, solves: PREVIEWS, ..goal };
    let rounded = fit_count(preview, edge_length, |edge| {
        begin();
        let rounded = parametrizer.rounded(&size.scaled(edge), &options, progress);
        made(rounded.map(|map| Tried { quads: map.area, solution: map, flaws: 0 }), &mut first_error)
    })?;
    let edge_length = rounded.as_ref().map_or(edge_length, |r| r.size);
    let previews = rounded.as_ref().map_or(0, |r| r.solves);
    let mut first = rounded.map(|r| r.solution);
    // 2. Maps without folds, with small corrections.
    let fitted = fit_count(goal, edge_length, |edge| {
        begin();
        solves += 1;
        if solves > 1 && progress.spent() > request.most_effort {
            return Ok(None);
        }
        let rounded = match first.take() {
            Some(rounded) => Ok(rounded),
            None => parametrizer.rounded(&size.scaled(edge), &options, progress),
        };
        let map = rounded.and_then(|rounded| parametrizer.repaired(rounded, &options, progress));
        let tried = |map: Parametrization| {
            let (quads, flaws) = (area_of(&work.mesh, &map.map), map.inverted.len());
            Tried { solution: map, quads, flaws }
        };
        made(map.map(tried), &mut first_error)
    })?;
    match (fitted, first_error) {
        (Some(Fitted { solution, quads, size, solves }), _) => {
            let solves = solves + previews.saturating_sub(1);
            Ok(SizedMap { parametrization: solution, quads, edge_length: size, solves })
        }
        (None, Some(e)) => Err(e),
        (None, None) => Err(no_result("integer-grid map", "no solve was made")),
    }
}

/// What a solve made; an error other than cancellation only ends the corrections, and the first one is kept.
fn made<T>(
    result: Result<Tried<T>, quadloom_param::ParamError>,
    first_error: &mut Option<RemeshError>,
) -> Result<Option<Tried<T>>, RemeshError> {
    match result.map_err(param_error) {
        Ok(tried) => Ok(Some(tried)),
        Err(e @ RemeshError::Cancelled(_)) => Err(e),
        Err(e) => {
            first_error.get_or_insert(e);
            Ok(None)
        }
    }
}

/// How a count is to be reached under the options.
pub fn count_goal(quads: f64, options: &RemeshOptions) -> CountGoal {
    // Some of what is accepted is left to what extraction and components may add.
    CountGoal { quads, tolerance: 0.7 * options.tolerance, solves: COUNT_SOLVES }
}

/// Extracts the quads of a map.
///
/// # Errors     maps that do not close to quads, cancellation
pub fn extract_quads(work: &WorkMesh, map: &IntegerGridMap, progress: &Progress) -> Result<Extraction, RemeshError> {
    use quadloom_extract::ExtractError;
    quadloom_extract::extract(&work.mesh, map, &work.binding, progress).map_err(|e| match e {
        ExtractError::Cancelled(c) => c.into(),
        other => no_result("extraction", other),
    })
}

fn param_error(error: quadloom_param::ParamError) -> RemeshError {
    match error {
        quadloom_param::ParamError::Cancelled(c) => c.into(),
        other => no_result("integer-grid map", other),
    }
}

/// A stage that gave up.
pub(crate) fn no_result(stage: &'static str, why: impl std::fmt::Display) -> RemeshError {
    RemeshError::NoResult { stage, why: why.to_string(), elements: Elements::None }
}
