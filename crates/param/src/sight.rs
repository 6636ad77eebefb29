//! What integer vertices see: each other, and features straight ahead.
//!
//! In: a fold-free map on the lattice. Out: [`Sight`]s with their difference in the map and as linear forms. Holds: the
//! line of sight crosses no integer vertex, and the forms are those of this line. Not: what is farther away than asked. Source: the validity conditions of [Campen2015] §4 ask that no two of them coincide; two that lie on opposite
//! sides of a cell of no width do, although every path of arcs between them goes out and back.

use crate::charts::Charts;
use crate::integer_grid_map::{GRID_UNIT, IntegerGridMap, LatticePoint, rotate};
use crate::place::{Form, Place, Seams, sum};
use quadloom_mesh::{HalfEdgeId, TriConnectivity, VertexId};

/// From an integer vertex to another one, or straight to a feature.
#[derive(Clone, Debug)]
pub struct Sight {
    /// The vertex that sees.
    pub from: VertexId,
    /// The integer vertex that is seen; `None` for a feature.
    pub to: Option<VertexId>,
    /// The differences that must not all be zero: two coordinates of a vertex, one across a feature. Each in the map,
    /// grid units, and in variables of [`crate::problem`], in the chart of the last face on the way.
    pub ways: Vec<(f64, Form)>,
}

/// A cone of sight that leaves a face.
struct Cone {
    /// The side through which it leaves.
    side: HalfEdgeId,
    /// Where it comes from, in the chart of the side's face.
    source: LatticePoint,
    place: Place,
    /// Its limits: directions from the source, the second one counter-clockwise of the first.
    limits: [LatticePoint; 2],
}

/// Finds what integer vertices see; of two vertices that see each other, the one with the smaller number does.
///
/// # Input      map: fold-free; radius: largest difference in each coordinate, grid units
/// # Cost       proportional to the triangles in sight within the radius
pub fn sights(mesh: &TriConnectivity, charts: &Charts, map: &IntegerGridMap, radius: f64) -> Vec<Sight> {
    let mut search = Search {
        mesh,
        charts,
        map,
        seams: Seams::new(mesh, charts),
        radius: (radius * GRID_UNIT as f64) as i64,
        seen: Vec::new(),
    };
    for v in mesh.vertices().filter(|&v| charts.is_integer[v]) {
        search.look_around(v);
    }
    search.seen
}

struct Search<'a> {
    mesh: &'a TriConnectivity,
    charts: &'a Charts,
    map: &'a IntegerGridMap,
    seams: Seams<'a>,
    radius: i64,
    seen: Vec<Sight>,
}

impl Search<'_> {
    fn look_around(&mut self, v: VertexId) {
        for h in self.mesh.outgoing(v) {
            let (source, place) = (self.map.uv[h], Place::node(self.charts.node[h]));
            let side = self.mesh.next(h);
            // 1. Along the edge.
            self.see(v, side, source, &place);
            // 2. Through the opposite side, and on.
            let limits = [side, self.mesh.next(side)].map(|c| minus(self.map.uv[c], source));
            let mut cones = vec![Cone { side, source, place, limits }];
            while let Some(cone) = cones.pop() {
                self.pass(v, cone, &mut cones);
            }
        }
    }

    /// Notes the origin of a half-edge if it is an integer vertex with a larger number.
    fn see(&mut self, v: VertexId, corner: HalfEdgeId, source: LatticePoint, place: &Place) {
        let w = self.mesh.origin(corner);
        if w <= v || !self.charts.is_integer[w] {
            return;
        }
        let there = Place::node(self.charts.node[corner]);
        let way = minus(self.map.uv[corner], source).map(|x| x as f64 / GRID_UNIT as f64);
        let ways = [0, 1].map(|k| (way[k], sum(&there.0[k], -1, &place.0[k])));
        self.seen.push(Sight { from: v, to: Some(w), ways: ways.to_vec() });
    }

    /// Notes the feature that a cone ends on, if it is straight ahead: the foot of the source is in sight.
    fn see_feature(&mut self, v: VertexId, cone: &Cone) {
        if self.charts.feature_axis[self.mesh.edge(cone.side)].is_none() {
            return;
        }
        let ends = [cone.side, self.mesh.next(cone.side)].map(|c| minus(self.map.uv[c], cone.source));
        // 1. The coordinate across; a feature runs along the other one.
        let Some(k) = (0..2).find(|&k| ends[0][k] == ends[1][k]) else { return };
        let across = ends[0][k];
        let mut ahead = [0, 0];
        ahead[k] = across;
        // 2. On the piece of the feature that the cone shows.
        let [right, left] = cone.limits;
        let is_in_sight = !turns_left(ahead, right) && turns_left(ahead, left);
        if across == 0 || across.abs() > self.radius || !is_in_sight {
            return;
        }
        let there = Place::node(self.charts.node[cone.side]);
        let way = across as f64 / GRID_UNIT as f64;
        self.seen.push(Sight { from: v, to: None, ways: vec![(way, sum(&there.0[k], -1, &cone.place.0[k]))] });
    }

    /// Follows a cone across one face.
    fn pass(&mut self, v: VertexId, cone: Cone, cones: &mut Vec<Cone>) {
        self.see_feature(v, &cone);
        let Some(twin) = self.mesh.twin(cone.side) else { return };
        // 1. The cone in the chart of the face across.
        let transition = self.map.transition[cone.side];
        let source = transition.apply(cone.source);
        let place = self.seams.crossed(cone.side, &cone.place).unwrap_or(cone.place);
        let [right, left] = cone.limits.map(|d| rotate(d, transition.quarter_turns));
        // 2. The corner opposite to the side.
        let [first, second] = [self.mesh.next(twin), self.mesh.prev(twin)];
        let ahead = minus(self.map.uv[second], source);
        let (map, radius) = (self.map, self.radius);
        let is_far = |h: HalfEdgeId| minus(map.uv[h], source).iter().any(|x| x.abs() > radius);
        let (is_left_of_right, is_right_of_left) = (turns_left(right, ahead), turns_left(ahead, left));
        if is_left_of_right && is_right_of_left && !is_far(second) {
            self.see(v, second, source, &place);
        }
        if is_far(first) && is_far(second) && is_far(twin) {
            return;
        }
        // 3. What is in sight through the other two sides: first right of the corner, second left of it.
        if is_left_of_right {
            let limits = [right, if is_right_of_left { ahead } else { left }];
            cones.push(Cone { side: first, source, place: place.clone(), limits });
        }
        if is_right_of_left {
            let limits = [if is_left_of_right { ahead } else { right }, left];
            cones.push(Cone { side: second, source, place, limits });
        }
    }
}

fn minus(a: LatticePoint, b: LatticePoint) -> LatticePoint {
    [a[0] - b[0], a[1] - b[1]]
}

/// Whether the second direction is counter-clockwise of the first, by less than half a turn.
fn turns_left(a: LatticePoint, b: LatticePoint) -> bool {
    i128::from(a[0]) * i128::from(b[1]) > i128::from(a[1]) * i128::from(b[0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tmesh::evaluate;
    use crate::{ParamOptions, Parametrizer};
    use quadloom_field::{FieldConstraints, FieldOptions, SizeField, Transport, solve_cross_field};
    use quadloom_mesh::features::FeatureOptions;
    use quadloom_mesh::{DVec3, FeatureGraph, Progress, TriMesh, metric, shapes};

    /// What is seen on a map of a mesh, and the map's variables.
    fn seen(mesh: &TriMesh, features: &FeatureGraph, edge: f64) -> (Vec<Sight>, Vec<f64>) {
        let (length, transport, progress) = (metric::edge_lengths(mesh), Transport::of(mesh), Progress::none());
        let (constraints, _) = FieldConstraints::from_features(mesh, &transport, &length, features);
        let options = FieldOptions::default();
        let (field, _) = solve_cross_field(mesh, &transport, &length, &constraints, &options, &progress).unwrap();
        let mut parametrizer = Parametrizer::new(mesh, features, &field).unwrap();
        let size = SizeField::uniform(mesh.face_count(), edge);
        let map = parametrizer.map(&size, &ParamOptions::default(), &progress).unwrap();
        assert_eq!(map.inverted, []);
        let (charts, map) = (parametrizer.charts(), map.map);
        let mut x = vec![0.0; 2 * (charts.node_count + charts.segments.len())];
        for f in mesh.faces() {
            for h in mesh.face_half_edges(f) {
                (0..2).for_each(|k| x[2 * charts.node[h] as usize + k] = map.uv[h][k] as f64 / GRID_UNIT as f64);
            }
        }
        for (s, segment) in charts.segments.iter().enumerate() {
            let translation = map.transition[segment.sides[0]].translation;
            (0..2).for_each(|k| x[2 * (charts.node_count + s) + k] = translation[k] as f64 / GRID_UNIT as f64);
        }
        (sights(mesh, charts, &map, 6.0), x)
    }

    #[test]
    fn forms_of_sights_give_their_differences() {
        let sphere = shapes::sphere(1.0, 3);
        let lump = |p: DVec3| p * (1.0 + 0.2 * (2.3 * p.x + 0.4).sin()) * DVec3::new(1.0, 1.2, 1.6);
        let mesh = sphere.with_positions(sphere.positions().map(|&p| lump(p))).expect("finite");
        let (seen, x) = seen(&mesh, &FeatureGraph::none(&mesh), 0.5);
        assert!(seen.len() >= 12, "eight singular vertices, each with three neighbours");
        for sight in &seen {
            assert!(sight.ways.iter().any(|w| w.0 != 0.0), "{sight:?}");
            sight.ways.iter().for_each(|(way, form)| assert!((evaluate(form, &x) - way).abs() < 1e-9, "{sight:?}"));
        }
    }

    #[test]
    fn corners_see_the_features_ahead() {
        let mesh = shapes::bracket(0.1);
        let features = FeatureGraph::detect(&mesh, &FeatureOptions::default()).0;
        let (seen, x) = seen(&mesh, &features, 0.12);
        let ahead: Vec<&Sight> = seen.iter().filter(|s| s.to.is_none()).collect();
        assert!(!ahead.is_empty());
        for sight in ahead {
            let [(way, form)] = &sight.ways[..] else { panic!("one difference") };
            assert!(way.abs() >= 1.0 && (evaluate(form, &x) - way).abs() < 1e-9, "{sight:?}");
        }
    }
}
