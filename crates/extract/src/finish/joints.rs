//! Vertices on curves settle on the joints of coarse polylines, so that no chord cuts one off.
//!
//! In: a [`State`] whose vertices lie on their curves. Out: the same with some of them on joints, pinned there.
//! Holds: the order along the curve; no quad gets worse below the floor. Source: own.

use super::state::State;
use super::ties::{Move, Tie};
use quadloom_mesh::{ChainId, DVec3, VertexId, VertexMap};

/// Distance of a joint from the chord that passes it, relative to the mean quad edge, from which a vertex moves there.
///
/// A circle of 40 edges has 0.02. Smaller: vertices are pinned for nothing; larger: corners are cut off.
const LEAST_CUT_REL: f64 = 0.02;

/// A vertex moves at most this part of the way to its neighbour beyond the joint.
const REACH_REL: f64 = 0.6;

/// Scaled Jacobian down to which quads may get worse.
const SETTLED_FLOOR: f64 = 0.3;

/// A vertex on a curve, by its length from the curve's start; corners at the ends of the curve have no vertex.
#[derive(Clone, Copy)]
struct Stop {
    arc: f64,
    position: DVec3,
    vertex: Option<VertexId>,
}

/// Moves vertices onto the joints that lie farthest from the quads' edges; returns how many were pinned.
///
/// # Input      edge: mean edge length of the quads, file units
/// # Cost       linear in the joints and vertices of the curves
pub(crate) fn settle_on_joints(state: &mut State, edge: f64) -> usize {
    let mut stops = stops_by_chain(state);
    let mut wanted: VertexMap<Option<(f64, Move)>> = VertexMap::filled(state.quads.vertex_count(), None);
    for (chain, stops) in stops.iter_mut().enumerate() {
        close_or_end(state, chain as ChainId, stops);
        for (cut, vertex, to) in cut_joints(state, chain as ChainId, stops) {
            let better = wanted[vertex].is_none_or(|(other, _)| cut > other);
            if cut > LEAST_CUT_REL * edge && better {
                wanted[vertex] = Some((cut, to));
            }
        }
    }
    let moves: Vec<Option<Move>> = wanted.values().iter().map(|w| w.map(|(_, to)| to)).collect();
    state.advance(&moves, SETTLED_FLOOR);
    let mut pinned = 0;
    for v in state.quads.vertices() {
        if moves[v.index()].is_some_and(|to| to.position == state.position[v]) {
            state.pinned[v] = true;
            pinned += 1;
        }
    }
    pinned
}

/// The vertices on each curve, ascending by length, then by id.
fn stops_by_chain(state: &State) -> Vec<Vec<Stop>> {
    let mut stops: Vec<Vec<Stop>> = vec![Vec::new(); state.reference.curves.len()];
    for v in state.quads.vertices() {
        if let Tie::Curve { chain, arc } = state.tie[v] {
            stops[chain as usize].push(Stop { arc, position: state.position[v], vertex: Some(v) });
        }
    }
    stops.iter_mut().for_each(|list| list.sort_by(|a, b| a.arc.total_cmp(&b.arc).then(a.vertex.cmp(&b.vertex))));
    stops
}

/// Adds the ends of an open curve, or the neighbours across the start of a closed one.
fn close_or_end(state: &State, chain: ChainId, stops: &mut Vec<Stop>) {
    let curves = &state.reference.curves;
    let total = curves.length(chain);
    if !curves.is_closed(chain) {
        let end = |arc: f64| Stop { arc, position: curves.at(chain, arc).position, vertex: None };
        stops.insert(0, end(0.0));
        stops.push(end(total));
    } else if let (Some(&first), Some(&last)) = (stops.first(), stops.last()) {
        stops.insert(0, Stop { arc: last.arc - total, ..last });
        stops.push(Stop { arc: first.arc + total, ..first });
    }
}

/// Joints between two stops, how far each is from the chord, and the vertex that can move there.
fn cut_joints(state: &State, chain: ChainId, stops: &[Stop]) -> Vec<(f64, VertexId, Move)> {
    let curves = &state.reference.curves;
    let total = curves.length(chain);
    let mut found = Vec::new();
    let mut i = 0;
    for (arc, position) in curves.joints(chain) {
        // On a closed curve the stops begin before its start and end behind it, but by one gap only.
        while i + 1 < stops.len() && stops[i + 1].arc <= arc {
            i += 1;
        }
        let (Some(&a), Some(&b)) = (stops.get(i), stops.get(i + 1)) else { continue };
        if arc <= a.arc || b.arc <= a.arc {
            continue;
        }
        let t = quadloom_mesh::closest::closest_parameter(a.position, b.position, position);
        let cut = a.position.lerp(b.position, t).distance(position);
        // The nearer one of the two, or the other if that one is fixed: the way to the joint meets no other vertex.
        let reach = REACH_REL * (b.arc - a.arc);
        let mut ways = [(arc - a.arc, a.vertex), (b.arc - arc, b.vertex)];
        ways.sort_by(|x, y| x.0.total_cmp(&y.0));
        let movable = ways.iter().filter(|way| way.0 <= reach).filter_map(|way| way.1);
        if let Some(v) = movable.into_iter().find(|&v| !state.pinned[v]) {
            let arc = if total > 0.0 && curves.is_closed(chain) { arc.rem_euclid(total) } else { arc };
            found.push((cut, v, Move { position, tie: Tie::Curve { chain, arc } }));
        }
    }
    found
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
}
