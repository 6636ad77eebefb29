//! Coset enumeration of every presentation of the tables, timed.
//!
//! ```sh
//! cargo run --release -p quadloom-regular-maps --example orders -- FOLDER
//! ```
//!
//! In: see `tables`. Out: one JSON object: how many presentations, which have another order than stated, the seconds of all
//! enumerations of a table together, one after another, best of three; reading the text is not in them.
#![allow(clippy::print_stdout)]

mod tables;

use quadloom_regular_maps::{CosetLimit, Presentation, enumerate_cosets};
use serde_json::{Value, json};
use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = tables::folder()?;
    let small = table(&folder, "regular_maps_g02_24.tsv", [0, 7], tables::listed)?;
    let large = table(&folder, "large_maps.tsv", [0, 4], tables::large)?;
    println!("{:#}", json!({ "listed": measure(&small), "large": measure(&large) }));
    Ok(())
}

/// A row of a table.
struct Stated {
    map: String,
    order: usize,
    group: Presentation,
}

/// The rows of a table, with the columns of name and order.
fn table(folder: &Path, name: &str, columns: [usize; 2], group: Reader) -> Result<Vec<Stated>, Box<dyn Error>> {
    let [map, order] = columns;
    let stated = |r: &Vec<String>| Ok(Stated { map: r[map].clone(), order: r[order].parse()?, group: group(r)? });
    tables::rows(folder, name)?.iter().map(stated).collect()
}

/// What makes a group of a row.
type Reader = fn(&[String]) -> Result<Presentation, Box<dyn Error>>;

fn measure(table: &[Stated]) -> Value {
    let enumerate = |row: &Stated| {
        enumerate_cosets(&row.group.relators(), &[], CosetLimit::default()).map_or(0, |cosets| cosets.len())
    };
    let (orders, seconds) = tables::timed(|| table.iter().map(enumerate).collect::<Vec<_>>());
    let wrong: Vec<Value> = table
        .iter()
        .zip(&orders)
        .filter(|(row, found)| row.order != **found)
        .map(|(row, found)| json!({ "map": row.map, "stated": row.order, "found": found }))
        .collect();
    json!({ "presentations": table.len(), "wrong": wrong, "seconds": seconds })
}
