//! A tile as a mesh of its own, and maps of all tiles of a tiling.
//!
//! In: a tiling. Out: [`TileMesh`]: the tile cut open, and how it lies in the tiling's mesh; [`TileMaps`]: texture
//! coordinates of every corner. Holds: faces keep their order; along a cut both tiles have the same parameters.
//! Source: [Favreau2009] §5.2.

use crate::error::TilingError;
use crate::ids::TileId;
use crate::maps::{MapError, MapMethod, MapOptions, MapReport, TileMap, edges_on_one_side, map_tile};
use crate::tiling::{RefinedSurface, Tiling};
use quadloom_mesh::refine::{VertexOrigin, split_edges};
use quadloom_mesh::{
    CornerMap, DVec2, EdgeId, EdgeMap, FaceId, FaceMap, FeatureGraph, HalfEdgeId, Id, Progress, SurfacePoint, TriMesh,
    VertexId, VertexMap,
};
use rayon::prelude::*;
use std::sync::Arc;

/// A tile cut open.
#[derive(Clone, Debug)]
pub struct TileMesh {
    /// The tile's faces, ascending; vertices on its boundaries once per corner.
    pub mesh: TriMesh,
    /// Face of the tiling's mesh for each face.
    pub face_of: FaceMap<FaceId>,
    /// Vertex of the tiling's mesh for each vertex.
    pub vertex_of: VertexMap<VertexId>,
    /// Its corners: where its sides start, boundary after boundary, in the order of the cell's sides.
    pub corners: Vec<VertexId>,
}

/// What happens where a tile has no map of the kind asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OnFailure {
    /// There is no result.
    #[default]
    Error,
    /// The tile gets a mean value map; its report says so.
    MeanValue,
}

/// Maps of all tiles.
#[derive(Clone, Debug)]
pub struct TileMaps {
    /// The tiling; edges with both ends on one side of a tile are split.
    pub tiling: Tiling,
    /// Texture coordinates of each corner of each face.
    pub uv: CornerMap<DVec2>,
    /// One per tile.
    pub reports: Vec<MapReport>,
    /// Tiles that have a mean value map instead of the one asked for, and why.
    pub instead: Vec<(TileId, MapError)>,
}

impl Tiling {
    /// A tile as a mesh of its own.
    ///
    /// # Errors     [`TilingError::Mesh`] if there are more elements than ids
    /// # Cost       linear in the whole mesh
    pub fn tile_mesh(&self, tile: TileId) -> Result<TileMesh, TilingError> {
        let faces: Vec<FaceId> = self.face_tile.iter().filter(|(_, t)| **t == tile).map(|(f, _)| f).collect();
        self.open_tile(tile, &faces, &self.cut_edges())
    }

    /// A tile from its faces, ascending, and the edges that are cut.
    fn open_tile(&self, tile: TileId, faces: &[FaceId], cut: &EdgeMap<bool>) -> Result<TileMesh, TilingError> {
        let mesh = self.mesh();
        let local = |f: FaceId| faces.binary_search(&f).ok();
        let line = |h: HalfEdgeId| mesh.twin(h).is_none() || cut[mesh.edge(h)];
        let (mut number, mut positions, mut vertex_of) = (vec![[u32::MAX; 3]; faces.len()], Vec::new(), Vec::new());
        for (k, &f) in faces.iter().enumerate() {
            for (corner, h) in mesh.face_half_edges(f).into_iter().enumerate() {
                if number[k][corner] != u32::MAX {
                    continue;
                }
                // All corners of the sector: clockwise to its border, then counter-clockwise.
                let id = positions.len() as u32;
                positions.push(mesh.position(mesh.origin(h)));
                vertex_of.push(mesh.origin(h));
                let mut start = h;
                while !line(start)
                    && let Some(next) = mesh.rotate_cw(start)
                    && next != h
                {
                    start = next;
                }
                let mut at = start;
                loop {
                    let face = mesh.face(at);
                    let place = (at.0 - mesh.first_half_edge(face).0) as usize;
                    if let Some(k) = local(face) {
                        number[k][place] = id;
                    }
                    if line(mesh.prev(at)) {
                        break;
                    }
                    match mesh.rotate_ccw(at) {
                        Some(next) if next != start => at = next,
                        _ => break,
                    }
                }
            }
        }
        let open = TriMesh::new(positions, &number)?;
        let sides = self.complex.cells[tile].boundaries.iter().flatten();
        let corner = |h: HalfEdgeId| {
            let face = mesh.face(h);
            local(face).map(|k| VertexId(number[k][(h.0 - mesh.first_half_edge(face).0) as usize]))
        };
        let corners: Option<Vec<VertexId>> =
            sides.map(|&s| self.side_half_edges(s).first().and_then(|&h| corner(h))).collect();
        let corners = corners.ok_or(TilingError::Fault { what: "a side has no faces" })?;
        let face_of = FaceMap::from_vec(faces.to_vec());
        Ok(TileMesh { mesh: open, face_of, vertex_of: VertexMap::from_vec(vertex_of), corners })
    }

    /// Faces of every tile, ascending.
    pub fn faces_by_tile(&self) -> Vec<Vec<FaceId>> {
        let mut faces = vec![Vec::new(); self.complex.cells.len()];
        self.face_tile.iter().for_each(|(f, t)| faces[t.index()].push(f));
        faces
    }

    /// The same tiling on a mesh whose given edges, none of them on an arc, are split in the middle.
    ///
    /// # Input      parent: the mesh from which the surface was refined
    /// # Errors     [`TilingError::Mesh`] if there are more elements than ids
    pub fn with_split(&self, parent: &TriMesh, edges: &[EdgeId]) -> Result<Self, TilingError> {
        let old = &self.surface;
        let halves: Vec<(EdgeId, f64)> = edges.iter().map(|&e| (e, 0.5)).collect();
        let kinds = EdgeMap::filled(old.mesh.edge_count(), None);
        let (no_features, _) = FeatureGraph::from_kinds(&old.mesh, kinds, &Default::default());
        let refined = split_edges(&old.mesh, &no_features, &halves)?;
        let place = VertexMap::from_fn(refined.mesh.vertex_count(), |v| match refined.vertex_origin[v] {
            VertexOrigin::Vertex(v) => old.place[v],
            VertexOrigin::Edge(e, t) => {
                let face = old.parent_face[old.mesh.edge_faces(e).0];
                let [a, b] = old.mesh.ends(e).map(|v| weights_in(parent, &old.place[v], face));
                SurfacePoint { face, weights: std::array::from_fn(|k| a[k] + (b[k] - a[k]) * t) }
            }
            VertexOrigin::Face(f) => SurfacePoint { face: old.parent_face[f], weights: [1.0 / 3.0; 3] },
        });
        let cut_before = self.cut_edges();
        let mut cut = EdgeMap::filled(refined.mesh.edge_count(), false);
        for e in old.mesh.edges().filter(|&e| cut_before[e]) {
            let [a, b] = old.mesh.ends(e);
            let same = refined.mesh.find_edge(a, b).ok_or(TilingError::Fault { what: "a cut edge was split" })?;
            cut[same] = true;
        }
        let parent_face = FaceMap::from_fn(refined.mesh.face_count(), |f| old.parent_face[refined.parent_face[f]]);
        let surface = Arc::new(RefinedSurface { mesh: refined.mesh, parent_face, place });
        Ok(Self::from_cut(surface, &cut, self.node_vertex.values()))
    }
}

/// Weights in a face of a mesh of a point that lies on it.
fn weights_in(mesh: &TriMesh, place: &SurfacePoint, face: FaceId) -> [f64; 3] {
    if place.face == face {
        return place.weights;
    }
    let own = mesh.face_vertices(place.face);
    mesh.face_vertices(face).map(|v| own.iter().position(|&w| w == v).map_or(0.0, |k| place.weights[k]))
}

/// Maps every tile, which must be a disk, to the plane.
///
/// # Input      parent: the mesh from which the tiling's surface was refined
/// # Errors     [`TilingError::NotDisks`]; [`TilingError::Map`] names the first tile that has no map, of any kind if
/// failures are made up for
/// # Cost       that of [`map_tile`], tiles in parallel
/// # Guarantees the same bytes for any number of threads; both sides of a cut have the same parameters along it where
/// the border is fixed
pub fn map_tiles(
    tiling: &Tiling,
    parent: &TriMesh,
    method: MapMethod,
    options: &MapOptions,
    on_failure: OnFailure,
    progress: &Progress,
) -> Result<TileMaps, TilingError> {
    tiling.must_be_disks()?;
    let failed = |tile: usize, error| match error {
        MapError::Cancelled(stop) => TilingError::Cancelled(stop),
        error => TilingError::Map { tile, error },
    };
    // 1. Edges that a straight side would flatten.
    let open = |tiling: &Tiling| -> Result<Vec<TileMesh>, TilingError> {
        let (faces, cut) = (tiling.faces_by_tile(), tiling.cut_edges());
        faces.par_iter().enumerate().map(|(tile, faces)| tiling.open_tile(TileId::new(tile), faces, &cut)).collect()
    };
    let mut tiles = open(tiling)?;
    let mut tiling = tiling.clone();
    let mut split: Vec<EdgeId> = Vec::new();
    for (number, tile) in tiles.iter().enumerate() {
        for e in edges_on_one_side(&tile.mesh, &tile.corners).map_err(|e| failed(number, e))? {
            let h = tile.mesh.half_edge(e);
            let [a, b] = [tile.mesh.origin(h), tile.mesh.target(h)].map(|v| tile.vertex_of[v]);
            split.extend(tiling.mesh().find_edge(a, b));
        }
    }
    if !split.is_empty() {
        tiling = tiling.with_split(parent, &split)?;
        tiles = open(&tiling)?;
    }
    // 2. The maps.
    let mapped = |number: usize, tile: &TileMesh, method: MapMethod| {
        map_tile(&tile.mesh, &tile.corners, method, options, progress).map_err(|e| (number, e))
    };
    let maps: Vec<(TileMap, Option<(TileId, MapError)>)> = tiles
        .par_iter()
        .enumerate()
        .map(|(number, tile)| match mapped(number, tile, method) {
            Ok(map) => Ok((map, None)),
            Err((_, error)) if on_failure == OnFailure::MeanValue && !matches!(error, MapError::Cancelled(_)) => {
                let map = mapped(number, tile, MapMethod::MeanValue)?;
                Ok((map, Some((TileId::new(number), error))))
            }
            Err(error) => Err(error),
        })
        .collect::<Result<_, _>>()
        .map_err(|(number, error)| failed(number, error))?;
    // 3. By corner.
    let mut uv = CornerMap::filled(tiling.mesh().half_edge_count(), DVec2::ZERO);
    for (tile, (map, _)) in tiles.iter().zip(&maps) {
        for (f, &face) in tile.face_of.iter() {
            for (own, whole) in tile.mesh.face_half_edges(f).into_iter().zip(tiling.mesh().face_half_edges(face)) {
                uv[whole] = map.uv[tile.mesh.origin(own)];
            }
        }
    }
    let (maps, instead): (Vec<TileMap>, Vec<_>) = maps.into_iter().unzip();
    let reports = maps.into_iter().map(|m| m.report).collect();
    Ok(TileMaps { tiling, uv, reports, instead: instead.into_iter().flatten().collect() })
}
