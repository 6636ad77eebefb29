//! Improving the worst quads one vertex at a time.
//!
//! In: a [`State`]. Out: the same with its poor quads better. Holds: the worst quad at a moved vertex only improves.
//! Source: pattern search on the local maximin, the classical alternative to [Freitag1997]'s linear programs.

use super::state::State;
use super::ties::{Move, Tie};
use quadloom_mesh::{Cancelled, DVec3, FaceId, FaceMap, Progress, VertexId, VertexMap};

/// Radii of the pattern, relative to the mean length of the edges at the vertex.
const RADII_REL: [f64; 4] = [0.5, 0.2, 0.08, 0.03];

/// Directions of the pattern.
const DIRECTIONS: usize = 8;

/// Gain below which a move is not worth making.
const LEAST_GAIN: f64 = 1e-6;

/// Where vertices of the surface may go.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Reach {
    /// They stay on it.
    OnSurface,
    /// Beside it too, where it is too rough for quads.
    Beside,
}

/// Improves the quads below `threshold`, in at most `rounds` rounds.
///
/// # Output     number of moves
/// # Errors     cancellation
pub(crate) fn improve_worst(
    state: &mut State,
    threshold: f64,
    rounds: usize,
    progress: &Progress,
) -> Result<usize, Cancelled> {
    improve_within(state, threshold, rounds, Reach::OnSurface, progress)
}

/// Improves those of some quads that are below `threshold`, once, in the order of their vertices.
///
/// # Output     number of moves
pub(crate) fn improve_some(state: &mut State, quads: &[FaceId], threshold: f64, progress: &Progress) -> usize {
    let poor = quads.iter().filter(|f| state.quality[f.index()] < threshold);
    let mut vertices: Vec<VertexId> = poor.flat_map(|&f| state.quads.face_vertices(f)).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let mut moves = 0;
    for v in vertices {
        let faces: Vec<FaceId> = state.quads.outgoing(v).map(|h| state.quads.face(h)).collect();
        progress.spend(POOR_EFFORT * faces.len());
        moves += usize::from(improve(state, v, &faces, Reach::OnSurface));
    }
    moves
}

/// Improves the quads below `threshold` by vertices that leave the surface.
///
/// # Output     number of moves
/// # Errors     cancellation
pub(crate) fn improve_beside(
    state: &mut State,
    threshold: f64,
    rounds: usize,
    progress: &Progress,
) -> Result<usize, Cancelled> {
    let mut moves = 0;
    for _ in 0..LIFTS {
        moves += improve_within(state, threshold, rounds, Reach::Beside, progress)?;
        let bad: Vec<FaceId> = state.quads.faces().filter(|&f| state.is_bad(f)).collect();
        for &f in &bad {
            progress.check()?;
            moves += usize::from(lift(state, f));
        }
        if bad.is_empty() {
            break;
        }
    }
    Ok(moves)
}

/// Heights to which a whole quad is lifted, relative to the square root of its area: above folds that are smaller than
/// it.
const HEIGHTS_REL: [f64; 10] = [0.05, -0.05, 0.1, -0.1, 0.2, -0.2, 0.35, -0.35, 0.5, -0.5];

/// Rounds of lifting, single vertices and whole quads by turns.
const LIFTS: usize = 3;

/// Lifts those corners of a quad that may leave the surface, all to the same height; takes it back where the worst quad
/// around does not get better.
fn lift(state: &mut State, f: FaceId) -> bool {
    let corners: Vec<VertexId> = state.quads.face_vertices(f).into_iter().filter(|&v| state.may_move(v)).collect();
    let mut faces: Vec<FaceId> =
        corners.iter().flat_map(|&v| state.quads.outgoing(v).map(|h| state.quads.face(h))).collect();
    faces.sort_unstable();
    faces.dedup();
    let [a, b, c, d] = state.corners(f);
    let normal = (c - a).cross(d - b);
    let unit = normal.normalize_or_zero() * (0.5 * normal.length()).sqrt();
    let start: Vec<Move> = corners.iter().map(|&v| state.place(v)).collect();
    let before = state.worst_above(&faces, f64::NEG_INFINITY);
    for height in HEIGHTS_REL {
        for (&v, from) in corners.iter().zip(&start) {
            state.put(v, Move { position: from.position + unit * height, tie: from.tie.off_surface() });
        }
        if state.worst_above(&faces, before + LEAST_GAIN) > before + LEAST_GAIN {
            for &f in &faces {
                state.quality[f.index()] = state.measure(f);
            }
            return true;
        }
    }
    corners.iter().zip(start).for_each(|(&v, from)| state.put(v, from));
    false
}

fn improve_within(
    state: &mut State,
    threshold: f64,
    rounds: usize,
    reach: Reach,
    progress: &Progress,
) -> Result<usize, Cancelled> {
    let mut moves = 0;
    // A vertex is tried again once a quad at it has changed: the move that changed each quad last, from 1, and the
    // number of moves when each vertex was tried.
    let mut changed = FaceMap::filled(state.quads.face_count(), 1);
    let mut tried = VertexMap::filled(state.quads.vertex_count(), 0);
    for _ in 0..rounds {
        progress.check()?;
        let before = moves;
        let poor = state.quads.faces().filter(|f| state.quality[f.index()] < threshold);
        let mut vertices: Vec<VertexId> = poor.flat_map(|f| state.quads.face_vertices(f)).collect();
        vertices.sort_unstable();
        vertices.dedup();
        for v in vertices {
            let faces: Vec<FaceId> = state.quads.outgoing(v).map(|h| state.quads.face(h)).collect();
            if faces.iter().all(|&f| changed[f] <= tried[v]) {
                continue;
            }
            tried[v] = moves + 1;
            let bad = faces.iter().any(|&f| state.quality[f.index()] <= 0.0);
            progress.spend(if bad { BAD_EFFORT } else { POOR_EFFORT } * faces.len());
            if improve(state, v, &faces, reach) {
                moves += 1;
                faces.iter().for_each(|&f| changed[f] = moves + 1);
            }
        }
        if moves == before {
            break;
        }
    }
    Ok(moves)
}

/// Effort of trying a vertex, per quad at it, where one is inverted or faces against the surface: every place is measured.
const BAD_EFFORT: usize = 150;

/// The same where none is: most places are ruled out without a query.
const POOR_EFFORT: usize = 20;

/// Moves a vertex to the best place of the pattern around it, if one is better.
fn improve(state: &mut State, v: VertexId, faces: &[FaceId], reach: Reach) -> bool {
    let start = state.place(v);
    if start.tie == Tie::Fixed {
        return false;
    }
    let (mut best, mut best_worst) = (start, state.worst_above(faces, f64::NEG_INFINITY));
    let normal = state.vertex_normal(v);
    let lifted = reach == Reach::Beside && matches!(start.tie, Tie::Surface { .. });
    let mut displacements = pattern(state, v, normal);
    if lifted {
        let size = displacements.iter().map(|d| d.length()).fold(0.0, f64::max);
        let up = normal.normalize_or_zero() * size;
        displacements.extend(RADII_REL.iter().flat_map(|&r| [up * r, up * -r]));
    }
    for displacement in displacements {
        if !promising(state, v, displacement, faces, best_worst) {
            continue;
        }
        let beside = Move { position: start.position + displacement, tie: start.tie.off_surface() };
        let there = if lifted { Some(beside) } else { state.displaced(v, displacement, normal) };
        let Some(there) = there.filter(|there| state.is_near_home(v, there.position)) else { continue };
        state.put(v, there);
        let found = state.worst_above(faces, best_worst + LEAST_GAIN);
        if found > best_worst + LEAST_GAIN {
            (best, best_worst) = (there, found);
        }
        state.put(v, start);
    }
    let moved = best.position != start.position;
    if moved {
        state.put(v, best);
        for &f in faces {
            state.quality[f.index()] = state.measure(f);
        }
    }
    moved
}

/// What projecting a displaced vertex may add to the worst scaled Jacobian around it, by and large.
const PROJECTION_GAIN: f64 = 0.1;

/// Whether a displacement may improve the worst quad: for vertices on the surface judged before projecting, which costs
/// a query.
fn promising(state: &mut State, v: VertexId, displacement: DVec3, faces: &[FaceId], best_worst: f64) -> bool {
    let start = state.place(v);
    if best_worst < 0.0 || !matches!(start.tie, Tie::Surface { .. }) {
        return true;
    }
    state.put(v, Move { position: start.position + displacement, ..start });
    let worst = state.worst_jacobian(faces);
    state.put(v, start);
    worst > best_worst - PROJECTION_GAIN
}

/// Displacements to try: to the mean of the neighbours, and on circles in the tangent plane.
fn pattern(state: &State, v: VertexId, normal: DVec3) -> Vec<DVec3> {
    let Move { position: p, tie } = state.place(v);
    let around: Vec<DVec3> = state.quads.neighbours(v).map(|w| state.position[w] - p).collect();
    let count = around.len() as f64;
    let size = around.iter().map(|d| d.length()).sum::<f64>() / count;
    let mut list = vec![around.iter().sum::<DVec3>() / count];
    let x = match tie {
        // On a curve only the direction along it counts.
        Tie::Curve { chain, arc } => {
            let curves = &state.reference.curves;
            let (a, b) = (curves.at(chain, arc - 0.1 * size), curves.at(chain, arc + 0.1 * size));
            let t = (b.position - a.position).normalize_or_zero();
            return RADII_REL.iter().flat_map(|r| [t * (r * size), t * (-r * size)]).collect();
        }
        _ => normal.try_normalize().map_or(DVec3::X, |n| n.any_orthonormal_vector()),
    };
    let y = normal.normalize_or_zero().cross(x);
    for r in RADII_REL {
        for k in 0..DIRECTIONS {
            let angle = std::f64::consts::TAU * k as f64 / DIRECTIONS as f64;
            list.push((x * angle.cos() + y * angle.sin()) * (r * size));
        }
    }
    list
}
