//! Makes integer-grid maps of OBJ files and prints what each rung did.
//!
//! `cargo run --release -p quadloom-param --example map_model -- --quads 3000 FILE.obj...`
#![allow(clippy::print_stdout)]

use clap::Parser;
use quadloom_field::{CrossField, FieldConstraints, FieldOptions, SizeField, Transport};
use quadloom_mesh::features::FeatureOptions;
use quadloom_mesh::remesh::{RemeshOptions, TargetLength, isotropic};
use quadloom_mesh::{DVec3, FaceId, FeatureGraph, MeshError, Progress, TriMesh, metric};
use quadloom_param::{Charts, MapDefect, ParamOptions, Parametrization, Parametrizer, make_room, solve_open_field};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Lattice units per grid unit, as a divisor for printing.
const UNIT: f64 = quadloom_param::GRID_UNIT as f64;

/// Makes integer-grid maps of OBJ files and prints what each rung did
#[derive(Parser)]
struct Settings {
    /// The surfaces: clean triangle meshes
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Number of quads
    #[arg(long, default_value_t = 3000.0)]
    quads: f64,
    /// Edges that bend by more are features, degrees; 180 for none
    #[arg(long, default_value_t = 35.0)]
    sharp: f64,
    /// Loose chains shorter than so many quad edges are dropped
    #[arg(long, default_value_t = 5.0)]
    loose: f64,
    /// Open pieces must bend by so many degrees more than the surface beside them
    #[arg(long, default_value_t = 12.0)]
    contrast: f64,
    /// Price of a singularity beside a feature, radians²
    #[arg(long, default_value_t = 0.5)]
    crowding_cost: f64,
    /// Price of every quarter of index, radians²
    #[arg(long, default_value_t = 0.0)]
    singularity_cost: f64,
    /// Price of a near pair of opposite index, radians²
    #[arg(long, default_value_t = 1.0)]
    near_pair_cost: f64,
    /// List the first folded triangles
    #[arg(long)]
    folds: bool,
}

/// A work mesh with its features and field.
struct Model {
    mesh: TriMesh,
    features: FeatureGraph,
    field: CrossField,
    /// Length of a quad's edge.
    edge: f64,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let settings = Settings::parse();
    for path in &settings.files {
        let mut clock = Instant::now();
        let mut lap = || std::mem::replace(&mut clock, Instant::now()).elapsed().as_secs_f64();
        let model = prepare(path, &settings)?;
        let prepare_seconds = lap();
        let mut parametrizer = Parametrizer::new(&model.mesh, &model.features, &model.field)?;
        let size = SizeField::uniform(model.mesh.face_count(), model.edge);
        let result = parametrizer.map(&size, &ParamOptions::default(), &Progress::none())?;
        let map_seconds = lap();
        println!("{} work mesh and field {prepare_seconds:.2} s, map {map_seconds:.2} s", path.display());
        print_rungs(&model, parametrizer.charts(), &result);
        if settings.folds {
            print_folds(&model, parametrizer.charts(), &result);
        }
        print_defects(&model, &result);
    }
    Ok(())
}

/// Work mesh, features and field as the pipeline makes them.
fn prepare(path: &Path, settings: &Settings) -> Result<Model, Box<dyn std::error::Error>> {
    let progress = Progress::none();
    let input = read_obj(&std::fs::read_to_string(path)?)?;
    let edge = (input.area() / settings.quads).sqrt();
    let options = FeatureOptions {
        sharp_angle: Some(settings.sharp),
        min_loose_length: settings.loose * edge,
        min_piece_length: 4.0 * edge,
        min_contrast: settings.contrast,
        ..Default::default()
    };
    let (features, _) = FeatureGraph::detect(&input, &options);
    let target = TargetLength::Uniform(0.55 * edge);
    let work = isotropic(&input, &features, target, &RemeshOptions::default(), &progress)?;
    let (mesh, features) = (work.mesh, work.features);
    let length = metric::edge_lengths(&mesh);
    let transport = Transport::new(&mesh, &length);
    let (constraints, _) = FieldConstraints::from_features(&mesh, &transport, &length, &features);
    let options = FieldOptions {
        cancel_distance: 1.5 * edge,
        crowding_cost: settings.crowding_cost,
        singularity_cost: settings.singularity_cost,
        near_pair_cost: settings.near_pair_cost,
        ..Default::default()
    };
    let (field, report) = solve_open_field(&mesh, &transport, &length, &features, &constraints, &options, &progress)?;
    println!("{report:?}");
    match make_room(&mesh, &features, &features, &field)? {
        Some((refined, field)) => Ok(Model { mesh: refined.mesh, features: refined.features, field, edge }),
        None => Ok(Model { mesh, features, field, edge }),
    }
}

fn print_rungs(model: &Model, charts: &Charts, result: &Parametrization) {
    let r = &result.report;
    println!(
        "    faces {} singular {} features {} collapsed {} integers {}",
        model.mesh.face_count(),
        charts.singular.len(),
        model.features.edge_count(),
        charts.collapsed_sectors.len(),
        r.integers,
    );
    println!(
        "    inverted: solve {} | stiffen {} ({} solves) | untangle {} ({} steps) | left {} {:?}",
        r.inverted_after_solve,
        r.stiffen.inverted_after,
        r.stiffen.iterations,
        r.untangle.inverted_after,
        r.untangle.steps,
        result.inverted.len(),
        r.rung,
    );
    println!("    separation {:?}, seconds {:.2?}", r.separation, r.seconds);
}

/// Corners of folded triangles with what the map must do there: f feature, c corner, i integer, s index in quarters.
fn print_folds(model: &Model, charts: &Charts, result: &Parametrization) {
    let mesh = &model.mesh;
    let length = metric::edge_lengths(mesh);
    let (on, angles) = (model.features.feature_vertices(mesh), metric::corner_angles(mesh, &length));
    println!("    collapsed sectors at {:?}", charts.collapsed_sectors);
    let seamless: &[FaceId] = result.report.separation.as_ref().map_or(&[], |s| &s.seamless_inverted_faces);
    println!("    folds of the seamless map: {}", seamless.len());
    for &f in seamless.iter().chain(result.inverted.iter().take(10)) {
        let corners = mesh.face_vertices(f).map(|v| {
            let mark = |holds: bool, letter: &'static str| if holds { letter } else { "" };
            let index = charts.singular.iter().find(|s| s.0 == v).map_or(String::new(), |s| format!("s{}", s.1));
            let (f, c) = (mark(on[v], "f"), mark(model.features.is_corner[v], "c"));
            format!("{v}{f}{c}{}{index}", mark(charts.is_integer[v], "i"))
        });
        println!("    {f} {corners:?} {:?}", result.map.face_uv(mesh, f).map(|p| p.map(|x| x as f64 / UNIT)));
        let degrees = mesh.face_half_edges(f).map(|h| angles[h].to_degrees().round());
        println!("        angles {degrees:?} valences {:?}", mesh.face_vertices(f).map(|v| mesh.valence(v)));
    }
}

/// What the map violates besides folds, and fans that are wound otherwise than the field says.
fn print_defects(model: &Model, result: &Parametrization) {
    let (mesh, transport) = (&model.mesh, Transport::of(&model.mesh));
    for v in mesh.vertices().filter(|&v| !mesh.is_boundary_vertex(v)) {
        let (quarters, index) = (result.map.quarters(mesh, v), model.field.index(mesh, &transport, v));
        if 4 - index != quarters {
            println!("    {v} index {index}, {quarters} quarter turns, valence {}", mesh.valence(v));
        }
    }
    let defects = result.map.check(mesh, &model.features);
    let others: Vec<_> = defects.iter().filter(|d| !matches!(d, MapDefect::Inverted(_))).collect();
    if let [first, ..] = others[..] {
        println!("    {} DEFECTS, first {first:?}", others.len());
    }
}

/// Clean triangle meshes only: `v x y z` and `f a b c`; unused vertices are dropped.
fn read_obj(text: &str) -> Result<TriMesh, MeshError> {
    let (mut positions, mut faces) = (Vec::new(), Vec::new());
    for line in text.lines() {
        let mut word = line.split_whitespace();
        match word.next() {
            Some("v") => {
                let x: Vec<f64> = word.take(3).filter_map(|w| w.parse().ok()).collect();
                positions.push(DVec3::new(x[0], x[1], x[2]));
            }
            Some("f") => {
                let i: Vec<u32> = word.filter_map(|w| w.split('/').next()?.parse().ok()).collect();
                faces.push([i[0] - 1, i[1] - 1, i[2] - 1]);
            }
            _ => {}
        }
    }
    let mut number = vec![u32::MAX; positions.len()];
    let mut used = Vec::new();
    for corner in faces.as_flattened_mut() {
        let n = &mut number[*corner as usize];
        if *n == u32::MAX {
            *n = used.len() as u32;
            used.push(positions[*corner as usize]);
        }
        *corner = *n;
    }
    TriMesh::new(used, &faces)
}
