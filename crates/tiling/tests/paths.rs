//! Paths and loops of one's own: which are valid, what kinds of loops there are, cuts along them, shortest ones.

use quadloom_mesh::{DVec3, Progress, Summary, TriMesh, VertexId, shapes};
use quadloom_tiling::{Cutting, EdgeCosts, LoopKind, SearchMode, TilingError};

mod common;

const TORUS: [f64; 2] = [2.0, 0.7];

fn torus() -> TriMesh {
    shapes::torus(TORUS[0], TORUS[1], 24, 12)
}

/// The circle through the tube of a torus at y = 0, x > 0, around from its outermost vertex.
fn meridian(mesh: &TriMesh) -> Vec<VertexId> {
    let on = |v: &VertexId| mesh.position(*v).y.abs() < 1e-9 && mesh.position(*v).x > 0.0;
    let angle = |v: &VertexId| mesh.position(*v).z.atan2(mesh.position(*v).x - TORUS[0]);
    closed(mesh.vertices().filter(on).collect(), angle)
}

/// The outer equator, from the vertex with y = 0.
fn equator(mesh: &TriMesh) -> Vec<VertexId> {
    let on = |v: &VertexId| mesh.position(*v).z.abs() < 1e-9 && mesh.position(*v).truncate().length() > TORUS[0];
    closed(mesh.vertices().filter(on).collect(), |v| mesh.position(*v).y.atan2(mesh.position(*v).x))
}

fn closed(mut all: Vec<VertexId>, angle: impl Fn(&VertexId) -> f64) -> Vec<VertexId> {
    all.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    let zero = all.iter().position(|v| angle(v).abs() < 1e-9).unwrap();
    all.rotate_left(zero);
    all.push(all[0]);
    all
}

#[test]
fn loops_are_trivial_separating_or_neither() {
    let (mesh, progress) = (torus(), Progress::none());
    let costs = EdgeCosts::euclidean(&mesh);
    let cutting = Cutting::new(&mesh, &costs, &progress).unwrap();
    for path in [meridian(&mesh), equator(&mesh)] {
        assert_eq!(cutting.kind_of_loop(&path).unwrap(), LoopKind::NonSeparating);
    }
    // Around one face, and around one vertex.
    let [a, b, c] = mesh.face_vertices(quadloom_mesh::FaceId(5));
    assert_eq!(cutting.kind_of_loop(&[a, b, c, a]).unwrap(), LoopKind::Trivial);
    let mut star: Vec<VertexId> = mesh.neighbours(VertexId(40)).collect();
    star.push(star[0]);
    assert_eq!(cutting.kind_of_loop(&star).unwrap(), LoopKind::Trivial);
    // The seam of two tori glued along a triangle.
    let (double, seam) = glued();
    let costs = EdgeCosts::euclidean(&double);
    let cutting = Cutting::new(&double, &costs, &progress).unwrap();
    assert_eq!(Summary::of(&double).genus, 2);
    assert_eq!(cutting.kind_of_loop(&seam).unwrap(), LoopKind::Separating);
}

/// Two tori without a face each, glued along its border; the border as a loop.
fn glued() -> (TriMesh, Vec<VertexId>) {
    let mesh = torus();
    let n = mesh.vertex_count() as u32;
    let faces = mesh.to_faces();
    let [a, b, c] = faces[7];
    // The other torus is seen from its back: a ↔ a, b ↔ c.
    let glue = |v: u32| match v {
        v if v == a => a,
        v if v == b => c,
        v if v == c => b,
        v => v + n,
    };
    let others = faces.iter().enumerate().filter(|&(k, _)| k != 7).map(|(_, f)| f.map(glue));
    let mut all: Vec<[u32; 3]> = faces.iter().enumerate().filter(|&(k, _)| k != 7).map(|(_, f)| *f).collect();
    all.extend(others);
    let mut positions = mesh.positions().values().to_vec();
    positions.extend(mesh.positions().values().iter().map(|&p| p + DVec3::new(6.0, 0.0, 0.0)));
    // Vertices that no face uses any more are taken out.
    let mut number = vec![u32::MAX; positions.len()];
    let mut used = Vec::new();
    for &v in all.iter().flatten() {
        if number[v as usize] == u32::MAX {
            number[v as usize] = used.len() as u32;
            used.push(positions[v as usize]);
        }
    }
    let all: Vec<[u32; 3]> = all.into_iter().map(|f| f.map(|v| number[v as usize])).collect();
    (TriMesh::new(used, &all).unwrap(), [a, b, c, a].map(|v| VertexId(number[v as usize])).to_vec())
}

#[test]
fn paths_may_touch_cuts_and_not_cross_them() {
    let (mesh, progress) = (torus(), Progress::none());
    let costs = EdgeCosts::euclidean(&mesh);
    let mut cutting = Cutting::new(&mesh, &costs, &progress).unwrap();
    let (meridian, equator) = (meridian(&mesh), equator(&mesh));
    cutting.cut_path(&meridian).unwrap();
    // The equator goes on from the other side: in the cell it is a path between the two boundaries.
    let error = cutting.kind_of_loop(&equator).unwrap_err();
    assert_eq!(error, TilingError::Path { at: equator.len() - 1, why: "the path is not closed in the cell" });
    // One that begins in the middle of it crosses the cut.
    let mut shifted = equator[..equator.len() - 1].to_vec();
    shifted.rotate_left(equator.len() / 2);
    shifted.push(shifted[0]);
    assert!(matches!(cutting.cut_path(&shifted), Err(TilingError::Path { why: "it crosses an earlier cut", .. })));
    // Along the cut is allowed: the path is pulled off it.
    let along = &meridian[1..5];
    let before = cutting.tiling().unwrap();
    cutting.cut_path(&equator).unwrap();
    let disk = cutting.tiling().unwrap();
    assert_eq!((disk.check(), disk.complex.cells.values()[0].side_count()), (vec![], 4));
    cutting.cut_path(along).unwrap();
    let two = cutting.tiling().unwrap();
    assert_eq!((two.check(), two.complex.cells.len()), (vec![], 2));
    common::check_gluing("along a cut", &two);
    common::check_refinement("along a cut", &mesh, &two);
    assert_eq!(before.check(), []);
}

#[test]
fn what_is_no_path_is_named() {
    let (mesh, progress) = (torus(), Progress::none());
    let costs = EdgeCosts::euclidean(&mesh);
    let mut cutting = Cutting::new(&mesh, &costs, &progress).unwrap();
    let far = VertexId(200);
    let message = |path: &[VertexId], cutting: &mut Cutting| cutting.cut_path(path).unwrap_err().to_string();
    assert!(message(&[VertexId(0)], &mut cutting).contains("at least one edge"));
    assert!(message(&[VertexId(0), far], &mut cutting).contains("not joined by an edge"));
    assert!(message(&[VertexId(0), VertexId(9999)], &mut cutting).contains("no vertex 9999"));
    let eight: Vec<VertexId> = meridian(&mesh).into_iter().chain(equator(&mesh).into_iter().skip(1)).collect();
    assert!(message(&eight, &mut cutting).contains("meets itself"));
    assert!(cutting.cuts().is_empty());
}

#[test]
fn shortest_paths_are_those_of_the_torus() {
    let (mesh, progress) = (torus(), Progress::none());
    let costs = EdgeCosts::euclidean(&mesh);
    let mut cutting = Cutting::new(&mesh, &costs, &progress).unwrap();
    let length =
        |path: &[VertexId]| -> f64 { path.windows(2).map(|p| mesh.position(p[0]).distance(mesh.position(p[1]))).sum() };
    let girth = length(&meridian(&mesh));
    for search in [SearchMode::Fast, SearchMode::Exact] {
        let found = cutting.shortest_loop(search).unwrap().unwrap();
        assert!((found.cost - girth).abs() < 1e-9 && (length(&found.vertices) - girth).abs() < 1e-9);
        assert_eq!(found.vertices.first(), found.vertices.last());
    }
    let base = equator(&mesh)[7];
    let through = cutting.shortest_loop_at(base).unwrap().unwrap();
    assert!(through.vertices.contains(&base) && (through.cost - girth).abs() < 1e-9);
    cutting.cut_path(&meridian(&mesh)).unwrap();
    assert!(cutting.shortest_loop(SearchMode::Exact).unwrap().is_none(), "an annulus has no such loop");
    let across = cutting.shortest_boundary_path().unwrap();
    let inner = mesh.vertices().filter(|&v| {
        let p: DVec3 = mesh.position(v);
        p.z.abs() < 1e-9 && p.truncate().length() < TORUS[0]
    });
    assert!(
        (across.cost - length(&closed(inner.collect(), |v| mesh.position(*v).y.atan2(mesh.position(*v).x)))).abs()
            < 1e-9
    );
    let [a, b] = [equator(&mesh)[3], equator(&mesh)[9]];
    let path = cutting.shortest_path(a, b).unwrap().unwrap();
    assert!(
        path.vertices[0] == a
            && path.vertices.ends_with(&[b])
            && path.cost >= mesh.position(a).distance(mesh.position(b))
    );
}
