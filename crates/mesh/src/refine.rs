//! Splitting edges of a triangle mesh without moving its surface.
//!
//! In: a triangle mesh, its features, and the edges to split. Out: [`Refined`]: the finer mesh with its features
//! and where each of its elements comes from. Holds: the surface is the same point set; old vertices keep
//! their ids; new faces lie in their parents, so that a field per face can be copied; chain ids and corners
//! are kept. Not: better triangles. Source: [Bommes2012] §8.4 needs features that are apart.
//!
//! ```text
//!   1 split        2 splits         3 splits
//!      c              c                c
//!     /|\            / \              / \
//!    / | \         q ── p           q ── p
//!   /  |  \       /  ·'  \         / \  / \
//!  a ─ m ─ b     a ────── b       a ─ m ─ b
//! ```

use crate::features::FeatureGraph;
use crate::ids::{EdgeId, EdgeMap, FaceId, FaceMap, HalfEdgeId, HalfEdgeMap, VertexId, VertexMap};
use crate::mesh::{MeshError, TriMesh};
use crate::metric::FaceFrame;
use crate::surface_point::SurfacePoint;
use glam::DVec3;

/// Where a vertex of a refined mesh comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum VertexOrigin {
    /// The vertex of the same id.
    Vertex(VertexId),
    /// A point of an edge, at a parameter in 0..1 from the origin of its canonical half-edge.
    Edge(EdgeId, f64),
    /// The centroid of a face.
    Face(FaceId),
}

/// A mesh with split edges, and its relation to the mesh it was made from (the parent).
#[derive(Clone, Debug)]
pub struct Refined {
    /// The finer mesh; vertices of the parent come first, with their ids.
    pub mesh: TriMesh,
    /// The parent's features; chain ids are the same.
    pub features: FeatureGraph,
    /// Parent face of each face.
    pub parent_face: FaceMap<FaceId>,
    /// The parent's half-edge on which a half-edge lies, in the same direction; `None` inside a parent face.
    pub parent_half_edge: HalfEdgeMap<Option<HalfEdgeId>>,
    /// Direction of each face's side 0 in the frame of its parent, radians: an angle θ of the parent's frame
    /// is θ − turn in the frame of the face.
    pub frame_turn: FaceMap<f64>,
    /// Where each vertex comes from.
    pub vertex_origin: VertexMap<VertexOrigin>,
}

impl VertexOrigin {
    /// The point on the parent mesh.
    pub fn surface_point(&self, parent: &TriMesh) -> SurfacePoint {
        let at = |h: HalfEdgeId, t: f64| {
            let face = parent.face(h);
            let k = (h.0 - parent.first_half_edge(face).0) as usize;
            let mut weights = [0.0; 3];
            (weights[k], weights[(k + 1) % 3]) = (1.0 - t, t);
            SurfacePoint { face, weights }
        };
        match *self {
            Self::Vertex(v) => at(parent.outgoing_half_edge(v), 0.0),
            Self::Edge(e, t) => at(parent.half_edge(e), t),
            Self::Face(face) => SurfacePoint { face, weights: [1.0 / 3.0; 3] },
        }
    }
}

/// Splits edges at given parameters.
///
/// # Input      split: edges with parameters in 0..1 from the origin of the canonical half-edge; entries with
/// other parameters are ignored, of several for one edge the last counts
/// # Errors     [`MeshError`] if the result has more elements than ids
/// # Cost       linear
pub fn split_edges(mesh: &TriMesh, features: &FeatureGraph, split: &[(EdgeId, f64)]) -> Result<Refined, MeshError> {
    refine(mesh, features, split, &[])
}

/// Splits edges so that features are apart: afterwards no face has more than one feature edge, and every edge
/// between two feature vertices is a feature.
///
/// Otherwise aligning both feature edges of a triangle, or both ends of an edge, could make it degenerate in
/// the parameter domain ([Bommes2012] §8.4, feature line alignment).
///
/// # Errors     [`MeshError`] if the result has more elements than ids
/// # Cost       linear
pub fn separate_features(mesh: &TriMesh, features: &FeatureGraph) -> Result<Refined, MeshError> {
    // 1. Ordinary edges between features; this parts the feature edges of faces that have two of them.
    let on_feature = features.feature_vertices(mesh);
    let split: Vec<(EdgeId, f64)> = mesh
        .edges()
        .filter(|&e| !features.is_feature(e) && mesh.ends(e).iter().all(|&v| on_feature[v]))
        .map(|e| (e, 0.5))
        .collect();
    // 2. Faces bounded by features alone.
    let enclosed: Vec<FaceId> =
        mesh.faces().filter(|&f| mesh.sides(f).all(|h| features.is_feature(mesh.edge(h)))).collect();
    refine(mesh, features, &split, &enclosed)
}

/// Splits edges at parameters and faces at their centroids.
fn refine(
    mesh: &TriMesh,
    features: &FeatureGraph,
    split: &[(EdgeId, f64)],
    centroids: &[FaceId],
) -> Result<Refined, MeshError> {
    // 1. New vertices.
    let mut points = Points::new(mesh, split, centroids);
    // 2. Faces.
    let mut faces = Vec::with_capacity(mesh.face_count());
    let (mut parent_face, mut parent_half_edge) = (Vec::new(), Vec::new());
    for f in mesh.faces() {
        let polygon = Polygon::new(mesh, &points, f);
        for triangle in polygon.triangles(&points) {
            parent_face.push(f);
            parent_half_edge.extend([0, 1, 2].map(|k| polygon.side_between(triangle[k], triangle[(k + 1) % 3])));
            faces.push(triangle.map(|i| polygon.vertex(i)));
        }
    }
    // 3. The mesh, and frames where they changed.
    let fine = TriMesh::new(std::mem::take(&mut points.positions), &faces)?;
    let parent_face = FaceMap::from_vec(parent_face);
    let parent_half_edge = HalfEdgeMap::from_vec(parent_half_edge);
    let frame_turn = FaceMap::from_fn(fine.face_count(), |f| {
        let (side, parent) = (fine.first_half_edge(f), parent_face[f]);
        if parent_half_edge[side] == Some(mesh.first_half_edge(parent)) {
            return 0.0;
        }
        FaceFrame::of(mesh, parent).angle_of(fine.position(fine.target(side)) - fine.position(fine.origin(side)))
    });
    // 4. Features.
    let features = carry_features(mesh, &fine, features, &points, &parent_half_edge);
    let vertex_origin = VertexMap::from_vec(points.origin);
    Ok(Refined { mesh: fine, features, parent_face, parent_half_edge, frame_turn, vertex_origin })
}

/// Old and new vertices.
struct Points {
    positions: Vec<DVec3>,
    origin: Vec<VertexOrigin>,
    on_edge: EdgeMap<Option<u32>>,
    in_face: FaceMap<Option<u32>>,
}

impl Points {
    fn new(mesh: &TriMesh, split: &[(EdgeId, f64)], centroids: &[FaceId]) -> Self {
        let mut parameter = EdgeMap::filled(mesh.edge_count(), None);
        for &(e, t) in split {
            if t > 0.0 && t < 1.0 {
                parameter[e] = Some(t);
            }
        }
        let mut points = Self {
            positions: mesh.positions().values().to_vec(),
            origin: mesh.vertices().map(VertexOrigin::Vertex).collect(),
            on_edge: EdgeMap::filled(mesh.edge_count(), None),
            in_face: FaceMap::filled(mesh.face_count(), None),
        };
        for (e, &t) in parameter.iter() {
            if let Some(t) = t {
                let [a, b] = mesh.ends(e).map(|v| mesh.position(v));
                points.on_edge[e] = Some(points.positions.len() as u32);
                points.positions.push(a * (1.0 - t) + b * t);
                points.origin.push(VertexOrigin::Edge(e, t));
            }
        }
        for &f in centroids {
            let third = mesh.face_vertices(f).map(|v| mesh.position(v) / 3.0);
            points.in_face[f] = Some(points.positions.len() as u32);
            points.positions.push(third[0] + third[1] + third[2]);
            points.origin.push(VertexOrigin::Face(f));
        }
        points
    }
}

/// A face with the points on its sides, counter-clockwise from its first corner.
struct Polygon {
    vertices: Vec<u32>,
    /// The side that leaves each vertex.
    side: Vec<HalfEdgeId>,
    /// Place of each corner in `vertices`.
    corner: [usize; 3],
    centroid: Option<u32>,
}

impl Polygon {
    fn new(mesh: &TriMesh, points: &Points, f: FaceId) -> Self {
        let mut polygon = Self { vertices: Vec::new(), side: Vec::new(), corner: [0; 3], centroid: points.in_face[f] };
        for (k, h) in mesh.face_half_edges(f).into_iter().enumerate() {
            polygon.corner[k] = polygon.vertices.len();
            for v in std::iter::once(mesh.origin(h).0).chain(points.on_edge[mesh.edge(h)]) {
                polygon.vertices.push(v);
                polygon.side.push(h);
            }
        }
        polygon
    }

    /// Vertex at a place; the place after the last is the centroid.
    fn vertex(&self, place: usize) -> u32 {
        self.vertices.get(place).copied().or(self.centroid).unwrap_or(u32::MAX)
    }

    fn side_between(&self, from: usize, to: usize) -> Option<HalfEdgeId> {
        let n = self.vertices.len();
        (from < n && to == (from + 1) % n).then(|| self.side[from])
    }

    /// Triangles as places.
    fn triangles(&self, points: &Points) -> Vec<[usize; 3]> {
        let n = self.vertices.len();
        let after = |i: usize, steps: usize| (i + steps) % n;
        if self.centroid.is_some() {
            return (0..n).map(|i| [i, after(i, 1), n]).collect();
        }
        let is_split = [0, 1, 2].map(|k| self.corner.get(k + 1).copied().unwrap_or(n) - self.corner[k] == 2);
        match n {
            4 => {
                let k = is_split.iter().position(|&s| s).unwrap_or(0);
                let a = self.corner[k];
                vec![[a, after(a, 1), after(a, 3)], [after(a, 1), after(a, 2), after(a, 3)]]
            }
            5 => {
                // a, b: the unsplit side; p on bc, q on ca.
                let k = is_split.iter().position(|&s| !s).unwrap_or(0);
                let a = self.corner[k];
                let [b, p, c, q] = [1, 2, 3, 4].map(|steps| after(a, steps));
                let length = |i: usize, j: usize| {
                    points.positions[self.vertices[i] as usize].distance(points.positions[self.vertices[j] as usize])
                };
                let mut triangles = vec![[p, c, q]];
                if length(a, p) <= length(b, q) {
                    triangles.extend([[a, b, p], [a, p, q]]);
                } else {
                    triangles.extend([[a, b, q], [b, p, q]]);
                }
                triangles
            }
            6 => vec![[0, 1, 5], [1, 2, 3], [3, 4, 5], [1, 3, 5]],
            _ => vec![[0, 1, 2]],
        }
    }
}

fn carry_features(
    mesh: &TriMesh,
    fine: &TriMesh,
    features: &FeatureGraph,
    points: &Points,
    parent_half_edge: &HalfEdgeMap<Option<HalfEdgeId>>,
) -> FeatureGraph {
    let chain_of = EdgeMap::from_fn(fine.edge_count(), |e| {
        parent_half_edge[fine.half_edge(e)].and_then(|h| features.chain_of[mesh.edge(h)])
    });
    let is_corner = VertexMap::from_fn(fine.vertex_count(), |v| features.is_corner.get(v).copied().unwrap_or(false));
    let mut chains = features.chains.clone();
    for chain in &mut chains {
        let old = std::mem::take(&mut chain.vertices);
        for (i, &v) in old.iter().enumerate() {
            chain.vertices.push(v);
            let next = old.get(i + 1).or(if chain.closed { old.first() } else { None });
            let point = next.and_then(|&w| mesh.find_edge(v, w)).and_then(|e| points.on_edge[e]);
            chain.vertices.extend(point.map(VertexId));
        }
    }
    FeatureGraph { chain_of, chains, is_corner }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::features::FeatureOptions;
    use crate::topology::Summary;
    use proptest::prelude::*;

    /// A strip of triangles whose creases enclose and cross faces.
    fn folded_strip() -> TriMesh {
        let mut positions = Vec::new();
        for i in 0..9 {
            for j in 0..4 {
                positions.push(DVec3::new(f64::from(i), f64::from(j), f64::from((i * 7 + j * 5) % 4)));
            }
        }
        let mut faces = Vec::new();
        for i in 0..8u32 {
            for j in 0..3u32 {
                let a = 4 * i + j;
                faces.extend([[a, a + 4, a + 5], [a, a + 5, a + 1]]);
            }
        }
        TriMesh::new(positions, &faces).unwrap()
    }

    fn check(parent: &TriMesh, parent_features: &FeatureGraph, fine: &Refined) {
        assert!(Summary::of(&*fine.mesh).same_topology(&Summary::of(&**parent)));
        assert!((fine.mesh.area() - parent.area()).abs() < 1e-9 * parent.area());
        // Children lie in the plane of their parents, and turn like them.
        for f in fine.mesh.faces() {
            let p = fine.parent_face[f];
            assert!(fine.mesh.face_normal(f).dot(parent.face_normal(p)) > 1.0 - 1e-9);
            let (child, old) = (FaceFrame::of(&fine.mesh, f), FaceFrame::of(parent, p));
            assert!(old.direction(1.0).distance(child.direction(1.0 - fine.frame_turn[f])) < 1e-9);
        }
        for (v, origin) in fine.vertex_origin.iter() {
            assert!(origin.surface_point(parent).position(parent).distance(fine.mesh.position(v)) < 1e-12);
        }
        // Chains: the same ids, kinds and lengths; their edges are exactly the feature edges.
        assert_eq!(fine.features.chains.len(), parent_features.chains.len());
        let length = |mesh: &TriMesh, vs: &[VertexId]| {
            vs.windows(2).map(|w| mesh.position(w[0]).distance(mesh.position(w[1]))).sum::<f64>()
        };
        let mut edges = 0;
        for (id, (new, old)) in fine.features.chains.iter().zip(&parent_features.chains).enumerate() {
            assert_eq!((new.kind, new.closed), (old.kind, old.closed));
            let mut vertices = [new.vertices.clone(), old.vertices.clone()];
            if new.closed {
                vertices.iter_mut().for_each(|v| v.push(v[0]));
            }
            for w in vertices[0].windows(2) {
                let e = fine.mesh.find_edge(w[0], w[1]).expect("chain vertices are neighbours");
                assert_eq!(fine.features.chain_of[e], Some(id as u32));
                edges += 1;
            }
            assert!((length(&fine.mesh, &vertices[0]) - length(parent, &vertices[1])).abs() < 1e-9);
        }
        assert_eq!(edges, fine.features.edge_count());
    }

    #[test]
    fn separated_features_share_no_face_and_no_ordinary_edge() {
        let mesh = folded_strip();
        for sharp_angle in [None, Some(0.0), Some(35.0), Some(90.0)] {
            let options = FeatureOptions { sharp_angle, ..FeatureOptions::default() };
            let (features, _) = FeatureGraph::detect(&mesh, &options);
            let fine = separate_features(&mesh, &features).unwrap();
            check(&mesh, &features, &fine);
            let on = fine.features.feature_vertices(&fine.mesh);
            for f in fine.mesh.faces() {
                assert!(fine.mesh.sides(f).filter(|&h| fine.features.is_feature(fine.mesh.edge(h))).count() <= 1);
            }
            for e in fine.mesh.edges().filter(|&e| !fine.features.is_feature(e)) {
                assert!(fine.mesh.ends(e).iter().any(|&v| !on[v]));
            }
            let again = separate_features(&fine.mesh, &fine.features).unwrap();
            assert_eq!(again.mesh, fine.mesh, "nothing is left to separate");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn any_edges_can_be_split(chosen in proptest::collection::vec((0u32..83, 0.05..0.95f64), 0..83)) {
            let mesh = folded_strip();
            let (features, _) = FeatureGraph::detect(&mesh, &FeatureOptions::default());
            let split: Vec<_> = chosen.iter().map(|&(e, t)| (EdgeId(e), t)).collect();
            let fine = split_edges(&mesh, &features, &split).unwrap();
            check(&mesh, &features, &fine);
            let distinct: std::collections::BTreeSet<_> = split.iter().map(|&(e, _)| e).collect();
            prop_assert_eq!(fine.mesh.vertex_count(), mesh.vertex_count() + distinct.len());
        }
    }
}
