//! Maps in space: the drawn map is the source, nothing meets itself, and the rotations are those of the solid.
//!
//! In: maps of the catalogue. Holds: counts, closedness, exact self-intersection test, named groups, single precision.

use quadloom_mesh::{Progress, intersects_itself};
use quadloom_regular_maps::{RegularMap, catalogue};
use quadloom_tubification::realize::{Realization, RealizeOptions, realize};
use quadloom_tubification::{DrawOptions, EdgeStyle};

fn realized(name: &str, options: &RealizeOptions) -> (RegularMap, Realization) {
    let map = catalogue::find(name).unwrap().map().unwrap();
    let found = realize(&map, options, &Progress::none()).unwrap();
    (map, found)
}

fn check(name: &str, map: &RegularMap, found: &Realization, size: f64) {
    let counts = [found.counts.vertices, found.counts.edges, found.counts.faces];
    assert_eq!(counts, [map.vertex_count(), map.edge_count(), map.face_count()], "{name}");
    let mesh = &found.drawing.mesh;
    assert!(found.intersections.is_empty() && !intersects_itself(mesh), "{name}");
    assert!(mesh.edges().all(|e| !mesh.is_boundary_edge(e)), "{name}");
    let (low, high) = mesh.bounding_box();
    assert!(((high - low).max_element() - size).abs() < 1e-4, "{name}");
    // Files of any format hold these very numbers.
    assert!(mesh.positions().values().iter().all(|p| p.as_vec3().as_dvec3() == *p), "{name}");
}

#[test]
fn maps_in_space_are_what_they_should_be() {
    for (name, target, group) in [
        ("R2.1", "{2,3}_6", "D3"),
        ("R3.1", "{3,3}_4", "T"),
        ("R5.4", "{4,3}_6", "O"),
        ("R4.3", "{6,3}_6", "D3"),
        ("R5.8", "{5,10}_2", "D5"),
    ] {
        let options = RealizeOptions::default();
        let (map, found) = realized(name, &options);
        assert_eq!(found.matched.target.type_name(), target, "{name}");
        assert_eq!(found.tubes.rotations.group.to_string(), group, "{name}");
        check(name, &map, &found, options.size);
    }
}

/// Lines of the map run side by side along tubes with a half twist; chords of one crossed the other.
#[test]
fn thin_triangles_on_twisted_tubes_do_not_meet() {
    let options = RealizeOptions { size: 30.0, ..RealizeOptions::default() };
    let (map, found) = realized("R6.2", &options);
    assert!(!found.matched.target.is_orientable());
    check("R6.2", &map, &found, 30.0);
}

/// Where lines of the map are close together, ridges of the asked height have no room.
#[test]
fn ridges_are_lower_where_they_have_no_room() {
    let draw = |height| DrawOptions { edges: EdgeStyle::Relief(0.12), height, ..DrawOptions::default() };
    let options = RealizeOptions { draw: draw(0.12), ..RealizeOptions::default() };
    let (map, found) = realized("R3.1", &options);
    check("R3.1", &map, &found, options.size);
    let asked = 0.12 * found.tubes.surface.radius() * found.scale;
    assert!((found.relief - asked).abs() < 1e-12);
    let (map, found) = realized("R5.8", &options);
    check("R5.8", &map, &found, options.size);
    let asked = 0.12 * found.tubes.surface.radius() * found.scale;
    assert!(found.relief > 0.0 && found.relief < 0.5 * asked);
}
