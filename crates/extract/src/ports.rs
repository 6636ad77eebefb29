//! Ports: the unit grid directions that leave every grid point, counter-clockwise on the surface.
//!
//! In: a mesh, its map, the grid points. Out: [`Ports`], grouped by grid point.
//! Holds: around an interior regular point there are four, around an interior vertex of cone index i there are 4 - i;
//! faces of negative orientation contribute their directions in mirrored order.
//! Source: [Ebke2013] §4.2, own layout.
//!
//! ```text
//!            \ prev(h)            around a mesh vertex w, counter-clockwise:
//!    sector   \                   the edge of h, the directions strictly inside the sector of corner h,
//!    of next   \  sector of h     then the same for the next outgoing half-edge;
//!    corner     w ───────── h     on the boundary the last edge follows at the end
//! ```

use crate::grid_points::{Carrier, GridPoint, GridPoints};
use crate::lattice::{cross_direction, difference};
use quadloom_mesh::{EdgeId, FaceId, FaceMap, HalfEdgeId, TriConnectivity};
use quadloom_param::{IntegerGridMap, LatticePoint};

/// Where a port leaves its grid point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Site {
    /// Into the interior of the face of `half_edge`, in `direction` of the face's chart. `half_edge` is the corner of
    /// a vertex's sector, the edge of an edge's point as this face sees it, or any side around a face's point.
    Face { half_edge: HalfEdgeId, direction: u8 },
    /// Along the edge of `half_edge`, with it or against it.
    Edge { half_edge: HalfEdgeId, forward: bool },
}

/// A site without the details that several names of the same site may differ in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SiteKey {
    Face(FaceId, u8),
    /// The edge, and whether it is followed in the sense of its canonical half-edge.
    Edge(EdgeId, bool),
}

impl Site {
    pub fn key(self, mesh: &TriConnectivity) -> SiteKey {
        match self {
            Self::Face { half_edge, direction } => SiteKey::Face(mesh.face(half_edge), direction),
            Self::Edge { half_edge, forward } => {
                let e = mesh.edge(half_edge);
                SiteKey::Edge(e, forward == (mesh.half_edge(e) == half_edge))
            }
        }
    }
}

/// One outgoing grid direction of a grid point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Port {
    pub point: u32,
    pub site: Site,
}

/// All ports, grouped by grid point, counter-clockwise within each group.
pub(crate) struct Ports {
    pub list: Vec<Port>,
    /// Ports of point q: `first[q]..first[q + 1]`.
    pub first: Vec<u32>,
    /// Whether the surface surrounds the point, so that its last port is followed by its first.
    pub surrounded: Vec<bool>,
}

impl Ports {
    /// Lists the ports of every grid point.
    ///
    /// # Cost       linear in the fans of the points
    pub fn find(mesh: &TriConnectivity, map: &IntegerGridMap, sign: &FaceMap<i8>, points: &GridPoints) -> Self {
        let mut ports = Self { list: Vec::new(), first: Vec::new(), surrounded: Vec::new() };
        for (q, point) in points.points.iter().enumerate() {
            ports.first.push(ports.list.len() as u32);
            let surrounded = ports.leave(mesh, map, sign, q as u32, point);
            ports.surrounded.push(surrounded);
        }
        ports.first.push(ports.list.len() as u32);
        ports
    }

    /// Numbers of the ports of a point.
    pub fn of(&self, point: u32) -> std::ops::Range<u32> {
        self.first[point as usize]..self.first[point as usize + 1]
    }

    /// The port of a point at a site.
    pub fn at(&self, mesh: &TriConnectivity, point: u32, site: SiteKey) -> Option<u32> {
        self.of(point).find(|&p| self.list[p as usize].site.key(mesh) == site)
    }

    /// The chart in which the segment of a port starts: its face, and the point in it.
    pub fn start(&self, mesh: &TriConnectivity, map: &IntegerGridMap, points: &GridPoints, port: u32) -> LatticePoint {
        let Port { point, site } = self.list[port as usize];
        let (Site::Face { half_edge, .. } | Site::Edge { half_edge, .. }) = site;
        let GridPoint { carrier, face, at } = points.points[point as usize];
        match carrier {
            Carrier::Vertex(v) => {
                let corner = if mesh.origin(half_edge) == v { half_edge } else { mesh.next(half_edge) };
                map.uv[corner]
            }
            Carrier::Edge(e) if mesh.face(half_edge) != face => map.transition[mesh.half_edge(e)].apply(at),
            _ => at,
        }
    }

    /// Lists the ports of one point; returns whether the surface surrounds it.
    fn leave(
        &mut self,
        mesh: &TriConnectivity,
        map: &IntegerGridMap,
        sign: &FaceMap<i8>,
        point: u32,
        at: &GridPoint,
    ) -> bool {
        match at.carrier {
            Carrier::Vertex(v) => {
                for h in mesh.outgoing(v) {
                    self.along(map, mesh, point, h, true);
                    let last = mesh.prev(h);
                    let arms = [difference(map.uv[h], map.uv[mesh.next(h)]), difference(map.uv[h], map.uv[last])];
                    self.inside(point, h, sign[mesh.face(h)], arms);
                    if mesh.twin(last).is_none() {
                        self.along(map, mesh, point, last, false);
                    }
                }
                !mesh.is_boundary_vertex(v)
            }
            Carrier::Edge(e) => {
                let h = mesh.half_edge(e);
                self.along(map, mesh, point, h, true);
                self.beside(map, mesh, sign, point, h);
                self.along(map, mesh, point, h, false);
                if let Some(t) = mesh.twin(h) {
                    self.beside(map, mesh, sign, point, t);
                }
                mesh.twin(h).is_some()
            }
            Carrier::Face(f) => {
                let half_edge = mesh.first_half_edge(f);
                for k in 0..4u8 {
                    let direction = if sign[f] > 0 { k } else { (4 - k) % 4 };
                    self.list.push(Port { point, site: Site::Face { half_edge, direction } });
                }
                true
            }
        }
    }

    /// The port along an edge, if the edge follows a grid line.
    fn along(
        &mut self,
        map: &IntegerGridMap,
        mesh: &TriConnectivity,
        point: u32,
        half_edge: HalfEdgeId,
        forward: bool,
    ) {
        let d = difference(map.uv[half_edge], map.uv[mesh.next(half_edge)]);
        if (d[0] == 0) != (d[1] == 0) {
            self.list.push(Port { point, site: Site::Edge { half_edge, forward } });
        }
    }

    /// The ports from a point inside an edge into the face of `half_edge`.
    fn beside(
        &mut self,
        map: &IntegerGridMap,
        mesh: &TriConnectivity,
        sign: &FaceMap<i8>,
        point: u32,
        half_edge: HalfEdgeId,
    ) {
        let arm = difference(map.uv[half_edge], map.uv[mesh.next(half_edge)]);
        self.inside(point, half_edge, sign[mesh.face(half_edge)], [arm, [-arm[0], -arm[1]]]);
    }

    /// The directions strictly between two arms of an angle of at most π, from the first to the second.
    fn inside(&mut self, point: u32, half_edge: HalfEdgeId, sign: i8, [a, b]: [LatticePoint; 2]) {
        let s = i64::from(sign);
        let within = |d: u8| s * cross_direction(a, d) > 0 && s * cross_direction(b, d) < 0;
        // A positive face turns counter-clockwise in its chart, a negative one clockwise.
        let step = if sign > 0 { 1 } else { 3 };
        let Some(first) = (0..4u8).find(|&d| within(d) && !within((d + 4 - step) % 4)) else { return };
        for direction in (0..4u8).map(|k| (first + k * step) % 4).take_while(|&d| within(d)) {
            self.list.push(Port { point, site: Site::Face { half_edge, direction } });
        }
    }
}
