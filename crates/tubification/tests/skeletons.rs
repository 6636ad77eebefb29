//! Skeletons of maps in space.
//!
//! In: presentations. Holds: each skeleton passes its check, has the stated clearance and the stated symmetry.

use quadloom_mesh::{Id, Progress};
use quadloom_regular_maps::{CosetLimit, Presentation, RegularMap};
use quadloom_tubification::skeleton::{
    PointGroup, RelaxOptions, Relaxed, SkeletonError, Symmetry, clearance, relax, spherical, symmetries, torus,
};
use quadloom_tubification::skeleton::{edge_flags, first_flags, starts_here, upright_flags};

fn map(text: &str) -> RegularMap {
    RegularMap::from_presentation(&Presentation::parse(text).unwrap(), CosetLimit::default()).unwrap()
}

#[test]
fn maps_on_the_sphere_are_convex_solids_and_lanterns() {
    for (p, q, least) in [
        (3, 3, 0.2),
        (4, 3, 0.2),
        (3, 4, 0.2),
        (5, 3, 0.14),
        (3, 5, 0.13),
        (2, 3, 0.6),
        (2, 12, 0.18),
        (2, 50, 0.04),
        (3, 2, 0.4),
        (50, 2, 0.03),
    ] {
        let map = map(&format!("R^{p}, S^{q}"));
        let skeleton = spherical(&map).unwrap();
        skeleton.check(&map).unwrap_or_else(|defect| panic!("{map}: {defect}"));
        let found = clearance(&map, &skeleton);
        assert!(found > least, "{map}: {found}");
    }
}

/// {4, 4}, {6, 3} and {3, 6} by the translation that identifies: t or (t, t).
fn on_torus(p: usize, t: usize, skew: bool) -> String {
    match (p, skew) {
        (4, false) => format!("R^4, S^4, (R*S^-1)^{t}"),
        (4, true) => format!("R^4, S^4, (R*T*S)^{}", 2 * t),
        (6, false) => format!("R^6, S^3, (R*T*S)^{}", 2 * t),
        (6, true) => format!("R^6, S^3, (R^2*S^-1)^{}", 2 * t),
        (_, false) => format!("R^3, S^6, (R*T*S)^{}", 2 * t),
        (_, true) => format!("R^3, S^6, (S^2*R^-1)^{}", 2 * t),
    }
}

#[test]
fn maps_on_the_torus_lie_on_a_torus() {
    for p in [4, 6, 3] {
        for (t, skew) in [(1, false), (1, true), (2, false), (2, true), (3, false), (3, true), (6, false)] {
            let map = map(&on_torus(p, t, skew));
            let skeleton = torus(&map).unwrap_or_else(|| panic!("{map} {} {}", map.genus(), map.is_orientable()));
            skeleton.check(&map).unwrap_or_else(|defect| panic!("{map}: {defect}"));
            let found = clearance(&map, &skeleton);
            // A torus of E tubes has an area, so radii fall with the square root of E.
            let least = 0.4 / (map.edge_count() as f64).sqrt();
            assert!(found > least, "{map} with {} edges: {found}", map.edge_count());
        }
    }
}

fn dual(text: &str) -> RegularMap {
    let presentation = Presentation::parse(text).unwrap().dual();
    RegularMap::from_presentation(&presentation, CosetLimit::default()).unwrap()
}

/// Largest distance of a point from where the rotation of an automorphism should take it; normals included.
fn asymmetry(map: &RegularMap, found: &Relaxed) -> f64 {
    let skeleton = &found.skeleton;
    let upright = upright_flags(map);
    let mut worst = 0.0f64;
    for (h, rotation) in &found.symmetry.elements {
        let image = map.automorphism(*h);
        for (vertex, flag) in first_flags(map) {
            let there = map.vertex(image[flag.index()]).index();
            let sign = if upright[image[flag.index()]] { 1.0 } else { -1.0 };
            let normal = *rotation * skeleton.normals[vertex.index()] * sign;
            worst = worst.max(normal.distance(skeleton.normals[there]));
            let position = *rotation * skeleton.positions[vertex.index()];
            worst = worst.max(position.distance(skeleton.positions[there]));
        }
        for (edge, flag) in edge_flags(map) {
            let there = image[flag.index()];
            let mut points = skeleton.edges[map.edge(there).index()].clone();
            if !starts_here(map, there) {
                points.reverse();
            }
            let pairs = skeleton.edges[edge.index()].iter().zip(&points);
            worst = pairs.map(|(a, b)| (*rotation * *a).distance(*b)).fold(worst, f64::max);
        }
    }
    worst
}

fn relaxes(map: &RegularMap, options: &RelaxOptions, group: &str, least: f64) {
    let found = relax(map, options, &Progress::none()).unwrap_or_else(|error| panic!("{map}: {error}"));
    found.skeleton.check(map).unwrap_or_else(|defect| panic!("{map}: {defect}"));
    let measured = clearance(map, &found.skeleton);
    let name = found.symmetry.group.to_string();
    assert!(measured >= least && (found.clearance - measured).abs() < 1e-12, "{map}: {name} {measured}");
    assert!(group.is_empty() || group == name, "{map}: {name} {measured}");
    let error = asymmetry(map, &found);
    assert!(error < 1e-12, "{map}: {name} {error:e}");
}

fn named(group: PointGroup) -> RelaxOptions {
    RelaxOptions { symmetry: Symmetry::Named(group), starts: 3, ..RelaxOptions::default() }
}

#[test]
fn solids_relax_to_their_full_symmetry() {
    let options = RelaxOptions { starts: 2, symmetries: 3, ..RelaxOptions::default() };
    for (p, q, group, least) in
        [(3, 3, "T", 0.2), (4, 3, "O", 0.2), (3, 4, "O", 0.2), (5, 3, "I", 0.13), (3, 5, "I", 0.12)]
    {
        relaxes(&map(&format!("R^{p}, S^{q}")), &options, group, least);
    }
}

#[test]
fn double_covers_of_solids_have_their_rotations() {
    use PointGroup::{Dihedral, Icosahedral, Octahedral};
    let cube = "R^3, S^8, R*S*R^2*S*R^2*S^2*R^2*S*R^2*S*R^-1";
    let octahedron = "R^4, S^6, R^3*S*R^2*S*R^3*S*R^2*S";
    let dodecahedron = "R^3, S^10, R*S*R^2*S*R^2*S*R^2*S^2*R^2*S*R^2*S*R^2*S*R^-1";
    let icosahedron = "R^5, S^6, R^3*S*R^2*S*R^3*S*R^2*S";
    for (text, group, least) in [
        (cube, Dihedral(3), 0.06),
        (cube, Dihedral(8), 0.1),
        (octahedron, Octahedral, 0.1),
        (dodecahedron, Icosahedral, 0.06),
        (icosahedron, Icosahedral, 0.08),
    ] {
        relaxes(&dual(text), &named(group), &group.to_string(), least);
    }
}

#[test]
fn maps_without_a_model_relax() {
    let options = RelaxOptions { starts: 4, ..RelaxOptions::default() };
    relaxes(&map("R^5, S^10, R*S*R^2*S*R^-1"), &options, "", 0.14);
    relaxes(&map("R^3, S^4, (R*T*S)^3"), &options, "", 0.15);
    relaxes(&map("R^5, S^3, (R*T*S)^5"), &options, "", 0.08);
    relaxes(&map("R^3, S^5, (R*T*S)^5"), &options, "", 0.08);
    relaxes(&dual("R^10, S^15, R^3*S*R^-1*S, R*S*R^2*S^2*R^-5"), &options, "", 0.09);
    relaxes(&map("R^9, S^9, R*S*R^4*S*R^-3, R*S*R^2*S*R^2*S*R^-2"), &options, "", 0.06);
}

#[test]
fn large_maps_relax() {
    let options = RelaxOptions { starts: 1, symmetries: 6, steps: 600, ..RelaxOptions::default() };
    // As many edges as the targets of [Razafindrazaka2015] Fig. 9.21 have.
    for (p, t) in [(6, 7), (4, 9)] {
        let map = map(&on_torus(p, t, false));
        assert!(map.edge_count() > 140);
        relaxes(&map, &options, "", 0.01);
    }
}

#[test]
fn equal_options_give_equal_bytes() {
    let map = map("R^3, S^5, (R*T*S)^5");
    let options = RelaxOptions { starts: 2, symmetries: 2, steps: 200, ..RelaxOptions::default() };
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| relax(&map, &options, &Progress::none()).unwrap())
    };
    let (one, three) = (run(1), run(3));
    assert_eq!(one, three);
    assert_ne!(one.skeleton, relax(&map, &RelaxOptions { seed: 2, ..options }, &Progress::none()).unwrap().skeleton);
}

#[test]
fn what_cannot_be_had_is_named() {
    let tetrahedron = map("R^3, S^3");
    let error = relax(&tetrahedron, &named(PointGroup::Icosahedral), &Progress::none()).unwrap_err();
    assert!(matches!(error, SkeletonError::NoSymmetry { .. }), "{error}");
    let polygon = spherical(&map("R^5, S^2")).unwrap();
    assert_eq!(polygon.positions.len(), 5);
    let error = relax(&map("R^5, S^2"), &RelaxOptions::default(), &Progress::none()).unwrap_err();
    assert!(matches!(error, SkeletonError::Valence(_, 2)), "{error}");
    let stopped = Progress::none().with_time_limit(std::time::Duration::ZERO);
    let error = relax(&tetrahedron, &RelaxOptions::default(), &stopped).unwrap_err();
    assert!(matches!(error, SkeletonError::Cancelled(_)), "{error}");
}

#[test]
fn groups_of_rotations_are_faithful() {
    let cube = map("R^4, S^3");
    let found = symmetries(&cube, None, 8);
    assert_eq!(found[0].group, PointGroup::Octahedral);
    for imposed in &found {
        assert_eq!(imposed.elements.len(), imposed.group.order());
        for (g, a) in &imposed.elements {
            for (h, b) in &imposed.elements {
                let both = cube.product(*g, *h);
                let (_, c) = imposed.elements.iter().find(|(k, _)| *k == both).unwrap();
                assert!((*a * *b - *c).abs().to_cols_array().into_iter().all(|x| x < 1e-12));
            }
        }
    }
    for text in ["C7", "D2", "T", "O", "I"] {
        assert_eq!(text.parse::<PointGroup>().unwrap().to_string(), text);
    }
    assert!("D1".parse::<PointGroup>().is_err() && "X".parse::<PointGroup>().is_err());
}

#[test]
fn without_slope_edges_leave_in_the_plane_of_their_junction() {
    let map = map("R^5, S^3, (R*S*T)^5");
    for (slope, steepest) in [(0.0, 1e-9), (0.3, 0.26)] {
        let options = RelaxOptions { slope, symmetry: Symmetry::None, starts: 1, ..RelaxOptions::default() };
        let skeleton = relax(&map, &options, &Progress::none()).unwrap().skeleton;
        for (edge, flag) in edge_flags(&map) {
            let (line, normal) = (&skeleton.edges[edge.index()], skeleton.normals[map.vertex(flag).index()]);
            let leaving = (line[1] - line[0]).normalize();
            assert!(leaving.dot(normal).abs() < steepest, "{slope} {edge}");
        }
    }
}
