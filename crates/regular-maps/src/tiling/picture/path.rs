//! What a picture is made of: areas, lines and labels, in pixels from its top left corner.

use crate::ids::MapFaceId;
use glam::{DVec2, DVec3, dvec2};
use std::f64::consts::FRAC_PI_2;

/// A piece of a curve, from where the last one ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Segment {
    /// Straight.
    Line(DVec2),
    /// A circular arc, as in SVG.
    Arc {
        /// Where it ends.
        to: DVec2,
        /// Of the circle.
        radius: f64,
        /// Whether it is more than half of the circle.
        large: bool,
        /// Whether it runs clockwise on the screen.
        clockwise: bool,
    },
    /// A cubic Bézier curve: two control points and the end.
    Cubic(DVec2, DVec2, DVec2),
}

impl Segment {
    /// Where it ends.
    pub fn end(&self) -> DVec2 {
        match *self {
            Self::Line(to) | Self::Arc { to, .. } | Self::Cubic(_, _, to) => to,
        }
    }

    /// The circular arc through three points, or a line where it is no more than that from one.
    pub(super) fn through(a: DVec2, m: DVec2, b: DVec2, straight: f64) -> Self {
        let turn = (m - a).perp_dot(b - m);
        let chord = a.distance(b);
        if turn.abs() <= straight * chord || !turn.is_finite() {
            return Self::Line(b);
        }
        let radius = chord * a.distance(m) * m.distance(b) / (2.0 * turn.abs());
        Self::Arc { to: b, radius, large: (a - m).dot(b - m) > 0.0, clockwise: turn > 0.0 }
    }

    /// The same as cubic curves, each at most a quarter of a circle.
    pub(super) fn cubics(&self, from: DVec2) -> Vec<Self> {
        let Self::Arc { to, radius, large, clockwise } = *self else { return vec![*self] };
        let half = (to - from) / 2.0;
        let height = (radius * radius - half.length_squared()).max(0.0).sqrt();
        let side = if large == clockwise { 1.0 } else { -1.0 };
        let centre = from + half - side * height * half.perp().normalize_or_zero();
        let (start, end) = ((from - centre).to_angle(), (to - centre).to_angle());
        let tau = std::f64::consts::TAU;
        let sweep = if clockwise { (end - start).rem_euclid(tau) } else { (end - start).rem_euclid(tau) - tau };
        let count = (sweep.abs() / FRAC_PI_2 - 1e-9).ceil().max(1.0);
        let step = sweep / count;
        let handle = radius * 4.0 / 3.0 * (step / 4.0).tan();
        let at = |angle: f64| (centre + radius * DVec2::from_angle(angle), handle * DVec2::from_angle(angle).perp());
        let mut cubics: Vec<_> = (0..count as usize)
            .map(|k| {
                let (p, along) = at(start + step * k as f64);
                let (q, there) = at(start + step * (k + 1) as f64);
                Self::Cubic(p + along, q - there, q)
            })
            .collect();
        if let Some(Self::Cubic(_, _, end)) = cubics.last_mut() {
            *end = to;
        }
        cubics
    }
}

/// A connected curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Contour {
    /// Where it starts.
    pub start: DVec2,
    /// Its pieces.
    pub segments: Vec<Segment>,
    /// Whether it ends where it starts.
    pub closed: bool,
}

impl Contour {
    /// A whole circle.
    pub(super) fn circle(centre: DVec2, radius: f64) -> Self {
        let [left, right] = [-radius, radius].map(|x| centre + dvec2(x, 0.0));
        let half = |to| Segment::Arc { to, radius, large: false, clockwise: true };
        Self { start: left, segments: vec![half(right), half(left)], closed: true }
    }

    /// A polygon.
    pub(super) fn polygon(corners: &[DVec2]) -> Self {
        let segments = corners[1..].iter().map(|&p| Segment::Line(p)).collect();
        Self { start: corners[0], segments, closed: true }
    }

    /// Where it ends.
    pub fn end(&self) -> DVec2 {
        self.segments.last().map_or(self.start, Segment::end)
    }
}

/// The arc of a circle in space through three points, seen from above: two cubic curves.
pub(super) fn arc_in_space(points: [DVec3; 3], seen: impl Fn(DVec3) -> DVec2) -> Vec<Segment> {
    let [a, m, b] = points;
    let axis = (m - a).cross(b - m);
    let square = axis.length_squared();
    if square < 1e-14 * (b - a).length_squared().powi(2) || square == 0.0 {
        return vec![Segment::Line(seen(b))];
    }
    let (u, v) = (a - m, b - m);
    let centre = m + (u.length_squared() * v - v.length_squared() * u).cross(u.cross(v)) / (2.0 * square);
    let radius = centre.distance(m);
    let along = |p: DVec3| axis.cross(p - centre).normalize_or_zero();
    [[a, m], [m, b]]
        .map(|[p, q]| {
            let angle = 2.0 * (p.distance(q) / (2.0 * radius)).min(1.0).asin();
            let handle = radius * 4.0 / 3.0 * (angle / 4.0).tan();
            Segment::Cubic(seen(p + handle * along(p)), seen(q - handle * along(q)), seen(q))
        })
        .to_vec()
}

/// Curves that are drawn together. Areas are inside where a ray crosses an odd number of them.
pub type Path = Vec<Contour>;

/// A number to write.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    /// Its middle.
    pub at: DVec2,
    /// Digits.
    pub text: String,
    /// Height of a line, pixels.
    pub size: f64,
    /// Red, green, blue.
    pub colour: [u8; 3],
    /// Colour around it that sets it off.
    pub halo: Option<[u8; 3]>,
}

/// Something to draw.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// An area, with a line of that width in its own colour around it, so that no gap shows between areas side by side.
    Area {
        /// Closed curves.
        path: Path,
        /// Red, green, blue.
        colour: [u8; 3],
        /// Width of the line, pixels.
        seam: f64,
    },
    /// Lines with round ends.
    Line {
        /// Curves.
        path: Path,
        /// Red, green, blue.
        colour: [u8; 3],
        /// Pixels.
        width: f64,
    },
    /// A number.
    Label(Label),
}

/// Shapes of one face, or of none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Group {
    /// The face.
    pub face: Option<MapFaceId>,
    /// From back to front.
    pub shapes: Vec<Shape>,
}

/// Shapes of one kind.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Its class in SVG.
    pub name: &'static str,
    /// From back to front.
    pub groups: Vec<Group>,
}

impl Layer {
    /// A layer of shapes that belong to no face.
    pub(super) fn of(name: &'static str, shapes: Vec<Shape>) -> Self {
        Self { name, groups: vec![Group { face: None, shapes }] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arcs_and_their_cubics_pass_through_the_middle() {
        let circle = |angle: f64| dvec2(3.0, -1.0) + 2.0 * DVec2::from_angle(angle);
        for (from, sweep) in [(0.3, 0.4), (1.0, -2.0), (2.0, 4.5), (5.0, -5.5)] {
            let [a, m, b] = [0.0, 0.5, 1.0].map(|t| circle(from + t * sweep));
            let arc = Segment::through(a, m, b, 1e-9);
            let Segment::Arc { radius, large, clockwise, .. } = arc else { panic!("{arc:?}") };
            assert!((radius - 2.0).abs() < 1e-9 && large == (sweep.abs() > 3.2) && clockwise == (sweep > 0.0));
            let cubics = arc.cubics(a);
            let n = (sweep.abs() / FRAC_PI_2).ceil() as usize;
            assert_eq!(cubics.len(), n);
            for (k, cubic) in cubics.iter().enumerate() {
                let expected = circle(from + sweep * (k + 1) as f64 / n as f64);
                assert!(cubic.end().distance(expected) < 1e-9, "{from} {sweep}");
            }
        }
        assert_eq!(Segment::through(DVec2::ZERO, DVec2::X, 2.0 * DVec2::X, 1e-3), Segment::Line(2.0 * DVec2::X));
    }

    #[test]
    fn arcs_in_space_end_where_they_should() {
        let point = |angle: f64| DVec3::new(0.5, angle.cos(), angle.sin());
        let arc = arc_in_space([point(0.2), point(0.7), point(1.4)], |p| dvec2(p.y, p.z));
        let Segment::Cubic(a, b, end) = arc[0] else { panic!("{arc:?}") };
        let middle = (dvec2(0.2f64.cos(), 0.2f64.sin()) + 3.0 * a + 3.0 * b + end) / 8.0;
        assert!((middle.length() - 1.0).abs() < 1e-4 && end.distance(dvec2(0.7f64.cos(), 0.7f64.sin())) < 1e-12);
    }
}
