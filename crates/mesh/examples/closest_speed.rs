//! Times closest-point queries: `cargo run --release -p quadloom-mesh --example closest_speed`.
#![allow(clippy::print_stdout)]

use quadloom_mesh::{ClosestPoint, DVec3, shapes};
use std::time::Instant;

fn main() {
    let mesh = shapes::torus(1.0, 0.4, 320, 160);
    let start = Instant::now();
    let index = ClosestPoint::new(&mesh);
    println!("{} faces, built in {:.1} ms", mesh.face_count(), start.elapsed().as_secs_f64() * 1e3);
    let queries: Vec<DVec3> = mesh
        .vertices()
        .map(|v| {
            let noise = |k| 0.02 * (shapes::random(k, u64::from(v.0)) - 0.5);
            mesh.position(v) + DVec3::new(noise(1), noise(2), noise(3))
        })
        .collect();
    let start = Instant::now();
    let found: Vec<_> = queries.iter().map(|&p| index.query(p)).collect();
    let plain = start.elapsed().as_secs_f64() / queries.len() as f64;
    let start = Instant::now();
    let sum: f64 = queries.iter().zip(&found).map(|(&p, c)| index.query_near(p, c.point.face).distance).sum();
    let near = start.elapsed().as_secs_f64() / queries.len() as f64;
    assert_eq!(sum, found.iter().map(|c| c.distance).sum::<f64>());
    println!("query {:.2} µs, with a hint {:.2} µs", plain * 1e6, near * 1e6);
}
