//! The fixed border: parameters along the sides, and their places on a square, a polygon or a circle.
//!
//! In: a disk and, if wanted, a parameter per border vertex. Out: places of the border vertices; edges that a straight
//! side would flatten, and the mesh without them. Holds: parameters are multiples of 2⁻⁵³, so that 1 − t is exact and
//! two tiles that share a side agree along it bit for bit; border vertices of the unit square lie on it exactly.
//!
//! ```text
//!        3 ─── side 2 ─── 2          4 corners: the unit square. Others: a regular polygon in the circle of
//!        │                │          radius 1/2 about (1/2, 1/2), side 0 at the bottom. 1 or 2: the circle.
//!     side 3            side 1
//!        │                │
//!        0 ─── side 0 ─── 1
//! ```

use super::disk::{Disk, NONE};
use super::error::MapError;
use super::{Border, MapOptions};
use quadloom_mesh::refine::{Refined, split_edges};
use quadloom_mesh::{DVec2, DVec3, EdgeId, FeatureGraph, TriMesh, VertexId, VertexMap};
use std::cmp::Ordering;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Least length of a border edge as a fraction of its side.
///
/// Only shorter ones are lengthened to it. Larger: sides whose edges differ in length by more than this are distorted.
/// Smaller: the parameters of coinciding vertices come close to the 2⁻⁵³ by which they are told apart.
const LEAST_STEP: f64 = 1e-9;

/// Steps of a parameter between 0 and 1.
const STEPS: f64 = (1u64 << 53) as f64;

/// The place of every border vertex along its side: normalised arc length.
///
/// # Input      corners as for [`super::map_tile`]
/// # Output     t in 0..1 from the side's first corner; 0 at corners and inside. Edges shorter than a billionth of
/// their side count as that long
/// # Errors     no disk, or wrong corners
/// # Cost       linear
/// # Guarantees ascending along each side; a side with the same points in opposite order, in whatever mesh, has
/// exactly 1 − t: lengths are summed from the end that comes first lexicographically, and rounded to 2⁻⁵³
pub fn side_parameters(mesh: &TriMesh, corners: &[VertexId]) -> Result<VertexMap<f64>, MapError> {
    Ok(default_parameters(mesh, &Disk::new(mesh, corners)?))
}

/// Edges inside a tile with both ends on one straight side: the map would flatten their faces ([Floater2003b]).
///
/// # Input      corners as for [`super::map_tile`]; fewer than three have no straight sides
/// # Output     ascending; a corner belongs to both of its sides
/// # Errors     no disk, or wrong corners
/// # Cost       linear
pub fn edges_on_one_side(mesh: &TriMesh, corners: &[VertexId]) -> Result<Vec<EdgeId>, MapError> {
    Ok(flattened_edges(mesh, &Disk::new(mesh, corners)?))
}

/// Splits all edges inside a tile that have both ends on one straight side, at their midpoints.
///
/// # Output     the mesh of the parent's vertices followed by the midpoints; one pass leaves no such edge, as every new
/// edge has a midpoint, which is no border vertex
/// # Errors     no disk, wrong corners, or more elements than ids
/// # Cost       linear
pub fn split_side_edges(mesh: &TriMesh, features: &FeatureGraph, corners: &[VertexId]) -> Result<Refined, MapError> {
    let split: Vec<(EdgeId, f64)> = edges_on_one_side(mesh, corners)?.into_iter().map(|e| (e, 0.5)).collect();
    Ok(split_edges(mesh, features, &split)?)
}

/// Whether the sides are straight.
pub(super) fn has_straight_sides(disk: &Disk, border: Border) -> bool {
    border == Border::Polygon && disk.corner_at.len() >= 3
}

/// Edges inside with both ends on one side, for straight sides.
pub(super) fn flattened_edges(mesh: &TriMesh, disk: &Disk) -> Vec<EdgeId> {
    if !has_straight_sides(disk, Border::Polygon) {
        return Vec::new();
    }
    let side_of = sides_of_places(disk);
    let sides = |v: VertexId| (disk.place[v] != NONE).then(|| side_of[disk.place[v] as usize]);
    let share = |a: [usize; 2], b: [usize; 2]| a.iter().any(|side| b.contains(side));
    mesh.edges()
        .filter(|&e| !mesh.is_boundary_edge(e))
        .filter(|&e| matches!(mesh.ends(e).map(sides), [Some(a), Some(b)] if share(a, b)))
        .collect()
}

/// The sides of each place of the border: two different ones at corners.
fn sides_of_places(disk: &Disk) -> Vec<[usize; 2]> {
    let mut sides = vec![[0; 2]; disk.border.len()];
    for k in 0..disk.sides() {
        disk.side(k).take_while(|&at| at < disk.border.len()).for_each(|at| sides[at] = [k; 2]);
    }
    for (k, &at) in disk.corner_at.iter().enumerate() {
        sides[at] = [k, (k + disk.sides() - 1) % disk.sides()];
    }
    sides
}

/// Places of the border vertices, in their order along the border.
///
/// # Errors     parameters that are not ascending inside 0..1; flattened edges
pub(super) fn place_border(mesh: &TriMesh, disk: &Disk, options: &MapOptions) -> Result<Vec<DVec2>, MapError> {
    if disk.corner_at.is_empty() {
        return Err(MapError::NoCorner);
    }
    let parameter = match &options.side_parameters {
        Some(given) => checked_parameters(mesh, disk, given)?,
        None => default_parameters(mesh, disk),
    };
    if !has_straight_sides(disk, options.border) {
        return Ok(on_circle(mesh, disk, &parameter));
    }
    let flattened = flattened_edges(mesh, disk);
    match flattened.first() {
        Some(&edge) => Err(MapError::EdgeOnSide { edge, count: flattened.len() }),
        None => Ok(on_polygon(disk, &parameter)),
    }
}

fn on_polygon(disk: &Disk, parameter: &VertexMap<f64>) -> Vec<DVec2> {
    let corner = polygon(disk.sides());
    let mut place = vec![DVec2::ZERO; disk.border.len()];
    for k in 0..disk.sides() {
        let (p, q) = (corner[k], corner[(k + 1) % corner.len()]);
        let side = disk.side(k);
        for at in *side.start()..*side.end() {
            place[at] = p + (q - p) * parameter[disk.border[at]];
        }
    }
    place
}

/// Corners of the unit square, or of a regular polygon.
fn polygon(n: usize) -> Vec<DVec2> {
    if n == 4 {
        return [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(DVec2::from).to_vec();
    }
    let angle = |k: usize| TAU * k as f64 / n as f64 - FRAC_PI_2 - PI / n as f64;
    (0..n).map(|k| DVec2::splat(0.5) + 0.5 * DVec2::from_angle(angle(k))).collect()
}

/// Every side takes a part of the circle in proportion to its length.
fn on_circle(mesh: &TriMesh, disk: &Disk, parameter: &VertexMap<f64>) -> Vec<DVec2> {
    let lengths: Vec<f64> = (0..disk.sides()).map(|k| steps(&side_points(mesh, disk, k)).iter().sum()).collect();
    let total: f64 = lengths.iter().sum();
    let mut place = vec![DVec2::ZERO; disk.border.len()];
    let mut before = 0.0;
    for (k, length) in lengths.iter().enumerate() {
        let side = disk.side(k);
        for at in *side.start()..*side.end() {
            let turn = (before + length * parameter[disk.border[at]]) / total;
            place[at] = DVec2::splat(0.5) + 0.5 * DVec2::from_angle(TAU * turn - FRAC_PI_2);
        }
        before += length;
    }
    place
}

/// The given parameters, rounded to multiples of 2⁻⁵³.
fn checked_parameters(mesh: &TriMesh, disk: &Disk, given: &VertexMap<f64>) -> Result<VertexMap<f64>, MapError> {
    if given.len() != mesh.vertex_count() {
        return Err(MapError::SideParameterCount { found: given.len(), vertices: mesh.vertex_count() });
    }
    let mut parameter = VertexMap::filled(mesh.vertex_count(), 0.0);
    for k in 0..disk.sides() {
        let (side, mut last) = (disk.side(k), 0.0);
        for at in *side.start() + 1..*side.end() {
            let (vertex, value) = (disk.border[at], rounded(given[disk.border[at]]));
            if !(last < value && value < 1.0) {
                return Err(MapError::SideParameter { vertex, value: given[vertex] });
            }
            parameter[vertex] = value;
            last = value;
        }
    }
    Ok(parameter)
}

fn default_parameters(mesh: &TriMesh, disk: &Disk) -> VertexMap<f64> {
    let mut parameter = VertexMap::filled(mesh.vertex_count(), 0.0);
    for k in 0..disk.sides() {
        let start = *disk.side(k).start();
        for (i, t) in along(&side_points(mesh, disk, k)).into_iter().enumerate() {
            parameter[disk.at(start + i)] = t;
        }
    }
    parameter
}

fn side_points(mesh: &TriMesh, disk: &Disk, k: usize) -> Vec<DVec3> {
    disk.side(k).map(|at| mesh.position(disk.at(at))).collect()
}

/// Parameters of all points of a side but its last.
fn along(points: &[DVec3]) -> Vec<f64> {
    let last = points.len() - 1;
    if !runs_backwards(points) {
        return from_first(points)[..last].to_vec();
    }
    let reversed: Vec<DVec3> = points.iter().rev().copied().collect();
    from_first(&reversed).iter().rev().take(last).map(|t| 1.0 - t).collect()
}

/// Whether the points in opposite order come first lexicographically; no, if both orders are the same.
fn runs_backwards(points: &[DVec3]) -> bool {
    let order = |p: &DVec3, q: &DVec3| p.to_array().partial_cmp(&q.to_array()).unwrap_or(Ordering::Equal);
    let differ = points.iter().zip(points.iter().rev()).map(|(p, q)| order(p, q)).find(|o| o.is_ne());
    differ == Some(Ordering::Greater)
}

/// Arc length from the first point, in 0..=1.
fn from_first(points: &[DVec3]) -> Vec<f64> {
    let steps = steps(points);
    let total: f64 = steps.iter().sum();
    let mut sum = 0.0;
    let ends = steps.iter().map(|step| {
        sum += step;
        rounded(sum / total)
    });
    std::iter::once(0.0).chain(ends).collect()
}

/// Lengths between points, none far shorter than the whole.
fn steps(points: &[DVec3]) -> Vec<f64> {
    let lengths: Vec<f64> = points.windows(2).map(|w| w[0].distance(w[1])).collect();
    let total: f64 = lengths.iter().sum();
    let least = if total > 0.0 { LEAST_STEP * total } else { 1.0 };
    lengths.into_iter().map(|l| l.max(least)).collect()
}

/// The nearest multiple of 2⁻⁵³.
fn rounded(t: f64) -> f64 {
    (t * STEPS).round() / STEPS
}
