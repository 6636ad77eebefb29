//! The mutable triangle mesh that the remesher edits: half-edges in arrays, split, collapse and flip.
//!
//! In: a [`TriMesh`], its curve segments per half-edge. Out: the edited arrays.
//! Holds: an oriented 2-manifold with boundary after every operation whose precondition held; half-edges
//! of face f are 3f, 3f+1, 3f+2 as in [`crate::connectivity`]; dead elements are marked, never reused.
//! Source: the classical half-edge structure; the link condition of Dey, Edelsbrunner, Guha, Nekhayev (1999).

use crate::ids::{HalfEdgeId, VertexId};
use crate::mesh::TriMesh;
use glam::DVec3;

/// No element.
pub(super) const NONE: u32 = u32::MAX;

/// What may be done with a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// It moves on the surface.
    Free,
    /// It moves along one curve.
    OnCurve,
    /// It stays where it is.
    Pinned,
}

/// All that belongs to a vertex besides connectivity.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex {
    /// Position, file units.
    pub position: DVec3,
    /// Normal of the input surface there; zero on curves, where there is none.
    pub normal: DVec3,
    /// Target edge length, file units.
    pub size: f64,
    /// How far removed vertices may lie from the surface around this one, file units (an upper bound, summed up).
    pub error: f64,
    /// A face of the input near which the vertex lies.
    pub hint: u32,
    /// The input vertex it is, where it is pinned; a half-edge of the input edge it lies on, where it is on a curve.
    pub source: u32,
    /// What may be done with it.
    pub role: Role,
    /// Whether it stays, with all edges and faces between such.
    pub kept: bool,
    /// Number of edges.
    pub valence: u32,
}

/// A piece of a curve between two neighbouring vertices on it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    /// The curve.
    pub curve: u32,
    /// First and last vertex, in the curve's direction.
    pub ends: [u32; 2],
    /// Arc length on the curve at both ends; on a closed curve the last may exceed the total length.
    pub arc: [f64; 2],
}

/// The mutable mesh.
pub(super) struct Work {
    /// Origin of each half-edge; `NONE` where its face is dead.
    pub origin: Vec<u32>,
    /// The same edge seen from the neighbour; `NONE` on the boundary.
    pub twin: Vec<u32>,
    /// Curve segment of each half-edge, or `NONE`; the same on both sides.
    pub segment: Vec<u32>,
    /// Region between curves to which each face belongs.
    pub patch: Vec<u32>,
    /// One outgoing half-edge per vertex, on the boundary the one without a twin; `NONE` for dead vertices.
    pub out: Vec<u32>,
    /// The vertices.
    pub vertices: Vec<Vertex>,
    /// The curve segments; dead ones are no longer referred to by a half-edge.
    pub segments: Vec<Segment>,
}

/// Next side of the same face.
#[inline]
pub(super) fn next(h: u32) -> u32 {
    if h % 3 == 2 { h - 2 } else { h + 1 }
}

/// Previous side of the same face.
#[inline]
pub(super) fn prev(h: u32) -> u32 {
    if h.is_multiple_of(3) { h + 2 } else { h - 1 }
}

impl Work {
    /// Copies the connectivity of `mesh`; vertices come with their attributes, half-edges without segments.
    pub fn new(mesh: &TriMesh, patch: Vec<u32>, mut vertices: Vec<Vertex>) -> Self {
        let half_edges = (0..mesh.half_edge_count()).map(HalfEdgeId::new);
        for (v, vertex) in vertices.iter_mut().enumerate() {
            vertex.valence = mesh.valence(VertexId::new(v)) as u32;
        }
        Self {
            origin: half_edges.clone().map(|h| mesh.origin(h).0).collect(),
            twin: half_edges.map(|h| mesh.twin(h).map_or(NONE, |t| t.0)).collect(),
            segment: vec![NONE; mesh.half_edge_count()],
            patch,
            out: mesh.vertices().map(|v| mesh.outgoing_half_edge(v).0).collect(),
            vertices,
            segments: Vec::new(),
        }
    }

    /// Origin of a half-edge.
    #[inline]
    pub fn org(&self, h: u32) -> u32 {
        self.origin[h as usize]
    }
    /// Target of a half-edge.
    #[inline]
    pub fn tgt(&self, h: u32) -> u32 {
        self.origin[next(h) as usize]
    }
    /// Twin of a half-edge, or `NONE`.
    #[inline]
    pub fn twin(&self, h: u32) -> u32 {
        self.twin[h as usize]
    }
    /// Segment of a half-edge, or `NONE`.
    #[inline]
    pub fn seg(&self, h: u32) -> u32 {
        self.segment[h as usize]
    }
    /// Whether a half-edge's face is alive.
    #[inline]
    pub fn alive(&self, h: u32) -> bool {
        self.origin[h as usize] != NONE
    }
    /// Position of a vertex.
    #[inline]
    pub fn pos(&self, v: u32) -> DVec3 {
        self.vertices[v as usize].position
    }
    /// Role of a vertex.
    #[inline]
    pub fn role(&self, v: u32) -> Role {
        self.vertices[v as usize].role
    }
    /// Whether a vertex lies on a curve.
    #[inline]
    pub fn on_feature(&self, v: u32) -> bool {
        self.vertices[v as usize].role != Role::Free
    }
    /// Whether a vertex lies on the boundary.
    #[inline]
    pub fn on_boundary(&self, v: u32) -> bool {
        self.twin(self.out[v as usize]) == NONE
    }
    /// Squared length of a half-edge.
    #[inline]
    pub fn length_sq(&self, h: u32) -> f64 {
        self.pos(self.org(h)).distance_squared(self.pos(self.tgt(h)))
    }
    /// Length of a half-edge divided by the target there.
    #[inline]
    pub fn ratio(&self, h: u32) -> f64 {
        (self.length_sq(h)).sqrt() / self.target(h)
    }
    /// Whether an edge joins two vertices that stay.
    #[inline]
    pub fn stays(&self, h: u32) -> bool {
        self.vertices[self.org(h) as usize].kept && self.vertices[self.tgt(h) as usize].kept
    }
    /// Target length of an edge: the smaller one of its ends.
    #[inline]
    pub fn target(&self, h: u32) -> f64 {
        self.vertices[self.org(h) as usize].size.min(self.vertices[self.tgt(h) as usize].size)
    }
    /// Number of faces ever made.
    pub fn face_slots(&self) -> u32 {
        self.patch.len() as u32
    }
    /// Canonical half-edges of all live edges, ascending.
    pub fn edges(&self) -> impl Iterator<Item = u32> + '_ {
        // `NONE` is larger than every id, so that boundary half-edges are canonical.
        (0..self.origin.len() as u32).filter(|&h| self.alive(h) && h < self.twin(h))
    }
    /// The outgoing half-edges of a live vertex, counter-clockwise, on the boundary all of them.
    #[inline]
    pub fn ring(&self, v: u32) -> Ring<'_> {
        let start = self.out[v as usize];
        Ring { work: self, start, next: start }
    }
    /// Calls `see` with every half-edge at `v`, outgoing or (last one of a boundary fan) incoming, and its other end.
    #[inline]
    pub fn for_neighbours(&self, v: u32, mut see: impl FnMut(u32, u32)) {
        let mut last = NONE;
        for h in self.ring(v) {
            see(h, self.tgt(h));
            last = h;
        }
        let incoming = prev(last);
        if self.twin(incoming) == NONE {
            see(incoming, self.org(incoming));
        }
    }
    /// Whether an edge joins two vertices.
    pub fn adjacent(&self, a: u32, b: u32) -> bool {
        self.ring(a).any(|h| self.tgt(h) == b || self.org(prev(h)) == b)
    }
    /// The segments at a vertex on one curve: the one that ends there and the one that starts there.
    pub fn curve_neighbours(&self, v: u32) -> [u32; 2] {
        let mut found = [NONE; 2];
        self.for_neighbours(v, |h, _| {
            let s = self.seg(h);
            if s != NONE {
                found[usize::from(self.segments[s as usize].ends[0] == v)] = s;
            }
        });
        found
    }

    /// Whether the edge of `h` can be collapsed without changing the topology.
    ///
    /// Link condition: the ends have no common neighbours besides the vertices opposite to the edge, and an inner
    /// edge does not join two boundary vertices; besides, no vertex may be left with too few edges.
    pub fn link_condition(&self, h: u32, scratch: &mut Vec<u32>) -> bool {
        let (a, b, t) = (self.org(h), self.tgt(h), self.twin(h));
        if t != NONE && self.on_boundary(a) && self.on_boundary(b) {
            return false;
        }
        let opposite = [self.org(prev(h)), if t == NONE { NONE } else { self.org(prev(t)) }];
        for &c in opposite.iter().filter(|&&c| c != NONE) {
            let few = if self.on_boundary(c) { 2 } else { 3 };
            if self.vertices[c as usize].valence <= few {
                return false;
            }
        }
        let valence = self.vertices[a as usize].valence + self.vertices[b as usize].valence;
        let needed = match (t == NONE, self.on_boundary(a) || self.on_boundary(b)) {
            (true, _) => 3 + 2,
            (false, true) => 4 + 2,
            (false, false) => 4 + 3,
        };
        if valence < needed || opposite[0] == opposite[1] {
            return false;
        }
        scratch.clear();
        self.for_neighbours(a, |_, x| scratch.push(x));
        let mut common = 0;
        self.for_neighbours(b, |_, x| common += u32::from(scratch.contains(&x)));
        common == if t == NONE { 1 } else { 2 }
    }

    /// Collapses `h`: its origin a disappears, its target b takes over; needs [`Work::link_condition`].
    ///
    /// Positions and attributes of b are left to the caller; segments at a are handed on to b, and where a
    /// segment lies on `h` itself the caller has joined it to its neighbour before.
    pub fn collapse(&mut self, h: u32) {
        let (a, b, t) = (self.org(h), self.tgt(h), self.twin(h));
        let lost = if t == NONE { 3 } else { 4 };
        self.vertices[b as usize].valence =
            self.vertices[b as usize].valence + self.vertices[a as usize].valence - lost;
        // 1. Segments name their ends.
        if self.on_feature(a) {
            self.rename_segment_ends(a, b);
        }
        // 2. The fan of a gets the new origin, the one or two faces of the edge die.
        let start = self.out[a as usize];
        let mut g = start;
        loop {
            self.origin[g as usize] = b;
            g = self.twin(prev(g));
            if g == NONE || g == start {
                break;
            }
        }
        self.out[a as usize] = NONE;
        let first = self.close_face(h);
        let second = if t == NONE { NONE } else { self.close_face(t) };
        // 3. An outgoing half-edge for b.
        self.fix_out(if first != NONE { first } else { second });
    }

    /// Lets the segments that end at `a` end at `b`; not the one between the two.
    fn rename_segment_ends(&mut self, a: u32, b: u32) {
        let mut touched = Vec::new();
        self.for_neighbours(a, |g, x| {
            if x != b && self.seg(g) != NONE {
                touched.push(self.seg(g));
            }
        });
        for s in touched {
            for end in self.segments[s as usize].ends.iter_mut().filter(|end| **end == a) {
                *end = b;
            }
        }
    }

    /// Removes the face of `h` by joining its two other sides; returns a live outgoing half-edge of the target of `h`
    /// (or of its origin, which by now is the same vertex).
    fn close_face(&mut self, h: u32) -> u32 {
        let (n, p) = (next(h), prev(h));
        let (c, tn, tp) = (self.org(p), self.twin(n), self.twin(p));
        let segment = if self.seg(n) != NONE { self.seg(n) } else { self.seg(p) };
        for (x, y) in [(tn, tp), (tp, tn)] {
            if x != NONE {
                self.twin[x as usize] = y;
                self.segment[x as usize] = segment;
            }
        }
        for g in [h, n, p] {
            self.origin[g as usize] = NONE;
            self.segment[g as usize] = NONE;
            self.twin[g as usize] = NONE;
        }
        self.vertices[c as usize].valence -= 1;
        // tn leaves c, tp arrives there; seen from the merged vertex it is the other way round.
        self.fix_out(if tn != NONE { tn } else { next(tp) });
        if tp != NONE { tp } else { next(tn) }
    }

    /// Makes the clockwise-most half-edge of the fan of `h` the outgoing one of its origin.
    fn fix_out(&mut self, h: u32) {
        let (mut g, v) = (h, self.org(h));
        loop {
            let t = self.twin(g);
            if t == NONE {
                break;
            }
            g = next(t);
            if g == h {
                break;
            }
        }
        self.out[v as usize] = g;
    }

    /// Splits the edge of `h` with the new vertex `middle`, whose id is returned; a segment is halved at `arc`.
    ///
    /// ```text
    ///        c                    c
    ///      / f \                / | \
    ///    a ──h── b     →      a ─h m ── b      faces f, g keep a; two new ones get b
    ///      \ g /                \ | /
    ///        d                    d
    /// ```
    pub fn split(&mut self, h: u32, mut middle: Vertex, arc: f64) -> u32 {
        let (a, b, t) = (self.org(h), self.tgt(h), self.twin(h));
        let (m, s) = (self.vertices.len() as u32, self.seg(h));
        let second_half = if s == NONE { NONE } else { self.halve_segment(s, m, arc) };
        middle.valence = if t == NONE { 3 } else { 4 };
        self.vertices.push(middle);
        // 1. The side of f: h becomes a→m, next(h) becomes m→c, the new face is (m, b, c).
        let n = next(h);
        let c = self.org(prev(h));
        let f2 = self.push_face([m, b, c], self.patch[(h / 3) as usize]);
        self.hand_over(n, f2 + 1);
        self.origin[n as usize] = m;
        self.join(n, f2 + 2);
        self.vertices[c as usize].valence += 1;
        if self.out[b as usize] == n {
            self.out[b as usize] = f2 + 1;
        }
        self.out.push(f2);
        // 2. The side of g: t becomes m→a, prev(t) becomes d→m, the new face is (b, m, d).
        if t != NONE {
            let p = prev(t);
            let d = self.org(p);
            let f3 = self.push_face([b, m, d], self.patch[(t / 3) as usize]);
            self.hand_over(p, f3 + 2);
            self.origin[t as usize] = m;
            self.join(p, f3 + 1);
            self.join(f2, f3);
            self.vertices[d as usize].valence += 1;
            for (v, old, new) in [(b, t, f3), (d, p, f3 + 2)] {
                if self.out[v as usize] == old {
                    self.out[v as usize] = new;
                }
            }
            self.segment[f3 as usize] = s;
            self.segment[t as usize] = s;
        }
        // 3. The two halves of the edge.
        for (side, v) in [(h, a), (f2, b)] {
            let half = if s == NONE || self.segments[s as usize].ends.contains(&v) { s } else { second_half };
            self.segment[side as usize] = half;
            if self.twin(side) != NONE {
                let twin = self.twin(side);
                self.segment[twin as usize] = half;
            }
        }
        m
    }

    fn halve_segment(&mut self, s: u32, middle: u32, arc: f64) -> u32 {
        let whole = self.segments[s as usize];
        self.segments[s as usize] = Segment { ends: [whole.ends[0], middle], arc: [whole.arc[0], arc], ..whole };
        self.segments.push(Segment { ends: [middle, whole.ends[1]], arc: [arc, whole.arc[1]], ..whole });
        self.segments.len() as u32 - 1
    }

    fn push_face(&mut self, corners: [u32; 3], patch: u32) -> u32 {
        let first = self.origin.len() as u32;
        self.origin.extend(corners);
        self.twin.extend([NONE; 3]);
        self.segment.extend([NONE; 3]);
        self.patch.push(patch);
        first
    }

    /// Gives neighbour and segment of half-edge `from` to `to`.
    fn hand_over(&mut self, from: u32, to: u32) {
        let t = self.twin(from);
        self.join(to, t);
        self.segment[to as usize] = self.seg(from);
        self.segment[from as usize] = NONE;
    }

    fn join(&mut self, g: u32, h: u32) {
        self.twin[g as usize] = h;
        if h != NONE {
            self.twin[h as usize] = g;
        }
    }

    /// Puts a free vertex into a face, which becomes three; returns its id.
    pub fn split_face(&mut self, f: u32, mut middle: Vertex) -> u32 {
        let m = self.vertices.len() as u32;
        let [h, n, p] = [3 * f, 3 * f + 1, 3 * f + 2];
        let [a, b, c] = [h, n, p].map(|g| self.org(g));
        middle.valence = 3;
        self.vertices.push(middle);
        let patch = self.patch[f as usize];
        let (f2, f3) = (self.push_face([b, c, m], patch), self.push_face([c, a, m], patch));
        self.hand_over(n, f2);
        self.hand_over(p, f3);
        self.origin[p as usize] = m;
        self.join(n, f2 + 2);
        self.join(f2 + 1, f3 + 2);
        self.join(f3 + 1, p);
        self.out.push(p);
        for (v, old, new) in [(b, n, f2), (c, p, f3)] {
            if self.out[v as usize] == old {
                self.out[v as usize] = new;
            }
        }
        for v in [a, b, c] {
            self.vertices[v as usize].valence += 1;
        }
        m
    }

    /// Flips an inner edge; the opposite vertices must not be adjacent yet, and no segment may lie on it.
    ///
    /// ```text
    ///        c                    c
    ///      / f \                / | \
    ///    a ──h── b     →      a  f|g  b        h becomes d→c, its twin c→d
    ///      \ g /                \ | /
    ///        d                    d
    /// ```
    pub fn flip(&mut self, h: u32) {
        let t = self.twin(h);
        let (n, p, tn, tp) = (next(h), prev(h), next(t), prev(t));
        let (a, b, c, d) = (self.org(h), self.org(t), self.org(p), self.org(tp));
        let outer = [n, p, tn, tp].map(|g| (self.twin(g), self.seg(g)));
        for (g, origin) in [(h, d), (n, c), (p, a), (t, c), (tn, d), (tp, b)] {
            self.origin[g as usize] = origin;
        }
        // n: b→c ↦ c→a, p: c→a ↦ a→d, tn: a→d ↦ d→b, tp: d→b ↦ b→c
        for (g, (twin, segment)) in [(tp, outer[0]), (n, outer[1]), (p, outer[2]), (tn, outer[3])] {
            self.join(g, twin);
            self.segment[g as usize] = segment;
        }
        for (v, old, new) in [(a, [h, tn], p), (b, [t, n], tp), (c, [p, p], n), (d, [tp, tp], tn)] {
            if old.contains(&self.out[v as usize]) {
                self.out[v as usize] = new;
            }
        }
        for (v, up) in [(a, false), (b, false), (c, true), (d, true)] {
            let valence = &mut self.vertices[v as usize].valence;
            *valence = if up { *valence + 1 } else { *valence - 1 };
        }
    }

    /// Drops dead elements, keeping the order of the live ones.
    pub fn compact(&mut self) {
        // 1. New numbers.
        let number = |alive: &mut dyn Iterator<Item = bool>| {
            let mut count = 0;
            let map: Vec<u32> = alive
                .map(|live| {
                    count += u32::from(live);
                    if live { count - 1 } else { NONE }
                })
                .collect();
            (map, count)
        };
        let (vertex, vertex_count) = number(&mut self.out.iter().map(|&h| h != NONE));
        let (face, face_count) = number(&mut self.origin.chunks_exact(3).map(|f| f[0] != NONE));
        let mut used = vec![false; self.segments.len()];
        self.segment.iter().filter(|&&s| s != NONE).for_each(|&s| used[s as usize] = true);
        let (segment, segment_count) = number(&mut used.iter().copied());
        let renumber = |map: &[u32], i: u32| if i == NONE { NONE } else { map[i as usize] };
        let half_edge = |h: u32| if h == NONE { NONE } else { 3 * face[(h / 3) as usize] + h % 3 };
        // 2. Move down in place: new numbers never exceed old ones.
        for (old, &new) in face.iter().enumerate().filter(|&(_, &new)| new != NONE) {
            let new = new as usize;
            self.patch[new] = self.patch[old];
            for k in 0..3 {
                self.origin[3 * new + k] = vertex[self.origin[3 * old + k] as usize];
                self.twin[3 * new + k] = half_edge(self.twin[3 * old + k]);
                self.segment[3 * new + k] = renumber(&segment, self.segment[3 * old + k]);
            }
        }
        for (old, &new) in vertex.iter().enumerate().filter(|&(_, &new)| new != NONE) {
            self.out[new as usize] = half_edge(self.out[old]);
            self.vertices[new as usize] = self.vertices[old];
        }
        for (old, &new) in segment.iter().enumerate().filter(|&(_, &new)| new != NONE) {
            let s = self.segments[old];
            self.segments[new as usize] = Segment { ends: s.ends.map(|v| vertex[v as usize]), ..s };
        }
        // 3. Cut off the rest.
        let half_edge_count = 3 * face_count as usize;
        self.origin.truncate(half_edge_count);
        self.twin.truncate(half_edge_count);
        self.segment.truncate(half_edge_count);
        self.patch.truncate(face_count as usize);
        self.out.truncate(vertex_count as usize);
        self.vertices.truncate(vertex_count as usize);
        self.segments.truncate(segment_count as usize);
    }
}

/// Iterator over the outgoing half-edges of a vertex.
pub(super) struct Ring<'a> {
    work: &'a Work,
    start: u32,
    next: u32,
}

impl Iterator for Ring<'_> {
    type Item = u32;
    #[inline]
    fn next(&mut self) -> Option<u32> {
        let h = self.next;
        if h == NONE {
            return None;
        }
        let g = self.work.twin(prev(h));
        self.next = if g == self.start { NONE } else { g };
        Some(h)
    }
}

#[cfg(test)]
impl Work {
    /// The first broken invariant, if there is one.
    pub fn validate(&self) -> Result<(), String> {
        for h in 0..self.origin.len() as u32 {
            if !self.alive(h) {
                continue;
            }
            let t = self.twin(h);
            if t != NONE {
                if !self.alive(t) || self.twin(t) != h || self.org(t) != self.tgt(h) || self.tgt(t) != self.org(h) {
                    return Err(format!("half-edge {h} and its twin {t} do not match"));
                }
                if self.seg(t) != self.seg(h) {
                    return Err(format!("half-edge {h} and its twin {t} have different segments"));
                }
            }
            if self.seg(h) != NONE {
                let mut ends = self.segments[self.seg(h) as usize].ends;
                let mut own = [self.org(h), self.tgt(h)];
                ends.sort_unstable();
                own.sort_unstable();
                if ends != own {
                    return Err(format!("segment of {h} has ends {ends:?}, not {own:?}"));
                }
            }
            if self.out[self.org(h) as usize] == NONE {
                return Err(format!("half-edge {h} starts at the dead vertex {}", self.org(h)));
            }
        }
        let mut corners = vec![0u32; self.out.len()];
        for &v in self.origin.iter().filter(|&&v| v != NONE) {
            corners[v as usize] += 1;
        }
        for v in 0..self.out.len() as u32 {
            let h = self.out[v as usize];
            if h == NONE {
                continue;
            }
            if !self.alive(h) || self.org(h) != v {
                return Err(format!("outgoing half-edge {h} of vertex {v} starts elsewhere"));
            }
            if self.ring(v).count() as u32 != corners[v as usize] {
                return Err(format!("vertex {v}: {} of {} corners reached", self.ring(v).count(), corners[v as usize]));
            }
            let mut valence = 0;
            self.for_neighbours(v, |_, _| valence += 1);
            if valence != self.vertices[v as usize].valence {
                return Err(format!("vertex {v} has {valence} edges, not {}", self.vertices[v as usize].valence));
            }
        }
        Ok(())
    }
}
