//! What is written to files: quads with their quality, the map, the cross field.
//!
//! In: a [`RemeshResult`]. Out: surfaces and field files. Holds: elements are in the order of the result.

use crate::error::RemeshError;
use crate::part::Solution;
use crate::remesh::RemeshResult;
use quadloom_extract::QuadQuality;
use quadloom_io::{Batch, Format, IoError, SurfaceOut, stage_rawfield, stage_rosy, stage_surface};
use quadloom_mesh::{CornerId, DVec3};
use quadloom_param::{GRID_UNIT, LatticePoint};
use std::path::{Path, PathBuf};

/// The quads; in formats that hold them with the integer-grid coordinates of their corners, and in formats for analysis
/// with the scaled Jacobian of every quad and the valence of every vertex.
pub fn quad_surface(result: &RemeshResult, format: Option<Format>) -> SurfaceOut {
    let quads = &result.quads;
    let mut surface = SurfaceOut::from(quads);
    if format.is_some_and(|f| matches!(f, Format::Vtu | Format::Ply)) {
        let jacobian = QuadQuality::of(quads).scaled_jacobian.into_vec();
        surface.face_attributes = vec![("scaled_jacobian".into(), jacobian)];
        surface.vertex_attributes =
            vec![("valence".into(), quads.vertices().map(|v| quads.valence(v) as f64).collect())];
    }
    // Nobody asked for them: where they find no place, nothing is missed.
    if format.is_none_or(|f| matches!(f, Format::Obj | Format::Ply)) {
        let grids = result.parts.iter().map(|p| p.solution.as_ref().map(grid_uv));
        surface.corner_uv = grids.collect::<Option<Vec<_>>>().map(|g| g.concat());
    }
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

/// Where the mesh goes that a written cross field lives on: `.obj` is added to the whole name, so that it clashes with no
/// other file by accident.
pub fn field_surface_path(field: &Path) -> PathBuf {
    let mut name = field.as_os_str().to_os_string();
    name.push(".obj");
    name.into()
}

/// Adds the cross field to the files to be written, and the mesh that it lives on ([`field_surface_path`]).
///
/// # Errors     every error of writing; an extension that is no field's
pub fn stage_field(files: &mut Batch, path: &Path, result: &RemeshResult) -> Result<(), RemeshError> {
    let mut surface = SurfaceOut::default();
    let mut crosses: Vec<[DVec3; 4]> = Vec::new();
    for solution in solutions(result) {
        let mesh = &solution.work.mesh;
        append(&mut surface, &SurfaceOut::from(mesh));
        crosses.extend(mesh.faces().map(|f| [0, 1, 2, 3].map(|d| solution.field.direction(mesh, f, d))));
    }
    stage_crosses(files, path, &crosses)?;
    stage_surface(files, field_surface_path(path), &surface, &Default::default())?;
    Ok(())
}

/// Extensions of cross fields that are written, for messages.
pub const FIELDS_WRITTEN: &str = ".rosy or .rawfield";

/// Adds crosses to the files to be written, as `.rosy` (one direction each) or `.rawfield` (all four).
///
/// # Errors     every error of writing; an extension that is no field's
pub fn stage_crosses(files: &mut Batch, path: &Path, crosses: &[[DVec3; 4]]) -> Result<(), RemeshError> {
    match path.extension().and_then(|e| e.to_str()) {
        Some("rosy") => stage_rosy(files, path, &crosses.iter().map(|c| c[0]).collect::<Vec<_>>())?,
        Some("rawfield") => stage_rawfield(files, path, crosses)?,
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
