//! A map whose integers are decided: one free point per vertex, exact transitions everywhere.
//!
//! In: charts and a solution with integer translations, singular vertices and features. Out: [`PlacedMap`],
//! and from it the exact [`IntegerGridMap`]. Holds: all images of a vertex are images of one point under exact
//! grid automorphisms, so that moving vertices can never tear the map.
//! Source: [Bommes2012] §6, Eq. (6.1); consistency by construction as asked for in [Ebke2013] §4.

use crate::charts::Charts;
use crate::fans::{Saddle, is_wrong, saddles, wide_corners};
use crate::integer_grid_map::{GRID_UNIT, IntegerGridMap, LatticePoint, Transition, rotate};
use quadloom_mesh::{CornerMap, EdgeMap, FaceId, HalfEdgeMap, TriConnectivity, VertexId, VertexMap};
use std::sync::Arc;

/// A map with fixed integers and movable vertices.
#[derive(Clone, Debug)]
pub struct PlacedMap {
    /// Point of each vertex in the chart of its first outgoing half-edge, grid units.
    pub point: VertexMap<[f64; 2]>,
    /// Which coordinates of the point are fixed.
    pub fixed: VertexMap<[bool; 2]>,
    /// From that chart to the chart of each corner, translations in lattice units.
    pub to_corner: Arc<CornerMap<Transition>>,
    /// Transition across each half-edge.
    pub transition: Arc<HalfEdgeMap<Transition>>,
    /// Interior singular vertices with more than four quarter turns, ascending.
    pub saddles: Vec<Saddle>,
    /// Sectors between features with three quarter turns or more, ascending.
    pub wide_corners: Vec<Saddle>,
}

/// A solution that does not close up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PlacementError {
    /// The transitions around a regular vertex are not the identity.
    #[error("the transitions around regular vertex {0} do not close")]
    Holonomy(VertexId),
    /// A singular vertex is not the fixed point of its transitions.
    #[error("singular vertex {0} is not the fixed point of the transitions around it")]
    FixedPoint(VertexId),
}

impl PlacedMap {
    /// Rounds the integers of a solution and ties every corner to its vertex.
    ///
    /// # Input      `solution`: variables as numbered in [`crate::problem`], in units of `unit` lattice units;
    /// [`GRID_UNIT`] for an integer-grid map, a fraction of it for a seamless map on a finer grid
    /// # Errors     the first vertex at which transitions do not close
    pub fn new(mesh: &TriConnectivity, charts: &Charts, solution: &[f64], unit: i64) -> Result<Self, PlacementError> {
        // 1. Transitions: identity, or the rounded translation of the segment.
        let mut transition = HalfEdgeMap::filled(mesh.half_edge_count(), Transition::IDENTITY);
        for (s, segment) in charts.segments.iter().enumerate() {
            let t = 2 * (charts.node_count + s);
            let translation = [solution[t], solution[t + 1]].map(|x| (x.round() as i64) * unit);
            let forward = Transition { quarter_turns: segment.quarter_turns, translation };
            for &h in &segment.sides {
                transition[h] = forward;
                if let Some(twin) = mesh.twin(h) {
                    transition[twin] = forward.inverse();
                }
            }
        }
        // 2. From each vertex to its corners.
        let mut to_corner = CornerMap::filled(mesh.half_edge_count(), Transition::IDENTITY);
        let mut around = VertexMap::filled(mesh.vertex_count(), Transition::IDENTITY);
        for v in mesh.vertices() {
            let mut at = Transition::IDENTITY;
            for h in mesh.outgoing(v) {
                to_corner[h] = at;
                at = at.followed_by(transition[mesh.prev(h)]);
            }
            if !mesh.is_boundary_vertex(v) {
                around[v] = at;
            }
        }
        // 3. Points; integer coordinates are rounded and fixed.
        let mut fixed = VertexMap::from_fn(mesh.vertex_count(), |v| [charts.is_integer[v]; 2]);
        fix_features(mesh, charts, &to_corner, &mut fixed);
        let point = VertexMap::from_fn(mesh.vertex_count(), |v| {
            let n = 2 * charts.node[mesh.outgoing_half_edge(v)] as usize;
            let scale = unit as f64 / GRID_UNIT as f64;
            std::array::from_fn(|k| scale * if fixed[v][k] { solution[n + k].round() } else { solution[n + k] })
        });
        // 4. Exact closure.
        for v in mesh.vertices().filter(|&v| around[v] != Transition::IDENTITY) {
            if !charts.is_integer[v] {
                return Err(PlacementError::Holonomy(v));
            }
            let p = point[v].map(|x| (x * GRID_UNIT as f64).round() as i64);
            if around[v].apply(p) != p {
                return Err(PlacementError::FixedPoint(v));
            }
        }
        // 5. Turns that triangles without inversion can still miss.
        let (saddles, wide_corners) = (saddles(mesh, charts), wide_corners(charts));
        let (to_corner, transition) = (Arc::new(to_corner), Arc::new(transition));
        Ok(Self { point, fixed, to_corner, transition, saddles, wide_corners })
    }

    /// Image of a corner, grid units.
    #[inline]
    pub fn corner(&self, mesh: &TriConnectivity, h: quadloom_mesh::CornerId) -> [f64; 2] {
        let t = self.to_corner[h];
        let p = turn(self.point[mesh.origin(h)], t.quarter_turns);
        std::array::from_fn(|k| p[k] + t.translation[k] as f64 / GRID_UNIT as f64)
    }

    /// Images of the corners of a face, grid units.
    #[inline]
    pub fn face(&self, mesh: &TriConnectivity, f: FaceId) -> [[f64; 2]; 3] {
        mesh.face_half_edges(f).map(|h| self.corner(mesh, h))
    }

    /// The exact map: free coordinates are rounded to the lattice, then carried to every corner.
    pub fn to_lattice(&self, mesh: &TriConnectivity) -> IntegerGridMap {
        let point: VertexMap<LatticePoint> = self.point.map(|p| p.map(|x| (x * GRID_UNIT as f64).round() as i64));
        let uv = CornerMap::from_fn(mesh.half_edge_count(), |h| self.to_corner[h].apply(point[mesh.origin(h)]));
        IntegerGridMap { uv, transition: (*self.transition).clone() }
    }

    /// The fans that can turn wrongly without a fold.
    pub fn fans(&self) -> impl Iterator<Item = Saddle> {
        self.saddles.iter().chain(&self.wide_corners).copied()
    }

    /// Those at some vertices, first the saddles, then the wide corners; and whether each is a saddle.
    ///
    /// # Cost       logarithmic per vertex
    pub fn fans_at<'a>(&'a self, vertices: &'a [VertexId]) -> impl Iterator<Item = (Saddle, bool)> + 'a {
        fn at(fans: &[Saddle], v: VertexId) -> impl Iterator<Item = Saddle> {
            let from = fans.partition_point(|s| s.vertex < v);
            fans[from..].iter().copied().take_while(move |s| s.vertex == v)
        }
        let of = move |fans: &'a [Saddle]| vertices.iter().flat_map(move |&v| at(fans, v));
        of(&self.saddles).map(|s| (s, true)).chain(of(&self.wide_corners).map(|s| (s, false)))
    }

    /// Inverted or degenerate faces of the exact map and the faces around wrongly wound fans, ascending.
    pub fn folded_faces(&self, mesh: &TriConnectivity) -> Vec<FaceId> {
        let mut folded = self.to_lattice(mesh).inverted_faces(mesh);
        for saddle in self.fans().filter(|&s| is_wrong(mesh, self, s)) {
            folded.extend(saddle.fan(mesh).map(|h| mesh.face(h)));
        }
        folded.sort_unstable();
        folded.dedup();
        folded
    }
}

/// A vector turned counter-clockwise by quarter turns.
#[inline]
pub fn turn(p: [f64; 2], quarter_turns: u8) -> [f64; 2] {
    match quarter_turns % 4 {
        0 => p,
        1 => [-p[1], p[0]],
        2 => [-p[0], -p[1]],
        _ => [p[1], -p[0]],
    }
}

/// Along a feature the coordinate across it is fixed, in the chart of the vertex.
fn fix_features(
    mesh: &TriConnectivity,
    charts: &Charts,
    to_corner: &CornerMap<Transition>,
    fixed: &mut VertexMap<[bool; 2]>,
) {
    let axis: &EdgeMap<Option<u8>> = &charts.feature_axis;
    for e in mesh.edges() {
        let Some(axis) = axis[e] else { continue };
        let h = mesh.half_edge(e);
        for corner in [h, mesh.next(h)] {
            // The u axis of the corner's chart is a turned axis of the vertex' chart.
            let across = (u32::from(axis) + 1 + u32::from(to_corner[corner].quarter_turns)) % 2;
            fixed[mesh.origin(corner)][across as usize] = true;
        }
    }
    debug_assert!(rotate([1, 0], 1) == [0, 1]);
}
