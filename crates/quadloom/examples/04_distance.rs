//! 4. Distances from sharp edges of a part, with isolines, and the page that shows them.
//!
//! `cargo run --release -p quadloom --example 04_distance`
#![allow(clippy::print_stdout, reason = "an example")]

use quadloom::distance::{DistanceRequest, Lines, measure_distances, scene};
use quadloom::{Progress, RemeshError, Source, load, view::render_html};

fn main() -> Result<(), RemeshError> {
    let part = load(&Source::Sample("bracket".into()))?;
    let from = ["features:35", "point:0,0,0"].map(|name| name.parse().expect("a name of a source"));
    let request = DistanceRequest {
        from: from.to_vec(),
        snap_rel: 1.0,
        isolines: Some(Lines::Count(20)),
        picture: true,
        ..DistanceRequest::default()
    };
    let result = measure_distances(&part, &request, &Progress::none())?;
    println!("largest distance {:.6}, {} isolines", result.report.largest_distance, result.isolines.len());
    println!("{} bytes of a page", render_html(&scene(&result, "bracket")).len());
    Ok(())
}
