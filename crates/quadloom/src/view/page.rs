//! The page: the scene packed as text, put into the template.
//!
//! In: a [`Scene`]. Out: one HTML page. Holds: no text of the scene can leave its place (texts in HTML are
//! escaped, `<` never occurs in the data); coordinates are 32-bit floats relative to the centre of the bounding
//! box in units of half its diagonal, so that neither far origins nor odd scales cost digits.

use super::histogram::Histogram;
use super::scene::{DistanceLayer, Polyline, QuadLayer, Scene, Segment, SurfaceLayer};
use super::tiles::PackedTiles;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::DVec3;
use serde::Serialize;

const PAGE: &str = include_str!("page.html");
const STYLE: &str = include_str!("style.css");
/// What the scripts of all pages share.
pub(super) const COMMON: &str = include_str!("common.js");
const SCRIPT: &str = include_str!("viewer.js");
const UNFOLDED: &str = include_str!("unfolded.js");

/// Renders a scene as one self-contained HTML page.
///
/// # Input      any scene; faces naming a vertex that does not exist are left out
/// # Output     UTF-8 text; about 40 bytes per input triangle, 60 per quad, 32 per segment, plus 70 kB
/// # Cost       linear
/// # Guarantees works offline; escapes every text; the same bytes for the same scene
pub fn render_html(scene: &Scene) -> String {
    let title = heading(&scene.title);
    let data = json(&PackedScene::of(scene, title));
    let texts = [("title", &*escape(title)), ("style", STYLE), ("scene", &data)];
    fill(PAGE, &[&texts[..], &[("common", COMMON), ("unfolded", UNFOLDED), ("script", SCRIPT)]].concat())
}

/// The title, or the name of the program where there is none.
pub(super) fn heading(title: &str) -> &str {
    if title.trim().is_empty() { "Quadloom" } else { title.trim() }
}

/// JSON that no tag can end.
pub(super) fn json(data: &impl Serialize) -> String {
    serde_json::to_string(data).unwrap_or_default().replace('<', "\\u003c")
}

/// Replaces every `{{name}}` of the template; what is put in is not searched again.
pub(super) fn fill(template: &str, values: &[(&str, &str)]) -> String {
    let mut page = String::with_capacity(template.len() + values.iter().map(|(_, v)| v.len()).sum::<usize>());
    let mut rest = template;
    while let Some((before, name, after)) = next_place(rest) {
        page.push_str(before);
        page.push_str(values.iter().find(|(n, _)| *n == name).map_or("", |(_, v)| v));
        rest = after;
    }
    page + rest
}

fn next_place(text: &str) -> Option<(&str, &str, &str)> {
    let (before, rest) = text.split_once("{{")?;
    let (name, after) = rest.split_once("}}")?;
    Some((before, name, after))
}

/// Text as HTML shows it literally.
pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;").replace('\'', "&#39;")
}

/// The data of the page, as `viewer.js` reads it: arrays are base64 of little-endian 32-bit numbers.
#[derive(Serialize)]
struct PackedScene<'a> {
    title: &'a str,
    version: &'static str,
    /// Centre of the bounding box and half its diagonal, file units.
    centre: [f64; 3],
    unit: f64,
    input: Option<PackedFaces>,
    quads: Option<PackedFaces>,
    distance: Option<PackedDistance>,
    tiles: Option<PackedTiles<'a>>,
    singularities: PackedPoints,
    lines: PackedLines,
    statistics: &'a [(String, String)],
    histograms: Vec<PackedHistogram<'a>>,
}

#[derive(Serialize)]
struct PackedFaces {
    positions: String,
    faces: String,
    /// Empty or one value per face.
    quality: String,
}

/// Distances in units of the largest one, NaN where there is none.
#[derive(Serialize)]
struct PackedDistance {
    values: String,
    largest: f64,
    /// Bands up to the largest distance.
    bands: f64,
    isolines: String,
    paths: String,
    sources: String,
    cut_locus: String,
    /// Sources that are points, three coordinates each.
    source_points: String,
}

#[derive(Serialize)]
struct PackedPoints {
    positions: String,
    valence: String,
}

/// Six coordinates per segment.
#[derive(Serialize)]
struct PackedLines {
    features: String,
    boundary: String,
    seams: String,
    field: String,
    grid_u: String,
    grid_v: String,
}

#[derive(Serialize)]
struct PackedHistogram<'a> {
    title: &'a str,
    unit: &'a str,
    low: f64,
    high: f64,
    counts: &'a [u64],
    mark: Option<f64>,
    summary: Option<[f64; 3]>,
}

impl<'a> PackedScene<'a> {
    fn of(scene: &'a Scene, title: &'a str) -> Self {
        let place = Placement::of(scene);
        let singular = || scene.singularities.iter();
        Self {
            title,
            version: env!("CARGO_PKG_VERSION"),
            centre: place.centre.to_array(),
            unit: place.unit,
            input: scene.input.as_ref().map(|s| place.surface(s)),
            quads: scene.quads.as_ref().map(|q| place.quads(q)),
            distance: scene.distance.as_ref().map(|d| place.distance(d)),
            tiles: scene.tiles.as_ref().map(|t| PackedTiles::of(t, &place, &shown_triangles(scene))),
            singularities: PackedPoints {
                positions: place.points(singular().map(|s| s.position)),
                valence: pack(singular().map(|s| s.valence.to_le_bytes())),
            },
            lines: PackedLines {
                features: place.segments(scene.features.iter().flat_map(|l| l.segments())),
                boundary: place.segments(scene.boundary.iter().flat_map(|l| l.segments())),
                seams: place.segments(scene.seams.iter().copied()),
                field: place.segments(scene.crosses.iter().flat_map(|c| c.segments())),
                grid_u: place.segments(scene.uv_isolines.u.iter().copied()),
                grid_v: place.segments(scene.uv_isolines.v.iter().copied()),
            },
            statistics: &scene.statistics,
            histograms: scene.histograms.iter().map(PackedHistogram::of).collect(),
        }
    }
}

impl<'a> PackedHistogram<'a> {
    fn of(h: &'a Histogram) -> Self {
        let Histogram { title, unit, low, high, counts, mark, summary } = h;
        Self { title, unit, low: *low, high: *high, counts, mark: *mark, summary: *summary }
    }
}

/// Numbers and corners of the input's triangles that the page holds.
fn shown_triangles(scene: &Scene) -> Vec<(usize, [u32; 3])> {
    scene.input.iter().flat_map(|s| s.triangles.iter().copied().enumerate().filter(|(_, f)| whole(s, f))).collect()
}

fn whole(layer: &SurfaceLayer, triangle: &[u32; 3]) -> bool {
    triangle.iter().all(|&v| (v as usize) < layer.positions.len())
}

/// From file units to the page's: the bounding box has its centre at 0 and its corners at distance 1.
pub(super) struct Placement {
    centre: DVec3,
    unit: f64,
}

impl Placement {
    fn of(scene: &Scene) -> Self {
        let surfaces = scene.input.iter().flat_map(|s| &s.positions);
        let quads = scene.quads.iter().flat_map(|q| &q.positions);
        let lines = scene.features.iter().chain(&scene.boundary).flat_map(|l| &l.points);
        let grid = scene.uv_isolines.u.iter().chain(&scene.uv_isolines.v).flatten();
        let points =
            surfaces.chain(quads).chain(lines).chain(grid).chain(scene.singularities.iter().map(|s| &s.position));
        Self::around(points.copied())
    }

    /// Of the points with finite coordinates.
    pub(super) fn around(points: impl Iterator<Item = DVec3>) -> Self {
        let finite = points.filter(|p| p.is_finite());
        let (low, high) =
            finite.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
        if !low.is_finite() {
            return Self { centre: DVec3::ZERO, unit: 1.0 };
        }
        // Halved first: the sum of two finite coordinates may not be finite.
        let (centre, half) = (0.5 * low + 0.5 * high, 0.5 * high - 0.5 * low);
        let largest = half.max_element();
        let unit = if largest > 0.0 { largest * (half / largest).length() } else { 1.0 };
        Self { centre, unit }
    }

    fn place(&self, p: DVec3) -> [u8; 12] {
        let q = ((p - self.centre) / self.unit).as_vec3().to_array();
        let mut bytes = [0; 12];
        for (k, x) in q.iter().enumerate() {
            bytes[4 * k..4 * k + 4].copy_from_slice(&x.to_le_bytes());
        }
        bytes
    }

    pub(super) fn points(&self, points: impl Iterator<Item = DVec3>) -> String {
        pack(points.map(|p| self.place(p)))
    }

    pub(super) fn segments(&self, segments: impl Iterator<Item = Segment>) -> String {
        self.points(segments.flatten())
    }

    fn surface(&self, layer: &SurfaceLayer) -> PackedFaces {
        let shown = layer.triangles.iter().filter(|f| whole(layer, f));
        PackedFaces {
            positions: self.points(layer.positions.iter().copied()),
            faces: pack(shown.flatten().map(|v| v.to_le_bytes())),
            quality: String::new(),
        }
    }

    fn distance(&self, layer: &DistanceLayer) -> PackedDistance {
        let largest = layer.values.iter().copied().filter(|d| d.is_finite()).fold(0.0, f64::max);
        let share = |&d: &f64| if d.is_finite() && largest > 0.0 { (d / largest) as f32 } else { f32::NAN };
        let lines = |lines: &[Polyline]| self.segments(lines.iter().flat_map(|l| l.segments()));
        let alone = layer.sources.iter().filter(|s| s.points.len() == 1).map(|s| s.points[0]);
        PackedDistance {
            values: pack(layer.values.iter().map(share).map(f32::to_le_bytes)),
            largest,
            bands: if layer.band > 0.0 { largest / layer.band } else { 1.0 },
            isolines: lines(&layer.isolines),
            paths: lines(&layer.paths),
            sources: lines(&layer.sources),
            cut_locus: lines(&layer.cut_locus),
            source_points: self.points(alone),
        }
    }

    fn quads(&self, layer: &QuadLayer) -> PackedFaces {
        let whole = |f: &&[u32; 4]| f.iter().all(|&v| (v as usize) < layer.positions.len());
        let quality = layer.quality.iter().copied().chain(std::iter::repeat(f64::NAN));
        let shown = || layer.quads.iter().zip(quality.clone()).filter(|(f, _)| whole(f));
        PackedFaces {
            positions: self.points(layer.positions.iter().copied()),
            faces: pack(shown().flat_map(|(f, _)| f).map(|v| v.to_le_bytes())),
            quality: if layer.quality.is_empty() {
                String::new()
            } else {
                pack(shown().map(|(_, q)| (q as f32).to_le_bytes()))
            },
        }
    }
}

/// Base64 of the numbers' bytes, one after the other.
pub(super) fn pack<const N: usize>(numbers: impl Iterator<Item = [u8; N]>) -> String {
    STANDARD.encode(numbers.flatten().collect::<Vec<u8>>())
}

#[cfg(test)]
mod tests {
    use super::super::histogram::Bins;
    use super::super::scene::{Cross, Polyline, Singularity, TileLayer, UnfoldedSide, UnfoldedTile};
    use super::*;
    use glam::DVec2;
    use proptest::prelude::*;
    use serde_json::Value;

    /// What a browser's JSON parser finds in the page.
    fn data_of(page: &str) -> Value {
        let (_, rest) = page.split_once("<script type=\"application/json\" id=\"scene\">").unwrap();
        serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap()
    }

    fn bytes_of(value: &Value) -> Vec<[u8; 4]> {
        let bytes = STANDARD.decode(value.as_str().unwrap()).unwrap();
        bytes.chunks_exact(4).map(|c| c.try_into().unwrap()).collect()
    }
    fn floats_of(value: &Value) -> Vec<f64> {
        bytes_of(value).into_iter().map(|b| f64::from(f32::from_le_bytes(b))).collect()
    }
    fn integers_of(value: &Value) -> Vec<u32> {
        bytes_of(value).into_iter().map(u32::from_le_bytes).collect()
    }

    /// Points of the page in file units.
    fn points_of(data: &Value, value: &Value) -> Vec<DVec3> {
        let number = |v: &Value| v.as_f64().unwrap();
        let centre = DVec3::from_array([0, 1, 2].map(|k| number(&data["centre"][k])));
        floats_of(value).chunks_exact(3).map(|c| centre + DVec3::from_slice(c) * number(&data["unit"])).collect()
    }

    fn scene_at(origin: DVec3, scale: f64) -> Scene {
        let p = |x: f64, y: f64, z: f64| origin + scale * DVec3::new(x, y, z);
        let square = vec![p(0.0, 0.0, 0.0), p(1.0, 0.0, 0.0), p(1.0, 1.0, 0.3), p(0.0, 1.0, 0.0)];
        Scene {
            title: "A square".into(),
            input: Some(SurfaceLayer { positions: square.clone(), triangles: vec![[0, 1, 2], [0, 2, 3]] }),
            quads: Some(QuadLayer { positions: square.clone(), quads: vec![[0, 1, 2, 3]], quality: vec![0.75] }),
            singularities: vec![Singularity { position: square[2], valence: 5 }],
            features: vec![Polyline { points: square.clone(), closed: true }],
            boundary: vec![Polyline { points: square[..2].to_vec(), closed: true }],
            seams: vec![[square[0], square[2]]],
            crosses: vec![Cross { point: p(0.5, 0.5, 0.0), u: DVec3::X, v: DVec3::Y, length: scale }],
            statistics: vec![("quads".into(), "1".into())],
            histograms: vec![Histogram::new("h", "", Bins { low: 0.0, high: 1.0, count: 2 }, [0.75]).with_mark(1.0)],
            ..Scene::default()
        }
    }

    #[test]
    fn the_page_holds_the_scene() {
        for (origin, scale) in [(DVec3::ZERO, 1.0), (DVec3::splat(1e6), 1.0), (DVec3::ZERO, 1e-20), (DVec3::X, 1e150)] {
            let scene = scene_at(origin, scale);
            let data = data_of(&render_html(&scene));
            let close = |value: &Value, expected: &[DVec3]| {
                let found = points_of(&data, value);
                assert_eq!(found.len(), expected.len());
                for (a, b) in found.iter().zip(expected) {
                    assert!((*a - *b).abs().max_element() <= 1e-6 * scale, "{a} is not {b}");
                }
            };
            let quads = scene.quads.as_ref().unwrap();
            close(&data["quads"]["positions"], &quads.positions);
            close(&data["input"]["positions"], &quads.positions);
            close(&data["singularities"]["positions"], &[quads.positions[2]]);
            close(&data["lines"]["seams"], &scene.seams[0]);
            close(&data["lines"]["features"], &scene.features[0].segments().flatten().collect::<Vec<_>>());
            close(&data["lines"]["field"], scene.crosses[0].segments().as_flattened());
            assert_eq!(integers_of(&data["quads"]["faces"]), [0, 1, 2, 3]);
            assert_eq!(integers_of(&data["input"]["faces"]), [0, 1, 2, 0, 2, 3]);
            assert_eq!(integers_of(&data["singularities"]["valence"]), [5]);
            assert_eq!(floats_of(&data["quads"]["quality"]), [0.75]);
            assert_eq!(data["lines"]["boundary"].as_str().unwrap().len(), 64, "two segments of 24 bytes");
            assert_eq!(data["histograms"][0]["counts"], serde_json::json!([0, 1]));
        }
    }

    /// The square cut into two tiles along its diagonal.
    fn tiled_square() -> Scene {
        let square = scene_at(DVec3::ZERO, 1.0);
        let corner = |k: usize| square.input.as_ref().unwrap().positions[k];
        let side = |label: &str, arc, reversed, border| UnfoldedSide { label: label.into(), arc, reversed, border };
        let tile = |name: &str, ring| UnfoldedTile { name: name.into(), rings: vec![ring] };
        let tiles = TileLayer {
            tile: vec![1, 0],
            uv: vec![[DVec2::ZERO, DVec2::X, DVec2::ONE], [DVec2::ZERO, DVec2::ONE, DVec2::Y]],
            cuts: vec![Polyline { points: vec![corner(0), corner(2)], closed: false }],
            multipoints: vec![corner(0), corner(2)],
            unfolded: vec![
                tile("tile 0: a b", vec![side("a", 1, false, true), side("b", 3, false, false)]),
                tile("tile 1: b⁻¹ c", vec![side("b⁻¹", 3, true, false), side("c", 2, false, true)]),
            ],
        };
        Scene { tiles: Some(tiles), ..square }
    }

    #[test]
    fn tiles_are_packed_with_their_triangles() {
        let mut scene = tiled_square();
        // A triangle without a vertex takes its tile and its coordinates with it.
        scene.input.as_mut().unwrap().triangles.insert(1, [0, 1, 99]);
        let layer = scene.tiles.as_mut().unwrap();
        layer.tile.insert(1, 7);
        layer.uv.insert(1, [DVec2::splat(9.0); 3]);
        let data = data_of(&render_html(&scene));
        let tiles = &data["tiles"];
        assert_eq!(integers_of(&tiles["tile"]), [1, 0]);
        let colours = integers_of(&tiles["colours"]);
        assert!(colours.len() == 2 && colours[0] != colours[1]);
        assert_eq!(floats_of(&tiles["uv"]), [0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 1.0]);
        let [a, b] = points_of(&data, &tiles["cuts"])[..] else { panic!("one segment") };
        assert!(a.distance(DVec3::ZERO) < 1e-6 && b.distance(DVec3::new(1.0, 1.0, 0.3)) < 1e-6);
        assert_eq!(integers_of(&tiles["arcs"]), [0], "the one cut is the one arc that is not on the boundary");
        assert_eq!(points_of(&data, &tiles["multipoints"]).len(), 2);
        let rings = |k: usize| tiles["unfolded"][k]["rings"].clone();
        assert_eq!(rings(0), serde_json::json!([[["a", 1, 2], ["b", 0, 0]]]));
        assert_eq!(rings(1), serde_json::json!([[["b", 0, 1], ["c", 2, 2]]]));
        assert_eq!(render_html(&scene), render_html(&scene));
    }

    #[test]
    fn odd_tilings_make_pages_too() {
        let mut scene = tiled_square();
        let layer = scene.tiles.as_mut().unwrap();
        layer.tile = vec![u32::MAX - 1];
        layer.uv = vec![[DVec2::NAN; 3]];
        layer.cuts.push(Polyline::default());
        layer.unfolded[0].rings.push(Vec::new());
        let data = data_of(&render_html(&scene));
        assert_eq!(integers_of(&data["tiles"]["tile"]), [u32::MAX; 2]);
        assert_eq!(floats_of(&data["tiles"]["uv"]), [0.0; 12]);
        assert_eq!(integers_of(&data["tiles"]["arcs"]), [u32::MAX], "two cuts but one arc");
        scene.tiles = Some(TileLayer::default());
        assert_eq!(data_of(&render_html(&scene))["tiles"]["uv"], "");
        scene.input = None;
        assert_eq!(data_of(&render_html(&scene))["tiles"]["tile"], "");
    }

    #[test]
    fn a_page_asks_for_nothing_and_has_no_place_left() {
        for scene in [Scene::default(), scene_at(DVec3::ZERO, 1.0), tiled_square()] {
            let page = render_html(&scene);
            assert!(page.contains("default-src 'none'") && !page.contains("{{") && !page.contains("}}"));
            // The one address is the name of SVG's elements, which nobody fetches.
            assert_eq!(page.replace("http://www.w3.org/2000/svg", "").matches("http").count(), 1, "http-equiv alone");
            assert!(!page.contains(" src=") && !page.contains("@import") && !page.contains("url("));
        }
    }

    #[test]
    fn odd_scenes_make_pages_too() {
        let mut scene = scene_at(DVec3::ZERO, 1.0);
        let quads = scene.quads.as_mut().unwrap();
        quads.quads.extend([[0, 1, 2, 99], [3, 2, 1, 0]]);
        quads.positions.push(DVec3::NAN);
        let data = data_of(&render_html(&scene));
        assert_eq!(integers_of(&data["quads"]["faces"]), [0, 1, 2, 3, 3, 2, 1, 0]);
        assert!(floats_of(&data["quads"]["quality"])[1].is_nan(), "no quality was given");
        let lonely = Scene {
            singularities: vec![Singularity { position: DVec3::splat(f64::INFINITY), valence: 3 }],
            ..Scene::default()
        };
        assert_eq!(data_of(&render_html(&lonely))["unit"], 1.0);
    }

    #[test]
    fn two_hundred_thousand_triangles_fit_in_fifteen_megabytes() {
        let side = 316_u32;
        let points: Vec<_> =
            (0..=side).flat_map(|j| (0..=side).map(move |i| DVec3::new(i.into(), j.into(), 0.0))).collect();
        let cell = |k: u32| (k / side) * (side + 1) + k % side;
        let corners = move |k: u32| [cell(k), cell(k) + 1, cell(k) + side + 2, cell(k) + side + 1];
        let triangles: Vec<_> = (0..side * side).map(corners).flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        assert!(triangles.len() > 199_000);
        let segment = [points[0], points[1]];
        let mut scene = Scene {
            quads: Some(QuadLayer {
                positions: points[..10_100].to_vec(),
                quads: (0..10_000).map(|k| [k, k + 1, k + 2, k + 3]).collect(),
                quality: vec![1.0; 10_000],
            }),
            input: Some(SurfaceLayer { positions: points, triangles }),
            ..Scene::default()
        };
        // As many pieces of iso-lines as a map to 10,000 quads has on triangles of this size.
        scene.uv_isolines.u = vec![segment; 65_000];
        scene.uv_isolines.v = vec![segment; 65_000];
        assert!(render_html(&scene).len() < 15_000_000);
    }

    proptest! {
        #[test]
        fn no_text_leaves_its_place(
            text in r#"[<>&"'/!{}a-z-]{0,12}(</script>|<!--|\{\{scene\}\}|</title>|<script>)[<>&"' a-z]{0,12}"#
        ) {
            let plain = render_html(&Scene::default());
            let mut scene = tiled_square();
            scene.title = text.clone();
            let unfolded = &mut scene.tiles.as_mut().unwrap().unfolded[0];
            unfolded.name = text.clone();
            unfolded.rings[0][0].label = text.clone();
            scene.statistics = vec![(text.clone(), text.clone())];
            scene.histograms[0].title = text.clone();
            let page = render_html(&scene);
            for tag in ["<script", "</script", "<!--", "</title", "<title", "<h1", "<canvas"] {
                prop_assert_eq!(page.matches(tag).count(), plain.matches(tag).count(), "{}", tag);
            }
            let data = data_of(&page);
            prop_assert_eq!(data["title"].as_str().unwrap(), text.trim());
            prop_assert_eq!(data["statistics"][0][1].as_str().unwrap(), &text);
            prop_assert_eq!(data["tiles"]["unfolded"][0]["name"].as_str().unwrap(), &text);
            prop_assert_eq!(data["tiles"]["unfolded"][0]["rings"][0][0][0].as_str().unwrap(), &text);
            prop_assert_eq!(data["histograms"][0]["title"].as_str().unwrap(), &text);
        }
    }
}
