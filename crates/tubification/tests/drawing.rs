//! Drawn maps are the source maps, whatever the surface looks like.
//!
//! In: `../shared/research/regular-maps`, where it is there. Holds: for every match of every listed source with at most
//! 3000 flags the drawn map passes its check: each flag one disk beside its three neighbours, counts, Euler characteristic.

use glam::DVec3;
use quadloom_regular_maps::{CosetLimit, FlagId, MatchOptions, Presentation, RegularMap, Word, find_matches};
use quadloom_tubification::{DrawOptions, Drawn, EdgeStyle, draw};
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

/// A place for every point that is no surface at all: what is drawn does not depend on it.
fn anywhere(flag: FlagId, u: f64, v: f64) -> (DVec3, DVec3) {
    (DVec3::new(f64::from(flag.0), u, v), DVec3::Z)
}

fn map(text: &str) -> RegularMap {
    RegularMap::from_presentation(&Presentation::parse(text).unwrap(), CosetLimit::default()).unwrap()
}

#[test]
fn kleins_quartic_is_drawn_in_every_style() {
    let klein = map("R^3, S^7, (R*S^-2)^4");
    let found = find_matches(&klein, &MatchOptions::default());
    assert!(found.iter().any(|m| m.target.p() == 3 && m.target.is_orientable()));
    for m in &found {
        for drawn in [Drawn::Map, Drawn::Dual] {
            for edges in [EdgeStyle::None, EdgeStyle::Bands(0.2), EdgeStyle::Tubes(0.2), EdgeStyle::Relief(0.3)] {
                let options = DrawOptions { drawn, edges, height: 0.1, steps: [4, 4] };
                let (drawing, counts) = draw(&klein, m, anywhere, &options).unwrap();
                assert_eq!(counts.edges, 84);
                assert_eq!(counts.faces, if drawn == Drawn::Map { 56 } else { 24 });
                assert!(drawing.mesh.face_count() > 1000);
            }
        }
    }
}

#[test]
fn a_drawing_with_two_flags_swapped_does_not_pass() {
    let klein = map("R^3, S^7, (R*S^-2)^4");
    let found = find_matches(&klein, &MatchOptions::default());
    let (mut drawing, _) = draw(&klein, &found[0], anywhere, &DrawOptions::default()).unwrap();
    let faces: Vec<_> = drawing.mesh.faces().collect();
    let [a, b] = [drawing.flag[faces[0]], FlagId(77)];
    assert_ne!(a, b);
    for f in faces {
        let g = drawing.flag[f];
        drawing.flag[f] = if g == a {
            b
        } else if g == b {
            a
        } else {
            g
        };
    }
    assert!(drawing.check(&klein).is_err());
}

#[test]
fn every_match_draws_its_source() {
    let Some(rows) = table("regular_maps_g02_24.tsv") else { return };
    let options = DrawOptions { edges: EdgeStyle::None, steps: [4, 4], ..DrawOptions::default() };
    let mut failed = Vec::new();
    for row in rows {
        let extra = row[14].split(", ").filter(|w| !w.is_empty()).map(|w| Word::parse(w).unwrap()).collect();
        let presentation = Presentation::new(row[4].parse().unwrap(), row[5].parse().unwrap(), extra);
        let source = RegularMap::from_presentation(&presentation, CosetLimit::default()).unwrap();
        for m in find_matches(&source, &MatchOptions::default()) {
            if let Err(error) = draw(&source, &m, anywhere, &options) {
                failed.push(format!("{} on {}: {error}", row[0], m.target));
            }
        }
    }
    assert!(failed.is_empty(), "{} {failed:#?}", failed.len());
}
