//! GLB, binary glTF 2.0: one mesh, quads as pairs of triangles that FB_ngon_encoding lets a reader join again.
//!
//! In: a surface. Out: a node with triangles and, where there are feature polylines, lines.
//! Holds: coordinates are single precision; those of a model far from the origin are relative to its centre, which the
//! node gives back, so that rounding follows the model's size. The extension is declared only where it is used.
//! Source: glTF 2.0 specification; extension draft <https://github.com/KhronosGroup/glTF/pull/1620>.

use crate::surface::SurfaceOut;
use crate::triangulate::fans;
use quadloom_mesh::DVec3;
use serde_json::{Map, Value, json};
use std::io::{self, Write};

/// glTF's numbers.
const TRIANGLES: u32 = 4;
const LINES: u32 = 1;
const U32: u32 = 5125;
const F32: u32 = 5126;
const VERTEX_BUFFER: u32 = 34962;
const INDEX_BUFFER: u32 = 34963;

/// A model further from the origin than this many of its diagonals is written relative to its centre. Below it, single
/// precision is good to 4e-6 of the diagonal, finer than any picture; the few readers that ignore nodes are served.
const FAR: f64 = 32.0;

/// Writes a GLB file.
pub(crate) fn write(surface: &SurfaceOut, out: &mut dyn Write) -> io::Result<()> {
    // 1. What goes into the buffer.
    let origin = origin(surface);
    let points: Vec<[f32; 3]> = surface.positions.iter().map(|&p| single(p - origin)).collect();
    let triangles = fans(&surface.faces, &surface.positions);
    let segments: Vec<[u32; 2]> =
        surface.polylines.iter().flat_map(|line| line.windows(2).map(|w| [w[0], w[1]])).collect();
    // 2. The buffer and its description.
    let mut file = Parts::default();
    let mut attributes = Map::new();
    attributes.insert("POSITION".into(), file.vectors(&points, true).into());
    if let Some(colors) = &surface.vertex_colors {
        attributes.insert("COLOR_0".into(), file.vectors(colors, false).into());
    }
    let mut primitives = Vec::new();
    let polygons = surface.faces.iter().any(|face| face.len() > 3);
    if !triangles.is_empty() {
        let indices = file.indices(triangles.as_flattened());
        let mut primitive = json!({ "attributes": attributes, "indices": indices, "mode": TRIANGLES });
        if polygons {
            primitive["extensions"] = json!({ "FB_ngon_encoding": {} });
        }
        primitives.push(primitive);
    }
    if !segments.is_empty() {
        let indices = file.indices(segments.as_flattened());
        primitives.push(json!({ "attributes": attributes, "indices": indices, "mode": LINES }));
    }
    write_file(out, &document(&file, primitives, origin, polygons), file.buffer)
}

/// Number of vertices that single precision moves.
pub(crate) fn rounded_vertices(surface: &SurfaceOut) -> usize {
    let origin = origin(surface);
    let stored = |p: DVec3| origin + DVec3::from(single(p - origin).map(f64::from));
    surface.positions.iter().filter(|&&p| stored(p) != p).count()
}

fn single(p: DVec3) -> [f32; 3] {
    p.as_vec3().to_array()
}

/// Where the node's own origin lies: in single precision, as readers keep it.
fn origin(surface: &SurfaceOut) -> DVec3 {
    let bounds = |(lo, hi): (DVec3, DVec3), p: &DVec3| (lo.min(*p), hi.max(*p));
    let (lo, hi) = surface.positions.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), bounds);
    let centre = 0.5 * lo + 0.5 * hi;
    if centre.is_finite() && centre.length() > FAR * (hi - lo).length() {
        centre.as_vec3().as_dvec3()
    } else {
        DVec3::ZERO
    }
}

#[derive(Default)]
struct Parts {
    buffer: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Parts {
    fn vectors(&mut self, values: &[[f32; 3]], bounds: bool) -> usize {
        let view = self.view(values.iter().flatten().flat_map(|x| x.to_le_bytes()), VERTEX_BUFFER);
        let mut accessor = json!({ "bufferView": view, "componentType": F32, "count": values.len(), "type": "VEC3" });
        if bounds {
            let along = |k: usize, pick: fn(f32, f32) -> f32| values.iter().map(|p| p[k]).reduce(pick).unwrap_or(0.0);
            accessor["min"] = json!([0, 1, 2].map(|k| along(k, f32::min)));
            accessor["max"] = json!([0, 1, 2].map(|k| along(k, f32::max)));
        }
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn indices(&mut self, values: &[u32]) -> usize {
        let view = self.view(values.iter().flat_map(|v| v.to_le_bytes()), INDEX_BUFFER);
        self.accessors
            .push(json!({ "bufferView": view, "componentType": U32, "count": values.len(), "type": "SCALAR" }));
        self.accessors.len() - 1
    }

    /// Appends bytes, all of four-byte values, so that views stay aligned.
    fn view(&mut self, bytes: impl Iterator<Item = u8>, target: u32) -> usize {
        let offset = self.buffer.len();
        self.buffer.extend(bytes);
        let length = self.buffer.len() - offset;
        self.views.push(json!({ "buffer": 0, "byteOffset": offset, "byteLength": length, "target": target }));
        self.views.len() - 1
    }
}

fn document(file: &Parts, primitives: Vec<Value>, origin: DVec3, polygons: bool) -> Value {
    let mut node = json!({ "mesh": 0 });
    if origin != DVec3::ZERO {
        node["translation"] = json!(single(origin));
    }
    let mut document = json!({
        "asset": { "version": "2.0", "generator": "quadloom" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [node],
        "meshes": [{ "primitives": primitives }],
        "accessors": file.accessors,
        "bufferViews": file.views,
        "buffers": [{ "byteLength": file.buffer.len() }],
    });
    if polygons {
        document["extensionsUsed"] = json!(["FB_ngon_encoding"]);
    }
    document
}

/// The two chunks, text padded with blanks and data with zeros to multiples of four.
fn write_file(out: &mut dyn Write, document: &Value, mut buffer: Vec<u8>) -> io::Result<()> {
    let mut text = serde_json::to_vec(document)?;
    text.resize(text.len().next_multiple_of(4), b' ');
    buffer.resize(buffer.len().next_multiple_of(4), 0);
    let length = |n: usize| u32::try_from(n).map_err(|_| io::Error::other("more than the 4 GiB a GLB file can have"));
    out.write_all(b"glTF")?;
    out.write_all(&2u32.to_le_bytes())?;
    out.write_all(&length(12 + 8 + text.len() + 8 + buffer.len())?.to_le_bytes())?;
    for (kind, bytes) in [(b"JSON", &text), (b"BIN\0", &buffer)] {
        out.write_all(&length(bytes.len())?.to_le_bytes())?;
        out.write_all(kind)?;
        out.write_all(bytes)?;
    }
    Ok(())
}
