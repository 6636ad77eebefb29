//! Cross fields without collapsed sectors: between two features that meet, at least one quarter turn.
//!
//! In: a mesh, its features, constraints of a cross field. Out: a field and its report.
//! Holds: as few sectors as possible are left in which the map would have to fold; those are still found by
//! [`Charts::collapsed_sectors`](crate::Charts). Source: [Bommes2012] §8.6, prescribed indices, used where two
//! feature edges meet at less than 45°: the smoothest field gives such a sector no quarter turn, hence no quad.

use crate::charts::collapsed_sectors;
use quadloom_field::{
    CrossField, FieldConstraints, FieldError, FieldOptions, FieldReport, Transport, solve_cross_field,
};
use quadloom_mesh::{EdgeMap, FeatureGraph, Progress, TriConnectivity};

/// Solves again at most this often; each time every sector that is still collapsed gets a quarter turn more.
const ROUNDS: u32 = 4;

/// The smoothest cross field that leaves room for a quad between any two features that meet.
///
/// # Errors     those of the cross field
/// # Cost       one solve, and one more per round in which a sector is collapsed
/// # Guarantees none where a user's prescription stands against it, or at boundary vertices
pub fn solve_open_field(
    mesh: &TriConnectivity,
    transport: &Transport,
    length: &EdgeMap<f64>,
    features: &FeatureGraph,
    constraints: &FieldConstraints,
    options: &FieldOptions,
    progress: &Progress,
) -> Result<(CrossField, FieldReport), FieldError> {
    let mut constraints = constraints.clone();
    let given: Vec<_> = constraints.indices.iter().map(|i| i.0).collect();
    let on_feature = features.feature_vertices(mesh);
    let clear_of = mesh.vertices().filter(|&v| on_feature[v]).collect();
    let options = &FieldOptions { clear_of, ..options.clone() };
    let mut field = solve_cross_field(mesh, transport, length, &constraints, options, progress)?;
    let mut collapsed = collapsed_sectors(mesh, length, transport, features, &field.0);
    let (mut best, mut fewest) = (field.clone(), collapsed.len());
    for _ in 0..ROUNDS {
        collapsed.retain(|v| !mesh.is_boundary_vertex(*v) && !given.contains(v));
        if collapsed.is_empty() {
            break;
        }
        for &v in &collapsed {
            let wanted = field.0.index(mesh, transport, v) - 1;
            constraints.indices.retain(|i| i.0 != v);
            constraints.indices.push((v, wanted));
        }
        let Ok(next) = solve_cross_field(mesh, transport, length, &constraints, options, progress) else { break };
        field = next;
        collapsed = collapsed_sectors(mesh, length, transport, features, &field.0);
        if collapsed.len() < fewest {
            (best, fewest) = (field.clone(), collapsed.len());
        }
    }
    Ok(best)
}
