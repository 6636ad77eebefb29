//! The page: the scene packed as text, put into the template.
//!
//! In: a [`Scene`]. Out: one HTML page. Holds: no text of the scene can leave its place (texts in HTML are
//! escaped, `<` never occurs in the data); coordinates are 32-bit floats relative to the centre of the bounding
//! box in units of half its diagonal, so that neither far origins nor odd scales cost digits.

use super::histogram::Histogram;
use super::scene::{QuadLayer, Scene, Segment, SurfaceLayer};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::DVec3;
use serde::Serialize;

const PAGE: &str = include_str!("page.html");
const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("viewer.js");

/// Renders a scene as one self-contained HTML page.
///
/// # Input      any scene; faces naming a vertex that does not exist are left out
/// # Output     UTF-8 text; about 40 bytes per input triangle, 60 per quad, 32 per segment, plus 60 kB
/// # Cost       linear
/// # Guarantees works offline; escapes every text; the same bytes for the same scene
pub fn render_html(scene: &Scene) -> String {
    let title = if scene.title.trim().is_empty() { "Quadloom" } else { scene.title.trim() };
    let data = serde_json::to_string(&PackedScene::of(scene, title)).unwrap_or_default().replace('<', "\\u003c");
    fill(PAGE, &[("title", &escape(title)), ("style", STYLE), ("scene", &data), ("script", SCRIPT)])
}

/// Replaces every `{{name}}` of the template; what is put in is not searched again.
fn fill(template: &str, values: &[(&str, &str)]) -> String {
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
fn escape(text: &str) -> String {
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

/// From file units to the page's: the bounding box has its centre at 0 and its corners at distance 1.
struct Placement {
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
        let finite = points.filter(|p| p.is_finite());
        let (low, high) =
            finite.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)));
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

    fn points(&self, points: impl Iterator<Item = DVec3>) -> String {
        pack(points.map(|p| self.place(p)))
    }

    fn segments(&self, segments: impl Iterator<Item = Segment>) -> String {
        self.points(segments.flatten())
    }

    fn surface(&self, layer: &SurfaceLayer) -> PackedFaces {
        let whole = |f: &&[u32; 3]| f.iter().all(|&v| (v as usize) < layer.positions.len());
        PackedFaces {
            positions: self.points(layer.positions.iter().copied()),
            faces: pack(layer.triangles.iter().filter(whole).flatten().map(|v| v.to_le_bytes())),
            quality: String::new(),
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
fn pack<const N: usize>(numbers: impl Iterator<Item = [u8; N]>) -> String {
    STANDARD.encode(numbers.flatten().collect::<Vec<u8>>())
}
