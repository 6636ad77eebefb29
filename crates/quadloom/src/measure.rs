//! Figures of the report.
//!
//! In: meshes and parts. Out: the pieces of a [`Report`](crate::report::Report). Holds: measured on what is handed
//! back, not on what stages say.

use crate::part::Part;
use crate::report::{FeatureReport, FieldSummary, MapSummary, SurfaceReport};
use quadloom_extract::{Deviation, Distances};
use quadloom_field::Transport;
use quadloom_mesh::{FaceShape, Mesh, Summary, TriMesh};
use quadloom_param::RelocationReport;

/// Counts and size of a mesh.
pub fn surface_report<S: FaceShape>(mesh: &Mesh<S>) -> SurfaceReport {
    SurfaceReport { summary: Summary::of(mesh), area: mesh.area(), diagonal: mesh.diagonal() }
}

/// Distances over all parts, percent of the whole's diagonal; means are weighted by area.
pub fn distances(parts: &[Part], input: &TriMesh) -> Distances {
    let whole = input.diagonal();
    let measured: Vec<(Distances, f64, f64)> =
        parts.iter().map(|p| (p.distances, p.diagonal / whole, p.area / input.area())).collect();
    let joined = |pick: &dyn Fn(&Distances) -> Option<Deviation>| {
        let mut total = 0.0;
        let mut all = Deviation::default();
        for (distances, scale, weight) in &measured {
            if let Some(deviation) = pick(distances) {
                total += weight;
                all.mean += weight * scale * deviation.mean;
                all.max = all.max.max(scale * deviation.max);
            }
        }
        (total > 0.0).then(|| Deviation { mean: all.mean / total, max: all.max })
    };
    Distances {
        to_reference: joined(&|d| Some(d.to_reference)).unwrap_or_default(),
        from_reference: joined(&|d| Some(d.from_reference)).unwrap_or_default(),
        feature: joined(&|d| d.feature),
        boundary: joined(&|d| d.boundary),
    }
}

/// Feature curves over all parts.
pub fn feature_report(parts: &[Part]) -> FeatureReport {
    let mut report = FeatureReport::default();
    for part in parts {
        let graph = &part.features.graph;
        report.chains += graph.chains.len();
        report.edges += graph.edge_count();
        report.corners += graph.is_corner.values().iter().filter(|&&c| c).count();
        report.dropped_edges += part.features.dropped_edges;
        report.chains_kept += chains_kept(part);
    }
    report
}

/// Number of chains along which quad edges run.
pub fn chains_kept(part: &Part) -> usize {
    kept_chains(part).into_iter().filter(|&k| k).count()
}

/// Whether quad edges run along each chain.
pub fn kept_chains(part: &Part) -> Vec<bool> {
    let chains = part.features.graph.chains.len();
    let Some(solution) = &part.solution else { return vec![true; chains] };
    let mut kept = vec![false; chains];
    for &chain in solution.extraction.feature_edges.values().iter().flatten() {
        if let Some(kept) = kept.get_mut(chain as usize) {
            *kept = true;
        }
    }
    kept
}

/// The cross fields of all parts.
pub fn field_summary(parts: &[Part], given: bool) -> FieldSummary {
    let mut summary = FieldSummary::default();
    let (mut of_field, mut kept) = (0, true);
    for part in parts {
        let Some(solution) = &part.solution else {
            kept = false;
            continue;
        };
        summary.energy += solution.energy;
        let mesh = &solution.work.mesh;
        let singular = solution.field.singularities(mesh, &Transport::of(mesh));
        of_field += singular.len();
        for &(_, index) in &singular {
            *summary.by_index.entry(index).or_default() += 1;
        }
        if given {
            kept &= same_indices(&singular.iter().map(|s| s.1).collect::<Vec<_>>(), solution);
        }
    }
    if given {
        summary.given_singularities = Some(of_field);
        summary.singularities_kept = Some(kept);
    }
    summary
}

/// Whether the free irregular vertices of the quads are as many of each index as the field has.
fn same_indices(field: &[i32], solution: &crate::part::Solution) -> bool {
    let quads = &solution.extraction.mesh;
    let interior = quads.vertices().filter(|&v| !quads.is_boundary_vertex(v));
    let mut found: Vec<i32> = interior.map(|v| 4 - quads.valence(v) as i32).filter(|&i| i != 0).collect();
    let mut wanted = field.to_vec();
    found.sort_unstable();
    wanted.sort_unstable();
    found == wanted
}

/// The maps of all parts.
pub fn map_summary(parts: &[Part]) -> MapSummary {
    let mut summary = MapSummary::default();
    for part in parts {
        summary.solves += part.solves;
        if let Some(solution) = &part.solution {
            summary.triangles += solution.work.mesh.face_count();
            summary.flips += solution.map.parametrization.inverted.len();
        }
    }
    summary
}

/// Relocation over all parts that had one.
pub fn relocation_summary(parts: &[Part]) -> Option<RelocationReport> {
    let mut all = parts.iter().filter_map(|p| p.solution.as_ref()?.relocation.as_ref());
    let first = all.next()?.clone();
    Some(all.fold(first, |sum, part| RelocationReport {
        tried: sum.tried + part.tried,
        kept: sum.kept + part.kept,
        energy: [0, 1].map(|k| sum.energy[k] + part.energy[k]),
        inverted: [0, 1].map(|k| sum.inverted[k] + part.inverted[k]),
    }))
}
