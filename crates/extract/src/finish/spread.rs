//! Vertices are spread along curves again where a chord cuts much off, and all around make room for them.
//!
//! In: a [`State`] whose vertices lie on their curves. Out: the same with vertices of such stretches elsewhere on the
//! curve, pinned there. Holds: the order along the curve; no quad gets worse below the floor; a curve's largest cut gets
//! smaller, or all around it stays as it was. Source: own; places are chosen as in [`super::joints`], from the whole
//! curve instead of its joints alone, and reached one vertex after the other instead of together.

use super::joints::{Curve, Place, Stop, cheapest, stops_by_chain};
use super::state::State;
use super::ties::{Move, Tie};
use super::untangle::improve_some;
use quadloom_mesh::{Cancelled, ChainId, FaceId, Progress, VertexId};

/// Distance of a curve from a chord, relative to the mean quad edge, from which vertices are spread again.
///
/// Smaller: circles of six vertices (0.13) are taken apart for nothing; larger: curves are left that are seen to be cut.
const MUCH_CUT_REL: f64 = 0.14;

/// Vertices to either side of such a chord that move.
const WINDOW: usize = 5;

/// Way that a vertex can go in each round, in mean quad edges: far first, to where the fewest are cut off, then near it,
/// to where those are least. Each round sees how far the vertices came in the one before.
const REACH_REL: [f64; 4] = [1.5, 1.5, 0.4, 0.1];

/// Number of places within the reach to either side.
const SAMPLES: i32 = 9;

/// Two neighbours come no nearer to each other than this, in mean quad edges, unless they are already.
const LEAST_GAP_REL: f64 = 0.3;

/// Cost of moving a vertex by a mean quad edge, in squares of cuts relative to that edge.
const SHIFT_COST: f64 = 1e-3;

/// Cost of what a cut has above [`MUCH_CUT_REL`], squared: no sum of small ones is worth one of those.
const MUCH_COST: f64 = 100.0;

/// Joints at most that a vertex chooses from; those that stick out farthest.
const MOST_JOINTS: usize = 8;

/// Strides in which vertices go to their places; all around improves after each.
const STRIDES: usize = 8;

/// Rings of quads around the vertices of a stretch that make room.
const RINGS: usize = 3;

/// Scaled Jacobian below which quads around are improved on the way.
const ROOM: f64 = 0.5;

/// A vertex on its way along a curve.
struct Traveller {
    vertex: VertexId,
    from: f64,
    to: Place,
    /// How much of its way it has made, 0..=1.
    made: f64,
}

/// Spreads vertices along all curves that chords cut off; returns how many moved.
///
/// # Input      edge: mean edge length of the quads, file units; floor: scaled Jacobian down to which quads may get worse
/// # Errors     cancellation
/// # Cost       linear in the vertices and joints of all curves, and a few pattern searches per vertex near a large cut
pub(crate) fn spread_along_curves(
    state: &mut State,
    edge: f64,
    floor: f64,
    progress: &Progress,
) -> Result<usize, Cancelled> {
    let mut moved = 0;
    for (chain, own) in stops_by_chain(state).into_iter().enumerate() {
        let vertices: Vec<VertexId> = own.into_iter().map(|(_, v)| v).collect();
        moved += Stretch { chain: chain as ChainId, vertices, edge, floor }.spread(state, progress)?;
    }
    Ok(moved)
}

/// The vertices of a curve.
struct Stretch {
    chain: ChainId,
    vertices: Vec<VertexId>,
    edge: f64,
    floor: f64,
}

impl Stretch {
    fn spread(&self, state: &mut State, progress: &Progress) -> Result<usize, Cancelled> {
        let before = self.largest_cut(state);
        let mut travellers = self.choose(state, REACH_REL[0]);
        if travellers.is_empty() {
            return Ok(0);
        }
        // 1. All that may move, as it is.
        let rings = self.rings(state, &travellers);
        let saved = Saved::new(state, &rings);
        // 2. Choose and go, until there is nothing left to choose.
        for round in 1..=REACH_REL.len() {
            for t in &travellers {
                state.pinned[t.vertex] = true;
            }
            for left in (1..=STRIDES).rev() {
                progress.check()?;
                for t in &mut travellers {
                    self.stride(state, t, left);
                }
                improve_some(state, &rings, ROOM, progress);
            }
            let Some(&reach) = REACH_REL.get(round) else { break };
            travellers = self.choose(state, reach);
            travellers.retain(|t| saved.contains(t.vertex));
            if travellers.is_empty() {
                break;
            }
        }
        // 3. Only if it was worth it.
        let after = self.largest_cut(state);
        if after >= before {
            saved.restore(state);
            return Ok(0);
        }
        Ok(saved.moved_on_curves(state))
    }

    fn own(&self, state: &State) -> Vec<(f64, VertexId)> {
        let arc = |&v: &VertexId| match state.tie[v] {
            Tie::Curve { chain, arc } if chain == self.chain => Some((arc, v)),
            _ => None,
        };
        let mut own: Vec<(f64, VertexId)> = self.vertices.iter().filter_map(arc).collect();
        own.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        own
    }

    /// The largest distance of the curve from a chord, file units.
    fn largest_cut(&self, state: &State) -> f64 {
        let curve = Curve::new(state, self.chain, self.edge);
        let stops = curve.stops(self.own(state));
        stops.windows(2).map(|w| curve.cut(w[0].places[0], w[1].places[0])).fold(0.0, f64::max)
    }

    /// Who is to go where.
    fn choose(&self, state: &State, reach_rel: f64) -> Vec<Traveller> {
        let curve = Curve::new(state, self.chain, self.edge);
        let mut stops = curve.stops(self.own(state));
        if stops.len() < 3 {
            return Vec::new();
        }
        let is_near = self.near_large_cuts(&curve, &stops);
        if !is_near.contains(&true) {
            return Vec::new();
        }
        // The first vertex of a closed curve comes once more at the end.
        let count = stops.len() - usize::from(curve.is_closed());
        for (i, stop) in stops.iter_mut().enumerate().take(count) {
            if is_near[i] && stop.vertex.is_some() {
                self.add_places(state, &curve, stop, reach_rel * self.edge);
            }
        }
        if curve.is_closed() {
            let total = state.reference.curves.length(self.chain);
            stops[count].places = stops[0].places.iter().map(|p| Place { arc: p.arc + total, ..*p }).collect();
        }
        let chosen = cheapest(&stops, curve.is_closed(), |from, to| self.piece_costs(&curve, from, to));
        let traveller = |(stop, place): (&Stop, usize)| {
            let (vertex, from, to) = (stop.vertex?, stop.places[0].arc, stop.places[place]);
            (place > 0).then_some(Traveller { vertex, from, to, made: 0.0 })
        };
        stops.iter().zip(chosen).take(count).filter_map(traveller).collect()
    }

    /// Which stops are within a few of a chord that cuts much off.
    fn near_large_cuts(&self, curve: &Curve, stops: &[Stop]) -> Vec<bool> {
        let count = stops.len() - usize::from(curve.is_closed());
        let mut near = vec![false; stops.len()];
        for (i, w) in stops.windows(2).enumerate() {
            if curve.cut(w[0].places[0], w[1].places[0]) <= MUCH_CUT_REL * self.edge {
                continue;
            }
            for k in 0..2 * WINDOW {
                let at = i + 1 + k;
                if curve.is_closed() {
                    near[(at + count * WINDOW - WINDOW) % count] = true;
                } else if (WINDOW..count + WINDOW).contains(&at) {
                    near[at - WINDOW] = true;
                }
            }
        }
        near
    }

    /// Adds the joints and some points of the curve around a vertex.
    fn add_places(&self, state: &State, curve: &Curve, stop: &mut Stop, reach: f64) {
        let own = stop.places[0];
        let [from, to] = [-reach, reach].map(|d| Place { arc: own.arc + d, ..own });
        let mut joints: Vec<(f64, Place)> = curve.between(from, to).iter().map(|&j| (curve.bulge(j), j)).collect();
        joints.retain(|&(_, j)| curve.sticks_out(j) && j.position != own.position);
        joints.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.arc.total_cmp(&b.1.arc)));
        stop.places.extend(joints.into_iter().take(MOST_JOINTS).map(|j| j.1));
        let total = state.reference.curves.length(self.chain);
        for k in (-SAMPLES..=SAMPLES).filter(|&k| k != 0) {
            let arc = own.arc + reach * f64::from(k) / f64::from(SAMPLES);
            if curve.is_closed() || (arc > 0.0 && arc < total) {
                stop.places.push(Place { arc, position: state.reference.curves.at(self.chain, arc).position });
            }
        }
    }

    /// Cost of the chord between any place of a stop and any of the next one, the way of the latter included.
    fn piece_costs(&self, curve: &Curve, from: &Stop, to: &Stop) -> Vec<Vec<f64>> {
        let least_gap = LEAST_GAP_REL * self.edge;
        let cost = |i: usize, j: usize| {
            let (a, b) = (from.places[i], to.places[j]);
            if (i, j) != (0, 0) && b.arc - a.arc < least_gap {
                return f64::INFINITY;
            }
            let cut = curve.cut(a, b) / self.edge;
            let much = (cut - MUCH_CUT_REL).max(0.0);
            let way = (b.arc - to.places[0].arc) / self.edge;
            cut * cut + MUCH_COST * much * much + SHIFT_COST * way * way
        };
        (0..from.places.len()).map(|i| (0..to.places.len()).map(|j| cost(i, j)).collect()).collect()
    }

    /// Takes a vertex on by one of so many strides that are left, or as much of it as its quads allow.
    fn stride(&self, state: &mut State, t: &mut Traveller, left: usize) {
        let start = state.place(t.vertex);
        let faces: Vec<FaceId> = state.quads.outgoing(t.vertex).map(|h| state.quads.face(h)).collect();
        let limit = state.worst_above(&faces, f64::NEG_INFINITY).min(self.floor);
        for part in [1.0, 0.5, 0.25] {
            let made = if left == 1 && part == 1.0 { 1.0 } else { t.made + part * (1.0 - t.made) / left as f64 };
            let there = state.reference.curves.at(self.chain, t.from + (t.to.arc - t.from) * made);
            let position = if made == 1.0 { t.to.position } else { there.position };
            state.put(t.vertex, Move { position, tie: Tie::Curve { chain: self.chain, arc: there.arc } });
            if state.worst_above(&faces, f64::NEG_INFINITY) >= limit {
                t.made = made;
                state.measure_around(t.vertex);
                return;
            }
            state.put(t.vertex, start);
        }
    }

    /// Quads within some rings around the travellers.
    fn rings(&self, state: &State, travellers: &[Traveller]) -> Vec<FaceId> {
        let mut around = state.faces_around(travellers.iter().map(|t| t.vertex));
        for _ in 1..RINGS {
            around = state.faces_around(around.iter().flat_map(|&f| state.quads.face_vertices(f)));
        }
        around
    }
}

/// Vertices as they were, and whether they were pinned; ascending.
struct Saved(Vec<(VertexId, Move, bool)>);

impl Saved {
    fn new(state: &State, quads: &[FaceId]) -> Self {
        let mut vertices: Vec<VertexId> = quads.iter().flat_map(|&f| state.quads.face_vertices(f)).collect();
        vertices.sort_unstable();
        vertices.dedup();
        Self(vertices.into_iter().map(|v| (v, state.place(v), state.pinned[v])).collect())
    }

    fn contains(&self, v: VertexId) -> bool {
        self.0.binary_search_by_key(&v, |s| s.0).is_ok()
    }

    fn restore(self, state: &mut State) {
        for &(v, place, pinned) in &self.0 {
            state.put(v, place);
            state.pinned[v] = pinned;
        }
        for (v, ..) in self.0 {
            state.measure_around(v);
        }
    }

    fn moved_on_curves(&self, state: &State) -> usize {
        let moved = |&&(v, place, _): &&(VertexId, Move, bool)| {
            matches!(state.tie[v], Tie::Curve { .. }) && state.position[v] != place.position
        };
        self.0.iter().filter(moved).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::extraction::{ExtractReport, Extraction, Placement};
    use crate::finish::ties::Ties;
    use crate::quality::scaled_jacobian;
    use crate::reference::Reference;
    use quadloom_mesh::features::FeatureOptions;
    use quadloom_mesh::{
        DVec3, EdgeMap, FaceMap, FeatureGraph, PolylineIndex, QuadMesh, SurfacePoint, TriMesh, VertexMap,
    };
    use std::f64::consts::TAU;

    const SIDES: u32 = 16;

    /// Rings of points around the z axis, and the corners of the cells between them.
    fn rings(radii: &[f64], count: u32, turn: impl Fn(usize, u32) -> f64) -> (Vec<DVec3>, Vec<[u32; 4]>) {
        let point = |k: usize, i: u32| {
            let (sin, cos) = (TAU * turn(k, i)).sin_cos();
            DVec3::new(cos, sin, 0.0) * radii[k]
        };
        let point = &point;
        let points = (0..radii.len()).flat_map(|k| (0..count).map(move |i| point(k, i))).collect();
        let cell = |k: u32, i: u32| {
            let (j, low, high) = ((i + 1) % count, k * count, (k + 1) * count);
            [low + i, high + i, high + j, low + j]
        };
        let cells = (0..radii.len() as u32 - 1).flat_map(|k| (0..count).map(move |i| cell(k, i))).collect();
        (points, cells)
    }

    /// Spreads vertices along a bore of 16 sides, given in turns; the largest distance of a joint from the quads before
    /// and after, and the worst scaled Jacobian.
    fn spread_on_bore(starts: &[f64]) -> (f64, f64, f64) {
        let count = starts.len() as u32;
        let (points, cells) = rings(&[1.75, 3.2, 5.0], SIDES, |_, i| f64::from(i) / f64::from(SIDES));
        let triangles: Vec<[u32; 3]> = cells.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let plate = TriMesh::new(points, &triangles).expect("a plate");
        let (features, _) = FeatureGraph::detect(&plate, &FeatureOptions::default());
        let reference = Reference::new(&plate, &features);
        let even = |i: u32| starts[0] + f64::from(i) / f64::from(count);
        let turn = |k: usize, i: u32| starts[i as usize] + (even(i) - starts[i as usize]) * k as f64 / 3.0;
        let (mut positions, quads) = rings(&[1.75, 2.7, 3.7, 4.8], count, turn);
        for p in &mut positions[..count as usize] {
            *p = reference.curves.query_any(*p).expect("a boundary").position;
        }
        let mesh = QuadMesh::new(positions, &quads).expect("quads");
        let bore = reference.curves.query_any(mesh.position(VertexId(0))).expect("a boundary").chain;
        let edge = plate.edges().next().expect("an edge");
        let placement = VertexMap::from_fn(mesh.vertex_count(), |v: VertexId| match v.0 / count {
            0 => Placement::Chain { chain: bore, edge, parameter: 0.0 },
            3 => Placement::Corner(v),
            _ => Placement::Free,
        });
        let quads = Extraction {
            origin: VertexMap::filled(mesh.vertex_count(), SurfacePoint { face: FaceId(0), weights: [1.0, 0.0, 0.0] }),
            placement,
            feature_edges: EdgeMap::from_fn(mesh.edge_count(), |e| {
                mesh.ends(e).iter().all(|v| v.0 < count).then_some(bore)
            }),
            grid: FaceMap::filled(mesh.face_count(), None),
            report: ExtractReport::default(),
            mesh,
        };
        let (mut state, bad) = State::new(&quads.mesh, &reference, Ties::new(&quads, &reference, 1.2));
        assert_eq!(bad, 0);
        let farthest = |state: &State| {
            let side = |i: u32| ([i, (i + 1) % count].map(|v| state.position[VertexId(v)]), false);
            let index = PolylineIndex::new(&(0..count).map(side).collect::<Vec<_>>());
            let joints = (0..SIDES).map(|i| plate.position(VertexId(i)));
            joints.map(|p| index.query_any(p).map_or(f64::INFINITY, |c| c.distance)).fold(0.0, f64::max)
        };
        let before = farthest(&state);
        let moved = spread_along_curves(&mut state, 1.2, 0.06, &Progress::none()).expect("not cancelled");
        assert_eq!(moved > 0, farthest(&state) < before);
        for i in 0..count {
            assert!(reference.curves.query(bore, state.position[VertexId(i)]).distance < 1e-12);
        }
        let worst = state.quads.faces().map(|f| scaled_jacobian(state.corners(f))).fold(f64::INFINITY, f64::min);
        (before, farthest(&state), worst)
    }

    /// Nine vertices as a map left them; those at the gaps of two sides and more have the ends of others in their way.
    #[test]
    fn vertices_spread_where_they_are_crowded_beside_a_gap() {
        let starts = [0.64, 2.49, 3.05, 4.06, 4.74, 5.84, 6.94, 8.13, 9.49].map(|arc| arc / 10.84);
        let (before, after, worst) = spread_on_bore(&starts);
        // The best that nine vertices on 16 joints can do: a chord over two sides, 1.75 (1 - cos 22.5°).
        assert!(before > 0.22 && after < 0.14 && worst > 0.2, "{before} {after} {worst}");
    }

    #[test]
    fn five_vertices_on_a_bore_cut_it_off_and_stay_no_worse() {
        let (before, after, worst) = spread_on_bore(&[0.0, 0.2, 0.4, 0.6, 0.8]);
        assert!(before > 0.2 && after <= before && worst > 0.2, "{before} {after} {worst}");
    }
}
