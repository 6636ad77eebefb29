//! Flipping edges: towards six neighbours a vertex, or towards larger smallest angles.
//!
//! In: the remesher's state. Out: the same vertices, other edges.
//! Holds: curve edges stay, no new edge joins two curves, no face folds.
//! Source: valence flips after Botsch, Kobbelt (2004) §4; the angle criterion is Delaunay's, on the two faces alone.

use super::Remesher;
use super::guard::{Shape, sag};
use super::work::{NONE, Role, Work, prev};
use crate::progress::Cancelled;
use glam::DVec3;

/// What a flip is to improve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Goal {
    /// Valences near six, four on the boundary.
    Valence,
    /// Larger smallest angles.
    Angle,
}

/// Quality that a flip for the sake of valences must leave: an isosceles triangle of 30° has 0.6.
const MIN_QUALITY_AFTER_VALENCE_FLIP: f64 = 0.5;

impl Remesher<'_> {
    /// One pass over all edges in the order of their ids.
    pub(super) fn flip_edges(&mut self, goal: Goal) -> Result<usize, Cancelled> {
        let mut flipped = 0;
        for h in 0..self.work.origin.len() as u32 {
            let work = &self.work;
            let t = work.twin(h);
            if !work.alive(h) || t == NONE || h > t || work.seg(h) != NONE || work.stays(h) {
                continue;
            }
            let wanted = match goal {
                Goal::Valence => gains_valence(work, h),
                Goal::Angle => gains_angle(work, h),
            };
            if wanted && self.flip_allowed(h, goal) {
                self.tick()?;
                self.work.flip(h);
                flipped += 1;
            }
        }
        self.tally.flips += flipped;
        Ok(flipped)
    }

    fn flip_allowed(&self, h: u32, goal: Goal) -> bool {
        let work = &self.work;
        let t = work.twin(h);
        let (a, b, c, d) = (work.org(h), work.org(t), work.org(prev(h)), work.org(prev(t)));
        // 1. Connectivity: no double edge, no vertex of fewer than three (two) edges, no bridge between curves.
        let few = |v: u32| work.vertices[v as usize].valence <= if work.on_boundary(v) { 2 } else { 3 };
        if (work.on_feature(c) && work.on_feature(d)) || c == d || few(a) || few(b) || work.adjacent(c, d) {
            return false;
        }
        // 2. Directions, shapes.
        let place = [a, b, c, d].map(|v| work.pos(v));
        let normal = [a, b, c, d].map(|v| work.vertices[v as usize].normal);
        let [pa, pb, pc, pd] = place;
        let old = [Shape::of([pa, pb, pc]), Shape::of([pb, pa, pd])];
        let new = [Shape::of([pa, pd, pc]), Shape::of([pb, pc, pd])];
        let both = Shape { twice: old[0].twice + old[1].twice, ..old[0] };
        let both = Shape { twice_area: both.twice.length(), quality: 1.0, ..both };
        let (worst_old, worst_new) = (old[0].quality.min(old[1].quality), new[0].quality.min(new[1].quality));
        let floor = match goal {
            Goal::Valence => MIN_QUALITY_AFTER_VALENCE_FLIP,
            Goal::Angle => worst_old,
        };
        let input = [normal[0] + normal[2] + normal[3], normal[1] + normal[2] + normal[3]];
        if worst_new < floor.min(worst_old)
            || !(0..2).all(|k| new[k].may_replace(&both, input[k], &self.limits))
            || new[0].cos_to(new[1].twice) < self.limits.cos_turn.min(old[0].cos_to(old[1].twice))
        {
            return false;
        }
        // 3. The new edge must not cut off a ridge.
        let vertex = |v: u32| &work.vertices[v as usize];
        let height = sag(vertex(c), vertex(d));
        let limit = self.limits.max_deviation * vertex(c).size.min(vertex(d).size);
        if height > limit && height > sag(vertex(a), vertex(b)) {
            return false;
        }
        let cuts =
            new[0].cuts_edge([vertex(a), vertex(d), vertex(c)]) || new[1].cuts_edge([vertex(b), vertex(c), vertex(d)]);
        // The height of an edge over the surface, from the end that lies inside a region.
        let height = |u: u32, v: u32| {
            let start = self.start_face(if work.on_feature(u) { v } else { u }, work.patch[(h / 3) as usize]);
            self.surface.height(work.pos(u).lerp(work.pos(v), 0.5), start)
        };
        if !cuts {
            return true;
        }
        let new_height = height(c, d);
        new_height <= limit || new_height <= height(a, b)
    }
}

/// Wanted number of edges less the present one.
fn excess(work: &Work, v: u32) -> i64 {
    let vertex = &work.vertices[v as usize];
    match vertex.role {
        // At corners the angles of the sectors decide, not a number.
        Role::Pinned => 0,
        _ => i64::from(vertex.valence) - if work.on_boundary(v) { 4 } else { 6 },
    }
}

fn gains_valence(work: &Work, h: u32) -> bool {
    let t = work.twin(h);
    let (a, b, c, d) = (work.org(h), work.org(t), work.org(prev(h)), work.org(prev(t)));
    // (x - 1)² - x² = 1 - 2x for the ends, (x + 1)² - x² = 1 + 2x for the opposite vertices, 0 at corners.
    let change = |v: u32, by: i64| if work.role(v) == Role::Pinned { 0 } else { 1 + 2 * by * excess(work, v) };
    change(a, -1) + change(b, -1) + change(c, 1) + change(d, 1) < 0
}

/// Cotangents within which four points count as lying on a circle.
const CIRCLE_TOLERANCE: f64 = 1e-3;

fn gains_angle(work: &Work, h: u32) -> bool {
    let t = work.twin(h);
    let (a, b) = (work.pos(work.org(h)), work.pos(work.org(t)));
    let cotangent = |c: DVec3| {
        let (u, v) = (a - c, b - c);
        u.dot(v) / u.cross(v).length().max(1e-12 * u.length() * v.length()).max(f64::MIN_POSITIVE)
    };
    cotangent(work.pos(work.org(prev(h)))) + cotangent(work.pos(work.org(prev(t)))) < -CIRCLE_TOLERANCE
}
