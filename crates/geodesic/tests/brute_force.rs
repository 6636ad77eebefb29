//! Distances against an independent brute force on small surfaces.
//!
//! In: a thousand random surfaces: noisy spheres and tori, with holes, with needles, with random intrinsic lengths.
//! Out: agreement to 1e-9, symmetry, the Lipschitz property, paths as long as their distances.

mod common;

use common::{Oracle, dice, with_holes};
use quadloom_geodesic::{IntrinsicSurface, Keep, Options, Source, Wavefront, vertex_distances};
use quadloom_mesh::metric::edge_lengths;
use quadloom_mesh::shapes::{displace, sphere, torus, with_noise};
use quadloom_mesh::{DVec2, DVec3, EdgeMap, FaceId, Progress, SurfacePoint, TriConnectivity, TriMesh, VertexId};

/// Surfaces in all.
const SURFACES: u64 = 1000;

/// A random small surface; connected or not, with boundary or not.
fn surface(seed: u64) -> TriMesh {
    let noise = [0.02, 0.15, 0.3][(seed % 3) as usize];
    let base = match seed % 4 {
        0 => sphere(1.0, 1),
        1 => torus(1.0, 0.45, 6, 4),
        2 => sphere(1.0, 0),
        _ => torus(1.0, 0.3, 5, 3),
    };
    let mut mesh = with_noise(&base, noise, seed);
    if seed % 5 == 3 {
        // Needles.
        let squeezed = mesh.positions().map(|p| *p * DVec3::new(1.0, 1.0, 0.01));
        mesh = mesh.with_positions(squeezed).unwrap();
    }
    if seed % 5 == 4 {
        mesh = displace(&mesh, |p| 0.3 * (5.0 * p.x).sin() * (4.0 * p.y).cos());
    }
    if seed % 2 == 1
        && let Some(open) = with_holes(&mesh, |f| dice(seed, 1000 + u64::from(f)) > 0.12)
    {
        mesh = open;
    }
    mesh
}

/// Lengths of the surface, or near to them at random, with all triangle inequalities.
fn lengths(mesh: &TriMesh, seed: u64) -> EdgeMap<f64> {
    let mut length = edge_lengths(mesh);
    if seed % 7 == 6 {
        // Between 1 and 1.9 every triple is a triangle.
        length = EdgeMap::from_fn(mesh.edge_count(), |e| 1.0 + 0.9 * dice(seed, 50 + u64::from(e.0)));
    }
    length
}

fn corner(mesh: &TriConnectivity, v: VertexId) -> SurfacePoint {
    let h = mesh.outgoing_half_edge(v);
    let mut weights = [0.0; 3];
    weights[(h.0 % 3) as usize] = 1.0;
    SurfacePoint { face: mesh.face(h), weights }
}

fn random_point(mesh: &TriConnectivity, seed: u64, index: u64) -> SurfacePoint {
    let face = FaceId::new((dice(seed, index) * mesh.face_count() as f64) as usize % mesh.face_count());
    let (mut a, mut b) = (dice(seed, index + 1), dice(seed, index + 2));
    if a + b > 1.0 {
        (a, b) = (1.0 - a, 1.0 - b);
    }
    if index % 4 == 1 {
        // On a side.
        b = 0.0;
    }
    SurfacePoint { face, weights: [1.0 - a - b, a, b] }
}

fn place(oracle: &Oracle, p: &SurfacePoint) -> DVec2 {
    let corners = oracle.layout(oracle.mesh.face_half_edges(p.face));
    corners[0] * p.weights[0] + corners[1] * p.weights[1] + corners[2] * p.weights[2]
}

fn largest(distances: &[f64]) -> f64 {
    distances.iter().copied().filter(|d| d.is_finite()).fold(0.0, f64::max)
}

fn assert_equal(seed: u64, what: &str, ours: &[f64], theirs: &[f64]) {
    let scale = largest(theirs).max(1e-300);
    for (v, (a, b)) in ours.iter().zip(theirs).enumerate() {
        assert!(
            (a.is_infinite() && b.is_infinite()) || (a - b).abs() <= 1e-9 * scale,
            "surface {seed}, {what}, vertex {v}: {a} and {b}, difference {:.2e}",
            (a - b) / scale
        );
    }
}

#[test]
fn vertices_as_sources() {
    for seed in 0..SURFACES {
        let mesh = surface(seed);
        let length = lengths(&mesh, seed);
        let (oracle, exact) = (Oracle::new(&mesh, &length), IntrinsicSurface::new(&mesh, &length).unwrap());
        let v = VertexId::new((dice(seed, 3) * mesh.vertex_count() as f64) as usize);
        let ours = vertex_distances(&exact, &[Source::vertex(v)]).unwrap();
        assert_equal(seed, "vertex", ours.values(), &oracle.distances(&[(v, 0.0)]));
    }
}

#[test]
fn points_segments_and_start_values_as_sources() {
    for seed in 0..SURFACES {
        let mesh = surface(seed);
        let length = lengths(&mesh, seed);
        let (oracle, exact) = (Oracle::new(&mesh, &length), IntrinsicSurface::new(&mesh, &length).unwrap());
        let (mut sources, mut seeds) = (Vec::new(), Vec::new());
        for k in 0..1 + seed % 3 {
            let start = if k > 0 { 0.8 * dice(seed, 30 + k) } else { 0.0 };
            let p = random_point(&mesh, seed, 100 + 7 * k);
            let sides = mesh.face_half_edges(p.face);
            let mut add = |found: Vec<(VertexId, f64)>| seeds.extend(found.into_iter().map(|(v, d)| (v, d + start)));
            let as_seen = |p: &SurfacePoint| {
                let mut found = oracle.seen_from_face(sides, place(&oracle, p), oracle.bound);
                // A point of a side is seen from the face behind it, too.
                if let Some(i) = p.weights.iter().position(|&w| w == 0.0)
                    && let Some(t) = mesh.twin(sides[(i + 1) % 3])
                {
                    let back = mesh.face(t);
                    let mut weights = [0.0; 3];
                    for (u, w) in mesh.face_vertices(p.face).into_iter().zip(p.weights).filter(|x| x.1 > 0.0) {
                        weights[mesh.face_vertices(back).into_iter().position(|x| x == u).unwrap()] = w;
                    }
                    let p = SurfacePoint { face: back, weights };
                    found.extend(oracle.seen_from_face(mesh.face_half_edges(back), place(&oracle, &p), oracle.bound));
                }
                found
            };
            add(as_seen(&p));
            if (seed + k) % 2 == 0 {
                let q = SurfacePoint { face: p.face, ..random_point(&mesh, seed, 300 + 4 * k) };
                add(as_seen(&q));
                add(oracle.seen_from_segment(sides, place(&oracle, &p), place(&oracle, &q), oracle.bound));
                sources.push(Source::segment(p, q).with_start(start).with_label(k as u32));
            } else {
                sources.push(Source::point(p).with_start(start).with_label(k as u32));
            }
        }
        let theirs = oracle.distances(&seeds);
        let mut wave = Wavefront::new(&exact);
        wave.spread(&sources, &Options::default(), &Progress::none()).unwrap();
        let ours = wave.field().vertex_distances();
        assert_equal(seed, "mixed", ours.values(), &theirs);
        // The order of the sources changes nothing but rounding; vertices alone neither.
        sources.reverse();
        wave.spread(&sources, &Options { keep: Keep::Vertices, ..Options::default() }, &Progress::none()).unwrap();
        for (v, &d) in wave.field().vertex_distances().iter() {
            assert!(
                d == ours[v] || (d - ours[v]).abs() <= 1e-13 * largest(ours.values()),
                "{seed} {v} {d} {}",
                ours[v]
            );
        }
    }
}

#[test]
fn distances_are_symmetric_and_paths_as_long_as_they_are() {
    for seed in 0..SURFACES {
        let mesh = surface(seed);
        let length = lengths(&mesh, seed);
        let exact = IntrinsicSurface::new(&mesh, &length).unwrap();
        let mut wave = Wavefront::new(&exact);
        let (p, q) = (random_point(&mesh, seed, 401), random_point(&mesh, seed, 410));
        wave.spread(&[Source::point(p)], &Options::default(), &Progress::none()).unwrap();
        let there = wave.field().at(&q).unwrap().distance;
        let scale = largest(wave.field().vertex_distances().values());
        // 1. The path.
        let path = wave.field().path_from(&q).unwrap();
        assert_eq!(path.is_some(), there.is_finite());
        if let Some(path) = path {
            assert!((path.length - there).abs() <= 1e-9 * scale, "{seed}: path {} distance {there}", path.length);
            for step in path.points.windows(2) {
                let before = wave.field().at(&step[0]).unwrap().distance;
                let after = wave.field().at(&step[1]).unwrap().distance;
                assert!(after <= before + 1e-9 * scale, "{seed}: a path goes down");
            }
        }
        // 2. Lipschitz along edges; vertices and points agree.
        let field = wave.field();
        for e in mesh.edges() {
            let [a, b] = mesh.ends(e).map(|v| field.vertex_distance(v));
            assert!(a.is_infinite() || (a - b).abs() <= length[e] + 1e-12 * scale, "{seed}: edge {e}");
        }
        for v in mesh.vertices() {
            let (a, b) = (field.vertex_distance(v), field.at(&corner(&mesh, v)).unwrap().distance);
            assert!(a == b || (a - b).abs() <= 1e-9 * scale, "{seed}: vertex {v}: {a} and {b}");
        }
        // 3. The way back.
        wave.spread(&[Source::point(q)], &Options::default(), &Progress::none()).unwrap();
        let back = wave.field().at(&p).unwrap().distance;
        assert!(there == back || (there - back).abs() <= 1e-9 * scale, "{seed}: {there} there, {back} back");
    }
}

#[test]
fn approximations_are_never_above_and_within_their_promise() {
    for seed in 0..200 {
        let mesh = surface(seed);
        let length = lengths(&mesh, seed);
        let exact = IntrinsicSurface::new(&mesh, &length).unwrap();
        let source = [Source::vertex(VertexId(0))];
        let truth = vertex_distances(&exact, &source).unwrap();
        let mut wave = Wavefront::new(&exact);
        for epsilon in [1e-4, 1e-2, 0.1, 0.5] {
            wave.spread(&source, &Options { epsilon, ..Options::default() }, &Progress::none()).unwrap();
            for (v, &d) in wave.field().vertex_distances().iter() {
                let t = truth[v];
                assert!(
                    d == t || (d <= t * (1.0 + 1e-9) && d >= t * (1.0 - epsilon) - 1e-12),
                    "{seed} {epsilon} {v}: {d} for {t}"
                );
            }
        }
    }
}
