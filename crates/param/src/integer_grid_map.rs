//! Integer-grid maps on a fixed-point lattice: the exact hand-over from parametrisation to extraction.
//!
//! In: a triangle mesh, lattice coordinates per corner, transitions per half-edge.
//! Out: [`IntegerGridMap`]; [`IntegerGridMap::check`] lists every violated condition of its definition.
//! Holds after a clean check: transitions are grid automorphisms, singular vertices are integer points, every
//! triangle is positively oriented, features lie on integer iso-lines. All decisions are integer arithmetic.
//! Source: [Bommes2012] §6, Eqs. (6.1)-(6.3); the fixed-point lattice follows the idea of [Ebke2013] §4.

use quadloom_mesh::{CornerMap, EdgeId, FaceId, FeatureGraph, HalfEdgeId, HalfEdgeMap, TriConnectivity, VertexId};
use serde::{Deserialize, Serialize};

/// Binary digits behind the point: one grid unit is 2^24 lattice units.
///
/// More digits represent thinner triangles; 24 leave 39 bits before the point, and every determinant fits 128 bits.
pub const LATTICE_BITS: u32 = 24;

/// One grid unit in lattice units.
pub const GRID_UNIT: i64 = 1 << LATTICE_BITS;

/// A point of the parameter plane, lattice units.
pub type LatticePoint = [i64; 2];

/// Rotation by quarter turns followed by a translation ([Bommes2012] §6, Eq. (6.1)).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Transition {
    /// Counter-clockwise quarter turns, 0..4.
    pub quarter_turns: u8,
    /// Translation, lattice units; a multiple of [`GRID_UNIT`] in an integer-grid map.
    pub translation: LatticePoint,
}

impl Transition {
    /// The identity.
    pub const IDENTITY: Self = Self { quarter_turns: 0, translation: [0, 0] };

    /// Image of a point.
    #[inline]
    pub fn apply(self, p: LatticePoint) -> LatticePoint {
        let r = rotate(p, self.quarter_turns);
        [r[0] + self.translation[0], r[1] + self.translation[1]]
    }

    /// The transition back.
    pub fn inverse(self) -> Self {
        let quarter_turns = (4 - self.quarter_turns) % 4;
        let t = rotate(self.translation, quarter_turns);
        Self { quarter_turns, translation: [-t[0], -t[1]] }
    }

    /// First `self`, then `then`.
    pub fn followed_by(self, then: Self) -> Self {
        Self { quarter_turns: (self.quarter_turns + then.quarter_turns) % 4, translation: then.apply(self.translation) }
    }
}

/// A vector turned counter-clockwise by quarter turns.
#[inline]
pub fn rotate(p: LatticePoint, quarter_turns: u8) -> LatticePoint {
    match quarter_turns % 4 {
        0 => p,
        1 => [-p[1], p[0]],
        2 => [-p[0], -p[1]],
        _ => [p[1], -p[0]],
    }
}

/// Twice the signed area of a lattice triangle, exactly.
#[inline]
pub fn signed_area(a: LatticePoint, b: LatticePoint, c: LatticePoint) -> i128 {
    let d =
        |p: LatticePoint, q: LatticePoint| [i128::from(q[0]) - i128::from(p[0]), i128::from(q[1]) - i128::from(p[1])];
    let (u, v) = (d(a, b), d(a, c));
    u[0] * v[1] - u[1] * v[0]
}

/// A map of every triangle into the plane whose integer iso-lines stitch to a quad mesh.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct IntegerGridMap {
    /// Image of every corner in the chart of its face, lattice units.
    pub uv: CornerMap<LatticePoint>,
    /// Change from the chart of a half-edge's face to the chart of the face across; identity on the boundary.
    pub transition: HalfEdgeMap<Transition>,
}

/// A violated condition of [`IntegerGridMap`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MapDefect {
    /// The transition does not carry one image of the edge onto the other.
    #[error("the images of edge side {0} do not agree across its transition")]
    Seam(HalfEdgeId),
    /// The translation is not a whole number of grid units.
    #[error("the transition across edge side {0} is not an integer translation")]
    FractionalTransition(HalfEdgeId),
    /// A singular vertex is not at an integer point.
    #[error("singular vertex {0} is not at an integer point")]
    FractionalSingularity(VertexId),
    /// A triangle is mapped with non-positive orientation.
    #[error("face {0} is inverted or degenerate in the map")]
    Inverted(FaceId),
    /// A feature edge is not on an integer iso-line.
    #[error("feature edge {0} is not on an integer iso-line")]
    Feature(EdgeId),
}

impl IntegerGridMap {
    /// Images of the corners of a face, lattice units.
    pub fn face_uv(&self, mesh: &TriConnectivity, f: FaceId) -> [LatticePoint; 3] {
        mesh.face_half_edges(f).map(|h| self.uv[h])
    }

    /// Images of the corners of a face, grid units, to rounding.
    pub fn face_in_units(&self, mesh: &TriConnectivity, f: FaceId) -> [[f64; 2]; 3] {
        self.face_uv(mesh, f).map(|p| p.map(|x| x as f64 / GRID_UNIT as f64))
    }

    /// Twice the signed area of a face's image, lattice units squared.
    pub fn face_area(&self, mesh: &TriConnectivity, f: FaceId) -> i128 {
        let [a, b, c] = self.face_uv(mesh, f);
        signed_area(a, b, c)
    }

    /// Faces of non-positive orientation, ascending ([Bommes2012] §6, Eq. (6.3)).
    pub fn inverted_faces(&self, mesh: &TriConnectivity) -> Vec<FaceId> {
        mesh.faces().filter(|&f| self.face_area(mesh, f) <= 0).collect()
    }

    /// Quarter turns that the map misses around a vertex: valence 3 gives 1, valence 5 gives -1, regular 0.
    ///
    /// From the transitions alone, as the total turn that they make around the vertex (modulo 4, in -1..=2);
    /// boundary vertices are not looked at and give 0.
    pub fn cone(&self, mesh: &TriConnectivity, v: VertexId) -> i32 {
        if mesh.is_boundary_vertex(v) {
            return 0;
        }
        let turns: u32 = mesh.outgoing(v).map(|h| u32::from(self.transition[h].quarter_turns)).sum();
        // Outgoing half-edges are crossed clockwise, which sees the missing turns as additional ones.
        match (4 - turns % 4) % 4 {
            3 => -1,
            t => t as i32,
        }
    }

    /// Quarters of the full angle that the triangles around an interior vertex cover in the map: exactly 4 at a regular
    /// one, 4 minus the index elsewhere.
    ///
    /// Unlike [`IntegerGridMap::cone`] it sees triangles that wind around the vertex twice without being inverted.
    /// Counted as the axis directions passed, triangles of negative orientation counting against the others.
    pub fn quarters(&self, mesh: &TriConnectivity, v: VertexId) -> i32 {
        let axes = [[1, 0], [0, 1], [-1, 0], [0, -1]];
        let quarters = |h: HalfEdgeId| {
            let [o, a, b] = [h, mesh.next(h), mesh.prev(h)].map(|c| self.uv[c]);
            let sign = signed_area(o, a, b).signum();
            // The half-open sector from the first arm to the second, of less than half a turn.
            let (first, second) = if sign > 0 { (a, b) } else { (b, a) };
            let within = |d: &&[i64; 2]| {
                let tip = [o[0] + d[0], o[1] + d[1]];
                let (from_first, to_second) = (signed_area(o, first, tip), signed_area(o, tip, second));
                let on_first = from_first == 0 && (0..2).any(|k| i128::from(d[k]) * i128::from(first[k] - o[k]) > 0);
                on_first || (from_first > 0 && to_second > 0)
            };
            if sign == 0 { 0 } else { sign as i32 * axes.iter().filter(within).count() as i32 }
        };
        mesh.outgoing(v).map(quarters).sum()
    }

    /// Every violated condition, ascending by kind and id; empty for an integer-grid map.
    ///
    /// # Cost       linear
    /// # Source     [Bommes2012] §6, Eqs. (6.1), (6.2), (6.3); §8.4 for features
    pub fn check(&self, mesh: &TriConnectivity, features: &FeatureGraph) -> Vec<MapDefect> {
        let mut defects = Vec::new();
        for h in mesh.half_edges() {
            let (t, Some(twin)) = (self.transition[h], mesh.twin(h)) else { continue };
            let here = [self.uv[h], self.uv[mesh.next(h)]].map(|p| t.apply(p));
            if here != [self.uv[mesh.next(twin)], self.uv[twin]] || self.transition[twin] != t.inverse() {
                defects.push(MapDefect::Seam(h));
            }
            if t.translation.iter().any(|x| x % GRID_UNIT != 0) {
                defects.push(MapDefect::FractionalTransition(h));
            }
        }
        for v in mesh.vertices() {
            let at = self.uv[mesh.outgoing_half_edge(v)];
            let singular = !mesh.is_boundary_vertex(v) && (self.cone(mesh, v) != 0 || self.quarters(mesh, v) != 4);
            if singular && at.iter().any(|x| x % GRID_UNIT != 0) {
                defects.push(MapDefect::FractionalSingularity(v));
            }
        }
        defects.extend(self.inverted_faces(mesh).into_iter().map(MapDefect::Inverted));
        for e in mesh.edges().filter(|&e| features.is_feature(e)) {
            let h = mesh.half_edge(e);
            let (p, q) = (self.uv[h], self.uv[mesh.next(h)]);
            if !(0..2).any(|k| p[k] == q[k] && p[k] % GRID_UNIT == 0) {
                defects.push(MapDefect::Feature(e));
            }
        }
        defects
    }
}
