//! Features that quads would cut off: curves with fewer quads along them than their shape and length ask for.
//!
//! In: the features of a motorcycle graph, lengths of edges in quads, integers. Out: rows that ask for as many quads as
//! bring the chords near the curve. Holds: no row asks for more quads than the curve is long. Not: that the rows can be
//! met; they are wishes.
//! Source: ours; [Bommes2012] §8.3 aligns the map with features and leaves how many quads they get to rounding.

use crate::fans::undistorted;
use crate::place::Form;
use crate::problem::FaceGradient;
use crate::tmesh::TMesh;
use glam::DVec3;
use quadloom_mesh::{FaceMap, TriMesh};
use quadloom_numeric::{IntegerProblem, IntegerSum, LowerBound};

/// Distance of a curve from its chords, in quads, beyond which more of them are asked for.
///
/// Smaller: more curves are stretched; larger: bores become polygons of few sides.
const CUT_OFF: f64 = 0.15;

/// Quads beyond which a curve is never cut off by much: rounding takes away few.
const MOST_QUADS: f64 = 40.0;

/// A feature from one integer vertex to the next, or once around.
pub(crate) struct Curve {
    /// Its vertices, the first one again at the end of a closed one; in quads.
    points: Vec<DVec3>,
    /// Length up to each of them.
    at: Vec<f64>,
    /// Quads along it.
    quads: IntegerSum,
}

/// Curves whose number of quads is a matter of integers.
pub(crate) fn curves(
    mesh: &TriMesh,
    gradient: &FaceMap<FaceGradient>,
    tmesh: &TMesh,
    problem: &IntegerProblem,
) -> Vec<Curve> {
    let over = |form: &Form| problem.over_integers(form.iter().map(|&(i, c)| (i as usize, f64::from(c))));
    let mut curves = Vec::new();
    for curve in &tmesh.curves {
        let Some(quads) = over(&curve.form).filter(|sum| !sum.terms.is_empty()) else { continue };
        let mut end = DVec3::ZERO;
        let (mut points, mut at) = (vec![end], vec![0.0]);
        for &h in &curve.sides {
            let along = mesh.position(mesh.target(h)) - mesh.position(mesh.origin(h));
            let length = undistorted(mesh, gradient, h)[0].length();
            end += along.normalize_or_zero() * length;
            points.push(end);
            at.push(at[at.len() - 1] + length);
        }
        if at[at.len() - 1] <= MOST_QUADS {
            curves.push(Curve { points, at, quads });
        }
    }
    curves
}

impl Curve {
    /// The row that asks for enough quads; `None` where these integers give them.
    pub fn wish(&self, z: &[f64]) -> Option<LowerBound> {
        let length = self.at[self.at.len() - 1];
        let quads = self.quads.value(z).round();
        if quads < 1.0 || quads + 1.0 > length || self.cut_off(quads as usize) <= CUT_OFF {
            return None;
        }
        let enough = (quads as usize + 1..=length as usize).find(|&n| self.cut_off(n) <= CUT_OFF)?;
        Some(LowerBound { terms: self.quads.terms.clone(), least: enough as f64 - self.quads.constant })
    }

    /// Largest distance of a vertex from the chord over it where this many quads share the length equally.
    fn cut_off(&self, quads: usize) -> f64 {
        let length = self.at[self.at.len() - 1];
        let mut largest = 0.0_f64;
        let mut next = 0;
        for k in 0..quads {
            let [from, to] = [k, k + 1].map(|k| length * k as f64 / quads as f64);
            let [a, b] = [self.point(from), self.point(to)];
            let along = (b - a).normalize_or_zero();
            while next < self.at.len() && self.at[next] <= to {
                let p = self.points[next] - a;
                largest = largest.max((p - along * p.dot(along).clamp(0.0, a.distance(b))).length());
                next += 1;
            }
        }
        largest
    }

    /// The point at a length along the curve.
    fn point(&self, at: f64) -> DVec3 {
        let k = self.at.partition_point(|&a| a <= at).clamp(1, self.at.len() - 1);
        let part = (at - self.at[k - 1]) / (self.at[k] - self.at[k - 1]).max(f64::MIN_POSITIVE);
        self.points[k - 1].lerp(self.points[k], part.clamp(0.0, 1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// A curve through points, whose number of quads is the only integer.
    fn through(points: Vec<DVec3>) -> Curve {
        let mut at = vec![0.0];
        for pair in points.windows(2) {
            at.push(at[at.len() - 1] + pair[0].distance(pair[1]));
        }
        Curve { points, at, quads: IntegerSum { terms: vec![(0, 1.0)], constant: 0.0 } }
    }

    fn bore(corners: usize, length: f64) -> Curve {
        let point = |k: usize| DVec3::from((glam::DVec2::from_angle(TAU * (k % corners) as f64 / corners as f64), 0.0));
        let curve = through((0..=corners).map(point).collect());
        let scale = length / curve.at[corners];
        through(curve.points.iter().map(|&p| p * scale).collect())
    }

    #[test]
    fn chords_of_a_circle_are_as_far_as_their_sagitta() {
        let (curve, radius) = (bore(3600, 12.0), 12.0 / TAU);
        for n in 3..20 {
            let sagitta = radius * (1.0 - (TAU / (2.0 * n as f64)).cos());
            assert!((curve.cut_off(n) - sagitta).abs() < 1e-3, "{n}: {} {sagitta}", curve.cut_off(n));
        }
    }

    #[test]
    fn a_bore_cut_off_asks_for_more_quads_and_never_for_more_than_it_is_long() {
        let row = bore(16, 10.85).wish(&[6.0]).expect("six chords are 0.23 quads away");
        assert_eq!((row.least, &row.terms[..]), (8.0, &[(0, 1.0)][..]));
        assert_eq!(bore(16, 10.85).wish(&[8.0]), None);
        // Four quads cut off a small one, too, but it has no room for five.
        assert!(bore(16, 4.5).cut_off(4) > CUT_OFF);
        assert_eq!(bore(16, 4.5).wish(&[4.0]), None);
    }

    #[test]
    fn straight_features_may_have_few_quads() {
        assert_eq!(through(vec![DVec3::ZERO, DVec3::X * 3.0, DVec3::X * 9.0]).wish(&[1.0]), None);
    }
}
