//! 3. A cross field of one's own: the quads follow it.
//!
//! On a torus every face gets the direction around the axis, so that the quads run along both circles and no vertex
//! is irregular.
//!
//! `cargo run --release -p quadloom --example 03_own_field`
#![allow(clippy::print_stdout, reason = "an example")]

use quadloom::mesh::DVec3;
use quadloom::{GivenField, Progress, RemeshError, RemeshOptions, Target, remesh_mesh, sample};

fn main() -> Result<(), RemeshError> {
    let torus = sample("torus").ok_or_else(|| RemeshError::NoSample("torus".into()))?;
    let around = |f| {
        let corner = torus.face_vertices(f).map(|v| torus.position(v));
        DVec3::Z.cross((corner[0] + corner[1] + corner[2]) / 3.0)
    };
    let field = GivenField { directions: torus.faces().map(around).collect() };
    let options = RemeshOptions { target: Target::Quads(800), field: Some(field), ..RemeshOptions::default() };
    let result = remesh_mesh(&torus, &options, &Progress::none())?;
    println!("{} quads, {} irregular vertices", result.report.count.reached, result.report.irregular.interior);
    Ok(())
}
