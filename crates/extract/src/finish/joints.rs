//! Vertices on curves settle on the joints of coarse polylines, so that no chord cuts one off.
//!
//! In: a [`State`] whose vertices lie on their curves. Out: the same with some of them on joints, pinned there.
//! Holds: the order along the curve; no quad gets worse below the floor. Source: own; the choice of joints is a shortest
//! path through the places that each vertex can go to, as in optimal polygonal approximation.

use super::state::State;
use super::sweep::{Aim, sweep};
use super::ties::{Move, Tie};
use quadloom_mesh::closest::closest_parameter;
use quadloom_mesh::{Cancelled, ChainId, DVec3, Progress, VertexId};

/// Distance of a joint from the chord that passes it, relative to the mean quad edge, from which it counts as cut off.
///
/// A circle of 40 edges has 0.02. Smaller: vertices are pinned for nothing; larger: corners are cut off.
const LEAST_CUT_REL: f64 = 0.02;

/// A vertex moves at most this part of the way to its neighbours.
const REACH_REL: f64 = 0.9;

/// Two neighbours come no nearer to each other than this, relative to their distance before; sweeps space them again.
///
/// Larger: a vertex half way between two joints, with one beside it that stays, reaches neither. Smaller: short edges.
const LEAST_GAP_REL: f64 = 0.35;

/// Cost of moving a vertex by a mean quad edge, in squares of cuts relative to that edge.
///
/// Larger: small cuts stay; smaller: vertices move far for little.
const SHIFT_COST: f64 = 2e-3;

/// Joints at most that a vertex chooses from; those that stick out farthest.
const MOST_PLACES: usize = 8;

/// Strides in which vertices go to their joints; the others make room after each.
const STRIDES: usize = 2;

/// A point of a curve, by its length from the curve's start; on closed curves it may be beyond either end.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub arc: f64,
    pub position: DVec3,
}

/// A vertex on a curve, or an end of the curve, with the places it can go to; the first one is where it is.
pub(super) struct Stop {
    pub vertex: Option<VertexId>,
    pub places: Vec<Place>,
}

/// Where a vertex is to go.
struct Goal {
    vertex: VertexId,
    chain: ChainId,
    from: f64,
    to: Place,
    /// Whether it is a joint that sticks out, where the vertex is to stay.
    is_joint: bool,
}

/// Moves vertices onto joints so that the quads' edges cut off as little as possible; returns how many were pinned.
///
/// # Input      edge: mean edge length of the quads, file units; floor: scaled Jacobian down to which quads may get worse
/// # Errors     cancellation
/// # Cost       near linear in the joints and vertices of the curves, and a few sweeps if any is cut off
pub(crate) fn settle_on_joints(
    state: &mut State,
    edge: f64,
    floor: f64,
    aim: Aim,
    progress: &Progress,
) -> Result<usize, Cancelled> {
    // 1. Who goes where.
    let own = stops_by_chain(state);
    let mut goals: Vec<Goal> = Vec::new();
    for (chain, own) in own.into_iter().enumerate() {
        goals.extend(Curve::new(state, chain as ChainId, edge).goals(own));
    }
    if goals.is_empty() {
        return Ok(0);
    }
    // 2. In strides; who is on the way, or stays, is not swept away.
    for goal in &goals {
        state.pinned[goal.vertex] = true;
    }
    for left in (1..=STRIDES).rev() {
        progress.check()?;
        let mut moves: Vec<Option<Move>> = vec![None; state.quads.vertex_count()];
        for goal in &goals {
            moves[goal.vertex.index()] = stride(state, goal, left);
        }
        state.advance(&moves, floor);
        if left > 1 {
            sweep(state, aim);
        }
    }
    // 3. Who did not arrive is free again.
    let mut pinned = 0;
    for goal in &goals {
        let moved = goal.to.arc != goal.from;
        let there = goal.is_joint && state.position[goal.vertex] == goal.to.position;
        state.pinned[goal.vertex] = there;
        pinned += usize::from(there && moved);
    }
    Ok(pinned)
}

/// The next of so many strides that are left.
fn stride(state: &State, goal: &Goal, left: usize) -> Option<Move> {
    let Tie::Curve { chain, .. } = state.tie[goal.vertex] else { return None };
    let curves = &state.reference.curves;
    let there = curves.at(chain, goal.from + (goal.to.arc - goal.from) * (1.0 - (left - 1) as f64 / STRIDES as f64));
    let position = if left == 1 { goal.to.position } else { there.position };
    (chain == goal.chain).then_some(Move { position, tie: Tie::Curve { chain, arc: there.arc } })
}

/// The vertices on each curve, ascending by length, then by id.
pub(super) fn stops_by_chain(state: &State) -> Vec<Vec<(f64, VertexId)>> {
    let mut stops: Vec<Vec<(f64, VertexId)>> = vec![Vec::new(); state.reference.curves.len()];
    for v in state.quads.vertices() {
        if let Tie::Curve { chain, arc } = state.tie[v] {
            stops[chain as usize].push((arc, v));
        }
    }
    stops.iter_mut().for_each(|list| list.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))));
    stops
}

/// A curve of the surface and its joints.
pub(super) struct Curve<'a> {
    state: &'a State<'a>,
    chain: ChainId,
    /// Ascending; those of a closed curve once more before and behind it.
    joints: Vec<Place>,
    edge: f64,
}

impl<'a> Curve<'a> {
    pub(super) fn new(state: &'a State<'a>, chain: ChainId, edge: f64) -> Self {
        let curves = &state.reference.curves;
        let total = curves.length(chain);
        let rounds: &[f64] = if curves.is_closed(chain) { &[-1.0, 0.0, 1.0] } else { &[0.0] };
        let round =
            |&k: &f64| curves.joints(chain).map(move |(arc, position)| Place { arc: arc + k * total, position });
        Self { state, chain, joints: rounds.iter().flat_map(round).collect(), edge }
    }

    /// Where the vertices are to go that are not pinned; nowhere if nothing is cut off.
    fn goals(&self, own: Vec<(f64, VertexId)>) -> Vec<Goal> {
        let stops = self.stops(own);
        let is_cut = |w: &[Stop]| self.cut(w[0].places[0], w[1].places[0]) > LEAST_CUT_REL * self.edge;
        if !stops.windows(2).any(is_cut) {
            return Vec::new();
        }
        let stops = self.with_places(stops);
        let chosen = cheapest(&stops, self.is_closed(), |from, to| self.piece_costs(from, to));
        let goal = |(stop, place): (&Stop, usize)| {
            let vertex = stop.vertex.filter(|&v| !self.state.pinned[v])?;
            let (from, to) = (stop.places[0].arc, stop.places[place]);
            Some(Goal { vertex, chain: self.chain, from, to, is_joint: place > 0 || self.is_joint(to) })
        };
        // The first vertex of a closed curve comes once more at the end.
        let count = stops.len() - usize::from(self.is_closed());
        stops.iter().zip(chosen).take(count).filter_map(goal).collect()
    }

    pub(super) fn is_closed(&self) -> bool {
        self.state.reference.curves.is_closed(self.chain)
    }

    /// The vertices where they are, between the ends of an open curve; a closed one ends with its first vertex.
    pub(super) fn stops(&self, own: Vec<(f64, VertexId)>) -> Vec<Stop> {
        let curves = &self.state.reference.curves;
        let total = curves.length(self.chain);
        let stop = |(arc, v): (f64, VertexId)| Stop {
            vertex: Some(v),
            places: vec![Place { arc, position: self.state.position[v] }],
        };
        let end = |arc: f64| Stop {
            vertex: None,
            places: vec![Place { arc, position: curves.at(self.chain, arc).position }],
        };
        if self.is_closed() {
            let again = own.first().map(|&(arc, v)| (arc + total, v));
            return own.into_iter().chain(again).map(stop).collect();
        }
        std::iter::once(end(0.0)).chain(own.into_iter().map(stop)).chain([end(total)]).collect()
    }

    /// The joints between two places.
    pub(super) fn between(&self, a: Place, b: Place) -> &[Place] {
        let from = self.joints.partition_point(|j| j.arc <= a.arc);
        let to = self.joints.partition_point(|j| j.arc < b.arc);
        &self.joints[from..to.max(from)]
    }

    /// Distance of the curve from the chord between two places, file units.
    pub(super) fn cut(&self, a: Place, b: Place) -> f64 {
        let off = |j: &Place| {
            let t = closest_parameter(a.position, b.position, j.position);
            a.position.lerp(b.position, t).distance(j.position)
        };
        self.between(a, b).iter().map(off).fold(0.0, f64::max)
    }

    /// Whether a place is a joint that sticks out.
    fn is_joint(&self, place: Place) -> bool {
        let near = self.joints.partition_point(|j| j.arc < place.arc);
        let is_here = |j: &Place| j.position == place.position;
        self.joints[near.saturating_sub(1)..].iter().take(3).any(is_here) && self.sticks_out(place)
    }

    pub(super) fn sticks_out(&self, joint: Place) -> bool {
        self.bulge(joint) > 0.5 * LEAST_CUT_REL * self.edge
    }

    /// How far a joint sticks out of the curve at the size of quads, file units.
    pub(super) fn bulge(&self, joint: Place) -> f64 {
        let curves = &self.state.reference.curves;
        let [a, b] = [-0.5, 0.5].map(|k| curves.at(self.chain, joint.arc + k * self.edge).position);
        a.lerp(b, closest_parameter(a, b, joint.position)).distance(joint.position)
    }

    /// Adds the joints within reach of each vertex that is free to move.
    fn with_places(&self, mut stops: Vec<Stop>) -> Vec<Stop> {
        let arcs: Vec<f64> = stops.iter().map(|s| s.places[0].arc).collect();
        let total = self.state.reference.curves.length(self.chain);
        let last = stops.len() - 1;
        for (i, stop) in stops.iter_mut().enumerate() {
            if stop.vertex.is_none_or(|v| self.state.pinned[v]) {
                continue;
            }
            // Neighbours across the start of a closed curve; the ends of an open one are no vertices.
            let before = if i > 0 { arcs[i - 1] } else { arcs[last - 1] - total };
            let after = if i < last { arcs[i + 1] } else { arcs[1] + total };
            let own = stop.places[0];
            let from = Place { arc: own.arc + REACH_REL * (before - own.arc), ..own };
            let to = Place { arc: own.arc + REACH_REL * (after - own.arc), ..own };
            let mut within: Vec<(f64, Place)> = self.between(from, to).iter().map(|&j| (self.bulge(j), j)).collect();
            within.retain(|&(_, j)| self.sticks_out(j) && j.position != own.position);
            within.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.arc.total_cmp(&b.1.arc)));
            stop.places.extend(within.into_iter().take(MOST_PLACES).map(|w| w.1));
        }
        if self.is_closed() {
            // The copy has the same places in the same order, one round further.
            stops[last].places = stops[0].places.iter().map(|p| Place { arc: p.arc + total, ..*p }).collect();
        }
        stops
    }

    /// Cost of the chord between any place of a stop and any of the next one, the way of the latter included.
    fn piece_costs(&self, from: &Stop, to: &Stop) -> Vec<Vec<f64>> {
        let least_gap = LEAST_GAP_REL * (to.places[0].arc - from.places[0].arc);
        let cost = |i: usize, j: usize| {
            let (a, b) = (from.places[i], to.places[j]);
            if (i, j) != (0, 0) && b.arc - a.arc < least_gap {
                return f64::INFINITY;
            }
            let cut = self.cut(a, b) / self.edge;
            let way = (b.arc - to.places[0].arc) / self.edge;
            SHIFT_COST * way * way + if cut > LEAST_CUT_REL { cut * cut } else { 0.0 }
        };
        (0..from.places.len()).map(|i| (0..to.places.len()).map(|j| cost(i, j)).collect()).collect()
    }
}

/// The choice of a place for each stop that costs least, by the costs of the pieces between two stops.
///
/// Equal costs are decided by the earlier place.
pub(super) fn cheapest(
    stops: &[Stop],
    closed: bool,
    piece_costs: impl Fn(&Stop, &Stop) -> Vec<Vec<f64>>,
) -> Vec<usize> {
    let pieces: Vec<Vec<Vec<f64>>> = stops.windows(2).map(|w| piece_costs(&w[0], &w[1])).collect();
    let starts = if closed { stops[0].places.len() } else { 1 };
    let mut best = (f64::INFINITY, vec![0; stops.len()]);
    for start in 0..starts {
        // 1. Least cost to each place of each stop, and the place before.
        let mut cost: Vec<f64> = vec![f64::INFINITY; stops[0].places.len()];
        cost[start] = 0.0;
        let mut before: Vec<Vec<usize>> = Vec::with_capacity(pieces.len());
        for piece in &pieces {
            let cheapest = |to: usize| {
                let from = |i: usize| cost[i] + piece[i][to];
                let i = (1..cost.len()).fold(0, |least, i| if from(i) < from(least) { i } else { least });
                (from(i), i)
            };
            let next: Vec<(f64, usize)> = (0..piece[0].len()).map(cheapest).collect();
            before.push(next.iter().map(|n| n.1).collect());
            cost = next.into_iter().map(|n| n.0).collect();
        }
        // 2. A closed curve ends in the place where it started.
        let end = if closed { start } else { 0 };
        if cost[end] < best.0 {
            let mut places = vec![end];
            for back in before.iter().rev() {
                places.push(back[places[places.len() - 1]]);
            }
            places.reverse();
            best = (cost[end], places);
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use crate::extraction::{ExtractReport, Extraction, Placement};
    use crate::finish::{FinishOptions, finish};
    use crate::reference::Reference;
    use quadloom_mesh::features::FeatureOptions;
    use quadloom_mesh::{
        DVec3, EdgeMap, FaceId, FaceMap, FeatureGraph, Progress, QuadMesh, SurfacePoint, TriMesh, VertexId, VertexMap,
    };

    /// A roof-shaped plate under three quads, none of whose vertices is at the ridge to begin with.
    #[test]
    fn a_vertex_goes_to_the_joint_of_a_coarse_boundary() {
        let at = |x: f64, y: f64| DVec3::new(x, y, 0.0);
        let ridge = at(1.3, 1.35);
        let points = vec![at(0.0, 0.0), at(1.3, 0.0), at(3.0, 0.0), at(0.0, 1.0), ridge, at(3.0, 1.0)];
        let plate = TriMesh::new(points, &[[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]]).expect("a plate");
        let (features, _) = FeatureGraph::detect(&plate, &FeatureOptions::default());
        assert!(!features.is_corner[VertexId(4)]);
        let reference = Reference::new(&plate, &features);
        // Four vertices below, four on the upper boundary.
        let top = |x: f64| at(x, if x < 1.3 { 1.0 + 0.35 * x / 1.3 } else { 1.0 + 0.35 * (3.0 - x) / 1.7 });
        let place = |i: usize| if i < 4 { at(i as f64, 0.0) } else { top((i - 4) as f64) };
        let positions: Vec<DVec3> = (0..8).map(place).collect();
        let mesh = QuadMesh::new(positions, &[[0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6]]).expect("three quads");
        let chain_at = |p: DVec3| reference.curves.query_any(p).expect("a boundary").chain;
        let placement = VertexMap::from_fn(8, |v: VertexId| match v.0 % 4 {
            0 | 3 => Placement::Corner(v),
            _ => Placement::Chain {
                chain: chain_at(mesh.position(v)),
                edge: plate.edges().next().unwrap(),
                parameter: 0.0,
            },
        });
        let feature_edges = EdgeMap::from_fn(mesh.edge_count(), |e| {
            let [a, b] = mesh.ends(e).map(|v| mesh.position(v));
            mesh.is_boundary_edge(e).then(|| chain_at(a.midpoint(b)))
        });
        let quads = Extraction {
            origin: VertexMap::filled(8, SurfacePoint { face: FaceId(0), weights: [1.0, 0.0, 0.0] }),
            placement,
            feature_edges,
            grid: FaceMap::filled(3, None),
            report: ExtractReport::default(),
            mesh,
        };
        let finished = finish(&quads, &reference, &FinishOptions::default(), &Progress::none()).expect("finished");
        assert_eq!(finished.report.pinned, 1);
        assert_eq!(finished.mesh.position(VertexId(5)), ridge);
        // The others stay on their curves, in their order.
        for v in [VertexId(1), VertexId(2), VertexId(6)] {
            assert!(reference.curves.query_any(finished.mesh.position(v)).expect("a boundary").distance < 1e-12);
        }
        assert!(finished.mesh.position(VertexId(6)).x > 1.3);
    }

    /// Three teeth side by side above three quads: the vertices between the quads have to move the same way.
    #[test]
    fn vertices_make_room_for_each_other_on_a_saw() {
        let at = |x: f64, y: f64| DVec3::new(x, y, 0.0);
        let rim = [at(0.0, 2.0), at(0.7, 2.3), at(1.5, 2.0), at(2.3, 2.3), at(3.0, 2.0)];
        let points: Vec<DVec3> = rim.iter().copied().chain([at(0.0, 0.0), at(3.0, 0.0)]).collect();
        let plate = TriMesh::new(points, &[[5, 1, 0], [5, 2, 1], [5, 6, 2], [6, 3, 2], [6, 4, 3]]).expect("a plate");
        let (features, _) = FeatureGraph::detect(&plate, &FeatureOptions::default());
        let reference = Reference::new(&plate, &features);
        let on_rim = |x: f64| {
            let k = (1..4).find(|&k| x <= rim[k].x).unwrap_or(4);
            let t = (x - rim[k - 1].x) / (rim[k].x - rim[k - 1].x);
            rim[k - 1].lerp(rim[k], t)
        };
        let positions: Vec<DVec3> = (0..5)
            .map(|i| at(0.75 * f64::from(i), 0.0))
            .chain((0..5).map(|i| on_rim(0.75 * f64::from(i) + if i % 4 == 0 { 0.0 } else { 0.35 })))
            .collect();
        let mesh = QuadMesh::new(positions, &[[0, 1, 6, 5], [1, 2, 7, 6], [2, 3, 8, 7], [3, 4, 9, 8]]).expect("quads");
        let chain_at = |p: DVec3| reference.curves.query_any(p).expect("a boundary").chain;
        let placement = VertexMap::from_fn(10, |v: VertexId| match v.0 % 5 {
            0 | 4 => Placement::Corner(v),
            _ => Placement::Chain {
                chain: chain_at(mesh.position(v)),
                edge: plate.edges().next().unwrap(),
                parameter: 0.0,
            },
        });
        let feature_edges = EdgeMap::from_fn(mesh.edge_count(), |e| {
            let [a, b] = mesh.ends(e).map(|v| mesh.position(v));
            mesh.is_boundary_edge(e).then(|| chain_at(a.midpoint(b)))
        });
        let quads = Extraction {
            origin: VertexMap::filled(10, SurfacePoint { face: FaceId(0), weights: [1.0, 0.0, 0.0] }),
            placement,
            feature_edges,
            grid: FaceMap::filled(4, None),
            report: ExtractReport::default(),
            mesh,
        };
        let finished = finish(&quads, &reference, &FinishOptions::default(), &Progress::none()).expect("finished");
        for (v, joint) in [(6, 1), (7, 2), (8, 3)] {
            assert_eq!(finished.mesh.position(VertexId(v)), rim[joint], "{:?}", finished.mesh.positions());
        }
    }
}
