//! Maps of whole tilings: quadrangles fill the unit square without folds, and both sides of a cut agree.

use quadloom_mesh::{DVec2, HalfEdgeId, Progress, Summary, TriMesh, shapes};
use quadloom_tiling::maps::{MapMethod, MapOptions};
use quadloom_tiling::{
    ArcId, CutOptions, EdgeCosts, Method, OnFailure, QuadOptions, TileMaps, Tiling, cut_into_pants, cut_to_disk,
    map_tiles,
};
use std::collections::BTreeMap;

mod common;

fn quadrangles(mesh: &TriMesh, method: Method) -> Tiling {
    let (costs, progress) = (EdgeCosts::euclidean(mesh), Progress::none());
    let mut cutting = cut_to_disk(mesh, &costs, method, &CutOptions::default(), &progress).unwrap();
    cutting.quadrangulate(&QuadOptions::default()).unwrap();
    cutting.tiling().unwrap()
}

fn mapped(tiling: &Tiling, mesh: &TriMesh, method: MapMethod) -> TileMaps {
    map_tiles(tiling, mesh, method, &MapOptions::default(), OnFailure::MeanValue, &Progress::none()).unwrap()
}

fn surfaces() -> Vec<(TriMesh, Method)> {
    let mut all = vec![
        (shapes::torus(2.0, 0.7, 24, 12), Method::SinglePoint),
        (shapes::many_holes(12, 1500), Method::SinglePoint),
        (shapes::plate_with_holes(0.15), Method::Intermediate),
        (shapes::cylinder(1.0, 2.0, 24, 8), Method::Shortest),
    ];
    for genus in 1..=4 {
        all.push((shapes::genus_series(genus, 0), Method::SinglePoint));
        all.push((shapes::genus_series(genus, 0), Method::Shortest));
    }
    all
}

#[test]
fn quadrangles_fill_the_square_without_folds() {
    for (mesh, method) in surfaces() {
        let what = format!("genus {}, {method:?}", Summary::of(&mesh).genus);
        let maps = mapped(&quadrangles(&mesh, method), &mesh, MapMethod::MeanValue);
        assert!(maps.instead.is_empty());
        let tiling = &maps.tiling;
        assert_eq!(tiling.check(), [], "{what}");
        common::check_gluing(&what, tiling);
        common::check_refinement(&what, &mesh, tiling);
        let mut area = vec![0.0; tiling.complex.cells.len()];
        for f in tiling.mesh().faces() {
            let [a, b, c] = tiling.mesh().face_half_edges(f).map(|h| maps.uv[h]);
            let coord = |p: DVec2| robust::Coord { x: p.x, y: p.y };
            assert!(robust::orient2d(coord(a), coord(b), coord(c)) > 0.0, "{what}: face {f} folds");
            assert!([a, b, c].iter().all(|p| p.min_element() >= 0.0 && p.max_element() <= 1.0), "{what}");
            area[tiling.face_tile[f].0 as usize] += 0.5 * (b - a).perp_dot(c - a);
        }
        assert!(area.iter().all(|a| (a - 1.0).abs() < 1e-9), "{what}: {area:?}");
    }
}

/// How far along the unit square's side number `k` a point of it is.
fn along(k: usize, p: DVec2) -> f64 {
    let (t, off) = [(p.x, p.y), (p.y, 1.0 - p.x), (1.0 - p.x, 1.0 - p.y), (1.0 - p.y, p.x)][k];
    assert_eq!(off, 0.0, "a point of side {k} is off it: {p}");
    t
}

#[test]
fn both_sides_of_a_cut_have_the_same_parameters() {
    for (mesh, method) in surfaces() {
        let maps = mapped(&quadrangles(&mesh, method), &mesh, MapMethod::MeanValue);
        let tiling = &maps.tiling;
        let mut sides: BTreeMap<ArcId, Vec<Vec<f64>>> = BTreeMap::new();
        for cell in tiling.complex.cells.values() {
            for (k, &side) in cell.polygon().unwrap().iter().enumerate() {
                let half_edges: Vec<HalfEdgeId> = tiling.side_half_edges(side);
                let mut places: Vec<f64> = half_edges.iter().map(|&h| along(k, maps.uv[h])).collect();
                let last = tiling.mesh().next(half_edges[half_edges.len() - 1]);
                places.push(along(k, maps.uv[last]));
                assert!(places[0] == 0.0 && places.windows(2).all(|p| p[0] < p[1]) && places.ends_with(&[1.0]));
                if side.reversed {
                    places.reverse();
                    places.iter_mut().for_each(|t| *t = 1.0 - *t);
                }
                sides.entry(side.arc).or_default().push(places);
            }
        }
        let glued = sides.values().filter(|s| s.len() == 2).inspect(|s| assert_eq!(s[0], s[1])).count();
        assert!(glued > 0);
    }
}

#[test]
fn other_maps_are_fold_free_too_or_replaced() {
    let mesh = shapes::genus_series(2, 0);
    let tiling = quadrangles(&mesh, Method::SinglePoint);
    for method in [MapMethod::Conformal, MapMethod::AngleBased, MapMethod::Circles] {
        let maps = mapped(&tiling, &mesh, method);
        assert_eq!(maps.reports.len(), 3);
        for (tile, report) in maps.reports.iter().enumerate() {
            let replaced = maps.instead.iter().any(|(t, _)| t.0 as usize == tile);
            assert_eq!(report.method, if replaced { MapMethod::MeanValue } else { method });
            assert!(report.folded.is_empty());
        }
    }
    // Pants are no disks.
    let (costs, progress) = (EdgeCosts::euclidean(&mesh), Progress::none());
    let pants = cut_into_pants(&mesh, &costs, &CutOptions::default(), &progress).unwrap().tiling().unwrap();
    assert!(
        map_tiles(&pants, &mesh, MapMethod::MeanValue, &MapOptions::default(), OnFailure::Error, &progress).is_err()
    );
}

#[test]
fn threads_change_no_byte() {
    let mesh = shapes::many_holes(12, 1500);
    let tiling = quadrangles(&mesh, Method::SinglePoint);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| mapped(&tiling, &mesh, MapMethod::MeanValue).uv)
    };
    assert_eq!(with(1), with(3));
}
