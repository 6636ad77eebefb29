//! Names of sources become sources on the repaired surface.
//!
//! In: what a user named, the repaired surface. Out: [`quadloom_geodesic::Source`] values labelled by the number of
//! their `--from`. Holds: points in space are moved to the nearest point of the surface, and how far is told.

use super::request::{DistanceRequest, Named};
use crate::error::RemeshError;
use quadloom_geodesic::{CurveTracer, IntrinsicSurface, Source, boundary_sources, edge_sources};
use quadloom_io::CurvePoint;
use quadloom_mesh::metric::dihedral_angle;
use quadloom_mesh::repair::Repaired;
use quadloom_mesh::{ClosestPoint, EdgeId, FaceSoup, Progress, SurfacePoint, TriMesh, VertexId};
use std::cell::OnceCell;

/// Barycentric weights below this are zero: points given at a vertex or on an edge lie there.
const WEIGHT_ZERO: f64 = 1e-12;

/// Looks names up in a repaired surface.
pub(super) struct Lookup<'a> {
    soup: &'a FaceSoup,
    repaired: &'a Repaired,
    surface: &'a IntrinsicSurface<'a>,
    /// File units.
    snap: f64,
    closest: OnceCell<ClosestPoint>,
    /// Farthest that a point was moved, file units.
    pub moved: f64,
}

impl<'a> Lookup<'a> {
    pub fn new(
        soup: &'a FaceSoup,
        repaired: &'a Repaired,
        surface: &'a IntrinsicSurface<'a>,
        request: &DistanceRequest,
    ) -> Self {
        let snap = request.snap_rel * repaired.mesh.diagonal();
        Self { soup, repaired, surface, snap, closest: OnceCell::new(), moved: 0.0 }
    }

    fn mesh(&self) -> &'a TriMesh {
        &self.repaired.mesh
    }

    /// The sources of one name.
    ///
    /// # Errors     vertices that do not exist or are used by no face; points too far away; a surface without boundary
    /// or sharp edges where these are asked for; curves that leave their component
    pub fn sources(&mut self, named: &Named, label: u32, progress: &Progress) -> Result<Vec<Source>, RemeshError> {
        let mesh = self.mesh();
        let nothing = |why: &str| Err(RemeshError::Mismatch { what: "--from", why: why.to_string() });
        match named {
            Named::Vertices(list) => {
                let vertices = list.iter().map(|&v| self.vertex(v)).collect::<Result<Vec<_>, _>>()?;
                Ok(vertices.into_iter().map(|v| Source::vertex(v).with_label(label)).collect())
            }
            Named::Points(list) => {
                let points = list.iter().map(|p| self.point(p)).collect::<Result<Vec<_>, _>>()?;
                Ok(points.into_iter().map(|p| Source::point(p).with_label(label)).collect())
            }
            Named::Boundary => match boundary_sources(mesh, label) {
                none if none.is_empty() => nothing("the surface has no boundary; name vertices, points or curves"),
                all => Ok(all),
            },
            Named::Features(degrees) => {
                let sharp = |e: &EdgeId| dihedral_angle(mesh, mesh.half_edge(*e)).to_degrees() > *degrees;
                match edge_sources(mesh, mesh.edges().filter(sharp), label) {
                    none if none.is_empty() => {
                        nothing(&format!("no edge bends by more than {degrees} degrees; use a smaller angle"))
                    }
                    all => Ok(all),
                }
            }
            Named::Curves(curves) => {
                let mut tracer = CurveTracer::new(self.surface);
                let mut all = Vec::new();
                for curve in curves {
                    let points = curve.iter().map(|p| self.point(p)).collect::<Result<Vec<_>, _>>()?;
                    all.extend(tracer.join(&points, label, progress)?);
                }
                Ok(all)
            }
        }
    }

    /// The points of a name that paths are traced from.
    ///
    /// # Errors     as [`Self::sources`]; names that are no points
    pub fn points(&mut self, named: &Named) -> Result<Vec<SurfacePoint>, RemeshError> {
        match named {
            Named::Vertices(list) => list.iter().map(|&v| self.vertex(v).map(|v| at_vertex(self.mesh(), v))).collect(),
            Named::Points(list) => list.iter().map(|p| self.point(p)).collect(),
            _ => Err(RemeshError::Mismatch {
                what: "--path-from",
                why: "paths begin at points; name vertices:… or point:x,y,z".into(),
            }),
        }
    }

    fn vertex(&self, v: u32) -> Result<VertexId, RemeshError> {
        let wrong = |why: String| RemeshError::Mismatch { what: "a vertex", why };
        match self.repaired.vertex_of_input.get(v as usize) {
            None => {
                let count = self.repaired.vertex_of_input.len();
                Err(wrong(format!("there is no vertex {v}, the last one is {}; vertices count from 0", count - 1)))
            }
            Some(None) => Err(wrong(format!("vertex {v} is used by no face; name one of the surface"))),
            Some(Some(v)) => Ok(*v),
        }
    }

    fn point(&mut self, p: &CurvePoint) -> Result<SurfacePoint, RemeshError> {
        match *p {
            CurvePoint::Space(position) => {
                let closest = self.closest.get_or_init(|| ClosestPoint::new(&self.repaired.mesh)).query(position);
                if closest.distance > self.snap {
                    return Err(RemeshError::Mismatch {
                        what: "a point",
                        why: format!(
                            "({}, {}, {}) is {:.3e} away from the surface, more than --snap allows ({:.3e}); check its \
                             place and units",
                            position.x, position.y, position.z, closest.distance, self.snap
                        ),
                    });
                }
                self.moved = self.moved.max(closest.distance);
                Ok(cleaned(closest.point))
            }
            CurvePoint::OnFace { face, weights } => self.point_on_face(face, weights),
        }
    }

    /// A point on a face of the input.
    fn point_on_face(&mut self, face: u32, weights: [f64; 3]) -> Result<SurfacePoint, RemeshError> {
        let wrong = |why: String| RemeshError::Mismatch { what: "a point of a curve", why };
        let Some(corners) = self.soup.faces.get(face as usize) else {
            return Err(wrong(format!("there is no face {face}, the last one is {}", self.soup.faces.len() - 1)));
        };
        let &[a, b, c] = &corners[..] else {
            return Err(wrong(format!("face {face} has {} corners; weights need a triangle", corners.len())));
        };
        let sum: f64 = weights.iter().sum();
        if weights.iter().any(|&w| w < -1e-9) || (sum - 1.0).abs() > 1e-6 {
            return Err(wrong(format!("face {face}: weights {weights:?} are not in 0..=1 with a sum of 1")));
        }
        // 1. The same triangle of the repaired surface, whichever corner it begins with.
        let corners = [a, b, c].map(|v| self.repaired.vertex_of_input[v as usize]);
        if let [Some(a), Some(b), Some(c)] = corners {
            let same = self.mesh().outgoing(a).find_map(|h| {
                let f = self.mesh().face(h);
                let order = self.mesh().face_vertices(f).map(|v| [a, b, c].iter().position(|&u| u == v));
                let [Some(i), Some(j), Some(k)] = order else { return None };
                Some(SurfacePoint { face: f, weights: [i, j, k].map(|i| weights[i].max(0.0) / sum) })
            });
            if let Some(point) = same {
                return Ok(cleaned(point));
            }
        }
        // 2. A face that repair changed: by position.
        let position = [a, b, c].iter().zip(weights).map(|(&v, w)| self.soup.positions[v as usize] * w).sum();
        self.point(&CurvePoint::Space(position))
    }
}

/// A vertex as a point of a face.
pub(super) fn at_vertex(mesh: &TriMesh, v: VertexId) -> SurfacePoint {
    let h = mesh.outgoing_half_edge(v);
    let mut weights = [0.0; 3];
    weights[(h.0 % 3) as usize] = 1.0;
    SurfacePoint { face: mesh.face(h), weights }
}

/// The same point with weights that are all but zero at zero.
fn cleaned(p: SurfacePoint) -> SurfacePoint {
    let weights = p.weights.map(|w| if w < WEIGHT_ZERO { 0.0 } else { w });
    let sum: f64 = weights.iter().sum();
    SurfacePoint { face: p.face, weights: weights.map(|w| w / sum) }
}
