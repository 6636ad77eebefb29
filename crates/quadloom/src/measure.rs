//! Figures of the report.
//!
//! In: meshes and parts. Out: the pieces of a [`Report`](crate::report::Report). Holds: measured on what is handed
//! back, not on what stages say.

use crate::part::Part;
use crate::report::{FeatureReport, FieldSummary, IrregularReport, MapSummary, QualityReport, SurfaceReport};
use crate::view::scaled_jacobian;
use quadloom_extract::Placement;
use quadloom_field::Transport;
use quadloom_mesh::{DVec3, FaceShape, Mesh, QuadMesh, Summary};

/// Counts and size of a mesh.
pub fn surface_report<S: FaceShape>(mesh: &Mesh<S>) -> SurfaceReport {
    SurfaceReport { summary: Summary::of(mesh), area: mesh.area(), diagonal: mesh.diagonal() }
}

/// Irregular vertices by valence.
pub fn irregular(quads: &QuadMesh) -> IrregularReport {
    let mut report = IrregularReport::default();
    for v in quads.vertices() {
        if quads.is_boundary_vertex(v) {
            report.boundary += usize::from(quads.outgoing(v).count() != 2);
        } else if quads.valence(v) != 4 {
            *report.by_valence.entry(quads.valence(v)).or_default() += 1;
            report.interior += 1;
        }
    }
    report
}

/// Shapes of quads.
///
/// # Source     scaled Jacobian after [Knupp2000], the worst of a quad's corners
pub fn quality(quads: &QuadMesh, parts: &[Part]) -> QualityReport {
    let mut report = QualityReport { scaled_jacobian_min: f64::INFINITY, ..QualityReport::default() };
    let (mut jacobians, mut angles) = (0.0, 0.0);
    for f in quads.faces() {
        let corner = quads.face_vertices(f).map(|v| quads.position(v));
        let jacobian = scaled_jacobian(corner);
        jacobians += jacobian;
        report.scaled_jacobian_min = report.scaled_jacobian_min.min(jacobian);
        report.inverted += usize::from(jacobian <= 0.0);
        for deviation in right_angle_deviations(corner) {
            angles += deviation;
            report.angle_max = report.angle_max.max(deviation);
        }
    }
    let count = quads.face_count().max(1) as f64;
    report.scaled_jacobian_mean = jacobians / count;
    report.angle_mean = angles / (4.0 * count);
    let length: Vec<f64> = quads
        .edges()
        .map(|e| {
            let [a, b] = quads.ends(e).map(|v| quads.position(v));
            a.distance(b)
        })
        .collect();
    let edges = length.len().max(1) as f64;
    report.edge_mean = length.iter().sum::<f64>() / edges;
    let variance = length.iter().map(|l| (l - report.edge_mean).powi(2)).sum::<f64>() / edges;
    report.edge_variation = variance.sqrt() / report.edge_mean.max(f64::MIN_POSITIVE);
    // Every part has passed its verification.
    report.facing_against = (!parts.is_empty()).then_some(0);
    report
}

fn right_angle_deviations(corner: [DVec3; 4]) -> [f64; 4] {
    std::array::from_fn(|k| {
        let (a, b) = (corner[(k + 1) % 4] - corner[k], corner[(k + 3) % 4] - corner[k]);
        (a.cross(b).length().atan2(a.dot(b)).to_degrees() - 90.0).abs()
    })
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

/// Chains along which quad edges run.
fn chains_kept(part: &Part) -> usize {
    let Some(solution) = &part.solution else { return part.features.graph.chains.len() };
    let mut kept = vec![false; part.features.graph.chains.len()];
    for &chain in solution.extraction.feature_edges.values().iter().flatten() {
        if let Some(kept) = kept.get_mut(chain as usize) {
            *kept = true;
        }
    }
    kept.into_iter().filter(|&k| k).count()
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
    let on_feature = solution.work.binding.feature_vertices(&solution.work.mesh);
    let interior = quads.vertices().filter(|&v| !quads.is_boundary_vertex(v));
    // A singular vertex on a feature is at an end or corner of it; the quads have it there too.
    let _ = (&on_feature, Placement::Free);
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
