//! Relaxes the skeletons of all targets of a table of source maps and prints their clearances.
//!
//! In: lines `p q relators` (relators in R, S, T), a folder. Out: a line per target, an OBJ file each.
#![allow(clippy::print_stdout)]

use quadloom_mesh::Progress;
use quadloom_regular_maps::matching::{MatchOptions, find_matches};
use quadloom_regular_maps::{CosetLimit, Presentation, RegularMap};
use quadloom_tubification::skeleton::{self, RelaxOptions, Skeleton, Symmetry};
use std::collections::BTreeSet;
use std::error::Error;
use std::fmt::Write;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [table, folder, rest @ ..] = arguments.as_slice() else {
        return Err("usage: target_skeletons TABLE FOLDER [only {p,q}_r or V/E …]".into());
    };
    let mut seen = BTreeSet::new();
    for line in std::fs::read_to_string(table)?.lines() {
        let source = RegularMap::from_presentation(&Presentation::parse(line)?, CosetLimit::default())?;
        for found in find_matches(&source, &MatchOptions::default()) {
            let target = found.target;
            let (v, e) = (target.vertex_count(), target.edge_count());
            let name = format!("{target} {v}/{e} {}", if target.is_orientable() { "" } else { "N" });
            if (rest.is_empty() || rest.iter().any(|only| name.contains(only))) && seen.insert(name.clone()) {
                relax(&target, &name, Path::new(folder))?;
            }
        }
    }
    Ok(())
}

fn relax(map: &RegularMap, name: &str, folder: &Path) -> Result<(), Box<dyn Error>> {
    let started = std::time::Instant::now();
    let steps = std::env::var("STEPS").ok().and_then(|s| s.parse().ok());
    let starts = std::env::var("STARTS").ok().and_then(|s| s.parse().ok());
    let mut options = RelaxOptions::default();
    options.steps = steps.unwrap_or(options.steps);
    options.starts = starts.unwrap_or(options.starts);
    if let Ok(group) = std::env::var("GROUP") {
        options.symmetry = if group == "none" { Symmetry::None } else { Symmetry::Named(group.parse()?) };
    }
    match skeleton::relax(map, &options, &Progress::none()) {
        Ok(found) => {
            let seconds = started.elapsed().as_secs_f64();
            println!("{name} {} clearance {:.4} {seconds:.1} s", found.symmetry.group, found.clearance);
            let file: String = name.chars().map(|c| if "{},/ ".contains(c) { '_' } else { c }).collect();
            std::fs::write(folder.join(format!("{file}.obj")), obj(&found.skeleton)?)?;
        }
        Err(error) => println!("{name} FAILED: {error}"),
    }
    Ok(())
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
