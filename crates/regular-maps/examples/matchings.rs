//! Matchings of every map of the tables, timed and compared with the listed pairs.
//!
//! ```sh
//! cargo run --release -p quadloom-regular-maps --example matchings -- FOLDER
//! ```
//!
//! In: see `tables`. Out: one JSON object: sources with a match and pairs, found and listed, what of the listed is missing,
//! and the seconds of the search for all maps together, one after another, best of three; groups are enumerated before.
#![allow(clippy::print_stdout)]

mod tables;

use quadloom_regular_maps::{CosetLimit, MatchOptions, Pole, RegularMap, TubeMatch, find_matches};
use serde_json::json;
use std::collections::BTreeSet;
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = tables::folder()?;
    let rows = tables::rows(&folder, "regular_maps_g02_24.tsv")?;
    let pairs = tables::rows(&folder, "pairings_g02_24.tsv")?;
    let maps = rows
        .iter()
        .map(|r| Ok(RegularMap::from_presentation(&tables::listed(r)?, CosetLimit::default())?))
        .collect::<Result<Vec<_>, Box<dyn Error>>>()?;
    let (found, seconds) =
        tables::timed(|| maps.iter().map(|map| find_matches(map, &MatchOptions::default())).collect::<Vec<_>>());
    let missing: Vec<String> = rows
        .iter()
        .zip(&found)
        .flat_map(|(row, found)| pairs.iter().filter(|p| p[1] == row[0]).map(move |p| (p, found)))
        .filter(|(pair, found)| !found.iter().any(|m| is_listed_as(m, pair)))
        .map(|(pair, _)| format!("{} on {}", pair[1], pair[6]))
        .collect();
    let listed: BTreeSet<&String> = pairs.iter().map(|p| &p[1]).collect();
    let lost = rows.iter().zip(&found).filter(|(row, found)| found.is_empty() && listed.contains(&row[0]));
    let result = json!({
        "maps": maps.len(),
        "sources": { "found": found.iter().filter(|f| !f.is_empty()).count(), "listed": listed.len() },
        "lost": lost.map(|(row, _)| row[0].clone()).collect::<Vec<_>>(),
        "pairs": { "found": found.iter().map(Vec::len).sum::<usize>(), "listed": pairs.len() },
        "missing": missing,
        "seconds": seconds,
    });
    println!("{result:#}");
    Ok(())
}

/// Whether a match is the one of a row: pole, type and Petrie length of the target, index, junctions, tubes, sides.
fn is_listed_as(found: &TubeMatch, row: &[String]) -> bool {
    let pole = match found.pole {
        Pole::Face => "F",
        Pole::Vertex => "V",
    };
    let stated = [4, 6, 8, 10, 12, 13].map(|k| row[k].as_str());
    let here = [
        pole.into(),
        found.target.type_name(),
        found.index.to_string(),
        found.target.is_orientable().to_string(),
        found.junctions().to_string(),
        found.tubes().to_string(),
    ];
    here == stated
}
