//! Tiles as files.
//!
//! In: a [`TileResult`]. Out: files that are staged. Holds: vertices are those of the components one after the other,
//! in each the vertices of the component first, then new ones; faces are in the order of their tiles.

use super::{TileResult, TiledPart};
use crate::error::RemeshError;
use quadloom_io::Batch;
use quadloom_mesh::{CornerMap, DVec2, FaceId, VertexId};
use quadloom_tiling::{ArcId, Tiling};
use serde_json::{Value, json};
use std::collections::HashMap;
use std::io::{self, Write};
use std::path::Path;

/// Adds tiles as OBJ: a group per tile, cuts as `l` lines.
///
/// # Errors     every error of writing
pub fn stage_tiles(files: &mut Batch, path: &Path, result: &TileResult) -> Result<(), RemeshError> {
    let tilings: Vec<Mapped> = result.parts.iter().map(|p| (&p.tiling, p.uv.as_ref())).collect();
    Ok(files.stage(path, |out| write_obj(out, &tilings))?)
}

/// Adds nodes, arcs, tiles and words as JSON.
///
/// # Errors     every error of writing
pub fn stage_layout(files: &mut Batch, path: &Path, result: &TileResult) -> Result<(), RemeshError> {
    let tilings: Vec<&Tiling> = result.parts.iter().map(|p| &p.tiling).collect();
    let mut layout = layout_of(&tilings);
    layout["new_vertices"] = new_vertices(&result.parts);
    Ok(files.stage(path, |out| writeln!(out, "{layout}"))?)
}

/// Adds every intermediate tiling to a folder: `step_000.obj` with `step_000.json`, and so on.
///
/// # Input      folder: exists
/// # Errors     every error of writing
pub fn stage_steps(files: &mut Batch, folder: &Path, result: &TileResult) -> Result<(), RemeshError> {
    let count = result.parts.iter().map(|p| p.steps.len()).max().unwrap_or(0);
    for step in 0..count {
        let tilings: Vec<&Tiling> = result.parts.iter().filter_map(|p| p.steps.get(step).or(p.steps.last())).collect();
        let unmapped: Vec<Mapped> = tilings.iter().map(|t| (*t, None)).collect();
        files.stage(&folder.join(format!("step_{step:03}.obj")), |out| write_obj(out, &unmapped))?;
        let layout = layout_of(&tilings);
        files.stage(&folder.join(format!("step_{step:03}.json")), |out| writeln!(out, "{layout}"))?;
    }
    Ok(())
}

/// A tiling, and texture coordinates of its corners.
type Mapped<'a> = (&'a Tiling, Option<&'a CornerMap<DVec2>>);

fn write_obj(out: &mut dyn Write, tilings: &[Mapped]) -> io::Result<()> {
    for (tiling, _) in tilings {
        for p in tiling.mesh().positions().values() {
            writeln!(out, "v {} {} {}", p.x, p.y, p.z)?;
        }
    }
    let (mut first, mut number, mut places) = (1, 0, 0);
    for (tiling, uv) in tilings {
        for faces in tiling.faces_by_tile() {
            writeln!(out, "g tile_{number}")?;
            number += 1;
            match uv {
                None => write_faces(out, tiling, &faces, first)?,
                Some(uv) => places = write_mapped_faces(out, tiling, uv, &faces, first, places)?,
            }
        }
        first += tiling.mesh().vertex_count() as u32;
    }
    writeln!(out, "g cuts")?;
    first = 1;
    for (tiling, _) in tilings {
        for arc in cuts_of(tiling) {
            write!(out, "l")?;
            for v in &tiling.arc_path[arc] {
                write!(out, " {}", v.0 + first)?;
            }
            writeln!(out)?;
        }
        first += tiling.mesh().vertex_count() as u32;
    }
    Ok(())
}

fn write_faces(out: &mut dyn Write, tiling: &Tiling, faces: &[FaceId], first: u32) -> io::Result<()> {
    for &f in faces {
        let [a, b, c] = tiling.mesh().face_vertices(f).map(|v| v.0 + first);
        writeln!(out, "f {a} {b} {c}")?;
    }
    Ok(())
}

/// Writes the faces of one tile with texture coordinates, each place of a vertex once; returns how many were written.
fn write_mapped_faces(
    out: &mut dyn Write,
    tiling: &Tiling,
    uv: &CornerMap<DVec2>,
    faces: &[FaceId],
    first: u32,
    mut places: u32,
) -> io::Result<u32> {
    let mut known: HashMap<(u32, [u64; 2]), u32> = HashMap::new();
    let mut corners: Vec<[u32; 2]> = Vec::with_capacity(3 * faces.len());
    for h in faces.iter().flat_map(|&f| tiling.mesh().face_half_edges(f)) {
        let (v, at) = (tiling.mesh().origin(h).0, uv[h]);
        let key = (v, [at.x.to_bits(), at.y.to_bits()]);
        let place = match known.get(&key) {
            Some(&place) => place,
            None => {
                places += 1;
                known.insert(key, places);
                writeln!(out, "vt {} {}", at.x, at.y)?;
                places
            }
        };
        corners.push([v + first, place]);
    }
    for face in corners.chunks_exact(3) {
        let [[a, i], [b, j], [c, k]] = [face[0], face[1], face[2]];
        writeln!(out, "f {a}/{i} {b}/{j} {c}/{k}")?;
    }
    Ok(places)
}

/// Arcs that are not the mesh's boundary.
pub(super) fn cuts_of(tiling: &Tiling) -> impl Iterator<Item = ArcId> + '_ {
    (0..tiling.arc_path.len() as u32).map(ArcId).filter(|&a| !tiling.is_border(a))
}

fn layout_of(tilings: &[&Tiling]) -> Value {
    let (mut nodes, mut arcs, mut tiles) = (Vec::new(), Vec::new(), Vec::new());
    let (mut first_vertex, mut first_face) = (0, 0);
    for tiling in tilings {
        let (first_node, first_arc) = (nodes.len(), arcs.len());
        let letters = tiling.letters();
        for &v in tiling.node_vertex.values() {
            let p = tiling.mesh().position(v);
            nodes.push(json!({ "vertex": v.0 + first_vertex, "position": [p.x, p.y, p.z] }));
        }
        for (arc, ends) in tiling.complex.arcs.iter() {
            let vertices: Vec<u32> = tiling.arc_path[arc].iter().map(|v| v.0 + first_vertex).collect();
            arcs.push(json!({
                "letter": quadloom_tiling::word::Side::forward(letters[arc]).to_string(),
                "nodes": ends.map(|n| n.0 as usize + first_node),
                "border": tiling.is_border(arc),
                "length": tiling.arc_length(arc),
                "vertices": vertices,
            }));
        }
        let faces = tiling.faces_by_tile();
        for ((tile, cell), faces) in tiling.complex.cells.iter().zip(&faces) {
            let side =
                |s: &quadloom_tiling::Side| json!({ "arc": s.arc.0 as usize + first_arc, "reversed": s.reversed });
            let boundaries: Vec<Vec<Value>> = cell.boundaries.iter().map(|b| b.iter().map(side).collect()).collect();
            tiles.push(json!({
                "genus": cell.genus,
                "boundaries": boundaries,
                "word": tiling.word(tile).map(|w| w.to_string()),
                "first_face": first_face,
                "faces": faces.len(),
            }));
            first_face += faces.len();
        }
        first_vertex += tiling.mesh().vertex_count() as u32;
    }
    json!({ "nodes": nodes, "arcs": arcs, "tiles": tiles })
}

/// New vertices with the face of their component's surface in which they lie.
fn new_vertices(parts: &[TiledPart]) -> Value {
    let mut all = Vec::new();
    let mut first = 0;
    for part in parts {
        let old = part.component.mesh.vertex_count();
        for v in (old..part.tiling.mesh().vertex_count()).map(VertexId::new) {
            let place = &part.tiling.surface.place[v];
            let face = part.component.face_of[place.face].0;
            all.push(json!({ "vertex": v.0 + first, "face": face, "weights": place.weights }));
        }
        first += part.tiling.mesh().vertex_count() as u32;
    }
    Value::Array(all)
}
