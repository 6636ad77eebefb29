//! Cutting a surface into tiles, from what a user names.
//!
//! In: a soup, a [`TileRequest`]. Out: [`TileResult`]: per component a tiling that passed its check, with the tilings
//! before it where they are wanted, words, and a report. Holds: what [`quadloom_tiling`] holds; a tiling whose check
//! finds anything is not returned. Source: [Favreau2009].

mod output;
mod picture;
pub mod request;
mod saved;

pub use output::{stage_layout, stage_steps, stage_tiles};
pub use picture::scene;
pub use request::{Cost, Into, TileRequest};
pub use saved::{check_layout, read_tiling};

use crate::error::{RemeshError, Warning, WarningCode};
use quadloom_mesh::repair::{Component, RepairOptions, Repaired, repair, split_components};
use quadloom_mesh::{CornerMap, DVec2, EdgeMap, FaceId, FaceSoup, Id, Progress, Summary, TriMesh, VertexId, VertexMap};
use quadloom_tiling::maps::{MapError, MapMethod, MapOptions, MapReport};
use quadloom_tiling::{
    CutKind, CutOptions, Cutting, EdgeCosts, Method, OnFailure, QuadOptions, QuadReport, SearchMode, TileId, Tiling,
    TilingError, cut_given, cut_into_cylinders, cut_into_pants, cut_to_disk, map_tiles,
};
use serde::Serialize;
use std::time::Instant;

/// A surface cut into tiles.
#[derive(Clone, Debug)]
pub struct TileResult {
    /// The components, by their smallest face.
    pub parts: Vec<TiledPart>,
    /// What was done and measured.
    pub report: TileReport,
    /// What a user should know.
    pub warnings: Vec<Warning>,
}

/// A component cut into tiles.
#[derive(Clone, Debug)]
pub struct TiledPart {
    /// The component, as it was before.
    pub component: Component,
    /// Its tiling.
    pub tiling: Tiling,
    /// The tilings before the first cut and after each one; empty where they were not asked for. Where tiles were
    /// mapped, the last one lacks the splits of edges that maps need.
    pub steps: Vec<Tiling>,
    /// Texture coordinates of each corner, where tiles were mapped.
    pub uv: Option<CornerMap<DVec2>>,
}

/// What was done and measured; lengths in file units.
#[derive(Clone, Debug, Serialize)]
pub struct TileReport {
    /// Into what was cut.
    pub into: Into,
    /// How one tile was made; none where the cut was given, or pants were made.
    pub method: Option<Method>,
    /// How far shortest loops were looked for.
    pub search: SearchMode,
    /// What a cut cost.
    pub cost: String,
    /// Number of tiles.
    pub tiles: usize,
    /// Number of sides of each tile, on all its boundaries.
    pub sides: Vec<usize>,
    /// Points where cuts meet, or meet a boundary, and one on each cut or boundary where none does.
    pub multipoints: usize,
    /// Length of all cuts on the refined mesh.
    pub length: f64,
    /// Cost of all cuts as they were found, before they were pulled off each other.
    pub cut_cost: f64,
    /// Euler characteristic of the surface.
    pub chi: i64,
    /// Sum of the components' genera.
    pub genus: i64,
    /// Boundary loops of the surface.
    pub boundary_loops: usize,
    /// Word of the tile, where all is one polygon before any diagonal is cut.
    pub word: Option<String>,
    /// The canonical word that it is equivalent to.
    pub canonical_word: Option<String>,
    /// The components, in order.
    pub components: Vec<PartReport>,
    /// Vertices of the surface, and of the refined mesh.
    pub vertices: [usize; 2],
    /// Faces of the surface, and of the refined mesh.
    pub faces: [usize; 2],
    /// Where the time went.
    pub seconds: Seconds,
    /// Largest resident memory of the process so far, bytes; none where the system does not tell.
    pub peak_memory_bytes: Option<u64>,
}

/// One component.
#[derive(Clone, Debug, Serialize)]
pub struct PartReport {
    /// Its genus.
    pub genus: i64,
    /// Its boundary loops.
    pub boundary_loops: usize,
    /// Number of tiles.
    pub tiles: usize,
    /// Sides of the polygon before any diagonal is cut; none where there was none.
    pub polygon: Option<usize>,
    /// Its word.
    pub word: Option<String>,
    /// The canonical word that it is equivalent to.
    pub canonical_word: Option<String>,
    /// The cuts, in their order.
    pub cuts: Vec<CutReport>,
    /// What quadrangulation did.
    pub quadrangles: Option<QuadReport>,
    /// Maps of the tiles, where they were asked for.
    pub maps: Vec<MapReport>,
}

/// One cut.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct CutReport {
    /// What it did.
    pub kind: CutKind,
    /// What it cost.
    pub cost: f64,
}

/// Where the time went.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Seconds {
    /// Soup to surface.
    pub repair: f64,
    /// Cuts.
    pub cutting: f64,
    /// Refined meshes, tilings and their checks.
    pub tilings: f64,
    /// Maps of tiles.
    pub maps: f64,
}

/// The method, if none is asked for.
fn default_method(request: &TileRequest, closed: bool) -> Method {
    match (request.method, request.into, closed) {
        (Some(method), ..) => method,
        (None, Into::Schema | Into::Quads, true) => Method::SinglePoint,
        (None, Into::Schema | Into::Quads, false) => Method::Intermediate,
        (None, Into::Disk | Into::Pants | Into::Cylinders, _) => Method::Shortest,
    }
}

/// Cuts a surface into tiles.
///
/// # Input      a soup, as a file says it; what is asked for
/// # Errors     a soup that is no surface; names that are not on it; every [`TilingError`], with the component where
/// there are several; a stop
/// # Cost       that of the algorithm asked for, per component
/// # Guarantees deterministic; every tiling passed [`Tiling::check`]
pub fn tile_surface(soup: &FaceSoup, request: &TileRequest, progress: &Progress) -> Result<TileResult, RemeshError> {
    let mut seconds = Seconds::default();
    let clock = Instant::now();
    progress.report("repair", 0.0);
    crate::input::check_extent(soup)?;
    let repaired = repair(soup, &RepairOptions { zero_area_rel: 0.0, ..RepairOptions::default() })?;
    if request.cut.is_some() && matches!(request.into, Into::Pants | Into::Cylinders) {
        let why =
            "it goes with --into disk, schema and quads; pants and cylinders are cut along loops that are looked for";
        return Err(RemeshError::Mismatch { what: "--cut", why: why.into() });
    }
    let given = Given::read(soup, &repaired, request)?;
    let components = split_components(&repaired.mesh).map_err(TilingError::from)?;
    seconds.repair = clock.elapsed().as_secs_f64();
    let several = components.len() > 1;
    let mut parts = Vec::with_capacity(components.len());
    let mut reports = Vec::with_capacity(components.len());
    let (mut cut_cost, mut warnings) = (0.0, Vec::new());
    for (number, component) in components.into_iter().enumerate() {
        let named = |error: TilingError| match error {
            TilingError::Cancelled(stop) => RemeshError::Cancelled(stop),
            error if several => {
                RemeshError::Tiling { component: Some((number, component.face_of[FaceId(0)].0)), error }
            }
            error => RemeshError::Tiling { component: None, error },
        };
        let (mut part, mut report, cost) =
            tile_component(&component, &given, request, progress, &mut seconds).map_err(named)?;
        if let Some(method) = request.parametrize {
            let clock = Instant::now();
            let instead = map_part(&mut part, &mut report, method, progress).map_err(named)?;
            seconds.maps += clock.elapsed().as_secs_f64();
            let first = reports.iter().map(|r: &PartReport| r.tiles).sum::<usize>();
            warnings.extend(instead.into_iter().map(|(tile, error)| {
                let message = format!("tile {} has a mean value map instead: {error}", first + tile.index());
                Warning::new(WarningCode::TileMapMissed, message)
            }));
        }
        cut_cost += cost;
        reports.push(report);
        parts.push(part);
    }
    let report = report_of(&repaired.mesh, request, &parts, reports, cut_cost, seconds);
    let found = repaired.report.findings();
    warnings.extend(found.map(|f| Warning::new(WarningCode::Repaired, format!("the input was repaired: {f}"))));
    Ok(TileResult { parts, report, warnings })
}

/// What a request names, on the repaired surface.
struct Given {
    /// Multiplier of costs.
    multiplier: Option<VertexMap<f64>>,
    forbidden: Vec<VertexId>,
    base: Option<VertexId>,
    /// Edges to cut along.
    cut: Option<Vec<[VertexId; 2]>>,
}

impl Given {
    fn read(soup: &FaceSoup, repaired: &Repaired, request: &TileRequest) -> Result<Self, RemeshError> {
        let on_surface = |name: &str, what: &'static str| -> Result<VertexMap<f64>, RemeshError> {
            let found = soup.vertex_attributes.iter().find(|(n, _)| n == name);
            let Some((_, values)) = found else {
                let names: Vec<&str> = soup.vertex_attributes.iter().map(|(n, _)| n.as_str()).collect();
                let has = if names.is_empty() { "it has none (.ply can have some)".into() } else { names.join(", ") };
                return Err(RemeshError::Mismatch {
                    what,
                    why: format!("there is no vertex attribute `{name}`; {has}"),
                });
            };
            let mut map = VertexMap::filled(repaired.mesh.vertex_count(), f64::NAN);
            for (&value, v) in values.iter().zip(&repaired.vertex_of_input).rev() {
                v.iter().for_each(|&v| map[v] = value);
            }
            Ok(map)
        };
        let multiplier = match &request.cost {
            Cost::Attribute(name) => Some(on_surface(name, "--cost")?),
            _ => None,
        };
        let forbidden = match &request.forbid {
            Some(name) => on_surface(name, "--forbid")?.iter().filter(|(_, x)| **x != 0.0).map(|(v, _)| v).collect(),
            None => Vec::new(),
        };
        let vertex = |v: u32| -> Result<VertexId, RemeshError> {
            let wrong = |why| RemeshError::Mismatch { what: "--base", why };
            match repaired.vertex_of_input.get(v as usize) {
                Some(Some(v)) => Ok(*v),
                Some(None) => Err(wrong(format!("vertex {v} is used by no face; name one of the surface"))),
                None => {
                    let last = repaired.vertex_of_input.len() - 1;
                    Err(wrong(format!("there is no vertex {v}, the last one is {last}; vertices count from 0")))
                }
            }
        };
        let cut = match &request.cut {
            None => None,
            Some(path) => {
                let file = quadloom_io::read_features(path)?;
                let mut edges = Vec::new();
                for [a, b] in file.vertex_pairs(soup)? {
                    let ends = [a, b].map(|v| repaired.vertex_of_input[v as usize]);
                    match ends {
                        [Some(a), Some(b)] if repaired.mesh.find_edge(a, b).is_some() => edges.push([a, b]),
                        _ => {
                            let why = format!("vertices {a} and {b} are not joined by an edge of a triangle");
                            return Err(RemeshError::Mismatch { what: "--cut", why });
                        }
                    }
                }
                Some(edges)
            }
        };
        Ok(Self { multiplier, forbidden, base: request.base.map(vertex).transpose()?, cut })
    }
}

/// Cuts one component.
fn tile_component(
    component: &Component,
    given: &Given,
    request: &TileRequest,
    progress: &Progress,
    seconds: &mut Seconds,
) -> Result<(TiledPart, PartReport, f64), TilingError> {
    let mesh = &component.mesh;
    let clock = Instant::now();
    // 1. Costs and names, on the component.
    let local = |v: VertexId| component.vertex_of.values().binary_search(&v).ok().map(VertexId::new);
    let mut costs = match request.cost {
        Cost::Curvature(strength) => EdgeCosts::curvature(mesh, strength)?,
        _ => EdgeCosts::euclidean(mesh),
    };
    if let Some(multiplier) = &given.multiplier {
        let local = VertexMap::from_fn(mesh.vertex_count(), |v| multiplier[component.vertex_of[v]]);
        costs = costs.times_vertices(mesh, &local)?;
    }
    costs = costs.without_vertices(mesh, given.forbidden.iter().filter_map(|&v| local(v)));
    let options = CutOptions { search: request.search, base: given.base.and_then(local) };
    // 2. Cuts.
    let summary = Summary::of(mesh);
    let wants_quads = request.into == Into::Quads;
    if wants_quads && summary.genus == 0 && summary.boundary_loops == 0 {
        let instead = "a sphere cut open has two sides; cut it into a disk, or mesh it with `quadloom remesh`";
        return Err(TilingError::NoHandle { algorithm: "cutting into quadrangles", instead });
    }
    let mut cutting = match (&given.cut, request.into) {
        (Some(edges), _) => cut_along_edges(mesh, &costs, edges, &local, request.into, progress)?,
        (None, Into::Pants) => cut_into_pants(mesh, &costs, &options, progress)?,
        (None, Into::Cylinders) => cut_into_cylinders(mesh, &costs, &options, progress)?,
        (None, _) => {
            let method = default_method(request, summary.boundary_loops == 0);
            cut_to_disk(mesh, &costs, method, &options, progress)?
        }
    };
    seconds.cutting += clock.elapsed().as_secs_f64();
    // 3. The polygon, then quadrangles.
    let (mut polygon, mut word, mut canonical_word, mut quadrangles) = (None, None, None, None);
    if !matches!(request.into, Into::Pants | Into::Cylinders) {
        let clock = Instant::now();
        let tiling = cutting.tiling()?;
        if let [cell] = tiling.complex.cells.values()
            && let Some(found) = tiling.word(TileId(0))
        {
            polygon = Some(cell.side_count());
            canonical_word = Some(found.canonical_form().text());
            word = Some(found.to_string());
        }
        seconds.tilings += clock.elapsed().as_secs_f64();
    }
    if wants_quads {
        let clock = Instant::now();
        let options = QuadOptions { search: request.search, choice: request.diagonals };
        quadrangles = Some(cutting.quadrangulate(&options)?);
        seconds.cutting += clock.elapsed().as_secs_f64();
    }
    // 4. Tilings, checked.
    let clock = Instant::now();
    progress.report("tilings", 0.0);
    let steps = if request.steps { cutting.steps()? } else { Vec::new() };
    let tiling = match steps.last() {
        Some(last) => last.clone(),
        None => cutting.tiling()?,
    };
    for tiling in steps.iter().chain([&tiling]) {
        progress.check()?;
        if !tiling.check().is_empty() {
            return Err(TilingError::Fault { what: "a tiling does not pass its check" });
        }
    }
    seconds.tilings += clock.elapsed().as_secs_f64();
    let report = PartReport {
        genus: summary.genus,
        boundary_loops: summary.boundary_loops,
        tiles: tiling.complex.cells.len(),
        polygon,
        word,
        canonical_word,
        cuts: cutting.cuts().iter().map(|c| CutReport { kind: c.kind, cost: c.cost }).collect(),
        quadrangles,
        maps: Vec::new(),
    };
    let cost = cutting.cost();
    Ok((TiledPart { component: component.clone(), tiling, steps, uv: None }, report, cost))
}

/// Maps the tiles of a component; tiles that have no map of the kind asked for get a mean value map and are returned.
fn map_part(
    part: &mut TiledPart,
    report: &mut PartReport,
    method: MapMethod,
    progress: &Progress,
) -> Result<Vec<(TileId, MapError)>, TilingError> {
    progress.report("maps", 0.0);
    let options = MapOptions::default();
    let maps = map_tiles(&part.tiling, &part.component.mesh, method, &options, OnFailure::MeanValue, progress)?;
    if !maps.tiling.check().is_empty() {
        return Err(TilingError::Fault { what: "a tiling does not pass its check after edges were split" });
    }
    (part.tiling, part.uv, report.maps) = (maps.tiling, Some(maps.uv), maps.reports);
    Ok(maps.instead)
}

/// Cuts along edges that the user gave; into one disk, several tiles are merged.
fn cut_along_edges<'a>(
    mesh: &'a TriMesh,
    costs: &'a EdgeCosts,
    edges: &[[VertexId; 2]],
    local: &impl Fn(VertexId) -> Option<VertexId>,
    into: Into,
    progress: &'a Progress,
) -> Result<Cutting<'a>, TilingError> {
    let mut cut = EdgeMap::filled(mesh.edge_count(), false);
    for &[a, b] in edges {
        if let (Some(a), Some(b)) = (local(a), local(b))
            && let Some(e) = mesh.find_edge(a, b)
        {
            cut[e] = true;
        }
    }
    let cutting = cut_given(mesh, costs, &cut, progress)?;
    if !matches!(into, Into::Disk | Into::Schema) {
        return Ok(cutting);
    }
    let merged = cutting.tiling()?.merged().cut_edges();
    cut_given(mesh, costs, &merged, progress)
}

/// The report of all components.
fn report_of(
    mesh: &TriMesh,
    request: &TileRequest,
    parts: &[TiledPart],
    components: Vec<PartReport>,
    cut_cost: f64,
    seconds: Seconds,
) -> TileReport {
    let summary = Summary::of(mesh);
    let cells = || parts.iter().flat_map(|p| p.tiling.complex.cells.values());
    let one = |text: fn(&PartReport) -> &Option<String>| match &components[..] {
        [only] => text(only).clone(),
        _ => None,
    };
    let searched = request.cut.is_none() && !matches!(request.into, Into::Pants | Into::Cylinders);
    TileReport {
        into: request.into,
        method: searched.then(|| default_method(request, summary.boundary_loops == 0)),
        search: request.search,
        cost: request.cost.to_string(),
        tiles: cells().count(),
        sides: cells().map(|c| c.side_count()).collect(),
        multipoints: parts.iter().map(|p| p.tiling.complex.nodes).sum(),
        length: parts.iter().map(|p| p.tiling.cut_length()).sum(),
        cut_cost,
        chi: summary.chi,
        genus: summary.genus,
        boundary_loops: summary.boundary_loops,
        word: one(|part| &part.word),
        canonical_word: one(|part| &part.canonical_word),
        components,
        vertices: [mesh.vertex_count(), parts.iter().map(|p| p.tiling.mesh().vertex_count()).sum()],
        faces: [mesh.face_count(), parts.iter().map(|p| p.tiling.mesh().face_count()).sum()],
        seconds,
        peak_memory_bytes: crate::memory::peak_bytes(),
    }
}
