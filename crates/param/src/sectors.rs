//! Cross fields without collapsed sectors: between two features that meet, at least one quarter turn.
//!
//! In: a mesh, its features, constraints of a cross field. Out: a field and its report.
//! Holds: as few sectors as possible are left in which the map would have to fold; those are still found by
//! [`Charts::collapsed_sectors`](crate::Charts). Source: [Bommes2012] §8.2, moving a singularity by changing a period
//! jump, used where two feature edges meet at less than 45°: the smoothest field gives such a sector no quarter turn,
//! hence no quad.

use crate::charts::{Sector, sectors};
use quadloom_field::{
    CrossField, FieldConstraints, FieldError, FieldOptions, FieldReport, Transport, solve_cross_field,
};
use quadloom_mesh::{EdgeId, EdgeMap, FeatureGraph, HalfEdgeId, Progress, TriConnectivity};

/// Solves again at most this often; each time every sector that is still collapsed gets a quarter turn more.
const ROUNDS: u32 = 4;

/// The smoothest cross field that leaves room for a quad between any two features that meet.
///
/// # Errors     those of the cross field
/// # Cost       one solve, and one more per round in which a sector is collapsed
/// # Guarantees none where a user's prescription stands against it, or where a sector is a single triangle
pub fn solve_open_field(
    mesh: &TriConnectivity,
    transport: &Transport,
    length: &EdgeMap<f64>,
    features: &FeatureGraph,
    constraints: &FieldConstraints,
    options: &FieldOptions,
    progress: &Progress,
) -> Result<(CrossField, FieldReport), FieldError> {
    let given: Vec<_> = constraints.indices.iter().map(|i| i.0).collect();
    let on_feature = features.feature_vertices(mesh);
    let clear_of = mesh.vertices().filter(|&v| on_feature[v]).collect();
    let mut options = FieldOptions { clear_of, ..options.clone() };
    let mut field = solve_cross_field(mesh, transport, length, constraints, &options, progress)?;
    let closed = |field: &CrossField| -> Vec<Sector> {
        let mut all = sectors(mesh, length, transport, features, field);
        all.retain(|s| s.quarters <= 0);
        all
    };
    let mut collapsed = closed(&field.0);
    let (mut best, mut fewest) = (field.clone(), collapsed.len());
    for _ in 0..ROUNDS {
        collapsed.retain(|s| !given.contains(&s.vertex) && !s.inside.is_empty());
        if collapsed.is_empty() {
            break;
        }
        // A quarter of index leaves the vertex through an edge of the sector, and none may come back that way.
        let mut opened = field.0.clone();
        for sector in &collapsed {
            let Some((e, amount)) = opening(mesh, transport, &opened, &sector.inside) else { continue };
            opened.period_jump[e] += amount;
            options.kept.extend(sector.inside.iter().map(|&h| mesh.edge(h)));
        }
        options.start_from = Some(opened.period_jump);
        field = solve_cross_field(mesh, transport, length, constraints, &options, progress)?;
        collapsed = closed(&field.0);
        if collapsed.len() < fewest {
            (best, fewest) = (field.clone(), collapsed.len());
        }
    }
    Ok(best)
}

/// The change of one period jump that gives a sector a quarter turn more and leaves the least turn on its edge.
///
/// # Input      inside: half-edges from the vertex, strictly inside the sector
fn opening(
    mesh: &TriConnectivity,
    transport: &Transport,
    field: &CrossField,
    inside: &[HalfEdgeId],
) -> Option<(EdgeId, i32)> {
    // A sector loses the turns met when it is walked counter-clockwise, those over the twins of its half-edges; a turn
    // falls by a quarter where the jump rises.
    let turn =
        |h: HalfEdgeId| mesh.twin(h).map(|t| (field.turn(mesh, transport, t), mesh.half_edge(mesh.edge(h)) == t));
    let most =
        inside.iter().filter_map(|&h| Some((h, turn(h)?))).max_by(|a, b| a.1.0.total_cmp(&b.1.0).then(b.0.cmp(&a.0)));
    most.map(|(h, (_, is_canonical))| (mesh.edge(h), if is_canonical { 1 } else { -1 }))
}
