//! Lines: edges, the boundary with its arrows, the tiling around the domain.
//!
//! In: sides of triangles. Out: layers. Holds: lines are thinner where the model makes everything smaller.

use super::lens::Lens;
use super::path::{Contour, Label, Layer, Shape};
use crate::colouring::{hue, oklch};
use crate::ids::FlagMap;
use crate::map::Reflection;
use crate::plane::Curvature;
use crate::tiling::element::{Element, ElementGroup};
use crate::tiling::{BoundaryEdge, FlatTiling, Side};
use glam::{DMat3, DVec2};
use std::collections::{HashSet, VecDeque};

/// Lines are as thin as the model makes things small, to this power: less, for very thin ones are not seen.
const TAPER: f64 = 0.55;

/// Thinnest lines, of their full width.
const THINNEST: f64 = 0.16;

/// Number of widths that are told apart.
const WIDTHS: f64 = 10.0;

/// The colour of the tiling around the domain.
const SURROUNDINGS: [u8; 3] = [0xd9, 0xd4, 0xca];

/// Smallest size of triangles around the domain, for a picture of 1000 pixels, and their largest number.
const SMALLEST: f64 = 5.0;
const MOST: usize = 12_000;

/// Length of arrows and size of labels relative to their boundary edge, with bounds for a picture of 1000 pixels.
const ARROW: (f64, [f64; 2]) = (0.2, [3.0, 17.0]);
const LABEL: (f64, [f64; 2]) = (0.26, [5.5, 24.0]);

/// How lines are drawn at the centre.
pub(super) struct Pen {
    pub(super) colour: [u8; 3],
    pub(super) width: f64,
}

/// Full width at the centre, thinner where things are small.
fn taper(magnification: f64) -> f64 {
    let exact = magnification.clamp(0.0, 1.0).powf(TAPER).max(THINNEST);
    (exact * WIDTHS).ceil() / WIDTHS
}

/// Lines by width, thin ones first.
fn tapered(curves: impl IntoIterator<Item = (f64, Contour)>, pen: &Pen) -> Vec<Shape> {
    let mut by_width: std::collections::BTreeMap<u32, Vec<Contour>> = Default::default();
    for (magnification, curve) in curves {
        by_width.entry((taper(magnification) * WIDTHS).round() as u32).or_default().push(curve);
    }
    let line = |(step, path)| Shape::Line { path, colour: pen.colour, width: pen.width * f64::from(step) / WIDTHS };
    by_width.into_iter().map(line).collect()
}

pub(super) fn line_layer(name: &'static str, lens: &Lens, sides: &[Side], pen: &Pen) -> Layer {
    let curves = sides.iter().map(|&side| (lens.magnification(lens.tiling.middle(side.flag)), lens.side(side)));
    Layer::of(name, tapered(curves, pen))
}

/// The boundary, and what is written at it.
pub(super) fn boundary_layer(lens: &Lens, visible: &FlagMap<bool>, unit: f64, labels: bool) -> Vec<Layer> {
    let count = lens.tiling.boundary().iter().map(|edge| edge.label).max().unwrap_or(0) as usize;
    let (mut lines, mut arrows, mut texts) = (Vec::new(), Vec::new(), Vec::new());
    for edge in lens.tiling.boundary() {
        let colour = oklch(0.5, 0.16, hue(edge.label as usize - 1, count));
        let sides: Vec<_> = edge.sides.iter().filter(|side| visible[side.flag]).copied().collect();
        lines.extend(line_layer("", lens, &sides, &Pen { colour, width: 4.5 * unit }).groups.remove(0).shapes);
        let Some(middle) = Middle::of(lens, edge).filter(|_| sides.len() == edge.sides.len()) else { continue };
        let length = (ARROW.0 * middle.length).min(ARROW.1[1] * unit);
        if length >= ARROW.1[0] * unit {
            arrows.push(Shape::Area { path: vec![arrow(&middle, edge.forward, length)], colour, seam: 0.0 });
        }
        let size = (LABEL.0 * middle.length).min(LABEL.1[1] * unit);
        if labels && size >= LABEL.1[0] * unit {
            let at = middle.at + (0.72 * size + 0.5 * length) * middle.outward();
            texts.push(Shape::Label(Label { at, text: edge.label.to_string(), size, colour, halo: Some([255; 3]) }));
        }
    }
    vec![Layer::of("boundary", lines), Layer::of("arrows", arrows), Layer::of("labels", texts)]
}

/// The point halfway along a boundary edge.
struct Middle {
    at: DVec2,
    /// Along the edge, the domain to the left (on the screen, too).
    along: DVec2,
    length: f64,
}

impl Middle {
    fn of(lens: &Lens, edge: &BoundaryEdge) -> Option<Self> {
        let points = polyline(lens, edge);
        let lengths: Vec<f64> = points.windows(2).map(|w| w[0].distance(w[1])).collect();
        let length: f64 = lengths.iter().sum();
        let mut left = length / 2.0;
        for (pair, &step) in points.windows(2).zip(&lengths) {
            if left <= step && step > 0.0 {
                let at = pair[0].lerp(pair[1], left / step);
                return Some(Self { at, along: (pair[1] - pair[0]) / step, length });
            }
            left -= step;
        }
        None
    }

    fn outward(&self) -> DVec2 {
        // Pixels run downwards: the right of the way is a quarter turn clockwise on the screen.
        self.along.perp()
    }
}

/// Eight points per side.
fn polyline(lens: &Lens, edge: &BoundaryEdge) -> Vec<DVec2> {
    let tiling = lens.tiling;
    let point = |&side: &Side, k: usize| {
        let [a, b] = tiling.ends(side).map(|corner| tiling.corners(side.flag)[corner]);
        lens.pixel(tiling.plane().between(a, b, k as f64 / 8.0))
    };
    edge.sides.iter().flat_map(|side| (0..=8).map(move |k| point(side, k))).collect()
}

/// An arrow head, its middle at the middle of the edge.
fn arrow(middle: &Middle, forward: bool, length: f64) -> Contour {
    let along = if forward { middle.along } else { -middle.along } * length;
    let back = middle.at - 0.5 * along;
    let aside = 0.46 * along.perp();
    Contour::polygon(&[middle.at + 0.6 * along, back + aside, back + 0.25 * along, back - aside])
}

/// Edges of the map beyond the domain, as far as they can be seen.
///
/// # Cost       linear in the triangles met, at most [`MOST`]
pub(super) fn surroundings_layer(lens: &Lens, unit: f64) -> Option<Layer> {
    let tiling = lens.tiling;
    if tiling.plane().curvature == Curvature::Spherical {
        return None;
    }
    let frame = &tiling.frame;
    let curves = beyond(tiling, |isometry| is_seen(lens, isometry, unit)).into_iter().map(|isometry| {
        let [vertex, edge] = [0, 1].map(|k| tiling.plane().normalised(isometry * frame.corners[k]));
        (lens.magnification(tiling.plane().between(vertex, edge, 0.5)), lens.curve(vertex, edge))
    });
    Some(Layer::of("surroundings", tapered(curves, &Pen { colour: SURROUNDINGS, width: 2.0 * unit })))
}

/// Whether a triangle is in the picture and large enough.
fn is_seen(lens: &Lens, isometry: DMat3, unit: f64) -> bool {
    let tiling = lens.tiling;
    let [a, b, c] = tiling.frame.corners.map(|p| lens.pixel(tiling.plane().normalised(isometry * p)));
    let half = 500.0 * unit;
    let inside = (a - DVec2::splat(half)).abs().max_element() < 1.05 * half;
    inside && (b - a).perp_dot(c - a).abs().sqrt() > SMALLEST * unit
}

/// The triangles of evenly many reflections that lie around the domain, nearest in steps first.
fn beyond(tiling: &FlatTiling, is_seen: impl Fn(DMat3) -> bool) -> Vec<DMat3> {
    let map = tiling.map();
    let group = ElementGroup::of_type(map.p(), map.q());
    let mut met: HashSet<Element> = tiling.elements.values().iter().copied().collect();
    let flags = tiling.order().iter();
    let mut queue: VecDeque<_> =
        flags.map(|&g| (tiling.elements[g], tiling.isometries[g], tiling.is_counter_clockwise(g))).collect();
    let mut found = Vec::new();
    while let Some((element, isometry, even)) = queue.pop_front() {
        for by in Reflection::ALL {
            let (next, there) = (group.times(element, by), isometry * tiling.frame.reflection(by));
            if met.len() < map.order() + MOST && is_seen(there) && met.insert(next) {
                queue.push_back((next, there, !even));
                found.extend((!even).then_some(there));
            }
        }
    }
    found
}
