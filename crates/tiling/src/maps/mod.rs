//! Maps of disk-shaped tiles to the plane ([Favreau2009] §5.2).
//!
//! In: a mesh that is a disk, its corners, a [`MapMethod`]. Out: [`TileMap`]: a place per vertex and what it is worth.
//! Holds: a map with a fixed border has its corners at those of the unit square or a regular polygon, and two tiles
//! agree along a common side; faces are tested exactly, and a folded map is no success unless it was allowed. Not: free
//! of overlaps where the border is free; the report tells. Source: the sources of each method's own module.
//!
//! | method | border | folds | distortion |
//! |---|---|---|---|
//! | [`MapMethod::MeanValue`] | fixed, convex | never | moderate |
//! | [`MapMethod::Conformal`] | fixed, convex | with obtuse triangles | angles best for this border |
//! | [`MapMethod::AngleBased`] | free | from rounding alone | angles best of all |
//! | [`MapMethod::Circles`] | free | from rounding alone | areas near the border kept |

mod angles;
mod border;
mod checks;
mod circles;
mod conformal;
mod disk;
mod error;
mod harmonic;
mod layout;
mod mean_value;
mod measures;
mod metric;

pub use border::{edges_on_one_side, side_parameters, split_side_edges};
pub use checks::{border_overlaps, folded_faces};
pub use error::MapError;
pub use measures::Distortion;

use disk::Disk;
use metric::Metric;
use quadloom_mesh::{CornerMap, DVec2, FaceId, Progress, TriMesh, VertexId, VertexMap};
use serde::{Deserialize, Serialize};

/// How a tile is mapped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MapMethod {
    /// To a convex border by mean value coordinates [Floater2003]; never folded.
    MeanValue,
    /// To a convex border by discrete conformal, that is harmonic, coordinates [Eck1995].
    Conformal,
    /// With a free border by angle-based flattening [ShefferDeSturler2001].
    AngleBased,
    /// With a free border by circle packing [CollinsStephenson2003].
    Circles,
}

impl std::fmt::Display for MapMethod {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::MeanValue => "mean value",
            Self::Conformal => "conformal",
            Self::AngleBased => "angle based",
            Self::Circles => "circle packing",
        })
    }
}

/// Where a fixed border goes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Border {
    /// The unit square for four corners, a regular polygon in the circle for any other number from three, the circle
    /// for one or two.
    #[default]
    Polygon,
    /// The circle of radius 1/2 about (1/2, 1/2), a part for each side in proportion to its length.
    Circle,
}

/// Which circles are packed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PackingKind {
    /// Circles at the inversive distances that they have on the surface. A flat tile is reproduced. Where a circle
    /// would have to be so small or so large that triangles degenerate, touching circles are packed instead.
    #[default]
    InversiveDistance,
    /// Touching circles: a packing always exists, and forgets all shapes of triangles.
    Tangent,
}

/// Options of [`map_tile`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct MapOptions {
    /// Where a fixed border goes. Default: polygon.
    pub border: Border,
    /// Place of each border vertex along its side, 0..1 from the side's first corner, ascending; other entries are
    /// ignored. Default: [`side_parameters`].
    pub side_parameters: Option<VertexMap<f64>>,
    /// Most rounds in which a mean value map whose faces cannot be told apart is drawn outwards. Default: 16, of which
    /// a finger a hundred times as long as its girth needs 6. Each costs one solve.
    pub max_rounds: usize,
    /// Whether maps other than mean value are returned although they fold; their report lists the faces. Default: no.
    pub allow_folds: bool,
    /// Which circles are packed. Default: inversive distances.
    pub packing: PackingKind,
}

impl Default for MapOptions {
    fn default() -> Self {
        Self {
            border: Border::default(),
            side_parameters: None,
            max_rounds: 16,
            allow_folds: false,
            packing: PackingKind::default(),
        }
    }
}

/// A map of a tile to the plane.
#[derive(Clone, Debug, PartialEq)]
pub struct TileMap {
    /// Place of every vertex. Fixed border: inside the unit square. Free border: file units, the first corner at the
    /// origin, the second on the x axis, with the area of the surface.
    pub uv: VertexMap<DVec2>,
    /// How it was made and what it is worth.
    pub report: MapReport,
}

/// How a map was made and what it is worth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MapReport {
    /// How the tile was mapped.
    pub method: MapMethod,
    /// Number of vertices.
    pub vertices: usize,
    /// Number of faces.
    pub faces: usize,
    /// Number of border vertices.
    pub border_vertices: usize,
    /// Number of corners.
    pub corners: usize,
    /// Rounds of the method. Mean value: drawing outwards; 0 for the weights of the paper. Free border: steps
    /// of Newton's method.
    pub rounds: usize,
    /// Largest error of the angle conditions, radians; 0 for fixed borders.
    pub residual: f64,
    /// Which circles were packed: for circle packings, and for angle-based maps that had to be sought from one.
    pub packing: Option<PackingKind>,
    /// Number of triangles that are degenerate: flat to 1e-8 of the mean edge length, or nearly so.
    pub degenerate_faces: usize,
    /// What was added to all edge lengths on their account, as a fraction of the mean length.
    pub added_length: f64,
    /// Faces whose area in the plane is not positive, ascending; decided exactly.
    pub folded: Vec<FaceId>,
    /// Whether the border crosses or touches itself; decided exactly. If not, and no face is folded, the map is
    /// one-to-one.
    pub overlaps: bool,
    /// Distortion of angles and areas.
    pub distortion: Distortion,
}

/// A place per vertex, and how it was found.
struct Found {
    uv: VertexMap<DVec2>,
    rounds: usize,
    residual: f64,
    packing: Option<PackingKind>,
}

/// Maps a tile to the plane.
///
/// Degenerate triangles get angles from edge lengths to which a tiny length was added, so that no method divides by
/// zero; the report counts them.
///
/// # Input      mesh: a disk; corners: boundary vertices, counter-clockwise (the surface to the left), at least one for
/// a fixed border; four go to the unit square: 0 → (0,0), 1 → (1,0), 2 → (1,1), 3 → (0,1)
/// # Output     a place per vertex and a report
/// # Errors     no disk; wrong corners or parameters; [`MapError::EdgeOnSide`] where a straight side would flatten
/// faces; [`MapError::Folded`], always for mean value, otherwise unless folds are allowed; [`MapError::NotConverged`]
/// # Cost       fixed border: one sparse factorisation, and one more per round; angle based: one of twice the unknowns
/// per round; circles: one per round
/// # Guarantees mean value: one-to-one (no fold and a convex border; both exact). Places of a square's border lie on it
/// exactly. The same input gives the same bytes for any number of threads
/// # Source     [Favreau2009] §5.2
pub fn map_tile(
    mesh: &TriMesh,
    corners: &[VertexId],
    method: MapMethod,
    options: &MapOptions,
    progress: &Progress,
) -> Result<TileMap, MapError> {
    let disk = Disk::new(mesh, corners)?;
    let metric = Metric::new(mesh)?;
    progress.check()?;
    let found = match method {
        MapMethod::MeanValue | MapMethod::Conformal => {
            let border = border::place_border(mesh, &disk, options)?;
            to_border(mesh, &disk, &metric, method, &border, options, progress)?
        }
        MapMethod::AngleBased => flatten_angles(mesh, &disk, &metric, progress)?,
        MapMethod::Circles => pack_circles(mesh, &disk, &metric, options.packing, progress)?,
    };
    let report = report(mesh, &disk, &metric, method, &found);
    if let (Some(&face), false) = (report.folded.first(), options.allow_folds) {
        let advice = "use mean value, which never folds, or allow folds";
        return Err(MapError::Folded { face, count: report.folded.len(), method, rounds: found.rounds, advice });
    }
    progress.report("map", 1.0);
    Ok(TileMap { uv: found.uv, report })
}

fn to_border(
    mesh: &TriMesh,
    disk: &Disk,
    metric: &Metric,
    method: MapMethod,
    border: &[DVec2],
    options: &MapOptions,
    progress: &Progress,
) -> Result<Found, MapError> {
    let (uv, rounds) = match method {
        MapMethod::Conformal => (conformal::solve(mesh, disk, metric, border)?, 0),
        _ => mean_value::solve(mesh, disk, metric, border, options, progress)?,
    };
    Ok(Found { uv, rounds, residual: 0.0, packing: None })
}

fn flatten_angles(mesh: &TriMesh, disk: &Disk, metric: &Metric, progress: &Progress) -> Result<Found, MapError> {
    let flat = angles::flatten(mesh, disk, metric, progress)?;
    let uv = laid_out(mesh, disk, metric, &flat.angle, MapMethod::AngleBased)?;
    Ok(Found { uv, rounds: flat.rounds, residual: flat.residual, packing: flat.start })
}

fn pack_circles(
    mesh: &TriMesh,
    disk: &Disk,
    metric: &Metric,
    kind: PackingKind,
    progress: &Progress,
) -> Result<Found, MapError> {
    let packed = circles::pack(mesh, disk, metric, kind, progress)?;
    let uv = laid_out(mesh, disk, metric, &packed.angle, MapMethod::Circles)?;
    Ok(Found { uv, rounds: packed.rounds, residual: packed.residual, packing: Some(packed.kind) })
}

fn laid_out(
    mesh: &TriMesh,
    disk: &Disk,
    metric: &Metric,
    angle: &CornerMap<f64>,
    method: MapMethod,
) -> Result<VertexMap<DVec2>, MapError> {
    let area = mesh.faces().map(|f| metric.area(mesh, f)).sum::<f64>() * metric.unit * metric.unit;
    layout::lay_out(mesh, disk, angle, area).map_err(|e| conformal::fault(method, &e))
}

fn report(mesh: &TriMesh, disk: &Disk, metric: &Metric, method: MapMethod, found: &Found) -> MapReport {
    MapReport {
        method,
        vertices: mesh.vertex_count(),
        faces: mesh.face_count(),
        border_vertices: disk.border.len(),
        corners: disk.corner_at.len(),
        rounds: found.rounds,
        residual: found.residual,
        packing: found.packing,
        degenerate_faces: metric.degenerate,
        added_length: metric.added,
        folded: folded_faces(mesh, &found.uv),
        overlaps: border_overlaps(mesh, &found.uv),
        distortion: measures::measure(mesh, metric, &found.uv),
    }
}
