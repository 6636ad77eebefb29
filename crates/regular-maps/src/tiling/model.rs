//! Models of the plane to look at.

use glam::DVec3;

/// A model of the plane. On the sphere and in the flat plane they are the same formulas.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Model {
    /// Conformal: geodesics are circular arcs. Stereographic projection of the sphere. In the disc of radius 1.
    #[default]
    Poincare,
    /// Projective: geodesics are straight. In the disc of radius 1; of the sphere it shows less than half.
    Klein,
    /// Conformal, on the upper half of the unit sphere: geodesics are half circles that meet the equator, which is at
    /// infinity, at right angles ([Razafindrazaka2015] Fig. 9.9). For the sphere: the sphere itself.
    Jemisphere,
}

impl Model {
    /// A point of a [`Plane`](crate::Plane) in this model; z is 0 but on the Jemisphere.
    pub fn project(self, point: DVec3) -> DVec3 {
        match self {
            Self::Klein => DVec3::new(point.x / point.z, point.y / point.z, 0.0),
            Self::Poincare => poincare(point),
            Self::Jemisphere => {
                // Only the sphere has points with w below 1; there the detour would end at infinity.
                if point.z < 0.5 {
                    return point.normalize();
                }
                let z = poincare(point);
                let square = z.length_squared();
                DVec3::new(2.0 * z.x, 2.0 * z.y, 1.0 - square) / (1.0 + square)
            }
        }
    }
}

/// From the point (0, 0, −1) onto w = 0.
fn poincare(point: DVec3) -> DVec3 {
    DVec3::new(point.x / (1.0 + point.z), point.y / (1.0 + point.z), 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::Plane;

    #[test]
    fn models_agree_with_distances() {
        let plane = Plane::of_type(3, 7);
        let point = plane.at(1.3, 0.4);
        assert!((Model::Klein.project(point).length() - 1.3f64.tanh()).abs() < 1e-12);
        assert!((Model::Poincare.project(point).length() - 0.65f64.tanh()).abs() < 1e-12);
        let high = Model::Jemisphere.project(point);
        assert!((high.length() - 1.0).abs() < 1e-12 && (high.z - 1.3f64.cosh().recip()).abs() < 1e-12);
        let sphere = Plane::of_type(4, 3);
        for distance in [0.3, 2.0, std::f64::consts::PI] {
            let point = sphere.at(distance, 0.4);
            assert!((Model::Jemisphere.project(point) - point).length() < 1e-12);
        }
    }
}
