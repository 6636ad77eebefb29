//! Curves as sources: as many points as one likes come as near to them as expected, and nothing nearer.

mod common;

use common::dice;
use quadloom_geodesic::{
    CurveTracer, GeodesicError, IntrinsicSurface, Options, Source, SourceShape, Wavefront, boundary_sources,
    edge_sources,
};
use quadloom_mesh::metric::{dihedral_angle, edge_lengths};
use quadloom_mesh::shapes::{bracket, cylinder, displace, join, sphere, torus};
use quadloom_mesh::{FaceId, Progress, SurfacePoint, TriMesh, VertexId, VertexMap};

fn bumpy_torus() -> TriMesh {
    displace(&torus(1.0, 0.4, 40, 20), |p| 0.06 * (7.0 * p.x).sin() * (5.0 * p.y + 3.0 * p.z).cos())
}

fn random_points(mesh: &TriMesh, seed: u64, count: u64) -> Vec<SurfacePoint> {
    let point = |k: u64| {
        let face = FaceId::new((dice(seed, 3 * k) * mesh.face_count() as f64) as usize % mesh.face_count());
        let (a, b) = (0.5 * dice(seed, 3 * k + 1), 0.5 * dice(seed, 3 * k + 2));
        SurfacePoint { face, weights: [1.0 - a - b, a, b] }
    };
    (0..count).map(point).collect()
}

fn distances(wave: &mut Wavefront, sources: &[Source]) -> VertexMap<f64> {
    wave.spread(sources, &Options::default(), &Progress::none()).unwrap();
    wave.field().vertex_distances()
}

/// `count + 1` points on each segment.
fn dense(sources: &[Source], count: u32) -> Vec<Source> {
    let on = |source: &Source| match source.shape {
        SourceShape::Segment(p, q) => (0..=count)
            .map(|k| {
                let t = f64::from(k) / f64::from(count);
                let weights = [0, 1, 2].map(|i| (1.0 - t) * p.weights[i] + t * q.weights[i]);
                Source::point(SurfacePoint { face: p.face, weights }).with_label(source.label).with_start(source.start)
            })
            .collect(),
        _ => vec![source.clone()],
    };
    sources.iter().flat_map(on).collect()
}

fn longest_segment(mesh: &TriMesh, sources: &[Source]) -> f64 {
    let length = |source: &Source| match source.shape {
        SourceShape::Segment(p, q) => p.position(mesh).distance(q.position(mesh)),
        _ => 0.0,
    };
    sources.iter().map(length).fold(0.0, f64::max)
}

#[test]
fn a_curve_is_the_limit_of_dense_points() {
    let torus = bumpy_torus();
    let part = bracket(0.25);
    let sharp = part.edges().filter(|&e| dihedral_angle(&part, part.half_edge(e)).to_degrees() > 35.0);
    let of_part = edge_sources(&part, sharp, 0);
    for (mesh, given) in [(&torus, None), (&part, Some(of_part))] {
        let lengths = edge_lengths(mesh);
        let surface = IntrinsicSurface::new(mesh, &lengths).unwrap();
        let curve = given.unwrap_or_else(|| {
            CurveTracer::new(&surface).join(&random_points(mesh, 4, 6), 0, &Progress::none()).unwrap()
        });
        assert!(curve.len() > 20);
        let mut wave = Wavefront::new(&surface);
        let exact = distances(&mut wave, &curve);
        let far = 0.1 * exact.values().iter().copied().fold(0.0, f64::max);
        let mut before = f64::INFINITY;
        // Four times as many points: a sixteenth of the error, give or take where they fall.
        for count in [1, 4, 16] {
            let near = distances(&mut wave, &dense(&curve, count));
            let spacing = longest_segment(mesh, &curve) / f64::from(count);
            let mut worst = 0.0f64;
            for (v, &d) in exact.iter() {
                let error = near[v] - d;
                assert!(error >= -1e-12, "points are on the curve, {error:.2e} nearer than it");
                // No place of a piece is farther than half of it from its ends.
                let most = 0.5 * spacing;
                assert!(error <= most + 1e-12, "{count} points: {error:.3e} is more than {most:.3e} at {d}");
                if d >= far {
                    worst = worst.max(error);
                }
            }
            assert!(worst <= before / 6.0 || worst < 1e-13, "{count} points: {worst:.3e} after {before:.3e}");
            before = worst;
        }
    }
}

#[test]
fn the_distance_is_zero_on_a_curve_and_nowhere_else() {
    let mesh = bumpy_torus();
    let lengths = edge_lengths(&mesh);
    let surface = IntrinsicSurface::new(&mesh, &lengths).unwrap();
    let mut tracer = CurveTracer::new(&surface);
    for seed in 0..10 {
        // Seven points in random order: the curve crosses itself; and it closes.
        let mut points = random_points(&mesh, seed, 7);
        points.push(points[0]);
        let curve = tracer.join(&points, 3, &Progress::none()).unwrap();
        let mut wave = Wavefront::new(&surface);
        let exact = distances(&mut wave, &curve);
        let largest = exact.values().iter().copied().fold(0.0, f64::max);
        for piece in dense(&curve, 5) {
            let SourceShape::Point(p) = piece.shape else { continue };
            let nearest = wave.field().at(&p).unwrap();
            assert!(nearest.distance.abs() <= 1e-12 * largest && nearest.label == Some(3), "{nearest:?}");
        }
        // Shortest paths bend at saddles, so that the curve passes some vertices.
        assert!(exact.values().iter().filter(|&&d| d < 1e-9).count() < mesh.vertex_count() / 4);
        // The pieces follow each other without a gap, and their order does not matter.
        let ends: Vec<[SurfacePoint; 2]> = curve
            .iter()
            .map(|s| match s.shape {
                SourceShape::Segment(p, q) => [p, q],
                _ => unreachable!("a curve of distinct points has segments alone"),
            })
            .collect();
        for pair in ends.windows(2) {
            assert!(pair[0][1].position(&mesh).distance(pair[1][0].position(&mesh)) < 1e-12);
        }
        let mut reversed = curve.clone();
        reversed.reverse();
        for (v, &d) in distances(&mut wave, &reversed).iter() {
            assert!((d - exact[v]).abs() <= 1e-13 * largest);
        }
    }
}

#[test]
fn several_curves_keep_their_labels() {
    let mesh = cylinder(1.0, 4.0, 40, 20);
    let lengths = edge_lengths(&mesh);
    let surface = IntrinsicSurface::new(&mesh, &lengths).unwrap();
    // 1. Both rims; each vertex belongs to the nearer one.
    let all = boundary_sources(&mesh, 0);
    let z = |s: &Source| match s.shape {
        SourceShape::Segment(p, _) => p.position(&mesh).z,
        _ => unreachable!("boundaries are segments"),
    };
    let middle =
        0.5 * (all.iter().map(z).fold(f64::INFINITY, f64::min) + all.iter().map(z).fold(f64::NEG_INFINITY, f64::max));
    let labelled: Vec<Source> = all.iter().map(|s| s.clone().with_label(u32::from(z(s) > middle))).collect();
    let mut wave = Wavefront::new(&surface);
    let exact = distances(&mut wave, &labelled);
    for (v, label) in wave.field().vertex_labels().iter() {
        let above = mesh.position(v).z - middle;
        assert!(above.abs() < 1e-9 || *label == Some(u32::from(above > 0.0)), "{v}: {label:?} {above}");
        assert!((exact[v] - (2.0 - above.abs())).abs() < 1e-12, "{v}: {} {above}", exact[v]);
    }
    // 2. The one that starts late is nearest later.
    let late: Vec<Source> =
        labelled.iter().map(|s| if s.label == 1 { s.clone().with_start(1.0) } else { s.clone() }).collect();
    for (v, &d) in distances(&mut wave, &late).iter() {
        let above = mesh.position(v).z - middle;
        assert!((d - (2.0 + above).min(3.0 - above)).abs() < 1e-12);
    }
}

#[test]
fn curves_join_points_by_shortest_paths() {
    for (seed, mesh) in
        [(1, bumpy_torus()), (2, bracket(0.25)), (3, displace(&sphere(1.0, 4), |p| 0.2 * (6.0 * p.x).sin()))]
    {
        let lengths = edge_lengths(&mesh);
        let surface = IntrinsicSurface::new(&mesh, &lengths).unwrap();
        let (mut tracer, mut wave) = (CurveTracer::new(&surface), Wavefront::new(&surface));
        let points = random_points(&mesh, seed, 24);
        for pair in points.windows(2) {
            wave.spread(&[Source::point(pair[0])], &Options::default(), &Progress::none()).unwrap();
            let exact = wave.field().at(&pair[1]).unwrap().distance;
            let joined = tracer.join(pair, 0, &Progress::none()).unwrap();
            let length = |s: &Source| match s.shape {
                SourceShape::Segment(p, q) => p.position(&mesh).distance(q.position(&mesh)),
                _ => 0.0,
            };
            let found: f64 = joined.iter().map(length).sum();
            assert!((found - exact).abs() <= 1e-10 * exact, "{seed}: {found} instead of {exact}");
        }
    }
}

#[test]
fn curves_that_cannot_be_joined_are_named() {
    let two = join(&[sphere(1.0, 1), sphere(0.5, 1)]);
    let lengths = edge_lengths(&two);
    let surface = IntrinsicSurface::new(&two, &lengths).unwrap();
    let mut tracer = CurveTracer::new(&surface);
    let in_face = |face: usize| SurfacePoint { face: FaceId::new(face), weights: [0.2, 0.3, 0.5] };
    let (first, last) = (in_face(0), in_face(two.face_count() - 1));
    let result = tracer.join(&[first, in_face(5), last], 4, &Progress::none());
    let expected = GeodesicError::CurveLeavesComponent { label: 4, point: 1, from: FaceId(5), to: last.face };
    assert_eq!(result, Err(expected.clone()));
    assert!(expected.to_string().contains("points 1 and 2") && expected.to_string().contains("source 4"));
    assert_eq!(tracer.join(&[], 0, &Progress::none()), Err(GeodesicError::NoSource));
    let one = tracer.join(&[first, first], 2, &Progress::none()).unwrap();
    assert_eq!(one, [Source::point(first).with_label(2)]);
    // A tracer can go on after an error.
    let curve = tracer.join(&[first, in_face(40)], 0, &Progress::none()).unwrap();
    assert!(curve.len() > 1 && curve.iter().all(|s| matches!(s.shape, SourceShape::Segment(..))));
    assert_eq!(two.neighbours(VertexId(0)).count(), 5);
}
