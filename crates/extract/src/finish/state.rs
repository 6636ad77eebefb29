//! The moving vertices of finishing, and what may not get worse.
//!
//! In: ties and positions. Out: [`State`], with proposals that are taken back where they hurt a quad.
//! Holds: after [`State::advance`] no quad is worse than before, unless it is better than the floor.
//! Source: own.

use super::ties::{Move, Tie, Ties, project};
use crate::quality::{scaled_jacobian, worst_corner};
use crate::reference::{Facing, Reference};
use quadloom_mesh::{DVec3, FaceId, QuadMesh, VertexId, VertexMap};
use rayon::prelude::*;

/// Quads above this scaled Jacobian may get worse, down to it, for the sake of their neighbours.
///
/// Larger: sweeps stall at the first poor quad; smaller: single quads are given up for the mean.
pub(crate) const QUALITY_FLOOR: f64 = 0.5;

/// The same while vertices are put onto the surface: being there is worth more than a good quad.
const PROJECTED_FLOOR: f64 = 0.05;

/// Scaled Jacobian below which a quad counts as inverted.
const INVERTED: f64 = 0.005;

/// A vertex moves at most this part of the way to its neighbour along a curve, so that two never pass each other.
const CURVE_STEP_REL: f64 = 0.45;

/// Cosine between a quad's normal and the surface normals at its corners above which no query is needed.
const CLEARLY_FACING: f64 = 0.25;

/// Quality at most of a quad some of whose points face against the surface: it counts as inverted, but is not worse than
/// one that is degenerate, as the points may be nearest to the other side of a thin sheet.
const UNCLEAR: f64 = 0.0;

/// Distance from home to which single moves take a vertex, relative to the mean of its edges or of all.
///
/// Smaller: quads of a bunched fold are not pulled apart; larger: sheets that lie near are reached.
const HOME_REL: f64 = 2.0;

/// Mean length of edges between some positions.
pub(crate) fn mean_edge(quads: &QuadMesh, position: &VertexMap<DVec3>) -> f64 {
    let length = |[a, b]: [VertexId; 2]| position[a].distance(position[b]);
    let total: f64 = quads.edges().map(|e| length(quads.ends(e))).sum();
    total / quads.edge_count().max(1) as f64
}

/// Positions, ties and quality of a quad mesh on its way.
pub(crate) struct State<'a> {
    pub quads: &'a QuadMesh,
    pub reference: &'a Reference<'a>,
    pub position: VertexMap<DVec3>,
    pub tie: VertexMap<Tie>,
    along: VertexMap<[Option<VertexId>; 2]>,
    /// Vertices that stay where they are.
    pub pinned: VertexMap<bool>,
    /// Vertices that left their corner or curve, and where they were.
    pub left: Vec<(VertexId, Move)>,
    /// Where vertices are at home, and how far from there single moves may take them.
    home: VertexMap<(DVec3, f64)>,
    /// Quality of each quad: its scaled Jacobian; negative where it faces against the surface.
    pub quality: Vec<f64>,
    /// Whether quads face along the surface where its normals at their corners say so clearly, or that at their centre.
    trusting: bool,
}

impl<'a> State<'a> {
    /// The quads with their vertices put onto what they are tied to, except where that would invert a quad.
    ///
    /// # Output     the state, and the number of quads that are bad as they came
    pub fn new(quads: &'a QuadMesh, reference: &'a Reference<'a>, ties: Ties) -> (Self, usize) {
        let Ties { position: tied, tie: wanted, along, .. } = ties;
        let position = quads.positions().clone();
        let tie = VertexMap::from_fn(quads.vertex_count(), |v| wanted[v].off_surface());
        let pinned = VertexMap::filled(quads.vertex_count(), false);
        let (left, quality) = (Vec::new(), Vec::new());
        let home = VertexMap::filled(quads.vertex_count(), (DVec3::ZERO, f64::INFINITY));
        let mut state = Self { quads, reference, position, tie, along, pinned, left, home, quality, trusting: true };
        state.quality = (0..quads.face_count()).into_par_iter().map(|f| state.measure(FaceId::new(f))).collect();
        let bad = state.bad_quads();
        let moves: Vec<Option<Move>> =
            quads.vertices().map(|v| Some(Move { position: tied[v], tie: wanted[v] })).collect();
        state.advance(&moves, PROJECTED_FLOOR);
        state.settle();
        (state, bad)
    }

    /// Vertices are at home where they are: single moves stay within a few edges, so that one at a quad without a cure
    /// does not run away across the surface.
    pub fn settle(&mut self) {
        let mean = mean_edge(self.quads, &self.position);
        self.home = VertexMap::from_fn(self.quads.vertex_count(), |v| {
            let p = self.position[v];
            let (sum, count) =
                self.quads.neighbours(v).fold((0.0, 0.0), |(sum, n), w| (sum + self.position[w].distance(p), n + 1.0));
            (p, HOME_REL * f64::max(mean, sum / count))
        });
    }

    /// Whether a single move may take a vertex to a place.
    pub fn is_near_home(&self, v: VertexId, place: DVec3) -> bool {
        let (home, reach) = self.home[v];
        place.distance(home) <= reach
    }

    /// From now on looks at the surface between the corners of all quads.
    pub fn distrust_corners(&mut self) {
        self.trusting = false;
        self.quality = (0..self.quads.face_count()).into_par_iter().map(|f| self.measure(FaceId::new(f))).collect();
    }

    /// Number of inverted quads.
    pub fn bad_quads(&self) -> usize {
        self.quads.faces().filter(|&f| self.is_bad(f)).count()
    }

    /// Puts vertices that a quad kept off the surface or their curve onto it where that no longer inverts one.
    pub fn project_all(&mut self) {
        let place = |v: VertexId| {
            let there = self.displaced(v, DVec3::ZERO, self.vertex_normal(v))?;
            (there.position != self.position[v]).then_some(there)
        };
        let moves: Vec<Option<Move>> =
            (0..self.quads.vertex_count()).into_par_iter().map(|v| place(VertexId::new(v))).collect();
        self.advance(&moves, PROJECTED_FLOOR);
    }

    /// Positions of a quad's corners.
    pub fn corners(&self, f: FaceId) -> [DVec3; 4] {
        self.quads.face_vertices(f).map(|v| self.position[v])
    }

    /// Quality of a quad at the current positions.
    pub fn measure(&self, f: FaceId) -> f64 {
        let corner = self.corners(f);
        let jacobian = scaled_jacobian(corner);
        match self.facing(f, corner) {
            Facing::Along => jacobian,
            Facing::Wrinkled | Facing::Unclear => jacobian.min(UNCLEAR),
            Facing::Against(normal) => worst_corner(corner, normal).min(0.0) - 1e-9,
        }
    }

    /// The worst scaled Jacobian of some quads, each with its own normal.
    pub fn worst_jacobian(&self, faces: &[FaceId]) -> f64 {
        faces.iter().map(|&f| scaled_jacobian(self.corners(f))).fold(f64::INFINITY, f64::min)
    }

    /// The worst quality of some quads, or an upper bound of it that is not above `limit`.
    pub fn worst_above(&self, faces: &[FaceId], limit: f64) -> f64 {
        // A quad that faces against the surface is negative, another one has its Jacobian, which costs no query.
        let bound = if limit >= 0.0 { self.worst_jacobian(faces) } else { f64::INFINITY };
        if bound <= limit {
            return bound;
        }
        let mut worst = f64::INFINITY;
        for &f in faces {
            worst = worst.min(self.measure(f));
            if worst <= limit {
                break;
            }
        }
        worst
    }

    /// How a quad faces.
    fn facing(&self, f: FaceId, corner: [DVec3; 4]) -> Facing {
        let normal = (corner[2] - corner[0]).cross(corner[3] - corner[1]);
        let vertices = self.quads.face_vertices(f);
        let (mut on_surface, mut clear, mut hint) = (0, 0, None);
        for v in vertices {
            if let Tie::Surface { face, normal: n } = self.tie[v] {
                on_surface += 1;
                clear += usize::from(n.dot(normal) > CLEARLY_FACING * normal.length());
                hint = hint.or(Some(face));
            }
        }
        if self.trusting && on_surface >= 3 && clear == on_surface {
            return Facing::Along;
        }
        let centre = corner.iter().sum::<DVec3>() / 4.0;
        let closest = &self.reference.closest;
        let nearest = hint.map_or_else(|| closest.query(centre), |face| closest.query_near(centre, face)).point.face;
        if self.trusting && self.reference.mesh.vector_area(nearest).dot(normal) > 0.0 {
            return Facing::Along;
        }
        self.reference.facing(corner, nearest)
    }

    /// Area-weighted normal of the quads around a vertex, not normalised.
    pub fn vertex_normal(&self, v: VertexId) -> DVec3 {
        let normal = |f: FaceId| {
            let [a, b, c, d] = self.corners(f);
            (c - a).cross(d - b)
        };
        self.quads.outgoing(v).map(|h| normal(self.quads.face(h))).sum()
    }

    /// The place that a displacement takes a vertex to, on what it is tied to; `None` if it cannot move.
    pub fn displaced(&self, v: VertexId, displacement: DVec3, normal: DVec3) -> Option<Move> {
        let p = self.position[v];
        match self.tie[v] {
            Tie::Fixed => None,
            Tie::Curve { .. } | Tie::Surface { .. } if self.pinned[v] => None,
            Tie::Surface { face, .. } => {
                let n = normal.normalize_or_zero();
                let tangential = displacement - n * displacement.dot(n);
                project(self.reference, p + tangential, normal, Some(face))
            }
            Tie::Curve { chain, arc } => {
                let curves = &self.reference.curves;
                let (back, ahead) = self.room(v, chain, arc)?;
                // The curve's direction over the distance to be moved, so that corners of the polyline do not stick.
                let reach = (0.5 * displacement.length()).max(1e-9 * curves.length(chain));
                let (a, b) = (curves.at(chain, arc - reach).position, curves.at(chain, arc + reach).position);
                let step = displacement.dot((b - a).normalize_or_zero());
                let c = curves.at(chain, arc + step.clamp(-CURVE_STEP_REL * back, CURVE_STEP_REL * ahead));
                Some(Move { position: c.position, tie: Tie::Curve { chain, arc: c.arc } })
            }
        }
    }

    /// Lengths along a curve from a vertex to its neighbours before and after it.
    fn room(&self, v: VertexId, chain: u32, arc: f64) -> Option<(f64, f64)> {
        let curves = &self.reference.curves;
        let total = curves.length(chain);
        let [Some(a), Some(b)] = self.along[v] else { return None };
        let arc_of = |w: VertexId| match self.tie[w] {
            Tie::Curve { chain: c, arc } if c == chain => Some(arc),
            _ => None,
        };
        let gap = |to: f64| {
            let d = to - arc;
            if curves.is_closed(chain) && total > 0.0 { d - total * (d / total).round() } else { d }
        };
        let (a, b) = match (arc_of(a), arc_of(b)) {
            (Some(a), Some(b)) => (gap(a), gap(b)),
            // A neighbour that is a corner lies at the end on its side.
            (Some(a), None) => (gap(a), if a < arc { total - arc } else { -arc }),
            (None, Some(b)) => (if b < arc { total - arc } else { -arc }, gap(b)),
            (None, None) => (-arc, total - arc),
        };
        (a * b < 0.0).then(|| (-a.min(b), a.max(b)))
    }

    /// Takes all moves at once, then takes back those at quads that got worse and are below `floor`, until none is.
    ///
    /// # Output     largest distance moved, file units
    pub fn advance(&mut self, moves: &[Option<Move>], floor: f64) -> f64 {
        let old: Vec<Move> = self.quads.vertices().map(|v| self.place(v)).collect();
        for v in self.quads.vertices() {
            if let Some(m) = moves[v.index()] {
                self.put(v, m);
            }
        }
        let moved = self.quads.vertices().filter(|v| moves[v.index()].is_some());
        let mut touched = self.faces_around(moved);
        let mut quality = self.quality.clone();
        while !touched.is_empty() {
            let measured: Vec<f64> = touched.par_iter().map(|&f| self.measure(f)).collect();
            let mut back: Vec<VertexId> = Vec::new();
            for (&f, &q) in touched.iter().zip(&measured) {
                quality[f.index()] = q;
                if q < self.quality[f.index()].min(floor) {
                    back.extend(self.quads.face_vertices(f));
                }
            }
            back.sort_unstable();
            back.dedup();
            back.retain(|&v| self.position[v] != old[v.index()].position);
            for &v in &back {
                self.put(v, old[v.index()]);
            }
            touched = self.faces_around(back.into_iter());
        }
        self.quality = quality;
        self.quads.vertices().map(|v| self.position[v].distance(old[v.index()].position)).fold(0.0, f64::max)
    }

    /// Quads at some vertices, ascending.
    pub fn faces_around(&self, vertices: impl Iterator<Item = VertexId>) -> Vec<FaceId> {
        let mut at = vec![false; self.quads.face_count()];
        for v in vertices {
            self.quads.outgoing(v).for_each(|h| at[self.quads.face(h).index()] = true);
        }
        self.quads.faces().filter(|f| at[f.index()]).collect()
    }

    /// Lets a vertex leave its corner or curve for a place on the surface; the quality of its quads is not updated.
    pub fn release(&mut self, v: VertexId, to: Move) {
        self.left.push((v, self.place(v)));
        self.put(v, to);
    }

    /// Largest distance of a vertex that left its corner or curve from it, file units.
    pub fn farthest_left(&self) -> f64 {
        let distance = |&(v, from): &(VertexId, Move)| match from.tie {
            Tie::Curve { chain, .. } => self.reference.curves.query(chain, self.position[v]).distance,
            _ => self.position[v].distance(from.position),
        };
        self.left.iter().map(distance).fold(0.0, f64::max)
    }

    /// Measures the quads at a vertex again.
    pub fn measure_around(&mut self, v: VertexId) {
        let faces: Vec<FaceId> = self.quads.outgoing(v).map(|h| self.quads.face(h)).collect();
        for f in faces {
            self.quality[f.index()] = self.measure(f);
        }
    }

    /// Whether a quad counts as inverted: with a margin, so that writing coordinates as text does not turn it over.
    pub fn is_bad(&self, f: FaceId) -> bool {
        self.quality[f.index()] < INVERTED
    }

    /// Whether a vertex goes anywhere on the surface.
    pub fn may_move(&self, v: VertexId) -> bool {
        matches!(self.tie[v], Tie::Surface { .. }) && !self.pinned[v]
    }

    /// Where a vertex is.
    pub fn place(&self, v: VertexId) -> Move {
        Move { position: self.position[v], tie: self.tie[v] }
    }

    /// Puts a vertex somewhere; the quality of its quads is not updated.
    pub fn put(&mut self, v: VertexId, to: Move) {
        self.position[v] = to.position;
        self.tie[v] = to.tie;
    }
}
