//! Ties: an iso-line of the map, hence a chain of quad edges, runs from one singular vertex to another.
//!
//! In: charts and two singular vertices. Out: [`TiePath`], a path between them and the row that makes one of their
//! coordinates equal in the chart at its end.
//! Holds: in a map that meets the row, the second vertex lies on an axis through the first, in the plane unrolled along
//! the path. Not: that the iso-line stays near the path, nor that a map without folds meets the row; whether the chain
//! exists is seen in the quads.
//! Source: [Bommes2012] §8.6, base complex: linear constraints by which irregular vertices are connected by a chain of
//! edges; the choice of the coordinate from the field along a shortest path is ours.
//!
//! ```text
//!           ●  b            the field along the path a ─── b: |Δu| > |Δv|, so the row is v_a = v_b,
//!     ●───────┘             with v_a carried over the seams between them
//!   a   path
//! ```

use crate::charts::Charts;
use crate::place::{Form, Place, Seams, sum};
use crate::placed::turn;
use quadloom_field::{CrossField, Transport};
use quadloom_mesh::{HalfEdgeId, TriMesh, VertexId, VertexMap};
use quadloom_numeric::Elimination;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::f64::consts::FRAC_PI_2;

/// Two singular vertices that a chain of quad edges is to join.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tie {
    /// The vertices, interior and of index other than 0.
    pub ends: [VertexId; 2],
}

/// Why two vertices cannot be tied.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TieError {
    /// The field is regular there.
    #[error("vertex {0} cannot be tied: the cross field is not singular there")]
    Regular(VertexId),
    /// Both ends are one vertex.
    #[error("vertex {0} cannot be tied to itself")]
    Same(VertexId),
    /// Boundaries, corners or other singular vertices are in every way.
    #[error("vertices {0} and {1} cannot be tied: no path joins them that avoids other singular vertices")]
    NoPath(VertexId, VertexId),
    /// The other ties and the features leave the two no distance.
    #[error("vertices {0} and {1} cannot be tied: with the other constraints they would coincide in the map")]
    Coincide(VertexId, VertexId),
}

/// A path between two tied vertices and what the map says of its ends.
#[derive(Clone, Debug)]
pub struct TiePath {
    /// The tied vertices.
    pub ends: [VertexId; 2],
    /// Way of the path as the field sees it, in the chart at its end, file units.
    pub way: [f64; 2],
    /// The coordinate that both ends share in that chart: 0 is u, 1 is v.
    pub constant: usize,
    /// Second end minus first end, in that chart, over the variables of [`crate::problem`].
    pub difference: [Form; 2],
}

impl TiePath {
    /// A shortest path of edges between the ends of a tie, and the coordinate that changes less along it.
    ///
    /// # Errors     see [`TieError`]; [`TieError::Coincide`] is not looked for
    /// # Cost       n log n
    pub fn new(
        mesh: &TriMesh,
        charts: &Charts,
        transport: &Transport,
        field: &CrossField,
        tie: Tie,
    ) -> Result<Self, TieError> {
        let [a, b] = tie.ends;
        // 1. The path.
        if let Some(&v) = tie.ends.iter().find(|&&v| charts.singular.binary_search_by_key(&v, |s| s.0).is_err()) {
            return Err(TieError::Regular(v));
        }
        if a == b {
            return Err(TieError::Same(a));
        }
        let sides = shortest_path(mesh, charts, a, b).ok_or(TieError::NoPath(a, b))?;
        // 2. The way along it, and the place of its beginning, carried from chart to chart.
        let seams = Seams::new(mesh, charts);
        let (mut way, mut place) = ([0.0; 2], Place::node(charts.node[sides[0]]));
        for (i, &side) in sides.iter().enumerate() {
            let step = step_along(mesh, charts, transport, field, side);
            way = [way[0] + step[0], way[1] + step[1]];
            let Some(&ahead) = sides.get(i + 1) else { break };
            // Counter-clockwise around the vertex between the two sides; it is regular, so either way would do.
            let mut corner = mesh.next(side);
            while corner != ahead {
                let through = mesh.prev(corner);
                way = turn(way, charts.quarter_turns[through]);
                place = seams.crossed(through, &place).unwrap_or(place);
                corner = mesh.twin(through).ok_or(TieError::NoPath(a, b))?;
            }
        }
        // 3. The row.
        let end = Place::node(charts.node[mesh.next(sides[sides.len() - 1])]);
        let difference = [0, 1].map(|k| sum(&end.0[k], -1, &place.0[k]));
        let constant = usize::from(way[0].abs() >= way[1].abs());
        Ok(Self { ends: tie.ends, way, constant, difference })
    }

    /// The difference that is to be zero.
    pub fn constant_difference(&self) -> &Form {
        &self.difference[self.constant]
    }
}

/// A side of a face in its chart, as long as in space.
fn step_along(
    mesh: &TriMesh,
    charts: &Charts,
    transport: &Transport,
    field: &CrossField,
    side: HalfEdgeId,
) -> [f64; 2] {
    let f = mesh.face(side);
    let angle = transport.direction(side) - field.angle[f] - f64::from(charts.axis[f]) * FRAC_PI_2;
    let length = mesh.position(mesh.origin(side)).distance(mesh.position(mesh.target(side)));
    [length * angle.cos(), length * angle.sin()]
}

/// Half-edges of a shortest path inside the surface whose vertices between the ends are regular.
fn shortest_path(mesh: &TriMesh, charts: &Charts, a: VertexId, b: VertexId) -> Option<Vec<HalfEdgeId>> {
    let is_open = |v: VertexId| v == b || (!charts.is_integer[v] && !mesh.is_boundary_vertex(v));
    let mut distance = VertexMap::filled(mesh.vertex_count(), f64::INFINITY);
    let mut through: VertexMap<Option<HalfEdgeId>> = VertexMap::filled(mesh.vertex_count(), None);
    let mut queue = BinaryHeap::from([Reverse((0u64, a))]);
    distance[a] = 0.0;
    while let Some(Reverse((bits, v))) = queue.pop() {
        // Non-negative floats are ordered as their bits.
        if f64::from_bits(bits) > distance[v] {
            continue;
        }
        if v == b {
            break;
        }
        for h in mesh.outgoing(v) {
            let w = mesh.target(h);
            let there = distance[v] + mesh.position(v).distance(mesh.position(w));
            if is_open(w) && there < distance[w] {
                distance[w] = there;
                through[w] = Some(h);
                queue.push(Reverse((there.to_bits(), w)));
            }
        }
    }
    let (mut path, mut at) = (Vec::new(), b);
    while at != a {
        let h = through[at]?;
        path.push(h);
        at = mesh.origin(h);
    }
    path.reverse();
    Some(path)
}

/// Whether the coordinate along each tie is still free to differ once all constraints are met.
///
/// # Errors     [`TieError::Coincide`] for the first tie whose ends are one point in every map
pub fn must_differ(ties: &[TiePath], elimination: &Elimination) -> Result<(), TieError> {
    for tie in ties {
        let (mut left, mut constant) = (BTreeMap::<u32, f64>::new(), 0.0);
        for &(variable, c) in &tie.difference[1 - tie.constant] {
            let expression = elimination.expression(variable as usize);
            constant += f64::from(c) * expression.constant;
            for &(k, factor) in expression.terms {
                *left.entry(k).or_insert(0.0) += f64::from(c) * factor;
            }
        }
        if left.values().all(|c| c.abs() < ROUNDING) && f64::abs(constant) < ROUNDING {
            return Err(TieError::Coincide(tie.ends[0], tie.ends[1]));
        }
    }
    Ok(())
}

/// Coefficients below this are the rounding error of sums of small integers and halves.
const ROUNDING: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::{map_constraints, variable_count};
    use crate::{ParamOptions, Parametrizer};
    use quadloom_field::{FieldConstraints, FieldOptions, SizeField, solve_cross_field};
    use quadloom_mesh::{DVec3, FeatureGraph, Progress, metric, shapes};
    use quadloom_numeric::Solver;

    /// A lump whose eight singular vertices are not aligned.
    fn lump() -> (TriMesh, CrossField) {
        let sphere = shapes::sphere(1.0, 3);
        let waves = |p: DVec3| 0.2 * (2.3 * p.x + 0.4).sin() + 0.15 * (1.9 * p.y - 0.8).cos();
        let positions = sphere.positions().map(|&p| p * (1.0 + waves(p)) * DVec3::new(1.0, 1.2, 1.6));
        let mesh = sphere.with_positions(positions).expect("finite");
        let (constraints, options) = (FieldConstraints::none(&mesh), FieldOptions::default());
        let (length, progress) = (metric::edge_lengths(&mesh), Progress::none());
        let field = solve_cross_field(&mesh, &Transport::of(&mesh), &length, &constraints, &options, &progress);
        (mesh, field.expect("a field").0)
    }

    /// Second end minus first end in the chart at the end of the path, from the exact map alone.
    fn unrolled(mesh: &TriMesh, charts: &Charts, map: &crate::IntegerGridMap, ends: [VertexId; 2]) -> [i64; 2] {
        let sides = shortest_path(mesh, charts, ends[0], ends[1]).expect("a path");
        let mut start = map.uv[sides[0]];
        for pair in sides.windows(2) {
            let mut corner = mesh.next(pair[0]);
            while corner != pair[1] {
                let through = mesh.prev(corner);
                start = map.transition[through].apply(start);
                corner = mesh.twin(through).expect("an interior vertex");
            }
        }
        let end = map.uv[mesh.next(sides[sides.len() - 1])];
        [end[0] - start[0], end[1] - start[1]]
    }

    #[test]
    fn tied_vertices_share_a_coordinate_exactly() {
        let (mesh, field) = lump();
        let features = FeatureGraph::none(&mesh);
        let size = SizeField::uniform(mesh.face_count(), 0.2);
        let singular: Vec<VertexId> = field.singularities(&mesh, &Transport::of(&mesh)).iter().map(|s| s.0).collect();
        let mut changed = 0;
        for &b in &singular[1..] {
            let ends = [singular[0], b];
            let made = |ties: &[Tie]| {
                let mut parametrizer = Parametrizer::with_ties(&mesh, &features, &field, ties).expect("rows");
                let map = parametrizer.map(&size, &ParamOptions::default(), &Progress::none()).expect("a map").map;
                unrolled(&mesh, parametrizer.charts(), &map, ends)
            };
            changed += usize::from(!made(&[]).contains(&0));
            let difference = made(&[Tie { ends }]);
            assert!(difference.contains(&0) && difference != [0, 0], "{ends:?}: {difference:?}");
        }
        assert!(changed > 0, "all were aligned without ties");
    }

    #[test]
    fn ties_without_a_meaning_are_refused() {
        let (mesh, field) = lump();
        let (features, transport) = (FeatureGraph::none(&mesh), Transport::of(&mesh));
        let singular: Vec<VertexId> = field.singularities(&mesh, &transport).iter().map(|s| s.0).collect();
        let refused = |ends: [VertexId; 2]| {
            let parametrizer = Parametrizer::with_ties(&mesh, &features, &field, &[Tie { ends }]);
            parametrizer.err().expect("no meaning")
        };
        let regular = mesh.vertices().find(|v| !singular.contains(v)).expect("a regular vertex");
        assert_eq!(refused([singular[0], regular]), TieError::Regular(regular).into());
        assert_eq!(refused([singular[0]; 2]), TieError::Same(singular[0]).into());
    }

    #[test]
    fn ties_of_both_coordinates_would_make_their_ends_coincide() {
        let (mesh, field) = lump();
        let (features, transport) = (FeatureGraph::none(&mesh), Transport::of(&mesh));
        let charts = Charts::new(&mesh, &metric::edge_lengths(&mesh), &transport, &features, &field);
        let ends = [charts.singular[0].0, charts.singular[1].0];
        let one = TiePath::new(&mesh, &charts, &transport, &field, Tie { ends }).expect("a path");
        let other = TiePath { constant: 1 - one.constant, ..one.clone() };
        let eliminated = |ties: &[TiePath]| {
            let rows = map_constraints(&mesh, &features, &charts, ties);
            let solver = Solver::new(variable_count(&charts), &rows.rows, &rows.integers).expect("a solution");
            must_differ(ties, solver.elimination())
        };
        assert_eq!(eliminated(std::slice::from_ref(&one)), Ok(()));
        assert_eq!(eliminated(&[one, other]), Err(TieError::Coincide(ends[0], ends[1])));
    }
}
