//! Needles, zero lengths, symmetry, odd scales, several components, broken input: no gap, no endless loop, no wrong word.

mod common;

use common::{dice, with_holes};
use quadloom_geodesic::{
    Field, GeodesicError, IntrinsicSurface, Keep, Options, RefineOptions, Source, Wavefront, isolines, spaced,
    vertex_distances,
};
use quadloom_mesh::metric::edge_lengths;
use quadloom_mesh::repair::{RepairOptions, repair};
use quadloom_mesh::shapes::{bracket, cube, displace, join, plate_with_holes, sphere, torus, with_noise};
use quadloom_mesh::{DVec3, EdgeMap, FaceId, Progress, SurfacePoint, TriConnectivity, TriMesh, VertexId, VertexMap};
use std::collections::BinaryHeap;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Largest jump between windows, relative to the largest distance.
const JUMP: f64 = 1e-9;
/// The same on needles, where rays on both sides of a vertex may part by 1e-8.
const JUMP_ON_NEEDLES: f64 = 2e-8;

/// The windows of every edge follow each other, without hole and without jump.
fn assert_whole(what: &str, mesh: &TriConnectivity, lengths: &EdgeMap<f64>, field: &Field, jump_rel: f64) {
    let largest = field.vertex_distances().values().iter().copied().filter(|d| d.is_finite()).fold(0.0, f64::max);
    for e in mesh.edges() {
        let windows: Vec<_> = field.windows(e).collect();
        let ends = mesh.ends(e).map(|v| field.vertex_distance(v));
        if windows.is_empty() {
            // Not reached, or nothing crosses it since a shortest path runs along it.
            let along = (ends[0] - ends[1]).abs() - lengths[e];
            assert!(ends[0].is_infinite() || along.abs() <= 1e-12 * largest, "{what}: edge {e} is empty");
            continue;
        }
        let (first, last) = (windows[0], windows[windows.len() - 1]);
        assert!(first.interval[0] <= 1e-6 && last.interval[1] >= 1.0 - 1e-6, "{what}: edge {e} ends early");
        for pair in windows.windows(2) {
            let (gap, jump) = (pair[1].interval[0] - pair[0].interval[1], pair[1].distances[0] - pair[0].distances[1]);
            assert!(gap.abs() <= 1e-6, "{what}: edge {e} has a hole of {gap:.2e}");
            let allowed = gap.abs() * lengths[e] + jump_rel * largest;
            assert!(jump.abs() <= allowed, "{what}: edge {e} has a jump of {:.2e}", jump / largest);
        }
    }
}

/// Spreads from some vertices and looks at every edge.
fn check_mesh(what: &str, mesh: &TriConnectivity, lengths: &EdgeMap<f64>, jump_rel: f64) {
    let surface = IntrinsicSurface::new(mesh, lengths).unwrap();
    let mut wave = Wavefront::new(&surface);
    for (k, epsilon) in [0.0, 0.0, 1e-3].into_iter().enumerate() {
        let v = VertexId::new(k * 7919 % mesh.vertex_count());
        let options = Options { epsilon, ..Options::default() };
        wave.spread(&[Source::vertex(v)], &options, &Progress::none()).unwrap();
        if epsilon == 0.0 {
            assert_whole(what, mesh, lengths, &wave.field(), jump_rel);
        }
        // Never above Dijkstra's distances along edges, which are finite exactly where a path leads.
        let (along, field) = (dijkstra(mesh, lengths, v), wave.field());
        for (u, &most) in along.iter().enumerate() {
            let d = field.vertex_distance(VertexId::new(u));
            assert!(d.is_infinite() == most.is_infinite(), "{what}: vertex {u}: {d} and {most}");
            assert!(!d.is_finite() || d <= most * (1.0 + 1e-12), "{what}: vertex {u}: {d} above {most}");
        }
    }
}

fn dijkstra(mesh: &TriConnectivity, lengths: &EdgeMap<f64>, from: VertexId) -> Vec<f64> {
    let mut distance = vec![f64::INFINITY; mesh.vertex_count()];
    distance[from.index()] = 0.0;
    let mut queue = BinaryHeap::from([(std::cmp::Reverse(0u64), from.0)]);
    while let Some((std::cmp::Reverse(bits), v)) = queue.pop() {
        let d = f64::from_bits(bits);
        if d > distance[v as usize] {
            continue;
        }
        for e in mesh.vertex_edges(VertexId(v)) {
            let [a, b] = mesh.ends(e);
            let u = if a.0 == v { b } else { a };
            if d + lengths[e] < distance[u.index()] {
                distance[u.index()] = d + lengths[e];
                queue.push((std::cmp::Reverse((d + lengths[e]).to_bits()), u.0));
            }
        }
    }
    distance
}

fn squeezed(mesh: &TriMesh, by: DVec3) -> TriMesh {
    mesh.with_positions(mesh.positions().map(|p| *p * by)).unwrap()
}

#[test]
fn no_gap_on_odd_surfaces() {
    let flat_grid = plate_with_holes(0.05);
    let pancake = squeezed(&sphere(1.0, 3), DVec3::new(1.0, 1.0, 1e-5));
    let cases = [
        ("needles", squeezed(&with_noise(&sphere(1.0, 3), 0.2, 1), DVec3::new(1.0, 1.0, 1e-6))),
        ("needles along an axis", squeezed(&torus(1.0, 0.4, 24, 12), DVec3::new(1e3, 1.0, 1.0))),
        ("a symmetric sphere", sphere(1.0, 3)),
        ("a symmetric torus", torus(1.0, 0.5, 32, 16)),
        ("a cube, flat but for its edges", cube(1.0, 8)),
        ("a plane with holes", squeezed(&flat_grid, DVec3::new(1.0, 1.0, 1.0))),
        ("a pancake", pancake),
        ("a part", bracket(0.3)),
        ("waves", displace(&torus(1.0, 0.45, 30, 20), |p| 0.2 * (9.0 * p.x).sin() * (8.0 * p.y).cos())),
        ("two components", join(&[sphere(1.0, 2), torus(3.0, 0.5, 12, 8)])),
    ];
    for (what, mesh) in cases {
        let has_needles = what.contains("needles") || what == "a pancake";
        check_mesh(what, &mesh, &edge_lengths(&mesh), if has_needles { JUMP_ON_NEEDLES } else { JUMP });
    }
}

#[test]
fn lengths_that_hardly_tell_heights_do_no_harm() {
    // Heights of a hundred-thousandth of the sides: their squares are at the end of the digits.
    let mesh = squeezed(&torus(1.0, 0.4, 24, 12), DVec3::new(1e5, 1.0, 1.0));
    let lengths = edge_lengths(&mesh);
    let surface = IntrinsicSurface::new(&mesh, &lengths).unwrap();
    for v in [0, 60, 133].map(VertexId) {
        let there = vertex_distances(&surface, &[Source::vertex(v)]).unwrap();
        let along = dijkstra(&mesh, &lengths, v);
        for u in mesh.vertices().step_by(29) {
            let back = vertex_distances(&surface, &[Source::vertex(u)]).unwrap()[v];
            assert!((there[u] - back).abs() <= 1e-6 * there[u], "{v} to {u}: {} and {back}", there[u]);
            assert!(there[u] <= along[u.index()] * (1.0 + 1e-12));
            // No shorter than straight through the air.
            assert!(there[u] >= mesh.position(v).distance(mesh.position(u)) * (1.0 - 1e-9));
        }
    }
}

/// The same mesh with the ends of some edges in one place, and for each vertex the first one that is there.
fn with_contracted(mesh: &TriMesh, is_contracted: impl Fn(u32) -> bool) -> (TriMesh, Vec<u32>) {
    let mut first: Vec<u32> = (0..mesh.vertex_count() as u32).collect();
    for e in mesh.edges().filter(|e| is_contracted(e.0)) {
        let [a, b] = mesh.ends(e).map(|v| first[v.index()]);
        first.iter_mut().filter(|v| **v == a.max(b)).for_each(|v| *v = a.min(b));
    }
    let positions = VertexMap::from_fn(mesh.vertex_count(), |v| mesh.position(VertexId(first[v.index()])));
    (mesh.with_positions(positions).unwrap(), first)
}

/// The same surface without its faces that have an edge of no length, if it is one, and its vertex for each old one.
fn without_flat_faces(mesh: &TriMesh, first: &[u32]) -> Option<(TriMesh, Vec<VertexId>)> {
    let firsts: Vec<u32> = (0..first.len() as u32).filter(|&v| first[v as usize] == v).collect();
    let number = |v: u32| firsts.binary_search(&first[v as usize]).unwrap() as u32;
    let faces = mesh.to_faces().into_iter().map(|f| f.map(number)).filter(|[a, b, c]| a != b && b != c && c != a);
    let positions = firsts.iter().map(|&v| mesh.position(VertexId(v))).collect();
    let contracted = TriMesh::new(positions, &faces.collect::<Vec<_>>()).ok()?;
    Some((contracted, (0..first.len() as u32).map(|v| VertexId(number(v))).collect()))
}

/// A noisy sphere with some edges contracted, as [`with_contracted`] has it.
fn contracted_sphere(seed: u64) -> (TriMesh, Vec<u32>) {
    let share = 0.01 * (1 + seed % 5) as f64;
    with_contracted(&with_noise(&sphere(1.0, 2), 0.1, seed), |e| dice(seed, u64::from(e)) < share)
}

/// Once, a window told the end of a side without length the straight distance to it, even if it did not see it.
#[test]
fn edges_without_length_change_no_distance() {
    let mut compared = 0;
    for seed in 0..60 {
        let (mesh, first) = contracted_sphere(seed);
        let Some((contracted, number)) = without_flat_faces(&mesh, &first) else { continue };
        compared += usize::from(contracted.vertex_count() < mesh.vertex_count());
        let (lengths, lengths_there) = (edge_lengths(&mesh), edge_lengths(&contracted));
        let here = IntrinsicSurface::new(&mesh, &lengths).unwrap();
        let there = IntrinsicSurface::new(&contracted, &lengths_there).unwrap();
        for v in mesh.vertices().step_by(23) {
            let distances = vertex_distances(&here, &[Source::vertex(v)]).unwrap();
            let expected = vertex_distances(&there, &[Source::vertex(number[v.index()])]).unwrap();
            for (u, &d) in distances.iter() {
                let exact = expected[number[u.index()]];
                assert!((d - exact).abs() <= 1e-13, "{seed}: {v} to {u}: {d}, {exact} without edges of no length");
            }
        }
    }
    assert!(compared > 40, "only {compared} of them are surfaces without those edges");
}

#[test]
fn edges_without_length_are_crossed() {
    let mut without_length = 0;
    for seed in 0..60 {
        let (mesh, _) = contracted_sphere(seed);
        let lengths = edge_lengths(&mesh);
        without_length += lengths.values().iter().filter(|&&l| l == 0.0).count();
        check_mesh(&format!("zero lengths {seed}"), &mesh, &lengths, JUMP_ON_NEEDLES);
    }
    assert!(without_length > 500, "only {without_length} edges have no length");
    // All of one face.
    let mesh = sphere(1.0, 1);
    let zero = EdgeMap::filled(mesh.edge_count(), 0.0);
    let surface = IntrinsicSurface::new(&mesh, &zero).unwrap();
    let distance = vertex_distances(&surface, &[Source::vertex(VertexId(3))]).unwrap();
    assert!(distance.values().iter().all(|&d| d == 0.0));
}

#[test]
fn scales_change_nothing_but_the_scale() {
    let mesh = displace(&torus(1.0, 0.4, 30, 15), |p| 0.05 * (9.0 * p.x).sin());
    let lengths = edge_lengths(&mesh);
    let distances = |lengths: &EdgeMap<f64>| {
        let surface = IntrinsicSurface::new(&mesh, lengths).unwrap();
        vertex_distances(&surface, &[Source::vertex(VertexId(17))]).unwrap()
    };
    let usual = distances(&lengths);
    for exponent in [-330, -40, 40, 330] {
        let factor = 2.0f64.powi(exponent);
        let scaled = distances(&lengths.map(|l| l * factor));
        assert!(scaled.iter().all(|(v, &d)| d == usual[v] * factor), "2^{exponent} changes no digit");
    }
    for factor in [1e-100, 1e-9, 1e12, 1e100] {
        let scaled = distances(&lengths.map(|l| l * factor));
        assert!(scaled.iter().all(|(v, &d)| (d / factor - usual[v]).abs() <= 1e-13 * usual[v]), "{factor}");
    }
}

#[test]
#[allow(clippy::print_stderr, reason = "a test that skips says so")]
fn broken_models_that_are_surfaces_have_distances() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/models/nasty");
    let Ok(entries) = std::fs::read_dir(&folder) else {
        eprintln!("skipped: there are no models in {}", folder.display());
        return;
    };
    let mut paths: Vec<PathBuf> = entries.map(|e| e.unwrap().path()).collect();
    paths.sort();
    let mut checked = 0;
    for path in paths {
        let Ok(soup) = quadloom_io::read_soup(&path) else { continue };
        let options = RepairOptions { zero_area_rel: 0.0, ..RepairOptions::default() };
        let Ok(repaired) = repair(&soup, &options) else { continue };
        let mesh = &repaired.mesh;
        check_mesh(&path.display().to_string(), mesh, &edge_lengths(mesh), JUMP_ON_NEEDLES);
        checked += 1;
    }
    assert!(checked > 5, "only {checked} of them are surfaces");
}

#[test]
fn the_same_sources_give_the_same_bytes() {
    let mesh = displace(&torus(1.0, 0.4, 40, 20), |p| 0.07 * (9.0 * p.x).sin() * (5.0 * p.z).cos());
    let lengths = edge_lengths(&mesh);
    let surface = IntrinsicSurface::new(&mesh, &lengths).unwrap();
    let bits = |wave: &Wavefront| -> Vec<u64> {
        let field = wave.field();
        let windows = mesh.edges().flat_map(|e| field.windows(e).collect::<Vec<_>>());
        let of_windows = windows.flat_map(|w| [w.interval[0], w.interval[1], w.distances[0], w.distances[1]]);
        field.vertex_distances().values().iter().copied().chain(of_windows).map(f64::to_bits).collect()
    };
    let sources = [Source::vertex(VertexId(3)), Source::vertex(VertexId(400)).with_label(1).with_start(0.1)];
    for epsilon in [0.0, 1e-3] {
        let options = Options { epsilon, ..Options::default() };
        let mut fresh = Wavefront::new(&surface);
        fresh.spread(&sources, &options, &Progress::none()).unwrap();
        let mut used = Wavefront::new(&surface);
        used.spread(&[Source::vertex(VertexId(9))], &Options::default(), &Progress::none()).unwrap();
        used.spread(&sources, &options, &Progress::none()).unwrap();
        assert_eq!(bits(&fresh), bits(&used));
    }
}

#[test]
fn within_a_limit_distances_are_right() {
    let mesh = with_noise(&sphere(1.0, 4), 0.05, 2);
    let lengths = edge_lengths(&mesh);
    let surface = IntrinsicSurface::new(&mesh, &lengths).unwrap();
    let source = [Source::vertex(VertexId(11))];
    let all = vertex_distances(&surface, &source).unwrap();
    let mut wave = Wavefront::new(&surface);
    let options = Options { limit: 0.7, ..Options::default() };
    wave.spread(&source, &options, &Progress::none()).unwrap();
    let some = wave.field().vertex_distances();
    let right = all.iter().filter(|&(v, &d)| d <= 0.7 && some[v] == d).count();
    assert_eq!(right, all.values().iter().filter(|&&d| d <= 0.7).count());
    assert!(some.iter().all(|(v, &d)| d >= all[v]) && some.values().iter().any(|d| d.is_infinite()));
}

#[test]
fn a_subdivided_graph_is_longer_within_its_bound() {
    const PARTS: usize = 64;
    for seed in 0..30 {
        let mut mesh = with_noise(&if seed % 2 == 0 { sphere(1.0, 1) } else { torus(1.0, 0.4, 7, 5) }, 0.15, seed);
        if seed % 3 == 2
            && let Some(open) = with_holes(&mesh, |f| dice(seed, 1000 + u64::from(f)) > 0.1)
        {
            mesh = open;
        }
        let lengths = edge_lengths(&mesh);
        let surface = IntrinsicSurface::new(&mesh, &lengths).unwrap();
        let mut wave = Wavefront::new(&surface);
        wave.spread(&[Source::vertex(VertexId(0))], &Options::default(), &Progress::none()).unwrap();
        // 1. Nodes: vertices, then 63 on each edge; lines: all straight ones within a face.
        let node = |h: quadloom_mesh::HalfEdgeId, k: usize| {
            let e = mesh.edge(h);
            match k {
                0 => mesh.origin(h).index(),
                PARTS => mesh.target(h).index(),
                k => {
                    let k = if mesh.half_edge(e) == h { k } else { PARTS - k };
                    mesh.vertex_count() + e.index() * (PARTS - 1) + k - 1
                }
            }
        };
        let mut faces_of = vec![Vec::new(); mesh.vertex_count() + mesh.edge_count() * (PARTS - 1)];
        let mut face_nodes = Vec::new();
        for f in mesh.faces() {
            let corners = mesh.face_vertices(f).map(|v| mesh.position(v));
            let mut nodes = Vec::new();
            for (i, h) in mesh.face_half_edges(f).into_iter().enumerate() {
                for k in 0..PARTS {
                    let at = corners[i].lerp(corners[(i + 1) % 3], k as f64 / PARTS as f64);
                    nodes.push((node(h, k), at));
                    faces_of[node(h, k)].push(f.index());
                }
            }
            face_nodes.push(nodes);
        }
        // 2. Dijkstra.
        let mut distance = vec![f64::INFINITY; faces_of.len()];
        let mut queue = BinaryHeap::from([(std::cmp::Reverse(0u64), 0usize)]);
        distance[0] = 0.0;
        while let Some((std::cmp::Reverse(bits), n)) = queue.pop() {
            let d = f64::from_bits(bits);
            if d > distance[n] {
                continue;
            }
            for nodes in faces_of[n].iter().map(|&f| &face_nodes[f]) {
                let at = nodes.iter().find(|x| x.0 == n).unwrap().1;
                for &(m, q) in nodes {
                    let through = d + at.distance(q);
                    if through < distance[m] {
                        distance[m] = through;
                        queue.push((std::cmp::Reverse(through.to_bits()), m));
                    }
                }
            }
        }
        // 3. Each crossing of an exact path is at most half a part of its edge from a node, and two lines end there.
        let part = |p: &SurfacePoint| match p.weights.iter().position(|&w| w == 0.0) {
            Some(k) => lengths[mesh.edge(mesh.face_half_edges(p.face)[(k + 1) % 3])] / PARTS as f64,
            None => 0.0,
        };
        for v in mesh.vertices() {
            let (exact, graph) = (wave.field().vertex_distance(v), distance[v.index()]);
            if exact.is_infinite() {
                assert!(graph.is_infinite());
                continue;
            }
            assert!(exact <= graph * (1.0 + 1e-12), "{seed}: vertex {v}: {exact} above {graph}");
            let h = mesh.outgoing_half_edge(v);
            let mut weights = [0.0; 3];
            weights[(h.0 % 3) as usize] = 1.0;
            let path = wave.field().path_from(&SurfacePoint { face: mesh.face(h), weights }).unwrap().unwrap();
            let bound = exact + path.points.iter().map(part).sum::<f64>() + 1e-12;
            assert!(graph <= bound, "{seed}: vertex {v}: {graph} above {bound}");
        }
    }
}

#[test]
fn what_is_wrong_is_named() {
    let mesh = sphere(1.0, 1);
    let lengths = edge_lengths(&mesh);
    let with = |e: usize, length: f64| {
        let mut wrong = lengths.clone();
        wrong.values_mut()[e] = length;
        IntrinsicSurface::new(&mesh, &wrong).map(|_| ()).unwrap_err().to_string()
    };
    // 1. Lengths.
    assert!(
        with(7, f64::NAN).contains("edge 7") && with(7, -1.0).contains("-1") && with(7, f64::INFINITY).contains("inf")
    );
    assert!(with(7, 100.0).contains("longer than the others"));
    let few = EdgeMap::filled(3, 1.0);
    assert!(matches!(IntrinsicSurface::new(&mesh, &few), Err(GeodesicError::LengthCount { found: 3, edges: 120 })));
    // 2. Sources.
    let surface = IntrinsicSurface::new(&mesh, &lengths).unwrap();
    let mut wave = Wavefront::new(&surface);
    let mut wrong =
        |source: Source, options: &Options| wave.spread(&[source], options, &Progress::none()).unwrap_err().to_string();
    let usual = Options::default();
    let p = |face: u32, weights: [f64; 3]| SurfacePoint { face: FaceId(face), weights };
    let inside = p(0, [0.2, 0.3, 0.5]);
    assert!(wrong(Source::vertex(VertexId(99)).with_label(6), &usual).contains("source 6: there is no vertex 99"));
    assert!(wrong(Source::point(p(500, [1.0, 0.0, 0.0])), &usual).contains("no face 500"));
    assert!(wrong(Source::point(p(3, [1.0, 0.5, 0.0])), &usual).contains("no point of face 3"));
    assert!(wrong(Source::point(p(3, [f64::NAN, 0.5, 0.5])), &usual).contains("no point of face 3"));
    assert!(wrong(Source::segment(inside, p(1, inside.weights)), &usual).contains("faces 0 and 1"));
    for start in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(wrong(Source::vertex(VertexId(0)).with_start(start), &usual).contains("starts at"));
    }
    for epsilon in [-0.1, 1.0, f64::NAN] {
        let options = Options { epsilon, ..Options::default() };
        assert!(wrong(Source::vertex(VertexId(0)), &options).contains("epsilon"));
    }
    assert_eq!(wave.spread(&[], &usual, &Progress::none()), Err(GeodesicError::NoSource));
    // 3. Questions to a wavefront that kept no windows, or with wrong numbers.
    let only_vertices = Options { keep: Keep::Vertices, ..Options::default() };
    wave.spread(&[Source::vertex(VertexId(0))], &only_vertices, &Progress::none()).unwrap();
    assert_eq!(wave.field().at(&inside), Err(GeodesicError::NoWindows));
    assert_eq!(wave.field().path_from(&inside), Err(GeodesicError::NoWindows));
    assert_eq!(wave.field().cut_locus(0.1), Err(GeodesicError::NoWindows));
    let refined = wave.field().refine(&RefineOptions::within(0.1), &Progress::none());
    assert_eq!(refined.map(|_| ()), Err(GeodesicError::NoWindows));
    wave.spread(&[Source::vertex(VertexId(0))], &usual, &Progress::none()).unwrap();
    for tolerance in [0.0, -1.0, f64::NAN] {
        let refined = wave.field().refine(&RefineOptions::within(tolerance), &Progress::none());
        assert!(refined.map(|_| ()).unwrap_err().to_string().contains("tolerance"));
    }
    let distance = wave.field().vertex_distances();
    for spacing in [0.0, -1.0, f64::NAN, 1e-9] {
        assert!(spaced(&distance, spacing).is_err(), "{spacing}");
    }
    // 4. A stop.
    let stopped = Progress::none().with_flag(Arc::new(AtomicBool::new(true)));
    let large = sphere(1.0, 6);
    let lengths = edge_lengths(&large);
    let surface = IntrinsicSurface::new(&large, &lengths).unwrap();
    let result = Wavefront::new(&surface).spread(&[Source::vertex(VertexId(0))], &usual, &stopped);
    assert!(matches!(result, Err(GeodesicError::Cancelled(_))));
}

#[test]
fn isolines_close_or_end_at_the_boundary() {
    let mesh = plate_with_holes(0.1);
    let lengths = edge_lengths(&mesh);
    let surface = IntrinsicSurface::new(&mesh, &lengths).unwrap();
    let distance = vertex_distances(&surface, &[Source::vertex(VertexId(0))]).unwrap();
    let largest = distance.values().iter().copied().fold(0.0, f64::max);
    let values = spaced(&distance, largest / 30.0).unwrap();
    assert!((29..=30).contains(&values.len()));
    let lines = isolines(&mesh, &distance, &values);
    let mut crossed = std::collections::BTreeSet::new();
    for line in &lines {
        assert!(line.points.len() > 1);
        for &(e, t) in &line.points {
            let [a, b] = mesh.ends(e).map(|v| distance[v]);
            assert!((a + t * (b - a) - line.value).abs() <= 1e-12 * largest);
            assert!(crossed.insert((e, line.value.to_bits())), "each edge is crossed once by a value");
        }
        let ends = [line.points[0].0, line.points[line.points.len() - 1].0];
        assert!(line.is_closed || ends.iter().all(|&e| mesh.is_boundary_edge(e)));
    }
    // Every edge that should be crossed is.
    let expected = mesh
        .edges()
        .flat_map(|e| {
            let [a, b] = mesh.ends(e).map(|v| distance[v]);
            values.iter().filter(move |&&v| (a < v) != (b < v)).map(move |v| (e, v.to_bits())).collect::<Vec<_>>()
        })
        .collect::<std::collections::BTreeSet<_>>();
    assert_eq!(crossed, expected);
}
