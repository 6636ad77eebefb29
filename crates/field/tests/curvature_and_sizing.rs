//! Curvature, salient directions and sizes against surfaces whose answer is known.

mod common;

use common::plate;
use quadloom_field::{
    CrossField, CurvatureSizing, FieldConstraints, FieldOptions, SalientOptions, SizeField, SoftDirection, Transport,
    constraints::cross_distance, curvature_at, local_feature_size, salient_directions, solve_cross_field,
};
use quadloom_mesh::metric::{FaceFrame, edge_lengths, face_areas};
use quadloom_mesh::{DVec3, FaceId, FaceMap, Progress, TriMesh, VertexMap, shapes};

fn centre(mesh: &TriMesh, f: FaceId) -> DVec3 {
    mesh.face_vertices(f).into_iter().map(|v| mesh.position(v)).sum::<DVec3>() / 3.0
}

#[test]
fn a_sphere_is_curved_alike_everywhere() {
    let mesh = shapes::sphere(2.0, 4);
    let curvature = curvature_at(&mesh, 0.5, &Progress::none()).unwrap();
    for (f, c) in curvature.iter() {
        assert!((c.max - 0.5).abs() < 0.05 && (c.min - 0.5).abs() < 0.08, "face {f}: {c:?}");
    }
}

#[test]
fn a_cylinder_is_curved_around_its_axis_only() {
    let mesh = shapes::cylinder(0.5, 4.0, 48, 60);
    let options = SalientOptions::new(&mesh, 0.3);
    let curvature = curvature_at(&mesh, 0.2, &Progress::none()).unwrap();
    let salient = salient_directions(&mesh, &options, &Progress::none()).unwrap();
    let axis = (0..3).map(|k| DVec3::AXES[k]).find(|&a| mesh.faces().all(|f| mesh.face_normal(f).dot(a).abs() < 0.1));
    let axis = axis.unwrap();
    let inside: Vec<FaceId> = {
        let (low, high) = mesh.bounding_box();
        let middle = 0.5 * (low + high);
        mesh.faces().filter(|&f| (centre(&mesh, f) - middle).dot(axis).abs() < 1.2).collect()
    };
    assert!(inside.len() > 1000);
    for f in inside {
        let c = curvature[f];
        assert!((c.max.abs() - 2.0).abs() < 0.2 && c.min.abs() < 0.1, "face {f}: {c:?}");
        let around = FaceFrame::of(&mesh, f).direction(c.angle);
        assert!(around.dot(axis).abs() < 0.1, "face {f}: {around}");
        let direction = salient[f].unwrap_or_else(|| panic!("face {f} has no salient direction"));
        assert!(cross_distance(direction.angle, c.angle) < 0.1);
    }
}

#[test]
fn nothing_is_salient_on_a_sphere_or_a_plane() {
    for mesh in [shapes::sphere(1.0, 4), plate(20, 0.0)] {
        let salient = salient_directions(&mesh, &SalientOptions::new(&mesh, 0.2), &Progress::none()).unwrap();
        assert_eq!(salient.values().iter().flatten().count(), 0);
    }
}

fn torus_field(mesh: &TriMesh, constraints: &FieldConstraints) -> CrossField {
    let (transport, length) = (Transport::of(mesh), edge_lengths(mesh));
    let options = FieldOptions::default();
    solve_cross_field(mesh, &transport, &length, constraints, &options, &Progress::none()).unwrap().0
}

#[test]
fn a_free_torus_turns_to_its_salient_directions() {
    let mesh = shapes::torus(1.0, 0.2, 90, 18);
    let salient = salient_directions(&mesh, &SalientOptions::new(&mesh, 0.12), &Progress::none()).unwrap();
    assert!(salient.values().iter().flatten().count() > mesh.face_count() / 2);
    let mut constraints = FieldConstraints::none(&mesh);
    constraints.preferred = salient.map(|s| s.map(|s| SoftDirection { angle: s.angle, weight: 1.0 }));
    let field = torus_field(&mesh, &constraints);
    let off: f64 = salient.iter().filter_map(|(f, s)| s.map(|s| cross_distance(s.angle, field.angle[f]))).sum();
    assert!(off / (mesh.face_count() as f64) < 0.06, "mean deviation {}", off / mesh.face_count() as f64);
    assert!(field.singularities(&mesh, &Transport::of(&mesh)).is_empty());
}

#[test]
fn sizes_ask_for_the_wanted_number_of_quads() {
    let mesh = shapes::torus(1.0, 0.3, 60, 20);
    let area = face_areas(&mesh, &edge_lengths(&mesh));
    let field = torus_field(&mesh, &FieldConstraints::none(&mesh));
    let curvature = curvature_at(&mesh, 0.2, &Progress::none()).unwrap();
    let sizing = CurvatureSizing { tolerance: 0.002, shortest: 0.02, longest: 0.5, anisotropy: 1.0 };
    let density = VertexMap::from_fn(mesh.vertex_count(), |v| if mesh.position(v).x > 0.0 { 4.0 } else { 1.0 });
    for size in [
        SizeField::uniform(mesh.face_count(), 7.0),
        SizeField::by_curvature(&field, &curvature, &sizing),
        SizeField::by_density(&mesh, &density, 0.01).graded(&mesh, &field, 0.3),
    ] {
        let size = size.normalized(&area, 1234.0);
        assert!((size.quads(&area) - 1234.0).abs() < 1e-6);
        assert_eq!(size.first_defect(), None);
    }
    let dense = SizeField::by_density(&mesh, &density, 0.01);
    let half = |side: f64| {
        let faces: Vec<FaceId> = mesh.faces().filter(|&f| side * centre(&mesh, f).x > 0.1).collect();
        faces.iter().map(|&f| area[f] / (dense.u[f] * dense.v[f])).sum::<f64>()
            / faces.iter().map(|&f| area[f]).sum::<f64>()
    };
    assert!((half(1.0) / half(-1.0) - 4.0).abs() < 0.05);
}

#[test]
fn graded_sizes_grow_slowly_and_only_shrink() {
    let mesh = plate(24, 0.1);
    let field = torus_field(&mesh, &FieldConstraints::none(&mesh));
    let mut size = SizeField::uniform(mesh.face_count(), 1.0);
    size.u.values_mut()[17] = 0.05;
    let graded = size.graded(&mesh, &field, 0.4);
    for h in mesh.half_edges() {
        let Some(t) = mesh.twin(h) else { continue };
        let (f, g) = (mesh.face(h), mesh.face(t));
        let swapped = field.matching(&mesh, h) % 2 == 1;
        let (u, v) = if swapped { (&graded.v, &graded.u) } else { (&graded.u, &graded.v) };
        let limit = 0.4 * centre(&mesh, f).distance(centre(&mesh, g)) + 1e-12;
        assert!(u[g] <= graded.u[f] + limit && v[g] <= graded.v[f] + limit);
    }
    for f in mesh.faces() {
        assert!(graded.u[f] <= size.u[f] && graded.v[f] <= size.v[f]);
        // Without singularities the short length stays on its own axis, whatever the axis is called in a face.
        assert_eq!(graded.u[f].max(graded.v[f]), 1.0, "face {f}");
    }
    assert_eq!(graded.u.values()[17], 0.05);
    assert!(graded.u.values().iter().chain(graded.v.values()).filter(|&&h| h < 1.0).count() > 20);
}

/// On a flat annulus with radial crosses the lengths that fit are proportional to the radius (log-polar map).
#[test]
fn the_curl_of_polar_crosses_goes_with_lengths_proportional_to_the_radius() {
    let (rings, around) = (24u32, 96u32);
    let radius = |i: u32| 1.0 + 2.0 * f64::from(i) / f64::from(rings);
    let mut points = Vec::new();
    let mut faces = Vec::new();
    for i in 0..=rings {
        for j in 0..around {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(j) / f64::from(around)).sin_cos();
            points.push(radius(i) * DVec3::new(cos, sin, 0.0));
            let id = |i: u32, j: u32| i * around + j % around;
            if i < rings {
                let (p, q, r, s) = (id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1));
                faces.extend([[p, q, r], [p, r, s]]);
            }
        }
    }
    let mesh = TriMesh::new(points, &faces).unwrap();
    let (transport, length) = (Transport::of(&mesh), edge_lengths(&mesh));
    let radial = FaceMap::from_fn(mesh.face_count(), |f| centre(&mesh, f));
    let field = CrossField::from_directions(&mesh, &radial).unwrap();
    let size = SizeField::uniform(mesh.face_count(), 0.1)
        .curl_corrected(&mesh, &transport, &length, &field, 1.0, 10.0)
        .unwrap();
    let ratios: Vec<f64> = mesh.faces().map(|f| size.u[f] / centre(&mesh, f).length()).collect();
    let (low, high) = ratios.iter().fold((f64::INFINITY, 0f64), |(l, h), &r| (l.min(r), h.max(r)));
    assert!(high / low < 1.05, "length over radius between {low} and {high}");
    assert_eq!(size.u, size.v);
}

#[test]
fn the_feature_size_of_a_sphere_is_its_radius_and_of_a_cylinder_too() {
    let sphere = shapes::sphere(1.5, 4);
    for (v, r) in local_feature_size(&sphere, 0.01, 100.0, &Progress::none()).unwrap().iter() {
        assert!((1.1..1.55).contains(r), "vertex {v}: {r}");
    }
    let torus = shapes::torus(2.0, 0.3, 80, 24);
    let radius = local_feature_size(&torus, 0.01, 100.0, &Progress::none()).unwrap();
    let mean = radius.values().iter().sum::<f64>() / radius.len() as f64;
    assert!((mean - 0.3).abs() < 0.03, "{mean}");
}

#[test]
fn curvature_asks_for_two_lengths_on_a_cylinder() {
    let mesh = shapes::cylinder(0.5, 4.0, 48, 60);
    let mut constraints = FieldConstraints::none(&mesh);
    let salient = salient_directions(&mesh, &SalientOptions::new(&mesh, 0.3), &Progress::none()).unwrap();
    constraints.add_salient(&salient, None);
    let field = torus_field(&mesh, &constraints);
    let curvature = curvature_at(&mesh, 0.2, &Progress::none()).unwrap();
    let sizing = CurvatureSizing { tolerance: 0.01, shortest: 0.01, longest: 2.0, anisotropy: 1.0 };
    let size = SizeField::by_curvature(&field, &curvature, &sizing);
    let expected = (8.0 * 0.01 / 2.0f64).sqrt();
    let hits = mesh
        .faces()
        .filter(|&f| {
            let (short, long) = (size.u[f].min(size.v[f]), size.u[f].max(size.v[f]));
            (short - expected).abs() < 0.1 * expected && long > 3.0 * expected
        })
        .count();
    assert!(hits > mesh.face_count() * 8 / 10, "{hits} of {}", mesh.face_count());
    let square = SizeField::by_curvature(&field, &curvature, &CurvatureSizing { anisotropy: 0.0, ..sizing });
    assert_eq!(square.u, square.v);
}
