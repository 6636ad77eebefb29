//! Cuts that would touch are apart: on random surfaces with many handles, by every method.

use quadloom_mesh::{Progress, Summary, shapes};
use quadloom_tiling::{CutOptions, EdgeCosts, Method, QuadOptions, SearchMode, cut_into_cylinders, cut_to_disk};
use std::collections::BTreeSet;

mod common;

/// No two cuts share an edge, or a vertex that is not an end of one of them; no cut meets itself.
fn check_apart(what: &str, cuts: &[Vec<u32>]) {
    let (mut edges, mut inner) = (BTreeSet::new(), BTreeSet::new());
    for path in cuts {
        for p in path.windows(2) {
            assert!(edges.insert((p[0].min(p[1]), p[0].max(p[1]))), "{what}: an edge is shared");
        }
        for &v in &path[1..path.len() - 1] {
            assert!(inner.insert(v), "{what}: inner vertex {v} is shared");
        }
    }
}

#[test]
fn cuts_share_no_edge_and_no_inner_vertex() {
    let mut handles = 0;
    for seed in 0..100 {
        let mesh = shapes::random_genus(seed);
        let genus = Summary::of(&mesh).genus;
        handles += genus;
        let costs = EdgeCosts::euclidean(&mesh);
        let progress = Progress::none();
        for method in [Method::Shortest, Method::SinglePoint, Method::Intermediate] {
            let search = if seed % 3 == 0 { SearchMode::Exact } else { SearchMode::Fast };
            let what = format!("seed {seed}, genus {genus}, {method:?}, {search:?}");
            let options = CutOptions { search, base: None };
            let mut cutting = cut_to_disk(&mesh, &costs, method, &options, &progress).expect(&what);
            let report = cutting.quadrangulate(&QuadOptions { search, ..Default::default() }).expect(&what);
            let paths: Vec<Vec<u32>> = cutting.cuts().iter().map(|c| c.path().iter().map(|v| v.0).collect()).collect();
            check_apart(&what, &paths);
            let tiling = cutting.tiling().unwrap();
            assert_eq!(tiling.check(), [], "{what}");
            common::check_gluing(&what, &tiling);
            common::check_refinement(&what, &mesh, &tiling);
            assert_eq!(tiling.complex.cells.len(), report.quadrangles);
            if method == Method::SinglePoint {
                assert_eq!(report.quadrangles as i64, 2 * genus - 1, "{what}");
            }
        }
        if genus > 1 && seed % 5 == 0 {
            let what = format!("seed {seed}, genus {genus}, cylinders");
            let tiling =
                cut_into_cylinders(&mesh, &costs, &CutOptions::default(), &progress).expect(&what).tiling().unwrap();
            assert_eq!(tiling.check(), [], "{what}");
            common::check_gluing(&what, &tiling);
            common::check_refinement(&what, &mesh, &tiling);
        }
    }
    assert!(handles > 300, "these surfaces have few handles: {handles}");
}
