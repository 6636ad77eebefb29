//! What a result must be before it is called one.
//!
//! In: quads and the surface they stand for. Out: [`Verification`]. Holds: made from the definitions, not from what
//! the stages say of themselves. That quads are four different vertices, manifold and oriented is what
//! [`QuadMesh`]'s constructor has checked.

use crate::features::{FeatureRequest, find_features};
use quadloom_extract::{Facing, Reference, scaled_jacobian, split_at_centres};
use quadloom_mesh::{ClosestPoint, DVec3, FaceId, QuadMesh, Summary, TriMesh, VertexId};
use rayon::prelude::*;

/// What was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Verification {
    /// Topology of the surface.
    pub expected: Summary,
    /// Topology of the quads.
    pub found: Summary,
    /// Quads whose scaled Jacobian is not clearly positive, ascending.
    pub inverted: Vec<FaceId>,
    /// Quads that face against the surface they cover ([`Reference::faces_against`]), ascending.
    pub against: Vec<FaceId>,
    /// Quads of which that is so at the centre but not all around it, ascending; they do not keep the quads from passing,
    /// as the face nearest to the centre may not be one that the quad stands for: on a rough surface or beside a thin
    /// sheet.
    pub unclear: Vec<FaceId>,
}

impl Verification {
    /// Whether the quads are a result.
    pub fn passed(&self) -> bool {
        self.expected.same_topology(&self.found) && self.inverted.is_empty() && self.against.is_empty()
    }

    /// Quads that keep the others from passing; those with two faults come twice.
    pub fn failed(&self) -> impl Iterator<Item = FaceId> + '_ {
        self.inverted.iter().chain(&self.against).copied()
    }

    /// What is wrong, in a sentence; empty if nothing is.
    pub fn complaint(&self) -> String {
        if !self.expected.same_topology(&self.found) {
            let shape = |s: &Summary| {
                format!(
                    "Euler characteristic {}, {} components, {} boundary loops",
                    s.chi, s.components, s.boundary_loops
                )
            };
            return format!("the quads have {}, the input has {}", shape(&self.found), shape(&self.expected));
        }
        let list = |quads: &[FaceId], what: &str| match quads {
            [] => String::new(),
            [first, ..] => format!("{} quads {what} (first: {first})", quads.len()),
        };
        let both = [list(&self.inverted, "are inverted or degenerate"), list(&self.against, "face against the input")];
        both.iter().filter(|s| !s.is_empty()).cloned().collect::<Vec<_>>().join(", ")
    }
}

/// Scaled Jacobian below which a quad counts as inverted.
///
/// Not zero: coordinates are read back and measured by others with other rounding, and a quad of 1e-13 is useless.
const LEAST_JACOBIAN: f64 = 1e-4;

/// Compares quads with the surface they stand for.
///
/// # Cost       five closest-point queries per quad
pub fn verify(quads: &QuadMesh, reference: &Reference) -> Verification {
    let corners = |f: FaceId| quads.face_vertices(f).map(|v| quads.position(v));
    let all: Vec<FaceId> = quads.faces().collect();
    let nearest = |f: FaceId| reference.closest.query(corners(f).iter().sum::<DVec3>() / 4.0).point.face;
    let facing: Vec<(FaceId, Facing)> =
        all.into_par_iter().map(|f| (f, reference.facing(corners(f), nearest(f)))).collect();
    let those =
        |wanted: fn(Facing) -> bool| -> Vec<FaceId> { facing.iter().filter(|q| wanted(q.1)).map(|q| q.0).collect() };
    Verification {
        expected: Summary::of(reference.mesh),
        found: Summary::of(quads),
        inverted: quads.faces().filter(|&f| scaled_jacobian(corners(f)) < LEAST_JACOBIAN).collect(),
        against: those(|facing| matches!(facing, Facing::Against(_))),
        unclear: those(|facing| matches!(facing, Facing::Wrinkled | Facing::Unclear)),
    }
}

/// Distance from the quads, relative to the longest edge there, from which a part of the surface counts as lost.
///
/// Tips of 500 quads on the models measured stick out by up to 1; sheets and rods that a folded map left out by 4.
const LOST_REL: f64 = 2.0;

/// The vertex of the surface that is farthest from the quads for their size there, if that is too far.
///
/// # Output     the vertex, its distance in file units, and that relative to the longest edge of the nearest quad
/// # Cost       a closest-point query per vertex of the surface
pub fn lost_part(quads: &QuadMesh, surface: &TriMesh) -> Option<(VertexId, f64, f64)> {
    let ours = split_at_centres(quads).ok()?;
    let tree = ClosestPoint::new(&ours);
    let all: Vec<VertexId> = surface.vertices().collect();
    let measured = all.into_par_iter().map(|v| {
        let near = tree.query(surface.position(v));
        // Four triangles per quad, in its order.
        let corner = quads.face_vertices(FaceId::new(near.point.face.index() / 4)).map(|v| quads.position(v));
        let longest = (0..4).map(|k| corner[k].distance(corner[(k + 1) % 4])).fold(f64::MIN_POSITIVE, f64::max);
        (v, near.distance, near.distance / longest)
    });
    let lost: Vec<(VertexId, f64, f64)> = measured.filter(|m| m.2 > LOST_REL).collect();
    lost.into_iter().reduce(|a, b| if b.2 > a.2 { b } else { a })
}

/// [`verify`] against a surface with the sharp edges that a run would keep for quads of this size.
///
/// # Input      sharp_angle: as in [`crate::RemeshOptions`], degrees; `None`: no edge is sharp
pub fn verify_against(quads: &QuadMesh, surface: &TriMesh, sharp_angle: Option<f64>) -> Verification {
    let length = |e| quads.ends(e).map(|v| quads.position(v));
    let total: f64 = quads.edges().map(length).map(|[a, b]| a.distance(b)).sum();
    let wanted = FeatureRequest { sharp_angle, ..FeatureRequest::default() };
    let features = find_features(surface, &wanted, total / quads.edge_count().max(1) as f64);
    verify(quads, &Reference::new(surface, &features.graph))
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadloom_mesh::shapes;

    #[test]
    fn quads_that_leave_out_a_spike_have_lost_a_part() {
        let cube = shapes::cube(1.0, 4);
        let quads = crate::split::split_triangles(&cube).expect("quads");
        assert_eq!(lost_part(&quads, &cube), None);
        // One corner far out.
        let corner = cube.vertices().find(|&v| cube.position(v) == DVec3::ONE).expect("the corner");
        let out = |v: VertexId| if v == corner { DVec3::splat(3.0) } else { cube.position(v) };
        let spike = TriMesh::new(cube.vertices().map(out).collect(), &cube.to_faces()).expect("a spike");
        assert_eq!(lost_part(&quads, &spike).map(|l| l.0), Some(corner));
    }
}
