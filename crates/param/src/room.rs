//! Room around pinned vertices: every edge between two of them is split.
//!
//! In: a mesh, its features and a cross field. Out: a refinement and the field on it.
//! Holds: the surface is the same point set, chains and singularities are the same, old vertices keep their ids. Source:
//! [Bommes2012] §8.4 for features; singular vertices are pinned to integers as well, and a triangle at two of them can
//! be left without room between its neighbours, whichever integers they get.

use quadloom_field::{CrossField, Transport};
use quadloom_mesh::{EdgeId, FeatureGraph, MeshError, Refined, TriMesh, VertexMap, refine};

/// Splits the edges between pinned vertices: interior singular ones, and vertices of features.
///
/// # Input      features: those of the mesh, to be carried; binding: those that the map follows
/// # Output     `None` where there is no such edge
/// # Errors     [`MeshError`] if the result has more elements than ids
/// # Cost       linear
pub fn make_room(
    mesh: &TriMesh,
    features: &FeatureGraph,
    binding: &FeatureGraph,
    field: &CrossField,
) -> Result<Option<(Refined, CrossField)>, MeshError> {
    let on_feature = binding.feature_vertices(mesh);
    let mut singular = VertexMap::filled(mesh.vertex_count(), false);
    let at_singular = field.singularities(mesh, &Transport::of(mesh)).into_iter().map(|s| s.0);
    at_singular.filter(|&v| !mesh.is_boundary_vertex(v)).for_each(|v| singular[v] = true);
    let is_tight = |e: &EdgeId| !features.is_feature(*e) && mesh.ends(*e).iter().all(|&v| on_feature[v] || singular[v]);
    let split: Vec<(EdgeId, f64)> = mesh.edges().filter(is_tight).map(|e| (e, 0.5)).collect();
    if split.is_empty() {
        return Ok(None);
    }
    let refined = refine::split_edges(mesh, features, &split)?;
    let carried = field.carried_to(&refined, mesh);
    Ok(Some((refined, carried)))
}
