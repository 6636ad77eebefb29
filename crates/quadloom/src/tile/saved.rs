//! Tilings that were saved: the mesh with its layout becomes a tiling again, and is checked.
//!
//! In: the soup of a mesh, a layout as [`super::stage_layout`] writes it. Out: [`Tiling`], and what contradicts its
//! definition. Holds: nothing of the layout is believed: what [`Tiling::check`] finds nothing wrong with is a tiling.

use crate::error::RemeshError;
use quadloom_io::{IoError, read_text};
use quadloom_mesh::{FaceMap, FaceSoup, TriMesh, VertexId};
use quadloom_tiling::tiling::unrefined;
use quadloom_tiling::{ArcId, ArcMap, Cell, CellComplex, NodeId, NodeMap, Side, TileId, TileMap, Tiling};
use serde::Deserialize;
use std::path::Path;
use std::sync::Arc;

#[derive(Deserialize)]
struct Layout {
    nodes: Vec<Node>,
    arcs: Vec<SavedArc>,
    tiles: Vec<SavedTile>,
}

#[derive(Deserialize)]
struct Node {
    vertex: u32,
}

#[derive(Deserialize)]
struct SavedArc {
    nodes: [u32; 2],
    vertices: Vec<u32>,
}

#[derive(Deserialize)]
struct SavedTile {
    genus: u32,
    boundaries: Vec<Vec<SavedSide>>,
    first_face: usize,
    faces: usize,
}

#[derive(Deserialize)]
struct SavedSide {
    arc: u32,
    reversed: bool,
}

/// The tiling that a mesh and its layout say.
///
/// # Errors     a layout that cannot be read, or names vertices and faces that the mesh does not have; a soup that is no
/// oriented manifold of triangles
/// # Cost       linear
pub fn read_tiling(soup: &FaceSoup, layout: &Path) -> Result<Tiling, RemeshError> {
    let wrong = |what: String| RemeshError::File(IoError::Mismatch { path: layout.to_path_buf(), what });
    let saved: Layout = serde_json::from_str(&read_text(layout)?).map_err(|e| wrong(format!("no layout: {e}")))?;
    // 1. The mesh, as it is.
    let triangles: Option<Vec<[u32; 3]>> = soup.faces.iter().map(|f| f.as_slice().try_into().ok()).collect();
    let triangles = triangles.ok_or_else(|| wrong("the mesh has faces that are no triangles".into()))?;
    let mesh = TriMesh::new(soup.positions.clone(), &triangles).map_err(|e| wrong(format!("the mesh is none: {e}")))?;
    // 2. Numbers in range.
    let vertices = mesh.vertex_count() as u32;
    let all = saved.nodes.iter().map(|n| n.vertex).chain(saved.arcs.iter().flat_map(|a| a.vertices.iter().copied()));
    if let Some(v) = all.max().filter(|&v| v >= vertices) {
        return Err(wrong(format!("it names vertex {v}, but there are only {vertices}")));
    }
    let mut face_tile = FaceMap::filled(mesh.face_count(), TileId(u32::MAX));
    for (tile, saved) in saved.tiles.iter().enumerate() {
        let end = saved.first_face.saturating_add(saved.faces);
        if end > mesh.face_count() {
            return Err(wrong(format!("tile {tile} has faces up to {end}, but there are only {}", mesh.face_count())));
        }
        (saved.first_face..end).for_each(|f| face_tile[quadloom_mesh::FaceId::new(f)] = TileId(tile as u32));
    }
    // 3. The tiling.
    let side = |s: &SavedSide| Side { arc: ArcId(s.arc), reversed: s.reversed };
    let cell = |t: &SavedTile| Cell {
        genus: t.genus,
        boundaries: t.boundaries.iter().map(|b| b.iter().map(side).collect()).collect(),
    };
    let path = |a: &SavedArc| a.vertices.iter().map(|&v| VertexId(v)).collect();
    Ok(Tiling {
        complex: CellComplex {
            nodes: saved.nodes.len(),
            arcs: ArcMap::from_vec(saved.arcs.iter().map(|a| a.nodes.map(NodeId)).collect()),
            cells: TileMap::from_vec(saved.tiles.iter().map(cell).collect()),
        },
        node_vertex: NodeMap::from_vec(saved.nodes.iter().map(|n| VertexId(n.vertex)).collect()),
        arc_path: ArcMap::from_vec(saved.arcs.iter().map(path).collect()),
        face_tile,
        surface: Arc::new(unrefined(&mesh)),
    })
}

/// Defects that are listed one by one.
const MOST_LISTED: usize = 20;

/// What contradicts the definition of a tiling in a mesh with its layout, the first defects and the number of the others;
/// empty if nothing does.
///
/// # Errors     as [`read_tiling`]
pub fn check_layout(soup: &FaceSoup, layout: &Path) -> Result<Vec<String>, RemeshError> {
    let defects = read_tiling(soup, layout)?.check();
    let more = defects.len().saturating_sub(MOST_LISTED);
    let listed = defects.iter().take(MOST_LISTED).map(ToString::to_string);
    Ok(listed.chain((more > 0).then(|| format!("and {more} more defects"))).collect())
}
