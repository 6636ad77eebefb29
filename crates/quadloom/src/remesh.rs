//! A surface becomes quads: repair, components, parts, reunion, verification, report.
//!
//! In: a [`FaceSoup`] or a mesh, and [`RemeshOptions`]. Out: [`RemeshResult`] with a [`Report`].
//! Holds: pure quads, manifold, oriented, same topology as the repaired input, none inverted, none facing against
//! it; the same bytes for any number of threads. Not: the count, if a warning says so.
//! Source: [Bommes2012] ch. 6 and 8.

use crate::components::{join, shares};
use crate::error::{RemeshError, Warning, WarningCode};
use crate::input::check_extent;
use crate::inspect::{as_read, topology_warning};
use crate::measure::{distances, feature_report, field_summary, map_summary, relocation_summary, surface_report};
use crate::memory;
use crate::options::{AUTO_QUADS_MAX, AUTO_QUADS_MIN, Elements, MOST_QUADS, RemeshOptions, Target};
use crate::part::{Part, remesh_part};
use crate::report::{ComponentReport, CountReport, REPORT_VERSION, Report, Seconds, Units};
use crate::requests::requests;
use crate::singularities::{singularity_summary, singularity_warnings};
use crate::stages::no_result;
use crate::ties::{tie_reports, tie_warnings};
use crate::verify::Verification;
use crate::warnings::{count_warning, detail_warning, feature_warnings, of_component, repair_warnings};
use quadloom_extract::{IrregularVertices, QuadQuality};
use quadloom_mesh::repair::{Component, RepairError, RepairOptions, Repaired, repair, split_components};
use quadloom_mesh::{FaceId, FaceMap, FaceSoup, Progress, QuadMesh, TriMesh, metric};
use rayon::prelude::*;
use std::time::Instant;

/// The quads and everything known about them.
#[derive(Clone, Debug)]
pub struct RemeshResult {
    /// The quads.
    pub quads: QuadMesh,
    /// The repaired input.
    pub input: TriMesh,
    /// How each component was made, in the order of the components.
    pub parts: Vec<Part>,
    /// Everything measured.
    pub report: Report,
}

/// Makes a pure-quad mesh of what a file says.
///
/// # Input      positions in file units; ids in the options are those of the soup
/// # Errors     [`RemeshError`]; its kind tells the command's exit code
/// # Cost       near-linear in triangles and quads; about 10 seconds for 200,000 triangles
/// # Guarantees what the module says; warnings in the report say what was missed
pub fn remesh(soup: &FaceSoup, options: &RemeshOptions, progress: &Progress) -> Result<RemeshResult, RemeshError> {
    let begin = Instant::now();
    options.check()?;
    check_extent(soup)?;
    let mut seconds = Seconds::default();
    progress.report("repair", 0.0);
    let repaired = seconds.time("repair", || repair(soup, &RepairOptions::default()))?;
    progress.check()?;
    remesh_repaired(soup, &repaired, options, (begin, seconds), progress)
}

/// Makes a pure-quad mesh of a triangle mesh.
///
/// As [`remesh`], without a repair.
pub fn remesh_mesh(mesh: &TriMesh, options: &RemeshOptions, progress: &Progress) -> Result<RemeshResult, RemeshError> {
    let begin = Instant::now();
    options.check()?;
    let soup = FaceSoup {
        positions: mesh.positions().values().to_vec(),
        faces: mesh.to_faces().iter().map(|f| f.to_vec()).collect(),
        ..FaceSoup::default()
    };
    check_extent(&soup)?;
    let repaired = Repaired {
        mesh: mesh.clone(),
        vertex_of_input: mesh.vertices().map(Some).collect(),
        input_face: FaceMap::from_fn(mesh.face_count(), |f| f.0),
        report: Default::default(),
    };
    remesh_repaired(&soup, &repaired, options, (begin, Seconds::default()), progress)
}

/// Number of quads that the options ask of a mesh.
pub fn target_count(mesh: &TriMesh, target: Target) -> usize {
    let of_length = |length: f64| ((mesh.area() / (length * length)).round() as usize).max(1);
    match target {
        Target::Auto => (mesh.face_count() / 4).clamp(AUTO_QUADS_MIN, AUTO_QUADS_MAX),
        Target::Quads(n) => n,
        Target::EdgeLength(length) => of_length(length),
        Target::Scale(scale) => {
            let edges = metric::edge_lengths(mesh);
            of_length(scale * edges.values().iter().sum::<f64>() / edges.len().max(1) as f64)
        }
    }
}

fn remesh_repaired(
    soup: &FaceSoup,
    repaired: &Repaired,
    options: &RemeshOptions,
    (begin, mut seconds): (Instant, Seconds),
    progress: &Progress,
) -> Result<RemeshResult, RemeshError> {
    let mesh = &repaired.mesh;
    let mut warnings = repair_warnings(repaired);
    let read = as_read(soup, repaired);
    warnings.extend(topology_warning(&read, repaired));
    // 1. Components and their shares.
    let components = split_components(mesh).map_err(|e| no_result("components", e))?;
    check_area(soup, repaired, &components)?;
    let asked = target_count(mesh, options.target);
    if asked > MOST_QUADS {
        return Err(RemeshError::TooMany { asked: asked as f64, most: MOST_QUADS });
    }
    let share = shares(&components, asked);
    let requests = requests(soup, repaired, &components, &share, options, &mut warnings)?;
    // 2. Each component by itself.
    let parts: Vec<Part> = requests
        .par_iter()
        .enumerate()
        .map(|(i, request)| {
            let part = remesh_part(request, options, progress);
            part.map_err(|e| at_component(e, i as u32, components.len(), request.mesh.face_count()))
        })
        .collect::<Vec<_>>()
        .into_iter()
        .collect::<Result<_, _>>()?;
    // 3. One mesh again.
    let quads = join(&parts.iter().map(|p| &p.quads).collect::<Vec<_>>()).map_err(|e| no_result("join", e))?;
    for (i, part) in parts.iter().enumerate() {
        seconds.absorb(&part.seconds);
        let named = part.warnings.iter().cloned().map(|w| if parts.len() > 1 { of_component(w, i as u32) } else { w });
        warnings.extend(named);
    }
    warnings.extend(feature_warnings(&parts, options));
    if options.relocate && options.field.is_some() {
        let message = "singular vertices of a given field stay where they are; --relocate was ignored";
        warnings.push(Warning::new(WarningCode::Ignored, message));
    }
    // 4. What was measured.
    progress.report("report", 0.0);
    let count = count_report(asked, quads.face_count(), options);
    if count.error_percent.abs() > count.tolerance_percent {
        warnings.push(count_warning(&count, &parts));
    }
    let singularities = singularity_summary(&requests, &parts);
    warnings.extend(singularities.iter().flat_map(|s| singularity_warnings(s, options.other_singularities)));
    let ties = tie_reports(&requests, &parts);
    warnings.extend(tie_warnings(&ties));
    let distance = distances(&parts, mesh);
    warnings.extend(detail_warning(&distance, &quads, mesh.diagonal()));
    let (quality, irregular) =
        seconds.time("report", || (QuadQuality::of(&quads).summary(), IrregularVertices::of(&quads)));
    let quads_of = |list: fn(&Verification) -> &[FaceId]| parts.iter().map(|p| list(&p.verification).len()).sum();
    let report = Report {
        report_version: REPORT_VERSION,
        quadloom: env!("CARGO_PKG_VERSION"),
        units: Units::OF_REPORT,
        input_as_read: read,
        input: surface_report(mesh),
        repairs: repaired.report.findings().map(ToString::to_string).collect(),
        output: surface_report(&quads),
        irregular,
        count,
        features: feature_report(&parts),
        field: field_summary(&parts, options.field.is_some()),
        map: map_summary(&parts),
        singularities,
        ties,
        relocation: relocation_summary(&parts),
        quality,
        facing_against: quads_of(|v| &v.against),
        facing_unclear: quads_of(|v| &v.unclear),
        distance,
        components: component_reports(&components, &share, &parts),
        total_seconds: (begin.elapsed().as_secs_f64() * 1e3).round() / 1e3,
        seconds,
        peak_memory_bytes: memory::peak_bytes(),
        warnings,
    };
    Ok(RemeshResult { quads, input: mesh.clone(), parts, report })
}

/// Area of a piece, relative to the square of its diagonal, up to which it counts as none.
///
/// The flattest triangles that repair keeps have 1e-7, tubes as thin as hair on a house 1e-6.
const LEAST_AREA_REL: f64 = 1e-10;

/// Whether a mesh is more than a line.
pub(crate) fn has_area(mesh: &TriMesh) -> bool {
    mesh.area() > LEAST_AREA_REL * mesh.diagonal().powi(2)
}

/// Refuses pieces without area: nothing can be laid out on them.
fn check_area(soup: &FaceSoup, repaired: &Repaired, components: &[Component]) -> Result<(), RemeshError> {
    let without: Vec<&Component> = components.iter().filter(|c| !has_area(&c.mesh)).collect();
    match without[..] {
        [] => Ok(()),
        [..] if without.len() == components.len() => Err(RepairError::NothingLeft { faces: soup.faces.len() }.into()),
        [piece, ..] => {
            let faces = piece.mesh.face_count();
            let first = piece.face_of.values().first().map_or(0, |&f| repaired.input_face[f]);
            Err(RemeshError::NoArea { faces, first })
        }
    }
}

fn at_component(error: RemeshError, i: u32, count: usize, triangles: usize) -> RemeshError {
    match error {
        RemeshError::NoResult { stage, why, .. } if count > 1 => RemeshError::NoResult {
            stage,
            why: format!("component {} of {count} ({triangles} triangles): {why}", i + 1),
            elements: Elements::Components(vec![i]),
        },
        other => other,
    }
}

fn count_report(asked: usize, reached: usize, options: &RemeshOptions) -> CountReport {
    CountReport {
        asked,
        explicit: options.target != Target::Auto,
        reached,
        error_percent: 100.0 * (reached as f64 - asked as f64) / asked as f64,
        tolerance_percent: 100.0 * options.tolerance,
    }
}

fn component_reports(components: &[Component], share: &[usize], parts: &[Part]) -> Vec<ComponentReport> {
    let made_by = |part: &Part| if part.solution.is_some() { "integer-grid map" } else { "split triangles" };
    components
        .iter()
        .zip(share)
        .zip(parts)
        .map(|((component, &asked), part)| ComponentReport {
            triangles: component.mesh.face_count(),
            asked,
            reached: part.quads.face_count(),
            attempt: part.attempt,
            made_by: made_by(part),
        })
        .collect()
}
