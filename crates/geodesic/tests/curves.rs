//! Curves as sources: as many points as one likes come as near to them as expected, and nothing nearer.

mod common;

use common::dice;
use quadloom_geodesic::{
    CurveTracer, GeodesicError, IntrinsicSurface, Keep, Options, Source, SourceShape, Wavefront, boundary_sources,
    edge_sources,
};
use quadloom_mesh::metric::{dihedral_angle, edge_lengths};
use quadloom_mesh::shapes::{bracket, cylinder, displace, join, sphere, torus};
use quadloom_mesh::{DVec3, EdgeId, FaceId, Progress, SurfacePoint, TriMesh, VertexId, VertexMap};

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

fn bumpy_sphere() -> TriMesh {
    displace(&sphere(1.0, 3), |p| 0.15 * (5.0 * p.x).sin() * (4.0 * p.y + 3.0 * p.z).cos())
}

/// A bumpy torus, a bumpy sphere and a part, each with a curve: closed and self-crossing, open, sharp edges.
fn surfaces_with_curves() -> Vec<(TriMesh, Vec<Source>)> {
    let joined = |mesh: TriMesh, seed: u64, is_closed: bool| {
        let lengths = edge_lengths(&mesh);
        let surface = IntrinsicSurface::new(&mesh, &lengths).unwrap();
        let mut points = random_points(&mesh, seed, 5);
        points.extend(is_closed.then_some(points[0]));
        let curve = CurveTracer::new(&surface).join(&points, 0, &Progress::none()).unwrap();
        (mesh, curve)
    };
    let part = bracket(0.3);
    let sharp = part.edges().filter(|&e| dihedral_angle(&part, part.half_edge(e)).to_degrees() > 35.0);
    let of_part = edge_sources(&part, sharp, 0);
    vec![joined(bumpy_torus(), 8, true), joined(bumpy_sphere(), 9, false), (part, of_part)]
}

fn ends(source: &Source) -> [SurfacePoint; 2] {
    match source.shape {
        SourceShape::Segment(p, q) => [p, q],
        _ => unreachable!("curves of distinct points have segments alone"),
    }
}

fn between(p: &SurfacePoint, q: &SurfacePoint, t: f64) -> SurfacePoint {
    SurfacePoint { face: p.face, weights: [0, 1, 2].map(|i| (1.0 - t) * p.weights[i] + t * q.weights[i]) }
}

/// Points on each piece, no farther apart than `spacing`, with both of its ends; `times` as many.
fn spaced_points(mesh: &TriMesh, curve: &[Source], spacing: f64, times: u32) -> Vec<Source> {
    let on = |source: &Source| {
        let [p, q] = ends(source);
        let count = times * (p.position(mesh).distance(q.position(mesh)) / spacing).ceil().max(1.0) as u32;
        let label = source.label;
        (0..=count)
            .map(move |k| Source::point(between(&p, &q, f64::from(k) / f64::from(count))).with_label(label))
            .collect::<Vec<_>>()
    };
    curve.iter().flat_map(on).collect()
}

fn corner(mesh: &TriMesh, v: VertexId) -> SurfacePoint {
    let h = mesh.outgoing_half_edge(v);
    let mut weights = [0.0; 3];
    weights[(h.0 % 3) as usize] = 1.0;
    SurfacePoint { face: mesh.face(h), weights }
}

#[test]
fn points_miss_a_curve_by_the_square_of_their_spacing() {
    for (which, (mesh, curve)) in surfaces_with_curves().into_iter().enumerate() {
        let lengths = edge_lengths(&mesh);
        let surface = IntrinsicSurface::new(&mesh, &lengths).unwrap();
        let mut wave = Wavefront::new(&surface);
        let exact = distances(&mut wave, &curve);
        let largest = exact.values().iter().copied().fold(0.0, f64::max);
        // 1. The last leg of each shortest path lies in one face with the piece on which it ends: its length, the length
        //    of the piece, and where on it (0..1) the foot is.
        let pieces: Vec<[DVec3; 2]> = curve.iter().map(|piece| ends(piece).map(|p| p.position(&mesh))).collect();
        let leg = |v: VertexId| {
            let path = wave.field().path_from(&corner(&mesh, v)).unwrap().unwrap();
            let [.., p, q] = path.points[..] else { return [0.0; 3] };
            let foot = q.position(&mesh);
            let detour = |[a, b]: &[DVec3; 2]| foot.distance(*a) + foot.distance(*b) - a.distance(*b);
            let piece = pieces.iter().min_by(|s, t| detour(s).total_cmp(&detour(t))).unwrap();
            assert!(detour(piece) < 1e-9 * largest, "{which}: the path of {v} ends on the curve");
            let length = piece[0].distance(piece[1]);
            [p.position(&mesh).distance(foot), length, foot.distance(piece[0]) / length]
        };
        let legs = VertexMap::from_fn(mesh.vertex_count(), leg);
        // 2. Points half as far apart, thrice. Where the last leg begins, the point next to its foot is seen as well:
        //    Pythagoras bounds the error. A quarter of the mean is left on the whole, but not of each step: many paths
        //    have few feet in common, and these fall beside points or between them.
        let mut means = Vec::new();
        for times in [2, 4, 8, 16] {
            let spacing = 0.04 * largest;
            let near = distances(&mut wave, &spaced_points(&mesh, &curve, spacing, times));
            let (mut sum, mut count) = (0.0, 0);
            for (v, &d) in exact.iter() {
                let [leg, piece, foot] = legs[v];
                let gaps = f64::from(times) * (piece / spacing).ceil().max(1.0);
                let beside = (foot * gaps - (foot * gaps).round()) * piece / gaps;
                let error = near[v] - d;
                let most = leg.hypot(beside) - leg + 1e-10 * largest;
                assert!(error >= -1e-12 * largest && error <= most, "{which}, {v}: {error:.3e} of {most:.3e}, {times}");
                if d > 0.2 * largest {
                    sum += error;
                    count += 1;
                }
            }
            means.push(sum / f64::from(count));
        }
        assert!((32.0..128.0).contains(&(means[0] / means[3])), "{which}: {means:?}");
        assert!(means.is_sorted_by(|a, b| a > b), "{which}: {means:?}");
    }
}

#[test]
fn the_distance_of_a_curve_is_the_least_of_its_points() {
    for (which, (mesh, curve)) in surfaces_with_curves().into_iter().enumerate() {
        let lengths = edge_lengths(&mesh);
        let surface = IntrinsicSurface::new(&mesh, &lengths).unwrap();
        let (mut wave, mut back) = (Wavefront::new(&surface), Wavefront::new(&surface));
        let exact = distances(&mut wave, &curve);
        let largest = exact.values().iter().copied().fold(0.0, f64::max);
        let spacing = 0.005 * largest;
        let points = spaced_points(&mesh, &curve, spacing, 1);
        for p in random_points(&mesh, 50 + which as u64, 20) {
            let there = wave.field().at(&p).unwrap().distance;
            back.spread(&[Source::point(p)], &Options::default(), &Progress::none()).unwrap();
            let of_points = points.iter().map(|s| match s.shape {
                SourceShape::Point(q) => back.field().at(&q).unwrap().distance,
                _ => unreachable!("points alone"),
            });
            let least = of_points.fold(f64::INFINITY, f64::min);
            assert!(there <= least + 1e-11 * largest, "{which}: {there} to the curve, {least} to a point of it");
            assert!(least <= there + 0.5 * spacing, "{which}: {there} to the curve, {least} to its points");
        }
    }
}

#[test]
fn curves_have_distance_zero_wherever_they_pass() {
    for (which, (mesh, curve)) in surfaces_with_curves().into_iter().enumerate() {
        let lengths = edge_lengths(&mesh);
        let surface = IntrinsicSurface::new(&mesh, &lengths).unwrap();
        let mut wave = Wavefront::new(&surface);
        let exact = distances(&mut wave, &curve);
        let largest = exact.values().iter().copied().fold(0.0, f64::max);
        for (k, source) in curve.iter().enumerate() {
            let [p, q] = ends(source);
            for t in [0.0, 1e-9, 0.3, dice(7, k as u64), 1.0] {
                let nearest = wave.field().at(&between(&p, &q, t)).unwrap();
                assert!(nearest.distance.abs() <= 1e-12 * largest, "{which}, piece {k} at {t}: {nearest:?}");
                assert_eq!(nearest.label, Some(0));
            }
        }
    }
}

#[test]
fn cutting_turning_repeating_and_shuffling_pieces_changes_nothing() {
    for (which, (mesh, curve)) in surfaces_with_curves().into_iter().enumerate() {
        let lengths = edge_lengths(&mesh);
        let surface = IntrinsicSurface::new(&mesh, &lengths).unwrap();
        let mut wave = Wavefront::new(&surface);
        let exact = distances(&mut wave, &curve);
        let largest = exact.values().iter().copied().fold(0.0, f64::max);
        let part = |source: &Source, from: f64, to: f64| {
            let [p, q] = ends(source);
            Source::segment(between(&p, &q, from), between(&p, &q, to))
        };
        let mut shuffled: Vec<Source> = curve.iter().map(|s| part(s, 1.0, 0.0)).collect();
        (1..shuffled.len()).for_each(|k| shuffled.swap(k, (dice(which as u64, k as u64) * (k + 1) as f64) as usize));
        let cut = |cuts: &[f64]| -> Vec<Source> {
            curve.iter().flat_map(|s| cuts.windows(2).map(|w| part(s, w[0], w[1])).collect::<Vec<_>>()).collect()
        };
        let variants = [
            ("turned and shuffled", shuffled.clone(), 1e-13),
            ("twice", [&curve[..], &shuffled[..]].concat(), 1e-13),
            ("with what covers parts of it", [&curve[..], &cut(&[0.2, 0.7, 0.9])[..]].concat(), 1e-12),
            ("cut", cut(&[0.0, 0.3, 0.31, 0.8, 1.0]), 1e-12),
            ("cut into bits", cut(&[0.0, 1e-7, 0.5, 0.5 + 1e-9, 1.0 - 1e-6, 1.0]), 1e-12),
        ];
        for (what, sources, tolerance) in variants {
            for (v, &d) in distances(&mut wave, &sources).iter() {
                let error = (d - exact[v]) / largest;
                assert!(error.abs() <= tolerance, "{which}, {what}, {v}: {error:.2e}");
            }
        }
        // Twice with another label: the first one named, or the second, but never a third.
        let second: Vec<Source> = curve.iter().map(|s| s.clone().with_label(1)).collect();
        distances(&mut wave, &[&curve[..], &second[..]].concat());
        assert!(wave.field().vertex_labels().values().iter().all(|l| matches!(l, Some(0 | 1))));
    }
}

#[test]
fn pieces_of_one_curve_keep_their_own_labels() {
    for (which, (mesh, curve)) in surfaces_with_curves().into_iter().enumerate() {
        let lengths = edge_lengths(&mesh);
        let surface = IntrinsicSurface::new(&mesh, &lengths).unwrap();
        let mut wave = Wavefront::new(&surface);
        let groups = 6;
        let label = |k: usize| (k * groups / curve.len()) as u32;
        let labelled: Vec<Source> = curve.iter().enumerate().map(|(k, s)| s.clone().with_label(label(k))).collect();
        let exact = distances(&mut wave, &labelled);
        let named = wave.field().vertex_labels();
        let largest = exact.values().iter().copied().fold(0.0, f64::max);
        // Each group alone is nowhere nearer, and as near where it is named.
        let mut count = 0;
        for group in 0..groups as u32 {
            let alone: Vec<Source> = labelled.iter().filter(|s| s.label == group).cloned().collect();
            for (v, &d) in distances(&mut wave, &alone).iter() {
                assert!(d >= exact[v] - 1e-12 * largest, "{which}: {v} is nearer to {group} alone");
                if named[v] == Some(group) {
                    count += 1;
                    assert!(d <= exact[v] + 1e-12 * largest, "{which}: {v} is not nearest to {group}");
                }
            }
        }
        assert_eq!(count, mesh.vertex_count());
    }
}

#[test]
fn an_edge_is_the_same_told_in_either_face_or_through_its_vertices() {
    let mesh = bumpy_torus();
    let lengths = edge_lengths(&mesh);
    let surface = IntrinsicSurface::new(&mesh, &lengths).unwrap();
    let mut wave = Wavefront::new(&surface);
    // 1. A closed walk around the torus, and a branch.
    let edges: Vec<EdgeId> = mesh.edges().filter(|e| e.0 % 97 == 5 || e.0 % 101 == 7).collect();
    let told = edge_sources(&mesh, edges.iter().copied(), 2);
    assert!(told.len() == edges.len() && told.iter().all(|s| s.label == 2 && s.start == 0.0));
    let exact = distances(&mut wave, &told);
    let largest = exact.values().iter().copied().fold(0.0, f64::max);
    // 2. In the other face.
    let in_twin = |&e: &EdgeId| {
        let h = mesh.twin(mesh.half_edge(e)).unwrap();
        let at = |k: u32| {
            let mut weights = [0.0; 3];
            weights[((h.0 + k - 3 * mesh.face(h).0) % 3) as usize] = 1.0;
            SurfacePoint { face: mesh.face(h), weights }
        };
        Source::segment(at(0), at(1)).with_label(2)
    };
    let turned: Vec<Source> = edges.iter().map(in_twin).collect();
    // 3. Through the tracer: neighbours are joined along their edge.
    let mut tracer = CurveTracer::new(&surface);
    let traced = |&e: &EdgeId| tracer.join(&mesh.ends(e).map(|v| corner(&mesh, v)), 2, &Progress::none()).unwrap();
    let traced: Vec<Source> = edges.iter().flat_map(traced).collect();
    for (what, sources) in [("other faces", turned), ("traced", traced)] {
        for (v, &d) in distances(&mut wave, &sources).iter() {
            assert!((d - exact[v]).abs() <= 1e-13 * largest, "{what}: {v} {d} {}", exact[v]);
        }
    }
    for &e in &edges {
        assert!(mesh.ends(e).iter().all(|&v| exact[v] == 0.0));
    }
    // 4. A surface without boundary has no boundary.
    assert!(boundary_sources(&mesh, 0).is_empty());
}

#[test]
fn curves_keep_the_promise_of_epsilon_and_of_keep() {
    for (which, (mesh, curve)) in surfaces_with_curves().into_iter().enumerate() {
        let lengths = edge_lengths(&mesh);
        let surface = IntrinsicSurface::new(&mesh, &lengths).unwrap();
        let mut wave = Wavefront::new(&surface);
        let exact = distances(&mut wave, &curve);
        let largest = exact.values().iter().copied().fold(0.0, f64::max);
        for epsilon in [0.0, 1e-3, 0.05] {
            for keep in [Keep::Windows, Keep::Vertices] {
                wave.spread(&curve, &Options { epsilon, keep, ..Options::default() }, &Progress::none()).unwrap();
                for (v, &d) in wave.field().vertex_distances().iter() {
                    let (most, least) = (exact[v] + 1e-12 * largest, (1.0 - epsilon) * exact[v] - 1e-12 * largest);
                    assert!((least..=most).contains(&d), "{which}, {epsilon}, {keep:?}, {v}: {d} for {}", exact[v]);
                }
            }
        }
    }
}
