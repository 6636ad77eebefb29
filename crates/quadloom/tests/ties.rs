//! Ties and relocation through the whole pipeline, seen in the quads.

use quadloom::mesh::{DVec3, Summary, VertexId, shapes};
use quadloom::ties::{TieMiss, straight_chain};
use quadloom::{FailureKind, Progress, RemeshOptions, RemeshResult, Target, TriMesh, WarningCode, remesh_mesh};

/// A lump without symmetry, so that hardly any two irregular vertices are aligned by chance.
fn lump() -> TriMesh {
    let sphere = shapes::sphere(1.0, 4);
    let waves = |p: DVec3| 0.2 * (2.3 * p.x + 0.4).sin() + 0.15 * (1.9 * p.y - 0.8).cos() + 0.1 * (2.9 * p.z).sin();
    let positions = sphere.positions().map(|&p| p * (1.0 + waves(p)) * DVec3::new(1.0, 1.2, 1.6));
    sphere.with_positions(positions).expect("finite")
}

fn options() -> RemeshOptions {
    RemeshOptions { target: Target::Quads(900), ..RemeshOptions::default() }
}

fn made(mesh: &TriMesh, options: &RemeshOptions) -> RemeshResult {
    remesh_mesh(mesh, options, &Progress::none()).unwrap_or_else(|e| panic!("{e}"))
}

/// The vertex of the input nearest to a point.
fn near(mesh: &TriMesh, p: DVec3) -> VertexId {
    let distance = |v: &VertexId| mesh.position(*v).distance_squared(p);
    mesh.vertices().min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("a vertex")
}

/// Pairs of irregular vertices that no straight chain joins, nearest first.
fn loose_pairs(result: &RemeshResult) -> Vec<[DVec3; 2]> {
    let quads = &result.quads;
    let irregular: Vec<VertexId> = quads.vertices().filter(|&v| quads.valence(v) != 4).collect();
    let mut pairs = Vec::new();
    for (i, &a) in irregular.iter().enumerate() {
        for &b in &irregular[..i] {
            if straight_chain(quads, a, b).is_none() {
                pairs.push([quads.position(a), quads.position(b)]);
            }
        }
    }
    pairs.sort_by(|p, q| p[0].distance(p[1]).total_cmp(&q[0].distance(q[1])));
    pairs
}

/// Edges of the straight chain between the irregular vertices nearest to two points.
fn chain_between(result: &RemeshResult, pair: [DVec3; 2]) -> Option<usize> {
    let quads = &result.quads;
    let [a, b] = pair.map(|p| {
        let distance = |v: &VertexId| quads.position(*v).distance_squared(p);
        let irregular = quads.vertices().filter(|&v| quads.valence(v) != 4);
        irregular.min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("an irregular vertex")
    });
    straight_chain(quads, a, b)
}

#[test]
fn tied_irregular_vertices_are_joined_by_a_straight_chain() {
    let mesh = lump();
    let free = made(&mesh, &options());
    let loose = loose_pairs(&free);
    assert!(loose.len() >= 8, "{} pairs are not joined without a tie", loose.len());
    // Near ones, and one on the other side of the lump.
    for pair in [loose[0], loose[3], loose[loose.len() - 1]] {
        let tie = pair.map(|p| near(&mesh, p).0);
        let tied = made(&mesh, &RemeshOptions { ties: vec![tie], ..options() });
        let edges = chain_between(&tied, pair);
        assert!(edges.is_some(), "{tie:?} is not joined: {:?}", tied.report.warnings);
        assert_eq!(tied.report.ties.iter().map(|t| (t.asked, t.edges)).collect::<Vec<_>>(), [(tie, edges)]);
        assert!(!tied.report.warnings.iter().any(|w| w.misses_request()));
        assert_eq!(tied.report.irregular.by_valence, free.report.irregular.by_valence);
    }
}

#[test]
fn several_ties_are_kept_together() {
    let mesh = lump();
    let loose = loose_pairs(&made(&mesh, &options()));
    let pairs = [loose[0], loose[2]];
    let ties: Vec<[u32; 2]> = pairs.map(|pair| pair.map(|p| near(&mesh, p).0)).to_vec();
    let tied = made(&mesh, &RemeshOptions { ties: ties.clone(), ..options() });
    assert_eq!(tied.report.ties.iter().map(|t| t.asked).collect::<Vec<_>>(), ties);
    for (pair, tie) in pairs.into_iter().zip(&tied.report.ties) {
        assert!(tie.edges.is_some(), "{:?}", tied.report.warnings);
        assert_eq!(chain_between(&tied, pair), tie.edges);
    }
}

#[test]
fn a_tie_of_a_vertex_to_itself_is_refused() {
    let error = remesh_mesh(&lump(), &RemeshOptions { ties: vec![[5, 5]], ..options() }, &Progress::none());
    assert_eq!(error.expect_err("nothing to tie").kind(), FailureKind::Usage);
}

#[test]
fn a_tie_of_one_irregular_vertex_to_itself_is_missed_aloud() {
    let mesh = lump();
    let free = made(&mesh, &options()).quads;
    let irregular = free.vertices().find(|&v| free.valence(v) != 4).expect("an irregular vertex");
    let v = near(&mesh, free.position(irregular));
    let beside = mesh.outgoing(v).map(|h| mesh.target(h)).next().expect("a neighbour");
    let result = made(&mesh, &RemeshOptions { ties: vec![[v.0, beside.0]], ..options() });
    assert_eq!(result.report.ties[0].missed, Some(TieMiss::SameVertex));
    let warning = result.report.warnings.iter().find(|w| w.code == WarningCode::TieMissed).expect("a warning");
    assert!(warning.misses_request() && warning.message.contains("one irregular vertex"));
    assert!(Summary::of(&result.quads).same_topology(&Summary::of(&mesh)));
}

#[test]
fn relocation_lowers_the_energy_and_keeps_the_indices() {
    let mesh = lump();
    let few = RemeshOptions { target: Target::Quads(400), relocate: true, ..RemeshOptions::default() };
    let result = made(&mesh, &few);
    let relocation = result.report.relocation.as_ref().expect("it was asked for");
    assert!(relocation.kept > 0 && relocation.kept <= relocation.tried, "{relocation:?}");
    assert!(relocation.energy[1] < relocation.energy[0], "{relocation:?}");
    assert!(relocation.inverted[1] <= relocation.inverted[0], "{relocation:?}");
    assert_eq!(result.report.map.flips, 0);
    let quads = &result.quads;
    // Poincaré-Hopf.
    let sum: i64 = quads.vertices().map(|v| 4 - quads.valence(v) as i64).sum();
    assert_eq!(sum, 4 * Summary::of(quads).chi);
    assert_eq!(made(&mesh, &few).quads, result.quads, "the same twice");
}
