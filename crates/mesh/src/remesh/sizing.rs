//! Target lengths where the wanted ones are too coarse: strong curvature, narrow gaps between curves.
//!
//! In: the decimated work mesh, wanted lengths at its vertices. Out: smaller or equal ones, graded.
//! Holds: no length falls below the least one allowed; lengths of neighbours differ by a bounded slope.
//! Source: chord deviation of a circle, length²·κ/8; grading as a Lipschitz bound along edges.

use super::Remesher;
use super::work::{NONE, next, prev};

/// Edge length over the height of one row of triangles between a curve and the next vertices.
///
/// 2.4 makes isosceles triangles of 40°, 40°, 100°. Equilateral ones, 1.15, would cost four times as many
/// triangles on thin plates; 2.8 gives angles over 110°.
const LENGTH_PER_ROW: f64 = 2.4;
/// The same for the width of a gap between two curves, which holds two rows.
const LENGTH_PER_GAP: f64 = 0.5 * LENGTH_PER_ROW;
/// An edge from a curve to a free vertex that is shorter than this, relative to the target, is the height of a row.
const SHORT_ROW: f64 = 1.0 / LENGTH_PER_ROW;
/// Largest change of the target length per length walked. Larger: fewer triangles, worse angles between sizes.
const MAX_SLOPE: f64 = 0.4;
/// Sweeps of the grading; lengths differ by a factor of at most 1 / min_length_rel, so that few suffice.
const MAX_SWEEPS: usize = 16;

impl Remesher<'_> {
    /// Lowers target lengths where the present edges show that they are too long.
    pub(super) fn adapt_sizes(&mut self) {
        let wanted: Vec<f64> = self.work.vertices.iter().map(|v| v.size).collect();
        let mut size = wanted.clone();
        let mut lower = |v: u32, length: f64| size[v as usize] = size[v as usize].min(length);
        for h in self.work.edges() {
            let bound = self.curvature_bound(h).min(self.gap_bound(h));
            lower(self.work.org(h), bound);
            lower(self.work.tgt(h), bound);
        }
        for v in 0..wanted.len() as u32 {
            if self.work.out[v as usize] != NONE && self.work.role(v) == super::work::Role::OnCurve {
                lower(v, self.chain_bound(v));
            }
        }
        for (v, (&new, &old)) in size.iter().zip(&wanted).enumerate() {
            self.work.vertices[v].size = new.max(self.options.min_length_rel * self.base_size(v as u32)).min(old);
        }
        self.grade_sizes();
    }

    /// Length at which an edge like `h` would deviate from the surface by just what is allowed.
    fn curvature_bound(&self, h: u32) -> f64 {
        let sag = self.relative_sag(h);
        let target = self.work.target(h);
        let length = self.work.length_sq(h).sqrt();
        if sag * target <= 1e-9 * length {
            return f64::INFINITY;
        }
        // On a curved surface the height grows with the square of the length. Where it is below the limit, the edge may
        // as well cross a crease, over which it grows with the length only: that is the milder bound.
        let room = self.limits.max_deviation / sag;
        length * room.max(room.sqrt())
    }

    /// Length of the edges that fill the gap between two curves with well-shaped triangles, if `h` spans one.
    fn gap_bound(&self, h: u32) -> f64 {
        let work = &self.work;
        if work.seg(h) != NONE {
            return f64::INFINITY;
        }
        let length = work.length_sq(h).sqrt();
        match [work.org(h), work.tgt(h)].map(|v| work.on_feature(v)) {
            [true, true] => {
                // Across the tip of a wedge the gap closes anyway; smaller triangles would not be better ones.
                let tip = |side: u32| side != NONE && work.seg(next(side)) != NONE && work.seg(prev(side)) != NONE;
                if tip(h) || tip(work.twin(h)) { f64::INFINITY } else { LENGTH_PER_GAP * length }
            }
            [false, false] => f64::INFINITY,
            _ if length < SHORT_ROW * work.target(h) => LENGTH_PER_ROW * length,
            _ => f64::INFINITY,
        }
    }

    /// Length at which the curve at `v` would deviate from its chords by just what is allowed.
    fn chain_bound(&self, v: u32) -> f64 {
        let [before, after] = self.work.curve_neighbours(v);
        if before == NONE || after == NONE {
            return f64::INFINITY;
        }
        let (first, second) = (self.work.segments[before as usize], self.work.segments[after as usize]);
        let curve = &self.curves[first.curve as usize];
        let span = first.arc[1] - first.arc[0] + second.arc[1] - second.arc[0];
        let deviation = curve.chord_deviation(first.arc[0], first.arc[0] + span);
        let allowed = self.options.max_chain_deviation_rel * self.work.vertices[v as usize].size;
        if deviation <= 1e-9 * span { f64::INFINITY } else { span * (allowed / deviation).sqrt() }
    }

    /// Makes sizes change slowly along edges.
    fn grade_sizes(&mut self) {
        let edges: Vec<u32> = self.work.edges().collect();
        for sweep in 0..MAX_SWEEPS {
            let mut changed = false;
            for i in 0..edges.len() {
                let h = edges[if sweep % 2 == 0 { i } else { edges.len() - 1 - i }];
                let (a, b) = (self.work.org(h) as usize, self.work.tgt(h) as usize);
                let step = MAX_SLOPE * self.work.length_sq(h).sqrt();
                for (from, to) in [(a, b), (b, a)] {
                    let limit = self.work.vertices[from].size + step;
                    if self.work.vertices[to].size > limit {
                        self.work.vertices[to].size = limit;
                        changed = true;
                    }
                }
            }
            if !changed {
                break;
            }
        }
    }
}
