//! Tables of regular maps and of pairs, as far as the examples that time with them need.
//!
//! In: a folder with `regular_maps_g02_24.tsv`, `pairings_g02_24.tsv` and `large_maps.tsv`. Out: rows and presentations.

#![allow(dead_code, reason = "each example uses a part")]

use quadloom_regular_maps::{Presentation, Word};
use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The folder that the command line names.
pub fn folder() -> Result<PathBuf, Box<dyn Error>> {
    Ok(std::env::args().nth(1).ok_or("usage: FOLDER, the one with the tables")?.into())
}

/// The rows of a table without its head.
pub fn rows(folder: &Path, name: &str) -> Result<Vec<Vec<String>>, Box<dyn Error>> {
    let path = folder.join(name);
    let text = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    Ok(text.lines().skip(1).map(|l| l.split('\t').map(String::from).collect()).collect())
}

/// The group of a row of `regular_maps_g02_24.tsv`.
pub fn listed(row: &[String]) -> Result<Presentation, Box<dyn Error>> {
    let words = row[14].split(", ").filter(|w| !w.is_empty()).map(Word::parse).collect::<Result<_, _>>()?;
    Ok(Presentation::new(row[4].parse()?, row[5].parse()?, words))
}

/// The group of a row of `large_maps.tsv`: words there are the indices of reflections.
pub fn large(row: &[String]) -> Result<Presentation, Box<dyn Error>> {
    let word = |digits: &str| {
        let letters: Vec<String> = digits.trim().chars().map(|d| format!("r{d}")).collect();
        Word::parse(&letters.join("*"))
    };
    let words = row[5].split(',').map(word).collect::<Result<_, _>>()?;
    Ok(Presentation::new(row[1].parse()?, row[2].parse()?, words))
}

/// The result of a job, and the least seconds of three runs of it.
pub fn timed<T>(mut job: impl FnMut() -> T) -> (T, f64) {
    let mut once = || {
        let start = Instant::now();
        let result = job();
        (result, start.elapsed().as_secs_f64())
    };
    let (mut result, mut seconds) = once();
    for _ in 1..3 {
        let next = once();
        seconds = seconds.min(next.1);
        result = next.0;
    }
    (result, seconds)
}
