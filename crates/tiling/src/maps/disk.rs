//! The disk that is mapped: its border from corner to corner, its interior vertices.
//!
//! In: a mesh and its corners. Out: [`Disk`], or which condition they violate. Holds: the border starts at the first
//! corner and has the surface to its left; side k runs from corner k to the next.

use super::error::MapError;
use quadloom_mesh::topology::boundary_loops;
use quadloom_mesh::{Summary, TriMesh, VertexId, VertexMap};
use std::ops::RangeInclusive;

pub(super) const NONE: u32 = u32::MAX;

/// A mesh that is a disk, with its corners.
pub(super) struct Disk {
    /// Boundary vertices, counter-clockwise from corner 0 (from any one if there is no corner).
    pub border: Vec<VertexId>,
    /// Place of each corner in `border`, ascending from 0.
    pub corner_at: Vec<usize>,
    /// Place of each vertex in `border`; [`NONE`] inside.
    pub place: VertexMap<u32>,
    /// Interior vertices, ascending.
    pub interior: Vec<VertexId>,
    /// Number of each vertex in `interior`; [`NONE`] on the border.
    pub inner: VertexMap<u32>,
}

impl Disk {
    /// # Errors     no disk; a corner inside, repeated, or out of order
    pub fn new(mesh: &TriMesh, corners: &[VertexId]) -> Result<Self, MapError> {
        let mut border = border_of(mesh)?;
        let mut place = places(mesh, &border);
        if let Some(&first) = corners.first() {
            border.rotate_left(place_of(&place, first)?);
            place = places(mesh, &border);
        }
        let corner_at = corner_places(&place, corners)?;
        let interior: Vec<VertexId> = mesh.vertices().filter(|&v| place[v] == NONE).collect();
        let mut inner = VertexMap::filled(mesh.vertex_count(), NONE);
        interior.iter().enumerate().for_each(|(i, &v)| inner[v] = i as u32);
        Ok(Self { border, corner_at, place, interior, inner })
    }

    /// Number of sides: of corners, at least 1.
    pub fn sides(&self) -> usize {
        self.corner_at.len().max(1)
    }

    /// Places of a side's vertices, both ends included; the last may be one past the end of the border.
    pub fn side(&self, k: usize) -> RangeInclusive<usize> {
        let at = |k: usize| self.corner_at.get(k).copied();
        at(k).unwrap_or(0)..=at(k + 1).unwrap_or(self.border.len())
    }

    /// Vertex at a place, which may be one past the end.
    pub fn at(&self, place: usize) -> VertexId {
        self.border[place % self.border.len()]
    }
}

fn border_of(mesh: &TriMesh) -> Result<Vec<VertexId>, MapError> {
    let summary = Summary::of(mesh.connectivity());
    if (summary.components, summary.boundary_loops, summary.chi) != (1, 1, 1) {
        let (components, boundaries) = (summary.components, summary.boundary_loops);
        return Err(MapError::NotDisk { components, genus: summary.genus, boundaries });
    }
    Ok(boundary_loops(mesh.connectivity()).remove(0).into_iter().map(|h| mesh.origin(h)).collect())
}

fn places(mesh: &TriMesh, border: &[VertexId]) -> VertexMap<u32> {
    let mut place = VertexMap::filled(mesh.vertex_count(), NONE);
    border.iter().enumerate().for_each(|(i, &v)| place[v] = i as u32);
    place
}

fn place_of(place: &VertexMap<u32>, vertex: VertexId) -> Result<usize, MapError> {
    match place.get(vertex) {
        Some(&at) if at != NONE => Ok(at as usize),
        _ => Err(MapError::CornerNotOnBorder { vertex }),
    }
}

fn corner_places(place: &VertexMap<u32>, corners: &[VertexId]) -> Result<Vec<usize>, MapError> {
    let mut at: Vec<usize> = Vec::with_capacity(corners.len());
    for &vertex in corners {
        let next = place_of(place, vertex)?;
        if at.last().is_some_and(|&last| next <= last) {
            return Err(MapError::CornerOrder { vertex });
        }
        at.push(next);
    }
    Ok(at)
}
