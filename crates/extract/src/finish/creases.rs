//! Sharp edges that the quads were not made to follow get vertices and edges where the quads have some beside them.
//!
//! In: a [`State`] on the surface, and the angle from which an edge is sharp. Out: the same with paths of quad edges on
//! such creases, pinned there. Holds: no quad gets worse below the floor; a crease that is a feature already is left to
//! its ties. Not: every crease; one that crosses the quads diagonally, or is shorter than they are, gets single vertices.
//! Source: own. A short crease that ends in a smooth surface would cost the map irregular vertices; here it costs none.

use super::state::State;
use super::sweep::{Aim, sweep};
use super::ties::{Move, project};
use crate::quality::split_at_centres;
use quadloom_mesh::closest::{ClosestPoint, PolylineIndex};
use quadloom_mesh::features::FeatureOptions;
use quadloom_mesh::metric::dihedral_angle;
use quadloom_mesh::{
    Cancelled, ChainId, DVec3, EdgeMap, FaceId, FeatureGraph, FeatureKind, HalfEdgeId, MeshError, Progress, QuadMesh,
    VertexId,
};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

/// Length of all creases, relative to that of all quad edges, beyond which they are the grain of the surface.
///
/// CAD models have up to 0.02 left when their features are tied, scans 0.05 to 0.2.
const GRAIN_REL: f64 = 0.04;

/// Distance from a crease up to which vertices are drawn to it, in mean quad edges.
const REACH_REL: f64 = 0.75;

/// Creases shorter than this, in mean quad edges, get one vertex at their middle.
const SHORT_REL: f64 = 0.6;

/// Edges of a path at most, relative to the mean quad edges that fit along its crease: a path with more is a stair.
const STAIR_REL: f64 = 1.3;

/// How much the length of an edge counts that is a mean quad edge away from the crease, beside one on it.
const OFF_COST: f64 = 20.0;

/// Strides in which vertices go to a crease; the others make room after each.
const STRIDES: usize = 3;

/// Scaled Jacobian down to which quads may get worse for a crease.
const CREASE_FLOOR: f64 = 0.35;

/// A vertex that is on its way to a place on a crease.
struct Pull {
    vertex: VertexId,
    target: DVec3,
    /// A face of the surface beside the crease.
    face: FaceId,
}

/// Creases of the surface, a face beside each of their edges, and the quads as they lie.
struct Creases {
    chains: FeatureGraph,
    curves: PolylineIndex,
}

/// Draws paths of quad edges onto creases; returns how many vertices reached one.
///
/// # Input      angle: from which an edge is sharp, degrees; edge: mean edge length of the quads, file units
/// # Errors     positions that are no mesh, cancellation
/// # Cost       a closest-point query per end of a crease, a search along it, a few sweeps
pub(crate) fn follow_creases(
    state: &mut State,
    angle: f64,
    edge: f64,
    aim: Aim,
    progress: &Progress,
) -> Result<usize, CreaseError> {
    let Some(creases) = Creases::find(state, angle, edge) else { return Ok(0) };
    // 1. Who goes where.
    let pulls = creases.pulls(state, edge)?;
    // 2. In strides; who is on the way is not swept back.
    for pull in &pulls {
        state.pinned[pull.vertex] = true;
    }
    for left in (1..=STRIDES).rev() {
        progress.check()?;
        let mut moves: Vec<Option<Move>> = vec![None; state.quads.vertex_count()];
        for pull in &pulls {
            moves[pull.vertex.index()] = stride(state, pull, left);
        }
        state.advance(&moves, CREASE_FLOOR);
        sweep(state, aim);
    }
    // 3. Who did not arrive is free again.
    let mut arrived = 0;
    for pull in &pulls {
        let there = state.position[pull.vertex] == pull.target;
        state.pinned[pull.vertex] = there;
        arrived += usize::from(there);
    }
    Ok(arrived)
}

/// Why creases were not followed.
#[derive(Debug, thiserror::Error)]
pub(crate) enum CreaseError {
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

/// The next of so many strides that are left.
fn stride(state: &State, pull: &Pull, left: usize) -> Option<Move> {
    if left == 1 {
        return Some(Move::on(state.reference, pull.face, pull.target));
    }
    let position = state.position[pull.vertex];
    let there = position + (pull.target - position) / left as f64;
    project(state.reference, there, state.vertex_normal(pull.vertex), None)
}

impl Creases {
    /// Sharp edges that are no features, in chains; `None` where there is none, or the surface is full of them.
    fn find(state: &State, angle: f64, edge: f64) -> Option<Self> {
        let (mesh, features) = (state.reference.mesh, state.reference.features);
        let limit = angle.to_radians();
        let is_crease =
            |e| !features.is_feature(e) && !mesh.is_boundary_edge(e) && dihedral_angle(mesh, mesh.half_edge(e)) > limit;
        let kind = EdgeMap::from_fn(mesh.edge_count(), |e| is_crease(e).then_some(FeatureKind::Sharp));
        let long = |e| {
            let [a, b] = mesh.ends(e).map(|v| mesh.position(v));
            a.distance(b)
        };
        let length: f64 = mesh.edges().filter(|&e| kind[e].is_some()).map(long).sum();
        if length <= 0.0 || length > GRAIN_REL * edge * state.quads.edge_count() as f64 {
            return None;
        }
        let (chains, _) = FeatureGraph::from_kinds(mesh, kind, &FeatureOptions::default());
        let curves = PolylineIndex::from_features(mesh, &chains);
        Some(Self { chains, curves })
    }

    /// The vertices to be drawn and their places, each vertex once.
    fn pulls(&self, state: &State, edge: f64) -> Result<Vec<Pull>, MeshError> {
        let quads = state.quads.with_positions(state.position.clone())?;
        let tree = ClosestPoint::new(&split_at_centres(&quads)?);
        let mut pulls: BTreeMap<VertexId, Pull> = BTreeMap::new();
        for chain in 0..self.curves.len() as ChainId {
            for (vertex, arc) in self.stops(&quads, &tree, chain, edge) {
                let at = self.curves.at(chain, arc);
                let face = self.face_beside(state, chain, at.segment);
                let far = quads.position(vertex).distance(at.position) > REACH_REL * edge;
                if !far && state.may_move(vertex) {
                    pulls.entry(vertex).or_insert(Pull { vertex, target: at.position, face });
                }
            }
        }
        Ok(pulls.into_values().collect())
    }

    /// Vertices for one crease, with the lengths along it where they belong.
    fn stops(&self, quads: &QuadMesh, tree: &ClosestPoint, chain: ChainId, edge: f64) -> Vec<(VertexId, f64)> {
        let total = self.curves.length(chain);
        let nearest = |arc: f64| nearest_corner(quads, tree, self.curves.at(chain, arc).position);
        // 1. Closed creases in two halves.
        let cuts = if self.curves.is_closed(chain) { vec![0.0, 0.5 * total, total] } else { vec![0.0, total] };
        let mut stops = Vec::new();
        for cut in cuts.windows(2) {
            let (from, to) = (cut[0], cut[1]);
            if to - from < SHORT_REL * edge {
                let middle = 0.5 * (from + to);
                stops.push((nearest(middle), middle));
                continue;
            }
            // 2. A path of edges beside it, its vertices spread along it in proportion; else its ends alone.
            let (a, b) = (nearest(from), nearest(to));
            let path = self.path(quads, chain, [a, b], edge);
            if path.len() < 2 || (path.len() - 1) as f64 > (STAIR_REL * (to - from) / edge).max(1.5) {
                stops.extend([(a, from), (b, to)]);
                continue;
            }
            let steps: Vec<f64> =
                path.windows(2).map(|w| quads.position(w[0]).distance(quads.position(w[1]))).collect();
            let whole: f64 = steps.iter().sum();
            let mut gone = 0.0;
            for (k, &v) in path.iter().enumerate() {
                stops.push((v, from + (to - from) * gone / whole.max(f64::MIN_POSITIVE)));
                gone += steps.get(k).copied().unwrap_or(0.0);
            }
        }
        stops
    }

    /// The shortest path of quad edges from one vertex to another that keeps to a crease; empty if it would be long.
    ///
    /// Equal lengths are decided by the smaller vertex.
    fn path(&self, quads: &QuadMesh, chain: ChainId, [from, to]: [VertexId; 2], edge: f64) -> Vec<VertexId> {
        let most = (1.0 + OFF_COST * REACH_REL * REACH_REL) * (self.curves.length(chain) + 2.0 * edge);
        let mut reached: BTreeMap<VertexId, (f64, VertexId)> = BTreeMap::from([(from, (0.0, from))]);
        // Lengths are not negative: their bits have their order.
        let mut open = BinaryHeap::from([Reverse((0u64, from))]);
        while let Some(Reverse((bits, v))) = open.pop() {
            let length = f64::from_bits(bits);
            if v == to {
                break;
            }
            if length > reached[&v].0 || length > most {
                continue;
            }
            let p = quads.position(v);
            for w in quads.neighbours(v) {
                let q = quads.position(w);
                let off = self.curves.query(chain, p.midpoint(q)).distance / edge;
                let there = length + p.distance(q) * (1.0 + OFF_COST * off * off);
                if reached.get(&w).is_none_or(|r| there < r.0) {
                    reached.insert(w, (there, v));
                    open.push(Reverse((there.to_bits(), w)));
                }
            }
        }
        if !reached.contains_key(&to) {
            return Vec::new();
        }
        let mut path = vec![to];
        while path[path.len() - 1] != from {
            path.push(reached[&path[path.len() - 1]].1);
        }
        path.reverse();
        path
    }

    fn face_beside(&self, state: &State, chain: ChainId, segment: u32) -> FaceId {
        let mesh = state.reference.mesh;
        let vertices = &self.chains.chains[chain as usize].vertices;
        let at = |i: usize| vertices[i % vertices.len()];
        let e = mesh.find_edge(at(segment as usize), at(segment as usize + 1));
        let h: HalfEdgeId = e.map_or(mesh.outgoing_half_edge(vertices[0]), |e| mesh.half_edge(e));
        mesh.face(h)
    }
}

/// The corner nearest to a point of the quad that is nearest to it.
fn nearest_corner(quads: &QuadMesh, tree: &ClosestPoint, p: DVec3) -> VertexId {
    // Four triangles per quad, in its order.
    let quad = FaceId::new(tree.query(p).point.face.index() / 4);
    let [first, rest @ ..] = quads.face_vertices(quad);
    let distance = |v: VertexId| quads.position(v).distance_squared(p);
    rest.into_iter().fold(first, |best, v| if distance(v) < distance(best) { v } else { best })
}

#[cfg(test)]
mod tests {
    use crate::extraction::{ExtractReport, Extraction, Placement};
    use crate::finish::{FinishOptions, finish};
    use crate::quality::scaled_jacobian;
    use crate::reference::Reference;
    use quadloom_mesh::features::FeatureOptions;
    use quadloom_mesh::{
        DVec3, EdgeMap, FaceId, FaceMap, FeatureGraph, PolylineIndex, Progress, QuadMesh, SurfacePoint, TriMesh,
        VertexId, VertexMap,
    };

    /// A plate with a fold along y = 0 that is sharp in the middle and fades to both sides.
    fn folded(x: f64, y: f64) -> DVec3 {
        DVec3::new(x, y, -0.9 * y.abs() / (1.0 + y * y) * (1.0 - x.abs() / 3.0).max(0.0))
    }

    /// A grid of points, and the corners of its cells.
    fn grid(xs: &[f64], ys: &[f64]) -> (Vec<DVec3>, Vec<[u32; 4]>) {
        let points = ys.iter().flat_map(|&y| xs.iter().map(move |&x| folded(x, y))).collect();
        let (columns, rows) = (xs.len() as u32, ys.len() as u32);
        let cell =
            |i: u32, j: u32| [i + j * columns, i + 1 + j * columns, i + 1 + (j + 1) * columns, i + (j + 1) * columns];
        let cells = (0..rows - 1).flat_map(|j| (0..columns - 1).map(move |i| cell(i, j))).collect();
        (points, cells)
    }

    #[test]
    fn quad_edges_go_to_a_crease_that_is_no_feature() {
        let fine: Vec<f64> = (0..=32).map(|i| 0.25 * f64::from(i) - 4.0).collect();
        let (points, cells) = grid(&fine, &fine[4..=28]);
        let triangles: Vec<[u32; 3]> = cells.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let plate = TriMesh::new(points, &triangles).expect("a plate");
        // The crease is too short to be a feature.
        let options = FeatureOptions { min_loose_length: 9.0, ..FeatureOptions::default() };
        let (features, dropped) = FeatureGraph::detect(&plate, &options);
        assert!(dropped > 4 && features.chains.len() == 4);
        let reference = Reference::new(&plate, &features);
        let columns: Vec<f64> = (-4..=4).map(f64::from).collect();
        let (positions, quads) = grid(&columns, &[-3.0, -1.7, -0.65, 0.35, 1.35, 2.2, 3.0]);
        let mesh = QuadMesh::new(positions, &quads).expect("quads");
        let chain_at = |p: DVec3| reference.curves.query_any(p).expect("a boundary");
        let placement = VertexMap::from_fn(mesh.vertex_count(), |v: VertexId| {
            let p = mesh.position(v);
            if p.x.abs() == 4.0 && p.y.abs() == 3.0 {
                return Placement::Corner(v);
            }
            let chain =
                |chain| Placement::Chain { chain, edge: plate.edges().next().expect("an edge"), parameter: 0.0 };
            if mesh.is_boundary_vertex(v) { chain(chain_at(p).chain) } else { Placement::Free }
        });
        let feature_edges = EdgeMap::from_fn(mesh.edge_count(), |e| {
            let [a, b] = mesh.ends(e).map(|v| mesh.position(v));
            mesh.is_boundary_edge(e).then(|| chain_at(a.midpoint(b)).chain)
        });
        let quads = Extraction {
            origin: VertexMap::filled(mesh.vertex_count(), SurfacePoint { face: FaceId(0), weights: [1.0, 0.0, 0.0] }),
            placement,
            feature_edges,
            grid: FaceMap::filled(mesh.face_count(), None),
            report: ExtractReport::default(),
            mesh,
        };
        let farthest = |crease_angle| {
            let options = FinishOptions { crease_angle, ..FinishOptions::default() };
            let finished = finish(&quads, &reference, &options, &Progress::none()).expect("finished");
            let corners = |f| finished.mesh.face_vertices(f).map(|v| finished.mesh.position(v));
            assert!(finished.mesh.faces().all(|f| scaled_jacobian(corners(f)) > 0.3));
            let ends = |e| (finished.mesh.ends(e).map(|v| finished.mesh.position(v)), false);
            let edges: Vec<([DVec3; 2], bool)> = finished.mesh.edges().map(ends).collect();
            let index = PolylineIndex::new(&edges);
            let on_crease = (-4..=4).map(|i| folded(0.25 * f64::from(i), 0.0));
            let off = on_crease.map(|p| index.query_any(p).map_or(f64::INFINITY, |c| c.distance)).fold(0.0, f64::max);
            (off, finished.report.creased)
        };
        let ((before, none), (after, some)) = (farthest(None), farthest(Some(35.0)));
        assert!(none == 0 && some >= 3, "{none} {some}");
        assert!(after < 0.02 && before > 5.0 * after, "{before} {after}");
    }
}
