//! Times and lengths of every method on generated surfaces, as JSON lines ([Favreau2009] Table 1, Figures 16 and 17).
//!
//! `cargo run --release -p quadloom-tiling --example table`; with `-- write FOLDER` it writes the surfaces instead, and
//! plates with 100 holes.
#![allow(clippy::print_stdout, reason = "a program")]

use quadloom_mesh::{Progress, Summary, TriMesh, shapes};
use quadloom_tiling::{CutOptions, EdgeCosts, Method, QuadOptions, SearchMode, cut_to_disk};
use serde_json::json;
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    if let [verb, folder] = &args[..]
        && verb == "write"
    {
        return write(std::path::Path::new(folder));
    }
    for genus in 1..=4 {
        for level in 0..if genus < 3 { 4 } else { 3 } {
            let mesh = shapes::genus_series(genus, level);
            for method in [Method::Shortest, Method::SinglePoint, Method::Intermediate] {
                for search in [SearchMode::Exact, SearchMode::Fast] {
                    row(&mesh, level, method, search)?;
                }
            }
        }
    }
    Ok(())
}

/// Writes all surfaces as OBJ.
fn write(folder: &std::path::Path) -> Result<(), Box<dyn std::error::Error>> {
    let mut surfaces: Vec<(String, TriMesh)> = Vec::new();
    for genus in 1..=4 {
        surfaces.extend((0..4).map(|level| (format!("genus{genus}_level{level}"), shapes::genus_series(genus, level))));
    }
    for vertices in [31_250, 125_000, 500_000] {
        surfaces.push((format!("holes100_{vertices}"), shapes::many_holes(100, vertices)));
    }
    for (name, mesh) in surfaces {
        let faces = mesh.to_faces().iter().map(|f| f.to_vec()).collect();
        let surface = quadloom_io::SurfaceOut::new(mesh.positions().values().to_vec(), faces);
        quadloom_io::write_surface(folder.join(format!("{name}.obj")), &surface, &Default::default())?;
    }
    Ok(())
}

/// One row: best of three runs.
fn row(mesh: &TriMesh, level: u32, method: Method, search: SearchMode) -> Result<(), Box<dyn std::error::Error>> {
    let costs = EdgeCosts::euclidean(mesh);
    let progress = Progress::none();
    let mut best: Option<serde_json::Value> = None;
    let mut least = f64::INFINITY;
    for _ in 0..3 {
        let start = Instant::now();
        let options = CutOptions { search, base: None };
        let mut cutting = cut_to_disk(mesh, &costs, method, &options, &progress)?;
        let single = start.elapsed().as_secs_f64();
        let cost = cutting.cost();
        let first = cutting.cuts()[0].cost;
        let sides = cutting.tiling()?.complex.cells.values()[0].side_count();
        let start = Instant::now();
        let report = cutting.quadrangulate(&QuadOptions { search, ..Default::default() })?;
        let quads = start.elapsed().as_secs_f64();
        let start = Instant::now();
        let tiling = cutting.tiling()?;
        let finish = start.elapsed().as_secs_f64();
        if single + quads < least {
            least = single + quads;
            best = Some(json!({
                "genus": Summary::of(mesh).genus, "level": level, "vertices": mesh.vertex_count(),
                "method": method, "search": search, "single_s": single, "quads_s": quads, "refined_mesh_s": finish,
                "sides": sides, "first_loop": first, "length": cost,
                "quadrangles": report.quadrangles, "quads_length": cutting.cost(),
                "greedy_diagonals": report.greedy_cost, "optimal_diagonals": report.optimal_cost,
                "length_on_refined_mesh": tiling.cut_length(), "refined_vertices": tiling.mesh().vertex_count(),
                "defects": tiling.check().len(),
            }));
        }
    }
    println!("{}", best.ok_or("no run")?);
    Ok(())
}
