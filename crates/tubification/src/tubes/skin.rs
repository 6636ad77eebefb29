//! The skin of the tubes: where rays from centre lines leave the field.
//!
//! In: a map, its skeleton, a radius. Out: [`Skin`]: the place of every point of a quarter-tube.
//! Holds: only edges at a common junction blend; half-way along, a tube is its own edge's alone, so both halves meet
//! smoothly. Rays of one quarter-tube fan out, so points keep their order while a junction ends before the middle of its
//! tubes. Source: [Razafindrazaka2015] §9.4, Fig. 9.11, with a blending field for a body.

use super::curve::{Curve, Station};
use super::field::Field;
use super::junction::{Rims, Spokes};
use crate::skeleton::{Skeleton, first_flags, starts_here, upright_flags};
use glam::DVec3;
use quadloom_mesh::Id;
use quadloom_regular_maps::ids::{FlagId, FlagMap};
use quadloom_regular_maps::map::{Reflection, RegularMap};
use std::f64::consts::PI;

/// Where rays become perpendicular to a tube, relative to how far its junction reaches along it. At 1 rays from next to the
/// vertex meet on the skin; larger crowds the middle of the tube.
const JUNCTION_LENGTH: f64 = 1.5;

/// The same, at least, where tubes are short.
const SHORTEST_JUNCTION: f64 = 1.15;

/// Junctions end here at the latest, as a part of the half tube.
const LONGEST_JUNCTION: f64 = 0.9;

/// Where along a half tube the other edges of its junction begin to fade out.
const FADE_FROM: f64 = 0.5;

/// Least speed along a tube at its junction, relative to even.
const LEAST_SLOPE: f64 = 0.25;

/// Step in which a ray looks for the skin, in radii.
const RAY_STEP: f64 = 0.35;

/// Steps of a ray at most: beyond it the junction is larger than any that tubes of this radius can be parted at.
const RAY_STEPS: usize = 400;

/// The map, its curves and the field around them.
pub(super) struct Skin<'a> {
    map: &'a RegularMap,
    skeleton: &'a Skeleton,
    curves: &'a [Curve],
    field: Field,
    radius: f64,
    upright: FlagMap<bool>,
    /// Edges at each vertex, each once.
    stars: Vec<Vec<usize>>,
    spokes: Spokes,
}

/// What a ray from a tube's centre line sees.
struct Sight<'a> {
    star: &'a [usize],
    /// The edge that always counts in full; none at a junction.
    own: Option<usize>,
    /// Weight of the others.
    others: f64,
}

impl<'a> Skin<'a> {
    pub(super) fn new(
        map: &'a RegularMap,
        skeleton: &'a Skeleton,
        curves: &'a [Curve],
        radius: f64,
        softness: f64,
    ) -> Self {
        Self {
            map,
            skeleton,
            curves,
            field: Field::new(curves, radius, softness),
            radius,
            upright: upright_flags(map),
            stars: stars(map),
            spokes: Spokes::new(map, skeleton, curves, radius),
        }
    }

    pub(super) fn map(&self) -> &'a RegularMap {
        self.map
    }

    pub(super) fn is_upright(&self, flag: FlagId) -> bool {
        self.upright[flag]
    }

    pub(super) fn spokes(&self) -> &Spokes {
        &self.spokes
    }

    /// The normal of a flag's vertex.
    pub(super) fn normal(&self, flag: FlagId) -> DVec3 {
        self.skeleton.normals[self.map.vertex(flag).index()]
    }

    /// How far the skin is from a flag's vertex in a direction.
    pub(super) fn reach_at_junction(&self, flag: FlagId, direction: DVec3) -> f64 {
        let vertex = self.map.vertex(flag).index();
        let sight = Sight { star: &self.stars[vertex], own: None, others: 1.0 };
        self.reach(&sight, self.skeleton.positions[vertex], direction)
    }

    /// The point at u along the tube, at the j-th of the rim's rows around it.
    ///
    /// # Input      `junction`: [`Self::junction_length`] of the flag
    pub(super) fn point(&self, flag: FlagId, u: f64, j: usize, rims: &Rims, junction: f64) -> DVec3 {
        let rim = rims.arc(flag);
        let vertex = self.map.vertex(flag).index();
        if u == 0.0 {
            return self.skeleton.positions[vertex] + rim[j];
        }
        let edge = self.map.edge(flag).index();
        let along = self.along(edge, u, junction);
        let (station, side) = self.station(flag, along);
        let (sin, cos) = (PI * j as f64 / (rim.len() - 1) as f64).sin_cos();
        let ring = self.radius * (cos * station.front + sin * side);
        let ray = rim[j].lerp(ring, (along / junction).min(1.0)).normalize_or(ring.normalize());
        let others = 1.0 - smooth((u - FADE_FROM) / (1.0 - FADE_FROM));
        let sight = Sight { star: &self.stars[vertex], own: Some(edge), others };
        station.point + ray * self.reach(&sight, station.point, ray)
    }

    /// Arc length from a junction. However short, it gets its share of u: what is drawn on the surface is drawn evenly in u.
    fn along(&self, edge: usize, u: f64, junction: f64) -> f64 {
        let half = 0.5 * self.curves[edge].length();
        let slope = (junction / half).clamp(LEAST_SLOPE, 1.0);
        half * u * (slope + (1.0 - slope) * u)
    }

    /// Where along a flag's tube, from its vertex, rays are perpendicular to it: the same on both sides of the tube. None
    /// where that is beyond the middle.
    pub(super) fn junction_length(&self, flag: FlagId, rims: &Rims) -> Option<f64> {
        let spoke = self.spokes.of(flag);
        let both = [flag, self.map.reflect(flag, Reflection::R2)];
        let extent = both.iter().flat_map(|&f| rims.arc(f)).map(|p| p.dot(spoke)).fold(0.0, f64::max);
        let longest = 0.5 * LONGEST_JUNCTION * self.curves[self.map.edge(flag).index()].length();
        (extent * SHORTEST_JUNCTION < longest).then(|| (extent * JUNCTION_LENGTH).max(self.radius).min(longest))
    }

    /// The tube at a distance from a flag's vertex: walked outwards, its front on the side of P1, and the direction to the
    /// side of the flag's face.
    fn station(&self, flag: FlagId, along: f64) -> (Station, DVec3) {
        let curve = &self.curves[self.map.edge(flag).index()];
        let start = starts_here(self.map, flag);
        let at = curve.at(if start { along } else { curve.length() - along });
        // Fronts are those of upright flags at the start; there a half tube's line v = 0 is the other half's line v = 1.
        let from_start = if start { flag } else { self.map.reflect(flag, Reflection::R0) };
        let upright = if self.upright[from_start] == start { 1.0 } else { -1.0 };
        let tangent = if start { at.tangent } else { -at.tangent };
        let front = upright * at.front;
        (Station { point: at.point, tangent, front }, front.cross(tangent))
    }

    /// The length of a ray inside the skin.
    fn reach(&self, sight: &Sight, from: DVec3, direction: DVec3) -> f64 {
        let excess = |t: f64| self.excess(sight, from + t * direction);
        let step = RAY_STEP * self.radius;
        let mut near = 0.0;
        for _ in 0..RAY_STEPS {
            let far = near + step;
            if excess(far) < 0.0 {
                return root(excess, near, far, 1e-13 * self.radius);
            }
            near = far;
        }
        near
    }

    /// The field over its level on the skin.
    fn excess(&self, sight: &Sight, at: DVec3) -> f64 {
        let weight = |edge: usize| if sight.own == Some(edge) { 1.0 } else { sight.others };
        let value = |&edge: &usize| match weight(edge) {
            0.0 => 0.0,
            w => w * self.field.of_edge(edge, at),
        };
        sight.star.iter().map(value).sum::<f64>() - self.field.level()
    }
}

/// The edges at each vertex, each once.
fn stars(map: &RegularMap) -> Vec<Vec<usize>> {
    let star = |first: FlagId| {
        let turn = |&flag: &FlagId| Some(map.walk(flag, &[Reflection::R1, Reflection::R2]));
        let flags = std::iter::successors(Some(first), turn).take(map.q());
        let mut edges: Vec<_> = flags.map(|flag| map.edge(flag).index()).collect();
        edges.sort_unstable();
        edges.dedup();
        edges
    };
    first_flags(map).into_iter().map(|(_, first)| star(first)).collect()
}

/// 0 until 0, 1 from 1, twice continuously differentiable.
fn smooth(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * x * (10.0 + x * (6.0 * x - 15.0))
}

/// The zero between `low`, where a function is positive, and `high`, where it is negative: false position in the Illinois
/// variant, made safe by bisection.
fn root(f: impl Fn(f64) -> f64, low: f64, high: f64, width: f64) -> f64 {
    let (mut a, mut b, mut fa, mut fb) = (low, high, f(low), f(high));
    if fa <= 0.0 {
        return a;
    }
    let mut kept = 0;
    for k in 0..100 {
        let secant = b - fb * (b - a) / (fb - fa);
        let x = if k % 4 == 3 || !(a < secant && secant < b) { 0.5 * (a + b) } else { secant };
        let fx = f(x);
        // The end that is kept twice pulls half as much.
        if fx >= 0.0 {
            fb *= if kept == 1 { 0.5 } else { 1.0 };
            (a, fa, kept) = (x, fx, 1);
        } else {
            fa *= if kept == -1 { 0.5 } else { 1.0 };
            (b, fb, kept) = (x, fx, -1);
        }
        if b - a < width || fx == 0.0 {
            return x;
        }
    }
    0.5 * (a + b)
}

#[cfg(test)]
mod tests {
    use super::root;

    #[test]
    fn zeros_of_flat_and_steep_functions() {
        let near = |found: f64, wanted: f64| assert!((found - wanted).abs() < 1e-9, "{found} {wanted}");
        near(root(|x| 2.0 - x * x, 0.0, 3.0, 1e-12), 2f64.sqrt());
        near(root(|x| (1.25 - x).powi(3), 0.0, 3.0, 1e-12), 1.25);
        near(root(|x| (1.0 - x).tanh() + 0.25, 0.0, 3.0, 1e-12), 1.0 + 0.25f64.atanh());
    }
}
