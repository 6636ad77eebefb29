//! Makes the catalogue of regular maps, or measures how long the search takes.
//!
//! ```sh
//! cargo run --release -p quadloom-regular-maps --example make_catalogue          # writes data/regular_maps.tsv
//! cargo run --release -p quadloom-regular-maps --example make_catalogue -- --genus 2..15 --threads 1   # only measures
//! ```
//!
//! In: nothing. Out: all maps of the catalogue's genera, and the large maps of [Razafindrazaka2015] ch. 9, each found by a
//! search of its type. Holds: the same bytes on every machine.
#![allow(clippy::print_stdout)]

use quadloom_mesh::Progress;
use quadloom_regular_maps::catalogue::COMPLETE;
use quadloom_regular_maps::enumerate::{FoundMap, enumerate_maps, enumerate_type};
use quadloom_regular_maps::{Letter, Word};
use std::error::Error;
use std::fmt::Write;
use std::ops::RangeInclusive;
use std::time::Instant;

/// Genus, p, q, Petrie length of the large maps that the thesis draws; the second has no other of its type and genus.
const LARGE: [[usize; 4]; 4] = [[37, 3, 15, 20], [41, 4, 6, 40], [61, 4, 6, 60], [85, 4, 8, 28]];

const HEAD: &str = "\
# Reflexible orientable regular maps up to duality: all of genus 2 to 24, and the large ones of [Razafindrazaka2015] ch. 9.
# Made by: cargo run --release -p quadloom-regular-maps --example make_catalogue
# Relators besides R^p, S^q, T^2, (R*S)^2, (S*T)^2, (R*T)^2.
# genus\tp\tq\tpetrie\torder\tvertex multiplicity\tface multiplicity\tduality\trelators
";

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let value = |name: &str| arguments.iter().position(|a| a == name).and_then(|at| arguments.get(at + 1));
    if let Some(threads) = value("--threads") {
        rayon::ThreadPoolBuilder::new().num_threads(threads.parse()?).build_global()?;
    }
    match value("--genus") {
        Some(text) => measure(range(text)?),
        None => write_catalogue(),
    }
}

fn range(text: &str) -> Result<RangeInclusive<usize>, Box<dyn Error>> {
    let (from, to) = text.split_once("..").unwrap_or((text, text));
    Ok(from.parse()?..=to.parse()?)
}

fn measure(genera: RangeInclusive<usize>) -> Result<(), Box<dyn Error>> {
    let start = Instant::now();
    let maps = enumerate_maps(genera.clone(), &Progress::none())?;
    let seconds = start.elapsed().as_secs_f64();
    let counts: Vec<_> = genera.map(|g| maps.iter().filter(|m| m.map.genus() == g).count().to_string()).collect();
    println!("maps per genus: {}", counts.join(" "));
    println!("{} maps in {seconds:.2} s with {} threads", maps.len(), rayon::current_num_threads());
    Ok(())
}

fn write_catalogue() -> Result<(), Box<dyn Error>> {
    let start = Instant::now();
    let mut maps = enumerate_maps(COMPLETE, &Progress::none())?;
    println!("{} maps of genus {COMPLETE:?}: {:.1} s", maps.len(), start.elapsed().as_secs_f64());
    for [genus, p, q, petrie] in LARGE {
        let start = Instant::now();
        let found = enumerate_type(p, q, genus, &Progress::none())?;
        println!("genus {genus}, {{{p},{q}}}: {} maps, {:.1} s", found.len(), start.elapsed().as_secs_f64());
        maps.extend(found.into_iter().find(|found| found.map.petrie() == petrie));
    }
    let mut text = HEAD.to_string();
    for map in &maps {
        line(&mut text, map)?;
    }
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/data/regular_maps.tsv");
    std::fs::write(path, text)?;
    println!("{path}: {} maps", maps.len());
    Ok(())
}

fn line(text: &mut String, found: &FoundMap) -> std::fmt::Result {
    let FoundMap { map, presentation } = found;
    let [of_vertex, of_face] = map.multiplicities();
    let duality = if map.is_self_dual() { "self-dual" } else { "-" };
    let relators: Vec<String> = presentation.extra.iter().map(as_power).collect();
    let numbers = [map.genus(), map.p(), map.q(), map.petrie(), map.order(), of_vertex, of_face];
    numbers.iter().try_for_each(|n| write!(text, "{n}\t"))?;
    writeln!(text, "{duality}\t{}", relators.join(", "))
}

/// A word, as a power where it is one.
fn as_power(word: &Word) -> String {
    let letters: &[Letter] = word.letters();
    let n = letters.len();
    let repeats = |k: usize| n.is_multiple_of(k) && (k..n).all(|i| letters[i] == letters[i - k]);
    match (2..n).find(|&k| repeats(k)) {
        Some(k) => format!("({})^{}", Word::new(letters[..k].iter().copied()), n / k),
        None => word.to_string(),
    }
}
