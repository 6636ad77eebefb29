//! Which curves of a component are kept: boundaries, sharp edges, named edges, drawn curves.
//!
//! In: a component, what the user names, the size of the quads. Out: [`FeatureGraph`] and what was left out.
//! Holds: every kept edge is on one chain. Not: that named edges exist; those that do not are counted.
//! Source: [Bommes2012] §8.1 (sharp edges), §8.4 (alignment).

use crate::guides::trace_guides;
use quadloom_mesh::features::FeatureOptions;
use quadloom_mesh::metric::dihedral_angle;
use quadloom_mesh::{DVec3, EdgeId, EdgeMap, FeatureGraph, FeatureKind, TriMesh, VertexId};

/// Pieces of sharp edges with an open end that are shorter, in total, than this many target edges are dropped.
///
/// Scans and organic shapes have hundreds of such fragments, and each end of one costs irregular vertices; creases of
/// CAD models end on other creases.
const LOOSE_CHAIN_EDGES: f64 = 5.0;

/// Pieces of sharp edges with an open end are dropped unless this many times sharper than the edges beside them.
///
/// Creases that end somewhere on the CAD models measured have 30 to 90, folds of scans and of coarsely sampled bends
/// 1 to 7, even where they are hundreds of edges long.
const CREASE_CONTRAST: f64 = 12.0;

/// Target edges of height over an edge from which the faces beside it are facets, and it a crease whatever its contrast:
/// quads see the surface as flat there. Less: the strips of coarsely sampled bends are facets.
const FACET_HEIGHT_REL: f64 = 2.0;

/// Any piece of sharp edges shorter than this many target edges is dropped: no quad fits inside.
const SHORT_PIECE_EDGES: f64 = 4.0;

/// What would be dropped is kept where it is at most this part of all sharp edges, by length.
///
/// Scans and organic shapes would drop most of theirs, CAD models next to none: there even short creases, and bends of
/// few strips, were meant.
const FEW_REL: f64 = 0.1;

/// Target edges of the shortest piece that is kept for that: it is rounded up to a quad edge.
const LEAST_PIECE_EDGES: f64 = 0.5;

/// Target edges to either side over which a boundary has to turn for a corner.
///
/// More: notches of a few quads lose their corners. Less: the saw teeth of scans each become one, with no room between.
const BOUNDARY_REACH_REL: f64 = 1.0;

/// What is to be kept on one component.
#[derive(Clone, Debug, Default)]
pub struct FeatureRequest {
    /// Dihedral angle from which an edge is sharp, degrees; `None`: none is.
    pub sharp_angle: Option<f64>,
    /// Ends of edges that are named; pairs that are no edge are ignored.
    pub edges: Vec<[VertexId; 2]>,
    /// Curves near the surface.
    pub guides: Vec<Vec<DVec3>>,
}

/// The features of one component.
#[derive(Clone, Debug)]
pub struct Features {
    /// The chains.
    pub graph: FeatureGraph,
    /// Sharp edges in loose chains that were dropped.
    pub dropped_edges: usize,
}

/// Finds the features of a component.
///
/// # Input      size: target edge length of the quads, file units
/// # Cost       linear, and a shortest path per piece of a drawn curve
/// # Guarantees boundaries are always among the features; named edges are never dropped
pub fn find_features(mesh: &TriMesh, request: &FeatureRequest, size: f64) -> Features {
    // 1. Boundaries and sharp edges.
    let limit = request.sharp_angle.map_or(f64::INFINITY, f64::to_radians);
    let mut kind = EdgeMap::from_fn(mesh.edge_count(), |e| {
        if mesh.is_boundary_edge(e) {
            return Some(FeatureKind::Boundary);
        }
        (dihedral_angle(mesh, mesh.half_edge(e)) > limit).then_some(FeatureKind::Sharp)
    });
    // 2. Loose chains go before named edges come, so that no named edge is dropped with them.
    let options = FeatureOptions {
        min_loose_length: LOOSE_CHAIN_EDGES * size,
        min_piece_length: SHORT_PIECE_EDGES * size,
        min_contrast: CREASE_CONTRAST,
        facet_height: FACET_HEIGHT_REL * size,
        boundary_reach: BOUNDARY_REACH_REL * size,
        few_rel: FEW_REL,
        least_length: LEAST_PIECE_EDGES * size,
        ..FeatureOptions::default()
    };
    let (mut graph, dropped_edges) = FeatureGraph::from_kinds(mesh, kind.clone(), &options);
    if request.edges.is_empty() && request.guides.is_empty() {
        return Features { graph, dropped_edges };
    }
    let dropped: Vec<EdgeId> = mesh.edges().filter(|&e| kind[e].is_some() && !graph.is_feature(e)).collect();
    dropped.iter().for_each(|&e| kind[e] = None);
    // 3. Named edges and drawn curves.
    for e in request.edges.iter().filter_map(|&[a, b]| mesh.find_edge(a, b)) {
        kind[e] = kind[e].or(Some(FeatureKind::Sharp));
    }
    for e in trace_guides(mesh, &request.guides) {
        kind[e] = kind[e].or(Some(FeatureKind::Guide));
    }
    let options = FeatureOptions { boundary_reach: BOUNDARY_REACH_REL * size, ..FeatureOptions::default() };
    graph = FeatureGraph::from_kinds(mesh, kind, &options).0;
    // Those that came back by their names were not dropped.
    let dropped_edges = dropped.iter().filter(|&&e| !graph.is_feature(e)).count();
    Features { graph, dropped_edges }
}

/// The same chains, ids included, with those of the boundary no longer binding.
pub fn without_boundary(mesh: &TriMesh, features: &FeatureGraph) -> FeatureGraph {
    let mut free = features.clone();
    for e in mesh.edges().filter(|&e| mesh.is_boundary_edge(e)) {
        free.chain_of[e] = None;
    }
    let on = free.feature_vertices(mesh);
    for v in mesh.vertices() {
        free.is_corner[v] &= on[v];
    }
    free
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadloom_mesh::shapes;

    #[test]
    fn edges_that_are_named_are_not_counted_as_dropped() {
        let bracket = shapes::bracket(0.1);
        let size = 0.5 * bracket.diagonal();
        let found = FeatureRequest { sharp_angle: Some(35.0), ..FeatureRequest::default() };
        let dropped = find_features(&bracket, &found, size).dropped_edges;
        assert!(dropped > 0);
        let sharp: Vec<[VertexId; 2]> = bracket
            .edges()
            .filter(|&e| dihedral_angle(&bracket, bracket.half_edge(e)) > 35f64.to_radians())
            .map(|e| bracket.ends(e))
            .collect();
        let all = FeatureRequest { edges: sharp.clone(), ..found.clone() };
        assert_eq!(find_features(&bracket, &all, size).dropped_edges, 0);
        // An edge that is kept anyway, and all that are dropped stay dropped.
        let kept = find_features(&bracket, &found, size).graph;
        let one = sharp.into_iter().find(|&[a, b]| bracket.find_edge(a, b).is_some_and(|e| kept.is_feature(e)));
        let one = FeatureRequest { edges: one.into_iter().collect(), ..found };
        assert_eq!(find_features(&bracket, &one, size).dropped_edges, dropped);
    }
}
