//! Realises a map and writes its surface as OBJ, a group per face.
//!
//! In: a presentation, a file name, optionally the type of a target such as `{3,3}_4`. Out: the file, and what was measured.
#![allow(clippy::print_stdout)]

use quadloom_mesh::Progress;
use quadloom_regular_maps::{CosetLimit, MatchOptions, Presentation, RegularMap, find_matches};
use quadloom_tubification::RealizeOptions;
use quadloom_tubification::realize::{realize, realize_on};
use std::error::Error;
use std::fmt::Write;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [text, path, rest @ ..] = arguments.as_slice() else {
        return Err("usage: realize RELATORS OUT.obj [TARGET]".into());
    };
    let map = RegularMap::from_presentation(&Presentation::parse(text)?, CosetLimit::default())?;
    let start = std::time::Instant::now();
    let (options, progress) = (RealizeOptions::default(), Progress::none());
    let found = match rest.first() {
        None => realize(&map, &options, &progress)?,
        Some(target) => {
            let matches = find_matches(&map, &MatchOptions::default());
            let found = matches.into_iter().find(|m| m.target.type_name() == *target).ok_or("no such target")?;
            realize_on(&map, found, &options, &progress)?
        }
    };
    let target = &found.matched.target;
    println!(
        "{map} on {target} {}/{} {:?} radius {:.4} rotations {} triangles {} intersections {} {:?} {:.2} s",
        target.vertex_count(),
        target.edge_count(),
        found.tubes.kind,
        found.tubes.surface.radius(),
        found.tubes.rotations.group,
        found.drawing.mesh.face_count(),
        found.intersections.len(),
        found.counts,
        start.elapsed().as_secs_f64()
    );
    let mesh = &found.drawing.mesh;
    let mut out = String::new();
    mesh.positions().values().iter().try_for_each(|p| writeln!(out, "v {} {} {}", p.x, p.y, p.z))?;
    for f in mesh.faces() {
        let [a, b, c] = mesh.face_vertices(f).map(|v| v.0 + 1);
        let group = if found.drawing.is_edge[f] { "edge".into() } else { map.face(found.drawing.flag[f]).to_string() };
        writeln!(out, "g {group}\nf {a} {b} {c}")?;
    }
    std::fs::write(path, out)?;
    Ok(())
}
