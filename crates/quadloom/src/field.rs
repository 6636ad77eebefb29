//! A cross field on the faces of a file.
//!
//! In: a [`FaceSoup`] that is a clean triangle mesh. Out: [`FileField`]: four directions per face, in the file's
//! order. Holds: fields belong to the faces of the file, so that a file that needs repair is refused.

use crate::error::RemeshError;
use crate::features::{FeatureRequest, find_features};
use crate::stages::{WorkMesh, cross_field};
use quadloom_field::Transport;
use quadloom_mesh::{DVec3, FaceSoup, Progress, TriMesh, VertexId};

/// What a field is to follow; vertices are numbers of the file.
#[derive(Clone, Debug, Default)]
pub struct FieldRequest {
    /// Dihedral angle from which an edge is followed, degrees; `None`: none is.
    pub sharp_angle: Option<f64>,
    /// Edges that are followed besides.
    pub features: Vec<[u32; 2]>,
    /// Prescribed singular vertices with their index in quarters.
    pub singularities: Vec<(u32, i32)>,
}

/// A field on the faces of a file.
#[derive(Clone, Debug)]
pub struct FileField {
    /// The directions of each face's cross, counter-clockwise, unit vectors.
    pub crosses: Vec<[DVec3; 4]>,
    /// Singular vertices with their index in quarters, ascending.
    pub singularities: Vec<(u32, i32)>,
    /// Smoothness energy ([Bommes2012] §8.2, Eq. (8.1)), radians squared.
    pub energy: f64,
}

/// Solves for a field.
///
/// # Errors     a file that is no clean triangle mesh; prescriptions without a field; cancellation
pub fn solve_field(soup: &FaceSoup, request: &FieldRequest, progress: &Progress) -> Result<FileField, RemeshError> {
    // 1. The file's own faces.
    let triangles: Option<Vec<[u32; 3]>> = soup.faces.iter().map(|f| f.as_slice().try_into().ok()).collect();
    let unfit = |why: String| RemeshError::Mismatch { what: "a field per face", why };
    let triangles = triangles.ok_or_else(|| unfit("there are faces with more than three corners".into()))?;
    let mesh = TriMesh::new(soup.positions.clone(), &triangles)
        .map_err(|e| unfit(format!("{e}; `quadloom check` lists all defects, `quadloom remesh` repairs them")))?;
    // 2. What it follows.
    let edges = request.features.iter().map(|e| e.map(VertexId)).collect();
    let wanted = FeatureRequest { sharp_angle: request.sharp_angle, edges, guides: Vec::new() };
    let features = find_features(&mesh, &wanted, 0.0).graph;
    let work = WorkMesh { mesh, binding: features.clone(), features };
    let singularities: Vec<(VertexId, i32)> = request.singularities.iter().map(|&(v, i)| (VertexId(v), i)).collect();
    // 3. The field.
    let (field, report) = cross_field(&work, 0.0, &singularities, progress)?;
    let mesh = &work.mesh;
    Ok(FileField {
        crosses: mesh.faces().map(|f| [0, 1, 2, 3].map(|d| field.direction(mesh, f, d))).collect(),
        singularities: field.singularities(mesh, &Transport::of(mesh)).iter().map(|&(v, i)| (v.0, i)).collect(),
        energy: report.energy,
    })
}
