//! Points of the skin: where rays from a tube's axis leave the field.
//!
//! In: a map, its curves, a [`Field`]. Out: [`Skin`]: the point and normal at (u, v) of a quarter-tube.
//! Holds: glued sides of quarter-tubes have the same rays; rays of one quarter-tube do not cross inside the tube. Not: that
//! tubes keep clear of each other. Source: [Razafindrazaka2015] §9.4, Fig. 9.11.
//!
//! At the junction (u = 0) rays fan out in the plane between two tubes, from pole to pole; farther out they stand
//! perpendicular on the axis. In between, over the arc length in which tubes part, directions are blended.

use super::curve::{Curve, Station};
use super::field::Field;
use crate::ids::{FlagId, FlagMap};
use crate::map::{Reflection, RegularMap};
use crate::skeleton::{Skeleton, edge_flags, upright_flags};
use glam::DVec3;
use quadloom_mesh::Id;
use std::f64::consts::{PI, TAU};
/// Length of a junction relative to how far its skin reaches along the tube; below 1 rays would cross inside it.
const JUNCTION_LENGTH: f64 = 1.6;
/// The same, in radii, where it does not reach along the tube at all.
const JUNCTION_MARGIN: f64 = 0.8;
/// Junctions end here at the latest, as a share of half a tube.
const LONGEST_JUNCTION: f64 = 0.9;
/// Pieces along half a tube at most.
const MOST_STEPS: usize = 48;

/// How a quarter-tube lies in space.
#[derive(Clone, Copy, Debug)]
struct Quarter {
    edge: usize,
    /// Whether the edge's curve starts at the flag's vertex.
    starts: bool,
    /// +1 where the line v = 0 runs along the curve's front, −1 where it runs opposite.
    front: f64,
    vertex: usize,
    pole: DVec3,
    /// Between this tube and the next one on the face's side.
    bisector: DVec3,
    /// Over this arc length directions are blended.
    parting: f64,
}

/// The skin of tubes.
#[derive(Clone, Debug)]
pub(super) struct Skin {
    curves: Vec<Curve>,
    field: Field,
    radius: f64,
    quarters: FlagMap<Quarter>,
    /// Edges at each vertex, each once.
    edges_at: Vec<Vec<usize>>,
    /// Farthest that a ray can go.
    reach: f64,
}

impl Skin {
    /// The skin at this radius; `None` where tubes are shorter than their junctions need.
    pub(super) fn new(
        map: &RegularMap,
        skeleton: &Skeleton,
        curves: &[Curve],
        radius: f64,
        softness: f64,
    ) -> Option<Self> {
        let mut edges_at = vec![Vec::new(); map.vertex_count()];
        map.flags().for_each(|f| edges_at[map.vertex(f).index()].push(map.edge(f).index()));
        for list in &mut edges_at {
            list.sort_unstable();
            list.dedup();
        }
        let field = Field::new(curves, radius, softness);
        let quarters = quarters(map, skeleton, curves);
        let reach = curves.iter().map(Curve::length).fold(4.0 * radius, f64::max);
        let mut skin = Self { curves: curves.to_vec(), field, radius, quarters, edges_at, reach };
        for flag in map.flags() {
            let sides = [flag, map.reflect(flag, Reflection::R2)];
            let extent = sides.iter().map(|&f| skin.extent(f)).fold(0.0, f64::max);
            let parting = JUNCTION_LENGTH * extent + JUNCTION_MARGIN * radius;
            skin.quarters[flag].parting = parting;
            if parting > LONGEST_JUNCTION * 0.5 * curves[skin.quarters[flag].edge].length() {
                return None;
            }
        }
        Some(skin)
    }

    /// How far the skin over the junction's side of a quarter-tube reaches along the tube.
    fn extent(&self, flag: FlagId) -> f64 {
        let quarter = &self.quarters[flag];
        let tangent = leaving(&self.curves, quarter);
        let along = |v: f64| {
            let (start, direction) = self.ray(flag, 0.0, v);
            self.leave(quarter.vertex, start, direction) * direction.dot(tangent)
        };
        [0.0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0].map(along).into_iter().fold(0.0, f64::max)
    }

    /// Pieces along and around a quarter-tube that follow its bends.
    pub(super) fn steps(&self) -> [usize; 2] {
        let longest = self.curves.iter().map(Curve::length).fold(0.0, f64::max);
        [((0.5 * longest / self.radius).ceil() as usize).clamp(8, MOST_STEPS), 10]
    }

    pub(super) fn radius(&self) -> f64 {
        self.radius
    }

    /// The point at (u, v) of a quarter-tube.
    pub(super) fn point(&self, flag: FlagId, u: f64, v: f64) -> DVec3 {
        let (start, direction) = self.ray(flag, u, v);
        start + direction * self.leave(self.quarters[flag].vertex, start, direction)
    }

    /// The outward unit normal there: against the gradient of the field.
    pub(super) fn normal(&self, flag: FlagId, u: f64, v: f64) -> DVec3 {
        let (start, direction) = self.ray(flag, u, v);
        let vertex = self.quarters[flag].vertex;
        let at = start + direction * self.leave(vertex, start, direction);
        let h = 1e-4 * self.radius;
        let slope = |axis: DVec3| self.value(vertex, at - h * axis) - self.value(vertex, at + h * axis);
        DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z)).normalize_or(direction)
    }

    fn ray(&self, flag: FlagId, u: f64, v: f64) -> (DVec3, DVec3) {
        let quarter = &self.quarters[flag];
        let (station, arc) = self.station(quarter, u);
        let front = quarter.front * station.front;
        let side = front.cross(station.tangent);
        let blend = smooth((arc / quarter.parting).min(1.0));
        let pole = quarter.pole.lerp(front, blend).normalize_or(front);
        let across = quarter.bisector.lerp(side, blend).normalize_or(side);
        let (sin, cos) = (PI * v).sin_cos();
        // Both ends of the fan are the poles exactly.
        let direction = if v == 0.0 {
            pole
        } else if v == 1.0 {
            -pole
        } else {
            cos * pole + sin * across
        };
        (station.point, direction.normalize_or(across))
    }

    /// The axis at u, with the tangent away from the flag's vertex, and the arc length from there.
    fn station(&self, quarter: &Quarter, u: f64) -> (Station, f64) {
        let curve = &self.curves[quarter.edge];
        let half = 0.5 * curve.length();
        // The junction, however short, gets its share of u.
        let slope = (1.2 * quarter.parting / half).clamp(0.08, 1.0);
        let arc = half * u * (slope + (1.0 - slope) * u);
        let mut station = curve.at(if quarter.starts { arc } else { curve.length() - arc });
        if !quarter.starts {
            station.tangent = -station.tangent;
        }
        (station, arc)
    }

    fn value(&self, vertex: usize, at: DVec3) -> f64 {
        self.edges_at[vertex].iter().map(|&e| self.field.of_edge(e, at)).sum()
    }

    /// Distance at which a ray from the axis first leaves the level: steps, then halving.
    fn leave(&self, vertex: usize, start: DVec3, direction: DVec3) -> f64 {
        let level = self.field.level();
        let inside = |t: f64| self.value(vertex, start + t * direction) > level;
        let step = 0.2 * self.radius;
        let (mut low, mut high) = (0.0, step);
        while inside(high) && high < self.reach {
            (low, high) = (high, high + step);
        }
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if inside(middle) { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }
}

/// 0 at 0, 1 at 1, flat at both.
fn smooth(t: f64) -> f64 {
    t * t * (3.0 - 2.0 * t)
}

fn quarters(map: &RegularMap, skeleton: &Skeleton, curves: &[Curve]) -> FlagMap<Quarter> {
    use Reflection::{R0, R2};
    let upright = upright_flags(map);
    let nothing =
        Quarter { edge: 0, starts: true, front: 1.0, vertex: 0, pole: DVec3::Z, bisector: DVec3::X, parting: 1.0 };
    let mut quarters = FlagMap::from_vec(vec![nothing; map.order()]);
    for (edge, first) in edge_flags(map) {
        // The line v = 0 of a flag goes on as v = 1 of its r₀-neighbour and is v = 1 of its r₂-neighbour.
        let around = [(first, true, 1.0), (map.reflect(first, R0), false, -1.0), (map.reflect(first, R2), true, -1.0)];
        let last = (map.walk(first, &[R0, R2]), false, 1.0);
        for (flag, starts, front) in around.into_iter().chain([last]) {
            let vertex = map.vertex(flag).index();
            let pole = if upright[flag] { skeleton.normals[vertex] } else { -skeleton.normals[vertex] };
            quarters[flag] = Quarter { edge: edge.index(), starts, front, vertex, pole, ..nothing };
        }
    }
    for flag in map.flags() {
        quarters[flag].bisector = bisector(map, curves, &quarters, flag);
    }
    quarters
}

fn leaving(curves: &[Curve], quarter: &Quarter) -> DVec3 {
    curves[quarter.edge].leaving()[usize::from(!quarter.starts)]
}

/// The direction midway between a tube and the next one on the face's side, as seen along the pole, and as high above the
/// junction's plane as both are on average.
fn bisector(map: &RegularMap, curves: &[Curve], quarters: &FlagMap<Quarter>, flag: FlagId) -> DVec3 {
    let next = map.reflect(flag, Reflection::R1);
    let pole = quarters[flag].pole;
    let [a, b] = [flag, next].map(|f| leaving(curves, &quarters[f]));
    let flat = |t: DVec3| (t - pole * pole.dot(t)).normalize_or(pole.any_orthonormal_vector());
    let (x, y) = (flat(a), pole.cross(flat(a)));
    // Counter-clockwise about the pole of the flag, which for an overturned flag is the back.
    let angle = flat(b).dot(y).atan2(flat(b).dot(x)).rem_euclid(TAU);
    let (sin, cos) = (0.5 * angle).sin_cos();
    let height = 0.5 * (pole.dot(a) + pole.dot(b));
    (cos * x + sin * y) * (1.0 - height * height).max(0.0).sqrt() + height * pole
}
