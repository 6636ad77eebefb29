//! Layers of a scene from meshes, features, fields and maps.
//!
//! In: checked meshes and what lives on them. Out: the parts of a [`Scene`](super::Scene), file units.
//! Holds: everything is listed in id order. Not: thinning, except for [`crosses`], which says how.

use super::histogram::scaled_jacobians;
use super::scene::{Cross, Polyline, QuadLayer, Segment, Singularity, SurfaceLayer};
use quadloom_mesh::metric::FaceFrame;
use quadloom_mesh::{FaceMap, FeatureChain, FeatureGraph, FeatureKind, HalfEdgeId, QuadMesh, TriMesh, VertexId};
use quadloom_param::{IntegerGridMap, Transition};

impl SurfaceLayer {
    /// The surface of a triangle mesh.
    pub fn of(mesh: &TriMesh) -> Self {
        Self { positions: mesh.positions().values().to_vec(), triangles: mesh.connectivity().to_faces() }
    }
}

impl QuadLayer {
    /// The quads of a mesh with their scaled Jacobians.
    pub fn of(mesh: &QuadMesh) -> Self {
        Self {
            positions: mesh.positions().values().to_vec(),
            quads: mesh.connectivity().to_faces(),
            quality: scaled_jacobians(mesh),
        }
    }
}

/// Interior vertices of a quad mesh whose valence is not four, ascending.
pub fn irregular_vertices(mesh: &QuadMesh) -> Vec<Singularity> {
    let interior = mesh.vertices().filter(|&v| !mesh.is_boundary_vertex(v));
    interior
        .map(|v| Singularity { position: mesh.position(v), valence: mesh.valence(v) as u32 })
        .filter(|s| s.valence != 4)
        .collect()
}

/// Feature curves that are no boundary, by chain.
pub fn feature_lines(mesh: &TriMesh, features: &FeatureGraph) -> Vec<Polyline> {
    let inner = features.chains.iter().filter(|c| c.kind != FeatureKind::Boundary);
    inner.map(|c| chain_line(mesh, c)).collect()
}

fn chain_line(mesh: &TriMesh, chain: &FeatureChain) -> Polyline {
    Polyline { points: chain.vertices.iter().map(|&v| mesh.position(v)).collect(), closed: chain.closed }
}

/// Boundary loops of a triangle mesh, by their smallest half-edge.
///
/// # Cost       linear
pub fn boundary_lines(mesh: &TriMesh) -> Vec<Polyline> {
    let mut next = vec![None; mesh.vertex_count()];
    let sides = || mesh.half_edges().filter(|&h| mesh.twin(h).is_none());
    for h in sides() {
        next[mesh.origin(h).index()] = Some(mesh.target(h));
    }
    let mut loops = Vec::new();
    for h in sides() {
        let points: Vec<_> = take_loop(&mut next, mesh.origin(h)).into_iter().map(|v| mesh.position(v)).collect();
        if !points.is_empty() {
            loops.push(Polyline { points, closed: true });
        }
    }
    loops
}

/// Follows `next` from `start` until it ends, removing what it passes.
fn take_loop(next: &mut [Option<VertexId>], start: VertexId) -> Vec<VertexId> {
    let mut passed = Vec::new();
    let mut at = start;
    while let Some(following) = next[at.index()].take() {
        passed.push(at);
        at = following;
    }
    passed
}

/// Edges across which the transition is not the identity, ascending.
///
/// # Source     [Bommes2012] §6, Eq. (6.1)
pub fn seams(mesh: &TriMesh, map: &IntegerGridMap) -> Vec<Segment> {
    let is_seam = |h: HalfEdgeId| mesh.twin(h).is_some() && map.transition[h] != Transition::IDENTITY;
    mesh.edges().filter(|&e| is_seam(mesh.half_edge(e))).map(|e| mesh.ends(e).map(|v| mesh.position(v))).collect()
}

/// Crosses of a field with one angle per face, thinned out to about `limit` crosses of equal area.
///
/// Faces are passed in id order and one is taken whenever the area passed since the last reaches the total
/// divided by `limit`, so large faces keep theirs and small ones share. A cross is at its face's centroid and as
/// long as 0.7 times the side of a square of the area that it stands for.
///
/// # Input      angle: of one of the four directions in the frame of the face (x along side 0), radians
/// # Cost       linear
pub fn crosses(mesh: &TriMesh, angle: &FaceMap<f64>, limit: usize) -> Vec<Cross> {
    let share = mesh.area() / limit.max(1) as f64;
    let mut passed = 0.5 * share;
    let mut taken = Vec::new();
    for f in mesh.faces() {
        let area = mesh.vector_area(f).length();
        passed += area;
        if passed >= share && area > 0.0 {
            passed %= share;
            let frame = FaceFrame::of(mesh, f);
            let u = frame.direction(angle[f]);
            let point = mesh.face_vertices(f).iter().map(|&v| mesh.position(v) / 3.0).sum();
            let length = 0.7 * area.max(share).sqrt();
            taken.push(Cross { point, u, v: frame.normal.cross(u), length });
        }
    }
    taken
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadloom_mesh::{DVec3, HalfEdgeMap};

    fn grid(n: u32) -> (Vec<DVec3>, Vec<[u32; 4]>) {
        let points = (0..=n).flat_map(|j| (0..=n).map(move |i| DVec3::new(f64::from(i), f64::from(j), 0.0))).collect();
        let at = move |i: u32, j: u32| j * (n + 1) + i;
        let quads = (0..n)
            .flat_map(|j| (0..n).map(move |i| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]))
            .collect();
        (points, quads)
    }

    fn triangulated(n: u32) -> TriMesh {
        let (points, quads) = grid(n);
        let faces: Vec<_> = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        TriMesh::new(points, &faces).unwrap()
    }

    #[test]
    fn a_regular_grid_has_no_irregular_vertex_and_a_cube_eight() {
        let (points, quads) = grid(3);
        assert!(irregular_vertices(&QuadMesh::new(points, &quads).unwrap()).is_empty());
        let corners = (0..8).map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2))).collect();
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let cube = irregular_vertices(&QuadMesh::new(corners, &faces).unwrap());
        assert_eq!(cube.iter().map(|s| s.valence).collect::<Vec<_>>(), [3; 8]);
    }

    #[test]
    fn loops_cover_the_boundary_once() {
        let (points, quads) = grid(5);
        let ring = quads.iter().filter(|q| q[0] != 14);
        let faces: Vec<_> = ring.flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let mesh = TriMesh::new(points, &faces).unwrap();
        let loops = boundary_lines(&mesh);
        let length = |l: &Polyline| l.segments().map(|[a, b]| a.distance(b)).sum::<f64>();
        let mut lengths: Vec<_> = loops.iter().map(length).collect();
        lengths.sort_by(f64::total_cmp);
        assert_eq!(lengths, [4.0, 20.0]);
    }

    #[test]
    fn seams_are_the_edges_with_a_transition() {
        let mesh = triangulated(2);
        let inner = mesh.edges().find(|&e| !mesh.is_boundary_edge(e)).unwrap();
        let (uv, mut transition) = (
            quadloom_mesh::CornerMap::filled(mesh.half_edge_count(), [0, 0]),
            HalfEdgeMap::filled(mesh.half_edge_count(), Transition::IDENTITY),
        );
        let turn = Transition { quarter_turns: 1, translation: [0, 0] };
        transition[mesh.half_edge(inner)] = turn;
        let map = IntegerGridMap { uv, transition };
        assert_eq!(seams(&mesh, &map), [mesh.ends(inner).map(|v| mesh.position(v))]);
    }

    #[test]
    fn crosses_lie_in_their_faces_and_keep_to_the_limit() {
        let mesh = triangulated(20);
        let angle = FaceMap::filled(mesh.face_count(), 0.3);
        let some = crosses(&mesh, &angle, 100);
        assert!((95..=105).contains(&some.len()), "{}", some.len());
        for c in &some {
            assert!(c.u.dot(c.v).abs() < 1e-12 && c.u.z == 0.0 && c.v.z == 0.0);
            assert!((c.u.length() - 1.0).abs() < 1e-12 && (c.length - 0.7 * 2.0).abs() < 1e-9);
        }
        assert_eq!(crosses(&mesh, &angle, 10_000).len(), mesh.face_count());
    }
}
