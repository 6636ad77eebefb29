//! Exact geodesic distance on a surface, from what a user names.
//!
//! In: a soup, a [`DistanceRequest`]. Out: [`DistanceResult`]: distances and nearest sources of vertices, lines of equal
//! distance, shortest paths, a report. Holds: what [`quadloom_geodesic`] holds; vertices keep the numbers of the input,
//! those that no face uses are kept and are not reached. Source: [Bommes2012] §9.

mod fine;
mod output;
mod picture;
pub mod request;
mod sources;

pub use fine::{Fine, RefinementReport};
pub use output::{EXPECTED, stage_distances, stage_lines, stage_lines_svg};
pub use picture::scene;
pub use request::{DistanceRequest, From, Lines};

use crate::error::{RemeshError, Warning, WarningCode};
use quadloom_geodesic::{
    Counts, CutLocus, Field, IntrinsicSurface, Isoline, Keep, Options, Source, SourceShape, Wavefront, isolines, spaced,
};
use quadloom_mesh::metric::edge_lengths;
use quadloom_mesh::repair::{RepairOptions, repair};
use quadloom_mesh::{DVec3, FaceSoup, Progress, SurfacePoint, TriMesh, VertexId, VertexMap};
use request::Named;
use serde::Serialize;
use sources::Lookup;
use std::time::Instant;

/// Distances of a surface's vertices, and what was asked for besides.
#[derive(Clone, Debug)]
pub struct DistanceResult {
    /// The repaired surface.
    pub mesh: TriMesh,
    /// Vertex of the surface for each vertex of the input; `None` if no face uses it.
    pub vertex_of_input: Vec<Option<VertexId>>,
    /// Distance of every vertex of the surface, file units; infinity where no source reaches.
    pub distance: VertexMap<f64>,
    /// Number of the nearest source.
    pub source: VertexMap<Option<u32>>,
    /// A mesh on which the field is nearly linear, where one was asked for or lines and pictures need it.
    pub fine: Option<Fine>,
    /// Lines of equal distance.
    pub isolines: Vec<Curve>,
    /// Shortest paths, one per point asked for; without points where no source reaches.
    pub paths: Vec<Curve>,
    /// Sources as points and segments, each with its number; only for pictures.
    pub source_curves: Vec<Curve>,
    /// Where shortest paths of different directions meet, as segments; only for pictures.
    pub cut_locus: Vec<Curve>,
    /// What was done and measured.
    pub report: DistanceReport,
    /// What a user should know.
    pub warnings: Vec<Warning>,
}

/// A polyline in space.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Its points, file units; a closed one repeats its first point.
    pub points: Vec<DVec3>,
    /// A line's distance, a path's length, file units; a source's number.
    pub value: f64,
    /// Normal of a face beside each point.
    pub normals: Vec<DVec3>,
}

/// What was done and measured; lengths in file units.
#[derive(Clone, Debug, Serialize)]
pub struct DistanceReport {
    /// Faces and vertices of the surface, vertices of the input.
    pub faces: usize,
    /// Vertices of the surface.
    pub vertices: usize,
    /// Vertices of the input, also unused ones.
    pub input_vertices: usize,
    /// The sources, in order.
    pub sources: Vec<SourceReport>,
    /// Relative error that was allowed.
    pub epsilon: f64,
    /// Largest distance of a vertex that is reached.
    pub largest_distance: f64,
    /// Vertices of the surface that no source reaches.
    pub unreached: usize,
    /// Farthest that a point was moved to lie on the surface.
    pub snapped: f64,
    /// What the wavefront did.
    pub counts: Counts,
    /// Windows that were kept, and per edge; none where only vertices were asked for.
    pub windows: Option<usize>,
    /// The same per edge.
    pub windows_per_edge: Option<f64>,
    /// The mesh that was made finer, where that was asked for.
    pub refinement: Option<RefinementReport>,
    /// Lines of equal distance.
    pub isolines: usize,
    /// Lengths of the paths asked for; `None` where no source reaches.
    pub path_lengths: Vec<Option<f64>>,
    /// Where the time went.
    pub seconds: Seconds,
    /// Largest resident memory of the process so far, bytes; none where the system does not tell.
    pub peak_memory_bytes: Option<u64>,
}

/// One `--from`.
#[derive(Clone, Debug, Serialize)]
pub struct SourceReport {
    /// As it was named.
    pub from: String,
    /// Points, vertices and segments that it became.
    pub pieces: usize,
    /// Distance with which it starts.
    pub start: f64,
    /// Vertices to which it is nearest.
    pub vertices: usize,
}

/// Where the time went.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Seconds {
    /// Soup to surface.
    pub repair: f64,
    /// Names to sources.
    pub sources: f64,
    /// The wavefront.
    pub wavefront: f64,
    /// Lines, paths.
    pub queries: f64,
}

/// Measures distances on a surface.
///
/// # Input      a soup, as a file says it; what is asked for
/// # Errors     more start values than sources; a soup that is no surface; names that are not on it; a stop
/// # Cost       that of [`Wavefront::spread`]; without lines, paths and pictures only windows of the wavefront's
/// surroundings are in memory
/// # Guarantees deterministic; exact up to rounding with ε = 0
pub fn measure_distances(
    soup: &FaceSoup,
    request: &DistanceRequest,
    progress: &Progress,
) -> Result<DistanceResult, RemeshError> {
    if let Some(&value) = request.start.get(request.from.len()) {
        return Err(RemeshError::Option {
            option: "start",
            value,
            allowed: "one number for each --from, in their order,",
        });
    }
    let mut seconds = Seconds::default();
    let mut clock = Clock(Instant::now());
    let named = request.from.iter().map(Named::read).collect::<Result<Vec<_>, _>>()?;
    let named_paths = request.path_from.iter().map(Named::read).collect::<Result<Vec<_>, _>>()?;
    // 1. The surface. Needles and slivers stay: distances are exact on them.
    progress.report("repair", 0.0);
    crate::input::check_extent(soup)?;
    let repaired = repair(soup, &RepairOptions { zero_area_rel: 0.0, ..RepairOptions::default() })?;
    let mesh = &repaired.mesh;
    let lengths = edge_lengths(mesh);
    let surface = IntrinsicSurface::new(mesh, &lengths)?;
    seconds.repair = clock.lap();
    // 2. Sources.
    progress.report("sources", 0.0);
    let mut lookup = Lookup::new(soup, &repaired, &surface, request);
    let mut sources: Vec<Source> = Vec::new();
    let mut source_reports = Vec::new();
    for (k, (from, named)) in request.from.iter().zip(&named).enumerate() {
        let start = request.start.get(k).copied().unwrap_or(0.0);
        let pieces = lookup.sources(named, k as u32, progress)?;
        source_reports.push(SourceReport { from: from.to_string(), pieces: pieces.len(), start, vertices: 0 });
        sources.extend(pieces.into_iter().map(|piece| piece.with_start(start)));
    }
    let mut path_points = Vec::new();
    for named in &named_paths {
        path_points.extend(lookup.points(named)?);
    }
    let snapped = lookup.moved;
    seconds.sources = clock.lap();
    // 3. The wavefront.
    let needs_windows =
        !path_points.is_empty() || request.picture || request.refine.is_some() || request.isolines.is_some();
    let keep = if needs_windows { Keep::Windows } else { Keep::Vertices };
    let mut wave = Wavefront::new(&surface);
    wave.spread(&sources, &Options { epsilon: request.epsilon, keep, ..Options::default() }, progress)?;
    seconds.wavefront = clock.lap();
    // 4. What was asked for.
    progress.report("queries", 0.0);
    let field = wave.field();
    let (distance, source) = (field.vertex_distances(), field.vertex_labels());
    let largest_distance = distance.values().iter().copied().filter(|d| d.is_finite()).fold(0.0, f64::max);
    let fine = Fine::of(&repaired, &field, request, largest_distance, progress)?;
    let (line_mesh, line_distance) = fine.as_ref().map_or((mesh, &distance), |fine| (&fine.mesh, &fine.distance));
    let lines = lines_of(line_mesh, line_distance, request.isolines, largest_distance)?;
    let paths = path_points.iter().map(|p| path_of(mesh, &field, p)).collect::<Result<Vec<_>, _>>()?;
    let (mut source_curves, mut cut_locus) = (Vec::new(), Vec::new());
    if request.picture {
        source_curves = curves_of_sources(mesh, &sources);
        cut_locus = curves_of_cut_locus(mesh, &field.cut_locus(CUT_LOCUS_JUMP)?);
    }
    source.values().iter().flatten().for_each(|&k| source_reports[k as usize].vertices += 1);
    let unreached = distance.values().iter().filter(|d| d.is_infinite()).count();
    let windows = needs_windows.then(|| field.window_count());
    seconds.queries = clock.lap();
    let report = DistanceReport {
        faces: mesh.face_count(),
        vertices: mesh.vertex_count(),
        input_vertices: soup.positions.len(),
        sources: source_reports,
        epsilon: request.epsilon,
        largest_distance,
        unreached,
        snapped,
        counts: field.counts(),
        windows,
        windows_per_edge: windows.map(|w| w as f64 / mesh.edge_count() as f64),
        refinement: fine.as_ref().and_then(|fine| fine.report.clone()),
        isolines: lines.len(),
        path_lengths: paths.iter().map(|p| (!p.points.is_empty()).then_some(p.value)).collect(),
        seconds,
        peak_memory_bytes: crate::memory::peak_bytes(),
    };
    let warnings = warnings_of(&report, &repaired.report);
    Ok(DistanceResult {
        vertex_of_input: repaired.vertex_of_input,
        mesh: repaired.mesh,
        distance,
        source,
        fine,
        isolines: lines,
        paths,
        source_curves,
        cut_locus,
        report,
        warnings,
    })
}

/// Seconds since the last lap.
struct Clock(Instant);

impl Clock {
    fn lap(&mut self) -> f64 {
        let now = Instant::now();
        (now - std::mem::replace(&mut self.0, now)).as_secs_f64()
    }
}

/// What a user should know.
fn warnings_of(report: &DistanceReport, repair: &quadloom_mesh::repair::RepairReport) -> Vec<Warning> {
    let mut warnings = Vec::new();
    for finding in repair.findings() {
        warnings.push(Warning::new(WarningCode::Repaired, format!("the input was repaired: {finding}")));
    }
    if report.unreached > 0 {
        let message = format!(
            "{} of {} vertices are on pieces of the surface without a source; their distance is infinite",
            report.unreached, report.vertices
        );
        warnings.push(Warning::new(WarningCode::Unreached, message));
    }
    let lost = report.path_lengths.iter().filter(|l| l.is_none()).count();
    if lost > 0 {
        let message =
            format!("{lost} of {} paths begin where no source reaches (--path-from)", report.path_lengths.len());
        warnings.push(Warning::new(WarningCode::PathMissed, message));
    }
    if let Some(refinement) = report.refinement.as_ref().filter(|r| !r.is_reached) {
        let message = format!(
            "refinement stopped at an error of {:.3e} with {} faces, --refine asked for {:.3e}; use a larger tolerance",
            refinement.largest_error, refinement.faces, refinement.tolerance
        );
        warnings.push(Warning::new(WarningCode::RefinementMissed, message));
    }
    warnings
}

fn lines_of(
    mesh: &TriMesh,
    distance: &VertexMap<f64>,
    lines: Option<Lines>,
    largest: f64,
) -> Result<Vec<Curve>, RemeshError> {
    let Some(lines) = lines else { return Ok(Vec::new()) };
    let values = match lines {
        Lines::Spacing(spacing) => spaced(distance, spacing)?,
        Lines::Count(count) => (1..=count).map(|k| largest * k as f64 / (count + 1) as f64).collect(),
    };
    Ok(isolines(mesh, distance, &values).iter().map(|line| curve_of_line(mesh, line)).collect())
}

fn curve_of_line(mesh: &TriMesh, line: &Isoline) -> Curve {
    let mut points: Vec<DVec3> = Vec::with_capacity(line.points.len() + 1);
    let mut normals = Vec::with_capacity(line.points.len() + 1);
    let closing = line.points.first().filter(|_| line.is_closed);
    for &(e, t) in line.points.iter().chain(closing) {
        let [a, b] = mesh.ends(e).map(|v| mesh.position(v));
        points.push(a.lerp(b, t));
        normals.push(mesh.face_normal(mesh.edge_faces(e).0));
    }
    Curve { points, value: line.value, normals }
}

fn path_of(mesh: &TriMesh, field: &Field, p: &SurfacePoint) -> Result<Curve, RemeshError> {
    let path = field.path_from(p)?;
    let points = path.as_ref().map_or(&[][..], |path| &path.points);
    Ok(Curve {
        points: points.iter().map(|p| p.position(mesh)).collect(),
        value: path.as_ref().map_or(f64::INFINITY, |path| path.length),
        normals: points.iter().map(|p| mesh.face_normal(p.face)).collect(),
    })
}

/// Least difference of cosines at which a ridge is drawn: less is what a mesh's own facets make.
const CUT_LOCUS_JUMP: f64 = 0.2;

fn curves_of_cut_locus(mesh: &TriMesh, locus: &CutLocus) -> Vec<Curve> {
    let place = |k: usize| {
        let p = &locus.points[k];
        let [a, b] = mesh.ends(p.edge).map(|v| mesh.position(v));
        (a.lerp(b, p.at), mesh.face_normal(mesh.edge_faces(p.edge).0))
    };
    let curve = |&[j, k]: &[usize; 2]| {
        let ((p, m), (q, n)) = (place(j), place(k));
        Curve { points: vec![p, q], value: locus.points[j].distance, normals: vec![m, n] }
    };
    locus.segments.iter().map(curve).collect()
}

fn curves_of_sources(mesh: &TriMesh, sources: &[Source]) -> Vec<Curve> {
    let curve = |source: &Source| {
        let points = match source.shape {
            SourceShape::Vertex(v) => vec![sources::at_vertex(mesh, v)],
            SourceShape::Point(p) => vec![p],
            SourceShape::Segment(p, q) => vec![p, q],
        };
        Curve {
            points: points.iter().map(|p| p.position(mesh)).collect(),
            value: f64::from(source.label),
            normals: points.iter().map(|p| mesh.face_normal(p.face)).collect(),
        }
    };
    sources.iter().map(curve).collect()
}
