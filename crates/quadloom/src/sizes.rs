//! Where quads are smaller, and where they are stretched.
//!
//! In: a work mesh, its field, what is asked for. Out: [`SizeField`] relative to the mean edge length of the quads.
//! Holds: lengths are positive, grow slowly, and ask for one quad per squared mean length over the whole surface.
//! Source: [Bommes2012] §8.3.

use crate::options::AdaptTo;
use crate::stages::WorkMesh;
use quadloom_field::curvature::curvatures;
use quadloom_field::sizing::{CurvatureSizing, local_feature_size};
use quadloom_field::{CrossField, Curvature, SizeField, Transport};
use quadloom_mesh::closest::ClosestPoint;
use quadloom_mesh::{Cancelled, FaceMap, Progress, TriMesh, VertexMap, metric};

/// What is asked of the sizes.
#[derive(Clone, Debug, Default)]
pub struct SizeRequest {
    /// How strongly sizes follow curvature or local feature size, 0..=1.
    pub adaptivity: f64,
    /// Which of the two.
    pub adapt_to: AdaptTo,
    /// How strongly quads stretch along low curvature, 0..=1.
    pub anisotropy: f64,
    /// How far lengths follow the field so that its crosses scaled by them have less curl, 0..=1.
    pub curl_correction: f64,
    /// Relative number of quads per area at every vertex of the surface.
    pub density: Option<VertexMap<f64>>,
}

/// Shortest and longest length, relative to the mean: the work mesh has room for quads of half its usual size.
const RANGE: f64 = 2.0;

/// Largest factor by which the curl correction changes lengths.
const CURL_RANGE: f64 = 1.5;

/// Growth of lengths per unit of distance: doubled over about three quads.
const GROWTH: f64 = 0.3;

/// Density below this part of the largest one counts as that much: quads of four times the smallest edge.
const LEAST_DENSITY: f64 = 1.0 / 16.0;

/// Local feature size, relative to the diagonal, below which smaller ones are told apart no more.
const LEAST_FEATURE_SIZE: f64 = 1e-3;

impl SizeRequest {
    /// Whether all quads are to be squares of about one size.
    pub fn is_uniform(&self) -> bool {
        self.adaptivity == 0.0 && self.anisotropy == 0.0 && self.density.is_none()
    }
}

/// Sizes relative to the mean.
///
/// # Input      surface: the mesh that the request's density lives on; edge: mean edge length of the quads, file units
/// # Errors     cancellation
/// # Cost       a neighbourhood search per face or some closest-point queries per vertex, if sizes are not uniform
pub fn relative_sizes(
    work: &WorkMesh,
    field: &CrossField,
    surface: &TriMesh,
    edge: f64,
    request: &SizeRequest,
    progress: &Progress,
) -> Result<SizeField, Cancelled> {
    let mesh = &work.mesh;
    let area = metric::face_areas(mesh, &metric::edge_lengths(mesh));
    let mut size = SizeField::uniform(mesh.face_count(), edge);
    // 1. Curvature, and what stretches or shrinks quads besides.
    let by_shape = request.adapt_to == AdaptTo::FeatureSize && request.adaptivity > 0.0;
    let adaptivity = if by_shape { 0.0 } else { request.adaptivity };
    if adaptivity > 0.0 || request.anisotropy > 0.0 {
        let curvature: FaceMap<Curvature> = curvatures(mesh, &[edge], progress)?.map(|disks| disks[0]);
        size = by_curvature(field, &curvature, &area, edge, adaptivity, request.anisotropy);
    }
    if by_shape {
        let factor = by_feature_size(mesh, &area, request.adaptivity, progress)?;
        size = multiplied(&size, &factor);
    }
    // 2. Density.
    if let Some(density) = &request.density {
        let here = transfer(surface, density, mesh);
        let wanted = SizeField::by_density(mesh, &here, LEAST_DENSITY);
        size = multiplied(&size, &wanted);
    }
    // 3. Less curl, so that quads need not shear.
    if request.curl_correction > 0.0 {
        let length = metric::edge_lengths(mesh);
        let transport = Transport::new(mesh, &length);
        // Where the potential cannot be solved for, sizes stay as they are: the map copes with more curl too.
        let strength = request.curl_correction;
        if let Ok(corrected) = size.curl_corrected(mesh, &transport, &length, field, strength, CURL_RANGE) {
            size = corrected;
        }
    }
    // 4. No jumps, and one quad per unit of area in the mean.
    let whole: f64 = area.values().iter().sum();
    let graded = if request.is_uniform() { size } else { size.graded(mesh, field, GROWTH) };
    Ok(graded.normalized(&area, whole))
}

/// Aspect from the anisotropy asked for, mean length from the adaptivity.
fn by_curvature(
    field: &CrossField,
    curvature: &FaceMap<Curvature>,
    area: &FaceMap<f64>,
    edge: f64,
    adaptivity: f64,
    anisotropy: f64,
) -> SizeField {
    let whole: f64 = area.values().iter().sum();
    let squares: f64 = area.iter().map(|(f, a)| a * curvature[f].max.powi(2)).sum();
    let typical = (squares / whole.max(f64::MIN_POSITIVE)).sqrt();
    let sizing = CurvatureSizing {
        // A quad of the mean length on typical curvature is just within the tolerance.
        tolerance: edge * edge * typical / 8.0,
        shortest: edge / RANGE,
        longest: edge * RANGE,
        anisotropy,
    };
    let full = SizeField::by_curvature(field, curvature, &sizing);
    let mean = |f| (full.u[f] * full.v[f]).sqrt();
    let log_mean = area.iter().map(|(f, a)| a * mean(f).ln()).sum::<f64>() / whole.max(f64::MIN_POSITIVE);
    let factor = |f| (log_mean + adaptivity * (mean(f).ln() - log_mean)).exp() / mean(f);
    SizeField {
        u: FaceMap::from_fn(area.len(), |f| full.u[f] * factor(f)),
        v: FaceMap::from_fn(area.len(), |f| full.v[f] * factor(f)),
    }
}

/// Lengths in proportion to the local feature size, drawn towards their mean and within the usual range of it.
fn by_feature_size(
    mesh: &TriMesh,
    area: &FaceMap<f64>,
    adaptivity: f64,
    progress: &Progress,
) -> Result<SizeField, Cancelled> {
    let largest = mesh.diagonal();
    // Creases have no local feature size at all; what is far below the range counts as its lower end.
    let radius = local_feature_size(mesh, LEAST_FEATURE_SIZE * largest, largest, progress)?;
    let length = SizeField::from_vertex_lengths(mesh, &radius).blended(area, adaptivity);
    let whole: f64 = area.values().iter().sum();
    let log_mean = area.iter().map(|(f, a)| a * length.u[f].ln()).sum::<f64>() / whole.max(f64::MIN_POSITIVE);
    let mean = log_mean.exp();
    Ok(SizeField::from_lengths(length.u.map(|h| (h / mean).clamp(1.0 / RANGE, RANGE))))
}

/// Product of two sizes, face by face and direction by direction.
fn multiplied(size: &SizeField, factor: &SizeField) -> SizeField {
    let product = |a: &FaceMap<f64>, b: &FaceMap<f64>| FaceMap::from_fn(a.len(), |f| a[f] * b[f]);
    SizeField { u: product(&size.u, &factor.u), v: product(&size.v, &factor.v) }
}

/// Values of a surface's vertices at the vertices of a mesh on it.
fn transfer(surface: &TriMesh, value: &VertexMap<f64>, mesh: &TriMesh) -> VertexMap<f64> {
    let closest = ClosestPoint::new(surface);
    VertexMap::from_fn(mesh.vertex_count(), |v| {
        let point = closest.query(mesh.position(v)).point;
        let corner = surface.face_vertices(point.face);
        (0..3).map(|k| point.weights[k] * value[corner[k]]).sum()
    })
}
