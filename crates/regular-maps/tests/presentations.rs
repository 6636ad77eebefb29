//! The group orders of the given presentations.
//!
//! In: `../shared/research/regular-maps`, where it is there. Holds: each presentation has the stated order, type, Petrie
//! length and counts.

use quadloom_regular_maps::{CosetLimit, Presentation, RegularMap, Word};
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

fn number(text: &str) -> usize {
    text.parse().unwrap()
}

#[test]
fn all_presentations_have_their_orders() {
    let Some(rows) = table("regular_maps_g02_24.tsv") else { return };
    for row in rows {
        let extra = row[14].split(", ").filter(|w| !w.is_empty()).map(|w| Word::parse(w).unwrap()).collect();
        let presentation = Presentation::new(number(&row[4]), number(&row[5]), extra);
        let map = RegularMap::from_presentation(&presentation, CosetLimit::default()).unwrap();
        let found = [map.petrie(), map.order(), map.vertex_count(), map.edge_count(), map.face_count(), map.genus()];
        let stated = [6, 7, 8, 9, 10, 3].map(|k| number(&row[k]));
        assert_eq!(found, stated, "{}", row[0]);
        assert_eq!(map.multiplicities(), [number(&row[11]), number(&row[12])], "{}", row[0]);
        assert_eq!(map.is_self_dual().to_string(), row[13], "{}", row[0]);
        assert!(map.is_orientable());
    }
}

#[test]
fn large_maps_have_their_orders() {
    let Some(rows) = table("large_maps.tsv") else { return };
    for row in rows {
        let words = row[5].split(',').map(|digits| {
            let text: Vec<String> = digits.trim().chars().map(|d| format!("r{d}")).collect();
            Word::parse(&text.join("*")).unwrap()
        });
        let presentation = Presentation::new(number(&row[1]), number(&row[2]), words.collect());
        let map = RegularMap::from_presentation(&presentation, CosetLimit::default()).unwrap();
        assert_eq!([map.genus(), map.petrie(), map.order()], [0, 3, 4].map(|k| number(&row[k])));
    }
}
