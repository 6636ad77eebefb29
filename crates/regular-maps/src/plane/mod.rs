//! The plane in which a map of type {p, q} is drawn: sphere, Euclidean or hyperbolic plane, in one set of coordinates.
//!
//! In: p and q. Out: [`Plane`]: the fundamental triangle, its reflections as matrices, models to look at.
//! Holds: points are (x, y, w) with κ(x² + y²) + w² = 1, κ the sign of the curvature; geodesics are straight lines in
//! (x/w, y/w). Not: exact numbers; which flag is which is decided by the group, never by them.
//! Source: [Razafindrazaka2015] §9.1, §9.3, Fig. 9.4, 9.7, 9.9.
//!
//! ```text
//!   F ───────── E     F face centre, at the origin; E edge midpoint; V vertex.
//!     ╲  base   │     angle π/p at F, π/2 at E, π/q at V. R = r₀r₁ turns by +2π/p about F, S = r₁r₂ by +2π/q about V.
//!        ╲ flag │
//!           ╲   │
//!              V
//! ```

use crate::map::Reflection;
use glam::{DMat3, DVec3};

/// The sign of the curvature.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Curvature {
    /// 1/p + 1/q > 1/2.
    Spherical,
    /// 1/p + 1/q = 1/2.
    Flat,
    /// 1/p + 1/q < 1/2.
    Hyperbolic,
}

impl Curvature {
    /// Of the tiling {p, q}.
    pub fn of_type(p: usize, q: usize) -> Self {
        match (2 * (p + q)).cmp(&(p * q)) {
            std::cmp::Ordering::Greater => Self::Spherical,
            std::cmp::Ordering::Equal => Self::Flat,
            std::cmp::Ordering::Less => Self::Hyperbolic,
        }
    }

    fn sign(self) -> f64 {
        match self {
            Self::Spherical => 1.0,
            Self::Flat => 0.0,
            Self::Hyperbolic => -1.0,
        }
    }
}

/// The plane of the tiling {p, q} with its base flag.
#[derive(Clone, Debug)]
pub struct Plane {
    /// The sign of the curvature.
    pub curvature: Curvature,
    /// Corners of the base flag's triangle: vertex V, edge midpoint E, face centre F, each fixed by the two other
    /// reflections.
    pub corners: [DVec3; 3],
    reflections: [DMat3; 3],
}

impl Plane {
    /// The plane of {p, q}; p and q are at least 2. In the flat plane the distance from a face's centre to its corners is 1.
    pub fn of_type(p: usize, q: usize) -> Self {
        use std::f64::consts::PI;
        let curvature = Curvature::of_type(p, q);
        let (a, b) = (PI / p as f64, PI / q as f64);
        // Right-angled triangle with angles a and b: its hypotenuse F V and its side F E.
        let (to_vertex, to_edge) = match curvature {
            Curvature::Flat => (1.0, a.cos()),
            Curvature::Spherical => {
                ((a.cos() / a.sin() * b.cos() / b.sin()).acos(), (b.cos() / a.sin()).min(1.0).acos())
            }
            Curvature::Hyperbolic => ((a.tan() * b.tan()).recip().acosh(), (b.cos() / a.sin()).acosh()),
        };
        let plane = Self { curvature, corners: [DVec3::Z; 3], reflections: [DMat3::IDENTITY; 3] };
        let edge = plane.at(to_edge, 0.0);
        let corners = [plane.at(to_vertex, -a), edge, DVec3::Z];
        let along_edge =
            plane.shift(to_edge) * DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)) * plane.shift(-to_edge);
        let (sin, cos) = (-2.0 * a).sin_cos();
        let bisector = DMat3::from_cols(DVec3::new(cos, sin, 0.0), DVec3::new(sin, -cos, 0.0), DVec3::Z);
        let axis = DMat3::from_diagonal(DVec3::new(1.0, -1.0, 1.0));
        Self { curvature, corners, reflections: [axis, bisector, along_edge] }
    }

    /// The reflection of the base flag.
    pub fn reflection(&self, by: Reflection) -> DMat3 {
        self.reflections[by as usize]
    }

    /// The isometry of a word: it takes the base flag to the flag that the word names.
    pub fn isometry(&self, word: &[Reflection]) -> DMat3 {
        word.iter().fold(DMat3::IDENTITY, |m, &by| m * self.reflection(by))
    }

    /// The point at this distance from the origin in this direction, radians.
    pub fn at(&self, distance: f64, angle: f64) -> DVec3 {
        let (sin, cos) = angle.sin_cos();
        let radial = self.sine(distance);
        DVec3::new(radial * cos, radial * sin, self.cosine(distance))
    }

    /// The translation along the x-axis.
    pub fn shift(&self, distance: f64) -> DMat3 {
        let (s, c) = (self.sine(distance), self.cosine(distance));
        let back = -self.curvature.sign() * s;
        DMat3::from_cols(DVec3::new(c, 0.0, back), DVec3::Y, DVec3::new(s, 0.0, c))
    }

    /// The isometry without reflection that takes a point to the origin.
    pub fn to_origin(&self, point: DVec3) -> DMat3 {
        let angle = point.y.atan2(point.x);
        DMat3::from_rotation_z(angle) * self.shift(-self.distance(DVec3::Z, point)) * DMat3::from_rotation_z(-angle)
    }

    /// The distance of two points.
    pub fn distance(&self, a: DVec3, b: DVec3) -> f64 {
        let d = b - a;
        let flat = d.x * d.x + d.y * d.y;
        match self.curvature {
            Curvature::Flat => flat.sqrt(),
            // Chords keep their digits where points are close; cosines do not.
            Curvature::Spherical => 2.0 * (0.5 * d.length()).min(1.0).asin(),
            Curvature::Hyperbolic => 2.0 * (0.5 * (flat - d.z * d.z).max(0.0).sqrt()).asinh(),
        }
    }

    /// The point that divides the geodesic from a to b like the chord at t: symmetric about the midpoint.
    pub fn between(&self, a: DVec3, b: DVec3, t: f64) -> DVec3 {
        self.normalised(a.lerp(b, t))
    }

    /// The point on the ray through a linear combination of points.
    pub fn normalised(&self, v: DVec3) -> DVec3 {
        let square = match self.curvature {
            Curvature::Spherical => v.length_squared(),
            Curvature::Flat => v.z * v.z,
            Curvature::Hyperbolic => v.z * v.z - v.x * v.x - v.y * v.y,
        };
        v / square.max(f64::MIN_POSITIVE).sqrt()
    }

    fn sine(&self, x: f64) -> f64 {
        match self.curvature {
            Curvature::Spherical => x.sin(),
            Curvature::Flat => x,
            Curvature::Hyperbolic => x.sinh(),
        }
    }

    fn cosine(&self, x: f64) -> f64 {
        match self.curvature {
            Curvature::Spherical => x.cos(),
            Curvature::Flat => 1.0,
            Curvature::Hyperbolic => x.cosh(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn reflections_satisfy_the_relators_of_the_tiling() {
        use Reflection::{R0, R1, R2};
        for (p, q) in [(3, 3), (4, 3), (2, 5), (5, 2), (4, 4), (3, 6), (6, 3), (3, 7), (4, 6), (12, 12)] {
            let plane = Plane::of_type(p, q);
            for (pair, n) in [([R0, R1], p), ([R1, R2], q), ([R0, R2], 2), ([R0, R0], 1), ([R1, R1], 1), ([R2, R2], 1)]
            {
                let error = (plane.isometry(&pair.repeat(n)) - DMat3::IDENTITY).abs();
                let worst = error.to_cols_array().into_iter().fold(0.0, f64::max);
                // A rotation about a point so far away has entries as large as its w squared.
                assert!(worst < 1e-10 * plane.corners[0].z.powi(2).max(1.0), "{{{p},{q}}} {pair:?} {worst}");
            }
            for by in Reflection::ALL {
                for (k, &corner) in plane.corners.iter().enumerate() {
                    let moved = plane.distance(plane.reflection(by) * corner, corner);
                    assert_eq!(moved < 1e-6, k != by as usize, "{{{p},{q}}} {by:?} {k} {moved}");
                }
            }
        }
    }

    #[test]
    fn rotations_turn_counter_clockwise() {
        let plane = Plane::of_type(3, 7);
        let point = plane.isometry(&[Reflection::R0, Reflection::R1]) * plane.at(0.5, 0.1);
        assert!((point.y.atan2(point.x) - (0.1 + TAU / 3.0)).abs() < 1e-12);
        let to_vertex = plane.to_origin(plane.corners[0]);
        let turn = to_vertex * plane.isometry(&[Reflection::R1, Reflection::R2]) * to_vertex.inverse();
        let point = turn * plane.at(0.5, 0.1);
        assert!((point.y.atan2(point.x) - (0.1 + TAU / 7.0)).abs() < 1e-9);
    }
}
