//! What a result must be before it is called one.
//!
//! In: quads and the surface they stand for. Out: [`Verification`]. Holds: made from the definitions, not from what
//! the stages say of themselves. That quads are four different vertices, manifold and oriented is what
//! [`QuadMesh`]'s constructor has checked.

use quadloom_extract::{Reference, scaled_jacobian};
use quadloom_mesh::{DVec3, FaceId, FeatureGraph, QuadMesh, Summary, TriMesh};
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
    /// Quads whose normal points against the surface's, ascending.
    pub against: Vec<FaceId>,
}

impl Verification {
    /// Whether the quads are a result.
    pub fn passed(&self) -> bool {
        self.expected.same_topology(&self.found) && self.inverted.is_empty() && self.against.is_empty()
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
    Verification {
        expected: Summary::of(reference.mesh),
        found: Summary::of(quads),
        inverted: quads.faces().filter(|&f| scaled_jacobian(corners(f)) < LEAST_JACOBIAN).collect(),
        against: all.into_par_iter().filter(|&f| faces_against(corners(f), reference)).collect(),
    }
}

/// [`verify`] against a surface without features.
pub fn verify_against(quads: &QuadMesh, surface: &TriMesh) -> Verification {
    verify(quads, &Reference::new(surface, &FeatureGraph::none(surface)))
}

/// Whether five points of a quad all lie nearest to faces that point the other way.
///
/// Some of them may be nearest to the other side of a thin sheet; a quad that is turned over has all five against it.
fn faces_against(corner: [DVec3; 4], reference: &Reference) -> bool {
    let normal = (corner[2] - corner[0]).cross(corner[3] - corner[1]);
    let centre = corner.iter().sum::<DVec3>() / 4.0;
    let against = |p: DVec3| reference.mesh.vector_area(reference.closest.query(p).point.face).dot(normal) < 0.0;
    against(centre) && corner.iter().all(|&c| against(c.lerp(centre, 0.5)))
}
