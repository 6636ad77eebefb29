//! Splitting edges that are too long, and edges between two curve vertices.
//!
//! In: the remesher's state. Out: more, shorter edges; no face has two curve edges, no inner edge joins two curves.
//! Holds: new vertices lie on the input's curves, or on its surface where that folds nothing.
//! Source: limit 4/3 of the target after Botsch, Kobbelt (2004); separation of features, [Bommes2012] §8.4.

use super::Remesher;
use super::collapse::LONG;
use super::flip::Goal;
use super::guard::Shape;
use super::surface::Foot;
use super::work::{NONE, Role, Segment, Vertex, next, prev};
use crate::progress::Cancelled;
use glam::DVec3;

/// Sweeps over long edges: an edge 4/3·2^k targets long needs k, more than 40 are never meant.
const MAX_SWEEPS: usize = 40;

/// Factor by which the longest edge must shrink from level to level; halving and flips give about a half.
const PROGRESS: f64 = 0.8;

impl Remesher<'_> {
    /// Brings edges of coarse input within twice the split limit, halving the longest ones level by level.
    ///
    /// Each level collapses what came out short: the midpoints of a row of needles would multiply otherwise.
    pub(super) fn refine_coarse(&mut self) -> Result<(), Cancelled> {
        let mut before = f64::INFINITY;
        for _ in 0..MAX_SWEEPS {
            let longest =
                self.work.edges().filter(|&h| !self.work.stays(h)).map(|h| self.work.ratio(h)).fold(0.0, f64::max);
            // An edge that refuses to be split must not keep the others going through levels that do nothing.
            if longest <= 2.0 * LONG || longest > PROGRESS * before || !self.split_sweep(0.5 * longest)? {
                break;
            }
            before = longest;
            self.collapse_short()?;
            self.work.compact();
            self.flip_edges(Goal::Angle)?;
        }
        Ok(())
    }

    /// Splits long edges, longest first, until there is none; edges that cannot be split without a fold stay.
    pub(super) fn split_long(&mut self) -> Result<(), Cancelled> {
        for _ in 0..MAX_SWEEPS {
            if !self.split_sweep(LONG)? {
                break;
            }
        }
        Ok(())
    }

    /// Splits the edges longer than `limit` times the target that there are now, longest first; says if one was split.
    fn split_sweep(&mut self, limit: f64) -> Result<bool, Cancelled> {
        let mut long: Vec<(f64, u32)> =
            self.work.edges().map(|h| (self.work.ratio(h), h)).filter(|&(ratio, _)| ratio > limit).collect();
        long.retain(|&(_, h)| !self.work.stays(h));
        long.sort_by(|x, y| y.0.total_cmp(&x.0).then(x.1.cmp(&y.1)));
        let mut changed = false;
        for (ratio, h) in long {
            self.tick()?;
            // A split moves half-edge ids to other edges: what is met may be another edge, in its turn later.
            if self.work.ratio(h) >= 0.75 * ratio && !self.beside_longer(h) {
                changed |= self.split_edge(h).is_some();
            }
        }
        Ok(changed)
    }

    /// Whether a face of `h` has a longer side that is too long as well: it has refused to be split, and splitting `h`
    /// in its stead would go on for ever.
    fn beside_longer(&self, h: u32) -> bool {
        let work = &self.work;
        let length_sq = work.length_sq(h);
        let longer = |g: u32| work.length_sq(g) > 1.01 * length_sq && work.ratio(g) > LONG;
        [h, work.twin(h)].into_iter().filter(|&side| side != NONE).any(|side| longer(next(side)) || longer(prev(side)))
    }

    /// Splits faces with three curve edges at their centre and inner edges between curve vertices in the middle.
    pub(super) fn separate_features(&mut self) -> Result<(), Cancelled> {
        for f in 0..self.work.face_slots() {
            let sides = [3 * f, 3 * f + 1, 3 * f + 2];
            if self.work.alive(3 * f) && sides.iter().all(|&h| self.work.seg(h) != NONE && !self.work.stays(h)) {
                self.split_face(f);
            }
        }
        // Splits hand edges on to new half-edges, so that those are gone through as well.
        let mut h = 0;
        while (h as usize) < self.work.origin.len() {
            self.tick()?;
            let work = &self.work;
            let inner = work.alive(h) && h < work.twin(h) && work.seg(h) == NONE && !work.stays(h);
            if inner && work.on_feature(work.org(h)) && work.on_feature(work.tgt(h)) {
                self.split_edge(h);
            }
            h += 1;
        }
        Ok(())
    }

    /// A face of the input near vertex `v` in region `patch`.
    pub(super) fn start_face(&self, v: u32, patch: u32) -> u32 {
        let vertex = &self.work.vertices[v as usize];
        match vertex.role {
            Role::Free => vertex.hint,
            Role::OnCurve => self.surface.face_at_half_edge(vertex.source, patch),
            Role::Pinned => self.surface.face_at_vertex(vertex.source, patch),
        }
    }

    /// The vertex of a curve at an arc length.
    pub(super) fn curve_vertex(&self, curve: u32, arc: f64, size: f64) -> Vertex {
        let (position, half_edge) = self.curves[curve as usize].point(arc);
        Vertex {
            position,
            normal: DVec3::ZERO,
            size,
            error: 0.0,
            hint: half_edge / 3,
            source: half_edge,
            role: Role::OnCurve,
            kept: false,
            valence: 0,
        }
    }

    /// A free vertex at the point of the input nearest to `position`, found from two vertices nearby.
    fn surface_vertex(&self, position: DVec3, from: [u32; 2], patch: u32, size: f64) -> Vertex {
        let starts = from.map(|v| self.start_face(v, patch));
        let mut foot = self.nearest_foot(position, starts.into_iter());
        if foot.distance_sq > (self.limits.max_deviation * size).powi(2) {
            // A walk that ended on the wrong side of an edge of the input: start from all faces around.
            foot = self.nearest_foot(position, starts.into_iter().flat_map(|f| self.surface.faces_around(f)));
        }
        Vertex {
            position: foot.point,
            normal: self.surface.normal[foot.face as usize],
            size,
            error: 0.0,
            hint: foot.face,
            source: NONE,
            role: Role::Free,
            kept: false,
            valence: 0,
        }
    }

    /// The nearest of the feet found from several faces; of equals the first.
    fn nearest_foot(&self, p: DVec3, starts: impl Iterator<Item = u32>) -> Foot {
        let feet = starts.map(|f| self.surface.walk(p, f));
        feet.reduce(|best, foot| if foot.distance_sq < best.distance_sq { foot } else { best })
            .unwrap_or_else(|| self.surface.foot_on_face(p, 0))
    }

    /// Splits one edge in the middle; `None` if that would fold a face.
    fn split_edge(&mut self, h: u32) -> Option<u32> {
        let work = &self.work;
        let (a, b, s) = (work.org(h), work.tgt(h), work.seg(h));
        let size = 0.5 * (work.vertices[a as usize].size + work.vertices[b as usize].size);
        let error = work.vertices[a as usize].error.max(work.vertices[b as usize].error);
        let (vertex, arc) = if s == NONE {
            let middle = work.pos(a).lerp(work.pos(b), 0.5);
            let vertex = self.surface_vertex(middle, [a, b], work.patch[(h / 3) as usize], size);
            let fits = self.halves_fit(h, &vertex);
            (if fits { vertex } else { Vertex { position: middle, ..vertex } }, 0.0)
        } else {
            let arc = self.split_arc(s, size)?;
            let vertex = self.curve_vertex(work.segments[s as usize].curve, arc, size);
            if !self.halves_fit(h, &vertex) {
                return None;
            }
            (vertex, arc)
        };
        self.tally.splits += 1;
        let m = self.work.split(h, Vertex { error, ..vertex }, arc);
        if s != NONE {
            self.curves[self.work.segments[s as usize].curve as usize].edges += 1;
            let second = self.work.segments.len() as u32 - 1;
            self.set_arc(second, self.work.segments[second as usize].arc);
        }
        Some(m)
    }

    /// Arc length at which to split a segment: the middle, or the polyline point nearest to it whose chords are near.
    fn split_arc(&self, s: u32, size: f64) -> Option<f64> {
        let Segment { curve, arc, .. } = self.work.segments[s as usize];
        let curve = &self.curves[curve as usize];
        let limit = self.options.max_chain_deviation_rel * size;
        let middle = 0.5 * (arc[0] + arc[1]);
        let near = |t: f64| curve.chord_deviation(arc[0], t).max(curve.chord_deviation(t, arc[1])) <= limit;
        let (piece, fraction) = curve.locate(middle);
        let base = middle - fraction * (curve.arc[piece + 1] - curve.arc[piece]);
        let ends = [base, base + curve.arc[piece + 1] - curve.arc[piece]];
        std::iter::once(middle).chain(ends).find(|&t| t > arc[0] && t < arc[1] && near(t))
    }

    /// Whether the faces that a split makes stay healthy.
    fn halves_fit(&self, h: u32, middle: &Vertex) -> bool {
        let work = &self.work;
        [h, work.twin(h)].into_iter().filter(|&side| side != NONE).all(|side| {
            let corner = work.corners(side);
            let old = Shape::of(corner);
            let normal = [side, next(side), prev(side)].map(|g| work.vertices[work.org(g) as usize].normal);
            let m = middle.position;
            let halves = [([corner[0], m, corner[2]], 0), ([m, corner[1], corner[2]], 1)];
            halves.into_iter().all(|(half, kept)| {
                let input = normal[kept] + normal[2] + middle.normal;
                let new = Shape::of(half);
                // The linear split has half the area; much less means that the middle comes near a side.
                new.may_replace(&old, input, &self.limits) && new.twice_area > 0.2 * old.twice_area
            })
        })
    }

    fn split_face(&mut self, f: u32) {
        let corner = self.work.corners(3 * f);
        let ends = [0, 1, 2].map(|k| self.work.org(3 * f + k));
        let centre = (corner[0] + corner[1] + corner[2]) / 3.0;
        let size = ends.iter().map(|&v| self.work.vertices[v as usize].size).fold(f64::INFINITY, f64::min);
        let vertex = self.surface_vertex(centre, [ends[0], ends[1]], self.work.patch[f as usize], size);
        self.work.split_face(f, Vertex { position: centre, ..vertex });
        self.tally.splits += 1;
    }
}
