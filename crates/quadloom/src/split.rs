//! Triangles split into quads: the last resort where no integer-grid map is found, and the natural quads of a
//! component of a few triangles.
//!
//! In: a triangle mesh. Out: [`split_triangles`]: three quads per triangle, meeting at its centroid.
//! Holds: same topology; every quad lies in its triangle's plane and is convex where the triangle is not degenerate.
//! Not: few irregular vertices; every centroid has valence 3 and every mesh vertex keeps its own.

use quadloom_mesh::{DVec3, MeshError, QuadMesh, TriMesh};

/// Number of quads that [`split_triangles`] makes of each triangle.
pub const QUADS_PER_TRIANGLE: usize = 3;

/// Splits every triangle into three quads at its centroid and the midpoints of its sides.
///
/// Vertices come first, then one per edge, then one per face.
///
/// # Errors     none for a triangle mesh; the constructor of the quad mesh is not bypassed
/// # Cost       linear
pub fn split_triangles(mesh: &TriMesh) -> Result<QuadMesh, MeshError> {
    let (vertices, edges) = (mesh.vertex_count(), mesh.edge_count());
    let mut positions: Vec<DVec3> = mesh.positions().values().to_vec();
    positions.extend(mesh.edges().map(|e| {
        let [a, b] = mesh.ends(e);
        mesh.position(a).midpoint(mesh.position(b))
    }));
    positions.extend(mesh.faces().map(|f| {
        let [a, b, c] = mesh.face_vertices(f).map(|v| mesh.position(v));
        (a + b + c) / 3.0
    }));
    let mut quads = Vec::with_capacity(QUADS_PER_TRIANGLE * mesh.face_count());
    for f in mesh.faces() {
        for h in mesh.face_half_edges(f) {
            let [before, after] = [mesh.prev(h), h].map(|side| (vertices + mesh.edge(side).index()) as u32);
            let centre = (vertices + edges + f.index()) as u32;
            quads.push([mesh.origin(h).index() as u32, after, centre, before]);
        }
    }
    QuadMesh::new(positions, &quads)
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadloom_mesh::{Summary, VertexId};

    #[test]
    fn an_open_and_a_closed_mesh_keep_their_topology() {
        let corner = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let closed =
            TriMesh::new(corner.to_vec(), &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]).expect("a tetrahedron");
        let open = TriMesh::new(corner.to_vec(), &[[0, 2, 1], [0, 1, 3]]).expect("two triangles");
        for mesh in [closed, open] {
            let quads = split_triangles(&mesh).expect("quads");
            assert!(Summary::of(&quads).same_topology(&Summary::of(&mesh)));
            assert_eq!(quads.face_count(), 3 * mesh.face_count());
            assert!((quads.area() - mesh.area()).abs() < 1e-12);
            for v in mesh.vertices() {
                assert_eq!(quads.position(VertexId::new(v.index())), mesh.position(v));
                assert_eq!(quads.valence(v), mesh.valence(v));
            }
        }
    }
}
