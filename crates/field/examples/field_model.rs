//! Solves a cross field on OBJ files and prints singularities by index, energy and seconds.
//!
//! `cargo run --release -p quadloom-field --example field_model -- FILE.obj... [--raw] [--off] [--quads N] [--greedy] [--cost X] [--cancel X]`
#![allow(clippy::print_stdout)]

use quadloom_field::{FieldConstraints, FieldOptions, FieldStart, Transport, solve_cross_field};
use quadloom_mesh::features::FeatureOptions;
use quadloom_mesh::metric::edge_lengths;
use quadloom_mesh::remesh::{RemeshOptions, TargetLength, isotropic};
use quadloom_mesh::{DVec3, FeatureGraph, Progress, TriMesh};
use quadloom_numeric::Rounding;
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Shared machines: wall-clock and processor time differ, both are printed.
    let mut arguments = std::env::args().skip(1);
    let (mut files, mut options) = (Vec::new(), FieldOptions::default());
    let (mut sharp, mut cancel, mut quads, mut remeshed, mut loose) = (Some(35.0), 0.0, 3000.0, true, 2.0);
    while let Some(word) = arguments.next() {
        let mut number = || arguments.next().and_then(|s| s.parse::<f64>().ok()).unwrap_or(0.0);
        match word.as_str() {
            "--off" => sharp = None,
            "--greedy" => options.start = FieldStart::Rounded(Rounding::Greedy),
            "--exactly" => options.start = FieldStart::SmoothestExactly,
            "--direct" => options.start = FieldStart::Rounded(Rounding::Direct),
            "--one" => options.start = FieldStart::Rounded(Rounding::GreedyOneByOne),
            "--raw" => remeshed = false,
            "--quads" => quads = number(),
            "--loose" => loose = number(),
            "--no-search" => options.local_search = false,
            "--cost" => options.singularity_cost = number(),
            "--near" => options.near_pair_cost = number(),
            "--cancel" => cancel = number(),
            _ => files.push(word),
        }
    }
    println!(
        "{:24} {:>7} {:>6} | start {:>9} {:>5} | result {:>9} {:>5}  by index",
        "model", "faces", "fixed", "E", "sing", "E", "sing"
    );
    for file in files {
        let input = read_obj(&file)?;
        let target = (input.area() / quads).sqrt();
        let features = FeatureOptions { sharp_angle: sharp, min_loose_length: loose * target, ..Default::default() };
        let (features, _) = FeatureGraph::detect(&input, &features);
        let (mesh, features) = match remeshed {
            true => {
                let size = TargetLength::Uniform(0.55 * target);
                let work = isotropic(&input, &features, size, &RemeshOptions::default(), &Progress::none())?;
                (work.mesh, work.features)
            }
            false => (input, features),
        };
        let length = edge_lengths(&mesh);
        let (clock, cpu) = (Instant::now(), cpu_seconds());
        let transport = Transport::of(&mesh);
        let (constraints, _) = FieldConstraints::from_features(&mesh, &transport, &length, &features);
        let options = FieldOptions { cancel_distance: cancel * target, ..options.clone() };
        let (field, report) = solve_cross_field(&mesh, &transport, &length, &constraints, &options, &Progress::none())?;
        let seconds = clock.elapsed().as_secs_f64();
        let cpu = cpu_seconds() - cpu;
        let mut by_index = std::collections::BTreeMap::new();
        for (_, q) in field.singularities(&mesh, &transport) {
            *by_index.entry(q).or_insert(0) += 1;
        }
        let name = file.rsplit('/').next().unwrap_or(&file);
        println!(
            "{name:24} {:7} {:6} | {:9.3} {:5} | {:9.3} {:5} {by_index:?} moves {} pairs {} twists {} defects {} far {} | {:.3} + {:.3} = {seconds:.3} s, cpu {cpu:.3} s",
            mesh.face_count(),
            constraints.fixed_faces().count(),
            report.start_energy,
            report.start_singularities,
            report.energy,
            report.singularities,
            report.moves,
            report.cancelled_pairs,
            report.twists,
            field.check(&mesh, &transport).len(),
            field.far_matchings(&mesh, &transport).len(),
            report.seconds[0],
            report.seconds[1],
        );
    }
    Ok(())
}

/// Processor seconds of this thread, where the system tells (Linux); a loaded machine does not change them.
fn cpu_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    text.split(' ').next().and_then(|ns| ns.parse::<f64>().ok()).map_or(f64::NAN, |ns| 1e-9 * ns)
}

/// Positions and triangles of an OBJ file; unused vertices are dropped.
fn read_obj(file: &str) -> Result<TriMesh, Box<dyn std::error::Error>> {
    let text = std::fs::read_to_string(file)?;
    let (mut points, mut faces) = (Vec::new(), Vec::new());
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let c: Vec<f64> = words.take(3).map(str::parse).collect::<Result<_, _>>()?;
                points.push(DVec3::from_slice(&c));
            }
            Some("f") => {
                let ids: Vec<u32> = words
                    .map(|w| w.split('/').next().unwrap_or(w).parse::<u32>().map(|i| i - 1))
                    .collect::<Result<_, _>>()?;
                for k in 1..ids.len() - 1 {
                    faces.push([ids[0], ids[k], ids[k + 1]]);
                }
            }
            _ => {}
        }
    }
    let mut used = vec![u32::MAX; points.len()];
    let mut kept = Vec::new();
    for v in faces.as_flattened_mut() {
        let slot = &mut used[*v as usize];
        if *slot == u32::MAX {
            *slot = kept.len() as u32;
            kept.push(points[*v as usize]);
        }
        *v = *slot;
    }
    Ok(TriMesh::new(kept, &faces)?)
}
