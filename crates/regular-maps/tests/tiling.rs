//! Flat pictures of maps.
//!
//! In: presentations, and `../shared/research/regular-maps`, where it is there. Holds: the polygon, glued by its labels,
//! is the map; pictures can be read.

use quadloom_regular_maps::tiling::{Centre, FlatTiling, LayoutOptions, Pieces};
use quadloom_regular_maps::{CosetLimit, Presentation, RegularMap, Word};
use std::path::PathBuf;

fn map(text: &str) -> RegularMap {
    RegularMap::from_presentation(&Presentation::parse(text).unwrap(), CosetLimit::default()).unwrap()
}

fn number(text: &str) -> usize {
    text.parse().unwrap()
}

/// All maps of the table, with their names; none, said aloud, where it is not there.
fn known_maps() -> Vec<(String, RegularMap)> {
    let path =
        PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/research/regular-maps/regular_maps_g02_24.tsv");
    let Ok(text) = std::fs::read_to_string(&path) else {
        #[allow(clippy::print_stderr)]
        {
            eprintln!("SKIPPED: {} is not there", path.display());
        }
        return Vec::new();
    };
    let rows = text.lines().skip(1).map(|line| line.split('\t').collect::<Vec<_>>());
    rows.map(|row| {
        let extra = row[14].split(", ").filter(|w| !w.is_empty()).map(|w| Word::parse(w).unwrap()).collect();
        let presentation = Presentation::new(number(row[4]), number(row[5]), extra);
        let map = RegularMap::from_presentation(&presentation, CosetLimit::default()).unwrap();
        (row[0].to_string(), map)
    })
    .collect()
}

#[test]
fn all_known_maps_are_glued_to_themselves() {
    for (name, map) in known_maps() {
        for centre in [Centre::Face, Centre::Vertex, Centre::Edge] {
            for pieces in [Pieces::Triangles, Pieces::Faces, Pieces::Vertices] {
                let tiling = FlatTiling::layout_with(&map, &LayoutOptions { centre, pieces }).unwrap();
                assert_eq!(tiling.check(), [], "{name} {map} {centre:?} {pieces:?}");
            }
        }
    }
}
