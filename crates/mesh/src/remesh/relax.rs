//! Tangential relaxation: vertices move towards the centre of their faces and back to the input.
//!
//! In: the remesher's state. Out: the same connectivity, other positions.
//! Holds: free vertices lie on the input surface afterwards where that folds nothing, curve vertices on their curve.
//! Source: area-weighted tangential smoothing after Botsch, Kobbelt (2004) §4; one vertex after the other.

use super::Remesher;
use super::guard::Shape;
use super::work::{NONE, Role, Vertex};
use crate::progress::Cancelled;
use glam::DVec3;

/// Fractions of the wanted step that are tried in turn.
const STEPS: [f64; 2] = [1.0, 0.5];
/// Moves shorter than this times the target are not worth their cost.
const MIN_MOVE: f64 = 1e-3;

impl Remesher<'_> {
    /// Moves every vertex once, in the order of ids.
    pub(super) fn relax(&mut self) -> Result<(), Cancelled> {
        for v in 0..self.work.out.len() as u32 {
            if self.work.out[v as usize] == NONE || self.work.vertices[v as usize].kept {
                continue;
            }
            self.tick()?;
            match self.work.role(v) {
                Role::Free => self.relax_free(v),
                Role::OnCurve => self.relax_on_curve(v),
                Role::Pinned => {}
            }
        }
        Ok(())
    }

    /// Brings free vertices that still lie off the input to it, where that folds nothing; counts those that stay off.
    pub(super) fn settle(&mut self) {
        for v in 0..self.work.out.len() as u32 {
            let old = self.work.vertices[v as usize];
            if self.work.out[v as usize] == NONE || old.role != Role::Free {
                continue;
            }
            let near = (1e-6 * old.size).powi(2);
            if self.surface.foot_on_face(old.position, old.hint).distance_sq > near && !self.try_move(v, old.position) {
                self.tally.off_surface += 1;
            }
        }
    }

    /// Moves a free vertex to the point of the input nearest to `goal`, if that folds nothing.
    fn try_move(&mut self, v: u32, goal: DVec3) -> bool {
        let old = self.work.vertices[v as usize];
        let foot = self.surface.walk(goal, old.hint);
        let normal = self.surface.normal[foot.face as usize];
        let moved = Vertex { position: foot.point, normal, hint: foot.face, ..old };
        let allowed = self.work.may_become(v, &moved, NONE, &self.surface, &self.limits);
        if allowed {
            self.work.vertices[v as usize] = moved;
            self.tally.moves += 1;
        }
        allowed
    }

    fn relax_free(&mut self, v: u32) {
        let old = self.work.vertices[v as usize];
        let step = self.tangential_step(v);
        if step.length_squared() < (MIN_MOVE * old.size).powi(2) {
            return;
        }
        if !STEPS.into_iter().any(|fraction| self.try_move(v, old.position + fraction * step)) {
            self.tally.refused_moves += 1;
        }
    }

    /// From `v` to the area-weighted mean of the centres of its faces, without the part along the normal.
    ///
    /// Areas count in units of the squared target length, so that graded sizes stay graded.
    fn tangential_step(&self, v: u32) -> DVec3 {
        let work = &self.work;
        let centre = &work.vertices[v as usize];
        let (mut sum, mut weights, mut normal) = (DVec3::ZERO, 0.0, DVec3::ZERO);
        for h in work.ring(v) {
            let corner = work.corners(h);
            let (x, y) = (&work.vertices[work.tgt(h) as usize], &work.vertices[work.apex(h) as usize]);
            let shape = Shape::of(corner);
            let size = (centre.size + x.size + y.size) / 3.0;
            let weight = shape.twice_area / (size * size);
            sum += weight * (x.position + y.position + centre.position);
            weights += 3.0 * weight;
            normal += shape.twice;
        }
        if weights <= 0.0 {
            return DVec3::ZERO;
        }
        let (step, normal) = (sum / weights - centre.position, normal.normalize_or_zero());
        step - normal * normal.dot(step)
    }

    fn relax_on_curve(&mut self, v: u32) {
        let work = &self.work;
        let [before, after] = work.curve_neighbours(v);
        if before == NONE || after == NONE {
            return;
        }
        let (first, second) = (work.segments[before as usize], work.segments[after as usize]);
        let curve = &self.curves[first.curve as usize];
        let [left, right] = [first.arc[1] - first.arc[0], second.arc[1] - second.arc[0]];
        let size = |end: u32| work.vertices[end as usize].size;
        let (l, r) = (size(first.ends[0]), size(second.ends[1]));
        let wanted = (left + right) * l / (l + r);
        let old = work.vertices[v as usize];
        if (wanted - left).abs() < MIN_MOVE * old.size {
            return;
        }
        let deviation = |arc: [f64; 2]| curve.chord_deviation(arc[0], arc[1]);
        let limit = self.options.max_chain_deviation_rel * old.size;
        for fraction in STEPS {
            let shift = fraction * (wanted - left);
            let arcs = [[first.arc[0], first.arc[1] + shift], [second.arc[0] + shift, second.arc[1]]];
            if arcs.iter().any(|&arc| deviation(arc) > limit) {
                continue;
            }
            let moved = Vertex { valence: old.valence, ..self.curve_vertex(first.curve, arcs[1][0], old.size) };
            if self.work.may_become(v, &moved, NONE, &self.surface, &self.limits) {
                self.work.vertices[v as usize] = moved;
                self.set_arc(before, arcs[0]);
                self.set_arc(after, arcs[1]);
                self.tally.moves += 1;
                return;
            }
        }
        self.tally.refused_moves += 1;
    }

    /// Stores the arc lengths of a segment, its start brought within one turn of a closed curve.
    pub(super) fn set_arc(&mut self, s: u32, arc: [f64; 2]) {
        let segment = &mut self.work.segments[s as usize];
        let length = self.curves[segment.curve as usize].length();
        let turn = match arc[0] {
            t if t >= length => -length,
            t if t < 0.0 => length,
            _ => 0.0,
        };
        segment.arc = arc.map(|t| t + turn);
    }
}
