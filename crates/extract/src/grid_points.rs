//! Grid points of an integer-grid map: the future quad vertices.
//!
//! In: a triangle mesh and its map. Out: [`GridPoints`], every preimage of an integer point once, owned by the mesh
//! vertex, edge or face that carries it, in that order, ascending by id.
//! Holds: exact; a point on an edge belongs to the edge alone. Source: [Ebke2013] §4.1, own enumeration.

use crate::lattice::{difference, grid_units_between, is_grid_point, strict_neighbours};
use quadloom_mesh::{EdgeId, FaceId, TriConnectivity, VertexId, VertexMap};
use quadloom_param::{GRID_UNIT, IntegerGridMap, LatticePoint};

/// The element whose interior carries a grid point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Carrier {
    Vertex(VertexId),
    Edge(EdgeId),
    Face(FaceId),
}

/// A preimage of an integer point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct GridPoint {
    pub carrier: Carrier,
    /// The face in whose chart `at` is given: of the vertex's first corner, of the edge's canonical half-edge.
    pub face: FaceId,
    pub at: LatticePoint,
}

/// All grid points, with look-up by carrier.
pub(crate) struct GridPoints {
    pub points: Vec<GridPoint>,
    of_vertex: VertexMap<u32>,
    /// Points of edge e: `first_of_edge[e]..first_of_edge[e + 1]`, in the order along the canonical half-edge.
    first_of_edge: Vec<u32>,
    /// Points of face f: likewise, ascending by (v, u).
    first_of_face: Vec<u32>,
}

const NONE: u32 = u32::MAX;

impl GridPoints {
    /// Enumerates the grid points.
    ///
    /// # Cost       linear in mesh elements, points, and integer rows crossed by triangles
    pub fn find(mesh: &TriConnectivity, map: &IntegerGridMap) -> Self {
        let mut points = Vec::new();
        // 1. Mesh vertices on integer points.
        let mut of_vertex = VertexMap::filled(mesh.vertex_count(), NONE);
        for v in mesh.vertices() {
            let h = mesh.outgoing_half_edge(v);
            if is_grid_point(map.uv[h]) {
                of_vertex[v] = points.len() as u32;
                points.push(GridPoint { carrier: Carrier::Vertex(v), face: mesh.face(h), at: map.uv[h] });
            }
        }
        // 2. Points inside edges.
        let mut first_of_edge = Vec::with_capacity(mesh.edge_count() + 1);
        for e in mesh.edges() {
            first_of_edge.push(points.len() as u32);
            let h = mesh.half_edge(e);
            let face = mesh.face(h);
            points_inside_edge(map.uv[h], map.uv[mesh.next(h)], |at| {
                points.push(GridPoint { carrier: Carrier::Edge(e), face, at });
            });
        }
        first_of_edge.push(points.len() as u32);
        // 3. Points inside faces.
        let mut first_of_face = Vec::with_capacity(mesh.face_count() + 1);
        for f in mesh.faces() {
            first_of_face.push(points.len() as u32);
            points_inside_triangle(map.face_uv(mesh, f), |at| {
                points.push(GridPoint { carrier: Carrier::Face(f), face: f, at });
            });
        }
        first_of_face.push(points.len() as u32);
        Self { points, of_vertex, first_of_edge, first_of_face }
    }

    /// The point at a mesh vertex.
    pub fn at_vertex(&self, v: VertexId) -> Option<u32> {
        Some(self.of_vertex[v]).filter(|&q| q != NONE)
    }

    /// The point inside an edge at `at`, in the chart of the canonical half-edge.
    pub fn in_edge(&self, e: EdgeId, at: LatticePoint) -> Option<u32> {
        // Edge points are monotone in both coordinates: a linear order along the edge.
        let range = self.first_of_edge[e.index()]..self.first_of_edge[e.index() + 1];
        let list = &self.points[range.start as usize..range.end as usize];
        let ascending = list.len() < 2 || list[0].at < list[1].at;
        list.binary_search_by(|p| if ascending { p.at.cmp(&at) } else { at.cmp(&p.at) })
            .ok()
            .map(|k| range.start + k as u32)
    }

    /// The point inside a face at `at`, in the face's chart.
    pub fn in_face(&self, f: FaceId, at: LatticePoint) -> Option<u32> {
        let range = self.first_of_face[f.index()]..self.first_of_face[f.index() + 1];
        self.points[range.start as usize..range.end as usize]
            .binary_search_by_key(&[at[1], at[0]], |p| [p.at[1], p.at[0]])
            .ok()
            .map(|k| range.start + k as u32)
    }
}

/// Grid points strictly inside the segment from `a` to `b`, in this order.
fn points_inside_edge(a: LatticePoint, b: LatticePoint, mut found: impl FnMut(LatticePoint)) {
    let d = difference(a, b);
    // Walk along the axis with fewer integer lines across it, unless the edge is parallel to those lines.
    let axis = usize::from(d[0] == 0 || (d[1] != 0 && d[1].abs() < d[0].abs()));
    if d[axis] == 0 {
        return;
    }
    let mut visit = |k: i64| {
        let here = k * GRID_UNIT;
        let numerator = i128::from(d[1 - axis]) * i128::from(here - a[axis]);
        let denominator = i128::from(d[axis]);
        if numerator % denominator != 0 {
            return;
        }
        let other = a[1 - axis] + (numerator / denominator) as i64;
        if other % GRID_UNIT == 0 {
            found(if axis == 0 { [here, other] } else { [other, here] });
        }
    };
    let range = grid_units_between(a[axis], b[axis]);
    if d[axis] > 0 { range.for_each(&mut visit) } else { range.rev().for_each(&mut visit) }
}

/// Grid points strictly inside a triangle of either orientation, ascending by (v, u).
fn points_inside_triangle(corner: [LatticePoint; 3], mut found: impl FnMut(LatticePoint)) {
    let low = corner.iter().map(|p| p[1]).min().unwrap_or(0);
    let high = corner.iter().map(|p| p[1]).max().unwrap_or(0);
    for row in grid_units_between(low, high) {
        let y = row * GRID_UNIT;
        let mut crossing = [(0i128, 0i128); 2];
        let mut count = 0;
        for k in 0..3 {
            let (p, q) = (corner[k], corner[(k + 1) % 3]);
            if (p[1] <= y) != (q[1] <= y) {
                let d = difference(p, q).map(i128::from);
                let numerator = i128::from(p[0]) * d[1] + d[0] * i128::from(y - p[1]);
                crossing[count] = strict_neighbours(numerator, d[1] * i128::from(GRID_UNIT));
                count += 1;
            }
        }
        // Below one crossing and above the other: at most one of the two ranges is not empty.
        let [a, b] = crossing;
        for column in (a.1..=b.0).chain(b.1..=a.0) {
            found([column as i64 * GRID_UNIT, y]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use quadloom_param::integer_grid_map::signed_area;

    fn by_brute_force(corner: [LatticePoint; 3]) -> Vec<LatticePoint> {
        let mut list = Vec::new();
        for y in -12..=12 {
            for x in -12..=12 {
                let p = [x * GRID_UNIT, y * GRID_UNIT];
                let s: Vec<i128> = (0..3).map(|k| signed_area(corner[k], corner[(k + 1) % 3], p).signum()).collect();
                if s[0] != 0 && s.iter().all(|&x| x == s[0]) {
                    list.push(p);
                }
            }
        }
        list
    }

    /// Coordinates that meet the integer lines often.
    fn coordinate() -> impl Strategy<Value = i64> {
        prop_oneof![
            (-10i64..=10).prop_map(|k| k * GRID_UNIT),
            (-20i64..=20).prop_map(|k| k * GRID_UNIT / 2),
            (-10 * GRID_UNIT)..(10 * GRID_UNIT)
        ]
    }

    proptest! {
        #[test]
        fn triangles_as_by_brute_force(c in proptest::array::uniform6(coordinate())) {
            let corner = [[c[0], c[1]], [c[2], c[3]], [c[4], c[5]]];
            let mut list = Vec::new();
            points_inside_triangle(corner, |p| list.push(p));
            prop_assert_eq!(list, by_brute_force(corner));
        }

        #[test]
        fn edges_as_by_brute_force(c in proptest::array::uniform4(coordinate())) {
            let (a, b) = ([c[0], c[1]], [c[2], c[3]]);
            let mut list = Vec::new();
            points_inside_edge(a, b, |p| list.push(p));
            let dot = |p: LatticePoint, q: LatticePoint, r: LatticePoint| {
                let (u, v) = (difference(p, q), difference(p, r));
                i128::from(u[0]) * i128::from(v[0]) + i128::from(u[1]) * i128::from(v[1])
            };
            let mut expected = Vec::new();
            for y in -12..=12 {
                for x in -12..=12 {
                    let p = [x * GRID_UNIT, y * GRID_UNIT];
                    if signed_area(a, b, p) == 0 && dot(p, a, b) < 0 {
                        expected.push(p);
                    }
                }
            }
            expected.sort_by_key(|&p| dot(a, b, p));
            prop_assert_eq!(list, expected);
        }
    }
}
