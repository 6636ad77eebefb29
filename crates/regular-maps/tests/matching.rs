//! Matches of sources with tubified targets.
//!
//! In: `../shared/research/regular-maps`, where it is there. Holds: every listed pair is found; the pairs of
//! [Razafindrazaka2015] §9.6 are.

use quadloom_regular_maps::{CosetLimit, MatchOptions, Presentation, RegularMap, Word, find_matches};
use std::path::PathBuf;

fn table(name: &str) -> Option<Vec<Vec<String>>> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/research/regular-maps").join(name);
    match std::fs::read_to_string(&path) {
        Ok(text) => Some(text.lines().skip(1).map(|l| l.split('\t').map(String::from).collect()).collect()),
        Err(_) => {
            #[allow(clippy::print_stderr)]
            {
                eprintln!("SKIPPED: {} is not there", path.display());
            }
            None
        }
    }
}

fn map_of(row: &[String]) -> RegularMap {
    let extra = row[14].split(", ").filter(|w| !w.is_empty()).map(|w| Word::parse(w).unwrap()).collect();
    let presentation = Presentation::new(row[4].parse().unwrap(), row[5].parse().unwrap(), extra);
    RegularMap::from_presentation(&presentation, CosetLimit::default()).unwrap()
}

#[test]
fn every_listed_pair_is_found() {
    let (Some(maps), Some(pairs)) = (table("regular_maps_g02_24.tsv"), table("pairings_g02_24.tsv")) else { return };
    let mut missing = Vec::new();
    let mut sources = 0;
    for row in maps {
        let map = map_of(&row);
        let found = find_matches(&map, &MatchOptions::default());
        sources += usize::from(!found.is_empty());
        for pair in pairs.iter().filter(|pair| pair[1] == row[0]) {
            let here = found.iter().any(|m| {
                m.target.type_name() == pair[6]
                    && m.index.to_string() == pair[8]
                    && m.junctions().to_string() == pair[12]
                    && m.tubes().to_string() == pair[13]
                    && m.target.is_orientable().to_string() == pair[10]
            });
            if !here {
                missing.push(format!("{} on {}", row[0], pair[6]));
            }
        }
    }
    assert!(missing.is_empty(), "{missing:?}");
    assert!(sources >= 85, "{sources}");
}

#[test]
fn large_maps_match() {
    let Some(rows) = table("large_maps.tsv") else { return };
    for (row, junctions) in rows.iter().zip([24, 80, 120, 84]) {
        let words = row[5].split(',').map(|digits| {
            let text: Vec<String> = digits.trim().chars().map(|d| format!("r{d}")).collect();
            Word::parse(&text.join("*")).unwrap()
        });
        let presentation = Presentation::new(row[1].parse().unwrap(), row[2].parse().unwrap(), words.collect());
        let map = RegularMap::from_presentation(&presentation, CosetLimit::default()).unwrap();
        let found = find_matches(&map, &MatchOptions::default());
        let list: Vec<_> = found.iter().map(|m| (m.target.type_name(), m.junctions(), m.tubes())).collect();
        assert!(found.iter().any(|m| m.junctions() == junctions), "genus {}: {list:?}", row[0]);
    }
}
