//! Collapsing short edges: the decimation of fine input, and the collapse pass of a round.
//!
//! In: the remesher's state. Out: fewer, longer edges.
//! Holds: topology, corners and chains are kept; no face folds; removed vertices stay within the deviation.
//! Source: decimation by edge length with buckets; limits 4/5 and 4/3 of the target after Botsch, Kobbelt (2004).

use super::Remesher;
use super::guard::sag;
use super::work::{NONE, Role, Segment, Vertex, next, prev};
use crate::progress::Cancelled;

/// Edges shorter than this times the target collapse ([Botsch, Kobbelt 2004] §4).
pub(super) const SHORT: f64 = 4.0 / 5.0;
/// Edges longer than this times the target are split.
pub(super) const LONG: f64 = 4.0 / 3.0;
/// Number of length classes of the decimation: finer classes order better and cost nothing.
const CLASSES: usize = 32;

/// Where the vertex goes that two become.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    Origin,
    Target,
    Middle,
}

impl Remesher<'_> {
    /// Removes vertices of fine input, shortest edges first, keeping the remaining ones where they are.
    pub(super) fn decimate(&mut self) -> Result<(), Cancelled> {
        let mut classes: Vec<Vec<u32>> = vec![Vec::new(); CLASSES];
        let class = |ratio: f64| (ratio * (CLASSES as f64 / SHORT)) as usize;
        let edges: Vec<u32> = self.work.edges().collect();
        for &h in edges.iter().rev() {
            if let Some(list) = classes.get_mut(class(self.work.ratio(h))) {
                list.push(h);
            }
        }
        let mut current = 0;
        while current < CLASSES {
            let Some(h) = classes[current].pop() else {
                current += 1;
                continue;
            };
            if !self.work.alive(h) || class(self.work.ratio(h)) != current {
                continue;
            }
            self.tick()?;
            let Some(kept) = self.collapse_to_end(h) else { continue };
            let work = &self.work;
            work.for_neighbours(kept, |g, _| {
                if let Some(list) = classes.get_mut(class(work.ratio(g))) {
                    list.push(g);
                    current = current.min(class(work.ratio(g)));
                }
            });
        }
        Ok(())
    }

    /// Collapses an edge into the better of its ends; returns the vertex that is left.
    fn collapse_to_end(&mut self, h: u32) -> Option<u32> {
        // The vertex of fewer edges goes first: its ring is cheaper to fill well.
        let [a, b] = [self.work.org(h), self.work.tgt(h)].map(|v| self.work.vertices[v as usize].valence);
        let order = if a <= b { [Place::Target, Place::Origin] } else { [Place::Origin, Place::Target] };
        order.into_iter().find_map(|place| self.try_collapse(h, place))
    }

    /// One pass over all short edges, in the order of their ids.
    pub(super) fn collapse_short(&mut self) -> Result<(), Cancelled> {
        for h in 0..self.work.origin.len() as u32 {
            if !self.work.alive(h) || h > self.work.twin(h) || self.work.ratio(h) >= SHORT {
                continue;
            }
            self.tick()?;
            let [a, b] = [self.work.org(h), self.work.tgt(h)].map(|v| self.work.role(v));
            let movable = a == b && a != Role::Pinned;
            if movable && self.try_collapse(h, Place::Middle).is_some() {
                continue;
            }
            self.collapse_to_end(h);
        }
        Ok(())
    }

    /// Collapses an edge if everything allows it; returns the vertex that is left.
    fn try_collapse(&mut self, h: u32, place: Place) -> Option<u32> {
        let (a, b) = (self.work.org(h), self.work.tgt(h));
        if !self.roles_allow(h, place) || !self.work.link_condition(h, &mut self.scratch) {
            return None;
        }
        let merged = self.merged_vertex(h, place)?;
        if !self.lengths_allow(h, &merged) {
            return None;
        }
        for (v, other) in [(a, b), (b, a)] {
            let moves = self.work.pos(v) != merged.position;
            if moves && !self.work.may_become(v, &merged, other, &self.surface, &self.limits) {
                return None;
            }
        }
        if self.work.seam_folds(h, merged.position) {
            return None;
        }
        let error = self.removal_error(h, &merged, place);
        if error > self.limits.max_deviation * merged.size {
            return None;
        }
        self.join_segments(h, place)?;
        self.work.collapse(h);
        let valence = self.work.vertices[b as usize].valence;
        self.work.vertices[b as usize] = Vertex { valence, error, ..merged };
        self.tally.collapses += 1;
        Some(b)
    }

    /// Features stay: a vertex on a curve only slides along it, and no new edge joins two curves.
    fn roles_allow(&self, h: u32, place: Place) -> bool {
        let work = &self.work;
        let (a, b) = (work.org(h), work.tgt(h));
        let removed = [(a, b, Place::Origin), (b, a, Place::Target)];
        removed.into_iter().filter(|removal| removal.2 != place).all(|(gone, kept, _)| {
            match (work.role(gone), work.seg(h)) {
                _ if work.vertices[gone as usize].kept => false,
                (Role::Pinned, _) | (Role::OnCurve, NONE) => false,
                (Role::OnCurve, s) => {
                    let curve = &self.curves[work.segments[s as usize].curve as usize];
                    curve.edges > curve.min_edges
                }
                (Role::Free, _) => !work.on_feature(kept) || !self.would_bridge(gone, kept, h),
            }
        })
    }

    /// Whether merging the free vertex `gone` into `kept`, on a curve, makes a new edge between two curve vertices.
    fn would_bridge(&self, gone: u32, kept: u32, h: u32) -> bool {
        let work = &self.work;
        let apex = [work.apex(h), work.apex(work.twin(h))];
        let mut bridge = false;
        work.for_neighbours(gone, |_, x| bridge |= x != kept && !apex.contains(&x) && work.on_feature(x));
        bridge
    }

    /// The vertex that the ends of `h` become, on the input surface.
    fn merged_vertex(&self, h: u32, place: Place) -> Option<Vertex> {
        let work = &self.work;
        let (a, b) = (work.vertices[work.org(h) as usize], work.vertices[work.tgt(h) as usize]);
        let size = a.size.min(b.size);
        match (place, work.seg(h)) {
            (Place::Origin, _) => Some(Vertex { size, ..a }),
            (Place::Target, _) => Some(Vertex { size, ..b }),
            (Place::Middle, NONE) => {
                let foot = self.surface.walk(a.position.lerp(b.position, 0.5), a.hint);
                let normal = self.surface.normal[foot.face as usize];
                Some(Vertex { position: foot.point, normal, hint: foot.face, size, ..a })
            }
            (Place::Middle, s) => {
                let Segment { curve, arc, .. } = work.segments[s as usize];
                Some(self.curve_vertex(curve, 0.5 * (arc[0] + arc[1]), size))
            }
        }
    }

    /// No edge may come out longer than the split limit, unless one that long is there already.
    fn lengths_allow(&self, h: u32, merged: &Vertex) -> bool {
        let work = &self.work;
        let (a, b) = (work.org(h), work.tgt(h));
        let mut allowed = true;
        for v in [a, b] {
            if work.pos(v) == merged.position {
                continue;
            }
            let mut present = None;
            work.for_neighbours(v, |_, x| {
                let (other, length_sq) = (&work.vertices[x as usize], merged.position.distance_squared(work.pos(x)));
                let limit = LONG * merged.size.min(other.size);
                if x != a && x != b && length_sq > limit * limit {
                    allowed &= length_sq <= *present.get_or_insert_with(|| work.longest_sq(v));
                }
            });
        }
        allowed
    }

    /// Upper bound of the distance of all vertices removed here from the new faces, file units.
    fn removal_error(&self, h: u32, merged: &Vertex, place: Place) -> f64 {
        let work = &self.work;
        let (a, b) = (work.org(h), work.tgt(h));
        let carried = work.vertices[a as usize].error.max(work.vertices[b as usize].error);
        let distance = match place {
            Place::Target => work.distance_to_fan(a, merged.position, b, work.pos(a)),
            Place::Origin => work.distance_to_fan(b, merged.position, a, work.pos(b)),
            // A new place on the surface: the sag limit of its edges bounds the deviation.
            Place::Middle => 0.0,
        };
        carried + distance
    }

    /// Joins the segment of `h` with its neighbours on the curve; `None` (and no change) if the curve would be left.
    fn join_segments(&mut self, h: u32, place: Place) -> Option<()> {
        let work = &self.work;
        let s = work.seg(h);
        // A triangle with two curve edges that become one would lose one of them.
        for side in [h, work.twin(h)] {
            if side != NONE && work.seg(next(side)) != NONE && work.seg(prev(side)) != NONE {
                return None;
            }
        }
        if s == NONE {
            return Some(());
        }
        let Segment { curve, ends, arc } = work.segments[s as usize];
        let goal = match place {
            Place::Origin => arc[usize::from(ends[1] == work.org(h))],
            Place::Target => arc[usize::from(ends[1] == work.tgt(h))],
            Place::Middle => 0.5 * (arc[0] + arc[1]),
        };
        // 1. The neighbours that grow, with their new arc lengths, shifted by a turn where the curve closes.
        let mut grown = Vec::new();
        let length = self.curves[curve as usize].length();
        for (end, v) in ends.into_iter().enumerate() {
            if goal == arc[end] {
                continue;
            }
            let neighbour = work.curve_neighbours(v)[end];
            let mut piece = *work.segments.get(neighbour as usize)?;
            let shift = ((piece.arc[1 - end] - arc[end]) / length).round() * length;
            piece.arc[1 - end] = goal + shift;
            grown.push((neighbour, piece));
        }
        // 2. They must stay near the curve.
        let limit = self.options.max_chain_deviation_rel * work.target(h);
        let near = |piece: &Segment| self.curves[curve as usize].chord_deviation(piece.arc[0], piece.arc[1]) <= limit;
        if !grown.iter().all(|(_, piece)| near(piece)) {
            return None;
        }
        for (neighbour, piece) in grown {
            self.set_arc(neighbour, piece.arc);
        }
        self.curves[curve as usize].edges -= 1;
        Some(())
    }

    /// Height of the surface over an edge relative to the target length there.
    pub(super) fn relative_sag(&self, h: u32) -> f64 {
        let (a, b) = (&self.work.vertices[self.work.org(h) as usize], &self.work.vertices[self.work.tgt(h) as usize]);
        sag(a, b) / self.work.target(h)
    }
}
