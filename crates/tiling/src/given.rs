//! Tiles from a user's own cut edges ([Favreau2009] Lemma 1).
//!
//! In: a connected mesh and edges of it. Out: a [`Cutting`] along them, or the reason why what is left are no disks.
//! Holds: nothing is refined; the arcs are those of the edges given.

use crate::cost::EdgeCosts;
use crate::cutting::{Cut, CutKind, Cutting};
use crate::error::TilingError;
use crate::ids::ArcId;
use crate::tiling::{Tiling, unrefined};
use quadloom_mesh::{EdgeMap, Id, Progress, TriMesh};
use std::sync::Arc;

/// Cuts a mesh along given edges into disks.
///
/// # Input      cut: true for edges to cut along; border edges count as cut already
/// # Errors     [`TilingError::NotDisks`] names the first tile that is no disk; those of [`Cutting::new`]
/// # Cost       linear
pub fn cut_given<'a>(
    mesh: &'a TriMesh,
    costs: &'a EdgeCosts,
    cut: &EdgeMap<bool>,
    progress: &'a Progress,
) -> Result<Cutting<'a>, TilingError> {
    let mut cutting = Cutting::new(mesh, costs, progress)?;
    let tiling = Tiling::from_cut(Arc::new(unrefined(mesh)), cut, &[]);
    tiling.must_be_disks()?;
    for (arc, path) in (0..tiling.arc_path.len()).map(ArcId::new).map(|a| (a, &tiling.arc_path[a])) {
        if tiling.is_border(arc) {
            continue;
        }
        let half_edges: Option<Vec<u32>> =
            path.windows(2).map(|p| mesh.find_half_edge(p[0], p[1]).map(|h| h.0)).collect();
        let half_edges = half_edges.ok_or(TilingError::Fault { what: "an arc is broken" })?;
        let edge = |&h: &u32| costs.values()[mesh.edge(quadloom_mesh::HalfEdgeId(h))];
        let cost = half_edges.iter().map(edge).filter(|c| c.is_finite()).sum();
        cutting.surface.cut(&half_edges)?;
        cutting.cuts.push(Cut { kind: CutKind::Given, cost, points: path.iter().map(|v| v.0).collect() });
    }
    Ok(cutting)
}
