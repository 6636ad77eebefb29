//! The catalogue: its maps, its names, and how names are found.
//!
//! In: the crate's data; `../shared/research/regular-maps`, where it is there. Holds: each presentation makes the map whose
//! numbers stand beside it; maps are those of the search and those of the independent list; every name finds its map.

use proptest::prelude::*;
use quadloom_mesh::Progress;
use quadloom_regular_maps::catalogue::{COMPLETE, CatalogueError, Entry, Filter, entries, find, identify, list};
use quadloom_regular_maps::enumerate::enumerate_maps;
use quadloom_regular_maps::{CosetLimit, Presentation, RegularMap, Word};
use std::path::PathBuf;

fn rows(name: &str) -> Option<Vec<Vec<String>>> {
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

fn map_of(p: &str, q: &str, words: Vec<Word>) -> RegularMap {
    let presentation = Presentation::new(number(p), number(q), words);
    RegularMap::from_presentation(&presentation, CosetLimit::default()).unwrap()
}

#[test]
fn entries_have_the_numbers_of_their_presentations() {
    assert_eq!(entries().len(), 429);
    for entry in entries() {
        let map = entry.map().unwrap();
        let found = [map.p(), map.q(), map.petrie(), map.order(), map.genus()];
        assert_eq!(found, [entry.p, entry.q, entry.petrie, entry.order, entry.genus], "{}", entry.identifier);
        let found = [map.vertex_count(), map.edge_count(), map.face_count()];
        assert_eq!(found, [entry.vertices, entry.edges, entry.faces], "{}", entry.identifier);
        assert_eq!((map.multiplicities(), map.is_self_dual()), (entry.multiplicities, entry.self_dual));
        assert!(map.is_orientable() && entry.p <= entry.q && !entry.dual);
    }
}

#[test]
fn the_search_finds_the_catalogue() {
    let found = enumerate_maps(COMPLETE, &Progress::none()).unwrap();
    let listed = list(&Filter { genus: Some(COMPLETE), kind: None });
    assert_eq!(found.len(), listed.len());
    for (found, entry) in found.iter().zip(listed) {
        assert_eq!(found.presentation, entry.presentation, "{}", entry.identifier);
    }
    let counts: Vec<_> = COMPLETE.map(|g| list(&Filter { genus: Some(g..=g), kind: None }).len()).collect();
    let to_15 = [6, 12, 12, 16, 13, 12, 11, 32, 24, 14, 11, 22, 12, 23];
    assert_eq!(counts, [&to_15[..], &[17, 40, 14, 35, 13, 40, 18, 11, 17]].concat());
}

/// The list there was made by another program; of a map and its dual of the same type it may have the other one.
#[test]
fn the_independent_list_has_the_same_maps() {
    let Some(rows) = rows("regular_maps_g02_24.tsv") else { return };
    assert_eq!(rows.len(), list(&Filter { genus: Some(COMPLETE), kind: None }).len());
    let mut met = Vec::new();
    for row in rows {
        let words = row[14].split(", ").filter(|w| !w.is_empty()).map(|w| Word::parse(w).unwrap()).collect();
        let map = map_of(&row[4], &row[5], words);
        let entry = identify(&map).unwrap_or_else(|| panic!("{} is missing", row[0]));
        let [vertices, faces, of_vertex, of_face] = [8, 10, 11, 12].map(|k| number(&row[k]));
        assert_eq!([3, 6, 7, 9].map(|k| number(&row[k])), [entry.genus, entry.petrie, entry.order, entry.edges]);
        assert_eq!([vertices, faces], [entry.vertices, entry.faces], "{}", row[0]);
        assert_eq!([of_vertex, of_face], entry.multiplicities, "{}", row[0]);
        assert_eq!(row[13] == "true", entry.self_dual, "{}", row[0]);
        assert_eq!(entry.map().unwrap(), map, "{}", row[0]);
        let upright = if entry.dual { entry.dual() } else { entry };
        let name = (row[2] != "ambiguous").then(|| row[1].clone());
        assert_eq!(upright.name, name, "{}", row[0]);
        met.push(upright.identifier);
    }
    met.sort();
    met.dedup();
    assert_eq!(met.len(), 425);
}

#[test]
fn large_maps_are_those_of_the_independent_list() {
    let Some(rows) = rows("large_maps.tsv") else { return };
    for row in rows {
        let words = row[5].split(',').map(|digits| {
            let text: Vec<String> = digits.trim().chars().map(|d| format!("r{d}")).collect();
            Word::parse(&text.join("*")).unwrap()
        });
        let entry = identify(&map_of(&row[1], &row[2], words.collect())).expect("a large map");
        assert_eq!(entry.identifier, format!("{{{},{}}}_{}#{}.1", row[1], row[2], row[3], row[0]));
    }
}

#[test]
fn names_find_maps() {
    let found = |name: &str| find(name).unwrap_or_else(|e| panic!("{e}")).identifier;
    for name in ["R3.1", "r3.1", " R3.1 ", "{3,7}_8#3.1", "{3,7}_8", "{3,7}#3", "{3, 7}_8", "{7,3}_8'", "R3.1''"] {
        assert_eq!(found(name), "{3,7}_8#3.1", "{name}");
    }
    for name in ["R3.1'", "R3.1′", "R3.1 ’", "{7,3}_8", "{3,7}_8'", "{3,7}_8#3.1'"] {
        assert_eq!(found(name), "{3,7}_8#3.1'", "{name}");
    }
    assert_eq!(["R9.3", "R9.4"].map(found), ["{4,6}_24#9.4", "{4,6}_6#9.3"]);
    assert_eq!(["R37.2", "R41.3"].map(found), ["{3,15}_20#37.1", "{4,6}_40#41.1"]);
}

#[test]
fn sphere_and_torus_have_names() {
    let numbers = |name: &str| find(name).map(|e| (e.genus, e.faces, e.identifier)).unwrap();
    assert_eq!(numbers("cube"), (0, 6, "{4,3}".into()));
    assert_eq!(numbers("{4,3}_6"), numbers("Cube"));
    assert_eq!(numbers("cube'"), (0, 8, "{4,3}'".into()));
    assert_eq!(find("{3,5}").unwrap().name.as_deref(), Some("icosahedron"));
    assert_eq!(numbers("hosohedron 6"), (0, 6, "{2,6}".into()));
    assert_eq!(numbers("{2,6}"), numbers("hosohedron 6"));
    assert_eq!(numbers("dihedron 5"), (0, 2, "{5,2}".into()));
    assert_eq!(numbers("{4,4}_(3,0)"), (1, 9, "{4,4}_(3,0)".into()));
    assert_eq!(numbers("{4,4}_(0,3)"), numbers("{4,4}_(3,0)"));
    assert_eq!(numbers("{3,6}_(2,2)"), (1, 24, "{3,6}_(2,2)".into()));
    assert_eq!(numbers("{6,3}_{1,1}"), (1, 3, "{6,3}_(1,1)".into()));
}

#[test]
fn an_unknown_name_says_what_there_is() {
    let message = |name: &str| find(name).unwrap_err().to_string();
    assert!(message("R3.13").contains("genus 3 has 12 maps up to duality, R3.1 to R3.12"));
    assert!(message("R3.0").contains("12 maps"));
    assert!(message("R25.1").contains("genus 2 to 24"));
    assert!(message("R37.1").contains("only R37.2"));
    assert!(message("R0.1").contains("solids") && message("R1.1").contains("torus"));
    assert!(message("{3,7}_9").contains("{3,7}_8#3.1"));
    assert!(message("{3,11}").contains("none of them of type {3,11}"));
    assert!(message("{4,4}").contains("infinitely many"));
    assert!(message("{4,4}_(2,1)").contains("chiral"));
    assert!(message("{3,7}_(2,0)").contains("types of the torus"));
    assert!(message("{3,5}_5").contains("{3,5}"));
    assert!(message("Klein").contains("no name of a map"));
    assert!(message("{2,5000}").contains("more than 1000"));
}

#[test]
fn a_name_of_several_maps_lists_them() {
    let tied = find("R3.5").unwrap_err();
    let candidates = vec!["{4,8}_8#3.5".to_string(), "{4,8}_8#3.6".to_string()];
    assert_eq!(tied, CatalogueError::Ambiguous { name: "R3.5".into(), candidates: candidates.clone() });
    assert_eq!(find("{4,8}_8#3"), Err(CatalogueError::Several { name: "{4,8}_8#3".into(), candidates }));
    assert!(
        matches!(find("{7,3}"), Err(CatalogueError::Several { candidates, .. }) if candidates[0] == "{3,7}_8#3.1'")
    );
    assert!(find("R19.19").unwrap_err().to_string().contains("R19.19 is one of {6,12}"));
}

#[test]
fn filters_choose() {
    let hurwitz = list(&Filter { genus: None, kind: Some((7, 3)) });
    assert_eq!(hurwitz.iter().map(|e| e.genus).collect::<Vec<_>>(), [3, 7, 14, 14, 14]);
    assert_eq!(list(&Filter { genus: Some(2..=3), kind: None }).len(), 18);
    assert_eq!(list(&Filter::default()).len(), entries().len());
}

#[test]
fn json_has_the_promised_fields() {
    let value = serde_json::to_value(find("R3.1'").unwrap()).unwrap();
    let mut names: Vec<_> = value.as_object().unwrap().keys().map(String::as_str).collect();
    names.sort_unstable();
    let expected =
        ["edges", "faces", "genus", "identifier", "name", "order", "p", "petrie", "presentation", "q", "vertices"];
    assert_eq!(names, expected);
    assert_eq!((&value["name"], &value["faces"]), (&"R3.1'".into(), &24.into()));
    let presentation = Presentation::parse(value["presentation"].as_str().unwrap()).unwrap();
    assert_eq!((presentation.p, presentation.q), (7, 3));
}

#[test]
fn maps_of_sphere_and_torus_are_identified() {
    for name in ["cube", "hosohedron 5", "dihedron 2", "{4,4}_(2,2)", "{4,4}_(1,0)", "{3,6}_(3,0)", "{6,3}_(2,2)"] {
        let entry = find(name).unwrap();
        assert_eq!(identify(&entry.map().unwrap()), Some(entry.clone()), "{name}");
    }
    let half = Presentation::parse("R^3, S^5, (R*T*S)^5").unwrap();
    assert_eq!(identify(&RegularMap::from_presentation(&half, CosetLimit::default()).unwrap()), None);
}

fn any_entry() -> impl Strategy<Value = &'static Entry> {
    (0..entries().len()).prop_map(|i| &entries()[i])
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn every_identifier_and_name_finds_its_map(entry in any_entry()) {
        prop_assert_eq!(&find(&entry.identifier), &Ok(entry.clone()));
        if let Some(name) = &entry.name {
            prop_assert_eq!(&find(name), &Ok(entry.clone()));
        }
        let dual = find(&format!("{}'", entry.label())).unwrap();
        prop_assert!(dual.dual && dual.dual() == *entry);
    }

    #[test]
    fn duals_are_duals(entry in any_entry()) {
        let (map, dual) = (entry.map().unwrap(), entry.dual().map().unwrap());
        prop_assert_eq!(&map.dual(), &dual);
        let found = identify(&dual).unwrap();
        prop_assert_eq!(found, if entry.self_dual { entry.clone() } else { entry.dual() });
    }

    #[test]
    fn no_text_makes_the_lookup_fail_otherwise_than_by_an_error(text in "[R{}_(),.#'0-9 a-z]{0,12}") {
        if let Ok(entry) = find(&text) {
            prop_assert!(entry.order == 4 * entry.edges);
        }
    }
}
