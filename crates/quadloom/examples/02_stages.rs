//! 2. The same way arrow by arrow: what each stage hands to the next.
//!
//! `cargo run --release -p quadloom --example 02_stages`
#![allow(clippy::print_stdout, reason = "an example")]

use quadloom::extract::{FinishOptions, Reference, finish};
use quadloom::features::{FeatureRequest, find_features};
use quadloom::sizes::{SizeRequest, relative_sizes};
use quadloom::stages::{
    MapRequest, count_goal, cross_field, extract_quads, integer_grid_map, work_edge_length, work_mesh,
};
use quadloom::verify::verify;
use quadloom::{Progress, RemeshOptions, sample};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (options, progress) = (RemeshOptions::default(), Progress::none());
    let surface = sample("plate").ok_or("there is no such shape")?;
    let quads = 600.0;
    let edge = (surface.area() / quads).sqrt();

    // Surface to features: here the outline and five holes.
    let request = FeatureRequest { sharp_angle: options.sharp_angle, ..FeatureRequest::default() };
    let features = find_features(&surface, &request, edge).graph;
    println!("{} feature curves", features.chains.len());

    // Surface to work mesh: even triangles, as fine as the quads need.
    let work = work_mesh(&surface, &features, work_edge_length(surface.area(), edge), &options, &progress)?;
    println!("{} triangles in, {} to work on", surface.face_count(), work.mesh.face_count());

    // Work mesh to cross field.
    let (field, report) = cross_field(&work, edge, Default::default(), &progress)?;
    println!("{} singular vertices, energy {:.2}", report.singularities, report.energy);

    // Cross field to integer-grid map, of a size that gives the count.
    let size = relative_sizes(&work, &field, &surface, edge, &SizeRequest::default(), &progress)?;
    let goal = count_goal(quads, &options);
    let map = integer_grid_map(&work, &field, &size, goal, edge, MapRequest::default(), &progress)?;
    println!("{:.0} quads in the map after {} solves", map.quads, map.solves);

    // Map to quads, and back onto the surface.
    let extraction = extract_quads(&work, &map.parametrization.map, &progress)?;
    let reference = Reference::new(&surface, &features);
    let finished = finish(&extraction, &reference, &FinishOptions::default(), &progress)?;

    // Verified, from the definitions.
    let verification = verify(&finished.mesh, &reference);
    println!("{} quads, {}", finished.mesh.face_count(), if verification.passed() { "valid" } else { "not valid" });
    Ok(())
}
