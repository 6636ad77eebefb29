//! The wavefront: windows spread over the surface in the order of their distances.
//!
//! In: [`IntrinsicSurface`], sources, [`Options`]. Out: the windows of every edge and a distance per vertex.
//! Holds: on every edge the list covers what can be reached, each place with the shortest path to it; the result does
//! not depend on the order of the queue, which only saves work. Source: [Bommes2012] §9 after [Surazhsky2005] and
//! [Mitchell1987]; dominated windows are dropped by the distances of the edge's ends [XinWang2009].
//!
//! The queue holds edges and vertices, not windows: an edge is taken when its nearest pending window is next, and all
//! of them are propagated together, so that a face is laid out once for all.

use crate::crossing::{Crossing, Frame, Joint, Pencil};
use crate::error::GeodesicError;
use crate::insert::{Pieces, insert};
use crate::lists::EdgeLists;
use crate::merge;
use crate::profile::fronts;
use crate::sources::{Cell, Root, Source, Sources, cell_of, place};
use crate::surface::{Apex, IntrinsicSurface, Turn};
use crate::window::{DRIFT_REL, OVERLAP_REL, TIE_REL, Window};
use quadloom_mesh::{EdgeId, EdgeMap, FaceId, HalfEdgeId, Progress, VertexId, VertexMap};
use std::collections::BinaryHeap;
use std::f64::consts::PI;

/// How distances are computed.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Relative error that the final distances may have, 0 ≤ ε < 1; 0, the default, is exact up to rounding.
    pub epsilon: f64,
    /// Distance beyond which nothing is computed, file units. Default infinity.
    pub limit: f64,
    /// What is kept. Default [`Keep::Windows`].
    pub keep: Keep,
}

/// What a wavefront leaves behind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Keep {
    /// All windows: distances can be asked for anywhere, paths traced.
    #[default]
    Windows,
    /// Distances of vertices alone: windows are forgotten where the wavefront has passed, which saves most memory.
    Vertices,
}

impl Default for Options {
    fn default() -> Self {
        Self { epsilon: 0.0, limit: f64::INFINITY, keep: Keep::Windows }
    }
}

/// What was done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Counts {
    /// Windows that were propagated across a face.
    pub propagated: u64,
    /// Candidates that were entered into a list, at least in part.
    pub entered: u64,
    /// Candidates that were made.
    pub candidates: u64,
    /// Pairs of neighbouring windows that were merged.
    pub merged: u64,
    /// Vertices that became pseudo-sources, with repetitions.
    pub pseudo_sources: u64,
    /// Places where neighbouring windows part, so that what is between is seen from there.
    pub joints: u64,
}

/// An edge or a vertex in a queue; nearest first, then by id.
///
/// One number, so that comparing takes one step: the bits of a key that is not negative, which rise with it, and the id
/// (edges first, vertices after them), all reversed for a heap with the greatest on top.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Event(u128);

impl Event {
    fn new(key: f64, id: u32) -> Self {
        Self(!(u128::from(key.to_bits()) << 32 | u128::from(id)))
    }

    fn key(self) -> f64 {
        f64::from_bits((!self.0 >> 32) as u64)
    }

    fn id(self) -> u32 {
        !self.0 as u32
    }
}

/// A candidate is dropped unseen only if paths from an end of the edge are shorter by more than this, relative to it: one
/// that comes along the edge itself is as long as those, but for what its source has drifted.
const FILTER_REL: f64 = 10.0 * DRIFT_REL;
/// Edges behind the wavefront are looked for when this many more have been met, so that each is looked at about twice.
const CLOSE_AFTER: usize = 1024;
/// Stop is asked for once in so many events.
const CHECK_EVERY: u32 = 4096;

/// Wavefronts on one surface, one after the other, in memory that is kept.
pub struct Wavefront<'a> {
    pub(crate) surface: &'a IntrinsicSurface<'a>,
    pub(crate) lists: EdgeLists,
    pub(crate) distance: VertexMap<f64>,
    pub(crate) label: VertexMap<u32>,
    /// Bound on how far below the true distance a vertex is.
    error: VertexMap<f32>,
    /// Key of an edge in the queue; infinity if it is not there.
    queued: EdgeMap<f64>,
    pub(crate) sources: Sources,
    /// Faces in whose closure there are sources that are no vertices, ascending, and those sources beside them.
    pub(crate) face_roots: Vec<(FaceId, u32)>,
    pub(crate) root_list: Vec<u32>,
    pub(crate) counts: Counts,
    queue: BinaryHeap<Event>,
    /// Edges with windows and vertices with a distance, to be forgotten by the next wavefront.
    touched_edges: Vec<EdgeId>,
    touched_vertices: Vec<VertexId>,
    /// Edges whose windows may be forgotten once the wavefront is beyond a distance.
    closing: Vec<(f64, EdgeId)>,
    /// As soon as there are so many.
    close_at: usize,
    scratch: Scratch,
    epsilon: f64,
    pub(crate) keep: Keep,
    /// Where windows spread; everywhere if there is none.
    pub(crate) corridor: Option<Corridor>,
}

/// Where a shortest path to a goal can be: places whose distances from both ends are together at most that of the ends.
pub(crate) struct Corridor {
    /// Bound from below of each vertex's distance from the goal, where it is known.
    lower: VertexMap<f64>,
    known: Vec<VertexId>,
    /// The same for other vertices.
    beyond: f64,
    most: f64,
}

impl Corridor {
    pub fn new(vertices: usize) -> Self {
        let lower = VertexMap::filled(vertices, f64::INFINITY);
        Self { lower, known: Vec::new(), beyond: 0.0, most: f64::INFINITY }
    }

    /// Takes bounds from an approximate wavefront that began at the goal and has come so far.
    pub fn set(&mut self, guide: &Wavefront, front: f64, most: f64) {
        self.known.drain(..).for_each(|v| self.lower[v] = f64::INFINITY);
        self.known.extend_from_slice(&guide.touched_vertices);
        self.known.iter().for_each(|&v| self.lower[v] = guide.distance[v]);
        (self.beyond, self.most) = (front, most * (1.0 + CORRIDOR_SLACK));
    }

    fn lower(&self, v: VertexId) -> f64 {
        self.lower[v].min(self.beyond)
    }

    /// Whether a path can lead over an edge that it reaches after a distance.
    fn has_edge(&self, [p, q]: [VertexId; 2], length: f64, after: f64) -> bool {
        // No place of the edge is farther from both ends than they are apart.
        after + 0.5 * (self.lower(p) + self.lower(q) - length) <= self.most
    }

    fn has_vertex(&self, v: VertexId, after: f64) -> bool {
        after + self.lower(v) <= self.most
    }
}

/// Room for rounding.
const CORRIDOR_SLACK: f64 = 1e-9;

/// Lists that are empty between steps.
#[derive(Default)]
struct Scratch {
    /// What leaves an edge into the face of its canonical half-edge, and into the other one.
    forward: Vec<Pencil>,
    backward: Vec<Pencil>,
    /// What they become on the next and on the previous side.
    next: Vec<Window>,
    prev: Vec<Window>,
    /// The list of a side on which they arrive.
    list: Vec<Window>,
    pieces: Pieces,
    /// Angles of a vertex's corners.
    corners: Vec<f64>,
}

/// In `queued`: the windows of this edge are forgotten and no new one is let in.
const CLOSED: f64 = f64::NEG_INFINITY;

impl<'a> Wavefront<'a> {
    /// An empty wavefront.
    ///
    /// # Cost       linear
    pub fn new(surface: &'a IntrinsicSurface<'a>) -> Self {
        let mesh = surface.connectivity();
        Self {
            surface,
            lists: EdgeLists::new(mesh.edge_count()),
            distance: VertexMap::filled(mesh.vertex_count(), f64::INFINITY),
            label: VertexMap::filled(mesh.vertex_count(), u32::MAX),
            error: VertexMap::filled(mesh.vertex_count(), 0.0),
            queued: EdgeMap::filled(mesh.edge_count(), f64::INFINITY),
            sources: Sources::default(),
            face_roots: Vec::new(),
            root_list: Vec::new(),
            counts: Counts::default(),
            queue: BinaryHeap::new(),
            touched_edges: Vec::new(),
            touched_vertices: Vec::new(),
            closing: Vec::new(),
            close_at: CLOSE_AFTER,
            scratch: Scratch::default(),
            epsilon: 0.0,
            keep: Keep::Windows,
            corridor: None,
        }
    }

    /// Spreads from sources until nothing changes any more.
    ///
    /// # Input      sources with labels and start values, file units
    /// # Output     what [`Wavefront::field`] answers; an earlier wavefront is forgotten
    /// # Errors     the first source that is wrong; an ε outside 0..1; a stop that was asked for
    /// # Cost       O(w log w) for w windows, near linear in the faces for ε > 0; seldom quadratic for ε = 0
    /// # Guarantees with ε = 0 exact up to rounding: about 1e-15 of the distance per hundred faces crossed; with ε > 0
    /// nowhere more than ε below. The same bytes each time
    /// # Source     [Bommes2012] §9
    pub fn spread(&mut self, sources: &[Source], options: &Options, progress: &Progress) -> Result<(), GeodesicError> {
        self.spread_until(sources, options, progress, |_, _| false)
    }

    /// Spreads until `enough` says so of a distance within which all is known.
    pub(crate) fn spread_until(
        &mut self,
        sources: &[Source],
        options: &Options,
        progress: &Progress,
        mut enough: impl FnMut(&Self, f64) -> bool,
    ) -> Result<(), GeodesicError> {
        if !(0.0..1.0).contains(&options.epsilon) {
            return Err(GeodesicError::Option { what: "epsilon", range: "in 0..1", value: options.epsilon });
        }
        self.reset();
        self.sources = Sources::new(self.surface, sources)?;
        self.face_roots = self.sources.by_face(self.surface.connectivity());
        self.root_list = self.face_roots.iter().map(|&(_, k)| k).collect();
        (self.epsilon, self.keep) = (options.epsilon, options.keep);
        self.start();
        let limit = options.limit * self.surface.scale();
        let edges = self.surface.connectivity().edge_count() as u32;
        let mut until_check = CHECK_EVERY;
        while let Some(event) = self.queue.pop().filter(|event| event.key() <= limit) {
            until_check -= 1;
            if until_check == 0 {
                progress.check()?;
                let reached = self.touched_vertices.len() as f64;
                progress.report("wavefront", reached / self.distance.len() as f64);
                until_check = CHECK_EVERY;
            }
            let (key, id) = (event.key(), event.id());
            if enough(self, key) {
                break;
            }
            self.close(key);
            if id < edges {
                self.advance_edge(EdgeId(id), key);
            } else {
                self.advance_vertex(VertexId(id - edges), key);
            }
        }
        Ok(())
    }

    /// Forgets the last wavefront.
    ///
    /// # Cost       linear in what it touched
    fn reset(&mut self) {
        for e in self.touched_edges.drain(..) {
            self.lists.clear(e);
            self.queued[e] = f64::INFINITY;
        }
        for v in self.touched_vertices.drain(..) {
            (self.distance[v], self.label[v], self.error[v]) = (f64::INFINITY, u32::MAX, 0.0);
        }
        self.queue.clear();
        self.closing.clear();
        self.close_at = CLOSE_AFTER;
        self.counts = Counts::default();
    }

    // ----- sources -----

    /// Windows of all sources.
    fn start(&mut self) {
        let sources = std::mem::take(&mut self.sources);
        let vertices = self.surface.connectivity().vertex_count() as u32;
        for &(v, start, label) in &sources.vertices {
            self.reach_from_source(v, start, label);
        }
        for &(v, start, _) in &sources.vertices {
            if self.distance[v] == start {
                self.emit(v, None, Star::Whole);
            }
        }
        self.sources = sources;
        for k in 0..self.sources.roots.len() {
            let (shape, start, _) = self.sources.roots[k];
            let root = vertices + k as u32;
            match shape {
                Root::Point(p) => self.start_point(p, start, root),
                Root::Segment(p, q) => self.start_segment(p, q, start, root),
            }
        }
    }

    fn reach_from_source(&mut self, v: VertexId, start: f64, label: u32) {
        if start < self.distance[v] {
            self.touched_vertices.push(v);
            (self.distance[v], self.label[v], self.error[v]) = (start, label, 0.0);
        }
    }

    /// Windows on the sides of a point's face, or of both faces of its edge ([Bommes2012] Figure 9.4).
    fn start_point(&mut self, p: quadloom_mesh::SurfacePoint, start: f64, root: u32) {
        let mesh = self.surface.connectivity();
        match cell_of(mesh, &p) {
            Cell::Vertex(_) => {}
            Cell::Inside(face) => {
                let at = place(self.surface.layout(face), p.weights);
                self.start_in_face(face, None, at, start, root);
            }
            Cell::Side(side) => {
                for (h, x) in self.both_sides(side, weight_along(mesh, side, &p)) {
                    let apex = self.surface.apex(h);
                    let window = Window::circular([0.0, apex.base], [x, 0.0], start, root);
                    self.enter(h, window, false);
                    self.start_over(h, &apex, [x, 0.0], start, root);
                }
            }
        }
    }

    /// The half-edges of an edge with the place at a fraction of the first one along each.
    fn both_sides(&self, h: HalfEdgeId, t: f64) -> impl Iterator<Item = (HalfEdgeId, f64)> + use<> {
        let mesh = self.surface.connectivity();
        let length = self.surface.length(mesh.edge(h));
        let x = t * length;
        [Some((h, x)), mesh.twin(h).map(|twin| (twin, length - x))].into_iter().flatten()
    }

    /// Windows of a point of a face's layout on its sides, but for one of them.
    fn start_in_face(&mut self, face: FaceId, except: Option<HalfEdgeId>, at: [f64; 2], start: f64, root: u32) {
        let first = self.surface.connectivity().first_half_edge(face);
        let apex = self.surface.apex(first);
        if except != Some(first) {
            self.enter(first, Window::circular([0.0, apex.base], at, start, root), true);
        }
        self.start_over(first, &apex, at, start, root);
    }

    /// Windows of a point in the frame of a half-edge on the two other sides of its face.
    fn start_over(&mut self, h: HalfEdgeId, apex: &Apex, at: [f64; 2], start: f64, root: u32) {
        for (g, frame) in self.other_sides(h, apex) {
            self.enter(g, Window::circular([0.0, frame.length], frame.to(at), start, root), true);
        }
    }

    /// The frames of the two other sides of a face, in the frame of one.
    fn other_sides(&self, h: HalfEdgeId, apex: &Apex) -> [(HalfEdgeId, Frame); 2] {
        let mesh = self.surface.connectivity();
        let (b, c) = ([apex.base, 0.0], [apex.x, apex.y]);
        [(mesh.next(h), Frame::new(b, c, apex.right)), (mesh.prev(h), Frame::new(c, [0.0; 2], apex.left))]
    }

    /// Linear windows of a segment ([Bommes2012] Figure 9.6 a); its ends are points of their own.
    fn start_segment(&mut self, p: quadloom_mesh::SurfacePoint, q: quadloom_mesh::SurfacePoint, start: f64, root: u32) {
        let mesh = self.surface.connectivity();
        let corners = mesh.face_half_edges(p.face);
        let on_side = (0..3).find(|&k| p.weights[(k + 2) % 3] == 0.0 && q.weights[(k + 2) % 3] == 0.0);
        let Some(k) = on_side else {
            let layout = self.surface.layout(p.face);
            let (p, q) = (place(layout, p.weights), place(layout, q.weights));
            for k in 0..3 {
                let (from, to) = (layout[k], layout[(k + 1) % 3]);
                let length = self.surface.length(mesh.edge(corners[k]));
                self.start_fronts(corners[k], &Frame::new(from, to, length), p, q, start, root);
            }
            return;
        };
        let side = corners[k];
        let [s, t] = [weight_along(mesh, side, &p), weight_along(mesh, side, &q)];
        for ((h, x), (_, y)) in self.both_sides(side, s).zip(self.both_sides(side, t)).collect::<Vec<_>>() {
            let apex = self.surface.apex(h);
            let window = Window::linear([x.min(y), x.max(y)], [0.0, 1.0], start, root);
            self.enter(h, window, false);
            for (g, frame) in self.other_sides(h, &apex) {
                self.start_fronts(g, &frame, [x, 0.0], [y, 0.0], start, root);
            }
        }
    }

    /// The two fronts of a segment on a side of its face.
    fn start_fronts(&mut self, g: HalfEdgeId, frame: &Frame, p: [f64; 2], q: [f64; 2], start: f64, root: u32) {
        for window in fronts(frame, p, q, start, root).into_iter().flatten() {
            self.enter(g, window, true);
        }
    }

    // ----- vertices -----

    /// A saddle becomes a pseudo-source; past a flat vertex a path may go on along an edge.
    fn advance_vertex(&mut self, v: VertexId, key: f64) {
        // Lower by no more than rounding since it was queued.
        if self.distance[v] >= key * (1.0 - 4.0 * TIE_REL) {
            let star = if self.surface.turn(v) == Turn::Saddle { Star::Whole } else { Star::Edges };
            self.counts.pseudo_sources += u64::from(star == Star::Whole);
            // Behind merged windows the path's direction is not known.
            let sector = if self.error[v] > 0.0 { None } else { self.shadow(v) };
            self.emit(v, sector, star);
        }
    }

    /// The directions at a vertex in which paths can leave it, as an interval of angles counted from its first outgoing
    /// half-edge: those at least half a turn from where the path arrives. `None` if that is not known. Leaves the angles
    /// of the vertex's corners in the scratch list.
    fn shadow(&mut self, v: VertexId) -> Option<Sector> {
        let mesh = self.surface.connectivity();
        let mut corners = std::mem::take(&mut self.scratch.corners);
        corners.clear();
        let (mut arrives, mut best) = (None, f64::INFINITY);
        let (mut angle, mut doubt) = (0.0, 1e-9);
        for h in mesh.outgoing(v) {
            let mut consider = |spoke: HalfEdgeId, at: f64| {
                if let Some((difference, turn)) = self.arrival(v, spoke)
                    && difference < best
                {
                    (best, arrives) = (difference, Some((at, turn)));
                }
            };
            consider(h, angle);
            let (corner, error) = self.surface.corner_angle(h);
            corners.push(corner);
            angle += corner;
            doubt += error;
            if mesh.twin(mesh.prev(h)).is_none() {
                consider(mesh.prev(h), angle);
            }
        }
        self.scratch.corners = corners;
        let is_known = best <= 16.0 * TIE_REL * self.distance[v] && doubt < 0.1;
        let arrives = arrives.filter(|_| is_known).map(|(at, [x, y])| at + y.atan2(x))?;
        let total = angle;
        let closed = !mesh.is_boundary_vertex(v);
        Some(Sector { from: arrives + PI - doubt, to: arrives + total - PI + doubt, total, closed })
    }

    /// How far the end of a spoke's list is from the vertex's distance, and the direction of the arriving path's source,
    /// with the spoke as x axis and y to its left.
    fn arrival(&self, v: VertexId, spoke: HalfEdgeId) -> Option<(f64, [f64; 2])> {
        let mesh = self.surface.connectivity();
        let e = mesh.edge(spoke);
        let at_start = mesh.ends(e)[0] == v;
        let list = self.lists.of(e);
        let length = self.surface.length(e);
        let window = if at_start { list.first()? } else { list.last()? };
        let (window, x) = if at_start { (*window, window.b0) } else { (window.reversed(length), length - window.b1) };
        if x > 0.0 {
            return None;
        }
        let difference = (window.at(0.0) - self.distance[v]).abs();
        let ([sx, sy], _) = window.source();
        // A front comes from against its slope.
        let along = if window.is_linear() { -sx } else { sx };
        // Seen along the spoke away from v, a window that moves into the face on the left has its source on the right.
        let leaves_left = window.to_canonical() == at_start;
        Some((difference, [along, if leaves_left { -sy } else { sy }]))
    }

    /// Windows from a vertex on the edges around it and on those opposite, within a sector.
    fn emit(&mut self, v: VertexId, sector: Option<Sector>, star: Star) {
        let mesh = self.surface.connectivity();
        let (start, error) = (self.distance[v], self.error[v]);
        let mut angle = 0.0;
        for (k, h) in mesh.outgoing(v).enumerate() {
            let corner = if sector.is_some() { self.scratch.corners[k] } else { 0.0 };
            let within = sector.map_or(Some([0.0, corner]), |s| s.within(angle, angle + corner));
            let whole = sector.is_none();
            angle += corner;
            let Some([lo, hi]) = within else { continue };
            // 1. Along the edges beside the face.
            let [at_first, at_last] = [whole || lo <= SPOKE, whole || hi >= corner - SPOKE];
            if at_first {
                self.enter_spoke(h, v, start, error);
            }
            if at_last {
                self.enter_spoke(mesh.prev(h), v, start, error);
            }
            if star == Star::Edges {
                continue;
            }
            // 2. Across the face.
            let apex = self.surface.apex(h);
            let frame = Frame::new([apex.base, 0.0], [apex.x, apex.y], apex.right);
            let on_link = |beta: f64| {
                let (sin, cos) = beta.sin_cos();
                let across = cos * frame.direction[1] - sin * frame.direction[0];
                if across > 0.0 { (apex.base * sin / across).min(frame.length) } else { frame.length }
            };
            let slack = OVERLAP_REL * frame.length;
            let from = if at_first { 0.0 } else { (on_link(lo) - slack).max(0.0) };
            let to = if at_last { frame.length } else { (on_link(hi) + slack).min(frame.length) };
            let window = Window::circular([from, to], frame.to([0.0; 2]), start, v.0).with_error(error);
            self.enter(mesh.next(h), window, true);
        }
    }

    /// The path along an edge; it covers the edge and no face.
    fn enter_spoke(&mut self, h: HalfEdgeId, v: VertexId, start: f64, error: f32) {
        let mesh = self.surface.connectivity();
        let length = self.surface.length(mesh.edge(h));
        let x = if mesh.origin(h) == v { 0.0 } else { length };
        let window = Window::circular([0.0, length], [x, 0.0], start, v.0).with_error(error);
        self.enter(h, window, false);
    }

    // ----- edges -----

    /// Propagates the pending windows of an edge.
    fn advance_edge(&mut self, e: EdgeId, key: f64) {
        if self.queued[e] != key {
            return;
        }
        self.queued[e] = f64::INFINITY;
        let left = close_gaps(self.lists.of_mut(e), self.surface.parted(), key, self.surface.length(e));
        self.lists.truncate(e, left);
        self.merge(e);
        let mesh = self.surface.connectivity();
        let (canonical, length) = (mesh.half_edge(e), self.surface.length(e));
        // 1. Pending windows, and what is between those that part.
        let Scratch { forward, backward, .. } = &mut self.scratch;
        let (mut forward, mut backward) = (std::mem::take(forward), std::mem::take(backward));
        let list = self.lists.of_mut(e);
        for k in 0..list.len() {
            let before = k.checked_sub(1).map(|j| list[j]);
            let w = &mut list[k];
            let is_new = w.is_pending() || before.is_some_and(|b| b.is_pending());
            let front = if w.to_canonical() { &mut forward } else { &mut backward };
            if is_new && let Some(joint) = before.and_then(|b| Joint::between(&b, w, length)) {
                self.counts.joints += 1;
                front.push(Pencil::from_joint(&joint));
            }
            if w.is_pending() {
                front.push(Pencil::of(*w));
            }
        }
        list.iter_mut().for_each(|w| w.set_pending(false));
        self.counts.propagated += (forward.len() + backward.len()) as u64;
        // 2. Across the faces.
        if !forward.is_empty() {
            self.cross_all(canonical, &forward);
        }
        if let Some(twin) = mesh.twin(canonical).filter(|_| !backward.is_empty()) {
            backward.iter_mut().for_each(|pencil| *pencil = pencil.reversed(length));
            self.cross_all(twin, &backward);
        }
        forward.clear();
        backward.clear();
        (self.scratch.forward, self.scratch.backward) = (forward, backward);
        if self.keep == Keep::Vertices {
            self.closing.push((self.farthest(e), e));
        }
    }

    /// Merges pending windows of an edge.
    fn merge(&mut self, e: EdgeId) {
        let before = self.lists.of(e).len();
        if before < 2 {
            return;
        }
        let same = |a, b| a == b || label_of(&self.label, &self.sources, a) == label_of(&self.label, &self.sources, b);
        let left = merge::merge_pending(self.lists.of_mut(e), self.surface.length(e), self.epsilon, same);
        self.lists.truncate(e, left);
        self.counts.merged += (before - left) as u64;
    }

    /// No place of an edge is farther than this: it can be reached from the ends.
    fn farthest(&self, e: EdgeId) -> f64 {
        let [p, q] = self.surface.connectivity().ends(e);
        0.5 * (self.distance[p] + self.distance[q] + self.surface.length(e))
    }

    /// Forgets the windows of edges that a wavefront at a distance has passed, when there may be enough of them.
    fn close(&mut self, at: f64) {
        if self.closing.len() < self.close_at {
            return;
        }
        let Self { closing, lists, queued, .. } = self;
        closing.retain(|&(farthest, e)| {
            if farthest >= at {
                return true;
            }
            // Queued again meanwhile: its next step will put it here again.
            if queued[e] == f64::INFINITY {
                lists.clear(e);
                queued[e] = CLOSED;
            }
            false
        });
        self.close_at = 2 * self.closing.len() + CLOSE_AFTER;
    }

    /// Propagates pencils, given in the frame of a half-edge, across its face.
    fn cross_all(&mut self, h: HalfEdgeId, pencils: &[Pencil]) {
        let crossing = Crossing::new(self.surface, h);
        let (mut next, mut prev) = (std::mem::take(&mut self.scratch.next), std::mem::take(&mut self.scratch.prev));
        for pencil in pencils {
            crossing.cross(pencil, &mut next, &mut prev);
        }
        self.enter_all(crossing.next, &mut next, true);
        self.enter_all(crossing.prev, &mut prev, true);
        (self.scratch.next, self.scratch.prev) = (next, prev);
    }

    /// Enters one window.
    fn enter(&mut self, h: HalfEdgeId, window: Window, moves: bool) {
        let mut one = std::mem::take(&mut self.scratch.next);
        one.push(window);
        self.enter_all(h, &mut one, moves);
        self.scratch.next = one;
    }

    /// Enters windows given in the frame of a half-edge, whose sources are on the side of that half-edge's face.
    ///
    /// Windows that move cross the half-edge out of its face.
    fn enter_all(&mut self, h: HalfEdgeId, windows: &mut Vec<Window>, moves: bool) {
        let mesh = self.surface.connectivity();
        let e = mesh.edge(h);
        if self.queued[e] == CLOSED || windows.is_empty() {
            windows.clear();
            return;
        }
        let (length, canonical, [p, q]) = (self.surface.length(e), mesh.half_edge(e) == h, mesh.ends(e));
        let pending = moves && !mesh.is_boundary_edge(e);
        // 1. In the edge's own frame, in its order.
        for w in windows.iter_mut() {
            let own = if canonical { *w } else { w.reversed(length) }.with_direction(!canonical);
            *w = if pending { own.pending() } else { own };
        }
        if windows.len() > 1 && windows[0].b0 > windows[windows.len() - 1].b0 {
            windows.reverse();
        }
        self.counts.candidates += windows.len() as u64;
        let Scratch { list, pieces, .. } = &mut self.scratch;
        let (mut list, mut pieces) = (std::mem::take(list), std::mem::take(pieces));
        list.clear();
        list.extend_from_slice(self.lists.of(e));
        let mut key = f64::INFINITY;
        for &w in windows.iter() {
            // 2. The vertices that it reaches.
            let (at_b0, at_b1) = (w.at(w.b0), w.at(w.b1));
            if w.b0 <= 0.0 {
                self.reach(p, at_b0, w.root(), w.error);
            }
            if w.b1 >= length {
                self.reach(q, at_b1, w.root(), w.error);
            }
            // 3. Paths from an end of the edge that are shorter everywhere ([XinWang2009] §4).
            let tie = FILTER_REL * (at_b0 + at_b1);
            if length <= 0.0
                || self.farthest_of(p) + w.b1 < at_b1 - tie
                || self.farthest_of(q) + (length - w.b0) < at_b0 - tie
            {
                continue;
            }
            // 4. The list.
            let least = insert(&mut list, &mut pieces, length, w);
            self.counts.entered += u64::from(least < f64::INFINITY);
            key = key.min(least);
        }
        windows.clear();
        if key < f64::INFINITY {
            // Rounding may put a front's beginning behind its source.
            let key = if key > 0.0 { key } else { 0.0 };
            if self.lists.of(e).is_empty() {
                self.touched_edges.push(e);
            }
            self.lists.set(e, &list);
            let leads_on = self.corridor.as_ref().is_none_or(|c| c.has_edge([p, q], length, key));
            if pending && leads_on && key < self.queued[e] {
                self.queued[e] = key;
                self.queue.push(Event::new(key, e.0));
            }
        }
        (self.scratch.list, self.scratch.pieces) = (list, pieces);
    }

    /// What the true distance of a vertex cannot exceed.
    fn farthest_of(&self, v: VertexId) -> f64 {
        self.distance[v] + f64::from(self.error[v])
    }

    /// A path reaches a vertex.
    fn reach(&mut self, v: VertexId, distance: f64, root: u32, error: f32) {
        // The ends of a front's interval are rounded, also to beyond its source.
        let distance = if distance > 0.0 { distance } else { 0.0 };
        let before = self.distance[v];
        if distance >= before {
            return;
        }
        if before == f64::INFINITY {
            self.touched_vertices.push(v);
        }
        self.distance[v] = distance;
        self.label[v] = label_of(&self.label, &self.sources, root);
        self.error[v] = error;
        let leads_on = self.corridor.as_ref().is_none_or(|c| c.has_vertex(v, distance));
        if distance < before * (1.0 - 2.0 * TIE_REL) && leads_on && self.surface.turn(v) != Turn::Convex {
            let id = self.surface.connectivity().edge_count() as u32 + v.0;
            self.queue.push(Event::new(distance, id));
        }
    }
}

/// Lets neighbours reach to each other over gaps that rounding has made, also where a window of the other direction, far
/// from their distances, has filled one; returns how many windows are left, at the start of the list.
///
/// On triangles that are known to fewer digits (needles) rays on both sides of a vertex differ by more than they are
/// widened. What the extension adds is too short by its square.
fn close_gaps(list: &mut [Window], parted: f64, key: f64, length: f64) -> usize {
    let narrow = parted * (key + length);
    let mut last = 0;
    for next in 1..list.len() {
        let r = list[next];
        let l = list[last];
        if r.b0 > l.b1 && l.to_canonical() == r.to_canonical() {
            let (distance, slope) = r.at_with_slope(r.b0);
            if (r.b0 - l.b1) * (1.0 - slope * slope).max(0.0).sqrt() <= parted * distance {
                list[next].b0 = l.b1;
            }
        } else if l.b1 - l.b0 <= narrow && last > 0 {
            let before = list[last - 1];
            let (joint, far) = (before.at(before.b1), l.at(l.b0));
            let is_filler = before.to_canonical() == r.to_canonical()
                && far - joint > 4.0 * narrow
                && (r.at(r.b0) - joint).abs() <= 4.0 * narrow;
            if is_filler {
                last -= 1;
                list[next].b0 = before.b1;
            }
        }
        last += 1;
        list[last] = list[next];
    }
    last + 1
}

/// Label of a root: of a vertex's nearest source, or of a source itself.
pub(crate) fn label_of(label: &VertexMap<u32>, sources: &Sources, root: u32) -> u32 {
    match (root as usize).checked_sub(label.len()) {
        None => label[VertexId(root)],
        Some(k) => sources.roots[k].2,
    }
}

/// Fraction of a point along a side of its face.
fn weight_along(mesh: &quadloom_mesh::TriConnectivity, side: HalfEdgeId, p: &quadloom_mesh::SurfacePoint) -> f64 {
    p.weights[(mesh.next(side).0 % 3) as usize]
}

/// Directions nearer to an edge than this are along it, radians.
const SPOKE: f64 = 1e-9;

/// What leaves a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Star {
    /// Windows on the edges around it and on those opposite.
    Whole,
    /// Windows on the edges around it alone.
    Edges,
}

/// An interval of directions at a vertex.
#[derive(Clone, Copy, Debug)]
struct Sector {
    from: f64,
    to: f64,
    /// Sum of the angles around the vertex.
    total: f64,
    /// Whether angles repeat after it; else the sector is what is outside `to - total..=from` of them.
    closed: bool,
}

impl Sector {
    /// The part of the sector within `lo..=hi`, from `lo`.
    fn within(&self, lo: f64, hi: f64) -> Option<[f64; 2]> {
        let cut = |from: f64, to: f64| {
            let (a, b) = (from.max(lo), to.min(hi));
            (a <= b).then_some([a - lo, b - lo])
        };
        if !self.closed {
            // Beyond half a turn from the arriving path, on either side.
            return cut(self.from, self.total).or_else(|| cut(0.0, self.to - self.total));
        }
        let mut found: Option<[f64; 2]> = None;
        for turn in [-2.0, -1.0, 0.0, 1.0, 2.0] {
            if let Some([a, b]) = cut(self.from + turn * self.total, self.to + turn * self.total) {
                found = Some(found.map_or([a, b], |[c, d]: [f64; 2]| [a.min(c), b.max(d)]));
            }
        }
        found
    }
}
