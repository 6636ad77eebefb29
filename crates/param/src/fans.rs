//! The triangles around singular vertices of negative index and in the wide corners between features, which can be free
//! of folds and yet wound wrongly.
//!
//! In: a [`PlacedMap`]. Out: which of its fans turn by less than their vertex demands; a placement that turns rightly.
//! Holds: where no triangle is inverted and no fan here is wrong, every vertex is wound as its transitions and features
//! demand: triangles give half a turn each whatever their shape, so that a vertex that turns by a full turn too much
//! needs another that turns by one too little, which positive triangles allow from five quarters on. Between features
//! it takes half a turn, where a feature runs backwards, and three quarters: a notch of the boundary whose corner is
//! drawn as an ordinary one makes a vertex further along turn by four.
//!
//! ```text
//!   valence 5, right: five quarter turns      wrong: one quarter turn, all triangles positive;
//!                                             a regular vertex nearby turns by eight
//! ```
//!
//! Differs from [Bommes2012] §8.4, where fold-free is taken for valid.

use crate::charts::{Charts, Sector};
use crate::integer_grid_map::GRID_UNIT;
use crate::placed::{PlacedMap, turn};
use crate::problem::FaceGradient;
use quadloom_mesh::{DVec2, FaceMap, HalfEdgeId, TriConnectivity, VertexId};
use std::f64::consts::{FRAC_PI_2, PI};

/// Distance of the placed neighbours from the singular vertex, relative to their distance without distortion.
///
/// Larger: the fan reaches over neighbours that the rounding has moved near. Smaller: thinner triangles to start from.
const FAN_SIZE: f64 = 0.2;

/// A vertex, some corners in a row around it, and the quarter turns that they make.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Saddle {
    /// The vertex.
    pub vertex: VertexId,
    /// Quarter turns that the map has to make over the corners: at least 5 all around, at least 3 between features.
    pub quarters: u32,
    /// The corner from which the others follow counter-clockwise.
    pub first: HalfEdgeId,
    /// Number of corners.
    pub corners: u32,
}

impl Saddle {
    /// The corners, counter-clockwise.
    pub fn fan(self, mesh: &TriConnectivity) -> impl Iterator<Item = HalfEdgeId> {
        std::iter::successors(Some(self.first), |&h| mesh.rotate_ccw(h)).take(self.corners as usize)
    }

    /// Whether the corners are all there are around an interior vertex.
    fn is_closed(self, mesh: &TriConnectivity) -> bool {
        self.fan(mesh).last().and_then(|h| mesh.rotate_ccw(h)) == Some(self.first)
    }
}

/// The interior singular vertices of negative index, ascending.
pub fn saddles(mesh: &TriConnectivity, charts: &Charts) -> Vec<Saddle> {
    let is_saddle = |&(v, index): &(VertexId, i32)| index < 0 && !mesh.is_boundary_vertex(v);
    let saddle = |&(vertex, index): &(VertexId, i32)| Saddle {
        vertex,
        quarters: 4 + index.unsigned_abs(),
        first: mesh.outgoing_half_edge(vertex),
        corners: mesh.outgoing(vertex).count() as u32,
    };
    charts.singular.iter().filter(|s| is_saddle(s)).map(saddle).collect()
}

/// The sectors between features that are wide enough to turn wrongly without a fold, ascending.
pub fn wide_corners(charts: &Charts) -> Vec<Saddle> {
    let corner = |s: &Sector| Saddle {
        vertex: s.vertex,
        quarters: s.quarters.max(0) as u32,
        first: s.first,
        corners: s.inside.len() as u32 + 1,
    };
    charts.wide_sectors.iter().map(corner).collect()
}

/// Whether the triangles around a saddle, counted with their orientation, make the wrong number of turns.
pub fn is_wrong(mesh: &TriConnectivity, map: &PlacedMap, saddle: Saddle) -> bool {
    let angle = |h: HalfEdgeId| {
        let [o, a, b] = [h, mesh.next(h), mesh.prev(h)].map(|c| DVec2::from(map.corner(mesh, c)));
        (a - o).perp_dot(b - o).atan2((a - o).dot(b - o))
    };
    let sum: f64 = saddle.fan(mesh).map(angle).sum();
    (sum / FRAC_PI_2 - f64::from(saddle.quarters)).abs() > 0.5
}

/// Neighbours of a saddle with places that make its fan turn rightly; `None` where one of them is not free to move or
/// a triangle would take half a turn.
///
/// The directions keep the ratios of the angles on the surface and follow the field on average; those of features are
/// axes.
pub fn unfolded(
    mesh: &TriConnectivity,
    map: &PlacedMap,
    gradient: &FaceMap<FaceGradient>,
    saddle: Saddle,
) -> Option<Vec<(VertexId, [f64; 2])>> {
    let fan: Vec<HalfEdgeId> = saddle.fan(mesh).collect();
    let is_closed = saddle.is_closed(mesh);
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
    let mut common = wanted.to_angle();
    if !is_closed {
        common = (common / FRAC_PI_2).round() * FRAC_PI_2;
    }
    // 3. Places, carried to each neighbour's own chart.
    let mut places = Vec::with_capacity(fan.len() + 1);
    let mut lay = |h: HalfEdgeId, corner_of_w: HalfEdgeId, length: f64, direction: f64, is_side: bool| {
        let w = mesh.origin(corner_of_w);
        // Along a feature one coordinate is free.
        let fixed = map.fixed[w];
        if fixed == [true; 2] || (fixed != [false; 2] && !is_side) {
            return None;
        }
        let centre = DVec2::from(map.corner(mesh, h));
        let place = centre + FAN_SIZE * length * DVec2::from_angle(direction + common);
        let t = map.to_corner[corner_of_w];
        let back = [0, 1].map(|k| place[k] - t.translation[k] as f64 / GRID_UNIT as f64);
        let free = turn(back, (4 - t.quarter_turns) % 4);
        places.push((w, [0, 1].map(|k| if fixed[k] { map.point[w][k] } else { free[k] })));
        Some(())
    };
    for (i, (&h, side)) in fan.iter().zip(&sides).enumerate() {
        lay(h, mesh.next(h), side[0].length(), direction[i], !is_closed && i == 0)?;
    }
    if let (false, Some((&h, side))) = (is_closed, fan.iter().zip(&sides).next_back()) {
        let turned = f64::from(map.to_corner[h].quarter_turns) * FRAC_PI_2;
        lay(h, mesh.prev(h), side[1].length(), at + turned, true)?;
    }
    Some(places)
}

/// The two sides of a corner in the chart of its face, without distortion.
pub(crate) fn undistorted(mesh: &TriConnectivity, gradient: &FaceMap<FaceGradient>, h: HalfEdgeId) -> [DVec2; 2] {
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
            saddles: vec![Saddle { vertex: VertexId(0), quarters: 5, first: HalfEdgeId(0), corners: n }],
            wide_corners: Vec::new(),
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

    /// Six equal triangles in a notch of the boundary of three quarter turns, drawn with `quarters` of them.
    fn notch(quarters: f64) -> (quadloom_mesh::TriMesh, PlacedMap) {
        let at = |k: u32, quarters: f64| DVec2::from_angle(f64::from(k) / 6.0 * quarters * FRAC_PI_2);
        let positions =
            std::iter::once(quadloom_mesh::DVec3::ZERO).chain((0..7).map(|k| at(k, 3.0).extend(0.0))).collect();
        let faces: Vec<[u32; 3]> = (0..6).map(|k| [0, k + 1, k + 2]).collect();
        let mesh = quadloom_mesh::TriMesh::new(positions, &faces).expect("a notched disk");
        let corner =
            Saddle { vertex: VertexId(0), quarters: 3, first: mesh.outgoing_half_edge(VertexId(0)), corners: 6 };
        let map = PlacedMap {
            point: quadloom_mesh::VertexMap::from_fn(mesh.vertex_count(), |v| match v.0 {
                0 => [0.0; 2],
                k => at(k - 1, quarters).into(),
            }),
            // The boundary runs along the axes: its neighbours move along them.
            fixed: quadloom_mesh::VertexMap::from_fn(mesh.vertex_count(), |v| match v.0 {
                0 => [true; 2],
                k => [k == 7, k == 1],
            }),
            to_corner: quadloom_mesh::CornerMap::filled(mesh.half_edge_count(), Transition::IDENTITY).into(),
            transition: quadloom_mesh::HalfEdgeMap::filled(mesh.half_edge_count(), Transition::IDENTITY).into(),
            saddles: Vec::new(),
            wide_corners: vec![corner],
        };
        (mesh, map)
    }

    #[test]
    fn a_notch_whose_boundary_runs_backwards_counts_as_folded_and_is_laid_out_again() {
        let (mesh, mut wrong) = notch(1.0);
        let corner = wrong.wide_corners[0];
        assert!(wrong.to_lattice(&mesh).inverted_faces(&mesh).is_empty(), "all triangles are positive");
        assert!(is_wrong(&mesh, &wrong, corner));
        assert_eq!(wrong.folded_faces(&mesh), mesh.faces().collect::<Vec<_>>());
        let gradient = FaceMap::from_fn(mesh.face_count(), |f| {
            let p = mesh.face_vertices(f).map(|v| mesh.position(v).truncate());
            let twice = (p[1] - p[0]).perp_dot(p[2] - p[0]);
            FaceGradient { hat: [0, 1, 2].map(|k| (p[(k + 2) % 3] - p[(k + 1) % 3]).perp() / twice), area: 0.5 * twice }
        });
        let places = unfolded(&mesh, &wrong, &gradient, corner).expect("all neighbours are free to move");
        assert_eq!(places.len(), 7);
        for (v, place) in places {
            assert!((0..2).all(|k| !wrong.fixed[v][k] || place[k] == wrong.point[v][k]), "on its axis");
            wrong.point[v] = place;
        }
        assert!(!is_wrong(&mesh, &wrong, corner));
        assert_eq!(wrong.folded_faces(&mesh), []);
        let (mesh, right) = notch(3.0);
        assert_eq!(right.folded_faces(&mesh), []);
    }
}
