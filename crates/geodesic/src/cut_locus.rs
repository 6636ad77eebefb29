//! Candidates for the geodesic medial axis (cut locus): where shortest paths of different directions meet.
//!
//! In: a field. Out: places on edges where the distance has a ridge, and lines between them through faces.
//! Holds: every ridge of the field that is at least as sharp as asked for and crosses an edge is listed. Not: branches
//! that end inside a face, which cross no edge; for ε > 0 ridges may be those of merged windows.
//! Source: [Bommes2012] §9, adaptive refinement ("smooth ... everywhere except for the geodesic medial axis").

use crate::error::GeodesicError;
use crate::field::Field;
use crate::wavefront::label_of;
use quadloom_mesh::EdgeId;

/// A place on an edge where two shortest paths meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutPoint {
    /// The edge.
    pub edge: EdgeId,
    /// Fraction from the origin of its canonical half-edge.
    pub at: f64,
    /// Distance, file units.
    pub distance: f64,
    /// By how much the direction of the distance along the edge turns there: the difference of cosines, 0..=2.
    pub jump: f64,
    /// Labels of the sources of both paths.
    pub labels: [u32; 2],
}

/// Places on edges, and which of them lie on one ridge through a face.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CutLocus {
    /// The places, by edge.
    pub points: Vec<CutPoint>,
    /// Pairs of places in one face.
    pub segments: Vec<[usize; 2]>,
}

impl Field<'_> {
    /// Where shortest paths meet whose directions along an edge differ.
    ///
    /// # Input      jump: least difference of cosines, above 0; 0.1 hides what noise of the surface makes
    /// # Output     places and lines; in a face with two places a line joins them, in one with more each is joined to
    /// the nearest by distance that is left
    /// # Errors     a wavefront that kept no windows
    /// # Cost       linear in the windows
    pub fn cut_locus(&self, jump: f64) -> Result<CutLocus, GeodesicError> {
        self.needs_windows()?;
        let (wave, mesh) = (self.wave, self.wave.surface.connectivity());
        let mut locus = CutLocus::default();
        let mut of_edge: Vec<std::ops::Range<usize>> = Vec::with_capacity(mesh.edge_count());
        // 1. Ridges on edges: the distance rises more steeply before than behind.
        for e in mesh.edges() {
            let first = locus.points.len();
            let length = wave.surface.length(e);
            for pair in wave.lists.of(e).windows(2) {
                let ((d, before), (_, behind)) = (pair[0].at_with_slope(pair[0].b1), pair[1].at_with_slope(pair[1].b0));
                if before - behind >= jump {
                    let labels = [pair[0], pair[1]].map(|w| label_of(&wave.label, &wave.sources, w.root()));
                    let (at, distance) = (pair[0].b1 / length, d / wave.surface.scale());
                    locus.points.push(CutPoint { edge: e, at, distance, jump: before - behind, labels });
                }
            }
            of_edge.push(first..locus.points.len());
        }
        // 2. Through faces, in the order of their distances.
        for face in mesh.faces() {
            let mut here: Vec<usize> =
                mesh.face_half_edges(face).into_iter().flat_map(|h| of_edge[mesh.edge(h).index()].clone()).collect();
            here.sort_by(|&a, &b| locus.points[a].distance.total_cmp(&locus.points[b].distance).then(a.cmp(&b)));
            locus.segments.extend(here.windows(2).map(|w| [w[0], w[1]]));
        }
        Ok(locus)
    }
}
