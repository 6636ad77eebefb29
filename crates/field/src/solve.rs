//! Cross field solve: constraints in, the smoothest field with few singularities out.
//!
//! In: connectivity, edge lengths, constraints. Out: a cross field and a report.
//! Holds: hard directions exactly (up to quarter turns); prescribed indices and index sums exactly; angles minimise
//! Eq. (8.1) for the period jumps found. Not: the global optimum over the period jumps.
//! Source: [Bommes2012] §8.2, §8.6.
//!
//! 1. Roots: constrained faces, and one face per component without any.
//! 2. Start: period jumps by mixed-integer rounding or from the globally optimal field.
//! 3. Prescribed indices, where the start does not have them.
//! 4. Local search over the singularities.
//! 5. Components without any direction turn to the preferred directions.

use crate::constraints::{FieldConstraints, SoftDirection};
use crate::cross_field::{CrossField, nearest_jump};
use crate::error::FieldError;
use crate::mixed_integer::mixed_integer_jumps;
use crate::search::{Search, index_groups};
use crate::smoothest::{COARSEST, smoothest_angles};
use crate::system::{Roots, SmoothnessSystem};
use crate::transport::Transport;
use quadloom_mesh::topology::components;
use quadloom_mesh::{DVec2, EdgeId, EdgeMap, FaceId, FaceMap, Progress, TriConnectivity, VertexId, VertexMap};
use quadloom_numeric::{Rounding, SolveReport};
use std::f64::consts::FRAC_PI_2;
use std::time::Instant;

/// How the first period jumps are found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FieldStart {
    /// From the globally optimal direction field ([Knoppel2013]), solved on a coarsened mesh and smoothed. Prescribed
    /// indices are reached from there, or by greedy rounding if they are many or overlap.
    Smoothest,
    /// As `Smoothest`, solved on the whole mesh: slower, the same after the local search in general.
    SmoothestExactly,
    /// By the mixed-integer solver ([Bommes2012] §8.2).
    Rounded(Rounding),
}

/// How a cross field is solved.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldOptions {
    /// How the first period jumps are found.
    pub start: FieldStart,
    /// Whether singularities are moved and joined afterwards ([Bommes2012] §8.2, local search).
    pub local_search: bool,
    /// Rise of the energy (8.1) that one quarter of index less is worth, radians². Larger: fewer singularities, more
    /// distortion.
    pub singularity_cost: f64,
    /// Opposite singularities closer than this are joined if that is not too dear, file units. About 1.5 quad edges:
    /// nearer pairs collapse in the integer-grid map. Default 0: none.
    pub cancel_distance: f64,
    /// Rise of the energy at which a near pair is still joined, radians².
    pub near_pair_cost: f64,
    /// Opposite singularities farther apart are not considered as a pair, file units. Default: unlimited.
    pub reach: f64,
    /// Vertices of curves that singularities should not be next to, as a map has no room for them there; on the curve
    /// they may be. Those that the search leaves beside a curve are moved one ring further. Default: none.
    pub clear_of: Vec<VertexId>,
    /// Energy per quarter of index next to a curve, radians², on top of `singularity_cost`.
    pub crowding_cost: f64,
    /// Period jumps to start from, in place of `start`. Default: none.
    pub start_from: Option<EdgeMap<i32>>,
    /// Edges whose period jump stays what it is at the start. Default: none.
    pub kept: Vec<EdgeId>,
}

impl Default for FieldOptions {
    fn default() -> Self {
        Self {
            start: FieldStart::Smoothest,
            local_search: true,
            singularity_cost: 0.0,
            cancel_distance: 0.0,
            near_pair_cost: 1.0,
            reach: f64::INFINITY,
            clear_of: Vec::new(),
            crowding_cost: 0.5,
            start_from: None,
            kept: Vec::new(),
        }
    }
}

/// What a solve did.
#[derive(Clone, Debug, Default)]
pub struct FieldReport {
    /// Faces whose angle was free.
    pub free_faces: usize,
    /// Faces fixed because their component has no constraint.
    pub anchors: Vec<FaceId>,
    /// Report of the mixed-integer solver, if it made the start.
    pub rounding: Option<SolveReport>,
    /// Energy (8.1) of the start, radians².
    pub start_energy: f64,
    /// Singularities of the start.
    pub start_singularities: usize,
    /// Energy (8.1) of the result, radians².
    pub energy: f64,
    /// Singularities of the result.
    pub singularities: usize,
    /// Moves of singularities along edges.
    pub moves: usize,
    /// Pairs of singularities that were joined.
    pub cancelled_pairs: usize,
    /// Quarter turns around handles and tubes.
    pub twists: usize,
    /// Seconds for the start, and for the search.
    pub seconds: [f64; 2],
}

/// Prescriptions up to which indices are carried to their places one by one; more of them leave no room for that.
const MOST_ENFORCED: usize = 64;

/// Solves for a smooth cross field under constraints.
///
/// # Input      length: of every edge, file units; constraints: angles in radians, indices in quarters
/// # Output     the field and what happened
/// # Errors     sizes that do not fit, prescriptions without a field, cancellation
/// # Cost       two sparse factorisations and a few dozen solves: near-linear
/// # Guarantees see the module
/// # Source     [Bommes2012] §8.2, Eqs. (8.1) to (8.3)
pub fn solve_cross_field(
    mesh: &TriConnectivity,
    transport: &Transport,
    length: &EdgeMap<f64>,
    constraints: &FieldConstraints,
    options: &FieldOptions,
    progress: &Progress,
) -> Result<(CrossField, FieldReport), FieldError> {
    constraints.validate(mesh)?;
    progress.check()?;
    let clock = Instant::now();
    let mut report = FieldReport::default();
    // 1. Roots.
    let mut roots = Roots::new(mesh, constraints);
    report.anchors = roots.anchors.clone();
    // 2. Start.
    let (period_jump, rounded) = match &options.start_from {
        Some(jumps) => (jumps.clone(), None),
        None => start_jumps(mesh, transport, length, &mut roots, constraints, options.start, progress)?,
    };
    report.rounding = rounded;
    let system = SmoothnessSystem::new(mesh, transport, roots.clone())?;
    report.free_faces = system.free_faces();
    let begin = |jumps| {
        let groups = index_groups(mesh, constraints.index_sums());
        Search::new(mesh, transport, length, &system, groups, jumps, options)
    };
    let mut search = begin(period_jump);
    // 3. Prescriptions, which the smoothest start does not know.
    let sums: Vec<(&[VertexId], i32)> = constraints.index_sums().collect();
    let disjoint = sums.len() <= MOST_ENFORCED && are_disjoint(mesh, &sums);
    if !disjoint || !search.enforce(&sums, progress)? {
        let rounded = mixed_integer_jumps(mesh, transport, length, &roots, constraints, Rounding::Greedy, progress)?;
        report.rounding = Some(rounded.1);
        search = begin(rounded.0);
    }
    report.start_energy = search.field().energy(mesh, transport);
    report.start_singularities = search.field().singularities(mesh, transport).len();
    report.seconds[0] = clock.elapsed().as_secs_f64();
    // 4. Local search.
    let clock = Instant::now();
    if options.local_search {
        search.run(progress)?;
        search.move_clear();
    }
    report.moves = search.counts.moves;
    report.twists = search.counts.twists;
    report.cancelled_pairs = search.counts.cancelled_pairs;
    let mut field = search.into_field();
    // 5. A component without directions is free to turn as a whole.
    turn_free_components(mesh, &report.anchors, constraints, &mut field);
    report.energy = field.energy(mesh, transport);
    report.singularities = field.singularities(mesh, transport).len();
    report.seconds[1] = clock.elapsed().as_secs_f64();
    Ok((field, report))
}

/// Period jumps to start from; turns soft directions to the branch that the start chose.
fn start_jumps(
    mesh: &TriConnectivity,
    transport: &Transport,
    length: &EdgeMap<f64>,
    roots: &mut Roots,
    constraints: &FieldConstraints,
    start: FieldStart,
    progress: &Progress,
) -> Result<(EdgeMap<i32>, Option<SolveReport>), FieldError> {
    let coarsest = match start {
        FieldStart::Rounded(rounding) => {
            let (jumps, rounded) =
                mixed_integer_jumps(mesh, transport, length, roots, constraints, rounding, progress)?;
            return Ok((jumps, Some(rounded)));
        }
        FieldStart::Smoothest => COARSEST,
        FieldStart::SmoothestExactly => usize::MAX,
    };
    let angle = smoothest_angles(mesh, transport, roots, coarsest, progress)?;
    turn_soft_directions(roots, &angle);
    Ok((EdgeMap::from_fn(mesh.edge_count(), |e| nearest_jump(mesh, transport, &angle, e)), None))
}

/// Whether no vertex is prescribed twice.
fn are_disjoint(mesh: &TriConnectivity, sums: &[(&[VertexId], i32)]) -> bool {
    let mut seen = VertexMap::filled(mesh.vertex_count(), false);
    sums.iter().flat_map(|(list, _)| list.iter()).all(|&v| !std::mem::replace(&mut seen[v], true))
}

/// Adds to all angles of each anchored component the one that brings its crosses nearest to the preferred directions:
/// the argument of Σ w·e^{4i(α - θ)}, a quarter of it. Neither energy nor indices change.
fn turn_free_components(
    mesh: &TriConnectivity,
    anchors: &[FaceId],
    constraints: &FieldConstraints,
    field: &mut CrossField,
) {
    if anchors.is_empty() || constraints.preferred.values().iter().all(Option::is_none) {
        return;
    }
    let parts = components(mesh);
    let mut sum = vec![DVec2::ZERO; parts.count];
    for (f, preferred) in constraints.preferred.iter() {
        if let Some(p) = preferred {
            sum[parts.of_face[f] as usize] += p.weight * DVec2::from_angle(4.0 * (p.angle - field.angle[f]));
        }
    }
    let mut turn = vec![0.0; parts.count];
    for &f in anchors {
        let part = parts.of_face[f] as usize;
        turn[part] = 0.25 * sum[part].y.atan2(sum[part].x);
    }
    for f in mesh.faces() {
        field.angle[f] += turn[parts.of_face[f] as usize];
    }
}

/// Takes of each soft direction's four branches the one nearest to the field.
pub(crate) fn turn_soft_directions(roots: &mut Roots, angle: &FaceMap<f64>) {
    for f in angle.ids() {
        if let Some(soft) = roots.soft[f] {
            let turns = ((angle[f] - soft.angle) / FRAC_PI_2).round();
            roots.soft[f] = Some(SoftDirection { angle: soft.angle + FRAC_PI_2 * turns, ..soft });
        }
    }
}
