//! Parallel transport between the frames of neighbouring faces.
//!
//! In: connectivity and edge lengths. Out: [`Transport`]: κ per edge, directions of half-edges, angle defects,
//! base indices. Holds: κ_ji = -κ_ij exactly; the angles of every face sum to π, so that around every interior
//! vertex Σκ equals the angle defect up to whole turns. Never reads a position.
//! Source: [Bommes2012] §8.2, Eq. (8.1) and the base index I0; [Ray2008].
//!
//! | paper | here | meaning | unit |
//! |---|---|---|---|
//! | κ_ij | [`Transport::kappa`] | turns a direction of frame i into frame j | radians |
//! | A_d(v) | [`Transport::defect`] | angle defect | radians |
//! | I_0(v) | [`Transport::base_index`] / 4 | index of the field with all p = 0 | quarters |

use quadloom_mesh::metric::{corner_angles, edge_lengths, half_edge_directions, wrap_angle};
use quadloom_mesh::{CornerMap, EdgeMap, HalfEdgeId, TriConnectivity, TriMesh, VertexId, VertexMap};
use std::f64::consts::{FRAC_2_PI, PI, TAU};

/// Transport between face frames and the base indices of a triangle mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Transport {
    kappa: EdgeMap<f64>,
    direction: CornerMap<f64>,
    defect: VertexMap<f64>,
    base_index: VertexMap<i32>,
}

impl Transport {
    /// Transport of a mesh with the given edge lengths.
    ///
    /// # Cost       linear
    pub fn new(mesh: &TriConnectivity, length: &EdgeMap<f64>) -> Self {
        let direction = half_edge_directions(mesh, &corner_angles(mesh, length));
        let kappa = EdgeMap::from_fn(mesh.edge_count(), |e| {
            let h = mesh.half_edge(e);
            mesh.twin(h).map_or(0.0, |t| wrap_angle(direction[t] + PI - direction[h]))
        });
        let mut transport = Self {
            kappa,
            direction,
            defect: VertexMap::filled(mesh.vertex_count(), 0.0),
            base_index: VertexMap::filled(mesh.vertex_count(), 0),
        };
        for v in mesh.vertices() {
            transport.defect[v] = transport.angle_defect(mesh, v);
            transport.base_index[v] = transport.rounded_base_index(mesh, v);
        }
        transport
    }

    /// Transport of a mesh in space.
    pub fn of(mesh: &TriMesh) -> Self {
        Self::new(mesh, &edge_lengths(mesh))
    }

    /// κ across a half-edge, from the frame of its face to that of the face across, radians; 0 on the boundary.
    #[inline]
    pub fn kappa(&self, mesh: &TriConnectivity, h: HalfEdgeId) -> f64 {
        let e = mesh.edge(h);
        if mesh.half_edge(e) == h { self.kappa[e] } else { -self.kappa[e] }
    }

    /// Direction of a half-edge in the frame of its face, radians.
    #[inline]
    pub fn direction(&self, h: HalfEdgeId) -> f64 {
        self.direction[h]
    }

    /// Angle defect of a vertex, radians: 2π (π on the boundary) minus the angles around it.
    #[inline]
    pub fn defect(&self, v: VertexId) -> f64 {
        self.defect[v]
    }

    /// Four times the base index I_0 of an interior vertex; 0 on the boundary.
    #[inline]
    pub fn base_index(&self, v: VertexId) -> i32 {
        self.base_index[v]
    }

    /// Half-edges crossed by a counter-clockwise walk around a vertex, each leaving the face it belongs to.
    ///
    /// ```text
    ///        /  next face          the walk leaves face(h), h outgoing, through prev(h)
    ///       /
    ///      v ───── h ────►
    /// ```
    pub fn crossings<'a>(&'a self, mesh: &'a TriConnectivity, v: VertexId) -> impl Iterator<Item = HalfEdgeId> + 'a {
        mesh.outgoing(v).map(|h| mesh.prev(h)).filter(|&h| mesh.twin(h).is_some())
    }

    /// The defect from the angles between half-edge directions, which sum to π in every face whatever its lengths.
    fn angle_defect(&self, mesh: &TriConnectivity, v: VertexId) -> f64 {
        let full = if mesh.is_boundary_vertex(v) { PI } else { TAU };
        full - mesh.outgoing(v).map(|h| self.corner_angle(mesh, h)).sum::<f64>()
    }

    fn corner_angle(&self, mesh: &TriConnectivity, h: HalfEdgeId) -> f64 {
        let turn = wrap_angle(self.direction[mesh.prev(h)] + PI - self.direction[h]);
        // A turn just below -π is an angle of π that was rounded; small negative angles are zero.
        if turn < -0.5 * PI { turn + TAU } else { turn }
    }

    /// 4·I_0 = (A_d - Σκ)·2/π, an integer by construction ([Bommes2012] §8.2, base index).
    fn rounded_base_index(&self, mesh: &TriConnectivity, v: VertexId) -> i32 {
        if mesh.is_boundary_vertex(v) {
            return 0;
        }
        let turn: f64 = self.crossings(mesh, v).map(|h| self.kappa(mesh, h)).sum();
        let quarters = (self.defect[v] - turn) * FRAC_2_PI;
        debug_assert!((quarters - quarters.round()).abs() < 1e-6, "base index of {v} is {quarters} quarters");
        quarters.round() as i32
    }
}
