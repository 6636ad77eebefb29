//! Lengths, angles, areas, cotangents and face frames of a triangle mesh.
//!
//! In: connectivity and edge lengths (positions only where a function says so), file units.
//! Out: maps of lengths, radians, areas. Holds: finite values for degenerate triangles too, where the
//! triangle inequality is violated angles are clamped to 0 and π. Source: Euclidean trigonometry.

use crate::connectivity::TriConnectivity;
use crate::ids::{CornerMap, EdgeMap, FaceId, FaceMap, HalfEdgeId, VertexMap};
use crate::mesh::TriMesh;
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// Length of every edge, file units.
pub fn edge_lengths(mesh: &TriMesh) -> EdgeMap<f64> {
    EdgeMap::from_fn(mesh.edge_count(), |e| {
        let [a, b] = mesh.ends(e);
        mesh.position(a).distance(mesh.position(b))
    })
}

/// Interior angle of every corner, radians in 0..=π.
pub fn corner_angles(mesh: &TriConnectivity, length: &EdgeMap<f64>) -> CornerMap<f64> {
    CornerMap::from_fn(mesh.half_edge_count(), |h| {
        let (right, opposite, left) =
            (length[mesh.edge(h)], length[mesh.edge(mesh.next(h))], length[mesh.edge(mesh.prev(h))]);
        let denominator = 2.0 * right * left;
        if denominator <= 0.0 {
            return 0.0;
        }
        ((right * right + left * left - opposite * opposite) / denominator).clamp(-1.0, 1.0).acos()
    })
}

/// Area of every face, file units squared, by Heron's formula in its stable form.
pub fn face_areas(mesh: &TriConnectivity, length: &EdgeMap<f64>) -> FaceMap<f64> {
    FaceMap::from_fn(mesh.face_count(), |f| {
        let mut side = mesh.face_half_edges(f).map(|h| length[mesh.edge(h)]);
        side.sort_by(|a, b| b.total_cmp(a));
        let [a, b, c] = side;
        let product = (a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c));
        0.25 * product.max(0.0).sqrt()
    })
}

/// Angle defect of every vertex, radians: 2π (π on the boundary) minus the angles around it.
///
/// The sum is 2π·chi ([Bommes2012] §6, footnote 1; Gauss-Bonnet).
pub fn angle_defects(mesh: &TriConnectivity, angle: &CornerMap<f64>) -> VertexMap<f64> {
    VertexMap::from_fn(mesh.vertex_count(), |v| {
        let full = if mesh.is_boundary_vertex(v) { PI } else { TAU };
        full - mesh.outgoing(v).map(|h| angle[h]).sum::<f64>()
    })
}

/// Cotangent of the angle opposite to every half-edge, clamped to ±1e6 for degenerate triangles.
pub fn opposite_cotangents(mesh: &TriConnectivity, length: &EdgeMap<f64>) -> CornerMap<f64> {
    let area = face_areas(mesh, length);
    CornerMap::from_fn(mesh.half_edge_count(), |h| {
        let (c, a, b) = (length[mesh.edge(h)], length[mesh.edge(mesh.next(h))], length[mesh.edge(mesh.prev(h))]);
        ((a * a + b * b - c * c) / (4.0 * area[mesh.face(h)]).max(f64::MIN_POSITIVE)).clamp(-1e6, 1e6)
    })
}

/// The corners of a face laid out in its own frame: origin at corner 0, x axis along side 0, file units.
pub fn face_layout(mesh: &TriConnectivity, length: &EdgeMap<f64>, f: FaceId) -> [DVec2; 3] {
    let [ab, bc, ca] = mesh.face_half_edges(f).map(|h| length[mesh.edge(h)]);
    if ab <= 0.0 {
        return [DVec2::ZERO, DVec2::ZERO, DVec2::new(ca, 0.0)];
    }
    let x = (ca * ca + ab * ab - bc * bc) / (2.0 * ab);
    [DVec2::ZERO, DVec2::new(ab, 0.0), DVec2::new(x, (ca * ca - x * x).max(0.0).sqrt())]
}

/// Direction of every half-edge in the frame of its face, radians in (-π, π]; side 0 has angle 0.
pub fn half_edge_directions(mesh: &TriConnectivity, angle: &CornerMap<f64>) -> CornerMap<f64> {
    CornerMap::from_fn(mesh.half_edge_count(), |h| {
        let [a, b, _] = mesh.face_half_edges(mesh.face(h));
        match h.0 - a.0 {
            0 => 0.0,
            1 => PI - angle[b],
            _ => wrap_angle(PI + angle[a]),
        }
    })
}

/// Angle that turns a direction of a half-edge's face frame into the frame of the face across, radians in (-π, π].
///
/// For half-edge h from face i to face j: θ_j = θ_i + κ_ij when both are flattened along the common edge
/// ([Bommes2012] §8.2, Eq. (8.1)). Zero on the boundary. Antisymmetric except at exactly ±π.
pub fn transport_angle(mesh: &TriConnectivity, direction: &CornerMap<f64>, h: HalfEdgeId) -> f64 {
    mesh.twin(h).map_or(0.0, |t| wrap_angle(direction[t] + PI - direction[h]))
}

/// The angle's representative in (-π, π].
pub fn wrap_angle(angle: f64) -> f64 {
    let wrapped = angle - TAU * (angle / TAU).round();
    if wrapped <= -PI { wrapped + TAU } else { wrapped }
}

/// Orthonormal frame of a face in space: x along side 0, y to its left, z the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaceFrame {
    /// Unit vector along side 0.
    pub x: DVec3,
    /// Unit vector in the face, a quarter turn counter-clockwise of x.
    pub y: DVec3,
    /// Unit normal.
    pub normal: DVec3,
}

impl FaceFrame {
    /// The frame of face `f`; some orthonormal frame where the face has no area.
    pub fn of(mesh: &TriMesh, f: FaceId) -> Self {
        let [a, b, c] = mesh.face_vertices(f).map(|v| mesh.position(v));
        let side = if a != b { b - a } else { c - a };
        let mut x = side.normalize_or_zero();
        if x == DVec3::ZERO {
            x = DVec3::X;
        }
        let mut normal = mesh.face_normal(f);
        normal = (normal - x * x.dot(normal)).normalize_or_zero();
        if normal == DVec3::ZERO {
            normal = x.any_orthonormal_vector();
        }
        Self { x, y: normal.cross(x), normal }
    }

    /// The unit vector at `angle` radians from x.
    pub fn direction(&self, angle: f64) -> DVec3 {
        self.x * angle.cos() + self.y * angle.sin()
    }

    /// The angle of a vector's projection, radians in (-π, π].
    pub fn angle_of(&self, v: DVec3) -> f64 {
        v.dot(self.y).atan2(v.dot(self.x))
    }
}

/// Angle between the normals of the faces of an edge, radians in 0..=π; zero on the boundary.
pub fn dihedral_angle(mesh: &TriMesh, h: HalfEdgeId) -> f64 {
    let Some(t) = mesh.twin(h) else { return 0.0 };
    let (m, n) = (mesh.face_normal(mesh.face(h)), mesh.face_normal(mesh.face(t)));
    if m == DVec3::ZERO || n == DVec3::ZERO { 0.0 } else { m.cross(n).length().atan2(m.dot(n)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes;
    use crate::topology::euler_characteristic;
    use proptest::prelude::*;

    fn test_shapes() -> Vec<TriMesh> {
        vec![
            shapes::with_noise(&shapes::sphere(1.0, 2), 0.02, 7),
            shapes::torus(1.0, 0.4, 12, 9),
            shapes::smooth_genus(3, 1),
            shapes::cylinder(1.0, 2.0, 8, 5),
            shapes::plate_with_holes(0.5),
            shapes::bracket(0.7),
        ]
    }

    #[test]
    fn angle_defects_sum_to_the_euler_characteristic() {
        for mesh in test_shapes() {
            let defects = angle_defects(&mesh, &corner_angles(&mesh, &edge_lengths(&mesh)));
            let total: f64 = defects.values().iter().sum();
            assert!((total - TAU * euler_characteristic(mesh.connectivity()) as f64).abs() < 1e-9);
        }
    }

    #[test]
    fn transport_around_a_vertex_turns_by_its_defect() {
        for mesh in test_shapes() {
            let angle = corner_angles(&mesh, &edge_lengths(&mesh));
            let (direction, defect) = (half_edge_directions(&mesh, &angle), angle_defects(&mesh, &angle));
            for v in mesh.vertices().filter(|&v| !mesh.is_boundary_vertex(v)) {
                // Counter-clockwise: from each face across the side that enters v.
                let turn: f64 = mesh.outgoing(v).map(|h| transport_angle(&mesh, &direction, mesh.prev(h))).sum();
                assert!(wrap_angle(turn - defect[v]).abs() < 1e-9, "{turn} and {}", defect[v]);
            }
        }
    }

    #[test]
    fn intrinsic_and_spatial_measures_agree() {
        for mesh in test_shapes() {
            let length = edge_lengths(&mesh);
            let angle = corner_angles(&mesh, &length);
            let (area, cotangent) = (face_areas(&mesh, &length), opposite_cotangents(&mesh, &length));
            let direction = half_edge_directions(&mesh, &angle);
            for f in mesh.faces() {
                let frame = FaceFrame::of(&mesh, f);
                let layout = face_layout(&mesh, &length, f);
                assert!((area[f] - mesh.vector_area(f).length()).abs() < 1e-12);
                assert!((frame.x.cross(frame.y) - frame.normal).length() < 1e-12);
                for (k, h) in mesh.face_half_edges(f).into_iter().enumerate() {
                    let side = mesh.position(mesh.target(h)) - mesh.position(mesh.origin(h));
                    let other = mesh.position(mesh.origin(mesh.prev(h))) - mesh.position(mesh.origin(h));
                    assert!((angle[h] - side.angle_between(other)).abs() < 1e-7);
                    assert!(wrap_angle(direction[h] - frame.angle_of(side)).abs() < 1e-7);
                    let flat = layout[(k + 1) % 3] - layout[k];
                    assert!(
                        flat.distance(frame.direction(direction[h]).dot(side) * DVec2::from_angle(direction[h])) < 1e-7
                    );
                    assert!((cotangent[h] - 1.0 / angle[mesh.prev(h)].tan()).abs() < 1e-6);
                }
            }
        }
    }

    #[test]
    fn a_cube_turns_by_right_angles() {
        let mesh = shapes::cube(1.0, 3);
        for e in mesh.edges() {
            let turn = dihedral_angle(&mesh, mesh.half_edge(e));
            assert!(turn.abs() < 1e-12 || (turn - PI / 2.0).abs() < 1e-12);
        }
    }

    proptest! {
        #[test]
        fn wrapping_keeps_the_direction(angle in -1e3..1e3f64) {
            let wrapped = wrap_angle(angle);
            prop_assert!(-PI < wrapped && wrapped <= PI);
            prop_assert!((wrapped.sin() - angle.sin()).abs() < 1e-9 && (wrapped.cos() - angle.cos()).abs() < 1e-9);
        }

        #[test]
        fn any_three_lengths_have_finite_measures(side in [0.0..2.0f64, 0.0..2.0, 0.0..2.0]) {
            // Also lengths that no triangle has.
            let mesh = TriConnectivity::from_faces(3, &[[0, 1, 2]]).unwrap();
            let length = EdgeMap::from_vec(side.to_vec());
            let angle = corner_angles(&mesh, &length);
            prop_assert!(angle.values().iter().all(|a| (0.0..=PI).contains(a)));
            prop_assert!(face_areas(&mesh, &length)[FaceId(0)] >= 0.0);
            prop_assert!(opposite_cotangents(&mesh, &length).values().iter().all(|c| c.abs() <= 1e6));
            prop_assert!(face_layout(&mesh, &length, FaceId(0)).iter().all(|p| p.is_finite()));
        }
    }
}
