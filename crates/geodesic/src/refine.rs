//! Meshes as fine as a distance field needs.
//!
//! In: a field, a tolerance. Out: [`Refinement`], the same surface with more vertices, so that the field is linear along
//! every edge up to the tolerance. Holds: old vertices, edges and faces stay where they are, new vertices lie on old
//! edges and inside old faces, and their distances are exact; every edge of the result was compared in closed form.
//! Not: a bound inside faces, where the field can only differ by what its edges allow.
//! Source: [Bommes2012] §9, adaptive refinement. Instead of splits and flips, whole cells are replaced:
//!
//! ```text
//!       c              c                c
//!      ╱ ╲            ╱│╲              ╱ ╲         plain, green (one side split: two triangles for now), red
//!     ╱   ╲          ╱ │ ╲           P2───P1       (all three sides split: four cells). A narrow green cell of
//!    ╱     ╲        ╱  │  ╲          ╱ ╲ ╱ ╲       which any edge is to be split becomes red first, so that
//!   a ───── b      a ──m── b        a ──P0── b     no narrow triangle is halved.
//! ```

use crate::crossing::Frame;
use crate::error::GeodesicError;
use crate::field::Field;
use crate::path::barycentric;
use crate::wavefront::label_of;
use crate::window::Window;
use quadloom_mesh::{EdgeId, EdgeMap, FaceId, FaceMap, Progress, SurfacePoint, TriConnectivity, VertexId, VertexMap};
use std::collections::hash_map::Entry;
use std::collections::{HashMap, HashSet};

/// How a mesh is refined.
#[derive(Clone, Debug, PartialEq)]
pub struct RefineOptions {
    /// Largest difference between the distance and its linear interpolant along an edge, file units; above 0.
    pub tolerance: f64,
    /// No more faces than this. Default 5 million: about 2 GB while it runs.
    pub most_faces: usize,
}

impl RefineOptions {
    /// A tolerance in file units.
    pub fn within(tolerance: f64) -> Self {
        Self { tolerance, most_faces: 5_000_000 }
    }
}

/// A refined mesh with its field.
#[derive(Clone, Debug)]
pub struct Refinement {
    /// Vertices of the old mesh keep their numbers.
    pub connectivity: TriConnectivity,
    /// Where each vertex lies on the old mesh.
    pub points: VertexMap<SurfacePoint>,
    /// Distance of each vertex, file units.
    pub distance: VertexMap<f64>,
    /// Label of the nearest source of each vertex.
    pub label: VertexMap<Option<u32>>,
    /// The old face of each face.
    pub parent_face: FaceMap<FaceId>,
    /// Length of each edge, file units.
    pub length: EdgeMap<f64>,
    /// Largest difference between the distance and its linear interpolant along an edge of the old mesh, file units.
    pub error_before: f64,
    /// The same for the refined mesh.
    pub error: f64,
    /// Smallest angle of a triangle of the old mesh, degrees.
    pub smallest_old_angle: f64,
    /// Smallest angle of a triangle with a new vertex, degrees; infinity where there is none.
    pub smallest_new_angle: f64,
    /// Rounds of refinement.
    pub steps: usize,
    /// Whether the tolerance was met; else the number of faces, or edges too short to split, stopped it.
    pub is_reached: bool,
}

/// Edges shorter than this, relative to the longest edge of the mesh, are not split.
const SHORTEST_REL: f64 = 1e-7;
/// A cell is split at most once in a round; lengths halve at least each second one.
const MOST_STEPS: usize = 200;

/// Halves whose angles are at least this, degrees, stay: smaller, and needles come; larger, and faces are wasted (30
/// makes a tenth more of them from straight fronts).
const PERMANENT: f64 = 10.0;
/// Where the best places would make an angle below this, degrees, edges are split halfway. At 12 the number of faces
/// doubles, since ridges are no longer met; at 0 angles of a degree appear.
const NEEDLE: f64 = 4.0;

/// Windows narrower than this, relative to their edge, are left out.
const NARROWEST_REL: f64 = 1e-11;

/// Where a vertex lies on the old mesh.
#[derive(Clone, Copy, Debug)]
enum Origin {
    Vertex(VertexId),
    /// Distance from the edge's origin, scaled.
    Edge(EdgeId, f64),
    /// Place in the face's layout.
    Inside(FaceId, [f64; 2]),
}

/// A triangle, or one that is halved at a vertex `m` on side `k`: two triangles.
#[derive(Clone, Copy, Debug)]
struct Cell {
    corners: [u32; 3],
    parent: FaceId,
    middle: Option<(u8, u32)>,
}

impl Cell {
    fn plain(corners: [u32; 3], parent: FaceId) -> Self {
        Self { corners, parent, middle: None }
    }

    /// Corners such that the split side comes first, and the vertex on it.
    fn halved(&self) -> Option<([u32; 3], u32)> {
        self.middle.map(|(k, m)| {
            let k = k as usize;
            ([self.corners[k], self.corners[(k + 1) % 3], self.corners[(k + 2) % 3]], m)
        })
    }

    fn triangles(&self) -> impl Iterator<Item = [u32; 3]> + use<> {
        let [first, second] = match self.halved() {
            None => [Some(self.corners), None],
            Some(([a, b, c], m)) => [Some([a, m, c]), Some([m, b, c])],
        };
        first.into_iter().chain(second)
    }

    /// The edges of its triangles on its outline.
    fn outline(&self) -> impl Iterator<Item = Key> + use<> {
        let sides = match self.halved() {
            None => {
                let [a, b, c] = self.corners;
                [Some(key(a, b)), Some(key(b, c)), Some(key(c, a)), None]
            }
            Some(([a, b, c], m)) => [Some(key(a, m)), Some(key(m, b)), Some(key(b, c)), Some(key(c, a))],
        };
        sides.into_iter().flatten()
    }

    /// The edge between its two triangles.
    fn bisector(&self) -> Option<Key> {
        self.halved().map(|([_, _, c], m)| key(m, c))
    }
}

/// An edge by its vertices, ascending.
type Key = (u32, u32);

fn key(a: u32, b: u32) -> Key {
    (a.min(b), a.max(b))
}

/// The field along an edge compared with its linear interpolant.
#[derive(Clone, Copy, Debug)]
struct Comparison {
    /// Largest difference, scaled.
    error: f64,
    /// Whether the edge is long enough to be split.
    is_long: bool,
    /// Where it would be split for the error's sake, and halfway.
    best: Sample,
    halfway: Sample,
}

/// The field at a place of an edge.
#[derive(Clone, Copy, Debug)]
struct Sample {
    /// Fraction from the end with the smaller number.
    at: f64,
    distance: f64,
    label: u32,
}

impl Field<'_> {
    /// Refines the mesh until the field is linear along every edge up to a tolerance.
    ///
    /// # Errors     a tolerance that is not above 0; a wavefront that kept no windows; a stop
    /// # Cost       near linear in the faces that are made, times the windows of a face
    /// # Guarantees the same surface; exact distances at the new vertices
    /// # Source     [Bommes2012] §9, adaptive refinement
    pub fn refine(&self, options: &RefineOptions, progress: &Progress) -> Result<Refinement, GeodesicError> {
        self.needs_windows()?;
        if !(options.tolerance > 0.0 && options.tolerance.is_finite()) {
            return Err(GeodesicError::Option { what: "the tolerance", range: "above 0", value: options.tolerance });
        }
        let mut refiner = Refiner::new(*self, options.tolerance * self.wave.surface.scale());
        let error_before = refiner.compare_all(progress)?;
        let (mut error, mut steps, mut is_reached) = (error_before, 0, error_before <= refiner.tolerance);
        while !is_reached && steps < MOST_STEPS {
            progress.report("refine", (refiner.tolerance / error).clamp(0.0, 1.0));
            let mut tags = refiner.tags();
            if tags.is_empty() || refiner.faces_after(&tags) > options.most_faces {
                break;
            }
            refiner.keep_angles(&mut tags);
            refiner.split(&tags);
            steps += 1;
            error = refiner.compare_all(progress)?;
            is_reached = error <= refiner.tolerance;
        }
        Ok(refiner.finish([error_before, error], steps, is_reached))
    }
}

/// A mesh on its way to be fine enough.
struct Refiner<'w> {
    field: Field<'w>,
    tolerance: f64,
    origins: Vec<Origin>,
    /// Scaled.
    distance: Vec<f64>,
    label: Vec<u32>,
    cells: Vec<Cell>,
    /// Edges that were met; those that are gone may stay.
    compared: HashMap<Key, Comparison>,
}

impl<'w> Refiner<'w> {
    fn new(field: Field<'w>, tolerance: f64) -> Self {
        let wave = field.wave;
        let mesh = wave.surface.connectivity();
        Self {
            field,
            tolerance,
            origins: mesh.vertices().map(Origin::Vertex).collect(),
            distance: wave.distance.values().to_vec(),
            label: wave.label.values().to_vec(),
            cells: mesh.faces().map(|f| Cell::plain(mesh.face_vertices(f).map(|v| v.0), f)).collect(),
            compared: HashMap::new(),
        }
    }

    // ----- comparing -----

    /// Compares the field on all edges; returns the largest error.
    fn compare_all(&mut self, progress: &Progress) -> Result<f64, GeodesicError> {
        let mut compared = std::mem::take(&mut self.compared);
        let mut largest = 0.0f64;
        for (i, cell) in self.cells.iter().enumerate() {
            if i % 4096 == 0 {
                progress.check()?;
            }
            for edge in cell.outline().chain(cell.bisector()) {
                let comparison = compared.entry(edge).or_insert_with(|| self.compare(edge, cell.parent));
                largest = largest.max(comparison.error);
            }
        }
        self.compared = compared;
        Ok(largest)
    }

    fn compare(&self, (u, v): Key, face: FaceId) -> Comparison {
        let (p, q) = (self.place(u, face), self.place(v, face));
        let length = (q[0] - p[0]).hypot(q[1] - p[1]);
        let ends = [u, v].map(|v| self.distance[v as usize]);
        let is_finite = ends.iter().all(|d| d.is_finite());
        if !(is_finite && length > 0.0) {
            let none = Sample { at: 0.5, distance: ends[0].max(ends[1]), label: self.label[u as usize] };
            return Comparison { error: 0.0, is_long: false, best: none, halfway: none };
        }
        let windows = self.windows_along(u, v, face, [p, q]);
        let (error, worst_at) = largest_error(&windows, length, ends);
        let sample = |at: f64| self.sample(&windows, face, [p, q], at, length);
        let is_long = length > SHORTEST_REL;
        Comparison { error, is_long, best: sample(clamped(worst_at)), halfway: sample(0.5) }
    }

    /// The windows along an edge, counted from `u`.
    fn windows_along(&self, u: u32, v: u32, face: FaceId, [p, q]: [[f64; 2]; 2]) -> Vec<Window> {
        let Some((e, from, to)) = self.on_old_edge(u, v, face) else { return self.field.along(face, p, q) };
        // Where two fronts begin at one point, rounding may leave room for a window that is far too long, and as narrow
        // as rounding: places in it are looked up otherwise.
        let narrow = NARROWEST_REL * self.field.wave.surface.length(e);
        let windows = self.field.wave.lists.of(e).iter().filter(|w| w.b1 - w.b0 > narrow);
        let (lo, hi) = (from.min(to), from.max(to));
        let clip = |w: &Window| (w.b1 > lo && w.b0 < hi).then(|| w.over(w.b0.max(lo), w.b1.min(hi)));
        if from < to {
            windows.filter_map(clip).map(|w| w.shifted(from)).collect()
        } else {
            windows.rev().filter_map(clip).map(|w| w.reversed(from)).collect()
        }
    }

    /// The old edge on which two vertices lie, and their places on it.
    fn on_old_edge(&self, u: u32, v: u32, face: FaceId) -> Option<(EdgeId, f64, f64)> {
        let wave = self.field.wave;
        let mesh = wave.surface.connectivity();
        let on = |e: EdgeId, origin: Origin| match origin {
            Origin::Vertex(w) if mesh.ends(e)[0] == w => Some(0.0),
            Origin::Vertex(w) if mesh.ends(e)[1] == w => Some(wave.surface.length(e)),
            Origin::Edge(other, x) if other == e => Some(x),
            _ => None,
        };
        mesh.face_half_edges(face).into_iter().map(|h| mesh.edge(h)).find_map(|e| {
            let (from, to) = on(e, self.origins[u as usize]).zip(on(e, self.origins[v as usize]))?;
            Some((e, from, to))
        })
    }

    /// The field at a fraction of an edge.
    fn sample(&self, windows: &[Window], face: FaceId, [p, q]: [[f64; 2]; 2], at: f64, length: f64) -> Sample {
        let wave = self.field.wave;
        let x = at * length;
        let near = windows.partition_point(|w| w.b1 < x);
        let covers = |w: &&Window| w.b0 <= x && x <= w.b1;
        let known = windows[near..].iter().take(2).filter(covers).min_by(|a, b| a.at(x).total_cmp(&b.at(x)));
        if let Some(w) = known {
            return Sample { at, distance: w.at(x), label: label_of(&wave.label, &wave.sources, w.root()) };
        }
        // Between two windows that rounding has parted.
        let place = [0, 1].map(|k| p[k] + at * (q[k] - p[k]));
        let approach = self.field.approach(face, place, None);
        let (distance, label) = approach.map_or((f64::INFINITY, u32::MAX), |a| (a.distance, a.label));
        Sample { at, distance, label }
    }

    /// Where a vertex lies in the layout of an old face.
    fn place(&self, v: u32, face: FaceId) -> [f64; 2] {
        let surface = self.field.wave.surface;
        let mesh = surface.connectivity();
        let layout = surface.layout(face);
        match self.origins[v as usize] {
            Origin::Inside(_, at) => at,
            Origin::Vertex(v) => {
                let corners = mesh.face_vertices(face);
                layout[(0..3).find(|&k| corners[k] == v).expect("cells lie in the faces of their corners")]
            }
            Origin::Edge(e, x) => {
                let sides = mesh.face_half_edges(face);
                let k = (0..3).find(|&k| mesh.edge(sides[k]) == e).expect("cells lie in the faces of their edges");
                let t = x / surface.length(e);
                let t = if mesh.half_edge(e) == sides[k] { t } else { 1.0 - t };
                [0, 1].map(|i| (1.0 - t) * layout[k][i] + t * layout[(k + 1) % 3][i])
            }
        }
    }

    // ----- tagging -----

    /// The edges to be split: those with too large an error, and those that keep cells regular.
    fn tags(&self) -> HashMap<Key, Sample> {
        let mut beside: HashMap<Key, [u32; 2]> = HashMap::new();
        let mut tags: HashMap<Key, Sample> = HashMap::new();
        let mut to_visit: Vec<u32> = Vec::new();
        let mut halves: HashSet<Key> = HashSet::new();
        // 1. Errors.
        for (i, cell) in self.cells.iter().enumerate() {
            let wrong = |edge: &Key| self.compared[edge].error > self.tolerance && self.compared[edge].is_long;
            for edge in cell.outline() {
                beside.entry(edge).and_modify(|two| two[1] = i as u32).or_insert([i as u32, u32::MAX]);
                if wrong(&edge) {
                    tags.insert(edge, self.compared[&edge].best);
                }
            }
            if cell.bisector().filter(wrong).is_some_and(|bisector| halves.insert(bisector)) {
                to_visit.push(i as u32);
            }
        }
        to_visit.extend(
            (0..self.cells.len() as u32).filter(|&i| self.cells[i as usize].outline().any(|e| tags.contains_key(&e))),
        );
        // 2. Cells with two split sides, and halved ones that change at all, get all their sides split.
        while let Some(i) = to_visit.pop() {
            let cell = &self.cells[i as usize];
            let count = cell.outline().filter(|e| tags.contains_key(e)).count();
            let sides: Vec<Key> = match cell.halved() {
                None if count >= 2 => cell.outline().collect(),
                Some(([a, b, c], m)) if count >= 1 || halves.contains(&key(m, c)) => vec![key(b, c), key(c, a)],
                _ => continue,
            };
            for side in sides {
                if let Entry::Vacant(place) = tags.entry(side) {
                    place.insert(self.compared[&side].halfway);
                    to_visit.extend(beside[&side].iter().filter(|&&j| j != u32::MAX && j != i));
                }
            }
        }
        tags
    }

    /// The number of triangles after a split.
    fn faces_after(&self, tags: &HashMap<Key, Sample>) -> usize {
        let of = |cell: &Cell| {
            let count = cell.outline().filter(|e| tags.contains_key(e)).count();
            match (cell.middle, count) {
                (None, 0) => 1,
                (None, 1) | (Some(_), 0) => 2,
                (None, _) => 4,
                (Some(_), count) => 2 + count,
            }
        };
        self.cells.iter().map(of).sum()
    }

    // ----- splitting -----

    /// Splits halfway instead where the best places would make needles: then the parts are similar to the whole.
    fn keep_angles(&self, tags: &mut HashMap<Key, Sample>) {
        let mut halfway: HashSet<Key> = HashSet::new();
        for cell in &self.cells {
            let (corners, first) = cell.halved().map_or((cell.corners, None), |(corners, m)| (corners, Some(m)));
            let layout = corners.map(|v| self.place(v, cell.parent));
            let at = |k: usize| {
                let (u, v) = (k, (k + 1) % 3);
                let t = tags.get(&key(corners[u], corners[v]))?.at;
                let t = if corners[u] < corners[v] { t } else { 1.0 - t };
                Some([0, 1].map(|i| (1.0 - t) * layout[u][i] + t * layout[v][i]))
            };
            let points = [first.map(|m| self.place(m, cell.parent)).or_else(|| at(0)), at(1), at(2)];
            let [a, b, c] = layout;
            let parts: Vec<[[f64; 2]; 3]> = match points {
                [None, None, None] => continue,
                [Some(p0), Some(p1), Some(p2)] => vec![[a, p0, p2], [p0, b, p1], [p2, p1, c], [p0, p1, p2]],
                _ => (0..3)
                    .filter_map(|k| points[k].map(|m| (k, m)))
                    .flat_map(|(k, m)| {
                        let [a, b, c] = [0, 1, 2].map(|i| layout[(k + i) % 3]);
                        [[a, m, c], [m, b, c]]
                    })
                    .collect(),
            };
            if parts.into_iter().map(smallest_angle).fold(f64::INFINITY, f64::min) < NEEDLE {
                halfway.extend(cell.outline().filter(|edge| tags.contains_key(edge)));
            }
        }
        for edge in halfway {
            tags.insert(edge, self.compared[&edge].halfway);
        }
    }

    /// Splits tagged edges and the cells beside them.
    fn split(&mut self, tags: &HashMap<Key, Sample>) {
        let mut new_vertex: HashMap<Key, u32> = HashMap::with_capacity(tags.len());
        let mut cells = Vec::with_capacity(self.cells.len());
        for cell in std::mem::take(&mut self.cells) {
            let parent = cell.parent;
            let mut on = |this: &mut Self, edge: Key| {
                let sample = tags.get(&edge)?;
                Some(*new_vertex.entry(edge).or_insert_with(|| this.add_vertex(edge, sample, parent)))
            };
            let (corners, first) = cell.halved().map_or((cell.corners, None), |(corners, m)| (corners, Some(m)));
            let [a, b, c] = corners;
            let points = [first.or_else(|| on(self, key(a, b))), on(self, key(b, c)), on(self, key(c, a))];
            match points {
                [Some(p0), Some(p1), Some(p2)] => {
                    // The halves of a side that was split before may be split again.
                    let mut half = |u: u32, v: u32| first.and_then(|_| on(self, key(u, v))).map(|m| (0, m));
                    let middles = [half(a, p0), half(p0, b)];
                    cells.push(Cell { corners: [a, p0, p2], parent, middle: middles[0] });
                    cells.push(Cell { corners: [p0, b, p1], parent, middle: middles[1] });
                    cells.push(Cell::plain([p2, p1, c], parent));
                    cells.push(Cell::plain([p0, p1, p2], parent));
                }
                _ => {
                    let middle = (0..3).find_map(|k| points[k].map(|m| (k as u8, m)));
                    cells.push(Cell { corners, parent, middle });
                }
            }
        }
        // Halves of good shape may be halved again.
        self.cells = Vec::with_capacity(cells.len());
        for cell in cells {
            let angle = |t: [u32; 3]| smallest_angle(t.map(|v| self.place(v, cell.parent)));
            let good = cell.middle.is_some() && cell.triangles().all(|t| angle(t) >= PERMANENT);
            if good {
                self.cells.extend(cell.triangles().map(|t| Cell::plain(t, cell.parent)));
            } else {
                self.cells.push(cell);
            }
        }
        self.compared.retain(|edge, _| !tags.contains_key(edge));
    }

    fn add_vertex(&mut self, (u, v): Key, sample: &Sample, face: FaceId) -> u32 {
        let t = sample.at;
        let origin = match self.on_old_edge(u, v, face) {
            Some((e, from, to)) => Origin::Edge(e, from + t * (to - from)),
            None => {
                let (p, q) = (self.place(u, face), self.place(v, face));
                Origin::Inside(face, [0, 1].map(|k| p[k] + t * (q[k] - p[k])))
            }
        };
        self.origins.push(origin);
        self.distance.push(sample.distance);
        self.label.push(sample.label);
        (self.origins.len() - 1) as u32
    }

    // ----- result -----

    fn finish(self, [error_before, error]: [f64; 2], steps: usize, is_reached: bool) -> Refinement {
        let surface = self.field.wave.surface;
        let (mesh, scale) = (surface.connectivity(), surface.scale());
        let mut faces = Vec::with_capacity(self.cells.len());
        let mut parents = Vec::with_capacity(self.cells.len());
        let mut smallest = f64::INFINITY;
        for cell in &self.cells {
            for triangle in cell.triangles() {
                if triangle.iter().any(|&v| v as usize >= mesh.vertex_count()) {
                    smallest = smallest.min(smallest_angle(triangle.map(|v| self.place(v, cell.parent))));
                }
                faces.push(triangle);
                parents.push(cell.parent);
            }
        }
        let connectivity = TriConnectivity::from_faces(self.origins.len(), &faces)
            .expect("replacing triangles by triangulations of them keeps a manifold one");
        let parent_face = FaceMap::from_vec(parents);
        let length = EdgeMap::from_fn(connectivity.edge_count(), |e| {
            let [u, v] = connectivity.ends(e).map(|v| self.place(v.0, parent_face[connectivity.edge_faces(e).0]));
            (u[0] - v[0]).hypot(u[1] - v[1]) / scale
        });
        Refinement {
            points: VertexMap::from_vec(self.origins.iter().map(|&origin| self.point(origin)).collect()),
            distance: VertexMap::from_vec(self.distance.iter().map(|d| d / scale).collect()),
            label: VertexMap::from_vec(self.label.iter().map(|&l| (l != u32::MAX).then_some(l)).collect()),
            connectivity,
            parent_face,
            length,
            error_before: error_before / scale,
            error: error / scale,
            smallest_old_angle: mesh.faces().map(|f| smallest_angle(surface.layout(f))).fold(f64::INFINITY, f64::min),
            smallest_new_angle: smallest,
            steps,
            is_reached,
        }
    }

    fn point(&self, origin: Origin) -> SurfacePoint {
        let surface = self.field.wave.surface;
        let mesh = surface.connectivity();
        let mut weights = [0.0; 3];
        match origin {
            Origin::Vertex(v) => {
                let h = mesh.outgoing_half_edge(v);
                weights[(h.0 % 3) as usize] = 1.0;
                SurfacePoint { face: mesh.face(h), weights }
            }
            Origin::Edge(e, x) => {
                let h = mesh.half_edge(e);
                let (k, t) = ((h.0 % 3) as usize, x / surface.length(e));
                (weights[k], weights[(k + 1) % 3]) = (1.0 - t, t);
                SurfacePoint { face: mesh.face(h), weights }
            }
            Origin::Inside(face, at) => SurfacePoint { face, weights: barycentric(surface.layout(face), at) },
        }
    }
}

/// The largest difference between the field along an edge and the line between its ends' distances, and the fraction
/// where it is.
fn largest_error(windows: &[Window], length: f64, [d0, d1]: [f64; 2]) -> (f64, f64) {
    let slope = (d1 - d0) / length;
    let (mut worst, mut at) = (0.0, 0.5 * length);
    for w in windows {
        let extremum = w.has_slope_at(slope);
        let inside = (extremum > w.b0 && extremum < w.b1).then_some(extremum);
        for x in [Some(w.b0), Some(w.b1), inside].into_iter().flatten() {
            let error = (w.at(x) - (d0 + slope * x)).abs();
            if error > worst {
                (worst, at) = (error, x);
            }
        }
    }
    (worst, at / length)
}

/// Where an edge is split for an error at a fraction: not near its ends, or so that the error's place is halfway of a
/// part ([Bommes2012] §9).
fn clamped(t: f64) -> f64 {
    match t {
        t if t < 0.125 => 0.25,
        t if t < 0.25 => 2.0 * t,
        t if t <= 0.75 => t,
        t if t < 0.875 => 2.0 * t - 1.0,
        _ => 0.75,
    }
}

/// Smallest angle of a triangle, degrees.
fn smallest_angle(corners: [[f64; 2]; 3]) -> f64 {
    let angle = |k: usize| {
        let [a, b, c] = [0, 1, 2].map(|i| corners[(k + i) % 3]);
        let frame = Frame::new(a, b, (b[0] - a[0]).hypot(b[1] - a[1]));
        let [x, y] = frame.to(c);
        y.abs().atan2(x).to_degrees()
    };
    (0..3).map(angle).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{IntrinsicSurface, Options, Source, Wavefront, boundary_sources};
    use quadloom_mesh::metric::edge_lengths;
    use quadloom_mesh::shapes::{sphere, with_noise};
    use quadloom_mesh::{DVec3, TriMesh};

    #[test]
    fn splits_keep_away_from_ends() {
        for i in 0..=1000 {
            let t = f64::from(i) / 1000.0;
            assert!((0.25..=0.75).contains(&clamped(t)), "{t}");
        }
        // The place of the error is halfway of a part.
        assert_eq!((clamped(0.2), clamped(0.8)), (0.4, 0.6000000000000001));
    }

    /// A square plane of irregular triangles.
    fn plane(n: usize) -> TriMesh {
        let at = |i: usize, j: usize| {
            let inner = |k: usize| k > 0 && k < n;
            let shift = |a: usize, b: usize| 0.3 * ((a * 7919 + b * 104_729) as f64).sin();
            let (dx, dy) = if inner(i) && inner(j) { (shift(i, j), shift(j + 50, i)) } else { (0.0, 0.0) };
            DVec3::new((i as f64 + dx) / n as f64, (j as f64 + dy) / n as f64, 0.0)
        };
        let positions = (0..=n).flat_map(|j| (0..=n).map(move |i| at(i, j))).collect();
        let id = |i: usize, j: usize| (j * (n + 1) + i) as u32;
        let faces: Vec<[u32; 3]> = (0..n)
            .flat_map(|j| (0..n).map(move |i| (i, j)))
            .flat_map(|(i, j)| {
                let [a, b, c, d] = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
                if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
            })
            .collect();
        TriMesh::new(positions, &faces).unwrap()
    }

    #[test]
    fn straight_fronts_need_few_faces() {
        let mesh = plane(14);
        let lengths = edge_lengths(&mesh);
        let surface = IntrinsicSurface::new(&mesh, &lengths).unwrap();
        let mut wave = Wavefront::new(&surface);
        wave.spread(&boundary_sources(&mesh, 0), &Options::default(), &Progress::none()).unwrap();
        let coarse = wave.field().refine(&RefineOptions::within(1.0), &Progress::none()).unwrap();
        assert_eq!(coarse.connectivity.face_count(), mesh.face_count());
        let fine = wave.field().refine(&RefineOptions::within(coarse.error / 100.0), &Progress::none()).unwrap();
        let factor = fine.connectivity.face_count() as f64 / mesh.face_count() as f64;
        assert!(fine.is_reached && fine.error <= fine.error_before / 100.0);
        assert!(factor <= 4.0, "{factor}");
        assert!(fine.smallest_new_angle >= 1.0, "{}", fine.smallest_new_angle);
        // Exact at the new vertices.
        for (v, p) in fine.points.iter() {
            let at = p.position(&mesh);
            let truth = at.x.min(at.y).min(1.0 - at.x).min(1.0 - at.y);
            assert!((fine.distance[v] - truth).abs() <= 1e-12, "{at} {} {truth}", fine.distance[v]);
        }
    }

    #[test]
    fn new_vertices_have_the_distance_of_their_points() {
        let mesh = with_noise(&sphere(1.0, 2), 0.1, 5);
        let lengths = edge_lengths(&mesh);
        let surface = IntrinsicSurface::new(&mesh, &lengths).unwrap();
        let mut wave = Wavefront::new(&surface);
        let p = |face: u32, weights: [f64; 3]| SurfacePoint { face: FaceId(face), weights };
        let sources = [
            Source::point(p(3, [0.2, 0.3, 0.5])),
            Source::segment(p(100, [0.1, 0.2, 0.7]), p(100, [0.6, 0.4, 0.0])).with_label(1),
        ];
        wave.spread(&sources, &Options::default(), &Progress::none()).unwrap();
        let fine = wave.field().refine(&RefineOptions::within(1e-3), &Progress::none()).unwrap();
        assert!(fine.is_reached);
        for (v, point) in fine.points.iter() {
            let nearest = wave.field().at(point).unwrap();
            assert!(
                (fine.distance[v] - nearest.distance).abs() <= 1e-9,
                "{v} {} {}",
                fine.distance[v],
                nearest.distance
            );
        }
        // The same surface: its area, and its topology.
        let positions = fine.points.map(|p| p.position(&mesh));
        let refined = TriMesh::from_parts(fine.connectivity.clone(), positions).unwrap();
        assert!((refined.area() - mesh.area()).abs() <= 1e-12 * mesh.area());
        for (e, length) in edge_lengths(&refined).iter() {
            assert!((length - fine.length[e]).abs() <= 1e-12);
        }
        // Linear along edges.
        for e in refined.edges() {
            let [a, b] = refined.ends(e);
            let [p, q] = [a, b].map(|v| refined.position(v));
            let face = fine.parent_face[refined.edge_faces(e).0];
            for t in [0.25, 0.5, 0.75] {
                let at = p.lerp(q, t);
                let corners = mesh.face_vertices(face).map(|v| mesh.position(v));
                let weights = weights_of(corners, at);
                let truth = wave.field().at(&SurfacePoint { face, weights }).unwrap().distance;
                let linear = fine.distance[a] * (1.0 - t) + fine.distance[b] * t;
                assert!((truth - linear).abs() <= 1e-3 + 1e-9, "{e}: {truth} {linear}");
            }
        }
    }

    fn weights_of([a, b, c]: [DVec3; 3], p: DVec3) -> [f64; 3] {
        let n = (b - a).cross(c - a);
        let w =
            [(b - p).cross(c - p), (c - p).cross(a - p), (a - p).cross(b - p)].map(|x| (x.dot(n) / n.dot(n)).max(0.0));
        let sum: f64 = w.iter().sum();
        w.map(|w| w / sum)
    }
}
