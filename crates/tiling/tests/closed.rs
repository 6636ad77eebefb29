//! Closed generated surfaces: numbers of sides and tiles, definitions, and re-gluing by an independent count.

use quadloom_mesh::{Progress, Summary, TriMesh, shapes};
use quadloom_tiling::{CutOptions, EdgeCosts, Method, QuadOptions, SearchMode, Tiling, cut_to_disk};

mod common;

fn surfaces() -> Vec<(String, TriMesh)> {
    let mut all = vec![("torus".to_owned(), shapes::torus(2.0, 0.7, 24, 12))];
    for genus in 1..=4 {
        for level in 1..=2 {
            all.push((format!("genus {genus}, level {level}"), shapes::smooth_genus(genus, level)));
        }
    }
    all
}

fn check(what: &str, mesh: &TriMesh, tiling: &Tiling) {
    let defects = tiling.check();
    assert!(defects.is_empty(), "{what}: {:?}", &defects[..defects.len().min(5)]);
    common::check_gluing(what, tiling);
    common::check_refinement(what, mesh, tiling);
    assert!(Summary::of(mesh).same_topology(&Summary::of(tiling.mesh())), "{what}: topology changed");
}

#[test]
fn every_method_gives_one_even_polygon_and_quadrangles() {
    for (name, mesh) in surfaces() {
        let genus = Summary::of(&mesh).genus as usize;
        let costs = EdgeCosts::euclidean(&mesh);
        for method in [Method::Shortest, Method::SinglePoint, Method::Intermediate] {
            for search in [SearchMode::Fast, SearchMode::Exact] {
                let what = format!("{name}, {method:?}, {search:?}");
                let progress = Progress::none();
                let options = CutOptions { search, base: None };
                let mut cutting = cut_to_disk(&mesh, &costs, method, &options, &progress).expect(&what);
                let tiling = cutting.tiling().unwrap();
                check(&what, &mesh, &tiling);
                assert_eq!(tiling.complex.cells.len(), 1, "{what}");
                let sides = tiling.complex.cells.values()[0].polygon().expect("a disk").len();
                let (least, most) = match method {
                    Method::Shortest => (4 * genus, 12 * genus - 6),
                    Method::SinglePoint => (4 * genus, 4 * genus),
                    Method::Intermediate => (4 * genus, 6 * genus - 2),
                };
                assert!(sides.is_multiple_of(2) && least <= sides && sides <= most, "{what}: {sides} sides");
                if method == Method::SinglePoint {
                    assert_eq!(tiling.complex.nodes, 1, "{what}");
                }
                let report = cutting.quadrangulate(&QuadOptions { search, ..Default::default() }).expect(&what);
                assert_eq!(report.quadrangles, sides / 2 - 1, "{what}");
                for (step, tiling) in cutting.steps().unwrap().iter().enumerate() {
                    check(&format!("{what}, step {step}"), &mesh, tiling);
                }
                let quads = cutting.tiling().unwrap();
                assert_eq!(quads.complex.cells.len(), report.quadrangles, "{what}");
                assert!(
                    quads.complex.cells.values().iter().all(|c| c.polygon().is_some_and(|s| s.len() == 4)),
                    "{what}"
                );
            }
        }
    }
}
