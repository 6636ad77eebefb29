//! 5. A surface of genus 3 as a polygon with 12 sides, then as 5 quadrangles, with the page that shows them.
//!
//! `cargo run --release -p quadloom --example 05_tiles`
#![allow(clippy::print_stdout, reason = "an example")]

use quadloom::tile::{Into, TileRequest, scene, tile_surface};
use quadloom::{Progress, RemeshError, Source, load, view::render_html};

fn main() -> Result<(), RemeshError> {
    let surface = load(&Source::Sample("genus3".into()))?;
    let request = TileRequest { into: Into::Quads, ..TileRequest::default() };
    let result = tile_surface(&surface, &request, &Progress::none())?;
    let report = &result.report;
    println!("word: {}", report.word.as_deref().unwrap_or("none"));
    println!("canonical word: {}", report.canonical_word.as_deref().unwrap_or("none"));
    println!("{} tiles with sides {:?}, cuts of length {:.6}", report.tiles, report.sides, report.length);
    println!("{} bytes of a page", render_html(&scene(&result, "genus 3")).len());
    Ok(())
}
