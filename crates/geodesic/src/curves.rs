//! Curves as sources: polylines on the surface, cut into one piece per face.
//!
//! In: points of the surface in order, or edges. Out: [`Source`] segments. Holds: every piece lies in one face; points
//! of one face are joined straight, others by the shortest path between them. Curves may cross themselves.
//! Source: [Bommes2012] §9, polygons on the mesh ("subdivide the input polygon such that every segment lies entirely
//! in one triangle").

use crate::error::GeodesicError;
use crate::sources::{Cell, Source, cell_of, check_point, place};
use crate::surface::IntrinsicSurface;
use crate::wavefront::{Corridor, Options, Wavefront};
use quadloom_mesh::{EdgeId, FaceId, Progress, SurfacePoint, TriConnectivity, VertexId};

/// Joins points of a surface to curves, in memory that is kept from one to the next.
pub struct CurveTracer<'a> {
    wave: Wavefront<'a>,
    /// From the other end, approximately: tells where the shortest path can be.
    guide: Wavefront<'a>,
    corridor: Option<Corridor>,
}

/// Relative error of the guide: larger is faster, and leaves a wider corridor.
const GUIDE_EPSILON: f64 = 0.01;

impl<'a> CurveTracer<'a> {
    /// Prepares a surface.
    ///
    /// # Cost       linear
    pub fn new(surface: &'a IntrinsicSurface<'a>) -> Self {
        let corridor = Some(Corridor::new(surface.connectivity().vertex_count()));
        Self { wave: Wavefront::new(surface), guide: Wavefront::new(surface), corridor }
    }

    /// The curve through points in order.
    ///
    /// # Input      points; a closed curve repeats its first point; equal neighbours are one
    /// # Output     segments with the label; a point where there is only one
    /// # Errors     a point that is none; neighbours on different components; no point at all; a stop
    /// # Cost       linear in the pieces; where points do not share a face, that of a wavefront as far as they are apart
    pub fn join(
        &mut self,
        points: &[SurfacePoint],
        label: u32,
        progress: &Progress,
    ) -> Result<Vec<Source>, GeodesicError> {
        let mesh = self.wave.surface.connectivity();
        let points = points.iter().map(|p| check_point(mesh, *p, label)).collect::<Result<Vec<_>, _>>()?;
        let mut pieces = Vec::new();
        for (k, pair) in points.windows(2).enumerate() {
            progress.check()?;
            if let Some((p, q)) = in_one_face(mesh, &pair[0], &pair[1]) {
                if p.weights != q.weights {
                    pieces.push(Source::segment(p, q).with_label(label));
                }
                continue;
            }
            let path = self.shortest(pair[0], pair[1], progress)?;
            let Some(path) = path else {
                let (from, to) = (pair[0].face, pair[1].face);
                return Err(GeodesicError::CurveLeavesComponent { label, point: k, from, to });
            };
            for step in path.windows(2) {
                if let Some((p, q)) = in_one_face(mesh, &step[0], &step[1]) {
                    pieces.push(Source::segment(p, q).with_label(label));
                }
            }
        }
        if pieces.is_empty() {
            let first = points.first().ok_or(GeodesicError::NoSource)?;
            pieces.push(Source::point(*first).with_label(label));
        }
        Ok(pieces)
    }

    /// Points along the shortest path from one point to another; `None` where there is none.
    ///
    /// # Errors     a point that is none; a stop
    /// # Cost       that of a wavefront as far as they are apart
    pub fn shortest(
        &mut self,
        from: SurfacePoint,
        to: SurfacePoint,
        progress: &Progress,
    ) -> Result<Option<Vec<SurfacePoint>>, GeodesicError> {
        // 1. Approximately from one end: never above the truth, and at the other end not far below it.
        let options = Options { epsilon: GUIDE_EPSILON, ..Options::default() };
        let (enough, mut front) = (is_known(self.wave.surface, &to), f64::INFINITY);
        let enough = |wave: &Wavefront, key: f64| {
            let known = enough(wave, key);
            front = if known { key } else { front };
            known
        };
        self.guide.spread_until(&[Source::point(from)], &options, progress, enough)?;
        let near = self.guide.field().at(&to)?.distance * self.wave.surface.scale();
        if near.is_infinite() {
            return Ok(None);
        }
        // 2. Exactly from the other one, but only where both distances together are no more than the whole one can be.
        let mut corridor = self.corridor.take().unwrap_or_else(|| Corridor::new(self.wave.distance.len()));
        corridor.set(&self.guide, front, near / (1.0 - GUIDE_EPSILON));
        self.wave.corridor = Some(corridor);
        let enough = is_known(self.wave.surface, &from);
        let done = self.wave.spread_until(&[Source::point(to)], &Options::default(), progress, enough);
        self.corridor = self.wave.corridor.take();
        done?;
        Ok(self.wave.field().path_from(&from)?.map(|path| path.points))
    }
}

/// Whether all windows that matter to a point are known: those nearer than the shortest way over a corner of its face.
fn is_known(surface: &IntrinsicSurface, p: &SurfacePoint) -> impl Fn(&Wavefront, f64) -> bool + use<> {
    let corners = surface.connectivity().face_vertices(p.face);
    let layout = surface.layout(p.face);
    let at = place(layout, p.weights);
    let to_corner: [f64; 3] = std::array::from_fn(|k| (layout[k][0] - at[0]).hypot(layout[k][1] - at[1]));
    move |wave, key| (0..3).map(|k| wave.distance[corners[k]] + to_corner[k]).fold(f64::INFINITY, f64::min) < key
}

/// Segments along edges.
///
/// # Cost       linear
pub fn edge_sources(mesh: &TriConnectivity, edges: impl IntoIterator<Item = EdgeId>, label: u32) -> Vec<Source> {
    let segment = |e: EdgeId| {
        let h = mesh.half_edge(e);
        let (face, k) = (mesh.face(h), (h.0 % 3) as usize);
        let corner = |k: usize| {
            let mut weights = [0.0; 3];
            weights[k] = 1.0;
            SurfacePoint { face, weights }
        };
        Source::segment(corner(k), corner((k + 1) % 3)).with_label(label)
    };
    edges.into_iter().map(segment).collect()
}

/// The boundary of a surface as segments; empty where it is closed.
///
/// # Cost       linear
pub fn boundary_sources(mesh: &TriConnectivity, label: u32) -> Vec<Source> {
    edge_sources(mesh, mesh.edges().filter(|&e| mesh.is_boundary_edge(e)), label)
}

/// Two points told in one face, if a face has both.
pub(crate) fn in_one_face(
    mesh: &TriConnectivity,
    p: &SurfacePoint,
    q: &SurfacePoint,
) -> Option<(SurfacePoint, SurfacePoint)> {
    let try_face = |face: FaceId| told_in(mesh, p, face).zip(told_in(mesh, q, face));
    match (cell_of(mesh, p), cell_of(mesh, q)) {
        (Cell::Inside(f), _) | (_, Cell::Inside(f)) => try_face(f),
        (Cell::Side(h), _) | (_, Cell::Side(h)) => {
            [Some(h), mesh.twin(h)].into_iter().flatten().find_map(|h| try_face(mesh.face(h)))
        }
        (Cell::Vertex(v), _) => mesh.outgoing(v).find_map(|h| try_face(mesh.face(h))),
    }
}

/// A point told in another face, if it lies in it.
pub(crate) fn told_in(mesh: &TriConnectivity, p: &SurfacePoint, face: FaceId) -> Option<SurfacePoint> {
    if p.face == face {
        return Some(*p);
    }
    let corner = |v: VertexId| mesh.face_vertices(face).into_iter().position(|u| u == v);
    let mut weights = [0.0; 3];
    for (k, v) in mesh.face_vertices(p.face).into_iter().enumerate().filter(|&(k, _)| p.weights[k] > 0.0) {
        weights[corner(v)?] = p.weights[k];
    }
    Some(SurfacePoint { face, weights })
}
