//! Extraction against grids known in closed form.

mod maps;

use maps::{Model, Random, cuboid, grid_area, is_positive, map_of, mark_line, rectangle, scramble, torus};
use proptest::prelude::*;
use quadloom_extract::{ExtractError, Extraction, Placement, extract};
use quadloom_mesh::topology::Summary;
use quadloom_mesh::{CornerMap, FeatureGraph, Progress, QuadMesh};
use quadloom_param::{GRID_UNIT, MapDefect};

fn run(model: &Model) -> Result<Extraction, ExtractError> {
    extract(&model.mesh, &model.map, &model.features, &Progress::none())
}

/// Unit squares of the plane with integer corners, as the sorted list of their lower left corners.
fn unit_squares(mesh: &QuadMesh) -> Vec<[i64; 2]> {
    let mut list: Vec<[i64; 2]> = mesh
        .faces()
        .map(|f| {
            let p = mesh.face_vertices(f).map(|v| mesh.position(v));
            let low = p.iter().fold(p[0], |a, &b| a.min(b));
            let corner = [low.x.round() as i64, low.y.round() as i64];
            for (k, &q) in p.iter().enumerate() {
                let expected = [[0., 0.], [1., 0.], [1., 1.], [0., 1.]]
                    .map(|o| [o[0] + corner[0] as f64, o[1] + corner[1] as f64]);
                let i = expected.iter().position(|e| (e[0] - q.x).hypot(e[1] - q.y) < 1e-5).expect("a unit square");
                let first = expected.iter().position(|e| (e[0] - p[0].x).hypot(e[1] - p[0].y) < 1e-5).unwrap();
                assert_eq!(i, (first + k) % 4, "counter-clockwise");
            }
            corner
        })
        .collect();
    list.sort_unstable();
    list
}

/// Positions in lexicographic order, at the precision that charts agree to.
fn sorted_positions(mesh: &QuadMesh) -> Vec<[i64; 3]> {
    let mut list: Vec<[i64; 3]> =
        mesh.positions().values().iter().map(|p| p.to_array().map(|x| (x * 1e6).round() as i64)).collect();
    list.sort_unstable();
    list
}

fn all_squares(size: [usize; 2]) -> Vec<[i64; 2]> {
    (0..size[0]).flat_map(|i| (0..size[1]).map(move |j| [i as i64, j as i64])).collect()
}

#[test]
fn one_square_of_two_triangles() {
    let model = rectangle([1, 1], [1, 1], 0.0, 7);
    let e = run(&model).unwrap();
    assert_eq!(unit_squares(&e.mesh), [[0, 0]]);
    assert!(e.placement.values().iter().all(|p| matches!(p, Placement::Corner(_))));
    assert!(e.feature_edges.values().iter().all(Option::is_some));
}

#[test]
fn vertices_edges_and_faces_carry_grid_points() {
    // 6 x 4 units on 4 x 3 cells without jitter: points at vertices, inside axis-parallel edges, and inside faces.
    let model = rectangle([6, 4], [4, 3], 0.0, 3);
    let e = run(&model).unwrap();
    assert_eq!(unit_squares(&e.mesh), all_squares([6, 4]));
    assert_eq!(e.report.followed_features, e.report.feature_edges);
}

#[test]
fn features_along_mesh_edges_become_quad_edges() {
    // The mesh line between cells 2 and 3 of 5 lies at u = 4.
    let mut model = rectangle([10, 6], [5, 4], 0.0, 11);
    mark_line(&mut model, 0, 4);
    let e = run(&model).unwrap();
    let sharp = model.features.chains.iter().position(|c| c.kind == quadloom_mesh::FeatureKind::Sharp).unwrap() as u32;
    let on_line: Vec<_> = e.mesh.edges().filter(|&q| e.feature_edges[q] == Some(sharp)).collect();
    assert_eq!(on_line.len(), 6);
    for q in on_line {
        assert!(e.mesh.ends(q).iter().all(|&v| (e.mesh.position(v).x - 4.0).abs() < 1e-6));
    }
    let on_chain =
        e.placement.values().iter().filter(|p| matches!(p, Placement::Chain { chain, .. } if *chain == sharp));
    assert_eq!(on_chain.count(), 5, "its ends are corners");
    assert_eq!(e.report.followed_features, e.report.feature_edges);
    let boundary = e.mesh.edges().filter(|&q| e.mesh.is_boundary_edge(q));
    assert!(boundary.clone().all(|q| e.feature_edges[q].is_some()));
    assert_eq!(boundary.count(), 32);
}

#[test]
fn cube_has_eight_corners_of_valence_three() {
    for (size, cells) in [([1, 1, 1], 1), ([1, 1, 1], 3), ([3, 2, 4], 2)] {
        let mut model = cuboid(size, cells);
        for turn in 0..3 {
            if turn > 0 {
                scramble(&mut model, 5 + turn);
            }
            let e = run(&model).unwrap();
            let [a, b, c] = size;
            assert_eq!(e.mesh.face_count(), 2 * (a * b + b * c + c * a));
            assert_eq!(Summary::of(&e.mesh).chi, 2);
            let corners = e.mesh.vertices().filter(|&v| e.mesh.valence(v) == 3).count();
            assert_eq!((corners, e.mesh.vertices().filter(|&v| e.mesh.valence(v) > 4).count()), (8, 0));
            // Cone indices as documented: +1 at valence three.
            let cones: Vec<i32> =
                model.mesh.vertices().map(|v| model.map.cone(&model.mesh, v)).filter(|&i| i != 0).collect();
            assert_eq!(cones, [1; 8]);
            let quarters = |v| model.map.quarters(&model.mesh, v);
            let sharp: Vec<i32> = model.mesh.vertices().map(quarters).filter(|&q| q != 4).collect();
            assert_eq!(sharp, [3; 8]);
            assert_eq!(e.report.followed_features, model.features.edge_count());
        }
    }
}

#[test]
fn scaled_cube_has_quads_larger_than_triangles() {
    // Charts in units of a third: grid points are rarer than vertices.
    let mut model = cuboid([6, 6, 6], 1);
    let uv = model.map.uv.map(|p| p.map(|x| x / 3));
    model.map = map_of(&model.mesh, uv);
    let e = run(&model).unwrap();
    assert_eq!(e.mesh.face_count(), 24);
    assert_eq!(e.report.followed_features, model.features.edge_count());
}

#[test]
fn grid_coordinates_are_unit_squares() {
    let mut model = torus([7, 5], [9, 6], 0.2, [0.3, 0.1], 5);
    scramble(&mut model, 3);
    let e = run(&model).unwrap();
    for f in e.mesh.faces() {
        let g = e.grid[f].expect("no fold");
        let d = [0, 1].map(|k| g[1][k] - g[0][k]);
        assert_eq!(d[0].abs() + d[1].abs(), 1);
        assert_eq!([0, 1].map(|k| g[3][k] - g[0][k]), [-d[1], d[0]]);
        assert_eq!([0, 1].map(|k| g[2][k] - g[3][k]), d);
        // The first corner's origin has these coordinates.
        let v = e.mesh.face_vertices(f)[0];
        let o = e.origin[v];
        let uv = model.map.face_uv(&model.mesh, o.face);
        for k in 0..2 {
            let at: f64 = (0..3).map(|i| o.weights[i] * uv[i][k] as f64).sum();
            assert!((at / GRID_UNIT as f64 - f64::from(g[0][k])).abs() < 1e-9);
        }
        assert!((o.weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert!((o.position(&model.mesh) - e.mesh.position(v)).length() < 1e-12);
    }
}

#[test]
fn unaligned_boundary_is_trimmed_and_said() {
    let mut model = rectangle([5, 4], [6, 7], 0.2, 9);
    // Half a unit to the right: the columns at both ends are cut.
    let uv = model.map.uv.map(|p| [p[0] + GRID_UNIT / 2, p[1]]);
    model.map = map_of(&model.mesh, uv);
    model.features = FeatureGraph::none(&model.mesh);
    let e = run(&model).unwrap();
    assert_eq!(e.mesh.face_count(), 4 * 4);
    assert_eq!(e.report.trimmed, 2 * 5);
    // Both directions.
    let uv = model.map.uv.map(|p| [p[0], p[1] + GRID_UNIT / 3]);
    model.map = map_of(&model.mesh, uv);
    let e = run(&model).unwrap();
    assert_eq!(e.mesh.face_count(), 4 * 3);
}

#[test]
fn broken_maps_are_refused_with_the_place() {
    let mut model = rectangle([3, 3], [3, 3], 0.0, 1);
    let h = model.mesh.half_edges().find(|&h| model.mesh.twin(h).is_some()).unwrap();
    model.map.transition[h].translation[0] += GRID_UNIT;
    let Err(ExtractError::Map(list)) = run(&model) else { panic!("not seamless") };
    assert!(list.contains(&MapDefect::Seam(h)));
    model.map.transition[h].translation[0] = 1;
    assert!(matches!(run(&model), Err(ExtractError::Map(_))));
    let mut model = rectangle([3, 3], [3, 3], 0.0, 1);
    model.map.uv[h][0] = i64::MIN;
    assert!(matches!(run(&model), Err(ExtractError::Range { .. })));
}

#[test]
fn cancelled_run_says_so() {
    let model = rectangle([3, 3], [3, 3], 0.0, 1);
    let flag = std::sync::Arc::new(std::sync::atomic::AtomicBool::new(true));
    let e = extract(&model.mesh, &model.map, &model.features, &Progress::none().with_flag(flag));
    assert!(matches!(e, Err(ExtractError::Cancelled(_))));
}

/// Moves one inner vertex so far that some of its triangles turn over.
fn fold(model: &mut Model, seed: u64, reach: f64) {
    let mut random = Random(seed | 1);
    let inner: Vec<_> = model.mesh.vertices().filter(|&v| !model.mesh.is_boundary_vertex(v)).collect();
    let v = inner[random.below(inner.len() as u64) as usize];
    let d = [0, 1].map(|_| (reach * random.signed() * GRID_UNIT as f64) as i64);
    let mesh = &model.mesh;
    let uv = CornerMap::from_fn(mesh.half_edge_count(), |h| {
        let p = model.map.uv[h];
        if mesh.origin(h) == v { [p[0] + d[0], p[1] + d[1]] } else { p }
    });
    model.map = map_of(&model.mesh, uv);
}

#[test]
fn folds_are_survived_or_refused() {
    let (mut folded, mut survived) = (0, 0);
    for seed in 1..400 {
        let mut model = rectangle([9, 7], [10, 8], 0.25, seed);
        fold(&mut model, seed * 77, 1.5);
        if is_positive(&model) {
            continue;
        }
        folded += 1;
        match run(&model) {
            Ok(e) => {
                survived += 1;
                assert_eq!(Summary::of(&e.mesh).chi, 1);
                assert!(e.report.inverted_faces > 0);
            }
            Err(ExtractError::NotQuads { faces, .. }) => assert!(!faces.is_empty()),
            Err(ExtractError::Mesh(_) | ExtractError::Topology { .. }) => {}
            Err(other) => panic!("{other}"),
        }
    }
    assert!(folded > 100);
    assert!(survived * 100 >= folded * 95, "{survived} of {folded}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn valid_planar_maps_yield_their_grid(
        size in [1usize..12, 1usize..12], cells in [1usize..9, 1usize..9], jitter in 0.0f64..0.45, seed in any::<u64>(),
    ) {
        let mut model = rectangle(size, cells, jitter, seed);
        prop_assume!(is_positive(&model));
        let plain = run(&model).unwrap();
        prop_assert_eq!(unit_squares(&plain.mesh), all_squares(size));
        prop_assert_eq!(plain.report.simplified + plain.report.lost + plain.report.trimmed + plain.report.filled + plain.report.contracted, 0);
        // The charts do not matter.
        scramble(&mut model, seed);
        let scrambled = run(&model).unwrap();
        prop_assert_eq!(unit_squares(&scrambled.mesh), all_squares(size));
        prop_assert_eq!(sorted_positions(&scrambled.mesh), sorted_positions(&plain.mesh));
    }

    #[test]
    fn valid_tori_yield_their_grid(
        size in [3usize..10, 3usize..10], cells in [3usize..9, 3usize..9], jitter in 0.0f64..0.4,
        shift in [-3.0f64..3.0, -3.0f64..3.0], seed in any::<u64>(),
    ) {
        let mut model = torus(size, cells, jitter, shift, seed);
        prop_assume!(is_positive(&model));
        scramble(&mut model, seed);
        let e = run(&model).unwrap();
        prop_assert_eq!(e.mesh.face_count() as f64, grid_area(&model));
        prop_assert_eq!(e.mesh.face_count(), size[0] * size[1]);
        let s = Summary::of(&e.mesh);
        prop_assert_eq!((s.chi, s.components, s.boundary_loops), (0, 1, 0));
        prop_assert!(e.mesh.vertices().all(|v| e.mesh.valence(v) == 4));
    }
}
