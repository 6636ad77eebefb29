//! 1. The whole way in one call: a generated shape becomes quads, and its report is looked at.
//!
//! `cargo run --release -p quadloom --example 01_remesh`
#![allow(clippy::print_stdout, reason = "an example")]

use quadloom::{Progress, RemeshError, RemeshOptions, Target, remesh_mesh, sample};

fn main() -> Result<(), RemeshError> {
    let bracket = sample("bracket").ok_or_else(|| RemeshError::NoSample("bracket".into()))?;
    let options = RemeshOptions { target: Target::Quads(2000), ..RemeshOptions::default() };
    let result = remesh_mesh(&bracket, &options, &Progress::none())?;

    let report = &result.report;
    println!("{} triangles, {} quads", report.input.summary.faces, report.output.summary.faces);
    println!("genus {} before, {} after", report.input.summary.genus, report.output.summary.genus);
    println!("irregular vertices by valence: {:?}", report.irregular.by_valence);
    println!("mean scaled Jacobian {:.3}", report.quality.scaled_jacobian_mean);
    for (stage, seconds) in report.seconds.iter() {
        println!("{stage:>18} {seconds:.2} s");
    }
    for warning in &report.warnings {
        println!("warning: {}", warning.message);
    }
    Ok(())
}
