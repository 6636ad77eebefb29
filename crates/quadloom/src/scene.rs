//! A result as a picture.
//!
//! In: a [`RemeshResult`], or a mesh. Out: a [`Scene`] for [`crate::view::render_html`].

use crate::part::{Part, Solution};
use crate::remesh::RemeshResult;
use crate::view::{
    Polyline, QuadLayer, Scene, SurfaceLayer, boundary_lines, crosses, feature_lines, irregular_vertices, isolines,
    quad_histograms, seams,
};
use quadloom_extract::IrregularVertices;
use quadloom_mesh::repair::split_components;
use quadloom_mesh::{QuadMesh, Summary, TriMesh};

/// Crosses that a page shows, over all components: more are not told apart.
const CROSSES: usize = 6000;

/// Everything that a run made.
pub fn of_result(result: &RemeshResult, title: &str) -> Scene {
    let report = &result.report;
    let area = result.input.area();
    // 1. What is to be seen without any map.
    let edge = (area / report.count.asked.max(1) as f64).sqrt();
    let mut scene = of_quads(&result.quads, Some(&result.input), Some(edge), title);
    scene.features = feature_curves(result);
    // 2. Field and map.
    for Solution { work, field, map, .. } in result.parts.iter().filter_map(|p| p.solution.as_ref()) {
        let (mesh, map) = (&work.mesh, &map.parametrization.map);
        let share = (CROSSES as f64 * mesh.area() / area) as usize;
        scene.seams.extend(seams(mesh, map));
        scene.crosses.extend(crosses(mesh, &field.angle, share));
        let lines = isolines(mesh, map);
        scene.uv_isolines.u.extend(lines.u);
        scene.uv_isolines.v.extend(lines.v);
        scene.uv_isolines.skipped_faces.extend(lines.skipped_faces);
    }
    // 3. The table.
    let mut rows = vec![("asked quads".into(), report.count.asked.to_string())];
    rows.extend(std::mem::take(&mut scene.statistics));
    let mut row = |name: &str, value: String| rows.push((name.to_string(), value));
    row("feature curves", format!("{} of {}", report.features.chains_kept, report.features.chains));
    row("map solves", report.map.solves.to_string());
    let split = result.parts.iter().filter(|p| p.solution.is_none()).count();
    if split > 0 {
        row("components of split triangles", format!("{split} of {}", result.parts.len()));
    }
    let skipped = scene.uv_isolines.skipped_faces.len();
    if skipped > 0 {
        row("triangles without map lines", format!("{skipped} (too many lines)"));
    }
    for (stage, seconds) in report.seconds.iter() {
        row(stage, format!("{seconds:.2} s"));
    }
    rows.push(("all stages, wall clock".into(), format!("{:.2} s", report.total_seconds)));
    scene.statistics = rows;
    scene
}

/// The curves of the input, also of components that have no map.
fn feature_curves(result: &RemeshResult) -> Vec<Polyline> {
    let lines = |mesh: &TriMesh, part: &Part| feature_lines(mesh, &part.features.graph);
    match &result.parts[..] {
        [part] => lines(&result.input, part),
        parts => {
            // Parts are in the order of the components; a mesh that was one can always be taken apart.
            let components = split_components(&result.input).unwrap_or_default();
            components.iter().zip(parts).flat_map(|(component, part)| lines(&component.mesh, part)).collect()
        }
    }
}

/// Quads, with the surface that they stand for and the edge length that was aimed at, file units.
pub fn of_quads(quads: &QuadMesh, reference: Option<&TriMesh>, target_edge: Option<f64>, title: &str) -> Scene {
    let summary = Summary::of(quads);
    let irregular = IrregularVertices::of(quads);
    let by_valence = |v: usize| irregular.by_valence.get(&v).copied().unwrap_or(0);
    let statistics = [
        ("quads", summary.faces.to_string()),
        ("vertices", summary.vertices.to_string()),
        ("Euler characteristic", summary.chi.to_string()),
        ("components", summary.components.to_string()),
        ("boundary loops", summary.boundary_loops.to_string()),
        ("irregular vertices", irregular.interior.to_string()),
        ("of valence 3 / 5", format!("{} / {}", by_valence(3), by_valence(5))),
    ];
    Scene {
        title: title.into(),
        input: reference.map(SurfaceLayer::of),
        quads: Some(QuadLayer::of(quads)),
        singularities: irregular_vertices(quads),
        boundary: reference.map(boundary_lines).unwrap_or_default(),
        statistics: statistics.map(|(name, value)| (name.to_string(), value)).to_vec(),
        histograms: quad_histograms(quads, target_edge),
        ..Scene::default()
    }
}

/// A triangle mesh alone.
pub fn of_triangles(mesh: &TriMesh, title: &str) -> Scene {
    let summary = Summary::of(mesh);
    let statistics = [
        ("triangles", summary.faces),
        ("vertices", summary.vertices),
        ("components", summary.components),
        ("boundary loops", summary.boundary_loops),
    ];
    Scene {
        title: title.into(),
        input: Some(SurfaceLayer::of(mesh)),
        boundary: boundary_lines(mesh),
        statistics: statistics.map(|(name, value)| (name.to_string(), value.to_string())).to_vec(),
        ..Scene::default()
    }
}
