//! Maps all tiles of a mesh file's quadrangles by one method and prints what comes out.
//!
//! `cargo run --release -p quadloom-tiling --example map_tiles -- MESH mean-value|conformal|angle-based|circles [METHOD]`
#![allow(clippy::print_stdout, reason = "a program")]

use quadloom_mesh::{Progress, Summary, repair};
use quadloom_tiling::maps::{MapMethod, MapOptions};
use quadloom_tiling::{CutOptions, EdgeCosts, Method, OnFailure, QuadOptions, cut_to_disk, map_tiles};
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let path = args.first().ok_or("give a mesh file")?;
    let method = match args.get(1).map(String::as_str) {
        Some("conformal") => MapMethod::Conformal,
        Some("angle-based") => MapMethod::AngleBased,
        Some("circles") => MapMethod::Circles,
        _ => MapMethod::MeanValue,
    };
    let options = repair::RepairOptions { zero_area_rel: 0.0, ..Default::default() };
    let mesh = repair::repair(&quadloom_io::read_soup(path)?, &options)?.mesh;
    let costs = EdgeCosts::euclidean(&mesh);
    let progress = Progress::none();
    let closed = Summary::of(&mesh).boundary_loops == 0;
    let cutting = match args.get(2).map(String::as_str) {
        Some("shortest") => Method::Shortest,
        Some("intermediate") => Method::Intermediate,
        _ if closed => Method::SinglePoint,
        _ => Method::Intermediate,
    };
    let mut cutting = cut_to_disk(&mesh, &costs, cutting, &CutOptions::default(), &progress)?;
    for quads in [false, true] {
        if quads {
            cutting.quadrangulate(&QuadOptions::default())?;
        }
        let tiling = cutting.tiling()?;
        let start = Instant::now();
        match map_tiles(&tiling, &mesh, method, &MapOptions::default(), OnFailure::Error, &progress) {
            Ok(maps) => {
                let rounds: Vec<usize> = maps.reports.iter().map(|r| r.rounds).collect();
                println!(
                    "{method}: {} tiles, {:.2} s, rounds at most {} (more than 0: {}), {} vertices",
                    rounds.len(),
                    start.elapsed().as_secs_f64(),
                    rounds.iter().max().unwrap_or(&0),
                    rounds.iter().filter(|r| **r > 0).count(),
                    maps.tiling.mesh().vertex_count(),
                );
            }
            Err(error) => println!("{method}: {:.2} s, {error}", start.elapsed().as_secs_f64()),
        }
    }
    Ok(())
}
