//! Tube surfaces around skeletons of maps.
//!
//! In: presentations. Holds: counts, closedness, orientation, sides that fit bit by bit, no self-intersection, symmetry.

use quadloom_mesh::{DVec3, FaceId, Progress, QuadMesh, topology};
use quadloom_regular_maps::{CosetLimit, FlagId, Presentation, Reflection, RegularMap};
use quadloom_tubification::rotations;
use quadloom_tubification::skeleton::{self, RelaxOptions, Skeleton, upright_flags};
use quadloom_tubification::tubes::{TubeError, TubeOptions, TubeSurface, build_without_intersections, choose_radius};

fn map(text: &str) -> RegularMap {
    RegularMap::from_presentation(&Presentation::parse(text).unwrap(), CosetLimit::default()).unwrap()
}

fn skeleton_of(map: &RegularMap) -> Skeleton {
    let relaxed = || skeleton::relaxed(map, &RelaxOptions::default(), &Progress::none()).unwrap();
    skeleton::exact(map).unwrap_or_else(relaxed)
}

fn coarse() -> TubeOptions {
    TubeOptions { levels: 2, ..TubeOptions::default() }
}

/// Six times the enclosed volume.
fn volume(mesh: &QuadMesh) -> f64 {
    let centre = |f: FaceId| mesh.face_vertices(f).map(|v| mesh.position(v)).iter().sum::<DVec3>() / 4.0;
    mesh.faces().map(|f| 2.0 * mesh.vector_area(f).dot(centre(f))).sum()
}

fn check_surface(map: &RegularMap, surface: &TubeSurface) {
    let [v, e] = [map.vertex_count(), map.edge_count()];
    assert_eq!(surface.cage_counts(), [2 * v + 2 * e, 8 * e, 4 * e], "{map}");
    let mesh = surface.mesh();
    assert!(mesh.edges().all(|e| !mesh.is_boundary_edge(e)), "{map} has a boundary");
    assert_eq!(topology::euler_characteristic(mesh), 2 * v as i64 - 2 * e as i64, "{map}");
    assert_eq!(topology::component_summaries(mesh).len(), 1, "{map}");
    assert!(volume(mesh) > 0.0, "{map} is inside out");
    let [along, around] = surface.cells();
    assert_eq!(mesh.face_count(), map.order() * along * around);
    for face in mesh.faces() {
        let [i, j] = surface.cell_of_face(face);
        let flag = surface.flag_of_face()[face];
        let corner = surface.point(flag, i as f64 / along as f64, j as f64 / around as f64);
        assert!(corner.distance(mesh.position(mesh.face_vertices(face)[0])) < 1e-9 * surface.radius());
    }
    check_sides(map, surface);
}

/// Where quarter-tubes meet, both say the same.
fn check_sides(map: &RegularMap, surface: &TubeSurface) {
    let same = |a: (FlagId, f64, f64), b: (FlagId, f64, f64)| {
        assert_eq!(surface.point(a.0, a.1, a.2), surface.point(b.0, b.1, b.2), "{map} {a:?} {b:?}");
        assert_eq!(surface.normal(a.0, a.1, a.2), surface.normal(b.0, b.1, b.2), "{map} {a:?} {b:?}");
    };
    for flag in map.flags() {
        let [r0, r1, r2] = Reflection::ALL.map(|by| map.reflect(flag, by));
        for t in [0.0, 1e-17, 0.1, 0.25, 1.0 / 3.0, 0.5, 0.7, 0.999, 1.0] {
            same((flag, 0.0, t), (r1, 0.0, 1.0 - t));
            same((flag, 1.0, t), (r0, 1.0, 1.0 - t));
            same((flag, t, 0.0), (r2, t, 1.0));
        }
    }
}

/// The poles of upright flags are where normals point, and normals point outwards.
fn check_poles(map: &RegularMap, skeleton: &Skeleton, surface: &TubeSurface) {
    let upright = upright_flags(map);
    for flag in map.flags() {
        let vertex = map.vertex(flag).0 as usize;
        let normal = skeleton.normals[vertex] * if upright[flag] { 1.0 } else { -1.0 };
        let to = surface.point(flag, 0.0, 0.0) - skeleton.positions[vertex];
        assert!(to.normalize().distance(normal) < 1e-9 && to.length() > 0.7 * surface.radius(), "{map} {flag}");
        assert!(surface.normal(flag, 0.0, 0.0).dot(normal) > 0.5, "{map} {flag}");
    }
}

#[test]
fn maps_on_the_sphere() {
    let types = [(3, 3), (4, 3), (3, 4), (5, 3), (3, 5), (3, 2), (7, 2)];
    let lanterns = [3, 4, 5, 8, 12, 25].map(|n| (2, n));
    for (p, q) in types.into_iter().chain(lanterns) {
        let map = map(&format!("R^{p}, S^{q}"));
        let skeleton = skeleton_of(&map);
        let surface = build_without_intersections(&map, &skeleton, &coarse()).unwrap();
        check_surface(&map, &surface);
        check_poles(&map, &skeleton, &surface);
        assert!(surface.radius() > 0.6 * choose_radius(&map, &skeleton), "{map} {}", surface.radius());
        let found = rotations::measure(&map, |flag| samples(&surface, flag));
        assert_eq!(found.elements.len(), map.order() / 2, "{map}");
    }
}

fn samples(surface: &TubeSurface, flag: FlagId) -> Vec<DVec3> {
    [[0.0, 0.0], [0.25, 0.5], [0.625, 0.25], [1.0, 0.5]].map(|[u, v]| surface.point(flag, u, v)).to_vec()
}

#[test]
fn maps_on_the_torus_and_others() {
    for text in [
        "R^4, S^4, (R*S^-1)^4",
        "R^6, S^3, (R*T*S)^6",
        "R^3, S^6, (R*T*S)^6",
        "R^5, S^10, R*S*R^2*S*R^-1",
        "R^4, S^3, (R*T*S)^3",
        "R^3, S^5, (R*T*S)^5",
    ] {
        let map = map(text);
        let skeleton = skeleton_of(&map);
        let surface = build_without_intersections(&map, &skeleton, &coarse()).unwrap();
        check_surface(&map, &surface);
        check_poles(&map, &skeleton, &surface);
        // Where edges part slowly, junctions take most of a tube unless it is thin.
        assert!(surface.radius() > 0.2 * choose_radius(&map, &skeleton), "{map} {}", surface.radius());
    }
}

/// A rotation of space that keeps the tetrahedron's vertices permutes the vertices of its surface.
#[test]
fn rotations_of_the_tetrahedron_permute_the_vertices() {
    let map = map("R^3, S^3");
    let skeleton = skeleton_of(&map);
    let surface = TubeSurface::build(&map, &skeleton, &coarse()).unwrap();
    let points = surface.mesh().positions().values();
    let images = |k: usize| {
        let (axis, from) = (skeleton.positions[k], skeleton.positions[(k + 1) % 4]);
        let turn = glam::DQuat::from_axis_angle(axis, std::f64::consts::TAU / 3.0);
        assert!(skeleton.positions.iter().any(|p| p.distance(turn * from) < 1e-9));
        points.iter().map(move |&p| turn * p)
    };
    for image in [0, 1].into_iter().flat_map(images) {
        assert!(points.iter().any(|p| p.distance(image) < 1e-9), "{image}");
    }
}

/// Half-way along a straight tube it is round and has the asked radius; normals point away from its edge.
#[test]
fn tubes_are_round() {
    let map = map("R^4, S^3");
    let skeleton = skeleton_of(&map);
    let options = TubeOptions { radius: Some(0.1), ..TubeOptions::default() };
    let surface = TubeSurface::build(&map, &skeleton, &options).unwrap();
    for flag in map.flags() {
        let line = skeleton.outward(&map, flag);
        let middle = line[0].midpoint(line[line.len() - 1]);
        for v in [0.0, 0.3, 0.5, 0.9] {
            let out = surface.point(flag, 1.0, v) - middle;
            assert!((out.length() - 0.1).abs() < 1e-4, "{}", out.length());
            assert!(surface.normal(flag, 1.0, v).dot(out) > 0.1 * 0.999);
        }
    }
}

#[test]
fn what_cannot_be_built_is_refused() {
    let map = map("R^4, S^3");
    let skeleton = skeleton_of(&map);
    let build = |options: TubeOptions| TubeSurface::build(&map, &skeleton, &options);
    for radius in [-1.0, 0.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(build(TubeOptions { radius: Some(radius), ..coarse() }), Err(TubeError::Option(..))));
    }
    assert!(matches!(build(TubeOptions { radius: Some(1.0), ..coarse() }), Err(TubeError::TooThick(_))));
    assert!(matches!(build(TubeOptions { softness: 1.0, ..coarse() }), Err(TubeError::Option(..))));
    let mut broken = skeleton.clone();
    broken.normals[0] = -broken.normals[0];
    assert!(matches!(TubeSurface::build(&map, &broken, &coarse()), Err(TubeError::Skeleton(_))));
}

/// Next to the poles of a junction with uneven edges, points on the corner lines were another curve than those beside them.
#[test]
fn surfaces_are_continuous_at_corners_of_junctions() {
    let bouquet = quadloom_regular_maps::catalogue::find("R2.4").unwrap().map().unwrap();
    for map in [map("R^3, S^3"), map("R^3, S^5, (R*S*T)^5"), bouquet] {
        let skeleton = skeleton_of(&map);
        let surface = build_without_intersections(&map, &skeleton, &coarse()).unwrap();
        let near = 1e-7;
        for flag in map.flags() {
            for k in 0..=64 {
                let v = f64::from(k) / 64.0;
                for (u, beside) in [(0.0, near), (1.0, 1.0 - near)] {
                    let jump = surface.point(flag, u, v).distance(surface.point(flag, beside, v));
                    assert!(jump < 1e-5, "{map} {flag} {u} {v} {jump}");
                }
            }
        }
    }
}
