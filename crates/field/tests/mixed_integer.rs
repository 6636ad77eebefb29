//! The mixed-integer formulation: exact minima on tiny meshes, prescribed indices, order of the methods.

mod common;

use common::{cube, plate, sphere, torus};
use quadloom_field::{
    CrossField, FieldConstraints, FieldError, FieldOptions, FieldStart, Transport, solve_cross_field,
};
use quadloom_mesh::metric::edge_lengths;
use quadloom_mesh::{FaceMap, Progress, TriMesh, VertexId};
use quadloom_numeric::{ExactOptions, Rounding};

fn options(rounding: Rounding) -> FieldOptions {
    FieldOptions { start: FieldStart::Rounded(rounding), local_search: false, ..Default::default() }
}

fn solve(mesh: &TriMesh, constraints: &FieldConstraints, options: &FieldOptions) -> Result<CrossField, FieldError> {
    let (transport, length) = (Transport::of(mesh), edge_lengths(mesh));
    let (field, _) = solve_cross_field(mesh, &transport, &length, constraints, options, &Progress::none())?;
    assert_eq!(field.check(mesh, &transport), vec![]);
    Ok(field)
}

/// Every choice of period jumps in -2..=2 on the edges outside a spanning tree, each with its best angles by
/// Gauss-Seidel: slow, and independent of the solver.
fn brute_force_minimum(mesh: &TriMesh, constraints: &FieldConstraints) -> f64 {
    let transport = Transport::of(mesh);
    // Angles fixed where constrained; each other face is reached over one edge of zero jump.
    let mut reached: Vec<bool> = mesh.faces().map(|f| constraints.angle[f].is_some()).collect();
    let mut tree = vec![false; mesh.edge_count()];
    loop {
        let next = mesh
            .half_edges()
            .find(|&h| mesh.twin(h).is_some_and(|t| reached[mesh.face(h).index()] && !reached[mesh.face(t).index()]));
        let Some(h) = next else { break };
        tree[mesh.edge(h).index()] = true;
        reached[mesh.face(mesh.twin(h).unwrap()).index()] = true;
    }
    let open: Vec<_> = mesh.edges().filter(|&e| !tree[e.index()] && !mesh.is_boundary_edge(e)).collect();
    assert!(open.len() <= 6, "{} open edges", open.len());
    let mut best = f64::INFINITY;
    for code in 0..5usize.pow(open.len() as u32) {
        let angle = FaceMap::from_fn(mesh.face_count(), |f| constraints.angle[f].unwrap_or(0.0));
        let mut field = CrossField::from_angles(mesh, &transport, angle);
        field.period_jump.values_mut().fill(0);
        let mut rest = code;
        for &e in &open {
            field.period_jump[e] = (rest % 5) as i32 - 2;
            rest /= 5;
        }
        for _ in 0..100 {
            for f in mesh.faces().filter(|&f| constraints.angle[f].is_none()) {
                let sides: Vec<f64> = mesh
                    .face_half_edges(f)
                    .into_iter()
                    .filter(|&h| mesh.twin(h).is_some())
                    .map(|h| field.turn(mesh, &transport, h))
                    .collect();
                field.angle[f] += sides.iter().sum::<f64>() / sides.len() as f64;
            }
        }
        best = best.min(field.energy(mesh, &transport));
    }
    best
}

#[test]
fn exact_mode_finds_the_brute_force_minimum() {
    // A bent plate of 8 triangles and an octahedron; two faces fixed at awkward angles.
    for (mesh, angles) in [(plate(2, 0.4), [0.3, 1.1]), (sphere(0), [0.2, 0.9])] {
        let mut constraints = FieldConstraints::none(&mesh);
        let faces: Vec<_> = mesh.faces().collect();
        constraints.angle[faces[0]] = Some(angles[0]);
        constraints.angle[faces[faces.len() - 1]] = Some(angles[1]);
        let expected = brute_force_minimum(&mesh, &constraints);
        let transport = Transport::of(&mesh);
        let exact = solve(&mesh, &constraints, &options(Rounding::Exact(ExactOptions::default()))).unwrap();
        let energy = exact.energy(&mesh, &transport);
        assert!((energy - expected).abs() < 1e-6, "exact {energy}, brute force {expected}");
        let greedy = solve(&mesh, &constraints, &options(Rounding::Greedy)).unwrap();
        assert!(greedy.energy(&mesh, &transport) >= expected - 1e-9);
    }
}

#[test]
fn greedy_is_no_worse_than_direct_and_finds_the_corners_of_a_cube() {
    for mesh in [cube(2), sphere(3), plate(10, 0.5)] {
        let (transport, none) = (Transport::of(&mesh), FieldConstraints::none(&mesh));
        let energy = |rounding| solve(&mesh, &none, &options(rounding)).unwrap().energy(&mesh, &transport);
        assert!(energy(Rounding::Greedy) <= energy(Rounding::Direct) + 1e-9);
    }
    let mesh = cube(2);
    let field = solve(&mesh, &FieldConstraints::none(&mesh), &options(Rounding::Greedy)).unwrap();
    let found = field.singularities(&mesh, &Transport::of(&mesh));
    assert_eq!(found, (0..8).map(|k| (VertexId(k), 1)).collect::<Vec<_>>());
}

#[test]
fn prescribed_indices_are_obeyed_before_and_after_the_local_search() {
    let mesh = sphere(3);
    let transport = Transport::of(&mesh);
    let mut constraints = FieldConstraints::none(&mesh);
    constraints.indices = vec![(VertexId(0), 2), (VertexId(7), -1), (VertexId(11), 0), (VertexId(3), 1)];
    let region: Vec<VertexId> = (20..60).map(VertexId).collect();
    constraints.regions = vec![(region.clone(), 3)];
    for local_search in [false, true] {
        let options = FieldOptions { local_search, ..Default::default() };
        let field = solve(&mesh, &constraints, &options).unwrap();
        for &(v, q) in &constraints.indices {
            assert_eq!(field.index(&mesh, &transport, v), q, "vertex {v}");
        }
        assert_eq!(region.iter().map(|&v| field.index(&mesh, &transport, v)).sum::<i32>(), 3);
    }
}

#[test]
fn a_torus_with_all_indices_zero_is_regular() {
    let mesh = torus(18, 10);
    let mut constraints = FieldConstraints::none(&mesh);
    constraints.indices = mesh.vertices().map(|v| (v, 0)).collect();
    let field = solve(&mesh, &constraints, &FieldOptions::default()).unwrap();
    assert!(field.singularities(&mesh, &Transport::of(&mesh)).is_empty());
}

#[test]
fn impossible_prescriptions_are_refused_with_a_reason() {
    let mesh = sphere(1);
    let mut constraints = FieldConstraints::none(&mesh);
    constraints.indices = mesh.vertices().map(|v| (v, 0)).collect();
    let error = solve(&mesh, &constraints, &FieldOptions::default()).unwrap_err();
    assert!(matches!(error, FieldError::Unsatisfiable { .. }), "{error}");
    let open = plate(3, 0.0);
    let mut constraints = FieldConstraints::none(&open);
    constraints.indices = vec![(VertexId(0), 1)];
    let error = solve(&open, &constraints, &FieldOptions::default()).unwrap_err();
    assert_eq!(error, FieldError::NoInteriorVertex { vertex: VertexId(0) });
}

#[test]
fn the_local_search_never_raises_the_energy() {
    for (k, mesh) in [sphere(3), torus(14, 9), plate(14, 0.6), cube(3)].iter().enumerate() {
        let transport = Transport::of(mesh);
        let mut constraints = FieldConstraints::none(mesh);
        for f in mesh.faces().filter(|f| f.0 % 37 == 3) {
            constraints.angle[f] = Some(f64::from(f.0) * 0.7 + k as f64);
        }
        for start in [FieldStart::Smoothest, FieldStart::SmoothestExactly, FieldStart::Rounded(Rounding::Direct)] {
            let base = FieldOptions { start, near_pair_cost: 0.0, ..Default::default() };
            let searched = solve(mesh, &constraints, &base).unwrap();
            let plain = solve(mesh, &constraints, &FieldOptions { local_search: false, ..base }).unwrap();
            assert!(searched.energy(mesh, &transport) <= plain.energy(mesh, &transport) + 1e-9);
            assert_eq!(constraints.missed_directions(&searched, 1e-9), vec![]);
        }
    }
}
