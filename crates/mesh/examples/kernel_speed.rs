//! Times the kernel on a torus: `cargo run --release -p quadloom-mesh --example kernel_speed [STEPS]`;
//! the torus has `STEPS`² triangles (default 452, which makes 205,000).
#![allow(clippy::print_stdout)]

use quadloom_mesh::repair::{RepairOptions, repair};
use quadloom_mesh::topology::cut_graph;
use quadloom_mesh::{ClosestPoint, DVec3, EdgeMap, FaceSoup, TriConnectivity, VertexId, shapes};
use std::time::Instant;

fn timed<T>(what: &str, per: usize, unit: &str, run: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let result = run();
    let seconds = start.elapsed().as_secs_f64();
    println!("{what:<28} {:>8.1} ms  {:>6.2} µs a {unit}", seconds * 1e3, seconds * 1e6 / per as f64);
    result
}

fn main() {
    let steps = std::env::args().nth(1).and_then(|a| a.parse().ok()).unwrap_or(452);
    let mesh = shapes::torus(1.0, 0.4, steps, steps / 2);
    let (faces, list) = (mesh.face_count(), mesh.to_faces());
    timed("connectivity", faces, "triangle", || TriConnectivity::from_faces(mesh.vertex_count(), &list))
        .expect("a torus is a manifold");
    let soup = FaceSoup {
        positions: mesh.positions().values().to_vec(),
        faces: list.iter().map(|f| f.to_vec()).collect(),
        ..FaceSoup::default()
    };
    timed("repair", faces, "triangle", || repair(&soup, &RepairOptions::default())).expect("a torus is clean");
    let cost = EdgeMap::filled(mesh.edge_count(), 1.0);
    let singular: Vec<VertexId> = (0..100).map(|i| VertexId::new(i * mesh.vertex_count() / 100)).collect();
    timed("cut graph", faces, "triangle", || cut_graph(&mesh, &cost, &singular));
    let index = timed("closest points: build", faces, "triangle", || ClosestPoint::new(&mesh));
    let queries: Vec<DVec3> = mesh
        .vertices()
        .map(|v| {
            let noise = |k| 0.02 * (shapes::random(k, u64::from(v.0)) - 0.5);
            mesh.position(v) + DVec3::new(noise(1), noise(2), noise(3))
        })
        .collect();
    let found: Vec<_> =
        timed("closest points: query", queries.len(), "query", || queries.iter().map(|&p| index.query(p)).collect());
    let sum: f64 = timed("closest points: with hint", queries.len(), "query", || {
        queries.iter().zip(&found).map(|(&p, c)| index.query_near(p, c.point.face).distance).sum()
    });
    assert_eq!(sum, found.iter().map(|c| c.distance).sum::<f64>());
}
