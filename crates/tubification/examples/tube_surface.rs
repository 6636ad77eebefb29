//! Writes the tube surface of a map as an OBJ file.
//!
//! In: a presentation in R, S, T; a file; options. Out: the quads, and on standard output what is known about them.
#![allow(clippy::print_stdout)]

use quadloom_mesh::{DVec3, Progress, QuadMesh};
use quadloom_regular_maps::{CosetLimit, Presentation, RegularMap};
use quadloom_tubification::skeleton::{self, RelaxOptions, Skeleton};
use quadloom_tubification::tubes::{TubeOptions, TubeSurface, build_without_intersections};
use std::error::Error;
use std::io::{BufWriter, Write};

const USAGE: &str = "usage: tube_surface PRESENTATION OUT.obj [radius=X] [levels=N] [softness=X]
  tetrahedron 'R^3,S^3'; cube 'R^4,S^3'; lantern 'R^2,S^12'; a torus 'R^4,S^4,(R*S^-1)^4'; half a cube 'R^4,S^3,(R*T*S)^3'";

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [presentation, file, rest @ ..] = arguments.as_slice() else {
        return Err(USAGE.into());
    };
    let map = RegularMap::from_presentation(&Presentation::parse(presentation)?, CosetLimit::default())?;
    let skeleton = skeleton_of(&map)?;
    let started = std::time::Instant::now();
    let surface = build_without_intersections(&map, &skeleton, &options(rest)?)?;
    report(&map, &skeleton, &surface, started.elapsed().as_secs_f64());
    write(surface.mesh(), file)
}

fn options(words: &[String]) -> Result<TubeOptions, Box<dyn Error>> {
    let mut options = TubeOptions::default();
    for word in words {
        match word.split_once('=') {
            Some(("radius", x)) => options.radius = Some(x.parse()?),
            Some(("levels", n)) => options.levels = n.parse()?,
            Some(("softness", x)) => options.softness = x.parse()?,
            _ => return Err(USAGE.into()),
        }
    }
    Ok(options)
}

fn skeleton_of(map: &RegularMap) -> Result<Skeleton, Box<dyn Error>> {
    match skeleton::exact(map) {
        Some(skeleton) => Ok(skeleton),
        None => Ok(skeleton::relaxed(map, &RelaxOptions::default(), &Progress::none())?),
    }
}

fn report(map: &RegularMap, skeleton: &Skeleton, surface: &TubeSurface, seconds: f64) {
    let clearance = skeleton::clearance(map, skeleton);
    println!("{map}: {} junctions, {} tubes, clearance {clearance:.4}", map.vertex_count(), map.edge_count());
    let mesh = surface.mesh();
    println!(
        "radius {:.4}, {} vertices, {} quads, {seconds:.2} s",
        surface.radius(),
        mesh.vertex_count(),
        mesh.face_count()
    );
}

fn write(mesh: &QuadMesh, file: &str) -> Result<(), Box<dyn Error>> {
    let mut out = BufWriter::new(std::fs::File::create(file)?);
    for DVec3 { x, y, z } in mesh.positions().values() {
        writeln!(out, "v {x} {y} {z}")?;
    }
    for [a, b, c, d] in mesh.to_faces() {
        writeln!(out, "f {} {} {} {}", a + 1, b + 1, c + 1, d + 1)?;
    }
    Ok(())
}
