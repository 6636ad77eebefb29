//! The triangles around singular vertices of negative index, which can be free of folds and yet wound wrongly.
//!
//! In: a [`PlacedMap`]. Out: which of its fans turn by less than their vertex demands; a placement that turns rightly.
//! Holds: where no triangle is inverted and no fan here is wrong, every interior vertex is wound as its transitions
//! demand: triangles give half a turn each whatever their shape, so that a vertex that turns by a full turn too much
//! needs another that turns by one too little, which positive triangles allow from five quarters on.
//!
//! ```text
//!   valence 5, right: five quarter turns      wrong: one quarter turn, all triangles positive;
//!                                             a regular vertex nearby turns by eight
//! ```
//!
//! Differs from [Bommes2012] §8.4, where fold-free is taken for valid.

use crate::charts::Charts;
use crate::integer_grid_map::GRID_UNIT;
use crate::placed::{PlacedMap, turn};
use crate::problem::FaceGradient;
use quadloom_mesh::{DVec2, FaceMap, HalfEdgeId, TriConnectivity, VertexId};
use std::f64::consts::{FRAC_PI_2, PI};

/// Distance of the placed neighbours from the singular vertex, relative to their distance without distortion.
///
/// Larger: the fan reaches over neighbours that the rounding has moved near. Smaller: thinner triangles to start from.
const FAN_SIZE: f64 = 0.2;

/// A singular vertex and the quarter turns around it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Saddle {
    /// The vertex, interior.
    pub vertex: VertexId,
    /// Quarter turns that the map has to make around it, at least 5.
    pub quarters: u32,
}

/// The interior singular vertices of negative index, ascending.
pub fn saddles(mesh: &TriConnectivity, charts: &Charts) -> Vec<Saddle> {
    let is_saddle = |&(v, index): &(VertexId, i32)| index < 0 && !mesh.is_boundary_vertex(v);
    let saddle = |&(vertex, index): &(VertexId, i32)| Saddle { vertex, quarters: 4 + index.unsigned_abs() };
    charts.singular.iter().filter(|s| is_saddle(s)).map(saddle).collect()
}

/// Whether the triangles around a saddle, counted with their orientation, make the wrong number of turns.
pub fn is_wrong(mesh: &TriConnectivity, map: &PlacedMap, saddle: Saddle) -> bool {
    let angle = |h: HalfEdgeId| {
        let [o, a, b] = [h, mesh.next(h), mesh.prev(h)].map(|c| DVec2::from(map.corner(mesh, c)));
        (a - o).perp_dot(b - o).atan2((a - o).dot(b - o))
    };
    let sum: f64 = mesh.outgoing(saddle.vertex).map(angle).sum();
    (sum / FRAC_PI_2 - f64::from(saddle.quarters)).abs() > 0.5
}

/// Neighbours of a saddle with places that make its fan turn rightly; `None` where one of them is not free to move or
/// a triangle would take half a turn.
///
/// The directions keep the ratios of the angles on the surface and follow the field on average.
pub fn unfolded(
    mesh: &TriConnectivity,
    map: &PlacedMap,
    gradient: &FaceMap<FaceGradient>,
    saddle: Saddle,
) -> Option<Vec<(VertexId, [f64; 2])>> {
    let fan: Vec<HalfEdgeId> = mesh.outgoing(saddle.vertex).collect();
    // 1. Undistorted sides and angles of the fan in the charts of its faces.
    let sides: Vec<[DVec2; 2]> = fan.iter().map(|&h| undistorted(mesh, gradient, h)).collect();
    let angles: Vec<f64> = sides.iter().map(|[a, b]| a.angle_to(*b)).collect();
    let scale = f64::from(saddle.quarters) * FRAC_PI_2 / angles.iter().sum::<f64>();
    if angles.iter().any(|a| scale * a >= 0.95 * PI) {
        return None;
    }
    // 2. Directions up to a common turn, which is the mean of what every face wants.
    let mut direction = Vec::with_capacity(fan.len());
    let (mut at, mut wanted) = (0.0, DVec2::ZERO);
    for ((&h, side), angle) in fan.iter().zip(&sides).zip(&angles) {
        let in_chart = at + f64::from(map.to_corner[h].quarter_turns) * FRAC_PI_2;
        direction.push(in_chart);
        wanted += DVec2::from_angle(side[0].to_angle() - in_chart);
        at += scale * angle;
    }
    let common = wanted.to_angle();
    // 3. Places, carried to each neighbour's own chart.
    let mut places = Vec::with_capacity(fan.len());
    for ((&h, side), direction) in fan.iter().zip(&sides).zip(direction) {
        let w = mesh.target(h);
        if map.fixed[w] != [false; 2] {
            return None;
        }
        let centre = DVec2::from(map.corner(mesh, h));
        let place = centre + FAN_SIZE * side[0].length() * DVec2::from_angle(direction + common);
        let t = map.to_corner[mesh.next(h)];
        let back = [0, 1].map(|k| place[k] - t.translation[k] as f64 / GRID_UNIT as f64);
        places.push((w, turn(back, (4 - t.quarter_turns) % 4)));
    }
    Some(places)
}

/// The two sides of a corner in the chart of its face, without distortion.
fn undistorted(mesh: &TriConnectivity, gradient: &FaceMap<FaceGradient>, h: HalfEdgeId) -> [DVec2; 2] {
    let face = &gradient[mesh.face(h)];
    let corners = mesh.face_half_edges(mesh.face(h));
    let k = corners.iter().position(|&c| c == h).unwrap_or(0);
    // The hat function of a corner falls across its opposite side: side = -perp(gradient)·2·area.
    let side = |i: usize| -face.hat[i % 3].perp() * (2.0 * face.area);
    [side(k + 2), -side(k + 1)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integer_grid_map::Transition;
    use quadloom_mesh::shapes;

    #[test]
    fn undistorted_sides_are_those_of_the_triangle() {
        let mesh = shapes::sphere(1.0, 2);
        let length = quadloom_mesh::metric::edge_lengths(&mesh);
        let gradient = FaceMap::from_fn(mesh.face_count(), |f| {
            let p = quadloom_mesh::metric::face_layout(&mesh, &length, f);
            let twice = (p[1] - p[0]).perp_dot(p[2] - p[0]);
            let hat = std::array::from_fn(|k| (p[(k + 2) % 3] - p[(k + 1) % 3]).perp() / twice);
            FaceGradient { hat, area: 0.5 * twice }
        });
        for f in mesh.faces() {
            let p = quadloom_mesh::metric::face_layout(&mesh, &length, f);
            for (k, h) in mesh.face_half_edges(f).into_iter().enumerate() {
                let [a, b] = undistorted(&mesh, &gradient, h);
                assert!(a.distance(p[(k + 1) % 3] - p[k]) < 1e-12 && b.distance(p[(k + 2) % 3] - p[k]) < 1e-12);
            }
        }
    }

    /// Ten equal triangles around a vertex of five quarter turns, drawn with `quarters` of them.
    fn fan(quarters: f64) -> (quadloom_mesh::TriMesh, PlacedMap) {
        let n = 10u32;
        let at = |k: u32, full: f64| DVec2::from_angle(f64::from(k) / f64::from(n) * full);
        let on_ring = |k: u32| at(k, std::f64::consts::TAU).extend(0.0);
        let positions = std::iter::once(quadloom_mesh::DVec3::ZERO).chain((0..n).map(on_ring)).collect();
        let faces: Vec<[u32; 3]> = (0..n).map(|k| [0, k + 1, (k + 1) % n + 1]).collect();
        let mesh = quadloom_mesh::TriMesh::new(positions, &faces).expect("a disk");
        let to_corner = quadloom_mesh::CornerMap::from_fn(mesh.half_edge_count(), |h| {
            // The last triangle sees the first vertex of the ring across the seam, a quarter turn further.
            let across = mesh.origin(h) == VertexId(1) && mesh.face(h).0 == n - 1;
            Transition { quarter_turns: u8::from(across), translation: [0, 0] }
        });
        let point = quadloom_mesh::VertexMap::from_fn(mesh.vertex_count(), |v| match v.0 {
            0 => [0.0; 2],
            k => at(k - 1, quarters * FRAC_PI_2).into(),
        });
        let map = PlacedMap {
            point,
            fixed: quadloom_mesh::VertexMap::filled(mesh.vertex_count(), [false; 2]),
            to_corner: to_corner.into(),
            transition: quadloom_mesh::HalfEdgeMap::filled(mesh.half_edge_count(), Transition::IDENTITY).into(),
            saddles: vec![Saddle { vertex: VertexId(0), quarters: 5 }],
        };
        (mesh, map)
    }

    #[test]
    fn a_fan_of_positive_triangles_that_winds_wrongly_counts_as_folded() {
        let (mesh, wrong) = fan(1.0);
        assert!(wrong.to_lattice(&mesh).inverted_faces(&mesh).is_empty(), "all triangles are positive");
        assert!(is_wrong(&mesh, &wrong, wrong.saddles[0]));
        assert_eq!(wrong.folded_faces(&mesh), mesh.faces().collect::<Vec<_>>());
        let (mesh, right) = fan(5.0);
        assert!(!is_wrong(&mesh, &right, right.saddles[0]));
        assert_eq!(right.folded_faces(&mesh), []);
    }
}
