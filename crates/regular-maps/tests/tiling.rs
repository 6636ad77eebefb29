//! Flat pictures of maps.
//!
//! In: presentations, and `../shared/research/regular-maps`, where it is there. Holds: the polygon, glued by its labels,
//! is the map; pictures can be read.

use quadloom_regular_maps::colouring::Colouring;
use quadloom_regular_maps::tiling::{Centre, FlatTiling, LayoutOptions, Model, PictureOptions, Pieces, png, svg};
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

const NAMED: [(&str, &str); 9] = [
    ("tetrahedron", "R^3, S^3"),
    ("cube", "R^4, S^3"),
    ("hosohedron", "R^2, S^5"),
    ("half an icosahedron", "R^3, S^5, (R*T*S)^5"),
    ("torus", "R^4, S^4, (R*S^-1)^3"),
    ("R2.1", "R^3, S^8, R*S*R^2*S*R^2*S^2*R^2*S*R^2*S*R^-1"),
    ("R2.4", "R^5, S^10, R*S*R^2*S*R^-1"),
    ("R3.1", "R^3, S^7, (R*S^-2)^4"),
    ("R13.2", "R^3, S^12, R*S*R^2*S*R^2*S^3*R^2*S*R^2*S^2*R^-1"),
];

/// Number of labels.
fn labels(tiling: &FlatTiling) -> u32 {
    tiling.boundary().iter().map(|edge| edge.label).max().unwrap_or(0)
}

#[test]
fn named_maps_have_the_boundaries_of_their_pictures() {
    let found = NAMED.map(|(name, text)| {
        let tiling = FlatTiling::layout(&map(text), Centre::Face).unwrap();
        assert_eq!(tiling.check(), [], "{name}");
        assert!(tiling.boundary().iter().all(|e| tiling.boundary()[e.partner].label == e.label), "{name}");
        labels(&tiling)
    });
    // Nothing to glue on the sphere; one edge twice for the projective plane; two for the torus.
    assert_eq!(found[..5], [0, 0, 0, 1, 2]);
    // Klein's quartic: fourteen sides around a heptagon. R2.4: a decagon around its vertex.
    let klein = FlatTiling::layout(&map(NAMED[7].1).dual(), Centre::Face).unwrap();
    let decagon = FlatTiling::layout(&map(NAMED[6].1), Centre::Vertex).unwrap();
    assert_eq!((labels(&klein), labels(&decagon)), (7, 5));
    assert!(decagon.boundary().iter().all(|e| e.sides.len() == 2), "{:?}", decagon.boundary());
}

#[test]
fn a_projective_plane_is_glued_along_its_edge_in_one_direction() {
    let tiling = FlatTiling::layout(&map(NAMED[3].1), Centre::Face).unwrap();
    let [a, b] = tiling.boundary() else { panic!("{:?}", tiling.boundary()) };
    assert!(a.forward && b.forward && a.partner == 1 && b.partner == 0);
    assert_eq!((tiling.glued().orientable, tiling.glued().chi), (false, 1));
}

#[test]
fn maps_without_a_plane_are_refused() {
    let loop_on_sphere = RegularMap::from_table(&[[1, 1, 2], [0, 0, 3], [3, 3, 0], [2, 2, 1]]).unwrap();
    assert_eq!(loop_on_sphere.p(), 1);
    assert!(FlatTiling::layout(&loop_on_sphere, Centre::Face).is_err());
}

#[test]
fn triangles_have_the_area_of_the_surface() {
    for (name, text) in &NAMED[5..] {
        let map = map(text);
        let tiling = FlatTiling::layout(&map, Centre::Vertex).unwrap();
        let disc = |p: glam::DVec3| Model::Klein.project(p).truncate();
        let area: f64 = map.flags().map(|g| hyperbolic_area(tiling.corners(g).map(disc))).sum();
        let wanted = std::f64::consts::TAU * (2 * map.genus() - 2) as f64;
        assert!((area - wanted).abs() < 1e-6 * wanted, "{name} {area} {wanted}");
    }
}

/// π minus the angles, from points of the Klein disc alone.
fn hyperbolic_area(corners: [glam::DVec2; 3]) -> f64 {
    let lift = |p: glam::DVec2| p.extend(1.0) / (1.0 - p.length_squared()).sqrt();
    let product = |a: glam::DVec3, b: glam::DVec3| a.x * b.x + a.y * b.y - a.z * b.z;
    let corners = corners.map(lift);
    let angles = [0, 1, 2].map(|k| {
        let at = corners[k];
        let [u, v] = [1, 2].map(|j| corners[(k + j) % 3] + at * product(at, corners[(k + j) % 3]));
        (product(u, v) / (product(u, u) * product(v, v)).sqrt()).acos()
    });
    std::f64::consts::PI - angles.iter().sum::<f64>()
}

#[test]
fn half_edges_are_in_all_models() {
    let tiling = FlatTiling::layout(&map(NAMED[6].1), Centre::Vertex).unwrap();
    let lines = tiling.lines(Model::Jemisphere);
    assert_eq!(lines.len(), 20);
    assert!(lines.values().iter().flatten().all(|p| (p.length() - 1.0).abs() < 1e-9 && p.z > 0.0));
}

/// All pictures of a map that differ in kind.
fn pictures() -> Vec<PictureOptions> {
    let plain = PictureOptions { size: 300, face_numbers: true, ..PictureOptions::default() };
    let full = PictureOptions { triangles: true, dual_edges: true, petrie: Some(0), ..plain.clone() };
    vec![
        plain.clone(),
        PictureOptions { model: Model::Klein, colouring: Some(Colouring::Petrie), ..full.clone() },
        PictureOptions { model: Model::Jemisphere, colouring: Some(Colouring::Triangle), ..full },
        PictureOptions { colouring: None, background: None, petrie: Some(usize::MAX), ..plain },
    ]
}

#[test]
fn svg_is_well_formed_and_the_same_each_time() {
    for (name, text) in NAMED {
        let map = map(text);
        let tiling = FlatTiling::layout(&map, Centre::Face).unwrap();
        for options in pictures() {
            let text = svg(&tiling, &options);
            assert_eq!(text, svg(&tiling, &options));
            assert_balanced(&text);
            assert!(!text.contains("NaN") && !text.contains("inf"), "{name} {options:?}");
            let groups: Vec<_> = text.match_indices("data-face=").collect();
            let all = options.model != Model::Jemisphere;
            assert!(groups.len() <= map.face_count() && (!all || groups.len() == map.face_count()), "{name}");
            assert!(coordinates(&text).all(|x| x.abs() < 1e7), "{name} {options:?}");
        }
    }
}

fn assert_balanced(text: &str) {
    let mut open = Vec::new();
    for tag in text.split('<').skip(1) {
        let (tag, _) = tag.split_once('>').expect("a tag ends");
        let name = tag.split_whitespace().next().unwrap();
        if let Some(name) = name.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name));
        } else if !tag.ends_with('/') {
            open.push(name);
        }
        assert_eq!(tag.matches('"').count() % 2, 0, "{tag}");
    }
    assert!(open.is_empty(), "{open:?}");
}

fn coordinates(text: &str) -> impl Iterator<Item = f64> {
    let paths = text.split(" d=\"").skip(1).map(|rest| rest.split('"').next().unwrap());
    let numbers = paths.flat_map(|path| path.split(|c: char| c.is_ascii_alphabetic() || c == ' '));
    numbers.filter(|n| !n.is_empty()).map(|n| n.parse().unwrap())
}

#[test]
fn png_has_its_size_and_the_colours_of_faces() {
    let klein = map(NAMED[7].1).dual();
    let tiling = FlatTiling::layout(&klein, Centre::Face).unwrap();
    for options in pictures() {
        let bytes = png(&tiling, &options);
        assert_eq!(bytes, png(&tiling, &options));
        let pixels = tiny_skia::Pixmap::decode_png(&bytes).unwrap();
        assert_eq!((pixels.width(), pixels.height()), (300, 300));
    }
    let plain = PictureOptions { size: 301, edges: false, ..PictureOptions::default() };
    let pixels = tiny_skia::Pixmap::decode_png(&png(&tiling, &plain)).unwrap();
    let middle = pixels.pixel(150, 150).unwrap();
    let wanted = Colouring::Face.colours(klein.face_count())[0];
    assert_eq!([middle.red(), middle.green(), middle.blue()], wanted);
    assert_eq!(pixels.pixel(0, 0).unwrap().red(), 255);
}
