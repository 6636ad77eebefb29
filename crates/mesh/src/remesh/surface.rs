//! The input surface as the remesher asks it: regions between curves, normals, the nearest point by walking.
//!
//! In: the input mesh and which of its edges are curves. Out: feet of points, found from a nearby face.
//! Holds: a walk never crosses a curve, so that a point stays on its side of a crease and on its sheet of a
//! thin plate; it ends in a local minimum of the distance, which may not be the global one.
//! Source: descent over the faces around the side or corner on which the nearest point of a face lies.

use super::work::NONE;
use crate::closest::closest_weights;
use crate::ids::{EdgeMap, FaceId, HalfEdgeId};
use crate::mesh::TriMesh;
use glam::DVec3;

/// The nearest point found.
#[derive(Clone, Copy, Debug)]
pub(super) struct Foot {
    pub face: u32,
    pub weights: [f64; 3],
    pub point: DVec3,
    pub distance_sq: f64,
}

/// The input surface.
pub(super) struct Surface<'a> {
    pub mesh: &'a TriMesh,
    /// Region of each face: faces joined across edges that are no curves.
    pub patch: Vec<u32>,
    /// Unit normal of each face, averaged with its neighbours in the region where it is small.
    pub normal: Vec<DVec3>,
}

impl<'a> Surface<'a> {
    /// Prepares the surface; `scale` is the length below which faces are too small to have a normal of their own.
    pub fn new(mesh: &'a TriMesh, is_curve: &EdgeMap<bool>, scale: f64) -> Self {
        let patch = patches(mesh, is_curve);
        let normal = smooth_normals(mesh, &patch, scale);
        Self { mesh, patch, normal }
    }

    /// The point of face `f` nearest to `p`.
    pub fn foot_on_face(&self, p: DVec3, f: u32) -> Foot {
        let corner = self.mesh.face_vertices(FaceId(f)).map(|v| self.mesh.position(v));
        let weights = closest_weights(&corner, p);
        let point = corner[0] * weights[0] + corner[1] * weights[1] + corner[2] * weights[2];
        Foot { face: f, weights, point, distance_sq: point.distance_squared(p) }
    }

    /// Walks from face `start` downhill in distance to `p`, staying in the region of `start`.
    pub fn walk(&self, p: DVec3, start: u32) -> Foot {
        let mut best = self.foot_on_face(p, start);
        // The distance falls with every step, so that no face is visited twice.
        while let Some(foot) = self.step(p, &best) {
            best = foot;
        }
        best
    }

    /// Distance of `p` from the surface, found from a face near it.
    pub fn height(&self, p: DVec3, start: u32) -> f64 {
        self.walk(p, start).distance_sq.sqrt()
    }

    fn step(&self, p: DVec3, at: &Foot) -> Option<Foot> {
        let patch = self.patch[at.face as usize];
        let first = 3 * at.face;
        let zero = at.weights.map(|w| w <= 0.0);
        let mut best = None;
        let mut limit = at.distance_sq * (1.0 - 1e-12);
        let mut consider = |f: FaceId| {
            if f.0 != at.face && self.patch[f.index()] == patch {
                let foot = self.foot_on_face(p, f.0);
                if foot.distance_sq < limit {
                    limit = foot.distance_sq;
                    best = Some(foot);
                }
            }
        };
        match zero {
            [false, false, false] => {}
            // On one side: only the face across can be nearer.
            [true, false, false] | [false, true, false] | [false, false, true] => {
                let opposite = zero.iter().position(|&z| z).unwrap_or(0) as u32;
                let side = HalfEdgeId(first + (opposite + 1) % 3);
                if let Some(t) = self.mesh.twin(side) {
                    consider(self.mesh.face(t));
                }
            }
            // On a corner: all faces around it.
            _ => {
                let corner = zero.iter().position(|&z| !z).unwrap_or(0) as u32;
                let v = self.mesh.origin(HalfEdgeId(first + corner));
                self.mesh.outgoing(v).for_each(|h| consider(self.mesh.face(h)));
            }
        }
        best
    }

    /// The faces at the corners of a face that belong to its region, with repetitions.
    pub fn faces_around(&self, f: u32) -> impl Iterator<Item = u32> + '_ {
        let corners = self.mesh.face_vertices(FaceId(f));
        let faces = corners.into_iter().flat_map(|v| self.mesh.outgoing(v)).map(|h| self.mesh.face(h).0);
        faces.filter(move |&g| self.patch[g as usize] == self.patch[f as usize])
    }

    /// A face of region `patch` at an input vertex; any face there if the region does not touch it.
    pub fn face_at_vertex(&self, v: u32, patch: u32) -> u32 {
        let v = crate::ids::VertexId(v);
        let mut faces = self.mesh.outgoing(v).map(|h| self.mesh.face(h).0);
        let first = self.mesh.face(self.mesh.outgoing_half_edge(v)).0;
        faces.find(|&f| self.patch[f as usize] == patch).unwrap_or(first)
    }

    /// The face of region `patch` beside an input half-edge; its own face if neither side belongs to the region.
    pub fn face_at_half_edge(&self, h: u32, patch: u32) -> u32 {
        let h = HalfEdgeId(h);
        let own = self.mesh.face(h).0;
        match self.mesh.twin(h) {
            Some(t) if self.patch[own as usize] != patch && self.patch[self.mesh.face(t).index()] == patch => {
                self.mesh.face(t).0
            }
            _ => own,
        }
    }
}

/// Regions of faces joined across edges that are no curves, numbered by their smallest face.
fn patches(mesh: &TriMesh, is_curve: &EdgeMap<bool>) -> Vec<u32> {
    let mut patch = vec![NONE; mesh.face_count()];
    let mut count = 0;
    let mut stack = Vec::new();
    for seed in mesh.faces() {
        if patch[seed.index()] != NONE {
            continue;
        }
        patch[seed.index()] = count;
        stack.push(seed);
        while let Some(f) = stack.pop() {
            for h in mesh.face_half_edges(f) {
                let Some(t) = mesh.twin(h).filter(|_| !is_curve[mesh.edge(h)]) else { continue };
                let g = mesh.face(t);
                if patch[g.index()] == NONE {
                    patch[g.index()] = count;
                    stack.push(g);
                }
            }
        }
        count += 1;
    }
    patch
}

/// Area of the neighbourhood over which normals are averaged, in squares of the scale: a face that large counts
/// alone. A quarter is about half of an equilateral triangle of that side. Larger: fine noise no longer blocks
/// collapses, but facets of coarse input get normals that are not theirs.
const AVERAGED_AREA: f64 = 0.25;

fn smooth_normals(mesh: &TriMesh, patch: &[u32], scale: f64) -> Vec<DVec3> {
    let vector: Vec<DVec3> = mesh.faces().map(|f| mesh.vector_area(f)).collect();
    let enough = AVERAGED_AREA * scale * scale;
    let unit = |f: FaceId| {
        let own = vector[f.index()];
        let wanted = (enough - own.length()).max(0.0);
        let (mut sum, mut area) = (DVec3::ZERO, 0.0);
        for h in mesh.face_half_edges(f) {
            if let Some(g) = mesh.twin(h).map(|t| mesh.face(t)).filter(|g| patch[g.index()] == patch[f.index()]) {
                sum += vector[g.index()];
                area += vector[g.index()].length();
            }
        }
        let share = if area > 0.0 { (wanted / area).min(1.0) } else { 0.0 };
        (own + share * sum).normalize_or_zero()
    };
    mesh.faces().map(unit).collect()
}
