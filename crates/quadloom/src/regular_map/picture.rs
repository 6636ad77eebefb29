//! The page of a realised map.
//!
//! In: a [`Realized`]. Out: a [`MapScene`]: the surface, and the flat picture in the same colours and numbers.

use super::{EDGE_COLOR, Realized};
use crate::error::RemeshError;
use crate::view::MapScene;
use quadloom_regular_maps::tiling::{Centre, FlatTiling, PictureOptions, svg};

/// What the viewer's page shows. The flat picture has no colours where tubes have them.
///
/// # Errors     those of [`FlatTiling::layout`]
pub fn map_scene(result: &Realized) -> Result<MapScene, RemeshError> {
    let drawing = &result.realization.drawing;
    let tiling = FlatTiling::layout(&result.shown, Centre::Face)?;
    let options = PictureOptions { colouring: result.colouring.clone(), ..PictureOptions::default() };
    Ok(MapScene {
        title: result.report.title(),
        facts: result.report.facts(),
        positions: result.positions.clone(),
        triangles: drawing.mesh.to_faces(),
        face: result.face.clone(),
        is_edge: drawing.is_edge.values().to_vec(),
        class: result.class.clone(),
        palette: result.palette.clone(),
        edge_color: EDGE_COLOR,
        flat: svg(&tiling, &options),
    })
}
