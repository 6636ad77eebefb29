//! Half-edge connectivity of triangle, quad and mixed polygon meshes.
//!
//! In: a vertex count and faces as cyclic vertex lists. Out: [`Connectivity`], or every defect with its ids.
//! Holds: the surface is an oriented 2-manifold with boundary, every vertex is used and has one fan.
//! Never reads a position. Source: the classical half-edge structure, array form.
//!
//! ```text
//!            c                half-edges of a triangle f: 3f = a→b, 3f+1 = b→c, 3f+2 = c→a
//!          /   \              half-edge h also names the corner at its origin
//!     3f+2/  f  \3f+1         twin(h): the same edge seen from the neighbour; none on the boundary
//!        /       \            edge(h): id shared by h and twin(h)
//!       a ─────── b
//!           3f
//! ```

use crate::ids::{EdgeId, FaceId, HalfEdgeId, VertexId};

const NONE: u32 = u32::MAX;

/// How half-edges are grouped into faces.
pub trait FaceShape: Clone + Send + Sync + std::fmt::Debug {
    /// Number of faces, given the number of half-edges.
    fn faces(&self, half_edges: usize) -> usize;
    /// First half-edge of a face.
    fn first(&self, face: FaceId) -> HalfEdgeId;
    /// Number of sides of a face.
    fn degree(&self, face: FaceId) -> usize;
    /// Face of a half-edge.
    fn face(&self, half_edge: HalfEdgeId) -> FaceId;
}

/// Every face has `N` sides; half-edge `N·f + k` is side `k` of face `f`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fixed<const N: usize>;

/// Faces of any degree; half-edges are numbered face after face.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Mixed {
    offsets: Vec<u32>,
    face_of: Vec<u32>,
}

impl<const N: usize> FaceShape for Fixed<N> {
    #[inline]
    fn faces(&self, half_edges: usize) -> usize {
        half_edges / N
    }
    #[inline]
    fn first(&self, face: FaceId) -> HalfEdgeId {
        HalfEdgeId(face.0 * N as u32)
    }
    #[inline]
    fn degree(&self, _face: FaceId) -> usize {
        N
    }
    #[inline]
    fn face(&self, half_edge: HalfEdgeId) -> FaceId {
        FaceId(half_edge.0 / N as u32)
    }
}

impl FaceShape for Mixed {
    fn faces(&self, _half_edges: usize) -> usize {
        self.offsets.len().saturating_sub(1)
    }
    fn first(&self, face: FaceId) -> HalfEdgeId {
        HalfEdgeId(self.offsets[face.index()])
    }
    fn degree(&self, face: FaceId) -> usize {
        (self.offsets[face.index() + 1] - self.offsets[face.index()]) as usize
    }
    fn face(&self, half_edge: HalfEdgeId) -> FaceId {
        FaceId(self.face_of[half_edge.index()])
    }
}

/// Why a face list is not an oriented 2-manifold; ids are those of the list.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Defect {
    /// A face names a vertex that does not exist.
    #[error("face {face} uses vertex {vertex}, but there are only {vertices} vertices")]
    IndexOutOfRange {
        /// The face.
        face: FaceId,
        /// The index it names.
        vertex: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// A face has fewer than three different vertices, or one of them twice.
    #[error("face {face} is degenerate: it repeats vertex {vertex} or has fewer than three sides")]
    DegenerateFace {
        /// The face.
        face: FaceId,
        /// A repeated vertex.
        vertex: VertexId,
    },
    /// Two faces have the same vertices.
    #[error("face {face} repeats face {first}")]
    DuplicateFace {
        /// The later face.
        face: FaceId,
        /// The earlier one.
        first: FaceId,
    },
    /// More than two faces share an edge.
    #[error("edge ({a}, {b}) has {count} faces")]
    NonManifoldEdge {
        /// One end.
        a: VertexId,
        /// The other end.
        b: VertexId,
        /// Number of incident faces.
        count: usize,
    },
    /// Two faces traverse their common edge in the same direction.
    #[error("faces {first} and {second} traverse edge ({a}, {b}) in the same direction")]
    InconsistentOrientation {
        /// One end.
        a: VertexId,
        /// The other end.
        b: VertexId,
        /// One face.
        first: FaceId,
        /// The other face.
        second: FaceId,
    },
    /// The faces of a vertex form more than one fan.
    #[error("vertex {vertex} has more than one fan of faces")]
    NonManifoldVertex {
        /// The vertex.
        vertex: VertexId,
    },
    /// No face uses this vertex.
    #[error("vertex {vertex} is not used by any face")]
    UnusedVertex {
        /// The vertex.
        vertex: VertexId,
    },
    /// More elements than 32-bit ids can name.
    #[error("{half_edges} face sides are more than 32-bit ids can name")]
    TooLarge {
        /// Number of face sides.
        half_edges: usize,
    },
}

/// Half-edge connectivity of an oriented 2-manifold with boundary.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Connectivity<S> {
    shape: S,
    /// Origin vertex of each half-edge.
    origin: Vec<u32>,
    twin: Vec<u32>,
    edge: Vec<u32>,
    /// Canonical half-edge of each edge.
    half_edge: Vec<u32>,
    /// One outgoing half-edge per vertex; on the boundary the one without a twin.
    out: Vec<u32>,
}

/// Connectivity of a triangle mesh.
pub type TriConnectivity = Connectivity<Fixed<3>>;
/// Connectivity of a pure-quad mesh.
pub type QuadConnectivity = Connectivity<Fixed<4>>;
/// Connectivity of a mesh of polygons.
pub type PolygonConnectivity = Connectivity<Mixed>;

impl<const N: usize> Connectivity<Fixed<N>> {
    /// Builds the connectivity of `faces` on `vertices` vertices.
    ///
    /// # Errors     every defect, in the order of the elements
    /// # Cost       linear
    pub fn from_faces(vertices: usize, faces: &[[u32; N]]) -> Result<Self, Vec<Defect>> {
        Self::build(vertices, Fixed, faces.as_flattened().to_vec())
    }

    /// The vertices of a face, in order.
    #[inline]
    pub fn face_vertices(&self, face: FaceId) -> [VertexId; N] {
        let first = face.index() * N;
        std::array::from_fn(|k| VertexId(self.origin[first + k]))
    }

    /// The half-edges of a face, in order.
    #[inline]
    pub fn face_half_edges(&self, face: FaceId) -> [HalfEdgeId; N] {
        let first = face.0 * N as u32;
        std::array::from_fn(|k| HalfEdgeId(first + k as u32))
    }

    /// All faces as vertex lists.
    pub fn to_faces(&self) -> Vec<[u32; N]> {
        self.origin.as_chunks::<N>().0.to_vec()
    }
}

impl Connectivity<Mixed> {
    /// Builds the connectivity of polygons on `vertices` vertices.
    ///
    /// # Errors     every defect, in the order of the elements
    /// # Cost       linear
    pub fn from_polygons<F: AsRef<[u32]>>(vertices: usize, faces: &[F]) -> Result<Self, Vec<Defect>> {
        let mut offsets = vec![0u32];
        let (mut face_of, mut origin) = (Vec::new(), Vec::new());
        for (f, face) in faces.iter().enumerate() {
            origin.extend_from_slice(face.as_ref());
            face_of.extend(std::iter::repeat_n(f as u32, face.as_ref().len()));
            offsets.push(origin.len() as u32);
        }
        Self::build(vertices, Mixed { offsets, face_of }, origin)
    }
}

impl<S: FaceShape> Connectivity<S> {
    fn build(vertices: usize, shape: S, origin: Vec<u32>) -> Result<Self, Vec<Defect>> {
        if origin.len() >= NONE as usize || vertices >= NONE as usize {
            return Err(vec![Defect::TooLarge { half_edges: origin.len() }]);
        }
        let n = origin.len();
        let mut mesh = Self {
            shape,
            origin,
            twin: vec![NONE; n],
            edge: vec![NONE; n],
            half_edge: Vec::new(),
            out: vec![NONE; vertices],
        };
        // 1. Indices and faces on their own; later steps rely on them.
        let defects = mesh.face_defects(vertices);
        if !defects.is_empty() {
            return Err(defects);
        }
        // 2. Pair half-edges of equal ends.
        let mut defects = mesh.pair_half_edges(vertices);
        // 3. One fan a vertex.
        if defects.is_empty() {
            defects = mesh.link_vertices();
        }
        if defects.is_empty() { Ok(mesh) } else { Err(defects) }
    }

    fn face_defects(&self, vertices: usize) -> Vec<Defect> {
        let mut defects = Vec::new();
        for face in self.faces() {
            let first = self.shape.first(face).index();
            let corners = &self.origin[first..first + self.shape.degree(face)];
            if let Some(&vertex) = corners.iter().find(|&&v| v as usize >= vertices) {
                defects.push(Defect::IndexOutOfRange { face, vertex, vertices });
                continue;
            }
            let repeated = (0..corners.len()).find(|&k| corners[..k].contains(&corners[k]));
            if repeated.is_some() || corners.len() < 3 {
                let vertex = VertexId(repeated.map_or_else(|| corners.first().copied().unwrap_or(0), |k| corners[k]));
                defects.push(Defect::DegenerateFace { face, vertex });
            }
        }
        defects
    }

    /// Sorts half-edges by their smaller, then larger end (two counting passes) and pairs equal ones.
    fn pair_half_edges(&mut self, vertices: usize) -> Vec<Defect> {
        let ends: Vec<(u32, u32)> = (0..self.origin.len())
            .map(|h| {
                let (a, b) = (self.origin[h], self.origin[self.next(HalfEdgeId::new(h)).index()]);
                (a.min(b), a.max(b))
            })
            .collect();
        let by_high = counting_sort((0..ends.len() as u32).collect(), vertices, |h| ends[h as usize].1);
        let order = counting_sort(by_high, vertices, |h| ends[h as usize].0);
        let mut groups: Vec<(u32, usize, usize)> = Vec::new();
        let mut i = 0;
        while i < order.len() {
            let mut j = i + 1;
            while j < order.len() && ends[order[j] as usize] == ends[order[i] as usize] {
                j += 1;
            }
            groups.push((order[i], i, j));
            i = j;
        }
        // Edge ids follow the smallest half-edge, so that they do not depend on vertex numbers.
        groups.sort_unstable();
        let mut defects = Vec::new();
        for (e, &(first, i, j)) in groups.iter().enumerate() {
            let (a, b) = (VertexId(ends[first as usize].0), VertexId(ends[first as usize].1));
            for &h in &order[i..j] {
                self.edge[h as usize] = e as u32;
            }
            self.half_edge.push(first);
            match order[i..j] {
                [_] => {}
                [g, h] if self.origin[g as usize] != self.origin[h as usize] => {
                    self.twin[g as usize] = h;
                    self.twin[h as usize] = g;
                }
                [g, h] => {
                    let (first, second) = (self.face(HalfEdgeId(g)), self.face(HalfEdgeId(h)));
                    defects.push(if self.same_vertices(first, second) {
                        Defect::DuplicateFace { face: second, first }
                    } else {
                        Defect::InconsistentOrientation { a, b, first, second }
                    });
                }
                _ => defects.push(Defect::NonManifoldEdge { a, b, count: j - i }),
            }
        }
        defects
    }

    fn same_vertices(&self, a: FaceId, b: FaceId) -> bool {
        let sorted = |f: FaceId| {
            let first = self.shape.first(f).index();
            let mut list = self.origin[first..first + self.shape.degree(f)].to_vec();
            list.sort_unstable();
            list
        };
        sorted(a) == sorted(b)
    }

    fn link_vertices(&mut self) -> Vec<Defect> {
        let mut corners = vec![0u32; self.out.len()];
        for h in 0..self.origin.len() {
            let v = self.origin[h] as usize;
            corners[v] += 1;
            // Prefer the half-edge without a twin, from which a counter-clockwise walk sees the whole fan.
            if self.out[v] == NONE || self.twin[h] == NONE {
                self.out[v] = h as u32;
            }
        }
        let mut defects = Vec::new();
        for (v, &corner_count) in corners.iter().enumerate() {
            let vertex = VertexId::new(v);
            if self.out[v] == NONE {
                defects.push(Defect::UnusedVertex { vertex });
            } else if self.outgoing(vertex).count() != corner_count as usize {
                defects.push(Defect::NonManifoldVertex { vertex });
            }
        }
        defects
    }

    /// Number of vertices.
    #[inline]
    pub fn vertex_count(&self) -> usize {
        self.out.len()
    }
    /// Number of half-edges, which is the number of corners.
    #[inline]
    pub fn half_edge_count(&self) -> usize {
        self.origin.len()
    }
    /// Number of edges.
    #[inline]
    pub fn edge_count(&self) -> usize {
        self.half_edge.len()
    }
    /// Number of faces.
    #[inline]
    pub fn face_count(&self) -> usize {
        self.shape.faces(self.origin.len())
    }
    /// All vertices, ascending.
    pub fn vertices(&self) -> impl DoubleEndedIterator<Item = VertexId> + ExactSizeIterator + Clone + use<S> {
        (0..self.vertex_count()).map(VertexId::new)
    }
    /// All half-edges, ascending.
    pub fn half_edges(&self) -> impl DoubleEndedIterator<Item = HalfEdgeId> + ExactSizeIterator + Clone + use<S> {
        (0..self.half_edge_count()).map(HalfEdgeId::new)
    }
    /// All edges, ascending.
    pub fn edges(&self) -> impl DoubleEndedIterator<Item = EdgeId> + ExactSizeIterator + Clone + use<S> {
        (0..self.edge_count()).map(EdgeId::new)
    }
    /// All faces, ascending.
    pub fn faces(&self) -> impl DoubleEndedIterator<Item = FaceId> + ExactSizeIterator + Clone + use<S> {
        (0..self.face_count()).map(FaceId::new)
    }

    /// Vertex at which a half-edge starts.
    #[inline]
    pub fn origin(&self, h: HalfEdgeId) -> VertexId {
        VertexId(self.origin[h.index()])
    }
    /// Vertex at which a half-edge ends.
    #[inline]
    pub fn target(&self, h: HalfEdgeId) -> VertexId {
        self.origin(self.next(h))
    }
    /// The same edge seen from the neighbouring face; `None` on the boundary.
    #[inline]
    pub fn twin(&self, h: HalfEdgeId) -> Option<HalfEdgeId> {
        let t = self.twin[h.index()];
        (t != NONE).then_some(HalfEdgeId(t))
    }
    /// Next side of the same face, counter-clockwise.
    #[inline]
    pub fn next(&self, h: HalfEdgeId) -> HalfEdgeId {
        let face = self.shape.face(h);
        let (first, degree) = (self.shape.first(face).0, self.shape.degree(face) as u32);
        HalfEdgeId(if h.0 + 1 == first + degree { first } else { h.0 + 1 })
    }
    /// Previous side of the same face.
    #[inline]
    pub fn prev(&self, h: HalfEdgeId) -> HalfEdgeId {
        let face = self.shape.face(h);
        let (first, degree) = (self.shape.first(face).0, self.shape.degree(face) as u32);
        HalfEdgeId(if h.0 == first { first + degree - 1 } else { h.0 - 1 })
    }
    /// Face of a half-edge.
    #[inline]
    pub fn face(&self, h: HalfEdgeId) -> FaceId {
        self.shape.face(h)
    }
    /// Edge of a half-edge.
    #[inline]
    pub fn edge(&self, h: HalfEdgeId) -> EdgeId {
        EdgeId(self.edge[h.index()])
    }
    /// Canonical half-edge of an edge: the one with the smaller id.
    #[inline]
    pub fn half_edge(&self, e: EdgeId) -> HalfEdgeId {
        HalfEdgeId(self.half_edge[e.index()])
    }
    /// Ends of an edge: origin and target of its canonical half-edge.
    #[inline]
    pub fn ends(&self, e: EdgeId) -> [VertexId; 2] {
        let h = self.half_edge(e);
        [self.origin(h), self.target(h)]
    }
    /// First half-edge of a face.
    #[inline]
    pub fn first_half_edge(&self, f: FaceId) -> HalfEdgeId {
        self.shape.first(f)
    }
    /// Number of sides of a face.
    #[inline]
    pub fn degree(&self, f: FaceId) -> usize {
        self.shape.degree(f)
    }
    /// Half-edges of a face, in order.
    pub fn sides(&self, f: FaceId) -> impl DoubleEndedIterator<Item = HalfEdgeId> + ExactSizeIterator + Clone + use<S> {
        let first = self.shape.first(f).0;
        (first..first + self.shape.degree(f) as u32).map(HalfEdgeId)
    }
    /// Faces on both sides of an edge: of the canonical half-edge, and of its twin.
    #[inline]
    pub fn edge_faces(&self, e: EdgeId) -> (FaceId, Option<FaceId>) {
        let h = self.half_edge(e);
        (self.face(h), self.twin(h).map(|t| self.face(t)))
    }
    /// Whether an edge has one face only.
    #[inline]
    pub fn is_boundary_edge(&self, e: EdgeId) -> bool {
        self.twin[self.half_edge[e.index()] as usize] == NONE
    }
    /// Whether a vertex lies on the boundary.
    #[inline]
    pub fn is_boundary_vertex(&self, v: VertexId) -> bool {
        self.twin[self.out[v.index()] as usize] == NONE
    }
    /// An outgoing half-edge of a vertex; on the boundary the clockwise-most one, which lies on the boundary.
    #[inline]
    pub fn outgoing_half_edge(&self, v: VertexId) -> HalfEdgeId {
        HalfEdgeId(self.out[v.index()])
    }
    /// Outgoing half-edges of a vertex, counter-clockwise; on the boundary from the clockwise-most one.
    pub fn outgoing(&self, v: VertexId) -> Outgoing<'_, S> {
        let start = self.outgoing_half_edge(v);
        Outgoing { mesh: self, start, next: Some(start) }
    }
    /// The outgoing half-edge counter-clockwise of `h` around its origin; `None` across the boundary.
    #[inline]
    pub fn rotate_ccw(&self, h: HalfEdgeId) -> Option<HalfEdgeId> {
        self.twin(self.prev(h))
    }
    /// The outgoing half-edge clockwise of `h` around its origin; `None` across the boundary.
    #[inline]
    pub fn rotate_cw(&self, h: HalfEdgeId) -> Option<HalfEdgeId> {
        self.twin(h).map(|t| self.next(t))
    }
    /// The half-edge from `a` to `b`, if an edge joins them and has a face on that side.
    pub fn find_half_edge(&self, a: VertexId, b: VertexId) -> Option<HalfEdgeId> {
        self.outgoing(a).find(|&h| self.target(h) == b)
    }
    /// The edge between `a` and `b`, if there is one.
    pub fn find_edge(&self, a: VertexId, b: VertexId) -> Option<EdgeId> {
        self.find_half_edge(a, b).or_else(|| self.find_half_edge(b, a)).map(|h| self.edge(h))
    }
    /// Edges at a vertex, counter-clockwise.
    pub fn vertex_edges(&self, v: VertexId) -> impl Iterator<Item = EdgeId> + '_ {
        let last =
            self.outgoing(v).last().map(|h| self.prev(h)).filter(|&h| self.twin(h).is_none()).map(|h| self.edge(h));
        self.outgoing(v).map(|h| self.edge(h)).chain(last)
    }
    /// Neighbours of a vertex, counter-clockwise.
    pub fn neighbours(&self, v: VertexId) -> impl Iterator<Item = VertexId> + '_ {
        self.vertex_edges(v).map(move |e| {
            let [a, b] = self.ends(e);
            if a == v { b } else { a }
        })
    }
    /// Number of edges at a vertex.
    pub fn valence(&self, v: VertexId) -> usize {
        self.vertex_edges(v).count()
    }
}

/// Iterator over the outgoing half-edges of a vertex.
#[derive(Clone)]
pub struct Outgoing<'a, S> {
    mesh: &'a Connectivity<S>,
    start: HalfEdgeId,
    next: Option<HalfEdgeId>,
}

impl<S: FaceShape> Iterator for Outgoing<'_, S> {
    type Item = HalfEdgeId;
    #[inline]
    fn next(&mut self) -> Option<HalfEdgeId> {
        let current = self.next?;
        self.next = self.mesh.rotate_ccw(current).filter(|&h| h != self.start);
        Some(current)
    }
}

fn counting_sort(items: Vec<u32>, keys: usize, key: impl Fn(u32) -> u32) -> Vec<u32> {
    let mut start = vec![0u32; keys + 1];
    for &i in &items {
        start[key(i) as usize + 1] += 1;
    }
    for k in 0..keys {
        start[k + 1] += start[k];
    }
    let mut sorted = vec![0; items.len()];
    for &i in &items {
        let slot = &mut start[key(i) as usize];
        sorted[*slot as usize] = i;
        *slot += 1;
    }
    sorted
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::repair::{RepairOptions, repair};
    use crate::shapes;
    use crate::soup::FaceSoup;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    fn defects(vertices: usize, faces: &[[u32; 3]]) -> Vec<Defect> {
        TriConnectivity::from_faces(vertices, faces).unwrap_err()
    }

    #[test]
    fn every_kind_of_defect_is_named() {
        let (f, v) = (FaceId, VertexId);
        assert_eq!(
            defects(3, &[[0, 1, 3], [0, 1, 2]]),
            [Defect::IndexOutOfRange { face: f(0), vertex: 3, vertices: 3 }]
        );
        assert_eq!(defects(3, &[[0, 1, 2], [2, 1, 2]]), [Defect::DegenerateFace { face: f(1), vertex: v(2) }]);
        let twice = defects(3, &[[0, 1, 2], [1, 2, 0]]);
        assert_eq!(twice, vec![Defect::DuplicateFace { face: f(1), first: f(0) }; 3]);
        assert_eq!(
            defects(5, &[[0, 1, 2], [1, 0, 3], [0, 1, 4]]),
            [Defect::NonManifoldEdge { a: v(0), b: v(1), count: 3 }]
        );
        assert_eq!(
            defects(4, &[[0, 1, 2], [0, 1, 3]]),
            [Defect::InconsistentOrientation { a: v(0), b: v(1), first: f(0), second: f(1) }]
        );
        assert_eq!(defects(5, &[[0, 1, 2], [0, 3, 4]]), [Defect::NonManifoldVertex { vertex: v(0) }]);
        assert_eq!(defects(4, &[[0, 1, 3]]), [Defect::UnusedVertex { vertex: v(2) }]);
        let short = PolygonConnectivity::from_polygons(3, &[vec![0, 1, 2], vec![0, 1]]).unwrap_err();
        assert_eq!(short, [Defect::DegenerateFace { face: f(1), vertex: v(0) }]);
    }

    #[test]
    fn two_cones_at_a_point_are_one_defect() {
        // Closed fans: two tetrahedra that share a vertex.
        let tetrahedron = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d], [a, d, b], [b, d, c]];
        let faces: Vec<[u32; 3]> = [tetrahedron([0, 1, 2, 3]), tetrahedron([0, 4, 5, 6])].concat();
        assert_eq!(defects(7, &faces), [Defect::NonManifoldVertex { vertex: VertexId(0) }]);
    }

    /// Everything that half-edges promise, against the plain list of faces.
    fn check<S: FaceShape>(mesh: &Connectivity<S>) {
        for h in mesh.half_edges() {
            assert_eq!(mesh.next(mesh.prev(h)), h);
            assert_eq!(mesh.prev(mesh.next(h)), h);
            assert_eq!(mesh.face(mesh.next(h)), mesh.face(h));
            match mesh.twin(h) {
                Some(t) => {
                    assert_ne!(t, h);
                    assert_eq!((mesh.twin(t), mesh.edge(t)), (Some(h), mesh.edge(h)));
                    assert_eq!((mesh.origin(t), mesh.target(t)), (mesh.target(h), mesh.origin(h)));
                }
                None => assert!(mesh.is_boundary_edge(mesh.edge(h)) && mesh.is_boundary_vertex(mesh.origin(h))),
            }
            if let Some(g) = mesh.rotate_ccw(h) {
                assert_eq!((mesh.origin(g), mesh.rotate_cw(g)), (mesh.origin(h), Some(h)));
            }
            assert_eq!(mesh.find_half_edge(mesh.origin(h), mesh.target(h)), Some(h));
        }
        for (i, e) in mesh.edges().enumerate() {
            assert_eq!(mesh.edge(mesh.half_edge(e)).index(), i);
            assert!(mesh.twin(mesh.half_edge(e)).is_none_or(|t| t > mesh.half_edge(e)));
        }
        for v in mesh.vertices() {
            let outgoing: BTreeSet<HalfEdgeId> = mesh.outgoing(v).collect();
            assert_eq!(outgoing, mesh.half_edges().filter(|&h| mesh.origin(h) == v).collect());
            let around = mesh.half_edges().filter(|&h| mesh.origin(h) == v || mesh.target(h) == v);
            let edges: BTreeSet<EdgeId> = around.map(|h| mesh.edge(h)).collect();
            assert_eq!(mesh.vertex_edges(v).collect::<BTreeSet<_>>(), edges);
            assert_eq!(mesh.valence(v), edges.len());
            let on_boundary = edges.iter().filter(|&&e| mesh.is_boundary_edge(e)).count();
            assert_eq!(on_boundary, if mesh.is_boundary_vertex(v) { 2 } else { 0 });
        }
    }

    #[test]
    fn polygons_of_any_degree_are_linked() {
        // A cube with one side cut into triangles and one left open.
        let faces: [&[u32]; 6] = [&[0, 3, 2, 1], &[0, 1, 5, 4], &[1, 2, 6, 5], &[2, 3, 7, 6], &[3, 0, 4], &[3, 4, 7]];
        let mesh = PolygonConnectivity::from_polygons(8, &faces).unwrap();
        check(&mesh);
        assert_eq!((mesh.vertex_count(), mesh.edge_count(), mesh.face_count()), (8, 13, 6));
        let quads = QuadConnectivity::from_faces(8, &[[0, 3, 2, 1], [0, 1, 5, 4], [1, 2, 6, 5]]);
        assert_eq!(quads.unwrap_err(), [Defect::UnusedVertex { vertex: VertexId(7) }]);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn half_edges_agree_with_the_face_list(removed in proptest::collection::vec(0usize..160, 0..120), base in 0..3) {
            // What is left of a shape when faces are taken away.
            let whole = match base {
                0 => shapes::sphere(1.0, 1),
                1 => shapes::torus(1.0, 0.4, 10, 8),
                _ => shapes::smooth_genus(2, 0),
            };
            let faces = whole.to_faces();
            let left = (0..faces.len()).filter(|f| !removed.contains(f)).map(|f| faces[f].to_vec()).collect();
            let soup = FaceSoup { positions: whole.positions().values().to_vec(), faces: left, ..FaceSoup::default() };
            if let Ok(repaired) = repair(&soup, &RepairOptions::default()) {
                check(repaired.mesh.connectivity());
                let again = TriConnectivity::from_faces(repaired.mesh.vertex_count(), &repaired.mesh.to_faces());
                prop_assert_eq!(&again.unwrap(), repaired.mesh.connectivity());
            }
        }
    }
}
