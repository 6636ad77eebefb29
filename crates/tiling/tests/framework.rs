//! M-tilings as types: the surjection between steps, merging, given cuts, and a check that finds what is wrong.

use quadloom_mesh::{EdgeMap, FaceId, HalfEdgeId, Progress, Summary, TriMesh, VertexId, shapes};
use quadloom_tiling::cells::ComplexDefect;
use quadloom_tiling::tiling::Carrier;
use quadloom_tiling::{
    ArcId, CutOptions, Cutting, EdgeCosts, Method, NodeId, QuadOptions, Side, TileId, Tiling, TilingDefect,
    TilingError, cut_given, cut_into_pants, cut_to_disk, tile_from_cut,
};

mod common;

fn quads<'a>(mesh: &'a TriMesh, costs: &'a EdgeCosts, method: Method, progress: &'a Progress) -> Cutting<'a> {
    let mut cutting = cut_to_disk(mesh, costs, method, &CutOptions::default(), progress).unwrap();
    cutting.quadrangulate(&QuadOptions::default()).unwrap();
    cutting
}

#[test]
fn every_step_maps_onto_the_one_before() {
    let progress = Progress::none();
    for (mesh, method) in [
        (shapes::smooth_genus(2, 1), Method::Shortest),
        (shapes::smooth_genus(3, 1), Method::SinglePoint),
        (shapes::plate_with_holes(0.2), Method::Intermediate),
    ] {
        let costs = EdgeCosts::euclidean(&mesh);
        let steps = quads(&mesh, &costs, method, &progress).steps().unwrap();
        assert!(steps.len() > 3);
        for pair in steps.windows(2) {
            let (coarse, fine) = (&pair[0], &pair[1]);
            let pi = fine.surjection(coarse).unwrap();
            // F ∘ π = F: every image lies where π says, and everything coarse is met.
            for (node, &carrier) in pi.nodes.iter() {
                let v = fine.node_vertex[node];
                match carrier {
                    Carrier::Node(n) => assert_eq!(coarse.node_vertex[n], v),
                    Carrier::Arc(a) => assert!(coarse.arc_path[a][1..coarse.arc_path[a].len() - 1].contains(&v)),
                    Carrier::Tile(t) => {
                        assert!(fine.mesh().outgoing(v).all(|h| coarse.face_tile[fine.mesh().face(h)] == t));
                    }
                }
            }
            for (arc, &carrier) in pi.arcs.iter() {
                let inner = &fine.arc_path[arc];
                match carrier {
                    Carrier::Arc(a) => assert!(inner.iter().all(|v| coarse.arc_path[a].contains(v))),
                    Carrier::Tile(t) => {
                        let beside = inner.windows(2).filter_map(|p| fine.mesh().find_half_edge(p[0], p[1]));
                        assert!(beside.into_iter().all(|h| coarse.face_tile[fine.mesh().face(h)] == t));
                    }
                    Carrier::Node(n) => panic!("arc {arc} lies in node {n}"),
                }
            }
            for f in fine.mesh().faces() {
                assert_eq!(pi.tiles[fine.face_tile[f]], coarse.face_tile[f]);
            }
            let met: std::collections::BTreeSet<ArcId> = pi
                .arcs
                .values()
                .iter()
                .filter_map(|c| match c {
                    Carrier::Arc(a) => Some(*a),
                    _ => None,
                })
                .collect();
            assert_eq!(met.len(), coarse.complex.arcs.len(), "an arc of the coarser tiling is lost");
        }
    }
}

#[test]
fn merged_tiles_are_one_disk() {
    let progress = Progress::none();
    for mesh in [shapes::smooth_genus(2, 1), shapes::genus_series(4, 0), shapes::plate_with_holes(0.2)] {
        let costs = EdgeCosts::euclidean(&mesh);
        let method = if Summary::of(&mesh).boundary_loops == 0 { Method::SinglePoint } else { Method::Shortest };
        let tiling = quads(&mesh, &costs, method, &progress).tiling().unwrap();
        let merged = tiling.merged();
        assert!(tiling.complex.cells.len() > 1);
        assert_eq!((merged.complex.cells.len(), merged.check()), (1, vec![]));
        assert!(merged.complex.cells.values()[0].polygon().is_some());
        assert!(merged.cut_length() < tiling.cut_length());
        // Genus is kept where tiles are no disks.
        if Summary::of(&mesh).chi < 0 {
            let pants = cut_into_pants(&mesh, &costs, &CutOptions::default(), &progress).unwrap().tiling().unwrap();
            let merged = pants.merged();
            assert_eq!((merged.complex.cells.len(), merged.check()), (1, vec![]));
        }
    }
}

/// Vertices of a torus of radii 2 and 0.7 on one circle through its tube, or on its outer equator.
fn on_ring(mesh: &TriMesh, v: VertexId, through_tube: bool) -> bool {
    let p = mesh.position(v);
    if through_tube { p.y.abs() < 1e-9 && p.x > 0.0 } else { p.z.abs() < 1e-9 && p.truncate().length() > 2.0 }
}

/// The edges of one of these circles.
fn ring(mesh: &TriMesh, through_tube: bool) -> EdgeMap<bool> {
    EdgeMap::from_fn(mesh.edge_count(), |e| mesh.ends(e).into_iter().all(|v| on_ring(mesh, v, through_tube)))
}

#[test]
fn given_edges_are_a_tile_or_the_reason_is_told() {
    let mesh = shapes::torus(2.0, 0.7, 12, 8);
    let (one, other) = (ring(&mesh, true), ring(&mesh, false));
    let both = EdgeMap::from_fn(mesh.edge_count(), |e| one[e] || other[e]);
    let tiling = tile_from_cut(&mesh, &both).unwrap();
    assert_eq!(tiling.check(), []);
    assert_eq!(tiling.complex.cells.values()[0].side_count(), 4);
    assert_eq!(tiling.word(TileId(0)).unwrap().canonical_form().text(), "a1 b1 a1⁻¹ b1⁻¹");
    for ring in [one, other] {
        let error = tile_from_cut(&mesh, &ring).expect_err("an annulus is no disk");
        assert!(matches!(error, TilingError::NotDisks { tiles: 1, boundaries: 2, genus: 0, .. }), "{error}");
    }
    let (costs, progress) = (EdgeCosts::euclidean(&mesh), Progress::none());
    let mut cutting = cut_given(&mesh, &costs, &both, &progress).unwrap();
    assert_eq!(cutting.quadrangulate(&QuadOptions::default()).unwrap().quadrangles, 1);
    // All edges: every triangle is a tile of its own.
    let all = EdgeMap::filled(mesh.edge_count(), true);
    assert!(matches!(tile_from_cut(&mesh, &all), Err(TilingError::SeveralTiles { tiles: 192 })));
    let triangles = cut_given(&mesh, &costs, &all, &progress).unwrap().tiling().unwrap();
    assert_eq!(triangles.check(), []);
    common::check_gluing("triangles", &triangles);
    let merged = triangles.merged();
    assert_eq!((merged.complex.cells.len(), merged.check()), (1, vec![]));
}

#[test]
fn what_is_wrong_with_a_tiling_is_found() {
    let mesh = shapes::smooth_genus(2, 1);
    let (costs, progress) = (EdgeCosts::euclidean(&mesh), Progress::none());
    let good = quads(&mesh, &costs, Method::Intermediate, &progress).tiling().unwrap();
    assert_eq!(good.check(), []);
    let spoilt = |change: &dyn Fn(&mut Tiling)| {
        let mut tiling = good.clone();
        change(&mut tiling);
        tiling.check()
    };
    let has = |found: Vec<TilingDefect>, wanted: &dyn Fn(&TilingDefect) -> bool| {
        assert!(found.iter().any(wanted), "{:?}", &found[..found.len().min(4)]);
    };
    use TilingDefect as D;
    has(spoilt(&|t| t.complex.cells[TileId(0)].genus = 1), &|d| matches!(d, D::Topology { .. }));
    has(spoilt(&|t| t.complex.cells[TileId(0)].boundaries.clear()), &|d| {
        matches!(d, D::Complex(ComplexDefect::Sides { .. }) | D::BoundaryLength { .. })
    });
    has(spoilt(&|t| t.complex.cells[TileId(0)].boundaries[0].swap(0, 1)), &|d| {
        matches!(d, D::Complex(ComplexDefect::Gap { .. }) | D::Boundary { .. })
    });
    has(spoilt(&|t| t.complex.cells[TileId(0)].boundaries[0][0].reversed ^= true), &|d| matches!(d, D::Complex(_)));
    has(spoilt(&|t| t.complex.cells[TileId(0)].boundaries.push(Vec::new())), &|d| {
        matches!(d, D::Complex(ComplexDefect::EmptyBoundary { .. }))
    });
    let stranger = Side { arc: ArcId(9999), reversed: false };
    has(spoilt(&|t| t.complex.cells[TileId(0)].boundaries[0].push(stranger)), &|d| {
        matches!(d, D::Complex(ComplexDefect::NoArc { .. }))
    });
    has(spoilt(&|t| t.complex.arcs[ArcId(0)][0] = NodeId(9999)), &|d| {
        matches!(d, D::Complex(ComplexDefect::NoNode { .. }))
    });
    has(spoilt(&|t| t.node_vertex[NodeId(0)] = t.node_vertex[NodeId(1)]), &|d| matches!(d, D::NodesMeet(..)));
    has(spoilt(&|t| t.arc_path[ArcId(0)][1] = VertexId(0)), &|d| matches!(d, D::BrokenArc { .. }));
    has(spoilt(&|t| t.arc_path[ArcId(0)] = t.arc_path[ArcId(1)].clone()), &|d| {
        matches!(d, D::ArcsOverlap(..) | D::ArcsMeet(..) | D::BrokenArc { .. })
    });
    has(spoilt(&|t| t.face_tile[FaceId(0)] = TileId(9999)), &|d| matches!(d, D::NoTile(_)));
    has(
        spoilt(&|t| {
            let f = inner_face(t);
            let own = t.face_tile[f];
            t.face_tile[f] = TileId(u32::from(own.0 == 0));
        }),
        &|d| matches!(d, D::TilesOverlap(..)),
    );
    has(spoilt(&|t| t.mesh().clone().faces().for_each(|f| t.face_tile[f] = TileId(0))), &|d| {
        matches!(d, D::EmptyTile(_))
    });
}

/// A face no side of which is cut.
fn inner_face(tiling: &Tiling) -> FaceId {
    let cut = tiling.cut_edges();
    let mesh = tiling.mesh();
    let free = |h: HalfEdgeId| !cut[mesh.edge(h)] && mesh.twin(h).is_some();
    mesh.faces().find(|&f| mesh.face_half_edges(f).into_iter().all(free)).expect("a face inside a tile")
}

#[test]
fn bad_input_is_named() {
    let progress = Progress::none();
    let torus = shapes::torus(2.0, 0.7, 12, 8);
    let costs = EdgeCosts::euclidean(&torus);
    let options = CutOptions { base: Some(VertexId(96)), ..CutOptions::default() };
    for method in [Method::Shortest, Method::SinglePoint, Method::Intermediate] {
        let error = cut_to_disk(&torus, &costs, method, &options, &progress).err().expect("no such vertex");
        assert_eq!(error, TilingError::NoVertex { vertex: VertexId(96), last: 95 });
    }
    let negative = EdgeMap::from_fn(torus.edge_count(), |e| if e.0 == 7 { -1.0 } else { 1.0 });
    assert!(matches!(EdgeCosts::new(negative), Err(TilingError::Cost { edge, .. }) if edge.0 == 7));
    assert!(EdgeCosts::new(EdgeMap::filled(3, f64::NAN)).is_err());
    assert!(EdgeCosts::curvature(&torus, 1.5).is_err() && EdgeCosts::curvature(&torus, f64::NAN).is_err());
    let few = EdgeCosts::new(EdgeMap::filled(3, 1.0)).unwrap();
    let error = Cutting::new(&torus, &few, &progress).err().expect("three costs");
    assert_eq!(error, TilingError::CostCount { found: 3, edges: torus.edge_count() });
    let two = shapes::join(&[torus.clone(), shapes::displace(&torus, |_| 0.1)]);
    let costs_of_two = EdgeCosts::euclidean(&two);
    let error = Cutting::new(&two, &costs_of_two, &progress).err().expect("two components");
    assert_eq!(error, TilingError::Components { components: 2 });
    // Zero costs are allowed; where all edges are forbidden there is no way.
    for method in [Method::Shortest, Method::SinglePoint, Method::Intermediate] {
        let free = EdgeCosts::new(EdgeMap::filled(torus.edge_count(), 0.0)).unwrap();
        let cutting = cut_to_disk(&torus, &free, method, &CutOptions::default(), &progress).unwrap();
        assert_eq!(cutting.tiling().unwrap().check(), []);
        let walls = EdgeCosts::new(EdgeMap::filled(torus.edge_count(), f64::INFINITY)).unwrap();
        let error = cut_to_disk(&torus, &walls, method, &CutOptions::default(), &progress).err().expect("no way");
        assert!(matches!(error, TilingError::NoWay { .. }), "{error}");
        // A ring that no cut may enter still leaves the other ways around.
        let guarded = costs.clone().without_vertices(&torus, torus.vertices().filter(|&v| on_ring(&torus, v, false)));
        let result = cut_to_disk(&torus, &guarded, method, &CutOptions::default(), &progress);
        assert!(matches!(result.err(), Some(TilingError::NoWay { .. })), "a disk around a forbidden ring");
        let spots = costs.clone().without_vertices(&torus, [5, 40, 77].map(VertexId));
        let cutting = cut_to_disk(&torus, &spots, method, &CutOptions::default(), &progress).unwrap();
        for path in cutting.cuts().iter().map(|c| c.path()) {
            assert!(
                !path.iter().any(|v| [5, 40, 77].contains(&v.0)),
                "{method:?}: a cut runs through a forbidden vertex"
            );
        }
    }
    // Cancelled before it began.
    let stopped = Progress::none().with_time_limit(std::time::Duration::ZERO);
    let error = cut_to_disk(&torus, &costs, Method::Shortest, &CutOptions::default(), &stopped).err().expect("stopped");
    assert!(matches!(error, TilingError::Cancelled(_)));
}
