//! Cross fields without collapsed sectors: between two features that meet, at least one quarter turn.
//!
//! In: a mesh, its features, constraints of a cross field. Out: a field and its report.
//! Holds: as few sectors as possible are left in which the map would have to fold; those are still found by
//! [`Charts::collapsed_sectors`](crate::Charts). Source: [Bommes2012] §8.2, moving a singularity by changing a period
//! jump, used where two feature edges meet at less than 45°: the smoothest field gives such a sector no quarter turn,
//! hence no quad.

use crate::charts::{Sector, sectors};
use quadloom_field::{
    CrossField, FieldConstraints, FieldError, FieldOptions, FieldReport, Transport, solve_cross_field, unspiralled,
};
use quadloom_mesh::{EdgeId, EdgeMap, FeatureGraph, HalfEdgeId, Progress, TriConnectivity, VertexId, VertexMap};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

/// Solves again at most this often; each time every sector that is still collapsed gets a quarter turn more.
const ROUNDS: u32 = 4;

/// Distance from the corner, in cancel distances, to which the quarter of index is moved that opens a sector, and within
/// which no other comes near: the energy draws it into the corner, where the map has no room for it.
const CLEARANCE: f64 = 6.0;

/// The same as a part of the shorter of the two features: where it ends there is no corner any more.
const CLEARANCE_OF_SIDE: f64 = 0.6;

/// Angle of a sector, radians, below which the quarter of index stays near the corner: at the tip of a hairpin it most
/// often leaves by the other side of a feature.
const NARROW: f64 = std::f64::consts::FRAC_PI_6;

/// Distance from the features, in cancel distances, below which a place in the sector is as crowded as its corner.
const LEAST_DEPTH: f64 = 0.5;

/// Part of the way to the quarter's place within which nothing comes near.
const KEPT_REL: f64 = 0.75;

/// The smoothest cross field that leaves room for a quad between any two features that meet, and around every tube.
///
/// # Errors     those of the cross field
/// # Cost       one solve, and one more per round in which a sector is collapsed, and for tubes that spiral
/// # Guarantees none where a user's prescription stands against it, or where a sector is a single triangle
pub fn solve_open_field(
    mesh: &TriConnectivity,
    transport: &Transport,
    length: &EdgeMap<f64>,
    features: &FeatureGraph,
    constraints: &FieldConstraints,
    options: &FieldOptions,
    progress: &Progress,
) -> Result<(CrossField, FieldReport), FieldError> {
    let corners = Corners::new(mesh, transport, length, features, constraints);
    let clear_of = mesh.vertices().filter(|&v| corners.on_feature[v]).collect();
    let options = FieldOptions { clear_of, ..options.clone() };
    let first = solve_cross_field(mesh, transport, length, constraints, &options, progress)?;
    let (field, report) = corners.opened(first, options.clone(), progress)?;
    let Some(jumps) = unspiralled(mesh, transport, features, &field) else { return Ok((field, report)) };
    // A turn may cost less energy than none: no search any more.
    let straight = FieldOptions { start_from: Some(jumps), local_search: false, ..options };
    let (field, FieldReport { energy, .. }) =
        solve_cross_field(mesh, transport, length, constraints, &straight, progress)?;
    Ok((field, FieldReport { energy, ..report }))
}

/// What is asked of a field at the corners of features.
struct Corners<'a> {
    mesh: &'a TriConnectivity,
    transport: &'a Transport,
    length: &'a EdgeMap<f64>,
    features: &'a FeatureGraph,
    constraints: &'a FieldConstraints,
    on_feature: VertexMap<bool>,
    /// Length of each chain, file units.
    chain_length: Vec<f64>,
}

impl<'a> Corners<'a> {
    fn new(
        mesh: &'a TriConnectivity,
        transport: &'a Transport,
        length: &'a EdgeMap<f64>,
        features: &'a FeatureGraph,
        constraints: &'a FieldConstraints,
    ) -> Self {
        let mut chain_length = vec![0.0; features.chains.len()];
        for (e, chain) in features.chain_of.iter() {
            chain.iter().for_each(|&c| chain_length[c as usize] += length[e]);
        }
        let on_feature = features.feature_vertices(mesh);
        Self { mesh, transport, length, features, constraints, on_feature, chain_length }
    }

    /// Sectors to which a field gives no quarter turn.
    fn collapsed(&self, field: &CrossField) -> Vec<Sector> {
        let mut all = sectors(self.mesh, self.length, self.transport, self.features, field);
        all.retain(|s| s.quarters <= 0);
        all
    }

    /// The best of several rounds of opening what is collapsed.
    fn opened(
        &self,
        start: (CrossField, FieldReport),
        mut options: FieldOptions,
        progress: &Progress,
    ) -> Result<(CrossField, FieldReport), FieldError> {
        let Self { mesh, transport, length, constraints, .. } = *self;
        let mut field = start;
        let mut collapsed = self.collapsed(&field.0);
        let (mut best, mut fewest) = (field.clone(), collapsed.len());
        for _ in 0..ROUNDS {
            collapsed.retain(|s| constraints.indices.iter().all(|i| i.0 != s.vertex) && !s.inside.is_empty());
            if collapsed.is_empty() {
                break;
            }
            // A quarter of index leaves the vertex through the sector, and none may come back that way.
            let mut jumps = field.0.clone();
            for sector in &collapsed {
                self.open(sector, &mut jumps, &mut options);
            }
            options.start_from = Some(jumps.period_jump);
            field = solve_cross_field(mesh, transport, length, constraints, &options, progress)?;
            collapsed = self.collapsed(&field.0);
            if collapsed.len() < fewest {
                (best, fewest) = (field.clone(), collapsed.len());
            }
        }
        Ok(best)
    }

    /// Moves a quarter of index out of a corner, and keeps the edges through which it would come back.
    fn open(&self, sector: &Sector, field: &mut CrossField, options: &mut FieldOptions) {
        let mesh = self.mesh;
        match self.wedge(sector, field, options.cancel_distance) {
            Some(wedge) => {
                wedge.open(mesh, sector.vertex, field);
                options.kept.extend(wedge.near.iter().flat_map(|&v| mesh.vertex_edges(v)));
            }
            None => match opening(mesh, self.transport, field, &sector.inside) {
                Some((e, amount)) => field.period_jump[e] += amount,
                None => return,
            },
        }
        options.kept.extend(sector.inside.iter().map(|&h| mesh.edge(h)));
    }

    /// The surroundings of a corner, if a singularity has room there.
    fn wedge(&self, sector: &Sector, field: &CrossField, cancel_distance: f64) -> Option<Wedge> {
        if sector.angle < NARROW {
            return None;
        }
        let length_of = |e: EdgeId| self.features.chain_of[e].map_or(0.0, |c| self.chain_length[c as usize]);
        let [a, b] = sides(self.mesh, sector).map(length_of);
        let reach = (CLEARANCE * cancel_distance).min(CLEARANCE_OF_SIDE * a.min(b));
        let index = |v: VertexId| field.index(self.mesh, self.transport, v);
        let wedge = Wedge::new(self.mesh, self.length, &self.on_feature, sector, reach, index)?;
        (wedge.depth >= LEAST_DEPTH * cancel_distance).then_some(wedge)
    }
}

/// The surroundings of a corner within one sector, up to the nearest features.
#[derive(Clone, Debug)]
struct Wedge {
    /// Edges from the corner to the nearest singular vertex of negative index, else to the vertex farthest from the
    /// features.
    path: Vec<EdgeId>,
    /// Vertices, not on features, that are nearer to the corner than most of that path and than singular vertices.
    near: Vec<VertexId>,
    /// Distance of the path's end from the features, file units; infinite if the quarter vanishes there.
    depth: f64,
}

impl Wedge {
    /// Looks around a corner; `None` if no vertex apart from the features is within reach, or none is farther than the
    /// vertices around the corner.
    ///
    /// # Input      reach: file units
    /// # Cost       O(n log n) of the vertices within reach
    fn new(
        mesh: &TriConnectivity,
        length: &EdgeMap<f64>,
        on_feature: &VertexMap<bool>,
        sector: &Sector,
        reach: f64,
        index: impl Fn(VertexId) -> i32,
    ) -> Option<Self> {
        // 1. Distances from the corner, through the sector.
        let first = sector.inside.iter().map(|&h| (length[mesh.edge(h)], mesh.target(h), mesh.edge(h)));
        let within = distances(mesh, length, first.filter(|&(d, v, _)| d <= reach && !on_feature[v]), |d, v| {
            d <= reach && !on_feature[v]
        });
        // 2. Distances from the features around, the corner included.
        let rim = within.keys().flat_map(|&v| mesh.outgoing(v)).filter(|&h| on_feature[mesh.target(h)]);
        let from_rim = rim.map(|h| (length[mesh.edge(h)], mesh.origin(h), mesh.edge(h)));
        let depth = distances(mesh, length, from_rim, |_, v| within.contains_key(&v));
        let deepest = depth.iter().max_by(|a, b| a.1.0.total_cmp(&b.1.0).then(b.0.cmp(a.0))).map(|d| *d.0)?;
        let singular = within.iter().map(|(&v, at)| (at.0, v, index(v))).filter(|s| s.2 != 0);
        let nearest = singular.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let (last, room) = match nearest.filter(|s| s.2 < 0) {
            Some(opposite) => (opposite.1, f64::INFINITY),
            None => (deepest, depth[&deepest].0),
        };
        // 3. The way there, and what is nearer.
        let most = KEPT_REL * nearest.map_or(f64::INFINITY, |s| s.0).min(within[&last].0);
        let near: Vec<VertexId> = within.iter().filter(|(_, at)| at.0 < most).map(|(&v, _)| v).collect();
        let (mut path, mut at) = (Vec::new(), last);
        while at != sector.vertex {
            let e = within.get(&at)?.1;
            path.push(e);
            at = other_end(mesh, e, at);
        }
        path.reverse();
        (path.len() > 1).then_some(Self { path, near, depth: room })
    }

    /// Moves a quarter of index from the corner to the end of the path.
    fn open(&self, mesh: &TriConnectivity, corner: VertexId, field: &mut CrossField) {
        let mut at = corner;
        for &e in &self.path {
            // Crossing the canonical half-edge is counter-clockwise around its target, which is the second end.
            field.period_jump[e] += if mesh.ends(e)[0] == at { -1 } else { 1 };
            at = other_end(mesh, e, at);
        }
    }
}

/// The two edges that bound a sector.
fn sides(mesh: &TriConnectivity, sector: &Sector) -> [EdgeId; 2] {
    let last = sector.inside.last().copied().unwrap_or(sector.first);
    [mesh.edge(sector.first), mesh.edge(mesh.prev(last))]
}

fn other_end(mesh: &TriConnectivity, e: EdgeId, v: VertexId) -> VertexId {
    let [a, b] = mesh.ends(e);
    if a == v { b } else { a }
}

/// Shortest distances along edges from some first steps, each with the edge it was reached by.
///
/// # Input      first: distance, vertex, edge; may: whether a vertex at a distance may be entered
fn distances(
    mesh: &TriConnectivity,
    length: &EdgeMap<f64>,
    first: impl Iterator<Item = (f64, VertexId, EdgeId)>,
    may: impl Fn(f64, VertexId) -> bool,
) -> BTreeMap<VertexId, (f64, EdgeId)> {
    // Positive numbers are ordered as their bits are.
    let entry = |(d, v, e): (f64, VertexId, EdgeId)| Reverse((d.to_bits(), v, e));
    let mut queue: BinaryHeap<_> = first.map(entry).collect();
    let mut reached = BTreeMap::new();
    while let Some(Reverse((bits, v, through))) = queue.pop() {
        if reached.contains_key(&v) {
            continue;
        }
        let d = f64::from_bits(bits);
        reached.insert(v, (d, through));
        for e in mesh.vertex_edges(v) {
            let (w, there) = (other_end(mesh, e, v), d + length[e]);
            if !reached.contains_key(&w) && may(there, w) {
                queue.push(entry((there, w, e)));
            }
        }
    }
    reached
}

/// The change of one period jump that gives a sector a quarter turn more and leaves the least turn on its edge.
///
/// # Input      inside: half-edges from the vertex, strictly inside the sector
fn opening(
    mesh: &TriConnectivity,
    transport: &Transport,
    field: &CrossField,
    inside: &[HalfEdgeId],
) -> Option<(EdgeId, i32)> {
    // A sector loses the turns met when it is walked counter-clockwise, those over the twins of its half-edges; a turn
    // falls by a quarter where the jump rises.
    let turn =
        |h: HalfEdgeId| mesh.twin(h).map(|t| (field.turn(mesh, transport, t), mesh.half_edge(mesh.edge(h)) == t));
    let most =
        inside.iter().filter_map(|&h| Some((h, turn(h)?))).max_by(|a, b| a.1.0.total_cmp(&b.1.0).then(b.0.cmp(&a.0)));
    most.map(|(h, (_, is_canonical))| (mesh.edge(h), if is_canonical { 1 } else { -1 }))
}
