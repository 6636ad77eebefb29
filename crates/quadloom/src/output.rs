//! What is written to files: quads with their quality, the map, the cross field.
//!
//! In: a [`RemeshResult`]. Out: surfaces and field files. Holds: elements are in the order of the result.

use crate::error::RemeshError;
use crate::part::Solution;
use crate::remesh::RemeshResult;
use quadloom_extract::QuadQuality;
use quadloom_io::{Format, IoError, SurfaceOut, write_rawfield, write_rosy, write_surface};
use quadloom_mesh::{CornerId, DVec3};
use quadloom_param::{GRID_UNIT, LatticePoint};
use std::path::Path;

/// The quads with the integer-grid coordinates of their corners, and, in formats for analysis, the scaled Jacobian of
/// every quad and the valence of every vertex.
pub fn quad_surface(result: &RemeshResult, format: Option<Format>) -> SurfaceOut {
    let quads = &result.quads;
    let mut surface = SurfaceOut::from(quads);
    if format.is_some_and(|f| matches!(f, Format::Vtu | Format::Ply)) {
        let jacobian = QuadQuality::of(quads).scaled_jacobian.into_vec();
        surface.face_attributes = vec![("scaled_jacobian".into(), jacobian)];
        surface.vertex_attributes =
            vec![("valence".into(), quads.vertices().map(|v| quads.valence(v) as f64).collect())];
    }
    let grid: Option<Vec<Vec<[f64; 2]>>> =
        result.parts.iter().map(|p| p.solution.as_ref().map(grid_uv)).collect::<Option<Vec<_>>>().map(|g| g.concat());
    surface.corner_uv = grid;
    surface
}

fn grid_uv(solution: &Solution) -> Vec<Vec<[f64; 2]>> {
    let squares = solution.extraction.grid.values().iter();
    squares.map(|square| square.map_or_else(Vec::new, |s| s.map(|p| p.map(f64::from)).to_vec())).collect()
}

/// The work meshes with the integer-grid map as texture coordinates, grid units.
pub fn map_surface(result: &RemeshResult) -> SurfaceOut {
    let mut surface = SurfaceOut::default();
    let mut uv = Vec::new();
    for solution in solutions(result) {
        let (mesh, map) = (&solution.work.mesh, &solution.map.parametrization.map);
        append(&mut surface, &SurfaceOut::from(mesh));
        let point = |h: CornerId| grid_point(map.uv[h]);
        uv.extend(mesh.faces().map(|f| mesh.face_half_edges(f).map(point).to_vec()));
    }
    surface.corner_uv = Some(uv);
    surface
}

fn grid_point(p: LatticePoint) -> [f64; 2] {
    p.map(|x| x as f64 / GRID_UNIT as f64)
}

/// Writes the cross field, and beside it, as .obj, the mesh that it lives on.
///
/// # Errors     every error of writing; an extension that is no field's
pub fn write_field(path: &Path, result: &RemeshResult) -> Result<(), RemeshError> {
    let mut surface = SurfaceOut::default();
    let mut crosses: Vec<[DVec3; 4]> = Vec::new();
    for solution in solutions(result) {
        let mesh = &solution.work.mesh;
        append(&mut surface, &SurfaceOut::from(mesh));
        crosses.extend(mesh.faces().map(|f| [0, 1, 2, 3].map(|d| solution.field.direction(mesh, f, d))));
    }
    write_crosses(path, &crosses)?;
    write_surface(path.with_extension("obj"), &surface, &Default::default())?;
    Ok(())
}

/// Extensions of cross fields that are written, for messages.
pub const FIELDS_WRITTEN: &str = ".rosy or .rawfield";

/// Writes crosses as `.rosy` (one direction each) or `.rawfield` (all four).
///
/// # Errors     every error of writing; an extension that is no field's
pub fn write_crosses(path: &Path, crosses: &[[DVec3; 4]]) -> Result<(), RemeshError> {
    match path.extension().and_then(|e| e.to_str()) {
        Some("rosy") => write_rosy(path, &crosses.iter().map(|c| c[0]).collect::<Vec<_>>())?,
        Some("rawfield") => write_rawfield(path, crosses)?,
        _ => return Err(IoError::UnknownOutput { path: path.to_path_buf(), expected: FIELDS_WRITTEN }.into()),
    }
    Ok(())
}

fn solutions(result: &RemeshResult) -> impl Iterator<Item = &Solution> {
    result.parts.iter().filter_map(|p| p.solution.as_ref())
}

fn append(all: &mut SurfaceOut, one: &SurfaceOut) {
    let offset = all.positions.len() as u32;
    all.positions.extend_from_slice(&one.positions);
    all.faces.extend(one.faces.iter().map(|f| f.iter().map(|v| v + offset).collect()));
}
