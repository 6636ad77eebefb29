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

type Fallible<T> = Result<T, Box<dyn Error>>;

/// Name, stated order and group.
type Row = (String, usize, Presentation);

/// The rows of a table; name and stated order by column.
fn table(
    folder: &Path,
    name: &str,
    [map, order]: [usize; 2],
    group: fn(&[String]) -> Fallible<Presentation>,
) -> Fallible<Vec<Row>> {
    tables::rows(folder, name)?.iter().map(|r| Ok((r[map].clone(), r[order].parse()?, group(r)?))).collect()
}

fn measure(table: &[Row]) -> Value {
    let enumerate = |(_, _, group): &Row| {
        enumerate_cosets(&group.relators(), &[], CosetLimit::default()).map_or(0, |cosets| cosets.len())
    };
    let (orders, seconds) = tables::timed(|| table.iter().map(enumerate).collect::<Vec<_>>());
    let wrong: Vec<Value> = table
        .iter()
        .zip(&orders)
        .filter(|((_, stated, _), found)| stated != *found)
        .map(|((name, stated, _), found)| json!({ "map": name, "stated": stated, "found": found }))
        .collect();
    json!({ "presentations": table.len(), "wrong": wrong, "seconds": seconds })
}
