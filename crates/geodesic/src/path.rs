//! Shortest paths, traced back to their source.
//!
//! In: a field, a point. Out: [`GeodesicPath`]: the points at which the path bends or crosses an edge.
//! Holds: every step goes straight through one face, to where the best window of that face says; the steps' lengths sum
//! to the distance minus the source's start value, up to rounding (for ε > 0: up to ε).
//! Source: [Bommes2012] §9 ("sufficient for the propagation and also for the exact evaluation").

use crate::curves::told_in;
use crate::error::GeodesicError;
use crate::field::{Approach, Field, Via};
use crate::sources::{Cell, cell_of, check_point, place};
use quadloom_mesh::{FaceId, HalfEdgeId, SurfacePoint, VertexId};

/// A shortest path from a point back to its source.
#[derive(Clone, Debug, PartialEq)]
pub struct GeodesicPath {
    /// The point, where the path crosses edges or passes vertices, and the source. Consecutive points lie in one face:
    /// the face of the earlier one.
    pub points: Vec<SurfacePoint>,
    /// Sum of the lengths of its pieces, file units.
    pub length: f64,
    /// Label of the source.
    pub label: u32,
}

/// Where a path is.
#[derive(Clone, Copy)]
enum At {
    Vertex(VertexId),
    /// In a face's layout, having come through one of its sides.
    Face(FaceId, [f64; 2], Option<usize>),
}

/// Places closer to an edge's end than this, relative to the edge, are the end.
const SNAP_REL: f64 = 1e-9;

impl Field<'_> {
    /// Traces the shortest path from a point back to its source.
    ///
    /// # Output     `None` where no source reaches
    /// # Errors     a point that is none
    /// # Cost       linear in the windows of the faces that the path crosses
    pub fn path_from(&self, p: &SurfacePoint) -> Result<Option<GeodesicPath>, GeodesicError> {
        self.needs_windows()?;
        let (wave, mesh) = (self.wave, self.wave.surface.connectivity());
        let p = check_point(mesh, *p, 0)?;
        let mut at = match cell_of(mesh, &p) {
            Cell::Vertex(v) => At::Vertex(v),
            Cell::Inside(face) => At::Face(face, place(wave.surface.layout(face), p.weights), None),
            Cell::Side(h) => self.nearer_side(h, &p),
        };
        let mut points = vec![p];
        let mut length = 0.0;
        // Each step lowers the distance; only rounding could make it stand still.
        for _ in 0..4 * mesh.edge_count() + 16 {
            if let At::Vertex(v) = at
                && let Some((_, label)) = wave.sources.at_vertex(v).filter(|s| s.0 <= wave.distance[v])
            {
                return Ok(Some(GeodesicPath { points, length: length / wave.surface.scale(), label }));
            }
            let Some((face, from, approach)) = self.step(at) else { return Ok(None) };
            let to = self.place_of(face, &approach.via);
            length += (to[0] - from[0]).hypot(to[1] - from[1]);
            let point = self.point_of(face, &approach.via);
            // The earlier point is told in the face that is crossed.
            if let Some(last) = points.last_mut() {
                *last = self.same_point_in(last, face, from);
            }
            let moved = to != from;
            if moved {
                points.push(point);
            }
            at = match approach.via {
                Via::Source(_) => {
                    return Ok(Some(GeodesicPath {
                        points,
                        length: length / wave.surface.scale(),
                        label: approach.label,
                    }));
                }
                Via::Corner(k) => At::Vertex(mesh.face_vertices(face)[k]),
                Via::Side(k, x) => self.across(mesh.face_half_edges(face)[k], x),
            };
        }
        Err(GeodesicError::PathLost { face: p.face })
    }

    /// The next piece of a path: its face, where it begins there, how it goes on.
    fn step(&self, at: At) -> Option<(FaceId, [f64; 2], Approach)> {
        let (wave, mesh) = (self.wave, self.wave.surface.connectivity());
        match at {
            At::Face(face, from, except) => self.approach(face, from, except).map(|a| (face, from, a)),
            At::Vertex(v) => {
                let mut best: Option<(FaceId, [f64; 2], Approach)> = None;
                for h in mesh.outgoing(v) {
                    let face = mesh.face(h);
                    let k = (h.0 - mesh.first_half_edge(face).0) as usize;
                    let from = wave.surface.layout(face)[k];
                    for a in self.approaches_of_corner(face, k, from) {
                        if a.distance < best.map_or(f64::INFINITY, |(_, _, b)| b.distance) {
                            best = Some((face, from, a));
                        }
                    }
                }
                best
            }
        }
    }

    /// The point of an edge, told in the face through which its path goes on.
    fn nearer_side(&self, h: HalfEdgeId, p: &SurfacePoint) -> At {
        let (wave, mesh) = (self.wave, self.wave.surface.connectivity());
        let options = [Some(h), mesh.twin(h)].into_iter().flatten().filter_map(|side| {
            let face = mesh.face(side);
            let from = wave.place_in(face, p)?;
            let k = (side.0 - mesh.first_half_edge(face).0) as usize;
            let distance = self.approach(face, from, Some(k))?.distance;
            Some((distance, At::Face(face, from, Some(k))))
        });
        let own = At::Face(p.face, place(wave.surface.layout(p.face), p.weights), None);
        options.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(own, |(_, at)| at)
    }

    /// The face behind a side, or the vertex at its end.
    fn across(&self, h: HalfEdgeId, x: f64) -> At {
        let (wave, mesh) = (self.wave, self.wave.surface.connectivity());
        let length = wave.surface.length(mesh.edge(h));
        if x <= SNAP_REL * length {
            return At::Vertex(mesh.origin(h));
        }
        if x >= (1.0 - SNAP_REL) * length {
            return At::Vertex(mesh.target(h));
        }
        match mesh.twin(h) {
            None => At::Face(mesh.face(h), self.place_of(mesh.face(h), &Via::Side((h.0 % 3) as usize, x)), None),
            Some(t) => {
                let k = (t.0 % 3) as usize;
                let face = mesh.face(t);
                At::Face(face, self.place_of(face, &Via::Side(k, length - x)), Some(k))
            }
        }
    }

    fn place_of(&self, face: FaceId, via: &Via) -> [f64; 2] {
        let layout = self.wave.surface.layout(face);
        match *via {
            Via::Source(at) => at,
            Via::Corner(k) => layout[k],
            Via::Side(k, x) => {
                let t = self.fraction(face, k, x);
                [0, 1].map(|i| (1.0 - t) * layout[k][i] + t * layout[(k + 1) % 3][i])
            }
        }
    }

    fn fraction(&self, face: FaceId, k: usize, x: f64) -> f64 {
        let mesh = self.wave.surface.connectivity();
        let length = self.wave.surface.length(mesh.edge(mesh.face_half_edges(face)[k]));
        if length > 0.0 { (x / length).clamp(0.0, 1.0) } else { 0.0 }
    }

    fn point_of(&self, face: FaceId, via: &Via) -> SurfacePoint {
        let mut weights = [0.0; 3];
        match *via {
            Via::Corner(k) => weights[k] = 1.0,
            Via::Side(k, x) => {
                let t = self.fraction(face, k, x);
                (weights[k], weights[(k + 1) % 3]) = (1.0 - t, t);
            }
            Via::Source(at) => weights = barycentric(self.wave.surface.layout(face), at),
        }
        SurfacePoint { face, weights }
    }

    /// A point of the path in the face through which it goes on.
    fn same_point_in(&self, p: &SurfacePoint, face: FaceId, from: [f64; 2]) -> SurfacePoint {
        let elsewhere = || SurfacePoint { face, weights: barycentric(self.wave.surface.layout(face), from) };
        told_in(self.wave.surface.connectivity(), p, face).unwrap_or_else(elsewhere)
    }

    /// The ways from a corner of a face: through the opposite side, along its sides, to sources inside.
    fn approaches_of_corner(&self, face: FaceId, k: usize, from: [f64; 2]) -> impl Iterator<Item = Approach> {
        let mesh = self.wave.surface.connectivity();
        let layout = self.wave.surface.layout(face);
        let along = [(k + 1) % 3, (k + 2) % 3].map(|j| {
            let towards_source = [layout[j][0] - from[0], layout[j][1] - from[1]];
            let v = mesh.face_vertices(face)[j];
            let distance = self.wave.distance[v] + towards_source[0].hypot(towards_source[1]);
            Approach { distance, label: self.wave.label[v], towards_source, via: Via::Corner(j) }
        });
        let through = self.approach_from(face, from, |j| j == (k + 1) % 3, |_| false);
        along.into_iter().chain(through)
    }
}

/// Weights of a place in a layout.
pub(crate) fn barycentric(corners: [[f64; 2]; 3], [x, y]: [f64; 2]) -> [f64; 3] {
    // Corner 0 is the origin, corner 1 on the x axis, corner 2 above it.
    let ([bx, _], [cx, cy]) = (corners[1], corners[2]);
    let w2 = if cy > 0.0 { (y / cy).clamp(0.0, 1.0) } else { 0.0 };
    let w1 = if bx > 0.0 { ((x - w2 * cx) / bx).clamp(0.0, 1.0 - w2) } else { 0.0 };
    [1.0 - w1 - w2, w1, w2]
}
