//! Shortest walks in a cut surface.
//!
//! In: a cut surface, edge costs in units, classes. Out: shortest loops, connections and paths, as [`Walk`]s.
//! Holds: lengths are sums of integers, hence exact; ties go to the smaller id; a search stops as soon as nothing
//! shorter than its bound can come. Source: [Favreau2009] §3.2.1; truncation as in its §5.1.

use crate::classes::cost_of;
use crate::cost::FORBIDDEN;
use crate::cut_surface::{CutSurface, NONE, Walk};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Distances and predecessors of the last search; memory is kept from one to the next.
#[derive(Default)]
pub(crate) struct Search {
    label: Vec<Label>,
    stamp: u32,
    heap: BinaryHeap<Reverse<(u64, u32)>>,
    /// Vertices settled by the last search, nearest first.
    pub settled: Vec<u32>,
}

/// What a search knows of a vertex.
#[derive(Clone, Copy, Default)]
struct Label {
    stamp: u32,
    settled: bool,
    distance: u64,
    /// Vertex before it, and a half-edge of the edge between; `NONE` at sources.
    before: u32,
    edge: u32,
    /// Class of the path, or label of its source.
    class: u64,
}

/// A walk and its length, units.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Found {
    pub length: u64,
    pub walk: Walk,
}

impl Search {
    fn start(&mut self, vertices: usize) {
        if self.stamp == u32::MAX {
            self.label.clear();
            self.stamp = 0;
        }
        self.stamp += 1;
        self.label.resize(vertices, Label::default());
        self.heap.clear();
        self.settled.clear();
    }

    fn offer(&mut self, v: u32, distance: u64, before: u32, edge: u32, class: u64) {
        let label = &mut self.label[v as usize];
        if label.stamp == self.stamp && label.distance <= distance {
            return;
        }
        *label = Label { stamp: self.stamp, settled: false, distance, before, edge, class };
        self.heap.push(Reverse((distance, v)));
    }

    fn settle_next(&mut self) -> Option<(u64, u32)> {
        while let Some(Reverse((d, v))) = self.heap.pop() {
            let label = &mut self.label[v as usize];
            if !label.settled && label.distance == d {
                label.settled = true;
                self.settled.push(v);
                return Some((d, v));
            }
        }
        None
    }

    fn seen(&self, v: u32) -> Option<&Label> {
        Some(&self.label[v as usize]).filter(|l| l.stamp == self.stamp)
    }

    /// Distance of a settled vertex.
    pub fn distance(&self, v: u32) -> Option<u64> {
        self.seen(v).filter(|l| l.settled).map(|l| l.distance)
    }

    /// Label of the source of a settled vertex.
    pub fn label(&self, v: u32) -> Option<u64> {
        self.seen(v).filter(|l| l.settled).map(|l| l.class)
    }

    /// Vertex before `v` on its path, and the edge between; `None` at sources.
    pub fn before(&self, v: u32) -> Option<(u32, u32)> {
        self.seen(v).map(|l| (l.before, l.edge)).filter(|&(before, _)| before != NONE)
    }

    /// The path from `v` back to its source.
    pub fn path_back(&self, v: u32) -> Walk {
        let mut walk = Walk::start(v);
        while let Some((before, edge)) = self.before(walk.last()) {
            walk.push(edge, before);
        }
        walk
    }

    /// The shortest loop through `base`, shorter than `bound`, whose class is not trivial.
    ///
    /// # Output     the loop without the part that it runs twice; its length is that of the whole loop at `base`
    /// # Cost       O(k log k) for the k vertices within half the length
    pub fn shortest_loop(
        &mut self,
        s: &CutSurface,
        units: &[u64],
        class: &[u64],
        base: u32,
        bound: u64,
        trivial: impl Fn(u64) -> bool,
    ) -> Option<Found> {
        self.start(s.vertex_count());
        self.offer(base, 0, NONE, NONE, 0);
        let mut best = bound;
        let mut closing = None;
        while let Some((d, v)) = self.settle_next() {
            if 2 * d >= best {
                break;
            }
            let own = self.label[v as usize].class;
            s.for_edges(v, |h, w| {
                let cost = cost_of(s, units, h);
                if cost == FORBIDDEN {
                    return;
                }
                let through = own ^ class[h as usize];
                match self.seen(w) {
                    Some(other) if other.settled => {
                        let length = d + cost + other.distance;
                        if length < best && !trivial(through ^ other.class) {
                            best = length;
                            closing = Some((v, h, w));
                        }
                    }
                    _ => self.offer(w, d + cost, v, h, through),
                }
            });
        }
        let (v, h, w) = closing?;
        Some(Found { length: best, walk: self.close(v, h, w) })
    }

    /// The loop of two paths from one source and the edge between their ends, without the part that both share.
    fn close(&self, v: u32, h: u32, w: u32) -> Walk {
        let (mut a, mut b) = (self.path_back(v), self.path_back(w));
        while !a.edges.is_empty()
            && !b.edges.is_empty()
            && a.vertices[a.vertices.len() - 2] == b.vertices[b.vertices.len() - 2]
        {
            for path in [&mut a, &mut b] {
                path.vertices.pop();
                path.edges.pop();
            }
        }
        let mut walk = a.reversed();
        walk.push(h, w);
        for (&edge, &vertex) in b.edges.iter().zip(&b.vertices[1..]) {
            walk.push(edge, vertex);
        }
        walk
    }

    /// The shortest walk between two sources of different labels.
    ///
    /// # Input      sources: vertices with labels; of several for one vertex the first counts
    pub fn connect(&mut self, s: &CutSurface, units: &[u64], sources: &[(u32, u64)], bound: u64) -> Option<Found> {
        self.start(s.vertex_count());
        for &(v, label) in sources {
            self.offer(v, 0, NONE, NONE, label);
        }
        let mut best = bound;
        let mut closing = None;
        while let Some((d, v)) = self.settle_next() {
            if 2 * d >= best {
                break;
            }
            let own = self.label[v as usize].class;
            s.for_edges(v, |h, w| {
                let cost = cost_of(s, units, h);
                if cost == FORBIDDEN {
                    return;
                }
                match self.seen(w) {
                    Some(other) if other.settled => {
                        let length = d + cost + other.distance;
                        if other.class != own && length < best {
                            best = length;
                            closing = Some((v, h, w));
                        }
                    }
                    _ => self.offer(w, d + cost, v, h, own),
                }
            });
        }
        let (v, h, w) = closing?;
        let mut walk = self.path_back(v).reversed();
        walk.push(h, w);
        let rest = self.path_back(w);
        rest.edges.iter().zip(&rest.vertices[1..]).for_each(|(&edge, &vertex)| walk.push(edge, vertex));
        Some(Found { length: best, walk })
    }

    /// The shortest walk from one of `sources` to a vertex that is a target, shorter than `bound`.
    pub fn path(
        &mut self,
        s: &CutSurface,
        units: &[u64],
        sources: &[u32],
        bound: u64,
        is_target: impl Fn(u32) -> bool,
    ) -> Option<Found> {
        self.start(s.vertex_count());
        for &v in sources {
            self.offer(v, 0, NONE, NONE, 0);
        }
        while let Some((d, v)) = self.settle_next() {
            if d >= bound {
                return None;
            }
            if is_target(v) && self.before(v).is_some() {
                return Some(Found { length: d, walk: self.path_back(v).reversed() });
            }
            self.relax(s, units, d, v);
        }
        None
    }

    /// Spreads from labelled sources over everything that can be reached.
    pub fn spread(&mut self, s: &CutSurface, units: &[u64], sources: &[(u32, u64)], mut stop: impl FnMut(u32) -> bool) {
        self.start(s.vertex_count());
        for &(v, label) in sources {
            self.offer(v, 0, NONE, NONE, label);
        }
        while let Some((d, v)) = self.settle_next() {
            if stop(v) {
                return;
            }
            self.relax(s, units, d, v);
        }
    }

    fn relax(&mut self, s: &CutSurface, units: &[u64], d: u64, v: u32) {
        let own = self.label[v as usize].class;
        s.for_edges(v, |h, w| {
            let cost = cost_of(s, units, h);
            if cost != FORBIDDEN && !self.seen(w).is_some_and(|l| l.settled) {
                self.offer(w, d + cost, v, h, own);
            }
        });
    }

    /// The walk with the fewest edges from `sources` to a target, along edges that `may_step` allows.
    ///
    /// # Input      may_step: from a vertex, along a half-edge of an edge, to a vertex
    pub fn follow(
        &mut self,
        s: &CutSurface,
        sources: &[u32],
        may_step: impl Fn(u32, u32, u32) -> bool,
        is_target: impl Fn(u32) -> bool,
    ) -> Option<Walk> {
        self.start(s.vertex_count());
        let mut queue = std::collections::VecDeque::new();
        for &v in sources {
            self.label[v as usize] =
                Label { stamp: self.stamp, settled: true, distance: 0, before: NONE, edge: NONE, class: 0 };
            queue.push_back(v);
        }
        while let Some(v) = queue.pop_front() {
            if is_target(v) {
                return Some(self.path_back(v).reversed());
            }
            s.for_edges(v, |h, w| {
                if self.seen(w).is_none() && may_step(v, h, w) {
                    let stamp = self.stamp;
                    self.label[w as usize] = Label { stamp, settled: true, distance: 0, before: v, edge: h, class: 0 };
                    queue.push_back(w);
                }
            });
        }
        None
    }
}
