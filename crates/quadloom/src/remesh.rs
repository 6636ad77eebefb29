//! A surface becomes quads: repair, components, parts, reunion, verification, report.
//!
//! In: a [`FaceSoup`] or a mesh, and [`RemeshOptions`]. Out: [`RemeshResult`] with a [`Report`].
//! Holds: pure quads, manifold, oriented, same topology as the repaired input, none inverted, none facing against
//! it; the same bytes for any number of threads. Not: the count, if a warning says so.
//! Source: [Bommes2012] ch. 6 and 8.

use crate::components::{join, shares};
use crate::error::{RemeshError, Warning, WarningCode};
use crate::features::FeatureRequest;
use crate::guides::is_at_one_vertex;
use crate::input::check_extent;
use crate::inspect::{as_read, topology_warning};
use crate::ladder::attempts_of_piece;
use crate::measure::{
    distances, feature_report, field_summary, kept_chains, map_summary, relocation_summary, surface_report,
};
use crate::memory;
use crate::options::{AUTO_QUADS_MAX, AUTO_QUADS_MIN, Elements, Fallback, MOST_QUADS, RemeshOptions, Target};
use crate::part::{Part, PartRequest, remesh_part};
use crate::report::{ComponentReport, CountReport, REPORT_VERSION, Report, Seconds, Units};
use crate::singularities::{SingularityRequest, check_list, singularity_summary, singularity_warnings};
use crate::sizes::SizeRequest;
use crate::stages::no_result;
use crate::ties::{TieRequest, tie_reports, tie_warnings};
use quadloom_extract::{IrregularVertices, QuadQuality};
use quadloom_mesh::repair::{Component, FindingKind, RepairError, RepairOptions, Repaired, repair, split_components};
use quadloom_mesh::{
    ClosestPoint, DVec3, FaceMap, FaceSoup, FeatureKind, Progress, QuadMesh, TriMesh, VertexId, VertexMap, metric,
};
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
    // 4. What was measured.
    progress.report("report", 0.0);
    let count = count_report(asked, quads.face_count(), options);
    if count.error_percent.abs() > count.tolerance_percent {
        warnings.push(count_warning(&count, &parts));
    }
    warnings.extend(feature_warnings(&parts, options));
    let singularities = singularity_summary(&requests, &parts);
    warnings.extend(singularities.iter().flat_map(|s| singularity_warnings(s, options.other_singularities)));
    let ties = tie_reports(&requests, &parts);
    warnings.extend(tie_warnings(&ties));
    if options.relocate && options.field.is_some() {
        let message = "singular vertices of a given field stay where they are; --relocate was ignored";
        warnings.push(Warning::new(WarningCode::Ignored, message));
    }
    let (quality, irregular) =
        seconds.time("report", || (QuadQuality::of(&quads).summary(), IrregularVertices::of(&quads)));
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
        facing_against: 0,
        distance: distances(&parts, mesh),
        components: component_reports(&components, &share, &parts),
        total_seconds: (begin.elapsed().as_secs_f64() * 1e3).round() / 1e3,
        seconds,
        peak_memory_bytes: memory::peak_bytes(),
        warnings,
    };
    Ok(RemeshResult { quads, input: mesh.clone(), parts, report })
}

/// What is asked of each component; what fits no component is an error or a warning.
fn requests<'a>(
    soup: &FaceSoup,
    repaired: &Repaired,
    components: &'a [Component],
    share: &[usize],
    options: &RemeshOptions,
    warnings: &mut Vec<Warning>,
) -> Result<Vec<PartRequest<'a>>, RemeshError> {
    // Where each vertex of the repaired mesh is among the components.
    let mut place = VertexMap::filled(repaired.mesh.vertex_count(), (0usize, VertexId(0)));
    for (i, component) in components.iter().enumerate() {
        for (v, &whole) in component.vertex_of.iter() {
            place[whole] = (i, v);
        }
    }
    let find = |id: u32| Some(place[(*repaired.vertex_of_input.get(id as usize)?)?]);
    let mut requests: Vec<PartRequest> = components
        .iter()
        .zip(share)
        .map(|(component, &quads)| PartRequest {
            mesh: &component.mesh,
            quads,
            features: FeatureRequest { sharp_angle: options.sharp_angle, ..FeatureRequest::default() },
            field: None,
            sizes: SizeRequest {
                adaptivity: options.adaptivity,
                adapt_to: options.adapt_to,
                anisotropy: options.anisotropy,
                curl_correction: options.curl_correction,
                density: None,
            },
            singularities: Vec::new(),
            ties: Vec::new(),
            attempts: match options.fallback {
                Fallback::Split if components.len() > 1 => attempts_of_piece(quads),
                _ => usize::MAX,
            },
        })
        .collect();
    // 1. Named edges.
    let mut missing = Vec::new();
    for &named in &options.features {
        match named.map(find) {
            [Some((i, a)), Some((j, b))] if i == j && components[i].mesh.find_edge(a, b).is_some() => {
                requests[i].features.edges.push([a, b]);
            }
            _ => missing.push(named),
        }
    }
    warnings.extend(missing_edges_warning(&missing));
    // 2. Singular vertices.
    for &(asked, quarters) in options.singularities.iter().flatten() {
        let (i, vertex) = find(asked)
            .ok_or_else(|| RemeshError::Mismatch { what: "the list of singularities", why: no_vertex(soup, asked) })?;
        requests[i].singularities.push(SingularityRequest { asked, vertex, quarters, named: true });
    }
    if options.singularities.as_ref().is_some_and(Vec::is_empty) && !options.other_singularities {
        for (request, component) in requests.iter_mut().zip(components) {
            request.singularities.extend(SingularityRequest::of_no_vertex(&component.mesh));
        }
    }
    for request in &requests {
        check_list(request.mesh, &request.singularities, options.other_singularities)?;
    }
    // 3. Ties.
    for &asked in &options.ties {
        let [a, b] = asked.map(find);
        match (a, b) {
            (Some((i, a)), Some((j, b))) if i == j && a == b => {
                let why = format!(
                    "--tie {},{}: both are one point of the surface; name two different ones",
                    asked[0], asked[1]
                );
                return Err(RemeshError::Mismatch { what: "a tie", why });
            }
            (Some((i, a)), Some((j, b))) if i == j => {
                requests[i].ties.push(TieRequest { asked, vertices: [a, b] });
            }
            (Some((i, _)), Some((j, _))) => {
                let why = format!(
                    "--tie {},{}: its ends are on components {} and {} of the surface, and no chain of quad edges \
                     leads from one to another; name two vertices of one component",
                    asked[0],
                    asked[1],
                    i + 1,
                    j + 1
                );
                return Err(RemeshError::Mismatch { what: "a tie", why });
            }
            (a, _) => {
                let lacking = asked[usize::from(a.is_some())];
                let why = format!("--tie {},{}: {}", asked[0], asked[1], no_vertex(soup, lacking));
                return Err(RemeshError::Mismatch { what: "a tie", why });
            }
        }
    }
    // 4. Curves go to the component that their first point is nearest to.
    let mut points = Vec::new();
    for (k, guide) in options.guides.iter().enumerate() {
        if let Some(i) = nearest_component(&repaired.mesh, &place, guide) {
            requests[i].features.guides.push(guide.clone());
            points.extend(is_at_one_vertex(&components[i].mesh, guide).then_some(k));
        }
    }
    let far = far_guides(&repaired.mesh, &options.guides);
    warnings.extend(far_guides_warning(&repaired.mesh, options.guides.len(), &far));
    points.retain(|k| far.iter().all(|f| f.0 != *k));
    warnings.extend(short_guides_warning(options.guides.len(), &points));
    // 5. Density.
    if let Some(name) = &options.density {
        let value = density(soup, name)?;
        let mut whole = VertexMap::filled(repaired.mesh.vertex_count(), 0.0);
        for (i, v) in repaired.vertex_of_input.iter().enumerate() {
            if let Some(v) = *v {
                whole[v] = value.get(i).copied().unwrap_or(0.0);
            }
        }
        for (request, component) in requests.iter_mut().zip(components) {
            request.sizes.density = Some(component.vertex_of.map(|&v| whole[v]));
        }
    }
    // 6. The given field.
    if let Some(field) = &options.field {
        if field.directions.len() != soup.faces.len() {
            let why = format!("it has {} vectors, the input {} faces", field.directions.len(), soup.faces.len());
            return Err(RemeshError::Mismatch { what: "the cross field", why });
        }
        for (request, component) in requests.iter_mut().zip(components) {
            let direction = |f| field.directions[repaired.input_face[component.face_of[f]] as usize];
            request.field = Some(FaceMap::from_fn(component.mesh.face_count(), direction));
        }
    }
    Ok(requests)
}

/// The values of a vertex attribute of the file.
fn density<'a>(soup: &'a FaceSoup, name: &str) -> Result<&'a [f64], RemeshError> {
    let found = soup.vertex_attributes.iter().find(|(n, _)| n == name);
    found.map(|(_, values)| values.as_slice()).ok_or_else(|| {
        let names: Vec<String> = soup.vertex_attributes.iter().map(|(n, _)| format!("`{n}`")).collect();
        let there = match &names[..] {
            [] => "it has no attributes at all (OBJ and STL cannot have any)".into(),
            _ => format!("it has {}", names.join(", ")),
        };
        let why = format!("there is no vertex attribute `{name}` (colours are none); {there}");
        RemeshError::Mismatch { what: "--density", why }
    })
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

/// A warning about named edges that the mesh does not have, by the vertices of the file.
pub(crate) fn missing_edges_warning(missing: &[[u32; 2]]) -> Option<Warning> {
    let &[a, b] = missing.first()?;
    let message = format!(
        "{} feature edges are not edges of the mesh and are not kept (first: vertices {a} and {b}); an edge is named by its \
         two ends",
        missing.len()
    );
    let elements = Elements::Vertices(missing.as_flattened().to_vec());
    Some(Warning::new(WarningCode::FeatureMissed, message).at(elements))
}

/// Distance of a drawn curve from the surface, relative to the surface's diagonal, from which it counts as far.
///
/// Curves drawn with few points leave a surface by a hundredth; those in other units or places are nowhere near.
const FAR_GUIDE_REL: f64 = 0.05;

/// Drawn curves that are somewhere else, each with its farthest point and that one's distance.
fn far_guides(mesh: &TriMesh, guides: &[Vec<DVec3>]) -> Vec<(usize, (usize, f64))> {
    if guides.is_empty() {
        return Vec::new();
    }
    let tree = ClosestPoint::new(mesh);
    let limit = FAR_GUIDE_REL * mesh.diagonal();
    let farthest = |guide: &Vec<DVec3>| {
        let distances = guide.iter().map(|&p| tree.query(p).distance).enumerate();
        distances.fold((0, 0.0), |far: (usize, f64), near| if near.1 > far.1 { near } else { far })
    };
    let all = guides.iter().map(farthest).enumerate();
    all.filter(|(_, (_, distance))| *distance > limit).collect()
}

/// A warning about drawn curves that are somewhere else; they are traced all the same, along what is nearest.
fn far_guides_warning(mesh: &TriMesh, guides: usize, far: &[(usize, (usize, f64))]) -> Option<Warning> {
    let &(curve, (point, distance)) = far.first()?;
    let message = format!(
        "{} of {guides} drawn curves (--guides) are far from the surface, and at best the edges nearest to them are \
         followed (first: point {} of curve {} is {distance:.3e} away, the surface has a diagonal of {:.3e}); check \
         their units and place",
        far.len(),
        point + 1,
        curve + 1,
        mesh.diagonal()
    );
    Some(Warning::new(WarningCode::GuideFar, message))
}

/// A warning about drawn curves without an edge along them.
fn short_guides_warning(guides: usize, short: &[usize]) -> Option<Warning> {
    let first = short.first()?;
    let message = format!(
        "{} of {guides} drawn curves (--guides) are shorter than the triangles under them, and nothing follows them (first: \
         curve {}); draw longer ones, or refine the surface there",
        short.len(),
        first + 1
    );
    Some(Warning::new(WarningCode::FeatureMissed, message))
}

/// Says that a vertex is not there, and what is.
fn no_vertex(soup: &FaceSoup, asked: u32) -> String {
    match soup.positions.len() {
        count if (asked as usize) < count => {
            format!("vertex {asked} of the input is on no face that is left after repair; name one of a face")
        }
        count => format!(
            "there is no vertex {asked}: the input has {count}, numbered from 0 to {}; name one of those",
            count.saturating_sub(1)
        ),
    }
}

fn nearest_component(mesh: &TriMesh, place: &VertexMap<(usize, VertexId)>, guide: &[DVec3]) -> Option<usize> {
    let &first = guide.first()?;
    let distance = |v: &VertexId| mesh.position(*v).distance_squared(first);
    mesh.vertices().min_by(|a, b| distance(a).total_cmp(&distance(b))).map(|v| place[v].0)
}

fn repair_warnings(repaired: &Repaired) -> Vec<Warning> {
    repaired
        .report
        .findings()
        .map(|finding| {
            let elements = match finding.kind {
                FindingKind::WeldedVertex
                | FindingKind::NonManifoldVertex
                | FindingKind::UnusedVertex
                | FindingKind::TJunction => Elements::Vertices(finding.first.clone()),
                _ => Elements::Faces(finding.first.clone()),
            };
            Warning::new(WarningCode::Repaired, finding.to_string()).at(elements)
        })
        .collect()
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

fn of_component(warning: Warning, i: u32) -> Warning {
    let message = format!("component {}: {}", i + 1, warning.message);
    let elements = match warning.elements {
        Elements::None => Elements::Components(vec![i]),
        other => other,
    };
    Warning { message, elements, ..warning }
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

fn count_warning(count: &CountReport, parts: &[Part]) -> Warning {
    let creased = parts.iter().any(|p| p.features.graph.edge_count() > 0);
    let why = if parts.iter().any(|p| p.solution.is_none()) {
        "split triangles cannot have any number; ask for more quads"
    } else if count.reached > count.asked && creased {
        "features and singular vertices need more; ask for more quads, or keep fewer edges (--sharp-angle)"
    } else if count.reached > count.asked {
        "singular vertices and handles need more; ask for more quads"
    } else {
        "no map without folds was found nearer to it; ask for another number"
    };
    let of = format!("({:+.1} %, tolerance {} %)", count.error_percent, count.tolerance_percent);
    if count.explicit {
        let message = format!("{} quads instead of {} {of}: {why}", count.reached, count.asked);
        return Warning::new(WarningCode::CountMissed, message);
    }
    let message = format!("{} quads were made where {} were aimed at {of}: {why}", count.reached, count.asked);
    Warning::new(WarningCode::DefaultCountMissed, message)
}

fn feature_warnings(parts: &[Part], options: &RemeshOptions) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let dropped = parts.iter().map(|p| p.features.dropped_edges).sum::<usize>();
    if dropped > 0 {
        let message = format!(
            "{dropped} sharp edges in pieces that are short, or no sharper than the surface around them, were not kept"
        );
        warnings.push(Warning::new(WarningCode::LooseFeaturesDropped, message));
    }
    // Boundaries that are to be free are not lost.
    let wanted = |kind: FeatureKind| options.keep_boundary || kind != FeatureKind::Boundary;
    let lost_of = |part: &Part| {
        let chains = part.features.graph.chains.iter().zip(kept_chains(part));
        chains.filter(|(chain, kept)| !kept && wanted(chain.kind)).count()
    };
    let lost = parts.iter().map(lost_of).sum::<usize>();
    if lost > 0 {
        let message = format!("{lost} feature curves have no quad edge along them");
        // What nobody asked for is not missed.
        let named = !options.features.is_empty() || !options.guides.is_empty();
        let code = if named { WarningCode::FeatureMissed } else { WarningCode::FeatureLost };
        warnings.push(Warning::new(code, message));
    }
    warnings
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
