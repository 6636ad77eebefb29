//! Charts: the mesh cut to a disk, the cross field combed on it, one parameter node per vertex and sector.
//!
//! In: a triangle mesh, its features, a cross field. Out: [`Charts`].
//! Holds: off the seams the combed field matches itself without a turn; every singular vertex lies on a seam;
//! corners of a vertex share a node unless a seam separates them.
//! Source: [Bommes2012] §8.4, "Cutting the mesh" and "Cross boundary compatibility".
//!
//! ```text
//!       left chart        h: v0 → v1 is the seam side whose face is "left"; its twin's face is "right"
//!   v0 ─────h────▶ v1     right = Rot90^turns · left + translation of the segment
//!       right chart
//! ```

use quadloom_field::{CrossField, Transport};
use quadloom_mesh::topology::cut_graph;
use quadloom_mesh::{
    CornerMap, EdgeMap, FaceId, FaceMap, FeatureGraph, HalfEdgeId, HalfEdgeMap, TriConnectivity, VertexId, VertexMap,
    metric,
};
use std::collections::VecDeque;
use std::f64::consts::FRAC_PI_2;

/// A run of seam edges with one transition function.
#[derive(Clone, Debug)]
pub struct SeamSegment {
    /// Seam sides in order; the face of each is on the left.
    pub sides: Vec<HalfEdgeId>,
    /// Quarter turns from the left charts to the right ones.
    pub quarter_turns: u8,
}

/// A mesh cut open along seams, with a combed cross field.
#[derive(Clone, Debug)]
pub struct Charts {
    /// Direction of the cross that is the u axis of each face's chart, 0..4.
    pub axis: FaceMap<u8>,
    /// Quarter turns from the chart of a half-edge's face to the chart across; 0 off the seams and on the boundary.
    pub quarter_turns: HalfEdgeMap<u8>,
    /// Edges on the seams; boundary edges are none.
    pub is_seam: EdgeMap<bool>,
    /// The seams as runs of edges.
    pub segments: Vec<SeamSegment>,
    /// Parameter node of each corner.
    pub node: CornerMap<u32>,
    /// Number of nodes.
    pub node_count: usize,
    /// Direction of each feature edge's canonical half-edge in its chart: quarter turns from the u axis.
    pub feature_axis: EdgeMap<Option<u8>>,
    /// Vertices that must be integer points: singular ones, corners, irregular feature vertices.
    pub is_integer: VertexMap<bool>,
    /// Singular interior vertices with their index in quarters, ascending.
    pub singular: Vec<(VertexId, i32)>,
    /// Sectors between two feature edges that the field gives no quarter turn: the map has to fold there.
    pub collapsed_sectors: Vec<VertexId>,
    /// Sectors of three quarter turns and more, ascending by vertex.
    pub wide_sectors: Vec<Sector>,
    /// One face per component, ascending.
    pub roots: Vec<FaceId>,
}

impl Charts {
    /// Cuts the mesh and combs the field.
    ///
    /// # Input      `angle`: corner angles, radians; `length`: edge lengths, file units
    /// # Cost       near linear
    pub fn new(
        mesh: &TriConnectivity,
        length: &EdgeMap<f64>,
        transport: &Transport,
        features: &FeatureGraph,
        field: &CrossField,
    ) -> Self {
        // 1. Matching of the raw field across every half-edge.
        let matching = HalfEdgeMap::from_fn(mesh.half_edge_count(), |h| field.matching(mesh, h));
        let singular = field.singularities(mesh, transport);
        // 2. Seams through all singular vertices, away from features where that is cheap.
        let cones: Vec<VertexId> = singular.iter().map(|s| s.0).collect();
        let weight = EdgeMap::from_fn(mesh.edge_count(), |e| length[e]);
        let mut is_seam = cut_graph(mesh, &weight, &cones);
        for e in mesh.edges() {
            is_seam[e] &= !mesh.is_boundary_edge(e);
        }
        // 3. Comb: breadth first from a root per component, never across a seam.
        let (axis, roots) = comb(mesh, &matching, &is_seam);
        let quarter_turns = HalfEdgeMap::from_fn(mesh.half_edge_count(), |h| match mesh.twin(h) {
            Some(t) => (axis[mesh.face(h)] + matching[h] + 4 - axis[mesh.face(t)]) % 4,
            None => 0,
        });
        // A turn off the seams cannot happen when the cut is a disk through all cones; keep the map seamless anyway.
        for h in mesh.half_edges() {
            if quarter_turns[h] != 0 {
                is_seam[mesh.edge(h)] = true;
            }
        }
        // 4. Nodes, integer vertices, segments.
        let (node, node_count) = number_nodes(mesh, &is_seam);
        let relative = |h: HalfEdgeId| transport.direction(h) - field.angle[mesh.face(h)];
        let feature_axis = EdgeMap::from_fn(mesh.edge_count(), |e| {
            features.is_feature(e).then(|| {
                let h = mesh.half_edge(e);
                (quarter(relative(h)) + 4 - axis[mesh.face(h)]) % 4
            })
        });
        let mut sectors = sectors(mesh, length, transport, features, field);
        let (mut is_integer, collapsed_sectors) = feature_sectors(features, &sectors);
        sectors.retain(|s| s.quarters >= 3);
        for &v in &cones {
            is_integer[v] = true;
        }
        let segments = collect_segments(mesh, &is_seam, &quarter_turns, &is_integer);
        Self {
            axis,
            quarter_turns,
            is_seam,
            segments,
            node,
            node_count,
            feature_axis,
            is_integer,
            singular,
            collapsed_sectors,
            wide_sectors: sectors,
            roots,
        }
    }
}

/// A sector between two neighbouring feature edges at a vertex.
#[derive(Clone, Debug)]
pub struct Sector {
    /// The vertex.
    pub vertex: VertexId,
    /// Its clockwise-most corner.
    pub first: HalfEdgeId,
    /// Half-edges from the vertex strictly inside the sector, counter-clockwise.
    pub inside: Vec<HalfEdgeId>,
    /// Its angle, radians.
    pub angle: f64,
    /// Quarter turns that the field gives it.
    pub quarters: i64,
}

fn quarter(angle: f64) -> u8 {
    ((angle / FRAC_PI_2).round() as i64).rem_euclid(4) as u8
}

fn comb(mesh: &TriConnectivity, matching: &HalfEdgeMap<u8>, is_seam: &EdgeMap<bool>) -> (FaceMap<u8>, Vec<FaceId>) {
    let mut axis: FaceMap<Option<u8>> = FaceMap::filled(mesh.face_count(), None);
    let mut reached = FaceMap::filled(mesh.face_count(), false);
    let mut roots = Vec::new();
    let mut queue = VecDeque::new();
    for root in mesh.faces() {
        if axis[root].is_some() {
            continue;
        }
        axis[root] = Some(0);
        queue.push_back(root);
        while let Some(f) = queue.pop_front() {
            for h in mesh.face_half_edges(f) {
                let Some(t) = mesh.twin(h).filter(|_| !is_seam[mesh.edge(h)]) else { continue };
                let g = mesh.face(t);
                if axis[g].is_none() {
                    axis[g] = Some((axis[f].unwrap_or(0) + matching[h]) % 4);
                    queue.push_back(g);
                }
            }
        }
        // Components are counted across seams.
        if !reached[root] {
            roots.push(root);
            reached[root] = true;
            let mut stack = vec![root];
            while let Some(f) = stack.pop() {
                for h in mesh.face_half_edges(f) {
                    if let Some(t) = mesh.twin(h)
                        && !reached[mesh.face(t)]
                    {
                        reached[mesh.face(t)] = true;
                        stack.push(mesh.face(t));
                    }
                }
            }
        }
    }
    (axis.map(|a| a.unwrap_or(0)), roots)
}

/// Corners of a vertex share a node up to the next seam.
fn number_nodes(mesh: &TriConnectivity, is_seam: &EdgeMap<bool>) -> (CornerMap<u32>, usize) {
    let mut node = CornerMap::filled(mesh.half_edge_count(), u32::MAX);
    let mut count = 0u32;
    for v in mesh.vertices() {
        let fan: Vec<HalfEdgeId> = mesh.outgoing(v).collect();
        let start = fan.iter().position(|&h| is_seam[mesh.edge(h)] || mesh.twin(h).is_none()).unwrap_or(0);
        for i in 0..fan.len() {
            let h = fan[(start + i) % fan.len()];
            if i == 0 || is_seam[mesh.edge(h)] || mesh.twin(h).is_none() {
                count += 1;
            }
            node[h] = count - 1;
        }
    }
    (node, count as usize)
}

/// All sectors at feature vertices, ascending by vertex.
///
/// The parameter angle of a sector is the sum of its corner angles and of the field's residual turns
/// θ_i + κ_ij + π/2·p_ij − θ_j; for a field aligned to both its sides it is a whole number of quarter turns.
///
/// # Input      `length`: of every edge, file units
/// # Cost       linear
pub fn sectors(
    mesh: &TriConnectivity,
    length: &EdgeMap<f64>,
    transport: &Transport,
    features: &FeatureGraph,
    field: &CrossField,
) -> Vec<Sector> {
    let angle = metric::corner_angles(mesh, length);
    let mut sectors: Vec<Sector> = Vec::new();
    for v in mesh.vertices() {
        let fan: Vec<HalfEdgeId> = mesh.outgoing(v).collect();
        let Some(start) = fan.iter().position(|&h| features.is_feature(mesh.edge(h))) else { continue };
        let (mut sum, mut wide) = (0.0, 0.0);
        let (mut inside, mut first) = (Vec::new(), fan[start]);
        for i in 0..fan.len() {
            let h = fan[(start + i) % fan.len()];
            if let Some(t) = mesh.twin(h).filter(|_| !features.is_feature(mesh.edge(h))) {
                // Crossing from the clockwise neighbour t into the face of h.
                sum -= field.turn(mesh, transport, t);
                inside.push(h);
            }
            sum += angle[h];
            wide += angle[h];
            let next = mesh.edge(mesh.prev(h));
            if features.is_feature(next) || mesh.is_boundary_edge(next) || i + 1 == fan.len() {
                let quarters = (sum / FRAC_PI_2).round() as i64;
                sectors.push(Sector { vertex: v, first, inside: std::mem::take(&mut inside), angle: wide, quarters });
                (sum, wide) = (0.0, 0.0);
                first = fan[(start + i + 1) % fan.len()];
            }
        }
    }
    sectors
}

/// Marks feature vertices that are not passed straight through, and those with a sector without a quarter turn.
fn feature_sectors(features: &FeatureGraph, sectors: &[Sector]) -> (VertexMap<bool>, Vec<VertexId>) {
    let mut is_integer = features.is_corner.clone();
    let mut collapsed = Vec::new();
    for sector in sectors {
        if sector.quarters != 2 {
            is_integer[sector.vertex] = true;
        }
        if sector.quarters <= 0 && collapsed.last() != Some(&sector.vertex) {
            collapsed.push(sector.vertex);
        }
    }
    (is_integer, collapsed)
}

fn collect_segments(
    mesh: &TriConnectivity,
    is_seam: &EdgeMap<bool>,
    quarter_turns: &HalfEdgeMap<u8>,
    is_integer: &VertexMap<bool>,
) -> Vec<SeamSegment> {
    let mut degree = VertexMap::filled(mesh.vertex_count(), 0u32);
    for e in mesh.edges().filter(|&e| is_seam[e]) {
        for v in mesh.ends(e) {
            degree[v] += 1;
        }
    }
    let ends_here = |v: VertexId| degree[v] != 2 || is_integer[v] || mesh.is_boundary_vertex(v);
    let mut done = EdgeMap::filled(mesh.edge_count(), false);
    let mut segments = Vec::new();
    for anywhere in [false, true] {
        for h0 in mesh.half_edges() {
            let e0 = mesh.edge(h0);
            if !is_seam[e0] || done[e0] || !(anywhere || ends_here(mesh.origin(h0))) {
                continue;
            }
            let mut sides = vec![h0];
            done[e0] = true;
            let mut h = h0;
            while !ends_here(mesh.target(h)) {
                let v = mesh.target(h);
                let next = mesh
                    .outgoing(v)
                    .find(|&g| is_seam[mesh.edge(g)] && !done[mesh.edge(g)] && quarter_turns[g] == quarter_turns[h0]);
                let Some(g) = next else { break };
                done[mesh.edge(g)] = true;
                sides.push(g);
                h = g;
            }
            segments.push(SeamSegment { sides, quarter_turns: quarter_turns[h0] });
        }
    }
    segments
}
