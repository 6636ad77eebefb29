//! Letting go of features where they alone keep a quad inverted.
//!
//! In: a [`State`] with inverted quads. Out: the same with vertices on the surface that were on corners or curves.
//! Holds: vertices of the surface's boundary stay on it; a single vertex is let go only where that cures its quads.
//! Source: own.

use super::state::State;
use super::ties::{Move, Tie, project};
use quadloom_mesh::{FaceId, VertexId};

/// Lets single vertices of inverted quads leave their corner or curve, at each quad the one that has to go least far.
///
/// # Output     number of vertices that did
/// # Cost       one pattern search per vertex of an inverted quad
pub(crate) fn release_single(state: &mut State) -> usize {
    let bad: Vec<FaceId> = state.quads.faces().filter(|&f| state.is_bad(f)).collect();
    let mut released = 0;
    for f in bad {
        // 1. Another vertex may have cured it.
        if !state.is_bad(f) {
            continue;
        }
        // 2. What each vertex could do, and how far it would go.
        let trials = state.quads.face_vertices(f).into_iter().filter_map(|v| trial(state, v)).collect::<Vec<_>>();
        // 3. The least of it.
        if let Some(least) = trials.into_iter().min_by(|a, b| a.distance.total_cmp(&b.distance)) {
            state.pinned[least.vertex] = false;
            state.release(least.vertex, least.to);
            state.measure_around(least.vertex);
            released += 1;
        }
    }
    released
}

/// A place of a vertex that left its corner or curve, where none of its quads is inverted.
struct Trial {
    vertex: VertexId,
    to: Move,
    /// From where it was, file units.
    distance: f64,
}

/// Distances that a vertex goes, relative to the mean length of its edges: the first one that cures.
const RADII_REL: [f64; 8] = [0.03, 0.06, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5];

/// Directions in the tangent plane.
const DIRECTIONS: usize = 16;

/// Worst quality around a vertex from which its quads count as cured.
const CURED: f64 = 0.02;

/// Where a vertex would go, `None` if its quads are not cured by it; the state stays as it is.
fn trial(state: &mut State, v: VertexId) -> Option<Trial> {
    if !may_leave(state, v) {
        return None;
    }
    let start = state.place(v);
    let to = nearest_cure(state, v, start);
    state.put(v, start);
    to.map(|to| Trial { vertex: v, to, distance: to.position.distance(start.position) })
}

/// The nearest place on the surface at which the quads of a vertex are cured; the best one of those as near.
fn nearest_cure(state: &mut State, v: VertexId, start: Move) -> Option<Move> {
    let faces: Vec<FaceId> = state.quads.outgoing(v).map(|h| state.quads.face(h)).collect();
    let normal = state.vertex_normal(v);
    let (x, y) = normal.try_normalize()?.any_orthonormal_pair();
    let edges: Vec<f64> = state.quads.neighbours(v).map(|w| state.position[w].distance(start.position)).collect();
    let size = edges.iter().sum::<f64>() / edges.len() as f64;
    RADII_REL.iter().find_map(|&r| {
        let (mut best, mut best_worst) = (None, CURED);
        for k in 0..DIRECTIONS {
            let (sin, cos) = (std::f64::consts::TAU * k as f64 / DIRECTIONS as f64).sin_cos();
            let there = project(state.reference, start.position + (x * cos + y * sin) * (r * size), normal, None);
            let Some(there) = there else { continue };
            state.put(v, there);
            let worst = state.worst_above(&faces, best_worst);
            if worst > best_worst {
                (best, best_worst) = (Some(there), worst);
            }
        }
        best
    })
}

/// Whether a vertex is held by more than the surface, and not by its boundary.
fn may_leave(state: &State, v: VertexId) -> bool {
    !state.may_move(v) && !state.quads.is_boundary_vertex(v)
}

/// Lets corners and curve vertices at inverted quads, and at `rings` rings of quads around them, leave their curves.
///
/// # Output     number of vertices that did
pub(crate) fn release_around(state: &mut State, rings: usize) -> usize {
    let mut around: Vec<FaceId> = state.quads.faces().filter(|&f| state.is_bad(f)).collect();
    for _ in 0..rings {
        around = state.faces_around(around.iter().flat_map(|&f| state.quads.face_vertices(f)));
    }
    let mut released = 0;
    for v in around.iter().flat_map(|&f| state.quads.face_vertices(f)) {
        if matches!(state.tie[v], Tie::Surface { .. }) || state.quads.is_boundary_vertex(v) {
            released += usize::from(std::mem::take(&mut state.pinned[v]));
            continue;
        }
        let normal = state.vertex_normal(v);
        if let Some(there) = project(state.reference, state.position[v], normal, None) {
            state.release(v, there);
            released += 1;
        }
    }
    released
}
