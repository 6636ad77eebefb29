//! Tiles as files.
//!
//! In: a [`TileResult`]. Out: files that are staged. Holds: vertices are those of the components one after the other,
//! in each the vertices of the component first, then new ones; faces are in the order of their tiles.

use super::{TileResult, TiledPart};
use crate::error::RemeshError;
use quadloom_io::Batch;
use quadloom_mesh::VertexId;
use quadloom_tiling::{ArcId, Tiling};
use serde_json::{Value, json};
use std::io::{self, Write};
use std::path::Path;

/// Adds tiles as OBJ: a group per tile, cuts as `l` lines.
///
/// # Errors     every error of writing
pub fn stage_tiles(files: &mut Batch, path: &Path, result: &TileResult) -> Result<(), RemeshError> {
    let tilings: Vec<&Tiling> = result.parts.iter().map(|p| &p.tiling).collect();
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
        let tilings: Vec<&Tiling> =
            result.parts.iter().filter_map(|p| p.steps.get(step).or(p.steps.last())).collect();
        files.stage(&folder.join(format!("step_{step:03}.obj")), |out| write_obj(out, &tilings))?;
        let layout = layout_of(&tilings);
        files.stage(&folder.join(format!("step_{step:03}.json")), |out| writeln!(out, "{layout}"))?;
    }
    Ok(())
}

/// Faces of a tiling by tile, then by number.
fn faces_by_tile(tiling: &Tiling) -> Vec<Vec<[u32; 3]>> {
    let mut faces = vec![Vec::new(); tiling.complex.cells.len()];
    for (f, tile) in tiling.face_tile.iter() {
        faces[tile.0 as usize].push(tiling.mesh().face_vertices(f).map(|v| v.0));
    }
    faces
}

fn write_obj(out: &mut dyn Write, tilings: &[&Tiling]) -> io::Result<()> {
    for tiling in tilings {
        for p in tiling.mesh().positions().values() {
            writeln!(out, "v {} {} {}", p.x, p.y, p.z)?;
        }
    }
    let (mut first, mut number) = (1, 0);
    for tiling in tilings {
        for faces in faces_by_tile(tiling) {
            writeln!(out, "g tile_{number}")?;
            number += 1;
            for [a, b, c] in faces {
                writeln!(out, "f {} {} {}", a + first, b + first, c + first)?;
            }
        }
        first += tiling.mesh().vertex_count() as u32;
    }
    writeln!(out, "g cuts")?;
    first = 1;
    for tiling in tilings {
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
        let faces = faces_by_tile(tiling);
        for ((tile, cell), faces) in tiling.complex.cells.iter().zip(&faces) {
            let side = |s: &quadloom_tiling::Side| json!({ "arc": s.arc.0 as usize + first_arc, "reversed": s.reversed });
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
