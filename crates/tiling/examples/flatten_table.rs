//! Angle errors of maps with a free border on known shapes, as JSON lines ([Favreau2009] §5.2).
//!
//! `cargo run --release -p quadloom-tiling --example flatten_table`
#![allow(clippy::print_stdout, reason = "a program")]

use quadloom_mesh::{DVec3, Progress, TriMesh, VertexId, shapes};
use quadloom_tiling::maps::{MapMethod, MapOptions, PackingKind, map_tile};
use serde_json::json;
use std::f64::consts::TAU;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for (shape, mesh) in surfaces() {
        let kinds = [
            ("angle-based", MapMethod::AngleBased, PackingKind::default()),
            ("circles", MapMethod::Circles, PackingKind::InversiveDistance),
            ("touching circles", MapMethod::Circles, PackingKind::Tangent),
        ];
        for (name, method, packing) in kinds {
            let border = mesh.vertices().find(|&v| mesh.is_boundary_vertex(v)).unwrap_or(VertexId(0));
            let options = MapOptions { packing, allow_folds: true, ..MapOptions::default() };
            let map = map_tile(&mesh, &[border], method, &options, &Progress::none())?;
            let d = map.report.distortion;
            println!(
                "{}",
                json!({
                    "shape": shape, "faces": mesh.face_count(), "method": name,
                    "angle_mean_degrees": d.angle_mean, "angle_largest_degrees": d.angle_largest,
                    "area_mean": d.area_mean, "area_largest": d.area_largest, "rounds": map.report.rounds,
                    "folded": map.report.folded.len(), "overlaps": map.report.overlaps,
                })
            );
        }
    }
    Ok(())
}

fn surfaces() -> Vec<(String, TriMesh)> {
    let mut all = Vec::new();
    for n in [10, 20, 40] {
        all.push(("planar, jittered".to_string(), grid(n, |x, y| DVec3::new(x, y, 0.0), 0.3)));
        // A sector of the plane rolled up to a cone, without its tip and cut along a line: it unrolls exactly.
        let cone = |x: f64, y: f64| {
            let (r, t) = (0.2 + 0.8 * y, 0.95 * TAU * x);
            DVec3::new(0.6 * r * t.cos(), 0.6 * r * t.sin(), 0.8 * r)
        };
        all.push(("cone, cut".to_string(), grid(n, cone, 0.2)));
    }
    for levels in 2..=5 {
        all.push((
            "cone with its tip".to_string(),
            disk(levels, |p| DVec3::new(p.x, p.y, 0.7 * p.truncate().length())),
        ));
        all.push(("spherical cap of 60 degrees".to_string(), cap(levels)));
    }
    all
}

/// The unit square with n by n cells, their vertices moved by up to `jitter` of a cell, on a surface.
fn grid(n: u32, place: impl Fn(f64, f64) -> DVec3, jitter: f64) -> TriMesh {
    let at = |i: u32, j: u32| {
        let inside = |k: u32| k > 0 && k < n;
        let shift = |index: u64| jitter * (2.0 * shapes::random(3, index) - 1.0);
        let number = u64::from(i * (n + 1) + j);
        let x = f64::from(i) + if inside(i) { shift(2 * number) } else { 0.0 };
        let y = f64::from(j) + if inside(j) { shift(2 * number + 1) } else { 0.0 };
        place(x / f64::from(n), y / f64::from(n))
    };
    let positions = (0..=n).flat_map(|j| (0..=n).map(move |i| (i, j))).map(|(i, j)| at(i, j)).collect();
    let corner = |i: u32, j: u32| j * (n + 1) + i;
    let cells = (0..n).flat_map(|j| (0..n).map(move |i| (i, j)));
    let faces: Vec<[u32; 3]> = cells
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    TriMesh::new(positions, &faces).expect("a grid")
}

/// The part of a sphere above a height, as a disk of its own.
fn upper(mesh: &TriMesh, height: f64) -> TriMesh {
    let above = |v: u32| mesh.position(VertexId(v)).z >= height - 1e-9;
    let faces: Vec<[u32; 3]> = mesh.to_faces().into_iter().filter(|f| f.iter().all(|&v| above(v))).collect();
    let mut number = vec![u32::MAX; mesh.vertex_count()];
    let mut positions = Vec::new();
    for &v in faces.iter().flatten() {
        if number[v as usize] == u32::MAX {
            number[v as usize] = positions.len() as u32;
            positions.push(mesh.position(VertexId(v)));
        }
    }
    let faces: Vec<[u32; 3]> = faces.into_iter().map(|f| f.map(|v| number[v as usize])).collect();
    TriMesh::new(positions, &faces).expect("a cap")
}

fn cap(levels: u32) -> TriMesh {
    upper(&shapes::sphere(1.0, levels), 0.5)
}

/// A cap pressed flat, then placed by a function of the plane.
fn disk(levels: u32, place: impl Fn(DVec3) -> DVec3) -> TriMesh {
    let cap = cap(levels);
    let positions = cap.positions().values().iter().map(|p| place(DVec3::new(p.x, p.y, 0.0))).collect();
    TriMesh::new(positions, &cap.to_faces()).expect("a disk")
}
