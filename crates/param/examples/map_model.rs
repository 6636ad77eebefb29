//! Makes integer-grid maps of OBJ files and prints what each rung did.
//!
//! `cargo run --release -p quadloom-param --example map_model -- QUADS FILE.obj...`

use quadloom_field::{CrossField, FieldConstraints, FieldOptions, SizeField, Transport};
use quadloom_mesh::features::FeatureOptions;
use quadloom_mesh::remesh::{RemeshOptions, TargetLength, isotropic};
use quadloom_mesh::{DVec3, FeatureGraph, MeshError, Progress, TriMesh, metric};
use quadloom_param::{ParamOptions, Parametrizer, solve_open_field};
use std::time::Instant;

#[allow(clippy::print_stdout)]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let quads: f64 = arguments.next().ok_or("QUADS")?.parse()?;
    let progress = Progress::none();
    for path in arguments {
        let input = read_obj(&std::fs::read_to_string(&path)?)?;
        let edge = (input.area() / quads).sqrt();
        let mut clock = Instant::now();
        let mut lap = || std::mem::replace(&mut clock, Instant::now()).elapsed().as_secs_f64();
        let sharp_angle = std::env::var("SHARP").map_or(Some(35.0), |a| a.parse().ok());
        let options = FeatureOptions {
            sharp_angle,
            min_loose_length: std::env::var("LOOSE").map_or(5.0, |x| x.parse().unwrap_or(5.0)) * edge,
            min_piece_length: 4.0 * edge,
            min_contrast: std::env::var("CONTRAST").map_or(12.0, |x| x.parse().unwrap_or(12.0)),
            ..Default::default()
        };
        let (features, _) = FeatureGraph::detect(&input, &options);
        lap();
        let work =
            isotropic(&input, &features, TargetLength::Uniform(0.55 * edge), &RemeshOptions::default(), &progress)?;
        let remesh_seconds = lap();
        let (mesh, features) = (work.mesh, work.features);
        let length = metric::edge_lengths(&mesh);
        let transport = Transport::new(&mesh, &length);
        let constraints = FieldConstraints::from_features(&mesh, &transport, &length, &features);
        let field_options = FieldOptions {
            cancel_distance: 1.5 * edge,
            crowding_cost: std::env::var("CROWD").map_or(0.5, |x| x.parse().unwrap_or(0.5)),
            singularity_cost: std::env::var("SCOST").map_or(0.0, |x| x.parse().unwrap_or(0.0)),
            near_pair_cost: std::env::var("NPC").map_or(1.0, |x| x.parse().unwrap_or(1.0)),
            ..Default::default()
        };
        let (field, field_report): (CrossField, _) =
            solve_open_field(&mesh, &transport, &length, &features, &constraints.0, &field_options, &progress)?;
        let singular = field.singularities(&mesh, &transport).len();
        let field_seconds = lap();
        println!("{field_report:?}");
        let mut parametrizer = Parametrizer::new(&mesh, &features, &field)?;
        let collapsed = parametrizer.charts().collapsed_sectors.len();
        let size = SizeField::uniform(mesh.face_count(), edge);
        let result = parametrizer.map(&size, &ParamOptions::default(), &progress)?;
        let map_seconds = lap();
        let r = &result.report;
        println!(
            "{:24} faces {:6} singular {:4} features {:5} collapsed {:3} integers {:5} | solve {:4} stiffen {:4} ({}) untangle {:4} ({} steps) left {:4} {:?} {:?} | remesh {:.2} field {:.2} map {:.2} = {:.2} {:.2} {:.2}",
            path.rsplit('/').next().unwrap_or(""),
            mesh.face_count(),
            singular,
            features.edge_count(),
            collapsed,
            r.integers,
            r.inverted_after_solve,
            r.stiffen.inverted_after,
            r.stiffen.iterations,
            r.untangle.inverted_after,
            r.untangle.steps,
            result.inverted.len(),
            r.rung,
            r.separation,
            remesh_seconds,
            field_seconds,
            map_seconds,
            r.seconds[0],
            r.seconds[1],
            r.seconds[2],
        );
        if std::env::var_os("FOLDS").is_some() {
            let charts = parametrizer.charts();
            let on = features.feature_vertices(&mesh);
            println!("    collapsed sectors at {:?}", charts.collapsed_sectors);
            let seamless = r.separation.as_ref().map(|s| s.seamless_inverted_faces.clone()).unwrap_or_default();
            println!("    seamless folds {}", seamless.len());
            println!("    {:?}", r.separation.as_ref().map_or([0; 2], |s| s.inverted));
            for &f in seamless.iter().chain(&[quadloom_mesh::FaceId(0)]).chain(result.inverted.iter().take(10)) {
                let corners = mesh.face_vertices(f).map(|v| {
                    format!(
                        "{v}{}{}{}{}",
                        if on[v] { "f" } else { "" },
                        if features.is_corner[v] { "c" } else { "" },
                        if charts.is_integer[v] { "i" } else { "" },
                        charts.singular.iter().find(|s| s.0 == v).map_or(String::new(), |s| format!("s{}", s.1)),
                    )
                });
                println!(
                    "    {f} {corners:?} {:?}",
                    result.map.face_uv(&mesh, f).map(|p| p.map(|x| x as f64 / 16777216.0))
                );
                println!(
                    "        angles {:?} valences {:?}",
                    {
                        let a = metric::corner_angles(&mesh, &length);
                        mesh.face_half_edges(f).map(|h| a[h].to_degrees().round())
                    },
                    mesh.face_vertices(f).map(|v| mesh.valence(v))
                );
            }
        }
        let defects = result
            .map
            .check(&mesh, &features)
            .into_iter()
            .filter(|d| !matches!(d, quadloom_param::MapDefect::Inverted(_)))
            .count();
        for v in mesh.vertices().filter(|&v| !mesh.is_boundary_vertex(v)) {
            let (cone, quarters) = (result.map.cone(&mesh, v), result.map.quarters(&mesh, v));
            let field_index = field.index(&mesh, &transport, v);
            if 4 - field_index != quarters {
                println!(
                    "    {v} field index {field_index} cone {cone} quarters {quarters} valence {}",
                    mesh.valence(v)
                );
            }
        }
        if defects > 0 {
            println!("    {defects} DEFECTS, first {:?}", result.map.check(&mesh, &features)[0]);
        }
    }
    Ok(())
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
