//! Ties between singular vertices: what was asked for, what the map is told, what the quads have.
//!
//! In: pairs of vertices of the input. Out: pairs of singular vertices of a work mesh, and one [`TieReport`] each.
//! Holds: a tie is reported as joined only if quads have the chain of edges, which is looked for there.
//! Source: [Bommes2012] §8.6, base complex.

use crate::error::{Warning, WarningCode};
use crate::options::Elements;
use crate::part::{Part, PartRequest};
use crate::stages::WorkMesh;
use quadloom_extract::Extraction;
use quadloom_field::{CrossField, Transport};
use quadloom_mesh::{HalfEdgeId, QuadConnectivity, VertexId};
use quadloom_param::Tie;
use serde::Serialize;

/// A tie as it was asked for, between vertices of one component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TieRequest {
    /// Numbers of the input file, for reports.
    pub asked: [u32; 2],
    /// The vertices of the component.
    pub vertices: [VertexId; 2],
}

/// What became of a tie.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct TieReport {
    /// Vertices of the input file that were named.
    pub asked: [u32; 2],
    /// Quad edges of the straight chain between the two irregular vertices; `None` where there is none.
    pub edges: Option<usize>,
    /// Why there is none.
    pub missed: Option<TieMiss>,
}

/// Why there is no chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum TieMiss {
    /// All interior vertices are regular.
    NothingIrregular,
    /// One irregular vertex is nearest to both.
    SameVertex,
    /// The quads have no straight chain between the two.
    NoChain,
    /// The quads were made by splitting triangles, which knows no ties.
    TrianglesSplit,
}

/// The ties between the singular vertices that are nearest to what was named; where there are none, or both names mean
/// the same one, there is no tie.
pub fn ties_on(work: &WorkMesh, field: &CrossField, request: &PartRequest) -> Vec<Option<Tie>> {
    if request.ties.is_empty() {
        return Vec::new();
    }
    let mesh = &work.mesh;
    let singular = field.singularities(mesh, &Transport::of(mesh));
    let nearest = |v: VertexId| {
        let distance = |w: VertexId| mesh.position(w).distance_squared(request.mesh.position(v));
        singular.iter().map(|s| s.0).min_by(|&a, &b| distance(a).total_cmp(&distance(b)))
    };
    let tie = |asked: &TieRequest| {
        let [a, b] = asked.vertices.map(nearest);
        Some(Tie { ends: [a?, b?] }).filter(|tie| tie.ends[0] != tie.ends[1])
    };
    request.ties.iter().map(tie).collect()
}

/// Looks for the chains in the quads.
pub fn joined_ties(
    work: &WorkMesh,
    extraction: &Extraction,
    request: &PartRequest,
    ties: &[Option<Tie>],
) -> Vec<TieReport> {
    let quads = &extraction.mesh;
    let at = |v: VertexId| {
        let distance = |q: VertexId| extraction.origin[q].position(&work.mesh).distance_squared(work.mesh.position(v));
        quads.vertices().min_by(|&a, &b| distance(a).total_cmp(&distance(b)))
    };
    let edges = |tie: &Tie| straight_chain(quads, at(tie.ends[0])?, at(tie.ends[1])?);
    let any_irregular = quads.vertices().any(|v| quads.valence(v) != 4 && !quads.is_boundary_vertex(v));
    let report = |(tie, asked): (&Option<Tie>, &TieRequest)| {
        let edges = tie.as_ref().and_then(edges);
        let why = match tie {
            _ if !any_irregular => TieMiss::NothingIrregular,
            None => TieMiss::SameVertex,
            Some(_) => TieMiss::NoChain,
        };
        TieReport { asked: asked.asked, edges, missed: edges.is_none().then_some(why) }
    };
    ties.iter().zip(&request.ties).map(report).collect()
}

/// Edges of the shortest straight chain from one irregular vertex to another: it leaves every vertex between them
/// opposite to where it came, and they are interior and regular.
///
/// # Cost       the edges looked at, at most all of them
pub fn straight_chain(quads: &QuadConnectivity, from: VertexId, to: VertexId) -> Option<usize> {
    if quads.valence(from) == 4 || quads.valence(to) == 4 {
        return None;
    }
    quads.outgoing(from).filter_map(|first| chain_length(quads, first, to)).min()
}

fn chain_length(quads: &QuadConnectivity, first: HalfEdgeId, to: VertexId) -> Option<usize> {
    let mut h = first;
    for edges in 1..=quads.edge_count() {
        let v = quads.target(h);
        if v == to {
            return Some(edges);
        }
        if quads.valence(v) != 4 || quads.is_boundary_vertex(v) {
            return None;
        }
        // Two quads to the left of where it came from.
        h = quads.rotate_ccw(quads.rotate_ccw(quads.twin(h)?)?)?;
    }
    None
}

/// All ties of all components, in the order of the components.
pub fn tie_reports(requests: &[PartRequest], parts: &[Part]) -> Vec<TieReport> {
    let split = |t: &TieRequest| TieReport { asked: t.asked, edges: None, missed: Some(TieMiss::TrianglesSplit) };
    let of_part = |(request, part): (&PartRequest, &Part)| match &part.solution {
        Some(solution) => solution.ties.clone(),
        None => request.ties.iter().map(split).collect(),
    };
    requests.iter().zip(parts).flat_map(of_part).collect()
}

/// A warning for every tie without a chain.
pub fn tie_warnings(reports: &[TieReport]) -> impl Iterator<Item = Warning> + '_ {
    reports.iter().filter_map(|tie| {
        let [a, b] = tie.asked;
        let message = match tie.missed? {
            TieMiss::NothingIrregular => format!(
                "vertices {a} and {b} are not tied: the quads have no irregular vertex inside; --singularities makes some"
            ),
            TieMiss::SameVertex => format!(
                "vertices {a} and {b} are not tied: one irregular vertex is nearest to both; name vertices beside two \
                 different ones"
            ),
            TieMiss::NoChain => format!(
                "no chain of quad edges joins the irregular vertices nearest to vertices {a} and {b}: no map without \
                 folds has it; name vertices on the same line of the field, or more quads"
            ),
            TieMiss::TrianglesSplit => format!(
                "vertices {a} and {b} are not tied: triangles were split into quads, which have no chains"
            ),
        };
        Some(Warning::new(WarningCode::TieMissed, message).at(Elements::Vertices(tie.asked.to_vec())))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadloom_mesh::QuadMesh;
    use quadloom_mesh::{DVec3, shapes};

    /// A cube of n × n quads per side: its corners are irregular and joined along the cube's edges only.
    fn quad_cube(n: u32) -> QuadMesh {
        let triangles = shapes::cube(1.0, n);
        let mut quads: Vec<[u32; 4]> = Vec::new();
        let number = |p: DVec3| triangles.vertices().find(|&v| triangles.position(v).distance(p) < 1e-9).map(|v| v.0);
        let step = 1.0 / f64::from(n);
        for axis in 0..3 {
            for end in [0.0, 1.0] {
                for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                    let at = |di: u32, dj: u32| {
                        let mut p = [0.0; 3];
                        p[axis] = end;
                        p[(axis + 1) % 3] = f64::from(i + di) * step;
                        p[(axis + 2) % 3] = f64::from(j + dj) * step;
                        number(DVec3::from(p)).expect("a vertex of the cube")
                    };
                    let quad = [at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
                    quads.push(if end > 0.0 { quad } else { [quad[0], quad[3], quad[2], quad[1]] });
                }
            }
        }
        QuadMesh::new(triangles.positions().values().to_vec(), &quads).expect("a cube")
    }

    #[test]
    fn corners_of_a_cube_are_joined_along_its_edges_and_not_across() {
        let cube = quad_cube(4);
        let corners: Vec<VertexId> = cube.vertices().filter(|&v| cube.valence(v) == 3).collect();
        assert_eq!(corners.len(), 8);
        for &a in &corners {
            for &b in corners.iter().filter(|&&b| b != a) {
                let apart = (cube.position(a) - cube.position(b)).abs();
                let along_edge = apart.to_array().iter().filter(|&&d| d > 0.5).count() == 1;
                assert_eq!(straight_chain(&cube, a, b), along_edge.then_some(4), "{apart}");
            }
        }
        let regular = cube.vertices().find(|&v| cube.valence(v) == 4).expect("a regular vertex");
        assert_eq!(straight_chain(&cube, corners[0], regular), None);
    }
}
