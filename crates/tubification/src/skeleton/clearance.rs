//! How thick the tubes around a skeleton can be.
//!
//! In: a map and its [`Skeleton`]. Out: [`clearance`], a tube radius relative to the size of the skeleton.
//! Holds: it does not change under rotation, translation and scaling. Not: a proof that the tube surface has no
//! self-intersection; near junctions it depends on how the surface is made there.
//!
//! A radius is too large where two points of the skeleton are closer than two radii, unless they are neighbours along the
//! skeleton. Points of two edges in the quarters next to a common junction are neighbours as long as the edges part there
//! about as fast as they leave; points of one edge are, until it has turned by π between them.

use super::{Skeleton, edge_flags, other_end};
use glam::DVec3;
use quadloom_mesh::Id;
use quadloom_regular_maps::ids::{FlagId, MapEdgeId};
use quadloom_regular_maps::map::RegularMap;
use std::f64::consts::PI;

/// How much slower than straight lines in their first directions edges may part near a junction. At 1 bends to each other
/// count as contact, at 3 even a swirl does not.
const PARTING_SLACK: f64 = 1.5;

/// The part of an edge, at each end, in which the tubes at a junction may still be one.
const JUNCTION_PART: f64 = 0.25;

/// Radius of the thickest tubes relative to the radius of the skeleton's extent about its centre.
///
/// # Output     min of half the distance of points that are no neighbours and of the radius of curvature, divided by the
///   radius of [`extent`]; 0 where edges cross
/// # Cost       quadratic in the number of points
pub fn clearance(map: &RegularMap, skeleton: &Skeleton) -> f64 {
    clearance_above(map, skeleton, 0.0).unwrap_or(0.0)
}

/// The clearance where it is larger than `floor`; stops as soon as it cannot be.
pub(super) fn clearance_above(map: &RegularMap, skeleton: &Skeleton, floor: f64) -> Option<f64> {
    let size = extent(skeleton).1;
    if size <= 0.0 || size.is_nan() {
        return None;
    }
    let ropes = Rope::all(map, skeleton);
    let mut least = ropes.iter().map(Rope::curvature_radius).fold(size, f64::min);
    for (k, a) in ropes.iter().enumerate() {
        least = least.min(within(a));
        for b in &ropes[..k] {
            least = least.min(between(a, b, least));
            if least <= floor * size {
                return None;
            }
        }
    }
    (least > floor * size).then_some(least / size)
}

/// Centre (mean of the edges' points by length) and radius of a skeleton.
pub fn extent(skeleton: &Skeleton) -> (DVec3, f64) {
    let mut sum = DVec3::ZERO;
    let mut length = 0.0;
    for pair in skeleton.edges.iter().flat_map(|edge| edge.windows(2)) {
        let l = pair[0].distance(pair[1]);
        sum += 0.5 * l * (pair[0] + pair[1]);
        length += l;
    }
    let centre = if length > 0.0 { sum / length } else { DVec3::ZERO };
    let points = skeleton.edges.iter().flatten();
    (centre, points.map(|p| p.distance(centre)).fold(0.0, f64::max))
}

/// An edge with arc lengths.
struct Rope<'a> {
    points: &'a [DVec3],
    /// Arc length from the start, per point.
    arc: Vec<f64>,
    ends: [usize; 2],
    /// Directions in which it leaves its ends.
    leaving: [DVec3; 2],
    centre: DVec3,
    radius: f64,
}

/// A point of an edge as seen from the nearer end.
struct Foot {
    vertex: usize,
    side: usize,
    /// Distance along the edge, and as a fraction of the edge.
    arc: f64,
    part: f64,
}

impl<'a> Rope<'a> {
    fn all(map: &RegularMap, skeleton: &'a Skeleton) -> Vec<Self> {
        let make = |(edge, flag): (MapEdgeId, FlagId)| {
            let ends = [map.vertex(flag).index(), other_end(map, flag).index()];
            Self::new(&skeleton.edges[edge.index()], ends)
        };
        edge_flags(map).into_iter().map(make).collect()
    }

    fn new(points: &'a [DVec3], ends: [usize; 2]) -> Self {
        let mut arc = vec![0.0];
        arc.extend(points.windows(2).map(|pair| pair[0].distance(pair[1])));
        for i in 1..arc.len() {
            arc[i] += arc[i - 1];
        }
        let centre = points.iter().sum::<DVec3>() / points.len() as f64;
        let radius = points.iter().map(|p| p.distance(centre)).fold(0.0, f64::max);
        let last = points.len() - 1;
        let leaving = [points[1] - points[0], points[last - 1] - points[last]].map(DVec3::normalize_or_zero);
        Self { points, arc, ends, leaving, centre, radius }
    }

    fn length(&self) -> f64 {
        self.arc[self.arc.len() - 1]
    }

    fn foot(&self, arc: f64) -> Foot {
        let back = self.length() - arc;
        let side = usize::from(arc > back);
        let arc = arc.min(back);
        Foot { vertex: self.ends[side], side, arc, part: arc / self.length() }
    }

    fn curvature_radius(&self) -> f64 {
        self.points.windows(3).map(|p| bend_radius(p[0], p[1], p[2])).fold(f64::INFINITY, f64::min)
    }
}

/// Turns from this angle, radians, are hairpins: rounding, which cures sharper bends between even segments, takes away much
/// of a rope there.
const HAIRPIN: f64 = 1.8;

/// Radius of the bend at the middle one of three points: of the circle through them, or of the largest that touches both
/// segments within the shorter half, which a hairpin with one long side needs.
fn bend_radius(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let (u, v) = (b - a, c - b);
    let area = u.cross(v).length();
    if area <= 1e-12 * u.length() * v.length() && u.dot(v) >= 0.0 {
        return f64::INFINITY;
    }
    let circle = u.length() * v.length() * (u + v).length() / (2.0 * area);
    let turn = area.atan2(u.dot(v));
    let touching = 0.5 * u.length().min(v.length()) / (0.5 * turn).tan();
    if turn > HAIRPIN { circle.min(touching) } else { circle }
}

/// Bound that two edges set each other, as far as it is below `least`.
fn between(a: &Rope, b: &Rope, least: f64) -> f64 {
    let mut bound = f64::INFINITY;
    if 0.5 * (a.centre.distance(b.centre) - a.radius - b.radius) > least {
        return bound;
    }
    for i in 0..a.points.len() - 1 {
        for j in 0..b.points.len() - 1 {
            let (p, q) = ([a.points[i], a.points[i + 1]], [b.points[j], b.points[j + 1]]);
            let (s, t) = closest(p, q);
            let half = 0.5 * p[0].lerp(p[1], s).distance(q[0].lerp(q[1], t));
            if half < bound.min(least) {
                let x = a.foot(a.arc[i] + s * (a.arc[i + 1] - a.arc[i]));
                let y = b.foot(b.arc[j] + t * (b.arc[j + 1] - b.arc[j]));
                if !parts([a, b], [&x, &y], half) {
                    bound = half;
                }
            }
        }
    }
    bound
}

/// Whether two points, half their distance being `half`, are neighbours across a junction.
fn parts(ropes: [&Rope; 2], feet: [&Foot; 2], half: f64) -> bool {
    if feet[0].vertex != feet[1].vertex || (feet[0].part > JUNCTION_PART && feet[1].part > JUNCTION_PART) {
        return false;
    }
    let leaving = [0, 1].map(|k| ropes[k].leaving[feet[k].side]);
    let spoke = 0.5 * (leaving[0] - leaving[1]).length();
    // At the junction itself both sides are rounding errors.
    half + 1e-9 * ropes[0].length() >= feet[0].arc.min(feet[1].arc) * spoke / PARTING_SLACK
}

/// Bound that an edge sets itself.
fn within(a: &Rope) -> f64 {
    let mut bound = f64::INFINITY;
    for i in 0..a.points.len() {
        for j in 0..i {
            let half = 0.5 * a.points[i].distance(a.points[j]);
            let turned = half < (a.arc[i] - a.arc[j]) / PI;
            if turned && half < bound {
                let (x, y) = (a.foot(a.arc[i]), a.foot(a.arc[j]));
                if x.side == y.side || !parts([a, a], [&x, &y], half) {
                    bound = half;
                }
            }
        }
    }
    bound
}

/// Parameters of the closest points of two segments.
fn closest(p: [DVec3; 2], q: [DVec3; 2]) -> (f64, f64) {
    let (u, v, w) = (p[1] - p[0], q[1] - q[0], p[0] - q[0]);
    let (a, b, c, d, e) = (u.length_squared(), u.dot(v), v.length_squared(), u.dot(w), v.dot(w));
    let clamped = |x: f64| if x.is_finite() { x.clamp(0.0, 1.0) } else { 0.0 };
    let det = a * c - b * b;
    let s = if det > 1e-14 * a * c { clamped((b * e - c * d) / det) } else { 0.0 };
    let t = clamped((b * s + e) / c);
    (clamped((b * t - d) / a), t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closest_points_of_segments() {
        let crossing = [DVec3::new(-1.0, 0.0, 0.0), DVec3::X];
        let above = [DVec3::new(0.0, -1.0, 0.5), DVec3::new(0.0, 3.0, 0.5)];
        assert_eq!(closest(crossing, above), (0.5, 0.25));
        let parallel = [DVec3::new(3.0, 1.0, 0.0), DVec3::new(2.0, 1.0, 0.0)];
        assert_eq!(closest(crossing, parallel), (1.0, 1.0));
    }

    #[test]
    fn circle_through_three_points() {
        assert!((bend_radius(DVec3::X, DVec3::Y, -DVec3::X) - 1.0).abs() < 1e-12);
        assert_eq!(bend_radius(DVec3::ZERO, DVec3::X, 2.0 * DVec3::X), f64::INFINITY);
    }

    /// The circle through the points of a hairpin with one long side is large.
    #[test]
    fn hairpins_have_no_room() {
        let back = DVec3::new(0.92, 0.05, 0.0);
        assert!(bend_radius(DVec3::ZERO, DVec3::X, back) < 0.02);
    }
}
