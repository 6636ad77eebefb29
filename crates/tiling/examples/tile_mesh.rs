//! Cuts a mesh file by every method and prints what comes out, with times.
//!
//! `cargo run --release -p quadloom-tiling --example tile_mesh -- MESH [exact]`
#![allow(clippy::print_stdout, reason = "a program")]

use quadloom_mesh::{Progress, repair};
use quadloom_tiling::{CutOptions, EdgeCosts, Method, QuadOptions, SearchMode, cut_to_disk};
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let path = args.next().ok_or("give a mesh file")?;
    let search = if args.next().as_deref() == Some("exact") { SearchMode::Exact } else { SearchMode::Fast };
    let soup = quadloom_io::read_soup(&path)?;
    let mesh = repair::repair(&soup, &Default::default())?.mesh;
    let costs = EdgeCosts::euclidean(&mesh);
    let progress = Progress::none();
    for method in [Method::Shortest, Method::SinglePoint, Method::Intermediate] {
        let start = Instant::now();
        let options = CutOptions { search, base: None };
        let mut cutting = match cut_to_disk(&mesh, &costs, method, &options, &progress) {
            Ok(cutting) => cutting,
            Err(error) => {
                println!("{method:?}: {error}");
                continue;
            }
        };
        let single = start.elapsed().as_secs_f64();
        let before = cutting.tiling()?;
        let cost = cutting.cost();
        let start = Instant::now();
        let report = cutting.quadrangulate(&QuadOptions { search, ..Default::default() })?;
        let quads = start.elapsed().as_secs_f64();
        let tiling = cutting.tiling()?;
        println!(
            "{method:?}: {single:.3} s, {} sides, {} nodes, cost {cost:.4}, on the mesh {:.4}; {quads:.3} s, {} quads, \
             cost {:.4} (greedy diagonals {:.4}, optimal {:.4}), on the mesh {:.4}; refined {} -> {} vertices; defects {}",
            before.complex.cells.values()[0].side_count(),
            before.complex.nodes,
            before.cut_length(),
            report.quadrangles,
            cutting.cost(),
            report.greedy_cost,
            report.optimal_cost,
            tiling.cut_length(),
            mesh.vertex_count(),
            tiling.mesh().vertex_count(),
            tiling.check().len(),
        );
    }
    Ok(())
}
