//! The centre line of a tube with its frame.
//!
//! In: an edge's polyline. Out: [`Curve`]: points at even arc length, tangents, and the direction of the front line.
//! Holds: the same curve, walked from the other end, has the same points and frames up to rounding.
//! Source: [Razafindrazaka2015] §9.4, "the normals along each segment are interpolated from the junctions"; the
//! rotation-minimising frame is the double reflection of [Wang2008].

use glam::{DQuat, DVec3};
use std::f64::consts::PI;

/// Points put on each segment of the polyline before it is measured.
const SUBDIVISION: usize = 8;

/// Segments of a curve at most; beyond it the polyline shows on tubes that are thick compared with their bends.
const MOST_SEGMENTS: usize = 96;

/// Segments of a curve at least: frames turn evenly from one to the next, also about a straight line.
const LEAST_SEGMENTS: usize = 24;

/// Turning of a whole curve, radians, below which it is straight.
const STRAIGHT: f64 = 1e-7;

/// Twists this close to a half-turn are half-turns, and right-handed: seen from both ends they are then the same.
const HALF_TURN: f64 = 1e-6;

/// A smooth curve, from the start of an edge to its end.
#[derive(Clone, Debug)]
pub(super) struct Curve {
    points: Vec<DVec3>,
    tangents: Vec<DVec3>,
    /// Rotation-minimising from the front at the start.
    fronts: Vec<DVec3>,
    /// Turn of the front about the tangent at the end, radians; uniform along the curve.
    twist: f64,
    length: f64,
}

/// A point of a curve with its frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Station {
    pub(super) point: DVec3,
    pub(super) tangent: DVec3,
    /// Unit, perpendicular to the tangent: on the front line.
    pub(super) front: DVec3,
}

impl Curve {
    /// The smooth curve through the points of a polyline, as segments that are at most about `sagitta` off; none where its
    /// length is zero. It has no frame yet.
    pub(super) fn through(line: &[DVec3], sagitta: f64) -> Option<Self> {
        let line = distinct(line);
        if line.len() < 2 {
            return None;
        }
        let slopes = slopes(&line);
        let dense = refine(&line, &slopes);
        let length = arc_lengths(&dense)[dense.len() - 1];
        let turning = turning(&dense);
        let wanted = (length * turning / (8.0 * sagitta)).sqrt().ceil();
        let segments = (wanted as usize).clamp(LEAST_SEGMENTS, MOST_SEGMENTS);
        let points = even(&dense, segments);
        let ends = [slopes[0], slopes[slopes.len() - 1]].map(DVec3::normalize);
        let tangents = tangents(&points, ends);
        let fronts = tangents.iter().map(|t| t.any_orthonormal_vector()).collect();
        Some(Self { points, tangents, fronts, twist: 0.0, length })
    }

    /// Frames from the front at the start to the front at the end, both made perpendicular to the curve: the
    /// rotation-minimising frame and the least uniform twist; of two half-turns the right-handed one. The mean of both ways
    /// along the curve, so that neither end is preferred.
    pub(super) fn framed(self, start: DVec3, end: DVec3) -> Self {
        let there = self.clone().framed_from(start, end);
        let mut back = self.clone();
        back.points.reverse();
        back.tangents.reverse();
        back.tangents.iter_mut().for_each(|t| *t = -*t);
        let back = back.framed_from(end, start);
        let means = there.fronts.iter().zip(back.fronts.iter().rev()).zip(&self.tangents);
        let fronts = means.map(|((a, b), &t)| across(*a + *b, t)).collect();
        Self { fronts, ..self }
    }

    fn framed_from(mut self, start: DVec3, end: DVec3) -> Self {
        let last = self.points.len() - 1;
        self.fronts[0] = across(start, self.tangents[0]);
        for i in 0..last {
            self.fronts[i + 1] = self.transported(i);
        }
        let twist = angle_about(self.tangents[last], self.fronts[last], across(end, self.tangents[last]));
        let twist = if twist < 1e-6 - PI { twist + 2.0 * PI } else { twist };
        for i in 0..=last {
            let turn = DQuat::from_axis_angle(self.tangents[i], twist * i as f64 / last as f64);
            self.fronts[i] = across(turn * self.fronts[i], self.tangents[i]);
        }
        self
    }

    /// Arc length.
    pub(super) fn length(&self) -> f64 {
        self.length
    }

    /// Points between which the curve is straight, ends included.
    pub(super) fn points(&self) -> Vec<DVec3> {
        if self.straight { vec![self.points[0], self.points[self.points.len() - 1]] } else { self.points.clone() }
    }

    /// Directions at the start and, backwards, at the end.
    pub(super) fn leaving(&self) -> [DVec3; 2] {
        [self.tangents[0], -self.tangents[self.tangents.len() - 1]]
    }

    /// The point at an arc length from the start.
    pub(super) fn at(&self, arc: f64) -> Station {
        let last = self.points.len() - 1;
        let part = (arc / self.length).clamp(0.0, 1.0);
        let x = part * last as f64;
        let i = (x as usize).min(last - 1);
        let t = x - i as f64;
        let tangent = self.tangents[i].lerp(self.tangents[i + 1], t).normalize_or(self.tangents[i]);
        let carried = across(self.fronts[i].lerp(self.fronts[i + 1], t), tangent);
        let front = DQuat::from_axis_angle(tangent, self.twist * part) * carried;
        Station { point: self.points[i].lerp(self.points[i + 1], t), tangent, front }
    }

    /// The double reflection of [Wang2008] from point i to the next.
    fn transported(&self, i: usize) -> DVec3 {
        let step = self.points[i + 1] - self.points[i];
        let mirrored = |v: DVec3, m: DVec3| v - m * (2.0 * m.dot(v) / m.length_squared().max(f64::MIN_POSITIVE));
        let (front, tangent) = (mirrored(self.fronts[i], step), mirrored(self.tangents[i], step));
        mirrored(front, self.tangents[i + 1] - tangent)
    }
}

/// The part of a direction perpendicular to a tangent, as a unit vector.
fn across(direction: DVec3, tangent: DVec3) -> DVec3 {
    let part = direction - tangent * direction.dot(tangent);
    if part.length() > 1e-9 { part.normalize() } else { tangent.any_orthonormal_vector() }
}

/// The angle about an axis from one direction to another, in (−π, π].
fn angle_about(axis: DVec3, from: DVec3, to: DVec3) -> f64 {
    axis.dot(from.cross(to)).atan2(from.dot(to))
}

fn distinct(line: &[DVec3]) -> Vec<DVec3> {
    let size: f64 = line.windows(2).map(|p| p[0].distance(p[1])).sum();
    let mut kept: Vec<DVec3> = Vec::with_capacity(line.len());
    for &point in line {
        if kept.last().is_none_or(|before| before.distance(point) > 1e-9 * size) {
            kept.push(point);
        }
    }
    kept
}

/// Derivatives by chord length at the points of a polyline, of the parabolas through three points.
fn slopes(line: &[DVec3]) -> Vec<DVec3> {
    let steps: Vec<f64> = line.windows(2).map(|p| p[0].distance(p[1])).collect();
    let chords: Vec<DVec3> = line.windows(2).zip(&steps).map(|(p, h)| (p[1] - p[0]) / h).collect();
    let last = chords.len() - 1;
    let end = |near: usize, far: usize| {
        chords[near] + (chords[near] - chords[far]) * (steps[near] / (steps[near] + steps[far]))
    };
    if last == 0 {
        return vec![chords[0]; 2];
    }
    let inner = (0..last).map(|i| (chords[i] * steps[i + 1] + chords[i + 1] * steps[i]) / (steps[i] + steps[i + 1]));
    std::iter::once(end(0, 1)).chain(inner).chain(std::iter::once(end(last, last - 1))).collect()
}

/// Points of the cubic curve with these slopes.
fn refine(line: &[DVec3], slopes: &[DVec3]) -> Vec<DVec3> {
    let mut points = vec![line[0]];
    for i in 0..line.len() - 1 {
        let h = line[i].distance(line[i + 1]);
        for k in 1..=SUBDIVISION {
            let t = k as f64 / SUBDIVISION as f64;
            let (a, b) = ((1.0 - t) * (1.0 - t) * t * h, (t - 1.0) * t * t * h);
            let blend = t * t * (3.0 - 2.0 * t);
            points.push(line[i].lerp(line[i + 1], blend) + a * slopes[i] + b * slopes[i + 1]);
        }
    }
    points
}

fn arc_lengths(points: &[DVec3]) -> Vec<f64> {
    let mut arc = vec![0.0];
    arc.extend(points.windows(2).map(|p| p[0].distance(p[1])));
    for i in 1..arc.len() {
        arc[i] += arc[i - 1];
    }
    arc
}

fn turning(points: &[DVec3]) -> f64 {
    let angle = |p: &[DVec3]| (p[1] - p[0]).cross(p[2] - p[1]).length().atan2((p[1] - p[0]).dot(p[2] - p[1]));
    points.windows(3).map(angle).sum()
}

/// Points of a polyline at even arc lengths.
fn even(dense: &[DVec3], segments: usize) -> Vec<DVec3> {
    let arc = arc_lengths(dense);
    let last = dense.len() - 1;
    let place = |k: usize| {
        let at = arc[last] * k as f64 / segments as f64;
        let i = arc.partition_point(|&a| a < at).clamp(1, last);
        dense[i - 1].lerp(dense[i], (at - arc[i - 1]) / (arc[i] - arc[i - 1]))
    };
    let inner = (1..segments).map(place);
    std::iter::once(dense[0]).chain(inner).chain(std::iter::once(dense[last])).collect()
}

fn tangents(points: &[DVec3], ends: [DVec3; 2]) -> Vec<DVec3> {
    let inner = points.windows(3).map(|p| (p[2] - p[0]).normalize_or(ends[0]));
    std::iter::once(ends[0]).chain(inner).chain(std::iter::once(ends[1])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn helix(reverse: bool) -> Vec<DVec3> {
        let at = |i: i32| DVec3::new((0.2 * i as f64).cos(), (0.2 * i as f64).sin(), 0.1 * i as f64);
        let points = (0..=20).map(at);
        if reverse { points.rev().collect() } else { points.collect() }
    }

    #[test]
    fn both_ways_are_one_curve() {
        let (one, two) = (DVec3::new(0.3, 0.4, 1.0), DVec3::new(-0.2, 1.0, 0.1));
        let there = Curve::through(&helix(false), 1e-3).unwrap().framed(one, two);
        let back = Curve::through(&helix(true), 1e-3).unwrap().framed(two, one);
        for k in 0..=40 {
            let arc = there.length() * k as f64 / 40.0;
            let (a, b) = (there.at(arc), back.at(there.length() - arc));
            assert!(a.point.distance(b.point) < 1e-12 && a.front.distance(b.front) < 1e-9, "{k}");
            assert!(a.front.dot(a.tangent).abs() < 1e-12);
        }
    }

    #[test]
    fn half_turns_are_right_handed() {
        let line = [DVec3::ZERO, DVec3::X];
        for (start, end) in [(DVec3::Y, -DVec3::Y), (-DVec3::Z, DVec3::Z)] {
            let curve = Curve::through(&line, 1e-3).unwrap();
            assert_eq!(curve.points().len(), 2);
            let middle = curve.framed(start, end).at(0.5);
            assert!(middle.front.distance(DVec3::X.cross(start)) < 1e-9, "{middle:?}");
        }
    }
}
