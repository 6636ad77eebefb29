//! The pipeline on generated shapes: topology, count, determinism, given fields, refusals.

use quadloom::mesh::{DVec3, Summary, shapes};
use quadloom::verify::verify_against;
use quadloom::{
    FailureKind, Fallback, GivenField, Progress, RemeshError, RemeshOptions, RemeshResult, Target, TriMesh,
    remesh_mesh, sample,
};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

fn shape(name: &str) -> TriMesh {
    sample(name).unwrap_or_else(|| panic!("there is no sample {name}"))
}

fn quads(n: usize) -> RemeshOptions {
    RemeshOptions { target: Target::Quads(n), ..RemeshOptions::default() }
}

fn made(mesh: &TriMesh, options: &RemeshOptions) -> RemeshResult {
    remesh_mesh(mesh, options, &Progress::none()).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn shapes_of_any_topology_become_valid_quads_of_the_count_asked_for() {
    for (name, n) in
        [("sphere", 400), ("torus", 500), ("genus2", 800), ("cylinder", 300), ("plate", 500), ("cube", 300)]
    {
        let mesh = shape(name);
        let result = made(&mesh, &quads(n));
        assert!(Summary::of(&result.quads).same_topology(&Summary::of(&mesh)), "{name}");
        assert!(verify_against(&result.quads, &mesh, Some(35.0)).passed(), "{name}");
        assert_eq!(result.report.components[0].made_by, "integer-grid map", "{name}: {:?}", result.report.warnings);
        let error = result.report.count.error_percent;
        assert!(error.abs() <= 10.0 || result.report.warnings.iter().any(|w| w.misses_request()), "{name}: {error} %");
    }
}

#[test]
fn springs_have_no_irregular_vertex() {
    // Long tubes: the smoothest field spirals along them, and then there is no map at all.
    let pipe = shapes::cylinder(0.12, 36.0, 16, 400);
    let wound = |v| {
        let p: DVec3 = pipe.position(v);
        let out = 1.0 + p.x;
        DVec3::new(out * p.z.cos(), out * p.z.sin(), p.y + 0.08 * p.z)
    };
    let spring = TriMesh::new(pipe.vertices().map(wound).collect(), &pipe.to_faces()).expect("a spring");
    for n in [700, 1500, 3000] {
        let report = made(&spring, &quads(n)).report;
        assert_eq!(report.irregular.interior, 0, "{n}: {:?}", report.warnings);
        assert_eq!(report.components[0].attempt, 0, "{n}: {:?}", report.warnings);
    }
}

/// A closed surface of these points and triangles.
fn polyhedron(points: &[[f64; 3]], faces: &[[u32; 3]]) -> TriMesh {
    TriMesh::new(points.iter().map(|&p| DVec3::from(p)).collect(), faces).expect("a polyhedron")
}

#[test]
fn a_corner_of_a_cube_keeps_its_edges_where_they_meet_at_45_degrees() {
    // The smoothest field gives the corners of 45° no quad or, next to them, a singular vertex.
    let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let corner = polyhedron(&points, &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]);
    for n in [100, 500, 1000, 2000] {
        let report = made(&corner, &quads(n)).report;
        assert_eq!((report.features.chains_kept, report.features.dropped_edges), (6, 0), "{n}: {:?}", report.warnings);
        assert!(report.quality.scaled_jacobian_min > 0.3, "{n}: {}", report.quality.scaled_jacobian_min);
    }
}

#[test]
fn the_sharp_edges_of_a_polyhedron_are_kept_where_others_of_its_edges_are_blunt() {
    // The ten sharp edges end at blunt ones that are nearly as sharp.
    let points = [
        [-0.8, -1.3, -0.1],
        [0.4, 1.1, 0.0],
        [-0.6, -0.8, 0.2],
        [1.6, 0.3, -0.4],
        [-1.0, 1.6, 0.1],
        [-1.7, -0.1, -0.3],
        [0.4, 0.8, -0.5],
        [-0.3, -1.0, -0.1],
        [-1.3, 0.0, 0.0],
    ];
    let faces = [
        [5, 3, 0],
        [6, 3, 5],
        [5, 4, 6],
        [8, 4, 5],
        [8, 2, 4],
        [5, 0, 8],
        [8, 0, 2],
        [1, 2, 3],
        [4, 2, 1],
        [3, 6, 1],
        [1, 6, 4],
        [3, 2, 7],
        [2, 0, 7],
        [7, 0, 3],
    ];
    let features = made(&polyhedron(&points, &faces), &quads(500)).report.features;
    assert_eq!((features.edges, features.dropped_edges), (10, 0));
}

#[test]
fn indices_of_the_quads_sum_to_the_euler_characteristic() {
    // Poincaré-Hopf: the sum of 4 - valence over a closed quad mesh is four times chi.
    for name in ["sphere", "torus", "genus2"] {
        let result = made(&shape(name), &quads(600));
        let sum: i64 = result.report.irregular.by_valence.iter().map(|(&v, &n)| (4 - v as i64) * n as i64).sum();
        assert_eq!(sum, 4 * result.report.input.summary.chi, "{name}");
    }
}

#[test]
fn the_result_does_not_depend_on_threads() {
    let mesh = shape("two_spheres");
    let in_pool = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| made(&mesh, &quads(400)).quads)
    };
    assert_eq!(in_pool(1), in_pool(2));
}

#[test]
fn a_given_field_without_singularities_gives_a_regular_torus() {
    let torus = shape("torus");
    let around = |f| {
        let corner = torus.face_vertices(f).map(|v| torus.position(v));
        DVec3::Z.cross((corner[0] + corner[1] + corner[2]) / 3.0)
    };
    let field = GivenField { directions: torus.faces().map(around).collect() };
    let result = made(&torus, &RemeshOptions { field: Some(field), ..quads(600) });
    assert_eq!(result.report.irregular.interior, 0);
    assert_eq!(result.report.field.singularities_kept, Some(true));
}

#[test]
fn position_and_scale_of_the_input_are_kept() {
    let sphere = shape("sphere");
    let moved = sphere.positions().map(|p| *p * 1e-6 + DVec3::new(3.0, -2.0, 1.0));
    let moved = sphere.with_positions(moved).expect("finite");
    let result = made(&moved, &quads(300));
    for (_, p) in result.quads.positions().iter() {
        let distance = p.distance(DVec3::new(3.0, -2.0, 1.0));
        assert!((0.95e-6..1.01e-6).contains(&distance), "{distance}");
    }
}

#[test]
fn a_cancelled_run_says_so() {
    let progress = Progress::none().with_flag(Arc::new(AtomicBool::new(true)));
    let error = remesh_mesh(&shape("sphere"), &quads(300), &progress).expect_err("cancelled");
    assert_eq!(error.kind(), FailureKind::Cancelled);
}

#[test]
fn values_that_cannot_be_meant_are_refused() {
    let wrong = [
        RemeshOptions { target: Target::EdgeLength(-1.0), ..RemeshOptions::default() },
        RemeshOptions { target: Target::Scale(f64::NAN), ..RemeshOptions::default() },
        RemeshOptions { tolerance: 0.0, ..RemeshOptions::default() },
        RemeshOptions { sharp_angle: Some(-3.0), ..RemeshOptions::default() },
    ];
    for options in wrong {
        let error = remesh_mesh(&shape("cube"), &options, &Progress::none()).expect_err("refused");
        assert!(matches!(error, RemeshError::Option { .. }), "{error}");
    }
}

#[test]
fn a_single_triangle_is_split_with_a_warning_or_refused() {
    let triangle = TriMesh::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y], &[[0, 1, 2]]).expect("a triangle");
    let result = made(&triangle, &quads(12));
    assert!(Summary::of(&result.quads).same_topology(&Summary::of(&triangle)));
    let off = RemeshOptions { fallback: Fallback::Off, ..quads(12) };
    if let Err(error) = remesh_mesh(&triangle, &off, &Progress::none()) {
        assert_eq!(error.kind(), FailureKind::NoResult);
    }
}
