//! How good quads are: shapes, irregular vertices, distance to the surface they stand for.
//!
//! In: a quad mesh, and for distances a [`Reference`]. Out: values per element, summaries, histograms.
//! Holds: a quad whose scaled Jacobian is zero or less is inverted; distances are sampled, at fixed points, so they
//! are lower estimates of the largest and the same in every run.
//! Source: scaled Jacobian after [Knupp2000], the worst of a quad's corners.

use crate::reference::Reference;
use quadloom_mesh::closest::{ClosestPoint, PolylineIndex};
use quadloom_mesh::topology::boundary_loops;
use quadloom_mesh::{
    CornerMap, DVec3, EdgeMap, FaceId, FaceMap, FeatureKind, HalfEdgeId, MeshError, QuadMesh, TriMesh,
};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Scaled Jacobian of a quad, in -1..=1: the sine of its worst corner angle, seen along the cross product of its
/// diagonals.
#[inline]
pub fn scaled_jacobian(corner: [DVec3; 4]) -> f64 {
    let normal = (corner[2] - corner[0]).cross(corner[3] - corner[1]).normalize_or_zero();
    worst_corner(corner, normal)
}

/// The smallest sine of a corner angle, seen along a unit normal.
#[inline]
pub(crate) fn worst_corner(corner: [DVec3; 4], normal: DVec3) -> f64 {
    let sine = |k: usize| {
        let (a, b) = (corner[(k + 1) % 4] - corner[k], corner[(k + 3) % 4] - corner[k]);
        let size = (a.length_squared() * b.length_squared()).sqrt();
        a.cross(b).dot(normal) / size.max(1e-300)
    };
    sine(0).min(sine(1)).min(sine(2).min(sine(3)))
}

/// Angle of each corner of a quad, degrees in 0..=180.
pub fn corner_angles(corner: [DVec3; 4]) -> [f64; 4] {
    std::array::from_fn(|k| {
        let (a, b) = (corner[(k + 1) % 4] - corner[k], corner[(k + 3) % 4] - corner[k]);
        a.cross(b).length().atan2(a.dot(b)).to_degrees()
    })
}

/// Positions of a quad's corners.
#[inline]
pub fn corners(quads: &QuadMesh, f: FaceId) -> [DVec3; 4] {
    quads.face_vertices(f).map(|v| quads.position(v))
}

/// Shape measures of every quad.
#[derive(Clone, Debug, PartialEq)]
pub struct QuadQuality {
    /// Scaled Jacobian of each quad.
    pub scaled_jacobian: FaceMap<f64>,
    /// Angle of each corner, degrees.
    pub angle: CornerMap<f64>,
    /// Length of each edge, file units.
    pub edge_length: EdgeMap<f64>,
}

/// Shape measures over all quads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct QualitySummary {
    /// Smallest scaled Jacobian.
    pub scaled_jacobian_min: f64,
    /// Mean scaled Jacobian.
    pub scaled_jacobian_mean: f64,
    /// Quads whose scaled Jacobian is zero or less.
    pub inverted: usize,
    /// Mean deviation of the corner angles from 90 degrees, degrees.
    pub angle_mean: f64,
    /// Largest deviation of a corner angle from 90 degrees, degrees.
    pub angle_max: f64,
    /// Mean edge length, file units.
    pub edge_mean: f64,
    /// Standard deviation of the edge lengths, relative to their mean.
    pub edge_variation: f64,
}

/// Counts of values in bins of equal width.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Histogram {
    /// Lower end of the first bin.
    pub low: f64,
    /// Upper end of the last bin.
    pub high: f64,
    /// Values in each bin; values outside are counted in the nearest one.
    pub counts: Vec<usize>,
}

impl Histogram {
    /// Counts values in `bins` bins between `low` and `high`.
    pub fn of(values: &[f64], low: f64, high: f64, bins: usize) -> Self {
        let mut counts = vec![0; bins.max(1)];
        let scale = counts.len() as f64 / (high - low).max(f64::MIN_POSITIVE);
        for &x in values {
            let bin = ((x - low) * scale).floor().clamp(0.0, (counts.len() - 1) as f64);
            counts[bin as usize] += 1;
        }
        Self { low, high, counts }
    }
}

impl QuadQuality {
    /// Measures every quad.
    ///
    /// # Cost       linear
    pub fn of(quads: &QuadMesh) -> Self {
        let angle = quads.faces().flat_map(|f| corner_angles(corners(quads, f))).collect();
        Self {
            scaled_jacobian: FaceMap::from_fn(quads.face_count(), |f| scaled_jacobian(corners(quads, f))),
            angle,
            edge_length: EdgeMap::from_fn(quads.edge_count(), |e| {
                let [a, b] = quads.ends(e).map(|v| quads.position(v));
                a.distance(b)
            }),
        }
    }

    /// Measures over all quads.
    pub fn summary(&self) -> QualitySummary {
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
        let deviation: Vec<f64> = self.angle.values().iter().map(|a| (a - 90.0).abs()).collect();
        let (jacobian, length) = (self.scaled_jacobian.values(), self.edge_length.values());
        let edge_mean = mean(length);
        let variance = mean(&length.iter().map(|l| (l - edge_mean).powi(2)).collect::<Vec<_>>());
        QualitySummary {
            scaled_jacobian_min: jacobian.iter().copied().fold(f64::INFINITY, f64::min),
            scaled_jacobian_mean: mean(jacobian),
            inverted: jacobian.iter().filter(|&&j| j <= 0.0).count(),
            angle_mean: mean(&deviation),
            angle_max: deviation.iter().copied().fold(0.0, f64::max),
            edge_mean,
            edge_variation: variance.sqrt() / edge_mean.max(f64::MIN_POSITIVE),
        }
    }
}

/// Irregular vertices: interior ones by valence, and the number of boundary vertices without two quads.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct IrregularVertices {
    /// Interior vertices of each valence but four.
    pub by_valence: BTreeMap<usize, usize>,
    /// Number of irregular interior vertices.
    pub interior: usize,
    /// Boundary vertices that do not have two quads.
    pub boundary: usize,
}

impl IrregularVertices {
    /// Counts the irregular vertices of a mesh.
    pub fn of(quads: &QuadMesh) -> Self {
        let mut found = Self::default();
        for v in quads.vertices() {
            let faces = quads.outgoing(v).count();
            if quads.is_boundary_vertex(v) {
                found.boundary += usize::from(faces != 2);
            } else if faces != 4 {
                *found.by_valence.entry(faces).or_default() += 1;
                found.interior += 1;
            }
        }
        found
    }
}

/// Mean and largest of some distances, per cent of the reference's bounding-box diagonal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Deviation {
    /// Mean.
    pub mean: f64,
    /// Largest.
    pub max: f64,
}

/// Distances between quads and the surface they stand for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Distances {
    /// From the quads to the reference.
    pub to_reference: Deviation,
    /// From the reference to the quads.
    pub from_reference: Deviation,
    /// From the reference's sharp features to the quads' edges; `None` without such features.
    pub feature: Option<Deviation>,
    /// Between the boundaries, both ways; `None` where the reference or the quads have none.
    pub boundary: Option<Deviation>,
}

/// Points sampled on either surface, about: enough for the second digit of the mean.
const SURFACE_SAMPLES: usize = 50_000;

/// The same for each quad at most: a surface of a thousand crumbs would else be sampled a thousand times over.
const SAMPLES_PER_QUAD: usize = 100;

/// Samples per edge of curves.
const EDGE_SAMPLES: usize = 5;

impl Distances {
    /// Samples the distances.
    ///
    /// # Errors     never for a valid quad mesh: only where its split into triangles is not a mesh
    /// # Cost       a closest-point query per vertex, about 100,000 more at most, 200 for each quad of few; in parallel
    pub fn measure(quads: &QuadMesh, reference: &Reference) -> Result<Self, MeshError> {
        let unit = 100.0 / reference.mesh.diagonal().max(f64::MIN_POSITIVE);
        let ours = split_at_centres(quads)?;
        let our_tree = ClosestPoint::new(&ours);
        let samples = SURFACE_SAMPLES.min(SAMPLES_PER_QUAD * quads.face_count());
        let feature = sharp_samples(reference);
        let our_edges: Vec<([DVec3; 2], bool)> =
            quads.edges().map(|e| (quads.ends(e).map(|v| quads.position(v)), false)).collect();
        let feature = (!feature.is_empty()).then(|| {
            let index = PolylineIndex::new(&our_edges);
            Deviation::of(&feature, unit, |p| index.query_any(p).map_or(f64::INFINITY, |c| c.distance))
        });
        Ok(Self {
            to_reference: Deviation::of(&surface_samples(&ours, samples), unit, |p| {
                reference.closest.query(p).distance
            }),
            from_reference: Deviation::of(&surface_samples(reference.mesh, samples), unit, |p| {
                our_tree.query(p).distance
            }),
            feature,
            boundary: boundary_deviation(quads, reference.mesh, unit),
        })
    }
}

impl Deviation {
    fn of(points: &[DVec3], unit: f64, distance: impl Fn(DVec3) -> f64 + Sync) -> Self {
        let list: Vec<f64> = points.par_iter().map(|&p| distance(p) * unit).collect();
        let max = list.iter().copied().fold(0.0, f64::max);
        Self { mean: list.iter().sum::<f64>() / list.len().max(1) as f64, max }
    }
}

/// Quads that face against the reference, ascending.
///
/// # Cost       one to five closest-point queries per quad, in parallel
pub fn facing_against(quads: &QuadMesh, reference: &Reference) -> Vec<FaceId> {
    let all: Vec<FaceId> = quads.faces().collect();
    let against = |f: &FaceId| {
        let corner = corners(quads, *f);
        let centre = corner.iter().sum::<DVec3>() / 4.0;
        reference.faces_against(corner, reference.closest.query(centre).point.face)
    };
    all.into_par_iter().filter(against).collect()
}

/// Four triangles around the centre of each quad: always a mesh, and fair to both diagonals.
pub fn split_at_centres(quads: &QuadMesh) -> Result<TriMesh, MeshError> {
    let mut positions = quads.positions().values().to_vec();
    let mut faces = Vec::with_capacity(4 * quads.face_count());
    for f in quads.faces() {
        let centre = positions.len() as u32;
        positions.push(corners(quads, f).iter().sum::<DVec3>() / 4.0);
        let v = quads.face_vertices(f).map(|v| v.0);
        faces.extend((0..4).map(|k| [v[k], v[(k + 1) % 4], centre]));
    }
    TriMesh::new(positions, &faces)
}

/// About so many points spread by area over a mesh, at fixed places, and its vertices.
fn surface_samples(mesh: &TriMesh, samples: usize) -> Vec<DVec3> {
    let density = samples as f64 / mesh.area().max(f64::MIN_POSITIVE);
    let mut points = mesh.positions().values().to_vec();
    let (mut due, mut taken) = (0.0, 0usize);
    for f in mesh.faces() {
        due += density * mesh.vector_area(f).length();
        let [a, b, c] = mesh.face_vertices(f).map(|v| mesh.position(v));
        while (taken as f64) + 0.5 < due {
            // The R2 sequence: evenly spread without a random generator.
            let n = taken as f64;
            let (mut s, mut t) =
                ((0.5 + n * 0.754_877_666_246_692_7).fract(), (0.5 + n * 0.569_840_290_998_053_2).fract());
            if s + t > 1.0 {
                (s, t) = (1.0 - s, 1.0 - t);
            }
            points.push(a + (b - a) * s + (c - a) * t);
            taken += 1;
        }
    }
    points
}

fn sharp_samples(reference: &Reference) -> Vec<DVec3> {
    let (mesh, features) = (reference.mesh, reference.features);
    let is_sharp = |c: u32| features.chains[c as usize].kind == FeatureKind::Sharp;
    mesh.edges()
        .filter(|&e| features.chain_of[e].is_some_and(is_sharp))
        .flat_map(|e| edge_samples(mesh.ends(e).map(|v| mesh.position(v))))
        .collect()
}

fn edge_samples([a, b]: [DVec3; 2]) -> impl Iterator<Item = DVec3> {
    (0..EDGE_SAMPLES).map(move |k| a.lerp(b, k as f64 / (EDGE_SAMPLES - 1) as f64))
}

fn boundary_deviation(quads: &QuadMesh, mesh: &TriMesh, unit: f64) -> Option<Deviation> {
    let ours = loop_positions(&boundary_loops(quads), |h| quads.position(quads.origin(h)));
    let theirs = loop_positions(&boundary_loops(mesh), |h| mesh.position(mesh.origin(h)));
    if ours.is_empty() || theirs.is_empty() {
        return None;
    }
    let one_way = |from: &[(Vec<DVec3>, bool)], to: &[(Vec<DVec3>, bool)]| {
        let index = PolylineIndex::new(to);
        let points: Vec<DVec3> = from
            .iter()
            .flat_map(|(p, _)| (0..p.len()).flat_map(|k| edge_samples([p[k], p[(k + 1) % p.len()]])))
            .collect();
        Deviation::of(&points, unit, |p| index.query_any(p).map_or(f64::INFINITY, |c| c.distance))
    };
    let (a, b) = (one_way(&ours, &theirs), one_way(&theirs, &ours));
    Some(Deviation { mean: 0.5 * (a.mean + b.mean), max: a.max.max(b.max) })
}

fn loop_positions(loops: &[Vec<HalfEdgeId>], at: impl Fn(HalfEdgeId) -> DVec3) -> Vec<(Vec<DVec3>, bool)> {
    loops.iter().map(|l| (l.iter().map(|&h| at(h)).collect(), true)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadloom_mesh::FeatureGraph;

    fn at(x: f64, y: f64) -> DVec3 {
        DVec3::new(x, y, 0.0)
    }

    #[test]
    fn known_quads() {
        let square = [at(0., 0.), at(2., 0.), at(2., 1.), at(0., 1.)];
        assert!((scaled_jacobian(square) - 1.0).abs() < 1e-15);
        let rhombus = [at(0., 0.), at(2., 0.), at(3., 3f64.sqrt()), at(1., 3f64.sqrt())];
        assert!((scaled_jacobian(rhombus) - 60f64.to_radians().sin()).abs() < 1e-12);
        assert!((corner_angles(rhombus)[1] - 120.0).abs() < 1e-9);
        let dart = [at(0., 0.), at(1., 0.2), at(2., 0.), at(1., 2.)];
        assert!(scaled_jacobian(dart) < 0.0);
        // Against the other order of corners a square is as good: facing is another question.
        assert!((scaled_jacobian([square[3], square[2], square[1], square[0]]) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn distance_of_a_shifted_square_is_the_shift() {
        let plane = |z: f64| [at(0., 0.), at(1., 0.), at(1., 1.), at(0., 1.)].map(|p| p + DVec3::Z * z).to_vec();
        let mesh = TriMesh::new(plane(0.0), &[[0, 1, 2], [0, 2, 3]]).unwrap();
        let quads = QuadMesh::new(plane(0.1), &[[0, 1, 2, 3]]).unwrap();
        let features = FeatureGraph::none(&mesh);
        let reference = Reference::new(&mesh, &features);
        let d = Distances::measure(&quads, &reference).unwrap();
        let expected = 10.0 / 2f64.sqrt();
        for x in [d.to_reference.mean, d.to_reference.max, d.from_reference.mean, d.boundary.unwrap().max] {
            assert!((x - expected).abs() < 1e-9, "{x} {expected}");
        }
        assert_eq!(d.feature, None);
        assert!(facing_against(&quads, &reference).is_empty());
        let turned = QuadMesh::new(plane(0.1), &[[3, 2, 1, 0]]).unwrap();
        assert_eq!(facing_against(&turned, &reference), [FaceId(0)]);
    }

    #[test]
    fn histogram_counts_everything() {
        let h = Histogram::of(&[-1.0, 0.0, 0.49, 0.5, 1.0, 7.0], 0.0, 1.0, 2);
        assert_eq!(h.counts, [3, 3]);
    }
}
