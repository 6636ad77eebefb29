//! The base triangle with its incentre at the origin.
//!
//! In: a [`Plane`]. Out: [`Frame`]. Holds: reflections have the smallest entries that they can have, so that a product of
//! many stays as exact as its own size allows; about a face's centre, from where vertices of {84, 84} are at a distance
//! of 7, it would not.

use crate::map::Reflection;
use crate::plane::{Curvature, Plane};
use glam::{DMat3, DVec3};

#[derive(Clone, Debug)]
pub(super) struct Frame {
    /// From the plane's base triangle to this one.
    pub(super) from_plane: DMat3,
    /// V, E, F.
    pub(super) corners: [DVec3; 3],
    reflections: [DMat3; 3],
}

impl Frame {
    pub(super) fn new(plane: &Plane) -> Self {
        let from_plane = plane.to_origin(incentre(plane));
        let corners = plane.corners.map(|corner| plane.normalised(from_plane * corner));
        let sign = sign(plane.curvature);
        let reflections = lines(corners, sign).map(|line| {
            // v − 2 ⟨line, v⟩ normal, the normal being the line's coefficients in the plane's own product.
            let normal = DVec3::new(line.x, line.y, sign * line.z);
            let columns = [line.x, line.y, line.z].map(|c| -2.0 * c * normal);
            DMat3::IDENTITY + DMat3::from_cols(columns[0], columns[1], columns[2])
        });
        Self { from_plane, corners, reflections }
    }

    pub(super) fn reflection(&self, by: Reflection) -> DMat3 {
        self.reflections[by as usize]
    }
}

/// The lines of the sides as linear forms of length 1, positive inside.
fn lines(corners: [DVec3; 3], sign: f64) -> [DVec3; 3] {
    [0, 1, 2].map(|i| {
        let line = corners[(i + 1) % 3].cross(corners[(i + 2) % 3]);
        line / (line.x * line.x + line.y * line.y + sign * line.z * line.z).sqrt()
    })
}

/// The point of the base triangle at equal distance from its sides.
fn incentre(plane: &Plane) -> DVec3 {
    let [a, b, c] = lines(plane.corners, sign(plane.curvature));
    plane.normalised(DMat3::from_cols(a, b, c).transpose().inverse() * DVec3::ONE)
}

fn sign(curvature: Curvature) -> f64 {
    match curvature {
        Curvature::Spherical => 1.0,
        Curvature::Flat => 0.0,
        Curvature::Hyperbolic => -1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reflections_are_those_of_the_plane() {
        for (p, q) in [(2, 5), (5, 2), (4, 3), (4, 4), (3, 7), (12, 12)] {
            let plane = Plane::of_type(p, q);
            let frame = Frame::new(&plane);
            for by in Reflection::ALL {
                let there = frame.from_plane.inverse() * frame.reflection(by) * frame.from_plane;
                let worst = (there - plane.reflection(by)).abs().to_cols_array().into_iter().fold(0.0, f64::max);
                assert!(worst < 1e-9, "{{{p},{q}}} {by:?} {worst}");
            }
        }
    }
}
