//! 7. Klein's quartic: its targets, then the map on tubes around a tetrahedron, as a file and as a page.
//!
//! `cargo run --release -p quadloom --example 07_regular_map`
#![allow(clippy::print_stdout, reason = "an example")]

use quadloom::io::Batch;
use quadloom::regular_map::{MapSpec, RealizeRequest, find_map, map_scene, matches, realize_map, stage_realized};
use quadloom::{Progress, RemeshError, view::render_map_html};

fn main() -> Result<(), RemeshError> {
    let klein = find_map(&MapSpec::Presentation("R^3, S^7, (R*S^-2)^4".into()))?;
    println!("{} {}", klein.name, klein.identifier);
    for found in matches(&klein)? {
        println!("on {}: {} junctions, {} tubes", found.target.name, found.junctions, found.tubes);
    }
    let result = realize_map(&klein, &RealizeRequest { size: 80.0, ..RealizeRequest::default() }, &Progress::none())?;
    println!("{}: rotations {}", result.report.title(), result.report.surface_of.symmetry.group);
    let mut files = Batch::new();
    stage_realized(&mut files, &std::env::temp_dir().join("klein.glb"), &result)?;
    files.commit()?;
    println!("{} bytes of a page", render_map_html(&map_scene(&result)?).len());
    Ok(())
}
