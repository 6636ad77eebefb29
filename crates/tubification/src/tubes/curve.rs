//! The centre line of a tube with its frame.
//!
//! In: the edges' polylines. Out: [`Curve`]s: points at even arc length, tangents, and the direction of the front line.
//! Holds: the same curve, walked from the other end, has the same points and frames up to rounding; curves of one skeleton
//! are rounded alike, until tubes can follow their bends. Not: that there is room for the tubes.
//! Source: [Razafindrazaka2015] §9.4, "the normals along each segment are interpolated from the junctions"; the
//! rotation-minimising frame is the double reflection of [Wang2008].

use glam::{DQuat, DVec3};
use std::f64::consts::PI;

/// Points put on each segment of the polyline before it is measured.
const SUBDIVISION: usize = 8;

/// Points per tube radius while corners are rounded, and per curve at most.
const FINENESS: f64 = 4.0;
const MOST_POINTS: usize = 600;

/// Bends are rounded until the radius of curvature is this many tube radii: below 1 tubes pinch, at 1 they have a crease.
const BEND: f64 = 1.5;

/// Roundings at most; each spreads a corner by about a fifth of the radius in the square.
const ROUNDINGS: usize = 400;

/// Turns of a polyline next to its end above this angle, radians, are corners: the curve leaves along the first segment.
const CORNER: f64 = 0.6;

/// Share of the radius by which segments may be off a curve, and segments at most.
const SAGITTA: f64 = 0.004;
const MOST_SEGMENTS: usize = 160;

/// Segments at least: a half twist turns by 11° on each.
const LEAST_SEGMENTS: usize = 16;

/// Turning of a whole curve, radians, below which it is straight.
const STRAIGHT: f64 = 1e-7;

/// Twists this close to a half-turn are half-turns, and right-handed: seen from both ends they are then the same.
const HALF_TURN: f64 = 1e-6;

/// A smooth curve, from the start of an edge to its end.
#[derive(Clone, Debug)]
pub(super) struct Curve {
    points: Vec<DVec3>,
    tangents: Vec<DVec3>,
    fronts: Vec<DVec3>,
    length: f64,
    straight: bool,
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
    fn through(points: Vec<DVec3>, radius: f64) -> Self {
        let length = arc_lengths(&points)[points.len() - 1];
        let turning: f64 = points.windows(3).map(turn).sum();
        let wanted = (length * turning / (8.0 * SAGITTA * radius)).sqrt().ceil();
        let segments = (wanted as usize).clamp(LEAST_SEGMENTS, MOST_SEGMENTS);
        let points = even(&points, segments);
        let tangents = tangents(&points);
        let fronts = tangents.iter().map(|t| t.any_orthonormal_vector()).collect();
        Self { points, tangents, fronts, length, straight: turning < STRAIGHT }
    }

    /// Frames from the front at the start to the front at the end, both made perpendicular to the curve: the
    /// rotation-minimising frame and the least uniform twist; of two half-turns the right-handed one.
    pub(super) fn framed(mut self, start: DVec3, end: DVec3) -> Self {
        let last = self.points.len() - 1;
        self.fronts[0] = across(start, self.tangents[0]);
        for i in 0..last {
            self.fronts[i + 1] = self.transported(i);
        }
        let twist = angle_about(self.tangents[last], self.fronts[last], across(end, self.tangents[last]));
        let twist = if twist < HALF_TURN - PI { twist + 2.0 * PI } else { twist };
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

    /// Points that the segments between them follow the curve through: the two ends where it is straight.
    pub(super) fn points(&self) -> Vec<DVec3> {
        match self.straight {
            true => vec![self.points[0], self.points[self.points.len() - 1]],
            false => self.points.clone(),
        }
    }

    /// Directions at the start and, backwards, at the end.
    pub(super) fn leaving(&self) -> [DVec3; 2] {
        [self.tangents[0], -self.tangents[self.tangents.len() - 1]]
    }

    /// The point at an arc length from the start.
    pub(super) fn at(&self, arc: f64) -> Station {
        let last = self.points.len() - 1;
        let x = (arc / self.length).clamp(0.0, 1.0) * last as f64;
        let i = (x as usize).min(last - 1);
        let t = x - i as f64;
        let tangent = self.tangents[i].lerp(self.tangents[i + 1], t).normalize_or(self.tangents[i]);
        let front = across(self.fronts[i].lerp(self.fronts[i + 1], t), tangent);
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

/// The curves along polylines, for tubes of a radius. They have no frames yet.
///
/// # Errors     the number of a polyline without length
pub(super) fn along(lines: &[Vec<DVec3>], radius: f64) -> Result<Vec<Curve>, usize> {
    let smooth = |(k, line): (usize, &Vec<DVec3>)| {
        let line = distinct(line);
        if line.len() < 2 { Err(k) } else { Ok(through_all(&line)) }
    };
    let fine = |line: Vec<DVec3>| {
        let wanted = FINENESS * arc_lengths(&line)[line.len() - 1] / radius;
        even(&line, (wanted.ceil() as usize).clamp(16, MOST_POINTS))
    };
    let mut fine: Vec<Vec<DVec3>> =
        lines.iter().enumerate().map(smooth).map(|line| line.map(fine)).collect::<Result<_, _>>()?;
    for _ in 0..ROUNDINGS {
        if fine.iter().all(|line| least_bend(line) >= BEND * radius) {
            break;
        }
        fine.iter_mut().for_each(|line| round(line));
    }
    Ok(fine.into_iter().map(|line| Curve::through(line, radius)).collect())
}

/// The least radius of curvature of a polyline with even steps.
fn least_bend(line: &[DVec3]) -> f64 {
    line.windows(3).map(|p| 0.5 * p[0].distance(p[2]) / turn(p)).fold(f64::INFINITY, f64::min)
}

/// Moves points half-way to the middle of their neighbours; the ends stay.
fn round(line: &mut [DVec3]) {
    let moved: Vec<DVec3> = line.windows(3).map(|p| 0.5 * p[1] + 0.25 * (p[0] + p[2])).collect();
    line[1..=moved.len()].copy_from_slice(&moved);
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

/// A smooth curve through the points of a polyline: centripetal Catmull-Rom, which does not overshoot at corners.
fn through_all(line: &[DVec3]) -> Vec<DVec3> {
    let knots: Vec<f64> = line.windows(2).map(|p| p[0].distance(p[1]).sqrt()).collect();
    let slopes = slopes(line, &knots);
    let mut points = vec![line[0]];
    for (i, &h) in knots.iter().enumerate() {
        for k in 1..=SUBDIVISION {
            let t = k as f64 / SUBDIVISION as f64;
            let (a, b) = ((1.0 - t) * (1.0 - t) * t * h, (t - 1.0) * t * t * h);
            let blend = t * t * (3.0 - 2.0 * t);
            points.push(line[i].lerp(line[i + 1], blend) + a * slopes[i] + b * slopes[i + 1]);
        }
    }
    points
}

/// Derivatives at the points of a polyline, of the parabolas through three points.
fn slopes(line: &[DVec3], knots: &[f64]) -> Vec<DVec3> {
    let chords: Vec<DVec3> = line.windows(2).zip(knots).map(|(p, h)| (p[1] - p[0]) / h).collect();
    let last = chords.len() - 1;
    if last == 0 {
        return vec![chords[0]; 2];
    }
    let end = |near: usize, far: usize, turn: f64| {
        let corner = (1.0 - (turn / CORNER).powi(2)).max(0.0);
        chords[near] + (chords[near] - chords[far]) * (corner * knots[near] / (knots[near] + knots[far]))
    };
    let inner = (0..last).map(|i| (chords[i] * knots[i + 1] + chords[i + 1] * knots[i]) / (knots[i] + knots[i + 1]));
    let [first, final_] = [&line[..3], &line[last - 1..]].map(turn);
    std::iter::once(end(0, 1, first)).chain(inner).chain(std::iter::once(end(last, last - 1, final_))).collect()
}

fn arc_lengths(points: &[DVec3]) -> Vec<f64> {
    let mut arc = vec![0.0];
    arc.extend(points.windows(2).map(|p| p[0].distance(p[1])));
    for i in 1..arc.len() {
        arc[i] += arc[i - 1];
    }
    arc
}

/// The angle between two segments.
fn turn(p: &[DVec3]) -> f64 {
    let (a, b) = (p[1] - p[0], p[2] - p[1]);
    a.cross(b).length().atan2(a.dot(b))
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

/// Directions at the points of a polyline with even steps; at the ends those of the parabolas.
fn tangents(points: &[DVec3]) -> Vec<DVec3> {
    let last = points.len() - 1;
    if last == 1 {
        return vec![(points[1] - points[0]).normalize(); 2];
    }
    let end = |a: DVec3, b: DVec3, c: DVec3| (4.0 * b - 3.0 * a - c).normalize_or(DVec3::X);
    let first = end(points[0], points[1], points[2]);
    let final_ = -end(points[last], points[last - 1], points[last - 2]);
    let inner = points.windows(3).map(|p| (p[2] - p[0]).normalize_or(first));
    std::iter::once(first).chain(inner).chain(std::iter::once(final_)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn helix(reverse: bool) -> Vec<DVec3> {
        let at = |i: i32| DVec3::new((0.2 * i as f64).cos(), (0.2 * i as f64).sin(), 0.1 * i as f64);
        let points = (0..=20).map(at);
        if reverse { points.rev().collect() } else { points.collect() }
    }

    fn curve(line: &[DVec3], radius: f64) -> Curve {
        along(&[line.to_vec()], radius).unwrap().remove(0)
    }

    #[test]
    fn both_ways_are_one_curve() {
        let (one, two) = (DVec3::new(0.3, 0.4, 1.0), DVec3::new(-0.2, 1.0, 0.1));
        let there = curve(&helix(false), 0.1).framed(one, two);
        let back = curve(&helix(true), 0.1).framed(two, one);
        for k in 0..=40 {
            let arc = there.length() * k as f64 / 40.0;
            let (a, b) = (there.at(arc), back.at(there.length() - arc));
            let off = [a.point.distance(b.point), a.front.distance(b.front)];
            assert!(off[0] < 1e-12 && off[1] < 1e-9, "{k} {off:?}");
            assert!(a.front.dot(a.tangent).abs() < 1e-12);
        }
    }

    #[test]
    fn half_turns_are_right_handed() {
        let line = [DVec3::ZERO, DVec3::X];
        for (start, end) in [(DVec3::Y, -DVec3::Y), (-DVec3::Z, DVec3::Z)] {
            let curve = curve(&line, 0.1);
            assert_eq!(curve.points().len(), 2);
            let middle = curve.framed(start, end).at(0.5);
            assert!(middle.front.distance(DVec3::X.cross(start)) < 1e-9, "{middle:?}");
        }
    }

    #[test]
    fn corners_are_rounded_and_arcs_are_not() {
        let corner = curve(&[DVec3::X, DVec3::ZERO, DVec3::Y], 0.1);
        assert!(least_bend(&corner.points()) > 0.14, "{}", least_bend(&corner.points()));
        let arc: Vec<_> = (0..=16).map(|i| (i as f64 * 0.2).sin_cos()).map(|(y, x)| DVec3::new(x, y, 0.0)).collect();
        for point in curve(&arc, 0.1).points() {
            assert!((point.length() - 1.0).abs() < 1e-3, "{point}");
        }
    }
}
