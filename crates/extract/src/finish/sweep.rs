//! Sweeps that make quads rectangular.
//!
//! In: a [`State`]. Out: proposals for every vertex from the rectangles nearest to its quads.
//! Holds: all vertices move at once, so that the result does not depend on their order or on threads.
//! Source: projective dynamics of shapes as in [Bouaziz2012], one Jacobi step a sweep.

use super::shape::nearest_rectangle;
use super::state::{QUALITY_FLOOR, State};
use super::ties::Move;
use quadloom_mesh::{DVec3, FaceId, VertexId};
use rayon::prelude::*;

/// What a sweep draws vertices towards.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Aim {
    /// How much of its rectangle's stretch a quad keeps: 0 draws it to a square, 1 leaves its aspect alone.
    pub stretch_kept: f64,
    /// Part of the mean of the neighbours in the proposal, 0..=1.
    pub laplacian: f64,
    /// Shorter steps are not made, file units.
    pub shortest_step: f64,
}

/// One sweep; returns the largest distance moved, file units.
pub(crate) fn sweep(state: &mut State, aim: Aim) -> f64 {
    // 1. The vertex normals, which orient the quads.
    let normals: Vec<DVec3> =
        (0..state.quads.vertex_count()).into_par_iter().map(|v| state.vertex_normal(VertexId::new(v))).collect();
    // 2. The rectangle of each quad.
    let rectangles: Vec<Option<[DVec3; 4]>> = (0..state.quads.face_count())
        .into_par_iter()
        .map(|f| {
            let f = FaceId::new(f);
            let around: DVec3 = state.quads.face_vertices(f).iter().map(|v| normals[v.index()]).sum();
            let corner = state.corners(f);
            let own = (corner[2] - corner[0]).cross(corner[3] - corner[1]);
            let normal = if own.dot(around) > 0.0 { own } else { around };
            nearest_rectangle(corner, normal.normalize_or_zero(), aim.stretch_kept)
        })
        .collect();
    // 3. Every vertex towards the mean of its corners.
    let moves: Vec<Option<Move>> = (0..state.quads.vertex_count())
        .into_par_iter()
        .map(|v| {
            let v = VertexId::new(v);
            let target = proposal(state, &rectangles, aim.laplacian, v);
            let step = target - state.position[v];
            let short = step.length_squared() < aim.shortest_step * aim.shortest_step;
            if short { None } else { state.displaced(v, step, normals[v.index()]) }
        })
        .collect();
    // 4. Together, as far as no quad suffers.
    state.advance(&moves, QUALITY_FLOOR)
}

fn proposal(state: &State, rectangles: &[Option<[DVec3; 4]>], laplacian: f64, v: VertexId) -> DVec3 {
    let quads = state.quads;
    let (mut sum, mut weight) = (DVec3::ZERO, 0.0);
    for h in quads.outgoing(v) {
        let f = quads.face(h);
        if let Some(corner) = rectangles[f.index()] {
            sum += corner[(h.0 - quads.first_half_edge(f).0) as usize];
            weight += 1.0;
        }
    }
    let mean = if weight > 0.0 { sum / weight } else { state.position[v] };
    let laplacian = if weight > 0.0 { laplacian } else { 1.0 };
    if laplacian <= 0.0 {
        return mean;
    }
    let (mut sum, mut count) = (DVec3::ZERO, 0.0);
    for w in quads.neighbours(v) {
        sum += state.position[w];
        count += 1.0;
    }
    mean.lerp(sum / count, laplacian)
}
