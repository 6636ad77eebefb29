//! From points of the plane to pixels.
//!
//! In: a tiling and a model. Out: [`Lens`]: points and geodesics in pixels, what is hidden, what is at infinity.
//! Holds: geodesics are exact arcs and lines. Source: [Razafindrazaka2015] Fig. 9.4 for the sphere, Fig. 9.9.
//!
//! ```text
//!   stereographic: the point opposite the centre is at infinity; lines to it end at the rim, a circle around all else
//! ```

use super::path::{Contour, Path, Segment, arc_in_space};
use crate::plane::{Curvature, Plane};
use crate::tiling::{FlatTiling, Model, Side};
use glam::{DVec2, DVec3, dvec2};
use std::f64::consts::TAU;

/// Height of the eye above the equator of a Jemisphere, degrees. Lower: more of the back is hidden.
const ELEVATION: f64 = 55.0;

/// Part of the picture's half width that a disc or globe takes; the rest is for labels.
const DISC: f64 = 0.965;

/// The same for a domain in the flat plane or projected from half a sphere, whose labels are outside.
const DOMAIN: f64 = 0.88;

/// Radius of the rim relative to the farthest point that is not at infinity.
const RIM: f64 = 1.5;

/// Arcs that are nowhere farther from their chord than this, pixels, are drawn straight.
const STRAIGHT: f64 = 0.02;

pub(super) struct Lens<'a> {
    pub(super) tiling: &'a FlatTiling,
    pub(super) model: Model,
    /// Pixels per unit of the model.
    pub(super) scale: f64,
    /// Where the model's origin is.
    pub(super) origin: DVec2,
    /// Radius of the rim in the model, where something is at infinity.
    pub(super) rim: Option<f64>,
}

impl<'a> Lens<'a> {
    pub(super) fn new(tiling: &'a FlatTiling, model: Model, size: f64) -> Self {
        let curvature = tiling.plane().curvature;
        let model = match (model, curvature) {
            // Of the sphere the projective model shows less than half.
            (Model::Klein, Curvature::Spherical) => Model::Poincare,
            _ => model,
        };
        let half = size / 2.0;
        let mut lens = Self { tiling, model, scale: half * DISC, origin: DVec2::splat(half), rim: None };
        match (model, curvature) {
            (Model::Jemisphere, Curvature::Hyperbolic) => {
                let low = ELEVATION.to_radians().sin();
                lens.origin.y += lens.scale * (1.0 - low) / 2.0;
            }
            (Model::Jemisphere, _) | (_, Curvature::Hyperbolic) => {}
            (_, Curvature::Spherical) => lens.fit_sphere(half),
            (_, Curvature::Flat) => lens.fit_domain(half),
        }
        lens
    }

    fn fit_sphere(&mut self, half: f64) {
        let positions = || self.tiling.positions.iter();
        let near = positions().filter(|&&p| !is_far(p)).map(|&p| self.model.project(p).length());
        let radius = near.fold(f64::MIN_POSITIVE, f64::max);
        if positions().any(|&p| is_far(p)) {
            self.rim = Some(RIM * radius);
            self.scale = half * DISC / (RIM * radius);
        } else {
            self.scale = half * DOMAIN / radius;
        }
    }

    fn fit_domain(&mut self, half: f64) {
        let places = || self.tiling.positions.iter().map(|&p| self.model.project(p).truncate());
        let low = places().fold(DVec2::INFINITY, DVec2::min);
        let high = places().fold(DVec2::NEG_INFINITY, DVec2::max);
        self.scale = 2.0 * half * DOMAIN / (high - low).max_element();
        let middle = (low + high) / 2.0 * self.scale;
        self.origin -= dvec2(middle.x, -middle.y);
    }

    fn plane(&self) -> &Plane {
        self.tiling.plane()
    }

    /// A point of the model in pixels.
    pub(super) fn seen(&self, point: DVec3) -> DVec2 {
        let (x, y) = match self.model {
            Model::Jemisphere => {
                let (sin, cos) = ELEVATION.to_radians().sin_cos();
                (point.x, sin * point.y + cos * point.z)
            }
            _ => (point.x, point.y),
        };
        self.origin + self.scale * dvec2(x, -y)
    }

    /// A point of the plane in pixels.
    pub(super) fn pixel(&self, point: DVec3) -> DVec2 {
        self.seen(self.model.project(point))
    }

    /// Whether the eye sees the side of the surface on which a point of the plane is.
    pub(super) fn is_visible(&self, point: DVec3) -> bool {
        if self.model != Model::Jemisphere {
            return true;
        }
        let (sin, cos) = ELEVATION.to_radians().sin_cos();
        let place = self.model.project(point);
        sin * place.z - cos * place.y >= 0.0
    }

    /// Whether hidden parts are drawn below the others: a dome has an inside, a globe has none.
    pub(super) fn shows_hidden(&self) -> bool {
        self.plane().curvature == Curvature::Hyperbolic
    }

    /// How large things near a point are relative to those at the centre.
    pub(super) fn magnification(&self, point: DVec3) -> f64 {
        match self.plane().curvature {
            Curvature::Hyperbolic => 2.0 / (1.0 + point.z),
            _ => 1.0,
        }
    }

    /// The geodesic between two points, less than half a turn.
    pub(super) fn curve(&self, a: DVec3, b: DVec3) -> Contour {
        let (start, end) = (self.end_towards(a, b), self.end_towards(b, a));
        let middle = || self.plane().between(a, b, 0.5);
        let segments = match self.model {
            _ if self.is_at_rim(a) || self.is_at_rim(b) => vec![Segment::Line(end)],
            Model::Klein => vec![Segment::Line(end)],
            Model::Poincare => vec![Segment::through(start, self.pixel(middle()), end, STRAIGHT)],
            Model::Jemisphere => arc_in_space([a, middle(), b].map(|p| self.model.project(p)), |p| self.seen(p)),
        };
        Contour { start, segments, closed: false }
    }

    /// A side of a triangle.
    pub(super) fn side(&self, side: Side) -> Contour {
        let [a, b] = self.tiling.ends(side).map(|k| self.tiling.corners(side.flag)[k]);
        self.curve(a, b)
    }

    /// A point, or where the line from another one to infinity meets the rim.
    fn end_towards(&self, point: DVec3, other: DVec3) -> DVec2 {
        match self.rim {
            Some(rim) if is_far(point) => self.seen(rim * dvec2(other.x, other.y).normalize_or_zero().extend(0.0)),
            _ => self.pixel(point),
        }
    }

    pub(super) fn is_at_rim(&self, point: DVec3) -> bool {
        self.rim.is_some() && is_far(point)
    }

    /// The area inside outlines; around: whether infinity is inside it.
    pub(super) fn area(&self, outlines: &[Vec<Side>], around: bool) -> Path {
        let mut path: Path = outlines.iter().map(|outline| self.outline(outline)).collect();
        if let Some(rim) = self.rim.filter(|_| around) {
            path.push(Contour::circle(self.origin, rim * self.scale));
        }
        path
    }

    fn outline(&self, sides: &[Side]) -> Contour {
        let mut whole = Contour { start: DVec2::ZERO, segments: Vec::new(), closed: true };
        for (k, &side) in sides.iter().enumerate() {
            let curve = self.side(side);
            if k == 0 {
                whole.start = curve.start;
            } else {
                whole.segments.extend(self.along_rim(whole.end(), curve.start));
            }
            whole.segments.extend(curve.segments);
        }
        whole.segments.extend(self.along_rim(whole.end(), whole.start));
        whole
    }

    /// From where an outline reaches the rim to where it leaves it, the area to the left.
    fn along_rim(&self, from: DVec2, to: DVec2) -> Option<Segment> {
        let rim = self.rim? * self.scale;
        if from.distance(to) < 1e-6 * rim {
            return None;
        }
        let angle = |p: DVec2| (-(p.y - self.origin.y)).atan2(p.x - self.origin.x);
        let turn = (angle(to) - angle(from)).rem_euclid(TAU);
        Some(Segment::Arc { to, radius: rim, large: turn > TAU / 2.0, clockwise: false })
    }

    /// The outline of the whole model: the circle at infinity, the dome, the globe; nothing for the flat plane.
    pub(super) fn horizon(&self) -> Path {
        let disc = || vec![Contour::circle(self.origin, self.scale)];
        match (self.model, self.plane().curvature) {
            (Model::Jemisphere, Curvature::Hyperbolic) => self.dome(),
            (Model::Jemisphere, _) | (_, Curvature::Hyperbolic) => disc(),
            (_, Curvature::Spherical) => {
                self.rim.map(|rim| Contour::circle(self.origin, rim * self.scale)).into_iter().collect()
            }
            (_, Curvature::Flat) => Vec::new(),
        }
    }

    /// The silhouette of the upper half of the sphere over the front half of its equator.
    fn dome(&self) -> Path {
        let (sin, cos) = ELEVATION.to_radians().sin_cos();
        let behind = DVec3::new(0.0, sin, cos);
        let quarter = |u: DVec3, v: DVec3| {
            let middle = (u + v).normalize();
            arc_in_space([u, middle, v], |p| self.seen(p))
        };
        let segments = [quarter(DVec3::X, behind), quarter(behind, -DVec3::X), quarter(-DVec3::X, -DVec3::Y)];
        let mut segments = segments.concat();
        segments.extend(quarter(-DVec3::Y, DVec3::X));
        vec![Contour { start: self.seen(DVec3::X), segments, closed: true }]
    }
}

fn is_far(point: DVec3) -> bool {
    point.z < -1.0 + 1e-9
}
