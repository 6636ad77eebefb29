//! Feature curves: sharp edges, boundaries and guides, grouped into chains between corners.
//!
//! In: a triangle mesh and the edges that are to be kept. Out: [`FeatureGraph`].
//! Holds: every feature edge belongs to exactly one chain; chains meet only at corners; a chain without
//! a corner is closed; ids follow the smallest edge id. Source: [Bommes2012] §8.4, feature line alignment.

use crate::DVec3;
use crate::ids::{EdgeId, EdgeMap, FaceId, HalfEdgeId, VertexId, VertexMap};
use crate::mesh::TriMesh;
use crate::metric::dihedral_angle;
use crate::topology::boundary_loops;
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_2, PI};

/// Number of a chain in [`FeatureGraph::chains`].
pub type ChainId = u32;

/// Why an edge is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum FeatureKind {
    /// The edge has one face.
    Boundary,
    /// The normals of its faces differ by more than the sharp angle, or a feature file names it.
    Sharp,
    /// A user drew a curve along it.
    Guide,
}

/// A maximal run of feature edges without a corner inside.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FeatureChain {
    /// What it is.
    pub kind: FeatureKind,
    /// Its vertices in order; a closed chain does not repeat its first vertex.
    pub vertices: Vec<VertexId>,
    /// Whether the last vertex is joined to the first one.
    pub closed: bool,
}

/// The feature curves of a triangle mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FeatureGraph {
    /// Chain of each edge; `None` for ordinary edges.
    pub chain_of: EdgeMap<Option<ChainId>>,
    /// The chains.
    pub chains: Vec<FeatureChain>,
    /// Vertices that stay where they are: ends and branches of features, sharp turns, changes of kind.
    pub is_corner: VertexMap<bool>,
}

/// How features are found and split.
#[derive(Clone, Debug, PartialEq)]
pub struct FeatureOptions {
    /// Dihedral angle from which an edge is sharp, degrees; `None`: no edge is. Default 35, the custom of the field:
    /// smaller angles pick up coarse tessellation, larger ones lose chamfers.
    pub sharp_angle: Option<f64>,
    /// Turn of a chain from which a vertex is a corner, degrees. Default 50: below it a polygonal circle of eight
    /// sides stays one smooth chain, above it a hexagon does.
    pub corner_angle: f64,
    /// Length along a boundary, to either side, over which it must turn as much for a corner, file units: the saw teeth
    /// of a scan's boundary are none. Corners within half of it keep as many as they turn by right angles together.
    /// Default 0: the two edges at the vertex decide.
    pub boundary_reach: f64,
    /// Connected pieces of sharp edges with an open end, and not attached to a boundary or guide, that are shorter than
    /// this are dropped, file units. Default 0: none is.
    pub min_loose_length: f64,
    /// Connected pieces of sharp edges that are shorter than this and not attached are dropped, closed ones too, file
    /// units. Default 0: none is.
    pub min_piece_length: f64,
    /// Connected pieces of sharp edges with an open end are dropped if their median edge is fewer times sharper than the
    /// edges beside it. Default 0: none is.
    pub min_contrast: f64,
    /// Pieces whose median edge lies between faces of at least this height over it are creases between facets, whatever
    /// their contrast, file units. Default: none is.
    pub facet_height: f64,
    /// Where all that would be dropped is at most this part of the length of all sharp edges, the surface is a solid and
    /// no scan: its open pieces of several edges are kept that have at least [`Self::least_length`]. Default 0: never.
    pub few_rel: f64,
    /// Length of the shortest piece that is kept for being one of few, file units. Default 0.
    pub least_length: f64,
}

/// Distance of two corners of a boundary, relative to the reach, below which they are looked at together.
///
/// Larger: the ends of narrow tabs lose corners. Smaller: a thorn of the boundary is three corners where one has room.
const CROWDED_REL: f64 = 0.5;

impl Default for FeatureOptions {
    fn default() -> Self {
        Self {
            sharp_angle: Some(35.0),
            corner_angle: 50.0,
            boundary_reach: 0.0,
            min_loose_length: 0.0,
            min_piece_length: 0.0,
            min_contrast: 0.0,
            facet_height: f64::INFINITY,
            few_rel: 0.0,
            least_length: 0.0,
        }
    }
}

impl FeatureGraph {
    /// Finds boundaries and sharp edges.
    ///
    /// # Output     the features, and the number of edges in loose chains that were dropped
    /// # Cost       linear
    pub fn detect(mesh: &TriMesh, options: &FeatureOptions) -> (Self, usize) {
        let limit = options.sharp_angle.map_or(f64::INFINITY, f64::to_radians);
        let kind = EdgeMap::from_fn(mesh.edge_count(), |e| {
            if mesh.is_boundary_edge(e) {
                Some(FeatureKind::Boundary)
            } else {
                (dihedral_angle(mesh, mesh.half_edge(e)) > limit).then_some(FeatureKind::Sharp)
            }
        });
        Self::from_kinds(mesh, kind, options)
    }

    /// Groups given feature edges into chains, dropping short loose ones of kind `Sharp`.
    ///
    /// # Output     the features, and the number of dropped edges
    pub fn from_kinds(
        mesh: &TriMesh,
        mut kind: EdgeMap<Option<FeatureKind>>,
        options: &FeatureOptions,
    ) -> (Self, usize) {
        let first = Self::group(mesh, &kind, options);
        let dropped = first.unwanted_edges(mesh, options);
        if dropped.is_empty() {
            return (first, 0);
        }
        for &e in &dropped {
            kind[e] = None;
        }
        (Self::group(mesh, &kind, options), dropped.len())
    }

    /// No feature at all, not even the boundary.
    pub fn none(mesh: &TriMesh) -> Self {
        Self {
            chain_of: EdgeMap::filled(mesh.edge_count(), None),
            chains: Vec::new(),
            is_corner: VertexMap::filled(mesh.vertex_count(), false),
        }
    }

    /// Whether an edge is a feature.
    pub fn is_feature(&self, e: EdgeId) -> bool {
        self.chain_of[e].is_some()
    }

    /// Whether some feature edge meets each vertex.
    pub fn feature_vertices(&self, mesh: &crate::connectivity::TriConnectivity) -> VertexMap<bool> {
        let mut on = VertexMap::filled(mesh.vertex_count(), false);
        for (e, chain) in self.chain_of.iter() {
            if chain.is_some() {
                for v in mesh.ends(e) {
                    on[v] = true;
                }
            }
        }
        on
    }

    /// Number of feature edges.
    pub fn edge_count(&self) -> usize {
        self.chain_of.values().iter().flatten().count()
    }

    fn group(mesh: &TriMesh, kind: &EdgeMap<Option<FeatureKind>>, options: &FeatureOptions) -> Self {
        let mut at: VertexMap<Vec<EdgeId>> = VertexMap::filled(mesh.vertex_count(), Vec::new());
        for (e, k) in kind.iter() {
            if k.is_some() {
                for v in mesh.ends(e) {
                    at[v].push(e);
                }
            }
        }
        let cos_turn = options.corner_angle.to_radians().cos();
        let is_corner = VertexMap::from_fn(mesh.vertex_count(), |v| match at[v][..] {
            [] => false,
            [e, g] => {
                let p = mesh.position(v);
                let turns =
                    |a: DVec3, b: DVec3| (p - a).normalize_or_zero().dot((b - p).normalize_or_zero()) < cos_turn;
                let reach = if kind[e] == Some(FeatureKind::Boundary) { options.boundary_reach } else { 0.0 };
                let [a, b] = [e, g].map(|first| mesh.position(other_end(mesh, first, v)));
                let [far_a, far_b] = [e, g].map(|first| point_along(mesh, &at, v, first, reach));
                kind[e] != kind[g] || turns(a, b) && turns(far_a, far_b)
            }
            _ => true,
        });
        let chain_of = EdgeMap::filled(mesh.edge_count(), None);
        let mut graph = Self { chain_of, chains: Vec::new(), is_corner };
        for crowd in graph.crowds(mesh, kind, &at, options.boundary_reach) {
            graph.thin_out(mesh, &crowd);
        }
        // Open chains first, from each corner, so that a chain never starts in its middle; closed ones after.
        for corners_only in [true, false] {
            for e in mesh.edges() {
                let Some(k) = kind[e] else { continue };
                for start in mesh.ends(e) {
                    if graph.chain_of[e].is_none() && (!corners_only || graph.is_corner[start]) {
                        graph.walk(mesh, &at, k, start, e);
                    }
                }
            }
        }
        graph
    }

    /// Runs of vertices along the boundary, from a corner to another one, in which corners follow each other within half
    /// the reach; only those with several corners.
    fn crowds(
        &self,
        mesh: &TriMesh,
        kind: &EdgeMap<Option<FeatureKind>>,
        at: &VertexMap<Vec<EdgeId>>,
        reach: f64,
    ) -> Vec<Vec<VertexId>> {
        let mut crowds = Vec::new();
        if reach <= 0.0 {
            return crowds;
        }
        let is_plain = |v: VertexId| at[v].len() == 2 && at[v].iter().all(|&e| kind[e] == Some(FeatureKind::Boundary));
        for outline in boundary_loops(mesh) {
            let outline: Vec<VertexId> = outline.iter().map(|&h| mesh.origin(h)).collect();
            let n = outline.len();
            let corners: Vec<usize> = (0..n).filter(|&i| self.is_corner[outline[i]] && is_plain(outline[i])).collect();
            // 1. Vertices from each corner to the next one, if that is near.
            let link = |k: usize| -> Option<Vec<VertexId>> {
                let (from, to) = (corners[k], corners[(k + 1) % corners.len()]);
                let steps = if to > from { to - from } else { to + n - from };
                let run: Vec<VertexId> = (0..=steps).map(|i| outline[(from + i) % n]).collect();
                let length: f64 = run.windows(2).map(|w| mesh.position(w[0]).distance(mesh.position(w[1]))).sum();
                let is_free = run[1..steps].iter().all(|&v| !self.is_corner[v]);
                (length < CROWDED_REL * reach && is_free).then_some(run)
            };
            let links: Vec<Option<Vec<VertexId>>> = (0..corners.len()).map(link).collect();
            // 2. Those in a row, from one without a link before it; a loop of nothing but corners stays as it is.
            let Some(start) = links.iter().position(Option::is_none) else { continue };
            let mut crowd: Vec<VertexId> = Vec::new();
            for i in 1..=links.len() {
                match &links[(start + i) % links.len()] {
                    Some(run) => crowd.extend(&run[usize::from(!crowd.is_empty())..]),
                    None if !crowd.is_empty() => crowds.push(std::mem::take(&mut crowd)),
                    None => {}
                }
            }
        }
        crowds
    }

    /// Leaves a run of the boundary as many corners as it turns by right angles, the sharpest ones that turn its way:
    /// there is no room for quads between the others.
    fn thin_out(&mut self, mesh: &TriMesh, crowd: &[VertexId]) {
        let turn = |v: VertexId| {
            let angle = |h: HalfEdgeId| {
                let [o, a, b] = [h, mesh.next(h), mesh.prev(h)].map(|c| mesh.position(mesh.origin(c)));
                (a - o).angle_between(b - o)
            };
            PI - mesh.outgoing(v).map(angle).sum::<f64>()
        };
        let whole: f64 = crowd.iter().map(|&v| turn(v)).sum();
        let mut corners: Vec<(f64, VertexId)> =
            crowd.iter().filter(|&&v| self.is_corner[v]).map(|&v| (turn(v) * whole.signum(), v)).collect();
        corners.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let kept = (whole.abs() / FRAC_PI_2).round() as usize;
        for &(_, v) in corners.iter().skip(kept) {
            self.is_corner[v] = false;
        }
    }

    fn walk(&mut self, mesh: &TriMesh, at: &VertexMap<Vec<EdgeId>>, kind: FeatureKind, start: VertexId, first: EdgeId) {
        let id = self.chains.len() as ChainId;
        let (mut vertices, mut edge, mut closed) = (vec![start], first, false);
        loop {
            self.chain_of[edge] = Some(id);
            let v = other_end(mesh, edge, vertices[vertices.len() - 1]);
            if v == start {
                // A loop through one corner is an open chain whose two ends coincide.
                closed = !self.is_corner[start];
                if !closed {
                    vertices.push(v);
                }
                break;
            }
            vertices.push(v);
            if self.is_corner[v] {
                break;
            }
            match at[v].iter().find(|&&g| g != edge) {
                Some(&g) => edge = g,
                None => break,
            }
        }
        self.chains.push(FeatureChain { kind, vertices, closed });
    }

    /// Edges of the pieces of sharp edges that are not worth keeping.
    fn unwanted_edges(&self, mesh: &TriMesh, options: &FeatureOptions) -> Vec<EdgeId> {
        if options.min_loose_length <= 0.0 && options.min_piece_length <= 0.0 && options.min_contrast <= 0.0 {
            return Vec::new();
        }
        let piece = self.sharp_pieces(mesh);
        let count = piece.iter().flatten().max().map_or(0, |&last| last + 1);
        // 1. Length and open ends of every piece.
        let ends_at = self.chain_ends(mesh);
        let (mut length, mut loose, mut attached) = (vec![0.0; count], vec![false; count], vec![false; count]);
        let on_other = self.on_other_kinds(mesh);
        for (chain, &piece) in self.chains.iter().zip(&piece) {
            let Some(piece) = piece else { continue };
            let ends = [chain.vertices[0], chain.vertices[chain.vertices.len() - 1]];
            loose[piece] |= !chain.closed && ends.iter().any(|&v| ends_at[v] == 1);
            attached[piece] |= ends.iter().any(|&v| on_other[v]);
        }
        let piece_of = |e: EdgeId| piece[self.chain_of[e]? as usize];
        let (mut contrast, mut height) = (vec![Vec::new(); count], vec![Vec::new(); count]);
        let mut edges = vec![0; count];
        for e in mesh.edges() {
            if let Some(piece) = piece_of(e) {
                edges[piece] += 1;
                let [a, b] = mesh.ends(e).map(|v| mesh.position(v));
                length[piece] += a.distance(b);
                if loose[piece] && options.min_contrast > 0.0 {
                    contrast[piece].push(crease_contrast(mesh, e));
                    height[piece].push(least_height(mesh, e));
                }
            }
        }
        // 2. Too short, or no sharper than what is around it, unless that is facets.
        let median = |values: &mut Vec<f64>| {
            let middle = values.len() / 2;
            (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
        };
        let mut blurred = |i: usize| {
            median(&mut contrast[i]).is_some_and(|c| c < options.min_contrast)
                && median(&mut height[i]).is_some_and(|h| h < options.facet_height)
        };
        let mut unwanted: Vec<bool> = (0..count)
            .map(|i| {
                let short = length[i] < options.min_piece_length;
                let short_and_loose = loose[i] && length[i] < options.min_loose_length;
                (!attached[i] && (short || short_and_loose)) || (loose[i] && blurred(i))
            })
            .collect();
        // 3. Where they are few, the longer ones of them are kept after all.
        let lost: f64 = (0..count).filter(|&i| unwanted[i]).map(|i| length[i]).sum();
        if lost <= options.few_rel * length.iter().sum::<f64>() {
            for i in 0..count {
                let is_line = loose[i] && edges[i] > 1 && length[i] >= options.least_length;
                unwanted[i] &= !is_line;
            }
        }
        mesh.edges().filter(|&e| piece_of(e).is_some_and(|piece| unwanted[piece])).collect()
    }

    /// The connected piece of sharp chains that each chain belongs to, numbered by the smallest chain; `None` for chains
    /// of other kinds.
    fn sharp_pieces(&self, mesh: &TriMesh) -> Vec<Option<usize>> {
        fn root(parent: &mut [usize], mut i: usize) -> usize {
            while parent[i] != i {
                parent[i] = parent[parent[i]];
                i = parent[i];
            }
            i
        }
        let mut parent: Vec<usize> = (0..self.chains.len()).collect();
        let mut first_at: VertexMap<Option<usize>> = VertexMap::filled(mesh.vertex_count(), None);
        let is_sharp = |i: usize| self.chains[i].kind == FeatureKind::Sharp;
        for (i, chain) in self.chains.iter().enumerate().filter(|&(i, _)| is_sharp(i)) {
            for v in [chain.vertices[0], chain.vertices[chain.vertices.len() - 1]] {
                let j = *first_at[v].get_or_insert(i);
                let (a, b) = (root(&mut parent, i), root(&mut parent, j));
                parent[a.max(b)] = a.min(b);
            }
        }
        let mut number = vec![None; self.chains.len()];
        let mut count = 0;
        for i in (0..self.chains.len()).filter(|&i| is_sharp(i)) {
            let r = root(&mut parent, i);
            if r == i {
                number[i] = Some(count);
                count += 1;
            } else {
                number[i] = number[r];
            }
        }
        number
    }

    /// Vertices of chains that are not sharp edges, the boundary's for instance.
    fn on_other_kinds(&self, mesh: &TriMesh) -> VertexMap<bool> {
        let mut on = VertexMap::filled(mesh.vertex_count(), false);
        for chain in self.chains.iter().filter(|c| c.kind != FeatureKind::Sharp) {
            chain.vertices.iter().for_each(|&v| on[v] = true);
        }
        on
    }

    /// Ends of open chains of any kind at each vertex.
    fn chain_ends(&self, mesh: &TriMesh) -> VertexMap<u32> {
        let mut ends_at = VertexMap::filled(mesh.vertex_count(), 0);
        for chain in self.chains.iter().filter(|c| !c.closed) {
            for v in [chain.vertices[0], chain.vertices[chain.vertices.len() - 1]] {
                ends_at[v] += 1;
            }
        }
        ends_at
    }
}

/// How many times sharper an edge is than its surroundings: its dihedral angle over the mean, over its two faces, of the
/// smaller dihedral angle of the face's other two edges.
///
/// A crease between smooth surfaces has 30 and more; folds of noise and of coarsely sampled bends have 1 to 7. Angles
/// below one degree count as one degree.
fn crease_contrast(mesh: &TriMesh, e: EdgeId) -> f64 {
    let h = mesh.half_edge(e);
    let least = |h: HalfEdgeId| {
        let angle = |h: HalfEdgeId| if mesh.twin(h).is_some() { dihedral_angle(mesh, h) } else { 0.0 };
        angle(mesh.next(h)).min(angle(mesh.prev(h)))
    };
    let around = match mesh.twin(h) {
        Some(t) => 0.5 * (least(h) + least(t)),
        None => least(h),
    };
    dihedral_angle(mesh, h) / around.max(1f64.to_radians())
}

/// The least height of an edge's faces over it.
fn least_height(mesh: &TriMesh, e: EdgeId) -> f64 {
    let [a, b] = mesh.ends(e).map(|v| mesh.position(v));
    let height = |f: FaceId| 2.0 * mesh.vector_area(f).length() / a.distance(b).max(f64::MIN_POSITIVE);
    let (i, j) = mesh.edge_faces(e);
    height(i).min(j.map_or(f64::INFINITY, height))
}

/// Where a curve that leaves a vertex along an edge is after some length; its next vertex at least, its end at most.
fn point_along(mesh: &TriMesh, at: &VertexMap<Vec<EdgeId>>, start: VertexId, first: EdgeId, reach: f64) -> DVec3 {
    let (mut edge, mut v) = (first, other_end(mesh, first, start));
    let mut left = reach - mesh.position(start).distance(mesh.position(v));
    while left > 0.0 && v != start {
        let [a, b] = at[v][..] else { break };
        edge = if a == edge { b } else { a };
        let w = other_end(mesh, edge, v);
        let (p, q) = (mesh.position(v), mesh.position(w));
        let length = p.distance(q);
        if length >= left {
            return p.lerp(q, left / length);
        }
        left -= length;
        v = w;
    }
    mesh.position(v)
}

/// The end of `e` that is not `v`.
pub fn other_end(mesh: &TriMesh, e: EdgeId, v: VertexId) -> VertexId {
    let [a, b] = mesh.ends(e);
    if a == v { b } else { a }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes;
    use glam::DVec3;
    use std::collections::BTreeMap;

    #[test]
    fn most_folds_of_noise_are_no_creases_but_those_of_a_solid_are() {
        let options = FeatureOptions { min_contrast: 12.0, ..FeatureOptions::default() };
        let bracket = shapes::sample("bracket").expect("a sample");
        let (crisp, dropped) = FeatureGraph::detect(&bracket, &options);
        assert!(crisp.edge_count() > 0 && dropped == 0, "dropped {dropped} of {}", crisp.edge_count());
        // A sphere whose vertices move in and out at random has sharp edges everywhere and no crease.
        let sphere = shapes::sphere(1.0, 4);
        let rough = |v: VertexId| {
            let random = (f64::from(v.0) * 12.9898).sin() * 43_758.547;
            sphere.position(v) * (1.0 + 0.04 * (random - random.floor()))
        };
        let positions = sphere.vertices().map(rough).collect();
        let noisy = TriMesh::new(positions, &sphere.to_faces()).expect("the same connectivity");
        let (sharp, _) = FeatureGraph::detect(&noisy, &FeatureOptions::default());
        let (kept, dropped) = FeatureGraph::detect(&noisy, &options);
        assert!(sharp.edge_count() > 100 && dropped > 4 * kept.edge_count(), "{} {dropped}", kept.edge_count());
    }

    /// Chains cover every feature edge once, run between corners, and pass no corner inside.
    fn check(mesh: &TriMesh, graph: &FeatureGraph) {
        let mut covered: BTreeMap<EdgeId, ChainId> = BTreeMap::new();
        for (id, chain) in graph.chains.iter().enumerate() {
            let mut vertices = chain.vertices.clone();
            if chain.closed {
                assert!(vertices.iter().all(|&v| !graph.is_corner[v]));
                vertices.push(vertices[0]);
            } else {
                assert!(graph.is_corner[vertices[0]] && graph.is_corner[vertices[vertices.len() - 1]]);
                assert!(vertices[1..vertices.len() - 1].iter().all(|&v| !graph.is_corner[v]));
            }
            for w in vertices.windows(2) {
                let e = mesh.find_edge(w[0], w[1]).expect("neighbours");
                assert_eq!(covered.insert(e, id as ChainId), None, "an edge belongs to one chain");
            }
        }
        let expected = graph.chain_of.iter().filter_map(|(e, c)| c.map(|c| (e, c))).collect();
        assert_eq!(covered, expected);
    }

    #[test]
    fn a_cube_has_twelve_chains_and_eight_corners() {
        let mesh = shapes::cube(1.0, 5);
        let (graph, dropped) = FeatureGraph::detect(&mesh, &FeatureOptions::default());
        check(&mesh, &graph);
        assert_eq!((graph.chains.len(), dropped), (12, 0));
        assert!(graph.chains.iter().all(|c| c.vertices.len() == 6 && !c.closed && c.kind == FeatureKind::Sharp));
        assert_eq!(graph.is_corner.values().iter().filter(|&&c| c).count(), 8);
        let (smooth, _) =
            FeatureGraph::detect(&mesh, &FeatureOptions { sharp_angle: None, ..FeatureOptions::default() });
        assert_eq!(smooth.edge_count(), 0);
    }

    #[test]
    fn boundaries_are_closed_chains() {
        let mesh = shapes::plate_with_holes(0.3);
        let (graph, _) = FeatureGraph::detect(&mesh, &FeatureOptions::default());
        check(&mesh, &graph);
        // Five round holes; the outline has four corners and as many chains.
        assert_eq!(graph.chains.iter().filter(|c| c.closed).count(), 5);
        assert_eq!(graph.chains.len(), 9);
        assert!(graph.chains.iter().all(|c| c.kind == FeatureKind::Boundary));
    }

    #[test]
    fn saw_teeth_of_a_boundary_are_no_corners_at_the_size_of_quads() {
        // A strip whose lower rim goes up and down by 60°, between two square corners.
        let teeth = 20u32;
        let rim = (0..=teeth).map(|i| DVec3::new(f64::from(i), if i % 2 == 1 { 0.6 } else { 0.0 }, 0.0));
        let top = (0..=teeth).map(|i| DVec3::new(f64::from(i), 9.0, 0.0));
        let positions: Vec<DVec3> = rim.chain(top).collect();
        let n = teeth + 1;
        let faces: Vec<[u32; 3]> = (0..teeth).flat_map(|i| [[i, i + 1, n + i], [i + 1, n + i + 1, n + i]]).collect();
        let mesh = TriMesh::new(positions, &faces).unwrap();
        let corners = |boundary_reach: f64| {
            let options = FeatureOptions { boundary_reach, ..FeatureOptions::default() };
            let (graph, _) = FeatureGraph::detect(&mesh, &options);
            check(&mesh, &graph);
            graph.is_corner.values().iter().filter(|&&c| c).count()
        };
        assert!(corners(0.0) >= 19, "{}", corners(0.0));
        // Those within reach of the square corners see them turn.
        assert!((4..=8).contains(&corners(5.0)), "{}", corners(5.0));
    }

    #[test]
    fn a_thorn_beside_a_bend_of_the_boundary_is_one_corner_and_a_tab_two() {
        // The outline of a plate around a point inside, its right side bent inwards at (4, 0).
        let plate = |extra: &[[f64; 2]]| {
            let before = [[0.0, -4.0], [8.0, -4.0]];
            let outline: Vec<[f64; 2]> =
                before.iter().chain(extra).chain(&[[8.0, 4.0], [0.0, 4.0], [0.0, 0.0]]).copied().collect();
            let at = |&[x, y]: &[f64; 2]| DVec3::new(x, y, 0.0);
            let n = outline.len() as u32;
            let positions: Vec<DVec3> = outline.iter().chain(&[[2.0, 0.0]]).map(at).collect();
            let faces: Vec<[u32; 3]> = (0..n).map(|i| [i, (i + 1) % n, n]).collect();
            TriMesh::new(positions, &faces).unwrap()
        };
        let corners = |mesh: &TriMesh, boundary_reach: f64| {
            let options = FeatureOptions { boundary_reach, ..FeatureOptions::default() };
            let (graph, _) = FeatureGraph::detect(mesh, &options);
            check(mesh, &graph);
            mesh.vertices().filter(|&v| graph.is_corner[v]).map(|v| mesh.position(v)).collect::<Vec<_>>()
        };
        // A bend of a right angle with a thorn in it: its feet turn against its tip, all three see a corner.
        let thorn = plate(&[[4.0, -0.15], [4.3, 0.0], [4.0, 0.15]]);
        assert_eq!(corners(&thorn, 0.0).len(), 7);
        let left = corners(&thorn, 2.0);
        assert_eq!(left.len(), 5, "{left:?}");
        // The end of a narrow tab turns by two right angles.
        let tab = plate(&[[8.0, -0.15], [12.0, -0.15], [12.0, 0.15], [8.0, 0.15]]);
        assert_eq!(corners(&tab, 2.0).len(), 8);
    }

    #[test]
    fn a_loop_through_one_corner_is_open() {
        // One triangle with a sharp tip: the corner angle makes only the tip a corner.
        let positions = vec![DVec3::new(9.0, 0.0, 0.0), DVec3::new(0.0, 1.0, 0.0), DVec3::new(0.0, -1.0, 0.0)];
        let mesh = TriMesh::new(positions, &[[0, 1, 2]]).unwrap();
        let options = FeatureOptions { corner_angle: 120.0, ..FeatureOptions::default() };
        let (graph, _) = FeatureGraph::detect(&mesh, &options);
        check(&mesh, &graph);
        assert_eq!(graph.chains.len(), 1);
        assert_eq!(graph.chains[0].vertices.len(), 4);
    }

    #[test]
    fn short_loose_chains_are_dropped_and_attached_ones_kept() {
        let mesh = shapes::cylinder(1.0, 1.0, 12, 6);
        let along = |from: f64, to: f64| {
            let mesh = &mesh;
            EdgeMap::from_fn(mesh.edge_count(), move |e| {
                let [a, b] = mesh.ends(e).map(|v| mesh.position(v));
                let on_line = |p: DVec3| p.y.abs() < 1e-9 && p.x > 0.0 && p.z > from && p.z < to;
                match mesh.is_boundary_edge(e) {
                    true => Some(FeatureKind::Boundary),
                    false => (on_line(a) && on_line(b)).then_some(FeatureKind::Sharp),
                }
            })
        };
        let options = FeatureOptions { min_loose_length: 0.6, ..FeatureOptions::default() };
        let (loose, dropped) = FeatureGraph::from_kinds(&mesh, along(0.1, 0.6), &options);
        assert_eq!((loose.chains.len(), dropped), (2, 2));
        let (attached, dropped) = FeatureGraph::from_kinds(&mesh, along(-1.0, 0.6), &options);
        check(&mesh, &attached);
        assert_eq!((attached.chains.len(), dropped), (3, 0));
        let (long, dropped) = FeatureGraph::from_kinds(&mesh, along(0.1, 0.9), &options);
        check(&mesh, &long);
        assert_eq!((long.chains.len(), dropped), (3, 0));
    }

    #[test]
    fn short_loose_chains_are_kept_where_they_are_few() {
        let mesh = shapes::cube(1.0, 6);
        // The edges of the cube, and a line of so many edges in the middle of its top.
        let with_line = |count: f64| {
            EdgeMap::from_fn(mesh.edge_count(), |e| {
                let [a, b] = mesh.ends(e).map(|v| mesh.position(v));
                let on_line = |p: DVec3| p.z == 1.0 && p.x == 0.5 && p.y > 0.3 && p.y < 0.4 + count / 6.0;
                let sharp = dihedral_angle(&mesh, mesh.half_edge(e)) > 1.0 || (on_line(a) && on_line(b));
                sharp.then_some(FeatureKind::Sharp)
            })
        };
        let kept = |count: f64, few_rel: f64, least_length: f64| {
            let options = FeatureOptions { min_loose_length: 0.9, few_rel, least_length, ..FeatureOptions::default() };
            let (graph, dropped) = FeatureGraph::from_kinds(&mesh, with_line(count), &options);
            check(&mesh, &graph);
            (graph.chains.len() - 12, dropped)
        };
        assert_eq!(kept(2.0, 0.0, 0.0), (0, 2));
        // A third of an edge of the cube beside twelve of them.
        assert_eq!(kept(2.0, 0.05, 0.3), (1, 0));
        assert_eq!(kept(2.0, 0.02, 0.3), (0, 2));
        assert_eq!(kept(2.0, 0.05, 0.4), (0, 2));
        // A single edge is no line.
        assert_eq!(kept(1.0, 0.05, 0.0), (0, 1));
    }

    #[test]
    fn guides_meet_sharp_chains_at_corners() {
        let mesh = shapes::cube(1.0, 4);
        let kind = EdgeMap::from_fn(mesh.edge_count(), |e| {
            let [a, b] = mesh.ends(e).map(|v| mesh.position(v));
            let top = |p: DVec3| p.z == 1.0;
            if dihedral_angle(&mesh, mesh.half_edge(e)) > 1.0 {
                Some(FeatureKind::Sharp)
            } else {
                (top(a) && top(b) && a.x == 0.5 && b.x == 0.5).then_some(FeatureKind::Guide)
            }
        });
        let (graph, _) = FeatureGraph::from_kinds(&mesh, kind, &FeatureOptions::default());
        check(&mesh, &graph);
        assert_eq!(graph.chains.iter().filter(|c| c.kind == FeatureKind::Guide).count(), 1);
        assert_eq!(graph.chains.len(), 12 + 2 + 1);
    }
}
