//! Skeletons of maps in space.
//!
//! In: presentations. Holds: each skeleton passes its check, has the stated clearance and the stated symmetry.

use quadloom_regular_maps::skeleton::{clearance, spherical, torus};
use quadloom_regular_maps::{CosetLimit, Presentation, RegularMap};

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
