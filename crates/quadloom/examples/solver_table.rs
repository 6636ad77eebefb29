//! Time and energy of the ways to round, on a model at several resolutions: cross field and integer-grid map.
//!
//! `cargo run --release -p quadloom --example solver_table -- FILE [TRIANGLES,... [METHOD,...]]` prints JSON; `cargo xtask
//! eval solver` makes the tables of it. Energies have their constants: 0 is a perfect field or map.
//! Source: the set-up of tables 5.1 and 5.2 of [Bommes2012].
#![allow(clippy::print_stdout, reason = "an example")]

use quadloom::features::{FeatureRequest, find_features};
use quadloom::mesh::remesh::{RemeshOptions, TargetLength, isotropic};
use quadloom::mesh::repair::{RepairOptions, repair};
use quadloom::mesh::{EdgeMap, FaceMap, metric};
use quadloom::stages::{WORK_EDGE_REL, WorkMesh, cross_field};
use quadloom::{Progress, Source, TriMesh, load};
use quadloom_field::{
    CrossField, FieldConstraints, FieldError, FieldOptions, FieldStart, SizeField, Transport, solve_cross_field,
};
use quadloom_numeric::{ExactOptions, Rounding, SolveError, SolveOptions, Solver, Updates};
use quadloom_param::Charts;
use quadloom_param::problem::{EnergyOptions, face_gradients, map_constraints, orientation_energy, variable_count};
use serde_json::{Value, json};
use std::error::Error;
use std::time::{Duration, Instant};

/// A method is given up after this long.
const LIMIT: Duration = Duration::from_secs(900);
/// The exact one earlier: it is asked for small problems only.
const EXACT_LIMIT: Duration = Duration::from_secs(60);

fn main() -> Result<(), Box<dyn Error>> {
    let mut words = std::env::args().skip(1);
    let Ok(source) = words.next().ok_or("FILE [TRIANGLES,... [METHOD,...]]")?.parse::<Source>();
    let sizes = words.next().unwrap_or_else(|| "200,1000,2000,20000".into());
    let names = words.next().unwrap_or_else(|| "direct,greedy,greedy with ladder,naive,exact".into());
    let methods: Vec<Method> = methods().into_iter().filter(|m| names.split(',').any(|n| n == m.0)).collect();
    let surface = repair(&load(&source)?, &RepairOptions::default())?.mesh;
    let mut rows = Vec::new();
    for size in sizes.split(',') {
        let work = coarsened(&surface, size.parse()?)?;
        rows.extend(field_rows(&work, &methods)?);
        rows.extend(map_rows(&work, &methods)?);
    }
    println!("{:#}", Value::from(rows));
    Ok(())
}

/// An isotropic mesh of about so many triangles, coarse where the surface is curved too; more where the topology needs
/// them.
fn coarsened(surface: &TriMesh, triangles: usize) -> Result<WorkMesh, Box<dyn Error>> {
    let even = RemeshOptions {
        max_deviation_rel: f64::INFINITY,
        max_chain_deviation_rel: f64::INFINITY,
        min_length_rel: 1.0,
        ..RemeshOptions::default()
    };
    let mut edge = equilateral_edge(surface.area() / triangles as f64);
    let mut best: Option<(f64, WorkMesh)> = None;
    for _ in 0..CORRECTIONS {
        let request = FeatureRequest { sharp_angle: Some(35.0), ..FeatureRequest::default() };
        let features = find_features(surface, &request, edge / WORK_EDGE_REL).graph;
        let made = isotropic(surface, &features, TargetLength::Uniform(edge), &even, &Progress::none())?;
        let ratio = made.mesh.face_count() as f64 / triangles as f64;
        let miss = ratio.ln().abs();
        if best.as_ref().is_none_or(|(least, _)| miss < *least) {
            let work = WorkMesh { binding: made.features.clone(), mesh: made.mesh, features: made.features };
            best = Some((miss, work));
        }
        if miss < CLOSE {
            break;
        }
        edge *= ratio.sqrt();
    }
    Ok(best.ok_or("no isotropic mesh was made")?.1)
}

/// Miss of the number of triangles, as a logarithm, at which it is close enough.
const CLOSE: f64 = 0.05;

/// Tries for the number of triangles.
const CORRECTIONS: usize = 8;

/// Edge length of an equilateral triangle of this area.
fn equilateral_edge(area: f64) -> f64 {
    (area * 4.0 / 3.0_f64.sqrt()).sqrt()
}

/// A name, a way to round, and how the relaxation follows.
type Method = (&'static str, Rounding, Updates);

fn methods() -> Vec<Method> {
    let exact = ExactOptions { time_limit: Some(EXACT_LIMIT), ..ExactOptions::default() };
    vec![
        ("direct", Rounding::Direct, Updates::Auto),
        ("greedy", Rounding::Greedy, Updates::Auto),
        ("greedy with ladder", Rounding::Greedy, Updates::Ladder),
        ("naive", Rounding::Naive, Updates::Auto),
        ("exact", Rounding::Exact(exact), Updates::Auto),
    ]
}

fn field_rows(work: &WorkMesh, methods: &[Method]) -> Result<Vec<Value>, Box<dyn Error>> {
    let mesh = &work.mesh;
    let length = metric::edge_lengths(mesh);
    let transport = Transport::new(mesh, &length);
    let (constraints, _) = FieldConstraints::from_features(mesh, &transport, &length, &work.binding);
    let mut rows = Vec::new();
    // The field has its own ways to follow a rounding: one greedy row only.
    for (name, rounding, _) in methods.iter().filter(|m| m.0 != "greedy with ladder") {
        let options =
            FieldOptions { start: FieldStart::Rounded(*rounding), local_search: false, ..FieldOptions::default() };
        let progress = Progress::none().with_time_limit(LIMIT);
        let begin = Instant::now();
        let solved = solve_cross_field(mesh, &transport, &length, &constraints, &options, &progress);
        let seconds = begin.elapsed().as_secs_f64();
        let found = match solved {
            Ok((_, report)) => {
                let proven =
                    report.rounding.as_ref().and_then(|r| r.exact).map(|e| json!({ "proven": e.proven, "gap": e.gap }));
                let integers = report.rounding.as_ref().map(|r| r.free_integers);
                json!({ "energy": report.energy, "integers": integers, "exact": proven })
            }
            Err(FieldError::Cancelled(_) | FieldError::Solve(SolveError::Cancelled)) => json!({ "given_up": true }),
            Err(FieldError::Solve(SolveError::TooManyIntegers { integers, .. })) => refused(integers),
            Err(other) => return Err(other.into()),
        };
        rows.push(row("field", name, mesh, seconds, found));
    }
    Ok(rows)
}

fn map_rows(work: &WorkMesh, methods: &[Method]) -> Result<Vec<Value>, Box<dyn Error>> {
    let mesh = &work.mesh;
    let edge = equilateral_edge(mesh.area() / mesh.face_count() as f64) / WORK_EDGE_REL;
    let field: CrossField = cross_field(work, edge, Default::default(), &Progress::none())?.0;
    let length: EdgeMap<f64> = metric::edge_lengths(mesh);
    let transport = Transport::new(mesh, &length);
    let charts = Charts::new(mesh, &length, &transport, &work.binding, &field);
    let constraints = map_constraints(mesh, &work.binding, &charts, &[]);
    let size = SizeField::uniform(mesh.face_count(), edge);
    let gradient = face_gradients(mesh, &length, &field, &size, &charts);
    let weight = FaceMap::filled(mesh.face_count(), 1.0);
    let energy = orientation_energy(mesh, &charts, &gradient, &weight, &EnergyOptions::default(), 1.0);
    let constant: f64 = 2.0 * gradient.values().iter().map(|g| g.area).sum::<f64>();
    let mut rows = Vec::new();
    for (name, rounding, updates) in methods {
        let begin = Instant::now();
        let cancelled = || begin.elapsed() > LIMIT;
        let mut solver = Solver::new(variable_count(&charts), &constraints.rows, &constraints.integers)?;
        let options = SolveOptions {
            rounding: *rounding,
            updates: *updates,
            cancelled: Some(&cancelled),
            ..SolveOptions::default()
        };
        let solved = solver.solve(&energy, &options);
        let seconds = begin.elapsed().as_secs_f64();
        let found = match solved {
            Ok(solution) => {
                let exact = solution.report.exact.map(|e| json!({ "proven": e.proven, "gap": e.gap }));
                let integers = solution.report.free_integers;
                json!({ "energy": solution.energy + constant, "integers": integers, "exact": exact })
            }
            Err(SolveError::Cancelled) => json!({ "given_up": true }),
            Err(SolveError::TooManyIntegers { integers, .. }) => refused(integers),
            Err(other) => return Err(other.into()),
        };
        rows.push(row("map", name, mesh, seconds, found));
    }
    Ok(rows)
}

/// The exact search keeps a dense matrix over the integers and refuses where that is too large.
fn refused(integers: usize) -> Value {
    json!({ "integers": integers, "refused": true })
}

fn row(problem: &str, method: &str, mesh: &TriMesh, seconds: f64, found: Value) -> Value {
    let mut row = json!({ "problem": problem, "method": method, "triangles": mesh.face_count(), "seconds": seconds });
    if let (Value::Object(row), Value::Object(found)) = (&mut row, found) {
        row.extend(found);
    }
    row
}
