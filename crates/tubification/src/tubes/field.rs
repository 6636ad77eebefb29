//! The field whose level is the skin of tubes: soft junctions without a formula for each valence.
//!
//! In: edge curves as segments. Out: [`Field`]: what each edge contributes at a point.
//! Holds: the level around a straight line is the cylinder of the asked radius; an edge contributes nothing farther than
//! the support; twice continuously differentiable. Source: convolution surfaces, [Bloomenthal1991], with a kernel of
//! bounded support, as a body for [Razafindrazaka2015] Fig. 9.11.
//!
//! An edge contributes ∫ (1 − |x − γ(s)|²/R²)² ds over its part in the ball of radius R about x, scaled so that an endless
//! straight line at distance d contributes (1 − d²/R²)^{5/2}.

use super::curve::Curve;
use glam::DVec3;

/// A straight part of an edge.
#[derive(Clone, Copy, Debug)]
struct Rod {
    start: DVec3,
    direction: DVec3,
    length: f64,
}

/// Rods of a piece of an edge, with a ball around them.
#[derive(Clone, Debug)]
struct Piece {
    rods: Vec<Rod>,
    centre: DVec3,
    radius: f64,
}

/// Rods in a piece: where many edges meet most pieces are far away.
const PIECE: usize = 8;

/// The contributions of all edges.
#[derive(Clone, Debug)]
pub(super) struct Field {
    /// By edge.
    pieces: Vec<Vec<Piece>>,
    support: f64,
    level: f64,
}

impl Field {
    /// # Input      `radius` of tubes; `softness`: support relative to it, above 1
    pub(super) fn new(curves: &[Curve], radius: f64, softness: f64) -> Self {
        let pieces = curves.iter().map(|curve| Piece::all(&curve.points())).collect();
        let level = (1.0 - softness.powi(-2)).powf(2.5);
        Self { pieces, support: radius * softness, level }
    }

    /// The value on the skin.
    pub(super) fn level(&self) -> f64 {
        self.level
    }

    /// What an edge contributes at a point: between 0 and about 1.
    pub(super) fn of_edge(&self, edge: usize, at: DVec3) -> f64 {
        let sum: f64 = self.pieces[edge].iter().map(|piece| piece.value(at, self.support)).sum();
        sum * 15.0 / (16.0 * self.support)
    }
}

impl Piece {
    fn all(points: &[DVec3]) -> Vec<Self> {
        let last = points.len() - 1;
        (0..last).step_by(PIECE).map(|from| Self::new(&points[from..=(from + PIECE).min(last)])).collect()
    }

    fn new(points: &[DVec3]) -> Self {
        let rod = |p: &[DVec3]| {
            let (length, step) = (p[0].distance(p[1]), p[1] - p[0]);
            Rod { start: p[0], direction: step / length, length }
        };
        let centre = points.iter().sum::<DVec3>() / points.len() as f64;
        let radius = points.iter().map(|p| p.distance(centre)).fold(0.0, f64::max);
        Self { rods: points.windows(2).map(rod).collect(), centre, radius }
    }

    fn value(&self, at: DVec3, support: f64) -> f64 {
        let reach = self.radius + support;
        if at.distance_squared(self.centre) > reach * reach {
            return 0.0;
        }
        self.rods.iter().map(|rod| rod.value(at, support)).sum()
    }
}

impl Rod {
    /// ∫ (1 − |x − γ|²/R²)² ds over the part within R.
    fn value(&self, at: DVec3, support: f64) -> f64 {
        let to = at - self.start;
        let foot = to.dot(self.direction);
        let r2 = support * support;
        // What is left of 1 at the foot of the perpendicular.
        let left = 1.0 - (to.length_squared() - foot * foot) / r2;
        if left <= 0.0 {
            return 0.0;
        }
        let half = support * left.sqrt();
        let (from, until) = ((-foot).max(-half), (self.length - foot).min(half));
        if from >= until {
            return 0.0;
        }
        let integral = |s: f64| {
            let q = s * s / r2;
            s * (left * left + q * (q / 5.0 - 2.0 * left / 3.0))
        };
        integral(until) - integral(from)
    }
}

#[cfg(test)]
mod tests {
    use super::super::curve::along;
    use super::*;

    #[test]
    fn a_straight_line_has_the_radius() {
        let line = [DVec3::new(-5.0, 0.0, 0.0), DVec3::new(5.0, 0.0, 0.0)];
        let broken: Vec<_> = (0..=20).map(|i| DVec3::new(0.5 * i as f64 - 5.0, 0.0, 0.0)).collect();
        for (line, softness) in [(line.to_vec(), 1.4), (broken.clone(), 1.6), (broken, 2.0)] {
            let field = Field::new(&along(&[line], 0.7).unwrap(), 0.7, softness);
            let skin = field.of_edge(0, DVec3::new(0.3, 0.7 * 0.6, 0.7 * 0.8));
            assert!((skin - field.level()).abs() < 1e-12);
            assert_eq!(field.of_edge(0, DVec3::new(0.0, 0.7 * softness + 1e-9, 0.0)), 0.0);
        }
    }
}
