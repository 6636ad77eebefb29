//! What an operation must not do to the surface: fold it, make slivers, leave the input.
//!
//! In: the work mesh and a vertex with the place it would move to. Out: whether it may.
//! Holds: a face whose shape or direction already breaks a limit may stay as bad, never become worse.

use super::surface::Surface;
use super::work::{NONE, Vertex, Work, next, prev};
use crate::closest::closest_weights;
use glam::DVec3;

/// Limits, dimensionless or relative to the target edge length.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Cosine of the angle by which one operation may turn a face.
    pub cos_turn: f64,
    /// Cosine of the angle between a face and the input's normals at its vertices.
    pub cos_input: f64,
    /// Quality below which a face is a sliver; 1: equilateral.
    pub min_quality: f64,
    /// Height of the surface over an edge, relative to the target length.
    pub max_deviation: f64,
}

/// Limits of one operation on a face: 45° and 60°.
///
/// The first must allow a hexagonal tube to be made from a round one; with 60° creases of 35° fold over in two steps.
/// The second bounds what several steps add up to. Quality 0.25 belongs to an angle of about 8°: a higher limit stops
/// decimation beside creases too early, a lower one leaves slivers that later rounds cannot cure.
pub(super) const LIMITS: Limits =
    Limits { cos_turn: std::f64::consts::FRAC_1_SQRT_2, cos_input: 0.5, min_quality: 0.25, max_deviation: 0.1 };

/// Quality below which a face has no direction to speak of, so that it may turn freely.
const NO_DIRECTION: f64 = 0.02;

/// Cosines that differ by less are the same: a face keeps its direction when one of its sides is halved.
const ROUNDING: f64 = 1e-9;

/// Shape quality 4√3·area / Σ side², in 0..=1, from twice the vector area.
#[inline]
pub(super) fn quality(twice_area: f64, [a, b, c]: [DVec3; 3]) -> f64 {
    let sides = a.distance_squared(b) + b.distance_squared(c) + c.distance_squared(a);
    if sides > 0.0 { 2.0 * 3f64.sqrt() * twice_area / sides } else { 0.0 }
}

/// A triangle's direction and shape.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shape {
    /// Twice the vector area.
    pub twice: DVec3,
    /// Its length.
    pub twice_area: f64,
    /// Shape quality, 0..=1.
    pub quality: f64,
}

impl Shape {
    /// Measures a triangle.
    #[inline]
    pub fn of(corner: [DVec3; 3]) -> Self {
        let twice = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
        let twice_area = twice.length();
        Self { twice, twice_area, quality: quality(twice_area, corner) }
    }

    /// Cosine of the angle to another direction (which need not have unit length).
    #[inline]
    pub fn cos_to(&self, direction: DVec3) -> f64 {
        let scale = self.twice_area * direction.length();
        if scale > 0.0 { self.twice.dot(direction) / scale } else { 1.0 }
    }

    /// Whether the turn of a face can be judged: by its own direction and by normals of the input.
    #[inline]
    fn has_direction(old: &Self, input: DVec3) -> bool {
        old.quality > NO_DIRECTION && input.length_squared() > 0.01
    }

    /// Whether this shape may replace `old`, given the sum of the input's normals at its vertices.
    #[inline]
    pub fn may_replace(&self, old: &Shape, input: DVec3, limits: &Limits) -> bool {
        if self.twice_area <= 0.0 {
            return false;
        }
        if old.quality > NO_DIRECTION && self.cos_to(old.twice) < limits.cos_turn {
            return false;
        }
        if input.length_squared() <= 0.01 {
            return true;
        }
        let cos = self.cos_to(input);
        cos >= limits.cos_input || (old.quality > NO_DIRECTION && cos >= old.cos_to(input) - ROUNDING)
    }
}

/// Cosine of the angle between a face and the input's normal at one of its vertices from which the face may cut off an
/// edge of the input that is no feature, so that its distance is measured. 37°: a larger angle lets rounded
/// edges shrink unseen, a smaller one measures all over noisy surfaces.
const COS_CUT: f64 = 0.8;

impl Shape {
    /// Whether the face may cut off an edge or a corner of the input.
    #[inline]
    pub fn cuts_edge(&self, vertices: [&Vertex; 3]) -> bool {
        vertices.iter().any(|v| v.normal != DVec3::ZERO && self.twice.dot(v.normal) < COS_CUT * self.twice_area)
    }

    /// The mean of three corners.
    #[inline]
    pub fn centre(corner: [DVec3; 3]) -> DVec3 {
        (corner[0] + corner[1] + corner[2]) / 3.0
    }
}

/// Cosine of the dihedral angle, 120°, from which two faces count as folded over one another. Creases of thin plates that
/// are no features come near 90°; folds are near 180°.
const COS_FOLD: f64 = -0.5;

/// Whether two neighbours (each before and after) fold over one another that did not before.
#[inline]
fn folds(one: [Shape; 2], two: [Shape; 2]) -> bool {
    let folded = |k: usize| {
        one[k].quality > NO_DIRECTION && two[k].quality > NO_DIRECTION && one[k].cos_to(two[k].twice) < COS_FOLD
    };
    folded(1) && !folded(0)
}

/// Whether the edge to `end` comes to bulge too far when one vertex becomes another.
#[inline]
fn bulges(old: &Vertex, new: &Vertex, end: &Vertex, limits: &Limits) -> bool {
    let height = sag(new, end);
    height > limits.max_deviation * new.size.min(end.size) && height > sag(old, end)
}

/// Whether the centre of a face comes to lie farther from the input than allowed, and than before.
fn cuts_deeper(old: &Vertex, new: &Vertex, [x, y]: [&Vertex; 2], surface: &Surface<'_>, limits: &Limits) -> bool {
    let height = |p: DVec3| surface.height(Shape::centre([p, x.position, y.position]), new.hint);
    let after = height(new.position);
    after > limits.max_deviation * new.size && after > height(old.position)
}

/// Estimated height of the surface over the chord from `a` to `b`, file units.
///
/// A parabola that leaves the tangent plane by d at distance c bulges by d/4 over the chord.
#[inline]
pub(super) fn sag(a: &Vertex, b: &Vertex) -> f64 {
    let chord = b.position - a.position;
    0.25 * chord.dot(a.normal).abs().max(chord.dot(b.normal).abs())
}

impl Work {
    /// Corners of the face of `h`, from its origin.
    #[inline]
    pub fn corners(&self, h: u32) -> [DVec3; 3] {
        [self.pos(self.org(h)), self.pos(self.tgt(h)), self.pos(self.org(prev(h)))]
    }

    /// Whether the faces at `v` that do not touch `other` stay healthy when `v` becomes `moved`.
    pub fn may_become(&self, v: u32, moved: &Vertex, other: u32, surface: &Surface<'_>, limits: &Limits) -> bool {
        let place = &self.vertices[v as usize];
        let (mut worst_old, mut worst_new) = (f64::INFINITY, f64::INFINITY);
        let mut last: Option<[Shape; 2]> = None;
        for h in self.ring(v) {
            let (x, y) = (self.tgt(h), self.apex(h));
            let (vx, vy) = (&self.vertices[x as usize], &self.vertices[y as usize]);
            let old = Shape::of([place.position, vx.position, vy.position]);
            worst_old = worst_old.min(old.quality);
            if x == other || y == other {
                last = None;
                continue;
            }
            let new = Shape::of([moved.position, vx.position, vy.position]);
            worst_new = worst_new.min(new.quality);
            let input = moved.normal + vx.normal + vy.normal;
            let pair = [old, new];
            if !new.may_replace(&old, input, limits)
                || last.is_some_and(|last| self.seg(h) == NONE && folds(last, pair))
                || (!Shape::has_direction(&old, input) && self.folds_outwards(next(h), pair))
                || bulges(place, moved, vx, limits)
                || (new.cuts_edge([moved, vx, vy]) && cuts_deeper(place, moved, [vx, vy], surface, limits))
            {
                return false;
            }
            last = Some(pair);
        }
        worst_new >= limits.min_quality.min(worst_old)
    }

    /// Whether a face that changes folds over the face across its side `side`, which does not change.
    fn folds_outwards(&self, side: u32, pair: [Shape; 2]) -> bool {
        let outer = self.twin(side);
        outer != NONE && self.seg(outer) == NONE && folds([Shape::of(self.corners(outer)); 2], pair)
    }

    /// Whether the faces that the collapse of `h` to `place` makes neighbours fold over one another.
    pub fn seam_folds(&self, h: u32, place: DVec3) -> bool {
        let (a, b) = (self.org(h), self.tgt(h));
        [h, self.twin(h)].into_iter().filter(|&side| side != NONE).any(|side| {
            let sides = [next(side), prev(side)].map(|g| (self.twin(g), self.seg(g)));
            let [(first, NONE), (second, NONE)] = sides else { return false };
            if first == NONE || second == NONE {
                return false;
            }
            let moved = |g: u32| {
                let corners = [self.org(g), self.tgt(g), self.apex(g)];
                Shape::of(corners.map(|v| if v == a || v == b { place } else { self.pos(v) }))
            };
            let (first, second) = (moved(first), moved(second));
            first.quality > NO_DIRECTION && second.quality > NO_DIRECTION && first.cos_to(second.twice) < COS_FOLD
        })
    }

    /// Distance of the point `p` from the faces at `v` as they would be with `v` at `place`, without those touching
    /// `other`.
    pub fn distance_to_fan(&self, v: u32, place: DVec3, other: u32, p: DVec3) -> f64 {
        let mut nearest = f64::INFINITY;
        for h in self.ring(v) {
            let (x, y) = (self.tgt(h), self.org(prev(h)));
            if x != other && y != other {
                let corner = [place, self.pos(x), self.pos(y)];
                let w = closest_weights(&corner, p);
                let foot = corner[0] * w[0] + corner[1] * w[1] + corner[2] * w[2];
                nearest = nearest.min(foot.distance_squared(p));
            }
        }
        if nearest.is_finite() { nearest.sqrt() } else { 0.0 }
    }

    /// Longest edge at a vertex, file units squared.
    pub fn longest_sq(&self, v: u32) -> f64 {
        let p = self.pos(v);
        let mut longest = 0.0f64;
        self.for_neighbours(v, |_, x| longest = longest.max(p.distance_squared(self.pos(x))));
        longest
    }

    /// The vertex opposite to a half-edge in its face; `NONE` for no half-edge.
    pub fn apex(&self, h: u32) -> u32 {
        if h == NONE { NONE } else { self.org(prev(h)) }
    }
}
