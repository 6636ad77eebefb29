//! Tips of the surface that the quads cut off get a vertex each.
//!
//! In: a [`State`] on the surface. Out: the same with some vertices at the points of the surface that were farthest from
//! the quads, pinned there. Holds: no quad gets worse below the floor. Source: own.

use super::state::State;
use super::ties::{Move, Tie, project};
use crate::quality::split_at_centres;
use quadloom_mesh::closest::ClosestPoint;
use quadloom_mesh::{DVec3, FaceId, MeshError, VertexId, VertexMap};
use rayon::prelude::*;

/// Distance of a vertex of the surface from the quads, relative to the longest edge there, from which it is a tip.
///
/// Smaller: the sag of coarse quads on ordinary curvature, up to 0.5 with five around a circle both ways, is taken for tips and
/// quads get worse for nothing.
const TIP_REL: f64 = 0.5;

/// Way that a vertex goes at once, in mean quad edges; its neighbours follow before it goes on.
const STRIDE_REL: f64 = 0.6;

/// Scaled Jacobian down to which quads may get worse for a tip.
const TIP_FLOOR: f64 = 0.3;

/// Moves vertices towards tips; returns how many moved.
///
/// # Input      edge: mean edge length of the quads, file units
/// # Errors     positions that are no mesh
/// # Cost       a closest-point query per vertex of the surface, in parallel
pub(crate) fn reach_tips(state: &mut State, edge: f64) -> Result<usize, MeshError> {
    // 1. Vertices of the surface that are far from the quads, with the corner that is nearest to each.
    let quads = state.quads.with_positions(state.position.clone())?;
    let ours = split_at_centres(&quads)?;
    let tree = ClosestPoint::new(&ours);
    let surface = state.reference.mesh;
    let is_loose = |v: &VertexId| matches!(state.tie[*v], Tie::Surface { .. });
    let far = |p: DVec3| {
        let near = tree.query(p);
        // Four triangles per quad, in its order.
        let quad = FaceId::new(near.point.face.index() / 4);
        let corner = quads.face_vertices(quad).map(|v| quads.position(v));
        let longest = (0..4).map(|k| corner[k].distance(corner[(k + 1) % 4])).fold(edge, f64::max);
        if near.distance <= TIP_REL * longest {
            return None;
        }
        let corners = quads.face_vertices(quad).into_iter().filter(is_loose);
        let distance = |v: &VertexId| quads.position(*v).distance_squared(p);
        let v = corners.min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
        Some((v, near.distance, p))
    };
    let points: Vec<DVec3> = surface.vertices().map(|v| surface.position(v)).collect();
    let tips: Vec<(VertexId, f64, DVec3)> = points.into_par_iter().filter_map(far).collect();
    // 2. Each corner goes for the farthest one.
    let mut wanted: VertexMap<Option<(f64, DVec3)>> = VertexMap::filled(quads.vertex_count(), None);
    for (v, distance, p) in tips {
        if wanted[v].is_none_or(|(other, _)| distance > other) {
            wanted[v] = Some((distance, p));
        }
    }
    let stride = |(v, w): (VertexId, &Option<(f64, DVec3)>)| {
        let (_, tip) = (*w)?;
        let way = tip - state.position[v];
        let short = (STRIDE_REL * edge / way.length().max(f64::MIN_POSITIVE)).min(1.0);
        project(state.reference, state.position[v] + way * short, state.vertex_normal(v), None)
    };
    let moves: Vec<Option<Move>> = wanted.iter().map(stride).collect();
    // 3. Where quads allow it.
    state.advance(&moves, TIP_FLOOR);
    let mut moved = 0;
    for v in state.quads.vertices() {
        if moves[v.index()].is_some_and(|to| to.position == state.position[v]) {
            state.pinned[v] = true;
            moved += 1;
        }
    }
    Ok(moved)
}
