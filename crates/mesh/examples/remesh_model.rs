//! Remeshes OBJ files and prints what came out: `remesh_model [--quads N] [--sharp DEGREES] [--verbose] [--out DIR] FILE…`.
//!
//! The target edge length is 0.55·√(area / N): the edge of a work mesh for N quads.
#![allow(clippy::print_stdout, clippy::print_stderr)]

use quadloom_mesh::remesh::{RemeshOptions, Remeshed, TargetLength, isotropic};
use quadloom_mesh::repair::{RepairOptions, repair};
use quadloom_mesh::soup::FaceSoup;
use quadloom_mesh::topology::Summary;
use quadloom_mesh::{DVec3, FeatureGraph, Progress, TriMesh, features::FeatureOptions};
use std::error::Error;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

struct Arguments {
    quads: f64,
    sharp: f64,
    verbose: bool,
    out: Option<PathBuf>,
    files: Vec<PathBuf>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = arguments()?;
    println!(
        "{:<20} {:>7} {:>7} {:>7} {:>6} {:>6} {:>6} {:>6} {:>6} {:>6} {:>5}  check",
        "model", "in", "out", "sec", "min°", "max°", "good%", "reg%", "edge", "dev%", "long"
    );
    let mut failures = 0;
    for file in &arguments.files {
        failures += match run(file, &arguments) {
            Ok(passed) => usize::from(!passed),
            Err(error) => {
                println!("{:<20} {error}", file.display());
                1
            }
        };
    }
    if failures > 0 { Err(format!("{failures} models fail a check").into()) } else { Ok(()) }
}

fn arguments() -> Result<Arguments, Box<dyn Error>> {
    let mut found = Arguments { quads: 4000.0, sharp: 35.0, verbose: false, out: None, files: Vec::new() };
    let mut rest = std::env::args().skip(1);
    while let Some(argument) = rest.next() {
        let mut value = || rest.next().ok_or("an option lacks its value");
        match argument.as_str() {
            "--quads" => found.quads = value()?.parse()?,
            "--sharp" => found.sharp = value()?.parse()?,
            "--verbose" => found.verbose = true,
            "--out" => found.out = Some(value()?.into()),
            _ => found.files.push(argument.into()),
        }
    }
    Ok(found)
}

fn run(file: &Path, arguments: &Arguments) -> Result<bool, Box<dyn Error>> {
    let mesh = read_obj(file)?;
    let options =
        FeatureOptions { sharp_angle: (arguments.sharp > 0.0).then_some(arguments.sharp), ..FeatureOptions::default() };
    let (features, _) = FeatureGraph::detect(&mesh, &options);
    let target = 0.55 * (mesh.area() / arguments.quads).sqrt();
    let start = Instant::now();
    let size = TargetLength::Uniform(target);
    let result = isotropic(&mesh, &features, size, &RemeshOptions::default(), &Progress::none())?;
    let seconds = start.elapsed().as_secs_f64();
    let problems = problems(&mesh, &features, &result);
    let report = &result.report;
    if arguments.verbose {
        let vertices = features.feature_vertices(&mesh).values().iter().filter(|&&on| on).count();
        println!(
            "  {} chains through {vertices} of {} vertices; {report:?}",
            features.chains.len(),
            mesh.vertex_count()
        );
    }
    println!(
        "{:<20} {:>7} {:>7} {:>7.3} {:>6.1} {:>6.1} {:>6.2} {:>6.1} {:>6.2} {:>6.1} {:>5}  {}",
        file.file_stem().unwrap_or_default().to_string_lossy(),
        mesh.face_count(),
        result.mesh.face_count(),
        seconds,
        report.min_angle,
        report.max_angle,
        100.0 * report.good_angles,
        100.0 * report.regular_vertices,
        mean_edge(&result.mesh) / target,
        100.0 * deviation(&mesh, &result.mesh) / target,
        report.long_edges,
        if problems.is_empty() { "ok".into() } else { problems.join(", ") }
    );
    if let Some(directory) = &arguments.out {
        std::fs::create_dir_all(directory)?;
        std::fs::write(directory.join(file.file_name().unwrap_or_default()), obj(&result.mesh))?;
    }
    Ok(problems.is_empty())
}

/// What the result breaks of what remeshing promises.
fn problems(mesh: &TriMesh, features: &FeatureGraph, result: &Remeshed) -> Vec<String> {
    let mut list = Vec::new();
    let new = &result.mesh;
    let mut expect = |holds: bool, what: &str| {
        if !holds {
            list.push(what.to_string());
        }
    };
    expect(Summary::of(&**mesh).same_topology(&Summary::of(&**new)), "topology");
    expect(result.report.splits + result.report.collapses + result.report.moves > 0, "unchanged");
    let kept = features
        .chains
        .iter()
        .zip(&result.features.chains)
        .all(|(x, y)| x.kind == y.kind && x.closed == y.closed && y.vertices.len() >= if x.closed { 3 } else { 2 });
    expect(kept && features.chains.len() == result.features.chains.len(), "chains");
    let corners = |m: &TriMesh, g: &FeatureGraph| -> Vec<[u64; 3]> {
        let is_corner = |v: &quadloom_mesh::VertexId| g.is_corner[*v];
        let mut list: Vec<_> =
            m.vertices().filter(is_corner).map(|v| m.position(v).to_array().map(f64::to_bits)).collect();
        list.sort_unstable();
        list
    };
    expect(corners(mesh, features) == corners(new, &result.features), "corners");
    let on = result.features.feature_vertices(new);
    let bridges = new.edges().filter(|&e| !result.features.is_feature(e) && new.ends(e).iter().all(|&v| on[v])).count();
    expect(bridges == 0, "bridges");
    let flat = new.faces().filter(|&f| new.vector_area(f).length() <= 0.0).count();
    expect(flat == 0, "zero areas");
    // Normals of the input at the vertices that lie on no curve, where it has one.
    let turned = new
        .faces()
        .filter(|&f| {
            let free = new.face_vertices(f).into_iter().filter(|&v| !on[v] && !new.is_boundary_vertex(v));
            let normal: DVec3 = free.map(|v| mesh.face_normal(result.origin[v].face)).sum();
            new.face_normal(f).dot(normal) < 0.0
        })
        .count();
    expect(turned == 0, &format!("{turned} turned"));
    let folded = new
        .edges()
        .filter(|&e| {
            !result.features.is_feature(e)
                && quadloom_mesh::metric::dihedral_angle(new, new.half_edge(e)).to_degrees() > 120.0
        })
        .count();
    expect(folded == 0, &format!("{folded} folded"));
    list
}

fn mean_edge(mesh: &TriMesh) -> f64 {
    let length = quadloom_mesh::metric::edge_lengths(mesh);
    length.values().iter().sum::<f64>() / length.len().max(1) as f64
}

/// Largest distance of the input's vertices from the new mesh.
fn deviation(mesh: &TriMesh, new: &TriMesh) -> f64 {
    let index = quadloom_mesh::closest::ClosestPoint::new(new);
    mesh.positions().values().iter().map(|&p| index.query(p).distance).fold(0.0, f64::max)
}

fn read_obj(file: &Path) -> Result<TriMesh, Box<dyn Error>> {
    let text = String::from_utf8_lossy(&std::fs::read(file)?).into_owned();
    let mut soup = FaceSoup::default();
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let coordinates = words.take(3).map(str::parse).collect::<Result<Vec<f64>, _>>()?;
                soup.positions.push(DVec3::from_slice(coordinates.get(..3).ok_or("a vertex lacks a coordinate")?));
            }
            Some("f") => {
                let corner = |word: &str| -> Result<u32, Box<dyn Error>> {
                    let number = word.split('/').next().unwrap_or(word).parse::<i64>()?;
                    let index = if number < 0 { soup.positions.len() as i64 + number } else { number - 1 };
                    Ok(u32::try_from(index)?)
                };
                soup.faces.push(words.map(corner).collect::<Result<_, _>>()?);
            }
            _ => {}
        }
    }
    Ok(repair(&soup, &RepairOptions::default())?.mesh)
}

fn obj(mesh: &TriMesh) -> String {
    let mut text = String::new();
    for p in mesh.positions().values() {
        let _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z);
    }
    for f in mesh.faces() {
        let [a, b, c] = mesh.face_vertices(f).map(|v| v.0 + 1);
        let _ = writeln!(text, "f {a} {b} {c}");
    }
    text
}
