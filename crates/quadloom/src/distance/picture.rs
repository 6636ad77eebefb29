//! Distances as a picture.
//!
//! In: a [`DistanceResult`] of a request for a picture. Out: a [`Scene`] for [`crate::view::render_html`]: bands of
//! colour, lines, sources, paths, cut locus.

use super::fine::BANDS;
use super::{Curve, DistanceResult};
use crate::view::{DistanceLayer, Polyline, Scene, SurfaceLayer, boundary_lines};

/// Everything that was measured.
pub fn scene(result: &DistanceResult, title: &str) -> Scene {
    let report = &result.report;
    let (mesh, distance) = match &result.fine {
        Some(fine) => (&fine.mesh, &fine.distance),
        None => (&result.mesh, &result.distance),
    };
    let lines = |curves: &[Curve]| -> Vec<Polyline> {
        curves.iter().map(|c| Polyline { points: c.points.clone(), closed: false }).collect()
    };
    // Bands end where lines are, if these are evenly spaced and not too many.
    let values: Vec<f64> = result.isolines.iter().map(|l| l.value).collect();
    let spacing = values.first().copied().filter(|&s| s > 0.0 && report.largest_distance / s <= 200.0);
    let band = spacing.unwrap_or(report.largest_distance / BANDS as f64);
    let number = |x: f64| format!("{x:.6}");
    let mut statistics = vec![
        ("triangles".to_string(), report.faces.to_string()),
        ("vertices".to_string(), report.vertices.to_string()),
        ("largest distance".to_string(), number(report.largest_distance)),
    ];
    if report.unreached > 0 {
        statistics.push(("vertices not reached".into(), report.unreached.to_string()));
    }
    for (k, source) in report.sources.iter().enumerate() {
        statistics.push((format!("source {k}: {}", source.from), format!("nearest of {} vertices", source.vertices)));
    }
    if let Some(windows) = report.windows_per_edge {
        statistics.push(("windows per edge".into(), format!("{windows:.2}")));
    }
    if report.epsilon > 0.0 {
        statistics.push(("relative error allowed".into(), report.epsilon.to_string()));
    }
    if mesh.face_count() != report.faces {
        statistics.push(("triangles drawn".into(), mesh.face_count().to_string()));
    }
    for (k, length) in report.path_lengths.iter().enumerate() {
        statistics.push((format!("path {k}"), length.map_or("none".into(), number)));
    }
    statistics.push(("wavefront".into(), format!("{:.3} s", report.seconds.wavefront)));
    Scene {
        title: title.into(),
        input: Some(SurfaceLayer::of(mesh)),
        boundary: boundary_lines(mesh),
        distance: Some(DistanceLayer {
            values: distance.values().to_vec(),
            band,
            isolines: lines(&result.isolines),
            paths: lines(&result.paths),
            sources: lines(&result.source_curves),
            cut_locus: lines(&result.cut_locus),
        }),
        statistics,
        ..Scene::default()
    }
}
