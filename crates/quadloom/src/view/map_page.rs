//! The page of a regular map: its surface in space and its flat picture side by side.
//!
//! In: a [`MapScene`]. Out: one HTML page ([`render_map_html`]), which works without a network.
//! Holds: as for [`super::render_html`], the page asks for nothing outside itself, texts are escaped, and the same scene
//! gives the same bytes; of the flat picture only drawing elements are taken over, no scripts and no links; what cannot
//! be drawn is counted on the page. Not: that the faces are those of a map; nothing is checked here.
//! Source: own.

use super::page::{COMMON, Placement, escape, fill, heading, json, pack};
use glam::DVec3;
use serde::Serialize;

const PAGE: &str = include_str!("map_page.html");
const STYLE: &str = include_str!("map_style.css");
const SCRIPT: &str = include_str!("map_viewer.js");

/// Number of a face or of a colour that is not known.
const NONE: u32 = u32::MAX;

/// A drawn map and its flat picture.
///
/// Lists by triangle may be shorter than `triangles`: then the rest is of no face, in no band and of no class.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MapScene {
    /// Heading of the page and name of its window; plain text.
    pub title: String,
    /// Facts: name and value, shown in order; plain text.
    pub facts: Vec<(String, String)>,
    /// Vertices of the surface, any unit.
    pub positions: Vec<DVec3>,
    /// Corners of the triangles, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// The face of the map that each triangle belongs to; `u32::MAX` for none.
    pub face: Vec<u32>,
    /// Whether each triangle belongs to an edge's band (drawn in `edge_color`).
    pub is_edge: Vec<bool>,
    /// Colour of each triangle outside bands, by its place in the palette; beyond the palette it is grey.
    pub class: Vec<u32>,
    /// Colours of the classes: red, green, blue.
    pub palette: Vec<[u8; 3]>,
    /// Colour of the bands: red, green, blue.
    pub edge_color: [u8; 3],
    /// The flat picture: an SVG whose groups `<g data-face="12">` hold the pieces of a face. May be empty: then the page
    /// shows the surface alone.
    pub flat: String,
}

/// Renders a map as one self-contained HTML page.
///
/// # Input      any scene; triangles with a vertex that is missing or not finite are left out, and the page says how many
/// # Output     UTF-8 text; about 33 bytes per triangle, the flat picture, and 60 kB
/// # Cost       linear
/// # Guarantees works offline; escapes every text; the same bytes for the same scene
pub fn render_map_html(scene: &MapScene) -> String {
    let title = heading(&scene.title);
    let data = json(&PackedMap::of(scene, title));
    let texts = [("title", &*escape(title)), ("style", STYLE), ("scene", &data)];
    fill(PAGE, &[&texts[..], &[("common", COMMON), ("script", SCRIPT)]].concat())
}

/// The data of the page, as `map_viewer.js` reads it: arrays are base64 of little-endian numbers.
#[derive(Serialize)]
struct PackedMap<'a> {
    title: &'a str,
    version: &'static str,
    facts: &'a [(String, String)],
    /// Three 32-bit floats per vertex, within radius 1.
    positions: String,
    /// Three vertices per triangle.
    triangles: PackedNumbers,
    /// One per triangle; the largest number that fits means none.
    face: PackedNumbers,
    /// One per triangle: 0 for a band, 1 for no class, otherwise the class plus 2.
    tint: PackedNumbers,
    palette: &'a [[u8; 3]],
    edge_color: [u8; 3],
    flat: &'a str,
    /// Triangles that cannot be drawn.
    left_out: usize,
}

impl<'a> PackedMap<'a> {
    fn of(scene: &'a MapScene, title: &'a str) -> Self {
        let place = Placement::around(scene.positions.iter().copied());
        let drawn: Vec<_> = (0..scene.triangles.len()).filter(|&t| scene.draws(t)).collect();
        let corners = drawn.iter().flat_map(|&t| scene.triangles[t]);
        Self {
            title,
            version: env!("CARGO_PKG_VERSION"),
            facts: &scene.facts,
            positions: place.points(scene.positions.iter().copied()),
            triangles: PackedNumbers::of(corners.collect()),
            face: PackedNumbers::of(drawn.iter().map(|&t| scene.face.get(t).copied().unwrap_or(NONE)).collect()),
            tint: PackedNumbers::of(drawn.iter().map(|&t| scene.tint(t)).collect()),
            palette: &scene.palette,
            edge_color: scene.edge_color,
            flat: &scene.flat,
            left_out: scene.triangles.len() - drawn.len(),
        }
    }
}

impl MapScene {
    fn draws(&self, triangle: usize) -> bool {
        let point = |v: u32| self.positions.get(v as usize);
        self.triangles[triangle].iter().all(|&v| point(v).is_some_and(|p| p.is_finite()))
    }

    fn tint(&self, triangle: usize) -> u32 {
        let class = self.class.get(triangle).filter(|&&c| (c as usize) < self.palette.len());
        match (self.is_edge.get(triangle), class) {
            (Some(true), _) => 0,
            (_, Some(class)) => class.saturating_add(2),
            _ => 1,
        }
    }
}

/// Numbers in as few bytes each as hold them all; `NONE` becomes the largest number of that width.
#[derive(Debug, PartialEq, Serialize)]
struct PackedNumbers {
    /// Bytes per number: 1, 2 or 4.
    width: u8,
    data: String,
}

impl PackedNumbers {
    fn of(numbers: Vec<u32>) -> Self {
        let most = numbers.iter().copied().filter(|&n| n != NONE).max().unwrap_or(0);
        // Truncating cuts NONE to the largest number, which no other one is.
        let numbers = numbers.iter();
        if most < u32::from(u8::MAX) {
            Self { width: 1, data: pack(numbers.map(|&n| [n as u8])) }
        } else if most < u32::from(u16::MAX) {
            Self { width: 2, data: pack(numbers.map(|&n| (n as u16).to_le_bytes())) }
        } else {
            Self { width: 4, data: pack(numbers.map(|n| n.to_le_bytes())) }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use base64::Engine;
    use base64::engine::general_purpose::STANDARD;
    use proptest::prelude::*;
    use serde_json::Value;

    /// What a browser's JSON parser finds in the page.
    fn data_of(page: &str) -> Value {
        let (_, rest) = page.split_once("<script type=\"application/json\" id=\"scene\">").unwrap();
        serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap()
    }

    fn numbers_of(value: &Value) -> Vec<u32> {
        let width = value["width"].as_u64().unwrap() as usize;
        let bytes = STANDARD.decode(value["data"].as_str().unwrap()).unwrap();
        bytes.chunks_exact(width).map(|c| c.iter().rev().fold(0, |n, &b| (n << 8) | u32::from(b))).collect()
    }

    /// A square of two triangles, one of which is an edge's band.
    fn square() -> MapScene {
        MapScene {
            title: "A square".into(),
            facts: vec![("genus".into(), "0".into())],
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            face: vec![12, 7],
            is_edge: vec![false, true],
            class: vec![1, 0],
            palette: vec![[1, 2, 3], [4, 5, 6]],
            edge_color: [9, 8, 7],
            flat: r#"<svg viewBox="0 0 1 1"><g data-face="12"><path d="M0 0H1V1Z"/></g></svg>"#.into(),
        }
    }

    #[test]
    fn the_page_holds_the_scene() {
        let scene = square();
        let data = data_of(&render_map_html(&scene));
        assert_eq!(numbers_of(&data["triangles"]), [0, 1, 2, 0, 2, 3]);
        assert_eq!(numbers_of(&data["face"]), [12, 7]);
        assert_eq!(numbers_of(&data["tint"]), [3, 0], "class 1 comes third, the band first");
        assert_eq!(data["positions"].as_str().unwrap().len(), 64, "four points of 12 bytes");
        assert_eq!(data["palette"], serde_json::json!([[1, 2, 3], [4, 5, 6]]));
        assert_eq!(data["edge_color"], serde_json::json!([9, 8, 7]));
        assert_eq!(data["facts"], serde_json::json!([["genus", "0"]]));
        assert_eq!(data["flat"].as_str().unwrap(), scene.flat);
        assert_eq!(data["left_out"], 0);
        assert_eq!(render_map_html(&scene), render_map_html(&scene.clone()));
    }

    #[test]
    fn what_cannot_be_drawn_is_counted() {
        let mut scene = square();
        scene.positions.push(DVec3::new(0.0, f64::NAN, 0.0));
        scene.triangles = vec![[0, 1, 99], [0, 1, 2], [0, 1, 4], [0, 2, 3], [2, 1, 0]];
        scene.face = vec![1, 2, 3, 4];
        scene.is_edge = vec![true];
        scene.class = vec![0, 0, 0, 55];
        let data = data_of(&render_map_html(&scene));
        assert_eq!(data["left_out"], 2);
        assert_eq!(numbers_of(&data["triangles"]), [0, 1, 2, 0, 2, 3, 2, 1, 0]);
        assert_eq!(numbers_of(&data["face"]), [2, 4, 255], "the last triangle is of no face");
        assert_eq!(numbers_of(&data["tint"]), [2, 1, 1], "no class, or one beyond the palette, is none");
        let empty = data_of(&render_map_html(&MapScene::default()));
        assert_eq!((&empty["left_out"], &empty["title"]), (&0.into(), &"Quadloom".into()));
        assert_eq!(numbers_of(&empty["face"]), [0; 0]);
    }

    #[test]
    fn numbers_take_as_few_bytes_as_they_can() {
        for (most, width) in [(0, 1), (254, 1), (255, 2), (65_534, 2), (65_535, 4), (NONE - 1, 4)] {
            let packed = serde_json::to_value(PackedNumbers::of(vec![NONE, most, 0])).unwrap();
            assert_eq!(packed["width"], width);
            let none = NONE >> (32 - 8 * width);
            assert_eq!(numbers_of(&packed), [none, most, 0]);
            assert!(most < none);
        }
    }

    #[test]
    fn a_page_asks_for_nothing_and_has_no_place_left() {
        for scene in [MapScene::default(), square()] {
            let page = render_map_html(&scene);
            assert!(page.contains("default-src 'none'") && !page.contains("{{") && !page.contains("}}"));
            // The one address is the name of SVG's elements, which nobody fetches.
            assert_eq!(page.replace("http://www.w3.org/2000/svg", "").matches("http").count(), 1, "http-equiv alone");
            assert!(!page.contains(" src=") && !page.contains("@import") && !page.contains("url("));
        }
    }

    #[test]
    fn every_element_of_the_page_is_closed() {
        let page = render_map_html(&square());
        let names = ["html", "head", "style", "body", "main", "header", "footer", "aside", "section", "div", "span"];
        for name in names.into_iter().chain(["dialog", "table", "tr", "button", "label", "script", "dl", "p", "h1"]) {
            let start = |end: &str| page.matches(&format!("<{name}{end}")).count();
            assert_eq!(start(">") + start(" "), page.matches(&format!("</{name}>")).count(), "{name}");
        }
    }

    #[test]
    fn half_a_million_triangles_fit_in_twenty_megabytes() {
        let count = 500_000;
        let scene = MapScene {
            positions: vec![DVec3::X; count / 2],
            triangles: vec![[0, 1, count as u32 / 2 - 1]; count],
            face: (0..count as u32).map(|t| t / 100).collect(),
            class: vec![0; count],
            palette: vec![[0; 3]],
            ..MapScene::default()
        };
        assert!(render_map_html(&scene).len() < 20_000_000);
    }

    proptest! {
        #[test]
        fn no_text_leaves_its_place(
            text in r#"[<>&"'/!{}a-z-]{0,12}(</script>|<!--|\{\{scene\}\}|</title>|<script>)[<>&"' a-z]{0,12}"#
        ) {
            let plain = render_map_html(&MapScene::default());
            let facts = vec![(text.clone(), text.clone())];
            let scene = MapScene { title: text.clone(), facts, flat: text.clone(), ..square() };
            let page = render_map_html(&scene);
            for tag in ["<script", "</script", "<!--", "</title", "<title", "<h1", "<canvas"] {
                prop_assert_eq!(page.matches(tag).count(), plain.matches(tag).count(), "{}", tag);
            }
            let data = data_of(&page);
            prop_assert_eq!(data["title"].as_str().unwrap(), text.trim());
            prop_assert_eq!(data["facts"][0][1].as_str().unwrap(), &text);
            prop_assert_eq!(data["flat"].as_str().unwrap(), &text);
        }
    }
}
