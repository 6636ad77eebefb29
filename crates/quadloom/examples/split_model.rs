//! Makes quads of OBJ files by splitting triangles, the last resort of the pipeline, and prints what came out:
//! `split_model [--quads N] [--out DIR] FILE…`; without `--quads`, a quarter of the triangles.
#![allow(clippy::print_stdout)]

use quadloom::count::CountGoal;
use quadloom::extract::{Reference, scaled_jacobian};
use quadloom::features::{FeatureRequest, find_features};
use quadloom::io::SurfaceOut;
use quadloom::mesh::repair::{RepairOptions, repair};
use quadloom::split::split_surface;
use quadloom::verify::verify;
use quadloom::{Progress, QuadMesh};
use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let (mut quads, mut out, mut files) = (None, None, Vec::new());
    let mut rest = std::env::args().skip(1);
    while let Some(argument) = rest.next() {
        let mut value = || rest.next().ok_or("an option lacks its value");
        match argument.as_str() {
            "--quads" => quads = Some(value()?.parse::<usize>()?),
            "--out" => out = Some(PathBuf::from(value()?)),
            _ => files.push(PathBuf::from(argument)),
        }
    }
    println!(
        "{:<20} {:>7} {:>7} {:>6} {:>9} {:>6} {:>6}  check",
        "model", "asked", "quads", "sec", "irregular", "sj", "worst"
    );
    let mut failures = 0;
    for file in &files {
        failures += usize::from(!run(file, quads, out.as_deref())?);
    }
    if failures > 0 { Err(format!("{failures} models fail").into()) } else { Ok(()) }
}

fn run(file: &Path, quads: Option<usize>, out: Option<&Path>) -> Result<bool, Box<dyn Error>> {
    let mesh = repair(&quadloom::io::read_soup(file)?, &RepairOptions::default())?.mesh;
    let wanted = quads.unwrap_or(mesh.face_count() / 4);
    let request = FeatureRequest { sharp_angle: Some(35.0), ..FeatureRequest::default() };
    let features = find_features(&mesh, &request, (mesh.area() / wanted as f64).sqrt()).graph;
    let start = Instant::now();
    let goal = CountGoal { quads: wanted as f64, tolerance: 0.05, solves: 4 };
    let made = split_surface(&mesh, &features, goal, &Progress::none());
    let seconds = start.elapsed().as_secs_f64();
    let name = file.file_stem().unwrap_or_default().to_string_lossy();
    let made = match made {
        Ok(made) => made,
        Err(error) => {
            println!("{name:<20} {wanted:>7} {:>7} {seconds:>6.2} {error}", "-");
            return Ok(false);
        }
    };
    let verification = verify(&made, &Reference::new(&mesh, &features));
    let jacobian: Vec<f64> =
        made.faces().map(|f| scaled_jacobian(made.face_vertices(f).map(|v| made.position(v)))).collect();
    println!(
        "{name:<20} {wanted:>7} {:>7} {seconds:>6.2} {:>9} {:>6.3} {:>6.3}  {}",
        made.face_count(),
        irregular(&made),
        jacobian.iter().sum::<f64>() / jacobian.len() as f64,
        jacobian.iter().fold(1.0, |a: f64, &b| a.min(b)),
        if verification.passed() { "ok".into() } else { verification.complaint() }
    );
    if let Some(directory) = out {
        std::fs::create_dir_all(directory)?;
        let path = directory.join(file.file_name().unwrap_or_default());
        quadloom::io::write_surface(path, &SurfaceOut::from(&made), &Default::default())?;
    }
    Ok(verification.passed())
}

fn irregular(mesh: &QuadMesh) -> usize {
    mesh.vertices().filter(|&v| !mesh.is_boundary_vertex(v) && mesh.valence(v) != 4).count()
}
