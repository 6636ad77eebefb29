//! Writes the skeleton of a map as polylines.
//!
//! In: a presentation `R^8, S^3, …`, a file name, optionally a point group. Out: an OBJ file of `l` elements.
#![allow(clippy::print_stdout)]

use quadloom_mesh::Progress;
use quadloom_regular_maps::{CosetLimit, Presentation, RegularMap};
use quadloom_tubification::skeleton::{self, RelaxOptions, Relaxed, Skeleton, Symmetry, clearance};
use std::error::Error;
use std::fmt::Write;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [text, path, rest @ ..] = arguments.as_slice() else {
        return Err("usage: skeleton 'R^p, S^q, …' OUT.obj [exact|auto|none|C3|D2|T|O|I] [dual]".into());
    };
    let mut presentation = Presentation::parse(text)?;
    if rest.iter().any(|r| r == "dual") {
        presentation = presentation.dual();
    }
    let map = RegularMap::from_presentation(&presentation, CosetLimit::default())?;
    let started = std::time::Instant::now();
    let (skeleton, name) = make(&map, rest.first().map_or("exact", String::as_str))?;
    skeleton.check(&map)?;
    let (v, e) = (map.vertex_count(), map.edge_count());
    let seconds = started.elapsed().as_secs_f64();
    println!("{map} {v}/{e} {name} clearance {:.4} {seconds:.1} s", clearance(&map, &skeleton));
    std::fs::write(path, obj(&skeleton)?)?;
    Ok(())
}

fn make(map: &RegularMap, how: &str) -> Result<(Skeleton, String), Box<dyn Error>> {
    if how == "exact"
        && let Some(skeleton) = skeleton::spherical(map).or_else(|| skeleton::torus(map))
    {
        return Ok((skeleton, "exact".into()));
    }
    let symmetry = match how {
        "exact" | "auto" => Symmetry::Auto,
        "none" => Symmetry::None,
        name => Symmetry::Named(name.parse()?),
    };
    let options = RelaxOptions { symmetry, ..RelaxOptions::default() };
    let Relaxed { skeleton, symmetry, .. } = skeleton::relax(map, &options, &Progress::none())?;
    Ok((skeleton, symmetry.group.to_string()))
}

fn obj(skeleton: &Skeleton) -> Result<String, std::fmt::Error> {
    let mut text = String::new();
    let mut next = 1;
    for edge in &skeleton.edges {
        edge.iter().try_for_each(|p| writeln!(text, "v {} {} {}", p.x, p.y, p.z))?;
        let indices: Vec<_> = (next..next + edge.len()).map(|i| i.to_string()).collect();
        writeln!(text, "l {}", indices.join(" "))?;
        next += edge.len();
    }
    Ok(text)
}
