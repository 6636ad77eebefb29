//! Meshes as fine as lines and pictures of a distance field need.
//!
//! In: a field, what was asked for. Out: [`Fine`]. Holds: the same surface; a tolerance that a user gave is met or a
//! warning says so; one that only lines and pictures ask for may be cut short by the number of faces.
//! Source: [Bommes2012] §9, adaptive refinement.

use super::request::{DistanceRequest, Lines};
use crate::error::RemeshError;
use quadloom_geodesic::{Field, RefineOptions};
use quadloom_mesh::repair::Repaired;
use quadloom_mesh::{Progress, TriMesh, VertexMap};
use serde::Serialize;

/// A refined mesh with its field.
#[derive(Clone, Debug)]
pub struct Fine {
    /// Vertices of the surface keep their numbers.
    pub mesh: TriMesh,
    /// Distance of every vertex, file units.
    pub distance: VertexMap<f64>,
    /// Number of the nearest source.
    pub source: VertexMap<Option<u32>>,
    /// What was done, where a user asked for it; only then the mesh is written.
    pub report: Option<RefinementReport>,
}

/// A refinement in numbers; lengths in file units.
#[derive(Clone, Debug, Serialize)]
pub struct RefinementReport {
    /// Largest difference between field and linear interpolant along an edge that was asked for.
    pub tolerance: f64,
    /// Whether it was met.
    #[serde(rename = "reached")]
    pub is_reached: bool,
    /// Faces of the surface.
    pub faces_before: usize,
    /// Faces of the refined mesh.
    pub faces: usize,
    /// Its vertices.
    pub vertices: usize,
    /// Largest difference along an edge of the surface.
    pub largest_error_before: f64,
    /// Largest difference along an edge of the refined mesh.
    pub largest_error: f64,
    /// Smallest angle of the surface's triangles, degrees.
    pub smallest_angle_before: f64,
    /// Smallest angle of triangles with a new vertex, degrees; none where there is none.
    pub new_smallest_angle: Option<f64>,
    /// Rounds.
    pub steps: usize,
}

/// Bands of colour in a picture without lines.
pub(super) const BANDS: usize = 24;
/// Error that lines and pictures allow, relative to the distance from one line or band to the next.
const LINE_REL: f64 = 0.05;
/// Most faces that are made for lines and pictures: as many times the surface's, and as many more.
const LINE_FACES: (usize, usize) = (3, 50_000);

impl Fine {
    /// Refines the surface if that is asked for, or if lines or pictures need it.
    pub(super) fn of(
        repaired: &Repaired,
        field: &Field,
        request: &DistanceRequest,
        largest: f64,
        progress: &Progress,
    ) -> Result<Option<Self>, RemeshError> {
        let mesh = &repaired.mesh;
        let options = match (request.refine, request.isolines) {
            (Some(tolerance), _) => RefineOptions::within(tolerance),
            (None, lines) if lines.is_some() || request.picture => {
                let step = match lines {
                    Some(Lines::Spacing(spacing)) => spacing.min(largest),
                    Some(Lines::Count(count)) => largest / (count + 1) as f64,
                    None => largest / BANDS as f64,
                };
                let most_faces = LINE_FACES.0 * mesh.face_count() + LINE_FACES.1;
                RefineOptions { most_faces, ..RefineOptions::within(LINE_REL * step) }
            }
            _ => return Ok(None),
        };
        if largest <= 0.0 && request.refine.is_none() {
            // Nothing is farther than the sources.
            return Ok(None);
        }
        let refined = field.refine(&options, progress)?;
        let report = request.refine.map(|tolerance| RefinementReport {
            tolerance,
            is_reached: refined.is_reached,
            faces_before: mesh.face_count(),
            faces: refined.connectivity.face_count(),
            vertices: refined.connectivity.vertex_count(),
            largest_error_before: refined.error_before,
            largest_error: refined.error,
            smallest_angle_before: refined.smallest_old_angle,
            new_smallest_angle: refined.smallest_new_angle.is_finite().then_some(refined.smallest_new_angle),
            steps: refined.steps,
        });
        let old = mesh.vertex_count();
        let positions = VertexMap::from_fn(refined.points.len(), |v| {
            if v.index() < old { mesh.position(v) } else { refined.points[v].position(mesh) }
        });
        let mesh = TriMesh::from_parts(refined.connectivity, positions).expect("means of finite positions are finite");
        Ok(Some(Self { mesh, distance: refined.distance, source: refined.label, report }))
    }
}
