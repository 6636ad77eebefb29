//! Pants and cylinders: how many there are, and that each is one.

use quadloom_mesh::{Progress, Summary, TriMesh, shapes};
use quadloom_tiling::{CutOptions, EdgeCosts, SearchMode, TilingError, cut_into_cylinders, cut_into_pants};

mod common;

fn check(what: &str, mesh: &TriMesh) {
    let costs = EdgeCosts::euclidean(mesh);
    let progress = Progress::none();
    let pairs = -Summary::of(mesh).chi as usize;
    for search in [SearchMode::Fast, SearchMode::Exact] {
        let options = CutOptions { search, base: None };
        let what = format!("{what}, {search:?}");
        let pants = cut_into_pants(mesh, &costs, &options, &progress).expect(&what);
        for tiling in pants.steps().unwrap() {
            assert_eq!(tiling.check(), [], "{what}");
        }
        let tiling = pants.tiling().unwrap();
        common::check_gluing(&what, &tiling);
        common::check_refinement(&what, mesh, &tiling);
        assert_eq!(tiling.complex.cells.len(), pairs, "{what}");
        assert!(tiling.complex.cells.values().iter().all(|c| c.genus == 0 && c.boundaries.len() == 3), "{what}");

        let cylinders = cut_into_cylinders(mesh, &costs, &options, &progress).expect(&what);
        let tiling = cylinders.tiling().unwrap();
        assert_eq!(tiling.check(), [], "{what}");
        common::check_gluing(&what, &tiling);
        common::check_refinement(&what, mesh, &tiling);
        assert_eq!(tiling.complex.cells.len(), 3 * pairs, "{what}");
        for cell in tiling.complex.cells.values() {
            let mut sides: Vec<usize> = cell.boundaries.iter().map(Vec::len).collect();
            sides.sort_unstable();
            assert_eq!((cell.genus, sides), (0, vec![1, 2]), "{what}: as in Figure 4");
        }
    }
}

#[test]
fn closed_surfaces_fall_into_pants_and_cylinders() {
    for genus in 2..=5 {
        check(&format!("genus {genus}"), &shapes::smooth_genus(genus, 1));
    }
}

/// A sphere with some vertices' stars taken out.
fn punctured(holes: &[u32]) -> TriMesh {
    let sphere = shapes::sphere(1.0, 3);
    let taken: Vec<bool> = {
        let mut taken = vec![false; sphere.vertex_count()];
        holes.iter().for_each(|&v| taken[v as usize] = true);
        taken
    };
    let faces: Vec<[u32; 3]> =
        sphere.to_faces().into_iter().filter(|f| f.iter().all(|&v| !taken[v as usize])).collect();
    let mut number = vec![u32::MAX; sphere.vertex_count()];
    let mut positions = Vec::new();
    for &v in faces.iter().flatten() {
        if number[v as usize] == u32::MAX {
            number[v as usize] = positions.len() as u32;
            positions.push(sphere.position(quadloom_mesh::VertexId(v)));
        }
    }
    let faces: Vec<[u32; 3]> = faces.into_iter().map(|f| f.map(|v| number[v as usize])).collect();
    TriMesh::new(positions, &faces).unwrap()
}

#[test]
fn spheres_with_holes_fall_into_pants() {
    for holes in [&[0, 1, 2][..], &[0, 1, 2, 3], &[0, 1, 2, 3, 4, 5], &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11]] {
        check(&format!("{} holes", holes.len()), &punctured(holes));
    }
}

#[test]
fn surfaces_without_pants_are_refused() {
    let progress = Progress::none();
    for mesh in [shapes::sphere(1.0, 2), shapes::torus(2.0, 0.5, 12, 8), shapes::cylinder(1.0, 2.0, 12, 4)] {
        let costs = EdgeCosts::euclidean(&mesh);
        let error = cut_into_pants(&mesh, &costs, &CutOptions::default(), &progress).err().expect("no pants");
        assert!(matches!(error, TilingError::NoPants { .. }), "{error}");
    }
}
