//! Layers of a scene from meshes, features, fields and maps.
//!
//! In: checked meshes and what lives on them. Out: the parts of a [`Scene`](super::Scene), file units.
//! Holds: everything is listed in id order. Not: thinning, except for [`crosses`], which says how.

use super::histogram::scaled_jacobians;
use super::scene::{Cross, Polyline, QuadLayer, Segment, Singularity, SurfaceLayer};
use quadloom_mesh::metric::FaceFrame;
use quadloom_mesh::{DVec3, FaceMap, FeatureChain, FeatureGraph, FeatureKind, HalfEdgeId, QuadMesh, TriMesh, VertexId};
use quadloom_param::{IntegerGridMap, Transition};
use std::collections::HashMap;
use std::f64::consts::PI;

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

/// Crosses of a field with one angle per face, evenly thinned out to about `limit`.
///
/// Faces are passed in id order and one is taken unless a taken one of the same side of the surface is nearer than
/// r, where the discs of diameter r around `limit` points fill `JAMMED` of the area. A cross is at its face's
/// centroid and as long as `CROSS_LENGTH` times the side of a square of the area that it stands for.
///
/// # Input      angle: of one of the four directions in the frame of the face (x along side 0), radians
/// # Output     ascending by face; fewer than `limit` where there are fewer faces
/// # Cost       linear
pub fn crosses(mesh: &TriMesh, angle: &FaceMap<f64>, limit: usize) -> Vec<Cross> {
    let share = mesh.area() / limit.max(1) as f64;
    let mut taken = Spaced::new((JAMMED * share * 4.0 / PI).sqrt());
    let mut shown = Vec::new();
    for f in mesh.faces() {
        let area = mesh.vector_area(f).length();
        let point = mesh.face_vertices(f).iter().map(|&v| mesh.position(v) / 3.0).sum();
        let frame = FaceFrame::of(mesh, f);
        if area > 0.0 && taken.insert(point, frame.normal) {
            let u = frame.direction(angle[f]);
            shown.push(Cross { point, u, v: frame.normal.cross(u), length: CROSS_LENGTH * area.max(share).sqrt() });
        }
    }
    shown
}

/// Share of the area that discs cover which are placed one after the other until no more fit: 0.55 in random order,
/// nearly 0.7 row by row; ids of faces are in between, so that the number of crosses is right within a fifth.
const JAMMED: f64 = 0.6;
/// Longer crosses touch each other, shorter ones hide their directions.
const CROSS_LENGTH: f64 = 0.7;

/// Points with normals, those of the same side no nearer than a distance, in a grid of cells of that size.
struct Spaced {
    distance: f64,
    cells: HashMap<[i64; 3], Vec<(DVec3, DVec3)>>,
}

impl Spaced {
    fn new(distance: f64) -> Self {
        Self { distance, cells: HashMap::new() }
    }

    /// Adds a point unless it is too near to another one; whether it was added.
    fn insert(&mut self, point: DVec3, normal: DVec3) -> bool {
        let cell = (point / self.distance).floor().to_array().map(|x| x as i64);
        let offsets = || (0..27).map(|k| [k / 9 - 1, k / 3 % 3 - 1, k % 3 - 1]);
        let around = offsets().map(|d| [0, 1, 2].map(|k| cell[k].saturating_add(d[k])));
        let near = |&(p, n): &(DVec3, DVec3)| p.distance(point) < self.distance && n.dot(normal) > 0.0;
        if around.filter_map(|c| self.cells.get(&c)).flatten().any(near) {
            return false;
        }
        self.cells.entry(cell).or_default().push((point, normal));
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadloom_mesh::HalfEdgeMap;

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
    fn crosses_are_apart_and_leave_no_hole() {
        let mesh = triangulated(60);
        let angle = FaceMap::filled(mesh.face_count(), 0.3);
        let some = crosses(&mesh, &angle, 100);
        // Discs on the border reach over it, so there are more than on a closed surface.
        assert!((90..=140).contains(&some.len()), "{}", some.len());
        for c in &some {
            assert!(c.u.dot(c.v).abs() < 1e-12 && c.u.z == 0.0 && c.v.z == 0.0);
            assert!((c.u.length() - 1.0).abs() < 1e-12 && (c.length - 0.7 * 6.0).abs() < 1e-9);
        }
        let r = (JAMMED * 36.0 * 4.0 / PI).sqrt();
        let nearest =
            |p: DVec3| some.iter().map(|c| c.point.distance(p)).filter(|&d| d > 0.0).fold(f64::INFINITY, f64::min);
        assert!(some.iter().all(|c| nearest(c.point) >= r));
        assert!(mesh.vertices().all(|v| nearest(mesh.position(v)) < r + 1.0));
        assert_eq!(crosses(&mesh, &angle, 100_000).len(), mesh.face_count());
    }

    #[test]
    fn both_sides_of_a_thin_wall_have_crosses() {
        let (mut points, quads) = grid(20);
        let n = points.len() as u32;
        points.extend(points.clone().iter().map(|&p| p + DVec3::Z * 1e-3));
        let up = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]].map(|t| t.map(|v| v + n)));
        let down = quads.iter().flat_map(|&[a, b, c, d]| [[a, c, b], [a, d, c]]);
        let mesh = TriMesh::new(points, &up.chain(down).collect::<Vec<_>>()).unwrap();
        let shown = crosses(&mesh, &FaceMap::filled(mesh.face_count(), 0.0), 200);
        let above = shown.iter().filter(|c| c.point.z > 0.0).count();
        assert!(above > 70 && shown.len() - above > 70, "{above} of {}", shown.len());
    }
}
