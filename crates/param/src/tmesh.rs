//! The motorcycle graph of a seamless map: iso-lines traced from every integer vertex until they meet.
//!
//! In: a fold-free map on the lattice whose singular vertices need not be integer points. Out: [`TMesh`]: its arcs
//! with exact lengths, each with the linear form in the map's variables that gives its length in any other map
//! with the same seams. Holds: the arcs of a fold-free map have non-negative lengths.
//! Not: arcs of a map with folds; tracing then stops with an error.
//! Source: motorcycle graphs as in [Campen2015] §3; the linear forms are ours.
//!
//! ```text
//!   s ────a────●            a trace from s ends on the trace of t:
//!              │ b          a = length of s's trace, b = where it meets t's trace
//!              t
//! ```

use crate::charts::Charts;
use crate::integer_grid_map::{GRID_UNIT, IntegerGridMap, LatticePoint, rotate, signed_area};
pub use crate::place::Form;
use crate::place::{Place, Seams, negated, sum};
use quadloom_mesh::{FaceId, FaceMap, FeatureGraph, HalfEdgeId, HalfEdgeMap, Progress, TriConnectivity, VertexId};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A piece of a trace or feature between two nodes.
#[derive(Clone, Debug)]
pub struct Arc {
    /// Length in variables of [`crate::problem`].
    pub form: Form,
    /// Length in the traced map, grid units.
    pub length: f64,
    /// First node.
    pub from: u32,
    /// Last node.
    pub to: u32,
    /// Whether it runs along a feature.
    pub on_feature: bool,
}

/// Arcs and nodes of a motorcycle graph.
#[derive(Clone, Debug, Default)]
pub struct TMesh {
    /// All arcs, line after line.
    pub arcs: Vec<Arc>,
    /// Per node: an integer vertex, or a place on a feature; such nodes must stay apart. Integer vertices come first.
    pub pinned: Vec<bool>,
    /// Number of nodes that are integer vertices.
    pub vertices: usize,
    /// Features from one integer vertex to the next, and those without any once around; each as seen from both sides.
    pub curves: Vec<Curve>,
}

/// A feature from one integer vertex to the next, or once around.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Its sides, one after the other.
    pub sides: Vec<HalfEdgeId>,
    /// Length in variables of [`crate::problem`].
    pub form: Form,
}

impl TMesh {
    /// Number of nodes that are integer vertices; they have the smallest numbers.
    pub fn vertex_nodes(&self) -> usize {
        self.vertices
    }
}

/// Why a map could not be traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TraceError {
    /// The trace left a triangle nowhere; the map folds there.
    #[error("a trace is stuck in face {0}")]
    Stuck(FaceId),
    /// Traces did not meet within the allowed number of steps.
    #[error("traces do not end")]
    Endless,
}

/// Traces every integer vertex of a map in all directions that are not features.
///
/// # Input      `map`: fold-free; `charts`: the charts it was made from
/// # Cost       proportional to the triangles crossed, times the logarithm of the number of traces
pub fn trace(
    mesh: &TriConnectivity,
    features: &FeatureGraph,
    charts: &Charts,
    map: &IntegerGridMap,
    progress: &Progress,
) -> Result<TMesh, TraceError> {
    let mut tracer = Tracer::new(mesh, features, charts, map);
    tracer.follow_features();
    tracer.start_traces();
    tracer.run(progress)?;
    tracer.start_feelers();
    tracer.run(progress)?;
    Ok(tracer.finish())
}

/// Unit direction d: 0 = +u, 1 = +v, 2 = −u, 3 = −v.
fn unit(d: u8) -> LatticePoint {
    rotate([1, 0], d)
}

/// Axis and sign of a direction.
fn axis(d: u8) -> (usize, i64) {
    ((d % 2) as usize, if d < 2 { 1 } else { -1 })
}

#[derive(Clone, Debug)]
struct Junction {
    at: i64,
    form: Form,
    node: u32,
}

#[derive(Clone, Debug)]
struct Line {
    start: Option<u32>,
    junctions: Vec<Junction>,
    end: Option<Junction>,
    on_feature: bool,
    /// Whether it only measures: nothing ends on it, and it leaves no junction where it ends.
    is_feeler: bool,
}

/// A line as seen in one face: its source and direction in the face's chart.
#[derive(Clone, Copy, Debug)]
struct Passage {
    line: u32,
    direction: u8,
    source: LatticePoint,
    place: u32,
    end: i64,
}

/// Faces that all traces together may cross, per face of the mesh; a graph that needs more is not worth having.
///
/// Motorcycle graphs of maps at sensible sizes cross each face about once; spirals that never end cross it for ever.
const STEPS_PER_FACE: usize = 8;

/// Terms of linear forms that all traces together may hold: about 100 MB. Surfaces of very high genus have seams that
/// every trace crosses hundreds of times, and rows of such length would be too dense to be solved.
const MOST_TERMS: usize = 4_000_000;

struct Tracer<'a> {
    mesh: &'a TriConnectivity,
    features: &'a FeatureGraph,
    charts: &'a Charts,
    map: &'a IntegerGridMap,
    seams: Seams<'a>,
    places: Vec<Place>,
    /// Terms in all places, to bound memory.
    terms: usize,
    lines: Vec<Line>,
    pinned: Vec<bool>,
    node_of: quadloom_mesh::VertexMap<u32>,
    feature_side: HalfEdgeMap<Option<Passage>>,
    passages: FaceMap<Vec<Passage>>,
    curves: Vec<Curve>,
    /// (distance so far, line, face, entered through; `None` at the source).
    queue: BinaryHeap<Reverse<(i64, u32)>>,
    state: Vec<Option<(Passage, FaceId, Option<HalfEdgeId>)>>,
}

impl<'a> Tracer<'a> {
    fn new(mesh: &'a TriConnectivity, features: &'a FeatureGraph, charts: &'a Charts, map: &'a IntegerGridMap) -> Self {
        let mut pinned = Vec::new();
        let node_of = quadloom_mesh::VertexMap::from_fn(mesh.vertex_count(), |v| {
            if charts.is_integer[v] {
                pinned.push(true);
                pinned.len() as u32 - 1
            } else {
                u32::MAX
            }
        });
        Self {
            mesh,
            features,
            charts,
            map,
            seams: Seams::new(mesh, charts),
            places: Vec::new(),
            terms: 0,
            lines: Vec::new(),
            pinned,
            node_of,
            feature_side: HalfEdgeMap::filled(mesh.half_edge_count(), None),
            passages: FaceMap::filled(mesh.face_count(), Vec::new()),
            curves: Vec::new(),
            queue: BinaryHeap::new(),
            state: Vec::new(),
        }
    }

    /// The place in the chart across half-edge `h`.
    fn cross(&mut self, h: HalfEdgeId, place: u32) -> u32 {
        let Some(moved) = self.seams.crossed(h, &self.places[place as usize]) else { return place };
        self.terms += moved.terms();
        self.places.push(moved);
        self.places.len() as u32 - 1
    }

    fn carry(&mut self, h: HalfEdgeId, passage: Passage) -> Passage {
        let t = self.map.transition[h];
        Passage {
            direction: (passage.direction + t.quarter_turns) % 4,
            source: t.apply(passage.source),
            place: self.cross(h, passage.place),
            ..passage
        }
    }

    fn new_place(&mut self, corner: HalfEdgeId) -> u32 {
        self.places.push(Place::node(self.charts.node[corner]));
        self.places.len() as u32 - 1
    }

    /// Direction of a half-edge that runs along an axis in its chart.
    fn side_direction(&self, h: HalfEdgeId) -> u8 {
        let (p, q) = (self.map.uv[h], self.map.uv[self.mesh.next(h)]);
        let d = [q[0] - p[0], q[1] - p[1]];
        if d[0].abs() >= d[1].abs() {
            if d[0] >= 0 { 0 } else { 2 }
        } else if d[1] >= 0 {
            1
        } else {
            3
        }
    }

    /// Every side of every feature belongs to a line from the integer vertex behind it.
    fn follow_features(&mut self) {
        let is_feature = |h: HalfEdgeId| self.features.is_feature(self.mesh.edge(h));
        let sides: Vec<HalfEdgeId> = self.mesh.half_edges().filter(|&h| is_feature(h)).collect();
        for from_integer in [true, false] {
            for &h in &sides {
                let v = self.mesh.origin(h);
                if self.feature_side[h].is_none() && (!from_integer || self.charts.is_integer[v]) {
                    self.follow_feature(h);
                }
            }
        }
    }

    fn follow_feature(&mut self, first: HalfEdgeId) {
        let mesh = self.mesh;
        let line = self.lines.len() as u32;
        let start = Some(self.node_of[mesh.origin(first)]).filter(|&n| n != u32::MAX);
        self.lines.push(Line { start, junctions: Vec::new(), end: None, on_feature: true, is_feeler: false });
        let place = self.new_place(first);
        let mut passage =
            Passage { line, direction: self.side_direction(first), source: self.map.uv[first], place, end: i64::MAX };
        let (mut h, mut sides) = (first, Vec::new());
        loop {
            self.feature_side[h] = Some(passage);
            sides.push(h);
            let v = mesh.target(h);
            if self.charts.is_integer[v] {
                let corner = mesh.next(h);
                let end = self.new_place(corner);
                let junction = self.along(&passage, self.map.uv[corner], end, self.node_of[v]);
                if start.is_some() {
                    self.curves.push(Curve { sides, form: junction.form.clone() });
                }
                self.lines[line as usize].end = Some(junction);
                return;
            }
            // Clockwise around v, on the left side of the feature, to its next edge.
            let mut g = mesh.next(h);
            while !self.features.is_feature(mesh.edge(g)) {
                let Some(twin) = mesh.twin(g) else { return };
                passage = self.carry(g, passage);
                g = mesh.next(twin);
            }
            h = g;
            if self.feature_side[h].is_some() {
                if h == first {
                    let around = self.along(&passage, self.map.uv[h], place, u32::MAX);
                    self.curves.push(Curve { sides, form: around.form });
                }
                return;
            }
        }
    }

    /// Where a point with a symbolic place projects onto a passage.
    fn along(&self, passage: &Passage, point: LatticePoint, place: u32, node: u32) -> Junction {
        let (k, sign) = axis(passage.direction);
        let (here, source) = (&self.places[place as usize].0[k], &self.places[passage.place as usize].0[k]);
        let difference = sum(here, -1, source);
        Junction {
            at: sign * (point[k] - passage.source[k]),
            form: if sign > 0 { difference } else { negated(&difference) },
            node,
        }
    }

    /// One trace per quarter turn around every integer vertex, except along features.
    fn start_traces(&mut self) {
        let mesh = self.mesh;
        for v in mesh.vertices().filter(|&v| self.charts.is_integer[v]) {
            self.start_traces_at(v);
        }
    }

    fn start_traces_at(&mut self, v: VertexId) {
        let mesh = self.mesh;
        let fan: Vec<HalfEdgeId> = mesh.outgoing(v).collect();
        for h in fan {
            let [a, b, c] = [h, mesh.next(h), mesh.prev(h)].map(|x| self.map.uv[x]);
            for d in 0..4 {
                let u = unit(d);
                let tip = [a[0] + u[0], a[1] + u[1]];
                // In the half-open sector from side h (included) to the next side counter-clockwise.
                let from_right = signed_area(a, b, tip);
                let to_left = signed_area(a, tip, c);
                let ahead = |p: LatticePoint| (p[0] - a[0]) * u[0] + (p[1] - a[1]) * u[1] > 0;
                let inside = if from_right == 0 { ahead(b) } else { from_right > 0 && to_left > 0 };
                if !inside || (from_right == 0 && self.features.is_feature(mesh.edge(h))) {
                    continue;
                }
                let line = self.lines.len() as u32;
                self.lines.push(Line {
                    start: Some(self.node_of[v]),
                    junctions: Vec::new(),
                    end: None,
                    on_feature: false,
                    is_feeler: false,
                });
                let place = self.new_place(h);
                let passage = Passage { line, direction: d, source: a, place, end: i64::MAX };
                self.state.resize(self.lines.len(), None);
                self.state[line as usize] = Some((passage, mesh.face(h), None));
                self.queue.push(Reverse((0, line)));
            }
        }
        self.state.resize(self.lines.len(), None);
    }

    /// From every feature without an integer vertex, a line to whatever is opposite on each side: nothing else says how
    /// far such a feature is from the next one.
    fn start_feelers(&mut self) {
        let mesh = self.mesh;
        let mut felt = vec![false; self.lines.len()];
        for h in mesh.half_edges() {
            let Some(side) = self.feature_side[h] else { continue };
            let line = side.line as usize;
            if self.lines[line].start.is_none() && !std::mem::replace(&mut felt[line], true) {
                self.start_feeler(h);
            }
        }
    }

    /// Square to the left of a side of a feature, from its origin.
    fn start_feeler(&mut self, side: HalfEdgeId) {
        let mesh = self.mesh;
        let line = self.lines.len() as u32;
        let place = self.new_place(side);
        let direction = (self.side_direction(side) + 1) % 4;
        let mut passage = Passage { line, direction, source: self.map.uv[side], place, end: i64::MAX };
        let mut corner = side;
        loop {
            let [a, b, c] = [corner, mesh.next(corner), mesh.prev(corner)].map(|x| self.map.uv[x]);
            let u = unit(passage.direction);
            let tip = [a[0] + u[0], a[1] + u[1]];
            if signed_area(a, b, tip) >= 0 && signed_area(a, tip, c) > 0 {
                break;
            }
            // Counter-clockwise around the vertex.
            let g = mesh.prev(corner);
            let Some(twin) = mesh.twin(g).filter(|_| self.feature_side[g].is_none()) else { return };
            passage = self.carry(g, passage);
            corner = twin;
        }
        let node = self.pinned.len() as u32;
        self.pinned.push(true);
        self.lines.push(Line {
            start: Some(node),
            junctions: Vec::new(),
            end: None,
            on_feature: false,
            is_feeler: true,
        });
        self.state.resize(self.lines.len(), None);
        self.state[line as usize] = Some((passage, mesh.face(corner), None));
        self.queue.push(Reverse((0, line)));
    }

    fn run(&mut self, progress: &Progress) -> Result<(), TraceError> {
        self.state.resize(self.lines.len(), None);
        let most = STEPS_PER_FACE * self.mesh.face_count() + 20_000;
        let mut steps = 0;
        while let Some(Reverse((_, line))) = self.queue.pop() {
            steps += 1;
            if steps > most || self.terms > MOST_TERMS || (steps % 1024 == 0 && progress.cancelled()) {
                return Err(TraceError::Endless);
            }
            self.step(line)?;
        }
        Ok(())
    }

    /// Crosses one face: ends on the first line met, or goes on through the side ahead.
    fn step(&mut self, line: u32) -> Result<(), TraceError> {
        let Some((mut passage, face, entered)) = self.state[line as usize].take() else { return Ok(()) };
        let is_feeler = self.lines[line as usize].is_feeler;
        // 1. The nearest line that crosses ours in this face.
        if let Some((other, distance)) = self.first_crossing(&passage, face) {
            let node = self.pinned.len() as u32;
            self.pinned.push(false);
            let met = self.along(&other, passage.source, passage.place, node);
            let end = self.along(&passage, other.source, other.place, node);
            self.lines[line as usize].end = Some(end);
            if !is_feeler {
                self.lines[other.line as usize].junctions.push(met);
                passage.end = distance;
                self.passages[face].push(passage);
            }
            return Ok(());
        }
        if !is_feeler {
            self.passages[face].push(passage);
        }
        // 2. An integer vertex exactly ahead.
        if let Some(corner) = self.vertex_ahead(&passage, face, entered) {
            let place = self.new_place(corner);
            let node = self.node_of[self.mesh.origin(corner)];
            let end = self.along(&passage, self.map.uv[corner], place, node);
            self.lines[line as usize].end = Some(end);
            return Ok(());
        }
        // 3. The side ahead.
        let exit = self.exit_side(&passage, face, entered)?;
        if let Some(side) = self.feature_side[exit] {
            let node = self.pinned.len() as u32;
            self.pinned.push(true);
            let met = self.along(&side, passage.source, passage.place, node);
            let end = self.along(&passage, side.source, side.place, node);
            if !is_feeler {
                self.lines[side.line as usize].junctions.push(met);
            }
            self.lines[line as usize].end = Some(end);
            return Ok(());
        }
        let Some(twin) = self.mesh.twin(exit) else { return Err(TraceError::Stuck(face)) };
        let distance = self.exit_distance(&passage, exit);
        let carried = self.carry(exit, passage);
        self.state[line as usize] = Some((carried, self.mesh.face(twin), Some(twin)));
        self.queue.push(Reverse((distance, line)));
        Ok(())
    }

    /// A corner of the face at an integer vertex that lies exactly on the line, ahead of where it was entered.
    fn vertex_ahead(&self, p: &Passage, face: FaceId, entered: Option<HalfEdgeId>) -> Option<HalfEdgeId> {
        let (k, sign) = axis(p.direction);
        let candidates = match entered {
            Some(g) => vec![self.mesh.prev(g)],
            None => self.mesh.face_half_edges(face).to_vec(),
        };
        candidates.into_iter().find(|&h| {
            let at = self.map.uv[h];
            self.charts.is_integer[self.mesh.origin(h)]
                && at[1 - k] == p.source[1 - k]
                && sign * (at[k] - p.source[k]) > 0
        })
    }

    fn first_crossing(&self, passage: &Passage, face: FaceId) -> Option<(Passage, i64)> {
        let [a, b, c] = self.map.face_uv(self.mesh, face);
        let (k, sign) = axis(passage.direction);
        let mut best: Option<(i64, Passage)> = None;
        for other in &self.passages[face] {
            if other.direction % 2 == passage.direction % 2 {
                continue;
            }
            let mut p = passage.source;
            p[k] = other.source[k];
            let inside = signed_area(a, b, p) >= 0 && signed_area(b, c, p) >= 0 && signed_area(c, a, p) >= 0;
            let distance = sign * (p[k] - passage.source[k]);
            let (l, s) = axis(other.direction);
            let along = s * (p[l] - other.source[l]);
            if inside
                && distance > 0
                && along > 0
                && along <= other.end
                && best.is_none_or(|(d, o)| (distance, other.line) < (d, o.line))
            {
                best = Some((distance, *other));
            }
        }
        best.map(|(d, o)| (o, d))
    }

    /// A vertex exactly on the line counts as lying to the right of it, in every chart.
    fn exit_side(&self, p: &Passage, face: FaceId, entered: Option<HalfEdgeId>) -> Result<HalfEdgeId, TraceError> {
        let mesh = self.mesh;
        let u = unit(p.direction);
        let left = |q: LatticePoint| {
            i128::from(u[0]) * i128::from(q[1] - p.source[1]) - i128::from(u[1]) * i128::from(q[0] - p.source[0]) > 0
        };
        match entered {
            None => {
                let corner = mesh.face_half_edges(face).into_iter().find(|&h| self.map.uv[h] == p.source);
                corner.map(|h| mesh.next(h)).ok_or(TraceError::Stuck(face))
            }
            Some(g) => {
                let (origin, target, tip) = (self.map.uv[g], self.map.uv[mesh.next(g)], self.map.uv[mesh.prev(g)]);
                if !left(origin) || left(target) {
                    return Err(TraceError::Stuck(face));
                }
                Ok(if left(tip) { mesh.next(g) } else { mesh.prev(g) })
            }
        }
    }

    fn exit_distance(&self, p: &Passage, exit: HalfEdgeId) -> i64 {
        let (a, b) = (self.map.uv[exit], self.map.uv[self.mesh.next(exit)]);
        let (k, sign) = axis(p.direction);
        let across = 1 - k;
        let t = (p.source[across] - a[across]) as f64 / ((b[across] - a[across]) as f64);
        let at = a[k] as f64 + if t.is_finite() { t.clamp(0.0, 1.0) } else { 0.5 } * (b[k] - a[k]) as f64;
        (sign as f64 * (at - p.source[k] as f64)) as i64
    }

    fn finish(self) -> TMesh {
        let mut arcs = Vec::new();
        for mut line in self.lines {
            line.junctions.sort_by_key(|j| (j.at, j.node));
            let origin = line.start.map(|node| Junction { at: 0, form: Vec::new(), node });
            let stops: Vec<Junction> = origin.into_iter().chain(line.junctions).chain(line.end).collect();
            for pair in stops.windows(2) {
                arcs.push(Arc {
                    form: sum(&pair[1].form, -1, &pair[0].form),
                    length: (pair[1].at - pair[0].at) as f64 / GRID_UNIT as f64,
                    from: pair[0].node,
                    to: pair[1].node,
                    on_feature: line.on_feature,
                });
            }
        }
        let vertices = self.node_of.values().iter().filter(|&&n| n != u32::MAX).count();
        TMesh { arcs, pinned: self.pinned, vertices, curves: self.curves }
    }
}

/// Value of a form.
pub fn evaluate(form: &Form, x: &[f64]) -> f64 {
    form.iter().map(|&(i, c)| f64::from(c) * x[i as usize]).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ParamOptions, Parametrizer};
    use quadloom_field::{FieldConstraints, FieldOptions, SizeField, Transport, solve_cross_field};
    use quadloom_mesh::features::FeatureOptions;
    use quadloom_mesh::{metric, shapes};

    /// A tube has two closed features and no integer vertex: only feelers say how far they are from each other.
    #[test]
    fn closed_features_feel_what_is_opposite() {
        let (height, edge) = (3.0, 0.25);
        let mesh = shapes::cylinder(1.0, height, 32, 16);
        let (features, _) = FeatureGraph::detect(&mesh, &FeatureOptions::default());
        let length = metric::edge_lengths(&mesh);
        let transport = Transport::new(&mesh, &length);
        let (constraints, _) = FieldConstraints::from_features(&mesh, &transport, &length, &features);
        let progress = Progress::none();
        let (field, _) =
            solve_cross_field(&mesh, &transport, &length, &constraints, &FieldOptions::default(), &progress).unwrap();
        let mut parametrizer = Parametrizer::new(&mesh, &features, &field).unwrap();
        let size = SizeField::uniform(mesh.face_count(), edge);
        let map = parametrizer.map(&size, &ParamOptions::default(), &progress).unwrap();
        assert_eq!(map.inverted, []);
        let tmesh = trace(&mesh, &features, parametrizer.charts(), &map.map, &progress).unwrap();
        assert_eq!(tmesh.vertex_nodes(), 0, "no integer vertex, so no trace");
        let feelers: Vec<&Arc> = tmesh.arcs.iter().filter(|arc| !arc.on_feature).collect();
        assert_eq!(feelers.len(), 2, "one from each rim");
        for feeler in feelers {
            assert!(tmesh.pinned[feeler.from as usize] && tmesh.pinned[feeler.to as usize]);
            assert!((feeler.length - height / edge).abs() <= 0.5, "{}", feeler.length);
            assert!(!feeler.form.is_empty(), "its length is a matter of the map's variables");
        }
    }
}
