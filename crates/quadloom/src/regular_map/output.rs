//! A realised map as files.
//!
//! In: a [`Realized`]. Out: surfaces that are staged. Holds: STL, OBJ, OFF and VTU hold one closed surface; GLB and PLY
//! repeat vertices where colours meet, so that colours do not run into each other.

use super::{Realized, Tubed};
use crate::error::RemeshError;
use quadloom_io::{Batch, Format, SurfaceOut, WriteOptions, WriteWarning, stage_surface};
use quadloom_mesh::{FaceId, TriMesh};
use quadloom_tubification::realize::RealizeError;
use std::collections::HashMap;
use std::io::{self, Write};
use std::path::Path;

/// Adds the surface in the format of the path's extension.
///
/// # Errors     every error of writing
pub fn stage_realized(files: &mut Batch, path: &Path, result: &Realized) -> Result<Vec<WriteWarning>, RemeshError> {
    let surface = match Format::from_path(path) {
        Some(Format::Obj) => {
            files.stage(path, |out| write_obj(out, result))?;
            return Ok(Vec::new());
        }
        Some(Format::Glb) => coloured(result, linear),
        Some(Format::Ply) => coloured(result, |c| f32::from(c) / 255.0),
        Some(Format::Vtu) => SurfaceOut { face_attributes: vec![("face".into(), numbers(result))], ..plain(result) },
        _ => plain(result),
    };
    Ok(stage_surface(files, path, &surface, &WriteOptions::default())?)
}

/// Adds tubes without a map on them: quads, or triangles where the format has no quads.
///
/// # Errors     every error of writing
pub fn stage_tubes(files: &mut Batch, path: &Path, result: &Tubed) -> Result<Vec<WriteWarning>, RemeshError> {
    let surface = &result.tubes.surface;
    let faces = if Format::from_path(path).is_some_and(Format::holds_quads) {
        surface.mesh().to_faces().iter().map(|f| f.to_vec()).collect()
    } else {
        // Those that were looked at for self-intersections.
        triangles(&surface.triangles().map_err(RealizeError::Tubes)?)
    };
    Ok(stage_surface(files, path, &SurfaceOut::new(result.positions.clone(), faces), &WriteOptions::default())?)
}

/// One closed surface.
fn plain(result: &Realized) -> SurfaceOut {
    SurfaceOut::new(result.positions().to_vec(), triangles(&result.realization.drawing.mesh))
}

/// The number of the map's face on each triangle, −1 on edges.
fn numbers(result: &Realized) -> Vec<f64> {
    let is_edge = result.realization.drawing.is_edge.values();
    let number = |(&face, &edge): (&u32, &bool)| if edge { -1.0 } else { f64::from(face) };
    result.face.iter().zip(is_edge).map(number).collect()
}

/// A channel of sRGB as an amount of light, which glTF's colours are.
fn linear(channel: u8) -> f32 {
    let c = f64::from(channel) / 255.0;
    let light = if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) };
    light as f32
}

/// Vertices once for each colour that meets there.
fn coloured(result: &Realized, channel: fn(u8) -> f32) -> SurfaceOut {
    let mesh = &result.realization.drawing.mesh;
    let mut number = HashMap::new();
    let (mut positions, mut colors, mut faces) = (Vec::new(), Vec::new(), Vec::with_capacity(mesh.face_count()));
    for f in mesh.faces() {
        let color = result.color(f);
        let corner = |v: quadloom_mesh::VertexId| {
            *number.entry((v, color)).or_insert_with(|| {
                positions.push(result.positions()[v.index()]);
                colors.push(color.map(channel));
                positions.len() as u32 - 1
            })
        };
        faces.push(mesh.face_vertices(f).map(corner).to_vec());
    }
    SurfaceOut { vertex_colors: Some(colors), ..SurfaceOut::new(positions, faces) }
}

fn triangles(mesh: &TriMesh) -> Vec<Vec<u32>> {
    mesh.faces().map(|f| mesh.face_vertices(f).map(|v| v.0).to_vec()).collect()
}

/// A group for each face of the map and one for its edges.
fn write_obj(out: &mut dyn Write, result: &Realized) -> io::Result<()> {
    let mesh = &result.realization.drawing.mesh;
    for p in result.positions() {
        writeln!(out, "v {} {} {}", p.x, p.y, p.z)?;
    }
    let group = |f: FaceId| if result.realization.drawing.is_edge[f] { u32::MAX } else { result.face[f.index()] };
    let mut faces: Vec<FaceId> = mesh.faces().collect();
    faces.sort_by_key(|&f| (group(f), f));
    let mut last = None;
    for f in faces {
        let here = group(f);
        if last.replace(here) != Some(here) {
            match here {
                u32::MAX => writeln!(out, "g edges")?,
                face => writeln!(out, "g face_{face}")?,
            }
        }
        let [a, b, c] = mesh.face_vertices(f).map(|v| v.0 + 1);
        writeln!(out, "f {a} {b} {c}")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_of_the_light_is_at_188() {
        assert_eq!([linear(0), linear(255)], [0.0, 1.0]);
        assert!((linear(188) - 0.5).abs() < 5e-3);
    }
}
