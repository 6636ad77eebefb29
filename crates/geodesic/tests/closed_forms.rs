//! Exact distances against closed forms, to 1e-10 of the largest.
//!
//! In: surfaces that unfold to the plane, told by connectivity and edge lengths alone: a plane with convex outline, one
//! with obstacles, cylinder, cones of less and more than a full turn, cube, regular tetrahedron, flat torus.
//! Out: distances of all vertices and of random points as the unfolded figure has them.

mod common;

use common::dice;
use quadloom_geodesic::{CurveTracer, IntrinsicSurface, Options, Source, Wavefront};
use quadloom_mesh::{DVec2, EdgeMap, FaceId, Progress, SurfacePoint, TriConnectivity, VertexId};
use std::f64::consts::{PI, TAU};

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
        for (k, (p, all)) in places.iter().zip(&truths).enumerate() {
            let (found, exact) = (field.at(p).unwrap(), nearest(all));
            let error = (found.distance - exact) / largest;
            assert!(error.abs() <= 1e-10, "{what}: place {k} has {} instead of {exact}: {error:.2e}", found.distance);
            let label = found.label.unwrap() as usize;
            assert!(all[label] <= exact + 1e-9 * largest, "{what}: place {k} is not nearest to source {label}");
            if k < self.mesh.vertex_count() {
                let of_vertex = field.vertex_distance(VertexId::new(k));
                assert!((of_vertex - exact).abs() <= 1e-10 * largest, "{what}: vertex {k}: {of_vertex} and {exact}");
            }
            if k % 7 == 0 {
                let path = field.path_from(p).unwrap().unwrap();
                let start = sources.iter().find(|s| s.label == path.label).unwrap().start;
                assert!((path.length + start - exact).abs() <= 1e-10 * largest, "{what}: path {k} has {}", path.length);
            }
        }
    }
}

/// A square grid of `n` by `n` cells with displaced vertices and diagonals at random; `inside` tells which cells exist.
fn plane(n: usize, seed: u64, inside: impl Fn(usize, usize) -> bool) -> Unfolded {
    let exists = |i: usize, j: usize| i < n && j < n && inside(i, j);
    // Vertices on the outline and on obstacles stay.
    let is_free = |i: usize, j: usize| {
        i > 0 && j > 0 && exists(i - 1, j - 1) && exists(i, j - 1) && exists(i - 1, j) && exists(i, j)
    };
    let at = |i: usize, j: usize| {
        let index = (j * (n + 1) + i) as u64;
        let amount = if is_free(i, j) { 0.5 } else { 0.0 };
        let [dx, dy] = [0, 1].map(|k| amount * (dice(seed, 2 * index + k) - 0.5));
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
        let turn = usize::from(dice(seed + 1, (j * n + i) as u64) < 0.5);
        for [a, b, c] in [[0, 1, 2], [0, 2, 3]].map(|t| t.map(|k| (k + turn) % 4)) {
            faces.push([ids[a], ids[b], ids[c]]);
            corners.push([a, b, c].map(|k| at(cell[k].0, cell[k].1)));
        }
    }
    Unfolded::new(vertices as usize, &faces, corners)
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
        let flat = plane(9, seed, |_, _| true);
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
            let flat = plane(n, 40 + seed, |i, j| !is_hole(i, j));
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
fn wrapped(m: usize, n: usize, closed: bool, seed: u64, at: impl Fn(f64, f64) -> DVec2) -> Unfolded {
    let rows = if closed { n } else { n + 1 };
    let id = |i: usize, j: usize| ((j % rows) * m + i % m) as u32;
    let place = |i: usize, j: usize| {
        let free = closed || (j > 0 && j < n);
        let [dx, dy] = [0, 1].map(|k| if free { 0.5 * (dice(seed, 2 * u64::from(id(i, j)) + k) - 0.5) } else { 0.0 });
        at(i as f64 + dx, j as f64 + dy)
    };
    let (mut faces, mut corners) = (Vec::new(), Vec::new());
    for (i, j) in (0..m * n).map(|k| (k % m, k / m)) {
        let cell = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
        let turn = usize::from(dice(seed + 1, (j * m + i) as u64) < 0.5);
        for t in [[0, 1, 2], [0, 2, 3]].map(|t| t.map(|k| cell[(k + turn) % 4])) {
            faces.push(t.map(|(i, j)| id(i, j)));
            corners.push(t.map(|(i, j)| place(i, j)));
        }
    }
    Unfolded::new(rows * m, &faces, corners)
}

#[test]
fn a_cylinder_unfolds_to_a_strip() {
    for seed in 0..8 {
        let (m, n) = (7 + seed as usize, 6);
        let flat = wrapped(m, n, false, seed, |x, y| DVec2::new(x, 1.7 * y));
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
        let flat = wrapped(8, 7, true, seed, |x, y| u * x / 8.0 + v * y / 7.0);
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
fn cone(total: f64, seed: u64) -> (Unfolded, Vec<[[f64; 2]; 3]>) {
    let (m, rings) = (11usize, 5usize);
    let id = |i: usize, j: usize| if j == 0 { 0 } else { (1 + (j - 1) * m + i % m) as u32 };
    let polar = |i: usize, j: usize| {
        let free = j > 0 && j < rings;
        let [dr, da] = [0, 1].map(|k| if free { 0.5 * (dice(seed, 2 * u64::from(id(i, j)) + k) - 0.5) } else { 0.0 });
        [j as f64 + dr, (i as f64 + da) * total / m as f64]
    };
    let mut cells = Vec::new();
    for i in 0..m {
        cells.push([(i, 0), (i, 1), (i + 1, 1)]);
        for j in 1..rings {
            let cell = [(i, j), (i, j + 1), (i + 1, j + 1), (i + 1, j)];
            let turn = usize::from(dice(seed + 1, (j * m + i) as u64) < 0.5);
            cells.extend([[0, 1, 2], [0, 2, 3]].map(|t| t.map(|k| cell[(k + turn) % 4])));
        }
    }
    let faces: Vec<[u32; 3]> = cells.iter().map(|t| t.map(|(i, j)| id(i, j))).collect();
    let polars: Vec<[[f64; 2]; 3]> = cells.iter().map(|t| t.map(|(i, j)| polar(i, j))).collect();
    // Each face in a plane of its own, with the tip at the origin and its middle direction along x.
    let corners = polars.iter().map(|corners| {
        let middle = middle_angle(corners);
        corners.map(|[r, a]| r * DVec2::from_angle(a - middle))
    });
    (Unfolded::new(1 + rings * m, &faces, corners.collect()), polars)
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
            let (flat, polars) = cone(total, seed);
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
    fn cut(&self, n: usize, seed: u64) -> (Unfolded, Vec<usize>) {
        let (mut faces, mut corners, mut owner) = (Vec::new(), Vec::new(), Vec::new());
        // Vertices are named by the solid's vertices and their weights, in n-ths.
        let mut names = std::collections::BTreeMap::new();
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
                    let amount = if name.len() == 4 { 0.4 / n as f64 } else { 0.0 };
                    let index = (f * 1000 + k * 100 + i * 10 + j) as u64;
                    let [x, y] = [0, 1].map(|k| amount * (dice(seed, 2 * index + k) - 0.5));
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
        (Unfolded::new(names.len(), &faces, corners), owner)
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
        let (flat, owner) = cube.cut(4, seed);
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
        let (flat, owner) = solid.cut(5, seed);
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
