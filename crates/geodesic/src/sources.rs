//! What distances are measured from.
//!
//! In: vertices, points, segments within faces, each with a label and a start value. Out: [`Sources`], checked, with
//! every point in the layout of its face. Holds: a point lies on a vertex, on an edge, or inside one face, and is
//! treated as that; equal points with equal start values are kept once. Source: [Bommes2012] §9, generalization to
//! arbitrary sources.

use crate::error::GeodesicError;
use crate::surface::IntrinsicSurface;
use crate::window::MAX_ROOTS;
use quadloom_mesh::{FaceId, HalfEdgeId, SurfacePoint, TriConnectivity, VertexId};
use std::collections::HashSet;

/// How far barycentric weights may be from a sum of 1, and below 0.
const WEIGHT_TOLERANCE: f64 = 1e-9;

/// Something to measure from.
#[derive(Clone, Debug, PartialEq)]
pub enum SourceShape {
    /// A vertex.
    Vertex(VertexId),
    /// Any point of the surface.
    Point(SurfacePoint),
    /// A straight segment within one face, given by its ends; both name the same face.
    Segment(SurfacePoint, SurfacePoint),
}

/// A source with what is told of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// Where it is.
    pub shape: SourceShape,
    /// Reported by queries where this source is the nearest.
    pub label: u32,
    /// Distance with which it starts, file units; default 0.
    pub start: f64,
}

impl Source {
    /// A vertex with label 0 that starts at 0.
    pub fn vertex(v: VertexId) -> Self {
        Self { shape: SourceShape::Vertex(v), label: 0, start: 0.0 }
    }

    /// A point with label 0 that starts at 0.
    pub fn point(p: SurfacePoint) -> Self {
        Self { shape: SourceShape::Point(p), label: 0, start: 0.0 }
    }

    /// A segment within a face with label 0 that starts at 0.
    pub fn segment(p: SurfacePoint, q: SurfacePoint) -> Self {
        Self { shape: SourceShape::Segment(p, q), label: 0, start: 0.0 }
    }

    /// The same source with another label.
    pub fn with_label(mut self, label: u32) -> Self {
        self.label = label;
        self
    }

    /// The same source with another start value, file units.
    pub fn with_start(mut self, start: f64) -> Self {
        self.start = start;
        self
    }
}

/// The cell of the surface on which a point lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) enum Cell {
    Vertex(VertexId),
    /// The half-edge in the point's face.
    Side(HalfEdgeId),
    Inside(FaceId),
}

/// The cell of a point: weights of exactly zero put it on a side or a vertex.
pub(crate) fn cell_of(mesh: &TriConnectivity, p: &SurfacePoint) -> Cell {
    let corners = mesh.face_half_edges(p.face);
    let on: Vec<usize> = (0..3).filter(|&k| p.weights[k] > 0.0).collect();
    match on[..] {
        [k] => Cell::Vertex(mesh.origin(corners[k])),
        [j, k] => Cell::Side(corners[if (j + 1) % 3 == k { j } else { k }]),
        _ => Cell::Inside(p.face),
    }
}

/// A root of windows that is not a vertex.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Root {
    Point(SurfacePoint),
    /// The line between two points of a face; windows of its ends are theirs.
    Segment(SurfacePoint, SurfacePoint),
}

/// Checked sources, scaled.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sources {
    /// Vertices, ascending, with their least start values and the labels of those.
    pub vertices: Vec<(VertexId, f64, u32)>,
    /// Points that are no vertices, and segments, with start values and labels; their order is that of their roots.
    pub roots: Vec<(Root, f64, u32)>,
}

impl Sources {
    /// Checks sources and sorts them by what they are.
    ///
    /// # Errors     the first source that is wrong; no source at all
    /// # Cost       linear
    pub fn new(surface: &IntrinsicSurface, sources: &[Source]) -> Result<Self, GeodesicError> {
        let mesh = surface.connectivity();
        let mut checked = Self::default();
        let mut seen = HashSet::new();
        for source in sources {
            let (label, start) = (source.label, source.start * surface.scale());
            if !(source.start >= 0.0 && start.is_finite()) {
                return Err(GeodesicError::Start { label, start: source.start });
            }
            let mut add_point = |p: SurfacePoint, this: &mut Self| {
                if !seen.insert((p.face, p.weights.map(f64::to_bits), start.to_bits(), label)) {
                    return;
                }
                match cell_of(mesh, &p) {
                    Cell::Vertex(v) => this.vertices.push((v, start, label)),
                    _ => this.roots.push((Root::Point(p), start, label)),
                }
            };
            match source.shape {
                SourceShape::Vertex(v) => {
                    if v.index() >= mesh.vertex_count() {
                        return Err(GeodesicError::NoVertex { label, vertex: v, last: mesh.vertex_count() - 1 });
                    }
                    checked.vertices.push((v, start, label));
                }
                SourceShape::Point(p) => add_point(check_point(mesh, p, label)?, &mut checked),
                SourceShape::Segment(p, q) => {
                    let (p, q) = (check_point(mesh, p, label)?, check_point(mesh, q, label)?);
                    if p.face != q.face {
                        return Err(GeodesicError::SegmentFaces { label, faces: [p.face, q.face] });
                    }
                    add_point(p, &mut checked);
                    add_point(q, &mut checked);
                    if p.weights != q.weights {
                        checked.roots.push((Root::Segment(p, q), start, label));
                    }
                }
            }
        }
        checked.vertices.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
        checked.vertices.dedup_by_key(|source| source.0);
        if checked.vertices.is_empty() && checked.roots.is_empty() {
            return Err(GeodesicError::NoSource);
        }
        let roots = mesh.vertex_count() + checked.roots.len();
        if roots > MAX_ROOTS {
            return Err(GeodesicError::TooLarge { roots, most: MAX_ROOTS });
        }
        Ok(checked)
    }
}

impl Sources {
    /// Start value and label of a vertex that is a source.
    pub fn at_vertex(&self, v: VertexId) -> Option<(f64, u32)> {
        let k = self.vertices.binary_search_by_key(&v, |source| source.0).ok()?;
        Some((self.vertices[k].1, self.vertices[k].2))
    }

    /// The faces that points and segments touch, with their numbers, ascending.
    pub fn by_face(&self, mesh: &TriConnectivity) -> Vec<(FaceId, u32)> {
        let mut list = Vec::new();
        for (k, (root, _, _)) in self.roots.iter().enumerate() {
            let (Root::Point(p) | Root::Segment(p, _)) = *root;
            list.push((p.face, k as u32));
            let on = |q: &SurfacePoint| (0..3).filter(|&i| q.weights[i] == 0.0).fold(0u8, |m, i| m | 1 << i);
            let shared = match root {
                Root::Point(p) => on(p),
                Root::Segment(p, q) => on(p) & on(q),
            };
            // On the side opposite to a corner without weight.
            for i in (0..3).filter(|i| shared >> i & 1 == 1) {
                let side = HalfEdgeId(mesh.first_half_edge(p.face).0 + (i + 1) % 3);
                list.extend(mesh.twin(side).map(|t| (mesh.face(t), k as u32)));
            }
        }
        list.sort_unstable();
        list
    }
}

/// A point with weights that are not negative and sum to 1, or why it is none.
pub(crate) fn check_point(mesh: &TriConnectivity, p: SurfacePoint, label: u32) -> Result<SurfacePoint, GeodesicError> {
    if p.face.index() >= mesh.face_count() {
        return Err(GeodesicError::NoFace { label, face: p.face, last: mesh.face_count().saturating_sub(1) });
    }
    let sum: f64 = p.weights.iter().sum();
    let in_range = p.weights.iter().all(|&w| w >= -WEIGHT_TOLERANCE) && (sum - 1.0).abs() <= WEIGHT_TOLERANCE;
    if !in_range {
        return Err(GeodesicError::Weights { label, face: p.face, weights: p.weights });
    }
    let weights = p.weights.map(|w| w.max(0.0));
    let sum: f64 = weights.iter().sum();
    Ok(SurfacePoint { face: p.face, weights: weights.map(|w| w / sum) })
}

/// Where a point lies in a layout of its face's corners.
pub(crate) fn place(corners: [[f64; 2]; 3], weights: [f64; 3]) -> [f64; 2] {
    [0, 1].map(|k| (0..3).map(|i| weights[i] * corners[i][k]).sum())
}
