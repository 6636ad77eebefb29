//! Digits as strokes, for formats without fonts.
//!
//! In: a label. Out: lines. Holds: digits are as wide and high as those of a common sans-serif font.
//!
//! ```text
//!   x from 0 to 0.5, y from 0 (top) to 0.7 (baseline), of the height of a line
//! ```

use super::path::{Contour, Label, Segment};
use glam::{DVec2, dvec2};

/// From one digit to the next, of the height of a line.
const ADVANCE: f64 = 0.58;

/// Width of the strokes.
pub(super) const WEIGHT: f64 = 0.085;

/// Width of the halo, both sides together.
pub(super) const HALO: f64 = 0.22;

/// Part of a digit: a polygon's side after side, or an arc of an ellipse (centre, half axes, from and to in degrees,
/// clockwise from the right).
enum Stroke {
    Lines(&'static [[f64; 2]]),
    Arc([f64; 2], [f64; 2], [f64; 2]),
}

use Stroke::{Arc, Lines};

const DIGITS: [&[Stroke]; 10] = [
    &[Arc([0.25, 0.35], [0.2, 0.35], [0.0, 360.0])],
    &[Lines(&[[0.1, 0.14], [0.29, 0.0], [0.29, 0.7]])],
    &[Arc([0.25, 0.19], [0.2, 0.19], [180.0, 400.0]), Lines(&[[0.403, 0.312], [0.05, 0.7], [0.46, 0.7]])],
    &[Arc([0.23, 0.17], [0.18, 0.17], [200.0, 450.0]), Arc([0.23, 0.52], [0.21, 0.18], [270.0, 520.0])],
    &[Lines(&[[0.36, 0.7], [0.36, 0.0], [0.03, 0.5], [0.48, 0.5]])],
    &[Lines(&[[0.42, 0.0], [0.12, 0.0], [0.085, 0.33]]), Arc([0.245, 0.475], [0.205, 0.225], [225.0, 510.0])],
    &[Arc([0.25, 0.48], [0.2, 0.22], [0.0, 360.0]), Arc([0.44, 0.5], [0.39, 0.5], [180.0, 260.0])],
    &[Lines(&[[0.04, 0.0], [0.46, 0.0], [0.19, 0.7]])],
    &[Arc([0.25, 0.17], [0.17, 0.17], [0.0, 360.0]), Arc([0.25, 0.52], [0.2, 0.18], [0.0, 360.0])],
    &[Arc([0.25, 0.22], [0.2, 0.22], [0.0, 360.0]), Arc([0.06, 0.2], [0.39, 0.5], [0.0, 80.0])],
];

/// The strokes of a label's digits; other characters are left out.
pub(super) fn strokes(label: &Label) -> Vec<Contour> {
    let digits: Vec<_> = label.text.chars().filter_map(|c| c.to_digit(10)).collect();
    let width = ADVANCE * digits.len() as f64 - (ADVANCE - 0.5);
    let corner = label.at - label.size * dvec2(width / 2.0, 0.35);
    let contours = digits.iter().enumerate().flat_map(|(k, &digit)| {
        let from = corner + dvec2(label.size * ADVANCE * k as f64, 0.0);
        DIGITS[digit as usize].iter().map(move |stroke| contour(stroke, from, label.size))
    });
    contours.collect()
}

fn contour(stroke: &Stroke, from: DVec2, size: f64) -> Contour {
    let points: Vec<DVec2> = match stroke {
        Lines(points) => points.iter().map(|&p| DVec2::from(p)).collect(),
        Arc(centre, axes, [start, end]) => {
            let steps = ((end - start) / 12.0).ceil();
            let angle = |k: usize| (start + (end - start) * k as f64 / steps).to_radians();
            let point = |k| DVec2::from(*centre) + DVec2::from(*axes) * DVec2::from_angle(angle(k));
            (0..=steps as usize).map(point).collect()
        }
    };
    let place = |p: DVec2| from + size * p;
    let segments = points[1..].iter().map(|&p| Segment::Line(place(p))).collect();
    Contour { start: place(points[0]), segments, closed: false }
}
