//! A cross field on the faces of a file.
//!
//! In: a [`FaceSoup`] that is a clean triangle mesh. Out: [`FileField`]: four directions per face, in the file's
//! order. Holds: fields belong to the faces of the file, so that a file that needs repair is refused.

use crate::error::{RemeshError, Warning};
use crate::features::{FeatureRequest, find_features};
use crate::input::check_extent;
use crate::remesh::has_area;
use crate::singularities::{SingularityRequest, check_list, others_warning};
use crate::stages::{Prescribed, WorkMesh, cross_field};
use crate::warnings::missing_edges_warning;
use quadloom_field::Transport;
use quadloom_mesh::repair::{RepairError, RepairOptions, repair, split_components};
use quadloom_mesh::{DVec3, FaceSoup, Progress, TriMesh, VertexId};
use std::collections::BTreeMap;

/// What a field is to follow; vertices are numbers of the file.
#[derive(Clone, Debug, Default)]
pub struct FieldRequest {
    /// Dihedral angle from which an edge is followed, degrees; `None`: none is.
    pub sharp_angle: Option<f64>,
    /// Edges that are followed besides.
    pub features: Vec<[u32; 2]>,
    /// Prescribed singular vertices with their index in quarters; an empty list asks for none, `None` leaves it open.
    pub singularities: Option<Vec<(u32, i32)>>,
    /// Whether other vertices may be singular besides.
    pub other_singularities: bool,
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
    /// What should be known.
    pub warnings: Vec<Warning>,
}

/// Solves for a field.
///
/// # Errors     a file that is no clean triangle mesh; prescriptions without a field; cancellation
pub fn solve_field(soup: &FaceSoup, request: &FieldRequest, progress: &Progress) -> Result<FileField, RemeshError> {
    check_extent(soup)?;
    // 1. The file's own faces.
    let triangles: Option<Vec<[u32; 3]>> = soup.faces.iter().map(|f| f.as_slice().try_into().ok()).collect();
    let unfit = |why: String| RemeshError::Mismatch { what: "a field per face", why };
    let triangles = triangles.ok_or_else(|| unfit("there are faces with more than three corners".into()))?;
    let mesh = TriMesh::new(soup.positions.clone(), &triangles).map_err(|e| {
        // No repair is promised that does not exist.
        unfit(match repair(soup, &RepairOptions::default()) {
            Ok(_) => format!("{e}; `quadloom check` lists all defects, `quadloom remesh` repairs them"),
            Err(obstacle) => format!("{e}, and no repair helps: {obstacle}"),
        })
    })?;
    if !has_area(&mesh) {
        return Err(RepairError::NothingLeft { faces: mesh.face_count() }.into());
    }
    let is_whole = check_singularities(&mesh, request)?;
    // 2. What it follows.
    let edges: Vec<[VertexId; 2]> = request.features.iter().map(|e| e.map(VertexId)).collect();
    let missing: Vec<[u32; 2]> =
        edges.iter().filter(|[a, b]| mesh.find_edge(*a, *b).is_none()).map(|e| e.map(|v| v.0)).collect();
    let wanted = FeatureRequest { sharp_angle: request.sharp_angle, edges, guides: Vec::new() };
    let features = find_features(&mesh, &wanted, 0.0).graph;
    let work = WorkMesh { mesh, binding: features.clone(), features };
    let listed = request.singularities.iter().flatten();
    let singularities: Vec<(VertexId, i32)> = listed.map(|&(v, i)| (VertexId(v), i)).collect();
    // 3. The field.
    let only = is_whole && !request.other_singularities;
    let (field, report) = cross_field(&work, 0.0, Prescribed { at: &singularities, only }, progress)?;
    let mesh = &work.mesh;
    let singular = field.singularities(mesh, &Transport::of(mesh));
    // Given ones are singular by construction; those of index 0 are not.
    let given = singularities.iter().filter(|s| s.1 != 0).count();
    let others = if only { singular.len().saturating_sub(given) } else { 0 };
    Ok(FileField {
        crosses: mesh.faces().map(|f| [0, 1, 2, 3].map(|d| field.direction(mesh, f, d))).collect(),
        singularities: singular.iter().map(|&(v, i)| (v.0, i)).collect(),
        energy: report.energy,
        warnings: missing_edges_warning(&missing).into_iter().chain(others_warning(others)).collect(),
    })
}

/// Refuses lists that no field has, component by component; says whether every component has given vertices.
fn check_singularities(mesh: &TriMesh, request: &FieldRequest) -> Result<bool, RemeshError> {
    let Some(listed) = &request.singularities else { return Ok(false) };
    let unfit = |why: String| RemeshError::Mismatch { what: "the list of singularities", why };
    let mut quarters: BTreeMap<VertexId, Vec<i32>> = BTreeMap::new();
    for &(v, index) in listed {
        if v as usize >= mesh.vertex_count() {
            let count = mesh.vertex_count();
            let last = count.saturating_sub(1);
            return Err(unfit(format!(
                "there is no vertex {v}: the input has {count}, numbered from 0 to {last}; name one of those"
            )));
        }
        quarters.entry(VertexId(v)).or_default().push(index);
    }
    let mut everywhere = true;
    for component in split_components(mesh).map_err(|e| unfit(e.to_string()))? {
        let mut list = Vec::new();
        for (vertex, whole) in component.vertex_of.iter() {
            let given = quarters.get(whole).into_iter().flatten();
            list.extend(given.map(|&quarters| SingularityRequest { asked: whole.0, vertex, quarters, named: true }));
        }
        if listed.is_empty() {
            list.extend(SingularityRequest::of_no_vertex(&component.mesh));
        }
        check_list(&component.mesh, &list, request.other_singularities)?;
        everywhere &= !list.is_empty();
    }
    Ok(everywhere)
}
