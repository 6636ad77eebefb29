//! Exact distances against closed forms, to 1e-12 of the largest (1e-11 on needles); lengths of traced paths to 1e-10.
//!
//! In: surfaces that unfold to the plane, told by connectivity and edge lengths alone: a plane with convex outline, one
//! with obstacles, cylinder, cones of less and more than a full turn, cube, octahedron, regular tetrahedron, flat torus,
//! pillow, two discs glued; cut irregularly (also to needles by random splits) or as regularly as can be.
//! Out: distances of all vertices and of random points as the unfolded figure has them.

mod common;

use common::{Oracle, dice};
use quadloom_geodesic::{CurveTracer, IntrinsicSurface, Options, Source, SourceShape, Wavefront, vertex_distances};
use quadloom_mesh::{DVec2, EdgeMap, FaceId, Progress, SurfacePoint, TriConnectivity, VertexId};
use std::collections::{BTreeMap, HashMap};
use std::f64::consts::{PI, TAU};

/// Error allowed, relative to the largest distance.
const ROUNDING: f64 = 1e-12;
/// The same on figures cut to needles. The crate is told lengths, whose rounding moves the apex of a triangle by their
/// square over its height: 1e-10 sides where it is as thin as 1e-6, of which up to 6e-12 are left in a distance. Paths
/// unfolded with fifty digits from the lengths as told differ from the closed forms by as much, and from the crate by
/// 1e-14.
const ROUNDING_ON_NEEDLES: f64 = 1e-11;
/// What a needle is: height by longest side.
const NEEDLE: f64 = 1e-5;

/// A surface whose faces lie in the plane: all of it, or each face for itself.
struct Unfolded {
    mesh: TriConnectivity,
    /// Where each face's corners lie.
    corners: Vec<[DVec2; 3]>,
    length: EdgeMap<f64>,
}

impl Unfolded {
    fn new(vertices: usize, faces: &[[u32; 3]], corners: Vec<[DVec2; 3]>) -> Self {
        let mesh = TriConnectivity::from_faces(vertices, faces).unwrap();
        let length = EdgeMap::from_fn(mesh.edge_count(), |e| {
            let h = mesh.half_edge(e);
            let (face, k) = (mesh.face(h).index(), (h.0 % 3) as usize);
            corners[face][k].distance(corners[face][(k + 1) % 3])
        });
        Self { mesh, corners, length }
    }

    /// The same, of faces that are all seen from above: where one is turned over, the figure overlaps itself, and
    /// distances on it are shorter or longer than those of the figure without.
    fn upright(self) -> Self {
        assert!(self.corners.iter().all(|t| twice_area(t) > 0.0), "no face is turned over");
        self
    }

    /// Least height of a face by its longest side.
    fn thinnest(&self) -> f64 {
        let longest = |[a, b, c]: &[DVec2; 3]| a.distance(*b).max(b.distance(*c)).max(c.distance(*a));
        let thin = |t| twice_area(t).abs() / longest(t).powi(2);
        self.corners.iter().map(thin).fold(f64::INFINITY, f64::min)
    }

    fn place(&self, p: &SurfacePoint) -> DVec2 {
        let [a, b, c] = self.corners[p.face.index()];
        a * p.weights[0] + b * p.weights[1] + c * p.weights[2]
    }

    /// A point inside a face, on a side, or at a corner.
    fn random_point(&self, seed: u64, index: u64) -> SurfacePoint {
        let face = (dice(seed, index) * self.mesh.face_count() as f64) as usize % self.mesh.face_count();
        let (mut a, mut b) = (dice(seed, index + 1), dice(seed, index + 2));
        if a + b > 1.0 {
            (a, b) = (1.0 - a, 1.0 - b);
        }
        match index % 5 {
            0 => b = 0.0,
            1 => (a, b) = (1.0, 0.0),
            _ => {}
        }
        SurfacePoint { face: FaceId::new(face), weights: [1.0 - a - b, a, b] }
    }

    fn at_vertex(&self, v: VertexId) -> SurfacePoint {
        let h = self.mesh.outgoing_half_edge(v);
        let mut weights = [0.0; 3];
        weights[(h.0 % 3) as usize] = 1.0;
        SurfacePoint { face: self.mesh.face(h), weights }
    }

    /// The same surface with faces and sides split at random places, and for each face the one that it is a part of.
    fn shattered(&self, seed: u64, rounds: u64) -> (Self, Vec<usize>) {
        let mut shards = Shards {
            vertices: self.mesh.vertex_count() as u32,
            faces: self.mesh.faces().map(|f| self.mesh.face_vertices(f).map(|v| v.0)).collect(),
            corners: self.corners.clone(),
            part_of: (0..self.mesh.face_count()).collect(),
        };
        (0..rounds).for_each(|round| shards.split(100 * seed + round));
        (Self::new(shards.vertices as usize, &shards.faces, shards.corners), shards.part_of)
    }

    /// Points, segments in a face, polylines and closed polylines with labels and start values; where their pieces lie.
    fn mixed_sources(&self, seed: u64) -> (Vec<Source>, Vec<Figure>) {
        let surface = IntrinsicSurface::new(&self.mesh, &self.length).unwrap();
        let mut tracer = CurveTracer::new(&surface);
        let scale = self.length.values().iter().copied().fold(0.0, f64::max);
        let (mut sources, mut figures) = (Vec::new(), Vec::new());
        for k in 0..1 + seed % 4 {
            let start = if k > 0 { scale * dice(seed, 900 + k) } else { 0.0 };
            let p = |j: u64| self.random_point(seed, 31 * k + 7 * j);
            let points = match (seed + k) % 4 {
                0 => vec![p(0)],
                1 => vec![p(2), SurfacePoint { face: p(2).face, ..p(3) }],
                2 => vec![p(1), p(2), p(3)],
                _ => vec![p(2), p(3), p(4), p(2)],
            };
            let pieces = tracer.join(&points, k as u32, &Progress::none()).unwrap();
            figures.push((pieces.iter().map(|piece| self.place_of(piece)).collect(), start));
            sources.extend(pieces.into_iter().map(|piece| piece.with_start(start)));
        }
        (sources, figures)
    }

    fn place_of(&self, source: &Source) -> [DVec2; 2] {
        match source.shape {
            SourceShape::Segment(p, q) => [p, q].map(|p| self.place(&p)),
            SourceShape::Point(p) => [self.place(&p); 2],
            SourceShape::Vertex(v) => [self.place(&self.at_vertex(v)); 2],
        }
    }

    /// The same faces with corners elsewhere.
    fn with_corners(self, place: impl Fn(usize, DVec2) -> DVec2) -> Self {
        let corners = self.corners.iter().enumerate().map(|(f, corners)| corners.map(|at| place(f, at))).collect();
        Self { corners, ..self }
    }

    /// Compares distances from mixed sources with those between all images of points in the plane.
    fn check_images<I: Iterator<Item = DVec2>>(&self, what: &str, seeds: u64, images: impl Fn(DVec2) -> I) {
        for seed in 0..seeds {
            let (sources, figures) = self.mixed_sources(seed);
            self.check(&format!("{what}, sources {seed}"), &sources, |p| {
                let at: Vec<DVec2> = images(self.place(p)).collect();
                let to = |(pieces, start): &Figure| {
                    let all = pieces.iter().flat_map(|&piece| at.iter().map(move |&at| to_segment(at, piece)));
                    start + all.fold(f64::INFINITY, f64::min)
                };
                figures.iter().map(to).collect()
            });
        }
    }

    /// Compares distances, labels, and lengths of paths with those of the figure.
    fn check(&self, what: &str, sources: &[Source], truth: impl Fn(&SurfacePoint) -> Vec<f64>) {
        let surface = IntrinsicSurface::new(&self.mesh, &self.length).unwrap();
        let mut wave = Wavefront::new(&surface);
        wave.spread(sources, &Options::default(), &Progress::none()).unwrap();
        let field = wave.field();
        let vertices = self.mesh.vertices().map(|v| self.at_vertex(v));
        let places: Vec<SurfacePoint> = vertices.chain((0..200).map(|k| self.random_point(77, 10 * k + 2))).collect();
        let truths: Vec<Vec<f64>> = places.iter().map(truth).collect();
        let nearest = |all: &[f64]| all.iter().copied().fold(f64::INFINITY, f64::min);
        let largest = truths.iter().map(|t| nearest(t)).fold(0.0, f64::max);
        let rounding = if self.thinnest() < NEEDLE { ROUNDING_ON_NEEDLES } else { ROUNDING };
        for (k, (p, all)) in places.iter().zip(&truths).enumerate() {
            let (found, exact) = (field.at(p).unwrap(), nearest(all));
            let error = (found.distance - exact) / largest;
            assert!(
                error.abs() <= rounding,
                "{what}: place {k} has {} instead of {exact}: {error:.2e}",
                found.distance
            );
            let label = found.label.unwrap() as usize;
            assert!(all[label] <= exact + 1e-9 * largest, "{what}: place {k} is not nearest to source {label}");
            if k < self.mesh.vertex_count() {
                let of_vertex = field.vertex_distance(VertexId::new(k));
                assert!((of_vertex - exact).abs() <= rounding * largest, "{what}: vertex {k}: {of_vertex} and {exact}");
            }
            if k % 7 == 0 {
                let path = field.path_from(p).unwrap().unwrap();
                let start = sources.iter().find(|s| s.label == path.label).unwrap().start;
                assert!((path.length + start - exact).abs() <= 1e-10 * largest, "{what}: path {k} has {}", path.length);
            }
        }
    }
}

/// Faces that are split: what is left of an [`Unfolded`] without its connectivity.
struct Shards {
    vertices: u32,
    faces: Vec<[u32; 3]>,
    corners: Vec<[DVec2; 3]>,
    /// The face of the beginning of which each is a part.
    part_of: Vec<usize>,
}

impl Shards {
    /// Replaces a face by parts, told by its corners 0..=2 and a new vertex 3.
    fn replace(&mut self, f: usize, parts: &[[usize; 3]], new: u32, at: DVec2) {
        let (ids, places) = (self.faces[f], self.corners[f]);
        let id = |k: usize| if k == 3 { new } else { ids[k] };
        let place = |k: usize| if k == 3 { at } else { places[k] };
        (self.faces[f], self.corners[f]) = (parts[0].map(id), parts[0].map(place));
        for part in &parts[1..] {
            self.faces.push(part.map(id));
            self.corners.push(part.map(place));
            self.part_of.push(self.part_of[f]);
        }
    }

    /// Splits many faces or their sides once, at places between 0.02 and 0.98 of them.
    fn split(&mut self, seed: u64) {
        let sides: HashMap<(u32, u32), (usize, usize)> = (0..self.faces.len())
            .flat_map(|f| (0..3).map(move |k| (f, k)))
            .map(|(f, k)| ((self.faces[f][k], self.faces[f][(k + 1) % 3]), (f, k)))
            .collect();
        let mut done = vec![false; self.faces.len()];
        for f in 0..done.len() {
            let chance = |k: u64| dice(seed, 5 * f as u64 + k);
            let (k, t) = ((3.0 * chance(0)) as usize % 3, 0.02 + 0.96 * chance(1));
            let twin = sides.get(&(self.faces[f][(k + 1) % 3], self.faces[f][k])).copied();
            if chance(2) < 0.3 || done[f] || twin.is_some_and(|(g, _)| done[g]) {
                continue;
            }
            let new = self.vertices;
            self.vertices += 1;
            done[f] = true;
            if chance(3) < 0.4 {
                let [a, b, c] = self.corners[f];
                let at = a.lerp(b, t).lerp(c, 0.02 + 0.96 * chance(4));
                self.replace(f, &[[0, 1, 3], [1, 2, 3], [2, 0, 3]], new, at);
                continue;
            }
            for (f, k, t) in [Some((f, k, t)), twin.map(|(g, j)| (g, j, 1.0 - t))].into_iter().flatten() {
                let (next, apex) = ((k + 1) % 3, (k + 2) % 3);
                let at = self.corners[f][k].lerp(self.corners[f][next], t);
                self.replace(f, &[[k, 3, apex], [3, next, apex]], new, at);
                done[f] = true;
            }
        }
    }
}

/// How a figure is cut into triangles.
#[derive(Clone, Copy, PartialEq)]
enum Cut {
    /// Vertices displaced and diagonals at random.
    Irregular,
    /// Vertices on lines through each other, diagonals all the same: every place is a tie.
    Regular,
}

impl Cut {
    /// A number in -1/4..1/4 by which a vertex is displaced, in steps of the grid.
    fn offset(self, seed: u64, index: u64) -> f64 {
        if self == Self::Regular { 0.0 } else { 0.5 * (dice(seed, index) - 0.5) }
    }

    /// Which diagonal a cell has.
    fn turn(self, seed: u64, cell: usize) -> usize {
        usize::from(self == Self::Irregular && dice(seed + 1, cell as u64) < 0.5)
    }
}

/// A square grid of `n` by `n` cells; `inside` tells which cells exist.
fn plane(n: usize, cut: Cut, seed: u64, inside: impl Fn(usize, usize) -> bool) -> Unfolded {
    let exists = |i: usize, j: usize| i < n && j < n && inside(i, j);
    // Vertices on the outline and on obstacles stay.
    let is_free = |i: usize, j: usize| {
        i > 0 && j > 0 && exists(i - 1, j - 1) && exists(i, j - 1) && exists(i - 1, j) && exists(i, j)
    };
    let at = |i: usize, j: usize| {
        let index = (j * (n + 1) + i) as u64;
        let [dx, dy] = [0, 1].map(|k| if is_free(i, j) { cut.offset(seed, 2 * index + k) } else { 0.0 });
        DVec2::new(i as f64 + dx, j as f64 + dy) / n as f64
    };
    let mut number = vec![u32::MAX; (n + 1) * (n + 1)];
    let (mut vertices, mut faces, mut corners) = (0, Vec::new(), Vec::new());
    for (i, j) in (0..n * n).map(|k| (k % n, k / n)).filter(|&(i, j)| exists(i, j)) {
        let cell = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
        let ids = cell.map(|(i, j)| {
            let id = &mut number[j * (n + 1) + i];
            if *id == u32::MAX {
                *id = vertices;
                vertices += 1;
            }
            *id
        });
        let turn = cut.turn(seed, j * n + i);
        for [a, b, c] in [[0, 1, 2], [0, 2, 3]].map(|t| t.map(|k| (k + turn) % 4)) {
            faces.push([ids[a], ids[b], ids[c]]);
            corners.push([a, b, c].map(|k| at(cell[k].0, cell[k].1)));
        }
    }
    Unfolded::new(vertices as usize, &faces, corners).upright()
}

/// Negative where the corners run clockwise.
fn twice_area([a, b, c]: &[DVec2; 3]) -> f64 {
    (*b - *a).perp_dot(*c - *a)
}

fn to_segment(p: DVec2, [a, b]: [DVec2; 2]) -> f64 {
    let ab = b - a;
    let t = if ab.length_squared() > 0.0 { ((p - a).dot(ab) / ab.length_squared()).clamp(0.0, 1.0) } else { 0.0 };
    p.distance(a + t * ab)
}

/// Segments with a start value.
type Figure = (Vec<[DVec2; 2]>, f64);

#[test]
fn a_convex_plane_has_euclidean_distances() {
    for seed in 0..12 {
        let flat = plane(9, Cut::Irregular, seed, |_, _| true);
        let surface = IntrinsicSurface::new(&flat.mesh, &flat.length).unwrap();
        let mut tracer = CurveTracer::new(&surface);
        let (mut sources, mut figures) = (Vec::new(), Vec::<Figure>::new());
        for k in 0..1 + seed % 4 {
            let start = if k > 0 { 0.3 * dice(seed, 900 + k) } else { 0.0 };
            let p = |j: u64| flat.random_point(seed, 31 * k + 7 * j);
            let points = match (seed + k) % 4 {
                // A vertex or a point; a segment in a face; an open and a closed polyline across faces.
                0 => vec![p(0)],
                1 => vec![p(2), SurfacePoint { face: p(2).face, ..p(3) }],
                2 => vec![p(1), p(2), p(3), p(4)],
                _ => vec![p(2), p(3), p(4), p(2)],
            };
            let pieces = tracer.join(&points, k as u32, &Progress::none()).unwrap();
            sources.extend(pieces.into_iter().map(|piece| piece.with_start(start)));
            let at: Vec<DVec2> = points.iter().map(|p| flat.place(p)).collect();
            figures.push((
                if at.len() > 1 { at.windows(2).map(|w| [w[0], w[1]]).collect() } else { vec![[at[0]; 2]] },
                start,
            ));
        }
        flat.check(&format!("plane {seed}"), &sources, |p| {
            let at = flat.place(p);
            let to = |(pieces, start): &Figure| {
                start + pieces.iter().map(|&piece| to_segment(at, piece)).fold(f64::INFINITY, f64::min)
            };
            figures.iter().map(to).collect()
        });
    }
}

/// A box of cells that do not exist.
type Hole = [usize; 4];

/// Whether a straight line passes through the inside of a box.
fn crosses(a: DVec2, b: DVec2, [x0, y0, x1, y1]: Hole, n: usize) -> bool {
    let (lo, hi) = (DVec2::new(x0 as f64, y0 as f64) / n as f64, DVec2::new(x1 as f64, y1 as f64) / n as f64);
    let (mut from, mut to) = (0.0f64, 1.0f64);
    for k in 0..2 {
        let (p, d) = (a[k], b[k] - a[k]);
        if d.abs() < 1e-15 {
            if p <= lo[k] + 1e-13 || p >= hi[k] - 1e-13 {
                return false;
            }
            continue;
        }
        let (s, t) = ((lo[k] - p) / d, (hi[k] - p) / d);
        (from, to) = (from.max(s.min(t)), to.min(s.max(t)));
    }
    to - from > 1e-12
}

#[test]
fn obstacles_are_passed_as_the_visibility_graph_says() {
    let n = 12;
    // A square; an L, as two boxes that overlap; three boxes, two of them from the outline.
    let figures: [&[Hole]; 3] =
        [&[[4, 4, 8, 8]], &[[2, 3, 5, 10], [2, 3, 10, 6]], &[[1, 2, 9, 4], [3, 6, 99, 8], [6, 9, 8, 99]]];
    for (figure, holes) in figures.iter().enumerate() {
        for seed in 0..6 {
            let is_hole = |i, j| holes.iter().any(|&[x0, y0, x1, y1]| i >= x0 && i < x1 && j >= y0 && j < y1);
            let cut = if seed % 3 == 2 { Cut::Regular } else { Cut::Irregular };
            let flat = plane(n, cut, 40 + seed, |i, j| !is_hole(i, j));
            let is_free = |a: DVec2, b: DVec2| !holes.iter().any(|&hole| crosses(a, b, hole, n));
            // 1. Sources: a point, or a segment in a face, and another point with a start value.
            let p = flat.random_point(seed, 3);
            let q = SurfacePoint { face: p.face, ..flat.random_point(seed, 13) };
            let r = flat.random_point(seed, 22);
            let pieces: [([DVec2; 2], f64); 2] = [
                ([flat.place(&p), if seed % 2 == 0 { flat.place(&p) } else { flat.place(&q) }], 0.0),
                ([flat.place(&r); 2], 0.2),
            ];
            let first = if seed % 2 == 0 { Source::point(p) } else { Source::segment(p, q) };
            let sources = [first, Source::point(r).with_label(1).with_start(0.2)];
            // 2. Corners, each with its distance from each source: Dijkstra over lines of sight.
            let to_node = |x: f64, y: f64| DVec2::new(x, y) / n as f64;
            let nodes: Vec<DVec2> = holes
                .iter()
                .flat_map(|&[x0, y0, x1, y1]| {
                    let [x0, y0, x1, y1] = [x0, y0, x1, y1].map(|x| x as f64);
                    [to_node(x0, y0), to_node(x1, y0), to_node(x1, y1), to_node(x0, y1)]
                })
                .collect();
            let straight = |at: DVec2, ([a, b], start): ([DVec2; 2], f64)| {
                let ab = b - a;
                let t = if a == b { 0.0 } else { ((at - a).dot(ab) / ab.length_squared()).clamp(0.0, 1.0) };
                let ends = [a, b, a + t * ab].into_iter().filter(|&end| is_free(at, end));
                start + ends.map(|end| at.distance(end)).fold(f64::INFINITY, f64::min)
            };
            let of_nodes = pieces.map(|piece| {
                let mut distance: Vec<f64> = nodes.iter().map(|&node| straight(node, piece)).collect();
                for _ in 0..nodes.len() {
                    for (i, &a) in nodes.iter().enumerate() {
                        for (j, &b) in nodes.iter().enumerate() {
                            if is_free(a, b) {
                                distance[j] = distance[j].min(distance[i] + a.distance(b));
                            }
                        }
                    }
                }
                distance
            });
            flat.check(&format!("obstacles {figure}, {seed}"), &sources, |p| {
                let at = flat.place(p);
                let over = |k: usize| {
                    let around = nodes.iter().zip(&of_nodes[k]).filter(|(node, _)| is_free(at, **node));
                    around.map(|(node, d)| d + at.distance(*node)).fold(straight(at, pieces[k]), f64::min)
                };
                vec![over(0), over(1)]
            });
        }
    }
}

/// A grid of `m` by `n` cells whose columns repeat, and its rows too if `closed`; cell (i, j) begins at `at(i, j)`.
fn wrapped([m, n]: [usize; 2], closed: bool, cut: Cut, seed: u64, at: impl Fn(f64, f64) -> DVec2) -> Unfolded {
    let rows = if closed { n } else { n + 1 };
    let id = |i: usize, j: usize| ((j % rows) * m + i % m) as u32;
    let place = |i: usize, j: usize| {
        let free = closed || (j > 0 && j < n);
        let [dx, dy] = [0, 1].map(|k| if free { cut.offset(seed, 2 * u64::from(id(i, j)) + k) } else { 0.0 });
        at(i as f64 + dx, j as f64 + dy)
    };
    let (mut faces, mut corners) = (Vec::new(), Vec::new());
    for (i, j) in (0..m * n).map(|k| (k % m, k / m)) {
        let cell = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
        let turn = cut.turn(seed, j * m + i);
        for t in [[0, 1, 2], [0, 2, 3]].map(|t| t.map(|k| cell[(k + turn) % 4])) {
            faces.push(t.map(|(i, j)| id(i, j)));
            corners.push(t.map(|(i, j)| place(i, j)));
        }
    }
    Unfolded::new(rows * m, &faces, corners).upright()
}

#[test]
fn a_cylinder_unfolds_to_a_strip() {
    for seed in 0..8 {
        let (m, n) = (7 + seed as usize, 6);
        let flat = wrapped([m, n], false, Cut::Irregular, seed, |x, y| DVec2::new(x, 1.7 * y));
        let shift = DVec2::new(m as f64, 0.0);
        let p = flat.random_point(seed, 1 + seed);
        let q = SurfacePoint { face: p.face, ..flat.random_point(seed, 53) };
        let piece = if seed % 2 == 0 { [p, p] } else { [p, q] }.map(|p| flat.place(&p));
        let sources = [if seed % 2 == 0 { Source::point(p) } else { Source::segment(p, q) }];
        flat.check(&format!("cylinder {seed}"), &sources, |p| {
            let at = flat.place(p);
            let images = (-2..=2).map(|k| to_segment(at + shift * f64::from(k), piece));
            vec![images.fold(f64::INFINITY, f64::min)]
        });
    }
}

#[test]
fn a_flat_torus_has_the_distances_of_its_lattice() {
    for seed in 0..8 {
        let (u, v) = (DVec2::new(1.0, 0.0), DVec2::new(0.37 - 0.1 * seed as f64, 0.9));
        let flat = wrapped([8, 7], true, Cut::Irregular, seed, |x, y| u * x / 8.0 + v * y / 7.0);
        let sources = [flat.random_point(seed, 2), flat.random_point(seed, 11)];
        let places = sources.map(|p| flat.place(&p));
        let sources = [0, 1].map(|k| Source::point(sources[k]).with_label(k as u32).with_start(0.1 * k as f64));
        flat.check(&format!("torus {seed}"), &sources, |p| {
            let at = flat.place(p);
            let images = (0..81).map(|k| u * f64::from(k % 9 - 4) + v * f64::from(k / 9 - 4));
            let least = |k: usize| {
                0.1 * k as f64 + images.clone().map(|t| (at + t).distance(places[k])).fold(f64::INFINITY, f64::min)
            };
            vec![least(0), least(1)]
        });
    }
}

/// A fan of rings around a vertex with the given sum of angles; polar coordinates of each face's corners.
fn cone(total: f64, sizes: [usize; 2], cut: Cut, seed: u64) -> (Unfolded, Vec<[[f64; 2]; 3]>) {
    let (flat, polars) = cone_or_folded(total, sizes, cut, seed);
    (flat.upright(), polars)
}

/// The same of any sectors: displaced vertices of wide ones turn faces over. That is a surface, but not a cone.
fn cone_or_folded(total: f64, [m, rings]: [usize; 2], cut: Cut, seed: u64) -> (Unfolded, Vec<[[f64; 2]; 3]>) {
    let (faces, polars) = fan(total, [m, rings], cut, seed);
    // Each face in a plane of its own, with the tip at the origin and its middle direction along x.
    let corners = polars.iter().map(|corners| {
        let middle = middle_angle(corners);
        corners.map(|[r, a]| r * DVec2::from_angle(a - middle))
    });
    (Unfolded::new(1 + rings * m, &faces, corners.collect()), polars)
}

/// Faces of a fan of rings, and polar coordinates of their corners; the last ring has the last vertices.
fn fan(total: f64, [m, rings]: [usize; 2], cut: Cut, seed: u64) -> (Vec<[u32; 3]>, Vec<[[f64; 2]; 3]>) {
    let id = |i: usize, j: usize| if j == 0 { 0 } else { (1 + (j - 1) * m + i % m) as u32 };
    let polar = |i: usize, j: usize| {
        let free = j > 0 && j < rings;
        let [dr, da] = [0, 1].map(|k| if free { cut.offset(seed, 2 * u64::from(id(i, j)) + k) } else { 0.0 });
        [j as f64 + dr, (i as f64 + da) * total / m as f64]
    };
    let mut cells = Vec::new();
    for i in 0..m {
        cells.push([(i, 0), (i, 1), (i + 1, 1)]);
        for j in 1..rings {
            let cell = [(i, j), (i, j + 1), (i + 1, j + 1), (i + 1, j)];
            let turn = cut.turn(seed, j * m + i);
            cells.extend([[0, 1, 2], [0, 2, 3]].map(|t| t.map(|k| cell[(k + turn) % 4])));
        }
    }
    let faces: Vec<[u32; 3]> = cells.iter().map(|t| t.map(|(i, j)| id(i, j))).collect();
    (faces, cells.iter().map(|t| t.map(|(i, j)| polar(i, j))).collect())
}

/// Mean angle of a face's corners, but for the tip.
fn middle_angle(corners: &[[f64; 2]; 3]) -> f64 {
    let angles: Vec<f64> = corners.iter().filter(|c| c[0] > 0.0).map(|c| c[1]).collect();
    angles.iter().sum::<f64>() / angles.len() as f64
}

#[test]
fn cones_and_saddles_unfold_around_their_tip() {
    for (k, total) in [1.3, 3.0, 4.0, TAU - 0.3, TAU, TAU + 1e-3, 7.5, 3.0 * PI, 11.0].into_iter().enumerate() {
        for seed in 0..4 {
            // Narrow enough for displaced vertices.
            let sectors = 11.max((2.0 * total).ceil() as usize);
            let (flat, polars) = cone(total, [sectors, 5], Cut::Irregular, seed);
            let polar_of = |p: &SurfacePoint| {
                let at = flat.place(p);
                (at.length(), at.y.atan2(at.x) + middle_angle(&polars[p.face.index()]))
            };
            let p = flat.random_point(seed + 10 * k as u64, 2 + seed);
            let (r, a) = polar_of(&p);
            flat.check(&format!("cone of {total}, {seed}"), &[Source::point(p)], |q| {
                let (s, b) = polar_of(q);
                let turn = (b - a).rem_euclid(total);
                let turn = turn.min(total - turn);
                let straight = (r - s).hypot(2.0 * (r * s).sqrt() * (0.5 * turn).sin());
                vec![if turn >= PI { r + s } else { straight }]
            });
        }
    }
}

#[test]
fn saddles_of_folded_fans_have_the_distances_of_brute_force() {
    let mut folded = 0;
    for (total, seed) in [7.5, 9.0, 11.0, 13.0].into_iter().flat_map(|total| (0..8).map(move |seed| (total, seed))) {
        let (flat, _) = cone_or_folded(total, [11, 5], Cut::Irregular, seed);
        folded += usize::from(flat.corners.iter().any(|t| twice_area(t) <= 0.0));
        let (oracle, surface) =
            (Oracle::new(&flat.mesh, &flat.length), IntrinsicSurface::new(&flat.mesh, &flat.length).unwrap());
        let v = VertexId::new((dice(seed, 1) * flat.mesh.vertex_count() as f64) as usize);
        let truth = oracle.distances(&[(v, 0.0)]);
        let largest = truth.iter().copied().fold(0.0, f64::max);
        for (u, &d) in vertex_distances(&surface, &[Source::vertex(v)]).unwrap().iter() {
            let exact = truth[u.index()];
            assert!((d - exact).abs() <= ROUNDING * largest, "fan of {total}, {seed}, {v} to {u}: {d} and {exact}");
        }
    }
    assert!(folded > 4, "only {folded} are folded");
}

/// Told of each unfolded face: the face, its corners, and the two rays between which it is seen.
type Meet<'a> = dyn FnMut(usize, &[DVec2], Option<[DVec2; 2]>) + 'a;

/// A face of a polyhedron, cut into triangles: corner positions of triangles inside a polygon given by its corners.
struct Solid {
    /// Corners of each face, counter-clockwise, as vertices of the solid.
    faces: Vec<Vec<usize>>,
    /// The same in a plane of the face's own.
    outlines: Vec<Vec<DVec2>>,
}

impl Solid {
    fn regular(faces: Vec<Vec<usize>>) -> Self {
        let outline = |face: &Vec<usize>| {
            let n = face.len();
            let radius = 0.5 / (PI / n as f64).sin();
            (0..n).map(|k| radius * DVec2::from_angle(TAU * k as f64 / n as f64)).collect()
        };
        let outlines = faces.iter().map(outline).collect();
        Self { faces, outlines }
    }

    /// Shortest distance between two points: straight lines over all sequences of faces without repetition, each within
    /// the sides that it crosses.
    fn distance(&self, (f, p): (usize, DVec2), (g, q): (usize, DVec2)) -> f64 {
        let mut visited = vec![false; self.faces.len()];
        let places = self.outlines[f].clone();
        let mut best = f64::INFINITY;
        self.follow(f, &places, p, None, &mut visited, &mut |face, places: &[DVec2], cone| {
            if face == g {
                let image = transfer(&self.outlines[g], places, q);
                let is_seen = cone.is_none_or(|[r, l]: [DVec2; 2]| {
                    (r - p).perp_dot(image - p) >= -1e-13 && (image - p).perp_dot(l - p) >= -1e-13
                });
                if is_seen {
                    best = best.min(p.distance(image));
                }
            }
        });
        best
    }

    fn follow(
        &self,
        face: usize,
        places: &[DVec2],
        p: DVec2,
        cone: Option<[DVec2; 2]>,
        visited: &mut [bool],
        meet: &mut Meet,
    ) {
        meet(face, places, cone);
        visited[face] = true;
        let n = places.len();
        for k in 0..n {
            let (a, b) = (self.faces[face][k], self.faces[face][(k + 1) % n]);
            let behind = (0..self.faces.len()).find(|&g| side_of(&self.faces[g], b, a).is_some()).unwrap();
            if visited[behind] {
                continue;
            }
            // Seen from inside the face, the side runs from right to left.
            let (mut right, mut left) = (places[k], places[(k + 1) % n]);
            if let Some([r, l]) = cone {
                if (r - p).perp_dot(right - p) < 0.0 {
                    right = r;
                }
                if (l - p).perp_dot(left - p) > 0.0 {
                    left = l;
                }
                if (right - p).perp_dot(left - p) <= 0.0 {
                    continue;
                }
            }
            let j = side_of(&self.faces[behind], b, a).unwrap();
            let outline = &self.outlines[behind];
            let (from, to) = (outline[j], outline[(j + 1) % outline.len()]);
            let (image_from, image_to) = (places[(k + 1) % n], places[k]);
            let rotation = (image_to - image_from) / (to - from).length();
            let unit = (to - from).normalize();
            let image = |x: DVec2| {
                let d = x - from;
                let (along, across) = (d.dot(unit), unit.perp_dot(d));
                image_from + along * rotation + across * rotation.perp()
            };
            let images: Vec<DVec2> = outline.iter().map(|&x| image(x)).collect();
            self.follow(behind, &images, p, Some([right, left]), visited, meet);
        }
        visited[face] = false;
    }

    /// Each face cut into a fan of `n`-fold triangles, displaced inside.
    fn cut(&self, n: usize, cut: Cut, seed: u64) -> (Unfolded, Vec<usize>) {
        let (mut faces, mut corners, mut owner) = (Vec::new(), Vec::new(), Vec::new());
        // Vertices are named by the solid's vertices and their weights, in n-ths.
        let mut names = BTreeMap::new();
        for (f, face) in self.faces.iter().enumerate() {
            for k in 1..face.len() - 1 {
                let around = [0, k, k + 1];
                let place = |i: usize, j: usize| {
                    let weights = [n - i - j, i, j];
                    let mut name: Vec<(usize, usize)> =
                        around.iter().zip(weights).filter(|x| x.1 > 0).map(|(&c, w)| (face[c], w)).collect();
                    name.sort_unstable();
                    // Only the face's own inside is displaced, diagonals are not.
                    if name.len() == 3 {
                        name.push((usize::MAX, f));
                    }
                    let amount = if name.len() == 4 { 0.8 / n as f64 } else { 0.0 };
                    let index = (f * 1000 + k * 100 + i * 10 + j) as u64;
                    let [x, y] = [0, 1].map(|k| amount * cut.offset(seed, 2 * index + k));
                    let at: DVec2 =
                        around.iter().zip(weights).map(|(&c, w)| self.outlines[f][c] * (w as f64 / n as f64)).sum();
                    (name, at + DVec2::new(x, y))
                };
                for (i, j) in (0..n * n).map(|k| (k % n, k / n)).filter(|(i, j)| i + j < n) {
                    let up = [(i, j), (i + 1, j), (i, j + 1)];
                    let down = [(i + 1, j), (i + 1, j + 1), (i, j + 1)];
                    for t in [Some(up), (i + j + 2 <= n).then_some(down)].into_iter().flatten() {
                        let t = t.map(|(i, j)| place(i, j));
                        corners.push([t[0].1, t[1].1, t[2].1]);
                        faces.push(t.map(|(name, _)| {
                            let next = names.len() as u32;
                            *names.entry(name).or_insert(next)
                        }));
                        owner.push(f);
                    }
                }
            }
        }
        (Unfolded::new(names.len(), &faces, corners).upright(), owner)
    }
}

/// The side of a face that runs from one vertex to another.
fn side_of(face: &[usize], from: usize, to: usize) -> Option<usize> {
    (0..face.len()).find(|&k| face[k] == from && face[(k + 1) % face.len()] == to)
}

/// A point of an outline in a moved copy of it.
fn transfer(outline: &[DVec2], places: &[DVec2], q: DVec2) -> DVec2 {
    let (u, w) = (outline[1] - outline[0], places[1] - places[0]);
    let d = q - outline[0];
    let (along, across) = (d.dot(u) / u.length_squared(), u.perp_dot(d) / u.length_squared());
    places[0] + along * w + across * w.perp()
}

#[test]
fn a_cube_has_the_distances_of_its_unfoldings() {
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let cube = Solid::regular(faces.map(|f| f.to_vec()).to_vec());
    for seed in 0..6 {
        let (flat, owner) = cube.cut(4, Cut::Irregular, seed);
        assert_eq!(flat.mesh.vertex_count() + flat.mesh.face_count() - flat.mesh.edge_count(), 2);
        let p = flat.random_point(seed, 2 + seed);
        let of = |p: &SurfacePoint| (owner[p.face.index()], flat.place(p));
        flat.check(&format!("cube {seed}"), &[Source::point(p)], |q| vec![cube.distance(of(&p), of(q))]);
    }
}

#[test]
fn a_regular_tetrahedron_rolls_on_its_lattice() {
    let solid = Solid::regular([[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]].map(|f| f.to_vec()).to_vec());
    // Rolled out: face 0 1 2 in the middle, 3 across each of its sides. Half turns around lattice points are its symmetry.
    let height = 0.75f64.sqrt();
    let (a, b, c) = (DVec2::ZERO, DVec2::X, DVec2::new(0.5, height));
    let places = [
        [a, b, c],
        [a, DVec2::new(0.5, -height), b],
        [b, DVec2::new(1.5, height), c],
        [c, DVec2::new(-0.5, height), a],
    ];
    for seed in 0..6 {
        let (flat, owner) = solid.cut(5, Cut::Irregular, seed);
        assert_eq!(flat.mesh.vertex_count() + flat.mesh.face_count() - flat.mesh.edge_count(), 2);
        let rolled = |p: &SurfacePoint| {
            let f = owner[p.face.index()];
            transfer(&solid.outlines[f], &places[f], flat.place(p))
        };
        let p = flat.random_point(seed, 2 + seed);
        let at = rolled(&p);
        flat.check(&format!("tetrahedron {seed}"), &[Source::point(p)], |q| {
            let q = rolled(q);
            let shifts = (0..121).map(|k| 2.0 * (b * f64::from(k % 11 - 5) + c * f64::from(k / 11 - 5)));
            let images = shifts.flat_map(|t| [at.distance(q + t), at.distance(t - q)]);
            vec![images.fold(f64::INFINITY, f64::min)]
        });
        // The other way to know: unfolding along sequences of faces.
        let of = |p: &SurfacePoint| (owner[p.face.index()], flat.place(p));
        flat.check(&format!("tetrahedron {seed}, unfolded"), &[Source::point(p)], |q| {
            vec![solid.distance(of(&p), of(q))]
        });
    }
}

/// The figure and irregular, regular, and shattered cuts of it.
fn cuts(figure: impl Fn(Cut) -> Unfolded) -> Vec<(&'static str, Unfolded)> {
    let shattered = |cut, rounds| figure(cut).shattered(rounds, rounds).0;
    vec![
        ("irregular", figure(Cut::Irregular)),
        ("regular", figure(Cut::Regular)),
        ("split", shattered(Cut::Irregular, 1)),
        ("split thrice", shattered(Cut::Regular, 3)),
        ("shattered", shattered(Cut::Irregular, 5)),
    ]
}

#[test]
fn planes_have_the_distances_of_any_cut_of_them() {
    for (what, flat) in cuts(|cut| plane(6, cut, 3, |_, _| true)) {
        flat.check_images(&format!("plane, {what}"), 12, std::iter::once);
    }
    // Many faces in a row: a hundred cells on each side.
    for cut in [Cut::Irregular, Cut::Regular] {
        plane(100, cut, 8, |_, _| true).check_images("large plane", 4, std::iter::once);
    }
}

#[test]
fn cylinders_and_tori_have_the_distances_of_any_cut_of_them() {
    for (what, flat) in cuts(|cut| wrapped([7, 6], false, cut, 5, |x, y| DVec2::new(x, 1.3 * y))) {
        let shift = DVec2::new(7.0, 0.0);
        flat.check_images(&format!("cylinder, {what}"), 12, |at| (-2..=2).map(move |k| at + shift * f64::from(k)));
    }
    // Skewed, square, and of equilateral triangles.
    for (u, v) in [
        (DVec2::X, DVec2::new(-0.4, 0.8)),
        (DVec2::X, DVec2::Y),
        (DVec2::X, DVec2::new(0.5, 0.75f64.sqrt())),
        (3.0 * DVec2::X, DVec2::new(0.2, 0.5)),
    ] {
        for (what, flat) in cuts(|cut| wrapped([6, 6], true, cut, 5, |x, y| (u * x + v * y) / 6.0)) {
            flat.check_images(&format!("torus {u} {v}, {what}"), 8, |at| {
                (0..169).map(move |k| at + u * f64::from(k % 13 - 6) + v * f64::from(k / 13 - 6))
            });
        }
    }
}

/// Images of a place under half turns about the points of a lattice.
fn half_turns(at: DVec2, u: DVec2, v: DVec2) -> impl Iterator<Item = DVec2> {
    let shifts = (0..81).map(move |k| 2.0 * (u * f64::from(k % 9 - 4) + v * f64::from(k / 9 - 4)));
    shifts.flat_map(move |t| [t + at, t - at])
}

#[test]
fn a_pillow_has_the_distances_of_half_turns() {
    // Two unit squares glued along all sides: the back of (x, y) is (2 - x, y).
    let pillow = |cut: Cut| {
        let (top, bottom) = (plane(5, cut, 1, |_, _| true), plane(5, cut, 2, |_, _| true));
        // A quarter turn, so that no two diagonals join the same vertices.
        let turned = bottom.corners.iter().map(|t| t.map(|at| DVec2::new(1.0 - at.y, at.x)));
        let layers = [(0, top.corners.clone()), (1, turned.collect())];
        let (mut faces, mut corners) = (Vec::new(), Vec::new());
        let mut names = BTreeMap::new();
        for (layer, [a, b, c]) in layers.into_iter().flat_map(|(layer, all)| all.into_iter().map(move |t| (layer, t))) {
            let t = if layer == 0 { [a, b, c] } else { [b, a, c] };
            faces.push(t.map(|at| {
                let is_outer = at.min_element() < 1e-9 || at.max_element() > 1.0 - 1e-9;
                let [x, y] = [at.x, at.y].map(|x| (1e9 * x).round() as i64);
                let next = names.len() as u32;
                *names.entry((x, y, if is_outer { 0 } else { layer })).or_insert(next)
            }));
            corners.push(t.map(|at| if layer == 0 { at } else { DVec2::new(2.0 - at.x, at.y) }));
        }
        Unfolded::new(names.len(), &faces, corners)
    };
    for (what, flat) in cuts(pillow) {
        assert_eq!(flat.mesh.vertex_count() + flat.mesh.face_count() - flat.mesh.edge_count(), 2);
        flat.check_images(&format!("pillow, {what}"), 12, |at| half_turns(at, DVec2::X, DVec2::Y));
    }
}

/// Numbers vertices anew, in the order of their first faces.
fn compact(faces: Vec<[u32; 3]>, corners: Vec<[DVec2; 3]>) -> Unfolded {
    let mut number = BTreeMap::new();
    let mut numbered = |v: u32| {
        let next = number.len() as u32;
        *number.entry(v).or_insert(next)
    };
    let faces: Vec<[u32; 3]> = faces.into_iter().map(|t| t.map(&mut numbered)).collect();
    let count = 1 + faces.iter().flatten().copied().max().unwrap_or(0);
    Unfolded::new(count as usize, &faces, corners)
}

#[test]
fn two_discs_glued_have_the_distances_of_one_reflection() {
    // Regular polygons with `m` sides, one on the other, seen from below as from above.
    for (m, rings, cut) in
        [(7, 4, Cut::Irregular), (24, 6, Cut::Irregular), (24, 6, Cut::Regular), (6, 3, Cut::Regular)]
    {
        let (top, polars) = fan(TAU, [m, rings], cut, 1);
        let (bottom, polars_below) = fan(TAU, [m, rings], cut, 2);
        let inner = (1 + (rings - 1) * m) as u32;
        let place = |[r, a]: [f64; 2]| r * DVec2::from_angle(a);
        let (mut faces, mut corners) = (top.clone(), Vec::new());
        corners.extend(polars.iter().map(|t| t.map(place)));
        for (face, polar) in bottom.iter().zip(&polars_below) {
            let [a, b, c] = face.map(|v| if v < inner { v + 10_000 } else { v });
            faces.push([b, a, c]);
            corners.push([1, 0, 2].map(|k| place(polar[k])));
        }
        let upper = top.len();
        let outline: Vec<DVec2> = (0..=m).map(|k| place([rings as f64, k as f64 * TAU / m as f64])).collect();
        let whole = compact(faces, corners);
        for (rounds, seed) in [(0, 0), (0, 1), (0, 2), (2, 3), (4, 4)] {
            let (flat, part_of) = whole.shattered(seed, rounds);
            let is_above = |p: &SurfacePoint| part_of[p.face.index()] < upper;
            let sources: Vec<SurfacePoint> = match seed {
                // The middle: all of the rim is as far.
                0 => vec![flat.at_vertex(VertexId(0))],
                k => (0..3).map(|j| flat.random_point(seed, 10 * j + k)).collect(),
            };
            let named = |k: usize| Source::point(sources[k]).with_label(k as u32).with_start(0.3 * k as f64);
            let named: Vec<Source> = (0..sources.len()).map(named).collect();
            flat.check(&format!("discs of {m}, {seed}"), &named, |q| {
                let over = |(k, p): (usize, &SurfacePoint)| {
                    let (a, b) = (flat.place(p), flat.place(q));
                    let rim = outline.windows(2).map(|side| over_side(a, b, [side[0], side[1]]));
                    let on_rim = [p, q].map(|p| to_outline(flat.place(p), &outline) < 1e-12);
                    let same = is_above(p) == is_above(q) || on_rim[0] || on_rim[1];
                    0.3 * k as f64 + if same { a.distance(b) } else { rim.fold(f64::INFINITY, f64::min) }
                };
                sources.iter().enumerate().map(over).collect()
            });
        }
    }
}

fn to_outline(p: DVec2, outline: &[DVec2]) -> f64 {
    outline.windows(2).map(|side| to_segment(p, [side[0], side[1]])).fold(f64::INFINITY, f64::min)
}

/// The shortest way from one place to another that touches a side, which has both on its left.
fn over_side(p: DVec2, q: DVec2, [a, b]: [DVec2; 2]) -> f64 {
    let u = (b - a).normalize();
    let [(px, py), (qx, qy)] = [p, q].map(|p| ((p - a).dot(u), u.perp_dot(p - a).max(0.0)));
    let x = if py + qy > 0.0 { px + (qx - px) * py / (py + qy) } else { px };
    let x = x.clamp(0.0, a.distance(b));
    (px - x).hypot(py) + (qx - x).hypot(qy)
}

#[test]
fn tetrahedra_and_octahedra_have_the_distances_of_any_cut_of_them() {
    // 1. The tetrahedron, rolled out.
    let solid = Solid::regular([[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]].map(|f| f.to_vec()).to_vec());
    let height = 0.75f64.sqrt();
    let (a, b, c) = (DVec2::ZERO, DVec2::X, DVec2::new(0.5, height));
    let below = DVec2::new(0.5, -height);
    let places = [[a, b, c], [a, below, b], [b, DVec2::new(1.5, height), c], [c, DVec2::new(-0.5, height), a]];
    let rolled = |cut: Cut| {
        let (flat, owner) = solid.cut(4, cut, 1);
        flat.with_corners(|f, at| transfer(&solid.outlines[owner[f]], &places[owner[f]], at))
    };
    for (what, flat) in cuts(rolled) {
        flat.check_images(&format!("tetrahedron, {what}"), 12, |at| half_turns(at, b, c));
    }
    // 2. Cube and octahedron, unfolded face by face; from vertices, middles of sides, and points.
    let cube = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let octahedron = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    let solids = [cube.map(|f| f.to_vec()).to_vec(), octahedron.map(|f| f.to_vec()).to_vec()].map(Solid::regular);
    for (which, solid) in solids.iter().enumerate() {
        for (cut, rounds) in [(Cut::Regular, 0), (Cut::Irregular, 1), (Cut::Regular, 3)] {
            let (flat, owner) = solid.cut(4, cut, 1);
            let (flat, part_of) = flat.shattered(rounds, rounds);
            let of = |p: &SurfacePoint| (owner[part_of[p.face.index()]], flat.place(p));
            let middle = flat.mesh.edges().nth(7).unwrap();
            let h = flat.mesh.half_edge(middle);
            let mut weights = [0.5; 3];
            weights[((h.0 + 2) % 3) as usize] = 0.0;
            let on_side = SurfacePoint { face: flat.mesh.face(h), weights };
            let points = [flat.at_vertex(VertexId(0)), on_side, flat.at_vertex(VertexId(9)), flat.random_point(5, 3)];
            for (k, p) in points.iter().enumerate() {
                flat.check(&format!("solid {which}, {rounds}, {k}"), &[Source::point(*p)], |q| {
                    // A vertex of the solid belongs to several faces.
                    let all = solid.same_places(of(p)).into_iter().map(|p| solid.distance(p, of(q)));
                    vec![all.fold(f64::INFINITY, f64::min)]
                });
            }
        }
    }
}

impl Solid {
    /// A place as all the faces tell it to which it belongs, if it is a vertex.
    fn same_places(&self, (f, p): (usize, DVec2)) -> Vec<(usize, DVec2)> {
        let Some(k) = self.outlines[f].iter().position(|c| c.distance(p) < 1e-12) else { return vec![(f, p)] };
        let of_face = |g: usize| self.faces[g].iter().position(|&v| v == self.faces[f][k]).map(|j| (g, j));
        (0..self.faces.len()).filter_map(of_face).map(|(g, j)| (g, self.outlines[g][j])).collect()
    }
}

/// Distance on a cone from a place, in polar coordinates, to a segment whose ends are less than half a turn apart.
fn to_segment_on_cone(total: f64, [s, b]: [f64; 2], [p, q]: [[f64; 2]; 2]) -> f64 {
    let place = |[r, a]: [f64; 2]| r * DVec2::from_angle(a - p[1]);
    let [from, to] = [place(p), place(q)];
    let foot = |at: DVec2| {
        let (d, t) = (to - from, (at - from).dot(to - from) / (to - from).length_squared().max(1e-300));
        from + d * t.clamp(0.0, 1.0)
    };
    // 1. Over the tip.
    let mut best = s + foot(DVec2::ZERO).length();
    // 2. Straight, where a place of the segment is less than half a turn away.
    for turn in -2..=2 {
        let b = b + f64::from(turn) * total - p[1];
        for x in [foot(s * DVec2::from_angle(b)), from, to] {
            let apart = (x.to_angle() - b).abs();
            if x.length() > 0.0 && apart < PI {
                best = best.min((x.length() - s).hypot(2.0 * (x.length() * s).sqrt() * (0.5 * apart).sin()));
            }
        }
    }
    best
}

#[test]
fn cones_have_the_distances_of_any_cut_of_them() {
    for total in [0.7, 2.0, PI, 5.0, TAU - 1e-6, TAU, TAU + 1e-9, TAU + 1e-5, 7.0, 9.5, 15.0] {
        for (cut, rounds) in [(Cut::Regular, 0), (Cut::Irregular, 1), (Cut::Regular, 3), (Cut::Irregular, 4)] {
            let (flat, polars) = cone(total, [13, 4], cut, 3);
            let (flat, part_of) = flat.shattered(rounds, rounds);
            let polar_of = |face: FaceId, at: DVec2| {
                let middle = middle_angle(&polars[part_of[face.index()]]);
                [at.length(), if at.length() > 0.0 { at.to_angle() + middle } else { middle }]
            };
            for seed in 0..8 {
                // The tip, a point, or mixed.
                let (mut sources, _) = flat.mixed_sources(seed);
                if seed % 3 == 0 {
                    sources.push(Source::vertex(VertexId(0)).with_start(0.4).with_label(4));
                }
                let pieces: Vec<(u32, f64, [[f64; 2]; 2])> = sources
                    .iter()
                    .map(|source| {
                        let face = match source.shape {
                            SourceShape::Segment(p, _) | SourceShape::Point(p) => p.face,
                            SourceShape::Vertex(v) => flat.at_vertex(v).face,
                        };
                        (source.label, source.start, flat.place_of(source).map(|at| polar_of(face, at)))
                    })
                    .collect();
                flat.check(&format!("cone of {total}, {rounds}, {seed}"), &sources, |q| {
                    let q = polar_of(q.face, flat.place(q));
                    let mut all = vec![f64::INFINITY; 5];
                    for &(label, start, piece) in &pieces {
                        let d = start + to_segment_on_cone(total, q, piece);
                        all[label as usize] = all[label as usize].min(d);
                    }
                    all
                });
            }
        }
    }
}
