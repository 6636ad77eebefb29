//! Shape operators of geodesic disks, principal curvatures, salient directions.
//!
//! In: a triangle mesh, radii. Out: [`Curvature`] per face, [`salient_directions`].
//! Holds: a face's operator is symmetric and finite; a salient direction is stable over an interval of radii.
//! Not: convergence under every refinement (the edge-based estimate needs disks of several edges).
//! Source: [CohenSteiner2003] (normal cycle: an edge contributes β·|e ∩ B|·ē·ēᵀ); [Bommes2012] §8.1.
//!
//! | paper | here | meaning | unit |
//! |---|---|---|---|
//! | S_r | [`Curvature`] | shape operator of the disk of radius r | 1/length |
//! | τ | [`Curvature::anisotropy`] | relative anisotropy of the principal curvatures | – |
//! | r_0, r_1, w | [`SalientOptions`] | radii and half-width of the interval of stability | length |
//! | τ_min, K | [`SalientOptions`] | least anisotropy, least mean curvature | –, 1/length |

use crate::system::neighbours;
use glam::{DMat3, DVec2, DVec3};
use quadloom_mesh::metric::FaceFrame;
use quadloom_mesh::{FaceId, FaceMap, Progress, TriMesh};
use rayon::prelude::*;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Faces of a disk at most, so that cost stays linear where the mesh is much finer than the radius.
///
/// 300 faces are a disk of about nine edge lengths; larger disks are cut off there, and say less about finer detail.
const DISK_FACES: usize = 300;

/// Shape operator of a face in its frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Curvature {
    /// Principal curvatures, |max| ≥ |min|, 1/length; positive where the surface is convex.
    pub max: f64,
    /// See `max`.
    pub min: f64,
    /// Angle of the direction of `max` in the face's frame, radians.
    pub angle: f64,
}

impl Curvature {
    /// Relative anisotropy τ = ||κ_max| - |κ_min|| / |κ_max| in 0..=1; 0 where flat ([Bommes2012] §8.1).
    pub fn anisotropy(&self) -> f64 {
        if self.max == 0.0 { 0.0 } else { (self.max.abs() - self.min.abs()).abs() / self.max.abs() }
    }

    /// Mean curvature, 1/length.
    pub fn mean(&self) -> f64 {
        0.5 * (self.max + self.min)
    }

    /// Normal curvature of the direction at `angle` radians in the face's frame, 1/length (Euler's theorem).
    pub fn normal(&self, angle: f64) -> f64 {
        let c = (angle - self.angle).cos().powi(2);
        self.max * c + self.min * (1.0 - c)
    }

    /// From the edge sum Σ β·|e ∩ B|·ē·ēᵀ over a disk, whose eigenvectors belong to each other's curvatures.
    fn from_edge_sum(sum: DMat3, area: f64, frame: &FaceFrame) -> Self {
        if area <= 0.0 {
            return Self::default();
        }
        let entry = |u: DVec3, v: DVec3| u.dot(sum * v) / area;
        let (xx, xy, yy) = (entry(frame.x, frame.x), entry(frame.x, frame.y), entry(frame.y, frame.y));
        let (middle, spread) = (0.5 * (xx + yy), (0.25 * (xx - yy).powi(2) + xy * xy).sqrt());
        let along = 0.5 * (2.0 * xy).atan2(xx - yy);
        // An edge bends the surface across itself: the larger eigenvalue's vector is the other direction.
        let (high, low) = (middle + spread, middle - spread);
        if high.abs() >= low.abs() {
            Self { max: high, min: low, angle: along + std::f64::consts::FRAC_PI_2 }
        } else {
            Self { max: low, min: high, angle: along }
        }
    }
}

/// Shape operators of the disks of several radii around every face.
///
/// # Input      radii: ascending, file units
/// # Output     one curvature per radius and face
/// # Errors     cancellation
/// # Cost       a bounded neighbourhood search per face, in parallel; the result does not depend on the threads
/// # Source     [CohenSteiner2003]; disks by paths over face centroids
pub fn curvatures(
    mesh: &TriMesh,
    radii: &[f64],
    progress: &Progress,
) -> Result<FaceMap<Vec<Curvature>>, quadloom_mesh::Cancelled> {
    let disks = Disks::new(mesh);
    let list: Result<Vec<Vec<Curvature>>, _> = (0..mesh.face_count())
        .into_par_iter()
        .with_min_len(256)
        .map_init(
            || Scratch { members: Vec::new(), seen: vec![u32::MAX; mesh.face_count()] },
            |scratch, f| {
                if f % 256 == 0 {
                    progress.check()?;
                }
                Ok(disks.curvatures(FaceId::new(f), radii, scratch))
            },
        )
        .collect();
    list.map(FaceMap::from_vec)
}

/// What a thread keeps between disks.
struct Scratch {
    /// Faces of the disk with their distances, nearest first.
    members: Vec<(f64, FaceId)>,
    /// Centre of the last disk that a face belonged to.
    seen: Vec<u32>,
}

/// What every disk of a mesh needs.
struct Disks<'a> {
    mesh: &'a TriMesh,
    centroid: FaceMap<DVec3>,
    area: FaceMap<f64>,
    /// Half of Σ β·|e|·ē·ēᵀ over the sides of each face, so that an edge inside a disk counts once.
    edges: FaceMap<DMat3>,
}

impl<'a> Disks<'a> {
    fn new(mesh: &'a TriMesh) -> Self {
        let normal = FaceMap::from_fn(mesh.face_count(), |f| mesh.face_normal(f));
        let edges = FaceMap::from_fn(mesh.face_count(), |f| {
            let mut sum = DMat3::ZERO;
            for h in mesh.face_half_edges(f) {
                let Some(t) = mesh.twin(h) else { continue };
                let along = mesh.position(mesh.target(h)) - mesh.position(mesh.origin(h));
                let (length, unit) = (along.length(), along.normalize_or_zero());
                let (m, n) = (normal[f], normal[mesh.face(t)]);
                // Positive where the surface is convex: the normals open away from each other.
                let beta = m.cross(n).dot(unit).atan2(m.dot(n));
                sum += 0.5 * beta * length * outer(unit);
            }
            sum
        });
        Self {
            mesh,
            centroid: FaceMap::from_fn(mesh.face_count(), |f| {
                mesh.face_vertices(f).into_iter().map(|v| mesh.position(v)).sum::<DVec3>() / 3.0
            }),
            area: FaceMap::from_fn(mesh.face_count(), |f| mesh.vector_area(f).length()),
            edges,
        }
    }

    /// Curvatures of the disks around a face, by faces in the order of their distance.
    fn curvatures(&self, centre: FaceId, radii: &[f64], scratch: &mut Scratch) -> Vec<Curvature> {
        self.find_members(centre, radii.last().copied().unwrap_or(0.0), scratch);
        let members = &scratch.members;
        let frame = FaceFrame::of(self.mesh, centre);
        let (mut sum, mut area, mut at) = (DMat3::ZERO, 0.0, 0);
        let mut result = Vec::with_capacity(radii.len());
        for &radius in radii {
            while at < members.len() && members[at].0 <= radius {
                sum += self.edges[members[at].1];
                area += self.area[members[at].1];
                at += 1;
            }
            result.push(Curvature::from_edge_sum(sum, area, &frame));
        }
        result
    }

    /// Faces whose centroid is within reach over a path of centroids, nearest first.
    fn find_members(&self, centre: FaceId, reach: f64, scratch: &mut Scratch) {
        scratch.members.clear();
        let mut heap = BinaryHeap::from([Reverse((Distance(0.0), centre.0))]);
        while let Some(Reverse((Distance(d), f))) = heap.pop() {
            if std::mem::replace(&mut scratch.seen[f as usize], centre.0) == centre.0 {
                continue;
            }
            let f = FaceId(f);
            scratch.members.push((d, f));
            if scratch.members.len() == DISK_FACES {
                break;
            }
            for g in neighbours(self.mesh, f).filter(|g| scratch.seen[g.index()] != centre.0) {
                // Paths over centroids zigzag; the straight distance is better until the surface bends.
                let path = d + self.centroid[f].distance(self.centroid[g]);
                let next = path.min(self.centroid[centre].distance(self.centroid[g]).max(d));
                if next <= reach {
                    heap.push(Reverse((Distance(next), g.0)));
                }
            }
        }
    }
}

fn outer(u: DVec3) -> DMat3 {
    DMat3::from_cols(u * u.x, u * u.y, u * u.z)
}

#[derive(Clone, Copy, PartialEq)]
struct Distance(f64);
impl Eq for Distance {}
impl PartialOrd for Distance {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Distance {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

/// Which directions are salient ([Bommes2012] §8.1, with its defaults).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SalientOptions {
    /// Smallest radius r_0, file units. The average edge length of the mesh.
    pub smallest_radius: f64,
    /// Largest radius r_1, file units. The target edge length h.
    pub largest_radius: f64,
    /// Half-width w of the interval over which a disk must be stable, file units. A quarter of the target edge length.
    pub half_width: f64,
    /// Least relative anisotropy τ_min. 0.8; smaller: directions near umbilics, larger: fewer constraints.
    pub min_anisotropy: f64,
    /// Least mean curvature K, 1/length: 0.1 over the radius of a bounding sphere.
    pub min_mean_curvature: f64,
    /// Largest spread of the direction within the interval, radians. π/12: noise turns directions by more.
    pub max_spread: f64,
}

impl SalientOptions {
    /// The thesis' values for a mesh and a target edge length, file units.
    pub fn new(mesh: &TriMesh, target: f64) -> Self {
        let edges = mesh.edge_count().max(1) as f64;
        let total: f64 = mesh
            .edges()
            .map(|e| {
                let [a, b] = mesh.ends(e);
                mesh.position(a).distance(mesh.position(b))
            })
            .sum();
        let smallest_radius = total / edges;
        Self {
            smallest_radius,
            largest_radius: target.max(smallest_radius),
            half_width: 0.25 * target,
            min_anisotropy: 0.8,
            min_mean_curvature: 0.1 / (0.5 * mesh.diagonal()).max(f64::MIN_POSITIVE),
            max_spread: std::f64::consts::PI / 12.0,
        }
    }
}

/// A direction that the surface itself suggests.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SalientDirection {
    /// Angle in the face's frame, radians.
    pub angle: f64,
    /// Relative anisotropy at the chosen radius.
    pub anisotropy: f64,
    /// Largest deviation of the direction within the interval of radii, radians: smaller is more stable.
    pub spread: f64,
}

/// Radii per interval of half-width w: enough that an unstable disk does not slip between two of them.
const RADII_PER_INTERVAL: usize = 3;

/// Principal directions that are stable over an interval of radii; `None` where the surface suggests nothing.
///
/// A disk is valid if all disks within ±w of its radius are anisotropic (τ ≥ τ_min) and curved (|H| ≥ K); of the valid
/// ones the one with the most stable direction is taken.
///
/// # Errors     cancellation
/// # Cost       see [`curvatures`]
/// # Source     [Bommes2012] §8.1; differs: directions whose spread exceeds `max_spread` are dropped
pub fn salient_directions(
    mesh: &TriMesh,
    options: &SalientOptions,
    progress: &Progress,
) -> Result<FaceMap<Option<SalientDirection>>, quadloom_mesh::Cancelled> {
    // 1. Radii from r_0 - w to r_1 + w in steps of w / RADII_PER_INTERVAL.
    let step = (options.half_width / RADII_PER_INTERVAL as f64).max(1e-9 * options.largest_radius);
    let first = (options.smallest_radius - options.half_width).max(0.25 * options.smallest_radius);
    let count = (((options.largest_radius + options.half_width - first) / step).ceil().max(0.0) as usize).min(64) + 1;
    let radii: Vec<f64> = (0..count).map(|k| first + step * k as f64).collect();
    let all = curvatures(mesh, &radii, progress)?;
    // 2. The most stable valid radius of each face.
    Ok(all.map(|list| most_stable(list, &radii, options)))
}

fn most_stable(list: &[Curvature], radii: &[f64], options: &SalientOptions) -> Option<SalientDirection> {
    let valid =
        |c: &Curvature| c.anisotropy() >= options.min_anisotropy && c.mean().abs() >= options.min_mean_curvature;
    let mut best: Option<SalientDirection> = None;
    for (k, c) in list.iter().enumerate() {
        let inside = radii[k] >= options.smallest_radius - 1e-12 && radii[k] <= options.largest_radius + 1e-12;
        let (low, high) = (k.saturating_sub(RADII_PER_INTERVAL), (k + RADII_PER_INTERVAL).min(list.len() - 1));
        let interval = &list[low..=high];
        if !inside || !interval.iter().all(valid) {
            continue;
        }
        let spread = interval.iter().map(|other| line_angle(other.angle - c.angle)).fold(0.0, f64::max);
        if spread <= options.max_spread && best.is_none_or(|b| spread < b.spread) {
            best = Some(SalientDirection { angle: c.angle, anisotropy: c.anisotropy(), spread });
        }
    }
    best
}

/// Size of an angle between lines, radians in 0..=π/2.
fn line_angle(angle: f64) -> f64 {
    let unit = DVec2::from_angle(2.0 * angle);
    0.5 * unit.y.atan2(unit.x).abs()
}

/// Curvature of every face at one radius, for sizing.
pub fn curvature_at(
    mesh: &TriMesh,
    radius: f64,
    progress: &Progress,
) -> Result<FaceMap<Curvature>, quadloom_mesh::Cancelled> {
    let all = curvatures(mesh, &[radius], progress)?;
    Ok(all.map(|list| list[0]))
}
