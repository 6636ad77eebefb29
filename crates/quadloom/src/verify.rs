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
    /// Quads of which that is so at the centre but not all around it, as beside a thin sheet, ascending; they do not
    /// keep the quads from passing.
    pub unclear: Vec<FaceId>,
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
    let points: Vec<(FaceId, usize)> =
        all.into_par_iter().map(|f| (f, points_against(corners(f), reference))).filter(|p| p.1 > 0).collect();
    let those = |wanted: fn(usize) -> bool| points.iter().filter(|p| wanted(p.1)).map(|p| p.0).collect();
    Verification {
        expected: Summary::of(reference.mesh),
        found: Summary::of(quads),
        inverted: quads.faces().filter(|&f| scaled_jacobian(corners(f)) < LEAST_JACOBIAN).collect(),
        against: those(|n| n >= 3),
        unclear: those(|n| n < 3),
    }
}

/// [`verify`] against a surface without features.
pub fn verify_against(quads: &QuadMesh, surface: &TriMesh) -> Verification {
    verify(quads, &Reference::new(surface, &FeatureGraph::none(surface)))
}

/// At how many of five points a quad faces against the surface; 0 if it does not at its centre.
fn points_against(corner: [DVec3; 4], reference: &Reference) -> usize {
    let centre = corner.iter().sum::<DVec3>() / 4.0;
    reference.points_against(corner, reference.closest.query(centre).point.face)
}
