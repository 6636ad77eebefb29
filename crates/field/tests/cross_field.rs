//! The cross field against its definition: Poincaré-Hopf, known minima, prescriptions, determinism.

mod common;

use common::{cube, plate, sphere, torus};
use quadloom_field::{CrossField, FieldConstraints, FieldOptions, FieldReport, Transport, solve_cross_field};
use quadloom_mesh::features::FeatureOptions;
use quadloom_mesh::metric::{FaceFrame, edge_lengths};
use quadloom_mesh::topology::euler_characteristic;
use quadloom_mesh::{FaceMap, FeatureGraph, Progress, TriMesh, VertexId};
use std::f64::consts::{FRAC_PI_2, TAU};

fn solve(mesh: &TriMesh, features: bool, options: &FieldOptions) -> (CrossField, FieldReport, FieldConstraints) {
    let (transport, length) = (Transport::of(mesh), edge_lengths(mesh));
    let graph = match features {
        true => FeatureGraph::detect(mesh, &FeatureOptions::default()).0,
        false => FeatureGraph::none(mesh),
    };
    let (constraints, disagreeing) = FieldConstraints::from_features(mesh, &transport, &length, &graph);
    assert!(disagreeing.is_empty() || features);
    let (field, report) =
        solve_cross_field(mesh, &transport, &length, &constraints, options, &Progress::none()).unwrap();
    assert_eq!(field.check(mesh, &transport), vec![]);
    assert_eq!(constraints.missed_directions(&field, 1e-9), vec![]);
    (field, report, constraints)
}

fn indices(mesh: &TriMesh, field: &CrossField) -> Vec<i32> {
    field.singularities(mesh, &Transport::of(mesh)).into_iter().map(|(_, q)| q).collect()
}

#[test]
fn transport_around_a_vertex_turns_by_its_angle_defect() {
    for mesh in [cube(2), sphere(2), torus(9, 7), plate(6, 0.2)] {
        let transport = Transport::of(&mesh);
        let mut total = 0.0;
        for v in mesh.vertices() {
            total += transport.defect(v);
            if !mesh.is_boundary_vertex(v) {
                let turn: f64 = transport.crossings(&mesh, v).map(|h| transport.kappa(&mesh, h)).sum();
                let rest = (turn - transport.defect(v)) / TAU;
                assert!((rest - rest.round()).abs() < 1e-9, "vertex {v}: {rest} turns");
            }
        }
        assert!((total - TAU * euler_characteristic(&mesh) as f64).abs() < 1e-9, "Gauss-Bonnet");
    }
}

#[test]
fn any_field_obeys_poincare_hopf() {
    for (seed, mesh) in [cube(1), sphere(2), torus(8, 6), plate(5, 0.3)].iter().enumerate() {
        let transport = Transport::of(mesh);
        let angle = FaceMap::from_fn(mesh.face_count(), |f| ((f.0 as f64 + 1.0) * 12.9898 + seed as f64).sin() * 50.0);
        let mut field = CrossField::from_angles(mesh, &transport, angle);
        // Jumps that are not the nearest ones are as legal.
        for e in mesh.edges().filter(|&e| e.0 % 5 == 0 && !mesh.is_boundary_edge(e)) {
            field.period_jump[e] += e.0 as i32 % 3 - 1;
        }
        assert_eq!(field.check(mesh, &transport), vec![]);
        let sum: f64 = mesh.vertices().map(|v| field.turning(mesh, &transport, v)).sum();
        assert!((sum - 4.0 * euler_characteristic(mesh) as f64).abs() < 1e-6);
        for v in mesh.vertices().filter(|&v| !mesh.is_boundary_vertex(v)) {
            let (index, turning) = (f64::from(field.index(mesh, &transport, v)), field.turning(mesh, &transport, v));
            assert!((index - turning).abs() < 1e-6, "vertex {v}: {index} and {turning}");
        }
    }
}

/// The matching, by brute force in space: of the neighbour's four directions the one nearest after unfolding.
#[test]
fn matching_follows_directions_across_every_edge() {
    let mesh = plate(6, 0.05);
    let transport = Transport::of(&mesh);
    let (field, _, _) = solve(&mesh, true, &FieldOptions::default());
    for h in mesh.half_edges() {
        let Some(t) = mesh.twin(h) else { continue };
        let (here, there) = (mesh.face(h), mesh.face(t));
        // Unfold the neighbour about the common edge: keep the edge, rotate the normal.
        let axis = (mesh.position(mesh.target(h)) - mesh.position(mesh.origin(h))).normalize();
        let (from, to) = (FaceFrame::of(&mesh, here), FaceFrame::of(&mesh, there));
        let unfolded = |d: u8| {
            let v = field.direction(&mesh, here, d);
            axis * v.dot(axis) + to.normal.cross(axis) * v.dot(from.normal.cross(axis))
        };
        for d in 0..4 {
            let nearest = (0..4u8)
                .max_by(|&a, &b| {
                    let cos = |k: u8| field.direction(&mesh, there, k).dot(unfolded(d));
                    cos(a).total_cmp(&cos(b))
                })
                .unwrap();
            if field.turn(&mesh, &transport, h).abs() < 0.7 {
                assert_eq!((d + field.matching(&mesh, h)) % 4, nearest, "half-edge {h}, direction {d}");
            }
        }
        assert_eq!((field.matching(&mesh, h) + field.matching(&mesh, t)) % 4, 0);
    }
}

/// A quarter turn more per counter-clockwise round: the chart of a valence-3 vertex closes by +1.
#[test]
fn matchings_around_a_vertex_give_its_index() {
    let mesh = sphere(3);
    let transport = Transport::of(&mesh);
    let (field, _, _) = solve(&mesh, false, &FieldOptions::default());
    for v in mesh.vertices() {
        let turns: i32 = transport.crossings(&mesh, v).map(|h| i32::from(field.matching(&mesh, h))).sum();
        assert_eq!((turns - field.index(&mesh, &transport, v)).rem_euclid(4), 0);
    }
}

#[test]
fn directions_in_space_come_back() {
    let mesh = torus(20, 12);
    let (field, _, _) = solve(&mesh, false, &FieldOptions::default());
    for d in 0..4 {
        let directions = FaceMap::from_fn(mesh.face_count(), |f| 3.0 * field.direction(&mesh, f, d));
        let again = CrossField::from_directions(&mesh, &directions).unwrap();
        let transport = Transport::of(&mesh);
        assert_eq!(again.singularities(&mesh, &transport), field.singularities(&mesh, &transport));
        assert!((again.energy(&mesh, &transport) - field.energy(&mesh, &transport)).abs() < 1e-9);
    }
    let normals = FaceMap::from_fn(mesh.face_count(), |f| mesh.face_normal(f));
    assert!(CrossField::from_directions(&mesh, &normals).is_err());
}

#[test]
fn a_cube_has_its_corners() {
    let mesh = cube(3);
    for features in [true, false] {
        let (field, _, _) = solve(&mesh, features, &FieldOptions::default());
        let found = field.singularities(&mesh, &Transport::of(&mesh));
        assert_eq!(found, (0..8).map(|k| (VertexId(k), 1)).collect::<Vec<_>>(), "features {features}");
    }
}

#[test]
fn a_sphere_has_eight_singularities_and_a_torus_none() {
    let (field, _, _) = solve(&sphere(4), false, &FieldOptions::default());
    assert_eq!(indices(&sphere(4), &field), vec![1; 8]);
    let mesh = torus(60, 14);
    let (field, _, _) = solve(&mesh, false, &FieldOptions::default());
    assert_eq!(indices(&mesh, &field), Vec::<i32>::new());
}

#[test]
fn a_square_plate_is_regular_with_four_convex_corners() {
    let mesh = plate(8, 0.0);
    let transport = Transport::of(&mesh);
    let (field, report, _) = solve(&mesh, true, &FieldOptions::default());
    assert_eq!(indices(&mesh, &field), Vec::<i32>::new());
    assert!(report.energy < 1e-12);
    let corners = mesh.vertices().filter(|&v| (field.turning(&mesh, &transport, v) - 1.0).abs() < 1e-6).count();
    assert_eq!(corners, 4);
}

#[test]
fn angles_minimise_the_energy_for_their_jumps() {
    let mesh = plate(7, 0.3);
    let transport = Transport::of(&mesh);
    let (field, _, constraints) = solve(&mesh, true, &FieldOptions::default());
    let energy = field.energy(&mesh, &transport);
    for f in mesh.faces().filter(|&f| constraints.angle[f].is_none()) {
        for step in [-1e-3, 1e-3] {
            let mut moved = field.clone();
            moved.angle[f] += step;
            assert!(moved.energy(&mesh, &transport) > energy);
        }
    }
}

#[test]
fn same_bits_twice() {
    let mesh = plate(12, 0.4);
    let options = FieldOptions { cancel_distance: 0.2, ..Default::default() };
    assert_eq!(solve(&mesh, true, &options).0, solve(&mesh, true, &options).0);
}

#[test]
fn soft_directions_bend_a_field_without_fixing_it() {
    let mesh = torus(24, 12);
    let (transport, length) = (Transport::of(&mesh), edge_lengths(&mesh));
    let mut constraints = FieldConstraints::none(&mesh);
    let wanted = FRAC_PI_2 / 3.0;
    let f = mesh.faces().next().unwrap();
    constraints.soft[f] = Some(quadloom_field::SoftDirection { angle: wanted, weight: 10.0 });
    let (field, _) =
        solve_cross_field(&mesh, &transport, &length, &constraints, &FieldOptions::default(), &Progress::none())
            .unwrap();
    assert!(quadloom_field::constraints::cross_distance(field.angle[f], wanted) < 1e-6, "nothing else pulls");
}
